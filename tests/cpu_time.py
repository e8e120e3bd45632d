"""A bound on CPU time that a test sets to what it calls, and to nothing that earlier tests have left in memory."""

from __future__ import annotations

import gc
import time
from collections.abc import Iterator
from contextlib import contextmanager

_OLDEST = 2


@contextmanager
def cpu_time_below(limit: float) -> Iterator[None]:
    """Fails if the body takes more CPU time than `limit` (s).

    In a process that has run thousands of tests one search for cycles among all objects takes a second. Whether it
    falls into the body is chance: it is not counted.
    """
    searches: list[float] = []  # [s] CPU when one begins, and, below zero, when it ends

    def search(phase: str, info: dict[str, int]) -> None:
        if info["generation"] == _OLDEST:
            searches.append(time.process_time() if phase == "start" else -time.process_time())

    gc.callbacks.append(search)
    begin = time.process_time()
    try:
        yield
        taken = time.process_time() - begin + sum(searches)
    finally:
        gc.callbacks.remove(search)
    assert taken < limit, f"{taken:.2f} s of CPU time, {limit:g} s allowed"
