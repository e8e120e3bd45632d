"""`olp check`: budgets of programs, routines and spans, and what is told of those that do not hold."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from guard_cells import CELL, cell, check
from hypothesis import given, settings
from hypothesis import strategies as st

from olp.__main__ import main
from olp.checks.guard.budget import Budget, budgets_for
from olp.checks.guard.run import judge
from olp.identification.recording import read_recording
from olp.identification.signature import calibrate, write_signature
from olp.reports.batch import Job, plan_and_time

SAMPLES = Path(__file__).parent.parent / "samples" / "inform"
UP20 = SAMPLES.parent / "up20"


def seconds(path: Path, toml: str) -> float | None:
    """What the budget of `toml` measures in the program."""
    (path.parent / "olp.toml").write_text(f"[[budget]]\nname = 'b'\nlimit_s = 1000\n{toml}", encoding="utf-8")
    read, *_ = budgets_for(str(path))
    assert not read.diagnostics, read.diagnostics
    (item,) = judge(str(path), read.budgets, Job()).items
    return item.seconds


def rows(path: Path) -> list[tuple[str, int, float]]:
    """(job, line, seconds) of each step."""
    timing = plan_and_time(str(path), Job())
    return [(Path(s["file"]).stem, s["line"], s["duration_s"]) for s in timing.segments()]


def line_of(path: Path, text: str) -> int:
    return 1 + next(n for n, line in enumerate(path.read_text().splitlines()) if text in line)


def test_a_budget_measures_the_total_and_its_parts(tmp_path):
    path = cell(tmp_path)
    timing = plan_and_time(str(path), Job())
    assert seconds(path, "") == pytest.approx(timing.total_s)
    assert seconds(path, "of = 'motion'") == pytest.approx(timing.motion_s)
    assert seconds(path, "of = 'wait'") == pytest.approx(2 * 0.25 + 0.7)
    assert seconds(path, "of = 'io'") == 0.0


def test_a_routine_called_twice_in_a_row_is_measured_once_and_the_longer_counts(tmp_path):
    path = cell(tmp_path)
    steps = [duration for job, _, duration in rows(path) if job == "GRIP"]
    first, second = sum(steps[:4]), sum(steps[4:])
    assert first != second
    assert seconds(path, "routine = 'GRIP'\njob = 'MAIN'") == pytest.approx(max(first, second))


def test_a_span_holds_what_is_called_between_its_labels(tmp_path):
    path = cell(tmp_path)
    stop = line_of(path, "*FINISH")
    start = line_of(path, "*START")
    wanted = sum(s for job, line, s in rows(path) if job == "GRIP" or start < line < stop)
    assert seconds(path, "from = 'START'\nto = '*FINISH'\njob = 'MAIN'") == pytest.approx(wanted)


def test_a_span_that_ends_before_a_call_does_not_hold_the_call(tmp_path):
    path = cell(tmp_path, jobs=CELL | {"MAIN": """
        *A
        MOVL C00001 V=200.0 PL=0
        *B
        CALL JOB:GRIP
        MOVL C00002 V=150.0 PL=0
        """})  # fmt: skip
    assert seconds(path, "from = 'A'\nto = 'B'\njob = 'MAIN'") == pytest.approx(rows(path)[0][2])


def test_a_span_that_only_calls_is_measured(tmp_path):
    path = cell(tmp_path, jobs=CELL | {"MAIN": "*A\nCALL JOB:GRIP\n*B\nMOVL C00002 V=150.0 PL=0"})
    wanted = sum(s for job, _, s in rows(path) if job == "GRIP")
    assert seconds(path, "from = 'A'\nto = 'B'\njob = 'MAIN'") == pytest.approx(wanted)


@pytest.mark.parametrize("times", [1, 2, 5])
def test_a_span_that_a_jump_repeats_is_measured_once(tmp_path, times):
    path = cell(tmp_path, jobs={"MAIN": f"""
        MOVL C00000 V=100.0
        *A
        MOVL C00003 V=200.0 PL=0
        MOVL C00001 V=200.0 PL=0
        INC B000
        *B
        JUMP *A IF B000<{times}
        """})  # fmt: skip
    two = [s for _, line, s in rows(path) if line > line_of(path, "*A")]
    assert len(two) == 2 * times
    longest = max(a + b for a, b in zip(two[::2], two[1::2], strict=True))
    assert seconds(path, "from = 'A'\nto = 'B'") == pytest.approx(longest)


def test_a_loop_within_a_span_belongs_to_one_execution(tmp_path):
    path = cell(tmp_path, jobs={"MAIN": """
        MOVL C00000 V=100.0
        *A
        FOR B000 START= 1 TO 3
        MOVL C00003 V=200.0 PL=0
        MOVL C00001 V=200.0 PL=0
        NEXT B000
        *B
        MOVL C00002 V=150.0 PL=0
        """})  # fmt: skip
    wanted = sum(s for _, line, s in rows(path) if line_of(path, "*A") < line < line_of(path, "*B"))
    assert seconds(path, "from = 'A'\nto = 'B'") == pytest.approx(wanted)


def test_a_routine_that_a_called_one_calls_is_measured_execution_by_execution(tmp_path):
    path = cell(tmp_path, jobs={
        "MAIN": "MOVL C00000 V=100.0\nCALL JOB:CELL",
        "CELL": "CALL JOB:GRIP\nCALL JOB:GRIP\nCALL JOB:GRIP",
        "GRIP": CELL["GRIP"],
    })  # fmt: skip
    steps = np.array([s for job, _, s in rows(path) if job == "GRIP"]).reshape(3, 4).sum(axis=1)
    assert seconds(path, "routine = 'GRIP'\njob = 'MAIN'") == pytest.approx(steps.max())


def test_the_main_routine_is_the_whole_program(tmp_path):
    path = cell(tmp_path)
    assert seconds(path, "routine = 'MAIN'\njob = 'MAIN'") == pytest.approx(
        plan_and_time(str(path), Job()).total_s
    )


@pytest.mark.parametrize(
    ("toml", "status"),
    [
        ("limit_s = 3.0", "failed"),
        ("limit_s = 3.0\nlevel = 'warn'", "warned"),
        ("limit_s = 50.0", "held"),
        ("limit_s = 50.0\nwarn_s = 3", "warned"),
        ("limit_s = 50.0\nwarn_pct = 8", "warned"),
        ("limit_s = 50.0\nwarn_pct = 90", "held"),
        ("limit_s = 3.0\ntolerance_s = 20", "held"),
        ("limit_s = 3.0\ntolerance_pct = 300", "held"),
        ("limit_s = 3.0\ntolerance_pct = 3", "failed"),
        ("limit_s = 0", "failed"),
        ("limit_s = 50\non = 'upper'", "held"),
        ("limit_s = 50\nroutine = 'NOWHERE'", "unknown"),
        ("limit_s = 50\nfrom = 'FINISH'\nto = 'START'", "unknown"),
    ],
)
def test_a_budget_holds_warns_fails_or_cannot_be_judged(tmp_path, monkeypatch, toml, status):
    cell(tmp_path, f"[[budget]]\nname = 'b'\njob = 'MAIN'\n{toml}")
    assert check(tmp_path, monkeypatch).items == {"b": status}


@given(limit=st.floats(0, 20), tolerance=st.floats(0, 5), warn=st.floats(0, 30))
@settings(max_examples=60, deadline=None)
def test_a_budget_is_over_exactly_when_its_seconds_exceed_limit_and_tolerance(
    tmp_path_factory, limit, tolerance, warn
):
    path = _one_cell(tmp_path_factory)
    budget = Budget("b", str(path.parent), 1, limit, tolerance, warn)
    (item,) = judge(str(path), (budget,), Job()).items
    expected = "failed" if item.seconds > limit + tolerance else "warned" if item.seconds >= warn else "held"
    assert item.status == expected


def _one_cell(factory, known: list[Path] = []) -> Path:  # noqa: B006, one for all examples
    if not known:
        known.append(cell(factory.mktemp("cell")))
    return known[0]


def test_a_budget_over_its_limit_names_the_lines_and_what_would_help(tmp_path, capsys, monkeypatch):
    path = cell(tmp_path, "[[budget]]\nname = 'promised'\njob = 'MAIN'\nlimit_s = 3\n")
    monkeypatch.chdir(tmp_path)
    assert main(["check", "--no-cache", "--format", "json"]) == 1
    told = json.loads(capsys.readouterr().out)
    head, *worst = told["findings"]
    assert head["code"] == "M010"
    assert head["numbers"]["over_s"] == pytest.approx(plan_and_time(str(path), Job()).total_s - 3, abs=1e-6)
    by_line: dict[tuple[str, int], float] = {}
    for job, line, s in rows(path):
        by_line[job, line] = by_line.get((job, line), 0.0) + s
    order = sorted(by_line, key=lambda key: -by_line[key])[:3]
    assert [(Path(f["file"]).stem, f["line"]) for f in worst] == order
    assert all(f["help"] for f in worst)


def test_what_helps_is_said_for_what_limits_the_line(tmp_path):
    path = cell(tmp_path, jobs={"MAIN": """
        MOVL C00000 V=100.0
        MOVL C00011 V=50.0 PL=0
        MOVL C00010 V=1500.0 PL=0
        TIMER T=3.00
        """})  # fmt: skip
    found = judge(str(path), (Budget("b", str(tmp_path), 1, 1.0),), Job()).findings
    helps = {f.line: f.help for f in found if f.code == "M011"}
    assert "programmed speed" in helps[line_of(path, "C00011 V")]
    assert "more speed changes nothing" in helps[line_of(path, "C00010 V")]
    assert "a wait" in helps[line_of(path, "TIMER")]


@pytest.mark.parametrize(
    ("pattern", "covered"),
    [
        ("'*.jbi'", {"MAIN.JBI", "a/MAIN.JBI", "a/b/GRIP.JBI"}),
        ("'MAIN.JBI'", {"MAIN.JBI", "a/MAIN.JBI"}),
        ("'a/*.jbi'", {"a/MAIN.JBI"}),
        ("'a\\*.jbi'", {"a/MAIN.JBI"}),
        ("'a/**'", {"a/MAIN.JBI", "a/b/GRIP.JBI"}),
        ("'a/'", {"a/MAIN.JBI", "a/b/GRIP.JBI"}),
        ("['a/b/*', 'MA?N.jbi']", {"MAIN.JBI", "a/MAIN.JBI", "a/b/GRIP.JBI"}),
        ("'**/GRIP.JBI'", {"a/b/GRIP.JBI"}),
        ("'c/*'", set()),
    ],
)
def test_patterns_are_seen_from_the_file_that_holds_them(tmp_path, pattern, covered):
    (tmp_path / "olp.toml").write_text(f"[[budget]]\nlimit_s = 1\nfiles = {pattern}\n")
    everything = ["MAIN.JBI", "a/MAIN.JBI", "a/b/GRIP.JBI"]
    found = set()
    for name in everything:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        read, *_ = budgets_for(str(tmp_path / name))
        found |= {name for budget in read.budgets if budget.covers(str(tmp_path / name))}
    assert found == covered


def test_budgets_of_folders_above_hold_too_but_not_beyond_a_repository(tmp_path, monkeypatch):
    cell(tmp_path / "repo" / "cell", "[[budget]]\nname = 'near'\njob = 'MAIN'\nlimit_s = 1\n")
    (tmp_path / "repo" / ".git").mkdir()
    (tmp_path / "repo" / "olp.toml").write_text("[[budget]]\nname = 'above'\njob = 'MAIN'\nlimit_s = 100\n")
    (tmp_path / "olp.toml").write_text("[[budget]]\nname = 'outside'\nlimit_s = 1\n")
    assert check(tmp_path, monkeypatch).items == {"near": "failed", "above": "held"}


@pytest.mark.parametrize(
    ("toml", "code", "line"),
    [
        ("[[budget]]\n", "M001", 1),
        ("\n[[budget]]\nlimit_s = -1", "M001", 2),
        ("[[budget]]\nlimit_s = true", "M001", 1),
        ("[[budget]]\nlimit_s = inf", "M001", 1),
        ("[[budget]]\nlimit_s = 1\nof = 'all'", "M001", 1),
        ("[[budget]]\nlimit_s = 1\non = 'upper'\nof = 'wait'", "M001", 1),
        ("[[budget]]\nlimit_s = 1\nfrom = 'A'", "M001", 1),
        ("[[budget]]\nlimit_s = 1\nfiles = [3]", "M001", 1),
        ("[[budget]]\nlimit_s = 1\nfiles = []", "M001", 1),
        ("[[budget]]\nlimit_s = 1\nname = 3", "M001", 1),
        ("[[budget]]\nlimit_s = 1\ntolerance_s = 1\ntolerance_pct = 1", "M001", 1),
        ("[[budget]]\nlimit_s = 1\nlimt_s = 2", "M002", 1),
        ("[budget]\nlimit_s = 1", "M001", 0),
        ("[[budget]]\nlimit_s = = 1", "M001", 2),
        ("[[budget]]\nlimit_s = 1\njob = 'NOBODY'", "M007", 1),
    ],
)
def test_a_budget_that_says_nonsense_is_told_with_its_line_and_never_held(
    tmp_path, capsys, monkeypatch, toml, code, line
):
    cell(tmp_path, toml)
    monkeypatch.chdir(tmp_path)
    assert main(["check", "--no-cache", "--format", "json"]) == 2
    findings = json.loads(capsys.readouterr().out)["findings"]
    told = {(f["code"], f["file"], f["line"]) for f in findings}
    assert (code, "olp.toml", line) in told


def test_a_part_that_only_some_programs_have_is_judged_where_it_is(tmp_path, monkeypatch):
    cell(tmp_path, "[[budget]]\nname = 'span'\nfrom = 'START'\nto = 'FINISH'\nlimit_s = 100\n")
    found = check(tmp_path, monkeypatch)
    assert {Path(r.path).name: len(r.items) for r in found.results} == {"MAIN.JBI": 1, "GRIP.JBI": 0}


def test_no_budget_at_all_is_no_success(tmp_path, capsys, monkeypatch):
    cell(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(["check", "--no-cache"]) == 2
    assert "no budget holds" in capsys.readouterr().out


def test_a_folder_without_programs_and_a_budget_file_that_is_not_there_are_told(tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    assert main(["check", "--no-cache", str(tmp_path / "empty")]) == 2
    assert "C004" in capsys.readouterr().err
    path = cell(tmp_path)
    assert main(["check", "--no-cache", str(path), "--budgets", str(tmp_path / "none.toml")]) == 2
    assert "M001" in capsys.readouterr().err


def test_given_budgets_hold_for_programs_below_them(tmp_path, capsys):
    cell(tmp_path / "jobs", "[[budget]]\nlimit_s = 0\n")
    (tmp_path / "budgets.toml").write_text("[[budget]]\nname = 'given'\nlimit_s = 100\n")
    arguments = ["check", "--no-cache", str(tmp_path / "jobs"), "--budgets", str(tmp_path / "budgets.toml")]
    assert main(arguments) == 0
    assert "given" in capsys.readouterr().out


def test_a_program_that_cannot_be_read_is_unknown_and_not_held(tmp_path, monkeypatch):
    shutil.copy(SAMPLES / "broken" / "binary.jbi", tmp_path / "MAIN.JBI")
    (tmp_path / "olp.toml").write_text("[[budget]]\nname = 'b'\nlimit_s = 100\n")
    assert check(tmp_path, monkeypatch).items == {"b": "unknown"}


def test_a_step_without_a_time_makes_the_budget_unknown(tmp_path, monkeypatch):
    cell(
        tmp_path,
        "[[budget]]\nname = 'b'\nlimit_s = 100\n",
        {"MAIN": "MOVL P090 V=100.0\nMOVL C00001 V=100.0"},
    )
    assert check(tmp_path, monkeypatch).items == {"b": "unknown"}


def test_programs_that_fail_come_first_the_one_most_over_before_all(tmp_path, capsys, monkeypatch):
    slow = "MOVL C00001 V=10.0\nMOVL C00000 V=10.0"
    cell(tmp_path, "[[budget]]\nname = 'b'\nlimit_s = 1.5\n", {
        "A": "MOVL C00001 V=500.0", "B": "TIMER T=2.00", "C": slow, "D": "MOVL C00001 V=500.0",
    })  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert main(["check", "--no-cache", "--format", "json"]) == 1
    files = [item["file"] for item in json.loads(capsys.readouterr().out)["items"]]
    assert files[:2] == ["C.JBI", "B.JBI"]


def test_a_program_that_is_not_whole_has_no_total_in_the_store(tmp_path, capsys, monkeypatch):
    path = cell(tmp_path)
    text = path.read_bytes()
    path.write_bytes(text.replace(b"MOVL C00002 V=150.0 PL=0", b"MOVL C00002 V=15O.0 PL=0"))
    monkeypatch.chdir(tmp_path)
    main(["check", "--store", "olp.db", "."])
    capsys.readouterr()
    assert main(["trend", "MAIN", "--format", "json"]) == 0
    assert [point["total_s"] for point in json.loads(capsys.readouterr().out)] == [None]


def test_a_store_keeps_runs_and_trend_shows_the_change(tmp_path, capsys, monkeypatch):
    path = cell(tmp_path, "[[budget]]\nlimit_s = 100\n")
    monkeypatch.chdir(tmp_path)
    assert main(["check", "--store", "olp.db"]) == 0
    before = plan_and_time(str(path), Job()).total_s
    path.write_bytes(path.read_bytes().replace(b"V=200.0", b"V=20.0"))
    assert main(["check", "--store", "olp.db"]) == 0
    after = plan_and_time(str(path), Job()).total_s
    capsys.readouterr()
    for name in ("MAIN", "MAIN.JBI", "main"):
        assert main(["trend", name, "--format", "json"]) == 0
        points = json.loads(capsys.readouterr().out)
        assert [p["total_s"] for p in points] == pytest.approx([before, after])
    assert main(["trend", "MAIN", "--last", "1", "--format", "csv"]) == 0
    assert capsys.readouterr().out.count("MAIN.JBI") == 1
    assert main(["trend", "MAIN"]) == 0
    assert f"{after - before:+.3f}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["trend", "NOBODY"], "M005"),
        (["trend", "MAIN", "--store", "none.db"], "M004"),
        (["trend", "MAIN", "--store", "MAIN.JBI"], "M004"),
        (["check", "--store", "MAIN.JBI"], "M004"),
        (["check", "--store", ".olp-cache"], "M004"),
        (["check", "--store", "no/folder/olp.db"], "M004"),
        (["check", "--cache", "MAIN.JBI"], "M006"),
        (["check", "--cache", "olp.db"], "M006"),
        (["check", "--format", "html"], "C011"),
    ],
)
def test_files_that_are_something_else_are_refused_and_left_alone(
    tmp_path, capsys, monkeypatch, arguments, code
):
    path = cell(tmp_path, "[[budget]]\nlimit_s = 100\n")
    monkeypatch.chdir(tmp_path)
    assert main(["check", "--store", "olp.db"]) == 0
    before = path.read_bytes()
    assert main(arguments) == 2
    assert code in capsys.readouterr().err
    assert path.read_bytes() == before


def test_the_upper_end_of_the_interval_is_judged_with_the_budgets_own_signature(
    tmp_path, monkeypatch, signature
):
    home = tmp_path / "cell"
    shutil.copytree(UP20, home, ignore=lambda _, names: [n for n in names if n == "olp.toml"])
    shutil.copy(signature, home / "robot.json")
    path = home / "APPR-L.JBI"
    robot = (UP20 / "olp.toml").read_text() if (UP20 / "olp.toml").exists() else ""
    (home / "olp.toml").write_text(robot)
    timing = plan_and_time(str(path), Job(signature=str(signature)))
    between = (timing.total_s + timing.high_s) / 2
    budget = "[[budget]]\nname = '{}'\njob = 'APPR-L'\non = '{}'\nsignature = 'robot.json'\nlimit_s = {}\n"
    (home / "olp.toml").write_text(
        robot
        + "\n"
        + budget.format("middle", "prediction", between)
        + budget.format("upper", "upper", between)
        + budget.format("above", "upper", timing.high_s + 0.01)
    )
    monkeypatch.chdir(tmp_path)  # the signature is seen from olp.toml, not from here
    assert check(tmp_path, monkeypatch).items == {"middle": "held", "upper": "failed", "above": "held"}


@pytest.fixture(scope="module")
def signature(tmp_path_factory) -> Path:
    """One of a recording of the samples."""
    path = tmp_path_factory.mktemp("signature") / "robot.json"
    write_signature(calibrate(read_recording(UP20), "factors")[0], path)
    return path


def test_one_run_tells_several_ways_and_each_as_if_alone(tmp_path, capsys, monkeypatch):
    cell(tmp_path, "[[budget]]\nname = 'b'\nlimit_s = 1\n")
    monkeypatch.chdir(tmp_path)
    for command in (["check"], ["lint", "--fail-on", "note"], ["diff", "MAIN.JBI", "GRIP.JBI"]):
        files = {form: f"{command[0]}.{form}" for form in ("junit", "sarif", "markdown")}
        also = [word for form, file in files.items() for word in ("--also", f"{form}={file}")]
        status = main([*command, *also])
        text = capsys.readouterr().out
        assert main(command) == status
        assert capsys.readouterr().out == text
        for form, file in files.items():
            assert main([*command, "--format", form, "-o", "alone"]) == status
            assert Path(file).read_bytes() == Path("alone").read_bytes()


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["--also", "junit"], "C002"),
        (["--also", "=x"], "C002"),
        (["--also", "junit="], "C002"),
        (["--also", "nonsense=x"], "C011"),
        (["-o", "x", "--also", "junit=./x"], "C002"),
        (["--also", "junit=MAIN.JBI"], "C006"),
    ],
)
def test_files_of_further_formats_that_make_no_sense_are_refused(tmp_path, capsys, monkeypatch, words, code):
    path = cell(tmp_path, "[[budget]]\nlimit_s = 100\n")
    before = path.read_bytes()
    monkeypatch.chdir(tmp_path)
    assert main(["check", *words]) == 2
    assert f"error[{code}]" in capsys.readouterr().err
    assert path.read_bytes() == before


def test_the_lower_end_calls_a_budget_over_only_where_that_is_sure(tmp_path, monkeypatch, signature):
    home = tmp_path / "cell"
    shutil.copytree(UP20, home)
    shutil.copy(signature, home / "robot.json")
    path = home / "APPR-L.JBI"
    timing = plan_and_time(str(path), Job(signature=str(signature)))
    assert timing.low_s < timing.total_s < timing.high_s
    budget = "[[budget]]\nname = '{}'\njob = 'APPR-L'\non = 'lower'\nsignature = 'robot.json'\n"
    budget += "limit_s = {}\nlevel = '{}'\n"
    settings = home / "olp.toml"
    settings.write_text(
        (settings.read_text() if settings.exists() else "")
        + "\n"
        + budget.format("sure", timing.low_s - 0.01, "fail")
        + budget.format("shown", timing.low_s - 0.01, "warn")
        + budget.format("unsure", (timing.low_s + timing.total_s) / 2, "fail")
        + budget.format("below", timing.total_s + 1e-6, "fail")
    )
    monkeypatch.chdir(tmp_path)
    found = check(tmp_path, monkeypatch)
    assert found.items == {"sure": "failed", "shown": "warned", "unsure": "warned", "below": "held"}
    says = {item.name: item.message for result in found.results for item in result.items}
    assert "lower end" in says["sure"]
    assert "within the interval" in says["unsure"]


@pytest.mark.parametrize("on", ["upper", "lower"])
def test_an_end_of_the_interval_is_known_of_a_whole_program_without_a_signature(tmp_path, monkeypatch, on):
    path = cell(tmp_path, f"[[budget]]\nname = 'b'\nlimit_s = 100\non = '{on}'\n")
    assert check(tmp_path, monkeypatch).items == {"b": "held"}
    timing = plan_and_time(str(path), Job())
    assert timing.expected_low_s < timing.total_s < timing.expected_high_s
    assert seconds(path, f"on = '{on}'") == (
        timing.expected_high_s if on == "upper" else timing.expected_low_s
    )
    (tmp_path / "olp.toml").write_text(f"[[budget]]\nlimit_s = 100\non = '{on}'\nof = 'wait'\n")
    (read,) = budgets_for(str(tmp_path / "MAIN.JBI"))
    assert [d.code for d in read.diagnostics] == ["M001"]


def test_versions_that_are_timed_in_part_only_are_not_called_held(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    job = (SAMPLES / "palletising" / "PICK.JBI").read_bytes()
    for name, speed in (("old", b"100.0"), ("new", b"90.0")):
        shutil.copytree(SAMPLES / "palletising", tmp_path / name)
        line = b"MOVL P099 V=" + speed + b"\r\nEND\r\n"
        (tmp_path / name / "PICK.JBI").write_bytes(re.sub(rb"END\s*$", line, job))
    assert main(["diff", "old/PICK.JBI", "new/PICK.JBI"]) == 2
    told = capsys.readouterr().out
    assert "unknown" in told
    assert "the new version is timed in part only, 1 finding: line " in told
