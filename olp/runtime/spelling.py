"""Expressions in a few plain words, for messages."""

from __future__ import annotations

from olp.ir import expressions as ex
from olp.runtime.assumptions import VARIABLE_LETTERS

_TAUGHT_LETTERS = {"robot": "C", "base": "BC", "station": "EC"}


def spell(e: ex.Expression) -> str:
    """The expression as a person would say it."""
    match e:
        case ex.Number(value):
            return f"{value:g}" if isinstance(value, float) else str(value)
        case ex.Text(value) | ex.Unknown(value):
            return value[:60]
        case ex.SignalState(on):
            return "on" if on else "off"
        case ex.Variable(store, index, local, name):
            number = index.value if isinstance(index, ex.Number) else None
            place = f"{number:03d}" if isinstance(number, int) else f"[{spell(index)}]"
            return name or f"{'L' if local else ''}{VARIABLE_LETTERS[store]}{place}"
        case ex.Taught(store, number):
            return f"{_TAUGHT_LETTERS.get(store, store)}{number:05d}"
        case ex.Element(variable, index):
            return f"element {spell(index)} of {spell(variable)}"
        case ex.Signal(bus, index):
            return f"{bus.replace('-', ' ')} {spell(index)}"
        case ex.SystemValue(name, index):
            return f"{name} {index}" if index else name
        case ex.Argument(number):
            return f"argument {number}"
        case _:
            return _spell_composed(e)


def _spell_composed(e: ex.Expression) -> str:
    match e:
        case ex.FrameRef(kind, number):
            return f"{kind} frame" + (f" {spell(number)}" if number is not None else "")
        case ex.Unary(operator, operand):
            return f"{operator} {spell(operand)}" if operator == "not" else f"-{spell(operand)}"
        case ex.Binary(operator, left, right) | ex.Compare(operator, left, right):
            return f"{spell(left)} {operator} {spell(right)}"
        case ex.Logic(first, rest):
            return " ".join([spell(first), *(f"{word} {spell(c)}" for word, c in rest)])
        case ex.Function(name, arguments) | ex.CallValue(name, arguments):
            return f"{name}({', '.join(map(spell, arguments))})"
        case _:
            return _spell_named(e)


def _spell_named(e: ex.Expression) -> str:
    """What languages have whose variables have names."""
    match e:
        case ex.Named(name):
            return name
        case ex.Item(base, indices):
            return f"{spell(base)}[{', '.join(map(spell, indices))}]"
        case ex.Member(base, name):
            return f"{spell(base)}.{name}"
        case ex.PositionLiteral(kind):
            return "a position" if kind == "pose" else "axis values"
        case ex.RecordLiteral(kind, members):
            return kind or f"{len(members)} values"
        case ex.NamedArgument(name, value):
            return name if value is None else f"{name} = {spell(value)}"
        case _:
            return str(e)
