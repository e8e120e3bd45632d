"""Which line of the old version is which of the new one: by what the lines do, not by their numbers."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Sequence

import numpy as np

from olp.checks.difference.rows import ComparedLine

_SKIP = 1.0  # cost of a line that has no partner; a pair that costs more than two of them is none
_SMALL = 300  # lines of a gap that are aligned exactly; longer gaps pair up by their text


def align(
    old: Sequence[ComparedLine], new: Sequence[ComparedLine]
) -> Iterator[tuple[ComparedLine | None, ComparedLine | None]]:
    """Pairs in order; each row comes once. Lines that do the same are anchors, those between pair up."""
    matcher = difflib.SequenceMatcher(
        None, [r.signature for r in old], [r.signature for r in new], autojunk=False
    )
    for word, a, b, c, d in matcher.get_opcodes():
        if word == "equal":
            yield from zip(old[a:b], new[c:d], strict=True)
        else:
            yield from _gap(old[a:b], new[c:d])


def _gap(
    old: Sequence[ComparedLine], new: Sequence[ComparedLine]
) -> Iterator[tuple[ComparedLine | None, ComparedLine | None]]:
    if not old or not new:
        yield from ((row, None) for row in old)
        yield from ((None, row) for row in new)
    elif len(old) > _SMALL or len(new) > _SMALL:
        yield from _by_text(old, new)
    else:
        yield from _cheapest(old, new)


def _by_text(
    old: Sequence[ComparedLine], new: Sequence[ComparedLine]
) -> Iterator[tuple[ComparedLine | None, ComparedLine | None]]:
    """A long gap: first by the same text, what is left by order."""
    matcher = difflib.SequenceMatcher(
        None, [_words(r) for r in old], [_words(r) for r in new], autojunk=False
    )
    for word, a, b, c, d in matcher.get_opcodes():
        both = min(b - a, d - c)
        if word == "equal" or word == "replace":
            yield from zip(old[a : a + both], new[c : c + both], strict=True)
        else:
            both = 0
        yield from ((row, None) for row in old[a + both : b])
        yield from ((None, row) for row in new[c + both : d])


def _words(row: ComparedLine) -> tuple[str, str, str]:
    return row.routine, row.kind, row.text


def _cheapest(
    old: Sequence[ComparedLine], new: Sequence[ComparedLine]
) -> Iterator[tuple[ComparedLine | None, ComparedLine | None]]:
    """The pairing of least cost (Needleman and Wunsch)."""
    price = np.array([[_price(a, b) for b in new] for a in old])
    table = np.zeros((len(old) + 1, len(new) + 1))
    table[:, 0] = np.arange(len(old) + 1) * _SKIP
    table[0] = np.arange(len(new) + 1) * _SKIP
    for i in range(1, len(old) + 1):
        for j in range(1, len(new) + 1):
            table[i, j] = min(
                table[i - 1, j - 1] + price[i - 1, j - 1], table[i - 1, j] + _SKIP, table[i, j - 1] + _SKIP
            )
    pairs: list[tuple[ComparedLine | None, ComparedLine | None]] = []
    i, j = len(old), len(new)
    while i or j:
        if i and j and table[i, j] == table[i - 1, j - 1] + price[i - 1, j - 1]:
            i, j = i - 1, j - 1
            pairs.append((old[i], new[j]))
        elif i and table[i, j] == table[i - 1, j] + _SKIP:
            i -= 1
            pairs.append((old[i], None))
        else:
            j -= 1
            pairs.append((None, new[j]))
    yield from reversed(pairs)


def _price(a: ComparedLine, b: ComparedLine) -> float:
    """0 for the same, more than two skips for what cannot be the same line."""
    if a.routine != b.routine or (a.kind in ("wait", "signal")) != (b.kind in ("wait", "signal")):
        return 3 * _SKIP
    if a.kind in ("wait", "signal"):
        alike = difflib.SequenceMatcher(None, a.text, b.text, autojunk=False).quick_ratio()
        return 1.9 * _SKIP * (1.0 - alike) if a.kind == b.kind else 2.5 * _SKIP
    price = 0.0 if a.kind == b.kind else 0.6
    # The name of the point and the word of the move say more than the numbers: those are what gets touched up.
    price += 0.7 * (1.0 - difflib.SequenceMatcher(None, a.text, b.text, autojunk=False).quick_ratio())
    gap = float(np.linalg.norm(a.target - b.target))
    price += 0.6 * min(gap / 0.2, 1.0) if np.isfinite(gap) else 0.0 if _same_axes(a, b) else 0.3
    price += 0.1 * (a.speed != b.speed) + 0.1 * (a.blend != b.blend)
    return price


def _same_axes(a: ComparedLine, b: ComparedLine) -> bool:
    return bool(np.allclose(a.axes, b.axes, rtol=0.0, atol=1e-9, equal_nan=True))
