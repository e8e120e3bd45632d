"""What a program uses of its numbered variables: which numbers, as what, and whether they ever hold a fraction."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from olp.ir.expressions import (
    Argument,
    Binary,
    Expression,
    Function,
    Number,
    Store,
    Unary,
    Variable,
)
from olp.ir.program import (
    Assign,
    Clear,
    Program,
    ReadInput,
    Routine,
    Statement,
    Update,
)
from olp.ir.transformer import expressions_of

TYPES: Final = {
    Store.BYTE: "integer",
    Store.INTEGER: "integer",
    Store.DOUBLE: "integer",
    Store.REAL: "real",
    Store.STRING: "string",
    Store.ROBOT: "position",
}


def numbered(program: Program, store: Store) -> set[int]:
    """Numbers of the global variables of a kind that a program names."""
    return {
        int(e.index.value)
        for s in program.statements()
        for e in expressions_of(s)
        if type(e) is Variable and e.store is store and not e.local and type(e.index) is Number
    }


def arguments_of(routine: Routine, expressions: list[Expression]) -> tuple[Store | None, ...]:
    """What a routine takes: as its header says, else as its body, with these expressions, reads."""
    read = [e.number for e in expressions if type(e) is Argument]
    count = max((len(routine.arguments), *read))
    kinds = {
        s.value.number: s.target.store
        for s in routine.body
        if type(s) is Assign and type(s.value) is Argument and type(s.target) is Variable
    }
    said = len(routine.arguments)
    return (*routine.arguments, *(kinds.get(number) for number in range(said + 1, count + 1)))


def whole_registers(statements: Iterable[Statement]) -> frozenset[int]:
    """Numbers of the real registers that only ever get whole values, so that they can count."""
    assigned: dict[int, list[Expression | None]] = {}
    for s in statements:
        target = getattr(s, "target", None) if isinstance(s, (Assign, Update, ReadInput, Clear)) else None
        if target is None:
            target = getattr(s, "variable", None)
        if isinstance(target, Variable) and target.store is Store.REAL and isinstance(target.index, Number):
            values = assigned.setdefault(int(target.index.value), [])
            if isinstance(s, Assign):
                values.append(s.value)
            elif isinstance(s, Update):
                values.append(Binary(s.operator, s.target, s.operand) if s.operand is not None else None)
            else:
                values.append(Number(0))
    whole = set(assigned)
    while True:
        kept = {n for n in whole if all(_is_whole(value, whole) for value in assigned[n])}
        if kept == whole:
            return frozenset(whole)
        whole = kept


def _is_whole(e: Expression | None, whole: set[int]) -> bool:
    match e:
        case Number(value):
            return isinstance(value, int) or float(value).is_integer()
        case Variable(Store.REAL, Number(index)):
            return int(index) in whole
        case Variable(store):
            return TYPES.get(store) == "integer"
        case Unary("-", operand):
            return _is_whole(operand, whole)
        case Binary(operator, left, right):
            return operator in ("div", "mod") or (
                operator in "+-*" and _is_whole(left, whole) and _is_whole(right, whole)
            )
        case Function(name):
            return name in ("round", "trunc", "floor", "ceil")
        case _:
            return False


def in_units(counts: Expression, scale: int) -> Expression:
    """[mm] or [deg] of the controller's counts."""
    if isinstance(counts, Unary) and counts.operator == "-" and isinstance(counts.operand, Number):
        counts = Number(-counts.operand.value)
    return Number(counts.value / scale) if isinstance(counts, Number) else Binary("/", counts, Number(scale))
