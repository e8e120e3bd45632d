"""Three-way merges: how many conflicts, and whether anything was lost or is wrong.

    python bench/merge.py made [COUNT [SEED]]          made programs of all languages, against what must come out
    python bench/merge.py real FOLDER [HALF [MOST [KEEP]]]   merges cut from the histories below FOLDER; 320 made ones
    python bench/merge.py speed                        a job of 10,000 lines: the whole command, its start included

HALF is `development`, `held-out` or `all`; MOST limits the pairs of versions of each repository, and below KEEP stands
what was wrong. `real` has five kinds of merges:

    merges that happened: both parents changed a program
    two changes that happened: of three versions in a row, the second change is made in the first one, as a rebase does
        it (`on_its_own` of the oracle)
    a change undone: of three versions in a row, the first change is taken back while the second one stays, as `git
        revert` does it, with the middle version as base
    a change that happened, points touched up: what a version became, and up to three positions moved of those that it
        left alone
    a change that happened, cut in two: its places, each given to one of two sides

Of the second, fourth and fifth it is known what must come out, to the byte.
`bench/merge_oracle.py` says what is right, and `git merge-file` does the same merges.
"""

from __future__ import annotations

import itertools
import os
import random
import re
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import NamedTuple

from olp.checks.merge.merge import merge_bytes
from olp.checks.merge.model import MergedText
from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.languages.vendor import find_vendor, recognise
from olp.runtime.interpreter import run

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from bench.merge_oracle import (
    Shared,
    alike,
    both_changed,
    cut_in_two,
    lost,
    on_its_own,
    renamed,
    touched_up,
    wrong,
)

SUFFIXES = (
    ".jbi", ".src", ".sub", ".dat", ".mod", ".modx", ".prg", ".sys", ".ls", ".script", ".pgx", ".dtx", ".as", ".pg",
    ".pdl",
)  # fmt: skip


# --- Counting ---


@dataclass
class Sums:
    """Of the conflicts, `ours_place`: both sides only put something at one place, or into what the other took out;
    `ours_closed`, `git_closed`: false ones, both sides changed nothing that is the same. The others are forced: both
    changed the same statement, point or datum, by the oracle. `git_wrong`: git had no conflict, and not what must come
    out.
    """

    merges: int = 0
    ours: int = 0
    git: int = 0
    ours_place: int = 0
    ours_closed: int = 0
    git_closed: int = 0
    worse: int = 0
    hunks: int = 0
    git_hunks: int = 0
    bad: int = 0
    git_wrong: int = 0
    refused: int = 0
    seconds: float = 0.0
    examples: list[str] = field(default_factory=list)


_COUNTED = [one.name for one in fields(Sums) if one.name != "examples"]


class Case(NamedTuple):
    """A merge to judge. `expected`: what must come out, where that is known."""

    name: str
    base: bytes
    ours: bytes
    theirs: bytes
    expected: bytes | None = None


def by_git(folder: Path, case: Case) -> tuple[int, bytes]:
    """How many conflicts git's own merge of texts has, and what it writes."""
    for name, data in (("base", case.base), ("ours", case.ours), ("theirs", case.theirs)):
        (folder / name).write_bytes(data)
    command = ["git", "merge-file", "-p", "-q", "ours", "base", "theirs"]
    done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    return (done.returncode if done.returncode < 128 else 1), done.stdout


def judge(sums: Sums, case: Case, folder: Path, keep: Path | None = None) -> None:
    vendor = recognise(decode(case.base, case.name)) or recognise(decode(case.ours, case.name))
    begin = time.process_time()
    try:
        merged = None if vendor is None else merge_bytes(vendor.name, case.base, case.ours, case.theirs)
    except OlpError:
        merged = None
    if vendor is None or merged is None:
        sums.refused += 1
        return
    sums.seconds += time.process_time() - begin
    conflicts, written = by_git(folder, case)
    base, ours, theirs = (one.decode("latin-1") for one in case[1:4])
    shared = Shared([], [])
    if case.expected is None and (conflicts or merged.hunks):
        shared = both_changed(vendor.name, folder, base, ours, theirs)
    sums.merges += 1
    sums.git += conflicts > 0
    sums.git_hunks += conflicts
    sums.ours += bool(merged.hunks)
    sums.hunks += len(merged.hunks)
    sums.ours_place += bool(merged.hunks) and not shared.same and bool(shared.places)
    sums.ours_closed += bool(merged.hunks) and not shared.same
    sums.git_closed += conflicts > 0 and not shared.same
    sums.worse += bool(merged.hunks) and not conflicts
    sums.git_wrong += case.expected is not None and not conflicts and written != case.expected
    found = list(_faults(vendor.name, case, merged, folder))
    sums.bad += bool(found)
    alone = bool(merged.hunks) and not shared.same
    told = [f"{len(merged.hunks)} conflicts, {len(shared.places)} by the oracle"] if alone else []
    for text in [*found[:1], *told]:
        sums.examples.append(f"{case.name}: {text}")
    if keep is not None and (found or told):
        place = keep / re.sub(r"[^\w.#-]", "_", case.name)
        place.mkdir(parents=True, exist_ok=True)
        wanted = b"" if case.expected is None else case.expected
        for label, data in zip(
            ("base", "ours", "theirs", "merged", "expected", "said"),
            (
                *case[1:4],
                merged.to_bytes(),
                wanted,
                "\n".join([*found, *shared.same, *shared.places]).encode(),
            ),
            strict=True,
        ):
            (place / label).write_bytes(data)


def _faults(language: str, case: Case, merged: MergedText, folder: Path) -> Iterator[str]:
    """What is wrong with a merge. A conflict too many is none of these."""
    data = merged.to_bytes()
    swapped = merge_bytes(language, case.base, case.theirs, case.ours)
    if swapped.swapped() != merged or (not merged.hunks and swapped.to_bytes() != data):
        yield "not the same with the sides swapped"
    base, ours, theirs, text = (one.decode("latin-1") for one in (*case[1:4], data))
    if any(merged.renamed.values()):
        base, ours, theirs = renamed(language, base, ours, theirs, text)
    if merged.hunks:
        yield from lost(language, ours, theirs, base, text)
    elif case.expected is not None:
        if not alike(language, text, case.expected.decode("latin-1")):
            yield "not what must come out"
    else:
        yield from wrong(language, base, ours, theirs, text)
        yield from _elsewhere(language, case, data, folder)


def _elsewhere(language: str, case: Case, merged: bytes, folder: Path) -> Iterator[str]:
    """Where the four programs go when they run: to no place that no version knows, and to all that are new on a side.

    Places are those of the tool, in millimetres and in the robot's base frame; of a program without a file beside it.
    """
    name = case.name.partition("#")[0]
    base, ours, theirs, came = (_places(language, data, name, folder) for data in (*case[1:4], merged))
    if base is None or ours is None or theirs is None or came is None:
        return
    _RAN.append(len(came))
    for place in sorted(came - base - ours - theirs):
        yield f"goes to {place}, which no version does"
    for place in sorted(((ours | theirs) - base) - came):
        yield f"does not go to {place}, which is new"


_RAN: list[int] = []  # of each merge that was run, how many places it goes to


def _places(language: str, data: bytes, name: str, folder: Path) -> set[tuple[float, ...]] | None:
    """The targets of a program's moves; None where it is not a program or has a mistake."""
    if name.lower().endswith((".dat", ".dtx")):
        return None
    program = find_vendor(language).read(decode(data, name))
    if not program.routines or any(one.is_error for one in program.diagnostics):
        return None
    (folder / "empty").mkdir(exist_ok=True)
    plan = run(program, folder=folder / "empty", max_steps=20_000)
    rows = plan.moves.target
    known = plan.positions
    found = set()
    for row in {int(one) for one in rows}:
        place = known.position[row] * 1e3
        values = place if place[0] == place[0] else known.axes[row]
        if all(value == value for value in values):
            found.add(tuple(round(float(value), 4) + 0.0 for value in values))
    return found


def table(rows: dict[str, Sums], examples: int = 10) -> None:
    heads = (
        f"{'':17} {'conflicts':>9} {'':13} | {'forced':>6} {'':5} | {'false':>5} {'':20}",
        f" | {'hunks':>6} {'':6} | {'git':>5}\n{'':10} {'merges':>6} {'olp':>9} {'git':>5} {'fewer':>7} |",
        f" {'olp':>6} {'git':>5} | {'olp':>5} {'git':>5} {'fewer':>7} {'places':>6} | {'olp':>6} {'git':>6} |",
        f" {'wrong':>5} {'worse':>6} {'wrong':>6} {'ms each':>8}",
    )
    print("".join(heads))
    whole = total(rows)
    for name, one in [*rows.items(), ("all", whole)]:
        each = 1e3 * one.seconds / one.merges if one.merges else 0.0
        false = f"{one.ours_closed:5} {one.git_closed:5} {_fewer(one.ours_closed, one.git_closed):>7}"
        print(
            f"{name:10} {one.merges:6} {one.ours:9} {one.git:5} {_fewer(one.ours, one.git):>7} |"
            f" {one.ours - one.ours_closed:6} {one.git - one.git_closed:5} |"
            f" {false} {one.ours_place:6} | {one.hunks:6} {one.git_hunks:6} | {one.git_wrong:5} {one.worse:6}"
            f" {one.bad:6} {each:8.1f}"
        )
    for one in rows.values():
        for example in one.examples[:examples]:
            print("  ", example)
    if whole.refused:
        print(f"{whole.refused} refused: no text of a language, or conflict markers in it")


def total(rows: dict[str, Sums]) -> Sums:
    """All of them together."""
    found = Sums()
    for one in rows.values():
        for key in _COUNTED:
            setattr(found, key, getattr(found, key) + getattr(one, key))
    return found


def _fewer(ours: int, git: int) -> str:
    return f"{100 * (1 - ours / git):.0f} %" if git else "-"


# --- Real histories ---


def repositories(folder: Path, half: str) -> list[tuple[str, Path, dict[str, list[str]]]]:
    """Name, git directory and the blobs of each program's versions, of one half of the repositories ("all": of all).

    In the order of how many pairs of versions they have, the first, fourth, fifth, eighth … are for development.
    """
    found = []
    for place in sorted({path.parent for path in folder.rglob("HEAD") if (path.parent / "objects").is_dir()}):
        name = next(one for one in reversed(place.relative_to(folder).parts) if one not in (".git", "repo"))
        versions = _versions(place)
        pairs = sum(len(blobs) - 1 for blobs in versions.values())
        if pairs:
            found.append((-pairs, name, place, versions))
    return [
        (name, place, versions)
        for rank, (_, name, place, versions) in enumerate(sorted(found, key=lambda one: one[:2]))
        if half in ("all", "development" if rank % 4 in (0, 3) else "held-out")
    ]


def _git(place: Path, *words: str) -> bytes:
    return subprocess.run(["git", f"--git-dir={place}", *words], capture_output=True, check=False).stdout


def _versions(place: Path) -> dict[str, list[str]]:
    """The blobs of each program that has two versions or more, from the first on."""
    blobs: dict[str, list[str]] = defaultdict(list)
    log = _git(
        place,
        "log",
        "--reverse",
        "--no-merges",
        "--no-renames",
        "--raw",
        "--no-abbrev",
        "-z",
        "--format=",
        "HEAD",
    )
    words = log.decode("utf-8", "surrogateescape").split("\0")
    for head, path in itertools.pairwise(words):
        row = head.lstrip("\n").split()
        if len(row) == 5 and row[0].startswith(":") and path.lower().endswith(SUFFIXES):
            blob = row[3]
            if set(blob) != {"0"} and (not blobs[path] or blobs[path][-1] != blob):
                blobs[path].append(blob)
    return {path: some for path, some in blobs.items() if len(some) > 1}


KINDS = {
    "merge": "merges that happened",
    "apart": "two changes that happened, each made in the same version",
    "undo": "a change undone that another one followed",
    "night": "a change that happened, points touched up",
    "cut": "a change that happened, cut in two",
    "made": "made: points moved in one version, logic changed in the other",
}


def cases(folder: Path, half: str, most: int) -> Iterator[tuple[str, Case]]:
    """The kind of each merge that is cut from the histories, and the merge."""
    with tempfile.TemporaryDirectory() as made:
        for repository, place, versions in repositories(folder, half):
            for case in itertools.islice(_happened(repository, place), most):
                yield "merge", case
            pairs = (
                (path, at, blobs[at : at + 3])
                for path, blobs in versions.items()
                for at in range(len(blobs) - 1)
            )
            for path, at, blobs in itertools.islice(pairs, most):
                texts = [_git(place, "cat-file", "blob", one) for one in blobs]
                yield from _cut(Path(made), f"{repository}/{path}#{at}", texts)


def _cut(folder: Path, name: str, texts: list[bytes]) -> Iterator[tuple[str, Case]]:
    choose = random.Random(name)
    if len(texts) > 2:
        yield "undo", Case(name, texts[1], texts[0], texts[2])
        apart = on_its_own(folder, *texts)
        if apart is not None:
            yield "apart", Case(name, texts[0], *apart)
    touched = touched_up(texts[0], texts[1], choose)
    if touched is not None:
        yield "night", Case(name, texts[0], *touched)
    numbered = name.lower().partition("#")[0].endswith((".jbi", ".ls"))
    cut = None if numbered else cut_in_two(folder, texts[0], texts[1], choose)
    if cut is not None:
        yield "cut", Case(name, texts[0], *cut)


def _happened(repository: str, place: Path) -> Iterator[Case]:
    """Merges in the history whose two sides both changed a program."""
    for line in _git(place, "rev-list", "--merges", "--parents", "--all").decode().splitlines():
        commit, *parents = line.split()
        base = _git(place, "merge-base", *parents).decode().split()
        if len(parents) != 2 or not base:
            continue
        words = ("diff", "--name-only", "--no-renames", "-z", base[0])
        sides = [
            set(_git(place, *words, one).decode("utf-8", "surrogateescape").split("\0")) for one in parents
        ]
        for path in sorted(sides[0] & sides[1]):
            texts = [_git(place, "cat-file", "blob", f"{one}:{path}") for one in (base[0], *parents)]
            if path.lower().endswith(SUFFIXES) and all(texts):
                yield Case(f"{repository}/{path}#{commit[:7]}", *texts)


def real(folder: Path, half: str, most: int, keep: Path | None) -> None:
    kinds: dict[str, dict[str, Sums]] = {kind: {} for kind in KINDS if kind != "made"}
    with tempfile.TemporaryDirectory() as work:
        for kind, case in cases(folder, half, most):
            suffix = Path(case.name.partition("#")[0]).suffix.lower()
            sums = kinds[kind].setdefault(suffix, Sums())
            judge(sums, case, Path(work), None if keep is None else keep / kind)
    made_rows = made(40, 1)
    whole = {}
    for kind, rows in [*kinds.items(), ("made", made_rows)]:
        print(f"\n{KINDS[kind]}")
        table(dict(sorted(rows.items())))
        whole[kind] = total(rows)
    print("\nall")
    table(whole, examples=0)
    print(f"\n{len(_RAN)} merges without conflicts were run with their versions, to {sum(_RAN)} places")


# --- Made programs ---


@dataclass(frozen=True)
class Step:
    """A move to a position, or a line of logic. `name`: of the position, for life; `joint`: no straight move."""

    name: str
    values: tuple[float, ...] = ()
    speed: int = 100
    comment: str = ""
    word: str = ""
    joint: bool = False


@dataclass(frozen=True)
class Made:
    steps: tuple[Step, ...]
    date: str = "2026/03/01 08:00"
    revision: int = 4


def program(choose: random.Random) -> Made:
    return Made(tuple(_step(choose, f"p{n + 1}") for n in range(choose.randint(4, 30))))


def _step(choose: random.Random, name: str) -> Step:
    values = tuple(round(choose.uniform(-400, 900), 3) for _ in range(3))
    values += tuple(round(choose.uniform(-170, 170), 2) for _ in range(3))
    return Step(
        name, values, choose.choice((100, 150, 200, 250, 500)), choose.choice(("", "", "near", "part"))
    )


def night(made: Made, choose: random.Random) -> tuple[Made, set[str]]:
    """Points touched up on the robot, and the header that the controller writes."""
    steps = list(made.steps)
    places = [n for n, step in enumerate(steps) if step.values]
    chosen = choose.sample(places, min(len(places), choose.randint(1, 5)))
    for n in chosen:
        values = tuple(
            round(v + choose.uniform(0.5, 4.0), 3 if k < 3 else 2) for k, v in enumerate(steps[n].values)
        )
        steps[n] = replace(steps[n], values=values)
    return Made(tuple(steps), "2026/03/02 03:12", made.revision + 1), {steps[n].name for n in chosen}


def office(made: Made, choose: random.Random) -> tuple[Made, set[str]]:
    """Logic changed: speeds, new steps, steps that go, signals, straight moves that become joint moves.

    The positions that stay are as they were.
    """
    steps = list(made.steps)
    gone: set[str] = set()
    for number in range(choose.randint(1, 5)):
        at = choose.randrange(len(steps))
        kind = choose.choice(("speed", "new", "gone", "signal", "comment", "joint"))
        if kind == "speed" and steps[at].values:
            steps[at] = replace(steps[at], speed=steps[at].speed + 20)
        elif kind == "new":
            steps.insert(at, _step(choose, f"q{number + 1}"))
        elif kind == "gone" and len(steps) > 3 and steps[at].values:
            gone.add(steps.pop(at).name)
        elif kind == "signal":
            steps.insert(at, Step("", word=f"signal {choose.randint(1, 9)}{number}"))
        elif kind == "joint" and steps[at].values:
            steps[at] = replace(steps[at], joint=not steps[at].joint, speed=choose.choice((100, 300, 900)))
        elif steps[at].values:
            steps[at] = replace(steps[at], comment=f"way {number}")
    return Made(tuple(steps), "2026/03/01 17:45", made.revision), gone


def both(made: Made, robot: Made, changed: Made, touched: set[str]) -> Made:
    """What must come out: the office's steps with the robot's positions."""
    values = {step.name: step.values for step in robot.steps if step.name in touched}
    steps = tuple(replace(step, values=values.get(step.name, step.values)) for step in changed.steps)
    return Made(steps, robot.date, robot.revision)


def spell(language: str, made: Made) -> str:
    return globals()[f"_as_{language}"](made)


def _numbers(values: tuple[float, ...], sign: str = ",") -> str:
    return sign.join(f"{v:.3f}" for v in values)


def _as_inform(made: Made) -> str:
    moves = [step for step in made.steps if step.values]
    rows = [f"C{n:05d}={_numbers(step.values)}" for n, step in enumerate(moves)]
    body, n = [], 0
    for step in made.steps:
        if step.values:
            how = f"J C{n:05d} VJ={step.speed / 10:.2f}" if step.joint else f"L C{n:05d} V={step.speed:.1f}"
            body.append(f"MOV{how}" + (f"  //{step.comment}" if step.comment else ""))
            n += 1
        else:
            number = step.word.split()[1]
            body.append(f"DOUT OT#({number}) ON")
    head = [
        "/JOB",
        "//NAME MADE",
        "//POS",
        f"///NPOS {len(rows)},0,0,0,0,0",
        "///TOOL 0",
        "///POSTYPE BASE",
        "///RECTAN",
    ]
    head += [
        "///RCONF 1,0,0,0,0,0,0,0",
        *rows,
        "//INST",
        f"///DATE {made.date}",
        "///ATTR SC,RW",
        "///GROUP1 RB1",
        "NOP",
    ]
    return "\r\n".join([*head, *body, "END", ""])


def _as_tp(made: Made) -> str:
    first = {f"p{n + 1}": n + 1 for n in range(40)}
    known = [step.name for step in made.steps if step.values]
    highest = _HIGHEST[0]
    numbers = {}
    for name in known:
        if name in first:
            numbers[name] = first[name]
    for name in [name for name in known if name not in first]:
        highest += 1
        numbers[name] = highest
    body = []
    for step in made.steps:
        if step.values:
            label = f':"{step.comment}"' if step.comment else ""
            path, speed = ("J", f"{step.speed // 10}%") if step.joint else ("L", f"{step.speed}mm/sec")
            body.append(f"{path} P[{numbers[step.name]}{label}] {speed} FINE    ;")
        else:
            body.append(f"  DO[{step.word.split()[1]}]=ON ;")
    date = made.date[2:10].replace("/", "-") + "  TIME " + made.date[11:] + ":00"
    text = ["/PROG  MADE", "/ATTR", "OWNER\t\t= MNEDITOR;", "CREATE\t\t= DATE 26-01-01  TIME 10:00:00;"]
    text += [f"MODIFIED\t= DATE {date};", f"LINE_COUNT\t= {len(body)};", "/MN"]
    text += [f"{n:4d}:{line}" for n, line in enumerate(body, 1)] + ["/POS"]
    for name in sorted(numbers, key=lambda one: numbers[one]):
        step = next(one for one in made.steps if one.name == name)
        v = step.values
        text += [f"P[{numbers[name]}]{{", "   GP1:", "\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',"]
        text += [f"\tX = {v[0]:9.3f}  mm,\tY = {v[1]:9.3f}  mm,\tZ = {v[2]:9.3f}  mm,"]
        text += [f"\tW = {v[3]:9.3f} deg,\tP = {v[4]:9.3f} deg,\tR = {v[5]:9.3f} deg", "};"]
    return "\r\n".join([*text, "/END", ""])


_HIGHEST = [0]  # of the numbers that the program had at first: a new position gets the next one


def _as_krl(made: Made) -> str:
    text = ["&ACCESS RVP", f"&REL {made.revision}", "DEF made ( )"]
    text += [
        f"DECL E6POS X{s.name}={{"
        + ",".join(f"{key} {value:.3f}" for key, value in zip("XYZABC", s.values, strict=True))
        + "}"
        for s in sorted(made.steps, key=_named)
        if s.values
    ]
    for s in made.steps:
        if s.values:
            text.append(f"$VEL.CP={s.speed / 1000:.3f}" + (f" ; {s.comment}" if s.comment else ""))
            text.append(f"{'PTP' if s.joint else 'LIN'} X{s.name}")
        else:
            text.append(f"$OUT[{s.word.split()[1]}]=TRUE")
    return "\r\n".join([*text, "END", ""])


def _as_rapid(made: Made) -> str:
    text = ["MODULE Made"]
    speeds = sorted({s.speed for s in made.steps if s.values})
    text += [f"  CONST speeddata speed{one}:=[{one},500,5000,1000];" for one in speeds]
    text += [
        f"  CONST robtarget {s.name}:=[[{_numbers(s.values[:3])}],[1,0,0,0],[{int(s.values[3] / 90)},0,0,0],"
        "[9E9,9E9,9E9,9E9,9E9,9E9]];"
        for s in sorted(made.steps, key=_named)
        if s.values
    ]
    text.append("  PROC main()")
    for s in made.steps:
        note = f" ! {s.comment}" if s.comment else ""
        text.append(
            f"    Move{'J' if s.joint else 'L'} {s.name},speed{s.speed},fine,tool0;{note}"
            if s.values
            else f"    SetDO do{s.word.split()[1]},1;"
        )
    return "\n".join([*text, "  ENDPROC", "ENDMODULE", ""])


def _as_urscript(made: Made) -> str:
    text = ["def made():"]
    for s in sorted(made.steps, key=_named):
        if s.values:
            text.append(f"  global {s.name} = p[{_numbers(tuple(v / 1000 for v in s.values), ', ')}]")
    for s in made.steps:
        note = f"  # {s.comment}" if s.comment else ""
        text.append(
            f"  move{'j' if s.joint else 'l'}({s.name}, v={s.speed / 1000:.3f}){note}"
            if s.values
            else f"  set_standard_digital_out({s.word.split()[1]}, True)"
        )
    return "\n".join([*text, "end", ""])


def _as_as(made: Made) -> str:
    text = [".PROGRAM made() #0"]
    for s in made.steps:
        note = f" ; {s.comment}" if s.comment else ""
        text += (
            [f"  SPEED {s.speed} MM/S{note}", f"  {'J' if s.joint else 'L'}MOVE {s.name}"]
            if s.values
            else [f"  SIGNAL {s.word.split()[1]}"]
        )
    text += [".END", ".TRANS"]
    text += [f"{s.name} {_numbers(s.values, ' ')}" for s in sorted(made.steps, key=_named) if s.values]
    return "\r\n".join([*text, ".END", ""])


def _as_pdl2(made: Made) -> str:
    text = ["PROGRAM made", "VAR"]
    names = sorted((s for s in made.steps if s.values), key=_named)
    text += [f"  {s.name} : POSITION" for s in names] + ["BEGIN"]
    for s in names:
        text.append(f"  {s.name} := POS({_numbers(s.values, ', ')}, '')")
    for s in made.steps:
        note = f" -- {s.comment}" if s.comment else ""
        text += (
            [
                f"  $LIN_SPD := {s.speed / 1000:.3f}{note}",
                f"  MOVE {'JOINT' if s.joint else 'LINEAR'} TO {s.name}",
            ]
            if s.values
            else [f"  $DOUT[{s.word.split()[1]}] := ON"]
        )
    return "\r\n".join([*text, "END made", ""])


def _as_val3(made: Made) -> str:
    text = ['<Database xmlns="http://www.staubli.com/robotics/VAL3/Data/2">', "  <Datas>"]
    for s in sorted((s for s in made.steps if s.values), key=_named):
        x, y, z, rx, ry, rz = s.values
        text += [f'    <Data name="{s.name}" access="public" xsi:type="array" type="pointRx" size="1">']
        text += [
            f'      <Value key="0" x="{x}" y="{y}" z="{z}" rx="{rx}" ry="{ry}" rz="{rz}" fatherId="world[0]" />',
            "    </Data>",
        ]
    return "\n".join([*text, "  </Datas>", "</Database>", ""])


def _named(step: Step) -> tuple[str, int]:
    return step.name[:1], int(step.name[1:] or 0)


_SUFFIX = {
    "inform": ".jbi", "tp": ".ls", "krl": ".src", "rapid": ".mod", "as": ".as", "pdl2": ".pdl", "val3": ".dtx",
    "urscript": ".script",
}  # fmt: skip
LANGUAGES = tuple(_SUFFIX)


def made(count: int, seed: int) -> dict[str, Sums]:
    """So many of each language, but for those in which both sides changed one position."""
    rows: dict[str, Sums] = {}
    with tempfile.TemporaryDirectory() as folder:
        for language in LANGUAGES:
            sums = rows.setdefault(language, Sums())
            suffix = _SUFFIX[language]
            done = 0
            while done < count:
                choose = random.Random(f"{language} {seed} {done}")
                done += 1
                base = program(choose)
                _HIGHEST[0] = len(base.steps)
                robot, touched = night(base, choose)
                changed, gone = office(base, choose)
                if touched & gone:
                    continue  # both changed that position: a conflict, as it has to be
                want = both(base, robot, changed, touched)
                texts = [spell(language, one).encode() for one in (base, robot, changed, want)]
                judge(sums, Case(f"made{suffix}", *texts), Path(folder))
    return rows


def speed() -> None:
    """The command in a process of its own, with and without times, and the merge alone."""
    choose = random.Random(1)
    base = Made(tuple(_step(choose, f"p{n + 1}") for n in range(5000)))
    robot, _ = night(base, choose)
    changed, _ = office(base, choose)
    print(
        f"{'language':10} {'lines':>6} {'merge':>8} {'command':>8} {'with times':>10}   [s of CPU, best of 3]"
    )
    with tempfile.TemporaryDirectory() as folder:
        for language, suffix in _SUFFIX.items():
            _HIGHEST[0] = len(base.steps)
            share = 10_000 / len(spell(language, base).splitlines())
            sides = [
                replace(one, steps=one.steps[: int(share * len(one.steps))]) for one in (base, robot, changed)
            ]
            texts = [spell(language, one).encode() for one in sides]
            paths = [Path(folder) / f"{name}{suffix}" for name in ("base", "ours", "theirs")]
            for path, data in zip(paths, texts, strict=True):
                path.write_bytes(data)
            begin = time.process_time()
            merge_bytes(language, texts[0], texts[1], texts[2])
            alone = time.process_time() - begin
            command = [sys.executable, "-m", "olp", "merge", *map(str, paths), "-o", "-"]
            told = [min(_cpu([*command, *more]) for _ in range(3)) for more in (["--no-time"], [])]
            print(f"{language:10} {len(texts[0].splitlines()):6} {alone:8.2f} {told[0]:8.2f} {told[1]:10.2f}")


def _cpu(command: list[str]) -> float:
    """With the modules' bytecode, as where olp is installed: the first run may write it."""
    environment = {name: text for name, text in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    before = os.times()
    subprocess.run(command, capture_output=True, check=True, env=environment)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def main(words: list[str]) -> None:
    if words[:1] == ["made"]:
        table(made(int(words[1]) if len(words) > 1 else 125, int(words[2]) if len(words) > 2 else 1))
    elif words[:1] == ["real"] and len(words) > 1:
        half = words[2] if len(words) > 2 else "all"
        most = int(words[3]) if len(words) > 3 else 10**9
        real(Path(words[1]), half, most, Path(words[4]) if len(words) > 4 else None)
    elif words == ["speed"]:
        speed()
    else:
        print(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
