"""FANUC's E1, E2 and E3: axes beside the arm, in joint positions and in poses, and what translations make of them."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest
from test_arm_branch import GP25
from tp_listings import listing, read

from olp.core.diagnostic import OlpError
from olp.ir.expressions import PositionLiteral
from olp.transpile import Context
from olp.transpile.convert import convert, run_converted, runs_of
from olp.transpile.link import link
from olp.transpile.receipt import receipt_of

JOINTS = "\tJ1= {0:.4f} deg,\tJ2= {1:.4f} deg,\tJ3= {2:.4f} deg,\n\tJ4= {3:.4f} deg,\tJ5= {4:.4f} deg,\tJ6= {5:.4f} deg"
POSE = "\tX = {0:.4f}  mm,\tY = {1:.4f}  mm,\tZ = {2:.4f}  mm,\n\tW = {3:.4f} deg,\tP = {4:.4f} deg,\tR = {5:.4f} deg"
STANDS = ([2.865, 11.459, -17.189, 11.459, -51.566, 11.459], [9.5, 3.25, -8.5, 21.25, -40.5, 31.75])
PLACES = ([850.25, 100.5, 400.75, 166.6332, -6.4235, 12.5658], [870.5, 80.25, 410.5, 160.25, -4.5, 14.75])
BESIDE = ([120.5, 35.25, -12.75], [220.5, 45.25, -22.75], [20.5, 5.25, -2.75], [60.25, -15.5, 7.75])
MOVES = ("J P[1] 20% FINE", "L P[2] 200mm/sec FINE", "J P[3] 20% FINE", "L P[4] 100mm/sec FINE")


def positions(beside=BESIDE):
    rows = []
    for number, axes in enumerate(beside, 1):
        joint = number % 2 == 1
        numbers = (STANDS if joint else PLACES)[(number - 1) // 2]
        config = "" if joint else "\t\tCONFIG : 'F U T, 0, 0, 0',"
        further = "".join(
            f",\n\tE{n}= {value:.4f} {'mm' if n == 1 else 'deg'}" for n, value in enumerate(axes, 1)
        )
        values = (JOINTS if joint else POSE).format(*numbers)
        rows.append(f"P[{number}]{{\n   GP1:\n\tUF : 0, UT : 1,{config}\n{values}{further}\n}};\n")
    return "".join(rows)


def program(beside=BESIDE):
    return read(listing(*MOVES, positions=positions(beside)))


def test_axes_beside_the_arm_do_not_take_part_in_its_plan():
    with_them, without = (program(beside).plan(robot=GP25) for beside in (BESIDE, [[]] * 4))
    assert not [found.render() for found in with_them.diagnostics if found.is_error]
    for column in ("position", "quaternion", "axes"):
        one, other = (getattr(plan.positions, column)[plan.moves.target] for plan in (with_them, without))
        np.testing.assert_array_equal(one, other)
    ends = np.degrees(with_them.positions.axes[with_them.moves.target][[0, 2], :6])
    np.testing.assert_allclose(ends, STANDS, atol=1e-4)


def test_the_plan_says_that_it_leaves_them_out():
    says = [one.says for one in program().plan(robot=GP25).assumptions]
    assert sum("external axes are not in this plan" in text for text in says) == 1
    for beside in ([[]] * 4, [[0.0, 0.0, 0.0]] * 4):
        says = [one.says for one in program(beside).plan(robot=GP25).assumptions]
        assert not any("external axes" in text for text in says)


def test_seven_joints_are_another_robot_and_not_an_axis_beside_one():
    text = listing(MOVES[0], positions=positions([[]]).replace("\n};", ",\n\tJ7= 12.5 deg\n};"))
    assert "I002" in [found.code for found in read(text).plan(robot=GP25).diagnostics]


@pytest.mark.parametrize("target", ["krl", "rapid"])
def test_they_are_carried_as_written_to_languages_that_have_them(target):
    source = program()
    made = convert(source, target, Context(robot=GP25))
    literals = [d.value for d in made.translated.program.data if isinstance(d.value, PositionLiteral)]
    found = [literal.external for literal in literals if literal.external]
    np.testing.assert_allclose(found, BESIDE, atol=1e-9)
    text = "".join(data.decode("latin-1") for data in made.files.values())
    for row in BESIDE:
        first, second, third = (f"{value:g}" for value in row)
        words = {
            "krl": f"E1 {first},E2 {second},E3 {third}}}",
            "rapid": f"[{first},{second},{third},9E9,9E9,9E9]",
        }
        assert words[target] in text
    plans = (source.plan(robot=GP25), run_converted(made, target, GP25, source))
    ends = [plan.positions.axes[plan.moves.target][:, :6] for plan in plans]
    for one, other in pairwise(ends):
        np.testing.assert_allclose(one, other, atol=1e-5)


@pytest.mark.parametrize("target", ["inform", "urscript"])
def test_elsewhere_they_are_left_out_and_each_move_tells_where_they_go(target):
    source = program()
    with pytest.raises(OlpError) as refused:
        convert(source, target, Context(robot=GP25))
    assert {found.code for found in refused.value.diagnostics} == {"X011"}
    assert sorted(found.line for found in refused.value.diagnostics) == [8, 9, 10, 11]
    made = convert(source, target, Context(robot=GP25, on_loss="comment"))
    told = [loss for loss in made.translated.losses if loss.part == "beside"]
    assert [loss.line for loss in told] == [8, 9, 10, 11]
    runs = runs_of(source, made, target, (GP25, GP25))
    found = receipt_of(link(source), made.translated, target, tuple(made.files), runs, (GP25, GP25))
    left = [one.line for one in found.verdict.objections if one.kind == "left-out"]
    assert left == [8, 9, 10, 11]
    assert found.comparison is not None
    assert found.comparison.differences == []
    text = made.files[made.main].decode("cp1252")
    found = re.findall(r"external axis (\d): (\S+)", text)
    assert [float(value) for _, value in found] == [value for row in BESIDE for value in row]
    assert [number for number, _ in found] == ["1", "2", "3"] * 4
    returning = program([[0.0, 0.0, 0.0], *BESIDE[1:]])
    back = convert(returning, target, Context(robot=GP25, on_loss="comment"))
    assert [loss.line for loss in back.translated.losses if loss.part == "beside"] == [8, 9, 10, 11]
    made = convert(program([[0.0, 0.0, 0.0]] * 4), target, Context(robot=GP25))
    assert not [loss for loss in made.translated.losses if loss.part == "beside"]


def test_one_that_is_left_out_keeps_the_place_of_the_next():
    text = listing(MOVES[0], positions=positions([BESIDE[0]]).replace(",\n\tE2= 35.2500 deg", ""))
    made = convert(read(text), "rapid", Context(robot=GP25))
    assert b"[120.5,9E9,-12.75,9E9,9E9,9E9]" in made.files[made.main]
