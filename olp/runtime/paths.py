"""How long the tool's path of each move is: lines, arcs through three points, splines.

Arcs and splines need their neighbours: a chain of circular moves P1 P2 P3 … is entered on a straight line to P1;
the move to each later point lies on the circle through it and its two neighbours in the chain (the last one: through
the three last points). A chain ends at another kind of move or at a point marked as the end of an arc, which then
also begins the next one (controller manuals, circular interpolation).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.ir.program import Path
from olp.robots.geometry import Pose, quaternion_from_rotation, rotation_from_quaternion, slerp
from olp.runtime.plan import PATHS, Moves, Positions

Floats = NDArray[np.float64]
_CIRCULAR, _SPLINE = PATHS.index(Path.CIRCULAR), PATHS.index(Path.SPLINE)
# Gauss-Legendre nodes on 0..1: exact to 1e-9 for the arc length of the parabolas of taught splines.
_NODES, _WEIGHTS = (
    (np.polynomial.legendre.leggauss(24)[0] + 1) / 2,
    np.polynomial.legendre.leggauss(24)[1] / 2,
)


def turn_between(first: Floats, second: Floats) -> Floats:
    """(n,) [rad] 0..pi between orientations given as quaternions (n, 4); nan where one is unknown."""
    difference = np.minimum(
        np.linalg.norm(first - second, axis=1), np.linalg.norm(first + second, axis=1)
    )  # chord on the unit sphere: exact for small turns, where arccos loses half of the digits
    angle: Floats = 4.0 * np.arcsin(np.minimum(difference / 2.0, 1.0))
    return angle


class _Curve(NamedTuple):
    """A curved row's third point; it lies before the start (True) or beyond the target (False) of the row."""

    row: int
    third: int  # row in Positions
    before: bool


def shape_paths(
    moves: Moves,
    positions: Positions,
    end_of_arc: NDArray[np.bool_],
    whole: Mapping[int, int] | None = None,
) -> tuple[NDArray[np.int32], NDArray[np.bool_], Floats]:
    """(via, before, length): the third point that shapes each curved move (-1: straight), whether it lies before
    the start, and every path's length [m]. `whole`: rows that are arcs of their own -> a point beyond their target."""
    start, target = positions.position[moves.start], positions.position[moves.target]
    with np.errstate(over="ignore"):  # a place of 1e200 m is infinitely far
        length: Floats = np.linalg.norm(target - start, axis=1)
    via, earlier = np.full(len(moves), -1, dtype=np.int32), np.zeros(len(moves), dtype=bool)
    for code, measure in ((_CIRCULAR, _arc_length), (_SPLINE, _parabola_length)):
        own = [row for row in whole or () if moves.path[row] == code]
        rest = (
            np.setdiff1d(np.nonzero(moves.path == code)[0], own) if own else np.nonzero(moves.path == code)[0]
        )
        curves = _curves(moves, rest, end_of_arc)
        curves += [_Curve(row, (whole or {})[row], before=False) for row in own]
        if not curves:
            continue
        rows = np.array([curve.row for curve in curves])
        third = np.array([curve.third for curve in curves], dtype=np.int32)
        before = np.array([curve.before for curve in curves])
        via[rows], earlier[rows] = third, before
        length[rows] = measure(
            *_ordered(start[rows], target[rows], positions.position[third], before), before
        )
    return via, earlier, length


def _ordered(
    start: Floats, target: Floats, third: Floats, before: NDArray[np.bool_]
) -> tuple[Floats, Floats, Floats]:
    """The three points in the order in which the curve passes them."""
    early = before[:, None]
    return np.where(early, third, start), np.where(early, start, target), np.where(early, target, third)


def _curves(moves: Moves, rows: NDArray[np.intp], end_of_arc: NDArray[np.bool_]) -> list[_Curve]:
    chained = [False] * (len(rows) + 1)  # whether row i continues the chain that row i - 1 is in
    for i in range(1, len(rows)):
        chained[i] = _continues(moves, int(rows[i - 1]), int(rows[i]))
    curves = []
    for i, row in enumerate(rows):
        if not chained[i]:
            continue  # the first point of a chain is reached on a line
        ends_here = end_of_arc[row] or not chained[i + 1]
        starts_here = end_of_arc[rows[i - 1]] or not chained[i - 1]
        if not ends_here:
            curves.append(_Curve(int(row), int(moves.target[rows[i + 1]]), before=False))
        elif not starts_here or (i > 1 and chained[i - 1] and not end_of_arc[rows[i - 1]]):
            curves.append(_Curve(int(row), int(moves.start[rows[i - 1]]), before=True))
    return curves


def _continues(moves: Moves, before: int, here: int) -> bool:
    """Whether the same mechanism goes on curving from where the earlier curved row ended."""
    mechanism = moves.mechanism[here]
    between = moves.mechanism[before + 1 : here]
    return bool(
        moves.mechanism[before] == mechanism
        and moves.target[before] == moves.start[here]
        and not np.any(between == mechanism)
    )


def _arc_length(a: Floats, b: Floats, c: Floats, second: NDArray[np.bool_]) -> Floats:
    """Length [m] of the arc a-b (or b-c where `second`) of the circle that runs a, b, c; the chord on a line."""
    centre, radius, axis = circle(a, b, c)
    first, last = np.where(second[:, None], b, a), np.where(second[:, None], c, b)
    chord: Floats = np.linalg.norm(last - first, axis=1)
    with np.errstate(invalid="ignore"):
        swept = swept_angle(first - centre, last - centre, axis)
        result: Floats = np.where(np.isfinite(radius), radius * swept, chord)
    return result


def cross(a: Floats, b: Floats) -> Floats:
    """(n, 3), as NumPy's own, which takes five times as long for a few rows."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.stack((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx), axis=1)


def circle(a: Floats, b: Floats, c: Floats) -> tuple[Floats, Floats, Floats]:
    """The circle through three points (n, 3): centre [m], radius (n,) [m] (inf on a line), unit axis of a -> b -> c."""
    u, v = b - a, c - a
    w = cross(u, v)
    ww = np.sum(w * w, axis=1)
    uu, vv = np.sum(u * u, axis=1), np.sum(v * v, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = (cross(w, u) * vv[:, None] + cross(v, w) * uu[:, None]) / (2.0 * ww[:, None])
        axis = w / np.sqrt(ww)[:, None]
    # A via point within a millionth of the chord of the line gives no circle that anyone could have meant.
    radius = np.where(ww <= 1e-12 * uu * vv, np.inf, np.linalg.norm(offset, axis=1))
    return a + offset, radius, axis


_WHOLE_ARC: Final = math.radians(
    350.0
)  # beyond it an arc's ends are too near to each other to tell its circle


def arc_by_angle(start: Pose, via: Floats, end: Pose, angle: float) -> list[tuple[Floats, Pose]]:
    """(point on the way (3,) [m], end) of each arc that turns a tool by `angle` [rad] from `start` altogether.

    The circle runs through `start`, `via` (3,) [m] and `end`, and a positive angle turns in this order. The tool's turn
    is that from `start` to `end` (KSS manual, CIRC with CA; that the last orientation is the programmed one is not
    said there). Empty where the three points tell no circle.
    """
    centre, radius, axis = circle(start.position[None], via[None], end.position[None])
    if not np.isfinite(radius[0]) or not angle:
        return []
    spoke = start.position[None] - centre
    count = 1 if abs(angle) <= _WHOLE_ARC else math.ceil(abs(angle) / np.pi)
    turns = quaternion_from_rotation(start.rotation), quaternion_from_rotation(end.rotation)

    def point(share: float) -> Floats:
        sine, cosine = np.sin(angle * share), np.cos(angle * share)
        result: Floats = (centre + spoke * cosine + cross(axis, spoke) * sine)[0]
        return result

    def pose(share: float) -> Pose:
        return Pose(point(share), rotation_from_quaternion(slerp(*turns, share)))

    return [(point((k + 0.5) / count), pose((k + 1) / count)) for k in range(count)]


def swept_angle(first: Floats, last: Floats, axis: Floats) -> Floats:
    """(n,) [rad] 0..2 pi from one spoke to the other, turning about the unit axis."""
    sine, cosine = np.sum(axis * cross(first, last), axis=1), np.sum(first * last, axis=1)
    angle: Floats = np.arctan2(sine, cosine) % (2.0 * np.pi)
    return angle


def _parabola_length(a: Floats, b: Floats, c: Floats, second: NDArray[np.bool_]) -> Floats:
    """Length [m] of the part a-b (or b-c where `second`) of the parabola a, b, c with chord lengths as parameter."""
    curve = _parabola(a, b, c)
    low, high = np.where(second, curve.middle, 0.0), np.where(second, curve.end, curve.middle)
    t = low[:, None] + (high - low)[:, None] * _NODES
    slope = curve.d1[:, None, :] + (2.0 * t - curve.middle[:, None])[:, :, None] * curve.d2[:, None, :]
    length = (high - low) * (np.linalg.norm(slope, axis=2) @ _WEIGHTS)
    chord: Floats = np.linalg.norm(np.where(second[:, None], c - b, b - a), axis=1)
    result: Floats = np.where(np.isfinite(length), length, chord)
    return result


class _Parabola(NamedTuple):
    """p(t) = a + t d1 + t (t - middle) d2, from t = 0 at a over `middle` at b to `end` at c (chord lengths, [m])."""

    middle: Floats
    end: Floats
    d1: Floats
    d2: Floats


def _parabola(a: Floats, b: Floats, c: Floats) -> _Parabola:
    middle = np.linalg.norm(b - a, axis=1)
    end = middle + np.linalg.norm(c - b, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        d1 = (b - a) / middle[:, None]
        d2 = ((c - a) / end[:, None] - d1) / (end - middle)[:, None]
    return _Parabola(middle, end, d1, d2)


def point_on_arc(
    start: Floats, target: Floats, third: Floats, before: NDArray[np.bool_], fraction: Floats
) -> Floats:
    """(n, 3) [m]: where a circular move is at `fraction` (n,) of its length; on the chord where there is no circle."""
    centre, radius, axis = circle(*_ordered(start, target, third, before))
    spoke = start - centre
    with np.errstate(invalid="ignore"):
        angle = (swept_angle(spoke, target - centre, axis) * fraction)[:, None]
        point = centre + spoke * np.cos(angle) + cross(axis, spoke) * np.sin(angle)
    chord = start + (target - start) * fraction[:, None]
    result: Floats = np.where(np.isfinite(radius)[:, None], point, chord)
    return result


def point_on_parabola(
    start: Floats, target: Floats, third: Floats, before: NDArray[np.bool_], fraction: Floats
) -> Floats:
    """(n, 3) [m]: where a spline move is at `fraction` (n,) of its length; on the chord where there is no curve."""
    a, b, c = _ordered(start, target, third, before)
    curve = _parabola(a, b, c)
    low, high = np.where(before, curve.middle, 0.0), np.where(before, curve.end, curve.middle)
    with np.errstate(invalid="ignore"):
        t = _parameter(curve, low, high, fraction)[:, None]
    point = a + t * curve.d1 + t * (t - curve.middle[:, None]) * curve.d2
    chord = start + (target - start) * fraction[:, None]
    result: Floats = np.where(np.isfinite(point), point, chord)
    return result


_HALVINGS: Final = 46  # of an interval: the rest is below what a float tells of it
_EVEN: Final = 1e-5  # how much the parameter's pace changes along a piece whose length is proportional to it


def _parameter(curve: _Parabola, low: Floats, high: Floats, fraction: Floats) -> Floats:
    """(n,) the parameter between `low` and `high` at which a share of that piece's length is behind.

    The length is the integral of |u + 2 t d2|, in closed form; it grows with the parameter, so halving finds it. The
    parameter itself runs unevenly, and stands still where a path turns back at a point.
    """
    u = curve.d1 - curve.middle[:, None] * curve.d2
    square = 4.0 * np.sum(curve.d2**2, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        vertex = -2.0 * np.sum(u * curve.d2, axis=1) / square
        bend = np.maximum(np.sum(u**2, axis=1) / square - vertex**2, 0.0)

    def length(t: Floats) -> Floats:
        """Over the square root of `square`, from the vertex on."""
        x = t - vertex
        root = np.sqrt(x * x + bend)
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = np.where(bend > 0.0, bend * np.arcsinh(x / np.sqrt(bend)), 0.0)
        result: Floats = (x * root + turn) / 2.0
        return result

    even = low + (high - low) * fraction
    first, whole = length(low), length(high) - length(low)
    below, above = low.copy(), high.copy()
    for _ in range(_HALVINGS):
        t = (below + above) / 2.0
        short = length(t) - first < fraction * whole
        below, above = np.where(short, t, below), np.where(short, above, t)
    steady = ~(high - low > _EVEN * np.sqrt((low - vertex) ** 2 + bend))
    found: Floats = np.where(steady | ~np.isfinite(whole), even, (below + above) / 2.0)
    return found
