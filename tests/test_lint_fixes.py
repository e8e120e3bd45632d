"""`olp lint --fix`: what is safe leaves every step as it was, what is not mends its finding; neither is believed."""

from __future__ import annotations

import random
from functools import partial
from pathlib import Path

import pytest
from interpreter_jobs import job_text

from bench import lint as bench
from olp.__main__ import main
from olp.checks.lint import all_rules
from olp.checks.lint.fix import Edit, fixed, fixes, same_run
from olp.checks.lint.run import lint
from olp.fluent import read
from olp.reports.batch import Job, time_program

RULES = {rule.code: rule for rule in all_rules()}
_KUKA = "LIN {{X 900,Y {},Z 700,A 10,B 80,C 20}}{}\n"
_TARGET = "[[900,{},700],[0.1,0.7,0.7,0.1],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
_UR = "  movel(p[0.300,{},0.300,0.1,3.1,0.2], a=1.2, v={}{})\n"
# An exact stop on the way, a zone that is too long, and a point that nobody moves to.
PROGRAMS = {
    "A.SRC": "DEF A()\nDECL E6POS XLOST\n"
    + "".join(_KUKA.format(y, end) for y, end in ((100, ""), (250, " ; C_DIS"), (400, " C_DIS"), (550, "")))
    + "END\n",
    "A.MOD": "MODULE A\nPROC main()\nVAR robtarget lost:=" + _TARGET.format(100) + ";\n"
    + "".join(
        f"MoveL {_TARGET.format(y)},v200,{zone},tool0; ! fine z5\n"
        for y, zone in ((100, "fine"), (250, "fine"), (400, "z100"), (412, "fine"))
    )
    + "ENDPROC\nENDMODULE\n",
    "A.script": "def a():\n"
    + "".join(
        _UR.format(y, v, r)
        for y, v, r in ((-0.3, 0.25, ""), (-0.2, 0.25, ""), (-0.1, 0.25, ", r=0.08"), (-0.09, 1.5, ""))
    )
    + "end\na()\n",
    "A.LS": "/PROG A\n/ATTR\n/MN\n"
    + "".join(
        f"{n:4d}:L P[{n}] 200mm/sec {end}    ;\n" for n, end in ((1, "FINE"), (2, "FINE"), (3, "CNT100"), (4, "FINE"))
    )
    + "/POS\n"
    + "".join(
        f"P[{n}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = 900.0 mm,\tY = {y} mm,\t"
        "Z = 300.0 mm,\n\tW = 175.0 deg,\tP = 1.0 deg,\tR = 5.0 deg\n};\n"
        for n, y in ((1, -300.0), (2, -150.0), (3, -20.0), (4, -8.0))
    )
    + "/END\n",
}  # fmt: skip
WANTED = {"A.SRC": {"W001", "W008"}, "A.MOD": {"W001", "W003", "W008"}, "A.script": {"W001", "W002", "W003"},
          "A.LS": {"W001"}}  # fmt: skip
JOB = Job(robot="yaskawa/gp25")
SETTINGS = "[tools]\n1 = [10.0, 5.0, 200.0, 3.0, -4.0, 7.0]\n"


def run(program):
    return time_program(program, JOB)


def planted(folder: Path, code: str, seed: int = 2) -> Path:
    (folder / "olp.toml").write_text(bench.SETTINGS)
    text = bench.clean(random.Random(1))
    bench.PLANTS[code](text, random.Random(seed))
    path = folder / "PART.JBI"
    path.write_text("\r\n".join([*text.lines(), ""]), newline="")
    return path


@pytest.mark.parametrize("code", sorted(RULES))
def test_a_rule_offers_what_it_says_it_offers_and_what_is_done_mends_it(tmp_path, code):
    path = planted(tmp_path, code)
    found = [f for f in lint(str(path), Job()).findings if f.code == code]
    program = read(path)
    edits = fixes(program, found)
    rule = RULES[code]
    assert all(edit.safe for edit in edits) or rule.suggests
    assert {edit.code for edit in edits} <= {code}
    assert all(edit.says and 0 < edit.first <= edit.last for edit in edits)
    if not rule.fixable:
        assert not any(edit.safe for edit in edits)
    if rule.suggests or code == "W014":
        done = fixed(program, edits, partial(time_program, job=Job()))
        assert {(e.code, e.line) for e in done.done} == {(f.code, f.line) for f in found}
        path.write_bytes(done.program.to_bytes())
        assert code not in {f.code for f in lint(str(path), Job()).findings}


@pytest.mark.parametrize("code", ["W001", "W002", "W003", "W010", "W015"])
def test_what_alters_the_motion_is_changed_only_when_asked(tmp_path, code, capsys):
    path = planted(tmp_path, code)
    before = path.read_bytes()
    main(["lint", str(path), "--fix", "--select", code])
    assert path.read_bytes() == before
    main(["lint", str(path), "--fix", "--unsafe-fixes", "--select", code])
    assert path.read_bytes() != before
    assert "1 mended, 1 of them unsafe" in capsys.readouterr().out


def test_unsafe_fixes_alone_are_refused(tmp_path, capsys):
    assert main(["lint", str(planted(tmp_path, "W001")), "--unsafe-fixes"]) == 2
    assert "C002" in capsys.readouterr().err


@pytest.mark.parametrize("name", sorted(PROGRAMS))
def test_every_language_is_mended_in_its_own_words(tmp_path, name):
    (tmp_path / "olp.toml").write_text(SETTINGS)
    path = tmp_path / name
    path.write_bytes(PROGRAMS[name].encode())
    program = read(path)
    found = [f for f in lint(str(path), JOB).findings if f.code in WANTED[name]]
    assert {f.code for f in found} == WANTED[name]
    done = fixed(program, fixes(program, found), run)
    assert {e.code for e in done.done} == WANTED[name], [(e.code, e.text) for e in done.refused]
    old, new = program.source.lines, done.program.source.lines
    assert len(set(old) ^ set(new)) == 2 * len(done.done) - sum(not e.text for e in done.done)
    path.write_bytes(done.program.to_bytes())
    assert not {f.code for f in lint(str(path), JOB).findings} & WANTED[name]


@pytest.mark.parametrize("name", ["A.SRC", "A.MOD"])
def test_a_declaration_that_nobody_needs_goes_and_the_run_stays(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(PROGRAMS[name].encode())
    before = read(path)
    assert main(["lint", str(path), "--fix", "--select", "W008", "--robot", "yaskawa/gp25"]) == 0
    (gone,) = set(before.source.lines) - set(read(path).source.lines)
    assert "lost" in gone.lower()
    assert same_run(run(before), run(read(path)))


def test_a_change_that_calls_itself_safe_and_is_not_is_left_alone(tmp_path):
    body = "*LOST\nMOVL C00000 V=100.0\nMOVL C00003 V=100.0 PL=0\nTIMER T=0.50"
    path = tmp_path / "PART.JBI"
    path.write_bytes(job_text(body, name="PART").encode())
    program = read(path)
    (label,) = fixes(program, [f for f in lint(str(path), Job()).findings if f.code == "W014"])
    line = label.first
    lies = [
        Edit("W014", line, line, line + 1, (), "takes a move with it", True),
        Edit(
            "W014", line, line, line + 3, ("MOVL C00000 V=100.0", "MOVL C00003 V=101.0 PL=0"), "faster", True
        ),
        Edit("W014", line, line, line, ("NONSENSE",), "no statement", True),
        Edit("W014", line, line, line, ("*OTHER",), "mends nothing", True),
    ]
    done = fixed(program, [*lies, label], partial(time_program, job=Job()))
    assert done.done == (label,)
    assert set(done.refused) == set(lies)


def test_changes_of_several_lines_are_made_where_the_lines_are_by_then(tmp_path):
    rows = [row for n in range(5) for row in (f"*L{n}", f"MOVL C0000{n} V=100.0 PL=0", "DOUT OT#(1) ON")]
    path = tmp_path / "PART.JBI"
    path.write_bytes(job_text("\n".join(rows), name="PART").encode())
    program = read(path)
    edits = fixes(program, [f for f in lint(str(path), Job()).findings if f.code == "W014"])
    assert len(edits) == 5
    wrong = Edit("W014", edits[1].line, edits[1].first + 1, edits[1].first + 1, (), "a move", True)
    done = fixed(program, [edits[0], wrong, *edits[1:]], partial(time_program, job=Job()))
    assert done.done == tuple(edits)
    text = path.read_bytes()
    for n in range(5):
        text = text.replace(f"*L{n}\r\n".encode(), b"")
    assert done.program.to_bytes() == text
