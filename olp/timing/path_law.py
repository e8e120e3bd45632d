"""How long a line or an arc takes, alone or as a piece of a path with rounded corners: one law for both.

A piece of length L at speed u takes L/u, and each of its ends costs time. Speeding up from rest, or
braking to it, costs

    u/(2 a) + (s/2) u/(u + w)

a the tool's acceleration, s what a stop costs beyond it: a ramp of the acceleration needs a time of its
own, less at speeds below w. An end in a corner is passed at a speed v that the corner's radius and the
acceleration across the path allow, and costs what braking to it, or speeding up from it, takes longer than u:

    (u - v)^2/(2 a u)     1/v^2 = 1/u^2 + (2 - cos t - cos r)/(g a (z + h))

t the turn of the direction, r that of the tool's own turning, z the corner's zone. Where a controller or
a recorder parts a path at its corners is a convention: b goes from the piece behind a corner to the piece
before it, and the first piece of a run takes f longer. The speed is

    u = (V^-6 + m^-6)^(-1/6)     m = sqrt(2 a L / n)

V the programmed speed, at most what the axes can do (e^k L over the time that the slowest axis needs at
its rated speed) and the tool's highest; n the ends' share of u/(2 a), by V: a short piece never gets to V. Arcs
of radius R have the acceleration a e^(q c/(c + a)), c = V^2/R: speeding up shares the axes with turning, more so the
faster the arc; in equal parts 1/sqrt(2) each.
Where an acceleration is programmed a is a number of its own times it.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.timing.arm_prior import LineAcceleration

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]

_SHARPNESS: Final = (
    6.0  # of the smaller of two speeds: a piece that just reaches its speed is a little slower
)
_LEAST: Final = 0.2  # of L/u: corners of a convention take no more than that off a piece


class PathNumber(NamedTuple):
    """A parameter of the law: prior mean and spread for any arm, of its logarithm if `logarithmic`."""

    name: str
    unit: str
    mean: float
    sd: float
    logarithmic: bool
    source: str


_OF_THE_ARM: Final = float("nan")  # what line_acceleration says of it
NUMBERS: Final = (
    PathNumber("acceleration", "m/s²", _OF_THE_ARM, _OF_THE_ARM, True, "published, or learnt over arms"),
    PathNumber("arc exponent", "1", -0.35, 0.2, False, "an acceleration shared by speeding up and turning"),
    PathNumber("stop", "s", 0.05, 0.05, False, "usual filters of controllers"),
    PathNumber("stop speed", "m/s", float(np.log(0.1)), 0.7, True, "a guess that holds for any arm"),
    PathNumber(
        "corner acceleration", "1", 0.0, 1.0, True, "across the path as along it, by a factor of three"
    ),
    PathNumber("corner zone", "m", float(np.log(0.01)), 1.0, True, "a guess that holds for any arm"),
    PathNumber("corner convention", "s", 0.0, 0.05, False, "a recorder may part a path anywhere"),
    PathNumber("highest speed", "m/s", float(np.log(6.0)), 0.6, True, "a guess that holds for any arm"),
    PathNumber("override exponent", "1", 1.5, 0.7, False, "not known of this controller"),
    PathNumber("axis share", "1", 0.0, 0.2, False, "rated speeds of the axes, turned evenly along the path"),
    PathNumber("first piece", "s", 0.0, 0.05, False, "a recorder may begin anywhere"),
    PathNumber("programmed acceleration", "1", 0.0, 0.2, True, "what is programmed, by a fifth"),
)


def prior_numbers(lines: LineAcceleration) -> tuple[Floats, Floats]:
    """Means and standard deviations of NUMBERS (p,) for an arm whose lines accelerate with `lines`."""
    own = np.array([np.isnan(number.mean) for number in NUMBERS])
    mean = np.where(own, np.log(lines.value), [number.mean for number in NUMBERS])
    return mean, np.where(own, lines.doubt, [number.sd for number in NUMBERS])


_STOP: Final = next(number for number in NUMBERS if number.name == "stop")
MOST_OF_A_STOP: Final = _STOP.mean + 1.96 * _STOP.sd  # [s] where nothing is known of the controller
SCATTER: Final = 0.03  # [1] what the law leaves of a piece, before any was recorded


@dataclass(frozen=True, slots=True, eq=False)
class PathPieces:
    """n pieces of paths, in their order; `zone`, `turn` … describe their ends in corners and are 0 at stops."""

    length: Floats  # (n,) [m] along the path
    speed: Floats  # (n,) [m/s] programmed
    acceleration: Floats  # (n,) [m/s²] as programmed, nan where nothing is
    share: Floats  # (n,) [1] of it that a percent of acceleration asks for
    arc: Mask  # (n,)
    curvature: Floats  # (n,) [1/m] of arcs, 0 of lines
    override: Floats  # (n,) [1]
    rolling: Mask  # (n, 2) whether it begins and ends in a corner
    zone: Floats  # (n, 2) [m] of the corner there
    turn: Floats  # (n, 2) [rad] of the direction there
    tilt: Floats  # (n, 2) [rad/m] change of how much the tool turns along the way there, at most 1.5
    axis: Floats  # (n,) [s] that the slowest axis needs at its rated speed, 0 where not known
    first: Mask  # (n,) no piece leads to where it begins

    def __len__(self) -> int:
        return len(self.length)

    def take(self, rows: Mask | Rows) -> PathPieces:
        return PathPieces(*(getattr(self, field.name)[rows] for field in fields(self)))


def path_durations(numbers: Floats, pieces: PathPieces) -> Floats:
    """Durations (n,) [s] for `numbers` in the order of NUMBERS, logarithms where `logarithmic`."""
    usual, slow, across, zone, highest, programmed = np.exp(numbers[[0, 3, 4, 5, 7, 11]]).tolist()
    arc, stop, convention, override, axis, first = numbers[[1, 2, 6, 8, 9, 10]].tolist()
    push = np.where(pieces.acceleration > 0, programmed * pieces.acceleration, usual) * pieces.share
    push = push * pieces.override**override
    with np.errstate(divide="ignore", invalid="ignore"):
        able = np.where(pieces.axis > 0, np.exp(axis) * pieces.length / pieces.axis, np.inf)
        wanted = np.minimum(np.minimum(pieces.speed, highest), able) * pieces.override
        inwards = wanted**2 * pieces.curvature
        push = push * np.exp(arc * inwards / (inwards + push))
        bend = 2.0 - np.cos(pieces.turn) - np.cos(pieces.tilt)
        needed = wanted[:, None] ** 2 * bend / (across * push[:, None] * (pieces.zone + zone))
        ends = np.where(pieces.rolling, (1.0 - (1.0 + needed) ** -0.5) ** 2, 1.0).sum(axis=1)
        top = np.sqrt(2.0 * push * pieces.length / np.maximum(ends, 1e-9))
        speed = (wanted**-_SHARPNESS + top**-_SHARPNESS) ** (-1.0 / _SHARPNESS)
        settled = speed / (speed + slow)
    stops = 2 - pieces.rolling.sum(axis=1)
    moved = pieces.rolling[:, 1].astype(np.float64) - pieces.rolling[:, 0]
    cruise = pieces.length / speed
    extra = (stops * stop / 2 - moved * convention) * settled + first * pieces.first
    return np.asarray(np.maximum(cruise + ends * speed / (2.0 * push) + extra, _LEAST * cruise))
