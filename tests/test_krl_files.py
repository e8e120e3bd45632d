"""Files that belong together, inline forms and the motion data they name, and everything that is wrong with a text."""

from __future__ import annotations

from pathlib import Path

import pytest
from krl_programs import body, codes, one, read, source, unplaced, written

import olp
from olp.ir.expressions import (
    FrameRef,
    Item,
    Member,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    RecordLiteral,
    Text,
)
from olp.ir.program import (
    Acceleration,
    AccelerationUnit,
    Assign,
    Blend,
    BlendKind,
    Declare,
    ExternalTool,
    Program,
    SetAcceleration,
    SetBlend,
    SetFrame,
    SetSpeed,
    SetTool,
    Speed,
    SpeedUnit,
)
from olp.ir.program import Path as Shape
from olp.languages.vendors.krl.grammar import KrlLine, KrlParser
from olp.languages.vendors.krl.reader import read_program
from olp.languages.vendors.krl.scope import Scope
from olp.transpile.convert import convert
from olp.transpile.link import link

SAMPLES = Path(__file__).resolve().parent.parent / "samples" / "krl"
DAT = [
    "DECL E6POS XP1={X 1.0,Y 2.0,Z 3.0,A 4.0,B 5.0,C 6.0,S 2,T 10,E1 0.0}",
    'DECL FDAT FP1={TOOL_NO 3,BASE_NO 2,IPO_FRAME #BASE,POINT2[] " "}',
    'DECL FDAT FP2={TOOL_NO 0,BASE_NO 0,IPO_FRAME #TCP,POINT2[] " "}',
    "DECL PDAT PPDAT1={VEL 100.0,ACC 80.0,APO_DIST 120.0,APO_MODE #CPTP}",
    "DECL PDAT PPDAT2={VEL 100.0,ACC 80.0,APO_DIST 25.0,APO_MODE #CDIS}",
    "DECL LDAT LCPDAT1={VEL 2.0,ACC 60.0,APO_DIST 12.5}",
]
FORM = ["PDAT_ACT=PPDAT1", "FDAT_ACT=FP1", "BAS (#PTP_PARAMS,50 )", "PTP XP1 C_PTP"]


def rate(value: float, scale: float) -> SetAcceleration:
    unit = AccelerationUnit.FRACTION if scale < 0.02 else AccelerationUnit.TRAVEL
    return SetAcceleration(
        0, (Acceleration(unit, Quantity(Number(value), scale)),), Shape.JOINT if scale < 0.02 else None
    )


# --- inline forms ----------------------------------------------------------------------------------------


def test_a_joint_form_sets_what_the_public_bas_sets() -> None:
    found = body(*FORM, dat=DAT)
    assert found[2:7] == (
        rate(80.0, 0.005),  # DEF_ACC_PTP is 50 %
        SetBlend(0, (Blend(BlendKind.SHARE, Quantity(Number(100), 0.01)),)),  # at most 100 %
        SetTool(0, FrameRef("tool", Number(3))),
        SetFrame(0, FrameRef("user", Number(2))),
        SetSpeed(0, (Speed(SpeedUnit.FRACTION, Quantity(Number(50), 0.01)),)),
    )
    assert found[0] == Assign(0, Named("PDAT_ACT"), Named("PPDAT1"))


def test_a_joint_form_in_mm_sets_the_distance() -> None:
    found = body("PDAT_ACT=PPDAT2", "FDAT_ACT=FP1", "BAS (#PTP_PARAMS,50 )", dat=DAT)
    assert found[3] == SetBlend(0, (Blend(BlendKind.RADIUS, Quantity(Number(25.0), 0.001)),))


def test_a_path_form_sets_what_the_public_bas_sets() -> None:
    found = body("LDAT_ACT=LCPDAT1", "FDAT_ACT=FP2", "BAS(#CP_PARAMS,0.25)", dat=DAT)
    assert found[2:] == (
        rate(60.0, 0.023),  # DEF_ACC_CP is 2.3 m/s²
        SetBlend(0, (Blend(BlendKind.RADIUS, Quantity(Number(12.5), 0.001)),)),
        SetTool(0, FrameRef("tool", Number(0))),
        SetFrame(0, FrameRef("base")),
        ExternalTool(0, body("$IPO_MODE=#TCP")[0].tool),  # type: ignore[union-attr]
        SetSpeed(0, (Speed(SpeedUnit.TRAVEL, Quantity(Number(0.25), 1.0)),)),
    )


def test_the_first_settings_are_those_of_the_public_files() -> None:
    found = body("BAS (#INITMOV,0 )")
    assert rate(100, 0.005) in found
    assert SetSpeed(0, (Speed(SpeedUnit.FRACTION, Quantity(Number(100), 0.01)),)) in found
    assert SetSpeed(0, (Speed(SpeedUnit.TRAVEL, Quantity(Number(2), 1.0)),)) in found
    sizes = {
        blend.kind: blend.value.literal
        for s in found
        if isinstance(s, SetBlend)
        for blend in s.blends
        if blend.value
    }
    assert sizes[BlendKind.SHARE] == 0.5
    assert sizes[BlendKind.RADIUS] == 0.003
    assert sizes[BlendKind.SPEED] == 1.0


@pytest.mark.parametrize(
    ("call", "statement"),
    [
        ("BAS(#VEL_PTP,30)", SetSpeed(0, (Speed(SpeedUnit.FRACTION, Quantity(Number(30), 0.01)),))),
        ("BAS(#ACC_PTP,20)", rate(20, 0.005)),
        ("BAS(#VEL_CP,1.5)", SetSpeed(0, (Speed(SpeedUnit.TRAVEL, Quantity(Number(1.5), 1.0)),))),
        ("BAS(#ACC_CP,20)", rate(20, 0.023)),
        ("BAS(#TOOL,4)", SetTool(0, FrameRef("tool", Number(4)))),
        ("BAS(#BASE,0)", SetFrame(0, FrameRef("base"))),
    ],
)
def test_calls_of_bas(call: str, statement: object) -> None:
    assert one(call) == statement


def test_a_spline_form_resolves_the_data_it_names() -> None:
    line = (
        "SPTP XP1 WITH $VEL_AXIS[1]=SVEL_JOINT(70.0), $TOOL=STOOL2(FP1), $BASE=SBASE(FP1.BASE_NO), "
        "$ACC_AXIS[1]=SACC_JOINT(PPDAT2), $APO=SAPO_PTP(PPDAT2), $LOAD=SLOAD(FP1.TOOL_NO) C_Spl"
    )
    move = one(line, dat=DAT)
    assert move.speed == Speed(SpeedUnit.FRACTION, Quantity(Number(70.0), 0.01))
    assert (move.tool, move.frame) == (FrameRef("tool", Number(3)), FrameRef("user", Number(2)))
    assert move.acceleration == Quantity(Number(80.0), 0.01)  # DEF_ACC_SPTP is 100 %: twice that of PTP
    assert move.blend == Blend(BlendKind.RADIUS, Quantity(Number(25.0), 0.001), "C_SPL")
    assert [name for name, _ in move.other] == ["$LOAD"]
    line = one(
        "SLIN XP1 WITH $VEL=SVEL_CP(0.1, , LCPDAT1), $APO=SAPO(LCPDAT1), $ACC=SACC_CP(LCPDAT1) C_SPL", dat=DAT
    )
    assert line.speed == Speed(SpeedUnit.TRAVEL, Quantity(Number(0.1), 1.0))
    assert line.blend.value.literal == 0.0125
    assert line.rate.value.literal == pytest.approx(1.38)


def test_after_a_branch_the_motion_data_are_looked_up_while_running() -> None:
    program = read("PDAT_ACT=PPDAT1", "FDAT_ACT=FP1", "again:", "BAS (#PTP_PARAMS,50 )", dat=DAT)
    speeds = [s for s in program.routines[0].body if isinstance(s, SetAcceleration)]
    assert speeds[0].rates[0].value.written == Member(Named("PDAT_ACT"), "ACC")


def test_motion_data_without_a_value_are_told() -> None:
    program = read(*FORM)
    assert ("P413", 4) in codes(program)
    assert not [d for d in program.diagnostics if d.is_error]


# --- files -----------------------------------------------------------------------------------------------


def test_the_list_beside_a_program_is_found_whatever_its_case(tmp_path: Path) -> None:
    (tmp_path / "PART.SRC").write_bytes(b"DEF part ( )\r\nPTP XP1\r\nEND\r\n")
    (tmp_path / "Part.Dat").write_bytes(
        b"DEFDAT part\r\nDECL E6POS XP1={X 1,Y 2,Z 3,A 4,B 5,C 6}\r\nENDDAT\r\n"
    )
    program = olp.read(tmp_path / "PART.SRC")
    assert not program.diagnostics
    assert [d.name for d in program.data] == ["XP1"]
    assert [Path(s.path).name for s in program.companions] == ["Part.Dat"]


def test_files_that_are_searched_for_a_name_are_read_once_for_all_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "part.src").write_bytes(b"DEF part ( )\r\nDECL INT n\r\nn=PARTS\r\nEND\r\n")
    (tmp_path / "other.src").write_bytes(b"DEF other ( )\r\nEND\r\n")
    read_input, asked = olp.core.source.read_input, []

    def noted(path: Path, most: int) -> bytes:
        asked.append(Path(path).name)
        return read_input(path, most)

    monkeypatch.setattr(olp.core.source, "read_input", noted)
    program = olp.read(tmp_path / "part.src")
    for _ in range(3):
        assert [one.code for one in program.plan().diagnostics] == ["I209"]
    assert asked.count("other.src") == 1
    (tmp_path / "other.src").write_bytes(b"DEF other ( )\r\nEND\r\nDEF third ( )\r\nEND\r\n")
    program.plan()
    assert asked.count("other.src") == 2


@pytest.mark.parametrize("folder", ["", "System", "../System", "R1/System"])
def test_the_controllers_list_is_found_in_its_folders(tmp_path: Path, folder: str) -> None:
    here = tmp_path / "work"
    place = (here / folder).resolve()
    place.mkdir(parents=True, exist_ok=True)
    here.mkdir(exist_ok=True)
    (here / "part.src").write_bytes(b"DEF part ( )\r\n$TOOL=TOOL_DATA[2]\r\nPTP XHOME\r\nEND\r\n")
    rows = [
        "DEFDAT $CONFIG",
        "E6AXIS XHOME={A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}",
        "DECL FRAME TOOL_DATA[16]",
        "TOOL_DATA[2]={X 7,Y 0,Z 0,A 0,B 0,C 0}",
        "INT OTHER=1",
        "ENDDAT",
    ]
    (place / "$config.dat").write_bytes("\r\n".join(rows).encode())
    program = olp.read(here / "part.src")
    assert [d.name for d in program.data] == ["XHOME", "TOOL_DATA"]
    tools = program.data[1].value
    assert isinstance(tools, RecordLiteral)
    assert tools.members[1][1] == PositionLiteral("pose", (0.007, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert unplaced(program.routines[0].body[0]) == SetTool(0, Item(Named("TOOL_DATA"), (Number(2),)))


def test_the_controllers_list_and_its_types_are_found_above_the_folders_of_a_project(tmp_path: Path) -> None:
    """A folder below holds a routine that alone names what the list declares, of a type of its own."""
    below = tmp_path / "main" / "place"
    below.mkdir(parents=True)
    (tmp_path / "main" / "part.src").write_text("DEF part ( )\nplace ( )\nEND\n")
    (below / "place.src").write_text("DEF place ( )\nIF Bins[2].Full THEN\nHALT\nENDIF\nEND\n")
    rows = [
        "STRUC Lid_T BOOL Open",
        "STRUC Bin_T Lid_T Lid,BOOL Full",
        "DECL Bin_T Bins[3]",
        "DECL Bin_T Other",
    ]
    (tmp_path / "$config.dat").write_text("\n".join(["DEFDAT $CONFIG", *rows, "ENDDAT", ""]))
    program = link(olp.read(tmp_path / "main" / "part.src")).program
    assert {d.name for d in program.data} == {"Bins", "Bin_T", "Lid_T"}


def test_a_name_of_a_programs_own_list_hides_that_of_the_controllers(tmp_path: Path) -> None:
    """KUKA's $config.dat has I[20], and its p00.dat an I of its own: a translation declared both."""
    (tmp_path / "part.src").write_text("DEF part ( )\nWAIT SEC I\nEND\n")
    (tmp_path / "part.dat").write_text("DEFDAT PART\nINT I=2\nENDDAT\n")
    (tmp_path / "$config.dat").write_text("DEFDAT $CONFIG\nDECL INT I[20]\nI[1]=7\nENDDAT\n")
    program = olp.read(tmp_path / "part.src")
    assert [(d.name, d.sizes, d.value) for d in program.data] == [("I", (), Number(2))]
    assert program.plan().durations.tolist() == [2.0]
    made = convert(link(program).program, "rapid").files
    assert b"".join(made.values()).count(b" num I") == 1


def test_a_list_is_read_alone_and_known_by_its_text(tmp_path: Path) -> None:
    (tmp_path / "points.dat").write_bytes(
        "\r\n".join(["&ACCESS RVP", "DEFDAT points PUBLIC", *DAT, "ENDDAT"]).encode()
    )
    program = olp.read(tmp_path / "points.dat")
    assert (program.vendor, len(program.data)) == ("krl", 6)
    assert not program.diagnostics
    assert program.to_bytes() == (tmp_path / "points.dat").read_bytes()


def test_elements_of_arrays_and_texts_are_values_of_their_declarations() -> None:
    rows = [
        "DECL INT N[3]",
        "N[1]=5",
        "N[3]=7",
        "CHAR T[8]",
        'T[]="abc"',
        "CHAR W[2,8]",
        'W[2,]="x"',
        "INT M[2,2]",
        "M[2,1]=4",
    ]
    found = {d.name: d.value for d in read(dat=rows).data}
    assert found["N"].members[0][1] == Number(5)  # type: ignore[union-attr]
    assert found["N"].members[2][1] == Number(7)  # type: ignore[union-attr]
    assert found["T"] == Text("abc")
    assert found["W"].members[1][1] == Text("x")  # type: ignore[union-attr]
    assert found["M"].members[1][1].members[0][1] == Number(4)  # type: ignore[union-attr]


def test_several_routines_of_a_file_with_their_parameters() -> None:
    text = [
        "&ACCESS RVP", "DEF part ( )", "grip (1)", "END", "", "GLOBAL DEF grip (n :IN,m :OUT)", "DECL INT n,m", "END",
        "DEFFCT REAL half (x :IN)", "REAL x", "RETURN x/2", "ENDFCT",
    ]  # fmt: skip
    program = read_program(source(text), ())
    assert not program.diagnostics
    main, grip, half = program.routines
    assert program.main == "part"
    assert (main.shared, grip.shared, half.shared) == (True, True, False)
    assert [(p.name, p.type, p.by_reference) for p in grip.parameters] == [
        ("n", "integer", False),
        ("m", "integer", True),
    ]
    assert (half.returns, half.parameters[0].type) == ("real", "real")
    assert not any(isinstance(s, Declare) for s in grip.body)
    assert main.details["above"] == "&ACCESS RVP"


def test_the_sample_reads_without_a_finding_and_keeps_its_bytes() -> None:
    for path in sorted(SAMPLES.glob("*.*")):
        program = olp.read(path)
        assert not program.diagnostics, [d.render() for d in program.diagnostics]
        assert program.to_bytes() == path.read_bytes()
        assert path.read_bytes().count(b"\n") == path.read_bytes().count(b"\r\n")


# --- what is wrong ---------------------------------------------------------------------------------------


def errors(program: Program) -> list[tuple[str, int]]:
    return [(d.code, d.line) for d in program.diagnostics if d.is_error]


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        (["PTP XP1 C_DES"], [("P404", 2)]),
        (["LIN {X 1,Y}"], [("P404", 2)]),
        (["WAIT 0.5"], [("P404", 2)]),
        (["x=1 y=2"], [("P404", 2)]),
        (["n=(1+2"], [("P404", 2)]),
        (["LIN XP1 #BASE"], [("P404", 2)]),
        (["FOR a.b=1 TO 2", "ENDFOR"], [("P404", 2)]),
        (["n='B012'"], [("P404", 2)]),
        (["IF a THEN"], [("P405", 2)]),
        (["ENDIF"], [("P405", 2)]),
        (["WHILE a", "ENDIF", "ENDWHILE"], [("P405", 3)]),
        (["LOOP", "IF a THEN", "ENDLOOP"], [("P405", 3)]),
        (["EXIT"], [("P405", 2)]),
        (["CASE 1"], [("P405", 2)]),
        (["IF a THEN", "ELSE", "IF b THEN", "ELSE", "ENDIF", "ELSE", "ENDIF"], [("P405", 7)]),
        (["SWITCH a", "DEFAULT", "CASE 1", "ENDSWITCH"], [("P405", 4)]),
        (["ENDSPLINE"], [("P405", 2)]),
        (["SPLINE"], [("P405", 3)]),
        (["GOTO out"], [("P406", 2)]),
        (["a:", "a:"], [("P407", 3)]),
        (["END", "DEF PART ( )"], [("P408", 3)]),
        ([f"n={'1' * 30}"], [("P409", 2)]),
        ([f"n={'(' * 300}1{')' * 300}"], [("P409", 2)]),
        (["DEF other ( )"], [("P402", 2)]),
        (["END", "n=1", "DEF other ( )"], [("P401", 3)]),
        (["END", "END"], [("P402", 3), ("P402", 4)]),
    ],
)  # fmt: skip
def test_a_mistake_has_its_code_and_line(lines: list[str], told: list[tuple[str, int]]) -> None:
    assert errors(read(*lines)) == told


def test_all_mistakes_are_told_at_once_and_the_rest_is_there() -> None:
    program = read("PTP (", "PTP XP1", "WAIT FOR", "$OUT[1]=", "n=2", dat=DAT)
    assert errors(program) == [("P404", 2), ("P404", 4), ("P404", 5)]
    assert len(program.routines[0].body) == 2


def test_a_broken_line_that_opens_a_block_does_not_break_the_block() -> None:
    assert errors(read("IF a THAN", "ELSE", "ENDIF", "FOR i=1 2", "ENDFOR")) == [("P404", 2), ("P404", 5)]


def test_a_mistake_in_the_list_names_the_list() -> None:
    program = read("PTP XP1", dat=["DECL E6POS XP1={X 1 Y 2}", "PTP XP1", "N=5"])
    told = [(d.code, d.file, d.line) for d in program.diagnostics if d.is_error]
    assert told == [("P404", "part.dat", 2), ("P403", "part.dat", 3), ("P403", "part.dat", 4)]


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        (["PTP XP9"], [("P411", 2)]),
        (["INT i", "INT i"], [("P415", 3)]),
        (["; FOLD x"], [("P417", 2)]),
        (["IF a THEN", "ELSEIF b THEN", "ENDIF"], [("P418", 3)]),
    ],
)
def test_warnings(lines: list[str], told: list[tuple[str, int]]) -> None:
    program = read(*lines, dat=DAT)
    assert [(d.code, d.line) for d in program.diagnostics] == told
    assert not any(d.is_error for d in program.diagnostics)


def test_motion_data_that_every_controller_has_are_taken_and_told() -> None:
    program = read("PDAT_ACT=PDEFAULT", "FDAT_ACT=FHOME", "BAS (#PTP_PARAMS,40 )", "PTP XHOME")
    assert ("P420", 1) in codes(program)
    assert ("P412", 5) in codes(program)
    body = [unplaced(one) for one in program.routines[0].body]
    assert SetTool(0, FrameRef("tool", Number(1))) in body
    assert SetFrame(0, FrameRef("base")) in body
    own = read("PDAT_ACT=PDEFAULT", config=["DECL PDAT PDEFAULT={VEL 100.0,ACC 50.0,APO_DIST 20.0}"])
    assert not own.diagnostics


@pytest.mark.parametrize("line", ["PTP !", "LIN ! C_DIS", "CIRC !,!,CA 90"])
def test_a_point_that_is_still_to_be_taught_is_told_and_written_back(line: str) -> None:
    program = read(line, "PTP !")
    assert codes(program) == [("P412", 2)]
    assert line in written(program)[0]
    assert "I209" in [found.code for found in program.plan().diagnostics]


def test_a_missing_list_is_told_once() -> None:
    assert codes(read("PTP XP8", "PTP XP9")) == [("P412", 2)]


def test_a_controllers_list_that_is_not_understood_is_told() -> None:
    program = read("PTP XHOME", config=["E6AXIS XHOME={A1 1", "INT B="])
    assert ("P419", 1) in codes(program)


@pytest.mark.parametrize("raw", [b"", b"  \r\n", b"DEF \0 ()\r\n", b"\x00\x01\x02"])
def test_what_is_no_program_is_told(raw: bytes) -> None:
    from olp.core.source import decode

    program = read_program(decode(raw, "a.src"), ())
    assert {d.code for d in program.diagnostics} == {"P400"}


def test_thousands_of_broken_lines_are_given_up() -> None:
    program = read(*["PTP ("] * 3000)
    assert sum(d.code == "P404" for d in program.diagnostics) == 2000
    assert sum(d.code == "P410" for d in program.diagnostics) == 1


def test_the_lists_of_a_tree_are_parsed_once_for_all_its_programs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = ["STRUC PART_T INT no, FRAME at, REAL mass", "DECL PART_T part={no 3,at {X 70.5},mass 2.5}"]
    rows += ["FRAME station={X 41.5,Y 12,Z 3,A 15,B 0,C 0}", "SIGNAL gripper $OUT[31]"]
    (tmp_path / "$config.dat").write_text("\n".join(["DEFDAT $CONFIG", *rows, "ENDDAT", ""]))
    for n in (1, 2, 3):
        (tmp_path / f"part{n}.src").write_text(
            f"DEF part{n} ( )\npart.mass=part.no\n$BASE=station\ngripper=TRUE\nWAIT SEC 0.{n}\nEND\n"
        )
    parsed: list[str] = []
    really = KrlParser.parse_line

    def noting(self: KrlParser, line: str, scope: Scope) -> KrlLine:
        parsed.append(line)
        return really(self, line, scope)

    monkeypatch.setattr(KrlParser, "parse_line", noting)
    programs = [olp.read(tmp_path / f"part{n}.src") for n in (1, 2, 3)]
    assert [parsed.count(row) for row in rows] == [1, 1, 0, 1]  # a plain frame needs no grammar
    assert programs[0].data == programs[1].data == programs[2].data
    assert {one.name: one.type for one in programs[2].data} == {
        "PART_T": "structure",
        "part": "PART_T",
        "station": "frame",
        "gripper": "signal",
    }
    mass = next(s for s in programs[2].routines[0].body if isinstance(s, Assign))
    assert mass.target == Member(Named("part"), "mass")
