"""Seconds of moves: the way of a whole program as one string of intervals, and a controller that runs along it.

Speed squared over the way is found by a pass forwards and one backwards (the phase plane), where each interval has its
own limit and accelerations; controllers whose ramps are S-curves, sines or of one time plan each move in closed form.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from bench.sixth_author.arm import Arm, angles_of, orientation
from bench.sixth_author.programs import Move

_INTERVALS = 56  # of a move
_JOINT_SPEED = 1500.0  # of the tool at 100 percent of a joint move [mm/s]


@dataclass(frozen=True)
class Piece:
    """k intervals of a way. The way is counted in mm, in shares of a joint move, or in shares of a turn on the spot."""

    length: np.ndarray  # (k,)
    move: np.ndarray  # (k,) index
    slope: np.ndarray  # (k,) sine of how steeply the tool goes up
    reach: np.ndarray  # (k,) distance from the first axis [mm]
    axes: np.ndarray  # (k, 6) turn of each axis per length [rad]
    turn: np.ndarray  # (k,) turn of the tool per length [rad]
    radius: np.ndarray  # (k,) of curvature [mm]
    joint: np.ndarray  # (k,) whether of a joint move
    heading: np.ndarray  # (k, 3) share of the way along x, y and z


@dataclass(frozen=True)
class Way(Piece):
    """The way of n moves, piece after piece."""

    stops: np.ndarray  # (n,) whether a move ends in an exact stop
    first: np.ndarray  # (n,) interval
    last: np.ndarray  # (n,) interval behind the last one
    whole: np.ndarray  # (n,) length


def lay(moves: Sequence[Move], arm: Arm, corner: float) -> Way:
    """The way of a program whose corners begin `corner` times their radius ahead."""
    cuts = _cuts(moves, corner)
    pieces = [
        _joint_piece(i, move, arm) if move.kind == "joint" else _tool_piece(i, moves, cuts, arm)
        for i, move in enumerate(moves)
    ]
    last = np.cumsum([len(piece.length) for piece in pieces])
    joined = {
        name: np.concatenate([getattr(piece, name) for piece in pieces])
        for name in Piece.__dataclass_fields__
    }
    whole = np.array([piece.length.sum() for piece in pieces])
    return Way(**joined, stops=cuts == 0, first=np.r_[0, last[:-1]], last=last, whole=whole)


def _cuts(moves: Sequence[Move], corner: float) -> np.ndarray:
    """What the corner at each end takes off the move [mm] (n,)."""
    cuts = np.zeros(len(moves))
    for i in range(len(moves) - 1):
        a, b = moves[i], moves[i + 1]
        if corner > 0 and a.blend > 0 and a.kind == b.kind == "linear":
            before, after = np.linalg.norm(a.end - a.start), np.linalg.norm(b.end - b.start)
            if before > 2 and after > 2:
                cuts[i] = min(corner * a.blend, 0.48 * before, 0.48 * after)
    return cuts


def _joint_piece(index: int, move: Move, arm: Arm) -> Piece:
    """All axes in proportion; fills in joints or points, which the program leaves open."""
    if not move.joints_start.size:
        a, b = (
            arm.inverse(point[None], orientation(turn).as_matrix()[None])[0]
            for point, turn in ((move.start, move.turn_start), (move.end, move.turn_end))
        )
        b[[3, 5]] += 2 * np.pi * np.round((a - b)[[3, 5]] / 2 / np.pi)
        move.joints_start, move.joints_end = a, b
    if not move.start.size:
        points, turns = arm.forward(np.stack([move.joints_start, move.joints_end]))
        move.start, move.end = points
        move.turn_start, move.turn_end = angles_of(turns[0]), angles_of(turns[1])
    way = move.joints_end - move.joints_start
    n = _INTERVALS
    points, _ = arm.forward(move.joints_start + np.linspace(0, 1, n + 1)[:, None] * way)
    slope = np.diff(points, axis=0)[:, 2] / (np.linalg.norm(np.diff(points, axis=0), axis=1) + 1e-9)
    per_axis = np.tile(np.abs(way), (n, 1))
    return _piece(index, points, np.full(n, 1.0 / n), slope, per_axis, np.zeros(n), np.full(n, np.inf), True)


def _tool_piece(index: int, moves: Sequence[Move], cuts: np.ndarray, arm: Arm) -> Piece:
    """A line with its halves of the corners, or an arc; fills in the joints, which the program leaves open."""
    move = moves[index]
    points, radius = _arc(move) if move.kind == "circular" else _line(index, moves, cuts)
    steps = np.diff(points, axis=0)
    length = np.linalg.norm(steps, axis=1)
    if length.sum() < 1e-6:  # a turn on the spot
        length = np.full(len(length), 1.0 / len(length))
    slope = steps[:, 2] / np.maximum(np.linalg.norm(steps, axis=1), 1e-9)
    start = orientation(move.turn_start)
    turn = (start.inv() * orientation(move.turn_end)).as_rotvec()
    move.turned = float(np.linalg.norm(turn))
    place = np.r_[0, np.cumsum(length)]
    turns = start * Rotation.from_rotvec(np.outer(place / place[-1], turn))
    joints = arm.inverse(points, turns.as_matrix())
    move.joints_start, move.joints_end = joints[0], joints[-1]
    per_axis = np.abs(np.diff(joints, axis=0)) / length[:, None]
    per_turn = np.full(len(length), move.turned / place[-1])
    return _piece(index, points, length, slope, per_axis, per_turn, radius, False)


def _piece(
    index: int,
    points: np.ndarray,
    length: np.ndarray,
    slope: np.ndarray,
    axes: np.ndarray,
    turn: np.ndarray,
    radius: np.ndarray,
    joint: bool,
) -> Piece:
    """What all kinds of moves have; `points` (k + 1, 3) [mm]."""
    steps, k = np.diff(points, axis=0), len(length)
    far = np.hypot(points[:, 0], points[:, 1])
    heading = np.abs(steps) / np.maximum(np.linalg.norm(steps, axis=1), 1e-9)[:, None]
    reach = (far[1:] + far[:-1]) / 2
    return Piece(length, np.full(k, index), slope, reach, axes, turn, radius, np.full(k, joint), heading)


def _arc(move: Move) -> tuple[np.ndarray, np.ndarray]:
    """Points (k + 1, 3) and radii (k,) [mm] of a circle through three points."""
    u, w = np.array(move.via) - move.start, move.end - move.start
    normal = np.cross(u, w)
    square = normal @ normal
    centre = move.start + (np.cross(normal, u) * (w @ w) + np.cross(w, normal) * (u @ u)) / (2 * square)
    radius = np.linalg.norm(move.start - centre)
    x, z = (move.start - centre) / radius, normal / np.sqrt(square)
    y = np.cross(z, x)
    whole = math.atan2((move.end - centre) @ y, (move.end - centre) @ x) % (2 * np.pi)
    angle = np.linspace(0, whole, _INTERVALS + 1)[:, None]
    points = centre + radius * (np.cos(angle) * x + np.sin(angle) * y)
    return points, np.full(_INTERVALS, radius)


def _line(index: int, moves: Sequence[Move], cuts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (k + 1, 3) and radii (k,) [mm] of a line, with half of the corner at either end."""
    move = moves[index]
    length = np.linalg.norm(move.end - move.start)
    way = (move.end - move.start) / max(length, 1e-9)
    before, after = cuts[index - 1] if index else 0.0, cuts[index]
    points = move.start + np.linspace(before, length - after, _INTERVALS + 1)[:, None] * way
    radius = np.full(_INTERVALS, np.inf)
    if before > 0:
        other = _unit(moves[index - 1])
        half, bend = _half_corner(move.start - before * other, move.start, move.start + before * way, 0.5)
        points, radius = np.vstack([half, points[1:]]), np.r_[bend, radius]
    if after > 0:
        other = _unit(moves[index + 1])
        half, bend = _half_corner(move.end - after * way, move.end, move.end + after * other, 0.0)
        points, radius = np.vstack([points, half[1:]]), np.r_[radius, bend]
    return points, radius


def _unit(move: Move) -> np.ndarray:
    way = move.end - move.start
    return np.asarray(way / np.linalg.norm(way))


def _half_corner(
    begin: np.ndarray, middle: np.ndarray, end: np.ndarray, at: float
) -> tuple[np.ndarray, np.ndarray]:
    """Points (11, 3) and radii (10,) [mm] of half a parabola, from parameter `at` on."""
    t = np.linspace(0, 0.5, 11) + at
    points = ((1 - t) ** 2)[:, None] * begin + (2 * t * (1 - t))[:, None] * middle + (t**2)[:, None] * end
    first = np.gradient(points, axis=0)
    second = np.gradient(first, axis=0)
    bend = np.linalg.norm(first, axis=1) ** 3 / (np.linalg.norm(np.cross(first, second), axis=1) + 1e-9)
    return points, np.maximum((bend[1:] + bend[:-1]) / 2, 0.15)


@dataclass(frozen=True)
class Controller:
    """One reality, or what the simulation takes for it. The values here are neutral."""

    acceleration: float = 3000.0  # [mm/s^2]
    corner_acceleration: float = 3000.0  # across the way [mm/s^2]
    speed_factor: float = 1.0
    stretch: float = 1.0  # durations are divided by it
    clamp: float = np.inf  # of the tool's speed [mm/s]
    turn_speed: float = np.inf  # of the tool [rad/s]
    turn_acceleration: float = np.inf  # [rad/s^2]
    jerk: float = np.inf  # [mm/s^3]
    gravity: float = 0.0  # share of acceleration lost straight up
    gravity_variant: int = 0  # 0 lifts and brakes are weaker, 1 both ramps by direction, 2 force balance
    gyration: float = 0.0  # radius of the arm's own inertia [mm], 0: none
    reference_reach: float = 1000.0  # where accelerations are as told [mm]
    arm_mass: float = 0.0  # [kg], 0: loads do not count
    wrist_inertia: float = 0.0  # [kg m^2], 0: inertias of loads do not count
    joint_speeds: np.ndarray | None = None  # (6,) [rad/s]
    joint_accelerations: np.ndarray | None = None  # (6,) [rad/s^2]
    torque_loss: float = 0.0  # share of acceleration lost at rated speed
    knee: float = 0.4  # share of rated speed where that begins
    viscous: float = 0.0  # share lost at rated speed
    coulomb: float = 0.0  # share lost at any speed
    friction_helps: float = 0.0  # 1: friction brakes, too
    slides: np.ndarray | None = None  # (3,) shares of the acceleration that the axes of a gantry have
    settle: float = 0.0  # at every exact stop [s]
    dispatch: float = 0.0  # per move [s]
    corner: float = 1.0  # share of the radius at which corners begin
    cycle: float = 0.0  # [s], 0: none
    rounds_up: bool = True  # durations to whole cycles, else to the nearest
    warm_amplitude: float = 0.0  # at the start
    warm_time: float = 1e9  # [s]
    warms: str = "rate"  # or "acc": the whole time or the accelerations
    waits: np.ndarray | None = None  # (n,) [s]
    law: str = "trap"  # "fir", "dS", "sin2", "ramp"
    ramp_time: float = 0.0  # [s] of a filter, or the shortest ramp


class Engine:
    """Runs a program; ways are kept by how their corners begin."""

    def __init__(self, moves: Sequence[Move], arm: Arm, base: Controller) -> None:
        self.moves, self.arm, self.base = moves, arm, base
        self._ways: dict[float, Way] = {}

    def way(self, corner: float) -> Way:
        """The way with corners that begin so many times their radius ahead."""
        key = round(corner, 4)
        if key not in self._ways:
            self._ways[key] = lay(self.moves, self.arm, key)
        return self._ways[key]

    def run(
        self, accelerates: np.ndarray | float = 1.0, speeds: np.ndarray | float = 1.0, **changes: Any
    ) -> np.ndarray:
        """Durations (n,) [s] with changes of the controller, and factors of each move's accelerations and speed."""
        told = replace(self.base, **changes)
        times = self._planned(told, accelerates, speeds)
        if told.warm_amplitude:
            cold = np.exp(-np.r_[0, np.cumsum(times)[:-1]] / told.warm_time)
            slower = 1 + told.warm_amplitude * cold
            times = (
                times * slower if told.warms == "rate" else self._planned(told, accelerates / slower, speeds)
            )
        if told.waits is not None:
            times = times + told.waits
        if told.cycle:
            rounded = np.ceil(times / told.cycle - 1e-9) if told.rounds_up else np.round(times / told.cycle)
            times = rounded * told.cycle
        return times

    def _planned(
        self, told: Controller, accelerates: np.ndarray | float, speeds: np.ndarray | float
    ) -> np.ndarray:
        """Durations (n,) [s] without warmth, waits and cycles."""
        way = self.way(told.corner)
        with np.errstate(all="ignore"):
            limit = self._limit(way, told) * np.broadcast_to(speeds, len(self.moves))[way.move]
            strength = self._strength(way, told) * np.broadcast_to(accelerates, len(self.moves))[way.move]
            up, down = _ramps(way, told, strength)
        if told.law in ("dS", "sin2", "ramp"):
            times = self._closed(way, told, limit, up, down)
        else:
            times = self._phase_plane(way, told, limit, up, down)
        if told.law == "fir":
            times = times + told.ramp_time * way.stops
        return times / told.stretch + told.settle * way.stops + told.dispatch

    def _of_moves(self, way: Way, name: str) -> np.ndarray:
        return np.array([getattr(move, name) for move in self.moves])[way.move]

    def _limit(self, way: Way, told: Controller) -> np.ndarray:
        """The highest speed in each interval (k,), lengths per second."""
        speed = np.array([1000.0 if np.isnan(move.speed) else move.speed for move in self.moves])[way.move]
        share = np.minimum(np.array([_percent(move) for move in self.moves])[way.move] / 100, 1.0)
        axes = np.where(way.axes < 1e-9, 1e-12, way.axes)
        by_axes = share * np.min(self.arm.speeds / axes, 1)
        limit = np.where(
            way.joint, by_axes * told.speed_factor, np.minimum(speed * told.speed_factor, told.clamp)
        )
        limit = np.minimum(limit, np.where(way.joint, np.inf, told.turn_speed / np.maximum(way.turn, 1e-12)))
        if told.joint_speeds is not None:
            limit = np.minimum(limit, np.min(told.joint_speeds / axes, 1))
        return np.minimum(limit, np.where(way.joint, np.inf, np.sqrt(told.corner_acceleration * way.radius)))

    def _strength(self, way: Way, told: Controller) -> np.ndarray:
        """The acceleration in each interval (k,), lengths per second squared."""
        ratio = told.acceleration / self.base.acceleration
        axes = np.where(way.axes < 1e-9, 1e-12, way.axes)
        own = np.tile(self.arm.accelerations, (len(way.move), 1)) * ratio
        if told.wrist_inertia:
            own[:, 3:] /= (1 + self._of_moves(way, "inertia") / told.wrist_inertia)[:, None]
        a = np.where(way.joint, np.min(own / axes, 1), told.acceleration)
        if told.slides is not None:
            a = np.minimum(a, np.min(told.slides * told.acceleration / np.maximum(way.heading, 1e-6), 1))
        if told.joint_accelerations is not None:
            a = np.minimum(a, np.min(told.joint_accelerations / axes, 1))
        turning = told.turn_acceleration * ratio / np.maximum(way.turn, 1e-12)
        a = np.minimum(a, np.where(way.joint, np.inf, turning))
        if told.arm_mass:
            a = a / (1 + self._of_moves(way, "payload") / told.arm_mass)
        if told.gyration:
            here = told.gyration**2 + way.reach**2
            a = a * (told.gyration**2 + told.reference_reach**2) / here
        return a

    def _phase_plane(
        self, way: Way, told: Controller, limit: np.ndarray, up: np.ndarray, down: np.ndarray
    ) -> np.ndarray:
        """Durations (n,) [s] of a controller that looks ahead over the whole way between stops."""
        squares = np.empty(len(way.length) + 1)
        squares[1:-1] = np.minimum(limit[1:], limit[:-1]) ** 2
        squares[0] = squares[-1] = 0
        squares[way.last[way.stops]] = 0
        rated = self._rated(way, told)
        loss = _Loss(told.torque_loss, told.knee, -told.viscous)
        gain = replace(loss, drag=told.friction_helps * told.viscous)
        ahead = _reached((2 * up * way.length).tolist(), squares.tolist(), rated.tolist(), loss)
        back = _reached((2 * down * way.length).tolist()[::-1], ahead[::-1], rated.tolist()[::-1], gain)
        speed = np.sqrt(back[::-1])
        if told.torque_loss > 0 or told.viscous > 0:
            share = rated * (speed[:-1] + speed[1:]) / 2
            up, down = up * loss.left(share), down * gain.left(share)
        seconds = _interval_seconds(way.length, limit, speed[:-1], speed[1:], up, down)
        return np.bincount(way.move, seconds, len(self.moves))

    def _rated(self, way: Way, told: Controller) -> np.ndarray:
        """Share of rated speed per speed along the way (k,)."""
        by_axes = np.max(way.axes / self.arm.speeds, 1)
        return by_axes if told.torque_loss else np.where(way.joint, by_axes, 1 / _JOINT_SPEED)

    def _closed(
        self, way: Way, told: Controller, limit: np.ndarray, up: np.ndarray, down: np.ndarray
    ) -> np.ndarray:
        """Durations (n,) [s] of moves with one ramp up, one down and one speed between, by means over the way."""
        a, b, top = (np.empty(len(self.moves)) for _ in range(3))
        for i in range(len(self.moves)):
            of_move = slice(way.first[i], way.last[i])
            third = max(2, (way.last[i] - way.first[i]) // 3)
            a[i] = 1 / np.mean(1 / up[of_move][:third])
            b[i] = 1 / np.mean(1 / down[of_move][-third:])
            top[i] = np.mean(limit[of_move] ** -2.0) ** -0.5

        def ramps(speed: np.ndarray) -> np.ndarray:
            return self._ramp_time(told, speed, a) + self._ramp_time(told, speed, b)

        low, high = np.zeros(len(top)), top.copy()
        reached = top * ramps(top) / 2 <= way.whole
        for _ in range(45):
            middle = (low + high) / 2
            fits = middle * ramps(middle) / 2 <= way.whole
            low, high = np.where(fits, middle, low), np.where(fits, high, middle)
        speed = np.where(reached, top, low)
        return ramps(speed) + np.maximum(way.whole - speed * ramps(speed) / 2, 0) / speed

    def _ramp_time(self, told: Controller, speed: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Seconds (n,) of a ramp to a speed."""
        if told.law == "sin2":
            return np.pi * speed / (2 * a)
        if told.law == "ramp":
            return np.maximum(speed / a, told.ramp_time)
        if not np.isfinite(told.jerk):
            return speed / a
        joint = np.array([move.kind == "joint" for move in self.moves])
        jerk = np.where(joint, a * told.jerk / self.base.acceleration, told.jerk)
        return np.where(speed >= a * a / jerk, speed / a + a / jerk, 2 * np.sqrt(speed / jerk))


def _percent(move: Move) -> float:
    """Programmed speed of a joint move, percent of rated."""
    if move.percent is not None:
        return move.percent
    return 100.0 if np.isnan(move.speed) else move.speed / 15.0


def _ramps(way: Way, told: Controller, strength: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations and decelerations (k,) under weight and friction, lengths per second squared."""
    up, down = strength.copy(), strength.copy()
    weight = np.where(way.joint, 0, told.gravity) * way.slope
    if told.gravity:
        if told.gravity_variant == 0:
            up *= 1 - np.maximum(weight, 0)
            down *= 1 - np.maximum(-weight, 0)
        else:
            up *= 1 - weight
            down *= 1 - weight if told.gravity_variant == 1 else 1 + weight
    if told.coulomb:
        up *= 1 - told.coulomb
        down *= 1 + told.friction_helps * told.coulomb
    return up, down


@dataclass(frozen=True)
class _Loss:
    """What is left of an acceleration at a share of rated speed."""

    torque: float  # share lost at rated speed
    knee: float  # share of rated speed where that begins
    drag: float  # share gained at rated speed

    def left(self, share: np.ndarray) -> np.ndarray:
        """The factor (k,), 0.08 at least."""
        lost = self.torque * np.maximum(0, (share - self.knee) / (1 - self.knee))
        return np.maximum(1 - lost + self.drag * share, 0.08)


def _reached(gains: list[float], squares: list[float], rated: list[float], loss: _Loss) -> list[float]:
    """Squares of speed that are reached from the first node on, at most `squares`, with `gains` per interval."""
    torque, knee, drag = loss.torque, loss.knee, loss.drag
    depends, reached, square = torque > 0 or drag != 0, [0.0] * len(squares), 0.0
    for i, gain in enumerate(gains):
        factor = 1.0
        if depends:
            share = rated[i] * math.sqrt(square)
            if torque:
                factor -= torque * max(0.0, (share - knee) / (1 - knee))
            factor = max(factor + drag * share, 0.08)
        square = min(square + gain * factor, squares[i + 1])
        reached[i + 1] = square
    return reached


def _interval_seconds(
    length: np.ndarray,
    limit: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    up: np.ndarray,
    down: np.ndarray,
) -> np.ndarray:
    """Seconds (k,) inside intervals: faster, along the limit, slower."""
    with np.errstate(all="ignore"):
        peak = (2 * length + begin**2 / up + end**2 / down) / (1 / up + 1 / down)
        peak = np.sqrt(np.maximum(peak, 0))
        peak = np.maximum(np.minimum(peak, limit), np.maximum(begin, end))
        rest = length - (peak**2 - begin**2) / 2 / up - (peak**2 - end**2) / 2 / down
        return (peak - begin) / up + (peak - end) / down + np.maximum(rest, 0) / peak
