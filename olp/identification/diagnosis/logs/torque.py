"""What the axes need beyond rigid bodies: torque or current against speed, acceleration and gravity.

Three ways to take rigid bodies out, the best that the recording allows: the simulation's own torques, the robot's
masses, or a basis of inertia, gravity and centrifugal columns whose sizes are fitted per axis.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.select import LibraryColumn, Products, products
from olp.identification.diagnosis.logs.series import (
    Spectrum,
    autoregression,
    even,
    kept,
    order_of,
    runs,
    whiten,
)
from olp.identification.recording.log import Log
from olp.timing.physics.coulomb_friction import coulomb
from olp.timing.physics.viscous_friction import viscous

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
_MOST_RATIO = 25  # samples per column, at least
_LEAST_WAY = 0.02  # [rad | m]: less is an axis that is held, not moved
_BESIDE = 2.0  # times the smoothing of speeds: that near to a standstill no sample counts
_SHRINK = 1e-3  # of the strongest direction
MASSES = "masses"  # no name of a term: inertia and gravity that the simulation has otherwise


@dataclass(frozen=True, slots=True, eq=False)
class LogMotion:
    """Positions, speeds and accelerations (n, k) of the samples of a log, from its command where there is one."""

    time: Floats
    q: Floats
    speed: Floats
    acceleration: Floats
    noise: Floats  # (k,) [rad/s | m/s] of `speed`
    slower: Floats  # `speed` behind a Gaussian twice as wide: what depends on that is not known better
    blur: float  # [s] standard deviation of the Gaussian of `speed`
    curl: Floats  # second derivative of `slower`

    def take(self, rows: NDArray[np.intp]) -> LogMotion:
        """Some of the samples."""
        parts = (self.time, self.q, self.speed, self.acceleration)
        time, q, speed, acceleration = (part[rows] for part in parts)
        return LogMotion(
            time, q, speed, acceleration, self.noise, self.slower[rows], self.blur, self.curl[rows]
        )


def motion(log: Log, smooth: float | None = None) -> LogMotion:
    """By Gaussians of `smooth` [s] over the measured axes; two and a half samples, 8 ms at least, where None."""
    step = log.period
    width = smooth if smooth is not None else max(2.5 * step, 0.008)
    grid = even(log.time, log.q, step)
    spectrum = Spectrum(grid)
    axes = range(log.q.shape[1])

    def derived(source: Spectrum, order: int, gauss: float) -> Floats:
        values = np.stack([source.derivative(order, j, gauss) for j in axes], axis=1)
        return source.grid.at(log.time, values)

    speed = derived(spectrum, 1, width)
    noise = 1.4826 * np.median(np.abs(derived(spectrum, 1, width / 2) - speed), axis=0)
    source, order = spectrum, 1
    if log.speed is not None and np.isfinite(log.speed).all():
        source, order = Spectrum(even(log.time, log.speed, step)), 0
        speed = derived(source, order, width)
    slower = derived(source, order, 2 * width)
    curl = derived(source, order + 2, 2 * width)
    return LogMotion(log.time, log.q, speed, derived(spectrum, 2, width), noise, slower, width, curl)


def rigid_basis(moved: LogMotion, axis: int, slides: tuple[bool, ...]) -> Floats:
    """(n, p) inertia, coupling, centrifugal and gravity columns of one axis, for a robot whose masses nobody knows.

    Smooth in speed and even in it, so that none can stand for friction. Axes that never move bring nothing.
    """
    q, v, a = moved.q, moved.speed, moved.acceleration
    k = q.shape[1]
    live = [j for j in range(k) if np.ptp(q[:, j]) > 1e-3]
    turning = [j for j in live if not slides[j]]
    columns = [np.ones(len(q))]
    columns += [a[:, j] for j in live]
    columns += [v[:, i] * v[:, j] for i in live for j in live if i <= j and (i != axis or j != axis)]
    inner = [j for j in turning if j > 0]
    angles = [q[:, j] for j in inner]
    angles += [q[:, i] + s * q[:, j] for i, j in itertools.pairwise(inner) for s in (1, -1)]
    angles += [q[:, 1] + s * q[:, 2] + p * q[:, 4] for s in (1, -1) for p in (1, -1)] if k > 4 else []
    for angle in angles:
        columns += [np.cos(angle), np.sin(angle)]
    if axis in turning:
        for j in inner:
            if j != axis:
                columns += [np.cos(q[:, j]) * a[:, axis], np.sin(q[:, j]) * a[:, axis]]
    basis = np.stack(columns, axis=1)
    return _independent(basis)


def _independent(basis: Floats) -> Floats:
    """Principal directions, without those that the motion does not excite at all."""
    centred = basis[:, 1:] - basis[:, 1:].mean(axis=0)
    spread = centred.std(axis=0)
    centred = centred[:, spread > 1e-9] / spread[spread > 1e-9]
    values, vectors = np.linalg.eigh(centred.T @ centred / len(centred))
    good = values > 1e-5 * max(values.max(initial=0), 1e-300)
    most = max(len(basis) // _MOST_RATIO, 1)
    directions = vectors[:, good][:, ::-1][:, :most]
    return np.column_stack([np.ones(len(basis)), centred @ directions])


@dataclass(frozen=True, slots=True, eq=False)
class AxisTorque:
    """One axis: what is to be explained, the library, the samples used, and both whitened."""

    axis: int
    residual: Floats  # (n,) raw
    library: Floats  # (n, p) raw
    use: Mask  # (n,)
    filter: Floats  # (8,), fewer between many gaps
    products: Products
    raw: Products  # not whitened
    slower: Products  # not whitened, with speeds behind a Gaussian twice as wide


def axis_torque(
    moved: LogMotion, residual: Floats, base: Floats, axis: int, extra: tuple[tuple[str, Floats], ...] = ()
) -> AxisTorque | None:
    """The library of one axis over `base` (n, m); `extra`: more columns by term. None when the axis does not move."""
    speed = moved.speed[:, axis]
    quick = float(np.quantile(np.abs(speed), 0.98))
    soft = max(0.005 * quick, 3 * float(moved.noise[axis]))
    # At rest the direction of friction is anybody's guess, and beside it smoothed speeds are early or late.
    use = _away_from(np.abs(speed) <= 2 * soft, moved.time, _BESIDE * moved.blur) & np.isfinite(residual)
    margin = moved.time[0] + 0.1, moved.time[-1] - 0.1
    use &= (moved.time > margin[0]) & (moved.time < margin[1])
    signs = np.sign(speed[use])
    if (
        use.sum() < 400
        or np.ptp(moved.q[use, axis]) < _LEAST_WAY
        or abs(signs.mean()) > 0.98
        or quick <= 10 * float(moved.noise[axis])
    ):
        return None
    named = [("viscous-friction", viscous(speed)), ("coulomb-friction", coulomb(speed, soft / 4)), *extra]
    # Smoothing, and a servo that yields to friction, change what a torque has of the speed by its second derivative.
    curl = moved.curl[:, axis] * (quick / max(float(moved.curl[use, axis].std()), 1e-300))
    base = np.column_stack([base, curl])
    library = np.column_stack([base, *(column for _, column in named)])
    slow = moved.slower[use, axis]
    smoother = library[use]
    smoother[:, base.shape[1] : base.shape[1] + 2] = np.stack(
        [viscous(slow), coulomb(slow, soft / 4)], axis=1
    )
    columns = (LibraryColumn(""),) * base.shape[1] + tuple(
        LibraryColumn(term, positive=term.endswith("friction")) for term, _ in named
    )
    soft_columns = np.array([c.term in ("", MASSES) for c in columns])
    soft_columns[[0, base.shape[1] - 1]] = False
    prior = shrink(library[use], soft_columns)
    raw = products(library[use], residual[use], columns, prior)
    fit = raw.fit(tuple(range(len(columns))))
    run = runs(moved.time, use)
    order = order_of(run)
    a = autoregression(np.where(use, residual - library @ fit, 0.0), run, order)
    keep = kept(run, order)
    if keep.sum() < 300:
        return None
    white = whiten(library, a, keep)
    target = whiten(np.where(use, residual, 0.0), a, keep)
    table = products(white, target, columns, shrink(white, soft_columns))
    slower = products(smoother, residual[use], columns, prior)
    return AxisTorque(axis, residual, library, use, a, table, raw, slower)


def _away_from(bad: Mask, time: Floats, least: float) -> Mask:
    """(n,) samples farther than `least` [s] from all that are `bad`."""
    if not bad.any():
        return np.ones(len(time), dtype=bool)
    at = time[bad]
    after = np.searchsorted(at, time)
    before = time - at[np.maximum(after - 1, 0)]
    ahead = at[np.minimum(after, len(at) - 1)] - time
    near = ((after > 0) & (before <= least)) | ((after < len(at)) & (ahead <= least))
    return np.asarray(~near)


def shrink(library: Floats, soft: Mask) -> Floats:
    """(p,) prior of the columns `soft`: what the motion excites a thousand times less than the rest stays small.

    Without it, torques of one trajectory say nothing of another's: the basis is far larger than what moves.
    """
    if not soft.any():
        return np.zeros(library.shape[1])
    return np.asarray(soft, dtype=np.float64) * _SHRINK * float((library[:, soft] ** 2).mean(axis=0).max())
