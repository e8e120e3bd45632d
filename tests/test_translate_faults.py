"""Numbers of translations, each computed here by hand: units, shares, zones, frames and numbered data."""

import math
import re

import numpy as np
import pytest

from olp.kinematics import forward
from olp.plan import WaitStep
from olp.reading import read_source
from olp.robot import load_robot
from olp.source import decode
from olp.translate import Context
from olp.translate.convert import convert, run_converted
from olp.translate.link import link

ROBOT = load_robot("yaskawa/gp25")
JOINTS = ([0.0, 0.0, 0.0, 0.0, -0.5, 0.0], [0.6, 0.1, 0.0, 0.0, -0.5, 0.0])
NAMES = {
    "inform": "part.jbi",
    "krl": "part.src",
    "rapid": "part.mod",
    "tp": "part.ls",
    "urscript": "part.script",
}


def read(text, vendor):
    program = read_source(decode(text.encode("cp1252"), NAMES[vendor]), vendor=vendor)
    assert not [d.render() for d in program.diagnostics if d.is_error]
    return link(program).program


def translated(text, vendor, target):
    made = convert(
        read(text, vendor), target, Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00"
    )
    return b"\n".join(made.files.values()).decode("cp1252")


def module(*rows, data=()):
    return "\r\n".join(["MODULE M", *data, "PROC main()", *rows, "ENDPROC", "ENDMODULE", ""])


def krl(*rows):
    return "\r\n".join(["DEF PART ( )", *rows, "END", ""])


def inform(*rows):
    head = ["/JOB", "//NAME PART", "//POS", "///NPOS 0,0,0,0,0,0", "//INST"]
    head += ["///DATE 2026/03/02 14:07", "///ATTR SC,RW", "///GROUP1 RB1", "NOP"]
    return "\r\n".join([*head, *rows, "END", ""])


def found_number(pattern, text, at=-1):
    return float(re.findall(pattern, text)[at])


# --- speeds ---------------------------------------------------------------------------------------------


def ur_joint_moves(speed):
    rows = [f"  movej({joints}, a=1.0, v={speed})" for joints in JOINTS]
    return "\n".join(["def part():", *rows, "end", ""])


def distance():
    """[m] between the flange's places at both joint positions."""
    positions, _ = forward(ROBOT, np.array(JOINTS))
    return math.dist(positions[0], positions[1])


def test_the_speed_of_the_leading_axis_becomes_the_share_that_takes_as_long():
    time = 0.6 / 0.5
    share = max(0.6 / ROBOT.speeds[0], 0.1 / ROBOT.speeds[1]) / time
    text = translated(ur_joint_moves(0.5), "urscript", "inform")
    assert found_number(r"VJ=([\d.]+)", text) == pytest.approx(100 * share, abs=0.01)


def test_the_speed_of_the_leading_axis_becomes_the_tools_mean_speed():
    length = distance()
    text = translated(ur_joint_moves(0.5), "urscript", "rapid")
    name = re.findall(r"MoveAbsJ .*\],(v\w+),", text)[-1]
    travel = found_number(rf"{name}:=\[([\d.]+),", text)
    assert travel == pytest.approx(1000 * length / (0.6 / 0.5), rel=1e-5)


def test_the_tools_speed_of_a_joint_move_becomes_the_leading_axis_speed():
    degrees = [", ".join(f"{math.degrees(v):.9f}" for v in joints) for joints in JOINTS]
    rows = [f"MoveAbsJ [[{one}],[9E9,9E9,9E9,9E9,9E9,9E9]],v500,fine,tool0;" for one in degrees]
    length = distance()
    text = translated(module(*rows), "rapid", "urscript")
    assert found_number(r"\bv=([\d.]+)", text) == pytest.approx(0.6 / (length / 0.5), rel=1e-5)


# --- blends ---------------------------------------------------------------------------------------------


def krl_moves(word, setting):
    place = "{{X 900,Y {},Z 500,A 0,B 0,C 180}}"
    rows = [setting, "$VEL.CP=0.4", "BAS (#VEL_PTP,30)", f"{word} {place.format(100)}"]
    return krl(
        *rows,
        f"{word} {place.format(200)} C_{'PTP' if word == 'PTP' else 'DIS'}",
        f"{word} {place.format(250)}",
    )


def test_a_share_of_the_way_is_of_its_half():
    text = translated(krl_moves("PTP", "$APO.CPTP=40"), "krl", "rapid")
    assert ",z20,tool0" in text  # 40 % of half of 100 mm


def test_a_radius_stays_a_radius_in_millimetres():
    text = translated(krl_moves("LIN", "$APO.CDIS=12.5"), "krl", "inform")
    assert re.findall(r"CR=([\d.]+)", text) == ["12.5"]


@pytest.mark.parametrize("level", [1, 3, 8])
def test_a_position_level_is_the_robots_zone_of_that_number(level):
    source = inform(f"MOVL P001 V=200.0 PL={level}", "MOVL P002 V=200.0 PL=0").replace(
        "///NPOS 0,0,0,0,0,0",
        "///NPOS 0,0,0,2,0,0\r\n///TOOL 0\r\n///POSTYPE BASE\r\n///RECTAN\r\n"
        "P001=900.0,100.0,500.0,180.0,0.0,0.0\r\nP002=900.0,300.0,500.0,180.0,0.0,0.0",
    )
    text = translated(source, "inform", "krl")
    assert found_number(r"CDIS=([\d.]+)", text) == pytest.approx(1000 * ROBOT.blend_zones[level - 1])


@pytest.mark.parametrize("level", [1, 3])
def test_a_radius_on_a_joint_move_is_the_level_with_that_zone(level):
    radius = 1000 * ROBOT.blend_zones[level - 1]
    source = krl_moves("PTP", f"$APO.CPTP={radius:g}")  # of half of 100 mm …
    source = source.replace("Y 200", "Y 300")  # … which is 100 mm, so that percents are millimetres
    assert f"PL={level}" in translated(source, "krl", "inform")


def test_half_a_corner_speed_begins_at_a_quarter_of_the_distance():
    def radius(share):
        rows = [
            "/PROG  PART", "/ATTR", "DEFAULT_GROUP\t= 1,*,*,*,*;", "/APPL", "/MN",
            f"   1:L P[1] 400mm/sec CNT{share} ;", f"   2:L P[2] 400mm/sec CNT{share} ;",
            "   3:L P[1] 400mm/sec FINE ;", "/POS",
        ]  # fmt: skip
        for number, y in ((1, 100.0), (2, 500.0)):
            rows += [
                f"P[{number}]{{", "   GP1:", "\tUF : 0, UT : 0,\t\tCONFIG : 'N U T, 0, 0, 0',",
                f"\tX = 900.000  mm,\tY = {y:.3f}  mm,\tZ = 500.000  mm,",
                "\tW = 180.000 deg,\tP = 0.000 deg,\tR = 0.000 deg", "};",
            ]  # fmt: skip
        text = translated("\n".join([*rows, "/END", ""]), "tp", "rapid")
        return float(re.findall(r"MoveL P2,v400,z([\d_]+),", text)[0].replace("_", "."))

    assert radius(50) == pytest.approx(radius(100) / 4, rel=1e-4)


# --- frames, names, signals, variables ------------------------------------------------------------------

TURNED = "[0.70710678118,0,0,0.70710678118]"  # 90 deg about Z


@pytest.mark.parametrize("target", ["inform", "krl", "tp", "urscript"])
def test_the_object_frame_stands_in_the_user_frame(target):
    wobj = f'PERS wobjdata w:=[FALSE,TRUE,"",[[500,0,0],{TURNED}],[[300,0,0],[1,0,0,0]]];'
    place = "[[10,20,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    program = read(module(f"MoveL {place},v100,fine,tool0\\WObj:=w;", data=[wobj]), "rapid")
    made = convert(program, target, Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00")
    plan = run_converted(made, target, ROBOT, program)
    # The user frame turns x into y: 500 + (-20), 300 + 10.
    (step,) = plan.steps()
    np.testing.assert_allclose(step.target, [0.48, 0.31, 0.5], atol=1e-6)


def test_signals_keep_the_numbers_of_their_names_and_others_are_apart():
    text = translated(module("SetDO do7,1;", "SetDO doGrip,1;", "SetDO doVacuum,0;"), "rapid", "inform")
    written = re.findall(r"DOUT OT#\((\d+)\) (ON|OFF)", text)
    assert written[0] == ("7", "ON")
    assert len({number for number, _ in written}) == 3


@pytest.mark.parametrize("target", ["krl", "rapid", "urscript"])
def test_variables_that_a_variable_counts_are_those_that_their_numbers_name(target):
    source = inform(
        "SET B000 2", "SET I002 7", "SET I003 9", "SET I[B000] 5",
        "IFTHEN I002=5", "TIMER T=1.50", "ELSE", "TIMER T=2.50", "ENDIF",
        "IFTHEN I003=9", "TIMER T=0.75", "ELSE", "TIMER T=3.50", "ENDIF",
    )  # fmt: skip
    program = read(source, "inform")
    made = convert(program, target, Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00")
    plan = run_converted(made, target, ROBOT, program)
    assert [step.duration for step in plan.steps() if isinstance(step, WaitStep)] == [1.5, 0.75]
