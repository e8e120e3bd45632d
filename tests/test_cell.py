"""A cell: what a controller starts, what it may be told to do, and where the time goes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import openpyxl
import pytest
from interpreter_jobs import plan_of, write_jobs

from olp.__main__ import main
from olp.reports.batch import Job, time_files
from olp.reports.cell import cell_tree, cost_of, spelled_time, started
from olp.reports.formats import Options
from olp.timing.causes import CAUSES, seconds_by_cause
from olp.timing.timing import time_plan

PALLETISING = Path(__file__).resolve().parents[1] / "samples" / "inform" / "palletising"
CELL = {
    "MAIN": "*LOOP\nJUMP *A IF B001=1\nJUMP *B IF B001=2\nJUMP *LOOP\n*A\nCALL JOB:ONE\nJUMP *LOOP\n"
    "*B\nCALL JOB:TWO\nJUMP *LOOP",
    "ONE": "TIMER T=1.00\nCALL JOB:SHARED",
    "SHARED": "TIMER T=0.50",
    "TWO": "TIMER T=2.00\nCALL JOB:SHARED",
}


def told(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(list(words)) in (0, 2)
    return capsys.readouterr().out


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    return write_jobs(tmp_path, CELL).parent


def test_each_program_stands_below_its_first_caller_whether_the_call_ran_or_not(cell: Path) -> None:
    parts = time_files(sorted(str(path) for path in cell.glob("*.JBI")), Job(), workers=1)
    tree = [(Path(parts[row.index].file).stem, row.depth) for row in cell_tree(parts)]
    assert tree == [("MAIN", 0), ("ONE", 1), ("SHARED", 2), ("TWO", 1)]


def test_of_programs_that_call_one_another_in_a_circle_the_first_one_is_started(tmp_path: Path) -> None:
    jobs = {"A": "CALL JOB:B IF B001=1\nTIMER T=1.00", "B": "CALL JOB:A IF B001=2\nTIMER T=1.00"}
    folder = write_jobs(tmp_path, jobs).parent
    parts = time_files(sorted(str(path) for path in folder.glob("*.JBI")), Job(), workers=1)
    assert started(parts) == [0]


def test_each_branch_of_a_main_program_that_is_told_what_to_do_is_timed(cell: Path) -> None:
    job = Job(options=Options(segments=False))
    parts = time_files(sorted(str(path) for path in cell.glob("*.JBI")), job, workers=1)
    found = {Path(p.file).stem: [(b.decides, b.value, b.total_s) for b in p.branches] for p in parts}
    assert found["MAIN"] == [("B001", "1", 1.5), ("B001", "2", 2.5)]
    assert not any(found[name] for name in ("ONE", "TWO", "SHARED"))


@pytest.mark.parametrize(
    "body",
    [
        "SET B001 1\nJUMP *A IF B001=1\nJUMP *B IF B001=2\n*A\nTIMER T=1.00\n*B",
        "FOR B001 START= 0 TO 2\nJUMP *A IF B001=1\nJUMP *B IF B001=2\n*A\nTIMER T=1.00\n*B\nNEXT B001",
        "JUMP *A IF B001=1\nTIMER T=1.00\n*A",
    ],
)
def test_what_a_program_decides_itself_is_no_choice_of_others(tmp_path: Path, body: str) -> None:
    path = write_jobs(tmp_path, {"MAIN": body})
    assert not time_files([str(path)], Job(), workers=1)[0].branches


def test_report_and_time_say_the_same_total(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = cell / "page.html"
    assert main(["report", str(PALLETISING), "-o", str(page)]) in (0, 2)
    objects = json.loads(told(capsys, "time", str(PALLETISING), "--format", "json"))
    total = sum(one["total_s"] for one in objects if one["started"])
    assert [Path(one["file"]).stem for one in objects if one["started"]] == ["MAIN"]
    assert f"{total:.3f} s<small>" in page.read_text("utf-8")
    assert f"  {total:.3f}  " in told(capsys, "time", str(PALLETISING))


def test_the_causes_of_each_step_sum_to_its_time_and_a_stop_costs_more_than_its_settling() -> None:
    stops = "MOVL C00000 V=50.0\nMOVL C00001 V=50.0 PL=0\nTIMER T=0.25\nMOVL C00002 V=50.0 PL=0"
    timing = time_plan(plan_of(stops, robot="yaskawa/ma2010"))
    shares = seconds_by_cause(timing)
    assert np.allclose(shares.sum(axis=1), timing.duration_s, atol=1e-9)
    assert (shares >= 0).all()
    causes = dict(zip(CAUSES, shares.sum(axis=0), strict=True))
    assert causes["wait"] == 0.25
    assert causes["exact stop"] > 2 * 0.166  # two stops, each with its settling, and half of the ramps
    profile = timing.rows.profile
    ramps = float(profile.durations[1:, [0, 2]].sum())
    assert causes["acceleration"] + causes["exact stop"] == pytest.approx(ramps + 2 * 0.166, abs=1e-6)


def test_the_costliest_lines_sum_their_runs_and_say_what_would_help() -> None:
    body = "MOVL C00000 V=50.0\nMOVL C00002 V=10.0 PL=0\nMOVL C00001 V=50.0 PL=0\nTIMER T=0.25"
    looped = f"FOR B000 START= 0 TO 3\n{body}\nNEXT B000"
    cost = cost_of(time_plan(plan_of(looped, robot="yaskawa/ma2010")), 2)
    assert [line.statement for line in cost.lines] == ["MOVL C00002 V=10.0 PL=0", "MOVL C00001 V=50.0 PL=0"]
    assert cost.lines[0].runs == 4
    assert "a higher speed than 10 mm/s" in cost.lines[0].helps
    assert "a zone instead of the exact stop" in cost.lines[0].helps


def test_a_folder_is_told_by_cause_by_job_or_by_line(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert told(capsys, "time", str(PALLETISING), "--by", "cause").startswith("where the time goes: ")
    lines = told(capsys, "time", str(PALLETISING), "--by", "line", "--top", "3").splitlines()
    assert lines[0] == "the 3 lines that cost most"
    assert len(lines) == 5
    jobs = told(capsys, "time", str(PALLETISING), "--by", "job", "--sort", "time").splitlines()
    assert [line.split()[0] for line in jobs[2:5]] == ["MAIN.JBI", "PICK.JBI", "PLACE.JBI"]
    whole = told(capsys, "time", str(cell))
    assert "MAIN.JBI: B001 decides (line " in whole
    assert "1: >= 1.500 s (line " in whole  # a loop that only waits has no end and no cycle


def test_the_suffix_decides_about_the_format(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, begins in (("x.csv", b"line,"), ("x.json", b"[\n"), ("x.md", b"## "), ("x.txt", b"4 ")):
        assert main(["time", *map(str, sorted(cell.glob("*.JBI"))), "-o", str(cell / name)]) == 0
        assert name != "x.txt" or b"B001 decides" in (cell / name).read_bytes()
        assert (cell / name).read_bytes().startswith(begins) or name == "x.txt"
    assert main(["time", str(cell / "MAIN.JBI"), "-o", str(cell / "y.csv"), "--format", "json"]) == 2
    assert "a file ending in .csv is csv, and --format says json" in capsys.readouterr().err
    assert not (cell / "y.csv").exists()
    assert main(["lint", str(cell), "-o", str(cell / "y.json")]) in (0, 1)
    assert json.loads((cell / "y.json").read_bytes())


def test_a_workbook_holds_numbers_and_no_formula(tmp_path: Path) -> None:
    path = write_jobs(tmp_path, {"MAIN": "TIMER T=1.50"})
    strange = path.with_name("=1+1.JBI")
    path.rename(strange)
    assert main(["time", str(strange), "-o", str(tmp_path / "x.xlsx")]) == 0
    book = openpyxl.load_workbook(tmp_path / "x.xlsx")
    rows = list(book["rows"].values)
    assert rows[1][rows[0].index("duration_s")] == 1.5
    cells = [cell for sheet in book for row in sheet.iter_rows() for cell in row]
    assert not [cell.value for cell in cells if cell.data_type == "f"]


def test_without_the_library_a_workbook_is_one_clear_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "openpyxl", None)
    path = write_jobs(tmp_path, {"MAIN": "TIMER T=1.50"})
    assert main(["time", str(path), "-o", str(tmp_path / "x.xlsx")]) == 2
    assert "error[Y002]" in (said := capsys.readouterr().err)
    assert 'pip install "olp[excel]"' in said
    assert not (tmp_path / "x.xlsx").exists()


def test_one_sentence_about_many_files_is_told_once(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("P", "Q", "R", "S", "T"):
        (cell / f"{name}.JBI").write_bytes((cell / "ONE.JBI").read_bytes().replace(b"T=1.00", b"T="))
    main(["time", str(cell), "--summary"])
    said = capsys.readouterr().err
    assert said.count("error[P020]") == 1
    assert "the same in " in said
    assert " and 1 more places" in said


def test_lint_counts_its_rules_and_is_quiet(capsys: pytest.CaptureFixture[str]) -> None:
    quiet = told_lint(capsys, "--quiet").splitlines()
    counted = told_lint(capsys, "--statistics").splitlines()
    assert all(line.count(": W") == 1 for line in quiet)
    assert counted[-1].split()[0] == str(len(quiet))
    assert sum(int(line.split()[0]) for line in counted[:-1]) == len(quiet)


def told_lint(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(["lint", str(PALLETISING), *words]) in (0, 1)
    return capsys.readouterr().out


def test_times_are_spelled_as_people_say_them() -> None:
    assert [spelled_time(t) for t in (41.24, 59.96, 185.0, 5498.0)] == [
        "41.2 s",
        "1 min 00 s",
        "3 min 05 s",
        "1 h 31 min",
    ]
