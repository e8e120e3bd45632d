"""Results of earlier runs, kept as long as nothing changed that they depend on.

A result is found again by the content of every file that was read for it, by the settings, the budgets and the version
of olp. Dates play no part: a fresh checkout finds what another machine stored.
"""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from pathlib import Path

from olp.batch import Job
from olp.guard.budget import Budget
from olp.guard.judge import Judged
from olp.outcome.model import Finding, Item, Level, Status

_SCHEMA = "create table if not exists result (path text primary key, key text not null, value text not null)"
_CONTROLLER = (
    ".cnd",
    ".dat",
    ".prm",
    ".sys",
    ".va",
    ".toml",
)  # files beside a program that its times depend on
_UNRESOLVED = frozenset({"I102", "I209", "I203"})  # another file of the folder may answer these


@dataclass(slots=True)
class Cache:
    """The cache in the file `path`. A file that is no cache is replaced; one that cannot be written is not used."""

    path: Path
    settings: str = ""
    _known: dict[str, tuple[str, Judged]] = field(default_factory=dict)
    _files: dict[str, str] = field(default_factory=dict)
    _folders: dict[tuple[str, bool], str] = field(default_factory=dict)

    @classmethod
    def open(cls, path: Path, job: Job) -> Cache:
        """The cache for runs with the settings `job`."""
        cache = cls(path, _settings(job))
        try:
            with closing(sqlite3.connect(path)) as store:
                store.execute(_SCHEMA)
                for file, key, value in store.execute("select path, key, value from result"):
                    cache._known[file] = key, _judged(json.loads(value))
        except (sqlite3.Error, ValueError, KeyError, TypeError):
            cache._known.clear()
            path.unlink(missing_ok=True)
        return cache

    def find(self, path: str, budgets: Sequence[Budget]) -> Judged | None:
        """The result of `path` if everything is as it was."""
        known = self._known.get(os.path.abspath(path))
        if known is None:
            return None
        key, judged = known
        return judged if key == self._key(judged, budgets) and judged.path == path else None

    def keep(self, results: Iterable[tuple[Judged, Sequence[Budget]]]) -> None:
        """Stores results."""
        rows = [
            (os.path.abspath(judged.path), self._key(judged, budgets), json.dumps(asdict(judged)))
            for judged, budgets in results
        ]
        try:
            with closing(sqlite3.connect(self.path)) as store:
                store.execute(_SCHEMA)
                store.executemany("insert or replace into result values (?, ?, ?)", rows)
                store.commit()
        except sqlite3.Error:
            return

    def _key(self, judged: Judged, budgets: Sequence[Budget]) -> str:
        open_names = any(finding.code in _UNRESOLVED for finding in judged.findings)
        folders = {os.path.dirname(os.path.abspath(file)) for file in judged.read}
        parts = [
            self.settings,
            repr(sorted(map(repr, budgets))),
            *(self._file(file) for file in judged.read),
            *(self._folder(folder, open_names) for folder in sorted(folders)),
            *(self._file(b.signature) for b in budgets if b.signature),
        ]
        return sha256("\0".join(parts).encode("utf-8", "surrogatepass")).hexdigest()

    def _file(self, path: str) -> str:
        found = self._files.get(path)
        if found is None:
            try:
                found = sha256(Path(path).read_bytes()).hexdigest()
            except OSError:
                found = "missing"
            self._files[path] = found
        return found

    def _folder(self, folder: str, names: bool) -> str:
        """What stands beside a program: controller files by content, the others by name where names may matter."""
        found = self._folders.get((folder, names))
        if found is None:
            from olp.assumptions import nearest_assumptions

            try:
                listed = sorted(entry.path for entry in os.scandir(folder) if entry.is_file())
            except OSError:
                listed = []
            above = nearest_assumptions(folder)
            parts = [self._file(path) for path in listed if path.lower().endswith(_CONTROLLER)]
            parts += [os.path.basename(path) for path in listed] if names else []
            parts += [self._file(str(above))] if above is not None else []
            found = self._folders[(folder, names)] = sha256(
                "\0".join(parts).encode("utf-8", "surrogatepass")
            ).hexdigest()
        return found


def _settings(job: Job) -> str:
    """The settings that times depend on, with the content of the files they name, and the version of olp itself."""
    from olp import __version__

    files = [job.robot, job.assumptions, job.signature]
    contents = [
        sha256(Path(f).read_bytes()).hexdigest() for f in files if f is not None and os.path.isfile(f)
    ]
    return repr((__version__, job, contents))


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
