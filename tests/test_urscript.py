"""URScript as it is read: shapes of the manual, units, names, and what PolyScope exports."""

from __future__ import annotations

import math
from pathlib import Path as File

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import olp
from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.expressions import (
    Binary,
    CallValue,
    Compare,
    Expression,
    FrameRef,
    Function,
    Item,
    Logic,
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
    Unary,
)
from olp.ir.program import (
    Acceleration,
    AccelerationUnit,
    Assign,
    Blend,
    BlendKind,
    Break,
    Call,
    Comment,
    Continue,
    Declare,
    Dwell,
    Else,
    ElseIf,
    EndIf,
    If,
    LineKind,
    Message,
    Move,
    Path,
    Pause,
    Process,
    Program,
    Return,
    SetOutput,
    SetTool,
    Speed,
    SpeedUnit,
    StartTask,
    Wait,
    WaitTask,
    While,
)
from olp.languages import vendor
from olp.languages.vendor import recognise
from olp.languages.vendors.urscript import builtins
from olp.languages.vendors.urscript.grammar import instruction_parser
from olp.languages.vendors.urscript.lines import quick
from olp.languages.vendors.urscript.syntax import angles_from_vector, vector_from_angles
from olp.robots.geometry import rotation_from_angles
from olp.runtime import places
from olp.runtime.interpreter import run
from olp.runtime.memory import PositionValue
from olp.runtime.plan import Plan
from olp.runtime.state import Machine

DEG = math.pi / 180.0
SAMPLES = File(__file__).resolve().parent.parent / "samples" / "urscript"
SCRIPTS = sorted(path for path in SAMPLES.rglob("*.script") if path.parent.name != "broken")


def read(text: str, path: str = "a.script") -> Program:
    return read_source(decode(text.encode(), path), vendor="urscript")


def whole(*lines: str) -> Program:
    """The lines as the body of a program, which must have no error."""
    program = read("\n".join(["def main_program():", *(f"  {line}" for line in lines), "end", ""]))
    problems = [d.render() for d in program.diagnostics if d.is_error]
    assert not problems, "\n".join(problems)
    return program


def body(*lines: str) -> list[object]:
    return list(whole(*lines).routines[0].body)


def one(line: str) -> object:
    (statement,) = body(line)
    return statement


def move(line: str) -> Move:
    found = one(line)
    assert isinstance(found, Move)
    return found


def value(text: str, *before: str) -> Expression:
    """What an expression means, behind some assignments."""
    last = body(*before, f"result = [{text}, 0]")[-1]
    assert isinstance(last, Declare)
    assert isinstance(last.value, RecordLiteral)
    return last.value.members[0][1]


# --- moves ----------------------------------------------------------------------------------------------


def test_a_joint_move_without_arguments_has_those_of_the_manual() -> None:
    found = move("movej([0.1, -0.2, 0.3, -0.4, 0.5, -0.6])")
    assert found.path is Path.JOINT
    assert found.targets == (PositionLiteral("joint", (0.1, -0.2, 0.3, -0.4, 0.5, -0.6)),)
    assert found.speed == Speed(SpeedUnit.AXIS, Quantity(Number(1.05), 1.0))
    assert found.rate == Acceleration(AccelerationUnit.AXIS, Quantity(Number(1.4), 1.0))
    assert found.blend == Blend(BlendKind.RADIUS, Quantity(Number(0), 1.0))
    assert found.frame == FrameRef("base")


def test_a_line_without_arguments_has_those_of_the_manual() -> None:
    found = move("movel(p[0.4, 0.1, 0.2, 0, 3.1, 0])")
    assert found.path is Path.LINEAR
    assert found.speed == Speed(SpeedUnit.TRAVEL, Quantity(Number(0.25), 1.0))
    assert found.rate == Acceleration(AccelerationUnit.TRAVEL, Quantity(Number(1.2), 1.0))


@pytest.mark.parametrize(
    "arguments",
    [
        "a=1.3, v=0.31, r=0.012",
        "1.3, 0.31, 0, 0.012",
        "1.3, v=0.31, r=0.012",
        "r=0.012, v=0.31, a=1.3",
        "1.3,v = 0.31,t=0,r =0.012",
    ],
)
def test_arguments_stand_by_place_and_by_name(arguments: str) -> None:
    found = move(f"movel(p[0.4, 0.1, 0.2, 0, 3.1, 0], {arguments})")
    assert found.speed is not None
    assert found.rate is not None
    assert found.blend is not None
    assert found.blend.value is not None
    assert found.speed.value.literal == 0.31
    assert found.rate.value.literal == 1.3
    assert found.blend == Blend(BlendKind.RADIUS, Quantity(Number(0.012), 1.0))
    assert found.other == ()


def test_the_target_may_be_given_by_its_name_behind_others() -> None:
    assert move("movel(v=0.3, pose=p[1, 2, 3, 0, 0, 0])") == move("movel(p[1, 2, 3, 0, 0, 0], v=0.3)")
    assert move("movej(a=1, q=[1, 2, 3, 4, 5, 6])") == move("movej([1, 2, 3, 4, 5, 6], a=1)")


def test_a_time_overrides_the_speed_which_is_kept() -> None:
    found = move("movej([0, 0, 0, 0, 0, 0.1], a=2, v=1.5, t=0.75)")
    assert found.speed == Speed(SpeedUnit.TIME, Quantity(Number(0.75), 1.0))
    assert found.other == (("v", Number(1.5)),)
    assert move("movel(p[1, 0, 0, 0, 0, 0], t=2)").other == ()
    assert move("movej([0, 0, 0, 0, 0, 0.1], 2, 1.5, 0, 0.01)").speed == Speed(
        SpeedUnit.AXIS, Quantity(Number(1.5), 1.0)
    )


def test_a_time_that_is_always_nothing_is_kept_beside_the_speed_that_counts() -> None:
    found = body("t_fun = 0", "movel(p[1, 0, 0, 0, 0, 0], 1.2, v=0.4, t=t_fun)")[-1]
    assert isinstance(found, Move)
    assert found.speed == Speed(SpeedUnit.TRAVEL, Quantity(Number(0.4), 1.0))
    assert found.other == ((builtins.NO_TIME, Named("t_fun")),)


def test_an_arc_has_both_its_points_and_its_mode() -> None:
    found = move("movec(p[1, 0, 0, 0, 0, 0], p[1, 1, 0, 0, 0, 0], a=1, v=0.2, r=0.05, mode=1)")
    assert found.path is Path.CIRCULAR
    assert found.via == PositionLiteral("pose", (1.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert found.targets == (PositionLiteral("pose", (1.0, 1.0, 0.0, 0.0, 0.0, 0.0)),)
    assert found.other == (("mode", Number(1)),)
    assert move("movec(p[1,0,0,0,0,0], p[1,1,0,0,0,0], 1, 0.2, 0.05, 0)").other == ()


def test_a_process_move_is_a_line_that_says_so() -> None:
    found = move("movep(p[1, 0, 0, 0, 0, 0], a=1.2, v=0.1, r=0.02)")
    assert found.path is Path.LINEAR
    assert found.other == (("process", SignalState(True)),)


def test_optimal_moves_have_shares_of_what_the_robot_can_do() -> None:
    found = move("optimovej([0, 0, 0, 0, 0, 1], a=0.5, v=0.6, r=0.01)")
    assert found.path is Path.JOINT
    assert found.speed == Speed(SpeedUnit.FRACTION, Quantity(Number(0.6), 1.0))
    assert found.acceleration == Quantity(Number(0.5), 1.0)
    assert found.rate is None
    assert move("optimovel(p[1, 0, 0, 0, 0, 0])").speed == Speed(
        SpeedUnit.FRACTION, Quantity(Number(0.3), 1.0)
    )


def test_inverse_kinematics_keep_the_pose_and_the_joints_near_it() -> None:
    found = move("movej(get_inverse_kin(p[1, 0, 0, 0, 0, 0], qnear=[1, 2, 3, 4, 5, 6]), a=1.4, v=1.0)")
    near = PositionLiteral("joint", (1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    assert found.targets == (
        Function("inverse", (PositionLiteral("pose", (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)), near)),
    )


def test_a_feature_is_the_frame_of_the_move_and_a_waypoint_is_not() -> None:
    in_feature = body("plane = p[1, 2, 3, 0, 0, 1]", "movel(pose_trans(plane, p[0.1, 0, 0, 0, 0, 0]))")[-1]
    assert isinstance(in_feature, Move)
    assert in_feature.frame == Named("plane")
    assert in_feature.targets == (PositionLiteral("pose", (0.1, 0.0, 0.0, 0.0, 0.0, 0.0)),)
    for name in ("pick_p", "pick"):
        text = f"movel(pose_trans({name}, p[0, 0, -0.1, 0, 0, 0]))"
        _, _, approach = body(f"{name} = p[1, 2, 3, 0, 0, 1]", f"movel({name})", text)
        assert isinstance(approach, Move)
        assert approach.frame == FrameRef("base")
        assert isinstance(approach.targets[0], Function)
        assert approach.targets[0].name == "pose-product"


def test_both_points_of_an_arc_stand_in_one_frame_or_in_the_base() -> None:
    text = "movec(pose_trans(a, p[1, 0, 0, 0, 0, 0]), pose_trans({}, p[1, 1, 0, 0, 0, 0]))"
    one_frame = body("a = p[0, 0, 1, 0, 0, 0]", text.format("a"))[-1]
    two_frames = body("a = p[0, 0, 1, 0, 0, 0]", "b = a", text.format("b"))[-1]
    assert isinstance(one_frame, Move)
    assert isinstance(two_frames, Move)
    assert one_frame.frame == Named("a")
    assert two_frames.frame == FrameRef("base")


def test_a_function_of_the_program_comes_before_a_move_of_the_manual() -> None:
    program = read("def prog():\n  def movej(x):\n    sleep(x)\n  end\n  movej(2)\nend\n")
    assert isinstance(program.routines[0].body[0], Call)


# --- positions ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "vector",
    [
        (0.3, -1.2, 0.7),
        (2.2214414690791831, 2.2214414690791831, 0.0),
        (0.0, 3.141592653589793, 0.0),
        (1e-9, -2e-9, 3e-9),
        (0.0, 1.5707963267948966, 0.0),
        (4.0, -3.0, 1.0),
        (-1.2091995761561452, 1.2091995761561452, -1.2091995761561452),
    ],
)
def test_rotation_vectors_turn_as_scipy_says(vector: tuple[float, float, float]) -> None:
    expected = Rotation.from_rotvec(vector).as_matrix()
    angles = angles_from_vector(*vector)
    np.testing.assert_allclose(rotation_from_angles(angles), expected, atol=1e-12)
    back = Rotation.from_rotvec(vector_from_angles(*angles)).as_matrix()
    np.testing.assert_allclose(back, expected, atol=1e-12)


def test_angles_of_a_pose_are_about_z_y_and_x_in_this_order() -> None:
    found = move("movel(p[0.1, 0.2, 0.3, 0.4, -0.5, 0.6])").targets[0]
    assert isinstance(found, PositionLiteral)
    z, y, x = Rotation.from_rotvec((0.4, -0.5, 0.6)).as_euler("ZYX")
    np.testing.assert_allclose(found.values, (0.1, 0.2, 0.3, x, y, z), atol=1e-12)


def test_a_thousand_random_rotation_vectors_agree_with_scipy() -> None:
    random = np.random.default_rng(20)
    vectors = random.normal(size=(1000, 3)) * random.uniform(0.0, 2.5, (1000, 1))
    ours = np.array([angles_from_vector(*map(float, vector)) for vector in vectors])
    np.testing.assert_allclose(
        rotation_from_angles(ours), Rotation.from_rotvec(vectors).as_matrix(), atol=1e-12
    )


def test_a_pose_of_computed_numbers_stays_computed_and_one_of_constants_does_not() -> None:
    assert move("movel(p[0.5/2, -(0.1+0.2), 1*2, d2r(90), 0, 0])").targets[0] == PositionLiteral(
        "pose", (0.25, -(0.1 + 0.2), 2.0, 90 * DEG, 0.0, 0.0)
    )
    computed = move("movel(p[x, 0, 0.1, 0, 0, 0])").targets[0]
    assert isinstance(computed, Function)
    assert computed.name == "pose-vector"
    assert computed.arguments[0] == Named("x")


def test_six_numbers_are_joints_where_a_move_takes_them_and_a_list_elsewhere() -> None:
    program = whole(
        "home = [0, -1, 1, 0, 1, 0]",
        "limits = [1, 2, 3, 4, 5, 6]",
        "start_q = [0.5, 0, 0, 0, 0, 0]",
        "movej(home)",
    )
    found = {d.name: d for d in program.routines[0].body if isinstance(d, Declare)}
    assert found["home"].type == "joints"
    assert found["home"].value == PositionLiteral("joint", (0.0, -1.0, 1.0, 0.0, 1.0, 0.0))
    assert found["start_q"].type == "joints"
    assert isinstance(found["limits"].value, RecordLiteral)
    assert found["limits"].sizes == (Number(6),)


def test_a_list_passed_to_a_function_that_moves_there_is_joints() -> None:
    text = """\
def prog():
  def go(q):
    movej(q)
  end
  park = [0, 1, 2, 3, 4, 5]
  go(park)
  go([5, 4, 3, 2, 1, 0])
end
"""
    program = read(text)
    declared, _, second = program.routines[0].body
    assert isinstance(declared, Declare)
    assert isinstance(second, Call)
    assert isinstance(declared.value, PositionLiteral)
    assert second.arguments == (PositionLiteral("joint", (5.0, 4.0, 3.0, 2.0, 1.0, 0.0)),)
    assert program.routines[1].parameters[0].type == "joints"


def test_a_table_of_joints_is_a_table_of_joints() -> None:
    found = body("tab = [[0,0,0,0,0,0], [1,1,1,1,1,1]]", "movej(tab[i])")
    assert isinstance(found[0], Declare)
    assert isinstance(found[0].value, RecordLiteral)
    assert [item.kind for _, item in found[0].value.members if isinstance(item, PositionLiteral)] == [
        "joint"
    ] * 2
    assert isinstance(found[1], Move)
    assert found[1].targets == (Item(Named("tab"), (Binary("+", Named("i"), Number(1)),)),)


# --- expressions ----------------------------------------------------------------------------------------


def test_elements_of_a_pose_are_metres_and_a_rotation_vector() -> None:
    pose = "pos = p[1, 2, 3, 0, 0, 0]"
    assert value("pos[1]", pose) == Binary("*", Member(Named("pos"), "y"), Number(0.001))
    assert value("pos[5]", pose) == Member(Named("pos"), "rotation3")
    stored = body(pose, "pos[2] = pos[2] + 0.1")[-1]
    z = Member(Named("pos"), "z")
    assert stored == Assign(
        3, z, Binary("*", Binary("+", Binary("*", z, Number(0.001)), Number(0.1)), Number(1000.0))
    )
    assert body(pose, "pos[0] = pos[1]")[-1] == Assign(
        3, Member(Named("pos"), "x"), Member(Named("pos"), "y")
    )


def test_elements_of_joints_are_radians_and_lists_count_from_nothing() -> None:
    joints = "q = get_actual_joint_positions()"
    assert value("q[0]", joints) == Binary("*", Item(Named("q"), (Number(1),)), Number(DEG))
    assert value("xs[2]", "xs = [7, 8, 9]") == Item(Named("xs"), (Number(3),))
    assert value("xs[i-1]", "xs = [7, 8, 9]") == Item(Named("xs"), (Named("i"),))
    stored = body(joints, "q[3] = d2r(12)")[-1]
    assert isinstance(stored, Assign)
    assert stored.value == Number(12)


def test_angles_are_degrees_for_olp_and_radians_for_the_script() -> None:
    assert value("sin(x)") == Function("sin", (Binary("*", Named("x"), Number(1.0 / DEG)),))
    assert value("sin(d2r(30))") == Function("sin", (Number(30),))
    assert value("atan2(a, b)") == Binary("*", Function("atan2", (Named("a"), Named("b"))), Number(DEG))
    assert value("r2d(acos(x))") == Function("acos", (Named("x"),))
    assert value("d2r(x)") == Binary("*", Named("x"), Number(DEG))


def test_operators_bind_as_they_do_in_python() -> None:
    a, b, c = Named("a"), Named("b"), Named("c")
    assert value("a + b * c") == Binary("+", a, Binary("*", b, c))
    assert value("a - b - c") == Binary("-", Binary("-", a, b), c)
    assert value("a % b") == Binary("mod", a, b)
    assert value("-a * b") == Binary("*", Unary("-", a), b)
    assert value("a or b and not c") == Logic(a, (("or", Logic(b, (("and", Unary("not", c)),))),))
    assert value("not a == b") == Unary("not", Compare("=", a, b))
    assert value("a xor b") == Logic(a, (("xor", b),))
    assert value("a != 1") == Compare("<>", a, Number(1))


def test_calls_of_the_manual_have_their_neutral_names() -> None:
    a, b = Named("a"), Named("b")
    assert value("pose_trans(a, b)") == Function("pose-product", (a, b))
    assert value("pose_inv(a)") == Function("pose-inverse", (a,))
    assert value("pose_add(a, b)") == Function("pose-add", (a, b))
    assert value("get_actual_tcp_pose()") == SystemValue("current-pose")
    assert value("get_forward_kin(q)") == Function("forward", (Named("q"),))
    assert value("point_dist(a, b)") == Binary("*", Function("pose-distance", (a, b)), Number(0.001))
    assert value("pow(a, 2)") == Function("power", (a, Number(2)))
    assert value("str_sub(a, 2, 3)") == Function("part-of-text", (a, Number(3), Number(3)))
    assert value("struct(x=1, y=a).x") == Member(RecordLiteral("struct", (("x", Number(1)), ("y", a))), "x")
    assert value("get_tool_digital_in(1)") == Signal("tool-in", Number(1))
    assert value("get_configurable_digital_out(2)") == Signal("configurable-out", Number(2))
    assert value("modbus_get_signal_status(a, False)") == Function(
        "modbus_get_signal_status", (a, SignalState(False))
    )
    assert value("gripper.width(a)") == Function("gripper.width", (a,))
    assert value("elsewhere(a, n=2)") == CallValue("elsewhere", (a, NamedArgument("n", Number(2))))


def test_texts_are_joined_by_a_plus_and_hold_marks_of_comments() -> None:
    assert value('"a # b" + to_str(n)') == Function(
        "joined-text", (Text("a # b"), Function("text-of-value", (Named("n"),)))
    )


# --- statements -----------------------------------------------------------------------------------------


def test_signals_waits_and_settings() -> None:
    assert one("set_digital_out(3, True)") == SetOutput(2, Signal("out", Number(3)), SignalState(True))
    assert one("set_standard_analog_out(0, 0.5)") == SetOutput(
        2, Signal("analog-out", Number(0)), Number(0.5)
    )
    assert one("sleep(0.35)") == Dwell(2, Quantity(Number(0.35), 1.0))
    tool = one("set_tcp(p[0, 0, 0.1, 0, 0, 0])")
    assert tool == SetTool(2, PositionLiteral("pose", (0.0, 0.0, 0.1, 0.0, 0.0, 0.0)))
    payload = one("set_payload(1.5, [0, 0, 0.1])")
    assert isinstance(payload, Process)
    assert payload.name == "set_payload"
    assert body("kill h", "enter_critical", "sync()") == [
        Process(2, "kill", (("", Named("h")),)),
        Process(3, "enter_critical"),
        Process(4, "sync"),
    ]


@pytest.mark.parametrize("idle", ["sync()", "sleep(get_steptime())"])
@pytest.mark.parametrize(
    ("condition", "waited"),
    [
        ("get_digital_in(1) == False", Compare("=", Signal("in", Number(1)), SignalState(True))),
        ("get_digital_in(1)", Unary("not", Signal("in", Number(1)))),
        ("not done", Named("done")),
        ("x < 3", Compare(">=", Named("x"), Number(3))),
    ],
)
def test_a_loop_that_does_nothing_waits(idle: str, condition: str, waited: Expression) -> None:
    assert body(f"while ({condition}):", f"  {idle}", "end") == [Wait(2, waited)]
    assert body(f"while {condition}: {idle} end") == [Wait(2, waited)]


def test_a_loop_that_does_something_or_never_ends_is_a_loop() -> None:
    for inside in ("sleep(0.1)", "sync() # idle", "x = 1"):
        assert While in map(type, body("while (go):", inside, "end"))
    assert type(body("while (True):", "sync()", "end")[0]) is While


def test_popups_and_messages() -> None:
    assert body('popup("go?", "Title", False, False, blocking=True)')[1:] == [
        Message(2, Text("go?")),
        Pause(2),
    ]
    assert body('popup("hello", blocking=True)') == [Message(2, Text("hello")), Pause(2)]
    assert body('popup("hello")') == [Process(2, "popup"), Message(2, Text("hello"))]
    assert one('textmsg("n=", n)') == Message(2, Function("joined-text", (Text("n="), Named("n"))))


def test_blocks_on_one_line_and_over_many() -> None:
    found = body("while x > 0:", "if a: break end", "if b:", "continue", "elif c: y = 1", "end", "end")
    kinds = [type(s) for s in found]
    at = kinds.index(While)
    assert kinds[at : at + 3] == [While, If, Break]
    assert Continue in kinds
    assert ElseIf in kinds
    assert kinds.count(EndIf) == 2
    joined = body("if (a and", "   b or  # why", "   c):", "  sync()", "end")
    assert isinstance(joined[0], If)
    assert joined[0].comment == "why"


def test_a_whole_if_may_stand_in_one_line() -> None:
    lines = [
        'textmsg("if else")',
        "if x > 1: y = 1 elif x > 2: y = 2 else: y = 3 end # why",
        "if x: y = 1",
        "else: y = 4 end",
    ]
    _, said, *found = body(*lines)
    assert said == Message(2, Text("if else"))
    first = [If, Assign, ElseIf, Assign, Else, Assign, EndIf]
    assert [type(one) for one in found] == [*first, If, Assign, Else, Assign, EndIf]
    assert [one.line for one in found if isinstance(one, (ElseIf, Else))] == [3, 3, 5]


def test_halt_ends_the_program_and_is_kept_in_functions() -> None:
    assert body("halt") == [Return(2, spelling="halt")]
    program = read("def prog():\n  def stop():\n    halt\n  end\n  stop()\nend\n")
    assert program.routines[1].body == (Process(3, "halt"),)


def test_threads_start_and_are_waited_for() -> None:
    text = """\
def prog():
  thread blink():
    while (True):
      sync()
    end
  end
  h = run blink()
  run blink()
  join h
end
"""
    program = read(text)
    assert program.routines[0].body == (
        StartTask(7, "blink", "h"),
        StartTask(8, "blink", ""),
        WaitTask(9, "h"),
    )
    assert program.routines[1].details == {"kind": "thread"}


def test_marks_of_polyscope_are_comments_that_keep_their_sign() -> None:
    assert body('$ 5 "Home" "breakAfter"', "# note") == [
        Comment(2, '$ 5 "Home" "breakAfter"'),
        Comment(3, " note"),
    ]


# --- names and functions --------------------------------------------------------------------------------

NESTED = """\
def prog():
  global speed = 0.2
  count = 0
  mine = 4
  def help(n, twice=False):
    local mine = 1
    count = count + n
    inner = 2
    return inner
  end
  while (True):
    total = help(2, twice=True)
    help(count)
  end
end
"""


def test_functions_share_what_the_program_and_they_use() -> None:
    program = read(NESTED)
    assert program.main == "prog"
    assert [r.name for r in program.routines] == ["prog", "help"]
    assert {d.name: d.value for d in program.data} == {"speed": Number(0.2), "count": Number(0)}
    helper = program.routines[1]
    assert [(p.name, p.optional, p.default) for p in helper.parameters] == [
        ("n", False, None),
        ("twice", True, SignalState(False)),
    ]
    assert helper.returns == "integer"
    assert [type(s) for s in helper.body] == [Declare, Assign, Declare, Return]
    main = program.routines[0].body
    assert [s.name for s in main if isinstance(s, Declare)] == ["total", "mine"]
    assert (
        Call(12, "help", (Number(2), NamedArgument("twice", SignalState(True))), result=Named("total"))
        in main
    )


def test_a_name_that_is_local_to_a_function_is_not_the_shared_one() -> None:
    inside = "  def f():\n    local a = 2.5\n    a = a + 1\n    return a\n  end\n"
    text = f"def prog():\n  global a = 1\n{inside}  a = f()\nend\n"
    program = read(text)
    first, second, _ = program.routines[1].body
    assert first == Declare(4, "a", "real", Number(2.5), native="local")
    assert isinstance(second, Assign)
    assert {d.name: d.type for d in program.data} == {"a": "real"}


def test_functions_of_one_name_in_two_places_are_two() -> None:
    text = """\
def prog():
  def a():
    def x():
      sync()
    end
    x()
  end
  def b():
    def x():
      sleep(1)
    end
    x()
  end
  a()
  b()
end
"""
    program = read(text)
    names = [r.name for r in program.routines]
    assert len(set(names)) == 5
    calls = [s.routine for r in program.routines for s in r.body if isinstance(s, Call)]
    assert sorted(calls) == sorted(names[1:])


def test_data_that_is_set_once_holds_from_the_beginning_on() -> None:
    program = whole(
        "movej([0,0,0,0,0,0])", "global late_p = p[1, 2, 3, 0, 0, 0]", "global n = 1", "n = n + 1"
    )
    known = {d.name: d.value for d in program.data}
    assert isinstance(known["late_p"], PositionLiteral)
    assert known["n"] is None


@pytest.mark.parametrize(
    ("text", "main"),
    [
        ("def only():\n  sync()\nend\n", "only"),
        ("def first():\n  sync()\nend\ndef second():\n  sync()\nend\nsecond()\n", "second"),
        ("def part():\n  sync()\nend\ndef whole():\n  part()\nend\n", "whole"),
        ("def part():\n  sync()\nend\nsleep(1)\npart()\n", "a"),
        ("sleep(1)\n", "a"),
        ("sec blink():\n  set_digital_out(1, True)\nend\ndef prog():\n  sync()\nend\n", "prog"),
    ],
)
def test_the_program_is_what_runs(text: str, main: str) -> None:
    program = read(text)
    assert program.main == main
    assert program.routines[0].name == main


def test_comments_above_a_function_belong_to_it() -> None:
    program = read("def prog():\n  # far\n\n  # near\n  def f():\n    sync()\n  end\n  f()\nend\n")
    assert program.routines[1].body[0] == Comment(4, " near")
    assert program.routines[0].body[0] == Comment(2, " far")


def test_every_line_has_a_kind_and_the_bytes_come_back() -> None:
    raw = b'def p():\r\n\r\n  # \xe4\xf6\r\n  $ 1 "x"\r\n  {{REPLACE}}\r\n  movej()\r\nend\r\n'
    program = read_source(decode(raw, "a.script"))
    kinds = LineKind
    assert list(program.line_kinds) == [
        kinds.STATEMENT,
        kinds.BLANK,
        kinds.COMMENT,
        kinds.COMMENT,
        kinds.OPAQUE,
        kinds.ERROR,
        kinds.STATEMENT,
    ]
    assert program.to_bytes() == raw


def test_scripts_are_recognised_by_their_text() -> None:
    assert recognise(decode(b"def f():\n  sync()\nend\n", "x.txt")).name == "urscript"  # type: ignore[union-attr]
    assert recognise(decode(b"movej([0,0,0,0,0,0], a=1)\n", "x.txt")).name == "urscript"  # type: ignore[union-attr]
    assert recognise(decode(b"def f():\n  return 1\n", "x.txt")) is None


PLAIN = [
    "movej([0.1, -0.2, 3, 4., .5, -6e-1], a=1.4, v=1.05)",
    "movel(p[0.1, -0.2, 3, 4., .5, -6e-1],1.2,0.25,0,0.01)",
    "movep(p[0.1,-0.2,3,4.,.5,-6e-1], a = acc, v=speed_ms, r = 0.001)",
    "movel(pick_p, a=1.2, v=0.25)",
    "movej(get_inverse_kin(pick_p, qnear=pick_q), a=1.4, v=1.0, r=0.05)",
    "movej(get_inverse_kin(p[1, 2, 3, 4, 5, 6], qnear=[1, 2, 3, 4, 5, 6]), a=1.4, v=1.0)",
    "movel(pose_trans(plane, pick_p), a=1.2, v=0.25)",
    "movel(pose_trans(p[1,2,3,4,5,6], pick_p))",
    "global pick_p=p[1.0, 2, -3, 4, 5, 6]",
    "local home_q = [1.0, 2, -3, 4, 5, 6]",
    "x = [1, 2]",
    "x = p[0, -0, 0.0, -0.0, +0, 12345678901234567]",
    "x = p[1, 2, 3, 4]",
    "movel(P1 , a = 1.2,v=0.25 )",
    "movel(pose_trans(frame_5, P1), v=weld_speed * 0.001, r=0.002)",
    "movel(P1, v=speed*2)",
]


@pytest.mark.parametrize("line", PLAIN)
def test_the_fast_path_gives_what_the_grammar_gives(line: str) -> None:
    assert quick(line) is not None
    assert repr(quick(line)) == repr(instruction_parser().parse(line))  # where -0.0 is not 0.0


@pytest.mark.parametrize(
    "line",
    [
        "movej(True)",
        "movej([1,2,3,4,5,])",
        "movel(p[1,2])",
        "movel(p[a,2,3,4,5,6])",
        "movej(x, and=3)",
        "movej(x, a=not)",
        "global True = [1]",
        "x = [1, --2]",
        "movel(p[1,2,3,4,5,6], a=1.2, v=2*3)",
        "movej(f(x))",
        "movel(P1,)",
        "movel(P1, v=1 #)",
        "movel(P1, v=speed * 2 + 1)",
        "movel(P1, v=speed * -2)",
        "movel(P1, v=not * 2)",
        "movel(P1 v=1)",
    ],
)
def test_the_fast_path_declines_what_is_not_plain(line: str) -> None:
    assert quick(line) is None


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_samples_read_without_an_error_and_come_back_byte_by_byte(path: File) -> None:
    program = olp.read(path)
    assert not [d.render() for d in program.diagnostics if d.is_error]
    assert program.to_bytes() == path.read_bytes()


def test_the_export_of_polyscope_goes_to_its_waypoints() -> None:
    program = olp.read(SAMPLES / "polyscope.script")
    assert [d.code for d in program.diagnostics] == []
    assert program.main == "polyscope"
    assert [r.name for r in program.routines] == [
        "polyscope",
        "Step_Counter_Thread_3f1c",
        "gripper_set",
        "gripper_is_open",
        "Put_Down",
    ]
    points = {d.name: d for d in program.data if isinstance(d.value, PositionLiteral)}
    assert {name[-2:]: points[name].type for name in ("Above_p", "Above_q")} == {
        "_p": "position",
        "_q": "joints",
    }
    plan = program.plan(robot="universal-robots/ur10e")
    assert not [d.render() for d in plan.diagnostics if d.is_error]
    wanted = ("Above_p", "Grip_p", "Above_p", "Over_p", "Place_p", "Over_p")
    targets = [plan.positions.position[int(row)] for row in plan.moves.target[1:]]
    for name, position in zip(wanted, targets, strict=True):
        value = points[name].value
        assert isinstance(value, PositionLiteral)
        np.testing.assert_allclose(position, value.values[:3], atol=1e-8)
    axes = plan.positions.axes[plan.moves.target]
    home = points["Home_q"].value
    assert isinstance(home, PositionLiteral)
    np.testing.assert_allclose(axes[0], home.values, atol=1e-12)


def test_rotation_vectors_and_roll_pitch_yaw_are_one_turn() -> None:
    rows = ["v = rpy2rotvec([0.3, 0.2, 0.1])", "w = rotvec2rpy(v)", *(f"sleep(w[{n}])" for n in range(3))]
    text = "def prog():\n" + "".join(f"  {row}\n" for row in rows) + "end\n"
    waits = read(text).plan().durations
    assert waits == pytest.approx([0.3, 0.2, 0.1])
    half_turn = read("def prog():\n  w = rotvec2rpy([0, 0, 1.5])\n  sleep(w[2])\nend\n").plan().durations
    assert half_turn == pytest.approx([1.5])


def test_elements_of_what_nothing_here_knows_are_assumed_as_the_whole_is() -> None:
    text = """def part():
  r = socket_read_ascii_float(3)
  movel(p[0.4, -0.2, 0.3, 0, 3.14, 0], v=0.1)
  if r[0] > 1:
    sleep(5)
  end
  q = [r[1], r[2]]
  sleep(q[0] + 1)
end
"""
    plan = read_source(decode(text.encode(), "part.script")).plan()
    assert not [d for d in plan.diagnostics if d.is_error]
    assert [round(float(x), 6) for x in plan.durations] == [1.0]
    assert any("socket_read_ascii_float is not known here" in one for one in map(str, plan.assumptions))


AHEAD = """
def ahead():
  frame = p[0.05, 0, 0, 0, 0, 0.1]
  a = p[0.3, -0.1, 0.3, 0, 3.14, 0]
  movej([0, -1.5, 1.5, -1.5, -1.5, 0])
  movej(get_inverse_kin(pose_trans(frame, a), qnear=[0, -1.5, 1.5, -1.5, -1.5, 0]))
  b = p[0.3, 0.1, 0.3, 0, 3.14, 0]
  i = 0
  while i < 3:
    movej(get_inverse_kin(pose_trans(frame, b), qnear=[0, -1.5, 1.5, -1.5, -1.5, 0]))
    movej(get_inverse_kin(b, qnear=[0, -1.5, 1.5, -1.5, -1.5, 1]))
    b = pose_add(b, p[0.01, 0, 0, 0, 0, 0])
    movej(get_inverse_kin(p[9, 9, 9, 0, 0, 0], qnear=[0, -1.5, 1.5, -1.5, -1.5, 2]))
    i = i + 1
  end
  frame = p[0.06, 0, 0, 0, 0, 0.1]
  movej(get_inverse_kin(pose_trans(frame, a), qnear=[0, -1.5, 1.5, -1.5, -1.5, 0]))
end
"""


def test_axes_that_are_found_ahead_are_those_that_are_found_one_by_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of moves whose poses change before the program comes to them, too."""
    asked: list[int] = []

    def counted(m: Machine, value: PositionValue, *more: PositionValue) -> PositionValue:
        asked.append(m.line)
        return one_by_one(m, value, *more)

    def planned() -> Plan:
        return run(vendor.read_source(decode(AHEAD.encode(), "a.script")), "universal-robots/ur5e")

    one_by_one = places.joints_of
    monkeypatch.setattr(places, "joints_of", counted)
    together = planned()
    few = len(asked)
    monkeypatch.setattr(places, "_solve", lambda m, asked: None)
    single = planned()
    assert few < len(asked) - few
    np.testing.assert_allclose(together.positions.axes, single.positions.axes, rtol=0, atol=1e-12)
    assert together.diagnostics == single.diagnostics
    assert together.assumptions == single.assumptions
