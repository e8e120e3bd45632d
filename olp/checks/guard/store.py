"""Stores runs over time in an SQLite file, so that drift is one query.

Tables: `run` (id, started, version, commit_id), `program` (run, path, total_s, motion_s, wait_s, io_s, high_s) and
`item` (run, path, name, status, seconds, limit_s). Seconds are the predictions of that run.

Codes: M004 a file that is not such a store.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Sequence
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from olp.checks.guard.run import JudgedFile
from olp.core.diagnostic import OlpError, error
from olp.core.files import utf8
from olp.core.git import git

_MARK = 0x6F6C7073  # SQLite's application_id: "olps"
_MOST_S = 1e12  # of a program: 30,000 years
_PATIENCE_S = 30.0  # for another olp that writes
_SCHEMA = """
create table if not exists run (id integer primary key, started text not null, version text not null,
                                commit_id text not null);
create table if not exists program (run integer not null references run, path text not null, total_s real,
                                    motion_s real, wait_s real, io_s real, high_s real, primary key (run, path));
create table if not exists item (run integer not null references run, path text not null, name text not null,
                                 status text not null, seconds real, limit_s real, primary key (run, path, name));
create index if not exists program_path on program (path);
"""
# What may run without an end when a row is written or read; views of other names are whoever's queries.
_ODD = """
select count(*) from sqlite_master where type = 'trigger'
    or (name in ('run', 'program', 'item') and (type != 'table' or sql like 'create virtual%'))
"""


class TrendPoint(NamedTuple):
    """One program in one run; `total_s` None where it could not be timed."""

    started: str
    commit: str
    path: str
    total_s: float | None
    motion_s: float
    wait_s: float


def keep(path: Path, results: Sequence[JudgedFile], root: Path) -> None:
    """Add a run. Paths are stored relative to `root`, so that machines agree. Raises OlpError (M004)."""
    from olp.core.version import __version__

    now = datetime.now(UTC).isoformat(timespec="seconds")
    try:
        with closing(_opened(path)) as store, store:
            run = store.execute(
                "insert into run (started, version, commit_id) values (?, ?, ?)",
                (now, __version__, _commit(root)),
            ).lastrowid
            store.executemany(
                "insert or replace into program values (?, ?, ?, ?, ?, ?, ?)",
                [
                    (run, _name(r.path, root), r.total_s, r.motion_s, r.wait_s, r.io_s, r.high_s)
                    for r in results
                ],
            )
            store.executemany(
                "insert or replace into item values (?, ?, ?, ?, ?, ?)",
                [
                    (run, _name(r.path, root), item.name, str(item.status), item.seconds, item.limit_s)
                    for r in results
                    for item in r.items
                ],
            )
    except sqlite3.Error as problem:
        raise _refused(path, problem) from None


def history(path: Path, job: str) -> list[TrendPoint]:
    """All runs of a program called `job`: its path, the end of it, or its stem. Raises OlpError (M004)."""
    if not path.is_file():
        raise OlpError(
            error("M004", "no such store", file=str(path), help="olp check --store FILE makes one")
        )
    query = (
        "select started, commit_id, path, total_s, motion_s, wait_s from program join run on run.id = program.run "
        "order by run.id, path"
    )
    try:
        with closing(_opened(path)) as store:
            return [TrendPoint(*row) for row in store.execute(query) if _can_be(row) and _means(row[2], job)]
    except sqlite3.Error as problem:
        raise _refused(path, problem) from None


def check(path: Path) -> None:
    """Raises OlpError (M004) for a file that cannot be a store, before any work is done for it."""
    try:
        _opened(path).close()
    except sqlite3.Error as problem:
        raise _refused(path, problem) from None


def _opened(path: Path) -> sqlite3.Connection:
    store = sqlite3.connect(path, timeout=_PATIENCE_S)
    try:
        mark = store.execute("pragma application_id").fetchone()[0]
        tables = store.execute("select count(*) from sqlite_master").fetchone()[0]
        if tables and mark != _MARK:
            raise sqlite3.DatabaseError("it is another program's database")
        if store.execute(_ODD).fetchone()[0]:
            raise sqlite3.DatabaseError("it holds triggers, or what stands in the place of its tables")
        store.execute(f"pragma application_id = {_MARK}")
        store.executescript(_SCHEMA)
    except sqlite3.Error:
        store.close()
        raise
    return store


def _can_be(row: Sequence[object]) -> bool:
    """Whether olp can have written the row; other rows are ignored."""
    texts, (total, *parts) = row[:3], row[3:]
    numbers = parts if total is None else [total, *parts]
    return all(type(text) is str for text in texts) and all(
        type(number) is float and abs(number) < _MOST_S for number in numbers
    )


def _means(path: str, job: str) -> bool:
    wanted, known = job.replace("\\", "/").casefold(), path.casefold()
    name = known.rpartition("/")[2]
    return known == wanted or known.endswith("/" + wanted) or name.rpartition(".")[0] == wanted


def _name(path: str, root: Path) -> str:
    try:
        name = Path(os.path.realpath(path)).relative_to(os.path.realpath(root)).as_posix()
    except ValueError:
        name = Path(path).as_posix()
    return utf8(name).decode()


def _commit(root: Path) -> str:
    """The commit that is checked out, "" without one or without git."""
    try:
        asked = git("rev-parse", "--short=12", "HEAD", cwd=root)
    except OlpError:
        return ""
    return "" if asked is None else asked.decode().strip()


def _refused(path: Path, problem: sqlite3.Error) -> OlpError:
    return OlpError(
        error("M004", f"the store cannot be used: {problem}", file=str(path), help="name another file")
    )
