"""What the axes allow along the lines of a plan, against the same path looked at four thousand times."""

from __future__ import annotations

import numpy as np
import pytest

from olp.core.source import decode
from olp.ir.points import PointKind, PointState
from olp.ir.program import Path
from olp.robots.coordinate_systems import Cell, Mechanism
from olp.robots.geometry import Pose, rotation_from_quaternion, slerp
from olp.robots.kinematics import forward, inverse, track, with_tool, without_tool
from olp.robots.kinematics.configuration import Tool
from olp.robots.robot import load_robot
from olp.runtime.plan import PATHS, BlendCode, Plan
from olp.runtime.recorder import Recorder
from olp.timing.retiming import Singular, along_path
from olp.timing.retiming.along import _paths, sample
from olp.timing.timing import time_plan

LINEAR, JOINT, CIRCULAR, SPLINE = (
    PATHS.index(p) for p in (Path.LINEAR, Path.JOINT, Path.CIRCULAR, Path.SPLINE)
)
ROBOT = load_robot("yaskawa/ma2010")
CALM = np.array([0.1, 0.2, -0.1, 0.3, -0.8, 0.2])
BY_AXES = PointState(PointKind.JOINT)


def plan_of(*joints, speed: float = 1.0, path: int = LINEAR, robot=ROBOT) -> Plan:
    """Moves through poses that are given by their axes (k,) [rad]."""
    text = "\r\n".join(f"move {i}" for i in range(1, len(joints))).encode()
    recorder = Recorder(Cell([Mechanism("RB1", robot)]), (decode(text, "along.jbi"),))
    indices = [recorder.position(0, BY_AXES, tuple(q)) for q in joints]
    recorder.at[0] = indices[0]
    for line, index in enumerate(indices[1:], start=1):
        recorder.step(0, line)
        unit = 0 if path == JOINT else 1
        recorder.row(0, index, path, unit, speed, BlendCode.EXACT)
    return recorder.finish(())


def looked_at_closely(plan: Plan, row: int, count: int = 4001) -> tuple[np.ndarray, np.ndarray]:
    """Place (n,) [m] and |dq/ds| (n, k) along a line."""
    start, target = plan.moves.start[row], plan.moves.target[row]
    positions, part = plan.positions, np.linspace(0, 1, count)
    point = positions.position[start] * (1 - part[:, None]) + positions.position[target] * part[:, None]
    turned = rotation_from_quaternion(slerp(positions.quaternion[start], positions.quaternion[target], part))
    place = plan.moves.length[row] * part
    axes = track(ROBOT, point, turned, positions.axes[start][:6])
    return place, np.abs(np.gradient(axes, place, axis=0, edge_order=2))


@pytest.mark.parametrize("seed", range(8))
def test_speed_axis_and_place_are_those_of_a_close_look(seed):
    rng = np.random.default_rng(seed)
    first = CALM + rng.uniform(-0.3, 0.3, 6)
    plan = plan_of(first, first + rng.uniform(-0.4, 0.4, 6))
    place, slope = looked_at_closely(plan, 0)
    by_axis = ROBOT.speeds / slope.max(axis=0)
    found = along_path(plan)
    assert found.known[0]
    assert found.singular[0] == Singular.NONE
    assert found.speed[0] == pytest.approx(by_axis.min(), rel=0.01)
    assert found.axis[0] == np.argmin(by_axis)
    steepest = slope[:, found.axis[0]]
    assert np.interp(found.place[0], place, steepest) == pytest.approx(steepest.max(), rel=0.01)


def test_a_row_that_a_loop_passes_again_is_looked_at_once_and_has_the_same_limits(monkeypatch):
    rng = np.random.default_rng(3)
    ends = [CALM + rng.uniform(-0.4, 0.4, 6) for _ in range(3)]
    sampled = []

    def counted(plan, robot, rows, count):
        sampled.append(len(rows))
        return sample(plan, robot, rows, count)

    monkeypatch.setattr("olp.timing.retiming.along.sample", counted)
    once, thrice = along_path(plan_of(*ends, ends[0])), along_path(plan_of(*(ends * 3), ends[0]))
    assert len(thrice.speed) == 9
    assert sum(sampled) == 2 * 3  # each of the three lines in each plan
    for name in (
        "known",
        "speed",
        "axis",
        "place",
        "acceleration",
        "paced",
        "singular",
        "nearness",
        "lost",
        "outside",
    ):
        assert np.array_equal(getattr(thrice, name), np.tile(getattr(once, name), 3), equal_nan=True), name


def test_a_spline_that_turns_back_is_as_fast_as_the_line_that_it_is():
    """Its parameter stands still where it turns back; the arm does not have to."""
    there = CALM + np.array([0.2, 0.1, -0.1, 0.1, 0.1, 0.2])
    splines, lines = (along_path(plan_of(CALM, there, CALM, there, path=p)) for p in (SPLINE, LINEAR))
    assert splines.known.all()
    assert splines.speed == pytest.approx(lines.speed, rel=1e-3)
    assert splines.acceleration == pytest.approx(lines.acceleration, rel=1e-3)


def near_the_wrist(speed: float) -> Plan:
    """A line of 0.6 m on which B comes within two degrees of zero, so that R has to be quick there."""
    rng = np.random.default_rng(0)
    first = np.array([0.1, 0.2, -0.1, 0.3, -0.6, 0.2]) + rng.uniform(-0.4, 0.4, 6)
    return plan_of(first, first + rng.uniform(-0.5, 0.5, 6), speed=speed)


def test_a_line_slows_down_only_where_the_axis_asks_for_it():
    plan = near_the_wrist(1.5)
    place, slope = looked_at_closely(plan, 0)
    allowed = np.minimum((ROBOT.speeds / np.maximum(slope, 1e-9)).min(axis=1), 1.5)
    assert allowed.min() < 1.4
    found = along_path(plan)
    assert found.speed[0] == pytest.approx(allowed.min(), rel=0.01)
    mean = place[-1] / np.trapezoid(1 / allowed, place)
    assert found.paced[0] == pytest.approx(mean, rel=0.01)
    lazy = along_path(plan, acceleration=np.array([2.0]))
    assert found.speed[0] < lazy.paced[0] < found.paced[0]  # the tool itself takes its time to slow down


def test_the_time_of_a_line_that_an_axis_slows_is_longer_and_names_the_axis():
    plan = near_the_wrist(0.9)
    found = along_path(plan)
    assert found.paced[0] < 0.9
    timing = time_plan(plan)
    assert timing.limited_by[0] == f"axis {ROBOT.axis_names[found.axis[0]]} speed"
    assert timing.speed_mm_s[0] == pytest.approx(900.0)
    assert timing.reached_mm_s[0] < 900.0
    assert along_path(near_the_wrist(0.2)).paced[0] == 0.2


@pytest.mark.parametrize(("start", "end"), [(-0.6, 0.5), (0.5, -0.6)])
def test_a_line_through_a_straight_wrist_is_told_and_not_given_a_number(start, end):
    one, other = CALM.copy(), CALM.copy()
    one[3:], other[3:] = (0.05, start, 0.1), (0.02, end, 0.12)
    plan = plan_of(one, other, speed=0.5)
    found = along_path(plan)
    assert found.singular[0] == Singular.WRIST
    assert found.nearness[0] < np.radians(1.0)
    assert np.isnan(found.speed[0])
    assert found.paced[0] == 0.5
    timing = time_plan(plan)
    (told,) = [d for d in timing.diagnostics if d.code == "L105"]
    assert (told.line, told.file) == (1, "along.jbi")
    assert "straight wrist" in told.message
    assert not told.is_error
    assert np.isfinite(timing.duration_s).all()


def test_how_near_a_line_comes_to_a_straight_wrist_is_what_a_close_look_finds():
    one, other = CALM.copy(), CALM.copy()
    one[3:], other[3:] = (0.9, -0.5, 0.0), (-1.1, -0.012, 0.6)
    plan = plan_of(one, other)
    found = along_path(plan)
    assert found.singular[0] == Singular.WRIST
    assert found.nearness[0] <= 0.012


def with_wrist_at(*points) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Flange positions (n, 3) [m], one rotation (n, 3, 3) and axes (n, 6) with the wrist centre at `points`."""
    assert ROBOT.geometry is not None
    assert ROBOT.geometry.links is not None
    _, turned = forward(ROBOT, CALM)
    turned = np.repeat(turned, len(points), axis=0)
    flange = np.array(points) + ROBOT.geometry.links.d6 * turned[:, :, 2]
    axes, reached = inverse(ROBOT, flange, turned, (1, 0, 0, 0, 0, 0))
    assert reached.all()
    return flange, turned, axes


def test_a_line_that_takes_the_wrist_over_axis_s_is_told_with_its_distance():
    *_, axes = with_wrist_at((0.004, -0.3, 0.9), (0.004, 0.3, 0.9))
    found = along_path(plan_of(*axes))
    assert found.singular[0] == Singular.SHOULDER
    assert found.nearness[0] == pytest.approx(0.004, abs=0.002)
    assert "mm of a singularity (a wrist above axis S)" in found.diagnostics[-1].message


def test_a_line_that_leaves_the_reach_between_two_points_is_told_with_the_place():
    flange, turned, axes = with_wrist_at((0.2, -0.9, 0.05), (0.2, 0.9, 0.05))
    plan = plan_of(*axes)
    found = along_path(plan)
    part = np.linspace(0, 1, 2001)[:, None]
    _, reached = inverse(
        ROBOT, flange[0] * (1 - part) + flange[1] * part, turned[:1].repeat(2001, axis=0), (1, 0, 0, 0, 0, 0)
    )
    first = plan.moves.length[0] * np.argmin(reached) / 2000
    assert 0.1 < first < 0.9
    assert found.lost[0] == pytest.approx(first, abs=0.02)
    assert np.isnan(found.speed[0])
    assert "L103" in [d.code for d in found.diagnostics]


def test_axes_outside_their_soft_limits_are_named_for_lines_and_joint_moves():
    inside, beyond = CALM.copy(), CALM.copy()
    inside[0], beyond[0] = ROBOT.upper[0] - 0.1, ROBOT.upper[0] + 0.05
    for path in (LINEAR, JOINT):
        found = along_path(plan_of(inside, beyond, path=path))
        assert found.outside[0] == 0
        (told,) = [d for d in found.diagnostics if d.code == "L104"]
        assert "axis S leaves its soft limits" in told.message
    assert along_path(plan_of(CALM, CALM + 0.1)).outside[0] == -1


def test_short_lines_looked_at_at_their_ends_allow_what_the_long_one_does():
    first = CALM + 0.2
    long = plan_of(first, CALM - 0.2)
    _, slope = looked_at_closely(long, 0, 121)
    start, target = long.moves.start[0], long.moves.target[0]
    part = np.linspace(0, 1, 121)[:, None]
    point = long.positions.position[start] * (1 - part) + long.positions.position[target] * part
    turned = rotation_from_quaternion(
        slerp(long.positions.quaternion[start], long.positions.quaternion[target], part[:, 0])
    )
    axes = track(ROBOT, point, turned, first)
    short = along_path(plan_of(*axes))
    assert short.known.all()
    expected = (ROBOT.speeds / ((slope[1:] + slope[:-1]) / 2)).min(axis=1)
    assert short.speed == pytest.approx(expected, rel=0.01)
    assert short.speed.min() == pytest.approx(along_path(long).speed[0], rel=0.02)


def test_an_arc_is_looked_at_along_the_arc():
    _, turned = forward(ROBOT, CALM)
    angle = np.array([0.0, 1.0, 2.0])
    points = np.stack((1.2 + 0.2 * np.cos(angle), 0.2 * np.sin(angle), 0.1 + 0 * angle), axis=1)
    axes, reached = inverse(ROBOT, points, np.repeat(turned, 3, axis=0), (1, 0, 0, 0, 0, 0))
    assert reached.all()
    plan = plan_of(axes[0] + 1e-3, *axes, path=CIRCULAR)
    found = along_path(plan)
    fine = np.linspace(1.0, 2.0, 2001)
    way = np.stack((1.2 + 0.2 * np.cos(fine), 0.2 * np.sin(fine), 0.1 + 0 * fine), axis=1)
    followed = track(ROBOT, way, np.repeat(turned, 2001, axis=0), axes[1])
    slope = np.abs(np.gradient(followed, 0.2 * (fine - 1.0), axis=0, edge_order=2)).max(axis=0)
    assert plan.moves.length[2] == pytest.approx(0.2, rel=1e-9)
    assert found.speed[2] == pytest.approx((ROBOT.speeds / slope).min(), rel=0.01)


def test_of_joint_moves_unknown_robots_and_chains_nothing_is_made_up():
    assert not along_path(plan_of(CALM, CALM + 0.3, path=JOINT)).known.any()
    slim = load_robot("yaskawa/sia20d")
    middle = (slim.lower + slim.upper) / 2 + 0.3
    found = along_path(plan_of(middle, middle + 0.02, robot=slim))
    assert found.known[0]
    assert found.assumptions == (
        "the axes of yaskawa/sia20d along lines are checked at the ends of each line only",
    )


def test_with_a_tool_it_is_the_tool_that_goes_straight():
    tool = Pose(np.array([0.02, -0.03, 0.31]), np.eye(3))
    text, cell = decode(b"move", "tool.jbi"), Cell([Mechanism("RB1", ROBOT)], tools={3: Tool(tool)})
    recorder = Recorder(cell, (text,))
    state = PointState(PointKind.JOINT, tool=3)
    first, last = (recorder.position(0, state, tuple(q)) for q in (CALM, CALM + 0.3))
    recorder.at[0] = first
    recorder.step(0, 1)
    recorder.row(0, last, LINEAR, 1, 1.0, BlendCode.EXACT)
    plan = recorder.finish(())
    start, target = plan.positions.position[[plan.moves.start[0], plan.moves.target[0]]]
    assert start == pytest.approx(with_tool(*forward(ROBOT, CALM), tool)[0][0])
    part = np.linspace(0, 1, 2001)
    turned = rotation_from_quaternion(
        slerp(*plan.positions.quaternion[[plan.moves.start[0], plan.moves.target[0]]], part)
    )
    flange = without_tool(start + (target - start) * part[:, None], turned, tool)
    axes = track(ROBOT, *flange, CALM)
    slope = np.abs(np.gradient(axes, plan.moves.length[0] * part, axis=0, edge_order=2)).max(axis=0)
    assert along_path(plan).speed[0] == pytest.approx((ROBOT.speeds / slope).min(), rel=0.01)


def test_a_move_over_nothing_and_a_program_of_nothing_are_looked_at_too():
    assert len(along_path(plan_of(CALM)).speed) == 0
    still = along_path(plan_of(CALM, CALM))
    assert not still.known[0]
    assert still.diagnostics == ()


def test_a_short_line_through_a_straight_wrist_is_told_too():
    one, other = CALM.copy(), CALM.copy()
    one[4], other[4] = np.radians(-1.6), np.radians(1.7)
    found = along_path(plan_of(one, other))
    assert found.singular[0] == Singular.WRIST
    assert found.nearness[0] == 0.0


def test_derivatives_over_the_place_do_not_depend_on_how_the_samples_are_spread():
    place = np.linspace(0.0, 1.0, 81) ** 1.3 * 0.7
    joints = np.stack((np.sin(3 * place), place**2), axis=1)
    path = _paths(place[None, :], joints[None])
    inner = slice(20, -5)
    assert path.first[0, inner, 0] == pytest.approx(3 * np.cos(3 * place)[inner], rel=1e-3)
    assert path.second[0, inner, 0] == pytest.approx(-9 * np.sin(3 * place)[inner], rel=0.02)
    assert path.second[0, inner, 1] == pytest.approx(2.0, rel=0.02)
