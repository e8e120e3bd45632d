"""Lowers control flow, tasks, messages and process instructions: one short method per rule."""

from __future__ import annotations

from typing import Any, NamedTuple

from lark import Token

from olp.ir.expressions import Expression, SignalState, Text, Unknown, Variable
from olp.ir.program import (
    Begin,
    Call,
    Case,
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
    Jump,
    Label,
    Message,
    Next,
    Pause,
    Process,
    PulseOutput,
    Return,
    StartTask,
    Switch,
    Synchronise,
    WaitTask,
    While,
)
from olp.languages.vendors.inform import values
from olp.languages.vendors.inform.expressions import InformRemark
from olp.languages.vendors.inform.moves import InformMoveRules
from olp.languages.vendors.inform.names import unmangle


class Suffix(NamedTuple):
    """`IF …` or `IFEXPRESS …` behind an instruction."""

    word: str
    condition: Expression


class SwitchAndCase(NamedTuple):
    """`SWITCH a CASE 1` on one line: two statements."""

    switch: Switch
    case: Case


_NO_SUFFIX = Suffix("", None)  # type: ignore[arg-type]


def _suffix(children: list[Any]) -> tuple[list[Any], Suffix]:
    """The children before the suffix, and the suffix or an empty one."""
    if children and type(children[-1]) is Suffix:
        return children[:-1], children[-1]
    return children, _NO_SUFFIX


class FlowRules(InformMoveRules):
    def suffix(self, children: list[Any]) -> Suffix:
        return Suffix(str(children[0]), children[1])

    def label(self, children: list[Token]) -> Label:
        return Label(0, children[0][1:])

    def jump(self, children: list[Any]) -> Jump:
        (word, *_, target), suffix = _suffix(children)
        if word == "JMP":
            self.remarks.append(InformRemark("P036", "JMP", word.column or 1))
        name = target[1:] if type(target) is Token else target
        return Jump(0, name, suffix.condition, spelling=suffix.word)

    def call(self, children: list[Any]) -> Call:
        (word, job, *arguments), suffix = _suffix(children)
        jump = word == "JUMP"
        name = unmangle(job[4:].strip())
        return Call(0, name, tuple(arguments), suffix.condition, jump=jump, spelling=suffix.word)

    def macro(self, children: list[Any]) -> Call:
        (_, number, *arguments), suffix = _suffix(children)
        return Call(0, "", tuple(arguments), suffix.condition, macro=number, spelling=suffix.word)

    def return_(self, children: list[Any]) -> Return:
        value, suffix = _suffix(children)
        return Return(0, value[0] if value else None, suffix.condition, spelling=suffix.word)

    def if_(self, children: list[Any]) -> If:
        return If(0, children[1], spelling=str(children[0]))

    def else_if(self, children: list[Any]) -> ElseIf:
        return ElseIf(0, children[1], spelling=str(children[0]))

    def else_(self, _: list[Any]) -> Else:
        return Else(0)

    def end_if(self, _: list[Any]) -> EndIf:
        return EndIf(0)

    def while_(self, children: list[Any]) -> While:
        return While(0, children[1], spelling=str(children[0]))

    def end_while(self, _: list[Any]) -> EndWhile:
        return EndWhile(0)

    def for_(self, children: list[Any]) -> For:
        variable, _, start, _, stop, *step = children
        return For(0, variable, start, stop, step[1] if step else None)

    def next_(self, children: list[Variable]) -> Next:
        return Next(0, children[0] if children else None)

    def switch(self, children: list[Any]) -> Switch | SwitchAndCase:
        value, *case = children
        return SwitchAndCase(Switch(0, value), self.case(case)) if case else Switch(0, value)

    def case(self, children: list[Any]) -> Case:
        return Case(0, tuple(children[1:]))

    def default(self, _: list[Any]) -> Default:
        return Default(0)

    def end_switch(self, _: list[Any]) -> EndSwitch:
        return EndSwitch(0)

    def begin(self, _: list[Any]) -> Begin:
        return Begin(0)

    def end(self, _: list[Any]) -> End:
        return End(0)

    def disabled(self, children: list[Token]) -> Disabled:
        return Disabled(0, unmangle(children[0].strip()))

    def pulse(self, children: list[Any]) -> PulseOutput:
        (signal, duration), suffix = _suffix(children)
        return PulseOutput(0, signal, duration, suffix.condition, spelling=suffix.word)

    # --- operator, tasks, process -----------------------------------------------------------------------

    def pause(self, children: list[Any]) -> Pause:
        _, suffix = _suffix(children)
        return Pause(0, suffix.condition, spelling=suffix.word)

    def start_task(self, children: list[Any]) -> StartTask:
        (job, task, *sync), suffix = _suffix(children)
        name = unmangle(job[4:].strip())
        return StartTask(0, name, str(task), suffix.condition, spelling=suffix.word, synchronised=bool(sync))

    def wait_task(self, children: list[Token]) -> WaitTask:
        return WaitTask(0, str(children[0]))

    def synchronise(self, children: list[Any]) -> Synchronise:
        return Synchronise(0, children[0], children[2] if len(children) > 1 else None)

    def message(self, children: list[Expression]) -> Message:
        return Message(0, children[0])

    def process(self, children: list[Any]) -> Process:
        return Process(0, str(children[0]), tuple(children[1:]))

    def tagged(self, children: list[Any]) -> tuple[str, Expression]:
        return str(children[0]).removesuffix("="), children[1]

    def word(self, children: list[Token]) -> tuple[str, Expression]:
        word = unmangle(str(children[0]))
        known = self.aliases.get(word)
        if known is not None:
            self.named_any = True
            return "", known
        return "", Unknown(word)

    def positional(self, children: list[Expression]) -> tuple[str, Expression]:
        return "", children[0]

    def positional_number(self, children: list[Token]) -> tuple[str, Expression]:
        return "", values.number(children[0])

    def positional_text(self, children: list[Token]) -> tuple[str, Expression]:
        return "", Text(children[0][1:-1])

    def positional_taught(self, children: list[Token]) -> tuple[str, Expression]:
        return "", values.taught(children[0])

    def positional_state(self, children: list[Token]) -> tuple[str, Expression]:
        return "", SignalState(children[0] == "ON")
