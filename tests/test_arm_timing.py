"""The law of joint moves: its mathematics, its priors, and what calibration makes of recorded moves."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import olp
from olp.__main__ import main
from olp.identification.recording import read_recording
from olp.identification.signature import calibrate, read_signature, write_signature
from olp.identification.signature.boosted_trees import BoostedTrees, fit_trees
from olp.identification.signature.joint_moves import (
    contradicting,
    corrected,
    faster_than_rated,
    find_regions,
    fit_arm,
    learn_arm,
    recorded_joint_moves,
)
from olp.identification.signature.rows import predict_recording
from olp.reports.batch import Job, plan_and_time
from olp.robots.kinematics import forward
from olp.robots.model import Robot
from olp.robots.robot import load_robot
from olp.robots.times_to_speed import reach_of
from olp.timing.arm import ArmTiming, gradient, solve
from olp.timing.arm_moves import JointMoves, joint_moves, rated_inertia, taken_of_drives
from olp.timing.arm_prior import arm_prior, fastest_speed, known_lines, line_acceleration, line_class
from olp.timing.joint_times import ramp_doubt

Floats = NDArray[np.float64]
ROBOT = "kuka/kr3-r540"


def moves_of(count: int, seed: int = 0, robot: str | None = None, load: float | None = None) -> JointMoves:
    draw = np.random.default_rng(seed)
    arm = None if robot is None else load_robot(robot)
    low, high = (np.full(6, -2.0), np.full(6, 2.0)) if arm is None else (arm.lower, arm.upper)
    start, end = draw.uniform(low, high, (2, count, 6))
    one = np.ones(count)
    payload = None if arm is None or arm.payload is None else draw.uniform(0.2, 1.0, count) * arm.payload
    if arm is not None and load is not None:
        payload = np.full(count, load * (arm.payload or 10.0))
    return joint_moves(arm, start, end, draw.choice([0.1, 0.5, 1.0], count), one, one, payload)


def another_arm(prior: ArmTiming, seed: int) -> ArmTiming:
    """An arm that the prior would not call odd."""
    draw = np.random.default_rng(seed)
    return replace(prior, mean=draw.multivariate_normal(prior.mean, prior.covariance))


def test_the_gradient_is_the_derivative() -> None:
    prior = another_arm(arm_prior(load_robot(ROBOT)), 3)
    ends = np.resize([1.0, 0.5, 0.0], 30)
    motions = moves_of(30, robot=ROBOT).motions
    motions = replace(motions, override=np.full(30, 0.8), ramps=ends, stop=np.floor(ends))
    found, step = gradient(prior.mean, motions), 1e-6
    for i in range(len(prior.mean)):
        bent = np.zeros_like(prior.mean)
        bent[i] = step
        high, low = (np.log(solve(prior.mean + sign * bent, motions).duration) for sign in (1, -1))
        assert np.allclose(found[:, i], (high - low) / (2 * step), atol=1e-6), prior.names[i]


def test_one_axis_takes_what_small_steps_take() -> None:
    """Integrates the trapezoid of the slowest axis; sharing and what a stop costs are taken out."""
    prior = arm_prior(load_robot(ROBOT))
    mean = prior.mean.copy()
    mean[2 * 6], mean[2 * 6 + 3] = 0.0, np.log(1e-3)
    mean[prior.names.index("short ramp")] = -20.0
    timing = prior.with_mean(mean)
    turned = np.zeros((3, 6))
    turned[:, 1] = (0.05, 0.6, 2.0)
    ones = np.ones(3)
    motions = joint_moves(None, 0 * turned, turned, np.array([1.0, 1.0, 0.4]), ones, ones).motions
    speed, ramp = timing.speeds[1], timing.times_to_speed[1]
    for way, fraction, found in zip(turned[:, 1], motions.fraction, timing.durations(motions), strict=True):
        exponent = float(mean[2 * 6 + 1])
        push, top, step = speed / ramp * fraction**exponent, speed * fraction, 1e-5
        position = velocity = clock = 0.0
        while position < way and clock < 20:
            braking = velocity**2 / (2 * push) >= way - position
            velocity = max(velocity + step * (-push if braking else push), 1e-9)
            velocity = min(velocity, top)
            position, clock = position + velocity * step, clock + step
        assert found == pytest.approx(clock, rel=5e-3, abs=1e-3)


def test_a_heavier_load_and_a_stretched_arm_turn_harder() -> None:
    robot = load_robot(ROBOT)
    stretched, folded = np.radians([[[0.0, 0, 0, 0, 0, 0]], [[0, -110, 150, 0, 0, 0]]])
    empty, full = np.array([0.5]), np.array([3.0])
    by = np.array([[0.01, 0, 0, 0, 0, 0]])
    light, heavy = (taken_of_drives(robot, stretched, stretched + by, m).load[0, 0, 0] for m in (empty, full))
    assert heavy > 5 * light
    far, near = (taken_of_drives(robot, pose, pose + by, full).arm[0, 0, 0] for pose in (stretched, folded))
    assert far > 2 * near


def pace_of_load(arm: Robot, start: Floats, turn: Floats) -> Floats:
    """(n,) [m] per unit of the move: the load's speed, from differences of the flange's poses."""
    step, reach = 1e-5, 0.1 * reach_of(arm.geometry)
    ends = (forward(arm, start + sign * step * turn) for sign in (-1, 1))
    before, after = (position + reach * rotation[:, :, 2] for position, rotation in ends)
    return np.asarray(np.linalg.norm(after - before, axis=1) / (2 * step))


@pytest.mark.parametrize("robot", [ROBOT, "yaskawa/ma2010"])
def test_what_a_load_takes_of_all_drives_together_is_what_moves_it(robot: str) -> None:
    """The drives' work along a move of all axes is the load's m v²; each axis alone says what its 1 stands for."""
    arm, draw = load_robot(robot), np.random.default_rng(5)
    start = draw.uniform(0.4 * arm.lower, 0.4 * arm.upper, (6, 6))
    full, point = np.full(6, 3.0), np.zeros(6)

    def taken(turn: Floats) -> Floats:
        return taken_of_drives(arm, start, start + turn, full, point).load[:, :, 0] * np.sign(turn)

    reference = np.zeros((6, 6))
    for axis, unit in enumerate(np.eye(6)):
        turn = np.tile(unit, (6, 1))
        reference[:, axis] = pace_of_load(arm, start, turn) ** 2 / taken(turn)[:, axis]
    turn = draw.uniform(-1, 1, (6, 6))
    work = np.sum(taken(turn) * turn * reference, axis=1)
    assert work == pytest.approx(pace_of_load(arm, start, turn) ** 2, rel=1e-5)


def test_axes_that_turn_against_each_other_are_faster_than_together() -> None:
    """The second and third axis of an arm: the forearm keeps its direction, or turns by both."""
    arm = load_robot(ROBOT)
    start = np.radians(np.tile([0.0, -90, 90, 0, 0, 0], (2, 1)))
    turn = np.radians([[0.0, 25, 25, 0, 0, 0], [0, 25, -25, 0, 0, 0]])
    one = np.ones(2)
    together, against = arm_prior(arm).durations(
        joint_moves(arm, start, start + turn, one, one, one, 3 * one).motions
    )
    assert against < 0.85 * together


def test_one_axis_says_the_speed_of_a_move_and_another_one_its_ramps() -> None:
    prior = arm_prior(load_robot(ROBOT))
    mean = prior.mean.copy()
    stop, sharing = prior.names.index("stop"), prior.names.index("sharing")
    mean[stop], mean[sharing], mean[prior.names.index("short ramp")] = 0.0, np.log(1e-3), -20.0
    mean[6 + 4] += 1.0  # the fifth axis is slow to its speed, the sixth hardly
    turned = np.zeros((3, 6))
    turned[[0, 2], 4], turned[[1, 2], 5] = 0.5, 3.0
    one = np.ones(3)
    motions = joint_moves(None, 0 * turned, turned, one, one, one).motions
    fifth, sixth, both = prior.with_mean(mean).durations(motions)
    cruise = turned[1, 5] / prior.speeds[5]
    assert both == pytest.approx(cruise + (fifth / 2) ** 2 / cruise, rel=1e-3)
    assert both > 1.05 * max(fifth, sixth)


def one_axis(timing: ArmTiming, way: Floats, fraction: Floats) -> Floats:
    """(n,) [s] of the first axis alone."""
    end = np.zeros((len(way), 6))
    end[:, 0] = way
    one = np.ones(len(way))
    return timing.durations(joint_moves(None, 0 * end, end, fraction, one, one).motions)


def test_a_ramp_that_is_short_costs_time_and_at_most_as_much_as_the_move() -> None:
    prior = arm_prior(load_robot(ROBOT))
    mean = prior.mean.copy()
    mean[prior.names.index("stop")] = 0.0
    with_it, without = mean.copy(), mean.copy()
    with_it[prior.names.index("short ramp")], without[prior.names.index("short ramp")] = np.log(0.02), -20.0
    fraction = np.array([1.0, 0.3, 0.1, 0.03])
    way = np.full(4, 2.5)
    plain = one_axis(prior.with_mean(without), way, fraction)
    more = one_axis(prior.with_mean(with_it), way, fraction) - plain
    assert np.all(np.diff(more) > 0)
    ramp = prior.times_to_speed[0] * fraction
    assert more[:2] == pytest.approx(0.02**2 / ramp[:2], rel=0.05)
    small = np.radians(np.geomspace(1e-3, 90, 60))
    slow = np.full(60, 0.01)
    times, least = (one_axis(prior.with_mean(numbers), small, slow) for numbers in (with_it, without))
    assert np.all(np.diff(times) > 0)
    assert np.all(times <= 2 * least)


def test_the_weaker_end_of_a_move_says_both_ramps() -> None:
    """The same move begun stretched, ended stretched, and stretched at both ends: one time."""
    moves = moves_of(1, 2, ROBOT).motions.take(np.zeros(3, dtype=np.intp))
    share = np.array([[1.0, 0.2], [0.2, 1.0], [1.0, 1.0]])[:, None, :]
    arm, load = (share * values[:, :, :1] for values in (moves.arm, moves.load))
    begun, ended, both = arm_prior(load_robot(ROBOT)).durations(replace(moves, arm=arm, load=load))
    assert [begun, ended] == pytest.approx([both, both], rel=1e-9)


def test_a_wrist_turns_its_load_rather_than_itself() -> None:
    """A sixth axis with a hundredth of the rated inertia has its rotor to turn and hardly anything else."""
    robot = load_robot(ROBOT)
    start, end = np.zeros((2, 6)), np.zeros((2, 6))
    end[:, 5] = 1.0
    one, light, rated = np.ones(2), 0.0002, 0.017
    moves = joint_moves(robot, start, end, one, one, one, one, np.array([light, rated])).motions
    prior = arm_prior(robot)
    quick, usual = prior.durations(moves) - prior.stop
    rotor = 1 / (1 + np.exp(-prior.mean[prior.names.index("wrist rotor share")]))
    assert (quick / usual) ** 2 < rotor + 0.2


def test_a_programmed_acceleration_does_not_know_the_load() -> None:
    """movej of a Universal Robot accelerates as it is told."""
    moves = [moves_of(20, 4, "universal-robots/ur10e", share) for share in (0.1, 1.0)]
    light, heavy = (arm_prior(load_robot("universal-robots/ur10e")).durations(m.motions) for m in moves)
    assert heavy == pytest.approx(light, rel=0.05)


@pytest.mark.parametrize(
    "robot", ["kuka/kr3-r540", "yaskawa/ma2010", "universal-robots/ur10e", "abb/irb6640-235-2.55"]
)
def test_every_number_of_a_prior_has_a_source_and_a_spread(robot: str) -> None:
    prior = arm_prior(load_robot(robot))
    assert all(p.source and p.sd > 0 for p in prior.parameters)
    assert np.all(np.linalg.eigvalsh(prior.covariance) > 0)
    assert prior.speeds == pytest.approx(load_robot(robot).speeds)


def test_an_arm_without_a_name_is_a_usual_one_and_hardly_known() -> None:
    prior = arm_prior(None, (), [f"q{i}" for i in range(1, 7)])
    assert np.all(prior.sd[:6] > 0.3)
    assert 1.0 < np.degrees(prior.speeds[0]) / 100 < 4.0


def test_times_to_speed_of_all_arms_are_not_one_constant() -> None:
    small, large = (arm_prior(load_robot(name)).times_to_speed for name in (ROBOT, "abb/irb6640-235-2.55"))
    assert np.all(large > 1.3 * small)


@pytest.mark.parametrize("seed", range(3))
def test_twenty_moves_find_another_arm_and_say_how_well(seed: int) -> None:
    robot = load_robot(ROBOT)
    prior = arm_prior(robot)
    drawn = another_arm(prior, seed).mean.copy()
    drawn[6:12] += np.log(2.0)  # and slow to its speeds
    true = prior.with_mean(drawn)
    moves = moves_of(220, seed, ROBOT)
    draw = np.random.default_rng(seed)
    measured = true.durations(moves.motions) * np.exp(draw.normal(0, 0.01, len(moves)))
    learnt = learn_arm(prior, moves.take(np.arange(20)), measured[:20], np.zeros(20, dtype=np.int64))
    rest = moves.take(np.arange(20, 220))
    before, after = prior.durations(rest.motions), learnt.predict(rest)
    error = np.abs(after.duration / measured[20:] - 1)
    assert np.median(error) < 0.03
    assert np.mean(error) < 0.8 * np.mean(np.abs(before / measured[20:] - 1))
    assert np.mean((after.low <= measured[20:]) & (measured[20:] <= after.high)) >= 0.9


def test_what_moves_do_not_tell_keeps_its_prior_and_is_named() -> None:
    prior = arm_prior(load_robot(ROBOT))
    moves = moves_of(30, 1, ROBOT)
    wrist, motions = np.array([0, 0, 0, 1, 1, 1], dtype=bool), moves.motions
    end = np.where(wrist, moves.start, moves.end)
    shares = (motions.fraction, motions.acceleration, motions.override)
    moves = joint_moves(load_robot(ROBOT), moves.start, end, *shares)
    learnt = learn_arm(prior, moves, prior.durations(moves.motions) * 1.1, np.zeros(30, dtype=np.int64))
    assert {"time to speed A5", "override exponent"} <= set(learnt.untold)
    assert "speed A1" not in learnt.untold
    place = prior.names.index("time to speed A5")
    assert learnt.timing.mean[place] == pytest.approx(prior.mean[place], abs=0.15)


def test_pauses_hardly_bend_the_law() -> None:
    prior = arm_prior(load_robot(ROBOT))
    true, moves = another_arm(prior, 5), moves_of(200, 5, ROBOT)
    measured = true.durations(moves.motions)
    measured[::10] *= 2.5
    fitted = fit_arm(prior, moves.motions, measured)
    clean = np.ones(200, dtype=bool)
    clean[::10] = False
    assert np.median(np.abs(fitted.residual[clean])) < 0.02


def test_an_arm_at_half_of_its_rated_speeds_is_learnt() -> None:
    """One axis at several speeds: no law with the rated speed fits, and the moves beat the data sheet."""
    prior = arm_prior(load_robot(ROBOT))
    true = prior.mean.copy()
    true[:6] += np.log(0.5)
    draw, one = np.random.default_rng(8), np.ones(30)
    start, end = np.zeros((2, 30, 6))
    start[:, 0], end[:, 0] = draw.uniform(-1.5, 1.5, (2, 30))
    share = draw.choice([0.1, 0.5, 1.0], 30)
    moves = joint_moves(load_robot(ROBOT), start, end, share, one, one)
    measured = prior.with_mean(true).durations(moves.motions)
    seen, unseen = np.arange(20), np.arange(20, 30)
    learnt = learn_arm(prior, moves.take(seen), measured[seen], np.zeros(20, dtype=np.int64))
    told = learnt.predict(moves.take(unseen))
    assert told.duration == pytest.approx(measured[unseen], rel=0.03)
    assert np.all((told.low <= measured[unseen]) & (measured[unseen] <= told.high))


def test_two_pauses_in_ten_moves_do_not_make_an_arm_that_no_arm_is() -> None:
    """Spreads over all arms hold: a number told of an arm may be wrong, a usual one is only unlikely."""
    prior = arm_prior(None, (), [f"q{i}" for i in range(1, 7)])
    errors = []
    for seed in (5, 13):
        moves = moves_of(100, seed)
        true = another_arm(prior, seed).durations(moves.motions)
        seen, rest, measured = np.arange(10), np.arange(10, 100), true[:10].copy()
        measured[[2, 7]] *= 4.0
        learnt = fit_arm(prior, moves.motions.take(seen), measured).timing
        errors.append(np.mean(np.abs(learnt.durations(moves.motions.take(rest)) / true[rest] - 1)))
    assert np.mean(errors) < 0.2  # 0.24 where every prior number could be left


def test_moves_that_mislead_are_not_learnt_and_that_is_told(tmp_path: Path) -> None:
    """Half of a recording ran at another override than the other half, and no column says so."""
    robot = load_robot(ROBOT)
    prior, moves, one = arm_prior(robot), moves_of(24, 3, ROBOT), np.ones(24)
    moves = joint_moves(robot, moves.start, moves.end, moves.motions.fraction, one, one)
    measured = prior.durations(moves.motions) * np.repeat([1.5, 1.0], 12)
    recording = read_recording(write_recording(tmp_path / "two", moves, measured, ROBOT))
    signature, told = calibrate(recording)
    (note,) = (d for d in told if d.code in ("H052", "H055"))
    assert note.code == "H055"
    assert "with nothing learnt" in note.message
    rows, _ = predict_recording(signature, recording)
    assert rows.predicted == pytest.approx(prior.durations(moves.motions), rel=1e-3)
    assert np.mean((rows.low <= measured) & (measured <= rows.high)) >= 0.95


def test_what_is_learnt_is_compared_with_nothing_learnt(tmp_path: Path) -> None:
    folder, _ = joints_alone(tmp_path, ROBOT)
    _, told = calibrate(read_recording(folder))
    (note,) = (d for d in told if d.code == "H052")
    assert "% with nothing learnt" in note.message


def test_a_region_in_which_moves_are_slow_is_found_and_others_are_not() -> None:
    draw = np.random.default_rng(2)
    features, law = draw.normal(size=(100, 12)), draw.normal(size=100)
    measured = law + draw.normal(0, 0.03, 100)
    assert find_regions(features, law, measured) == ()
    slow = features[:, 7] > 1.2
    measured[slow] = 1.3 + draw.normal(0, 0.05, int(slow.sum()))
    (region,) = find_regions(features, law, measured)
    assert (region.feature, region.above, region.share) == (7, True, 0.0)
    assert region.bound == pytest.approx(1.2, abs=0.25)
    assert np.mean(np.abs(corrected([region], features, law) - measured)) < 0.06


def test_trees_learn_a_step_and_are_the_same_again() -> None:
    draw = np.random.default_rng(4)
    features = draw.uniform(-1, 1, (600, 5))
    target = np.where(features[:, 2] > 0.3, 0.2, -0.1) + draw.normal(0, 0.02, 600)
    trees = fit_trees(features[:400], target[:400], 60)
    left = target[400:] - trees.predict(features[400:])
    assert np.median(np.abs(left)) < 0.03 < np.median(np.abs(target[400:] - np.median(target[:400])))
    again = BoostedTrees.from_json(trees.to_json())
    assert again.predict(features) == pytest.approx(trees.predict(features), abs=1e-6)
    assert np.array_equal(fit_trees(features[:400], target[:400], 60).value, trees.value)


# --- through the files ------------------------------------------------------------------------------------------------


def write_recording(folder: Path, moves: JointMoves, measured: Floats, robot: str | None) -> Path:
    folder.mkdir(exist_ok=True)
    axes = range(moves.start.shape[1])
    names = [f"q{i + 1}_{end}_deg" for end in ("start", "end") for i in axes]
    with (folder / "moves.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(["move", "type", "duration_s", "speed_pct", *names])
        joints = np.degrees(np.concatenate([moves.start, moves.end], axis=1))
        rows = zip(measured.tolist(), (moves.motions.fraction * 100).tolist(), joints.tolist(), strict=True)
        for i, (seconds, speed, angles) in enumerate(rows):
            table.writerow([i + 1, "joint", "" if np.isnan(seconds) else f"{seconds:.4f}", speed, *angles])
    words = "" if robot is None else f'robot = "{robot}"\n'
    (folder / "recording.toml").write_text(words, encoding="utf-8")
    return folder


def joints_alone(tmp_path: Path, robot: str | None = None) -> tuple[Path, Floats]:
    """A recording of joint moves alone, half of them to predict, and what all of them take."""
    arm = None if robot is None else load_robot(robot)
    prior = arm_prior(arm, (), [f"q{i}" for i in range(1, 7)])
    moves = moves_of(60, 7, robot)
    if robot is not None:
        assert arm is not None
        one = np.ones(60)
        moves = joint_moves(arm, moves.start, moves.end, moves.motions.fraction, one, one)
    true = another_arm(prior, 11).durations(moves.motions)
    measured = true.copy()
    measured[1::2] = np.nan
    return write_recording(tmp_path / "joints", moves, measured, robot), true


@pytest.mark.parametrize("robot", [None, ROBOT])
def test_a_recording_of_joint_moves_alone_is_enough(tmp_path: Path, robot: str | None) -> None:
    folder, true = joints_alone(tmp_path, robot)
    recording = read_recording(folder)
    signature, told = calibrate(recording)
    assert "H052" in {d.code for d in told}
    write_signature(signature, tmp_path / "signature.json")
    again = read_signature(tmp_path / "signature.json")
    rows, _ = predict_recording(again, recording)
    assert rows.predicted == pytest.approx(predict_recording(signature, recording)[0].predicted, rel=1e-6)
    unseen = np.arange(60) % 2 == 1
    assert np.median(np.abs(rows.predicted / true - 1)[unseen]) < 0.06
    assert np.mean(((rows.low <= true) & (true <= rows.high))[unseen]) >= 0.85
    assert np.all(rows.low < rows.predicted)


def test_rows_that_contradict_each_other_are_told(tmp_path: Path) -> None:
    moves = moves_of(30, 3, ROBOT)
    twice = moves.take(np.concatenate([np.arange(30), np.arange(30)]))
    measured = arm_prior(load_robot(ROBOT)).durations(twice.motions)
    measured[37] *= 1.8
    _, told = calibrate(read_recording(write_recording(tmp_path / "twice", twice, measured, ROBOT)))
    (found,) = [d for d in told if d.code == "H050"]
    assert "8 (" in found.message
    assert "38 (" in found.message
    assert found.message.startswith("1 moves")


def test_too_few_moves_are_counted_by_kind(tmp_path: Path) -> None:
    moves = moves_of(3, 3, ROBOT)
    recording = read_recording(write_recording(tmp_path / "few", moves, np.ones(3), ROBOT))
    with pytest.raises(olp.OlpError) as caught:
        calibrate(recording)
    assert caught.value.diagnostics[0].code == "H003"
    assert "3 joint moves" in caught.value.diagnostics[0].message


def test_lines_told_by_joints_alone_are_learnt_with_the_robot_and_say_that_they_need_it(
    tmp_path: Path,
) -> None:
    robot = load_robot(ROBOT)
    middle = np.array([0.0, -1.5, 1.6, 0.0, 0.6, 0.0])
    ends = middle + np.outer(np.linspace(-0.3, 0.3, 9), [1.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    way = np.linalg.norm(np.diff(forward(robot, ends)[0], axis=0), axis=1)
    axes = [f"q{i + 1}_{end}_deg" for end in ("start", "end") for i in range(6)]
    lines = [",".join(["move", "type", "duration_s", "speed_mm_s", *axes])]
    for i, (start, end, length) in enumerate(zip(ends[:-1], ends[1:], way, strict=True)):
        joints = np.degrees(np.concatenate([start, end])).round(6).tolist()
        lines.append(",".join(map(str, [i + 1, "linear", round(length / 0.1 + 0.05, 5), 100, *joints])))
    (tmp_path / "moves.csv").write_text("\n".join([*lines, ""]), encoding="utf-8")
    with pytest.raises(olp.OlpError) as caught:
        calibrate(read_recording(tmp_path))
    assert "8 lines are told by joints alone" in (caught.value.diagnostics[0].help or "")
    (tmp_path / "recording.toml").write_text(f'robot = "{ROBOT}"\n', encoding="utf-8")
    recording = read_recording(tmp_path)
    signature, told = calibrate(recording)
    assert predict_recording(signature, recording)[0].predicted == pytest.approx(
        recording.moves.duration, rel=0.01
    )
    assert any(d.code == "H054" and "8 lines" in d.message for d in told)


def test_arcs_with_their_ends_at_the_flange_and_their_middle_at_the_tool_are_not_learnt(
    tmp_path: Path,
) -> None:
    axes = [f"q{i + 1}_{end}_deg" for end in ("start", "end") for i in range(6)]
    lines = [
        ",".join(["move", "type", "duration_s", "speed_mm_s", "x_via_mm", "y_via_mm", "z_via_mm", *axes])
    ]
    for i in range(6):
        joints = [-20 + i, -90, 90, 0, 40, 0, 20 + i, -90, 90, 0, 40, 0]
        lines.append(",".join(map(str, [i + 1, "circular", 20 + i / 100, 100, 450, 5 * i, 300, *joints])))
    (tmp_path / "moves.csv").write_text("\n".join([*lines, ""]), encoding="utf-8")
    (tmp_path / "recording.toml").write_text(f'robot = "{ROBOT}"\n', encoding="utf-8")
    with pytest.raises(olp.OlpError) as caught:
        calibrate(read_recording(tmp_path))
    assert [d.code for d in caught.value.diagnostics] == ["H003", "H054"]
    assert "6 arcs are left out" in caught.value.diagnostics[1].message
    (tmp_path / "recording.toml").write_text(
        f'robot = "{ROBOT}"\ntool = [0, 0, 80, 0, 0, 0]\n', encoding="utf-8"
    )
    assert not any(d.code == "H054" for d in calibrate(read_recording(tmp_path))[1])


def test_slow_moves_without_a_speed_are_told(tmp_path: Path) -> None:
    robot, moves, one = load_robot(ROBOT), moves_of(12, 4, ROBOT), np.ones(12)
    moves = joint_moves(robot, moves.start, moves.end, one, one, one)
    measured = arm_prior(robot).durations(moves.motions) * np.repeat([1.0, 4.0], [9, 3])
    folder = write_recording(tmp_path / "slow", moves, measured, ROBOT)
    text = (folder / "moves.csv").read_text(encoding="utf-8")
    assert not any(d.code == "H056" for d in calibrate(read_recording(folder))[1])
    (folder / "moves.csv").write_text(text.replace(",100.0,", ",,"), encoding="utf-8")
    (note,) = (d for d in calibrate(read_recording(folder))[1] if d.code == "H056")
    assert "3 joint moves without speed_pct" in note.message


def test_moves_faster_than_the_axes_are_told_and_not_learnt(tmp_path: Path) -> None:
    moves = moves_of(30, 3, ROBOT)
    measured = arm_prior(load_robot(ROBOT)).durations(moves.motions)
    measured[4] *= 0.3
    signature, told = calibrate(read_recording(write_recording(tmp_path / "fast", moves, measured, ROBOT)))
    (found,) = [d for d in told if d.code == "H051"]
    assert found.message.endswith("moves 5")
    assert signature.arm is not None
    assert signature.arm.rows == 29


def test_the_program_override_of_a_row_counts(tmp_path: Path) -> None:
    moves = moves_of(12, 3, ROBOT)
    folder = write_recording(tmp_path / "slow", moves, np.full(12, np.nan), ROBOT)
    table = (folder / "moves.csv").read_text(encoding="utf-8").splitlines()
    written = [table[0] + ",override_pct", *(f"{line},50" for line in table[1:])]
    (folder / "moves.csv").write_text("\n".join(written) + "\n", encoding="utf-8")
    recording = read_recording(folder)
    found, _ = recorded_joint_moves(recording.moves, recording.robot, None, 6)
    assert found.motions.override == pytest.approx(np.full(12, 0.5))


def test_no_load_that_an_arm_is_told_to_carry_is_beyond_its_rated_one(tmp_path: Path) -> None:
    """A controller or a simulation that is told more than usual says what the rated load is; programs know it."""
    folder, _ = joints_alone(tmp_path, ROBOT)
    table = (folder / "moves.csv").read_text(encoding="utf-8").splitlines()
    arm = load_robot(ROBOT)
    usual = rated_inertia(arm)
    for simulated, unmeasured, rated in ((2.5, 9.0, 2.5 * usual), (0.5, 9.0, None)):
        each = (f"{usual * 0.1},{usual * (unmeasured if i % 2 else simulated)}" for i in range(60))
        head = table[0] + ",payload_inertia_kg_m2,sim_payload_inertia_kg_m2"
        rows = [head, *(f"{line},{more}" for line, more in zip(table[1:], each, strict=True))]
        (folder / "moves.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
        recording = read_recording(folder)
        signature, told = calibrate(recording)
        assert signature.arm is not None
        assert signature.arm.timing.load_inertia == (rated and pytest.approx(rated))
        assert any("rated load" in found.message for found in told) == (rated is not None)
        write_signature(signature, tmp_path / "signature.json")
        again = read_signature(tmp_path / "signature.json")
        assert again.version == (7 if rated is None else 8)
        moves, _ = recorded_joint_moves(recording.moves, arm, None, 6, rated)
        expected = signature.arm.predict(moves).duration
        assert predict_recording(again, recording)[0].predicted == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("written", "instead", "says"),
    [
        ('"quantile_95"', '"quantile"', "a field is missing"),
        ('"version": 7', '"version": 5', "law of joint moves"),
    ],
)
def test_a_file_with_a_spoilt_or_former_law_is_refused(
    tmp_path: Path, written: str, instead: str, says: str
) -> None:
    folder, _ = joints_alone(tmp_path)
    signature, _ = calibrate(read_recording(folder))
    path = tmp_path / "signature.json"
    write_signature(signature, path)
    text = path.read_text(encoding="utf-8")
    assert written in text
    path.write_text(text.replace(written, instead), encoding="utf-8")
    with pytest.raises(olp.OlpError) as caught:
        read_signature(path)
    assert caught.value.diagnostics[0].code == "H008"
    assert says in caught.value.diagnostics[0].message


def test_a_program_takes_what_the_learnt_law_says(tmp_path: Path) -> None:
    folder, _ = joints_alone(tmp_path, ROBOT)
    signature, _ = calibrate(read_recording(folder))
    assert signature.arm is not None
    program = tmp_path / "moves.src"
    targets = ("0,-90,90,0,0,0", "60,-60,100,20,30,10", "-40,-100,80,0,-30,90")
    poses = [", ".join(f"A{i + 1} {v}" for i, v in enumerate(t.split(","))) for t in targets]
    lines = ["BAS (#VEL_PTP, 100)", *(f"PTP {{{pose}}}" for pose in poses)]
    program.write_text("\n".join(["DEF moves()", *lines, "END"]) + "\n", encoding="utf-8")
    timing = olp.read(program).plan(robot=ROBOT)
    frame = timing.time(signature=signature)
    joints = np.radians([[float(v) for v in t.split(",")] for t in targets])
    one = np.ones(2)
    last = frame[frame["kind"] == "joint"].iloc[-2:]
    share = last["speed_pct"].to_numpy() / 100
    expected = signature.arm.predict(joint_moves(load_robot(ROBOT), joints[:-1], joints[1:], share, one, one))
    found = last["duration_s"].to_numpy()
    assert found == pytest.approx(expected.duration, rel=1e-6)


def test_the_text_shows_the_interval_of_the_total_without_a_signature(
    capsys: pytest.CaptureFixture[str],
) -> None:
    job = "samples/inform/generations/dx200.jbi"
    assert main(["time", job]) == 0
    timing = plan_and_time(job, Job())
    assert timing.total_ends == timing.expected is not None
    low, high = timing.total_ends
    assert low < timing.total_s < high
    assert f"(95 %: {low:.3f} to {high:.3f})" in capsys.readouterr().out


def test_half_of_the_repeats_may_contradict_each_other() -> None:
    label, measured = np.repeat(np.arange(4), 2), np.array([0.8, 0.81, 1.1, 1.1, 0.5, 1.4, 0.9, 2.3])
    assert [rows.tolist() for rows in contradicting(label, measured, 0.001)] == [[4, 5], [6, 7]]


def test_without_a_robot_no_axis_is_faster_than_those_of_any_arm() -> None:
    moves = moves_of(3)
    least = moves.motions.turned.max(axis=1) / (moves.motions.fraction * fastest_speed())
    for share, fast in ((0.5, True), (1.2, False)):
        assert (faster_than_rated(None, moves, share * least, 0.0) == fast).all()


# --- lines ----------------------------------------------------------------------------------------------------------


def test_lines_accelerate_as_the_arm_or_its_controller_publishes_it() -> None:
    known = line_acceleration(load_robot("yaskawa/ma2010"))
    assert known.published
    assert known.value == pytest.approx(3.05)
    assert line_acceleration(load_robot(ROBOT)).value == 2.3
    assert line_acceleration(load_robot("universal-robots/ur5e")).value == 1.2
    assert line_acceleration(None, "PolyScope on e-Series").value == 1.2


def test_lines_that_nobody_published_are_told_by_arms_of_the_maker_and_by_all_others_less() -> None:
    irb, fanuc, none = (
        line_acceleration(robot)
        for robot in (load_robot("abb/irb120-3-0.58"), load_robot("fanuc/lr-mate-200id"), None)
    )
    assert not irb.published
    assert not fanuc.published
    assert irb.value > 2 * fanuc.value
    assert irb.doubt < 0.5 * fanuc.doubt
    assert fanuc[:2] == pytest.approx(none[:2])


def test_a_row_says_nothing_of_its_own_arm() -> None:
    arms = known_lines()
    own = next(arm for arm in arms if arm.robot.startswith("abb/irb6640"))
    told = line_acceleration(load_robot(own.robot))
    others = tuple(arm for arm in arms if arm is not own)
    assert told[:2] == pytest.approx(
        (np.exp(line_class("ABB", ["IRC5"], others)[0]), line_class("ABB", ["IRC5"], others)[1])
    )


def test_each_arm_is_told_by_the_others_within_what_is_stated_and_better_than_by_one_value_for_all() -> None:
    arms, away = known_lines(), {}
    for levels in ((True, True), (False, False)):
        told = [line_class(a.maker, [a.controller], [b for b in arms if b is not a], levels) for a in arms]
        away[levels] = np.log([arm.acceleration for arm in arms]) - [mean for mean, _ in told]
        assert np.all(np.abs(away[levels]) <= 1.96 * np.array([doubt for _, doubt in told]))
    assert np.mean(away[True, True] ** 2) < np.mean(away[False, False] ** 2)


def test_the_class_of_an_arm_is_what_samples_of_the_same_spreads_say() -> None:
    """Against a Gibbs-like check by simulation: arms drawn with known spreads lie where the law says they do."""
    draw = np.random.default_rng(4)
    away = []
    for _ in range(60):
        makers = {name: draw.normal(0, 0.8) for name in "ABCDE"}
        arms = [
            known_lines()[0]._replace(
                robot=f"{name}/{i}",
                maker=name,
                controller=f"{name}1",
                acceleration=float(np.exp(own + draw.normal(0, 0.3))),
            )
            for name, own in makers.items()
            for i in range(3)
        ]
        asked, rest = arms[0], arms[1:]
        mean, doubt = line_class(asked.maker, [asked.controller], rest)
        away.append((np.log(asked.acceleration) - mean) / doubt)
    assert 0.75 < np.sqrt(np.mean(np.square(away))) < 1.15


def test_a_doubted_ramp_reaches_from_the_profile_of_one_acceleration_to_that_of_another() -> None:
    def takes(way: float, speed: float, push: float) -> float:
        return way / speed + speed / push if way * push >= speed**2 else 2.0 * np.sqrt(way / push)

    wide = np.exp(1.96 * 0.9)
    for way, speed, push in ((1.0, 0.5, 3.0), (0.1, 1.0, 3.0), (0.02, 1.0, 2.0)):
        usual, cruise = takes(way, speed, push), way / speed
        below, above = ramp_doubt(*(np.array([v]) for v in (usual - cruise, cruise, 0.9)))
        assert usual - below[0] == pytest.approx(takes(way, speed, push * wide))
        assert usual + above[0] == pytest.approx(takes(way, speed, push / wide))


@pytest.mark.parametrize(
    ("programmed", "robot", "published"),
    [
        ("$ACC.CP=2.0", ROBOT, True),
        ("$ACC.CP=2.0", "fanuc/lr-mate-200id", True),
        ("", "fanuc/lr-mate-200id", False),
    ],
)
def test_the_interval_says_what_an_unpublished_acceleration_of_lines_makes(
    tmp_path: Path, programmed: str, robot: str, published: bool
) -> None:
    path = tmp_path / "lines.src"
    lines = (
        "DEF lines()",
        "$VEL.CP=0.5",
        programmed,
        "LIN {X 400,Y 0,Z 500}",
        "LIN {X 400,Y 200,Z 500}",
        "END",
    )
    path.write_text("\n".join((*lines, "")), encoding="utf-8")
    timing = plan_and_time(path, Job(robot=robot))
    said = " ".join(a.says for a in timing.assumptions)
    assert ("is not published for fanuc/lr-mate-200id" in said) is not published
    assert ("twenty recorded moves would determine it" in said) is not published
    assert timing.expected is not None
    low, high = timing.expected
    assert low < timing.total_s < high
    assert (high < 1.5 * timing.total_s) is published


def test_the_interval_holds_what_a_stop_may_cost_where_nobody_knows_it(tmp_path: Path) -> None:
    path = tmp_path / "lines.src"
    lines = (
        "DEF lines()",
        "$VEL.CP=0.5",
        "$ACC.CP=2.0",
        "LIN {X 400,Y 0,Z 500}",
        "LIN {X 400,Y 200,Z 500}",
        "END",
    )
    path.write_text("\n".join((*lines, "")), encoding="utf-8")
    unknown = plan_and_time(path, Job(robot="fanuc/lr-mate-200id"))
    (tmp_path / "olp.toml").write_text("[motion]\nsettling_s = 0\n", encoding="utf-8")
    known = plan_and_time(path, Job(robot="fanuc/lr-mate-200id"))
    assert unknown.total_s == known.total_s
    assert unknown.expected is not None
    assert known.expected is not None
    assert unknown.expected[0] == known.expected[0]
    assert unknown.expected[1] - known.expected[1] == pytest.approx(2 * (0.05 + 1.96 * 0.05))


@pytest.mark.slow
def test_joint_moves_that_all_run_into_each_other_are_learnt(tmp_path: Path) -> None:
    """The times are those of another arm, by its signature: corners as olp's law has them."""
    draw, robot = np.random.default_rng(5), load_robot(ROBOT)
    points = draw.uniform(-1.2, 1.2, (81, 6)) + np.array([0, -1.4, 1.5, 0, 0.4, 0])
    one = np.ones(80)
    moves = joint_moves(robot, points[:-1], points[1:], draw.choice([0.1, 0.2, 0.4], 80), one, one)
    folder, _ = joints_alone(tmp_path, ROBOT)
    signature, _ = calibrate(read_recording(folder))
    assert signature.arm is not None
    slow = arm_prior(robot)
    slow = slow.with_mean(slow.mean + np.repeat([-0.05, 0.0], [6, len(slow.mean) - 6]))
    other = replace(signature, arm=replace(signature.arm, timing=slow, regions=(), trees=None), parts={})

    def rolling(durations: Floats) -> Path:
        written = write_recording(tmp_path / "rolling", moves, durations, ROBOT)
        table = (written / "moves.csv").read_text(encoding="utf-8").splitlines()
        cells = ["blend_mm", *["20"] * 79, "0"]
        text = "\n".join(f"{line},{cell}" for line, cell in zip(table, cells, strict=True))
        (written / "moves.csv").write_text(text + "\n", encoding="utf-8")
        return written

    true = predict_recording(other, read_recording(rolling(np.full(80, np.nan))))[0].predicted
    learnt, told = calibrate(read_recording(rolling(np.where(np.arange(80) % 2, np.nan, true))))
    assert learnt.arm is not None
    assert any("of them run into others" in d.message for d in told if d.code == "H052")
    speeds = np.log(learnt.arm.timing.speeds / slow.speeds)
    assert np.abs(np.median(speeds)) < 0.02  # before: 0.05
    rows, _ = predict_recording(learnt, read_recording(rolling(true)))
    unseen = (np.arange(80) % 2 == 1) & (true > 0.1)
    assert np.median(np.abs(rows.predicted[unseen] / true[unseen] - 1)) < 0.02


def test_a_search_for_what_a_stop_costs_says_nothing_of_numpy(
    tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    """Lines at several speeds that accelerate at once: the search for 1/a looks below zero."""
    head = "move,duration_s,speed_mm_s,x_start_mm,y_start_mm,z_start_mm,x_end_mm,y_end_mm,z_end_mm\n"
    ways = [(200, 100, 2.0), (300, 400, 0.75), (150, 200, 0.751), (400, 100, 4.0), (250, 400, 0.624)]
    lines = [f"{i},{t},{v},500,0,500,{500 + way},0,500\n" for i, (way, v, t) in enumerate(ways, 1)]
    (tmp_path / "moves.csv").write_text(head + "".join(lines), encoding="utf-8")
    calibrate(read_recording(tmp_path))
    assert not recwarn.list
