"""Damages every sample in 2,000 ways and reads, plans and times the result: `python bench/mutations.py [PATH …]`.

Byte flips, truncations and line swaps, seeded by the sample's name. Nothing but OlpError may be raised, nothing may
take more than a second, the bytes come back unchanged, and every line is accounted for. Exit status 1 otherwise.
"""

from __future__ import annotations

import argparse
import random
import re
import signal
import sys
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np

import olp
from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import Comment, LineKind, Opaque, Program
from olp.timing.result import Timing
from olp.timing.timing import time_plan

SAMPLES = Path(__file__).resolve().parent.parent / "samples"
SUFFIXES = (".jbi",)
MAX_STEPS = 2_000  # of the interpreter: a damaged loop ends there
LIMIT = 1.0  # [s] CPU for reading, planning and timing one mutation
HANG = 30  # [s] after which a mutation is given up
_BLANKS = bytes(n for n in range(128) if chr(n).isspace()) + b"\x1a"
_SPLIT = re.compile(rb"\r\n|\n|\r")
_LINE_END = re.compile(rb"(\r\n|\n|\r)")


class Hang(BaseException):
    """Raised by the alarm; no `except Exception` catches it."""


class Tally(NamedTuple):
    """What happened to one sample. `failures`: (what, mutation number, detail), the first few of each kind."""

    sample: str
    mutations: int
    refused: int  # with diagnostics, as no job
    timed: int
    slowest: float  # [s] CPU
    failures: tuple[tuple[str, int, str], ...]


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("paths", nargs="*", type=Path, default=[SAMPLES], metavar="PATH")
    parser.add_argument("--count", type=int, default=2_000, help="mutations per sample (2,000)")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--show", type=int, help="print one mutation of one sample and its traceback")
    args = parser.parse_args(arguments)
    samples = list(find(args.paths))
    if args.show is not None:
        return show(samples[0], args.show)
    with ProcessPoolExecutor(args.processes) as pool:
        tallies = list(pool.map(try_sample, samples, [args.count] * len(samples)))
    return print_report(tallies)


def find(paths: list[Path]) -> Iterator[Path]:
    for path in paths:
        if path.is_dir():
            yield from (p for p in sorted(path.rglob("*")) if p.suffix.lower() in SUFFIXES)
        else:
            yield path


def try_sample(path: Path, count: int) -> Tally:
    """All mutations of one sample; runs in a process of its own."""
    signal.signal(signal.SIGALRM, give_up)
    raw, outcomes = path.read_bytes(), Counter[str]()
    slowest, failures = 0.0, list[tuple[str, int, str]]()
    for number in range(count):
        damaged = mutation(raw, path.name, number)
        start = time.process_time()
        outcome, wrong = try_once(path, raw, damaged)
        seconds = time.process_time() - start
        slowest = max(slowest, seconds)
        if seconds > LIMIT:
            wrong.append(("slow", f"{seconds:.2f} s"))
        outcomes[outcome] += 1
        failures += [(what, number, detail) for what, detail in wrong]
    return Tally(str(path), count, outcomes["refused"], outcomes["timed"], slowest, tuple(failures))


def give_up(signum: int, frame: object) -> NoReturn:
    raise Hang


def try_once(path: Path, raw: bytes, damaged: bytes) -> tuple[str, list[tuple[str, str]]]:
    """(outcome, what went wrong) of one mutation."""
    signal.alarm(HANG)
    stage = "read"
    try:
        program = read_source(decode(damaged, str(path)))
        wrong = list(check(program, raw, damaged))
        stage = "plan"
        wrong += check_times(time_plan(program.plan(max_steps=MAX_STEPS)))
        return "timed", wrong
    except olp.OlpError as refusal:
        silent = (
            [] if any(d.severity == "error" for d in refusal.diagnostics) else [("no reason", repr(refusal))]
        )
        return "refused", silent
    except Hang:
        return "crash", [("hang", f"{stage}: over {HANG} s")]
    except Exception as problem:
        return "crash", [(f"{stage} raises", where(problem))]
    finally:
        signal.alarm(0)


def where(problem: Exception) -> str:
    """The exception and the innermost line of olp that let it pass."""
    frames = traceback.extract_tb(problem.__traceback__)
    inner = next((f for f in reversed(frames) if "/olp/" in f.filename), frames[-1])
    return f"{type(problem).__name__} at {inner.filename.rpartition('/olp/')[2]}:{inner.lineno}: {problem}"[
        :200
    ]


def check(program: Program, raw: bytes, damaged: bytes) -> Iterator[tuple[str, str]]:
    """The promises about reading: same bytes back, every line accounted for, a lost end is said."""
    if program.to_bytes() != damaged:
        yield "bytes", "not the same bytes"
    kinds, lines = program.line_kinds, program.source.lines
    if len(kinds) != len(lines):
        yield "lines", f"{len(kinds)} line kinds for {len(lines)} lines"
        return
    reported = {d.line for d in program.diagnostics}
    stands = {s.line: s for s in program.statements()}
    rows = {int(n) for routine in program.routines for b in routine.points.blocks.values() for n in b.lines}
    for number, (kind, text) in enumerate(zip(kinds, lines, strict=True), 1):
        if not accounted(kind, text, number in reported, stands.get(number), number in rows):
            yield "silent line", f"line {number}, kind {kind}: {text[:60]!r}"
            return
    if loses_its_end(raw, damaged) and not any(d.severity == "error" for d in program.diagnostics):
        yield "silent half", "END is lost and no error says so"


def check_times(timing: Timing) -> Iterator[tuple[str, str]]:
    """A step without a time has a diagnostic; all others take at least nothing."""
    if (timing.duration_s < 0).any() or np.isinf(timing.duration_s).any():
        yield "no time", "a duration is negative or infinite"
    if np.isnan(timing.duration_s).any() and not timing.diagnostics:
        yield "no time", "a duration is unknown and nothing says why"


def accounted(kind: int, text: str, reported: bool, statement: object, is_row: bool) -> bool:
    """Whether a line is what its kind says, by evidence that does not come from the kind itself."""
    if reported:
        return True
    match kind:
        case LineKind.BLANK:
            return not text.replace("\x1a", "").strip()
        case LineKind.POINT:
            return is_row
        case LineKind.STATEMENT:
            return statement is not None
        case LineKind.COMMENT:
            return isinstance(statement, Comment) or text.lstrip("\ufeff \t").startswith(("'", "//"))
        case LineKind.OPAQUE:
            return isinstance(statement, Opaque)
        case LineKind.RECORD:
            return "/" in text or is_alias_row(text)
        case LineKind.FREE_TEXT:
            return True
    return False


def is_alias_row(text: str) -> bool:
    return re.match(r"\s*L?(?:BP|EX|[BIDRSP])\d+\s", text) is not None


def loses_its_end(raw: bytes, damaged: bytes) -> bool:
    """Whether instructions of the damaged text run out without END, or the sample's are gone altogether."""
    words = [line.strip(_BLANKS) for line in _SPLIT.split(damaged)]
    starts = [index for index, word in enumerate(words) if word.split()[:1] == [b"//INST"]]
    if not starts:
        return b"//INST" in raw
    jobs = [index for index, word in enumerate(words) if word == b"/JOB"] + [len(words)]
    return any(b"END" not in words[start : next(job for job in jobs if job > start)] for start in starts)


def mutation(raw: bytes, name: str, number: int) -> bytes:
    """Mutation `number` of a sample: always the same one."""
    dice = random.Random(f"{name}/{number}")
    return (flip, truncate, swap)[number % 3](raw, dice)


def flip(raw: bytes, dice: random.Random) -> bytes:
    """One to eight bytes get another value."""
    changed = bytearray(raw)
    for _ in range(dice.randint(1, 8) if raw else 0):
        changed[dice.randrange(len(raw))] ^= dice.randint(1, 255)
    return bytes(changed)


def truncate(raw: bytes, dice: random.Random) -> bytes:
    return raw[: dice.randrange(len(raw) + 1)]


def swap(raw: bytes, dice: random.Random) -> bytes:
    """Two lines change places, line ends included."""
    pieces = _LINE_END.split(raw)
    lines = [a + b for a, b in zip(pieces[::2], [*pieces[1::2], b""], strict=True)]
    i, j = dice.randrange(len(lines)), dice.randrange(len(lines))
    lines[i], lines[j] = lines[j], lines[i]
    return b"".join(lines)


def show(path: Path, number: int) -> int:
    """One mutation in full, for whoever repairs what it breaks."""
    damaged = mutation(path.read_bytes(), path.name, number)
    sys.stdout.buffer.write(damaged + b"\n")
    try:
        program = read_source(decode(damaged, str(path)))
        for diagnostic in program.diagnostics:
            print(diagnostic.render())
        print(list(check(program, path.read_bytes(), damaged)))
        print(time_plan(program.plan(max_steps=MAX_STEPS)).frame())
    except Exception:
        traceback.print_exc()
    return 0


def print_report(tallies: list[Tally]) -> int:
    failures = [(t.sample, *failure) for t in tallies for failure in t.failures]
    total = sum(t.mutations for t in tallies)
    kinds = Counter(failure[1] for failure in failures)
    raised = sum(count for what, count in kinds.items() if what.endswith("raises"))
    silent = sum(kinds[what] for what in ("silent line", "silent half", "lines", "no reason", "no time"))
    timed, refused = sum(t.timed for t in tallies), sum(t.refused for t in tallies)
    print(
        f"{len(tallies)} samples, {total:,} mutations: {timed:,} read, planned and timed, {refused:,} refused\n"
    )
    print("| figure | asked | measured |\n|---|---|---|")
    print(f"| anything but OlpError raised | 0 | {raised} |")
    print(
        f"| longer than {LIMIT:.0f} s CPU (slowest) | 0 | {kinds['slow'] + kinds['hang']} ({slowest(tallies)}) |"
    )
    print(f"| bytes changed | 0 | {kinds['bytes']} |")
    print(f"| lines or halves lost in silence | 0 | {silent} |")
    print_groups(failures)
    return 1 if failures else 0


def print_groups(failures: list[tuple[str, str, int, str]]) -> None:
    """Failures of one kind and place together, with one example each."""
    groups: dict[tuple[str, str], list[tuple[str, str, int, str]]] = {}
    for failure in failures:
        _, what, _, detail = failure
        place = ":".join(detail.split(":")[:2]) if what.endswith("raises") else ""
        groups.setdefault((what, place), []).append(failure)
    for (what, _), found in sorted(groups.items(), key=lambda item: -len(item[1])):
        sample, _, number, detail = found[0]
        print(
            f"\n- {what}, {len(found)} times: {detail}\n  python bench/mutations.py {sample} --show {number}"
        )


def slowest(tallies: list[Tally]) -> str:
    worst = max(tallies, key=lambda t: t.slowest)
    return f"{worst.slowest:.2f} s, {Path(worst.sample).name}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
