"""TRIGGER WHEN DISTANCE: what it does, as the statements before or behind the move that it belongs to.

"TRIGGER" (KSS 8, programming instructions for system integrators): DISTANCE=0 acts at the start point of the next
motion, DISTANCE=1 at its end point; where that point is approximated, at the end of its arc, or in the middle of it.
DELAY shifts this by milliseconds, PATH by millimetres before or behind the end point, with ONSTART the start point.
An output that is shifted stays with its move; for all else the nearer end stands, which is told. A routine that waits
or moves stays as it is.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from typing import Final

from olp.core.units import mm, ms
from olp.ir import program as st
from olp.ir.expressions import CallValue, Expression, Number, Quantity, Signal, SignalState, SystemValue, Text
from olp.ir.transformer import expressions_of
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendor import ON_THE_WAY
from olp.languages.vendors.krl.scope import Scope

_TRIGGER: Final = re.compile(
    r"TRIGGER\s+WHEN\s+(?:DISTANCE\s*=\s*(?P<at>[01])|PATH\s*=\s*(?P<path>\S.*?)(?P<start>\s+ONSTART)?)"
    r"\s+DELAY\s*=\s*(?P<delay>\S.*?)\s+DO\s+(?P<deed>.*?)"
    r"(?:\s+PRIO\s*=\s*-?\d+)?",
    re.IGNORECASE,
)
_NUMBER: Final = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)")
_QUIET: Final = (*st.MOVES_NOTHING, st.Assign, st.Process)
_HELD_UP: Final = (
    *_QUIET,
    st.SetOutput,
    st.PulseOutput,
    st.Dwell,
    st.Wait,
    st.Message,
)  # a trigger waits with these
# What takes no time.
_INSTANT: Final = (
    st.Assign, st.Comment, st.Declare, st.Begin, st.If, st.Else, st.EndIf, st.Switch, st.Case, st.Default, st.EndSwitch,
    st.Return, st.Message, st.End, st.SetOutput, st.PulseOutput,
)  # fmt: skip
_INSTANT_FUNCTIONS: Final = frozenset({"varstate"})
_CORNER: Final = "it acts as the program passes the corner, not where the arm is on its arc"
_ORDER: Final = "it runs in the order of the text, whatever the advance run has read already"
_UNKNOWN: Final = "it is called in the order of the text: no file here tells whether it waits"
_NOWHERE: Final = "it acts in the order of the text: the text does not show at which move"

NAME: Final = "trigger"
_AT: Final = "at"
_PATH: Final = "mm"
_DELAY: Final = "ms"
Find = Callable[[str], st.Routine | None]


def with_switches(body: Sequence[st.Statement]) -> tuple[st.Statement, ...]:
    """The statements with outputs that triggers switch as parts of their moves."""
    named: dict[int, list[st.PathTrigger]] = {}  # by the place of the move
    gone: set[int] = set()
    for at, s in enumerate(body):
        if type(s) is st.Process and s.name == NAME:
            move = _next_move(body, at)
            switch = None if move is None else _switch(s, body[move].line - s.line)
            if move is not None and switch is not None:
                named.setdefault(move, []).append(switch)
                gone.add(at)
    return tuple(_with_named(body, named, gone))


def _with_named(
    body: Sequence[st.Statement], named: Mapping[int, list[st.PathTrigger]], gone: Set[int]
) -> Iterator[st.Statement]:
    """`gone`: places of the statements that became parts of moves; their comments stay."""
    for at, s in enumerate(body):
        if at not in gone:
            yield replace(s, triggers=tuple(named[at])) if at in named and isinstance(s, st.Move) else s
        elif isinstance(s, st.Process) and s.comment:
            yield st.Comment(s.line, s.comment)


def _switch(s: st.Process, above: int) -> st.PathTrigger | None:
    """The output that a trigger switches, None where it does something else, or switches to what is computed."""
    given = dict(s.arguments)
    signal, value = given.get("output"), given.get("value")
    if not isinstance(signal, Signal) or not isinstance(value, (Number, SignalState)):
        return None
    if any(isinstance(given.get(name), Text) for name in (_PATH, _DELAY)):
        return None  # shifted by what the program computes
    metres, seconds = (
        Quantity(far, scale) if isinstance(far := given.get(name), Number) else None
        for name, scale in ((_PATH, mm), (_DELAY, ms))
    )
    return st.PathTrigger(signal, value, given[_AT] == Number(0), metres, seconds, above)


def with_triggers(body: Sequence[st.Statement], find: Find) -> tuple[st.Statement, ...]:
    """What triggers do as statements before and behind their moves, but for outputs at other places than an end.

    `find`: a routine by its name.
    """
    before: dict[int, list[st.Statement]] = {}  # by the place of the move
    behind: dict[int, list[st.Statement]] = {}
    gone: set[int] = set()
    for at, s in enumerate(body):
        if isinstance(s, st.Move) and s.triggers and not any(one.is_shifted for one in s.triggers):
            gone.add(at)
            for one in s.triggers:
                deed = st.SetOutput(s.line - one.above, one.signal, one.value)
                rows = _rows(deed, _is_corner(body, at, one.at_start), find, "")
                (before if one.at_start else behind).setdefault(at, []).extend(rows)
            behind.setdefault(at, []).insert(0, replace(s, triggers=()))
        elif type(s) is st.Process and s.name == NAME and (rows := _spelled(body, at, s, find)):
            gone.add(at)
            at_start = dict(s.arguments)[_AT] == Number(0)
            move = _next_move(body, at, find)
            (before if at_start else behind).setdefault(at if move is None else move, []).extend(rows)
    if not gone:
        return tuple(body)
    return tuple(
        row
        for at, s in enumerate(body)
        for row in (*before.get(at, ()), *(() if at in gone else (s,)), *behind.get(at, ()))
    )


def _spelled(body: Sequence[st.Statement], at: int, s: st.Process, find: Find) -> list[st.Statement]:
    """What stands for a trigger that switches no plain output; nothing for one that is not known here."""
    deed, move = _deed(s), _next_move(body, at, find)
    if deed is None:
        return []
    if move is None:
        return _rows(deed, False, find, _NOWHERE) if dict(s.arguments)[_AT] == Number(0) else []
    given = {name: e.value for name, e in s.arguments if isinstance(e, Number)}
    at_start = not given[_AT]
    sizes = [
        f"{abs(v):g} {unit} {'before' if v < 0 else 'behind'} it"
        for v, unit in ((given.get(_PATH, 0.0), "mm"), (given.get(_DELAY, 0.0), "ms"))
        if v
    ]
    sizes += [f"shifted by {e.value}" for name, e in s.arguments if name and isinstance(e, Text)]
    end = "start" if at_start else "end"
    says = f"it acts at the {end} of the move, not {' and '.join(sizes)}" if sizes else ""
    return _rows(deed, _is_corner(body, move, at_start), find, says)


def _is_corner(body: Sequence[st.Statement], move: int, at_start: bool) -> bool:
    """Whether the arm goes on at that end of a move."""
    return not _starts_at_rest(body, move) if at_start else not _is_exact(body[move])


def read_trigger(code: str, scope: Scope) -> st.Process:
    """The statement as it is written, with what it does as further arguments where that is known."""
    plain = st.Process(0, NAME, (("", Text(code)),))
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
        case st.SetOutput(_, signal, value):
            parts: tuple[tuple[str, Expression], ...] = (("output", signal), ("value", value))
        case st.PulseOutput(_, signal, Quantity(seconds, 1.0), None, _, ""):
            parts = (("pulse", signal), ("value", seconds))
        case st.Assign(_, target, value):
            parts = (("target", target), ("value", value))
        case st.Call(_, routine, arguments):
            parts = (("call", CallValue(routine, arguments)),)
        case _:
            return plain
    shifts = ((_PATH, match["path"] or "0"), (_DELAY, match["delay"]))
    shift: tuple[tuple[str, Expression], ...] = tuple(
        (name, Number(float(text)) if _NUMBER.fullmatch(text) else Text(text))
        for name, text in shifts
        if not _NUMBER.fullmatch(text) or float(text)
    )
    return st.Process(0, NAME, (*plain.arguments, at, *parts, *shift))


def _deed(s: st.Process) -> st.Statement | None:
    """What a trigger does; None for one that is not known here."""
    given = dict(s.arguments)
    if _AT not in given:
        return None
    match given:
        case {"output": Signal() as signal, "value": value}:
            return st.SetOutput(s.line, signal, value, s.comment)
        case {"pulse": Signal() as signal, "value": value}:
            return st.PulseOutput(s.line, signal, Quantity(value, 1.0), comment=s.comment)
        case {"call": CallValue(routine, arguments)}:
            return st.Call(s.line, routine, arguments, comment=s.comment)
        case _:
            return st.Assign(s.line, given["target"], given["value"], s.comment)


def _rows(deed: st.Statement, corner: bool, find: Find, shifted: str) -> list[st.Statement]:
    """What is written for it, nothing where that would do something else. `shifted`: by what it acts elsewhere."""
    if isinstance(deed, st.Call):
        routine = find(deed.routine)
        if routine is None:
            shifted = shifted or _UNKNOWN
        elif not _is_instant(routine, at_rest=not corner):
            return []
    why = shifted or (_CORNER if corner else _ORDER if isinstance(deed, (st.Assign, st.Call)) else "")
    if not why:
        return [deed]
    # CONTINUE: the advance run does not stop the arm for it.
    return [st.Process(deed.line, "continue", (("", Text("CONTINUE")), (ON_THE_WAY, Text(why)))), deed]


def _is_instant(routine: st.Routine, at_rest: bool) -> bool:
    """Whether a routine waits for nothing, whoever calls it where; `at_rest`: where the arm stands, signals neither."""
    stopping = SystemValue if at_rest else (Signal, SystemValue)
    return all(isinstance(s, _INSTANT) for s in routine.body) and not any(
        isinstance(e, stopping)
        or (isinstance(e, CallValue) and e.routine.casefold() not in _INSTANT_FUNCTIONS)
        for s in routine.body
        for e in expressions_of(s)
    )


def _next_move(body: Sequence[st.Statement], at: int, find: Find | None = None) -> int | None:
    """The move that a trigger belongs to; None where the text does not show it."""
    for place in range(at + 1, len(body)):
        s = body[place]
        if isinstance(s, st.Move):
            return place
        elsewhere = isinstance(s, st.Call) and find is not None and find(s.routine) is None
        if not (elsewhere or isinstance(s, _HELD_UP)):
            return None
    return None


def _starts_at_rest(body: Sequence[st.Statement], at: int) -> bool:
    """Whether the move before a statement stops at its end, and nothing between them leads here."""
    for s in reversed(body[:at]):
        if isinstance(s, st.Move):
            return _is_exact(s)
        if isinstance(s, st.Dwell):
            return True
        if not isinstance(s, (*_QUIET, st.SetOutput, st.PulseOutput)):
            return False
    return False


def _is_exact(s: st.Statement) -> bool:
    return (
        isinstance(s, st.Move)
        and s.blend is not None
        and s.blend.value is not None
        and s.blend.value.literal is not None
        and s.blend.value.literal <= 0.0
    )
