"""`olp lint --load` in INFORM, TP, VAL3, AS and PDL2: each rule tells its mistake at its line, and nothing of a sound
program."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from olp.checks.lint.run import lint_load
from olp.reports.batch import Job


class Sound(NamedTuple):
    """A program that a controller takes, and files of its cell."""

    file: str
    text: str
    beside: dict[str, str]


INFORM = Sound(
    "SEAM-12.JBI",
    """/JOB
//NAME SEAM-12
//POS
///NPOS 2,0,0,0,0,0
///TOOL 2
///POSTYPE PULSE
///PULSE
C00000=-1203,20417,-33120,512,-41877,902
C00001=-1203,20418,-33120,512,-41877,902
//INST
///DATE 2026/03/02 14:07
///ATTR SC,RW
///GROUP1 RB1
///LVARS 1,0,2,0,0,0,0,0
NOP
'start of the seam
*TOP
MOVJ C00000 VJ=25.00 PL=2
MOVL C00001 V=187.0  //operator's side
GETARG LD001 IARG#(1)
SET B003 255
SET LB000 1
MSG "what's next"
CALL JOB:WELD ARGF12 ARGFLD000
JUMP *TOP IF IN#(12)=ON
END
""",
    {"WELD.JBI": "/JOB\n//NAME WELD\n//POS\n///NPOS 0,0,0,0,0,0\n//INST\n///ATTR SC,RW\nNOP\nEND\n"},
)
TP = Sound(
    "PICK_2.LS",
    """/PROG  PICK_2
/ATTR
COMMENT = "left side";
DEFAULT_GROUP = 1,*,*,*,*;
/MN
   1:  !it's ; the left ; ;
   2:  LBL[1:again] ;
   3:J P[1:over] 100% CNT100    ;
   4:L P[2] R[3]mm/sec FINE    ;
   5:  R[1:count]=AR[1] ;
   6:  GO[1]=R[1:count] ;
   7:  CALL GRIP(1,(-2.5),'wide, -1') ;
   8:  IF R[1:0 is none]>3,JMP LBL[1] ;
/POS
P[1:"over"]{
   GP1:
    UF : 0, UT : 1,  CONFIG : 'N U T, 0, 0, 0',
    X = 812.4 mm, Y = -33.1 mm, Z = 707.5 mm,
    W = 12.5 deg, P = 3.5 deg, R = 178.25 deg
};
P[2]{
   GP1:
    UF : 0, UT : 1,  CONFIG : 'N U T, 0, 0, 0',
    X = 812.4 mm, Y = -33.1 mm, Z = 607.5 mm,
    W = 12.5 deg, P = 3.5 deg, R = 178.25 deg
};
/END
""",
    {"GRIP.LS": "/PROG  GRIP\n/MN\n   1:  R[2]=AR[1] ;\n/END\n"},
)
VAL3 = Sound(
    "start.pgx",
    """<?xml version="1.0" encoding="utf-8" ?>
<Programs xmlns="http://www.staubli.com/robotics/VAL3/Program/2">
  <Program name="start">
    <Parameters>
      <Parameter name="x_nCount" type="num" xsi:type="element" />
    </Parameters>
    <Locals>
      <Local name="l_nPart" type="num" xsi:type="array" size="1" />
    </Locals>
    <Code><![CDATA[begin
  // the part's number
  for l_nPart=1 to x_nCount
    movej(jHome,tGrip,mFast)
    movel(appro(pPick,{0,0,-50,0,0,0}),tGrip,mFast)
    waitEndMove()
    call pick(l_nPart,"part, one")
    if esStatus()==0 and pPick.trsf.x>100
      lib:open(flange)
    endIf
  endFor
end]]></Code>
  </Program>
</Programs>
""",
    {
        "cell.pjx": '<Project><Programs><Program file="start.pgx" /><Program file="pick.pgx" /></Programs>'
        '<Database><Data file="cell.dtx" /></Database></Project>\n',
        "pick.pgx": '<Programs>\n<Program name="pick">\n<Parameters>\n<Parameter name="x_nOne" type="num" />\n'
        '<Parameter name="x_sTwo" type="string" />\n</Parameters>\n<Code><![CDATA[begin\nend]]></Code>\n</Program>\n'
        "</Programs>\n",
        "cell.dtx": "<Database>\n<Datas>\n"
        + "".join(
            f'<Data name="{name}" type="{kind}" size="1" />\n'
            for name, kind in (
                ("jHome", "jointRx"),
                ("pPick", "pointRx"),
                ("tGrip", "tool"),
                ("mFast", "mdesc"),
            )
        )
        + "</Datas>\n</Database>\n",
    },
)
AS = Sound(
    "cell.as",
    """.PROGRAM main() #0
  ; it's "begun
  speed.fast = 80
  x = SQRT(ABS(-2))+ATAN2(1,2)
10 JMOVE #home
again:
  LMOVE pick.left
  CALL grip.part(.n,x)
  CALL grip.left
  $s = $MID("a,b",1,1)
  IF x > 3 GOTO again
.END
.PROGRAM grip.part(.one,.two) #0
  SIGNAL .one
.END
.PROGRAM grip.right() #0
  SIGNAL -2
.END
""",
    {},
)
PDL2 = Sound(
    "cell.pdl",
    """PROGRAM cell PROG_ARM = 1
CONST
  most = 4
VAR
  count, other : INTEGER
  way : ARRAY[3] OF POSITION
  s : STRING[20]
ROUTINE drop(k : INTEGER; VAR r, q : REAL)
VAR
  count : INTEGER
BEGIN
  count := k -- the routine's own := one
  r := q
END drop
ROUTINE far(a : INTEGER) EXPORTED FROM library
BEGIN
again::
  FOR count := 1 TO most DO
    way[count].X := 12.5
    drop(count, other, &
      3)
  ENDFOR
  s := 'drop(1) := x'
  $LIN_SPD := 0.25
  IF count > 2 THEN
    GOTO again
  ENDIF
END cell
""",
    {},
)
ALL = {"inform": INFORM, "tp": TP, "val3": VAL3, "as": AS, "pdl2": PDL2}


def told(
    folder: Path, language: str, old: str = "", new: str = "", controller: str = ""
) -> list[tuple[str, int]]:
    """(code, line) of what is told of the sound program with `new` for `old`, in any of the cell's files."""
    sound = ALL[language]
    files = {sound.file: sound.text, **sound.beside}
    assert not old or any(old in text for text in files.values())
    for name, text in files.items():
        folder.joinpath(name).write_text(text.replace(old, new, 1) if old else text, encoding="utf-8")
    return [
        (found.code, found.line)
        for name in files
        for found in lint_load(str(folder / name), Job(), controller).findings
    ]


@pytest.mark.parametrize("language", ALL)
def test_a_sound_program_is_told_nothing_of(language: str, tmp_path: Path) -> None:
    assert told(tmp_path, language) == []


@pytest.mark.parametrize(
    ("language", "old", "new", "expected"),
    [
        ("inform", "//NAME SEAM-12", "//NAME SEAM-12-OF-THE-LEFT-SIDE-OF-THE-PART", ("K103", 2)),
        ("inform", "C00001=", "C00000=", ("K102", 9)),
        ("inform", "///TOOL 2", "///TOOL 64", ("K109", 5)),
        ("inform", "///GROUP1 RB1\n", "", ("K114", 17)),
        ("inform", "*TOP\n", "*TOP\n*TOP\n", ("K102", 18)),
        ("inform", "SET B003 255", "SET B003 256", ("K108", 21)),
        ("inform", "SET B003 255", "SET I003 32768", ("K108", 21)),
        ("inform", "VJ=25.00", "VJ=125.00", ("K109", 18)),
        ("inform", "SET LB000", "SET LB001", ("K109", 22)),
        ("inform", "LD001", "LD002", ("K109", 20)),
        ("inform", "///LVARS 1,0,2,0,0,0,0,0\n", "", ("K109", 19)),
        ("inform", "IARG#(1)", "IARG#(9)", ("K109", 20)),
        ("inform", "ARGF12", "ARGF1 ARGF2 ARGF3 ARGF4 ARGF5 ARGF6 ARGF7 ARGF8", ("K112", 24)),
        ("inform", "SET LB000 1", "SET LB000 1 'one", ("K105", 22)),
        ("inform", "GETARG", "GETTARG", ("K101", 20)),
        ("inform", "JOB:WELD", "JOB:WELDS", ("K101", 24)),
        ("inform", "VJ=25.00", "V=25.0", ("K108", 18)),
        ("inform", "VJ=25.00 PL=2", "VJ=25.00 +MOVJ C00001 V=10.0", ("K108", 18)),
        ("inform", "V=187.0", "VJ=18.00", ("K108", 19)),
        ("inform", "V=187.0", "V=187.0 ACC=101", ("K109", 19)),
        ("inform", "SET B003 255", "TIMER T=656.00", ("K109", 21)),
        ("inform", "SET B003 255", "DOUT IN#(1) ON", ("K108", 21)),
        ("inform", "SET B003 255", "DOUT OT#(1) 1", ("K108", 21)),
        ("inform", "SET B003 255", "INC P003", ("K108", 21)),
        ("tp", "/PROG  PICK_2", "/PROG  PICK_THE_PART_FROM_THE_LEFT_SIDE_NOW_2", ("K103", 1)),
        ("tp", "/PROG  PICK_2", "/PROG  2PICK", ("K105", 1)),
        ("tp", '"left side"', '"left "side""', ("K105", 3)),
        ("tp", "= 1,*", "= *,*", ("K114", 8)),
        ("tp", "2:  LBL[1:again] ;", "2:  LBL[1:again] ;\n   3:  LBL[1] ;", ("K102", 8)),
        ("tp", "2:  LBL[1:again] ;", "2:  LBL[1:again] ;\n   3:  LBL[32767] ;", ("K109", 8)),
        ("tp", "P[2]{", "P[1]{", ("K102", 21)),
        ("tp", "R[1:count]=AR", "R[0:count]=AR", ("K109", 10)),
        ("tp", "100% CNT", "101% CNT", ("K109", 8)),
        ("tp", "CNT100", "CNT101", ("K109", 8)),
        ("tp", "R[3]mm/sec", "AR[3]mm/sec", ("K108", 9)),
        ("tp", "CNT100", "CNT AR[1]", ("K108", 8)),
        ("tp", "GO[1]=R[1:count]", "GO[1]=GI[1:count]", ("K108", 11)),
        ("tp", "(-2.5)", "-2.5", ("K112", 12)),
        ("tp", "(1,(-2.5)", "(1,2,3,4,5,6,7,8,9,10,(-2.5)", ("K112", 12)),
        ("tp", "CALL GRIP", "CALL GRIPP", ("K101", 12)),
        ("tp", "100% CNT", "100mm/sec CNT", ("K108", 8)),
        ("tp", "R[3]mm/sec", "R[3]%", ("K108", 9)),
        ("tp", "GO[1]=R[1:count]", "DO[1]=1", ("K108", 11)),
        ("tp", "GO[1]=R[1:count]", "WAIT DI[1:part]<>0", ("K108", 11)),
        ("tp", "GO[1]=R[1:count]", "OVERRIDE=101%", ("K109", 11)),
        ("tp", "GO[1]=R[1:count]", "PR[1,10]=R[1:count]", ("K109", 11)),
        ("tp", "GO[1]=R[1:count]", "IF DI[1:part]=ON THEN ;\n   7:  ENDIF", ("K114", 11)),
        ("tp", "GO[1]=R[1:count]", "IF DI[1]=ON AND !DI[2],JMP LBL[1]", ("K114", 11)),
        ("tp", "GO[1]=R[1:count]", "IF DI[1]=ON AND DI[2]=ON OR R[1]>2,JMP LBL[1]", ("K114", 11)),
        ("tp", "GO[1]=R[1:count]", "WAIT DI[1]=ON OR DI[2]=ON AND R[1]>2", ("K114", 11)),
        ("val3", '<Local name="l_nPart"', '<Local name="x_nCount"', ("K102", 8)),
        ("val3", 'name="jHome"', 'name="pPick"', ("K102", 4)),
        ("val3", '<Local name="l_nPart"', '<Local name="until"', ("K104", 8)),
        ("val3", "movej(jHome", "movej(jSafe", ("K101", 13)),
        ("val3", "call pick", "call drop", ("K101", 16)),
        ("val3", "waitEndMove", "waitEndMoves", ("K101", 15)),
        ("val3", 'file="pick.pgx"', 'file="drop.pgx"', ("K101", 1)),
        ("val3", "waitEndMove()", "delay()", ("K112", 15)),
        ("val3", "appro(pPick,{0,0,-50,0,0,0})", "appro(pPick)", ("K112", 14)),
        ("val3", 'pick(l_nPart,"part, one")', "pick(l_nPart)", ("K112", 16)),
        ("as", "speed.fast =", "speed.of.the.left.gun =", ("K103", 3)),
        ("as", ".PROGRAM grip.right()", ".PROGRAM grip.right.of.all()", ("K103", 16)),
        ("as", ".PROGRAM grip.right()", ".PROGRAM Main()", ("K102", 16)),
        ("as", "  LMOVE", "Again: LMOVE", ("K102", 7)),
        ("as", "  LMOVE", "10 LMOVE", ("K102", 7)),
        ("as", "CALL grip.part", "CALL grpi.part", ("K101", 8)),
        ("as", "grip.part(.n,x)", "grip.part(.n,x,1)", ("K112", 8)),
        ("as", "ATAN2(1,2)", "ATAN2(1)", ("K112", 4)),
        ("as", "LMOVE", "LMOVES", ("K101", 7)),
        ("pdl2", "  s : STRING", "  most : STRING", ("K102", 7)),
        ("pdl2", "  count : INTEGER\n", "  q : INTEGER\n", ("K102", 10)),
        ("pdl2", "  s : STRING", "  theNumberOfThePartsThatAreStillLeft : STRING", ("K103", 7)),
        ("pdl2", "  s : STRING", "  until : STRING", ("K104", 7)),
        ("pdl2", "again::", "VAR x : INTEGER\nBEGIN\nagain::", ("K106", 17)),
        ("pdl2", "  s := '", "  ss := '", ("K101", 23)),
        ("pdl2", "FOR count", "FOR counter", ("K101", 18)),
        ("pdl2", "  s := 'drop", "  most := 'drop", ("K111", 23)),
        ("pdl2", "drop(count, other, &", "drop(count, &", ("K112", 20)),
        ("pdl2", "  IF count", "again::\n  IF count", ("K102", 25)),
    ],
)
def test_each_mistake_is_told(
    language: str, old: str, new: str, expected: tuple[str, int], tmp_path: Path
) -> None:
    found = told(tmp_path, language, old, new)
    assert expected in found, found


def test_names_are_shorter_on_older_controllers(tmp_path: Path) -> None:
    assert told(tmp_path, "inform", "SEAM-12", "SEAM-1234", "nx100") == [("K103", 2)]
    assert ("K103", 17) in told(tmp_path, "inform", "*TOP", "*TOPOFALL1", "nx100")
    assert told(tmp_path, "tp", "PICK_2", "PICK_2345", "r-j3") == [("K103", 1)]


def test_what_may_stand_elsewhere_is_not_missed(tmp_path: Path) -> None:
    assert told(tmp_path, "inform", "JOB:WELD", "JOB:GRIND") == []  # no whole backup
    assert told(tmp_path, "tp", "CALL GRIP", "CALL SCAN") == []
    assert told(tmp_path, "as", "CALL grip.part(.n,x)", "CALL scan") == []
    assert told(tmp_path, "pdl2", "CONST\n", "IMPORT 'library'\nCONST\n") == []
    assert told(tmp_path, "val3", "esStatus", "cs9Status") == []  # of a later version


def test_what_versions_take_otherwise_is_no_mistake(tmp_path: Path) -> None:
    for sound in (
        "cls(scPage)",
        "gotoxy(scPage,0,1)",
        "gotoxy(0,1)",
        "nKey=getKey(scPage)",
        "delete(sNames[1])",
    ):
        new = f"l_nPart=1 // {sound}\n    {sound.replace('scPage', 'x_nCount').replace('nKey', 'x_nCount')}"
        new = new.replace("sNames", "l_nPart")
        assert told(tmp_path, "val3", "waitEndMove()", new) == [], sound
    assert ("K112", 15) in told(tmp_path, "val3", "waitEndMove()", "gotoxy(0)")


def test_only_call_means_a_program_of_val3_that_has_a_functions_name(tmp_path: Path) -> None:
    (tmp_path / "isSettled.pgx").write_text(VAL3.beside["pick.pgx"].replace("pick", "isSettled"))
    assert told(tmp_path, "val3", "esStatus()==0", "isSettled()") == []
    assert told(tmp_path, "val3", "call pick(", "call isSettled(") == []
    assert told(tmp_path, "val3", "call pick(l_nPart,", "call isSettled(") == [("K112", 16)]


def test_a_program_of_karel_is_not_its_listing(tmp_path: Path) -> None:
    assert told(tmp_path, "tp", "CALL GRIP", "CALL GR_IP") == []


def test_a_pdl2_program_exports_its_own_routine(tmp_path: Path) -> None:
    head = "ROUTINE drop(k : INTEGER; VAR r, q : REAL)"
    exported = f"{head} EXPORTED FROM cell GLOBAL\n{head}"
    assert told(tmp_path, "pdl2", head, exported) == []
    assert told(tmp_path, "pdl2", head, f"{exported}\nBEGIN\nEND drop\n{head}") == [("K102", 12)]


@pytest.mark.parametrize(
    ("language", "old", "new"),
    [
        ("val3", "movej(jHome", "movej(pHome"),  # its type, in its first letter
        ("tp", "CALL GRIP", "CALL GRIT"),
        ("inform", "JOB:WELD", "JOB:WELT"),
        ("as", '$MID("a,b",1,1)', '$MID("a,b",1)'),
    ],
)
def test_a_name_of_a_series_is_no_mistake(language: str, old: str, new: str, tmp_path: Path) -> None:
    sound = ALL[language]
    files = {sound.file: sound.text.replace(old, new), **sound.beside}
    assert files[sound.file] != sound.text
    for name in files.keys() - {"cell.pjx"}:  # which says that no file is missing
        (tmp_path / name).write_text(files[name])
    assert lint_load(str(tmp_path / sound.file), Job(), "").findings == ()


def test_a_backup_holds_all_jobs(tmp_path: Path) -> None:
    (tmp_path / "SYSTEM.SYS").write_text("R1 : 1-06VX88-A0*(GP88)\n")
    assert told(tmp_path, "inform", "JOB:WELD", "JOB:GRIND") == [("K101", 24)]


def test_names_of_an_import_may_be_any(tmp_path: Path) -> None:
    text = PDL2.text.replace("CONST\n", "IMPORT 'library'\nCONST\n").replace("  s := ", "  theirs := ")
    (tmp_path / "cell.pdl").write_text(text)
    assert lint_load(str(tmp_path / "cell.pdl"), Job(), "").findings == ()
