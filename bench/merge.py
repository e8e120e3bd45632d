"""Three-way merges: how many conflicts, and whether anything was lost or is wrong.

    python bench/merge.py made [COUNT [SEED]]      made programs of all languages, against what must come out
    python bench/merge.py real FOLDER [MOST]       versions out of the repositories below FOLDER (bare ones as well)
    python bench/merge.py speed                    a job of 10,000 lines

`real` cuts two merges out of three versions that follow each other: the middle one as base and the others as sides,
and the first as base, the second as theirs and the first with three positions touched up as ours, of those that the
second version has left alone. What is right is decided here from the lines alone, with no code of the merge: how often
each line stands in base, ours, theirs and merge, without numbers of lines, and with positions in place of numbers.
`git merge-file` does the same merges.
"""

from __future__ import annotations

import itertools
import random
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from olp.checks.merge.merge import merge_bytes
from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.languages.vendor import recognise, vendor_names

SUFFIXES = (
    ".jbi", ".src", ".sub", ".dat", ".mod", ".modx", ".prg", ".sys", ".ls", ".script", ".pgx", ".dtx", ".as", ".pg",
    ".pdl",
)  # fmt: skip


# --- What is right, from the lines alone ---


def facts(language: str, text: str) -> tuple[Counter[str], Counter[str]]:
    """Statements without the numbers of their positions, and positions as statements use them or as data have them."""
    lines = [" ".join(line.split()) for line in re.split(r"\r\n|\n|\r", text)]
    if language == "inform":
        return _inform(lines)
    if language == "tp":
        return _tp(lines)
    lines = [line for line in lines if line and not re.match(r"&REL\b", line)]
    return _words(lines, _MARKS[language])


_MARKS = {"krl": ";", "rapid": "!", "urscript": "#", "as": ";", "pdl2": "--", "val3": "//"}


def _words(lines: list[str], mark: str) -> tuple[Counter[str], Counter[str]]:
    """Words and remarks: one side may change the words of a line and the other what is remarked on them."""
    split = [line.partition(mark) for line in lines]
    return Counter(s[0].strip() for s in split if s[0].strip()), Counter(
        s[2].strip() for s in split if s[2].strip()
    )


def _inform(lines: list[str]) -> tuple[Counter[str], Counter[str]]:
    rows, state = {}, {}
    said: Counter[str] = Counter()
    used: Counter[str] = Counter()
    for line in lines:
        row = re.match(r"(BC|EC|BP|EX|C|P|E)(\d+)=(.*)", line)
        record = re.match(r"///(TOOL|USER|POSTYPE|RECTAN|PULSE|ANGLE|RCONF)\b(.*)", line)
        if row:
            pulse = state.get("kind") == "PULSE"
            keys = ("TOOL", "kind") if pulse else ("TOOL", "kind", "POSTYPE", "RCONF")
            user = state.get("USER", "") if "USER" in state.get("POSTYPE", "") else ""
            rows[row[1] + row[2]] = row[3] + "|".join(state.get(key, "") for key in keys) + user
        elif record:
            if record[1] in ("RECTAN", "PULSE", "ANGLE"):
                state["kind"] = record[1]
            else:
                state[record[1]] = record[2].strip()
        elif line.startswith(("///DATE", "///NPOS")):
            continue
        elif line:
            code = (
                line
                if line.startswith("'")
                else line.partition("//")[0]
                if not line.startswith("/")
                else line
            )
            found = [] if line.startswith("'") else re.findall(r"(?<![A-Z0-9#])(?:BC|EC|C)\d{3,}", code)
            for name in found:
                used[rows.get(name, name)] += 1
                line = line.replace(name, "@", 1)
            said[line] += 1
    # A position that nothing uses is there all the same.
    for name, row in rows.items():
        if name[0] in "PX" or name.startswith(("BP", "EX")):
            used[f"{name} {row}"] += 1
    return said, used


def _tp(lines: list[str]) -> tuple[Counter[str], Counter[str]]:
    text = "\n".join(lines)
    blocks = dict(re.findall(r"^P ?\[ ?(\d+)[^\]\n]*\] ?\{([^}]*)\}", text, re.MULTILINE))
    said: Counter[str] = Counter()
    used: Counter[str] = Counter()
    head = text.partition("\n/POS")[0]
    for line in head.split("\n"):
        if re.match(r"(MODIFIED|CREATE|LINE_COUNT|PROG_SIZE|MEMORY_SIZE|VERSION)\b", line) or not line:
            continue
        line = re.sub(r"^\d+:", "", line).strip()
        for number in re.findall(r"(?<![\w$])P\[ ?(\d+)", line) if not line.startswith("!") else ():
            used[blocks.get(number, number)] += 1
        said[re.sub(r"(?<![\w$])P\[ ?\d+", "P[@", line)] += 1
    return said, used


def wrong(language: str, base: str, ours: str, theirs: str, merged: str) -> list[str]:
    """What a merge without conflicts lost, doubled, made up or put into another order."""
    found = []
    for of in zip(*(facts(language, text) for text in (base, ours, theirs, merged)), strict=True):
        b, o, t, m = of
        for fact in b.keys() | o.keys() | t.keys() | m.keys():
            low, high = _allowed(b[fact], o[fact], t[fact])
            if not low <= m[fact] <= high:
                found.append(f"{b[fact]} {o[fact]} {t[fact]} -> {m[fact]}: {fact[:90]}")
    return [*found, *_order(language, base, ours, theirs, merged)]


def _allowed(b: int, o: int, t: int) -> tuple[int, int]:
    if o == t:
        return (o, o) if o == b else (min(o, 2 * o - b), max(o, 2 * o - b))
    if o == b or t == b:
        only = t if o == b else o
        return only, only
    both = o + t - b
    return max(0, min(o, t, both)), max(o, t, both)


def _order(language: str, base: str, ours: str, theirs: str, merged: str) -> Iterator[str]:
    """Statements that come once in all and stand in one order on both sides keep it."""
    if language == "inform":
        places = [
            _places(
                re.sub(r"(?m)^(?:C|BC|EC|P|BP|EX)\d+=.*$|^///.*$|(?<![A-Z0-9#])(?:BC|EC|C)\d{3,}", "", text)
            )
            for text in (ours, theirs, merged)
        ]
    elif language == "tp":
        places = [
            _places(re.sub(r"(?m)^\s*\d+:|(?<![\w$])P\[ ?\d+", "", text.partition("/POS")[0]))
            for text in (ours, theirs, merged)
        ]
    else:
        places = [_places(text) for text in (ours, theirs, merged)]
    o, t, m = places
    if any(word in merged for word in ("DEFDAT", "<Data", ".TRANS")):
        return  # lists of data have no order
    both = sorted((line for line in m if line in o and line in t and len(line) > 3), key=lambda line: m[line])
    for one, other in itertools.pairwise(both):
        if o[one] > o[other] and t[one] > t[other]:
            yield f"order: {one[:50]} before {other[:50]}"


def _places(text: str) -> dict[str, int]:
    lines = [" ".join(line.split()) for line in re.split(r"\r\n|\n|\r", text)]
    often = Counter(lines)
    return {line: at for at, line in enumerate(lines) if line and often[line] == 1}


def lost(language: str, ours: str, theirs: str, base: str, merged: str) -> list[str]:
    """Lines new on a side that a merge with conflicts does not show anywhere."""
    b, o, t, m = (facts(language, text)[0] for text in (base, ours, theirs, merged))
    return [f"not shown: {line[:90]}" for line in (o - b) | (t - b) if not m[line]]


# --- Counting ---


@dataclass
class Sums:
    merges: int = 0
    ours: int = 0
    git: int = 0
    hunks: int = 0
    git_hunks: int = 0
    bad: int = 0
    refused: int = 0
    examples: list[str] = field(default_factory=list)
    seconds: float = 0.0


def by_git(folder: Path, base: bytes, ours: bytes, theirs: bytes) -> int:
    """How many conflicts git's own merge of texts has."""
    for name, data in (("base", base), ("ours", ours), ("theirs", theirs)):
        (folder / name).write_bytes(data)
    command = ["git", "merge-file", "-p", "-q", "ours", "base", "theirs"]
    done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    return done.returncode if done.returncode < 128 else 1


def judge(
    sums: Sums,
    name: str,
    base: bytes,
    ours: bytes,
    theirs: bytes,
    folder: Path,
    expected: bytes | None = None,
) -> None:
    vendor = recognise(decode(base, name)) or recognise(decode(ours, name))
    if vendor is None:
        sums.refused += 1
        return
    sums.merges += 1
    conflicts = by_git(folder, base, ours, theirs)
    sums.git += conflicts > 0
    sums.git_hunks += conflicts
    begin = time.perf_counter()
    try:
        merged = merge_bytes(vendor.name, base, ours, theirs)
    except OlpError as problem:
        sums.refused += 1
        sums.merges -= 1
        sums.git -= conflicts > 0
        sums.git_hunks -= conflicts
        sums.examples.append(f"{name}: refused: {problem.diagnostics[0].message}")
        return
    sums.seconds += time.perf_counter() - begin
    sums.ours += bool(merged.hunks)
    sums.hunks += len(merged.hunks)
    data = merged.to_bytes()
    text = [one.decode("latin-1") for one in (base, ours, theirs, data)]
    if merged.hunks:
        found = lost(vendor.name, text[1], text[2], text[0], text[3])
        if expected is not None:
            found.append("a conflict where there is none")
    elif expected is not None:
        found = [] if data == expected else ["not what must come out"]
    else:
        found = wrong(vendor.name, *text)
    swapped = merge_bytes(vendor.name, base, theirs, ours)
    if not merged.hunks and swapped.to_bytes() != data:
        found.append("another text with the sides swapped")
    if found:
        sums.bad += 1
        sums.examples.append(
            f"{name}: {found[0]}" + (f" (and {len(found) - 1} more)" if len(found) > 1 else "")
        )
        keep = folder.parent / f"bad-{len(sums.examples)}"
        if folder.name == "kept":
            keep.mkdir(exist_ok=True)
            for label, one in zip(
                ("base", "ours", "theirs", "merged"), (base, ours, theirs, data), strict=True
            ):
                (keep / label).write_bytes(one)


def table(rows: dict[str, Sums]) -> None:
    print(
        f"{'language':10} {'merges':>6} {'with conflicts':>14} {'git':>5} {'fewer':>6}"
        f" {'hunks':>6} {'git':>6} {'wrong':>6} {'ms each':>8}"
    )
    total = Sums()
    for name, one in [*rows.items(), ("all", total)]:
        if one is not total:
            for key in ("merges", "ours", "git", "hunks", "git_hunks", "bad", "refused", "seconds"):
                setattr(total, key, getattr(total, key) + getattr(one, key))
        fewer = f"{100 * (1 - one.ours / one.git):.0f} %" if one.git else "-"
        each = 1e3 * one.seconds / one.merges if one.merges else 0.0
        print(
            f"{name:10} {one.merges:6} {one.ours:14} {one.git:5} {fewer:>6} {one.hunks:6} {one.git_hunks:6}"
            f" {one.bad:6} {each:8.1f}"
        )
    for one in rows.values():
        for example in one.examples[:10]:
            print("  ", example)
    if total.refused:
        print(f"{total.refused} refused: no text of a language, or conflict markers in it")


# --- Real histories ---


def histories(folder: Path) -> Iterator[tuple[str, str, list[bytes]]]:
    """(repository, path, versions from the first on) of each program that has two versions or more."""
    repositories = sorted(
        {path.parent for path in folder.rglob("HEAD") if (path.parent / "objects").is_dir()}
    )
    for repository in repositories:

        def git(*words: str, where: Path = repository) -> bytes:
            return subprocess.run(
                ["git", f"--git-dir={where}", *words], capture_output=True, check=False
            ).stdout

        blobs: dict[str, list[str]] = defaultdict(list)
        log = git(
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
        for path, versions in blobs.items():
            if len(versions) >= 2:
                yield repository.parent.name, path, [git("cat-file", "blob", one) for one in versions]


def touched_up(text: bytes, other: bytes, choose: random.Random) -> bytes | None:
    """The text with up to three positions moved, as at the robot, that `other` has as they were; None without any."""
    found = [
        m
        for pattern in (
            rb"(?m)^C\d+=([-\d.]+)", rb"\bX\s*=\s*([-\d.]+)", rb"\{\s*X\s+([-\d.]+)", rb"\bx=\"([-\d.]+)\"",
            rb":=\s*\[\s*\[\s*([-\d.]+)", rb"=\s*p?\[\s*([-\d.]+)", rb"POS\(\s*([-\d.]+)",
        )
        for m in re.finditer(pattern, text)
        if text[m.start(1) : m.start(1) + 40].splitlines()[0] in other
    ]  # fmt: skip
    if not found:
        return None
    pieces, last = [], 0
    for match in sorted(choose.sample(found, min(3, len(found))), key=lambda m: m.start(1)):
        if match.start(1) < last:
            continue
        number = match[1].decode()
        decimals = len(number.partition(".")[2])
        new = f"{float(number) + choose.choice((1, -1, 2)) * 10.0 ** -min(decimals, 1) * 3:.{decimals}f}"
        pieces += [text[last : match.start(1)], new.encode()]
        last = match.end(1)
    return b"".join([*pieces, text[last:]])


def real(folder: Path, most: int) -> None:
    choose = random.Random(1)
    kinds: dict[str, dict[str, Sums]] = {
        "two changes that happened": {},
        "a change that happened, points touched up": {},
    }
    places: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as made:
        kept = Path(made) / "kept"
        kept.mkdir()
        for repository, path, versions in histories(folder):
            for at in range(len(versions) - 1):
                if places[repository] >= most:
                    break
                places[repository] += 1
                first, second = versions[at], versions[at + 1]
                name = f"{repository}/{path}#{at}"
                suffix = Path(path).suffix.lower()
                if at + 2 < len(versions):
                    sums = kinds["two changes that happened"].setdefault(suffix, Sums())
                    judge(sums, name, second, first, versions[at + 2], kept)
                touched = touched_up(first, second, choose)
                if touched is not None:
                    sums = kinds["a change that happened, points touched up"].setdefault(suffix, Sums())
                    judge(sums, name, first, touched, second, kept)
        for kind, rows in kinds.items():
            print(f"\n{kind}")
            table(dict(sorted(rows.items())))


# --- Made programs ---


@dataclass(frozen=True)
class Step:
    """A move to a position, or a line of logic. `name`: of the position, for life."""

    name: str
    values: tuple[float, ...] = ()
    speed: int = 100
    comment: str = ""
    word: str = ""


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
    """Logic changed: speeds, new steps, steps that go, signals. The positions that stay are as they were."""
    steps = list(made.steps)
    gone: set[str] = set()
    for number in range(choose.randint(1, 5)):
        at = choose.randrange(len(steps))
        kind = choose.choice(("speed", "new", "gone", "signal", "comment"))
        if kind == "speed" and steps[at].values:
            steps[at] = replace(steps[at], speed=steps[at].speed + 20)
        elif kind == "new":
            steps.insert(at, _step(choose, f"q{number + 1}"))
        elif kind == "gone" and len(steps) > 3 and steps[at].values:
            gone.add(steps.pop(at).name)
        elif kind == "signal":
            steps.insert(at, Step("", word=f"signal {choose.randint(1, 9)}{number}"))
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
            body.append(f"MOVL C{n:05d} V={step.speed:.1f}" + (f"  //{step.comment}" if step.comment else ""))
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
            body.append(f"L P[{numbers[step.name]}{label}] {step.speed}mm/sec FINE    ;")
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
            text.append(f"LIN X{s.name}")
        else:
            text.append(f"$OUT[{s.word.split()[1]}]=TRUE")
    return "\r\n".join([*text, "END", ""])


def _as_rapid(made: Made) -> str:
    text = ["MODULE Made"]
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
            f"    MoveL {s.name},v{s.speed},fine,tool0;{note}"
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
            f"  movel({s.name}, v={s.speed / 1000:.3f}){note}"
            if s.values
            else f"  set_standard_digital_out({s.word.split()[1]}, True)"
        )
    return "\n".join([*text, "end", ""])


def _as_as(made: Made) -> str:
    text = [".PROGRAM made() #0"]
    for s in made.steps:
        note = f" ; {s.comment}" if s.comment else ""
        text += (
            [f"  SPEED {s.speed} MM/S{note}", f"  LMOVE {s.name}"]
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
            [f"  $LIN_SPD := {s.speed / 1000:.3f}{note}", f"  MOVE LINEAR TO {s.name}"]
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


def made_ones(count: int, seed: int) -> None:
    rows: dict[str, Sums] = {}
    with tempfile.TemporaryDirectory() as folder:
        for language in vendor_names():
            sums = rows.setdefault(language, Sums())
            suffix = {"val3": ".dtx", "inform": ".jbi", "tp": ".ls", "krl": ".src", "rapid": ".mod"}.get(
                language, f".{language}"
            )
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
                judge(sums, f"made{suffix}", *texts[:3], Path(folder), texts[3])
    table(rows)


def speed() -> None:
    choose = random.Random(1)
    base = Made(tuple(_step(choose, f"p{n + 1}") for n in range(5000)))
    robot, _ = night(base, choose)
    changed, _ = office(base, choose)
    for language in ("inform", "tp", "krl", "rapid"):
        _HIGHEST[0] = len(base.steps)
        texts = [spell(language, one).encode() for one in (base, robot, changed)]
        begin = time.process_time()
        merged = merge_bytes(language, *texts)
        seconds = time.process_time() - begin
        print(
            f"{language:10} {len(texts[0].splitlines()):6} lines {seconds:6.3f} s of CPU, {len(merged.hunks)} conflicts"
        )


def main(words: list[str]) -> None:
    if words[:1] == ["made"]:
        made_ones(int(words[1]) if len(words) > 1 else 125, int(words[2]) if len(words) > 2 else 1)
    elif words[:1] == ["real"] and len(words) > 1:
        real(Path(words[1]), int(words[2]) if len(words) > 2 else 10**9)
    elif words == ["speed"]:
        speed()
    else:
        print(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
