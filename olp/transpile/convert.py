"""Writes a program in another language: the passes, the language's writer, and files of the target's shape.

`convert` makes files with a receipt, one per routine if needed; `export` makes one text and keeps nothing that the
language cannot say. Every vendor that can be written has a template `templates/<vendor>.j2`, which holds the shape of a
file, and a module `olp.languages.vendors.<vendor>.writer`, which spells the words.

Codes: X001 a language that cannot be written, X002 something that the language cannot say, X003 a character that the
encoding does not have, X011 something that the passes refuse.
"""

from __future__ import annotations

import codecs
import os
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, cast

from olp.core.diagnostic import Diagnostic, OlpError, Span, error, raise_errors
from olp.core.garbage_collection import no_garbage_collection
from olp.ir.expressions import Number, Quantity, Store, Taught
from olp.ir.points import PointBlock, PointTable
from olp.ir.program import Begin, Call, Comment, Dwell, End, Move, Program, Routine, Statement, Wait
from olp.ir.terminology import kind_of
from olp.ir.transformer import expressions_of
from olp.languages.limits import Limits, limits_of, refuse_unwritable
from olp.runtime.plan import CUT_SHORT
from olp.transpile.commented_out import text_alone, with_texts
from olp.transpile.context import Context, Fate, Loss, Translated, partly_left_out
from olp.transpile.dead_code import name_of
from olp.transpile.pipeline import MOST_AGAIN, asked_inputs, canonical, plan_of, refusals

if TYPE_CHECKING:
    from pathlib import Path

    from olp.robots.model import Robot
    from olp.runtime.assumptions import Assumptions, SignalKey
    from olp.runtime.made_up import MadeUp
    from olp.runtime.plan import Plan
    from olp.transpile.receipt import PlanRuns

_ERRORS = "surrogateescape"  # bytes that could not be read are written as they were, see `source`
_WITH_ASCII = frozenset({"cp1252", "iso8859-1", "utf-8"})  # of which ASCII is a part
_ROW = 1_000  # characters that a statement, a point or a declaration may take, twice what any was seen to
_FALLBACK = "cp1252"  # what controllers sold in Europe and America write


class Writer(Protocol):
    """The module `olp.languages.vendors.<vendor>.writer`."""

    def write(self, program: Program, date: str) -> tuple[dict[str, object], list[Diagnostic]]:
        """The values for the vendor's template, and an error for everything that the language cannot say."""


def export(
    program: Program,
    vendor: str,
    output: str | os.PathLike[str] | None = None,
    *,
    template: str | os.PathLike[str] | None = None,
    encoding: str | None = None,
    date: str | None = None,
) -> bytes:
    """The program in `vendor`'s language, also written to the file `output` if that is given.

    `template`: a jinja2 file instead of the vendor's own. `encoding`: a Python codec (None: the program's own).
    `date`: YYYY/MM/DD HH:MM for files that hold one (None: the program's own, or now).
    Raises OlpError with all errors of the program, all that the language cannot say (X…), or the template's (J…).
    """
    refuse_unwritable(vendor)
    raise_errors([found.at(program.path) for found in program.diagnostics])
    if program.vendor != vendor:
        program = _translated(program, vendor)
    text = _text(program, vendor, template, date or now())
    data = encoded(text, program, vendor, encoding or encoding_of(program))
    if output is not None:
        from olp.core.files import write_output

        write_output(os.fspath(output), data, inputs=[program.path] if program.path else [])
    return data


def _translated(program: Program, vendor: str) -> Program:
    """A program of another language in the form that the writer takes; `olp convert` says what changed."""
    from olp.transpile.pipeline import canonical, refusals

    translated = canonical(program, vendor)
    raise_errors([*translated.problems, *refusals(program, vendor, translated)])
    return translated.program


def _text(program: Program, vendor: str, template: str | os.PathLike[str] | None, date: str) -> str:
    writer = cast(Writer, import_module(f"olp.languages.vendors.{vendor}.writer"))
    values, problems = writer.write(program, date)
    raise_errors(problems)
    return rendered(values, vendor, program, template)


def rendered(
    values: dict[str, object],
    vendor: str,
    program: Program,
    template: str | os.PathLike[str] | None = None,
) -> str:
    """What the vendor's template, or another one, makes of a writer's values. Raises OlpError (J…)."""
    from olp.languages.templating import RenderingLimits, given, shipped

    renderer = shipped(vendor) if template is None else given(template)
    # What was read from several files has little text of its own.
    rows = len(program.data) + sum(len(r.body) + len(r.points) for r in program.routines)
    size = len(program.source.raw) + rows
    characters = 1_000_000 + 100 * size + _ROW * rows
    limits = RenderingLimits(steps=100_000 + 10 * size, characters=characters, seconds=60.0)
    return renderer.render(values, limits)


def now() -> str:
    """YYYY/MM/DD HH:MM."""
    from datetime import datetime

    return datetime.now().strftime("%Y/%m/%d %H:%M")


def encoding_of(program: Program) -> str:
    """What the program was read in; a mark of the byte order, which controllers refuse, is left out."""
    encoding = program.source.encoding
    if encoding == "ascii" or encoding.startswith(("utf-16", "utf-32")):
        return _FALLBACK
    return "utf-8" if encoding == "utf-8-sig" else encoding


def encoded(text: str, program: Program, vendor: str, encoding: str) -> bytes:
    """The text with the vendor's line ends. Raises OlpError (X003)."""
    from olp.languages.vendor import find_vendor

    ended = text.replace("\n", find_vendor(vendor).newline)
    try:
        # A table of characters takes twenty times as long as ASCII, which nearly all programs are.
        ascii_too = text.isascii() and codecs.lookup(encoding).name in _WITH_ASCII
        return ended.encode("ascii" if ascii_too else encoding, _ERRORS)
    except LookupError:
        raise OlpError(
            error("X003", f"unknown encoding '{encoding}'", help="try cp1252, shift_jis or utf-8")
        ) from None
    except UnicodeEncodeError:
        raise OlpError(*_unencodable(text, program, encoding)) from None


def _unencodable(text: str, program: Program, encoding: str) -> list[Diagnostic]:
    """One error per line of the new text that the encoding cannot hold."""
    problems = []
    for number, line in enumerate(text.split("\n"), 1):
        try:
            line.encode(encoding, _ERRORS)
        except UnicodeEncodeError as problem:
            span = Span(number, problem.start + 1, problem.end + 1)
            message = f"{encoding} has no '{line[problem.start : problem.end]}'"
            more = {
                "file": program.path,
                "source_line": line,
                "help": "choose another --encoding, such as utf-8",
            }
            problems.append(error("X003", f"{message} (line of the new text)", span, **more))
    return problems


_MOST_STEPS = 200_000  # statements of a run
_MOST_MADE_UP = 10_000  # of each of the runs with made-up values, which are many
_ROUNDS = 20  # of commenting out what the writer refuses


@dataclass(frozen=True, slots=True)
class Converted:
    """`files`: name -> bytes; `main`: the one that runs. `translated`: the passes' losses and mapping."""

    files: dict[str, bytes]
    main: str
    translated: Translated
    problems: tuple[Diagnostic, ...] = field(default=())


def convert(
    program: Program,
    vendor: str,
    context: Context | None = None,
    *,
    encoding: str | None = None,
    date: str | None = None,
) -> Converted:
    """`program` as files of the language `vendor`.

    Raises OlpError with the program's own errors, with what the target cannot say (X002, X011, X014), and where the
    question needs a robot (X012). With `on_loss` "comment" statements that cannot be said become comments, and
    routines with an error, but the main one.
    """
    refuse_unwritable(vendor)
    context = context or Context()
    if context.on_loss == "comment":
        program = with_texts(program, vendor)
    raise_errors([found.at(program.path) for found in program.diagnostics])
    # Statements are many, small and without cycles.
    with no_garbage_collection():
        return _converted(program, vendor, context, encoding, date)


def _converted(
    program: Program, vendor: str, context: Context, encoding: str | None, date: str | None
) -> Converted:
    left_out = text_alone(program)
    for _ in range(_ROUNDS):
        translated = canonical(program, vendor, context, left_out)
        raise_errors(translated.problems)
        files, main, problems = _written(translated.program, vendor, encoding, date, context.forms)
        lines = {found.line: _reason(found) for found in problems if found.line}
        if not left_out.add(lines, program, context.on_loss):
            break
    told = refusals(program, vendor, translated)
    refused = {found.line for found in told}
    # What a pass refuses the writer cannot say either, and in less fitting words.
    told += [found for found in problems if not found.line or found.line not in refused]
    if told:
        raise OlpError(*dict.fromkeys(told))
    return Converted(files, main, translated)


def _reason(found: Diagnostic) -> str:
    """Why the writer cannot say something, as the receipt tells it: "a computed index (…)"."""
    says = found.message.partition(": ")[2] or found.message
    return f"{says} ({found.help})" if found.help else says


def _written(
    program: Program, vendor: str, encoding: str | None, date: str | None, forms: bool
) -> tuple[dict[str, bytes], str, list[Diagnostic]]:
    """The files, which of them runs, and what the writer cannot say."""
    from olp.languages.vendor import find_vendor

    limits = limits_of(vendor, forms)
    suffix = find_vendor(vendor).written_suffix or find_vendor(vendor).suffixes[0]
    files: dict[str, bytes] = {}
    problems: list[Diagnostic] = []
    main = ""
    for part in split(program, limits):
        routine = _main_of(part)
        stem = routine.name if routine is not None else name_of(part)
        texts, found = _texts(part, vendor, date, limits)
        problems += found
        for ending, text in texts.items():
            name = f"{stem}{ending or suffix}"
            if not found:
                files[name] = _encoded(text, part, vendor, encoding)
            main = main or name
    return files, main, problems


def _main_of(program: Program) -> Routine | None:
    return next(
        (r for r in program.routines if r.name == program.main),
        program.routines[0] if program.routines else None,
    )


def _texts(
    program: Program, vendor: str, date: str | None, limits: Limits
) -> tuple[dict[str, str], list[Diagnostic]]:
    """The text of the file ("") and of those beside it, by suffix."""

    writer: Any = import_module(f"olp.languages.vendors.{vendor}.writer")
    asked = {"pair": limits.data_beside, "forms": limits.forms}
    values, problems = writer.write(
        program, date or now(), **{name: True for name, on in asked.items() if on}
    )
    companions: dict[str, str] = values.pop("companions", {})
    if problems:
        return {"": ""}, list(problems)
    text = rendered(values, vendor, program)
    return ({"": text, **companions} if text else companions), []  # of data alone there is nothing that runs


def _encoded(text: str, program: Program, vendor: str, encoding: str | None) -> bytes:

    return encoded(text, program, vendor, encoding or encoding_of(program))


def run_converted(
    converted: Converted,
    vendor: str,
    robot: Robot | None,
    source: Program | None = None,
    inputs: Mapping[SignalKey, tuple[int, ...]] | None = None,
) -> Plan:
    """The plan of the files, read again and run beside each other.

    `source`: what stands around that program (its olp.toml, its controller's tools and frames) stands around them.
    `inputs`: of the source, beside those that its olp.toml has.
    """
    with _read_again(converted, vendor, robot, source) as (_, plan):
        return plan(inputs or {}, _MOST_STEPS, None)


PlanAgain: TypeAlias = (
    "Callable[..., Plan]"  # of inputs, how many statements, made-up values, which routine starts
)


def first_routine(written: Program, converted: Converted, vendor: str) -> str:
    """The routine that runs first in the `written` main file: where the controller starts, whatever the passes took for
    the first; else that of the program it was made from."""
    made = converted.translated.program
    if written.main.casefold() == limits_of(vendor).started:
        return written.main
    return made.main or (made.routines[0].name if made.routines else "")


def starting(written: Sequence[Program], start: str) -> Program:
    """The program that has the routine `start`, from there; the first one where none has it."""
    for program in written:
        for routine in program.routines:
            if routine.name.casefold() == start.casefold():
                return replace(program, main=routine.name)
    return written[0]


@contextmanager
def _read_again(
    converted: Converted, vendor: str, robot: Robot | None, source: Program | None
) -> Generator[tuple[list[Program], PlanAgain]]:
    """The programs of the files, and what runs them: inputs of the source, how many statements, made-up values."""
    from olp.core.files import temporary_cell
    from olp.languages.vendor import find_vendor, read
    from olp.runtime.folder import read_cached
    from olp.runtime.interpreter import run

    def read_once(path: Path) -> Program:
        cached = read_cached(path)  # as the runs do that come to it
        return cached if cached.vendor == vendor else read(path, vendor=vendor)

    with temporary_cell() as folder:
        paths = [folder / name for name in converted.files]
        for path, data in zip(paths, converted.files.values(), strict=True):
            path.write_bytes(data)
        main = folder / converted.main
        program = read(main, vendor=vendor)
        raise_errors(program.diagnostics)
        suffixes = find_vendor(vendor).suffixes
        others = [p for p in paths if p != main and p.suffix.lower() in suffixes]
        written = [program, *map(read_once, others)]

        def plan(
            inputs: Mapping[SignalKey, tuple[int, ...]], steps: int, made_up: MadeUp | None, start: str = ""
        ) -> Plan:
            around = None if source is None else _surroundings(source, converted, robot, inputs)
            one = starting(written, converted.translated.mapping.get(("routine", start), start or own))
            return run(one, robot, folder=folder, assumptions=around, max_steps=steps, made_up=made_up)

        own = first_routine(program, converted, vendor)
        yield written, plan


def _surroundings(
    source: Program,
    converted: Converted,
    robot: Robot | None,
    more: Mapping[SignalKey, tuple[int, ...]],
) -> Assumptions:
    """olp.toml beside the source, with its tools and frames under the numbers that they have in the target."""
    from pathlib import Path

    from olp.ir.points import PointKind, PointState
    from olp.runtime.assumptions import Assumptions, WrittenPosition, load_assumptions, nearest_assumptions
    from olp.runtime.memory import ACTIVE
    from olp.transpile.context import cell_of
    from olp.transpile.correspondence import SignalsThere

    folder = Path(source.path).parent if source.path and Path(source.path).is_file() else None
    path = nearest_assumptions(folder) if folder is not None else None
    given = load_assumptions(path) if path is not None else Assumptions()
    cell = cell_of(source, robot)
    mapping = converted.translated.mapping

    def number(kind: str, n: int) -> int:
        new = mapping.get((kind, str(n)), "")
        return int(new) if new.isdecimal() else n

    tools = {number("tool", n): tuple(map(float, t.pose.xyz_angles())) for n, t in cell.tools.items()}
    frames = {number("frame", n): tuple(map(float, p.xyz_angles())) for n, p in cell.user_frames.items()}
    names = dict(given.names)
    for (kind, name), literal in converted.translated.held.items():
        if name.isdecimal():
            (tools if kind == "tool" else frames)[int(name)] = literal.values[:6]
        else:
            names[name.casefold()] = WrittenPosition(PointState(PointKind.POSE, ACTIVE), literal.values[:6])

    there = SignalsThere.of(mapping)
    inputs = {there.find(signal): values for signal, values in {**more, **given.inputs}.items()}
    waits = {there.find(signal): seconds for signal, seconds in given.waits.items()}
    return replace(given, tools=tools, frames=frames, names=names, inputs=inputs, waits=waits)


def runs_of(
    source: Program,
    converted: Converted,
    vendor: str,
    robots: tuple[Robot | None, Robot | None],
    lasting: ExitStack | None = None,
) -> PlanRuns:
    """Both programs run: as olp.toml and the usual assumptions have it, and again with the inputs that they ask for on.

    `robots`: of the source, and of the translation where it is another one. Further programs that the source holds
    (`Routine.starts`) run behind these. `lasting`: keeps the files of the translation for runs with one made-up value
    (`MadeUpRun.alone`), which else are read again for each.
    """
    from olp.runtime.end_actions import shown_at_ends
    from olp.runtime.made_up import MadeUp
    from olp.transpile.correspondence import SharedUnknowns, origins_of
    from olp.transpile.receipt import PlanRuns

    asked = asked_inputs(source)
    sets = [asked] if asked else []
    unknown = SharedUnknowns(source, converted.translated, vendor)
    plain = MadeUp(types=unknown.types)
    with_inputs = [MadeUp() for _ in sets]
    losses = converted.translated.losses
    left = _without(source, [loss for loss in losses if loss.leaves_out and loss.fate is Fate.COMMENTED])
    starts = tuple(routine.name for routine in source.routines if routine.starts)
    others = [replace(left, main=start) for start in starts]
    by_starts = [MadeUp(types=unknown.types, asked=plain.asked) for _ in starts]
    first = [plan_of(left, robots[0], None, None, plain)]
    first += [
        plan_of(left, robots[0], inputs, MOST_AGAIN, here)
        for inputs, here in zip(sets, with_inputs, strict=True)
    ]
    further = [plan_of(one, robots[0], None, None, here) for one, here in zip(others, by_starts, strict=True)]
    target = robots[1] or robots[0]

    def as_in(here: MadeUp) -> MadeUp:
        return MadeUp(turns=unknown.turns(here), timed=unknown.timed(here))

    reading: list[PlanAgain] = []  # what runs the translation, as long as its files are there

    def both(
        program: Program, start: str, here: MadeUp, those: Callable[[], MadeUp]
    ) -> tuple[Plan | None, Plan | None]:
        plan = plan_of(program, robots[0], {}, _MOST_MADE_UP, here)
        if plan is None:
            return None, None
        # What the source comes to the end of, the translation has to end, too: its waits may be loops that ask.
        most = _MOST_MADE_UP if any(d.code in CUT_SHORT for d in plan.diagnostics) else _MOST_STEPS
        if reading:
            return plan, reading[0]({}, most, those(), start)
        with _read_again(converted, vendor, target, source) as (_, again):
            return plan, again({}, most, those(), start)

    try:
        with ExitStack() as here_alone:
            files = lasting or here_alone
            written, again = files.enter_context(_read_again(converted, vendor, target, source))
            there = [again({}, _MOST_STEPS, as_in(plain))]
            there += [
                again(inputs, MOST_AGAIN, as_in(here)) for inputs, here in zip(sets, with_inputs, strict=True)
            ]
            there += [
                again({}, _MOST_STEPS, as_in(here), start)
                for start, here in zip(starts, by_starts, strict=True)
            ]
            origins = origins_of(converted.translated.program, map(shown_at_ends, written))
            reading.append(again)
            made_up = [
                run
                for program, start in zip((left, *others), ("", *starts), strict=True)
                for run in unknown.runs(partial(both, program, start), plain.asked)
            ]
            if lasting is None:
                reading.clear()
    except OlpError:
        return PlanRuns(tuple(first), (None,) * len(first))
    labels = (*("" for _ in first), *starts)
    return PlanRuns((*first, *further), tuple(there), origins, tuple(made_up), labels)


def _without(program: Program, losses: Sequence[Loss]) -> Program:
    """The program with nothing in the place of the statements that are left out of its translation."""
    lines = {loss.line for loss in losses}
    if not lines:
        return program
    lost = {(loss.line, loss.statement) for loss in losses}
    partly = partly_left_out(program, losses)
    routines = []
    for r in program.routines:
        rows = [
            _nothing(s) if s.line in lines and (s.line not in partly or (s.line, kind_of(s)) in lost) else s
            for s in r.body
        ]
        routines.append(replace(r, body=tuple(rows)))
    return replace(program, routines=tuple(routines))


def _nothing(s: Statement) -> Statement:
    """What is left of a statement: where the program waited, the arm still stops."""
    return Dwell(s.line, Quantity(Number(0), 1.0)) if isinstance(s, (Wait, Dwell)) else Comment(s.line, "")


# --- Files of the target ---
# Programs in the files that the target takes: one routine each, and no more statements or points than it holds.

_STRAIGHT = frozenset(
    {"Move", "SetOutput", "PulseOutput", "Dwell", "Wait", "Comment", "Assign", "Update", "Message", "Call"}
)


def split(program: Program, limits: Limits) -> Iterator[Program]:
    """The programs of the single files, the one that runs first."""
    if not limits.one_routine_per_file:
        yield program
        return
    main = program.main or (program.routines[0].name if program.routines else "")
    ordered = sorted(program.routines, key=lambda routine: routine.name != main)
    taken = {routine.name for routine in program.routines}
    for routine in ordered:
        for part in _parts(routine, limits, taken):
            yield replace(program, routines=(part,), main=part.name)


def _parts(routine: Routine, limits: Limits, taken: set[str]) -> Iterator[Routine]:
    """A straight routine that is too long as several, called in order; others stay whole."""
    points = sum(len(block) for key, block in routine.points.blocks.items() if key[1])
    room = min(limits.statements or len(routine.body), limits.points or len(routine.body))
    fits = len(routine.body) <= room and (not limits.points or points <= limits.points)
    if fits or any(
        type(s).__name__ not in _STRAIGHT for s in routine.body if not isinstance(s, (Begin, End))
    ):
        yield routine
        return
    rows: list[Statement] = [s for s in routine.body if not isinstance(s, (Begin, End))]
    pieces = list(_pieces(rows, room - 2))
    names = []
    for number in range(1, len(pieces) + 1):
        names.append(_name(routine.name, number, limits, taken))
    calls: list[Statement] = [Call(0, name) for name in names]
    yield replace(routine, body=(Begin(0), *calls, End(0)), points=_only(routine.points, set()))
    for name, piece in zip(names, pieces, strict=True):
        used = {e.number for s in piece for e in expressions_of(s) if type(e) is Taught}
        held = replace(routine.points, blocks={k: b for k, b in routine.points.blocks.items() if k[1]})
        yield replace(routine, name=name, body=(Begin(0), *piece, End(0)), points=_only(held, used))


def _pieces(rows: list[Statement], room: int) -> Iterator[list[Statement]]:
    """Runs of statements; an arc stays in one of them."""
    start = 0
    while start < len(rows):
        stop = min(start + room, len(rows))
        while stop < len(rows) and stop > start + 1 and _within_arc(rows, stop):
            stop -= 1
        yield rows[start:stop]
        start = stop


def _within_arc(rows: list[Statement], at: int) -> bool:
    s = rows[at]
    return isinstance(s, Move) and s.path.value == "circular" and s.via is None


def _name(stem: str, number: int, limits: Limits, taken: set[str]) -> str:
    tail = f"_{number}"
    room = limits.routine_name
    while True:
        name = (stem[: room - len(tail)] if room else stem) + tail
        if name not in taken:
            taken.add(name)
            return name
        tail += "A"


def _only(table: PointTable, numbers: set[int]) -> PointTable:
    """The taught points of these numbers, and all others."""
    blocks: dict[tuple[Store, bool], PointBlock] = {}
    for key, block in table.blocks.items():
        if not key[1]:
            blocks[key] = block
            continue
        rows = [row for row, number in enumerate(block.numbers.tolist()) if number in numbers]
        if rows:
            kept = {int(block.numbers[row]): at for at, row in enumerate(rows)}
            blocks[key] = PointBlock(
                block.store,
                block.taught,
                block.numbers[rows],
                block.values[rows],
                block.state[rows],
                block.lines[rows],
                kept,
            )
    return replace(table, blocks=blocks)
