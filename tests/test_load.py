"""`olp lint --load`: what a controller refuses, told at its line, and nothing of what it takes."""

from __future__ import annotations

from pathlib import Path

import pytest

from olp.__main__ import main
from olp.checks.lint.run import lint_load
from olp.reports.batch import Job

RAPID = """MODULE Cell
    CONST num most:=4;
    VAR num count:=0;
    VAR bool busy:=FALSE;
    VAR string label:="";
    PERS robtarget pHome:=[[812.4,-33.1,707.5],[0.5,0.5,0.5,0.5],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    PERS robtarget pPick:=[[512.4,-33.1,707.5],[0.5,0.5,0.5,0.5],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    PROC main()
        VAR num height:=12.5;
        count:=height+Sum(3,most);
        FOR i FROM 1 TO most DO
            Pick i\\Slow;
            IF busy AND diPart=1 GOTO again;
        ENDFOR
    again:
        MoveL Offs(pHome,0,0,height),v200,z10,tool0\\WObj:=wobj0;
        SetDO doGrip,1;
    ENDPROC
    PROC Pick(num which\\switch Slow|switch Fast)
        MoveJ pPick,v200,fine,tool0;
        label:=NumToStr(which,0);
        TPWrite "part "\\Num:=count;
    ENDPROC
    FUNC num Sum(num one,num other)
        RETURN one+other;
    ENDFUNC
ENDMODULE
"""
KRL = """DEF CELL()
DECL INT COUNT
DECL BOOL BUSY
REAL HEIGHT
BAS(#INITMOV,0)
COUNT = 3
HEIGHT = 12.5
AGAIN:
PTP XHOME
LIN {X 812.4,Y -33.1,Z 707.5+HEIGHT,A 12,B 3,C 178}
PICK(COUNT, BUSY)
IF SUM(COUNT) > 2 THEN
GOTO AGAIN
ENDIF
END
DEF PICK(WHICH:IN, DONE:OUT)
INT WHICH
BOOL DONE
DONE = TRUE
END
DEFFCT INT SUM(N:IN)
INT N
RETURN N + 1
ENDFCT
"""


def told(folder: Path, name: str, text: str, controller: str = "") -> list[tuple[str, int]]:
    """(code, line) of what is told of one program."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return [(f.code, f.line) for f in lint_load(str(path), Job(), controller).findings]


def test_a_parameter_of_krl_may_have_several_indices(tmp_path: Path) -> None:
    text = "DEF CELL()\nEND\nDEF FILL(N:IN, TABLE[,]:OUT)\nINT N\nINT TABLE[,]\nTABLE[1,N]=2\nEND\n"
    assert told(tmp_path, "cell.src", text) == []


def test_the_nearest_of_several_names_is_suggested(tmp_path: Path) -> None:
    path = tmp_path / "cell.script"
    path.write_text("def cell():\n  st_digital_out(0, True)\nend\n", encoding="utf-8")
    (found,) = lint_load(str(path), Job(), "").findings
    assert "set_digital_out" in f"{found}"


def test_a_sound_program_is_told_nothing_of(tmp_path: Path) -> None:
    assert told(tmp_path, "Cell.mod", RAPID) == []
    assert told(tmp_path, "cell.src", KRL) == []


def test_what_the_folder_above_declares_is_not_missing(tmp_path: Path) -> None:
    (tmp_path / "cell").mkdir()
    text = RAPID.replace("count:=height", "counnt:=height")
    assert told(tmp_path / "cell", "Cell.mod", text) == [("K101", 10)]
    (tmp_path / "Shared.mod").write_text("MODULE Shared\n    VAR num counnt:=0;\nENDMODULE\n")
    assert told(tmp_path / "cell", "Cell.mod", text) == []


@pytest.mark.parametrize("name", ["TOOL", "MAXIMUM", "BASE"])
def test_a_word_of_one_place_may_name_something_else(tmp_path: Path, name: str) -> None:
    assert told(tmp_path, "cell.src", KRL.replace("COUNT", name)) == []


def test_what_krl_chooses_by_is_not_told(tmp_path: Path) -> None:
    rows = "SWITCH COUNT\nCASE -1,2\nCASE 'B101'\nDEFAULT\nENDSWITCH\nBUSY = NOT (BUSY AND (COUNT>1)) OR $IN[COUNT+1]"
    assert told(tmp_path, "CELL.src", KRL.replace("COUNT = 3", rows)) == []


def test_what_rapid_allows_is_not_told(tmp_path: Path) -> None:
    """A constant of a routine that hides a variable, whole arrays, components of an array, data that a parameter is."""
    text = RAPID.replace(
        "VAR num count:=0;", "VAR num count:=0;\n    PERS num rows{2,most}:=[[1,2,3,4],[5,6,7,8]];"
    )
    text = text.replace(
        "VAR num height:=12.5;",
        "CONST num count:=2;\n        VAR num height:=count;\n        VAR pos places{2}:=[[1,2,3],[4,5,6]];",
    )
    text = text.replace(
        "count:=height+Sum(3,most);", "rows{1,2}:=places{1}.x;\n        Fill rows,places{2}.y;"
    )
    fill = "    PROC Fill(PERS num all{*,*},INOUT num one)\n        one:=all{1,1};\n    ENDPROC\nENDMODULE"
    assert told(tmp_path, "Cell.mod", text.replace("ENDMODULE", fill)) == []
    text = text.replace(
        "places{2}.y;", "EulerZYX(\\Z,[1,0,0,0]);"
    )  # a routine cannot change what a function returns
    assert [code for code, _ in told(tmp_path, "Cell.mod", text.replace("ENDMODULE", fill))] == ["K108"]


def test_a_character_of_a_rapid_text_that_is_written_as_its_number_counts_as_one(tmp_path: Path) -> None:
    full = RAPID.replace('label:="";', f'label:="{"x" * 76}\\0D\\0A\\\\"";')
    assert told(tmp_path, "Cell.mod", full.replace('""', 'x"')) == []
    assert told(tmp_path, "Cell.mod", full.replace('""', 'xx"')) == [("K103", 5)]


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("Pick i\\Slow;", "Pikc i\\Slow;", "K101"),
        ("count:=height", "counnt:=height", "K101"),
        ("MoveJ pPick", "MoveJ pPicck", "K101"),
        ("PERS robtarget pPick", "PERS robtarget pHome", "K102"),
        ("VAR num height", "VAR num heightOfTheTableAboveTheFloorInMm:=1;\n        VAR num height", "K103"),
        ("VAR bool busy", "VAR bool while", "K104"),
        ("        SetDO doGrip,1;", "        VAR num late:=1;", "K106"),
        ("CONST num most:=4;", "CONST num most;", "K107"),
        ("count:=height+Sum(3,most);", 'count:="three";', "K108"),
        ("RETURN one+other;", "RETURN;", "K108"),
        ("IF busy AND diPart=1 GOTO", "IF count GOTO", "K108"),
        ("        SetDO doGrip,1;", '        TEST count\n        CASE 1,"two":\n        ENDTEST', "K108"),
        ("        SetDO doGrip,1;", "        TEST label\n        CASE 1:\n        ENDTEST", "K108"),
        ("RETURN one+other;", "count:=one;", "K108"),
        ("label:=NumToStr(which,0);", "most:=5;", "K111"),
        ("Pick i\\Slow;", "Pick;", "K112"),
        ("Pick i\\Slow;", "Pick i\\Quick;", "K112"),
        ("Sum(3,most)", "Sum(3)", "K112"),
        ("NumToStr(which,0)", "NumToStr(which)", "K112"),
        ("NumToStr(which,0)", "NumToStr(busy,0)", "K108"),
        ("Pick i\\Slow;", "Pick label\\Slow;", "K108"),
        ("v200,z10", "z10,v200", "K108"),
        ("MoveJ pPick", "MoveAbsJ pPick", "K108"),
        ("MoveJ pPick", "MoveJ pPick.trans", "K108"),
        ("count:=height", "pPick.trans.xx:=height", "K109"),
        ("count:=height+Sum(3,most);", "label:=pPick.trans.x;", "K108"),
        ("tool0\\WObj:=wobj0", "tool0\\WobjData:=wobj0", "K112"),
        ('TPWrite "part "', "TPWrite labell", "K101"),
        ('TPWrite "part "\\Num:=count;', 'TPWrite "part "+count;', "K108"),
        ("SetDO doGrip,1;", "IF busy AND count THEN\n        ENDIF", "K108"),
        ("count:=height+Sum(3,most);", "busy:=count=1 OR count;", "K108"),
        ("MoveJ pPick", "MoveJ pPick+100", "K108"),
        ("VAR num height:=12.5;", "VAR num height;\n        VAR num rows{3};\n        height:=rows;", "K109"),
        ("count:=height+Sum(3,most);", "ConfL Off;", "K112"),
        ("VAR num height", "PERS num height", "K115"),
        ("        SetDO doGrip,1;", "    again:\n        SetDO doGrip,1;", "K102"),
        ("MODULE Cell", "MODULE CellWithANameThatIsLongerThanAnyOther", "K103"),
        ("count:=height+Sum(3,most);", "count{1}:=height;", "K109"),
        ("VAR num height:=12.5;", "VAR num height;\n        VAR num rows{3};\n        rows{1,2}:=1;", "K109"),
        ("VAR num count:=0;", "VAR num count:=0;\n    VAR num rows{3}:=[1,2];", "K109"),
        ("VAR num count:=0;", "VAR num count:=0;\n    VAR num more:=2*count;", "K107"),
        ("FUNC num Sum(num one", "FUNC num Sum(INOUT num one", "K108"),
        ("FUNC num Sum(num one,num other", "FUNC num Sum(num one,PERS num other", "K108"),
        ("count:=height+Sum(3,most);", "busy:=label=1;", "K108"),
        ("        SetDO doGrip,1;", "IF busy AND count=TRUE THEN\n        ENDIF", "K108"),
        ("        SetDO doGrip,1;", "        CONNECT count WITH Pick;", "K112"),
    ],
)
def test_each_mistake_in_rapid_is_told(tmp_path: Path, old: str, new: str, code: str) -> None:
    assert old in RAPID
    text = RAPID.replace(old, new, 1)
    codes = {one for one, _ in told(tmp_path, "Cell.mod", text)}
    assert code in codes or (code == "K104" and codes)  # the reader may have refused the line


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("COUNT = 3", "COUNTT = 3", "K101"),
        ("COUNT = 3", "COUNT = $IN[1]*30", "K108"),
        ("COUNT = 3", "COUNT = 30-2*(BUSY)", "K108"),
        ("COUNT = 3", "COUNT = COUNT+$OUT[COUNT-1]", "K108"),
        ("PICK(COUNT, BUSY)", "PIKC(COUNT, BUSY)", "K101"),
        ("REAL HEIGHT", "REAL COUNT", "K102"),
        ("REAL HEIGHT", "REAL HEIGHT, HEIGHT_OF_THE_TABLE_ABOVE", "K103"),
        ("REAL HEIGHT", "REAL HEIGHT, REPEAT", "K104"),
        ("COUNT = 3", "CÖUNT = 3", "K105"),
        ("COUNT = 3", "DECL INT LATE", "K106"),
        ("DONE = TRUE", "DONE = 7", "K108"),
        ("PICK(COUNT, BUSY)", "PICK(COUNT, BUSY, 1)", "K112"),
        ("IF SUM(COUNT) > 2", "IF 2 < PICK(COUNT)", "K112"),
        ("DEF CELL()", "DEF CELLS()", "K113"),
        ("PICK(COUNT, BUSY)", "PICK(BUSY, COUNT)", "K108"),
        ("INT WHICH", "INT WICH", "K101"),
        ("IF SUM(COUNT) > 2", "IF SUM(COUNT) + 2", "K108"),
        ("IF SUM(COUNT) > 2", "IF SUM(BUSY) > 2", "K108"),
        ("COUNT = 3", "$OUT[3] = COUNT", "K108"),
        ("COUNT = 3", "WAIT FOR HEIGHT", "K108"),
        ("COUNT = 3", "WAIT SEC BUSY", "K108"),
        ("COUNT = 3", "BUSY = BUSY AND COUNT", "K108"),
        ("COUNT = 3", "BUSY = NOT (BUSY OR (COUNT+1))", "K108"),
        ("IF SUM(COUNT) > 2", "IF SUM(COUNT) > 2 AND COUNT", "K108"),
        ("COUNT = 3", "FOR HEIGHT=1 TO 3\nENDFOR", "K108"),
        ("COUNT = 3", "SWITCH HEIGHT\nCASE 1\nENDSWITCH", "K108"),
        ("COUNT = 3", "SWITCH COUNT\nCASE 1.5\nENDSWITCH", "K108"),
        ("COUNT = 3", "SUM(COUNT)", "K112"),
        ("PTP XHOME", "PTP HEIGHT", "K108"),
        ("RETURN N + 1", "RETURN", "K108"),
        ("RETURN N + 1", "RETURN N > 1", "K108"),
        ("RETURN N + 1", "N = 1", "K108"),
        ("RETURN N + 1\nENDFCT", "RETURN N + 1\nEND", "K114"),
        ("GOTO AGAIN\nENDIF\nEND", "GOTO AGAIN\nENDIF\nENDFCT", "K114"),
        ("DONE = TRUE", "RETURN 5", "K108"),
        ("REAL HEIGHT", "REAL HEIGHT=3", "K115"),
        ("REAL HEIGHT", "REAL HEIGHT\nSTRING TEXT", "K101"),
        ("REAL HEIGHT", "REAL HEIGHT\nDECL BOOLEAN OK", "K101"),
        ("COUNT = 3", "IF BUSY THEN\nELSEIF COUNT==1 THEN\nENDIF", "K115"),
        ("COUNT = 3", "$IN[3]=TRUE", "K115"),
        ("PTP XHOME", "LIN XHOME C_PTP", "K115"),
        ("PTP XHOME", "SPLINE\nLIN XHOME\nENDSPLINE", "K115"),
    ],
)
def test_each_mistake_in_krl_is_told(tmp_path: Path, old: str, new: str, code: str) -> None:
    assert old in KRL
    codes = {one for one, _ in told(tmp_path, "cell.src", KRL.replace(old, new, 1))}
    assert code in codes or (code == "K105" and codes)


def test_a_routine_that_another_module_has_for_itself_is_told(tmp_path: Path) -> None:
    (tmp_path / "tools.src").write_text("DEF TOOLS()\nEND\nDEF HIDDEN()\nEND\nGLOBAL DEF SEEN()\nEND\n")
    assert told(tmp_path, "cell.src", "DEF CELL()\nTOOLS()\nSEEN()\nHIDDEN()\nEND\n") == [("K101", 4)]


def test_the_cases_of_a_test_within_another_are_held_against_its_own_value(tmp_path: Path) -> None:
    rows = 'TEST count\nCASE 1:\nTEST label\nCASE "a","b":\nENDTEST\nCASE -2,most:\nDEFAULT:\nENDTEST'
    assert told(tmp_path, "Cell.mod", RAPID.replace("SetDO doGrip,1;", rows)) == []


def test_a_name_that_stands_twice_in_a_list_is_told(tmp_path: Path) -> None:
    text = "DEFDAT CELL PUBLIC\nDECL INT COUNT=1\nDECL E6POS XP1={X 1}\nDECL REAL Count=2\nENDDAT\n"
    assert told(tmp_path, "cell.dat", text) == [("K102", 4)]


def test_an_unknown_name_is_no_mistake_where_another_file_may_declare_it(tmp_path: Path) -> None:
    text = "DEF CELL()\nPTP XTABLE\nGRIP_OPEN()\nEND\n"
    assert told(tmp_path, "cell.src", text) == []
    system, program = tmp_path / "R1/System", tmp_path / "R1/Program"
    system.mkdir(parents=True)
    program.mkdir()
    (system / "$config.dat").write_text("DEFDAT $CONFIG\nDECL E6POS XTABLE={X 1}\nENDDAT\n")
    assert told(program, "cell.src", text) == [("K101", 3)]


LIST = """DEFDAT CELL PUBLIC
STRUC PALLET INT COUNT,LAYER[4], FRAME PLACE, BOOL FREE
ENUM KIND LARGE,SMALL
DECL PALLET PALLETS[3,2]
DECL KIND BOX=#LARGE
INT COUNTS[3]
ENDDAT
"""
USES = """DEF CELL()
INT I
PALLETS[1,2].LAYER[I]=3
PALLETS[1,I].PLACE.X=12.5
BOX=#SMALL
IF PALLETS[1,1].FREE THEN
COUNTS[1]=4
ENDIF
WAIT FOR READY()
END
DEFFCT BOOL READY()
RETURN TRUE
ENDFCT
"""


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("LAYER[I]=3", "LAYERS[I]=3", "K109"),
        (".PLACE.X", ".PLACE.S", "K109"),
        ("PALLETS[1,2]", "PALLETS[2]", "K109"),
        ("COUNTS[1]=4", "COUNTS[1,1]=4", "K109"),
        ("BOX=#SMALL", "BOX=#MIDDLE", "K109"),
        ("IF PALLETS[1,1].FREE THEN", "IF I THEN", "K108"),
        ("DEFFCT BOOL READY()", "DEF READY()", "K112"),
        ("INT I\n", "INT I\nINT J=COUNTS[1]\n", "K107"),
        ("COUNTS[1]=4", "COUNTS=4", "K109"),
        ("INT I\n", "INT I\nFRAME F\nF={X 1,Y 2,S 2}\n", "K109"),
        ("INT I\n", "INT I\nAXIS J\nJ={X 1}\n", "K109"),
    ],
)
def test_what_a_list_of_krl_declares_is_what_statements_may_name(
    tmp_path: Path, old: str, new: str, code: str
) -> None:
    (tmp_path / "cell.dat").write_text(LIST)
    assert told(tmp_path, "cell.src", USES) == []
    assert old in USES
    assert code in {one for one, _ in told(tmp_path, "cell.src", USES.replace(old, new, 1))}


def test_a_cell_that_declares_nearly_all_lacks_what_it_does_not(tmp_path: Path) -> None:
    names = [f"PART{letter}" for letter in "ABCDEFGHIJKLMNOP"]
    rows = "".join(f"INT {name}\n" for name in names)
    (tmp_path / "$config.dat").write_text(f"DEFDAT $CONFIG\n{rows}ENDDAT\n")
    (tmp_path / "below").mkdir()
    text = "DEF CELL()\n" + "".join(f"{name}=1\n" for name in names) + "WAIT SEC PAUSED\nEND\n"
    assert told(tmp_path / "below", "cell.src", text) == [("K101", 18)]


def test_what_options_call_in_the_submit_program_is_not_judged(tmp_path: Path) -> None:
    """The names are all declared but two: one in the controller's own folds, one in the user's."""
    names = [f"PART{letter}" for letter in "ABCDEFGHIJKLMNOPQRSTUVWXYZ"]
    rows = "".join(f"INT {name}\n" for name in names)
    (tmp_path / "$config.dat").write_text(f"DEFDAT $CONFIG\n{rows}ENDDAT\n")
    own = "".join(f"{name}=1\n" for name in names)
    text = (
        f"DEF SPS()\n;FOLD TORQUE\nWATCH_TORQUES()\n;ENDFOLD\n;FOLD USER PLC\n{own}BLINK()\n;ENDFOLD\nEND\n"
    )
    assert told(tmp_path, "sps.sub", text) == [("K101", 32)]
    assert told(tmp_path, "sps.src", text) == [("K101", 3), ("K101", 32)]


def test_names_are_shorter_on_older_controllers(tmp_path: Path) -> None:
    text = RAPID.replace("height", "heightOfTheTable1")
    assert told(tmp_path, "Cell.mod", text) == []
    assert {code for code, _ in told(tmp_path, "Cell.mod", text, "irc5-5.15")} == {"K103"}


def test_the_command_ends_with_1_and_names_the_controllers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "Cell.mod"
    path.write_text(RAPID.replace("Pick i", "Pikc i"))
    assert main(["lint", "--load", str(path)]) == 1
    assert "did you mean Pick?" in capsys.readouterr().out
    assert main(["lint", "--load", "--controller", "krc4-8.5", str(path)]) == 2
    assert "irc5-6.13" in capsys.readouterr().err
    assert main(["lint", "--controller", "irc5-6.13", str(path)]) == 2


SCRIPT = """def cell():
  global speed=0.25
  gripper=rpc_factory("xmlrpc", "http://127.0.0.1:40404")
  def grip(width, force=40):
    set_standard_digital_out(0, width>10)
    gripper.close(width, force, 1, 2)
  end
  thread watch():
    while True:
      sync()
    end
  end
  run watch()
  movej(get_inverse_kin(p[0.4,0,0.3,0,3.14,0], [0,-1.5,1.5,0,1.5,0]), a=1.4, v=1.05)
  movel(pose_trans(get_actual_tcp_pose(), p[0,0,0.1,0,0,0]), 1.2, speed, 0, 0.01)
  grip(20)
  rq_activate_and_wait()
end
"""


def test_a_sound_script_may_call_what_a_urcap_or_another_file_adds(tmp_path: Path) -> None:
    assert told(tmp_path, "cell.script", SCRIPT) == []
    exported = SCRIPT.replace("  grip(20)", '  $ 4 "grip"\n  grip(20)')
    assert told(tmp_path, "exported.script", exported) == [
        ("K101", 18)
    ]  # PolyScope writes URCaps' functions along
    (tmp_path / "library.script").write_text("def rq_activate_and_wait():\n  sync()\nend\n")
    assert told(tmp_path, "exported.script", exported) == []
    written = exported.replace("get_actual_tcp_pose()", "tool_pose()")
    assert told(tmp_path, "exported.script", written) == []  # PolyScope's own, in no manual


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("movej(get", "movej_(get", ("K101", 14)),
        ("set_standard_digital_out(0", "set_standart_digital_out(0", ("K101", 5)),
        ("  sync()", "  Sync()", ("K101", 10)),
        ("grip(20)", "gripp(20)", ("K101", 16)),
        ("grip(20)", "grip()", ("K112", 16)),
        ("grip(20)", "grip(20, 40, 1)", ("K112", 16)),
        ("  sync()", "  sync(1)", ("K112", 10)),
        ('"xmlrpc", ', "", ("K112", 3)),
        ("1.2, speed, 0", "1.2, sped, 0", ("K101", 15)),
        ("width>10", "widht>10", ("K101", 5)),
        ("get_actual_tcp_pose(), p", "get_actual_tcp_pose(\n    ), pose_inv(), p", ("K112", 16)),
    ],
)
def test_each_mistake_in_urscript_is_told(
    tmp_path: Path, old: str, new: str, expected: tuple[str, int]
) -> None:
    assert old in SCRIPT
    assert expected in told(tmp_path, "cell.script", SCRIPT.replace(old, new, 1))


RAPID_RULES = (
    (["LOCAL PERS num a;"], [], [], ("K107", 2)),
    (["VAR signaldi di1:=1;"], [], [], ("K107", 2)),
    (["VAR num a:=Abs(-1);"], [], [], ("K107", 2)),
    ([], ["VAR jointtarget j:=CJointT();"], [], ("K107", 3)),
    (["VAR num a{2,2,2,2};"], [], [], ("K109", 2)),
    (["VAR num a:=1;", "RECORD r", "num x;", "ENDRECORD"], [], [], ("K106", 3)),
    ([], [], ["VAR num a:=1;"], ("K106", 4)),
    ([], ["RETRY;"], [], ("K115", 3)),
    ([], ["VAR intnum i;", "CONNECT i WITH t;"], ["TRAP t", "ENDTRAP"], ("K115", 4)),
)


@pytest.mark.parametrize(("data", "rows", "behind", "expected"), RAPID_RULES)
def test_what_a_rapid_module_may_not_declare(
    tmp_path: Path, data: list[str], rows: list[str], behind: list[str], expected: tuple[str, int]
) -> None:
    text = "\n".join(["MODULE Cell", *data, "PROC main()", *rows, "ENDPROC", *behind, "ENDMODULE", ""])
    assert told(tmp_path, "Cell.mod", text) == [expected]


@pytest.mark.parametrize(
    ("row", "code"), [("raw:=PackRawBytes(a);", "K112"), ("a:=TPWrite(a);", "K112"), ("raw:=other;", "K111")]
)
def test_what_rapid_data_cannot_be_set_to(tmp_path: Path, row: str, code: str) -> None:
    """An instruction has no value, and data of a type without values take none."""
    data = ["MODULE Cell", "VAR num a;", "VAR rawbytes raw;", "VAR rawbytes other;"]
    text = "\n".join([*data, "PROC main()", row, "ENDPROC", "ENDMODULE", ""])
    assert (code, 6) in told(tmp_path, "Cell.mod", text)
    sound = text.replace(row, "GetJointData 1\\Position:=a;\nCopyRawBytes raw,1,other,1;\na:=Abs(a);")
    assert told(tmp_path, "Cell.mod", sound) == []


@pytest.mark.parametrize(
    ("row", "told_here"),
    [("PERS num state;", [("K108", 2)]), ("PERS string state{2};", [("K108", 2)])]
    + [(row, []) for row in ("PERS num state{2};", "TASK PERS num state;", "LOCAL PERS num state:=1;")],
)
def test_a_pers_of_several_tasks_is_declared_alike(
    tmp_path: Path, row: str, told_here: list[tuple[str, int]]
) -> None:
    (tmp_path / "Other.mod").write_text("MODULE Other\nPERS num state{2};\nENDMODULE\n")
    assert told(tmp_path, "Cell.mod", f"MODULE Cell\n{row}\nENDMODULE\n") == told_here


def test_what_a_rapid_module_may_declare(tmp_path: Path) -> None:
    data = ["RECORD r", "num x;", "ENDRECORD", "LOCAL PERS num a:=1;", "PERS num b;", "VAR num c{2,2,2};"]
    data += ["VAR clock t;", "VAR intnum i;"]
    rows = ["CONNECT i WITH trapped;", "a:=b;", "ERROR", "IF ERRNO=1 THEN", "RETRY;", "ENDIF", "TRYNEXT;"]
    text = ["MODULE Cell", *data, "PROC main()", *rows, "ENDPROC", "TRAP trapped", "ENDTRAP", "ENDMODULE", ""]
    assert told(tmp_path, "Cell.mod", "\n".join(text)) == []


KRL_RULES = (
    (["DECL INT A[2,2,2,2]"], "", ("K109", 2)),
    (["INTERRUPT DECL 200 WHEN $IN[1]==TRUE DO CELL()"], "", ("K109", 2)),
    (["INT I", "I=1", "SWITCH I", "DEFAULT", "I=2", "ENDSWITCH"], "", ("K114", 4)),
    (["ENUM T A,B,A"], "", ("K102", 2)),
    (["INT A[3]", "A[1.5]=2"], "", ("K109", 3)),
    (["N=4"], "DECL CONST INT N=3", ("K111", 2)),
)


@pytest.mark.parametrize(("rows", "listed", "expected"), KRL_RULES)
def test_what_a_krl_module_may_not_say(
    tmp_path: Path, rows: list[str], listed: str, expected: tuple[str, int]
) -> None:
    (tmp_path / "cell.dat").write_text(f"DEFDAT CELL\n{listed}\nENDDAT\n", encoding="utf-8")
    assert told(tmp_path, "cell.src", "\n".join(["DEF CELL()", *rows, "END", ""])) == [expected]


def test_a_list_of_krl_publishes_only_what_it_may(tmp_path: Path) -> None:
    text = "DEFDAT CELL\nDECL GLOBAL INT X=0\nENDDAT\n"
    assert told(tmp_path, "cell.dat", text) == [("K115", 2)]
    assert told(tmp_path, "cell.dat", text.replace("CELL", "CELL PUBLIC")) == []


@pytest.mark.parametrize(
    "row",
    [
        "INT A=FALSE",
        "DECL BOOL A=5",
        "REAL A=TRUE",
        "INT A[3]=TRUE",
        "FRAME A=5",
        "BOOL A=#ON",
        "AXIS A={X 1}",
    ],
)
def test_the_first_value_in_a_list_of_krl_is_of_the_kind_that_is_declared(tmp_path: Path, row: str) -> None:
    sound = [
        "INT A=-3",
        "REAL A=2",
        "INT A='B101'",
        "BOOL A=FALSE",
        'CHAR A[3]="abc"',
        "FRAME A={FRAME: X 1}",
    ]
    for one in sound:
        assert told(tmp_path, "cell.dat", f"DEFDAT CELL\n{one}\nENDDAT\n") == []
    ((_, line),) = told(tmp_path, "cell.dat", f"DEFDAT CELL\n{row}\nENDDAT\n")
    assert line == 2


def test_variables_of_another_modules_list_are_seen_where_they_are_global_alone(tmp_path: Path) -> None:
    (tmp_path / "$config.dat").write_text("DEFDAT $CONFIG PUBLIC\nINT PARTS=1\nENDDAT\n")
    text = "DEF CELL()\nINT N\nN=COUNTED+PARTS\nN=COUNTED\nEND\n"
    for row, expected in (("INT COUNTED=1", [("K101", 3)]), ("DECL GLOBAL INT COUNTED=1", [])):
        (tmp_path / "other.dat").write_text(f"DEFDAT OTHER PUBLIC\n{row}\nENDDAT\n")
        assert told(tmp_path, "cell.src", text) == expected
    (tmp_path / "other.dat").write_text("DEFDAT OTHER PUBLIC\nINT COUNTED=1\nENDDAT\n")
    (tmp_path / "cell.dat").write_text("DEFDAT CELL\nIMPORT INT COUNTED IS \\OTHER..COUNTED\nENDDAT\n")
    assert told(tmp_path, "cell.src", text) == []
    (tmp_path / "cell.dat").unlink()
    (tmp_path / "$config.dat").unlink()  # which may declare another COUNTED
    assert told(tmp_path, "cell.src", text) == []


def test_a_krl_module_may_say_this(tmp_path: Path) -> None:
    (tmp_path / "cell.dat").write_text("DEFDAT CELL\nDECL CONST INT N=3\nENDDAT\n", encoding="utf-8")
    rows = ["DECL INT A[2,2,2]", "INT I", "GLOBAL INTERRUPT DECL 81 WHEN $IN[1]==TRUE DO CELL()", "I=N"]
    rows += [
        "SWITCH I",
        ";what comes",
        "CASE 1",
        "I=2",
        "DEFAULT",
        "I=3",
        "ENDSWITCH",
        "IF N==I THEN",
        "ENDIF",
    ]
    assert told(tmp_path, "cell.src", "\n".join(["DEF CELL()", *rows, "END", ""])) == []


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ("R[1]=R[2]+R[3]*R[4]", [("K114", 6)]),
        ("R[1]=R[2] DIV 2-R[4]", [("K114", 6)]),
        ("R[1]=R[2]+1+2+3+4+5+6", [("K114", 6)]),
        ("R[1]=(R[2]+R[3]*R[4])", []),
        ("R[1]=-1*R[2]", []),
        ("R[1:a-b]=R[2:c*d]+1+2+3+4+5", []),
    ],
)
def test_arithmetic_of_tp_without_parentheses(
    tmp_path: Path, row: str, expected: list[tuple[str, int]]
) -> None:
    text = f"/PROG  A\n/ATTR\nDEFAULT_GROUP\t= 1,*,*,*,*;\n/APPL\n/MN\n   1:  {row} ;\n/POS\n/END\n"
    assert told(tmp_path, "A.LS", text) == expected


def test_the_comment_of_a_tp_program_has_sixteen_characters(tmp_path: Path) -> None:
    text = '/PROG  A\n/ATTR\nCOMMENT\t\t= "{}";\nDEFAULT_GROUP\t= 1,*,*,*,*;\n/MN\n/POS\n/END\n'
    assert told(tmp_path, "A.LS", text.format("pick the parts up")) == [("K103", 3)]
    assert told(tmp_path, "A.LS", text.format("pick all parts   ")) == []
