"""The names of a text: definitions, references, outline, completion and hover.

Completion offers the language's words and the names of the text and its folder. Hover says what a line does and what a
name means, in a few lines of Markdown.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from olp.core.diagnostic import OlpError
from olp.core.source import Source, file_name, load
from olp.core.units import deg, mm
from olp.ir.program import Program, Routine
from olp.languages.tokens import TokenKind, Word, Words
from olp.languages.vendor import find_vendor, part_of
from olp.robots.geometry import angles_from_rotation, rotation_from_quaternion
from olp.runtime.folder import files_by_name_record, files_by_stem, read_cached
from olp.runtime.plan import StepKind
from olp.servers.language.document import vendor_of
from olp.servers.language.service import Analysis, ProgramService

if TYPE_CHECKING:
    from olp.timing.result import Timing


_MOST_LISTED = 2000  # names of a kind in an outline: nobody reads more


class OutlineSymbol(NamedTuple):
    """An entry of the outline: a routine with what it defines. Lines `line` to `last`."""

    name: str
    kind: TokenKind
    line: int
    column: int
    end_column: int
    last: int
    children: tuple[OutlineSymbol, ...] = ()


def names(analysis: Analysis) -> list[PlacedName]:
    """All names of the text."""
    vendor = analysis.program.vendor if analysis.program is not None else vendor_of(analysis.source, "") or ""
    return names_in(analysis.source, analysis.program, vendor)


def name_at(found: list[PlacedName], line: int, column: int) -> PlacedName | None:
    """The name at a place, or the one that ends there."""
    return next((n for n in found if n.line == line and n.column <= column <= n.end_column), None)


def definitions(service: ProgramService, analysis: Analysis, line: int, column: int) -> list[PlacedName]:
    """Definitions of the name at a place, in this text or another file."""
    found = names(analysis)
    asked = name_at(found, line, column)
    if asked is None:
        return []
    here = [name for name in found if name.defines and name.same_as(asked)]
    if here:
        return here
    if asked.kind is TokenKind.ROUTINE:
        called = _file_of(analysis, asked)
        if called:
            return called
    others = (n for names_there in _elsewhere(service, analysis) for n in names_there)
    there = [name for name in others if name.defines and name.same_as(asked)][:1]
    if there or asked.kind is not TokenKind.VARIABLE:
        return there
    # What no language declares comes into being where it is named first.
    return [next(name for name in found if name.same_as(asked))]


def references(
    service: ProgramService, analysis: Analysis, line: int, column: int, definition: bool = True
) -> list[PlacedName]:
    """Where the name at a place is used, in this text, in open ones and in the files that it needs."""
    found = names(analysis)
    asked = name_at(found, line, column)
    if asked is None:
        return []
    result = [name for name in found if name.same_as(asked)]
    if not asked.scope:
        for names_there in _elsewhere(service, analysis):
            result.extend(name for name in names_there if name.same_as(asked))
    return [name for name in result if definition or not name.defines]


def outline(analysis: Analysis) -> list[OutlineSymbol]:
    """The routines of the text, each with its labels, points and variables."""
    found = [name for name in names(analysis) if name.defines]
    program = analysis.program
    routines = () if program is None else program.routines
    result: list[OutlineSymbol] = []
    taken: set[int] = set()
    for routine in routines:
        last = routine.last_line or len(analysis.source.lines)
        inside = [n for n in found if routine.line <= n.line <= last and n.kind is not TokenKind.ROUTINE]
        taken.update(map(id, inside))
        head = next(
            (n for n in found if n.kind is TokenKind.ROUTINE and routine.line <= n.line <= last), None
        )
        place = (head.line, head.column, head.end_column) if head else (routine.line, 1, 1)
        children = _entries(analysis, inside)
        name = routine.name or Path(analysis.path).stem
        result.append(OutlineSymbol(name, TokenKind.ROUTINE, *place, max(last, place[0]), tuple(children)))
    rest = [n for n in found if id(n) not in taken and (n.kind is not TokenKind.ROUTINE or not routines)]
    return [*result, *_entries(analysis, rest)]


def _entries(analysis: Analysis, found: list[PlacedName]) -> Iterator[OutlineSymbol]:
    counts: dict[TokenKind, int] = {}
    for name in found:
        counts[name.kind] = counts.get(name.kind, 0) + 1
        if counts[name.kind] <= _MOST_LISTED:
            text = analysis.source.line(name.line)[name.column - 1 : name.end_column - 1]
            yield OutlineSymbol(text, name.kind, name.line, name.column, name.end_column, name.line)


def _file_of(analysis: Analysis, asked: PlacedName) -> list[PlacedName]:
    """The file with the name of a routine, or whose head names it."""
    path = Path(analysis.path)
    if not path.is_absolute() or not path.suffix:
        return []
    key = asked.key.upper()
    found = files_by_stem(path.parent, path.suffix).get(key) or files_by_name_record(
        path.parent, path.suffix
    ).get(key)
    if found is None or found == path:
        return []
    there = _names_of_file(str(found))
    heads = [name for name in there if name.kind is TokenKind.ROUTINE and name.defines]
    return [n for n in heads if n.key.upper() == key] or heads[:1]


def _elsewhere(service: ProgramService, analysis: Analysis) -> Iterator[list[PlacedName]]:
    """The names of the files that belong to the text: those it needs, and open ones beside it."""
    files = dict.fromkeys(analysis.needs)
    folder = Path(analysis.path).parent
    files.update(dict.fromkeys(path for path in service.documents if Path(path).parent == folder))
    files.pop(analysis.path, None)
    for file in files:
        if file in service.documents:
            other = service.analyses.get(file)
            if other is not None:
                yield names(other)
        else:
            yield _names_of_file(file)


def _names_of_file(path: str) -> list[PlacedName]:
    program: Program | None = None
    try:
        source: Source = load(path)
        vendor = vendor_of(source, "") or ""
        if words_of(vendor) is None:
            return []
        # A list (KRL .dat) is no program: every routine sees what stands in it.
        if path.lower().endswith(find_vendor(vendor).suffixes):
            program = read_cached(Path(path))
    except (OSError, OlpError):
        return []
    return names_in(source, program, vendor)


# --- Names ---
# Where a name comes into being and where it is used: in the text itself and in the files that belong to it.


class PlacedName(NamedTuple):
    """A name at a place. `scope`: the routine that it is known in, "" where every one knows it."""

    file: str
    line: int
    column: int
    end_column: int
    kind: TokenKind
    key: str
    scope: str
    defines: bool

    def same_as(self, other: PlacedName) -> bool:
        """Whether both mean one thing. What is known in one routine only is another thing in another file."""
        alike = self.key == other.key and self.scope == other.scope
        return alike and (not self.scope or self.file == other.file)


def words_of(vendor: str) -> Words | None:
    """How a language spells its names, None where olp does not know."""
    words: Words | None = part_of(vendor, "tokens")
    return words


def names_in(source: Source, program: Program | None, vendor: str) -> list[PlacedName]:
    """All names of a text, in order."""
    words = words_of(vendor)
    if words is None:
        return []
    routines = () if program is None or words.one_scope else program.routines
    rows: list[tuple[int, str, Word]] = []
    known: dict[tuple[str, str], TokenKind] = {}  # scope and key of what a line declares
    for number, text in enumerate(source.lines, 1):
        found = list(words.words(text))
        scope = scope_at(routines, number) if found else ""
        for word in found:
            rows.append((number, scope, word))
            if word.defines and word.kind is not None:
                known.setdefault((_home(words, word, scope), word.key), word.kind)
    names: list[PlacedName] = []
    defined: set[tuple[str, str]] = set()
    for number, scope, word in rows:
        home = _home(words, word, scope)
        if words.identifier and (home, word.key) not in known:
            home = ""
        kind = known.get((home, word.key), word.kind or TokenKind.VARIABLE)
        # A variable that a language does not declare comes into being where it is assigned first.
        defines = word.defines and not (words.first_counts and (home, word.key) in defined)
        if defines:
            defined.add((home, word.key))
        place = (source.path, number, word.column, word.end_column)
        names.append(PlacedName(*place, word.kind or kind, word.key, home, defines))
    return names


def _home(words: Words, word: Word, scope: str) -> str:
    """The routine that a word may belong to: marked names say so themselves, others do unless they are routines."""
    if word.local:
        return scope
    return scope if words.identifier and word.plain else ""


def scope_at(routines: Iterable[Routine], line: int) -> str:
    """The innermost routine that a line belongs to, "" for none."""
    found, begin = "", 0
    for routine in routines:
        if begin < routine.line <= line <= (routine.last_line or line):
            found, begin = routine.name or f"line {routine.line}", routine.line
    return found


_MOST = 500  # names of a kind: a list of 10,000 points helps nobody
_TOKEN = re.compile(r"[^\s,;(){}=\[]*$")


class Proposal(NamedTuple):
    """`text` in place of what stands between `column` and the cursor. `kind` None: a word of the language."""

    text: str
    column: int
    kind: TokenKind | None
    detail: str = ""


def completion(analysis: Analysis, line: str, number: int, column: int) -> list[Proposal]:
    """Proposals for a cursor before `column` of `line` (number `number`), which may be newer than the analysis."""
    before = line[: column - 1]
    match = _TOKEN.search(before)
    start = match.start() + 1 if match else column
    typed = before[start - 1 :].casefold()
    vendor = analysis.program.vendor if analysis.program is not None else vendor_of(analysis.source, "") or ""
    words = words_of(vendor)
    if words is None:
        return []
    found = [Proposal(word, start, None) for word in sorted(words.vocabulary())]
    found += _names(analysis, number, start)
    found += _jobs(analysis, vendor, before[: start - 1], start, typed)
    return [one for one in found if one.text.casefold().startswith(typed)]


def _names(analysis: Analysis, number: int, start: int) -> Iterator[Proposal]:
    """Each name of the text once, spelt as where it comes into being, else as where it stands first."""
    spelt: dict[tuple[str, str], Proposal] = {}
    counts: dict[TokenKind, int] = {}
    for name in sorted(names(analysis), key=lambda one: not one.defines):
        key = (name.scope, name.key)
        if key in spelt or name.line == number or counts.get(name.kind, 0) >= _MOST:
            continue
        counts[name.kind] = counts.get(name.kind, 0) + 1
        text = analysis.source.line(name.line)
        word = text[name.column - 1 : name.end_column - 1]
        if not word[:1].isdigit():  # the number of a frame alone
            spelt[key] = Proposal(word, start, name.kind, text.strip()[:80])
    yield from spelt.values()


def _jobs(analysis: Analysis, vendor: str, before: str, start: int, typed: str) -> Iterator[Proposal]:
    """The other programs of the folder, where one can be called."""
    path = Path(analysis.path)
    if not path.is_absolute() or not path.parent.is_dir():
        return
    own = find_vendor(vendor)
    mark = own.call_mark
    if mark and not (typed.startswith(mark.casefold()) or re.search(own.call_words, before)):
        return
    files = files_by_stem(path.parent, path.suffix)
    heads = files_by_name_record(path.parent, path.suffix) if mark else {}
    for name in sorted({*files, *heads} - {path.stem.upper()}):
        yield Proposal(f"{mark}{name}", start, TokenKind.ROUTINE, f"{name} in this folder")


_MOST_RUNS = 5  # executions that are told one by one


def hover(service: ProgramService, analysis: Analysis, line: int, column: int) -> str:
    """Markdown for a place; empty if there is nothing to show."""
    parts = [*_line(analysis, line)]
    asked = name_at(names(analysis), line, column)
    if asked is not None:
        parts += _name(service, analysis, asked, line, column)
    return "\n\n".join(parts)


def _line(analysis: Analysis, line: int) -> Iterator[str]:
    timing, steps = analysis.timing, analysis.steps(line)
    if timing is None or not steps:
        return
    seconds = timing.duration_s[steps]
    whole = float(seconds.sum())
    often = f" in {len(steps)} executions" if len(steps) > 1 else ""
    yield f"**{_seconds(whole)}**{often}" if not math.isnan(whole) else "**no time**: see the findings"
    last = steps[min(len(steps), _MOST_RUNS) - 1]
    for number, step in enumerate(steps[:_MOST_RUNS], 1):
        told = _move(timing, step) if timing.plan.kind[step] == StepKind.MOVE else ""
        head = f"{number}. " if len(steps) > 1 else "- "
        yield f"{head}{_interval(timing, step)}{told}".rstrip()
    if len(steps) > _MOST_RUNS:
        yield f"… and {len(steps) - _MOST_RUNS} more"
    if timing.plan.kind[last] == StepKind.MOVE:
        yield from _pose(timing, steps[-1])


def _interval(timing: Timing, step: int) -> str:
    text = _seconds(float(timing.duration_s[step]))
    if timing.interval is not None:
        low, high = float(timing.interval.low[step]), float(timing.interval.high[step])
        if not math.isnan(low):
            text += f" (95 %: {low:.3f} to {high:.3f})"
    return f"{text}, ends at {float(timing.end_s[step]):.3f} s"


def _move(timing: Timing, step: int) -> str:
    """Way, turn, speeds, acceleration and limit."""
    columns = (
        ("{:.1f} mm", timing.distance_mm),
        ("turns {:.1f}°", timing.angle_deg),
        ("programmed {:g} %", timing.speed_pct),
        ("programmed {:.1f} mm/s", timing.speed_mm_s),
        ("programmed {:g} °/s", timing.speed_deg_s),
        ("reached {:.1f} mm/s", timing.reached_mm_s),
        ("{:.0f} mm/s²", timing.accel_mm_s2),
    )
    found = [text.format(float(of[step])) for text, of in columns if not math.isnan(float(of[step]))]
    if timing.limited_by[step]:
        found.append(f"limited by {timing.limited_by[step]}")
    return ": " + ", ".join(found)


def _pose(timing: Timing, step: int) -> Iterator[str]:
    """Where the move ends: the tool in the base, and the axes."""
    plan = timing.plan
    row = int(plan.row[step])
    target, mechanism = int(plan.moves.target[row]), int(plan.moves.mechanism[row])
    place, turn = plan.positions.position[target], plan.positions.quaternion[target]
    if not np.isnan(place).any():
        x, y, z = place / mm
        rx, ry, rz = angles_from_rotation(rotation_from_quaternion(turn)) / deg
        yield (
            f"ends at X {x:.3f} Y {y:.3f} Z {z:.3f} mm, Rx {rx:.4f} Ry {ry:.4f} Rz {rz:.4f}° (tool in the base)"
        )
    robot = plan.robots[mechanism] if mechanism < len(plan.robots) else None
    if robot is None:
        return
    axes = plan.positions.axes[target][: len(robot.axes)]
    if not np.isnan(axes).any():
        shown = " ".join(
            f"{name} {value / (mm if axis.linear else deg):.3f}{' mm' if axis.linear else '°'}"
            for name, axis, value in zip(robot.axis_names, robot.axes, axes.tolist(), strict=True)
        )
        yield f"axes {shown}"


def _name(
    service: ProgramService, analysis: Analysis, asked: PlacedName, line: int, column: int
) -> Iterator[str]:
    """The line of the name's definition."""
    for found in definitions(service, analysis, line, column)[:1]:
        if found.line == asked.line and found.file == asked.file:
            continue
        where = (
            f"line {found.line}" if found.file == analysis.path else f"{file_name(found.file)}:{found.line}"
        )
        yield f"{asked.kind} of {where}: `{_text(service, analysis, found)}`"


def _text(service: ProgramService, analysis: Analysis, name: PlacedName) -> str:
    if name.file == analysis.path:
        return analysis.source.line(name.line).strip()
    if name.file in service.documents:
        return service.documents[name.file].line(name.line).strip()
    try:
        return load(name.file).line(name.line).strip()
    except OSError:
        return ""


def _seconds(value: float) -> str:
    return "no time" if math.isnan(value) else f"{value:.3f} s"
