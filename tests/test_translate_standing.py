"""Where a program counts from where the arm stands, the arm stands there."""

from __future__ import annotations

import pytest
from translated_texts import krl, translated

from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import Move
from olp.transpile import Context
from olp.transpile.convert import convert

HEAD = "DEF p ( )\nE6POS here\n$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\n$VEL.CP=0.5\n$APO.CDIS=50\n"
POINT = "LIN {X 1000,Y %d,Z 1200,A 0,B 90,C 0} C_DIS\n"
RELATIVE = HEAD + POINT % 0 + POINT % 400 + "$OUT[1]=TRUE\nLIN_REL {Z -30}\nEND\n"
ON_THE_WAY = HEAD + POINT % 0 + POINT % 400 + "LIN_REL {Z -30}\nEND\n"
READ = HEAD + POINT % 0 + POINT % 400 + "here=$POS_ACT\nhere.Z=here.Z+50\nLIN here\nEND\n"
BRANCH = HEAD + POINT % 0 + "IF $IN[1] THEN\n" + POINT % 400 + "ENDIF\nLIN_REL {Z -30}\nEND\n"
FIRST = HEAD + "here=$POS_ACT\nhere.Z=here.Z+50\nLIN here\n" + POINT % 400 + POINT % 0 + "END\n"


def converted(text, target):
    made = convert(
        read_source(decode(text.encode(), "p"), vendor="krl"),
        target,
        Context(on_loss="comment"),
        date="2026/01/01 00:00",
    )
    moves = [
        s
        for s in read_source(decode(made.files[made.main], made.main), vendor=target).statements()
        if isinstance(s, Move)
    ]
    losses = [(loss.line, loss.part) for loss in made.translated.losses]
    return moves, losses


def passes_by(move):
    return move.blend is not None and move.blend.value is not None and (move.blend.value.literal or 0) > 0


@pytest.mark.parametrize("target", ["rapid", "urscript"])
@pytest.mark.parametrize("text", [RELATIVE, READ])
def test_the_move_before_stops_and_the_receipt_says_so(text, target):
    moves, losses = converted(text, target)
    assert [passes_by(move) for move in moves] == [True, False, False]
    assert (7, "blend") not in losses


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_a_relative_move_that_the_target_has_itself_needs_no_stop(target):
    moves, _ = converted(ON_THE_WAY, target)
    assert moves[1].blend == moves[0].blend


def test_where_the_way_there_is_open_the_receipt_asks_to_see_to_it():
    assert (11, "position") in converted(BRANCH, "rapid")[1]


def test_what_a_program_begins_with_needs_no_stop():
    assert not [line for line, part in converted(FIRST, "rapid")[1] if part == "position"]


@pytest.mark.parametrize(
    ("target", "word"), [("rapid", "WaitRob"), ("tp", "WAIT 0(sec)"), ("urscript", "sleep(0)")]
)
def test_the_arm_is_waited_for_only_where_it_may_still_move(target, word):
    """A statement that only waits for the arm stood behind exact stops, too."""
    line = "LIN {X %d,Y 0,Z 400,A 0,B 90,C 0}"
    stopped = (
        "$VEL.CP=0.2",
        line % 900,
        "WAIT SEC 0",
        "PART2()",
        "WAIT SEC 0",
        "IF $IN[1] THEN",
        line % 910,
        "ENDIF",
    )
    called = "DEF PART2()\r\nWAIT SEC 0\r\nEND\r\n"
    assert word not in translated(krl(*stopped, "WAIT SEC 0") + called, "krl", target)
    rounded = ("$APO.CDIS=5", *stopped[:-2], f"{line % 910} C_DIS", "ENDIF", "X=1", "WAIT SEC 0")
    text = "DEF PART ( )\r\nDECL INT X\r\n" + "\r\n".join(rounded) + "\r\nEND\r\n" + called
    assert translated(text, "krl", target).count(word) == 1


def test_a_routine_that_an_interrupt_calls_waits_for_the_arm():
    """It begins while the arm moves: no move stands before it in the text."""
    rows = (
        "INTERRUPT DECL 4 WHEN $IN[5]==TRUE DO HALTED()", "INTERRUPT ON 4", "$VEL.CP=0.2",
        "$APO.CDIS=5",
        "LIN {X 900,Y 0,Z 400,A 0,B 90,C 0} C_DIS", "LIN {X 950,Y 0,Z 400,A 0,B 90,C 0}",
    )  # fmt: skip
    text = krl(*rows) + "DEF HALTED()\r\nWAIT SEC 0\r\n$OUT[1]=TRUE\r\nEND\r\n"
    assert "WaitRob" in translated(text, "krl", "rapid")
