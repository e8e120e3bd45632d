"""What is wrong with a listing is told with its place, all at once, and nothing else is lost."""

from __future__ import annotations

import pytest
from tp_listings import HEAD, codes, listing, read

from olp.ir.program import Call, Jump, LineKind, Move, SetOutput, Wait

GERMAN = """/PROG  FOLGE7
/ATTR
EIGN.\t\t= GME;
KOMMENTAR\t= "Greifer";
PROG_GR\xd6\xdfE\t= 1132;
ERSTELL\t\t= TAG 25-03-15  ZEIT 13:37:40;
GE\xc4NDERT\t= TAG 25-03-16  ZEIT 15:37:40;
ZEILEN\t\t= 6;
SCHUTZ\t\t= LESEN_SCHREIB;
DEFAULT_GRUP\t= 1,*,*,*,*;
KONTROLLCODE\t= 00000000 00000000;
/MN
   1:  WKZ_NUM=2 ;
   2:  BENUTZER_NUM=1 ;
   3:L P[1] 1500mm/sek CNT0 ACC100 ZEIT VOR    .10sek,P-SPS    ;
      1:  FB-PSPS (AN) ;
      2:  WARTE (E[62] [&] !E[61] [+] E[15])    ;
      3:  WENN (E[19:AN, A[1]),SPRUNG LABEL[3] ;
      4:  LABEL[3] ;
      5:  gA[19]=(11) ;
       ------ ;
   4:  A[15:Greifer AUS]=AN ;
   5:  AUFRUF AUSGANG ;
   6:  i[4]=gE[2]    ;
   7:  !WARTE AUF AUS ;
/POS
P[1]{
   GP1:
\tUF : 1, UT : 2,\t\tKONFIG : 'N U T, 0, 0, 0',
\tX =   110.500  mm,\tY =    12.500  mm,\tZ =     -.384  mm,
\tW =   178.500 deg,\tP =     3.250 deg,\tR =   -21.500 deg
};
/END
"""


def told(text):
    return [(found.code, found.line) for found in read(text).diagnostics if found.is_error]


@pytest.mark.parametrize(
    ("instruction", "code", "message"),
    [
        ("L P[1] 100mm/sec", "P520", "a move without a termination"),
        ("L P[1] FINE", "P520", "a move without a speed"),
        ("L P[1] 0mm/sec FINE", "P520", "a speed that is not positive"),
        ("L P[1] P[2] 100mm/sec FINE", "P520", "a L move with 2 positions"),
        ("C P[1] 100mm/sec FINE", "P520", "a C move with 1 positions"),
        ("L P[1] 100mm/hour FINE", "P520", "'mm/hour'"),
        ("L P[1 100mm/sec FINE", "P520", "is not expected here"),
        ("L P[1] 100mm/sec CNT", "P520", "CNT without its number"),
        ("R[1]=", "P520", "the line ends too early"),
        ("R[1]=R[2]+", "P520", "the line ends too early"),
        ("IF R[1]>2 JMP LBL[1]", "P520", "'JMP' is not expected here"),
        ("SELECT R[1]=1,CALL ...", "P520", "this was not filled in"),
        ("R[...]=1", "P520", "this was not filled in"),
        ("JMP LBL[9]", "P526", "LBL[9] does not exist"),
        ("L P[99] 100mm/sec FINE", "P525", "there is no position P[99]"),
        ("ENDIF", "P528", "ENDIF without IF"),
        ("IF (DI[1]) THEN", "P528", "IF is never closed"),
        ("FOR R[1]=1 TO 3", "P528", "FOR is never closed"),
        ("=2,CALL PICK", "P528", "a case without SELECT"),
        ("R[1]=PULSE,1.0sec", "P520", "a pulse on something that is no output"),
        ("DO[1]=PULSE,5%", "P520", "a pulse in %"),
        ("FOR DI[1]=1 TO 3", "P520", "FOR counts something that is no register"),
        ("R[1]=" + "9" * 25, "P523", "longer than any controller takes"),
        ("R[1]=(" * 300, "P523", "longer than any controller takes"),
    ],
)
def test_a_mistake_is_told_in_its_line(instruction, code, message):
    found = [one for one in read(listing("R[5]=1", instruction, "R[6]=2")).diagnostics if one.is_error]
    assert [(one.code, one.line) for one in found[:1]] == [(code, 9)]
    assert message in found[0].message


def test_no_branch_stands_behind_else():
    program = read(listing("IF (DI[1]) THEN", "ELSE", "R[1]=1", "ELSE", "ENDIF"))
    (found,) = (one for one in program.diagnostics if one.is_error)
    assert (found.code, found.line, found.message) == ("P528", 11, "ELSE behind the ELSE of line 9")


def test_the_caret_stands_under_the_mistake():
    (found,) = (one for one in read(listing("R[5]=1 2")).diagnostics if one.is_error)
    assert found.source_line[found.column - 1 : found.end_column - 1] == "2"


def test_all_mistakes_are_told_at_once():
    program = read(listing("R[1]=", "DO[1]=ON", "JMP LBL[4]", "L P[1] FINE"))
    assert told(listing("R[1]=", "DO[1]=ON", "JMP LBL[4]", "L P[1] FINE")) == [
        ("P520", 8),
        ("P526", 10),
        ("P520", 11),
    ]
    assert [type(s) for s in program.routines[0].body] == [SetOutput, Jump]
    assert program.line_kinds[7] == LineKind.ERROR


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "P500"),
        ("ALARM LOG\n", "P500"),
        ("/PROG  A\n\0/MN\n/END\n", "P500"),
        (HEAD.replace("PART", "") + "/POS\n/END\n", "P501"),
        ("/PROG  A\n/ATTR\n", "P502"),
        (HEAD.replace("PART", "P" * 40) + "/POS\n/END\n", "P503"),
        (HEAD + "   1:  R[1]=2\n   2:  END ;\n/POS\n/END\n", "P504"),
        (HEAD + "   1:  END ;\n/POS\n", "P505"),
        (listing("!" + "long " * 9), "P506"),
        (listing("L P[1] 10mm/sec FINE", points=0), "P515"),
        (listing("SOME NEW THING[3]"), "P521"),
        (listing("OPEN HAND"), "P522"),
        (listing("LBL[1]", "LBL[1]"), "P527"),
        (listing("LBL[70000]"), "P529"),
        (GERMAN, "P530"),
        (GERMAN, "P531"),
        (HEAD + "   1:  END ;\n       ------ ;\n/POS\n/END\n", "P532"),
    ],
)
def test_every_code_has_a_text_that_raises_it(text, code):
    assert code in codes(text)


def test_thousands_of_broken_lines_end_in_one_word():
    found = codes(listing(*[f"R[{n}]=" for n in range(1, 2100)], points=0))
    assert found.count("P524") == 1
    assert found.count("P520") == 2000


def test_conventions_are_told_once_and_only_where_they_matter():
    found = [one.code for one in read(listing("J P[1] 50% FINE")).diagnostics]
    assert found == ["P534"]
    defined = listing("UFRAME[1]=PR[1]", "UTOOL[2]=PR[2]", "J P[1] 50% FINE")
    assert not read(defined).diagnostics


# --- languages and forms --------------------------------------------------------------------------------


def test_a_german_listing_means_what_an_english_one_means():
    program = read(GERMAN)
    assert not [one for one in program.diagnostics if one.is_error]
    english = read(
        HEAD
        + """   1:  UTOOL_NUM=2 ;
   2:  UFRAME_NUM=1 ;
   3:L P[1] 1500mm/sec CNT0 ACC100 TB    .10sec,P-SPS    ;
      1:  TC_ONLINE (ON) ;
      2:  WAIT (DI[62] AND !DI[61] OR DI[15])    ;
      3:  IF (DI[19:AN, A[1]),JMP LBL[3] ;
      4:  LBL[3] ;
      5:  GO[19]=(11) ;
       ------ ;
   4:  DO[15:Greifer AUS]=ON ;
   5:  CALL AUSGANG ;
   6:  R[4]=GI[2]    ;
   7:  !WARTE AUF AUS ;
"""
        + GERMAN[GERMAN.index("/POS") :]
    )
    both = [
        [repr(s).replace(f"line={s.line}", "").replace("/15", "/10") for s in p.routines[0].body]
        for p in (program, english)
    ]
    assert both[0] == both[1]
    details = program.routines[0].details
    assert (details["/ATTR PROTECT"], details["/ATTR DEFAULT_GROUP"]) == ("READ_WRITE", "1,*,*,*,*")
    assert details["/ATTR CREATE"] == "DATE 25-03-15  TIME 13:37:40"
    assert program.routines[0].comment == "Greifer"


def test_listings_without_numbers_and_with_other_line_ends_read_the_same():
    usual = listing("UTOOL_NUM=1", "L P[1] 100mm/sec FINE", "CALL PICK", "WAIT DI[1]=ON")
    expected = [type(s) for s in read(usual).routines[0].body]
    bare = "\n".join(
        line.split(":  ", 1)[-1] if line[:4].strip().isdigit() else line for line in usual.split("\n")
    )
    colon = "\n".join(
        " : " + line.split(":  ", 1)[-1] if line[:4].strip().isdigit() else line for line in usual.split("\n")
    )
    for text in (
        bare,
        colon,
        usual.replace("\n", "\r\n"),
        usual.replace("\n", "\r"),
        usual.replace("   ", "\t"),
    ):
        assert [type(s) for s in read(text).routines[0].body] == expected
        assert read(text).to_bytes() == text.encode("latin-1")


def test_a_long_line_goes_on_behind_a_colon():
    text = (
        HEAD
        + """   1:  WAIT (DI[1:first]=ON AND DI[2]=ON
    :  AND DI[3:third]=ON) TIMEOUT,LBL[4]    ;
   2:  LBL[4] ;
/POS
/END
"""
    )
    program = read(text)
    wait, jump, _ = program.routines[0].body
    assert isinstance(wait, Wait)
    assert jump.target == "4"
    assert (wait.line, jump.line) == (8, 8)
    assert not program.diagnostics


def test_two_programs_in_one_file_are_two_routines():
    program = read(listing("CALL OTHER") + listing("DO[1]=ON").replace("PART", "OTHER"))
    assert [routine.name for routine in program.routines] == ["PART", "OTHER"]
    assert [type(r.body[0]) for r in program.routines] == [Call, SetOutput]


def test_every_line_has_a_kind():
    text = listing("!note", "J P[1] 50% FINE", "NEW THING[1]", "R[1]=", "", "//END")
    program = read(text)
    blank = [n for n, kind in enumerate(program.line_kinds) if kind == LineKind.BLANK]
    assert all(not program.source.lines[n].strip() for n in blank)
    kinds = dict(zip(program.source.lines, program.line_kinds, strict=True))
    assert kinds["   1:  !note ;"] == LineKind.COMMENT
    assert kinds["   3:  NEW THING[1] ;"] == LineKind.OPAQUE
    assert kinds["P[1]{"] == LineKind.POINT
    assert kinds["/POS"] == LineKind.RECORD


def test_points_named_by_moves_are_found_whatever_their_order():
    program = read(listing("J P[3] 50% FINE", "C P[1] P[2] 100mm/sec FINE"))
    assert not [one for one in program.diagnostics if one.is_error]
    assert all(isinstance(s, Move) for s in program.routines[0].body)


def test_a_broken_opening_does_not_make_its_end_wrong_too():
    assert codes(listing("IF (R[1]=) THEN", "ELSE", "ENDIF", "FOR R[1]= TO 3", "ENDFOR")) == ["P520", "P520"]


def test_a_call_with_words_for_arguments_is_kept():
    text = listing("CALL USER(Basic1,Nr1 Service,ProgNr=31, , ,S-Point=31)")
    assert codes(text) == ["P521"]
    assert read(text).routines[0].body[0].text == "CALL USER(Basic1,Nr1 Service,ProgNr=31, , ,S-Point=31)"


def test_instructions_of_options_are_no_macros_and_pallet_moves_are_told_with_a_warning():
    text = listing("PALLETIZING-B_3", "J PAL_3[A_1] 50% CNT30", "L PAL_3[BTM] 100mm/sec FINE", "PALLETIZING-END_3",
                   "Touch Offset PR[1]", "Touch Offset End", "Search End", "Track End")  # fmt: skip
    program = read(text)
    assert {s.text for s in program.routines[0].body} >= {"PALLETIZING-END_3", "L PAL_3[BTM] 100mm/sec FINE"}
    assert not [one for one in program.diagnostics if one.is_error or one.code == "P522"]
    assert [one.severity.name for one in program.diagnostics if "PALLETIZING" in one.message].count(
        "WARNING"
    ) == 1


def test_what_a_move_calls_on_its_way_is_told_once() -> None:
    rows = "   1:L P[1] 100mm/sec FINE TB .10sec,CALL OPEN(1) ;\n   2:L P[1] 100mm/sec FINE TA .10sec,CALL OPEN(1) ;\n"
    rows += "   3:L P[1] 100mm/sec FINE DB 10mm,DO[2]=PULSE,0.5sec ;\n   4:L P[1] 100mm/sec FINE TB .10sec,DO[1]=ON ;\n"
    found = [d for d in read(HEAD + rows + GERMAN[GERMAN.index("/POS") :]).diagnostics if d.code == "P535"]
    assert [d.message.partition(" runs")[0] for d in found] == ["OPEN(1)", "DO[2]=PULSE,0.5sec"]
