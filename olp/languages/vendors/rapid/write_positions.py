"""Spells positions, tools, work objects and other structures: the way back of `literals`."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Final

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.languages.decimals import all_trimmed
from olp.languages.generator import CannotSayError
from olp.languages.vendors.rapid.literals import confdata

NO_AXES: Final = "[9E9,9E9,9E9,9E9,9E9,9E9]"
NO_CONFIGURATION: Final = "[0,0,0,0]"
_SAME: Final = 1e-9  # how far the cosine of half an angle may be from 1 for two quaternions to be one turn
_TURN_DIGITS: Final = 9
_DIGITS: Final = (4, 9)
_EXACT_DIGITS: Final = (4, 9, 12, 15)


def decimal(value: float, scale: float = 1.0, exact: bool = True) -> str:
    """The number whose `scale`-fold is `value`, with as few digits as give exactly it.

    At most fifteen decimals, nine unless `exact`: values that were computed need no more.
    """
    written = value / scale
    if not math.isfinite(written):
        raise CannotSayError(f"{written} is no number that a program can hold")
    for digits in _EXACT_DIGITS if exact else _DIGITS:
        text = f"{written:.{digits}f}".rstrip("0").rstrip(".")
        if float(text) * scale == value:
            break
    return "0" if text in ("-0", "") else text


def number(value: int | float) -> str:
    """A literal as it stands in an expression: 12 stays whole, 12.0 keeps its point."""
    if isinstance(value, int):
        return str(int(value))
    text = repr(value)
    if not math.isfinite(value):
        raise CannotSayError(f"{value} is no number that a program can hold")
    return text.replace("e", "E")


def quaternion(rx: float, ry: float, rz: float) -> tuple[float, float, float, float]:
    """w x y z, w >= 0, of R = Rz(rz) Ry(ry) Rx(rx) [rad]."""
    cx, sx, cy, sy = math.cos(rx / 2), math.sin(rx / 2), math.cos(ry / 2), math.sin(ry / 2)
    cz, sz = math.cos(rz / 2), math.sin(rz / 2)
    q = (
        cz * cy * cx + sz * sy * sx,
        cz * cy * sx - sz * sy * cx,
        cz * sy * cx + sz * cy * sx,
        sz * cy * cx - cz * sy * sx,
    )
    return q if q[0] >= 0 else (-q[0], -q[1], -q[2], -q[3])


@lru_cache(maxsize=20_000)
def turn(rx: float, ry: float, rz: float, written: str) -> str:
    """`[q1,q2,q3,q4]`; the digits that were read where they still mean this turn."""
    computed = quaternion(rx, ry, rz)
    if written:
        known = tuple(float(text) for text in written.split(","))
        size = math.sqrt(sum(q * q for q in known))
        if size and abs(sum(a * b for a, b in zip(computed, known, strict=True))) / size > 1.0 - _SAME:
            return f"[{written}]"
    texts = all_trimmed(computed, _TURN_DIGITS)
    assert texts is not None  # none is greater than one
    return f"[{','.join([one.rstrip('.') for one in texts])}]"


def place(values: tuple[float, ...], exact: bool = True) -> str:
    """`[x,y,z]` of metres."""
    x, y, z = values[:3]
    return f"[{decimal(x, mm, exact)},{decimal(y, mm, exact)},{decimal(z, mm, exact)}]"


def axes(external: tuple[float, ...], own: bool = True) -> str:
    """External axes [mm or deg]; 9E9: not connected. Other languages write zeros for axes that they do not have."""
    if not external or (not own and not any(external)):
        return NO_AXES
    texts = ["9E9" if math.isnan(value) else decimal(value) for value in external[:6]]
    return f"[{','.join(texts + ['9E9'] * (6 - len(texts)))}]"


def literal(it: ex.PositionLiteral, kind: str, own: bool) -> str:
    """A position as a value of type `kind`. `own`: what RAPID wrote beside it holds."""
    if it.kind == "joint":
        if len(it.values) > 6:
            raise CannotSayError("a position of more than six axes")
        values = [*it.values, *[0.0] * (6 - len(it.values))]
        return f"[[{','.join(decimal(value, deg, own) for value in values)}],{axes(it.external, own)}]"
    values6 = it.values[:6]
    total = sum(values6)
    if total != total and any(map(math.isnan, values6)):
        raise CannotSayError("a position with values left out", "write all six")
    native = dict(it.native) if own else {}
    if kind == "pos":
        return place(values6, own)
    turned = turn(values6[3], values6[4], values6[5], native.get("orient", ""))
    if kind == "orient":
        return turned
    pose = f"{place(values6, own)},{turned}"
    if kind == "pose":
        return f"[{pose}]"
    if kind == "tooldata":
        return f"[TRUE,[{pose}],[1,[0,0,1],[1,0,0,0],0,0,0]]"
    if kind == "wobjdata":
        return f'[FALSE,TRUE,"",[{pose}],[[0,0,0],[1,0,0,0]]]'
    found = native.get("confdata", "") or confdata(it.configuration, it.sectors)
    arm = f"[{found}]" if found else NO_CONFIGURATION
    return f"[{pose},{arm},{axes(it.external, own)}]"
