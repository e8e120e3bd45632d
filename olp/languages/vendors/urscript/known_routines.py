"""Functions of the controller that reach outside the arm, which other languages get as calls."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Final, NamedTuple

from olp.ir.expressions import Binary, CallValue, Expression, Function, Named, NamedArgument, Number
from olp.ir.program import Assign, Call, Declare, Parameter, Process, Program, Routine, Statement
from olp.ir.transformer import calls_nothing, mapped
from olp.languages.vendors.urscript.builtins import OTHERS, RESULTS

# Settings that no routine has to make elsewhere: of the buses of this box.
SETTINGS: Final = frozenset({"modbus_set_runstate_dependent_choice", "modbus_set_signal_update_frequency"})
# Sockets, buses, registers that others read, and other programs: another controller can do the same by a routine that a
# person writes for it.
_OUTSIDE: Final = ("socket_", "modbus_", "request_", "rtde_", "read_", "write_")
REPLACEABLE: Final = frozenset(
    {
        *("dashboard_send", "ft_rtde_input_enable", "get_euromap_input", "rpc_factory", "set_euromap_output"),
        *(name for name in OTHERS - SETTINGS if name.startswith(_OUTSIDE)),
    }
)
KNOWN_ROUTINES: Final[Mapping[str, str]] = dict.fromkeys(sorted(REPLACEABLE), "a function of URScript")
# What they give is a list, of how many values they got and of these: elsewhere a routine puts them into an argument.
FILLED: Final = {
    name: RESULTS[name].removeprefix("list:")
    for name in sorted(REPLACEABLE)
    if RESULTS.get(name, "").startswith("list:")
}
FILLING: Final = frozenset(FILLED)
RESULT_TYPES: Final[Mapping[str, str]] = {
    name: RESULTS[name] for name in sorted((REPLACEABLE & RESULTS.keys()) - FILLED.keys())
}


def with_outside_calls(program: Program) -> Program:
    """The program with calls in the place of functions that reach outside the arm, arguments in the order written."""
    filled = [one for r in program.routines for s in r.body if (one := _filled(s)) is not None]
    data = tuple([_sized(mapped(d, _call_value), filled) for d in program.data])
    shared = {d.name: _room(d) for d in data}
    return replace(program, routines=tuple([_with_calls(r, shared) for r in program.routines]), data=data)


class _Filled(NamedTuple):
    """A list that a statement fills: its name, the type of its elements, and how many there may be."""

    name: str
    kind: str
    size: int


def _filled(s: Statement) -> _Filled | None:
    """The list that a statement fills by such a function, None for another one or where no size is written."""
    name = s.target.name if isinstance(s, Assign) and type(s.target) is Named else ""
    name = s.name if isinstance(s, Declare) else name
    value = s.value if isinstance(s, (Assign, Declare)) else None
    if not name or type(value) is not Function or value.name not in FILLING or not value.arguments:
        return None
    size = room_for(value)
    return None if size is None else _Filled(name, FILLED[value.name], size)


def room_for(value: Function) -> int | None:
    """How many elements the list of such a function has at most, None where no number is written."""
    count = _added(value.arguments[0]) if value.arguments else None
    return None if count is None else 1 + count


def _added(e: Expression) -> int | None:
    """A whole number, as it stands or as a sum: `1+6+1`."""
    if type(e) is Number:
        return int(e.value)
    if type(e) is not Binary or e.operator != "+":
        return None
    left, right = _added(e.left), _added(e.right)
    return None if left is None or right is None else left + right


def _sized(d: Declare, filled: Iterable[_Filled]) -> Declare:
    """The declaration with room for what such functions put into it, where nothing else says how much there is."""
    here = [one for one in filled if one.name == d.name]
    if not here or d.sizes or (d.value is not None and _filled(d) is None):
        return d
    return replace(d, type=here[0].kind, value=None, sizes=(Number(max(one.size for one in here)),))


def _room(d: Declare | Parameter) -> int:
    (size,) = d.sizes if len(d.sizes) == 1 else (None,)
    return int(size.value) if type(size) is Number else 0


def _with_calls(routine: Routine, shared: Mapping[str, int]) -> Routine:
    filled = [one for s in routine.body if (one := _filled(s)) is not None]
    room = {**shared, **{p.name: _room(p) for p in routine.parameters}}
    rows: list[Statement] = []
    for s in routine.body:
        if isinstance(s, Declare):
            declared = _sized(mapped(s, _call_value), filled)
            room[s.name] = _room(declared)
            rows.append(declared)
            if declared.value is not None or _filled(s) is None:
                continue
        rows.append(_as_call(s, room))
    return replace(routine, body=tuple(rows))


def _as_call(s: Statement, room: Mapping[str, int]) -> Statement:
    if not calls_nothing(s):
        s = mapped(s, _call_value)
    if isinstance(s, Process) and s.name in REPLACEABLE:
        return Call(s.line, s.name, tuple(value for _, value in s.arguments), comment=s.comment)
    found = _filled(s)
    if found is None or room.get(found.name, 0) < found.size:
        return s
    assert isinstance(s, (Assign, Declare))
    assert isinstance(s.value, Function)
    return Call(s.line, s.value.name, (*_in_order(s.value.arguments), Named(found.name)), comment=s.comment)


def _call_value(e: Expression) -> Expression:
    if type(e) is not Function or e.name not in REPLACEABLE or e.name in FILLED:
        return e
    return CallValue(e.name, _in_order(e.arguments))


def _in_order(given: tuple[Expression, ...]) -> tuple[Expression, ...]:
    return tuple((a.value or a) if isinstance(a, NamedArgument) else a for a in given)
