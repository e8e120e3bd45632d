"""What the real controller has and the simulation has not: sizes of each cause, what is alike, laws of no list."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bench.sixth_author.arm import Arm, RedrawError
from bench.sixth_author.motion import Controller, Engine
from bench.sixth_author.programs import PROGRAMS, Move, Rng

TERMS = (
    "acceleration", "jerk", "gravity", "reach-inertia", "payload", "payload-inertia", "joint-acceleration-limit",
    "joint-speed-limit", "torque-speed", "speed-clamp", "orientation-limit", "speed-scale", "settling", "dispatch",
    "blending", "cycle-quantisation", "warm-up", "external-wait", "viscous-friction", "coulomb-friction",
)  # fmt: skip
_SHOWN_BY = {  # programs that show a cause, some of them more often than others
    "acceleration": ["sweep", "pick", "pallet", "inspect", "weld", "joints", "glue"],
    "jerk": ["sweep", "pick", "pallet", "inspect", "tend"],
    "gravity": ["sweep", "inspect", "pick"],
    "payload": ["pick", "pallet", "tend", "sweep"],
    "reach-inertia": ["sweep", "pallet", "pick", "tend"],
    "payload-inertia": ["joints"],
    "joint-acceleration-limit": ["joints", "sweep", "tend", "joints", "joints"],
    "joint-speed-limit": ["joints", "joints", "sweep", "pick", "tend", "inspect"],
    "torque-speed": ["joints"],
    "speed-clamp": ["sweep", "pick", "pallet", "tend", "weld"],
    "orientation-limit": ["sweep", "inspect", "pick", "pallet"],
    "blending": ["glue", "weld", "glue"],
    "cycle-quantisation": ["sweep", "pick", "inspect", "joints", "pallet"],
    "external-wait": ["tend", "pick", "pallet", "inspect"],
    "viscous-friction": ["joints", "sweep"],
    "coulomb-friction": ["joints", "sweep", "pick"],
}
Changes = dict[str, Any]  # of a Controller
Sizes = dict[str, Any]  # what a truth tells: numbers with units, and words


def shown_by(term: str) -> list[str]:
    """Programs that show a cause."""
    return _SHOWN_BY.get(term) or list(PROGRAMS)


@dataclass(frozen=True)
class Cell:
    """A program that an arm runs, or a gantry that moves a tool as an arm would."""

    engine: Engine
    program: str
    gantry: bool
    reference_reach: float  # where accelerations are as told [mm]
    whole: float  # duration of the program [s]

    @property
    def moves(self) -> Sequence[Move]:
        """Of the program."""
        return self.engine.moves

    @property
    def base(self) -> Controller:
        """What the simulation takes for the controller."""
        return self.engine.base

    @property
    def arm(self) -> Arm:
        """Of the cell."""
        return self.engine.arm

    @property
    def by_joints(self) -> bool:
        """Whether the program is a joint test."""
        return self.program == "joints"

    @property
    def rounded(self) -> bool:
        """Whether some corners are rounded."""
        return any(move.blend > 0 for move in self.moves)

    @property
    def straight(self) -> np.ndarray:
        """Moves of the tool along a line or arc (n,)."""
        return np.array([move.kind != "joint" for move in self.moves])


@dataclass(frozen=True)
class Hidden:
    """A cause of one size: changes of the real controller and of the simulation's, and what a truth tells of them.

    `told`: the numbers that `olp diagnose` gives by the same name, in the same unit and with the same meaning.
    """

    real: Changes
    simulated: Changes = field(default_factory=dict)
    sizes: Sizes = field(default_factory=dict)
    told: dict[str, float] = field(default_factory=dict)


class Draw:
    """Draws one size of a cause."""

    def __init__(self, rng: Rng) -> None:
        self.rng = rng

    def between(self, low: float, high: float) -> list[float]:
        """Sizes between two."""
        return [self.rng.uniform(low, high)]

    def beside(self, below: tuple[float, float], above: tuple[float, float]) -> list[float]:
        """Factors below and above one."""
        return [self.rng.uniform(*below) if self.rng.random() < 0.6 else self.rng.uniform(*above)]

    def one_of(self, *choices: float) -> list[Any]:
        """Which of some variants."""
        return [choices[self.rng.integers(len(choices))]]


class Scan(Draw):
    """Goes through sizes of a cause, to see what is alike."""

    def __init__(self) -> None:
        pass

    def between(self, low: float, high: float) -> list[float]:
        return list(np.linspace(low, high, 7))

    def beside(self, below: tuple[float, float], above: tuple[float, float]) -> list[float]:
        return list(np.linspace(*below, 8)) + list(np.linspace(*above, 6))

    def one_of(self, *choices: float) -> list[Any]:
        return list(choices)


def number(value: float, unit: str) -> dict[str, object]:
    """A number of a truth, with its unit."""
    return {"value": round(float(value), 6), "unit": unit}


def _acceleration(cell: Cell, draw: Draw) -> list[Hidden]:
    base, found = cell.base, []
    ends = ((0.4, 0.97), (1.03, 2.2)) if isinstance(draw, Scan) else ((0.5, 0.9), (1.12, 1.7))
    for k in draw.beside(*ends):
        real = {"acceleration": base.acceleration * k, "corner_acceleration": base.corner_acceleration}
        metres = base.acceleration * k / 1000
        told = {"scale": float(k)} | ({"acceleration": metres} if cell.straight.all() else {})
        found.append(Hidden(real, {}, {"factor": number(k, "1"), "real": number(metres, "m/s^2")}, told))
    return found


def _jerk(cell: Cell, draw: Draw) -> list[Hidden]:
    if cell.base.law != "dS":
        return []
    found = []
    for k in draw.between(0.5, 2.2):
        jerk = cell.base.acceleration / (k * 0.12)
        told = {"jerk": jerk / 1000} if cell.straight.all() else {}
        found.append(Hidden({"jerk": jerk}, {}, {"jerk": number(jerk / 1000, "m/s^3")}, told))
    return found


def _gravity(cell: Cell, draw: Draw) -> list[Hidden]:
    if cell.straight.sum() <= 8:
        return []
    words = ("capped", "both ramps", "force")
    return [
        Hidden(
            {"gravity": k, "gravity_variant": v},
            {},
            {"share": number(k, "1"), "variant": words[v]},
            {"share": float(k)},
        )
        for v in draw.one_of(0, 1, 2)
        for k in draw.between(0.2, 0.55)
    ]


def _reach_inertia(cell: Cell, draw: Draw) -> list[Hidden]:
    at = cell.reference_reach
    return [
        Hidden(
            {"gyration": k, "reference_reach": at},
            {},
            {"radius_of_gyration": number(k / 1000, "m"), "reference_reach": number(at / 1000, "m")},
        )
        for k in draw.between(150, 900)
    ]


def _payload(cell: Cell, draw: Draw) -> list[Hidden]:
    if len({move.payload for move in cell.moves}) <= 1:
        return []
    return [Hidden({"arm_mass": k}, {}, {"arm_mass": number(k, "kg")}) for k in draw.between(8, 40)]


def _payload_inertia(cell: Cell, draw: Draw) -> list[Hidden]:
    if len({move.inertia for move in cell.moves}) <= 1:
        return []
    return [
        Hidden({"wrist_inertia": k}, {}, {"axis_inertia": number(k, "kg m^2")})
        for k in draw.between(0.1, 0.5)
    ]


def _joint_limits(cell: Cell, draw: Draw, what: str, rated: np.ndarray, unit: str) -> list[Hidden]:
    """Limits of one axis: shares of what is rated (6,) [rad/s] or [rad/s^2]."""
    if cell.gantry:
        return []
    found = []
    for axis in draw.one_of(*range(6)):
        for k in draw.between(0.25, 0.8)[::2]:
            limits = np.full(6, np.inf)
            limits[axis] = k * rated[axis]
            sizes = {"axis": axis + 1, "limit": number(np.degrees(limits[axis]), unit)}
            told = {f"limit_axis_{axis + 1}": float(limits[axis])}
            found.append(Hidden({what: limits}, {}, sizes, told))
    return found


def _joint_acceleration(cell: Cell, draw: Draw) -> list[Hidden]:
    rated = cell.arm.accelerations * (0.7 if cell.straight.mean() > 0.6 else 1)
    return _joint_limits(cell, draw, "joint_accelerations", rated, "deg/s^2")


def _joint_speed(cell: Cell, draw: Draw) -> list[Hidden]:
    half = 0.5 if cell.straight.mean() > 0.6 else 1
    return _joint_limits(cell, draw, "joint_speeds", cell.arm.speeds * half, "deg/s")


def _torque_speed(cell: Cell, draw: Draw) -> list[Hidden]:
    if cell.base.law not in ("trap", "fir"):
        return []
    found = []
    for k in draw.between(0.5, 0.9):
        for knee in (0.0, 0.2, 0.4) if isinstance(draw, Scan) else draw.between(0.2, 0.5):
            sizes = {"knee": number(knee, "1 (of rated speed)"), "left_at_rated": number(1 - k, "1")}
            found.append(Hidden({"torque_loss": k, "knee": knee}, {}, sizes))
    return found


def _speed_clamp(cell: Cell, draw: Draw) -> list[Hidden]:
    speeds = np.unique([move.speed for move in cell.moves if move.kind != "joint"])
    if cell.straight.sum() <= 5 or len(speeds) <= 1:
        return []
    clamps = [speeds[-1] * k for k in draw.between(0.35, 0.85)]
    return [
        Hidden({"clamp": v}, {}, {"clamp": number(v / 1000, "m/s")}, {"clamp": float(v / 1000)})
        for v in clamps
    ]


def _orientation_limit(cell: Cell, draw: Draw) -> list[Hidden]:
    if not any(move.turned > 0.1 for move in cell.moves if move.kind == "linear"):
        return []
    rates = [(k, math.radians(k)) for k in draw.between(30, 140)]
    return [
        Hidden(
            {"turn_speed": rate, "turn_acceleration": rate / 0.25},
            {},
            {"turn_speed": number(k, "deg/s")},
            {"rate": rate},
        )
        for k, rate in rates
    ]


def _speed_scale(cell: Cell, draw: Draw) -> list[Hidden]:
    scanned = isinstance(draw, Scan)
    found = []
    for whole in (True, False) if scanned else [draw.rng.random() < 0.35]:
        for k in draw.beside((0.8, 0.97), (1.02, 1.2) if scanned else (1.03, 1.15)):
            sizes = {"factor": number(k, "1"), "whole_profile": bool(whole)}
            found.append(Hidden({"stretch" if whole else "speed_factor": k}, {}, sizes, {"scale": float(k)}))
    return found


def _settling(cell: Cell, draw: Draw) -> list[Hidden]:
    times = draw.between(0.01, 0.16)
    return [Hidden({"settle": t}, {}, {"time": number(t, "s")}, {"time": float(t)}) for t in times]


def _dispatch(cell: Cell, draw: Draw) -> list[Hidden]:
    times = draw.between(0.008, 0.1)
    return [Hidden({"dispatch": t}, {}, {"time": number(t, "s")}, {"time": float(t)}) for t in times]


def _blending(cell: Cell, draw: Draw) -> list[Hidden]:
    if not cell.rounded:
        return []
    if isinstance(draw, Scan):
        return [Hidden({"corner": k}) for k in (0, 0.4, 1.7)]
    pairs = ((1.0, 0.0), (0.0, 1.0), (1.0, 0.35), (0.4, 1.0), (2.0, 1.0))
    real, simulated = pairs[draw.rng.integers(5)]
    sizes = {"radius_factor_real": number(real, "1"), "radius_factor_sim": number(simulated, "1")}
    return [Hidden({"corner": real}, {"corner": simulated}, sizes)]


def _cycle(cell: Cell, draw: Draw) -> list[Hidden]:
    cycle = float(draw.rng.choice([0.016, 0.02, 0.024, 0.032, 0.04, 0.05]))
    up = bool(draw.rng.random() < 0.6)
    sizes = {"cycle": number(cycle, "s"), "rounding": "up" if up else "nearest"}
    return [Hidden({"cycle": cycle, "rounds_up": up}, {}, sizes, {"cycle": cycle})]


def _warm_up(cell: Cell, draw: Draw) -> list[Hidden]:
    scanned, found = isinstance(draw, Scan), []
    for tau in [cell.whole * part for part in ((0.08, 0.2, 0.4) if scanned else draw.between(0.1, 0.4))]:
        for warms in ["rate", "acc"] if scanned else [str(draw.rng.choice(["rate", "acc"]))]:
            ends = (0.04, 0.2) if warms == "rate" else (0.3, 0.9)
            for k in [0.1] if scanned else draw.between(*ends):
                real = {"warm_amplitude": k, "warm_time": tau, "warms": warms}
                sizes = {"amplitude": number(k, "1"), "tau": number(tau, "s"), "acts_on": warms}
                told = {"share": float(k), "tau": float(tau)} if warms == "rate" else {}
                found.append(Hidden(real, {}, sizes, told))
    return found


def _external_wait(cell: Cell, draw: Draw) -> list[Hidden]:
    """Waits at one line of a job, or anywhere."""
    rng, count = draw.rng, len(cell.moves)
    waits = np.zeros(count)
    places = [(move.job, move.line) for move in cell.moves]
    often = [place for place in sorted(set(places)) if count * 0.04 < places.count(place) < count * 0.2]
    if often and rng.random() < 0.7:
        job, line = often[rng.integers(len(often))]
        which = [i for i in range(count) if places[i] == (job, line)]
        where = f"at job {job} line {line + 1}"
    else:
        which = list(rng.choice(count, max(3, int(count * rng.uniform(0.04, 0.12))), replace=False))
        where = "scattered"
    waits[which] = rng.uniform(0.05, 0.2) + rng.exponential(rng.uniform(0.1, 0.5), len(which))
    mean = float(waits[which].mean())
    return [Hidden({"waits": waits}, {}, {"mean_wait": number(mean, "s"), "where": where}, {"mean": mean})]


def _viscous(cell: Cell, draw: Draw) -> list[Hidden]:
    if cell.base.law not in ("trap", "fir"):
        return []
    return [
        Hidden(
            {"viscous": k, "friction_helps": helps},
            {},
            {"share_at_rated": number(k, "1"), "helps_braking": bool(helps)},
        )
        for k in draw.between(0.3, 0.8)
        for helps in draw.one_of(0.0, 1.0)
    ]


def _coulomb(cell: Cell, draw: Draw) -> list[Hidden]:
    return [
        Hidden(
            {"coulomb": k, "friction_helps": helps},
            {},
            {"share": number(k, "1"), "helps_braking": bool(helps)},
            {"share": float(k)},
        )
        for k in draw.between(0.15, 0.5)
        for helps in draw.one_of(0.0, 1.0)
    ]


_SIZES: dict[str, Callable[[Cell, Draw], list[Hidden]]] = {
    "acceleration": _acceleration,
    "jerk": _jerk,
    "gravity": _gravity,
    "reach-inertia": _reach_inertia,
    "payload": _payload,
    "payload-inertia": _payload_inertia,
    "joint-acceleration-limit": _joint_acceleration,
    "joint-speed-limit": _joint_speed,
    "torque-speed": _torque_speed,
    "speed-clamp": _speed_clamp,
    "orientation-limit": _orientation_limit,
    "speed-scale": _speed_scale,
    "settling": _settling,
    "dispatch": _dispatch,
    "blending": _blending,
    "cycle-quantisation": _cycle,
    "warm-up": _warm_up,
    "external-wait": _external_wait,
    "viscous-friction": _viscous,
    "coulomb-friction": _coulomb,
}


def drawn(term: str, cell: Cell, rng: Rng) -> Hidden:
    """A cause of a random size, where this cell shows it."""
    found = _SIZES[term](cell, Draw(rng))
    if not found:
        raise RedrawError(term)
    return found[0]


@dataclass(frozen=True)
class Likeness:
    """Causes that leave no more than the noise of an effect, and the nearest one."""

    alike: list[str]
    nearest: str | None
    left: float  # square of what the nearest leaves over the noise


def likeness(
    cell: Cell,
    simulated: Changes,
    effect: np.ndarray,
    others: list[np.ndarray],
    noise: float,
    own: str | None,
) -> Likeness:
    """Which other single change of the controller would give the same seconds (n,) within the noise [s].

    `others`: the seconds of further effects, which may change in size.
    """
    alike, nearest, least = [], None, np.inf
    before = cell.engine.run(**simulated)
    for term in TERMS:
        if term in (own, "external-wait", "cycle-quantisation"):
            continue
        left = np.inf
        for size in _SIZES[term](cell, Scan()):
            if term == "blending" and size.real["corner"] == cell.base.corner:
                continue
            try:
                shape = cell.engine.run(**(simulated | size.real)) - before
            except RedrawError:
                continue
            if np.any(np.abs(shape) > 1e-6):
                left = min(left, _left(effect, shape, others) / noise**2)
        if left < 10:
            alike.append(term)
        if left < least:
            nearest, least = term, left
    for clock in (before, before * np.cumsum(before) / before.sum()):
        shapes = np.stack([clock, *others], 1)
        rest = effect - shapes @ np.linalg.lstsq(shapes, effect, rcond=None)[0]
        if (rest**2).sum() / noise**2 < 10 and "clock" not in alike:
            alike.append("clock")
    return Likeness(alike, nearest, float(least))


def _left(effect: np.ndarray, shape: np.ndarray, others: list[np.ndarray]) -> float:
    """Square [s^2] that a shape leaves, made larger or smaller by less than three times."""
    shapes = np.stack([shape, *others], 1)
    k = np.linalg.lstsq(shapes, effect, rcond=None)[0]
    if not 0.35 <= k[0] <= 2.8:
        k[0] = np.clip(k[0], 0.35, 2.8)
        if others:
            k[1:] = np.linalg.lstsq(shapes[:, 1:], effect - k[0] * shape, rcond=None)[0]
    return float(((effect - shapes @ k) ** 2).sum())


@dataclass(frozen=True)
class Outside:
    """A law of no list: real seconds (n,), what it is, and a column that shows it."""

    seconds: np.ndarray
    note: str
    columns: dict[str, np.ndarray] = field(default_factory=dict)


def _spool(rng: Rng, cell: Cell, plain: np.ndarray) -> Outside:
    ends = np.cumsum(plain)
    each = ends[-1] / rng.uniform(2.3, 5)
    used = (ends % each) / each
    times = cell.engine.run(1 / (1 + rng.uniform(0.7, 1.6) * used**1.5))
    return Outside(times, "wire spool: the pull grows as it empties, and falls at each change")


def _resonance(rng: Rng, cell: Cell, plain: np.ndarray) -> Outside:
    speed = np.array([move.speed for move in cell.moves])
    kinds = np.unique(speed[~np.isnan(speed)])
    if len(kinds) < 4:
        raise RedrawError("few speeds")
    middle = kinds[len(kinds) // 2 - (rng.random() < 0.5)]
    within = (speed > 0.9 * middle) & (speed < 1.1 * middle)
    times = cell.engine.run(speeds=np.where(within, rng.uniform(0.72, 0.9), 1.0))
    return Outside(times, f"the controller avoids a band of speeds around {middle:g} mm/s")


def _hose(rng: Rng, cell: Cell, plain: np.ndarray) -> Outside:
    ways = [move.end - move.start for move in cell.moves]
    heading = np.array([math.atan2(way[1], way[0]) for way in ways])
    off = rng.uniform(0, 6.28)
    far = np.array([np.hypot(way[0], way[1]) for way in ways]) > 5
    times = cell.engine.run(1 / (1 + far * rng.uniform(0.3, 0.7) * (1 + np.cos(2 * heading - off))))
    return Outside(times, "hose drag depends on the heading in the plane, twice per turn")


def _starved(rng: Rng, cell: Cell, plain: np.ndarray) -> Outside:
    before = np.r_[9, plain[:-1]]
    limit = np.quantile(plain, 0.35)
    late = np.where(before < limit, (limit - before) * rng.uniform(0.2, 0.6), 0)
    return Outside(
        plain + late, "planner starved after a short move: time depends on the previous move's duration"
    )


def _heads(rng: Rng, cell: Cell, plain: np.ndarray) -> Outside:
    second = (np.arange(len(plain)) // 2) % 2
    times = cell.engine.run(np.where(second, rng.uniform(0.55, 0.75), 1.0), np.where(second, 0.97, 1))
    return Outside(times, "two heads used in turn, two moves each, one limps")


def _ambient(rng: Rng, cell: Cell, plain: np.ndarray) -> Outside:
    ends = np.cumsum(plain)
    phase = 2 * np.pi * ends / ends[-1] * rng.uniform(1.5, 3.5) + rng.uniform(0, 6)
    warm = 22 + 9 * np.sin(phase) + rng.normal(0, 0.3, len(plain))
    times = cell.engine.run(1 / (1 + np.maximum(warm - 20, 0) * rng.uniform(0.04, 0.1)))
    note = "acceleration reduced above 20 degrees of the cabinet, temperature_c is recorded"
    return Outside(times, note, {"temperature_c": np.round(warm, 1)})


def _counterweight(rng: Rng, cell: Cell, plain: np.ndarray) -> Outside:
    pressure, factor = 1.0, np.ones(len(plain))
    for i, move in enumerate(cell.moves):
        climb = (move.end - move.start)[2]
        pressure = min(1.0, pressure + plain[i] * 0.08)
        factor[i] = 1 if climb <= 0 else 0.35 + 0.65 * pressure
        if climb > 0:
            pressure = max(0.05, pressure - climb / 500.0)
    note = "hydraulic counterweight: lifting empties the accumulator, which refills with time"
    return Outside(cell.engine.run(factor), note)


def _dress_pack(rng: Rng, cell: Cell, plain: np.ndarray) -> Outside:
    angle = np.array([move.joints_start[5] + move.joints_start[3] for move in cell.moves])
    twist = np.abs(np.sin(angle * 1.5 + rng.uniform(0, 3)))
    times = cell.engine.run(1 / (1 + rng.uniform(0.5, 1.2) * twist**2))
    return Outside(times, "dress pack: drag is periodic in the sum of two wrist angles at the start")


_OUTSIDE = (_spool, _resonance, _hose, _starved, _heads, _ambient, _counterweight, _dress_pack)


def outside(rng: Rng, cell: Cell) -> Outside:
    """The program under a law of no list."""
    plain = cell.engine.run()
    return _OUTSIDE[rng.choice(len(_OUTSIDE))](rng, cell, plain)
