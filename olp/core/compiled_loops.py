"""The optional compiled extra (`pip install olp[fast]`, numba): the same answers, sooner.

Nothing needs it. Importing it costs a third of a second, so a small task is done without even when it is there.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache, update_wrapper
from importlib.util import find_spec
from types import FunctionType
from typing import Any, Generic, ParamSpec, TypeVar, cast

from olp.core.diagnostic import OlpError, error

P = ParamSpec("P")
R = TypeVar("R")

IMPORT_TIME = 0.5  # [s] CPU of importing numba and loading a kernel that was compiled before, measured
LOAD_TIME = 0.1  # [s] of loading the kernel alone


class Kernel(Generic[P, R]):
    """A function of loops over arrays, compiled when it is first called; without numba it must not be called.

    `helpers`: the functions of its module that it calls, each after those that it calls itself.
    """

    def __init__(self, function: Callable[P, R], helpers: tuple[FunctionType, ...] = ()) -> None:
        update_wrapper(self, function)
        self.plain = function
        self._helpers = helpers
        self._compiled: Callable[P, R] | None = None

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        if self._compiled is None:
            self._compiled = _compile(self.plain, self._helpers)
        return self._compiled(*args, **kwargs)


def kernel(*helpers: Callable[..., Any]) -> Callable[[Callable[P, R]], Kernel[P, R]]:
    """Decorator that makes a Kernel of a function which calls `helpers`."""
    return lambda function: Kernel(function, cast(tuple[FunctionType, ...], helpers))


@cache
def available() -> bool:
    """Whether the compiled extra is installed."""
    return find_spec("numba") is not None


def use(compiled: bool | None, seconds: float) -> bool:
    """Whether to run compiled: as told, or where left open (None) if it saves `seconds` [s] that are worth it.

    Raises OlpError (F001) when it is told but not installed.
    """
    if compiled is None:
        return available() and seconds > (LOAD_TIME if "numba" in sys.modules else IMPORT_TIME)
    if compiled and not available():
        raise OlpError(error("F001", "the compiled extra is not installed", help="pip install olp[fast]"))
    return compiled


class Loops:
    """Whether to do in compiled loops what is asked for again and again: from when they would have saved what it costs
    to load them. `saving` [s] per row. What all loops have in common is paid by what they would have saved together.
    """

    _together = 0.0  # [s] that all of them would have saved

    def __init__(self, saving: float) -> None:
        self._saving = saving
        self._saved = 0.0

    def worth(self, rows: int) -> bool:
        """Whether to do so for these rows, too."""
        self._saved += self._saving * rows
        Loops._together += self._saving * rows
        return self._saved > LOAD_TIME and use(None, Loops._together)


def _compile(function: Callable[P, R], helpers: tuple[FunctionType, ...]) -> Callable[P, R]:
    import numba

    options: dict[str, Any] = {"error_model": "numpy", "nogil": True}
    # Compiled functions can only call compiled ones: they get their module's names with those replaced.
    assert isinstance(function, FunctionType)
    names = dict(function.__globals__)
    for helper in helpers:
        names[helper.__name__] = numba.njit(**options)(FunctionType(helper.__code__, names, helper.__name__))
    loops = FunctionType(function.__code__, names, function.__name__, function.__defaults__)
    compiled: Callable[P, R]
    try:
        compiled = numba.njit(cache=True, **options)(loops)
    except RuntimeError:
        # An installation that cannot be written to has no place for compiled code: compile in every process.
        compiled = numba.njit(**options)(loops)
    return compiled
