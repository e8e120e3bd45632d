"""Definitions, references and the outline of a text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from olp.core.diagnostic import OlpError
from olp.core.source import Source, load
from olp.ir.program import Program, Routine
from olp.languages.tokens import TokenKind, Word, Words
from olp.languages.vendor import find_vendor, part_of
from olp.runtime.folder import files_by_name_record, files_by_stem, read_cached
from olp.servers.language.analysis import Analysis
from olp.servers.language.document import vendor_of
from olp.servers.language.service import ProgramService

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
    """Where the name at a place comes into being, in this text or another file."""
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
    """The file that is called like a routine, or whose head names it."""
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
