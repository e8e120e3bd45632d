"""Results of earlier runs, kept as long as nothing changed that they depend on.

A result is found again by the content of every file that was read for it, by the settings, the budgets and olp itself.
Dates and places play no part: a fresh checkout elsewhere finds what another machine stored.

Codes: M006 a file that is no cache.
"""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from hashlib import sha256
from pathlib import Path

from olp.checks.guard.budget import Budget
from olp.checks.guard.judge import Judged
from olp.core.diagnostic import OlpError, error
from olp.reports.batch import Job
from olp.reports.outcome.model import Finding, Item, Level, Status

_MARK = 0x6F6C7063  # SQLite's application_id: "olpc"
_SCHEMA = "create table if not exists result (path text primary key, key text not null, value text not null)"
# Files beside a program that its times depend on.
_CONTROLLER = (".cnd", ".dat", ".prm", ".sys", ".va", ".toml")
_UNRESOLVED = frozenset({"I102", "I203", "I209"})  # another file of the folder may answer these
_PATIENCE_S = 5.0  # for another olp that writes


@dataclass(slots=True)
class Cache:
    """The cache in the file `path`; one that cannot be opened or written is not used."""

    path: Path
    settings: str = ""
    _known: dict[str, tuple[str, str]] = field(default_factory=dict)
    _files: dict[str, str] = field(default_factory=dict)
    _folders: dict[tuple[str, bool], str] = field(default_factory=dict)

    @classmethod
    def open(cls, path: Path, job: Job) -> Cache:
        """The cache for runs with the settings `job`. Raises OlpError (M006) for a file that is something else."""
        found = cls(path, _settings(job))
        if not path.is_file() or not path.stat().st_size:
            return found
        try:
            with closing(sqlite3.connect(path, timeout=_PATIENCE_S)) as store:
                if store.execute("pragma application_id").fetchone()[0] != _MARK:
                    raise _refused(path)
                rows = store.execute("select path, key, value from result")
                found._known = {name: (key, value) for name, key, value in rows}
        except sqlite3.OperationalError:
            return found
        except sqlite3.DatabaseError:
            raise _refused(path) from None
        return found

    def find(self, path: str, budgets: Sequence[Budget]) -> Judged | None:
        """The result of `path` if everything is as it was."""
        known = self._known.get(self._name(path))
        if known is None:
            return None
        try:
            judged = _judged(json.loads(known[1]))
        except (ValueError, KeyError, TypeError, AssertionError):
            return None
        return judged if judged.path == path and known[0] == self._key(judged, budgets) else None

    def keep(self, results: Iterable[tuple[Judged, Sequence[Budget]]]) -> None:
        """Stores results."""
        rows = [
            (self._name(judged.path), self._key(judged, budgets), json.dumps(asdict(judged)))
            for judged, budgets in results
        ]
        try:
            with closing(sqlite3.connect(self.path, timeout=_PATIENCE_S)) as store:
                store.execute(f"pragma application_id = {_MARK}")
                store.execute(_SCHEMA)
                store.executemany("insert or replace into result values (?, ?, ?)", rows)
                store.commit()
        except sqlite3.Error:
            return

    def _name(self, path: str) -> str:
        """The program as seen from the cache, so that a checkout elsewhere has the same name for it."""
        try:
            return os.path.relpath(path, self.path.parent)
        except ValueError:  # another drive of Windows
            return os.path.abspath(path)

    def _key(self, judged: Judged, budgets: Sequence[Budget]) -> str:
        calls = len(judged.read) > 1 or any(finding.code in _UNRESOLVED for finding in judged.findings)
        folders = dict.fromkeys(os.path.dirname(os.path.abspath(file)) for file in judged.read)
        parts = [
            self.settings,
            *sorted(repr(replace(b, home="", line=0, signature="")) for b in budgets),
            *(self._file(file) for file in judged.read),
            *(self._folder(folder, calls) for folder in folders),
            *(self._file(b.signature) for b in budgets if b.signature),
        ]
        return _digest(parts)

    def _file(self, path: str) -> str:
        found = self._files.get(path)
        if found is None:
            found = self._files[path] = _content(path)
        return found

    def _folder(self, folder: str, names: bool) -> str:
        """What stands beside a program: controller files by content; others by name where it calls any of them."""
        found = self._folders.get((folder, names))
        if found is None:
            try:
                listed = sorted(entry.path for entry in os.scandir(folder) if entry.is_file())
            except OSError:
                listed = []
            parts = [self._file(path) for path in listed if path.lower().endswith(_CONTROLLER)]
            parts += [
                os.path.basename(path) for path in listed if names and not path.endswith(self.path.name)
            ]
            parts += [self._file(path) for path in _settings_files(folder)]
            found = self._folders[folder, names] = _digest(parts)
        return found


def _settings_files(folder: str) -> list[str]:
    """The olp.toml that holds for a folder, and the robot files that it names."""
    from olp.runtime.assumptions import load_assumptions, nearest_assumptions

    above = nearest_assumptions(folder)
    if above is None:
        return []
    given = load_assumptions(above)
    robots = [name for name in (given.robot, *given.robots.values()) if name.lower().endswith(".toml")]
    return [str(above), *(str(above.parent / name) for name in robots)]


def _settings(job: Job) -> str:
    """The settings that times depend on, with the content of the files they name, and olp itself."""
    names = (job.robot, job.assumptions, job.signature)
    contents = [_content(name) for name in names if name is not None and os.path.isfile(name)]
    return repr((_olp(), job, contents))


@cache
def _olp() -> str:
    """What olp is made of: its version says too little while somebody works on it."""
    import olp

    root = Path(olp.__file__).parent
    files = [path for kind in ("*.py", "*.toml", "*.lark") for path in sorted(root.rglob(kind))]
    return _digest([olp.__version__, *(_content(str(path)) for path in files)])


def _content(path: str) -> str:
    try:
        return sha256(Path(path).read_bytes()).hexdigest()
    except OSError:
        return "missing"


def _digest(parts: Iterable[str]) -> str:
    return sha256("\0".join(parts).encode("utf-8", "surrogatepass")).hexdigest()


def _refused(path: Path) -> OlpError:
    return OlpError(
        error(
            "M006", "this file is no cache of olp check", file=str(path), help="name another one with --cache"
        )
    )


def _judged(value: dict[str, object]) -> Judged:
    """The result from its JSON."""
    items = value.pop("items")
    findings = value.pop("findings")
    assert isinstance(items, list)
    assert isinstance(findings, list)
    return Judged(
        items=tuple(Item(**{**item, "status": Status(item["status"])}) for item in items),
        findings=tuple(_finding(finding) for finding in findings),
        **{**value, "read": tuple(value["read"])},  # type: ignore[arg-type]
    )


def _finding(value: dict[str, object]) -> Finding:
    fixes = value["fixes"]
    assert isinstance(fixes, list)
    whole = {**value, "level": Level(str(value["level"])), "fixes": tuple(tuple(fix) for fix in fixes)}
    return Finding(**whole)  # type: ignore[arg-type]
