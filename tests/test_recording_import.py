"""Recordings out of what controllers record of their own accord; the sample is made by samples/recordings/make.py."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from olp.__main__ import main
from olp.core.units import deg, mm
from olp.identification.recording import read_recording
from olp.robots.robot import library_name

TRACE = Path(__file__).resolve().parents[1] / "samples" / "recordings" / "trace"


@pytest.fixture
def trace(tmp_path: Path) -> Path:
    return Path(shutil.copytree(TRACE, tmp_path / "trace"))


def said(capsys: pytest.CaptureFixture[str], *words: str | Path) -> str:
    """What the error stream says of a question that cannot be answered."""
    assert main(["recording", "import", *map(str, words)]) == 2
    return capsys.readouterr().err


def test_a_trace_gives_the_motions_to_the_cycle(tmp_path: Path) -> None:
    out = tmp_path / "made"
    # Any file of the set stands for all of them.
    files = ["PALLET_KRCIpo.dat", "PALLET_PROG.TXT"]
    words = [*(str(TRACE / name) for name in files), "-o", str(out), "--override", "85"]
    assert main(["recording", "import", *words]) == 0
    moves, settings = read_recording(out).moves, read_recording(out).settings
    assert moves.duration.tolist() == pytest.approx([0.3, 0.348, 0.204], abs=1e-9)
    assert moves.line.tolist() == [12, 13, 15]
    assert moves.kinds == ("joint", "linear", "linear") or list(moves.kinds) == ["joint", "linear", "linear"]
    assert (moves.joints_end[1] / deg).tolist() == pytest.approx([26.25, -74.5, 90.5, 4.75, 38.0, -15.25])
    assert moves.joints_start[2].tolist() == pytest.approx(moves.joints_end[1].tolist())
    assert (moves.end[0] / mm).tolist() == pytest.approx([451.25, 24.375, 489.375])
    assert (moves.end_angles[0] / deg).tolist() == pytest.approx(
        [-6.25, 20.125, 1.75]
    )  # A, B, C about z, y, x
    assert settings.robot == "kuka/kr3-r540"
    assert settings.time_resolution == 0.012
    assert settings.tool is not None
    assert [v / deg for v in settings.tool[3:]] == pytest.approx([2.5, -60.0, 0.0])
    text = (out / "moves.csv").read_text("utf-8")
    assert "override_pct" in text
    assert ",60.0,100.0,1.25,0.003," in text
    log = (out / "log.csv").read_text("utf-8").splitlines()
    assert [row.rpartition(",")[2] for row in (log[2], log[3], log[27], log[28])] == ["-1", "1", "1", "-1"]


def test_simulated_motions_are_paired_and_those_of_another_program_are_refused(
    trace: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program = trace / "PALLET_PROG.TXT"
    text = (
        program.read_text("ascii").replace("LINE: 13", "LINE: 27").replace("TIME: 0.732000", "TIME: 0.744000")
    )
    program.write_text(text, "ascii")
    assert main(["recording", "import", str(TRACE), "--sim", str(trace), "-o", str(tmp_path / "made")]) == 0
    assert read_recording(tmp_path / "made").moves.sim.tolist() == pytest.approx([0.3, 0.36, 0.204])
    program.write_text(text.replace("TYPE: PTP", "TYPE: LIN"), "ascii")
    told = said(capsys, TRACE, "--sim", trace, "-o", tmp_path / "other")
    assert (
        "error[D054]: line 12 of PALLET and line 12 of the simulated PALLET are not the same motion" in told
    )


def test_a_motion_without_an_end_is_left_out_and_told(
    trace: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program = trace / "PALLET_PROG.TXT"
    first, *blocks = program.read_text("ascii").split("#BEGINMOTIONINFO")
    program.write_text("#BEGINMOTIONINFO".join([first, *blocks[:-1]]), "ascii")
    assert main(["recording", "import", str(trace), "-o", str(tmp_path / "made")]) == 0
    assert (
        "warning[D052]: the motion of line 15 of PALLET is left out: it has no end" in capsys.readouterr().err
    )
    assert len(read_recording(tmp_path / "made").moves) == 2


@pytest.mark.parametrize(
    ("name", "change", "says"),
    [
        (
            "PALLET_KRCIpo.r64",
            lambda raw: raw[:-8],
            "error[D051]: 8632 bytes are not 12 channels of 90 samples",
        ),
        (
            "PALLET_KRCIpo.r64",
            lambda raw: b"\xff" * 8 + raw[8:],
            "error[D051]: sample 0 of X_Act is no number",
        ),
        ("PALLET_KRCIpo.dat", lambda raw: b"", "error[D051]: this is no header of a trace"),
        (
            "PALLET_KRCIpo.dat",
            lambda raw: raw.replace(b"Act6", b"Act7"),
            "error[D051]: 5 of 6 axes are recorded",
        ),
        ("PALLET_PROG.TXT", lambda raw: b"", "error[D051]: no motion begins and ends in this trace"),
        ("PALLET_PROG.TXT", None, "error[D050]: PALLET_PROG.TXT is missing"),
    ],
)
def test_a_broken_trace_is_one_error_and_nothing_is_written(trace, tmp_path, capsys, name, change, says):
    file = trace / name
    if change is None:
        file.unlink()
    else:
        file.write_bytes(change(file.read_bytes()))
    assert says in said(capsys, trace, "-o", tmp_path / "made")
    assert not (tmp_path / "made").exists()


def test_what_no_recorder_wrote_is_told_with_what_would_have_been(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "notes.csv").write_text("a\n")
    told = said(capsys, tmp_path / "notes.csv", "-o", tmp_path / "made")
    assert "error[D053]" in told
    assert "known are NAME_PROG.TXT, NAME_KRCIpo.dat and NAME_KRCIpo.r64" in told


def test_a_controllers_name_of_its_robot_is_found_in_the_library() -> None:
    assert library_name("KR3R540 C4SR") == "kuka/kr3-r540"
    assert library_name("nobody's") == ""
