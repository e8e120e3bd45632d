"""Where moves go: elements, arithmetic, conversions, frames, shifts and increments, against numpy by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from interpreter_jobs import errors, findings, plan_of, said, write_jobs
from numpy.typing import NDArray

from olp.fluent import read
from olp.ir.expressions import Store
from olp.ir.points import PointKind, PointState
from olp.robots.kinematics import forward, pulses_to_joints
from olp.robots.robot import load_robot
from olp.runtime.assumptions import Assumptions, WrittenPosition
from olp.runtime.interpreter import run
from olp.runtime.plan import Plan, StepKind

Array = NDArray[np.float64]
FIRST = np.array([0.011, -0.2034, 0.41725])
ANGLES = np.radians([178.2610, 1.5083, -29.8410])


def turn(rx: float, ry: float, rz: float) -> Array:
    """Rz Ry Rx, written out once more."""
    cx, sx, cy, sy, cz, sz = (f(a) for a in (rx, ry, rz) for f in (math.cos, math.sin))
    x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return z @ y @ x


def matrix(values: Array) -> Array:
    """4 x 4 of x, y, z [m], Rx, Ry, Rz [rad]."""
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = turn(*values[3:]), values[:3]
    return result


def pose(x: float, y: float, z: float, rx: float, ry: float, rz: float) -> Array:
    """From mm and degrees."""
    return np.array([x / 1000, y / 1000, z / 1000, *np.radians([rx, ry, rz])])


def last(plan: Plan) -> tuple[Array, Array]:
    """Position (3,) and rotation (3, 3) of the last target."""
    target = plan.moves.target[plan.row[np.nonzero(plan.kind == StepKind.MOVE)[0][-1]]]
    w, x, y, z = plan.positions.quaternion[target]
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return plan.positions.position[target], rotation


def reaches(plan: Plan, expected: Array) -> None:
    position, rotation = last(plan)
    assert not findings(plan), plan.diagnostics
    np.testing.assert_allclose(position, expected[:3, 3], atol=1e-9)
    np.testing.assert_allclose(rotation, expected[:3, :3], atol=1e-9)


def variables(**poses: Array | tuple[float, ...]) -> dict[tuple[Store, int], WrittenPosition]:
    """P variables in the base frame (numpy poses) or in pulses (tuples)."""
    base, pulse = PointState(PointKind.POSE, "base"), PointState(PointKind.PULSE)
    return {
        (Store.ROBOT, int(name[1:])): WrittenPosition(base if isinstance(v, np.ndarray) else pulse, tuple(v))
        for name, v in poses.items()
    }


P1 = pose(812.4, -133.7, 207.9, 171.3, 12.6, -37.2)
P2 = pose(34.1, 58.3, -21.7, 5.1, -3.3, 14.9)
GIVEN = Assumptions(variables=variables(P001=P1, P002=P2))


def test_elements_are_micrometres_and_ten_thousandths_of_a_degree() -> None:
    body = """
    SETE P001 (2) 300000
    SETE P001 (6) 900000
    GETE LD000 P001 (1)
    ADD LD000 1500
    SETE P001 (1) LD000
    MOVL P001 V=50.0
    """
    expected = pose(813.9, 300.0, 207.9, 171.3, 12.6, 90.0)
    reaches(plan_of(body, GIVEN), matrix(expected))


def test_elements_of_a_pulse_position_are_pulses() -> None:
    given = Assumptions(variables=variables(P003=(1200.0, -3400.0, 560.0, 70.0, -8000.0, 900.0)))
    plan = plan_of(
        "GETE LD000 P003 (2)\nSUB LD000 100\nSETE P003 (2) LD000\nMOVJ P003 VJ=25.00",
        given,
        robot="yaskawa/ma2010",
    )
    robot = load_robot("yaskawa/ma2010")
    joints = pulses_to_joints(robot, np.array([[1200.0, -3500.0, 560.0, 70.0, -8000.0, 900.0]]))
    np.testing.assert_allclose(plan.positions.axes[plan.moves.target[0]], joints[0], atol=1e-12)


def test_the_seventh_element_of_a_six_axis_position_is_zero() -> None:
    plan = plan_of("GETE LD000 P001 (7)\nIFTHENEXP LD000<>0\nTIMER T=1.00\nENDIF\nMOVL P001 V=50.0", GIVEN)
    assert len(plan) == 1


def test_an_element_beyond_all_axes_is_an_error() -> None:
    assert [code for code, _ in errors(plan_of("GETE LD000 P001 (9)", GIVEN))] == ["I210"]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("SET P003 P001\nADD P003 P002", P1 + P2),
        ("SET P003 P001\nSUB P003 P002", P1 - P2),
        ("SET P003 P002\nMUL P003 3", 3 * P2),
        ("SET P003 P002\nDIV P003 2", P2 / 2),
    ],
)
def test_arithmetic_on_positions_works_element_by_element(body: str, expected: Array) -> None:
    reaches(plan_of(f"{body}\nMOVL P003 V=50.0", GIVEN), matrix(expected))


def test_positions_of_different_kinds_are_not_added() -> None:
    given = Assumptions(variables=variables(P001=P1, P003=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)))
    assert [code for code, _ in errors(plan_of("ADD P001 P003", given))] == ["I211"]


def test_pose_product_and_inverse_are_those_of_matrices() -> None:
    reaches(plan_of("MULMAT P003 P001 P002\nMOVL P003 V=50.0", GIVEN), matrix(P1) @ matrix(P2))
    reaches(plan_of("INVMAT P003 P001\nMOVL P003 V=50.0", GIVEN), np.linalg.inv(matrix(P1)))


def test_a_frame_from_three_points_stands_where_they_say() -> None:
    given = Assumptions(
        variables=variables(
            P001=pose(500.0, 100.0, 200.0, 180.0, 0.0, 0.0),
            P002=pose(500.0, 300.0, 200.0, 180.0, 0.0, 0.0),
            P003=pose(450.0, 260.0, 200.0, 180.0, 0.0, 0.0),
        )
    )
    # x along base +y, the plane's third point towards base -x: y is -x, z is up
    rows = "///USER 7\n///POSTYPE USER\nC00050=10.000,20.000,30.000,0.0000,0.0000,0.0000"
    plan = plan_of("MFRAME UF#(7) P001 P002 P003\nMOVL C00050 V=50.0", given, rows=rows)
    expected = np.eye(4)
    expected[:3, :3] = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    expected[:3, 3] = [0.5 - 0.02, 0.1 + 0.01, 0.2 + 0.03]
    reaches(plan, expected)


def test_a_frame_that_is_redefined_moves_later_moves_only() -> None:
    given = Assumptions(
        variables=variables(
            P001=pose(500.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            P002=pose(600.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            P003=pose(500.0, 100.0, 0.0, 0.0, 0.0, 0.0),
            P011=pose(700.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            P012=pose(800.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            P013=pose(700.0, 100.0, 0.0, 0.0, 0.0, 0.0),
        )
    )
    rows = "///USER 7\n///POSTYPE USER\nC00050=10.000,20.000,30.000,0.0000,0.0000,0.0000"
    move = "MOVL C00050 V=50.0"
    plan = plan_of(
        f"MFRAME UF#(7) P001 P002 P003\n{move}\nMFRAME UF#(7) P011 P012 P013\n{move}", given, rows=rows
    )
    x = plan.positions.position[plan.moves.target, 0]
    np.testing.assert_allclose(x, [0.51, 0.71], atol=1e-12)


def test_three_points_on_a_line_are_no_frame() -> None:
    given = Assumptions(variables=variables(P001=P1, P002=P1, P003=P1))
    plan = plan_of("MFRAME UF#(7) P001 P002 P003\nMOVL C00001 V=50.0", given)
    assert errors(plan)[0][0] == "G001"
    assert errors(plan)[0][1] > 0
    assert len(plan) == 1


SHIFT = variables(P001=pose(20.0, -30.0, 40.0, 0.0, 0.0, 0.0))


def test_a_shift_moves_taught_targets_until_it_is_switched_off() -> None:
    plan = plan_of(
        "MOVL C00000 V=50.0\nSFTON P001 BF\nMOVL C00000 V=50.0\nSFTOF\nMOVL C00000 V=50.0",
        Assumptions(variables=SHIFT),
    )
    position = plan.positions.position[plan.moves.target]
    np.testing.assert_allclose(position[[0, 2]], [FIRST, FIRST], atol=1e-12)
    np.testing.assert_allclose(position[1], FIRST + np.array([0.02, -0.03, 0.04]), atol=1e-12)
    assert not findings(plan)


UFRAME = (
    b"//UFRAME 2\r\n///NAME PALLET\r\n///TOOL 1\r\n///GROUP 1,0,0,0\r\n"
    b"////BUSER 1043.271,-318.906,112.442,1.3100,-2.7200,38.4600\r\n"
)
FRAME = pose(1043.271, -318.906, 112.442, 1.31, -2.72, 38.46)


def test_a_shift_runs_along_the_axes_of_its_user_frame(tmp_path: Path) -> None:
    (tmp_path / "UFRAME.CND").write_bytes(UFRAME)
    (tmp_path / "olp.toml").write_text(
        "[variables]\nP001 = { pose_mm_deg = [20, -30, 40, 0, 0, 7.3] }\n", encoding="utf-8"
    )
    main = write_jobs(tmp_path, {"MAIN": "SFTON P001 UF#(2)\nMOVL C00000 V=50.0"})
    plan = run(read(main))
    frame = matrix(FRAME)[:3, :3]
    expected = np.eye(4)
    expected[:3, 3] = FIRST + frame @ [0.02, -0.03, 0.04]
    expected[:3, :3] = frame @ turn(0, 0, math.radians(7.3)) @ frame.T @ turn(*ANGLES)
    reaches(plan, expected)
    assert "turns the tool about its centre point" in said(plan)


def test_points_in_a_user_frame_are_carried_by_it(tmp_path: Path) -> None:
    (tmp_path / "UFRAME.CND").write_bytes(UFRAME)
    text = write_jobs(tmp_path, {"MAIN": "MOVL C00000 V=50.0"})
    content = text.read_bytes().replace(b"///POSTYPE BASE", b"///USER 2\r\n///POSTYPE USER")
    text.write_bytes(content)
    reaches(run(read(text)), matrix(FRAME) @ matrix(np.array([*FIRST, *ANGLES])))


def test_an_increment_in_the_base_frame_adds_along_its_axes() -> None:
    given = Assumptions(variables=SHIFT)
    plan = plan_of("MOVL C00000 V=50.0\nIMOV P001 V=50.0 BF\nIMOV P001 V=50.0 BF", given)
    expected = np.eye(4)
    expected[:3, 3], expected[:3, :3] = FIRST + 2 * np.array([0.02, -0.03, 0.04]), turn(*ANGLES)
    reaches(plan, expected)


def test_an_increment_in_the_tool_frame_adds_along_the_tool() -> None:
    given = Assumptions(variables=variables(P001=pose(20.0, -30.0, 40.0, 4.0, 0.0, 11.0)))
    plan = plan_of("MOVL C00000 V=50.0\nIMOV P001 V=50.0 TF", given)
    start = matrix(np.array([*FIRST, *ANGLES]))
    reaches(plan, start @ matrix(pose(20.0, -30.0, 40.0, 4.0, 0.0, 11.0)))


def test_an_increment_in_pulses_adds_to_the_pulses_of_the_arm() -> None:
    start, by = (1200.0, -3400.0, 560.0, 70.0, -8000.0, 900.0), (100.0, 200.0, -300.0, 0.0, 50.0, -7.0)
    plan = plan_of(
        "MOVJ P001 VJ=25.00\nIMOV P002 VJ=25.00",
        Assumptions(variables=variables(P001=start, P002=by)),
        robot="yaskawa/ma2010",
    )
    joints = pulses_to_joints(load_robot("yaskawa/ma2010"), np.array([np.add(start, by)]))
    np.testing.assert_allclose(plan.positions.axes[plan.moves.target[1]], joints[0], atol=1e-12)
    assert not findings(plan)


def test_an_increment_before_any_move_needs_a_start_position() -> None:
    plan = plan_of("IMOV P001 V=50.0 BF", GIVEN)
    assert findings(plan)[0] == "I215"
    assert not len(plan)
    start = {"RB1": WrittenPosition(PointState(PointKind.POSE, "base"), tuple(P1))}
    reaches(
        plan_of("IMOV P002 V=50.0 TF", Assumptions(variables=GIVEN.variables, start=start)),
        matrix(P1) @ matrix(P2),
    )


PULSES = (2242.0, -15910.0, -30274.0, 1525.0, -51078.0, 9460.0)


def test_the_current_position_is_known_in_pulses_and_as_a_pose() -> None:
    given = Assumptions(variables=variables(P001=PULSES))
    body = """
    MOVJ P001 VJ=25.00
    GETS PX010 $PX000
    GETS PX011 $PX001
    MOVL C00000 V=50.0
    MOVJ P010 VJ=25.00
    MOVL C00000 V=50.0
    MOVL P011 V=50.0
    """
    plan = plan_of(body, given, robot="yaskawa/ma2010")
    assert not findings(plan)
    robot = load_robot("yaskawa/ma2010")
    position, rotation = forward(robot, pulses_to_joints(robot, np.array([PULSES])))
    axes = plan.positions.axes[plan.moves.target]
    np.testing.assert_allclose(axes[2], axes[0], atol=1e-12)
    target = plan.positions.position[plan.moves.target]
    np.testing.assert_allclose(target[4], position[0], atol=1e-9)
    np.testing.assert_allclose(last(plan)[1], rotation[0], atol=1e-9)


def test_converting_to_a_frame_and_back_to_pulses_gives_the_same_pulses() -> None:
    given = Assumptions(variables=variables(P001=PULSES))
    body = """
    CNVRT P002 P001 BF
    GETE LD000 P002 (1)
    CNVRT P003 P002
    GETE LD001 P003 (5)
    TIMER T=LD000
    MUL LD001 -1
    TIMER T=LD001
    MOVL P002 V=50.0
    """
    plan = plan_of(body, given, robot="yaskawa/ma2010")
    robot = load_robot("yaskawa/ma2010")
    position, _ = forward(robot, pulses_to_joints(robot, np.array([PULSES])))
    seconds = [float(plan.durations[plan.row[i]]) for i in range(2)]
    assert seconds[0] * 100 == pytest.approx(round(position[0, 0] * 1e6), abs=1)
    assert seconds[1] * 100 == pytest.approx(51078, abs=1)
    np.testing.assert_allclose(last(plan)[0], position[0], atol=1e-9)


def test_a_conversion_without_a_robot_says_what_is_missing() -> None:
    plan = plan_of("CNVRT P002 P001 BF", Assumptions(variables=variables(P001=PULSES)))
    assert errors(plan)[0][0] == "I212"
    assert "--robot" in plan.diagnostics[0].help


def test_a_tool_that_is_set_holds_for_later_moves_only() -> None:
    given = Assumptions(variables=variables(P001=PULSES, P002=pose(0.0, 0.0, 150.0, 0.0, 0.0, 0.0)))
    plan = plan_of(
        "MOVJ P001 VJ=25.00\nSETTOOL TL#(0) P002\nMOVJ P001 VJ=25.00", given, robot="yaskawa/ma2010"
    )
    robot = load_robot("yaskawa/ma2010")
    flange, rotation = forward(robot, pulses_to_joints(robot, np.array([PULSES])))
    target = plan.positions.position[plan.moves.target]
    np.testing.assert_allclose(target[0], flange[0], atol=1e-9)
    np.testing.assert_allclose(target[1], flange[0] + rotation[0] @ [0, 0, 0.15], atol=1e-9)


def test_a_tool_that_is_set_to_what_it_holds_parts_no_arc() -> None:
    places = {
        "P001": P1,
        "P002": P1 + pose(40.0, 30.0, 5.0, 0.0, 0.0, 0.0),
        "P003": P1 + pose(85.0, -10.0, 12.0, 0.0, 0.0, 0.0),
        "P005": pose(12.5, -8.25, 187.4, 0.0, 15.0, 30.0),
    }
    tool = "SETTOOL TL#(0) P005\n"
    arc = "GETS PX006 $PX001\nMOVC P006 V=50.0\nMOVC P002 V=50.0\nMOVC P003 V=50.0"
    given = Assumptions(variables=variables(**places))
    once, twice = (
        plan_of(f"{tool}MOVL P001 V=50.0\n{again}{arc}", given, robot="yaskawa/ma2010")
        for again in ("", tool)
    )
    assert (once.moves.via[-2:] >= 0).all()
    np.testing.assert_array_equal(twice.moves.via[-2:], once.moves.via[-2:])
    np.testing.assert_allclose(twice.moves.length, once.moves.length, atol=1e-12)


def test_a_position_variable_of_the_header_is_set_before_anything_runs(tmp_path: Path) -> None:
    main = write_jobs(tmp_path, {"MAIN": "SETE P030 (1) 700000\nCALL JOB:SUB", "SUB": "MOVL P030 V=50.0"})
    sub = tmp_path / "SUB.JBI"
    row = b"//INST"
    sub.write_bytes(
        sub.read_bytes().replace(row, b"P00030=1.000,2.000,3.000,0.0000,0.0000,0.0000\r\n" + row, 1)
    )
    (tmp_path / "olp.toml").write_text(
        "[variables]\nP030 = { pose_mm_deg = [9, 8, 7, 0, 0, 0] }\n", encoding="utf-8"
    )
    plan = run(read(main))
    # what the caller computed before the call is not undone by it
    np.testing.assert_allclose(last(plan)[0], [0.7, 0.008, 0.007], atol=1e-12)


def test_a_move_to_a_position_without_a_value_is_left_out_which_is_told_with_how_to_give_one() -> None:
    plan = plan_of("MOVL P077 V=50.0\nMOVL C00001 V=50.0")
    assert not errors(plan)
    assert plan.diagnostics[0].code == "I203"
    assert "left out" in plan.diagnostics[0].message
    assert "[variables] P077" in plan.diagnostics[0].help
    assert len(plan) == 1


def test_elements_set_one_by_one_make_a_cartesian_position_which_is_reported() -> None:
    plan = plan_of("SETE P077 (3) 5000\nMOVL C00000 V=50.0\nIMOV P077 V=50.0 BF")
    assert "P077 has no value yet" in said(plan)
    np.testing.assert_allclose(last(plan)[0], FIRST + np.array([0, 0, 0.005]), atol=1e-12)


def test_the_points_of_a_relative_job_stand_in_its_own_frame(tmp_path: Path) -> None:
    (tmp_path / "UFRAME.CND").write_bytes(UFRAME)
    text = write_jobs(tmp_path, {"MAIN": "MOVL C00000 V=50.0"})
    content = text.read_bytes().replace(b"///POSTYPE BASE", b"///POSTYPE USER")
    text.write_bytes(content.replace(b"///ATTR SC,RW", b"///ATTR SC,RW,RJ\r\n////FRAME USER 2"))
    plan = run(read(text))
    assert not errors(plan)
    np.testing.assert_allclose(last(plan)[0], (matrix(FRAME) @ [*FIRST, 1.0])[:3], atol=1e-9)


def test_a_shift_is_converted_into_the_axes_of_another_frame(tmp_path: Path) -> None:
    (tmp_path / "UFRAME.CND").write_bytes(UFRAME)
    (tmp_path / "olp.toml").write_text(
        "[variables]\nP001 = { pose_mm_deg = [20, -30, 40, 0, 0, 7.3] }\n", encoding="utf-8"
    )
    main = write_jobs(tmp_path, {"MAIN": "CONVSFT P002 P001 UF#(2)\nSFTON P002 UF#(2)\nMOVL C00000 V=50.0"})
    expected = np.eye(4)
    expected[:3, 3] = FIRST + np.array([0.02, -0.03, 0.04])
    expected[:3, :3] = turn(0, 0, math.radians(7.3)) @ turn(*ANGLES)
    reaches(run(read(main)), expected)


def test_the_shift_between_two_positions_takes_one_to_the_other() -> None:
    plan = plan_of("MSHIFT P003 BF P001 P002\nMOVL P001 V=50.0\nIMOV P003 V=50.0 BF", GIVEN)
    reaches(plan, matrix(P2))


def test_matrices_of_pulses_are_refused() -> None:
    given = Assumptions(variables=variables(P001=PULSES, P002=P2))
    for body in ("MULMAT P003 P001 P002", "INVMAT P003 P001"):
        assert [code for code, _ in errors(plan_of(body, given))] == ["I213"]


def test_a_position_divided_by_zero_is_an_error() -> None:
    assert [code for code, _ in errors(plan_of("DIV P001 0", GIVEN))] == ["I207"]


def test_the_position_of_a_step_can_be_fetched() -> None:
    plan = plan_of("GETPOS PX010 STEP#(2)\nMOVL C00003 V=50.0\nMOVL C00005 V=50.0\nMOVL P010 V=50.0")
    target = plan.positions.position[plan.moves.target]
    np.testing.assert_allclose(target[2], target[1], atol=1e-12)
    assert [code for code, _ in errors(plan_of("GETPOS PX010 STEP#(2)\nMOVL C00003 V=50.0"))] == ["I217"]


VARIABLES = (
    b"//VAR\r\n///PFNUM 6,0,0\r\n///SHARE 0,0,0,0,0,3,0,0\r\n///P\r\n"
    b'"PULSE"0,0,0,0,0,0,2242,-15910,-30274,1525,-51078,9460\r\n'
    b'"BASE"0,0,0,0,0,0,812.400,-133.700,207.900,171.3000,12.6000,-37.2000\r\n"UNUSED"\r\n'
)


def test_positions_of_var_dat_are_read_as_pulses_or_poses(tmp_path: Path) -> None:
    (tmp_path / "VAR.DAT").write_bytes(VARIABLES)
    main = write_jobs(tmp_path, {"MAIN": "MOVJ P000 VJ=25.00\nMOVL P001 V=50.0"})
    plan = run(read(main), "yaskawa/ma2010")
    robot = load_robot("yaskawa/ma2010")
    joints = pulses_to_joints(robot, np.array([PULSES]))
    np.testing.assert_allclose(plan.positions.axes[plan.moves.target[0]], joints[0], atol=1e-12)
    reaches(plan, matrix(P1))


def test_the_header_of_a_called_job_wins_over_var_dat(tmp_path: Path) -> None:
    (tmp_path / "VAR.DAT").write_bytes(VARIABLES)
    main = write_jobs(tmp_path, {"MAIN": "CALL JOB:SUB", "SUB": "MOVL P001 V=50.0"})
    sub = tmp_path / "SUB.JBI"
    row = b"//INST"
    sub.write_bytes(
        sub.read_bytes().replace(row, b"P00001=1.000,2.000,3.000,0.0000,0.0000,0.0000\r\n" + row, 1)
    )
    np.testing.assert_allclose(last(run(read(main)))[0], [0.001, 0.002, 0.003], atol=1e-12)


def test_the_current_position_includes_the_table() -> None:
    body = "MOVJ C00050  +MOVJ EC00000\nGETS PX010 $PX000\nGETE LD000 EX010 (1)\nTIMER T=LD000"
    plan = plan_of(
        "SPEED VJ=20.00\n" + body,
        robot="yaskawa/ma2010",
        header="///GROUP1 RB1\n///GROUP2 ST1",
        rows="///POSTYPE PULSE\n///PULSE\nC00050=2242,-15910,-30274,1525,-51078,9460\nEC00000=8820,902",
    )
    assert float(plan.durations[-1]) == pytest.approx(88.20)


def test_a_position_converted_into_a_user_frame_is_the_same_place(tmp_path: Path) -> None:
    (tmp_path / "UFRAME.CND").write_bytes(UFRAME)
    (tmp_path / "olp.toml").write_text(
        "[variables]\nP001 = { pose_mm_deg = [812.4, -133.7, 207.9, 171.3, 12.6, -37.2] }\n", encoding="utf-8"
    )
    body = "CNVRT P002 P001 UF#(2)\nGETE LD000 P002 (1)\nADD LD000 1000000\nTIMER T=LD000\nMOVL P002 V=50.0"
    plan = run(read(write_jobs(tmp_path, {"MAIN": body})))
    seen = np.linalg.inv(matrix(FRAME)) @ matrix(P1)
    assert float(plan.durations[0]) * 100 == pytest.approx(1e6 + seen[0, 3] * 1e6, abs=1)
    reaches(plan, matrix(P1))


def test_a_taught_point_can_be_copied_into_a_variable() -> None:
    plan = plan_of("SET P010 C00003\nMOVL C00003 V=50.0\nMOVL P010 V=50.0")
    target = plan.positions.position[plan.moves.target]
    np.testing.assert_allclose(target[1], target[0], atol=1e-12)
    assert not findings(plan)


def test_a_shift_in_the_tool_frame_leads_from_the_first_position_to_the_second() -> None:
    plan = plan_of("MSHIFT PX003 TF PX001 PX002\nMOVL P001 V=50.0\nIMOV P003 V=50.0 TF", GIVEN)
    reaches(plan, matrix(P2))


def test_a_shift_in_a_frame_that_moves_along_is_taken_unchanged_and_reported() -> None:
    plan = plan_of("CONVSFT P003 P002 P001 MTF\nMOVL P003 V=50.0", GIVEN)
    assert "master-tool frame is taken unchanged" in said(plan)
    reaches(plan, matrix(P2))
