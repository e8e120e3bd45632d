"""Translations run as their source does, and whatever they change is in the receipt."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from translate_programs import Maker, round_trip
from translated_texts import VENDORS

import olp
from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.fluent import Program
from olp.ir.block_structure import negated
from olp.ir.expressions import (
    Compare,
    FrameRef,
    Logic,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    SignalState,
    Variable,
)
from olp.ir.points import PointTable
from olp.ir.program import (
    Assign,
    Blend,
    BlendKind,
    Call,
    Declare,
    EndIf,
    If,
    Move,
    Process,
    Routine,
    SetBlend,
    SetFrame,
    SetOverride,
    SetSpeed,
    SetTool,
    Speed,
    SpeedUnit,
)
from olp.ir.program import Path as Shape
from olp.robots.robot import load_robot
from olp.transpile import Context, Mapping, canonical
from olp.transpile.arcs import half_way
from olp.transpile.compare import compare_plans
from olp.transpile.context import read_mapping
from olp.transpile.convert import convert, run_converted
from olp.transpile.link import link
from olp.transpile.modal_state import modal_settings
from olp.transpile.pipeline import work_for
from olp.transpile.support import kinds, support

SAMPLES = Path(__file__).parent.parent / "samples"
HANDLING = {
    "inform": "inform/handling/HANDLING.JBI",
    "krl": "krl/handling.src",
    "rapid": "rapid/handling.mod",
    "tp": "tp/handling.ls",
    "urscript": "urscript/handling.script",
}
PAIRS = [(a, b) for a in VENDORS for b in VENDORS if a != b]
ROBOT = load_robot("yaskawa/gp25")
MM, PERCENT = 0.001, 0.01


def linked(vendor):
    return link(olp.read(SAMPLES / HANDLING[vendor])).program


# --- all languages --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("source", "target"), PAIRS)
def test_the_sample_runs_the_same_in_every_other_language(source, target):
    program = linked(source)
    made = convert(program, target, Context(robot=ROBOT, on_loss="comment"))
    losses = made.translated.losses
    named = {loss.part for loss in losses}
    found = compare_plans(
        program.plan(robot=ROBOT),
        run_converted(made, target, ROBOT, program),
        speeds=not named & {"speed", "configuration"},
        blends="blend" not in named,
        without={loss.line for loss in losses if loss.leaves_out},
    )
    assert found.is_equal, found.differences
    assert found.steps == 15
    assert found.worst_position <= 1e-6
    assert found.worst_angle <= math.radians(1e-4)


@pytest.mark.parametrize(("source", "target"), PAIRS)
def test_random_programs_come_back_as_they_were(source, target):
    for seed in (0, 1):
        assert round_trip(seed, source, target, ROBOT) == [], seed


def test_blends_for_urscript_never_meet(tmp_path):
    """Other controllers cut a zone to half of the way; URScript leaves such a point out of the path."""
    module = tmp_path / "m.mod"
    points = [(500, 0, 600), (500, 90, 600), (500, 150, 600), (500, 150, 500), (540, 150, 500)]
    zones = ["fine", "z100", "z50", "z10", "z5"]
    moves = [
        f"    MoveL [[{x},{y},{z}],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v200,{zone},tool0;"
        for (x, y, z), zone in zip(points, zones, strict=True)
    ]
    module.write_text("\n".join(["MODULE m", "  PROC main()", *moves, "  ENDPROC", "ENDMODULE", ""]))
    program = olp.read(module)
    made = convert(program, "urscript", Context(robot=ROBOT))
    radii = run_converted(made, "urscript", ROBOT, program).moves.blend[1:4] / MM
    ways = [90, 60, 100, 40]
    assert all(a + b < way for a, b, way in zip([0, *radii], [*radii, 0], ways, strict=True))
    assert radii == pytest.approx([29.99, 29.99, 10])
    told = [(loss.line, round(loss.size, 2)) for loss in made.translated.losses if loss.part == "blend"]
    assert told == [(4, 70.01), (5, 20.01)]


@pytest.mark.parametrize("target", VENDORS)
def test_a_moved_point_is_seen_by_the_comparison(target):
    program = Maker(3).program()
    plan = program.plan(robot=ROBOT)
    at = next(n for n, d in enumerate(program.data) if d.name.startswith("pt"))
    literal = program.data[at].value
    moved = replace(literal, values=(literal.values[0] + 2e-6, *literal.values[1:]))
    data = (*program.data[:at], replace(program.data[at], value=moved), *program.data[at + 1 :])
    made = convert(replace(program, data=data), target, Context(robot=ROBOT))
    assert compare_plans(plan, run_converted(made, target, ROBOT), blends=False, speeds=False).differences


def test_a_program_of_the_same_language_stays_as_it_is():
    program = linked("krl")
    assert canonical(program, "krl").program is program


def test_an_unknown_language_is_refused():
    with pytest.raises(OlpError) as told:
        canonical(linked("krl"), "basic")
    assert [d.code for d in told.value.diagnostics] == ["X010"]


def test_export_uses_the_same_passes():
    program = linked("rapid")
    made = convert(program, "urscript", Context(robot=ROBOT))
    with pytest.raises(OlpError) as told:  # without a robot the joint speeds mean nothing
        program.export("urscript")
    assert {d.code for d in told.value.diagnostics} == {"X012"}
    assert b"movej" in made.files[made.main]


# --- modal values ---------------------------------------------------------------------------------------

STOP = Blend(BlendKind.RADIUS)


def speed(value):
    return Speed(SpeedUnit.TRAVEL, Quantity(Number(value), MM))


def move(line, **more):
    return Move(line, Shape.LINEAR, (Named("p"),), None, Blend(BlendKind.RADIUS), **more)


def program_of(*body, routines=(), data=()):
    point = Declare(0, "p", "position", PositionLiteral("pose", (0.9, 0.1, 0.5, 3.0, 0.1, 0.2)), shared=True)
    rows = tuple(replace(s, line=n) for n, s in enumerate(body, 1))
    first = Routine("MAIN", 1, rows, PointTable())
    source = decode(b"\n" * 99, "made", "cp1252")
    return Program("krl", source, (first, *routines), data=(point, *data), main="MAIN")


def moves_of(program, target="rapid"):
    work = work_for(program, target, Context())
    result = modal_settings(program, work)
    return [s for s in result.statements() if isinstance(s, Move)], result


def test_each_move_gets_the_speed_and_blend_that_reach_it():
    small = SetBlend(0, (Blend(BlendKind.RADIUS, Quantity(Number(5), MM)),))
    (one, two), _ = moves_of(
        program_of(SetSpeed(0, (speed(100),)), small, move(0), SetSpeed(0, (speed(200),)), move(0))
    )
    assert one.speed == speed(100)
    assert two.speed == speed(200)
    assert one.blend.value == two.blend.value == Quantity(Number(5), MM)


def test_a_speed_that_depends_on_the_way_is_held_by_a_variable():
    test = Compare("=", Named("n"), Number(1))
    program = program_of(
        SetSpeed(0, (speed(100),)),
        If(0, test),
        SetSpeed(0, (speed(200),)),
        EndIf(0),
        move(0),
        data=(Declare(0, "n", "integer", Number(1)),),
    )
    (found,), result = moves_of(program)
    name = found.speed.value.written
    assert isinstance(name, Named)
    written = [s.value for s in result.statements() if isinstance(s, Assign) and s.target == name]
    assert written == [Number(100.0), Number(200.0)]


def test_a_called_routine_changes_what_holds_for_its_caller():
    inner = Routine("SUB", 10, (SetSpeed(10, (speed(300),)),), PointTable())
    (found,), _ = moves_of(program_of(SetSpeed(0, (speed(100),)), Call(0, "SUB"), move(0), routines=(inner,)))
    assert found.speed == speed(300)


def test_a_routine_called_at_two_speeds_moves_at_both():
    inner = Routine("SUB", 10, (replace(move(0), line=10),), PointTable())
    program = program_of(
        SetSpeed(0, (speed(100),)),
        Call(0, "SUB"),
        SetSpeed(0, (speed(200),)),
        Call(0, "SUB"),
        routines=(inner,),
    )
    (found,), result = moves_of(program)
    assert isinstance(found.speed.value.written, Named)
    assert sum(isinstance(s, Assign) for s in result.statements()) == 2


def test_an_override_is_multiplied_into_the_speeds_of_a_language_without_one():
    rows = (SetOverride(0, Quantity(Number(50), PERCENT)), SetSpeed(0, (speed(100),)), move(0))
    (found,), _ = moves_of(program_of(*rows), "urscript")
    assert found.speed.value.literal == pytest.approx(0.05)


def test_tools_and_frames_reach_their_moves():
    tool = PositionLiteral("pose", (0.0, 0.0, 0.2, 0.0, 0.0, 0.0))
    rows = (move(0), SetTool(0, tool), SetFrame(0, FrameRef("user", Number(3))), move(0))
    (one, two), _ = moves_of(program_of(SetSpeed(0, (speed(9),)), *rows))
    assert (one.tool, one.frame) == (FrameRef("tool", Number(0)), FrameRef("base"))
    assert (two.tool, two.frame) == (tool, FrameRef("user", Number(3)))


# --- pieces ---------------------------------------------------------------------------------------------


def test_the_middle_of_an_arc_lies_on_its_circle_and_on_the_right_side():
    angles = np.radians([10.0, 60.0, 100.0])
    a, b, c = (np.array([math.cos(t), math.sin(t), 0.3]) for t in angles)
    middle = half_way(a, b, c)
    assert np.allclose(middle, [math.cos(math.radians(35)), math.sin(math.radians(35)), 0.3])
    # More than half of the circle between the two, the third point on the short side.
    long = half_way(c, a, b)
    assert np.allclose(long, [math.cos(math.radians(235)), math.sin(math.radians(235)), 0.3])


def test_the_opposite_of_a_condition():
    a, b, c = (Compare("<", Named(name), Number(1)) for name in "abc")
    turned = negated(Logic(a, (("and", b), ("or", c))))
    assert [word for word, _ in turned.rest] == ["or", "and"]
    assert negated(turned) == Logic(a, (("and", b), ("or", c)))
    assert negated(SignalState(True)) == SignalState(False)


def test_names_are_legal_and_apart():
    data = tuple(
        Declare(0, name, "integer", Number(1), shared=True)
        for name in ("Größe", "groesse", "x" * 60, "x" * 61, "IF", "2nd")
    )
    uses = [Assign(0, Named(d.name), Number(2)) for d in data]
    made = canonical(program_of(*uses, data=data), "rapid")
    names = [d.name for d in made.program.data if d.name != "p"]
    assert len({name.casefold() for name in names}) == len(data)
    assert all(len(name) <= 32 and name.isascii() and not name[0].isdigit() for name in names)
    assert "IF" not in names
    assert made.mapping[("variable", "Größe")] == "Groesse"


def test_what_cannot_be_said_is_refused_with_its_line_or_becomes_a_comment():
    program = program_of(SetSpeed(0, (speed(9),)), Process(0, "ARCON"), move(0))
    with pytest.raises(OlpError) as told:
        convert(program, "rapid", Context(robot=ROBOT))
    assert [(d.code, d.line) for d in told.value.diagnostics] == [("X011", 2)]
    made = convert(program, "rapid", Context(robot=ROBOT, on_loss="comment"))
    assert b"! not translated" in made.files[made.main]
    assert [(loss.line, loss.fate.value) for loss in made.translated.losses] == [(2, "commented")]


def test_a_joint_speed_without_a_robot_is_no_number():
    with pytest.raises(OlpError) as told:
        convert(linked("tp"), "rapid", Context())
    assert {d.code for d in told.value.diagnostics} == {"X012"}


def test_a_joint_move_takes_as_long_on_another_robot():
    other = load_robot("yaskawa/ma2010")
    program = linked("krl")
    made = convert(program, "inform", Context(ROBOT, other, on_loss="comment"))
    plan = run_converted(made, "inform", other, program)
    fractions = plan.moves.fraction[~np.isnan(plan.moves.fraction)]
    first = program.plan(robot=ROBOT)
    one = next(row for row in range(len(first.moves)) if first.moves.fraction[row] == 0.55)
    turned = np.abs(
        first.positions.axes[first.moves.target[one]] - first.positions.axes[first.moves.start[one]]
    )[:6]
    wanted = (turned / other.speeds).max() / ((turned / ROBOT.speeds).max() / 0.55)
    assert np.isclose(fractions, wanted, rtol=1e-3).any()


def test_mapped_tools_frames_and_signals_are_used():
    mapping = Mapping(
        tools={"tGripper": "5"}, frames={"wTable": "4"}, signals={"out do3": "12"}, set_values=False
    )
    made = convert(linked("rapid"), "inform", Context(robot=ROBOT, mapping=mapping))
    text = made.files[made.main].decode()
    assert "///TOOL 5" in text
    assert "///USER 4" in text
    assert "DOUT OT#(12) OFF" in text
    assert "SETTOOL" not in text


def test_a_mapping_file_tells_all_that_is_wrong_with_it(tmp_path):
    file = tmp_path / "map.toml"
    file.write_text("tool = 1\nset_values = 3\n[frames]\na = [1]\n")
    with pytest.raises(OlpError) as told:
        read_mapping(file)
    assert [d.code for d in told.value.diagnostics] == ["X013"] * 3


@pytest.mark.slow
def test_a_long_straight_job_is_split_into_jobs_that_run_in_order():
    rows = []
    data = []
    for n in range(10_500):
        data.append(
            Declare(
                0,
                f"q{n}",
                "position",
                PositionLiteral("pose", (0.9, 1e-5 * n, 0.5, 3.0, 0.1, 0.2)),
                shared=True,
            )
        )
        stop = Blend(BlendKind.RADIUS, Quantity(Number(0), MM))
        rows.append(
            Move(
                0,
                Shape.LINEAR,
                (Named(f"q{n}"),),
                speed(100),
                stop,
                tool=FrameRef("tool", Number(0)),
                frame=FrameRef("base"),
            )
        )
    program = program_of(*rows, data=tuple(data))
    made = convert(program, "inform", Context())
    assert sorted(made.files) == ["MAIN.JBI", "MAIN_1.JBI", "MAIN_2.JBI"]
    assert compare_plans(program.plan(), run_converted(made, "inform", None)).is_equal


# --- commands -------------------------------------------------------------------------------------------


def run(*arguments):
    return main([str(a) for a in arguments])


def test_convert_writes_files_and_a_receipt(tmp_path, capsys):
    out, receipt = tmp_path / "out", tmp_path / "receipt.json"
    code = run(
        "convert",
        SAMPLES / HANDLING["tp"],
        "--to",
        "krl",
        "--robot",
        "yaskawa/gp25",
        "-o",
        out,
        "--receipt",
        receipt,
    )
    assert code == 0
    assert sorted(path.name for path in out.iterdir()) == ["HANDLING.dat", "HANDLING.src"]
    found = json.loads(receipt.read_text())
    assert found["totals"]["refused"] == 0
    assert found["difference"]["says"] == []
    assert found["difference"]["position_mm"] <= 0.001
    assert len(found["time"]["segments"]) == found["difference"]["steps"]
    assert found["time"]["source_s"] == pytest.approx(found["time"]["target_s"], rel=0.3)
    assert "both run: 15 steps" in capsys.readouterr().out


def test_a_refused_translation_leaves_nothing_behind(tmp_path, capsys):
    job = SAMPLES / "inform/pitfalls/weaving.jbi"
    code = run("convert", job, "--to", "krl", "--robot", "yaskawa/ma2010", "-o", tmp_path / "out")
    assert code == 2
    assert not (tmp_path / "out").exists()
    assert "X011" in capsys.readouterr().err


def test_files_that_are_there_stay_as_they_are(tmp_path, capsys):
    arguments = (
        "convert",
        SAMPLES / HANDLING["tp"],
        "--to",
        "krl",
        "--robot",
        "yaskawa/gp25",
        "-o",
        tmp_path,
    )
    (tmp_path / "HANDLING.dat").write_text("mine")
    assert run(*arguments) == 2
    assert (tmp_path / "HANDLING.dat").read_text() == "mine"
    assert "C009" in capsys.readouterr().err
    assert run(*arguments, "--force") == 0


@pytest.mark.parametrize("source", VENDORS)
@pytest.mark.parametrize("target", VENDORS)
def test_a_flat_translation_runs_as_the_program_does(source, target):
    program = linked(source)
    made = convert(program, target, Context(robot=ROBOT, flat=True))
    named = {loss.part for loss in made.translated.losses}
    plan, other = program.plan(robot=ROBOT), run_converted(made, target, ROBOT, program)
    found = compare_plans(
        plan, other, speeds=not named & {"speed", "configuration"}, blends="blend" not in named
    )
    assert found.is_equal, found.differences
    # INFORM's arc is a chain: its first point, where the arm stands already, and two parts.
    assert found.steps == 15 + (source == "inform") * (2 if target == "inform" else 1)
    assert found.worst_position <= 1e-6
    assert len([name for name in made.files if not name.endswith(".dat")]) == 1


def test_every_kind_of_statement_is_in_the_table(capsys):
    assert run("vendors", "--format", "json") == 0
    found = json.loads(capsys.readouterr().out)
    assert tuple(found["statements"]) == kinds()
    assert all(set(row) >= set(VENDORS) for row in found["statements"].values())


def test_the_table_says_what_the_writers_do():
    table = support()
    assert all(table["Move linear"][vendor].writes == "exact" for vendor in VENDORS)
    assert all(table["Move linear"][vendor].reads for vendor in VENDORS)
    assert not table["Repeat"]["rapid"].reads
    assert table["Repeat"]["rapid"].writes == "exact"
    assert not any(table["Opaque"][vendor].writes for vendor in VENDORS)


def test_variables_have_no_numbers_in_a_language_with_names():
    made = canonical(linked("inform"), "rapid", Context(robot=ROBOT))
    assert not any(isinstance(s, Variable) for r in made.program.routines for s in r.body)


COMPUTED = """def main():
  def add(x, y=2):
    return x + y
  end
  set_tcp(p[0,0,0.1,0,0,0])
  base = p[0.4, 0.1, 0.3, 0, 3.14159, 0]
  z = 0.05
  n = add(1)
  z = 0.01 * add(n, y=2)
  movej([0.1,-1.2,1.5,-1.8,-1.5,0.2], a=1.4, v=1.05)
  movel(base, a=1.2, v=0.25)
  q = p[base[0]+z, base[1], base[2]+0.02, base[3], base[4], base[5]]
  movel(q, a=1.2, v=0.25)
  q = p[q[1]+0.4, q[0], q[2], q[3], q[4], q[5]]
  movel(q, a=1.2, v=0.25)
  movel(p[base[0]+0.1, base[1]+z, base[2], base[3], base[4], base[5]], a=1.2, v=0.25)
  rx = base[3]
end
main()
"""


@pytest.mark.parametrize("target", [vendor for vendor in VENDORS if vendor != "urscript"])
def test_computed_positions_and_arguments_left_out_mean_the_same_elsewhere(tmp_path, target):
    source = tmp_path / "computed.script"
    source.write_text(COMPUTED)
    receipt = tmp_path / "receipt.json"
    arguments = ("--robot", "yaskawa/gp25", "-o", tmp_path / "out", "--receipt", receipt)
    assert run("convert", source, "--to", target, *arguments) == 0
    found = json.loads(receipt.read_text())["difference"]
    assert found["steps"] == 5
    assert found["says"] == []
    assert found["position_mm"] <= 0.001


def test_the_stop_handler_and_continue_of_krl_are_no_loss(tmp_path):
    source = tmp_path / "k.src"
    source.write_text(
        "DEF k()\nGLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )\nINTERRUPT ON 3\n"
        "BAS (#VEL_PTP,40)\nPTP {A1 5.5,A2 -90,A3 90,A4 3.5,A5 40,A6 21}\nCONTINUE\n$OUT[3]=TRUE\nEND\n"
    )
    receipt = tmp_path / "receipt.json"
    arguments = ("--robot", "yaskawa/gp25", "-o", tmp_path / "out", "--receipt", receipt)
    assert run("convert", source, "--to", "urscript", *arguments) == 0
    found = json.loads(receipt.read_text())
    assert not [loss for loss in found["losses"] if loss["statement"] == "Process"]
    assert found["difference"]["says"] == []
    assert sum("means nothing to another controller: it is left out" in note for note in found["notes"]) == 3
    assert "CONTINUE" not in (tmp_path / "out" / "k.script").read_text()


OWN_ALONE = """MODULE M
VAR loadsession s;
PERS tooldata held:=[FALSE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
CONST robtarget p1:=[[900,0,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
MoveL p1,v100,fine,tool0;
WaitLoad s;
IF RobOS() THEN
WaitTime 1;
ENDIF
MoveL p1,v100,fine,held;
WaitTime 2;
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("target", [vendor for vendor in VENDORS if vendor != "rapid"])
def test_what_names_data_of_its_own_language_or_a_tool_beside_the_robot_becomes_a_comment(tmp_path, target):
    source = tmp_path / "m.mod"
    source.write_text(OWN_ALONE)
    program = link(olp.read(source)).program
    made = convert(program, target, Context(robot=ROBOT, on_loss="comment"))
    commented = {loss.line: loss.says for loss in made.translated.losses if loss.fate.value == "commented"}
    assert sorted(commented) == [7, 8, 9, 10, 11]
    assert "RobOS" in commented[8]
    assert "beside the robot" in commented[11]
    with pytest.raises(OlpError) as told:
        convert(program, target, Context(robot=ROBOT))
    assert "X011" in {d.code for d in told.value.diagnostics}


TASKS = """/JOB
//NAME MAIN
//POS
///NPOS 0,0,0,0,0,0
//INST
///DATE 2026/03/02 14:07
///ATTR SC,RW
NOP
PWAIT SUB3
CALL JOB:SHOW ARGF"mm/s" ARGF-3.25
END
/JOB
//NAME SHOW
//POS
///NPOS 0,0,0,0,0,0
//INST
///DATE 2026/03/02 14:07
///ATTR SC,RW
///LVARS 0,0,0,0,1,0,0,0
NOP
GETARG LS000 IARG#(1)
MSG LS000
END
"""


@pytest.mark.parametrize(
    ("target", "head", "call"),
    [
        ("krl", "DEF SHOW (arg1[] :IN)", 'SHOW ("mm/s")'),
        ("rapid", "PROC SHOW(string arg1)", 'SHOW "mm/s";'),
        ("urscript", "def SHOW(arg1):", 'SHOW("mm/s")'),
    ],
)
def test_arguments_have_the_type_that_is_read_and_those_that_nothing_reads_are_left_out(
    tmp_path, target, head, call
):
    source = tmp_path / "MAIN.JBI"
    source.write_text(TASKS)
    made = convert(link(olp.read(source)).program, target, Context(robot=ROBOT, on_loss="comment"))
    lines = [line.strip() for line in made.files[made.main].decode().splitlines()]
    assert head in lines
    assert call in lines
    assert any("SHOW takes 1 of its 2 arguments" in told.says for told in made.translated.remarks)
    assert [loss.says for loss in made.translated.losses] == [
        "the end of a task that nothing here starts: SUB3"
    ]


NO_POINTS = (
    "/JOB\n//NAME {}\n//POS\n///NPOS 0,0,0,0,0,0\n"
    "//INST\n///DATE 2026/01/01 00:00\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\n"
)


def test_a_refusal_in_a_called_program_names_its_own_file_and_line(tmp_path, capsys):
    """SETUALM has no word in URScript; it stands in the second file, whose lines follow those of the first."""
    (tmp_path / "MAIN.JBI").write_text(NO_POINTS.format("MAIN") + "CALL JOB:SUB\nEND\n")
    alarm = 'TIMER T=0.5\nSETUALM 8012 "NO CARTON" 0\nEND\n'
    (tmp_path / "SUB.JBI").write_text(NO_POINTS.format("SUB") + alarm)
    status = main(["convert", str(tmp_path / "MAIN.JBI"), "--to", "urscript", "-o", str(tmp_path / "out")])
    told = capsys.readouterr().err
    assert status == 2
    assert "SUB.JBI:11" in told
    assert "MAIN.JBI:" not in told


def test_programs_that_do_nothing_are_not_said_to_agree(tmp_path, capsys):
    job = tmp_path / "EMPTY.JBI"
    job.write_text(NO_POINTS.format("EMPTY") + "END\n")
    main(["convert", str(job), "--to", "krl", "-o", str(tmp_path / "out"), "--robot", "yaskawa/gp25"])
    assert "there was nothing to compare" in capsys.readouterr().out
