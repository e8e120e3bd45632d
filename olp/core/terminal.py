"""Text for output: cells of a table, and text that is safe for a terminal.

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

from olp.core.diagnostic import visible_styled


class Screen(io.TextIOWrapper):
    """A text stream to a terminal that passes no control characters except line feeds, tabs and olp's own styles."""

    def write(self, text: str, /) -> int:
        return super().write(visible_styled(text))


# --- Tables ---
# Cells of CSV that a spreadsheet would compute get an apostrophe in front, and lose it when they are read.

_FORMULA = re.compile(r"'*[=+\-@\t\r]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Return the rows as CSV in which a spreadsheet takes no text for a formula."""
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
    """Return `value` as a cell; a text that a spreadsheet would take for a formula gets an apostrophe in front."""
    if not isinstance(value, str) or not _FORMULA.match(value) or _NUMBER.fullmatch(value):
        return value
    return f"'{value}"


def from_cell(text: str) -> str:
    """Return the text that `to_cell` was given."""
    return text[1:] if text.startswith("'") and _FORMULA.match(text) else text


# --- Colour ---
# Colour for terminals, by the ANSI codes that all of them understand. Never in files and pipes.

BOLD: Final = "1"
DIM: Final = "2"
RED: Final = "31"
YELLOW: Final = "33"


def paint(text: str, style: str) -> str:
    """Return `text` with the terminal codes of `style` around it."""
    return f"\x1b[{style}m{text}\x1b[0m" if text else text


def wanted(stream: TextIO) -> bool:
    """Return whether `stream` is a terminal that shows colour; the variable NO_COLOR (https://no-color.org) turns
    it off.
    """
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb" or not stream.isatty():
        return False
    if sys.platform == "win32":
        # An empty command makes older Windows consoles interpret the codes.
        os.system("")
    return True
