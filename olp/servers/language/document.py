"""A text that somebody is editing: lines and their ends, changed in place."""

from __future__ import annotations

import re
from itertools import chain
from typing import NamedTuple

from olp.core.source import Source
from olp.ir.program import Program
from olp.languages.vendor import find_vendor, read_source, recognise, vendor_names

_LINE = re.compile(r"([^\r\n]*)(\r\n|\n|\r|\Z)")


class Place(NamedTuple):
    """Between two characters: `column` 1 stands before the first one of the line."""

    line: int
    column: int


class TextChange(NamedTuple):
    """The text from `start` to `stop` is replaced by `text`."""

    start: Place
    stop: Place
    text: str


class Splice(NamedTuple):
    """Effect of a change on the lines: from line `first` on, `removed` lines were replaced by `added` ones."""

    first: int
    removed: int
    added: int

    def moved(self, line: int) -> int | None:
        """The new number of the line, None if its text may have changed."""
        if line < self.first:
            return line
        return line + self.added - self.removed if line >= self.first + self.removed else None


class OpenDocument:
    """The text of the file `path`, which need not exist. `language`: as the editor calls it. `version`: its count.

    `edition` counts the changes of this object, whatever the editor counts.
    """

    def __init__(self, path: str, text: str, language: str = "", version: int = 0) -> None:
        self.path = path
        self.language = language
        self.version = version
        self.edition = 0
        self.splices: list[Splice] = []  # since somebody has emptied the list
        self._raw: bytes | None = None
        self._lines, self._ends = _split(text)

    def __len__(self) -> int:
        return len(self._lines)

    def line(self, number: int) -> str:
        """Line `number` without its end; empty outside of the text."""
        return self._lines[number - 1] if 0 < number <= len(self._lines) else ""

    @property
    def text(self) -> str:
        return "".join(chain.from_iterable(zip(self._lines, self._ends, strict=True)))

    @property
    def raw(self) -> bytes:
        """The text in UTF-8."""
        if self._raw is None:
            self._raw = self.text.encode("utf-8", "surrogatepass")
        return self._raw

    def source(self) -> Source:
        """The text as a file of that path would hold it."""
        raw = self.raw
        # Behind the last line end an editor shows one more, empty line.
        lines = self._lines if self._lines[-1] else self._lines[:-1]
        return Source(self.path, raw, "ascii" if raw.isascii() else "utf-8", tuple(lines))

    def replace(self, text: str) -> None:
        """All of it at once."""
        before = len(self._lines)
        self._lines, self._ends = _split(text)
        self._changed(Splice(1, before, len(self._lines)))

    def change(self, change: TextChange) -> None:
        """One edit; places outside of the text mean its nearest place."""
        start, stop = sorted((self.clamped(change.start), self.clamped(change.stop)))
        first, last = start.line - 1, stop.line - 1
        left, right = self._lines[first][: start.column - 1], self._lines[last][stop.column - 1 :]
        piece = left + change.text + right + self._ends[last]
        # A carriage return that now stands before a line feed is one line end with it.
        if piece.endswith("\r") and self._ends[last + 1 : last + 2] == ["\n"] and not self._lines[last + 1]:
            last += 1
            piece += "\n"
        if first and piece.startswith("\n") and self._ends[first - 1] == "\r":
            first -= 1
            piece = self._lines[first] + "\r" + piece
        lines, ends = _split(piece)
        if last + 1 < len(self._lines):  # the piece has its own end: what follows begins behind it
            lines.pop()
            ends.pop()
        self._lines[first : last + 1] = lines
        self._ends[first : last + 1] = ends
        self._changed(Splice(first + 1, last + 1 - first, len(lines)))

    def clamped(self, place: Place) -> Place:
        """The nearest place of the text."""
        line = min(max(place.line, 1), len(self._lines))
        if place.line > len(self._lines):
            return Place(line, len(self._lines[-1]) + 1)
        return Place(line, min(max(place.column, 1), len(self._lines[line - 1]) + 1))

    def _changed(self, splice: Splice) -> None:
        self.edition += 1
        self._raw = None
        self.splices.append(splice)


def _split(text: str) -> tuple[list[str], list[str]]:
    """Lines and their ends; the last line has none and may be empty."""
    found = _LINE.findall(text)
    lines, ends = [line for line, _ in found], [end for _, end in found]
    # The pattern matches once more, at the very end of a text whose last line is not empty.
    if len(lines) > 1 and not ends[-2]:
        lines.pop()
        ends.pop()
    return lines, ends


# --- Edits ---
# Changes of a text that an editor is offered.


class TextEdit(NamedTuple):
    """The text from (line, column) to (end_line, end_column) becomes `text`."""

    line: int
    column: int
    end_line: int
    end_column: int
    text: str


class Action(NamedTuple):
    """A quick fix: `code` of the finding it is for; `preferred` where it is what most people want."""

    title: str
    code: str
    edits: tuple[TextEdit, ...]
    preferred: bool = False


# --- Reading ---
# The program in a text of an editor: the language is what the editor says, else what the file looks like.


def vendor_of(source: Source, language: str) -> str | None:
    """The vendor's name: from the file's suffix, else the editor's language, else the text. None: unknown."""
    said, known = language.casefold(), vendor_names()
    said = next((name for name in known if said in find_vendor(name).editor_names), said)
    by_suffix = [name for name in known if source.path.lower().endswith(find_vendor(name).suffixes)]
    if said in known and (not by_suffix or said in by_suffix):
        return said
    found = recognise(source)
    return found.name if found is not None else None


def read_document(source: Source, language: str) -> Program:
    """The program. Raises OlpError (P002) for an unknown language."""
    return read_source(source, vendor=vendor_of(source, language))
