"""Names, hover, completion, quick fixes, lenses and formatting, in all five languages."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from olp.languages.tokens import TokenKind, spellings
from olp.servers.language.actions import actions, equal, formatting, lenses
from olp.servers.language.document import Place, TextChange
from olp.servers.language.service import ProgramService, complete
from olp.servers.language.symbols import completion, definitions, hover, outline, references, words_of

SAMPLES = Path(__file__).parent.parent / "samples"
INFORM, KRL, RAPID, TP, URSCRIPT = (
    "inform/handling/HANDLING.JBI",
    "krl/handling.src",
    "rapid/handling.mod",
    "tp/handling.ls",
    "urscript/handling.script",
)
LANGUAGES = [INFORM, KRL, RAPID, TP, URSCRIPT]


@pytest.fixture
def service():
    made = ProgramService()
    yield made
    for path in list(made.documents):
        made.close(path)


def opened(service: ProgramService, name: str, text: str | None = None) -> str:
    path = str(SAMPLES / name)
    service.open(path, Path(path).read_bytes().decode() if text is None else text)
    assert service.current(path) is not None
    return path


def place_of(lines: tuple[str, ...], fragment: str) -> Place:
    """Where the mark | stands in the first line that holds the fragment."""
    text = fragment.replace("|", "")
    number = next(n for n, line in enumerate(lines, 1) if text in line)
    return Place(number, lines[number - 1].index(text) + fragment.index("|") + 1)


# A cursor, and the line (of which file) that it leads to.
DEFINED = [
    (INFORM, "MOVJ C0000|1 VJ", "", "C00001=110.500"),
    (INFORM, "JUMP *TA|BLE IF", "", "*TABLE"),
    (INFORM, "CALL JOB:DR|OP", "DROP.JBI", "//NAME DROP"),
    (INFORM, "SET P021 P0|20", "", "P00020="),
    (INFORM, "///USER |1", "", "MFRAME UF#(1)"),
    (INFORM, "DEC B00|0", "", "SET B000 2"),
    (KRL, "PTP XP|1 C_DIS", "handling.dat", "DECL E6POS XP1="),
    (KRL, "  DR|OP ( )", "", "DEF DROP ( )"),
    (KRL, "FOR I|=1", "", "DECL INT I"),
    (RAPID, "MoveJ pAbo|ve,v2000", "", "CONST robtarget pAbove"),
    (RAPID, "Offs(pPart,0,0,40*i|)", "", "FOR i FROM"),
    (RAPID, "MoveAbsJ jHome\\NoEOffs,v1500,fine,tGri|pper", "", "PERS tooldata tGripper"),
    (TP, "JMP LBL[1|0]", "", "LBL[10:back to table]"),
    (TP, "UTOOL[1]=PR[81:gri|pper]", "", "PR[81,1:gripper]=12.5"),
    (URSCRIPT, "movej(home|_q, a=1.4, v=1.1)", "", "global home_q ="),
    (URSCRIPT, "  set_tcp(gripper|_tcp)", "", "global gripper_tcp ="),
]


@pytest.mark.parametrize(("name", "cursor", "file", "line"), DEFINED)
def test_a_name_leads_to_where_it_comes_into_being(service, name, cursor, file, line) -> None:
    analysis = service.analyses[opened(service, name)]
    lines = analysis.source.lines
    found = definitions(service, analysis, *place_of(lines, cursor))
    assert len(found) == 1
    assert Path(found[0].file).name == (file or Path(name).name)
    text = Path(found[0].file).read_text().splitlines()[found[0].line - 1]
    assert line in text


def test_references_are_all_places_of_one_thing_and_none_of_its_namesakes(service) -> None:
    text = (
        "/JOB\n//NAME A\n//POS\n///NPOS 1,0,0,0,0,0\n///TOOL 0\n///PULSE\nC00001=1,2,3,4,5,6\n//INST\n///GROUP1 RB1\n"
        "NOP\nMOVJ C00001 VJ=5.00\nMOVJ C00001 VJ=6.00\nSET B001 1\n'C00001 in a comment\nEND\n"
    )
    path = opened(service, "inform/both.jbi", text + text.replace("NAME A", "NAME B"))
    analysis = service.analyses[path]
    taught = references(service, analysis, 11, 8)
    assert [name.line for name in taught] == [7, 11, 12]
    assert [name.line for name in references(service, analysis, 11, 8, definition=False)] == [11, 12]
    assert [name.line for name in references(service, analysis, 13, 6)] == [13, 28]


def test_references_reach_the_files_that_a_program_needs(service) -> None:
    analysis = service.analyses[opened(service, KRL)]
    found = references(service, analysis, *place_of(analysis.source.lines, "PTP XP|1 C_DIS"))
    assert {Path(name.file).name for name in found} == {"handling.src", "handling.dat"}


@pytest.mark.parametrize("name", LANGUAGES)
def test_the_outline_holds_every_routine_and_only_lines_of_the_text(service, name) -> None:
    analysis = service.analyses[opened(service, name)]
    entries = outline(analysis)
    assert analysis.program is not None
    routines = [entry.name for entry in entries if entry.kind is TokenKind.ROUTINE]
    assert [r.casefold() for r in routines] == [r.name.casefold() for r in analysis.program.routines]
    assert any(child.kind is not TokenKind.ROUTINE for entry in entries for child in (entry, *entry.children))
    for entry in entries:
        for child in (entry, *entry.children):
            assert 1 <= child.line <= child.last <= len(analysis.source.lines)
            assert child.column <= child.end_column <= len(analysis.source.line(child.line)) + 1


@pytest.mark.parametrize("name", LANGUAGES)
def test_hover_on_a_move_tells_time_way_speed_limit_and_pose(service, name) -> None:
    analysis = service.analyses[opened(service, name)]
    assert analysis.timing is not None
    timing, plan = analysis.timing, analysis.timing.plan
    step = next(
        n
        for n in range(len(plan))
        if timing.kind[n] == "linear" and plan.source[n] == 0 and timing.duration_s[n] > 0
    )
    text = hover(service, analysis, int(plan.line[step]), 1)
    assert f"{timing.duration_s[step]:.3f} s" in text
    assert f"{timing.distance_mm[step]:.1f} mm" in text
    assert f"reached {timing.reached_mm_s[step]:.1f} mm/s" in text
    assert f"limited by {timing.limited_by[step]}" in text
    assert "ends at X " in text
    assert " mm, Rx " in text


def test_hover_on_a_name_shows_its_definition(service) -> None:
    analysis = service.analyses[opened(service, INFORM)]
    place = place_of(analysis.source.lines, "MOVJ C0000|1 VJ")
    assert "`C00001=110.500,45.250,160.000" in hover(service, analysis, *place)
    assert hover(service, analysis, 1, 1) == ""


COMPLETED = [
    (INFORM, "MOV|", {"MOVJ", "MOVL", "MOVC"}),
    (INFORM, "MOVL C0|", {"C00000", "C00001"}),
    (INFORM, "MOVL C00001 V|", {"V=", "VJ=", "VR="}),
    (INFORM, "JUMP *|", {"*TABLE", "*REST"}),
    (INFORM, "CALL J|", {"JOB:DROP"}),
    (KRL, "S|", {"SLIN", "SWITCH", "SPLINE"}),
    (KRL, "PTP x|", {"XP1", "XP2"}),
    (RAPID, "    Mo|", {"MoveL", "MoveJ", "MoveAbsJ"}),
    (RAPID, "    MoveL pA|", {"pAbove", "pArc"}),
    (RAPID, "    MoveL pArc,v100,z1|", {"z1", "z10", "z100"}),
    (TP, "   9:  WA|", {"WAIT"}),
    (TP, "   9:  JMP LBL[|", {"LBL[10:back to table]"}),
    (URSCRIPT, "  mov|", {"movel", "movej", "movep", "movec"}),
    (URSCRIPT, "  movel(pi|", {"pick_p"}),
]


@pytest.mark.parametrize(("name", "typed", "wanted"), COMPLETED)
def test_what_may_follow_is_proposed_and_nothing_that_begins_otherwise(service, name, typed, wanted) -> None:
    path = opened(service, name)
    line = typed.replace("|", "")
    found = completion(service.analyses[path], line, 9999, len(line) + 1)
    texts = {one.text for one in found}
    assert wanted <= texts
    start = found[0].column
    assert all(text.casefold().startswith(line[start - 1 :].casefold()) for text in texts)


def test_points_of_a_krl_list_are_proposed_in_its_program(service) -> None:
    path = opened(service, KRL)
    assert "LIFTED" in {one.text for one in completion(service.analyses[path], "LIN LI", 9999, 7)}


@pytest.mark.parametrize("name", LANGUAGES)
def test_the_vocabulary_is_that_of_the_grammar(name) -> None:
    vendor = name.partition("/")[0]
    words = words_of(vendor)
    assert words is not None
    assert len(words.vocabulary()) > 40
    text = (Path(__file__).parent.parent / "grammars" / f"{vendor}.lark").read_text()
    assert any(word in text for word in words.vocabulary())


def test_spellings_of_plain_patterns_are_complete() -> None:
    assert spellings(r"C_(?:PTP|DIS)(?![\w$])") == ["C_PTP", "C_DIS"]
    assert spellings(r"(?:V|VJ)=") == ["V=", "VJ="]
    assert sorted(spellings("AB?C")) == ["ABC", "AC"]
    assert spellings(r"[A-Z]+") == []


def test_a_fix_that_a_rule_carries_is_offered_and_does_what_it_says(service) -> None:
    path = opened(service, "inform/pitfalls/labels.jbi")
    analysis = complete(service, path)
    assert analysis is not None
    finding = next(one for one in analysis.lint if one.fixes)
    offered = [a for a in actions(analysis, finding.line, finding.line) if a.preferred]
    assert [action.code for action in offered] == [finding.code]
    document = service.documents[path]
    gone = document.line(finding.line)
    for edit in offered[0].edits:
        document.change(
            TextChange(Place(edit.line, edit.column), Place(edit.end_line, edit.end_column), edit.text)
        )
    assert gone not in document.text.splitlines()
    again = complete(service, path)
    assert again is not None
    assert finding.message not in {one.message for one in again.lint}


def test_an_excuse_silences_its_finding(service) -> None:
    path = opened(service, "inform/pitfalls/labels.jbi")
    analysis = complete(service, path)
    assert analysis is not None
    finding = analysis.lint[0]
    (excuse,) = [a for a in actions(analysis, finding.line, finding.line) if a.title.startswith("Excuse")]
    (edit,) = excuse.edits
    document = service.documents[path]
    document.change(
        TextChange(Place(edit.line, edit.column), Place(edit.end_line, edit.end_column), edit.text)
    )
    again = complete(service, path)
    assert again is not None
    assert len(again.lint) == len(analysis.lint) - 1


def test_a_misspelt_word_is_offered_as_it_was_meant(service) -> None:
    text = (SAMPLES / INFORM).read_bytes().decode().replace("MOVJ C00001", "MOVY C00001")
    path = opened(service, INFORM, text)
    analysis = service.analyses[path]
    line = next(n for n, one in enumerate(analysis.source.lines, 1) if one.startswith("MOVY"))
    (action,) = actions(analysis, line, line)
    assert action.edits[0].text.startswith("MOV")
    assert not actions(analysis, line + 1, line + 1)


def test_the_lens_tells_the_total_and_every_budget(service, tmp_path) -> None:
    text = (SAMPLES / INFORM).read_bytes().decode()
    (tmp_path / "olp.toml").write_text(
        'robot = "yaskawa/gp25"\n'
        "[[budget]]\nname = 'cell 4'\nlimit_s = 42.0\n"
        "[[budget]]\nname = 'waits'\nof = 'wait'\nlimit_s = 0.1\n"
        "[[budget]]\nname = 'other'\njob = 'ELSEWHERE'\nlimit_s = 1.0\n"
    )
    path = tmp_path / "HANDLING.JBI"
    path.write_bytes(text.encode())
    service.open(str(path), text)
    analysis = service.current(str(path))
    assert analysis is not None
    total, cell, waits = lenses(analysis)
    assert f"{analysis.timing.total_s:.3f} s: motion" in total.text
    assert cell.text.startswith("budget cell 4: ")
    assert cell.text.endswith(f"{42 - analysis.timing.total_s:.3f} s left")
    assert not cell.over
    assert waits.over
    assert "over" in waits.text


def test_a_broken_budget_offers_the_edits_that_hold_it(service, tmp_path) -> None:
    path = tmp_path / "TOUCH-UP.JBI"
    text = (SAMPLES / "inform/touch-up/before/TOUCH-UP.JBI").read_bytes().decode()
    budgets = "[[budget]]\nname = 'cell'\nlimit_s = 3.6\n[[budget]]\nname = 'none'\nlimit_s = 0.1\n"
    (tmp_path / "olp.toml").write_text(f'robot = "yaskawa/ma2010"\n{budgets}')
    path.write_bytes(text.encode())
    service.open(str(path), text)
    analysis = service.current(str(path))
    line = next(lens.line for lens in lenses(analysis) if lens.over)
    (action,) = [one for one in actions(analysis, line, line) if one.title.startswith("Make it")]
    assert action.title == f"Make it 3.6 s: {len(action.edits)} edit{'s' * (len(action.edits) != 1)}"
    rows = text.splitlines()
    for edit in action.edits:
        assert (edit.column, edit.end_column, edit.line) == (1, len(rows[edit.line - 1]) + 1, edit.end_line)
        rows[edit.line - 1] = edit.text
    service.open(str(path), "\r\n".join([*rows, ""]))
    assert analysis.timing.total_s > 3.6 >= service.current(str(path)).timing.total_s
    assert not [one for one in actions(analysis, line + 1, line + 1) if one.title.startswith("Make it")]


@pytest.mark.parametrize("name", [*LANGUAGES, "rapid/pallet.prg", "inform/generations/dx200.jbi"])
def test_formatting_never_changes_what_a_text_means_and_is_done_once(service, name) -> None:
    chance = random.Random(name)
    path = opened(service, name)
    document = service.documents[path]
    for _ in range(40):
        line = chance.randrange(1, len(document) + 1)
        place = Place(line, chance.choice([1, len(document.line(line)) + 1]))
        document.change(TextChange(place, place, chance.choice([" ", "  ", "\t", "      "])))
    before = service.current(path)
    assert before is not None
    edits = formatting(before)
    for edit in reversed(edits):
        document.change(
            TextChange(Place(edit.line, edit.column), Place(edit.end_line, edit.end_column), edit.text)
        )
    after = service.current(path)
    assert after is not None
    assert before.program is not None
    assert after.program is not None
    assert equal(before.program.routines, after.program.routines)
    assert before.timing is None or before.timing.total_s == after.timing.total_s
    assert formatting(after) == []


def test_formatting_lays_out_blocks_and_numbers(service) -> None:
    script = "def a():\nif True:\nsleep(1)\nelse:\n      sleep(2)\nend\nend\na()\n"
    path = opened(service, "urscript/a.script", script)
    laid = {edit.line: edit.text for edit in formatting(service.analyses[path], indent="    ")}
    assert laid[2] == "    if True:"
    assert laid[3] == "        sleep(1)"
    assert laid[4] == "    else:"
    text = (SAMPLES / TP).read_bytes().decode()
    path = opened(service, TP, text.replace("   3:", "  33:"))
    assert [edit.text for edit in formatting(service.analyses[path])] == [
        "   3:  !-------------------------------- ;"
    ]
    assert formatting(service.analyses[path], 1, 10) == []


def test_a_text_that_a_new_layout_would_change_stays_as_it_is(service, monkeypatch) -> None:
    from olp.languages.vendors.urscript import tokens as urscript

    monkeypatch.setattr(
        urscript.UrscriptLayout,
        "lines",
        lambda self, lines, indent: [line.replace("sleep(1)", "sleep(2)") for line in lines],
    )
    path = opened(service, "urscript/a.script", "def a():\n  sleep(1)\nend\na()\n")
    assert formatting(service.analyses[path]) == []


def test_what_changes_the_motion_is_offered_as_such_and_mends_what_it_promises(service) -> None:
    path = opened(service, "inform/pitfalls/stop.jbi", STOPS)
    analysis = complete(service, path)
    assert analysis is not None
    finding = next(one for one in analysis.lint if one.code == "W001")
    offered = [
        a for a in actions(analysis, finding.line, finding.line) if a.title.endswith("changes the motion)")
    ]
    assert offered
    assert not offered[0].preferred
    (edit,) = offered[0].edits
    document = service.documents[path]
    document.change(
        TextChange(Place(edit.line, edit.column), Place(edit.end_line, edit.end_column), edit.text)
    )
    again = complete(service, path)
    assert again is not None
    assert "W001" not in {one.code for one in again.lint}


STOPS = """\
/JOB
//NAME STOP
//POS
///NPOS 4,0,0,0,0,0
///TOOL 0
///POSTYPE BASE
///RECTAN
///RCONF 1,0,0,0,0,0,0,0
C00000=1043.700,-271.300,-60.038,176.4130,-3.9170,11.2730
C00001=1103.700,-271.300,-60.038,176.4130,-3.9170,11.2730
C00002=1183.700,-261.300,-60.038,176.4130,-3.9170,11.2730
C00003=1263.700,-251.300,-60.038,176.4130,-3.9170,11.2730
//INST
///DATE 2026/05/21 11:36
///ATTR SC,RW
///GROUP1 RB1
NOP
MOVJ C00000 VJ=25.00
MOVL C00001 V=300.0 PL=2
MOVL C00002 V=300.0 PL=0
MOVL C00003 V=300.0 PL=0
END
"""
