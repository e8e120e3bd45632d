"""How well an arm is told by all other arms: `python bench/priors.py`.

The time to rated speed, axis by axis; the acceleration of lines, arm by arm, by several laws of which olp uses "maker,
controller". "Share of the axes": a part of what the times to rated speed of the arm's class let its axes do along
lines, the middle of 400 postures.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from olp.robots.kinematics.configuration import jacobian
from olp.robots.model import Robot
from olp.robots.robot import load_robot, robot_names
from olp.robots.times_to_speed import WORST_CASE, WORST_CASE_DOUBT, known_arms, times_to_speed
from olp.timing.arm_prior import KnownLines, known_lines, line_class

_POSTURES, _SEED, _BENT = 400, 0, 60.0
_POWER = -0.25  # of the payload: as one over the time to speed, olp/robots/times_to_speed.py


def main() -> None:
    """Prints one row per known arm and one per axis, then those of lines."""
    errors: list[list[float]] = [[] for _ in range(6)]
    inside: list[list[bool]] = [[] for _ in range(6)]
    arms = known_arms()
    for arm in arms:
        if arm.robot not in robot_names():
            continue
        robot = dataclasses.replace(load_robot(arm.robot), name="unknown/arm", payload=arm.payload)
        others = times_to_speed(robot, tuple(other for other in arms if other is not arm))
        for i, time in enumerate(arm.times):
            error = float(np.log(time / others.median[i])) - (WORST_CASE[i] if arm.worst_case else 0.0)
            doubt = np.hypot(others.doubt[i], WORST_CASE_DOUBT if arm.worst_case else 0.0)
            errors[i].append(error)
            inside[i].append(abs(error) <= 1.96 * doubt)
        kind = "worst case" if arm.worst_case else "controller"
        shown = "  ".join(f"{t:.2f}/{own:.2f}" for t, own in zip(others.median, arm.times, strict=False))
        print(f"{arm.robot:24} {kind}  {shown}")
    for i in range(6):
        print(f"axis {i + 1}: {np.std(errors[i]):.2f} of ln(time), inside 95 %: {np.mean(inside[i]):.0%}")
    of_lines()


def of_lines() -> None:
    """Accelerations of lines [m/s²]."""
    arms = known_lines()
    print(
        "\nlines: error of ln(acceleration) of each arm by the others, over the standard deviation that is stated"
    )
    print(" " * 27 + "  ".join(f"{arm.robot.split('/')[1][:11]:>11}" for arm in arms))
    with_axes = [arm for arm in arms if arm.robot in robot_names()]
    able = {arm.robot: along_lines(load_robot(arm.robot)) for arm in with_axes}
    plain, both = (False, False), (True, True)
    left_one_out("one for all", arms, plain)
    left_one_out("payload", [by_payload(arm) for arm in arms], plain)
    left_one_out("maker", arms, (True, False))
    left_one_out("controller", arms, (False, True))
    left_one_out("maker, controller", arms, both)
    left_one_out("maker, controller, payload", [by_payload(arm) for arm in arms], both)
    print(f"of the {len(with_axes)} whose axes are known:")
    left_one_out("one for all", with_axes, plain)
    shares = [arm._replace(acceleration=arm.acceleration / able[arm.robot]) for arm in with_axes]
    left_one_out("share of the axes", shares, plain)


def left_one_out(law: str, scaled: Sequence[KnownLines], levels: tuple[bool, bool]) -> None:
    """One row; `scaled`: the arms with what is left of their accelerations by the law."""
    errors, doubts = [], []
    for arm in scaled:
        others = [other for other in scaled if other is not arm]
        mean, doubt = line_class(arm.maker, [arm.controller], others, levels)
        errors.append(float(np.log(arm.acceleration)) - mean)
        doubts.append(doubt)
    away = np.array(errors) / doubts
    shown = "  ".join(f"{e:+.2f}/{d:.2f}".rjust(11) for e, d in zip(errors, doubts, strict=True))
    print(
        f"{law:26} {shown}   root mean square {np.sqrt(np.mean(np.square(errors))):.2f}, of errors over what is stated "
        f"{np.sqrt(np.mean(away**2)):.2f}, inside 95 %: {np.mean(np.abs(away) <= 1.96):.0%}"
    )


def by_payload(arm: KnownLines) -> KnownLines:
    return arm._replace(acceleration=arm.acceleration * arm.payload**-_POWER)


def along_lines(robot: Robot) -> float:
    """[m/s²] that the axes allow in the middle of many postures and directions."""
    draw = np.random.default_rng(_SEED)
    axes = robot.speeds / times_to_speed(robot).median
    low, high = np.maximum(robot.lower, -2.5), np.minimum(robot.upper, 2.5)
    joints = draw.uniform(low, high, (_POSTURES, len(robot.axes)))
    directions = draw.normal(size=(_POSTURES, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    found = []
    for matrix, direction in zip(jacobian(robot, joints), directions, strict=True):
        if np.linalg.cond(matrix) < _BENT:
            rates = np.linalg.solve(matrix, np.concatenate([direction, np.zeros(3)]))
            found.append(1.0 / np.max(np.abs(rates) / axes))
    return float(np.median(found))


if __name__ == "__main__":
    main()
