"""Aligns the pieces of two versions: equal ones first, then the most similar ones between them."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Iterator, Sequence

Pair = tuple[int, int]
# What two pieces have in common, from 0 (nothing) to 1 (all).
Alike = Callable[[int, int], float]

_LARGEST = 250_000  # pairs that are compared one by one: a gap of 500 pieces on both sides
_LEAST = 0.5  # in common; below, a piece went and another came


def align(old: Sequence[str], new: Sequence[str], alike: Alike) -> list[Pair]:
    """Pairs (old, new), ascending in both. Pieces without a partner are in none."""
    pairs: list[Pair] = []
    work = [(0, len(old), 0, len(new))]
    while work:
        a, b, c, d = work.pop()
        while a < b and c < d and old[a] == new[c]:
            pairs.append((a, c))
            a, c = a + 1, c + 1
        while a < b and c < d and old[b - 1] == new[d - 1]:
            b, d = b - 1, d - 1
            pairs.append((b, d))
        if a == b or c == d:
            continue
        anchors = _anchors(old, new, a, b, c, d)
        if not anchors:
            pairs += _gap(old, new, (a, b, c, d), alike)
            continue
        for i, j in anchors:
            pairs.append((i, j))
            work.append((a, i, c, j))
            a, c = i + 1, j + 1
        work.append((a, b, c, d))
    return sorted(pairs)


def _anchors(old: Sequence[str], new: Sequence[str], a: int, b: int, c: int, d: int) -> list[Pair]:
    """Equal pieces that occur once on both sides, as many as are in the same order (patience)."""
    often, there = Counter(old[a:b]), Counter(new[c:d])
    place = {new[j]: j for j in range(c, d) if there[new[j]] == 1 and new[j]}
    found = [(i, place[old[i]]) for i in range(a, b) if old[i] in place and often[old[i]] == 1]
    return longest_rising(found)


def longest_rising(found: Sequence[Pair]) -> list[Pair]:
    """The longest subsequence of `found`, sorted by the first of each pair, in which the second rises too."""
    tails: list[int] = []
    ends: list[int] = []
    before: list[int] = []
    for at, (_, j) in enumerate(found):
        rank = bisect_left(tails, j)
        if rank == len(tails):
            tails.append(j)
            ends.append(at)
        else:
            tails[rank], ends[rank] = j, at
        before.append(ends[rank - 1] if rank else -1)
    chain: list[Pair] = []
    at = ends[-1] if ends else -1
    while at >= 0:
        chain.append(found[at])
        at = before[at]
    return chain[::-1]


def _gap(
    old: Sequence[str], new: Sequence[str], gap: tuple[int, int, int, int], alike: Alike
) -> Iterator[Pair]:
    """The pairing with the largest similarity (Needleman and Wunsch)."""
    a, b, c, d = gap
    if (b - a) * (d - c) > _LARGEST:
        if b - a == d - c:  # all was touched up, nothing came or went
            yield from ((a + k, c + k) for k in range(b - a) if alike(a + k, c + k) >= _LEAST)
        return
    width = d - c + 1
    best = [[0.0] * width for _ in range(b - a + 1)]
    shared = [[0.0] * width for _ in range(b - a + 1)]
    for i in range(b - a - 1, -1, -1):
        row, below, common = best[i], best[i + 1], shared[i]
        for j in range(width - 2, -1, -1):
            # Equal words say more than any likeness: two of them outweigh three that are nearly so.
            value = 2.0 if old[a + i] == new[c + j] else alike(a + i, c + j)
            common[j] = value
            most = max(below[j], row[j + 1])
            row[j] = max(most, below[j + 1] + value) if value >= _LEAST else most
    i = j = 0
    while i < b - a and j < d - c:
        if shared[i][j] >= _LEAST and best[i][j] == best[i + 1][j + 1] + shared[i][j]:
            yield a + i, c + j
            i, j = i + 1, j + 1
        elif best[i][j] == best[i + 1][j]:
            i += 1
        else:
            j += 1


_WORD = re.compile(r"\w+|[^\w\s]")


Words = frozenset[tuple[str, int]]  # each with how often it came before


def words_of(code: str) -> Words:
    """The words and operators of a piece."""
    often: Counter[str] = Counter()
    found = []
    for word in _WORD.findall(code):
        found.append((word, often[word]))
        often[word] += 1
    return frozenset(found)


def likeness(one: Words, other: Words) -> float:
    """The share of words that two pieces have in common [1]."""
    total = len(one) + len(other)
    return 2.0 * len(one & other) / total if total else 0.0
