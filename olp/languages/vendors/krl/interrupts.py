"""INTERRUPT: what runs as soon as a condition comes true, as neutral words of a process instruction.

"INTERRUPT" (KSS 8, programming instructions for system integrators): `INTERRUPT DECL 5 WHEN $IN[3]==TRUE DO HIT()`
declares one, ON and OFF switch it, DISABLE and ENABLE put it off; without a number they mean all. Its routine runs when
the condition turns from FALSE to TRUE. BRAKE in it stops the arm, which goes on when the routine ends; RESUME gives up
the move and all routines up to the one that declared the interrupt.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Final

from lark.exceptions import UnexpectedInput

from olp.ir.expressions import CallValue, Expression, Number, SignalState, Text
from olp.ir.program import Assign, Call, Process
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendor import BEGINS, WATCH
from olp.languages.vendors.krl.scope import Scope

NAME: Final = "interrupt"
_DECLARED: Final = re.compile(
    r"(?:GLOBAL\s+)?INTERRUPT\s+(?:WITH\s+\S.*?\s+)?DECL\s+(?P<number>\d+)\s+WHEN\s+(?P<when>.*\S)\s+DO\s+(?P<do>\S.*)",
    re.IGNORECASE,
)
_SWITCHED: Final = re.compile(
    r"INTERRUPT\s+(?P<how>ON|OFF|ENABLE|DISABLE)(?:\s+(?P<number>\d+))?", re.IGNORECASE
)
_HOW: Final = {"ON": "on", "ENABLE": "on", "OFF": "off", "DISABLE": "off"}


def read_interrupt(code: str, scope: Scope) -> Process:
    """The statement as it is written, with what it says as further arguments where that is known."""
    plain = (("", Text(code)),)
    switched = _SWITCHED.fullmatch(code)
    if switched is not None:
        number = int(switched["number"] or 0)
        return Process(
            0, NAME, (*plain, (WATCH, Text(_HOW[switched["how"].upper()])), ("number", Number(number)))
        )
    declared = _DECLARED.fullmatch(code)
    if declared is None:
        return Process(0, NAME, plain)
    from olp.languages.vendors.krl.grammar import line_parser

    try:
        condition = line_parser().parse_line(f"X={declared['when']}", scope).result
        call = line_parser().parse_line(declared["do"], scope).result
    except (UnexpectedInput, BrokenLineError):
        return Process(0, NAME, plain)
    if not isinstance(condition, Assign) or not isinstance(call, Call):
        return Process(0, NAME, plain)
    more: tuple[tuple[str, Expression], ...] = (
        (WATCH, Text("declared")),
        ("number", Number(int(declared["number"]))),
        ("when", condition.value),
        ("call", CallValue(call.routine, call.arguments)),
    )
    return Process(0, NAME, (*plain, *more))


def written(s: Process, value: Callable[[Expression], str]) -> list[str]:
    """The statements that declare or switch what another language watches; none for anything else."""
    given = dict(s.arguments)
    how, number = given.get(WATCH), given.get("number")
    if not isinstance(how, Text) or not isinstance(number, Number):
        return []
    when, call = given.get("when"), given.get("call")
    if when is not None and isinstance(call, CallValue):
        begins = [f"INTERRUPT ON {number.value}"] if given.get(BEGINS) == SignalState(True) else []
        return [f"GLOBAL INTERRUPT DECL {number.value} WHEN {value(when)} DO {call.routine} ( )", *begins]
    if number.value:
        return [f"INTERRUPT {how.value.upper()} {number.value}"]
    return [f"INTERRUPT {'ENABLE' if how.value == 'on' else 'DISABLE'}"]
