"""VAL3: its turns, data, frames, speeds, corners and blocks, against independent values."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from handling_sample import SAMPLES, check_damage, check_plan, check_whole, poses
from scipy.spatial.transform import Rotation

import olp
from olp.core.source import decode
from olp.core.units import mm
from olp.fluent import read_source
from olp.ir.expressions import (
    FrameRef,
    Item,
    Named,
    Number,
    PositionLiteral,
    Signal,
    SignalState,
    Text,
    Unary,
)
from olp.ir.program import Assign, Declare, If, Move, Program, SetOutput, SpeedUnit, Wait
from olp.robots.robot import load_robot
from olp.transpile.context import Context
from olp.transpile.convert import convert, run_converted
from olp.transpile.link import link

FOLDER = SAMPLES / "val3"
DATA = """<Database><Datas>
<Data name="f" type="frame" size="1"><Value key="0" x="100" rz="90" fatherId="g[0]" /></Data>
<Data name="g" type="frame" size="1"><Value key="0" z="50" fatherId="world[0]" /></Data>
<Data name="p" type="pointRx" size="2">
  <Value key="0" x="10" fatherId="f[0]" />
  <Value key="1" x="20" y="5" fatherId="f[0]" />
</Data>
<Data name="q" type="pointRx" size="2">
  <Value key="0" x="10" fatherId="f[0]" />
  <Value key="1" x="20" fatherId="world[0]" />
</Data>
<Data name="m" type="mdesc" size="1"><Value key="0" tmax="250" vel="40" blend="cartesian" leave="5" reach="9" /></Data>
<Data name="still" type="mdesc" size="1"><Value key="0" tmax="250" blend="off" /></Data>
<Data name="j" type="jointRx" size="1"><Value key="0" j1="10" j3="-20" /></Data>
<Data name="out" type="dio" size="1"><Value key="0" link="x" /></Data>
</Datas></Database>
"""


def text(*lines: str, head: str = "") -> bytes:
    code = "".join(f"{line}\n" for line in lines)
    code = f"<Code><![CDATA[begin\n{code}end]]></Code>"
    return f'<Programs>\n<Program name="start">\n{head}\n{code}\n</Program>\n</Programs>\n'.encode()


def program(*lines: str, head: str = "") -> Program:
    return read_source(decode(text(*lines, head=head), "start.pgx"), vendor="val3")


def codes(found: Program) -> list[str]:
    return [d.code for d in found.diagnostics]


def with_data(folder: Path, *lines: str, head: str = "") -> Program:
    (folder / "data.dtx").write_text(DATA)
    (folder / "start.pgx").write_bytes(text(*lines, head=head))
    return olp.read(folder / "start.pgx")


def moves(found: Program) -> list[Move]:
    return [one for one in found.routines[0].body if isinstance(one, Move)]


@pytest.mark.parametrize("turn", [(30, 15, -72), (-113.3, 2.7, 146.3), (10, 0, 20), (5, 90, 7)])
def test_the_turn_of_a_point_is_rx_ry_rz(turn: tuple[float, float, float]) -> None:
    x, y, z = turn
    row = f'<Value key="0" x="10.5" y="-20" z="30" rx="{x}" ry="{y}" rz="{z}" />'
    raw = f'<Database><Datas>\n<Data name="p" type="pointRx" size="1">\n{row}\n</Data></Datas></Database>\n'
    (found,) = read_source(decode(raw.encode(), "a.dtx")).data
    assert isinstance(found, Declare)
    assert isinstance(found.value, PositionLiteral)
    np.testing.assert_allclose(found.value.values[:3], [10.5 * mm, -20 * mm, 30 * mm])
    ours = Rotation.from_euler("xyz", found.value.values[3:]).as_matrix()
    np.testing.assert_allclose(ours, Rotation.from_euler("XYZ", turn, degrees=True).as_matrix(), atol=1e-12)


def test_computed_braces_turn_like_written_ones(tmp_path: Path) -> None:
    plan = with_data(
        tmp_path,
        "n=31.5",
        "movel(appro(p,{1,2,3,n,15,-72}),flange,m)",
        "movel(appro(p,{1,2,3,31.5,15,-72}),flange,m)",
    ).plan()
    first, second = plan.moves.target
    np.testing.assert_allclose(
        plan.positions.quaternion[first], plan.positions.quaternion[second], atol=1e-12
    )


def test_points_stand_in_their_frames_and_frames_in_theirs(tmp_path: Path) -> None:
    plan = with_data(tmp_path, "movel(p[1],flange,m)").plan()
    np.testing.assert_allclose(plan.positions.position[plan.moves.target[0]], [0.095, 0.02, 0.05], atol=1e-12)


def test_each_element_has_a_frame_of_its_own(tmp_path: Path) -> None:
    found = with_data(tmp_path, "movel(q[0],flange,m)", "movel(q[1],flange,m)", "movel(q[n],flange,m)")
    assert [one.frame for one in moves(found)] == [Named("f"), FrameRef("base")]
    assert codes(found) == ["P576", "P575"]


def test_a_move_takes_speed_and_corner_from_its_descriptor(tmp_path: Path) -> None:
    found = with_data(tmp_path, "movej(j,flange,m)", "movel(p,flange,m)", "movel(p[1],flange,still)")
    units = [one.speed.unit for one in moves(found) if one.speed is not None]
    assert units == [SpeedUnit.FRACTION, SpeedUnit.TRAVEL, SpeedUnit.TRAVEL]
    plan = found.plan("yaskawa/gp25")
    assert plan.moves.fraction[0] == pytest.approx(0.4)
    assert list(plan.moves.travel[1:]) == pytest.approx([0.25, 0.25])
    assert list(plan.moves.blend[:2]) == pytest.approx([0.005, 0.005])
    assert plan.moves.blend_code[2] == 0
    np.testing.assert_allclose(
        np.degrees(plan.positions.axes[plan.moves.target[0], :3]), [10, 0, -20], atol=1e-12
    )


def test_a_descriptor_changed_by_the_program_holds(tmp_path: Path) -> None:
    plan = with_data(tmp_path, "m.tmax=80", "m.blend=off", "movel(p,flange,m)").plan()
    assert plan.moves.travel[0] == pytest.approx(0.08)
    assert plan.moves.blend_code[0] == 0


def test_ports_are_signals_by_their_names(tmp_path: Path) -> None:
    body = with_data(tmp_path, "out=true", "wait(out==false)").routines[0].body
    assert body[0].signal == Signal("out", Text("out"))  # type: ignore[union-attr]
    assert body[0].value == SignalState(True)  # type: ignore[union-attr]


def test_break_ends_a_case_and_leaves_a_loop() -> None:
    found = program(
        "n=2", "while true", "switch n", "case 1", "delay(0.1)", "break", "case 2,3", "delay(0.2)", "break", "default",
        "delay(0.3)", "break", "endSwitch", "break", "endWhile",
    )  # fmt: skip
    assert codes(found) == []
    assert [step.duration for step in found.plan().steps()] == pytest.approx([0.2])


def test_a_watch_waits_and_says_whether_it_came() -> None:
    found = program("if watch(di==true,2.5)==false", "endIf", "bCame=watch(di==true,1.5)")
    waits = [one.timeout.literal for one in found.routines[0].body if hasattr(one, "timeout") and one.timeout]
    assert waits == [2.5, 1.5]


def test_code_that_is_escaped_instead_of_quoted_is_read() -> None:
    raw = (
        b'<programList><program name="a"><source>\n<code>begin\nif 1 &lt; 2\ndelay(0.5)\nendIf\nend</code>\n'
        b"</source></program></programList>\n"
    )
    found = read_source(decode(raw, "a.pgx"))
    assert codes(found) == []
    assert [step.duration for step in found.plan().steps()] == [0.5]


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("movel(p,flange)", "P570"),
        ("while", "P570"),
        ("enablePower()", "P571"),
        ("n=" + "(" * 150 + "1" + ")" * 150, "P572"),
        ("while true", "P573"),
        ("alterMovel(p)", "P575"),
        ("movel(p,flange,{100,50,100,250,9999,leave,10,10})", "P575"),
        ("movel({1,2,3,4,5},flange,m)", "P570"),
    ],
)
def test_each_mistake_has_its_code_and_a_place(line: str, code: str) -> None:
    (found,) = program(line).diagnostics
    assert (found.code, found.line) == (code, 5)
    assert found.help


def test_files_and_missing_data_have_codes() -> None:
    assert codes(read_source(decode(b"poem\n", "a.pgx"))) == ["P574"]
    assert codes(read_source(decode(b'<Programs><Program name="a">\n<Code>begin\n', "a.pgx"))) == ["P573"]
    assert codes(program("movel(pNowhere,flange,m)")) == ["P576", "P577"]


def test_the_sample_goes_where_its_numbers_say() -> None:
    check_plan(olp.read(FOLDER / "start.pgx").plan("yaskawa/gp25"))


def test_the_sample_is_read_whole() -> None:
    check_whole(sorted(path for path in FOLDER.iterdir() if path.is_file()), frozenset({"P576"}))


@pytest.mark.parametrize("name", ["start.pgx", "handling.dtx", "handling.pjx"])
def test_no_damage_makes_the_reader_raise_or_hang(name: str) -> None:
    check_damage(FOLDER / name, 9)


def test_characters_of_texts_are_counted_from_0() -> None:
    found = program(
        's = "abcd"', "n = asc(mid(s,2,1),1)", "s = left(s,1)+chr(65)", "delay(n)", "delay(asc(s,1))"
    )
    steps = [step.duration for step in found.plan().steps()]
    assert steps == pytest.approx([ord("c"), ord("A")])


def test_the_state_of_an_output_is_read_from_the_output(tmp_path: Path) -> None:
    """It was read from an input of the same name, which the target then had as another signal."""
    found = with_data(tmp_path, "out=!out", "if dioGet(out)", "endIf")
    (write,) = [one for one in found.routines[0].body if isinstance(one, SetOutput)]
    assert write.value == Unary("not", Signal("out", Text("out")))
    (asked,) = [one for one in found.routines[0].body if isinstance(one, If)]
    assert asked.condition == Signal("out", Text("out"))
    (tmp_path / "data.dtx").write_text(DATA.replace('link="x"', 'link="BasicIO-1\\%Q3"'))
    (tmp_path / "start.pgx").write_bytes(text("wait(out)"))
    (wait,) = [one for one in olp.read(tmp_path / "start.pgx").routines[0].body if isinstance(one, Wait)]
    assert wait.condition == Signal("out", Text("out"))


def test_an_axis_of_joint_values_is_their_element(tmp_path: Path) -> None:
    """KRL got `j.j6`, which no E6AXIS has."""
    found = with_data(tmp_path, "j.j6=j.j6+90")
    (one,) = [one for one in found.routines[0].body if isinstance(one, Assign)]
    assert one.target == Item(Named("j"), (Number(6),))


def test_a_parameter_of_a_type_of_the_project_keeps_its_type() -> None:
    """It was taken for a number, of which the target got members."""
    head = (
        '<Parameters><Parameter name="x_c" type="Motion" /><Parameter name="x_n" type="num" /></Parameters>'
    )
    (routine,) = program("x_n=x_c.speed", head=head).routines
    assert [one.type for one in routine.parameters] == ["Motion", "real"]


def _turned(x: float, y: float, z: float, *angles: float) -> np.ndarray:
    found = np.eye(4)
    found[:3, :3] = Rotation.from_euler("XYZ", angles, degrees=True).as_matrix()
    found[:3, 3] = x, y, z
    return found


@pytest.mark.parametrize("reference", ["f", "g", "world"])
def test_compose_moves_a_point_as_the_frame_sees_it(tmp_path: Path, reference: str) -> None:
    g, f = _turned(400, 100, 50, 0, 0, 0), _turned(100, 0, 0, 0, 0, 90)
    frames = {"f": g @ f, "g": g, "world": np.eye(4)}
    point, by = frames["f"] @ _turned(20, 5, 200, 0, 170, 0), _turned(3, -7, 20, 10, 20, 30)
    seen = np.linalg.inv(frames[reference]) @ point
    data = DATA.replace(
        'name="g" type="frame" size="1"><Value key="0"',
        'name="g" type="frame" size="1"><Value key="0" x="400" y="100"',
    )
    (tmp_path / "data.dtx").write_text(data.replace('x="20" y="5"', 'x="20" y="5" z="200" ry="170"', 1))
    line = f"movel(compose(p[1],{reference},{{3,-7,20,10,20,30}}),flange,still)"
    (tmp_path / "start.pgx").write_bytes(text("movej({0,20,70,0,60,0},flange,still)", line))
    plan = olp.read(tmp_path / "start.pgx").plan("staubli/tx2-60l")
    wanted = frames[reference] @ by @ seen
    wanted[:3, 3] *= mm
    np.testing.assert_allclose(poses(plan)[-1], wanted, atol=1e-7)


def test_where_the_arm_stands_is_a_point_of_the_frame_that_it_is_asked_in(tmp_path: Path) -> None:
    (move,) = moves(with_data(tmp_path, "p[0]=here(flange,f)", "movel(appro(p[0],{0,0,9,0,0,0}),flange,m)"))
    assert move.frame == Named("f")
    (move,) = moves(with_data(tmp_path, "movel(compose(here(flange,f),f,{0,0,9,0,0,0}),flange,m)"))
    assert move.frame == Named("f")


def test_the_types_of_a_project_are_in_its_libraries(tmp_path: Path) -> None:
    """As `Disk://` says, from the folder that holds the project's own."""
    project, library = tmp_path / "server", tmp_path / "types" / "Order"
    project.mkdir()
    library.mkdir(parents=True)
    rows = '<Data name="{}" type="{}" size="{}" />'
    members = [("nCount", "num", 1), ("jGoal", "jointRx", 1), ("mSpeed", "mdesc", 1), ("nTimes", "num", 3)]
    data = "\n".join(rows.format(*one) for one in members)
    (library / "Order.dtx").write_text(f"<Database><Datas>\n{data}\n</Datas></Database>\n")
    types = '<Types><Type name="Order" path="Disk://types/Order/Order.pjx" /></Types>'
    (project / "server.pjx").write_text(f"<Project>\n{types}\n</Project>\n")
    head = '<Locals><Local name="l_order" type="Order" size="1" /></Locals>'
    lines = ("l_order.nCount=3", "l_order.jGoal=herej()", "movej(l_order.jGoal,flange,l_order.mSpeed)")
    (project / "start.pgx").write_bytes(text(*lines, head=head))
    context = Context(load_robot("staubli/tx2-60l"), on_loss="comment")
    made = convert(link(olp.read(project / "start.pgx")).program, "rapid", context)
    written = made.files[made.main].decode().replace(" ", "")
    assert "l_order_nCount:=3;" in written
    assert "MoveAbsJl_order_jGoal" in written


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_an_angle_that_is_computed_is_one_of_the_inverse(tmp_path: Path, target: str) -> None:
    """No register holds the inverse: the line was left out, and the move after it."""
    rows = ("l_p.trsf.rx=l_p.trsf.rx+5*i", "l_p.trsf.z=l_p.trsf.z+i", "movel(l_p,flange,still)")
    head = "".join(
        f'<Local name="{name}" type="{kind}" size="1" />' for name, kind in (("l_p", "point"), ("i", "num"))
    )
    lines = ("l_p={900,100,600,10,170,20}", "for i=1 to 3", *rows, "endFor")
    found = link(with_data(tmp_path, *lines, head=f"<Locals>{head}</Locals>")).program
    robot = load_robot("yaskawa/gp25")
    made = convert(found, target, Context(robot, on_loss="comment"))
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    plan = run_converted(made, target, robot, found)
    for ours, right in zip(poses(plan), poses(found.plan(robot)), strict=True):
        np.testing.assert_allclose(ours, right, atol=2e-5)


GRAB = """<Programs>
<Program name="grab">
<Parameters>
<Parameter name="x_p" type="pointRx" xsi:type="element" use="value" />
<Parameter name="x_tool" type="tool" xsi:type="element" use="reference" />
</Parameters>
<Code><![CDATA[begin
movel(appro(x_p,{0,0,-5,0,0,0}),x_tool,free)
movel(x_p,x_tool,still)
end]]></Code>
</Program>
</Programs>
"""


def test_a_point_that_is_handed_over_stands_in_its_frame(tmp_path: Path) -> None:
    """q's second point stands in the world, p's in f, which stands in g: [20, 5, 0] there is [95, 20, 50]."""
    (tmp_path / "grab.pgx").write_text(GRAB)
    head = '<Locals><Local name="t" type="tool" xsi:type="array" size="1" /></Locals>'
    found = with_data(tmp_path, "call grab(p[1],t)", "call grab(q[1],t)", head=head)
    (tmp_path / "data.dtx").write_text(
        DATA.replace("</Datas>", '<Data name="free" type="mdesc" size="1"><Value key="0" /></Data></Datas>')
    )
    found = olp.read(tmp_path / "start.pgx")
    plan = found.plan()
    places = plan.positions.position[[plan.moves.target[1], plan.moves.target[3]]]
    np.testing.assert_allclose(places, [[0.095, 0.02, 0.05], [0.02, 0, 0]], atol=1e-12)
    made = convert(link(found).program, "rapid", Context(load_robot("staubli/tx2-60l"), on_loss="comment"))
    written = made.files[made.main].decode()
    assert "PROC grab(robtarget x_p,PERS tooldata x_tool,PERS wobjdata x_p_frame)" in written
    assert "grab p{2},t,f;" in written
    assert "grab q{2},t,wobj0;" in written
    assert "bounded by vel alone" in str(made.translated.losses)


def test_where_ways_join_a_point_stands_in_one_of_their_frames(tmp_path: Path) -> None:
    head = '<Locals><Local name="l_p" type="pointRx" xsi:type="array" size="1" /></Locals>'
    branch = ("if j.j1>0", "l_p=p[0]", "else", "l_p=q[1]", "endIf", "movel(l_p,flange,m)")
    found = with_data(tmp_path, *branch, head=head)
    assert codes(found) == ["P575"]
    assert "several frames" in found.diagnostics[0].message
    alike = ("if j.j1>0", "l_p=p[0]", "else", "l_p=q[0]", "endIf", "movel(l_p,flange,m)")
    assert [one.frame for one in moves(with_data(tmp_path, *alike, head=head))] == [Named("f")]
    loop = ("l_p=p[0]", "while j.j1>0", "movel(l_p,flange,m)", "l_p=q[1]", "endWhile")
    assert "P577" in codes(with_data(tmp_path, *loop, head=head))


def test_points_of_an_array_get_the_frames_of_those_that_they_are_set_to(tmp_path: Path) -> None:
    head = '<Locals><Local name="l_p" type="pointRx" xsi:type="array" size="3" /></Locals>'
    filled = ("for n=0 to 2", "l_p[n]=p[0]", "endFor", "movel(l_p[1],flange,m)")
    assert [one.frame for one in moves(with_data(tmp_path, *filled, head=head))] == [Named("f")]
    apart = ("l_p[0]=p[0]", "l_p[1]=q[1]", "movel(l_p[0],flange,m)", "movel(l_p[1],flange,m)")
    assert [one.frame for one in moves(with_data(tmp_path, *apart, head=head))] == [
        Named("f"),
        FrameRef("base"),
    ]
    assert "P575" in codes(with_data(tmp_path, *apart, "movel(l_p[n],flange,m)", head=head))


def test_a_descriptor_that_never_blends_stops_also_where_its_speed_changes(tmp_path: Path) -> None:
    found = with_data(tmp_path, "movel(p[0],flange,still)", "still.tmax=90", "movel(p[1],flange,still)")
    made = convert(link(found).program, "rapid", Context(load_robot("staubli/tx2-60l"), on_loss="comment"))
    written = made.files[made.main].decode()
    assert written.count(",fine,") == 2
