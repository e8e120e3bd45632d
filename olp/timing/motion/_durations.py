"""Durations of many synchronised moves from rest to rest with limited jerk, without their profiles."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from olp.core import compiled_loops
from olp.core.diagnostic import OlpError, error, raise_errors
from olp.timing.motion._profile import Floats

_BLOCK = 4096  # moves at a time: all arrays of a block together stay in the second-level cache
_SAVING = 1.2e-7  # [s] per axis and move that compiled code saves, measured by bench/profiles.py


class Law(NamedTuple):
    """Coefficients of T(L) of one axis from rest to rest, piece by piece; see `durations`. Numbers, or one per move."""

    cruises: Floats  # L [m] from which the programmed speed is reached
    holds: Floats  # L [m] from which the acceleration limit is reached
    pace: Floats  # 1 / speed [s/m]
    extra: Floats  # what a move that cruises takes longer than L / speed [s]
    ramp: Floats  # [s]
    slow: Floats  # 4 / acceleration [s²/m]
    offset: Floats  # [s²]
    root: Floats  # cube of T / L^(1/3) [s³/m]


def durations(
    length: ArrayLike,
    speed: ArrayLike,
    acceleration: ArrayLike,
    k1: ArrayLike,
    k2: ArrayLike | None = None,
    compiled: bool | None = None,
) -> Floats:
    """Seconds (n,) of n moves of k synchronised axes, each from rest to rest: the slowest axis decides.

    `length` (n, k) [m or rad], its sign does not matter; the limits [per s, s², s³] are numbers, (k,) per axis
    or (n, k); `k2` is `k1` when left out. The law is that of the `linear` motion model (Apostolovic's thesis,
    section 4.3), from rest to rest solved for T. With v, a the limits, p = 1/k1, q = 1/k2, S = p + q and
    C = p²/6 + pq/2 + q²/3 (the length of a change of speed is C a³):
      T³ = 4 S³ L / C                                   until a is reached, at L = 2 C a³;
      T = a p + √(4 L/a + a² (4 q² - p²)/3)             from then on;
      T = L/v + v/a + a p - a³ (p² - q²)/(12 v)         where v is reached and a too,
      T = L/v + b (2 S - 4 C/S), b = √(2 v/S)           where v is reached and a is not.
    `compiled`: as in olp.core.compiled_loops.use. Raises OlpError (T001) for numbers that are not finite,
    limits not above zero and shapes that do not fit, F001.
    """
    distance = np.abs(np.asarray(length, dtype=np.float64))
    if distance.ndim != 2:
        raise OlpError(error("T001", f"lengths need the shape (moves, axes), not {distance.shape}"))
    given = {"speed": speed, "acceleration": acceleration, "k1": k1, "k2": k2}
    limits = {n: np.asarray(value, dtype=np.float64) for n, value in given.items() if value is not None}
    _check(distance, limits)
    count, axes = distance.shape
    same = all(limit.ndim < 2 for limit in limits.values())
    table = [np.broadcast_to(limit, (axes,) if same else distance.shape) for limit in limits.values()]
    v, a, onset, release = (*table, table[2])[:4]
    result = np.zeros(count)
    if compiled_loops.use(compiled, _SAVING * distance.size):
        if same:
            _one_law(distance, *_law(v, a, onset, release), result)
        else:
            _many_laws(distance, v, a, onset, release, result)
        return result
    laws = list(map(Law._make, zip(*_law(v, a, onset, release), strict=True))) if same else []
    for start in range(0, count, _BLOCK):
        part = slice(start, start + _BLOCK)
        best = result[part]
        for axis in range(axes):
            law = laws[axis] if same else _law(*_columns((v, a, onset, release), part, axis))
            np.maximum(best, _time(np.ascontiguousarray(distance[part, axis]), law), out=best)
    return result


def _columns(limits: tuple[Floats, ...], part: slice, axis: int) -> list[Floats]:
    """Limits of one axis from (n, k) limits; k1 and k2 stay one array if they are the same array."""
    columns = [np.ascontiguousarray(limit[part, axis]) for limit in limits[:3]]
    same = limits[2] is limits[3]
    return [*columns, columns[2] if same else np.ascontiguousarray(limits[3][part, axis])]


def _check(distance: Floats, limits: dict[str, Floats]) -> None:
    problems = []
    if not np.isfinite(distance).all():
        problems.append(error("T001", "length is not finite everywhere"))
    for name, limit in limits.items():
        if not (np.isfinite(limit) & (limit > 0)).all():
            problems.append(error("T001", f"{name} has to be finite and positive"))
        try:
            np.broadcast_to(limit, distance.shape)
        except ValueError:
            problems.append(error("T001", f"{name} of shape {limit.shape} does not fit {distance.shape}"))
    raise_errors(problems)


def _law(v: Floats, a: Floats, k1: Floats, k2: Floats) -> Law:
    if k1 is k2:
        return _symmetric_law(v, a, k1)
    p, q = 1 / k1, 1 / k2
    s = p + q
    c = p * p / 6 + p * q / 2 + q * q / 3
    b = np.sqrt(2 * v / s)  # acceleration at which v is reached without holding it
    holds = b > a
    squares = a * a * a * (p - q) * s / 12
    rise = v * (v / a + a * q) + squares
    return Law(
        np.where(holds, rise, 2 * c * b * b * b),
        2 * c * a * a * a,
        1 / v,
        np.where(holds, v / a + a * p - squares / v, b * (2 * s - 4 * c / s)),
        a * p,
        4 / a,
        a * a * (4 * q * q - p * p) / 3,
        4 * s * s * s / c,
    )


def _symmetric_law(v: Floats, a: Floats, k: Floats) -> Law:
    """`_law` for k1 = k2, where most terms vanish."""
    p = 1 / k
    b = np.sqrt(v * k)  # acceleration at which v is reached without holding it
    held = np.minimum(a, b)
    ramp = a * p
    extra = v / held + held * p
    return Law(v * extra, 2 * ramp * ramp * a, 1 / v, extra, ramp, 4 / a, ramp * ramp, 32 * p)


def _time(length: Floats, law: Law) -> Floats:
    """Duration [s] of moves (n,) of one axis."""
    time: Floats = np.sqrt(np.maximum(length * law.slow + law.offset, 0.0))
    time += law.ramp
    short = np.flatnonzero(length < law.holds)
    if len(short):
        root = law.root[short] if np.ndim(law.root) else law.root
        time[short] = np.cbrt(length[short] * root)
    np.copyto(time, length * law.pace + law.extra, where=length >= law.cruises)
    return time


@compiled_loops.Kernel
def _one_law(
    length: Floats, cruises: Floats, holds: Floats, pace: Floats, extra: Floats,
    ramp: Floats, slow: Floats, offset: Floats, root: Floats, result: Floats,
) -> None:  # fmt: skip
    for i in range(length.shape[0]):
        longest = 0.0
        for k in range(length.shape[1]):
            way = length[i, k]
            if way >= cruises[k]:
                time = way * pace[k] + extra[k]
            elif way >= holds[k]:
                time = ramp[k] + sqrt(way * slow[k] + offset[k])
            elif way * root[k] > longest * longest * longest:
                time = np.cbrt(way * root[k])
            else:
                continue
            longest = max(longest, time)
        result[i] = longest


@compiled_loops.Kernel
def _many_laws(length: Floats, v: Floats, a: Floats, k1: Floats, k2: Floats, result: Floats) -> None:
    for i in range(length.shape[0]):
        longest = 0.0
        for k in range(length.shape[1]):
            way, speed, limit = length[i, k], v[i, k], a[i, k]
            p, q = 1 / k1[i, k], 1 / k2[i, k]
            s = p + q
            c = p * p / 6 + p * q / 2 + q * q / 3
            squares = limit * limit * limit * (p - q) * s / 12
            holds = 2 * speed > limit * limit * s
            b = 0.0 if holds else sqrt(2 * speed / s)
            if way >= (speed * (speed / limit + limit * q) + squares if holds else 2 * c * b * b * b):
                extra = speed / limit + limit * p - squares / speed if holds else b * (2 * s - 4 * c / s)
                time = way / speed + extra
            elif way >= 2 * c * limit * limit * limit:
                time = limit * p + sqrt(4 * way / limit + limit * limit * (4 * q * q - p * p) / 3)
            elif way * 4 * s * s * s / c > longest * longest * longest:
                time = np.cbrt(way * 4 * s * s * s / c)
            else:
                continue
            longest = max(longest, time)
        result[i] = longest
