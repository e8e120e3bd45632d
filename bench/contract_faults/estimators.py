"""Faults of meaning in an estimator of signatures: what a careless author does, whatever the method is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np

Planted = tuple[str, Callable[[], Callable[[], bool]]]
Estimates = Callable[..., Any]

# --- of what it estimates: (the estimate, the moves) -> another estimate -------------------------------------------


def _learnt_from_the_answer(found: Any, moves: Any) -> Any:
    from olp.identification.signature.estimator import measured_slowness

    measured = measured_slowness(moves)
    return found._replace(slowness=np.where(np.isfinite(measured), measured, found.slowness))


ESTIMATES: Final[dict[str, Callable[[Any, Any], Any]]] = {
    "a slowness 4 % too large": lambda e, m: e._replace(slowness=1.04 * e.slowness),
    "a slowness per millimetre": lambda e, m: e._replace(slowness=e.slowness / 1000),
    "an acceleration for a slowness": lambda e, m: e._replace(slowness=1.0 / e.slowness),
    "a slowness of the other sign": lambda e, m: e._replace(slowness=-e.slowness),
    "a slowness that knows the neighbours": lambda e, m: e._replace(
        slowness=0.9 * e.slowness + 0.1 * e.slowness[:1]
    ),
    "the moves in the order of their speed": lambda e, m: e._replace(
        slowness=e.slowness[np.argsort(m.length)]
    ),
    "the answer that was asked for": _learnt_from_the_answer,
    "a doubt of the other sign": lambda e, m: e._replace(sd=-e.sd - 1e-6),
    "a doubt of a time, not of a slowness": lambda e, m: e._replace(sd=e.sd * m.duration),
    "a doubt that is none": lambda e, m: e._replace(sd=np.full(len(e.sd), np.nan)),
    "all moves called unlike what was learnt": lambda e, m: e._replace(
        inside=np.zeros(len(e.sd), dtype=bool)
    ),
    "one move too few": lambda e, m: e._replace(slowness=e.slowness[1:]),
}

# --- of what it learns from: moves -> other moves ------------------------------------------------------------------

LEARNS_FROM: Final[dict[str, Callable[[Any], Any]]] = {
    "speeds read as mm/s": lambda m: replace(m, speed=m.speed * 1000),
    "durations in milliseconds": lambda m: replace(m, duration=m.duration * 1000),
    "durations without their last 5 %": lambda m: replace(m, duration=0.95 * m.duration),
    "starts and ends changed about": lambda m: replace(m, start=m.end, end=m.start),
    "the first half of the moves": lambda m: m.take(np.arange(len(m)) < len(m) // 2),
}


def estimator_faults(name: str) -> list[Planted]:
    """(what, plant) of every fault; one that changes no answer on the suite's moves counts as nothing."""
    found = [(what, _plant_estimate(name, change)) for what, change in ESTIMATES.items()]
    found += [(what, _plant_fit(name, change)) for what, change in LEARNS_FROM.items()]
    return [*found, ("moves that are changed by learning", _plant_spoiling(name))]


def _kind(name: str) -> Any:
    from olp.identification.signature.estimator import load_estimator

    return type(load_estimator(name))


def _plant_estimate(name: str, change: Callable[[Any, Any], Any]) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        kind, changed = _kind(name), [False]
        whole = kind.estimate

        def estimate(self: Any, parameters: Any, moves: Any, robot: Any) -> Any:
            found = whole(self, parameters, moves, robot)
            other = change(found, moves)
            changed[0] |= _differs(found, other)
            return other

        kind.estimate = estimate
        return lambda: changed[0]

    return plant


def _differs(one: Any, other: Any) -> bool:
    pairs = [(one.slowness, other.slowness), (one.sd, other.sd), (one.inside * 1.0, other.inside * 1.0)]
    return not all(a.shape == b.shape and np.allclose(a, b, rtol=1e-9, atol=1e-12) for a, b in pairs)


def _plant_fit(name: str, change: Callable[[Any], Any]) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        kind, changed = _kind(name), [False]
        whole = kind.fit

        def fit(self: Any, moves: Any, robot: Any) -> Any:
            other = whole(self, change(moves), robot)
            if not changed[0]:  # once: it learns twice
                right = self.estimate(whole(self, moves, robot), moves, robot)
                changed[0] = _differs(right, self.estimate(other, moves, robot))
            return other

        kind.fit = fit
        return lambda: changed[0]

    return plant


def _plant_spoiling(name: str) -> Callable[[], Callable[[], bool]]:
    def plant() -> Callable[[], bool]:
        kind, changed = _kind(name), [False]
        whole = kind.fit

        def fit(self: Any, moves: Any, robot: Any) -> Any:
            found = whole(self, moves, robot)
            moves.duration[:] = moves.duration * 1.000001
            changed[0] = True
            return found

        kind.fit = fit
        return lambda: changed[0]

    return plant
