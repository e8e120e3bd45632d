"""What moves take that run into each other: what their corners save by the law, and the sum from stop to stop."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.coefficients import CIRCULAR, CORNER, JOINT, STOP, Parts, value_of
from olp.identification.signature.motions import Motions
from olp.identification.signature.stretches import Stretches
from olp.languages.vendor import blending_of
from olp.runtime.plan import USUAL_LAW
from olp.timing.blending.law import load_law

if TYPE_CHECKING:
    from olp.identification.recording.moves import RecordedMoves
    from olp.robots.robot import Robot
    from olp.timing.arm_moves import JointTimes

Floats = NDArray[np.float64]
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
    pace, push = motions.pace, motions.slowness[:, 0]
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
