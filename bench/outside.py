"""Recordings of robots whose hidden law is in no list, for `bench/made_up.py`: nothing may be named there.

    python bench/outside.py FOLDER [--seed 1] [--cases 24] && python bench/made_up.py FOLDER

A drive with constant acceleration between stops runs lines of several speeds, lengths and directions, some with rounded
ends, and one of nine laws changes its durations by a few percent: a drift that turns round, two time constants of
opposite sign, a random walk, heat of fast moves, alternating parts, a resonance with the duration, a tooth of the first
axis' gear, a batch that comes and goes, a slow oscillation. Every law has zero mean: nothing of it is a constant.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from made_up import make_cases
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SPEEDS = (0.1, 0.2, 0.3, 0.5, 0.8)  # [m/s]
PAUSE = 0.15  # [s] between moves


class Run(NamedTuple):
    """n moves as simulated; m, s and rad."""

    start: Floats  # (n, 3)
    end: Floats  # (n, 3)
    speed: Floats
    blend: Floats
    acceleration: float
    simulated: Floats
    begin: Floats  # [s] when each move starts

    @property
    def share(self) -> Floats:
        """(n,) 0 … 1 of the time of the run."""
        return np.asarray(self.begin / self.begin[-1])


def run_of(rng: np.random.Generator) -> Run:
    count = int(rng.integers(100, 320))
    stations = rng.uniform([0.5, -0.6, -0.1], [1.2, 0.6, 0.7], (int(rng.integers(5, 10)), 3))
    start = stations[rng.integers(len(stations), size=count)]
    towards = rng.normal(size=(count, 3))
    way = rng.uniform(0.06, 0.6, count)
    end = start + way[:, None] * towards / np.linalg.norm(towards, axis=1)[:, None]
    speed = rng.choice(rng.choice(SPEEDS, 4, replace=False), count)
    acceleration = rng.uniform(1.0, 3.0)
    peak = np.minimum(speed, np.sqrt(acceleration * way))
    simulated = way / peak + peak / acceleration
    begin = np.concatenate([[0.0], np.cumsum(simulated + PAUSE)[:-1]])
    blend = np.where(rng.random(count) < 0.4, rng.choice([0.005, 0.01, 0.02], count), 0.0)
    return Run(start, end, speed, blend, acceleration, simulated, begin)


def turns_round(run: Run, rng: np.random.Generator) -> Floats:
    """A drift up, and down again."""
    top = rng.uniform(0.3, 0.7)
    share = run.share
    return np.where(share < top, share / top, (1.0 - share) / (1.0 - top))


def two_constants(run: Run, rng: np.random.Generator) -> Floats:
    quick, slow = rng.uniform(0.05, 0.12), rng.uniform(0.3, 0.6)
    return np.asarray(np.exp(-run.share / slow) - 1.3 * np.exp(-run.share / quick))


def random_walk(run: Run, rng: np.random.Generator) -> Floats:
    return np.cumsum(rng.normal(size=len(run.speed)))


def heat(run: Run, rng: np.random.Generator) -> Floats:
    """What fast moves leave, and rests take away."""
    cools, state, found = rng.uniform(0.05, 0.15), 0.0, []
    for speed in (run.speed / run.speed.max()).tolist():
        found.append(state)
        state = (1.0 - cools) * state + cools * speed**2
    return np.array(found)


def alternating(run: Run, rng: np.random.Generator) -> Floats:
    """Every other part is handled otherwise; a part takes so many moves."""
    return np.arange(len(run.speed)) // int(rng.integers(3, 8)) % 2 * 1.0


def resonance(run: Run, rng: np.random.Generator) -> Floats:
    """What an oscillation leaves at the end hangs on where in its period the move stops."""
    return np.cos(2.0 * math.pi * run.simulated / rng.uniform(0.06, 0.15))


def tooth(run: Run, rng: np.random.Generator) -> Floats:
    """Of the first axis' gear."""
    azimuth = np.arctan2(run.end[:, 1], run.end[:, 0])
    return np.sin(rng.integers(9, 20) * azimuth + rng.uniform(0.0, 6.0))


def batch(run: Run, rng: np.random.Generator) -> Floats:
    """Comes at one time and goes at another."""
    come = rng.uniform(0.2, 0.4)
    return ((run.share > come) & (run.share < come + rng.uniform(0.2, 0.4))) * 1.0


def oscillation(run: Run, rng: np.random.Generator) -> Floats:
    return np.sin(2.0 * math.pi * (run.share * rng.uniform(2.2, 9.0) + rng.random()))


LAWS: tuple[Callable[[Run, np.random.Generator], Floats], ...] = (
    *(turns_round, two_constants, random_walk, heat, alternating, resonance, tooth, batch, oscillation),
)


def write(folder: Path, run: Run, measured: Floats) -> None:
    points = [f"{axis}_{at}_mm" for at in ("start", "end") for axis in "xyz"]
    with open(folder / "moves.csv", "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(
            ["move", "duration_s", "sim_s", "t_start_s", *points, "speed_mm_s", "accel_mm_s2", "blend_mm"]
        )
        for k in range(len(measured)):
            seconds = [measured[k], run.simulated[k], run.begin[k]]
            lengths = [*run.start[k], *run.end[k], run.speed[k], run.acceleration, run.blend[k]]
            rows.writerow([k + 1, *(f"{s:.6f}" for s in seconds), *(f"{1000 * v:.4f}" for v in lengths)])


def made(folder: Path, number: int, rng: np.random.Generator) -> dict[str, Any]:
    run, law = run_of(rng), LAWS[number % len(LAWS)]
    shape = law(run, rng)
    shape = (shape - shape.mean()) / shape.std()
    noise = float(rng.uniform(0.0015, 0.003))
    # Some laws cost a share of the time, others a time.
    share = law in (resonance, tooth) or rng.random() < 0.3
    cost = rng.uniform(0.008, 0.03) if share else rng.uniform(0.015, 0.04) * run.simulated
    measured = run.simulated + cost * shape + noise * rng.normal(size=len(shape))
    write(folder, run, measured)
    return {
        "mode": "outside",
        "terms": [],
        "moves": None,
        "noise_s": noise,
        "resolution_s": 1e-6,
        "law": law.__name__,
    }


if __name__ == "__main__":
    make_cases(__doc__, made)
