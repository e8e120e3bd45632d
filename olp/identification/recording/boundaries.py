"""When a move ends, to a fraction of a sample: where the arm comes to rest and leaves again, or passes nearest by."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_LEAST_STILL = 5e-5  # [m] movements below this are rest
_NOISES = 6.0
_NEAR = 0.010  # [m] a rest farther from its point than this (and 3 times the nearest) is another one


class Rest(NamedTuple):
    """[s] when the arm came to rest and when it left; nan where the log does not show it. `place` (c,) [m]."""

    arrive: float
    leave: float
    place: Floats


def stillness(time: Floats, place: Floats) -> float:
    """[m] below which a movement is noise: six times the scatter while the arm hardly moves, at least 0.05 mm.

    From second differences, which a steady motion does not feel: var = 6 σ².
    """
    if len(time) < 5:
        return _LEAST_STILL
    bend = np.linalg.norm(place[2:] - 2 * place[1:-1] + place[:-2], axis=1)
    speed = np.linalg.norm(place[2:] - place[:-2], axis=1)
    slow = bend[speed <= np.quantile(speed, 0.2)]
    noise = float(np.median(slow)) / math.sqrt(6.0)
    return max(_LEAST_STILL, _NOISES * noise)


def rest(time: Floats, place: Floats, point: Floats, still: float, dwells: bool = False) -> Rest | None:
    """The rest near `point` (c,) in samples (n,), (n, c); None when the arm does not stop there.

    `still` [m]: see `stillness`. `dwells`: the program waits there, so it is no turning point however short.
    """
    if len(time) < 3:
        return None
    distance = np.linalg.norm(place - point, axis=1)
    near = np.nonzero(distance <= max(3 * distance.min(), _NEAR))[0]
    pace = np.full(len(time), np.inf)
    inner = near[(near > 0) & (near < len(time) - 1)]
    span = np.maximum(time[inner + 1] - time[inner - 1], 1e-9)
    pace[inner] = np.linalg.norm(place[inner + 1] - place[inner - 1], axis=1) / span
    for end, beside in ((0, 1), (len(time) - 1, len(time) - 2)):
        if end in near:
            pace[end] = np.linalg.norm(place[end] - place[beside]) / max(abs(time[end] - time[beside]), 1e-9)
    if not np.isfinite(pace).any():
        return None
    slowest = int(np.argmin(pace))
    away = np.linalg.norm(place - place[slowest], axis=1)
    first, last = _run(away <= still, slowest)
    centre = np.median(place[first : last + 1], axis=0)
    away = np.linalg.norm(place - centre, axis=1)
    if away[slowest] <= still:
        first, last = _run(away <= still, slowest)
    after, before = (time[last:], away[last:]), (-time[: first + 1][::-1], away[: first + 1][::-1])
    turned = None if dwells else _turning_point(after, before, still)
    if turned is not None:
        return Rest(turned, turned, centre)
    return Rest(-_begin(*before, still), _begin(*after, still), centre)


def _turning_point(after: tuple[Floats, Floats], before: tuple[Floats, Floats], still: float) -> float | None:
    """[s] the instant of a stop too short to tell its two ends apart, None for a real rest.

    A motion that goes as t^p from its turning point passes s, 4 s and 16 s at times that grow by r = 4^(1/p) each. So
    it is within s for 2/(r - 1) times as long as it takes from s to 4 s, and √r times that where the samples within
    reach all lie on one side.
    """
    levels = (still, 4 * still, 16 * still)
    left, within = [], 0.0
    for time, away in (after, before):
        beyond = [np.nonzero(away >= reach)[0] for reach in levels]
        if not len(beyond[0]) or not len(beyond[1]) or not beyond[0][0]:
            return None
        passed = [_crossing(time, away, int(i[0]), r) for i, r in zip(beyond, levels, strict=True) if len(i)]
        quick = passed[1] - passed[0]
        growth = (passed[2] - passed[1]) / max(quick, 1e-12) if len(passed) > 2 else 2.0
        growth = min(max(growth, 1.5), 4.0)
        within = max(within, 2 * growth**0.5 / (growth - 1) * quick)
        left.append(passed[0])
    leave, came = left
    shortest = 1.1 * within + float(after[0][1] - after[0][0])
    return (leave - came) / 2 if leave + came < shortest else None


def _crossing(time: Floats, away: Floats, index: int, level: float) -> float:
    """[s] at which `away` passes `level` between sample `index` - 1 and `index`."""
    share = (level - away[index - 1]) / max(away[index] - away[index - 1], 1e-15)
    return float(time[index - 1] + np.clip(share, 0.0, 1.0) * (time[index] - time[index - 1]))


def _run(inside: NDArray[np.bool_], at: int) -> tuple[int, int]:
    """First and last index of the unbroken run of True around `at`."""
    outside = np.nonzero(~inside)[0]
    cut = int(np.searchsorted(outside, at))
    first = int(outside[cut - 1]) + 1 if cut else 0
    last = int(outside[cut]) - 1 if cut < len(outside) else len(inside) - 1
    return first, last


def _begin(time: Floats, away: Floats, still: float) -> float:
    """[s] when a motion began whose first sample here is still at rest; nan when nothing moves.

    The samples from s to 16 s beyond the rest, at least three, are carried back to zero as a motion at constant speed
    or, when that fits them better, at constant acceleration.
    """
    beyond = np.nonzero(away > still)[0]
    if not len(beyond):
        return float("nan")
    first = int(beyond[0])
    far = np.nonzero(away > 16 * still)[0]
    last = min(max(int(far[0]) if len(far) else len(away), first + 3), len(away))
    falls = np.nonzero(np.diff(away[first:last]) <= 0)[0]
    if len(falls) and last - first <= 3:
        last = first + 1 + int(falls[0])
    crossing = _crossing(time, away, first, still)
    if last - first < 2:
        return crossing
    t, x = time[first:last] - time[first], away[first:last]
    fits = []
    for shape in (x, np.sqrt(x)):
        slope, height = np.polyfit(t, shape, 1)
        if slope > 0:
            misfit = float(np.abs(slope * t + height - shape).max() / shape[-1])
            fits.append((misfit, float(time[first] - height / slope)))
    if not fits:
        return crossing
    # Two samples fit both: a motion that doubles its speed within them is still accelerating.
    chosen = min(fits)[1] if last - first > 2 else fits[-1 if x[1] > 2.5 * x[0] else 0][1]
    # The slowest begin taken for real, at constant jerk, is within s for 1.7 times as long as from s to 4 s.
    double = np.nonzero(away > 4 * still)[0]
    reach = 2 * (_crossing(time, away, int(double[0]), 4 * still) - crossing) if len(double) else 0.0
    return float(np.clip(chosen, min(float(time[first - 1]), crossing - reach), crossing))


def pass_by(time: Floats, place: Floats, point: Floats) -> tuple[float, float]:
    """When the way is nearest to `point`, on the straight pieces between samples [s], and how near [m]."""
    near = place - point
    if len(time) == 1:
        return float(time[0]), float(np.linalg.norm(near[0]))
    step = np.diff(near, axis=0)
    square = np.maximum(np.einsum("ij,ij->i", step, step), 1e-18)
    share = np.clip(-np.einsum("ij,ij->i", near[:-1], step) / square, 0.0, 1.0)
    distance = np.linalg.norm(near[:-1] + share[:, None] * step, axis=1)
    best = int(np.argmin(distance))
    return float(time[best] + share[best] * (time[best + 1] - time[best])), float(distance[best])
