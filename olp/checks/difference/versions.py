"""Sources of the two versions: two files, two folders, or two states of a git repository.

Codes: U001 no such file, folder or revision; U002 git failed (olp/core/git.py); U003 nothing to compare.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Collection, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from olp.checks.difference.compare import ProgramDifference, compare
from olp.checks.guard.budget import budgets_for
from olp.checks.guard.run import judge
from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.git import asked_of_git, files_of, git, lay_out
from olp.identification.timing_job import TimingJob
from olp.ir.program import Program
from olp.reports.outcome.model import JudgedItem, Status
from olp.timing.result import Timing

_WORKING_COPY = "."


class VersionPair(NamedTuple):
    """One program in both versions; None where it is missing."""

    name: str
    old: Path | None
    new: Path | None


@dataclass(frozen=True, slots=True)
class Versions:
    """The programs to compare. `folders`: location of each version's called routines and settings."""

    pairs: tuple[VersionPair, ...]
    folders: tuple[Path | None, Path | None] = (None, None)

    def compare(self, pair: VersionPair, job: TimingJob) -> ProgramDifference:
        """The difference of one program, with the budgets' verdicts on both versions."""
        old, new = (_timed(path, job, folder) for path, folder in zip(pair[1:], self.folders, strict=True))
        why = "; ".join(t for t in (old, new) if isinstance(t, str))
        if why or old is None or new is None or isinstance(old, str) or isinstance(new, str):
            before, after = (t[0].total_s if isinstance(t, tuple) else None for t in (old, new))
            return ProgramDifference(pair.name, before, after, why=why)
        found = compare(pair.name, old[0], new[0], (old[1], new[1]))
        return replace(found, budgets=_budgets(pair, job))


def _timed(path: Path | None, job: TimingJob, folder: Path | None) -> tuple[Timing, Program] | str | None:
    """The timing of one version; None if it is missing, the reason if it cannot be read."""
    from olp.identification.timing_job import time_program
    from olp.languages.vendor import read

    if path is None:
        return None
    try:
        program = read(path, encoding=job.encoding)
        return time_program(program, job, folder), program
    except OlpError as problem:
        return problem.diagnostics[0].message


def _budgets(pair: VersionPair, job: TimingJob) -> tuple[JudgedItem, ...]:
    """Verdicts of the new version's budgets."""
    if pair.new is None:
        return ()
    own = tuple(b for known in budgets_for(str(pair.new)) for b in known.budgets if b.covers(str(pair.new)))
    if not own:
        return ()
    items = judge(str(pair.new), own, job).items
    return tuple(replace(item, file=pair.name) for item in items if item.status is not Status.HELD)


@contextmanager
def open_versions(old: str, new: str, paths: Sequence[str] = ()) -> Generator[Versions]:
    """The versions that two arguments name; revisions are checked out into a temporary folder.

    Raises OlpError (U001, U002, U003).
    """
    a, b = Path(old), Path(new)
    with tempfile.TemporaryDirectory(prefix="olp-diff-") as folder:
        if a.exists() and b.exists() and not (_is_revision(old) and not a.is_file() and old != _WORKING_COPY):
            yield _of_paths(a, b)
            return
        unknown = [w for w in (old, new) if not (Path(w).exists() or w == _WORKING_COPY or _is_revision(w))]
        if unknown:
            raise OlpError(*map(_no_version, unknown))
        first = _laid_out(old, Path(folder) / "old", paths)
        second = Path.cwd() if new == _WORKING_COPY else _laid_out(new, Path(folder) / "new", paths)
        yield _of_folders(first, second, paths)


def _of_paths(a: Path, b: Path) -> Versions:
    if a.is_dir() != b.is_dir():
        raise OlpError(
            error("U003", "a file and a folder cannot be compared", file=str(b), help="name two of a kind")
        )
    if a.is_dir():
        return _of_folders(a, b, ())
    # git difftool hands over copies in a temporary folder, and says in BASE whose they are.
    original = next((os.environ[word] for word in ("MERGED", "BASE") if os.environ.get(word)), "")
    home = Path(original).parent if original and Path(original).name in (a.name, b.name) else None
    name = original if home is not None else str(b if b.is_file() else a)
    # A version that is not there is the null device to git.
    old, new = (path if path.is_file() else None for path in (a, b))
    return Versions((VersionPair(name, old, new),), (_home(a, home), _home(b, home)))


def _home(path: Path, home: Path | None) -> Path | None:
    """Folder of the routines that a temporary copy calls: that of the original; None if `path` is no temporary copy."""
    temporary = path.resolve().is_relative_to(Path(tempfile.gettempdir()).resolve())
    return home if home is not None and temporary else None


def _of_folders(a: Path, b: Path, paths: Sequence[str]) -> Versions:
    from olp.languages.vendor import vendor_suffixes

    suffixes = vendor_suffixes()
    names = sorted(_programs(a, suffixes, paths) | _programs(b, suffixes, paths))
    if not names:
        raise OlpError(
            error("U003", "no program in either version", file=str(b), help=f"olp reads {' '.join(suffixes)}")
        )
    pairs = [VersionPair(name, _there(a / name), _there(b / name)) for name in names]
    return Versions(tuple(pair for pair in pairs if not _same(pair)) or tuple(pairs))


def _programs(root: Path, suffixes: tuple[str, ...], paths: Sequence[str]) -> set[str]:
    found = set()
    wanted = [PurePosixPath(path.replace("\\", "/")) for path in paths]
    for folder, inner, files in os.walk(root):
        inner[:] = [name for name in inner if not name.startswith(".")]
        for name in files:
            if name.lower().endswith(suffixes):
                relative = PurePosixPath(Path(folder, name).relative_to(root).as_posix())
                if not wanted or any(relative.is_relative_to(path) for path in wanted):
                    found.add(str(relative))
    return found


def _there(path: Path) -> Path | None:
    return path if path.is_file() else None


def _same(pair: VersionPair) -> bool:
    """Whether nothing can have changed: both files and the files beside them are identical."""
    if pair.old is None or pair.new is None or pair.old.read_bytes() != pair.new.read_bytes():
        return False
    return _around(pair.old.parent) == _around(pair.new.parent)


def _around(folder: Path) -> dict[str, bytes]:
    """Content of the small files beside a program: called routines, tools, settings."""
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file() and p.stat().st_size < 1_000_000}


def _is_revision(word: str) -> bool:
    return git("rev-parse", "--verify", "--quiet", f"{word}^{{commit}}") is not None


def _no_version(word: str) -> Diagnostic:
    says = f"{word[:60]!r} is not a file, a folder or a git revision"
    return error("U001", says, help="name two programs, two folders, or revisions such as HEAD~1 HEAD")


def _laid_out(revision: str, folder: Path, paths: Sequence[str]) -> Path:
    """Check out the files of a revision into `folder`; its copy of the current folder. Raises OlpError (U001, U002)."""
    if revision.startswith("-") or not _is_revision(revision):
        raise OlpError(_no_version(revision))
    folder.mkdir(parents=True)
    prefix = os.fsdecode(asked_of_git("rev-parse", "--show-prefix")).strip()
    # The whole repository, not the current folder: olp.toml may stand above.
    files = files_of(revision)
    wanted = _wanted(files, prefix, paths)
    if wanted is None or wanted:
        lay_out(files, wanted or (), folder)
    found = folder / prefix
    found.mkdir(parents=True, exist_ok=True)
    return found


def _wanted(
    files: Collection[PurePosixPath], prefix: str, paths: Sequence[str]
) -> list[PurePosixPath] | None:
    """The paths to check out, relative to git's root: None for everything.

    For a file its whole folder, which has the routines that it calls; in addition settings and robot files of all
    folders.
    """
    roots = [PurePosixPath(prefix, path.replace("\\", "/")) for path in paths]
    if not roots or PurePosixPath(".") in roots:
        return None
    folders = {root.parent if root in files else root for root in roots}
    if PurePosixPath(".") in folders:
        return None
    parents = {parent for name in files for parent in name.parents}
    return sorted(folders & parents) + [name for name in files if name.suffix == ".toml"]
