"""What a move does at its end is done in the other language, too."""

from __future__ import annotations

import pytest
from translated_texts import ROBOT, module, read, run_elsewhere
from translated_texts import converted as translated_at_once

from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import Call, Move, SetOutput
from olp.transpile import Context
from olp.transpile.compare import compare_plans
from olp.transpile.context import Fate
from olp.transpile.convert import convert

HEAD = (
    "MODULE M\nCONST robtarget p:=[[900,0,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nPROC main()\n"
)
TAIL = "ENDPROC\nPROC grip()\nSetDO do6,1;\nENDPROC\nENDMODULE\n"
LANGUAGES = ["inform", "krl", "tp", "urscript"]


def converted(lines, target):
    source = read_source(decode((HEAD + lines + TAIL).encode(), "M.mod"), vendor="rapid")
    made = convert(source, target, Context(on_loss="comment"))
    program = read_source(decode(made.files[made.main], made.main), vendor=target)
    main = next(r for r in program.routines if r.name.casefold() == "main")
    return made, [s for s in main.body if isinstance(s, (Move, SetOutput, Call))]


@pytest.mark.parametrize("target", LANGUAGES)
def test_an_output_of_a_move_is_set_behind_it(target):
    made, body = converted("MoveL p,v100,fine,tool0;\nMoveLDO p,v100,fine,tool0,do5,1;\n", target)
    assert [type(s) for s in body] == [Move, Move, SetOutput]
    assert body[2].signal.index.value == 5
    assert not [loss for loss in made.translated.losses if loss.part in ("end", "option")]


@pytest.mark.parametrize("target", LANGUAGES)
def test_a_routine_of_a_move_that_passes_by_is_called_and_the_receipt_says_where(target):
    made, body = converted('MoveLSync p,v100,z10,tool0,"grip";\nMoveL p,v100,fine,tool0;\n', target)
    assert [type(s) for s in body] == [Move, Call, Move]
    assert [loss.line for loss in made.translated.losses if loss.part == "end"] == [4]


def test_a_process_move_is_refused_with_what_it_does_beside_moving():
    made, body = converted("TriggL p,v100,gunon,fine,tool0;\n", "krl")
    assert not any(isinstance(s, Move) for s in body)
    says = "the option TriggL means nothing in KRL, and the move without it is another one"
    assert says in {loss.says for loss in made.translated.losses if loss.leaves_out}


# --- triggers ---------------------------------------------------------------------------------------------


_TRIGGERS = (
    "VAR triggdata gun;", "VAR triggdata off;", "VAR num x:=3;",
    "CONST robtarget p1:=[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
    "CONST robtarget p2:=[[900,200,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
)  # fmt: skip
_MOVES = (
    "MoveJ p1,v100,fine,tool0;",
    "TriggL p2,v100,gun\\T2:=off,z10,tool0;",
    "TriggL p1,v100,gun,fine,tool0;",
)


@pytest.mark.parametrize("target", LANGUAGES)
@pytest.mark.parametrize(
    "rows",
    [
        ("TriggIO gun,20\\DOp:=do1,1;", "TriggIO off,5\\Start\\DOp:=do2,0;"),
        ("TriggIO gun,5\\DOp:=do1,1;", "TriggEquip off,60,0.1\\DOp:=do1,0;"),
        ("TriggIO gun,0.1\\Time\\DOp:=do1,1;", "TriggIO off,0.2\\Time\\DOp:=do2,0;"),
    ],
)
def test_outputs_on_the_way_stand_in_their_order_and_the_receipt_says_which_are_elsewhere(rows, target):
    text = module(*rows, *_MOVES, data=_TRIGGERS)
    one, other = read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", target)
    told = translated_at_once(text, "rapid", target).translated.losses
    at_ends = {loss.line for loss in told if loss.part == "order"}
    found = compare_plans(one, other, loose={"order": at_ends})
    assert found.differences == []
    assert found.steps == 6
    # TP has one for each move, KRL as many as are needed; in a corner each counts from its own end.
    assert at_ends & {11, 12} == {11} | ({12} if target in ("inform", "urscript") else set())
    assert not [loss for loss in told if loss.leaves_out and loss.fate is not Fate.EXACT]


def test_an_output_at_the_very_end_is_exact():
    text = module("TriggIO gun,0\\DOp:=do1,1;", "TriggL p1,v100,gun,fine,tool0;", data=_TRIGGERS)
    assert [loss.line for loss in translated_at_once(text, "rapid", "tp").translated.losses] == [8]


@pytest.mark.parametrize(
    "rows",
    [
        ("TriggIO gun,20\\DOp:=do1,x;", "TriggIO off,5\\DOp:=do2,0;"),
        ("TriggIO gun,20\\DOp:=do1,1;", "TriggIO off,5\\DOp:=do2,0;", "TriggIO gun,20\\DOp:=do3,1;"),
        ("TriggIO gun,20\\DOp:=do1,1;", "TriggInt off,5,alarm;"),
        ("TriggIO gun,20\\DOp:=do1,1;", "off:=gun;"),
        ("TriggIO gun,20\\DOp:=do1,1;", "TriggIO off,0.1\\Time\\DOp:=do2,0;"),
        ("TriggIO gun,x\\DOp:=do1,1;", "TriggIO off,5\\DOp:=do2,0;"),
    ],
)
@pytest.mark.parametrize("target", ["krl", "tp"])
def test_a_move_whose_triggers_the_text_does_not_tell_is_refused(rows, target):
    text = module(*rows, _MOVES[1], data=_TRIGGERS)
    told = translated_at_once(text, "rapid", target).translated.losses
    line = text.splitlines().index(_MOVES[1]) + 1
    assert line in {loss.line for loss in told if loss.leaves_out}
