"""Programs of this author: picking, pallets, seams, machine tending, probing, beads, fans and joint tests."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

Rng = np.random.Generator
Angles = Sequence[float] | np.ndarray
DOWN = (180.0, 0.0, 0.0)  # the tool looks down: rx, ry, rz [deg]


def _open() -> np.ndarray:
    """A vector that is not known yet."""
    return np.empty(0)


@dataclass
class Move:
    """A move. What a program leaves open (joints of a line, points of a joint move) is filled in as its way is laid."""

    kind: str  # "linear", "circular" or "joint"
    speed: float  # [mm/s], nan in programs of joint moves alone
    blend: float  # radius of the corner at the end [mm], 0: exact stop
    payload: float  # [kg]
    inertia: float  # of the load [kg m^2]
    job: str
    line: int  # in the job, from 0
    cycle: int
    start: np.ndarray = field(default_factory=_open)  # (3,) [mm]
    end: np.ndarray = field(default_factory=_open)
    turn_start: np.ndarray = field(default_factory=_open)  # (3,) rx, ry, rz [deg]
    turn_end: np.ndarray = field(default_factory=_open)
    via: np.ndarray | None = None  # (3,) middle point of a circular move [mm]
    joints_start: np.ndarray = field(default_factory=_open)  # (6,) [rad], of the way that was laid last
    joints_end: np.ndarray = field(default_factory=_open)
    percent: float | None = None  # of the rated speed, in joint programs
    turned: float = 0.0  # by which the tool turns [rad]


@dataclass
class Program:
    """A program that is being written: where the tool is, what it carries, and the moves so far."""

    moves: list[Move] = field(default_factory=list)
    at: np.ndarray = field(default_factory=_open)  # (3,) [mm]
    turn: np.ndarray = field(default_factory=lambda: np.array(DOWN))  # (3,) [deg]
    payload: float = 0.0  # [kg]
    inertia: float = 0.0  # [kg m^2]
    job: str = "MAIN"
    line: int = 1
    cycle: int = 1

    def begin(self, at: Sequence[float] | np.ndarray) -> None:
        """Puts the tool at a point [mm]."""
        self.at = np.array(at, float)

    def go(
        self,
        to: Sequence[float] | np.ndarray,
        speed: float,
        kind: str = "linear",
        turn: Angles | None = None,
        blend: float = 0.0,
        via: np.ndarray | None = None,
    ) -> None:
        """A move to a point [mm] at a speed [mm/s]; none where the tool is there already."""
        point = np.array(to, float)
        angles = self.turn.copy() if turn is None else np.array(turn, float)
        if np.linalg.norm(point - self.at) < 1 and np.allclose(angles, self.turn):
            return
        self.moves.append(
            Move(
                kind, float(speed), float(blend), self.payload, self.inertia, self.job, self.line, self.cycle,
                self.at, point, self.turn, angles, via,
            )
        )  # fmt: skip
        self.at, self.turn = point, angles
        self.line += 1


def _place(
    rng: Rng, near: float = 750, far: float = 1250, low: float = 200, high: float = 900, side: float = 60
) -> np.ndarray:
    """A point (3,) [mm] in a sector of a ring around the arm; `side` in degrees."""
    reach, angle = rng.uniform(near, far), math.radians(rng.uniform(-side, side))
    return np.array([reach * math.cos(angle), reach * math.sin(angle), rng.uniform(low, high)])


def _by(x: float, y: float, z: float) -> np.ndarray:
    """A step (3,) [mm]."""
    return np.array([x, y, z], float)


def _direction(rng: Rng) -> np.ndarray:
    """A random unit vector."""
    way = rng.normal(size=3)
    return np.asarray(way / np.linalg.norm(way))


def _kind(by_joints: bool) -> str:
    return "joint" if by_joints else "linear"


def _pick(rng: Rng, size: int, by_joints: bool, turning: bool) -> list[Move]:
    """Parts of several masses from some places to others."""
    p, cycle = Program(), 0
    p.begin(_place(rng, low=600, high=800))
    picks = [_place(rng, low=200, high=500) for _ in range(rng.integers(2, 6))]
    places = [_place(rng, low=200, high=700) for _ in range(rng.integers(2, 6))]
    masses = list(rng.choice([1.5, 3, 4.5, 6, 8, 12, 18], rng.integers(2, 5), replace=False))
    speeds = sorted(rng.choice([200, 300, 400, 500, 600, 800, 1000, 1200, 1500], 3, replace=False))
    kind = _kind(by_joints)
    while len(p.moves) < size:
        cycle += 1
        p.cycle, p.line, p.job = cycle, 5, "PICK"
        which = rng.integers(len(picks))
        a, b = picks[which], places[rng.integers(len(places))]
        up = _by(0, 0, rng.uniform(80, 250))
        turn = np.array([180.0, 0, rng.uniform(-120, 120) if turning else 0])
        p.go(a + up, speeds[-1], kind, DOWN)
        p.go(a, speeds[0], turn=DOWN)
        p.payload = float(masses[which % len(masses)])
        p.go(a + up, speeds[1], turn=DOWN)
        p.job, p.line = "PLACE", 20
        p.go(b + up, speeds[rng.integers(1, 3)], kind, turn)
        p.go(b, speeds[0], turn=turn)
        p.payload = 0.0
        p.go(b + up, speeds[-1], turn=turn)
    return p.moves[:size]


def _pallet(rng: Rng, size: int, by_joints: bool, turning: bool) -> list[Move]:
    """Boxes onto a pallet in layers of three by three."""
    p = Program()
    a = _place(rng, 750, 1000, 300, 500, 40)
    p.begin(a + _by(0, 0, 250))
    origin = _place(rng, 800, 900, 150, 250, 20) * [1, 0, 1] + _by(0, -350, 0)
    mass = float(rng.choice([4, 8, 12, 20]))
    speeds = sorted(rng.choice([300, 500, 700, 900, 1200, 1600], 3, replace=False))
    pitch = rng.uniform(110, 180), rng.uniform(120, 200), rng.uniform(80, 150)
    kind, box = _kind(by_joints), 0
    while len(p.moves) < size:
        layer, row, column = box // 9, (box % 9) // 3, box % 3
        b = origin + _by(row * pitch[0], column * pitch[1], (layer % 4) * pitch[2])
        turn = [180, 0, 90.0 * ((box + layer) % 2) if turning else 0]
        p.cycle, p.line, p.job = box + 1, 8, f"PAL{layer % 4 + 1}"
        top = max(a[2], b[2]) + 180
        p.go([a[0], a[1], a[2] + 120], speeds[2], kind, DOWN)
        p.go(a, speeds[0], turn=DOWN)
        p.payload = mass * (1 + (layer % 3) * 0.5)
        p.go([a[0], a[1], top], speeds[1], turn=DOWN)
        p.go([b[0], b[1], top], speeds[2 if rng.random() < 0.5 else 1], kind, turn)
        p.go(b, speeds[0], turn=turn)
        p.payload = 0.0
        p.go([b[0], b[1], top], speeds[2], turn=turn)
        box += 1
    return p.moves[:size]


def _weld(rng: Rng, size: int, by_joints: bool, turning: bool) -> list[Move]:
    """Slow seams of a few pieces with rounded corners, and quick ways between them."""
    p = Program()
    p.begin(_place(rng, low=500, high=700))
    p.payload = float(rng.choice([0, 3]))
    slow = sorted(rng.choice([8, 12, 18, 25, 40, 60, 90], 3, replace=False))
    quick = rng.choice([300, 500, 800, 1200], 2, replace=False)
    seam = 0
    while len(p.moves) < size:
        seam += 1
        p.job, p.line, p.cycle = f"SEAM{seam % 4 + 1}", 3, (seam - 1) // 4 + 1
        a = _place(rng, low=300, high=500)
        way = rng.normal(size=3) * [1, 1, 0.3]
        way /= np.linalg.norm(way)
        turn = [180 + (rng.uniform(-30, 30) if turning else 0), 0, rng.uniform(-60, 60) if turning else 0]
        round_it = 0 if by_joints else float(rng.choice([0, 20, 40]))
        p.go(a + _by(0, 0, 150), quick[0], _kind(by_joints), turn, blend=round_it)
        p.go(a, quick[1], turn=turn)
        speed = slow[rng.integers(3)]
        for _ in range(rng.integers(2, 5)):
            piece = way + rng.normal(size=3) * [0.5, 0.5, 0.1]
            piece /= np.linalg.norm(piece)
            to = p.at + piece * rng.uniform(15, 90)
            p.go(to, speed * rng.choice([1, 2, 5]), turn=turn, blend=float(rng.choice([0, 3, 5, 8])))
        p.moves[-1].blend = 0.0
        p.go(p.at + _by(0, 0, 150), quick[1], turn=turn)
    return _ended(p, size)


def _ended(p: Program, size: int) -> list[Move]:
    """So many moves, of which the last one stops."""
    moves = p.moves[:size]
    moves[-1].blend = 0.0
    return moves


def _tend(rng: Rng, size: int, by_joints: bool, turning: bool) -> list[Move]:
    """Parts from a bin into a machine, and out of it."""
    p = Program()
    home = _place(rng, 750, 900, 600, 800, 10)
    p.begin(home)
    stock = _place(rng, 800, 1100, 250, 450, 60)
    door = _place(rng, 800, 900, 500, 700, 60)
    chuck = door + _by(rng.uniform(150, 250), rng.uniform(-80, 80), -60)
    out = _place(rng, 800, 1100, 250, 500, 60)
    kind, cycle = _kind(by_joints), 0
    while len(p.moves) < size:
        cycle += 1
        p.cycle, p.line, p.job = cycle, 4, "TEND"
        speed = rng.choice([600, 800, 1000, 1300])
        off = rng.uniform(-50, 50, 2)
        a = stock + _by(off[0], off[1], 0)
        turn = [180, 25 if turning else 0, 60 if turning else 0]
        p.go(a + _by(0, 0, 150), speed, kind, DOWN)
        p.go(a, 150, turn=DOWN)
        p.payload = (2.0, 5.0, 9.0, 14.0)[cycle % 4]
        p.inertia = 0.02 * p.payload
        p.go(a + _by(0, 0, 150), 400, turn=DOWN)
        p.go(door, speed, kind, turn)
        p.line, p.job = 30, "MACHINE"
        p.go(chuck, 250, turn=turn)
        p.payload, p.inertia = 0.0, 0.0
        p.go(door, 500, turn=turn)
        p.job, p.line = "TEND", 50
        p.go(out + _by(off[1], off[0], 150), speed, kind, DOWN)
        p.go(out + _by(off[1], off[0], 0), 150, turn=DOWN)
        p.go(home, speed, kind, DOWN)
    return p.moves[:size]


def _inspect(rng: Rng, size: int, by_joints: bool, turning: bool) -> list[Move]:
    """Short slow touches from all sides of a part."""
    p = Program()
    p.begin(_place(rng, low=500, high=600))
    centre = _place(rng, 850, 1050, 350, 500, 30)
    slow = rng.choice([5, 10, 15, 25, 40, 60], 3, replace=False)
    quick = rng.choice([150, 250, 400, 700], 2, replace=False)
    while len(p.moves) < size:
        way = _direction(rng)
        a = centre + way * rng.uniform(90, 250)
        turn = [rng.uniform(-most, most) if turning else 0 for most in (35, 25, 90)]
        turn[0] = 180 + turn[0]
        p.job = f"PROBE{rng.integers(1, 4)}"
        speed = quick[rng.integers(2)]
        p.go(a, speed, _kind(by_joints and rng.random() < 0.5), turn)
        touch = a - way * rng.uniform(4, 25)
        p.go(touch, slow[rng.integers(3)], turn=turn)
        p.go(a, slow[rng.integers(3)] * 4, turn=turn)
        p.line = p.line % 40
    return p.moves[:size]


def _glue(rng: Rng, size: int, by_joints: bool, turning: bool) -> list[Move]:
    """Beads around rectangles with rounded corners, some with a zigzag or an arc."""
    p = Program()
    p.begin(_place(rng, low=400, high=500))
    speeds = rng.choice([50, 80, 120, 200, 300, 450], 4, replace=False)
    bead = 0
    while len(p.moves) < size:
        bead += 1
        p.job, p.line, p.cycle = f"BEAD{bead % 3 + 1}", 2, (bead + 2) // 3
        corner = _place(rng, 850, 1000, 300, 400, 25)
        sides = rng.uniform(60, 260), rng.uniform(50, 200)
        radius = float(rng.choice([3, 5, 8, 12, 20]))
        _bead(p, rng, corner, sides, radius, speeds[rng.integers(4)], turning)
    return _ended(p, size)


def _bead(
    p: Program,
    rng: Rng,
    corner: np.ndarray,
    sides: tuple[float, float],
    radius: float,
    speed: float,
    turning: bool,
) -> None:
    """One bead; lengths in mm, speed in mm/s."""
    wide, deep = sides
    points = [corner + _by(x, y, 0) for x, y in ((0, 0), (wide, 0), (wide, deep), (0, deep))]
    turn: Angles = DOWN
    p.go(points[0] + _by(0, 0, 60), 600, turn=turn)
    p.go(points[0], 150, turn=turn)
    zigzag = rng.integers(0, 2)
    for i in (1, 2, 3, 0):
        turn = [180, 0, (i * 90 % 360 if i < 3 else -90) * 0.5] if turning else turn
        if zigzag and i == 2:
            for _ in range(2):
                to = p.at + (points[2] - points[1]) * 0.3 + _by(rng.uniform(-15, 15), 0, 0)
                p.go(to, speed, turn=turn, blend=radius)
        if i == 0 and rng.random() < 0.4:
            p.moves[-1].blend = 0.0
            middle = (points[3] + points[0]) / 2 + _by(-deep * 0.35, 0, 0)
            p.go(points[0], speed, "circular", turn, via=middle)
        else:
            p.go(points[i], speed, turn=turn, blend=radius if i and rng.random() < 0.75 else 0.0)
    p.go(points[0] + _by(0, 0, 60), 300, turn=turn)


def _sweep(rng: Rng, size: int, by_joints: bool, turning: bool) -> list[Move]:
    """Fans of lines from a point and back, of many lengths, speeds and directions."""
    p = Program()
    speeds = rng.choice([50, 100, 200, 300, 400, 600, 800, 1000, 1400], rng.integers(3, 7), replace=False)
    masses = rng.choice([0.0, 5, 10, 15, 20], rng.integers(2, 4), replace=False)
    loaded = rng.random() < 0.35
    centre, there = np.zeros(3), 0
    while len(p.moves) < size:
        if there % 24 == 0:
            centre = _place(rng, 850, 1150, 400, 700, 45)
            if not p.at.size:
                p.begin(centre)
            p.job, p.line = f"FAN{there // 24 + 1}", 1
            p.go(centre, 300, turn=DOWN)
            if loaded:
                p.payload = float(masses[(there // 24) % len(masses)])
        way = _direction(rng)
        if rng.random() < 0.25:
            way = _by(0, 0, rng.choice([-1.0, 1.0]))
        length = float(rng.choice([10, 20, 40, 80, 150, 250, 350]))
        turn: Angles = DOWN
        if turning and rng.random() < 0.7:
            turn = [180 + rng.uniform(-30, 30), rng.uniform(-30, 30), rng.uniform(-100, 100)]
        speed = speeds[rng.integers(len(speeds))]
        kind = _kind(by_joints and rng.random() < 0.5)
        p.go(centre + way * length, speed, kind, turn)
        p.go(centre, speed, kind, DOWN)
        there += 1
    return p.moves[:size]


def _joint_test(rng: Rng, size: int, by_joints: bool, turning: bool) -> list[Move]:
    """Axes alone and together from one posture and back, with four loads."""
    _place(rng)
    moves: list[Move] = []
    posture = np.radians([0, 55, -75, 10, 70, 0.0])
    loads = [(0.0, 0.0), (3.0, 0.05), (6.0, 0.15), (8.0, 0.35)]  # [kg], [kg m^2]
    percents = rng.choice([10, 20, 30, 50, 65, 80, 100, 100], 5, replace=False)
    load, job, line, there = loads[0], "MAIN", 1, 0
    while len(moves) < size:
        if there % 16 == 0:
            load, job, line = loads[(there // 16) % 4], f"AXIS{there // 16 + 1}", 1
        if rng.random() < 0.55:
            way = np.zeros(6)
            way[rng.integers(6)] = 1.0
        else:
            way = (rng.random(6) < 0.6) * rng.uniform(0.3, 1, 6)
        if not way.any():
            continue
        way = way * rng.choice([-1, 1], 6) * np.radians([70, 30, 35, 100, 50, 150])
        way = way * rng.choice([0.06, 0.15, 0.3, 0.6, 1.0])
        percent = float(percents[rng.integers(5)])
        for a, b in ((posture, posture + way), (posture + way, posture)):
            one = Move("joint", np.nan, 0.0, *load, job, line, 1, percent=percent)
            one.joints_start, one.joints_end = a, b
            moves.append(one)
            line += 1
        there += 1
    return moves[:size]


PROGRAMS: dict[str, Callable[[Rng, int, bool, bool], list[Move]]] = {
    "pick": _pick,
    "pallet": _pallet,
    "weld": _weld,
    "tend": _tend,
    "inspect": _inspect,
    "glue": _glue,
    "sweep": _sweep,
    "joints": _joint_test,
}
