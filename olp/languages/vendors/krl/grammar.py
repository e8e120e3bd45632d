"""The KRL parser: built once per process from grammars/krl.lark, shared by all reads."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

from lark import Token

from olp.ir.expressions import (
    Binary,
    Expression,
    Named,
    Number,
    Quantity,
    Signal,
    SignalState,
    Text,
    Unary,
)
from olp.ir.program import (
    Assign,
    Break,
    Call,
    Case,
    Default,
    Dwell,
    Else,
    ElseIf,
    EndIf,
    EndSwitch,
    EndWhile,
    For,
    If,
    Jump,
    Label,
    Message,
    Next,
    Pause,
    PulseOutput,
    Repeat,
    Return,
    SetOutput,
    Switch,
    Until,
    Wait,
    While,
)
from olp.languages.lark_host import BrokenLineError, Grammar
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

TRUE = SignalState(True)


class StatementRules(DeclarationRules):
    def start(self, children: list[Any]) -> Any:
        return children[0]

    # --- values and outputs -----------------------------------------------------------------------------

    def assignment(self, children: list[Any]) -> Assign | SetOutput:
        reference, value = children
        target = self.lower(reference)
        value = settle(value, self.scope, self.scope.type_of(target))
        if isinstance(target, (Binary, Unary)):
            return _clock(target, value)
        return SetOutput(0, target, value) if type(target) is Signal else Assign(0, target, value)

    def pulse(self, children: list[Any]) -> PulseOutput:
        signal, state, time = children
        if type(signal) is Named:
            signal = Signal("out", Text(signal.name))  # named in a list that is not here
        if type(signal) is not Signal or signal.bus == "in":
            raise BrokenLineError(
                "PULSE switches an output", word="PULSE", wanted="PULSE ($OUT[1], TRUE, 0.5)"
            )
        spelling = "" if state == TRUE else "FALSE"
        condition = None if state == TRUE or state == SignalState(False) else state
        return PulseOutput(0, signal, Quantity(self.plain(time), 1.0), condition, spelling=spelling)

    def call(self, children: list[Any]) -> Call | Message:
        name, arguments = children
        if name.upper() == "MSGNOTIFY" and len(arguments) == 1:
            return Message(0, arguments[0])
        return Call(0, self.scope.spell(name), arguments)

    # --- blocks -----------------------------------------------------------------------------------------

    def if_(self, children: list[Any]) -> If:
        return If(0, self.plain(children[0]))

    def else_if(self, children: list[Any]) -> ElseIf:
        return ElseIf(0, self.plain(children[0]))

    def else_(self, _: list[Any]) -> Else:
        return Else(0)

    def end_if(self, _: list[Any]) -> EndIf:
        return EndIf(0)

    def while_(self, children: list[Any]) -> While:
        return While(0, self.plain(children[0]))

    def end_while(self, _: list[Any]) -> EndWhile:
        return EndWhile(0)

    def loop(self, _: list[Any]) -> While:
        return While(0, TRUE, spelling="LOOP")

    def end_loop(self, _: list[Any]) -> EndWhile:
        return EndWhile(0)

    def for_(self, children: list[Any]) -> For:
        reference, start, stop, step = children
        variable = self.lower(reference)
        if not isinstance(variable, Named):
            raise BrokenLineError("FOR counts a variable", word=reference.name, wanted="FOR I=1 TO 6")
        return For(0, variable, self.plain(start), self.plain(stop), step and self.plain(step))

    def end_for(self, _: list[Any]) -> Next:
        return Next(0, None)

    def repeat(self, _: list[Any]) -> Repeat:
        return Repeat(0)

    def until(self, children: list[Any]) -> Until:
        return Until(0, self.plain(children[0]))

    def switch(self, children: list[Any]) -> Switch:
        return Switch(0, self.plain(children[0]))

    def case(self, children: list[Expression]) -> Case:
        return Case(0, tuple(map(self.plain, children)))

    def default(self, _: list[Any]) -> Default:
        return Default(0)

    def end_switch(self, _: list[Any]) -> EndSwitch:
        return EndSwitch(0)

    def exit(self, _: list[Any]) -> Break:
        return Break(0)

    # --- jumps and waits --------------------------------------------------------------------------------

    def label(self, children: list[Token]) -> Label:
        return Label(0, self.scope.spell(children[0]))

    def goto(self, children: list[Token]) -> Jump:
        return Jump(0, self.scope.spell(children[0]))

    def return_(self, children: list[Any]) -> Return:
        return Return(0, self.plain(children[0]) if children else None)

    def halt(self, _: list[Any]) -> Pause:
        return Pause(0)

    def wait(self, children: list[Any]) -> Wait:
        return Wait(0, self.plain(children[0]))

    def dwell(self, children: list[Any]) -> Dwell:
        return Dwell(0, Quantity(self.plain(children[0]), 1.0))


def _clock(target: Binary | Unary, value: Expression) -> Assign:
    """`$TIMER[1]=0`, in ms, and `$TIMER_STOP[1]=FALSE`."""
    if isinstance(target, Unary):
        on = SignalState(not value.on) if isinstance(value, SignalState) else Unary("not", value)
        return Assign(0, target.operand, on)
    if isinstance(value, Number):
        seconds = value.value / 1000
        return Assign(0, target.left, Number(int(seconds) if seconds.is_integer() else seconds))
    return Assign(0, target.left, Binary("/", value, target.right))
