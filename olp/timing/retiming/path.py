"""Data of retiming: joints and their derivatives over the path length, and the limits found on each row."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SampledPath:
    """One path of n samples, or b of them with a leading axis: k axes over the place s.

    `place` (n,) or (b, n): s, increasing; metres of tool path, or any parameter.
    `first`, `second` (..., n, k): dq/ds [rad/m], d²q/ds² [rad/m²].
    """

    place: Floats
    first: Floats
    second: Floats

    @classmethod
    def through(cls, place: ArrayLike, joints: ArrayLike, pieces: int = 10) -> SampledPath:
        """Path through `joints` (n, k) or (b, n, k) at `place` (n,): a cubic spline with `pieces` samples per span.

        Raises OlpError (L001) when the places do not increase or the shapes do not fit.
        """
        s, q = np.asarray(place, dtype=np.float64), np.asarray(joints, dtype=np.float64)
        if q.ndim not in (2, 3) or s.shape != (q.shape[-2],) or pieces < 1:
            raise OlpError(error("L001", f"joints {q.shape} do not fit the places {s.shape} of a path"))
        along_first = np.moveaxis(q, -2, 0)
        spline = spline_through(s, along_first)
        steps = np.arange(pieces) / pieces
        grid = np.append((s[:-1, None] + np.diff(s)[:, None] * steps).ravel(), s[-1])
        _, first, second = spline(grid)
        wide = np.broadcast_to(grid, (*q.shape[:-2], len(grid)))
        return cls(wide, np.moveaxis(first, 0, -2), np.moveaxis(second, 0, -2))


# --- Spline ---
# Cubic splines through points: joints between the samples of a path, with their derivatives.


@dataclass(frozen=True, slots=True)
class Spline:
    """Piecewise cubic in s with two continuous derivatives: `knots` (n,), `values` and `bends` (n, ...)."""

    knots: Floats
    values: Floats
    bends: Floats  # second derivatives at the knots

    def __call__(self, s: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Value, first and second derivative (m, ...) at `s` (m,); beyond the ends the outer pieces continue."""
        at = np.asarray(s, dtype=np.float64)
        i = np.clip(np.searchsorted(self.knots, at, side="right") - 1, 0, len(self.knots) - 2)
        extra = (1,) * (self.values.ndim - 1)
        h = (self.knots[i + 1] - self.knots[i]).reshape(-1, *extra)
        right = (at - self.knots[i]).reshape(-1, *extra) / h
        left = 1.0 - right
        y0, y1, m0, m1 = self.values[i], self.values[i + 1], self.bends[i], self.bends[i + 1]
        value = left * y0 + right * y1 + h * h / 6 * ((left**3 - left) * m0 + (right**3 - right) * m1)
        first = (y1 - y0) / h + h / 6 * ((3 * right**2 - 1) * m1 - (3 * left**2 - 1) * m0)
        return value, first, left * m0 + right * m1


def spline_through(s: ArrayLike, points: ArrayLike) -> Spline:
    """The cubic spline through `points` (n, ...) at `s` (n,), whose two outer pieces on each side are one cubic.

    (Not-a-knot ends: C. de Boor, "A Practical Guide to Splines", 1978, chapter IV.) Three points give a parabola,
    two a line. Raises OlpError (L001) when s does not increase or has fewer than two values.
    """
    knots, values = np.asarray(s, dtype=np.float64), np.asarray(points, dtype=np.float64)
    if knots.ndim != 1 or len(knots) < 2 or len(values) != len(knots) or not (np.diff(knots) > 0).all():
        raise OlpError(error("L001", "a path needs two or more samples at increasing places"))
    extra = (1,) * (values.ndim - 1)
    h = np.diff(knots)
    slopes = np.diff(values, axis=0) / h.reshape(-1, *extra)
    bends = np.zeros_like(values)
    if len(knots) == 3:
        bends[:] = 2.0 * (slopes[1] - slopes[0]) / (h[0] + h[1])
    elif len(knots) > 3:
        _solve(h, 6.0 * np.diff(slopes, axis=0), bends)
    return Spline(knots, values, bends)


def _solve(h: Floats, right: Floats, bends: Floats) -> None:
    """Writes the second derivatives into `bends`: elimination in the tridiagonal system of the inner knots."""
    below, above = h[:-1].copy(), h[1:].copy()
    main = 2.0 * (h[:-1] + h[1:])
    main[0] += h[0] + h[0] ** 2 / h[1]
    above[0] -= h[0] ** 2 / h[1]
    main[-1] += h[-1] + h[-1] ** 2 / h[-2]
    below[-1] -= h[-1] ** 2 / h[-2]
    rows = right.copy()
    diagonal, lower, upper = main.tolist(), below.tolist(), above.tolist()
    for i in range(1, len(rows)):
        share = lower[i] / diagonal[i - 1]
        diagonal[i] -= share * upper[i - 1]
        rows[i] -= share * rows[i - 1]
    rows[-1] /= diagonal[-1]
    for i in range(len(rows) - 2, -1, -1):
        rows[i] = (rows[i] - upper[i] * rows[i + 1]) / diagonal[i]
    bends[1:-1] = rows
    bends[0] = rows[0] + (rows[0] - rows[1]) * (h[0] / h[1])
    bends[-1] = rows[-1] + (rows[-1] - rows[-2]) * (h[-1] / h[-2])


class Singular(IntEnum):
    """Which singularity a row passes, in the order of olp.robots.kinematics.Clearance."""

    NONE = -1
    WRIST = 0
    ELBOW = 1
    SHOULDER = 2


@dataclass(slots=True)
class PathLimits:
    """Limits per row of Moves, (m,); lengths are metres of tool path, or radians where only the tool turns.

    `known`: the row is a line, an arc or a spline with known axes; all other rows have only `outside`. `speed`
    [m/s]: the highest at which no axis exceeds its own anywhere on the row, inf where nothing moves; `axis` (-1:
    none) is the first that would exceed it, at `place` [m] from the start. `acceleration` [m/s²]: the highest from
    standstill that all axes allow, inf where none is known. `paced` [m/s]: mean speed of a run that enters and
    leaves the row at the programmed speed and slows down only where an axis needs it; otherwise the programmed
    speed. `singular`: a Singular, -1 if none; such a row has no trustworthy limits (nan), and `paced` is the
    programmed speed. `nearness` [rad] (shoulder [m]): the smallest distance from it. `lost`: distance [m] from the
    start at which a pose is out of reach, nan if none; such a row has no limits (nan) either. `outside` (-1: none):
    an axis that leaves its soft limits.
    """

    known: NDArray[np.bool_]
    speed: Floats
    axis: NDArray[np.int8]
    place: Floats
    acceleration: Floats
    paced: Floats
    singular: NDArray[np.int8]
    nearness: Floats
    lost: Floats
    outside: NDArray[np.int8]
    diagnostics: tuple[Diagnostic, ...] = ()
    assumptions: tuple[str, ...] = ()

    @classmethod
    def nothing(cls, count: int, programmed: Floats) -> PathLimits:
        """Rows without any known limit."""
        nan, none = np.full(count, np.nan), np.full(count, -1, dtype=np.int8)
        return cls(
            known=np.zeros(count, dtype=np.bool_),
            speed=np.full(count, np.inf),
            axis=none.copy(),
            place=nan.copy(),
            acceleration=np.full(count, np.inf),
            paced=programmed.copy(),
            singular=none.copy(),
            nearness=nan.copy(),
            lost=nan.copy(),
            outside=none,
        )
