"""True and false in AS, which has numbers for them: a condition holds unless it is 0, and TRUE and ON are -1."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import expressions_of, mapped

_ARITHMETIC: Final = (ex.Number, ex.Binary, ex.Quantity)
_ROUNDS: Final = 4  # of variables that are set to variables


def with_truths(
    routines: list[st.Routine], data: Mapping[str, st.Declare]
) -> tuple[list[st.Routine], set[str]]:
    """Conditions that are numbers as comparisons with 0; the names that only ever hold true or false, case folded.

    `data`: of the tables, by the folded name.
    """
    logical = _logical_names(routines, data)

    def is_number(e: ex.Expression) -> bool:
        base = e.base if isinstance(e, ex.Item) else e
        if isinstance(base, ex.Named):
            name = base.name.casefold()
            return not name.startswith(("$", ".$")) and name not in logical
        return isinstance(e, (*_ARITHMETIC, ex.Function)) or (
            (isinstance(e, ex.Unary) and e.operator == "-") or _is_group(e)
        )

    def truth(e: Any) -> Any:
        if isinstance(e, ex.Number):
            return ex.SignalState(e.value != 0)
        return ex.Compare("<>", e, ex.Number(0)) if is_number(e) else e

    def number(e: ex.Expression) -> ex.Expression:
        """What is true or false as the number that it is here: -1 and 0."""
        if isinstance(e, ex.SignalState):
            return ex.Number(-1 if e.on else 0)
        return ex.Unary("-", e) if not is_number(e) and _is_logical(e, logical) else e

    def inner(e: ex.Expression) -> ex.Expression:
        match e:
            case ex.Binary(_, left, right) if (sides := (number(left), number(right))) != (left, right):
                return replace(e, left=sides[0], right=sides[1])
            case ex.Unary("-", operand) if number(operand) is not operand:
                return ex.Binary("-", ex.Number(0), number(operand))
            case ex.Item(_, indices) if any(number(one) is not one for one in indices):
                return replace(e, indices=tuple(map(number, indices)))
            case ex.Logic(first, rest):
                parts = tuple((word, truth(one)) for word, one in rest)
                return e if truth(first) is first and parts == rest else ex.Logic(truth(first), parts)
            case ex.Unary("not", operand):
                return e if truth(operand) is operand else ex.Unary("not", truth(operand))
            case ex.Compare(operator, left, right):
                sides = tuple(
                    number(one) if operator not in ("=", "<>") or is_number(other) else one
                    for one, other in ((left, right), (right, left))
                )
                return e if sides == (left, right) else ex.Compare(operator, *sides)
        return e

    def changed(s: st.Statement) -> st.Statement:
        s = mapped(s, inner)
        condition = getattr(s, "condition", None)
        if condition is not None and truth(condition) is not condition:
            s = replace(s, condition=truth(condition))  # type: ignore[call-arg]
        if isinstance(s, st.Assign) and is_number(s.target) and number(s.value) is not s.value:
            s = replace(s, value=number(s.value))
        if isinstance(s, st.Call) and any(number(one) is not one for one in s.arguments):
            s = replace(s, arguments=tuple(map(number, s.arguments)))
        return s

    return [replace(r, body=tuple([changed(s) for s in r.body])) for r in routines], logical


def _is_group(e: ex.Expression) -> bool:
    return isinstance(e, ex.Signal) and e.bus.endswith("-group")


def _logical_names(routines: list[st.Routine], data: Mapping[str, st.Declare]) -> set[str]:
    """Variables that get nothing but true and false, and that nothing takes for a number."""
    values: dict[str, list[ex.Expression]] = {}
    numbers = {p.name.casefold() for r in routines for p in r.parameters} | data.keys()
    for s in (s for r in routines for s in r.body):
        if isinstance(s, st.Assign) and isinstance(s.target, ex.Named):
            values.setdefault(s.target.name.casefold(), []).append(s.value)
        elif isinstance(s, st.Assign):
            numbers |= _names(s.target)
        numbers |= set(_taken_for_numbers(s))
    found = {name for name in values if name not in numbers}
    for _ in range(_ROUNDS):
        found = {name for name in found if all(_is_logical(value, found) for value in values[name])}
    return found


def _is_logical(e: ex.Expression, logical: set[str]) -> bool:
    if isinstance(e, ex.Named):
        return e.name.casefold() in logical
    plain = isinstance(e, ex.Signal) and not _is_group(e) and not e.bus.startswith("analog")
    return (
        plain
        or isinstance(e, (ex.SignalState, ex.Compare, ex.Logic))
        or (isinstance(e, ex.Unary) and e.operator == "not")
    )


def _taken_for_numbers(s: st.Statement) -> Iterator[str]:
    """Folded names of variables that a statement takes for a number: in sums, indices, arguments, comparisons."""
    if not isinstance(s, (st.Assign, st.If, st.ElseIf, st.While, st.Until, st.Wait, st.Jump)):
        yield from _names(s)
        return
    for e in expressions_of(s):
        match e:
            case ex.Binary() | ex.Function() | ex.CallValue() | ex.Unary("-"):
                yield from _names(e)
            case ex.Item(_, indices):
                for index in indices:
                    yield from _names(index)
            case ex.Compare(operator, left, right):
                plain = operator in ("=", "<>") and not any(
                    isinstance(one, _ARITHMETIC) for one in (left, right)
                )
                for one in () if plain else (left, right):
                    yield from _names(one)


def _names(node: Any) -> set[str]:
    found = {e.name.casefold() for e in expressions_of(node) if isinstance(e, ex.Named)}
    return found | ({node.name.casefold()} if isinstance(node, ex.Named) else set())
