"""How well the time to rated speed of an arm is told by all other arms, axis by axis: `python bench/priors.py`."""

from __future__ import annotations

import dataclasses

import numpy as np

from olp.robots.robot import load_robot, robot_names
from olp.robots.times_to_speed import WORST_CASE, WORST_CASE_DOUBT, known_arms, times_to_speed


def main() -> None:
    """Prints one row per known arm and one per axis."""
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


if __name__ == "__main__":
    main()
