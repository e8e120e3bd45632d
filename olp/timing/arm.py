"""How long a joint move of an arm takes: the one law that `time`, `predict`, `calibrate` and `diagnose` share.

All axes start and stop together. An axis alone runs a trapezoid of speed, rest to rest,

    t = D/V + V w     where V w <= D/V,     t = 2 sqrt(D w)     else     (w = 1/a)

with V = v p o and w = (tau/v) J / (p^k o^m b): v the rated speed, tau the time to it, p the programmed
fraction of speed, b that of acceleration, o the program override. k says what a lower programmed speed does
to the ramps (0: they keep their acceleration, 1: their time), m what the override does (2: the whole time
axis is stretched, 0: only speeds are scaled). J is the inertia about the axis in the middle of the move
over that of the stretched arm with its rated load,

    J = r + (1 - r) ((1 - c) A + c P)

with the rotor's share r, the load's share c of what is beyond it, A the arm's and P the load's own relative
inertia, times exp(f . g) for what the geometry does not tell: f are sines and cosines of the second and
third axis. The move takes

    T = (sum of t^n)^(1/n) + s

n = 1/sharing: axes that need nearly as long as the slowest one lengthen the move; s is what a stop costs at
any speed: the controller's filter, whole cycles, settling. Sources: a profile filter as a moving average
adds its length to a move and the override scales the time axis (KUKA KR C2 handbook of machine data,
$FILTER and $RED_ACC_OV); that posture in the middle of a move tells more than at its ends was found on
recorded moves (docs/arm-timing.md).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

POSTURE = 6  # functions of the posture
MAIN = 3  # axes before the wrist: those whose inertia the posture changes
_LEAST = 1e-9  # [rad | m] an axis that turns less stands


@dataclass(frozen=True, slots=True, eq=False)
class JointMotions:
    """n joint moves of k axes from rest to rest. Unknown payloads are nan."""

    turned: Floats  # (n, k) [rad | m] how far each axis goes, not negative
    posture: Floats  # (n, POSTURE) [1] functions of the posture in the middle of the move
    arm: Floats  # (n, k) [1] the arm's own inertia about each axis, over that of the stretched arm
    load: Floats  # (n, k) [1] the load's inertia about each axis, over that of the rated load at full reach
    fraction: Floats  # (n,) [1] programmed share of the rated speeds
    acceleration: Floats  # (n,) [1] programmed share of the accelerations
    override: Floats  # (n,) [1] program override

    def __len__(self) -> int:
        return len(self.turned)

    def take(self, rows: NDArray[np.intp] | Mask) -> JointMotions:
        return JointMotions(*(getattr(self, field.name)[rows] for field in fields(self)))


class LawParameter(NamedTuple):
    """One number of the law: `mean` and `sd` of its logarithm where `logarithmic`; `source` says where it is from."""

    name: str
    unit: str
    mean: float
    sd: float
    source: str
    logarithmic: bool = False

    @property
    def value(self) -> float:
        return float(np.exp(self.mean)) if self.logarithmic else self.mean


@dataclass(frozen=True, slots=True, eq=False)
class ArmTiming:
    """The law with its numbers, each with a spread and a source: a prior, or what moves made of it.

    `mean` (p,) in the order of `names_of`; `covariance` (p, p) of it. `scatter` [1]: of repeated moves, relative.
    """

    axes: tuple[str, ...]
    mean: Floats
    covariance: Floats
    sources: tuple[str, ...]  # (p,)
    scatter: float

    @property
    def names(self) -> tuple[str, ...]:
        return names_of(self.axes)

    @property
    def sd(self) -> Floats:
        """(p,)"""
        return np.sqrt(np.diag(self.covariance))

    @property
    def parameters(self) -> tuple[LawParameter, ...]:
        rows = zip(self.names, self.mean.tolist(), self.sd.tolist(), self.sources, strict=True)
        return tuple(
            LawParameter(name, _unit(name), mean, sd, source, _logarithmic(name))
            for name, mean, sd, source in rows
        )

    @property
    def speeds(self) -> Floats:
        """(k,) [rad/s | m/s] rated."""
        return np.exp(self.mean[: len(self.axes)])

    @property
    def times_to_speed(self) -> Floats:
        """(k,) [s] from rest to rated speed, stretched and with the rated load."""
        return np.exp(self.mean[len(self.axes) : 2 * len(self.axes)])

    @property
    def stop(self) -> float:
        """[s] what a stop costs at any speed."""
        return float(self.mean[2 * len(self.axes)])

    def durations(self, motions: JointMotions) -> Floats:
        """(n,) [s]; 0 where no axis moves, nan where something is not known."""
        return solve(self.mean, motions).duration

    def axis_times(self, motions: JointMotions) -> Floats:
        """(n, k) [s] of each axis alone."""
        return solve(self.mean, motions).axis_times

    def spread(self, motions: JointMotions) -> Floats:
        """(n,) [1] sd of ln(duration): what is not known of the numbers, and the scatter of moves."""
        jacobian = gradient(self.mean, motions)
        return np.asarray(
            np.sqrt(np.einsum("ij,jk,ik->i", jacobian, self.covariance, jacobian) + self.scatter**2)
        )

    def doubts(self, motions: JointMotions) -> tuple[tuple[str, float], ...]:
        """(name, share [s]) of what makes most of the doubt in the sum of these moves, the largest first."""
        share = np.abs(self.durations(motions) @ np.nan_to_num(gradient(self.mean, motions))) * self.sd
        order = np.argsort(-share)
        return tuple((self.names[i], float(share[i])) for i in order.tolist())

    def with_mean(self, mean: Floats) -> ArmTiming:
        return replace(self, mean=mean)


class JointSolution(NamedTuple):
    """What `solve` found: see ArmTiming."""

    duration: Floats  # (n,) [s]
    axis_times: Floats  # (n, k) [s]
    cruise: Floats  # (n, k) [s] of each axis at its speed, D/V
    ramps: Floats  # (n, k) [s] V w where the speed is reached, else t/2
    reached: Mask  # (n, k) whether an axis gets to its speed
    joined: Floats  # (n,) [s] duration without the stop


def names_of(axes: Sequence[str]) -> tuple[str, ...]:
    """The parameters in their order."""
    wrist = [name for name in axes[:MAIN] for _ in range(POSTURE)]
    return (
        *(f"speed {a}" for a in axes),
        *(f"time to speed {a}" for a in axes),
        "stop", "percent exponent", "override exponent", "sharing",
        "rotor share", "load share", "wrist rotor share", "wrist load share",
        *(f"posture {a} {i % POSTURE}" for i, a in enumerate(wrist)),
    )  # fmt: skip


def _logarithmic(name: str) -> bool:
    return name.startswith(("speed", "time to speed", "sharing"))


def _unit(name: str) -> str:
    if name.startswith("speed"):
        return "rad/s"
    return "s" if name.startswith("time to speed") or name == "stop" else "1"


def _shares(mean: Floats, axes: int) -> tuple[Floats, Floats]:
    """(k,) rotor share and load share of each axis; both are kept as their log odds."""
    base = 2 * axes + 4
    odds = mean[base : base + 4]
    share = 1.0 / (1.0 + np.exp(-odds))
    main = np.arange(axes) < MAIN
    return np.where(main, share[0], share[2]), np.where(main, share[1], share[3])


def _inertia(mean: Floats, m: JointMotions) -> Floats:
    """(n, k) [1] J."""
    rotor, loaded = _shares(mean, m.turned.shape[1])
    return np.asarray(rotor + (1.0 - rotor) * ((1.0 - loaded) * m.arm + loaded * m.load))


def solve(mean: Floats, m: JointMotions) -> JointSolution:
    """The law for the numbers `mean`, see the head of this file."""
    axes = m.turned.shape[1]
    speed, ramp = np.exp(mean[:axes]), np.exp(mean[axes : 2 * axes])
    stop, percent, override = mean[2 * axes : 2 * axes + 3].tolist()
    power = float(np.exp(-mean[2 * axes + 3]))
    pace = (m.fraction * m.override)[:, None] * speed
    log_share = percent * np.log(m.fraction) + override * np.log(m.override) + np.log(m.acceleration)
    slowness = _inertia(mean, m) * (ramp / speed) * np.exp(-log_share)[:, None]
    main = min(MAIN, axes)
    weights = mean[2 * axes + 8 :].reshape(main, POSTURE)
    slowness[:, :main] *= np.exp(m.posture @ weights.T)
    cruise, ramps = m.turned / pace, pace * slowness
    reached = ramps <= cruise
    times = np.where(reached, cruise + ramps, 2.0 * np.sqrt(m.turned * slowness))
    longest = np.max(times, axis=1, initial=0.0)
    safe = np.where(longest > 0, longest, 1.0)
    joined = longest * np.sum((times / safe[:, None]) ** power, axis=1) ** (1.0 / power)
    moving = np.max(m.turned, axis=1, initial=0.0) > _LEAST
    duration = np.where(moving, np.maximum(joined + stop, 0.1 * joined), 0.0)
    duration = np.where(np.isnan(joined), np.nan, duration)
    return JointSolution(duration, times, cruise, ramps, reached, joined)


def gradient(mean: Floats, m: JointMotions) -> Floats:
    """(n, p) of ln(duration) by the numbers."""
    axes = m.turned.shape[1]
    found = solve(mean, m)
    times, joined = found.axis_times, found.joined
    power = float(np.exp(-mean[2 * axes + 3]))
    safe = np.where(joined > 0, joined, 1.0)
    ratio = times / safe[:, None]
    weight = ratio ** (power - 1.0)  # of joined by each axis' time
    by_speed = np.where(found.reached, -found.cruise, -0.5 * times)
    by_slowness = np.where(found.reached, found.ramps, 0.5 * times)
    result = np.zeros((len(m), len(mean)))
    result[:, :axes] = weight * by_speed
    # A ramp's time at rated speed does not depend on the speed: w = tau/v is in both.
    pull = weight * by_slowness
    result[:, axes : 2 * axes] = pull
    total = pull.sum(axis=1)
    result[:, 2 * axes] = 1.0
    result[:, 2 * axes + 1] = -np.log(m.fraction) * total
    result[:, 2 * axes + 2] = -np.log(m.override) * total
    with np.errstate(divide="ignore", invalid="ignore"):
        entropy = -np.sum(np.where(ratio > 0, ratio**power * np.log(ratio), 0.0), axis=1)
    result[:, 2 * axes + 3] = joined * entropy  # d joined / d ln(sharing)
    rotor, loaded = _shares(mean, axes)
    mixed = (1.0 - loaded) * m.arm + loaded * m.load
    inertia = rotor + (1.0 - rotor) * mixed
    by_rotor = pull * (1.0 - mixed) / inertia * rotor * (1.0 - rotor)
    by_load = pull * (1.0 - rotor) * (m.load - m.arm) / inertia * loaded * (1.0 - loaded)
    base, main = 2 * axes + 4, min(MAIN, axes)
    result[:, base], result[:, base + 2] = by_rotor[:, :main].sum(axis=1), by_rotor[:, main:].sum(axis=1)
    result[:, base + 1], result[:, base + 3] = by_load[:, :main].sum(axis=1), by_load[:, main:].sum(axis=1)
    for axis in range(main):
        first = base + 4 + POSTURE * axis
        result[:, first : first + POSTURE] = pull[:, axis : axis + 1] * m.posture
    duration = np.where(found.duration > 0, found.duration, 1.0)
    return np.asarray(result / duration[:, None])


def posture_functions(joints: Floats) -> Floats:
    """(n, POSTURE) of joints (n, k) [rad]: sine and cosine of the second axis, and of second plus and minus third."""
    if joints.shape[1] < 3:
        return np.zeros((len(joints), POSTURE))
    second, third = joints[:, 1], joints[:, 2]
    angles = (second, second + third, second - third)
    return np.stack([f(a) for a in angles for f in (np.sin, np.cos)], axis=1)
