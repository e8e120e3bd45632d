"""Colour for terminals, by the ANSI codes that all of them understand. Never in files and pipes."""

from __future__ import annotations

import os
import sys
from typing import Final, TextIO

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
