"""How long a joint move of an arm takes: the one law that `time`, `predict`, `calibrate` and `diagnose` share.

All axes start and stop together, on one profile: the slowest axis says its speed, the weakest its ramps. Rest to
rest it is a trapezoid and what short ramps and the stop cost,

    T = P + 1/(R o^m/beta^2 + 1/P) + s
    P = C + R     R = W/C where W <= C^2, sqrt(W) else
    C = max D/V     W = max D_J (tau/v) / (p^k o^m b)

over the axes; D is how far an axis goes, V = v p o its speed, v the rated one, tau the time to it, p the programmed
fraction of speed, b that of acceleration, o the program override. k says what a lower programmed speed does to
the ramps (0: they keep their acceleration, 1: their time), m what the override does (2: the whole time axis is
stretched, 0: only speeds are scaled). A ramp R much shorter than beta costs up to beta^2/R more: a controller does
not use all of what a drive could do at a low speed; the move at most doubles. D_J is how far the drive would turn the
stretched arm with its rated load for the same torque,

    D_J = | r D + (1 - r) ((1 - c) A + c P) |     the larger of both ends of the move

with the rotor's share r, the load's share c of what is beyond it, A what the arm and P what the load take of
this drive (olp/timing/arm_moves.py: inertia about the axis, and the pull of the other axes that turn with it),
times exp(f . g) for what the geometry does not tell: f are sines and cosines of the second and third axis in the
middle of the move. c is known by its odds: those of the load's inertia against the arm's, times e^load share.
A move that runs into another one, or that another one runs into, takes T for the share of its ends at rest, and C for
the others. Maxima are soft, (sum of x^n)^(1/n), n = 1/sharing: axes that need nearly as long as the slowest one
lengthen the move; s is what a stop costs at any speed: the controller's filter, whole cycles, settling.

Sources: a profile filter as a moving average adds its length to a move and the override scales the time axis (KUKA
KR C2 handbook of machine data, $FILTER and $RED_ACC_OV). Recordings of two arms (docs/arm-timing.md) say that one
axis gives the speed and another the ramps, that ramps follow the torque at the ends of a move, where they are, and
that the torque has the axes' pull on each other in it.
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
    """n joint moves of k axes; from rest to rest where `ramps` and `stop` are 1. Unknown payloads are nan."""

    turned: Floats  # (n, k) [rad | m] how far each axis goes, not negative
    posture: Floats  # (n, POSTURE) [1] functions of the posture in the middle of the move
    arm: Floats  # (n, k, 2) [rad | m] what the arm itself takes of each drive at both ends, over the arm stretched
    load: Floats  # (n, k, 2) [rad | m] what the load takes of it, over the rated load at full reach
    balance: Floats  # (n, k) [1] ln of the rated load's inertia at full reach over that of the stretched arm
    fraction: Floats  # (n,) [1] programmed share of the rated speeds
    acceleration: Floats  # (n,) [1] programmed share of the accelerations
    override: Floats  # (n,) [1] program override
    ramps: Floats  # (n,) [1] share of the ramps: half where one end runs into another move, 0 where both do
    stop: Floats  # (n,) [1] whether it ends in a stop

    def __len__(self) -> int:
        return len(self.turned)

    def take(self, rows: NDArray[np.intp] | Mask) -> JointMotions:
        return JointMotions(*(getattr(self, field.name)[rows] for field in fields(self)))


class LawParameter(NamedTuple):
    """One parameter of the law: `mean` and `sd`, of its logarithm if `logarithmic`; `source` says where the number
    is from.
    """

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
    """Parameters of the law, each with a spread and a source: prior knowledge, or fitted to recorded moves.

    `mean` (p,) in the order of `names_of`, `covariance` (p, p). `scatter` [1]: relative standard deviation of
    repeated moves. `load_inertia` [kg m²] of the rated load about its centre; None: a usual one.
    """

    axes: tuple[str, ...]
    mean: Floats
    covariance: Floats
    sources: tuple[str, ...]  # (p,)
    scatter: float
    load_inertia: float | None = None

    @property
    def names(self) -> tuple[str, ...]:
        return names_of(self.axes)

    @property
    def sd(self) -> Floats:
        """Standard deviations of the parameters (p,)."""
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
        """Rated speeds of the axes (k,) [rad/s | m/s]."""
        return np.exp(self.mean[: len(self.axes)])

    @property
    def times_to_speed(self) -> Floats:
        """Time of each axis from rest to rated speed (k,) [s], with the arm stretched and the rated load."""
        return np.exp(self.mean[len(self.axes) : 2 * len(self.axes)])

    @property
    def stop(self) -> float:
        """Time [s] that a stop costs at any speed."""
        return float(self.mean[2 * len(self.axes)])

    def durations(self, motions: JointMotions) -> Floats:
        """Durations of the moves (n,) [s]; 0 where no axis moves, nan where an input is unknown."""
        return solve(self.mean, motions).duration

    def axis_times(self, motions: JointMotions) -> Floats:
        """Duration that each axis would need alone (n, k) [s]."""
        return solve(self.mean, motions).axis_times

    def spread(self, motions: JointMotions) -> Floats:
        """Standard deviation of ln(duration) of each move (n,) [1]: uncertainty of the parameters and scatter of
        repeats.
        """
        jacobian = gradient(self.mean, motions)
        known = np.sum((jacobian @ self.covariance) * jacobian, axis=1)
        return np.asarray(np.sqrt(known + self.scatter**2))

    def doubts(self, motions: JointMotions) -> tuple[tuple[str, float], ...]:
        """Parameters by their share [s] in the uncertainty of the sum of these moves, as (name, share), the largest
        first.
        """
        share = np.abs(self.durations(motions) @ np.nan_to_num(gradient(self.mean, motions))) * self.sd
        order = np.argsort(-share)
        return tuple((self.names[i], float(share[i])) for i in order.tolist())

    def with_mean(self, mean: Floats) -> ArmTiming:
        return replace(self, mean=mean)


class JointSolution(NamedTuple):
    """Result of `solve`: durations (n,) [s], and for each axis its terms of the law and their derivatives."""

    duration: Floats  # (n,) [s]
    cruise: Floats  # (n, k) [s] of each axis at its speed, D/V
    work: Floats  # (n, k) [s²] D w of each axis
    by_cruise: Floats  # (n, k) [s] of the duration by the logarithm of `cruise`
    by_work: Floats  # (n, k) [s] the same by that of `work`
    by_short: Floats  # (n,) [s] the same by that of beta

    @property
    def axis_times(self) -> Floats:
        """Duration that each axis would need alone (n, k) [s]."""
        reached = self.work < self.cruise**2
        ramps = self.work / np.where(reached, self.cruise, 1.0)
        return np.where(reached, self.cruise + ramps, 2.0 * np.sqrt(self.work))


def names_of(axes: Sequence[str]) -> tuple[str, ...]:
    """Names of the law's parameters, in their order, for an arm with these axes."""
    wrist = [name for name in axes[:MAIN] for _ in range(POSTURE)]
    return (
        *(f"speed {a}" for a in axes),
        *(f"time to speed {a}" for a in axes),
        "stop", "percent exponent", "override exponent", "sharing",
        "rotor share", "load share", "wrist rotor share", "wrist load share", "short ramp",
        *(f"posture {a} {i % POSTURE}" for i, a in enumerate(wrist)),
    )  # fmt: skip


def _logarithmic(name: str) -> bool:
    return name.startswith(("speed", "time to speed", "sharing", "short ramp"))


def _unit(name: str) -> str:
    if name.startswith("speed"):
        return "rad/s"
    return "s" if name.startswith(("time to speed", "stop", "short ramp")) else "1"


_STOP, _PERCENT, _OVERRIDE, _SHARING, _ROTOR, _LOAD, _WRIST_ROTOR, _WRIST_LOAD, _SHORT = range(9)


def _shares(mean: Floats, m: JointMotions) -> tuple[Floats, Floats]:
    """Rotor share (k,) and load share (n, k) of each axis; `mean` holds their log odds."""
    axes = m.turned.shape[1]
    rest = mean[2 * axes :]
    main = np.arange(axes) < MAIN
    rotor = np.where(main, rest[_ROTOR], rest[_WRIST_ROTOR])
    load = np.where(main, rest[_LOAD], rest[_WRIST_LOAD]) + m.balance
    return 1.0 / (1.0 + np.exp(-rotor)), 1.0 / (1.0 + np.exp(-load))


def solve(mean: Floats, m: JointMotions) -> JointSolution:
    """Evaluates the law of this module for the parameters `mean`."""
    axes = m.turned.shape[1]
    main = min(MAIN, axes)
    speed, ramp, rest = np.exp(mean[:axes]), np.exp(mean[axes : 2 * axes]), mean[2 * axes :]
    log_share = (
        rest[_PERCENT] * np.log(m.fraction) + rest[_OVERRIDE] * np.log(m.override) + np.log(m.acceleration)
    )
    rotor, loaded = _shares(mean, m)
    taken = np.abs(_taken(rotor, loaded, m)).max(axis=2)
    work = taken * (ramp / speed) * np.exp(-log_share)[:, None]
    work[:, :main] *= np.exp(m.posture @ rest[_SHORT + 1 :].reshape(main, POSTURE).T)
    cruise = m.turned / ((m.fraction * m.override)[:, None] * speed)
    power = float(np.exp(-rest[_SHARING]))
    cruises, of_cruises = _joined(cruise, power)
    works, of_works = _joined(work, power / 2.0)
    moving = np.max(m.turned, axis=1, initial=0.0) > _LEAST
    reached = works < cruises**2
    ramps = np.where(reached, works / np.where(reached, cruises, 1.0), np.sqrt(works))
    profile = np.where(reached, cruises, ramps) + ramps
    scale = np.exp(2.0 * rest[_SHORT]) * m.override ** -rest[_OVERRIDE]
    short = scale * profile / (ramps * profile + scale)
    joined = m.ramps * (profile + short) + (1.0 - m.ramps) * cruises
    duration = np.where(moving, np.maximum(joined + m.stop * rest[_STOP], 0.1 * joined), 0.0)
    duration = np.where(np.isnan(joined), np.nan, duration)
    by_profile = 1.0 + (short / np.where(profile > 0, profile, 1.0)) ** 2
    saved = short**2 * ramps / scale  # by the logarithm of the ramps, in `short` alone
    by_cruise = m.ramps * np.where(reached, (cruises - ramps) * by_profile + saved, 0.0)
    by_cruise += (1.0 - m.ramps) * cruises
    by_work = m.ramps * (ramps * by_profile - np.where(reached, saved, saved / 2.0))
    by_short = m.ramps * 2.0 * saved
    return JointSolution(
        duration, cruise, work, by_cruise[:, None] * of_cruises, by_work[:, None] * of_works, by_short
    )


def _taken(rotor: Floats, loaded: Floats, m: JointMotions) -> Floats:
    """Drive use D_J (see the module), signed, at both ends of each move (n, k, 2) [rad | m]."""
    mixed = (1.0 - loaded[:, :, None]) * m.arm + loaded[:, :, None] * m.load
    return np.asarray(rotor[:, None] * m.turned[:, :, None] + (1.0 - rotor[:, None]) * mixed)


def _joined(values: Floats, power: float) -> tuple[Floats, Floats]:
    """Soft maximum of each row (n,), larger where other values come near the largest, and its logarithmic
    derivatives (n, k).
    """
    largest = np.max(values, axis=1, initial=0.0)
    share = (values / np.where(largest > 0, largest, 1.0)[:, None]) ** power
    total = np.sum(share, axis=1)
    return largest * total ** (1.0 / power), share / np.where(total > 0, total, 1.0)[:, None]


def gradient(mean: Floats, m: JointMotions) -> Floats:
    """Derivatives of ln(duration) by the parameters (n, p)."""
    axes = m.turned.shape[1]
    main = min(MAIN, axes)
    found = solve(mean, m)
    pull = found.by_work
    result = np.zeros((len(m), len(mean)))
    # A ramp's time at rated speed does not depend on the speed: w = tau/v is in both.
    result[:, :axes] = -found.by_cruise - pull
    result[:, axes : 2 * axes] = pull
    total = pull.sum(axis=1)
    rest = result[:, 2 * axes :]
    rest[:, _STOP] = m.stop
    rest[:, _SHORT] = found.by_short
    rest[:, _PERCENT] = -np.log(m.fraction) * total
    rest[:, _OVERRIDE] = -np.log(m.override) * (total + found.by_short / 2.0)
    rest[:, _SHARING] = np.exp(mean[2 * axes + _SHARING]) * (
        _spread(found.by_cruise) + 2.0 * _spread(found.by_work)
    )
    rotor, loaded = _shares(mean, m)
    both = _taken(rotor, loaded, m)
    weaker = np.abs(both).argmax(axis=2)[:, :, None]
    taken, arm, load = (np.take_along_axis(v, weaker, axis=2)[:, :, 0] for v in (both, m.arm, m.load))
    per_taken = pull / np.where(taken != 0, taken, 1.0)
    by_rotor = per_taken * (m.turned - (1.0 - loaded) * arm - loaded * load) * rotor * (1.0 - rotor)
    by_load = per_taken * (1.0 - rotor) * (load - arm) * loaded * (1.0 - loaded)
    for first, wrist, values in ((_ROTOR, _WRIST_ROTOR, by_rotor), (_LOAD, _WRIST_LOAD, by_load)):
        rest[:, first], rest[:, wrist] = values[:, :main].sum(axis=1), values[:, main:].sum(axis=1)
    for axis in range(main):
        at = _SHORT + 1 + POSTURE * axis
        rest[:, at : at + POSTURE] = pull[:, axis : axis + 1] * m.posture
    duration = np.where(found.duration > 0, found.duration, 1.0)
    return np.asarray(result / duration[:, None])


def _spread(shares: Floats) -> Floats:
    """Derivative of the soft maximum by the parameter `sharing` (n,), for contributions `shares` (n, k)."""
    total = np.sum(shares, axis=1, keepdims=True)
    part = shares / np.where(total > 0, total, 1.0)
    return np.asarray(-np.sum(shares * np.log(np.where(part > 0, part, 1.0)), axis=1))


def posture_functions(joints: Floats) -> Floats:
    """Posture features (n, POSTURE) of joints (n, k) [rad]: sine and cosine of axis 2, of axes 2 + 3 and of axes 2
    - 3.
    """
    if joints.shape[1] < 3:
        return np.zeros((len(joints), POSTURE))
    second, third = joints[:, 1], joints[:, 2]
    angles = (second, second + third, second - third)
    return np.stack([f(a) for a in angles for f in (np.sin, np.cos)], axis=1)
