"""`olp lint`: every rule finds its planted mistake and nothing in clean programs; baselines, excuses, fixes."""

from __future__ import annotations

import json
import random
import re
from pathlib import Path

import pytest
from guard_cells import CELL, cell
from interpreter_jobs import job_text, write_jobs

from bench import lint as bench
from olp.__main__ import main
from olp.checks.lint import all_rules
from olp.checks.lint.run import choice, lint, without_known
from olp.reports.batch import Job
from olp.reports.outcome import Level, OutcomeFinding

SAMPLES = Path(__file__).parent.parent / "samples" / "inform"
CODES = [rule.code for rule in all_rules()]


def codes(path: Path, **options) -> list[tuple[str, int]]:
    return [(found.code, found.line) for found in lint(str(path), Job(), **options).findings]


def write(folder: Path, body: str, **options) -> Path:
    path = folder / "PART.JBI"
    path.write_bytes(job_text(body, name="PART", **options).encode("cp1252"))
    return path


@pytest.fixture
def prepared(tmp_path) -> Path:
    (tmp_path / "olp.toml").write_text(bench.SETTINGS)
    return tmp_path


@pytest.mark.parametrize("code", CODES)
def test_a_planted_mistake_is_found_at_its_line(prepared, code):
    assert all(bench.planted(prepared, code, random.Random(seed))[0] for seed in range(4))


def test_clean_programs_have_no_finding(prepared):
    for seed in range(12):
        assert bench.findings(prepared, bench.clean(random.Random(seed))) == []


@pytest.mark.parametrize("sample", bench.SAMPLES, ids=lambda folder: folder.name)
def test_clean_samples_have_no_finding(sample):
    for path in sorted(sample.glob("*.[jJ][bB][iI]")):
        assert codes(path) == []


@pytest.mark.parametrize("rule", all_rules(), ids=lambda rule: rule.code)
def test_a_rule_says_what_why_and_what_is_better(rule):
    assert re.fullmatch(r"W0\d\d", rule.code)
    assert all((rule.title, rule.why, rule.example, rule.better))
    assert rule.why.endswith(".")
    assert type(rule).__doc__
    assert CODES.count(rule.code) == 1


@pytest.mark.parametrize("name", ["empty", "binary", "no-header", "control-bytes"])
def test_a_program_that_cannot_be_read_is_no_clean_one(name, capsys):
    assert main(["lint", str(SAMPLES / "broken" / f"{name}.jbi")]) == 2
    assert "unknown" in capsys.readouterr().out


@pytest.mark.parametrize("path", sorted((SAMPLES / "broken").glob("*.jbi")), ids=lambda path: path.stem)
def test_broken_programs_have_findings_and_no_traceback(path):
    assert any(found.level is Level.ERROR for found in lint(str(path), Job()).findings)


# Exact stops.


@pytest.mark.parametrize(
    ("between", "told"),
    [
        ("", True),
        ("'only a comment", True),
        ("DOUT OT#(1) ON", False),
        ("TIMER T=0.20", False),
        ("WAIT IN#(1)=ON T=1.00", False),
        ("CALL JOB:GRIP", False),
    ],
)
def test_a_stop_is_told_only_where_nothing_needs_it(tmp_path, between, told):
    write_jobs(tmp_path, {"GRIP": CELL["GRIP"]})
    path = write(
        tmp_path, f"MOVL C00000 V=100.0\nMOVL C00002 V=100.0 PL=0\n{between}\nMOVL C00004 V=100.0 PL=0"
    )
    assert ("W001" in dict(codes(path, asked=choice(["W001"], [])))) is told


def test_a_stop_where_the_arm_turns_back_is_meant(tmp_path):
    path = write(tmp_path, "MOVL C00000 V=100.0\nMOVL C00004 V=100.0 PL=0\nMOVL C00001 V=100.0 PL=0")
    assert codes(path, asked=choice(["W001"], [])) == []


# Labels, code that never runs.


@pytest.mark.parametrize("name", ["RETRY", "A", "V", "PL", "1", "0", "OT"])
def test_a_label_that_looks_like_other_words_is_used_only_by_jumps(tmp_path, name):
    moves = "MOVL C00000 V=100.0 PL=1\nDOUT OT#(1) ON"
    assert ("W014" in dict(codes(write(tmp_path, f"*{name}\n{moves}")))) is True
    assert (
        "W014" in dict(codes(write(tmp_path, f"*{name}\n{moves}\nINC B000\nJUMP *{name} IF B000<2")))
    ) is False


def test_labels_between_which_a_budget_counts_are_used(tmp_path):
    path = write(tmp_path, "*A\nMOVL C00000 V=100.0\n*B")
    assert [code for code, _ in codes(path)].count("W014") == 2
    (tmp_path / "olp.toml").write_text("[[budget]]\nlimit_s = 3\nfrom = 'A'\nto = '*b'\n")
    assert "W014" not in [code for code, _ in codes(path)]


def test_code_behind_a_jump_is_reached_through_a_label(tmp_path):
    assert "W010" not in dict(codes(write(tmp_path, "JUMP *A\n*A\nTIMER T=0.10")))
    assert "W010" in dict(codes(write(tmp_path, "JUMP *A\nTIMER T=0.10\n*A")))
    assert "W010" not in dict(codes(write(tmp_path, "JUMP *A IF IN#(1)=ON\nTIMER T=0.10\n*A")))


def test_a_position_variable_that_a_caller_may_set_is_a_note(tmp_path):
    path = write(tmp_path, "MOVL C00000 V=100.0\nMOVL P030 V=100.0")
    (found,) = (f for f in lint(str(path), Job()).findings if f.code == "W009")
    assert found.level is Level.NOTE


def test_one_mistake_is_told_once(tmp_path):
    path = write(tmp_path, "MOVL C00000 V=100.0\nMOVL C00900 V=100.0")
    assert [(code, line) for code, line in codes(path) if code in ("W009", "P030")] == [("W009", 28)]


# Excuses.


@pytest.mark.parametrize(
    ("line", "above", "excused"),
    [
        ("WAIT IN#(5)=ON", "", False),
        ("WAIT IN#(5)=ON  //olp: ignore W012", "", True),
        ("WAIT IN#(5)=ON  //OLP: IGNORE w012", "", True),
        ("WAIT IN#(5)=ON  //olp: ignore", "", True),
        ("WAIT IN#(5)=ON  //olp: ignore W001", "", False),
        ("WAIT IN#(5)=ON  //olp: ignore W001, W012", "", True),
        ("WAIT IN#(5)=ON", "'olp: ignore W012", True),
        ("WAIT IN#(5)=ON", "'olp: ignore W001", False),
        ("WAIT IN#(5)=ON", "DOUT OT#(1) ON  //olp: ignore W012", False),
    ],
)
def test_a_comment_excuses_its_line_or_the_next_one(tmp_path, line, above, excused):
    path = write(tmp_path, f"MOVL C00000 V=100.0\n{above}\n{line}")
    found = lint(str(path), Job(), choice(["W012"], []))
    assert (not found.findings) is excused
    assert found.excused == int(excused)


# Choosing.


def test_rules_are_chosen_by_code_or_beginning_and_unknown_ones_refused(tmp_path, capsys):
    path = write(tmp_path, "*A\nWAIT IN#(5)=ON\nCALL JOB:NOWHERE")
    everything = {code for code, _ in codes(path)}
    assert {"W011", "W012", "W014"} <= everything
    assert {code for code, _ in codes(path, asked=choice(["w011", "W014"], []))} == {"W011", "W014"}
    assert {code for code, _ in codes(path, asked=choice([], ["W01"]))} == everything - {
        "W011",
        "W012",
        "W014",
    }
    for words in (["--select", "W777"], ["--ignore", "X"]):
        assert main(["lint", str(path), *words]) == 2
        assert "W902" in capsys.readouterr().err


def test_olp_toml_chooses_for_what_is_below_it(tmp_path):
    path = write(tmp_path, "*A\nWAIT IN#(5)=ON")
    (tmp_path / "olp.toml").write_text('[lint]\nselect = ["W012", "W014"]\nignore = ["W014"]\n')
    assert {code for code, _ in codes(path)} == {"W012"}
    assert {code for code, _ in codes(path, asked=choice(["W014"], []))} == {"W014"}


@pytest.mark.parametrize(
    "toml", ["[lint]\nselect = 3", "[lint]\nselct = []", "lint = 3", '[lint]\nignore = ["W9"]']
)
def test_settings_that_say_nonsense_are_told(tmp_path, capsys, toml):
    path = write(tmp_path, "TIMER T=0.10")
    (tmp_path / "olp.toml").write_text(toml)
    assert main(["lint", str(path)]) == 2
    assert "W902" in capsys.readouterr().out


@pytest.mark.parametrize(("level", "status"), [("error", 0), ("warning", 0), ("note", 1)])
def test_the_level_that_fails_is_chosen_and_json_says_the_same(tmp_path, capsys, level, status):
    path = write(tmp_path, "WAIT IN#(5)=ON")
    assert main(["lint", str(path), "--select", "W012", "--fail-on", level, "--format", "json"]) == status
    assert json.loads(capsys.readouterr().out)["exit_status"] == status


def test_the_rules_are_listed(capsys):
    assert main(["lint", "--rules"]) == 0
    assert [row[:4] for row in capsys.readouterr().out.splitlines()] == CODES


# Baselines.


def test_a_baseline_excuses_what_is_known_and_counts_equal_lines(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    two = "WAIT IN#(5)=ON\nTIMER T=0.10\nWAIT IN#(5)=ON"
    write(tmp_path, two)
    arguments = ["lint", "PART.JBI", "--fail-on", "note", "--select", "W012"]
    assert main([*arguments, "--write-baseline", "known.json"]) == 0
    assert main([*arguments, "--baseline", "known.json"]) == 0
    write(tmp_path, f"DOUT OT#(1) ON\n\n{two}")  # other lines, the same findings
    assert main([*arguments, "--baseline", "known.json"]) == 0
    write(tmp_path, f"{two}\nWAIT IN#(5)=ON")  # one more of them
    assert main([*arguments, "--baseline", "known.json"]) == 1
    assert "1 finding, 2 known" in capsys.readouterr().out
    write(tmp_path, two.replace("IN#(5)", "IN#(6)", 1))  # another one
    assert main([*arguments, "--baseline", "known.json"]) == 1


def test_a_baseline_counts_down():
    one = OutcomeFinding("W012", Level.NOTE, "", "a", 3, source_line="WAIT")
    assert without_known([one, one, one], {one.fingerprint: 2}) == [one]
    assert without_known([one], {}) == [one]


def test_a_baseline_is_the_same_text_for_the_same_findings(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_jobs(tmp_path, {"B": "WAIT IN#(5)=ON", "A": "*X\nWAIT IN#(5)=ON"})
    for name, order in (("one", ["A.JBI", "B.JBI"]), ("two", ["B.JBI", "A.JBI"])):
        assert main(["lint", *order, "--write-baseline", name]) == 0
    assert Path("one").read_bytes() == Path("two").read_bytes()


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"version": 1}', '{"version": 1, "findings": [3]}', None])
def test_a_baseline_that_is_none_is_told(tmp_path, capsys, text):
    path = write(tmp_path, "TIMER T=0.10")
    if text is not None:
        (tmp_path / "known.json").write_text(text)
    assert main(["lint", str(path), "--baseline", str(tmp_path / "known.json")]) == 2
    assert "W901" in capsys.readouterr().err


# Fixes.


def test_a_fix_removes_its_line_and_no_other_byte(tmp_path, capsys):
    body = "MOVL C00000 V=100.0\n*LOST\nMOVL C00003 V=100.0 PL=0\n*KEPT\nINC B000\nJUMP *KEPT IF B000<3"
    path = write(tmp_path, body)
    before = path.read_bytes()
    from olp.reports.batch import plan_and_time

    seconds = plan_and_time(str(path), Job()).total_s
    assert main(["lint", str(path), "--fix", "--select", "W014"]) == 0
    assert path.read_bytes() == before.replace(b"*LOST\r\n", b"")
    assert plan_and_time(str(path), Job()).total_s == seconds
    assert "0 findings" in capsys.readouterr().out


def test_a_fix_leaves_excused_findings_alone(tmp_path):
    path = write(tmp_path, "'olp: ignore W014\n*LOST\nTIMER T=0.10")
    before = path.read_bytes()
    assert main(["lint", str(path), "--fix"]) == 0
    assert path.read_bytes() == before


def test_many_programs_on_several_processes_say_the_same(tmp_path, capsys):
    write_jobs(tmp_path, {f"J{n:03d}": f"WAIT IN#({n + 1})=ON\n*L{n}" for n in range(60)})
    told = []
    for workers in ("1", "2"):
        assert (
            main(["lint", str(tmp_path), "--ignore", "W008", "--workers", workers, "--format", "json"]) == 0
        )
        told.append(capsys.readouterr().out)
    assert told[0] == told[1]
    assert len(json.loads(told[0])["findings"]) == 120


def test_a_called_job_is_judged_by_itself(tmp_path):
    path = cell(tmp_path, jobs={"MAIN": "CALL JOB:GRIP", "GRIP": "WAIT IN#(5)=ON"})
    points = choice([], ["W008"])
    assert codes(path, asked=points) == []
    assert [code for code, _ in codes(tmp_path / "GRIP.JBI", asked=points)] == ["W012"]
