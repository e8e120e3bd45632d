"""Axis rates along moves, against joints along the path differentiated numerically."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import recordings
from cpu_time import cpu_time_below

from olp.core.units import deg, mm
from olp.identification.diagnosis.axis_rates import PLACES, AxisLaw, _over, limits_from_times, rates_of
from olp.identification.diagnosis.fitting import Noise, fit
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.diagnosis.search import shelf_of
from olp.identification.recorded_plan import case_of
from olp.identification.recording import read_recording
from olp.robots.geometry import (
    Pose,
    angles_from_rotation,
    quaternion_from_rotation,
    rotation_from_quaternion,
    slerp,
)
from olp.robots.kinematics import forward, inverse, track, with_tool, within_limits, without_tool
from olp.robots.kinematics.configuration import readings_of_joints
from olp.robots.robot import load_robot
from olp.timing.physics import load_term

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


def test_joint_points_that_are_elsewhere_than_the_tool_points_are_told_also_where_the_tool_is_given(tmp_path):
    robot, generator = load_robot("fanuc/m-20ia"), np.random.default_rng(7)
    lines = [line_of(robot, generator) for _ in range(4)]
    shown = [readings_of_joints(robot, joints) for joints, _, _ in lines]
    for joints, told in ((shown, True), ([joints for joints, _, _ in lines], False)):
        rows = [row(i, joints=j, pose=p) for i, (j, (_, p, _)) in enumerate(zip(joints, lines, strict=True))]
        recording = read(tmp_path, rows, robot.name, TOOL)
        _, notes = rates_of(recording, np.arange(4), recording.moves.chord)
        assert any("disagree" in note and "q3 + q2 is the joint's" in note for note in notes) is told


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


SPEEDS, RAMPS = np.array([2.1, 1.7, 2.6, 6.0]), np.array([4.0, 6.0, 5.0, 20.0])


def joint_times(turned, share, together, heavy=1.0):
    """What a simulation says of joint moves: all limits at once for all axes, or the slowest axis' own time."""
    paces, ramps = share[:, None] * SPEEDS / turned, RAMPS / turned
    ramps[:, 0] /= heavy
    if together:
        paces, ramps = paces.min(axis=1, keepdims=True), ramps.min(axis=1, keepdims=True)
    return np.where(paces**2 < ramps, 1 / paces + paces / ramps, 2 / np.sqrt(ramps)).max(axis=1)


def test_an_axis_whose_highest_speed_no_move_reaches_is_taken_to_reach_it_in_the_others_time():
    """It had none, so nothing that goes by the share of rated speeds, as `torque-speed` does, acted on its moves."""
    rng = np.random.default_rng(3)
    turned = np.where(
        rng.integers(4, size=120)[:, None] == np.arange(4), rng.uniform(0.5, 3.0, (120, 1)), 0.01
    )
    share, ramps = rng.choice([0.3, 0.6, 1.0], 120), SPEEDS / 0.4
    led = turned[:, 3] > 0.1
    turned[led, 3], share[led] = rng.uniform(0.1, 0.3, int(led.sum())), 1.0
    paces, slow = (share[:, None] * SPEEDS / turned).min(axis=1), (ramps / turned).min(axis=1)
    sim = np.where(paces**2 < slow, 1 / paces + paces / slow, 2 / np.sqrt(slow))
    found = limits_from_times(turned, share, np.ones(120), sim, np.ones(120, bool))
    speeds, likely = found.likely_speeds
    assert likely.tolist() == [False, False, False, True]
    np.testing.assert_allclose(speeds, SPEEDS, rtol=1e-3)
    alone = found._replace(speeds=np.where([True, False, False, False], SPEEDS, np.inf))
    assert not alone.likely_speeds[1].any()


@pytest.mark.parametrize("together", [True, False])
def test_the_limits_of_all_axes_are_read_off_simulated_joint_moves(together):
    rng = np.random.default_rng(3)
    turned, share = rng.uniform(0.05, 2.0, (120, 4)) * [1, 0.8, 1, 2], rng.choice([0.3, 0.6, 1.0], 120)
    sim = joint_times(turned, share, together)
    sim[::11] *= 0.8  # some go round a corner
    found = limits_from_times(turned, share, np.ones(120), sim, np.ones(120, bool))
    np.testing.assert_allclose(found.speeds, SPEEDS, rtol=1e-3)
    np.testing.assert_allclose(found.accelerations, RAMPS, rtol=1e-3)
    quick = np.argmin(share[:, None] * SPEEDS / turned, axis=1)
    assert np.mean(found.leading == quick) > (0.99 if together else 0.8)
    assert (
        limits_from_times(turned, share, np.ones(120), sim * rng.uniform(0.7, 1.3, 120), np.ones(120, bool))
        is None
    )


def test_a_time_beside_the_ramps_hides_no_limits_and_is_told(tmp_path):
    rng = np.random.default_rng(3)
    turned, share = rng.uniform(0.05, 2.0, (120, 4)) * [1, 0.8, 1, 2], rng.choice([0.3, 0.6, 1.0], 120)
    sim = joint_times(turned, share, True) + 0.05
    found = limits_from_times(turned, share, np.ones(120), sim, np.ones(120, bool))
    np.testing.assert_allclose(found.speeds, SPEEDS, rtol=1e-3)
    np.testing.assert_allclose(found.accelerations, RAMPS, rtol=1e-3)
    assert found.beside == pytest.approx(0.05, rel=1e-2)


def test_a_shortest_time_of_ramps_is_told_by_joint_moves():
    """A ramp to v takes v/a, or that time: small turns and slow moves all have it."""
    rng = np.random.default_rng(3)
    turned, share = rng.uniform(0.05, 2.0, (120, 4)) * [1, 0.8, 1, 2], rng.choice([0.1, 0.3, 1.0], 120)
    pace, ramp = (share[:, None] * SPEEDS / turned).min(axis=1), (RAMPS / turned).min(axis=1)
    low, high = np.zeros(120), pace
    for _ in range(60):
        middle = (low + high) / 2
        fits = middle * np.maximum(middle / ramp, 0.2) <= 1.0
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    ramps = np.maximum(low / ramp, 0.2)
    assert 0.2 < (low / ramp < 0.2).mean() < 0.8
    sim = 2.0 * ramps + (1.0 - low * ramps) / low
    found = limits_from_times(turned, share, np.ones(120), sim, np.ones(120, bool))
    np.testing.assert_allclose(found.speeds, SPEEDS, rtol=1e-3)
    np.testing.assert_allclose(found.accelerations, RAMPS, rtol=2e-3)
    assert (found.shortest, found.beside, found.built) == (pytest.approx(0.2, rel=1e-3), 0.0, 0.0)


@pytest.mark.parametrize("stop", [0.0, 0.05])
def test_accelerations_that_build_up_are_told_by_joint_moves_of_which_slow_ones_spend_a_part(stop):
    """A ramp to v takes v/a + t, or 2 √(v t/a) where it does not reach a."""
    rng = np.random.default_rng(3)
    turned, share = rng.uniform(0.05, 2.0, (120, 4)) * [1, 0.8, 1, 2], rng.choice([0.1, 0.3, 1.0], 120)
    pace, ramp = (share[:, None] * SPEEDS / turned).min(axis=1), (RAMPS / turned).min(axis=1)

    def ramped(fast):
        return np.where(fast >= 0.1 * ramp, fast / ramp + 0.1, 2 * np.sqrt(0.1 * fast / ramp))

    low, high = np.zeros(120), pace
    for _ in range(60):
        middle = (low + high) / 2
        fits = middle * ramped(middle) <= 1.0
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    top = np.where(pace * ramped(pace) <= 1.0, pace, low)
    assert (top < 0.1 * ramp).mean() > 0.2
    sim = 1.0 / top + ramped(top) + stop
    found = limits_from_times(turned, share, np.ones(120), sim, np.ones(120, bool))
    np.testing.assert_allclose(found.speeds, SPEEDS, rtol=1e-3)
    np.testing.assert_allclose(found.accelerations, RAMPS, rtol=2e-3)
    assert (found.built, found.beside) == (pytest.approx(0.1, rel=1e-2), pytest.approx(stop, abs=1e-3))


@pytest.mark.parametrize(
    ("overrides", "beside"), [((100,), 0.05), ((50,), 0.0), ((50,), 0.05), ((100, 50), 0.0)]
)
def test_joint_moves_without_a_robot_are_those_of_the_simulation_whatever_its_override_and_stops(
    overrides, beside, tmp_path
):
    rng = np.random.default_rng(8)
    points, share = rng.uniform(-1.0, 1.0, (121, 4)) * [1, 0.8, 1, 3], rng.choice([0.3, 0.6, 1.0], 120)
    override = np.array(overrides)[np.arange(120) // 60 % len(overrides)]  # of two sessions, say
    sim = joint_times(np.abs(np.diff(points, axis=0)), share * override / 100, True) + beside
    rows = [
        row(
            i + 1,
            "joint",
            points[i : i + 2],
            sim_s=repr(float(sim[i])),
            speed_pct=repr(float(100 * share[i])),
            override_pct=str(override[i]),
            sim_override_pct=str(override[i]),
        )
        for i in range(120)
    ]
    moves = case_of(read(tmp_path, rows)).case
    assert len(moves) > 110
    np.testing.assert_allclose(moves.base.duration(), moves.simulated, atol=1e-3)


def test_rounded_joint_moves_hide_no_limits(tmp_path):
    """Half of the moves go round a corner, by a law that olp does not know: those between exact stops tell the axes."""
    rng = np.random.default_rng(8)
    points, share = rng.uniform(-1.0, 1.0, (121, 4)) * [1, 0.8, 1, 3], rng.choice([0.3, 0.6, 1.0], 120)
    sim = joint_times(np.abs(np.diff(points, axis=0)), share, False)
    rounded = (np.arange(120) // 4 % 2).astype(bool)  # runs of four: there are moves between two stops
    sim[rounded] -= rng.uniform(0.05, 0.15, int(rounded.sum()))
    cells = [{"sim_s": repr(float(sim[i])), "speed_pct": repr(float(100 * share[i]))} for i in range(120)]
    rows = [
        row(i + 1, "joint", points[i : i + 2], **cells[i]) | {"blend_mm": "30" if rounded[i] else "0"}
        for i in range(120)
    ]
    moves = case_of(read(tmp_path, rows)).case
    np.testing.assert_allclose(moves.rates.rated, SPEEDS, rtol=1e-3)
    np.testing.assert_allclose(moves.rates.rated_acceleration, RAMPS, rtol=1e-3)


def test_an_axis_that_never_is_the_slowest_has_no_limit_in_simulated_times():
    rng = np.random.default_rng(6)
    turned, share = rng.uniform(0.02, 0.3, (60, 4)), rng.choice([0.3, 0.6, 1.0], 60)
    turned[:, 0] = rng.uniform(0.8, 2.0, 60)
    found = limits_from_times(turned, share, np.ones(60), joint_times(turned, share, True), np.ones(60, bool))
    assert found.speeds.tolist() == [pytest.approx(SPEEDS[0], rel=1e-3), np.inf, np.inf, np.inf]
    assert found.accelerations.tolist() == [pytest.approx(RAMPS[0], rel=1e-3), np.inf, np.inf, np.inf]
    assert set(found.leading.tolist()) == {0}


def test_joint_moves_without_a_robot_are_simulated_as_they_were(tmp_path):
    """The axis that turns farthest is often not the slowest: its speed was read off all the same, with rounded ends."""
    rng = np.random.default_rng(4)
    points, share = rng.uniform(-1.0, 1.0, (61, 4)) * [1, 0.8, 1, 2], rng.choice([0.3, 0.6, 1.0], 60)
    turned = np.abs(np.diff(points, axis=0))
    sim = joint_times(turned, share, True)
    rows = [
        row(
            i + 1,
            "joint",
            points[i : i + 2],
            sim_s=repr(float(sim[i])),
            speed_pct=repr(float(100 * share[i])),
        )
        | {"blend_mm": "30" if i % 3 == 0 else "0"}
        for i in range(60)
    ]
    moves = case_of(read(tmp_path, rows)).case
    np.testing.assert_allclose(moves.base.duration(), sim, rtol=1e-4)
    assert list(moves.leading) == [
        f"axis {k + 1}" for k in np.argmax(turned / SPEEDS / share[:, None], axis=1)
    ]
    np.testing.assert_allclose(moves.rates.rated_acceleration, RAMPS, rtol=1e-3)


def test_a_joint_move_that_alone_tells_an_axis_limits_is_not_judged(tmp_path):
    """A simulated time of one move fits a slow axis with short ramps and a quick one with long ramps."""
    rng = np.random.default_rng(7)
    points = rng.uniform(-1.0, 1.0, (61, 4)) * [1, 0.8, 1, 0.01]
    points[31:, 3] += 3.0  # axis 4 turns in move 31 alone
    turned, share = np.abs(np.diff(points, axis=0)), rng.choice([0.3, 0.6, 1.0], 60)
    turned[30, :3] = 0.1
    points = np.concatenate([np.zeros((1, 4)), np.cumsum(turned, axis=0)])
    sim = joint_times(turned, share, True)
    found = limits_from_times(turned, share, np.ones(60), sim, np.ones(60, bool))
    assert np.flatnonzero(~found.confirmed).tolist() == [30]
    assert found.speeds[3] == found.accelerations[3] == np.inf
    again = np.append(np.arange(60), [30] * 5)  # however often it is made
    found = limits_from_times(turned[again], share[again], np.ones(65), sim[again], np.ones(65, bool))
    assert np.flatnonzero(~found.confirmed).tolist() == [30, *range(60, 65)]
    cells = [{"sim_s": repr(float(sim[i])), "speed_pct": repr(float(100 * share[i]))} for i in range(60)]
    rows = [row(i + 1, "joint", points[i : i + 2], **cells[i]) | {"blend_mm": "30"} for i in range(60)]
    making = case_of(read(tmp_path, rows))
    assert making.case.move.tolist() == [i for i in range(1, 61) if i != 31]
    # The next one goes on from it all the same.
    assert making.case.base.corners.way[30] == pytest.approx(turned[30, 3], rel=1e-6)
    assert any("1 joint move alone" in note for note in making.notes)


@pytest.mark.parametrize(("between", "few"), [(6, True), (4, False), (1, False)])
def test_joint_moves_that_are_too_few_to_tell_all_limits_are_not_judged(between, few, tmp_path):
    """Beside lines: where something slows the first axis, which leads them, or any other, no time tells which one leads
    then. More of them have shown what the others can do, and where they are the rule they are what is asked about."""
    rng, count = np.random.default_rng(14), 70
    joint = np.arange(count) % between == 0
    points = np.cumsum(rng.uniform(0.02, 0.2, (count + 1, 4)), axis=0)
    for i in np.flatnonzero(joint).tolist():
        points[i + 1 :, 0] += rng.uniform(0.3, 1.5)
    share = rng.choice([0.3, 0.6, 1.0], count)
    sim = joint_times(np.diff(points, axis=0), share, True)
    tool = np.stack([0.1 * np.arange(count + 1), np.zeros(count + 1), np.zeros(count + 1)], axis=1), np.eye(3)
    rows = []
    for i in range(count):
        own = {"sim_s": repr(float(sim[i])), "speed_pct": repr(float(100 * share[i])), "blend_mm": "0"}
        if not joint[i]:
            own |= {"sim_s": "1.5", "speed_pct": "", "speed_mm_s": "100", "accel_mm_s2": "200"}
        if i == 18:
            own["blend_mm"] = "20"  # a joint move that runs into a line
        pose = [(tool[0][i], tool[1]), (tool[0][i + 1], tool[1])]
        rows.append(row(i + 1, "joint" if joint[i] else "linear", points[i : i + 2], pose, **own))
    making = case_of(read(tmp_path, rows))
    gone = set(range(1, count + 1)) - set(making.case.move.tolist())
    wanted = {*(np.flatnonzero(joint) + 1).tolist(), 20} if few else set()
    assert gone == wanted
    assert any("too few to tell the limits" in note for note in making.notes) == few


def joint_rows(points, share, sim, blend):
    cells = [
        {"sim_s": repr(float(t)), "speed_pct": repr(float(100 * p))} for t, p in zip(sim, share, strict=True)
    ]
    return [row(i + 1, "joint", points[i : i + 2], **c) | {"blend_mm": blend[i]} for i, c in enumerate(cells)]


def led_by_the_fourth(rng, led):
    """120 joint moves that other axes lead, but for those `led`."""
    turned = rng.uniform(0.1, 1.5, (120, 4)) * [1, 0.8, 1, 0.1]
    turned[led] = rng.uniform(0.05, 0.1, (len(led), 4))
    turned[led, 3] = rng.uniform(1.0, 3.0, len(led))
    share = rng.choice([0.3, 0.6, 1.0], 120)
    return np.concatenate([np.zeros((1, 4)), np.cumsum(turned, axis=0)]), turned, share


def test_moves_at_corners_that_the_simulation_stops_in_tell_limits_that_no_move_between_stops_reaches(
    tmp_path,
):
    """Axis 4 leads in five moves, all rounded: another axis was taken for the one that leads them, at a speed that made
    them half as long as the simulation says."""
    led = [8, 18, 28, 38, 48]
    points, turned, share = led_by_the_fourth(np.random.default_rng(12), led)
    sim = joint_times(turned, share, True)
    blend = ["30" if i // 4 % 2 or i in led else "0" for i in range(120)]
    moves = case_of(read(tmp_path, joint_rows(points, share, sim, blend))).case
    np.testing.assert_allclose(moves.rates.rated, SPEEDS, rtol=1e-3)
    np.testing.assert_allclose(moves.base.duration(), sim, rtol=1e-3)
    assert [moves.leading[i] for i in led] == ["axis 4"] * 5


def test_a_move_that_takes_longer_than_the_limits_say_is_not_judged(tmp_path):
    """A corner makes a move shorter, never longer: axis 4, which leads two rounded moves, has a limit of its own."""
    led, rng = [8, 28], np.random.default_rng(13)
    points, turned, share = led_by_the_fourth(rng, led)
    sim = joint_times(turned, share, True)
    rounded = np.array([i // 4 % 2 == 1 or i in led for i in range(120)])
    sim[rounded] -= rng.uniform(0.05, 0.15, int(rounded.sum()))
    making = case_of(read(tmp_path, joint_rows(points, share, sim, np.where(rounded, "30", "0"))))
    judged = set(making.case.move.tolist())
    assert len(judged) > 110
    assert not judged & {9, 29}


def test_a_stretched_arm_slows_joint_moves_as_far_as_the_first_axis_is_the_slowest(tmp_path):
    rng = np.random.default_rng(5)
    points, share = rng.uniform(-1.0, 1.0, (121, 4)) * [1, 0.8, 1, 2], rng.choice([0.3, 0.6, 1.0], 120)
    turned, reach = np.abs(np.diff(points, axis=0)), rng.uniform(0.4, 1.4, 120)
    told = joint_times(turned, share, True)
    measured = joint_times(turned, share, True, 1.0 + 0.8 * reach**2)
    rows = [
        row(
            i + 1,
            "joint",
            points[i : i + 2],
            sim_s=repr(float(told[i])),
            speed_pct=repr(float(100 * share[i])),
        )
        | {"duration_s": repr(float(measured[i]))}
        | {
            f"{c}_{end}_mm": repr(float(1000.0 * reach[i] * (c == "x")))
            for c in "xyz"
            for end in ("start", "end")
        }
        for i in range(120)
    ]
    moves = case_of(read(tmp_path, rows)).case
    term = load_term("reach-inertia")
    form = next(form for form in term.forms(moves) if form.key == "")
    best = fit(DurationModel((ModelPart(term, form, np.array([0.3])),)), moves, Noise(1e-5), 30)
    assert best.model.parts[0].values == pytest.approx([0.8], rel=1e-3)
    np.testing.assert_allclose(best.model.seconds(moves), measured, atol=1e-4)


def test_a_limit_that_a_step_of_the_fit_takes_beyond_all_numbers_is_none():
    per = np.array([[1.0, 2.0], [2.0, 1.0]])
    logs = np.array([0.0, 800.0, 0.0, 0.0])  # speeds of two axes, then accelerations
    with np.errstate(all="raise"):
        off, (fastest, _), _ = _over(logs, per, per, np.ones(2), AxisLaw(together=True, builds=False))
    np.testing.assert_array_equal(fastest, [0, 0])
    assert off == pytest.approx(np.log([2.0 / np.sqrt(0.5), 3.0]))


def bodies_without_the_robot(robot, folder, turned):
    """(n, m, 2, 3) [m] learnt from the ends of joint moves and lines, and what the robot's kinematics say. `turned`:
    another place of joint zero and another way to count for the third joint."""
    generator = np.random.default_rng(9)
    named, plain = [], []
    for number in range(24):
        joints, ends, _ = line_of(robot, generator)
        kind = "joint" if number % 2 else "linear"
        named.append(row(number, kind, joints=joints, pose=ends, speed_pct="50", speed_mm_s="100"))
        plain.append(row(number, kind, joints=turned(joints), pose=ends, speed_pct="50", speed_mm_s="100"))
    with_robot = read(folder / "named", named, robot.name, TOOL)
    without = read(folder / "plain", plain)
    found, _ = rates_of(without, np.arange(24), np.ones(24))
    exact, _ = rates_of(with_robot, np.arange(24), np.ones(24))
    return found.bodies, exact.bodies


@pytest.mark.parametrize("name", ["yaskawa/ma2010", "yaskawa/gp25"])
def test_elbow_and_wrist_of_an_arm_that_nobody_named_are_learnt_from_joints_and_points(tmp_path, name):
    (tmp_path / "named").mkdir()
    (tmp_path / "plain").mkdir()
    offset = np.array([0.0, 0.4, -0.7, 0.0, 0.0, 0.0])

    def turned(joints):
        counted = np.asarray(joints) + offset
        counted[:, 2] -= counted[:, 1]  # a forearm that a rod keeps
        return counted

    learnt, exact = bodies_without_the_robot(load_robot(name), tmp_path, turned)
    radius, wanted = (np.hypot(bodies[..., 0], bodies[..., 1]) for bodies in (learnt, exact))
    assert np.allclose(radius, wanted, atol=1e-3)
    rise, risen = (bodies[..., 2] - bodies[:1, :1, :, 2] for bodies in (learnt, exact))
    assert np.allclose(rise, risen, atol=1e-3)


@pytest.mark.parametrize("wrong", [0, 7])
def test_axis_rates_along_lines_of_an_arm_that_nobody_named_are_exact(tmp_path, wrong):
    """Against the kinematics of the robot; of some ends nobody knows whether the arm gets there."""
    robot, generator = load_robot("yaskawa/ma2010"), np.random.default_rng(4)
    named, plain = [], []
    for number in range(40):
        joints, ends, _ = line_of(robot, generator)
        told = np.asarray(joints) + (0.3 if number < wrong else 0.0)
        named.append(row(number, joints=joints, pose=ends, speed_mm_s="100"))
        plain.append(row(number, joints=told, pose=ends, speed_mm_s="100"))
    (tmp_path / "named").mkdir()
    (tmp_path / "plain").mkdir()
    every = np.arange(40)
    exact, _ = rates_of(read(tmp_path / "named", named, robot.name, TOOL), every, np.ones(40))
    found, _ = rates_of(read(tmp_path / "plain", plain), every, np.ones(40))
    np.testing.assert_allclose(found.path[wrong:, :, :3], exact.path[wrong:, :, :3], atol=1e-3)


def test_a_line_behind_the_arm_is_no_turn_of_its_first_axis(tmp_path):
    """Joint points give that axis within half a turn to either side."""
    generator, rows = np.random.default_rng(2), []
    for number in range(60):
        # Ends all around a first axis that nothing else is known of: the others have no arm's law.
        angle, radius = generator.uniform(-np.pi, np.pi, 2), generator.uniform(0.7, 1.2, 2)
        angle[1] = angle[0] + generator.uniform(-0.6, 0.6)
        ends = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(2)], axis=1)
        bearing = np.arctan2(ends[:, 1], ends[:, 0])
        joints = np.stack([bearing, radius, radius**2], axis=1)
        rows.append(
            row(number, speed_mm_s="100")
            | {
                f"{axis}_{end}_mm": repr(1000.0 * float(ends[k, c]))
                for k, end in enumerate(("start", "end"))
                for c, axis in enumerate("xyz")
            }
            | {
                f"q{axis + 1}_{end}_deg": repr(float(np.degrees(joints[k, axis])))
                for k, end in enumerate(("start", "end"))
                for axis in range(3)
            }
        )
    found, _ = rates_of(read(tmp_path, rows), np.arange(60), np.ones(60))
    turned = found.path[:, :, 0].mean(axis=1)
    assert np.abs(turned).max() < 1.0


def test_an_arm_whose_points_do_not_follow_from_its_joints_is_not_learnt(tmp_path):
    robot, generator = load_robot("yaskawa/ma2010"), np.random.default_rng(9)
    rows = []
    for number in range(24):
        joints, ends, _ = line_of(robot, generator)
        rows.append(row(number, joints=joints + generator.normal(0.0, 0.02, 6), pose=ends))
    rates, _ = rates_of(read(tmp_path, rows), np.arange(24), np.ones(24))
    assert rates.bodies is None


def test_moves_without_the_one_whose_arm_is_not_known_have_the_forms_of_all(tmp_path):
    robot, generator = load_robot("yaskawa/ma2010"), np.random.default_rng(9)
    rows = []
    for number in range(1, 25):
        joints, ends, _ = line_of(robot, generator)
        rows.append(row(number, joints=joints, pose=ends, speed_mm_s="100", accel_mm_s2="2000", sim_s="2.0"))
    moves = case_of(read(tmp_path, rows, robot.name, TOOL)).case
    assert moves.bodies_known
    bodies = moves.rates.bodies.copy()
    bodies[0] = np.nan
    moves = replace(moves, rates=replace(moves.rates, bodies=bodies), derived={}, numbers={})
    parts = shelf_of(moves, [load_term("gravity"), load_term("reach-inertia")]).parts
    some = moves.take(np.arange(1, len(moves)))
    for part in parts:
        model = DurationModel((part,))
        np.testing.assert_allclose(model.seconds(some), model.seconds(moves)[1:], atol=1e-9)
