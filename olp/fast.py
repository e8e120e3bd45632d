"""The optional compiled extra (`pip install olp[fast]`, numba): the same answers, sooner.

Nothing needs it. Importing it costs a third of a second, so a small task is done without even when it is there.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache, update_wrapper
from importlib.util import find_spec
from typing import Any, Generic, ParamSpec, TypeVar

from olp.diagnostic import OlpError, error

P = ParamSpec("P")
R = TypeVar("R")

IMPORT_TIME = 0.5  # [s] CPU of importing numba and loading a kernel that was compiled before, measured


class Kernel(Generic[P, R]):
    """A function of loops over arrays, compiled when it is first called; without numba it must not be called."""

    def __init__(self, function: Callable[P, R]) -> None:
        update_wrapper(self, function)
        self.plain = function
        self._compiled: Callable[P, R] | None = None

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        if self._compiled is None:
            self._compiled = _compile(self.plain)
        return self._compiled(*args, **kwargs)


@cache
def available() -> bool:
    """Whether the compiled extra is installed."""
    return find_spec("numba") is not None


def use(compiled: bool | None, seconds: float) -> bool:
    """Whether to run compiled: as told, or where left open (None) if it saves `seconds` [s] that are worth it.

    Raises OlpError (F001) when it is told but not installed.
    """
    if compiled is None:
        return available() and ("numba" in sys.modules or seconds > IMPORT_TIME)
    if compiled and not available():
        raise OlpError(error("F001", "the compiled extra is not installed", help="pip install olp[fast]"))
    return compiled


def _compile(function: Callable[P, R]) -> Callable[P, R]:
    import numba

    options: dict[str, Any] = {"error_model": "numpy", "nogil": True}
    compiled: Callable[P, R]
    try:
        compiled = numba.njit(cache=True, **options)(function)
    except RuntimeError:
        # An installation that cannot be written to has no place for compiled code: compile in every process.
        compiled = numba.njit(**options)(function)
    return compiled
