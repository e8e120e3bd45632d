"""Building many objects without looking for cycles among them."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def no_garbage_collection() -> Iterator[None]:
    """For code that builds many objects and no cycles: collecting them over and over doubles its time.

    What was built counts as old afterwards, or the first collection would walk over all of it once more.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.freeze()  # moves everything, and walks over nothing …
            gc.unfreeze()  # … to the oldest generation
            gc.enable()
