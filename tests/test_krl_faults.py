"""KRL written for other languages' programs: turns about the right axes, waits that tell whether they gave up."""

import numpy as np
import pytest
from krl_programs import source
from scipy.spatial.transform import Rotation

from olp.core.source import decode
from olp.fluent import Program, fluent
from olp.ir.expressions import (
    Compare,
    FrameRef,
    Function,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    Signal,
    SignalState,
)
from olp.ir.points import PointTable
from olp.ir.program import Blend, BlendKind, Declare, Move, Path, Routine, Speed, SpeedUnit, Wait
from olp.languages.templating import shipped
from olp.languages.vendors.krl.reader import read_program
from olp.languages.vendors.krl.writer import write
from olp.robots.robot import load_robot

PLACE = PositionLiteral("pose", (0.9, 0.1, 0.5, 3.0, 0.1, 0.2))


def text(*body, data=()):
    """A program of another language as the KRL writer spells it."""
    made = Program(
        "rapid",
        decode(b"\n" * 30, "job.mod"),
        (Routine("work", 1, body, PointTable()),),
        data=data,
        main="work",
    )
    values, problems = write(made, "", pair=False)
    assert not [d.render() for d in problems]
    return shipped("krl").render(values)


def to(target):
    speed = Speed(SpeedUnit.TRAVEL, Quantity(Number(0.2), 1.0))
    stop = Blend(BlendKind.RADIUS, Quantity(Number(0), 1.0))
    return Move(
        1, Path.LINEAR, (target,), speed, stop, tool=FrameRef("tool", Number(0)), frame=FrameRef("base")
    )


def reached(written):
    """Position and rotation of the last move when the text is read and run."""
    program = fluent(read_program(source(written, "work.src")))
    assert not [d.render() for d in program.diagnostics if d.is_error]
    plan = program.plan(robot=load_robot("yaskawa/gp25"))
    row = int(plan.moves.target[-1])
    w, x, y, z = plan.positions.quaternion[row]
    return plan.positions.position[row], Rotation.from_quat([x, y, z, w])


def test_a_computed_pose_turns_about_the_axes_that_its_angles_name():
    angles = (170, 5, 20)
    height = Declare(0, "height", "real", Number(500.0), shared=True)
    target = Function("pose-angles", (Number(900), Number(100), Named("height"), *map(Number, angles)))
    position, turned = reached(text(to(target), data=(height,)))
    np.testing.assert_allclose(position, [0.9, 0.1, 0.5], atol=1e-6)
    assert (turned.inv() * Rotation.from_euler("xyz", angles, degrees=True)).magnitude() < 1e-6


@pytest.mark.parametrize("turns", [(10, 0, 0), (0, 10, 0), (0, 0, 10), (10, 0, 20), (10, 20, 30)])
def test_a_shift_along_the_tool_turns_about_x_then_y_then_z(turns):
    target = Function("pose-relative-tool", (PLACE, Number(5), Number(-7), Number(30), *map(Number, turns)))
    position, turned = reached(text(to(target)))
    before = Rotation.from_euler("xyz", PLACE.values[3:])
    np.testing.assert_allclose(position, PLACE.values[:3] + before.apply([0.005, -0.007, 0.03]), atol=1e-6)
    wanted = before * Rotation.from_euler("XYZ", turns, degrees=True)
    assert (turned.inv() * wanted).magnitude() < 1e-6


def test_a_wait_that_gave_up_says_so():
    condition = Compare("=", Signal("in", Number(3)), SignalState(True))
    rows = [row.strip() for row in text(Wait(1, condition, Quantity(Number(2.5), 1.0))).splitlines()]
    assert "WHILE NOT ($IN[3]==TRUE) AND (WAITED<2.5)" in rows
    assert "TIMED_OUT=NOT ($IN[3]==TRUE)" in rows
