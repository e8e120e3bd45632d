"""Paths as retiming sees them: joints and their derivatives over the length of the path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.timing.retiming.spline import spline_through

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
        """Through `joints` (n, k) or (b, n, k) at `place` (n,) on a cubic spline, `pieces` samples per span.

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
