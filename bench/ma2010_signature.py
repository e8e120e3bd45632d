"""Totals of an MA2010's runs by a signature learnt on the other directions: python bench/ma2010_signature.py FOLDER

FOLDER holds `commands.csv` and the joint recordings beside it. Every run becomes rows of a moves.csv, which part where
the tool was nearest to the corner. A run is timed from 0.5 mm behind its start to 0.5 mm before its end (see
ma2010_runs). Samples 46 ms apart do not tell when the arm began and came to rest: the half millimetres are counted at
programmed speed, and speeding up and braking there together as 0.15 s, the acceleration time of the corner runs
(4 ms, another test, docs/blending.md). That constant is the same in every run.

The signature of each line of the table is calibrated by `olp calibrate`'s code on the runs in other directions only:
estimator, acceleration, what a stop costs and what a corner saves. Nothing is chosen by hand inside.
"""

from __future__ import annotations

import csv
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from ma2010_runs import ROBOT, THRESHOLD, Run, read  # noqa: E402

from olp.geometry import angles_from_rotation  # noqa: E402
from olp.kinematics import forward  # noqa: E402
from olp.recording import Recording, read_recording  # noqa: E402
from olp.signature import calibrate  # noqa: E402
from olp.signature.rows import predict_recording  # noqa: E402
from olp.units import deg, mm  # noqa: E402

Floats = NDArray[np.float64]
ASKED = 0.5
OUTER = 0.15  # [s] of a run's begin and end together
DIRECTIONS = {
    "+y": ("linear", "linear2", "dense"),
    "-z": ("linear3",),
    "-x": ("linear4",),
    "60° turn": ("kink",),
}
HEAD = [
    "move", "duration_s", "type", "x_start_mm", "y_start_mm", "z_start_mm", "x_end_mm", "y_end_mm", "z_end_mm",
    "rx_deg", "ry_deg", "rz_deg", "speed_mm_s", "pl", "job", "corner",
]  # fmt: skip


class Test(NamedTuple):
    """One run: its group, position level (9: none written) and recording."""

    group: str
    level: int
    run: Run


def tests(folder: Path) -> list[Test]:
    found = []
    for group in ("linear", "linear2", "linear3", "linear4", "kink"):
        for level in range(9):
            if (group, level) != ("linear2", 0):  # recorded on another control group
                name = f"blending_test/{group}/blending_zone_test/pl{level}.csv"
                found.append(Test(group, level, read(folder, True, name)[0]))
    for group in ("linear2", "kink"):
        name = f"blending_test/{group}_nozone/blending_zone_test/nozone.csv"
        found.append(Test(group, 9, read(folder, True, name)[0]))
    for level in range(9):
        name = f"blending_test/linear/dense_points_test/pl{level}.csv"
        found.append(Test("dense", level, read(folder, True, name)[0]))
    return found


def durations(run: Run) -> Floats:
    """(p - 1,) [s] of each move, see above."""
    way = np.linalg.norm(run.place[:, None] - run.points[1:-1], axis=2)
    total, outer = run.total, THRESHOLD / run.speed + OUTER / 2
    begin = int(np.argmax(run.behind > THRESHOLD))
    start = np.interp(THRESHOLD, run.behind[begin - 1 : begin + 1], run.time[begin - 1 : begin + 1])
    corners = []
    for column in way.T:
        # An exact stop is left in the middle of the rest.
        near = np.nonzero(column < column.min() + 0.02 * mm)[0]
        corners.append(run.time[near].mean())
    marks = np.concatenate([[start - outer], corners, [start + total + outer]])
    return np.diff(marks)


def recording(chosen: list[Test], folder: Path, work: Path) -> Recording:
    """These runs as moves.csv and recording.toml, read as anybody's."""
    tool = np.loadtxt(folder / "config" / "weldgun_old.csv", delimiter=",")
    turn = tool[:3, :3]
    rows, number = [], 0
    for test in chosen:
        run = test.run
        angles = angles_from_rotation(forward(ROBOT, run.joints[:1])[1][0] @ turn) / deg
        taken = durations(run)
        for i, seconds in enumerate(taken.tolist()):
            number += 1
            last = i == len(taken) - 1
            level = "0" if last else "" if test.level == 9 else str(test.level)
            corner = "untagged" if test.level == 9 and not last else "stop" if level == "0" else "zone"
            points = [f"{v / mm:.4f}" for v in (*run.points[i], *run.points[i + 1])]
            turned = [f"{a:.4f}" for a in angles]
            speed = f"{run.speed / mm:g}"
            rows.append(
                [str(number), f"{seconds:.6f}", "linear", *points, *turned, speed, level, run.name, corner]
            )
    with (work / "moves.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([HEAD, *rows])
    pose = [*tool[:3, 3], *(angles_from_rotation(turn) / deg)]
    told = f'robot = "yaskawa/ma2010"\ncontroller = "DX200"\ntool = {[round(float(v), 6) for v in pose]}\n'
    (work / "recording.toml").write_text(told, encoding="utf-8")
    return read_recording(work)


def totals(values: Floats, made: Recording) -> Floats:
    """(m,) sums over the rows of each run, in order."""
    names = list(dict.fromkeys(made.moves.job))
    return np.bincount([names.index(job) for job in made.moves.job], values)


def main(folder: Path) -> int:
    every = tests(folder)
    errors: dict[tuple[str, int], float] = {}
    print(
        "learnt on the other directions: what the signature holds, then each run left out, error % (measured s)"
    )
    for direction, groups in DIRECTIONS.items():
        learnt = [t for t in every if t.group not in groups]
        held = [t for t in every if t.group in groups]
        with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
            signature, told = calibrate(recording(learnt, folder, Path(one)))
            asked = recording(held, folder, Path(two))
            said = predict_recording(signature, asked)[0]
        print(f"{direction}: learnt from {len(learnt)} runs, method {signature.method}")
        for note in told:
            if note.code == "H021":
                print(f"    {note.message}")
        measured, predicted = totals(asked.moves.duration, asked), totals(said.predicted, asked)
        inside = np.mean((said.low <= asked.moves.duration) & (asked.moves.duration <= said.high))
        for test, true, guess in zip(held, measured, predicted, strict=True):
            errors[test.group, test.level] = 100 * (guess / true - 1)
        for group in groups:
            own = [
                (t.level, errors[t.group, t.level], s)
                for t, s in zip(held, measured, strict=True)
                if t.group == group
            ]
            print(
                f"    {group:8s} "
                + "  ".join(f"{'no' if k == 9 else k}: {e:+.2f} ({s:.3f})" for k, e, s in own)
            )
        print(f"    95 % intervals hold {100 * inside:.0f} % of the rows")
    return summary(errors)


def summary(errors: dict[tuple[str, int], float]) -> int:
    runs = np.abs([e for (group, _), e in errors.items() if group != "dense"])
    dense = np.abs([e for (group, _), e in errors.items() if group == "dense"])
    print(
        f"two-line runs: {len(runs)}, mean {runs.mean():.2f} %, worst {runs.max():.2f} %, above {ASKED} %: {np.sum(runs > ASKED)}"
    )
    print(
        f"dense runs: {len(dense)}, mean {dense.mean():.2f} %, worst {dense.max():.2f} %, above {ASKED} %: {np.sum(dense > ASKED)}"
    )
    return int(max(runs.max(), dense.max()) > ASKED)


if __name__ == "__main__":
    raise SystemExit(main(Path(sys.argv[1])))
