"""A log made of a program's own track, with noise, lost samples and another clock, gives the program's times back."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.core.units import mm
from olp.identification.recording import Log, read_recording
from olp.identification.recording.from_log import fit_clock, moves_from_log
from olp.identification.recording.programmed import moved
from olp.identification.recording.segments import pass_by, rest, stillness
from olp.identification.recording.writer import log_csv
from olp.reports.batch import Job, plan_and_time
from olp.timing.track import track

ROOT = Path(__file__).parent.parent
FAN = "samples/up20/APPR-1.JBI"
CORNERS = "samples/inform/generations/dx200.jbi"
CAM = "samples/inform/cam/FINISH.JBI"
OFFSET, RATE = 1234.5, 1.0004


@cache
def timed(job):
    return plan_and_time(str(ROOT / job), Job())


def log_of(job, dt, noise=0.0, lost=0.03, lead=1.0, seed=0, extra=()):
    """A log of one run: at rest for `lead` [s] at both ends, `noise` [rad] on every axis, a share `lost` of samples."""
    timing = timed(job)
    rng = np.random.default_rng(seed)
    way = track(timing, dt)
    count = round(lead / dt)
    before, after = -dt * np.arange(count, 0, -1), way.time[-1] + dt * np.arange(1, count + 1)
    time = np.concatenate([before, way.time, after])
    q = np.concatenate(
        [np.repeat(way.axes[:1], count, 0), way.axes, np.repeat(way.axes[-1:], count, 0), *extra]
    )
    time = np.concatenate([time, *(time[-1] + dt * np.arange(1, len(part) + 1) for part in extra)])
    kept = rng.random(len(time)) >= lost
    return Log(OFFSET + RATE * time[kept], (q + noise * rng.normal(size=q.shape))[kept], way.linear)


@pytest.mark.slow(
    "samples/up20/APPR-1.JBI-0.008-2e-05",
    "samples/up20/APPR-1.JBI-0.046-2e-05",
    "samples/inform/generations/dx200.jbi-0.004-0.0",
    "samples/inform/generations/dx200.jbi-0.046-2e-05",
)
@pytest.mark.parametrize(
    ("job", "dt", "noise"),
    [(FAN, 0.004, 0.0), (FAN, 0.008, 2e-5), (FAN, 0.046, 2e-5), (CORNERS, 0.004, 0.0), (CORNERS, 0.008, 2e-5),
     (CORNERS, 0.046, 2e-5), ("samples/inform/generations/nx100.jbi", 0.008, 2e-5)],
)  # fmt: skip
def test_durations_are_recovered_within_a_sample(job, dt, noise):
    found = moves_from_log(log_of(job, dt, noise), timed(job))
    runs = found.moves.kind != 3
    assert runs.sum() == len(moved(timed(job)))
    assert np.abs(found.moves.duration / RATE - found.planned).max() < dt
    assert found.by == "points"


@pytest.mark.slow
def test_a_thousand_short_moves_are_recovered_without_bias():
    found = moves_from_log(log_of(CAM, 0.008, 2e-5), timed(CAM))
    off = found.moves.duration / RATE - found.planned
    assert len(found.moves) == len(moved(timed(CAM))) == 3149
    assert np.abs(off).max() < 2 * 0.008
    assert abs(off.sum()) < 0.008


@pytest.mark.parametrize("job", [FAN, CORNERS])
def test_offset_and_rate_of_the_clock_are_recovered_within_their_uncertainty(job):
    clock = moves_from_log(log_of(job, 0.004, 1e-5), timed(job)).clock
    assert abs(clock.offset - OFFSET) < 5 * clock.offset_error + 1e-4
    assert abs(clock.rate - RATE) < 5 * clock.rate_error + 1e-6
    assert clock.rate_error < 1e-3


def test_rows_say_what_was_programmed():
    timing = timed(CORNERS)
    found = moves_from_log(log_of(CORNERS, 0.004), timing).moves
    assert found.line.tolist() == [27, 30, 31, 32, 34, 30, 31, 32, 34, 40]
    assert found.kinds == ("linear",) * 4 + ("wait",) + ("linear",) * 3 + ("wait", "joint")
    assert found.speed[0] == pytest.approx(270 * mm)
    assert found.speed_fraction[-1] == pytest.approx(0.625)
    assert found.acceleration_fraction[2] == pytest.approx(0.65)
    assert found.texts["corner"] == (
        "zone", "zone", "zone", "stop", "", "zone", "zone", "stop", "", "untagged",
    )  # fmt: skip
    np.testing.assert_allclose(found.end[:3], found.start[1:4], atol=1e-12)
    assert np.isnan(found.start[4]).all()


def test_moves_the_log_does_not_show_are_listed_and_left_out():
    timing, whole = timed(FAN), log_of(FAN, 0.008)
    cut = whole.time < OFFSET + RATE * 40.0
    log = Log(whole.time[cut], whole.q[cut], whole.slides)
    found = moves_from_log(log, timing)
    ran = moved(timing).end < 40.0
    assert len(found.moves) == pytest.approx(ran.sum(), abs=1)
    np.testing.assert_array_less(np.abs(found.moves.duration / RATE - found.planned)[:-1], 0.008)
    told = [d for d in found.diagnostics if d.code == "D042" and d.severity == "warning"]
    assert len(told) == 1
    assert f"{len(moved(timing)) - len(found.moves)} of " in told[0].message


def test_stretches_the_program_does_not_explain_are_listed():
    home = np.linspace(0, 1, 200)[:, None] * np.array([[0.6, 0.0, 0.0, 0.0, 0.0, 0.0]])
    away = track(timed(FAN), 0.05).axes[-1] + home
    found = moves_from_log(log_of(FAN, 0.008, lost=0.0, extra=(away,)), timed(FAN))
    told = [d for d in found.diagnostics if d.code == "D043"]
    assert len(told) == 1
    np.testing.assert_array_less(np.abs(found.moves.duration / RATE - found.planned), 0.008)


def test_a_robot_that_stands_a_little_off_is_told_and_cut_all_the_same():
    timing = timed(FAN)
    log = log_of(FAN, 0.008)
    # 0.4 deg of the first axis: 10 mm at the reach of the fan.
    shifted = Log(log.time, log.q + np.array([0.007, 0, 0, 0, 0, 0]), log.slides)
    found = moves_from_log(shifted, timing)
    assert any(d.code == "D045" for d in found.diagnostics)
    assert np.abs(found.moves.duration / RATE - found.planned).max() < 0.008


def counted(job, dt=0.008, first=1):
    """A log with the number of the executing move, -1 before, after and in waits."""
    log, moves = log_of(job, dt), moved(timed(job))
    at = (log.time - OFFSET) / RATE
    index = np.searchsorted(moves.begin, at, side="right") - 1
    running = (index >= 0) & (at < moves.end[np.maximum(index, 0)])
    return Log(log.time, log.q, log.slides, move=np.where(running, index + first, -1))


@pytest.mark.parametrize("first", [0, 1])
def test_a_counter_cuts_the_log_without_any_robot(first):
    found = moves_from_log(counted(CORNERS, first=first), timed(CORNERS))
    assert found.by == "counter"
    assert np.abs(found.moves.duration / RATE - found.planned).max() < 3 * 0.008  # lost samples


def test_a_counter_of_another_program_is_refused():
    log = counted(FAN)
    with pytest.raises(OlpError) as problem:
        moves_from_log(log, timed(CORNERS), "counter")
    assert [d.code for d in problem.value.diagnostics] == ["D041"]
    with pytest.raises(OlpError, match="no column move"):
        moves_from_log(log_of(FAN, 0.05), timed(FAN), "counter")


def dwelling(job, dwell, dt=0.008):
    """A log that stands still for `dwell` [s] after every move."""
    moves, way = moved(timed(job)), track(timed(job), dt)
    pieces = [np.repeat(way.axes[:1], 100, 0)]
    for begin, end in zip(moves.begin, moves.end, strict=True):
        inside = (way.time >= begin) & (way.time <= end)
        pieces += [way.axes[inside], np.repeat(way.axes[inside][-1:], round(dwell / dt), 0)]
    q = np.concatenate(pieces)
    return Log(np.arange(len(q)) * dt, q, way.linear)


def test_stops_alone_cut_a_log_of_exact_stops():
    found = moves_from_log(dwelling(FAN, 0.4), timed(FAN), "dwell")
    assert len(found.moves) == 32
    # A stop that the program does not ask for belongs to the move that arrives; the last move ends where it rests.
    off = found.moves.duration - found.planned
    np.testing.assert_allclose(off[:-1], 0.4, atol=0.05)
    assert abs(off[-1]) < 0.05


def test_stops_that_do_not_fit_the_program_are_refused():
    with pytest.raises(OlpError) as problem:
        moves_from_log(dwelling(FAN, 0.4), timed(CORNERS), "dwell")
    assert [d.code for d in problem.value.diagnostics] == ["D041"]


def test_a_log_of_other_axes_is_refused():
    log = log_of(FAN, 0.05)
    with pytest.raises(OlpError) as problem:
        moves_from_log(Log(log.time, log.q[:, :4], log.slides[:4]), timed(FAN))
    assert [d.code for d in problem.value.diagnostics] == ["D021"]


# --- the pieces -------------------------------------------------------------------------------------------------------


def walk(times, begin, end, dwell, acceleration=2.0):
    """(n, 2) [m]: 0.2 m along x, a rest from `begin` to `begin + dwell`, 0.2 m along y; trapezoids without cruise."""

    def gone(u):
        half = np.sqrt(0.2 / acceleration)
        u = np.clip(u, 0, 2 * half)
        return np.where(u < half, acceleration * u**2 / 2, 0.2 - acceleration * (2 * half - u) ** 2 / 2)

    return np.stack([0.2 - gone(begin - times), gone(times - end)], axis=1)


@pytest.mark.parametrize("dwell", [0.0, 0.2, 1.0])
@pytest.mark.parametrize("dt", [0.002, 0.01])
def test_a_rest_is_found_between_samples(dt, dwell):
    times = np.arange(0.0, 3.0, dt) + 0.3 * dt
    found = rest(times, walk(times, 1.0, 1.0 + dwell, dwell), np.array([0.2, 0.0]), 5e-5)
    assert found.arrive == pytest.approx(1.0, abs=0.6 * dt)
    assert found.leave == pytest.approx(1.0 + dwell, abs=0.6 * dt)


def test_a_point_is_passed_between_samples():
    times = np.arange(0.0, 1.0, 0.1)
    place = np.stack([times, np.full_like(times, 0.25)], axis=1)
    assert pass_by(times, place, np.array([0.437, 0.0])) == pytest.approx((0.437, 0.25))


def test_noise_is_told_from_motion():
    rng = np.random.default_rng(1)
    times = np.arange(0, 4, 0.01)
    quiet = walk(times, 1.5, 2.5, 1.0)
    assert stillness(times, quiet) == 5e-5
    sigma = 1e-4
    assert 4 * sigma < stillness(times, quiet + sigma * rng.normal(size=quiet.shape)) < 20 * sigma


def test_a_clock_is_fitted_past_wrong_instants():
    rng = np.random.default_rng(2)
    plan = np.sort(rng.random(60)) * 100
    log = 1.6e9 + 0.9998 * plan + 1e-3 * rng.normal(size=60)
    log[::15] += 2.0
    clock = fit_clock(plan, log)
    assert clock.rate == pytest.approx(0.9998, abs=5 * clock.rate_error + 5e-6)
    assert clock.offset == pytest.approx(1.6e9, abs=2e-3)
    assert fit_clock(plan[:2], log[:2]) is None


# --- the commands -----------------------------------------------------------------------------------------------------


def test_from_log_writes_a_recording_that_check_accepts(tmp_path, capsys):
    (tmp_path / "log.csv").write_bytes(log_csv(log_of(CORNERS, 0.008)))
    out = tmp_path / "made"
    words = [
        "recording",
        "from-log",
        str(tmp_path / "log.csv"),
        str(ROOT / CORNERS),
        "-o",
        str(out),
        "--with-log",
    ]
    assert main(words) == 0
    assert "10 rows by points" in capsys.readouterr().out
    found = read_recording(out)
    assert found.robot.name == "yaskawa/ma2010"
    assert found.log is not None
    assert found.tool is not None
    assert [d.code for d in found.diagnostics] == []
    assert main(["recording", "check", str(out)]) == 0
    assert "10, 10 measured" in capsys.readouterr().out
    assert main(words) == 2
    assert "C009" in capsys.readouterr().err
    assert main([*words, "--force"]) == 0


def test_check_answers_bad_input_with_status_2_and_good_input_in_json(tmp_path, capsys):
    import json

    (tmp_path / "moves.csv").write_text("move,duration_s\n1,2\n1,x\n", encoding="utf-8")
    assert main(["recording", "check", str(tmp_path)]) == 2
    assert "error[D010]" in capsys.readouterr().err
    assert main(["recording", "check", str(ROOT / "samples/up20"), "--format", "json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["moves"], found["robot"], found["diagnostics"]) == (146, "yaskawa/up20", [])
