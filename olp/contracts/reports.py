"""What every report format promises: `check_report`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Final

from olp.contracts.promises import Difference, Promise, hold
from olp.reports.batch import Job, time_files
from olp.reports.formats import Options, Report, ReportPart, load_report, report_names

FILES: Final = tuple(
    Path(__file__).resolve().parents[2] / "samples" / "up20" / f"{name}.JBI" for name in ("APPR-1", "DEPT-2")
)
ROBOT: Final = "yaskawa/up20"
_MISSING: Final = "gone/no-such-program.jbi"


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

    @cached_property
    def whole(self) -> str:
        return self.text()[0]


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
    if "nan" in re.findall(r"[a-z]+", text.lower()):
        yield "two programs", "a number that is none"


def tells_the_times(it: ReportUnderTest) -> Iterator[Difference]:
    """The numbers of the timing are in the report: of each segment, or with --no-segments of each file"""
    text, parts = it.text()
    numbers = [float(x) for x in re.findall(r"(?<![\w.])\d+\.\d+", text)]
    for part in parts:
        assert part.total_s is not None
        if not _told(numbers, part.total_s) and not _summed(numbers, part.total_s):
            yield part.file, f"its total of {part.total_s:.3f} s is not in the report, nor its parts"
    short, _ = it.text(Options(segments=False))
    if len(short) >= len(text):
        yield "segments=False", f"{len(short)} characters, {len(text)} with segments"
    if any(path.name not in short for path in FILES):
        yield "segments=False", "a file is missing"


def _told(numbers: list[float], value: float) -> bool:
    return any(abs(one - value) < 6e-4 for one in numbers)


def _summed(numbers: list[float], value: float) -> bool:
    return len(numbers) > 20 and max(numbers) > 0.5 * value


def stands_a_failed_file(it: ReportUnderTest) -> Iterator[Difference]:
    """A file that cannot be read does not stop the others, and the report does not pass it over"""
    text, parts = it.text(None, _MISSING)
    if [part.failed for part in parts] != [False, False, True]:
        yield _MISSING, f"failed: {[part.failed for part in parts]}"
    if any(path.name not in text for path in FILES):
        yield _MISSING, "the other files are not in the report"


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


def keeps_to_what_was_asked(it: ReportUnderTest) -> Iterator[Difference]:
    """No colour where none was asked for, and no character that steers a terminal"""
    if "\x1b" in it.whole:
        yield "colour=False", "control characters"
    strange = [c for c in it.whole if not c.isprintable() and c not in "\n\t"]
    if strange:
        yield "two programs", f"the character {strange[0]!r}"


PROMISES: Final[tuple[Promise[ReportUnderTest], ...]] = (
    says_what_it_is,
    names_every_file,
    tells_the_times,
    stands_a_failed_file,
    joins_what_it_is_given,
    keeps_to_what_was_asked,
)
