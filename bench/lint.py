"""`olp lint`: 20 planted mistakes per rule in clean programs, and what it says of clean programs.

    python bench/lint.py [--planted 20] [--clean 200]

Every program is generated: a path that stops only where something happens, with calls, waits, labels and tools. A
mistake is planted at a random place; it is found when its rule names its line. The clean programs are those before
the mistake was planted, and the samples of docs/lint.md.
"""

from __future__ import annotations

import argparse
import math
import random
import re
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from olp.checks.lint import all_rules  # noqa: E402
from olp.checks.lint.run import lint  # noqa: E402
from olp.reports.batch import Job  # noqa: E402

SAMPLES = tuple(ROOT / "samples" / "inform" / name for name in ("cam", "generations", "palletising", "twins"))
SETTINGS = """robot = "yaskawa/ma2010"

[tools]
1 = [12.4, -7.1, 310.2, 3.1, -41.2, 7.4]
2 = [31.0, 9.3, 262.7, -8.2, -33.1, 20.9]
"""
_TURN = (178.2610, 1.5083, -29.8410)


class Text(NamedTuple):
    """A job to plant in: its points, and its instructions. A mistake changes both lists in place."""

    points: list[str]
    body: list[str]

    def lines(self) -> list[str]:
        head = [
            "/JOB",
            "//NAME PART",
            "//POS",
            f"///NPOS {sum(p.startswith('C') for p in self.points)},0,0,0,0,0",
        ]
        head += [
            "///TOOL 1",
            "///POSTYPE BASE",
            "///RECTAN",
            "///RCONF 1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0",
        ]
        tail = [
            "//INST",
            "///DATE 2026/04/11 09:22",
            "///ATTR SC,RW",
            "///GROUP1 RB1",
            "NOP",
            *self.body,
            "END",
        ]
        return [*head, *self.points, *tail]

    def line_of(self, row: str) -> int:
        return 1 + self.lines().index(row)

    def moves(self) -> list[int]:
        """Rows of the path moves in the middle of the body, in order."""
        found = [n for n, row in enumerate(self.body) if row.startswith("MOVL")]
        return found[3:-3]


def point(number: int, place: list[float], turn: tuple[float, ...] = _TURN) -> str:
    return f"C{number:05d}={','.join(f'{v:.3f}' for v in place)},{','.join(f'{a:.4f}' for a in turn)}"


def clean(draw: random.Random, count: int = 24) -> Text:
    """A path that bends gently, in pieces of 60 to 120 mm; it stops where an output is set or something is awaited."""
    text = Text([], [])
    place, heading = [draw.uniform(840, 960), -340.0, draw.uniform(420, 560)], 1.6
    for n in range(count):
        text.points.append(point(n, place, (_TURN[0], _TURN[1], _TURN[2] + draw.uniform(-1, 1))))
        stops = n % 6 == 5
        level = "PL=0" if stops else f"PL={draw.choice((1, 2))}"
        kind, speed = ("MOVJ", "VJ=25.00") if n == 0 else ("MOVL", f"V={draw.uniform(60, 300):.1f}")
        text.body.append(f"{kind} C{n:05d} {speed} {level}")
        if stops:
            text.body.append(
                draw.choice((f"DOUT OT#({n}) ON", f"TIMER T=0.{n + 10}", f"WAIT IN#({n})=ON T=2.50"))
            )
        # Round the middle of the reach, so that the way never leads out of it.
        heading = 1.6 + 2 * math.pi * n / count + draw.uniform(-0.25, 0.25)
        step = draw.uniform(60, 80)
        place = [
            place[0] + step * math.cos(heading),
            place[1] + step * math.sin(heading),
            place[2] + draw.uniform(-9, 9),
        ]
    return text


Plant = Callable[[Text, random.Random], str]  # returns the row that the rule must name


def _number(row: str) -> int:
    return int(re.search(r"C(\d+)", row)[1])


def _place(text: Text, row: str) -> list[float]:
    taught = next(p for p in text.points if p.startswith(f"C{_number(row):05d}="))
    return [float(v) for v in taught.partition("=")[2].split(",")[:3]]


def _insert_near(
    text: Text, draw: random.Random, way: float, turn: float = 0.0, ending: str = "V=100.0 PL=1"
) -> str:
    """A further move, `way` mm on from a move in the middle and turned by `turn` degrees."""
    at = draw.choice([n for n in text.moves() if "PL=0" not in text.body[n]])
    x, y, z = _place(text, text.body[at])
    number = len([p for p in text.points if p.startswith("C")])
    text.points.append(point(number, [x + 0.6 * way, y + 0.8 * way, z], (*_TURN[:2], _TURN[2] + turn)))
    row = f"MOVL C{number:05d} {ending}"
    text.body.insert(at + 1, row)
    return row


def exact_stop(text: Text, draw: random.Random) -> str:
    at = draw.choice(
        [n for n in text.moves() if "PL=0" not in text.body[n] and text.body[n + 1].startswith("MOVL")]
    )
    text.body[at] = re.sub(r"PL=\d", "PL=0", text.body[at])
    return text.body[at]


def speed(text: Text, draw: random.Random) -> str:
    return _insert_near(text, draw, draw.uniform(4, 12), ending=f"V={draw.uniform(900, 1500):.1f} PL=0")


def long_zone(text: Text, draw: random.Random) -> str:
    return _insert_near(text, draw, draw.uniform(5, 25), ending=f"V=100.0 PL={draw.choice((7, 8))}")


def turn(text: Text, draw: random.Random) -> str:
    return _insert_near(
        text, draw, draw.uniform(15, 40), draw.choice((-1, 1)) * draw.uniform(60, 110), "V=300.0 PL=0"
    )


def outside(text: Text, draw: random.Random) -> str:
    at = draw.choice(text.moves())
    number = _number(text.body[at])
    row = next(n for n, p in enumerate(text.points) if p.startswith(f"C{number:05d}="))
    text.points[row] = point(number, [draw.uniform(2600, 4000), 100.0, 500.0])
    return text.body[at]


def singular(text: Text, draw: random.Random) -> str:
    """Two points taught in pulses, the wrist bent one way before and the other way behind."""
    at = draw.choice(text.moves())
    number = len([p for p in text.points if p.startswith("C")])
    base = [draw.randrange(-9000, 9000), draw.randrange(-20000, -9000), draw.randrange(-40000, -20000)]
    bend = draw.randrange(6000, 14000)
    text.points.append("///POSTYPE PULSE")
    text.points.append("///PULSE")
    roll = draw.randrange(-4000, 4000)
    for sign in (1, -1):
        axes = [*base, roll, sign * bend, draw.randrange(-500, 500)]
        text.points.append(f"C{number + (sign < 0):05d}={','.join(map(str, axes))}")
    rows = [
        f"MOVJ C{number:05d} VJ=20.00 PL=0",
        f"MOVL C{number + 1:05d} V=20.0 PL=0",
        "MOVJ C00001 VJ=20.00 PL=0",
    ]
    text.body[at + 1 : at + 1] = rows
    return rows[1]


def other_tool(text: Text, draw: random.Random) -> str:
    rows = [n for n in text.moves() if text.body[n - 1].startswith("MOVL") and "PL=0" not in text.body[n - 1]]
    at = draw.choice(rows)
    number = _number(text.body[at])
    row = next(n for n, p in enumerate(text.points) if p.startswith(f"C{number:05d}="))
    text.points[row : row + 1] = ["///TOOL 2", text.points[row], "///TOOL 1"]
    return text.body[at]


def unused_point(text: Text, draw: random.Random) -> str:
    number = len(text.points)
    text.points.append(
        point(number, [draw.uniform(800, 1000), draw.uniform(-300, 300), draw.uniform(300, 500)])
    )
    return text.points[-1]


def undefined_point(text: Text, draw: random.Random) -> str:
    at = draw.choice(text.moves())
    text.body[at] = re.sub(r"C\d+", f"C{draw.randrange(300, 900):05d}", text.body[at])
    return text.body[at]


def unreachable(text: Text, draw: random.Random) -> str:
    at = draw.choice(text.moves())
    rows = ["JUMP *NEXT", f"DOUT OT#({draw.randrange(900, 999)}) ON", "*NEXT"]
    text.body[at + 1 : at + 1] = rows
    return rows[1]


def missing_job(text: Text, draw: random.Random) -> str:
    row = f"CALL JOB:NOT-{draw.randrange(1000)}"
    text.body.insert(draw.choice(text.moves()) + 1, row)
    return row


def endless_wait(text: Text, draw: random.Random) -> str:
    row = f"WAIT IN#({draw.randrange(200, 400)})=ON"
    text.body.insert(draw.choice(text.moves()) + 1, row)
    return row


def twice_taught(text: Text, draw: random.Random) -> str:
    first = draw.choice(text.points[3:-3])
    row = f"C{len(text.points):05d}={first.partition('=')[2]}"
    text.points.append(row)
    text.body.insert(draw.choice(text.moves()) + 1, f"MOVL {row.partition('=')[0]} V=120.0 PL=0")
    return row


def unused_label(text: Text, draw: random.Random) -> str:
    row = f"*{draw.choice(('RETRY', 'A', 'P', 'L', 'OT', 'V', '1', '25', 'END'))}"
    text.body.insert(draw.choice(text.moves()) + 1, row)
    return row


def nowhere(text: Text, draw: random.Random) -> str:
    at = draw.choice(text.moves())
    number = _number(text.body[at])
    row = f"MOVL C{number:05d} V=77.0 PL=0"
    text.body.insert(at + 1, row)
    return row


PLANTS: dict[str, Plant] = {
    "W001": exact_stop,
    "W002": speed,
    "W003": long_zone,
    "W004": turn,
    "W005": outside,
    "W006": singular,
    "W007": other_tool,
    "W008": unused_point,
    "W009": undefined_point,
    "W010": unreachable,
    "W011": missing_job,
    "W012": endless_wait,
    "W013": twice_taught,
    "W014": unused_label,
    "W015": nowhere,
}


def findings(folder: Path, text: Text) -> list[tuple[str, int, str]]:
    """(code, line, message) of everything that is said of a program."""
    path = folder / "PART.JBI"
    path.write_text("\r\n".join([*text.lines(), ""]), newline="")
    return [(f.code, f.line, f.message) for f in lint(str(path), Job()).findings]


def planted(folder: Path, code: str, draw: random.Random) -> tuple[bool, list[tuple[str, int, str]]]:
    """Whether the mistake was found at its line, and what else was said of the program."""
    text = clean(draw)
    row = PLANTS[code](text, draw)
    found = findings(folder, text)
    line = text.line_of(row)
    # A zone is told at the corner: the line whose level it is, or the short move that follows.
    lines = {line - 1, line} if code == "W003" else {line}
    hit = any(f[0] == code and f[1] in lines for f in found)
    return hit, [f for f in found if f[0] != code]


def prepared() -> Iterator[Path]:
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "olp.toml").write_text(SETTINGS)
        yield Path(name)


def table(count: int, programs: int) -> None:
    draw = random.Random(20260413)
    total = 0
    for folder in prepared():
        said = [f for _ in range(programs) for f in findings(folder, clean(draw))]
        print(f"clean programs, generated: {len(said)} findings in {programs}", *said[:5], sep="\n  ")
        files = [
            path for sample in SAMPLES for path in sorted(sample.iterdir()) if path.suffix.lower() == ".jbi"
        ]
        said = [f for path in files for f in lint(str(path), Job()).findings]
        print(f"clean programs, samples:   {len(said)} findings in {len(files)}")
        print(f"\n{'rule':6s}{'title':38s}{'found':>6s}{'of':>5s}  besides")
        for rule in all_rules():
            results = [planted(folder, rule.code, draw) for _ in range(count)]
            hits = sum(hit for hit, _ in results)
            total += hits
            others = sorted({f[0] for _, more in results for f in more})
            print(f"{rule.code:6s}{rule.title:38s}{hits:6d}{count:5d}  {' '.join(others)}")
    print(f"{'all':44s}{total:6d}{count * len(PLANTS):5d}  {total / count / len(PLANTS):.1%}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--planted", type=int, default=20)
    parser.add_argument("--clean", type=int, default=200)
    given = parser.parse_args()
    table(given.planted, given.clean)
