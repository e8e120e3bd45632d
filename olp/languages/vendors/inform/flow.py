"""Lowers control flow, tasks, messages and process instructions: one short method per rule."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from lark import Token

from olp.core.units import mm
from olp.ir.expressions import Expression, FrameRef, Number, Position, SignalState, Text, Unknown, Variable
from olp.ir.program import (
    Begin,
    Blend,
    BlendKind,
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
    Move,
    MovePart,
    Next,
    Path,
    Pause,
    Process,
    PulseOutput,
    Reference,
    Return,
    Search,
    SetSpeed,
    Speed,
    SpeedUnit,
    StartTask,
    Switch,
    Synchronise,
    WaitTask,
    While,
)
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendors.inform import values
from olp.languages.vendors.inform.expressions import InformExpressionRules, InformRemark, checked, unmangle

# --- Moves ---
# Lowers move lines: MOVx, IMOV, SMOVx, REFP with their tags and second parts.

PATHS: Final = {"J": Path.JOINT, "L": Path.LINEAR, "C": Path.CIRCULAR, "S": Path.SPLINE}
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
_CONTINUOUS = Blend(BlendKind.CONTINUOUS)


class MoveTag(NamedTuple):
    """One word after a move's positions: a field of Move, its value, and how it begins in the line."""

    field: str
    value: Any
    word: str


def _level(written: Any) -> Blend:
    """PL=n."""
    if type(written) is Number and written.value not in range(9):
        raise BrokenLineError(f"a position level of {written.value}", word="PL=", wanted="0 to 8")
    return Blend(BlendKind.LEVEL, values.quantity(written, values.LEVEL))


def _check_speed(speed: Speed) -> None:
    """The leading group's speed times the move: it cannot be 0."""
    checked(speed.value, _SPEED_WORDS[speed.unit], "a speed")


class InformMoveRules(InformExpressionRules):
    def move(self, children: list[Any]) -> Move:
        word, rest = children[0], children[1:]
        targets, tags, parts = _sorted(rest)
        fields = _fields(tags)
        if "speed" in fields:
            _check_speed(fields["speed"])
        other = tuple(tag.value for tag in tags if tag.field == "other")
        if other:
            fields["other"] = other
        if word == "IMOV":
            fields.setdefault("relative", FrameRef("own"))
            spoken = fields.get("speed")
            joint = spoken is not None and spoken.unit is SpeedUnit.FRACTION
            path = Path.JOINT if joint else Path.LINEAR
        elif "relative" in fields:
            wrong = next(tag.word for tag in tags if tag.field == "relative")
            raise BrokenLineError(
                "a coordinate system belongs to IMOV only", word=wrong, wanted="no coordinate system"
            )
        else:
            path = PATHS[word[-1]]
        if word[0] == "S":
            fields["coordinated"] = True
        return Move(0, path, targets, parts=parts, **fields)

    def part(self, children: list[Any]) -> MovePart:
        _, word, *rest = children
        if word[:3] != "MOV":
            raise BrokenLineError(
                f"{word} cannot be the second part of a move", word=f"+{word}", wanted="MOVJ, MOVL or REFP"
            )
        targets, tags, _ = _sorted(rest)
        return MovePart(PATHS[word[-1]], targets, **_fields(tags))

    def reference_part(self, children: list[Any]) -> MovePart:
        return MovePart(None, tuple(children[2:]))

    def reference(self, children: list[Any]) -> Reference:
        word, number, *rest = children
        parts = tuple(part for part in rest if type(part) is MovePart)
        targets = tuple(part for part in rest if type(part) is not MovePart)
        return Reference(0, number, targets, parts, coordinated=word[0] == "S")

    def set_speed(self, children: list[Speed]) -> SetSpeed:
        for speed in children:
            _check_speed(speed)
        return SetSpeed(0, tuple(children))

    def level(self, children: list[Any]) -> MoveTag:
        return MoveTag("blend", _level(children[1]), "PL=")

    def rate(self, children: list[Any]) -> MoveTag:
        field = "acceleration" if children[0] == "ACC=" else "deceleration"
        rate = checked(values.quantity(children[1], values.RATE), children[0], "a rate")
        return MoveTag(field, rate, str(children[0]))

    def radius(self, children: list[Any]) -> MoveTag:
        return MoveTag("blend", Blend(BlendKind.RADIUS, values.quantity(children[1], (mm, mm))), "CR=")

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

    def relative(self, children: list[FrameRef]) -> MoveTag:
        return MoveTag("relative", children[0], _FRAME_WORDS[children[0].kind])

    def search(self, children: list[Any]) -> MoveTag:
        signal, _, state, time, _, distance = children
        travel = None if distance is None else values.quantity(distance, values.DISTANCE)
        return MoveTag("search", Search(signal, state == "ON", time, travel), "SRCH")

    def until(self, children: list[Any]) -> MoveTag:
        return MoveTag("until", children[0], "UNTIL")


def _sorted(rest: list[Any]) -> tuple[tuple[Position, ...], list[MoveTag], tuple[MovePart, ...]]:
    targets, tags, parts = [], [], []
    for item in rest:
        kind = type(item)
        if kind is MoveTag:
            tags.append(item)
        elif kind is Speed:
            tags.append(MoveTag("speed", item, _SPEED_WORDS[item.unit]))
        elif kind is MovePart:
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
