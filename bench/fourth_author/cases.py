"""Draws cells, hidden effects and recorders, and writes recordings with their sealed truth."""

import gzip
import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd

from bench.fourth_author.motion import CIRCULAR, JOINT, LINEAR, WAIT, Moves, World, seconds
from bench.fourth_author.programs import PROGRAMS, write_program
from bench.fourth_author.robots import Arm, all_arms, euler

_KINDS = ("joint", "linear", "circular", "wait")
_TYPES = (
    ["nothing"] * 8
    + ["single"] * 44
    + ["two"] * 18
    + ["somewhere"] * 10
    + ["cancelled"] * 8
    + ["outside"] * 8
    + ["clock"] * 4
)


@dataclass
class Hidden:
    """One hidden effect: the change of the world, the numbers a report may give for it, the moves if not all."""

    term: str
    change: dict[str, object]
    numbers: dict[str, float] = field(default_factory=dict)
    only: np.ndarray | None = None


@dataclass
class Scene:
    """What the effects may depend on."""

    rng: np.random.Generator
    moves: Moves
    arm: Arm
    sim: World
    acceleration: float

    @property
    def moving(self) -> np.ndarray:
        """Moves of the arm (m,)."""
        return self.moves.kind != WAIT

    @property
    def straight(self) -> np.ndarray:
        """Moves of the tool along a line or arc (m,)."""
        return (self.moves.kind == LINEAR) | (self.moves.kind == CIRCULAR)

    def geometric(self, low: float, high: float) -> float:
        """A number between two, evenly on a logarithmic scale."""
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def one_kind(self) -> bool:
        """Whether all moves are straight."""
        return bool(self.straight[self.moving].all())


def _acceleration(s: Scene) -> Hidden:
    k = 1 + s.geometric(0.03, 0.35) * s.rng.choice([-1, 1, -1])
    return Hidden("acceleration", {"accel": k}, {"scale": k})


def _jerk(s: Scene) -> Hidden:
    t = s.sim.ramp + s.geometric(0.02, 0.25)
    numbers = {"ramp_time": t}
    if s.sim.ramp == 0 and s.one_kind():
        numbers["jerk"] = s.acceleration / t
    return Hidden("jerk", {"ramp": t}, numbers)


def _gravity(s: Scene) -> Hidden | None:
    climb = np.abs(s.moves.p[:, -1, 2] - s.moves.p[:, 0, 2])
    if np.std(climb) < 0.03:
        return None
    up = s.geometric(0.06, 0.4)
    return Hidden("gravity", {"up": up, "brake": float(s.rng.choice([0, 0.5, 1])) * up})


def _reach(s: Scene) -> Hidden | None:
    radius = np.hypot(s.moves.p[:, 12, 0], s.moves.p[:, 12, 1])
    if np.std(radius) < 0.08 * np.mean(radius):
        return None
    return Hidden("reach-inertia", {"reach": s.geometric(0.1, 1.2) / np.mean(radius) ** 2})


def _payload(s: Scene) -> Hidden | None:
    if np.std(s.moves.payload[s.moving]) < 0.1 * s.arm.payload:
        return None
    k = s.geometric(0.08, 0.8) / s.arm.payload
    return Hidden("payload", {"carry": k}, {"growth": k})


def _payload_inertia(s: Scene) -> Hidden | None:
    joint = s.moves.kind == JOINT
    if joint.sum() < 20 or np.ptp(s.moves.inertia[joint]) <= 0:
        return None
    return Hidden("payload-inertia", {"bulk": s.geometric(0.5, 5) / np.max(s.moves.inertia)})


def _axis_accel(s: Scene) -> Hidden | None:
    if s.straight.sum() < 30:
        return None
    limits = np.full(s.arm.n, np.inf)
    axis = int(s.rng.integers(0, s.arm.n))
    needed = (
        np.abs(np.gradient(s.moves.q[s.straight], 1 / 24, axis=1))[:, :, axis]
        / s.moves.length[s.straight][:, None]
    )
    limits[axis] = float(np.quantile(needed.max(axis=1), s.rng.uniform(0.5, 0.9))) * s.acceleration
    return Hidden("joint-acceleration-limit", {"axis_accel": np.where(np.isfinite(limits), limits, 1e6)})


def _axis_speed(s: Scene) -> Hidden | None:
    limits = np.full(s.arm.n, 1e6)
    axis = int(s.rng.integers(0, s.arm.n))
    rate = np.abs(np.gradient(s.moves.q, 1 / 24, axis=1))[:, :, axis] / s.moves.length.clip(1e-6)[:, None]
    used = (rate.max(axis=1) * s.moves.speed)[s.moving]
    limits[axis] = float(np.quantile(used, s.rng.uniform(0.5, 0.9)))
    if limits[axis] < _LEAST * s.arm.speeds[axis]:
        return None  # an axis that hardly turns
    return Hidden("joint-speed-limit", {"axis_speed": limits})


def _torque_speed(s: Scene) -> Hidden | None:
    return Hidden("torque-speed", {"weak": s.rng.uniform(0.3, 0.9), "knee": s.rng.uniform(0.1, 0.6)})


def _viscous(s: Scene) -> Hidden | None:
    return Hidden("viscous-friction", {"viscous": s.rng.uniform(0.1, 0.6)})


def _clamp(s: Scene) -> Hidden | None:
    fast = s.moves.speed[s.straight]
    if len(fast) < 25 or np.ptp(fast) <= 0:
        return None
    top = float(np.quantile(fast, s.rng.uniform(0.6, 0.95)))
    clamp = top * s.rng.uniform(0.6, 0.97)
    return Hidden("speed-clamp", {"clamp": clamp}, {"clamp": clamp})


def _orientation(s: Scene) -> Hidden | None:
    rate = (s.moves.turn / s.moves.length.clip(1e-6) * s.moves.speed)[s.straight]
    if len(rate) < 25 or np.quantile(rate, 0.9) < 0.1:
        return None
    omega = float(np.quantile(rate, s.rng.uniform(0.5, 0.9)))
    return Hidden("orientation-limit", {"omega": omega}, {"rate": omega})


def _cruise(s: Scene) -> Hidden:
    k = 1 + s.geometric(0.01, 0.15) * s.rng.choice([-1, 1])
    return Hidden("speed-scale", {"cruise" if s.rng.random() < 0.7 else "stretch": k}, {"scale": k})


def _settling(s: Scene) -> Hidden | None:
    t = s.geometric(0.01, 0.3)
    return Hidden("settling", {"settle": s.sim.settle + t}, {"time": t})


def _dispatch(s: Scene) -> Hidden:
    t = s.geometric(0.006, 0.15)
    return Hidden("dispatch", {"dispatch": s.sim.dispatch + t}, {"time": t})


def _blending(s: Scene) -> Hidden | None:
    if (s.moves.zone > 0).mean() < 0.12:
        return None
    return Hidden(
        "blending", {"blend": s.rng.uniform(0.3, 1.0) if s.sim.blend == 0 else s.rng.uniform(0, 0.5)}
    )


def _tick(s: Scene) -> Hidden:
    t = float(s.rng.choice([0.008, 0.012, 0.016, 0.024, 0.04]))
    return Hidden("cycle-quantisation", {"tick": t}, {"cycle": t})


def _warm(s: Scene) -> Hidden:
    total = float(seconds(s.moves, s.sim, s.arm).sum())
    share, tau = s.geometric(0.01, 0.15), total * s.rng.uniform(0.1, 0.5)
    return Hidden("warm-up", {"warm": share, "warm_time": tau}, {"share": share, "tau": tau})


def _external(s: Scene) -> Hidden | None:
    m = len(s.moves)
    if s.moves.cycle.max() > 0 and s.rng.random() < 0.7:
        hit = s.moves.line == s.rng.choice(s.moves.line)
    else:
        hit = s.rng.random(m) < s.rng.uniform(0.02, 0.07)
    if hit.sum() < 2:
        return None
    waits = np.where(hit, s.rng.exponential(s.geometric(0.1, 1.5), m) + 0.05, 0.0)
    return Hidden("external-wait", {"waits": waits}, only=hit)


EFFECTS: dict[str, Callable[[Scene], Hidden | None]] = {
    "acceleration": _acceleration, "jerk": _jerk, "gravity": _gravity, "reach-inertia": _reach, "payload": _payload,
    "payload-inertia": _payload_inertia, "joint-acceleration-limit": _axis_accel, "joint-speed-limit": _axis_speed,
    "torque-speed": _torque_speed, "viscous-friction": _viscous, "speed-clamp": _clamp, "speed-scale": _cruise,
    "orientation-limit": _orientation, "settling": _settling, "dispatch": _dispatch, "blending": _blending,
    "cycle-quantisation": _tick, "warm-up": _warm, "external-wait": _external,
}  # fmt: skip
_LEAST = 0.01  # of a rated speed, that an axis is limited to
_ROBOT = {"joint-acceleration-limit", "joint-speed-limit", "torque-speed", "viscous-friction"}
_LOCAL = ("acceleration", "speed-scale", "settling", "dispatch", "jerk")


def _outside(s: Scene, times: np.ndarray) -> tuple[str, np.ndarray]:
    """An effect that no name of the contract means, and its seconds (m,)."""
    m = len(times)
    which = str(s.rng.choice(["shortest block", "mains", "belt", "bus", "walk"]))
    moving = s.moving
    if which == "shortest block":
        floor = float(np.quantile(times[moving], s.rng.uniform(0.2, 0.4)))
        return which, np.where(moving, np.maximum(floor - times, 0), 0)
    if which == "mains":
        clock = np.cumsum(times) / times.sum()
        return which, moving * times * s.geometric(0.01, 0.08) * np.sin(
            2 * np.pi * (s.rng.uniform(2.5, 7) * clock + s.rng.random())
        )
    if which == "belt":
        way = s.moves.p[:, -1, 1] - s.moves.p[:, 0, 1]
        return which, moving * way * s.geometric(0.02, 0.2)
    if which == "bus":
        before = np.roll(s.moves.speed / s.moves.speed[moving].max(), 1)
        return which, moving * before**2 * s.geometric(0.02, 0.2)
    walk = np.cumsum(s.rng.normal(size=m))
    return which, moving * times * s.geometric(0.01, 0.06) * walk / np.abs(walk).max()


def _condition(s: Scene) -> tuple[str, np.ndarray]:
    """A part of the moves by place, load or job, as a phrase and a mask (m,)."""
    options = ["y", "z", "x"]
    if np.ptp(s.moves.payload[s.moving]) > 0:
        options.append("payload")
    which = str(s.rng.choice(options))
    if which == "payload":
        values = np.unique(s.moves.payload[s.moving])
        return "payload_kg", (s.moves.payload >= values[-1]) & s.moving
    k = "xyz".index(which)
    end = s.moves.p[:, -1, k]
    return f"{which}_end_mm", (end > np.quantile(end[s.moving], s.rng.uniform(0.5, 0.85))) & s.moving


@dataclass
class Recorder:
    """How durations become numbers in a file."""

    kind: str
    resolution: float
    jitter: float

    def noise(self) -> float:
        """Standard deviation of a recorded duration [s]."""
        double = 2 if self.kind == "stamps" else 1
        return float(np.sqrt(double * (self.resolution**2 / 12 + self.jitter**2)))

    def record(self, times: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Recorded durations (m,) [s]."""
        m = len(times)
        if self.kind == "stamps":
            edges = np.concatenate([[0], np.cumsum(times)]) + 17.3 + self.jitter * rng.normal(size=m + 1)
            return np.diff(np.round(edges / self.resolution) * self.resolution)
        draw = rng.normal(size=m)
        if self.kind == "heavy":
            draw = np.clip(rng.standard_t(2.5, size=m), -15, 15) / 1.6
        return np.maximum(np.round((times + self.jitter * draw) / self.resolution), 1) * self.resolution


def _recorder(rng: np.random.Generator) -> Recorder:
    kind = str(rng.choice(["plain", "plain", "stamps", "heavy"]))
    resolution = float(rng.choice([0.001, 0.001, 0.004, 0.01, 0.01, 0.012]))
    return Recorder(kind, resolution, float(rng.choice([0.0003, 0.001, 0.002, 0.004, 0.008])))


def generate(folder: Path, seed: int, count: int) -> None:
    """Writes `count` cases: FOLDER/cases/NAME with the recording and FOLDER/truth/NAME.json."""
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    for k in range(count):
        name = f"c{k:03d}"
        rng = np.random.default_rng([seed, k])
        while True:
            try:
                truth = _case(rng, folder / "cases" / name, _TYPES[int(rng.integers(len(_TYPES)))])
                break
            except _AgainError:
                continue
        (folder / "truth" / f"{name}.json").write_text(json.dumps(truth, indent=1))


class _AgainError(Exception):
    """The draw is not possible in this cell."""


def _case(rng: np.random.Generator, folder: Path, sort: str) -> dict[str, object]:
    arms = all_arms()
    arm = arms[int(rng.integers(len(arms)))]
    arm.tool = float(rng.choice([0, 0.12, 0.25]))
    program = str(rng.choice(list(PROGRAMS)))
    acceleration = float(np.round(np.exp(rng.uniform(np.log(0.8), np.log(6))), 1))
    try:
        moves = write_program(
            rng, arm, program, int(rng.integers(70, 230)), acceleration, float(rng.choice([0.5, 1.0, 1.0]))
        )
    except RuntimeError as error:
        raise _AgainError from error
    if not 60 <= len(moves) <= 260 or (moves.kind != WAIT).sum() < 45:
        raise _AgainError
    override = float(rng.choice([1, 1, 1, 1, 0.8, 0.5]))
    moves.override[:] = override
    confounded = sort in ("single", "two") and rng.random() < 0.2
    if confounded:
        lines = np.flatnonzero(moves.kind == LINEAR)
        climb = np.abs(moves.p[lines, -1, 2] - moves.p[lines, 0, 2]) + moves.payload[lines] / arm.payload
        moves.speed[lines[np.argsort(climb)]] = np.sort(moves.speed[lines])[::-1]
    sim = World(
        ramp=float(rng.choice([0, 0, 0.04, 0.08])),
        settle=float(rng.choice([0, 0, 0.05])),
        blend=float(rng.choice([0, 1])),
    )
    scene = Scene(rng, moves, arm, sim, acceleration)
    recorder = _recorder(rng)
    simulated = seconds(moves, sim, arm)
    hidden, real, rate, note = _hide(scene, sort, recorder.noise(), simulated)
    required, allowed, power = _worth(scene, hidden, real, simulated, recorder.noise())
    if sort == "clock":
        required = ["clock"]
    if hidden and not required:
        raise _AgainError
    recorded = recorder.record(real * rate, rng)
    first = int(rng.choice([0, 1, 100]))
    known = bool({h.term for h in hidden} & _ROBOT) or rng.random() < 0.5
    shown = {h.term for h in hidden}
    if sort == "somewhere":  # the column that the condition is of
        shown.add("payload" if note == "payload_kg" else "gravity")
    _write(folder, scene, recorded, simulated, real * rate, known, shown, recorder, first)
    effects = []
    for h in hidden:
        without = _real(scene, [o for o in hidden if o is not h])
        moved = [int(i) + first for i in np.flatnonzero(np.abs(real - without) > 2 * recorder.noise())]
        effects.append({"term": h.term, "moves": moved, "numbers": h.numbers, "power": power[h.term]})
    if sort == "clock":
        effects = [
            {
                "term": "clock",
                "moves": list(range(first, first + len(moves))),
                "numbers": {"rate": rate},
                "power": 0.0,
            }
        ]
    if sort == "outside":
        effects = [{"term": note, "moves": [], "numbers": {}, "power": 0.0}]
    return {
        "family": sort, "program": program, "arm": arm.name, "robot_named": known, "moves": len(moves), "note": note,
        "confounded": confounded, "condition": note if sort == "somewhere" else None, "optional": allowed,
        "equivalents": {e["term"]: [] for e in effects}, "effects": effects, "noise_s": recorder.noise(),
        "recorder": recorder.kind, "resolution_s": recorder.resolution, "jitter_s": recorder.jitter,
        "sim": {"ramp": sim.ramp, "settle": sim.settle, "blend": sim.blend},
        "change": {h.term: {k: np.asarray(v).tolist() for k, v in h.change.items() if k != "waits"} for h in hidden},
        "rmse_s": float(np.sqrt(np.mean((real * rate - simulated) ** 2))),
    }  # fmt: skip


def _hide(
    s: Scene, sort: str, noise: float, simulated: np.ndarray
) -> tuple[list[Hidden], np.ndarray, float, str]:
    """Hidden effects of a sort of case, the real durations (m,), the recorder's rate, a note."""
    rng = s.rng
    if sort == "nothing":
        return [], simulated, 1.0, ""
    if sort == "clock":
        rate = 1 + s.geometric(0.005, 0.04) * rng.choice([-1, 1])
        if ((simulated * (rate - 1)) ** 2).sum() / noise**2 < 80:
            raise _AgainError
        return [], simulated, rate, "clock"
    if sort == "outside":
        which, extra = _outside(s, simulated)
        if (extra**2).sum() / noise**2 < 200:
            raise _AgainError
        return [], simulated + extra, 1.0, which
    if sort == "somewhere":
        label, mask = _condition(s)
        if not 5 <= mask.sum() <= 0.6 * s.moving.sum():
            raise _AgainError
        effect = _drawn(s, str(rng.choice(_LOCAL)), noise, simulated, mask)
        return [effect], _real(s, [effect]), 1.0, label
    if sort == "cancelled":
        names = [
            str(rng.choice(["jerk", "settling", "dispatch", "gravity", "payload", "reach-inertia"])),
            "acceleration",
        ]
        first = _drawn(s, names[0], noise, simulated)
        low, high = 0.5, 4.0
        for _ in range(30):
            middle = (low * high) ** 0.5
            tuned = Hidden("acceleration", {"accel": middle}, {"scale": middle})
            low, high = (middle, high) if _real(s, [first, tuned]).sum() > simulated.sum() else (low, middle)
        if not 0.6 < middle < 3:
            raise _AgainError
        return _numbered([first, tuned]), _real(s, [first, tuned]), 1.0, "cancelled"
    names = list(EFFECTS)
    first = _drawn(s, str(rng.choice(names)), noise, simulated)
    effects = [first]
    if sort == "two":
        others = [n for n in names if n != first.term and n != "cycle-quantisation"]
        effects.append(_drawn(s, str(rng.choice(others)), noise, simulated))
        effects.sort(key=lambda h: h.only is None)
    return _numbered(effects), _real(s, effects), 1.0, ""


def _numbered(effects: list[Hidden]) -> list[Hidden]:
    """The effects with the numbers that they have together: an acceleration that is another one builds up in the same
    time, so that its jerk is, too."""
    scale = float(np.prod([h.change.get("accel", 1.0) for h in effects]))
    for h in effects:
        if "jerk" in h.numbers:
            h.numbers["jerk"] *= scale
    return effects


def _drawn(
    s: Scene, term: str, noise: float, simulated: np.ndarray, mask: np.ndarray | None = None
) -> Hidden:
    """The draw of a term whose power is nearest to one drawn between subtle and large."""
    wanted = np.exp(s.rng.uniform(np.log(80), np.log(3e5)))
    best: tuple[float, Hidden] | None = None
    for _ in range(8):
        effect = EFFECTS[term](s)
        if effect is None:
            raise _AgainError
        if mask is not None:
            effect.only = mask
        power = ((_real(s, [effect]) - simulated) ** 2).sum() / noise**2
        off = abs(np.log(max(power, 1e-9) / wanted))
        if power > 50 and (best is None or off < best[0]):
            best = (off, effect)
    if best is None:
        raise _AgainError
    return best[1]


def _real(s: Scene, effects: list[Hidden]) -> np.ndarray:
    """Real durations (m,): effects of all moves at once; one under a condition in its moves alone."""
    world = replace(
        s.sim, **{k: v for h in effects if h.only is None or "waits" in h.change for k, v in h.change.items()}
    )
    times = seconds(s.moves, world, s.arm)
    for h in effects:
        if h.only is not None and "waits" not in h.change:
            local = seconds(s.moves, replace(world, **h.change), s.arm)
            times = np.where(h.only, local, times)
    return times


def _worth(
    s: Scene, hidden: list[Hidden], real: np.ndarray, simulated: np.ndarray, noise: float
) -> tuple[list[str], list[str], dict[str, float]]:
    """Terms that must be found, that may be, and the power of each beside the others."""
    power = {}
    for h in hidden:
        others = [o for o in hidden if o is not h]
        power[h.term] = float(((real - _real(s, others)) ** 2).sum() / noise**2)
    return [t for t, p in power.items() if p >= 40], [t for t, p in power.items() if p < 40], power


def _write(
    folder: Path,
    s: Scene,
    recorded: np.ndarray,
    simulated: np.ndarray,
    real: np.ndarray,
    known: bool,
    terms: set[str],
    recorder: Recorder,
    first: int,
) -> None:
    """The recording in one of the contract's many dresses."""
    rng, moves, arm = s.rng, s.moves, s.arm
    folder.mkdir(parents=True, exist_ok=True)
    m, waiting = len(moves), moves.kind == WAIT
    table: dict[str, object] = {"move": np.arange(m) + first}
    turning = (moves.kind == JOINT).sum()  # axes alone tell how far a joint move goes
    gives_joints = bool(terms & (_ROBOT | {"payload-inertia"})) or bool(turning > 0.5 * m)
    gives_joints = gives_joints or rng.random() < (0.7 if turning else 0.25)
    gives_tool = not (
        gives_joints
        and (moves.kind[~waiting] == JOINT).all()
        and rng.random() < 0.4
        and not terms & {"gravity", "reach-inertia"}
    )
    mixed = len(set(moves.kind)) > 1 or bool(gives_tool and (moves.kind == JOINT).any())
    if mixed or rng.random() < 0.85:
        table["type"] = np.array(_KINDS)[moves.kind]
    hidden = np.where(waiting, np.nan, 1.0)
    if gives_tool:
        for word, p in (("start", moves.p[:, 0]), ("end", moves.p[:, -1])):
            for i, axis in enumerate("xyz"):
                table[f"{axis}_{word}_mm"] = np.round(p[:, i] * 1e3, 3) * hidden
        if "orientation-limit" in terms or terms & _ROBOT or rng.random() < 0.6:
            for word, r in (("start", moves.start), ("end", moves.end)):
                angles = euler(r)
                for i, axis in enumerate("xyz"):
                    table[f"r{axis}_{word}_deg"] = np.round(angles[:, i], 4) * hidden
        if (moves.kind == CIRCULAR).any():
            for i, axis in enumerate("xyz"):
                table[f"{axis}_via_mm"] = np.round(moves.via[:, i] * 1e3, 3)
    if gives_joints:
        for word, k in (("start", 0), ("end", -1)):
            for i in range(arm.n):
                unit, scale = ("mm", 1e3) if arm.slides[i] else ("deg", 180 / np.pi)
                table[f"q{i + 1}_{word}_{unit}"] = np.round(moves.q[:, k, i] * scale, 4) * hidden
    straight = s.straight
    if straight.any():
        table["speed_mm_s"] = np.where(straight, np.round(moves.speed * 1e3, 2), np.nan)
    if (moves.kind == JOINT).any():
        table["speed_pct"] = np.round(moves.percent, 2)
    if straight.any() and rng.random() < 0.7:
        table["accel_mm_s2"] = np.where(straight, np.round(moves.accel * 1e3, 1), np.nan)
    if (moves.zone > 0).any():
        table["blend_mm"] = np.round(moves.zone * 1e3, 2)
    if "payload" in terms or "payload-inertia" in terms or (moves.payload.any() and rng.random() < 0.6):
        table["payload_kg"] = np.round(moves.payload, 3)
    if "payload-inertia" in terms or (moves.inertia.any() and rng.random() < 0.3):
        table["payload_inertia_kg_m2"] = np.round(moves.inertia, 5)
    if moves.override[0] != 1:
        table["override_pct"] = moves.override * 100
        if rng.random() < 0.5:
            table["sim_override_pct"] = moves.override * 100
    table["sim_s"] = np.round(simulated, int(rng.choice([3, 3, 4])))
    duration = np.round(recorded, 6)
    if rng.random() < 0.1:
        duration[rng.random(m) < 0.06] = np.nan
    table["duration_s"] = duration
    if "warm-up" in terms or rng.random() < 0.5:
        table["t_start_s"] = np.round(np.cumsum(real) - real + 5.0, 3)
    if moves.cycle.max() > 0 and rng.random() < 0.7:
        table["cycle"] = moves.cycle
    if "external-wait" in terms or rng.random() < 0.5:
        table["job"] = "MAIN.PRG"
        table["line"] = moves.line
    if rng.random() < 0.3:
        table["temperature_c"] = np.round(
            21 + 4 * (1 - np.exp(-np.arange(m) / 60)) + 0.2 * rng.normal(size=m), 1
        )
    if rng.random() < 0.2:
        table["batch"] = rng.integers(1, 5, m)
    if rng.random() < 0.2:
        table["operator"] = np.array(["Ada", "Bo", "Cy"])[rng.integers(0, 3, m)]
    frame = pd.DataFrame(table)
    order = list(rng.permutation(frame.columns)) if rng.random() < 0.3 else list(frame.columns)
    dress = str(rng.choice(["plain"] * 6 + ["gz", "tab", "semicolon"]))
    if dress == "semicolon":
        text = frame[order].to_csv(index=False, sep=";", decimal=",")
    else:
        text = frame[order].to_csv(index=False, sep="\t" if dress == "tab" else ",")
    if dress == "gz":
        (folder / "moves.csv.gz").write_bytes(gzip.compress(text.encode(), mtime=0))
    else:
        (folder / "moves.csv").write_text(text)
    toml = []
    if known:
        toml.append(f'robot = "{arm.library or "arm.toml"}"')
        if not arm.library:
            (folder / "arm.toml").write_text(arm.toml())
        if arm.tool:
            toml.append(f"tool = [0.0, 0.0, {arm.tool * 1e3:.1f}, 0.0, 0.0, 0.0]")
    if rng.random() < 0.6:
        toml.append(f"time_resolution_s = {recorder.resolution}")
    if toml:
        (folder / "recording.toml").write_text("\n".join(toml) + "\n")
