"""`olp fit`: the fewest edits that bring a program down to a time."""

from __future__ import annotations

import json
import random
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import Bounds, LinearConstraint, milp

from bench import fit as bench
from olp.__main__ import main
from olp.checks.fit.choices import Allowed, Choice, choices
from olp.checks.fit.fit import cover, fit
from olp.core.units import mm
from olp.languages.read import read
from olp.reports.batch import Job, time_program

ROOT = Path(__file__).parent.parent
TOUCH_UP = ROOT / "samples/inform/touch-up/before/TOUCH-UP.JBI"
ROBOT = "yaskawa/gp25"
SAMPLES = {
    "inform": TOUCH_UP,
    "krl": ROOT / "samples/krl/handling.src",
    "rapid": ROOT / "samples/rapid/handling.mod",
    "tp": ROOT / "samples/tp/handling.ls",
    "urscript": ROOT / "samples/urscript/handling.script",
}


def seconds(path: Path, folder: Path) -> float:
    return time_program(read(path), Job(robot=ROBOT), folder).total_s


@pytest.mark.parametrize("path", SAMPLES.values(), ids=SAMPLES)
def test_only_the_lines_of_the_edits_change_and_the_time_is_that_of_olp_time(path, tmp_path, capsys):
    before = seconds(path, path.parent)
    out = tmp_path / path.name
    words = ["fit", str(path), "--to", f"{0.9 * before:.6f}", "--max-speed", "600", "--within", "2"]
    assert main([*words, "-o", str(out), "--json", "--robot", ROBOT]) == 0
    told = json.loads(capsys.readouterr().out)
    text, old = out.read_bytes().splitlines(), path.read_bytes().splitlines()
    changed = [n for n, (a, b) in enumerate(zip(old, text, strict=True), 1) if a != b]
    assert 0 < len(told["edits"]) <= len(changed)
    shown = {one["line"] for one in told["edits"]}
    assert all(
        min(abs(n - line) for line in shown) <= 4 for n in changed
    )  # a form of KRL says a speed three times
    assert told["total_s"] == pytest.approx(_timed_there(out, path), abs=1e-9)
    assert told["total_s"] <= 0.9 * before + 1e-6
    assert told["low_s"] < told["total_s"] < told["high_s"]
    assert told["needed_s"] == pytest.approx(told["to_s"] * told["total_s"] / told["high_s"])


def _timed_there(out: Path, path: Path) -> float:
    from olp.core.source import decode
    from olp.languages.vendor import find_vendor

    vendor = find_vendor(read(path).vendor)
    return time_program(vendor.read(decode(out.read_bytes(), str(path))), Job(robot=ROBOT)).total_s


def test_no_smaller_set_of_edits_is_enough(tmp_path):
    path = tmp_path / "made.jbi"
    path.write_text(bench.job_text(random.Random("1 0"), 4))
    program = read(path)
    base = bench.timed(program, ROBOT, tmp_path)
    allowed = Allowed(2 * mm, 0.9)
    for share in (0.1, 0.3):
        found = fit(program, base.total_s * (1 - share), lambda p: bench.timed(p, ROBOT, tmp_path), allowed)
        assert found.reached
        assert len(found.edits) == bench.fewest(program, base, ROBOT, found.to_s, tmp_path, allowed)
        assert not bench.replayed(found, tmp_path / "out.jbi", ROBOT, 2.0)


def test_the_fewest_choices_are_those_of_a_solver_of_integer_programs():
    """SciPy's milp (HiGHS), over random gains."""
    for seed in range(40):
        choose = random.Random(seed)
        some = [Choice("speed", n, ("speed", n), "", level + 1.0) for n in range(12) for level in range(3)]
        gains = {one: choose.uniform(0.0, 1.0) * (1.0 + one.effort) for one in some}
        need = choose.uniform(0.5, 20.0)
        place = np.array([[float(one.line == n) for one in some] for n in range(12)])
        limits = [
            LinearConstraint(place, -np.inf, 1.0),
            LinearConstraint(np.array([[gains[one] for one in some]]), need, np.inf),
        ]
        solved = milp(
            np.ones(len(some)), constraints=limits, integrality=np.ones(len(some)), bounds=Bounds(0, 1)
        )
        found = cover(some, gains, need)
        assert (found is None) == (solved.x is None)
        if found is not None:
            assert len(found) == round(solved.fun)
            assert sum(gains[one] for one in found) >= need - 1e-12
            assert len({one.place for one in found}) == len(found)


def test_kept_lines_taught_points_and_limits_hold(tmp_path):
    text = TOUCH_UP.read_text().replace("MOVL C00002 V=118.0 PL=2", "MOVL C00002 V=118.0 PL=2  //olp: keep")
    path = tmp_path / "kept.jbi"
    path.write_text(text)
    program = read(path)
    base = bench.timed(program, ROBOT, tmp_path)
    line = text.splitlines().index("MOVL C00002 V=118.0 PL=2  //olp: keep") + 1
    found = choices(program, base, Allowed(2 * mm, 0.5, frozenset({line + 1})))
    assert not {one.line for one in found} & {line, line + 1}
    speeds = [new for one in found for _, new in one.texts if "mm/s" in one.says]
    assert speeds
    assert max(map(float, speeds)) <= 500.0
    best = fit(program, 0.1, lambda p: bench.timed(p, ROBOT, tmp_path), Allowed(2 * mm, 0.5))
    assert not best.reached
    rows = [one for one in best.program.source.lines if one.startswith("C0")]
    assert rows == [one for one in program.source.lines if one.startswith("C0")]
    assert all(one.deviation_mm <= 2.0 for one in best.edits)


def test_corners_are_not_passed_further_than_allowed(tmp_path):
    """Two lines at a right angle with a stop that nothing needs: a zone gains, and how much of one is measured."""
    rows = ["900.000,0.000,500.000", "900.000,200.000,500.000", "940.000,400.000,500.000"]
    points = "\n".join(f"C{n:05d}={row},180.0000,0.0000,0.0000" for n, row in enumerate(rows))
    head = "/JOB\n//NAME A\n//POS\n///NPOS 3,0,0,0,0,0\n///TOOL 0\n///POSTYPE BASE\n///RECTAN\n"
    head += "///RCONF 1,0,0,0,0,0,0,0\n"
    body = "//INST\n///DATE 2026/01/01 08:00\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\nMOVJ C00000 VJ=50.00\n"
    moves = "MOVL C00001 V=300.0 PL=0\nMOVL C00002 V=300.0 PL=0\nEND\n"
    path = tmp_path / "a.jbi"
    path.write_text(f"{head}{points}\n{body}{moves}")
    program = read(path)

    def run(p):
        return bench.timed(p, ROBOT, tmp_path)

    base = run(program)
    none = fit(program, base.total_s - 0.05, run, Allowed(0.0, 0.3))
    assert {one.choice.kind for one in none.edits} <= {"speed"}
    some = fit(program, 0.1, run, Allowed(5 * mm, 0.3))
    zones = [one for one in some.edits if one.choice.kind == "zone"]
    assert len(zones) == 1
    assert 0.0 < zones[0].deviation_mm <= 5.0
    assert zones[0].gained_s > 0.01


def test_what_cannot_be_reached_is_told_with_what_stops_it_and_nothing_is_written(tmp_path, capsys):
    out = tmp_path / "out.jbi"
    words = ["fit", str(TOUCH_UP), "-o", str(out), "--robot", ROBOT]
    assert main([*words, "--to", "0.5", "--front", str(tmp_path / "front.svg")]) == 1
    told = capsys.readouterr().out
    assert "0.5 s cannot be reached" in told
    assert "what stops it:" in told
    assert not out.exists()
    assert (tmp_path / "front.svg").read_bytes().startswith(b"<svg")
    assert main([*words, "--to", "3", "--front", str(tmp_path / "front.txt")]) == 2
    assert "error[E003]" in capsys.readouterr().err
    assert main(["fit", str(ROOT / "samples/as/handling.as"), "--to", "3", "-o", str(out)]) == 2
    assert "error[" in capsys.readouterr().err
    assert main([*words, "--to", "3", "--keep", "a-b"]) == 2
    assert "error[C002]" in capsys.readouterr().err


def test_a_speed_that_a_setting_gives_counts_as_one_of_the_program_and_lengths_may_have_their_unit(tmp_path):
    job = ROOT / "samples/inform/generations/dx200.jbi"  # its lines say V=140, SPEED says V=270
    out = tmp_path / job.name
    asked = ["fit", str(job), "--to", "3.5", "--within", "2mm", "-o", str(out), "--robot", "yaskawa/ma2010"]
    assert main(asked) == 0
    assert b"V=140.0" in job.read_bytes().splitlines()[30]
    assert b"V=140.0" not in out.read_bytes().splitlines()[30]
