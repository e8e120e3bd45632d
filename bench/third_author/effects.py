"""Effects that this author hides: each is physics of the arm with its own numbers, none a form of `olp`.

An effect is a function of (world, strength from 0 to 1, the drive so far). It returns the drive after it, the seconds
that it adds to each move beside the drive, and the numbers that parameters of the contract's term would have.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from bench.third_author.cells import GRID, Moves
from bench.third_author.plant import Drive, axis_limit, drive_of, seconds, trapezoid

Change = tuple[Drive, np.ndarray | float, dict[str, float]]


@dataclass
class World:
    """A recording's moves as simulated, and choices that hold for the whole case."""

    moves: Moves
    options: dict[str, float]  # drawn once per case
    starts: np.ndarray  # running time at the start of each move [s]
    pulls: tuple[np.ndarray, np.ndarray] | None = None  # what `gravity` needs, once it is asked for

    def __post_init__(self):
        self.drive = drive_of(self.moves)
        self.kind = self.moves.column("kind")
        self.joint = self.kind == "joint"
        self.waits = self.kind == "wait"
        self.lines = ~self.joint & ~self.waits
        self.blend = self.moves.column("blend")
        self.span = self.moves.q[:, -1] - self.moves.q[:, 0]  # of each axis [rad]
        self.limits = self.moves.arm.accelerations / np.maximum(
            np.abs(self.span), 1e-9
        )  # of s'' by each axis
        self.integrated = seconds(self.drive)
        self.simulated = np.where(self.waits, self.moves.column("dwell"), trapezoid(self.drive))


def acceleration(world: World, strength: float, drive: Drive) -> Change:
    """The drives give more or less current than the simulation thinks."""
    scale = 1 - 0.45 * strength if world.options["weaker"] else 1 + 0.6 * strength
    return drive.with_share(np.full_like(drive.up, scale)), 0.0, {"scale": scale}


def jerk(world: World, strength: float, drive: Drive) -> Change:
    """Torque builds up in a time, so acceleration does."""
    build_up = 0.01 + 0.16 * strength
    numbers = {} if world.joint.any() else {"jerk": drive.rated[world.lines].max() / build_up}
    return replace(drive, build_up=np.full(len(world.kind), build_up)), 0.0, numbers


def gravity(world: World, strength: float, drive: Drive) -> Change:
    """The weights of the arm's bodies and of the load work along the path, against or with the drives."""
    if world.pulls is None:
        world.pulls = _path_pull(world), _torque_left(world)
    path, torques = world.pulls
    up, down = (_with_weights(world, way * strength, path, torques) for way in (1, -1))
    if world.options["planned"]:  # the planner never asks for more than it knows
        up, down = np.minimum(up, 1), np.minimum(down, 1)
    return drive.with_share(np.clip(up, 0.1, 2), np.clip(down, 0.1, 2)), 0.0, {}


def _with_weights(world: World, share: float, path: np.ndarray, torques: np.ndarray) -> np.ndarray:
    """The acceleration of a ramp over that without weights; `share` is negative where they help to brake. Of a joint
    move each axis has its own, and whichever has least left sets both ramps, each for itself."""
    left = np.clip(1 - 2 * share * torques, 0.1, 2) * world.limits[:, None]
    return np.where(world.joint[:, None], left.min(-1) / world.limits.min(-1)[:, None], 1 - share * path)


def _path_pull(world: World) -> np.ndarray:
    """Slope of the weights' energy along the path, over the whole weight."""
    moves, arm = world.moves, world.moves.arm
    energy = arm.potential(moves.q, moves.column("load")[:, None])
    way = np.maximum(world.drive.length, 1e-9)[:, None]
    return 0.6 * np.gradient(energy, GRID, axis=1) / way / (9.81 * sum(arm.masses))


def _torque_left(world: World) -> np.ndarray:
    """The share of the torque of axes 2 and 3 that the weights take, against the way the axis turns."""
    moves, arm = world.moves, world.moves.arm
    load = moves.column("load")[:, None]
    taken = np.zeros_like(moves.q)
    worst = 9.81 * sum(arm.masses) * (arm.upper + arm.fore)
    for axis in (1, 2):
        shift = np.eye(arm.axes)[axis] * 1e-4
        torque = (arm.potential(moves.q + shift, load) - arm.potential(moves.q - shift, load)) / 2e-4
        taken[..., axis] = torque / worst * np.sign(world.span[:, [axis]])
    return taken


def reach_inertia(world: World, strength: float, drive: Drive) -> Change:
    """The bodies' inertia about the column grows outwards; the first axis has one torque."""
    moves, arm = world.moves, world.moves.arm
    inertia = arm.inertia(moves.q) - arm.column
    known = np.quantile(inertia, 0.05 if world.options["weaker"] else 0.6)  # where the simulation is right
    share = (1 + 2 * strength) / (1 + 2 * strength * inertia / known)
    others = np.min(world.limits[:, 1:], axis=1)[:, None]
    axes = np.minimum(world.limits[:, :1] * share, others) / world.limits.min(1)[:, None]
    return drive.with_share(np.where(world.joint[:, None], axes, share)), 0.0, {}


def payload(world: World, strength: float, drive: Drive) -> Change:
    """One force moves the arm's own mass and the load's; the simulation may carry another load."""
    load = world.moves.column("load")
    own = max(load.max(), 1e-9) / (0.15 + 1.2 * strength)
    share = (own + world.options["told"] * load.max()) / (own + load)
    return drive.with_share(share[:, None]), 0.0, {} if world.options["told"] else {"growth": 1 / own}


def payload_inertia(world: World, strength: float, drive: Drive) -> Change:
    """The wrist's axes turn the load's moment of inertia beside their own."""
    spin = world.moves.column("spin")
    own = max(spin.max(), 1e-9) / (0.3 + 2.5 * strength)
    factor = np.ones_like(world.limits)
    factor[:, 3:] = (own / (own + spin))[:, None]
    share = np.where(world.joint, (world.limits * factor).min(1) / world.limits.min(1), 1.0)
    return drive.with_share(share[:, None]), 0.0, {}


def _one_axis(world: World, limits: np.ndarray, strength: float) -> np.ndarray:
    """The path's limit with the limit of one axis lowered."""
    lowered = limits.copy()
    lowered[int(world.options["axis"]) % len(limits)] *= 1 - 0.65 * strength
    return axis_limit(np.abs(world.span), lowered)


def joint_acceleration_limit(world: World, strength: float, drive: Drive) -> Change:
    """One axis accelerates less than its data sheet says."""
    share = _one_axis(world, world.moves.arm.accelerations, strength) / world.limits.min(1)
    return drive.with_share(np.where(world.joint, share, 1.0)[:, None]), 0.0, {}


def joint_speed_limit(world: World, strength: float, drive: Drive) -> Change:
    """One axis turns no faster than some rate below its rated speed."""
    cap = np.where(world.joint, _one_axis(world, world.moves.arm.speeds, strength), np.inf)
    return replace(drive, cap=np.minimum(drive.cap, cap[:, None])), 0.0, {}


def torque_speed(world: World, strength: float, drive: Drive) -> Change:
    """Motors lose torque above a corner speed, perhaps not when they brake; of cells with one kind of moves."""
    if world.joint.any() and world.lines.any():
        return drive, 0.0, {}
    each = np.ones(len(world.kind))
    knee, idle = (0.75 - 0.6 * strength) * each, (1.8 - 0.7 * strength) * each
    return replace(drive, knee=knee, idle=idle, brake=world.options["braking"] * each), 0.0, {}


def speed_clamp(world: World, strength: float, drive: Drive) -> Change:
    """A supervision lets no tool go faster on a line."""
    limit = (1 - 0.7 * strength) * drive.speed.max(initial=0.0, where=world.lines)
    cap = np.where(world.lines, limit, np.inf)
    return replace(drive, cap=np.minimum(drive.cap, cap[:, None])), 0.0, {"clamp": limit}


def orientation_limit(world: World, strength: float, drive: Drive) -> Change:
    """The tool turns no faster than some rate, and slows the path."""
    per_way = world.moves.turned / np.maximum(drive.length, 1e-9) * world.lines
    rate = (1.05 - 0.9 * strength) * max((per_way * drive.speed).max(), 1e-6)
    cap = np.where(per_way > 1e-6, rate / np.maximum(per_way, 1e-6), np.inf)
    return replace(drive, cap=np.minimum(drive.cap, cap[:, None])), 0.0, {"rate": rate}


def speed_scale(world: World, strength: float, drive: Drive) -> Change:
    """Speeds are off by one factor."""
    scale = 1 - 0.15 * strength if world.options["weaker"] else 1 + 0.15 * strength
    return replace(drive, speed=drive.speed * scale), 0.0, {"scale": scale}


def override(world: World, strength: float, drive: Drive) -> Change:
    """The operator's override differs from cycle to cycle, and the simulation has 100 %."""
    steps = np.array([100, 100 - 30 * strength, 100 - 55 * strength]).round()
    percent = steps[(world.moves.cycles + 1) % 3]
    late = np.where(world.waits, 0.0, world.simulated * (100 / percent - 1))
    world.percent = percent
    return drive, late, {}


def settling(world: World, strength: float, drive: Drive) -> Change:
    """The controller waits at exact stops until the axes are in position."""
    time = 0.06 * strength
    return drive, np.where(~world.waits & (world.blend == 0), time, 0.0), {"time": time}


def dispatch(world: World, strength: float, drive: Drive) -> Change:
    """Interpreting a move costs time."""
    time = 0.05 * strength
    return drive, np.where(world.waits, 0.0, time), {"time": time}


def blending(world: World, strength: float, drive: Drive) -> Change:
    """At rounded corners the next ramp begins before the last has ended; the stamp is near the corner's middle."""
    rounds = ~world.waits & (world.blend > 0) & np.append(~world.waits[1:], False)
    way = np.where(world.joint, world.blend / (1.5 * world.moves.arm.upper), world.blend)
    last = _time_over(world, way)
    first = np.append(_time_over(world, np.append(0.0, way[:-1]))[1:], 0.0)
    saved = np.where(rounds, (0.3 + 0.7 * strength) * np.minimum(last, first), 0.0)
    share = world.options["corner"]
    return drive, -share * saved - (1 - share) * np.append(0.0, saved[:-1]), {}


def _time_over(world: World, way: np.ndarray) -> np.ndarray:
    """Time that a ramp needs for a way from rest [s], at most half the move."""
    drive = world.drive
    way = np.minimum(way, drive.length / 2)
    rate, top = np.maximum(drive.acceleration, 1e-9), np.maximum(drive.speed, 1e-9)
    ramp = top**2 / (2 * rate)
    time = np.where(way < ramp, np.sqrt(2 * way / rate), top / rate + (way - ramp) / top)
    return np.where(world.waits, 0.0, time)


def warm_up(world: World, strength: float, drive: Drive) -> Change:
    """Cold grease: moves take longer until the gears are warm."""
    share, tau = 0.01 + 0.07 * strength, world.options["warm"] * world.starts[-1]
    time = world.simulated if drive is world.drive else world.simulated + seconds(drive) - world.integrated
    late = np.where(world.waits, 0.0, time * share * np.exp(-world.starts / tau))
    return drive, late, {"share": share, "tau": tau}


def external_wait(world: World, strength: float, drive: Drive) -> Change:
    """At one line of the jobs the arm waits for a signal, often and for as long as it takes."""
    rng = np.random.default_rng(int(world.options["seed"]))
    lines, counts = np.unique(world.moves.lines[~world.waits], return_counts=True)
    at = (
        world.moves.lines == rng.choice(lines[counts < len(world.kind) / 6])
        if (counts < len(world.kind) / 6).any()
        else False
    )
    late = rng.gamma(1.5, 0.2 * strength, len(world.kind)) + 0.1 * strength
    return drive, np.where(at & ~world.waits & (rng.random(len(late)) < 0.7), late, 0.0), {}


def viscous_friction(world: World, strength: float, drive: Drive) -> Change:
    """Friction grows with speed: the drives get weaker and the brakes stronger."""
    quickest = np.max(drive.speed / np.maximum(drive.acceleration, 1e-9), where=~world.waits, initial=1e-6)
    return replace(drive, drag=np.full(len(world.kind), 0.75 * strength / quickest)), 0.0, {}


def coulomb_friction(world: World, strength: float, drive: Drive) -> Change:
    """Friction takes a share of the force of every ramp up, and helps every brake."""
    part = np.full_like(drive.up, 0.55 * strength)
    return drive.with_share(1 - part, 1 + part), 0.0, {"share": 0.55 * strength}


def clock(world: World, strength: float, drive: Drive) -> Change:
    """The recorder's second is another one, in motion and at rest."""
    rate = 1 + 0.03 * strength * (1 if world.options["weaker"] else -1)
    return drive, world.simulated * (rate - 1), {"rate": rate}


def ripple(world: World, strength: float, drive: Drive) -> Change:
    """A pump beside the arm: durations swing with the running time."""
    period = world.starts[-1] / (6 + 10 * world.options["warm"])
    swing = 0.03 * strength * np.sin(2 * np.pi * world.starts / period)
    return drive, np.where(world.waits, 0.0, swing), {}


def turning_back(world: World, strength: float, drive: Drive) -> Change:
    """Gears wind up: a move takes longer the more it turns back against the one before."""
    way = world.span / np.maximum(np.linalg.norm(world.span, axis=1, keepdims=True), 1e-9)
    back = np.append(0.0, 1 - np.sum(way[1:] * way[:-1], axis=1)) ** 2
    back -= back[~world.waits].mean()  # the rest is in the simulation
    return drive, np.where(world.waits, 0.0, 0.025 * strength * back), {}


def taught_elsewhere(world: World, strength: float, drive: Drive) -> Change:
    """Each place was taught again after the simulation was made, and has its own error."""
    rng = np.random.default_rng(int(world.options["seed"]))
    cells = np.round(world.moves.points[:, -1] / (0.15 * world.moves.arm.fore))
    place = np.unique(cells, axis=0, return_inverse=True)[1].ravel()
    errors = 0.04 * strength * rng.normal(size=place.max() + 1)
    return drive, np.where(world.waits, 0.0, errors[place]), {}


def dress_pack(world: World, strength: float, drive: Drive) -> Change:
    """Hoses pull in some directions about the column, more in longer moves."""
    angle = np.arctan2(world.moves.points[:, -1, 1], world.moves.points[:, -1, 0])
    pull = 0.08 * strength * world.simulated * np.sin(5 * angle)
    return drive, np.where(world.waits, 0.0, pull), {}


Effect = Callable[[World, float, Drive], Change]


def _named(*effects: Effect) -> dict[str, Effect]:
    return {effect.__name__.replace("_", "-"): effect for effect in effects}


EFFECTS = _named(
    acceleration, jerk, gravity, reach_inertia, payload, payload_inertia, joint_acceleration_limit, joint_speed_limit,
    torque_speed, speed_clamp, orientation_limit, speed_scale, settling, dispatch, blending, warm_up, external_wait,
    viscous_friction, coulomb_friction, clock,
)  # fmt: skip
OUTSIDE = _named(ripple, turning_back, taught_elsewhere, dress_pack)
