"""The effects that can be hidden: each changes what the drives can do, or what the controller makes of it.

An effect has one strength, 0 for none. What a body can do comes from MuJoCo where `body` is set (along the path, with
all links), and else from the load alone, as a controller that plans with the load data does.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.concealed.arms import mass_and_gravity
from bench.concealed.player import STEP, Drive, tails
from bench.concealed.programs import GRID, Moves

Floats = NDArray[np.float64]
G = 9.80665
COARSE = 9  # points along a move at which the rigid bodies are asked


class Hidden(NamedTuple):
    """One hidden effect. `body`: from the rigid bodies along the path. `draw` (n,): fixed random numbers of it."""

    term: str
    strength: float
    body: bool = False
    draw: Floats | None = None
    choice: float = 1.0  # a second property: sign, time constant, knee


@dataclass(slots=True)
class Bodies:
    """Mass matrix (n, G, 6, 6) and gravity (n, G, 6) of the moves, once per different move."""

    moves: Moves
    _mass: Floats | None = None
    _weight: Floats | None = None

    def tables(self) -> tuple[Floats, Floats]:
        """Along the path force [N]: effective mass (n, G) [kg] without payload, weight (n, G) [N]; see `inertia`."""
        if self._mass is None:
            self._mass, self._weight = self._ask()
        first, _ = self.moves.slopes()
        assert self._weight is not None
        mass = np.einsum("ngi,ngij,ngj->ng", first, self._mass, first)
        weight = np.einsum("ngi,ngi->ng", first, self._weight)
        return mass, weight

    def inertia(self, axis: int) -> Floats:
        """(n, G) [kg m^2] about an axis."""
        self.tables()
        assert self._mass is not None
        return self._mass[:, :, axis, axis]

    def _ask(self) -> tuple[Floats, Floats]:
        _, which, back = np.unique(self.moves.line, return_index=True, return_inverse=True)
        pick = np.linspace(0, GRID - 1, COARSE).astype(int)
        q = self.moves.path[which][:, pick].reshape(-1, 6)
        mass, weight = mass_and_gravity(self.moves.arm, q)
        fine = np.arange(GRID) / (GRID - 1) * (COARSE - 1)
        low = np.minimum(fine.astype(int), COARSE - 2)
        part = fine - low

        def spread(values: Floats) -> Floats:
            table = values.reshape(len(which), COARSE, *values.shape[1:])
            share = part.reshape(1, -1, *([1] * (values.ndim - 1)))
            return (table[:, low] * (1 - share) + table[:, low + 1] * share)[back]

        return spread(mass), spread(weight)


@dataclass(slots=True)
class World:
    """A program on an arm under a controller's plain setting: linear acceleration [m/s^2], how corners are passed."""

    moves: Moves
    acceleration: float
    corners: str = "overlap"  # what happens at rounded ends when nothing is hidden: overlap, stop, fly
    step: float = STEP  # s
    simulated_speed: float = 1.0  # factor on programmed speeds that the simulation was tuned to
    bodies: Bodies = field(init=False)

    def __post_init__(self) -> None:
        self.bodies = Bodies(self.moves)


def plain_drive(world: World) -> Drive:
    """What a simulation assumes: one linear acceleration, axes' rated speeds and accelerations for joint moves."""
    moves = world.moves
    n, one = len(moves), np.ones((len(moves), GRID))
    first, second = moves.slopes()
    span = np.abs(moves.axes[:, 1] - moves.axes[:, 0])
    with np.errstate(divide="ignore"):
        rated = np.min(moves.arm.speed / np.maximum(span, 1e-9), axis=1)
        quick = np.min(moves.arm.acceleration / np.maximum(span, 1e-9), axis=1)
    joint = moves.kind == 1
    speed = np.where(joint, moves.speed * rated, moves.speed) * world.simulated_speed
    accel = np.where(joint, quick, world.acceleration)
    inf = np.full(6, np.inf)
    return Drive(
        np.where(moves.kind == 2, 0.0, moves.length), speed, accel[:, None] * one, accel[:, None] * one,
        np.full(n, np.inf), 0.0 * one, 1.0, np.zeros(n), first, second, inf, inf, world.step,
    )  # fmt: skip


def _linear(world: World) -> Floats:
    return (world.moves.kind == 0).astype(float)[:, None]


def _acceleration(world: World, drive: Drive, h: Hidden) -> None:
    factor = 1 / (1 + h.strength) if h.choice > 0 else 1 + h.strength
    drive.up, drive.down = drive.up * factor, drive.down * factor


def _jerk(world: World, drive: Drive, h: Hidden) -> None:
    # A joint move ramps in the same time.
    drive.jerk = drive.up[:, 0] / max(h.strength, 1e-6)


def _gravity(world: World, drive: Drive, h: Hidden) -> None:
    moves = world.moves
    pull = np.repeat(G * moves.steepness()[:, None], GRID, axis=1)
    if h.body:
        _, weight = world.bodies.tables()
        lean = moves.steepness() * G
        linear = moves.kind == 0
        mean = weight[linear].mean(axis=1)
        mass = float(mean @ lean[linear] / max(lean[linear] @ lean[linear], 1e-9))
        pull = np.where(linear[:, None], weight / mass, 0.0)
    nominal = drive.up
    drive.up = np.maximum(nominal - h.strength * pull, 0.12 * nominal)
    drive.down = np.maximum(drive.down + h.strength * pull, 0.12 * nominal)


def _reach_inertia(world: World, drive: Drive, h: Hidden) -> None:
    if h.body:
        about = world.bodies.inertia(0)
    else:
        about = np.repeat((world.moves.radius()[:, GRID // 2] ** 2)[:, None], GRID, axis=1)
    slow = 1 + h.strength * _linear(world) * about / np.median(about)
    drive.up, drive.down = drive.up / slow, drive.down / slow


def _payload(world: World, drive: Drive, h: Hidden) -> None:
    carried = np.repeat(world.moves.load[:, None], GRID, axis=1)
    if h.body:
        mass, _ = world.bodies.tables()
        linear = world.moves.kind == 0
        carried = carried * np.where(linear[:, None], np.median(mass[linear]) / np.maximum(mass, 1e-9), 1.0)
    slow = 1 + h.strength * carried
    drive.up, drive.down = drive.up / slow, drive.down / slow


def wrist_limits(world: World, drive: Drive, strength: float) -> None:
    """The wrist's axes accelerate as their motors and the load's inertia allow; strength 0: the empty flange."""
    slow = 1 + strength * world.moves.inertia
    for axis in (3, 4, 5):
        slope = np.abs(drive.first[:, :, axis])
        with np.errstate(divide="ignore"):
            allowed = world.moves.arm.acceleration[axis] / slow[:, None] / np.maximum(slope, 1e-9)
        drive.up, drive.down = np.minimum(drive.up, allowed), np.minimum(drive.down, allowed)


def _payload_inertia(world: World, drive: Drive, h: Hidden) -> None:
    wrist_limits(world, drive, h.strength)


def _joint_acceleration(world: World, drive: Drive, h: Hidden) -> None:
    drive.most = world.moves.arm.acceleration / max(h.strength, 1e-6)


def _joint_speed(world: World, drive: Drive, h: Hidden) -> None:
    drive.fastest = world.moves.arm.speed / max(h.strength, 1e-6)


def _torque_speed(world: World, drive: Drive, h: Hidden) -> None:
    share = np.max(np.abs(drive.first) / world.moves.arm.speed, axis=2)
    drive.per_speed, drive.knee = h.strength * share, h.choice


def _speed_clamp(world: World, drive: Drive, h: Hidden) -> None:
    linear = world.moves.kind == 0
    most = world.moves.speed[linear].max() / (1 + h.strength)
    drive.speed = np.where(linear, np.minimum(drive.speed, most), drive.speed)


def _speed_scale(world: World, drive: Drive, h: Hidden) -> None:
    drive.speed = drive.speed / (1 + h.strength) if h.choice > 0 else drive.speed * (1 + h.strength)


def _viscous(world: World, drive: Drive, h: Hidden) -> None:
    drive.viscous = np.full(len(drive.speed), h.strength)


def _coulomb(world: World, drive: Drive, h: Hidden) -> None:
    # Friction costs in speeding up what it gives in braking.
    drive.up, drive.down = drive.up - h.strength * drive.up, drive.down + h.strength * drive.down


_DRIVES = {
    "acceleration": _acceleration, "jerk": _jerk, "gravity": _gravity, "reach-inertia": _reach_inertia,
    "payload": _payload, "payload-inertia": _payload_inertia, "joint-acceleration-limit": _joint_acceleration,
    "joint-speed-limit": _joint_speed, "torque-speed": _torque_speed, "speed-clamp": _speed_clamp,
    "speed-scale": _speed_scale, "viscous-friction": _viscous, "coulomb-friction": _coulomb,
}  # fmt: skip


def play(world: World, hidden: list[Hidden], like: list[Hidden] | None = None) -> Floats:
    """(n,) [s] true durations. `like`: effects whose way of computing is used too, though they are not there."""
    drive = plain_drive(world)
    terms = {h.term: h for h in [*hidden, *(like or [])]}
    if "payload-inertia" in terms and not any(h.term == "payload-inertia" for h in hidden):
        wrist_limits(world, drive, 0.0)
    for h in hidden:
        if h.term in _DRIVES:
            _DRIVES[h.term](world, drive, h)
    if terms.keys() & {"joint-acceleration-limit", "joint-speed-limit"} and not np.isfinite(drive.most).any():
        drive.most = np.where(np.isfinite(drive.most), drive.most, 1e9)
    times = drive.times()
    times = _turned(world, hidden, times)
    times = _cornered(world, drive, hidden, times)
    times = times + world.moves.wait
    return _controller(world, hidden, times)


def _turned(world: World, hidden: list[Hidden], times: Floats) -> Floats:
    for h in hidden:
        if h.term != "orientation-limit" or h.strength <= 0:
            continue
        moves, n = world.moves, len(world.moves)
        one, most = np.ones((n, GRID)), 3.0 / h.strength
        angle = np.where(moves.kind == 0, moves.angle, 0.0)
        flat = np.zeros((n, GRID, 6))
        inf = np.full(6, np.inf)
        turn = Drive(
            angle, np.full(n, most), most / h.choice * one, most / h.choice * one, np.full(n, np.inf),
            0 * one, 1.0, np.zeros(n), flat, flat, inf, inf, world.step,
        )  # fmt: skip
        times = np.maximum(times, turn.times())
    return times


def _cornered(world: World, drive: Drive, hidden: list[Hidden], times: Floats) -> Floats:
    """Rounded ends: the next move begins while the last one ends; the border between them is in the middle."""
    blend = world.moves.blend
    mode = world.corners
    share = 1.0
    for h in hidden:
        if h.term == "blending":
            mode, share = "overlap", h.strength
    if mode == "stop" or not (blend > 0).any():
        return times
    if mode == "fly":
        saved = tails(drive, np.full(len(blend), np.inf), True)
        before = tails(drive, np.full(len(blend), np.inf), True)
        entered = np.append(False, blend[:-1] > 0)
        return times - np.where(blend > 0, saved, 0.0) - np.where(entered, before, 0.0)
    over = tails(drive, np.minimum(share * blend, 0.5 * drive.length), False)
    over = np.where(blend > 0, np.minimum(over, 0.5 * np.append(times[1:], 0.0)), 0.0)
    return times - over / 2 - np.append(0.0, over[:-1]) / 2


def _controller(world: World, hidden: list[Hidden], times: Floats) -> Floats:
    moves = world.moves
    result = times.copy()
    by = {h.term: h for h in hidden}
    if h := by.get("settling"):
        result = result + h.strength * ((moves.blend == 0) & (moves.kind != 2))
    if h := by.get("dispatch"):
        result = result + h.strength
    if h := by.get("external-wait"):
        assert h.draw is not None
        result = result + h.strength * h.draw
    if h := by.get("warm-up"):
        result = _warming(result, moves.kind != 2, h)
    if h := by.get("outside"):
        assert h.draw is not None
        result = result * (1 + h.strength * h.draw)
    if h := by.get("clock"):
        result = result * (1 + h.strength * h.choice)
    if (h := by.get("cycle-quantisation")) and h.strength > 0:
        result = np.ceil(result / h.strength - 1e-9) * h.strength
    return result


def _warming(times: Floats, moving: NDArray[np.bool_], h: Hidden) -> Floats:
    """Cold joints make the whole move slower by a share that dies away with running time; no timer has joints."""
    result, clock = np.empty(len(times)), 0.0
    for i, time in enumerate(times.tolist()):
        result[i] = time * (1 + h.strength * np.exp(-clock / h.choice)) if moving[i] else time
        clock += result[i]
    return result
