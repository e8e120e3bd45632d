"""Which other effects would have made the same durations, as far as the noise lets anybody see.

For each hidden effect every other one is played on the same program at the strength that comes nearest. What is left,
as a sum of squares over the noise, is what evidence there can be: below `SAME` no method can tell, below `NEAR` a
careful one may say so.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bench.concealed.effects import Hidden, World, play
from bench.concealed.terms import KINDS

Floats = NDArray[np.float64]
SAME, NEAR = 12.0, 60.0
_MOST = 90  # moves looked at


def substitutes(
    world: World, hidden: list[Hidden], parts: dict[str, Floats], noise: float
) -> tuple[dict[str, list[str]], dict[str, list[str]], list[str]]:
    """By hidden term: those that no method can tell from it, and those that are near; and what nobody can see."""
    same: dict[str, list[str]] = {}
    near: dict[str, list[str]] = {}
    unseen = []
    n = len(world.moves)
    first = max(0, (n - _MOST) // 2)
    rows = slice(first, first + _MOST)
    quick = replace(world, moves=world.moves.take(rows), step=0.004)
    more = n / len(quick.moves)  # what these moves tell, all of them tell so many times over
    noise = noise / float(np.sqrt(more))
    parts = {t: p[rows] for t, p in parts.items()}
    hidden = [h._replace(draw=None if h.draw is None else h.draw[rows]) for h in hidden]
    base = play(quick, [], hidden)
    for h in hidden:
        if h.term not in parts or h.term == "outside":
            continue
        others = [parts[k] for k in parts if k != h.term]
        free = _free(others, len(base))
        left = free(parts[h.term])
        if float(left @ left) / noise**2 < SAME:
            unseen.append(h.term)
        same[h.term], near[h.term] = [], []
        for term in KINDS:
            if term in parts or h.term in ("warm-up", "external-wait") or term in _NEVER:
                continue
            miss = _nearest(quick, base, term, parts[h.term], free) / noise**2
            if miss < SAME:
                same[h.term].append(term)
            if miss < NEAR:
                near[h.term].append(term)
    return same, near, unseen


def _free(others: list[Floats], n: int):
    if not others:
        return lambda v: v
    basis = np.linalg.qr(np.stack(others, axis=1))[0]
    return lambda v: v - basis @ (basis.T @ v)


def _nearest(world: World, base: Floats, term: str, part: Floats, free) -> float:
    """Least sum of squares [s^2] between what `term` can make and `part`."""
    moves = world.moves
    if term == "blending" and (not (moves.blend > 0).any() or world.corners == "overlap"):
        return float("inf")
    if term == "orientation-limit" and not moves.angle.any():
        return float("inf")
    if (term == "payload" and not np.ptp(moves.load) > 0) or (
        term == "payload-inertia" and not moves.inertia.any()
    ):
        return float("inf")
    best = float("inf")
    signs = (1.0, -1.0) if term in ("acceleration", "speed-scale") else (KINDS_CHOICE.get(term, 1.0),)
    for sign in signs:
        kind = KINDS[term]
        low, high = np.log(kind.low), np.log(kind.high)
        if kind.low == kind.high:
            low, high = low - 0.3, high + 0.3

        def miss(log: float, sign: float = sign) -> float:
            alone = Hidden(term, float(np.exp(log)), choice=sign)
            start = base if term not in _OWN_WAY else play(world, [], [alone])
            gap = free(play(world, [alone]) - start - part)
            return float(gap @ gap)

        grid = np.linspace(low, high, 8)
        values = [miss(g) for g in grid]
        k = int(np.argmin(values))
        a, b = grid[max(k - 1, 0)], grid[min(k + 1, 7)]
        for _ in range(6):
            third = (b - a) * 0.382
            x, y = a + third, b - third
            if miss(x) < miss(y):
                b = y
            else:
                a = x
        best = min(best, miss((a + b) / 2), values[k])
    return best


KINDS_CHOICE = {"torque-speed": 0.4, "orientation-limit": 0.2, "warm-up": 120.0}
_NEVER = ("outside", "external-wait", "clock", "warm-up")
_OWN_WAY = ("joint-acceleration-limit", "joint-speed-limit", "payload-inertia")
