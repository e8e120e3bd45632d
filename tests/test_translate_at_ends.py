"""What a move does at its end is done in the other language, too."""

from __future__ import annotations

import pytest

from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import Call, Move, SetOutput
from olp.transpile import Context
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
