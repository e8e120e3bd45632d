"""Recordings with a known cause, for the tests of diagnosis: durations by stepping through time, not by a closed form.

`play` walks every move in steps of 0.2 ms: it accelerates while it can still brake in time. All effects are done to
what it is given, or to what it gives.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numba
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STEP = 2e-4  # [s]
SPEEDS = (0.05, 0.1, 0.2, 0.4, 0.8)  # [m/s]
ACCELERATION = 2.0  # [m/s²] of the simulation


@dataclass
class Program:
    """Straight moves between random points, as an engineer would record them."""

    start: Floats
    end: Floats
    speed: Floats
    stop: NDArray[np.bool_]
    blend: Floats
    payload: Floats
    more: dict[str, Floats] = field(default_factory=dict)

    @property
    def length(self) -> Floats:
        return np.linalg.norm(self.end - self.start, axis=1)

    @property
    def rise(self) -> Floats:
        return (self.end - self.start)[:, 2] / self.length

    def reach(self, end: bool) -> Floats:
        place = self.end if end else self.start
        return np.hypot(place[:, 0], place[:, 1])


def program(
    rng: np.random.Generator, moves: int = 150, rounded: float = 0.0, speeds: tuple[float, ...] = SPEEDS
) -> Program:
    """A few start points, fans of targets, mixed lengths and speeds; `rounded`: share of moves with a rounded end."""
    points = np.stack(
        [
            rng.uniform(0.6, 1.6, moves + 1),
            rng.uniform(-0.8, 0.8, moves + 1),
            rng.uniform(0.1, 1.2, moves + 1),
        ],
        1,
    )
    for k in range(1, moves + 1):  # some short ways
        if rng.random() < 0.4:
            way = rng.normal(size=3)
            points[k] = points[k - 1] + rng.uniform(0.05, 0.25) * way / np.linalg.norm(way)
    stop = rng.random(moves) >= rounded
    stop[-1] = True
    blend = np.where(stop, 0.0, rng.choice([0.002, 0.005, 0.01, 0.02], moves))
    payload = rng.choice([0.0, 5.0, 10.0, 20.0], moves)
    return Program(points[:-1], points[1:], rng.choice(speeds, moves), stop, blend, payload)


def play(way: Floats, speed: Floats, up: Floats, down: Floats) -> Floats:
    """[s] from rest to rest, stepped; the last step is as long as the way that is left needs."""
    return _played(*(np.asarray(one, float) for one in np.broadcast_arrays(way, speed, up, down)))


@numba.njit(cache=True)
def _played(way, speed, up, down):
    time = np.zeros(len(way))
    for k in range(len(way)):
        place = fast = 0.0
        while True:
            left = way[k] - place
            if fast**2 / (2.0 * down[k]) >= left - fast * STEP:
                faster = max(np.sqrt(max(2.0 * down[k] * left, 0.0)) - 0.5 * down[k] * STEP, 1e-4)
            else:
                faster = min(fast + up[k] * STEP, speed[k])
            step = 0.5 * (fast + faster) * STEP
            if step >= left:
                time[k] += STEP * left / step
                break
            time[k] += STEP
            place += step
            fast = faster
    return time


Effect = Callable[[Program, np.random.Generator], Floats]


def write(
    folder: Path,
    made: Program,
    real: Floats,
    sim: Floats,
    noise: float,
    rng: np.random.Generator,
    **toml: object,
) -> Path:
    """The recording in the contract's format, durations with scatter and to the millisecond."""
    folder.mkdir(parents=True, exist_ok=True)
    measured = np.round(real + noise * rng.normal(size=len(real)), 4)
    t_start = np.concatenate([[0.0], np.cumsum(real + 0.3)[:-1]])
    columns: Mapping[str, Floats] = {
        "move": np.arange(1, len(real) + 1),
        "duration_s": measured,
        "sim_s": np.round(sim, 6),
        **{f"{axis}_start_mm": made.start[:, k] * 1000 for k, axis in enumerate("xyz")},
        **{f"{axis}_end_mm": made.end[:, k] * 1000 for k, axis in enumerate("xyz")},
        "speed_mm_s": made.speed * 1000,
        "accel_mm_s2": np.full(len(real), ACCELERATION * 1000),
        "blend_mm": made.blend * 1000,
        "payload_kg": made.payload,
        "t_start_s": t_start,
        **made.more,
    }
    rows = [",".join(columns)]
    for row in zip(*columns.values(), strict=True):
        rows.append(",".join(f"{value:.10g}" for value in row))
    (folder / "moves.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    (folder / "recording.toml").write_text("time_resolution_s = 0.0001\n", encoding="utf-8")
    return folder
