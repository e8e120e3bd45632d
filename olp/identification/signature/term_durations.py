"""Durations of whole rows, corners and joint moves included, by the terms of a signature of method named_terms."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.identification.recording.moves import CIRCULAR
from olp.identification.signature.coefficients import TERMS
from olp.identification.signature.document import Signature
from olp.identification.signature.moveset import MoveSet
from olp.identification.signature.places import with_points
from olp.identification.signature.term_case import case_for, seconds_of
from olp.identification.signature.term_model import NamedModel, from_parameters
from olp.timing.physics._case import MeasuredMoves

if TYPE_CHECKING:
    from olp.identification.recording import Recording

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

_UNUSABLE = (KeyError, TypeError, ValueError, IndexError)
_CURVED = 2.0  # [1] no curve was learnt from: its interval is that many times as wide


class PredictedRows(NamedTuple):
    """m rows of a recording. `strain` (m,) [1]: how far outside; `half` (m,) [s] of the 95 % interval, with it."""

    rows: Rows
    duration: Floats  # (m,) [s]
    half: Floats
    strain: Floats
    reasons: tuple[str, ...]  # why a row is outside what was learnt, "" inside


def told_rows(signature: Signature, recording: Recording) -> PredictedRows | None:
    """What the terms say of the rows of `recording`, measured or not; None where they say nothing, or there are none.

    Raises OlpError: H008 parameters that cannot be used, H011 axes that are not known.
    """
    if TERMS not in signature.parts:
        return None
    named = terms_of(signature)
    made = case_for(named, recording)
    if made is None:
        return None
    try:
        seconds = seconds_of(named, made[0])
    except _UNUSABLE as problem:
        raise _unusable(problem) from None
    good = np.nonzero(np.isfinite(seconds))[0].astype(np.int64)
    case, rows, seconds = made[0].take(good), made[1][good], seconds[good]
    strain, reasons = np.ones(len(rows)), [""] * len(rows)
    placed = _placed(case, recording, rows)
    moves = moves_of_case(case, recording, rows)
    if len(moves):
        strain[placed] = signature.domain.strain(moves)
        for row, reason in zip(placed.tolist(), signature.domain.outside(moves), strict=True):
            reasons[row] = "" if case.joint[row] else reason
    strain[recording.moves.kind[rows] == CIRCULAR] *= _CURVED
    half = signature.parts[TERMS].spread.half * strain
    return PredictedRows(rows, seconds, half, strain, tuple(reasons))


def terms_of(signature: Signature) -> NamedModel:
    """The terms that a signature holds. Raises OlpError: H008, N001 a term that this olp does not know."""
    try:
        return from_parameters(signature.parameters)
    except _UNUSABLE as problem:
        raise _unusable(problem) from None


def _unusable(problem: Exception) -> OlpError:
    what = f"{type(problem).__name__}: {problem}"
    return OlpError(error("H008", f"the signature's terms cannot be used ({what})"))


def moves_of_case(case: MeasuredMoves, recording: Recording, rows: Rows) -> MoveSet:
    """The rows whose points are known, as places to be compared; a joint move has the usual speed of the others."""
    points = with_points(recording.moves, recording.robot, recording.tool)
    at = _placed(case, recording, rows)
    own = rows[at]
    chord = np.linalg.norm(points.end[own] - points.start[own], axis=1)
    speed, joint = case.base.speed[at], case.joint[at]
    usual = np.median(speed[~joint]) if (~joint).any() else np.nan
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.maximum(chord * speed / case.base.way[at], 1e-3)
    nothing = np.full(len(at), np.nan)
    return MoveSet(
        start=points.start[own],
        end=points.end[own],
        rotation=np.full((len(at), 3, 3), np.nan),
        speed=np.where(joint, usual if np.isfinite(usual) else mean, speed),
        nominal=nothing,
        duration=nothing,
        payload=case.payload[at],
        configuration=("",) * len(at),
        program=("",) * len(at),
    )


def _placed(case: MeasuredMoves, recording: Recording, rows: Rows) -> NDArray[np.intp]:
    """Which of the rows have, or get from the robot, points of the tool, and go somewhere."""
    points = with_points(recording.moves, recording.robot, recording.tool)
    return np.nonzero(points.has_points[rows] & case.moving)[0]
