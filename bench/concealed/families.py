"""The families of cases: how an effect is concealed, and the controls in which nothing may be named."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from bench.concealed.effects import Hidden, World
from bench.concealed.programs import Moves, Plan
from bench.concealed.terms import SINGLE

# Shares of all cases.
FAMILIES = {
    "one": 32, "none": 9, "cancelled": 9, "confounded": 9, "rare": 9, "fudged": 9, "overlapped": 10, "noise": 8,
    "outside": 8, "clock": 6, "poor": 5, "friction": 2, "log-one": 12, "log-none": 3, "log-clock": 5,
}  # fmt: skip
PAIRS = [
    ("jerk", "settling"), ("gravity", "settling"), ("gravity", "jerk"), ("payload", "settling"),
    ("speed-clamp", "dispatch"), ("blending", "acceleration"), ("settling", "dispatch"), ("warm-up", "payload"),
    ("reach-inertia", "settling"), ("acceleration", "speed-clamp"), ("cycle-quantisation", "settling"),
    ("joint-speed-limit", "settling"), ("gravity", "payload"), ("external-wait", "acceleration"),
    ("speed-scale", "jerk"), ("torque-speed", "dispatch"), ("orientation-limit", "acceleration"),
    ("gravity", "payload", "settling"), ("jerk", "settling", "speed-clamp"), ("warm-up", "external-wait"),
    ("reach-inertia", "payload", "dispatch"), ("joint-acceleration-limit", "settling"), ("payload-inertia", "settling"),
    ("acceleration", "settling", "external-wait"), ("blending", "settling"), ("gravity", "speed-clamp", "warm-up"),
]  # fmt: skip
CANCELLED = ["jerk", "gravity", "settling", "reach-inertia", "payload", "speed-clamp", "warm-up", "dispatch"]
# Those that can be as small as one likes.
FAINT = [
    t
    for t in SINGLE
    if t not in ("blending", "joint-speed-limit", "joint-acceleration-limit", "torque-speed")
]
CONFOUNDED = ["gravity", "settling", "payload", "reach-inertia", "warm-up", "jerk"]
RARE = ["speed-clamp", "external-wait", "payload", "orientation-limit", "joint-speed-limit", "external-wait"]
OUTSIDE = ["day", "parity", "walk", "step", "weekly"]


@dataclass(frozen=True, slots=True)
class Recipe:
    """What a case shall be. `tune`: (acceleration | speed, mean | moves) of the simulation."""

    terms: tuple[str, ...]
    sizes: tuple[float, ...]
    moves: int
    rich: bool = True
    rare: bool = False
    tune: tuple[str, str] | None = None
    shape: Callable[[Plan], Plan] | None = None
    change: Callable[[np.random.Generator, Moves], None] | None = None
    adjust: Callable[[np.random.Generator, World, Hidden], Hidden] | None = None
    note: str = ""


def recipe(dice: np.random.Generator, family: str, turn: int) -> Recipe:
    """The `turn`-th case of a family."""
    moves = int(np.exp(dice.uniform(np.log(60), np.log(600))))
    return _MAKERS[family](dice, turn, moves)


def _size(dice: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(dice.uniform(np.log(low), np.log(high))))


def _one(dice: np.random.Generator, turn: int, moves: int) -> Recipe:
    low, high = ((2.0, 10.0), (2.0, 10.0), (0.4, 2.0))[(turn // len(SINGLE)) % 3]
    return Recipe((SINGLE[turn % len(SINGLE)],), (_size(dice, low, high),), moves)


def _none(dice: np.random.Generator, turn: int, moves: int) -> Recipe:
    return Recipe((), (), moves)


def _noise(dice: np.random.Generator, turn: int, moves: int) -> Recipe:
    return Recipe((FAINT[(5 * turn) % len(FAINT)],), (_size(dice, 0.05, 0.3),), moves)


def _overlapped(dice: np.random.Generator, turn: int, moves: int) -> Recipe:
    terms = PAIRS[turn % len(PAIRS)]
    return Recipe(terms, tuple(_size(dice, 2.5, 9.0) for _ in terms), max(moves, 120))


def _cancelled(dice: np.random.Generator, turn: int, moves: int) -> Recipe:
    term = CANCELLED[turn % len(CANCELLED)]
    what = "speed" if turn % 4 == 3 and term in ("settling", "dispatch", "jerk") else "acceleration"
    return Recipe((term,), (_size(dice, 4.0, 10.0),), max(moves, 100), tune=(what, "mean"))


def _fudged(dice: np.random.Generator, turn: int, moves: int) -> Recipe:
    term = CANCELLED[(turn * 3 + 1) % len(CANCELLED)]
    what = "speed" if turn % 3 == 2 else "acceleration"
    return Recipe((term,), (_size(dice, 4.0, 10.0),), max(moves, 100), tune=(what, "moves"))


def _confounded(dice: np.random.Generator, turn: int, moves: int) -> Recipe:
    term = CONFOUNDED[turn % len(CONFOUNDED)]
    size, moves = _size(dice, 3.0, 10.0), max(moves, 100)
    if term == "gravity":
        return Recipe(
            (term,), (size,), moves, shape=lambda p: replace(p, steep_long=True), note="steep = long"
        )
    if term == "settling":
        return Recipe(
            (term,), (size,), moves, shape=lambda p: replace(p, long_stops=True), note="stops = long"
        )
    if term == "payload":
        return Recipe(
            (term,), (size,), moves, shape=lambda p: replace(p, loads_late=True), note="load = time"
        )
    if term == "reach-inertia":
        return Recipe((term,), (size,), moves, change=_fast_far, note="far = fast")
    if term == "jerk":
        return Recipe((term,), (size,), moves, change=_fast_long, note="long = fast")
    return Recipe((term,), (size,), moves, note="warm-up = temperature")


def _fast_far(dice: np.random.Generator, moves: Moves) -> None:
    _by_rank(dice, moves, moves.radius().mean(axis=1))


def _fast_long(dice: np.random.Generator, moves: Moves) -> None:
    _by_rank(dice, moves, moves.length)


def _by_rank(dice: np.random.Generator, moves: Moves, by: np.ndarray) -> None:
    """The programmed speed follows another property of the move, with some exceptions; the same in every cycle."""
    _, first, back = np.unique(moves.line, return_index=True, return_inverse=True)
    values = by[first]
    rank = np.argsort(np.argsort(values + dice.normal(0, 0.35, len(first)) * values.std()))
    speeds = np.sort(moves.speed[first])
    moves.speed[:] = np.where(moves.kind == 0, speeds[rank][back], moves.speed)


def _rare(dice: np.random.Generator, turn: int, moves: int) -> Recipe:
    term = RARE[turn % len(RARE)]
    return Recipe(
        (term,), (_size(dice, 4.0, 15.0),), max(moves, 100), rare=True, change=_SELDOM.get(term), adjust=_few
    )


def _seldom_fast(dice: np.random.Generator, moves: Moves) -> None:
    """A few moves are programmed faster than all others."""
    few = _some_lines(dice, moves)
    rest = moves.kind == 0
    top = moves.speed[rest].max()
    moves.speed[:] = np.where(few & rest, 2.5 * top, moves.speed)


def _seldom_loaded(dice: np.random.Generator, moves: Moves) -> None:
    few = _some_lines(dice, moves)
    moves.load[:] = np.where(few, 15.0, 0.0)


def _some_lines(dice: np.random.Generator, moves: Moves) -> np.ndarray:
    lines = np.unique(moves.line[(moves.kind == 0) & (moves.length > 0.1)])
    few = dice.choice(lines, max(3, round(0.07 * len(lines))), replace=False)
    return np.isin(moves.line, few)


_SELDOM = {"speed-clamp": _seldom_fast, "payload": _seldom_loaded}


def _few(dice: np.random.Generator, world: World, effect: Hidden) -> Hidden:
    if effect.term != "external-wait":
        return effect
    share = float(dice.choice([0.03, 0.05]))
    from bench.concealed.terms import waits

    return effect._replace(draw=waits(dice, world, share))


def _outside(dice: np.random.Generator, turn: int, moves: int) -> Recipe:
    kind = OUTSIDE[turn % len(OUTSIDE)]

    def draw(dice: np.random.Generator, world: World, effect: Hidden) -> Hidden:
        return effect._replace(draw=_strange(dice, kind, len(world.moves)))

    return Recipe(("outside",), (_size(dice, 3.0, 10.0),), max(moves, 100), adjust=draw, note=kind)


def _strange(dice: np.random.Generator, kind: str, n: int) -> np.ndarray:
    """(n,) relative disturbances that no term of the list makes."""
    at = np.arange(n)
    if kind == "day":
        return np.sin(2 * np.pi * (at / n * dice.uniform(2, 5) + dice.random()))
    if kind == "parity":
        return np.where(at % 2 == 0, 1.0, -1.0)
    if kind == "walk":
        walk = np.cumsum(dice.normal(size=n))
        return (walk - walk.mean()) / walk.std()
    if kind == "step":
        return np.where(at > n * dice.uniform(0.35, 0.65), 1.0, -0.2)
    return np.sin(2 * np.pi * at / dice.uniform(6, 14))


def _clock(dice: np.random.Generator, turn: int, moves: int) -> Recipe:
    return Recipe(("clock",), (_size(dice, 2.0, 10.0),), moves)


def _poor(dice: np.random.Generator, turn: int, moves: int) -> Recipe:
    term = ("settling", "dispatch", "acceleration", "jerk", "speed-scale")[turn % 5]
    return Recipe((term,), (_size(dice, 3.0, 10.0),), moves, rich=False)


def _friction(dice: np.random.Generator, turn: int, moves: int) -> Recipe:
    return Recipe(
        (("viscous-friction", "coulomb-friction")[turn % 2],), (_size(dice, 3.0, 10.0),), max(moves, 150)
    )


_MAKERS = {
    "one": _one, "none": _none, "noise": _noise, "overlapped": _overlapped, "cancelled": _cancelled,
    "fudged": _fudged, "confounded": _confounded, "rare": _rare, "outside": _outside, "clock": _clock,
    "poor": _poor, "friction": _friction,
}  # fmt: skip
