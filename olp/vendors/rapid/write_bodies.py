"""Writes a routine's body: indents, comments, and statements that only together are one instruction."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from olp.diagnostic import Diagnostic, Span, error
from olp.expression import Named, Number, Quantity, SystemValue
from olp.program import (
    Assign,
    Begin,
    Call,
    Case,
    Comment,
    Declare,
    Default,
    Disabled,
    Else,
    ElseIf,
    End,
    EndIf,
    EndSwitch,
    EndWhile,
    For,
    If,
    Label,
    Move,
    Next,
    ObeyFlags,
    Program,
    Routine,
    SetAcceleration,
    SetOverride,
    ShiftOn,
    Statement,
    Switch,
    Wait,
    While,
)
from olp.units import percent
from olp.vendors.rapid.statements import COMPACT
from olp.vendors.rapid.write_moves import MoveWriter
from olp.vendors.rapid.write_positions import CannotSayError
from olp.vendors.rapid.write_statements import StatementWriter

_OPENERS: Final = (If, While, For)
_CLOSERS: Final = (EndIf, EndWhile, Next)
_MIDDLE: Final = (Else, ElseIf)
_LESS_EXACT: Final = (SetAcceleration, SetOverride, ObeyFlags, ShiftOn)  # a Disabled beside them says all
_HANDLER: Final = re.compile(r"(ERROR|UNDO|BACKWARD)\b", re.IGNORECASE)
_HANDLER_OPENS: Final = re.compile(
    r"(?:(?:ELSE)?IF\b.*\bTHEN|ELSE|(?:FOR|WHILE)\b.*\bDO|TEST\b.*)\s*(?:!.*)?", re.IGNORECASE
)
_HANDLER_CLOSES: Final = re.compile(r"(?:ELSE(?:IF)?|END(?:IF|FOR|WHILE|TEST))\b", re.IGNORECASE)
_FORGETS: Final = (If, ElseIf, Else, EndIf, While, EndWhile, For, Next, Case, Default, EndSwitch, Label, Call)
_STEP: Final = "  "
_FULL: Final = 1.0  # the acceleration of moves that name none


class BodyWriter:
    """One routine. `problems` grows by what RAPID cannot say."""

    def __init__(
        self, program: Program, moves: MoveWriter, statements: StatementWriter, problems: list[Diagnostic]
    ) -> None:
        self.program = program
        self.moves = moves
        self.statements = statements
        self.words = statements.words
        self.problems = problems
        self._rows: list[str] = []
        self._depth = 2
        self._rate: float | None = _FULL  # what AccSet has set, None: not known here
        # Where no move names an acceleration, none is ever set.
        self._rated = any(isinstance(s, Move) and s.acceleration is not None for s in program.statements())

    def rows(self, body: Sequence[Statement], routine: Routine, opening: Sequence[str] = ()) -> list[str]:
        """The body's lines with their indent; `opening`: instructions that stand behind its declarations."""
        self._rows, self._depth = [], 2
        self._rate = _FULL if routine.name == self.program.main else None
        self.statements.returns = routine.details.get("returns", "") if self.words.own else ""
        if not self.words.own:
            body = self._declarations_first(body)
        declared = _declarations(body)
        place = 0
        while place < len(body):
            if place >= declared and opening:
                self._rows += [f"{_STEP * self._depth}{row}" for row in opening]
                opening = ()
            place = self._statement(body, place)
        return self._rows

    def _declarations_first(self, body: Sequence[Statement]) -> list[Statement]:
        """RAPID declares before the first instruction: later ones become a declaration there and an assignment."""
        first = next(
            (n for n, one in enumerate(body) if not isinstance(one, (Declare, Comment, Begin))), len(body)
        )
        declared: list[Statement] = []
        rest: list[Statement] = []
        for one in body[first:]:
            if not isinstance(one, Declare):
                rest.append(one)
                continue
            declared.append(replace(one, value=None, storage="variable", comment=""))
            if one.value is not None:
                rest.append(Assign(one.line, Named(one.name), one.value, one.comment))
        return [*body[:first], *declared, *rest]

    def _statement(self, body: Sequence[Statement], place: int) -> int:
        """Writes the statement at `place`, and those that belong to it; returns where the next one is."""
        one = body[place]
        if isinstance(one, (Begin, End)):
            return place + 1
        last = place
        self.words.before.clear()
        try:
            if isinstance(one, If) and one.spelling == COMPACT and self.words.own:
                last = _end_of_compact(body, place)
            if last > place:
                assert isinstance(one, If)
                rows = self._compact(one, body[place + 1 : last])
            else:
                rows, last = self._lines(body, place)
        except CannotSayError as problem:
            self._lose(problem, one.line)
            return last + 1
        rows = [*self.words.before, *rows]
        comment = getattr(body[last], "comment", "") or getattr(one, "comment", "")
        self._write(one, rows, comment)
        return last + 1

    def _lines(self, body: Sequence[Statement], place: int) -> tuple[list[str], int]:
        """The instructions of a statement, and the last statement that they say."""
        one = body[place]
        following = body[place + 1] if place + 1 < len(body) else None
        if isinstance(one, Move):
            return [*self._accelerated(one), self.moves.move(one)], place
        if not self.words.own and isinstance(one, _FORGETS):
            self._rate = None
        together = self.words.own and following is not None and following.line == one.line
        if together and isinstance(one, _LESS_EXACT) and isinstance(following, Disabled):
            return self.statements.lines(following), place + 1
        if isinstance(one, Wait) and isinstance(following, Assign) and following.line == one.line:
            timed = following.value == SystemValue("timed-out")
            if timed:
                return [self.statements.wait(one, following.target)], place + 1
        return self.statements.lines(one), place

    def _accelerated(self, move: Move) -> list[str]:
        """AccSet before a move of another language whose acceleration differs from what holds."""
        if self.words.own:
            return []
        rate = _FULL if move.acceleration is None else move.acceleration.literal
        if rate is None:
            raise CannotSayError("a computed acceleration of one move")
        if rate == self._rate or not self._rated:
            return []
        self._rate = rate
        return [f"AccSet {self.words.scaled(Quantity(Number(rate), 1.0), percent)},100;"]

    def _compact(self, opener: If, inner: Sequence[Statement]) -> list[str]:
        if len(inner) == 1 and isinstance(inner[0], Move):
            text = self.moves.move(inner[0])
        else:
            found, last = self._lines(inner, 0)
            if last != len(inner) - 1 or len(found) != 1:
                # Two statements of one instruction, such as WaitTime \InPos: written as a block.
                rest = [row for one in inner for row in self.statements.lines(one)]
                return [self.statements.if_(opener), *rest, "ENDIF"]
            text = found[0]
        return [f"IF {self.words.condition(opener.condition)} {text}"]

    def _write(self, one: Statement, rows: list[str], comment: str) -> None:
        kind = type(one)
        if isinstance(one, Disabled) and self.words.own:
            self._kept(one)
            return
        compact = isinstance(one, If) and (rows[-1].endswith(";") or rows[-1] == "ENDIF")
        if kind in _CLOSERS or kind in _MIDDLE or kind is EndSwitch or kind is Case or kind is Default:
            self._depth -= 1
        indent = _STEP * max(self._depth - (kind is Label), 1)
        last = len(rows) - 1
        for number, row in enumerate(rows):
            behind = f" !{comment}" if comment and number == last else ""
            self._rows.append(f"{indent}{row}{behind}".rstrip())
        if (
            (kind in _OPENERS and not compact)
            or kind in _MIDDLE
            or kind is Case
            or kind is Default
            or kind is Switch
        ):
            self._depth += 1

    def _kept(self, one: Disabled) -> None:
        """A line of a handler, or an instruction without effect."""
        handler = _HANDLER.match(one.text)
        if handler is not None:
            self._depth = 2
        if _HANDLER_CLOSES.match(one.text):
            self._depth -= 1
        self._rows.append(f"{_STEP * max(self._depth - (handler is not None), 1)}{one.text}")
        if _HANDLER_OPENS.fullmatch(one.text):
            self._depth += 1

    def _lose(self, problem: CannotSayError, line: int) -> None:
        text = self.program.source.line(line)
        span = Span(line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
        message = f"RAPID cannot say this: {problem}"
        self.problems.append(
            error("X002", message, span, file=self.program.path, source_line=text, help=problem.help)
        )


def _declarations(body: Sequence[Statement]) -> int:
    """Where the declarations at a body's beginning end."""
    last = 0
    for place, one in enumerate(body):
        if isinstance(one, Declare):
            last = place + 1
        elif not isinstance(one, (Comment, Begin)):
            break
    return last


def _end_of_compact(body: Sequence[Statement], place: int) -> int:
    """The EndIf of an IF without THEN: in the same line."""
    line = body[place].line
    for index in range(place + 1, min(place + 6, len(body))):
        if body[index].line != line:
            break
        if isinstance(body[index], EndIf):
            return index
    return place
