"""Work of this author's arms: palletising, handling, seams, tending of machines, probing."""

from dataclasses import dataclass, field

import numpy as np

from bench.third_author.arms import Arm, turn

DOWN = turn("y", np.pi)
SAMPLES = 61  # along each path, closer to each other at its ends
GRID = (1 - np.cos(np.pi * np.linspace(0, 1, SAMPLES))) / 2


@dataclass
class Step:
    """One executed move or wait: a row of the recording before it has a time."""

    kind: str
    position: np.ndarray  # of its end [m]
    rotation: np.ndarray
    via: np.ndarray | None = None
    speed: float = 0.0  # [m/s], of joint moves a share of the rated speed
    acceleration: float = 0.0  # [m/s^2], of joint moves a share of the rated acceleration
    blend: float = 0.0  # [m]
    load: float = 0.0  # [kg]
    spin: float = 0.0  # moment of inertia of the load [kg m^2]
    station: str = ""
    dwell: float = 0.0  # of a wait [s]


@dataclass
class Script:
    """Collects the steps of one cycle; what the hand carries stays until it is changed."""

    base_speed: float
    base_acceleration: float
    quick: float = 1.0  # share of the speeds in this job
    load: float = 0.0
    spin: float = 0.0
    steps: list[Step] = field(default_factory=list)

    def line(self, position, rotation=DOWN, *, share=1.0, blend=0.0, station="", via=None) -> None:
        kind = "linear" if via is None else "circular"
        speed = self.base_speed * self.quick * share
        self._add(kind, position, rotation, via, speed, self.base_acceleration, blend, station)

    def swing(self, position, rotation=DOWN, *, share=1.0, blend=0.0, station="") -> None:
        self._add("joint", position, rotation, None, min(1.0, self.quick * share), 1.0, blend, station)

    def wait(self, seconds: float) -> None:
        last = self.steps[-1]
        self.steps.append(Step("wait", last.position, last.rotation, load=self.load, dwell=seconds))

    def _add(self, kind, position, rotation, via, speed, acceleration, blend, station) -> None:
        self.steps.append(
            Step(kind, position, rotation, via, speed, acceleration, blend, self.load, self.spin, station)
        )


@dataclass
class Moves:
    """All steps of a recording as arrays: ends, paths of the axes, programmed numbers."""

    arm: Arm
    steps: list[Step]
    q: np.ndarray  # (n, SAMPLES, axes) [rad]
    points: np.ndarray  # (n, SAMPLES, 3) [m]
    rotations: np.ndarray  # (n, 2, 3, 3)
    length: np.ndarray  # [m], of joint moves 0
    turned: np.ndarray  # [rad]
    jobs: np.ndarray
    lines: np.ndarray
    cycles: np.ndarray

    def __len__(self) -> int:
        return len(self.steps)

    def column(self, name: str) -> np.ndarray:
        return np.array([getattr(step, name) for step in self.steps])


def point(rng, arm: Arm, angle: float, near=0.5, far=0.82, low=-0.35, high=0.15) -> np.ndarray:
    """A place for the tool at an angle about the column that the arm reaches with the tool downwards."""
    span = arm.upper + arm.fore
    radius = arm.shoulder[0] + span * rng.uniform(near, far)
    height = arm.shoulder[1] + span * rng.uniform(low, high) - arm.hand
    return np.array([radius * np.cos(angle), radius * np.sin(angle), height])


def _up(position, by: float) -> np.ndarray:
    return position + np.array([0, 0, by])


def palletising(rng, arm: Arm, script: Script, cycle: int) -> None:
    """Boxes from a conveyor onto a pallet of rows and layers."""
    if cycle == 0:
        span = arm.upper + arm.fore
        script.pick = point(rng, arm, rng.uniform(-1.6, -0.9), 0.6, 0.7, -0.25, -0.1)
        script.corner = point(rng, arm, 0.3, 0.5, 0.55, -0.4, -0.35)
        script.box = span * rng.uniform(0.07, 0.1, 3)
        script.kinds = rng.uniform(0.02, 0.12, 3) * arm.masses[0]
        script.linear = rng.random() < 0.4
        script.heights = span * rng.uniform(0.05, 0.2, 3)
    place = script.corner + script.box * np.array([cycle % 3, cycle // 3 % 3, cycle // 9])
    mass = script.kinds[cycle % 4 % 3]
    script.clear = script.heights[cycle % 3]
    move = script.line if script.linear else script.swing
    yaw = turn("z", np.pi / 2 * (cycle % 2)) @ DOWN
    move(_up(script.pick, script.clear), blend=0.02, station="conveyor")
    script.line(script.pick, share=0.3, station="conveyor")
    script.load, script.spin = mass, mass * float(np.sum(script.box[:2] ** 2)) / 12
    script.line(_up(script.pick, script.clear), share=0.6, blend=0.03, station="conveyor")
    move(_up(place, script.clear), yaw, blend=0.02, station="pallet")
    script.line(place, yaw, share=0.25, station="pallet")
    script.load = script.spin = 0.0
    script.line(_up(place, script.clear), yaw, share=0.8, blend=0.03, station="pallet")


def handling(rng, arm: Arm, script: Script, cycle: int) -> None:
    """Parts of some masses from trays into fixtures, all in straight lines."""
    if cycle == 0:
        script.places = [point(rng, arm, angle) for angle in np.linspace(-0.9, 1.0, 5)]
        script.kinds = rng.uniform(0.1, 0.5, 4) * arm.masses[2]
        script.clear = (arm.upper + arm.fore) * rng.uniform(0.08, 0.15)
    take, put = rng.choice(5, 2, replace=False)
    for station, at in (("tray", take), ("fixture", put)):
        spot = script.places[at] + rng.normal(0, 0.03, 3) * (arm.upper + arm.fore)
        rotation = turn("z", rng.uniform(-1, 1)) @ DOWN
        above = _up(spot, script.clear)
        script.line(above, rotation, blend=rng.choice([0.0, 0.01, 0.03]), station=f"{station}{at}")
        script.line(spot, rotation, share=0.4, station=f"{station}{at}")
        mass = float(script.kinds[rng.integers(4)]) if station == "tray" else 0.0
        script.load, script.spin = mass, mass * 0.02 * arm.upper
        script.line(above, rotation, share=0.7, blend=rng.choice([0.0, 0.02]), station=f"{station}{at}")


def seams(rng, arm: Arm, script: Script, cycle: int) -> None:
    """A torch along short lines and arcs, with quick ways between the seams."""
    start = point(rng, arm, rng.uniform(-0.8, 0.8), 0.5, 0.75, -0.3, -0.05)
    tilt = turn("z", rng.uniform(-0.6, 0.6)) @ turn("y", rng.uniform(-0.35, 0.35)) @ DOWN
    clear = (arm.upper + arm.fore) * 0.08
    (script.swing if rng.random() < 0.5 else script.line)(_up(start, clear), tilt, blend=0.01, station="air")
    script.line(start, tilt, share=0.3, station="seam")
    heading, at = rng.uniform(-np.pi, np.pi), start
    for part in range(rng.integers(3, 6)):
        heading += rng.uniform(-0.9, 0.9)
        size = rng.uniform(0.015, 0.06) * (1 if arm.upper < 0.5 else 2.5)
        along = size * np.array([np.cos(heading), np.sin(heading), 0])
        side = 0.25 * size * np.array([-np.sin(heading), np.cos(heading), 0])
        tilt = turn("z", rng.uniform(-0.3, 0.3)) @ tilt
        last = part >= 3
        share = rng.uniform(0.05, 0.25)
        script.line(
            at + along,
            tilt,
            share=share,
            blend=0.0 if last else rng.choice([0.0, 0.003]),
            station="seam",
            via=at + along / 2 + side if rng.random() < 0.35 else None,
        )
        at = at + along
    script.line(_up(at, clear), tilt, share=0.6, blend=0.01, station="air")


def tending(rng, arm: Arm, script: Script, cycle: int) -> None:
    """Machines loaded and unloaded with joint moves alone."""
    if cycle == 0:
        script.places = [point(rng, arm, angle, 0.4, 0.85) for angle in rng.uniform(-2.4, 2.4, 7)]
        script.turns = [
            turn("z", rng.uniform(-1.5, 1.5)) @ turn("y", rng.uniform(-0.5, 0.5) * (arm.axes == 6)) @ DOWN
            for _ in range(7)
        ]
        script.kinds = rng.uniform(0.1, 0.8, 3) * arm.masses[2]
    for at in rng.permutation(7)[:5]:
        script.swing(
            script.places[at] + rng.normal(0, 0.01, 3),
            script.turns[at],
            share=rng.choice([0.3, 0.6, 1.0]),
            blend=rng.choice([0.0, 0.0, 0.03]),
            station=f"machine{at}",
        )
        mass = float(rng.choice([0.0, *script.kinds]))
        script.load, script.spin = mass, mass * rng.uniform(0.01, 0.05) * arm.upper


def probing(rng, arm: Arm, script: Script, cycle: int) -> None:
    """Touching points here and there: random lines of all lengths."""
    for _ in range(5):
        rotation = (
            turn("z", rng.uniform(-1.2, 1.2)) @ turn("y", rng.uniform(-0.4, 0.4) * (arm.axes == 6)) @ DOWN
        )
        script.line(
            point(rng, arm, rng.uniform(-1.0, 1.0), 0.45, 0.8),
            rotation,
            share=rng.choice([0.1, 0.25, 0.5, 1.0]),
            blend=rng.choice([0.0, 0.0, 0.015]),
            station="probe",
        )
    script.load = float(rng.choice([0.0, 0.3, 0.6])) * arm.masses[2]


CELLS = {
    "palletising": palletising,
    "handling": handling,
    "seams": seams,
    "tending": tending,
    "probing": probing,
}


def make_moves(rng, arm: Arm, cell: str, count: int) -> Moves:
    """A recording's moves: cycles of one cell, in jobs of other speeds; raises ValueError where a path cannot be."""
    quick = arm.upper < 0.5
    script = Script(rng.uniform(0.6, 1.2) if quick else rng.uniform(0.9, 1.8), rng.uniform(2.0, 6.0))
    paces = rng.choice([1.0, 0.75, 0.5, 0.3, 0.15], 3, replace=False)
    timers = rng.random() < 0.5
    labels: list[tuple[str, int, int]] = []
    cycle = 0
    while len(script.steps) < count:
        job = cycle % 3
        script.quick = paces[job]
        before = len(script.steps)
        CELLS[cell](rng, arm, script, cycle)
        if timers:
            script.wait(float(rng.choice([0.2, 0.5, 0.8])))
        labels += [(f"JOB{job + 1}", i + 4, cycle // 3) for i in range(len(script.steps) - before)]
        cycle += 1
    jobs, lines, cycles = (np.array(part) for part in zip(*labels, strict=True))
    home = Step("joint", point(rng, arm, 0.0, 0.6, 0.65), DOWN)
    return _sampled(arm, [home, *script.steps], jobs, lines, cycles)


def _sampled(arm: Arm, steps: list[Step], jobs, lines, cycles) -> Moves:
    positions = np.array([s.position for s in steps])
    rotations = np.array([s.rotation for s in steps])
    ends = arm.joints(positions, rotations)
    moved = steps[1:]
    joint = np.array([s.kind == "joint" for s in moved])
    first, last = positions[:-1], positions[1:]
    points = first[:, None] + (last - first)[:, None] * GRID[:, None]
    for i, step in enumerate(moved):
        if step.via is not None:
            points[i] = _arc(first[i], step.via, last[i])
    relative = np.swapaxes(rotations[:-1], -1, -2) @ rotations[1:]
    axis, turned = _axis_angle(relative)
    paths = np.empty((len(moved), SAMPLES, arm.axes))
    here = ends[0]
    for i in range(len(moved)):
        if joint[i]:
            paths[i] = here + (ends[i + 1] - here) * GRID[:, None]
        else:
            turns = rotations[i] @ _rodrigues(axis[i], turned[i] * GRID)
            paths[i] = _followed(arm.joints(points[i], turns), here)
        here = paths[i, -1]
    if np.isnan(paths).any() or np.abs(np.diff(paths, axis=1)).max() > 0.6:
        raise ValueError("a path that this arm cannot follow")
    length = np.linalg.norm(np.diff(points, axis=1), axis=-1).sum(1) * ~joint
    pairs = np.stack([rotations[:-1], rotations[1:]], 1)
    return Moves(arm, moved, paths, points, pairs, length, turned, jobs, lines, cycles)


def _followed(q: np.ndarray, here: np.ndarray) -> np.ndarray:
    """The same poses without a jump from where the arm is: its wrist flips, its axes turn on."""
    q = np.vstack([here, q])
    if q.shape[1] == 6:
        fourth = np.unwrap(q[:, 3], period=np.pi)
        flipped = np.round((fourth - q[:, 3]) / np.pi) % 2 == 1
        q = np.column_stack(
            [q[:, :3], fourth, np.where(flipped, -q[:, 4], q[:, 4]), q[:, 5] + np.pi * flipped]
        )
    return np.unwrap(q, axis=0)[1:]


def _arc(a, b, c) -> np.ndarray:
    """Points of the circle through three points from the first to the last."""
    u, v = b - a, c - a
    normal = np.cross(u, v)
    centre = a + (np.cross(normal, u) * (v @ v) + np.cross(v, normal) * (u @ u)) / (2 * normal @ normal)
    x = (a - centre) / np.linalg.norm(a - centre)
    y = np.cross(normal / np.linalg.norm(normal), x)
    whole = np.arctan2((c - centre) @ y, (c - centre) @ x) % (2 * np.pi)
    angle = GRID[:, None] * whole
    return centre + np.linalg.norm(a - centre) * (np.cos(angle) * x + np.sin(angle) * y)


def _axis_angle(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    angle = np.arccos(np.clip((np.trace(matrix, axis1=-2, axis2=-1) - 1) / 2, -1, 1))
    axis = np.stack(
        [
            matrix[..., 2, 1] - matrix[..., 1, 2],
            matrix[..., 0, 2] - matrix[..., 2, 0],
            matrix[..., 1, 0] - matrix[..., 0, 1],
        ],
        -1,
    )
    size = np.linalg.norm(axis, axis=-1, keepdims=True)
    return np.where(size > 1e-9, axis / np.maximum(size, 1e-9), [0, 0, 1.0]), np.where(
        size[..., 0] > 1e-9, angle, 0.0
    )


def _rodrigues(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return (
        np.eye(3) + np.sin(angle)[:, None, None] * cross + (1 - np.cos(angle))[:, None, None] * cross @ cross
    )
