"""`olp fit`: the fewest edits that bring a program down to a time."""

from __future__ import annotations

import json
import random
import re
from dataclasses import replace
from itertools import pairwise, permutations
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import Bounds, LinearConstraint, milp

from bench import fit as bench
from olp.__main__ import main
from olp.checks.fit.choices import Allowed, Choice, choices
from olp.checks.fit.fit import cover, fit
from olp.checks.fit.order import OrderSearch, covering, held_karp, improved
from olp.checks.fit.report import front_file
from olp.core.units import mm
from olp.languages.vendor import read
from olp.reports.batch import Job, time_program
from olp.timing.track import track

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


@pytest.mark.slow("krl", "tp")
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


def test_no_set_of_edits_written_into_the_text_is_smaller(tmp_path):
    """The oracle of the bench: every set of other numbers in the lines, timed one by one."""
    choose = random.Random("1 0")
    path = tmp_path / "made.jbi"
    text, places = bench.spellings(bench.job_text(choose, 4), choose, 100)
    path.write_bytes(text.encode())
    program = read(path)
    base = bench.timed(program, ROBOT, tmp_path)
    ways = bench.all_ways(path, text, places, ROBOT)
    best = min(way.total_s for way in ways)
    for share in (0.4, 0.99):
        to_s = base.total_s - share * (base.total_s - best)
        found = fit(program, to_s, lambda p: bench.timed(p, ROBOT, tmp_path), Allowed(2 * mm, bench.FASTEST))
        assert found.reached
        assert len(found.edits) <= min(way.edits for way in ways if way.total_s <= to_s + 1e-9)
        assert not bench.wrong_with(found, path, tmp_path / "out.jbi", ROBOT, 2.0)


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
    for lines in ("a-b", "900"):
        assert main([*words, "--to", "3", "--keep", lines]) == 2
        assert "error[C002]" in capsys.readouterr().err


def test_a_speed_that_no_edit_changes_is_told_as_such(tmp_path, capsys):
    """A faster --max-speed would not help. Lines that take no time stop nothing."""
    program = tmp_path / "a.src"
    program.write_text(
        "DEF a()\nBAS(#INITMOV,0)\nslow(0.01*5)\nPTP {X 900,Y 0,Z 700,A 0,B 90,C 0,S 2,T 2}\n"
        "LIN {X 900,Y 300,Z 700,A 0,B 90,C 0}\nEND\nDEF slow(v:IN)\nREAL v\n$VEL.CP=v\nEND\n"
    )
    words = ["fit", str(program), "--to", "1", "--max-speed", "900", "--robot", "kuka/kr16-2"]
    assert main([*words, "-o", str(tmp_path / "b.src")]) == 1
    told = capsys.readouterr().out
    assert "speed that is computed or an argument, which is not edited: LIN {" in told
    assert "0.000 s, " not in told


def test_the_front_weighs_seconds_against_edits_and_against_millimetres(tmp_path):
    """No point is behind another one in all three, and a corner passed by half as much costs time."""
    program = tmp_path / "corner.script"
    program.write_text(
        "def corner():\n  movel(p[0.6, -0.2, 0.3, 0, 3.14, 0], a=1.2, v=0.1)\n"
        "  movel(p[0.6, 0.1, 0.3, 0, 3.14, 0], a=1.2, v=0.2, r=0.001)\n"
        "  movel(p[0.4, 0.1, 0.3, 0, 3.14, 0], a=1.2, v=0.2, r=0.001)\n"
        "  movel(p[0.4, -0.1, 0.3, 0, 3.14, 0], a=1.2, v=0.2)\nend\n"
    )
    run = lambda one: time_program(one, Job(robot="universal-robots/ur10e"))  # noqa: E731
    found = fit(read(program), 0.1, run, Allowed(5 * mm, 0.4))
    front = [(one.edits, one.within_mm, one.total_s) for one in found.front]
    assert not any(
        one != other and all(a <= b for a, b in zip(other, one, strict=True))
        for one in front
        for other in front
    )
    best = {far: min(s for _, mm_, s in front if mm_ <= far) for _, far, _ in front}
    assert len(best) >= 4
    assert list(dict(sorted(best.items())).values()) == sorted(best.values(), reverse=True)
    # A speed and a zone of one line: each has its part of what they gain together.
    both = [one.gained_s for one in found.edits if one.choice.line == 4]
    assert len(both) == 2
    assert min(both) > 0.01
    assert sum(one.gained_s for one in found.edits) == pytest.approx(found.before_s - found.timing.total_s)
    shown = front_file(found, "front.svg").decode()
    assert ">mm<" in shown
    assert ">edits<" in shown


def test_the_table_names_the_line_that_changes(tmp_path, capsys):
    program, out = tmp_path / "a.src", tmp_path / "b.src"
    program.write_text(
        "DEF a()\nBAS(#INITMOV,0)\n$VEL.CP=0.1\nPTP {X 900,Y 0,Z 700,A 0,B 90,C 0,S 2,T 2}\n"
        "LIN {X 900,Y 300,Z 700,A 0,B 90,C 0}\n$VEL.CP=0.4\nLIN {X 900,Y 0,Z 700,A 0,B 90,C 0}\nEND\n"
    )
    assert main(["fit", str(program), "--to", "2.2", "-o", str(out), "--robot", "kuka/kr16-2"]) == 0
    assert "\n     3  100 → 400 mm/s" in capsys.readouterr().out
    assert out.read_text().splitlines()[2] == "$VEL.CP=0.4"


def test_a_speed_that_a_setting_gives_counts_as_one_of_the_program_and_lengths_may_have_their_unit(tmp_path):
    job = ROOT / "samples/inform/generations/dx200.jbi"  # its lines say V=140, SPEED says V=270
    out = tmp_path / job.name
    asked = ["fit", str(job), "--to", "3.5", "--within", "2mm", "-o", str(out), "--robot", "yaskawa/ma2010"]
    assert main(asked) == 0
    assert b"V=140.0" in job.read_bytes().splitlines()[30]
    assert b"V=140.0" not in out.read_bytes().splitlines()[30]


SLOW = {
    "acc.mod": (
        "abb/irb4600-20-2.50",
        """MODULE A
  CONST robtarget p1:=[[1200,0,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget p2:=[[1200,400,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    AccSet 40, 50;
    MoveJ p1, v500, fine, tool0;
    MoveL p2, v500, fine, tool0;
    MoveL p1, v500, fine, tool0;
  ENDPROC
ENDMODULE
""",
        "AccSet 100, 50;",
    ),
    "acc.src": (
        "kuka/kr16-2",
        """DEF acc( )
$ACC.CP=0.5
$VEL.CP=0.3
PTP {A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0}
LIN {X 900,Y 0,Z 900,A 0,B 90,C 0}
LIN {X 900,Y 300,Z 900,A 0,B 90,C 0}
$VEL.CP=1.2
LIN {X 900,Y 0,Z 900,A 0,B 90,C 0}
$ACC.CP=2.3
LIN {X 900,Y 300,Z 900,A 0,B 90,C 0}
END
""",
        "$ACC.CP=2.3",
    ),
    "acc.script": (
        "universal-robots/ur10e",
        """def acc():
  movej([0,-1.57,1.57,-1.57,-1.57,0], a=1.4, v=0.5)
  movel(p[0.5,0.1,0.4,0,3.14,0], a=1.5, v=0.25)
  movel(p[0.5,0.3,0.4,0,3.14,0], 0.1, 0.25)
end
""",
        "0,3.14,0], 1.5, 0.25)",
    ),
}


@pytest.mark.slow("acc.script")
@pytest.mark.parametrize("name", SLOW)
def test_accelerations_are_raised_where_they_are_written_and_no_higher_than_anywhere(name, tmp_path, capsys):
    robot, text, written = SLOW[name]
    path = tmp_path / name
    path.write_text(text)
    out = tmp_path / f"out{path.suffix}"
    before = time_program(read(path), Job(robot=robot)).total_s
    best = fit(read(path), 0.01, lambda p: time_program(p, Job(robot=robot)), Allowed(acceleration=None))
    kinds = {one.choice.kind for one in best.edits}
    assert "acceleration" in kinds
    to_s = best.timing.total_s + 1e-6
    assert main(["fit", str(path), "--to", str(to_s), "-o", str(out), "--robot", robot]) == 0
    assert written in out.read_text()
    assert time_program(read(out), Job(robot=robot)).total_s <= to_s < before
    changed = [a for a, b in zip(text.splitlines(), out.read_text().splitlines(), strict=True) if a != b]
    assert len(changed) == len(best.edits)
    higher = fit(read(path), 0.01, lambda p: time_program(p, Job(robot=robot)), Allowed(acceleration=5.0))
    assert (higher.timing.total_s < best.timing.total_s) == (name != "acc.mod")  # AccSet: 100 % is the most


def test_a_joint_speed_in_radians_goes_to_the_highest_that_is_written(tmp_path):
    path = tmp_path / "axes.script"
    moves = [
        f"  movej([{turn},-1.57,1.57,-1.57,-1.57,0], a=1.4, v={v})"
        for turn, v in ((0, 0.5), (0.8, 0.5), (0, 1.0))
    ]
    path.write_text("\n".join(["def axes():", *moves, "end", ""]))
    robot = "universal-robots/ur10e"
    found = fit(read(path), 0.1, lambda p: time_program(p, Job(robot=robot)), Allowed())
    assert [(one.choice.line, one.choice.lines) for one in found.edits] == [(3, {3})]
    assert "a=1.4, v=1)" in found.program.source.line(3)
    assert found.timing.total_s < found.before_s - 0.3


def test_acc_and_dec_of_a_line_are_an_edit_each(tmp_path):
    path = tmp_path / "ACC.JBI"
    path.write_text(TOUCH_UP.read_text().replace(" PL=0", " PL=0 ACC=40 DEC=50", 1))
    program = read(path)
    base = bench.timed(program, ROBOT, tmp_path)
    found = [one for one in choices(program, base, Allowed()) if one.kind == "acceleration"]
    assert len({one.place for one in found}) == 2
    assert {text for one in found for _, text in one.texts} >= {"48", "60", "100"}
    best = fit(program, 0.1, lambda p: bench.timed(p, ROBOT, tmp_path), Allowed())
    assert "ACC=100 DEC=100" in best.program.source.raw.decode()


def test_a_setting_counts_once_for_all_moves_that_it_holds_for(tmp_path):
    """$VEL.CP before two LINs and another one before the third: one edit brings both down."""
    robot, text, _ = SLOW["acc.src"]
    path = tmp_path / "acc.src"
    path.write_text(text.replace("$ACC.CP=0.5\n", ""))
    program = read(path)
    base = time_program(program, Job(robot=robot))
    found = fit(program, base.total_s - 0.6, lambda p: time_program(p, Job(robot=robot)), Allowed())
    assert [one.choice.line for one in found.edits] == [2]
    assert found.edits[0].gained_s == pytest.approx(base.total_s - found.timing.total_s, abs=1e-9)
    assert found.reached


def job(name: str, body: str) -> str:
    rows = ["900.000,0.000,500.000", "900.000,200.000,500.000", "940.000,400.000,500.000"]
    points = "".join(f"C{n:05d}={row},180.0000,0.0000,0.0000\n" for n, row in enumerate(rows))
    head = f"/JOB\n//NAME {name}\n//POS\n///NPOS 3,0,0,0,0,0\n///TOOL 0\n///POSTYPE BASE\n///RECTAN\n"
    tail = "//INST\n///DATE 2026/01/01 08:00\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\n"
    return f"{head}///RCONF 1,0,0,0,0,0,0,0\n{points}{tail}{body}END\n"


def test_called_programs_are_edited_in_their_own_files_and_a_line_that_runs_twice_gains_twice(
    tmp_path, capsys
):
    moves = "MOVL C00001 V=100.0 PL=0\nMOVL C00002 V=100.0 PL=0\n"
    texts = {
        "MAIN.JBI": job(
            "MAIN", "MOVJ C00000 VJ=50.00\nCALL JOB:SUB\nMOVL C00000 V=300.0 PL=0\nCALL JOB:SUB\n"
        ),
        "SUB.JBI": job("SUB", moves),
        "OTHER.JBI": job("OTHER", "CALL JOB:SUB\n"),
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    main_job, out = tmp_path / "MAIN.JBI", tmp_path / "out"
    before = seconds(main_job, tmp_path)
    words = ["fit", str(main_job), "--to", str(before - 2.5), "--robot", ROBOT]
    assert main([*words, "-o", str(tmp_path / "OUT.JBI")]) == 1  # its own lines are not enough
    assert "-o FOLDER/" in capsys.readouterr().out
    assert main([*words, "-o", f"{out}/", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    (edit,) = told["edits"]
    assert (Path(edit["file"]).name, edit["gained_s"] > 2.5) == ("SUB.JBI", True)
    assert list(told["shared"].values()) == [["OTHER.JBI"]]
    assert sorted(one.name for one in out.iterdir()) == ["MAIN.JBI", "SUB.JBI"]
    assert told["total_s"] == pytest.approx(seconds(out / "MAIN.JBI", out), abs=1e-9)
    old, new = texts["SUB.JBI"].splitlines(), (out / "SUB.JBI").read_text().splitlines()
    assert [n for n, (a, b) in enumerate(zip(old, new, strict=True), 1) if a != b] == edit["changes"]
    assert {name: (tmp_path / name).read_text() for name in texts} == texts
    (tmp_path / "SUB.JBI").write_text(job("SUB", moves.replace("PL=0\n", "PL=0 //olp: keep\n")))
    assert main([*words, "-o", f"{out}/"]) == 1


def test_a_free_line_becomes_a_joint_move_and_says_how_far_it_leaves_the_straight_way(tmp_path, capsys):
    path, out = tmp_path / "MAIN.JBI", tmp_path / "OUT.JBI"
    path.write_text(job("MAIN", "MOVJ C00000 VJ=50.00\nMOVL C00002 V=300.0 PL=0\n"))
    line = path.read_text().splitlines().index("MOVL C00002 V=300.0 PL=0") + 1
    before = seconds(path, tmp_path)
    words = ["fit", str(path), "--to", str(before - 0.5), "-o", str(out), "--robot", ROBOT, "--json"]
    assert main(words) == 1
    capsys.readouterr()
    assert main([*words, "--free", str(line)]) == 0
    (edit,) = json.loads(capsys.readouterr().out)["edits"]
    assert re.fullmatch(r"MOVJ C00002 VJ=\d+\.00 PL=0", out.read_text().splitlines()[line - 1])
    timing = time_program(read(out), Job(robot=ROBOT), tmp_path)
    way = track(timing, 1e-3).position
    start, stop = way[0], way[-1]
    along = (stop - start) / np.linalg.norm(stop - start)
    off = np.linalg.norm((way - start) - ((way - start) @ along)[:, None] * along, axis=1).max()
    assert edit["deviation_mm"] == pytest.approx(off / mm, rel=1e-3)
    assert edit["deviation_mm"] > 1.0


def picks(count: int, choose: random.Random) -> tuple[str, list[tuple[int, int]]]:
    """A job that goes to points one after the other, down and up again at each; and the lines of each group."""
    rows, body = ["900.000,0.000,600.000"], ["MOVJ C00000 VJ=50.00"]
    for n in range(count):
        x, y = choose.uniform(750, 1100), (-1) ** n * choose.uniform(100, 400)
        rows += [f"{x:.3f},{y:.3f},500.000", f"{x:.3f},{y:.3f},450.000"]
        body += [
            f"MOVJ C{2 * n + 1:05d} VJ=25.00",
            f"MOVL C{2 * n + 2:05d} V=200.0 PL=0",
            f"DOUT OT#({n + 1}) ON",
        ]
        body += [f"MOVL C{2 * n + 1:05d} V=200.0"]
    points = [f"C{n:05d}={row},180.0000,0.0000,0.0000" for n, row in enumerate(rows)]
    head = [
        "/JOB",
        "//NAME PICKS",
        "//POS",
        f"///NPOS {len(rows)},0,0,0,0,0",
        "///TOOL 0",
        "///POSTYPE BASE",
        "///RECTAN",
    ]
    head += [
        "///RCONF 1,0,0,0,0,0,0,0",
        *points,
        "//INST",
        "///DATE 2026/01/01 08:00",
        "///ATTR SC,RW",
        "///GROUP1 RB1",
        "NOP",
    ]
    first = len(head) + 2
    groups = [(first + 4 * n, first + 4 * n + 3) for n in range(count)]
    return "\r\n".join([*head, *body, "MOVJ C00000 VJ=50.00", "END", ""]), groups


def shuffled(text: str, groups: list[tuple[int, int]], order: tuple[int, ...]) -> str:
    rows = text.split("\r\n")
    moved = [row for n in order for row in rows[groups[n][0] - 1 : groups[n][1]]]
    return "\r\n".join([*rows[: groups[0][0] - 1], *moved, *rows[groups[-1][1] :]])


@pytest.mark.slow
def test_groups_whose_order_is_free_come_in_the_fastest_one(tmp_path, capsys):
    text, groups = picks(4, random.Random(5))
    path, out = tmp_path / "PICKS.JBI", tmp_path / "OUT.JBI"
    path.write_bytes(text.encode())

    def total(order: tuple[int, ...]) -> float:
        out.write_bytes(shuffled(text, groups, order).encode())
        return seconds(out, tmp_path)

    best = min(permutations(range(4)), key=total)
    least, before = total(best), seconds(path, tmp_path)
    assert least < before - 0.05
    words = [
        "fit",
        str(path),
        "--to",
        str(least + 1e-6),
        "-o",
        str(out),
        "--robot",
        ROBOT,
        "--json",
        "--keep",
        "1-99",
    ]
    said = ",".join(f"{first}-{last}" for first, last in groups)
    assert main(words) == 1
    capsys.readouterr()
    assert main([*words[:-2], "--order", said]) == 0
    told = json.loads(capsys.readouterr().out)
    assert seconds(out, tmp_path) == pytest.approx(least, abs=1e-9)
    assert told["total_s"] == pytest.approx(least, abs=1e-9)
    assert sum(one["kind"] == "order" for one in told["edits"]) == 1
    lines = out.read_bytes().splitlines(keepends=True)
    assert sorted(lines) == sorted(text.encode().splitlines(keepends=True))
    old = text.encode().splitlines(keepends=True)
    assert {n for n, (a, b) in enumerate(zip(old, lines, strict=True), 1) if a != b} == {
        line for one in told["edits"] for line in one["changes"]
    }


def test_groups_that_depend_on_each_other_or_are_none_are_refused(tmp_path, capsys):
    text, groups = picks(3, random.Random(6))
    path = tmp_path / "PICKS.JBI"
    words = ["fit", str(path), "--to", "0.5", "-o", str(tmp_path / "o.jbi"), "--robot", ROBOT, "--order"]
    said = [f"{first}-{last}" for first, last in groups]
    for code, order in (
        ("U032", said[0]),
        ("U032", f"{said[0]},{said[2]}"),
        ("U032", f"{said[0]},{groups[1][0]}-999"),
    ):
        path.write_bytes(text.encode())
        assert main([*words, order]) == 2
        assert f"error[{code}]" in capsys.readouterr().err
    path.write_bytes(text.replace("OT#(2) ON", "OT#(2) ON //olp: keep").encode())
    assert main([*words, ",".join(said)]) == 2
    assert "error[U032]" in capsys.readouterr().err
    # The speed that the second group sets holds in the third one as well.
    settings = (
        text.replace("MOVJ C00003 VJ=25.00", "SPEED V=150.0")
        .replace(" V=200.0 PL=0", " PL=0")
        .replace(" V=200.0", "")
    )
    path.write_bytes(settings.replace("NOP", "NOP\r\nSPEED V=300.0").encode())
    moved = ",".join(f"{first + 1}-{last + 1}" for first, last in groups)
    assert main([*words, moved]) == 2
    assert "error[U033]" in capsys.readouterr().err


def test_the_order_of_measured_ways_is_the_best_one_and_that_of_many_groups_nearly():
    chance = np.random.default_rng(3)

    def cost(way, order):
        return way[[len(order), *order], [*order, len(order)]].sum()

    for _ in range(20):
        way = chance.uniform(0.5, 2.0, (7, 7))
        best = min(cost(way, order) for order in permutations(range(6)))
        assert cost(way, held_karp(way)) == pytest.approx(best)
    more = []
    for _ in range(10):
        place = chance.uniform(0.0, 1.0, (10, 2))
        way = np.linalg.norm(place[:, None] - place, axis=2)
        more.append(cost(way, improved(way)) / cost(way, held_karp(way)))
    assert max(more) < 1.05
    for count in range(2, 14):
        pairs = {pair for order in covering(count) for pair in pairwise((count, *order, count))}
        assert pairs >= {(a, b) for a in range(count + 1) for b in range(count + 1) if a != b}
        assert all(sorted(order) == list(range(count)) for order in covering(count))


@pytest.mark.slow
def test_six_groups_come_in_an_order_as_good_as_the_best_of_all(tmp_path):
    """Held and Karp on measured ways: against 60 random orders, timed."""
    choose = random.Random(8)
    text, groups = picks(6, choose)
    path, out = tmp_path / "PICKS.JBI", tmp_path / "OUT.JBI"
    path.write_bytes(text.encode())
    program, free = read(path), tuple(range(first, last + 1) for first, last in groups)
    found = fit(
        program,
        0.5,
        lambda p: bench.timed(p, ROBOT, tmp_path),
        Allowed(kept=frozenset(range(99)) - {*range(groups[0][0], groups[-1][1] + 1)}, order=free),
    )
    assert found.edits[0].choice.kind == "order"
    base = found.before_s - found.edits[0].gained_s
    for _ in range(60):
        order = list(range(6))
        choose.shuffle(order)
        out.write_bytes(shuffled(text, groups, tuple(order)).encode())
        assert base <= seconds(out, tmp_path) + 1e-3


def test_line_numbers_of_the_controller_stay_where_they_are(tmp_path):
    """TP: the text behind the number moves."""
    path = SAMPLES["tp"]
    program = read(path)
    rows = [(n, text) for n, text in enumerate(program.source.lines, 1) if re.match(r"\s*\d+:[LJ] ", text)]
    (first, one), (second, other) = next(
        (a, b) for a, b in pairwise(rows) if b[0] == a[0] + 1 and a[1].split("]")[0] != b[1].split("]")[0]
    )
    search = OrderSearch(
        program,
        bench.timed(program, ROBOT, path.parent),
        lambda p: None,
        (range(first, second), range(second, second + 1)),
    )
    new = search.ordered((1, 0)).source
    number = re.compile(r"\s*\d+:")
    for line, old in ((first, other), (second, one)):
        assert number.match(new.line(line))[0] == number.match(program.source.line(line))[0]
        assert number.sub("", new.line(line)) == number.sub("", old)


def test_no_edit_takes_more_moves_out_of_what_the_signature_has_seen_unless_asked(tmp_path):
    """A signature that has seen 300 mm/s."""
    path = tmp_path / "MAIN.JBI"
    path.write_text(job("MAIN", "MOVJ C00000 VJ=50.00\nMOVL C00001 V=300.0 PL=0\nMOVL C00002 V=200.0 PL=0\n"))
    program = read(path)

    def run(p):
        timing = bench.timed(p, ROBOT, tmp_path)
        return replace(timing, unseen=int((timing.plan.moves.travel > 0.3).sum()))

    within = fit(program, 0.5, run, Allowed(speed=0.6), front=False)
    asked = fit(program, 0.5, run, Allowed(speed=0.6, unseen=True), front=False)
    assert [one.choice.says for one in within.edits] == ["200 → 300 mm/s"]
    assert len(asked.edits) == 2
    assert asked.timing.unseen == 2


def test_joint_speeds_and_free_lines_make_the_tool_no_faster_than_it_may_be(tmp_path):
    path = tmp_path / "MAIN.JBI"
    path.write_text(job("MAIN", "MOVJ C00000 VJ=50.00\nMOVJ C00001 VJ=2.00 PL=0\nMOVL C00002 V=100.0 PL=0\n"))
    free = frozenset({path.read_text().splitlines().index("MOVL C00002 V=100.0 PL=0") + 1})
    reached = []
    for most in (0.3, 0.6, None):
        found = fit(
            read(path), 0.01, lambda p: bench.timed(p, ROBOT, tmp_path), Allowed(speed=most, free=free)
        )
        position = track(found.timing, 1e-3).position
        reached.append(float((np.linalg.norm(np.diff(position, axis=0), axis=1) / 1e-3).max()))
        assert found.edits
    assert reached[0] <= 0.3 * 1.01
    assert reached[1] <= 0.6 * 1.01
    assert reached[2] > 0.6


def test_an_override_is_named_where_it_stops_the_answer(tmp_path):
    path = tmp_path / "slow.ls"
    text = SAMPLES["tp"].read_text()
    numbered = next(line for line in text.splitlines() if line.lstrip().startswith("1:"))
    path.write_text(text.replace(numbered, f"   1:  OVERRIDE=30% ;\n{numbered}", 1))
    found = fit(
        read(path), 0.1, lambda one: time_program(one, Job(robot="fanuc/m-20ia"), tmp_path), Allowed()
    )
    assert not found.reached
    assert any("an override of 30%, which is not edited: 1:  OVERRIDE=30% ;" in one for one in found.limits)


CALLS = {
    "urscript": (
        "a.script",
        "def prog():\n  def go(p, v):\n    movel(p, a=1.2, v=v)\n  end\n"
        "  movel(p[0.3,-0.3,0.4,0,3.14,0], a=1.2, v=0.5)\n"
        "  go(p[0.5,-0.2,0.4,0,3.14,0], 0.25) # olp: keep\n  go(p[0.1,-0.2,0.4,0,3.14,0], 0.1)\nend\n",
        "go(p[0.1,-0.2,0.4,0,3.14,0], 0.1)",
        "go(p[0.1,-0.2,0.4,0,3.14,0], 0.12)",
    ),
    "krl": (
        "a.src",
        "DEF a()\nBAS(#INITMOV,0)\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 45,A6 0}\ngo(0.1, 0.1) ; 0.1\nEND\n"
        "DEF go(z:IN, v:IN)\nREAL z,v\n$VEL.CP=v\nLIN_REL {Z 100}\nLIN_REL {Z -100}\nEND\n",
        "go(0.1, 0.1) ; 0.1",
        "go(0.1, 0.12) ; 0.1",
    ),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_speed_that_a_call_gives_is_an_edit_of_the_call(name, tmp_path):
    file, text, old, new = CALLS[name]
    path = tmp_path / file
    path.write_text(text)

    def timed(program):
        return time_program(program, Job(robot=bench.ROBOTS[name]), tmp_path)

    program = read(path)
    before = timed(program)
    found = fit(program, 0.9 * before.total_s, timed, Allowed(speed=0.5))
    assert found.reached
    assert found.program.source.raw.decode() == text.replace(old, new)
    path.write_text(text.replace(old, new))
    assert timed(read(path)).total_s == pytest.approx(found.timing.total_s, abs=1e-9)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("$VEL.CP=v\n", "$VEL.CP=v\nWAIT SEC v\n"),  # it is a time as well
        ("go(0.1, 0.1) ; 0.1", "go(0.1, 0.1*1)"),
        ("go(0.1, 0.1) ; 0.1", "go(0.1, 0.1) ; olp: keep"),
    ],
)
def test_what_a_call_gives_for_something_else_or_computes_is_no_edit(old, new, tmp_path):
    file, text, _, _ = CALLS["krl"]
    path = tmp_path / file
    path.write_text(text.replace(old, new))
    program = read(path)
    timing = time_program(program, Job(robot=bench.ROBOTS["krl"]), tmp_path)
    assert not [one for one in choices(program, timing, Allowed(speed=0.5)) if one.kind == "speed"]
