"""Signatures from partial data: totals of programs, repeated cycles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.identification.recording import read_recording
from olp.identification.signature import MoveSet, calibrate, moves_of_recording, predict, read_signature
from olp.identification.signature.errors import ErrorModel, Spread
from olp.identification.signature.estimator import duration_of, load_estimator, measured_slowness
from olp.identification.signature.learn import average_cycles, with_scatter
from olp.identification.signature.mixture import Observations, Views, answer, average_covariance, ruler_of
from olp.identification.signature.partial_programs import (
    fit_totals,
    gather,
    predicted_totals,
    read_totals,
    signature_of_totals,
    stops_of,
)
from olp.reports.batch import Job, plan_and_time
from olp.robots.robot import load_robot

UP20 = load_robot("yaskawa/up20")
MEASURED = moves_of_recording(read_recording("samples/up20"))[0]


def with_duration(moves: MoveSet, duration: np.ndarray) -> MoveSet:
    return MoveSet(
        moves.start,
        moves.end,
        moves.rotation,
        moves.speed,
        moves.nominal,
        duration,
        moves.payload,
        moves.configuration,
        moves.program,
        moves.tool,
    )


def strings(count: int, size: int, seed: int = 0, waits: float = 2.0):
    """Programs of measured moves and their exact totals."""
    dice = np.random.default_rng(seed)
    picked = [dice.choice(len(MEASURED), size, replace=False) for _ in range(count)]
    total = np.array([MEASURED.duration[p].sum() + waits for p in picked])
    return gather([(MEASURED.take(p), waits) for p in picked], total)


# --- the process -----------------------------------------------------------------------------------------------


def test_sums_of_one_move_are_single_values():
    dice = np.random.default_rng(1)
    views = Views(dice.normal(size=(12, 6)), dice.normal(size=(12, 3)))
    values = np.sin(views.places[:, 0]) + 2
    single = Observations(values, np.arange(12), np.ones(12))
    order = dice.permutation(12)
    shuffled = Observations(values, order, np.ones(12))
    wanted = Views(dice.normal(size=(5, 6)), dice.normal(size=(5, 3)))
    one = answer(views, single, ruler_of(views), wanted)
    other = answer(views.take(order), shuffled, ruler_of(views), wanted)
    np.testing.assert_allclose(one.mean, other.mean, rtol=1e-7)
    np.testing.assert_allclose(one.sd, other.sd, rtol=1e-5)


def test_a_level_function_is_found_from_sums_and_doubt_grows_away_from_them():
    dice = np.random.default_rng(2)
    views = Views(dice.normal(size=(20, 6)), np.zeros((20, 0)))
    owner, share = np.arange(20) // 2, dice.uniform(0.5, 2, 20)
    seen = Observations(np.bincount(owner, 3.0 * share), owner, share)
    far = Views(np.full((1, 6), 40.0), np.zeros((1, 0)))
    near = answer(views, seen, ruler_of(views), views)
    np.testing.assert_allclose(near.mean, 3.0, atol=1e-6)
    assert answer(views, seen, ruler_of(views), far).sd[0] >= near.sd.max()


def test_the_average_covariance_can_be_one():
    views = Views(MEASURED.start.repeat(2, axis=1)[:40], np.zeros((40, 2)))
    matrix = average_covariance(views, views, ruler_of(views))
    np.testing.assert_allclose(matrix, matrix.T)
    assert np.linalg.eigvalsh(matrix).min() > -1e-6


def test_few_moves_come_back_through_their_parameters():
    estimator = load_estimator("averaged_process")
    few = MEASURED.take(np.arange(0, 146, 6))
    said = estimator.estimate(estimator.fit(few, UP20), few, UP20)
    assert np.median(np.abs(duration_of(said.slowness, few) / few.duration - 1)) < 0.004
    assert "at most" in estimator.needs(MEASURED, UP20)
    assert estimator.needs(few, None)


# --- totals ----------------------------------------------------------------------------------------------------


def test_thirty_totals_predict_moves_that_were_never_measured():
    learnt = strings(30, 4)
    parameters = fit_totals(learnt, UP20)
    other = strings(40, 4, seed=9)
    error = np.abs(predicted_totals(parameters, other, UP20) / other.total - 1)
    assert np.median(error) < 0.01


def test_totals_of_single_moves_are_the_moves():
    rows = np.arange(0, 146, 8)
    alone = gather([(MEASURED.take(np.array([i])), 1.5) for i in rows], MEASURED.duration[rows] + 1.5)
    few = MEASURED.take(rows)
    direct = load_estimator("averaged_process").fit(few, UP20)
    said = load_estimator("averaged_process").estimate(direct, MEASURED, UP20).slowness
    summed = load_estimator("averaged_process").estimate(fit_totals(alone, UP20), MEASURED, UP20).slowness
    # Only the level differs: it is told by the speeds, which are all the same here.
    np.testing.assert_allclose(summed, said, rtol=1e-3)


def test_totals_say_how_sure_they_are():
    signature = signature_of_totals(strings(30, 4), UP20)
    said = predict(signature, MEASURED, UP20)
    covered = (said.low <= MEASURED.duration) & (MEASURED.duration <= said.high)
    assert covered.mean() > 0.93
    assert np.median(said.high - said.low) < 0.6


def test_too_few_programs_are_told():
    with pytest.raises(OlpError) as raised:
        signature_of_totals(strings(3, 4), UP20)
    assert raised.value.diagnostics[0].code == "H032"


def test_a_plan_gives_its_straight_moves_and_the_rest():
    timing = plan_and_time("samples/up20/APPR-L.JBI", Job())
    moves, rest = stops_of(timing)
    assert len(moves) == 30
    assert rest + np.sum(timing.duration_s[1:]) == pytest.approx(timing.total_s)
    np.testing.assert_allclose(moves.length[0], 0.64)


def table(folder, rows):
    text = "job,total_s\n" + "".join(f"{job},{total}\n" for job, total in rows)
    (folder / "totals.csv").write_text(text)
    return folder / "totals.csv"


def test_the_command_makes_a_signature_of_the_sample_jobs(tmp_path, capsys):
    jobs = sorted(Path("samples/up20").resolve().glob("*.JBI"))
    rows = [(job, 1.08 * plan_and_time(str(job), Job()).total_s + off) for job in jobs for off in (0, 0.2)]
    output = tmp_path / "up20.json"
    assert main(["signature", "from-totals", str(table(tmp_path, rows)), "-o", str(output)]) == 0
    out = capsys.readouterr().out
    assert "9 totals of 292 straight moves" in out
    assert "scatter by 0.141 s" in out
    signature = read_signature(output)
    assert signature.method == "averaged_process"
    totals = [predict(signature, stops_of(plan_and_time(str(job), Job()))[0]).duration.sum() for job in jobs]
    np.testing.assert_allclose(totals, [rows[2 * i][1] + 0.1 for i in range(9)], rtol=0.01)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "job\nA.JBI\n",
        "job,total_s\n",
        "job,total_s\nA.JBI,-3\n",
        "job,total_s\n,4\n",
        "job,total_s\nA,x\n",
    ],
)
def test_a_table_that_cannot_be_ends_with_2(text, tmp_path, capsys):
    (tmp_path / "totals.csv").write_text(text)
    assert main(["signature", "from-totals", str(tmp_path / "totals.csv"), "-o", str(tmp_path / "x")]) == 2
    assert "error[H030]" in capsys.readouterr().err


def test_every_bad_row_is_told(tmp_path):
    with pytest.raises(OlpError) as raised:
        read_totals(table(tmp_path, [("A.JBI", -1), ("B.JBI", 3), ("", 4)]))
    assert [d.line for d in raised.value.diagnostics] == [2, 4]


# --- cycles ----------------------------------------------------------------------------------------------------


def repeated(times: int, noise: float, seed: int = 4) -> MoveSet:
    dice = np.random.default_rng(seed)
    rows = np.tile(np.arange(0, 146, 3), times)
    moves = MEASURED.take(rows)
    return with_duration(moves, moves.duration + noise * dice.normal(size=len(rows)))


def test_cycles_are_averaged_in_the_order_of_first_use():
    cycles = average_cycles(repeated(5, 0.02))
    first = MEASURED.take(np.arange(0, 146, 3))
    np.testing.assert_array_equal(cycles.moves.start, first.start)
    np.testing.assert_array_equal(cycles.moves.end, first.end)
    assert set(cycles.runs.tolist()) == {5}
    assert cycles.scatter * 0.3 == pytest.approx(0.02, rel=0.15)
    assert np.std(cycles.moves.duration - first.duration) == pytest.approx(0.02 / 5**0.5, rel=0.3)


def test_without_repeats_nothing_changes():
    cycles = average_cycles(MEASURED)
    assert cycles.moves is MEASURED
    assert cycles.scatter == 0
    errors = ErrorModel(Spread(1.0, 0.5, 0.5, 3), Spread(2.0, 0.5, 0.5, 3))
    assert with_scatter(errors, cycles) is errors


def test_the_noise_of_one_run_widens_what_the_means_were_held_out_with():
    cycles = average_cycles(repeated(4, 0.03))
    errors = ErrorModel(Spread(0.01, 0.0, 0.005, 3), Spread(0.02, 0.0, 0.01, 3))
    wide = with_scatter(errors, cycles)
    missing = cycles.scatter * (1 - 1 / 4) ** 0.5
    assert wide.near.half == pytest.approx(np.hypot(0.01, 1.96 * missing))
    assert wide.far.own == pytest.approx(np.hypot(0.01, missing))


def test_slowness_is_finite_for_all_measured_moves():
    assert np.isfinite(measured_slowness(MEASURED)).all()


def test_calibrate_learns_from_the_means_of_cycles(tmp_path):
    rows = Path("samples/up20/moves.csv").read_text().splitlines()
    names = rows[0].split(",")
    at = names.index("duration_s")
    lines = [rows[0]]
    dice = np.random.default_rng(0)
    for _ in range(3):
        for row in rows[1::4]:
            cells = row.split(",")
            cells[0] = str(len(lines))
            cells[at] = f"{float(cells[at]) + 0.03 * dice.normal():.3f}"
            lines.append(",".join(cells))
    (tmp_path / "moves.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "recording.toml").write_text('robot = "yaskawa/up20"\n')
    recording = read_recording(tmp_path)
    signature, told = calibrate(recording, "gaussian_process")
    assert "H033" in {d.code for d in told}
    assert signature.recording.moves == 37
    said = predict(signature, moves_of_recording(recording)[0])
    duration = recording.moves.duration
    assert np.mean((said.low <= duration) & (duration <= said.high)) > 0.9


def test_a_joint_log_of_a_probes_job_becomes_a_signature(tmp_path):
    box = ["--box", "710,1350,0,700,100,740", "--orientation", "180,-90,0"]
    probe = tmp_path / "probe"
    assert main(["probe", "--robot", "yaskawa/up20", "--moves", "6", *box, "-o", str(probe)]) == 0
    job, log = str(probe / "PROBE.JBI"), tmp_path / "track.csv"
    assert main(["track", job, "--robot", "yaskawa/up20", "--dt", "0.008", "-o", str(log)]) == 0
    rows = [row.split(",") for row in log.read_text().splitlines()]
    kept = [i for i, name in enumerate(rows[0]) if name == "t_s" or name.startswith("q")]
    text = "".join(",".join(row[i] for i in kept) + "\n" for row in rows)
    (tmp_path / "log.csv").write_text(text)
    made = tmp_path / "made"
    line = [
        "recording",
        "from-log",
        str(tmp_path / "log.csv"),
        job,
        "--robot",
        "yaskawa/up20",
        "-o",
        str(made),
    ]
    assert main(line) == 0
    signature, _ = calibrate(read_recording(made), "averaged_process")
    moves, _ = moves_of_recording(read_recording(probe))
    said = predict(signature, moves, UP20)
    # The log was made at olp's own 400 mm/s².
    np.testing.assert_allclose(said.duration, moves.length / 0.3 + 0.3 / 0.4, rtol=0.002)
