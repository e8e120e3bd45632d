"""A stepped controller ends when the closed forms do, goes where the track goes, and hands out nothing too early."""

from __future__ import annotations

import itertools
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from olp.core.diagnostic import OlpError
from olp.fluent import read
from olp.ir.program import Path
from olp.robots.geometry import Pose, rotation_from_quaternion
from olp.robots.kinematics import forward
from olp.robots.robot import load_robot
from olp.servers.controller import Controller, State, Step, Target
from olp.servers.controller.controller import Go, Queue, Stay
from olp.timing.motion import model_names
from olp.timing.timing import time_plan
from olp.timing.track import states, track

ARM = load_robot("yaskawa/ma2010")
TOOL = Pose.from_xyz_angles([0.012, -0.007, 0.31, 0.1, 0.52, 0.2])
HOME = np.radians([11.3, 5.2, -8.4, 12.6, -61.7, 20.9])
CYCLE = 0.004
ANY_MODEL = pytest.mark.parametrize("model", model_names())


def arm(model: str = "constant", **options) -> Controller:
    controller = Controller(ARM, model=model, cycle=CYCLE, **options)
    controller.set_tool(TOOL)
    controller.set_position(HOME)
    return controller


BASE = arm().step().tool


def at(x: float, y: float, z: float, turn: float = 0.0) -> Pose:
    """A pose beside the one at home, in mm and degrees."""
    turned = Pose.from_xyz_angles([0, 0, 0, np.radians(turn), 0, 0])
    return Pose(BASE.position + np.array([x, y, z]) * 1e-3, BASE.rotation @ turned.rotation)


def line(*place: float, speed: float = 0.23, zone: float | None = 0.0) -> Target:
    return Target(Path.LINEAR, pose=at(*place), speed=speed, zone=zone)


def arc(via, end, speed: float = 0.17, zone: float | None = 0.0) -> Target:
    return Target(Path.CIRCULAR, pose=at(*end), via=at(*via), speed=speed, zone=zone)


def joint(*degrees: float, speed: float = 0.43, zone: float | None = 0.0) -> Target:
    return Target(Path.JOINT, joints=tuple(np.radians(degrees)), speed=speed, zone=zone)


def spline(*place: float, zone: float | None = None) -> Target:
    return Target(Path.SPLINE, pose=at(*place), speed=0.19, zone=zone)


PROGRAMS = {
    "lines with exact stops": [line(83, 41, 0), line(95, -87, 61, 13), line(-37, 12, 5)],
    "lines without a zone": [line(83, 41, 0, zone=None), line(95, -87, 61, 13, zone=None), line(-37, 12, 5)],
    "lines with zones": [line(83, 41, 0, zone=0.025), line(95, -87, 61, zone=0.1), line(-37, 12, 5)],
    "short lines that cannot brake in one": [line(1.7 * i, 0.3 * i, 0, speed=0.6, zone=None) for i in range(1, 25)],
    "an arc between lines": [line(83, 41, 0, zone=None), arc((121, 77, 3), (90, 120, 9), zone=None), line(5, 6, 7)],
    "arcs with zones": [arc((41, 52, 3), (7, 103, 11), zone=0.025), arc((-61, 88, 3), (-93, 20, 0), zone=0.05)],
    "joint moves": [joint(20, 11, -3, 17, -50, -41, zone=0.05), joint(-9, 0, 4, 3, -72, 33), joint(*np.degrees(HOME))],
    "joint move into lines": [joint(17, 8, -5, 9, -57, 8, zone=0.05), line(83, 41, 0, zone=0.05), line(2, 3, 4)],
    "splines": [spline(31, 17, 0), spline(63, 5, 8), spline(88, 29, 3), spline(120, 22, 1, zone=0.0), line(1, 2, 3)],
    "dense splines": [spline(1.9 * i, 7 * (i % 3 == 0), 0.4 * i) for i in range(1, 16)],
    "turning on the spot": [Target(Path.LINEAR, pose=at(0, 0, 0, 37), turn=0.9), line(60, 0, 0, 11)],
    "going where it stands": [line(0, 0, 0), line(50, 7, 0), line(50, 7, 0, zone=None), line(0, 0, 0)],
}  # fmt: skip
ANY_PROGRAM = pytest.mark.parametrize("targets", PROGRAMS.values(), ids=PROGRAMS)
ANY_NAME = pytest.mark.parametrize("program", PROGRAMS)


def closed_form(targets: list[Target], model: str):
    """The same targets as one plan, timed at once."""
    controller = arm(model)
    for target in targets:
        controller.target(target)
    queue: Queue = controller._queue
    queue.closed = True
    known = queue.known()
    assert known.timing is not None
    return known.timing


def starved(controller: Controller, targets: list[Target]) -> list[Step]:
    """Steps of a simulator that gives a target only when it is asked for one."""
    waiting, steps = list(targets), []
    for _ in range(200_000):
        step = controller.step()
        if step.elapsed:
            steps.append(step)
        if step.state is State.DONE:
            return steps
        if step.state is not State.MOVING:
            if waiting:
                controller.target(waiting.pop(0))
            else:
                controller.end()
    raise AssertionError("the controller never comes to an end")


@cache
def steps_of(program: str, model: str = "constant") -> list[Step]:
    """`starved` of one of the programs, which several tests look at."""
    return starved(arm(model), PROGRAMS[program])


@pytest.mark.slow("short lines that cannot brake in one-linear", "dense splines-linear")
@ANY_MODEL
@ANY_NAME
def test_the_last_step_ends_when_the_closed_form_ends(program, model):
    steps = steps_of(program, model)
    assert steps[-1].time == pytest.approx(closed_form(PROGRAMS[program], model).total_s, abs=1e-9)
    assert steps[-1].speed == 0.0
    assert sum(step.elapsed for step in steps) == pytest.approx(steps[-1].time)


@pytest.mark.slow("short lines that cannot brake in one-linear", "dense splines-linear")
@ANY_MODEL
@ANY_NAME
def test_a_simulator_that_is_late_and_one_that_is_early_see_the_same_motion(program, model):
    early, targets = arm(model), PROGRAMS[program]
    for target in targets:
        early.target(target)
    early.end()
    path = track(closed_form(targets, model), 1e-3)
    for steps in (steps_of(program, model), list(early.run())):
        times = np.array([step.time for step in steps])
        position = np.array([step.tool.position for step in steps])
        expected = np.stack([np.interp(times, path.time, column) for column in path.position.T], axis=1)
        assert np.abs(position - expected).max() < 2e-6


@ANY_NAME
def test_every_step_is_one_cycle_long_except_the_last_of_a_motion(program):
    steps = steps_of(program)
    for step in steps:
        if step.state is State.MOVING:
            assert step.elapsed == pytest.approx(CYCLE)
        assert 0 < step.elapsed <= CYCLE * (1 + 1e-9)


@ANY_PROGRAM
def test_the_arm_never_jumps_and_the_speed_is_that_of_the_positions(targets):
    early = arm()
    for target in targets:
        early.target(target)
    early.end()
    steps = list(early.run())
    joints = np.array([HOME, *(step.joints for step in steps)])
    fastest = ARM.speeds * CYCLE
    assert (np.abs(np.diff(joints, axis=0)) < 3 * fastest).all()
    position = np.array([step.tool.position for step in steps])
    speeds = np.array([step.speed for step in steps])
    travelled = np.linalg.norm(np.diff(position, axis=0), axis=1)
    elapsed = np.array([step.elapsed for step in steps[1:]])
    assert (travelled / elapsed < np.maximum(speeds[:-1], speeds[1:]) + 0.1).all()
    mean = (speeds[:-1] + speeds[1:]) / 2
    assert np.sum(mean * elapsed) == pytest.approx(travelled.sum(), rel=0.05)


def test_the_last_step_stands_where_the_target_is():
    end = at(-37, 12, 5, 21)
    steps = starved(arm(), [line(83, 41, 0, zone=0.02), Target(Path.LINEAR, pose=end, speed=0.2)])
    assert steps[-1].tool.position == pytest.approx(end.position, abs=1e-9)
    assert steps[-1].tool.rotation == pytest.approx(end.rotation, abs=1e-9)
    goal = np.radians([20, 11, -3, 17, -50, -41])
    assert starved(arm(), [joint(*np.degrees(goal))])[-1].joints == pytest.approx(goal, abs=1e-12)


def test_an_arm_that_only_waits_stands_where_it_is():
    controller = arm()
    controller.wait(0.02)
    controller.end()
    steps = list(controller.run())
    assert len(steps) >= 5
    assert steps[-1].time == pytest.approx(0.02)
    for step in steps:
        np.testing.assert_allclose(step.joints, HOME, atol=1e-12)
        np.testing.assert_allclose(step.tool.position, BASE.position, atol=1e-9)
        np.testing.assert_allclose(step.tool.rotation, BASE.rotation, atol=1e-9)
        assert step.speed == 0.0


def test_a_line_to_joints_ends_in_these_very_joints():
    controller = arm()
    controller.target(line(83, 41, 0))
    there = list(controller.run())[-1].joints + 1e-8
    controller.set_position(HOME)
    controller.target(Target(Path.LINEAR, joints=tuple(there), speed=0.2))
    assert np.array_equal(list(controller.run())[-1].joints, there)


@ANY_PROGRAM
def test_a_step_that_says_moving_is_followed_by_another(targets):
    controller, waiting, promised = arm(), list(targets), False
    state = State.NEEDS_TARGET
    while state is not State.DONE:
        if state is not State.MOVING and waiting:
            controller.target(waiting.pop(0))
        elif state is not State.MOVING:
            controller.end()
        step = controller.step()
        assert step.elapsed > 0 or not promised
        state, promised = step.state, step.state is State.MOVING


def test_random_programs_end_with_the_closed_form_however_they_are_fed():
    generator = np.random.default_rng(20261120)
    for _ in range(12):
        targets = []
        for _ in range(int(generator.integers(2, 9))):
            zone = [0.0, None, float(generator.uniform(0.002, 0.08))][generator.integers(3)]
            place = generator.uniform(-120, 120, 3)
            turn, speed = generator.uniform(-20, 20), float(generator.uniform(0.02, 0.9))
            targets.append(line(*place, turn, speed=speed, zone=zone))
        controller, waiting, last = arm(), list(targets), None
        while last is None or last.state is not State.DONE:
            last = controller.step()
            while waiting and (last.state is not State.MOVING or generator.random() < 0.02):
                controller.target(waiting.pop(0))
                if generator.random() < 0.5:
                    break
            if not waiting:
                controller.end()
        assert last.time == pytest.approx(closed_form(targets, "constant").total_s, abs=1e-9)


def test_a_corner_is_not_entered_before_what_follows_is_known():
    controller = arm()
    controller.target(line(83, 41, 0, zone=0.02))
    assert list(controller.run()) == []
    assert controller.step().state is State.NEEDS_TARGET
    controller.target(line(95, -87, 61))
    assert controller.step().state is State.MOVING


def test_an_exact_stop_needs_no_look_ahead():
    controller = arm()
    controller.target(line(83, 41, 0))
    steps = list(controller.run())
    assert steps[-1].state is State.NEEDS_TARGET
    assert steps[-1].speed == 0.0
    assert steps[-1].time == pytest.approx(closed_form([line(83, 41, 0)], "constant").total_s, abs=1e-9)
    controller.end()
    assert controller.step().state is State.DONE


def test_a_simulator_that_has_nothing_to_give_waits_in_place():
    controller = arm()
    controller.target(line(83, 41, 0, zone=None))
    controller.target(line(140, 60, 0, zone=None))
    list(controller.run())
    first, second = controller.step(), controller.step()
    assert (first.elapsed, first.state) == (0.0, State.NEEDS_TARGET)
    assert second.time == first.time
    assert np.array_equal(second.joints, first.joints)


def test_states_from_idle_to_done_and_on():
    controller = arm()
    assert controller.step().state is State.IDLE
    assert controller.target(line(20, 0, 0)) == 1
    assert controller.wait(0.05) == 2
    controller.end()
    steps = list(controller.run())
    assert steps[-1].state is State.DONE
    assert {step.target for step in steps} == {1, 2}
    done = steps[-1].time
    assert controller.target(line(0, 0, 0)) == 3
    again = list(controller.run())
    assert again[0].time == pytest.approx(done + CYCLE)
    assert again[-1].state is State.NEEDS_TARGET


def test_a_wait_lasts_as_long_as_it_says_and_stops_the_move_before():
    controller = arm()
    controller.target(line(83, 41, 0, zone=None))
    controller.wait(0.731)
    controller.target(line(0, 0, 0))
    controller.end()
    steps = list(controller.run())
    there, back = (closed_form([line(83, 41, 0, zone=None)], "constant") for _ in range(2))
    still = [step for step in steps if step.speed < 1e-9]
    assert len(still) * CYCLE == pytest.approx(0.731 + 0.166, abs=0.012)
    assert steps[-1].time > there.total_s + back.total_s + 0.731


def test_a_long_motion_with_stops_does_not_pile_up():
    controller = arm()
    for i, x in enumerate(itertools.islice(itertools.cycle([20, 0]), 40)):
        controller.target(line(x, 0, 0, speed=0.8))
        list(controller.run())
        assert len(controller._queue.items) <= 1, f"after target {i}"


def test_targets_given_while_the_arm_is_long_past_a_stop_do_not_pile_up():
    controller = arm()
    for x in (20, 0, 20):
        controller.target(line(x, 0, 0, speed=0.8))
    total = closed_form([line(x, 0, 0, speed=0.8) for x in (20, 0, 20)], "constant").total_s
    while controller.step().time < 0.7 * total:
        pass
    controller.target(line(40, 0, 0, speed=0.8))
    assert len(controller._queue.items) == 2
    all_of_it = closed_form([line(x, 0, 0, speed=0.8) for x in (20, 0, 20, 40)], "constant").total_s
    assert list(controller.run())[-1].time == pytest.approx(all_of_it, abs=1e-9)


def test_poses_are_given_and_told_in_the_frame():
    frame = Pose.from_xyz_angles([0.83, -0.21, 0.14, 0.2, -0.4, 1.1])
    plain, framed = arm(), arm()
    framed.set_frame(frame)
    goal = at(83, 41, 0, 9)
    plain.target(Target(Path.LINEAR, pose=goal, speed=0.2))
    framed.target(Target(Path.LINEAR, pose=frame.inverse() @ goal, speed=0.2))
    one, two = list(plain.run()), list(framed.run())
    assert two[-1].time == pytest.approx(one[-1].time, abs=1e-9)
    seen = frame @ two[7].tool
    assert seen.position == pytest.approx(one[7].tool.position, abs=1e-9)
    assert two[-1].joints == pytest.approx(one[-1].joints, abs=1e-9)


def test_a_joint_move_to_a_pose_goes_there_in_the_frame_too():
    frame = Pose.from_xyz_angles([0.83, -0.21, 0.14, 0.2, -0.4, 1.1])
    controller = arm()
    controller.set_frame(frame)
    goal = at(83, 41, 0, 9)
    controller.target(Target(Path.JOINT, pose=frame.inverse() @ goal, speed=0.4))
    seen = frame @ list(controller.run())[-1].tool
    assert seen.position == pytest.approx(goal.position, abs=1e-9)
    assert seen.rotation == pytest.approx(goal.rotation, abs=1e-9)


def test_another_tool_takes_the_arm_elsewhere():
    controller = arm()
    controller.target(line(83, 41, 0))
    list(controller.run())
    other = Pose.from_xyz_angles([0.0, 0.05, 0.2, 0.0, 0.3, 0.0])
    controller.set_tool(other)
    stands = controller.step().tool
    goal = Pose(stands.position + np.array([0.0, 0.0, 0.05]), stands.rotation)
    controller.target(Target(Path.LINEAR, pose=goal, speed=0.2))
    end = list(controller.run())[-1]
    assert end.tool.position == pytest.approx(goal.position, abs=1e-9)


def test_effects_of_the_controller_reach_the_steps():
    plain, slow = arm(), arm(settings={"override_pct": 50.0, "servo_lag_s": 0.05})
    ends = []
    for controller in (plain, slow):
        controller.target(line(400, 100, 0, speed=0.1))
        ends.append(list(controller.run())[-1].time)
    assert ends[1] == pytest.approx(2 * (ends[0] - 0.166) + 0.166 + 0.05, abs=0.05)


def test_a_harder_stop_at_the_end_changes_only_what_is_not_yet_certain():
    """The rule that decides what is certain, against the truth: what the full program turns out to do."""
    targets = PROGRAMS["short lines that cannot brake in one"]
    controller = arm()
    full = closed_form(targets, "constant")
    for count, target in enumerate(targets[:-1], 1):
        controller.target(target)
        known = controller._queue.known()
        if known.horizon <= 0:
            continue
        assert known.timing is not None
        mine = [track_position(known.timing, share * known.horizon) for share in (0.3, 0.9, 1.0)]
        real = [track_position(full, share * known.horizon) for share in (0.3, 0.9, 1.0)]
        assert np.abs(np.array(mine) - real).max() < 1e-9, f"after {count} targets"


def test_the_length_of_a_spline_is_not_relied_on_before_the_point_that_shapes_it():
    """Found by random search: this last spline is shorter once its next point is known."""
    points = [(-6.91, 8.28, -3.1), (-6.9, 8.28, -3.09), (-6.36, 7.89, -3.34), (-11.21, 14.47, -7.79)]
    targets = [replace(spline(*point), speed=0.6) for point in points]
    targets.append(replace(spline(-11.22, 14.5, -7.8, zone=0.0), speed=0.6))
    steps, timing = starved(arm(), targets), closed_form(targets, "constant")
    expected = states(timing, np.array([step.time for step in steps]))[0]
    assert np.array([step.tool.position for step in steps]) == pytest.approx(expected, abs=1e-10)


def track_position(timing, time: float) -> np.ndarray:
    return states(timing, np.array([time]))[0][0]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"pose": None}, "either joints or a pose"),
        ({"joints": (0.1,) * 6}, "either joints or a pose"),
        ({"speed": None}, "either a speed or a turning speed"),
        ({"speed": 0.0}, "speed has to be above zero"),
        ({"speed": float("nan")}, "speed has to be above zero"),
        ({"zone": -0.001}, "zone has to be zero or more"),
        ({"zone": float("inf")}, "zone has to be zero or more"),
        ({"acceleration": 0.0}, "acceleration has to be above zero"),
        ({"path": Path.CIRCULAR}, "via pose"),
        ({"path": Path.JOINT, "speed": 1.2}, "at most 1"),
        ({"path": Path.JOINT, "speed": None, "turn": 1.0}, "no turning speed"),
        ({"pose": None, "joints": (0.1, 0.2)}, "6 axes"),
        ({"pose": Pose(np.array([np.nan, 0, 0]), np.eye(3))}, "finite"),
    ],
)
def test_a_wrong_target_is_told_and_not_queued(change, says):
    controller = arm()
    with pytest.raises(OlpError, match=says) as caught:
        controller.target(replace(line(83, 41, 0), **change))
    assert {d.code for d in caught.value.diagnostics} == {"S003"}
    assert controller.step().state is State.IDLE
    assert controller.target(line(83, 41, 0)) == 1


@pytest.mark.parametrize(
    ("target", "code"),
    [
        (line(9000, 0, 0), "S004"),
        (Target(Path.JOINT, pose=at(9000, 0, 0), speed=0.5), "S004"),
        (arc((900, 5000, 0), (9000, 100, 0)), "S004"),
        (joint(200, 0, 0, 0, 0, 0), "S005"),
        (Target(Path.LINEAR, joints=tuple(HOME + np.array([0, 0, 0, np.pi, 0, 0])), speed=0.1), "S006"),
    ],
)
def test_what_the_arm_cannot_do_is_told_and_not_queued(target, code):
    controller = arm()
    with pytest.raises(OlpError) as caught:
        controller.target(target)
    assert {d.code for d in caught.value.diagnostics} <= {code, "S005"}
    assert controller._queue.items == []


def test_an_arm_that_moves_is_not_put_elsewhere():
    controller = arm()
    controller.target(line(83, 41, 0))
    controller.step()
    with pytest.raises(OlpError, match="moves"):
        controller.set_position(HOME)
    list(controller.run())
    controller.set_position(HOME)
    assert controller.step().time == 0.0


@pytest.mark.parametrize("joints", [np.zeros(5), np.full(6, np.nan), np.full(6, 9.0)])
def test_a_position_that_is_none_is_refused(joints):
    with pytest.raises(OlpError):
        arm().set_position(joints)


@pytest.mark.parametrize("cycle", [0.0, -0.004, float("nan"), float("inf")])
def test_a_cycle_that_is_none_is_refused(cycle):
    with pytest.raises(OlpError, match="cycle"):
        Controller(ARM, cycle=cycle)


def test_a_wait_that_is_none_is_refused():
    for seconds in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(OlpError, match="wait"):
            arm().wait(seconds)


def test_the_plan_of_the_queue_is_the_plan_of_a_program():
    controller = arm()
    controller.target(line(83, 41, 0, zone=0.02))
    controller.wait(0.2)
    first, second = controller._queue.items
    assert isinstance(first, Go)
    assert isinstance(second, Stay)
    plan = controller._queue._plan([first, second])[0]
    assert time_plan(plan).wait_s == 0.2
    assert plan.statement(0) == "target 1"


def test_a_job_that_is_stepped_takes_the_time_that_olp_time_says():
    """The other way round: from a program's plan to targets, poses and all."""

    plan = read("samples/up20/APPR-1.JBI").plan()
    timing = time_plan(plan)
    assert plan.robot is not None
    controller = Controller(plan.robot, cycle=CYCLE, acceleration=0.4, settings=plan.settings)
    moves, positions = plan.moves, plan.positions
    flange = forward(plan.robot, positions.axes[moves.start[1], : len(plan.robot.axes)])
    taught = Pose(
        positions.position[moves.start[1]],
        rotation_from_quaternion(positions.quaternion[moves.start[1]][None])[0],
    )
    controller.set_tool(Pose(flange[0][0], flange[1][0]).inverse() @ taught)
    controller.set_position(positions.axes[moves.start[1], : len(plan.robot.axes)])
    rotations = rotation_from_quaternion(positions.quaternion)
    count = 7
    for row in range(1, count + 1):
        pose = Pose(positions.position[moves.target[row]], rotations[moves.target[row]])
        controller.target(Target(Path.LINEAR, pose=pose, speed=float(moves.travel[row])))
    controller.end()
    last = list(controller.run())[-1]
    assert last.time == pytest.approx(timing.end_s[count] - timing.end_s[0], abs=1e-9)
    assert last.joints == pytest.approx(positions.axes[moves.target[count]][: len(last.joints)], abs=1e-6)
