"""Straight lines that are known to be possible: those that were run, and those that `olp probe` proves in their box."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.units import mm
from olp.identification.diagnosis.axis_rates import PLACES, rates_of
from olp.identification.recording.moves import LINEAR, RecordedMoves
from olp.robots.geometry import rotation_from_angles
from olp.timing.physics._case import Floats, MeasuredMoves, Rates

if TYPE_CHECKING:
    from olp.identification.recording import Recording

Labels = NDArray[np.int64]

_MOST = 10  # recorded lines and proved lines, each
SHORTEST = 10 * mm


class StraightLines(NamedTuple):
    """m straight lines. `rates` (m, 21, k) per metre, None: axes are not known; `checked` (m,): rates are known."""

    start: Floats  # (m, 3) [m]
    end: Floats  # (m, 3) [m]
    fastest: Floats  # (m,) [m/s] that was run there; 0 where nothing was
    rates: Floats | None
    checked: NDArray[np.bool_]
    bodies: Floats  # (m, 21, 2, 3) [m] elbow and wrist centre, nan where not known

    @property
    def length(self) -> Floats:
        return np.asarray(np.linalg.norm(self.end - self.start, axis=1))


def lines_of(case: MeasuredMoves, recording: Recording, straight: Labels) -> StraightLines:
    kept = _spread(case.start[straight], case.end[straight])
    rows = straight[kept]
    top = float(case.base.speed[straight].max())
    rates = case.rates
    path = None if rates is None else rates.path[rows]
    known = np.zeros(len(rows), dtype=bool) if rates is None else rates.known[rows]
    start, end = case.start[rows], case.end[rows]
    recorded = StraightLines(start, end, case.base.speed[rows], path, known, _bodies(rates, rows))
    further = _proved(recording, case, straight, top) if rates is not None and rates.exact else None
    if further is None:
        return recorded
    assert path is not None
    assert further.rates is not None
    had = np.concatenate([recorded.start, recorded.end], axis=1)
    had = np.concatenate([had, np.roll(had, 3, axis=1)])
    more = np.concatenate([further.start, further.end], axis=1)
    new = np.abs(more[:, None] - had[None]).max(axis=2).min(axis=1) > SHORTEST
    pairs = zip(recorded, further, strict=True)
    return StraightLines(*(np.concatenate([a, b[new]]) for a, b in pairs))  # type: ignore[index]


def _proved(
    recording: Recording, case: MeasuredMoves, straight: Labels, speed: float
) -> StraightLines | None:
    """Lines between points of the recorded box that can be run at the fastest recorded speed."""
    from olp.identification.probe.candidates import candidates as lines_in
    from olp.identification.signature.axis_paths import has_axes

    robot, moves = recording.robot, recording.moves
    angles = usual_angles(recording)
    if robot is None or not has_axes(robot) or len(robot.axes) != 6 or angles is None:
        return None
    points = np.concatenate([case.start[straight], case.end[straight]])
    box = np.stack([points.min(axis=0), points.max(axis=0)], axis=1)
    if not (np.ptp(box, axis=1) > SHORTEST).any():
        return None
    shortest = 0.3 * float(np.linalg.norm(box[:, 1] - box[:, 0]))
    found = lines_in(robot, box, rotation_from_angles(angles), recording.tool, speed, shortest)
    if not len(found.starts):
        return None
    start, end = found.points[found.starts], found.points[found.ends]
    kept = _spread(start, end)
    start, end = start[kept], end[kept]
    hypothetical = replace(recording, moves=straight_moves(moves, start, end, angles))
    rates, _ = rates_of(hypothetical, np.arange(len(start)), np.linalg.norm(end - start, axis=1))
    if rates is None:
        return None
    bodies = _bodies(rates, np.arange(len(start)))
    return StraightLines(start, end, np.zeros(len(start)), rates.path, rates.known, bodies)


def _bodies(rates: Rates | None, rows: Labels) -> Floats:
    if rates is None or rates.bodies is None:
        return np.full((len(rows), PLACES, 2, 3), np.nan)
    return np.asarray(rates.bodies[rows])


def _spread(start: Floats, end: Floats) -> Labels:
    """Rows of lines far from each other; a line that is there in both senses is one line."""
    from olp.identification.signature.domain import spread_out

    ends = np.round(np.concatenate([start, end], axis=1), 4)
    turned = [tuple(row[:3]) > tuple(row[3:]) for row in ends.tolist()]
    same = np.where(np.array(turned)[:, None], np.roll(ends, 3, axis=1), ends)
    once = np.sort(np.unique(same, axis=0, return_index=True)[1])
    return np.asarray(once[spread_out(same[once], min(_MOST, len(once)))])


def usual_angles(recording: Recording) -> Floats | None:
    """(3,) [rad] The orientation that most moves start with, None where none tells it."""
    angles = recording.moves.start_angles
    angles = angles[np.isfinite(angles).all(axis=1)]
    if not len(angles):
        return None
    _, first, count = np.unique(np.round(angles, 5), axis=0, return_index=True, return_counts=True)
    return np.asarray(angles[first[np.argmax(count)]])


def straight_moves(like: RecordedMoves, start: Floats, end: Floats, angles: Floats) -> RecordedMoves:
    """Recorded moves without durations along these lines (n, 3) [m]."""
    count = len(start)
    changes: dict[str, object] = {}
    for column in fields(RecordedMoves):
        value = getattr(like, column.name)
        if isinstance(value, np.ndarray):
            empty = 0 if value.dtype.kind == "i" else np.nan
            changes[column.name] = np.full((count, *value.shape[1:]), empty, dtype=value.dtype)
    turned = np.broadcast_to(angles, (count, 3))
    changes |= {"move": np.arange(count), "start": start, "end": end, "job": ("",) * count}
    changes |= {"kind": np.full(count, LINEAR, np.int8), "start_angles": turned, "end_angles": turned}
    return replace(like, covariates={}, texts={}, **changes)  # type: ignore[arg-type]
