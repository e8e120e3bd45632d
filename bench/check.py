"""How long `olp check` takes over many jobs, the first time and again with nothing changed, and how often budgets that
hold are called broken when recordings scatter.

    python bench/check.py [--jobs 10000] [--moves 30] [--workers 2]
    python bench/check.py --alarms [--recordings 1000]
"""

from __future__ import annotations

import argparse
import random
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
POSE = "178.2610,1.5083,-29.8410"


def job(name: str, moves: int, draw: random.Random) -> str:
    """A job of `moves` moves, a few waits and outputs, at generic places."""
    points = [
        f"C{n:05d}={draw.uniform(700, 1200):.3f},{draw.uniform(-400, 400):.3f},{draw.uniform(200, 700):.3f},{POSE}"
        for n in range(moves)
    ]
    body = []
    for n in range(moves):
        if n % 10 == 5:
            body += [f"TIMER T={draw.uniform(0.05, 0.4):.2f}", f"DOUT OT#({n}) ON"]
        level = draw.choice(("PL=0", "PL=1", "PL=3", ""))
        speed = f"VJ={draw.uniform(20, 90):.2f}" if n % 6 == 0 else f"V={draw.uniform(50, 900):.1f}"
        body.append(f"{'MOVJ' if n % 6 == 0 else 'MOVL'} C{n:05d} {speed} {level}".rstrip())
    head = ["/JOB", f"//NAME {name}", "//POS", f"///NPOS {moves},0,0,0,0,0", "///TOOL 0", "///POSTYPE BASE"]
    head += ["///RECTAN", "///RCONF 1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0"]
    tail = ["//INST", "///DATE 2026/04/11 09:22", "///ATTR SC,RW", "///GROUP1 RB1", "NOP", *body, "END"]
    return "\r\n".join([*head, *points, *tail, ""])


def write_jobs(folder: Path, jobs: int, moves: int) -> None:
    draw = random.Random(7)
    settings = 'robot = "yaskawa/ma2010"\n\n[[budget]]\nname = "cycle"\nlimit_s = 90.0\n'
    (folder / "olp.toml").write_text(settings)
    for n in range(jobs):
        cell = folder / f"cell{n // 100:03d}"
        cell.mkdir(exist_ok=True)
        (cell / f"J{n:05d}.JBI").write_text(job(f"J{n:05d}", moves, draw), newline="")


def timed(folder: Path, *arguments: str) -> tuple[float, float, str]:
    """Seconds of the wall clock and of all cores that `olp check` takes, and its last line."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    command = [sys.executable, "-m", "olp", "check", *arguments]
    done = subprocess.run(
        command,
        cwd=folder,
        env={"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"},
        text=True,
        capture_output=True,
    )
    wall = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    assert done.returncode in (0, 1), done.stdout[-2000:] + done.stderr[-2000:]
    return wall, cpu, done.stdout.strip().rpartition("\n")[2]


def speed(jobs: int, moves: int, workers: int) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_jobs(folder, jobs, moves)
        print(f"{'olp check':34s} {'wall s':>8s} {'CPU s':>8s}")
        for says in ("first run", "again, nothing changed", "again, one job changed"):
            if says.endswith("changed") and "one" in says:
                path = folder / "cell000" / "J00000.JBI"
                path.write_bytes(path.read_bytes().replace(b"V=", b"V=1", 1))
            wall, cpu, last = timed(folder, "--workers", str(workers))
            print(f"{says:34s} {wall:8.2f} {cpu:8.2f}  {last}")


def alarms(recordings: int) -> None:
    """Budgets on an end of the interval, judged with signatures of noisy recordings of one robot.

    The truth is the robot of the samples' UP20 recording. Each repeated recording has the durations of that one with
    noise of its own on every move (normal, 4 ms and 0.3 %); a signature is learnt from it and judges a job. The budget
    is held, but for two, to see what `lower` misses: with `lower` its limit stands `margin` above the time that the
    robot truly takes, with `upper` above the upper end that the recording without noise gives. With no margin half of
    the recordings must say otherwise there: the limit is then what the end itself scatters around.
    """
    import csv
    import shutil

    import numpy as np

    sys.path.insert(0, str(ROOT))
    from olp.checks.guard.budget import Budget
    from olp.checks.guard.run import judge
    from olp.identification.recording import read_recording
    from olp.identification.signature import calibrate, write_signature
    from olp.reports.batch import Job

    source = ROOT / "samples" / "up20"
    draw = np.random.default_rng(20260411)
    names = sorted(path.name for path in source.glob("*.JBI"))
    with (source / "moves.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    # Which end is judged, and the room of the limit as a share of the time; None: half the interval.
    margins = {
        "lower, true time": ("lower", 0.0),
        "lower, true time + 0.25 %": ("lower", 0.0025),
        "lower, true time - 1 %": ("lower", -0.01),
        "lower, true time - 3 %": ("lower", -0.03),
        "prediction, true time": ("prediction", 0.0),
        "prediction, true time + 0.5 %": ("prediction", 0.005),
        "upper, true time": ("upper", "truth"),
        "upper, upper end": ("upper", 0.0),
        "upper, upper end + 0.25 %": ("upper", 0.0025),
        "upper, upper end + 0.5 %": ("upper", 0.005),
        "upper, upper end + 1 %": ("upper", 0.01),
        "upper, upper end + half the interval": ("upper", None),
    }
    counts = dict.fromkeys(margins, 0)
    warned = dict.fromkeys(margins, 0)
    rooms = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "noisy"
        shutil.copytree(source, folder)
        signature = Path(name) / "signature.json"
        write_signature(calibrate(read_recording(source), "factors")[0], signature)
        truth = {job: judge(str(folder / job), (), Job(signature=str(signature))) for job in names}
        for number in range(recordings):
            noisy = [{**row, "duration_s": _noisy(row["duration_s"], draw)} for row in rows]
            with (folder / "moves.csv").open("w", newline="", encoding="utf-8") as out:
                writer = csv.DictWriter(out, fieldnames=list(rows[0]))
                writer.writeheader()
                writer.writerows(noisy)
            # A file of its own: what was read once from a path is kept.
            signature = Path(name) / f"signature-{number}.json"
            write_signature(calibrate(read_recording(folder), "factors")[0], signature)
            one = truth[names[number % len(names)]]
            budgets = []
            rooms.append(one.high_s / one.total_s - 1)
            for says, (end, share) in margins.items():
                slack = one.high_s - one.total_s if share is None else 0.0
                base = one.high_s if end == "upper" and share != "truth" else one.total_s
                slack = share * one.total_s if isinstance(share, float) else slack
                budgets.append(Budget(says, str(folder), 1, base + slack, on=end, signature=str(signature)))
            for item in judge(one.path, budgets, Job()).items:
                assert str(item.status) in ("held", "warned", "failed"), item
                counts[item.name] += str(item.status) == "failed"
                warned[item.name] += str(item.status) == "warned"
    print(f"upper end above the true time: {min(rooms):.2%} to {max(rooms):.2%}")
    print(f"{'on, limit':38s} {'called over':>12s} {'warned':>8s} {'of':>6s} {'share':>8s}")
    for says, wrong in counts.items():
        print(f"{says:38s} {wrong:12d} {warned[says]:8d} {recordings:6d} {wrong / recordings:8.2%}")


def _noisy(text: str, draw) -> str:
    return f"{float(text) * (1 + draw.normal(0, 0.003)) + draw.normal(0, 0.004):.6f}" if text else text


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--jobs", type=int, default=10_000)
    parser.add_argument("--moves", type=int, default=30)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--alarms", action="store_true")
    parser.add_argument("--recordings", type=int, default=1000)
    given = parser.parse_args()
    alarms(given.recordings) if given.alarms else speed(given.jobs, given.moves, given.workers)
