"""Named terms as the parameters of a signature: what a diagnosis found, and the simulation it was found beside.

A term that is written here is rebuilt without the recording: its form by name, the values that do nothing (`nulls`),
and the numbers of the learnt moves that a form refers to (see `Case.number`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.identification.diagnosis.case_making import case_beside, with_rivals
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR, RecordedMoves
from olp.identification.recording.recording import Recording
from olp.identification.recording.settings import RecordingSettings
from olp.identification.signature.coefficients import TERMS, LearntParameter, Parameters
from olp.identification.signature.document import Signature
from olp.identification.signature.moveset import MoveSet, with_points
from olp.timing.physics import Form, MoveTerm, TermParameter, load_term
from olp.timing.physics._case import MeasuredMoves, Rates

if TYPE_CHECKING:
    from olp.robots.geometry import Pose
    from olp.robots.model import Robot


_FREE = math.inf  # a term in a file is applied, not fitted: it has no bounds
_NUMBER = "learnt moves: "
_PAYLOAD, _INERTIA = "payload", "payload inertia"
_LINEAR, _RAMP, _LAW, _OVERLAP, _SPLIT = (
    "simulation: linear acceleration",
    "simulation: joint ramp",
    "simulation: corner law",
    "simulation: corner overlap",
    "simulation: corner split",
)


class NamedModel(NamedTuple):
    """A model and the judged simulation's own motion.

    `linear` [m/s²] where a move does not say, `ramp` [s] of every axis to its rated speed, 0: as the robot's file says:
    how the simulation accelerates; nan for kinds of moves that were not learnt, of which the terms say nothing.
    `law`, `overlap`, `split`: how it passes rounded corners. `payload` [kg], `inertia` [kg m²]: of the load where a
    move does not say, nan where nothing does. `numbers`: see `Case.number`.
    """

    model: DurationModel
    linear: float
    ramp: float
    law: str = "stop"
    overlap: float = 1.0
    split: float = 0.5
    payload: float = math.nan
    inertia: float = math.nan
    numbers: Mapping[str, float] = {}


def to_parameters(named: NamedModel, sd: Mapping[tuple[str, str], float]) -> dict[str, LearntParameter]:
    """`sd`: standard deviations by the labels of part and parameter."""
    parts = named.model.parts
    found = {
        "terms": LearntParameter([part.term.name for part in parts], ""),
        "forms": LearntParameter([part.form.key for part in parts], ""),
        "axes": LearntParameter([part.form.axis for part in parts], ""),
        "nulls": LearntParameter([[_written(p.null) for p in part.form.parameters] for part in parts], ""),
    }
    for part in parts:
        for parameter, value in zip(part.form.parameters, part.values.tolist(), strict=True):
            key = _key(part.term.name, part.form.axis, parameter.name)
            found[key] = LearntParameter(value, parameter.unit, sd.get((part.label, parameter.name)))
    found[_LINEAR] = LearntParameter(_written(named.linear), "m/s²")
    found[_RAMP] = LearntParameter(_written(named.ramp), "s")
    found[_LAW] = LearntParameter(named.law, "")
    found[_OVERLAP], found[_SPLIT] = LearntParameter(named.overlap, "1"), LearntParameter(named.split, "1")
    for name, value, unit in ((_PAYLOAD, named.payload, "kg"), (_INERTIA, named.inertia, "kg m²")):
        if math.isfinite(value):
            found[name] = LearntParameter(value, unit)
    found.update({f"{_NUMBER}{name}": LearntParameter(value, "SI") for name, value in named.numbers.items()})
    return found


def from_parameters(parameters: Parameters) -> NamedModel:
    """What `to_parameters` wrote. Raises KeyError, TypeError, ValueError for anything else; OlpError N001."""
    lists = [parameters[name].value for name in ("terms", "forms", "axes", "nulls")]
    parts = tuple(
        _part(parameters, str(name), str(key), int(axis), nulls)
        for name, key, axis, nulls in zip(*lists, strict=True)
    )
    return NamedModel(
        DurationModel(parts),
        _read(parameters[_LINEAR].value),
        _read(parameters[_RAMP].value),
        str(parameters[_LAW].value),
        float(parameters[_OVERLAP].value),
        float(parameters[_SPLIT].value),
        _optional(parameters, _PAYLOAD),
        _optional(parameters, _INERTIA),
        {
            name.removeprefix(_NUMBER): float(p.value)
            for name, p in parameters.items()
            if name.startswith(_NUMBER)
        },
    )


def _part(parameters: Parameters, name: str, key: str, axis: int, nulls: list[float | None]) -> ModelPart:
    term = load_term(name)
    if not isinstance(term, MoveTerm):
        raise ValueError(f"{name} is no term of moves")
    prefix = _key(name, axis, "")
    own = [(k.removeprefix(prefix), p) for k, p in parameters.items() if k.startswith(prefix)]
    values = np.array([float(p.value) for _, p in own])
    if not len(values) or not np.isfinite(values).all():
        raise ValueError(f"{name} without values")
    known = tuple(
        TermParameter(label, p.unit, -_FREE, _FREE, math.inf if null is None else float(null))
        for (label, p), null in zip(own, nulls, strict=True)
    )
    return ModelPart(term, Form(key, known, "", axis), values)


def _optional(parameters: Parameters, name: str) -> float:
    return float(parameters[name].value) if name in parameters else math.nan


def _key(term: str, axis: int, parameter: str) -> str:
    return f"{term}: {parameter}" if axis < 0 else f"{term} {axis}: {parameter}"


def _written(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _read(value: float | None) -> float:
    return math.nan if value is None else float(value)


# --- Term case ---
# Moves of any program as the terms of a diagnosis see them, with the motion of the simulation that was judged.
#
# Code: H011 a term needs axes that are not known.

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
        made = case_beside(replace(recording, moves=asked), None, [])
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
    share = slow / case.base.accelerate
    base = case.base.with_(
        accelerate=slow,
        decelerate=slow,
        open_start=case.base.open_start * share,
        open_end=case.base.open_end * share,
        law=named.law,
        overlap=named.overlap,
        split=named.split,
    )
    asked = replace(
        case,
        base=base,
        simulated=base.duration(),
        numbers=named.numbers,
        derived={_RUNNING_TIME: np.full(len(case), np.inf)},
    )
    return with_rivals(asked, np.ones(len(asked)))


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
    if key in ("whole arm", "three bodies"):
        return rates is not None and rates.bodies is not None
    if name == "gravity" and key.startswith("each axis"):
        return rates is not None and rates.lifts is not None
    if name == "gravity" and key == "incline of the tool":
        return rates is not None and rates.climb is not None
    if name == "payload-inertia" and key == "limit":
        return rates is not None and rates.rated_acceleration is not None
    if name == "payload-inertia" and part.term.by_axis(part.form):
        return rates is not None
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


# --- Term durations ---
# Durations of whole rows, corners and joint moves included, by the terms of a signature of method named_terms.

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
