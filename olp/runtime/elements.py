"""Elements of positions and arithmetic on positions, in the controller's own whole units."""

from __future__ import annotations

import math

from olp.core.units import deg, um
from olp.ir.expressions import POSITION_STORES, Binary, Element, Store, Taught, Variable
from olp.ir.points import PointKind, PointState
from olp.runtime.arithmetic import calculate, round_half_away
from olp.runtime.evaluate import both, whole, write_variable
from olp.runtime.memory import PositionValue, Value
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError
from olp.runtime.targets import position_value
from olp.runtime.variables import read_variable

# Poses: micrometres and 0.0001 deg, as a published pallet job proves (300000 for 300 mm, 900000 for 90 deg).
_ANGLE = 1e-4 * deg  # [rad]
_LENGTHS = 3
_SIZE = 6
_FARTHEST = 1e12  # pulses, metres or radians
_MOST_ELEMENTS = 8
_ZERO_POSE = PositionValue(PointState(PointKind.POSE, "base"), (0.0,) * _SIZE)


def unit_of(value: PositionValue, index: int) -> float:
    """SI value of one count of element `index` (from 1)."""
    if value.state.kind is PointKind.PULSE:
        return 1.0
    if value.state.kind is PointKind.JOINT:
        return _ANGLE
    return um if index <= _LENGTHS else _ANGLE


def read_element(m: Machine, element: Element) -> int:
    """One element as the controller counts it. Raises StatementError for one that does not exist."""
    variable = element.variable
    if not isinstance(variable, (Taught, Variable)) or variable.store not in POSITION_STORES:
        raise StatementError("I209", f"{spell(variable)} is no position", "use a position variable")
    value = position_value(m, variable, Store.ROBOT if variable.store is Store.SYSTEM else variable.store)
    index = _index(m, element)
    if index > len(value.values) or math.isnan(value.values[index - 1]):
        return 0  # a seventh element of a six-axis arm reads as zero
    return round_half_away(value.values[index - 1] / unit_of(value, index))


def write_element(m: Machine, element: Element, count: int | float) -> None:
    """Sets one element from the controller's counts."""
    variable = element.variable
    if not isinstance(variable, Variable) or variable.store not in POSITION_STORES:
        raise StatementError("I209", f"{spell(variable)} cannot be changed", "use a position variable")
    if variable.store is Store.SYSTEM:
        variable = Variable(Store.ROBOT, variable.index, variable.local)
    value = held_position(m, variable)
    index = _index(m, element)
    values = list(value.values) + [0.0] * (index - len(value.values))
    values[index - 1] = count * unit_of(value, index)
    write_variable(m, variable, PositionValue(value.state, tuple(values)))


def held_position(m: Machine, variable: Variable) -> PositionValue:
    """The variable's position; one that nobody set is taken as a zero pose, which is reported."""
    index = whole(m, variable.index)
    held = (m.frame.locals if variable.local else m.memory.values).get((variable.store, index))
    if held is None:
        m.assume(f"{spell(variable)} has no value yet: taken as Cartesian, all elements 0, in the base frame")
        return _ZERO_POSE
    value = read_variable(m, variable.store, index, variable.local)
    assert isinstance(value, PositionValue)
    return value


def binary(m: Machine, e: Binary) -> Value:
    """The value of an operation on numbers, texts or positions."""
    left, right = both(m, e.left, e.right)
    if isinstance(left, PositionValue) and isinstance(right, (int, float, PositionValue)):
        return combine(e.operator, left, right)
    return calculate(e.operator, left, right)


def _index(m: Machine, element: Element) -> int:
    index = whole(m, element.index)
    if not 1 <= index <= _MOST_ELEMENTS:
        raise StatementError(
            "I210", f"a position has no element {index}", "write 1 .. 6, or 7 for a seventh axis"
        )
    return index


def combine(sign: str, left: PositionValue, right: PositionValue | int | float) -> PositionValue:
    """Element by element: position + - position, position * / number. Raises StatementError."""
    if isinstance(right, PositionValue):
        if sign not in "+-" or left.state.kind is not right.state.kind:
            raise StatementError(
                "I211",
                "only two positions of the same kind can be added or subtracted",
                "convert one of them first",
            )
        width = max(len(left.values), len(right.values))
        factor = 1.0 if sign == "+" else -1.0
        pairs = zip(_filled(left.values, width), _filled(right.values, width), strict=True)
        return PositionValue(left.state, tuple(a + factor * b for a, b in pairs))
    if sign not in "*/":
        raise StatementError("I211", "a number cannot be added to a position", "set its elements one by one")
    if sign == "/" and right == 0:
        raise StatementError("I207", "division by zero", "the controller stops with an alarm here")
    factor = float(right) if sign == "*" else 1.0 / right
    values = tuple(value * factor for value in left.values)
    if any(abs(value) > _FARTHEST for value in values):
        raise StatementError("I202", "the position lies beyond all space", "check the operands")
    return PositionValue(left.state, values)


def _filled(values: tuple[float, ...], width: int) -> list[float]:
    return [0.0 if math.isnan(v) else v for v in values] + [0.0] * (width - len(values))
