"""Expressions in a few plain words, for messages."""

from __future__ import annotations

from olp.ir.expressions import (
    Argument,
    Binary,
    CallValue,
    Compare,
    Element,
    Expression,
    FrameRef,
    Function,
    Item,
    Logic,
    Member,
    Named,
    NamedArgument,
    Number,
    PositionLiteral,
    RecordLiteral,
    Signal,
    SignalState,
    SystemValue,
    Taught,
    Text,
    Unary,
    Unknown,
    Variable,
)
from olp.runtime.assumptions import VARIABLE_LETTERS

_TAUGHT_LETTERS = {"robot": "C", "base": "BC", "station": "EC"}


def spell(e: Expression) -> str:
    """The expression as a person would say it."""
    match e:
        case Number(value):
            return f"{value:g}" if isinstance(value, float) else str(value)
        case Text(value) | Unknown(value):
            return value[:60]
        case SignalState(on):
            return "on" if on else "off"
        case Variable(store, index, local, name):
            number = index.value if isinstance(index, Number) else None
            place = f"{number:03d}" if isinstance(number, int) else f"[{spell(index)}]"
            return name or f"{'L' if local else ''}{VARIABLE_LETTERS[store]}{place}"
        case Taught(store, number):
            return f"{_TAUGHT_LETTERS.get(store, store)}{number:05d}"
        case Element(variable, index):
            return f"element {spell(index)} of {spell(variable)}"
        case Signal(bus, index):
            return f"{bus.replace('-', ' ')} {spell(index)}"
        case SystemValue(name, index):
            return f"{name} {index}" if index else name
        case Argument(number):
            return f"argument {number}"
        case _:
            return _spell_composed(e)


def _spell_composed(e: Expression) -> str:
    match e:
        case FrameRef(kind, number):
            return f"{kind} frame" + (f" {spell(number)}" if number is not None else "")
        case Unary(operator, operand):
            return f"{operator} {spell(operand)}" if operator == "not" else f"-{spell(operand)}"
        case Binary(operator, left, right) | Compare(operator, left, right):
            return f"{spell(left)} {operator} {spell(right)}"
        case Logic(first, rest):
            return " ".join([spell(first), *(f"{word} {spell(c)}" for word, c in rest)])
        case Function(name, arguments) | CallValue(name, arguments):
            return f"{name}({', '.join(map(spell, arguments))})"
        case _:
            return _spell_named(e)


def _spell_named(e: Expression) -> str:
    """What languages have whose variables have names."""
    match e:
        case Named(name):
            return name
        case Item(base, indices):
            return f"{spell(base)}[{', '.join(map(spell, indices))}]"
        case Member(base, name):
            return f"{spell(base)}.{name}"
        case PositionLiteral(kind):
            return "a position" if kind == "pose" else "axis values"
        case RecordLiteral(kind, members):
            return kind or f"{len(members)} values"
        case NamedArgument(name, value):
            return name if value is None else f"{name} = {spell(value)}"
        case _:
            return str(e)
