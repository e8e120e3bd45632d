"""Moves that count from where the arm stands, for languages that read this place while the arm is on its way.

Some languages count a relative move from the target of the move before, however that one is passed, and some wait
before they read the position. The others would take a place somewhere on the way: the move before has to stop.
"""

from __future__ import annotations

from dataclasses import replace
from enum import Enum
from typing import Final

from olp.core.units import mm
from olp.ir.expressions import CallValue, SystemValue
from olp.ir.moves import BlendKind
from olp.ir.program import Move, Program, Routine, Statement
from olp.ir.transformer import calls_nothing, edited, expressions_of
from olp.transpile.abstract_walk import BETWEEN, SETTING
from olp.transpile.blends import STOP
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.current_position import systems_of

_READ: Final = frozenset({"current-pose", "current-joints"})
_STRAIGHT: Final = (
    BETWEEN
    | SETTING
    | {
        "SetSpeed",
        "SetBlend",
        "SetAcceleration",
        "SetTool",
        "SetFrame",
        "SetOverride",
        "ObeyFlags",
        "Clear",
        "If",
    }
)
_STOPS: Final = "the arm stops here, as what follows counts from where it stands"
_UNKNOWN: Final = "counts from where the arm stands: see that all moves that lead here stop at their ends"


class Lead(Enum):
    """What leads to a reading where no move that passes by does."""

    STOP = "a move that stops"
    BEGIN = "the beginning of the routine"
    OPEN = "several ways, or a routine"


def standing(program: Program, work: TranslationContext) -> Program:
    """Every move that such a reading follows with an exact stop; where that is open, the loss says so."""
    return replace(program, routines=tuple([_routine(r, program, work) for r in program.routines]))


def _routine(routine: Routine, program: Program, work: TranslationContext) -> Routine:
    body = list(routine.body)
    first = next((r for r in program.routines if r.name == program.main), program.routines[0])
    for at, s in enumerate(body):
        if not _reads(s, work):
            continue
        before = _before(body, at)
        if isinstance(before, int):
            body[before] = _stopped(body[before], work)
        elif before is Lead.OPEN or (before is Lead.BEGIN and routine is not first):
            open_ = any(isinstance(x, Move) and not _stops(x) for x in program.statements())
            if open_:
                work.lose(s, Fate.APPROXIMATED, "position", _UNKNOWN)
    return replace(routine, body=tuple(body))


def _reads(s: Statement, work: TranslationContext) -> bool:
    if isinstance(s, Move) and s.relative is not None:
        return "relative" not in work.limits.native_offsets
    waits = work.conventions.waits_before_reading and not work.target_conventions.waits_before_reading
    if not waits or calls_nothing(s):
        return False
    return any(
        (isinstance(e, SystemValue) and e.name in _READ) or systems_of(e) is not None
        for e in expressions_of(s)
    )


def _before(body: list[Statement], at: int) -> Lead | int:
    """The row of the move that always runs before row `at`, where it does not stop; else what leads there."""
    for row in range(at - 1, -1, -1):
        s = body[row]
        if isinstance(s, Move):
            return Lead.STOP if _stops(s) else row
        if type(s).__name__ not in _STRAIGHT or any(type(e) is CallValue for e in expressions_of(s)):
            return Lead.OPEN
    return Lead.BEGIN


def _stops(s: Move) -> bool:
    size = None if s.blend is None or s.blend.value is None else s.blend.value.literal
    return size is not None and size <= 0.0


def _stopped(s: Statement, work: TranslationContext) -> Statement:
    assert isinstance(s, Move)
    blend = s.blend
    size = (
        None
        if blend is None or blend.value is None or blend.kind is not BlendKind.RADIUS
        else blend.value.literal
    )
    if size is None:
        work.lose(s, Fate.APPROXIMATED, "blend", _STOPS)
    else:
        work.lose(s, Fate.APPROXIMATED, "blend", _STOPS, size / mm, "mm")
    return edited(s, {"blend": STOP})
