"""URScript as it is written: the same program back, and the same motion when Python runs the text."""

from __future__ import annotations

import dataclasses
import math
import random
from pathlib import Path as File

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from translated_texts import converted
from urscript_python import Pose, Robot, run

import olp
from olp.core.diagnostic import OlpError, raise_errors
from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.expressions import (
    Binary,
    Compare,
    Expression,
    FrameRef,
    Function,
    Item,
    Member,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    Signal,
    SignalState,
    SystemValue,
    Text,
    Variable,
)
from olp.ir.expressions import Store as Kind
from olp.ir.points import PointTable
from olp.ir.program import (
    Acceleration,
    AccelerationUnit,
    Assign,
    Blend,
    BlendKind,
    Call,
    Comment,
    Declare,
    Dwell,
    EndIf,
    If,
    Jump,
    Message,
    Move,
    Opaque,
    Parameter,
    Path,
    Pause,
    Program,
    Routine,
    SetOutput,
    Speed,
    SpeedUnit,
    StartTask,
    Statement,
    Wait,
)
from olp.languages.templating import shipped
from olp.languages.vendors.urscript.writer import UrscriptWriter, write
from olp.robots.geometry import rotation_from_angles
from olp.robots.robot import load_robot
from olp.runtime.plan import PATHS, Plan, StepKind
from olp.transpile.context import Context
from olp.transpile.convert import convert, export
from olp.transpile.link import link

SAMPLES = File(__file__).resolve().parent.parent / "samples" / "urscript"
DEG = math.pi / 180.0
STOP = Blend(BlendKind.RADIUS, Quantity(Number(0), 1.0))


def read(text: str) -> Program:
    return read_source(decode(text.encode(), "a.script"), vendor="urscript")


def again(program: Program) -> Program:
    return read(export(program, "urscript").decode())


def meaning(program: Program) -> list[object]:
    """All of a program but the numbers of its lines."""
    rows: list[object] = [program.main]
    rows += [dataclasses.replace(one, line=0) for one in program.data]
    for routine in program.routines:
        rows += [routine.name, routine.parameters, routine.returns, dict(routine.details)]
        rows += [dataclasses.replace(one, line=0) for one in routine.body]
    return rows


def foreign(*body: Statement, data: tuple[Declare, ...] = ()) -> str:
    """What another language's statements are in URScript."""
    source = decode(b"x\n" * 20, "a.mod")
    program = Program("rapid", source, (Routine("main", 1, body, PointTable()),), data=data, main="main")
    values, problems = write(program, "")
    raise_errors(problems)
    return shipped("urscript").render(values)


def refusal(*body: Statement) -> str:
    with pytest.raises(OlpError) as raised:
        foreign(*body)
    assert {d.code for d in raised.value.diagnostics} == {"X002"}
    return raised.value.diagnostics[0].message


# --- the same program back ------------------------------------------------------------------------------

SHAPES = """\
# head
def whole():  # the program
  global tool_tcp = p[0.01, 0.02, 0.13, 0.3, -0.2, 0.1]
  set_tcp(tool_tcp, "gripper")
  set_tcp(p[0.01, 0.02, 0.13, 0.3, -0.2, 0.1], "gripper")
  set_payload(1.2, [0, 0, 0.05])
  plane = p[0.1, 0.2, 0.3, 0.3, 0.2, 0.1]
  pick_p = p[0.4, -0.1, 0.2, 2.2, -2.2, 0.1]
  pick_q = [0.1, -1.2, 1.3, -1.4, -1.5, 0.6]
  names = ["a", "b"]
  rec = struct(speed=0.1, place=pick_p)
  tab = [[0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 1, 0]]
  def shift(pose, up=0.1, *ignored):
  end
  $ 1 "Robot Program" "noBreak"
  while (True):
    movej(get_inverse_kin(pick_p, qnear=pick_q), a=1.4, v=1.05, r=0.02)  # over the part
    movej(get_inverse_kin(pose_trans(plane, pick_p), qnear=pick_q))
    movel(pose_trans(plane, pick_p), a=1.2, v=0.25)
    movel(pose_trans(pick_p, p[0, 0, -0.05, 0, 0, 0]), t=2.5, v=0.3)
    movec(p[0.4, 0, 0.2, 0, 3, 0], p[0.4, 0.1, 0.2, 0, 3, 0], v=0.2, mode=1)
    movep(pick_p, v=rec.speed, r=0.005)
    movej(tab[n], t=time_for(n))
    optimovel(pick_p, a=0.4)
    pick_p[2] = pick_p[2] + 0.01
    pick_q[5] = pick_q[5] + d2r(10)
    n = norm(-3) % 2
    x = sin(d2r(30)) + cos(n) * atan2(1, 2) - r2d(asin(0.5))
    y = pow(2, 3) / (1 - x) - (4 - (2 - 1))
    if (n == 1 and not (x > y or names[0] == "a")):
      popup("part?", title="Title", warning=True, blocking=True)
    elif (get_configurable_digital_in(2)):
      popup("hello", title="x")
    else:
      textmsg("n = ", n)
    end
    while (not get_standard_digital_in(2)):
      sync()
    end
    while (get_digital_in(9) == False):
      sleep(get_steptime())
    end
    olp_left = 2.5
    while (olp_left > 0 and (x < 1 or y > 2)):
      sync()
      olp_left = olp_left - get_steptime()
    end
    if (olp_left <= 0):
      break
    end
    set_tool_digital_out(1, n > 0)
    h = run blink()
    kill h
    join h
    enter_critical
    rpc.call(1, name="x")
    socket_send_line(str_cat("a", str_sub("text", 1, 2)), "s")
    continue
  end
  thread blink():
    set_digital_out(8, not (get_digital_out(8)))
    sleep(0.5)
  end
  def time_for(k):
    local y = k * 2
    return y + 0.1
  end
  halt
end
"""


def test_a_program_of_all_shapes_comes_back_as_the_same_program() -> None:
    program = read(SHAPES.replace("  def shift(pose, up=0.1, *ignored):\n  end\n", ""))
    assert not [d.render() for d in program.diagnostics if d.is_error]
    assert meaning(again(program)) == meaning(program)


def test_secondary_programs_stand_beside_the_program() -> None:
    program = read("sec lamp():\n  set_digital_out(1, True)\nend\ndef prog():\n  sleep(1)\nend\n")
    assert export(program, "urscript").startswith(b"sec lamp():\n")
    assert meaning(again(program)) == meaning(program)


def test_a_script_that_was_written_is_written_the_same_again() -> None:
    text = export(read(SHAPES.replace(", *ignored", "")), "urscript")
    assert export(read(text.decode()), "urscript") == text


@pytest.mark.parametrize("path", sorted(SAMPLES.glob("*.script")), ids=lambda path: path.name)
def test_samples_come_back_as_the_same_program(path: File) -> None:
    program = olp.read(path)
    assert meaning(again(program)) == meaning(program)


def test_names_and_comments_survive() -> None:
    text = export(olp.read(SAMPLES / "handling.script"), "urscript").decode()
    for word in (
        "gripper_tcp",
        "home_q",
        "# lift in three steps",
        "# above the part",
        "def drop():",
        "def handling():",
    ):
        assert word in text


def test_lines_end_as_on_the_controller() -> None:
    assert b"\r" not in export(read("def a():\r\n  sync()\r\nend\r\n"), "urscript")


# --- what another language says -------------------------------------------------------------------------


def line(target: Expression, **more: object) -> Move:
    speed = Speed(SpeedUnit.TRAVEL, Quantity(Number(250), 0.001))
    return Move(1, Path.LINEAR, (target,), speed, STOP, **more)  # type: ignore[arg-type]


def test_millimetres_degrees_and_angles_become_metres_and_a_rotation_vector() -> None:
    angles = (170.5 * DEG, -4 * DEG, 18 * DEG)
    text = foreign(line(PositionLiteral("pose", (0.26025, 0.06, 0.0405, *angles))))
    robot = run(text)
    (word, place, how, _) = robot.moves()[0]
    assert word == "movel"
    assert how["v"] == 0.25
    np.testing.assert_allclose(place[:3], (0.26025, 0.06, 0.0405), atol=1e-9)
    np.testing.assert_allclose(
        Rotation.from_rotvec(place[3:]).as_matrix(), rotation_from_angles(angles), atol=1e-9
    )


def test_joint_targets_blends_and_accelerations() -> None:
    move = Move(
        1,
        Path.JOINT,
        (PositionLiteral("joint", tuple(value * DEG for value in (5.5, -12.25, 18.75, 3.5, -47.25, 21))),),
        Speed(SpeedUnit.AXIS, Quantity(Number(60), DEG)),
        Blend(BlendKind.RADIUS, Quantity(Number(25), 0.001)),
        rate=Acceleration(AccelerationUnit.AXIS, Quantity(Number(2), 1.0)),
    )
    _, place, how, _ = run(foreign(move)).moves()[0]
    np.testing.assert_allclose(place, np.radians((5.5, -12.25, 18.75, 3.5, -47.25, 21)), atol=1e-9)
    assert how == {"a": 2, "v": pytest.approx(math.pi / 3), "t": 0, "r": 0.025}


def test_the_tool_is_set_where_it_changes_and_again_where_it_may_have() -> None:
    pose = PositionLiteral("pose", (0.4, 0.1, 0.2, 0.1, 0.2, 0.3))
    first, second = (line(pose, tool=Named(name)) for name in ("gripper", "probe"))
    tools = tuple(Declare(0, name, "tool", pose) for name in ("gripper", "probe"))
    text = foreign(
        first, first, second, If(1, Named("x")), first, EndIf(1), second, Call(1, "other"), second, data=tools
    )
    found = [one.strip() for one in text.splitlines() if "set_tcp" in one or "movel" in one]
    kinds = [one.split("(")[0] + (one[7:12] if "tcp" in one else "") for one in found]
    assert kinds == [
        "set_tcp(grip",
        "movel",
        "movel",
        "set_tcp(prob",
        "movel",
        "set_tcp(grip",
        "movel",
        "set_tcp(prob",
        "movel",
        "set_tcp(prob",
        "movel",
    ]


def test_a_frame_stands_before_the_target() -> None:
    place = PositionLiteral("pose", (0.1, 0.2, 0.3, 0.4, 0.5, 0.6))
    table = Declare(0, "table", "frame", PositionLiteral("pose", (0.7, -0.2, 0.3, 0.1, -0.2, 0.5)))
    text = foreign(line(place, frame=Named("table")), data=(table,))
    assert "movel(pose_trans(table, p[" in text
    position = rotation_from_angles((0.1, -0.2, 0.5)) @ (0.1, 0.2, 0.3) + (0.7, -0.2, 0.3)
    np.testing.assert_allclose(run(text).moves()[0][1][:3], position, atol=1e-9)
    assert "pose_trans" not in foreign(line(place, frame=FrameRef("base")))


POSE = Declare(0, "pos", "position", PositionLiteral("pose", (0.1, 0.2, 0.3, 0.4, -0.5, 0.6)))


@pytest.mark.parametrize(
    ("expression", "number"),
    [
        (Member(Named("pos"), "x"), 100.0),
        (Member(Named("pos"), "rx"), 0.4 / DEG),
        (Member(Named("pos"), "ry"), -0.5 / DEG),
        (Member(Named("pos"), "rz"), 0.6 / DEG),
        (Item(Named("joints"), (Number(2),)), -12.25),
        (Item(Named("numbers"), (Number(3),)), 9),
        (Function("sin", (Number(30),)), 0.5),
        (Function("acos", (Number(0.5),)), 60.0),
        (Function("atan2", (Number(1), Number(1))), 45.0),
        (Function("round", (Number(-2.5),)), -3),
        (Function("trunc", (Number(-2.5),)), -2),
        (Function("min", (Number(3), Number(2))), 2),
        (Function("max", (Number(3), Number(2))), 3),
        (Function("abs", (Number(-3),)), 3),
        (Function("exp", (Number(1),)), math.e),
        (Function("power", (Number(2), Number(5))), 32),
        (Binary("div", Number(-7), Number(2)), -3),
        (Binary("mod", Number(7), Number(3)), 1),
        (Function("pose-distance", (Named("pos"), Named("pos"))), 0.0),
        (Member(Function("pose-offset", (Named("pos"), Number(10), Number(0), Number(0))), "x"), 110.0),
    ],
)
def test_values_are_those_of_the_other_language(expression: Expression, number: float) -> None:
    joints = PositionLiteral("joint", tuple(v * DEG for v in (5.5, -12.25, 18.75, 3.5, -47.25, 21)))
    data = (
        POSE,
        Declare(0, "joints", "joints", joints),
        Declare(
            0,
            "numbers",
            "integer",
            olp.ir.expressions.RecordLiteral("list", tuple(("", Number(v)) for v in (7, 8, 9))),
        ),
    )
    text = foreign(Dwell(1, Quantity(expression, 1.0)), data=data)
    assert run(text).done == [("sleep", pytest.approx(number, abs=1e-8))]


def test_a_turned_tool_shift_turns_about_x_then_y_then_z() -> None:
    numbers = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0)
    target = Function("pose-relative-tool", (Named("pos"), *map(Number, numbers)))
    place = run(foreign(line(target), data=(POSE,))).moves()[0][1]
    base = rotation_from_angles((0.4, -0.5, 0.6))
    np.testing.assert_allclose(place[:3], base @ (0.01, 0.02, 0.03) + (0.1, 0.2, 0.3), atol=1e-9)
    turn = Rotation.from_euler("XYZ", (40, 50, 60), degrees=True).as_matrix()
    np.testing.assert_allclose(Rotation.from_rotvec(place[3:]).as_matrix(), base @ turn, atol=1e-9)


def test_a_component_is_stored_in_metres_and_an_angle_turns_the_pose() -> None:
    text = foreign(
        Assign(1, Member(Named("pos"), "z"), Number(55.5)),
        Assign(1, Member(Named("pos"), "ry"), Number(12.5)),
        line(Named("pos")),
        data=(POSE,),
    )
    place = run(text).moves()[0][1]
    np.testing.assert_allclose(place[:3], (0.1, 0.2, 0.0555), atol=1e-9)
    np.testing.assert_allclose(
        Rotation.from_rotvec(place[3:]).as_matrix(), rotation_from_angles((0.4, 12.5 * DEG, 0.6)), atol=1e-9
    )


def test_what_was_computed_by_helpers_is_read_as_what_it_means() -> None:
    text = foreign(Dwell(1, Quantity(Member(Named("pos"), "rx"), 1.0)), data=(POSE,))
    program = read(text)
    assert [r.name for r in program.routines] == ["main"]
    assert program.routines[0].body == (Dwell(7, Quantity(Member(Named("pos"), "rx"), 1.0)),)


def test_waits_with_and_without_an_end() -> None:
    ready = Compare("=", Signal("in", Number(3)), SignalState(True))
    robot = run(
        foreign(
            Wait(1, ready),
            Wait(1, ready, Quantity(Number(2), 1.0)),
            SetOutput(1, Signal("out", Number(1)), SignalState(True)),
        )
    )
    assert robot.syncs == 5
    assert robot.done == [("out", 1, True)]
    text = foreign(
        Wait(1, SignalState(False), Quantity(Number(0.1), 1.0)), Dwell(1, Quantity(Number(1), 1.0))
    )
    assert run(text).syncs == 50
    assert Wait(1, ready, Quantity(Number(2), 1.0)) in [
        dataclasses.replace(s, line=1)
        for s in read(foreign(Wait(1, ready, Quantity(Number(2), 1.0)))).statements()
    ]


def test_comments_messages_and_pauses() -> None:
    text = foreign(
        Comment(1, "first"), Message(1, Text("hello")), Pause(1), Message(1, Text("bye")), Pause(1)
    )
    assert "# first" in text
    assert text.count('popup("hello", blocking=True)') == 1
    assert "textmsg" not in text


@pytest.mark.parametrize(
    ("statement", "what"),
    [
        (Jump(1, "A"), "jump"),
        (Opaque(1, "FOO"), "only its own language"),
        (Call(1, "A", jump=True), "does not come back"),
        (Assign(1, Variable(Kind.REAL, Number(1)), Number(2)), "storing"),
        (SetOutput(1, Signal("out-group", Number(1)), Number(3)), "the group output"),
        (SetOutput(1, Signal("out", Text("doGrip")), SignalState(True)), "the digital output"),
        (Message(1, Text('say "x"')), "quotes"),
        (Dwell(1, Quantity(SystemValue("timer", 1), 1.0)), "a clock"),
        (Dwell(1, Quantity(Function("klingon", ()), 1.0)), "the function klingon"),
        (line(PositionLiteral("pose", (0.0,) * 6, external=(5.0,))), "further axes"),
        (line(PositionLiteral("pose", (0.0, math.nan, 0.0, 0.0, 0.0, 0.0))), "left out"),
        (line(Named("a"), frame=FrameRef("user", Number(1))), "a frame by its number"),
        (line(Named("a"), offset=Named("b")), "an offset"),
        (line(Named("a"), other=(("TB", Text("x")),)), "TB"),
        (line(Named("a"), acceleration=Quantity(Number(50), 0.01)), "a share of the rated one"),
        (Move(1, Path.LINEAR, (Named("a"),), None, STOP), "without a speed"),
        (
            Move(1, Path.SPLINE, (Named("a"),), Speed(SpeedUnit.TRAVEL, Quantity(Number(1), 1.0)), STOP),
            "a spline",
        ),
        (Move(1, Path.LINEAR, (Named("a"),), Speed(SpeedUnit.TRAVEL, Quantity(Number(1), 1.0))), "no radius"),
        (
            Move(1, Path.CIRCULAR, (Named("a"),), Speed(SpeedUnit.TRAVEL, Quantity(Number(1), 1.0)), STOP),
            "points of several moves",
        ),
    ],
)
def test_what_urscript_cannot_say_is_refused_with_its_reason(statement: Statement, what: str) -> None:
    assert what in refusal(statement)


def test_numbers_keep_their_digits() -> None:
    words = UrscriptWriter(read("def p():\nend\n"))
    for value in (0.1, 1e-05, -0.0, 1.3962634015954636, 7, -3):
        assert float(words.value(Number(value))) == value


# --- run by Python --------------------------------------------------------------------------------------


def places(robot: Robot) -> list[tuple[str, np.ndarray, np.ndarray | None]]:
    """(word, position or axes, turn) of each move."""
    found = []
    for word, place, _, _ in robot.moves():
        if isinstance(place, Pose):
            found.append((word, np.array(place[:3]), Rotation.from_rotvec(place[3:]).as_matrix()))
        else:
            found.append((word, np.array(place), None))
    return found


def assert_same(plan: Plan, robot: Robot) -> None:
    """The plan's moves are those that the script did: path, place, turn, speed, blend, in order."""
    rows = [int(plan.row[n]) for n in range(len(plan)) if plan.kind[n] == StepKind.MOVE]
    moves = plan.moves
    assert len(rows) == len(robot.moves())
    for row, (word, place, turn), done in zip(rows, places(robot), robot.moves(), strict=True):
        how = done[2]
        assert PATHS[moves.path[row]] == {"j": "joint", "c": "circular"}.get(word[4], "linear")
        at = int(moves.target[row])
        if turn is None:
            np.testing.assert_allclose(plan.positions.axes[at], place, atol=1e-9)
        else:
            np.testing.assert_allclose(plan.positions.position[at], place, atol=1e-9)
            w, x, y, z = plan.positions.quaternion[at]
            np.testing.assert_allclose(Rotation.from_quat((x, y, z, w)).as_matrix(), turn, atol=1e-9)
        speeds = moves.axis_speed if word == "movej" else moves.travel
        if how["t"]:
            assert moves.duration[row] == pytest.approx(how["t"])
        else:
            assert speeds[row] == pytest.approx(how["v"])
        assert moves.rate[row] == pytest.approx(how["a"])
        assert moves.blend[row] == pytest.approx(how["r"]) if how["r"] else not moves.blend[row] > 0


def test_the_sample_does_in_python_what_its_plan_says() -> None:
    path = SAMPLES / "handling.script"
    robot = run(path.read_text())
    plan = olp.read(path).plan(robot="yaskawa/gp25")
    assert_same(plan, robot)
    outs = [one[1:] for one in robot.done if one[0] == "out"]
    assert outs == [(3, False), (3, True), (3, False)]
    waits = [
        float(plan.durations[int(plan.row[n])]) for n in range(len(plan)) if plan.kind[n] == StepKind.WAIT
    ]
    assert [one[1] for one in robot.done if one[0] == "sleep"] == [wait for wait in waits if wait]


def test_the_sample_written_anew_does_the_same() -> None:
    path = SAMPLES / "handling.script"
    text = export(olp.read(path), "urscript").decode()
    first, second = run(path.read_text()), run(text)
    assert [one[0] for one in first.done] == [one[0] for one in second.done]
    for one, other in zip(places(first), places(second), strict=True):
        np.testing.assert_allclose(one[1], other[1], atol=1e-12)


OTHERS = {
    "inform": "inform/handling/HANDLING.JBI",
    "krl": "krl/handling.src",
    "rapid": "rapid/handling.mod",
    "tp": "tp/handling.ls",
}


@pytest.mark.parametrize("vendor", OTHERS)
def test_the_same_task_in_another_language_does_in_python_what_the_script_does(vendor: str) -> None:
    program = link(olp.read(SAMPLES.parent / OTHERS[vendor])).program
    converted = convert(program, "urscript", Context(load_robot("yaskawa/gp25"), on_loss="comment"))
    other = run(converted.files[converted.main].decode())
    own = run((SAMPLES / "handling.script").read_text())
    assert [one[0] for one in other.done] == [one[0] for one in own.done]
    assert [one[1:] for one in other.done if one[0] in ("out", "sleep")] == [
        one[1:] for one in own.done if one[0] in ("out", "sleep")
    ]
    for one, wanted in zip(places(other), places(own), strict=True):
        np.testing.assert_allclose(one[1], wanted[1], atol=1e-6)
        if wanted[2] is not None:
            np.testing.assert_allclose(one[2], wanted[2], atol=2e-6)
    for (word, _, how, tool), (_, _, wanted_how, wanted_tool) in zip(other.moves(), own.moves(), strict=True):
        if word != "movej":
            assert how["v"] == pytest.approx(wanted_how["v"])
            np.testing.assert_allclose(tool, wanted_tool, atol=1e-6)
        if vendor == "tp":  # CNT is a share of the speed, whose radius the robot decides
            continue
        if vendor == "krl" and word == "movel" and wanted_how["v"] == pytest.approx(0.1205):
            assert how["r"] == 0.0, "the loop ends at a WAIT FOR, which stops KUKA's advance run"
        else:
            assert how["r"] == pytest.approx(wanted_how["r"])


def scripts(seed: int) -> str:
    """A random program: waypoints, features, loops, branches, functions, arithmetic."""
    rng = random.Random(seed)
    lines = ["def prog():"]
    poses = [f"w{n}_p" for n in range(3)]

    def number(low: float, high: float) -> str:
        return f"{rng.uniform(low, high):.6f}"

    def pose() -> str:
        place = [number(0.75, 0.95), number(-0.2, 0.2), number(0.25, 0.5)]
        return f"p[{', '.join([*place, number(2.6, 3.1), number(-0.4, 0.4), number(-0.3, 0.3)])}]"

    def shift() -> str:
        return f"p[{', '.join(number(-0.03, 0.03) for _ in range(3))}, 0, {number(-0.1, 0.1)}, {number(-0.2, 0.2)}]"

    for name in poses:
        lines.append(f"  global {name} = {pose()}")
    lines.append(f"  global home_q = [{', '.join(number(-0.4, 0.4) for _ in range(6))}]")
    lines.append(f"  global feature = {shift()}")
    lines.append("  global count = 0")
    lines.append("  def lift(place, up=0.02):")
    lines.append("    place[2] = place[2] + up")
    lines.append("    count = count + 1")
    lines.append("    return place")
    lines.append("  end")

    def target() -> str:
        name = rng.choice(poses)
        return rng.choice(
            [
                name,
                pose(),
                f"pose_trans(feature, {name})",
                f"pose_trans({name}, {shift()})",
                f"pose_add({name}, {shift()})",
                f"lift({name})",
                f"lift({name}, up={number(-0.02, 0.02)})",
                f"p[{name}[0], {name}[1] + 0.01 * count, {name}[2], {name}[3], {name}[4], {name}[5]]",
                f"pose_trans(pose_inv(feature), {name})",
            ]
        )

    def manner() -> str:
        speed = rng.choice(["", f", v={number(0.05, 0.5)}", f", a={number(0.5, 2)}, v={number(0.05, 0.5)}"])
        return speed + rng.choice(["", f", r={number(0.001, 0.01)}", f", t={number(0.5, 2)}"])

    def statements(depth: int, indent: str) -> None:
        for _ in range(rng.randint(1, 4)):
            kind = rng.randint(0, 8 if depth < 2 else 5)
            if kind <= 1:
                lines.append(f"{indent}movel({target()}{manner()})")
            elif kind == 2:
                lines.append(f"{indent}movej({rng.choice(['home_q', target()])}{manner()})")
            elif kind == 3:
                lines.append(f"{indent}movec({rng.choice(poses)}, {target()}, v={number(0.05, 0.3)})")
            elif kind == 4:
                lines.append(f"{indent}count = count + {rng.randint(1, 3)}")
            elif kind == 5:
                lines.append(f"{indent}sleep({number(0.1, 1)})")
            elif kind == 6:
                name = f"i{depth}"
                lines.append(f"{indent}{name} = 0")
                lines.append(f"{indent}while ({name} < {rng.randint(1, 3)}):")
                statements(depth + 1, indent + "  ")
                lines.append(f"{indent}  {name} = {name} + 1")
                lines.append(f"{indent}end")
            else:
                lines.append(
                    f"{indent}if (count % {rng.randint(2, 4)} == 1 or sin(count) > {number(-1, 1)}):"
                )
                statements(depth + 1, indent + "  ")
                if rng.random() < 0.5:
                    lines.append(f"{indent}else:")
                    statements(depth + 1, indent + "  ")
                lines.append(f"{indent}end")

    statements(0, "  ")
    lines.append("end")
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("seed", range(40))
def test_a_random_program_moves_as_python_says_and_comes_back_the_same(seed: int) -> None:
    text = scripts(seed)
    program = read(text)
    assert not program.diagnostics, program.diagnostics[0].render()
    assert meaning(again(program)) == meaning(program)
    robot = run(text)
    written = run(export(program, "urscript").decode())
    assert [one[0] for one in robot.done] == [one[0] for one in written.done]
    for one, other in zip(places(robot), places(written), strict=True):
        np.testing.assert_allclose(one[1], other[1], atol=1e-9)
    assert_same(program.plan(robot="yaskawa/gp25"), robot)


# --- what the controller would refuse --------------------------------------------------------------------


def several(*routines: Routine) -> str:
    program = Program("inform", decode(b"x\n" * 20, "a.jbi"), routines, main=routines[0].name)
    values, problems = write(program, "")
    raise_errors(problems)
    return shipped("urscript").render(values)


def test_a_routine_that_is_started_is_a_thread() -> None:
    main = Routine("main", 1, (StartTask(1, "side", "SUB1"), Call(2, "other")), PointTable())
    side = Routine("side", 3, (Dwell(3, Quantity(Number(0.5), 1.0)),), PointTable())
    text = several(main, side, Routine("other", 4, (), PointTable()))
    assert "thread side():" in text
    assert "def other():" in text
    assert [type(s) for s in read(text).routines[0].body] == [StartTask, Call]


def test_a_thread_is_neither_called_nor_handed_anything() -> None:
    main = Routine("main", 1, (StartTask(1, "side", "SUB1"), Call(2, "side")), PointTable())
    with pytest.raises(OlpError, match="both called and started"):
        several(main, Routine("side", 3, (), PointTable()))
    handed = Routine("side", 3, (), PointTable(), parameters=(Parameter("a", "integer"),))
    with pytest.raises(OlpError, match="handed something"):
        several(Routine("main", 1, (StartTask(1, "side", "SUB1"),), PointTable()), handed)


def test_joint_angles_have_no_components_of_a_pose() -> None:
    joints = Declare(1, "q", "joints", PositionLiteral("joint", (0.0,) * 6))
    with pytest.raises(OlpError, match="the component z of joint angles"):
        foreign(Assign(1, Named("n"), Member(Named("q"), "z")), data=(joints,))


UNTYPED = """def part():
  sleep(1)
end
def grip(w, on, p, d, q):
  set_digital_out(w, on)
  sleep(d)
  movel(p, v=0.1)
  movej(q)
end
"""


@pytest.mark.parametrize(
    ("target", "head"),
    [
        ("rapid", "PROC grip(num w,bool on,robtarget p,num d,robtarget q)"),
        ("krl", "DECL INT w\r\nDECL BOOL on_1\r\nDECL E6POS p\r\nDECL REAL d\r\nDECL E6POS q\r\n"),
    ],
)
def test_a_parameter_without_a_type_is_what_its_routine_takes_it_for(target, head):
    """Scripts name no types: those of a routine that nothing here calls are told as assumed."""
    made = converted(UNTYPED, "urscript", target)
    text = b"\n".join(made.files.values()).decode()
    assert head.replace("\r\n", "\n") in text.replace("\r\n", "\n")
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    told = {loss.says for loss in made.translated.losses if loss.part == "parameter"}
    assert len(told) == 5
    assert "q, a parameter without a type, is taken for a Cartesian position, which it may not be" in told
