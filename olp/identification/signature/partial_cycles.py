"""Repeated cycles: one row per move, its mean over the cycles, and what the repeats say about the noise of one run.

Without it a repeat would tell what is held out when the others are fitted, and all errors would look like noise.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.errors import ErrorModel, Spread
from olp.identification.signature.moveset import MoveSet

Floats = NDArray[np.float64]

# [m], [m/s], [1], [kg] Moves nearer than this are repeats of one move.
_SAME = 1e-5
_NORMAL = 1.96


class Cycles(NamedTuple):
    """`moves`: the distinct ones, in the order of first use. `scatter` [s²/m]: of one run, 0 where nothing repeats."""

    moves: MoveSet
    runs: NDArray[np.int64]  # behind each
    scatter: float
    freedom: int  # degrees of freedom behind `scatter`


def average_cycles(moves: MoveSet) -> Cycles:
    """The mean duration of every move that was run several times."""
    if not len(moves):
        return Cycles(moves, np.zeros(0, dtype=np.int64), 0.0, 0)
    turned = np.nan_to_num(moves.rotation.reshape(len(moves), 9), nan=9.0)
    load = np.nan_to_num(moves.payload, nan=-1.0)
    keys = np.concatenate([moves.start, moves.end, turned, moves.speed[:, None], load[:, None]], axis=1)
    _, first, owner = np.unique(np.round(keys / _SAME), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    owner = np.argsort(order)[owner.reshape(-1)]
    rows = first[order].astype(np.int64)
    count = np.bincount(owner, minlength=len(rows)).astype(np.int64)
    freedom = int(len(moves) - len(rows))
    if not freedom:
        return Cycles(moves, count, 0.0, 0)
    mean = np.bincount(owner, moves.duration, len(rows)) / count
    off = (moves.duration - mean[owner]) / moves.speed
    kept = moves.take(rows)
    averaged = MoveSet(
        kept.start,
        kept.end,
        kept.rotation,
        kept.speed,
        kept.nominal,
        mean,
        kept.payload,
        kept.configuration,
        kept.program,
        kept.tool,
        kept.joints,
    )
    return Cycles(averaged, count, math.sqrt(float(np.sum(off**2)) / freedom), freedom)


def with_scatter(errors: ErrorModel, cycles: Cycles) -> ErrorModel:
    """Intervals of one run: what was held out were means, whose own noise is smaller by the root of the count."""
    missing = cycles.scatter * math.sqrt(1.0 - float(np.mean(1.0 / cycles.runs)))

    def wider(spread: Spread) -> Spread:
        return spread._replace(
            half=math.hypot(spread.half, _NORMAL * missing), own=math.hypot(spread.own, missing)
        )

    return ErrorModel(wider(errors.near), wider(errors.far)) if missing else errors
