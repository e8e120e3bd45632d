"""Building many objects without looking for cycles among them."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

_MOST: Final = (
    1_000_000  # objects, about 100 MB: a program of 20,000 moves is read and translated with a third of them
)


@dataclass(slots=True)
class _Old:
    """`added`: objects that were made old without Python's knowing, since all were looked at; `left`: after that."""

    added: int = 0
    left: int = 0


_old = _Old()


@contextmanager
def no_garbage_collection() -> Iterator[None]:
    """For code that builds many objects and no cycles: collecting them over and over doubles its time.

    What was built counts as old afterwards, or the first collection would walk over all of it once more. Python looks
    at the old ones when enough have become old, and does not count these; so they are counted here, and looked at
    before the next building when there are as many as had been left the last time.
    """
    enabled = gc.isenabled()
    if enabled and _old.added > max(_MOST, _old.left):
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
            gc.freeze()  # moves everything, and walks over nothing …
            gc.unfreeze()  # … to the oldest generation
            gc.enable()
