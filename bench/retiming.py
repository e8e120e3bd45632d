"""Paths with limits: duration, kept limits and cost against toppra: `python bench/retiming.py`.

100 random paths of six axes and 100 points each, half of them smooth (sums of sines), half of them wild (a spline
through independent random points); limits of every path are random too. Both solvers run on the same grid of 4951
samples in the same run, from points to a speed for every sample, and toppra once more on a grid four times as fine.
Limits are checked on the true spline at ten places inside every interval. The last rows look along the lines of two
programs of 100,000 moves: a raster of short lines, and one of long lines. Times are CPU time.
Exit status 1 when a figure is missed.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np
import speed
import toppra
import toppra.algorithm
import toppra.constraint
from numpy.typing import NDArray

from olp.core import compiled_loops
from olp.timing.retiming import LimitKind, Retimed, SampledPath, along_path, retime, spline_through

Array = NDArray[np.float64]
T = TypeVar("T")

PATHS, POINTS, AXES = 100, 100, 6
MOVES = 100_000  # of the programs
PIECES = 50  # samples per span: 4951 of a path
ASKED_DURATION, ASKED_EXCESS = 2e-3, 5e-3


class Case(NamedTuple):
    joints: Array  # (points, axes) [rad]
    speed: Array  # (axes,) [rad/s]
    acceleration: Array  # (axes,) [rad/s²]


class Figure(NamedTuple):
    name: str
    asked: str
    measured: str
    held: bool


def main() -> int:
    toppra.setup_logging("ERROR")
    figures = [*measured(cases()), *spacing(cases()), *along_programs()]
    print("| figure | asked | measured |\n|---|---|---|")
    for figure in figures:
        print(f"| {figure.name} | {figure.asked} | {figure.measured}{'' if figure.held else ' **missed**'} |")
    print(f"\ntoppra {version('toppra')}, numpy {np.__version__}, {sys.version.split()[0]}, "
          f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} while measuring")  # fmt: skip
    return 0 if all(figure.held for figure in figures) else 1


def measured(all_cases: list[Case]) -> list[Figure]:
    place = np.linspace(0.0, 1.0, POINTS)
    ours = together(place, all_cases, compiled=False)
    grid = ours.place[0]
    theirs, their_time = timed(lambda: [by_toppra(place, case, grid) for case in all_cases])
    finer = np.interp(np.arange(4 * (len(grid) - 1) + 1) / 4, np.arange(len(grid)), grid)
    fine = [by_toppra(place, case, finer) for case in all_cases]
    same = float(np.abs(ours.duration / [duration(grid, v) for v in theirs] - 1).max())
    apart = float(np.abs(ours.duration / [duration(finer, v) for v in fine] - 1).max())
    excess = max(worst(place, case, grid, ours.speed[i]) for i, case in enumerate(all_cases))
    their_excess = max(worst(place, case, grid, theirs[i]) for i, case in enumerate(all_cases))
    kept = f"{excess:.2%} (toppra {their_excess:.1%})"
    name = "duration against toppra, largest difference"
    figures = [
        Figure(f"{name}, same grid", "≤ 0.2 %", f"{same:.3%}", same <= ASKED_DURATION),
        Figure(f"{name}, its grid 4 × as fine", "≤ 0.2 %", f"{apart:.3%}", apart <= ASKED_DURATION),
        Figure("limits exceeded anywhere by", "≤ 0.5 %", kept, excess <= ASKED_EXCESS),
        Figure("toppra, one path", "-", f"{1e3 * their_time / PATHS:.1f} ms", True),
    ]
    for compiled, asked in ((False, 1.0), (True, 10.0)):
        name = "compiled" if compiled else "numpy"
        if compiled and not compiled_loops.available():
            figures.append(Figure("olp, compiled", "≥ 10 ×", "not installed: pip install olp[fast]", True))
            continue
        one_by_one(place, all_cases[:1], compiled)
        singly, single_time = timed(lambda on=compiled: one_by_one(place, all_cases, on))
        _, joint_time = timed(lambda on=compiled: together(place, all_cases, on))
        agree = max(abs(a.duration / b - 1) for a, b in zip(singly, ours.duration, strict=True))
        for seconds, how in ((single_time, "a call per path"), (joint_time, "all paths in a call")):
            ratio = their_time / seconds
            figures.append(
                Figure(
                    f"olp, {name}, {how}",
                    f"≥ {asked:.0f} × toppra",
                    f"{ratio:.1f} × ({1e3 * seconds / PATHS:.2f} ms a path)",
                    ratio >= asked and agree < 1e-9,
                )
            )
    kinds = [name.kind for name in ours.names]
    share = np.mean([kinds[i] is LimitKind.SPEED for i in ours.limiter.ravel()])
    split = f"{share:.0%}, {1 - share:.0%}"
    figures.append(Figure("intervals ruled by an axis's speed, by its acceleration", "-", split, True))
    return figures


def spacing(all_cases: list[Case]) -> Iterator[Figure]:
    """What the spacing of the samples does: 10, 20 and 40 a span."""
    place, few = np.linspace(0.0, 1.0, POINTS), all_cases[:20]
    limit = together(place, few, compiled_loops.available(), 160).duration
    above = [
        together(place, few, compiled_loops.available(), pieces).duration / limit - 1
        for pieces in (10, 20, 40)
    ]
    for start, name in ((0, "smooth"), (1, "random")):
        shares = ", ".join(f"{share[start::2].max():.2%}" for share in above)
        yield Figure(
            f"duration at 10, 20, 40 samples a span above that at 160, ten {name} paths", "-", shares, True
        )
    runs = together(place, few, False, 10)
    ours = max(worst(place, case, runs.place[0], runs.speed[i]) for i, case in enumerate(few))
    theirs = max(worst(place, c, runs.place[0], by_toppra(place, c, runs.place[0])) for c in few)
    name = "limits exceeded anywhere at 10 samples a span by"
    yield Figure(name, "-", f"{max(ours, 0.0):.2%} (toppra {theirs:.0%})", True)


def along_programs() -> Iterator[Figure]:
    """What `along_path` costs `olp time`."""
    import olp

    raster = speed.job("LARGE", MOVES)
    for text, name, asked in ((raster, "short lines", 1.0), (long_lines(raster), "long lines", None)):
        with tempfile.TemporaryDirectory() as folder:
            job = Path(folder) / "LARGE.JBI"
            job.write_bytes(text.encode("ascii"))
            (Path(folder) / "olp.toml").write_text(f'robot = "{speed.ROBOT}"\n')
            plan = olp.read(job).plan()
        found, seconds = min(
            (timed(lambda at=plan: along_path(at)) for _ in range(3)), key=lambda run: run[1]
        )
        mean = float(plan.moves.length.mean()) * 1e3
        yield Figure(
            f"limits along {int(found.known.sum()):,} {name} of a program, {mean:.1f} mm each",
            f"≤ {asked:.0f} s" if asked else "-",
            f"{seconds:.2f} s",
            asked is None or seconds <= asked,
        )


def long_lines(text: str) -> str:
    """The same program with its points in another order, so that neighbours are far apart."""
    lines = text.split("\r\n")
    points = [i for i, line in enumerate(lines) if line.startswith("C")]
    values = [lines[i].partition("=")[2] for i in points]
    for order, i in enumerate(points):
        name = lines[i].partition("=")[0]
        lines[i] = f"{name}={values[order * 61_803 % len(values)]}"
    return "\r\n".join(lines)


def cases() -> list[Case]:
    rng = np.random.default_rng(42)
    angle = np.linspace(0.0, 2.0 * np.pi, POINTS)[:, None]
    result = []
    for number in range(PATHS):
        if number % 2:
            joints = rng.normal(size=(POINTS, AXES))
        else:
            waves = [
                rng.normal(size=AXES) * np.sin((j + 1) * angle / 2 + rng.uniform(0, 6, AXES)) / (j + 1)
                for j in range(4)
            ]
            joints = sum(waves[1:], waves[0])
        speed = rng.uniform(2.0, 8.0, AXES)
        result.append(Case(joints, speed, speed / rng.uniform(0.1, 0.5, AXES)))
    return result


def together(place: Array, all_cases: list[Case], compiled: bool, pieces: int = PIECES) -> Retimed:
    path = SampledPath.through(place, np.stack([case.joints for case in all_cases]), pieces)
    speed = np.stack([case.speed for case in all_cases])[:, None, :]
    acceleration = np.stack([case.acceleration for case in all_cases])[:, None, :]
    return retime(path, speed, acceleration, compiled=compiled)


def one_by_one(place: Array, all_cases: list[Case], compiled: bool) -> list[Retimed]:
    return [
        retime(
            SampledPath.through(place, case.joints, PIECES), case.speed, case.acceleration, compiled=compiled
        )
        for case in all_cases
    ]


def by_toppra(place: Array, case: Case, grid: Array) -> Array:
    """ds/dt (n,) on the grid, limits held at both ends of each interval."""
    path = toppra.SplineInterpolator(place, case.joints)
    speed = toppra.constraint.JointVelocityConstraint(np.stack([-case.speed, case.speed], axis=1))
    limits = np.stack([-case.acceleration, case.acceleration], axis=1)
    kind = toppra.constraint.DiscretizationType.Interpolation
    acceleration = toppra.constraint.JointAccelerationConstraint(limits, discretization_scheme=kind)
    solver = toppra.algorithm.TOPPRA([speed, acceleration], path, gridpoints=grid, solver_wrapper="seidel")
    _, found, _ = solver.compute_parameterization(0.0, 0.0)
    if found is None:
        raise RuntimeError("toppra found no motion")
    return np.asarray(found)


def duration(grid: Array, speed: Array) -> float:
    return float(np.sum(2.0 * np.diff(grid) / (speed[1:] + speed[:-1])))


def worst(place: Array, case: Case, grid: Array, speed: Array) -> float:
    """The largest share by which a limit is exceeded at ten places of every interval, both ends included."""
    squares = speed**2
    rate = np.diff(squares) / (2.0 * np.diff(grid))
    part = np.linspace(0.0, 1.0, 10)[None, :]
    at = grid[:-1, None] * (1 - part) + grid[1:, None] * part
    x = (squares[:-1, None] * (1 - part) + squares[1:, None] * part).ravel()[:, None]
    _, first, second = spline_through(place, case.joints)(at.ravel())
    accelerated = np.abs(first * np.repeat(rate, 10)[:, None] + second * x) / case.acceleration
    driven = np.abs(first) * np.sqrt(np.maximum(x, 0.0)) / case.speed
    return float(max(accelerated.max(), driven.max())) - 1.0


def timed(work: Callable[[], T]) -> tuple[T, float]:
    """The answer and the CPU time [s]."""
    start = time.process_time()
    answer = work()
    return answer, time.process_time() - start


if __name__ == "__main__":
    sys.exit(main())
