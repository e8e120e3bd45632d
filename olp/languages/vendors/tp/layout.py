"""TP: lines numbered one after the other, in four columns, as the controller writes them."""

from __future__ import annotations

import re
from collections.abc import Sequence

from olp.languages.layout import Layout

_NUMBERED = re.compile(r"\s*\d+:(.*)")
_MAIN, _ENDS = re.compile(r"\s*/MN\b"), re.compile(r"\s*/(?:POS|END)\b")


class TpLayout(Layout):
    def lines(self, lines: Sequence[str], indent: str) -> list[str]:
        found: list[str] = []
        number = 0
        inside = False
        for line in lines:
            inside = _MAIN.match(line) is not None or (inside and _ENDS.match(line) is None)
            match = _NUMBERED.fullmatch(line) if inside else None
            if match is not None:
                number += 1
                line = f"{number:4d}:{match[1].rstrip()}"
            found.append(line)
        return found


LAYOUT = TpLayout()
