"""Acceleration limits of a path from the torque limits of the joints."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.dynamics.torques import DynamicModel, drives_of, gravity_torques, inertia_forces, same_shape
from olp.robots.model import Body

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_RAMP_SAMPLES: Final = 9  # along one ramp; torque changes slowly there: the pose turns by some degrees
_STEPS: Final = (
    15  # of the search: 1e-6 below the largest rate as a rule, 0.4 % at worst of 1000 random moves
)


class PathTorque(NamedTuple):
    """Torques along a path q(s): inertia s'' + squared s'² + linear s' + constant, for s' >= 0. Each (n, k)."""

    inertia: Array  # [Nm s² | N s²] M q_s
    squared: Array  # [Nm s² | N s²] M q_ss + centrifugal and Coriolis forces at q_s
    linear: Array  # [Nm s | N s] viscous friction
    constant: Array  # [Nm | N] gravity and Coulomb friction

    def at(self, speed: ArrayLike, acceleration: ArrayLike) -> Array:
        """Torques (n, k) [Nm | N] for s' [1/s] and s'' [1/s²], each () or (n,)."""
        v, a = (np.asarray(x, dtype=np.float64)[..., None] for x in (speed, acceleration))
        return self.inertia * a + self.squared * v**2 + self.linear * v + self.constant


class AccelerationInterval(NamedTuple):
    """Admissible s'' per sample, and the indices of the axes that limit it; empty where `lower` > `upper`."""

    lower: Array  # (n,) [1/s²]
    upper: Array  # (n,) [1/s²]
    lower_axis: Indices  # (n,)
    upper_axis: Indices  # (n,)

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """Samples (n,) where some acceleration keeps the torque limits at this speed."""
        return self.lower <= self.upper


class MoveAcceleration(NamedTuple):
    """Largest constant accelerations of joint moves from rest to rest, relative to their length [1/s²]: multiplied
    by |end - start| of an axis they are its acceleration. 0 where the robot cannot hold the pose, infinite without
    torque limits.
    """

    acceleration: Array  # (n,) [1/s²]
    deceleration: Array  # (n,) [1/s²]
    acceleration_axis: Indices  # (n,) the axis whose torque is used most
    deceleration_axis: Indices  # (n,)


def path_torque(
    model: DynamicModel, q: ArrayLike, slope: ArrayLike, curvature: ArrayLike, payload: Body | None = None
) -> PathTorque:
    """The torques along a path: `q`, `slope` dq/ds and `curvature` d²q/ds², each (n, k) [rad | m] (per s, s²).

    Linear in s'' and, without viscous friction, in s'² (Bobrow, Dubowsky, Gibson: Time-optimal control of robotic
    manipulators along specified paths, 1985). Coulomb friction acts against the direction of the path, also at
    rest: a start has to overcome it. Raises OlpError: K002, K007 wrong shapes.
    """
    positions, slopes, curvatures = same_shape(model.robot, q, slope, curvature)
    _, viscous, coulomb = drives_of(model)
    return PathTorque(
        inertia_forces(model, positions, None, slopes, payload),
        inertia_forces(model, positions, slopes, curvatures, payload),
        slopes * viscous,
        gravity_torques(model, positions, payload) + np.sign(slopes) * coulomb,
    )


def acceleration_interval(torque: PathTorque, speed: ArrayLike, limits: ArrayLike) -> AccelerationInterval:
    """The interval of s'' that keeps every torque within `limits` (k,) [Nm | N] at speed s' [1/s], () or (n,)."""
    available = np.asarray(limits, dtype=np.float64)
    needed = torque.at(speed, 0.0)
    size = np.abs(torque.inertia)
    # An axis without inertia along the path limits nothing, unless it is already overloaded.
    idle = size <= 1e-12 * size.max(axis=1, keepdims=True)
    overloaded = idle & (np.abs(needed) > available)
    safe = np.where(idle, 1.0, size)
    sense = np.where(torque.inertia < 0.0, -1.0, 1.0)
    upper = np.where(idle, np.inf, (available - sense * needed) / safe)
    lower = np.where(idle, -np.inf, (-available - sense * needed) / safe)
    upper, lower = np.where(overloaded, -np.inf, upper), np.where(overloaded, np.inf, lower)
    return AccelerationInterval(
        lower.max(axis=1), upper.min(axis=1), lower.argmax(axis=1), upper.argmin(axis=1)
    )


def path_acceleration(
    model: DynamicModel,
    q: ArrayLike,
    slope: ArrayLike,
    curvature: ArrayLike,
    speed: ArrayLike,
    payload: Body | None = None,
) -> AccelerationInterval:
    """Admissible s'' [1/s²] at n samples of a path passed at s' = `speed` [1/s], () or (n,); see `path_torque`."""
    torque = path_torque(model, q, slope, curvature, payload)
    return acceleration_interval(torque, speed, model.torque_limits)


def move_acceleration(
    model: DynamicModel, start: ArrayLike, end: ArrayLike, speed: ArrayLike, payload: Body | None = None
) -> MoveAcceleration:
    """Largest accelerations of n joint moves with synchronised axes: from rest, at a constant rate, to `speed`, and
    to rest.

    `start`, `end` (n, k) [rad | m]; `speed` s' > 0, () or (n,), as a share of the move per second. The torque
    limits hold at nine samples of each ramp. A move too short for its speed reaches its peak where the two ramps
    meet; the smaller rate is tested over the whole move, the other one over its first (last) half. Raises OlpError:
    K002, K007 wrong shapes, K008 a speed that is not positive.
    """
    begins, ends = same_shape(model.robot, start, end)
    top = positive_speed(speed, len(begins))
    ways = ((begins, ends, 1.0), (ends, begins, -1.0))
    half = [_Ramps(model, *way, top, np.full(len(top), 0.5), payload).largest() for way in ways]
    result = []
    for one, other, way in ((half[0], half[1], ways[0]), (half[1], half[0], ways[1])):
        long = (one[0] < other[0]) & (top**2 > one[0])
        if long.any():
            begin, finish, sense = way
            again = _Ramps(model, begin[long], finish[long], sense, top[long], np.ones(long.sum()), payload)
            one[0][long], one[1][long] = again.largest()
        result.append(one)
    return MoveAcceleration(result[0][0], result[1][0], result[0][1], result[1][1])


def positive_speed(speed: ArrayLike, count: int) -> Array:
    """`speed` [1/s] as (count,). Raises OlpError (K008) when an element is not finite and greater than 0."""
    top = np.broadcast_to(np.asarray(speed, dtype=np.float64), (count,))
    if not np.all(np.isfinite(top) & (top > 0.0)):
        raise OlpError(error("K008", "the speed of a move must be finite and greater than 0"))
    return top


class _Ramps(NamedTuple):
    """Ramps from rest at `begin` towards `end`. A stop is a ramp run backwards: then friction has the other `sense`."""

    model: DynamicModel
    begin: Array  # (n, k)
    end: Array  # (n, k)
    sense: float
    top: Array  # (n,) [1/s]
    longest: Array  # (n,) [1] share of the move that the ramp may take
    payload: Body | None

    def largest(self) -> tuple[Array, Indices]:
        """The largest rate (n,) [1/s²] within the limits, and the axis that is used most."""
        high = self._at_rest()
        free = np.isinf(high)
        high = np.where(free, 1.0, high)
        over, axis = self._load(high)
        best = np.where(over <= 1.0, high, 0.0)
        under = over if np.all(over <= 1.0) else self._load(best)[0]
        for turn in range(_STEPS if np.any(over > 1.0) else 0):
            # The load grows almost linearly with the rate: its chord hits well, halving keeps the bracket small.
            share = 0.5 if turn % 3 else np.clip((1.0 - under) / np.maximum(over - under, 1e-12), 0.01, 0.999)
            middle = best + (high - best) * share
            used, _ = self._load(middle)
            holds = used <= 1.0
            best, under = np.where(holds, middle, best), np.where(holds, used, under)
            high, over = np.where(holds, high, middle), np.where(holds, over, used)
        return np.where(free, np.inf, best), np.where(best > 0.0, self._load(best)[1], axis)

    def _at_rest(self) -> Array:
        """Upper bound (n,) [1/s²] of the rate from the first instant of the ramp; 0 where the start pose cannot be
        held.
        """
        torque = self._torque(self.begin)
        interval = acceleration_interval(torque, 0.0, self.model.torque_limits)
        return np.where((interval.lower <= 0.0) & (interval.upper > 0.0), interval.upper, 0.0)

    def _load(self, rate: Array) -> tuple[Array, Indices]:
        """The largest used share (n,) of a torque limit on the ramp at `rate`, and the index of its axis."""
        # Speed grows with the square root of the way: v² = 2 a s.
        length = np.minimum(self.top**2 / np.maximum(2.0 * rate, 1e-300), self.longest)
        way = length[:, None] * np.linspace(0.0, 1.0, _RAMP_SAMPLES)
        poses = self.begin[:, None, :] + (self.end - self.begin)[:, None, :] * way[..., None]
        torque = self._torque(poses.reshape(-1, poses.shape[-1]))
        speeds = np.sqrt(2.0 * rate[:, None] * way).ravel()
        needed = np.abs(torque.at(speeds, np.repeat(rate, _RAMP_SAMPLES)))
        shares = (needed / self.model.torque_limits).reshape(len(rate), _RAMP_SAMPLES, -1).max(axis=1)
        return shares.max(axis=1), shares.argmax(axis=1)

    def _torque(self, poses: Array) -> PathTorque:
        slope = np.repeat(self.end - self.begin, len(poses) // len(self.begin), axis=0)
        torque = path_torque(self.model, poses, slope, np.zeros_like(slope), self.payload)
        if self.sense > 0.0:
            return torque
        coulomb = np.sign(slope) * drives_of(self.model)[2]
        return torque._replace(linear=-torque.linear, constant=torque.constant - 2.0 * coulomb)
