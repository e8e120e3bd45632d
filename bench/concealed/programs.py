"""Random programs as an engineer records them: stations, mixed lengths, speeds and directions, stops, rounded ends."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from bench.concealed.arms import Arm, inverse, rot

Floats = NDArray[np.float64]
GRID = 33  # points along a move at which bodies are evaluated


@dataclass(frozen=True, slots=True)
class Plan:
    """What a program is like. Lengths [m], speeds [m/s], accelerations [m/s^2]."""

    moves: int
    lengths: tuple[float, float] = (0.02, 1.2)
    speeds: tuple[float, ...] = (0.1, 0.25, 0.5, 1.0)
    acceleration: float = 2.0
    cycles: int = 1
    blended: float = 0.0  # share of the moves with a rounded end
    waits: float = 0.0
    joint_moves: float = 0.0
    turning: float = 0.0  # share of the moves that reorient the tool
    loads: tuple[float, ...] = ()  # kg
    inertias: tuple[float, ...] = ()  # kg m^2
    wrist_forward: bool = False  # the tool along the forearm: near the wrist's singularity
    steep_long: bool = False  # the steeper, the longer
    loads_late: bool = False  # the load grows with time
    long_stops: bool = False  # only long moves stop


@dataclass(slots=True)
class Moves:
    """(n,) moves. `place` (n, 2, 3) [m], `turn` (n, 2, 3, 3), `axes` (n, 2, 6) [rad], `path` (n, G, 6) [rad].

    `length` [m] or 1 for a joint move; `speed` [m/s] or share of rated; `blend` [m]; `kind`: 0 linear, 1 joint, 2 wait.
    """

    arm: Arm
    plan: Plan
    kind: NDArray[np.int64]
    place: Floats
    turn: Floats
    axes: Floats
    path: Floats
    length: Floats
    angle: Floats  # [rad] of reorientation
    speed: Floats
    blend: Floats
    wait: Floats  # [s]
    load: Floats
    inertia: Floats
    cycle: NDArray[np.int64]
    line: NDArray[np.int64]
    extra: dict[str, Floats] = field(default_factory=dict)

    def take(self, rows: slice) -> Moves:
        """Some of the moves, in their order."""
        keep = {"arm", "plan", "extra"}
        return Moves(
            **{
                f.name: getattr(self, f.name) if f.name in keep else getattr(self, f.name)[rows]
                for f in fields(self)
            }
        )

    def __len__(self) -> int:
        return len(self.kind)

    @property
    def along(self) -> Floats:
        """(n, G) shares of the way."""
        return np.linspace(0, 1, GRID)

    def slopes(self) -> tuple[Floats, Floats]:
        """dq/ds and d2q/ds2 (n, G, 6) along the path coordinate (m, or 1 for joint moves)."""
        step = np.maximum(self.length, 1e-6)[:, None, None] / (GRID - 1)
        first = np.gradient(self.path, axis=1, edge_order=2) / step
        return first, np.gradient(first, axis=1, edge_order=2) / step

    def steepness(self) -> Floats:
        """(n,) sine of the climb."""
        rise = self.place[:, 1, 2] - self.place[:, 0, 2]
        return np.where(self.kind == 0, rise / np.maximum(self.length, 1e-9), 0.0)

    def radius(self) -> Floats:
        """(n, G) [m] of the tool from the first axis."""
        share = self.along[None, :, None]
        at = self.place[:, :1] * (1 - share) + self.place[:, 1:] * share
        return np.hypot(at[..., 0], at[..., 1])


def random_moves(dice: np.random.Generator, arm: Arm, plan: Plan) -> Moves:
    """Plays the plan once per cycle: the program closes no loop, each cycle repeats the same moves."""
    lines = max(4, plan.moves // plan.cycles)
    kind = np.zeros(lines, dtype=np.int64)
    kind[dice.random(lines) < plan.joint_moves] = 1
    kind[dice.random(lines) < plan.waits] = 2
    hop = np.cumsum(kind != 2)  # a wait ends where it starts
    places, turns = _points(dice, arm, plan, int(hop[-1]))
    before = hop - (kind != 2)
    place = np.stack([places[before], places[hop]], axis=1)
    turn = np.stack([turns[before], turns[hop]], axis=1)
    share = np.linspace(0, 1, GRID)
    path = _paths(arm, place, turn, share, kind)
    length = np.linalg.norm(place[:, 1] - place[:, 0], axis=1)
    length = np.where(kind == 1, 1.0, length)
    speed = dice.choice(plan.speeds, lines)
    speed = np.where(kind == 1, dice.choice([0.1, 0.25, 0.5, 1.0], lines), speed)
    blend = np.where(dice.random(lines) < plan.blended, dice.choice([0.005, 0.01, 0.02, 0.05], lines), 0.0)
    if plan.long_stops:
        blend = np.where(length < np.median(length) * dice.uniform(0.9, 1.1, lines), 0.02, 0.0)
    blend = _blendable(blend, kind, length)
    load = dice.choice(plan.loads, lines) if plan.loads else np.zeros(lines)
    if plan.loads and dice.random() < 0.5:  # picked up and put down, not at random
        load = np.repeat(dice.choice(plan.loads, lines), 5)[:lines]
    if plan.loads_late:
        load = np.sort(load)
    inertia = dice.choice(plan.inertias, lines) if plan.inertias else np.zeros(lines)
    wait = np.where(kind == 2, dice.choice([0.2, 0.5, 1.0], lines), 0.0)
    angle = _angles(turn)
    again = np.tile(np.arange(lines), plan.cycles)
    cycle = np.repeat(np.arange(plan.cycles), lines)
    line = 12 + again * 2
    return Moves(
        arm, plan, kind[again], place[again], turn[again], path[again][:, [0, -1]], path[again], length[again],
        angle[again], speed[again], blend[again], wait[again], load[again], inertia[again], cycle, line,
    )  # fmt: skip


def _blendable(blend: Floats, kind: NDArray[np.int64], length: Floats) -> Floats:
    """Rounded only between two linear moves, by at most 45 % of the shorter."""
    after = np.append(kind[1:], 2)
    shorter = np.minimum(length, np.append(length[1:], 0.0))
    allowed = (kind == 0) & (after == 0) & (shorter > 0.012)
    allowed[-1] = False
    # The zone that the program asks for is also the one that fits: what does not fit is another effect.
    fits = np.where(blend <= 0.45 * shorter, blend, 0.005)
    return np.where(allowed & (blend > 0), fits, 0.0)


def _angles(turn: Floats) -> Floats:
    trace = np.einsum("nij,nij->n", turn[:, 0], turn[:, 1])
    angle: Floats = np.arccos(np.clip((trace - 1) / 2, -1, 1))
    return np.where(angle < 1e-6, 0.0, angle)


def _points(dice: np.random.Generator, arm: Arm, plan: Plan, lines: int) -> tuple[Floats, Floats]:
    """(lines + 1, 3) and (lines + 1, 3, 3): a walk inside the reach, back to a station now and then."""
    near, far = 0.45 * arm.reach, 0.93 * arm.reach
    tilt = _tilt(dice, plan)
    places, turns = [_inside(dice, arm, tilt, near, far)], [tilt]
    stations = [_inside(dice, arm, tilt, near, far) for _ in range(dice.integers(3, 9))]
    low, high = np.log(plan.lengths[0]), np.log(min(plan.lengths[1], 1.1 * arm.reach))
    while len(places) <= lines:
        here = places[-1]
        if dice.random() < 0.12:
            goal = stations[dice.integers(len(stations))]
            length = float(np.linalg.norm(goal - here))
            if length < np.exp(low) or length > 1.3 * plan.lengths[1]:
                continue
        else:
            length = float(np.exp(dice.uniform(low, high)))
            goal = here + _way(dice, plan, arm, here, length, (low, high))
        turned = dice.random() < plan.turning
        frame = tilt @ _rotation(dice) if turned else (tilt if plan.turning else turns[-1])
        if length < 0.1 * arm.reach and turned and dice.random() < 0.3:
            frame = turns[-1]
        if _reachable(arm, np.stack([here, goal]), np.stack([turns[-1], frame]), near, far):
            places.append(goal)
            turns.append(frame)
        elif dice.random() < 0.02:
            # A corner of the room with no way on: leave it by the straightest way.
            goal = _inside(dice, arm, tilt, near, far)
            if _reachable(arm, np.stack([here, goal]), np.stack([turns[-1], tilt]), near, far):
                places.append(goal)
                turns.append(tilt)
    return np.array(places), np.array(turns)


def _way(
    dice: np.random.Generator, plan: Plan, arm: Arm, here: Floats, length: float, span: tuple[float, float]
) -> Floats:
    way = dice.normal(size=3)
    way[2] *= dice.choice([0.2, 1.0, 3.0])
    share = (np.log(length) - span[0]) / max(span[1] - span[0], 1e-9)
    if plan.steep_long:
        climb = np.clip(share + dice.normal(0, 0.12), 0.02, 0.98) * (1 if here[2] < 0.3 * arm.reach else -1)
        flat = dice.uniform(0, 2 * np.pi)
        way = np.array([np.cos(flat) * np.sqrt(1 - climb**2), np.sin(flat) * np.sqrt(1 - climb**2), climb])
    return length * way / np.linalg.norm(way)


def _tilt(dice: np.random.Generator, plan: Plan) -> Floats:
    """The tool's usual stance: down with a tilt, or forward."""
    if plan.wrist_forward:
        return rot(1, np.array(np.pi / 2 + dice.uniform(-0.1, 0.35))) @ rot(2, np.array(dice.uniform(-3, 3)))
    down = np.diag([1.0, -1.0, -1.0])
    return down @ rot(0, np.array(dice.uniform(-0.4, 0.4))) @ rot(1, np.array(dice.uniform(-0.4, 0.4)))


def _rotation(dice: np.random.Generator) -> Floats:
    angle = np.array(dice.choice([0.3, 0.6, 1.0, 1.6]) * dice.choice([-1, 1]))
    axis = int(dice.choice([0, 1, 2, 2]))
    return rot(axis, angle * (0.5 if axis < 2 else 1.0))


def _inside(dice: np.random.Generator, arm: Arm, tilt: Floats, near: float, far: float) -> Floats:
    while True:
        radius, angle = dice.uniform(near, far), dice.uniform(-1.6, 1.6)
        place = np.array(
            [radius * np.cos(angle), radius * np.sin(angle), dice.uniform(-0.2, 0.75) * arm.reach]
        )
        if _reachable(arm, np.stack([place, place]), np.stack([tilt, tilt]), near, far):
            return place


def _reachable(arm: Arm, place: Floats, turn: Floats, near: float, far: float) -> bool:
    share = np.linspace(0, 1, 9)[:, None]
    at = place[:1] * (1 - share) + place[1:] * share
    frames = _between(turn, share[:, 0])
    wrist = at - frames[..., 2] * (arm.d6 + arm.tool)
    radius = np.hypot(wrist[:, 0], wrist[:, 1])
    low = (radius < 0.35 * arm.reach) | (at[:, 2] < -0.45 * arm.reach) | (wrist[:, 0] < -0.3 * arm.reach)
    distance = np.hypot(radius - arm.a1, wrist[:, 2])
    if low.any() or (distance > arm.reach - arm.a1 - 0.04 * arm.reach).any():
        return False
    q = np.unwrap(inverse(arm, at, frames), axis=0)
    if not np.isfinite(q).all() or np.abs(np.diff(q, axis=0)).max() > 0.9:
        return False
    return bool(np.abs(q[:, 1]).max() < 2.4 and np.abs(q[:, 2]).max() < 3.4)


def _between(turn: Floats, share: Floats) -> Floats:
    """Rotations (k, 3, 3) on the shortest way between two."""
    step = turn[0].T @ turn[1]
    angle = float(np.arccos(np.clip((np.trace(step) - 1) / 2, -1, 1)))
    if angle < 1e-6 or angle > 3.0:
        return np.broadcast_to(turn[0], (len(share), 3, 3))
    axis = np.array([step[2, 1] - step[1, 2], step[0, 2] - step[2, 0], step[1, 0] - step[0, 1]])
    axis = axis / np.linalg.norm(axis)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    at = share[:, None, None] * angle
    return turn[0] @ (np.eye(3) + np.sin(at) * cross + (1 - np.cos(at)) * cross @ cross)


def _paths(arm: Arm, place: Floats, turn: Floats, share: Floats, kind: NDArray[np.int64]) -> Floats:
    """(n, G, 6) axes along the moves, without jumps inside one and from one to the next."""
    paths = np.empty((len(place), len(share), 6))
    last: Floats | None = None
    for i in range(len(place)):
        at = place[i, :1] * (1 - share[:, None]) + place[i, 1:] * share[:, None]
        q = np.unwrap(inverse(arm, at, _between(turn[i], share)), axis=0)
        if last is not None:
            q = q + 2 * np.pi * np.round((last - q[0]) / (2 * np.pi))
        if kind[i] == 1:
            q = q[0] + share[:, None] * (q[-1] - q[0])
        last = q[-1]
        paths[i] = q
    return paths
