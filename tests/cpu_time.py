"""A bound on CPU time that a test sets to what it calls, and to nothing that earlier tests have left in memory."""

from __future__ import annotations

import gc
import time
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def cpu_time_below(limit: float) -> Iterator[None]:
    """Fails if the body takes more CPU time than `limit` (s).

    In a process that has run thousands of tests one search for cycles among their objects takes as long as the body:
    they are frozen meanwhile, so that only the body's own objects are searched.
    """
    gc.collect()
    gc.freeze()
    try:
        begin = time.process_time()
        yield
        taken = time.process_time() - begin
    finally:
        gc.unfreeze()
    assert taken < limit, f"{taken:.2f} s of CPU time, {limit:g} s allowed"
