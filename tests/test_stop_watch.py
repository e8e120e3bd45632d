"""Tables of times, `line,duration_s` with the program they were taken of, as people and cycle logs write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from openpyxl import Workbook

import olp
from olp.__main__ import main
from olp.core.units import deg, mm
from olp.identification.recording import read_recording

JOB = Path("samples/inform/handling/HANDLING.JBI")
# Line 49 runs three times a round; DROP is called.
ROUND = [
    ("HANDLING.JBI", 41, 0.66),
    ("", 43, 0.36),
    ("", 49, 0.35),
    ("", 49, 0.33),
    ("", 49, 0.36),
    ("drop", 25, 3.31),
]


def written(folder: Path, rows: list[tuple[str, int, float]], more: str = "") -> Path:
    head = ["job", "line", "duration_s"] + ([more.partition("=")[0]] if more else [])
    tail = f",{more.partition('=')[2]}" if more else ""
    lines = [",".join(head), *(f"{job},{line},{time}{tail}" for job, line, time in rows)]
    path = folder / "times.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def imported(table: Path, *more: str) -> int:
    words = ["recording", "import", str(table), "--job", str(JOB), "--robot", "yaskawa/gp25"]
    return main([*words, "-o", str(table.parent / "made"), *more])


def test_each_row_gets_the_move_of_its_line_and_round(tmp_path: Path) -> None:
    later = [(job, line, time + 0.1) for job, line, time in ROUND]
    assert imported(written(tmp_path, ROUND + later, "shift=night")) == 0
    recording = read_recording(tmp_path / "made")
    moves, plan = recording.moves, olp.read(JOB).plan(robot="yaskawa/gp25")
    assert moves.duration.tolist() == pytest.approx([time for _, _, time in ROUND + later])
    assert moves.cycle.tolist() == [1] * 6 + [2] * 6
    assert moves.line.tolist() == [41, 43, 49, 49, 49, 25] * 2
    assert list(moves.job[:6]) == ["HANDLING.JBI"] * 5 + ["DROP.JBI"]
    assert moves.texts["shift"] == ("night",) * 12
    assert recording.robot is not None
    assert recording.robot.name == "yaskawa/gp25"
    # What the plan says of the third run of line 49, found without the importer.
    third = [step for step in plan.steps() if step.line == 49][2]
    assert moves.end[4] / mm == pytest.approx(third.target / mm, abs=1e-6)
    assert np.linalg.norm(moves.end[4] - moves.end[3]) / mm > 1.0
    assert moves.kinds[1] == "wait"
    assert np.isnan(moves.end[1]).all()
    assert moves.speed[0] / mm == pytest.approx(250.0)
    assert np.isfinite(moves.joints_end[0] / deg).all()


def test_excel_and_semicolons_give_what_commas_give(tmp_path: Path) -> None:
    assert imported(written(tmp_path, ROUND)) == 0
    plain = (tmp_path / "made" / "moves.csv").read_bytes()
    (tmp_path / "other").mkdir()
    book = Workbook()
    book.active.append(["job", "line", "duration_s", None])
    for job, line, time in ROUND:
        book.active.append([job or None, line, time])
    book.save(tmp_path / "other" / "times.xlsx")
    assert imported(tmp_path / "other" / "times.xlsx") == 0
    assert (tmp_path / "other" / "made" / "moves.csv").read_bytes() == plain
    rows = "".join(f"{job};{line};{str(time).replace('.', ',')}\n" for job, line, time in ROUND)
    (tmp_path / "other" / "times.csv").write_text(f"job;line;duration_s\n{rows}", "utf-8")
    assert imported(tmp_path / "other" / "times.csv", "--force") == 0
    assert (tmp_path / "other" / "made" / "moves.csv").read_bytes() == plain


def test_all_that_is_wrong_is_told_with_its_row_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = [*ROUND, ("", 999, 0.5), ("HANDLINK", 41, 0.5), ("", 41, -1.0), ("", 39, 0.2)]
    assert imported(written(tmp_path, rows)) == 2
    told = capsys.readouterr().err
    for words in (
        "line 999 neither moves nor waits in this run",
        "times.csv:8:2",
        "the program does not run HANDLINK",
        "it runs HANDLING.JBI, DROP.JBI",
        "duration_s cannot be -1",
        "line 39 neither moves nor waits in this run",
    ):
        assert words in told
    assert not (tmp_path / "made").exists()
    (tmp_path / "times.csv").write_text("line,duration_ms\n41,660\n", "utf-8")
    assert imported(tmp_path / "times.csv") == 2
    assert "column duration_s is missing" in (told := capsys.readouterr().err)
    assert "is it column duration_ms?" in told
    (tmp_path / "times.xlsx").write_bytes(b"PK\x03\x04 no workbook")
    assert imported(tmp_path / "times.xlsx") == 2
    assert "error[D002]: not an Excel workbook" in capsys.readouterr().err


def test_rows_that_are_no_whole_rounds_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert imported(written(tmp_path, ROUND[:4], "speed_mm_s=99")) == 0
    told = capsys.readouterr().err
    assert "warning[D056]: lines whose rows are no whole rounds of the program: 49" in told
    assert "column speed_mm_s is not used: the program says it" in told
    assert read_recording(tmp_path / "made").moves.speed[0] / mm == pytest.approx(250.0)


def test_a_table_without_its_program_is_told_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["recording", "import", str(written(tmp_path, ROUND)), "-o", str(tmp_path / "made")]) == 2
    assert "a table of times needs --job, the program that was timed" in capsys.readouterr().err


def test_what_a_table_says_of_the_run_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [
        "line,duration_s,cycle,sim_s,payload_kg,override_pct,t_start_s",
        "41,0.66,1,0.6,1.5,85,3",
        "43,0.36,1,,1.5,85,4",
    ]
    (tmp_path / "times.csv").write_text("\n".join(rows) + "\n", "utf-8")
    assert imported(tmp_path / "times.csv") == 0
    moves = read_recording(tmp_path / "made").moves
    assert moves.sim[0] == pytest.approx(0.6)
    assert np.isnan(moves.sim[1])
    assert moves.payload.tolist() == [1.5, 1.5]
    assert moves.override.tolist() == pytest.approx([0.85, 0.85])
    assert moves.t_start.tolist() == [3.0, 4.0]
    (tmp_path / "times.csv").write_text("line,duration_s,cycle\n41,0.66,1\n43,0.36,\n", "utf-8")
    assert imported(tmp_path / "times.csv", "--force") == 2
    assert "cycle is empty" in capsys.readouterr().err
