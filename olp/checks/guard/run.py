"""Checks many files against their budgets: unchanged results come from the cache, the rest runs on all cores.

The key of a cached result is the content of every file that was read for it, the settings, the budgets and olp
itself. Dates and folders play no part: a fresh checkout elsewhere finds what another machine stored.

A cache is untrusted: anyone may have written it. Invalid rows are ignored, and a verdict counts only where its own
figures lead to it. A cache that git tracks is rejected: a contributor could commit verdicts with it.

Codes: M006 a file that is not a cache; M008 a cache that git tracks.
"""

from __future__ import annotations

import json
import os
import re
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, field, replace
from functools import cache, partial
from hashlib import sha256
from itertools import starmap
from pathlib import Path
from typing import Any, NamedTuple

from olp.checks.guard.budget import Budget, Budgets, budgets_for, label_name
from olp.checks.guard.judge import judge_timing, unknown_item, verdict
from olp.core.diagnostic import Diagnostic, OlpError, Span, error
from olp.core.files import parse_json, read_input, utf8
from olp.core.git import git
from olp.identification.timing_job import TimingJob, time_program
from olp.ir.program import Program
from olp.reports.outcome.model import JudgedItem, Level, OutcomeFinding, Status, of_diagnostic
from olp.timing.result import Timing

_MARK = 0x6F6C7063  # SQLite's application_id: "olpc"
_SCHEMA = "create table if not exists result (path text primary key, key text not null, value text not null)"
# Files beside a program that its times depend on.
_CONTROLLER = (".cnd", ".dat", ".prm", ".sys", ".va", ".toml")
_UNRESOLVED = frozenset({"I102", "I203", "I209"})  # another file of the folder may answer these
_PATIENCE_S = 5.0  # for another olp that writes
_MOST_STEPS = 200_000_000  # of SQLite's machine: seconds
_MOST_TEXT = 8_000_000  # characters of one result
_MOST_READ = 10_000  # files of one program
_MOST = 1e12  # [s] and lines


@dataclass(frozen=True, slots=True)
class JudgedFile:
    """Verdict on one file. `read`: the files whose content decided it, for the cache; `unread`: the file could not
    be read.
    """

    path: str
    items: tuple[JudgedItem, ...]
    findings: tuple[OutcomeFinding, ...]
    total_s: float | None
    motion_s: float = 0.0
    wait_s: float = 0.0
    io_s: float = 0.0
    high_s: float | None = None
    read: tuple[str, ...] = ()
    unread: bool = False


@dataclass(slots=True)
class Cache:
    """The cache in the file `path`; it is not used if it cannot be opened or written."""

    path: Path
    settings: str = ""
    _known: dict[str, tuple[str, str]] = field(default_factory=dict)
    _files: dict[str, str] = field(default_factory=dict)
    _folders: dict[tuple[str, bool], str] = field(default_factory=dict)

    @classmethod
    def open(cls, path: Path, job: TimingJob) -> Cache:
        """The cache for runs with the settings `job`. Raises OlpError (M006) for a file that is not a cache."""
        found = cls(path, _settings(job))
        if not path.is_file() or not path.stat().st_size:
            return found
        if _is_tracked(path):
            says = "git tracks this cache, so its verdicts may come with the change that is judged"
            raise OlpError(error("M008", says, file=str(path), help=f"git rm --cached {path.name}"))
        try:
            with closing(sqlite3.connect(path, timeout=_PATIENCE_S)) as store:
                tables = store.execute("select count(*) from sqlite_master").fetchone()[0]
                # A run that was killed before it had written anything leaves a database without tables or mark.
                if tables and store.execute("pragma application_id").fetchone()[0] != _MARK:
                    raise _refused(path)
                found._known = _rows(store)
        except sqlite3.OperationalError:
            return found
        except sqlite3.DatabaseError:
            raise _refused(path) from None
        return found

    def find(self, path: str, budgets: Sequence[Budget]) -> JudgedFile | None:
        """The result of `path` if nothing that it depends on has changed."""
        known = self._known.get(self._name(path))
        if known is None:
            return None
        try:
            judged = _judged_from(parse_json(known[1]))
            same = judged.path == path and path in judged.read and known[0] == self._key(judged, budgets)
        except (ValueError, KeyError, TypeError, OverflowError):
            return None
        return judged if same and _follows(judged, budgets) else None

    def keep(self, results: Iterable[tuple[JudgedFile, Sequence[Budget]]]) -> None:
        """Store results."""
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
        """Path of the program relative to the cache, so that a checkout elsewhere has the same name for it."""
        try:
            name = os.path.relpath(path, self.path.parent)
        except ValueError:  # another drive of Windows
            name = os.path.abspath(path)
        return utf8(name).decode()

    def _key(self, judged: JudgedFile, budgets: Sequence[Budget]) -> str:
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
        """Digest of the files beside a program: controller files by content; with `names` (for programs with calls)
        the others by name.
        """
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


def _settings(job: TimingJob) -> str:
    """The settings that times depend on, with the content of the files they name, and olp itself."""
    names = (job.robot, job.assumptions, job.signature)
    contents = [_content(name) for name in names if name is not None and os.path.isfile(name)]
    return repr((_olp(), job, contents))


@cache
def _olp() -> str:
    """Digest of olp's own files: the version alone does not change during development."""
    from olp.core.version import __version__

    root = Path(__file__).parents[2]
    files = [path for kind in ("*.py", "*.toml", "*.lark") for path in sorted(root.rglob(kind))]
    return _digest([__version__, *(_content(str(path)) for path in files)])


def _content(path: str) -> str:
    try:
        return sha256(read_input(path)).hexdigest()
    except OSError:
        return "missing"


def _digest(parts: Iterable[str]) -> str:
    return sha256("\0".join(parts).encode("utf-8", "surrogatepass")).hexdigest()


def _refused(path: Path) -> OlpError:
    return OlpError(
        error(
            "M006",
            "this file is not a cache of olp check",
            file=str(path),
            help="name another one with --cache",
        )
    )


def _rows(store: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Name -> (key, value) of a plain table; anything else under its name, such as an endless view, gives no rows."""
    store.set_progress_handler(lambda: 1, _MOST_STEPS)
    kind = store.execute("select type from sqlite_master where name = 'result'").fetchone()
    if kind != ("table",):
        return {}
    rows = store.execute("select path, key, value from result where length(value) < ?", (_MOST_TEXT,))
    return {name: (key, value) for name, key, value in rows if type(name) is type(key) is type(value) is str}


def _is_tracked(path: Path) -> bool:
    try:
        return git("ls-files", "--error-unmatch", "--", path.name, cwd=path.resolve().parent) is not None
    except OlpError:
        return False


def _follows(judged: JudgedFile, budgets: Sequence[Budget]) -> bool:
    """Whether each budget has its verdict, and the stored seconds lead to it."""
    items = {item.name: item for item in judged.items}
    texts: list[str | None] | None = None
    if len(items) != len(judged.items) or set(items) - {b.name for b in budgets}:
        return False
    for budget in budgets:
        item = items.get(budget.name)
        if item is None:
            texts = [_text(file) for file in judged.read] if texts is None else texts
            if not budget.anywhere or _is_named(budget, judged.read, texts):
                return False
        elif item.limit_s != budget.limit_s or not _led_to(item, budget, judged):
            return False
    return True


def _is_named(budget: Budget, files: Sequence[str], texts: Sequence[str | None]) -> bool:
    """Whether a part of a program that is missing in the cached result may exist after all."""
    names = [budget.routine.casefold()] if budget.routine else [*map(label_name, (budget.start, budget.stop))]
    stems = {Path(file).stem.casefold() for file in files}
    return all(
        name in stems
        or not name.isascii()
        or any(text is None or re.search(rf"(?<!\w){re.escape(name)}(?!\w)", text) for text in texts)
        for name in names
    )


def _text(path: str) -> str | None:
    """The text of a program if its bytes are ASCII, else None."""
    try:
        raw = read_input(path)
    except OSError:
        return None
    packed = raw.startswith(b"\x1f\x8b") or b"\0" in raw
    return None if packed else raw.decode("latin-1").casefold()


def _led_to(item: JudgedItem, budget: Budget, judged: JudgedFile) -> bool:
    over = item.seconds is not None and item.seconds > budget.limit_s + budget.tolerance_s
    if item.seconds is None or (judged.total_s is None and not over):
        return item.status is Status.UNKNOWN
    if budget.on == "lower" and not over:  # the total that it belongs to is another signature's
        return item.status in (Status.HELD, Status.WARNED)
    return (item.status, item.message) == verdict(budget, item.seconds, judged.total_s or 0.0)


def _judged_from(value: object) -> JudgedFile:
    """The result from its JSON. Raises ValueError, KeyError or TypeError if it is invalid."""
    whole = _table(value)
    items = [_table(item) for item in _list(whole.pop("items"))]
    findings = [_table(finding) for finding in _list(whole.pop("findings"))]
    read = tuple(_texts(whole.pop("read")))
    if len(read) > _MOST_READ:
        raise ValueError("more files than a program calls")
    judged = JudgedFile(
        items=tuple(JudgedItem(**(item | {"status": Status(item["status"])})) for item in items),
        findings=tuple(_finding(finding) for finding in findings),
        read=read,
        **whole,
    )
    for item in judged.items:
        _texts([item.name, item.file, item.message, item.group, item.details])
        _numbers([item.seconds, item.limit_s, item.low_s, item.high_s])
        _wholes([item.line])
    if type(judged.unread) is not bool:
        raise ValueError("neither read nor unread")
    _texts([judged.path])
    _numbers([judged.total_s, judged.motion_s, judged.wait_s, judged.io_s, judged.high_s])
    return judged


def _finding(value: dict[str, Any]) -> OutcomeFinding:
    fixes = tuple(
        (int(first), int(last), str(text)) for first, last, text in map(_list, _list(value["fixes"]))
    )
    found = OutcomeFinding(**(value | {"level": Level(value["level"]), "fixes": fixes}))
    _texts([found.code, found.message, found.file, found.title, found.help, found.source_line, found.anchor])
    _wholes([found.line, found.column, found.end_column, *(line for fix in fixes for line in fix[:2])])
    _numbers([number for number in _table(found.numbers).values() if not isinstance(number, str)])
    return found


def _table(value: object) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ValueError("no table")
    return value


def _list(value: object) -> list[Any]:
    if not isinstance(value, list):
        raise ValueError("no list")
    return value


def _texts(values: Iterable[object]) -> Sequence[str]:
    found = [value for value in values if isinstance(value, str)]
    if not isinstance(values, list) or len(found) != len(values):
        raise ValueError("no text")
    for text in found:
        text.encode("utf-8", "surrogateescape")  # raises for half characters; names may hold any bytes
    return found


def _wholes(values: Iterable[object]) -> None:
    if not all(type(value) is int and 0 <= value < _MOST for value in values):
        raise ValueError("no place")


def _numbers(values: Iterable[object]) -> None:
    if not all(value is None or (isinstance(value, (int, float)) and abs(value) < _MOST) for value in values):
        raise ValueError("no number")


_WORTH_WORKERS = 24  # files below which starting processes costs more than it saves
_CHUNK = 32


class Task(NamedTuple):
    path: str
    budgets: tuple[Budget, ...]


class GuardSettings(NamedTuple):
    """Settings of a run. `cache`: its file, None for none. `scheduler`: address of a Dask cluster, "" for this
    machine.
    """

    job: TimingJob
    workers: int = 0
    cache: Path | None = None
    scheduler: str = ""


class GuardWork(NamedTuple):
    """Each file with its budgets, and all the budget files found."""

    tasks: tuple[Task, ...]
    budgets: tuple[Budgets, ...]

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """Problems of the budgets themselves, each once."""
        return [d for budgets in self.budgets for d in budgets.diagnostics]

    def idle(self, results: Sequence[JudgedFile], folders: Sequence[str]) -> list[Diagnostic]:
        """Diagnostics for budgets that hold for no program although their whole folder was checked."""
        roots = [Path(folder).resolve() for folder in folders if Path(folder).is_dir()]
        judged = {item.name for result in results for item in result.items}
        found = []
        for budgets in self.budgets:
            home = Path(budgets.path).parent
            if any(home.is_relative_to(root) for root in roots):
                found += [_idle(b, budgets.path) for b in budgets.budgets if b.name not in judged]
        return found


def _idle(budget: Budget, path: str) -> Diagnostic:
    says = f"the budget {budget.name!r} holds for no program below"
    span = Span(budget.line) if budget.line else None
    return error("M007", says, span, file=path, help="check files, job, routine, from and to, or remove it")


def tasks(paths: Sequence[str], given: str | None = None) -> GuardWork:
    """The work for checking `paths`. `given`: an olp.toml whose budgets hold, else the nearest ones."""
    found: list[Task] = []
    files: dict[str, Budgets] = {}
    folders: dict[str, list[Budgets]] = {}
    for path in paths:
        folder = os.path.dirname(path)
        known = folders[folder] = folders.get(folder) or budgets_for(path, given)
        files.update((budgets.path, budgets) for budgets in known)
        found.append(Task(path, tuple(b for budgets in known for b in budgets.budgets if b.covers(path))))
    return GuardWork(tuple(found), tuple(files.values()))


def run(
    work: Sequence[Task], settings: GuardSettings, done: Callable[[int], None] | None = None
) -> list[JudgedFile]:
    """One result per task, in their order. `done(n)` after each n files."""

    cache = Cache.open(settings.cache, settings.job) if settings.cache is not None else None
    results: dict[int, JudgedFile] = {}
    if cache is not None:
        for index, task in enumerate(work):
            known = cache.find(task.path, task.budgets)
            if known is not None:
                results[index] = known
    if done is not None:
        done(len(results))
    open_tasks = [(index, task) for index, task in enumerate(work) if index not in results]
    fresh: list[tuple[JudgedFile, Sequence[Budget]]] = []
    for (index, task), judged in zip(open_tasks, _judged([t for _, t in open_tasks], settings), strict=True):
        results[index] = judged
        fresh.append((judged, task.budgets))
        if done is not None:
            done(1)
    if cache is not None and fresh:
        cache.keep(fresh)
    return [results[index] for index in range(len(work))]


def _judged(work: Sequence[Task], settings: GuardSettings) -> Iterator[JudgedFile]:
    arguments = [(task.path, task.budgets, settings.job) for task in work]
    if settings.scheduler:
        yield from judge_on(settings.scheduler, arguments)
        return
    workers = min(settings.workers or os.cpu_count() or 1, 1 + len(work) // _WORTH_WORKERS)
    if workers <= 1:
        yield from starmap(judge, arguments)
        return
    from concurrent.futures import ProcessPoolExecutor

    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(judge_one, arguments, chunksize=_CHUNK)


def judge(path: str, budgets: Sequence[Budget], job: TimingJob) -> JudgedFile:
    """Times the program in `path` and checks it against `budgets`. Never raises for a bad program."""
    from olp.languages.vendor import read

    try:
        program = read(path, encoding=job.encoding)
        timings = {given: _timed(program, job, given) for given in {b.signature for b in budgets} | {""}}
    except OlpError as problem:
        findings = tuple(of_diagnostic(d, path) for d in problem.diagnostics)
        why = problem.diagnostics[0].message
        unknown = tuple(unknown_item(b, path, why) for b in budgets)
        return JudgedFile(path, unknown, findings, None, read=(path,), unread=True)
    plain = timings[""]
    items, more = judge_timing(path, program, timings, budgets)
    found = [*_once([of_diagnostic(d.at(path)) for d in plain.diagnostics]), *more]
    read_files = tuple(
        dict.fromkeys([path, *(s.path for s in plain.plan.sources), *(s.path for s in program.companions)])
    )
    whole = not plain.untimed and not plain.left_open
    total = plain.total_s if whole else None
    sums = (plain.motion_s, plain.wait_s, plain.io_s, plain.high_s)
    return JudgedFile(path, tuple(items), tuple(found), total, *sums, read_files)


def _once(found: list[OutcomeFinding]) -> list[OutcomeFinding]:
    seen: dict[tuple[str, str, int, str], OutcomeFinding] = {}
    for finding in found:
        seen.setdefault((finding.code, finding.file, finding.line, finding.message), finding)
    return list(seen.values())


def _timed(program: Program, job: TimingJob, signature: str) -> Timing:
    return time_program(program, replace(job, signature=signature) if signature else job)


def judge_one(argument: tuple[str, tuple[Budget, ...], TimingJob]) -> JudgedFile:
    """`judge` with one argument, for pools and clusters."""
    return judge(*argument)


# --- Cluster ---
# The same work on a Dask cluster: `--scheduler tcp://host:8786`. The files must be there under the same paths.
#
# Codes: M003 no cluster, or a worker that cannot do the work.

_PATIENCE = "20s"  # to reach the scheduler
_RETRIES = 5  # of a task whose worker died


def judge_on(
    address: str, arguments: Sequence[tuple[str, tuple[Budget, ...], TimingJob]]
) -> Iterator[JudgedFile]:
    """The results in the order of the arguments, each once. If a worker dies, another one takes over its task.

    Raises OlpError (M003) without the extra, without a scheduler, or when tasks keep failing.
    """
    try:
        import distributed
    except ImportError:
        raise OlpError(
            error("M003", "a cluster needs the library dask", help='pip install "olp[cluster]"')
        ) from None
    client_type: Any = distributed.Client
    chunks = [arguments[start : start + _CHUNK] for start in range(0, len(arguments), _CHUNK)]
    try:
        with client_type(address, timeout=_PATIENCE) as client:
            work = partial(judge_chunk, folder=os.getcwd())
            futures = client.map(work, chunks, retries=_RETRIES, pure=False)
            for future in futures:
                yield from future.result()
    except OSError as problem:
        raise OlpError(
            error("M003", f"no cluster at {address}: {problem}", help="check the address")
        ) from None
    except Exception as problem:
        says = f"the cluster at {address} could not do the work: {problem}"
        raise OlpError(
            error("M003", says[:300], help="the workers need the same olp and the same files")
        ) from None


def judge_chunk(chunk: Sequence[tuple[str, tuple[Budget, ...], TimingJob]], folder: str) -> list[JudgedFile]:
    """Results of some files, one after the other. `folder`: the working folder of their paths."""

    if os.path.isdir(folder):
        os.chdir(folder)
    return [judge_one(argument) for argument in chunk]
