"""The KRL parser: built once per process from grammars/krl.lark, shared by all reads."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

from lark import Token

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.languages.lark_host import BrokenLineError, Grammar
from olp.languages.statement_rules import BlockWords
from olp.languages.vendors.krl.declarations import DeclarationRules
from olp.languages.vendors.krl.scope import Scope
from olp.languages.vendors.krl.values import settle


class KrlLine(NamedTuple):
    """One line. `result`: a statement, or declarations, a head, a tail, a spline block's border."""

    result: Any
    mixed: bool  # comparisons stand beside AND or OR without parentheses


class KrlParser(Grammar):
    """Parses one line at a time."""

    def __init__(self) -> None:
        super().__init__("krl", StatementRules(), ("start",))

    def parse_line(self, line: str, scope: Scope) -> KrlLine:
        """Raises lark's UnexpectedInput, or BrokenLineError."""
        return KrlLine(*self.parse(line, then=("mixed",), scope=scope, mixed=False))


@cache
def line_parser() -> KrlParser:
    """The one parser of this process."""
    return KrlParser()


# --- Statements ---
# Lowers control flow, waits, calls, assignments and outputs: one short method per rule.

TRUE = ex.SignalState(True)


class StatementRules(DeclarationRules, BlockWords):
    def start(self, children: list[Any]) -> Any:
        return children[0]

    # --- values and outputs -----------------------------------------------------------------------------

    def assignment(self, children: list[Any]) -> st.Assign | st.SetOutput:
        reference, value = children
        target = self.lower(reference)
        value = settle(value, self.scope, self.scope.type_of(target))
        if isinstance(target, (ex.Binary, ex.Unary)):
            return clock_set(target, value)
        if isinstance(target, ex.Compare) and isinstance(target.left, ex.SystemValue):
            # Written, a flag is no condition: `$TIMER_FLAG[1]=FALSE`.
            target = ex.Signal("timer-flag", ex.Number(target.left.index))
        return st.SetOutput(0, target, value) if type(target) is ex.Signal else st.Assign(0, target, value)

    def pulse(self, children: list[Any]) -> st.PulseOutput:
        signal, state, time = children
        if type(signal) is ex.Named:
            signal = ex.Signal("out", ex.Text(signal.name))  # named in a list that is not here
        if type(signal) is not ex.Signal or signal.bus == "in":
            raise BrokenLineError(
                "PULSE switches an output", word="PULSE", wanted="PULSE ($OUT[1], TRUE, 0.5)"
            )
        spelling = "" if state == TRUE else "FALSE"
        condition = None if state == TRUE or state == ex.SignalState(False) else state
        return st.PulseOutput(0, signal, ex.Quantity(self.plain(time), 1.0), condition, spelling=spelling)

    def call(self, children: list[Any]) -> st.Call | st.Message:
        name, arguments = children
        if name.upper() == "MSGNOTIFY" and len(arguments) == 1:
            return st.Message(0, arguments[0])
        return st.Call(0, self.scope.spell(name), arguments)

    # --- blocks -----------------------------------------------------------------------------------------

    def loop(self, _: list[Any]) -> st.While:
        return st.While(0, TRUE, spelling="LOOP")

    def for_(self, children: list[Any]) -> st.For:
        reference, start, stop, step = children
        variable = self.lower(reference)
        if not isinstance(variable, ex.Named):
            raise BrokenLineError("FOR counts a variable", word=reference.name, wanted="FOR I=1 TO 6")
        return st.For(0, variable, self.plain(start), self.plain(stop), step and self.plain(step))

    # --- jumps and waits --------------------------------------------------------------------------------

    def label(self, children: list[Token]) -> st.Label:
        return st.Label(0, self.scope.spell(children[0]))

    def goto(self, children: list[Token]) -> st.Jump:
        return st.Jump(0, self.scope.spell(children[0]))

    def return_(self, children: list[Any]) -> st.Return:
        return st.Return(0, self.plain(children[0]) if children else None)

    def dwell(self, children: list[Any]) -> st.Dwell:
        """Of less than no time is none at all; it keeps the advance run, as every WAIT SEC."""
        time = self.plain(children[0])
        if isinstance(time, ex.Number) and time.value < 0:
            time = ex.Number(0)
        return st.Dwell(0, ex.Quantity(time, 1.0))


def clock_set(target: ex.Binary | ex.Unary, value: ex.Expression) -> st.Assign:
    """`$TIMER[1]=0`, in ms, and `$TIMER_STOP[1]=FALSE`."""
    if isinstance(target, ex.Unary):
        on = ex.SignalState(not value.on) if isinstance(value, ex.SignalState) else ex.Unary("not", value)
        return st.Assign(0, target.operand, on)
    if isinstance(value, ex.Number):
        seconds = value.value / 1000
        return st.Assign(0, target.left, ex.Number(int(seconds) if seconds.is_integer() else seconds))
    return st.Assign(0, target.left, ex.Binary("/", value, target.right))
