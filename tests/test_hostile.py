"""What comes from outside runs nothing, hangs nothing, and kills no run: the attacks that once gave way."""

from __future__ import annotations

import csv
import gzip
import io
import os
import re
import resource
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path

import pytest
from cpu_time import cpu_time_below

from bench import fuzz, hostile
from bench.hostile import JOB, SAMPLES
from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.core.files import write_output
from olp.core.source import decode
from olp.core.terminal import csv_text, from_cell
from olp.fluent import read, read_source
from olp.ir.expressions import Function, Named, Number, PositionLiteral, Text
from olp.ir.program import Assign
from olp.runtime import computing

needs_git = pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed")


@needs_git
@pytest.mark.parametrize("attack", hostile.CONFIGURATIONS)
def test_no_program_that_a_repository_names_is_run(attack, tmp_path, monkeypatch, capsys):
    proof = tmp_path / "proof"
    program = tmp_path / "program"
    program.write_text(f"#!/bin/sh\necho ran >> '{proof}'\ncat\n", encoding="utf-8")
    program.chmod(0o755)
    home = tmp_path / "cell"
    (home / "hooks").mkdir(parents=True)
    for hook in ("post-checkout", "post-index-change", "reference-transaction", "fsmonitor-watchman"):
        shutil.copy(program, home / "hooks" / hook)
    hostile.made_repository(home, hostile.CONFIGURATIONS[attack].format(program))
    monkeypatch.chdir(home)
    assert main(["diff", "HEAD~1", "HEAD"]) in (0, 1)
    assert "PICK.JBI" in capsys.readouterr().out
    assert not proof.exists()


@needs_git
def test_an_object_that_is_missing_is_not_fetched_from_where_the_repository_says(
    tmp_path, monkeypatch, capsys
):
    proof = tmp_path / "proof"
    config = (
        f"[remote \"origin\"]\n\turl = ext::sh -c 'echo% ran% >% {proof}'\n\tpromisor = true\n"
        "\tpartialclonefilter = blob:none\n[extensions]\n\tpartialclone = origin\n"
        '[protocol "ext"]\n\tallow = always\n[core]\n\trepositoryformatversion = 1\n'
    )
    home = tmp_path / "cell"
    home.mkdir()
    hostile.made_repository(home, config)
    blob = subprocess.run(
        ["git", "rev-parse", "HEAD:PICK.JBI"], cwd=home, check=True, capture_output=True, text=True
    ).stdout.strip()
    os.remove(home / ".git" / "objects" / blob[:2] / blob[2:])
    monkeypatch.chdir(home)
    assert main(["diff", "HEAD~1", "HEAD"]) == 2
    assert "U002" in capsys.readouterr().err
    assert not proof.exists()


@needs_git
def test_links_of_a_revision_are_read_as_the_file_they_lead_to_within_it(tmp_path, monkeypatch, capsys):
    home = tmp_path / "cell"
    home.mkdir()
    (tmp_path / "secret.JBI").write_bytes(JOB.read_bytes())
    (home / "OUT.JBI").symlink_to(tmp_path / "secret.JBI")
    (home / "IN.JBI").symlink_to("PICK.JBI")
    hostile.made_repository(home)
    monkeypatch.chdir(home)
    assert main(["diff", "HEAD~1", "HEAD"]) in (0, 1)
    said = capsys.readouterr().out
    assert "IN.JBI" in said
    assert "OUT.JBI" not in said


@pytest.mark.parametrize("document", hostile.TOMLS)
@pytest.mark.parametrize("use", ["assumptions", "robot", "mapping", "budgets", "recording"])
def test_a_hostile_toml_file_is_told_in_a_moment(use, document, tmp_path, capsys):
    file = tmp_path / ("recording.toml" if use == "recording" else "olp.toml")
    file.write_text(hostile.TOMLS[document], encoding="utf-8")
    shutil.copy(JOB, tmp_path)
    job = str(tmp_path / JOB.name)
    (tmp_path / "moves.csv").write_text("move,duration_s\n1,1.0\n", encoding="utf-8")
    command = {
        "assumptions": ["time", job],
        "robot": ["time", job, "--robot", str(file)],
        "mapping": ["convert", job, "--to", "krl", "--map", str(file), "-o", str(tmp_path / "out")],
        "budgets": ["check", job, "--no-cache"],
        "recording": ["recording", "check", str(tmp_path)],
    }[use]
    with cpu_time_below(4.0):
        assert main(command) in (0, 1, 2)
    said = capsys.readouterr()
    assert "Traceback" not in said.err
    assert len(said.err) < 60_000


def test_a_device_that_is_full_is_told(capsys):
    assert main(["report", str(JOB), "-o", "/dev/full"]) == 2
    assert "/dev/full" in capsys.readouterr().err


def test_what_is_no_plain_file_is_not_waited_for(tmp_path, capsys):
    os.mkfifo(tmp_path / "PIPE.JBI")
    (tmp_path / "ZERO.JBI").symlink_to("/dev/zero")
    (tmp_path / "SELF.JBI").symlink_to("SELF.JBI")
    for name in ("PIPE.JBI", "ZERO.JBI", "SELF.JBI"):
        for command in (
            ["time"],
            ["lint"],
            ["export", "--to", "inform"],
            ["report", "-o", str(tmp_path / "r.html")],
        ):
            assert main([*command, str(tmp_path / name)]) in (1, 2), (name, command)
            assert name in "".join(capsys.readouterr())


@pytest.mark.parametrize("option", ["--assumptions", "--signature", "--robot"])
def test_settings_that_are_no_plain_file_are_not_waited_for(option, tmp_path, capsys):
    os.mkfifo(tmp_path / "pipe.toml")
    assert main(["time", str(JOB), option, str(tmp_path / "pipe.toml")]) == 2
    assert "pipe.toml" in capsys.readouterr().err


EVIL = b"\x1b]0;owned\x07\x1b[2J\xe2\x80\xae"


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals")
@pytest.mark.parametrize(
    "command",
    [["time"], ["lint"], ["check"], ["time", "--explain", "24"], ["convert", "--to", "krl", "-o", "out"]],
)
def test_no_control_of_a_program_reaches_a_terminal(command, tmp_path):
    for file in JOB.parent.iterdir():
        shutil.copy(file, tmp_path)
    name = "A\x1b[31mB.JBI"
    lines = JOB.read_bytes().replace(b"\r\nNOP\r\n", b"\r\nNOP\r\n'" + EVIL + b"\r\n" + EVIL + b" X\r\n")
    (tmp_path / name).write_bytes(lines)
    ours, theirs = os.openpty()
    words = [sys.executable, "-m", "olp", *command, name]
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parent.parent), "TERM": "xterm"}
    process = subprocess.Popen(
        words, cwd=tmp_path, stdout=theirs, stderr=theirs, stdin=subprocess.DEVNULL, env=environment
    )
    os.close(theirs)
    said = b""
    try:
        while chunk := os.read(ours, 65536):
            said += chunk
    except OSError:  # Linux tells the end of a pseudo-terminal so
        pass
    process.wait(60)
    os.close(ours)
    left = re.sub(rb"\x1b\[(?:0|1|2|31|33)m", b"", said)
    assert said
    assert not re.search(rb"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]|\xe2\x80\xae", left), left[:2000]


@pytest.mark.skipif(os.name == "nt", reason="names of Windows are text")
@pytest.mark.parametrize("form", ["text", "json", "junit", "sarif", "github", "gitlab", "markdown"])
@pytest.mark.parametrize("command", ["lint", "check", "time", "convert"])
def test_a_file_name_that_is_no_text_does_not_end_a_run(command, form, tmp_path, monkeypatch, capfdbinary):
    home = tmp_path / "cell"
    shutil.copytree(JOB.parent, home)
    shutil.copy(JOB, os.fsencode(home) + b"/\x83\x7d\x83b\x83N.JBI")
    monkeypatch.chdir(tmp_path)
    words = [command, "cell", "--format", form]
    if command in ("lint", "check"):
        words += ["--also", f"{form}={tmp_path / 'told'}"]
    elif command == "convert":
        words = [
            "convert",
            "cell",
            "--to",
            "krl",
            "-o",
            str(tmp_path / "out"),
            "--receipt",
            str(tmp_path / "r.json"),
        ]
    elif form not in ("text", "json", "markdown"):
        pytest.skip("olp time has no such format")
    else:
        words += ["-o", str(tmp_path / "told")]
    first = main(words)
    assert first in (0, 1, 2)
    said = b"".join(capfdbinary.readouterr())
    assert b"Traceback" not in said
    assert b"surrogates" not in said
    assert main([*words, *(["--force"] if command == "convert" else [])]) == first


ABSURD = ("1e308", "-1e308", "1e-308", "1e200", "5e-324", "1.7976931348623157e308", "-0.0")
COLUMNS = (
    "duration_s",
    "sim_s",
    "speed_mm_s",
    "accel_mm_s2",
    "x_start_mm",
    "z_end_mm",
    "rx_deg",
    "distance_mm",
)


@pytest.mark.parametrize(
    ("number", "column"), [(ABSURD[n % len(ABSURD)], column) for n, column in enumerate(3 * COLUMNS)]
)
def test_absurd_numbers_of_a_recording_are_told(column, number, tmp_path, capsys):
    home = tmp_path / "recording"
    home.mkdir()
    rows = (SAMPLES / "up20" / "moves.csv").read_text(encoding="utf-8").splitlines()[:25]
    at = rows[0].split(",").index(column)
    for line in (3, 7, 11):
        cells = rows[line].split(",")
        rows[line] = ",".join([*cells[:at], number, *cells[at + 1 :]])
    (home / "moves.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    for command in (["recording", "check"], ["diagnose"]):
        assert main([*command, str(home)]) in (0, 1, 2), command
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        if abs(float(number)) > 1e100:
            assert "D015" in said.err


@pytest.mark.parametrize("nested", hostile.NESTED)
@pytest.mark.parametrize("vendor", hostile.HEADS)
@pytest.mark.parametrize("deep", [150, 500, 20_000])
def test_expressions_without_an_end_are_read_in_a_moment(vendor, nested, deep):
    before, after = hostile.HEADS[vendor]
    raw = (before + hostile.NESTED[nested](deep) + after).encode()
    with cpu_time_below(4.0):
        try:
            program = read_source(decode(raw, "p"), vendor=vendor)
            assert program.to_bytes() == raw
            program.plan()
        except OlpError:
            pass


FORMULAS = ("=1+1", "@SUM(A1)", "+cmd|' /C calc'!A0", "-2+3", "'=1", "''@x", "-1.5", "'", "plain", "=a,b\n=c")


def test_no_text_in_a_table_is_a_formula_and_every_text_comes_back():
    rows = list(csv.reader(io.StringIO(csv_text([FORMULAS, ("\t=1", "\r=1", -2.5)]))))
    cells = [cell for row in rows for cell in row]
    assert [cell for cell in cells if cell[0] in "=+-@\t\r"] == ["-1.5", "-2.5"]
    assert tuple(map(from_cell, rows[0])) == FORMULAS


def test_no_table_that_a_command_writes_holds_a_formula(tmp_path, monkeypatch, capsysbinary):
    for file in JOB.parent.iterdir():
        shutil.copy(file, tmp_path)
    for name in ("=A.JBI", "@B.JBI", os.fsdecode(b"\x83N.JBI")):
        shutil.copy(JOB, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    for words in (["time", "=A.JBI", "@B.JBI", "--format", "csv"], ["track", "=A.JBI", "--dt", "1"]):
        assert main(words) == 0, words
        said = capsysbinary.readouterr().out.decode()
        cells = [cell for row in csv.reader(io.StringIO(said)) for cell in row]
        assert "'=A.JBI" in cells
        assert not [cell for cell in cells if cell[:1] in tuple("=@")]
    assert main(["track", os.fsdecode(b"\x83N.JBI"), "--dt", "1"]) == 0


def test_what_a_killed_run_has_left_and_a_long_name_are_not_in_the_way(tmp_path):
    for name in ("out.csv", "o" * 255):
        with suppress(OSError):
            (tmp_path / f".{name}.{os.getpid()}.part").write_text("half", encoding="utf-8")
        write_output(tmp_path / name, b"whole")
        assert (tmp_path / name).read_bytes() == b"whole"


@pytest.mark.parametrize("document", hostile.JSONS)
def test_hostile_json_is_told_or_passed_over(document, tmp_path, capsys):
    text = hostile.JSONS[document]
    for name in ("signature.json", "X.JBI"):
        (tmp_path / name).write_text(text, encoding="utf-8")
    report = tmp_path / "report.html"
    summary = '<script type="application/json" id="summary">'
    report.write_text(f"<html>{summary}{text}</script>{summary * 2_000}", encoding="utf-8")
    assert main(["report", str(JOB), "-o", str(tmp_path / "report.html")]) == 0
    assert main(["time", str(JOB), "--signature", str(tmp_path / "signature.json")]) == 2
    assert main(["lint", str(JOB), "--baseline", str(tmp_path / "signature.json")]) in (0, 1, 2)
    assert main(["time", str(tmp_path / "X.JBI")]) == 2
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize("group", hostile.GROUPS)
def test_an_attack_of_each_kind_ends_in_a_moment_and_says_why(group, monkeypatch):
    # A child begins with the memory of the process that runs the tests.
    own_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    monkeypatch.setattr(hostile, "LIMIT_MB", hostile.LIMIT_MB + own_mb)
    assert [one for one in hostile.attacked(group, 0) if one.fault] == []


@pytest.mark.parametrize("target", fuzz.TARGETS)
def test_what_fuzzing_kept_is_held(target):
    ran = fuzz.replay(target)
    assert ran.inputs > 0
    assert [problem.where for _, problem in ran.faults] == []


def _commit() -> int:
    """Changes with every commit, so that CI draws others each time and a red run can be repeated; 0 outside git."""
    git = ["git", "-C", str(fuzz.ROOT), "rev-parse", "HEAD"]
    try:
        return int(subprocess.run(git, capture_output=True, text=True, check=True).stdout[:8], 16)
    except (OSError, subprocess.CalledProcessError):
        return 0


@pytest.mark.slow
@pytest.mark.parametrize("target", fuzz.TARGETS)
def test_changed_inputs_are_held(target, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # what is found is written there
    seed = _commit()
    ran = fuzz.changed(target, 0.5, seed)
    assert ran.inputs > 0
    again = f"python bench/fuzz.py {target} --seconds 30 --seed {seed}"
    assert [problem.where for _, problem in ran.faults] == [], again


BOMBS = {
    "moves.csv.gz": gzip.compress(b"1," * 40_000_000, 1),
    "log.csv.gz": gzip.compress(b"\n" * 80_000_000, 1),
    "moves.csv": b"move,duration_s\n" + b"1," * 600_000,
    "A.JBI": b"\n" * 1_000_001,
    "a.urp": gzip.compress('<!DOCTYPE l [<!ENTITY a "b">]><URProgram>&a;</URProgram>'.encode("utf-16")),
}


@pytest.mark.parametrize("name", BOMBS)
def test_a_few_bytes_that_become_many_are_told_before_they_do(name, tmp_path, capsys):
    (tmp_path / name).write_bytes(BOMBS[name])
    words = ["diagnose", str(tmp_path)] if ".csv" in name else ["time", str(tmp_path / name)]
    with cpu_time_below(2.0):
        assert main(words) == 2
    assert re.search("P004|P562|D00[23]", capsys.readouterr().err)


def test_a_table_takes_a_name_that_is_no_text(tmp_path):
    name = os.fsencode(tmp_path) + b"/\x83N.JBI"
    Path(os.fsdecode(name)).write_bytes(JOB.read_bytes())
    table = read(os.fsdecode(name)).plan().time()
    assert table["file"].str.contains(r"udc83N.JBI", regex=False).all()


ENDLESS = {
    "P.JBI": "/JOB\n//NAME P\n//POS\n///NPOS 0,0,0,0,0,0\n//INST\n///DATE 2020/01/01 00:00\n///ATTR SC,RW\nNOP\n"
    "*A\nDOUT OT#(1) ON\nJUMP *A\nEND\n",
    "loop.src": "DEF loop()\nLOOP\nENDLOOP\nEND\n",
    "true.src": "DEF true()\nINT i\nWHILE TRUE\ni = i + 1\nENDWHILE\nEND\n",
    "wait.src": "DEF wait()\nLOOP\nWAIT SEC 0.1\nENDLOOP\nEND\n",
    "for.src": "DEF for()\nINT i\nFOR i = 1 TO 2147483647\nWAIT SEC 0.1\nENDFOR\nEND\n",
    "self.src": "DEF self()\nself()\nEND\n",
}


@pytest.mark.parametrize("name", ENDLESS)
def test_no_budget_is_held_by_a_program_that_never_ends(name, tmp_path, capsys):
    (tmp_path / name).write_text(ENDLESS[name], encoding="utf-8")
    (tmp_path / "olp.toml").write_text("[[budget]]\nlimit_s = 1e9\n", encoding="utf-8")
    with cpu_time_below(4.0):
        assert main(["check", str(tmp_path), "--no-cache"]) == 2
    assert re.search("I10[689]", capsys.readouterr().out)


@pytest.mark.parametrize("turn", ["1e99 * 1e99, 0, 0", "0, -n * n, n * n", "n, 0, 0"])
def test_a_turn_without_a_measure_is_told(turn, tmp_path, capsys):
    script = tmp_path / "a.script"
    script.write_text(
        f"def a():\n  n = 1e99 * 1e99\n  movel(p[0.1, 0.2, 0.3, {turn}])\nend\n", encoding="utf-8"
    )
    assert main(["time", str(script)]) == 2
    assert "I202" in capsys.readouterr().err


BEYOND_REALS = {
    "a.src": "DEF a()\nx = $TIMER[1E999]\ny[1E999] = 3\nEND\n",
    "a.mod": "MODULE a\n  PROC main()\n    x{1e999} := 3;\n  ENDPROC\nENDMODULE\n",
    "a.script": "def a():\n  y = [1]\n  y[1e999] = 3\n  movel(p[1e999, 0, 0, 0, 0, 0])\nend\n",
    "a.as": ".PROGRAM a()\n  TWAIT 1E999\n.END\n",
    "a.pdl": "PROGRAM a\nBEGIN\n  DELAY 1E999\nEND a\n",
    "a.ls": "/PROG A\n/MN\n   1:  R[1E999]=3 ;\n/POS\n/END\n",
}


@pytest.mark.parametrize("name", BEYOND_REALS)
def test_a_number_beyond_all_reals_is_told_where_it_stands(name, tmp_path, capsys):
    (tmp_path / name).write_text(BEYOND_REALS[name], encoding="utf-8")
    assert main(["lint", str(tmp_path / name)]) != 0
    wrong = BEYOND_REALS[name].lower().splitlines()
    told = capsys.readouterr().out
    assert all(f"{name}:{row}:" in told for row, line in enumerate(wrong, 1) if "1e999" in line)


def test_a_pipe_that_nobody_reads_is_not_waited_for(tmp_path, capsys):
    os.mkfifo(tmp_path / "pipe")
    assert main(["time", str(JOB), "--format", "csv", "-o", str(tmp_path / "pipe")]) == 2
    assert "pipe" in capsys.readouterr().err


STORES = {
    "a trigger": "create trigger t after insert on program begin delete from run; end",
    "a view in place of a table": "drop table item; create view item as select 1",
}


@pytest.mark.parametrize("attack", STORES)
def test_a_store_that_does_more_than_keep_is_refused(attack, tmp_path, capsys):
    store = str(tmp_path / "store")
    assert main(["check", str(JOB), "--no-cache", "--store", store]) in (0, 1, 2)
    with closing(sqlite3.connect(store)) as file:
        file.executescript(STORES[attack])
    capsys.readouterr()
    for command in (["check", str(JOB), "--no-cache"], ["trend", "PICK"]):
        assert main([*command, "--store", store]) == 2
        assert "M004" in capsys.readouterr().err


@pytest.mark.parametrize("odd", ["x", b"\xff", 1e300, "null", "nan"])
def test_rows_of_a_store_that_olp_cannot_have_written_are_passed_over(odd, tmp_path, capsys):
    store = str(tmp_path / "store")
    for _ in range(2):
        assert main(["check", str(JOB), "--no-cache", "--store", store]) in (0, 1, 2)
    with closing(sqlite3.connect(store)) as file:
        file.execute("update program set total_s = ? where run = 1", (odd,))
        file.commit()
    capsys.readouterr()
    assert main(["trend", "PICK", "--store", store]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 2


def test_lint_says_why_it_cannot_judge_a_program_in_every_format(tmp_path, capsys):
    (tmp_path / "p.pgx").write_text('<?xml version="1.0"?>' + "<Programs>" * 60, encoding="utf-8")
    for form in ("text", "json", "junit", "sarif", "github", "gitlab", "markdown"):
        assert main(["lint", str(tmp_path / "p.pgx"), "--format", form]) == 2
        assert "the file holds no routine" in capsys.readouterr().out, form


ARGUMENTS = (Number(1), Number(1e300), Text("a"), Named("x"), PositionLiteral("pose", (0.0,) * 6))


@pytest.mark.parametrize("argument", ARGUMENTS)
def test_functions_with_too_few_or_absurd_arguments_are_told(argument):
    """In a statement, and where a variable is declared, which is before anything runs."""
    program = read_source(decode(b"def a():\n  x = 1\nend\n", "a.script"))
    (routine,) = program.routines
    (declared,) = routine.body
    calls = [
        Function(name, (argument,) * n)
        for name in {**computing.FUNCTIONS, **computing._FURTHER}
        for n in range(7)
    ]
    body = tuple(Assign(2, Named("x"), call) for call in calls)
    data = tuple(replace(declared, name=f"y{n}", value=call) for n, call in enumerate(calls))
    plan = replace(program, data=data, routines=(replace(routine, body=body),)).plan()
    told = {d.code for d in plan.diagnostics}
    assert "I222" in told
    assert "C016" not in told
