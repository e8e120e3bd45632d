"""A figure is a list of shapes in pixels, y down. Colours are roles, so that one figure fits light and dark.

A panel has two scaled axes with ticks at round numbers, a grid and labels, and converts data to pixels.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

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
    """`x`, `y` [px]: start, middle or end of the baseline. `upright`: rotated to read upwards."""

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
    """Shapes in the order in which they are painted. `title` is read first by screen readers."""

    width: int
    height: int
    title: str
    shapes: list[Shape] = field(default_factory=list)

    def add(self, *shapes: Shape) -> None:
        self.shapes.extend(shapes)


_SMALL = 11.0  # [px] of tick numbers


@dataclass(frozen=True, slots=True)
class Axes:
    """The panel's position in the figure [px] and the data at its edges."""

    figure: Figure
    left: float
    top: float
    width: float
    height: float
    x_range: tuple[float, float]
    y_range: tuple[float, float]

    def x(self, value: float) -> float:
        low, high = self.x_range
        return self.left + (value - low) / (high - low) * self.width

    def y(self, value: float) -> float:
        low, high = self.y_range
        return self.top + self.height - (value - low) / (high - low) * self.height

    def frame(self, x_label: str, y_label: str, title: str = "", x_numbers: bool = True) -> None:
        """Grid, ticks and labels; drawn before the data."""
        bottom = self.top + self.height
        for value in ticks(self.y_range, max(3, int(self.height / 34))):
            y = self.y(value)
            strong = value == 0.0 and self.y_range[0] < 0.0
            self._line((self.left, y), (self.left + self.width, y), "frame" if strong else "grid")
            self.figure.add(TextLabel(self.left - 7, y + 4, number(value), "muted", _SMALL, "end"))
        for value in ticks(self.x_range, max(3, int(self.width / 85))):
            x = self.x(value)
            self._line((x, self.top), (x, bottom), "grid")
            if x_numbers:
                self.figure.add(TextLabel(x, bottom + 16, number(value), "muted", _SMALL, "middle"))
        self._line((self.left, self.top), (self.left, bottom), "frame")
        self._line((self.left, bottom), (self.left + self.width, bottom), "frame")
        if x_label:
            self.figure.add(
                TextLabel(self.left + self.width / 2, bottom + 34, x_label, "muted", 12, "middle")
            )
        if y_label:
            self.figure.add(
                TextLabel(
                    self.left - 52, self.top + self.height / 2, y_label, "muted", 12, "middle", upright=True
                )
            )
        if title:
            self.figure.add(TextLabel(self.left, self.top - 9, title, "ink", 12.5, bold=True))

    def line(
        self, x: ArrayLike, y: ArrayLike, colour: Role, width: float = 1.8, dash: tuple[float, ...] = ()
    ) -> None:
        """Data as a line, clipped to the panel's edge; unknown values leave a gap."""
        xs = np.asarray(x, dtype=np.float64)
        ys = np.clip(np.asarray(y, dtype=np.float64), *self.y_range)
        known = np.isfinite(xs) & np.isfinite(ys)
        edges = np.flatnonzero(np.diff(np.concatenate(([0], known.astype(np.int8), [0]))))
        for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            points = [
                (self.x(a), self.y(b))
                for a, b in zip(xs[begin:end].tolist(), ys[begin:end].tolist(), strict=True)
            ]
            self.figure.add(Polyline(tuple(thinned(points)), colour, width, dash))

    def band(self, begin: float, end: float, colour: Role, opacity: float) -> None:
        """A stretch of the x axis, shaded over the panel's height."""
        low, high = (min(max(value, self.x_range[0]), self.x_range[1]) for value in (begin, end))
        self.figure.add(Box(self.x(low), self.top, self.x(high) - self.x(low), self.height, colour, opacity))

    def _line(self, start: tuple[float, float], end: tuple[float, float], colour: Role) -> None:
        self.figure.add(Polyline((start, end), colour, 1.0))


def ticks(span: tuple[float, float], most: int) -> list[float]:
    """Round numbers (1, 2, 2.5, 5 times a power of ten) inside the span, at most `most` + 1."""
    low, high = span
    raw = (high - low) / max(most, 1)
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(power * factor for factor in (1, 2, 2.5, 5, 10) if power * factor >= raw * (1 - 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [index * step for index in range(first, last + 1)]


def number(value: float) -> str:
    """A tick's number without rounding noise."""
    text = f"{value:.6g}"
    return "0" if text in ("-0", "0") else text.replace("-", "−")


def room(values: ArrayLike, share: float = 0.08, zero: bool = True) -> tuple[float, float]:
    """A range with margins that includes all known values and, with `zero`, zero."""
    known = np.asarray(values, dtype=np.float64).ravel()
    known = known[np.isfinite(known)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)
    if zero:
        low, high = min(low, 0.0), max(high, 0.0)
    if high - low < 1e-9:
        low, high = (low, low + 1.0) if zero else (low - 0.5, low + 0.5)
    air = (high - low) * share
    return (low - air if low < 0 or not zero else low), high + air


def thinned(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The line without points that lie within a fifth of a pixel of the line between the others."""
    if len(points) < 3:
        return points
    kept = [0]
    xy = np.array(points)
    stack = [(0, len(points) - 1)]
    marks = np.zeros(len(points), dtype=bool)
    while stack:
        begin, end = stack.pop()
        if end - begin < 2:
            continue
        chord = xy[end] - xy[begin]
        offset = xy[begin + 1 : end] - xy[begin]
        length = float(np.hypot(*chord))
        if length < 1e-9:
            apart = np.hypot(offset[:, 0], offset[:, 1])
        else:
            apart = np.abs(offset[:, 0] * chord[1] - offset[:, 1] * chord[0]) / length
            # A line that turns back on itself leaves its chord along it, not beside it.
            along = offset @ chord / length
            apart = np.maximum(apart, np.maximum(-along, along - length))
        far = int(np.argmax(apart))
        if apart[far] > 0.2:
            middle = begin + 1 + far
            marks[middle] = True
            stack += [(begin, middle), (middle, end)]
    kept += np.flatnonzero(marks).tolist()
    return [points[i] for i in [*kept, len(points) - 1]]
