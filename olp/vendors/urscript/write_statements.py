"""Spells every statement that is no move: one short function per type, lines without their indent."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from olp import called
from olp.expression import (
    Binary,
    Expression,
    Function,
    Item,
    Member,
    Named,
    Number,
    Signal,
    State,
    Text,
    Variable,
)
from olp.program import (
    Assign,
    Begin,
    Break,
    Call,
    Comment,
    Continue,
    Declare,
    Disabled,
    Dwell,
    Else,
    ElseIf,
    End,
    EndIf,
    EndWhile,
    If,
    Message,
    Opaque,
    Pause,
    Process,
    ReadInput,
    Return,
    SetOutput,
    SetTool,
    StartTask,
    Statement,
    Update,
    Wait,
    WaitTask,
    While,
)
from olp.units import deg, mm
from olp.vendors.urscript import builtins, helpers
from olp.vendors.urscript.folding import scaled
from olp.vendors.urscript.waits import inverted
from olp.vendors.urscript.write_values import CannotSayError, Words

_DEFAULTS: Final = {
    "integer": "0",
    "boolean": "False",
    "string": '""',
    "position": "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
    "frame": "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
    "tool": "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
    "joints": "[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
    "list": "[]",
}
_POSITIONS: Final = {"x": 0, "y": 1, "z": 2, "rotation1": 3, "rotation2": 4, "rotation3": 5}
_MOST_ITEMS = 1000
_STANDARD_SIGNALS = 8

Lines = list[str]


def spell(words: Words, s: Statement) -> Lines:
    """The statement as lines. Raises CannotSayError."""
    rule = _SPELL.get(type(s))
    if rule is None:
        raise CannotSayError(called.statement(s))
    return rule(words, s)


def declared(words: Words, s: Declare, scope: str) -> str:
    """`scope name = value`; what has no value gets the zero of its type."""
    value = default(s) if s.value is None else words.value(s.value)
    return f"{scope}{s.name} = {value}"


def default(s: Declare) -> str:
    """The zero of a declaration's type. Raises CannotSayError for one of unknown size."""
    zero = _DEFAULTS.get(s.type, "0.0")
    for size in reversed(s.sizes):
        if type(size) is not Number or not 0 <= size.value <= _MOST_ITEMS:
            raise CannotSayError(f"an array of unknown size ({s.name})")
        zero = f"[{', '.join([zero] * int(size.value))}]"
    return zero


# --- values ---------------------------------------------------------------------------------------------


def store(words: Words, target: Expression, value: Expression) -> str:
    """target = value, both in URScript's units."""
    match target:
        case Named(name):
            return f"{name} = {words.value(value)}"
        case Item(base, _) if words.kind(base) == "joints":
            return f"{words.element(target)} = {words.value(scaled(value, deg))}"
        case Item():
            return f"{words.element(target)} = {words.value(value)}"
        case Member(base, name) if name in _POSITIONS and words.kind(base) in ("", "position"):
            place = _POSITIONS[name]
            written = words.value(scaled(value, mm) if place < 3 else value)
            return f"{words.value(base)}[{place}] = {written}"
        case Member(base, "rx" | "ry" | "rz" as name) if words.kind(base) in ("", "position"):
            return _angle_stored(words, base, name, value)
        case Member(base, name) if words.kind(base) not in ("joints", "list"):
            return f"{words.value(base)}.{name} = {words.value(value)}"
        case Function("pose-element"):
            return f"{words.value(target)} = {words.value(value)}"
    raise CannotSayError("storing a value there")


def _angle_stored(words: Words, base: Expression, name: str, value: Expression) -> str:
    """One angle of a pose changed: all six components anew."""
    parts = [Member(base, part) for part in ("x", "y", "z")]
    angles = [value if part == name else Member(base, part) for part in ("rx", "ry", "rz")]
    return f"{words.value(base)} = {words.helper('olp_pose', (*parts, *angles))[0]}"


def _assign(words: Words, s: Assign) -> Lines:
    return [store(words, s.target, s.value)]


def _update(words: Words, s: Update) -> Lines:
    if s.operand is None or s.operator not in "+-*/" or isinstance(s.target, Variable):
        raise CannotSayError(called.operation(s.operator))
    return [store(words, s.target, Binary(s.operator, s.target, s.operand))]


def _declare(words: Words, s: Declare) -> Lines:
    if words.own:
        return [] if s.value is None else [declared(words, s, "local " if s.native == "local" else "")]
    return [declared(words, s, "local ")]


# --- blocks ---------------------------------------------------------------------------------------------


def _if(words: Words, s: If) -> Lines:
    return [f"if ({words.value(s.condition)}):"]


def _else_if(words: Words, s: ElseIf) -> Lines:
    return [f"elif ({words.value(s.condition)}):"]


def _while(words: Words, s: While) -> Lines:
    return [f"while ({words.value(s.condition)}):"]


def _fixed(text: str) -> Callable[[Words, Any], Lines]:
    return lambda words, s: [text]


def _nothing(words: Words, s: Statement) -> Lines:
    return []


def _wait(words: Words, s: Wait) -> Lines:
    condition = words.at_least(inverted(s.condition), 4)
    idle = "sleep(get_steptime())" if words.own and s.spelling == "sleep" else "sync()"
    if s.timeout is None:
        return [f"while ({condition}):", f"  {idle}", "end"]
    left = helpers.COUNTER
    return [
        f"{left} = {words.quantity(s.timeout)}",
        f"while ({left} > 0 and {condition}):",
        f"  {idle}",
        f"  {left} = {left} - get_steptime()",
        "end",
    ]


# --- signals, time, messages ----------------------------------------------------------------------------


def _output(words: Words, s: SetOutput) -> Lines:
    word = builtins.OUTPUT_WORDS.get(s.signal.bus)
    if word is None or type(s.signal.index) is Text:
        raise CannotSayError(*called.signal(s.signal))
    if s.signal.bus == "out" and type(s.signal.index) is Number and s.signal.index.value >= _STANDARD_SIGNALS:
        word = word.replace("_standard", "")
    value = s.value
    if s.signal.bus != "analog-out" and value in (Number(0), Number(1)):
        value = State(value == Number(1))
    return [f"{word}({words.value(s.signal.index)}, {words.value(value)})"]


def _read(words: Words, s: ReadInput) -> Lines:
    assert isinstance(s.signal, Signal)
    return [store(words, s.target, s.signal)]


def _dwell(words: Words, s: Dwell) -> Lines:
    return [f"sleep({words.quantity(s.duration)})"]


def _message(words: Words, s: Message) -> Lines:
    text = s.text
    if words.own and type(text) is Function and text.name == "joined-text" and len(text.arguments) == 2:
        return [f"textmsg({words.arguments(text.arguments)})"]
    return [f"textmsg({words.value(text)})"]


def popup(words: Words, options: Process | None, message: Message, blocking: bool) -> str:
    """popup(text, options …): of one or two statements that belong to it."""
    given = [] if options is None else [f"{name}={words.value(value)}" for name, value in options.arguments]
    more = ["blocking=True"] if blocking else []
    return f"popup({', '.join([words.value(message.text), *given, *more])})"


def _pause(words: Words, s: Pause) -> Lines:
    if s.condition is not None:
        raise CannotSayError("a pause under a condition")
    return ['popup("", blocking=True)']


# --- calls and threads ----------------------------------------------------------------------------------


def _call(words: Words, s: Call) -> Lines:
    if s.jump or s.macro is not None or s.condition is not None:
        raise CannotSayError("a call that does not come back, or a macro")
    text = f"{s.routine}({words.arguments(s.arguments)})"
    if s.result is None:
        return [text]
    match s.result:
        case Named(name):
            return [f"{name} = {text}"]
        case Item(base, _) if words.kind(base) != "joints":
            return [f"{words.element(s.result)} = {text}"]
        case Member(base, name) if words.kind(base) not in ("", "position"):
            return [f"{words.value(base)}.{name} = {text}"]
        case Member(base, name) if name.startswith("rotation"):
            return [f"{words.value(base)}[{_POSITIONS[name]}] = {text}"]
    raise CannotSayError("storing the result of a call there")


def _return(words: Words, s: Return) -> Lines:
    if s.condition is not None:
        raise CannotSayError("a return under a condition")
    if words.own and s.spelling == "halt":
        return ["halt"]
    return ["return" if s.value is None else f"return {words.value(s.value)}"]


def _start(words: Words, s: StartTask) -> Lines:
    if s.condition is not None or s.synchronised:
        raise CannotSayError("a task that keeps step with this one")
    handle = f"{s.task} = " if s.task and (words.own or s.task.isidentifier()) else ""
    return [f"{handle}run {s.routine}()"]


def _wait_task(words: Words, s: WaitTask) -> Lines:
    return [f"join {s.task}"]


def _process(words: Words, s: Process) -> Lines:
    if not words.own:
        raise CannotSayError(f"the instruction {s.name}")
    match s.name:
        case "kill" | "run":
            return [f"{s.name} {words.value(s.arguments[0][1])}"]
        case "halt" | "enter_critical" | "exit_critical":
            return [s.name]
        case "sync" if s.arguments:
            return ["sleep(get_steptime())"]
    given = [f"{name}={words.value(value)}" if name else words.value(value) for name, value in s.arguments]
    return [f"{s.name}({', '.join(given)})"]


def _opaque(words: Words, s: Opaque) -> Lines:
    if not words.own:
        raise CannotSayError("a line that only its own language understands")
    return [s.text]


def _tool(words: Words, s: SetTool) -> Lines:
    return [f"set_tcp({tool(words, s.tool)})"]


def tool(words: Words, e: Expression) -> str:
    """The arguments of set_tcp."""
    from olp.expression import PositionLiteral

    text = words.value(e)
    name = dict(e.native).get("name", "") if words.own and type(e) is PositionLiteral else ""
    return f'{text}, "{name}"' if name else text


def comment(words: Words, s: Comment) -> Lines:
    """A comment on a line of its own, or a mark of PolyScope."""
    text = " ".join(s.text.splitlines())
    if words.own:
        return [text if text.startswith("$") else f"#{text}"]
    return [f"# {text.strip()}".rstrip()]


_SPELL: Final[Mapping[type, Callable[[Words, Any], Lines]]] = {
    Assign: _assign,
    Begin: _nothing,
    Break: _fixed("break"),
    Call: _call,
    Comment: comment,
    Continue: _fixed("continue"),
    Declare: _declare,
    Disabled: lambda words, s: [f"# {s.text}"],
    Dwell: _dwell,
    Else: _fixed("else:"),
    ElseIf: _else_if,
    End: _nothing,
    EndIf: _fixed("end"),
    EndWhile: _fixed("end"),
    If: _if,
    Message: _message,
    Opaque: _opaque,
    Pause: _pause,
    Process: _process,
    ReadInput: _read,
    Return: _return,
    SetOutput: _output,
    SetTool: _tool,
    StartTask: _start,
    Update: _update,
    Wait: _wait,
    WaitTask: _wait_task,
    While: _while,
}
