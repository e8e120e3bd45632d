"""Where a name comes into being and where it is used: in the text itself and in the files that belong to it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from olp.core.source import Source
from olp.ir.program import Program, Routine
from olp.languages.tokens import TokenKind, Word, Words
from olp.languages.vendor import part_of


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
