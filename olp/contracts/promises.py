"""A contract suite: promises that hold for every member of a kind, and what a broken one says."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from traceback import extract_tb
from typing import Final, NamedTuple, TypeVar

Subject = TypeVar("Subject")
Difference = tuple[str, str]  # the input, and what differed
Promise = Callable[[Subject], Iterator[Difference]]
_MOST: Final = 5  # differences shown of one promise
_CALLS: Final = 3  # shown of an exception


class BrokenPromise(NamedTuple):
    """`promise`: the sentence that does not hold. `given`: the input that shows it. `differs`: what came out.

    `name`: of the promise's function, which `only` of `check_vendor` and `check_writer` takes.
    """

    promise: str
    given: str
    differs: str
    name: str

    def __str__(self) -> str:
        return f"{self.promise}\n    promise  {self.name}\n    given    {self.given}\n    differs  {self.differs}"


class ContractError(AssertionError):
    """Raised by every `check_…`: all promises that `member` breaks."""

    def __init__(self, member: str, broken: Sequence[BrokenPromise]) -> None:
        self.member, self.broken = member, tuple(broken)
        super().__init__("\n".join([f"{member} breaks its contract:", *(f"- {one}" for one in broken)]))


def sentence(promise: Callable[..., object]) -> str:
    """What a promise says: the first line of its docstring."""
    return (inspect.getdoc(promise) or promise.__name__).partition("\n")[0].rstrip(".")


def chosen(promises: Sequence[Promise[Subject]], only: str) -> Sequence[Promise[Subject]]:
    """The promise whose function is called `only`; all for "". Raises ValueError, which lists all, for another name."""
    found = [one for one in promises if only in ("", one.__name__)]
    if not found:
        listed = "\n".join(f"{one.__name__}: {sentence(one)}" for one in promises)
        raise ValueError(f"'{only}' is no promise of this contract, which has\n{listed}")
    return found


def hold(member: str, subject: Subject, promises: Sequence[Promise[Subject]], *, first: bool = False) -> None:
    """Raises ContractError with every promise that `subject` breaks; with `first` at the first one.

    A promise yields nothing where it holds. One that raises is broken: no member may raise on what a promise gives it.
    What one mistake raises in many promises is told in full once.
    """
    broken: list[BrokenPromise] = []
    raised: dict[
        tuple[str, str], str
    ] = {}  # the innermost place and what it raises -> the promise that tells it
    for promise in promises:
        try:
            found = islice(promise(subject), 1 if first else _MOST)
            broken += [BrokenPromise(sentence(promise), *one, promise.__name__) for one in found]
        except Exception as problem:
            mistake = str(extract_tb(problem.__traceback__, -1)), repr(problem)
            teller = raised.setdefault(mistake, promise.__name__)
            differs = _raised(problem) if teller == promise.__name__ else f"raised what {teller} tells"
            broken.append(BrokenPromise(sentence(promise), "the member itself", differs, promise.__name__))
        if broken and first:
            break
    if broken:
        raise ContractError(member, broken)


def _raised(problem: Exception) -> str:
    """The exception with the innermost calls: the last one alone is often in a library."""
    frames = [f"{frame.filename}:{frame.lineno}" for frame in extract_tb(problem.__traceback__, -_CALLS)]
    place = f" in {', called from '.join(reversed(frames))}" if frames else ""
    text = str(problem).strip()
    return f"raised {type(problem).__name__}{place}: {text[:400]}"
