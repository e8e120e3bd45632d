"""Loops that do nothing but wait: what they wait for, and for how long at most."""

from __future__ import annotations

from typing import Final

from olp.ir.expressions import Compare, Expression, Quantity, SignalState, Unary
from olp.ir.program import Wait
from olp.languages.vendors.urscript import helpers
from olp.languages.vendors.urscript.calls import is_step
from olp.languages.vendors.urscript.expressions import Expressions
from olp.languages.vendors.urscript.folding import fold
from olp.languages.vendors.urscript.lines import UrscriptLine
from olp.languages.vendors.urscript.outline import UrscriptPart
from olp.languages.vendors.urscript.syntax import (
    Assignment,
    Closing,
    Evaluation,
    Invocation,
    Opening,
    Simple,
    UrscriptName,
    UrscriptPair,
)

_INVERTED: Final = {"=": "<>", "<>": "=", "<": ">=", ">": "<=", "<=": ">", ">=": "<"}
_COUNTER: Final = UrscriptName(helpers.COUNTER)


class Waits:
    """Finds the waits of one part."""

    def __init__(self, part: UrscriptPart, expressions: Expressions) -> None:
        self._part = part
        self._expressions = expressions

    def at(self, index: int, line: UrscriptLine) -> tuple[Wait, int] | None:
        """The wait that begins here, and how many lines it has; None when the lines do more than wait."""
        if _is_count(line.content):
            return self._timed(index, line)
        return self._wait(index, line)

    def _wait(self, index: int, line: UrscriptLine) -> tuple[Wait, int] | None:
        lines = self._part.lines
        opening = lines[index][0].content
        if type(opening) is not Opening or opening.word != "while" or opening.condition is None:
            return None
        condition = self._expressions.lower(opening.condition)
        if type(condition) is SignalState:
            return None
        if opening.closed:
            idle: object = opening.rest
            count = 1
        else:
            idle = None if opening.rest is not None else self._inside(index, 1)
            count = 3
        if not isinstance(idle, Evaluation) or not _is_idle(idle):
            return None
        assert isinstance(idle.value, Invocation)  # a call of sync or sleep
        spelling = "sleep" if idle.value.arguments else ""
        return Wait(line.number, inverted(condition), comment=line.comment, spelling=spelling), count

    def _inside(self, index: int, count: int) -> object:
        """The first of `count` instructions in the block that `index` opens, None unless it holds just as many."""
        lines = self._part.lines
        if index + count + 1 >= len(lines):
            return None
        closing, outside = lines[index + count + 1]
        depth = lines[index][1]
        if type(closing.content) is not Closing or closing.comment or outside != depth:
            return None
        inside = lines[index + 1 : index + count + 1]
        if any(line.comment or place != depth + 1 for line, place in inside):
            return None
        return inside[0][0].content

    def _timed(self, index: int, line: UrscriptLine) -> tuple[Wait, int] | None:
        """A wait that gives up, as olp writes it: a counter runs down beside the condition."""
        lines = self._part.lines
        if index + 4 >= len(lines):
            return None
        start, opening, last = (lines[index + n][0].content for n in (0, 1, 3))
        idle = self._inside(index + 1, 2)
        if type(opening) is not Opening or opening.word != "while" or opening.rest is not None:
            return None
        if not isinstance(idle, Evaluation) or not _is_idle(idle) or not _is_count(last):
            return None
        match opening.condition:
            case UrscriptPair("and", UrscriptPair(">", UrscriptName(helpers.COUNTER), _), condition):
                assert isinstance(start, Assignment)  # `_is_count` has seen it
                timeout = Quantity(fold(self._expressions.lower(start.value)), 1.0)
                waited = inverted(self._expressions.lower(condition))
                return Wait(line.number, waited, timeout, line.comment), 5
        return None


def inverted(condition: Expression) -> Expression:
    """What holds when the condition does not; twice inverted it is what it was."""
    if type(condition) is Compare:
        if type(condition.right) is SignalState and condition.operator in ("=", "<>"):
            return Compare(condition.operator, condition.left, SignalState(not condition.right.on))
        return Compare(_INVERTED[condition.operator], condition.left, condition.right)
    if type(condition) is Unary and condition.operator == "not":
        return condition.operand
    return Unary("not", condition)


def _is_count(content: object) -> bool:
    """Whether the counter of a wait gets a value."""
    return isinstance(content, Assignment) and content.target == _COUNTER


def _is_idle(simple: Simple) -> bool:
    """sync() or sleep(get_steptime())."""
    if type(simple) is not Evaluation or type(simple.value) is not Invocation:
        return False
    call = simple.value
    if call.function == UrscriptName("sync") and not call.arguments:
        return True
    return (
        call.function == UrscriptName("sleep")
        and len(call.arguments) == 1
        and is_step(call.arguments[0].value)
    )
