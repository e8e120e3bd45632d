"""Logs as tables, imported in their own words: durations are known from how the motions are made."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.core.units import deg
from olp.identification.recording import read_recording
from olp.identification.recording.column_naming import parse_naming
from olp.identification.recording.importing import motions_between_rests
from olp.identification.recording.log import Log
from samples.recordings.make_logs import (
    DURATIONS,
    PERIOD,
    START,
    TURN,
    abb_csv,
    fanuc_csv,
    motions,
    pulse_csv,
)

LOGS = Path(__file__).resolve().parents[1] / "samples" / "recordings" / "logs"
TIME, AXES, BEGINS = motions()


def durations(path: Path, *words: str) -> list[float]:
    """Of the recording that is imported from `path`; its points are checked."""
    out = path.parent / "made"
    assert main(["recording", "import", str(path), "-o", str(out), "--force", *words]) == 0
    moves = read_recording(out).moves
    assert moves.joints_end[0] / deg == pytest.approx((START + TURN) / deg, abs=0.02)
    found: list[float] = moves.duration.tolist()
    return found


def said(capsys: pytest.CaptureFixture[str], path: Path, *words: str) -> str:
    assert main(["recording", "import", str(path), "-o", str(path.parent / "none"), *words]) == 2
    assert not (path.parent / "none").exists()
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("fanuc.csv", ()),
        ("abb.csv", ()),
        (
            "yaskawa.csv",
            (
                *("--robot", "yaskawa/gp25", "--column", "t_ms=Time_ms"),
                *(w for n, a in enumerate("SLURBT", 1) for w in ("--column", f"q{n}_pulse={a}_pulse")),
            ),
        ),
    ],
)
def test_the_samples_give_their_durations_to_a_sample(
    tmp_path: Path, name: str, words: tuple[str, ...]
) -> None:
    text = {
        "fanuc.csv": fanuc_csv(TIME, AXES),
        "abb.csv": abb_csv(TIME, AXES, BEGINS),
        "yaskawa.csv": pulse_csv(TIME, AXES),
    }
    assert (LOGS / name).read_text("utf-8") == text[name]  # what make_logs.py writes
    (tmp_path / name).write_text(text[name], encoding="utf-8")
    assert durations(tmp_path / name, *words) == pytest.approx(DURATIONS, abs=PERIOD)


def test_a_simulated_log_is_paired_by_the_same_rule(tmp_path: Path) -> None:
    time, axes, _ = motions((0.4, 0.7, 0.25, 1.0))
    (tmp_path / "sim.csv").write_text(fanuc_csv(time, axes), encoding="utf-8")
    (tmp_path / "run.csv").write_text(fanuc_csv(TIME, AXES), encoding="utf-8")
    durations(tmp_path / "run.csv", "--sim", str(tmp_path / "sim.csv"))
    assert read_recording(tmp_path / "made").moves.sim.tolist() == pytest.approx(
        [0.4, 0.7, 0.25, 1.0], abs=PERIOD
    )


def test_columns_are_named_by_their_numbers_where_the_file_begins_with_numbers(tmp_path: Path) -> None:
    rows = np.column_stack([TIME + 1.7e9, AXES])
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", fmt="%.6f")
    words = [w for n in range(1, 7) for w in ("--column", f"q{n}_rad={n + 1}")]
    assert durations(tmp_path / "run.csv", "--column", "t_s=1", *words) == pytest.approx(
        DURATIONS, abs=PERIOD
    )


def test_a_workbook_and_decimal_commas_hold_a_log(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    names = ["t_s", *(f"q{n}_deg" for n in range(1, 7))]
    book = openpyxl.Workbook()
    book.active.append(names)
    rows = np.column_stack([TIME, AXES / deg]).tolist()
    for row in rows:
        book.active.append(row)
    book.save(tmp_path / "run.xlsx")
    assert durations(tmp_path / "run.xlsx") == pytest.approx(DURATIONS, abs=PERIOD)
    lines = [";".join(names), *(";".join(f"{v:.5f}".replace(".", ",") for v in row) for row in rows)]
    (tmp_path / "run.csv").write_text("\n".join(lines), encoding="utf-8")
    assert durations(tmp_path / "run.csv") == pytest.approx(DURATIONS, abs=PERIOD)
    # The same with tabs, and with the quotes that some programs put around everything.
    (tmp_path / "run.txt").write_text("\n".join(line.replace(";", "\t") for line in lines), encoding="utf-8")
    assert durations(tmp_path / "run.txt") == pytest.approx(DURATIONS, abs=PERIOD)
    quoted = "\r\n".join(";".join(f'"{cell}"' for cell in line.split(";")) for line in lines)
    (tmp_path / "run.csv").write_text(quoted, encoding="utf-8", newline="")
    assert durations(tmp_path / "run.csv") == pytest.approx(DURATIONS, abs=PERIOD)


def test_a_file_without_names_and_a_folder_of_folders_say_what_to_type(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    np.savetxt(tmp_path / "run.csv", np.column_stack([TIME, AXES]), delimiter=",", fmt="%.6f")
    told = said(capsys, tmp_path / "run.csv")
    assert "nothing names its 7 columns" in told
    assert "--column t_s=1 --column q1_deg=2" in told
    (tmp_path / "all" / "real").mkdir(parents=True)
    assert "folders in it: real" in said(capsys, tmp_path / "all")


def test_columns_in_other_words_are_named_with_what_to_say(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "run.csv"
    path.write_text("Time [ms],Joint1,Joint2 (rad),axis_3\n0,1,2,3\n8,1,2,3\n", encoding="utf-8")
    told = said(capsys, path)
    assert "is it the column Time [ms]? olp recording import --column t_ms=Time [ms] says so" in told
    path.write_text("t_s,J1,J2 (rad)\n0,1,2\n1,1,2\n", encoding="utf-8")
    assert "q1_deg=J1" in said(capsys, path)
    path.write_text(pulse_csv(TIME, AXES), encoding="utf-8")
    told = said(capsys, path, "--robot", "yaskawa/gp25", "--column", "t_ms=Tme_ms")
    assert "there is no column of numbers Tme_ms" in told
    assert "did you mean Time_ms?" in told
    told = said(
        capsys, path, "--robot", "yaskawa/gp25", "--column", "t_ms=Time_ms", "--column", "q2_pulse=L_pulse"
    )
    assert "the column q1_deg is missing" in told
    assert "--column q1_pulse=S_pulse" in told
    assert "error[D061]: axes in pulses need its robot" in said(capsys, path, "--column", "q1_pulse=S_pulse")


@pytest.mark.parametrize("word", ["q1", "q1_inch=J1", "=J1", "q1_deg=", "speed=J1", "t_h=Time"])
def test_a_naming_that_means_nothing_is_refused(word: str) -> None:
    with pytest.raises(OlpError, match="means nothing"):
        parse_naming([word])


def test_a_column_is_named_once() -> None:
    with pytest.raises(OlpError, match="names q1_deg twice"):
        parse_naming(["q1_deg=J1", "q1_rad=J2"])


def test_numbers_that_look_like_radians_and_milliseconds_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    header = ",".join(["t_s", *(f"q{n}_deg" for n in range(1, 7))])
    rows = np.column_stack([TIME * 1000, AXES])
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", fmt="%.6f", header=header, comments="")
    main(["recording", "import", str(tmp_path / "run.csv"), "-o", str(tmp_path / "made")])
    told = capsys.readouterr().err
    assert "warning[D057]: no axis is farther than" in told
    assert "are these radians?" in told
    assert "is the time in milliseconds?" in told


def test_an_arm_that_stands_has_no_motion(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "run.csv").write_text(fanuc_csv(TIME[:40], AXES[:40]), encoding="utf-8")
    assert "error[D060]: no motion begins and ends in this log" in said(capsys, tmp_path / "run.csv")


def test_a_table_of_times_in_other_words_and_units_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    samples = LOGS.parents[1] / "inform" / "handling"
    path = tmp_path / "times.csv"
    path.write_text("Programm;Zeile;Dauer\nHANDLING;40;410,5\nHANDLING;41;660\n", encoding="utf-8")
    job = ("--job", str(samples / "HANDLING.JBI"), "--robot", "yaskawa/gp25")
    assert "--column duration_s=COLUMN says which one it is; there are Programm, Zeile, Dauer" in said(
        capsys, path, *job
    )
    names = [w for name in ("job=Programm", "line=Zeile", "duration_ms=Dauer") for w in ("--column", name)]
    assert main(["recording", "import", str(path), *job, *names, "-o", str(tmp_path / "made")]) == 0
    moves = read_recording(tmp_path / "made").moves
    assert moves.duration.tolist() == pytest.approx([0.4105, 0.66])
    assert moves.line.tolist() == [40, 41]
    assert "did you mean Dauer?" in said(capsys, path, *job, "--column", "duration_ms=Daur")
    path.write_text("line,duration_ms\n40,410\n", encoding="utf-8")
    assert "--column duration_ms=duration_ms says so" in said(capsys, path, *job)


@pytest.mark.parametrize("period", [0.002, 0.008, 0.046])
@pytest.mark.parametrize("noise", [0.0, 1e-5, 1e-4, 5e-4])
def test_motions_are_found_in_noise_and_lost_samples(period: float, noise: float) -> None:
    rng = np.random.default_rng(1)
    expected = DURATIONS * 5
    time, axes, _ = motions(expected, period)
    kept = rng.random(len(time)) > 0.03
    log = Log(time[kept], (axes + noise * rng.normal(size=axes.shape))[kept], (False,) * 6)
    found = [end - begin for begin, end in motions_between_rests(log)]
    assert found == pytest.approx(expected, abs=(2.1 if period > 0.01 else 1.5) * period)


def test_a_motion_that_the_log_cuts_is_left_out_and_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    time = TIME
    inside = (time > BEGINS[0] + 0.2) & (time < BEGINS[3] + 0.5)
    (tmp_path / "run.csv").write_text(fanuc_csv(time[inside], AXES[inside]), encoding="utf-8")
    assert main(["recording", "import", str(tmp_path / "run.csv"), "-o", str(tmp_path / "made")]) == 0
    assert read_recording(tmp_path / "made").moves.duration.tolist() == pytest.approx(
        DURATIONS[1:3], abs=PERIOD
    )
    told = capsys.readouterr().err
    assert "2 motions between rests" in told
    assert told.count("is left out: the log begins or ends within it") == 2
    # From the first sample of a motion to the last one of another nothing is cut.
    whole = (time >= BEGINS[0] - PERIOD / 2) & (time <= BEGINS[3] + DURATIONS[3] + PERIOD / 2)
    (tmp_path / "run.csv").write_text(fanuc_csv(time[whole], AXES[whole]), encoding="utf-8")
    assert durations(tmp_path / "run.csv") == pytest.approx(DURATIONS, abs=1.5 * PERIOD)
