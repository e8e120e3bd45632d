"""How few edits `olp fit` needs, and whether its answers hold.

    python bench/fit.py small [COUNT [SEED]]   made programs of up to 8 moves against all sets of edits
    python bench/fit.py real FOLDER [MOST]     programs below FOLDER, 5, 10 and 20 % faster
    python bench/fit.py speed                  made programs of 200 and 2,000 lines

Every answer is written to a file, read again and timed anew; the deviation at its corners is measured on that motion.
"""

from __future__ import annotations

import random
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

import numpy as np

from olp.checks.fit.choices import Allowed, apply, choices
from olp.checks.fit.fit import Fit, deviation, fit
from olp.core.diagnostic import OlpError
from olp.core.units import mm
from olp.ir.program import Program
from olp.languages.read import read
from olp.languages.vendor import vendor_suffixes
from olp.reports.batch import Job, time_program
from olp.timing.timing import Timing

ROBOTS = {
    "inform": "yaskawa/gp25",
    "krl": "kuka/kr16-2",
    "rapid": "abb/irb4600-20-2.50",
    "tp": "fanuc/m20ia",
    "urscript": "universal-robots/ur10e",
}
WITHIN = 2.0  # mm
FASTEST = 1.0  # m/s, of the tool in real programs
TARGETS = (0.05, 0.10, 0.20)


def job_text(choose: random.Random, moves: int) -> str:
    """A job of lines in front of the robot, with corners, stops and waits."""
    rows, body = [], []
    place = np.array([900.0, 0.0, 500.0])
    for n in range(moves):
        place = np.clip(
            place + np.array([choose.uniform(-160, 160) for _ in range(3)]),
            (700, -350, 250),
            (1150, 350, 800),
        )
        rows.append(f"C{n:05d}={place[0]:.3f},{place[1]:.3f},{place[2]:.3f},180.0000,0.0000,0.0000")
        if n == 0 or choose.random() < 0.2:
            body.append(
                f"MOVJ C{n:05d} VJ={choose.choice((12.5, 25.0, 50.0)):.2f} PL={choose.choice((0, 1))}"
            )
        else:
            speed, level = choose.choice((100, 200, 300, 600)), choose.choice((0, 0, 1, 2, 4))
            body.append(f"MOVL C{n:05d} V={speed:.1f} PL={level}")
        if choose.random() < 0.15:
            body.append("TIMER T=0.20")
    head = [
        "/JOB",
        "//NAME MADE",
        "//POS",
        f"///NPOS {moves},0,0,0,0,0",
        "///TOOL 0",
        "///POSTYPE BASE",
        "///RECTAN",
    ]
    head += [
        "///RCONF 1,0,0,0,0,0,0,0",
        *rows,
        "//INST",
        "///DATE 2026/01/01 08:00",
        "///ATTR SC,RW",
        "///GROUP1 RB1",
    ]
    return "\r\n".join([*head, "NOP", *body, "END", ""])


def timed(program: Program, robot: str, folder: Path) -> Timing:
    return time_program(program, Job(robot=robot), folder)


def replayed(found: Fit, path: Path, robot: str, within: float) -> list[str]:
    """What is wrong with an answer that is written, read and timed anew."""
    path.write_bytes(found.program.source.raw)
    again = timed(read(path), robot, path.parent)
    wrong = []
    if abs(again.total_s - found.timing.total_s) > 1e-9:
        wrong.append(f"replay {again.total_s - found.timing.total_s:+.3g} s")
    far = max((deviation(again, one.choice.line) for one in found.edits if one.choice.zone >= 0), default=0.0)
    if far > within * mm + 1e-9:
        wrong.append(f"corner {far / mm:.3f} mm")
    if found.reached != (again.total_s <= found.to_s + 1e-9):
        wrong.append("reached or not")
    return wrong


def fewest(
    program: Program, base: Timing, robot: str, to_s: float, folder: Path, allowed: Allowed
) -> int | None:
    """The smallest number of edits, all sets of the largest choices tried one after the other."""
    places: dict[tuple[str, int], list[object]] = {}
    for one in choices(program, base, allowed):
        places.setdefault(one.place, []).append(one)
    known: list[list[object]] = []
    for found in places.values():
        kept = []
        for one in found[::-1]:
            timing = timed(apply(program, [one]), robot, folder)
            if one.zone < 0 or deviation(timing, one.line) <= allowed.within:
                kept.append(one)
                break
        known += [kept] if kept else []
    for count in range(len(known) + 1):
        for some in combinations(known, count):
            chosen = [one[0] for one in some]
            timing = timed(apply(program, chosen), robot, folder)
            if timing.total_s <= to_s + 1e-9 and all(
                one.zone < 0 or deviation(timing, one.line) <= allowed.within for one in chosen
            ):
                return count
    return None


def small(count: int, seed: int) -> None:
    robot, allowed = ROBOTS["inform"], Allowed(WITHIN * mm, 0.9)
    sums: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for number in range(count):
            choose = random.Random(f"{seed} {number}")
            path = folder / "made.jbi"
            path.write_text(job_text(choose, choose.randint(3, 5)))
            program = read(path)
            base = timed(program, robot, folder)
            if base.untimed:
                sums["not timed"] += 1
                continue
            for share in TARGETS:
                to_s = base.total_s * (1 - share)
                found = fit(program, to_s, lambda one: timed(one, robot, folder), allowed)
                best = fewest(program, base, robot, to_s, folder, allowed)
                sums["asked"] += 1
                sums["wrong"] += bool(replayed(found, path.with_name("out.jbi"), robot, WITHIN))
                if best is None:
                    sums["infeasible"] += 1
                    sums["found though no set of largest choices is enough"] += found.reached
                    continue
                sums["feasible"] += 1
                sums["feasible and found"] += found.reached
                if found.reached:
                    more = len(found.edits) - best
                    sums[f"edits more than the fewest: {more}"] += 1
    for key, value in sorted(sums.items()):
        print(f"{value:6} {key}")


def programs(folder: Path) -> Iterator[Path]:
    """Programs below the folder, one of each of its folders in turn."""
    suffixes = vendor_suffixes()
    rows = [
        [
            path
            for path in sorted(one.rglob("*"))
            if path.name.lower().endswith(suffixes) and path.is_file() and path.stat().st_size < 300_000
        ]
        for one in sorted(path for path in folder.iterdir() if path.is_dir())
    ]
    for number in range(max(map(len, rows), default=0)):
        yield from (row[number] for row in rows if number < len(row))


def real(folder: Path, most: int) -> None:
    sums: Counter[str] = Counter()
    slowest: list[tuple[float, str]] = []
    why: Counter[str] = Counter()
    jobs = 0
    with tempfile.TemporaryDirectory() as name:
        for path in programs(folder):
            if jobs >= most:
                break
            try:
                program = read(path)
                robot = ROBOTS.get(program.vendor)
                if robot is None:
                    continue
                base = timed(program, robot, path.parent)
            except OlpError:
                continue
            if (
                not len(base.plan.moves)
                or base.untimed
                or any(d.is_error for d in base.diagnostics)
                or base.motion_s < 0.5
            ):
                sums["left out: cannot be timed whole, or hardly moves"] += 1
                continue
            jobs += 1
            for share in TARGETS:
                begin = time.process_time()
                run = lambda one, robot=robot, path=path: timed(one, robot, path.parent)  # noqa: E731
                found = fit(program, base.total_s * (1 - share), run, Allowed(WITHIN * mm, FASTEST))
                seconds = time.process_time() - begin
                slowest.append((seconds, f"{path.name}, {len(program.source.lines)} lines"))
                what = "reached" if found.reached else "the best is told"
                sums[f"{share:4.0%} faster: {what}"] += 1
                if not found.reached and share == TARGETS[0]:
                    why[found.limits[0].split(" s, ")[-1].partition(":")[0]] += 1
                out = Path(name) / path.name
                sums["answers that do not hold"] += found.reached and bool(
                    _replayed_there(found, out, path, robot)
                )
    print(f"{jobs} programs")
    for key, value in sorted(sums.items()):
        print(f"{value:6} {key}")
    print(f"what rules the longest line where {TARGETS[0]:.0%} are not reached:", dict(why.most_common(6)))
    for seconds, what in sorted(slowest)[-3:]:
        print(f"{seconds:6.2f} s of CPU: {what}")


def _replayed_there(found: Fit, out: Path, path: Path, robot: str) -> list[str]:
    """Timed with what stands beside the program itself."""
    out.write_bytes(found.program.source.raw)
    again = timed(apply(found.program, []), robot, path.parent)
    wrong = [] if abs(again.total_s - found.timing.total_s) <= 1e-9 else ["replay"]
    return wrong + ["lines"] * (len(out.read_bytes().splitlines()) != len(path.read_bytes().splitlines()))


def speed() -> None:
    robot = ROBOTS["inform"]
    with tempfile.TemporaryDirectory() as name:
        for moves in (90, 900):
            path = Path(name) / "made.jbi"
            path.write_text(job_text(random.Random(1), moves))
            program = read(path)
            base = timed(program, robot, path.parent)
            for share in TARGETS:
                begin, wall = time.process_time(), time.perf_counter()
                found = fit(
                    program,
                    base.total_s * (1 - share),
                    lambda one: timed(one, robot, Path(name)),
                    Allowed(WITHIN * mm),
                )
                print(
                    f"{len(program.source.lines):5} lines, {share:3.0%}: {time.process_time() - begin:6.2f} s of CPU,"
                    f" {time.perf_counter() - wall:6.2f} s; {len(found.edits)} edits,"
                    f" {'reached' if found.reached else 'not reached'}"
                )


def main(words: list[str]) -> None:
    if words[:1] == ["small"]:
        small(int(words[1]) if len(words) > 1 else 20, int(words[2]) if len(words) > 2 else 1)
    elif words[:1] == ["real"] and len(words) > 1:
        real(Path(words[1]), int(words[2]) if len(words) > 2 else 200)
    elif words == ["speed"]:
        speed()
    else:
        print(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
