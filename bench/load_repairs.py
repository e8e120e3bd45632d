"""What `olp lint --load` says of real histories: of errors that a later commit repaired, and of versions that stayed.

    python bench/load_repairs.py FOLDER [--half development|held-out] [--show]

FOLDER is or holds git repositories of robot programs (bare ones too); programs are never run. Each repository's
versions are put into a scratch folder one after the other, without merges, and every program that a commit changes
is checked before and after, with the files of its version beside it.

`repaired`: findings that a commit ended by changing their line, while the program stayed; `declared`: by what it
changed elsewhere. `broken`: findings on lines that a commit wrote. `kept`: programs as the last commit leaves them;
files that are refused as a whole are no programs. `told`: those with a finding, `right`: those whose findings
`load_kept.tsv` all calls right, as a person read them (templates with gaps, fixtures of parsers, errors that stayed);
all others count as false. `listed`: the errors of `load_repairs.tsv` (repository, commit that repairs it, file, a word
of the line), read from the differences; `seen`: olp has a finding on such a line of the version before, and none like
it behind the commit. Of shallow copies, where files are absent, those that are there are used.

The halves: repositories by the number of changed programs, the first, fourth, fifth, eighth … are for development.
"""

from __future__ import annotations

import argparse
import io
import os
import shutil
import subprocess
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from olp.checks.lint.run import lint_load
from olp.core.diagnostic import OlpError
from olp.core.source import load
from olp.languages.vendor import find_vendor, recognise, vendor_names, vendor_suffixes
from olp.reports.batch import Job

LISTS = {suffix for name in vendor_names() for suffix in find_vendor(name).list_suffixes}
SUFFIXES = tuple({*vendor_suffixes(), *LISTS, ".dtx", ".pjx"})
LISTED = Path(__file__).with_suffix(".tsv")
JUDGED = Path(__file__).with_name("load_kept.tsv")


class Told(NamedTuple):
    code: str
    message: str
    line: int
    text: str


class Repair(NamedTuple):
    """An error that a person read from a difference. `word`: stands in its line, as it was before the commit."""

    repository: str
    commit: str
    path: str
    word: str


class Verdict(NamedTuple):
    """What a person says of a kept program's findings with this code. `path`: of a program, or how several begin."""

    repository: str
    path: str
    code: str
    right: str  # right or false
    why: str


@dataclass(slots=True)
class Kept:
    """Programs of one language."""

    programs: int = 0
    told: int = 0
    right: int = 0


@dataclass(slots=True)
class Sums:
    """Of one repository. `kept`: by language."""

    changes: int = 0
    broken: int = 0
    declared: int = 0
    repaired: Counter[str] = field(default_factory=Counter)
    kept: dict[str, Kept] = field(default_factory=lambda: defaultdict(Kept))
    listed: int = 0
    seen: int = 0

    def add(self, other: Sums) -> None:
        self.changes += other.changes
        self.broken += other.broken
        self.declared += other.declared
        self.listed += other.listed
        self.seen += other.seen
        self.repaired += other.repaired
        for language, own in other.kept.items():
            into = self.kept[language]
            into.programs += own.programs
            into.told += own.told
            into.right += own.right


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, metavar="FOLDER")
    parser.add_argument("--half", default="all", choices=("all", "development", "held-out"))
    parser.add_argument("--only", default="", metavar="WORD", help="repositories whose name has this in it")
    parser.add_argument("--show", action="store_true", help="each finding")
    parser.add_argument("--listed", action="store_true", help="only commits of load_repairs.tsv")
    parser.add_argument("--kept", action="store_true", help="only the programs that stayed")
    parser.add_argument("--history", action="store_true", help="only the commits")
    chosen = parser.parse_args()
    total = Sums()
    heads = ("changes", "broken", "repaired", "declared", "listed", "seen", "kept", "told", "right")
    print("".join(f"{head:>9}" for head in heads))
    for name, place in repositories(chosen.folder, chosen.half):
        if chosen.only not in name:
            continue
        sums = of_repository(name, place, chosen)
        _row(name, sums)
        total.add(sums)
    _row(f"all; repaired: {dict(total.repaired.most_common())}", total)
    print(f"\n{'language':10} {'kept':>6} {'told':>6} {'right':>6} {'false':>6} {'share':>7}")
    for language, kept in sorted(total.kept.items()):
        false = kept.told - kept.right
        print(
            f"{language:10} {kept.programs:6} {kept.told:6} {kept.right:6} {false:6} {false / kept.programs:7.1%}"
        )


def _row(name: str, sums: Sums) -> None:
    kept, told, right = (
        sum(getattr(one, what) for one in sums.kept.values()) for what in ("programs", "told", "right")
    )
    repaired = sum(sums.repaired.values())
    row = (sums.changes, sums.broken, repaired, sums.declared, sums.listed, sums.seen, kept, told, right)
    print("".join(f"{count:9}" for count in row) + f"  {name}", flush=True)


def repositories(folder: Path, half: str) -> list[tuple[str, Path]]:
    """Name and git directory of those that have programs."""
    found = []
    for place in sorted({path.parent for path in folder.rglob("HEAD") if (path.parent / "objects").is_dir()}):
        parts = (*folder.resolve().parts, *place.relative_to(folder).parts)
        name = next(one for one in reversed(parts) if one not in (".git", "repo"))
        changes = sum(len(paths) for _, paths in commits(place))
        if changes or programs_at(place, last(place)):
            found.append((-changes, name, place))
    return [
        (name, place)
        for rank, (_, name, place) in enumerate(sorted(found))
        if half in ("all", "development" if rank % 4 in (0, 3) else "held-out")
    ]


def git(place: Path, *words: str, stdin: bytes = b"") -> bytes:
    return subprocess.run(
        ["git", f"--git-dir={place}", *words],
        input=stdin,
        capture_output=True,
        check=False,
        env={**os.environ, "GIT_NO_LAZY_FETCH": "1"},
    ).stdout


def commits(place: Path) -> Iterator[tuple[str, list[str]]]:
    """Each commit but the first that adds or changes files, and the programs that it changes."""
    words = ("log", "--reverse", "--no-merges", "--no-renames", "--diff-filter=AM", "--name-status", "-z")
    log = git(place, *words, "--format=%x01%H", "--all").decode("utf-8", "surrogateescape")
    for piece in log.split("\1")[1:]:
        commit, *words_of = (word.strip("\n") for word in piece.split("\0"))
        words_of = [word for word in words_of if word]
        rows = zip(words_of[::2], words_of[1::2], strict=False)
        yield commit, [path for status, path in rows if status == "M" and path.lower().endswith(SUFFIXES)]


def last(place: Path) -> str:
    """HEAD, or the newest commit of all branches where HEAD has no program."""
    return "HEAD" if programs_at(place, "HEAD") else git(place, "rev-list", "--all", "-1").decode().strip()


def programs_at(place: Path, commit: str) -> list[str]:
    names = git(place, "ls-tree", "-r", "-z", "--name-only", commit).decode("utf-8", "surrogateescape")
    return [name for name in names.split("\0") if name.lower().endswith(SUFFIXES)]


def of_repository(name: str, place: Path, chosen: argparse.Namespace) -> Sums:
    """Walks one history."""
    sums, show = Sums(), chosen.show
    listed = defaultdict(list)
    for repair in _listed():
        if repair.repository == name:
            listed[repair.commit].append(repair)
    told_of: dict[str, list[Told]] = {}
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for commit, paths in () if chosen.kept else commits(place):
            repairs = next((rows for short, rows in listed.items() if commit.startswith(short)), [])
            if not (repairs or (paths and not chosen.listed)):
                continue
            sums.changes += len(paths)
            old, new = (_put(place, one, folder) for one in (f"{commit}~1", commit))
            judged = {
                *paths,
                *(repair.path for repair in repairs),
                *(path for path in told_of if told_of[path]),
            }
            before, after = ({path: told(version / path) for path in judged} for version in (old, new))
            told_of |= after
            for path in sorted(judged):
                broken, repaired, declared = _difference(
                    before[path], _lines(old / path), after[path], _lines(new / path)
                )
                if not (new / path).is_file():
                    continue
                sums.broken += len(broken)
                sums.repaired += Counter(one.code for one in repaired)
                sums.declared += len(declared)
                for kind, found in zip(
                    ("broken", "repaired", "declared"), (broken, repaired, declared), strict=True
                ):
                    for one in found if show else ():
                        print(
                            f"  {kind} {commit[:7]} {path}:{one.line} {one.code} {one.message} | {one.text.strip()}"
                        )
            for repair in repairs:
                sums.listed += 1
                seen = _seen(before[repair.path], after[repair.path], repair.word)
                sums.seen += seen
                if show:
                    print(f"  {'seen' if seen else 'MISSED'} {repair.commit} {repair.path} {repair.word}")
            shutil.rmtree(old)
            shutil.rmtree(new)
        head = _put(place, last(place), folder)
        for path in () if chosen.history else programs_at(place, last(place)):
            language = _language(head / path)
            if not language:
                continue
            found = told(head / path)
            if any(not one.line for one in found):
                continue  # refused as a whole: a log, a template, an empty file
            kept = sums.kept[language]
            kept.programs += 1
            kept.told += bool(found)
            verdicts = [_verdict(name, path, one.code) for one in found]
            kept.right += bool(found) and all(one == "right" for one in verdicts)
            for one, verdict in zip(found, verdicts, strict=True) if show else ():
                print(
                    f"  kept {path}:{one.line} {one.code} {verdict}: {one.message} | {one.text.strip()[:100]}"
                )
    return sums


def _difference(
    before: list[Told], old: list[str], after: list[Told], new: list[str]
) -> tuple[list[Told], list[Told], list[Told]]:
    """What a commit broke, what it repaired in its lines, and what elsewhere: findings of one version alone."""
    told_before, told_after = ({(one.code, one.message) for one in found} for found in (before, after))
    lines_before, lines_after = set(old), set(new)
    gone = [b for b in before if (b.code, b.message) not in told_after]
    return (
        [a for a in after if a.text not in lines_before and (a.code, a.message) not in told_before],
        [b for b in gone if b.text not in lines_after],
        [b for b in gone if b.text in lines_after],
    )


def _seen(before: list[Told], after: list[Told], word: str) -> bool:
    """Whether a line with this word has a finding that is gone behind the commit."""
    gone = {(one.code, one.message, one.text) for one in before} - {
        (one.code, one.message, one.text) for one in after
    }
    return any(word in text for _, _, text in gone)


def _rows(path: Path) -> list[list[str]]:
    rows = path.read_text(encoding="utf-8").splitlines()
    return [row.split("\t") for row in rows if row and not row.startswith("#")]


def _listed() -> list[Repair]:
    return [Repair(*row) for row in _rows(LISTED)]


@lru_cache(maxsize=1)
def _judged() -> list[Verdict]:
    return [Verdict(*row) for row in _rows(JUDGED)]


def _verdict(repository: str, path: str, code: str) -> str:
    """right, false, or unread."""
    for one in _judged():
        if one.repository == repository and path.startswith(one.path) and one.code in (code, "*"):
            return one.right
    return "unread"


def _put(place: Path, commit: str, folder: Path) -> Path:
    """The programs of a version, in a new folder of `folder`: olp remembers folders by their paths."""
    made = Path(tempfile.mkdtemp(dir=folder))
    names = [name for name in programs_at(place, commit) if "\n" not in name]
    wanted = "".join(f"{commit}:{name}\n" for name in names).encode("utf-8", "surrogateescape")
    packed = io.BytesIO(git(place, "cat-file", "--batch", stdin=wanted))
    for name in names:
        head = packed.readline().split()
        if len(head) != 3 or not head[2].isdigit():
            continue  # absent
        content = packed.read(int(head[2]))
        packed.readline()
        target = made / name
        if target.resolve().is_relative_to(made.resolve()) and head[1] == b"blob":
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
    return made


def _language(path: Path) -> str:
    """The name of a program's language; empty of what is none."""
    if not path.is_file():
        return ""
    try:
        vendor = recognise(load(path))
    except OlpError:
        return ""
    return vendor.name if vendor else ""


def _lines(path: Path) -> list[str]:
    if not path.is_file():
        return []
    try:
        return list(load(path).lines)
    except OlpError:
        return []


def told(path: Path) -> list[Told]:
    """What olp says of one program; nothing of what is none."""
    if not _language(path):
        return []
    lines = _lines(path)
    return [
        Told(f.code, f.message, f.line, lines[f.line - 1] if 0 < f.line <= len(lines) else "")
        for f in lint_load(str(path), Job(), "").findings
    ]


if __name__ == "__main__":
    main()
