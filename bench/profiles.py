"""How right and how fast the motion models are: `python bench/profiles.py`. Exit status 1 when a figure is missed.

The independent solver is ruckig, in the same run. Moves are random over four decades of length and
three of limits; half of them brake at another rate than they accelerate.
Between speeds other than zero only moves that can be made without swinging back are compared (olp tells the others
by their problem, ruckig swings), as many of them as asked. Rates are per CPU second, the median of five.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import ruckig
from numpy.typing import NDArray

from olp.core import compiled_loops
from olp.timing.motion import Profile, durations, load_model

Array = NDArray[np.float64]

MOVES = 1_000_000
BLOCK = 100_000
AXES = 6
CALLS = 20_000
ASKED = 1e-9  # [s]
ASKED_NUMPY, ASKED_RATIO, ASKED_COMPILED = 2.5e6, 10.0, 6e6


class Figure(NamedTuple):
    name: str
    asked: str
    measured: str
    held: bool


def main() -> int:
    figures = [*agreement(), *rates()]
    print("| figure | asked | measured |\n|---|---|---|")
    for figure in figures:
        print(f"| {figure.name} | {figure.asked} | {figure.measured}{'' if figure.held else ' **missed**'} |")
    print(f"\nruckig {ruckig.__version__}, numpy {np.__version__}, {sys.version.split()[0]}, "
          f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} while measuring")  # fmt: skip
    return 0 if all(figure.held for figure in figures) else 1


def agreement() -> Iterator[Figure]:
    """Durations of both models against ruckig."""
    for model in ("constant", "linear"):
        for moving in (False, True):
            worst, compared, drawn = compare(model, moving)
            ends = "start and end speeds other than zero" if moving else "rest to rest"
            share = f" ({drawn:,} drawn)" if drawn > compared else ""
            yield Figure(
                f"`{model}`, {ends}: largest difference to ruckig over {compared:,} moves{share}",
                f"≤ {ASKED:.0e} s",
                f"{worst:.1e} s",
                worst <= ASKED and compared >= MOVES,
            )


def compare(model: str, moving: bool) -> tuple[float, int, int]:
    """Largest difference [s], how many moves were compared, how many were drawn."""
    rng = np.random.default_rng(20)
    worst, compared, drawn = 0.0, 0, 0
    while compared < MOVES:
        bounds = [(-3, 0.7), (-2, 0.5), (-0.7, 0.8), (-0.5, 2)]
        length, speed, rate, jerk = (10 ** rng.uniform(*b, BLOCK) for b in bounds)
        brake = np.where(rng.random(BLOCK) < 0.5, rate, 10 ** rng.uniform(-0.7, 0.8, BLOCK))
        start, end = speed * rng.uniform(0, 1, (2, BLOCK)) * moving
        rates = {"k1": jerk, "k2": jerk} if model == "linear" else {}
        profile = load_model(model).profile(length, speed, rate, brake, start, end, **rates)
        jerks = jerk if model == "linear" else np.full(BLOCK, np.inf)
        rows = np.flatnonzero(profile.feasible)[: MOVES - compared]
        expected = solve([c[rows] for c in (length, speed, rate, brake, jerks, start, end)])
        worst = max(worst, float(np.abs(profile.duration[rows] - expected).max()))
        compared, drawn = compared + len(rows), drawn + BLOCK
    return worst, compared, drawn


def solve(columns: list[Array]) -> Array:
    """ruckig's durations [s], (n,)."""
    solver, task, answer = ruckig.Ruckig(1), ruckig.InputParameter(1), ruckig.Trajectory(1)
    task.current_position = [0.0]
    found = []
    for length, speed, rate, brake, jerk, start, end in zip(*(c.tolist() for c in columns), strict=True):
        task.target_position, task.current_velocity, task.target_velocity = [length], [start], [end]
        task.max_velocity, task.max_acceleration, task.min_acceleration = [speed], [rate], [-brake]
        task.max_jerk = [jerk]
        if solver.calculate(task, answer) < 0:
            raise RuntimeError(f"ruckig failed on {length, speed, rate, brake, jerk, start, end}")
        found.append(answer.duration)
    return np.array(found)


def rates() -> Iterator[Figure]:
    """Jerk-limited synchronised moves of six axes per second."""
    rng = np.random.default_rng(7)
    length = rng.uniform(0.0, 3.0, (MOVES, AXES))  # [rad]
    speed = np.array([3.7, 3.7, 4.6, 7.3, 7.3, 15.4])  # [rad/s] rated
    rate, jerk = speed / 0.3, speed / 0.3 / 0.1
    share = rng.uniform(0.1, 1.0, (MOVES, 1))  # VJ of each move
    per_axis, per_move = (speed, rate, jerk), (speed * share, rate * share, jerk * share)
    profiles = per_second(lambda: whole_profiles(length[:CALLS], per_axis), CALLS)
    yield Figure("`profile()` of each axis, all phases, checked", "-", f"{profiles:,.0f} moves/s", True)
    for limits, name in ((per_axis, "one set of limits"), (per_move, "limits of each move its own")):
        few = tuple(limit if limit.ndim == 1 else limit[:CALLS] for limit in limits)
        calls = ruckig_calls(length[:CALLS], few)
        apart = float(np.abs(durations(length[:CALLS], *few, compiled=False) - calls.durations).max())
        yield Figure(f"ruckig, calls of six axes, {name}", "-", f"{calls.rate:,.0f} moves/s", True)
        yield Figure("… largest difference to it", f"≤ {ASKED:.0e} s", f"{apart:.1e} s", apart <= ASKED)
        plain = per_second(lambda at=limits: durations(length, *at, compiled=False), MOVES)
        held = plain >= ASKED_NUMPY and plain >= ASKED_RATIO * calls.rate
        yield Figure(
            f"`durations()`, numpy, {name}",
            f"≥ {ASKED_NUMPY / 1e6} M/s and ≥ {ASKED_RATIO:.0f} × ruckig",
            f"{plain / 1e6:.1f} M/s, {plain / calls.rate:.0f} ×",
            held,
        )
        if not compiled_loops.available():
            missing = "not installed: pip install olp[fast]"
            yield Figure(
                f"`durations()`, compiled, {name}", f"≥ {ASKED_COMPILED / 1e6:.0f} M/s", missing, True
            )
            continue
        quick = per_second(lambda at=limits: durations(length, *at, compiled=True), MOVES)
        yield Figure(
            f"`durations()`, compiled, {name}",
            f"≥ {ASKED_COMPILED / 1e6:.0f} M/s",
            f"{quick / 1e6:.1f} M/s, {quick / calls.rate:.0f} ×",
            quick >= ASKED_COMPILED,
        )


class Calls(NamedTuple):
    rate: float  # [1/s] per CPU second
    durations: Array  # [s]


def ruckig_calls(length: Array, limits: tuple[Array, ...]) -> Calls:
    """One call per move; limits that all moves share are set once."""
    solver, task, answer = ruckig.Ruckig(AXES), ruckig.InputParameter(AXES), ruckig.Trajectory(AXES)
    task.current_position = [0.0] * AXES
    shared = limits[0].ndim == 1
    own = list(zip(*(np.atleast_2d(limit).tolist() for limit in limits), strict=True))
    task.max_velocity, task.max_acceleration, task.max_jerk = own[0]
    targets = length.tolist()
    found: list[float] = []

    def work() -> None:
        found.clear()
        for i, target in enumerate(targets):
            task.target_position = target
            if not shared:
                task.max_velocity, task.max_acceleration, task.max_jerk = own[i]
            solver.calculate(task, answer)
            found.append(answer.duration)

    rate = per_second(work, len(targets))
    return Calls(rate, np.array(found))


def whole_profiles(length: Array, limits: tuple[Array, Array, Array]) -> Profile:
    speed, rate, jerk = (np.broadcast_to(limit, length.shape).ravel() for limit in limits)
    return load_model("linear").profile(length.ravel(), speed, rate, k1=jerk, k2=jerk)


def per_second(work: Callable[[], object], moves: int) -> float:
    work()
    times = []
    for _ in range(5):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return moves / statistics.median(times)


if __name__ == "__main__":
    sys.exit(main())
