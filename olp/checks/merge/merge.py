"""Merges three files and reports the time of the result and the budgets that it breaks.

Codes: U020 a version that cannot be merged, U021 conflict markers in a version, U022 the merged program has a
mistake that neither side has, U023 its time is incomplete, U024 no program of a known language.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from olp.checks.merge.model import Hunk, MergedText, SharedStatement, TextLine
from olp.checks.merge.three_way import merge_texts
from olp.core.diagnostic import Diagnostic, OlpError, Span, error, warning
from olp.core.files import from_os_error, read_input
from olp.core.garbage_collection import no_garbage_collection
from olp.core.result_cache import TextCache, remembering
from olp.core.source import decode
from olp.ir.program import Call, Declare, Label
from olp.languages.merging import MergeRules, PackedRules, lines_of
from olp.languages.vendor import Vendor, find_vendor, part_of, recognise, vendor_names

if TYPE_CHECKING:
    from olp.identification.timing_job import TimingJob
    from olp.ir.program import Program
    from olp.reports.outcome.model import JudgedItem
    from olp.timing.result import Timing

_MARKER = re.compile(rb"^(?:<{7,} |>{7,} )", re.MULTILINE)
_NAMES = ("base", "ours", "theirs")
_HEAD = 200  # bytes
_MOST_NAMES = 5  # that are told
_MOST_LINES = 4  # of each side of a conflict that no file holds


def merge_bytes(
    vendor: str, base: bytes, ours: bytes, theirs: bytes, files: tuple[str, str, str] = _NAMES
) -> MergedText:
    """The merge of three files of one language. Raises OlpError (U020, U021) for a text that cannot be merged."""
    rules = part_of(vendor, "merging")
    if rules is None:
        rules = MergeRules()
    packing = next(filter(None, map(rules.packing, (base, ours, theirs))), None)
    if packing is not None:
        return _merged_packed(packing, (base, ours, theirs), files)
    rules = next(filter(None, map(rules.of_saved, _told_by((base, ours, theirs)))), rules)
    for name, data in zip(files, (base, ours, theirs), strict=True):
        _check(name, data)
    if ours == theirs or base in (ours, theirs):
        # Nothing to decide, and no byte that could change.
        return _settled(theirs if ours == base else ours)
    with no_garbage_collection():
        return merge_texts(rules, *(data.decode("latin-1") for data in (base, ours, theirs)))


def _told_by(texts: Sequence[bytes]) -> list[str]:
    """The beginning of each text, which identifies its language."""
    return [data[:_HEAD].decode("latin-1") for data in texts]


def _merged_packed(
    rules: PackedRules, texts: tuple[bytes, bytes, bytes], files: tuple[str, str, str]
) -> MergedText:
    base, ours, theirs = texts
    if ours == theirs or base in (ours, theirs):
        return _settled(theirs if ours == base else ours)
    lines = [_unpacked(rules, *one).decode("latin-1") for one in zip(files, texts, strict=True)]
    merged = replace(merge_texts(rules, *lines), pack=rules.pack)
    try:
        merged.to_bytes()
    except ValueError as problem:
        raise OlpError(
            error(
                "U020",
                f"the two changes together are no program: {problem}",
                file=files[1],
                help="make one of the changes again in the other version",
            )
        ) from None
    return merged


def _unpacked(rules: PackedRules, file: str, data: bytes) -> bytes:
    try:
        return rules.unpack(data) if data else b""
    except ValueError as problem:
        raise OlpError(
            error(
                "U020", f"this cannot be merged: {problem}", file=file, help="save it again on the controller"
            )
        ) from None


def _settled(data: bytes) -> MergedText:
    return MergedText(tuple(TextLine(*line) for line in lines_of(data.decode("latin-1"))))


def _check(file: str, data: bytes) -> None:
    if b"\0" in data:
        raise OlpError(
            error(
                "U020",
                "this is not plain text: it cannot be merged",
                file=file,
                help="merge programs as their controllers save them, in an encoding of one byte or in UTF-8",
            )
        )
    marker = _MARKER.search(data) if b"<<<<<<<" in data or b">>>>>>>" in data else None
    if marker is not None:
        line = data.count(b"\n", 0, marker.start()) + 1
        raise OlpError(
            error(
                "U021",
                "a conflict of another merge is here",
                Span(line, 1, 8),
                file=file,
                source_line=data.splitlines()[line - 1].decode("latin-1"),
                help="resolve it, then merge",
            )
        )


# --- Files ---


class Seconds(NamedTuple):
    """Predicted totals [s]; None where a version cannot be timed."""

    base: float | None = None
    ours: float | None = None
    theirs: float | None = None
    merged: float | None = None


@dataclass(frozen=True, slots=True)
class Merged:
    """A merge of three files. `file`: name of the program; `ours`, `theirs`: the times [s] of the hunks' lines.

    `why`: the reason why the time is unknown. `budgets`: those that the merged program breaks or nearly breaks.
    """

    file: str
    text: MergedText
    seconds: Seconds = field(default_factory=Seconds)
    why: str = ""
    budgets: tuple[JudgedItem, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    hunk_seconds: tuple[tuple[float | None, float | None], ...] = ()

    @property
    def clean(self) -> bool:
        """Whether the merge has neither conflicts nor errors."""
        return not self.text.hunks and not any(one.is_error for one in self.diagnostics)

    @property
    def writable(self) -> bool:
        """Whether a file can be written, with or without conflicts."""
        return self.text.pack is None or not self.text.hunks

    def to_bytes(self, size: int = 7) -> bytes:
        """The merged file; each conflict is labelled with its subject and the time of either side."""
        return self.text.to_bytes(self._labels, size)

    def _labels(self, number: int, hunk: Hunk) -> tuple[str, str]:
        of = self.hunk_seconds[number] if number < len(self.hunk_seconds) else (None, None)
        what = f"{hunk.what} {hunk.name}".strip()
        sides = []
        for word, seconds, total in zip(("ours", "theirs"), of, self.seconds[1:3], strict=True):
            times = [f"{seconds:.3f} s"] if seconds is not None else []
            times += [f"program {total:.3f} s"] if total is not None else []
            sides.append(word + (f" ({', '.join(times)})" if times else ""))
        return f"{sides[0]}: {what}: {hunk.why}", sides[1]

    def as_text(self) -> str:
        """The report of the merge as text."""
        count = len(self.text.hunks)
        rows = [f"{self.file}: " + ("merged" if not count else f"{count} conflict{'s' * (count > 1)}")]
        rows[0] += "" if self.writable else ", nothing is written: this kind of file has no place for them"
        for word, taken in self.text.taken.items():
            parts = [f"{len(taken.points)} points" if len(taken.points) != 1 else f"point {taken.points[0]}"]
            parts += [f"{taken.statements} line{'s' * (taken.statements != 1)}"]
            if taken.points or taken.statements:
                rows.append(f"  from {word:6}  {', '.join(parts)}")
        for word, names in self.text.renamed.items():
            if names:
                told = ", ".join(f"{old} → {new}" for old, new in names[:_MOST_NAMES])
                more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
                rows.append(f"  from {word:6}  other names: {told}{more}")
        rows += [f"  both changed line {one.line}: {_shared(one)}" for one in self.text.shared]
        for hunk in self.text.hunks:
            rows.append(f"  conflict     {hunk.what} {hunk.name}: {hunk.why}".replace(" :", ":"))
            rows += [] if self.writable else _sides(hunk)
        known = {word: s for word, s in self.seconds._asdict().items() if s is not None}
        if "merged" in known:
            told = ", ".join(f"{word} {s:.3f}" for word, s in known.items() if word != "merged")
            rows.append(f"  time         {known['merged']:.3f} s ({told})")
        elif known:
            rows.append("  time         " + ", ".join(f"{word} {s:.3f} s" for word, s in known.items()))
        elif self.why:
            rows.append(f"  time         not known: {self.why}")
        rows += [f"  budget       {item.name}: {item.message}" for item in self.budgets]
        return "\n".join(rows)

    def as_json(self) -> dict[str, object]:
        """The report of the merge as data."""
        return {
            "file": self.file,
            "clean": self.clean,
            "seconds": self.seconds._asdict(),
            "taken": {
                word: {"points": list(one.points), "lines": one.statements}
                for word, one in self.text.taken.items()
            },
            "renamed": {word: dict(names) for word, names in self.text.renamed.items()},
            "both": [
                {"line": one.line, "ours": list(one.ours), "theirs": list(one.theirs)}
                for one in self.text.shared
            ],
            "conflicts": [
                {
                    "what": hunk.what,
                    "name": hunk.name,
                    "why": hunk.why,
                    "base": list(hunk.base),
                    "ours": [line.text for line in hunk.ours],
                    "theirs": [line.text for line in hunk.theirs],
                    "ours_s": of[0],
                    "theirs_s": of[1],
                }
                for hunk, of in zip(
                    self.text.hunks, self.hunk_seconds or ((None, None),) * len(self.text.hunks), strict=True
                )
            ],
            "budgets": [
                {"name": item.name, "status": str(item.status), "says": item.message, "limit_s": item.limit_s}
                for item in self.budgets
            ],
            "diagnostics": [
                {"code": one.code, "severity": str(one.severity), "line": one.line, "message": one.message}
                for one in self.diagnostics
            ],
        }


def _sides(hunk: Hunk) -> Iterator[str]:
    for word, lines in (("ours", hunk.ours), ("theirs", hunk.theirs)):
        for line in lines[:_MOST_LINES]:
            yield f"    {word:10} {line.text.strip()[:100]}"
        if len(lines) > _MOST_LINES:
            yield f"    {word:10} and {len(lines) - _MOST_LINES} more lines"


def _shared(one: SharedStatement) -> str:
    told = [
        f"{', '.join(names)} by {word}"
        for word, names in (("ours", one.ours), ("theirs", one.theirs))
        if names
    ]
    return ", ".join([*([] if one.ours and one.theirs else ["the same"]), *told])


def merge_files(paths: Sequence[str], home: str, job: TimingJob | None) -> Merged:
    """The merge of three files. `home`: path of the program, beside which its called routines are.

    `job`: settings of the timing, None: no timing. Raises OlpError (C005, U020, U021, U024).
    """
    texts = [_read(path) for path in paths]
    vendor = _language(texts, home)
    text = merge_bytes(vendor.name, texts[0], texts[1], texts[2], (paths[0], paths[1], paths[2]))
    with no_garbage_collection(), remembering(TextCache()):  # most lines are the same in all versions
        data = b"" if text.hunks else text.to_bytes()
        # What is saved beside the programs is none of them.
        merged = _program(vendor, data, home) if data and vendor.sniff(decode(data, home)) else None
        found = _new_mistakes(vendor, merged, texts, home) if merged is not None else ()
        result = Merged(home, text, diagnostics=found)
        if job is None or not _runs(vendor, home):
            return result
        return _timed(result, vendor, merged, texts, job)


def is_known(paths: Sequence[str], home: str) -> bool:
    """Whether one of three files is of a language that olp merges. Raises OlpError (C005)."""
    return _known([_read(path) for path in paths], home) is not None


def text_merge(paths: Sequence[str], size: int) -> int:
    """Git's own merge, written over the second file, for texts of no known language. Number of conflicts: 0, or 1
    for any.
    """
    from olp.core.files import write_output
    from olp.core.git import merged_text

    if any(b"\0" in _read(path) for path in paths):
        return 1  # git leaves ours there, and says so
    data, clean = merged_text(paths[1], paths[0], paths[2], size)
    write_output(paths[1], data, in_place=True)
    return 0 if clean else 1


def _read(path: str) -> bytes:
    try:
        return read_input(path)
    except OSError as problem:
        raise OlpError(from_os_error(problem)) from None


def _language(texts: Sequence[bytes], home: str) -> Vendor:
    found = _known(texts, home)
    if found is not None:
        return found
    raise OlpError(
        error(
            "U024",
            "this is not a robot program that olp knows",
            file=home,
            help="merge programs and data of robots: olp vendors lists their suffixes",
        )
    )


def _known(texts: Sequence[bytes], home: str) -> Vendor | None:
    """The vendor of the first version that identifies its language: the base is empty where both sides are new."""
    for data in texts:
        found = recognise(decode(data, home)) if data.strip() else None
        # Suffixes are those of other makers' files, too; a text that is none of the language stays as it is.
        if found is not None and found.sniff(decode(data, home)):
            return found
    for vendor in map(find_vendor, vendor_names()):
        rules: MergeRules | None = part_of(vendor.name, "merging")
        if rules is not None and any(map(rules.of_saved, _told_by(texts))):
            return vendor
    return None


def _runs(vendor: Vendor, home: str) -> bool:
    """Whether the file is a program, not a data list beside one."""
    return home.lower().endswith(vendor.suffixes) and not home.lower().endswith(vendor.data_suffixes or "\0")


def _program(vendor: Vendor, data: bytes, home: str) -> Program:
    return vendor.read(decode(data, home))


def _new_mistakes(
    vendor: Vendor, merged: Program, texts: Sequence[bytes], home: str
) -> tuple[Diagnostic, ...]:
    """Errors of the merged program that neither side has."""
    found = [*_mistakes(merged), *_undefined(merged)]
    if not found:
        return ()
    versions = [_program(vendor, data, home) for data in texts if data.strip()]
    known = {one.message for side in versions[-2:] for one in (*_mistakes(side), *_undefined(side))}
    here = {routine.name.upper() for side in versions for routine in side.routines}
    return tuple(
        error(
            "U022",
            f"neither side has this mistake, the merged program has: {one.message}",
            Span(one.line, one.column, one.end_column) if one.line else None,
            file=home,
            source_line=one.source_line,
            help=one.help,
        )
        for one in found
        # What no version defines stands in another file.
        if one.message not in known and (one.is_error or one.message.rpartition(" ")[2] in here)
    )


def _mistakes(program: Program) -> Iterator[Diagnostic]:
    """Errors that the reader finds, and names that are declared twice."""
    yield from (one for one in program.diagnostics if one.is_error)
    yield from _twice(program, "routine", [(one.name, one.line) for one in program.routines])
    for scope, body in (("", program.data), *((f" in {one.name}", one.body) for one in program.routines)):
        for what, kind in (("name", Declare), ("label", Label)):
            named = [(one.name, one.line) for one in body if isinstance(one, kind)]
            yield from _twice(program, what, named, scope)


def _twice(
    program: Program, what: str, named: Sequence[tuple[str, int]], scope: str = ""
) -> Iterator[Diagnostic]:
    lines = {name.casefold(): line for name, line in named}  # the last of each
    if len(lines) < len(named):
        often = Counter(name.casefold() for name, _ in named)
        for name in (name for name in lines if often[name] > 1):
            yield _mistake(
                error,
                program,
                lines[name],
                f"the {what} {name} stands twice{scope}",
                "take one of the two out",
            )


def _undefined(program: Program) -> Iterator[Diagnostic]:
    """Calls of routines that the file does not define."""
    own = {routine.name.upper() for routine in program.routines}
    for one in program.statements():
        if isinstance(one, Call) and one.macro is None and one.routine.upper() not in own:
            says = f"no routine here is called {one.routine.upper()}"
            yield _mistake(warning, program, one.line, says, "keep the routine, or leave out the call")


def _mistake(
    make: Callable[..., Diagnostic], program: Program, line: int, says: str, help: str
) -> Diagnostic:
    shown = program.source.line(line)
    return make("U022", says, Span(line, 1, len(shown) + 1), source_line=shown, help=help)


# --- Times ---


def _timed(
    result: Merged, vendor: Vendor, merged: Program | None, texts: Sequence[bytes], job: TimingJob
) -> Merged:
    from olp.identification.timing_job import time_program

    programs = [_program(vendor, data, result.file) if data.strip() else None for data in texts]
    # The file itself may not be there yet, and git makes folders after it has merged what belongs into them.
    folder = next(one for one in Path(result.file).absolute().parents if one.is_dir())
    timings: list[Timing | None] = []
    why = ""
    for program in (*programs, merged):
        try:
            timings.append(None if program is None else time_program(program, job, folder))
        except OlpError as problem:
            timings.append(None)
            why = problem.diagnostics[0].message
    totals = Seconds(*(None if one is None else one.total_s for one in timings))
    hunks = tuple(
        (_seconds(timings[1], hunk.ours_at), _seconds(timings[2], hunk.theirs_at))
        for hunk in (result.text.hunks if result.writable else ())  # else these are no lines of the program
    )
    held = replace(result, seconds=totals, why=why, hunk_seconds=hunks)
    if merged is None or timings[3] is None:
        return held
    return replace(held, budgets=_budgets(result.file, merged, timings[3]), diagnostics=(
        *held.diagnostics, *_told(timings[3])
    ))  # fmt: skip


def _told(timing: Timing) -> list[Diagnostic]:
    """Diagnostics of the merged program that make its time incomplete."""
    count = len(timing.left_open)
    if not count:
        return []
    first = timing.left_open[0]
    return [
        warning(
            "U023",
            f"the time is that of a part: {first.message}" + (f", and {count - 1} more" if count > 1 else ""),
            Span(first.line, first.column, first.end_column) if first.line else None,
            file=first.file,
            source_line=first.source_line,
            help="olp time says what is missing",
        )
    ]


def _seconds(timing: Timing | None, lines: Sequence[int]) -> float | None:
    """Time [s] of these lines of the program, over all their executions."""
    if timing is None:
        return None
    wanted = set(lines)
    plan = timing.plan
    steps = zip(plan.source.tolist(), plan.line.tolist(), timing.duration_s.tolist(), strict=True)
    found = [seconds for source, line, seconds in steps if source == 0 and line in wanted]
    return sum(s for s in found if s == s) if found else None


def _budgets(path: str, program: Program, timing: Timing) -> tuple[JudgedItem, ...]:
    from olp.checks.guard.budget import budgets_for

    own = [b for known in budgets_for(path) for b in known.budgets if b.covers(path) and not b.signature]
    if not own:
        return ()
    from olp.checks.guard.judge import judge_timing
    from olp.reports.outcome.model import Status

    items, _ = judge_timing(path, program, {"": timing}, own)
    return tuple(item for item in items if item.status is not Status.HELD)
