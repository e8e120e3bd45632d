"""The fastest motion along a path within limits, and which limit rules where."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core import compiled_loops
from olp.core.diagnostic import OlpError, error
from olp.timing.retiming.kernel import sweep_one
from olp.timing.retiming.path import SampledPath
from olp.timing.retiming.sweep import Strips, sweep

Floats = NDArray[np.float64]

_SAVING = 2e-6  # [s] per sample that compiled code saves, measured by bench/retiming.py
_AT_ONCE = 20_000  # samples at a time: their arrays stay in the cache


class LimitKind(StrEnum):
    """What kind of limit rules."""

    SPEED = "speed"
    ACCELERATION = "acceleration"
    PATH_SPEED = "path speed"
    PATH_ACCELERATION = "path acceleration"
    FURTHER = "further limit"


class Limiter(NamedTuple):
    """A limit by name: the number of its axis (or of the further limit), -1 for those of the path."""

    axis: int
    kind: LimitKind


class Further(NamedTuple):
    """More limits low <= p u + r x <= high with x = (ds/dt)², u = d²s/dt², (..., n, j) each; low < 0 < high.

    Torques are such: p = M q', r = M q'' + C(q') q', and the bounds less gravity and friction.
    """

    p: Floats
    r: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True, slots=True)
class Retimed:
    """The motion along n samples of a path, or of b paths with a leading axis.

    `place`, `speed` ds/dt, `time` [s] (..., n); `acceleration` d²s/dt² (..., n - 1), constant between samples.
    `limiter` (..., n - 1): index into `names` of the limit that is used most; `usage` (..., n - 1): how much of
    it [1]. `excess` (...): the largest share by which any limit is exceeded at a sample or halfway between two.
    Where start or end speed is not possible, `speed` begins or ends with the largest one that is.
    """

    place: Floats
    speed: Floats
    time: Floats
    acceleration: Floats
    limiter: NDArray[np.int16]
    usage: Floats
    excess: Floats
    names: tuple[Limiter, ...]

    @property
    def duration(self) -> Floats:
        """[s] (...)"""
        return self.time[..., -1]


class _Limits(NamedTuple):
    """Everything of b paths, (b, n, m) or (b, n)."""

    names: tuple[Limiter, ...]  # of path speed, axis speeds, then of the m rows
    p: Floats
    r: Floats
    low: Floats
    high: Floats
    rated: Floats  # (b, n, k): largest speeds of the axes
    speeds: Floats  # (b, n, k + 1): largest ds/dt by the path and by each axis


def retime(
    path: SampledPath,
    speed: ArrayLike,
    acceleration: ArrayLike,
    path_speed: ArrayLike = np.inf,
    path_acceleration: ArrayLike = np.inf,
    start_speed: ArrayLike = 0.0,
    end_speed: ArrayLike = 0.0,
    further: Further | None = None,
    compiled: bool | None = None,
) -> Retimed:
    """Retimes `path`: the fastest motion in which no limit is exceeded.

    `speed` [rad/s], `acceleration` [rad/s²]: of the axes, (k,) or along the path (..., n, k). `path_speed` [m/s]
    and `path_acceleration` [m/s²], numbers or (..., n), limit ds/dt and d²s/dt²: a controller's programmed speed
    and acceleration. `start_speed`, `end_speed` [m/s], a number or one per path. `compiled`: as in
    olp.core.compiled_loops.use. Raises OlpError: L002 for numbers that are not finite,
    shapes that do not fit or limits not above zero; F001.
    """
    single = path.place.ndim == 1
    limits = _limits(path, speed, acceleration, path_speed, path_acceleration, further)
    place = np.atleast_2d(path.place)
    count = len(place)
    start, end = (
        np.broadcast_to(np.asarray(v, dtype=np.float64), (count,)) for v in (start_speed, end_speed)
    )
    if not (np.isfinite(start) & np.isfinite(end) & (start >= 0) & (end >= 0)).all():
        raise OlpError(error("L002", "start and end speeds have to be finite and not negative"))
    on = compiled_loops.use(compiled, _SAVING * place.size)
    chunk = max(1, _AT_ONCE // place.shape[1])
    parts = []
    for begin in range(0, count, chunk):
        at = slice(begin, begin + chunk)
        some = _Limits(limits.names, *(part[at] for part in limits[1:]))
        squares = _swept(place[at], some, start[at] ** 2, end[at] ** 2, on)
        parts.append(_told(place[at], some, squares))
    return _joined(parts, single)


def _limits(
    path: SampledPath,
    speed: ArrayLike,
    acceleration: ArrayLike,
    path_speed: ArrayLike,
    path_acceleration: ArrayLike,
    further: Further | None,
) -> _Limits:
    shape = (-1, *path.first.shape[-2:])
    first, second = path.first.reshape(shape), path.second.reshape(shape)
    try:
        v, a = (
            np.broadcast_to(np.asarray(x, dtype=np.float64), path.first.shape) for x in (speed, acceleration)
        )
        travel, push = (
            np.broadcast_to(np.asarray(x, dtype=np.float64), path.first.shape[:-1])
            for x in (path_speed, path_acceleration)
        )
    except ValueError as problem:
        raise OlpError(error("L002", f"limits do not fit the path: {problem}")) from None
    sound = np.isfinite(first).all() and np.isfinite(second).all() and np.isfinite(path.place).all()
    if not (sound and (v > 0).all() and (a > 0).all() and (travel > 0).all() and (push > 0).all()):
        raise OlpError(error("L002", "a path has to be finite and its limits have to be above zero"))
    axes = range(first.shape[2])
    with np.errstate(divide="ignore"):
        by_axis = v.reshape(shape) / np.abs(first)
    rows = [(first, second, -a.reshape(shape), a.reshape(shape))]
    names = [Limiter(axis, LimitKind.ACCELERATION) for axis in axes]
    if not np.isinf(push).all():
        bound = push.reshape(*first.shape[:2], 1)
        rows.append((np.ones_like(bound), np.zeros_like(bound), -bound, bound))
        names.append(Limiter(-1, LimitKind.PATH_ACCELERATION))
    if further is not None:
        count = further.p.shape[-1]
        rows.append(tuple(np.broadcast_to(f, (*first.shape[:2], count)) for f in further))  # type: ignore[arg-type]
        names += [Limiter(i, LimitKind.FURTHER) for i in range(count)]
    p, r, low, high = (np.concatenate(parts, axis=2) for parts in zip(*rows, strict=True))
    speeds = np.concatenate((travel.reshape(*first.shape[:2], 1), by_axis), axis=2)
    of_speeds = [Limiter(-1, LimitKind.PATH_SPEED), *(Limiter(axis, LimitKind.SPEED) for axis in axes)]
    # A path along which nothing moves has no speed; any large one will do, for the time is that of other limits.
    return _Limits((*of_speeds, *names), p, r, low, high, v.reshape(shape), np.minimum(speeds, 1e9))


def _cap(place: Floats, limits: _Limits) -> Floats:
    """(b, n): largest ds/dt squared by the speeds of path and axes, also between the samples.

    Between two samples q' of a spline is quadratic and x is a line; where their product would exceed an axis's speed
    both ends give way by that share.
    """
    cap: Floats = limits.speeds.min(axis=2) ** 2
    axes = slice(limits.rated.shape[2])
    q, bend = limits.p[:, :, axes], limits.r[:, :, axes]
    limit = np.minimum(limits.rated[:, :-1], limits.rated[:, 1:])
    middle = (q[:, :-1] + q[:, 1:]) / 2 + np.diff(place)[:, :, None] / 4 * (bend[:, :-1] - bend[:, 1:])
    worst = np.ones((len(cap), cap.shape[1] - 1))
    for u in (0.25, 0.5, 0.75):
        between = (1 - u) ** 2 * q[:, :-1] + 2 * u * (1 - u) * middle + u**2 * q[:, 1:]
        used = np.square(between / limit).max(axis=2)
        np.maximum(worst, used * ((1 - u) * cap[:, :-1] + u * cap[:, 1:]), out=worst)
    cap[:, :-1] /= worst
    cap[:, 1:] /= np.maximum(worst, 1.0)
    return cap


def _swept(place: Floats, limits: _Limits, start: Floats, end: Floats, compiled: bool) -> Floats:
    """(b, n): ds/dt squared."""
    cap, step = _cap(place, limits), np.diff(place, axis=1)
    axes = limits.rated.shape[2]
    if not compiled:
        p, r, low, high = (np.ascontiguousarray(np.moveaxis(part, 0, -1)) for part in limits[1:5])
        return sweep(Strips(p, r, low, high, cap.T, step.T, axes), start, end).T
    squares = np.empty_like(cap)
    # One layout in memory, or each combination of layouts would be compiled by itself.
    p, r, low, high = (np.ascontiguousarray(part) for part in limits[1:5])
    for i in range(len(place)):
        sweep_one(p[i], r[i], low[i], high[i], cap[i], step[i], axes, start[i], end[i], squares[i])
    return squares


def _told(place: Floats, limits: _Limits, squares: Floats) -> Retimed:
    speed = np.sqrt(squares)
    step = np.diff(place, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        spent = np.where(step > 0, 2.0 * step / (speed[:, 1:] + speed[:, :-1]), 0.0)
    rate = np.diff(squares, axis=1) / (2.0 * step)
    time = np.concatenate((np.zeros((len(place), 1)), np.cumsum(spent, axis=1)), axis=1)
    by_speed = speed[:, :, None] / limits.speeds
    ends = [_used(limits, part, rate, squares[:, part]) for part in (slice(None, -1), slice(1, None))]
    usage = np.concatenate((np.maximum(by_speed[:, 1:], by_speed[:, :-1]), np.maximum(*ends)), axis=2)
    limiter = np.argmax(usage, axis=2)
    used = np.take_along_axis(usage, limiter[:, :, None], axis=2)[:, :, 0]
    halfway = _halfway(limits, rate, squares)
    excess = np.maximum(used.max(axis=1), halfway) - 1.0
    return Retimed(
        place, speed, time, rate, limiter.astype(np.int16), used, np.maximum(excess, 0.0), limits.names
    )


def _used(limits: _Limits, part: slice, rate: Floats, squares: Floats) -> Floats:
    """(b, n - 1, m): share of each limit that is used at the samples of `part`."""
    value = limits.p[:, part] * rate[:, :, None] + limits.r[:, part] * squares[:, :, None]
    share: Floats = value / np.where(value < 0, limits.low[:, part], limits.high[:, part])
    return share


def _halfway(limits: _Limits, rate: Floats, squares: Floats) -> Floats:
    """(b,): largest share of any limit halfway between two samples, where all quantities are taken as linear."""

    def middle(values: Floats) -> Floats:
        return (values[:, 1:] + values[:, :-1]) / 2

    halved = limits._replace(
        p=middle(limits.p), r=middle(limits.r), low=middle(limits.low), high=middle(limits.high)
    )
    worst: Floats = _used(halved, slice(None), rate, middle(squares)).max(axis=(1, 2))
    return worst


def _joined(parts: list[Retimed], single: bool) -> Retimed:
    """All paths in one, without the leading axis where there was none."""
    columns = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in Retimed.__dataclass_fields__
        if name != "names"
    }
    return Retimed(**{n: c[0] if single else c for n, c in columns.items()}, names=parts[0].names)
