"""What data begin with, written out: a value that names other data stands before or behind them, as it likes.

RAPID computes constants from each other in any order; KRL's lists hold only what is written out, URScript runs its
declarations one after the other, and registers are set by the program.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from olp.ir.expressions import (
    Binary,
    Expression,
    Item,
    Named,
    Number,
    PositionLiteral,
    Signal,
    SignalState,
    Text,
    Unary,
)
from olp.ir.program import Declare, Program
from olp.ir.transformer import expressions_of, mapped
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.symbols import Symbols, symbols_of

_PLAIN: Final = (Number, Text, SignalState, PositionLiteral, type(None))
_LEFT: Final = (Named, Item, Binary)  # what is not known before the program runs
_DEEPEST: Final = 20  # a value that names a value that names …


def first_values(program: Program, work: TranslationContext) -> Program:
    """All data of the program with literal values."""
    if all(type(d.value) in _PLAIN for d in program.data) and not any(r.data for r in program.routines):
        return program
    symbols = symbols_of(program)
    routines = tuple(
        replace(r, data=tuple(_written(d, symbols, r.name, work) for d in r.data)) if r.data else r
        for r in program.routines
    )
    data = tuple(_written(d, symbols, "", work) for d in program.data)
    return replace(program, routines=routines, data=data)


def _written(s: Declare, symbols: Symbols, routine: str, work: TranslationContext) -> Declare:
    if type(s.value) in _PLAIN or isinstance(s.value, Signal):
        return s
    value: Expression | None = s.value
    for _ in range(_DEEPEST):
        found = mapped(value, lambda e: _known(e, symbols, routine))
        if found == value:
            break
        value = found
    if any(isinstance(e, _LEFT) for e in expressions_of(value)):
        says = f"what {s.name} begins with is computed from values that are not known here"
        work.lose(s, Fate.APPROXIMATED, "value", says)
        work.ask("set what no file here tells the value of", s.name)
        return replace(s, value=None)
    return s if value is s.value else replace(s, value=value)


def _known(e: Expression, symbols: Symbols, routine: str) -> Expression:
    """One step: a name as what it always is, an operation on numbers as its result."""
    match e:
        case Named(name):
            symbol = symbols.find(routine, name)
            fixed = symbol.value if symbol is not None and symbol.is_fixed else None
            return fixed or e
        case Item():
            return symbols.fixed_value(routine, e) or e
        case Unary("-", Number(value)):
            return Number(-value)
        case Unary("not", SignalState(on)):
            return SignalState(not on)
        case Binary(operator, Number(left), Number(right)):
            return _computed(operator, left, right) or e
    return e


def _computed(operator: str, left: float, right: float) -> Number | None:
    match operator:
        case "+":
            return Number(left + right)
        case "-":
            return Number(left - right)
        case "*":
            return Number(left * right)
        case "/" if right:
            return Number(float(f"{left / right:.12g}"))
        case "div" if right:
            return Number(int(left / right))
    return None
