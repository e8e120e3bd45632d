"""What leaves as text: bytes of a file, cells of a table, and what a terminal may be shown.

Names, comments and messages come from programs. A terminal obeys control characters, some signs turn the direction
of a text so that it reads as another, and a spreadsheet computes what begins like a formula.
"""

from __future__ import annotations

import csv
import io
import os
import re
import sys
from collections.abc import Iterable
from typing import Final, TextIO

# Controls but line feed and tab, the C1 controls, directions of text, lone surrogates (of names that are no text).
_SIGNS = "\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff"
_UNSAFE = re.compile(f"[{_SIGNS}]")
_OWN_STYLE = re.compile(f"(\x1b\\[[0-9;]*m)|[{_SIGNS}]")  # what olp.core.colour writes stays


def visible(text: str) -> str:
    """`text` with every sign that would steer a terminal written as its code, such as \\x1b."""
    return _UNSAFE.sub(_code, text)


def utf8(text: str) -> bytes:
    """The bytes of a file; bytes of names that were no text are written as their codes."""
    return text.encode("utf-8", "backslashreplace")


def shown(text: str) -> bytes:
    """What standard output takes: in its encoding, and if it is a terminal, nothing that steers it."""
    if sys.stdout.isatty():
        text = _OWN_STYLE.sub(lambda found: found[1] or _code(found), text)
    text = text.encode("utf-8", "backslashreplace").decode("utf-8")
    return text.encode(sys.stdout.encoding or "utf-8", "replace")


class Screen(io.TextIOWrapper):
    """A text stream to a terminal that passes no control but line feeds, tabs and olp's own styles."""

    def write(self, text: str, /) -> int:
        return super().write(_OWN_STYLE.sub(lambda found: found[1] or _code(found), text))


def _code(found: re.Match[str]) -> str:
    return found[0].encode("unicode_escape").decode("ascii")


# --- Tables ---
# Cells of CSV that a spreadsheet would compute get an apostrophe in front, and lose it when they are read.

_FORMULA = re.compile(r"'*[=+\-@\t\r]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Rows as CSV, in which no text is a formula."""
    text = io.StringIO()
    plain = csv.writer(text, lineterminator="\n")
    quoted = csv.writer(text, lineterminator="\n", quoting=csv.QUOTE_ALL)
    for row in rows:
        cells = [to_cell(value) for value in row]
        returns = any(
            isinstance(cell, str) and "\r" in cell for cell in cells
        )  # Python before 3.13 quotes none
        (quoted if returns else plain).writerow(cells)
    return text.getvalue()


def to_cell(value: object) -> object:
    """`value` as a cell that shows what it is: a text that would be computed is marked as text."""
    if not isinstance(value, str) or not _FORMULA.match(value) or _NUMBER.fullmatch(value):
        return value
    return f"'{value}"


def from_cell(text: str) -> str:
    """The text that `to_cell` made a cell of."""
    return text[1:] if text.startswith("'") and _FORMULA.match(text) else text


# --- Colour ---
# Colour for terminals, by the ANSI codes that all of them understand. Never in files and pipes.

BOLD: Final = "1"
DIM: Final = "2"
RED: Final = "31"
YELLOW: Final = "33"


def paint(text: str, style: str) -> str:
    """`text` in a style."""
    return f"\x1b[{style}m{text}\x1b[0m" if text else text


def wanted(stream: TextIO) -> bool:
    """Whether somebody watches `stream` on a terminal that shows colour (https://no-color.org is respected)."""
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb" or not stream.isatty():
        return False
    if sys.platform == "win32":
        # An empty command makes older Windows consoles interpret the codes.
        os.system("")
    return True
