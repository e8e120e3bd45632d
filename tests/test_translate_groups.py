"""Tracks, stations and second arms of a job: external axes of the positions elsewhere, or told.

The oracle is the meaning of the manuals: KUKA's E1 to E6, ABB's eax_a to eax_f and FANUC's E1 to E3 are mm of an axis
that slides and degrees of one that turns; the arm's own axes stay what the pulses say.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest
from translated_texts import ROBOT, converted, inform, krl, module, read, tp

import olp
from olp.runtime.interpreter import run
from olp.runtime.plan import Plan
from olp.transpile import Context
from olp.transpile.compare import compare_plans
from olp.transpile.context import Fate
from olp.transpile.convert import convert, run_converted, runs_of
from olp.transpile.link import link
from olp.transpile.receipt import receipt_of

ARMS = [
    "14000,-21000,3100,1200,-52000,700",
    "8200,-18500,4300,2600,-47500,-900",
    "5300,-20500,1900,3700,-50000,450",
]
TRACK = [104848, 118357, 91173]  # pulses
TABLE = [(-31500, 8000), (12250, -4400), (23940, 10600)]
AXES = """
maker = "Own"
model = "{model}"
kind = "{kind}"
axes = [{axes}]
[sources]
limits = "drawing"
speed = "drawing"
pulses = "drawing"
"""
SLIDE = '{ name = "X", lower_mm = -150, upper_mm = 5200, speed_mm_s = 1250, pulses_per_mm = 85.5 }'
TURN = '{{ name = "{}", lower_deg = -185, upper_deg = 185, speed_deg_s = 80, pulses_per_deg = {} }}'
TILTS = f"{TURN.format(1, 1994.5)}, {TURN.format(2, 1376.25)}"
FILES = {
    "olp.toml": '[robots]\nBS1 = "track.toml"\nST1 = "table.toml"\n',
    "track.toml": AXES.format(model="Rail", kind="track", axes=SLIDE),
    "table.toml": AXES.format(model="Table", kind="positioner", axes=TILTS),
}
TARGETS = pytest.mark.parametrize("target", ["krl", "rapid", "tp"])


def job(
    *rows: str, tracks: list[int] = TRACK, tables: list[tuple[int, int]] = TABLE, second: bool = False
) -> str:
    arms = [*ARMS, *(("100,-200,300,400,-500,600",) if second else ())]
    points = ["///TOOL 0", "///POSTYPE PULSE", "///PULSE", *(f"C{n:05d}={row}" for n, row in enumerate(arms))]
    points += [f"BC{n:05d}={row}" for n, row in enumerate(tracks)]
    points += [f"EC{n:05d}={a},{b}" for n, (a, b) in enumerate(tables)]
    text = inform(*rows, points=points)
    text = text.replace(f"NPOS {len(arms)},0,0", f"NPOS {len(arms)},{len(tracks)},{len(tables)}")
    groups = "///GROUP1 RB1,BS1\r\n///GROUP2 ST1" + ("\r\n///GROUP3 RB2" if second else "")
    return text.replace("///GROUP1 RB1", groups)


def written(folder: Path, text: str, files: dict[str, str] = FILES) -> Path:
    for name, content in files.items():
        (folder / name).write_text(content)
    path = folder / "PART.JBI"
    path.write_bytes(text.encode())
    return path


def external(text: str, target: str) -> list[list[float]]:
    """The external axes of each position that is written, in the order of the program."""
    if target == "rapid":
        found = re.findall(r"\[([^\[\]]*9E9[^\[\]]*)\]\]", text)
        return [[float(x) for x in row.split(",") if x != "9E9"] for row in found]
    if target == "krl":
        rows = re.findall(r"DECL E6(?:POS|AXIS) .*", text)
        return [[float(x) for x in re.findall(r"\bE\d ([-\d.]+)", row)] for row in rows]
    return [
        [float(x) for x in re.findall(r"E\d= +([-\d.]+)", row)]
        for row in text.split("P[")[1:]
        if "GP1" in row
    ]


@TARGETS
def test_a_track_and_a_station_become_external_axes_in_their_units(tmp_path: Path, target: str) -> None:
    rows = [f"MOVJ C0000{n} BC0000{n} VJ=25.00 PL=0 +MOVJ EC0000{n} VJ=25.00" for n in range(3)]
    program = link(olp.read(written(tmp_path, job(*rows)))).program
    made = convert(program, target, Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00")
    text = b"\n".join(made.files.values()).decode("cp1252")
    found = external(text, target)
    wanted = [
        [mm / 85.5, tilt / 1994.5, turn / 1376.25] for mm, (tilt, turn) in zip(TRACK, TABLE, strict=True)
    ]
    assert len(found) == 3
    for row, values in zip(found, wanted, strict=True):
        assert row == pytest.approx(values, abs=0.001)
    if target == "tp":
        assert re.search(r"E1= +[\d.]+ +mm,\tE2= +[-\d.]+ +deg,\tE3= +[-\d.]+ +deg", text)
    assert not [loss for loss in made.translated.losses if loss.part in ("external", "groups")]
    assert any("external axes" in asked for asked in made.translated.asks)
    source, other = run(program, ROBOT), run_converted(made, target, ROBOT, program)
    assert compare_plans(source, other).differences == []
    assert [row[:1] for row in source.beside.values()] == [pytest.approx((mm / 85.5,)) for mm in TRACK]
    first, at = next(iter(other.beside.items()))
    far = replace(other, beside={**other.beside, first: (at[0] + 0.05, *at[1:])})
    assert [one.part for one in compare_plans(source, far).found] == ["external"]
    none = replace(other, beside={})
    assert {one.part for one in compare_plans(source, none).found} == {"external"}
    lines = {one.line for one in compare_plans(source, none).found}
    assert len(lines) > 1
    told = [min(lines)]  # of one move alone that its axes are left out
    left = compare_plans(source, none, loose={"beside": set(told)}).found
    assert {one.line for one in left} == lines - set(told)


@TARGETS
def test_a_line_on_a_moving_track_leads_where_the_arm_itself_goes_and_says_so(
    tmp_path: Path, target: str
) -> None:
    rows = ["MOVJ C00000 BC00000 VJ=25.00 PL=0 +MOVJ EC00000 VJ=25.00"]
    rows += [f"SMOVL C0000{n} BC0000{n} V=100.0 PL=0 +MOVJ EC0000{n}" for n in (1, 2)]
    program = link(olp.read(written(tmp_path, job(*rows, tables=[(5, 6)] * 3)))).program
    made = convert(program, target, Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00")
    losses = [(loss.line, loss.fate) for loss in made.translated.losses if loss.part == "external"]
    start = next(s.line for s in program.statements() if type(s).__name__ == "Move")
    assert losses == [(start + 1, Fate.APPROXIMATED), (start + 2, Fate.APPROXIMATED)]
    found = external(b"\n".join(made.files.values()).decode("cp1252"), target)
    assert [row[0] for row in found] == pytest.approx([mm / 85.5 for mm in TRACK], abs=0.001)
    assert {len(row) for row in found} == {1}  # the station stands still
    assert compare_plans(run(program, ROBOT), run_converted(made, target, ROBOT, program)).differences == []


@TARGETS
def test_without_a_file_the_pulses_are_assumed_and_each_move_says_so(target: str) -> None:
    rows = [f"MOVJ C0000{n} BC0000{n} VJ=25.00 PL=0 +MOVJ EC0000{n} VJ=25.00" for n in range(3)]
    made = converted(job(*rows), "inform", target)
    told = [loss.says for loss in made.translated.losses if loss.part == "external"]
    assert set(told) == {"1,000 pulses per mm or degree are assumed for an external axis"}
    assert any(
        "[robots]" in asked and {"BS1", "ST1"} == set(of) for asked, of in made.translated.asks.items()
    )
    text = b"\n".join(made.files.values()).decode("cp1252")
    assert external(text, target)[1] == pytest.approx([118.357, 12.25, -4.4], abs=0.001)


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (["SMOVL C00001 BC00001 V=100.0 PL=0 +MOVJ EC00001"], "a path over the work on a station that turns"),
        (
            ["GETS PX001 $PX000", "MOVL P001 BP001 V=9.0 PL=0"],
            "the program does not say where the track goes",
        ),
        (["MOVJ EC00001 VJ=5.00"], "a move of a track or a station alone"),
    ],
)
def test_what_external_axes_cannot_say_is_left_out_and_told(rows: list[str], says: str) -> None:
    first = "MOVJ C00000 BC00000 VJ=25.00 PL=0 +MOVJ EC00000 VJ=25.00"
    made = converted(job(first, *rows), "inform", "krl")
    last = max(loss.line for loss in made.translated.losses)
    found = [loss for loss in made.translated.losses if loss.line == last and loss.leaves_out]
    assert len(found) == 1
    assert says in found[0].says


def test_an_arm_without_external_axes_moves_alone_and_tells_where_they_go(tmp_path: Path) -> None:
    rows = [f"MOVJ C0000{n} BC0000{n} VJ=25.00 PL=0 +MOVJ EC0000{n} VJ=25.00" for n in range(3)]
    source = olp.read(written(tmp_path, job(*rows)))
    made = convert(link(source).program, "urscript", Context(ROBOT, on_loss="comment"))
    told = [loss.line for loss in made.translated.losses if loss.part == "beside"]
    text = made.files[made.main].decode()
    found = [float(v) for v in re.findall(r"external axis \d: (\S+) (?:mm|deg)", text)]
    rows_of = [
        (pulses / 85.5, one / 1994.5, two / 1376.25) for pulses, (one, two) in zip(TRACK, TABLE, strict=True)
    ]
    assert found == pytest.approx([value for row in rows_of for value in row])
    runs = runs_of(source, made, "urscript", (ROBOT, ROBOT))
    receipt = receipt_of(link(source), made.translated, "urscript", tuple(made.files), runs, (ROBOT, ROBOT))
    assert [one.line for one in receipt.verdict.objections if one.kind == "left-out"] == told
    assert len(told) == 3
    assert not [one for one in receipt.verdict.objections if one.kind == "difference"]


def test_a_station_that_stands_still_is_left_out_though_its_points_name_not_all_axes() -> None:
    text = job("MOVL C00000 EC00000 V=9.0", "MOVL C00001 EC00001 V=9.0", tracks=[], tables=[(0, 0)] * 2)
    text = re.sub(r"(EC0000\d=)0,0", r"\g<1>-3,,,,,", text).replace("RB1,BS1", "RB1")
    made = converted(text, "inform", "urscript")
    assert not [loss.says for loss in made.translated.losses if loss.leaves_out]
    assert any("the station has the same position in all points" in note for note in made.translated.notes)


@TARGETS
def test_the_second_arm_is_told_and_the_first_one_moves(target: str) -> None:
    rows = [f"MOVJ C0000{n} VJ=25.00 PL=0 +MOVJ C00003 VJ=25.00" for n in range(3)]
    text = job(*rows, tracks=[], tables=[], second=True).replace(
        "RB1,BS1\r\n///GROUP2 ST1\r\n///GROUP3", "RB1\r\n///GROUP2"
    )
    made = converted(text, "inform", target)
    told = {loss.line: (loss.fate, loss.part) for loss in made.translated.losses if loss.part == "process"}
    assert list(told.values()) == [(Fate.APPROXIMATED, "process")] * 3
    program = read(text, "inform")
    assert compare_plans(run(program, ROBOT), run_converted(made, target, ROBOT, program)).differences == []


def test_two_stations_are_not_taken_for_one() -> None:
    rows = [
        f"MOVJ C0000{n} VJ=25.00 PL=0 +MOVJ EC0000{n} VJ=9.00 +MOVJ EC0000{2 - n} VJ=9.00" for n in (0, 2)
    ]
    text = job(*rows, tracks=[]).replace("RB1,BS1", "RB1").replace("ST1", "ST1\r\n///GROUP3 ST2")
    losses = converted(text, "inform", "krl").translated.losses
    assert [loss.says for loss in losses if loss.leaves_out] == [
        "the program does not say where the station goes"
    ] * 2


def test_a_move_of_the_arm_alone_says_nothing_of_the_others() -> None:
    rows = ["MOVJ C00000 BC00000 VJ=25.00 PL=0 +MOVJ EC00000 VJ=25.00", "MOVJ C00001 VJ=25.00 PL=0"]
    losses = converted(job(*rows), "inform", "rapid").translated.losses
    assert [loss.says for loss in losses if loss.part == "external" and "nothing" in loss.says] == [
        "the move says nothing of external axes that others move"
    ]


@pytest.mark.parametrize("second", ["12.500", "-31.250"])
def test_what_a_point_of_several_groups_moves_besides_is_told(second: str) -> None:
    text = tp(
        "J P[1] 20% FINE",
        "J P[2] 20% FINE",
        positions=[(1, 0, 1, 900, 0, 500, 180, 0, 0), (2, 0, 1, 900, 90, 500, 180, 0, 0)],
    )
    table = "\t R =    0.000 deg\n   GP2:\n\tUF : 0, UT : 1,\n\tJ1= {} deg\n}};"
    for value in ("12.500", second):
        text = text.replace("\tR = 0.000 deg\n};", table.format(value), 1)
    assert text.count("GP2") == 2
    losses = converted(text, "tp", "krl").translated.losses
    told = [(loss.part, loss.says) for loss in losses if loss.part == "process"]
    moved = second != "12.500"
    assert (
        told == [("process", "the other control groups of the point move, too, and are left out")] * 2 * moved
    )


def test_an_external_axis_that_comes_back_to_zero_is_written_as_zero() -> None:
    place = "X 900,Y 0,Z 500,A 0,B 0,C 180"
    text = krl("$VEL.CP=0.1", f"LIN {{{place},E1 20.5,E2 0}}", f"LIN {{{place},E1 0,E2 0}}")
    made = converted(text, "krl", "rapid")
    assert external(b"\n".join(made.files.values()).decode(), "rapid") == [[20.5], [0.0]]
    program = read(text, "krl")
    other = run_converted(made, "rapid", ROBOT, program)
    assert compare_plans(run(program, ROBOT), other).differences == []
    assert [row[0] for row in other.beside.values()] == [20.5, 0.0]
    assert len(run(program, ROBOT).beside) == 2


def test_a_job_with_a_station_that_never_moves_has_a_plan_without_external_axes() -> None:
    assert run(read(job("TIMER T=0.50"), "inform"), ROBOT).beside == {}


@TARGETS
def test_moves_of_a_station_alone_beside_others_keep_their_axes_apart(target: str) -> None:
    rows = [
        "MOVJ C00000 BC00000 VJ=25.00 PL=0 +MOVJ EC00000 VJ=25.00",
        "MOVJ C00001 VJ=25.00 PL=0 +MOVJ EC00001 VJ=5.00",
    ]
    rows += ["MOVJ C00002 BC00002 VJ=25.00 PL=0 +MOVJ EC00002 VJ=25.00"]
    program = read(job(*rows), "inform")
    made = converted(job(*rows), "inform", target)
    source = run(program, ROBOT)
    assert [math.isnan(row[0]) for row in source.beside.values()] == [False, True, False]
    assert compare_plans(source, run_converted(made, target, ROBOT, program)).differences == []


def _on_a_track(*places: str) -> Plan:
    """Lines to two corners and back, each with the track's place in mm, 9E9 where the position says nothing of it."""
    turn, rest = "[0,1,0,0],[0,0,0,0]", "9E9,9E9,9E9,9E9,9E9"
    rows = [
        f"MoveL [[900,{100 * (at % 2)},400],{turn},[{place},{rest}]],v100,fine,tool0;"
        for at, place in enumerate(places)
    ]
    return read(module(*rows), "rapid").plan(robot=ROBOT)


def test_an_external_axis_that_only_the_translation_moves_is_a_difference() -> None:
    """The comparison looked at axes of the source alone; where it says nothing of one, that axis stands still."""
    still = _on_a_track("9E9", "9E9", "9E9")
    assert compare_plans(still, _on_a_track("40", "40", "40")).found == []  # set up, and never moved
    assert [one.part for one in compare_plans(still, _on_a_track("0", "40", "40")).found] == ["external"]
    once = _on_a_track("0", "40", "9E9")
    assert compare_plans(once, _on_a_track("0", "40", "40")).found == []
    assert [one.part for one in compare_plans(once, _on_a_track("0", "40", "70")).found] == ["external"]
