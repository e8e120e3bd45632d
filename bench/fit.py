"""How few edits `olp fit` needs, and whether its answers hold.

    python bench/fit.py small [COUNT [SEED]]   made programs of up to 8 moves against all sets of edits
    python bench/fit.py wide [COUNT [SEED]]    the same with more places, against all sets of up to three edits
    python bench/fit.py real FOLDER [MOST [FROM]]   programs below FOLDER, 5, 10 and 20 % faster; -v tells each
    python bench/fit.py speed                  made programs of 200 and 2,000 lines

Nothing of `olp fit` judges its answers: the oracle of `small` writes other numbers into the lines and times the text,
every answer is written to a file, read again and timed anew, its corners are measured on that motion, and its bytes
are compared with the old ones.
"""

from __future__ import annotations

import itertools
import random
import re
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from olp.checks.fit.choices import Allowed
from olp.checks.fit.fit import Fit, FitSearch, fit
from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.core.units import mm
from olp.ir.program import Program
from olp.languages.vendor import read, read_source
from olp.reports.batch import Job, time_program
from olp.runtime.plan import StepKind
from olp.timing.result import Timing
from olp.timing.track import tool_position

ROBOTS = {
    "inform": "yaskawa/gp25",
    "krl": "kuka/kr16-2",
    "rapid": "abb/irb4600-20-2.50",
    "tp": "fanuc/m-20ia",
    "urscript": "universal-robots/ur10e",
}
WITHIN = 2.0  # mm
FASTEST = 1.0  # m/s, of the tool in real programs
SUFFIXES = (".jbi", ".ls", ".mod", ".script", ".src")
LONGEST = 2000  # lines: for longer ones no time was ever promised
TARGETS = (0.05, 0.10, 0.20)


def timed(program: Program, robot: str, folder: Path) -> Timing:
    return time_program(program, Job(robot=robot), folder)


# --- What holds ---


def passed_by(timing: Timing, lines: set[int]) -> float:
    """[m] The furthest that the tool passes the target of a move on one of these lines, every execution measured."""
    plan, far = timing.plan, 0.0
    ends = np.concatenate(([0.0], timing.end_s))
    for step in np.flatnonzero(
        (plan.source == 0) & (plan.kind == StepKind.MOVE) & np.isin(plan.line, sorted(lines))
    ):
        times = np.linspace(ends[step], ends[min(step + 2, len(plan))], 1001)
        target = plan.positions.position[plan.moves.target[plan.row[step]]]
        far = max(far, float(np.linalg.norm(tool_position(timing, times) - target, axis=1).min()))
    return far


def travels(timing: Timing, lines: set[int]) -> float:
    """[m/s] The fastest that the tool travels in a move on one of these lines, over 400 pieces of its time."""
    plan, fast = timing.plan, 0.0
    ends = np.concatenate(([0.0], timing.end_s))
    for step in np.flatnonzero(
        (plan.source == 0) & (plan.kind == StepKind.MOVE) & np.isin(plan.line, sorted(lines))
    ):
        if ends[step + 1] - ends[step] > 1e-6:
            times = np.linspace(ends[step], ends[step + 1], 401)
            way = np.linalg.norm(np.diff(tool_position(timing, times), axis=0), axis=1)
            fast = max(fast, float((way / np.diff(times)).max()))
    return fast


def changed_lines(old: bytes, new: bytes) -> set[int] | None:
    """Numbers of the lines whose bytes differ, line ends included; None where there are more or fewer lines."""
    before, after = old.splitlines(keepends=True), new.splitlines(keepends=True)
    if len(before) != len(after):
        return None
    return {n for n, (a, b) in enumerate(zip(before, after, strict=True), 1) if a != b}


def wrong_with(found: Fit, path: Path, out: Path, robot: str, within: float) -> list[str]:
    """What does not hold of an answer: written to `out`, beside what it needs, read and timed anew."""
    wrong = []
    before = path.read_bytes()
    out.write_bytes(found.program.source.raw)
    again = timed(read(out), robot, out.parent)
    out.write_bytes(before)
    if abs(again.total_s - found.timing.total_s) > 1e-9:
        wrong.append(f"replay {again.total_s - found.timing.total_s:+.3g} s")
    if found.reached != (again.total_s <= found.to_s + 1e-9):
        wrong.append("reached or not")
    changed = changed_lines(before, found.program.source.raw)
    told = {line for one in found.edits for line in one.choice.lines}
    if changed is None or changed != told:
        wrong.append(
            f"changed lines {sorted(changed ^ told) if changed is not None else 'of another number'}"
        )
    far = passed_by(again, {one.choice.line for one in found.edits if one.choice.zone >= 0})
    if far > within * mm + 1e-6:
        wrong.append(f"corner {far / mm:.4f} mm")
    fast = travels(again, {one.choice.line for one in found.edits if one.choice.by_axes})
    if fast > FASTEST * 1.001:
        wrong.append(f"tool {fast:.4f} m/s")
    return wrong


# --- Made programs ---


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


class Way(NamedTuple):
    """One set of edits that can be made: how many, and the total [s]."""

    edits: int
    total_s: float


_NUMBERS = {  # what may be written in place of a number of the line
    r"(?<=\bVJ=)[\d.]+": lambda now: sorted({v for v in (1.5 * now, 100.0) if now < v <= 100.0}),
    r"(?<=\bV=)[\d.]+": lambda now: sorted({v for v in (1.5 * now, OF_MADE) if now < v <= OF_MADE}),
    r"(?<=\bPL=)\d+": lambda now: [v for v in (1, 2, 4, 8) if v > now],
}
OF_MADE = 1e3 * FASTEST  # mm/s, the fastest that a made program may be told to be
_MOST_WAYS = 6000  # of one program: some lines are then kept as they are


def spellings(
    text: str, choose: random.Random, most: int = _MOST_WAYS
) -> tuple[str, list[list[tuple[int, str, str]]]]:
    """The text, lines kept by a comment until it has few enough ways, and per number what may stand there instead."""
    rows = text.split("\r\n")
    places: list[list[tuple[int, str, str]]] = []
    for number, row in enumerate(rows):
        if not row.startswith("MOV"):
            continue
        for pattern, levels in _NUMBERS.items():
            found = re.search(pattern, row)
            ways = levels(float(found[0])) if found else []
            if ways:
                form = "{:.0f}" if "PL" in pattern else "{:.2f}" if "VJ" in pattern else "{:.1f}"
                places.append([(number, pattern, form.format(value)) for value in ways])
    while np.prod([1.0 + len(of) for of in places]) > most:
        kept = choose.choice(places)[0][0]
        rows[kept] += "  //olp: keep"
        places = [of for of in places if of[0][0] != kept]
    return "\r\n".join(rows), places


def all_ways(
    path: Path, text: str, places: list[list[tuple[int, str, str]]], robot: str, every: bool = False
) -> list[Way]:
    """Every set of edits that passes no corner further than it may; with `every` only those of all places."""
    found = []
    for some in itertools.product(*(of if every else [None, *of] for of in places)):
        rows, rounded, turned = text.split("\r\n"), set(), set()
        for number, pattern, value in filter(None, some):
            rows[number] = re.sub(pattern, value, rows[number], count=1)
            (rounded if "PL" in pattern else turned if "VJ" in pattern else set()).add(number + 1)
        timing = timed(read_source(decode("\r\n".join(rows).encode(), str(path))), robot, path.parent)
        holds = (
            passed_by_roughly(timing, rounded) <= WITHIN * mm and travels(timing, turned) <= FASTEST * 1.001
        )
        if not timing.untimed and holds:
            found.append(Way(sum(one is not None for one in some), timing.total_s))
    return found


def passed_by_roughly(timing: Timing, lines: set[int]) -> float:
    """The same as `passed_by` to a hundredth of a millimetre, for thousands of ways: two moves in 200 instants."""
    plan = timing.plan
    steps = np.flatnonzero((plan.kind == StepKind.MOVE) & np.isin(plan.line, sorted(lines)))
    if not len(steps):
        return 0.0
    ends = np.concatenate(([0.0], timing.end_s))
    bent = np.linspace(-1.0, 1.0, 201)[None, :] ** 3
    before, here, after = (ends[np.minimum(steps + k, len(plan))][:, None] for k in range(3))
    times = here + bent * np.where(bent < 0.0, here - before, after - here)
    target = plan.positions.position[plan.moves.target[plan.row[steps]]]
    way = tool_position(timing, times.ravel()).reshape(*times.shape, 3)
    return float(np.linalg.norm(way - target[:, None], axis=2).min(axis=1).max())


def small(count: int, seed: int) -> None:
    robot, allowed = ROBOTS["inform"], Allowed(WITHIN * mm, OF_MADE * mm)
    sums: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "made.jbi"
        for number in range(count):
            choose = random.Random(f"{seed} {number}")
            text, places = spellings(job_text(choose, choose.randint(3, 8)), choose)
            path.write_bytes(text.encode())
            program = read(path)
            base = timed(program, robot, path.parent)
            if base.untimed:
                sums["programs that cannot be timed"] += 1
                continue
            ways = all_ways(path, text, places, robot)
            sums["programs"] += 1
            sums["sets of edits tried"] += len(ways)
            search = FitSearch(program, lambda one: timed(one, robot, path.parent), allowed)
            best = min(way.total_s for way in ways)
            least = best / base.total_s
            for share in (
                *TARGETS,
                *(1.0 - choose.uniform(least, 1.0) for _ in range(5)),
                1.0 - 0.99 * least,
            ):
                _judge(sums, search, path, robot, base.total_s * (1 - share), ways)
    for key, value in sorted(sums.items()):
        print(f"{value:6} {key}")


def _judge(
    sums: Counter[str], search: FitSearch, path: Path, robot: str, to_s: float, ways: list[Way]
) -> None:
    """One target of one made program."""
    found, out = search.fit(to_s), path.with_name("out.jbi")
    enough = [way.edits for way in ways if way.total_s <= to_s + 1e-9]
    sums["targets"] += 1
    for what in wrong_with(found, path, out, robot, WITHIN):
        sums[f"does not hold: {what.split()[0]}"] += 1
    if not enough:
        sums["infeasible for the oracle"] += 1
        sums["infeasible for the oracle, reached all the same"] += found.reached
        return
    sums["feasible"] += 1
    sums["feasible and found"] += found.reached
    if found.reached:
        sums[f"edits more than the fewest: {len(found.edits) - min(enough)}"] += 1


def wide(count: int, seed: int) -> None:
    """Programs of 8 moves with all their places, against all sets of up to three edits that go as far as they may."""
    robot, allowed = ROBOTS["inform"], Allowed(WITHIN * mm, OF_MADE * mm)
    sums: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "made.jbi"
        for number in range(count):
            choose = random.Random(f"wide {seed} {number}")
            text, places = spellings(job_text(choose, 8), choose, 10**9)
            path.write_bytes(text.encode())
            program = read(path)
            base = timed(program, robot, path.parent)
            furthest = []
            for of in places:
                holds = [way for way in of if all_ways(path, text, [[way]], robot, every=True)]
                furthest += [holds[-1:]] if holds else []
            best = min(
                (way.total_s for way in all_ways(path, text, furthest, robot, every=True)), default=np.inf
            )
            search = FitSearch(program, lambda one: timed(one, robot, path.parent), allowed)
            sums["programs"] += 1
            sums["places"] += len(furthest)
            for share in (0.05, 0.1, 0.2, 0.3):
                to_s = base.total_s * (1 - share)
                found = search.fit(to_s, front=False)
                sums["targets"] += 1
                sums["feasible with all edits"] += best <= to_s
                sums["feasible with all edits and found"] += best <= to_s and found.reached
                if not found.reached or len(found.edits) > 4:
                    sums["not reached, or more than 4 edits: sets not tried"] += 1
                    continue
                fewest = len(found.edits)
                for size in range(len(found.edits)):
                    sets = (
                        all_ways(path, text, list(some), robot, every=True)
                        for some in itertools.combinations(furthest, size)
                    )
                    if any(way.total_s <= to_s + 1e-9 for ways in sets for way in ways):
                        fewest = size
                        break
                sums[f"edits more than the fewest: {len(found.edits) - fewest}"] += 1
    for key, value in sorted(sums.items()):
        print(f"{value:6} {key}")


# --- Real programs ---


def programs(folder: Path) -> Iterator[Path]:
    """Programs below the folder, none twice: of each language in turn, there of each folder in turn."""
    kinds: dict[str, dict[str, list[Path]]] = {}
    seen: set[bytes] = set()
    for path in sorted(folder.rglob("*")):
        kind = path.suffix.lower()
        if kind not in SUFFIXES or not path.is_file() or path.stat().st_size > 300_000:
            continue
        raw = path.read_bytes()
        if raw not in seen and raw.count(b"\n") <= LONGEST:
            seen.add(raw)
            kinds.setdefault(kind, {}).setdefault(path.relative_to(folder).parts[0], []).append(path)
    rows = [list(_in_turn(list(of.values()))) for _, of in sorted(kinds.items())]
    yield from _in_turn(rows)


def _in_turn(rows: list[list[Path]]) -> Iterator[Path]:
    for number in range(max(map(len, rows), default=0)):
        yield from (row[number] for row in rows if number < len(row))


def copied(folder: Path, path: Path, into: Path) -> Path:
    """The place of a program in a copy of all that stands around it: a robot's files may be anywhere in its tree."""
    top = path.relative_to(folder).parts[0]
    if not (into / top).exists():

        def large(at: str, names: list[str]) -> list[str]:
            files = (Path(at) / name for name in names)
            return [
                one.name
                for one in files
                if one.is_symlink() or (one.is_file() and one.stat().st_size > 10**6)
            ]

        shutil.copytree(folder / top, into / top, ignore=large)
    return into / path.relative_to(folder)


def timeable(path: Path) -> tuple[Program, Timing] | None:
    """A program that moves for half a second or more and whose time is known; None for others."""
    try:
        program = read(path)
        robot = ROBOTS.get(program.vendor)
        base = None if robot is None else timed(program, robot, path.parent)
    except OlpError:
        return None
    if base is None or not len(base.plan.moves) or base.untimed or base.motion_s < 0.5:
        return None
    return None if any(d.is_error for d in base.diagnostics) else (program, base)


def real(folder: Path, most: int, first: int, each: bool) -> None:
    sums: Counter[str] = Counter()
    kinds: Counter[str] = Counter()
    slowest: list[tuple[float, float, str]] = []
    why: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        known_ones = ((path, known) for path in programs(folder) if (known := timeable(path)) is not None)
        for path, known in itertools.islice(known_ones, first, first + most):
            program, base = known
            robot, out = ROBOTS[program.vendor], copied(folder, path, Path(name))
            kinds[program.vendor] += 1
            begin = time.process_time()
            run = lambda one, robot=robot, path=path: timed(one, robot, path.parent)  # noqa: E731
            search = FitSearch(program, run, Allowed(WITHIN * mm, FASTEST))
            for share in TARGETS:
                if share != TARGETS[0]:  # the first one pays for what all of them share
                    begin = time.process_time()
                found = search.fit(base.total_s * (1 - share))
                seconds, lines = time.process_time() - begin, len(program.source.lines)
                if each:
                    print(
                        f"{seconds:6.2f} {len(found.edits)} {found.reached} {path} {lines} {len(base.plan)}",
                        flush=True,
                    )
                slowest.append(
                    (
                        seconds / max(5.0, 0.03 * lines),
                        seconds,
                        f"{path}, {lines} lines, {len(base.plan)} steps",
                    )
                )
                sums[f"{share:4.0%} faster: {'reached' if found.reached else 'the best is told'}"] += 1
                if not found.reached and share == TARGETS[0]:
                    why[found.limits[0].split(" s, ")[-1].partition(":")[0]] += 1
                for what in wrong_with(found, path, out, robot, WITHIN):
                    sums[f"does not hold: {what.split()[0]}"] += 1
                    print(f"{path}, {share:.0%}: {what}", flush=True)
    print(f"{sum(kinds.values())} programs: {dict(kinds)}")
    for key, value in sorted(sums.items()):
        print(f"{value:6} {key}")
    print(f"what rules the longest line where {TARGETS[0]:.0%} are not reached:", dict(why.most_common(6)))
    late = sum(one[0] > 1.0 for one in slowest)
    print(f"{late} of {len(slowest)} took longer than 5 s, or 3 s for each 100 lines; the slowest:")
    for _, seconds, what in sorted(slowest)[-5:]:
        print(f"{seconds:6.2f} s of CPU: {what}")


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
    elif words[:1] == ["wide"]:
        wide(int(words[1]) if len(words) > 1 else 10, int(words[2]) if len(words) > 2 else 1)
    elif words[:1] == ["real"] and len(words) > 1:
        numbers = [int(word) for word in words[2:] if word.isdecimal()]
        real(Path(words[1]), *(numbers + [200, 0][len(numbers) :]), each="-v" in words)
    elif words == ["speed"]:
        speed()
    else:
        print(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
