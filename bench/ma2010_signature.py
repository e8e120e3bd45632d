"""Totals of an MA2010's runs by a signature learnt on the other directions: python bench/ma2010_signature.py FOLDER

FOLDER holds `commands.csv` and the joint recordings beside it. Every run becomes rows of a moves.csv, which part in the
middle of a rest, and in a corner where `olp recording from-log` parts them. A run is timed from 0.5 mm behind its start
to 0.5 mm before its end (see ma2010_runs). Samples 46 ms apart do not tell when the arm began and came to rest: half
millimetres are counted at programmed speed, and speeding up and braking there together as 0.15 s, the acceleration time
of the corner runs (4 ms, another test, docs/blending.md). That constant is the same in every run.

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

from from_log import job_text, segment, tool_text  # noqa: E402
from ma2010_runs import ROBOT, THRESHOLD, Run, read  # noqa: E402

import olp  # noqa: E402
from olp.core.units import deg, mm  # noqa: E402
from olp.identification.recording import Recording, read_recording  # noqa: E402
from olp.identification.signature import Signature, calibrate  # noqa: E402
from olp.identification.signature.correction import SignatureCorrection  # noqa: E402
from olp.identification.signature.rows import predict_recording  # noqa: E402
from olp.robots.geometry import angles_from_rotation  # noqa: E402
from olp.robots.kinematics import forward  # noqa: E402
from olp.timing.timing import time_plan  # noqa: E402

Floats = NDArray[np.float64]
ASKED = 0.5
OUTER = 0.15  # [s] of a run's begin and end together
DIRECTIONS = {
    "+y": ("linear", "linear2", "dense"),
    "-z": ("linear3",),
    "-x": ("linear4",),
    "60° turn": ("kink",),
}
Found = tuple[str, float, float, float, bool]  # group, errors of the commands [%], whether the interval holds
HEAD = [
    "move", "duration_s", "type", "x_start_mm", "y_start_mm", "z_start_mm", "x_end_mm", "y_end_mm", "z_end_mm",
    "rx_deg", "ry_deg", "rz_deg", "speed_mm_s", "pl", "job", "corner",
]  # fmt: skip


class Test(NamedTuple):
    """One run: its group, position level (9: none written), and what `olp recording` and `olp time` get of it."""

    group: str
    level: int
    run: Run
    durations: Floats  # (p - 1,) [s]
    angles: Floats  # (3,) [deg] of the tool
    job: str


def tests(folder: Path) -> list[Test]:
    names = [
        (group, level, f"{group}/blending_zone_test/pl{level}.csv")
        for group in ("linear", "linear2", "linear3", "linear4", "kink")
        for level in range(9)
        if (group, level) != ("linear2", 0)  # recorded on another control group
    ]
    names += [(group, 9, f"{group}_nozone/blending_zone_test/nozone.csv") for group in ("linear2", "kink")]
    names += [("dense", level, f"linear/dense_points_test/pl{level}.csv") for level in range(9)]
    with (folder / "commands.csv").open(encoding="utf-8", newline="") as file:
        commands = {row["file"]: row for row in csv.DictReader(file)}
    turn = tool_of(folder)[:3, :3]
    found = []
    for group, level, name in names:
        command = commands[f"blending_test/{name}"]
        run = read(folder, True, command["file"])[0]
        angles = angles_from_rotation(forward(ROBOT, run.joints[:1])[1][0] @ turn)
        job = job_text((run.points / mm).tolist(), angles, run.speed / mm, command["PL"])
        found.append(Test(group, level, run, durations(run, level, folder, command), angles / deg, job))
    return found


def tool_of(folder: Path) -> Floats:
    """(4, 4) [mm]"""
    return np.loadtxt(folder / "config" / "weldgun_old.csv", delimiter=",")


def durations(run: Run, level: int, folder: Path, command: dict[str, str]) -> Floats:
    """(p - 1,) [s] of each move, see above."""
    if level == 0:
        way = np.linalg.norm(run.place[:, None] - run.points[1:-1], axis=2)
        inner = [run.time[near < near.min() + 0.02 * mm].mean() for near in way.T]
    else:
        with tempfile.TemporaryDirectory() as work:
            seen = segment(folder, command, Path(work)).moves.t_start
        inner = (seen[1:] - np.loadtxt(folder / run.name, delimiter=",", usecols=0, max_rows=1)).tolist()
    outer = THRESHOLD / run.speed + OUTER / 2
    begin = int(np.argmax(run.behind > THRESHOLD))
    start = np.interp(THRESHOLD, run.behind[begin - 1 : begin + 1], run.time[begin - 1 : begin + 1])
    return np.diff(np.concatenate([[start - outer], inner, [start + run.total + outer]]))


def recording(chosen: list[Test], tool: Floats, work: Path) -> Recording:
    """These runs as moves.csv and recording.toml, read as anybody's."""
    rows: list[list[str]] = []
    for test in chosen:
        run = test.run
        for i, seconds in enumerate(test.durations.tolist()):
            last = i == len(test.durations) - 1
            level = "0" if last else "" if test.level == 9 else str(test.level)
            corner = "untagged" if test.level == 9 and not last else "stop" if level == "0" else "zone"
            points = [f"{v / mm:.4f}" for v in (*run.points[i], *run.points[i + 1])]
            head = [
                str(len(rows) + 1),
                f"{seconds:.6f}",
                "linear",
                *points,
                *(f"{a:.4f}" for a in test.angles),
            ]
            rows.append([*head, f"{run.speed / mm:g}", level, run.name, corner])
    with (work / "moves.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([HEAD, *rows])
    pose = [round(float(v), 6) for v in (*tool[:3, 3], *(angles_from_rotation(tool[:3, :3]) / deg))]
    told = f'robot = "yaskawa/ma2010"\ncontroller = "DX200"\ntool = {pose}\n'
    (work / "recording.toml").write_text(told, encoding="utf-8")
    return read_recording(work)


def by_job(test: Test, signature: Signature, tool: Floats, work: Path) -> tuple[float, float, float, float]:
    """[s] total of `olp time JOB --signature`, its interval, and the total without the signature."""
    (work / "TOOL.CND").write_text(tool_text(tool), encoding="ascii")
    (work / "RUN.JBI").write_text(test.job, encoding="ascii", newline="")
    plan = olp.read(work / "RUN.JBI").plan("yaskawa/ma2010")
    timing = time_plan(plan, learnt=SignatureCorrection(signature))
    assert timing.interval is not None
    return timing.total_s, timing.interval.total_low, timing.interval.total_high, time_plan(plan).total_s


def totals(values: Floats, made: Recording) -> Floats:
    """(m,) sums over the rows of each run, in order."""
    names = list(dict.fromkeys(made.moves.job))
    return np.bincount([names.index(job) for job in made.moves.job], values)


def main(folder: Path) -> int:
    every, tool = tests(folder), tool_of(folder)
    found: list[Found] = []
    print(
        "learnt on the other directions: what the signature holds, then each run left out, error % (measured s)"
    )
    for direction, groups in DIRECTIONS.items():
        learnt = [t for t in every if t.group not in groups]
        held = [t for t in every if t.group in groups]
        with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
            signature, told = calibrate(recording(learnt, tool, Path(one)))
            asked = recording(held, tool, Path(two))
            said = predict_recording(signature, asked)[0]
            timed = [by_job(test, signature, tool, Path(two)) for test in held]
        print(f"{direction}: learnt from {len(learnt)} runs, method {signature.method}")
        for note in told:
            if note.code == "H021":
                print(f"    {note.message}")
        measured, predicted = totals(asked.moves.duration, asked), totals(said.predicted, asked)
        lines: dict[str, list[str]] = {group: [] for group in groups}
        for test, true, guess, (total, low, high, plain) in zip(
            held, measured, predicted, timed, strict=True
        ):
            error, other, bare = (100 * (seconds / true - 1) for seconds in (guess, total, plain))
            found.append((test.group, error, other, bare, low <= true <= high))
            lines[test.group].append(f"{'no' if test.level == 9 else test.level}: {error:+.2f} ({true:.3f})")
        for group, words in lines.items():
            print(f"    {group:8s} " + "  ".join(words))
        taken = asked.moves.duration
        rows = np.mean((said.low <= taken) & (taken <= said.high))
        print(f"    95 % intervals hold {100 * rows:.0f} % of the rows")
    return max(summary(name, [f for f in found if (f[0] == "dense") == dense]) for name, dense in (
        ("two-line runs", False), ("dense runs", True)))  # fmt: skip


def summary(name: str, found: list[Found]) -> int:
    for command, column in (("olp predict", 1), ("olp time", 2), ("olp time without a signature", 3)):
        errors = np.abs([f[column] for f in found])
        print(
            f"{name}, {command}: {len(errors)}, mean {errors.mean():.2f} %, worst {errors.max():.2f} %, "
            f"above {ASKED} %: {np.sum(errors > ASKED)}"
        )
    print(f"{name}: the total's 95 % interval holds {sum(f[4] for f in found)} of {len(found)}")
    return int(max(abs(f[1]) for f in found) > ASKED)


if __name__ == "__main__":
    raise SystemExit(main(Path(sys.argv[1])))
