"""Places between the protocol and olp: lines from 0 there and from 1 here, columns in code units and in characters."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from urllib.parse import unquote, urlsplit

from lsprotocol import types
from pygls.uris import from_fs_path, to_fs_path

from olp.servers.language.document import OpenDocument, Place, TextChange

Line = Callable[[int], str]  # the text of a line, counted from 1
Json = dict[str, Any]


class Places:
    """`encoding`: the unit of columns that client and server have agreed on (utf-8, utf-16, utf-32)."""

    def __init__(self, encoding: str = "utf-16") -> None:
        self.encoding = encoding

    def units(self, text: str, column: int) -> int:
        """Code units before `column` of a line."""
        before = text[: column - 1]
        if self.encoding == "utf-32" or before.isascii():
            return len(before)
        if self.encoding == "utf-8":
            return len(before.encode("utf-8", "surrogatepass"))
        return len(before) + sum(ord(c) > 0xFFFF for c in before)

    def column(self, text: str, units: int) -> int:
        """The column behind that many code units of a line; its end where it is shorter."""
        if self.encoding == "utf-32" or text.isascii():
            return min(units, len(text)) + 1
        width = _utf8 if self.encoding == "utf-8" else _utf16
        for column, character in enumerate(text, 1):
            units -= width(character)
            if units < 0:
                return column
        return len(text) + 1

    def place(self, line: Line, position: types.Position) -> Place:
        return Place(position.line + 1, self.column(line(position.line + 1), position.character))

    def position(self, line: Line, number: int, column: int) -> Json:
        return {"line": max(number, 1) - 1, "character": self.units(line(number), column)}

    def range(self, line: Line, number: int, column: int = 1, end_column: int = 0) -> Json:
        """Of one line; `end_column` 0: to its end."""
        text = line(number)
        stop = end_column or len(text) + 1
        return {
            "start": self.position(line, number, column),
            "end": self.position(line, number, max(stop, column)),
        }

    def change(
        self, document: OpenDocument, change: types.TextDocumentContentChangeEvent
    ) -> TextChange | str:
        if isinstance(change, types.TextDocumentContentChangeWholeDocument):
            return change.text
        start = self.place(document.line, change.range.start)
        return TextChange(start, self.place(document.line, change.range.end), change.text)


def _utf8(character: str) -> int:
    return len(character.encode("utf-8", "surrogatepass"))


def _utf16(character: str) -> int:
    return 1 + (ord(character) > 0xFFFF)


def path_of(uri: str) -> str:
    """The file that a URI means; the URI itself where it means none."""
    try:
        return to_fs_path(uri) or uri
    except ValueError:
        return uri


def uri_of(path: str) -> str:
    """The URI of a path, or of what `path_of` gave back as it was."""
    if urlsplit(path).scheme not in ("", "file") and len(urlsplit(path).scheme) > 1:
        return path
    return from_fs_path(path) or path


def same_uri(first: str, second: str) -> bool:
    """Whether two spellings of a URI are one."""
    return unquote(first) == unquote(second)
