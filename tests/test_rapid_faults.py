"""Data of RAPID that is written where it is used: zones, turns, displacements."""

import numpy as np
import pytest
from rapid_modules import NO_AXES, module, move, read, statement

from olp.core.source import decode
from olp.ir.expressions import FrameRef, Function, Number, PositionLiteral, Quantity
from olp.ir.points import PointTable
from olp.ir.program import Assign, Blend, BlendKind, Move, Path, Program, Routine, Speed, SpeedUnit
from olp.languages.templating import shipped
from olp.languages.vendors.rapid.writer import write
from olp.robots.robot import load_robot

TURNED = "[0.70710678118,0,0,0.70710678118]"  # 90 deg about Z


@pytest.mark.parametrize(
    ("zone", "radius"), [("[TRUE,20,30,30,3,30,3]", 0.0), ("[FALSE,20,30,40,3,30,3]", 0.02)]
)
def test_a_zone_in_the_move_is_a_stop_where_its_first_value_says_so(zone, radius):
    found = move(f"MoveL p1,v100,{zone},tool0;")
    assert found.blend is not None
    assert found.blend.kind is BlendKind.RADIUS
    assert found.blend.value is not None
    assert found.blend.value.literal == pytest.approx(radius)


@pytest.mark.parametrize(
    ("zone", "radius"), [("[TRUE,20,30,30,3,30,3]", 0.0), ("[FALSE,20,30,40,3,30,3]", 0.02)]
)
def test_a_zone_of_ones_own_is_a_stop_where_its_first_value_says_so(zone, radius):
    found = move("MoveL p1,v100,zMine,tool0;", data=f"CONST zonedata zMine:={zone};")
    assert found.blend is not None
    assert found.blend.value is not None
    assert found.blend.value.literal == pytest.approx(radius)


def test_a_turn_that_is_assigned_is_in_degrees():
    place = f"[[100,200,300],[1,0,0,0],[0,0,0,0],{NO_AXES}]"
    found = statement(f"p1.rot:={TURNED};", data=f"VAR robtarget p1:={place};")
    assert isinstance(found, Assign)
    assert isinstance(found.value, Function)
    angles = [one.value for one in found.value.arguments[3:6]]
    np.testing.assert_allclose(angles, [0.0, 0.0, 90.0], atol=1e-6)


def test_a_displacement_leads_from_the_programmed_point_to_the_one_that_is_reached():
    down = "[0,1,0,0]"
    turned = "[0,0.92387953251,0.38268343236,0]"  # 45 deg about Z, then down
    data = [
        f"CONST robtarget p1:=[[900,100,500],{down},[0,0,0,0],{NO_AXES}];",
        f"CONST robtarget p2:=[[950,150,520],{turned},[0,0,0,0],{NO_AXES}];",
        f"CONST robtarget p3:=[[900,200,500],{down},[0,0,0,0],{NO_AXES}];",
    ]
    rows = ["PDispOn \\Rot \\ExeP:=p2,p1,tool0;", "MoveL p1,v100,fine,tool0;", "MoveL p3,v100,fine,tool0;"]
    plan = read(module(rows, data)).plan(robot=load_robot("yaskawa/gp25"))
    first, second = (step for step in plan.steps() if hasattr(step, "target"))
    np.testing.assert_allclose(first.target, [0.95, 0.15, 0.52], atol=1e-6)
    # 100 mm along y, turned with the displacement by 45 deg.
    half = 0.1 * np.sqrt(0.5)
    np.testing.assert_allclose(second.target, [0.95 - half, 0.15 + half, 0.52], atol=1e-6)


# --- written for another language's program -------------------------------------------------------------


@pytest.mark.parametrize(
    ("travel", "name", "value"),
    [(0.25, "v250", 250.0), (0.1, "v100", 100.0), (0.1234, "v123_4", 123.4), (2.75, "v2750", 2750.0)],
)
def test_a_speed_in_metres_per_second_is_written_in_millimetres_per_second(travel, name, value):
    place = PositionLiteral("pose", (0.9, 0.1, 0.5, 3.0, 0.1, 0.2))
    speed = Speed(SpeedUnit.TRAVEL, Quantity(Number(travel), 1.0))
    blend = Blend(BlendKind.RADIUS, Quantity(Number(0), 1.0))
    moved = Move(
        1, Path.LINEAR, (place,), speed, blend, tool=FrameRef("tool", Number(0)), frame=FrameRef("base")
    )
    program = Program(
        "krl", decode(b"\n" * 20, "job.src"), (Routine("work", 1, (moved,), PointTable()),), main="work"
    )
    values, problems = write(program, "")
    assert not problems
    text = shipped("rapid").render(values)
    assert f",{name},fine,tool0;" in text
    (again,) = (s for s in read(text).statements() if isinstance(s, Move))
    assert again.speed.value.literal == pytest.approx(value / 1000)
