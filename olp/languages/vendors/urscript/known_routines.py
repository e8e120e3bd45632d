"""Functions of the controller that reach outside the arm, which other languages get as calls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from olp.ir.expressions import CallValue, Expression, Function, NamedArgument
from olp.ir.program import Call, Process, Program, Statement
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
RESULT_TYPES: Final[Mapping[str, str]] = {
    name: RESULTS[name] for name in sorted(REPLACEABLE & RESULTS.keys())
}
# What they give is a list, which no routine of another language gives back.
_LISTS: Final = frozenset({"socket_read_ascii_float", "socket_read_binary_integer", "socket_read_byte_list"})


def with_outside_calls(program: Program) -> Program:
    """The program with calls in the place of functions that reach outside the arm, arguments in the order written."""
    routines = [replace(r, body=tuple([_as_call(s) for s in r.body])) for r in program.routines]
    data = tuple([mapped(d, _call_value) for d in program.data])
    return replace(program, routines=tuple(routines), data=data)


def _as_call(s: Statement) -> Statement:
    if not calls_nothing(s):
        s = mapped(s, _call_value)
    if isinstance(s, Process) and s.name in REPLACEABLE:
        return Call(s.line, s.name, tuple(value for _, value in s.arguments), comment=s.comment)
    return s


def _call_value(e: Expression) -> Expression:
    if type(e) is not Function or e.name not in REPLACEABLE - _LISTS:
        return e
    given = tuple((a.value or a) if isinstance(a, NamedArgument) else a for a in e.arguments)
    return CallValue(e.name, given)
