"""A corner in a line of a program rounded, or made smaller: as text, spelt as the vendor says."""

from __future__ import annotations

import re
from collections.abc import Iterator

from olp.languages.vendor import CornerSpelling, find_vendor


def rounded(vendor: str, text: str) -> str | None:
    """The line with its exact stop rounded as little as the language can say; None where it has none."""
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


def _split(text: str, words: CornerSpelling) -> tuple[str, str]:
    found = re.search(words.comment, text)
    return (text, "") if found is None else (text[: found.start()], text[found.start() :])
