"""How corners are written in a line of a program, so that one can be rounded or made smaller. Per language, as text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple


class _Words(NamedTuple):
    """`comment`: where one begins. `exact`: an exact stop, and what rounds it least. `zone`: a number, its group 1.

    `sizes`: the usual numbers, smallest first; empty: any, so that it is halved.
    """

    comment: str
    exact: tuple[str, str]
    zone: str
    sizes: tuple[float, ...] = ()


# PL of INFORM and zones of RAPID are those of their manuals; CNT of TP is a percentage, r of URScript metres.
_LANGUAGES = {
    "inform": _Words(r"//|^\s*'", (r"\bPL=0\b", "PL=1"), r"\bPL=(\d)\b", (1, 2, 3, 4, 5, 6, 7, 8)),
    "rapid": _Words(
        r"!", (r"\bfine\b", "z1"), r"\bz(\d+)\b", (1, 5, 10, 15, 20, 30, 40, 50, 60, 80, 100, 150, 200)
    ),
    "tp": _Words(r"!|//", (r"\bFINE\b", "CNT10"), r"\bCNT(\d+)\b", (5, 10, 25, 50, 75, 100)),
    "krl": _Words(r";", (r"\b(LIN|CIRC)(?:_REL)?\b.*\S(?=\s*$)", r"\g<0> C_DIS"), r"(?!)"),
    "urscript": _Words(r"#", (r"\)(?=\s*$)", ", r=0.001)"), r"\br=(0?\.\d+)\b"),
}


def rounded(vendor: str, text: str) -> str | None:
    """The line with its exact stop rounded as little as the language can say; None where it has none."""
    words = _LANGUAGES.get(vendor)
    if words is None:
        return None
    code, comment = _split(text, words)
    changed, count = re.subn(*words.exact, code, count=1)
    if not count or re.search(words.zone, code):
        # A stop of INFORM is a level too, of the others it is a word of its own.
        return changed + comment if count and vendor == "inform" else None
    return changed + comment


def smaller(vendor: str, text: str) -> Iterator[str]:
    """The line with smaller zones, the largest of them first."""
    words = _LANGUAGES.get(vendor)
    if words is None:
        return
    code, comment = _split(text, words)
    found = re.search(words.zone, code)
    if found is None:
        return
    size = float(found[1])
    sizes = [one for one in words.sizes if one < size][::-1] or [size / 2**n for n in range(1, 6)]
    if words.sizes and size <= words.sizes[0]:
        return
    for one in sizes:
        yield f"{code[: found.start(1)]}{one:.4g}{code[found.end(1) :]}{comment}"


def _split(text: str, words: _Words) -> tuple[str, str]:
    found = re.search(words.comment, text)
    return (text, "") if found is None else (text[: found.start()], text[found.start() :])
