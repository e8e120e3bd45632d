"""Numbers of translations, each computed here by hand: units, shares, zones, frames and numbered data."""

import math
import re

import numpy as np
import pytest
from translated_texts import ROBOT, converted, inform, krl, module, run_elsewhere, script, tp, translated

from olp.robots.kinematics import forward
from olp.runtime.plan import WaitStep

JOINTS = ([0.0, 0.0, 0.0, 0.0, -0.5, 0.0], [0.6, 0.1, 0.0, 0.0, -0.5, 0.0])


def found_number(pattern, text, at=-1):
    return float(re.findall(pattern, text)[at])


# --- speeds ---------------------------------------------------------------------------------------------


def ur_joint_moves(speed):
    return script(*[f"movej({joints}, a=1.0, v={speed})" for joints in JOINTS])


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


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
def test_an_axis_speed_in_a_variable_is_told_and_not_guessed(target):
    text = script("v_fun = 4", f"movej({JOINTS[1]}, a=1.0, v=v_fun)")
    losses = converted(text, "urscript", target).translated.losses
    assert "a speed in a variable" in " ".join(loss.says for loss in losses)


def test_a_move_with_several_lengths_gets_the_slowest_speed():
    # The first way to A turns S (210 deg/s), every other one T (885 deg/s), which takes a smaller share for 0.5 rad/s.
    home, a, b = "[0.0,0,0,0,-0.5,0]", "[0.6,0,0,0,-0.5,0]", "[0.6,0,0,0,-0.5,0.6]"
    rows = [f"movej({home}, v=0.5)", "n = 0", "while n < 2:"]
    rows += [f"  movej({a}, v=0.5)", f"  movej({b}, v=0.5)", "  n = n + 1", "end"]
    made = converted(script(*rows), "urscript", "inform")
    text = made.files[made.main].decode("cp1252")
    shares = [float(share) for share in re.findall(r"VJ=([\d.]+)", text)]
    slow, fast = (100 * math.degrees(0.5) / rated for rated in (885, 210))
    assert shares[-2:] == pytest.approx([slow, slow], abs=0.01)
    (loss,) = [one for one in made.translated.losses if "several lengths" in one.says]
    assert loss.size == pytest.approx(100 * (fast / slow - 1), rel=0.01)


# --- accelerations --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("target", "written"), [("inform", "ACC=50"), ("tp", "ACC50"), ("rapid", "AccSet 50,")]
)
def test_an_axis_acceleration_becomes_the_percent_of_the_rated_one(target, written):
    # L needs 0.5 s to its 210 deg/s: 420 deg/s² is the smallest rated acceleration of the axes.
    assert [axis.acceleration for axis in ROBOT.axes][1] == pytest.approx(math.radians(420))
    text = translated(script(f"movej({JOINTS[1]}, a={math.radians(210)!r}, v=0.5)"), "urscript", target)
    assert written in text


@pytest.mark.parametrize(
    ("target", "pattern"), [("urscript", r"a=([\d.]+)"), ("krl", r"ACC_AXIS\[1\]=([\d.]+)")]
)
def test_a_percent_of_the_axis_acceleration_is_of_the_rated_one(target, pattern):
    points = [
        "///TOOL 0",
        "///POSTYPE ANGLE",
        "///ANGLE",
        "C00000=34.0000,0.0000,0.0000,0.0000,-28.0000,0.0000",
    ]
    source = inform("MOVJ C00000 VJ=25.00 PL=0 ACC=50", points=points)
    expected = {"urscript": math.radians(210), "krl": 50.0}[target]
    assert found_number(pattern, translated(source, "inform", target)) == pytest.approx(expected, rel=1e-6)


def test_an_acceleration_within_a_branch_is_not_believed_behind_it():
    points = ["///TOOL 0", "///POSTYPE ANGLE", "///ANGLE"]
    points += ["C00000=34.0000,0.0000,0.0000,0.0000,-28.0000,0.0000"]
    points += ["C00001=4.0000,0.0000,0.0000,0.0000,-28.0000,0.0000"]
    rows = (
        "MOVJ C00000 VJ=25.00 PL=0 ACC=80",
        "IFTHEN IN#(1)=ON",
        "MOVJ C00001 VJ=25.00 PL=0 ACC=50",
        "ENDIF",
    )
    source = inform(*rows, "MOVJ C00000 VJ=25.00 PL=0 ACC=50", points=points)
    assert re.findall(r"AccSet (\d+)", translated(source, "inform", "rapid")) == ["80", "50", "50"]
    assert re.findall(r"\$ACC_AXIS\[6\]=(\d+)", translated(source, "inform", "krl")) == [
        "100",
        "80",
        "50",
        "50",
    ]


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
    points = ["///TOOL 0", "///POSTYPE BASE", "///RECTAN"]
    points += ["P001=900.0,100.0,500.0,180.0,0.0,0.0", "P002=900.0,300.0,500.0,180.0,0.0,0.0"]
    source = inform(f"MOVL P001 V=200.0 PL={level}", "MOVL P002 V=200.0 PL=0", points=points)
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
        moves = (f"L P[1] 400mm/sec CNT{share}", f"L P[2] 400mm/sec CNT{share}", "L P[1] 400mm/sec FINE")
        positions = [(n, 0, 0, 900.0, y, 500.0, 180.0, 0.0, 0.0) for n, y in ((1, 100.0), (2, 500.0))]
        text = translated(tp(*moves, positions=positions), "tp", "rapid")
        return float(re.findall(r"MoveL P2,v400,z([\d_]+),", text)[0].replace("_", "."))

    assert radius(50) == pytest.approx(radius(100) / 4, rel=1e-4)


# --- frames, names, signals, variables ------------------------------------------------------------------

TURNED = "[0.70710678118,0,0,0.70710678118]"  # 90 deg about Z


@pytest.mark.parametrize("target", ["inform", "krl", "tp", "urscript"])
def test_the_object_frame_stands_in_the_user_frame(target):
    wobj = f'PERS wobjdata w:=[FALSE,TRUE,"",[[500,0,0],{TURNED}],[[300,0,0],[1,0,0,0]]];'
    place = "[[10,20,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    plan = run_elsewhere(module(f"MoveL {place},v100,fine,tool0\\WObj:=w;", data=[wobj]), "rapid", target)
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
        "SET B000 0", "SET I000 7", "SET I001 9", "SET I[B000] 5",
        "IFTHEN I000=5", "TIMER T=1.50", "ELSE", "TIMER T=2.50", "ENDIF",
        "IFTHEN I001=9", "TIMER T=0.75", "ELSE", "TIMER T=3.50", "ENDIF",
    )  # fmt: skip
    plan = run_elsewhere(source, "inform", target)
    assert [step.duration for step in plan.steps() if isinstance(step, WaitStep)] == [1.5, 0.75]


@pytest.mark.parametrize(
    ("target", "pattern", "written", "size"),
    [("inform", r"VJ=([\d.]+)", 13.64, 0.00185), ("krl", r"VEL_PTP,([\d.]+)", 14.0, 0.35815)],
)
def test_a_speed_has_the_decimals_that_controllers_write_and_the_rest_is_in_the_receipt(
    target, pattern, written, size
):
    # 0.5 rad/s of 210 deg/s are 13.64185 %.
    made = converted(ur_joint_moves(0.5), "urscript", target)
    text = b"\n".join(made.files.values()).decode("cp1252")
    assert found_number(pattern, text) == written
    found = [loss for loss in made.translated.losses if "rounded" in loss.says and loss.part == "speed"]
    assert found[-1].size == pytest.approx(size, abs=1e-4)


def test_fanuc_gets_no_sign_before_a_register_and_no_function_of_a_number():
    rows = ("a:=-b;", "b:=Sin(30.5);", "WaitTime a*Sqrt(2.25);", "a:=Sin(b);")
    text = translated(module(*rows, data=("VAR num a:=1;", "VAR num b:=2;")), "rapid", "tp")
    assert "R[2:a]=0-R[1:b]" in text
    assert "R[1:b]=.507538363" in text.replace("=0.", "=.")  # sin 30.5 deg
    assert "SQRT" not in text
    assert "R[2:a]=SIN[R[1:b]]" in text
