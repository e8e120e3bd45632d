"""Lowers every instruction that is no move, one short method per rule of the grammar: control flow, tasks, process ….

The parser is built once per process from grammars/inform.lark and shared by all reads.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any, Final, NamedTuple, cast

from lark import Token

from olp.core.units import mm, percent
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.languages.lark_host import BrokenLineError, Grammar
from olp.languages.statement_rules import BlockWords
from olp.languages.vendors.inform import values
from olp.languages.vendors.inform.expressions import InformExpressionRules, InformRemark, checked, unmangle

# --- Moves ---
# Lowers move lines: MOVx, IMOV, SMOVx, REFP with their tags and second parts.

PATHS: Final = {"J": st.Path.JOINT, "L": st.Path.LINEAR, "C": st.Path.CIRCULAR, "S": st.Path.SPLINE}
_SPEED_WORDS = {unit: f"{word}=" for word, (unit, _, _) in values.SPEEDS.items()}
_FRAME_WORDS = {"base": "BF", "robot": "RF", "tool": "TF", "master-tool": "MTF", "user": "UF#"}
_SENTENCES = {
    "speed": "speed",
    "blend": "position level",
    "acceleration": "acceleration",
    "deceleration": "deceleration",
    "relative": "coordinate system",
    "search": "search",
    "until": "UNTIL",
    "passes": "pass",
    "end_of_arc": "FPT",
    "no_wait": "NWAIT",
}
_CONTINUOUS = st.Blend(st.BlendKind.CONTINUOUS)


_FULL: Final = ex.Quantity(ex.Number(100), percent)  # the braking of a move without DEC=


class MoveTag(NamedTuple):
    """One word after a move's positions: a field of Move, its value, and how it begins in the line."""

    field: str
    value: Any
    word: str


def _level(written: Any) -> st.Blend:
    """PL=n."""
    if type(written) is ex.Number and written.value not in range(9):
        raise BrokenLineError(f"a position level of {written.value}", word="PL=", wanted="0 to 8")
    return st.Blend(st.BlendKind.LEVEL, values.quantity(written, values.LEVEL))


def _check_speed(speed: st.Speed) -> None:
    """Raises BrokenLineError for a speed of 0: the leading group's speed times the move."""
    checked(speed.value, _SPEED_WORDS[speed.unit], "a speed")


class InformMoveRules(InformExpressionRules):
    def move(self, children: list[Any]) -> st.Move:
        word, rest = children[0], children[1:]
        targets, tags, parts = _sorted(rest)
        fields = _fields(tags)
        if "speed" in fields:
            _check_speed(fields["speed"])
        other = tuple(tag.value for tag in tags if tag.field == "other")
        if other:
            fields["other"] = other
        if word == "IMOV":
            fields.setdefault("relative", ex.FrameRef("own"))
            spoken = fields.get("speed")
            joint = spoken is not None and spoken.unit is st.SpeedUnit.FRACTION
            path = st.Path.JOINT if joint else st.Path.LINEAR
        elif "relative" in fields:
            wrong = next(tag.word for tag in tags if tag.field == "relative")
            raise BrokenLineError(
                "a coordinate system belongs to IMOV only", word=wrong, wanted="no coordinate system"
            )
        else:
            path = PATHS[word[-1]]
        if word[0] == "S":
            fields["coordinated"] = True
        if "acceleration" in fields:
            fields.setdefault("deceleration", _FULL)  # ACC= says nothing of braking
        return st.Move(0, path, targets, parts=parts, **fields)

    def part(self, children: list[Any]) -> st.MovePart:
        _, word, *rest = children
        if word[:3] != "MOV":
            raise BrokenLineError(
                f"{word} cannot be the second part of a move", word=f"+{word}", wanted="MOVJ, MOVL or REFP"
            )
        targets, tags, _ = _sorted(rest)
        return st.MovePart(PATHS[word[-1]], targets, **_fields(tags))

    def reference_part(self, children: list[Any]) -> st.MovePart:
        return st.MovePart(None, tuple(children[2:]))

    def reference(self, children: list[Any]) -> st.Reference:
        word, number, *rest = children
        parts = tuple(part for part in rest if type(part) is st.MovePart)
        targets = tuple(part for part in rest if type(part) is not st.MovePart)
        return st.Reference(0, number, targets, parts, coordinated=word[0] == "S")

    def set_speed(self, children: list[st.Speed]) -> st.SetSpeed:
        for speed in children:
            _check_speed(speed)
        return st.SetSpeed(0, tuple(children))

    def level(self, children: list[Any]) -> MoveTag:
        return MoveTag("blend", _level(children[1]), "PL=")

    def rate(self, children: list[Any]) -> MoveTag:
        field = "acceleration" if children[0] == "ACC=" else "deceleration"
        rate = checked(values.quantity(children[1], values.RATE), children[0], "a rate")
        return MoveTag(field, rate, str(children[0]))

    def radius(self, children: list[Any]) -> MoveTag:
        return MoveTag("blend", st.Blend(st.BlendKind.RADIUS, values.quantity(children[1], (mm, mm))), "CR=")

    def other(self, children: list[Any]) -> MoveTag:
        return MoveTag("other", (str(children[0])[:-1], children[1]), str(children[0]))

    def continuous(self, _: list[Token]) -> MoveTag:
        return MoveTag("blend", _CONTINUOUS, "CONT")

    def end_of_arc(self, _: list[Token]) -> MoveTag:
        return MoveTag("end_of_arc", True, "FPT")

    def no_wait(self, children: list[Token]) -> MoveTag:
        return MoveTag("no_wait", True, str(children[0]))

    def passes(self, children: list[Token]) -> MoveTag:
        return MoveTag("passes", str(children[0]), str(children[0]))

    def relative(self, children: list[ex.FrameRef]) -> MoveTag:
        return MoveTag("relative", children[0], _FRAME_WORDS[children[0].kind])

    def search(self, children: list[Any]) -> MoveTag:
        signal, _, state, time, _, distance = children
        travel = None if distance is None else values.quantity(distance, values.DISTANCE)
        return MoveTag("search", st.Search(signal, state == "ON", time, travel), "SRCH")

    def until(self, children: list[Any]) -> MoveTag:
        return MoveTag("until", children[0], "UNTIL")


def _sorted(rest: list[Any]) -> tuple[tuple[ex.Position, ...], list[MoveTag], tuple[st.MovePart, ...]]:
    targets, tags, parts = [], [], []
    for item in rest:
        kind = type(item)
        if kind is MoveTag:
            tags.append(item)
        elif kind is st.Speed:
            tags.append(MoveTag("speed", item, _SPEED_WORDS[item.unit]))
        elif kind is st.MovePart:
            parts.append(item)
        else:
            targets.append(item)
    return tuple(targets), tags, tuple(parts)


def _fields(tags: list[MoveTag]) -> dict[str, Any]:
    fields: dict[str, Any] = {}
    for tag in tags:
        if tag.field == "other":
            continue
        if tag.field in fields:
            message = f"a second {_SENTENCES[tag.field]} in one line"
            raise BrokenLineError(message, word=tag.word, wanted=f"one {_SENTENCES[tag.field]}")
        fields[tag.field] = tag.value
    return fields


# --- Flow ---


class Suffix(NamedTuple):
    """`IF …` or `IFEXPRESS …` behind an instruction."""

    word: str
    condition: ex.Expression


class SwitchAndCase(NamedTuple):
    """`SWITCH a CASE 1` on one line: two statements."""

    switch: st.Switch
    case: st.Case


_NO_SUFFIX = Suffix("", None)  # type: ignore[arg-type]


def _suffix(children: list[Any]) -> tuple[list[Any], Suffix]:
    """The children before the suffix, and the suffix or an empty one."""
    if children and type(children[-1]) is Suffix:
        return children[:-1], children[-1]
    return children, _NO_SUFFIX


class FlowRules(InformMoveRules, BlockWords):
    def suffix(self, children: list[Any]) -> Suffix:
        return Suffix(str(children[0]), children[1])

    def label(self, children: list[Token]) -> st.Label:
        return st.Label(0, children[0][1:])

    def jump(self, children: list[Any]) -> st.Jump:
        (word, *_, target), suffix = _suffix(children)
        if str(word) == "JMP":
            self.remarks.append(InformRemark("P036", "JMP", word.column or 1))
        name = target[1:] if type(target) is Token else target
        return st.Jump(0, name, suffix.condition, spelling=suffix.word)

    def call(self, children: list[Any]) -> st.Call:
        (word, job, *arguments), suffix = _suffix(children)
        jump = word == "JUMP"
        name = unmangle(job[4:].strip())
        return st.Call(0, name, tuple(arguments), suffix.condition, jump=jump, spelling=suffix.word)

    def macro(self, children: list[Any]) -> st.Call:
        (_, number, *arguments), suffix = _suffix(children)
        return st.Call(0, "", tuple(arguments), suffix.condition, macro=number, spelling=suffix.word)

    def return_(self, children: list[Any]) -> st.Return:
        value, suffix = _suffix(children)
        return st.Return(0, value[0] if value else None, suffix.condition, spelling=suffix.word)

    def if_(self, children: list[Any]) -> st.If:
        return st.If(0, children[1], spelling=str(children[0]))

    def else_if(self, children: list[Any]) -> st.ElseIf:
        return st.ElseIf(0, children[1], spelling=str(children[0]))

    def while_(self, children: list[Any]) -> st.While:
        return st.While(0, children[1], spelling=str(children[0]))

    def for_(self, children: list[Any]) -> st.For:
        variable, _, start, _, stop, *step = children
        return st.For(0, variable, start, stop, step[1] if step else None)

    def next_(self, children: list[ex.Variable]) -> st.Next:
        return st.Next(0, children[0] if children else None)

    def switch(self, children: list[Any]) -> st.Switch | SwitchAndCase:
        value, *case = children
        return SwitchAndCase(st.Switch(0, value), self.case(case)) if case else st.Switch(0, value)

    def case(self, children: list[Any]) -> st.Case:
        return st.Case(0, tuple(children[1:]))

    def begin(self, _: list[Any]) -> st.Begin:
        return st.Begin(0)

    def end(self, _: list[Any]) -> st.End:
        return st.End(0)

    def disabled(self, children: list[Token]) -> st.Disabled:
        return st.Disabled(0, unmangle(children[0].strip()))

    def pulse(self, children: list[Any]) -> st.PulseOutput:
        (signal, duration), suffix = _suffix(children)
        return st.PulseOutput(0, signal, duration, suffix.condition, spelling=suffix.word)

    # --- operator, tasks, process -----------------------------------------------------------------------

    def pause(self, children: list[Any]) -> st.Pause:
        _, suffix = _suffix(children)
        return st.Pause(0, suffix.condition, spelling=suffix.word)

    def start_task(self, children: list[Any]) -> st.StartTask:
        (job, task, *sync), suffix = _suffix(children)
        name = unmangle(job[4:].strip())
        return st.StartTask(
            0, name, str(task), suffix.condition, spelling=suffix.word, synchronised=bool(sync)
        )

    def wait_task(self, children: list[Token]) -> st.WaitTask:
        return st.WaitTask(0, str(children[0]))

    def synchronise(self, children: list[Any]) -> st.Synchronise:
        return st.Synchronise(0, children[0], children[2] if len(children) > 1 else None)

    def message(self, children: list[ex.Expression]) -> st.Message:
        return st.Message(0, children[0])

    def process(self, children: list[Any]) -> st.Process:
        return st.Process(0, str(children[0]), tuple(children[1:]))

    def tagged(self, children: list[Any]) -> tuple[str, ex.Expression]:
        return str(children[0]).removesuffix("="), children[1]

    def word(self, children: list[Token]) -> tuple[str, ex.Expression]:
        word = unmangle(str(children[0]))
        known = self.aliases.get(word)
        if known is not None:
            self.named_any = True
            return "", known
        return "", ex.Unknown(word)

    def positional(self, children: list[ex.Expression]) -> tuple[str, ex.Expression]:
        return "", children[0]

    def positional_number(self, children: list[Token]) -> tuple[str, ex.Expression]:
        return "", values.number(children[0])

    def positional_text(self, children: list[Token]) -> tuple[str, ex.Expression]:
        return "", ex.Text(children[0][1:-1])

    def positional_taught(self, children: list[Token]) -> tuple[str, ex.Expression]:
        return "", values.taught(children[0])

    def positional_state(self, children: list[Token]) -> tuple[str, ex.Expression]:
        return "", ex.SignalState(children[0] == "ON")


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
    """The rules of a whole instruction. Statements have line 0; the reader gives them their line."""

    def instruction(self, children: list[Any]) -> st.Statement | SwitchAndCase:
        if len(children) == 1:
            return children[0] if type(children[0]) is not Token else _comment(children[0])
        first, last = children[0], children[-1]
        if type(first) is Token:
            self.remarks.append(InformRemark("P040", str(first), first.column or 1))
        statement: st.Statement | SwitchAndCase = children[1] if type(first) is Token else first
        if type(last) is Token and not isinstance(statement, st.Disabled):
            if last[0] == "'":
                self.remarks.append(InformRemark("P033", str(last), last.column or 1))
            text = _comment(last).text
            if isinstance(statement, SwitchAndCase):
                return statement._replace(case=replace(statement.case, comment=text))
            statement = replace(cast(Any, statement), comment=text)
        return statement

    # --- values -----------------------------------------------------------------------------------------

    def assigned(self, children: list[ex.Expression]) -> ex.Expression:
        return children[0]

    function_value = assigned

    def argument_value(self, children: list[Any]) -> ex.Expression:
        value: ex.Expression = children[1]
        return value

    def assign(self, children: list[Any]) -> st.Assign:
        return st.Assign(0, children[0], children[1])

    def set_element(self, children: list[Any]) -> st.Assign:
        variable, index, value = children
        return st.Assign(0, ex.Element(variable, index), value)

    def get_element(self, children: list[Any]) -> st.Assign:
        target, variable, index = children
        return st.Assign(0, target, ex.Element(variable, index))

    def get_system(self, children: list[Any]) -> st.Assign:
        target, word = children
        if word == "$RV":
            return st.Assign(0, target, ex.SystemValue("returned"))
        variable = values.variable(word[1:])
        number = _whole(variable.index)
        if word.startswith("$PX") and number in _POSITION_VALUES:
            return st.Assign(0, target, ex.SystemValue(_POSITION_VALUES[number]))
        return st.Assign(0, target, ex.SystemValue(variable.store.value, number))

    def get_argument(self, children: list[Any]) -> st.Assign:
        return st.Assign(0, children[0], ex.Argument(_argument_number(children[2])))

    def get_register(self, children: list[Any]) -> st.Assign:
        target, signal, *half = children
        return st.Assign(0, target, _half(signal, half))

    def set_register(self, children: list[Any]) -> st.SetOutput:
        signal, *half, value = children
        return st.SetOutput(0, _half(signal, half), value)

    def get_tool(self, children: list[Any]) -> st.Assign:
        target, tool = children
        return st.Assign(0, target, ex.Function("tool-data", (tool.number,)))

    def set_tool(self, children: list[Any]) -> st.Assign:
        tool, position = children
        return st.Assign(0, ex.Function("tool-data", (tool.number,)), position)

    def get_position(self, children: list[Any]) -> st.Assign:
        return st.Assign(0, children[0], ex.Function("step-position", (children[2],)))

    def get_parameter(self, children: list[Any]) -> st.Assign:
        target, _, kind, _, number = children
        return st.Assign(0, target, ex.Function("parameter", (kind, number)))

    def function(self, children: list[Any]) -> st.Assign:
        word, target, *arguments = children
        return st.Assign(0, target, ex.Function(FUNCTIONS[word], tuple(arguments)))

    def update(self, children: list[Any]) -> st.Update:
        word, target, *operand = children
        counts = word in ("INC", "DEC")
        if counts == bool(operand):
            message = f"{word} takes one variable" if counts else f"{word} takes two values"
            raise BrokenLineError(message, word=str(word), wanted=f"{word} {'B000' if counts else 'B000 1'}")
        return st.Update(0, _OPERATORS[word], target, ex.Number(1) if counts else operand[0])

    def clear(self, children: list[Any]) -> st.Clear | st.Process:
        target = children[0]
        if target == "STACK":
            return st.Clear(0, None)
        if target == "MPF":
            return st.Process(0, "CLEAR", (("", ex.Unknown("MPF")),))
        return st.Clear(0, target, children[1] if len(children) > 1 else ex.Number(1))

    def clear_count(self, children: list[Any]) -> ex.Expression | None:
        return None if children[0] == "ALL" else children[0]

    # --- frames -----------------------------------------------------------------------------------------

    def define_frame(self, children: list[Any]) -> st.DefineFrame:
        frame, *points = children
        master = type(points[-1]) is Token
        return st.DefineFrame(0, frame, tuple(points[:-1] if master else points), master)

    def shift_on(self, children: list[Any]) -> st.ShiftOn:
        word, offset, *frame = children
        return st.ShiftOn(0, offset, frame[0] if frame else None, coordinated=word[:2] == "SS")

    def shift_off(self, children: list[Token]) -> st.ShiftOff:
        return st.ShiftOff(0, coordinated=children[0][:2] == "SS")

    def tool_on(self, children: list[ex.FrameRef]) -> st.ExternalTool:
        return st.ExternalTool(0, children[0].number)

    def tool_off(self, _: list[Any]) -> st.ExternalTool:
        return st.ExternalTool(0, None)

    # --- signals and time -------------------------------------------------------------------------------

    def digital_output(self, children: list[Any]) -> st.SetOutput:
        signal, value = children
        return st.SetOutput(0, signal, ex.SignalState(value == "ON") if type(value) is Token else value)

    def analog_output(self, children: list[Any]) -> st.SetOutput:
        return st.SetOutput(0, children[0], children[1])

    def digital_input(self, children: list[Any]) -> st.ReadInput:
        return st.ReadInput(0, children[0], children[1])

    def timer(self, children: list[ex.Quantity]) -> st.Dwell:
        return st.Dwell(0, children[0])

    def wait(self, children: list[Any]) -> st.Wait | st.Dwell:
        *conditions, time = children
        if conditions:
            return st.Wait(
                0, conditions[-1], time, spelling=str(conditions[0]) if len(conditions) > 1 else ""
            )
        if time is None:
            raise BrokenLineError(
                "WAIT names no condition", word="WAIT", wanted="WAIT IN#(1)=ON or WAIT T=1.00"
            )
        return st.Dwell(0, time)


def _comment(token: Token) -> st.Comment:
    return st.Comment(0, token[2 if token.startswith("//") else 1 :].rstrip())


def _half(signal: ex.Signal, half: list[Token]) -> ex.Signal:
    return replace(signal, part=half[0].lower()) if half else signal


def _whole(number: ex.Expression) -> int:
    assert type(number) is ex.Number
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

    statements: tuple[st.Statement, ...]
    remarks: tuple[InformRemark, ...]
    named: bool


class InformParser(Grammar):
    """Parses one instruction at a time. `words`: all that can open an instruction."""

    def __init__(self) -> None:
        super().__init__("inform", InformInstructionRules())
        self.words = self._instruction_words()

    def instruction(self, line: str, aliases: Mapping[str, ex.Variable]) -> InformLine:
        """Parses one instruction. Raises lark's UnexpectedInput, or BrokenLineError."""
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
