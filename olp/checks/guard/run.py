"""Many files against their budgets: what did not change comes from the cache, the rest runs on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import starmap
from pathlib import Path
from typing import Any, NamedTuple

from olp.checks.guard.budget import Budget, Budgets, budgets_for
from olp.checks.guard.judge import JudgedFile, judge
from olp.core.diagnostic import Diagnostic, OlpError, Span, error
from olp.reports.batch import Job

_WORTH_WORKERS = 24  # files below which starting processes costs more than it saves
_CHUNK = 32


class Task(NamedTuple):
    path: str
    budgets: tuple[Budget, ...]


class GuardSettings(NamedTuple):
    """How a run goes. `cache`: its file, None for none. `scheduler`: address of a Dask cluster, "" for this machine."""

    job: Job
    workers: int = 0
    cache: Path | None = None
    scheduler: str = ""


class GuardWork(NamedTuple):
    """Each file with its budgets, and all the budgets that were met on the way."""

    tasks: tuple[Task, ...]
    budgets: tuple[Budgets, ...]

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """What is wrong with the budgets themselves, each once."""
        return [d for budgets in self.budgets for d in budgets.diagnostics]

    def idle(self, results: Sequence[JudgedFile], folders: Sequence[str]) -> list[Diagnostic]:
        """Budgets that hold for no program although their whole folder was looked through: nobody keeps them."""
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
    """The work that checking `paths` is. `given`: an olp.toml whose budgets hold, else the nearest ones."""
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
    from olp.checks.guard.cache import Cache

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


def judge_one(argument: tuple[str, tuple[Budget, ...], Job]) -> JudgedFile:
    """`judge` with one argument, for pools and clusters."""
    return judge(*argument)


# --- Cluster ---
# The same work on a Dask cluster: `--scheduler tcp://host:8786`. The files must be there under the same paths.
#
# Codes: M003 no cluster, or a worker that cannot do the work.

_PATIENCE = "20s"  # to reach the scheduler
_RETRIES = 5  # of a task whose worker died


def judge_on(address: str, arguments: Sequence[tuple[str, tuple[Budget, ...], Job]]) -> Iterator[JudgedFile]:
    """The results in the order of the arguments, each once. A task whose worker dies is done by another one.

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


def judge_chunk(chunk: Sequence[tuple[str, tuple[Budget, ...], Job]], folder: str) -> list[JudgedFile]:
    """Some files, one after the other. `folder`: the one that their paths are seen from."""

    if os.path.isdir(folder):
        os.chdir(folder)
    return [judge_one(argument) for argument in chunk]
