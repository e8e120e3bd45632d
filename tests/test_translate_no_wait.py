"""What runs while the arm still moves: kept where the target can say it, and never put behind the move in silence."""

from __future__ import annotations

import pytest
from test_arm_branch import GP25
from translate_programs import Maker
from translated_texts import VENDORS

from olp.ir.expressions import Number, Signal, SignalState
from olp.ir.program import Path, SetOutput
from olp.transpile import Context
from olp.transpile.convert import convert


class Ahead(Maker):
    """A move, one that is not waited for, and a signal that is set meanwhile."""

    def block(self, depth):
        last = self.move(Path.LINEAR, self.point(), no_wait=True)
        signal = SetOutput(0, Signal("out", Number(3)), SignalState(True))
        return [self.move(Path.LINEAR, self.point()), last, signal]


@pytest.mark.parametrize("target", VENDORS)
def test_a_move_that_is_not_waited_for_stays_so_or_the_receipt_names_it(target):
    source = Ahead(4).program()
    made = convert(source, target, Context(robot=GP25, on_loss="comment"), date="2026/01/01 00:00")
    text = "".join(data.decode("latin-1") for data in made.files.values())
    lines = [s.line for s in source.statements() if getattr(s, "no_wait", False)]
    named = [
        line for line in lines if line in {loss.line for loss in made.translated.losses if loss.leaves_out}
    ]
    words = {"inform": "NWAIT", "rapid": "\\Conc,"}
    if target in words:
        assert text.count(words[target]) == len(lines)
    else:
        assert named == lines
