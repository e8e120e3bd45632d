"""Programs of languages with names, records, modal tools and frames, made by hand."""

import math

import numpy as np
import pytest

from olp.core.source import decode
from olp.fluent import Program
from olp.ir.expressions import (
    Binary,
    CallValue,
    Compare,
    FrameRef,
    Function,
    Item,
    Member,
    Named,
    NamedArgument,
    Number,
    PositionLiteral,
    Quantity,
    RecordLiteral,
    Signal,
    SignalState,
    SystemValue,
    Text,
)
from olp.ir.points import PointTable
from olp.ir.program import (
    Acceleration,
    AccelerationUnit,
    Assign,
    Blend,
    BlendKind,
    Break,
    Call,
    Continue,
    Declare,
    Dwell,
    EndIf,
    EndWhile,
    For,
    If,
    Jump,
    Label,
    Move,
    Next,
    Parameter,
    Path,
    Repeat,
    Return,
    Routine,
    SetAcceleration,
    SetFrame,
    SetOverride,
    SetSpeed,
    SetTool,
    ShiftOff,
    ShiftOn,
    Speed,
    SpeedUnit,
    Until,
    Wait,
    While,
)
from olp.robots.geometry import Pose
from olp.runtime.plan import PATHS, BlendCode, StepKind

NAN = math.nan
STOP = Blend(BlendKind.RADIUS, Quantity(Number(0), 1.0))


def pose(x, y, z, rx=0.0, ry=0.0, rz=0.0):
    """A pose literal [mm, deg]."""
    lengths = tuple(v / 1000 for v in (x, y, z))
    return PositionLiteral("pose", lengths + tuple(math.radians(v) for v in (rx, ry, rz)))


def plan_of(*body, routines=(), data=(), vendor="krl", robot=None, **routine):
    """The plan of a program with the statements `body`, in any language."""
    source = decode(b"\n" * 50)
    main = Routine("MAIN", 1, tuple(body), PointTable(), **routine)
    program = Program(vendor, source, (main, *routines), data=tuple(data))
    plan = program.plan(robot=robot)
    assert not [d for d in plan.diagnostics if d.is_error], plan.diagnostics
    return plan


def line(target, mm_s=250, **more):
    more.setdefault("blend", STOP)
    return Move(1, Path.LINEAR, (target,), Speed(SpeedUnit.TRAVEL, Quantity(Number(mm_s), 1e-3)), **more)


def where(plan):
    """(n, 3) [mm] of the targets of all moves."""
    return plan.positions.position[plan.moves.target] * 1000


def waits(plan):
    return plan.durations[plan.row[plan.kind == StepKind.WAIT]].tolist()


def test_a_named_point_is_moved_to_in_the_frame_and_with_the_tool_that_hold():
    frame, tool = pose(800, 100, 50, 0, 0, 90), pose(0, 0, 120)
    plan = plan_of(
        SetFrame(1, frame),
        SetTool(1, tool),
        line(Named("P1")),
        data=[Declare(0, "P1", "position", pose(10, 20, 30, 180))],
    )
    assert where(plan)[0] == pytest.approx([800 - 20, 100 + 10, 50 + 30])


def test_a_move_names_its_own_frame_without_changing_the_modal_one():
    plan = plan_of(
        SetFrame(1, pose(100, 0, 0)),
        line(pose(1, 2, 3), frame=pose(0, 500, 0)),
        line(pose(1, 2, 3)),
        line(pose(1, 2, 3), frame=FrameRef("base")),
    )
    assert where(plan) == pytest.approx(np.array([[1, 502, 3], [101, 2, 3], [1, 2, 3]]))


def test_a_work_object_is_its_user_frame_times_its_object_frame():
    work = RecordLiteral(
        "wobjdata",
        (
            ("robhold", SignalState(False)),
            ("uframe", pose(100, 0, 0, 0, 0, 90)),
            ("oframe", pose(10, 0, 0)),
        ),
    )
    plan = plan_of(line(pose(1, 2, 3), frame=Named("wobj1")), data=[Declare(0, "wobj1", "frame", work)])
    assert where(plan)[0] == pytest.approx([98, 11, 3])


def test_components_that_are_not_written_keep_their_value():
    plan = plan_of(
        line(pose(100, 200, 300, 180)),
        line(PositionLiteral("pose", (NAN, NAN, 0.5, NAN, NAN, NAN))),
    )
    assert where(plan)[1] == pytest.approx([100, 200, 500])
    assert plan.moves.angle[1] == pytest.approx(0.0, abs=1e-9)


def test_relative_moves_go_along_the_frame_or_along_the_tool():
    start = pose(100, 0, 0, 0, 90, 0)
    step = PositionLiteral("pose", (0.01, NAN, NAN, NAN, NAN, NAN))
    plan = plan_of(
        line(start),
        line(step, relative=FrameRef("own")),
        line(start),
        line(step, relative=FrameRef("tool")),
    )
    assert where(plan)[1] == pytest.approx([110, 0, 0])
    assert where(plan)[3] == pytest.approx([100, 0, -10])


def test_pose_functions_agree_with_products_of_matrices():
    base = pose(100, 50, 20, 10, 20, 30)
    mm = [Function("pose-offset", (base, Number(1), Number(2), Number(3)))]
    mm.append(
        Function(
            "pose-relative-tool", (base, Number(1), Number(2), Number(3), Number(0), Number(0), Number(5))
        )
    )
    mm.append(Function("pose-product", (base, pose(1, 2, 3, 0, 0, 5))))
    plan = plan_of(*(line(target) for target in mm))
    matrix = Pose.from_xyz_angles(base.values)
    turned = matrix.position * 1000 + matrix.rotation @ [1, 2, 3]
    assert where(plan)[0] == pytest.approx([101, 52, 23])
    assert where(plan)[1] == pytest.approx(turned)
    assert where(plan)[2] == pytest.approx(turned)
    first, second = plan.positions.quaternion[plan.moves.target[1:]]
    assert abs(first @ second) == pytest.approx(1.0)


def test_an_arc_of_one_statement_passes_its_via_point():
    middle, end = pose(100, 100, 0), pose(200, 0, 0)
    arc = Move(
        1, Path.CIRCULAR, (end,), Speed(SpeedUnit.TRAVEL, Quantity(Number(0.1), 1.0)), STOP, via=middle
    )
    plan = plan_of(line(pose(0, 0, 0)), arc, line(pose(200, 0, 50)))
    assert plan.moves.length[1] == pytest.approx(math.pi * 0.1)
    assert where(plan)[1] == pytest.approx([200, 0, 0])
    assert plan.moves.length[2] == pytest.approx(0.05)


def test_an_arc_with_an_angle_ends_where_the_angle_does():
    arc = Move(
        1,
        Path.CIRCULAR,
        (pose(200, 0, 0),),
        Speed(SpeedUnit.TRAVEL, Quantity(Number(0.1), 1.0)),
        STOP,
        via=pose(100, 100, 0),
        arc=Quantity(Number(90), math.pi / 180),
    )
    plan = plan_of(line(pose(0, 0, 0)), arc, line(pose(100, 100, 70)))
    assert where(plan)[1] == pytest.approx([100, 100, 0])
    assert plan.moves.length[1] == pytest.approx(math.pi * 0.05)
    assert plan.moves.length[2] == pytest.approx(0.07)


def test_arrays_records_and_components_are_read_and_written():
    points = RecordLiteral("array", (("", pose(1, 1, 1)), ("", pose(2, 2, 2))))
    plan = plan_of(
        Assign(1, Member(Item(Named("p"), (Number(2),)), "z"), Number(77)),
        Assign(1, Named("q"), Item(Named("p"), (Number(2),))),
        Assign(1, Member(Named("q"), "x"), Binary("+", Member(Named("q"), "x"), Number(0.5))),
        line(Item(Named("p"), (Number(1),))),
        line(Named("q")),
        line(Item(Named("p"), (Number(2),))),
        data=[Declare(0, "p", "position", points, (Number(2),))],
    )
    assert where(plan) == pytest.approx(np.array([[1, 1, 1], [2.5, 2, 77], [2, 2, 77]]))


def test_loops_that_repeat_leave_and_go_on():
    i = Named("i")
    plan = plan_of(
        Declare(1, "i", "integer", Number(0)),
        Repeat(2),
        Assign(3, i, Binary("+", i, Number(1))),
        If(4, Compare("=", i, Number(2))),
        Continue(5),
        EndIf(6),
        Dwell(7, Quantity(i, 1.0)),
        Until(8, Compare(">=", i, Number(4))),
        While(9, SignalState(True)),
        Assign(10, i, Binary("-", i, Number(1))),
        If(11, Compare("<", i, Number(1))),
        Break(12),
        EndIf(13),
        Dwell(14, Quantity(i, 0.1)),
        EndWhile(15),
        For(16, Named("k"), Number(1), Number(2)),
        Dwell(17, Quantity(Named("k"), 10.0)),
        Next(18, None),
    )
    assert waits(plan) == pytest.approx([1, 3, 4, 0.3, 0.2, 0.1, 10, 20])


def test_routines_take_arguments_by_value_by_name_and_by_reference_and_return_values():
    double = Routine(
        "DOUBLE",
        20,
        (Return(21, Binary("*", Named("x"), Number(2))),),
        PointTable(),
        parameters=(Parameter("x", "integer"),),
        returns="integer",
    )
    bump = Routine(
        "BUMP",
        30,
        (Assign(31, Named("v"), Binary("+", Named("v"), Named("by"))),),
        PointTable(),
        parameters=(
            Parameter("v", "integer", by_reference=True),
            Parameter("by", "integer", default=Number(5)),
        ),
    )
    n = Named("n")
    plan = plan_of(
        Declare(1, "n", "integer", Number(3)),
        Dwell(2, Quantity(CallValue("double", (n,)), 1.0)),
        Call(3, "bump", (n,)),
        Dwell(4, Quantity(n, 1.0)),
        Call(5, "bump", (n, NamedArgument("by", Number(10)))),
        Dwell(6, Quantity(n, 1.0)),
        Call(7, "double", (n,), result=n),
        Dwell(8, Quantity(n, 1.0)),
        routines=(double, bump),
    )
    assert waits(plan) == [6, 8, 18, 36]


def test_a_routine_without_an_end_inside_an_expression_stops_at_the_limit():
    forever = Routine("F", 20, (Return(21, CallValue("F", ())),), PointTable(), returns="integer")
    source = decode(b"\n" * 50)
    main = Routine("MAIN", 1, (Dwell(1, Quantity(CallValue("F", ()), 1.0)),), PointTable())
    plan = Program("krl", source, (main, forever)).plan()
    assert [d.code for d in plan.diagnostics] == ["I106"]


def test_speeds_of_the_leading_axis_and_times_are_kept_and_timed():
    joints = [PositionLiteral("joint", tuple(math.radians(v) for v in values)) for values in
              ((0, 0, 0, 0, 0, 0), (90, 30, 0, 0, 0, 0), (0, 0, 0, 0, 0, 0))]  # fmt: skip
    slow = Acceleration(AccelerationUnit.AXIS, Quantity(Number(1), 1.0))
    moves = [
        Move(1, Path.JOINT, (joints[0],), Speed(SpeedUnit.AXIS, Quantity(Number(0.5), 1.0)), STOP),
        Move(2, Path.JOINT, (joints[1],), Speed(SpeedUnit.AXIS, Quantity(Number(0.5), 1.0)), STOP, rate=slow),
        Move(3, Path.JOINT, (joints[2],), Speed(SpeedUnit.TIME, Quantity(Number(4), 1.0)), STOP),
    ]
    plan = plan_of(*moves, vendor="urscript", robot="yaskawa/gp25")
    assert plan.moves.axis_speed[1] == 0.5
    table = plan.time(model="constant")
    stop = table["duration_s"][2] - 4.0  # what an exact stop costs, the same for all
    assert table["duration_s"][1] - stop == pytest.approx(math.radians(90) / 0.5 + 0.5, abs=1e-6)


def test_accelerations_and_overrides_hold_for_what_follows():
    target = pose(500, 0, 0)
    rate = Acceleration(AccelerationUnit.TRAVEL, Quantity(Number(1.5), 1.0))
    plan = plan_of(
        line(pose(0, 0, 0)),
        SetAcceleration(1, (rate,)),
        SetOverride(1, Quantity(Number(50), 0.01)),
        line(target, 1000),
        SetOverride(1, Quantity(Number(100), 0.01)),
        SetSpeed(1, (Speed(SpeedUnit.TRAVEL, Quantity(Number(0.25), 1.0)),), turn=Quantity(Number(1), 1.0)),
        Move(1, Path.LINEAR, (pose(0, 0, 0, 0, 0, 50),), None, STOP),
    )
    assert plan.moves.travel.tolist() == [0.25, 0.5, 0.25]
    assert plan.moves.rate.tolist() == pytest.approx([NAN, 1.5, 1.5], nan_ok=True)
    assert plan.moves.turn.tolist() == pytest.approx([NAN, NAN, 1.0], nan_ok=True)


@pytest.mark.parametrize(
    ("vendor", "blend", "code", "size"),
    [
        ("krl", Blend(BlendKind.RADIUS, Quantity(Number(10), 1e-3)), BlendCode.ZONE, 0.01),
        ("krl", Blend(BlendKind.RADIUS), BlendCode.ZONE, 0.003),
        ("krl", Blend(BlendKind.SHARE, Quantity(Number(50), 0.01)), BlendCode.ZONE, 0.125),
        ("tp", Blend(BlendKind.SPEED, Quantity(Number(50), 0.01)), BlendCode.ZONE, 0.5),
        ("tp", Blend(BlendKind.SPEED, Quantity(Number(0), 0.01)), BlendCode.ZONE, 0.0),
        ("tp", Blend(BlendKind.RADIUS, Quantity(Number(20), 1e-3)), BlendCode.RADIUS, 0.02),
        ("urscript", Blend(BlendKind.RADIUS, Quantity(Number(0.02), 1.0)), BlendCode.ZONE, 0.02),
    ],
)
def test_blends_become_what_the_makers_law_takes(vendor, blend, code, size):
    plan = plan_of(
        line(pose(0, 0, 0)), line(pose(500, 0, 0), blend=blend), line(pose(500, 500, 0)), vendor=vendor
    )
    assert plan.moves.blend_code[1] == code
    assert plan.moves.blend[1] == pytest.approx(size)
    assert np.isfinite(plan.time()["duration_s"]).all()


def test_a_wait_for_a_named_signal_is_assumed_and_told():
    plan = plan_of(Wait(1, Compare("=", Signal("in", Text("diReady")), SignalState(True))), vendor="krl")
    assert any("diready" in a.says for a in plan.assumptions)


def test_what_nothing_defines_is_an_error_with_its_name():
    source = decode(b"\n" * 5)
    plan = Program("krl", source, (Routine("MAIN", 1, (line(Named("XP9")),), PointTable()),)).plan()
    assert [(d.code, "XP9" in d.message) for d in plan.diagnostics] == [("I209", True)]


def test_joint_moves_at_a_tool_speed_take_the_time_of_the_path():
    joints = [PositionLiteral("joint", tuple(math.radians(v) for v in values)) for values in
              ((0, 0, 0, 0, -30, 0), (40, 10, 5, 0, -30, 0))]  # fmt: skip
    moves = [
        Move(1, Path.JOINT, (p,), Speed(SpeedUnit.TRAVEL, Quantity(Number(200), 1e-3)), STOP) for p in joints
    ]
    plan = plan_of(*moves, vendor="rapid", robot="yaskawa/gp25")
    assert plan.moves.travel[1] == 0.2
    assert PATHS[plan.moves.path[1]] is Path.JOINT
    seconds = plan.time(model="constant")["duration_s"][1]
    assert seconds == pytest.approx(plan.moves.length[1] / 0.2, rel=0.5)
    assert seconds > plan.moves.length[1] / 0.2


def test_a_program_displacement_is_one_more_frame_inside_the_moves_own():
    plan = plan_of(
        SetFrame(1, pose(1000, 0, 0, 0, 0, 90)),
        ShiftOn(1, pose(10, 0, 0, 0, 0, 90)),
        line(pose(1, 0, 0)),
        ShiftOff(1),
        line(pose(1, 0, 0)),
        vendor="rapid",
    )
    assert where(plan) == pytest.approx(np.array([[999, 10, 0], [1000, 1, 0]]))


def test_a_first_move_to_where_the_arm_stands_goes_nowhere():
    plan = plan_of(line(SystemValue("current-pose")), line(pose(1, 2, 3)))
    assert len(plan.moves) == 1
    assert any("nowhere" in a.says for a in plan.assumptions)


def test_a_way_back_inside_a_condition_is_a_loop_that_ends():
    i = Named("i")
    plan = plan_of(
        Declare(1, "i", "integer", Number(0)),
        Label(2, "AGAIN"),
        Assign(3, i, Binary("+", i, Number(1))),
        line(pose(1, 2, 3)),
        If(4, Compare("<", i, Number(5))),
        Jump(5, "AGAIN"),
        EndIf(6),
        Dwell(7, Quantity(i, 1.0)),
    )
    assert waits(plan) == [5]
    assert len(plan.moves) == 5


def test_a_loop_is_not_left_where_no_label_is():
    """It ran as many statements as a run may take."""
    plan = plan_of(
        Label(1, "AGAIN"),
        Dwell(2, Quantity(Number(1), 0.1)),
        Jump(3, "NOWHERE", Compare(">", Named("i"), Number(5))),
        Jump(4, "AGAIN"),
    )
    assert "has no end" in plan.stop_reason
    assert waits(plan) == [0.1]


def test_an_element_of_whole_numbers_rounds_as_a_variable_of_them_does():
    plan = plan_of(
        Assign(1, Item(Named("n"), (Number(1),)), Number(2.6)),
        line(pose(0, 0, 0)),
        Assign(1, Member(Named("q"), "x"), Item(Named("n"), (Number(1),))),
        line(Named("q")),
        data=[
            Declare(0, "n", "integer", None, (Number(2),)),
            Declare(0, "q", "position", pose(0, 0, 0)),
        ],
    )
    assert where(plan)[1] == pytest.approx([3, 0, 0])
