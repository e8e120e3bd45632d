"""Parts of a three-way merge: settled lines, and hunks in which the user has to choose."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

_OTHER = {"ours": "theirs", "theirs": "ours"}
_SIDES = re.compile(r"\b(?:ours|theirs)\b")


class TextLine(NamedTuple):
    text: str
    end: str | None  # None: the next line goes on with it


@dataclass(frozen=True, slots=True)
class Hunk:
    """A conflict: both sides changed the same part. `what`: a point, a statement, a record; `name`: its name, if
    any.

    `ours_at`, `theirs_at`: the lines of each version that take time with it, from 1.
    """

    what: str
    name: str
    why: str
    ours: tuple[TextLine, ...]
    theirs: tuple[TextLine, ...]
    base: tuple[str, ...] = ()
    ours_at: tuple[int, ...] = ()
    theirs_at: tuple[int, ...] = ()

    @property
    def height(self) -> int:
        """Number of lines in the file, including the markers."""
        return len(self.ours) + len(self.theirs) + 3

    def swapped(self) -> Hunk:
        """The same hunk with the sides exchanged."""
        why = _SIDES.sub(lambda match: _OTHER[match[0]], self.why)
        sides = (self.theirs, self.ours, self.base, self.theirs_at, self.ours_at)
        return Hunk(self.what, self.name, why, *sides)


@dataclass(frozen=True, slots=True)
class TakenChanges:
    """Changes taken from one side: names of the changed points, and the number of changed statements."""

    points: tuple[str, ...] = ()
    statements: int = 0


class SharedStatement(NamedTuple):
    """A statement, on a line of the merge, with changes of both sides: the arguments that each changed.

    Empty: that side's change is contained in the other's.
    """

    line: int
    ours: tuple[str, ...]
    theirs: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class MergedText:
    """A merge. `ended`: whether the last line has a line end (None: unchanged). `taken`: by "ours", "theirs" and
    "both" (the same change). `renamed`: names that either side renamed, before and now. `shared`: statements with
    changes of both. `pack`: converts the text to the file; impossible with hunks.
    """

    parts: tuple[TextLine | Hunk, ...]
    newline: str = "\n"
    ended: bool | None = None
    taken: Mapping[str, TakenChanges] = field(default_factory=dict)
    renamed: Mapping[str, tuple[tuple[str, str], ...]] = field(default_factory=dict)
    shared: tuple[SharedStatement, ...] = ()
    pack: Callable[[bytes], bytes] | None = field(default=None, compare=False)

    @property
    def hunks(self) -> tuple[Hunk, ...]:
        return tuple(part for part in self.parts if isinstance(part, Hunk))

    def swapped(self) -> MergedText:
        """The same merge with the sides exchanged."""
        parts = tuple(part.swapped() if isinstance(part, Hunk) else part for part in self.parts)
        taken = {word: self.taken[_OTHER.get(word, word)] for word in self.taken}
        renamed = {word: self.renamed[_OTHER[word]] for word in self.renamed}
        shared = tuple(one._replace(ours=one.theirs, theirs=one.ours) for one in self.shared)
        return replace(self, parts=parts, taken=taken, renamed=renamed, shared=shared)

    def to_bytes(self, labels: Callable[[int, Hunk], tuple[str, str]] | None = None, size: int = 7) -> bytes:
        """The file; for a packed one with hunks its text. `labels`: of each hunk's two sides; `size`: length of a
        marker.
        """
        found: list[TextLine] = []
        number = 0
        for part in self.parts:
            if isinstance(part, TextLine):
                found.append(part)
                continue
            ours, theirs = labels(number, part) if labels else ("ours", "theirs")
            number += 1
            found.append(TextLine(f"{'<' * size} {ours}", self.newline))
            found += part.ours
            found.append(TextLine("=" * size, self.newline))
            found += part.theirs
            found.append(TextLine(f"{'>' * size} {theirs}", self.newline))
        last = len(found) - 1
        if found and self.ended is not None:
            found[-1] = TextLine(found[-1].text, (found[-1].end or self.newline) if self.ended else "")
        whole = (
            text if end is None else text + (end or (self.newline if at < last else ""))
            for at, (text, end) in enumerate(found)
        )
        data = "".join(whole).encode("latin-1", "replace")
        return data if self.pack is None or self.hunks else self.pack(data)
