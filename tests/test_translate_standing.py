"""Where a program counts from where the arm stands, the arm stands there."""

from __future__ import annotations

import pytest

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
