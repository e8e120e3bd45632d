"""What is computed: variables, signals, arithmetic and conditions, without any vendor's words.

Nodes are frozen values; two programs that compute the same have equal nodes. Evaluation lives in the
interpreter, spelling in the vendors' templates.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple

from olp.core.fast_dataclass import fast_init


class Store(StrEnum):
    """The kind of a variable: what it can hold."""

    BYTE = "byte"  # 0..255
    INTEGER = "integer"  # 16 bit, signed
    DOUBLE = "double"  # 32 bit integer, signed
    REAL = "real"  # floating point
    STRING = "string"
    ROBOT = "robot"  # position of a robot
    BASE = "base"  # position of the track that carries a robot
    STATION = "station"  # position of a positioner
    SYSTEM = "system"  # robot, base and station together


POSITION_STORES = frozenset({Store.ROBOT, Store.BASE, Store.STATION, Store.SYSTEM})


@fast_init
@dataclass(frozen=True, slots=True)
class Number:
    """A literal. `value` keeps int and float apart, because integer arithmetic differs."""

    value: int | float


@fast_init
@dataclass(frozen=True, slots=True)
class Text:
    """A string literal, without its quotes."""

    value: str


@fast_init
@dataclass(frozen=True, slots=True)
class SignalState:
    """A signal's literal state, on or off."""

    on: bool


@fast_init
@dataclass(frozen=True, slots=True)
class Variable:
    """A variable by kind and index. `name` is the alias it was written with; it does not take part in equality."""

    store: Store
    index: Expression
    local: bool = False
    name: str = field(default="", compare=False)


@fast_init
@dataclass(frozen=True, slots=True)
class Taught:
    """A position taught inside the routine (INFORM C, BC, EC): `store` says of what, `number` which."""

    store: Store
    number: int


@fast_init
@dataclass(frozen=True, slots=True)
class Element:
    """One element of a position variable: 1..3 x y z, 4..6 rx ry rz, 7 the extra axis; or an axis of pulses."""

    variable: Position
    index: Expression


@fast_init
@dataclass(frozen=True, slots=True)
class Signal:
    """An input, output, group or register: `bus` is the vendor-neutral name (`in`, `out`, `in-group` ...).

    `name`: what the program calls one that has a number; it does not take part in equality.
    """

    bus: str
    index: Expression  # a number, or a Text where the language names its signals
    part: str = ""  # "low" or "high" half of a register
    name: str = field(default="", compare=False)


@fast_init
@dataclass(frozen=True, slots=True)
class SystemValue:
    """A value that only the controller knows: current position, the last returned value, an alarm number.

    `comment`: what the program calls one of many; it does not take part in equality.
    """

    name: str
    index: int = 0
    comment: str = field(default="", compare=False)


@fast_init
@dataclass(frozen=True, slots=True)
class Argument:
    """The n-th argument (from 1) that the caller passed."""

    number: int


@fast_init
@dataclass(frozen=True, slots=True)
class FrameRef:
    """A coordinate system: kind is base, robot, user, tool, master-tool or own; user frames and tools have a number.

    "own": that of the value itself, pulses for a pulse position (a relative move that names no frame).
    """

    kind: str
    number: Expression | None = None


@fast_init
@dataclass(frozen=True, slots=True)
class Unary:
    operator: str  # "-" or "not"
    operand: Expression


@fast_init
@dataclass(frozen=True, slots=True)
class Binary:
    operator: str  # + - * / and or xor mod
    left: Expression
    right: Expression


@fast_init
@dataclass(frozen=True, slots=True)
class Compare:
    operator: str  # = <> < > <= >=
    left: Expression
    right: Expression


@fast_init
@dataclass(frozen=True, slots=True)
class Logic:
    """`first op second op third …`, evaluated strictly from left to right as controllers do (no precedence)."""

    first: Expression
    rest: tuple[tuple[str, Expression], ...]  # ("and" | "or", condition)


@fast_init
@dataclass(frozen=True, slots=True)
class Function:
    """A built-in: sqrt, pose-product, pose-inverse, convert, tool-data, step-position, parameter …"""

    name: str
    arguments: tuple[Expression, ...]


@fast_init
@dataclass(frozen=True, slots=True)
class Unknown:
    """A name that nothing defines, kept as written."""

    text: str


@fast_init
@dataclass(frozen=True, slots=True)
class Named:
    """A variable by its name, in the spelling of its declaration: languages without cases fold it while reading."""

    name: str


@fast_init
@dataclass(frozen=True, slots=True)
class Item:
    """An element of an array or of joint values; indices count from 1, whatever the language counts from."""

    base: Expression
    indices: tuple[Expression, ...]


@fast_init
@dataclass(frozen=True, slots=True)
class Member:
    """A component of a record. Of a position: x y z [mm], rx ry rz [deg], R = Rz(rz) Ry(ry) Rx(rx), e1 .. e6."""

    base: Expression
    name: str


@fast_init
@dataclass(frozen=True, slots=True)
class PositionLiteral:
    """A position written out where it is used, or as the value of a declaration.

    `kind` "pose": `values` x y z [m], rx ry rz [rad] as `PointKind.POSE`; "joint": axis values [rad], slides [m]. nan:
    not written, that component stays as it is. `external`: further axes as written [mm or deg], nan: not connected.
    `configuration`, `sectors`: arm flags as in `PointState`. `native`: what else was written, for the same language.
    """

    kind: str
    values: tuple[float, ...]
    external: tuple[float, ...] = ()
    configuration: tuple[int, ...] = ()
    native: tuple[tuple[str, str], ...] = field(default=(), compare=False)
    sectors: tuple[tuple[int, float, float], ...] = ()


@fast_init
@dataclass(frozen=True, slots=True)
class RecordLiteral:
    """A structure's value: (member, value) in order of writing; an array has members without names."""

    type: str
    members: tuple[tuple[str, Expression], ...]


@fast_init
@dataclass(frozen=True, slots=True)
class CallValue:
    """What a routine of the program returns."""

    routine: str
    arguments: tuple[Expression, ...] = ()


@fast_init
@dataclass(frozen=True, slots=True)
class NamedArgument:
    """An argument passed by its name; `value` None: a switch that is given."""

    name: str
    value: Expression | None = None


class Quantity(NamedTuple):
    """A number with a unit: SI value = value of `written` times `scale` (SI per written unit)."""

    written: Expression
    scale: float

    @property
    def literal(self) -> float | None:
        """The SI value when it is written out, None when a variable decides."""
        return self.written.value * self.scale if type(self.written) is Number else None


Position = Taught | Variable | Unknown  # what INFORM moves to; other languages move to any expression
Expression = (
    Number
    | Text
    | SignalState
    | Variable
    | Taught
    | Element
    | Signal
    | SystemValue
    | Argument
    | FrameRef
    | Unary
    | Binary
    | Compare
    | Logic
    | Function
    | Unknown
    | Named
    | Item
    | Member
    | PositionLiteral
    | RecordLiteral
    | CallValue
    | NamedArgument
)


# --- Other units ---

_SAME_FACTOR = 1e-12  # relative: what two conversions leave that undo each other


def scaled(e: Expression, factor: float) -> Expression:
    """`e` times `factor`, as one writes it: in millimetres, 0.04 * i metres are 40 * i.

    The factor goes into a number of the product, and one that undoes it is taken off. Of a number twelve digits count:
    else 4.5 mm grow by the last bit each time that a program is read and written.

        >>> scaled(Binary("*", Number(0.04), Named("i")), 1000)
        Binary(operator='*', left=Number(value=40.0), right=Named(name='i'))
    """
    if type(e) is Number:
        exact = type(e.value) is int and type(factor) is int
        return Number(e.value * factor if exact else float(f"{e.value * factor:.12g}"))
    if type(e) is Binary and type(e.right) is Number and e.operator in "*/" and e.right.value:
        held = e.right.value if e.operator == "*" else 1.0 / e.right.value
        if abs(held * factor - 1.0) < _SAME_FACTOR:
            return e.left
    if type(e) is Binary and e.operator == "*":
        for part, other in ((e.left, e.right), (e.right, e.left)):
            within = scaled(part, factor) if _holds_number(part) else part
            if within == Number(1):
                return other
            if within is not part:
                left, right = (within, other) if part is e.left else (other, within)
                return Binary("*", left, right)
    return Binary("*", e, Number(factor))


def _holds_number(e: Expression) -> bool:
    """Whether a factor of a product is a number."""
    if type(e) is Binary and e.operator == "*":
        return _holds_number(e.left) or _holds_number(e.right)
    return type(e) is Number


def without_decimals(e: Expression) -> Expression:
    """A product with whole numbers where it has them: 40 * i, not 40.0 * i. For targets where that changes no value."""
    match e:
        case Number(value) if float(value).is_integer():
            return Number(int(value))
        case Binary("*", left, right):
            return Binary("*", without_decimals(left), without_decimals(right))
    return e
