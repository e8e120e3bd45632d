"""Programs of made-up cells: pallets, spot welds, seams, machine tending, deburring, measuring; as `Moves`."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from bench.fourth_author.motion import CIRCULAR, JOINT, LINEAR, WAIT, Moves
from bench.fourth_author.robots import Arm, rotation_vector, turned

_STATIONS = 25
_DOWN = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]])


@dataclass
class Step:
    """One line of a program: a motion to point `to`, or a wait."""

    kind: int
    to: int = -1
    speed: float = 0.0  # m/s, or fraction of rated in joint moves
    zone: float = 0.0
    payload: float = 0.0
    inertia: float = 0.0
    pause: float = 0.0
    via: np.ndarray | None = None
    line: int = 0
    cycle: int = 0


@dataclass
class Cell:
    """Points and steps while a program is written."""

    rng: np.random.Generator
    arm: Arm
    home: np.ndarray
    scale: float  # horizontal distance of the home position [m]
    points: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    joints: list[np.ndarray] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)
    line: int = 3

    def point(
        self, bearing: float, distance: float, height: float, tilt: float = 0.0, yaw: float = 0.0
    ) -> int:
        """A point at a bearing [rad], at `distance` and `height` in shares of the scale; -1 where the arm cannot be."""
        centre, _ = self.arm.poses(self.home[None])
        at = np.array([np.cos(bearing), np.sin(bearing), 0]) * distance * self.scale
        at[2] = centre[0, 2] + height * self.scale
        return self.place(at, bearing, tilt, yaw)

    def place(self, at: np.ndarray, bearing: float, tilt: float = 0.0, yaw: float = 0.0) -> int:
        """A point at coordinates [m]."""
        rotation = turned(np.array([0.0, 0, 1]), np.array([bearing + yaw]))[0] @ _DOWN
        if self.arm.n != 4:
            axis = np.array([-np.sin(bearing + 0.7), np.cos(bearing + 0.7), 0])
            rotation = turned(axis, np.array([tilt]))[0] @ rotation
        seed = self.home.copy()
        seed[0] += self.arm.signs[0] * bearing
        q, ok = self.arm.reach(at[None], rotation[None], seed[None], 60)
        if not ok[0] or np.abs(q[0] - seed).max() > 2.6:
            return -1
        self.points.append((at, rotation))
        self.joints.append(q[0])
        return len(self.points) - 1

    def sure(self, make: Callable[[], int]) -> int:
        """A point that the arm reaches: tries again."""
        for _ in range(60):
            k = make()
            if k >= 0:
                return k
        raise RuntimeError("no point is in reach")

    def go(self, kind: int, to: int, speed: float, **more: object) -> None:
        """Adds a line with a motion."""
        self.line += int(self.rng.integers(1, 3))
        self.steps.append(Step(kind, to, speed, line=self.line, **more))  # type: ignore[arg-type]

    def wait(self, pause: float) -> None:
        """Adds a line with a wait."""
        self.line += 1
        self.steps.append(Step(WAIT, pause=pause, line=self.line))


def palletising(cell: Cell, size: int) -> None:
    """Boxes from a pick place to a grid in layers: joint moves between, straight lines up and down; heavy one way."""
    rng = cell.rng
    boxes, up = max(6, size // 6), np.array([0.0, 0.0, cell.scale])
    pick = cell.sure(
        lambda: cell.point(rng.uniform(-1.3, -0.6), rng.uniform(0.8, 1.1), rng.uniform(-0.3, -0.1))
    )
    at, _ = cell.points[pick]
    bearing = float(np.arctan2(at[1], at[0]))
    above = cell.sure(lambda: cell.place(at + rng.uniform(0.2, 0.35) * up, bearing))
    weights = rng.choice([0.15, 0.3, 0.5, 0.7], size=3) * cell.arm.payload
    empty = 0.1 * cell.arm.payload
    lift, carry = rng.uniform(0.25, 0.7, 2) * max(1, cell.scale)
    quick = rng.choice([0.5, 0.75, 1.0])
    straight = rng.random() < 0.35
    corner = float(rng.choice([0, 0.02, 0.04])) * cell.scale
    for i in range(boxes):
        column, row, layer = i % 3, (i // 3) % 3, i // 9
        spot = np.array([0.7 + 0.17 * column, 0.25 + 0.17 * row, 0]) * cell.scale
        spot[2] = at[2] + 0.06 * cell.scale * layer
        over = spot + 0.25 * up
        turn = float(np.arctan2(spot[1], spot[0]))
        to, hover = cell.place(spot, turn), cell.place(over, turn)
        if to < 0 or hover < 0:
            continue
        load = float(rng.choice(weights))
        bulk = 0.02 * load * cell.scale**2
        kind = LINEAR if straight else JOINT
        across = float(rng.choice([carry, 1.4 * carry])) if straight else quick
        cell.go(LINEAR, pick, lift, payload=empty)
        cell.go(LINEAR, above, lift * 0.8, payload=load, inertia=bulk, zone=corner)
        cell.go(kind, hover, across * 0.8, payload=load, inertia=bulk, zone=corner)
        cell.go(LINEAR, to, lift * 0.6, payload=load, inertia=bulk)
        cell.go(LINEAR, hover, lift, payload=empty, zone=corner)
        cell.go(kind, above, across, payload=empty)


def spots(cell: Cell, size: int) -> None:
    """Spot welding: many short joint moves along a flange, a wait for each weld, longer hops between rows."""
    rng = cell.rng
    rows = max(2, size // 30)
    speeds = rng.choice([0.1, 0.2, 0.35, 0.5, 0.8, 1.0], size=3, replace=False)
    weld = float(rng.choice([0.25, 0.4, 0.55]))
    waits = rng.random() < 0.5
    for _ in range(rows):
        base = cell.sure(
            lambda: cell.point(
                rng.uniform(-1, 1), rng.uniform(0.8, 1.1), rng.uniform(-0.2, 0.3), rng.uniform(-0.4, 0.4)
            )
        )
        cell.go(JOINT, base, float(speeds.max()))
        centre, _ = cell.points[base]
        way = rng.normal(size=3) * [1, 1, 0.5]
        way = way / np.linalg.norm(way)
        for k in range(1, 12):
            bearing = float(np.arctan2(centre[1], centre[0]))
            to = cell.place(
                centre + way * 0.04 * cell.scale * k, bearing, rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3)
            )
            if to < 0:
                break
            cell.go(
                JOINT,
                to,
                float(rng.choice(speeds)),
                payload=0.6 * cell.arm.payload,
                inertia=0.01 * cell.arm.payload,
            )
            if waits:
                cell.wait(weld)


def seams(cell: Cell, size: int) -> None:
    """Long seams at low speed with quick air moves, some arcs, a tilted torch."""
    rng = cell.rng
    weld = rng.choice([0.008, 0.015, 0.03, 0.05, 0.08], size=3, replace=False) * 1.5
    air = rng.choice([0.2, 0.35, 0.5, 0.8, 1.2], size=3, replace=False)
    for _ in range(max(5, size // 6)):
        bearing, distance, height = rng.uniform(-0.9, 0.9), rng.uniform(0.75, 1.1), rng.uniform(-0.25, 0.25)
        tilt = rng.uniform(-0.5, 0.5)
        first = cell.sure(
            lambda b=bearing, d=distance, h=height, t=tilt: cell.point(b + rng.normal() * 0.05, d, h, t)
        )
        at, _ = cell.points[first]
        ends = []
        for _k in range(2):
            ends.append(
                cell.sure(
                    lambda a=at, b=bearing, t=tilt: cell.place(
                        a + rng.uniform(-0.25, 0.25, 3) * [1, 1, 0.5] * cell.scale,
                        b,
                        t + rng.normal() * 0.1,
                        rng.normal() * 0.3,
                    )
                )
            )
        cell.go(LINEAR, first, float(rng.choice(air)))
        speed = float(rng.choice(weld)) * (1 if rng.random() < 0.6 else 6)
        if rng.random() < 0.3:
            a, b = cell.points[first][0], cell.points[ends[0]][0]
            via = (a + b) / 2 + np.cross(b - a, [0, 0, 1.0]) * rng.uniform(-0.45, 0.45)
            cell.go(CIRCULAR, ends[0], speed * 2, via=via)
        else:
            cell.go(LINEAR, ends[0], speed, zone=float(rng.choice([0, 0, 0.005])))
        cell.go(LINEAR, ends[1], speed)
        cell.go(LINEAR, first, float(rng.choice(air)), zone=float(rng.choice([0, 0.03])))


def tending(cell: Cell, size: int) -> None:
    """Machine tending: joint moves between stations, straight lines in and out, waits for doors; cycles are alike."""
    rng = cell.rng
    lines = rng.random() < 0.8
    cycles = int(rng.choice([4, 6, 9]))
    stations = max(2, size // cycles // 5)
    quick = rng.choice([0.3, 0.5, 0.7, 1.0], size=2, replace=False)
    slow = rng.uniform(0.08, 0.5, 2)
    body: list[Step] = []
    load = 0.0
    for _ in range(stations):
        bearing = rng.uniform(-1.4, 1.4)
        out = cell.sure(
            lambda b=bearing: cell.point(
                b, rng.uniform(0.75, 0.85), rng.uniform(0, 0.3), rng.uniform(-0.2, 0.2)
            )
        )
        at, _ = cell.points[out]
        into = cell.sure(
            lambda a=at, b=bearing: cell.place(
                a
                + np.array([np.cos(b), np.sin(b), 0]) * rng.uniform(0.15, 0.35) * cell.scale
                + [0, 0, -0.1 * cell.scale * rng.random()],
                b,
                0,
                rng.uniform(-0.4, 0.4),
            )
        )
        cell.go(JOINT, out, float(rng.choice(quick)), payload=load, zone=float(rng.choice([0, 0, 0.05])))
        kind = LINEAR if lines else JOINT
        cell.go(kind, into, float(rng.choice(slow)), payload=load)
        if rng.random() < 0.6:
            cell.wait(float(rng.choice([0.5, 1.0, 2.0])))
        load = float(rng.choice([0, 0.4, 0.8])) * cell.arm.payload
        cell.go(kind, out, float(rng.choice(slow)), payload=load)
    body = cell.steps
    cell.steps = []
    for c in range(cycles):
        cell.steps += [Step(**{**vars(s), "cycle": c + 1}) for s in body]


def deburring(cell: Cell, size: int) -> None:
    """Short straight segments along outlines with rounded corners at several speeds, over and over."""
    rng = cell.rng
    speeds = rng.choice([0.05, 0.1, 0.2, 0.3, 0.45], size=3, replace=False)
    for _ in range(max(4, size // 9)):
        start = cell.sure(
            lambda: cell.point(
                rng.uniform(-0.8, 0.8), rng.uniform(0.8, 1.1), rng.uniform(-0.2, 0.2), rng.uniform(-0.3, 0.3)
            )
        )
        cell.go(LINEAR, start, float(speeds.max() * 2))
        at, _ = cell.points[start]
        speed = float(rng.choice(speeds))
        heading = rng.uniform(0, 6)
        for k in range(8):
            heading += rng.uniform(0.3, 1.2)
            at = (
                at
                + np.array([np.cos(heading), np.sin(heading), rng.normal() * 0.3])
                * rng.uniform(0.03, 0.14)
                * cell.scale
            )
            to = cell.place(
                at, float(np.arctan2(at[1], at[0])), rng.uniform(-0.2, 0.2), rng.uniform(-0.3, 0.3)
            )
            if to < 0:
                break
            zone = 0.0 if k == 7 else float(rng.choice([0, 0.003, 0.008])) * cell.scale
            cell.go(LINEAR, to, speed, zone=zone)


def measuring(cell: Cell, size: int) -> None:
    """Scattered measuring points by straight lines of many lengths and speeds, with turns of the tool."""
    rng = cell.rng
    speeds = rng.choice([0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.5], size=4, replace=False)
    turns = rng.uniform(0, 1.0)
    for _ in range(size):
        to = cell.sure(
            lambda: cell.point(
                rng.uniform(-0.9, 0.9),
                rng.uniform(0.65, 1.15),
                rng.uniform(-0.35, 0.35),
                turns * rng.uniform(-0.6, 0.6),
                turns * rng.uniform(-1, 1),
            )
        )
        cell.go(
            LINEAR,
            to,
            float(rng.choice(speeds)),
            payload=float(rng.choice([0, 0.35, 0.7])) * cell.arm.payload,
        )


def joint_tour(cell: Cell, size: int) -> None:
    """Joint moves of all sizes at several speeds, with loads of several inertias."""
    rng = cell.rng
    speeds = rng.choice([0.1, 0.25, 0.4, 0.6, 0.8, 1.0], size=4, replace=False)
    for _ in range(size):
        to = cell.sure(
            lambda: cell.point(
                rng.uniform(-1.3, 1.3),
                rng.uniform(0.65, 1.15),
                rng.uniform(-0.35, 0.35),
                rng.uniform(-0.5, 0.5),
                rng.uniform(-1.2, 1.2),
            )
        )
        load = float(rng.choice([0, 0.3, 0.6, 0.9])) * cell.arm.payload
        cell.go(
            JOINT,
            to,
            float(rng.choice(speeds)),
            payload=load,
            inertia=load * float(rng.choice([0.002, 0.02, 0.05])),
        )


PROGRAMS = {p.__name__: p for p in (palletising, spots, seams, tending, deburring, measuring, joint_tour)}


def write_program(
    rng: np.random.Generator, arm: Arm, name: str, size: int, acceleration: float, builds: float
) -> Moves:
    """About `size` moves. `acceleration` [m/s^2] of straight moves; `builds`: share of the rated one of joint moves."""
    home, _ = arm.poses(arm.home[None])
    down = turned(np.array([0.0, 0, 1]), np.zeros(1)) @ _DOWN
    seed, ok = arm.reach(home, down, arm.home[None], 80)
    if not ok[0]:
        raise RuntimeError(f"{arm.name} cannot look down at home")
    cell = Cell(rng, arm, seed[0], float(np.hypot(home[0, 0], home[0, 1])))
    PROGRAMS[name](cell, size)
    return _realise(cell, acceleration, builds)


def _realise(cell: Cell, acceleration: float, builds: float) -> Moves:
    """Steps become paths; a straight line that the arm cannot follow becomes a joint move."""
    arm, steps = cell.arm, cell.steps
    m = len(steps)
    at = cell.steps[-1].to if cell.steps[-1].to >= 0 else next(s.to for s in reversed(steps) if s.to >= 0)
    begin, finish = np.zeros(m, int), np.zeros(m, int)
    for i, step in enumerate(steps):
        begin[i] = at
        at = step.to if step.to >= 0 else at
        finish[i] = at
    points = np.array([p for p, _ in cell.points])
    rotations = np.array([r for _, r in cell.points])
    joints = np.array(cell.joints)
    kind = np.array([s.kind for s in steps])
    same = (begin == finish) & (kind != WAIT)
    keep = ~same
    steps = [s for s, k in zip(steps, keep, strict=True) if k]
    kind, begin, finish = kind[keep], begin[keep], finish[keep]
    m = len(steps)
    p0, p1, r0, r1, q0, q1 = (
        points[begin],
        points[finish],
        rotations[begin],
        rotations[finish],
        joints[begin],
        joints[finish],
    )
    via = np.array([s.via if s.via is not None else [np.nan] * 3 for s in steps])
    vector = rotation_vector(r1 @ r0.transpose(0, 2, 1))
    turn = np.linalg.norm(vector, axis=1)
    axis = vector / np.maximum(turn, 1e-12)[:, None]
    q = q0[:, None, :] + np.linspace(0, 1, _STATIONS)[None, :, None] * (q1 - q0)[:, None, :]
    p = np.zeros((m, _STATIONS, 3))
    length = np.zeros(m)
    for i, u in enumerate(np.linspace(0, 1, _STATIONS)):
        p[:, i] = p0 + u * (p1 - p0)
        p[kind == JOINT, i] = arm.poses(q[kind == JOINT, i])[0] if (kind == JOINT).any() else 0
    for k in np.flatnonzero(kind == CIRCULAR):
        p[k], length[k] = _arc(p0[k], via[k], p1[k])
    lines = np.flatnonzero((kind == LINEAR) | (kind == CIRCULAR))
    good = np.ones(len(lines), bool)
    if len(lines):
        now = q0[lines]
        for i, u in enumerate(np.linspace(0, 1, _STATIONS)):
            target = (
                np.array(
                    [turned(a, np.array([u * t]))[0] for a, t in zip(axis[lines], turn[lines], strict=True)]
                )
                @ r0[lines]
            )
            now, ok = arm.reach(p[lines, i], target, now, 12)
            good &= ok
            q[lines, i] = now
        jump = np.abs(np.diff(q[lines], axis=1)).max(axis=(1, 2)) > 0.5
        good &= ~jump & (np.abs(q[lines, -1] - q1[lines]).max(axis=1) < 1e-3)
    for k in lines[~good]:
        kind[k] = JOINT
        q[k] = q0[k] + np.linspace(0, 1, _STATIONS)[:, None] * (q1[k] - q0[k])
        p[k] = arm.poses(q[k])[0]
        via[k] = np.nan
    straight = (kind == LINEAR) | (kind == CIRCULAR)
    length[kind == LINEAR] = np.linalg.norm(p1 - p0, axis=1)[kind == LINEAR]
    short = (kind == LINEAR) & (length < 1e-4)
    moved = np.abs(q1 - q0)
    leading = np.argmax(moved / arm.speeds, axis=1)
    length[kind == JOINT] = moved[np.arange(m), leading][kind == JOINT]
    given = np.array([s.speed for s in steps])
    given[lines[~good]] = 0.4
    ratio = moved / np.maximum(length, 1e-12)[:, None]
    fastest = (arm.speeds / np.maximum(ratio, 1e-9)).min(axis=1)
    strongest = (arm.accelerations / np.maximum(ratio, 1e-9)).min(axis=1)
    speed = np.where(straight, given, given * fastest)
    accel = np.where(straight, acceleration, builds * strongest)
    result = Moves(
        kind,
        q,
        p,
        r0,
        r1,
        via,
        length,
        turn,
        speed,
        accel,
        *(
            np.array([getattr(s, name) for s in steps], float)
            for name in ("zone", "payload", "inertia", "pause")
        ),
        np.where(kind == JOINT, given * 100, np.nan),
        np.ones(m),
        *(np.array([getattr(s, name) for s in steps]) for name in ("cycle", "line")),
    )
    wanted = ~short & ((length > 1e-4) | (kind == WAIT))
    result = Moves(*(x[wanted] for x in vars(result).values()))
    following = np.append(result.kind[1:], WAIT)
    result.zone[following == WAIT] = 0  # no corner is rounded into a wait, or into nothing
    return result


def _arc(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, float]:
    """Stations of the circle through three points, and its length [m]."""
    u, w = b - a, c - a
    normal = np.cross(u, w)
    if np.linalg.norm(normal) < 1e-9:
        return a + np.linspace(0, 1, _STATIONS)[:, None] * (c - a), float(np.linalg.norm(c - a))
    centre = a + np.cross(np.dot(u, u) * w - np.dot(w, w) * u, -normal) / (2 * np.dot(normal, normal))
    normal = normal / np.linalg.norm(normal)
    radius = a - centre
    side = np.cross(normal, radius)
    end = c - centre
    angle = np.arctan2(end @ side, end @ radius) % (2 * np.pi)
    t = np.linspace(0, angle, _STATIONS)
    return centre + np.cos(t)[:, None] * radius + np.sin(t)[:, None] * side, float(
        angle * np.linalg.norm(radius)
    )
