"""How one axis follows its reference: late by a clock, by its servo, by a soft gear or by play.

The reference is a command or a simulation on an even grid; every linear effect is its spectrum times a transfer
function, so a lag, a delay and an oscillation differ by what they do to quick parts of the motion, and compete.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.select import LibraryColumn, Products, products
from olp.identification.diagnosis.logs.series import Spectrum, autoregression, kept, order_of, runs, whiten
from olp.timing.physics.backlash import play
from olp.timing.physics.clock import shift
from olp.timing.physics.joint_compliance import swing
from olp.timing.physics.servo_lag import lag

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
LAG, COMPLIANCE, BACKLASH = "servo-lag", "joint-compliance", "backlash"
_ROUNDS = 6


@dataclass(frozen=True, slots=True)
class FollowingShape:
    """The terms of one axis in numbers; nan: the term is not there."""

    lag: float = math.nan  # [s]
    frequency: float = math.nan  # [rad/s]
    damping: float = math.nan  # [1]
    swing: float = math.nan  # [1] how much of what a soft gear makes is seen: 1 behind it
    play: float = math.nan  # [rad | m]
    # A gear whose torque is known: it gives way to that, less what the rotor before it needs.
    twist: float = math.nan  # [rad/Nm | m/N]
    push: float = math.nan  # [s²] rotor's inertia times `twist`
    give: float = math.nan  # [rad/Nm | m/N] by how much the servo gives way to torques that nobody planned

    def only(self, terms: tuple[str, ...]) -> FollowingShape:
        kept = self
        if LAG not in terms:
            kept = replace(kept, lag=math.nan)
        if COMPLIANCE not in terms:
            kept = replace(kept, frequency=math.nan, damping=math.nan, swing=math.nan)
            kept = replace(kept, twist=math.nan, push=math.nan, give=math.nan)
        return kept if BACKLASH in terms else replace(kept, play=math.nan)


@dataclass(frozen=True, slots=True, eq=False)
class Follower:
    """One axis against its reference. `time` (n,) [s] of the samples on the reference's clock, `use` those to count."""

    axis: int
    time: Floats
    measured: Floats  # (n,) [rad | m]
    reference: Spectrum
    use: Mask
    load: Floats | None = (
        None  # (n, 2) torque [Nm | N] and the reference's acceleration, where they are known
    )

    def seen(self, values: Floats) -> Floats:
        """(n,) a curve on the reference's grid at the samples."""
        return self.reference.grid.at(self.time, values[:, None])[:, 0]

    @property
    def residual(self) -> Floats:
        """(n,) measured less reference."""
        return self.measured - self.seen(self.reference.grid.values[:, self.axis])

    def delay(self, late: float) -> Floats:
        """(n,) what a reference that comes `late` [s] adds."""
        return self.seen(self.reference.through(shift(self.reference.omega, late), self.axis))

    def effects(self, shape: FollowingShape, late: float = 0.0) -> Floats:
        """(n,) what the terms of `shape` add to the reference, on top of a clock that is `late` [s]."""
        omega, axis = self.reference.omega, self.axis
        gain = 1 + shift(omega, late)
        if not math.isnan(shape.lag):
            gain = gain * (1 + lag(omega, shape.lag))
        if not math.isnan(shape.frequency):
            gain = gain * (1 + shape.swing * swing(omega, shape.frequency, shape.damping))
        added = self.reference.through(gain - 1, axis)
        if not math.isnan(shape.play):
            motor = self.reference.grid.values[:, axis] + added
            added = added + play(motor, shape.play)
        if self.load is None or math.isnan(shape.twist):
            return self.seen(added)
        given: Floats = self.load @ np.array([-shape.twist, shape.push, -shape.give])
        return self.seen(added) + given


@dataclass(frozen=True, slots=True, eq=False)
class Whitened:
    """A follower's noise: its filter (at most 8,) and the samples that have their neighbours."""

    filter: Floats
    keep: Mask

    def of(self, values: Floats) -> Floats:
        return whiten(values, self.filter, self.keep)


def whitened(follower: Follower, left: Floats) -> Whitened:
    """From what all terms together leave (n,)."""
    run = runs(follower.time, follower.use)
    order = order_of(run)
    return Whitened(autoregression(left, run, order), kept(run, order))


NAMES = ("lag", "frequency", "damping", "swing", "play", "twist", "push", "give")
_LOW = (1e-5, 2 * math.pi * 0.5, 2e-3, -20.0, 1e-9, 1e-12, 0.0, -1e-2)
_HIGH = (0.5, 2 * math.pi * 120, 0.5, 20.0, 0.1, 1e-2, 0.1, 1e-2)  # damped more, nothing oscillates


def jacobian(
    follower: Follower, shape: FollowingShape, late: float
) -> tuple[tuple[str, ...], Floats, Floats]:
    """Names of the numbers of `shape`, effects (n,) and their derivatives (n, p)."""
    here = follower.effects(shape, late)
    names = tuple(n for n in NAMES if not math.isnan(getattr(shape, n)))
    columns = []
    for name in names:
        value = getattr(shape, name)
        step = 1e-3 * max(
            abs(value), 1e-3 if name in ("damping", "swing") else 1e-5 if name == "lag" else 1e-9
        )
        there = follower.effects(replace(shape, **{name: value + step}), late)
        columns.append((there - here) / step)
    return names, here, np.stack(columns, axis=1) if columns else np.zeros((len(here), 0))


def refine(
    follower: Follower, shape: FollowingShape, late: float, noise: Whitened | None, rounds: int = _ROUNDS
) -> FollowingShape:
    """Gauss and Newton with halved steps, over a free constant; without `noise` plain least squares."""
    ones = np.ones((len(follower.time), 1))

    def seen(values: Floats) -> Floats:
        return noise.of(values) if noise is not None else values[follower.use]

    residual = follower.residual
    constant = seen(ones)

    def cost(values: Floats) -> float:
        v = seen(values)
        c = constant[:, 0]
        # Not by matrix products: on a busy machine their threads wait for each other.
        v = v - c * float((c * v).sum()) / max(float((c * c).sum()), 1e-300)
        return float((v * v).sum())

    here = cost(residual - follower.effects(shape, late))
    for _ in range(rounds):
        names, effect, slope = jacobian(follower, shape, late)
        if not names:
            return shape
        matrix = np.column_stack([seen(slope), constant])
        scale = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
        matrix /= scale
        values, vectors = np.linalg.eigh(matrix.T @ matrix)
        good = values > 1e-12 * values[-1]
        step = (
            vectors[:, good]
            @ ((vectors.T @ (matrix.T @ seen(residual - effect)))[good] / values[good])
            / scale
        )
        share = 1.0
        while share > 0.05:
            moved = {
                n: float(np.clip(getattr(shape, n) + share * s, _LOW[NAMES.index(n)], _HIGH[NAMES.index(n)]))
                for n, s in zip(names, step[:-1], strict=True)
            }
            there = replace(shape, **moved)
            now = cost(residual - follower.effects(there, late))
            if now < here:
                break
            share /= 2
        else:
            return shape
        done = (here - now) < 1e-5 * here
        shape, here = there, now
        if done:
            break
    return shape


COLUMNS = (
    LibraryColumn(""),
    LibraryColumn(LAG, positive=True),
    LibraryColumn(COMPLIANCE, parameters=3),
    LibraryColumn(BACKLASH, positive=True),
)


def library(follower: Follower, shape: FollowingShape, late: float) -> Floats:
    """(n, 4) constant, lag, oscillation and play of `shape`, each as if alone on a clock that is `late` [s]."""
    base = follower.delay(late) if late else 0.0
    parts = [np.ones(len(follower.time))]
    for term in (LAG, COMPLIANCE, BACKLASH):
        parts.append(follower.effects(shape.only((term,)), late) - base)
    return np.stack(parts, axis=1)


def compared(
    follower: Follower, shape: FollowingShape, late: float, noise: Whitened, extra: Floats | None = None
) -> Products:
    """The terms of one axis as columns, whitened; `extra` (n, m): more that is always in (a clock's two numbers)."""
    base = follower.delay(late) if late else 0.0
    columns = library(follower, shape, late)
    kinds = COLUMNS
    if extra is not None:
        columns = np.column_stack([columns, extra])
        kinds = COLUMNS + (LibraryColumn("clock"),) * extra.shape[1]
    return products(noise.of(columns), noise.of(follower.residual - base), kinds)
