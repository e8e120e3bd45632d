"""Changes the zone in a line of a program, as text in the vendor's syntax: rounds a corner, or makes it smaller."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from olp.languages.vendor import CornerSpelling, find_vendor


def rounded(vendor: str, text: str) -> str | None:
    """The line with its exact stop replaced by the smallest zone of the language; None if it has no exact stop."""
    words = find_vendor(vendor).corners
    if words is None:
        return None
    code, comment = _split(text, words)
    changed, count = re.subn(*words.exact, code, count=1)
    if not count or re.search(words.zone, code):
        return changed + comment if count and words.exact_is_zone else None
    return changed + comment


def smaller(vendor: str, text: str) -> Iterator[str]:
    """The line with smaller zones, the largest of them first."""
    words = find_vendor(vendor).corners
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


class Larger(NamedTuple):
    """A line with a larger zone, and a description: "PL=0 → PL=1"."""

    text: str
    says: str


def larger(vendor: str, text: str) -> Iterator[Larger]:
    """The line with larger zones, the smallest of them first; an exact stop with all zones that the language has."""
    words = find_vendor(vendor).corners
    if words is None:
        return
    code, comment = _split(text, words)
    start = code
    exact = re.search(words.exact[0], code)
    if exact is not None and re.search(words.zone, code) is None:
        start = re.sub(*words.exact, code, count=1)
        yield Larger(start + comment, "stop → smallest zone")
    found = re.search(words.zone, start)
    if found is None:
        return
    size = float(found[1])
    sizes = [one for one in words.sizes if one > size] or [
        size * 2**n for n in range(1, 7) if not words.sizes
    ]
    for one in sizes:
        yield Larger(
            f"{start[: found.start(1)]}{one:.4g}{start[found.end(1) :]}{comment}",
            f"zone {found[0]} → {found[0].replace(found[1], f'{one:.4g}')}",
        )


def freed(vendor: str, text: str, share: float) -> str | None:
    """A straight move as a joint move at `share` [1] of rated speed, in the language's syntax; None for other lines."""
    words = find_vendor(vendor).corners
    if words is None:
        return None
    code, comment = _split(text, words)
    for straight, joint in find_vendor(vendor).joint_moves:
        changed, count = re.subn(straight, joint.format(percent=100.0 * share), code, count=1)
        if count:
            return changed + comment
    return None


def _split(text: str, words: CornerSpelling) -> tuple[str, str]:
    found = re.search(words.comment, text)
    return (text, "") if found is None else (text[: found.start()], text[found.start() :])
