"""Moves of every kind as olp's own model of constant acceleration sees them: ways, speeds, accelerations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.places import joint_ends

if TYPE_CHECKING:
    from olp.identification.recording.moves import RecordedMoves
    from olp.robots.geometry import Pose
    from olp.robots.robot import Robot

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """n moves of k axes that start and stop together; a path has two "axes", the travel and the turn of the tool.

    All (n, k): `distance` [m | rad], `speed` [per s] and `slowness` [s² per] one over the acceleration; nan in moves
    of which nothing can be said. `way` (n,) [m] of the tool, the chord of a joint move.
    """

    distance: Floats
    speed: Floats
    slowness: Floats
    way: Floats

    def __len__(self) -> int:
        return len(self.way)

    @property
    def floor(self) -> Floats:
        """(n,) [s] at programmed speed from end to end, nothing accelerates faster."""
        return self.duration(0.0, 0)

    @property
    def pace(self) -> Floats:
        """(n,) [m/s] of the tool, for joint moves its mean along the chord; nan where it does not travel."""
        floor = self.floor
        return np.asarray(np.divide(self.way, floor, out=np.full(len(self), np.nan), where=floor > 0))

    def duration(self, scale: Floats | float, stops: NDArray[np.int64] | int) -> Floats:
        """(n,) [s], 1/a times `scale`; `stops`: at how many ends the arm stands. The slowest axis decides.

        Both ends: L/v + v/a, or 2√(L/a) below v; one end: L/v + v/2a, or √(2L/a).
        """
        s = self.slowness * np.broadcast_to(scale, len(self))[:, None]
        ends = np.broadcast_to(stops, len(self))[:, None]
        way, speed = self.distance, self.speed
        ramps = speed * s * ends / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            peak = np.where(ends == 2, 2 * np.sqrt(way * s), np.sqrt(2 * way * s))
            time = np.where(speed * ramps <= way, way / speed + ramps, peak)
            time = np.where(way == 0, 0.0, time)
            time = np.where(np.isfinite(speed), time, np.nan)
        return np.asarray(np.max(time, axis=1)) if time.shape[1] else np.full(len(self), np.nan)

    def turning(self, paths: Mask) -> Mask:
        """(n,) which of these rows the turn of the tool rules, not its travel."""
        travel = Motions(self.distance[:, :1], self.speed[:, :1], self.slowness[:, :1], self.way)
        own = travel.duration(1.0, 2)
        with np.errstate(invalid="ignore"):
            return np.asarray(paths & (self.duration(1.0, 2) > own * (1 + 1e-9)))

    def take(self, rows: Mask) -> Motions:
        return Motions(self.distance[rows], self.speed[rows], self.slowness[rows], self.way[rows])


def motions_of(
    moves: RecordedMoves, robot: Robot | None, tool: Pose | None, report: Callable[[str], None]
) -> Motions:
    """Joint, circular and straight rows; `slowness` of paths is nan until `with_slowness` tells it.

    `report` is called with what had to be assumed of the axes.
    """
    from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR
    from olp.timing.accelerations import MotionLimits, constant_axes
    from olp.timing.demand import turn_limits

    count = len(moves)
    axes = max(len(robot.axes) if robot else 0, 2)
    distance, speed, slowness = (np.full((count, axes), np.nan) for _ in range(3))
    way = moves.chord.copy()
    curved = moves.kind == CIRCULAR
    way[curved] = arc_length(moves.start[curved], moves.via[curved], moves.end[curved])
    along = (moves.kind == LINEAR) | curved
    # A joint move at a speed of the tool goes about as a straight one.
    along |= (moves.kind == JOINT) & np.isnan(moves.speed_fraction) & np.isfinite(moves.speed)
    distance[along], speed[along], slowness[along] = 0.0, 1.0, 0.0
    distance[along, 0], speed[along, 0], slowness[along, 0] = (
        way[along],
        (moves.speed * moves.played)[along],
        np.nan,
    )
    rate, push = turn_limits(robot)
    distance[along, 1], speed[along, 1], slowness[along, 1] = _turned(moves)[along], rate, 1.0 / push
    turns = (moves.kind == JOINT) & ~along
    if robot is not None and turns.any():
        start, end = joint_ends(moves, robot, tool)
        fraction = (moves.speed_fraction * moves.played)[:, None]
        rated = moves.acceleration_fraction[:, None]
        reach = constant_axes(robot, MotionLimits(None, report)) * np.where(np.isfinite(rated), rated, 1.0)
        distance[turns], speed[turns], slowness[turns] = 0.0, 1.0, 0.0
        own = slice(0, len(robot.axes))
        distance[turns, own] = np.abs(end - start)[turns]
        speed[turns, own] = (fraction * robot.speeds)[turns]
        slowness[turns, own] = (1.0 / reach)[turns]
    return Motions(distance, speed, slowness, way)


def with_slowness(motions: Motions, rows: NDArray[np.int64], slowness: Floats) -> Motions:
    """`slowness` (m,) [s²/m] of the paths in these rows."""
    told = motions.slowness.copy()
    told[rows, 0] = slowness
    return replace(motions, slowness=told)


def _turned(moves: RecordedMoves) -> Floats:
    """(n,) [rad] that the tool turns by; 0 where its orientation is not told at both ends."""
    from olp.robots.geometry import rotation_angle, rotation_from_angles

    result = np.zeros(len(moves))
    told = np.isfinite(np.concatenate([moves.start_angles, moves.end_angles], axis=1)).all(axis=1)
    if told.any():
        ends = (rotation_from_angles(a[told]) for a in (moves.start_angles, moves.end_angles))
        result[told] = rotation_angle(*ends)
    return result


def arc_length(start: Floats, via: Floats, end: Floats) -> Floats:
    """(n,) [m] of the arc through three points (n, 3); the chord where they lie on a line, nan where not told."""
    from olp.runtime.paths import circle, swept_angle

    with np.errstate(invalid="ignore"):
        centre, radius, axis = circle(start, via, end)
        swept = swept_angle(start - centre, end - centre, axis)
        chord = np.linalg.norm(end - start, axis=1)
        told = np.isfinite(np.concatenate([start, via, end], axis=1)).all(axis=1)
        return np.where(told, np.where(np.isfinite(radius), radius * swept, chord), np.nan)
