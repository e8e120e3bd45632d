"""KRL's words for numbers, units and positions, as neutral expressions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import lru_cache
from math import inf, isinf
from typing import Final, NamedTuple

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir.points import Sector
from olp.ir.program import Blend, BlendKind
from olp.languages.vendors.krl.scope import AXES, AXIS_NUMBERS, COMPONENTS, POSES, Scope

NOTHING: Final = math.nan
POSE_ORDER: Final = ("X", "Y", "Z", "C", "B", "A")  # as x y z rx ry rz
POSE_SCALES: Final = (mm, mm, mm, deg, deg, deg)
ARM: Final = ("S", "T")
NOT_CONNECTED: Final = 9e9
EXTERNALS: Final = ("E1", "E2", "E3", "E4", "E5", "E6")
STOP: Final = Blend(BlendKind.RADIUS, ex.Quantity(ex.Number(0), mm))
NULL_FRAME: Final = ex.PositionLiteral("pose", (0.0,) * 6, native=(("name", "$NULLFRAME"),))

# Fractions and rates of the public bas.src and $config.dat.
ACC_PTP: Final = 0.005  # DEF_ACC_PTP is 50 %, so ACC 100 is half of the rated one
ACC_SPTP: Final = 0.01  # DEF_ACC_SPTP is 100 %
ACC_CP: Final = 0.023  # DEF_ACC_CP is 2.3 m/s²: [m/s²] per percent


def is_stop(blend: Blend) -> bool:
    """Whether the arm stops exactly at the point."""
    return blend.kind is BlendKind.RADIUS and blend.value is not None and blend.value.literal == 0.0


class Component(NamedTuple):
    """`key`: the member in capitals, with [] where that was written."""

    key: str
    name: str
    value: ex.Expression | KrlAggregate


class KrlAggregate(NamedTuple):
    """`{X 1, Y 2}` before it is known of what; `tag`: the type where it is written inside."""

    tag: str
    components: tuple[Component, ...]


@lru_cache(maxsize=20_000)
def number(text: str) -> ex.Number:
    """`12` is an integer; `12.`, `.5` and `1E3` are reals."""
    return ex.Number(int(text) if text.isdecimal() else float(text))


def bits(text: str) -> ex.Number:
    """`'B0110'`, `'H1F'`, `'D12'`. Raises ValueError."""
    word = text[1:-1].replace(" ", "").upper()
    base = {"B": 2, "H": 16, "D": 10}.get(word[:1])
    return ex.Number(int(word[1:], base) if base and len(word) > 1 else int(word, 16))


def settle(it: ex.Expression | KrlAggregate, scope: Scope, type: str = "") -> ex.Expression:
    """An aggregate as a value of `type` (in capitals), or of that which its components are of."""
    if not isinstance(it, KrlAggregate):
        return it
    kind = it.tag or type
    keys = {component.key for component in it.components}
    if kind in POSES or (kind not in AXES and not scope.has_layout(kind) and keys <= COMPONENTS.keys()):
        return _pose(it, scope, kind)
    if kind in AXES or (not scope.has_layout(kind) and keys <= AXIS_NUMBERS.keys() | set(EXTERNALS)):
        return _axes(it, scope, kind)
    return _record(it, scope, kind)


def _record(it: KrlAggregate, scope: Scope, kind: str) -> ex.RecordLiteral:
    members = tuple(
        (
            scope.spell(one.name),
            settle(one.value, scope, scope.type_of_member(kind, one.key.partition("[")[0])),
        )
        for one in it.components
    )
    return ex.RecordLiteral(scope.spell(kind) if kind else "", members)


def _pose(it: KrlAggregate, scope: Scope, kind: str) -> ex.Expression:
    given = {component.key: component.value for component in it.components}
    if not given.keys() <= COMPONENTS.keys():
        return _record(it, scope, kind)
    if not all(type(value) is ex.Number for value in given.values()):
        return _computed("pose-angles", POSE_ORDER, given, scope)
    numbers = {key: float(value.value) for key, value in given.items() if isinstance(value, ex.Number)}
    values = tuple(
        numbers[key] * scale if key in numbers else NOTHING
        for key, scale in zip(POSE_ORDER, POSE_SCALES, strict=True)
    )
    native = tuple((key, str(int(numbers[key]))) for key in ARM if key in numbers)
    configuration = flags(int(numbers["S"])) if "S" in numbers else ()
    sectors = signs(int(numbers["T"])) if "S" in numbers and "T" in numbers else ()
    return ex.PositionLiteral("pose", values, _external(numbers), configuration, native, sectors)


def _axes(it: KrlAggregate, scope: Scope, kind: str) -> ex.Expression:
    given = {component.key: component.value for component in it.components}
    if not given.keys() <= AXIS_NUMBERS.keys() | set(EXTERNALS):
        return _record(it, scope, kind)
    if not all(type(value) is ex.Number for value in given.values()):
        return _computed("joints", AXIS_NUMBERS, given, scope)
    numbers = {key: float(value.value) for key, value in given.items() if isinstance(value, ex.Number)}
    values = tuple(numbers[key] * deg if key in numbers else NOTHING for key in AXIS_NUMBERS)
    return ex.PositionLiteral("joint", values, _external(numbers))


def _computed(
    name: str, order: Iterable[str], given: Mapping[str, ex.Expression | KrlAggregate], scope: Scope
) -> ex.Function:
    """A position of which a component is computed, nan where one is left out; S, T and external axes by their names."""
    parts = {key: settle(value, scope) for key, value in given.items()}
    arguments: list[ex.Expression] = [parts.get(key, ex.Number(NOTHING)) for key in order]
    arm = tuple((key, parts[key]) for key in ARM if key in parts)
    if arm:
        arguments.append(ex.NamedArgument("conf", ex.RecordLiteral("", arm)))
    if not parts.keys().isdisjoint(EXTERNALS):
        axes = (parts.get(key, ex.Number(NOT_CONNECTED)) for key in EXTERNALS)
        arguments.append(
            ex.NamedArgument("axes", ex.RecordLiteral("extjoint", tuple(zip(EXTERNALS, axes, strict=True))))
        )
    return ex.Function(name, tuple(arguments))


def _external(numbers: dict[str, float]) -> tuple[float, ...]:
    last = max((place for place, key in enumerate(EXTERNALS, 1) if key in numbers), default=0)
    return tuple(numbers.get(key, NOTHING) for key in EXTERNALS[:last])


def flags(status: int) -> tuple[int, ...]:
    """Arm flags of a status S (inferred: KUKA's A5 turns against Yaskawa's B, and A3 counts from the stretched arm).

    Bit 0: overhead area; bit 1: A3 bent as usual; bit 2: A5 negative. The turn T has no counterpart.
    """
    return (int(not status & 4), int(not status & 2), status & 1, 0, 0, 0)


def signs(turn: int) -> tuple[Sector, ...]:
    """Where the axes stand by a turn T: bit n of axis n+1, set where its angle is negative."""
    return tuple(Sector(n, -inf, 0.0) if turn >> n & 1 else Sector(n, 0.0, inf) for n in range(6))


def turn(sectors: tuple[tuple[int, float, float], ...]) -> int | None:
    """The way back of `signs`, None where the signs are not known."""
    negative = {axis: high == 0.0 for axis, low, high in sectors if isinf(low) != isinf(high)}
    return sum(1 << axis for axis, below in negative.items() if below) if len(negative) == 6 else None


def status(configuration: tuple[int, ...]) -> int:
    """The way back of `flags`."""
    noflip, lower, back = configuration[:3]
    return (0 if noflip else 4) | (0 if lower else 2) | (1 if back else 0)
