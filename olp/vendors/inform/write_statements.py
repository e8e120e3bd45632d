"""Spells every statement that is no motion: one short function per type, the way back of `statements`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from olp import called
from olp.expression import (
    Argument,
    Binary,
    Element,
    Expression,
    Function,
    Logic,
    Number,
    Signal,
    Store,
    SystemValue,
    Unary,
    Variable,
)
from olp.program import (
    Assign,
    Begin,
    Call,
    Case,
    Clear,
    Comment,
    Default,
    DefineFrame,
    Disabled,
    Dwell,
    Else,
    ElseIf,
    End,
    EndIf,
    EndSwitch,
    EndWhile,
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
    Return,
    SetOutput,
    ShiftOff,
    ShiftOn,
    StartTask,
    Statement,
    Switch,
    Synchronise,
    Update,
    Wait,
    WaitTask,
    While,
)
from olp.vendors.inform import values
from olp.vendors.inform.statements import FUNCTIONS
from olp.vendors.inform.write_values import CannotSayError, Words, decimal, is_simple

_FUNCTION_WORDS: Final = {name: word for word, name in FUNCTIONS.items()}
_UPDATES: Final = {
    "+": "ADD",
    "-": "SUB",
    "*": "MUL",
    "/": "DIV",
    "and": "AND",
    "or": "OR",
    "xor": "XOR",
    "not": "NOT",
}
_STEPS = {"+": "INC", "-": "DEC"}
_COUNTED = (Store.BYTE, Store.INTEGER, Store.DOUBLE)


def _suffix(words: Words, condition: Expression | None, spelling: str) -> str:
    """` IF …` or ` IFEXPRESS …`, or nothing."""
    if condition is None:
        return ""
    express = spelling == "IFEXPRESS" or (not spelling and not is_simple(condition))
    return f" {'IFEXPRESS' if express else 'IF'} {words.condition(condition, express)}"


def _block(word: str) -> Callable[[Words, Any], str]:
    """IFTHEN, ELSEIF and WHILE, each with a form for expressions."""

    def spell(words: Words, s: If | ElseIf | While) -> str:
        express = s.spelling.endswith("EXP") or (not s.spelling and not is_simple(s.condition))
        return f"{word}{'EXP' if express else ''} {words.condition(s.condition, express)}"

    return spell


# --- values ---------------------------------------------------------------------------------------------


def _assign(words: Words, s: Assign) -> str:
    if type(s.target) is Element:
        element = f"{words.value(s.target.variable)} ({words.value(s.target.index)})"
        return f"SETE {element} {words.value(s.value)}"
    if type(s.target) is Function:
        return f"SETTOOL TL#({words.value(_only(s.target, 'tool-data'))}) {words.value(s.value)}"
    target = words.value(s.target)
    match s.value:
        case Element(variable, index):
            return f"GETE {target} {words.position(variable)} ({words.value(index)})"
        case SystemValue():
            return f"GETS {target} {words.system(s.value)}"
        case Argument(number):
            return f"GETARG {target} IARG#({number})"
        case Signal() if s.value.bus == "register":
            return f"GETREG {target} {_register(words, s.value)}"
        case Function():
            return _function(words, target, s.value)
        case Binary() | Unary() | Signal():
            return f"SET {target}  EXPRESS {words.expression(s.value)}"
        case _:
            return f"SET {target} {words.value(s.value)}"


def _function(words: Words, target: str, function: Function) -> str:
    name, arguments = function.name, function.arguments
    if name == "tool-data":
        return f"GETTOOL {target} TL#({words.value(_only(function, name))})"
    if name == "step-position":
        return f"GETPOS {target} STEP#({words.value(_only(function, name))})"
    if name == "parameter" and len(arguments) == 2:
        return f"GETPRM {target} KIND={words.value(arguments[0])} PRMNO={words.value(arguments[1])}"
    if name not in _FUNCTION_WORDS:
        raise CannotSayError(called.function(name))
    return " ".join([_FUNCTION_WORDS[name], target, *map(words.value, arguments)])


def _only(function: Function, name: str) -> Expression:
    if function.name != name or len(function.arguments) != 1:
        raise CannotSayError(f"{called.function(function.name)} in this place")
    return function.arguments[0]


def _register(words: Words, signal: Signal) -> str:
    return f"{words.signal(signal)}{f' {signal.part.upper()}' if signal.part else ''}"


def _update(words: Words, s: Update) -> str:
    target = words.value(s.target)
    if s.operator in _STEPS and s.operand == Number(1) and _counts(s.target):
        return f"{_STEPS[s.operator]} {target}"
    if s.operator not in _UPDATES or s.operand is None:
        raise CannotSayError(called.operation(s.operator))
    return f"{_UPDATES[s.operator]} {target} {words.value(s.operand)}"


def _counts(target: Expression) -> bool:
    return type(target) is Variable and target.store in _COUNTED


def _clear(words: Words, s: Clear) -> str:
    if s.target is None:
        return "CLEAR STACK"
    return f"CLEAR {words.value(s.target)} {'ALL' if s.count is None else words.value(s.count)}"


# --- frames ---------------------------------------------------------------------------------------------


def _define_frame(words: Words, s: DefineFrame) -> str:
    points = map(words.position, s.points)
    return " ".join(["MFRAME", words.frame(s.frame), *points, *(["MTOOL"] if s.master_tool else [])])


def _shift_on(words: Words, s: ShiftOn) -> str:
    frame = "" if s.frame is None else f" {words.frame(s.frame)}"
    return f"{'S' if s.coordinated else ''}SFTON {words.position(s.offset)}{frame}"


def _shift_off(_: Words, s: ShiftOff) -> str:
    return "SSFTOF" if s.coordinated else "SFTOF"


def _external_tool(words: Words, s: ExternalTool) -> str:
    return "TCPOF" if s.tool is None else f"TCPON TL#({words.value(s.tool)})"


# --- signals and time -----------------------------------------------------------------------------------


def _set_output(words: Words, s: SetOutput) -> str:
    if s.signal.bus == "register":
        return f"SETREG {_register(words, s.signal)} {words.value(s.value)}"
    word = "AOUT" if s.signal.bus == "analog-out" else "DOUT"
    return f"{word} {words.signal(s.signal)} {words.value(s.value)}"


def _pulse(words: Words, s: PulseOutput) -> str:
    time = "" if s.duration is None else f" T={words.quantity(s.duration, values.TIME, 2)}"
    return f"PULSE {words.signal(s.signal)}{time}{_suffix(words, s.condition, s.spelling)}"


def _wait(words: Words, s: Wait) -> str:
    express = s.spelling == "FOREXPRESS" or (not s.spelling and type(s.condition) is Logic)
    time = "" if s.timeout is None else f" T={words.quantity(s.timeout, values.TIME, 2)}"
    return f"WAIT {'FOREXPRESS ' if express else ''}{words.condition(s.condition, express)}{time}"


# --- control flow ---------------------------------------------------------------------------------------


def _jump(words: Words, s: Jump) -> str:
    target = f"*{s.target}" if isinstance(s.target, str) else f"LABEL: {words.value(s.target)}"
    return f"JUMP {target}{_suffix(words, s.condition, s.spelling)}"


def _call(words: Words, s: Call) -> str:
    if s.macro is not None:
        text = f"MACRO1 MJ#({words.value(s.macro)})"
    else:
        text = f"{'JUMP' if s.jump else 'CALL'} JOB:{s.routine}"
    arguments = "".join(f" ARGF{words.value(argument)}" for argument in s.arguments)
    return f"{text}{arguments}{_suffix(words, s.condition, s.spelling)}"


def _return(words: Words, s: Return) -> str:
    value = "" if s.value is None else f" {words.value(s.value)}"
    return f"RET{value}{_suffix(words, s.condition, s.spelling)}"


def _for(words: Words, s: For) -> str:
    step = "" if s.step is None else f" STEP= {words.value(s.step)}"
    start, stop = words.value(s.start), words.value(s.stop)
    return f"FOR {words.value(s.variable)} START= {start} TO {stop}{step}"


def _next(words: Words, s: Next) -> str:
    return "NEXT" if s.variable is None else f"NEXT {words.value(s.variable)}"


# --- operator, tasks, process ---------------------------------------------------------------------------


def _start_task(words: Words, s: StartTask) -> str:
    if not s.task:
        raise CannotSayError("a parallel task without a number", "INFORM has the tasks SUB1 and further")
    sync = " SYNC" if s.synchronised else ""
    return f"PSTART JOB:{s.routine} {s.task}{sync}{_suffix(words, s.condition, s.spelling)}"


def _synchronise(words: Words, s: Synchronise) -> str:
    count = "" if s.tasks is None else f" SNUM={words.value(s.tasks)}"
    return f"TSYNC {words.value(s.number)}{count}"


def _process(words: Words, s: Process) -> str:
    return " ".join([s.name, *(_argument(words, tag, value) for tag, value in s.arguments)])


def _argument(words: Words, tag: str, value: Expression) -> str:
    if tag.endswith("#"):
        return f"{tag}({words.value(value)})"
    if tag == "T" and type(value) is Number:
        return f"T={decimal(float(value.value), 2)}"
    return f"{tag}={words.value(value)}" if tag else words.value(value)


SPELLINGS: Final[Mapping[type, Callable[[Words, Any], str]]] = {
    Assign: _assign,
    Update: _update,
    Clear: _clear,
    DefineFrame: _define_frame,
    ShiftOn: _shift_on,
    ShiftOff: _shift_off,
    ExternalTool: _external_tool,
    SetOutput: _set_output,
    PulseOutput: _pulse,
    ReadInput: lambda words, s: f"DIN {words.value(s.target)} {words.signal(s.signal)}",
    Dwell: lambda words, s: f"TIMER T={words.quantity(s.duration, values.TIME, 2)}",
    Wait: _wait,
    Label: lambda _, s: f"*{s.name}",
    Jump: _jump,
    Call: _call,
    Return: _return,
    If: _block("IFTHEN"),
    ElseIf: _block("ELSEIF"),
    Else: lambda _, s: "ELSE",
    EndIf: lambda _, s: "ENDIF",
    While: _block("WHILE"),
    EndWhile: lambda _, s: "ENDWHILE",
    For: _for,
    Next: _next,
    Switch: lambda words, s: f"SWITCH {words.expression(s.value)}",
    Case: lambda words, s: f"CASE {', '.join(map(words.value, s.values))}",
    Default: lambda _, s: "DEFAULT",
    EndSwitch: lambda _, s: "ENDSWITCH",
    Pause: lambda words, s: f"PAUSE{_suffix(words, s.condition, s.spelling)}",
    StartTask: _start_task,
    WaitTask: lambda _, s: f"PWAIT {s.task}",
    Synchronise: _synchronise,
    Message: lambda words, s: f"MSG {words.value(s.text)}",
    Process: _process,
    Comment: lambda _, s: f"'{s.text}",
    Begin: lambda _, s: "NOP",
    End: lambda _, s: "END",
    Disabled: lambda _, s: f"COMM {s.text}",
    Opaque: lambda _, s: s.text,
}
"""One function per statement type; motion is in `write_moves`."""


def vendor_words_only(statement: Statement) -> bool:
    """Whether the statement holds words of its own vendor, which mean nothing elsewhere."""
    return isinstance(statement, (Disabled, Opaque, Process))
