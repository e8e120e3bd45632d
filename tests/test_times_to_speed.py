"""The prior of an arm's accelerations: learnt over the arms of which something is published, honest about its doubt."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from olp.robots.robot import load_robot, robot_names
from olp.robots.times_to_speed import (
    WORST_CASE,
    WORST_CASE_DOUBT,
    KnownArm,
    known_arms,
    reach_of,
    times_to_speed,
)

IN_LIBRARY = [arm for arm in known_arms() if arm.robot in robot_names()]


@pytest.mark.parametrize("arm", IN_LIBRARY, ids=lambda arm: arm.robot)
def test_a_known_arm_is_the_one_of_the_library(arm: KnownArm) -> None:
    robot = load_robot(arm.robot)
    assert robot.payload in (None, arm.payload)
    if robot.geometry is not None:
        assert reach_of(robot.geometry) == pytest.approx(arm.reach, abs=1e-3)
    if not arm.worst_case:
        assert robot.speeds[:6] / robot.accelerations[:6] == pytest.approx(np.array(arm.times), abs=1e-3)


@pytest.mark.parametrize("axis", range(6))
def test_arms_that_took_no_part_lie_in_the_interval(axis: int) -> None:
    inside = []
    for arm in IN_LIBRARY:
        others = tuple(other for other in known_arms() if other is not arm)
        robot = dataclasses.replace(load_robot(arm.robot), payload=arm.payload)
        told = times_to_speed(robot, others)
        shift, extra = (WORST_CASE[axis], WORST_CASE_DOUBT) if arm.worst_case else (0.0, 0.0)
        error = np.log(arm.times[axis] / told.median[axis]) - shift
        inside.append(abs(error) <= 1.96 * np.hypot(told.doubt[axis], extra))
    assert 0.88 <= np.mean(inside) <= 1.0


def test_an_arms_own_row_narrows_the_doubt_and_a_heavier_class_is_slower() -> None:
    gp25 = load_robot("yaskawa/gp25")
    own, unknown = times_to_speed(gp25), times_to_speed(dataclasses.replace(gp25, name="another"))
    assert (own.doubt < 0.5 * unknown.doubt).all()
    assert own.median == pytest.approx(np.array([0.35, 0.5, 0.35, 0.24, 0.24, 0.12]), rel=0.05)
    light, heavy = (times_to_speed(dataclasses.replace(gp25, name="x", payload=kg)) for kg in (3.0, 300.0))
    assert (heavy.median > 1.5 * light.median).all()
    assert "class of 3 kg" in light.sources[0]


def test_every_robot_of_the_library_gets_a_time_for_every_axis() -> None:
    for name in robot_names():
        robot = load_robot(name)
        told = times_to_speed(robot)
        assert told.median.shape == told.doubt.shape == (len(robot.axes),)
        assert ((told.median > 0.02) & (told.median < 3.0) & (told.doubt > 0.1)).all()
