"""`olp diff`: CPU seconds for two 2,000-line versions, and how often 200 scripted edits are named for what they are.

    python bench/diff.py [--edits 200] [--lines 2000]

An edit changes one thing of a generated job: a point, a speed, a position level, a wait, a tool, a line more or less.
It is named when the change with the largest seconds among those that are not "its neighbour changed" has the cause of
the edit, and the parts must add up to the whole.
"""

from __future__ import annotations

import argparse
import random
import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from olp.checks.difference.compare import Cause, ProgramDifference  # noqa: E402
from olp.checks.difference.versions import open_versions  # noqa: E402
from olp.reports.batch import Job  # noqa: E402

Lines = list[str]
_POINT = re.compile(r"C(\d{5})=([-\d.]+),(.*)")


def job(moves: int, draw: random.Random) -> Lines:
    """The lines of a job that goes on from place to place, 60 to 180 mm each time."""
    place = [950.0, 0.0, 450.0]
    points, body = [], []
    for n in range(moves):
        place = [
            min(max(p + draw.choice((-1, 1)) * draw.uniform(35, 105), low), high)
            for p, low, high in zip(place, (700, -450, 200), (1200, 450, 700), strict=True)
        ]
        turn = draw.uniform(-4, 4)
        points.append(
            f"C{n:05d}={place[0]:.3f},{place[1]:.3f},{place[2]:.3f},178.2610,1.5083,{turn - 29.84:.4f}"
        )
        level = draw.choice(("PL=0", "PL=1", "PL=2", "PL=3"))
        body.append(f"MOVL C{n:05d} V={draw.uniform(40, 400):.1f} {level}")
        if n % 9 == 4:
            body.append(f"TIMER T={draw.uniform(0.1, 0.9):.2f}")
        if n % 13 == 7:
            body.append(f"DOUT OT#({1 + n % 200}) ON")
    head = [
        "/JOB",
        "//NAME PART",
        "//POS",
        f"///NPOS {moves},0,0,0,0,0",
        "///TOOL 1",
        "///POSTYPE BASE",
        "///RECTAN",
    ]
    head += ["///RCONF 1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0"]
    return [
        *head,
        *points,
        "//INST",
        "///DATE 2026/04/11 09:22",
        "///ATTR SC,RW",
        "///GROUP1 RB1",
        "NOP",
        *body,
        "END",
    ]


def _some(lines: Lines, draw: random.Random, pattern: str) -> int:
    found = [n for n, line in enumerate(lines) if re.search(pattern, line)]
    return draw.choice(found[3:-3])


def moved(lines: Lines, draw: random.Random) -> Cause:
    row = _some(lines, draw, r"^C\d+=")
    name, x, rest = _POINT.fullmatch(lines[row]).groups()
    lines[row] = f"C{name}={float(x) + draw.choice((-1, 1)) * draw.uniform(3, 60):.3f},{rest}"
    return Cause.POINT


def turned(lines: Lines, draw: random.Random) -> Cause:
    row = _some(lines, draw, r"^C\d+=")
    start, _, angle = lines[row].rpartition(",")
    lines[row] = f"{start},{float(angle) + draw.choice((-1, 1)) * draw.uniform(8, 40):.4f}"
    return Cause.POINT


def faster(lines: Lines, draw: random.Random) -> Cause:
    row = _some(lines, draw, r"^MOVL")
    scale = draw.choice((0.5, 0.8, 1.3, 2.0))
    lines[row] = re.sub(r"V=([\d.]+)", lambda m: f"V={float(m[1]) * scale:.1f}", lines[row])
    return Cause.SPEED


def stop(lines: Lines, draw: random.Random) -> Cause:
    row = _some(lines, draw, r"PL=[123]")
    lines[row] = re.sub(r"PL=\d", "PL=0", lines[row])
    return Cause.STOP


def no_stop(lines: Lines, draw: random.Random) -> Cause:
    # Not where the arm stands anyway, for a wait.
    pattern = r"PL=0"
    row = _some(lines, draw, pattern)
    while lines[row + 1].startswith("TIMER"):
        row = _some(lines, draw, pattern)
    lines[row] = lines[row].replace("PL=0", "PL=2")
    return Cause.NO_STOP


def zone(lines: Lines, draw: random.Random) -> Cause:
    row = _some(lines, draw, r"PL=1")
    while lines[row + 1].startswith("TIMER"):
        row = _some(lines, draw, r"PL=1")
    lines[row] = lines[row].replace("PL=1", "PL=3")
    return Cause.BLEND


def waits(lines: Lines, draw: random.Random) -> Cause:
    row = _some(lines, draw, r"^TIMER")
    lines[row] = f"TIMER T={draw.uniform(1.0, 3.0):.2f}"
    return Cause.WAIT


def added(lines: Lines, draw: random.Random) -> Cause:
    row = _some(lines, draw, r"^MOVL")
    if draw.random() < 0.5:
        lines.insert(row, f"TIMER T={draw.uniform(0.2, 2.0):.2f}")
    else:
        lines.insert(row, f"MOVL C{draw.randrange(10):05d} V={draw.uniform(40, 400):.1f} PL=0")
    return Cause.ADDED


def removed(lines: Lines, draw: random.Random) -> Cause:
    del lines[_some(lines, draw, r"^(MOVL|TIMER)")]
    return Cause.REMOVED


def joint(lines: Lines, draw: random.Random) -> Cause:
    row = _some(lines, draw, r"^MOVL")
    lines[row] = re.sub(r"MOVL (C\d+) V=[\d.]+", r"MOVJ \1 VJ=20.00", lines[row])
    return Cause.PATH


def accelerates(lines: Lines, draw: random.Random) -> Cause:
    lines[row] = f"{lines[row := _some(lines, draw, r'^MOVL')]} ACC={draw.randrange(20, 60)} DEC=50"
    return Cause.ACCELERATION


def tool(lines: Lines, draw: random.Random) -> Cause:
    """The point is taught with another tool: a record in front of it, and the old one behind it."""
    row = _some(lines, draw, r"^C\d+=")
    lines[row + 1 : row + 1] = ["///TOOL 1"]
    lines[row:row] = ["///TOOL 2"]
    return Cause.TOOL


EDITS: tuple[Callable[[Lines, random.Random], Cause], ...] = (
    moved, turned, faster, stop, no_stop, zone, waits, added, removed, joint, accelerates, tool,
)  # fmt: skip
_SETTINGS = """robot = "yaskawa/ma2010"

[tools]
1 = [12.4, -7.1, 310.2, 3.1, -41.2, 7.4]
2 = [31.0, 9.3, 262.7, -8.2, -33.1, 20.9]
"""


def versions(folder: Path, old: Lines, new: Lines) -> ProgramDifference:
    for name, lines in (("old", old), ("new", new)):
        (folder / name).mkdir(exist_ok=True)
        (folder / name / "olp.toml").write_text(_SETTINGS)
        (folder / name / "PART.JBI").write_text("\r\n".join([*lines, ""]), newline="")
    with open_versions(str(folder / "old" / "PART.JBI"), str(folder / "new" / "PART.JBI")) as found:
        return found.compare(found.pairs[0], Job())


def named(found: ProgramDifference) -> Cause | None:
    own = [c for c in found.changes if c.cause is not Cause.NEIGHBOUR]
    return max(own, key=lambda c: abs(c.change_s)).cause if own else None


def edits(count: int) -> None:
    draw = random.Random(20260412)
    right: Counter[str] = Counter()
    tried: Counter[str] = Counter()
    wrong, gap, exact = [], 0.0, 0
    with tempfile.TemporaryDirectory() as name:
        for n in range(count):
            old = job(60, draw)
            new = list(old)
            edit = EDITS[n % len(EDITS)]
            cause = edit(new, draw)
            found = versions(Path(name), old, new)
            assert found.change_s is not None, found.why
            gap = max(gap, abs(sum(c.change_s for c in found.changes) - found.change_s))
            tried[cause] += 1
            right[cause] += named(found) is cause
            exact += sum(c.cause is not Cause.NEIGHBOUR for c in found.changes) == 1
            if named(found) is not cause:
                wrong.append(f"{n}: {edit.__name__} called {named(found)}")
    print(f"{'edit':32s} {'named':>6s} {'of':>5s}")
    for cause, number in tried.items():
        print(f"{cause:32s} {right[cause]:6d} {number:5d}")
    total = sum(right.values())
    print(f"{'all':32s} {total:6d} {count:5d}  {total / count:.1%}")
    print(f"nothing else is named beside neighbours: {exact} of {count}")
    print(f"largest gap between the sum of the parts and the whole: {gap:.1e} s")
    print("\n".join(wrong))


def shifted(lines: Lines, first: int, last: int) -> Lines:
    """Points `first` to `last` all moved: nothing in between says where one belongs."""
    return [
        re.sub(r"=([-\d.]+),", lambda m: f"={float(m[1]) + 7.3:.3f},", line)
        if re.match(r"C\d+=", line) and first <= int(line[1:6]) < last
        else line
        for line in lines
    ]


def speed(lines: int) -> None:
    draw = random.Random(3)
    old = job(round(lines / 1.187), draw)
    new = list(old)
    for _ in range(20):
        for edit in EDITS:
            edit(new, draw)
    for says, other in (
        ("240 edits", new),
        ("all points moved", shifted(old, 0, 99999)),
        ("300 points in a row moved", shifted(old, 400, 700)),
        ("another program", job(round(lines / 1.187), draw)),
    ):
        with tempfile.TemporaryDirectory() as name:
            start, wall = time.process_time(), time.perf_counter()
            found = versions(Path(name), old, other)
            cpu, wall = time.process_time() - start, time.perf_counter() - wall
        assert found.change_s is not None, found.why
        statements, count = len(old) - old.index("NOP"), len(found.changes)
        print(f"{statements} lines, {says:27s} {count:5d} changes {cpu:6.2f} s CPU {wall:6.2f} s")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--edits", type=int, default=200)
    parser.add_argument("--lines", type=int, default=2000)
    given = parser.parse_args()
    speed(given.lines)
    edits(given.edits)
