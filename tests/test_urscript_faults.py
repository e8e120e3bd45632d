"""Values of URScript that are seldom mixed as here: long turns, outputs that are read, numbers beside variables."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.expressions import Function, Named, Number, Quantity, Signal
from olp.ir.points import PointTable
from olp.ir.program import (
    Blend,
    BlendKind,
    Declare,
    If,
    Move,
    Path,
    Program,
    Routine,
    SetOutput,
    Speed,
    SpeedUnit,
)
from olp.languages.vendors.urscript.syntax import angles_from_vector, vector_from_angles
from olp.transpile.convert import export


def read(*lines):
    text = "\n".join(["def part():", *lines, "end", ""])
    program = read_source(decode(text.encode(), "part.script"), vendor="urscript")
    assert not [d.render() for d in program.diagnostics if d.is_error]
    return program


def written(*statements, data=()):
    """A program of another language as URScript."""
    body = tuple(replace(s, line=n) for n, s in enumerate(statements, 1))
    source = decode(b"\n" * 50, "made.src", "cp1252")
    program = Program("krl", source, (Routine("PART", 1, body, PointTable()),), data=data, main="PART")
    return export(program, "urscript").decode()


def joint_move(target):
    speed = Speed(SpeedUnit.AXIS, Quantity(Number(1.0), 1.0))
    return Move(0, Path.JOINT, (target,), speed, Blend(BlendKind.RADIUS, Quantity(Number(0), 1.0)))


# The quaternion of these has a negative scalar, so that its opposite is the shorter turn.
LONG = [(150, 60, -150), (-170, 80, 170), (100, -70, 160), (179, 45, -179)]


@pytest.mark.parametrize("degrees", LONG)
def test_the_vector_of_angles_is_the_shorter_turn(degrees):
    angles = tuple(map(math.radians, degrees))
    rotation = Rotation.from_euler("xyz", angles)
    w = math.prod(math.cos(a / 2) for a in angles) + math.prod(math.sin(a / 2) for a in angles)
    assert w < 0.0
    vector = vector_from_angles(*angles)
    np.testing.assert_allclose(vector, rotation.as_rotvec(), atol=1e-9)
    back = Rotation.from_euler("xyz", angles_from_vector(*vector))
    assert (back.inv() * rotation).magnitude() < 1e-7


@pytest.mark.parametrize(
    ("word", "bus"),
    [
        ("get_digital_in", "in"),
        ("get_digital_out", "out"),
        ("get_standard_digital_out", "out"),
        ("get_standard_analog_out", "analog-out"),
        ("get_tool_digital_out", "tool-out"),
    ],
)
def test_an_output_that_is_read_is_no_input(word, bus):
    program = read(f"  if ({word}(3)):", "    sleep(1.0)", "  end")
    (found,) = (s for s in program.routines[0].body if isinstance(s, If))
    assert found.condition == Signal(bus, Number(3))


@pytest.mark.parametrize(("value", "word"), [(0, "False"), (1, "True")])
def test_an_output_that_is_set_to_a_number_is_on_for_one(value, word):
    text = written(SetOutput(0, Signal("out", Number(2)), Number(value)))
    assert f"set_standard_digital_out(2, {word})" in text


def test_joint_values_beside_a_variable_are_in_radians():
    axes = (Named("turn"), *map(Number, (-90, 90, 0, 45, 180)))
    text = written(
        joint_move(Function("joints", axes)), data=(Declare(0, "turn", "real", Number(30.0), shared=True),)
    )
    (line,) = (row for row in text.splitlines() if "movej" in row)
    inside = line[line.index("[") + 1 : line.index("]")].split(", ")
    assert inside[0] == "d2r(turn)"
    np.testing.assert_allclose([*map(float, inside[1:])], np.radians([-90, 90, 0, 45, 180]), atol=1e-12)


def test_a_pose_of_plain_numbers_is_in_metres_and_a_rotation_vector():
    target = Function("pose-angles", tuple(map(Number, (250, -100, 400, 180, 0, 30))))
    linear = replace(
        joint_move(target), path=Path.LINEAR, speed=Speed(SpeedUnit.TRAVEL, Quantity(Number(0.2), 1.0))
    )
    (line,) = (row for row in written(linear).splitlines() if "movel" in row)
    values = [*map(float, line[line.index("p[") + 2 : line.index("]")].split(", "))]
    np.testing.assert_allclose(values[:3], [0.25, -0.1, 0.4], atol=1e-9)
    turned = Rotation.from_rotvec(values[3:])
    wanted = Rotation.from_euler("xyz", [180, 0, 30], degrees=True)
    assert (turned.inv() * wanted).magnitude() < 1e-7
