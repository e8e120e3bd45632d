"""Parameters that a caller may leave out (RAPID's `\\num x`, `\\switch x`), where every argument has its place.

A flag stands before each that says whether it is given, which is what Present asks; a switch is its own flag.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from olp.ir.expressions import (
    CallValue,
    Expression,
    Function,
    Named,
    NamedArgument,
    Number,
    SignalState,
    Text,
)
from olp.ir.program import Call, Parameter, Program, Routine, Statement
from olp.ir.transformer import mapped
from olp.transpile.context import TranslationContext

# What stands for an argument that is left out, by its type: nothing reads it.
_UNREAD: Final[Mapping[str, Expression]] = {
    "real": Number(0),
    "integer": Number(0),
    "boolean": SignalState(False),
    "string": Text(""),
}
_PASSED_ON: Final = "?"  # behind the name of an argument that is given where the caller's own one is
_GIVEN: Final = "given"


@dataclass(frozen=True, slots=True)
class _Head:
    """A routine's parameters and their flags: name, case folded -> the flag's name; a switch's is its own."""

    parameters: tuple[Parameter, ...]
    flags: Mapping[str, str] = field(default_factory=dict)


def optional_parameters(program: Program, work: TranslationContext) -> Program:
    """Every routine with required parameters alone. Options of other types, or by reference, stay as they are."""
    heads = {
        routine.name.casefold(): _head(routine, work) for routine in program.routines if _is_plain(routine)
    }
    if not heads:
        return program
    return replace(program, routines=tuple(_routine(routine, heads) for routine in program.routines))


def _is_optional(p: Parameter) -> bool:
    return p.switch or (p.optional and p.default is None)


def _is_plain(routine: Routine) -> bool:
    options = [p for p in routine.parameters if _is_optional(p)]
    return bool(options) and all(
        p.switch or (p.type in _UNREAD and not p.by_reference and "{" not in p.native) for p in options
    )


def _head(routine: Routine, work: TranslationContext) -> _Head:
    flags = {
        p.name.casefold(): p.name if p.switch else work.fresh(f"{p.name}_given")
        for p in routine.parameters
        if _is_optional(p)
    }
    return _Head(routine.parameters, flags)


def _routine(routine: Routine, heads: Mapping[str, _Head]) -> Routine:
    own = heads.get(routine.name.casefold(), _Head(routine.parameters))
    names = {p.name.casefold() for p in routine.parameters}

    def change(e: Expression) -> Expression:
        if type(e) is CallValue and e.routine.casefold() in heads:
            return replace(e, arguments=_arguments(e.arguments, heads[e.routine.casefold()], own))
        if type(e) is Function and e.name == _GIVEN and type(e.arguments[0]) is Named:
            asked = e.arguments[0].name.casefold()
            if asked in own.flags:
                return Named(own.flags[asked])
            return SignalState(True) if asked in names else e
        return e

    def row(s: Statement) -> Statement:
        s = mapped(s, change)
        if isinstance(s, Call) and s.routine.casefold() in heads:
            return replace(s, arguments=_arguments(s.arguments, heads[s.routine.casefold()], own))
        return s

    parameters: list[Parameter] = []
    for p in routine.parameters:
        flag = own.flags.get(p.name.casefold())
        if flag is None:
            parameters.append(p)
            continue
        parameters.append(Parameter(flag, "boolean"))
        if not p.switch:
            parameters.append(replace(p, optional=False))
    return replace(routine, body=tuple(map(row, routine.body)), parameters=tuple(parameters))


def _arguments(given: tuple[Expression, ...], head: _Head, caller: _Head) -> tuple[Expression, ...]:
    """The arguments of a call, each in its place."""
    by_name = {a.name.casefold(): a for a in given if isinstance(a, NamedArgument)}
    positional = iter([a for a in given if not isinstance(a, NamedArgument)])
    found: list[Expression] = []
    for p in head.parameters:
        key = p.name.casefold()
        if key not in head.flags:
            found += [a for a in (next(positional, None),) if a is not None]
            continue
        named, passed = by_name.get(key), by_name.get(key + _PASSED_ON)
        if passed is not None and type(passed.value) is Named:
            flag: Expression = Named(caller.flags.get(passed.value.name.casefold(), passed.value.name))
            value: Expression = passed.value
        else:
            flag = SignalState(named is not None)
            value = _UNREAD.get(p.type, flag) if named is None or named.value is None else named.value
        found += [flag] if p.switch else [flag, value]
    return tuple(found)
