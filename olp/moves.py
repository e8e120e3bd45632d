"""Moves as written: which path, where to, how fast, how the end is passed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

from olp.expression import Expression, FrameRef, Position, Quantity, Signal


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


class Speed(NamedTuple):
    unit: SpeedUnit
    value: Quantity  # SI after scaling: fraction, m/s or rad/s


class BlendKind(StrEnum):
    """How a move's end is passed."""

    LEVEL = "level"  # a controller's position level; 0 is an exact stop
    CONTINUOUS = "continuous"  # no stop, size left to the controller (ERC: CONT)
    RADIUS = "radius"  # [m]


class Blend(NamedTuple):
    kind: BlendKind
    value: Quantity | None = None


class Search(NamedTuple):
    """Move until `signal` turns `on`, at most `distance` [m] or `time` [s] beyond."""

    signal: Signal
    on: bool
    time: Quantity | None = None
    distance: Quantity | None = None


class MovePart(NamedTuple):
    """What another control group does during the same move."""

    path: Path | None  # None: a reference point only (+REFP)
    targets: tuple[Position, ...]
    speed: Speed | None = None
    blend: Blend | None = None


@dataclass(frozen=True, slots=True)
class Move:
    """A motion of one or more control groups in step.

    `targets`: the leading group's positions, as written (robot, then its track, then a station).
    `speed` None: the modal speed holds. `relative`: the target is added to the current position in that frame.
    `coordinated`: the speed is relative to the work on the station in `parts` (SMOV).
    """

    line: int
    path: Path
    targets: tuple[Position, ...]
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


@dataclass(frozen=True, slots=True)
class Reference:
    """A reference point for weaving or search. Nothing moves."""

    line: int
    number: Expression
    targets: tuple[Position, ...]
    parts: tuple[MovePart, ...] = ()
    coordinated: bool = False
    comment: str = ""


@dataclass(frozen=True, slots=True)
class SetSpeed:
    """Modal speeds for moves that name none."""

    line: int
    speeds: tuple[Speed, ...]
    comment: str = ""
