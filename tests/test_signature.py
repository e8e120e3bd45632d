"""Signatures: learnt from moves, kept in a file, predicting with an interval."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.identification.recording import read_recording
from olp.identification.signature import (
    MoveSet,
    calibrate,
    moves_of_recording,
    predict,
    read_signature,
    write_signature,
)
from olp.identification.signature.domain import domain_of
from olp.identification.signature.errors import spread_of
from olp.identification.signature.estimator import duration_of, estimator_names, learnt, load_estimator
from olp.identification.signature.estimators.axis_terms import all_subsets, grouped_errors
from olp.identification.signature.file import from_json, to_json, to_text
from olp.identification.signature.folds import merit
from olp.identification.signature.gp import Belief, KernelPart, _cost, _squares, answer, learn, minimise
from olp.identification.signature.learn import fit_moves
from olp.robots.robot import load_robot

UP20 = Path(__file__).parent.parent / "samples" / "up20"
HEADER = "move,type,x_start_mm,y_start_mm,z_start_mm,x_end_mm,y_end_mm,z_end_mm,speed_mm_s,duration_s,pl\n"

METHODS = tuple(
    name
    for name in estimator_names()
    if not load_estimator(name).needs(moves_of_recording(read_recording(UP20))[0], load_robot("yaskawa/up20"))
)


@pytest.fixture(scope="module")
def recording():
    return read_recording(UP20)


@pytest.fixture(scope="module")
def moves(recording):
    return moves_of_recording(recording)[0]


@pytest.fixture(scope="module")
def half(moves):
    """Every second move: what a method learns from them is shared by the tests that ask for it."""
    return moves.take(np.arange(0, len(moves), 2))


@pytest.fixture(scope="module")
def robot():
    return load_robot("yaskawa/up20")


@pytest.fixture(scope="module")
def signature(recording):
    return calibrate(recording, "factors")[0]


def percent(slowness, moves):
    return 100 * np.abs(duration_of(slowness, moves) - moves.duration) / moves.duration


def held_out(name, moves, robot, out):
    estimator = load_estimator(name)
    parameters = estimator.fit(moves.take(~out), robot)
    asked = moves.take(out)
    return percent(estimator.estimate(parameters, asked, robot).slowness, asked)


@pytest.mark.slow("terms_and_places", "axis_terms_gp")
@pytest.mark.parametrize("name", METHODS)
def test_every_method_says_the_same_after_its_file_was_read(name, moves, robot, tmp_path):
    part = moves.take(np.arange(0, len(moves), 3))
    made = facts(fit_moves(part, robot, name), part)
    write_signature(made, tmp_path / "s.json")
    again = read_signature(tmp_path / "s.json")
    before, after = predict(made, moves), predict(again, moves)
    assert after.duration == pytest.approx(before.duration, abs=1e-6)
    assert after.high == pytest.approx(before.high, abs=1e-6)
    assert to_text(again) == to_text(made)


@pytest.mark.parametrize("name", METHODS)
def test_no_method_looks_at_the_durations_it_is_asked_for(name, half, robot):
    estimator, parameters = load_estimator(name), learnt(name, half, robot)
    blind = replace(half, duration=np.full(len(half), np.nan))
    seen, unseen = (estimator.estimate(parameters, m, robot).slowness for m in (half, blind))
    assert np.array_equal(seen, unseen)


@pytest.mark.parametrize("name", METHODS)
def test_the_order_of_what_is_asked_does_not_matter(name, moves, half, robot):
    estimator, parameters = load_estimator(name), learnt(name, half, robot)
    order = np.random.default_rng(1).permutation(len(moves))
    whole = estimator.estimate(parameters, moves, robot).slowness
    assert estimator.estimate(parameters, moves.take(order), robot).slowness == pytest.approx(whole[order])


# A Gaussian process on all moves takes ten times as long.
@pytest.mark.parametrize(
    ("name", "every"), [("axis_terms", 1), ("axis_terms_gp", 2), ("joint_limits", 1), ("constant", 1)]
)
def test_one_wrong_reading_does_not_move_the_others(name, every, moves, half, robot):
    estimator, asked = load_estimator(name), half if every == 2 else moves
    one = 70 // every
    wrong = asked.duration.copy()
    wrong[one] += 5.0
    plain, spoilt = (
        estimator.estimate(learnt(name, m, robot), asked, robot).slowness
        for m in (asked, replace(asked, duration=wrong))
    )
    others = np.arange(len(asked)) != one
    moved = np.abs(duration_of(spoilt, asked) - duration_of(plain, asked))[others]
    assert np.median(moved) < 0.03


def test_terms_are_the_same_for_the_mirrored_move(moves, robot):
    from olp.identification.signature.estimators.axis_terms import terms_of

    mirror = np.array([1.0, -1.0, 1.0])
    flip = np.diag(mirror)
    # The tool is mirrored with the move: R' = M R M, in which its own y turns round.
    mirrored = replace(
        moves, start=moves.start * mirror, end=moves.end * mirror, rotation=flip @ moves.rotation @ flip
    )
    assert terms_of(mirrored, robot).values == pytest.approx(terms_of(moves, robot).values, abs=1e-9)


def test_rates_at_both_ends_are_the_slopes_of_the_axes(moves, robot):
    from olp.identification.signature.axis_paths import axis_paths

    step = 1e-5
    start = axis_paths(moves, robot)
    ahead = axis_paths(replace(moves, start=moves.start + step * moves.direction), robot)
    slope = (ahead.start - start.start) / step
    assert start.start_rate[:, :3] == pytest.approx(slope[:, :3], rel=0.03, abs=0.02)


def test_a_whole_start_point_is_predicted_better_than_by_one_acceleration(moves, robot):
    errors = {name: [] for name in ("constant", "factors", "axis_terms")}
    for label in range(9):
        for name, found in errors.items():
            found.append(held_out(name, moves, robot, moves.start_labels == label))
    mean = {name: np.concatenate(found).mean() for name, found in errors.items()}
    assert mean["axis_terms"] < 0.85 < mean["factors"] < 1.31 < mean["constant"]


def test_a_whole_test_is_predicted_by_terms_of_the_axes(recording, moves, robot):
    tests = np.array(recording.moves.texts["test"])
    found = {test: held_out("axis_terms", moves, robot, tests == test).mean() for test in np.unique(tests)}
    assert found["approach"] < 1.0
    assert found["downward"] < 1.5
    assert found["depart"] < 2.5


@pytest.mark.slow
def test_the_choice_is_made_by_held_out_moves_and_start_points(moves, robot):
    part = moves.take(np.arange(0, len(moves), 2))
    fit = fit_moves(part, robot)
    assert set(METHODS) <= set(fit.compared)
    best = min(merit(score) for score in fit.compared.values())
    assert merit(fit.compared[fit.method]) <= best + 0.05
    assert fit.method not in ("constant", "joint_limits")


@pytest.mark.slow
def test_intervals_hold_nineteen_of_twenty_moves_of_start_points_that_were_held_out(moves, robot):
    inside = []
    for label in range(9):
        out = moves.start_labels == label
        fit = fit_moves(moves.take(~out), robot, "axis_terms")
        made = facts(fit, moves.take(~out))
        asked = moves.take(out)
        said = predict(made, asked, robot)
        inside.append((asked.duration >= said.low) & (asked.duration <= said.high))
        off = abs(said.duration.sum() - asked.duration.sum())
        assert off <= said.total_half(made)
    assert 0.9 <= np.concatenate(inside).mean() <= 1.0


def facts(fit, learnt):
    from olp.identification.signature.document import Learnt, Signature

    return Signature(
        "yaskawa/up20", "", None, None, Learnt("", "", len(learnt), 0.01), fit.method, fit.parameters, fit.errors,
        domain_of(learnt), {}, "",
    )  # fmt: skip


def test_outside_what_was_learnt_the_interval_widens_and_says_why(signature, moves):
    one = moves.take(np.arange(1))
    inside = predict(signature, one)
    far = predict(signature, replace(one, start=one.start + 3.0, end=one.end + 3.0))
    fast = predict(signature, replace(one, speed=one.speed * 3))
    assert inside.reasons == ("",)
    assert "from the nearest learnt move" in far.reasons[0]
    assert "speed 900 mm/s" in fast.reasons[0]
    wide = [float(p.high[0] - p.duration[0]) for p in (inside, far, fast)]
    assert wide[1] > 3 * wide[0]
    assert wide[2] > 3 * wide[0]


def test_a_sum_of_correlated_errors_is_wider_than_of_independent_ones():
    rng = np.random.default_rng(3)
    groups = np.repeat(np.arange(40), 25)
    errors = np.repeat(rng.normal(0, 0.03, 40), 25) + rng.normal(0, 0.02, 1000)
    spread = spread_of(errors, groups)
    assert spread.shared == pytest.approx(0.03, rel=0.3)
    assert spread.own == pytest.approx(0.02, rel=0.1)
    assert spread.half == pytest.approx(1.96 * math.hypot(0.03, 0.02), rel=0.3)


def test_total_intervals_hold_the_sums_of_new_groups():
    rng = np.random.default_rng(5)
    held, trials = 0, 400
    for _ in range(trials):
        shared = rng.normal(0, 0.03, 11)
        errors = shared.repeat(15) + rng.normal(0, 0.02, 165)
        spread = spread_of(errors[:150], np.repeat(np.arange(10), 15))
        from olp.identification.signature.errors import ErrorModel

        half = ErrorModel(spread, spread).total_half(np.ones(15), np.ones(15))
        held += abs(errors[150:].sum()) <= half
    assert 0.92 <= held / trials <= 0.99


def test_the_gradient_of_the_likelihood_is_its_slope():
    rng = np.random.default_rng(0)
    places = ((rng.normal(size=(15, 3)), rng.normal(size=(15, 3))), (rng.normal(size=(15, 2)),))
    squares, values, theta = _squares(places, places), rng.normal(size=15), rng.normal(size=6) * 0.3
    _, gradient = _cost(theta, squares, values, np.ones(15))
    for i, step in enumerate(np.eye(6) * 1e-6):
        ends = [_cost(theta + sign * step, squares, values, np.ones(15))[0] for sign in (1, -1)]
        assert gradient[i] == pytest.approx((ends[0] - ends[1]) / 2e-6, rel=1e-4, abs=1e-6)


def test_the_process_finds_a_smooth_function_again_and_its_doubt_grows_away_from_it():
    x = np.linspace(0, 6, 40)[:, None]
    part = KernelPart(Belief(1.0, 1.0), (Belief(1.0, 1.0),))
    process = learn(((x,),), np.sin(x[:, 0]), (part,), Belief(0.01, 1.0))
    mean, doubt = answer(process, ((np.array([[1.57], [20.0]]),),))
    assert mean[0] == pytest.approx(1.0, abs=0.01)
    assert doubt[0] < 0.02
    assert doubt[1] > 0.3


def test_the_minimiser_finds_the_bottom_of_a_bent_valley():
    def rosenbrock(p):
        x, y = p
        slope = [-2 * (1 - x) - 400 * x * (y - x * x), 200 * (y - x * x)]
        return float((1 - x) ** 2 + 100 * (y - x * x) ** 2), np.array(slope)

    assert minimise(rosenbrock, np.array([-1.2, 1.0]), 200) == pytest.approx([1.0, 1.0], abs=0.02)


def test_grouped_errors_are_those_of_plain_ridge_regressions():
    rng = np.random.default_rng(2)
    terms, values = rng.normal(size=(30, 4)), rng.normal(size=30)
    labels, subsets = np.arange(30) % 3, all_subsets(4, 2)
    found = grouped_errors(terms, values, np.ones(30), labels, subsets, 0.7)
    for subset, said in zip(subsets, found.tolist(), strict=True):
        errors = []
        for group in range(3):
            out = labels == group
            columns = np.c_[np.ones(30), terms[:, list(subset)]]
            damping = 0.7 * np.diag([0.0] + [1.0] * len(subset))
            left = columns[~out].T @ columns[~out] + damping
            weights = np.linalg.solve(left, columns[~out].T @ values[~out])
            errors.append(np.abs(columns[out] @ weights - values[out]).mean())
        assert said == pytest.approx(np.mean(errors))


def test_the_motion_of_a_slowness_is_that_of_the_constant_acceleration_model():
    from olp.timing.motion import load_model

    rng = np.random.default_rng(6)
    length, speed, acceleration = rng.uniform(0.01, 1, 50), rng.uniform(0.1, 1, 50), rng.uniform(0.3, 3, 50)
    made = line_moves(length, speed)
    profile = load_model("constant").profile(length, speed, acceleration, acceleration, 0.0, 0.0)
    assert duration_of(1 / acceleration, made) == pytest.approx(profile.duration)


def line_moves(length, speed):
    count = len(length)
    nothing = np.full(count, np.nan)
    end = np.zeros((count, 3))
    end[:, 0] = length
    return MoveSet(
        np.zeros((count, 3)), end, np.full((count, 3, 3), np.nan), speed, nothing, nothing, nothing, ("",) * count,
        ("",) * count,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({"schema": "other"}, "H006"),
        ({"version": 99}, "H007"),
        ({"domain": None}, "H008"),
        ({"parameters": {"tables": {}}}, "H008"),
        ({"errors_s2_per_m": {"near": {}, "far": {}}}, "H008"),
        ({"tool_mm_deg": ["a"]}, "H008"),
    ],
)
def test_a_file_that_is_no_signature_is_told_by_its_code(signature, change, code):
    content = json.loads(json.dumps(json.loads(to_text(signature)))) | change
    with pytest.raises(OlpError) as caught:
        from_json(content)
    assert caught.value.diagnostics[0].code == code


@pytest.mark.parametrize("text", ["", "[]", "{", "\x00", '{"schema": "olp-signature"}', "[" * 100_000])
def test_hostile_text_is_an_error_and_not_a_traceback(text, tmp_path):
    path = tmp_path / "s.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(OlpError) as caught:
        read_signature(path)
    assert caught.value.diagnostics[0].code in ("H006", "H007", "H008")


def test_the_file_names_robot_controller_recording_and_domain(signature, recording):
    content = to_json(signature)
    assert content["robot"] == "yaskawa/up20"
    assert content["controller"] == "XRC"
    assert content["recording"]["sha256"] == recording.sha256
    assert content["domain"]["speed_mm_s"] == pytest.approx([300.0, 300.0])


def test_an_unknown_method_and_too_few_moves_are_refused(recording, tmp_path):
    with pytest.raises(OlpError) as caught:
        calibrate(recording, "magic")
    assert caught.value.diagnostics[0].code == "H001"
    path = tmp_path / "moves.csv"
    path.write_text(HEADER + "1,linear,0,0,0,100,0,0,100,1.5,0\n", encoding="utf-8")
    with pytest.raises(OlpError) as caught:
        calibrate(read_recording(path))
    assert caught.value.diagnostics[0].code == "H003"


def test_without_a_robot_the_methods_that_need_none_are_there(tmp_path):
    rows = [
        f"{i},linear,{i * 10},0,0,{i * 10 + 300},{i * 7},0,100,{3.3 + 0.001 * i},0\n" for i in range(1, 30)
    ]
    path = tmp_path / "moves.csv"
    path.write_text(HEADER + "".join(rows), encoding="utf-8")
    made, _ = calibrate(read_recording(path))
    assert not load_estimator(made.method).needs_robot
    with pytest.raises(OlpError) as caught:
        calibrate(read_recording(path), "axis_terms")
    assert caught.value.diagnostics[0].code == "H002"


def test_predict_answers_every_row_measured_or_not(tmp_path, signature, capsys):
    write_signature(signature, tmp_path / "s.json")
    path = tmp_path / "moves.csv"
    rows = [
        "7,linear,1350,700,100,710,700,100,300,,0\n",
        "9,wait,,,,,,,,0.5,\n",
        "11,linear,1350,700,100,710,650,100,300,9.99,0\n",
        "12,linear,1350,700,100,710,650,100,300,,3\n",
    ]
    path.write_text(HEADER + "".join(rows), encoding="utf-8")
    assert (
        main(["predict", str(path), "--signature", str(tmp_path / "s.json"), "-o", str(tmp_path / "o.csv")])
        == 0
    )
    lines = (tmp_path / "o.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "move,predicted_s,low_s,high_s"
    assert lines[1].startswith("7,2.640000,")
    assert lines[2] == "9,,,"
    assert lines[3].startswith("11,2.660000,")
    at_stop, through = ([float(v) for v in line.split(",")[1:]] for line in lines[3:])
    assert through[0] == at_stop[0]
    assert through[1] < at_stop[1]
    assert "H012" in capsys.readouterr().err


def test_the_commands_calibrate_show_plot_and_diff_work_together(tmp_path, capsys):
    for method in ("factors", "constant"):
        assert main(["calibrate", str(UP20), "--method", method, "-o", str(tmp_path / f"{method}.json")]) == 0
    assert "held out inside the recording" in capsys.readouterr().out
    factors, constant = (str(tmp_path / f"{m}.json") for m in ("factors", "constant"))
    assert main(["signature", "show", factors]) == 0
    assert "speed 300 mm/s" in capsys.readouterr().out
    assert main(["signature", "plot", factors, "-o", str(tmp_path / "p.svg")]) == 0
    assert (tmp_path / "p.svg").read_text(encoding="utf-8").startswith("<")
    assert main(["signature", "diff", factors, factors, "--limit", "0.1"]) == 0
    assert "+0.00 %" in capsys.readouterr().out
    slower = json.loads(Path(factors).read_text(encoding="utf-8"))
    slower["parameters"]["nominal"]["value"] = 300.0
    (tmp_path / "slow.json").write_text(json.dumps(slower), encoding="utf-8")
    assert main(["signature", "diff", factors, str(tmp_path / "slow.json"), "--limit", "1"]) == 1
    assert main(["signature", "diff", factors, constant]) == 0


def test_the_signature_never_overwrites_the_recording(tmp_path, capsys):
    path = tmp_path / "moves.csv"
    text = (UP20 / "moves.csv").read_bytes()
    path.write_bytes(text)
    assert main(["calibrate", str(path), "--method", "constant", "-o", str(path)]) == 2
    assert "C006" in capsys.readouterr().err
    assert path.read_bytes() == text
