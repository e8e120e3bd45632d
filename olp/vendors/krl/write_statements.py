"""Spells every statement that is no motion: one short function per type, the way back of `statements`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from olp import called
from olp.expression import Expression, State, Text, Unary
from olp.program import (
    Assign,
    Break,
    Call,
    Case,
    Comment,
    Default,
    Dwell,
    Else,
    EndIf,
    EndSwitch,
    ExternalTool,
    For,
    If,
    Jump,
    Label,
    Message,
    Next,
    Opaque,
    Pause,
    Process,
    PulseOutput,
    ReadInput,
    Repeat,
    Return,
    SetOutput,
    Switch,
    Until,
    Update,
    Wait,
    While,
)
from olp.vendors.krl.write_values import CannotSayError, Words

_UPDATES: Final = {
    "+": "+",
    "-": "-",
    "*": "*",
    "/": "/",
    "and": " B_AND ",
    "or": " B_OR ",
    "xor": " B_EXOR ",
}
_POLL = "0.012"  # [s] the interpolation cycle
_PULSE = "0.3"  # [s] of a pulse that names no time


def _guarded(words: Words, condition: Expression | None, lines: list[str]) -> list[str]:
    if condition is None:
        return lines
    return [f"IF {words.expression(condition)} THEN", *(f"  {line}" for line in lines), "ENDIF"]


def _assign(words: Words, s: Assign) -> list[str]:
    return [f"{words.name(s.target)}={words.expression(s.value)}"]


def _update(words: Words, s: Update) -> list[str]:
    target = words.name(s.target)
    if s.operator == "not" or s.operand is None:
        return [f"{target}=B_NOT {words.expression(s.operand or s.target, 13)}"]
    if s.operator not in _UPDATES:
        raise CannotSayError(called.operation(s.operator))
    return [f"{target}={target}{_UPDATES[s.operator]}{words.expression(s.operand, 12)}"]


def _output(words: Words, s: SetOutput) -> list[str]:
    return [f"{words.signal(s.signal)}={words.expression(s.value)}"]


def _pulse(words: Words, s: PulseOutput) -> list[str]:
    time = _PULSE if s.duration is None else words.quantity(s.duration, 1.0)
    state, condition = "FALSE" if s.spelling == "FALSE" else "TRUE", s.condition
    if words.own and condition is not None:
        state, condition = words.expression(condition), None
    return _guarded(words, condition, [f"PULSE ({words.signal(s.signal)},{state},{time})"])


def _wait(words: Words, s: Wait) -> list[str]:
    if s.timeout is None:
        return [f"WAIT FOR {words.expression(s.condition)}"]
    condition, limit = words.expression(Unary("not", s.condition)), words.quantity(s.timeout, 1.0)
    return [
        "WAITED=0.0",
        f"WHILE {condition} AND (WAITED<{limit})",
        f"  WAIT SEC {_POLL}",
        f"  WAITED=WAITED+{_POLL}",
        "ENDWHILE",
        f"TIMED_OUT={condition}",
    ]


def _jump(words: Words, s: Jump) -> list[str]:
    if not isinstance(s.target, str):
        raise CannotSayError("a jump to a computed label", "write it as SWITCH")
    return _guarded(words, s.condition, [f"GOTO {s.target}"])


def _call(words: Words, s: Call) -> list[str]:
    if s.macro is not None:
        raise CannotSayError("a macro by its number")
    text = f"{s.routine} ({words.arguments(s.arguments)})"
    lines = [text if s.result is None else f"{words.name(s.result)}={text}"]
    return _guarded(words, s.condition, [*lines, "RETURN"] if s.jump else lines)


def _return(words: Words, s: Return) -> list[str]:
    line = "RETURN" if s.value is None else f"RETURN {words.expression(s.value)}"
    return _guarded(words, s.condition, [line])


def _while(words: Words, s: While) -> list[str]:
    return ["LOOP" if s.condition == State(True) else f"WHILE {words.expression(s.condition)}"]


def _for(words: Words, s: For) -> list[str]:
    step = "" if s.step is None else f" STEP {words.expression(s.step)}"
    text = f"FOR {words.name(s.variable)}={words.expression(s.start)} TO {words.expression(s.stop)}"
    return [text + step]


def _process(words: Words, s: Process) -> list[str]:
    if not words.own:
        raise CannotSayError(f"the process instruction {s.name}")
    if s.name == "TIME_BLOCK":
        value = [words.expression(one) for word, one in s.arguments if word == "="]
        shown = words.expression(s.arguments[0][1])
        return [f"TIME_BLOCK {shown}{'=' + value[0] if value else ''}"]
    if not s.arguments:
        return [s.name]
    text = s.arguments[0][1]
    assert isinstance(text, Text)
    return [text.value]


def _message(words: Words, s: Message) -> list[str]:
    return [f"MsgNotify({words.expression(s.text)})"]


def _opaque(words: Words, s: Opaque) -> list[str]:
    if not words.own:
        raise CannotSayError("a statement of another language")
    return [s.text]


def _pause(words: Words, s: Pause) -> list[str]:
    return _guarded(words, s.condition, ["HALT"])


SPELLINGS: Final[dict[type, Callable[[Words, Any], list[str]]]] = {
    Assign: _assign,
    Update: _update,
    SetOutput: _output,
    PulseOutput: _pulse,
    ReadInput: lambda words, s: [f"{words.name(s.target)}={words.signal(s.signal)}"],
    Dwell: lambda words, s: [f"WAIT SEC {words.quantity(s.duration, 1.0)}"],
    Wait: _wait,
    Label: lambda _, s: [f"{s.name}:"],
    Jump: _jump,
    Call: _call,
    Return: _return,
    If: lambda words, s: [f"IF {words.expression(s.condition)} THEN"],
    Else: lambda _, s: ["ELSE"],
    EndIf: lambda _, s: ["ENDIF"],
    While: _while,
    For: _for,
    Next: lambda _, s: ["ENDFOR"],
    Repeat: lambda _, s: ["REPEAT"],
    Until: lambda words, s: [f"UNTIL {words.expression(s.condition)}"],
    Break: lambda _, s: ["EXIT"],
    Switch: lambda words, s: [f"SWITCH {words.expression(s.value)}"],
    Case: lambda words, s: [f"CASE {words.arguments(s.values)}"],
    Default: lambda _, s: ["DEFAULT"],
    EndSwitch: lambda _, s: ["ENDSWITCH"],
    Pause: _pause,
    Message: _message,
    ExternalTool: lambda _, s: [f"$IPO_MODE={'#BASE' if s.tool is None else '#TCP'}"],
    Process: _process,
    Comment: lambda _, s: [f";{s.text}"],
    Opaque: _opaque,
}
"""One function per statement type; motion is in `write_moves`, declarations in `write_data`, loop ends in `writer`."""

HELPERS: Final = {"WAITED": "REAL", "TIMED_OUT": "BOOL"}
"""Variables that a wait with a limit uses: name -> type."""
