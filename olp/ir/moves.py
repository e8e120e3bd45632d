"""Moves as written: which path, where to, how fast, how the end is passed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

from olp.core.fast_dataclass import fast_init
from olp.ir.expressions import Expression, FrameRef, Position, Quantity, Signal


class Path(StrEnum):
    """The shape of a move between two points."""

    JOINT = "joint"
    LINEAR = "linear"
    CIRCULAR = "circular"
    SPLINE = "spline"


class SpeedUnit(StrEnum):
    """What a programmed speed means."""

    FRACTION = "fraction"  # of the axes' rated speed [1]
    TRAVEL = "travel"  # of the tool centre point [m/s]
    TURN = "turn"  # of the tool's orientation [rad/s]
    AXIS = "axis"  # of the axis that turns furthest [rad/s]
    TIME = "time"  # no speed: the move takes this long [s]


class Speed(NamedTuple):
    unit: SpeedUnit
    value: Quantity  # SI after scaling: fraction, m/s, rad/s or s
    native: str = ""  # the name it was written with (RAPID v100)


class AccelerationUnit(StrEnum):
    """What a programmed acceleration means."""

    FRACTION = "fraction"  # of the rated one [1]
    TRAVEL = "travel"  # of the tool centre point [m/s²]
    AXIS = "axis"  # of the axis that turns furthest [rad/s²]


class Acceleration(NamedTuple):
    unit: AccelerationUnit
    value: Quantity  # SI after scaling: fraction, m/s² or rad/s²


class BlendKind(StrEnum):
    """How a move's end is passed."""

    LEVEL = "level"  # a controller's position level; 0 is an exact stop
    CONTINUOUS = "continuous"  # no stop, size left to the controller (ERC: CONT)
    RADIUS = "radius"  # [m]; 0 is an exact stop
    SHARE = "share"  # of half of the way to the point [1] (KRL $APO.CPTP)
    SPEED = "speed"  # share of the programmed speed that is left at the corner [1] (FANUC CNT, KRL $APO.CVEL)
    TURN = "turn"  # [rad] of reorientation that is left (KRL $APO.CORI)


class Blend(NamedTuple):
    """`value` None: the modal one of this kind; of CONTINUOUS there is none."""

    kind: BlendKind
    value: Quantity | None = None
    native: str = ""  # the name it was written with (RAPID z10)


class Search(NamedTuple):
    """Move until `signal` turns `on`, at most `distance` [m] or `time` [s] beyond."""

    signal: Signal
    on: bool
    time: Quantity | None = None
    distance: Quantity | None = None


class PathTrigger(NamedTuple):
    """An output that switches while a move is under way, `metres` and `seconds` behind its end, or its start.

    Negative ones lie before that end. Times count from where the arm is at the distance. `above`: how many lines
    above the move it stands, 0 where the move itself names it.
    """

    signal: Signal
    value: Expression
    at_start: bool
    metres: Quantity | None = None
    seconds: Quantity | None = None
    above: int = 0

    @property
    def is_shifted(self) -> bool:
        """Whether it acts anywhere else than at an end of the move."""
        return any(far is not None and far.literal != 0.0 for far in (self.metres, self.seconds))


class MovePart(NamedTuple):
    """What another control group does during the same move."""

    path: Path | None  # None: a reference point only (+REFP)
    targets: tuple[Position, ...]
    speed: Speed | None = None
    blend: Blend | None = None


@fast_init
@dataclass(frozen=True, slots=True)
class Move:
    """A motion of one or more control groups in step.

    `targets`: the leading group's positions, as written (robot, then its track, then a station): taught points and
    position variables in INFORM, any expression with a position as its value elsewhere.
    `speed` None: the modal speed holds. `relative`: the target is added to the current position in that frame.
    `coordinated`: the speed is relative to the work on the station in `parts` (SMOV).
    """

    line: int
    path: Path
    targets: tuple[Expression, ...]
    speed: Speed | None = None
    blend: Blend | None = None
    parts: tuple[MovePart, ...] = ()
    comment: str = ""
    acceleration: Quantity | None = None  # fraction of rated
    deceleration: Quantity | None = None  # fraction of rated
    relative: FrameRef | None = None
    coordinated: bool = False
    end_of_arc: bool = False
    search: Search | None = None
    until: Expression | None = None  # the move ends early when this holds
    no_wait: bool = False  # the next statements run while this move is under way
    passes: str = ""  # multi-pass tag, as written (T00001)
    other: tuple[tuple[str, Expression], ...] = ()  # further tags and their values, not modelled
    via: Expression | None = None  # of an arc that is one statement
    arc: Quantity | None = None  # [rad] that an arc turns about its axis instead of ending at its target
    rate: Acceleration | None = None  # of this move alone; beside it `acceleration` is None
    turn: Quantity | None = None  # the tool turns no faster [rad/s], whatever the speed
    tool: Expression | None = None  # None: that of the point, else the modal one
    frame: Expression | None = None  # None: that of the point, else the modal one
    offset: Expression | None = None  # a pose added in the move's frame (FANUC Offset)
    tool_offset: Expression | None = None  # a pose added in the tool's axes (FANUC Tool_Offset)
    triggers: tuple[PathTrigger, ...] = ()  # in the order in which they are named

    @property
    def has_signals(self) -> bool:
        """Whether it may name signals."""
        return self.until is not None or self.search is not None or bool(self.triggers)


@dataclass(frozen=True, slots=True)
class Reference:
    """A reference point for weaving or search. Nothing moves."""

    line: int
    number: Expression
    targets: tuple[Position, ...]
    parts: tuple[MovePart, ...] = ()
    coordinated: bool = False
    comment: str = ""


@fast_init
@dataclass(frozen=True, slots=True)
class SetAcceleration:
    """Modal accelerations for moves that name none; FRACTION holds for all kinds of moves unless `path` says which."""

    line: int
    rates: tuple[Acceleration, ...]
    path: Path | None = None
    comment: str = ""


@fast_init
@dataclass(frozen=True, slots=True)
class SetBlend:
    """Modal sizes of blends for moves whose blend names a kind and no size."""

    line: int
    blends: tuple[Blend, ...]
    comment: str = ""


@fast_init
@dataclass(frozen=True, slots=True)
class SetTool:
    """The tool that holds from here on: FrameRef("tool", n), a name, or a pose on the flange."""

    line: int
    tool: Expression
    comment: str = ""


@fast_init
@dataclass(frozen=True, slots=True)
class SetFrame:
    """The frame that targets stand in from here on: FrameRef("user", n), FrameRef("base"), a name, or a pose."""

    line: int
    frame: Expression
    comment: str = ""


@dataclass(frozen=True, slots=True)
class SetOverride:
    """All programmed speeds are multiplied by `share` [1] from here on.

    `fastest`: no tool moves faster then [m/s] (RAPID VelSet); moves that last a given time are left alone.
    """

    line: int
    share: Quantity
    comment: str = ""
    fastest: Quantity | None = None


@dataclass(frozen=True, slots=True)
class ObeyFlags:
    """From here on joint moves go to the arm flags of their targets (`on`), or to the nearest axes."""

    line: int
    on: bool
    comment: str = ""


@fast_init
@dataclass(frozen=True, slots=True)
class SetSpeed:
    """Modal speeds for moves that name none; `turn` [rad/s] bounds the tool's turning on all of them."""

    line: int
    speeds: tuple[Speed, ...]
    comment: str = ""
    turn: Quantity | None = None
    path: Path | None = None  # FRACTION of moves of this path only; None: of joint moves
