"""Prior knowledge of an arm's moves, without any recording: each number with its source and its spread.

Joint moves: rated speeds of the robot file, times to speed that are published or learnt over arms of the same
class, known effects of the controller's generation. For an arm without a name: the arms of the library.

Lines and arcs: how fast the tool gains speed is a setting of the controller rather than an ability of the arm.
Where neither the robot file nor the controller's generation gives it, it is learnt over the arms for which it is
known (`line_accelerations.csv`): its logarithm is a common mean plus normal effects of the maker, the controller
and the arm; the answer is averaged over their spreads. `python bench/priors.py` predicts each arm from the others,
also by other laws (payload, a share of what the axes could do), which were farther off.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from functools import cache, lru_cache
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

import olp.robots
from olp.robots.controller_effects import KnownEffect, generation_of, generations_in
from olp.robots.model import Robot
from olp.timing.arm import MAIN, POSTURE, ArmTiming, names_of
from olp.timing.arm_moves import PriorArm

Floats = NDArray[np.float64]

_RATED_DOUBT: Final = (
    0.03  # of the logarithm: what rated speeds of data sheets differ from those that arms reach
)
_TIME_DOUBT_IN_COMMON: Final = (
    0.5  # share of the variance of times to speed that all axes of an arm have in common
)
_GIVEN_DOUBT: Final = 0.25  # of the logarithm of an acceleration that the robot file holds
# Of the logarithm: 338 joint moves of URScript in public programs ask for 1.4 (243), 0.8 (63), 0.7 and 0.5 rad/s².
_PROGRAMMED_DOUBT: Final = 0.4
# Log odds of the rotor's share where an acceleration is as programmed whatever the inertia.
_AS_PROGRAMMED: Final = (3.0, 0.5)
_UNKNOWN_TIME: Final = (
    0.25,
    0.6,
)  # [s], of the logarithm: middle of the arms of which times are known, any axis
_STOP: Final = (
    0.05,
    0.05,
)  # [s] usual profile filters are 0.1 s, part of which ends before a program goes on
_KNOWN_STOP_DOUBT: Final = 0.01  # [s]
_PERCENT: Final = (0.3, 0.5)  # [1] between ramps of the same acceleration and ramps of the same time
_OVERRIDE: Final = (1.5, 0.7)  # [1] between a stretched time axis and scaled speeds
_KNOWN_EXPONENT_DOUBT: Final = 0.15
_SHARING: Final = (np.log(0.03), 0.7)  # of the logarithm; 0.03 lengthens two equally slow axes by 2 %
# Log odds of the rotor's and the load's share, main axes, then wrist. A controller that does not reckon with inertia
# is one whose rotor is all. Load of the main axes: judgement, from a UR10e's published masses and those of an IRB 120
# as remembered, not looked up. Mean and spread were compared on a KR 3 with one program left out, the only recordings
# at hand with several loads: its held-out error is somewhat too good. The load's weight takes of the torque, too.
_SHARES: Final = ((-1.7, 1.5), (0.8, 0.5), (-0.4, 1.0), (0.0, 1.0))
_SHORT_RAMP: Final = (np.log(0.01), 1.0)  # [s], of the logarithm: about the cycle of a usual controller
_POSTURE_KNOWN, _POSTURE_UNKNOWN = 0.05, 0.3  # [1] sd of each weight, with and without the arm's geometry
_SCATTER: Final = 0.04  # [1] what a law of few numbers leaves on arms that it was not made for


def inferred_arm(robot: Robot) -> bool:
    """Whether the accelerations of the main axes of this arm are unpublished."""
    return robot.kind == "arm" and bool(np.isnan(robot.accelerations[:MAIN]).any())


@lru_cache(maxsize=64)
def unlearnt_law(robot: Robot, controller: str = "") -> PriorArm | None:
    """Prior law for the joint moves of a robot without a recording; None if its constant accelerations are
    published.

    `controller`: a text that may name the controller's generation.
    """
    return PriorArm(arm_prior(robot, generations_in(controller))) if inferred_arm(robot) else None


def arm_prior(robot: Robot | None, controllers: Sequence[str] = (), axes: Sequence[str] = ()) -> ArmTiming:
    """Prior parameters for `robot`, or for an unknown arm with the named `axes`. `controllers` replace those of the
    robot.
    """
    names = robot.axis_names if robot is not None else tuple(axes)
    speed, speed_spread, speed_source = _speeds(robot, len(names))
    known = generation_of(controllers or (robot.controllers if robot is not None else ()))
    time, time_spread, time_source = _times(robot, np.exp(speed), known.joint_acceleration)
    stop, stop_source = _STOP, "usual filters of controllers"
    if known.joint_stop is not None:
        stop, stop_source = (known.joint_stop.value, _KNOWN_STOP_DOUBT), known.joint_stop.source
    if robot is not None and robot.settling_time is not None:
        stop, stop_source = (robot.settling_time, _STOP[1]), robot.sources.get("settling_time", "robot file")
    percent, percent_source = _exponent(known.percent_exponent, _PERCENT)
    override, override_source = _exponent(known.override_exponent, _OVERRIDE)
    posture = _POSTURE_UNKNOWN if robot is None or robot.geometry is None else _POSTURE_KNOWN
    weights = min(MAIN, len(names)) * POSTURE
    shares = list(_SHARES)
    if known.joint_acceleration is not None:
        shares[0] = shares[2] = _AS_PROGRAMMED
    rest = [stop, percent, override, _SHARING, *shares, _SHORT_RAMP, *([(0.0, posture)] * weights)]
    count = len(names)
    covariance = np.zeros((2 * count + len(rest),) * 2)
    covariance[:count, :count], covariance[count : 2 * count, count : 2 * count] = speed_spread, time_spread
    covariance[2 * count :, 2 * count :] = np.diag([sd**2 for _, sd in rest])
    sources = (
        *speed_source, *time_source, stop_source, percent_source, override_source,
        *["a guess that holds for any arm"] * (6 + weights),
    )  # fmt: skip
    mean = np.concatenate([speed, time, [value for value, _ in rest]])
    assert len(mean) == len(names_of(names)) == len(sources)
    return ArmTiming(tuple(names), mean, covariance, tuple(sources), _SCATTER)


def _exponent(known: KnownEffect | None, guess: tuple[float, float]) -> tuple[tuple[float, float], str]:
    if known is None:
        return guess, "not known of this controller"
    return (known.value, _KNOWN_EXPONENT_DOUBT), known.source


def _speeds(robot: Robot | None, count: int) -> tuple[Floats, Floats, list[str]]:
    """Logarithms of the rated speeds (k,), their covariance (k, k) and sources."""
    if robot is not None:
        source = robot.sources.get("speed", "robot file")
        return np.log(robot.speeds), np.eye(count) * _RATED_DOUBT**2, [source] * count
    mean, spread = _library_speeds()
    if count != len(mean):
        return np.full(count, mean.mean()), np.eye(count) * 0.7**2, ["arms of the library"] * count
    return mean, spread, ["arms of the library"] * count


@cache
def _library_speeds() -> tuple[Floats, Floats]:
    """Mean and covariance of the logarithms of the rated speeds [rad/s] of all six-axis arms."""
    from olp.robots.robot import load_robot, robot_names

    arms = [load_robot(name) for name in robot_names()]
    rows = [arm.speeds for arm in arms if arm.kind == "arm" and len(arm.axes) == 6]
    rows = [speeds for speeds in rows if np.isfinite(speeds).all()]
    logs = np.log(np.array(rows))
    return logs.mean(axis=0), np.cov(logs.T)


@cache
def fastest_speed() -> float:
    """The highest rated speed [rad/s] of any rotary axis of an arm of the library."""
    from olp.robots.robot import load_robot, robot_names

    arms = [robot for robot in map(load_robot, robot_names()) if robot.kind == "arm"]
    return float(max(axis.speed for arm in arms for axis in arm.axes if not axis.linear))


def _times(
    robot: Robot | None, speeds: Floats, program: KnownEffect | None
) -> tuple[Floats, Floats, list[str]]:
    """Logarithms of the times to rated speed (k,), their covariance (k, k) and sources."""
    count = len(speeds)
    if robot is None:
        median, doubt = np.full(count, _UNKNOWN_TIME[0]), np.full(count, _UNKNOWN_TIME[1])
        sources = ["arms of which times are known"] * count
    else:
        from olp.robots.times_to_speed import times_to_speed

        found = times_to_speed(robot)
        median, doubt, sources = found.median.copy(), found.doubt.copy(), list(found.sources)
        given = robot.accelerations
        told = np.isfinite(given)
        median[told], doubt[told] = speeds[told] / given[told], _GIVEN_DOUBT
        for axis in np.flatnonzero(told).tolist():
            sources[axis] = robot.sources.get("acceleration", "robot file")
    if program is not None:
        median, doubt = speeds / program.value, np.full(count, _PROGRAMMED_DOUBT)
        sources = [program.source] * count
    shared = np.sqrt(_TIME_DOUBT_IN_COMMON) * doubt
    own = np.sqrt(1.0 - _TIME_DOUBT_IN_COMMON) * doubt
    return np.log(median), np.outer(shared, shared) + np.diag(own**2), sources


# --- Lines and arcs ---

_LINE_TABLE: Final = Path(olp.robots.__file__).with_name("line_accelerations.csv")
_SPREADS: Final = np.geomspace(
    0.05, 3.0, 14
)  # of the logarithm, that a maker, a controller or an arm may add
_ANYTHING: Final = 10.0  # of the logarithm of the mean of all arms: so wide that it says nothing


class LineAcceleration(NamedTuple):
    """Acceleration [m/s²] of lines and arcs whose program sets none; `published` for this arm or its controller."""

    value: float  # [m/s²]
    doubt: float  # standard deviation of its logarithm
    source: str
    published: bool


class KnownLines(NamedTuple):
    """A row of `line_accelerations.csv`."""

    robot: str
    maker: str
    controller: str
    payload: float  # [kg]
    acceleration: float  # [m/s²]
    source: str


@cache
def known_lines() -> tuple[KnownLines, ...]:
    """The rows of `line_accelerations.csv`, in their order."""
    with _LINE_TABLE.open(encoding="utf-8", newline="") as file:
        return tuple(
            KnownLines(
                row["robot"],
                row["maker"],
                row["controller"],
                float(row["payload_kg"]),
                float(row["acceleration_m_s2"]),
                row["source"],
            )
            for row in csv.DictReader(file)
        )


@lru_cache(maxsize=64)
def line_acceleration(robot: Robot | None, controller: str = "") -> LineAcceleration:
    """Acceleration of lines of `robot`, or of any arm if None. `controller`: a text that may name its generation.

    The row of the robot itself in the table is not used, so that its recording can judge the answer.
    """
    if robot is not None and robot.linear_acceleration is not None:
        source = robot.sources.get("linear_acceleration", "robot file")
        return LineAcceleration(robot.linear_acceleration, _GIVEN_DOUBT, source, True)
    names = generations_in(controller) or (robot.controllers if robot is not None else ())
    known = generation_of(names).linear_acceleration
    if known is not None:
        return LineAcceleration(known.value, _PROGRAMMED_DOUBT, known.source, True)
    arms = tuple(arm for arm in known_lines() if robot is None or arm.robot != robot.name)
    maker = "" if robot is None else robot.maker
    mean, doubt = line_class(maker, names, arms)
    alike = [arm for arm in arms if arm.controller in names or arm.maker == maker]
    told = f", {len(alike)} of them of its maker" if alike else ""
    return LineAcceleration(float(np.exp(mean)), doubt, f"learnt over {len(arms)} arms{told}", False)


def line_class(
    maker: str,
    controllers: Sequence[str],
    arms: Sequence[KnownLines],
    levels: tuple[bool, bool] = (True, True),
) -> tuple[float, float]:
    """Mean and standard deviation of the logarithm of an arm's acceleration [m/s²], learnt from `arms`.

    `levels`: whether the model has an effect of the maker and one of the controller.
    """
    logs = np.log([arm.acceleration for arm in arms])
    makers = np.array([arm.maker for arm in arms])
    names = np.array([arm.controller for arm in arms])
    same = [makers[:, None] == makers, names[:, None] == names, np.eye(len(arms), dtype=bool)]
    alike = [makers == maker, np.isin(names, list(controllers)), np.zeros(len(arms), dtype=bool)]
    grids = np.meshgrid(*(_SPREADS if use else np.zeros(1) for use in (*levels, True)), indexing="ij")
    variances = np.stack([grid.reshape(-1) for grid in grids], axis=1) ** 2  # (g, 3)
    between = np.tensordot(variances, np.array(same, dtype=np.float64), axes=1) + _ANYTHING**2
    to_arm = variances @ np.array(alike, dtype=np.float64) + _ANYTHING**2  # (g, n)
    solved = np.linalg.solve(between, np.stack([np.broadcast_to(logs, to_arm.shape), to_arm], axis=2))
    means = np.sum(to_arm * solved[:, :, 0], axis=1)
    spreads = variances.sum(axis=1) + _ANYTHING**2 - np.sum(to_arm * solved[:, :, 1], axis=1)
    likely = -(solved[:, :, 0] @ logs + np.linalg.slogdet(between)[1]) / 2.0
    weight = np.exp(likely - likely.max())
    weight /= weight.sum()
    mean = float(weight @ means)
    return mean, float(np.sqrt(weight @ (spreads + (means - mean) ** 2)))
