"""Results of earlier work on nearly the same text, for whoever works on it again and again: an editor.

Nothing is cached unless a caller asks for it with `remembering`. A cached result depends on its key alone, or on its
key and on answers that are asked for again before it is used: it is always what the work would give.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Hashable
from contextlib import contextmanager
from threading import local
from typing import Any, Final, TypeVar

Result = TypeVar("Result")


class CacheShelf:
    """Results by key. A result that a whole round does not ask for is dropped at the end of that round.

    `most`: a round ends with so many results, None: only with `turn`.
    """

    __slots__ = ("_most", "_new", "_old")

    def __init__(self, most: int | None = None) -> None:
        self._most = most
        self._new: dict[Hashable, Any] = {}
        self._old: dict[Hashable, Any] = {}

    def get(self, key: Hashable) -> Any:
        """Return the result of `key`; None where there is none."""
        found = self._new.get(key)
        if found is None:
            found = self._old.get(key)
            if found is not None:
                self.put(key, found)
        return found

    def put(self, key: Hashable, result: Any) -> None:
        if self._most is not None and len(self._new) >= self._most:
            self.turn(finished=True)
        self._new[key] = result

    def turn(self, finished: bool) -> None:
        """End a round. An unfinished one has not asked for all its keys, so no result is dropped after it."""
        if not finished:
            self._old.update(self._new)
            return
        self._old, self._new = self._new, {}


class TextCache:
    """Named shelves of results, one cache per text."""

    def __init__(self) -> None:
        self._shelves: dict[str, CacheShelf] = {}

    def shelf(self, name: str) -> CacheShelf:
        found = self._shelves.get(name)
        if found is None:
            found = self._shelves[name] = CacheShelf()
        return found

    def turn(self, finished: bool) -> None:
        for shelf in self._shelves.values():
            shelf.turn(finished)


class SupersededError(Exception):
    """Raised when newer work has made a result obsolete."""


class _Rounds(local):
    """Those under way in this thread, the innermost last."""

    def __init__(self) -> None:
        self.open: list[tuple[TextCache, Callable[[], bool]]] = []


_rounds = _Rounds()


@contextmanager
def remembering(memory: TextCache, wanted: Callable[[], bool] = lambda: True) -> Generator[None]:
    """Use `memory` for the results of this thread as long as the context lasts.

    `wanted`: returns whether the result is still of use; `check` calls it.
    """
    rounds = _rounds.open
    rounds.append((memory, wanted))
    finished = False
    try:
        yield
        finished = True
    finally:
        rounds.pop()
        memory.turn(finished)


def check() -> None:
    """Raise SupersededError where the result is no longer wanted. Long computations call this from time to time."""
    rounds = _rounds.open
    if rounds and not rounds[-1][1]():
        raise SupersededError


def shelf(name: str) -> CacheShelf | None:
    """Return the shelf of this name; None outside of `remembering`."""
    rounds = _rounds.open
    return rounds[-1][0].shelf(name) if rounds else None


# --- work that asks others ----------------------------------------------------------------------------------

_PLAIN: Final = (str, int, float, bool, type(None), frozenset)
_MOST: Final = 64  # members of a mapping or set that is compared as a whole

_Entry = tuple[str, tuple[Any, ...], Any]  # what was asked, with what, and the answer


class _Witness:
    """Stands for an object and writes down what it was asked and what it answered."""

    def __init__(self, real: object, log: list[_Entry]) -> None:
        self.__dict__["_real"] = real
        self.__dict__["_log"] = log

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._real, name)
        if not callable(found):
            self._log.append((name, _READ, _kept(found)))
            return found

        def call(*given: Any) -> Any:
            answer = found(*given)
            sure = _is_frozen(answer) and all(map(_is_frozen, given))
            self._log.append((name, given, answer if sure else _UNSURE))
            return answer

        return call

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self._real, name, value)
        self._log.append((name, _WRITTEN, value if _is_frozen(value) else _UNSURE))


_READ: Final = ("read",)
_WRITTEN: Final = ("written",)
_UNSURE: Final = object()


def _is_frozen(thing: Any) -> bool:
    """Whether nothing can change it: then it can be compared with later answers."""
    if isinstance(thing, _PLAIN):
        return True
    if isinstance(thing, tuple):
        return all(map(_is_frozen, thing))
    params = getattr(type(thing), "__dataclass_params__", None)
    return params is not None and bool(params.frozen)


def _kept(thing: Any) -> Any:
    """What an attribute was, for a comparison later."""
    if isinstance(thing, dict) and len(thing) <= _MOST and all(map(_is_frozen, thing.values())):
        return dict(thing)
    if isinstance(thing, set) and len(thing) <= _MOST:
        return set(thing)
    return thing if _is_frozen(thing) else _UNSURE


def remembered(known: CacheShelf | None, key: Hashable, asked: Any, work: Callable[[Any], Result]) -> Result:
    """`work(asked)`; the result of the last time where `asked` still answers all its questions as it did then.

    The questions are asked again, in their order, so whatever they change in `asked` is changed again. What raises is
    not kept, nor what changes a mapping of `asked` behind its back.
    """
    if known is None:
        return work(asked)
    before = known.get(key)
    if before is not None and _same_answers(asked, before[0]):
        result: Result = before[1]
        return result
    log: list[_Entry] = []
    result = work(_Witness(asked, log))
    if all(_is_sure(asked, entry) for entry in log):
        known.put(key, (log, result))
    return result


def _is_sure(asked: Any, entry: _Entry) -> bool:
    name, given, answer = entry
    if answer is _UNSURE:
        return False
    return not isinstance(answer, (dict, set)) or given is not _READ or getattr(asked, name) == answer


def _same_answers(asked: Any, log: list[_Entry]) -> bool:
    for name, given, answer in log:
        if given is _WRITTEN:
            setattr(asked, name, answer)
        else:
            again = getattr(asked, name) if given is _READ else getattr(asked, name)(*given)
            if again is not answer and again != answer:
                return False
    return True
