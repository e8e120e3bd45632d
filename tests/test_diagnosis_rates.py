"""Axis rates along moves, against joints along the path differentiated numerically."""

from __future__ import annotations

import numpy as np
import pytest
import recordings
from cpu_time import cpu_time_below

from olp.core.units import deg, mm
from olp.identification.diagnosis.axis_rates import PLACES, rates_of
from olp.identification.recording import read_recording
from olp.robots.geometry import (
    Pose,
    angles_from_rotation,
    quaternion_from_rotation,
    rotation_from_quaternion,
    slerp,
)
from olp.robots.kinematics import forward, inverse, track, with_tool, within_limits, without_tool
from olp.robots.robot import load_robot

TOOL = (12.0, -30.0, 240.0, 10.0, -35.0, 20.0)
FINE = 4000


def read(folder, rows, robot="", tool=None):
    text = f'robot = "{robot}"\n' if robot else ""
    text += f"tool = {list(tool)}\n" if tool else ""
    recordings.write(folder, text, "recording.toml")
    names = tuple(dict.fromkeys(name for row in rows for name in row))
    return read_recording(recordings.write(folder, recordings.table(*rows, names=names)))


def row(number, kind="linear", joints=None, pose=None, via=None, **cells):
    """One row: `joints` (2, k) [rad] and `pose` two (position, rotation), each of them optional."""
    found = {"move": str(number), "duration_s": "1.0", "type": kind, **cells}
    for i, end in enumerate(("start", "end")):
        if pose is not None:
            place, rotation = pose[i]
            angles = angles_from_rotation(rotation[None])[0] / deg
            found |= {
                f"{c}_{end}_mm": repr(float(v)) for c, v in zip("xyz", np.asarray(place) / mm, strict=True)
            }
            found |= {f"r{c}_{end}_deg": repr(float(v)) for c, v in zip("xyz", angles, strict=True)}
        if joints is not None:
            found |= {f"q{k + 1}_{end}_deg": repr(float(v / deg)) for k, v in enumerate(joints[i])}
    if via is not None:
        found |= {f"{c}_via_mm": repr(float(v / mm)) for c, v in zip("xyz", via, strict=True)}
    return found


def poses_at(robot, joints, tool):
    """Tool poses of joints (n, k)."""
    position, rotation = with_tool(*forward(robot, joints), Pose.from_xyz_angles(_si(tool)))
    return list(zip(position, rotation, strict=True))


def _si(tool):
    return [v * (mm if i < 3 else deg) for i, v in enumerate(tool)]


def followed(robot, points, start, end, tool, seed):
    """Joints (n, k) along places (n, 3) of the tool with orientations between two, from `seed` on; by `track`."""
    first, last = (quaternion_from_rotation(rotation[None])[0] for rotation in (start[1], end[1]))
    turned = rotation_from_quaternion(slerp(first, last, np.linspace(0, 1, len(points))))
    return track(robot, *without_tool(points, turned, Pose.from_xyz_angles(_si(tool))), seed)


def at_places(joints, length):
    """(21, k) rates per metre, by central differences of joints at FINE + 1 even places."""
    slope = np.gradient(joints, length / FINE, axis=0, edge_order=2)
    return slope[:: FINE // (PLACES - 1)]


def line_of(robot, generator, tool=TOOL):
    """A random line that can be run: joints at both ends, poses, reference joints."""
    while True:
        middle = (robot.lower + robot.upper) / 2
        start = middle + generator.uniform(-0.3, 0.3, len(middle)) * (robot.upper - robot.lower)
        end = start + generator.uniform(-0.25, 0.25, len(middle))
        ends = poses_at(robot, np.stack([start, end]), tool)
        points = ends[0][0] + np.linspace(0, 1, FINE + 1)[:, None] * (ends[1][0] - ends[0][0])
        joints = followed(robot, points, *ends, tool, start)
        calm = np.isfinite(joints).all() and np.abs(np.diff(joints, axis=0)).max() < 2e-3
        if calm and np.abs(joints[-1] - end).max() < 1e-6 and within_limits(robot, joints).all():
            return np.stack([start, end]), ends, joints


@pytest.mark.parametrize("name", ["yaskawa/ma2010", "yaskawa/up20", "yaskawa/gp25"])
def test_lines_turn_the_axes_as_the_numeric_derivative_of_the_path_says(tmp_path, name):
    robot, generator = load_robot(name), np.random.default_rng(5)
    lines = [line_of(robot, generator) for _ in range(12)]
    rows = [row(i, joints=j, pose=p) for i, (j, p, _) in enumerate(lines)]
    recording = read(tmp_path, rows, name, TOOL)
    length = recording.moves.chord
    rates, _ = rates_of(recording, np.arange(12), length)
    assert rates.exact
    assert rates.known.all()
    assert rates.names == robot.axis_names
    assert np.array_equal(rates.rated, robot.speeds)
    for i, (_, _, joints) in enumerate(lines):
        assert np.allclose(rates.path[i], at_places(joints, length[i]), rtol=1e-3, atol=1e-3)


def test_joint_points_alone_give_the_same_as_tool_points_and_joint_points(tmp_path):
    robot, generator = load_robot("yaskawa/ma2010"), np.random.default_rng(6)
    lines = [line_of(robot, generator) for _ in range(6)]
    both = read(tmp_path, [row(i, joints=j, pose=p) for i, (j, p, _) in enumerate(lines)], robot.name, TOOL)
    rates, _ = rates_of(both, np.arange(6), both.moves.chord)
    alone = read(tmp_path, [row(i, joints=j) for i, (j, _, _) in enumerate(lines)], robot.name, TOOL)
    again, _ = rates_of(alone, np.arange(6), both.moves.chord)
    assert np.allclose(rates.path, again.path, rtol=1e-6, atol=1e-6)


def test_the_tool_is_learnt_from_joint_and_tool_points_together(tmp_path):
    robot, generator = load_robot("yaskawa/ma2010"), np.random.default_rng(7)
    lines = [line_of(robot, generator) for _ in range(6)]
    rows = [row(i, joints=j, pose=p) for i, (j, p, _) in enumerate(lines)]
    told = read(tmp_path, rows, robot.name, TOOL)
    rates, _ = rates_of(told, np.arange(6), told.moves.chord)
    untold = read(tmp_path, rows, robot.name)
    again, notes = rates_of(untold, np.arange(6), untold.moves.chord)
    assert np.allclose(rates.path, again.path, rtol=1e-5, atol=1e-5)
    assert not any("tool" in note for note in notes)


def test_tool_points_alone_are_followed_in_front_elbow_up(tmp_path):
    robot = load_robot("yaskawa/up20")
    down = Pose.from_xyz_angles([0, 0, 0, 180 * deg, -90 * deg, 0]).rotation
    start, end = (np.array([1.35, 0.7, 0.1]), down), (np.array([0.71, -0.65, 0.3]), down)
    recording = read(tmp_path, [row(1, pose=(start, end))], "yaskawa/up20")
    rates, notes = rates_of(recording, np.arange(1), recording.moves.chord)
    points = start[0] + np.linspace(0, 1, FINE + 1)[:, None] * (end[0] - start[0])
    seed = inverse(robot, points[:1], down[None])[0][0]
    joints = followed(robot, points, start, end, (0.0,) * 6, seed)
    assert np.allclose(rates.path[0], at_places(joints, recording.moves.chord[0]), rtol=1e-3)
    assert any("the tool is not given" in note for note in notes)
    assert any("elbow up" in note for note in notes)


def test_circular_moves_follow_the_arc_through_the_middle_point(tmp_path):
    robot = load_robot("yaskawa/ma2010")
    seed = np.array([0.3, 0.2, -0.4, 0.2, -0.9, 0.5])
    (place, turned), *_ = poses_at(robot, seed[None], TOOL)
    centre, radius, swept = place - np.array([0.15, 0, 0]), 0.15, 1.7 * np.pi / 2
    angle = np.linspace(0, swept, FINE + 1)
    around = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    points = centre + radius * around
    ends = (place, turned), (points[-1], Pose.from_xyz_angles([0, 0, 0, 0.3, 0.1, -0.4]).rotation @ turned)
    joints = followed(robot, points, *ends, TOOL, seed)
    via = points[FINE // 3]
    cells = row(1, "circular", joints=(seed, joints[-1]), pose=ends, via=via)
    recording = read(tmp_path, [cells], robot.name, TOOL)
    rates, _ = rates_of(recording, np.arange(1), np.array([radius * swept]))
    assert np.allclose(rates.path[0], at_places(joints, radius * swept), rtol=1e-3, atol=1e-3)


def test_a_line_through_the_straight_wrist_keeps_its_branch_and_its_way(tmp_path):
    robot, tool = load_robot("yaskawa/ma2010"), (0.0,) * 6
    start = np.array([0.0, 0.1, -0.2, 0.0, -0.35, 0.0])
    # In the arm's own plane: B passes zero, R and T stand still.
    first = poses_at(robot, start[None], tool)[0]
    ends = first, (first[0] + [0, 0, 0.1], Pose.from_xyz_angles([0, 0, 0, 0, -0.7, 0]).rotation @ first[1])
    points = first[0] + np.linspace(0, 1, FINE + 1)[:, None] * (ends[1][0] - first[0])
    joints = followed(robot, points, *ends, tool, start)
    assert joints[0, 4] < -0.3
    assert joints[-1, 4] > 0.05
    recording = read(tmp_path, [row(1, joints=(start, joints[-1]), pose=ends)], robot.name, tool)
    rates, _ = rates_of(recording, np.arange(1), recording.moves.chord)
    wanted = at_places(joints, recording.moves.chord[0])
    assert np.allclose(rates.path[0], wanted, rtol=1e-3, atol=1e-2)


def test_a_line_close_past_the_straight_wrist_does_not_jump_to_another_branch(tmp_path):
    robot, tool = load_robot("yaskawa/ma2010"), (0.0,) * 6
    # At the middle of the line B is 2 degrees: R turns by 160 degrees within a few centimetres.
    middle = np.array([0.0, 0.1, -0.2, 0.0, 0.0, 0.0])
    middle[3], middle[4] = 0.5 * np.pi, 2.0 * deg
    (place, turned), *_ = poses_at(robot, middle[None], tool)
    swing = [Pose.from_xyz_angles([0, 0, 0, 0, a, 0]).rotation @ turned for a in (-0.2, 0.2)]
    ends = (place - [0, 0, 0.1], swing[0]), (place - np.array([0, 0, -0.1]), swing[1])
    points = ends[0][0] + np.linspace(0, 1, FINE + 1)[:, None] * (ends[1][0] - ends[0][0])
    back = followed(robot, points[: FINE // 2 + 1][::-1], (place, turned), ends[0], tool, middle)
    on = followed(robot, points[FINE // 2 :], (place, turned), ends[1], tool, middle)
    joints = np.concatenate([back[::-1], on[1:]])
    assert np.ptp(joints[:, 3]) > 2.0
    recording = read(tmp_path, [row(1, joints=(joints[0], joints[-1]), pose=ends)], robot.name, tool)
    rates, _ = rates_of(recording, np.arange(1), recording.moves.chord)
    assert np.allclose(rates.path[0], at_places(joints, 0.2), rtol=2e-2, atol=2e-2)


def test_arms_without_a_closed_form_are_followed_from_their_joint_points(tmp_path):
    robot, generator = load_robot("ur10e"), np.random.default_rng(8)
    rows, wanted = [], []
    for number in range(4):
        start = np.array([0.0, -1.4, 1.2, -1.0, 1.4, 0.0]) + generator.uniform(-0.6, 0.6, 6)
        end = start + generator.uniform(-0.15, 0.15, 6)
        ends = poses_at(robot, np.stack([start, end]), TOOL)
        rows.append(row(number, joints=(start, end), pose=ends))
        points = ends[0][0] + np.linspace(0, 1, 401)[:, None] * (ends[1][0] - ends[0][0])
        joints = followed(robot, points, *ends, TOOL, start)
        wanted.append(np.gradient(joints, np.linalg.norm(ends[1][0] - ends[0][0]) / 400, axis=0)[::20])
    recording = read(tmp_path, rows, robot.name, TOOL)
    rates, _ = rates_of(recording, np.arange(4), recording.moves.chord)
    assert rates.known.all()
    assert np.allclose(rates.path[:, 1:-1], np.array(wanted)[:, 1:-1], rtol=2e-3, atol=2e-3)


def test_joint_moves_turn_all_axes_in_proportion(tmp_path):
    robot = load_robot("yaskawa/ma2010")
    start, end = (
        np.array([0.1, 0.2, -0.1, 0.3, -0.5, 0.2]),
        np.array([-0.6, 0.4, 0.1, -0.2, -0.9, 1.0]),
    )
    joints = read(tmp_path, [row(1, "joint", joints=(start, end))], robot.name, TOOL)
    way = np.array([0.8])
    rates, _ = rates_of(joints, np.arange(1), way)
    assert np.allclose(rates.path[0], (end - start) / 0.8)
    poses = poses_at(robot, np.stack([start, end]), TOOL)
    points = read(tmp_path, [row(1, "joint", pose=poses)], robot.name, TOOL)
    again, _ = rates_of(points, np.arange(1), way)
    # Without joint points the wrist may be the other way round: S, L and U are the same.
    assert np.allclose(again.path[0, :, :3], rates.path[0, :, :3])


def test_without_a_robot_joint_points_give_means_and_say_so(tmp_path):
    start, end = np.zeros(6), np.array([0.1, -0.2, 0.3, 0.0, 0.5, -0.6])
    recording = read(tmp_path, [row(1, joints=(start, end)), row(2, "wait", joints=(end, end))])
    rates, notes = rates_of(recording, np.arange(2), np.array([0.5, 0.0]))
    assert not rates.exact
    assert rates.rated is None
    assert rates.known.tolist() == [True, False]
    assert np.allclose(rates.path[0], end / 0.5)
    assert np.all(rates.path[1] == 0)
    assert "names no robot" in notes[0]


def test_without_robot_and_joint_points_nothing_is_said_of_axes(tmp_path):
    recording = recordings.read(tmp_path, recordings.table(*recordings.moves(3)))
    rates, notes = rates_of(recording, np.arange(3), recording.moves.chord)
    assert rates is None
    assert "joint-speed-limit" in notes[0]


def test_what_cannot_be_known_is_zero_and_listed_with_its_reason(tmp_path):
    turned = np.eye(3)
    near, far = np.array([1.0, 0.2, 0.3]), np.array([9.0, 0.2, 0.3])
    rows = [
        row(11, pose=((near, turned), (near + 0.1, turned))),
        row(12, pose=((near, turned), (far, turned))),
        row(13, pose=((near, turned), (near, turned))),
        row(14, "wait"),
        row(15, "circular", pose=((near, turned), (near + 0.1, turned))),
    ]
    rows[-1] |= {"x_via_mm": "1050", "y_via_mm": "210", "z_via_mm": "390"}
    rows[0] |= {f"r{c}_{end}_deg": "" for c in "xyz" for end in ("start", "end")}
    recording = read(tmp_path, rows, "yaskawa/ma2010", TOOL)
    rates, notes = rates_of(recording, np.arange(5), np.array([0.2, 8.0, 0.0, 0.0, 0.2]))
    assert rates.known.tolist() == [False, False, False, False, True]
    assert np.all(rates.path[:4] == 0)
    told = notes[-1]
    assert told.startswith("3 of 4 moves have no axis rates")
    assert "no tool orientation (1, the first is move 11)" in told
    assert "out of reach (1, the first is move 12)" in told
    assert "no length (1, the first is move 13)" in told


def test_six_hundred_moves_take_less_than_a_second(tmp_path):
    robot, generator = load_robot("yaskawa/ma2010"), np.random.default_rng(9)
    rows = []
    for number in range(600):
        middle = np.array([0.0, 0.2, -0.2, 0.0, -0.8, 0.0])
        start = middle + generator.uniform(-0.5, 0.5, 6)
        end = start + generator.uniform(-0.4, 0.4, 6)
        poses = poses_at(robot, np.stack([start, end]), TOOL)
        rows.append(row(number, joints=(start, end), pose=poses))
    recording = read(tmp_path, rows, robot.name, TOOL)
    with cpu_time_below(1.0):
        rates, _ = rates_of(recording, np.arange(600), recording.moves.chord)
    assert rates.path.shape == (600, PLACES, 6)
    assert rates.known.mean() > 0.9
