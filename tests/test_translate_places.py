"""Places in translations, each computed here by hand: moves from where the arm stands, arcs, frames, arms' own data."""

import re

import numpy as np
import pytest
from translated_texts import (
    ROBOT,
    converted,
    inform,
    krl,
    module,
    read,
    run_elsewhere,
    tp,
    translated,
)

from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.runtime.interpreter import run
from olp.transpile.convert import run_converted

# Turned by 30 deg about Z: cos 0.8660254, sin 0.5.
TABLE = "{X 700,Y 100,Z 0,A 30,B 0,C 0}"
WORK = 'PERS wobjdata w:=[FALSE,TRUE,"",[[700,100,0],[0.9659258263,0,0,0.2588190451]],[[0,0,0],[1,0,0,0]]];'
DOWN = "[[100,-50,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
FIRST = (811.6025, 106.6987, 500.0)  # 700 + 100 cos + 50 sin, 100 + 100 sin - 50 cos


def places(plan):
    """[mm] of the moves' targets, seen from the base."""
    return [tuple(1000 * step.target) for step in plan.steps()]


def assert_places(plan, *expected):
    np.testing.assert_allclose(places(plan), expected, atol=2e-3)


# --- from where the arm stands --------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["inform", "rapid", "tp", "urscript"])
def test_a_move_by_an_offset_goes_along_its_own_frame(target):
    rows = (f"$BASE={TABLE}", "$VEL.CP=0.1", "LIN {X 100,Y -50,Z 500,A 0,B 0,C 180}", "LIN_REL {X 50}")
    plan = run_elsewhere(krl(*rows), "krl", target)
    # 50 mm along the table's X: 43.3013 and 25.
    assert_places(plan, FIRST, (854.9038, 131.6987, 500.0))


@pytest.mark.parametrize("target", ["inform", "rapid", "urscript"])
def test_a_move_by_an_offset_along_the_tool_goes_where_the_tool_points(target):
    rows = ("$VEL.CP=0.1", "LIN {X 900,Y 100,Z 500,A 90,B 0,C 180}", "LIN_REL {X 20,Z 30} #TOOL")
    # The tool's Z points down, and its X along the base's Y.
    plan = run_elsewhere(krl(*rows), "krl", target)
    assert_places(plan, (900.0, 100.0, 500.0), (900.0, 120.0, 470.0))


@pytest.mark.parametrize("target", ["rapid", "urscript"])
def test_where_the_arm_stands_is_seen_in_the_base_that_holds(target):
    head = ("DECL FRAME HERE", f"$BASE={TABLE}", "$VEL.CP=0.1", "LIN {X 100,Y -50,Z 500,A 0,B 0,C 180}")
    plan = run_elsewhere(
        krl(*head, "HERE=$POS_ACT", "LIN {X 150,Y -50,Z 500,A 0,B 0,C 180}", "LIN HERE"), "krl", target
    )
    assert_places(plan, FIRST, (854.9038, 131.6987, 500.0), FIRST)


@pytest.mark.parametrize("asked", ["", "\\Tool:=tool0\\WObj:=w"])
@pytest.mark.parametrize("target", ["krl", "rapid", "tp", "urscript"])
def test_crobt_is_seen_in_the_work_object_that_it_names_or_of_the_move_before(target, asked):
    rows = (f"MoveL {DOWN},v100,fine,tool0\\WObj:=w;", f"p1:=CRobT({asked});")
    rows += ("MoveL Offs(p1,50,0,0),v100,fine,tool0\\WObj:=w;",)
    text = module(*rows, data=(WORK, "VAR robtarget p1;"))
    plan = (
        read(text, "rapid").plan(robot=ROBOT) if target == "rapid" else run_elsewhere(text, "rapid", target)
    )
    assert_places(plan, FIRST, (854.9038, 131.6987, 500.0))


def test_crobt_in_the_world_is_no_position_in_the_work_object():
    rows = (f"MoveL {DOWN},v100,fine,tool0\\WObj:=w;", "p1:=CRobT(\\Tool:=tool0\\WObj:=wobj0);")
    text = module(*rows, "MoveL Offs(p1,10,0,0),v100,fine,tool0;", data=(WORK, "VAR robtarget p1;"))
    plan = run_elsewhere(text, "rapid", "urscript")
    assert_places(plan, FIRST, (821.6025, 106.6987, 500.0))
    assert_places(run_elsewhere(text, "rapid", "krl"), FIRST, (821.6025, 106.6987, 500.0))
    with pytest.raises(OlpError, match="another frame"):
        converted(
            text.replace("CRobT(\\Tool:=tool0\\WObj:=wobj0)", "CRobT(\\WObj:=w)"),
            "rapid",
            "inform",
            on_loss="error",
        )


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript"])
def test_where_the_arm_stands_is_seen_with_the_tool_that_holds(target):
    """Chosen behind the move before: with the tool of that move the place would be another one."""
    rows = ("DECL FRAME HERE", "DECL REAL N", f"$BASE={TABLE}", "$VEL.CP=0.1", "LIN {X 100,Y -50,Z 500,A 0,B 0,C 180}",
            "$BASE={X 10,Y 0,Z 0,A 0,B 0,C 0}", "$TOOL={X 0,Y 30,Z 40,A 0,B 0,C 0}", "HERE=$POS_ACT", "N=$POS_ACT.Z",
            "IF $POS_ACT.X>N THEN", "N=N+1", "ENDIF", "HERE.Z=N", "LIN HERE")  # fmt: skip
    text = krl(*rows)
    assert not [loss for loss in converted(text, "krl", target).translated.losses if loss.leaves_out]
    assert_places(run_elsewhere(text, "krl", target), *places(read(text, "krl").plan(robot=ROBOT)))


def test_what_reads_with_another_tool_than_the_controller_holds_is_refused():
    """INFORM has no statement that chooses a tool."""
    rows = (
        "$VEL.CP=0.1",
        "LIN {X 900,Y 2,Z 903,A 0,B 90,C 0}",
        "$TOOL={X 0,Y 30,Z 40,A 0,B 0,C 0}",
        "HERE=$POS_ACT",
    )
    made = converted(krl("DECL FRAME HERE", *rows), "krl", "inform")
    assert [loss.line for loss in made.translated.losses if loss.leaves_out] == [6]


OFFSETS = (
    "L P[1] 100mm/sec FINE",
    "L P[2] 100mm/sec FINE Offset,PR[1]",
    "L P[2] 100mm/sec FINE Tool_Offset,PR[1]",
)
SPOTS = [(1, 0, 0, 900.0, 0.0, 500.0, 180.0, 0.0, 0.0), (2, 0, 0, 900.0, 100.0, 500.0, 180.0, 0.0, 0.0)]


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "urscript"])
def test_offsets_that_turn_are_frames_before_and_behind_the_target(target):
    values = [f"PR[1,{n}]={value}" for n, value in enumerate((10, 0, 20, 0, 0, 90), 1)]
    plan = run_elsewhere(tp(*values, *OFFSETS, positions=SPOTS), "tp", target)
    # Turned by 90 deg, (900, 100) is (-100, 900); the tool's Z points down, and X where it did.
    assert_places(plan, (900.0, 0.0, 500.0), (-90.0, 900.0, 520.0), (910.0, 100.0, 480.0))


@pytest.mark.parametrize(
    ("target", "written"),
    [("krl", "LIN PV1:P2"), ("urscript", "pose_trans(PV1, P2)"), ("rapid", "PoseMult([PV1.trans,PV1.rot],")],
)
def test_an_offset_that_only_others_set_stays_one_and_the_receipt_asks_for_it(target, written):
    made = converted(tp(*OFFSETS[:2], positions=SPOTS), "tp", target)
    assert written in b"\n".join(made.files.values()).decode("cp1252")
    assert [loss.part for loss in made.translated.losses if "zeros are written" in loss.says] == ["variable"]
    assert made.translated.asks == {"set these values, which are zeros now": ("PV1",)}


# --- arcs -----------------------------------------------------------------------------------------------


def points_of(text):
    """[mm, deg] of the taught points of an INFORM job, by number."""
    rows = re.findall(r"C(\d+)=([-\d.,]+)", text)
    return {int(number): tuple(map(float, values.split(","))) for number, values in rows}


def test_an_arc_with_another_tool_begins_where_that_tool_stands():
    head = ("$VEL.CP=0.1", "$TOOL={X 0,Y 0,Z 100,A 0,B 0,C 0}", "LIN {X 900,Y 0,Z 500,A 0,B 0,C 180}")
    arc = "CIRC {X 950,Y 50,Z 350,A 0,B 0,C 180},{X 900,Y 100,Z 350,A 0,B 0,C 180}"
    text = translated(krl(*head, "$TOOL={X 30,Y 0,Z 250,A 0,B 0,C 0}", arc), "krl", "inform")
    # The flange is 100 above the first tip; the second tip is 250 below the flange and 30 along X.
    assert points_of(text)[1][:3] == pytest.approx((930.0, 0.0, 350.0), abs=1e-3)


def test_an_arc_in_another_frame_begins_at_the_same_place_seen_from_there():
    head = ("$VEL.CP=0.1", "$BASE={X 700,Y 0,Z 100,A 90,B 0,C 0}", "LIN {X 100,Y -200,Z 400,A 0,B 0,C 180}")
    arc = "CIRC {X 0,Y 150,Z 500,A 0,B 0,C 180},{X 50,Y 100,Z 500,A 0,B 0,C 180}"
    text = translated(krl(*head, "$BASE={X 800,Y 50,Z 0,A -90,B 0,C 0}", arc), "krl", "inform")
    # The base sees (900, 100, 500), which is (100, 50, 500) from the second origin, turned by +90 deg.
    place = points_of(text)[1]
    assert place[:3] == pytest.approx((-50.0, 100.0, 500.0), abs=1e-3)
    assert abs(place[5]) == pytest.approx(180.0, abs=1e-3)


@pytest.mark.parametrize("target", ["rapid", "urscript"])
def test_the_point_on_the_way_stands_in_the_frame_of_its_arc(target):
    head = ("$VEL.CP=0.1", "$BASE={X 700,Y 0,Z 0,A 90,B 0,C 0}", "LIN {X 0,Y -200,Z 500,A 0,B 0,C 180}")
    text = krl(*head, "CIRC {X 50,Y -250,Z 500,A 0,B 0,C 180},{X 100,Y -200,Z 500,A 0,B 0,C 180}")
    plan = run_elsewhere(text, "krl", target)
    away = np.linalg.norm(1000 * plan.positions.position - np.array([950.0, 50.0, 500.0]), axis=1)
    assert away.min() < 2e-3


def test_a_chain_of_points_bulges_away_from_the_next_one():
    points = ["///TOOL 0", "///POSTYPE BASE", "///RECTAN"]
    # A circle of 100 mm about (900, 0): its points at 0, 60 and 90 deg, and one at 180.
    for number, (x, y) in enumerate(((1000, 0), (950, 86.603), (900, 100), (800, 0))):
        points.append(f"C{number:05d}={x:.3f},{y:.3f},500.000,180.0000,0.0000,0.0000")
    rows = ["MOVC C00000 V=100.0", "MOVC C00001 V=100.0", "MOVC C00002 V=90.0", "MOVC C00003 V=80.0"]
    text = translated(inform(*rows, points=points), "inform", "rapid")
    (way,) = re.findall(r"arc_point:=\[\[([-\d.]+),([-\d.]+),500\]", text)
    assert tuple(map(float, way)) == pytest.approx((986.603, 50.0), abs=2e-3)  # at 30 deg
    assert "MoveC arc_point,P1," in text


# --- what points and frames are taught with -------------------------------------------------------------


def test_taught_points_keep_their_tool_and_their_user_frame():
    points = ["///USER 3", "///TOOL 2", "///POSTYPE USER", "///RECTAN"]
    points.append("C00000=100.000,50.000,20.000,180.0000,0.0000,0.0000")
    source = inform("MOVL C00000 V=100.0 PL=0", points=points)
    text = translated(source, "inform", "krl")
    assert "$TOOL=TOOL_DATA[2]" in text
    assert "$BASE=BASE_DATA[3]" in text


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "urscript"])
def test_the_plane_of_a_computed_frame_has_its_y_where_it_was(target):
    rows = ("UFRAME_NUM=1", "UTOOL_NUM=0", "L P[1] 100mm/sec FINE")
    head = (
        "PR[1,1]=700",
        "PR[1,2]=100",
        "PR[1,3]=0",
        "PR[1,4]=0",
        "PR[1,5]=0",
        "PR[1,6]=30",
        "UFRAME[1]=PR[1]",
    )
    text = tp(*head, *rows, positions=[(1, 1, 0, 100.0, -50.0, 500.0, 180.0, 0.0, 0.0)])
    assert_places(run_converted(converted(text, "tp", target), target, ROBOT, read(text, "tp")), FIRST)


# --- external axes --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("target", "written"), [("krl", r"E1 ([\d.]+),E2 ([\d.]+)"), ("rapid", r",\[([\d.]+),([\d.]+),9E9")]
)
def test_external_axes_keep_their_millimetres_and_degrees(target, written):
    text = tp("J P[1] 50% FINE", positions=[(1, 0, 0, 900.0, 0.0, 500.0, 180.0, 0.0, 0.0)])
    text = text.replace("R = 0.000 deg", "R = 0.000 deg,\n\tE1 = 250.000 mm,\tE2 = 30.000 deg")
    ((slide, turn),) = re.findall(written, translated(text, "tp", target))
    assert (float(slide), float(turn)) == pytest.approx((250.0, 30.0))


@pytest.mark.parametrize(("value", "unit"), [(250.0, "deg"), (850.5, "mm")])
def test_external_axes_have_the_unit_in_tp_that_their_values_suggest(value, unit):
    place = "X 900,Y 0,Z 500,A 0,B 0,C 180"
    text = krl("$VEL.CP=0.1", f"LIN {{{place},E1 {value},E2 0}}", f"LIN {{{place},E1 20,E2 0}}")
    assert not converted(krl("$VEL.CP=0.1", f"LIN {{{place},E1 0}}"), "krl", "tp").translated.losses
    written = translated(text, "krl", "tp")
    assert [float(x) for x in re.findall(rf"E1= +([\d.]+) +{unit}", written)] == [value, 20.0]
    assert "E2=" not in written
    made = converted(text, "krl", "tp").translated
    assert [(x.line, x.fate.value) for x in made.losses] == [(3, "approximated"), (4, "approximated")]
    assert any("external axes" in asked for asked in made.asks)


@pytest.mark.parametrize("target", ["inform", "urscript"])
def test_external_axes_are_no_part_of_the_arm_elsewhere_and_never_dropped(target):
    place = "X 900,Y 0,Z 500,A 0,B 0,C 180"
    still = krl("$VEL.CP=0.1", f"LIN {{{place},E1 0,E2 0}}")
    assert not converted(still, "krl", target).translated.losses
    slid = krl("$VEL.CP=0.1", "DECL E6POS P1", f"LIN {{{place},E1 250.0,E2 0}}")
    with pytest.raises(OlpError, match="external axes"):
        converted(slid, "krl", target, on_loss="error")
    (loss,) = converted(slid, "krl", target).translated.losses
    assert (loss.line, loss.fate.value, loss.part) == (4, "approximated", "beside")
    assert "external axes" in loss.says
    assert "external axis 1: 250" in translated(slid, "krl", target)
    rows = [f"P[{n}]={{{place},E1 {25 * n},E2 0}}" for n in (1, 2)]
    computed = krl(
        "DECL E6POS P[2]",
        "DECL INT n",
        "$VEL.CP=0.1",
        *rows,
        "n=2",
        "IF $IN[1] THEN",
        "n=1",
        "ENDIF",
        "LIN P[n]",
    )
    line = next(n for n, row in enumerate(computed.splitlines(), 1) if "LIN" in row)
    losses = converted(computed, "krl", target).translated.losses
    assert [one for one in losses if one.line == line and (one.leaves_out or one.part == "beside")]


@pytest.mark.parametrize("second", ["100,200", "101,200"])
def test_a_station_that_stands_still_is_no_group_that_moves(second):
    points = [
        "///TOOL 0",
        "///POSTYPE BASE",
        "///RECTAN",
        "C00000=900.000,0.000,500.000,180.0000,0.0000,0.0000",
    ]
    points += ["C00001=900.000,100.000,500.000,180.0000,0.0000,0.0000"]
    points += ["///POSTYPE PULSE", "///PULSE", "EC00000=100,200", f"EC00001={second}"]
    rows = [f"MOVL C0000{n} V=100.0 PL=0 +MOVJ EC0000{n} VJ=50.00" for n in (0, 1)]
    text = inform(*rows, points=points).replace("NPOS 2,0,0", "NPOS 2,0,2")
    text = text.replace("///GROUP1 RB1", "///GROUP1 RB1\n///GROUP2 ST1")
    made = converted(text, "inform", "krl")
    if second == "100,200":
        assert not made.translated.losses
        assert any("the station has the same position" in note for note in made.translated.notes)
    else:
        told = {(loss.fate.value, loss.part) for loss in made.translated.losses}
        assert told == {("approximated", "external")}
        assert b"E1 0.101,E2 0.2" in b"".join(made.files.values())


@pytest.mark.parametrize(
    ("kind", "second", "says"),
    [
        ("PULSE", "104847", "the track has the same position"),
        ("PULSE", "104848", "external"),
        ("BASE", "104847", ""),  # which the track does not carry along: the arm's own base is elsewhere
    ],
)
def test_a_track_that_stands_still_carries_what_is_taught_in_pulses(kind, second, says):
    places = ["100,-2000,3000,0,-50000,0", "8000,-2000,3000,0,-50000,0"]
    head = ["///POSTYPE PULSE", "///PULSE"]
    if kind == "BASE":
        head = ["///POSTYPE BASE", "///RECTAN"]
        places = ["900.0,0.0,500.0,180.0,0.0,0.0", "900.0,100.0,500.0,180.0,0.0,0.0"]
    points = ["///TOOL 0", *head, *(f"C0000{n}={place}" for n, place in enumerate(places))]
    points += ["///POSTYPE PULSE", "///PULSE", "BC00000=104847", f"BC00001={second}"]
    points += ["EC00000=1,2", "EC00001=1,2"]
    rows = [f"SMOVL C0000{n} BC0000{n} V=100.0 PL=0 +MOVJ EC0000{n}" for n in (0, 1)]
    text = inform("MEMOF", "CLEAR MPF", *rows, points=points).replace("NPOS 2,0,0", "NPOS 2,2,2")
    text = text.replace("///GROUP1 RB1", "///GROUP1 RB1,BS1\n///GROUP2 ST1")
    made = converted(text, "inform", "krl")
    notes = made.translated.notes
    left_out = {
        loss.says for loss in made.translated.losses if loss.leaves_out and loss.statement != "Process"
    }
    if says:
        assert not left_out
        said = notes if says != "external" else [loss.part for loss in made.translated.losses]
        assert any(says in one for one in said)
        assert any("the station has" in note for note in notes)
        assert made.files[made.main].count(b"LIN ") == 2
    else:
        assert left_out == {
            "the program does not say where the target is for an arm whose base is on a track"
        }


SHIFTED_POINTS = (
    "///TOOL 0",
    "///POSTYPE BASE",
    "///RECTAN",
    "C00000=900.000,0.000,500.000,180.0000,0.0000,0.0000",
    "C00001=900.000,100.000,500.000,180.0000,0.0000,0.0000",
    "P001=10.0,0.0,0.0,0.0,0.0,0.0",
    "P002=0.0,0.0,5.0,0.0,0.0,0.0",
)
OTHERS = pytest.mark.parametrize("target", ["krl", "rapid", "tp", "urscript"])


@OTHERS
def test_every_move_is_written_with_the_shift_that_holds_for_it(target):
    rows = ("SFTON P001", "MOVL C00001 V=50.0 PL=0", "SFTOF", "MOVL C00000 V=100.0 PL=0")
    text = inform(*rows, "SFTON P002 TF", "MOVL C00000 V=100.0 PL=0", points=SHIFTED_POINTS)
    there = ((910.0, 100.0, 500.0), (900.0, 0.0, 500.0), (900.0, 0.0, 495.0))
    assert_places(run_elsewhere(text, "inform", target), *there)


@OTHERS
def test_a_shift_that_changes_from_pass_to_pass_is_that_of_its_time(target):
    rows = ("SET B000 0", "*AGAIN", "SFTON P002", "ADD P002 P001", "MOVL C00000 V=50.0 PL=0", "SFTOF")
    rows += ("MOVL C00001 V=50.0 PL=0", "INC B000", "JUMP *AGAIN IF B000<2")
    text = inform(*rows, points=SHIFTED_POINTS)
    corner = (900.0, 100.0, 500.0)
    there = ((900.0, 0.0, 505.0), corner, (910.0, 0.0, 505.0), corner)
    assert_places(run_elsewhere(text, "inform", target), *there)


@OTHERS
def test_a_shift_that_may_turn_the_tool_is_left_out_with_its_moves(target):
    rows = (
        "SETE P001 (6) D000",
        "SFTON P001",
        "MOVL C00001 V=50.0 PL=0",
        "SFTOF",
        "MOVL C00000 V=100.0 PL=0",
    )
    text = inform(*rows, points=SHIFTED_POINTS)
    made = converted(text, "inform", target)
    assert len([loss for loss in made.translated.losses if loss.leaves_out]) >= 2
    assert_places(run_elsewhere(text, "inform", target), (900.0, 0.0, 500.0))


@pytest.mark.parametrize("target", ["krl", "inform", "tp", "urscript"])
def test_a_displacement_holds_in_the_routines_that_are_called_within_it(target):
    place = "[[900,0,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    routine = ("PROC go()", f"MoveL {place},v100,fine,tool0;", "ENDPROC")
    text = module("PDispSet [[10,0,0],[1,0,0,0]];", "go;", "PDispOff;", "go;", data=routine)
    assert_places(run_elsewhere(text, "rapid", target), (910.0, 0.0, 500.0), (900.0, 0.0, 500.0))


# --- position variables, which INFORM gives a frame and a tool ----------------------------------------------

POSES = ("{X 900,Y 0,Z 500,A 0,B 0,C 180}", "{X 900,Y 100,Z 500,A 0,B 0,C 180}")
COPIES = (
    ("g[1]=p", "PTP p", "LIN g[1]"),
    (f"g[1]={POSES[1]}", "g[2]=g[1]", "PTP g[1]", "LIN g[2]"),
    ("PTP p", "q=p", "$TOOL=TOOL_DATA[2]", "LIN q"),
    ("PTP p", "$TOOL=TOOL_DATA[2]", "$BASE=BASE_DATA[2]", "g[2]=p", "g[2].Y=50", "LIN g[2]"),
    (f"g[1]={POSES[1]}", "PTP g[1]", "$BASE=BASE_DATA[2]", "LIN g[1]"),
)


@pytest.mark.parametrize("rows", COPIES)
def test_a_copied_position_is_meant_with_the_tool_and_the_frame_of_the_move_to_it(rows, tmp_path, capfd):
    """KRL's positions have neither, INFORM's have both: SET P002 P001 copies those, too."""
    head = ("DECL E6POS p, q", "DECL E6POS g[3]", "BAS(#VEL_PTP,20)", "$VEL.CP=0.3")
    head += ("$TOOL=TOOL_DATA[1]", "$BASE=BASE_DATA[1]", f"p={POSES[0]}", "p.Z=p.Z+1")
    job = tmp_path / "part.src"
    job.write_text(krl(*head, *rows), newline="")
    command = ["convert", str(job), "--to", "inform", "-o", str(tmp_path / "there")]
    status = main([*command, "--robot", "yaskawa/gp25"])
    told = capfd.readouterr().out  # with other values of the tools and frames the runs agree, too
    assert (status, "all exact" in told, "no further differences" in told) == (0, True, True), told


@pytest.mark.parametrize(("storage", "begins_anew"), [("VAR", True), ("PERS", False)])
def test_a_position_that_its_program_changes_begins_anew_where_the_source_s_does(storage, begins_anew):
    """What stands below //POS is loaded with the job, once: a second start finds what the first one left."""
    point = f"{storage} robtarget q:=[[900,0,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    text = module("q.trans.x:=q.trans.x-10;", "MoveL q,v100,fine,tool0;", data=[point])
    made = translated(text, "rapid", "inform")
    changed = re.search(r"SETE (P\d+) \(1\)", made)[1]
    first = re.search(rf"SET {changed} (P\d+)", made)
    assert (first is not None) == begins_anew
    held = first[1] if first else changed
    assert f"P00{held[1:]}=900.000,0.000,500.000," in made
    assert_places(run_elsewhere(text, "rapid", "inform"), (890.0, 0.0, 500.0))


# The place of one pose in another's turn: what PolyScope programs compute way points with.
POSE_SUMS = """def part():
  global start = p[0.65, -0.3, 0.47, 2.2219, 2.22039, -0.00036]
  global there = p[0.7, -0.25, 0.57, 0.1, 3.1, 0]
  movel(there, a=1.2, v=0.25)
  global now = pose_sub(get_actual_tcp_pose(), start)
  global up = pose_sub(there, p[0, 0, -0.05, 0, 0, 0])
  movel(up, a=1.2, v=0.25)
  movel(pose_add(start, now), a=1.2, v=0.1)
  local next = pose_trans(pose_sub(there, start), p[0, 0, 0.1, 0, 0, 0])
  movel(pose_trans(start, next), a=1.2, v=0.25)
end
"""


@pytest.mark.parametrize("target", ["inform", "krl", "rapid"])
def test_poses_that_are_added_and_subtracted_are_products_whose_places_are_set(target):
    own, there = (plan_of_poses(one) for one in (None, target))
    np.testing.assert_allclose(there[0], own[0], atol=1e-5)
    turned = np.abs(np.sum(there[1] * own[1], axis=1))  # q and -q are one turn
    np.testing.assert_allclose(turned, 1, atol=1e-8)
    losses = converted(POSE_SUMS, "urscript", target).translated.losses
    assert not [one for one in losses if one.leaves_out]


def plan_of_poses(target):
    """Places [m] and turns of all targets of lines; None: of the program itself."""
    plan = run_elsewhere(POSE_SUMS, "urscript", target) if target else run(read(POSE_SUMS, "urscript"), ROBOT)
    at = plan.moves.target
    return plan.positions.position[at], plan.positions.quaternion[at]
