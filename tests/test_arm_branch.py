"""How the arm stands at poses that name no configuration: along lines as before, after joint moves nearest."""

from __future__ import annotations

import importlib
from types import SimpleNamespace

import numpy as np
import pytest
from eaik.IK_HP import HPRobot

from olp.fluent import read
from olp.ir.program import Path
from olp.robots.geometry import Pose, quaternion_from_rotation
from olp.robots.kinematics import configuration_of, forward, nearest
from olp.robots.kinematics.configuration import wrap
from olp.robots.robot import load_robot
from olp.runtime.arm_branch import PlannedArm
from olp.runtime.plan import PATHS, Positions
from olp.timing.timing import time_plan
from olp.timing.track import states

GP25 = load_robot("yaskawa/gp25")
UR10E = load_robot("universal-robots/ur10e")
JOINT = PATHS.index(Path.JOINT)


def rotation_vector(rotation):
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotation).as_rotvec()


def script(tmp_path, robot, start, moves):
    """A URScript program: to joints `start`, then `moves` of (word, joints that reach the pose)."""
    rows = [f"movej({list(map(float, start))})"]
    for word, joints in moves:
        position, rotation = forward(robot, joints)
        numbers = [*position[0], *rotation_vector(rotation[0])]
        rows.append(f"{word}(p[{', '.join(f'{value:.15f}' for value in numbers)}])")
    path = tmp_path / "way.script"
    path.write_text("\n".join(["def way():", *(f"  {row}" for row in rows), "end", "way()", ""]))
    return read(path)


def axes_of(program, robot):
    plan = program.plan(robot=robot)
    return plan.positions.axes[plan.moves.target][:, : len(robot.axes)]


def near(robot, joints, by, generator):
    return joints + generator.uniform(-by, by, len(robot.axes))


@pytest.mark.parametrize("robot", [GP25, UR10E], ids=["GP25", "UR10e"])
def test_lines_keep_the_branch_that_the_arm_is_on(robot, tmp_path):
    generator = np.random.default_rng(3)
    for _ in range(6):
        start = generator.uniform(0.4, 1.2, 6) * generator.choice([-1, 1], 6)
        ends = [near(robot, start, 0.08, generator) for _ in range(5)]
        found = axes_of(script(tmp_path, robot, start, [("movel", end) for end in ends]), robot)
        np.testing.assert_allclose(found, [start, *ends], atol=1e-7)


def test_a_joint_move_takes_the_nearest_of_all_solutions_that_eaik_knows(tmp_path):
    geometry = GP25.geometry
    directions = np.array([joint.direction for joint in geometry.joints])
    offsets = np.array([joint.offset for joint in geometry.joints] + [geometry.flange_offset])
    other, flange = HPRobot(directions, offsets), np.array(geometry.flange_rotation)
    generator = np.random.default_rng(5)
    for _ in range(30):
        start, end = generator.uniform(0.5 * GP25.lower, 0.5 * GP25.upper, (2, 6))
        position, rotation = forward(GP25, end)
        pose = np.eye(4)
        pose[:3, 3], pose[:3, :3] = position[0], rotation[0] @ flange.T
        solution = other.IK(pose)
        all_ways = np.asarray(solution.Q)[~np.asarray(solution.is_LS, dtype=bool)]
        turned = start + wrap(all_ways - start)
        turned = turned[((turned >= GP25.lower) & (turned <= GP25.upper)).all(axis=1)]
        best = turned[np.argmin(np.sum((turned - start) ** 2, axis=1))]
        np.testing.assert_allclose(nearest(GP25, position, rotation, start)[0], best, atol=1e-7)
        np.testing.assert_allclose(
            axes_of(script(tmp_path, GP25, start, [("movej", end)]), GP25)[1], best, atol=1e-6
        )


def test_the_plan_ends_a_line_where_the_followed_path_ends(tmp_path):
    # 0.7 m along the base's y axis with the tool turning: axes turn far, the wrist comes near its straight position.
    generator = np.random.default_rng(8)
    for _ in range(8):
        start = np.radians([-40, 5, -20, 30, -50, 20]) + generator.uniform(-0.2, 0.2, 6)
        end = np.radians([45, 8, -18, -60, -70, 150]) + generator.uniform(-0.2, 0.2, 6)
        program = script(tmp_path, GP25, start, [("movel", end)])
        plan = program.plan(robot=GP25)
        timing = time_plan(plan)
        _, _, followed = states(timing, np.linspace(0.0, timing.total_s - 1e-9, 4000))
        reached = plan.positions.axes[plan.moves.target[-1]][:6]
        if not np.isnan(followed[-1, :6]).any():
            np.testing.assert_allclose(followed[-1, :6], reached, atol=1e-3)


def test_a_line_does_not_go_to_the_flags_that_its_end_names(tmp_path):
    start = np.radians([10, 5, -20, 15, -50, 20])
    end = start + 0.05
    position, rotation = forward(GP25, end)
    flipped = [int(flag) for flag in configuration_of(GP25, end)[0]]
    flipped[0] = 1 - flipped[0]
    from olp.robots.geometry import angles_from_rotation

    x, y, z = position[0] * 1000
    rx, ry, rz = np.degrees(angles_from_rotation(rotation)[0])
    pulses = start * GP25.pulses_per_unit
    job = [
        "/JOB", "//NAME WAY", "//POS", "///NPOS 2,0,0,0,0,0", "///TOOL 0", "///POSTYPE PULSE", "///PULSE",
        "C00000=" + ",".join(f"{value:.0f}" for value in pulses), "///POSTYPE BASE", "///RECTAN",
        "///RCONF " + ",".join(map(str, flipped)), f"C00001={x:.3f},{y:.3f},{z:.3f},{rx:.4f},{ry:.4f},{rz:.4f}",
        "//INST", "///DATE 2026/03/02 14:07", "///ATTR SC,RW", "///GROUP1 RB1", "NOP", "MOVJ C00000 VJ=50.00",
        "MOVL C00001 V=100.0", "MOVJ C00001 VJ=50.00", "END",
    ]  # fmt: skip
    path = tmp_path / "WAY.JBI"
    path.write_bytes("".join(f"{row}\r\n" for row in job).encode())
    plan = read(path).plan(robot=GP25)
    line, joint = plan.positions.axes[plan.moves.target[1:]]
    np.testing.assert_allclose(line[:6], end, atol=1e-4)
    assert configuration_of(GP25, joint[:6])[0].tolist() == flipped
    # Not the place has changed between the two, but the arm.
    places = plan.positions.position[plan.moves.target[1:]]
    np.testing.assert_allclose(places[0], places[1], atol=1e-12)
    assert plan.moves.start[2] == plan.moves.target[1]
    assert any("arm flags" in one.says for one in plan.assumptions)


def test_the_axes_that_a_program_asks_for_are_those_of_the_plan(tmp_path):
    start = np.radians([10, 5, -20, 15, -50, 20])
    end = start + 0.1
    script(tmp_path, GP25, start, [("movel", end), ("movel", start)])
    text = (
        (tmp_path / "way.script")
        .read_text()
        .replace("\nend\n", "\n  q = get_actual_joint_positions()\n  movej(q)\nend\n")
    )
    path = tmp_path / "asks.script"
    path.write_text(text)
    found = axes_of(read(path), GP25)
    np.testing.assert_allclose(found, [start, end, start, start], atol=1e-7)


def test_a_straight_wrist_keeps_its_fourth_axis():
    joints = np.radians([10, 5, -20, 25, 0, 30])
    position, rotation = forward(GP25, joints)
    found = nearest(GP25, position, rotation, np.radians([12, 6, -22, 40, 3, 30]))[0]
    np.testing.assert_allclose(np.degrees(found), [10, 5, -20, 40, 0, 15], atol=1e-5)


def test_lines_that_a_program_comes_by_again_are_followed_once(tmp_path, monkeypatch):
    from olp.runtime.arm_branch import PlannedArm

    followed = []
    along = PlannedArm._along

    def counted(self, targets, here):
        followed.append(len(targets))
        return along(self, targets, here)

    counted.__name__ = "_along"
    monkeypatch.setattr(PlannedArm, "_along", counted)
    generator = np.random.default_rng(8)
    start = generator.uniform(0.4, 1.2, 6)
    ends = [near(GP25, start, 0.08, generator) for _ in range(3)]
    path = tmp_path / "round.script"
    rows = (
        script(tmp_path, GP25, start, [("movel", end) for end in ends]).to_bytes().decode().splitlines()[1:-2]
    )
    path.write_text(
        "\n".join(
            ["def way():", "  n = 0", "  while (n < 9):", *rows, "  n = n + 1", "  end", "end", "way()"]
        )
    )
    found = axes_of(read(path), GP25)
    np.testing.assert_allclose(found, np.tile([start, *ends], (9, 1)), atol=1e-7)
    assert sum(followed) <= 2 * len(ends)


def test_runs_that_go_the_same_way_follow_it_once(tmp_path, monkeypatch):
    from olp.core.result_cache import TextCache, remembering

    ways = []
    follow = PlannedArm._follow

    def counted(self, *given):
        ways.append(given)
        return follow(self, *given)

    monkeypatch.setattr(PlannedArm, "_follow", counted)
    generator = np.random.default_rng(17)
    start = generator.uniform(0.4, 1.2, 6)
    ends = [near(GP25, start, 0.08, generator) for _ in range(4)]
    one = script(tmp_path, GP25, start, [("movel", end) for end in ends])
    with remembering(TextCache()):
        found = [axes_of(one, GP25) for _ in range(3)]
        assert len(ways) == 1
        found[0][:] = 0.0  # what a caller does with its axes is its own
        np.testing.assert_array_equal(axes_of(one, GP25), found[1])
        other = script(tmp_path, GP25, start, [("movel", end) for end in ends[::-1]])
        np.testing.assert_allclose(axes_of(other, GP25), [start, *ends[::-1]], atol=1e-7)
        assert len(ways) == 2
    np.testing.assert_allclose(found[1], [start, *ends], atol=1e-7)


def test_runs_of_lines_that_are_solved_together_end_as_those_solved_one_by_one(tmp_path, monkeypatch):
    generator = np.random.default_rng(11)
    start = generator.uniform(0.4, 1.2, 6) * generator.choice([-1, 1], 6)
    moves = [("movel", near(GP25, start, 0.08, generator)) for _ in range(12)]
    program = script(tmp_path, GP25, start, moves)
    text = program.to_bytes().decode().split("\n")
    for row in (10, 7, 4):  # joint moves to written axes, each of which begins a run of lines
        text.insert(row, f"  movej({list(map(float, near(GP25, start, 0.05, generator)))})")
    (tmp_path / "runs.script").write_text("\n".join(text))
    program = read(tmp_path / "runs.script")
    with monkeypatch.context() as patch:
        patch.setattr(PlannedArm, "_again", None)  # which solves one run after the other
        together = axes_of(program, GP25)
    monkeypatch.setattr(PlannedArm, "_settle", lambda *_: None)
    np.testing.assert_array_equal(together, axes_of(program, GP25))
    assert len(together) == 16
    assert not np.isnan(together).any()


def test_lines_behind_an_unsure_one_are_not_all_solved_again_and_again(tmp_path, monkeypatch):
    asked = []
    really = PlannedArm._on_branch

    def counted(self, targets, start, first):
        asked.append(len(targets))
        return really(self, targets, start, first)

    solved = []
    inverse = importlib.import_module("olp.robots.kinematics.inverse")
    solve = inverse.inverse

    def solving(robot, positions, *more):
        solved.append(len(positions))
        return solve(robot, positions, *more)

    monkeypatch.setattr(PlannedArm, "_on_branch", counted)
    monkeypatch.setattr(inverse, "inverse", solving)
    generator = np.random.default_rng(11)
    start = np.array([0.4, -0.5, 0.6, 0.7, 0.0, 0.3])
    ends = [near(GP25, start, 0.03, generator) for _ in range(120)]
    for end in ends:
        end[4] = 0.0  # at a straight wrist the axes may go round
    axes_of(script(tmp_path, GP25, start, [("movel", end) for end in ends]), GP25)
    assert len(asked) > 60  # at many of them the run begins anew
    assert sum(asked) < 12 * len(ends)
    assert sum(solved) < 5 * len(ends)  # for either side of the wrist, and not once more for each new run


def test_a_position_in_two_runs_of_lines_is_solved_for_the_flags_of_each():
    joints = np.array([[0.4, -0.5, 0.6, 0.7, 0.5, 0.3], [0.5, -0.4, 0.6, 0.6, 0.7, 0.2]])
    position, rotation = forward(GP25, joints)
    positions = Positions(position, quaternion_from_rotation(rotation), joints)
    cell = SimpleNamespace(tool_pose=lambda number: Pose(np.zeros(3), np.eye(3)))
    flags = np.array([[0, 0, 0], [0, 0, 0], [1, 0, 0], [1, 0, 0]])
    targets = np.array([0, 1, 0, 1], dtype=np.int32)

    def arm():
        return PlannedArm(GP25, cell, positions, np.zeros(2, dtype=np.int32))

    at_once, again = arm(), arm()
    one_by_one = [arm()._with_flags(targets[[i]], flags[[i]])[0][0] for i in range(4)]
    np.testing.assert_array_equal(at_once._with_flags(targets, flags)[0], one_by_one)
    for i in (0, 2, 0, 1, 3):
        np.testing.assert_array_equal(again._with_flags(targets[[i]], flags[[i]])[0][0], one_by_one[i])
    assert np.abs(np.subtract(one_by_one[0], one_by_one[2])).max() > 1.0


def test_a_loop_over_lines_that_an_arm_without_a_closed_form_cannot_reach_is_followed_once(
    tmp_path, monkeypatch
):
    """Laps differ in the last digits of the axes, and a place between the two lines goes out of reach."""
    inverse = importlib.import_module(
        "olp.robots.kinematics.inverse"
    )  # the package has a function of this name
    calls = []
    whole = inverse.newton
    monkeypatch.setattr(inverse, "newton", lambda *given: calls.append(1) or whole(*given))
    rows = [
        "movej([0.3, -1.2, 1.4, -1.6, -1.5, 0.2])",
        "h = 0.3",
        "i = 0",
        "while i < 60:",
        "  movel(p[0.5, 0.1, h, 0, 3.1, 0])",
        "  movel(p[0.4, 0.3, 0.2, 0, 3.1, 0])",
        "  movel(p[1.18, 0.2, 0.7, 0, 3.1, 0])",
        "  h = h + 1.5",
        "  i = i + 1",
        "end",
    ]
    path = tmp_path / "way.script"
    path.write_text("\n".join(["def way():", *(f"  {row}" for row in rows), "end", "way()", ""]))
    plan = read(path).plan(robot="abb/crb15000-5-0.95")
    reached = ~np.isnan(plan.positions.axes[plan.moves.target]).any(axis=1)
    assert reached.tolist() == [True, True, True, False] + [False, True, False] * 59
    assert len(calls) < 300, len(calls)
