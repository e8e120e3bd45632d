"""The speed and acceleration that a simulation was tuned to, read off its own durations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_HOLD = 0.9  # of the moves between stops: so many have to come out within the digits
_FEWEST = 8  # moves between stops
_FULL = 4  # moves that reach their speed
_ROUNDS = 6
_WIDEST = 3.0  # times the programmed speed, and one over it
_CONDITION = 1e4
_PROGRAMMED = 1e-5  # [1] a factor nearer to 1 is none


def pace_of_simulation(
    way: Floats, speed: Floats, sim: Floats, slow: Floats, plain: Mask, resolution: float
) -> tuple[float, float] | None:
    """Factor on programmed speeds and one acceleration [m/s²] that make all moves between stops (`plain`) take what the
    simulation says; none where programmed speeds do already, or where no such pair does. `slow` (n,) [m/s²]: what is
    known of accelerations, nan: nothing.

    sim = L/(k v) + k v/a of moves that reach their speed: linear in 1/k and k/a.
    """
    rows = np.nonzero(plain & np.isfinite(sim) & (way > 0) & (speed > 0))[0]
    if len(rows) < _FEWEST:
        return None
    length, asked, took = way[rows], speed[rows], sim[rows]
    digits, given = _digits(took, resolution), slow[rows]
    if np.isfinite(given).all() and _held(_said(length, asked, given), took, digits) >= _HOLD:
        return None
    factor, one = 1.0, _first(length, asked, took)
    for _ in range(_ROUNDS):
        if _held(_said(length, factor * asked, one), took, digits) >= _HOLD:
            # Programmed speeds alone are left to the inference that needs no factor.
            return (factor, one) if abs(factor - 1.0) > _PROGRAMMED else None
        found = _solved(length, asked, took, factor, one, digits)
        if found is None:
            return None
        factor, one = found
    return None


def _digits(sim: Floats, resolution: float) -> float:
    """[s] to which the simulation's durations are written: its own digits, never coarser than the recorder's."""
    for places in range(1, 5):
        if np.allclose(sim * 10**places, np.round(sim * 10**places), atol=1e-3):
            return max(min(10.0**-places, float(np.nan_to_num(resolution)) or np.inf), 1e-4)
    return 1e-4


def _said(way: Floats, speed: Floats, slow: Floats | float) -> Floats:
    """(n,) [s] of trapezoids."""
    ramp = speed / slow
    return np.asarray(np.where(way >= speed * ramp, way / speed + ramp, 2.0 * np.sqrt(way / slow)))


def _held(said: Floats, sim: Floats, digits: float) -> float:
    """Share of the moves that come out within the digits."""
    return float(np.mean(np.abs(said - sim) <= 1.01 * digits))


def _first(way: Floats, speed: Floats, sim: Floats) -> float:
    """[m/s²] of the shortest moves, which hardly reach their speed."""
    slow = 4.0 * way / sim**2
    return float(np.median(np.sort(slow)[-max(len(slow) // 3, 1) :]))


def _solved(
    way: Floats, speed: Floats, sim: Floats, factor: float, one: float, digits: float
) -> tuple[float, float] | None:
    """The next pair, from the moves that reach their speed and, once a pair is near, come out nearly right."""
    full = way >= 1.2 * (factor * speed) ** 2 / one
    off = np.abs(_said(way, factor * speed, one) - sim)
    near = full & (off <= max(4.0 * digits, 2.0 * float(np.median(off[full])) if full.any() else 0.0))
    columns = np.stack([way / speed, speed], axis=1)[near]
    if near.sum() < _FULL or np.linalg.cond(columns / np.linalg.norm(columns, axis=0)) > _CONDITION:
        return None
    (slower, ramp), *_ = np.linalg.lstsq(columns, sim[near], rcond=None)
    if slower <= 0 or ramp <= 0 or not 1.0 / _WIDEST < slower < _WIDEST:
        return None
    return float(1.0 / slower), float(1.0 / (slower * ramp))
