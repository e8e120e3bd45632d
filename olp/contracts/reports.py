"""What every report format promises: `check_report`.

Two timings are told: that of two real programs, and one that is made by hand to hold what is rare in programs (a
routine of another file, a step without a time, assumptions, an error, the ends of an interval, signs that mean
something between cells).
"""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from olp.contracts.promises import Difference, Promise, hold
from olp.contracts.readings import differences, load_declared, save
from olp.core.diagnostic import Span, error, warning
from olp.core.source import Source
from olp.identification.timing_job import TimingJob, plan_and_time
from olp.reports.batch import Job, time_files
from olp.reports.cell import CellLinks
from olp.reports.formats.report import Options, Report, ReportPart, load_report, report_names
from olp.robots import RECORDED_ROBOT
from olp.runtime.plan import Assumption, StepKind
from olp.timing.result import CorrectionInterval, Timing

FILES: Final = tuple(
    Path(__file__).resolve().parents[2] / "samples" / "up20" / f"{name}.JBI" for name in ("APPR-1", "DEPT-2")
)
ROBOT: Final = RECORDED_ROBOT
_MISSING: Final = "gone/no-such-program.jbi"

# --- a timing made by hand ------------------------------------------------------------------------------------

_LINES: Final = ('TELL "a, b | ü"', "IF *I1* <> OFF", "RISE", "LOWER", "PAUSE", "GUESS")
_PLACE: Final = "cells/main|1.job"
_CALLED: Final = "cells/called.job"
_EVERYWHERE: Final = "the tool is as long as it *was*"
_ONCE: Final = "the gripper opens in no time"
_NUMBERS: Final[Mapping[str, tuple[float | None, ...]]] = {
    "distance_mm": (12.34567891, 150.0, 81.77, 7.06, None, 33.0),
    "speed_mm_s": (None, None, 300.0, 120.25, None, 250.0),
    "reached_mm_s": (99.51, 17.0, 299.87, 61.23, None, None),
    "accel_mm_s2": (2513.0, 777.0, 4001.0, 3055.0, None, None),
    "duration_s": (0.51234567, 1.25, 0.8765, 0.4321, 2.0, None),
    "speed_pct": (40.5, None, None, None, None, None),
    "speed_deg_s": (None, 55.25, None, None, None, None),
    "angle_deg": (None, 90.0, None, None, None, None),
}
_LIMITS: Final = ("speed", "tool turn", "speed", "acceleration", "", "")
_WITHOUT_A_TIME: Final = 5
_LOOKS: Final = (
    5,
    4,
    3,
    2,
)  # without a time, standing still, short of its speed, as programmed: told apart at once


@lru_cache(maxsize=2)
def made_timing(known: bool) -> Timing:
    """Six steps, the fourth of another file. `known`: nothing is left open, assumed or wrong."""
    timing = plan_and_time(str(FILES[0]), TimingJob(robot=ROBOT))
    numbers: dict[str, Any] = {
        name: np.array([np.nan if v is None else v for v in row]) for name, row in _NUMBERS.items()
    }
    if known:
        numbers["duration_s"][_WITHOUT_A_TIME] = 0.75
    wait = [StepKind.MOVE] * 4 + [StepKind.WAIT, StepKind.MOVE]
    plan = replace(
        timing.plan,
        sources=(_source(_PLACE, _LINES), _source(_CALLED, ("", "", "", "LOWER"))),
        line=np.array([1, 2, 3, 4, 5, 6], dtype=np.int32),
        source=np.array([0, 0, 0, 1, 0, 0], dtype=np.int16),
        kind=np.array(wait, dtype=np.int8),
        row=timing.plan.row[:6],
        robot=timing.plan.robot if known else None,
        stop_reason="" if known else "the limit of steps is reached",
    )
    places = [1, 2, 3, 5, 6, 7, 11, 12, 13, 17]
    assumed = [Assumption(line, _EVERYWHERE, _PLACE) for line in places] + [Assumption(4, _ONCE, _CALLED)]
    wrong = (
        error("X000", "<b> is unknown | left out", Span(6, 3), file=_PLACE),
        warning("Z000", "speed was not said", file=_PLACE),
    )
    return replace(
        timing,
        plan=plan,
        kind=("linear", "circular", "linear", "joint", "wait", "linear"),
        limited_by=_LIMITS,
        assumptions=() if known else tuple(assumed),
        diagnostics=() if known else wrong,
        interval=_interval(numbers["duration_s"]) if known else None,
        expected=(4.5, 7.25),
        **numbers,
    )


def _interval(duration: NDArray[np.float64]) -> CorrectionInterval:
    return CorrectionInterval(duration * 0.9, duration * 1.2, 4.1, 6.2)


def _source(path: str, lines: tuple[str, ...]) -> Source:
    return Source(path, "\r\n".join(lines).encode(), "utf-8", lines)


def made_part(report: Report, timing: Timing, options: Options) -> ReportPart:
    """As `time_file` makes it."""
    path, found = timing.plan.path, timing.diagnostics
    text = report.part(path, timing, found, options)
    sums = (timing.total_s, timing.motion_s, timing.wait_s, timing.io_s)
    return ReportPart(path, text, timing.robot, *sums, len(timing.assumptions), found)


# --- reading a report back ------------------------------------------------------------------------------------

# What the columns of tables for people are called, and the digits behind the point that they need at least.
_HEADS: Final = {
    "mm": "distance_mm", "V mm/s": "speed_mm_s", "top mm/s": "reached_mm_s", "mm/s²": "accel_mm_s2",
    "limited by": "limited_by", "time s": "duration_s", "end s": "end_s",
    "total s": "total_s", "motion s": "motion_s", "waits s": "wait_s", "I/O s": "io_s",
}  # fmt: skip
_DIGITS: Final = {"distance_mm": 1, "speed_mm_s": 1, "reached_mm_s": 1, "accel_mm_s2": 0}
_STYLE: Final = re.compile(r"\x1b\[[0-9;]*m")
Table = list[dict[str, Any]]


def tables_of(text: str) -> list[Table]:
    """The rows of every table of a report: objects of JSON, cells between bars, commas, or two blanks and more."""
    if text.startswith("["):
        found = json.loads(text)
        return [found, *(one["segments"] for one in found if one["segments"])]
    blocks = [block.split("\n") for block in re.split(r"\n{2,}", text.strip("\n"))]
    return [table for block in blocks for table in _read(block)]


def _read(lines: list[str]) -> Iterator[Table]:
    bars = [re.split(r"(?<!\\)\|", line)[1:-1] for line in lines if line.startswith("|")]
    commas = list(csv.reader(lines))
    if bars:
        yield _as_rows([bars[0], *bars[2:]])
    elif len(commas[0]) > 3 and ", " not in lines[0]:
        yield _as_rows(commas)
    else:
        begin = 1 if not re.search(r"\S {2,}\S", lines[0]) else 0  # a title above the table
        spans = _columns(lines[begin:])
        if len(spans) > 3:
            yield _as_rows([[line[a:b] for a, b in spans] for line in lines[begin:]])


def _columns(lines: list[str]) -> list[tuple[int, int]]:
    """Where the columns begin and end that two blanks keep apart in every line."""
    width = max(map(len, lines), default=0)
    blank = "".join("x" if any(line[i : i + 1].strip() for line in lines) else " " for i in range(width))
    return [found.span() for found in re.finditer(r"x+(?: x+)*", blank)]


def _as_rows(cells: list[list[str]]) -> Table:
    names = [_HEADS.get(name.strip(), name.strip()) for name in cells[0]]
    return [dict(zip([*names, *map(str, range(9))], map(str.strip, row), strict=False)) for row in cells[1:]]


def _is_of(cell: Any, value: float | None, digits: int) -> bool:
    """Whether a cell says this number, in so many digits or exactly; and nothing where there is none."""
    text = "" if cell is None else str(cell)
    if value is None or math.isnan(value):
        return text in ("", "unknown")
    found = re.fullmatch(r"(?:>= )?(-?\d+(?:\.(\d+))?)", text)
    if found is None:
        return False
    written = len(found[2] or "")
    return abs(float(found[1]) - value) <= 0.5 * 10.0**-written + 1e-9 and (
        written >= digits or abs(float(found[1]) - value) < 5e-7
    )


# --- the suite ------------------------------------------------------------------------------------------------


@lru_cache(maxsize=16)
def parts_of(name: str, options: Options, paths: tuple[str, ...]) -> tuple[ReportPart, ...]:
    return tuple(time_files(list(paths), Job(format=name, robot=ROBOT, options=options), workers=1))


class ReportUnderTest:
    def __init__(self, name: str) -> None:
        self.name, self.report = name, load_report(name)
        self.paths = tuple(str(path) for path in FILES)

    def text(self, options: Options | None = None, *more: str) -> tuple[str, tuple[ReportPart, ...]]:
        asked = options or Options()
        parts = parts_of(self.name, asked, (*self.paths, *more))
        return self.report.join(list(parts), asked), parts

    def made(self, *, known: bool = False, **options: Any) -> str:
        """The report of the timing made by hand."""
        asked = Options(**options)
        return self.report.join([made_part(self.report, made_timing(known), asked)], asked)

    @cached_property
    def whole(self) -> str:
        return self.text()[0]

    @cached_property
    def is_aligned(self) -> bool:
        """Whether blanks keep the columns apart."""
        return bool(re.search(r"^line +statement ", self.made(), flags=re.MULTILINE))


def check_report(name: str, *, first: bool = False) -> None:
    """Raises ContractError with every promise of a report format that the one called `name` breaks.

    from olp.contracts import check_report
    check_report("csv")
    """
    hold(f"report format {name}", ReportUnderTest(name), PROMISES, first=first)


def says_what_it_is(it: ReportUnderTest) -> Iterator[Difference]:
    """A format says in one line what it is for, and is found under the name of its file"""
    if not 5 < len(it.report.summary) < 100 or "\n" in it.report.summary:
        yield "summary", repr(it.report.summary)
    if it.name not in report_names() or not isinstance(it.report, Report):
        yield it.name, "the registry of formats does not find it"


def names_every_file(it: ReportUnderTest) -> Iterator[Difference]:
    """Every file is in the report, in the order in which they were given, and its text ends with a line end"""
    text = it.whole
    if not text.endswith("\n"):
        yield "two programs", "the last line has no end"
    places = [text.find(path.name) for path in FILES]
    if -1 in places or places != sorted(places):
        yield "two programs", f"their names are at {places}"
    for said in (text, it.made(), it.made(segments=False)):
        if {"nan", "none"} & set(re.findall(r"[a-z]+", said.lower())):
            yield "a program", "a number or a name that is none"


def tells_every_step(it: ReportUnderTest) -> Iterator[Difference]:
    """Each step is a row of a table: its line, its statement and its numbers, as exact as people and scripts need"""
    for known in (False, True):
        steps = list(made_timing(known).segments())
        rows = next(
            (table for table in tables_of(it.made(known=known)) if "statement" in (table or [{}])[0]), []
        )
        if len(rows) < len(steps):
            yield f"{len(steps)} steps", f"{len(rows)} rows"
        for row, step in zip(rows, steps, strict=False):
            yield from _of_step(row, step)
    ends = next(
        (t for t in tables_of(it.made(known=True, interval=True)) if {"low_s", "statement"} <= set(*t[:1])),
        [],
    )
    for row, step in zip(ends, made_timing(True).segments(), strict=False):
        if not _is_of(row["low_s"], step["low_s"], 3) or not _is_of(row["high_s"], step["high_s"], 3):
            yield step["statement"], f"its interval is {row['low_s']!r} to {row['high_s']!r}"
    if not ends and "4.100" not in it.made(known=True, interval=True):
        yield "interval=True", "no interval is told, of a step or of the total"


def _of_step(row: Mapping[str, Any], step: Mapping[str, Any]) -> Iterator[Difference]:
    said = re.sub(r"\\(?=[|*])|&(?=lt;)", "", str(row["statement"])).replace("lt;", "<")
    if not said.endswith(step["statement"]) or str(row["line"]) != str(step["line"]):
        yield step["statement"], f"line {row['line']} {said!r}"
    if said != step["statement"] and (said.partition(": ")[0] not in step["file"] or step["file"] == _PLACE):
        yield step["statement"], f"{said!r}, of {step['file']}"
    if "file" not in row and step["file"] != _PLACE and said == step["statement"]:
        yield step["statement"], f"nothing says that it stands in {step['file']}"
    if row["limited_by"] != step["limited_by"]:
        yield step["statement"], f"limited by {row['limited_by']!r}, not {step['limited_by']!r}"
    for name in ("distance_mm", "reached_mm_s", "accel_mm_s2", "duration_s", "end_s"):
        if not _is_of(row[name], step[name], _DIGITS.get(name, 3)):
            yield step["statement"], f"{name}: {row[name]!r}, not {step[name]}"
    yield from _of_speed(row, step)


def _of_speed(row: Mapping[str, Any], step: Mapping[str, Any]) -> Iterator[Difference]:
    """The programmed speed, in a column of its unit or with its unit in the one that there is."""
    units = {"speed_pct": " %", "speed_deg_s": " °/s"}
    if "speed_pct" in row:
        wrong = [name for name in ("speed_mm_s", "angle_deg", *units) if not _is_of(row[name], step[name], 1)]
    else:
        other = next(
            (f"{step[name]:g}{unit}" for name, unit in units.items() if step[name] is not None), None
        )
        right = row["speed_mm_s"] == other if other else _is_of(row["speed_mm_s"], step["speed_mm_s"], 1)
        wrong = [] if right else ["speed_mm_s"]
    for name in wrong:
        yield step["statement"], f"{name}: {row[name]!r}, not {step[name]}"


def keeps_cells_apart(it: ReportUnderTest) -> Iterator[Difference]:
    """A row has as many cells as its head and numbers stand right, whatever signs the texts in it hold"""
    for text in (it.made(), it.made(known=True), it.made(segments=False), it.whole):
        for table in tables_of(text):
            odd = [row for row in table if set(row) != set(table[0])]
            if odd:
                yield "cells", f"{list(odd[0])}, and above {list(table[0])}"
        rules = [line for line in text.split("\n") if re.fullmatch(r"\|[ :|-]+\|", line)]
        for rule, table in zip(rules, tables_of(text), strict=False):
            right = [
                name
                for name, cell in zip(table[0], rule.split("|")[1:-1], strict=True)
                if cell.strip() == "---:"
            ]
            if set(table[0]) - set(right) != {"statement", "limited_by"}:
                yield "columns of numbers", f"these stand right: {', '.join(right)}"
        if rules and re.search(r"(?<![\\*])\*(?!\*)|(?<!\\)\|1|<\w", text):
            yield "signs of the format", "they stand in it as they were written in the program"


def lines_columns_up(it: ReportUnderTest) -> Iterator[Difference]:
    """Where blanks keep columns apart, numbers end and words begin at one place; a narrow screen cuts only words"""
    if not it.is_aligned:
        return
    for width in (0, 84, 40):
        lines = it.made(known=True, width=width).split("\n\n")[0].split("\n")[1:]
        ends, begins = (
            {len(line) for line in lines},
            {line.find(s[:8]) for line, s in zip(lines[1:], _LINES, strict=True)},
        )
        if len(ends) != 1 or len(begins - {-1}) > 2 or not lines[0].endswith("end s"):
            yield f"width {width}", f"lines end at {sorted(ends)}, statements begin at {sorted(begins)}"
        for line, step in zip(lines[1:], made_timing(True).segments(), strict=True):
            if not line.endswith(f"  {step['end_s']:.3f}") or step["limited_by"] not in line:
                yield f"width {width}", f"{line!r} has lost its end"
        wide = len(it.made(known=True).split("\n")[1])
        if width and max(ends) != max(width, wide - len("called.job: LOWER") + 12):
            yield f"width {width}", f"lines of {max(ends)}, without a limit of {wide}"
    for width, cut in ((0, 0), (70, 2)):
        text = _overview(it, [f"cells/{name}{'x' * 40}.job" for name in "ab"], width)
        lines = text.strip().split("\n")
        if text.count("…") != cut or text.count("xx.job") != 2 or len({len(line) for line in lines[:1]}) > 1:
            yield f"long names, width {width}", text
        if width and max(map(len, lines)) != width:
            yield (
                f"long names, width {width}",
                f"lines of {max(map(len, lines))}: too long, or cut more than they have to",
            )


def _overview(it: ReportUnderTest, names: list[str], width: int = 0, called: tuple[str, ...] = ()) -> str:
    """The report without segments of the timing made by hand under these names; the last one calls `called`."""
    options = Options(segments=False, width=width)
    part = made_part(it.report, made_timing(True), options)
    parts = [
        replace(
            part, file=name, links=CellLinks("", (Path(name).stem.upper(),), called * (name == names[-1]))
        )
        for name in names
    ]
    return it.report.join(parts, options)


def tells_the_sums(it: ReportUnderTest) -> Iterator[Difference]:
    """Total, motion, waits and I/O of each file are told, with or without its segments, and what they leave out"""
    text, parts = it.text()
    short, _ = it.text(Options(segments=False))
    for part in parts:
        if not all(f"{part.total_s or 0:.3f}"[:-1] in said for said in (text, short)):
            yield part.file, f"its total of {part.total_s:.3f} s is not in the report"
    if len(short) >= len(text) or any(path.name not in short for path in FILES):
        yield "segments=False", f"{len(short)} characters, {len(text)} with segments, or a file is missing"
    for known in (True, False):
        timing = made_timing(known)
        text = it.made(known=known, segments=False)
        left = iter(re.findall(r"(?<![\w.])\d+\.\d+", text))
        for name in ("total_s", "motion_s", "wait_s", "io_s"):
            value = getattr(timing, name)
            if not any(_is_of(cell, value, 3) for cell in left):
                yield "segments=False", f"{name} {value:.3f} is not told, or not behind the others"
    if not re.search(
        r'"untimed": 1\b|,1$|>= \d.*\b1$|incomplete: 1 of 6 steps.*, 1 error', it.made(segments=False), re.M
    ):
        yield "a step without a time", "the report looks complete"
        for row in (row for table in tables_of(text) for row in table if "robot" in row):
            if (row["robot"] or "") != (timing.robot or "") or _is_of(
                row["untimed"], timing.untimed, 0
            ) is False:
                yield "segments=False", f"robot {row['robot']!r}, {row['untimed']} steps without a time"
    if it.is_aligned and ("file  " in it.made() or "2 files" not in it.whole):
        yield "segments=True", "an overview of one file, or none of two"
    yield from _sum_of_files(it)


def _sum_of_files(it: ReportUnderTest) -> Iterator[Difference]:
    """Where files are summed up: a routine's time is in that of its caller, and is not counted again."""
    total = made_timing(True).total_s
    names, called = ["cells/a.job", "cells/../cells/b.job"], ("A",)
    if f"{2 * total:.3f}" not in _overview(it, names):
        return  # this format sums nothing up
    for other, count in (((), 2), (called, 1)):
        line = _overview(it, names, 0, other).strip().split("\n")[-1]
        found = re.findall(r"\d+\.\d{3}", line)
        wanted = [
            f"{count * getattr(made_timing(True), name):.3f}"
            for name in ("total_s", "motion_s", "wait_s", "io_s")
        ]
        if found != wanted or (f"{count} of 2" in line) != bool(other) or "2 files" not in line:
            yield f"two files, {count} counted", line
    options = Options(segments=False)
    parts = [replace(made_part(it.report, made_timing(False), options), file=name) for name in names]
    line = it.report.join(parts, options).strip().split("\n")[-1]
    if not re.search(r">= \d.* 22 +2$", line):
        yield "two files with assumptions and errors", f"{line!r} does not count them"


def tells_what_is_behind(it: ReportUnderTest) -> Iterator[Difference]:
    """Who tells an assumption or a problem tells all of them, with their lines, and why a run ended early"""
    text = re.sub(r"\\(?=[|*])", "", it.made()).replace("&lt;", "<")
    if _EVERYWHERE in text or _ONCE in text:
        numbers = r"1\b.*\b2\b.*\b3\b.*\b5\b.*\b6\b.*\b7\b.*\b11\b.*\b12\b.*(?:\b2 more|\b13\b.*\b17\b)"
        if (
            not re.search(numbers, text)
            or "called.job" not in text.partition(_ONCE)[0][-60:] + text.partition(_ONCE)[2]
        ):
            yield "assumptions", "a line or a file is missing"
    bare = text.startswith("line,")  # nothing but a table
    if not bare and (_EVERYWHERE not in text or _ONCE not in text):
        yield "assumptions", "one of two is missing"
    if not bare and not it.is_aligned and "incomplete" not in text and '"untimed": 1' not in text:
        yield "a step without a time", "the report looks complete"
    if it.is_aligned == ("X000" in text) and not bare:
        yield (
            "diagnostics",
            "they belong into the report, or onto the screen beside a table of aligned columns",
        )
    if "X000" in text:
        for sign in ("Z000", "<b> is unknown | left out", "speed was not said", "error", "warning"):
            if sign not in text:
                yield "diagnostics", f"{sign!r} is missing"
        if re.search(r"Z000[^X]*line\W*0: speed", text) or not re.search(r"X000[^X]*\b6\b", text):
            yield "diagnostics", "a line that is none, or a line that is missing"
    if it.is_aligned and made_timing(False).plan.stop_reason not in text:
        yield "a run that ended early", "nothing says so"
    empty = made_timing(True).plan
    if it.is_aligned and "no move" not in _of_nothing(it):
        yield empty.path, "a program that does nothing has an empty table"


def _of_nothing(it: ReportUnderTest) -> str:
    """The report of a program that executes nothing."""
    timing = made_timing(True)
    nothing = {name: getattr(timing, name)[:0] for name in (*_NUMBERS, "kind", "limited_by")}
    plan = replace(
        timing.plan, **{name: getattr(timing.plan, name)[:0] for name in ("line", "source", "kind", "row")}
    )
    return it.report.part(_PLACE, replace(timing, plan=plan, **nothing), (), Options())


def paints_what_differs(it: ReportUnderTest) -> Iterator[Difference]:
    """Colour only where it was asked for: it changes no sign, and shows what is unknown, at rest, or cut short"""
    for text in (it.whole, it.made(), it.made(segments=False)):
        strange = [c for c in text if not c.isprintable() and c not in "\n\t"]
        if strange:
            yield "colour=False", f"the character {strange[0]!r}"
    painted = it.made(colour=True)
    if _STYLE.sub("", painted) != it.made():
        yield "colour=True", "another text"
    if painted == it.made():
        return
    lines = [line for mark in _LINES for line in painted.split("\n") if mark[:4] in line]
    looks = [tuple(_STYLE.findall(lines[row])) for row in _LOOKS]
    if len(set(looks)) < len(looks) or not looks[0]:
        yield "colour=True", f"rows look alike: {looks}"
    plain = [line for line in painted.split("\n") if line.startswith(("total", "incomplete", "line"))]
    if plain:
        yield "colour=True", f"{plain[0]!r} is not painted"


def stands_a_failed_file(it: ReportUnderTest) -> Iterator[Difference]:
    """A file that cannot be read does not stop the others, and the report does not pass it over"""
    text, parts = it.text(None, _MISSING)
    if [part.failed for part in parts] != [False, False, True]:
        yield _MISSING, f"failed: {[part.failed for part in parts]}"
    if any(path.name not in text for path in FILES):
        yield _MISSING, "the other files are not in the report"
    alone = it.report.join([replace(parts[-1], file=_MISSING)], Options())
    if it.is_aligned and "not timed" not in alone:
        yield _MISSING, alone


def joins_what_it_is_given(it: ReportUnderTest) -> Iterator[Difference]:
    """The parts make the whole: fewer parts are a shorter report, none at all is a report as well"""
    _, parts = it.text()
    one = it.report.join(list(parts[:1]), Options())
    if FILES[1].name in one or FILES[0].name not in one or len(one) >= len(it.whole):
        yield "one of two parts", "not the report of that file alone"
    none: object = it.report.join([], Options())
    if not isinstance(none, str):
        yield "no parts", repr(none)
    again = it.report.join(list(parts), Options())
    if again != it.whole:
        yield "the same parts", "another report the second time"


# --- declared reports -----------------------------------------------------------------------------------------

_DECLARED: Final = FILES[0].parent / "reports"
_OPTIONS: Final[Mapping[str, Mapping[str, Any]]] = {
    "segments": {}, "no segments": {"segments": False}, "interval": {"interval": True}, "colour": {"colour": True},
    "narrow": {"width": 70}, "colour, no segments": {"colour": True, "segments": False},
}  # fmt: skip
_LONG_NUMBER: Final = re.compile(r"\d+\.\d{11,}")  # whose last digits are the machine's


def declare_report(name: str) -> None:
    """Writes what the format makes of the timings made by hand, for its author to check."""
    _DECLARED.mkdir(exist_ok=True)
    save(_DECLARED / f"{name}.report", _reports_of(ReportUnderTest(name)))


def _reports_of(it: ReportUnderTest) -> dict[str, list[str]]:
    texts = {
        f"{options}, {'known' if known else 'left open'}": it.made(known=known, **chosen)
        for options, chosen in _OPTIONS.items()
        for known in (True, False)
    }
    texts["a program that executes nothing"] = _of_nothing(it)
    texts["three files, one of them called"] = _overview(it, ["a.job", "b.job", "c.job"], 0, ("A",))
    wrong = (error("X000", "it is not there", file="gone.job"),)
    gone = ReportPart("gone.job", it.report.part("gone.job", None, wrong, Options()), diagnostics=wrong)
    texts["a file that is not timed"] = it.report.join([gone], Options())
    return {name: list(_rows(text)) for name, text in texts.items()}


def _rows(text: str) -> Iterator[str]:
    """The lines, with the signs visible that are none on paper."""
    for line in text.replace("\r", "\\r").replace("\x1b", "\\e").split("\n"):
        yield _LONG_NUMBER.sub(lambda found: f"{float(found[0]):.9f}", line)


def tells_what_is_declared(it: ReportUnderTest) -> Iterator[Difference]:
    """What `samples/up20/reports/NAME.report` declares of the timings made by hand is what is told"""
    place = _DECLARED / f"{it.name}.report"
    if not place.exists():
        return
    found = _reports_of(it)
    for name, wanted in load_declared(place).items():
        for at, a, b in differences(wanted, found.get(name, [])):
            yield f"{place.name}, {name}, line {at}", f"declared: {a}; told: {b}"


PROMISES: Final[tuple[Promise[ReportUnderTest], ...]] = (
    says_what_it_is,
    names_every_file,
    tells_every_step,
    keeps_cells_apart,
    lines_columns_up,
    tells_the_sums,
    tells_what_is_behind,
    paints_what_differs,
    stands_a_failed_file,
    joins_what_it_is_given,
    tells_what_is_declared,
)
