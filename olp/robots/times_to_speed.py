"""Times of an arm's axes to rated speed where unpublished: learnt over the arms with known times.

`acceleration_times.csv` holds the public ones: ramp-up times of a maker's robot descriptions, computed for the
worst pose with rated load, and acceleration times from controller backups and manuals. The logarithm of an axis's
time is linear in that of the payload, and a worst-case time is longer than a usual one by a factor per axis: ridge
regression, whose residual is the uncertainty. An arm in the table takes no part in its own regression; its own row
is used in addition. `python bench/priors.py` prints how well each arm is predicted from the others.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg
from olp.robots.model import Geometry, Robot

Floats = NDArray[np.float64]
_TABLE: Final = Path(__file__).with_name("acceleration_times.csv")
_AXES: Final = 6
_USUAL_PAYLOAD: Final = 10.0  # [kg] where the regression has its origin; no result depends on it
# Before any data: the worst case takes longer by its inertia (arm stretched, rated load) and, at axes 2 and 3, by
# gravity, which takes away up to half of the torque. A factor of e^0.5 to either side.
WORST_CASE: Final = np.log([1.6, 2.5, 1.8, 1.3, 1.3, 1.3])
WORST_CASE_DOUBT: Final = 0.5
# Inertia grows as mass times length squared, torque as mass times length, and length as the cube root of mass: the
# time at the same speed grows as the sixth root to the third root of the payload.
_PAYLOAD_POWER: Final = 0.25
_PAYLOAD_POWER_DOUBT: Final = 0.5
_PAYLOAD_DOUBT: Final = 0.5  # of the logarithm of a payload that is only known by the reach
_CONTROLLER_DOUBT: Final = (
    0.25  # of the logarithm of a time out of a backup, whose meaning nobody has published
)
_OTHER_AXIS_DOUBT: Final = (
    1.0  # of axes beyond the sixth, slides and positioners: known by nothing but the others
)


@dataclass(frozen=True, slots=True)
class KnownArm:
    """A row of the table: times [s] from rest to rated speed, nan where unknown."""

    robot: str
    payload: float  # [kg]
    reach: float  # [m] axis 1 to the wrist's centre, arm stretched
    worst_case: bool
    times: tuple[float, ...]
    source: str


@dataclass(frozen=True, slots=True)
class TimesToSpeed:
    """Times of k axes: median time [s] from rest to rated speed, standard deviation of its logarithm, source of
    each.
    """

    median: Floats
    doubt: Floats
    sources: tuple[str, ...]


@cache
def known_arms() -> tuple[KnownArm, ...]:
    """The rows of `acceleration_times.csv`, in their order."""
    with _TABLE.open(encoding="utf-8", newline="") as file:
        return tuple(
            KnownArm(
                row["robot"],
                float(row["payload_kg"]),
                float(row["reach_m"]),
                row["kind"] == "worst-case",
                tuple(float(row[f"t{i + 1}_s"] or "nan") for i in range(_AXES)),
                row["source"],
            )
            for row in csv.DictReader(file)
        )


def times_to_speed(robot: Robot, arms: tuple[KnownArm, ...] | None = None) -> TimesToSpeed:
    """Times of `robot`, known and inferred: its own row if `arms` has one, else its class (payload, reach).

    `arms`: to learn from, all of `known_arms` if None.
    """
    arms = known_arms() if arms is None else arms
    own = [arm for arm in arms if arm.robot == robot.name]
    others = tuple(arm for arm in arms if arm.robot != robot.name)
    payload, doubt = _payload(robot, own, arms)
    median, width, sources = [], [], []
    for i, axis in enumerate(robot.axes):
        if i >= _AXES or axis.linear or robot.kind != "arm":
            usual = [t for arm in others for t in arm.times if t == t]
            mean, deviation, source = float(np.mean(np.log(usual))), _OTHER_AXIS_DOUBT, "all known axes"
        else:
            mean, deviation, source = _of_axis(i, payload, doubt, others, own)
        median.append(np.exp(mean))
        width.append(deviation)
        sources.append(source)
    return TimesToSpeed(np.array(median), np.array(width), tuple(sources))


def _of_axis(
    axis: int, payload: float, payload_doubt: float, others: tuple[KnownArm, ...], own: list[KnownArm]
) -> tuple[float, float, str]:
    """Mean and standard deviation of the logarithm of the time of `axis`, and its source."""
    law = _law_of_class(axis, others)
    row = np.array([1.0, np.log(payload / _USUAL_PAYLOAD), 0.0])
    mean = float(row @ law.fit)
    spread = law.variance + float(row @ law.covariance @ row) + (law.fit[1] * payload_doubt) ** 2
    source = f"class of {payload:.3g} kg, learnt over {law.arms} arms"
    for arm in own:
        if arm.times[axis] == arm.times[axis]:
            shift = law.fit[2] if arm.worst_case else 0.0
            noise = law.covariance[2, 2] + WORST_CASE_DOUBT**2 if arm.worst_case else _CONTROLLER_DOUBT**2
            gain = spread / (spread + noise)
            mean += gain * (float(np.log(arm.times[axis])) - shift - mean)
            spread *= 1 - gain
            source = f"{arm.source}{', worst case' if arm.worst_case else ''}; {source}"
    return mean, float(np.sqrt(spread)), source


@dataclass(frozen=True, slots=True)
class _LawOfClass:
    """The logarithm of an axis' time over (1, log of the payload, worst case), learnt over so many arms.

    `fit` (3,), `covariance` (3, 3), `variance` of what remains.
    """

    fit: Floats
    covariance: Floats
    variance: float
    arms: int


@lru_cache(maxsize=64)  # the axes of the arms that a cell or a test asks for in turn
def _law_of_class(axis: int, others: tuple[KnownArm, ...]) -> _LawOfClass:
    arms = [arm for arm in others if arm.times[axis] == arm.times[axis]]
    columns = [[1.0, np.log(arm.payload / _USUAL_PAYLOAD), float(arm.worst_case)] for arm in arms]
    x, y = np.array(columns), np.log([arm.times[axis] for arm in arms])
    expected = np.array([0.0, _PAYLOAD_POWER, WORST_CASE[axis]])
    weight = np.array([0.0, _PAYLOAD_POWER_DOUBT**-2.0, WORST_CASE_DOUBT**-2.0])
    variance, fit = 0.4, expected
    for _ in range(20):  # the residual's variance scales the ridge, and the other way round
        ridge = np.diag(variance * weight)
        fit = np.linalg.solve(x.T @ x + ridge, x.T @ y + ridge @ expected)
        variance = float(np.sum((y - x @ fit) ** 2) / (len(arms) - 2))
    covariance = variance * np.linalg.inv(x.T @ x + np.diag(variance * weight))
    return _LawOfClass(
        np.asarray(fit, dtype=np.float64), np.asarray(covariance, dtype=np.float64), variance, len(arms)
    )


def _payload(robot: Robot, own: list[KnownArm], arms: tuple[KnownArm, ...]) -> tuple[float, float]:
    """Rated payload [kg] and the standard deviation of its logarithm: stated, or inferred from the reach of the
    arms in the table.
    """
    stated = robot.payload or next((arm.payload for arm in own), None)
    if stated:
        return stated, 0.0
    reach = None if robot.geometry is None else reach_of(robot.geometry)
    if not reach:
        return float(np.exp(np.mean(np.log([arm.payload for arm in arms])))), 3 * _PAYLOAD_DOUBT
    slope, offset = np.polyfit(np.log([arm.reach for arm in arms]), np.log([arm.payload for arm in arms]), 1)
    return float(np.exp(offset + slope * np.log(reach))), 2 * _PAYLOAD_DOUBT


def reach_of(geometry: Geometry) -> float:
    """Distance [m] from axis 1 to the wrist's centre with the arm stretched: the sum of the links."""
    if geometry.links is not None:
        links = geometry.links
        return float(links.a1 + links.a2 + np.hypot(links.a3, links.d4))
    return float(sum(np.linalg.norm(joint.offset) for joint in geometry.joints[1:]))


# --- Turns of the tool ---

_TURN_SPEED: Final = (
    180.0 * deg
)  # [rad/s] of the tool's orientation; assumed where no robot is known, and reported
_TURN_ACCELERATION: Final = _TURN_SPEED / 0.3  # [rad/s²] the middle of the wrist axes of known arms


def turn_limits(robot: Robot | None) -> tuple[float, float]:
    """Speed [rad/s] and acceleration [rad/s²] of reorienting the tool: those of the slowest wrist axis, as every
    one may have to turn it.
    """
    if robot is None or len(robot.axes) < 6:
        return _TURN_SPEED, _TURN_ACCELERATION
    wrist = robot.speeds[3:6]
    accelerations = robot.accelerations[3:6]
    known = accelerations[~np.isnan(accelerations)]
    speed = float(wrist.min())
    if len(known):
        return speed, float(known.min())
    return speed, float(np.min(wrist / times_to_speed(robot).median[3:6]))
