"""Seconds of moves: a numeric engine of this author's own, with every effect of the contract as a number of a `World`.

Speed along the path is found on stations by a forward and a backward pass, with limits and accelerations that may
depend on place and speed; finite jerk is the integral of dv / acceleration with ramps of the acceleration at both ends.
"""

from dataclasses import dataclass, field

import numpy as np

from bench.fourth_author.robots import Arm

JOINT, LINEAR, CIRCULAR, WAIT = 0, 1, 2, 3
_COARSE, _FINE = 25, 401


@dataclass
class Moves:
    """m moves; path units are m, or rad (m of a slide) of the leading axis in joint moves."""

    kind: np.ndarray  # (m,)
    q: np.ndarray  # (m, COARSE, n) readings along the path
    p: np.ndarray  # (m, COARSE, 3) tool [m]
    start: np.ndarray  # (m, 3, 3) tool rotation at the start
    end: np.ndarray  # (m, 3, 3)
    via: np.ndarray  # (m, 3) middle point of a circular move [m], else nan
    length: np.ndarray  # (m,) path units
    turn: np.ndarray  # (m,) reorientation [rad]
    speed: np.ndarray  # (m,) programmed, path units/s
    accel: np.ndarray  # (m,) of the simulation, path units/s^2
    zone: np.ndarray  # (m,) radius of the corner at the end [m], 0: exact stop
    payload: np.ndarray  # (m,) [kg]
    inertia: np.ndarray  # (m,) of the load [kg m^2]
    pause: np.ndarray  # (m,) programmed seconds of a wait
    percent: np.ndarray  # (m,) programmed speed of joint moves, percent of rated
    override: np.ndarray  # (m,) fraction
    cycle: np.ndarray  # (m,)
    line: np.ndarray  # (m,)

    def __len__(self) -> int:
        return len(self.kind)


@dataclass
class World:
    """One reality. The neutral values are those of a plain simulation."""

    accel: float = 1.0  # ratio
    ramp: float = 0.0  # seconds in which the acceleration builds up: a / jerk
    up: float = 0.0  # share of acceleration lost straight up (gained straight down) while speeding up
    brake: float = 0.0  # share gained straight up while slowing down
    reach: float = 0.0  # accelerations divided by 1 + reach R^2 [1/m^2]
    carry: float = 0.0  # accelerations divided by 1 + carry m [1/kg]
    bulk: float = 0.0  # accelerations of the last three axes divided by 1 + bulk J [1/(kg m^2)]
    axis_accel: np.ndarray | None = None  # (n,) limits [rad/s^2] on linear paths
    axis_speed: np.ndarray | None = None  # (n,) limits [rad/s]
    weak: float = 0.0  # share of acceleration lost at an axis' rated speed
    knee: float = 0.5  # share of rated speed where the loss begins
    viscous: float = 0.0  # share of acceleration lost (gained in braking) at rated speed
    clamp: float = np.inf  # tool speed that is not exceeded [m/s]
    omega: float = np.inf  # turning speed of the tool [rad/s]
    cruise: float = 1.0  # speed ratio
    stretch: float = 1.0  # ratio of an override of the whole profile
    settle: float = 0.0  # s per exact stop
    dispatch: float = 0.0  # s per move
    blend: float = 0.0  # share of the corner's saving that happens
    tick: float = 0.0  # controller's cycle [s], 0: none
    warm: float = 0.0  # relative lateness at the start
    warm_time: float = 600.0  # time constant [s]
    waits: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (m,) s


def seconds(moves: Moves, world: World, arm: Arm) -> np.ndarray:
    """Durations (m,) [s] of one reality, without the recorder."""
    profile = _Path(moves, world, arm)
    times, peak, up, down = profile.run()
    if world.ramp > 0:
        times = (
            times
            + ramped(peak, up, down, moves.length, up * 0 + world.ramp)
            - ramped(peak, up, down, moves.length, up * 0)
        )
    saved = world.blend * to_go(
        np.minimum(moves.zone, 0.4 * profile.metres) / np.maximum(profile.metres, 1e-9),
        peak,
        down,
        moves.length,
    )
    times = np.maximum(times - saved, 0.3 * times)
    times = times + world.dispatch + world.settle * (moves.zone <= 0)
    times = np.where(moves.kind == WAIT, moves.pause, times)
    if world.tick > 0:
        times = np.ceil(times / world.tick - 1e-9) * world.tick
    if world.warm:
        clock = np.cumsum(times) - times
        times = times * (1 + world.warm * np.exp(-clock / world.warm_time) * (moves.kind != WAIT))
    if len(world.waits):
        times = times + world.waits
    return times


class _Path:
    """Limits and accelerations at the stations of all moves."""

    def __init__(self, moves: Moves, world: World, arm: Arm) -> None:
        self.moves, self.world, self.arm = moves, world, arm
        m = len(moves)
        coarse = np.linspace(0, 1, _COARSE)
        self.u = (1 - np.cos(np.pi * np.linspace(0, 1, _FINE))) / 2
        length = np.maximum(moves.length, 1e-9)
        steps = np.linalg.norm(np.diff(moves.p, axis=1), axis=2).sum(axis=1)
        self.metres = steps
        first = np.gradient(moves.q, coarse, axis=1) / length[:, None, None]
        second = np.gradient(first, coarse, axis=1) / length[:, None, None]
        second[moves.kind == JOINT] = 0
        tangent = np.gradient(moves.p, coarse, axis=1)
        climb = tangent[:, :, 2] / np.maximum(np.linalg.norm(tangent, axis=2), 1e-9)
        radius = np.hypot(moves.p[:, :, 0], moves.p[:, :, 1])
        self.first, self.second = (np.abs(_spread(x, coarse, self.u)) for x in (first, second))
        self.climb, self.radius = (_spread(x[:, :, None], coarse, self.u)[:, :, 0] for x in (climb, radius))
        self.length = length
        share = self.first / arm.speeds
        self.rate = share.max(axis=2)  # share of rated axis speed per path speed
        self.joint = moves.kind == JOINT
        self.base = np.repeat((moves.accel * world.accel * world.stretch**2)[:, None], _FINE, axis=1)
        self.base = self.base / (1 + world.reach * self.radius**2)
        self.base = self.base / (1 + world.carry * moves.payload)[:, None]
        if world.bulk:
            scale = np.ones((m, arm.n))
            scale[:, -3:] = 1 / (1 + world.bulk * moves.inertia)[:, None]
            own = (arm.accelerations * scale)[:, None, :] / np.maximum(self.first, 1e-9)
            plain = arm.accelerations / np.maximum(self.first, 1e-9)
            self.base = np.where(
                self.joint[:, None], self.base * own.min(axis=2) / plain.min(axis=2), self.base
            )

    def run(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Seconds, highest speed, mean accelerations of start and end (m,)."""
        w, moves = self.world, self.moves
        cap = np.repeat((moves.speed * moves.override * w.cruise * w.stretch)[:, None], _FINE, axis=1)
        straight = ~self.joint
        cap[straight] = np.minimum(cap[straight], w.clamp)
        if np.isfinite(w.omega):
            turning = w.omega * self.length / np.maximum(moves.turn, 1e-9)
            cap[straight] = np.minimum(cap[straight], turning[straight, None])
        if w.axis_speed is not None:
            cap = np.minimum(cap, (w.axis_speed / np.maximum(self.first, 1e-9)).min(axis=2))
        forward = self._pass(cap, 1)
        squared = self._pass(np.minimum(cap, forward), -1)
        speed = np.sqrt(np.maximum(squared, 0))
        ds = np.diff(self.u) * self.length[:, None]
        times = (2 * ds / np.maximum(speed[:, 1:] + speed[:, :-1], 1e-12)).sum(axis=1)
        times[moves.kind == WAIT] = 0
        third = _FINE // 4
        up, down = self._available(0 * cap, 1), self._available(0 * cap, -1)
        return times, speed.max(axis=1), up[:, :third].mean(axis=1), down[:, -third:].mean(axis=1)

    def _available(self, speed: np.ndarray, way: int, at: slice | int = slice(None)) -> np.ndarray:
        """Acceleration at stations, at a speed, forward (1) or in braking (-1)."""
        w = self.world
        climb, rate, base = self.climb[:, at], self.rate[:, at], self.base[:, at]
        factor = 1 - w.up * climb if way > 0 else 1 + w.brake * climb
        if w.weak or w.viscous:
            used = np.clip(rate * speed, 0, 1.2)
            factor = factor * (1 - w.weak * np.clip((used - w.knee) / (1 - w.knee), 0, 1.1))
            factor = factor * (1 - way * w.viscous * used)
        result = base * np.maximum(factor, 0.05)
        if w.axis_accel is not None:
            first, second = self.first[:, at], self.second[:, at]
            room = np.maximum(w.axis_accel - second * (speed**2)[..., None], 0.1 * w.axis_accel)
            limit = (room / np.maximum(first, 1e-9)).min(axis=-1)
            lines = (~self.joint)[:, None] if isinstance(at, slice) else ~self.joint
            result = np.where(lines, np.minimum(result, limit), result)
        return result

    def _pass(self, cap: np.ndarray, way: int) -> np.ndarray:
        """Squared speeds (m, stations) (forward: speeds) that the accelerations allow, from rest."""
        out = np.zeros_like(cap)
        by_speed = self.world.weak or self.world.viscous or self.world.axis_accel is not None
        order = range(1, _FINE) if way > 0 else range(_FINE - 2, -1, -1)
        for i in order:
            j = i - way
            ds = abs(self.u[i] - self.u[j]) * self.length
            v = np.sqrt(out[:, j])
            a = self._available(v, way, j)
            if by_speed:
                middle = np.sqrt(out[:, j] + a * ds)
                a = self._available(middle, way, j)
            out[:, i] = np.minimum(out[:, j] + 2 * a * ds, cap[:, i] ** 2)
        return np.sqrt(out) if way > 0 else out


def _spread(values: np.ndarray, coarse: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """(m, coarse, k) → (m, fine, k) by straight lines."""
    at = np.clip(np.searchsorted(coarse, fine, side="right") - 1, 0, len(coarse) - 2)
    part = ((fine - coarse[at]) / (coarse[at + 1] - coarse[at]))[None, :, None]
    return values[:, at] * (1 - part) + values[:, at + 1] * part


def ramped(
    speed: np.ndarray, up: np.ndarray, down: np.ndarray, length: np.ndarray, ramp: np.ndarray
) -> np.ndarray:
    """Seconds (m,) from rest to rest with accelerations that build up in `ramp` seconds; the peak by bisection."""
    low, high = 0 * speed, speed.copy()

    def legs(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pairs = [_leg(v, a, ramp) for a in (up, down)]
        return pairs[0][0] + pairs[1][0], pairs[0][1] + pairs[1][1]

    full = legs(high)[1] <= length
    for _ in range(45):
        middle = (low + high) / 2
        fits = legs(middle)[1] <= length
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    v = np.where(full, speed, low)
    t, d = legs(v)
    return t + np.maximum(length - d, 0) / np.maximum(v, 1e-12)


_NODES = (np.arange(160) + 0.5) / 160 * np.pi / 2
_SHARE = np.sin(_NODES)[:, None] ** 2
_SLOPE = (2 * np.sin(_NODES) * np.cos(_NODES))[:, None]


def _leg(v: np.ndarray, a: np.ndarray, ramp: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Seconds and path of a rise from rest to v: the integrals of dv / alpha and v dv / alpha by the middle rule."""
    speed = v * _SHARE
    dv = v * _SLOPE * (np.pi / 2 / 160)
    jerk = a / np.maximum(ramp, 1e-9)
    alpha = np.minimum(a, np.sqrt(2 * jerk * np.minimum(speed, v - speed)))
    t = (dv / np.maximum(alpha, 1e-12)).sum(axis=0)
    return t, (speed * dv / np.maximum(alpha, 1e-12)).sum(axis=0)


def to_go(share: np.ndarray, speed: np.ndarray, down: np.ndarray, length: np.ndarray) -> np.ndarray:
    """Seconds before the stop at which the next move may begin: the rest of the path is `share` of its length."""
    rest = share * length
    stop = speed**2 / (2 * np.maximum(down, 1e-9))
    ramp = np.sqrt(2 * np.minimum(rest, stop) / np.maximum(down, 1e-9))
    return np.where(rest > 0, ramp + np.maximum(rest - stop, 0) / np.maximum(speed, 1e-9), 0)
