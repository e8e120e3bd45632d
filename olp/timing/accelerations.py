"""Accelerations of a plan's moves: those of the law that the user chose, else constant ones.

A line keeps its linear acceleration wherever the law allows more: the law limits the axes, the linear acceleration
is what the controller uses.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.units import mm
from olp.robots.times_to_speed import times_to_speed
from olp.runtime.plan import Plan
from olp.timing.arm_prior import LineAcceleration, line_acceleration

if TYPE_CHECKING:
    from olp.robots.model import Robot
    from olp.timing.acceleration.law import AccelerationLaw

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

_SAMPLES = 9  # of a line: the slope at an end comes from the three next to it
_STEEP = (
    50.0  # [rad/m] an axis that turns more than this is near a singularity, where no slope is worth using
)


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """Accelerations and speeds to use. `report` is called with each assumption. `law` None: constant accelerations."""

    linear_acceleration: float | None  # [m/s²]
    report: Callable[[str], None]
    law: AccelerationLaw | None = None
    axis_scale: float = (
        1.0  # by which the arm's axes take longer to reach their speed, as a signature learnt it
    )
    learnt: Robot | None = None  # whose joint moves a learnt law times: nothing is assumed of its axes


def constant_axes(robot: Robot, limits: MotionLimits) -> Floats:
    """Constant accelerations of the axes (k,) [rad/s² | m/s²]: from the robot file, or typical of arms of its class
    (reported as an assumption).
    """
    given = robot.accelerations
    unknown = np.isnan(given)
    if not unknown.any():
        return given
    known = times_to_speed(robot)
    times = ", ".join(
        f"{axis} {time:.2f} s"
        for axis, time, use in zip(robot.axis_names, known.median, unknown, strict=True)
        if use
    )
    if robot is not limits.learnt:
        limits.report(
            f"accelerations of some axes of {robot.name} are not known: to rated speed as arms of its class ({times})"
        )
    return np.where(unknown, robot.speeds / known.median, given)


def of_axes(
    plan: Plan, robot: Robot, rows: Rows, fraction: Floats, limits: MotionLimits
) -> tuple[Floats, Floats]:
    """Acceleration and deceleration of each axis [rad/s² | m/s²], (n, k) or (k,), in joint moves at `fraction` (n,)
    of rated speed.
    """
    if not _usable(robot, limits):
        constant = constant_axes(robot, limits)
        return constant, constant
    assert limits.law is not None
    axes = plan.positions.axes[:, : len(robot.axes)]
    start, target = axes[plan.moves.start[rows]], axes[plan.moves.target[rows]]
    change = target - start
    if limits.law.name == "torque":
        up, down = _by_torque(robot, start, target, fraction, limits)
    else:
        up, down = (limits.law.accelerations(robot, q, d) for q, d in ((start, change), (target, -change)))
    if limits.law.name == "time_constant":  # every change of speed takes the same time, small ones too
        up, down = up * fraction[:, None], down * fraction[:, None]
    if np.isfinite(up).all() and np.isfinite(down).all():
        return up, down
    constant = constant_axes(robot, limits)
    return np.where(np.isfinite(up), up, constant), np.where(np.isfinite(down), down, constant)


def _by_torque(
    robot: Robot, start: Floats, target: Floats, fraction: Floats, limits: MotionLimits
) -> tuple[Floats, Floats]:
    """Acceleration and deceleration with all axes moving at once; nan where the torques cannot make the move or
    nothing moves.
    """
    from olp.timing.acceleration.torque import of_moves

    change = np.abs(target - start)
    up, down = np.full_like(change, np.nan), np.full_like(change, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.min(fraction[:, None] * robot.speeds / np.where(change > 0, change, np.nan), axis=1, initial=np.inf,
                      where=change > 0)  # fmt: skip
    known = np.isfinite(rate) & ~np.isnan(change).any(axis=1) & (rate > 0)
    if not known.any():
        return up, down
    found = of_moves(robot, start[known], target[known], rate[known])
    for says in found.assumptions:
        limits.report(says)
    limits.report("torque limits: without the mass of the tool and its load")
    for out, rates in ((up, found.acceleration), (down, found.deceleration)):
        out[known] = np.where(rates > 0, rates, np.nan)[:, None] * change[known]
    if (np.minimum(found.acceleration, found.deceleration) <= 0).any():
        limits.report(
            f"the torque limits of {robot.name} do not hold some poses: constant accelerations there"
        )
    return up, down


def of_lines(plan: Plan, rows: Rows, speed: Floats, limits: MotionLimits) -> tuple[Floats, Floats]:
    """Acceleration and deceleration [m/s²] (n,) along lines, arcs and splines at `speed` (n,) [m/s]."""
    acceleration = limits.linear_acceleration
    if acceleration is None:
        usual = line_acceleration(plan.robot)
        acceleration = usual.value
        if plan.robot is None or plan.robot.linear_acceleration is None:
            limits.report(_assumed(usual, plan.robot))
    up, down = np.full(len(rows), acceleration), np.full(len(rows), acceleration)
    if limits.law is None or limits.law.name == "constant":
        return up, down
    for index, robot in enumerate(plan.robots):
        at = np.flatnonzero(plan.moves.mechanism[rows] == index)
        if robot is None or not len(at) or not _usable(robot, limits):
            continue
        if limits.law.name == "time_constant":
            low = high = np.where(np.isfinite(speed[at]), speed[at], np.inf) / _seconds(limits.law, robot)
        else:
            low, high = _by_slope(plan, robot, rows[at], limits)
        up[at], down[at] = np.minimum(up[at], low), np.minimum(down[at], high)
    return up, down


def _assumed(usual: LineAcceleration, robot: Robot | None) -> str:
    value = f"{float(f'{usual.value / mm:.3g}'):g} mm/s²"
    if usual.published:
        return f"lines accelerate with {value} where none is programmed ({usual.source})"
    arm = "this arm" if robot is None else robot.name
    return f"the acceleration of lines is not published for {arm}: {value}, {usual.source}"


def filter_time(plan: Plan, limits: MotionLimits) -> float:
    """Time [s] of the acceleration filter that the chosen law already includes; 0 with laws that include none."""
    law, robot = limits.law, plan.robot
    if law is None or robot is None or law.name != "time_constant" or not law.knows(robot):
        return 0.0
    return _seconds(law, robot)


def _seconds(law: AccelerationLaw, robot: Robot) -> float:
    rest = np.zeros((1, len(robot.axes)))
    return float((robot.speeds / law.accelerations(robot, rest, rest))[0, 0])


def _by_slope(plan: Plan, robot: Robot, rows: Rows, limits: MotionLimits) -> tuple[Floats, Floats]:
    """Acceleration at the start and deceleration at the end of each row that the axes allow [m/s²] (n,); inf where
    unknown.
    """
    from olp.timing.retiming.along import measure, sample

    up, down = np.full(len(rows), np.inf), np.full(len(rows), np.inf)
    if robot.geometry is None or robot.geometry.links is None:
        limits.report(
            f"the acceleration law is used in joint moves of {robot.name} only: its inverse has no closed form"
        )
        return up, down
    axes = plan.positions.axes[:, : len(robot.axes)]
    moves = plan.moves
    known = (moves.length[rows] > 1e-9) & (measure(plan)[rows] > 1e-9)
    for end in (moves.start[rows], moves.target[rows]):
        known &= ~np.isnan(axes[end]).any(axis=1) & ~np.isnan(plan.positions.position[end]).any(axis=1)
    at = np.flatnonzero(known)
    if not len(at) or limits.law is None:
        return up, down
    looked = sample(plan, robot, rows[at], _SAMPLES)
    step = moves.length[rows[at]] / (_SAMPLES - 1)
    q = looked.joints
    for out, ends in ((up, (0, 1, 2)), (down, (-1, -2, -3))):
        first, second, third = (q[:, i] for i in ends)
        # Away from this end: at the target that is against the travel, as braking is.
        slope = (-3 * first + 4 * second - third) / (2 * step[:, None])
        usable = np.isfinite(slope).all(axis=1) & (np.abs(slope).max(axis=1) < _STEEP)
        if usable.any():
            out[at[usable]] = limits.law.along_path(robot, first[usable], slope[usable])[0]
    return up, down


def _usable(robot: Robot, limits: MotionLimits) -> bool:
    """Whether the chosen law has this robot's numbers; reports an assumption if it has not."""
    if limits.law is None or limits.law.name == "constant":
        return False
    if limits.law.knows(robot):
        return True
    limits.report(
        f"the {limits.law.name} acceleration law has no numbers of {robot.name}: constant accelerations"
    )
    return False
