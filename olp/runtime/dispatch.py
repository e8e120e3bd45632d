"""Main programs that wait to be told what to do: the values that decide, where they lead, the program with one of them.

A variable decides where the main routine compares it with two constants or more, and does not compute it itself:
somebody else, a PLC or an operator, sets it. The run of such a program alone says little; each branch has a time.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Any, Final

from olp.core import result_cache
from olp.core.diagnostic import OlpError, error
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.block_structure import pair
from olp.ir.transformer import expressions_of, mapped
from olp.runtime.spelling import spell

_MOST: Final = 24  # values of one variable
_NAMED: Final = 4  # routines in a message
_CONDITIONAL: Final = (st.If, st.ElseIf, st.While, st.Jump, st.Call, st.Return, st.Wait)


@dataclass(frozen=True, slots=True)
class BranchChoice:
    """One value, and the line that asks for it."""

    value: ex.Expression
    line: int

    @property
    def name(self) -> str:
        return spell(self.value)


class NoSuchRoutineError(OlpError):
    """A file has no routine of the name that a run is to start at, or none at all: it holds data (I101)."""


@dataclass(frozen=True, slots=True)
class Dispatcher:
    """What decides in the main routine: a variable or group of inputs, the first line that asks it, and its values."""

    decides: ex.Expression
    line: int
    choices: tuple[BranchChoice, ...]

    @property
    def name(self) -> str:
        return spell(self.decides)


def main_routine(program: st.Program) -> st.Routine | None:
    """The routine that a controller starts: the one that the program names, else its first."""
    named = [r for r in program.routines if program.main and r.name.casefold() == program.main.casefold()]
    named.sort(key=lambda r: r.name != program.main)  # first the one that is spelled so
    return next(iter(named or program.routines), None)


def begun_at(program: st.Program, name: str) -> st.Program:
    """The program as it is when a reader starts the routine `name`. Raises NoSuchRoutineError (I101)
    where it holds none."""
    alike = [r.name for r in program.routines if r.name.casefold() == name.casefold()]
    found = name if name in alike else next(iter(alike), None)
    if found is None:
        others = [r.name for r in program.routines]
        close = get_close_matches(name, others, 1)
        says = f"did you mean {close[0]}?" if close else f"it has {_some(others)}" if others else ""
        raise NoSuchRoutineError(
            error("I101", f"the file has no routine {name}", file=program.path, help=says)
        )
    return replace(program, main=found, main_is_guessed=False)


def guessed(program: st.Program) -> str:
    """What is assumed by running the main routine: that the file does not say so, and what else could run; "" where the
    language or the file tells it, or nothing else could."""
    main = main_routine(program)
    if main is None or not program.main_is_guessed:
        return ""
    called = _called(program.routines)
    others = [
        r.name
        for r in program.routines
        if r is not main
        and r.name.casefold() not in called
        and not r.returns
        and all(parameter.optional for parameter in r.parameters)
    ]
    if not others:
        return ""
    says = f"{main.name} is run: the file does not say where it begins"
    return f"{says}; olp time --routine starts another ({_some(others)})"


def _called(routines: tuple[st.Routine, ...]) -> frozenset[str]:
    """The routines that something calls or starts, their names folded."""
    known = result_cache.shelf("called routines")  # a translation is proven by many runs of the same routines
    before = None if known is None else known.get(id(routines))
    if before is not None and before[0] is routines:
        names: frozenset[str] = before[1]
        return names
    found = frozenset(
        one.routine.casefold()
        for routine in routines
        for s in routine.body
        for one in (s, *expressions_of(s))
        if isinstance(one, (st.Call, st.StartTask, ex.CallValue))
    )
    if known is not None:
        known.put(id(routines), (routines, found))
    return found


def _some(names: list[str]) -> str:
    """The first names of a list."""
    return ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")


def dispatches(program: st.Program) -> tuple[Dispatcher, ...]:
    """Everything that decides in the main routine, in order of the text."""
    routine = main_routine(program)
    if routine is None:
        return ()
    asked: dict[ex.Expression, dict[ex.Expression, int]] = {}
    for decides, value, line in _questions(routine):
        asked.setdefault(decides, {}).setdefault(value, line)
    return tuple(
        Dispatcher(
            decides, min(values.values()), tuple(BranchChoice(v, n) for v, n in values.items())[:_MOST]
        )
        for decides, values in asked.items()
        if len(values) > 1 and not _is_computed(routine, decides, values)
    )


def taking(program: st.Program, dispatch: Dispatcher, choice: BranchChoice) -> st.Program:
    """The program in which what decides has this value wherever the main routine asks for it."""
    routine = main_routine(program)
    assert routine is not None

    def change(e: ex.Expression) -> ex.Expression:
        return choice.value if e == dispatch.decides else e

    def changed(s: Any) -> Any:
        if isinstance(s, st.Switch):
            return replace(s, value=mapped(s.value, change))
        if isinstance(s, st.Jump) and not isinstance(s.target, str):
            return replace(s, target=mapped(s.target, change))
        if isinstance(s, _CONDITIONAL) and s.condition is not None:
            return replace(s, condition=mapped(s.condition, change))
        return s

    steered = replace(routine, body=tuple(map(changed, routine.body)))
    return replace(program, routines=tuple(steered if r is routine else r for r in program.routines))


def _questions(routine: st.Routine) -> Iterator[tuple[ex.Expression, ex.Expression, int]]:
    """Each comparison of a variable with a constant: both, and its line."""
    flow = pair(routine.body)
    for index, s in enumerate(routine.body):
        if isinstance(s, st.Switch):
            at, marker = index, flow.after.get(index)
            while marker is not None and at < marker < len(routine.body):
                branch = routine.body[marker]
                if isinstance(branch, st.Case) and _decides(s.value):
                    yield from ((s.value, v, branch.line) for v in branch.values if _constant(v))
                at, marker = marker, flow.after.get(marker)
        elif isinstance(s, st.Jump) and not isinstance(s.target, str) and _decides(s.target):
            yield from ((s.target, ex.Number(int(name)), s.line) for name in flow.labels if name.isdecimal())
        elif isinstance(s, (st.If, st.ElseIf, st.Jump, st.Call)) and s.condition is not None:
            yield from ((of, value, s.line) for of, value in _compared(s.condition))


def _compared(condition: ex.Expression) -> Iterator[tuple[ex.Expression, ex.Expression]]:
    if isinstance(condition, ex.Logic):
        for part in (condition.first, *(part for _, part in condition.rest)):
            yield from _compared(part)
    elif isinstance(condition, ex.Compare) and condition.operator == "=":
        left, right = condition.left, condition.right
        if _constant(left):
            left, right = right, left
        if _decides(left) and _constant(right):
            yield left, right


def _decides(e: ex.Expression) -> bool:
    return isinstance(e, (ex.Variable, ex.Named, ex.Signal))


def _constant(e: ex.Expression) -> bool:
    return isinstance(e, (ex.Number, ex.Text)) or (
        isinstance(e, ex.Unary) and isinstance(e.operand, ex.Number)
    )


def _is_computed(routine: st.Routine, decides: ex.Expression, values: dict[ex.Expression, int]) -> bool:
    """Whether the main routine itself finds the value: counts it, or sets one of those that it asks for at first."""
    first = min(values.values())
    if any(_sets(s, decides) and _from_outside(s) for s in routine.body):
        return False
    for s in routine.body:
        if not _sets(s, decides):
            continue
        plain = isinstance(s, st.Assign) and isinstance(s.value, (ex.Number, ex.Text, ex.SignalState))
        if not plain or (s.line < first and isinstance(s, st.Assign) and s.value in values):
            return True
    return False


def _sets(s: st.Statement, decides: ex.Expression) -> bool:
    if isinstance(s, st.For):
        return s.variable == decides
    return isinstance(s, (st.Assign, st.Update, st.ReadInput)) and s.target == decides


def _from_outside(s: st.Statement) -> bool:
    return isinstance(s, st.ReadInput) or (
        isinstance(s, st.Assign) and isinstance(s.value, (ex.Signal, ex.CallValue))
    )
