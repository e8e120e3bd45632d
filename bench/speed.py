"""How fast olp is: `python bench/speed.py`. Prints asked and measured; exit status 1 when a figure is missed.

Everything is generated here and measured in processes of its own; CPU times are user plus system.
"""

from __future__ import annotations

import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from plain_lark import count_lines

ROOT = Path(__file__).resolve().parent.parent
MOVES = 100_000
SMALL_JOBS, SMALL_MOVES = 10_000, 30
ROBOT = "yaskawa/ma2010"
RCONF = "///RCONF 1" + ",0" * 23

READ = """
import sys, time, olp
olp.read(sys.argv[2])                       # imports and tables are paid once per process
best = min(timed for _ in range(5) for start in [time.process_time()]
           for _ in [olp.read(sys.argv[1])] for timed in [time.process_time() - start])
print(best)
"""
WHOLE = """
import sys, olp
table = olp.read(sys.argv[1]).plan().time()
print(table["duration_s"].gt(0).sum())
"""


class Figure(NamedTuple):
    name: str
    asked: str
    measured: str
    held: bool


class Run(NamedTuple):
    """A finished process: CPU time, wall time [s], peak memory [MB], exit status, and what it printed."""

    cpu: float
    wall: float
    peak: float
    status: int
    text: str


def main() -> int:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        figures = [*large_job(folder), *many_jobs(folder), *small_process(folder)]
    print("| figure | asked | measured |\n|---|---|---|")
    for figure in figures:
        print(f"| {figure.name} | {figure.asked} | {figure.measured}{'' if figure.held else ' **missed**'} |")
    print(
        f"\n{sys.version.split()[0]}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} while measuring"
    )
    return 0 if all(figure.held for figure in figures) else 1


def large_job(folder: Path) -> Iterator[Figure]:
    """One CAM job of 100,000 moves."""
    text = job("LARGE", MOVES)
    large, tiny = folder / "large" / "LARGE.JBI", folder / "large" / "TINY.JBI"
    write(large, text)
    write(tiny, job("TINY", 12))
    (large.parent / "olp.toml").write_text(f'robot = "{ROBOT}"\n')
    lines = text.count("\n")
    rate = lines / float(run("-c", READ, large, tiny).text)
    start = time.process_time()
    known = count_lines(text)
    plain = known / (time.process_time() - start)
    yield Figure(
        f"reading {lines:,} lines alone, CPU", "≥ 150,000 lines/s", f"{rate:,.0f} lines/s", rate >= 150_000
    )
    yield Figure(
        "… against one plain lark LALR parse of the same text in the same run",
        "≥ 8 ×",
        f"{rate / plain:.1f} × ({plain:,.0f} lines/s)",
        rate >= 8 * plain and known >= lines - 20,
    )
    whole = run("-c", WHOLE, large)
    complete = int(whole.text) >= MOVES - 1  # nothing is known of the way to the first point
    yield Figure(
        "read + plan + time, whole process, CPU", "≤ 4 s", f"{whole.cpu:.2f} s", whole.cpu <= 4 and complete
    )
    yield Figure("… peak memory", "≤ 400 MB", f"{whole.peak:.0f} MB", whole.peak <= 400)


def many_jobs(folder: Path) -> Iterator[Figure]:
    """A folder of 10,000 jobs of 30 moves."""
    small = folder / "small"
    for number in range(SMALL_JOBS):
        write(
            small / f"{number // 500:02d}" / f"JOB-{number:05d}.JBI",
            job(f"JOB-{number:05d}", SMALL_MOVES, number),
        )
    for part in sorted(small.iterdir()):
        (part / "olp.toml").write_text(f'robot = "{ROBOT}"\n')
    done = run("-m", "olp", "time", small, "--format", "json")
    programs = done.text.count('"total_s"')
    rate = programs / done.wall
    name = f"{SMALL_JOBS:,} jobs of {SMALL_MOVES} moves, `olp time FOLDER --format json`, wall"
    measured = (
        f"{rate:,.0f} jobs/s ({done.cpu / programs * 1000:.2f} ms CPU a job)" if programs else "no answer"
    )
    yield Figure(name, "≥ 300 jobs/s", measured, rate >= 300 and programs == SMALL_JOBS and not done.status)


def small_process(folder: Path) -> Iterator[Figure]:
    """What somebody at a prompt waits for."""
    target = folder / "one" / "ONE.JBI"
    write(target, job("ONE", 91))
    (target.parent / "olp.toml").write_text(f'robot = "{ROBOT}"\n')
    lines = target.read_text().count("\n")
    cpu = statistics.median(run("-m", "olp", "time", target).cpu for _ in range(5))
    yield Figure(
        f"`olp time` on a job of {lines} lines, whole process, CPU", "≤ 0.8 s", f"{cpu:.2f} s", cpu <= 0.8
    )
    cpu = statistics.median(run("-m", "olp", "--help").cpu for _ in range(5))
    yield Figure("`olp --help`, whole process, CPU", "< 0.3 s", f"{cpu:.2f} s", cpu < 0.3)


def job(name: str, moves: int, seed: int = 0) -> str:
    """A raster over a curved sheet in front of the robot: one C point and one MOVL per move."""
    points, lines = [], []
    for index in range(moves):
        points.append(f"C{index:05d}=" + ",".join(pose(index, seed)))
        speed = 95.5 if index % 17 < 3 else 131.5 if index % 29 else 187.0
        lines.append(f"MOVL C{index:05d} V={speed:.1f}" if index else "MOVJ C00000 VJ=37.50")
    head = [
        "/JOB",
        f"//NAME {name}",
        "//POS",
        f"///NPOS {moves},0,0,0,0,0",
        "///TOOL 0",
        "///POSTYPE BASE",
        "///RECTAN",
        RCONF,
    ]
    middle = ["//INST", "///DATE 2026/05/21 11:36", "///ATTR SC,RW", "///GROUP1 RB1", "NOP"]
    return "\r\n".join([*head, *points, *middle, *lines, "END", ""])


def pose(index: int, seed: int) -> tuple[str, ...]:
    """Millimetres and degrees, as the controller writes them."""
    row, column = divmod(index, 331)
    x = 1043.7 + 1.13 * (column if row % 2 == 0 else 330 - column) + 0.0131 * (seed % 997)
    y = -271.3 + 1.77 * (row % 307) + 0.0173 * (seed % 1009)
    z = -83.9 + 27.1 * math.sin(0.0131 * x) + 19.3 * math.cos(0.0173 * y)
    angles = (176.413 + 0.0027 * column, -3.917 + 0.0031 * (row % 307), 11.273 + 0.0043 * column)
    return (f"{x:.3f}", f"{y:.3f}", f"{z:.3f}", *(f"{angle:.4f}" for angle in angles))


def write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text.encode("ascii"))


def run(*words: object) -> Run:
    """Runs python with `words` and waits for it and its own children."""
    command: Sequence[str] = [sys.executable, *map(str, words)]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    with tempfile.TemporaryFile() as output:
        start = time.perf_counter()
        process = subprocess.Popen(command, stdout=output, env=environment)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        text = output.read().decode()
    return Run(usage.ru_utime + usage.ru_stime, wall, usage.ru_maxrss / 1024, process.returncode, text)


if __name__ == "__main__":
    sys.exit(main())
