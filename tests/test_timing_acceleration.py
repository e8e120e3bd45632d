"""Which acceleration a plan's moves get: the laws behind `--accel-law`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.ir.points import PointKind, PointState
from olp.ir.program import Path
from olp.robots.coordinate_systems import Cell, Mechanism
from olp.robots.robot import load_robot
from olp.runtime.assumptions import load_assumptions
from olp.runtime.plan import PATHS, BlendCode, Plan
from olp.runtime.recorder import Recorder
from olp.timing.acceleration import law_names, load_law
from olp.timing.timing import time_plan

ANGLES = PointState(PointKind.JOINT)
LINEAR, JOINT = PATHS.index(Path.LINEAR), PATHS.index(Path.JOINT)
NEAR, STRETCHED = (0.0, 0.2, -0.3, 0.0, -0.9, 0.0), (0.0, 1.1, 0.9, 0.0, -0.9, 0.0)


def plan_of(*joints, path=JOINT, speed=0.3, robot="yaskawa/ma2010") -> Plan:
    """Moves with exact stops from the first pose through the others; speed [1] of joint moves, [m/s] of lines."""
    text = "\r\n".join(f"move {i}" for i in range(len(joints))).encode()
    recorder = Recorder(Cell([Mechanism("RB1", load_robot(robot))]), (decode(text, "test.jbi"),))
    first, *others = (recorder.position(0, ANGLES, q) for q in joints)
    recorder.at[0] = first
    for line, target in enumerate(others, 1):
        recorder.step(0, line)
        recorder.row(0, target, path, int(path == LINEAR), speed, BlendCode.EXACT)
    return recorder.finish(())


def swung(pose, axis: int, by: float):
    turned = list(pose)
    turned[axis] += by
    return tuple(turned)


def said(timing) -> str:
    return " | ".join(a.says for a in timing.assumptions)


@pytest.mark.parametrize("pose", [NEAR, STRETCHED])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_by_pose_swings_take_what_the_measured_axis_allows(pose, axis):
    """From the law's own limits: L = v²/2 (1/up + 1/down), so a short swing takes sqrt(2 L (1/up + 1/down))."""
    robot, law, way = load_robot("yaskawa/ma2010"), load_law("by_pose"), 0.02
    end = swung(pose, axis, way)
    sense = np.eye(6)[axis]
    up = law.accelerations(robot, pose, sense)[0, axis]
    down = law.accelerations(robot, end, -sense)[0, axis]
    wanted = np.sqrt(2 * way * (1 / up + 1 / down))
    timing = time_plan(plan_of(pose, end, speed=1.0), acceleration_law="by_pose")
    assert timing.duration_s[0] - 0.166 == pytest.approx(wanted, rel=1e-6)
    assert timing.limited_by[0] == f"axis {robot.axis_names[axis]} acceleration"


def test_a_stretched_arm_swings_slower_by_pose_but_not_by_a_constant():
    short, long = (plan_of(p, swung(p, 0, 0.1)) for p in (NEAR, STRETCHED))
    constant = [time_plan(p).duration_s[0] for p in (short, long)]
    by_pose = [time_plan(p, acceleration_law="by_pose").duration_s[0] for p in (short, long)]
    assert constant[0] == pytest.approx(constant[1])
    assert by_pose[1] > by_pose[0] * 1.05


@pytest.mark.parametrize("speed", [0.05, 0.2])
def test_with_a_time_constant_a_line_takes_its_length_over_its_speed_and_t(speed):
    plan = plan_of(NEAR, swung(NEAR, 0, 0.3), path=LINEAR, speed=speed)
    timing = time_plan(plan, acceleration_law="time_constant")
    # The measured exact stop of 0.166 s holds the filter's 0.15 s.
    assert timing.duration_s[0] == pytest.approx(plan.moves.length[0] / speed + 0.166)
    assert "time_constant acceleration law" in said(timing)


def test_with_a_time_constant_joint_moves_take_it_at_every_speed():
    for fraction in (0.1, 0.4):
        plan = plan_of(NEAR, swung(NEAR, 0, 1.0), speed=fraction)
        moving = 1.0 / (fraction * load_robot("yaskawa/ma2010").speeds[0])
        assert time_plan(plan, acceleration_law="time_constant").duration_s[0] == pytest.approx(
            moving + 0.166
        )


@pytest.mark.parametrize("law", [name for name in law_names() if name != "constant"])
def test_a_line_never_accelerates_harder_than_the_linear_acceleration(law):
    plan = plan_of(NEAR, swung(NEAR, 0, 0.2), path=LINEAR, speed=0.5)
    slow, constant = (time_plan(plan, acceleration=0.2, acceleration_law=name) for name in (law, "constant"))
    assert slow.accel_mm_s2[0] <= constant.accel_mm_s2[0] * (1 + 1e-12)


def test_a_line_has_what_its_axes_allow_where_that_is_less():
    plan = plan_of(STRETCHED, swung(STRETCHED, 0, 0.4), path=LINEAR, speed=2.0)
    free = time_plan(plan, acceleration=50.0)
    held = time_plan(plan, acceleration=50.0, acceleration_law="by_pose")
    assert held.accel_mm_s2[0] < 0.5 * free.accel_mm_s2[0]
    # Across the arm the tool moves on axis S alone: about the axis' own acceleration times the tool's distance from it.
    start = plan.positions.position[plan.moves.start[0]]
    swing = load_law("by_pose").accelerations(load_robot("yaskawa/ma2010"), STRETCHED, np.eye(6)[0])[0, 0]
    assert held.accel_mm_s2[0] / 1e3 <= swing * np.hypot(*start[:2]) * 1.1


def test_torque_limits_rule_the_joint_moves_of_a_robot_with_masses():
    robot = "universal-robots/ur10e"
    out = (0.0, -0.2, 0.1, -1.5, 1.5, 0.0)
    plan = plan_of(out, swung(out, 0, 1.0), speed=1.0, robot=robot)
    timing = time_plan(plan, acceleration_law="torque")
    assert "without the mass of the tool" in said(timing)
    assert timing.duration_s[0] != pytest.approx(time_plan(plan).duration_s[0], rel=1e-3)
    assert np.isfinite(timing.duration_s).all()


def test_a_robot_without_masses_gets_the_constants_and_says_so():
    plan = plan_of(NEAR, swung(NEAR, 0, 0.5))
    simple, asked = time_plan(plan), time_plan(plan, acceleration_law="torque")
    assert asked.total_s == simple.total_s
    assert "the torque acceleration law has no numbers of yaskawa/ma2010: constant accelerations" in said(
        asked
    )


def test_olp_toml_names_the_law_and_the_argument_beats_it():
    plan = plan_of(STRETCHED, swung(STRETCHED, 0, 0.1))
    named = replace(plan, settings={"acceleration_law": "by_pose"})
    assert time_plan(named).total_s == time_plan(plan, acceleration_law="by_pose").total_s
    assert time_plan(named, acceleration_law="constant").total_s == time_plan(plan).total_s


@pytest.mark.parametrize("law", law_names())
def test_olp_toml_may_name_every_law_there_is(tmp_path, law):
    file = tmp_path / "olp.toml"
    file.write_text(f'[motion]\nacceleration_law = "{law}"\n')
    found = load_assumptions(file)
    assert found.motion == {"acceleration_law": law}
    assert not found.diagnostics


def test_a_law_that_olp_toml_names_and_nobody_knows_is_told_with_its_line(tmp_path):
    file = tmp_path / "olp.toml"
    file.write_text('[motion]\nmodel = "linear"\nacceleration_law = "brisk"\n')
    found = load_assumptions(file)
    assert found.motion == {"model": "linear"}
    assert [(d.code, d.line) for d in found.diagnostics] == [("V004", 3)]
    assert "by_pose" in found.diagnostics[0].help


def test_an_unknown_law_is_refused_with_those_there_are():
    with pytest.raises(OlpError) as caught:
        time_plan(plan_of(NEAR, STRETCHED), acceleration_law="brisk")
    (problem,) = caught.value.diagnostics
    assert problem.code == "T021"
    assert "by_pose" in problem.help
