"""The same work on a Dask cluster: `--scheduler tcp://host:8786`. The files must be there under the same paths.

Codes: M003 no cluster, or a worker that cannot do the work.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from olp.checks.guard.judge import JudgedFile
from olp.core.diagnostic import OlpError, error

if TYPE_CHECKING:
    from olp.checks.guard.budget import Budget
    from olp.reports.batch import Job

_CHUNK = 32  # files per task: a task of milliseconds costs more to hand out than to do
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
    from olp.checks.guard.run import judge_one

    if os.path.isdir(folder):
        os.chdir(folder)
    return [judge_one(argument) for argument in chunk]
