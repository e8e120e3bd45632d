"""Constant folding: names that always hold the same value are written as it, functions of numbers as their result."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from operator import matmul
from typing import Final

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir.program import Move, Program, Statement
from olp.ir.transformer import is_written_out, mapped
from olp.languages.limits import Limits
from olp.robots.geometry import Pose
from olp.runtime.evaluate import round_half_away
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import with_routines, with_rows

_MEMBERS = ("x", "y", "z", "rx", "ry", "rz")
_POSES: Final = frozenset({"pose-product", "pose-inverse"})


_FUNCTIONS: Final[Mapping[str, Callable[[float], float]]] = {
    "sin": lambda angle: math.sin(math.radians(angle)),
    "cos": lambda angle: math.cos(math.radians(angle)),
    "tan": lambda angle: math.tan(math.radians(angle)),
    "sqrt": math.sqrt,
    "abs": abs,
}


_WHOLE: Final[Mapping[str, Callable[[float], int]]] = {
    "round": round_half_away,
    "trunc": math.trunc,
    "floor": math.floor,
    "ceil": math.ceil,
}


def _whole(e: ex.Function) -> ex.Expression:
    """A number that is written out, as a whole one: no whole variable takes a fraction as it is written."""
    value, sign = e.arguments[0], 1
    if type(value) is ex.Unary and value.operator == "-":
        value, sign = value.operand, -1
    return ex.Number(_WHOLE[e.name](sign * value.value)) if type(value) is ex.Number else e


def _computed(e: ex.Expression, limits: Limits) -> ex.Expression:
    """Where functions take variables only and no sign stands before one: what comes out of the numbers."""
    if type(e) is ex.Function and e.name in _WHOLE and len(e.arguments) == 1:
        return _whole(e)
    if not limits.register_arguments:
        return e
    if type(e) is ex.Unary and e.operator == "-":
        if isinstance(e.operand, ex.Number):
            return ex.Number(-e.operand.value)
        return ex.Binary("-", ex.Number(0), e.operand)
    if type(e) is ex.Function and e.name in _FUNCTIONS and len(e.arguments) == 1:
        value = e.arguments[0]
        if isinstance(value, ex.Number) and (value.value >= 0 or e.name != "sqrt"):
            return ex.Number(float(f"{_FUNCTIONS[e.name](value.value):.10g}"))
    return e


def _pose(e: ex.Function, given: Sequence[ex.Expression | None]) -> ex.PositionLiteral | None:
    """What comes out of constant poses, None where one of them is none. A product has the arm flags of its last factor,
    which `with_flags` gives it."""
    poses = [
        Pose.from_xyz_angles(one.values)
        for one in given
        if type(one) is ex.PositionLiteral
        and one.kind == "pose"
        and not (one.external or any(map(math.isnan, one.values)))
    ]
    if not poses or len(poses) < len(e.arguments):
        return None
    if e.name == "pose-inverse":
        return ex.PositionLiteral("pose", tuple(poses[0].inverse().xyz_angles().tolist()))
    last, values = given[-1], tuple(reduce(matmul, poses).xyz_angles().tolist())
    assert isinstance(last, ex.PositionLiteral)
    return ex.PositionLiteral("pose", values, configuration=last.configuration, sectors=last.sectors)


def fold_constants(program: Program, work: TranslationContext) -> Program:
    """Names that always hold the same number, text or state are written as it, and so are components of points."""
    symbols = work.symbols(program)
    elsewhere = _changeable(program)
    told: list[str] = []  # of them, in the statement under way

    def change(e: ex.Expression) -> ex.Expression:
        if type(e) is ex.Named and e.name not in work.registers:
            value = symbols.fixed_value("", e)
            if isinstance(value, (ex.Number, ex.Text, ex.SignalState)):
                if e.name in elsewhere:
                    told.append(e.name)
                return value
        if type(e) is ex.Member and isinstance(e.base, (ex.Named, ex.Item)) and e.name in _MEMBERS:
            literal = symbols.fixed_value("", e.base)
            if isinstance(literal, ex.PositionLiteral) and literal.kind == "pose":
                at = _MEMBERS.index(e.name)
                written = literal.values[at] / (mm if at < 3 else deg)
                return ex.Number(float(f"{written:.10g}"))
        if type(e) is ex.Function and e.name in _POSES and work.limits.register_arguments:
            return _pose(e, [symbols.fixed_value("", one) for one in e.arguments]) or e
        return _computed(e, work.limits)

    def folded(s: Statement) -> Statement:
        # A move to a plain name, nearly every one: a point is no number.
        if type(s) is Move and is_written_out(s):
            e = s.targets[0]
            if type(symbols.fixed_value("", e) if type(e) is ex.Named else e) is ex.PositionLiteral:
                return s
        told.clear()
        changed = mapped(s, change)
        for name in dict.fromkeys(told):
            where = "of another file" if elsewhere[name] else "that lasts"
            says = (
                f"{name} is a variable {where}, which other programs may change: its value there is written"
            )
            work.lose(s, Fate.APPROXIMATED, "value", says)
        return changed

    return with_routines(program, (with_rows(r, list(map(folded, r.body))) for r in program.routines))


def _changeable(program: Program) -> dict[str, bool]:
    """Data that are no constants: whether other files declare them, or they last and others see them."""
    own = program.source.raw.count(b"\n") + 1
    found = {}
    for d in program.data:
        # Those of the controller's own list have no line.
        elsewhere = d.line > own or (d.line == 0 and bool(d.native))
        if d.storage != "constant" and (elsewhere or (d.storage == "persistent" and d.shared)):
            found[d.name] = elsewhere
    return found
