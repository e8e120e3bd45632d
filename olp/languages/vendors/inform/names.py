"""Names of //ALIAS inside an instruction.

Such a name may hold blanks or be a word of the language. It is rewritten, character by character, into a range of
Unicode that no text uses, so that the grammar sees one name and all columns stay where they are.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

_SHIFT = 0xE000
_LAST_SHIFTED = 0x18FF
_PLAIN = re.compile(r"[^\W\d]\w*")
_SHAPED = re.compile(r"L?(?:PX|BP|EX|[BIDRSP])\d+|(?:BC|EC|C|E)\d+|SUB\d+|T\d{5}|ARGF.*")


def mangle(name: str) -> str:
    """The name as private characters, one for one."""
    return "".join(chr(_SHIFT + ord(c)) if ord(c) <= _LAST_SHIFTED else c for c in name)


def unmangle(name: str) -> str:
    """The name as it was written."""
    if name.isascii():
        return name
    return "".join(chr(ord(c) - _SHIFT) if _SHIFT <= ord(c) <= _SHIFT + _LAST_SHIFTED else c for c in name)


def is_plain(name: str) -> bool:
    """Whether the grammar reads the name as one without help."""
    return _PLAIN.fullmatch(name) is not None and _SHAPED.fullmatch(name) is None


class Mangler:
    """Rewrites some names wherever they stand alone in a line, the longest first."""

    def __init__(self, names: Iterable[str]) -> None:
        ordered = sorted(names, key=len, reverse=True)
        alternatives = "|".join(re.escape(name) for name in ordered)
        # ARGF stands glued to its value; strings and comments are passed over as wholes.
        self._pattern = re.compile(
            rf"""("[^"]*"|'.*|//.*)|(?:(?<![\w#*:])|(?<=ARGF))({alternatives})(?!\w)"""
            if ordered
            else r"(?!)"
        )

    def __call__(self, line: str) -> str:
        return self._pattern.sub(lambda match: match[1] or mangle(match[2]), line)
