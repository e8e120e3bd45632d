"""Lowers every instruction that is no move: one short method per rule of the grammar.

The parser is built once per process from grammars/inform.lark and shared by all reads.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any, Final, NamedTuple, cast

from lark import Token

from olp.ir.expressions import (
    Argument,
    Element,
    Expression,
    FrameRef,
    Function,
    Number,
    Quantity,
    Signal,
    SignalState,
    SystemValue,
    Unknown,
    Variable,
)
from olp.ir.program import (
    Assign,
    Clear,
    Comment,
    DefineFrame,
    Disabled,
    Dwell,
    ExternalTool,
    Process,
    ReadInput,
    SetOutput,
    ShiftOff,
    ShiftOn,
    Statement,
    Update,
    Wait,
)
from olp.languages.lark_host import BrokenLineError, Grammar
from olp.languages.vendors.inform import values
from olp.languages.vendors.inform.expressions import InformRemark
from olp.languages.vendors.inform.flow import FlowRules, SwitchAndCase

FUNCTIONS: Final = {
    "SQRT": "sqrt",
    "SIN": "sin",
    "COS": "cos",
    "ATAN": "atan",
    "MULMAT": "pose-product",
    "INVMAT": "pose-inverse",
    "CNVRT": "convert",
    "CONVSFT": "convert-shift",
    "MSHIFT": "shift-between",
    "VAL": "value-of-text",
    "VAL2STR": "text-of-value",
    "ASC": "code-of-character",
    "CHR$": "character-of-code",
    "MID$": "part-of-text",
    "LEN": "length-of-text",
    "CAT$": "joined-text",
    "STRSTR": "position-in-text",
}
_OPERATORS = {
    "ADD": "+",
    "SUB": "-",
    "MUL": "*",
    "DIV": "/",
    "AND": "and",
    "OR": "or",
    "XOR": "xor",
    "NOT": "not",
    "INC": "+",
    "DEC": "-",
}
_POSITION_VALUES = {0: "position-pulse", 1: "position-pose"}


class InformInstructionRules(FlowRules):
    """The whole instruction. Statements come with line 0; the reader stamps the true one on them."""

    def instruction(self, children: list[Any]) -> Statement | SwitchAndCase:
        if len(children) == 1:
            return children[0] if type(children[0]) is not Token else _comment(children[0])
        first, last = children[0], children[-1]
        if type(first) is Token:
            self.remarks.append(InformRemark("P040", str(first), first.column or 1))
        statement: Statement | SwitchAndCase = children[1] if type(first) is Token else first
        if type(last) is Token and not isinstance(statement, Disabled):
            if last[0] == "'":
                self.remarks.append(InformRemark("P033", str(last), last.column or 1))
            text = _comment(last).text
            if isinstance(statement, SwitchAndCase):
                return statement._replace(case=replace(statement.case, comment=text))
            statement = replace(cast(Any, statement), comment=text)
        return statement

    # --- values -----------------------------------------------------------------------------------------

    def assigned(self, children: list[Expression]) -> Expression:
        return children[0]

    function_value = assigned

    def argument_value(self, children: list[Any]) -> Expression:
        value: Expression = children[1]
        return value

    def assign(self, children: list[Any]) -> Assign:
        return Assign(0, children[0], children[1])

    def set_element(self, children: list[Any]) -> Assign:
        variable, index, value = children
        return Assign(0, Element(variable, index), value)

    def get_element(self, children: list[Any]) -> Assign:
        target, variable, index = children
        return Assign(0, target, Element(variable, index))

    def get_system(self, children: list[Any]) -> Assign:
        target, word = children
        if word == "$RV":
            return Assign(0, target, SystemValue("returned"))
        variable = values.variable(word[1:])
        number = _whole(variable.index)
        if word.startswith("$PX") and number in _POSITION_VALUES:
            return Assign(0, target, SystemValue(_POSITION_VALUES[number]))
        return Assign(0, target, SystemValue(variable.store.value, number))

    def get_argument(self, children: list[Any]) -> Assign:
        return Assign(0, children[0], Argument(_argument_number(children[2])))

    def get_register(self, children: list[Any]) -> Assign:
        target, signal, *half = children
        return Assign(0, target, _half(signal, half))

    def set_register(self, children: list[Any]) -> SetOutput:
        signal, *half, value = children
        return SetOutput(0, _half(signal, half), value)

    def get_tool(self, children: list[Any]) -> Assign:
        target, tool = children
        return Assign(0, target, Function("tool-data", (tool.number,)))

    def set_tool(self, children: list[Any]) -> Assign:
        tool, position = children
        return Assign(0, Function("tool-data", (tool.number,)), position)

    def get_position(self, children: list[Any]) -> Assign:
        return Assign(0, children[0], Function("step-position", (children[2],)))

    def get_parameter(self, children: list[Any]) -> Assign:
        target, _, kind, _, number = children
        return Assign(0, target, Function("parameter", (kind, number)))

    def function(self, children: list[Any]) -> Assign:
        word, target, *arguments = children
        return Assign(0, target, Function(FUNCTIONS[word], tuple(arguments)))

    def update(self, children: list[Any]) -> Update:
        word, target, *operand = children
        counts = word in ("INC", "DEC")
        if counts == bool(operand):
            message = f"{word} takes one variable" if counts else f"{word} takes two values"
            raise BrokenLineError(message, word=str(word), wanted=f"{word} {'B000' if counts else 'B000 1'}")
        return Update(0, _OPERATORS[word], target, Number(1) if counts else operand[0])

    def clear(self, children: list[Any]) -> Clear | Process:
        target = children[0]
        if target == "STACK":
            return Clear(0, None)
        if target == "MPF":
            return Process(0, "CLEAR", (("", Unknown("MPF")),))
        return Clear(0, target, children[1] if len(children) > 1 else Number(1))

    def clear_count(self, children: list[Any]) -> Expression | None:
        return None if children[0] == "ALL" else children[0]

    # --- frames -----------------------------------------------------------------------------------------

    def define_frame(self, children: list[Any]) -> DefineFrame:
        frame, *points = children
        master = type(points[-1]) is Token
        return DefineFrame(0, frame, tuple(points[:-1] if master else points), master)

    def shift_on(self, children: list[Any]) -> ShiftOn:
        word, offset, *frame = children
        return ShiftOn(0, offset, frame[0] if frame else None, coordinated=word[:2] == "SS")

    def shift_off(self, children: list[Token]) -> ShiftOff:
        return ShiftOff(0, coordinated=children[0][:2] == "SS")

    def tool_on(self, children: list[FrameRef]) -> ExternalTool:
        return ExternalTool(0, children[0].number)

    def tool_off(self, _: list[Any]) -> ExternalTool:
        return ExternalTool(0, None)

    # --- signals and time -------------------------------------------------------------------------------

    def digital_output(self, children: list[Any]) -> SetOutput:
        signal, value = children
        return SetOutput(0, signal, SignalState(value == "ON") if type(value) is Token else value)

    def analog_output(self, children: list[Any]) -> SetOutput:
        return SetOutput(0, children[0], children[1])

    def digital_input(self, children: list[Any]) -> ReadInput:
        return ReadInput(0, children[0], children[1])

    def timer(self, children: list[Quantity]) -> Dwell:
        return Dwell(0, children[0])

    def wait(self, children: list[Any]) -> Wait | Dwell:
        *conditions, time = children
        if conditions:
            return Wait(0, conditions[-1], time, spelling=str(conditions[0]) if len(conditions) > 1 else "")
        if time is None:
            raise BrokenLineError(
                "WAIT names no condition", word="WAIT", wanted="WAIT IN#(1)=ON or WAIT T=1.00"
            )
        return Dwell(0, time)


def _comment(token: Token) -> Comment:
    return Comment(0, token[2 if token.startswith("//") else 1 :].rstrip())


def _half(signal: Signal, half: list[Token]) -> Signal:
    return replace(signal, part=half[0].lower()) if half else signal


def _whole(number: Expression) -> int:
    assert type(number) is Number
    return int(number.value)


def _argument_number(token: Token) -> int:
    if not token.isdecimal():
        raise BrokenLineError(f"'{token}' is no argument number", word=str(token), wanted="1 to 8")
    return int(token)


_PLAIN_WORDS = re.compile(r"[A-Z][A-Z0-9$]+")


class InformLine(NamedTuple):
    """One instruction, with line 0: one statement, but two for `SWITCH a CASE 1`.

    `named`: names of //ALIAS took part, so it holds for its job only.
    """

    statements: tuple[Statement, ...]
    remarks: tuple[InformRemark, ...]
    named: bool


class InformParser(Grammar):
    """Parses one instruction at a time. `words`: all that can open an instruction."""

    def __init__(self) -> None:
        super().__init__("inform", InformInstructionRules())
        self.words = self._instruction_words()

    def instruction(self, line: str, aliases: Mapping[str, Variable]) -> InformLine:
        """Raises lark's UnexpectedInput, or BrokenLineError."""
        told = ("remarks", "named_any")
        parsed, remarks, named = self.parse(line, then=told, aliases=aliases, remarks=[], named_any=False)
        statements: tuple[Any, ...] = tuple(parsed) if isinstance(parsed, SwitchAndCase) else (parsed,)
        return InformLine(statements, tuple(remarks), named)

    def _instruction_words(self) -> frozenset[str]:
        """Every word that can open an instruction, as the grammar lists them."""
        choices = self.lark.parse_interactive("").choices()  # type: ignore[no-untyped-call]
        words: set[str] = set()
        for name in (set(choices) & set(self.terminals)) - {"COMMENT", "LABEL"}:
            pattern = self.terminals[name].split("(?!")[0].split("(?=")[0]
            words.update(_PLAIN_WORDS.findall(pattern.replace("\\", "")))
        return frozenset(words)


@cache
def instruction_parser() -> InformParser:
    """The one parser of this process."""
    return InformParser()
