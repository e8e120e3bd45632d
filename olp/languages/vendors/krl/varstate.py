"""`VARSTATE("P") == #INITIALIZED`: whether a routine was handed a parameter, as the calls of the program tell it.

VARSTATE tells #DECLARED, #INITIALIZED or #UNKNOWN of a variable; a parameter that a call leaves out is not
initialized until the routine sets it (KSS 8, programming instructions for system integrators, "VARSTATE()").
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from olp.ir.expressions import CallValue, Compare, Expression, Named, SignalState, Text, Unary, Unknown
from olp.ir.program import Program, Routine
from olp.ir.statements import Assign, Call, Statement
from olp.ir.transformer import calls_nothing, expressions_of, mapped, sets_numbers

_ASKS: Final = "varstate"
_GIVEN: Final = "#INITIALIZED"


def with_given_parameters(program: Program) -> Program:
    """The program with what all its calls decide alike as TRUE or FALSE."""
    if not any(_is_asked(s) for s in program.statements()):
        return program
    calls: dict[str, list[tuple[Expression, ...]]] = {}
    for s in program.statements():
        for routine, arguments in _calls(s):
            calls.setdefault(routine.casefold(), []).append(arguments)
    routines = tuple(_decided(r, calls.get(r.name.casefold(), [])) for r in program.routines)
    return replace(program, routines=routines)


def _decided(routine: Routine, calls: list[tuple[Expression, ...]]) -> Routine:
    if not calls or not routine.parameters or not any(map(_is_asked, routine.body)):
        return routine
    given: dict[str, set[bool]] = {
        p.name.casefold(): {at < len(one) and type(one[at]) is not Unknown for one in calls}
        for at, p in enumerate(routine.parameters)
    }

    def change(e: Expression) -> Expression:
        if type(e) is Unary and e.operator == "not" and type(e.operand) is SignalState:
            return SignalState(not e.operand.on)
        if not (type(e) is Compare and e.operator in ("=", "<>")):
            return e
        match e.left, e.right:
            case CallValue(name, (Text(of),)), Text(state) if name.casefold() == _ASKS:
                known = given.get(of.casefold(), set())
                if state.upper() == _GIVEN and len(known) == 1:
                    return SignalState((True in known) == (e.operator == "="))
        return e

    rows: list[Statement] = []
    for s in routine.body:
        rows.append(mapped(s, change) if _is_asked(s) else s)
        if isinstance(s, Assign) and isinstance(s.target, Named) and s.target.name.casefold() in given:
            given[s.target.name.casefold()].add(True)  # from here on some way may have set it
    return replace(routine, body=tuple(rows))


def _is_asked(s: Statement) -> bool:
    return not (calls_nothing(s) or sets_numbers(s)) and any(
        type(e) is CallValue and e.routine.casefold() == _ASKS for e in expressions_of(s)
    )


def _calls(s: Statement) -> Iterator[tuple[str, tuple[Expression, ...]]]:
    if isinstance(s, Call):
        yield s.routine, s.arguments
    if not (calls_nothing(s) or sets_numbers(s)):
        for e in expressions_of(s):
            if type(e) is CallValue:
                yield e.routine, e.arguments
