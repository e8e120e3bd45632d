"""A figure is a list of shapes in pixels, y down. Colours are roles, so that one figure fits light and dark."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final, Literal, NamedTuple

Role = str
Anchor = Literal["start", "middle", "end"]


class Tone(NamedTuple):
    light: str
    dark: str


# Contrast against the paper at least 4.5 for what is read, 3 for what is drawn, in both columns.
TONES: Final[Mapping[Role, Tone]] = MappingProxyType(
    {
        "paper": Tone("#ffffff", "#12161c"),
        "ink": Tone("#1f2328", "#e6edf3"),
        "muted": Tone("#59636e", "#9da7b1"),
        "grid": Tone("#dfe4e9", "#2b323b"),
        "frame": Tone("#a3adb8", "#566170"),
        "blue": Tone("#0b63ce", "#5aa2ff"),
        "orange": Tone("#b8500a", "#f0924a"),
        "green": Tone("#1a7f37", "#4ac062"),
        "purple": Tone("#7a45d6", "#b48cfb"),
        "pink": Tone("#b3307f", "#ea72b4"),
        "teal": Tone("#0f756c", "#35cdb9"),
        "red": Tone("#c4202b", "#ff6b63"),
        "olive": Tone("#7a6a00", "#d3bd3d"),
    }
)
SERIES: Final = ("blue", "orange", "green", "purple", "pink", "teal", "red", "olive")


@dataclass(frozen=True, slots=True)
class Polyline:
    """`points` [px]; `width` [px]; `dash` [px] on and off, () for a whole line."""

    points: tuple[tuple[float, float], ...]
    colour: Role
    width: float = 1.5
    dash: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Box:
    """A filled rectangle; `opacity` 0..1."""

    x: float
    y: float
    width: float
    height: float
    colour: Role
    opacity: float = 1.0


@dataclass(frozen=True, slots=True)
class Dot:
    x: float
    y: float
    radius: float
    colour: Role
    hollow: bool = False


@dataclass(frozen=True, slots=True)
class TextLabel:
    """`x`, `y` [px]: where the baseline begins, has its middle or ends. `upright`: turned to read upwards."""

    x: float
    y: float
    text: str
    colour: Role = "ink"
    size: float = 12.0
    anchor: Anchor = "start"
    bold: bool = False
    upright: bool = False


Shape = Polyline | Box | Dot | TextLabel


@dataclass(slots=True)
class Figure:
    """Shapes in the order in which they are painted. `title` is what a screen reader says first."""

    width: int
    height: int
    title: str
    shapes: list[Shape] = field(default_factory=list)

    def add(self, *shapes: Shape) -> None:
        self.shapes.extend(shapes)
