"""The passes in their order: a program of any language in the form that a language's writer takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from olp.program import Program
from olp.translate.work import Context, Loss, Work, work_for

Pass = Callable[[Program, Work], Program]


@dataclass(frozen=True, slots=True)
class Translated:
    """`mapping`: (kind, name in the source) -> name in the target.

    Kinds: point, variable, tool, frame, routine, signal, label.
    """

    program: Program
    losses: tuple[Loss, ...]
    mapping: dict[tuple[str, str], str]
    notes: tuple[str, ...] = ()


def passes() -> tuple[Pass, ...]:
    """All passes between two languages, in order."""
    return ()


def canonical(program: Program, target: str, context: Context | None = None) -> Translated:
    """`program` as the writer of the language `target` takes it. Raises OlpError (X010) for one that cannot be written.

    A program of the same language stays as it is.
    """
    work = work_for(program, target, context or Context())
    result = program
    if program.vendor != target:
        for step in passes():
            result = step(result, work)
    return Translated(result, tuple(work.losses), work.names, tuple(work.notes))
