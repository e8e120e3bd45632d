"""What moves take that run into each other: what their corners save by the law, and the sum from stop to stop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.coefficients import CIRCULAR, CORNER, JOINT, STOP, Parts, value_of
from olp.identification.signature.moveset import joint_ends
from olp.identification.signature.stretches import Stretches
from olp.languages.vendor import blending_of
from olp.runtime.plan import USUAL_LAW
from olp.timing.blending.law import load_law

if TYPE_CHECKING:
    from olp.identification.recording.moves import RecordedMoves
    from olp.robots.geometry import Pose
    from olp.robots.model import Robot
    from olp.timing.arm_moves import JointTimes


Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


# --- Motions ---
# Moves of every kind as olp's own model of constant acceleration sees them: ways, speeds, accelerations.


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

    @property
    def along(self) -> Floats:
        """(n,) [s²/m] one over the acceleration of the tool along its way, as the slowest axis has it."""
        with np.errstate(divide="ignore", invalid="ignore"):
            lead = np.argmax(np.nan_to_num(self.distance / self.speed), axis=1)[:, None]
            turned, slowness = (np.take_along_axis(v, lead, 1)[:, 0] for v in (self.distance, self.slowness))
            return np.asarray(slowness * turned / self.way)

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
    from olp.robots.times_to_speed import turn_limits
    from olp.timing.accelerations import MotionLimits, constant_axes

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


# --- Times ---


ROUNDED = "radius"  # name of the blending law


class Times(NamedTuple):
    """(n,) [s] per row. `duration` = `floor` + `over` + `fixed` - `saved`, never below zero.

    `floor`: at programmed speed; `over`: speeding up and braking where the arm stands, `full`: if it stood at both
    ends; `fixed`: per exact stop; `saved`: by the corner at the row's end, as learnt; `saving`: the same by the law
    alone, nan where it is not known.
    """

    floor: Floats
    over: Floats
    full: Floats
    fixed: Floats
    saved: Floats
    saving: Floats

    @property
    def duration(self) -> Floats:
        return np.maximum(self.floor + self.over + self.fixed - self.saved, 0.0)


class JointRows(NamedTuple):
    """`rows` (m,) of a recording whose `times` (m,) from rest to rest the learnt law of joint moves told.

    `floor` (m,) [s] at programmed speed; `stop` [s] of a duration, for the stop alone.
    """

    rows: NDArray[np.intp]
    times: JointTimes
    floor: Floats
    stop: float


def times_of(
    moves: RecordedMoves,
    motions: Motions,
    stretches: Stretches,
    parts: Parts,
    saving: Floats,
    settling: float,
    path_stop: float,
    joints: JointRows | None = None,
) -> Times:
    """`saving` (n,) [s] of `law_savings`; [s] per exact stop: `settling` of joint moves when none was learnt,
    `path_stop` of lines and arcs beyond what was learnt.

    `joints`: joint moves of which more was learnt than that.
    """
    from olp.identification.recording.moves import CIRCULAR as CURVED
    from olp.identification.recording.moves import JOINT as TURNING

    scale, fixed = np.ones(len(moves)), np.full(len(moves), path_stop + value_of(parts, STOP, "fixed_time"))
    scale[moves.kind == CURVED] = value_of(parts, CIRCULAR, "acceleration_time_scale")
    fixed[moves.kind == CURVED] += value_of(parts, CIRCULAR, "fixed_time")
    turning = moves.kind == TURNING
    scale[turning] = value_of(parts, JOINT, "acceleration_time_scale")
    fixed[turning] = value_of(parts, JOINT, "fixed_time") if JOINT in parts else settling
    floor = motions.floor
    over = motions.duration(scale, stretches.stops) - floor
    full = motions.duration(scale, 2) - floor
    if joints is not None:
        at = joints.rows
        stop = np.minimum(joints.stop, 0.5 * joints.times.duration)
        floor[at] = np.minimum(joints.floor, joints.times.duration - stop)
        full[at] = joints.times.duration - stop - floor[at]
        over[at] = full[at] * stretches.stops[at] / 2
        fixed[at] = stop
    saved = value_of(parts, CORNER, "saving_scale") * np.nan_to_num(saving)
    saved = np.where(stretches.ends_rolling, saved - value_of(parts, CORNER, "corner_time"), 0.0)
    last = stretches.begins_rolling & ~stretches.ends_rolling
    saved -= np.where(last, value_of(parts, CORNER, "stretch_time"), 0.0)
    return Times(floor, over, full, np.where(stretches.ends_rolling, 0.0, fixed), saved, saving)


def law_savings(
    moves: RecordedMoves, motions: Motions, stretches: Stretches, robot: Robot | None
) -> tuple[Floats, str]:
    """(n,) [s] that the corner at the end of each row saves by the blending law, and the law's name.

    Zero at stops and at corners without a tag; nan where the zone of a position level is not known.
    """
    saving = np.zeros(len(moves))
    law = law_of(moves, robot)
    at = np.nonzero(stretches.ends_rolling)[0]
    if not len(at):
        return saving, law
    zone = zones(moves, robot)
    if load_law(law).runs_at_once:
        labels = np.unique(stretches.label[at])
        for begin, end in zip(
            np.searchsorted(stretches.label, labels).tolist(),
            np.searchsorted(stretches.label, labels, side="right").tolist(),
            strict=True,
        ):
            rows = slice(begin, end)
            saving[rows] = _overlaps(motions.way[rows], motions.pace[rows], zone[rows])
    else:
        saving[at] = _rounded(moves, motions, at, zone[at])
    return np.where(stretches.ends_rolling, saving, 0.0), law


def law_of(moves: RecordedMoves, robot: Robot | None) -> str:
    """Position levels overlap, and all zones of a maker whose moves run at once; what else is written is a radius."""
    if (moves.level > 0).any() or robot is None:
        return USUAL_LAW
    law = blending_of(robot.maker)
    return law if law and load_law(law).runs_at_once else ROUNDED


def zones(moves: RecordedMoves, robot: Robot | None) -> Floats:
    """(n,) [m]; 0 without a tag, nan where a level's zone is not known."""
    zone = moves.blend.copy()
    level = moves.level.astype(np.int64)
    told = (level > 0) & ~(np.nan_to_num(zone) > 0)
    if robot is not None and robot.blend_zones is not None:
        table = np.array(robot.blend_zones)
        zone[told] = table[np.minimum(level[told], len(table)) - 1]
    else:
        zone[told] = np.nan
    return zone


def _overlaps(way: Floats, pace: Floats, zone: Floats) -> Floats:
    """(n,) [s] of the rows of one stretch, as `olp time` counts them (olp/timing/chain.py)."""
    from olp.timing.blending.yaskawa import PositionLevels, delays

    half = 0.5 * np.minimum(way[:-1], way[1:])
    with np.errstate(divide="ignore", invalid="ignore"):
        overlap = np.minimum(zone[:-1], half) / pace[:-1]
        cruise = way / pace
    known = np.nan_to_num(overlap)
    late = delays(
        np.where(np.isfinite(cruise), cruise, np.inf),
        np.insert(known, 0, 0.0),
        np.append(known, 0.0),
        PositionLevels().alone,
    )
    return np.append(overlap / 2 - late[:-1], 0.0)


def _rounded(moves: RecordedMoves, motions: Motions, at: NDArray[np.intp], zone: Floats) -> Floats:
    """(m,) [s] that arcs of radius `zone` save, braking down to their speed included; a loss is negative."""
    from olp.timing.blending.law import Corners

    result = np.zeros(len(at))
    pace, push = motions.pace, motions.along
    with np.errstate(invalid="ignore"):
        good = np.isfinite(zone) & (zone > 0) & (pace[at] > 0) & (pace[at + 1] > 0)
        good &= (push[at] > 0) & (push[at + 1] > 0)
    one, two = at[good], at[good] + 1
    result[~good & ~(zone == 0)] = np.nan
    if not len(one):
        return result
    first, second = moves.end[one] - moves.start[one], moves.end[two] - moves.start[two]
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.sum(first * second, axis=1) / (
            np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
        )
    turn = np.arccos(np.clip(np.nan_to_num(cosine, nan=1.0), -1.0, 1.0))
    corners = Corners.of(
        motions.way[one],
        motions.way[two],
        pace[one],
        pace[two],
        turn,
        zone[good],
        1 / push[one],
        1 / push[two],
    )
    passage = load_law(ROUNDED).passage(corners)
    brake = (pace[one] - passage.speed_in) ** 2 * push[one] / (2 * pace[one])
    push_up = (pace[two] - passage.speed_out) ** 2 * push[two] / (2 * pace[two])
    saved = passage.trim_before / pace[one] + passage.trim_after / pace[two] - passage.duration
    result[good] = saved - brake - push_up
    return result
