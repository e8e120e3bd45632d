"""INFORM's words for numbers, variables and units, as neutral expressions. Equal texts share one object."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Final

from olp.core.units import deg, mm, percent, um
from olp.ir.expressions import Expression, Number, Quantity, Store, Taught, Variable
from olp.ir.program import Speed, SpeedUnit

STORES: Final = {
    "B": Store.BYTE,
    "I": Store.INTEGER,
    "D": Store.DOUBLE,
    "R": Store.REAL,
    "S": Store.STRING,
    "P": Store.ROBOT,
    "BP": Store.BASE,
    "EX": Store.STATION,
    "PX": Store.SYSTEM,
}
# `E000` is the ERC generation's word for a station's taught point.
TAUGHT_STORES: Final = {"C": Store.ROBOT, "BC": Store.BASE, "EC": Store.STATION, "E": Store.STATION}

_COUNTED = frozenset({Store.BYTE, Store.INTEGER, Store.DOUBLE})
_KIND_AND_INDEX = re.compile(r"(L?)([A-Z]+?)(\d+)")

# SI value of one written unit: (as a literal, from a counted variable). V = I003 in 0.1 mm/s is stated in
# a published job; the other variable scales follow the controller's own resolution and are inferred.
SPEEDS: Final = {
    "V": (SpeedUnit.TRAVEL, mm, 0.1 * mm),
    "VJ": (SpeedUnit.FRACTION, percent, 0.01 * percent),
    "VR": (SpeedUnit.TURN, deg, 0.1 * deg),
}
TIME: Final = (1.0, 0.01)  # [s]
DISTANCE: Final = (mm, um)  # [m]
RATE: Final = (percent, percent)  # ACC=, DEC= [1]
LEVEL: Final = (1.0, 1.0)


@lru_cache(maxsize=20_000)
def number(text: str) -> Number:
    """`12` is an integer, `12.` and `12.0` are reals."""
    return Number(float(text) if "." in text else int(text))


@lru_cache(maxsize=20_000)
def variable(text: str) -> Variable:
    """`LD007` as a variable."""
    match = _KIND_AND_INDEX.fullmatch(text)
    assert match is not None, text
    return Variable(STORES[match[2]], number(str(int(match[3]))), local=bool(match[1]))


def taught(text: str) -> Taught:
    """`EC00012` as a taught position."""
    kind = text.rstrip("0123456789")
    return Taught(TAUGHT_STORES[kind], int(text[len(kind) :]))


def quantity(written: Expression, scales: tuple[float, float]) -> Quantity:
    """A value with its unit. `scales`: SI per written unit as a literal, and from a counted variable."""
    literal, counted = scales
    if type(written) is Number:
        return Quantity(written, literal)
    if type(written) is Variable and written.store not in _COUNTED:
        return Quantity(written, literal)
    return Quantity(written, counted)


def speed(tag: str, written: Expression) -> Speed:
    """`tag`: V, VJ or VR."""
    unit, literal, counted = SPEEDS[tag]
    return Speed(unit, quantity(written, (literal, counted)))


@lru_cache(maxsize=20_000)
def literal_speed(text: str) -> Speed:
    """`V=187.0` as a speed."""
    tag, value = text.split("=")
    return speed(tag, number(value))
