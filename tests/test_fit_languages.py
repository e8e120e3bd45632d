"""`olp fit` in the languages that it edits: values that speeds are made of, free lines and free orders.

The oracle writes into the text itself and times that.
"""

from __future__ import annotations

import json
import random
import re
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from olp.__main__ import main
from olp.core.units import mm
from olp.languages.literals import speeds
from olp.languages.vendor import read
from olp.reports.batch import Job, time_program
from olp.timing.track import track

ROBOT = "yaskawa/gp25"
Place = tuple[float, float, float]


def seconds(path: Path) -> float:
    return time_program(read(path), Job(robot=ROBOT), path.parent).total_s


def spelt(language: str, points: dict[str, Place], body: list[str]) -> str:
    """A program with these points [mm], the tool pointing down, and these lines."""
    rows = points.items()
    match language:
        case "krl":
            said = [
                f"DECL E6POS {n}={{X {x:.3f},Y {y:.3f},Z {z:.3f},A 0,B 0,C 180}}" for n, (x, y, z) in rows
            ]
            lines = ["DEF job()", *said, "$APO.CDIS=5", "BAS(#VEL_PTP,100)", *body, "END", ""]
        case "rapid":
            far = "[9E9,9E9,9E9,9E9,9E9,9E9]"
            said = [
                f"CONST robtarget {n}:=[[{x:.3f},{y:.3f},{z:.3f}],[0,1,0,0],[0,0,0,0],{far}];"
                for n, (x, y, z) in rows
            ]
            lines = ["MODULE job", *said, "PROC main()", *body, "ENDPROC", "ENDMODULE", ""]
        case "urscript":
            said = [f"{n}=p[{x / 1e3:.6f},{y / 1e3:.6f},{z / 1e3:.6f},3.14159,0,0]" for n, (x, y, z) in rows]
            lines = ["def job():", *said, *body, "end", ""]
        case _:
            number = {n: at for at, n in enumerate(points, 1)}
            text = [re.sub(r"P\[(\w+)\]", lambda m: f"P[{number[m[1]]}]", one) for one in body]
            # The groups of an order leave the listing's numbers where they are.
            lines = ["/PROG  JOB", "/MN", *(f"{at:4d}:{one} ;" for at, one in enumerate(text, 1)), "/POS"]
            for n, (x, y, z) in rows:
                lines += [f"P[{number[n]}]{{", "   GP1:", "\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',"]
                lines += [f"\tX = {x:9.3f}  mm,\tY = {y:9.3f}  mm,\tZ = {z:9.3f}  mm,"]
                lines += ["\tW =   180.000 deg,\tP =     0.000 deg,\tR =     0.000 deg", "};"]
            lines += ["/END", ""]
    return "\n".join(lines)


def _body(path: Path) -> list[int]:
    """The lines of the moves, from 1."""
    move = re.compile(r"(?: +\d+:)?(?:PTP|LIN|Move[JL]|[JL] P|move[jl])\b")
    return [n for n, row in enumerate(path.read_text().split("\n"), 1) if move.match(row)]


SUFFIX = {"krl": "src", "rapid": "mod", "tp": "ls", "urscript": "script"}
# A joint move, a straight one and an output.
WORDS = {
    "krl": ("PTP {}", "LIN {}", "$OUT[{}]=TRUE"),
    "rapid": ("MoveJ {},v200,fine,tool0;", "MoveL {},v200,fine,tool0;", "SetDO do{},1;"),
    "tp": ("J P[{}] 100% FINE", "L P[{}] 200mm/sec FINE", "DO[{}]=ON"),
    "urscript": ("movej({},a=1.4,v=1.05)", "movel({},a=1.2,v=0.2)", "set_digital_out({},True)"),
}


@pytest.mark.parametrize("language", SUFFIX)
def test_the_order_found_is_the_fastest_of_all_texts(language, tmp_path, capsys):
    choose = random.Random(language)
    joint, straight, output = WORDS[language]
    points = {"home": (900.0, 0.0, 600.0)}
    groups = []
    for n in range(3):
        x, y = choose.uniform(750, 1100), (-1) ** n * choose.uniform(150, 400)
        points |= {f"up{n}": (x, y, 500.0), f"down{n}": (x, y, 450.0)}
        groups.append([
            joint.format(f"up{n}"), straight.format(f"down{n}"), output.format(n + 1), straight.format(f"up{n}")
        ])  # fmt: skip

    def text(order: tuple[int, ...]) -> str:
        moves = [line for n in order for line in groups[n]]
        return spelt(language, points, [joint.format("home"), *moves, joint.format("home")])

    path, out = (tmp_path / f"{name}.{SUFFIX[language]}" for name in ("job", "out"))
    totals = {}
    for order in permutations(range(3)):
        out.write_text(text(order))
        totals[order] = seconds(out)
    slowest, fastest = max(totals, key=totals.__getitem__), min(totals, key=totals.__getitem__)
    groups = [groups[n] for n in slowest]
    path.write_text(text((0, 1, 2)))
    least = totals[fastest]
    assert least < seconds(path) - 0.05
    body = _body(path)
    first = body[1]
    said = ",".join(f"{first + 4 * n}-{first + 4 * n + 3}" for n in range(3))
    words = ["fit", str(path), "--to", f"{least + 1e-6}", "-o", str(out), "--robot", ROBOT, "--json"]
    assert main([*words, "--max-speed", "200", "--order", said]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["edits"][0]["kind"], len(told["edits"])) == ("order", 1)
    assert told["total_s"] == pytest.approx(least, abs=1e-9)
    assert seconds(out) == pytest.approx(least, abs=1e-9)


@pytest.mark.parametrize("language", SUFFIX)
def test_a_free_line_is_a_joint_move_of_the_text(language, tmp_path, capsys):
    joint, straight, _ = WORDS[language]
    points = {"home": (900.0, 0.0, 500.0), "far": (940.0, 400.0, 500.0)}
    path, out = (tmp_path / f"{name}.{SUFFIX[language]}" for name in ("job", "out"))
    path.write_text(spelt(language, points, [joint.format("home"), straight.format("far")]))
    number = _body(path)[1]
    words = ["fit", str(path), "--to", str(seconds(path) - 0.02), "-o", str(out), "--robot", ROBOT, "--json"]
    words += ["--keep", f"1-{number - 1},{number + 1}-99"]
    assert main([*words, "--free", str(number)]) == 0
    (edit,) = json.loads(capsys.readouterr().out)["edits"]
    old, new = path.read_text().split("\n"), out.read_text().split("\n")
    assert edit["kind"] == "joint"
    assert [row for row in new if row not in old] == [new[number - 1]]
    assert re.search(r"PTP far|MoveJ far,|J P\[2\] \d+%|movej\(far,", new[number - 1])
    way = track(time_program(read(out), Job(robot=ROBOT), tmp_path), 1e-3).position
    start, stop = np.array(points["home"]) * mm, np.array(points["far"]) * mm
    way = way[np.flatnonzero(np.linalg.norm(way - start, axis=1) < 1e-6)[-1] :]
    along = (stop - start) / np.linalg.norm(stop - start)
    off = np.linalg.norm((way - start) - ((way - start) @ along)[:, None] * along, axis=1).max()
    assert edit["deviation_mm"] == pytest.approx(off / mm, rel=1e-2)


# --- Speeds that stand elsewhere ---

SLOW = {
    "krl": ("DEF job()\nDECL REAL slow\nslow = 0.1\n$VEL.CP=slow\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0}\n"
            "LIN_REL {X 0,Y 200,Z 0}\nLIN_REL {X 0,Y -300,Z 0}\nEND\n", "slow = 0.1", "slow = 0.3"),
    "rapid": ("MODULE job\nCONST speeddata slow:=[100,500,5000,1000];\n"
              "CONST robtarget a:=[[900,0,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
              "CONST robtarget b:=[[900,300,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
              "PROC main()\nMoveJ a,v300,fine,tool0;\nMoveL b,slow,fine,tool0;\nMoveL a,slow,fine,tool0;\n"
              "ENDPROC\nENDMODULE\n", "slow:=[100,", "slow:=[300,"),
    "tp": (spelt("tp", {"a": (900.0, 0.0, 500.0), "b": (900.0, 300.0, 500.0)},
                 ["R[1]=100", "J P[a] 50% FINE", "L P[b] R[1]mm/sec FINE", "L P[a] R[1]mm/sec FINE"]),
           "R[1]=100", "R[1]=300"),
    "urscript": ("def job():\n  slow = 0.1\n  movej([0,-1.57,1.57,-1.57,-1.57,0],a=1.4,v=1.05)\n"
                 "  movel(p[0.9,0,0.5,3.14159,0,0],a=1.2,v=slow)\n  movel(p[0.9,0.3,0.5,3.14159,0,0],a=1.2,v=slow)\n"
                 "end\n", "slow = 0.1", "slow = 0.3"),
    "inform": ("/JOB\n//NAME JOB\n//POS\n///NPOS 2,0,0,0,0,0\n///TOOL 0\n///POSTYPE BASE\n///RECTAN\n"
               "///RCONF 1,0,0,0,0,0,0,0\nC00000=900.000,0.000,500.000,180.0000,0.0000,0.0000\n"
               "C00001=900.000,300.000,500.000,180.0000,0.0000,0.0000\n//INST\n///DATE 2026/06/05 16:20\n"
               "///ATTR SC,RW\n///GROUP1 RB1\nNOP\nSET I000 1000\nMOVJ C00000 VJ=50.00\nMOVL C00001 V=I000\n"
               "MOVL C00000 V=I000\nEND\n", "I000 1000", "I000 3000"),
}  # fmt: skip


@pytest.mark.parametrize("language", SLOW)
def test_the_value_that_speeds_are_made_of_is_one_edit_for_all_of_them(language, tmp_path, capsys):
    text, old, new = SLOW[language]
    suffix = SUFFIX.get(language, "jbi")
    path, out = tmp_path / f"job.{suffix}", tmp_path / f"out.{suffix}"
    out.write_text(text.replace(old, new))
    least = seconds(out)
    path.write_text(text)
    words = ["fit", str(path), "--to", f"{least + 1e-6}", "-o", str(out), "--robot", ROBOT, "--json"]
    assert main([*words, "--max-speed", "300"]) == 0
    told = json.loads(capsys.readouterr().out)
    (edit,) = told["edits"]
    assert out.read_text() == text.replace(old, new)
    assert told["total_s"] == pytest.approx(least, abs=1e-9)
    assert edit["gained_s"] == pytest.approx(told["before_s"] - least, abs=1e-9)
    assert main([*words, "--max-speed", "300", "--keep", str(edit["line"])]) == 1


def test_a_value_of_which_more_than_speeds_is_made_stays(tmp_path, capsys):
    text, old, _ = SLOW["inform"]
    path, words = tmp_path / "job.jbi", ["--to", "2", "-o", "-", "--robot", ROBOT, "--max-speed", "300"]
    for line in ("ADD I001 I000", "JUMP *A IF I000>3"):
        path.write_text(text.replace("END\n", f"{line}\n*A\nEND\n").replace(old, f"{old}"))
        assert main(["fit", str(path), *words]) == 1
        assert "I000" not in capsys.readouterr().out


def test_a_list_beside_the_program_is_edited_where_it_may_be_written(tmp_path, capsys):
    body = SLOW["krl"][0].replace("DECL REAL slow\nslow = 0.1\n", "")
    path, beside, out = tmp_path / "job.src", tmp_path / "job.dat", tmp_path / "out"
    path.write_text(body)
    data = "DEFDAT job\nDECL REAL slow=0.3 ; of lines\nDECL REAL other=0.3\nENDDAT\n"
    beside.write_text(data)
    least = seconds(path)
    beside.write_text(data.replace("slow=0.3", "slow=0.1"))
    words = ["fit", str(path), "--to", f"{least + 1e-6}", "--robot", ROBOT, "--max-speed", "300", "--json"]
    assert main([*words, "-o", str(tmp_path / "alone.src")]) == 1
    capsys.readouterr()
    assert main([*words, "-o", f"{out}/"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [Path(one["file"]).name for one in told["edits"]] == ["job.dat"]
    assert (out / "job.dat").read_text() == data
    assert seconds(out / "job.src") == pytest.approx(told["total_s"], abs=1e-9)
    assert "0.1" in beside.read_text()


def test_a_target_that_is_called_like_an_instruction_is_none(tmp_path):
    """`MoveL Move1` of a public program: its speed stood for nobody."""
    text = (
        SLOW["rapid"][0]
        .replace("MoveL b,slow", "MoveL MoveL1, v100")
        .replace("robtarget b", "robtarget MoveL1")
    )
    path = tmp_path / "job.mod"
    path.write_text(
        text.replace("MoveL a,slow,fine,tool0;", "MoveL a,v50,fine,tool0; ! MoveL b,v200,fine,tool0;")
    )
    assert [one.speed.native for one in speeds(read(path))] == ["v300", "v100", "v50"]
