"""What every name in a program stands for: where it is declared, what it holds, and whether anything changes it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, field
from typing import Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.transformer import expressions_of
from olp.languages.vendor import conventions_of


@dataclass(slots=True)
class Symbol:
    """One name. `scope`: the routine that it is local to, "" for those of the whole program.

    `assigned`: how many statements change it (by-reference arguments count); `value`: what it begins with.
    """

    name: str
    type: str
    scope: str = ""
    value: ex.Expression | None = None
    sizes: tuple[ex.Expression, ...] = ()
    storage: str = "variable"
    assigned: int = 0
    parameter: st.Parameter | None = None
    declared: bool = True

    @property
    def is_fixed(self) -> bool:
        """Whether it always holds `value`."""
        return not self.assigned and self.value is not None and self.parameter is None


@dataclass(slots=True)
class Symbols:
    """All names by (routine, name); routine "" holds the program's own."""

    table: dict[tuple[str, str], Symbol] = field(default_factory=dict)
    routines: dict[str, st.Routine] = field(default_factory=dict)
    declared: dict[str, st.Declare] = field(
        default_factory=dict
    )  # of the whole program; not asked for so far
    values_alone: bool = False  # no routine can change what it is handed
    filling: Set[str] = frozenset()  # see Conventions.filling_routines
    results: Mapping[str, str] = field(default_factory=dict)  # see Conventions.result_types

    def find(self, routine: str, name: str) -> Symbol | None:
        found = self.table.get((routine, name)) if routine else None
        if found is None:
            found = self.table.get(("", name))
        return self._asked_for(name) if found is None and name in self.declared else found

    def is_fixed(self, name: str) -> bool:
        """Whether a name of the whole program always holds what it begins with."""
        declared = self.declared.get(name)
        if declared is not None:
            return declared.value is not None
        symbol = self.find("", name)
        return symbol is not None and symbol.is_fixed

    def _asked_for(self, name: str) -> Symbol:
        """A symbol is made when somebody wants to know: most points are looked at by few passes."""
        s = self.declared.pop(name)
        found = self.table[("", name)] = Symbol(s.name, s.type, "", s.value, s.sizes, s.storage)
        return found

    def fixed_position(self, routine: str, expression: ex.Expression | None) -> ex.PositionLiteral | None:
        """The same, of a position."""
        value = self.fixed_value(routine, expression)
        return value if isinstance(value, ex.PositionLiteral) else None

    def fixed_value(self, routine: str, expression: ex.Expression | None) -> ex.Expression | None:
        """The literal that an expression always has: its own, or that of a name that nothing changes."""
        for _ in range(20):  # a name may stand for a name
            if type(expression) is ex.Item:
                return self._element(routine, expression)
            if type(expression) is not ex.Named:
                break
            name = expression.name
            declared = self.declared.get(name)
            if declared is not None and not (routine and (routine, name) in self.table):
                expression = declared.value  # nothing that changes it has been found
                continue
            symbol = self.find(routine, name)
            if symbol is None or not symbol.is_fixed:
                return None
            expression = symbol.value
        return expression if isinstance(expression, LITERALS) else None

    def _element(self, routine: str, e: ex.Item) -> ex.Expression | None:
        """The literal that an element of a constant array has."""
        array = self.fixed_value(routine, e.base)
        index = e.indices[0] if len(e.indices) == 1 else None
        if not isinstance(array, ex.RecordLiteral) or not isinstance(index, ex.Number):
            return None
        at = int(index.value) - 1
        if not 0 <= at < len(array.members) or array.members[at][0]:
            return None
        return self.fixed_value(routine, array.members[at][1])

    def __iter__(self) -> Iterator[Symbol]:
        for name in list(self.declared):
            self._asked_for(name)
        return iter(self.table.values())


LITERALS = (ex.Number, ex.Text, ex.SignalState, ex.PositionLiteral, ex.RecordLiteral)


def symbols_of(program: st.Program) -> Symbols:
    """The names of `program`. Names that are used and nowhere declared come into being where they are assigned."""
    found = Symbols({}, {routine.name: routine for routine in program.routines})
    known = conventions_of(program.vendor)
    found.values_alone, found.results = known.arguments_are_values, known.result_types
    found.filling = known.filling_routines
    declared = {declare.name: declare for declare in program.data}
    if len(declared) == len(program.data):
        found.declared = declared
    for declare in program.data if not found.declared else ():
        if declare.name in found.declared or ("", declare.name) in found.table:
            _declare(found, "", declare)
        else:
            found.declared[declare.name] = declare
    for routine in program.routines:
        for parameter in routine.parameters:
            key = (routine.name, parameter.name)
            found.table[key] = Symbol(
                parameter.name, parameter.type, routine.name, sizes=parameter.sizes, parameter=parameter
            )
        for declare in routine.data:
            _declare(found, routine.name, declare)
        for statement in routine.body if st.Declare in set(map(type, routine.body)) else ():
            if isinstance(statement, st.Declare):
                _declare(found, routine.name, statement)
    by_reference = any(p.by_reference for routine in program.routines for p in routine.parameters)
    for routine in program.routines:
        if not by_reference and _CHANGES.isdisjoint(map(type, routine.body)):
            continue
        for statement in routine.body:
            if type(statement) in _CHANGES:
                _note_changes(found, routine, statement)
            if by_reference:
                _note_called(found, routine, statement)
    return found


def _declare(found: Symbols, scope: str, s: st.Declare) -> None:
    scope = "" if s.shared else scope
    if not scope and s.name in found.declared:
        found._asked_for(s.name)
    known = found.table.get((scope, s.name))
    if known is None:
        found.table[(scope, s.name)] = Symbol(s.name, s.type, scope, s.value, s.sizes, s.storage)
    elif known.value is None:
        known.value = s.value
    elif s.value is not None:
        known.assigned += 1


_CHANGES = frozenset({st.Assign, st.Update, st.Clear, st.ReadInput, st.For, st.Call})


def base_of(target: ex.Expression | None) -> ex.Named | None:
    """The name whose value an assignment to `target` changes."""
    while isinstance(target, (ex.Item, ex.Member)):
        target = target.base
    return target if type(target) is ex.Named else None


def _note_changes(found: Symbols, routine: st.Routine, s: st.Statement) -> None:
    match s:
        case (
            st.Assign(target=target)
            | st.Update(target=target)
            | st.Clear(target=target)
            | st.ReadInput(target=target)
        ):
            value = getattr(s, "value", None)
            _changed(found, routine, target, value)
            if type(value) is ex.CallValue and value.routine not in found.routines:
                _note_unknown(found, routine, value.routine, value.arguments)
        case st.For(variable=variable):
            _changed(found, routine, variable, ex.Number(0))
        case st.Call():
            _changed(found, routine, s.result, None)
            _note_arguments(found, routine, s.routine, s.arguments)


def _note_called(found: Symbols, routine: st.Routine, s: st.Statement) -> None:
    """Variables that a function within an expression changes."""
    for expression in expressions_of(s):
        if type(expression) is ex.CallValue:
            _note_arguments(found, routine, expression.routine, expression.arguments)


def _note_arguments(
    found: Symbols, caller: st.Routine, name: str, arguments: tuple[ex.Expression, ...]
) -> None:
    called = found.routines.get(name)
    if called is None:
        _note_unknown(found, caller, name, arguments)
        return
    by_name = {p.name: p for p in called.parameters}
    positional = iter([p for p in called.parameters if not p.optional and not p.switch])
    for argument in arguments:
        if isinstance(argument, ex.NamedArgument):
            parameter, value = by_name.get(argument.name), argument.value
        else:
            parameter, value = next(positional, None), argument
        if parameter is not None and parameter.by_reference:
            _changed(found, caller, value, None)


def _note_unknown(
    found: Symbols, caller: st.Routine, called: str, arguments: tuple[ex.Expression, ...]
) -> None:
    """What a routine that is not at hand may change, where its language lets it."""
    fills = called.casefold() in found.filling
    for argument in arguments[-1:] if fills else () if found.values_alone else arguments:
        name = base_of(argument.value if isinstance(argument, ex.NamedArgument) else argument)
        symbol = found.find(caller.name, name.name) if name is not None else None
        if symbol is not None and symbol.storage != "constant":
            symbol.assigned += 1


def _changed(
    found: Symbols, routine: st.Routine, target: ex.Expression | None, value: ex.Expression | None
) -> None:
    name = base_of(target)
    if name is None:
        return
    symbol = found.find(routine.name, name.name)
    if symbol is None:
        kind = kind_of_value(found, routine.name, value) if value is not None and target is name else ""
        symbol = found.table[("", name.name)] = Symbol(name.name, kind, "", declared=False)
    elif not symbol.type and value is not None and target is name:
        symbol.type = kind_of_value(found, routine.name, value)
    symbol.assigned += 1


_POSES = ("pose-", "tool-data", "convert", "shift-between", "step-position")
_TEXTS = ("text-of-value", "joined-text", "part-of-text", "character-of-code")
_WHOLE = (
    "round",
    "trunc",
    "floor",
    "ceil",
    "length-of-text",
    "code-of-character",
    "position-in-text",
    "match-in-text",
    "find-in-text",
    "signal-number",
    "size-of-array",
)
STORED: Final = {
    ex.Store.BYTE: "integer",
    ex.Store.INTEGER: "integer",
    ex.Store.DOUBLE: "integer",
    ex.Store.REAL: "real",
    ex.Store.STRING: "string",
    ex.Store.ROBOT: "position",
}
_OF_NUMBERS: Final = ("group", "analog", "register")


def holds_number(bus: str) -> bool:
    """Whether the signals of a bus are numbers; those of the others are on or off."""
    return any(word in bus for word in _OF_NUMBERS)


def kind_of_value(found: Symbols, routine: str, e: ex.Expression | None) -> str:
    """The type of a value as `Declare.type` says it: integer, real, boolean, string, position, joints, or nothing."""
    if type(e) is ex.Named:  # nearly always
        name = e.name
        declared = found.declared.get(name)
        if declared is not None and (routine, name) not in found.table:
            return "" if declared.sizes else declared.type
        symbol = found.find(routine, name)
        return symbol.type if symbol is not None and not symbol.sizes else ""
    match e:
        case ex.Number(value):
            return "integer" if isinstance(value, int) else "real"
        case ex.Text():
            return "string"
        case (
            ex.SignalState()
            | ex.Compare()
            | ex.Logic()
            | ex.Unary("not", _)
            | ex.SystemValue("manual-reduced" | "manual-full" | "timer-running" | "timed-out")
        ):
            return "boolean"
        case ex.Function("same-text", _):
            return "boolean"
        case ex.SystemValue(name) if name in terminology.STATES:
            return "boolean"
        case ex.Signal(bus):
            return ("real" if "analog" in bus else "integer") if holds_number(bus) else "boolean"
        case ex.PositionLiteral(kind):
            return "joints" if kind == "joint" else "position"
        case ex.Item(base, _) if isinstance(base, ex.Named):
            symbol = found.find(routine, base.name)
            return "" if symbol is None else symbol.type if symbol.sizes else "real"
        case ex.Member():
            return "real"
        case ex.Variable(store):
            return STORED.get(store, "")
        case ex.CallValue(name):
            called = found.routines.get(name)
            return found.results.get(name.casefold(), "") if called is None else called.returns
        case _:
            return _computed_kind(found, routine, e)


def _computed_kind(found: Symbols, routine: str, e: ex.Expression | None) -> str:
    operator = getattr(e, "operator", "")
    if operator:
        parts = [getattr(e, name) for name in ("left", "right", "operand") if hasattr(e, name)]
        kinds = {kind_of_value(found, routine, part) for part in parts}
        if operator in ("div", "mod", "and", "or", "xor"):
            return "integer"
        if "string" in kinds:
            return "string"
        return "real" if operator == "/" or "real" in kinds else next(iter(kinds)) if len(kinds) == 1 else ""
    name = getattr(e, "name", "")
    if name == "timer-running":
        return "boolean"
    if name in ("pose-distance", "pose-element", "timer"):
        return "real"
    if name.startswith(_POSES) or name in ("current-pose", "position-pose", "forward"):
        return "position"
    if name in ("joints", "inverse", "current-joints", "position-pulse"):
        return "joints"
    if name in _TEXTS:
        return "string"
    return "integer" if name in _WHOLE else "real" if name else ""
