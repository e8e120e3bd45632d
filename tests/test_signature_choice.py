"""Which method is taken, how sure that is, what is shared by all errors, and the posture that the axes are read in."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from olp.identification.recording import read_recording
from olp.identification.signature import moves_of_recording
from olp.identification.signature.axis_paths import axis_paths
from olp.identification.signature.estimator import learnt, load_estimator
from olp.identification.signature.folds import HeldOut, Trial, by_directions, merit_doubt
from olp.identification.signature.learn import chosen, fit_moves
from olp.identification.signature.moveset import joint_ends
from olp.robots.kinematics import configuration_of, inverse
from olp.robots.robot import load_robot

MOVES = moves_of_recording(read_recording(Path(__file__).parent.parent / "samples" / "up20"))[0]
ROBOT = load_robot("yaskawa/up20")
GROUPS = np.arange(len(MOVES)) % 8


def trial(percent):
    """Held-out predictions whose times are off by so many percent, one number or one per move."""
    late = MOVES.duration * (1 + np.asarray(percent) / 100.0)
    slowness = (late - MOVES.length / MOVES.speed) / MOVES.speed
    return Trial(HeldOut(slowness, GROUPS), None, None)


def test_a_preferred_method_gives_way_only_to_one_that_is_surely_better():
    rng = np.random.default_rng(0)
    error = rng.uniform(0.5, 1.5, len(MOVES))
    by_luck = (
        np.where(GROUPS == 0, 0.05, 1.05) * error
    )  # far better in one group of eight, worse in all others
    surely = 0.8 * error
    assert chosen({"terms_and_places": trial(error), "factors": trial(by_luck)}, MOVES) == "terms_and_places"
    assert chosen({"terms_and_places": trial(error), "factors": trial(surely)}, MOVES) == "factors"
    assert chosen({"constant": trial(error), "factors": trial(by_luck)}, MOVES) == "factors"


def test_the_doubt_of_a_comparison_is_its_scatter_between_repeated_recordings():
    rng = np.random.default_rng(1)
    ratios, doubts = [], []
    for _ in range(200):
        group = rng.normal(1.0, 0.2, 8)[GROUPS]
        one, other = trial(np.ones(len(MOVES))), trial(group)
        doubts.append(merit_doubt(one, other, MOVES))
        ratios.append(np.log(np.mean(np.abs(group))))
    assert np.sqrt(np.mean(np.square(doubts))) == pytest.approx(np.std(ratios), rel=0.2)


def test_two_directions_do_not_judge_what_directions_cost():
    level = np.abs(MOVES.direction[:, 2]) < 0.1
    assert by_directions(MOVES) is not None
    assert by_directions(MOVES.take(level)) is None


def test_errors_of_a_total_do_not_cancel_below_what_few_learnt_moves_leave():
    few = fit_moves(MOVES.take(np.arange(len(MOVES)) % 5 == 0), ROBOT, "gaussian_process").errors.near
    assert few.shared >= 0.999 * few.own / np.sqrt(30)


@pytest.mark.slow
def test_few_moves_are_learnt_from_by_more_methods_than_many():
    names = {"axis_turns", "averaged_process", "axis_terms_gp"}
    few = learnt("terms_and_places", MOVES.take(np.arange(len(MOVES)) % 5 == 0), ROBOT)
    many = learnt("terms_and_places", MOVES, ROBOT)
    assert {key.partition(": ")[0] for key in few} >= names
    assert {key.partition(": ")[0] for key in many} & names == {"axis_turns"}


def test_moves_whose_axes_are_not_known_are_told_by_their_place():
    parameters = learnt("terms_and_places", MOVES, ROBOT)
    blind = replace(MOVES, rotation=np.full_like(MOVES.rotation, np.nan))
    said = load_estimator("terms_and_places").estimate(parameters, blind, ROBOT)
    place = load_estimator("gaussian_process").estimate(
        learnt("gaussian_process", MOVES, ROBOT), MOVES, ROBOT
    )
    assert said.slowness == pytest.approx(place.slowness)
    alone = load_estimator("axis_turns").estimate(learnt("axis_turns", MOVES, ROBOT), blind, ROBOT)
    assert not alone.inside.any()
    assert np.isfinite(alone.slowness).all()


def test_an_axis_turn_that_costs_time_costs_it_at_other_places_too():
    turned = np.degrees(np.abs(axis_paths(MOVES, ROBOT).end - axis_paths(MOVES, ROBOT).start)[:, 2])
    made = replace(MOVES, duration=MOVES.length / MOVES.speed + 0.3 + 0.004 * turned)
    out = MOVES.start_labels == 2
    errors = []
    for name in ("axis_turns", "gaussian_process"):
        estimator = load_estimator(name)
        said = estimator.estimate(estimator.fit(made.take(~out), ROBOT), made.take(out), ROBOT).slowness
        truth = (made.duration - made.length / made.speed)[out] / made.speed[out]
        errors.append(float(np.abs(said - truth).mean()))
    assert errors[0] < 0.3 * errors[1]


@pytest.mark.parametrize("text", ["0,1,0,0,0,0", "010000", "1 1 0 0 0 0 0 0"])
def test_a_lower_elbow_is_read_from_the_flags_of_the_configuration(text):
    low = axis_paths(replace(MOVES, configuration=(text,) * len(MOVES)), ROBOT)
    assert (configuration_of(ROBOT, axis_paths(MOVES, ROBOT).start)[:, 1] == 0).all()
    assert (configuration_of(ROBOT, low.start)[:, :2] == (0, 1)).all()


def test_joint_moves_between_poses_take_the_flags_too():
    recording = read_recording(Path(__file__).parent.parent / "samples" / "up20")
    rows = recording.moves
    low = replace(rows, texts={**rows.texts, "configuration": ("0,1,0,0,0,0",) * len(rows)})
    usual, elbow_down = (joint_ends(m, recording.robot, recording.tool) for m in (rows, low))
    for above, below in zip(usual, elbow_down, strict=True):
        assert (configuration_of(ROBOT, above)[:, 1] == 0).all()
        assert (configuration_of(ROBOT, below)[:, :2] == (0, 1)).all()


def test_another_word_for_the_configuration_leaves_the_usual_posture():
    named = replace(MOVES, configuration=("elbow up",) * len(MOVES))
    assert axis_paths(named, ROBOT).start == pytest.approx(axis_paths(MOVES, ROBOT).start)


def test_a_flipped_wrist_costs_what_the_same_poses_cost_without():
    ends = [inverse(ROBOT, p, MOVES.rotation, (1, 0, 0, 0, 0, 0))[0] for p in (MOVES.start, MOVES.end)]
    assert (configuration_of(ROBOT, ends[0])[:, 0] == 1).all()
    plain = axis_paths(MOVES, ROBOT)
    flipped = axis_paths(replace(MOVES, joints=np.stack(ends, axis=1)), ROBOT)
    assert flipped.start_rate == pytest.approx(plain.start_rate, abs=1e-6)
    assert flipped.end_rate == pytest.approx(plain.end_rate, abs=1e-6)
    turns = (flipped.end - flipped.start) - (plain.end - plain.start)
    assert np.abs(np.sin(turns / 2)).max() < 1e-6


def test_joint_points_of_a_recording_are_the_axes_themselves():
    flags = (0, 1, 0, 0, 0, 0)
    ends = [inverse(ROBOT, place, MOVES.rotation, flags)[0] for place in (MOVES.start, MOVES.end)]
    told = np.stack(ends, axis=1)
    told[5, 1] = np.nan
    paths = axis_paths(replace(MOVES, joints=told), ROBOT)
    others = np.arange(len(MOVES)) != 5
    assert paths.start[others] == pytest.approx(ends[0][others])
    assert paths.end[others] == pytest.approx(ends[1][others])
    assert paths.start[5] == pytest.approx(axis_paths(MOVES, ROBOT).start[5])


def test_joint_points_in_a_file_reach_the_moves(tmp_path):
    angles = ",".join(f"{v:.6f}" for v in np.degrees(axis_paths(MOVES, ROBOT).start[0]))
    later = ",".join(f"{v:.6f}" for v in np.degrees(axis_paths(MOVES, ROBOT).end[0]))
    heads = [f"q{i}_{end}_deg" for end in ("start", "end") for i in range(1, 7)]
    start, end = (",".join(f"{1000 * v:.3f}" for v in p) for p in (MOVES.start[0], MOVES.end[0]))
    columns = "move,type,x_start_mm,y_start_mm,z_start_mm,x_end_mm,y_end_mm,z_end_mm,speed_mm_s,duration_s,pl"
    row = f"1,linear,{start},{end},300,2.64,0,{angles},{later}"
    (tmp_path / "moves.csv").write_text(f"{columns},{','.join(heads)}\n{row}\n")
    (tmp_path / "recording.toml").write_text('robot = "yaskawa/up20"\n')
    found = moves_of_recording(read_recording(tmp_path))[0]
    assert found.joints is not None
    assert found.joints[0, 0] == pytest.approx(axis_paths(MOVES, ROBOT).start[0], abs=1e-6)
