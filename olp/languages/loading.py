"""What a controller refuses when it loads a program: the shape of a vendor's checks, and what all of them share.

A vendor that has them puts `LOAD`, one `Loading`, into `load.py` of its folder. Checks read the text, for a program
that a controller refuses is often one that no reader understands. Codes: K1nn, explained in docs/lint.md.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Final, NamedTuple

from olp.core.diagnostic import Diagnostic, OlpError, Severity, Span
from olp.core.source import Source, load
from olp.languages.vendor import Vendor

# Files of a cell beyond these are not read.
_MOST_FILES: Final = 400
_MOST_BYTES: Final = 20_000_000
_ENOUGH_NAMES: Final = 12  # that are found, before those that are not are believed to be missing
MOST_MISSING: Final = 0.12  # share of the names that a cell whose files are all there may lack


_OWN: Final = (
    "the variable",
    "the routine",
    "the function",
)  # that a program declares itself, unlike its tools
_SHORTEST, _LONG, _LETTERS = 4, 8, 2  # letters of a name, of a long one, and by which this may differ
_DIGITS: Final = re.compile(r"\d+")  # names that differ in their numbers are different names


@dataclass(frozen=True, slots=True)
class LoadedCell:
    """The files that a controller loads with a program, that one first. `controller`: as `--controller` says.
    `above`: those in the folder above, where a project may keep what all its programs share."""

    sources: tuple[Source, ...]
    controller: str
    above: tuple[Source, ...] = ()


class WrongForm(NamedTuple):
    """A form that the loader refuses: what matches, and what is told of it."""

    pattern: re.Pattern[str]
    code: str
    says: str
    help: str


@dataclass(slots=True)
class LoadFindings:
    """What a check has to say of one source. `unknown`: names that nothing declares, with where they stand.

    `doubtful`: those that the controller's configuration may declare: told only where one is nearly a declared name.
    """

    source: Source
    diagnostics: list[Diagnostic] = field(default_factory=list)
    unknown: list[tuple[str, Span, str]] = field(default_factory=list)
    doubtful: list[tuple[str, Span, str]] = field(default_factory=list)
    known: set[str] = field(default_factory=set)  # names that are used and declared

    def tell(
        self, code: str, message: str, span: Span, help: str = "", severity: Severity = Severity.ERROR
    ) -> None:
        line = self.source.line(span.line)
        self.diagnostics.append(Diagnostic(code, message, severity, self.source.path, *span, help, line))

    def whole_line(self, number: int) -> Span:
        """The text of a line, without the blanks around it."""
        line = self.source.line(number)
        return Span(number, len(line) - len(line.lstrip()) + 1, len(line.rstrip()) + 1)

    def place_of(self, number: int, name: str) -> Span:
        """Where a name stands in a line; its beginning where it does not."""
        match = re.search(rf"(?<![\w$]){re.escape(name)}(?!\w)", self.source.line(number))
        at = match.start() + 1 if match else 1
        return Span(number, at, at + len(name))

    def too_long(self, what: str, name: str, span: Span, most: int) -> None:
        """Tells a name of more than `most` characters, a sign of its type not counted."""
        size = len(name.lstrip("#$.*"))
        if size > most:
            self.tell("K103", f"the {what} {name[:40]} has {size} characters", span, f"{most} at most")

    def wrong_forms(self, forms: Iterable[WrongForm], number: int, code: str) -> None:
        """Tells the forms that a line's code, without its texts and comments, has and may not have."""
        for form in forms:
            if match := form.pattern.search(code):
                span = Span(number, match.start() + 1, match.end() + 1)
                self.tell(form.code, form.says, span, form.help)

    def doubles(
        self, names: Iterable[tuple[str, str, Span]], help: str = "call one of them otherwise"
    ) -> None:
        """Tells what stands twice. `names`: what must be unique, what is shown of it, and where it stands."""
        first: dict[str, Span] = {}
        for key, shown, span in names:
            if first.setdefault(key, span) != span:
                self.tell("K102", f"{shown} stands in line {first[key].line} already", span, help)

    def arguments(self, name: str, span: Span, takes: tuple[int, int], given: int) -> None:
        """Tells a wrong number of arguments; a negative one is unknown. `takes`: at least and at most."""
        least, most = takes
        if given < 0 or least <= given <= most:
            return
        count = f"{least} to {most}" if least < most else str(most)
        says = f"{name} takes {count} argument{'s' if most != 1 else ''}, and {given} are given"
        self.tell("K112", says, span)

    def finish(
        self, declared: Iterable[str], whole: bool, shared: bool = False, complete: bool = False
    ) -> list[Diagnostic]:
        """All findings by line. Unknown names are errors in a cell whose files are all there, else warnings where the
        name is nearly one that is declared or nearly all others are, else nothing.

        `declared`: every name that the cell has. `whole`: whether the cell says itself that nothing is missing.
        `shared`: whether names that a program declares itself in other languages may stand in a list that is not here.
        `complete`: whether all files of the cell together declare nearly all that they name.
        """
        names = {name.casefold() for name, _, _ in self.unknown}
        total = len(names) + len(self.known)
        mostly = (
            not shared and len(self.known) >= _ENOUGH_NAMES and len(names) <= max(1, MOST_MISSING * total)
        )
        spellings = {name.casefold(): name for name in sorted(declared)}
        told: set[str] = set()
        for name, span, what in (*self.unknown, *self.doubtful):
            if name.casefold() in told:
                continue
            told.add(name.casefold())
            near = get_close_matches(
                name.casefold(), [s for s in spellings if is_near(s, name.casefold())], 1, 0.0
            )
            certain = name.casefold() in names and (whole or complete or (mostly and what in _OWN))
            if not (near or certain):
                continue
            help = (
                f"did you mean {spellings[near[0]]}?"
                if near
                else "declare it, or put the file that does beside"
            )
            self.undeclared(f"{what} {name[:60]} is declared nowhere", span, help, whole)
        return sorted(self.diagnostics, key=lambda d: (d.line, d.column, d.code))

    def undeclared(self, says: str, span: Span, help: str, whole: bool) -> None:
        """A name that nothing declares: an error where all files are there (`whole`), else a warning."""
        self.tell("K101", says, span, help, Severity.ERROR if whole else Severity.WARNING)


def given_arguments(code: Sequence[str], opened: int) -> int:
    """How many arguments stand in the brackets that open at a place, -1 where these are not closed.

    `code`: the characters of a line or its tokens, without texts and comments.
    """
    depth = commas = 0
    for i in range(opened, len(code)):
        depth += (code[i] in ("(", "[", "{")) - (code[i] in (")", "]", "}"))
        if not depth:
            return commas + 1 if any(one.strip() for one in code[opened + 1 : i]) else 0
        commas += code[i] == "," and depth == 1
    return -1


def is_near(one: str, name: str) -> bool:
    """Whether two names are probably one, mistyped: their numbers agree, and one letter differs, or two of a long name.

    What only goes on is another name, and so is what has another first or last letter in one of its parts: nCount and
    sCount are of two types, PICK_L and PICK_R of a series.
    """
    short, long = sorted((one, name), key=len)
    if short == long or len(short) < _SHORTEST or len(long) - len(short) > _LETTERS:
        return False
    if _DIGITS.findall(one) != _DIGITS.findall(name) or (
        long.startswith(short) and len(long) - len(short) > 1
    ):
        return False
    differ = [i for i, (a, b) in enumerate(zip(one, name, strict=False)) if a != b]
    if len(one) == len(name) and len(differ) == 1 and not _is_inside(one, differ[0]):
        return False
    return _distance(short, long) <= (_LETTERS if len(short) >= _LONG else 1)


def _is_inside(name: str, at: int) -> bool:
    """Whether letters stand on both sides of a letter."""
    return name[:at][-1:].isalpha() and name[at + 1 :][:1].isalpha()


def _distance(one: str, other: str) -> int:
    """How many letters are to be changed, added, taken out, or swapped with the next."""
    before: list[int] = []
    row = list(range(len(other) + 1))
    for i, a in enumerate(one, 1):
        earlier, before, row = before, row, [i]
        for j, b in enumerate(other, 1):
            best = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (a != b))
            if i > 1 and j > 1 and a == other[j - 2] and one[i - 2] == b:
                best = min(best, earlier[j - 2] + 1)
            row.append(best)
    return row[-1]


@dataclass(frozen=True, slots=True)
class Loading:
    """A vendor's checks. `controllers`: what `--controller` may say, the usual one first."""

    controllers: tuple[str, ...]
    check: Callable[[Source, LoadedCell], list[Diagnostic]]
    suffixes: tuple[str, ...] = ()  # of further files that declare names
    looks_above: bool = False  # whether the folder above may declare names, too

    def refused(self, source: Source, vendor: Vendor, controller: str = "") -> list[Diagnostic]:
        """What a controller refuses of a program, with the files that it loads with it."""
        return self.check(source, _cell_of(source, vendor, self, controller))


def _cell_of(source: Source, vendor: Vendor, loading: Loading, controller: str) -> LoadedCell:
    """The program with the files that a controller loads with it."""
    sources: tuple[Source, ...] = (source,)
    above: tuple[Source, ...] = ()
    path = Path(source.path) if source.path else None
    if path is not None and path.is_file():
        suffixes = (*vendor.suffixes, *vendor.list_suffixes, *loading.suffixes)
        sources += _loaded(_others(path, vendor.folders_with(path.parent), suffixes))
        if loading.looks_above:
            above = _loaded(_others(path, (path.parent.parent,), suffixes))
    return LoadedCell(sources, controller or loading.controllers[0], above)


def _loaded(paths: Iterable[Path]) -> tuple[Source, ...]:
    """What can be read of the files, until there are too many."""
    sources: list[Source] = []
    size = 0
    for path in paths:
        size += path.stat().st_size
        if len(sources) >= _MOST_FILES or size > _MOST_BYTES:
            break
        try:
            sources.append(load(path))
        except OlpError:
            continue
    return tuple(sources)


def _others(path: Path, folders: Iterable[Path], suffixes: Sequence[str]) -> Iterable[Path]:
    for folder in folders:
        for one in sorted(folder.iterdir()) if os.access(folder, os.R_OK | os.X_OK) else ():
            if one.suffix.lower() in suffixes and one.is_file() and not one.samefile(path):
                yield one
