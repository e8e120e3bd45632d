"""From a recording to a signature with all that the recording tells: straight moves, and the parts beside them.

Code: H021 what was learnt beside straight moves.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.diagnostic import Diagnostic, info
from olp.signature.calibrate import AUTO
from olp.signature.calibrate import calibrate as calibrate_straight
from olp.signature.document import Signature
from olp.signature.moveset import moves_of_recording
from olp.signature.parts import (
    CIRCULAR,
    CORNER,
    FEWEST,
    JOINT,
    KINDS,
    STOP,
    Part,
    learn_part,
)
from olp.signature.recorded import Rows, rows_of
from olp.signature.stretches import stretches_of

if TYPE_CHECKING:
    from olp.recording import Recording
    from olp.robot import Robot

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]
Mask = NDArray[np.bool_]

NAMED = "named_terms"  # learnt from the whole recording by a diagnosis
# Speeds this far apart tell what a stop costs at any speed from what grows with the speed.
_RATIO = 1.5


class _Stretches(NamedTuple):
    """m stretches with corners, their sums [s] (m,)."""

    measured: Floats
    plain: Floats  # without corners
    saving: Floats
    corners: Floats
    first: NDArray[np.intp]  # row of each
    rows: Mask  # (n,) of the recording that are in one


def calibrate(
    recording: Recording, method: str = AUTO, robot: Robot | None = None
) -> tuple[Signature, tuple[Diagnostic, ...]]:
    """The signature of the robot that was recorded, and what there is to say about the recording.

    `method`: a name of `estimator_names()`, or "auto": the one that predicts held-out moves and start points of this
    recording best, of those that learn from moves alone. `robot`: instead of the recording's. Raises OlpError: H001,
    H002, H003, of "named_terms" H040 and N010.
    """
    if robot is not None:
        recording = replace(recording, robot=robot)
    if method == NAMED:
        from olp.signature.named import signature_of_recording

        return signature_of_recording(recording)
    parts: dict[str, Part] = {}
    straight = recording
    stop = _learn_stop(recording)
    if stop is not None:
        parts[STOP] = stop
        straight = _without_stops(recording, stop.value("fixed_time"))
    signature, told = calibrate_straight(straight, method, robot)
    signature = replace(signature, parts=parts)
    if _beside(recording):
        rows = rows_of(signature, recording, lambda says: None)
        for kind, learn in ((JOINT, _learn_joint), (CIRCULAR, _learn_curves), (CORNER, _learn_corners)):
            part = learn(rows)
            if part is not None:
                parts[kind] = part
                rows = rows.with_part(kind, part)
    return signature, (*told, *(_told(kind, part, recording.path) for kind, part in parts.items()))


def _beside(recording: Recording) -> bool:
    """Whether there is anything but straight moves from stop to stop."""
    others = any(kind in (JOINT, CIRCULAR) for kind in recording.moves.kinds)
    return others or bool(stretches_of(recording.moves).ends_rolling.any())


def _told(kind: str, part: Part, file: str) -> Diagnostic:
    what = {STOP: "straight moves at several speeds", CORNER: "stretches with corners"}.get(
        kind, f"{kind} moves"
    )
    learnt = ", ".join(
        f"{name} {p.value:.4g} ± {p.sd:.2g} {p.unit}"
        for name, p in part.quantities.items()
        if p.sd is not None
    )
    held = f"held out {part.unlearnt:.2f} % without, {part.learnt:.2f} % with it"
    return info("H021", f"{part.rows} {what}: {learnt or 'as the model says'} ({held})", file=file)


def _learn_stop(recording: Recording) -> Part | None:
    """What a stop costs at any speed; None where the speeds do not tell or nothing is gained by it."""
    moves, _ = moves_of_recording(recording)
    moves = moves.take(np.isfinite(moves.duration) & (moves.duration > 0))
    if len(moves) < FEWEST or moves.speed.max() < _RATIO * moves.speed.min():
        return None
    way, speed, measured = moves.length, moves.speed, moves.duration
    start = np.array([0.0, max(float(np.median((measured - way / speed) / speed)), 1e-6)])

    def model(q: Floats) -> Floats:
        whole = speed * speed * q[1] <= way
        return np.asarray(q[0] + np.where(whole, way / speed + speed * q[1], 2 * np.sqrt(way * q[1])))

    part, found = learn_part(STOP, model, measured, _labels(moves.program), start)
    return part if 0 in found.form and part.value("fixed_time") > 0 else None


def _without_stops(recording: Recording, fixed: float) -> Recording:
    """The recording with that much taken off its straight moves from stop to stop."""
    _, rows = moves_of_recording(recording)
    duration = recording.moves.duration.copy()
    duration[rows] -= fixed
    return replace(recording, moves=replace(recording.moves, duration=duration))


def _learn_joint(rows: Rows) -> Part | None:
    at = _stop_to_stop(rows, "joint")
    if at.sum() < FEWEST:
        return None
    motions, measured = rows.motions.take(at), rows.moves.duration[at]
    start = np.array([KINDS[JOINT].quantities[0].plain, rows.settling])
    part, _ = learn_part(
        JOINT, lambda q: motions.duration(q[0], 2) + q[1], measured, _groups(rows, at), start
    )
    return part


def _learn_curves(rows: Rows) -> Part | None:
    at = _stop_to_stop(rows, "circular")
    if at.sum() < FEWEST:
        return None
    motions, measured = rows.motions.take(at), rows.moves.duration[at]
    stop = rows.times.fixed[at]
    part, _ = learn_part(
        CIRCULAR, lambda q: motions.duration(q[0], 2) + stop + q[1], measured, _groups(rows, at)
    )
    return part


def _learn_corners(rows: Rows) -> Part | None:
    found = _stretches(rows)
    if len(found.measured) < FEWEST:
        return None

    def model(q: Floats) -> Floats:
        return np.asarray(found.plain - q[0] * found.saving + q[1] + q[2] * found.corners)

    groups = _labels(tuple(rows.moves.job[i] for i in found.first.tolist()))
    part, _ = learn_part(CORNER, model, found.measured, groups, law=rows.law)
    # The sum of a stretch is what was fitted; where its rows part is the recorder's convention, and scatters more.
    times = rows.with_part(CORNER, part).times
    off = np.sort(np.abs(rows.moves.duration - times.duration)[found.rows])
    within = float(off[min(int(np.ceil(0.95 * (len(off) + 1))), len(off)) - 1])
    return part._replace(row_half=max(within, part.spread.half / 2))


def _stretches(rows: Rows) -> _Stretches:
    """The stretches with corners of which every row was measured and can be predicted."""
    label, times, moves = rows.stretches.label, rows.times, rows.moves
    rolls = rows.stretches.ends_rolling
    corners = np.bincount(label, rolls)
    plain = times.floor + times.over + times.fixed
    whole = (
        np.isfinite(plain) & np.isfinite(moves.duration) & np.isfinite(times.saving) & ~rows.stretches.open
    )
    good = (corners > 0) & (np.bincount(label, ~whole) == 0)
    first = np.unique(label, return_index=True)[1]
    sums = [np.bincount(label, np.nan_to_num(v))[good] for v in (moves.duration, plain, times.saving)]
    return _Stretches(sums[0], sums[1], sums[2], corners[good].astype(np.float64), first[good], good[label])


def _stop_to_stop(rows: Rows, kind: str) -> Mask:
    at = np.array([name == kind for name in rows.moves.kinds], dtype=bool)
    at &= (rows.stretches.stops == 2) & ~rows.stretches.open
    return np.asarray(at & np.isfinite(rows.times.duration) & np.isfinite(rows.moves.duration))


def _groups(rows: Rows, at: Mask) -> Labels:
    return _labels(tuple(rows.moves.job[i] for i in np.nonzero(at)[0].tolist()))


def _labels(names: tuple[str, ...]) -> Labels:
    order: dict[str, int] = {}
    return np.array([order.setdefault(name, len(order)) for name in names], dtype=np.int64)
