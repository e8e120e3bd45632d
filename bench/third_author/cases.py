"""Draws cases: a cell, what is hidden in it, a recorder; writes recordings, and the truth beside them."""

import itertools
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from bench.third_author.arms import ARMS, euler
from bench.third_author.cells import CELLS, make_moves
from bench.third_author.effects import EFFECTS, OUTSIDE, World, override
from bench.third_author.plant import Drive, seconds, trapezoid
from bench.third_author.recorders import KINDS, record

FAMILIES = {
    "one": 0.36,
    "two": 0.14,
    "three": 0.05,
    "tuned": 0.1,
    "somewhere": 0.14,
    "nothing": 0.12,
    "outside": 0.09,
}
SOMEWHERE = (
    "acceleration",
    "jerk",
    "speed-scale",
    "settling",
    "dispatch",
    "speed-clamp",
    "gravity",
    "payload",
)
UNTUNED = ("acceleration", "clock", "external-wait", "override", "coulomb-friction", "speed-scale")
TWO_WAYS = ("acceleration", "speed-scale", "clock", "reach-inertia")  # of which the options choose one
EVERYWHERE = EFFECTS | {"override": override}
CLEAR = 3.0  # an effect's RMS over the moves, in noises
APART = 1.5  # the same of what no other effect of the case can take over
SHIFTS = (
    "reach-inertia",
    "payload",
)  # laws that are right somewhere: an acceleration beside them is where that is
ALIKE = 8.0  # square of what parts two causes, in noises: less is an honest equivalent


@dataclass
class Hidden:
    """A whole case before it is recorded: effects with their strengths, and the moves in which they act."""

    world: World
    names: list[str]
    strengths: list[float]
    where: list[np.ndarray]
    condition: str | None = None

    def numbers(self) -> list[dict[str, float]]:
        """Of each effect, in the drive that the effects before it leave: a share of the fastest is one of theirs."""
        drive, found = self.world.drive, []
        for name, strength, where in zip(self.names, self.strengths, self.where, strict=True):
            after, _, numbers = (EVERYWHERE | OUTSIDE)[name](self.world, strength, drive)
            if after is not drive:
                drive = after if where.all() else after.only(where, drive)
            found.append(numbers)
        return found

    def total(self, replaced: dict[int, tuple[str, float] | None] | None = None) -> np.ndarray:
        """True durations [s], with some of the effects replaced (by None: left out)."""
        drive, extra = self.world.drive, 0.0
        for i, own in enumerate(zip(self.names, self.strengths, strict=True)):
            chosen = (replaced or {}).get(i, own)
            if chosen is not None:
                name, strength = chosen
                after, late, _ = (EVERYWHERE | OUTSIDE)[name](self.world, strength, drive)
                if after is not drive:
                    drive = after if self.where[i].all() else after.only(self.where[i], drive)
                extra = extra + late * self.where[i]
        changed = 0.0 if drive is self.world.drive else seconds(drive) - self.world.integrated
        return self.world.simulated + changed + extra


def draw(
    rng: np.random.Generator, wanted: str | None = None, count: int | None = None
) -> tuple[Hidden, str, str, float]:
    """A fair case: its effects, family, recorder and noise [s]; whatever is too small is drawn again. `wanted` family
    and `count` of moves: drawn, too, where they are not said."""
    family = str(rng.choice(list(FAMILIES), p=list(FAMILIES.values())))
    family = wanted or family
    recorder = str(rng.choice(KINDS))
    sigma = float(10 ** rng.uniform(-3.2, -2.4))
    noise = {"digits": 0.0031, "grid": 0.005}.get(recorder, sigma)
    while True:
        hidden = _attempt(rng, family, count)
        if hidden is not None and _fair(hidden, noise):
            return hidden, family, recorder, sigma


def _attempt(rng, family: str, size: int | None) -> Hidden | None:
    arm = ARMS[rng.integers(len(ARMS))]
    cell = str(rng.choice(list(CELLS)))
    try:
        moves = make_moves(rng, arm, cell, size or int(rng.integers(100, 230)))
    except ValueError:
        return None
    options = {
        "weaker": float(rng.random() < 0.7), "planned": float(rng.random() < 0.4),
        "told": float(rng.choice([0, 0, 0.5, 1])),
        "axis": float(rng.integers(12)), "braking": float(rng.random() < 0.7), "corner": float(rng.choice([0.5, 1.0])),
        "warm": rng.uniform(0.1, 0.4), "seed": float(rng.integers(1 << 30)),
    }  # fmt: skip
    world = World(moves, options, np.zeros(len(moves)))
    world.starts = np.append(0.0, np.cumsum(world.simulated + 0.05)[:-1])
    count = {"two": 2, "three": 3, "nothing": 0}.get(family, 1)
    pool = {"outside": list(OUTSIDE), "somewhere": list(SOMEWHERE)}.get(family, list(EVERYWHERE))
    if family == "tuned":
        pool = [name for name in pool if name not in UNTUNED]
    if family in ("two", "three"):
        pool = [name for name in pool if name not in ("clock", "override", "cycle-quantisation")]
    names = [str(name) for name in rng.choice(pool, count, replace=False)]
    condition, where = None, np.ones(len(moves), bool)
    if family == "somewhere":
        condition, where = _condition(rng, world)
    hidden = Hidden(world, names, list(rng.uniform(0.25, 1, count)), [where] * count, condition)
    for _ in range(2):  # the running time is that of the real arm
        world.starts = np.append(0.0, np.cumsum(hidden.total() + 0.05)[:-1])
    return hidden


def _condition(rng, world: World) -> tuple[str, np.ndarray]:
    """A part of the moves: downwards, in a region, after a time, in one job, at one line."""
    moves = world.moves
    first, last = moves.points[:, 0], moves.points[:, -1]
    kind = rng.choice(["downwards", "region", "after", "job", "line"])
    if kind == "downwards":
        drop = first[:, 2] - last[:, 2]
        return "going down", drop > 0.7 * np.linalg.norm(last - first, axis=1)
    if kind == "region":
        axis = int(rng.integers(2))
        border = np.quantile(last[:, axis], rng.uniform(0.55, 0.8))
        return f"ends with {'xy'[axis]} > {1000 * border:.0f} mm", last[:, axis] > border
    if kind == "after":
        time = rng.uniform(0.35, 0.75) * world.starts[-1]
        return f"after {time:.0f} s", world.starts > time
    if kind == "job":
        job = rng.choice(np.unique(moves.jobs))
        return f"job {job}", moves.jobs == job
    place = rng.integers(len(moves))
    job, line = moves.jobs[place], moves.lines[place]
    return f"line {job}:{line}", (moves.jobs == job) & (moves.lines == line)


def _fair(hidden: Hidden, noise: float) -> bool:
    """Whether each effect is large enough to be seen, alone and beside the others."""
    if not hidden.names:
        return True
    whole = hidden.total()
    if not np.isfinite(whole).all() or (whole[~hidden.world.waits] < 0.02).any():
        return False
    parts = np.column_stack([whole - hidden.total({i: None}) for i in range(len(hidden.names))])
    for i, part in enumerate(parts.T):
        acts = np.abs(part) > 0.5 * noise
        spread = part[hidden.where[i] & ~hidden.world.waits]
        if (
            acts.sum() < 10
            or np.sqrt(np.mean(spread**2)) < CLEAR * noise
            or np.abs(part).sum() > 0.5 * whole.sum()
        ):
            return False
        if hidden.condition and not 0.03 < acts.mean() < 0.6:
            return False
        others = np.delete(parts, i, axis=1)
        if others.size:
            left = part - others @ np.linalg.lstsq(others, part, rcond=None)[0]
            if np.sqrt(np.mean(left**2)) < APART * noise:
                return False
    return len(hidden.names) < 2 or not _fewer(hidden, noise)


def _fewer(hidden: Hidden, noise: float) -> bool:
    """Whether one effect less, at another strength, gives nearly the same durations."""
    whole = hidden.total()
    for i in range(len(hidden.names)):
        for j in range(len(hidden.names)):
            grid = [] if i == j else np.linspace(0.05, 1.3, 16)
            found = [hidden.total({i: None, j: (hidden.names[j], s)}) - whole for s in grid]
            if found and min(np.sum(d**2) for d in _between(found)) < 40 * noise**2:
                return True
    return False


def _between(curves: list[np.ndarray]) -> Iterator[np.ndarray]:
    """The curves, and the smallest between each two neighbours."""
    yield from curves
    for a, b in itertools.pairwise(curves):
        way = b - a
        yield a + np.clip(-(a @ way) / max(way @ way, 1e-18), 0, 1) * way


def equivalents(hidden: Hidden, noise: float) -> dict[str, list[str]]:
    """Of each effect, the others that would give nearly the same durations at some strength and sign."""
    whole, found = hidden.total(), {}
    for i, name in enumerate(hidden.names):
        if name in OUTSIDE:
            continue
        found[name] = []
        for rival in EVERYWHERE:
            if rival in hidden.names:
                continue
            curves = []
            kept = dict(hidden.world.options)
            for weaker in (0.0, 1.0) if rival in TWO_WAYS else (1.0,):
                hidden.world.options["weaker"] = weaker
                curves += [hidden.total({i: (rival, s)}) for s in np.linspace(0.02, 1.3, 10)]
            hidden.world.options.update(kept)
            curves = [np.nan_to_num(c, nan=1e3) - whole for c in curves]
            if min(np.sum(d**2) for d in _between(curves)) < ALIKE * noise**2:
                found[name].append(rival)
    return found


def _tuned(rng, hidden: Hidden, whole: np.ndarray) -> tuple[np.ndarray, np.ndarray, str, float]:
    """The simulation's acceleration or speed is turned until the mean is right: what it says, its rows, the number."""
    world = hidden.world
    name = str(rng.choice(["acceleration", "acceleration", "speed-scale"]))
    low, high = 0.3, 3.0
    for _ in range(50):
        factor = np.sqrt(low * high)
        drive = _scaled(world, name, factor)
        slow = np.sum(trapezoid(drive)[~world.waits]) > np.sum(whole[~world.waits])
        low, high = (factor, high) if slow else (low, factor)
    return np.where(world.waits, world.simulated, trapezoid(drive)), drive, name, factor


def _scaled(world: World, name: str, factor: float) -> Drive:
    key = "acceleration" if name == "acceleration" else "speed"
    return replace(world.drive, **{key: getattr(world.drive, key) * factor})


def write_case(
    folder: Path, rng: np.random.Generator, wanted: str | None = None, count: int | None = None
) -> dict:
    """Writes one recording into a folder, and returns its truth; `wanted` and `count` as in `draw`."""
    while True:
        hidden, family, recorder, sigma = draw(rng, wanted, count)
        whole = hidden.total()
        world = hidden.world
        simulated, drive, tuned, factor = world.simulated, world.drive, None, 1.0
        if family == "tuned":
            simulated, drive, tuned, factor = _tuned(rng, hidden, whole)
            clear = np.std((whole - simulated)[~world.waits]) > CLEAR * max(sigma, 0.003)
            if not (clear and 0.4 < factor < 2.5 and abs(np.log(factor)) > 0.05):
                continue
        break
    measured, resolution = record(rng, recorder, whole, sigma)
    measured = np.maximum(measured, 0.001)
    noise = float(np.sqrt(np.mean((measured - whole) ** 2)))
    table = _table(rng, hidden, measured, simulated, drive)
    folder.mkdir(parents=True)
    table.to_csv(folder / "moves.csv", index=False, float_format="%.6f")
    text = f'controller = "third"\n{f"time_resolution_s = {resolution}" if resolution else ""}\n'
    (folder / "recording.toml").write_text(text)
    parts = []
    for i, (name, numbers) in enumerate(zip(hidden.names, hidden.numbers(), strict=True)):
        late = whole - hidden.total({i: None})
        parts.append({
            "term": name, "strength": hidden.strengths[i], "numbers": numbers,
            "rms_s": float(np.sqrt(np.mean(late**2))),
            "moves": [int(m) for m in np.flatnonzero(np.abs(late) > 1e-6) + 1],
        })  # fmt: skip
    if tuned:
        parts.append({"term": tuned, "numbers": {"scale": 1 / factor}, "moves": None, "strength": factor})
    return {
        "family": family, "recorder": recorder, "sigma_s": sigma, "noise_s": noise, "arm": world.moves.arm.name,
        "condition": hidden.condition, "options": world.options, "effects": parts,
        "equivalents": equivalents(hidden, noise), "moves": len(table),
        "optional": ["acceleration"] if set(SHIFTS) & set(hidden.names) else [],
    }  # fmt: skip


def _table(rng, hidden: Hidden, measured, simulated, drive) -> pd.DataFrame:
    """The recording's columns; those that nothing hidden needs are there or not at random."""
    world, moves = hidden.world, hidden.world.moves
    needed, n = set(hidden.names), len(moves)
    joints = world.joint.any() or rng.random() < 0.3
    points = not (world.joint.all() and rng.random() < 0.3) or hidden.condition or "reach-inertia" in needed
    columns: dict[str, np.ndarray] = {"move": np.arange(1, n + 1), "duration_s": measured, "sim_s": simulated}
    columns["type"] = world.kind
    if points or "gravity" in needed:
        ends = {"start": moves.points[:, 0], "end": moves.points[:, -1]}
        for end, values in ends.items():
            columns |= {f"{axis}_{end}_mm": 1000 * values[:, i] for i, axis in enumerate("xyz")}
        if "orientation-limit" in needed or rng.random() < 0.8:
            for i, end in enumerate(ends):
                angles = np.degrees(euler(moves.rotations[:, i]))
                columns |= {f"r{axis}_{end}_deg": angles[:, k] for k, axis in enumerate("xyz")}
        if (world.kind == "circular").any():
            middle = 1000 * moves.points[:, moves.points.shape[1] // 2]
            circular = world.kind == "circular"
            columns |= {f"{a}_via_mm": np.where(circular, middle[:, i], np.nan) for i, a in enumerate("xyz")}
    if joints:
        for end, k in (("start", 0), ("end", -1)):
            columns |= {f"q{j + 1}_{end}_deg": np.degrees(moves.q[:, k, j]) for j in range(moves.arm.axes)}
    programmed = moves.column("speed")
    columns["speed_mm_s"] = np.where(world.lines, 1000 * drive.speed, np.nan)
    if world.joint.any():
        columns["speed_pct"] = np.where(
            world.joint, 100 * programmed * drive.speed / np.maximum(world.drive.speed, 1e-9), np.nan
        )
    if rng.random() < 0.7:
        columns["accel_mm_s2"] = np.where(world.lines, 1000 * drive.acceleration, np.nan)
        if world.joint.any():
            share = drive.acceleration / np.maximum(world.drive.acceleration, 1e-9)
            columns["accel_pct"] = np.where(world.joint, 100 * share, np.nan)
    columns["blend_mm"] = 1000 * world.blend
    if {"warm-up", "clock"} & needed or (hidden.condition or "").startswith("after") or rng.random() < 0.5:
        columns["t_start_s"] = np.append(0.0, np.cumsum(measured + 0.05)[:-1])
    if (
        (hidden.condition or "").startswith(("job", "line"))
        or "external-wait" in needed
        or rng.random() < 0.6
    ):
        columns |= {"job": moves.jobs, "line": moves.lines}
    if "override" not in needed and rng.random() < 0.5:
        columns["cycle"] = moves.cycles
    load = moves.column("load")
    if {"payload", "gravity"} & needed or rng.random() < 0.5:
        columns["payload_kg"] = load
    if ("payload" in needed and world.options["told"]) or rng.random() < 0.15:
        told = world.options["told"] if "payload" in needed else 0.0
        columns["sim_payload_kg"] = np.full(n, told * load.max())
    if "payload-inertia" in needed or rng.random() < 0.2:
        columns["payload_inertia_kg_m2"] = moves.column("spin")
    if "override" in needed:
        columns |= {"override_pct": world.percent, "sim_override_pct": np.full(n, 100.0)}
    elif rng.random() < 0.15:
        columns["override_pct"] = np.full(n, 100.0)
    if rng.random() < 0.3:
        columns["temperature_c"] = 31 + np.cumsum(rng.normal(0, 0.05, n))
    if rng.random() < 0.3:
        columns["supply_v"] = 400 + rng.normal(0, 1.5, n)
    return pd.DataFrame(columns)


def generate(folder: Path, seed: int, cases: int) -> None:
    """Writes cases/NN and truth/NN.json; each case has its own stream, so that its number alone decides it."""
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    for number in range(cases):
        rng = np.random.default_rng([seed, number])
        truth = write_case(folder / "cases" / f"{number:03d}", rng)
        (folder / "truth" / f"{number:03d}.json").write_text(json.dumps(truth, indent=1))
