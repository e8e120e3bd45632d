"""Every report format over the same timings, and `olp time` as a user runs it."""

from __future__ import annotations

import csv
import io
import json
import os
import re
from pathlib import Path

import pytest

import olp
from olp.core.diagnostic import OlpError
from olp.reports.batch import Job, time_file, time_files
from olp.reports.formats import Options, load_report, report_names
from olp.timing.result import COLUMNS

SAMPLES = Path(__file__).parent.parent / "samples"
JOBS = sorted((SAMPLES / "up20").glob("*.JBI"))
ANY_FORMAT = pytest.mark.parametrize("name", report_names())
CONTRACT = {
    "file",
    "robot",
    "total_s",
    "motion_s",
    "wait_s",
    "io_s",
    "low_s",
    "high_s",
    "segments",
    "assumptions",
}
SEGMENT = {
    "line",
    "statement",
    "kind",
    "distance_mm",
    "speed_mm_s",
    "reached_mm_s",
    "accel_mm_s2",
    "limited_by",
    "duration_s",
    "end_s",
}


def report(name, paths, **options):
    job = Job(format=name, robot="yaskawa/up20", options=Options(**options))
    parts = time_files([str(p) for p in paths], job, workers=1)
    return load_report(name).join(parts, job.options), parts


def test_the_formats_of_the_contract_exist():
    assert {"text", "json", "csv", "markdown"} <= set(report_names())


def test_an_unknown_format_lists_those_there_are():
    with pytest.raises(OlpError) as caught:
        load_report("xml")
    assert "markdown" in caught.value.diagnostics[0].help


@ANY_FORMAT
@pytest.mark.parametrize("segments", [True, False])
def test_every_format_names_every_file_and_every_total(name, segments):
    text, parts = report(name, JOBS[:3], segments=segments)
    assert text.endswith("\n")
    for job, part in zip(JOBS, parts, strict=False):
        assert job.name in text
        assert part.total_s is not None
        if name in ("text", "markdown"):  # scripts get all digits, and a spreadsheet sums for itself
            assert f"total {part.total_s:.3f} s" in text or f"{part.total_s:.3f}  " in text


@ANY_FORMAT
def test_a_file_that_cannot_be_read_does_not_stop_the_others(name, tmp_path):
    missing = tmp_path / "gone.jbi"
    text, parts = report(name, [JOBS[0], missing, JOBS[1]])
    assert [p.failed for p in parts] == [False, True, False]
    assert JOBS[1].name in text


def test_json_has_the_keys_of_the_contract_and_numbers_that_add_up():
    text, _ = report("json", JOBS[:2])
    for program in json.loads(text):
        assert CONTRACT | {"diagnostics"} <= set(program)
        assert all(set(segment) >= SEGMENT for segment in program["segments"])
        durations = [segment["duration_s"] for segment in program["segments"]]
        assert sum(durations) == pytest.approx(program["total_s"])
        assert program["segments"][-1]["end_s"] == pytest.approx(program["total_s"])


def test_csv_is_one_table_that_a_spreadsheet_can_sum():
    text, parts = report("csv", JOBS[:2])
    rows = list(csv.DictReader(io.StringIO(text)))
    assert tuple(rows[0]) == COLUMNS
    for part in parts:
        mine = [float(row["duration_s"]) for row in rows if row["file"] == part.file]
        assert sum(mine) == pytest.approx(part.total_s, abs=1e-4)


def test_the_library_gives_the_same_numbers_as_the_command():
    frame = olp.read(JOBS[0]).plan(robot="yaskawa/up20").time()
    program = json.loads(report("json", JOBS[:1])[0])[0]
    assert list(frame.columns) == list(COLUMNS)
    assert frame["duration_s"].to_list() == [s["duration_s"] for s in program["segments"]]


def test_markdown_cells_cannot_break_the_table():
    text, _ = report("markdown", JOBS[:1])
    widths = {len(re.findall(r"(?<!\\)\|", line)) for line in text.splitlines() if line.startswith("|")}
    assert len(widths) == 1


def test_text_fits_the_terminal_and_has_no_colour_codes_unless_wanted():
    plain, _ = report("text", JOBS[:1], width=96)
    table = plain.split("\n\n")[0].splitlines()[1:]
    assert max(map(len, table)) <= 96
    assert "\x1b" not in plain
    assert "\x1b[" in report("text", JOBS[:1], colour=True)[0]


@pytest.mark.slow
def test_many_files_on_two_cores_give_what_one_gives(tmp_path):
    paths = []
    for i in range(60):
        paths.append(str(tmp_path / f"J{i:02}.JBI"))
        Path(paths[-1]).write_bytes(JOBS[i % len(JOBS)].read_bytes())
    job = Job(format="json", robot="yaskawa/up20")
    assert time_files(paths, job, workers=2) == time_files(paths, job, workers=1)


def test_a_part_says_how_much_was_assumed():
    part = time_file(str(JOBS[0]), Job(robot="yaskawa/up20"))
    assert part.assumed > 0
    assert "assumed:" in part.text


def test_time_writes_a_file_whole_and_never_over_its_input(tmp_path, capsys):
    from olp.__main__ import main

    job = tmp_path / "A.JBI"
    job.write_bytes(JOBS[0].read_bytes())
    out = tmp_path / "times.csv"
    assert main(["time", str(job), "--robot", "yaskawa/up20", "--format", "csv", "-o", str(out)]) == 0
    assert out.read_text(encoding="utf-8").startswith("line,statement,")
    assert main(["time", str(job), "--robot", "yaskawa/up20", "-o", str(job)]) == 2
    assert job.read_bytes() == JOBS[0].read_bytes()
    assert "overwrite" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ["--robot", "yaskawa/up21"],
        ["--model", "warp"],
        ["--accel", "-5"],
        ["--accel", "nan"],
        ["--format", "xml"],
        ["--assumptions", "nowhere.toml"],
        ["--cycles", "0"],
        ["--workers", "-1"],
        ["--encoding", "klingon"],
    ],
)
def test_wrong_options_are_told_with_status_2(words, capsys):
    from olp.__main__ import main

    assert main(["time", str(JOBS[0]), *words]) == 2
    shown = capsys.readouterr()
    assert shown.err.count("error[") == 1
    assert not shown.out, "nothing was timed, so there is no table"


@pytest.mark.parametrize(
    "words", [["--robot", "yaskawa/up21"], ["--model", "warp"], ["--assumptions", "no.toml"]]
)
@pytest.mark.parametrize("command", ["time", "annotate"])
def test_a_setting_that_is_wrong_for_every_file_is_told_once(command, words, capsys, tmp_path):
    from olp.__main__ import main

    more = ["-o", str(tmp_path)] if command == "annotate" else []
    assert main([command, *map(str, JOBS[:3]), *words, *more]) == 2
    assert capsys.readouterr().err.count("error[") == 1
    assert not list(tmp_path.iterdir())


def test_numbers_out_of_range_are_answered_in_words(capsys):
    from olp.__main__ import main

    for words in (["--accel", "-5"], ["--cycles", "0.5"]):
        assert main(["time", str(JOBS[0]), *words]) == 2
        assert f"argument {words[0]}: '{words[1]}' is not a " in capsys.readouterr().err


def test_a_move_without_a_robot_is_one_finding(tmp_path):
    path = tmp_path / "A.JBI"
    path.write_bytes((SAMPLES / "inform" / "twins" / "base.jbi").read_bytes())
    assert [d.code for d in time_file(str(path), Job()).diagnostics if d.is_error] == ["I003"]
    path.write_bytes((SAMPLES / "inform" / "twins" / "pulse.jbi").read_bytes())
    part = time_file(str(path), Job())
    assert [d.code for d in part.diagnostics if d.is_error] == ["I001"]
    assert "unknown" in part.text


def test_one_program_needs_no_sum_of_all():
    text, _ = report("text", JOBS[:1], segments=False)
    assert len(text.splitlines()) == 2


def test_track_says_what_it_takes_for_granted(capsys):
    from olp.__main__ import main

    assert main(["track", str(SAMPLES / "inform" / "twins" / "base.jbi"), "--dt", "0.5"]) == 0
    assert "assumed: RB1 is already at the target of its first move" in capsys.readouterr().err


def test_track_is_a_table_with_units_and_ends_with_the_program(tmp_path):
    import pandas

    from olp.__main__ import main

    out = tmp_path / "track.csv"
    words = ["track", str(JOBS[0]), "--robot", "yaskawa/up20", "--dt", "0.05", "-o", str(out)]
    assert main(words) == 0
    table = pandas.read_csv(out)
    total = json.loads(report("json", JOBS[:1])[0])[0]["total_s"]
    assert table["t_s"].iloc[-1] == pytest.approx(total, abs=1e-6)
    assert {"x_mm", "rz_deg", "line"} <= set(table.columns)
    parquet = tmp_path / "track.parquet"
    assert main([*words[:-1], str(parquet)]) == 0
    assert pandas.read_parquet(parquet)["x_mm"].to_list() == pytest.approx(table["x_mm"].to_list(), abs=1e-6)


def test_paths_are_shown_as_they_were_given(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("B.JBI").write_bytes(JOBS[0].read_bytes())
    part = time_file("B.JBI", Job(robot="yaskawa/up20"))
    assert part.file == "B.JBI"
    assert os.sep not in part.text.splitlines()[0]


@pytest.fixture
def lame(tmp_path):
    """A job with one line that cannot be read and two moves whose robot has an axis fewer than their points."""
    job = (SAMPLES / "inform" / "pitfalls" / "seven-axis.jbi").read_bytes()
    path = tmp_path / "LAME.JBI"
    path.write_bytes(job.replace(b"\r\nEND", b"\r\nTIMER T=\r\nTIMER T=0.5\r\nEND"))
    return path


@pytest.mark.parametrize("name", ["text", "markdown"])
def test_a_sum_that_leaves_something_out_says_so(name, lame):
    for segments in (True, False):
        text, _ = report(name, [lame, JOBS[0]], segments=segments)
        assert ">= 0.500" in text
        assert "total >= 0.500 s (" in text or (name == "text" and not segments)
    text, parts = report(name, [lame])
    assert f"incomplete: 2 of 4 steps have no time, {len(parts[0].diagnostics)} errors" in text
    assert "incomplete" not in report(name, [JOBS[0]])[0]
    assert ">=" not in report(name, [JOBS[0]])[0]


def test_scripts_are_told_how_many_steps_have_no_time(lame):
    assert [program["untimed"] for program in json.loads(report("json", [lame, JOBS[0]])[0])] == [2, 0]
    table = list(csv.DictReader(io.StringIO(report("csv", [lame, JOBS[0]], segments=False)[0])))
    assert [row["untimed"] for row in table] == ["2", "0"]


def test_moves_without_a_time_for_one_reason_are_one_finding(lame):
    _, parts = report("text", [lame])
    found = [d for d in parts[0].diagnostics if d.code == "T101"]
    assert [(d.line, " (and " in d.message) for d in found] == [(17, True)]


def test_what_is_wrong_with_a_job_that_others_call_is_told_once(tmp_path):
    from olp.reports.batch import shown

    head, tail = b"/JOB\r\n//NAME %s\r\n//POS\r\n///NPOS 0,0,0,0,0,0\r\n//INST\r\nNOP\r\n", b"\r\nEND\r\n"
    bodies = {"A": b"CALL JOB:C", "B": b"CALL JOB:C", "C": b"TIMER T="}
    for job, body in bodies.items():
        (tmp_path / f"{job}.JBI").write_bytes(head % job.encode() + body + tail)
    parts = time_files([str(tmp_path / f"{job}.JBI") for job in bodies], Job())
    assert [p.failed for p in parts] == [True, True, True]
    assert [d.code for d in shown(parts)] == ["P020"]


def test_what_others_call_is_summed_once():
    folder = SAMPLES / "inform" / "palletising"
    job = Job(options=Options(segments=False))
    parts = time_files([str(p) for p in sorted(folder.glob("*.JBI"))], job, workers=1)
    main = next(part for part in parts if part.file.endswith("MAIN.JBI"))
    last = load_report("text").join(parts, job.options).splitlines()[-1]
    assert last.startswith("1 of 5 files, calling the others ")
    assert f" {main.total_s:.3f} " in last
    assert load_report("text").join(parts[3:], job.options).splitlines()[-1].startswith("2 files ")


def test_track_refuses_a_suffix_that_promises_another_format(tmp_path, capsys):
    from olp.__main__ import main

    out = tmp_path / "track.xlsx"
    assert main(["track", str(JOBS[0]), "--robot", "yaskawa/up20", "-o", str(out)]) == 2
    assert "FILE.csv or FILE.parquet" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    ("moves", "words"),
    [
        ("MOVL C00001 V=50.0 PL=0\r\nMOVL C00002 V=50.0 PL=0", ""),
        ("MOVL C00001 V=50.0 PL=2\r\nMOVL C00002 V=50.0 PL=0", "zones of the position levels"),
        ("MOVJ C00001 VJ=50.00 PL=0", "axis speeds"),
    ],
)
def test_inferred_numbers_of_a_robot_are_told_where_they_are_used(moves, words, tmp_path):
    robot = "yaskawa/up20" if "speeds" in words else "yaskawa/ma2010"
    text = (SAMPLES / "inform" / "twins" / "base.jbi").read_bytes().decode()
    head = text[: text.index("MOVJ")]
    path = tmp_path / "A.JBI"
    path.write_bytes(f"{head}MOVL C00000 V=50.0\r\n{moves}\r\nEND\r\n".encode())
    part = time_file(str(path), Job(robot=robot))
    told = [line for line in part.text.splitlines() if "assumed: inferred" in line]
    assert len(told) == bool(words)
    assert all(f"for {robot}: {words} (" in line for line in told)


def test_narrow_terminals_keep_the_ends_of_file_names():
    text, _ = report("text", JOBS[:3], segments=False, width=78)
    lines = text.splitlines()
    assert max(map(len, lines)) <= 78
    assert [line.split()[0][-10:] for line in lines[2:5]] == [job.name[-10:] for job in JOBS[:3]]
    title, _, *rows = report("text", JOBS[:3], segments=False)[0].splitlines()
    assert title.startswith(f"3 programs that a controller starts in {JOBS[0].parent.as_posix()}/: ")
    assert [row.split()[0] for row in rows[:3]] == [job.name for job in JOBS[:3]]
