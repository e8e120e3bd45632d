"""What translations from and into INFORM, and from AS, VAL3 and PDL2, once did otherwise than their sources."""

from __future__ import annotations

import pytest
from translated_texts import ROBOT, converted, inform, module, read, translated

from olp.transpile import Context
from olp.transpile.convert import convert, runs_of
from olp.transpile.link import link
from olp.transpile.receipt import receipt_of

POINTS = (
    "///TOOL 0",
    "///POSTYPE ROBOT",
    "///RECTAN",
    "///RCONF 1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0",
    "P001=900.000,0.000,400.000,180.0000,0.0000,0.0000",
    "P002=900.000,100.000,400.000,180.0000,0.0000,0.0000",
)


def objections(text, vendor, target):
    """What stands against the proof, by kind; the translation is as `olp convert` makes it."""
    program = read(text, vendor)
    made = convert(program, target, Context(robot=ROBOT, on_loss="comment", forms=True))
    runs = runs_of(program, made, target, (ROBOT, None))
    receipt = receipt_of(link(program), made.translated, target, tuple(made.files), runs, (ROBOT, None))
    return {(one.kind, one.says) for one in receipt.verdict.objections}


def test_the_stop_handlers_of_inline_forms_take_no_place_in_the_pairs_of_statements():
    rows = ("MOVJ C001 VJ=20.00", "WAIT B001=1", "MOVJ C002 VJ=40.00", "DOUT OT#(1) ON")
    taught = [row.replace("P00", "C00") for row in POINTS]
    text = inform(*rows, points=taught).replace("NPOS 0,0,0,0", "NPOS 2,0,0,0")
    assert {kind for kind, _ in objections(text, "inform", "krl")} <= {"named"}


@pytest.mark.parametrize(
    ("target", "taken"),
    [("tp", ("R[1:n]=AR[1]", "=AR[2]")), ("inform", ("GETARG R000 IARG#(1)", "GETARG S000 IARG#(2)"))],
)
def test_what_the_first_routine_takes_comes_from_its_caller(target, taken):
    text = module().replace("PROC main()", "PROC part(num n,string t)\r\nIF n=2 SetDO do1,1;\r\nTPWrite t;")
    made = translated(text, "rapid", target)
    assert all(one in made for one in taken), made
    assert not objections(text, "rapid", target)


def test_what_the_caller_does_not_get_back_is_told():
    losses = converted("DEF PART(N:OUT)\r\nINT N\r\nN=N+1\r\nEND\r\n", "krl", "tp").translated.losses
    assert [one.says for one in losses] == ["the argument N of PART: its caller does not get it back"]
    text = module().replace("PROC main()", "PROC part(robtarget p)\r\nMoveJ p,v100,fine,tool0;")
    says = [one.says for one in converted(text, "rapid", "tp").translated.losses]
    assert "the argument p of part: its caller has to set the variable" in says
