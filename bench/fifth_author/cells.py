"""Programs of realistic cells: welding, palletising, tending, raster strokes, pick and place, a test grid."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .arm import Floats, WristedArm, along, inverse

Rng = np.random.Generator
NODES = (1 - np.cos(np.linspace(0, np.pi, 33))) / 2  # of the path: close together where speed changes


@dataclass(frozen=True)
class ProgramMove:
    """One executed move: poses (mm, rad), joints [rad] at `NODES`, speed [mm/s, or share of rated], corner [mm]."""

    kind: str
    start: Floats
    end: Floats
    q: Floats
    speed: float
    blend: float
    job: str
    line: int
    cycle: int
    payload: float = 0.0
    inertia: float = 0.0
    override: float = 1.0
    wait: float = 0.0

    @property
    def length(self) -> float:
        """Travel of the tool between the end points [mm]."""
        return float(np.linalg.norm(self.end[:3] - self.start[:3]))

    @property
    def slopes(self) -> Floats:
        """Turn of each axis per millimetre of a line, in its cells (cells, 6) [rad/mm]."""
        return np.abs(np.diff(self.q, axis=0)) / (np.diff(NODES) * self.length)[:, None]


class ProgramWriter:
    """Collects moves; speeds in mm/s for lines and as a share for joint moves."""

    def __init__(self, arm: WristedArm, pose: Floats, job: str) -> None:
        """Begin at a pose."""
        self.arm, self.pose, self.job = arm, pose, job
        self.cycle, self.line, self.payload, self.inertia, self.override = 1, 1, 0.0, 0.0, 1.0
        self.moves: list[ProgramMove] = []

    def begin(self, cycle: int, job: str | None = None, override: float = 1.0) -> None:
        """Begin a cycle at the program's first line."""
        self.cycle, self.line, self.job, self.override = cycle, 4, job or self.job, override

    def go(self, kind: str, pose: Floats, speed: float, blend: float = 0.0) -> None:
        """Add one move (samples of its joints come from inverse kinematics of the line)."""
        steps = NODES[:, None]
        q = inverse(self.arm, *along(self.pose, pose, NODES))
        if kind == "joint":
            q = q[0] + steps * (q[-1] - q[0])
        self.line += 1
        load = (self.payload, self.inertia, self.override)
        self.moves.append(
            ProgramMove(kind, self.pose, pose, q, speed, blend, self.job, self.line, self.cycle, *load)
        )
        self.pose = pose

    def hold(self, seconds: float) -> None:
        """Add a programmed wait; the move before it ends in an exact stop."""
        self.line += 1
        if self.moves:
            self.moves[-1] = replace(self.moves[-1], blend=0.0)
        last = self.moves[-1]
        self.moves.append(
            replace(last, kind="wait", start=last.end, q=last.q[-1:], line=self.line, wait=seconds, blend=0.0)
        )


def _pose(x: float, y: float, z: float, rz: float = 0.0, tilt: float = 0.0, lean: float = 0.0) -> Floats:
    return np.array([x, y, z, np.pi - tilt, lean, rz])


def _up(pose: Floats, height: float) -> Floats:
    return pose + np.array([0, 0, height, 0, 0, 0])


def palletise(rng: Rng, arm: WristedArm, size: int) -> list[ProgramMove]:
    """Pick boxes from a conveyor, stack them in layers; loads alternate with empty returns."""
    s = arm.reach / 1400
    pick = _pose(700 * s, -600 * s, -150 * s)
    out = ProgramWriter(arm, _up(pick, 350 * s), "PALLET")
    loads = rng.choice([4.0, 7.5, 12.0, 18.0], rng.integers(1, 4), replace=False)
    fast, slow, zone = (
        float(rng.choice([1000, 1500, 2000])),
        float(rng.choice([150, 300])),
        float(rng.choice([0, 20, 50, 100])),
    )
    joint = bool(rng.random() < 0.5)
    for n in range(size // 7 + 1):
        out.begin(n + 1, override=1.0)
        layer, place = divmod(n % 18, 6)
        drop = _pose(
            (500 + 160 * (place % 3)) * s,
            (350 + 170 * (place // 3)) * s,
            (-300 + 140 * layer) * s,
            np.pi / 2 * (layer % 2),
        )
        out.go("linear", pick, slow)
        out.payload = float(loads[n % len(loads)])
        out.inertia = round(out.payload * 0.012, 3)
        out.go("linear", _up(pick, 350 * s), slow * 2, zone)
        out.go("joint" if joint else "linear", _up(drop, 250 * s), 0.8 if joint else fast, zone)
        out.go("linear", drop, slow)
        out.payload = out.inertia = 0.0
        out.go("linear", _up(drop, 250 * s), slow * 3, zone)
        out.go("joint" if joint else "linear", _up(pick, 350 * s), 1.0 if joint else fast * 1.2, zone)
    return out.moves


def weld(rng: Rng, arm: WristedArm, size: int) -> list[ProgramMove]:
    """Seams on parts: air moves, approaches, slow seams with a tilted torch that turns at the ends."""
    s = arm.reach / 1400
    home = _pose(700 * s, 0, 250 * s)
    out = ProgramWriter(arm, home, "SEAM_A")
    zone, air = float(rng.choice([0, 5, 25])), float(rng.choice([500, 800, 1200]))
    seams = [
        (rng.uniform(500, 950), rng.uniform(-500, 500), rng.uniform(60, 320), rng.uniform(-3, 3))
        for _ in range(rng.integers(5, 12))
    ]
    cycle = 1
    while len(out.moves) < size:
        for n, (x, y, length, way) in enumerate(seams):
            out.begin(cycle, "SEAM_A" if n % 2 else "SEAM_B")
            out.line = 4 + 10 * n
            tilt, turn = (0.5, 0.9) if n % 3 else (-0.4, 0.2)
            a = _pose(x * s, y * s, -250 * s, turn, tilt)
            b = a + np.array(
                [length * s * np.cos(way), length * s * np.sin(way), 0, 0, 0, 0.8 if n % 2 else 0.0]
            )
            out.go("linear", _up(a, 90 * s), air, zone)
            out.go("linear", a, 200)
            out.go("linear", b, float([15, 25, 40, 60][n % 4]))
            out.go("linear", _up(b, 60 * s), 400, zone)
        out.go("linear", home, air)
        cycle += 1
    return out.moves


def tend(rng: Rng, arm: WristedArm, size: int) -> list[ProgramMove]:
    """Load a machine by joint moves and short straight insertions; wait for clamps."""
    s = arm.reach / 1400
    spots = [
        _pose(rng.uniform(550, 900) * s, y * s, rng.uniform(-250, 150) * s, rng.uniform(-1, 1))
        for y in (-650, -300, 100, 450, 700)
    ]
    out = ProgramWriter(arm, _up(spots[0], 180 * s), "TEND")
    pace, cycle, waits = float(rng.choice([0.5, 0.7, 1.0])), 1, bool(rng.random() < 0.6)
    while len(out.moves) < size:
        out.begin(cycle, override=1.0)
        order = list(range(1, 5)) if cycle % 2 else [2, 4, 1, 3]
        for n in [*order, 0]:
            spot = spots[n] + np.array([0, 0, 0, 0, 0, 0.3 * (cycle % 3)])
            out.go("joint", _up(spot, 180 * s), pace * (1.0 if n % 2 else 0.6), 0.0)
            out.go("linear", spot, 120 if n % 2 else 250)
            if waits and n in (2, 3):
                out.hold(0.4 if n == 2 else 1.2)
            out.payload, out.inertia = (0.0, 0.0) if n in (0, 3) else (3.0 + 2 * n, 0.02 * (3.0 + n * n))
            out.go("linear", _up(spot, 180 * s), 400)
        cycle += 1
    return out.moves


def raster(rng: Rng, arm: WristedArm, size: int) -> list[ProgramMove]:
    """Painting strokes: long parallel lines at constant speed, short side steps, rounded or exact ends."""
    s = arm.reach / 1400
    x0, width, pitch = 650 * s, float(rng.uniform(500, 900)) * s, float(rng.uniform(20, 60)) * s
    upright = bool(rng.random() < 0.4)
    zone = float(rng.choice([0, 10, 15]))
    out = ProgramWriter(arm, _pose(x0, -width / 2, -200 * s), "COAT")
    cycle = 1
    while len(out.moves) < size:
        speed = float(rng.choice([200, 350, 500, 800]))
        out.begin(cycle)
        for n in range(int(rng.integers(6, 11))):
            end = (width / 2 if n % 2 == 0 else -width / 2) * (1 - 0.05 * (n % 4))
            here = (x0, -200 * s + n * pitch) if upright else (x0 + n * pitch, -200 * s)
            out.go("linear", _pose(here[0], end, here[1], 0.15 * np.sign(end)), speed, zone)
            step = (x0, here[1] + pitch) if upright else (here[0] + pitch, here[1])
            out.go("linear", _pose(step[0], end, step[1], 0.15 * np.sign(end)), speed / 2, zone)
        out.go("linear", _pose(x0, -width / 2, -200 * s + (cycle % 3) * 90 * s), 1000)
        cycle += 1
    return out.moves


def sort_parts(rng: Rng, arm: WristedArm, size: int) -> list[ProgramMove]:
    """Pick from random places of a belt, put into bins; joint moves alone, at several shares of speed."""
    s = arm.reach / 1400
    bins = [
        _pose(x * s, y * s, -100 * s, y / 500) for x, y in ((350, 650), (600, 550), (450, -650), (700, -450))
    ]
    out = ProgramWriter(arm, _up(bins[0], 120 * s), "SORT")
    for cycle in range(1, size // 4 + 2):
        out.begin(cycle)
        part = _pose(
            rng.uniform(550, 1000) * s,
            rng.uniform(-300, 300) * s,
            -220 * s,
            rng.uniform(-1.5, 1.5),
            0,
            rng.uniform(-0.3, 0.3),
        )
        pace = float(rng.choice([0.3, 0.6, 1.0]))
        out.go("joint", _up(part, 120 * s), pace)
        out.go("joint", part, 0.3)
        out.payload = float(rng.choice([0.5, 2.0, 6.0]))
        out.inertia = round(out.payload * 0.02, 3)
        out.go("joint", _up(bins[cycle % 4], 120 * s), pace)
        out.go("joint", _up(bins[cycle % 4], 10 * s), 0.3)
        out.payload = out.inertia = 0.0
    return out.moves


def test_grid(rng: Rng, arm: WristedArm, size: int) -> list[ProgramMove]:
    """A commissioning test: lines of many lengths, inclines and speeds from a few stations and back."""
    s = arm.reach / 1400
    home = _pose(650 * s, 0, -50 * s)
    out = ProgramWriter(arm, home, "TEST")
    stations = [_pose(650 * s, y * s, z * s) for y, z in ((0, -50), (-350, 100), (350, -200))]
    while len(out.moves) < size:
        station = stations[len(out.moves) // 14 % 3]
        out.begin(1, f"TEST{len(out.moves) // 14 % 3}")
        out.go("linear", station, 500)
        for _ in range(6):
            ray = rng.normal(size=3) * (0.8, 1.0, 0.9)
            ray *= rng.uniform(40, 420) * s / np.linalg.norm(ray)
            speed = float(rng.choice([100, 250, 500, 1000, 1500]))
            out.payload = float(rng.choice([0.0, 5.0, 10.0]))
            out.inertia = round(out.payload * float(rng.choice([0.01, 0.04])), 3)
            target = station + np.array([*ray, 0, 0, float(rng.choice([0, 0, 1.2]))])
            if not np.isfinite(inverse(arm, *along(station, target, NODES))).all():
                continue
            out.go("linear", target, speed)
            out.go("linear", station, speed)
    return out.moves


CELLS: dict[str, Callable[[Rng, WristedArm, int], list[ProgramMove]]] = {
    "palletise": palletise,
    "weld": weld,
    "tend": tend,
    "raster": raster,
    "sort": sort_parts,
    "test": test_grid,
}


def make_program(rng: Rng, arm: WristedArm, cell: str, size: int) -> list[ProgramMove]:
    """A program of about `size` moves, all in reach; a third of them run under two overrides."""
    for _ in range(50):
        moves = [
            m for m in CELLS[cell](rng, arm, size)[: max(size, 30)] if m.kind == "wait" or m.length > 0.5
        ]
        if all(np.isfinite(m.q).all() for m in moves):
            return [*moves[:-1], replace(moves[-1], blend=0.0)]
    raise RuntimeError(f"{cell}: out of reach")
