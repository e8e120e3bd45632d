"""Which statement of the source each line of a translation was made from, found from the two texts' own statements.

The writer makes no list: the translated program and the program that is read again hold the same statements in the same
order, but for what a language sets beside them. Pairs are found routine by routine and never by counting: where one of
them has a statement more, the next pair is looked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Final

from olp.ir.program import Call, Dwell, Message, Move, Pause, Program, PulseOutput, SetOutput, Statement, Wait
from olp.runtime.assumptions import NAMED_SIGNAL, SignalKey, signal_name
from olp.runtime.plan import Event

Token = tuple[object, ...]
_AHEAD: Final = 32  # statements that are looked at for the next pair
_SIGNAL: Final = "signal"


def origins_of(translated: Program, written: Iterable[Program]) -> dict[tuple[str, int], int]:
    """File and line of `written`, the files read again -> the line of the source that it was made from."""
    found: dict[tuple[str, int], int] = {}
    bodies = {routine.name.casefold(): _steps(routine.body) for routine in translated.routines}
    for program in written:
        for routine in program.routines:
            made = bodies.get(routine.name.casefold())
            for s, t in _paired(made, _steps(routine.body)) if made is not None else ():
                if s.line:
                    found.setdefault((program.path, t.line), s.line)
    return found


def _steps(body: Sequence[Statement]) -> list[tuple[Token, Statement]]:
    return [(token, s) for s in body if (token := _token(s))]


def _token(s: Statement) -> Token:
    """What a statement and its translation have in common; () for what makes no step."""
    match s:
        case Move():
            return ("move", s.path)
        case Call():
            return ("call", s.routine.casefold())
        case SetOutput() | PulseOutput():
            return (type(s).__name__, s.signal.index)
        case Dwell() | Wait() | Pause() | Message():
            return (type(s).__name__,)
        case _:
            return ()


def _paired(
    made: list[tuple[Token, Statement]], written: list[tuple[Token, Statement]]
) -> Iterable[tuple[Statement, Statement]]:
    i, j = 0, 0
    while i < len(made) and j < len(written):
        if made[i][0] == written[j][0]:
            yield made[i][1], written[j][1]
            i, j = i + 1, j + 1
            continue
        more, others = _next_pair(made, written, i, j)
        i, j = i + more, j + others


def _next_pair(
    made: list[tuple[Token, Statement]], written: list[tuple[Token, Statement]], i: int, j: int
) -> tuple[int, int]:
    """How many statements of both come before the next pair, as few as can be."""
    for total in range(1, _AHEAD):
        for more in range(total + 1):
            x, y = i + more, j + total - more
            if x < len(made) and y < len(written) and made[x][0] == written[y][0]:
                return more, total - more
    return 1, 1


# --- signals ------------------------------------------------------------------------------------------------


def signals_there(mapping: Mapping[tuple[str, str], str]) -> dict[SignalKey, SignalKey]:
    """Signals of the source -> what they are in the target, those that are called otherwise there."""
    found = {}
    for (kind, name), to in mapping.items():
        if kind != _SIGNAL:
            continue
        bus, _, shown = name.rpartition(" ")
        there, _, index = to.rpartition(" ")
        found[_key(bus, shown)] = _key(there or bus, index)
    return found


def _key(bus: str, shown: str) -> SignalKey:
    return SignalKey(bus, int(shown)) if shown.isdecimal() else SignalKey(NAMED_SIGNAL, shown.casefold())


def renamer(mapping: Mapping[tuple[str, str], str]) -> Callable[[Event], Event]:
    """Events of the source with the target's signals."""
    names = {signal_name(old): signal_name(new) for old, new in signals_there(mapping).items()}

    def renamed(event: Event) -> Event:
        signals = tuple(sorted(names.get(name, name) for name in event.signals))
        return event if signals == event.signals else event._replace(signals=signals)

    return renamed
