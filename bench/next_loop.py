"""`olp diagnose --next` as a loop: diagnose, run what it proposes, add that to the recording, diagnose again.

    python bench/next_loop.py [--cases 12] [--seed 1] [--jobs 2]

A drive of its own (constant acceleration between stops, ramps that build up in a fixed time, a fixed time per move or
per exact stop, a speed factor, a clock) runs a poor program: one speed, ways that all reach it, exact stops. So most of
what is hidden, one effect or two, cannot be told from something else. Then the proposed moves and timers are run
by the same drive, as often as asked for, and the second answer is compared with what is hidden.
"""

from __future__ import annotations

import argparse
import csv
import os
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from olp.identification.diagnosis.diagnose import diagnose_recording  # noqa: E402
from olp.identification.diagnosis.result import Diagnosis, NextExperiment  # noqa: E402
from olp.identification.recording import read_recording  # noqa: E402

ACCELERATION, SPEED, NOISE = 2.0, 0.3, 0.001  # m/s², m/s, s
MOVES, SHORTEST, LONGEST = 70, 0.15, 0.5  # of the program; m
# Dry friction takes from speeding up what it gives to braking: from stop to stop 1/(1 - c) + 1/(1 + c) = 2/(1 - c²), as
# another acceleration does in every move. A log of torques tells them apart.
SAME = {"acceleration", "coulomb-friction"}
HIDDEN = (
    ("acceleration",), ("jerk",), ("settling",), ("dispatch",), ("speed-scale",), ("clock",),
    ("acceleration", "dispatch"), ("jerk", "speed-scale"), ("settling", "speed-scale"), ("acceleration", "settling"),
)  # fmt: skip


class Line(NamedTuple):
    """One move, or a timer where `way` is 0; lengths in m."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    speed: float  # [m/s]
    blend: float
    timer: float  # [s]


class Drive(NamedTuple):
    """What is hidden."""

    acceleration: float = 1.0  # times the simulated one
    ramp: float = 0.0  # [s] in which acceleration builds up
    settling: float = 0.0  # [s]
    dispatch: float = 0.0  # [s]
    scale: float = 1.0
    clock: float = 1.0

    def seconds(self, line: Line) -> float:
        if line.timer:
            return self.clock * line.timer
        way = float(np.linalg.norm(np.subtract(line.end, line.start)))
        slow = self.acceleration * ACCELERATION
        root = np.sqrt(self.ramp**2 + 4.0 * way / slow)
        speed = min(self.scale * line.speed, 2.0 * way / (self.ramp + root))
        travel = way / speed + speed / slow + self.ramp
        stop = self.settling if line.blend == 0 else 0.0
        return self.clock * (travel + stop + self.dispatch)


def drive_of(hidden: tuple[str, ...], rng: np.random.Generator) -> Drive:
    sizes = {
        "acceleration": {"acceleration": rng.uniform(0.6, 0.8)},
        "jerk": {"ramp": rng.uniform(0.04, 0.1)},
        "settling": {"settling": rng.uniform(0.03, 0.08)},
        "dispatch": {"dispatch": rng.uniform(0.02, 0.06)},
        "speed-scale": {"scale": rng.uniform(0.96, 0.985)},
        "clock": {"clock": 1.0 + rng.uniform(0.008, 0.02)},
    }
    return Drive(**{name: value for term in hidden for name, value in sizes[term].items()})


def program(rng: np.random.Generator) -> list[Line]:
    lines = []
    for _ in range(MOVES):
        start = rng.uniform([0.6, -0.5, 0.1], [1.1, 0.5, 0.8])
        towards = rng.normal(size=3)
        end = start + rng.uniform(SHORTEST, LONGEST) * towards / np.linalg.norm(towards)
        lines.append(Line(tuple(start.tolist()), tuple(end.tolist()), SPEED, 0.0, 0.0))
    return lines


def proposed(experiment: NextExperiment) -> list[Line]:
    """The moves and timers, as often as they are asked for."""
    nowhere = (0.0, 0.0, 0.0)
    moves = [Line(m.start, m.end, m.speed, m.blend, 0.0) for m in experiment.moves for _ in range(m.times)]
    return moves + [
        Line(nowhere, nowhere, 0.0, 0.0, t.duration) for t in experiment.timers for _ in range(t.times)
    ]


def record(folder: Path, lines: list[Line], drive: Drive, rng: np.random.Generator) -> None:
    nothing = Drive()
    with open(folder / "moves.csv", "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        points = [f"{axis}_{at}_mm" for at in ("start", "end") for axis in "xyz"]
        rows.writerow(
            ["move", "type", "duration_s", "sim_s", *points, "speed_mm_s", "accel_mm_s2", "blend_mm"]
        )
        for number, line in enumerate(lines, 1):
            seconds = drive.seconds(line) + NOISE * rng.normal()
            times = [f"{seconds:.6f}", f"{nothing.seconds(line):.6f}"]
            if line.timer:
                rows.writerow([number, "wait", *times, *[""] * 9])
                continue
            numbers = [
                f"{1000 * v:.4f}" for v in (*line.start, *line.end, line.speed, ACCELERATION, line.blend)
            ]
            rows.writerow([number, "linear", *times, *numbers])
    (folder / "recording.toml").write_text("time_resolution_s = 0.001\n", encoding="utf-8")


def right(told: Diagnosis, hidden: tuple[str, ...]) -> bool:
    """Exactly the hidden names, and nothing that could not be told from them but what no duration ever tells."""
    alike = [group for group in told.indistinguishable if not set(group) <= SAME]
    return sorted(f.term for f in told.findings) == sorted(hidden) and not alike


def loop(case: tuple[int, int]) -> tuple[str, bool, bool]:
    number, seed = case
    rng = np.random.default_rng([seed, number])
    hidden = HIDDEN[number % len(HIDDEN)]
    drive, lines = drive_of(hidden, rng), program(rng)
    answers = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(2):
            record(Path(folder), lines, drive, np.random.default_rng([seed, number, 7]))
            answers.append(diagnose_recording(read_recording(folder)).diagnosis)
            lines = lines + proposed(answers[-1].next_experiment)
    one, two = (
        f"{[f.term for f in told.findings]} alike {[list(g) for g in told.indistinguishable]}"
        for told in answers
    )
    return (
        f"{number:3d} hidden {list(hidden)}: {one}; then {two}",
        right(answers[0], hidden),
        right(answers[1], hidden),
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    first = second = 0
    with ProcessPoolExecutor(args.jobs) as pool:
        for text, before, after in pool.map(loop, [(k, args.seed) for k in range(args.cases)]):
            first, second = first + before, second + after
            print(f"{'right' if after else 'WRONG'} {text}", flush=True)
    print(f"\nexactly these, nothing else alike: {first} of {args.cases} at first, {second} after one round")


if __name__ == "__main__":
    main()
