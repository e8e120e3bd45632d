"""Tries readers, runs and translations on a folder of real programs: `python bench/corpus.py FOLDER [--vendor krl …]`.

FOLDER holds one folder per origin. Per language: complete programs without an error, motion programs for which
`olp time` with a fitting robot has a complete total, statements of translation pairs that are neither exact nor
approximated, files above ten seconds; and what is in the way, most frequent first. `--most N` takes N files of each
origin (default 40, spread), `--no-pairs` leaves the translations out, `--only-pairs` the totals, `--list` names the
files behind each cause. `--pairs all` translates from each language into all that are written and prints a table of
the pairs; without it RAPID, KRL and TP are translated into each other. `--half development` takes the origins whose
programs were read while the translation was made, `--half held-out` all others (KRL and RAPID alone).
Exit status 1 when a figure is missed. The programs are no part of the project: docs/figures.md names their origin.
"""

from __future__ import annotations

import re
import signal
import sys
import time
from argparse import ArgumentParser, Namespace
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

import olp
from olp.core.source import load
from olp.ir.program import Move, Opaque, Program
from olp.languages.limits import writable
from olp.languages.vendor import find_vendor, language_of, maker_of, vendor_names
from olp.robots.robot import load_robot, robot_names
from olp.runtime.first_move import holds_move
from olp.runtime.flow import called_bodies
from olp.runtime.interpreter import run
from olp.runtime.jobs import Jobs
from olp.runtime.plan import StepKind
from olp.timing.timing import time_plan
from olp.transpile.context import Context, Fate
from olp.transpile.convert import convert
from olp.transpile.link import link
from olp.transpile.receipt import counts_of

# Origins whose programs were read.
_DEVELOPMENT = {
    "krl": (
        *("Bugaj32+", "HugoDanielson+", "LozanIvanov+", "Naqiu06+", "RoboDK+", "RobotExMachina+"),
        *("Shangmc+", "antcsny+", "paulovictor237+"),
    ),
    "rapid": (
        *("Alienspartner+", "BossyMr+", "Hussainmotiwalla+", "Maurilio97-P+", "RoboDK+", "RoboLab-FIUNER+"),
        *("Springa13+", "Wlups+", "bristolroboticslab+", "harshbhatt99+", "liamjosephnolan+", "robotics+"),
        *("rparak+", "rpiRobotics+"),
    ),
}
_LINE = re.compile(rb"\r\n|\n|\r")
# What a whole file holds, in order; and what makes it a motion program.
_WHOLE = {
    "inform": rb"(?s)^/JOB\b.*^//INST\b.*^NOP\b.*^END\b",
    "krl": rb"(?is)^\s*(?:global\s+)?def(?:fct)?\s.*^\s*end(?:fct)?\b",
    "rapid": rb"(?is)^\s*module\s.*^\s*endmodule\b",
    "tp": rb"(?is)^/prog\b.*^/mn\b.*^/pos\b.*^/end\b",
    "urscript": rb"(?is)^\s*def\s.*^\s*end\b",
    "as": rb"(?is)^\s*\.program\s.*^\s*\.end\b",
    "pdl2": rb"(?is)^\s*program\s.*^\s*begin\b.*^\s*end\s",
    "val3": rb"(?is)<program\s.*\bbegin\b.*\bend\b.*</program>",
}
_MOTION = {
    "inform": rb"(?m)^MOV[JLCS]\s",
    "krl": rb"(?im)^\s*s?(?:ptp|lin|circ)(?:_rel)?\s",
    "rapid": rb"(?im)^[^!\r\n]*\bmove(?:j|l|c|absj)\b",
    "tp": rb"(?im)^\s*\d*\s*:\s*[jlca]\s+p",
    "urscript": rb"(?m)^[^#\r\n]*\bmove[jlpc]\s*\(",
    "as": rb"(?im)^\s*(?:[jlh]move|c[12]move|[jl]appro)\s",
    "pdl2": rb"(?im)^\s*move(?:fly)?\s",
    "val3": rb"\bmove[jlc]\s*\(",
}
_TEMPLATE = rb"\{\{ *\w+ *\}\}|\{% "  # a text that some program fills in first is no program yet
# A program that runs by itself: a module without main, and the controller's own routines, are only called.
_RUNS = {"rapid": rb"(?im)^\s*proc\s+main\s*\("}
_LIBRARIES = {"krl": ("system", "tp")}  # folders
ASKED_CLEAN, ASKED_TIMED, ASKED_UNSAID, SLOWEST_S = 0.99, 0.90, 0.05, 10.0
PAIRS = ("rapid", "krl", "tp")  # those whose statements are counted as usual
MAX_STEPS = 20_000
_TRIED = 6  # arms per program, small to large
_NO_ARM = ("I001", "I002", "I003", "I004", "T101")  # errors that another arm may not have
_GIVE_UP_S = 60
_QUOTED = re.compile(r"'[^']*'|\"[^\"]*\"|\b[\w$.\[\]]*(?:\d|[A-Z_]{2})[\w$.\[\]]*")


@dataclass(slots=True)
class Outcome:
    """What became of one file.

    `timed`: whether it has a complete total, None: not tried; `causes`: why not; `seconds`: of the slowest thing done.
    """

    path: str
    lines: int
    complete: bool
    moves: bool
    trouble: list[str] = field(default_factory=list)  # crashes and changed bytes
    errors: list[str] = field(default_factory=list)
    opaque: Counter[str] = field(default_factory=Counter)
    timed: bool | None = None
    causes: set[str] = field(default_factory=set)
    fates: dict[str, Counter[str]] = field(default_factory=dict)
    unsaid: Counter[str] = field(default_factory=Counter)  # what translations could not say
    seconds: float = 0.0


def main(arguments: Sequence[str]) -> int:
    given = _arguments(arguments)
    folder = Path(given.folder)
    held, found = True, False
    rows = []
    pairs: dict[str, list[Outcome]] = {}
    details: list[str] = []
    with ProcessPoolExecutor(given.jobs) as pool:
        for vendor in given.vendor or vendor_names():
            paths = chosen(folder, list(programs(folder, vendor)), given.most)
            paths = [path for path in paths if in_half(origin_of(path, folder), vendor, given.half)]
            if not paths:
                continue
            found = True
            outcomes = list(pool.map(partial(judge, vendor=vendor, works=_works(given)), paths))
            row, holds = figures(vendor, outcomes)
            rows.append(row)
            held = held and holds
            pairs[vendor] = outcomes
            details += told(vendor, folder, outcomes, given.list)
    if not found:
        print(f"no program below {folder}", file=sys.stderr)
        return 2
    head: tuple[str, ...] = (
        "language",
        "files, lines",
        "no crash, same bytes",
        f"complete without an error, asked {ASKED_CLEAN:.0%}",
    )
    head += (
        f"complete totals, asked {ASKED_TIMED:.0%}",
        f"neither exact nor near, asked {ASKED_UNSAID:.0%}",
        "slowest",
    )
    print_table(head, rows)
    if given.pairs == "all":
        print(f"\nneither exact nor near, by pair, asked {ASKED_UNSAID:.0%}:\n")
        print_table(("from \\ to", *map(language_of, writable())), pair_rows(pairs))
    print("\n".join(details))
    return 0 if held else 1


def _arguments(arguments: Sequence[str]) -> Namespace:
    parser = ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder")
    parser.add_argument("--vendor", action="append", choices=vendor_names())
    parser.add_argument("--most", type=int, default=40)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--no-pairs", action="store_true")
    parser.add_argument("--only-pairs", action="store_true")
    parser.add_argument("--half", default="all", choices=("all", "development", "held-out"))
    parser.add_argument("--pairs", default="usual", choices=("usual", "all"))
    parser.add_argument("--list", action="store_true")
    given = parser.parse_args(arguments)
    if given.half != "all" and not set(given.vendor or ()).issubset(_DEVELOPMENT):
        parser.error(f"--half: only {' and '.join(_DEVELOPMENT)} have halves")
    if given.half != "all":
        given.vendor = given.vendor or list(_DEVELOPMENT)
    return given


def origin_of(path: Path, folder: Path) -> str:
    return path.relative_to(folder).parts[0]


def in_half(origin: str, vendor: str, half: str) -> bool:
    if half == "all":
        return True
    return origin.startswith(_DEVELOPMENT[vendor]) == (half == "development")


def programs(folder: Path, vendor: str) -> Iterator[Path]:
    """The files with one of the language's suffixes; those that other makers use too must look like it."""
    language = find_vendor(vendor)
    for path in sorted(folder.rglob("*")):
        if not path.name.lower().endswith(language.suffixes) or not path.is_file():
            continue
        if vendor == "inform" or language.sniff(load(path)):
            yield path


def chosen(folder: Path, paths: list[Path], most: int) -> list[Path]:
    """At most `most` of each origin, evenly spread: one with many programs does not outweigh all others."""
    origins: dict[str, list[Path]] = defaultdict(list)
    for path in paths:
        origins[origin_of(path, folder)].append(path)
    picked: list[Path] = []
    for found in origins.values():
        step = max(1.0, len(found) / most)
        picked += [found[int(i * step)] for i in range(min(most, len(found)))]
    return picked


class TooLong(BaseException):
    """No answer within the seconds that a file may take."""


def _stop(*_: object) -> None:
    raise TooLong


def judge(path: Path, vendor: str, works: Sequence[Work]) -> Outcome:
    """Reads, writes back, times and translates one file; nothing it does may raise."""
    raw = path.read_bytes()
    complete = bool(re.search(_WHOLE[vendor], raw, re.MULTILINE)) and not re.search(_TEMPLATE, raw)
    runs = path.parent.name.lower() not in _LIBRARIES.get(vendor, ()) and re.search(
        _RUNS.get(vendor, b""), raw
    )
    out = Outcome(str(path), len(_LINE.split(raw)), complete, bool(runs and re.search(_MOTION[vendor], raw)))
    signal.signal(signal.SIGALRM, _stop)
    for work in works:
        signal.alarm(_GIVE_UP_S)
        start = time.process_time()
        try:
            work(out, path, vendor, raw)
        except TooLong:
            out.causes.add(f"no end within {_GIVE_UP_S} s")
        except Exception as problem:
            out.trouble.append(f"{work.__name__[1:]}: {problem!r}"[:200])
        finally:
            signal.alarm(0)
        out.seconds = max(out.seconds, time.process_time() - start)
    return out


def _read(out: Outcome, path: Path, vendor: str, raw: bytes) -> None:
    try:
        program = olp.read(path, vendor=vendor)
    except olp.OlpError as refusal:
        # A text that is no program at all is refused: that is an answer, unless the program is complete.
        out.errors += [f"{d.line}: [{d.code}] {d.message}" for d in refusal.diagnostics if d.is_error]
        return
    out.errors += [f"{d.line}: [{d.code}] {d.message}" for d in program.diagnostics if d.is_error]
    out.opaque.update(
        s.text.split()[0] for s in program.statements() if isinstance(s, Opaque) and s.text.split()
    )
    if program.to_bytes() != raw:
        out.trouble.append("bytes changed")


def _time(out: Outcome, path: Path, vendor: str, raw: bytes) -> None:
    if not (out.complete and out.moves):
        return
    out.timed = False
    try:
        program = olp.read(path, vendor=vendor)
        if not out.errors and not _reaches_move(program):
            out.timed = None
            return
    except olp.OlpError as refusal:
        out.causes |= {f"[{d.code}] {general(d.message)}" for d in refusal.diagnostics if d.is_error}
        return
    for robot in arms(vendor):
        causes = _causes(program, robot)
        if not out.causes or len(causes) < len(out.causes):
            out.causes = causes
        if not causes:
            out.timed = True
        if not causes or all(not cause.startswith(tuple(f"[{code}" for code in _NO_ARM)) for cause in causes):
            return


def _reaches_move(program: Program) -> bool:
    """Whether the routine that runs, or one that it calls, holds a move to another place than where the arm is.

    What the values at hand decide takes no part: this is asked of the text, and not of the run.
    """
    jobs = Jobs(program, Path(program.path).parent)
    main = jobs.main()
    return main is not None and holds_move((main.body, *called_bodies(jobs, main)))


def _causes(program: Program, robot: str) -> set[str]:
    """Why the program has no complete total with this arm, empty: it has."""
    try:
        timing = time_plan(run(program, robot, max_steps=MAX_STEPS, first_move=True))
    except olp.OlpError as refusal:
        return {f"[{d.code}] {general(d.message)}" for d in refusal.diagnostics if d.is_error}
    causes = {f"[{d.code}] {general(d.message)}" for d in timing.diagnostics if d.is_error}
    left_out = {d.line for d in timing.diagnostics if d.code in ("I203", "I209")}
    if not np.any(timing.plan.kind == StepKind.MOVE) and not any(
        s.line in left_out for s in program.statements() if isinstance(s, Move)
    ):
        causes.add("nothing moves")
    elif np.isnan(timing.duration_s).any() and not causes:
        causes.add("a step without a time")
    return causes


def general(message: str) -> str:
    """A message without the names and numbers of its program."""
    return message.split(":")[0][:90] if message.startswith("no ") else _QUOTED.sub("…", message)[:90]


def arms(vendor: str) -> list[str]:
    """Arms of the language's maker (olp has none: KUKA's), spread over the sizes; those with known pulses, if any."""
    maker = maker_of(vendor).casefold().replace(" ", "-")
    names = robot_names()
    own = [n for n in names if n.startswith(f"{maker}/")] or [n for n in names if n.startswith("kuka/")]
    six = [name for name in own if len(load_robot(name).axes) == 6] or own
    six = [name for name in six if load_robot(name).knows_pulses] or six
    step = max(1, len(six) // _TRIED)
    return six[::step][:_TRIED]


def _translate(
    out: Outcome, path: Path, vendor: str, raw: bytes, targets: Sequence[str] | None = None
) -> None:
    """Into RAPID, KRL and TP, from these; or into `targets` from any language."""
    if (targets is None and vendor not in PAIRS) or not (out.complete and out.moves) or out.errors:
        return
    linked = link(olp.read(path, vendor=vendor))
    robot = load_robot(arms(vendor)[0])
    for target in targets or PAIRS:
        if target == vendor:
            continue
        start = time.process_time()
        try:
            made = convert(linked.program, target, Context(robot, on_loss="comment"))
        except olp.OlpError as refusal:
            found = [d for d in refusal.diagnostics if d.is_error]
            count = sum(1 for s in linked.program.statements())
            out.fates[target] = Counter({"refused": count})
            out.unsaid.update(f"to {target}, whole: [{d.code}] {general(d.message)}" for d in found[:1])
            continue
        finally:
            out.seconds = max(out.seconds, time.process_time() - start)
        counts = counts_of(linked.program, made.translated.losses)
        out.fates[target] = sum((Counter(row) for row in counts.values()), Counter())
        out.unsaid.update(
            f"to {target}: {loss.statement}: {general(loss.says)}"
            for loss in made.translated.losses
            if loss.leaves_out and loss.fate is not Fate.EXACT  # of EXACT ones nothing is lost
        )


def _translate_to_all(out: Outcome, path: Path, vendor: str, raw: bytes) -> None:
    _translate(out, path, vendor, raw, writable())


Work = Callable[[Outcome, Path, str, bytes], None]


def _works(given: Namespace) -> tuple[Work, ...]:
    """What is done with each file."""
    translate: Work = _translate_to_all if given.pairs == "all" else _translate
    return (_read, *([] if given.only_pairs else [_time]), *([] if given.no_pairs else [translate]))


def figures(vendor: str, outcomes: list[Outcome]) -> tuple[tuple[str, ...], bool]:
    whole = [o for o in outcomes if o.complete]
    moving = [o for o in whole if o.timed is not None]
    sound = sum(not o.trouble for o in outcomes)
    clean = sum(not o.errors for o in whole)
    timed = sum(bool(o.timed) for o in moving)
    unsaid, total = left_out(row for o in outcomes for row in o.fates.values())
    slowest = max(outcomes, key=lambda o: o.seconds)
    row = (
        vendor,
        f"{len(outcomes)}, {sum(o.lines for o in outcomes):,}",
        share(sound, len(outcomes)),
        share(clean, len(whole)),
        share(timed, len(moving)),
        share(unsaid, total),
        f"{slowest.seconds:.1f} s",
    )
    held = sound == len(outcomes) and clean >= ASKED_CLEAN * len(whole) and timed >= ASKED_TIMED * len(moving)
    return row, held and unsaid <= ASKED_UNSAID * max(total, 1) and slowest.seconds <= SLOWEST_S


def left_out(rows: Iterable[Counter[str]]) -> tuple[int, int]:
    """Statements that are neither exact nor approximated, and all."""
    fates = sum(rows, Counter[str]())
    return fates.total() - fates["exact"] - fates["approximated"], fates.total()


def pair_rows(found: Mapping[str, Sequence[Outcome]]) -> Iterator[tuple[str, ...]]:
    """Per language a line of shares, one for each that is written."""
    for vendor, outcomes in found.items():
        fates = {target: [o.fates[target] for o in outcomes if target in o.fates] for target in writable()}
        cells = ("" if target == vendor else share(*left_out(rows)) for target, rows in fates.items())
        yield (language_of(vendor), *cells)


def share(part: int, whole: int) -> str:
    return f"{100 * part / whole:.1f} % ({part} of {whole})" if whole else "–"


def told(vendor: str, folder: Path, outcomes: list[Outcome], every: bool) -> list[str]:
    """What is in the way, most frequent first."""
    rows = [f"\n## {vendor}\n"]
    named = {o.path: str(Path(o.path).relative_to(folder)) for o in outcomes}
    rows += [f"- {named[o.path]}: {text}" for o in outcomes for text in o.trouble]
    rows += [f"- {named[o.path]}:{text}" for o in outcomes if o.complete for text in o.errors[:3]]
    behind: dict[str, list[str]] = defaultdict(list)
    for o in outcomes:
        for cause in o.causes if not o.timed else ():
            behind[cause].append(named[o.path])
    rows += [
        "\nno complete total (files):",
        *_most(Counter({c: len(p) for c, p in behind.items()}), behind, every),
    ]
    unsaid = sum((o.unsaid for o in outcomes), Counter())
    pairs = [
        f"to {target} {share(*left_out(o.fates[target] for o in outcomes if target in o.fates))}"
        for target in sorted({target for o in outcomes for target in o.fates})
    ]
    rows += [f"\nnot translated (statements), {', '.join(pairs)}:", *_most(unsaid, {}, every)]
    opaque = sum((o.opaque for o in outcomes), Counter())
    rows += ["\nkept but not modelled:", *_most(opaque, {}, every)]
    rows += [f"slow: {named[o.path]}: {o.seconds:.1f} s" for o in outcomes if o.seconds > SLOWEST_S]
    return rows


def _most(counts: Counter[str], behind: dict[str, list[str]], every: bool) -> list[str]:
    rows = [f"{count:6} {text}" for text, count in counts.most_common(40)]
    if every:
        rows = [r + "".join(f"\n         {p}" for p in behind.get(r[7:], ())[:12]) for r in rows]
    return rows


def print_table(head: tuple[str, ...], rows: Iterable[tuple[object, ...]]) -> None:
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(map(str, row)) + " |")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
