"""Registers that live on when a program ends keep what others set; positions without a value are asked for."""

from __future__ import annotations

import re

import numpy as np
import pytest
from translated_texts import converted as translation
from translated_texts import tp

import olp
from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import Assign, SetOutput
from olp.transpile import Context
from olp.transpile.convert import convert
from olp.transpile.link import link

HEAD = "/PROG  P\n/ATTR\n/MN\n"
POSE = "\tX= 900 mm, Y= 0 mm, Z= 900 mm,\n\tW= 0 deg, P= 90 deg, R= 0 deg\n"
TAIL = "/POS\nP[1]{\n   GP1:\n\tUF : 0, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n" + POSE + "};\n/END\n"
SET_BY_OTHERS = HEAD + "   1:  R[6:LIFT OFFS]=R[113:PART HEIGHT]+20 ;\n   2:  R[113:PART HEIGHT]=7 ;\n" + TAIL
BY_NUMBER = (
    HEAD
    + "   1:L PR[3] 50mm/sec FINE ;\n   2:  R[1]=R[1]+1 ;\n   3:  PR[R[1]]=P[1] ;\n   4:  PR[4]=P[1] ;\n"
    + "   5:L PR[4] 50mm/sec FINE ;\n   6:L PR[R[1]] 50mm/sec FINE ;\n"
    + TAIL
)


def converted(text, target):
    made = convert(
        read_source(decode(text.encode(), "p.ls"), vendor="tp"), target, Context(on_loss="comment")
    )
    return made, read_source(decode(made.files[made.main], made.main), vendor=target)


def test_no_register_is_set_to_zero_that_the_program_does_not_set():
    _, program = converted(SET_BY_OTHERS, "inform")
    sets = [s for s in program.statements() if isinstance(s, Assign)]
    assert len(sets) == 2  # as many as in the source


@pytest.mark.parametrize("target", ["krl", "rapid"])
def test_positions_among_those_chosen_by_number_are_asked_for(target):
    made, _ = converted(BY_NUMBER, target)
    (asked,) = made.translated.asks["teach these positions, which are zeros now"]
    assert asked.partition(" (")[0] == "PV[3]"
    assert [(loss.line, loss.part) for loss in made.translated.losses if loss.part == "position"] == [
        (4, "position")
    ]


@pytest.mark.parametrize("target", ["inform", "krl", "tp"])
def test_a_signal_0_gets_a_number_that_the_target_has_and_that_is_free(target):
    text = "def p():\n  set_digital_out(1, True)\n  set_digital_out(0, True)\nend\n"
    made = convert(read_source(decode(text.encode(), "p.script"), vendor="urscript"), target)
    program = read_source(decode(made.files[made.main], made.main), vendor=target)
    assert [s.signal.index.value for s in program.statements() if isinstance(s, SetOutput)] == [1, 2]
    assert [thing for things in made.translated.asks.values() for thing in things] == ["out 0 is 2"]


def _types_of_registers(*rows):
    lines = "".join(f"   {n}:  {row} ;\n" for n, row in enumerate(rows, 1))
    made, _ = converted(HEAD + lines + TAIL, "krl")
    text = b"\n".join(made.files.values()).decode()
    return dict(
        reversed(found.split(" ")) for found in re.findall(r"(?m)(?<=DECL )?\b(?:INT|REAL) \w+", text)
    )


@pytest.mark.parametrize(
    ("rows", "kind"),
    [
        (["R[1]=0", "R[1]=R[1]+1", "R[2]=R[1]"], "INT"),
        (["R[2]=R[1]", "R[1]=0"], "REAL"),  # what is there when it starts may be a fraction
        (["R[1]=R[1]+1", "R[2]=R[1]"], "REAL"),
        (["R[1]=0", "CALL ELSEWHERE", "R[2]=R[1]"], "REAL"),  # which may set it to a fraction
        (["R[1]=0", "CALL ELSEWHERE", "R[1]=3", "R[2]=R[1]"], "INT"),
        (["IF DI[1]=ON,R[1]=3", "R[2]=R[1]"], "REAL"),
    ],
)
def test_a_register_counts_with_whole_numbers_only_where_nothing_else_sets_what_is_read(rows, kind):
    types = _types_of_registers(*rows)
    assert types["R1"] == types["R2"] == kind


TABLE = "".join(f"q[{i},{j}] {300 + i} {j} 400 0 180 0\n" for i in range(1, 111) for j in range(1, 101))


def test_elements_of_a_table_that_has_no_room_are_points_where_their_index_is_a_number():
    moves = "LMOVE q[1,1]\nLMOVE q[39,29]\nFOR i = 1 TO 110\nLMOVE q[i,1]\nLMOVE q[i,2]\nEND\nLMOVE q[2,7]\n"
    text = f".PROGRAM p()\nSPEED 100 MM/S ALWAYS\n{moves}.END\n.TRANS\n{TABLE}.END\n"
    source = read_source(decode(text.encode(), "p.as"))
    made = convert(source, "inform", Context(on_loss="comment"))
    left_out = {loss.line: loss.says for loss in made.translated.losses if loss.leaves_out}
    assert left_out.keys() == {6, 7}
    assert all("more than 10000 variables" in says for says in left_out.values())
    found = read_source(decode(made.files[made.main], made.main)).plan()
    places = found.positions.position[found.moves.target]
    np.testing.assert_allclose(places * 1000, [[301, 1, 400], [339, 29, 400], [302, 7, 400]], atol=1e-3)


@pytest.mark.parametrize(
    ("target", "most", "asked"),
    [
        ("inform", 10_000, "P2019 is used, 128 are delivered"),
        ("tp", 2000, "PR[2000] is used, 100 are delivered"),
    ],
)
def test_each_move_to_a_position_for_which_no_variable_is_left_is_left_out(target, most, asked):
    rows = "".join(f"LMOVE a{n}\n" for n in range(2020)) * 2
    source = read_source(decode(f".PROGRAM p()\nSPEED 100 MM/S ALWAYS\n{rows}.END\n".encode(), "p.as"))
    made = convert(source, target, Context(on_loss="comment"))
    beyond = {loss.line for loss in made.translated.losses if loss.leaves_out}
    assert beyond == {n + 3 for n in (*range(most, 2020), *range(2020 + most, 4040)) if most < 2020}
    beginning = "set the controller up for more variables than it is delivered with"
    assert made.translated.asks[beginning] == (asked,)


def test_numbers_that_routines_have_for_themselves_need_no_larger_controller():
    own = "".join(f"local x{n} = {n}.5\n" for n in range(60))
    sums = "+".join(f"x{n}" for n in range(60))
    routines = "".join(f"def r{k}():\n{own}textmsg({sums})\nend\n" for k in range(3))
    text = f"def p():\n{routines}r0()\nr1()\nr2()\nend\n"
    made = convert(read_source(decode(text.encode(), "p.script"), vendor="urscript"), "inform")
    assert not made.translated.asks


def test_a_listing_that_calls_itself_and_takes_arguments_is_left_out_and_no_more(tmp_path):
    own = (
        HEAD.replace("P\n", "OWN\n", 1)
        + "   1:  R[1]=AR[1] ;\n   2:  CALL OWN(2) ;\n   3:  R[2]=AR[1] ;\n"
        + TAIL
    )
    (tmp_path / "own.ls").write_text(own)
    (tmp_path / "p.ls").write_text(HEAD + "   1:L P[1] 50mm/sec FINE ;\n   2:  CALL OWN(1) ;\n" + TAIL)
    linked = link(olp.read(tmp_path / "p.ls")).program
    made = convert(linked, "inform", Context(on_loss="comment"))
    left_out = {loss.statement for loss in made.translated.losses if loss.leaves_out}
    assert left_out == {"Call", "Assign"}
    assert b"MOVL C00000" in made.files[made.main]


def test_configurable_signals_are_further_ones_of_fanuc_and_robot_signals_its_own():
    text = "def p():\n  set_configurable_digital_out(3, True)\n  set_tool_digital_out(1, True)\nend\n"
    made = convert(read_source(decode(text.encode(), "p.script"), vendor="urscript"), "tp")
    job = made.files[made.main].decode()
    assert "DO[403]=ON" in job
    assert "DO[301]=ON" in job
    (asked,) = made.translated.asks.values()
    assert asked == ("configurable-out 3 is out 403", "tool-out 1 is out 301")
    program = "PROGRAM p\nBEGIN\n  $FDOUT[2] := TRUE\nEND p\n"
    own = convert(read_source(decode(program.encode(), "p.pdl"), vendor="pdl2"), "tp")
    assert "RO[2]=ON" in own.files[own.main].decode()


def test_positions_built_by_component_have_registers_of_a_larger_controller_where_all_others_are_taken():
    moves = "".join(f"  p{n} = get_actual_tcp_pose()\n  movel(p{n})\n" for n in range(102))
    branch = "  if get_standard_digital_in(1):\n    set_tcp(p[0,0,0.2,0,0,0])\n  end\n"
    text = f"def p():\n  set_tcp(p[0,0,0.1,0,0,0])\n{moves}{branch}  movel(p0)\nend\n"
    made = convert(
        read_source(decode(text.encode(), "p.script"), vendor="urscript"), "tp", Context(on_loss="comment")
    )
    job = made.files[made.main].decode()
    numbers = {int(n) for n in re.findall(r"PR\[(\d+)", job)}
    assert max(numbers) > 100
    assert "UTOOL[1]=PR[" in job


def test_a_register_that_chooses_a_position_register_is_read_and_may_hold_any_number():
    """It was taken for the 0 that nothing here changes: the line was left out, or R5 not asked for."""
    text = tp("PR[R[5]]=LPOS", "L PR[R[7]] 100mm/sec FINE")
    made = translation(text, "tp", "krl")
    written = b"".join(made.files.values()).decode("cp1252")
    assert "PV[R5]=$POS_ACT" in written
    assert "LIN PV[R7]" in written
    asked = {name for says, names in made.translated.asks.items() if "zeros now" in says for name in names}
    assert {"R5", "R7"} <= asked


def test_a_position_to_teach_names_the_tool_and_the_frame_of_its_moves():
    text = tp(
        "UFRAME_NUM=2", "UTOOL_NUM=3", "L PR[3] 100mm/sec FINE", "UFRAME_NUM=0", "L PR[4] 100mm/sec FINE"
    )
    asked = [name for names in translation(text, "tp", "inform").translated.asks.values() for name in names]
    assert "PV3 (tool 3 in frame 2)" in asked
    assert "PV4 (tool 3 in the base)" in asked
