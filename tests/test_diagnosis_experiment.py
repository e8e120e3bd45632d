"""The experiment that tells rivals apart: against brute force and simulated measurements, and as a job."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import recordings

import olp
from olp.core.diagnostic import OlpError
from olp.core.units import mm
from olp.identification.diagnosis import next_experiment
from olp.identification.diagnosis.axis_rates import rates_of
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.diagnosis.next_candidates import candidates, joined
from olp.identification.diagnosis.next_experiment import design_experiment
from olp.identification.diagnosis.next_job import write_experiment_job
from olp.identification.diagnosis.result import NextExperiment, NextTimer
from olp.identification.recorded_plan import case_of
from olp.identification.recording import read_recording
from olp.ir.program import Dwell, Move
from olp.runtime.plan import BlendCode, StepKind
from olp.timing.physics import load_term

NOISE = 0.005


@pytest.fixture(scope="module")
def up20():
    recording = read_recording("samples/up20")
    return recording, case_of(recording).case


@pytest.fixture(scope="module")
def runs(up20):
    recording, case = up20
    return candidates(case, recording, ())


def model(case, *parts):
    """(name, values[, form]) each."""
    made = []
    for name, values, *key in parts:
        term = load_term(name)
        fitting = (f for f in term.forms(case) if len(f.parameters) == len(values))
        form = next(f for f in fitting if not key or f.key == key[0])
        made.append(ModelPart(term, form, np.array(values, dtype=float)))
    return DurationModel(tuple(made))


def settling_and_dispatch(case):
    return [model(case, ("settling", [0.05])), model(case, ("dispatch", [0.05]))]


def test_settling_and_dispatch_are_told_apart_by_corners_with_and_without_rounding(up20):
    recording, case = up20
    found = design_experiment(case, settling_and_dispatch(case), NOISE, recording)
    assert found.why.startswith("settling and dispatch differ only when corners are blended: run these")
    assert "with and without rounding (CNT, PL)" in found.why
    assert any(move.blend > 0 for move in found.moves)
    assert any(move.blend == 0 and "exact stop" in move.why for move in found.moves)
    assert next_experiment.FEWEST <= len(found.moves) <= next_experiment.MOST


def test_jerk_and_settling_are_told_apart_though_they_agree_on_all_recorded_moves(up20):
    recording, case = up20
    rivals = [model(case, ("jerk", [8.0])), model(case, ("settling", [0.05]))]
    assert np.abs(rivals[0].smooth(case) - rivals[1].smooth(case)).max() < NOISE
    found = design_experiment(case, rivals, NOISE, recording)
    assert found.moves
    assert any(word in found.why for word in ("slow", "short", "blended"))


def test_moves_lie_in_the_recorded_box_and_are_no_faster_than_the_axes_allow(up20):
    recording, case = up20
    rivals = [model(case, ("gravity", [0.3], "both ramps")), model(case, ("reach-inertia", [0.6]))]
    found = design_experiment(case, rivals, NOISE, recording)
    ends = np.concatenate([case.start, case.end])
    points = np.array([p for move in found.moves for p in (move.start, move.end)])
    assert np.all(points >= ends.min(axis=0) - 1e-6)
    assert np.all(points <= ends.max(axis=0) + 1e-6)
    for move in found.moves:
        assert 0 < move.speed <= 1.5 * case.base.speed.max() + 1e-9
        assert 1 <= move.times <= 5


def test_the_chosen_moves_decide_between_rivals_in_simulated_measurements(up20, runs):
    recording, case = up20
    rivals = [model(case, ("acceleration", [0.7])), model(case, ("settling", [0.12]))]
    found = design_experiment(case, rivals, NOISE, recording)
    wrong = [_decided_wrong(case, runs, rivals, found.moves, truth) for truth in (0, 1)]
    assert max(wrong) <= 0.01


def _decided_wrong(case, runs, rivals, moves, truth):
    """Share of 400 measurements, with scatter and a common offset, that the other rival fits better."""
    said = np.array([_seconds(case, runs, rival, moves) for rival in rivals])
    generator = np.random.default_rng(1)
    wrong = 0
    for _ in range(400):
        measured = said[truth] + generator.normal(0, 5 * NOISE) + generator.normal(0, NOISE, len(moves))
        left = measured - said
        wrong += int(np.argmin((left - left.mean(axis=1, keepdims=True)).var(axis=1)) != truth)
    return wrong / 400


def _seconds(case, runs, rival, moves):
    """[s] of each proposed move, by the candidate it was."""
    rows = []
    for move in moves:
        apart = np.abs(runs.case.start - move.start).max(axis=1) + np.abs(runs.case.end - move.end).max(
            axis=1
        )
        apart += np.abs(runs.case.base.speed - move.speed) + np.abs(runs.case.blend - move.blend)
        rows.append(int(np.argmin(apart)))
        assert apart.min() < 1e-5
    return rival.smooth(joined(case, runs.case.take(np.array(rows))))[len(case) :]


def random_runs(seed, count=9, width=3):
    generator = np.random.default_rng(seed)
    return generator.normal(0, 0.02, count), generator.normal(0, 0.004, (count, width)), np.ones(count, int)


def brute(apart, spread, rows, chosen):
    at = list(chosen)
    covariance = spread[at] @ spread[at].T + (5 * NOISE) ** 2 * np.outer(rows[at], rows[at])
    covariance += NOISE**2 * np.diag(rows[at])
    return apart[at] @ np.linalg.inv(covariance) @ apart[at]


def test_a_gain_is_what_the_criterion_grows_by():
    for seed in range(5):
        apart, spread, rows = random_runs(seed)
        gains = next_experiment._gains(apart, spread, rows, NOISE, [0, 3])
        for run in (1, 2, 5):
            grown = brute(apart, spread, rows, [0, 3, run]) - brute(apart, spread, rows, [0, 3])
            assert gains[run] == pytest.approx(grown, rel=1e-6)
        assert next_experiment._separation(apart, spread, rows, NOISE, [0, 3]) == pytest.approx(
            brute(apart, spread, rows, [0, 3])
        )


def test_the_choice_is_nearly_the_best_of_all_choices_of_as_many_runs(runs):
    single = np.nonzero(np.bincount(runs.run) == 1)[0][:9]
    few = next_experiment.taken(runs, single)
    for seed in range(4):
        apart, spread, rows = random_runs(seed)
        chosen, reached = next_experiment._chosen(few, np.arange(9), 0.3 * apart[None], [spread], NOISE)
        best = max(brute(0.3 * apart, spread, rows, c) for c in combinations(range(9), len(chosen)))
        assert reached >= 0.8 * best


def test_parts_of_lines_turn_the_axes_as_the_same_moves_recorded_would(runs, tmp_path):
    some = np.linspace(0, len(runs.case) - 1, 25).astype(int)
    part = runs.case.take(some)
    names = ("move", "duration_s", *(f"{c}_{e}_mm" for e in ("start", "end") for c in "xyz"))
    names += ("rx_deg", "ry_deg", "rz_deg", "speed_mm_s")
    rows = [
        dict(zip(names, map(str, [i, 1.0, *(start / mm), *(end / mm), 180, -90, 0, 300]), strict=True))
        for i, (start, end) in enumerate(zip(part.start, part.end, strict=True))
    ]
    recordings.write(tmp_path, 'robot = "yaskawa/up20"\n', "recording.toml")
    told = recordings.read(tmp_path, recordings.table(*rows))
    rates, _ = rates_of(told, np.arange(25), told.moves.chord)
    # Between the places where the whole line was looked at the rates are interpolated.
    off, scale = np.abs(part.rates.path - rates.path), np.abs(rates.path).max()
    assert off.max() < 0.05 * scale
    assert off.mean() < 0.002 * scale


def test_rivals_that_agree_on_every_move_get_no_experiment(up20):
    recording, case = up20
    same = [model(case, ("settling", [0.05])), model(case, ("settling", [0.0501]))]
    found = design_experiment(case, same, NOISE, recording)
    assert found.moves == ()
    assert "nothing" in found.why or "no straight move" in found.why
    with pytest.raises(OlpError) as problem:
        write_experiment_job(found, recording, "nowhere.jbi")
    assert problem.value.diagnostics[0].code == "N040"


def test_one_explanation_needs_no_experiment(up20):
    recording, case = up20
    assert design_experiment(case, settling_and_dispatch(case)[:1], NOISE, recording).moves == ()


def test_without_tool_points_the_answer_says_what_is_missing(tmp_path):
    rows = [
        {"move": str(i), "duration_s": "1.1", "sim_s": "1.0", "type": "joint", "speed_pct": "50"}
        | {
            f"q{k}_{e}_deg": str(10 * k + i + 30 * (e == "end"))
            for k in range(1, 7)
            for e in ("start", "end")
        }
        for i in range(12)
    ]
    recording = recordings.read(tmp_path, recordings.table(*rows))
    case = case_of(recording).case
    found = design_experiment(case, settling_and_dispatch(case), NOISE, recording)
    assert found.moves == ()
    assert "tool points" in found.why


def test_three_rivals_are_all_told_apart(up20, runs):
    recording, case = up20
    rivals = [*settling_and_dispatch(case), model(case, ("acceleration", [0.85]))]
    found = design_experiment(case, rivals, NOISE, recording)
    said = np.array([_seconds(case, runs, rival, found.moves) for rival in rivals])
    for first, second in combinations(said, 2):
        difference = first - second
        assert np.linalg.norm(difference - difference.mean()) > 3 * NOISE


def test_warm_up_is_told_by_the_same_moves_cold_and_warm(up20, tmp_path):
    recording, _ = up20
    lines = [line.split(",") for line in Path("samples/up20/moves.csv").read_text().splitlines()]
    text = "".join(
        ",".join([*cells, "t_start_s" if i == 0 else str(20.0 * i)]) + "\n" for i, cells in enumerate(lines)
    )
    recordings.write(tmp_path, 'robot = "yaskawa/up20"\n', "recording.toml")
    recording = recordings.read(tmp_path, text)
    case = case_of(recording).case
    rivals = [model(case, ("warm-up", [0.03, 600.0], "share")), model(case, ("speed-scale", [1.01]))]
    found = design_experiment(case, rivals, NOISE, recording)
    assert any("while the robot is cold" in move.why for move in found.moves)
    assert any("after hours" in move.why for move in found.moves)
    file = tmp_path / "next.jbi"
    write_experiment_job(found, recording, file)
    assert b"PAUSE" in file.read_bytes()


def test_the_job_runs_the_moves_that_were_designed(up20, tmp_path):
    recording, case = up20
    found = design_experiment(case, settling_and_dispatch(case), NOISE, recording)
    told = write_experiment_job(found, recording, tmp_path / "next.jbi")
    assert all(d.code == "N041" for d in told)
    assert any("tool" in d.message for d in told)
    program = olp.read(str(tmp_path / "next.jbi"))
    assert not [d for d in program.diagnostics if d.is_error]
    plan = program.plan(recording.robot)
    rows = plan.row[plan.kind == StepKind.MOVE]
    moves, places = plan.moves, plan.positions.position
    run = {
        (
            *np.round(places[moves.start[r]], 5).tolist(),
            *np.round(places[moves.target[r]], 5).tolist(),
            round(float(moves.travel[r]), 4),
            bool(moves.blend_code[r] != BlendCode.EXACT),
        )
        for r in rows[1:]
    }
    for move in found.moves:
        assert (
            *np.round(move.start, 5).tolist(),
            *np.round(move.end, 5).tolist(),
            round(move.speed, 4),
            move.blend > 0,
        ) in run
    # All of them start and end at rest, but for the rounded point between two halves.
    assert sum(move.times for move in found.moves) <= len(rows)


def test_the_tool_does_not_turn_on_a_run_of_the_job(tmp_path):
    rows = [cells | {"x_end_mm": "900", "sim_s": "9.0"} for cells in recordings.moves(14, speed_mm_s="250")]
    for i, cells in enumerate(rows):
        cells |= {"rx_start_deg": str(150 + 2 * i), "ry_start_deg": str(i), "rz_start_deg": "0"}
        cells |= {"rx_end_deg": str(150 - 2 * i), "ry_end_deg": "0", "rz_end_deg": str(i)}
    recording = recordings.read(tmp_path, recordings.table(*rows))
    case = case_of(recording).case
    rivals = [model(case, ("settling", [0.5])), model(case, ("dispatch", [0.5]))]
    write_experiment_job(design_experiment(case, rivals, NOISE, recording), recording, tmp_path / "next.jbi")
    text = (tmp_path / "next.jbi").read_text()
    turned = {line.split("=")[0]: line.split(",")[3:] for line in text.splitlines() if line.startswith("C0")}
    passed = [next((w for w in line.split() if w in turned), line) for line in text.splitlines()]
    begins = [i for i, word in enumerate(passed) if word.startswith("'measured")]
    assert begins
    for begin in begins:
        # The point before the comment, and those between the two rests behind it.
        stop = next(i for i in range(begin + 2, len(passed)) if passed[i].startswith("TIMER"))
        run = [passed[begin - 1], *passed[begin + 2 : stop]]
        assert len({tuple(turned[point]) for point in run}) == 1


def test_a_recording_without_orientation_gets_no_job(tmp_path):
    rows = [cells | {"x_end_mm": "900", "sim_s": "9.0"} for cells in recordings.moves(14, speed_mm_s="250")]
    recording = recordings.read(tmp_path, recordings.table(*rows))
    case = case_of(recording).case
    rivals = [model(case, ("settling", [0.5])), model(case, ("dispatch", [0.5]))]
    found = design_experiment(case, rivals, NOISE, recording)
    assert found.moves
    with pytest.raises(OlpError) as problem:
        write_experiment_job(found, recording, tmp_path / "next.jbi")
    assert problem.value.diagnostics[0].code == "N040"
    assert "orientation" in problem.value.diagnostics[0].message


def test_a_timer_alone_parts_a_clock_from_a_speed(up20):
    recording, case = up20
    rivals = [model(case, ("clock", [1.008])), model(case, ("speed-scale", [1 / 1.008], "stretched"))]
    found = design_experiment(case, rivals, NOISE, recording)
    short, long = found.timers
    told = 0.008 * (long.duration - short.duration) * np.sqrt(long.times / 2.0)
    assert told > 5.0 * NOISE
    assert not design_experiment(case, settling_and_dispatch(case), NOISE, recording).timers
    both = [model(case, ("clock", [1.008]), (name, [0.05])) for name in ("settling", "dispatch")]
    assert not design_experiment(case, both, NOISE, recording).timers


@pytest.mark.slow("mod", "ls")
@pytest.mark.parametrize("suffix", ["src", "mod", "ls", "script"])
def test_the_job_is_written_in_the_language_of_the_suffix(suffix, up20, tmp_path):
    recording, case = up20
    found = design_experiment(case, settling_and_dispatch(case), NOISE, recording)
    timers = (NextTimer(1.0, 2), NextTimer(6.0, 2))
    texts = []
    for name in (f"again.{suffix}", "again.jbi"):
        file = tmp_path / name
        write_experiment_job(NextExperiment(found.why, found.moves, timers), recording, file)
        program = olp.read(str(file))
        assert not [d for d in program.diagnostics if d.is_error]
        texts.append(program)
    moves, dwells = (
        [sum(isinstance(s, kind) for r in program.routines for s in r.body) for program in texts]
        for kind in (Move, Dwell)
    )
    assert moves[0] == moves[1] > 0
    assert dwells[0] == dwells[1] >= 4
    assert texts[0].vendor == {"src": "krl", "mod": "rapid", "ls": "tp", "script": "urscript"}[suffix]


def test_timers_alone_make_a_job_that_moves_nothing(up20, tmp_path):
    recording, _ = up20
    file = tmp_path / "next.jbi"
    write_experiment_job(NextExperiment("timers", (), (NextTimer(5.0, 3),)), recording, file)
    body = [s for r in olp.read(str(file)).routines for s in r.body]
    assert sum(isinstance(s, Dwell) for s in body) == 3
    assert not any(isinstance(s, Move) for s in body)
