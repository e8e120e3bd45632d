"""KRL programs run: conventions against independent mathematics, modal variables, the common sample."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from krl_programs import again, read
from scipy.spatial.transform import Rotation

import olp
from olp.fluent import run as run_program
from olp.ir.program import Program
from olp.runtime.plan import BlendCode, Plan

SAMPLES = Path(__file__).resolve().parent.parent / "samples" / "krl"
ROBOT = "yaskawa/gp25"
DAT = [
    "DECL E6POS XP1={X 110.5,Y 45.25,Z 160.0,A -21.5,B 3.25,C 178.5}",
    "DECL E6POS XP2={X 130.25,Y 61.75,Z 120.5,A 18.0,B -4.0,C 170.5}",
    "DECL FRAME TBL={X 850.5,Y -210.25,Z 305.75,A 33.0,B -2.25,C 1.5}",
    "DECL FRAME GRP={X 12.5,Y -8.25,Z 187.4,A 30.0,B 15.0,C 0.0}",
]


def run(*lines: str) -> Plan:
    program = read(*lines, dat=DAT)
    assert not [d.render() for d in program.diagnostics if d.is_error]
    return plan_of(program)


def plan_of(program: Program) -> Plan:
    plan = run_program(program, ROBOT)
    assert not [d.render() for d in plan.diagnostics if d.is_error]
    return plan


def frame(x: float, y: float, z: float, a: float, b: float, c: float) -> np.ndarray:
    """KUKA's manuals: A turns about z, then B about the new y, then C about the new x; [m]."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("ZYX", [a, b, c], degrees=True).as_matrix()
    matrix[:3, 3] = np.array([x, y, z]) / 1000
    return matrix


TABLE = frame(850.5, -210.25, 305.75, 33.0, -2.25, 1.5)
P1 = frame(110.5, 45.25, 160.0, -21.5, 3.25, 178.5)
P2 = frame(130.25, 61.75, 120.5, 18.0, -4.0, 170.5)


def poses(plan: Plan) -> list[np.ndarray]:
    """The target of each move as a matrix in the base."""
    found = []
    for row in plan.moves.target:
        matrix = np.eye(4)
        matrix[:3, :3] = Rotation.from_quat(_scalar_last(plan.positions.quaternion[row])).as_matrix()
        matrix[:3, 3] = plan.positions.position[row]
        found.append(matrix)
    return found


def _scalar_last(quaternion: np.ndarray) -> np.ndarray:
    w, x, y, z = quaternion
    return np.array([x, y, z, w])


def test_a_pose_stands_in_the_base_that_holds() -> None:
    plan = run("$TOOL=GRP", "$BASE=TBL", "PTP XP1", "LIN XP2", "$BASE=$NULLFRAME", "LIN TBL:XP1")
    for found, wanted in zip(poses(plan), [TABLE @ P1, TABLE @ P2, TABLE @ P1], strict=True):
        np.testing.assert_allclose(found, wanted, atol=1e-9)


def test_frames_are_composed_from_left_to_right() -> None:
    shift = "{X 10.5,Y -20.25,Z 30.125,A 12.0,B 25.0,C 38.0}"
    plan = run("$BASE=TBL", f"$TOOL={shift}:GRP", "PTP XP1", f"LIN XP1:{shift}", f"LIN INV_POS({shift}):XP1")
    step = frame(10.5, -20.25, 30.125, 12.0, 25.0, 38.0)
    wanted = [TABLE @ P1, TABLE @ P1 @ step, TABLE @ np.linalg.inv(step) @ P1]
    for found, expected in zip(poses(plan), wanted, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-9)


def test_a_missing_component_keeps_its_value() -> None:
    plan = run("$TOOL=GRP", "$BASE=TBL", "PTP XP1", "LIN {Z 60.5,A 5.5}")
    expected = TABLE @ frame(110.5, 45.25, 60.5, 5.5, 3.25, 178.5)
    np.testing.assert_allclose(poses(plan)[1], expected, atol=1e-6)


def test_components_of_positions_are_numbers_in_mm_and_deg() -> None:
    plan = run(
        "$TOOL=GRP", "$BASE=TBL", "XP2=XP1", "XP2.Z=XP1.Z-40", "XP2.A=XP2.A+10", "XP2.C=170", "PTP XP2"
    )
    expected = TABLE @ frame(110.5, 45.25, 120.0, -11.5, 3.25, 170.0)
    np.testing.assert_allclose(poses(plan)[0], expected, atol=1e-9)


def test_a_relative_move_is_added_in_the_base_or_in_the_tool() -> None:
    plan = run("$TOOL=GRP", "$BASE=TBL", "PTP XP1", "LIN_REL {X 10,Z -20}", "LIN_REL {Z -15} #TOOL")
    base, tool = TABLE[:3, :3] @ [0.010, 0, -0.020], (TABLE @ P1)[:3, :3] @ [0, 0, -0.015]
    start, first, second = (pose[:3, 3] for pose in poses(plan))
    np.testing.assert_allclose(first - start, base, atol=1e-9)
    np.testing.assert_allclose(second - first, tool, atol=1e-9)


def test_axes_are_degrees() -> None:
    plan = run("PTP {A1 5.5,A2 -12.25,A3 18.75,A4 3.5,A5 -47.25,A6 21}")
    axes = plan.positions.axes[plan.moves.target[0], :6]
    np.testing.assert_allclose(np.degrees(axes), [5.5, -12.25, 18.75, 3.5, -47.25, 21], atol=1e-12)


def test_speeds_are_percent_and_metres_per_second() -> None:
    plan = run(
        "$TOOL=GRP",
        "$BASE=TBL",
        "BAS(#VEL_PTP,55)",
        "PTP XP1",
        "$VEL.CP=0.25",
        "LIN XP2",
        "$VEL.CP=0.1205",
        "LIN XP1",
    )
    assert plan.moves.fraction[0] == pytest.approx(0.55)
    assert list(plan.moves.travel[1:]) == pytest.approx([0.25, 0.1205])


def test_blends_have_the_sizes_that_hold() -> None:
    plan = run(
        "$TOOL=GRP",
        "$BASE=TBL",
        "PTP XP1",
        "$APO.CDIS=12.5",
        "LIN XP2 C_DIS",
        "$APO.CDIS=7",
        "LIN XP1 C_DIS",
        "LIN XP2",
    )
    assert list(plan.moves.blend)[1:3] == pytest.approx([0.0125, 0.007])
    assert [int(code) for code in plan.moves.blend_code][0::3] == [0, 0]


def test_loops_and_waits_run() -> None:
    plan = run("$TOOL=GRP", "$BASE=TBL", "PTP XP1", "n=2", "WHILE n>0", "n=n-1", "WAIT SEC 0.25", "ENDWHILE")
    waits = [step for step in plan.steps() if type(step).__name__ == "WaitStep"]
    assert [w.duration for w in waits] == pytest.approx([0.25, 0.25])  # type: ignore[union-attr]


# --- the common sample -----------------------------------------------------------------------------------


def test_the_sample_goes_where_its_numbers_say() -> None:
    plan = plan_of(olp.read(SAMPLES / "handling.src"))
    rack = frame(420.0, 640.5, 512.0, 90.5, 0.0, 0.0)
    lifted = [TABLE @ frame(110.5, 45.25, 20.125 + 40 * n, -21.5, 3.25, 178.5) for n in (0, 1, 2, 3)]
    wanted = [
        TABLE @ P1,
        *lifted,
        TABLE @ frame(260.25, 60.0, 40.5, 18.0, -4.0, 170.5),
        rack @ frame(55.5, -20.25, 88.0, -75.0, 12.5, 160.0),
    ]
    found = poses(plan)
    home = [5.5, -12.25, 18.75, 3.5, -47.25, 21.0]
    for move in (0, -1):
        axes = plan.positions.axes[plan.moves.target[move], :6]
        np.testing.assert_allclose(np.degrees(axes), home, atol=1e-9)
    for pose, expected in zip(found[1:-1], wanted, strict=True):
        np.testing.assert_allclose(pose, expected, atol=1e-9)
    assert list(plan.moves.fraction[[0, 1, -1]]) == pytest.approx([0.4, 0.55, 0.4])
    assert list(plan.moves.travel[2:8]) == pytest.approx([0.25, 0.1205, 0.1205, 0.1205, 0.15, 0.3])
    assert list(plan.moves.blend[[1, 3, 4, 6]]) == pytest.approx([0.025, 0.005, 0.005, 0.010])
    assert plan.moves.blend_code[5] == BlendCode.EXACT  # the loop that follows reads an input
    waits = [step.duration for step in plan.steps() if type(step).__name__ == "WaitStep"]  # type: ignore[union-attr]
    assert waits == pytest.approx([0.35, 0.0, 0.1])


def test_the_sample_written_again_does_the_same() -> None:
    program = olp.read(SAMPLES / "handling.src")
    first, second = plan_of(program), plan_of(again(program))
    for one, other in zip(poses(first), poses(second), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)
    assert [type(s).__name__ for s in first.steps()] == [type(s).__name__ for s in second.steps()]


def test_an_arc_with_an_angle_starts_where_another_ended() -> None:
    """A quarter of a circle, a half of the same circle, and the chord back to the first point."""
    at = "{{X {},Y {},Z 300,A 0,B 0,C 180}}"
    top, left, bottom, right = (at.format(*xy) for xy in ((800, 100), (700, 0), (800, -100), (900, 0)))
    plan = run(
        "$BASE=$NULLFRAME",
        f"PTP {right}",
        f"CIRC {top},{left},CA 90",
        f"CIRC {left},{bottom},CA 180",
        f"LIN {right}",
    )
    wanted = [(0.9, 0.0), (0.8, 0.1), (0.8, -0.1), (0.9, 0.0)]
    np.testing.assert_allclose([pose[:2, 3] for pose in poses(plan)], wanted, atol=1e-9)
    quarter = np.pi * 0.1 / 2
    np.testing.assert_allclose(plan.moves.length[1:], [quarter, 2 * quarter, np.sqrt(0.02)], atol=1e-9)


def test_setting_an_element_of_what_the_controller_owns_changes_no_time():
    plan = run("PTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}", "$TORQMON[2]=0", "PTP {A1 10}")
    assert not [d for d in plan.diagnostics if d.code == "I223"]
    assert any("$TORQMON is set" in one.says for one in plan.assumptions)


def test_an_element_without_a_value_leaves_the_others_of_its_array_as_they_are(tmp_path: Path) -> None:
    config = ["DECL FRAME TOOL_DATA[4]", "TOOL_DATA[3]={X 10.5,Y 0,Z 120,A 0,B 30,C 0}"]
    (tmp_path / "$config.dat").write_text("\n".join(["DEFDAT $CONFIG", *config, "ENDDAT", ""]))
    rows = ["$TOOL=TOOL_DATA[3]", "PTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}", "N=2", "$TOOL=TOOL_DATA[N]"]
    rows += ["PTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}"]
    (tmp_path / "part.src").write_text("\n".join(["DEF part()", "DECL INT N", *rows, "END", ""]))
    plan = plan_of(olp.read(tmp_path / "part.src"))
    first, second = plan.positions.position[plan.moves.target]
    apart = float(np.linalg.norm(first - second))
    assert apart == pytest.approx(
        np.hypot(0.0105, 0.12)
    )  # the second has no value: the flange, which is told
    assert any("TOOL_DATA" in one.says for one in plan.assumptions)


def test_a_clock_with_a_computed_number_is_what_the_controller_sets():
    """`$TIMER_STOP[n]`: an array that no file declares was refused as no array."""
    plan = run(
        "INT n", "n=2", "IF $TIMER_STOP[n]==FALSE THEN", "$OUT[1]=TRUE", "ENDIF", "$OUT[2]=$TIMER[n]>9"
    )
    assert not [d.render() for d in plan.diagnostics if d.is_error]
    assert any("$TIMER_STOP is taken as 0" in one.says for one in plan.assumptions)


@pytest.mark.parametrize("data", ["{TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE}", "FOWN"])
@pytest.mark.parametrize(("number", "length"), [(0, 0.0), (1, 0.1), (2, 0.2)])
def test_a_tool_by_a_computed_number_is_the_flange_at_0(
    tmp_path: Path, number: int, length: float, data: str
) -> None:
    """Public bas.src, TOOL and FRAMES: below 1 it is $NULLFRAME; TOOL_DATA has no element 0."""
    tools = [f"TOOL_DATA[{n}]={{X 0.0,Y 0.0,Z {100.0 * n},A 0.0,B 0.0,C 0.0}}" for n in (1, 2)]
    own = "DECL FDAT FOWN={TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE}"
    config = ["DEFDAT $CONFIG PUBLIC", own, "DECL FRAME TOOL_DATA[16]", *tools, "ENDDAT", ""]
    (tmp_path / "$config.dat").write_text("\n".join(config))
    rows = ["DEF part()", f"choose({number})", "PTP {X 900,Y 0,Z 500,A 0,B 0,C 0}", "END"]
    rows += ["DEF choose(n:IN)", "INT n", f"FDAT_ACT={data}"]
    rows += ["FDAT_ACT.TOOL_NO=n", "BAS(#FRAMES)", "END", ""]
    (tmp_path / "part.src").write_text("\n".join(rows))
    plan = olp.read(tmp_path / "part.src").plan(robot=ROBOT)
    assert not [d.render() for d in plan.diagnostics if d.is_error]
    assert not any("BASE" in one.says or "user frame" in one.says for one in plan.assumptions)
    tool = plan.tools.get(int(plan.held[0]))
    assert (0.0 if tool is None else float(tool.position[2])) == pytest.approx(length)
