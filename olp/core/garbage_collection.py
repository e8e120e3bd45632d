"""Keeps Python's garbage collector away from code that builds many objects and no reference cycles."""

from __future__ import annotations

import gc
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

_MOST_ADDED: Final = (
    1_000_000  # objects, about 100 MB: a program of 20,000 moves is read and translated with a third of them
)


@dataclass(slots=True)
class _Old:
    """Objects in the oldest generation: `left` by the last full collection here, `added` to it since by `gc.freeze`."""

    added: int = 0
    left: int = 0


_old = _Old()


@contextmanager
def no_garbage_collection() -> Generator[None]:
    """For code that builds many objects and no cycles: repeated collections would double its time.

    Afterwards all objects are moved to the oldest generation, or the next collection would walk over them once more.
    Python does not count objects that are moved so when it decides to collect the oldest generation. They are counted
    here: a full collection runs before the next such code when there are as many as the last one left.
    """
    enabled = gc.isenabled()
    if enabled and _old.added > max(_MOST_ADDED, _old.left):
        gc.collect()
        _old.added, _old.left = 0, len(gc.get_objects())
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            young, middle, _ = (
                gc.get_count()
            )  # objects, and collections that each left some of as many as there may be
            _old.added += young + middle * gc.get_threshold()[0]
            gc.freeze()  # moves all objects, without walking over them, …
            gc.unfreeze()  # … to the oldest generation
            gc.enable()
