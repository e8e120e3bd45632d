"""What is named, and what the verdict says: promises over recordings of all kinds, made by a drive of their own."""

from __future__ import annotations

import csv
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from olp.__main__ import main
from olp.identification.diagnosis import diagnose, findings, naming, search
from olp.identification.diagnosis.conditions import _bounded, _cost, _restricted, _said, conditioned, fit_anew
from olp.identification.diagnosis.diagnose import diagnose_recording
from olp.identification.diagnosis.evidence import (
    CUT,
    NOTICED,
    Gain,
    Selection,
    confirmed,
    drifts_on,
    fallen,
    matters,
)
from olp.identification.diagnosis.fitting import Noise, evaluate, fit, loss_each, slopes_of, whiten
from olp.identification.diagnosis.folds import Folds, interleaved
from olp.identification.diagnosis.intervals import parameters_with_intervals
from olp.identification.diagnosis.model import Condition, DurationModel, Statement
from olp.identification.diagnosis.report_text import text_report
from olp.identification.diagnosis.residuals import remains_of
from olp.identification.diagnosis.search import additions, move_terms, price, shelf_of, swaps
from olp.identification.diagnosis.verdict import AGREES, EXPLAINED, _grows, joined, verdict_of
from olp.identification.diagnosis.waits import (
    far_on_one_side,
    late_moves,
    spread,
    tails_of,
    threshold,
    told_by_unseen_moves,
)
from olp.identification.recorded_plan import case_of
from olp.identification.recording import read_recording
from olp.timing.physics._case import Rates

COUNT = 120
ACCELERATION = 2.0  # m/s²


def travel(way, speed, slow):
    """(n,) [s] between stops at constant acceleration."""
    full = way >= speed**2 / slow
    return np.where(full, way / speed + speed / slow, 2.0 * np.sqrt(way / slow))


def program(seed, count=COUNT):
    """Places, lengths and speeds of straight moves between exact stops."""
    rng = np.random.default_rng(seed)
    start = rng.uniform([0.6, -0.6, 0.0], [1.2, 0.6, 0.8], (count, 3))
    towards = rng.normal(size=(count, 3))
    way = rng.uniform(0.06, 0.6, count)
    end = start + way[:, None] * towards / np.linalg.norm(towards, axis=1)[:, None]
    return start, end, way, rng.choice([0.15, 0.3, 0.5, 0.8], count)


def record(folder, real, seed, more=None, toml="time_resolution_s = 0.001\n", stretch=1.0, made=None):
    """A recording of the program of a seed, or of `made`, with durations `real` (n,) [s]; the simulated ones are
    `stretch` times as long as what is written takes."""
    start, end, way, speed = made or program(seed, len(real))
    sim, clock = (
        stretch * travel(way, speed, ACCELERATION),
        np.concatenate([[0.0], np.cumsum(real + 0.2)[:-1]]),
    )
    folder.mkdir(exist_ok=True)
    with open(folder / "moves.csv", "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        points = [f"{axis}_{at}_mm" for at in ("start", "end") for axis in "xyz"]
        names = ["move", "duration_s", "sim_s", "t_start_s", *points, "speed_mm_s", "accel_mm_s2", "blend_mm"]
        rows.writerow([*names, *(more or {})])
        for i in range(len(real)):
            cells = [i + 1, f"{real[i]:.6f}", f"{sim[i]:.6f}", f"{clock[i]:.3f}"]
            cells += [f"{v * 1000:.4f}" for v in (*start[i], *end[i], speed[i], ACCELERATION)]
            rows.writerow([*cells, 0, *(values[i] for values in (more or {}).values())])
    (folder / "recording.toml").write_text(toml, encoding="utf-8")
    return read_recording(str(folder))


def stamped(seed, real, digits, heavy):
    """Durations that are differences of time stamps, rounded: what one move loses the next one wins."""
    rng = np.random.default_rng(seed)
    off = 0.003 * (rng.standard_t(3, COUNT + 1) if heavy else rng.normal(size=COUNT + 1))
    stamps = np.round((np.concatenate([[0.0], np.cumsum(real)]) + off) / digits) * digits
    return np.diff(stamps)


def plain(seed, count=COUNT):
    _, _, way, speed = program(seed, count)
    return travel(way, speed, ACCELERATION)


@pytest.mark.parametrize("by", [1, 10])
def test_moves_that_were_not_recorded_share_no_stamp_with_those_about_them(by, tmp_path):
    record(tmp_path / "r", plain(5), 5)
    lines = (tmp_path / "r" / "moves.csv").read_text().splitlines()
    kept = [k for k in range(1, COUNT + 1) if k % 7]
    rows = [",".join([str(by * k), *lines[k].split(",")[1:]]) for k in kept]
    (tmp_path / "r" / "moves.csv").write_text("\n".join([lines[0], *rows]) + "\n")
    follows = case_of(read_recording(str(tmp_path / "r"))).case.follows
    counted = [by == 10 or (k - 1) % 7 > 0 for k in kept[1:]]  # in tens, numbers do not count moves
    assert follows[1:].tolist() == counted


@pytest.mark.slow("1-0.0001-False", "2-0.01-False")
@pytest.mark.parametrize(("seed", "digits", "heavy"), [(1, 1e-4, False), (2, 0.01, False), (3, 1e-4, True)])
def test_shared_stamps_alone_are_no_mismatch(seed, digits, heavy, tmp_path):
    real = stamped(seed, plain(seed), digits, heavy)
    found = diagnose_recording(record(tmp_path / "r", real, seed)).diagnosis
    assert (found.verdict, found.findings) == ("no-mismatch", ())


@pytest.mark.slow
def test_shared_stamps_are_told_by_what_the_names_leave(tmp_path):
    start, end, way, _ = program(47)
    real = plain(47) + np.where((start - end)[:, 2] / way > 0.7, 0.03, 0.0)
    began = np.random.default_rng(47).uniform(0.0, 0.012)
    stamps = np.floor((np.concatenate([[0.0], np.cumsum(real)]) + began) / 0.012) * 0.012
    recording = record(tmp_path / "r", np.diff(stamps), 47, toml="time_resolution_s = 0.012\n")
    named = diagnose_recording(recording).named
    assert named.noise.order == pytest.approx(naming._order(named.fit, named.clean), abs=5e-3)


@pytest.mark.slow
def test_with_shared_stamps_a_term_is_named_and_its_number_is_finer_than_white_noise_would_allow(tmp_path):
    _, _, way, speed = program(4)
    real = stamped(4, travel(way, speed, 0.7 * ACCELERATION), 1e-4, False)
    found = diagnose_recording(record(tmp_path / "r", real, 4)).diagnosis
    assert found.verdict == "explained"
    assert found.findings[0].term == "acceleration"
    value = next(iter(found.findings[0].parameters.values())).value
    assert value == pytest.approx(0.7 * ACCELERATION, rel=0.02)


def test_whitening_of_shared_stamps_leaves_neighbours_independent_and_the_scatter_as_it_was(tmp_path):
    case = case_of(record(tmp_path / "r", plain(5), 5)).case
    rng = np.random.default_rng(5)
    stamps = np.diff(rng.normal(size=(COUNT + 1, 4000)), axis=0) / np.sqrt(2.0)
    draws = np.sqrt(0.98) * stamps + np.sqrt(0.02) * rng.normal(size=stamps.shape)
    white = whiten(draws, Noise(1e-5, -0.49), case)
    together = np.mean(white[1:] * white[:-1])
    assert abs(together) < 0.03
    assert np.mean(draws[1:] * draws[:-1]) == pytest.approx(-0.49, abs=0.02)
    assert np.mean(white**2) == pytest.approx(1.0, abs=0.05)
    half = case.take(np.arange(0, COUNT, 2))
    assert whiten(draws[::2], Noise(1e-5, -0.49), half) == pytest.approx(draws[::2])  # no neighbours any more


def test_a_term_under_a_condition_is_named_with_it_and_with_its_moves(tmp_path):
    _, end, way, _ = program(6)
    where = (end[:, 1] > 0.1) & (way > 0.2)
    rng = np.random.default_rng(6)
    real = plain(6) + 0.06 * where + rng.normal(0.0, 0.002, COUNT)
    found = diagnose_recording(record(tmp_path / "r", real, 6)).diagnosis
    (finding,) = found.findings
    assert finding.term in {"settling", "dispatch"}
    assert "y > " in finding.condition
    assert "length > " in finding.condition
    told, true = set(finding.moves), set((np.nonzero(where)[0] + 1).tolist())
    assert 2 * len(told & true) / (len(told) + len(true)) > 0.9


def test_what_acts_where_the_middle_of_a_move_is_has_one_statement(tmp_path):
    """Two statements about start and end leave moves out, whose ends are on either side: they were called waits."""
    start, end, way, speed = program(6)
    where = start[:, 2] + end[:, 2] < 2 * 0.45
    real = np.where(where, travel(way, np.minimum(speed, 0.2), ACCELERATION), plain(6))
    real += np.random.default_rng(6).normal(0.0, 0.002, COUNT)
    case, noise = case_of(record(tmp_path / "r", real, 6)).case, Noise(1e-3)
    shelf = shelf_of(case, move_terms())
    (part,) = conditioned(fit(DurationModel(), case, noise, 8), case, noise, shelf, 2).model.parts
    assert part.term.name == "speed-clamp"
    (statement,) = part.condition.statements
    assert statement.column == "middle z"
    assert part.condition.mask(case)[(speed > 0.2)].tolist() == where[speed > 0.2].tolist()


@pytest.mark.slow
def test_what_acts_in_few_moves_and_is_far_larger_than_the_scatter_is_named_and_foretold(tmp_path):
    """To first order such moves are outliers without weight: they were called waits."""
    _, end, way, _ = program(6)
    where = (end[:, 1] > 0.2) & (way > 0.4)
    assert 6 <= where.sum() <= 15
    rng = np.random.default_rng(6)
    real = plain(6) + 0.4 * where + rng.normal(0.0, 0.002, COUNT)
    found = diagnose_recording(record(tmp_path / "r", real, 6)).diagnosis
    (finding,) = found.findings
    assert finding.term in {"settling", "dispatch"}
    assert set(finding.moves) == set((np.nonzero(where)[0] + 1).tolist())
    assert found.heldout_after.rmse < found.heldout_before.rmse


@pytest.mark.slow
def test_under_a_condition_the_term_that_acts_is_told_from_those_that_promise_as_much_at_first(tmp_path):
    """A moving average of the speed: short moves lose up to twice its length, which no fixed time does."""
    _, end, way, speed = program(6)
    where, time = (end[:, 1] > 0.1) & (way > 0.12), 0.18
    peak = np.minimum(speed, 0.5 * ACCELERATION * (np.sqrt(time**2 + 4.0 * way / ACCELERATION) - time))
    averaged = way / peak + peak / ACCELERATION + time
    rng = np.random.default_rng(6)
    real = np.where(where, averaged, plain(6)) + rng.normal(0.0, 0.002, COUNT)
    found = diagnose_recording(record(tmp_path / "r", real, 6)).diagnosis
    (finding,) = found.findings
    assert finding.term == "jerk"
    assert finding.parameters["ramp_time"].value == pytest.approx(time, rel=0.03)
    assert found.indistinguishable == ()


def test_what_is_tried_in_the_place_of_a_term_is_what_acts_like_it_under_its_condition(tmp_path, monkeypatch):
    """In all moves the ramps differ by far more than in the short ones, where alone they are slower."""
    _, _, way, speed = program(6)
    slow = np.where(way < 0.15, travel(way, speed, 0.75 * ACCELERATION), plain(6))
    slow = slow + np.random.default_rng(6).normal(0.0, 0.002, COUNT)
    case = case_of(record(tmp_path / "r", slow, 6)).case
    shelf, noise = shelf_of(case, move_terms()), Noise(1e-3)
    part = next(p for p in shelf.parts if p.term.name == "dispatch")
    short = part._replace(condition=Condition((Statement("length", below=0.15),)))
    monkeypatch.setattr(search, "_IN_PLACE", 1)
    found = swaps(fit(DurationModel((short,)), case, noise), 0, shelf, case, noise)[0].model.parts[0]
    assert found.term.name == "acceleration"
    assert found.condition == short.condition
    assert found.values == pytest.approx(0.75 * ACCELERATION, rel=0.03)


@pytest.mark.slow
def test_under_a_condition_what_makes_moves_quicker_is_found(tmp_path):
    """Limits, which only slow, explain as much to first order with the wrong sign."""
    _, end, way, speed = program(6)
    where = (end[:, 1] > 0.1) & (way > 0.2)
    rng = np.random.default_rng(6)
    quick = travel(way, speed, 1.6 * ACCELERATION)
    real = np.where(where, quick, plain(6)) + rng.normal(0.0, 0.002, COUNT)
    recording = record(tmp_path / "r", real, 6)
    case = case_of(recording).case
    shelf, noise = shelf_of(case, move_terms()), Noise(1e-3)
    limits = [k for k, part in enumerate(shelf.parts) if part.term.name == "speed-clamp"]
    assert limits
    assert not any(shelf.parts[k].reversible for k in limits)
    assert all(
        p.term.name != "speed-clamp"
        for p in additions(shelf, evaluate(DurationModel(), case, noise), case, noise, 99)
    )
    (finding,) = diagnose_recording(recording).diagnosis.findings
    assert finding.term == "acceleration"
    assert finding.condition is not None


@pytest.mark.slow
def test_a_difference_without_a_name_still_has_a_next_experiment(tmp_path):
    rng = np.random.default_rng(22)
    real = plain(20) * (1.0 + 0.05 * np.sin(2 * np.pi * np.arange(COUNT) / 17.0)) + rng.normal(
        0.0, 0.002, COUNT
    )
    found = diagnose_recording(record(tmp_path / "r", real, 20)).diagnosis
    assert found.verdict == "unexplained"
    assert found.next_experiment.why.startswith("no name holds; of the nearest terms, ")
    assert found.next_experiment.moves or found.next_experiment.timers


@pytest.mark.slow
def test_what_remains_beside_a_name_has_a_next_experiment(tmp_path):
    rng, (start, end, way, speed) = np.random.default_rng(23), program(20)
    rise = (end - start)[:, 2] / way
    wave = 1.0 + 0.05 * np.sin(2 * np.pi * np.arange(COUNT) / 17.0)
    real = travel(way, speed, (1.0 - 0.5 * rise) * ACCELERATION) * wave + rng.normal(0.0, 0.002, COUNT)
    found = diagnose_recording(record(tmp_path / "r", real, 20)).diagnosis
    assert found.verdict == "partly-explained"
    assert found.next_experiment.why.startswith("more remains; of the nearest terms beside the names, ")
    assert found.next_experiment.moves or found.next_experiment.timers


@pytest.mark.slow("0.98")
@pytest.mark.parametrize("stretch", [0.98, 1.03])
def test_the_tuning_of_a_stretched_simulation_is_taken_back_and_is_no_cause(stretch, tmp_path):
    rng, cold = np.random.default_rng(9), np.exp(-np.arange(COUNT) / 40.0)
    real = plain(9) * (1.0 + 0.05 * cold) + rng.normal(0.0, 0.002, COUNT)
    found = diagnose_recording(record(tmp_path / "r", real, 9, stretch=stretch)).diagnosis
    assert [f.term for f in found.findings] == ["warm-up"]
    assert found.verdict == "explained"
    assert any("this tuning of the simulation is removed" in note for note in found.notes)
    # Alone it is what differs, and has a name.
    bare = plain(9) + rng.normal(0.0, 0.002, COUNT)
    found = diagnose_recording(record(tmp_path / "s", bare, 9, stretch=stretch)).diagnosis
    assert {"speed-scale", "clock"} >= {f.term for f in found.findings} > set()


def test_a_drift_of_the_simulated_times_is_told_from_one_of_the_whole(tmp_path):
    """Beside a time per move the share is another one; the form that is a little off left room for other names."""
    rng, real = np.random.default_rng(9), plain(9)
    late = 0.2 + 0.06 * real * np.exp(-np.arange(COUNT) / 40.0)
    found = diagnose_recording(
        record(tmp_path / "r", real + late + rng.normal(0.0, 0.001, COUNT), 9)
    ).diagnosis
    warm = next(f for f in found.findings if f.term == "warm-up")
    assert "T_s" in warm.equation
    assert len(found.findings) == 2


def under(case, column, above):
    """A time per move of 60 ms where a column is `above` a bound."""
    shelf = shelf_of(case, move_terms())
    part = next(p for p in shelf.parts if p.term.name == "dispatch")
    condition = Condition((Statement(column, above=above),))
    return DurationModel((part._replace(values=np.array([0.06]), condition=condition),))


def test_unseen_moves_are_foretold_with_the_condition_that_the_others_want(tmp_path):
    """A condition that the predicted moves have chosen too would foretell them too well."""
    _, end, _, _ = program(6)
    rng = np.random.default_rng(6)
    real = plain(6) + 0.06 * (end[:, 1] > 0.1) + rng.normal(0.0, 0.002, COUNT)
    case = case_of(record(tmp_path / "r", real, 6)).case
    noise = Noise(1e-3)
    for column, above in (("length", 0.3), ("y", 0.35)):
        found = fit_anew(under(case, column, above), case, noise, 10)
        (statement,) = found.model.parts[0].condition.statements
        assert statement.column == "y"
        assert statement.above == pytest.approx(0.1, abs=0.03)


def test_a_bound_stays_where_the_seen_moves_do_not_tell_another_from_it(tmp_path):
    _, end, _, _ = program(6)
    rng = np.random.default_rng(6)
    real = plain(6) + 0.06 * (end[:, 1] > 0.1) + rng.normal(0.0, 0.002, COUNT)
    case = case_of(record(tmp_path / "r", real, 6)).case
    model, far = under(case, "y", 0.1), np.nonzero(np.abs(end[:, 1] - 0.1) > 0.1)[0]
    found = fit_anew(model, case.take(far), Noise(1e-3), 10)
    assert found.model.parts[0].condition == model.parts[0].condition


def test_a_statement_that_a_better_bound_makes_needless_falls(tmp_path):
    """What it leaves out beside a rough bound on y, the right bound leaves out as well."""
    case = case_of(record(tmp_path / "r", plain(6), 6)).case
    better = np.where(case.end[:, 1] > 0.1, 10.0, -10.0)
    rough = Condition((Statement("length", above=0.1), Statement("y", above=0.0)))
    (statement,) = _bounded(rough, better, case).statements
    assert statement.column == "y"
    assert statement.above == pytest.approx(0.1, abs=0.03)
    both = np.where((case.end[:, 1] > 0.1) & (case.length > 0.2), 10.0, -10.0)
    assert len(_bounded(rough, both, case).statements) == 2


@pytest.mark.parametrize(("step", "stays"), [(0.003, False), (0.02, True)])
def test_a_name_in_a_part_of_the_moves_that_is_next_to_nothing_beside_another_is_its_form(
    step, stays, tmp_path
):
    """A large law is off by its form, which a small term in some of the moves makes up for."""
    _, end, way, speed = program(6)
    real = travel(way, speed, 0.4 * ACCELERATION) + step * (end[:, 1] > 0.1)
    real += np.random.default_rng(6).normal(0.0, 0.002, COUNT)
    case = case_of(record(tmp_path / "r", real, 6)).case
    shelf, noise = shelf_of(case, move_terms()), Noise(1e-3)
    large = next(part for part in shelf.parts if part.term.name == "acceleration")
    both = fit(DurationModel((large, *under(case, "y", 0.1).parts)), case, noise, 30)
    found, _, fell = confirmed(both, case, noise, Folds("", interleaved(np.arange(COUNT))), shelf)
    assert ("dispatch" in found.names, "dispatch" in fell) == (stays, not stays)


@pytest.mark.parametrize(("odd", "stays"), [(0.04, True), (0.06, False)])
def test_one_odd_move_beside_a_gap_does_not_decide_where_in_the_gap_a_bound_is(tmp_path, odd, stays):
    """Moves of 200 mm are not seen; the last one before them is late, by more than half of what the name does."""
    _, end, _, _ = program(6)
    rng = np.random.default_rng(6)
    real = plain(6) + 0.06 * (end[:, 1] > 0.1) + rng.normal(0.0, 0.002, COUNT)
    below = np.where(end[:, 1] < 0.0, end[:, 1], -np.inf)
    real[np.argmax(below)] += odd
    case = case_of(record(tmp_path / "r", real, 6)).case
    model, far = under(case, "y", 0.1), np.nonzero(np.abs(end[:, 1] - 0.1) > 0.1)[0]
    (statement,) = fit_anew(model, case.take(far), Noise(1e-3), 10).model.parts[0].condition.statements
    assert (statement.above == 0.1) == stays
    assert stays or statement.above == pytest.approx(below.max(), abs=0.03)


def test_what_acts_everywhere_gets_no_condition(tmp_path):
    case = case_of(record(tmp_path / "r", plain(7) + 0.05, 7)).case
    shelf, noise = shelf_of(case, move_terms()), Noise(1e-3)
    part = next(p for p in shelf.parts if p.term.name == "dispatch")
    best = evaluate(DurationModel((part._replace(values=np.array([0.05])),)), case, noise)
    assert conditioned(best, case, noise, shelf, 8) is best


def test_a_condition_says_what_holds_in_its_moves(tmp_path):
    case = case_of(record(tmp_path / "r", plain(8), 8)).case
    condition = Condition((Statement("length", above=0.3), Statement("y", below=0.1)))
    assert str(condition) == "length > 300 mm and y < 100 mm"
    assert (condition.mask(case) == ((case.length > 0.3) & (case.end[:, 1] < 0.1))).all()


@pytest.mark.slow("True")
@pytest.mark.parametrize("column", [False, True])
def test_an_override_is_named(column, tmp_path):
    share = np.where(np.arange(COUNT) % 3 == 0, 50.0, 85.0) if column else np.full(COUNT, 85.0)
    rng = np.random.default_rng(9)
    real = plain(9) / (share / 100.0) + rng.normal(0.0, 0.002, COUNT)
    recording = record(tmp_path / "r", real, 9, {"override_pct": share} if column else None)
    found = diagnose_recording(recording).diagnosis
    assert [f.term for f in found.findings] == ["speed-scale"]
    assert found.heldout_after.rmse < 0.004


@pytest.mark.slow
def test_the_load_that_the_simulation_was_told_is_compared_with_the_real_one(tmp_path):
    """Both ways: the robot carries more in some moves and less in others."""
    _, _, way, speed = program(10)
    real_load, told = np.where(np.arange(COUNT) % 2 == 0, 12.0, 2.0), np.full(COUNT, 6.0)
    ratio = (1.0 + 0.05 * told) / (1.0 + 0.05 * real_load)
    rng = np.random.default_rng(10)
    real = travel(way, speed, ACCELERATION * ratio) + rng.normal(0.0, 0.001, COUNT)
    recording = record(tmp_path / "r", real, 10, {"payload_kg": real_load, "sim_payload_kg": told})
    found = diagnose_recording(recording).diagnosis
    assert [f.term for f in found.findings] == ["payload"]
    growth = found.findings[0].parameters["growth"]
    assert growth.low < 0.05 < growth.high


@pytest.mark.slow("loads1-2.0-names1", "loads2-3.0-names2")
@pytest.mark.parametrize(
    ("loads", "carried", "names"),
    [
        ([0.0, 4.0, 12.0], 4.0, {"payload"}),
        ([0.0, 4.0, 12.0], 2.0, {"payload", "acceleration"}),
        ([0.0, 12.0], 3.0, {"payload", "acceleration"}),
    ],
)
def test_a_simulation_carries_a_load_that_some_move_carries_or_has_another_acceleration(
    loads, carried, names, tmp_path
):
    """With two loads a simulation that carries the heavy one, and is too quick, says the same: that is no third way
    between which nothing would be wrong with the acceleration."""
    _, _, way, speed = program(10)
    rng = np.random.default_rng(10)
    load = rng.choice(loads, COUNT)
    ratio = (1.0 + 0.05 * carried) / (1.0 + 0.05 * load)
    real = travel(way, speed, ACCELERATION * ratio) + rng.normal(0.0, 0.002, COUNT)
    found = diagnose_recording(record(tmp_path / "r", real, 10, {"payload_kg": load})).diagnosis
    assert {f.term for f in found.findings} == names
    told = next(f for f in found.findings if f.term == "payload").parameters
    assert told["growth"].value == pytest.approx(0.05, rel=0.03)
    assert "simulated" not in told or told["simulated"].value == carried


def axes(folder, ramps, paces, more, noise=0.0):
    """A recording of a KR 3, an axis at a time, at four speeds, robot and simulation under an override of 85 %:
    the robot's ramps (6,) [1] and speeds (6,) [1] over the simulated ones."""
    rated = np.radians([530.0, 529.0, 538.0, 600.0, 600.0, 800.0])
    rng = np.random.default_rng(3)
    axis, share = (v.ravel() for v in np.meshgrid(np.repeat(np.arange(6), 2), [0.1, 0.5, 0.7, 1.0]))
    turned = np.radians(rng.uniform(30.0, 100.0, len(axis)))
    speed, ramp = 0.85 * share * rated[axis], np.full(len(axis), 30.0)
    sim, real = travel(turned, speed, ramp), travel(turned, paces[axis] * speed, ramps[axis] * ramp)
    folder.mkdir(exist_ok=True)
    with open(folder / "moves.csv", "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        points = [f"q{k}_{at}_deg" for at in ("start", "end") for k in range(1, 7)]
        rows.writerow(["move", "type", "duration_s", "sim_s", "speed_pct", "override_pct", *points, *more])
        for i in range(len(axis)):
            start = np.array([0.0, -60.0, 60.0, 10.0, 20.0, 10.0])
            end = start + np.degrees(turned[i]) * (np.arange(6) == axis[i])
            cells = [
                i + 1,
                "joint",
                f"{real[i] + noise * rng.normal():.6f}",
                f"{sim[i]:.6f}",
                100.0 * share[i],
                85.0,
            ]
            rows.writerow([*cells, *np.concatenate([start, end]).round(6), *more.values()])
    (folder / "recording.toml").write_text(
        'robot = "kuka/kr3-r540"\ntime_resolution_s = 0.001\n', encoding="utf-8"
    )
    return read_recording(str(folder))


def test_an_override_that_the_simulation_ran_under_is_read_off_its_joint_moves(tmp_path):
    case = case_of(axes(tmp_path / "r", np.ones(6), np.ones(6), {})).case
    assert case.base.accelerate == pytest.approx(np.full(len(case), 30.0), rel=1e-3)
    assert case.override == pytest.approx(np.ones(len(case)))


@pytest.mark.slow
def test_another_load_inertia_and_slower_axes_are_named_beside_each_other(tmp_path):
    inertia = {"payload_inertia_kg_m2": 0.001, "sim_payload_inertia_kg_m2": 0.04}
    wrist = np.array([1.0, 1.0, 1.0, 1.8, 1.8, 1.8])
    slower = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 0.9])
    found = diagnose_recording(axes(tmp_path / "r", wrist, slower, inertia, 0.001)).diagnosis
    assert {f.term for f in found.findings} == {"payload-inertia", "speed-scale"}
    scale = next(f for f in found.findings if f.term == "speed-scale").parameters["scale_a6"]
    assert scale.value == pytest.approx(0.9, rel=0.01)


def test_names_are_kept_by_the_likelihood_of_unseen_moves_with_the_number_of_names_counted():
    strong, weak, worse = (
        Gain(40.0, 5.0, 0.02, 0.01, 9.0),
        Gain(4.0, 1.0, 0.02, 0.01, 9.0),
        Gain(40.0, 5.0, 0.01, 0.02, 0.0),
    )
    assert fallen([strong, weak], 20) == [1]
    assert fallen([strong, weak], 1) == []  # with nothing else to choose from, less will do
    assert fallen([worse], 20) == [0]  # the error goes up
    assert fallen([Gain(40.0, 35.0, 0.02, 0.01, 9.0)], 20) == [0]  # one move alone
    assert fallen([Gain(26.0, 13.0, 0.02, 0.01, 9.0)], 20) == []  # each of two tells the other
    assert fallen([Gain(40.0, 5.0, 0.1004, 0.1, 9.0)], 20) == []  # others are far off with it, too


def lifts(seed, count=COUNT):
    """A program as `program` makes it, of moves up and down by few lengths at few speeds."""
    rng = np.random.default_rng(seed)
    end, way = (
        rng.uniform([0.7, -0.6, 0.2], [1.3, 0.6, 0.8], (count, 3)),
        rng.choice([0.08, 0.12, 0.2, 0.3], count),
    )
    up = np.where(np.arange(count) % 2, 1.0, -1.0)
    start = end - (up * way)[:, None] * np.array([0.0, 0.0, 1.0])
    return start, end, way, rng.choice([0.1, 0.25, 0.5], count)


@pytest.mark.slow("2")
@pytest.mark.parametrize("seed", [1, 2])
def test_moves_that_are_rounded_alike_are_no_evidence_for_a_second_name(seed, tmp_path):
    made = lifts(seed)
    real = travel(made[2], made[3], 1.6) + np.random.default_rng(seed).normal(0.0, 0.001, COUNT)
    toml = "time_resolution_s = 0.01\n"
    found = diagnose_recording(
        record(tmp_path / "r", np.round(real, 2), seed, toml=toml, made=made)
    ).diagnosis
    assert [finding.term for finding in found.findings] == ["acceleration"]
    assert found.verdict == "explained"


def test_a_rounded_duration_tells_that_the_true_one_is_within_half_a_width_and_no_more():
    left = np.array([0.0, 0.002, 0.004, 0.006, 0.02, 1.0, 1e4])
    told = loss_each(left, 1e-4, 0.01)
    assert np.isfinite(told).all()
    assert np.abs(np.diff(told[:3])).max() < 1e-3
    assert np.diff(told[2:]).min() > 1.0
    fine, exact = loss_each(left, 0.01, 1e-5), loss_each(left, 0.01, 0.0)
    assert np.allclose(fine, exact, atol=1e-3)


def heavy(seed):
    """[s] of scatter (n,): mostly 1 ms, with odd moves far out on both sides."""
    return 0.001 * np.random.default_rng(seed).standard_t(2.5, COUNT)


HEAVY = (13, 33)  # each leaves more than 1.5 times what scatters near the middle


@pytest.mark.slow("13")
@pytest.mark.parametrize("seed", HEAVY)
def test_right_names_explain_all_that_a_scatter_with_heavy_tails_leaves(seed, tmp_path):
    _, _, way, speed = program(seed)
    real = travel(way, speed, 0.8 * ACCELERATION) + heavy(seed)
    outcome = diagnose_recording(record(tmp_path / "r", real, seed, toml="time_resolution_s = 0.0001\n"))
    found, left = outcome.diagnosis, outcome.diagnosis.remainder.rmse
    assert found.verdict == "explained"
    assert found.findings[0].term in {"acceleration", "coulomb-friction"}
    assert any("the noise floor holds" in note for note in found.notes)
    assert left <= EXPLAINED * found.noise_floor


@pytest.mark.slow("33")
@pytest.mark.parametrize("seed", HEAVY)
def test_beside_heavy_tails_what_acts_in_few_moves_without_a_name_is_not_explained(seed, tmp_path):
    _, _, way, speed = program(seed)
    some = np.random.default_rng(seed).choice(COUNT, 5, replace=False)
    real = travel(way, speed, 0.8 * ACCELERATION) + heavy(seed)
    real[some] -= 0.03
    found = diagnose_recording(record(tmp_path / "r", real, seed, toml="time_resolution_s = 0.0001\n"))
    assert found.diagnosis.verdict == "partly-explained"


def test_far_out_moves_of_a_pattern_are_no_scatter(tmp_path):
    at, rng = np.arange(COUNT), np.random.default_rng(8)
    odd = 0.03 * ((at % 16 == 3) * 1.0 - (at % 16 == 11))
    real = plain(8) + odd + rng.normal(0.0, 0.002, COUNT)
    found = diagnose_recording(record(tmp_path / "r", real, 8)).diagnosis
    assert found.verdict == "unexplained"
    assert found.noise_floor < 0.003
    assert not any("the noise floor holds" in note for note in found.notes)


def far_out_moves(tmp_path, off):
    """120 moves that scatter by 1 ms, four of them by 4 ms, the longest four, and what four are `off` by (4,) [ms]."""
    case = case_of(record(tmp_path / "r", plain(5), 5)).case
    left = np.random.default_rng(5).normal(size=len(case))
    left[[10, 20, 40, 50]] = (4.5, -4.5, 4.5, -4.5)
    longest = np.argsort(case.length)[-4:]
    return case, left, longest, np.asarray(off)


@pytest.mark.parametrize(
    ("off", "worth"),
    [
        ((20, 20, 20, 20), 3.3),  # no single move decides
        ((20, 20, 20, 0), 3.3),
        ((40, -20, 20, -20), 20.0),  # with its like, not beside it
        ((80, -20, 20, -20), 60.0),  # beside the others
        ((20, -20, 20, -20), 13.3),
        ((20, -20, 0, 0), 6.7),
        ((-20, -20, 0, 0), 6.7),  # of one or two moves nothing tells that the other side has none
        ((-20, 0, 0, 0), 3.3),
    ],
)
def test_far_out_moves_are_scatter_as_far_as_they_are_on_both_sides(off, worth, tmp_path):
    case, left, _, off = far_out_moves(tmp_path, off)
    left[[7, 30, 66, 90]] = off
    assert 1e6 * tails_of(left / 1000.0, case) == pytest.approx(worth, abs=0.5)


@pytest.mark.parametrize("seed", [0, 8, 11])
def test_waits_are_told_from_the_tails_of_a_scatter_by_moves_that_were_not_fitted(seed):
    """As late as three moves that wait for long, or that a scatter throws far out, one of its two tails the longer."""
    rng = np.random.default_rng(seed)
    tails = 0.003 * np.sort(rng.standard_t(2.5, COUNT))
    tails[:3] = tails[3:6]  # no early move is far out
    assert late_in(tails) >= 3
    assert not told_by_unseen_moves(tails, 1e-4, 0.0)
    waits = 0.003 * rng.normal(size=COUNT)
    waits[rng.choice(COUNT, 8, replace=False)] += rng.uniform(0.05, 0.3, 8)
    assert told_by_unseen_moves(waits, 1e-4, 0.0)
    coarse = np.round(waits / 0.003) * 0.003
    assert told_by_unseen_moves(coarse, 1e-4, 0.003)


def test_a_scatter_that_is_rounded_to_nothing_but_in_its_tails_does_not_wait():
    """Most durations are one number of digits, of no width: whatever lies beside it would be likelier by a wait."""
    told = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        off = np.round(0.0006 * rng.standard_t(2.5, 91), 3)
        told.append(told_by_unseen_moves(off, 1e-4, 0.001))
    assert sum(told) <= 2  # of forty, one of twenty


@pytest.mark.parametrize("side", [1, -1])
def test_a_few_moves_far_out_on_one_side_are_no_scatter(side):
    rng = np.random.default_rng(4)
    off = 0.002 * rng.normal(size=280)
    off[[6, 67, 209]] = side * np.array([0.013, 0.023, 0.03])
    rounded = np.round(off / 0.002) * 0.002
    for values, sigma, digits in ((off, 0.002, 0.0), (rounded, 0.0021, 0.002)):
        assert np.flatnonzero(far_on_one_side(values, sigma, digits)).tolist() == [6, 67, 209]
        values[67] *= -1.0
        assert not far_on_one_side(values, sigma, digits).any()


@pytest.mark.parametrize(("tails", "digits"), [(1.5, 0.0), (2.5, 0.0), (2.5, 0.01), (30.0, 0.01)])
@pytest.mark.parametrize("shared", [False, True])
def test_no_scatter_has_moves_far_out_on_one_side(tails, digits, shared):
    """At most one recording of a hundred is allowed; here are 96. Durations are rounded, or are those between
    rounded stamps that neighbours share; others differ from the simulated ones by a bias."""
    for seed in range(12):
        rng = np.random.default_rng(seed)
        real = (
            rng.uniform(0.3, 3.0, 200)
            if not shared
            else np.append(0.0, np.cumsum(rng.uniform(0.3, 3.0, 200)))
        )
        scatter = 0.003 * rng.standard_t(tails, len(real))
        told = real + scatter
        told = np.round(told / digits) * digits if digits else told
        off = np.diff(told) - np.diff(real) if shared else told - np.round(real + 0.0002, 3)
        middle = off[np.abs(off - np.median(off)) < 6.0 * spread(off, max(digits, 1e-4) / 2.0)]
        assert not far_on_one_side(off, middle.std(), digits).any()


@pytest.mark.parametrize(("other", "verdict"), [(-0.01, "unexplained"), (0.01, "no-mismatch")])
def test_three_moves_far_out_on_one_side_are_a_difference(other, verdict, tmp_path):
    """They leave less than twice the noise, and go together with nothing."""
    real = plain(5) + 0.001 * np.random.default_rng(5).normal(size=COUNT)
    real[[31, 60, 90]] -= (0.009, 0.01, -other)
    told = diagnose_recording(record(tmp_path / "r", real, 5)).diagnosis
    assert (told.verdict, told.findings) == (verdict, ())
    assert any("moves (32, 61, 91) are early by" in note for note in told.notes) == (verdict == "unexplained")


def late_in(off):
    """How many of `off` (n,) are later than a normal scatter is."""
    return int((off > threshold(len(off)) * spread(off, 1e-4)).sum())


def test_more_far_out_moves_than_half_as_far_are_no_scatter(tmp_path):
    case, left, _, off = far_out_moves(tmp_path, (20, -20, 20, -20))
    left[[7, 30, 66, 90]] = off
    left[[10, 20]] = 1.0
    assert tails_of(left / 1000.0, case) == 0.0


@pytest.mark.parametrize(
    ("per_second", "per_move", "verdict"), [(0.02, 0.0, "unexplained"), (0.0, 0.02, "no-mismatch")]
)
def test_a_difference_that_grows_with_the_durations_is_no_scatter(per_second, per_move, verdict, tmp_path):
    """Without repeats only its size tells it from one: of these moves a second one is as far off as a recorder whose
    stamps are uneven, and goes together with nothing."""
    real, rng = plain(5), np.random.default_rng(5)
    real = real + rng.normal(size=COUNT) * (per_second * real + per_move)
    told = diagnose_recording(record(tmp_path / "r", real, 5)).diagnosis
    assert (told.verdict, told.findings) == (verdict, ())


@pytest.mark.parametrize(("together", "verdict"), [(0.41, "no-mismatch"), (0.65, "unexplained")])
def test_a_correlation_that_chance_makes_once_in_a_hundred_recordings_is_no_difference(
    together, verdict, tmp_path
):
    """Nothing but such a correlation would tell that there is one."""
    off, other = np.random.default_rng(3).normal(size=(2, COUNT))
    column = together * off + np.sqrt(1.0 - together**2) * other
    recording = record(tmp_path / "r", plain(3) + 0.004 * off, 3, more={"oil_c": column})
    named = diagnose_recording(recording).named
    assert [c.column for c in named.remains.correlates] == ["oil_c"]
    assert (verdict_of(named), named.fit.names) == (verdict, ())


def test_few_moves_of_nearly_one_duration_grow_with_it_by_chance():
    """37 moves with nothing hidden, of 0.6 to 0.96 s, were unexplained for it."""
    rng = np.random.default_rng(5)
    grown = [_grows(rng.normal(scale=0.012, size=24), rng.uniform(0.6, 0.96, 24)) for _ in range(400)]
    assert sum(grown) <= 2


def test_far_out_moves_of_one_kind_are_no_scatter(tmp_path):
    case, left, longest, off = far_out_moves(tmp_path, (20, -20, 20, -20))
    left[longest] = off
    assert tails_of(left / 1000.0, case) == 0.0


def test_far_out_moves_that_are_so_in_their_repeats_are_no_scatter(tmp_path):
    case, left, _, off = far_out_moves(tmp_path, (20, 22, -20, -22))
    left[[7, 30, 66, 90]] = off
    assert tails_of(left / 1000.0, case) > 0.0
    labels = np.arange(len(case))
    labels[[30, 90]] = labels[[7, 66]]
    assert tails_of(left / 1000.0, replace(case, repeats=labels, derived={})) == 0.0


def test_three_moves_are_no_comparison(tmp_path):
    recording = record(tmp_path / "r", plain(11), 11)
    lines = (tmp_path / "r" / "moves.csv").read_text().splitlines()[:4]
    (tmp_path / "r" / "moves.csv").write_text("\n".join(lines) + "\n")
    found = diagnose_recording(read_recording(str(tmp_path / "r"))).diagnosis
    assert found.verdict == "not-judged"
    assert main(["diagnose", str(tmp_path / "r")]) == 2
    assert recording.moves.move.size == COUNT
    assert joined("not-judged", "not-judged", False) == "not-judged"
    assert joined("explained", "not-judged", True) == "explained"


def test_where_no_name_holds_the_verdict_is_that_of_no_names(monkeypatch, tmp_path):
    """An acceleration that fits how durations round, and foretells no unseen move, is no reason for a mismatch."""
    _, _, way, speed = program(22)
    real = np.round(travel(way, speed, 0.995 * ACCELERATION) / 0.02) * 0.02
    recording = record(tmp_path / "r", real, 22, toml="time_resolution_s = 0.02\n")

    def holds(best, clean, noise, folds, shelf, kinds):
        part = next(p for p in shelf.parts if p.term.name == "acceleration")
        return fit(DurationModel((part,)), clean, noise, 30), (Gain(30.0, 1.0, 0.02, 0.01, 4.0),), {}

    monkeypatch.setattr(naming, "confirmed", holds)
    monkeypatch.setattr(naming, "selection", lambda clean, *_: Selection(clean.simulated, ()))
    monkeypatch.setattr(
        diagnose, "_idle", lambda told: ""
    )  # nor does its interval tell that it does something
    found = diagnose_recording(recording).diagnosis
    assert any("not named for want of evidence" in note for note in found.notes)
    assert (found.verdict, found.findings) == ("no-mismatch", ())


FEW = 60  # moves: with twice as many the search of the strangest recordings takes ten times as long
WAYS = (
    *("nothing", "wave", "walk", "jerky", "tail", "drift", "late"),
    *("region", "clamp", "pair", "digits", "few"),
)


@pytest.mark.slow("walk", "jerky", "tail", "drift", "late", "region", "pair", "digits", "clamp", "few")
@pytest.mark.parametrize("way_of", WAYS)
def test_verdicts_and_names_never_contradict_what_is_left(way_of, tmp_path):
    """Whatever is wrong with a recording: no agreement above twice the floor, and so on."""
    _, end, way, speed = program(20, FEW)
    rng, at = np.random.default_rng(21), np.arange(FEW)
    real = plain(20, FEW) + rng.normal(0.0, 0.002, FEW)
    if way_of == "wave":
        real = real * (1.0 + 0.05 * np.sin(2 * np.pi * at / 17.0))
    elif way_of == "walk":
        real = real + 0.004 * np.cumsum(rng.normal(size=FEW))
    elif way_of == "jerky":
        real = real + 0.1 * np.minimum(speed, np.sqrt(2.0 * way))
    elif way_of == "tail":
        real = real + 0.02 * rng.standard_t(2, FEW)
    elif way_of == "drift":
        real = real * (1.0 + 0.03 * np.exp(-at / 40.0))
    elif way_of == "late":
        real = real + np.where(rng.random(FEW) < 0.06, 0.4, 0.0) + 0.03 * (end[:, 0] > 1.0)
    elif way_of == "region":
        real = np.where(end[:, 2] > 0.5, travel(way, speed, 0.5 * ACCELERATION), real)
    elif way_of == "clamp":
        real = travel(way, np.minimum(speed, 0.78), ACCELERATION) + rng.normal(0.0, 0.002, FEW)
    elif way_of == "pair":  # the second makes up for the first on the mean
        real = travel(way, speed, 0.8 * ACCELERATION) + rng.normal(0.0, 0.002, FEW)
        real -= np.mean(real - plain(20, FEW))
    elif way_of == "digits":
        real = np.round((real + 0.004) / 0.02) * 0.02
    elif way_of == "few":
        real = real + 0.05 * (at % 40 == 7)
    outcome = diagnose_recording(record(tmp_path / "r", real, 20))
    found = outcome.diagnosis
    left, floor = found.remainder.rmse, found.noise_floor
    assert found.verdict != "no-mismatch" or left <= AGREES * floor
    assert found.verdict != "explained" or max(left, found.heldout_after.rmse) <= EXPLAINED * floor * 1.001
    assert outcome.named is not None
    assert all(gain.cut >= CUT for gain in outcome.named.gains)
    told = [finding.evidence for finding in found.findings]
    assert all(one.heldout_before >= NOTICED * one.heldout_after for one in told)
    assert bool(found.findings) == (found.verdict in ("explained", "partly-explained"))
    assert not found.findings or found.heldout_after.rmse <= found.heldout_before.rmse
    for finding in found.findings:
        assert not finding.holds_null
        assert finding.evidence.heldout_before >= NOTICED * finding.evidence.heldout_after
        assert finding.evidence.delta_bic > 0
        for parameter in finding.parameters.values():
            assert parameter.low <= parameter.value <= parameter.high
    if way_of == "nothing":
        assert not found.findings


@pytest.mark.slow
def test_a_name_whose_interval_holds_its_null_falls_even_if_others_are_as_good(monkeypatch, tmp_path):
    """The one that is as good stands in its place, unless its interval holds its null, too."""
    recording = record(tmp_path / "r", 1.03 * plain(51, FEW), 51)
    first = diagnose_recording(recording).diagnosis
    (term, other), *_ = first.indistinguishable
    assert [finding.term for finding in first.findings] == [term]
    idle: set[str] = set()

    def wide(fitted, *rest):
        told = parameters_with_intervals(fitted, *rest)
        for part, parameters in zip(fitted.model.parts, told, strict=True):
            if part.term.name in idle:
                for known in part.form.parameters:
                    one = parameters[known.name]
                    parameters[known.name] = one._replace(low=known.low, high=known.high)
        return told

    monkeypatch.setattr(findings, "parameters_with_intervals", wide)
    for name, left in ((term, [other]), (other, [])):
        idle.add(name)
        found = diagnose_recording(recording).diagnosis
        assert [finding.term for finding in found.findings] == left
        (note,) = (note for note in found.notes if note.startswith("found by the search, and not named"))
        assert f"{term} (" in note


@pytest.mark.parametrize("seed", [0, 8, 11])
def test_the_condition_that_wins_most_is_found_without_looking_at_all_pairs(tmp_path, seed):
    start, _, way, speed = program(3)
    case = case_of(record(tmp_path / "moves", travel(way, speed, ACCELERATION), 3)).case
    said, rng = _said(case), np.random.default_rng(seed)
    better = rng.normal(size=len(case)) + 3.0 * (seed % 2) * (start[:, 1] > 0.2)
    most, pair = max(
        (
            float(better[(said.masks[:, a] * said.masks[:, b]) > 0].sum())
            - (1 + (a != b)) * _cost(len(case)),
            (a, b),
        )
        for a in range(len(said.statements))
        for b in range(a, len(said.statements))
        if said.fair[a, b]
    )
    gain, condition = said.best(better)
    assert gain == pytest.approx(2.0 * most)
    assert set(condition.statements) == {said.statements[k] for k in pair}
    assert said.best(better, 2.0 * most + 1e-6)[0] <= 2.0 * most + 1e-6


def test_slopes_are_those_of_the_whole_model_one_value_moved_at_a_time(tmp_path):
    _, _, way, speed = program(5)
    case = case_of(record(tmp_path / "moves", travel(way, speed, 0.7 * ACCELERATION) + 0.03, 5)).case
    shelf = shelf_of(case, move_terms())
    first = {part.term.name: part for part in reversed(shelf.parts)}
    model = DurationModel(tuple(first[name] for name in ("clock", "jerk", "acceleration", "dispatch")))
    fitted = fit(model, case, Noise(0.001), 3).model
    slopes, at = slopes_of(fitted, case, Noise(0.001)), 0
    for k, part in enumerate(fitted.parts):
        for i, parameter in enumerate(part.form.parameters):
            values = part.values.copy()
            step = 1e-5 * (
                np.log(parameter.high / parameter.low) if parameter.log else parameter.high - parameter.low
            )
            values[i] = values[i] * np.exp(step) if parameter.log else values[i] + step
            parts = (*fitted.parts[:k], part._replace(values=values), *fitted.parts[k + 1 :])
            moved = (DurationModel(parts).smooth(case) - fitted.smooth(case)) / step
            assert slopes[:, at] == pytest.approx(moved, rel=1e-3, abs=1e-3 * np.abs(moved).max())
            at += 1


@pytest.mark.parametrize(
    ("turn", "memory", "drifts"), [(0.4, 0, True), (np.inf, 0, False), (np.inf, 3, False)]
)
def test_a_warm_up_leaves_no_drift_or_is_none(tmp_path, turn, memory, drifts):
    """Errors that a recorder has for some moves (`memory`) are no drift."""
    _, _, way, speed = program(11)
    plain, rng = travel(way, speed, ACCELERATION), np.random.default_rng(11)
    share = np.cumsum(plain) / plain.sum()
    drift = (
        np.exp(-share / 0.3)
        if np.isinf(turn)
        else np.where(share < turn, share / turn, (1 - share) / (1 - turn))
    )
    scatter = np.convolve(rng.normal(size=COUNT), np.ones(memory + 1) * (1 + memory), "same")
    case = case_of(record(tmp_path / "moves", plain * (1 + 0.04 * drift) + 0.002 * scatter, 11)).case
    parts = [
        p for p in shelf_of(case, move_terms()).parts if p.term.name == "warm-up" and p.form.key == "share"
    ]
    noise = Noise(0.001)
    fitted = min((fit(DurationModel((part,)), case, noise, 20) for part in parts), key=lambda f: f.bic)
    assert fitted.scale < evaluate(DurationModel(), case, noise).scale
    assert drifts_on(fitted, 0, case) == drifts


@pytest.mark.parametrize("waits", [True, False])
def test_moves_that_are_late_the_more_the_longer_they_take_do_not_wait(tmp_path, waits):
    _, _, way, speed = program(12)
    plain, rng = travel(way, speed, ACCELERATION), np.random.default_rng(12)
    batch = (np.arange(COUNT) > 40) & (np.arange(COUNT) < 75)
    late = rng.uniform(0.05, 0.3, COUNT) if waits else 0.1 * plain
    case = case_of(record(tmp_path / "moves", plain + late * batch + 0.002 * rng.normal(size=COUNT), 12)).case
    assert late_moves(evaluate(DurationModel(), case, Noise(0.001)), case, 0.001).any() == waits


def test_what_acts_in_half_of_the_moves_is_not_said_of_all(tmp_path):
    """A speed of all moves explains most of it; the others are likelier without it: it does not act there."""
    _, end, way, speed = program(13)
    where = (end[:, 1] > 0.0) & (way > 0.2)
    plain, slow = travel(way, speed, ACCELERATION), travel(way, 0.97 * speed, ACCELERATION)
    real = np.where(where, slow, plain) + 0.002 * np.random.default_rng(13).normal(size=COUNT)
    case, noise = case_of(record(tmp_path / "moves", real, 13)).case, Noise(0.001)
    part = next(p for p in shelf_of(case, move_terms()).parts if p.term.name == "speed-scale")
    found = _restricted(fit(DurationModel((part,)), case, noise, 10), case, noise, _said(case)).model.parts
    assert found[0].values == pytest.approx([0.97], abs=0.003)
    said = found[0].condition.mask(case)
    assert 2 * (said & where).sum() / (said.sum() + where.sum()) > 0.9


def test_a_small_name_that_a_few_moves_alone_show_matters(tmp_path):
    """An acceleration explains next to all of it; beside it five short moves are late by a time per move."""
    _, _, way, speed = program(14)
    few = np.arange(COUNT) >= COUNT - 5
    real = (
        travel(way, speed, 0.6 * ACCELERATION)
        + 0.06 * few
        + 0.001 * np.random.default_rng(14).normal(size=COUNT)
    )
    case, noise = case_of(record(tmp_path / "moves", real, 14)).case, Noise(0.0005)
    parts = {p.term.name: p for p in shelf_of(case, move_terms()).parts if not p.form.key}
    late = parts["dispatch"]._replace(
        condition=Condition((Statement("time", above=float(case.t_start[~few].max())),))
    )
    fewer = fit(DurationModel((parts["acceleration"],)), case, noise, 20)
    more = fit(DurationModel((parts["acceleration"], late)), case, noise, 20)
    assert fewer.scale < 1.25 * more.scale
    assert matters(fewer, more, case, 0.02)
    assert not matters(more, more, case, 0.02)


def ramped(way, speed, up, down):
    """(n,) [s] between stops at an acceleration `up` and a deceleration `down` (n,) [m/s²]."""
    slow = 1.0 / up + 1.0 / down
    peak = np.minimum(speed, np.sqrt(2.0 * way / slow))
    return way / peak + 0.5 * peak * slow


@pytest.mark.slow("41", "45")
@pytest.mark.parametrize("seed", [41, 45, 48])
def test_an_inertia_that_the_simulation_has_at_one_reach_is_one_name(seed, tmp_path):
    """As an inertia that grows from the first axis, it took an acceleration beside it."""
    start, end, way, speed = program(seed)
    near, far = ((place[:, :2] ** 2).sum(axis=1) - 0.75 for place in (start, end))
    real = ramped(way, speed, ACCELERATION / (1.0 + 0.8 * near), ACCELERATION / (1.0 + 0.8 * far))
    real += np.random.default_rng(seed).normal(0.0, 0.003, COUNT)
    found = diagnose_recording(record(tmp_path / "r", real, seed)).diagnosis
    (finding,) = found.findings
    assert finding.term == "reach-inertia"
    assert found.indistinguishable == (
        ("reach-inertia", "acceleration"),
    )  # the same law from the first axis on
    assert [(a.term, a.beside) for a in finding.alternatives if a.beside] == [("acceleration", True)]
    assert "a plainer law of this name beside acceleration" in text_report(found)
    growth, simulated = finding.parameters["growth"], finding.parameters["simulated"]
    assert growth.low < 0.8 < growth.high
    assert simulated.low < np.sqrt(0.75) < simulated.high


def test_an_inertia_of_the_whole_arm_that_is_right_at_one_reach_is_declared_the_same_beside_an_acceleration(
    tmp_path,
):
    """It has more numbers than a plainer form and an acceleration, so that none of these is as good; one that is right
    at the first axis stands for no acceleration."""
    _, _, way, speed = program(44)
    blank = case_of(record(tmp_path / "r", travel(way, speed, ACCELERATION), 44)).case
    arms = (part for part in shelf_of(blank, move_terms()).parts if part.form.key == "any arm")
    arm = next(part for part in arms if part.term.name == "reach-inertia")
    law = np.array([0.2, 0.2, -0.1, 0.5])
    from_axis, factor = arm.term.beside_acceleration(arm.form, law, blank)
    assert factor > 1.1
    for values, alike in ((law, ["acceleration"]), (from_axis, [])):
        real = DurationModel((arm._replace(values=values),)).seconds(blank)
        real += np.random.default_rng(44).normal(0.0, 0.002, COUNT)
        case, noise = replace(blank, measured=real, derived={}), Noise(0.001)
        best = fit(DurationModel((arm._replace(values=values),)), case, noise, 30)
        named = SimpleNamespace(clean=case, noise=noise, shelf=shelf_of(case, move_terms()))
        told = findings._beside_another_acceleration(best, 0, named)
        assert [(one.term, one.beside) for one in told] == [(name, True) for name in alike]


@pytest.mark.slow
def test_weight_that_only_the_starting_ramp_feels_is_one_name(tmp_path):
    """A controller that brakes by the written rate: a number for up and one for down took an acceleration beside it."""
    start, end, way, speed = program(22)
    up = ACCELERATION * (1.0 - 0.4 * (end - start)[:, 2] / way)
    real = ramped(way, speed, up, np.full(COUNT, ACCELERATION))
    real += np.random.default_rng(22).normal(0.0, 0.002, COUNT)
    (finding,) = diagnose_recording(record(tmp_path / "r", real, 22)).diagnosis.findings
    assert finding.term == "gravity"
    share = finding.parameters["share"]
    assert share.low < 0.4 < share.high
    assert "braking is as simulated" in finding.says


@pytest.mark.parametrize(("rate", "doubted"), [(1.004, True), (0.996, True), (1.03, False)])
def test_what_rounds_to_an_override_of_100_percent_is_a_clock_sooner(rate, doubted, tmp_path):
    """Without timers the durations say nothing of it, and with a few next to nothing."""
    real = rate * plain(23) + np.random.default_rng(23).normal(0.0, 0.001, COUNT)
    case, noise = case_of(record(tmp_path / "r", real, 23)).case, Noise(0.0005)
    parts = shelf_of(case, move_terms()).parts
    clock, scale = (
        next(p for p in parts if (p.term.name, p.form.key) == key)
        for key in (("clock", ""), ("speed-scale", "stretched"))
    )
    one, other = (fit(DurationModel((part,)), case, noise, 20) for part in (clock, scale))
    assert (price(other) - price(one) > other.bic - one.bic + 3.0) == doubted


@pytest.mark.slow("41", "42")
@pytest.mark.parametrize("seed", [41, 42, 43])
def test_a_small_effect_in_a_part_of_the_space_is_seen_by_coarse_stamps(seed, tmp_path):
    """2 % of the speed, stamps of 10 ms: to first order the moves that are late by most have hardly any weight."""
    _, end, way, speed = program(seed)
    where = (end[:, 1] > 0.25) & (way > 0.35)
    real = np.where(where, travel(way, 0.98 * speed, ACCELERATION), plain(seed))
    real = np.round((real + np.random.default_rng(seed).normal(0.0, 0.003, COUNT)) / 0.01) * 0.01
    toml = "time_resolution_s = 0.01\n"
    (finding,) = diagnose_recording(record(tmp_path / "r", real, seed, toml=toml)).diagnosis.findings
    assert finding.term == "speed-scale"
    assert finding.condition


@pytest.mark.slow
def test_waits_are_looked_for_again_where_a_name_that_fell_had_them(monkeypatch, tmp_path):
    _, _, way, _ = program(31)
    late = np.argsort(way)[[-1, -2, 5]]
    real = plain(31) + np.random.default_rng(31).normal(0.0, 0.0015, COUNT)
    real[late] += (0.6, 0.2, 0.4)
    recording = record(tmp_path / "r", real, 31)
    longest = Condition((Statement("length", above=float(np.sort(way)[-3] + 1e-6)),))
    found, greedy = naming._found, []

    def takes_two(clean, noise, shelf, known=None):
        if greedy:
            return found(clean, noise, shelf)
        greedy.append(next(p for p in shelf.parts if p.term.name == "dispatch")._replace(condition=longest))
        return fit(DurationModel(tuple(greedy)), clean, noise, 20)

    monkeypatch.setattr(naming, "_found", takes_two)
    monkeypatch.setattr(naming, "_ROUNDS", 1)
    told = diagnose_recording(recording).diagnosis
    assert [finding.term for finding in told.findings] == ["external-wait"]
    assert set(told.findings[0].moves) == set((late + 1).tolist())


def test_ten_moves_that_are_late_the_more_the_longer_they_take_do_not_wait(tmp_path):
    plain_times, rng = plain(25), np.random.default_rng(25)
    few = np.arange(COUNT) % 12 == 3
    for late, waits in ((0.1 * plain_times, False), (rng.uniform(0.05, 0.3, COUNT), True)):
        real = plain_times + late * few + 0.001 * rng.normal(size=COUNT)
        case = case_of(record(tmp_path / "moves", real, 25)).case
        assert late_moves(evaluate(DurationModel(), case, Noise(0.001)), case, 0.001).any() == waits


@pytest.mark.parametrize("column", ["payload_kg", "payload_inertia_kg_m2"])
def test_moves_that_are_late_the_more_the_more_they_carry_do_not_wait(column, tmp_path):
    plain_times, rng = plain(25), np.random.default_rng(25)
    few, load = np.arange(COUNT) % 8 == 3, rng.uniform(2.0, 6.0, COUNT).round(2)
    for late, waits in ((0.03 * load, False), (rng.permutation(0.03 * load), True)):
        real = plain_times + late * few + 0.001 * rng.normal(size=COUNT)
        case = case_of(record(tmp_path / "moves", real, 25, {column: load.tolist()})).case
        assert late_moves(evaluate(DurationModel(), case, Noise(0.001)), case, 0.001).any() == waits


def test_a_few_waits_that_grow_with_a_property_by_chance_are_waits(tmp_path):
    plain_times, load = plain(25), np.random.default_rng(25).uniform(2.0, 6.0, COUNT).round(2)
    few = np.arange(COUNT) % (COUNT // 5) == 3
    late = np.where(few, 0.3 + 0.01 * load, 0.0)  # all five in the order of their loads: one of 120 orders
    real = plain_times + late + 0.001 * np.random.default_rng(26).normal(size=COUNT)
    case = case_of(record(tmp_path / "moves", real, 25, {"payload_kg": load.tolist()})).case
    assert late_moves(evaluate(DurationModel(), case, Noise(0.001)), case, 0.001).sum() == few.sum()


def test_moves_that_one_axis_leads_do_not_wait(tmp_path):
    real = plain(19) + np.random.default_rng(19).normal(0.0, 0.002, COUNT)
    some = np.arange(5, COUNT, 20)
    real[some] += np.linspace(0.1, 0.6, len(some))
    case = case_of(record(tmp_path / "r", real, 19)).case
    bare = evaluate(DurationModel(), case, Noise(0.001))
    axes, names = np.arange(COUNT) % 3, tuple(f"axis {k + 1}" for k in range(4))

    def late():
        rates = Rates(np.eye(4)[axes][:, None, :], np.ones(COUNT, dtype=bool), False, names)
        return late_moves(bare, replace(case, rates=rates, derived={}), 0.001)

    assert late().sum() == len(some)
    axes[some] = 3
    assert not late().any()


def test_all_moves_between_two_places_that_are_as_late_do_not_wait(tmp_path):
    """Three moves go from about one place to about another, as no other does; or one that does is in time."""
    start, end, way, speed = program(25)
    rng = np.random.default_rng(25)
    alike, few = np.arange(10, COUNT, 35), np.zeros(COUNT)
    start[alike], end[alike] = (
        at + rng.uniform(-0.02, 0.02, (len(alike), 3)) for at in ([1.1, -0.5, 0.7], [0.6, 0.5, 0.1])
    )
    way = np.linalg.norm(end - start, axis=1)
    for late, waits in ((alike, False), (alike[:3], True), (np.array([5, 50, 90]), True)):
        few = np.isin(np.arange(COUNT), late) * (0.13 + 0.01 * rng.normal(size=COUNT))
        real = travel(way, speed, ACCELERATION) + few + 0.001 * rng.normal(size=COUNT)
        case = case_of(record(tmp_path / "moves", real, 25, made=(start, end, way, speed))).case
        assert late_moves(evaluate(DurationModel(), case, Noise(0.001)), case, 0.001).any() == waits


@pytest.mark.slow("True")
@pytest.mark.parametrize("waits", [True, False])
def test_at_one_line_of_steep_moves_times_that_differ_are_waits_and_a_law_is_none(waits, tmp_path):
    """All moves of a line go down, and some of them wait there for a signal; or all are slowed by what they carry."""
    start, end, way, _ = program(26)
    rng = np.random.default_rng(26)
    down = (start - end)[:, 2] > 0.6 * way
    load = rng.uniform(0.5, 4.0, COUNT).round(1)
    signal = np.where(rng.random(COUNT) < 0.7, 0.1 + rng.gamma(1.5, 0.1, COUNT), 0.0)
    late = down * (signal if waits else 0.06 * load)
    line = np.where(down, 9, 1 + np.arange(COUNT) % 7)
    real = plain(26) + late + 0.001 * rng.normal(size=COUNT)
    more = {"job": ["JOB1"] * COUNT, "line": line.tolist(), "payload_kg": load.tolist()}
    found = diagnose_recording(record(tmp_path / "r", real, 26, more)).diagnosis
    assert 12 <= down.sum() <= 40
    terms = {finding.term: finding for finding in found.findings}
    assert ("external-wait" in terms) == waits
    if waits:
        assert found.verdict == "explained"
        assert set(terms["external-wait"].moves) >= set((np.flatnonzero(late > 0.05) + 1).tolist())


@pytest.mark.slow("True-5-2")
@pytest.mark.parametrize(("waits", "of", "some"), [(True, 3, 1), (True, 5, 2), (False, 3, 1)])
def test_moves_to_where_parts_come_from_wait_as_it_comes_or_have_a_law_of_their_place(
    waits, of, some, tmp_path
):
    """One move of three, or two of five, go down to a place of a pallet and wait there for a part; or go against a
    hose, the more the farther out. No line is recorded that would tell them."""
    start, end, way, speed = program(27)
    rng = np.random.default_rng(27)
    there = (np.arange(COUNT) % of > 0) & (np.arange(COUNT) % of <= some)
    end[there, 2] = 0.05
    end[there, 0] = 0.5 + 0.1 * (np.arange(int(there.sum())) % 8)
    start[1:] = np.where(there[:-1, None], end[:-1], start[1:])
    way = np.linalg.norm(end - start, axis=1)
    late = there * (rng.uniform(0.05, 0.9, COUNT) if waits else 0.3 * end[:, 0] ** 2)
    real = travel(way, speed, ACCELERATION) + late + 0.002 * rng.normal(size=COUNT)
    found = diagnose_recording(record(tmp_path / "r", real, 27, made=(start, end, way, speed))).diagnosis
    terms = {finding.term: finding for finding in found.findings}
    assert ("external-wait" in terms) == waits
    if waits:
        assert (found.verdict, list(terms)) == ("explained", ["external-wait"])
        assert set(terms["external-wait"].moves) == set((np.flatnonzero(there) + 1).tolist())


def test_where_one_line_waits_none_of_its_moves_tells_of_the_arm(tmp_path):
    """Those that wait for less than is far out were called an acceleration at that line, and a clock beside it."""
    rng = np.random.default_rng(12)
    line = np.arange(COUNT) % 8 + 1
    there = line == 5
    real = (
        plain(12) + 0.08 + rng.normal(0.0, 0.012, COUNT) + np.where(there, rng.exponential(0.45, COUNT), 0.0)
    )
    lines = {"job": ["PICK"] * COUNT, "line": line.tolist()}
    found = diagnose_recording(record(tmp_path / "r", real, 12, lines)).diagnosis
    terms = {finding.term: finding for finding in found.findings}
    assert found.verdict == "explained"
    assert len(terms) == 2
    assert set(terms) & {"dispatch", "settling", "jerk"}  # a time per move, which a filter takes, too
    assert set(terms["external-wait"].moves) <= set((np.flatnonzero(there) + 1).tolist())


@pytest.mark.parametrize("seed", [21, 22, 23])
def test_one_move_that_is_far_off_hides_no_shared_time_stamps(seed, tmp_path):
    """Its echo among the next moves, or what it did to their correlation, was a pattern: "partly explained"."""
    _, _, way, speed = program(seed)
    rng = np.random.default_rng(seed)
    real = travel(way, speed, 0.7 * ACCELERATION) + np.diff(rng.normal(0.0, 0.01, COUNT + 1))
    real[50] += 0.25
    found = diagnose_recording(record(tmp_path / "r", real, seed)).diagnosis
    assert {finding.term for finding in found.findings} <= {"acceleration", "coulomb-friction"}
    assert found.verdict == "explained"


@pytest.mark.parametrize("dry", [True, False])
def test_a_planner_that_runs_dry_behind_short_moves_makes_none_of_them_wait(dry, tmp_path):
    """It lacks the next move, the more the less the one before took: twelve moves were waits, "partly explained"."""
    _, _, way, speed = program(15)
    rng = np.random.default_rng(15)
    took = travel(way, speed, ACCELERATION)
    before = np.append(np.median(took), took[:-1])
    late = 0.4 * np.maximum(np.quantile(before, 0.15) - before, 0.0) + 0.03 * (
        before < np.quantile(before, 0.15)
    )
    late = late if dry else rng.permutation(late)
    real = took + late + rng.normal(0.0, 0.002, COUNT)
    found = diagnose_recording(record(tmp_path / "r", real, 15)).diagnosis
    assert ("external-wait" in {finding.term for finding in found.findings}) != dry
    assert (found.verdict == "explained") != dry


def test_waits_at_one_line_are_seen_although_a_name_made_up_for_a_part_of_each(tmp_path):
    """All moves of the line carry a load: beside what that load was given, some were early and some late."""
    rng = np.random.default_rng(14)
    line = np.arange(COUNT) % 12 + 1
    there = line == 5
    waits = there & (rng.random(COUNT) < 0.8)
    real = plain(14) + rng.normal(0.0, 0.02, COUNT) + np.where(waits, rng.uniform(0.2, 1.4, COUNT), 0.0)
    more = {"job": ["PICK"] * COUNT, "line": line.tolist(), "payload_kg": np.where(there, 5.0, 0.0).tolist()}
    found = diagnose_recording(record(tmp_path / "r", real, 14, more)).diagnosis
    assert (found.verdict, [finding.term for finding in found.findings]) == ("explained", ["external-wait"])
    assert set(found.findings[0].moves) >= set((np.flatnonzero(waits) + 1).tolist())


@pytest.mark.parametrize(("late", "verdict"), [((20,), "explained"), ((20, 21, 22, 23), "partly-explained")])
def test_beside_a_name_one_move_that_is_far_off_is_told_and_leaves_it(late, verdict, tmp_path):
    """A recorder missed one stamp: that left all other moves "not explained"."""
    _, _, way, speed = program(6)
    real = travel(way, speed, 0.7 * ACCELERATION) + np.random.default_rng(6).normal(0.0, 0.003, COUNT)
    real[list(late)] -= 0.2
    found = diagnose_recording(record(tmp_path / "r", real, 6)).diagnosis
    assert {finding.term for finding in found.findings} <= {"acceleration", "coulomb-friction"}
    assert found.verdict == verdict
    assert any(f"move {late[0] + 1} by 2" in note for note in found.notes) == (len(late) == 1)


def test_a_short_wait_in_a_move_that_a_term_changes_much_is_no_error_of_that_term(tmp_path):
    """The arm waits at one line of the job, once for less than the weaker drives cost in that move."""
    _, _, way, speed = program(5)
    weaker = travel(way, speed, 0.5 * ACCELERATION)
    real = weaker + np.random.default_rng(5).normal(0.0, 0.001, COUNT)
    waits = np.arange(3, COUNT, 8)
    real[waits] += np.random.default_rng(6).uniform(0.15, 0.6, len(waits))
    most = waits[np.argmax((weaker - travel(way, speed, ACCELERATION))[waits])]
    real[most] = weaker[most] + 0.05
    lines = {"job": ["J"] * COUNT, "line": list(np.arange(COUNT) % 8 + 1)}
    found = diagnose_recording(record(tmp_path / "r", real, 5, lines, toml="")).diagnosis
    assert {f.term for f in found.findings} == {"acceleration", "external-wait"}
    assert found.verdict == "explained"
    assert found.heldout_after.rmse < 0.0015


def test_a_limit_of_two_numbers_that_make_up_for_each_other_is_named(tmp_path):
    """Moves that turn so little that they never get to the fastest turn tell one number of two: either may be without
    end, and both together may not."""
    rng = np.random.default_rng(5)
    turn = np.where(np.arange(COUNT) % 20 == 3, rng.uniform(0.6, 1.1, COUNT), 0.02)
    zero = np.zeros(COUNT)
    columns = {f"{a}_{end}_deg": zero for a in ("rx", "ry", "rz") for end in ("start", "end")}
    columns["rz_end_deg"] = np.degrees(turn)
    start, end, way, speed = program(5)
    way, speed = np.where(turn > 0.1, 0.1, way), np.where(turn > 0.1, 0.5, speed)
    end = start + way[:, None] * (end - start) / np.linalg.norm(end - start, axis=1)[:, None]
    whole = np.maximum(travel(way, speed, ACCELERATION), 2.0 * np.sqrt(turn / 10.0))
    real = whole + rng.normal(0.0, 0.005, COUNT)
    read = record(tmp_path / "r", real, 5, columns, made=(start, end, way, speed))
    found = diagnose_recording(read).diagnosis
    assert [finding.term for finding in found.findings] == ["orientation-limit"]
    assert found.verdict == "explained"


@pytest.mark.parametrize(("dealt", "named"), [(0, "orientation-limit"), (1, "external-wait")])
def test_a_limit_that_three_moves_reach_is_named_where_each_tells_the_others(dealt, named, tmp_path):
    """Late as their turns ask, they reach the limit; late by the same times, dealt otherwise, they wait."""
    rng = np.random.default_rng(5)
    turn = np.where(np.isin(np.arange(COUNT), (11, 47, 83)), rng.uniform(0.8, 1.6, COUNT), 0.02)
    zero = np.zeros(COUNT)
    columns = {f"{a}_{end}_deg": zero for a in ("rx", "ry", "rz") for end in ("start", "end")}
    columns["rz_end_deg"] = np.degrees(turn)
    start, end, way, speed = program(5)
    way = np.where(turn > 0.1, 0.2, way)
    end = start + way[:, None] * (end - start) / np.linalg.norm(end - start, axis=1)[:, None]
    late = np.maximum(turn / 0.7 - travel(way, speed, ACCELERATION), 0.0)
    assert (late > 0).sum() == 3
    late[late > 0] = np.roll(late[late > 0], dealt)
    real = travel(way, speed, ACCELERATION) + late + rng.normal(0.0, 0.003, COUNT)
    found = diagnose_recording(
        record(tmp_path / "r", real, 5, columns, toml="", made=(start, end, way, speed))
    ).diagnosis
    assert [finding.term for finding in found.findings] == [named]


@pytest.mark.parametrize(("gained", "waits"), [(30.0, 4), (2000.0, 0)])
def test_waits_are_set_apart_where_a_name_under_a_condition_costs_more(gained, waits, monkeypatch, tmp_path):
    """A limit in a region that holds one of four waits would have that one, and the three others seemed its flaw."""
    real = plain(6) + np.random.default_rng(6).normal(0.0, 0.003, COUNT)
    real[[5, 30, 60, 90]] += 0.3
    case, noise = case_of(record(tmp_path / "r", real, 6)).case, Noise(0.0003)
    known = evaluate(DurationModel(), case, noise)

    def found(moves, *_):
        return (
            known._replace(bic=known.bic - gained)
            if moves is case
            else evaluate(DurationModel(), moves, noise)
        )

    monkeypatch.setattr(naming, "_found", found)
    late, _ = naming._set_apart(known, case, noise, shelf_of(case, ()))
    assert late.sum() == waits


@pytest.mark.parametrize(("early", "waits"), [(0.03, 8), (0.4, 0)])
def test_moves_that_are_later_than_any_is_early_wait_beside_a_form_that_is_off(early, waits, tmp_path):
    """What other names leave is to both sides; a scatter with tails is as early as it is late."""
    rng = np.random.default_rng(6)
    real = plain(6) + rng.normal(0.0, 0.003, COUNT)
    chosen = rng.permutation(COUNT)
    real[chosen[:8]] += rng.uniform(0.1, 0.35, 8)
    real[chosen[8:14]] -= early
    case = case_of(record(tmp_path / "r", real, 6)).case
    assert late_moves(evaluate(DurationModel(), case, Noise(0.0003)), case, 0.0003).sum() == waits


@pytest.mark.parametrize(("late", "named"), [((5, 90), ["external-wait"]), ((20, 21), []), ((20,), [])])
def test_two_moves_wait_if_they_are_of_no_one_kind(late, named, tmp_path):
    """Two late moves that follow each other may be late for a reason of that place."""
    real = plain(6) + np.random.default_rng(6).normal(0.0, 0.003, COUNT)
    real[list(late)] += 0.3
    found = diagnose_recording(record(tmp_path / "r", real, 6)).diagnosis
    assert [finding.term for finding in found.findings] == named
    assert (found.verdict == "explained") == bool(named)


@pytest.mark.slow("0.008-ceil-named0", "0.04-round-named1")
@pytest.mark.parametrize(("ends", "named"), [(np.ceil, ["cycle-quantisation"]), (np.round, [])])
@pytest.mark.parametrize("cycle", [0.008, 0.04])
def test_a_cycle_that_nobody_states_is_the_controllers_where_moves_end_late(ends, named, cycle, tmp_path):
    """A recorder that looks every 8 ms is early as often as late; what half a cycle more was then named for was a
    time per move."""
    real = ends((plain(8) + np.random.default_rng(8).normal(0.0, 0.0005, COUNT)) / cycle) * cycle
    found = diagnose_recording(record(tmp_path / "r", real, 8, toml="")).diagnosis
    assert [finding.term for finding in found.findings] == named


@pytest.mark.slow("0.0")
@pytest.mark.parametrize("late", [0.0, 0.006])
def test_a_cycle_of_few_programmed_moves_may_as_well_be_half_of_it_per_move(late, tmp_path):
    """Half a cycle more, rounded to the nearest multiple, is rounded up: in ten programmed moves it may be by chance,
    and was a time per move whatever it was."""
    made = tuple(column[np.arange(COUNT) % 10] for column in program(8, 10))
    times = travel(made[2], made[3], ACCELERATION)
    real = 0.012 * (np.round((times + late) / 0.012) if late else np.ceil(times / 0.012))
    found = diagnose_recording(record(tmp_path / "r", real, 8, toml="", made=made)).diagnosis
    assert [finding.term for finding in found.findings] == ["cycle-quantisation"]
    assert found.indistinguishable == (("cycle-quantisation", "dispatch"),)
    assert found.findings[0].alternatives[0].term == "dispatch"


def test_programmed_waits_alone_that_are_late_begin_and_end_nowhere(tmp_path):
    real = plain(6) + np.random.default_rng(6).normal(0.0, 0.003, COUNT)
    late = np.isin(np.arange(COUNT), [5, 30, 60, 90])
    real[late] += 0.3
    case = case_of(record(tmp_path / "r", real, 6)).case
    case = replace(case, moving=~late)
    fitted = evaluate(DurationModel(), case, Noise(0.0003))
    assert np.array_equal(late_moves(fitted, case, 0.0003), late)


def test_waits_in_the_moves_that_a_name_does_not_change_are_told_beside_it(tmp_path):
    """In fast moves a wait is no longer than what the clamp may be off by: that none is seen there chooses no moves."""
    rng = np.random.default_rng(6)
    _, _, way, speed = program(6)
    real = travel(way, np.minimum(speed, 0.3), ACCELERATION) + rng.normal(0.0, 0.004, COUNT)
    late = rng.choice(np.flatnonzero(speed < 0.4), 16, replace=False)
    real[late] += 0.06 + rng.exponential(0.15, 16)
    found = diagnose_recording(record(tmp_path / "r", real, 6)).diagnosis
    waits = next(finding for finding in found.findings if finding.term == "external-wait")
    assert set(waits.moves) >= set((late + 1).tolist())
    assert found.verdict == "explained"


@pytest.mark.slow("False")
@pytest.mark.parametrize("nearest", [False, True])
def test_what_is_rounded_alike_is_no_drift_beside_a_warm_up(nearest, tmp_path):
    """Cold grease takes a fifth of the acceleration; moves of a cycle are alike, and the clock shows 10 ms."""
    start, end, way, _ = program(7)
    cycle = np.arange(COUNT) % 12
    made = start[cycle], end[cycle], way[cycle], np.where(cycle % 3, 0.5, 0.8)
    sim = travel(made[2], made[3], ACCELERATION)
    cold = np.exp(-np.cumsum(sim + 0.2) / 60.0)
    real = travel(made[2], made[3], ACCELERATION * (1.0 - 0.25 * cold))
    real = np.round(real + nearest * 0.002, 2)
    found = diagnose_recording(record(tmp_path / "r", real, 7, toml="", made=made)).diagnosis
    warm = next(finding for finding in found.findings if finding.term == "warm-up")
    assert "ramps" in warm.says
    assert 0.15 < warm.parameters["share"].low < warm.parameters["share"].high < 0.35


def test_waits_that_end_between_two_cycles_do_not_hide_the_cycle_of_the_moves(tmp_path):
    rng = np.random.default_rng(8)
    _, _, way, speed = program(8)
    sim = travel(way, speed, ACCELERATION)
    still = np.arange(COUNT) % 6 == 5
    real = np.where(still, 0.35, np.ceil(sim / 0.024) * 0.024) + rng.normal(0.0, 0.0005, COUNT)
    folder = tmp_path / "r"
    record(folder, real, 8)
    table = list(csv.reader((folder / "moves.csv").read_text(encoding="utf-8").splitlines()))
    at = {name: k for k, name in enumerate(table[0])}
    for row, waits in zip(table[1:], still, strict=True):
        if waits:
            row[at["sim_s"]] = "0.35"
        row.append("wait" if waits else "linear")
    table[0].append("type")
    with open(folder / "moves.csv", "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(table)
    found = diagnose_recording(read_recording(str(folder))).diagnosis
    assert [finding.term for finding in found.findings] == ["cycle-quantisation"]
    assert found.findings[0].says == "durations of motion are whole multiples of 24 ms"
    assert found.verdict == "explained"


def test_where_all_moves_stop_a_filter_behind_the_planner_is_declared_alike(tmp_path):
    real = plain(9) + 0.08 + np.random.default_rng(9).normal(0.0, 0.003, COUNT)
    found = diagnose_recording(record(tmp_path / "r", real, 9)).diagnosis
    assert len(found.findings) == 1
    assert {"dispatch", "settling", "jerk"} <= set().union(*found.indistinguishable)
    assert len(found.indistinguishable) == len(set(found.indistinguishable))


def test_residuals_that_are_the_same_digits_have_no_order_by_what_no_clock_shows(tmp_path):
    """A cycle that is off by less than its own error ranks residuals by their length; all are one of a few digits."""
    case = case_of(record(tmp_path / "r", plain(10), 10)).case
    rng = np.random.default_rng(10)
    digits = np.round(rng.standard_t(3, COUNT)) * 1e-3
    left = digits - 1e-5 * case.simulated
    assert not remains_of(left, case, {}).correlates
    assert remains_of(left - 1e-3 * case.simulated, case, {}).correlates


def test_two_far_moves_near_each_other_are_no_pattern(tmp_path):
    case = case_of(record(tmp_path / "r", plain(11), 11)).case
    left = np.random.default_rng(11).normal(0.0, 0.001, COUNT)
    left[[40, 43]] = 0.012
    assert "previous moves" not in {look.column for look in remains_of(left, case, {}).correlates}
