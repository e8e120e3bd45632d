"""How moves are programmed: speeds, blends, accelerations, several mechanisms in step; and moves built by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from interpreter_jobs import errors, findings, plan_of, said, visited, write_jobs

from olp.core.source import decode
from olp.fluent import read
from olp.ir.expressions import Number, Quantity, Store, Taught
from olp.ir.points import PointBlock, PointKind, PointState, PointTable
from olp.ir.program import (
    Begin,
    Blend,
    BlendKind,
    ControlGroup,
    Dwell,
    End,
    Move,
    MovePart,
    Program,
    Routine,
    Speed,
    SpeedUnit,
)
from olp.ir.program import (
    Path as Shape,
)
from olp.runtime.assumptions import Assumptions
from olp.runtime.interpreter import run
from olp.runtime.plan import PATHS, BlendCode, Plan, StepKind

ARM = "yaskawa/ma2010"


def speeds(plan: Plan) -> list[tuple[str, float]]:
    """(kind, SI value) of every row."""
    moves = plan.moves
    names = ("fraction", "travel", "turn")
    table = np.stack([moves.fraction, moves.travel, moves.turn], axis=1)
    return [(names[int(np.nonzero(~np.isnan(row))[0][0])], float(row[~np.isnan(row)][0])) for row in table]


def test_speeds_are_si_whatever_way_they_are_written() -> None:
    body = """
    MOVJ C00000 VJ=12.50
    MOVL C00001 V=187.0
    MOVL C00002 VR=36.0
    SET I010 3750
    MOVJ C00003 VJ=I010
    SET I011 1234
    MOVL C00004 V=I011
    """
    plan = plan_of(body, robot=ARM)
    assert speeds(plan) == [
        ("fraction", pytest.approx(0.125)),
        ("travel", pytest.approx(0.187)),
        ("turn", pytest.approx(np.radians(36.0))),
        ("fraction", pytest.approx(0.375)),
        ("travel", pytest.approx(0.1234)),
    ]


def test_a_move_without_a_speed_takes_the_modal_one_of_its_kind() -> None:
    body = "SPEED VJ=62.50 V=750.0\nMOVJ C00000 VJ=10.00\nMOVL C00001\nMOVJ C00002\nSPEED V=40.0\nMOVL C00003"
    plan = plan_of(body, robot=ARM)
    assert [value for _, value in speeds(plan)] == pytest.approx([0.10, 0.75, 0.625, 0.04])
    assert "speed" not in said(plan)


def test_without_a_modal_speed_the_last_one_of_its_kind_holds_and_is_reported() -> None:
    plan = plan_of("MOVL C00000 V=46.0\nMOVJ C00001 VJ=25.00\nMOVL C00002", robot=ARM)
    assert speeds(plan)[2] == ("travel", pytest.approx(0.046))
    line = plan.sources[0].lines.index("MOVL C00002") + 1
    assert f"{line}: the move names no speed" in said(plan)


def test_without_any_speed_a_slow_default_is_taken_and_reported() -> None:
    plan = plan_of("MOVL C00000\nMOVJ C00001", robot=ARM)
    assert speeds(plan) == [("travel", pytest.approx(0.25)), ("fraction", pytest.approx(0.1))]
    assert said(plan).count("no speed was set before this move") == 2


@pytest.mark.parametrize(
    ("move", "code", "value"),
    [("MOVJ C00000 VJ=108.00", "I302", 1.0), ("SET I000 0\nMOVL C00000 V=I000", "I301", 0.25)],
)
def test_a_speed_that_the_controller_refuses_is_a_warning(move: str, code: str, value: float) -> None:
    plan = plan_of(move, robot=ARM)
    assert findings(plan) == [code]
    assert not errors(plan)
    assert speeds(plan)[0][1] == pytest.approx(value)


def test_ends_of_moves_are_exact_zoned_or_left_to_the_controller() -> None:
    plan = plan_of(
        "MOVL C00000 V=50.0 PL=0\nMOVL C00001 V=50.0 PL=1\nMOVL C00002 V=50.0 PL=6\n"
        "MOVL C00003 V=50.0\nMOVL C00004 V=50.0 CONT"
    )
    codes = [BlendCode(int(code)) for code in plan.moves.blend_code]
    assert codes == [BlendCode.EXACT, BlendCode.ZONE, BlendCode.ZONE, BlendCode.UNTAGGED, BlendCode.UNTAGGED]
    np.testing.assert_allclose(plan.moves.blend[1:3], [0.0125, 0.3])
    assert np.isnan(plan.moves.blend[[0, 3, 4]]).all()
    assert said(plan).count("the blend zones of this controller are not known") == 1


def zones(*mm: int) -> bytes:
    """An SC.PRM whose first group has these zones [mm] for PL = 1..8."""
    values = [0] * 800
    values[33:41] = [z * 1000 for z in mm]
    rows = [",".join(map(str, values[i : i + 10])) for i in range(0, 800, 10)]
    return "\r\n".join(["/CRC", "//ROBOT", "///S1C1G", *rows, ""]).encode()


def test_blend_zones_come_from_the_controllers_backup(tmp_path: Path) -> None:
    main = write_jobs(tmp_path, {"MAIN": "MOVL C00000 V=50.0 PL=2\nMOVL C00001 V=50.0 PL=8"})
    (tmp_path / "SC.PRM").write_bytes(zones(21, 43, 61, 87, 121, 199, 311, 433))
    plan = run(read(main))
    np.testing.assert_allclose(plan.moves.blend, [0.043, 0.433])
    assert "blend zones" not in said(plan)


def test_accelerations_are_fractions_of_the_rated_one() -> None:
    plan = plan_of("MOVL C00000 V=50.0 ACC=40 DEC=20\nMOVL C00001 V=50.0")
    np.testing.assert_allclose(plan.moves.acceleration, [0.4, 1.0])
    np.testing.assert_allclose(plan.moves.deceleration, [0.2, 1.0])


GROUPS = "///GROUP1 RB1,BS1\n///GROUP2 ST1"
ROWS = "BC00000=283917\nBC00001=301455\nEC00000=-1746,811\nEC00001=8820,902"


def test_a_move_of_several_groups_is_one_step_with_a_row_each() -> None:
    body = (
        "MOVJ C00000 BC00000 VJ=80.00  +MOVJ EC00000 VJ=25.00\nMOVL C00001 BC00001 V=93.0 PL=0  +MOVJ EC00001"
    )
    plan = plan_of(body, robot=ARM, header=GROUPS, rows=f"///TOOL 0\n///POSTYPE PULSE\n///PULSE\n{ROWS}")
    assert plan.mechanisms == ("RB1", "BS1", "ST1")
    assert list(plan.kind) == [StepKind.MOVE] * 2
    assert [list(plan.rows_of(i)) for i in range(2)] == [[0, 1, 2], [3, 4, 5]]
    assert list(plan.moves.mechanism) == [0, 1, 2, 0, 1, 2]
    # a track or table without a speed of its own keeps step: only its rated speed bounds it
    assert [s for _, s in speeds(plan)] == pytest.approx([0.8, 0.8, 0.25, 0.093, 1.0, 1.0])
    assert [PATHS[int(p)] for p in plan.moves.path] == [Shape.JOINT] * 3 + [Shape.LINEAR] + [Shape.JOINT] * 2
    assert (plan.moves.start[3:] == plan.moves.target[:3]).all()


def test_a_second_robot_in_the_second_part_moves_the_second_robot() -> None:
    body = "MOVL C00000 V=11.0  +MOVL C00001 V=21.0\nMOVL C00002 V=31.0  +MOVL C00003"
    plan = plan_of(body, header="///GROUP1 RB1,ST1\n///GROUP2 RB2")
    assert list(plan.moves.mechanism) == [0, 2, 0, 2]
    assert [s for _, s in speeds(plan)] == pytest.approx([0.011, 0.021, 0.031, 0.031])
    assert plan.mechanisms == ("RB1", "ST1", "RB2")


def test_a_reference_point_moves_nothing() -> None:
    assert visited(plan_of("MOVL C00000 V=50.0\nREFP 1 C00003\nMOVL C00001 V=50.0")) == [0, 1]


def test_what_cannot_be_known_of_a_move_is_reported() -> None:
    plan = plan_of(
        "MOVL C00000 V=50.0\nMOVL C00001 V=50.0 SRCH RIN#(1)=ON T=5.00 DIS=20.0\nMOVL C00002 V=50.0 UNTIL IN#(4)=ON"
    )
    assert visited(plan) == [0, 1, 2]
    assert "the search moves to its target" in said(plan)
    assert "ends the move early" in said(plan)
    assert said(plan).count("\n") == 2  # nothing else is said of the three moves


PULSE_ROWS = """///TOOL 0
///POSTYPE PULSE
///PULSE
C00050=-23252,-25038,-66049,-4838,-35806,11014
C00051=2242,-15910,-30274,1525,-51078,9460"""


def test_pulses_without_a_robot_are_one_error_that_names_candidates() -> None:
    plan = plan_of("MOVJ C00050 VJ=25.00\nMOVL C00051 V=50.0\nTIMER T=0.50", rows=PULSE_ROWS)
    assert [code for code, _ in errors(plan)] == ["I001"]
    found = next(d for d in plan.diagnostics if d.code == "I001")
    assert "--robot" in found.help
    assert "olp.toml" in found.help
    assert ARM in found.help
    assert len(plan) == 3


def test_a_second_robot_that_is_not_known_is_named_and_so_is_its_key(tmp_path: Path) -> None:
    """--robot is the first arm: telling the user to give it again would help nobody."""
    body = "MOVJ C00050 VJ=25.00  +MOVJ C00051 VJ=25.00\nMOVJ C00051 VJ=25.00  +MOVJ C00050 VJ=25.00"
    plan = plan_of(body, rows=PULSE_ROWS, robot=ARM, header="///GROUP1 RB1\n///GROUP2 RB2")
    found = [d for d in plan.diagnostics if d.is_error]
    assert [d.code for d in found] == ["I001"]
    assert "RB2" in found[0].message
    assert 'RB2 = "maker/model" under [robots]' in found[0].help
    assert "--robot" not in found[0].help
    times = plan.time()
    assert times["limited_by"].tolist() == ["", ""]


def test_what_limits_a_move_names_the_slowest_mechanism() -> None:
    body = "MOVJ C00050 VJ=25.00  +MOVJ C00051 VJ=25.00\nMOVJ C00050 VJ=25.00  +MOVJ C00050 VJ=5.00"
    given = Assumptions(robots={"RB2": ARM})
    plan = plan_of(body, given, rows=PULSE_ROWS, robot=ARM, header="///GROUP1 RB1\n///GROUP2 RB2")
    assert not findings(plan)
    assert plan.time()["limited_by"].tolist()[1].startswith("RB2 axis ")


def test_the_first_robot_that_is_named_counts(tmp_path: Path) -> None:
    main = write_jobs(tmp_path, {"MAIN": "MOVL C00000 V=50.0"})
    assert run(read(main)).robot is None
    (tmp_path / "olp.toml").write_text('robot = "yaskawa/gp25"\n', encoding="utf-8")
    assert run(read(main)).robot.name == "yaskawa/gp25"
    (tmp_path / "olp.toml").write_text(
        'robot = "yaskawa/gp25"\n[robots]\nRB1 = "yaskawa/gp50"\n', encoding="utf-8"
    )
    assert run(read(main)).robot.name == "yaskawa/gp50"
    assert run(read(main), ARM).robot.name == ARM


def test_a_robot_file_in_olp_toml_stands_beside_it(tmp_path: Path) -> None:
    library = Path(__file__).parent.parent / "olp" / "robots" / "yaskawa" / "gp25.toml"
    (tmp_path / "mine.toml").write_bytes(library.read_bytes())
    (tmp_path / "olp.toml").write_text('robot = "mine.toml"\n', encoding="utf-8")
    plan = run(read(write_jobs(tmp_path, {"MAIN": "MOVL C00000 V=50.0"})))
    assert plan.robot is not None
    assert not findings(plan)


def test_an_unknown_robot_in_olp_toml_is_an_error_and_linear_moves_are_still_planned(tmp_path: Path) -> None:
    (tmp_path / "olp.toml").write_text('robot = "yaskawa/gp52"\n', encoding="utf-8")
    plan = run(read(write_jobs(tmp_path, {"MAIN": "MOVL C00000 V=50.0\nMOVL C00003 V=50.0"})))
    assert [code for code, _ in errors(plan)] == ["R001"]
    assert plan.moves.length[1] == pytest.approx(3 * 0.0375)


def test_joint_moves_to_poses_need_a_robot_and_linear_ones_do_not() -> None:
    body = "MOVL C00000 V=50.0\nMOVJ C00001 VJ=25.00\nMOVJ C00002 VJ=25.00\nMOVL C00003 V=50.0"
    plan = plan_of(body)
    line = plan.sources[0].lines.index("MOVJ C00001 VJ=25.00") + 1
    assert errors(plan) == [("I003", line)]
    assert plan.diagnostics[0].message.endswith("needs the robot RB1 (and once more)")
    assert visited(plan) == [0, 1, 2, 3]
    assert not findings(plan_of("MOVL C00000 V=50.0\nMOVL C00001 V=50.0"))


def test_a_pose_out_of_reach_of_a_joint_move_is_told() -> None:
    plan = plan_of(
        "MOVJ C00000 VJ=25.00\nMOVJ C00050 VJ=25.00", robot=ARM, rows="C00050=9000.0,0.0,300.0,180.0,0.0,0.0"
    )
    assert findings(plan) == ["I004"]


def test_the_settings_of_the_motion_model_reach_the_plan() -> None:
    plan = plan_of("MOVL C00000 V=50.0", Assumptions(motion={"model": "linear", "accel_mm_s2": 2500.0}))
    assert plan.settings == {"model": "linear", "accel_mm_s2": 2500.0}


# --- programs built by hand, without any vendor's language ------------------------------------------------------


def by_hand(*body: object, groups: tuple[ControlGroup, ...] = ()) -> Program:
    """A routine over three poses 120, 160 and 200 mm apart (a right triangle) and two table angles."""
    numbers = np.arange(3, dtype=np.int64)
    poses = np.array([[0.6, 0.1, 0.3, 0, 0, 0], [0.72, 0.1, 0.3, 0, 0, 0], [0.72, 0.26, 0.3, 0, 0, 0]])
    states = (PointState(PointKind.POSE, "base"), PointState(PointKind.JOINT, "joint"))
    rows = {int(n): int(n) for n in numbers}
    lines = np.zeros(3, dtype=np.int32)
    blocks = {
        (Store.ROBOT, True): PointBlock(
            Store.ROBOT, True, numbers, poses, np.zeros(3, np.int32), lines, rows
        ),
        (Store.STATION, True): PointBlock(
            Store.STATION, True, numbers, np.array([[0.1], [0.4], [0.9]]), np.ones(3, np.int32), lines, rows
        ),
    }
    statements = (Begin(1), *body, End(99))
    routine = Routine("HAND", 1, statements, PointTable(states, blocks), groups)  # type: ignore[arg-type]
    return Program("none", decode(b"", "HAND"), (routine,))


def travel(mm_s: float) -> Speed:
    return Speed(SpeedUnit.TRAVEL, Quantity(Number(mm_s), 1e-3))


def line(number: int, mm_s: float = 50.0, **more: object) -> Move:
    return Move(10 + number, Shape.LINEAR, (Taught(Store.ROBOT, number),), travel(mm_s), **more)  # type: ignore[arg-type]


def test_a_program_without_a_vendor_is_planned() -> None:
    radius = Blend(BlendKind.RADIUS, Quantity(Number(8), 1e-3))
    plan = run(by_hand(line(0), line(1, blend=radius), Dwell(12, Quantity(Number(0.2), 1.0)), line(2)))
    assert list(plan.kind) == [StepKind.MOVE, StepKind.MOVE, StepKind.WAIT, StepKind.MOVE]
    assert list(plan.line) == [10, 11, 12, 12]
    np.testing.assert_allclose(plan.moves.length, [0.0, 0.12, 0.16], atol=1e-12)
    assert plan.moves.blend[1] == pytest.approx(0.008)


def test_a_part_with_a_table_moves_its_own_group() -> None:
    part = MovePart(Shape.JOINT, (Taught(Store.STATION, 1),))
    plan = run(
        by_hand(line(0), line(1, parts=(part,)), groups=(ControlGroup(("RB1",)), ControlGroup(("ST2",))))
    )
    assert plan.mechanisms == ("RB1", "ST2")
    assert list(plan.moves.mechanism) == [0, 0, 1]
    assert plan.positions.axes[plan.moves.target[2], 0] == pytest.approx(0.4)


def test_a_station_that_no_group_names_is_taken_and_reported() -> None:
    part = MovePart(Shape.JOINT, (Taught(Store.STATION, 1),))
    plan = run(by_hand(line(0, parts=(part,))))
    assert plan.mechanisms == ("RB1", "ST1")
    assert "ST1 is taken" in said(plan)


SAMPLES = Path(__file__).parent.parent / "samples" / "backup"


@pytest.mark.parametrize("cell", ["dx200", "yrc1000"])
def test_the_arm_comes_from_the_controllers_backup_beside_the_job(tmp_path: Path, cell: str) -> None:
    for file in (SAMPLES / cell).iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    main = write_jobs(tmp_path, {"MAIN": "MOVL C00000 V=50.0 PL=1\nMOVJ C00001 VJ=25.00 PL=1"})
    plan = run(read(main))
    assert plan.robot is not None
    assert len(plan.robot.axes) == 6
    assert plan.robot.knows_pulses
    assert not errors(plan)
    assert plan.robot.blend_zones is not None
    assert plan.moves.blend[0] == pytest.approx(plan.robot.blend_zones[0])


def test_a_backup_that_cannot_be_true_is_a_warning_and_linear_moves_are_planned(tmp_path: Path) -> None:
    for file in (SAMPLES / "yrc1000").iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    rows = (tmp_path / "RC.PRM").read_bytes().decode().split("\r\n")
    speeds = rows.index("///RC1G") + 1 + 107
    rows[speeds] = ",".join(["0"] * 10)
    (tmp_path / "RC.PRM").write_bytes("\r\n".join(rows).encode())
    plan = run(read(write_jobs(tmp_path, {"MAIN": "MOVL C00000 V=50.0\nMOVL C00002 V=50.0"})))
    assert plan.robot is None
    assert not errors(plan)
    assert findings(plan)
    assert visited(plan) == [0, 2]


def test_a_move_with_a_tag_without_value_is_left_out_whole() -> None:
    """Half of it once stood in the plan as a step of no mechanism, and timing it failed."""
    body = "MOVL C00001 V=50.0\nMOVL C00002 V=50.0 PL=NOWHERE ACC=20\nMOVL C00003 V=50.0"
    plan = plan_of(body)
    assert [code for code, _ in errors(plan)] == ["I209"]
    assert visited(plan) == [1, 3]
    assert len(plan.time()) == 2
