"""The fastest motion along a path within limits, and the deciding limit at each place."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core import compiled_loops
from olp.core.diagnostic import OlpError, error
from olp.timing.retiming.path import SampledPath

Floats = NDArray[np.float64]

_SAVING = 2e-6  # [s] per sample that compiled code saves, measured by bench/retiming.py
_AT_ONCE = 20_000  # samples at a time: their arrays stay in the cache
_NOTHING = (
    1e-150  # of a derivative of an axis along the path: it bounds no motion, and its reciprocal is no number
)


class LimitKind(StrEnum):
    """Kind of a limit."""

    SPEED = "speed"
    ACCELERATION = "acceleration"
    PATH_SPEED = "path speed"
    PATH_ACCELERATION = "path acceleration"
    FURTHER = "further limit"


class Limiter(NamedTuple):
    """A limit: its kind, and the number of its axis (or of the further limit), -1 for those of the path."""

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
    `limiter` (..., n - 1): index into `names` of the limit that is used most; `usage` (..., n - 1): the used share
    of it [1]. `excess` (...): the largest share by which any limit is exceeded at a sample or halfway between two.
    Where the start or end speed is not possible, `speed` begins or ends with the largest possible one.
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
        """Duration (...) [s]."""
        return self.time[..., -1]


class _Limits(NamedTuple):
    """All limits of b paths, (b, n, m) or (b, n)."""

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

    `speed` [rad/s], `acceleration` [rad/s²]: limits of the axes, (k,) or along the path (..., n, k). `path_speed`
    [m/s] and `path_acceleration` [m/s²], numbers or (..., n), limit ds/dt and d²s/dt²: a controller's programmed
    speed and acceleration. `start_speed`, `end_speed` [m/s], a number or one per path. `compiled`: as in
    olp.core.compiled_loops.use. Raises OlpError: L002 for numbers that are not finite, shapes that do not fit or
    limits not above zero; F001.
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
    first, second = (np.where(np.abs(d) < _NOTHING, 0.0, d).reshape(shape) for d in (path.first, path.second))
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
    """Largest (ds/dt)² by the speeds of path and axes (b, n), also between the samples.

    Between two samples q' of a spline is quadratic and x is linear; where their product would exceed an axis's
    speed, both ends are lowered by that share.
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
    """Largest feasible (ds/dt)² at the samples (b, n)."""
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
    """Used share of each limit (b, n - 1, m) at the samples of `part`."""
    value = limits.p[:, part] * rate[:, :, None] + limits.r[:, part] * squares[:, :, None]
    share: Floats = value / np.where(value < 0, limits.low[:, part], limits.high[:, part])
    return share


def _halfway(limits: _Limits, rate: Floats, squares: Floats) -> Floats:
    """Largest used share of any limit halfway between two samples (b,), with all quantities interpolated linearly."""

    def middle(values: Floats) -> Floats:
        return (values[:, 1:] + values[:, :-1]) / 2

    halved = limits._replace(
        p=middle(limits.p), r=middle(limits.r), low=middle(limits.low), high=middle(limits.high)
    )
    worst: Floats = _used(halved, slice(None), rate, middle(squares)).max(axis=(1, 2))
    return worst


def _joined(parts: list[Retimed], single: bool) -> Retimed:
    """All paths as one result, without the leading axis for a single path."""
    columns = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in Retimed.__dataclass_fields__
        if name != "names"
    }
    return Retimed(**{n: c[0] if single else c for n, c in columns.items()}, names=parts[0].names)


# --- Kernel ---
# The sweep below as loops over numbers, for the compiled extra. Same names, same answers.

Line = tuple[float, float]  # x = a - b y


def _limit(
    p: Floats, r: Floats, low: Floats, high: Floats, i: int, j: int, half: float
) -> tuple[float, float, float, float]:
    """Factors of x and y, and bounds, of limit j in interval i: at its start, at its end or inside; see `intervals`."""
    m = p.shape[1]
    if j < m:
        change = p[i, j] * half
        return r[i, j] - change, change, low[i, j], high[i, j]
    if j < 2 * m:
        k = j - m
        change = p[i + 1, k] * half
        return -change, change + r[i + 1, k], low[i + 1, k], high[i + 1, k]
    k = j - 2 * m
    before, after = r[i, k] / 2, r[i + 1, k] / 2
    change = (p[i, k] * half + p[i + 1, k] * half) / 2 + (before - after) / 4
    return after - change, before + change, max(low[i, k], low[i + 1, k]), min(high[i, k], high[i + 1, k])


def _solved(
    p: Floats, r: Floats, low: Floats, high: Floats, i: int, half: float, last: float, lines: Floats
) -> float:
    """Fill `lines` (4, ...) with a, b, lower a, lower b of interval i; return the largest possible y."""
    for j in range(lines.shape[1]):
        fx, fy, bottom, top = _limit(p, r, low, high, i, j, half)
        if fx == 0.0:
            lines[0, j], lines[1, j], lines[2, j], lines[3, j] = math.inf, 0.0, -math.inf, 0.0
            if fy != 0.0:
                last = min(last, max(top / fy, bottom / fy))
            continue
        share = 1.0 / fx
        lines[1, j] = lines[3, j] = fy * share
        if fx > 0.0:
            lines[0, j], lines[2, j] = top * share, bottom * share
        else:
            lines[0, j], lines[2, j] = bottom * share, top * share
    return last


def _bounds(
    p: Floats, r: Floats, low: Floats, high: Floats, axes: int, i: int, half: float, cap: float, y: float
) -> tuple[float, float, bool]:
    """The largest x of interval i for y, its slope in y, and whether any x is possible for y."""
    best, falls, least, possible = cap, 0.0, 0.0, True
    for j in range(2 * p.shape[1] + axes):
        fx, fy, bottom, top = _limit(p, r, low, high, i, j, half)
        if fx == 0.0:
            possible = possible and bottom <= fy * y <= top
            continue
        share = 1.0 / fx
        above, below = (top - fy * y) * share, (bottom - fy * y) * share
        if fx < 0.0:
            above, below = below, above
        if above < best:
            best, falls = above, fy * share
        if below > least:
            least = below
    return best, falls, possible and best >= least


def _top(lines: Floats, cap: float, y: float) -> Line:
    """The line that bounds x from above at y."""
    a, b = cap, 0.0
    for j in range(lines.shape[1]):
        if lines[0, j] - lines[1, j] * y < a - b * y:
            a, b = lines[0, j], lines[1, j]
    return a, b


def _bottom(lines: Floats, y: float) -> Line:
    """The line that bounds x from below at y."""
    a, b = 0.0, 0.0
    for j in range(lines.shape[1]):
        if lines[2, j] - lines[3, j] * y > a - b * y:
            a, b = lines[2, j], lines[3, j]
    return a, b


def _peak(lines: Floats, cap: float, y: float) -> float:
    """The smallest y, up to the given one, at which the largest x is greatest: see `_peaks`."""
    rise_a, rise_b = _top(lines, cap, 0.0)
    if rise_b >= 0.0:
        return 0.0
    fall_a, fall_b, bounded = 0.0, 0.0, False
    for _ in range(60):
        top_a, top_b = _top(lines, cap, y)
        low_a, low_b = _bottom(lines, y)
        room = (top_a - top_b * y) - (low_a - low_b * y)
        following = y
        if room < -1e-12 * (abs(top_a) + abs(top_b * y)):
            following = (top_a - low_a) / (top_b - low_b)
        else:
            if top_b < 0.0:
                rise_a, rise_b = top_a, top_b
            else:
                fall_a, fall_b, bounded = top_a, top_b, True
            if bounded:
                following = (fall_a - rise_a) / (fall_b - rise_b)
        before, y = y, max(following, 0.0)
        if abs(y - before) <= 1e-13 * before:
            break
    return y


@compiled_loops.kernel(_limit, _solved, _bounds, _top, _bottom, _peak)
def sweep_one(
    p: Floats, r: Floats, low: Floats, high: Floats, cap: Floats, step: Floats, axes: int, start: float, end: float,
    x: Floats,
) -> None:  # fmt: skip
    """Fill `x` (n,) of one path; p, r, low, high (n, m), cap (n,), step (n - 1,): see Strips."""
    n, m = p.shape
    lines = np.empty((4, 2 * m + axes))
    x[n - 1] = min(end, cap[n - 1])
    for i in range(n - 2, -1, -1):
        half = 0.5 / step[i]
        best, falls, possible = _bounds(p, r, low, high, axes, i, half, cap[i], x[i + 1])
        # Where x does not fall with y, the peak lies at y or further on and is not needed.
        if falls > 0.0 or not possible:
            last = _solved(p, r, low, high, i, half, cap[i + 1], lines)
            y = min(x[i + 1], _peak(lines, cap[i], last))
            a, b = _top(lines, cap[i], y)
            best = a - b * y
        x[i] = max(best, 0.0)
    x[0] = min(x[0], start)
    for i in range(n - 1):
        best = x[i + 1]
        for j in range(2 * m + axes):
            fx, fy, bottom, top = _limit(p, r, low, high, i, j, 0.5 / step[i])
            if fy > 0.0:
                best = min(best, (top - fx * x[i]) / fy)
            elif fy < 0.0:
                best = min(best, (bottom - fx * x[i]) / fy)
        x[i + 1] = max(best, 0.0)


# --- Sweep ---
# The largest speed along a path under linear limits, by one sweep back and one forward.
#
# Reachability analysis (H. Pham and Q.-C. Pham, "A new approach to time-optimal path parameterization based on
# reachability analysis", IEEE T-RO 34(3), 2018). With x = ds/dt squared and u = d²s/dt², constant between two
# samples, every limit reads low <= p u + r x <= high. Here it holds at both ends of each interval: with x at its
# start, y at its end and u = (y - x) / 2d, two limits in x and y. On a cubic spline an axis's acceleration q' u + q'' x
# is quadratic inside the interval, so it stays between its ends and the middle one of its three Bernstein
# coefficients, which is linear in x and y too and becomes a third limit: nothing is exceeded between the samples.
#
# The largest x for a y is the least of many lines, a concave function; so the largest controllable x is found at
# y = min(controllable y, where that function peaks).

_MOST_CUTS = 60  # of the search for a peak; two to six are usual


class Strips(NamedTuple):
    """Limits low <= p u + r x <= high at the n samples of b paths, (n, m, b) each; low < 0 < high.

    `cap` (n, b): largest x. `step` (n - 1, b): length of the intervals. The first `axes` of the m limits are those
    of axes, of which r = dp/ds.
    """

    p: Floats
    r: Floats
    low: Floats
    high: Floats
    cap: Floats
    step: Floats
    axes: int


class IntervalBounds(NamedTuple):
    """Bounds of every interval: x <= a - b y for all its lines, (n - 1, 2m + axes, b) each; `low_*`: x >= a - b y."""

    a: Floats
    b: Floats
    low_a: Floats
    low_b: Floats


def sweep(strips: Strips, start: Floats, end: Floats) -> Floats:
    """The largest x (n, b) with x <= `start` (b,) at the first and x <= `end` (b,) at the last sample."""
    x_part, y_part, low, high = intervals(strips)
    lines = _lines(x_part, y_part, low, high)
    peak = _peaks(lines, strips.cap, _last_y(x_part, y_part, low, high, strips.cap))
    x = np.empty_like(strips.cap)
    x[-1] = np.minimum(end, strips.cap[-1])
    for i in range(len(x) - 2, -1, -1):
        y = np.minimum(x[i + 1], peak[i])
        x[i] = np.minimum(np.min(lines.a[i] - lines.b[i] * y, axis=0), strips.cap[i])
    np.maximum(x, 0.0, out=x)
    x[0] = np.minimum(x[0], start)
    forward = _lines(y_part, x_part, low, high)
    for i in range(len(x) - 1):
        y = np.min(forward.a[i] - forward.b[i] * x[i], axis=0)
        x[i + 1] = np.maximum(np.minimum(y, x[i + 1]), 0.0)
    return x


def intervals(strips: Strips) -> tuple[Floats, Floats, Floats, Floats]:
    """Factors of x and y, and the bounds, (n - 1, 2m + axes, b), of each limit: at the start, at the end and, for
    axes, inside each interval.
    """
    p, r, axes = strips.p, strips.r, slice(strips.axes)
    half = 0.5 / strips.step[:, None, :]
    first, last = p[:-1] * half, p[1:] * half
    before, after = r[:-1, axes] / 2, r[1:, axes] / 2
    middle = (first[:, axes] + last[:, axes]) / 2 + (before - after) / 4
    low, high = strips.low, strips.high
    return (
        np.concatenate((r[:-1] - first, -last, after - middle), axis=1),
        np.concatenate((first, last + r[1:], before + middle), axis=1),
        np.concatenate((low[:-1], low[1:], np.maximum(low[:-1, axes], low[1:, axes])), axis=1),
        np.concatenate((high[:-1], high[1:], np.minimum(high[:-1, axes], high[1:, axes])), axis=1),
    )


def _lines(x_part: Floats, y_part: Floats, low: Floats, high: Floats) -> IntervalBounds:
    """Limits solved for x; a limit without x gives no bound."""
    none = x_part == 0.0
    factor = 1.0 / np.where(none, 1.0, x_part)
    b = np.where(none, 0.0, y_part * factor)
    up, down = high * factor, low * factor
    falling = factor < 0
    a = np.where(none, np.inf, np.where(falling, down, up))
    return IntervalBounds(a, b, np.where(none, -np.inf, np.where(falling, up, down)), b)


def _last_y(x_part: Floats, y_part: Floats, low: Floats, high: Floats, cap: Floats) -> Floats:
    """Largest y (n - 1, b) by its own cap and by the limits without x."""
    alone = (x_part == 0.0) & (y_part != 0.0)
    last = cap[1:]
    if alone.any():
        factor = 1.0 / np.where(alone, y_part, 1.0)
        bound = np.where(alone, np.maximum(high * factor, low * factor), np.inf)
        last = np.minimum(last, bound.min(axis=1))
    return last


def _peaks(lines: IntervalBounds, cap: Floats, last: Floats) -> Floats:
    """The smallest y (n - 1, b) at which the largest x is greatest, within 0..`last`.

    Kelley's cutting planes: the next y to evaluate is where the rising and the falling line found so far meet; from
    a y without any possible x, the lines of both bounds lead back to the last y that has one (Newton).
    """
    shape = last.shape
    a, b, low_a, low_b = (part.transpose(0, 2, 1).reshape(-1, part.shape[1]) for part in lines)
    cap, y = cap[:-1].reshape(-1, 1), last.reshape(-1).copy()
    a, b = np.append(a, cap, axis=1), np.append(b, np.zeros_like(cap), axis=1)
    low_a, low_b = np.append(low_a, np.zeros_like(cap), axis=1), np.append(low_b, np.zeros_like(cap), axis=1)
    rising_a, rising_b = _active(a, b, np.zeros(len(y)))
    falling_a, falling_b = np.zeros(len(y)), np.full(len(y), np.nan)
    y = np.where(rising_b < 0, y, 0.0)
    rows = np.flatnonzero(rising_b < 0)
    for _ in range(_MOST_CUTS):
        if not len(rows):
            break
        at, top, bottom = y[rows], (a[rows], b[rows]), (-low_a[rows], -low_b[rows])
        (top_a, top_b), (bottom_a, bottom_b) = _active(*top, at), _active(*bottom, at)
        room = top_a - top_b * at + (bottom_a - bottom_b * at)
        outside = room < -1e-12 * (np.abs(top_a) + np.abs(top_b * at))
        rising = ~outside & (top_b < 0)
        falling = ~outside & ~rising
        rising_a[rows[rising]], rising_b[rows[rising]] = top_a[rising], top_b[rising]
        falling_a[rows[falling]], falling_b[rows[falling]] = top_a[falling], top_b[falling]
        with np.errstate(divide="ignore", invalid="ignore"):
            back = (top_a + bottom_a) / (top_b + bottom_b)
            met = (falling_a[rows] - rising_a[rows]) / (falling_b[rows] - rising_b[rows])
        # No falling line yet: the last place that is possible is the peak.
        following = np.where(outside, back, np.where(np.isnan(met), at, met))
        y[rows] = np.maximum(following, 0.0)
        rows = rows[np.abs(following - at) > 1e-13 * at]
    return y.reshape(shape)


def _active(a: Floats, b: Floats, y: Floats) -> tuple[Floats, Floats]:
    """The line (a, b) of each row that is lowest at y (n,)."""
    row = np.arange(len(a))
    k = np.argmin(a - b * y[:, None], axis=1)
    return a[row, k], b[row, k]
