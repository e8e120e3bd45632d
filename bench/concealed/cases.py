"""Cases: a program, what is hidden in it, the simulation that lacks it, the recording, and the sealed answer."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.concealed.arms import random_arm
from bench.concealed.effects import Hidden, World, play
from bench.concealed.families import FAMILIES, Recipe, recipe
from bench.concealed.identical import substitutes
from bench.concealed.programs import random_moves
from bench.concealed.terms import KINDS, hidden_for, parameter, plan_for

Floats = NDArray[np.float64]
RESOLUTIONS = (0.0005, 0.001, 0.002, 0.004, 0.005, 0.008, 0.01, 0.02)


@dataclass(slots=True)
class Case:
    """`parts`: seconds per move that each hidden effect adds, with the others there. All times (n,) [s]."""

    name: str
    recipe: Recipe
    world: World
    hidden: list[Hidden]
    parts: dict[str, Floats]
    simulated: Floats
    real: Floats
    measured: Floats
    resolution: float
    noise: float  # [s] standard deviation of what the recorder adds
    answer: dict[str, Any]
    dice: np.random.Generator


def schedule(count: int) -> list[tuple[int, tuple[str, int]]]:
    """[(index, (family, how many of it came before))]: any first part of it has the same shares."""
    given = dict.fromkeys(FAMILIES, 0)
    total = sum(FAMILIES.values())
    result = []
    for index in range(count):
        family = min(
            FAMILIES, key=lambda f: ((given[f] + 0.5) * total / FAMILIES[f], list(FAMILIES).index(f))
        )
        result.append((index, (family, given[family])))
        given[family] += 1
    return result


def make(seed: int, index: int, family: str, turn: int, moves: int = 0) -> Case:
    """One case, of `moves` moves if it says so; the same numbers make the same case."""
    for attempt in range(40):
        dice = np.random.default_rng([seed, index, attempt])
        wish = recipe(dice, family, turn + attempt // 10)
        wish = replace(wish, moves=moves) if moves else wish
        case = _try(dice, f"{index:04d}-{family}", wish, family)
        if case is not None:
            return case
    raise RuntimeError(f"case {index} of seed {seed} ({family}) cannot be made")


def _try(dice: np.random.Generator, name: str, wish: Recipe, family: str) -> Case | None:
    arm = random_arm(dice)
    plan = plan_for(dice, list(wish.terms), wish.moves, wish.rich)
    plan = wish.shape(plan) if wish.shape else plan
    moves = random_moves(dice, arm, plan)
    wish.change(dice, moves) if wish.change else None
    world = World(moves, plan.acceleration)
    if "blending" in wish.terms:
        world.corners = str(dice.choice(["stop", "stop", "fly"])) if family != "cancelled" else "stop"
    resolution, noise = _recorder(dice, plan.cycles > 1)
    hidden: list[Hidden] = []
    for term, size in _fixed_first(wish):
        effect = hidden_for(dice, term, world)
        effect = wish.adjust(dice, world, effect) if wish.adjust else effect
        found = _sized(world, effect, size * noise, wish.rare)
        if found is None:
            return None
        if KINDS[term].low == KINDS[term].high:
            # It is as large as it is: the recorder is chosen to fit.
            part = play(world, [found]) - play(world, [], [found])
            resolution, noise = _finer(resolution, noise, _rms(part, wish.rare) / noise / size)
        hidden.append(found)
    world, hidden = _tuned(world, hidden, wish)
    if hidden is None or world is None:
        return None
    parts = _parts(world, hidden)
    simulated = play(world, [], hidden)
    real = play(world, hidden)
    if real.min() < 0.005 or (real[moves.kind != 2] < 0.3 * simulated[moves.kind != 2]).any():
        return None
    # A recorder with a coarser or finer clock, where the effect cannot be made as large as was wished.
    size = max((_rms(p, wish.rare) for p in parts.values()), default=0.0) / noise
    wished = max(wish.sizes, default=0.0)
    if wished and not 0.5 < size / wished < 2 and not wish.tune:
        resolution, noise = _finer(resolution, noise, size / wished)
        size = max(_rms(p, wish.rare) for p in parts.values()) / noise
        if not 0.4 < size / wished < 2.5:
            return None
    if wish.rare and not _few_enough(parts, noise):
        return None
    if not all(map(_often_enough, parts.values())):
        return None
    scatter = np.sqrt(max(noise**2 - resolution**2 / 12, 0.0))
    measured = np.round((real + dice.normal(0, scatter, len(real))) / resolution) * resolution
    measured = np.maximum(measured, resolution)
    answer = _answer(world, hidden, parts, noise, wish, family)
    return Case(name, wish, world, hidden, parts, simulated, real, measured, resolution, noise, answer, dice)


def _few_enough(parts: dict[str, Floats], noise: float) -> bool:
    """Few moves, and yet more than one could put down to chance."""
    return all(
        (np.abs(p) > 2 * noise).sum() >= 4 and (np.abs(p) > 1e-3 * noise).mean() < 0.3 for p in parts.values()
    )


def _often_enough(part: Floats) -> bool:
    """An effect in fewer moves than four is what a wait looks like as well, whatever its size."""
    return int((np.abs(part) > 0.05 * max(np.abs(part).max(), 1e-12)).sum()) >= 4


def _fixed_first(wish: Recipe) -> list[tuple[str, float]]:
    both = zip(wish.terms, wish.sizes, strict=True)
    return sorted(both, key=lambda b: KINDS[b[0]].low < KINDS[b[0]].high)


def _recorder(dice: np.random.Generator, repeats: bool) -> tuple[float, float]:
    """Resolution and standard deviation of all noise [s]. Scatter can only be known where moves are repeated."""
    resolution = float(dice.choice(RESOLUTIONS[1:7]))
    scatter = resolution * (dice.uniform(0.3, 1.2) if repeats else dice.uniform(0.05, 0.15))
    return resolution, float(np.hypot(scatter, resolution / np.sqrt(12)))


def _finer(resolution: float, noise: float, ratio: float) -> tuple[float, float]:
    wanted = resolution * ratio
    best = min((0.0001, 0.0002, *RESOLUTIONS, 0.05), key=lambda r: abs(np.log(r / wanted)))
    return best, noise * best / resolution


def _rms(part: Floats, rare: bool) -> float:
    acts = np.abs(part) > 0.05 * max(np.abs(part).max(), 1e-12)
    chosen = part[acts] if rare and acts.any() else part
    return float(np.sqrt(np.mean(chosen**2)))


def _sized(world: World, effect: Hidden, goal: float, rare: bool) -> Hidden | None:
    """The strength at which the effect alone changes durations by `goal` [s], or the nearest that it can be."""
    kind = KINDS[effect.term]
    start = play(world, [], [effect])

    def size(strength: float) -> float:
        return _rms(play(world, [effect._replace(strength=strength)]) - start, rare)

    least = kind.low
    while least > kind.low / 300 and kind.low < kind.high and size(least) > goal:
        least /= 4
    low, high = np.log(least), np.log(kind.high)
    if size(kind.high) < goal:
        return effect._replace(strength=kind.high) if size(kind.high) > 1e-4 else None
    if size(least) > goal:
        return effect._replace(strength=least)
    for _ in range(12):
        mid = (low + high) / 2
        if size(float(np.exp(mid))) < goal:
            low = mid
        else:
            high = mid
    return effect._replace(strength=float(np.exp((low + high) / 2)))


def _tuned(world: World, hidden: list[Hidden], wish: Recipe) -> tuple[World | None, list[Hidden] | None]:
    """The simulation as somebody calibrated it: by its acceleration or its speed, on the mean or on every move."""
    if not wish.tune:
        return world, hidden
    what, how = wish.tune
    real = play(world, hidden)
    start = play(world, [], hidden)

    def miss(factor: float) -> float:
        gap = real - _simulate(world, hidden, what, factor)
        return float(abs(gap.mean()) if how == "mean" else (gap**2).mean())

    grid = np.exp(np.linspace(np.log(0.25), np.log(4), 25))
    values = [miss(f) for f in grid]
    k = int(np.argmin(values))
    if k in (0, len(grid) - 1):
        return None, None
    low, high = grid[k - 1], grid[k + 1]
    for _ in range(30):
        x, y = low + 0.382 * (high - low), high - 0.382 * (high - low)
        low, high = (low, y) if miss(x) < miss(y) else (x, high)
    factor = (low + high) / 2
    if abs((real - start).mean()) < 1e-9:
        return None, None
    # Seen from the tuned simulation the robot has another acceleration, or another speed.
    sign, strength = (-1.0, 1 / factor - 1) if factor < 1 else (1.0, factor - 1)
    if what == "acceleration":
        world = replace(world, acceleration=world.acceleration * factor)
        return world, [Hidden("acceleration", strength, choice=sign), *hidden]
    world.simulated_speed = factor
    return world, [Hidden("speed-scale", strength, choice=sign), *hidden]


def _simulate(world: World, hidden: list[Hidden], what: str, factor: float) -> Floats:
    if what == "acceleration":
        tuned = replace(world, acceleration=world.acceleration * factor)
        tuned.bodies = world.bodies
        return play(tuned, [], hidden)
    tuned = replace(world)
    tuned.simulated_speed = factor
    tuned.bodies = world.bodies
    return play(tuned, [], hidden)


def _parts(world: World, hidden: list[Hidden]) -> dict[str, Floats]:
    whole = play(world, hidden)
    return {h.term: whole - play(world, [g for g in hidden if g is not h], hidden) for h in hidden}


def _answer(
    world: World, hidden: list[Hidden], parts: dict[str, Floats], noise: float, wish: Recipe, family: str
) -> dict[str, Any]:
    """What the scorer compares with. Only it opens it."""
    terms = [h.term for h in hidden if h.term != "outside"]
    same, near, unseen = substitutes(world, hidden, parts, noise) if terms else ({}, {}, [])
    size = {t: _rms(p, wish.rare) / noise for t, p in parts.items()}
    required = [t for t in terms if t not in unseen and size[t] >= 0.35 and family not in ("noise", "clock")]
    return {
        "family": family,
        "count": len(world.moves),
        "hidden": terms,
        "required": required,
        "allowed": [t for t in terms if t not in required],
        "same": same,
        "near": near,
        "unseen": unseen,
        "size": size,
        "rms_s": {t: float(np.sqrt(np.mean(p**2))) for t, p in parts.items()},
        "noise_floor_s": noise,
        "poor": not wish.rich,
        "confounded_with": wish.note,
        "body": {h.term: h.body for h in hidden},
        "strength": {h.term: h.strength for h in hidden},
        "choice": {h.term: h.choice for h in hidden},
        "parameters": {h.term: parameter(h.term, h, world, "acceleration" in terms) for h in hidden},
        "moves": {t: _acting(p, noise) for t, p in parts.items()},
        "simulation": {"acceleration_m_s2": world.acceleration, "corners": world.corners, "tuned": wish.tune},
    }


def _acting(part: Floats, noise: float) -> dict[str, list[int]]:
    """Rows in which an effect acts for certain, and in which it acts less than the noise shows."""
    much = np.abs(part) > 2 * noise
    little = (np.abs(part) > 1e-3 * noise) & ~much
    return {"acts": np.nonzero(much)[0].tolist(), "little": np.nonzero(little)[0].tolist()}
