"""What `olp lint --load` says of real histories: of errors that a later commit repaired, and of versions that stayed.

    python bench/load_repairs.py FOLDER [--half development|held-out] [--show]

FOLDER holds git repositories of robot programs (bare ones too); programs are never run. Each repository's versions are
put into a scratch folder one after the other, without merges, and every program that a
commit changes is checked before and after, with the files of its version beside it.

`repaired`: findings that a commit ended by changing their line, while the program stayed. `kept`: programs as the last
commit leaves them; files that are refused as a whole are no programs. `told`: those with a finding, `right`: those
whose findings `load_kept.tsv` all calls right, as a person read them (templates with gaps, fixtures of parsers, errors
that stayed); all others count as false. `listed`: the errors of `load_repairs.tsv` (repository, commit that repairs it,
file, a word of the line), read from the differences; `seen`: olp has a finding on such a line of the version before.

The halves: repositories by the number of changed programs, the first, fourth, fifth, eighth … are for development.
"""

from __future__ import annotations

import argparse
import io
import shutil
import subprocess
import tarfile
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
    repaired: Counter[str] = field(default_factory=Counter)
    kept: dict[str, Kept] = field(default_factory=lambda: defaultdict(Kept))
    listed: int = 0
    seen: int = 0

    def add(self, other: Sums) -> None:
        self.changes += other.changes
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
    chosen = parser.parse_args()
    total = Sums()
    print(f"{'changes':>8} {'repaired':>9} {'listed':>7} {'seen':>5} {'kept':>6} {'told':>6} {'right':>6}")
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
    print(
        f"{sums.changes:8} {sum(sums.repaired.values()):9} {sums.listed:7} {sums.seen:5} {kept:6} {told:6} {right:6}"
        f"  {name}",
        flush=True,
    )


def repositories(folder: Path, half: str) -> list[tuple[str, Path]]:
    """Name and git directory of those that have programs."""
    found = []
    for place in sorted({path.parent for path in folder.rglob("HEAD") if (path.parent / "objects").is_dir()}):
        name = next(one for one in reversed(place.relative_to(folder).parts) if one not in (".git", "repo"))
        changes = sum(len(paths) for _, paths in commits(place))
        if changes or programs_at(place, last(place)):
            found.append((-changes, name, place))
    return [
        (name, place)
        for rank, (_, name, place) in enumerate(sorted(found))
        if half in ("all", "development" if rank % 4 in (0, 3) else "held-out")
    ]


def git(place: Path, *words: str) -> bytes:
    return subprocess.run(["git", f"--git-dir={place}", *words], capture_output=True, check=False).stdout


def commits(place: Path) -> Iterator[tuple[str, list[str]]]:
    """Each commit but the first, and the programs that it changes."""
    words = ("log", "--reverse", "--no-merges", "--no-renames", "--diff-filter=M", "--name-only", "-z")
    log = git(place, *words, "--format=%x01%H", "--all").decode("utf-8", "surrogateescape")
    for piece in log.split("\1")[1:]:
        commit, *paths = (word.strip("\n") for word in piece.split("\0"))
        yield commit, [path for path in paths if path.lower().endswith(SUFFIXES)]


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
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for commit, paths in () if chosen.kept else commits(place):
            repairs = next((rows for short, rows in listed.items() if commit.startswith(short)), [])
            if not paths or (chosen.listed and not repairs):
                continue
            sums.changes += len(paths)
            old, new = (_put(place, one, folder) for one in (f"{commit}~1", commit))
            before = {path: told(old / path) for path in paths}
            for path in paths:
                after = told(new / path)
                lines = set(_lines(new / path))
                for one in before[path]:
                    if one.text in lines or any(
                        (one.code, one.message) == (a.code, a.message) for a in after
                    ):
                        continue
                    sums.repaired[one.code] += 1
                    if show:
                        print(
                            f"  repaired {commit[:7]} {path}:{one.line} {one.code} {one.message} | {one.text.strip()}"
                        )
            for repair in repairs:
                sums.listed += 1
                rows = [one for one in before.get(repair.path, ()) if repair.word in one.text]
                sums.seen += bool(rows)
                if show:
                    print(f"  {'seen' if rows else 'MISSED'} {repair.commit} {repair.path} {repair.word}")
            shutil.rmtree(old)
            shutil.rmtree(new)
        head = _put(place, last(place), folder)
        for path in programs_at(place, last(place)):
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
    names = programs_at(place, commit)
    packed = git(place, "--literal-pathspecs", "archive", commit, "--", *names) if names else b""
    if not packed:
        return made
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        archive.extractall(made, [one for one in archive if one.isfile()], filter="data")
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
