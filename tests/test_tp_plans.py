"""What FANUC programs do, against scipy's rotations: frames, tools, offsets, registers, arcs, times."""

from __future__ import annotations

from math import radians
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tp_listings import listing, read

from olp.fluent import read as read_file
from olp.robots.kinematics import forward
from olp.robots.robot import load_robot
from olp.runtime.assumptions import Assumptions
from olp.runtime.plan import Plan

ROBOT = "yaskawa/gp25"  # any arm: what is asked here are poses
FRAME = (850.5, -210.25, 305.75, 1.5, -2.25, 33.0)
TOOL = (12.5, -8.25, 187.4, 0.0, 15.0, 30.0)
SAMPLE = Path(__file__).parent.parent / "samples" / "tp" / "handling.ls"


def si(pose):
    return (*(value / 1000 for value in pose[:3]), *map(radians, pose[3:]))


CELL = Assumptions(frames={1: si(FRAME)}, tools={2: si(TOOL)})


def matrix(pose):
    """x y z [mm], W P R [deg] as a homogeneous matrix in metres: R = Rz(R) Ry(P) Rx(W)."""
    made = np.eye(4)
    made[:3, :3] = Rotation.from_euler("xyz", pose[3:], degrees=True).as_matrix()
    made[:3, 3] = np.array(pose[:3]) / 1000
    return made


def point(number):
    """Where POSITION of tp_listings stands, as it is written."""
    return (100.25 * number, 12.5, -0.384, 178.5, 3.25, -21.5)


def plan_of(*instructions, **more) -> Plan:
    plan = read(listing(*instructions, **more)).plan(robot=ROBOT, assumptions=CELL)
    errors = [one.render() for one in plan.diagnostics if one.is_error]
    assert not errors, errors
    return plan


def reached(plan: Plan):
    """(n, 4, 4): where the tool stands behind each move."""
    rows = plan.moves.target
    made = np.tile(np.eye(4), (len(rows), 1, 1))
    w, x, y, z = plan.positions.quaternion[rows].T
    made[:, :3, :3] = Rotation.from_quat(np.stack([x, y, z, w], axis=1)).as_matrix()
    made[:, :3, 3] = plan.positions.position[rows]
    return made


def assert_at(plan: Plan, *expected) -> None:
    found = reached(plan)
    assert len(found) == len(expected)
    for here, wanted in zip(found, expected, strict=True):
        np.testing.assert_allclose(here, wanted, atol=1e-9)


def test_a_position_stands_in_its_frame() -> None:
    assert_at(
        plan_of("L P[1] 100mm/sec FINE", "L P[2] 100mm/sec FINE"),
        *(matrix(FRAME) @ matrix(point(n)) for n in (1, 2)),
    )


def test_a_register_chooses_the_point_and_a_number_that_nobody_taught_is_told() -> None:
    plan = plan_of(
        "R[7]=1", "L P[R[7]] 100mm/sec FINE", "R[7]=R[7]+1", "PR[5]=P[R[7]]", "L PR[5] 100mm/sec FINE"
    )
    assert_at(plan, *(matrix(FRAME) @ matrix(point(n)) for n in (1, 2)))
    lost = read(listing("R[7]=9", "L P[R[7]] 100mm/sec FINE")).plan(robot=ROBOT, assumptions=CELL)
    assert [found.code for found in lost.diagnostics if found.is_error] == ["I206"]


def test_what_is_missing_is_asked_for_in_files_that_the_controller_has() -> None:
    plan = read(listing("PR[5]=P[1]", "L PR[5] 100mm/sec FINE", "PR[5]=PR[6]")).plan(robot=ROBOT)
    said = [found.help for found in plan.diagnostics] + [it.says for it in plan.assumptions]
    for asked in ("[frames] in olp.toml", "[tools] in olp.toml", "in olp.toml: [variables]"):
        assert any(asked in it for it in said)
    assert not any(".CND" in it or "VAR.DAT" in it for it in said)


def test_an_offset_is_added_in_the_frame_and_a_tool_offset_along_the_tool() -> None:
    offset, by_tool = (10.0, -20.0, 30.0, 4.0, 5.0, -6.0), (3.0, 4.0, -25.0, 0.0, 10.0, 0.0)
    lines = [
        f"PR[{n},{i}]=({value})" for n, pose in ((3, offset), (4, by_tool)) for i, value in enumerate(pose, 1)
    ]
    plan = plan_of(
        *lines,
        "L P[1] 100mm/sec FINE Offset,PR[3]",
        "L P[1] 100mm/sec FINE Tool_Offset,PR[4]",
        "L P[1] 100mm/sec FINE Offset,PR[3] Tool_Offset,PR[4]",
    )
    base = matrix(FRAME)
    assert_at(
        plan,
        base @ matrix(offset) @ matrix(point(1)),
        base @ matrix(point(1)) @ matrix(by_tool),
        base @ matrix(offset) @ matrix(point(1)) @ matrix(by_tool),
    )


def test_a_register_that_got_a_point_and_a_component_more() -> None:
    plan = plan_of("PR[5]=P[2]", "PR[5,3]=PR[5,3]+40", "PR[5,6]=(-45)", "L PR[5] 100mm/sec FINE")
    x, y, z, w, p, _ = point(2)
    assert_at(plan, matrix(FRAME) @ matrix((x, y, z + 40, w, p, -45.0)))


def test_a_computed_register_stands_in_the_selected_frame() -> None:
    lines = [f"PR[6,{i}]=({value})" for i, value in enumerate(point(3), 1)]
    there = matrix(point(3))
    assert_at(plan_of("UFRAME_NUM=1", "UTOOL_NUM=2", *lines, "L PR[6] 100mm/sec FINE"), matrix(FRAME) @ there)
    assert_at(plan_of("UFRAME_NUM=0", "UTOOL_NUM=2", *lines, "L PR[6] 100mm/sec FINE"), there)


def test_the_selected_frame_of_a_point_that_names_none() -> None:
    text = listing("UFRAME_NUM=1", "UTOOL_NUM=2", "L P[1] 100mm/sec FINE")
    plan = read(text.replace("UF : 1, UT : 2", "UF : F, UT : F")).plan(robot=ROBOT, assumptions=CELL)
    assert_at(plan, matrix(FRAME) @ matrix(point(1)))


def test_the_same_joints_are_reached_with_the_tool() -> None:
    """Axes of the pose: flange = target * inverse(tool)."""
    plan = plan_of("J P[1] 50% FINE", "PR[1]=JPOS", "UFRAME_NUM=0", "UTOOL_NUM=0", "J PR[1] 50% FINE")
    flange = matrix(FRAME) @ matrix(point(1)) @ np.linalg.inv(matrix(TOOL))
    np.testing.assert_allclose(reached(plan)[1], flange, atol=1e-6)


def test_an_incremental_position_is_added_to_where_the_arm_stands() -> None:
    plan = plan_of("UFRAME_NUM=1", "UTOOL_NUM=2", "L P[1] 100mm/sec FINE", "L P[2] 100mm/sec FINE INC")
    x, y, z = (point(1)[i] + point(2)[i] for i in range(3))
    np.testing.assert_allclose(
        reached(plan)[1][:3, 3], (matrix(FRAME) @ [x / 1e3, y / 1e3, z / 1e3, 1])[:3], atol=1e-9
    )


def test_speeds_times_and_corners() -> None:
    plan = plan_of(
        "OVERRIDE=100%",
        "J P[1] 25% FINE",
        "L P[2] 120cm/min CNT50",
        "L P[3] 2.5sec CR12",
        "L P[4] 90deg/sec CNT100 ACC50",
    )
    moves = plan.moves
    assert moves.fraction[0] == pytest.approx(0.25)
    assert moves.travel[1] == pytest.approx(0.02)
    assert moves.turn[3] == pytest.approx(radians(90))
    kinds = [step.blend_code.name for step in plan.steps()]
    assert kinds == ["EXACT", "ZONE", "RADIUS", "ZONE"]
    assert [step.blend for step in plan.steps()][1:] == pytest.approx([0.5, 0.012, 1.0])


def test_a_straight_move_with_a_speed_in_percent_is_slow_and_told() -> None:
    plan = plan_of("J P[1] 25% FINE", "L P[2] 100% FINE", "L P[3] 100mm/sec FINE")
    assert plan.moves.travel[1:] == pytest.approx([0.25, 0.1])
    (told,) = [one for one in plan.diagnostics if one.code == "I309"]
    assert "L P[2] 100% FINE" in told.source_line
    assert np.isfinite(plan.durations).all()


def waits(plan: Plan):
    return [step.duration for step in plan.steps() if type(step).__name__ == "WaitStep"]


def test_counting_jumping_and_choosing() -> None:
    program = (
        "R[1]=0",
        "LBL[1:again]",
        "R[1]=R[1]+1",
        "FOR R[2]=1 TO 2",
        "WAIT R[2]",
        "ENDFOR",
        "IF R[1]<2,JMP LBL[1]",
        "SELECT R[1]=1,JMP LBL[99]",
        "       =2,JMP LBL[2]",
        "LBL[99]",
        "WAIT 99.0(sec)",
        "LBL[2]",
        "R[3]=(R[1]*10+7 MOD 4)",
        "JMP LBL[R[3]]",
        "LBL[23]",
        "IF (R[1]=2 AND !DI[1]) THEN",
        "WAIT .25(sec)",
        "ELSE",
        "WAIT 77.0(sec)",
        "ENDIF",
        "END",
        "WAIT 88.0(sec)",
    )
    assert waits(plan_of(*program)) == pytest.approx([1, 2, 1, 2, 0.25])


def test_arguments_reach_the_called_program() -> None:
    text = listing("CALL OTHER(1.5,R[7])") + listing("WAIT AR[1]", "R[4]=AR[2]+2", "WAIT R[4]").replace(
        "PART", "OTHER"
    )
    assert waits(read(text).plan(robot=ROBOT)) == pytest.approx([1.5, 2.0])


def test_and_binds_before_or() -> None:
    lines = (
        "F[1]=(ON)",
        "F[2]=(OFF)",
        "F[3]=(OFF)",
        "IF (F[1] OR F[2] AND F[3]) THEN",
        "WAIT 1.0(sec)",
        "ENDIF",
    )
    assert waits(plan_of(*lines)) == [1.0]
    assert waits(plan_of(*(line.replace("F[1] OR F[2]", "(F[1] OR F[2])") for line in lines))) == []


def test_the_sample_runs_all_its_steps() -> None:
    plan = read_file(SAMPLE).plan(robot=ROBOT)
    assert not [one.render() for one in plan.diagnostics if one.is_error]
    kinds = [type(step).__name__[0] for step in plan.steps()]
    assert "".join(kinds) == "MSMMSWMMMWMMSWM"
    arc = next(step for step in plan.steps() if "C P[1" in step.statement)
    assert arc.path == "circular"
    assert arc.length > 0.16


# What samples/tp says in words: the frames and tools that the program gives itself, and where it goes in them.
TABLE, RACK = (850.5, -210.25, 305.75, 1.5, -2.25, 33.0), (420.0, 640.5, 512.0, 0.0, 0.0, 90.5)
GRIPPER, PROBE = (12.5, -8.25, 187.4, 0.0, 15.0, 30.0), (-31.0, 4.5, 220.75, 10.0, -5.0, 62.0)
HOME = (5.5, -12.25, 18.75, 3.5, -47.25, 21.0)
ABOVE, PICK = (110.5, 45.25, 160.0, 178.5, 3.25, -21.5), (110.5, 45.25, 20.125, 178.5, 3.25, -21.5)
BEHIND, SHELF = (260.25, 60.0, 40.5, 170.5, -4.0, 18.0), (55.5, -20.25, 88.0, 160.0, 12.5, -75.0)


def test_the_sample_goes_where_it_says() -> None:
    plan = read_file(SAMPLE).plan(robot=ROBOT)
    lifted = [(*PICK[:2], PICK[2] + 40 * step, *PICK[3:]) for step in (1, 2, 3)]
    on_table = [matrix(TABLE) @ matrix(pose) for pose in (ABOVE, PICK, *lifted, BEHIND)]
    found = reached(plan)
    np.testing.assert_allclose(found[1:7], on_table, atol=1e-9)
    np.testing.assert_allclose(found[7], matrix(RACK) @ matrix(SHELF), atol=1e-9)
    axes = plan.positions.axes[plan.moves.target]
    np.testing.assert_allclose(np.degrees(axes[[0, 8]]), [HOME, HOME], atol=1e-9)


def test_the_sample_goes_there_with_its_tools() -> None:
    """The flange of each pose, by the axes that reach it, is target * inverse(tool)."""
    plan = read_file(SAMPLE).plan(robot=ROBOT)
    axes = plan.positions.axes[plan.moves.target]
    positions, rotations = forward(load_robot(ROBOT), axes[[1, 7]])
    wanted = (
        matrix(TABLE) @ matrix(ABOVE) @ np.linalg.inv(matrix(GRIPPER)),
        matrix(RACK) @ matrix(SHELF) @ np.linalg.inv(matrix(PROBE)),
    )
    for position, rotation, flange in zip(positions, rotations, wanted, strict=True):
        np.testing.assert_allclose(position, flange[:3, 3], atol=1e-6)
        np.testing.assert_allclose(rotation, flange[:3, :3], atol=1e-6)


def test_the_sample_waits_and_switches_as_it_says() -> None:
    plan = read_file(SAMPLE).plan(robot=ROBOT)
    assert waits(plan) == pytest.approx([0.35, 0.0, 0.1])
    switched = [
        step.statement.split("  ", 1)[1] for step in plan.steps() if type(step).__name__ == "SignalStep"
    ]
    assert switched == ["DO[3:gripper]=OFF ;", "DO[3:gripper]=ON ;", "DO[3:gripper]=OFF ;"]
    assert plan.moves.travel[[2, 3, 6, 7]] == pytest.approx([0.25, 0.1205, 0.15, 0.3])
    assert plan.moves.fraction[[0, 1, 8]] == pytest.approx([0.4, 0.55, 0.4])
