"""Points that have numbers in TP and INFORM keep their names, where people write them."""

import re

import olp
from olp.robots.robot import load_robot
from olp.transpile import Context
from olp.transpile.convert import convert
from olp.transpile.link import link
from tests.test_krl_forms import CELL, ON, SAMPLES

BODY = f"""    MoveL pick,v200,fine,{ON};
    MoveC mid,the_place_where_parts_are_put,v100,fine,{ON};
    MoveL pick,v200,fine,{ON};
    MoveL p10,v200,fine,{ON};
    MoveL [[1,45,60],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v200,fine,{ON};"""


def translated(tmp_path, vendor, file):
    cell = CELL.replace("robtarget place", "robtarget the_place_where_parts_are_put")
    cell = cell.replace("VAR robtarget computed:=[[210", "CONST robtarget p10:=[[211")
    (tmp_path / "cell.mod").write_text(cell % BODY)
    made = convert(link(olp.read(tmp_path / "cell.mod")).program, vendor, Context(load_robot("kuka/kr16-2")))
    return made.files[file].decode().replace("\r\n", "\n")


def test_points_have_their_names_in_the_move_and_in_quotes_where_they_are_taught(tmp_path):
    text = translated(tmp_path, "tp", "main.ls")
    assert re.findall(r"[LC] P\[.*?\]|:  P\[.*?\]", text) == [
        "L P[1:pick]",
        "C P[2:mid]",
        ":  P[3:the_place_where_]",
        "L P[1:pick]",
        "L P[4:p10]",
        "L P[5]",
    ]
    assert re.findall(r"^P\[.*?\]", text, re.MULTILINE) == [
        'P[1:"pick"]',
        'P[2:"mid"]',
        'P[3:"the_place_where_"]',
        'P[4:"p10"]',
        "P[5]",
    ]
    assert re.search(r'^COMMENT\t\t= "cell";$', text, re.MULTILINE)


def test_names_come_back_with_the_listing(tmp_path):
    text = translated(tmp_path, "tp", "main.ls")
    (tmp_path / "main.ls").write_text(text)
    program = olp.read(tmp_path / "main.ls")
    assert program.routines[0].details["P[1]"] == "pick"
    assert not [d for d in program.diagnostics if d.is_error]
    assert 'P[1:"pick"]{' in program.export("tp").decode()


def test_names_of_a_listing_go_into_other_languages(tmp_path):
    (tmp_path / "main.ls").write_text(translated(tmp_path, "tp", "main.ls"))
    program = link(olp.read(tmp_path / "main.ls")).program
    for vendor, form in (("rapid", r"MoveL (\w+)"), ("krl", r"LIN (\w+)"), ("inform", r"MOVL .*//(\w+)")):
        files = convert(program, vendor, Context(load_robot("kuka/kr16-2"))).files
        text = b"".join(files.values()).decode()
        assert re.findall(form, text) == ["pick", "pick", "p10", *(["P5"] if vendor != "inform" else [])], (
            text
        )


def test_a_name_that_no_target_can_spell_gives_way_to_the_number(tmp_path):
    listing = translated(tmp_path, "tp", "main.ls").replace('P[2:"mid"]', 'P[2:"---"]')
    (tmp_path / "main.ls").write_text(listing)
    made = convert(link(olp.read(tmp_path / "main.ls")).program, "rapid", Context(load_robot("kuka/kr16-2")))
    assert re.search(r"MoveC P2,", b"".join(made.files.values()).decode())


def test_informs_moves_have_the_name_behind_them_where_they_have_no_comment(tmp_path):
    text = translated(tmp_path, "inform", "main.JBI")
    assert re.findall(r"^MOV\w (C\d+) .*?(?:  //(.*))?$", text, re.MULTILINE) == [
        ("C00000", "pick"),
        ("C00000", "pick"),  # where the arc begins
        ("C00001", "mid"),
        ("C00002", "the_place_where_"),
        ("C00000", "pick"),
        ("C00003", "p10"),
        ("C00004", ""),
    ]


def test_numbers_of_another_language_are_no_names(tmp_path):
    source = link(olp.read(SAMPLES / "inform" / "handling" / "HANDLING.JBI")).program
    made = convert(source, "tp", Context(load_robot("yaskawa/gp25")))
    assert not re.search(rb"P\[\d+:", made.files["HANDLING.ls"].replace(b"PR[", b""))
