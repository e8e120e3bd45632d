"""RAPID's string literals: quotes and backslashes are doubled, other characters may be two hexadecimal digits."""

from __future__ import annotations

import re
from typing import Final

_ESCAPE: Final = re.compile(r'""|\\\\|\\([0-9A-Fa-f]{2})')
_SPECIAL: Final = re.compile(r'["\\\x00-\x1f]')


def unquoted(literal: str) -> str:
    """The text of a literal with its quotes."""
    return _ESCAPE.sub(lambda m: chr(int(m[1], 16)) if m[1] else m[0][0], literal[1:-1])


def quoted(text: str) -> str:
    """The literal of a text."""

    def escaped(match: re.Match[str]) -> str:
        character = match[0]
        return character * 2 if character in '"\\' else f"\\{ord(character):02X}"

    return f'"{_SPECIAL.sub(escaped, text)}"'
