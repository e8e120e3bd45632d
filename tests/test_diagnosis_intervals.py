"""Intervals, folds, and what a simulation was tuned by."""

import csv
import math
from dataclasses import replace

import diagnosis_cases as planted
import numpy as np
import pytest

from olp.identification.diagnosis.case_making import _least_ramps, _SimulatedRows
from olp.identification.diagnosis.diagnose import diagnose_recording
from olp.identification.diagnosis.fitting import Noise, fit, moved, place_of
from olp.identification.diagnosis.folds import _dealt
from olp.identification.diagnosis.intervals import distance, parameters_with_intervals, settled
from olp.identification.diagnosis.logs.series import Grid, Spectrum
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.diagnosis.simulation_laws import SimulatedRamps, inferred, ramps_of, trapezoid, tuned
from olp.identification.recorded_plan import case_of
from olp.identification.recording import read_recording
from olp.timing.physics import load_term

NOISE = 0.002


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """Sixty moves that do as simulated."""
    rng = np.random.default_rng(5)
    made = planted.program(rng, 60)
    one = np.ones(60)
    sim = trapezoid(made.length, made.speed, planted.ACCELERATION * one)
    folder = planted.write(tmp_path_factory.mktemp("case") / "recording", made, sim, sim, NOISE, rng)
    return case_of(read_recording(folder)).case


def part_of(name, case, key, *values):
    term = load_term(name)
    form = next(f for f in term.forms(case) if f.key == key)
    return ModelPart(term, form, np.array(values))


def fitted(case, part, seed=0):
    """The fit of a part to durations that it made itself, with noise."""
    scatter = NOISE * np.random.default_rng(seed).normal(size=len(case))
    there = replace(case, measured=DurationModel((part,)).seconds(case) + scatter, derived={})
    return fit(DurationModel((part,)), there, Noise(1e-4), 30), there


def test_an_interval_ends_where_the_likelihood_has_fallen_as_far_as_two_deviations(case):
    best, there = fitted(case, part_of("speed-clamp", case, "", 0.3))
    for sign in (-1, 1):
        far = distance(best, 0, sign, 0.0, 2.0, there, Noise(1e-4))
        place = float(place_of(best.model)[0][0])
        end = fit(moved(best.model, 0, place + sign * far), there, Noise(1e-4), 10, held=0)
        assert math.sqrt(2 * (end.loss - best.loss)) == pytest.approx(2.0, abs=0.5)


def test_intervals_hold_the_truth_about_as_often_as_they_say(case):
    held = []
    for seed in range(60):
        best, there = fitted(case, part_of("settling", case, "", 0.03), seed)
        told = parameters_with_intervals(best, there, Noise(1e-4))[0]["time"]
        held.append(told.low <= 0.03 <= told.high)
    assert 53 <= sum(held) <= 60


def test_a_clamp_that_no_move_reaches_has_one_end_only(case):
    free = replace(case, measured=case.simulated, derived={})
    high = DurationModel((part_of("speed-clamp", case, "", 0.85),))
    told = parameters_with_intervals(fit(high, free, Noise(NOISE)), free, Noise(NOISE))[0]["clamp"]
    assert not told.identified
    assert 0.5 < told.low < 0.85 < told.high


def test_what_the_form_leaves_makes_intervals_wider_but_chance_does_not(case):
    best, there = fitted(case, part_of("settling", case, "", 0.03))
    plain, same, wide = (
        parameters_with_intervals(best, there, Noise(1e-4), (), floor)[0]["time"]
        for floor in (math.inf, best.scale, best.scale / 2)
    )
    assert same == plain
    assert wide.high - wide.low > 2 * (plain.high - plain.low)


def test_of_forms_that_do_equally_well_the_plain_law_is_reported(case):
    two = replace(case, payload=np.where(np.arange(60) % 2, 10.0, 0.0), derived={})
    best, there = fitted(two, part_of("payload", two, "weight", 0.02))
    assert settled(best, there, Noise(1e-4)).model.parts[0].form.key == ""


@pytest.mark.parametrize(("faster", "stronger"), [(1.0, 1.0), (0.93, 1.0), (1.0, 0.8), (1.1, 0.7)])
def test_what_a_simulation_was_tuned_by_is_found(faster, stronger):
    made = planted.program(np.random.default_rng(3), 60)
    slow = np.full(60, 2.0)
    sim = np.round(trapezoid(made.length, faster * made.speed, stronger * slow), 5)
    assert tuned(made.length, made.speed, slow, sim, np.ones(60, bool)) == pytest.approx(
        (faster, stronger), rel=1e-3
    )


def test_what_no_tuning_explains_is_no_tuning():
    made = planted.program(np.random.default_rng(3), 60)
    slow = np.full(60, 2.0)
    sim = trapezoid(made.length, made.speed, slow) + np.random.default_rng(4).uniform(0.0, 0.05, 60)
    assert tuned(made.length, made.speed, slow, sim, np.ones(60, bool)) == (1.0, 1.0)


def test_groups_are_dealt_so_that_the_difference_is_spread():
    labels = np.repeat(np.arange(20), 5)
    weight = np.where(labels % 5 == 0, 1.0, 0.0)  # four groups hold it all
    folds = _dealt(labels, weight)
    assert np.bincount(folds, weight).max() == 5
    assert np.bincount(folds).min() >= 10
    assert all(len(set(folds[labels == k].tolist())) == 1 for k in range(20))


def test_last_bits_do_not_change_how_groups_are_dealt():
    rng = np.random.default_rng(7)
    labels = np.repeat(np.arange(57), rng.integers(2, 5, 57))
    weight = np.where(labels % 3 == 0, 0.1, 0.0)
    folds = _dealt(labels, weight)
    for _ in range(20):
        shaken = weight * (1.0 + 1e-15 * rng.standard_normal(len(weight)))
        assert np.array_equal(_dealt(labels, shaken), folds)


def test_smoothing_keeps_the_level_of_a_curve():
    values = np.full((400, 1), 0.3)
    values[0] = 0.5
    smooth = Spectrum(Grid(0.0, 0.004, values)).derivative(0, 0, 0.01)
    assert smooth[100:300] == pytest.approx(0.3, abs=1e-6)


def test_a_tuned_simulation_is_told_and_its_motion_is_the_one_that_terms_change(tmp_path):
    rng = np.random.default_rng(6)
    made = planted.program(rng, 60)
    one = np.ones(60)
    sim = trapezoid(made.length, 0.9 * made.speed, planted.ACCELERATION * one)
    folder = planted.write(tmp_path / "recording", made, sim, sim, NOISE, rng)
    making = case_of(read_recording(folder))
    assert making.case.base.speed == pytest.approx(0.9 * made.speed, rel=1e-3)
    assert any("90.0" in note for note in making.notes)


BESIDE = [
    {"build": 0.08},
    {"stop": 0.05},
    {"filtered": 0.08},
    {"build": 0.06, "stop": 0.04},
    {"shortest": 0.2},
]


@pytest.mark.slow("law4-True", "law2-True", "law3-False")
@pytest.mark.parametrize("written", [True, False])
@pytest.mark.parametrize("law", BESIDE)
def test_what_a_simulations_ramps_have_beside_constant_accelerations_is_read_off_its_times(law, written):
    made = planted.program(np.random.default_rng(3), 60)
    slow = np.full(60, 2.0)
    sim = np.round(SimulatedRamps(**law).seconds(made.length, made.speed, slow), 3)
    sim[::11] += 0.3  # some moves have a limit of their own
    given = slow if written else np.full(60, np.nan)
    found = ramps_of(made.length, made.speed, given, sim, np.ones(60, bool))
    assert found.stronger == pytest.approx(1.0 if written else 2.0, rel=5e-3)
    for name in ("build", "filtered", "stop", "shortest"):
        assert getattr(found, name) == pytest.approx(law.get(name, 0.0), abs=2e-3)


@pytest.mark.parametrize("written", [True, False])
def test_a_simulation_whose_ramps_have_a_shortest_time_is_told(written, tmp_path):
    """By bisection of the peak speed. Most ramps here are the shortest: these were a share of the acceleration, and all
    others were off by up to 0.5 s."""
    shortest, slow, rng = 0.15, planted.ACCELERATION, np.random.default_rng(9)
    made = planted.program(rng, 80)
    made.speed = rng.choice([0.05, 0.1, 0.2, 0.6, 1.2], 80)
    low, high = np.zeros(80), made.speed.copy()
    for _ in range(60):
        peak = 0.5 * (low + high)
        fits = peak * np.maximum(peak / slow, shortest) <= made.length
        low, high = np.where(fits, peak, low), np.where(fits, high, peak)
    ramp = np.maximum(low / slow, shortest)
    sim = 2.0 * ramp + (made.length - low * ramp) / low
    assert np.mean(ramp > shortest) < 0.5
    folder = planted.write(tmp_path / "recording", made, sim, sim, NOISE, rng)
    if not written:
        table = list(csv.DictReader((folder / "moves.csv").read_text().splitlines()))
        kept = [name for name in table[0] if name != "accel_mm_s2"]
        rows = [",".join(row[name] for name in kept) for row in table]
        (folder / "moves.csv").write_text("\n".join([",".join(kept), *rows]) + "\n")
    making = case_of(read_recording(folder))
    np.testing.assert_allclose(making.case.base.duration(), sim, atol=1e-3)
    assert any("no ramp shorter than 150.0 ms" in note for note in making.notes)


@pytest.mark.parametrize("law", ["stop", "filtered", "build"])
def test_a_time_beside_ramps_is_told_by_moves_of_which_most_do_not_reach_their_speed(law):
    """Times of moves that do are straight lines of their ramps; those of the others lead far away from the law."""
    ways = {
        0.2: (1, 8, 15, 15, 35, 35),
        0.3: (2, 4, 8, 15, 25, 25, 25, 28, 35),
        0.4: (4, 35),
        0.6: (1, 2, 4, 8, 15, 35),
        0.8: (2, 2, 4, 25),
    }
    way, speed = np.array([(cm / 100, fast) for fast, each in ways.items() for cm in each]).T
    ramps = SimulatedRamps(stronger=1.4, **{law: 0.137})
    sim = np.round(ramps.seconds(way, speed, np.full(27, 1.4)), 4)
    found = ramps_of(way, speed, np.full(27, np.nan), sim, np.ones(27, bool))
    assert (found.stronger, getattr(found, law)) == (
        pytest.approx(1.4, rel=2e-3),
        pytest.approx(0.137, abs=5e-4),
    )


@pytest.mark.parametrize(
    ("term", "value", "ramp", "fastest"),
    [
        ("acceleration", 0.6, 1 / 0.6, 9.0),
        ("acceleration", 1.5, 1 / 1.5, 9.0),
        ("speed-clamp", 0.4, 1.0, 0.4),
    ],
)
def test_where_all_ramps_take_one_time_an_acceleration_scales_it_and_a_clamp_does_not(
    term, value, ramp, fastest, tmp_path
):
    """As of controllers with time constants. Nobody wrote an acceleration: the simulation's seemed to have no end."""
    rng, time = np.random.default_rng(9), 0.2
    made = planted.program(rng, 90)
    made.speed = np.minimum(rng.choice([0.1, 0.3, 0.6], 90), 0.5 * made.length / time)
    sim = made.length / made.speed + time
    real = made.length / np.minimum(made.speed, fastest) + ramp * time
    folder = planted.write(tmp_path / "recording", made, real, sim, NOISE, rng)
    table = list(csv.DictReader((folder / "moves.csv").read_text().splitlines()))
    kept = [name for name in table[0] if name != "accel_mm_s2"]
    rows = [",".join(row[name] for name in kept) for row in table]
    (folder / "moves.csv").write_text("\n".join([",".join(kept), *rows]) + "\n")
    case = case_of(read_recording(folder)).case
    np.testing.assert_allclose(case.base.duration(), sim, atol=1e-3)
    form = next(form for form in load_term(term).forms(case) if not form.key)
    null = 1.0 if term == "speed-clamp" else form.parameters[0].null
    part = ModelPart(load_term(term), form, np.array([value * null]))
    np.testing.assert_allclose(DurationModel((part,)).seconds(case), real, atol=2e-3)


def test_moves_that_a_simulation_makes_slower_than_all_others_have_their_own_accelerations():
    """Two of thirty: a gantry's slower slide, say. What weakens the drives takes its share of their longer ramps."""
    made = planted.program(np.random.default_rng(3), 30)
    slow = np.full(30, 2.0)
    slow[[7, 21]] = 0.6
    sim = np.round(trapezoid(made.length, made.speed, slow), 4)
    none, plain = np.zeros(30), np.ones(30, bool)
    found = inferred(
        *(made.length, made.speed, sim, plain, 0.0, SimulatedRamps()),
        known=none + np.nan,
        leading=np.full(30, -1),
    )
    assert found == pytest.approx(slow, rel=1e-2)


@pytest.mark.parametrize("law", [{"stop": 0.05}, {"filtered": 0.08}])
def test_a_simulation_that_moves_in_steps_has_the_law_that_it_is_a_step_off(law):
    rng = np.random.default_rng(3)
    made = planted.program(rng, 60)
    slow = np.full(60, 2.0)
    sim = SimulatedRamps(**law).seconds(made.length, made.speed, slow) + rng.uniform(0.0, 2e-3, 60)
    found = ramps_of(made.length, made.speed, slow, sim, np.ones(60, bool))
    assert found.stronger == pytest.approx(1.0, rel=1e-2)
    assert found.filtered + found.stop == pytest.approx(sum(law.values()), abs=3e-3)
    assert not found.build


def test_ramps_of_constant_acceleration_have_nothing_beside_and_scatter_has_no_law():
    made = planted.program(np.random.default_rng(3), 60)
    slow = np.full(60, 2.0)
    sim = trapezoid(made.length, 0.9 * made.speed, slow)
    assert ramps_of(made.length, made.speed, slow, np.round(sim, 3), np.ones(60, bool)) == SimulatedRamps()
    scattered = sim + np.random.default_rng(4).uniform(0.0, 0.05, 60)
    assert ramps_of(made.length, made.speed, slow, scattered, np.ones(60, bool)) is None


@pytest.mark.slow("0.08-0.3")
@pytest.mark.parametrize(("simulated", "built"), [(0.08, 0.3), (0.3, 0.08)])
def test_a_robot_that_builds_up_its_accelerations_otherwise_than_the_simulation_has_a_jerk_alone(
    simulated, built, tmp_path
):
    rng = np.random.default_rng(6)
    made = planted.program(rng, 80)
    slow = np.full(80, planted.ACCELERATION)
    sim, real = (
        SimulatedRamps(build=t, stop=0.05).seconds(made.length, made.speed, slow) for t in (simulated, built)
    )
    folder = planted.write(tmp_path / "recording", made, real, np.round(sim, 4), NOISE, rng)
    answer = diagnose_recording(read_recording(folder)).diagnosis
    assert [finding.term for finding in answer.findings] == ["jerk"]
    assert answer.verdict == "explained"
    assert any(f"{1e3 * simulated:.1f} ms" in note and "50.0 ms" in note for note in answer.notes)


def in_an_s(way, speed, slow, jerk):
    """[s] from rest to rest where accelerations build up at a jerk; the highest speed of short ways by bisection."""

    def ramp(fast):
        return np.where(fast >= slow**2 / jerk, fast / slow + slow / jerk, 2.0 * np.sqrt(fast / jerk))

    low, high = np.zeros(len(way)), np.array(speed)
    for _ in range(60):
        middle = 0.5 * (low + high)
        fits = middle * ramp(middle) <= way
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    top = np.where(speed * ramp(speed) <= way, speed, low)
    return way / top + ramp(top)


@pytest.mark.slow("time")
@pytest.mark.parametrize("one", ["jerk", "time"])
def test_whether_a_jerk_or_a_time_stays_where_accelerations_differ_the_robot_tells(one, tmp_path):
    """Of one acceleration, simulated times are the same by both; what was left was called jerk and friction."""
    rng, slow, build, stronger = np.random.default_rng(8), planted.ACCELERATION, 0.12, 0.7
    made = planted.program(rng, 120)
    sim = in_an_s(made.length, made.speed, slow, slow / build)
    jerk = slow / build if one == "jerk" else stronger * slow / build
    real = in_an_s(made.length, made.speed, stronger * slow, jerk)
    folder = planted.write(tmp_path / "recording", made, real, np.round(sim, 4), 0.0005, rng)
    answer = diagnose_recording(read_recording(folder)).diagnosis
    assert [finding.term for finding in answer.findings] == ["acceleration"]
    (number,) = answer.findings[0].parameters.values()
    assert number.value == pytest.approx(stronger * slow, rel=0.01)
    assert any("one jerk explains" in note for note in answer.notes) == (one == "jerk")


def test_a_simulation_in_which_half_of_the_lines_take_what_is_written_is_not_tuned():
    """The others end cycles, and are rounded into the next: 95 % of the speeds and 284 % of the accelerations."""
    way = np.array([320.2, 333, 332.7, 323.3, 317.6, 323.7, 327.5, 333.5, 350.5, 358.5, 315.4, 331.4]) / 1000
    speed = np.array([0.4, 0.8, 0.4, 0.4, 0.4, 0.4, 0.8, 0.8, 0.4, 0.4, 0.8, 0.8])
    sim = trapezoid(way, speed, np.full(12, 6.79))
    sim[[3, 6, 7, 10, 11]] -= [0.0297, 0.0626, 0.0625, 0.062, 0.0613]
    assert tuned(way, speed, np.full(12, 6.79), np.round(sim, 4), np.ones(12, bool)) == (1.0, 1.0)


def test_lines_of_one_speed_tell_a_time_in_which_written_accelerations_build_up():
    """A share of speeds and accelerations came near to most of them, and no other law was asked."""
    way = np.array(
        [0.6828, 0.1035, 0.5567, 0.6568, 0.2452, 0.4808, 0.4467, 0.6076, 0.5766, 0.0372, 1.0506, 1.7943]
    )
    slow = np.full(12, 5.23)
    sim = in_an_s(way, np.ones(12), slow, slow / 0.0939)
    law = ramps_of(way, np.ones(12), slow, np.round(sim, 4), np.ones(12, bool))
    assert (law.stronger, law.stop, law.filtered) == (1.0, 0.0, 0.0)
    assert law.build == pytest.approx(0.0939, abs=5e-4)


def test_a_time_that_builds_up_accelerations_is_none_of_stops_where_the_robot_shows_it(tmp_path):
    """All simulated lines reach their acceleration: they take the same by both. The robot had a second name,
    `settling`, that took back what the simulation was said to take at stops."""
    rng, slow, simulated, real = np.random.default_rng(6), planted.ACCELERATION, 0.04, 0.16
    made = planted.program(rng, 120, speeds=(0.1, 0.2, 0.5))
    sim, seconds = (in_an_s(made.length, made.speed, slow, slow / time) for time in (simulated, real))
    recording = read_recording(planted.write(tmp_path / "recording", made, seconds, sim, 0.002, rng))
    assert case_of(recording).case.base.added.max() > 0.03
    answer = diagnose_recording(recording).diagnosis
    assert [finding.term for finding in answer.findings] == ["jerk"]
    assert any("time at each stop" in note for note in answer.notes)


def turning(rng, count):
    """Lines of which every second one turns the tool, about z, and by what angle [rad]."""
    made = planted.program(rng, count)
    turn = np.where(np.arange(count) % 2 == 0, rng.uniform(0.2, 1.9, count), 0.0)
    names = [f"r{axis}_{end}_deg" for end in ("start", "end") for axis in "xyz"]
    made.more = {name: np.zeros(count) for name in names}
    made.more["rz_end_deg"] = np.degrees(turn)
    return made, turn


def test_limits_of_the_tools_turn_are_read_off_the_simulated_times(tmp_path):
    """What a weak axis cost was called gravity: as simulated, short ways took a tenth of what their turns do."""
    rng, rate, ramp, stop = np.random.default_rng(9), 1.7, 4.0, 0.05
    made, turn = turning(rng, 80)
    per_turn = np.where(turn > 0, made.length / np.where(turn > 0, turn, 1.0), np.inf)
    speed = np.minimum(made.speed, rate * per_turn)
    slow = np.minimum(planted.ACCELERATION, ramp * per_turn)
    sim = planted.play(made.length, speed, slow, slow) + stop
    assert np.mean(speed < made.speed) > 0.1
    assert np.mean(slow < planted.ACCELERATION) > 0.2
    folder = planted.write(tmp_path / "recording", made, sim, sim, NOISE, rng)
    making = case_of(read_recording(folder))
    np.testing.assert_allclose(making.case.base.duration(), sim, atol=1e-3)
    np.testing.assert_allclose(making.case.base.accelerate, slow, rtol=0.02)
    (note,) = (note for note in making.notes if "turns the tool" in note)
    told = [float(word) for word in note.split() if word[0].isdigit()]
    assert told == pytest.approx(np.degrees([rate, ramp]), rel=0.01)


def test_limits_of_the_turn_hide_no_ramps_where_every_line_turns_the_tool(tmp_path):
    """The simulation has two thirds of the written acceleration, which few lines show: the calmest do."""
    rng, rate, ramp = np.random.default_rng(9), 1.2, 3.0
    made, _ = turning(rng, 80)
    turn = rng.uniform(0.1, 1.9, 80)
    made.more["rz_end_deg"] = np.degrees(turn)
    stronger = 2 / 3 * planted.ACCELERATION
    speed, slow = (
        np.minimum(made.speed, rate * made.length / turn),
        np.minimum(stronger, ramp * made.length / turn),
    )
    sim = planted.play(made.length, speed, slow, slow)
    assert np.mean((speed < made.speed) | (slow < stronger)) > 0.4
    making = case_of(read_recording(planted.write(tmp_path / "recording", made, sim, sim, NOISE, rng)))
    np.testing.assert_allclose(making.case.base.duration(), sim, atol=2e-3)


@pytest.mark.parametrize("one", ["jerk", "time"])
def test_whether_a_jerk_or_a_time_stays_limits_of_the_turn_tell(one, tmp_path):
    """Lines that they slow have other accelerations: up to 0.8 s of a simulated line were unexplained."""
    rng, rate, ramp, build = np.random.default_rng(9), 1.7, 4.0, 0.12
    made, turn = turning(rng, 80)
    per_turn = np.where(turn > 0, made.length / np.where(turn > 0, turn, 1.0), np.inf)
    speed, slow = np.minimum(made.speed, rate * per_turn), np.minimum(planted.ACCELERATION, ramp * per_turn)
    jerk = planted.ACCELERATION / build if one == "jerk" else slow / build
    sim = in_an_s(made.length, speed, slow, jerk)
    making = case_of(read_recording(planted.write(tmp_path / "recording", made, sim, sim, NOISE, rng)))
    np.testing.assert_allclose(making.case.base.duration(), sim, atol=1e-3)
    assert any("m/s³" in note for note in making.notes) == (one == "jerk")


@pytest.mark.parametrize(
    ("of_lines", "fast", "spared"), [(0.1, 0.4, True), (0.2, 0.4, False), (0.1, 0.1, False)]
)
def test_drives_have_some_to_spare_where_the_controllers_shortest_ramp_holds_all_of_them(
    of_lines, fast, spared
):
    """Joint moves whose ramps all take the time that lines have, too: a robot of less acceleration had longer ones, and
    its name was another. If lines have another time, or all take the same, it may be that of the drives."""
    speed = np.array([0.05, fast, 1.0, 2.0])
    joint = np.array([False, False, True, True])
    way, slow, yes = np.full(4, 3.0), np.array([2.0, 2.0, 90.0, 90.0]), np.ones(4, bool)
    rows = _SimulatedRows(way, speed, slow, way, yes, yes, yes, joint, yes, np.zeros(4), np.zeros((4, 3)))
    found, shortest = _least_ramps(
        rows, slow, SimulatedRamps(shortest=of_lines), SimulatedRamps(shortest=0.1)
    )
    held = speed[joint] / 0.1
    assert found[joint] == pytest.approx(8.0 * held if spared else held)
    assert shortest.tolist() == [of_lines, of_lines, 0.1, 0.1]


def test_turning_lines_that_last_longer_for_other_reasons_have_no_limits_of_the_turn(tmp_path):
    rng = np.random.default_rng(9)
    made, turn = turning(rng, 80)
    sim = planted.play(made.length, made.speed, *(np.full(80, planted.ACCELERATION),) * 2)
    sim += np.where(turn > 0, rng.uniform(0.1, 0.5, 80), 0.0)
    making = case_of(read_recording(planted.write(tmp_path / "recording", made, sim, sim, NOISE, rng)))
    assert not any("turns the tool" in note for note in making.notes)


def test_an_interval_holds_what_another_form_says_that_does_as_well(case):
    """Whether one move's path is slowed, or its turn has ramps of its own: both say the same duration."""
    turn = np.where(np.arange(60) % 5 == 0, 0.06, 0.0)
    turn[7] = 2.5
    turning = replace(case, turn=turn, derived={})
    own, there = fitted(turning, part_of("orientation-limit", turning, "of its own", 1.2, 6.0))
    slowed = part_of("orientation-limit", turning, "slows the path", 1.2)
    best = fit(DurationModel((slowed,)), there, Noise(1e-4), 30)
    told = parameters_with_intervals(best, there, Noise(1e-4))[0]["rate"]
    assert told.low < own.model.parts[0].values[0] < told.high


def test_a_limit_is_no_less_a_limit_where_another_form_needs_none_for_it(case):
    """All turns are alike: ramps alone say the same time, and then the limit of the speed may be at infinity. The name
    was dropped for it, with 158 ms that it explained."""
    turning = replace(case, turn=np.where(np.arange(60) % 5 == 0, 2.4, 0.0), derived={})
    best, there = fitted(turning, part_of("orientation-limit", turning, "of its own, at once", 1.2))
    apart = part_of("orientation-limit", turning, "of its own", 20.0, 4 * 1.2**2 / 2.4)
    assert DurationModel((apart,)).seconds(there) == pytest.approx(best.model.seconds(there), abs=2 * NOISE)
    told = parameters_with_intervals(best, there, Noise(1e-4))[0]["rate"]
    assert told.identified
    assert told.low < 1.2 < told.high < 2.0


@pytest.mark.parametrize("lengths", [6, 60])
def test_moves_that_are_rounded_alike_are_no_evidence_of_their_own(case, lengths):
    """They last equally long and their scatter is hidden in one digit: together they tell as much as one of them."""
    part, held = part_of("dispatch", case, "", 0.02), 0
    for seed in range(20):
        sim = np.random.default_rng(seed).uniform(0.4, 2.0, lengths)[np.arange(60) % lengths]
        measured = np.round(sim + 0.028, 2)
        there = replace(case, simulated=sim, measured=measured, resolution=0.01, derived={})
        best = fit(DurationModel((part,)), there, Noise(0.0029), 30)
        told = parameters_with_intervals(best, there, Noise(0.0029))[0]["time"]
        held += told.low < 0.028 < told.high
    assert held >= 17


def test_running_time_counts_from_the_first_move_also_where_it_is_not_judged(tmp_path):
    rng = np.random.default_rng(5)
    made = planted.program(rng, 60)
    sim = trapezoid(made.length, made.speed, planted.ACCELERATION * np.ones(60))
    folder = planted.write(tmp_path / "recording", made, sim, sim, NOISE, rng)
    with open(folder / "moves.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows[:2]:
        row["sim_s"] = ""
    with open(folder / "moves.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, rows[0])
        table.writeheader()
        table.writerows(rows)
    told = case_of(read_recording(folder)).case
    starts = [float(rows[k]["t_start_s"]) for k in (0, 2)]
    assert [told.began, told.t_start[0]] == pytest.approx(starts)
