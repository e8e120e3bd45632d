"""Tries a reader on a folder of real programs: `python bench/corpus.py FOLDER [--vendor krl]`.

Prints what was asked and what was measured, every error on a complete program, and what is kept but not modelled.
Exit status 1 when a figure is missed. The programs are no part of the project: docs/figures.md names their origin.
"""

from __future__ import annotations

import re
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

import olp
from olp.core.source import load
from olp.ir.program import Opaque, Program
from olp.languages.vendor import find_vendor, vendor_names
from olp.timing.timing import time_plan

_LINE = re.compile(rb"\r\n|\n|\r")
_MARKS = (rb"/JOB", rb"//INST", rb"NOP", rb"END")
# What a whole file of the other languages holds, in order; and what makes it a motion program.
_WHOLE = {
    "krl": rb"(?is)^\s*(?:global\s+)?def(?:fct)?\s.*^\s*end(?:fct)?\b",
    "rapid": rb"(?is)^\s*module\s.*^\s*endmodule\b",
    "tp": rb"(?is)^/prog\b.*^/mn\b.*^/pos\b.*^/end\b",
    "urscript": rb"(?is)^\s*def\s.*^\s*end\b",
    "as": rb"(?is)^\s*\.program\s.*^\s*\.end\b",
    "pdl2": rb"(?is)^\s*program\s.*^\s*begin\b.*^\s*end\s",
    "val3": rb"(?is)<program\s.*\bbegin\b.*\bend\b.*</program>",
}
_MOTION = {
    "krl": rb"(?im)^\s*s?(?:ptp|lin|circ)(?:_rel)?\s",
    "rapid": rb"(?i)\bmove(?:j|l|c|absj)\b",
    "tp": rb"(?im)^\s*\d*\s*:\s*[jlca]\s+p",
    "urscript": rb"\bmove[jlpc]\s*\(",
    "as": rb"(?im)^\s*(?:[jlh]move|c[12]move|[jl]appro)\s",
    "pdl2": rb"(?im)^\s*move(?:fly)?\s",
    "val3": rb"\bmove[jlc]\s*\(",
}
MAX_STEPS = 20_000
ROBOT = "yaskawa/ma2010"  # the arm of most of the published jobs; for the others its times mean nothing
ASKED_ERROR_FREE = {"inform": 0.99}
ASKED_OF_OTHERS = 0.97  # of complete motion programs


class Outcome(NamedTuple):
    """What became of one file. `seconds`: CPU time of reading."""

    path: Path
    lines: int
    complete: bool
    crash: str
    unchanged: bool
    errors: tuple[olp.Diagnostic, ...]
    opaque: Counter[str]
    timed: tuple[str, ...]  # without a robot, then with ROBOT
    seconds: float


def main(arguments: list[str]) -> int:
    vendor = arguments[2] if len(arguments) == 3 and arguments[1] == "--vendor" else "inform"
    if len(arguments) not in (1, 3) or not Path(arguments[0]).is_dir() or vendor not in vendor_names():
        print("usage: python bench/corpus.py FOLDER [--vendor NAME]", file=sys.stderr)
        return 2
    folder = Path(arguments[0])
    outcomes = [judge(path, vendor) for path in programs(folder, vendor)]
    if not outcomes:
        print(f"no {vendor} file below {folder}", file=sys.stderr)
        return 2
    rows, held = figures(outcomes, vendor)
    print(f"{len(outcomes)} files, {sum(o.lines for o in outcomes):,} lines\n")
    print_table(("figure", "asked", "measured"), rows)
    for index, title in enumerate(("without a robot", f"with {ROBOT}, whichever arm it was")):
        print(f"\nplanned and timed {title}, without assumptions:\n")
        print_counts("outcome", (o.timed[min(index, len(o.timed) - 1)] for o in outcomes))
    print("\nkept but not modelled:\n")
    print_counts("instruction", (word for o in outcomes for word in o.opaque.elements()))
    print_problems(folder, outcomes)
    return 0 if held else 1


def programs(folder: Path, vendor: str) -> Iterator[Path]:
    """The files with one of the language's suffixes; those that other makers use too must look like it."""
    language = find_vendor(vendor)
    for path in sorted(folder.rglob("*")):
        if not path.name.lower().endswith(language.suffixes) or not path.is_file():
            continue
        if vendor == "inform" or language.sniff(load(path)):
            yield path


def judge(path: Path, vendor: str) -> Outcome:
    """Reads, writes, plans and times one file; nothing it does may raise."""
    raw = path.read_bytes()
    lines, complete = len(_LINE.split(raw)), is_complete(raw, vendor)
    start = time.process_time()
    try:
        program = olp.read(path, vendor=vendor)
    except olp.OlpError as refusal:
        # A text that is no job at all is refused with diagnostics: that is an answer, unless the job is complete.
        seconds = time.process_time() - start
        return Outcome(
            path, lines, complete, "", True, refusal.diagnostics, Counter(), ("not a job: refused",), seconds
        )
    except Exception as problem:
        return Outcome(path, lines, complete, repr(problem), False, (), Counter(), ("crash",), 0.0)
    seconds = time.process_time() - start
    errors = tuple(d for d in program.diagnostics if d.severity == "error")
    opaque = Counter(
        s.text.split()[0] for s in program.statements() if isinstance(s, Opaque) and s.text.split()
    )
    unchanged = program.to_bytes() == raw
    timed = tuple(plan_and_time(program, robot) for robot in (None, ROBOT))
    return Outcome(path, lines, complete, "", unchanged, errors, opaque, timed, seconds)


def is_complete(raw: bytes, vendor: str) -> bool:
    """Whether the marks of a whole job stand in order, each at the start of a line; elsewhere also moves."""
    if vendor != "inform":
        return bool(re.search(_WHOLE[vendor], raw, re.MULTILINE) and re.search(_MOTION[vendor], raw))
    words = [line.split()[0].rstrip(b"\x1a") for line in _LINE.split(raw) if line.split()]
    position = 0
    for mark in _MARKS:
        if mark not in words[position:]:
            return False
        position += words[position:].index(mark)
    return True


def plan_and_time(program: Program, robot: str | None) -> str:
    """The class of outcome in a few words."""
    try:
        timing = time_plan(program.plan(robot, max_steps=MAX_STEPS))
    except olp.OlpError as refusal:
        return f"refused: {', '.join(sorted({d.code for d in refusal.diagnostics if d.severity == 'error'}))}"
    except Exception as problem:
        return f"crash: {problem!r}"
    codes = ", ".join(sorted({d.code for d in timing.diagnostics if d.severity == "error"}))
    if np.isnan(timing.duration_s).all() and len(timing.duration_s):
        return f"no step timed: {codes}"
    return f"timed, with errors: {codes}" if codes else "timed"


def figures(outcomes: list[Outcome], vendor: str) -> tuple[list[tuple[str, str, str]], bool]:
    asked = ASKED_ERROR_FREE.get(vendor, ASKED_OF_OTHERS)
    whole = [o for o in outcomes if o.complete]
    read = sum(not o.crash for o in outcomes)
    same = sum(o.unchanged for o in outcomes)
    clean = sum(not o.errors and not o.crash for o in whole)
    crashes = sum(any(word.startswith("crash") for word in o.timed) for o in outcomes)
    rows = [
        ("read without a crash", "100 %", share(read, len(outcomes))),
        ("written back unchanged", "100 %", share(same, len(outcomes))),
        ("complete programs without an error", f"≥ {100 * asked:.0f} %", share(clean, len(whole))),
        ("planned and timed without a crash", "100 %", share(len(outcomes) - crashes, len(outcomes))),
    ]
    held = read == same == len(outcomes) and not crashes and clean >= asked * len(whole)
    return rows, held


def share(part: int, whole: int) -> str:
    return f"{100 * part / whole:.2f} % ({part} of {whole})" if whole else "nothing to measure"


def print_table(head: tuple[str, ...], rows: Iterable[tuple[object, ...]]) -> None:
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(map(str, row)) + " |")


def print_counts(head: str, words: Iterable[str]) -> None:
    print_table((head, "count"), Counter(words).most_common() or [("none", 0)])


def print_problems(folder: Path, outcomes: list[Outcome]) -> None:
    print("\nevery error, and every crash:\n")
    for outcome in outcomes:
        name = outcome.path.relative_to(folder)
        note = "" if outcome.complete else " (incomplete file)"
        if outcome.crash:
            print(f"- {name}: {outcome.crash}")
        if not outcome.unchanged:
            print(f"- {name}: bytes changed")
        for word in outcome.timed:
            if word.startswith("crash"):
                print(f"- {name}: {word}")
        for problem in outcome.errors:
            print(f"- {name}:{problem.line}: [{problem.code}] {problem.message}{note}")
    slowest = max(outcomes, key=lambda o: o.seconds)
    print(
        f"\nslowest to read: {slowest.path.relative_to(folder)}, {slowest.seconds:.3f} s CPU, {slowest.lines:,} lines"
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
