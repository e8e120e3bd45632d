"""TRIGGER WHEN DISTANCE: what it does, as the statements before or behind the move that it belongs to.

"TRIGGER" (KSS 8, programming instructions for system integrators): DISTANCE=0 acts at the start point of the next
motion, DISTANCE=1 at its end point; where that point is approximated, at the end of its arc, or in the middle of it.
DELAY shifts this by milliseconds, PATH by millimetres before or behind the end point, with ONSTART the start point: the
nearer end stands for it, which is told. A routine that waits or moves stays as it is.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Final

from olp.ir.expressions import CallValue, Expression, Number, Quantity, Signal, SystemValue, Text
from olp.ir.moves import Move, SetAcceleration, SetBlend, SetFrame, SetSpeed, SetTool
from olp.ir.program import Routine
from olp.ir.statements import (
    Assign,
    Begin,
    Call,
    Case,
    Comment,
    Declare,
    Default,
    Else,
    End,
    EndIf,
    EndSwitch,
    If,
    Message,
    Process,
    PulseOutput,
    Return,
    SetOutput,
    Statement,
    Switch,
)
from olp.ir.transformer import expressions_of
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendor import ON_THE_WAY
from olp.languages.vendors.krl.scope import Scope

_TRIGGER: Final = re.compile(
    r"TRIGGER\s+WHEN\s+(?:DISTANCE\s*=\s*(?P<at>[01])|PATH\s*=\s*(?P<path>[-+]?[\d.]+)(?P<start>\s+ONSTART)?)"
    r"\s+DELAY\s*=\s*(?P<delay>[-+]?[\d.]+)\s+DO\s+(?P<deed>.*?)"
    r"(?:\s+PRIO\s*=\s*-?\d+)?",
    re.IGNORECASE,
)
_QUIET: Final = (
    Comment,
    Declare,
    Begin,
    SetSpeed,
    SetBlend,
    SetAcceleration,
    SetTool,
    SetFrame,
    Assign,
    Process,
)
# What takes no time.
_INSTANT: Final = (
    Assign, Comment, Declare, Begin, If, Else, EndIf, Switch, Case, Default, EndSwitch, Return, Message, End,
    SetOutput, PulseOutput,
)  # fmt: skip
_INSTANT_FUNCTIONS: Final = frozenset({"varstate"})
_CORNER: Final = "it acts as the program passes the corner, not where the arm is on its arc"
_ORDER: Final = "it runs in the order of the text, whatever the advance run has read already"

NAME: Final = "trigger"
_AT: Final = "at"
_SHIFTED: Final = "shifted"
Find = Callable[[str], Routine | None]


def with_triggers(body: Sequence[Statement], find: Find) -> tuple[Statement, ...]:
    """The statements with triggers as what they do, before and behind their moves. `find`: a routine by its name."""
    before: dict[int, list[Statement]] = {}  # by the place of the move
    behind: dict[int, list[Statement]] = {}
    gone: set[int] = set()
    for at, s in enumerate(body):
        found = _deed(s) if type(s) is Process and s.name == NAME else None
        move = _next_move(body, at) if found is not None else None
        if found is None or move is None:
            continue
        at_end, deed = found
        corner = not _is_exact(body[move]) if at_end else not _starts_at_rest(body, at)
        shifted = dict(s.arguments).get(_SHIFTED) if type(s) is Process else None
        rows = _rows(deed, corner, find, shifted.value if isinstance(shifted, Text) else "")
        if rows:
            gone.add(at)
            (behind if at_end else before).setdefault(move, []).extend(rows)
    if not gone:
        return tuple(body)
    return tuple(
        one
        for at, s in enumerate(body)
        for one in (*before.get(at, ()), *(() if at in gone else (s,)), *behind.get(at, ()))
    )


def read_trigger(code: str, scope: Scope) -> Process:
    """The statement as it is written, with what it does as further arguments where that is known."""
    plain = Process(0, NAME, (("", Text(code)),))
    match = _TRIGGER.fullmatch(code)
    if match is None:
        return plain
    from lark.exceptions import UnexpectedInput

    from olp.languages.vendors.krl.grammar import line_parser

    try:
        deed = line_parser().parse_line(match["deed"], scope).result
    except (UnexpectedInput, BrokenLineError):
        return plain
    end = match["at"] == "1" if match["at"] else not match["start"]
    at = (_AT, Number(int(end)))
    match deed:
        case SetOutput(_, signal, value):
            parts: tuple[tuple[str, Expression], ...] = (("output", signal), ("value", value))
        case PulseOutput(_, signal, Quantity(seconds, 1.0), None, _, ""):
            parts = (("pulse", signal), ("value", seconds))
        case Assign(_, target, value):
            parts = (("target", target), ("value", value))
        case Call(_, routine, arguments):
            parts = (("call", CallValue(routine, arguments)),)
        case _:
            return plain
    shift = _shift(match, end)
    shifted = ((_SHIFTED, Text(shift)),) if shift else ()
    return Process(0, NAME, (*plain.arguments, at, *parts, *shifted))


def _shift(match: re.Match[str], end: bool) -> str:
    """By what it does not act at an end of its move, as the receipt says it."""
    path, delay = float(match["path"] or 0), float(match["delay"])
    sizes = [
        f"{abs(v):g} {unit} {'before' if v < 0 else 'behind'} it"
        for v, unit in ((path, "mm"), (delay, "ms"))
        if v
    ]
    if not sizes:
        return ""
    return f"it acts at the {'end' if end else 'start'} of the move, not {' and '.join(sizes)}"


def _deed(s: Process) -> tuple[bool, Statement] | None:
    """Whether a trigger acts at the end of its move, and what it does; None for one that is not known here."""
    given = dict(s.arguments)
    at = given.get(_AT)
    if at is None:
        return None
    deed: Statement
    match given:
        case {"output": Signal() as signal, "value": value}:
            deed = SetOutput(s.line, signal, value, s.comment)
        case {"pulse": Signal() as signal, "value": value}:
            deed = PulseOutput(s.line, signal, Quantity(value, 1.0), comment=s.comment)
        case {"call": CallValue(routine, arguments)}:
            deed = Call(s.line, routine, arguments, comment=s.comment)
        case _:
            deed = Assign(s.line, given["target"], given["value"], s.comment)
    return at == Number(1), deed


def _rows(deed: Statement, corner: bool, find: Find, shifted: str) -> list[Statement]:
    """What is written for it, nothing where that would do something else. `shifted`: by what it acts elsewhere."""
    if isinstance(deed, Call):
        routine = find(deed.routine)
        if routine is None or not _is_instant(routine, at_rest=not corner):
            return []
    why = shifted or (_CORNER if corner else _ORDER if isinstance(deed, (Assign, Call)) else "")
    if not why:
        return [deed]
    # CONTINUE: the advance run does not stop the arm for it.
    return [Process(deed.line, "continue", (("", Text("CONTINUE")), (ON_THE_WAY, Text(why)))), deed]


def _is_instant(routine: Routine, at_rest: bool) -> bool:
    """Whether a routine waits for nothing, whoever calls it where; `at_rest`: where the arm stands, signals neither."""
    stopping = SystemValue if at_rest else (Signal, SystemValue)
    return all(isinstance(s, _INSTANT) for s in routine.body) and not any(
        isinstance(e, stopping)
        or (isinstance(e, CallValue) and e.routine.casefold() not in _INSTANT_FUNCTIONS)
        for s in routine.body
        for e in expressions_of(s)
    )


def _next_move(body: Sequence[Statement], at: int) -> int | None:
    for place in range(at + 1, len(body)):
        s = body[place]
        if isinstance(s, Move):
            return place
        if not isinstance(s, _QUIET):
            return None
    return None


def _starts_at_rest(body: Sequence[Statement], at: int) -> bool:
    """Whether the move before a statement stops at its end, and nothing between them leads here."""
    for s in reversed(body[:at]):
        if isinstance(s, Move):
            return _is_exact(s)
        if not isinstance(s, (*_QUIET, SetOutput, PulseOutput)):
            return False
    return False


def _is_exact(s: Statement) -> bool:
    return (
        isinstance(s, Move)
        and s.blend is not None
        and s.blend.value is not None
        and s.blend.value.literal is not None
        and s.blend.value.literal <= 0.0
    )
