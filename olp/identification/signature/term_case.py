"""Moves of any program as the terms of a diagnosis see them, with the motion of the simulation that was judged.

Code: H011 a term needs axes that are not known.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.identification.diagnosis.case_making import case_of
from olp.identification.diagnosis.model import ModelPart
from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR, RecordedMoves
from olp.identification.recording.recording import Recording
from olp.identification.recording.settings import RecordingSettings
from olp.identification.signature.term_model import NamedModel
from olp.timing.physics._case import MeasuredMoves, Rates

if TYPE_CHECKING:
    from olp.robots.geometry import Pose
    from olp.robots.robot import Robot

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

_RUNNING_TIME = "running time"  # the column that warm-up goes by: for ever is warm


def case_for(named: NamedModel, recording: Recording) -> tuple[MeasuredMoves, Rows] | None:
    """The moves of which the terms can tell the time, and their rows; None where there is none.

    Durations in `recording` do not matter. Left out: waits, kinds of moves that were not learnt, moves without way or
    speed. Raises OlpError (K…).
    """
    moves = recording.moves
    paths = np.isin(moves.kind, (LINEAR, CIRCULAR))
    told = (paths & np.isfinite(named.linear)) | ((moves.kind == JOINT) & np.isfinite(named.ramp))
    if not told.any():
        return None
    count = len(moves)
    given = np.where(paths & ~np.isfinite(moves.acceleration), named.linear, moves.acceleration)
    nothing = np.full(count, np.nan)
    asked = replace(
        moves,
        duration=np.where(told, 1.0, np.nan),
        sim=nothing,
        acceleration=given,
        payload=np.where(np.isfinite(moves.payload), moves.payload, named.payload),
        payload_inertia=np.where(np.isfinite(moves.payload_inertia), moves.payload_inertia, named.inertia),
    )
    try:
        made = case_of(replace(recording, moves=asked))
    except OlpError as problem:
        if problem.diagnostics[0].code.startswith("K"):
            raise
        return None  # nothing to judge is nothing to tell
    return _beside(named, made.case, recording, made.rows), made.rows


def _beside(named: NamedModel, case: MeasuredMoves, recording: Recording, rows: Rows) -> MeasuredMoves:
    """The case with the judged simulation's motion, for ever running."""
    slow = case.base.accelerate
    if named.ramp > 0:
        slow = np.where(case.joint, rated_speed(case, recording, rows) / named.ramp, slow)
    base = case.base.with_(
        accelerate=slow, decelerate=slow, law=named.law, overlap=named.overlap, split=named.split
    )
    return replace(
        case,
        base=base,
        simulated=base.duration(),
        numbers=named.numbers,
        derived={_RUNNING_TIME: np.full(len(case), np.inf)},
    )


def seconds_of(named: NamedModel, case: MeasuredMoves) -> Floats:
    """(n,) [s] with the terms. Raises OlpError (H011) where one of them needs axes that are not known."""
    lacking = [part.term.name for part in named.model.parts if not _known(part, case.rates)]
    if lacking:
        says = f"{', '.join(lacking)}: how the axes of the arm turn along these moves is not known"
        raise OlpError(
            error("H011", says, help="name a robot whose kinematics olp knows, or write joint points")
        )
    return np.maximum(named.model.seconds(case), 0.0)


def _known(part: ModelPart, rates: Rates | None) -> bool:
    """Whether what the form of a term hangs on is there."""
    name, key, axis = part.term.name, part.form.key, part.form.axis
    if key == "whole arm":
        return rates is not None and rates.bodies is not None
    if name == "payload-inertia" and key == "limit":
        return rates is not None and rates.rated_acceleration is not None
    if name in ("joint-speed-limit", "joint-acceleration-limit"):
        if rates is None or axis >= len(rates.names):
            return False
        rated = rates.rated if name == "joint-speed-limit" else rates.rated_acceleration
        return axis >= 0 or rated is not None
    if name == "torque-speed" and key.startswith("axes"):
        # Of rated speeds where these are known, else in rad/s.
        return rates is not None and (rates.rated is not None) == (part.form.parameters[0].unit == "1")
    return True


def rated_speed(case: MeasuredMoves, recording: Recording, rows: Rows) -> Floats:
    """(n,) [rad/s] of the leading axes, times the share of the rated acceleration that a move asks for."""
    speed, push = (
        np.where(np.isfinite(v), v, 1.0)
        for v in (recording.moves.speed_fraction[rows], recording.moves.acceleration_fraction[rows])
    )
    return np.asarray(case.base.speed / speed * push)


def bare_recording(
    count: int, columns: Mapping[str, Any], robot: Robot | None, tool: Pose | None
) -> Recording:
    """`count` moves of which only `columns` (fields of RecordedMoves) are known, as a recording."""
    axes = columns["joints_start"].shape[1] if "joints_start" in columns else 0
    fields: dict[str, Any] = {
        name: np.full(count, np.nan)
        for name in (
            *("duration", "sim", "speed", "speed_fraction", "acceleration", "acceleration_fraction"),
            *("t_start", "payload", "payload_inertia"),
        )
    }
    fields |= {
        name: np.full((count, 3), np.nan) for name in ("start", "end", "via", "start_angles", "end_angles")
    }
    fields |= {name: np.full((count, axes), np.nan) for name in ("joints_start", "joints_end")}
    fields |= {
        "move": np.arange(count),
        "kind": np.full(count, LINEAR, dtype=np.int8),
        "slides": (False,) * axes,
        "blend": np.zeros(count),
        "level": np.full(count, -1, dtype=np.int8),
        "cycle": np.full(count, -1),
        "line": np.zeros(count, dtype=np.int64),
        "job": ("",) * count,
    }
    moves = RecordedMoves(**{**fields, **columns})
    return Recording("", moves, None, None, RecordingSettings(), robot, tool, "")
