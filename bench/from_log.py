"""`olp recording from-log` on published recordings of a Yaskawa MA2010 on a DX200: what it makes of raw joint logs.

    python bench/from_log.py FOLDER
    python bench/from_log.py --speed      how quickly a log of a million samples is read

FOLDER holds `commands.csv` and the joint recordings beside it. For each run the job is written that was commanded,
with its tool, and the log is cut into that job's moves. Beside it stands what can be measured without knowing any
move: the time from 0.5 mm behind the start to 0.5 mm before the end. Ramps lie outside of that, so a run takes longer
by an amount that depends on the speed alone: what has to be small is the scatter of that amount.
"""

from __future__ import annotations

import csv
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from ma2010_runs import ROBOT, read  # noqa: E402

from olp.core.units import deg  # noqa: E402
from olp.identification.recording import Log  # noqa: E402
from olp.identification.recording.from_log import FromLog, moves_from_log  # noqa: E402
from olp.reports.batch import Job, plan_and_time  # noqa: E402
from olp.robots.geometry import angles_from_rotation  # noqa: E402
from olp.robots.kinematics import forward  # noqa: E402

Floats = NDArray[np.float64]
OTHER_GROUP = "linear2/blending_zone_test/pl0.csv"


def job_text(points: list[list[float]], angles: Floats, speed: float, level: str) -> str:
    """A job that stands at the first point and goes straight to the others; the last end is exact."""
    rows = [",".join([f"{x:.4f}" for x in point] + [f"{a / deg:.4f}" for a in angles]) for point in points]
    lines = ["/JOB", "//NAME RUN", "//POS", f"///NPOS {len(rows)},0,0,0,0,0", "///TOOL 1", "///POSTYPE BASE"]
    lines += ["///RECTAN", "///RCONF " + ",".join(24 * "0")]
    lines += [f"C{i:05d}={row}" for i, row in enumerate(rows)]
    lines += ["//INST", "///DATE 2026/11/20 10:00", "///ATTR SC,RW,BASE", "///GROUP1 RB1", "NOP"]
    lines += ["MOVJ C00000 VJ=1.00 PL=0"]
    tag = "" if level == "none" else f" PL={level}"
    lines += [f"MOVL C{i:05d} V={speed:.1f}{tag}" for i in range(1, len(rows) - 1)]
    last = " PL=0" if level != "none" or speed <= 10 else ""
    return "\r\n".join([*lines, f"MOVL C{len(rows) - 1:05d} V={speed:.1f}{last}", "END", ""])


def tool_text(tool: Floats) -> str:
    """TOOL.CND with tool 1 at that pose (4, 4) [mm]."""
    numbers = [*tool[:3, 3], *(angles_from_rotation(tool[:3, :3]) / deg)]
    blank = ["0.000,0.000,0.000", "0.000", "0.000,0.000,0.000", "0.000,0,1"]
    text = []
    for number, six in enumerate(([0.0] * 6, numbers)):
        row = ",".join(f"{v:.{3 if i < 3 else 4}f}" for i, v in enumerate(six))
        text += [f"//TOOL {number}", "///NAME", row, *blank]
    return "\r\n".join([*text, ""])


def segment(folder: Path, command: dict[str, str], work: Path) -> FromLog:
    """The moves of one run."""
    table = np.loadtxt(folder / command["file"], delimiter=",")
    joints = table[:, 1:7] * (deg if command["joint_units"] == "deg" else 1.0)
    tool_file = "torch.csv" if "streaming" in command["file"] else "weldgun_old.csv"
    tool = np.loadtxt(folder / "config" / tool_file, delimiter=",")
    turn = forward(ROBOT, joints[:1])[1][0] @ tool[:3, :3]
    points = [[float(x) for x in point.split()] for point in command["points_mm"].split(";")]
    (work / "TOOL.CND").write_text(tool_text(tool), encoding="ascii")
    text = job_text(points, angles_from_rotation(turn), float(command["V_mm_s"]), command["PL"])
    (work / "RUN.JBI").write_text(text, encoding="ascii", newline="")
    timing = plan_and_time(str(work / "RUN.JBI"), Job(robot="yaskawa/ma2010"))
    return moves_from_log(Log(table[:, 0], joints, (False,) * 6, file=command["file"]), timing)


def speed(count: int = 1_000_000) -> None:
    """Reads a log of `count` samples and 14 columns."""
    from time import perf_counter

    from olp.identification.recording.log_reader import read_log
    from olp.identification.recording.writer import log_csv

    rng = np.random.default_rng(0)
    axes, currents = np.cumsum(rng.normal(size=(count, 6)), 0) * 1e-4, rng.normal(size=(count, 6))
    log = Log(np.arange(count) * 0.004, axes, (False,) * 6, current=currents, move=np.full(count, -1))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "log.csv"
        file.write_bytes(log_csv(log))
        started = perf_counter()
        read_log(file)
        took = perf_counter() - started
        print(
            f"{count:,} rows x 14 columns, {file.stat().st_size / 1e6:.0f} MB: {took:.2f} s, {count / took:,.0f} rows/s"
        )


def main(folder: Path) -> None:
    with (folder / "commands.csv").open(encoding="utf-8", newline="") as file:
        commands = [row for row in csv.DictReader(file) if "MOVL" in row["motion"]]
    runs = [row for row in commands if "blending_test" in row["file"] and OTHER_GROUP not in row["file"]]
    print(
        f"{'run':<52}{'moves':>6}{'seen':>6}{'first s':>9}{'second s':>9}{'total s':>9}{'inner s':>9}{'more s':>8}"
    )
    more: dict[str, list[float]] = {}
    halves: list[Floats] = []
    seen = asked = 0
    with tempfile.TemporaryDirectory() as work:
        for row in runs:
            made = segment(folder, row, Path(work))
            duration = made.moves.duration
            count = len(row["points_mm"].split(";")) - 1
            at_rest_last = "movel_test" not in row["file"]
            inner = read(folder, at_rest_last, row["file"])[0].total
            seen, asked = seen + len(duration), asked + count
            if "linear" in row["file"] and "/pl" in row["file"] and count == 2 and row["PL"] not in "012":
                halves.append(duration)
            more.setdefault(row["V_mm_s"], []).append(float(duration.sum()) - inner)
            shown = [f"{d:9.3f}" for d in (*duration[:2], duration.sum(), inner, duration.sum() - inner)]
            name = row["file"].removeprefix("blending_test/").removesuffix(".csv")
            print(f"{name:<52}{count:>6}{len(duration):>6}{''.join(shown)}")
            for told in made.diagnostics:
                if told.code in ("D042", "D043") and str(told.severity) == "warning":
                    print(f"    {told.code} {told.message}")
    print(f"\nmoves seen: {seen} of {asked} (asked: all)")
    for name, law, values in zip(("first", "second"), (3.75, 5.0), np.transpose(halves), strict=True):
        spread = f"{np.median(values):.3f} s, {values.min():.3f} to {values.max():.3f} s"
        print(f"{len(values)} straight runs, PL=3..8, {name} move: {spread} (law of the overlap: {law} s)")
    for speed, values in more.items():
        middle, scatter = np.median(values), np.std(values)
        print(f"V = {speed:>3} mm/s: {len(values)} runs longer by {middle:.3f} s, scatter {scatter:.3f} s")


if __name__ == "__main__":
    speed() if sys.argv[1] == "--speed" else main(Path(sys.argv[1]))
