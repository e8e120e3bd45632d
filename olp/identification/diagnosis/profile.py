"""How far a parameter can go before the data object, all others refitted: intervals by profile likelihood.

A limit that few moves reach has no parabola around its best value: moves come under it one by one. Where the data
never object, the side is open (D. Venzon, S. Moolgavkar, Applied Statistics 37, 1988).
"""

from __future__ import annotations

import math
from collections.abc import Callable

from olp.identification.diagnosis.fitting import (
    ModelFit,
    Noise,
    evaluate,
    fit,
    moved,
    parameters_of,
    place_of,
)
from olp.identification.diagnosis.model import DurationModel
from olp.timing.physics._case import MeasuredMoves

_STEPS = 4  # of each refit
_TRIES = 6  # refits per side
_NEAR = 0.12  # of the distance that is looked for
_FIRST = 0.05  # of the room to the bound, where nothing tells how far to go
_QUICKLY = 4.0  # times as far, at most, from one try to the next
_BEHIND = (0.15, 0.4, 1.0)  # of the room behind an end: where the likelihood is asked again
_STEPS_BEHIND = 10
_LIKELY = 4  # starts


def distance(
    best: ModelFit, index: int, sign: int, error: float, deviations: float, case: MeasuredMoves, noise: Noise
) -> float:
    """[coordinate] to where the likelihood has fallen as far as `deviations` of a normal one; inf where it never does.

    `error`: standard error by the curvature at the best value, 0 where there is none.
    """
    place, low, high = place_of(best.model)
    room = float(high[index] - place[index] if sign > 0 else place[index] - low[index])
    if room <= 0:
        return math.inf

    def asked(model: DurationModel, at: float, steps: int = _STEPS) -> tuple[DurationModel, float]:
        there = moved(model, index, float(place[index]) + sign * at)
        tried = fit(there, case, noise, steps, held=index)
        return tried.model, math.sqrt(max(2.0 * (tried.loss - best.loss), 0.0))

    at = _nearest(best.model, asked, room, error, deviations)
    if math.isfinite(at) and math.isinf(parameters_of(best.model)[index][1].null):
        # A limit that fewer moves reach may do as well when others make up for it.
        starts = _starts(best.model, index, case)
        for share in _BEHIND:
            behind = at + share * (room - at)
            there = float(place[index]) + sign * behind
            likely = sorted(starts, key=lambda m: evaluate(moved(m, index, there), case, noise).loss)
            if any(asked(model, behind, _STEPS_BEHIND)[1] < deviations for model in likely[:_LIKELY]):
                at = behind if share < 1.0 else math.inf
    return at


def _starts(model: DurationModel, index: int, case: MeasuredMoves) -> list[DurationModel]:
    """The model, and, where the part of coordinate `index` has more than one, with its guesses at the others."""
    part = parameters_of(model)[index][0]
    if len(part.values) == 1:
        return [model]
    guessed = [part._replace(values=values) for values in part.term.guesses(part.form, case)]
    return [model, *(DurationModel(tuple(g if p is part else p for p in model.parts)) for g in guessed)]


def _nearest(
    model: DurationModel,
    asked: Callable[[DurationModel, float], tuple[DurationModel, float]],
    room: float,
    error: float,
    deviations: float,
) -> float:
    """[coordinate] to the first end."""
    at = min(deviations * error, room) if error > 0 else _FIRST * room
    inside, fallen_inside, outside, fallen_outside = 0.0, 0.0, math.inf, math.inf
    for _ in range(_TRIES):
        tried, fallen = asked(model, at)
        if abs(fallen - deviations) < _NEAR * deviations:
            return at * deviations / fallen
        if fallen < deviations:
            if at >= room:
                return math.inf
            inside, fallen_inside, model = at, fallen, tried
        else:
            outside, fallen_outside = at, fallen
        if math.isinf(outside):
            at = min(at * min(max(deviations / max(fallen, 1e-9), 1.5), _QUICKLY), room)
        else:
            share = (deviations - fallen_inside) / max(fallen_outside - fallen_inside, 1e-9)
            at = inside + (outside - inside) * min(max(share, 0.1), 0.9)
    return at
