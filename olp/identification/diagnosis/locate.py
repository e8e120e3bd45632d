"""Where simulation and recording differ: move by move, significant or not, and in which phase."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.errors import errors_of
from olp.identification.diagnosis.model import DurationModel
from olp.identification.diagnosis.result import Mismatch, MoveResidual
from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]

_FALSE_DISCOVERIES = 0.05  # of the moves that are called significant


def mismatch_of(case: MeasuredMoves, sigma: float, model: DurationModel, late: NDArray[np.bool_]) -> Mismatch:
    """Residuals of all moves against the judged simulation."""
    residual = case.residual
    chosen = significant(residual, sigma)
    phases = _phases(case, model, late)
    moves = tuple(
        MoveResidual(
            int(case.move[i]),
            case.job[i] or None,
            int(case.line[i]) or None,
            phases[i],
            float(residual[i]),
            bool(chosen[i]),
        )
        for i in range(len(case))
    )
    return Mismatch(float(residual.mean()), errors_of(residual, case.measured), moves)


def significant(residual: Floats, sigma: float) -> NDArray[np.bool_]:
    """(n,) beyond the noise, at most 5 % false ones (Y. Benjamini, Y. Hochberg, J. R. Statist. Soc. B 57, 1995)."""
    tail = np.array([math.erfc(abs(r) / sigma / math.sqrt(2.0)) for r in residual.tolist()])
    order = np.argsort(tail)
    passed = tail[order] <= _FALSE_DISCOVERIES * np.arange(1, len(tail) + 1) / len(tail)
    count = int(np.nonzero(passed)[0].max()) + 1 if passed.any() else 0
    chosen = np.zeros(len(tail), dtype=bool)
    chosen[order[:count]] = True
    return chosen


def _phases(case: MeasuredMoves, model: DurationModel, late: NDArray[np.bool_]) -> list[str]:
    """Of the term that does most in a move; "whole" without one."""
    shares = model.contributions(case)
    if not shares:
        return ["settle" if waits else "whole" for waits in late.tolist()]
    most = np.argmax(np.abs(shares), axis=0)
    names = [part.term.phase for part in model.parts]
    return ["settle" if waits else names[k] for k, waits in zip(most.tolist(), late.tolist(), strict=True)]
