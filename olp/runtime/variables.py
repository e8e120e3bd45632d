"""Reading and storing variables as their kinds hold them."""

from __future__ import annotations

from typing import Final

from olp.ir.expressions import POSITION_STORES, Store
from olp.ir.points import PointKind
from olp.runtime.arithmetic import finite, round_half_away
from olp.runtime.assumptions import VARIABLE_LETTERS
from olp.runtime.memory import INTEGERS, RANGES, PositionValue, SystemPosition, Value, zero
from olp.runtime.state import Machine, StatementError

_POSE_SIZE: Final = 6
_POSITION_PARTS: Final = (Store.ROBOT, Store.BASE, Store.STATION)
_CHECK: Final = "check the value on the right"


def read_variable(m: Machine, store: Store, index: int, local: bool) -> Value:
    """A variable's value; one that nobody ever set holds zero, which is reported."""
    _check_index(index)
    key = (store, index)
    values = m.frame.locals if local else m.memory.values
    value = values.get(key)
    if value is not None:
        return value
    if store is Store.SYSTEM:
        parts = ((part, values.get((part, index))) for part in _POSITION_PARTS)
        held = tuple(
            (part, part_value) for part, part_value in parts if isinstance(part_value, PositionValue)
        )
        if held:
            return SystemPosition(held)
    value = values[key] = zero(store)
    name = f"{'L' if local else ''}{VARIABLE_LETTERS[store]}{index:03d}"
    if store in POSITION_STORES:
        del values[key]
        raise StatementError(
            "I203",
            f"position {name} has no value",
            f"put VAR.DAT beside the job, or say it in olp.toml: [variables] {name} = {{ pulse = [ … ] }}",
        )
    shown = '""' if store is Store.STRING else "0"
    where = "never set before it is read here" if local else "not in VAR.DAT or olp.toml"
    m.assume(f"{name} is taken as {shown}: {where}")
    return value


def store_variable(m: Machine, store: Store, index: int, local: bool, value: Value) -> None:
    """Stores a value as the variable's kind holds it. Raises StatementError when it does not fit."""
    _check_index(index)
    key = (store, index)
    if store is Store.SYSTEM:
        _store_system(m, index, local, value)
        return
    held = coerce(m, store, value)
    if local:
        if m.frame.locals.get(key) != held:
            m.memory.stamp += 1
            m.memory.changed[(store, -1 - index)] = m.memory.stamp
        m.frame.locals[key] = held
    else:
        m.memory.put(key, held)


def _store_system(m: Machine, index: int, local: bool, value: Value) -> None:
    if isinstance(value, PositionValue):  # the result of a pose function: that of the robot
        value = SystemPosition(((Store.ROBOT, value),))
    if not isinstance(value, SystemPosition):
        raise StatementError(
            "I204", "only a whole system position can be stored here", "use a PX variable or $PX000"
        )
    for store, part in value.parts:
        store_variable(m, store, index, local, part)


def coerce(m: Machine, store: Store, value: Value) -> Value:
    """`value` as a variable of kind `store` holds it."""
    if store in INTEGERS:
        return _integer(m, store, value)
    if store is Store.REAL:
        if isinstance(value, (int, float)):
            return finite(float(value))
        raise StatementError("I204", "a real variable holds numbers only", _CHECK)
    if store is Store.STRING:
        return value if isinstance(value, str) else _as_text(value)
    if isinstance(value, PositionValue) and (store is not Store.ROBOT or is_whole(value)):
        return value
    raise StatementError(
        "I204", "a position variable holds positions of its own kind only", "set its elements one by one"
    )


def is_whole(value: PositionValue) -> bool:
    """Whether a pose has all six numbers, as that of a robot must."""
    return value.state.kind is not PointKind.POSE or len(value.values) >= _POSE_SIZE


def _integer(m: Machine, store: Store, value: Value) -> int:
    if isinstance(value, str):
        value = _parsed(value)
    if not isinstance(value, (int, float)):
        raise StatementError("I204", "an integer variable holds numbers only", _CHECK)
    result = value
    if isinstance(value, float):
        result = round_half_away(value)
        if result != value:
            m.assume("a real value is rounded to the nearest integer, halves away from zero")
    low, high = RANGES[store]
    if not low <= result <= high:
        raise StatementError(
            "I205",
            f"{result} does not fit a {store.value} variable ({low} .. {high}): it keeps its value",
            "the controller stops with an alarm here; use a wider variable",
        )
    return int(result)


def _parsed(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise StatementError("I204", f"the text {text[:40]!r} is not a number", _CHECK) from None


def _as_text(value: Value) -> str:
    if isinstance(value, bool):
        return "ON" if value else "OFF"
    if isinstance(value, (int, float)):
        return str(value)
    raise StatementError("I204", "a position cannot become a text", _CHECK)


def _check_index(index: int) -> None:
    if index < 0:
        raise StatementError("I221", f"there is no variable with the index {index}", "indices begin at 0")
