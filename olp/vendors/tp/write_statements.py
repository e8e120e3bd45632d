"""Spells every statement that is no motion: one short function per type, the way back of `statements`.

Each gives the lines of one statement, without numbers and semicolons.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from olp import called
from olp.expression import (
    Binary,
    Compare,
    Expression,
    FrameRef,
    Function,
    Logic,
    Named,
    Number,
    PositionLiteral,
    State,
    Store,
    Text,
    Unary,
    Variable,
)
from olp.program import (
    Assign,
    Begin,
    Call,
    Clear,
    Comment,
    Declare,
    Disabled,
    Dwell,
    Else,
    End,
    For,
    If,
    Jump,
    Message,
    Next,
    Opaque,
    Pause,
    Process,
    PulseOutput,
    ReadInput,
    Return,
    SetFrame,
    SetOutput,
    SetOverride,
    SetTool,
    StartTask,
    Statement,
    Update,
    Wait,
)
from olp.vendors.tp import values
from olp.vendors.tp.limits import COMMENT_LENGTH
from olp.vendors.tp.write_moves import MoveWriter
from olp.vendors.tp.write_poses import added_lines, component_lines, components, is_position, shift_of
from olp.vendors.tp.write_values import CannotSayError, Words

_BOOLEAN = (Compare, Logic, Unary)
_LINE_ENDS: Final = frozenset("\r\n")


class StatementWriter:
    """Spells the statements of one program. `labels`: the number of a label by its name."""

    def __init__(self, words: Words, moves: MoveWriter, labels: Callable[[str], str], own: bool) -> None:
        self.words = words
        self.moves = moves
        self.labels = labels
        self.own = own

    def lines(self, statement: Statement) -> list[str]:
        """Raises CannotSayError."""
        spell = _SPELLINGS.get(type(statement))
        if spell is None:
            raise CannotSayError(called.statement(statement))
        return spell(self, statement)

    def _only_own(self, statement: Statement) -> None:
        if not self.own:
            raise CannotSayError(f"a word of another language: {called.statement(statement)}")

    # --- values -----------------------------------------------------------------------------------------

    def assign(self, s: Assign) -> list[str]:
        target, value = s.target, s.value
        if isinstance(target, FrameRef):
            return self._frame(target, value)
        if (
            isinstance(target, Variable)
            and target.store is Store.ROBOT
            and isinstance(value, PositionLiteral)
        ):
            return self._position(target, value)
        if isinstance(target, Variable) and target.store is Store.ROBOT and isinstance(value, Function):
            return self._computed(target, value)
        text = self.words.value(target)
        if isinstance(target, Variable) and target.store is Store.REAL:
            if isinstance(value, State):
                return [f"{text}={int(value.on)}"]
            if isinstance(value, _BOOLEAN) and not (isinstance(value, Unary) and value.operator == "-"):
                return [
                    f"IF ({self.words.expression(value)}) THEN",
                    f"{text}=1",
                    "ELSE",
                    f"{text}=0",
                    "ENDIF",
                ]
        if isinstance(target, Named) and not isinstance(value, (Number, Variable)):
            return [f"{text}=({self.words.expression(value)})"]
        return [f"{text}={self.words.assigned(value)}"]

    def _frame(self, target: FrameRef, value: Expression) -> list[str]:
        text = self.words.frame(target)
        if isinstance(value, Variable):
            return [f"{text}={self.words.variable(value)}"]
        if isinstance(value, PositionLiteral):
            register = self.moves.scratch.register()
            return [*self.moves.literal_lines(register, value), f"{text}=PR[{register}]"]
        raise CannotSayError("a computed frame", "compute it into a position register first")

    def _position(self, target: Variable, value: PositionLiteral) -> list[str]:
        plain = value.kind == "pose" and not value.configuration and not value.external
        if plain and not any(component != component for component in value.values):
            return self.moves.literal_lines(self.words.index(target.index), value)
        number = self.moves.positions.literal(value, None, None)
        return [f"{self.words.variable(target)}=P[{number}]"]

    def _computed(self, target: Variable, value: Function) -> list[str]:
        """A position register that is computed: component by component."""
        index = self.words.index(target.index)
        parts = components(value)
        if parts is not None:
            return component_lines(self.words, index, parts)
        shift = shift_of(value)
        if shift is None or not is_position(shift[0]):
            raise CannotSayError(called.function(value.name))
        start, by = shift
        first = self.assign(Assign(0, target, start)) if start != target else []
        return [*first, *added_lines(self.words, index, by)]

    def update(self, s: Update) -> list[str]:
        if s.operator not in ("+", "-", "*", "/") or s.operand is None:
            raise CannotSayError(called.operation(s.operator))
        return [
            f"{self.words.value(s.target)}={self.words.assigned(Binary(s.operator, s.target, s.operand))}"
        ]

    def clear(self, s: Clear) -> list[str]:
        if isinstance(s.target, Variable) and s.target.store is Store.REAL and s.count in (None, Number(1)):
            return [f"{self.words.variable(s.target)}=0"]
        raise CannotSayError("clearing several variables at once")

    def declare(self, s: Declare) -> list[str]:
        if s.name == values.TIMEOUT:
            return []
        raise CannotSayError(f"the variable {s.name} by its name", "give it a register")

    # --- signals and time -------------------------------------------------------------------------------

    def set_output(self, s: SetOutput) -> list[str]:
        text, value = self.words.signal(s.signal), s.value
        if s.signal.bus in ("flag", "marker"):
            return [f"{text}=({self.words.expression(value)})"]
        if isinstance(value, (State, Number, Variable)):
            return [f"{text}={self.words.value(value)}"]
        return [f"{text}=({self.words.expression(value)})"]

    def pulse(self, s: PulseOutput) -> list[str]:
        time = "" if s.duration is None else f",{self.words.quantity(s.duration, 1.0)}sec"
        return self._under(s.condition, f"{self.words.signal(s.signal)}=PULSE{time}")

    def read_input(self, s: ReadInput) -> list[str]:
        return [f"{self.words.value(s.target)}={self.words.signal(s.signal)}"]

    def dwell(self, s: Dwell) -> list[str]:
        text = self.words.quantity(s.duration, 1.0)
        return [f"WAIT {text}(sec)" if isinstance(s.duration.written, Number) else f"WAIT {text}"]

    def wait(self, s: Wait) -> list[str]:
        return [f"WAIT {self.words.condition(s.condition)}"]

    # --- control flow -----------------------------------------------------------------------------------

    def jump(self, s: Jump) -> list[str]:
        target = self.labels(s.target) if isinstance(s.target, str) else self.words.index(s.target)
        return self._under(s.condition, f"JMP LBL[{target}]")

    def call(self, s: Call) -> list[str]:
        if s.macro is not None or s.result is not None:
            raise CannotSayError(
                "a macro by its number" if s.macro is not None else "the value that a routine returns"
            )
        arguments = ",".join(self._call_argument(one) for one in s.arguments)
        routine = s.routine if self.own else s.routine.upper()
        word = routine if s.spelling == "macro" and self.own else f"CALL {routine}"
        call = f"{word}({arguments})" if s.arguments else word
        if not s.jump:
            return self._under(s.condition, call)
        if s.condition is None:
            return [call, "END"]
        return [f"IF {self.words.condition(s.condition, True)} THEN", call, "END", "ENDIF"]

    def _call_argument(self, it: Expression) -> str:
        if isinstance(it, State):
            return str(int(it.on))
        return self.words.value(it)

    def return_(self, s: Return) -> list[str]:
        if s.value is not None:
            raise CannotSayError("a value that a routine returns")
        return ["END"] if s.condition is None else self._under(s.condition, "END")

    def if_(self, s: If) -> list[str]:
        return [f"IF {self.words.condition(s.condition, True)} THEN"]

    def for_(self, s: For) -> list[str]:
        step = s.step.value if isinstance(s.step, Number) else None
        if s.step is not None and step not in (1, -1):
            raise CannotSayError("a loop whose step is not 1 or -1")
        if not isinstance(s.variable, Variable) or s.variable.store is not Store.REAL:
            raise CannotSayError("a loop that counts something else than a register")
        word = "DOWNTO" if step == -1 else "TO"
        return [
            f"FOR {self.words.value(s.variable)}={self.words.value(s.start)} {word} {self.words.value(s.stop)}"
        ]

    def pause(self, s: Pause) -> list[str]:
        return self._under(s.condition, "PAUSE")

    def start_task(self, s: StartTask) -> list[str]:
        return self._under(s.condition, f"RUN {s.routine if self.own else s.routine.upper()}")

    def _under(self, condition: Expression | None, text: str) -> list[str]:
        return [text] if condition is None else [f"IF {self.words.condition(condition)},{text}"]

    # --- frames, process, text --------------------------------------------------------------------------

    def set_tool(self, s: SetTool) -> list[str]:
        return [self.moves.select_tool(s.tool)]

    def set_frame(self, s: SetFrame) -> list[str]:
        return [self.moves.select_frame(s.frame)]

    def set_override(self, s: SetOverride) -> list[str]:
        text = self.words.quantity(s.share, values.PERCENT)
        return [f"OVERRIDE={text}%" if isinstance(s.share.written, Number) else f"OVERRIDE={text}"]

    def message(self, s: Message) -> list[str]:
        if not isinstance(s.text, Text):
            raise CannotSayError("a message that is computed")
        if not _LINE_ENDS.isdisjoint(s.text.value):
            raise CannotSayError("a message of several lines")
        return [f"MESSAGE[{s.text.value}]"]

    def process(self, s: Process) -> list[str]:
        self._only_own(s)
        arguments = [value for _, value in s.arguments]
        if s.name == "TIMER":
            timer, word = arguments
            assert isinstance(word, Text)
            return [f"{self.words.named('TIMER', timer)}={word.value}"]
        if s.name == "CALL":
            routine, *rest = map(self.words.value, arguments)
            return [f"CALL {routine}({','.join(rest)})" if rest else f"CALL {routine}"]
        if s.name.endswith("CONDITION"):
            condition = arguments[0]
            value = (
                self.words.value(condition)
                if isinstance(condition, Variable)
                else self.words.condition(condition)
            )
            return [f"{s.name} {value}"]
        text = "".join(value.value for value in arguments if isinstance(value, Text))
        return [f"{s.name}{'' if text[:1] in '[=' else ' '}{text}".rstrip()]

    def comment(self, s: Comment) -> list[str]:
        if self.own:
            return [s.text if s.text.startswith("--eg:") else f"!{s.text}"]
        return comment_lines(s.text)

    def disabled(self, s: Disabled) -> list[str]:
        self._only_own(s)
        return [f"//{s.text}"]

    def opaque(self, s: Opaque) -> list[str]:
        self._only_own(s)
        return [s.text]


def comment_lines(text: str) -> list[str]:
    """A comment in lines that the controller keeps whole."""
    if len(text) <= COMMENT_LENGTH:
        return [f"!{text}"]
    from textwrap import wrap

    return [f"!{part}" for part in wrap(text, COMMENT_LENGTH)]


_SPELLINGS: Final[Mapping[type[Any], Callable[[StatementWriter, Any], list[str]]]] = {
    Assign: StatementWriter.assign,
    Update: StatementWriter.update,
    Clear: StatementWriter.clear,
    Declare: StatementWriter.declare,
    SetOutput: StatementWriter.set_output,
    PulseOutput: StatementWriter.pulse,
    ReadInput: StatementWriter.read_input,
    Dwell: StatementWriter.dwell,
    Wait: StatementWriter.wait,
    Jump: StatementWriter.jump,
    Call: StatementWriter.call,
    Return: StatementWriter.return_,
    If: StatementWriter.if_,
    Else: lambda _, s: ["ELSE"],
    For: StatementWriter.for_,
    Next: lambda _, s: ["ENDFOR"],
    Pause: StatementWriter.pause,
    StartTask: StatementWriter.start_task,
    SetTool: StatementWriter.set_tool,
    SetFrame: StatementWriter.set_frame,
    SetOverride: StatementWriter.set_override,
    Message: StatementWriter.message,
    Process: StatementWriter.process,
    Comment: StatementWriter.comment,
    Disabled: StatementWriter.disabled,
    Opaque: StatementWriter.opaque,
    Begin: lambda _, s: [],
    End: lambda _, s: [],
}
