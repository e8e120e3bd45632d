"""RAPID: positions, quaternions and frames, against scipy's rotations."""

from __future__ import annotations

import math
import random
from pathlib import Path

import numpy as np
import pytest
from rapid_modules import NO_AXES, codes, errors, module, read, statements
from scipy.spatial.transform import Rotation

import olp
from olp.core.units import deg, mm
from olp.ir.expressions import Named, PositionLiteral
from olp.ir.program import Declare, Move
from olp.languages.vendors.rapid.clauses import Clause, Cutter
from olp.languages.vendors.rapid.fast import PlainClauses
from olp.languages.vendors.rapid.literals import quaternion_angles
from olp.languages.vendors.rapid.names import gather
from olp.languages.vendors.rapid.parsing import clause_parser
from olp.languages.vendors.rapid.write_values import quaternion
from olp.runtime.plan import MoveStep

SAMPLES = Path(__file__).resolve().parent.parent / "samples" / "rapid"


def rotation(w: float, x: float, y: float, z: float) -> Rotation:
    return Rotation.from_quat([x, y, z, w])


def angles(rx: float, ry: float, rz: float) -> Rotation:
    """[deg], R = Rz Ry Rx."""
    return Rotation.from_euler("ZYX", [rz, ry, rx], degrees=True)


def pose(x: float, y: float, z: float, turn: Rotation) -> np.ndarray:
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = turn.as_matrix(), (x, y, z)
    return found


def text(x: float, y: float, z: float, turn: Rotation) -> str:
    b, c, d, a = turn.as_quat()
    return f"[[{x},{y},{z}],[{a:.12f},{b:.12f},{c:.12f},{d:.12f}]]"


def targets(body: list[str], data: list[str]) -> list[np.ndarray]:
    """Where the moves of main go, in the base [m]."""
    program = read(module(body, data))
    assert not errors(program), [d.render() for d in program.diagnostics]
    plan = program.plan(robot="yaskawa/gp25")
    return [np.asarray(step.target) for step in plan.steps() if isinstance(step, MoveStep)]


# --- quaternions --------------------------------------------------------------------------------------------------


def test_quaternions_become_the_angles_of_the_same_turn() -> None:
    chance = random.Random(5)
    for _ in range(300):
        q = [chance.gauss(0, 1) for _ in range(4)]
        rx, ry, rz = (v / deg for v in quaternion_angles(*q))
        assert (rotation(*q).inv() * angles(rx, ry, rz)).magnitude() < 1e-9


@pytest.mark.parametrize(
    "q",
    [(0, 0, 1, 0), (0, 1, 0, 0), (0.5, 0.5, 0.5, 0.5), (math.sqrt(0.5), 0, math.sqrt(0.5), 0), (1, 0, 0, 0)],
)
def test_singular_turns_are_turns_too(q: tuple[float, ...]) -> None:
    rx, ry, rz = (v / deg for v in quaternion_angles(*q))
    assert (rotation(*q).inv() * angles(rx, ry, rz)).magnitude() < 1e-7


def test_the_scalar_of_a_quaternion_stands_first() -> None:
    half = math.radians(30) / 2
    (found,) = statements(f"p:=[[0,0,0],[{math.cos(half)},0,0,{math.sin(half)}]];", "VAR pose p;")
    assert found.value.values[3:] == pytest.approx((0, 0, math.radians(30)))


def test_angles_become_the_quaternion_of_the_same_turn() -> None:
    chance = random.Random(6)
    for _ in range(300):
        three = [chance.uniform(-180, 180) for _ in range(3)]
        written = quaternion(*(v * deg for v in three))
        assert written[0] >= 0
        assert (rotation(*written).inv() * angles(*three)).magnitude() < 1e-9


def test_a_quaternion_of_another_length_is_brought_to_unit_length_and_told_once() -> None:
    program = read(
        module([], [f"CONST robtarget p{n}:=[[1,2,3],[2,0,0,2],[0,0,0,0],{NO_AXES}];" for n in (1, 2)])
    )
    assert not errors(program)
    assert codes(program)["P463"] == [2]
    assert program.data[0].value.values[5] == pytest.approx(math.pi / 2)
    assert "P463" not in codes(
        read(module([], f"CONST robtarget p:=[[1,2,3],[0.7071,0,0,0.7071],[0,0,0,0],{NO_AXES}];"))
    )


@pytest.mark.parametrize(
    "data",
    [
        f"CONST robtarget p:=[[1,2,3],[0,0,0,0],[0,0,0,0],{NO_AXES}];",
        f"VAR robtarget p{{2}}:=[[[1,2,3],[0,0,0,0],[0,0,0,0],{NO_AXES}],[[1,2,3],[1,0,0,0],[0,0,0,0],{NO_AXES}]];",
        "PERS tooldata t:=[TRUE,[[0,0,0],[0,0,0,0]],[0,[0,0,0],[0,0,0,0],0,0,0]];",
        "VAR orient o:=[0,0,0,0];",
    ],
)
def test_a_quaternion_of_zeros_is_told_where_it_is_declared(data: str) -> None:
    program = read(module([], data))
    assert not errors(program)
    assert codes(program)["P465"] == [2]
    assert "P463" not in codes(program)


def test_a_move_to_a_quaternion_of_zeros_is_an_error() -> None:
    data = f"CONST robtarget p:=[[1,2,3],[0,0,0,0],[0,0,0,0],{NO_AXES}];"
    assert errors(read(module("MoveL p,v100,fine,tool0;", data))) == ["P465 4"]
    literal = f"[[1,2,3],[0,0,0,0],[0,0,0,0],{NO_AXES}]"
    assert errors(read(module(f"MoveL {literal},v100,fine,tool0;"))) == ["P451 3"]


# --- literals -----------------------------------------------------------------------------------------------------


def test_external_axes_that_are_not_connected_are_left_out() -> None:
    program = read(
        module(
            [],
            [
                "CONST robtarget a:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E+09,9e9,9E9,9000000000,9E9,9E9]];",
                "CONST robtarget b:=[[1,2,3],[1,0,0,0],[1,-2,0,4],[120.5,9E9,-30,9E9,9E9,9E9]];",
            ],
        )
    )
    first, second = (one.value for one in program.data)
    assert first.external == ()
    assert second.external[0] == 120.5
    assert second.external[2] == -30
    assert [math.isnan(v) for v in second.external] == [False, True, False, True, True, True]
    assert dict(second.native)["confdata"] == "1,-2,0,4"


def test_lengths_are_millimetres() -> None:
    (found,) = statements("p:=[12.5,-3,0.25];", "VAR pos p;")
    assert found.value.values[:3] == pytest.approx((0.0125, -0.003, 0.00025))


def test_the_fast_way_gives_what_the_grammar_gives() -> None:
    chance = random.Random(8)

    def number() -> str:
        return chance.choice(
            [f"{chance.uniform(-900, 900):.3f}", str(chance.randint(-9, 9)), "1E-3", "-.5", "0.0"]
        )

    def target() -> str:
        q = ",".join(f"{chance.gauss(0, 1):.6f}" for _ in range(4))
        axes = chance.choice([NO_AXES, "[0,9E9,9E9,9E9,9E9,9E9]"])
        arm = ",".join(str(chance.randint(-2, 2)) for _ in range(4))
        return f"[[{number()},{number()}, {number()}],[{q}],[{arm}],{axes}]"

    rows = [
        "MODULE M",
        "CONST speeddata vOwn:=[33,44,5000,1000];",
        "CONST zonedata zOwn:=[FALSE,3,4,4,.4,4,.4];",
    ]
    rows += [
        f"{chance.choice(['CONST', 'LOCAL VAR', 'TASK PERS'])} robtarget p{n}:={target()};" for n in range(40)
    ]
    rows += ["PROC main()"]
    for n in range(160):
        where = chance.choice([f"P{n % 40}", target()])
        speed, zone = chance.choice(["v100", "V50", "vOwn"]), chance.choice(["fine", "z5", "zOwn"])
        tool = chance.choice(["tool0", "tGrip", "tgrip\\WObj:=wObj1", "tGrip \\WObj := wobj0"])
        word = chance.choice(["MoveL", "MoveJ", "movel", "MoveC", "MoveAbsJ"])
        if word == "MoveC":
            where = f"{target()},{where}"
        if word == "MoveAbsJ":
            where = chance.choice(["jHome", f"[[1,-2,3.5,4,5,6],{NO_AXES}]"])
        rows.append(f"{word} {where},{speed},{zone},{tool};")
    rows += ["ENDPROC", "ENDMODULE"]
    clauses = [one for one in Cutter(rows).cut() if isinstance(one, Clause)]
    names = gather(clauses)
    plain = PlainClauses(names)
    taken = 0
    for clause in clauses:
        quick: Move | Declare | None = plain.move(clause.text, 0, "") or plain.point(clause.text, 0, "")
        if quick is not None:
            taken += 1
            assert [quick] == clause_parser().clause(clause.text, names), clause.text
    assert taken == 201  # the speed, too
    one, other = (plain.move(f"MoveL p1,{speed},zOwn,tool0;", 0, "") for speed in ("vOwn", "v60"))
    assert one is not None
    assert other is not None
    assert one.blend is other.blend  # one object for thousands of moves


@pytest.mark.parametrize(
    "clause",
    [
        "MoveL p,v5,z1,t\\WObj:=w\\Corr;",
        "MoveL Offs(p,0,0,1),v5,z1,t;",
        "MoveL p,v5\\T:=1,z1,t;",
        "MoveC p,v5,z1,t;",
        "MoveL p,q,v5,z1,t;",
        "MoveL [[1,2,3],[0,0,0,0],[0,0,0,0],[0,0,0,0,0,0]],v5,z1,t;",
        "MoveL [[nan,2,3],[1,0,0,0],[0,0,0,0],[0,0,0,0,0,0]],v5,z1,t;",
        "MoveL [[1,2,3],[1,0,0,0]],v5,z1,t;",
        "MoveL p,vUnknown,z1,t;",
        "MoveL di1,v5,z1,t;",
    ],
)
def test_the_fast_way_leaves_all_that_is_not_plain_to_the_grammar(clause: str) -> None:
    assert PlainClauses(gather([])).move(clause, 1, "") is None


# --- frames and functions -----------------------------------------------------------------------------------------

TURN = angles(12, -34, 56)
POINT = f"CONST robtarget p:=[[100,50,30],[1,0,0,0],[0,0,0,0],{NO_AXES}];"


def test_a_work_object_is_its_user_frame_then_its_object_frame() -> None:
    user, thing = pose(500, 100, 200, TURN), pose(10, -20, 30, angles(5, 6, 7))
    data = [
        f'PERS wobjdata w:=[FALSE,TRUE,"",{text(500, 100, 200, TURN)},{text(10, -20, 30, angles(5, 6, 7))}];',
        POINT,
    ]
    (found,) = targets(["MoveL p,v100,fine,tool0\\WObj:=w;"], data)
    assert found * 1000 == pytest.approx((user @ thing @ [100, 50, 30, 1])[:3], abs=1e-6)


def test_offs_moves_along_the_axes_of_the_work_object() -> None:
    user = pose(500, 100, 200, TURN)
    data = [f'PERS wobjdata w:=[FALSE,TRUE,"",{text(500, 100, 200, TURN)},[[0,0,0],[1,0,0,0]]];', POINT]
    (found,) = targets(["MoveL Offs(p,1,2,-3),v100,fine,tool0\\WObj:=w;"], data)
    assert found * 1000 == pytest.approx((user @ [101, 52, 27, 1])[:3], abs=1e-6)


def test_reltool_moves_along_the_axes_of_the_tool() -> None:
    data = [f"CONST robtarget p:={text(600, 50, 300, TURN)[:-1]},[0,0,0,0],{NO_AXES}];"]
    (found,) = targets(["MoveL RelTool(p,1,2,-3\\Rx:=90),v100,fine,tool0;"], data)
    assert found * 1000 == pytest.approx((pose(600, 50, 300, TURN) @ [1, 2, -3, 1])[:3], abs=1e-6)


def test_posemult_and_poseinv_are_products_of_poses() -> None:
    first, second = pose(300, 20, 400, TURN), pose(50, -60, 70, angles(10, 20, 30))
    data = [
        f"CONST pose a:={text(300, 20, 400, TURN)};",
        f"CONST pose b:={text(50, -60, 70, angles(10, 20, 30))};",
        "VAR pose c;",
    ]
    body = [
        "c:=PoseMult(a,PoseInv(b));",
        f"MoveL [c.trans,c.rot,[0,0,0,0],{NO_AXES}],v100,fine,tool0;",
        f"MoveL Offs([c.trans,[1,0,0,0],[0,0,0,0],{NO_AXES}],0,0,5),v100,fine,tool0;",
    ]
    wanted = (first @ np.linalg.inv(second))[:3, 3]
    for found, up in zip(targets(body, data), (0, 5), strict=True):
        assert found * 1000 == pytest.approx(wanted + np.array([0, 0, up]), abs=1e-6)


def test_orientzyx_turns_about_z_then_y_then_x() -> None:
    data = [f"VAR robtarget p:=[[600,50,300],[1,0,0,0],[0,0,0,0],{NO_AXES}];"]
    body = ["p.rot:=OrientZYX(56,-34,12);", "MoveL RelTool(p,1,2,-3),v100,fine,tool0;"]
    (found,) = targets(body, data)
    assert found * 1000 == pytest.approx((pose(600, 50, 300, TURN) @ [1, 2, -3, 1])[:3], abs=1e-6)


# --- the sample that all languages have ---------------------------------------------------------------------------

TABLE = pose(850.5, -210.25, 305.75, angles(1.5, -2.25, 33))
RACK = pose(420, 640.5, 512, angles(0, 0, 90.5))


def test_the_sample_goes_where_its_numbers_say() -> None:
    program = olp.read(SAMPLES / "handling.mod")
    assert not errors(program)
    steps = [s for s in program.plan(robot="yaskawa/gp25").steps() if isinstance(s, MoveStep)]
    part = [(110.5, 45.25, z) for z in (160, 20.125, 60.125, 100.125, 140.125)]
    wanted = [TABLE @ [*point, 1] for point in (*part, (260.25, 60, 40.5))] + [RACK @ [55.5, -20.25, 88, 1]]
    assert len(steps) == 9
    for step, where in zip(steps[1:8], wanted, strict=True):
        assert np.asarray(step.target) * 1000 == pytest.approx(where[:3], abs=1e-3)
    assert steps[0].target == pytest.approx(steps[8].target)


def test_the_sample_turns_as_its_numbers_say() -> None:
    program = olp.read(SAMPLES / "handling.mod")
    data = {one.name: one.value for one in program.data}
    for name, turn in (
        ("pAbove", (178.5, 3.25, -21.5)),
        ("pPart", (178.5, 3.25, -21.5)),
        ("pArc", (175, 1, 5)),
        ("pEdge", (170.5, -4, 18)),
        ("pShelf", (160, 12.5, -75)),
    ):
        found = angles(*(v / deg for v in data[name].values[3:]))
        assert math.degrees((found.inv() * angles(*turn)).magnitude()) < 1e-4, name
    tool = dict(data["tProbe"].members)["tframe"]
    assert isinstance(tool, PositionLiteral)
    assert tool.values[:3] == pytest.approx((-31 * mm, 4.5 * mm, 220.75 * mm))
    found = angles(*(v / deg for v in tool.values[3:]))
    assert math.degrees((found.inv() * angles(10, -5, 62)).magnitude()) < 1e-4


def test_the_sample_moves_as_fast_and_blends_as_wide_as_it_says() -> None:
    program = olp.read(SAMPLES / "handling.mod")
    moves = [one for one in program.statements() if isinstance(one, Move)]
    assert [one.speed.value.literal for one in moves] == pytest.approx(
        [1.5, 2.0, 0.25, 0.1205, 0.25, 1.5, 0.15, 0.3]
    )
    assert [one.blend.value.literal for one in moves] == pytest.approx([0, 0.025, 0, 0.005, 0, 0, 0.01, 0])
    assert [one.tool for one in moves[-2:]] == [Named("tGripper"), Named("tProbe")]


def test_a_list_of_modules_is_the_program_of_its_modules() -> None:
    whole, part = olp.read(SAMPLES / "handling.pgf"), olp.read(SAMPLES / "handling.mod")
    assert whole.to_bytes() == (SAMPLES / "handling.pgf").read_bytes()
    assert [one.name for one in whole.routines] == [one.name for one in part.routines]
    assert [one.path for one in whole.companions] == [str(SAMPLES / "handling.mod")]
    assert len(whole.line_kinds) == len(whole.source.lines)
    said = [[s.statement for s in p.plan(robot="yaskawa/gp25").steps()] for p in (whole, part)]
    assert said[0] == said[1]


def test_a_tool_and_a_work_object_that_the_program_changes_between_moves_are_looked_at_anew():
    data = [
        "PERS tooldata t:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];",
        'PERS wobjdata w:=[FALSE,TRUE,"",[[500,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];',
        f"CONST robtarget p:=[[100,0,900],[0,0,1,0],[0,0,0,0],{NO_AXES}];",
    ]
    line = "MoveL p,v100,fine,t\\WObj:=w;"
    plan = read(
        module([line, line, "t.tframe.trans.z:=300;", line, "w.uframe.trans.x:=700;", line], data)
    ).plan()
    moves = plan.moves
    tools = [plan.tools[number] for number in plan.held.tolist()]
    assert [round(1000 * float(tool.position[2])) for tool in tools] == [100, 100, 300, 300]
    assert (1000 * plan.positions.position[moves.target][:, 0]).round().tolist() == [600, 600, 600, 800]
