"""Values of the type that a typed target asks for: numbers and states of signals, poses and joint values are two there.

Some languages hold a signal's state in a number and joint values in a position, others take an input for a boolean. A
compiler of KRL or RAPID refuses such a line when the program is loaded. RAPID's tools and frames are persistent and
stand in the module, never in a routine.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Final, TypeGuard, TypeVar

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.transformer import (
    calls_nothing,
    changed_by,
    edited,
    expressions_of,
    mapped,
)
from olp.languages.limits import ValueTypes
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.first_values import UNDECLARED
from olp.transpile.implicit_declarations import ASKS
from olp.transpile.name_types import NUMERIC_FUNCTIONS, taken
from olp.transpile.occurrences import changed_rare, with_rare_rows, with_routines, with_rows
from olp.transpile.shared_variables import paired
from olp.transpile.symbols import Symbols, kind_of_value, symbols_of

_NUMBERS: Final = frozenset({"integer", "real"})
_PLACES: Final = frozenset({"position", "joints"})
_LITERALS: Final = frozenset(
    {ex.Number, ex.Text, ex.SignalState, ex.PositionLiteral, ex.RecordLiteral, ex.Unary, ex.Binary}
)
_MODULE_DATA: Final = frozenset({"tool", "frame"})
# What no language converts into one another, in a receipt's words.
_FAMILIES: Final = {
    "integer": "numbers",
    "real": "numbers",
    "boolean": "numbers",
    "string": "texts",
    "position": "positions",
    "joints": "positions",
    "tool": "positions",
    "frame": "positions",
    "list": "lists",
}
_S = TypeVar("_S", bound=st.Statement)
_NOTHING: Final = ex.PositionLiteral("pose", (0.0,) * 6)


def typed_values(program: st.Program, work: TranslationContext) -> st.Program:
    """For a typed target: every value as what takes it wants it. Elsewhere no text becomes a number, or the reverse."""
    types = work.limits.value_types
    if types is None:
        return program if work.source.vendor == work.target else _texts_apart(program, work)
    if types.persistent_systems:
        program = _systems_in_the_module(_places_apart(program, work), work)
    own = _Typing(types, work.symbols(program), work)
    routines = []
    for routine in program.routines:
        own.asked.clear()
        routines.append(with_rare_rows(routine, work.look(routine), partial(own.statement, routine.name)))
    program = with_routines(program, routines)
    return replace(program, data=(*program.data, *own.unused.values())) if own.unused else program


def _texts_apart(program: st.Program, work: TranslationContext) -> st.Program:
    """Refuses what sets or compares a text with a number, which each language converts in its own way, if at all."""
    own = _Typing(ValueTypes(signals_are_states=False), work.symbols(program), work)
    for routine in program.routines:
        for _, s in work.look(routine).rare:
            says = own.unlike(routine.name, s) if isinstance(s, st.Assign) else ""
            compared = (e for e in expressions_of(s) if isinstance(e, ex.Compare))
            says = says or next(filter(None, (own.unlike_sides(routine.name, e) for e in compared)), "")
            if "texts" in says:
                work.lose(s, Fate.REFUSED, "statement", says)
    return program


def digital_states(program: st.Program, work: TranslationContext) -> st.Program:
    """Digital signals with ON and OFF where the source has 1 and 0; compared with another number they are refused."""

    def compared(e: ex.Expression) -> ex.Expression:
        if type(e) is not ex.Compare or e.operator not in ("=", "<>"):
            return e
        left, right = e.left, e.right
        if type(right) is ex.SignalState and (
            type(left) in (ex.Compare, ex.Logic) or (type(left) is ex.Unary and left.operator == "not")
        ):  # no condition there is compared with a state
            return left if right.on is (e.operator == "=") else ex.Unary("not", left)
        if _is_bit(left) and type(right) is ex.Number and right.value in (0, 1):
            return replace(e, right=ex.SignalState(right.value == 1))
        if _is_bit(right) and type(left) is ex.Number and left.value in (0, 1):
            return replace(e, left=ex.SignalState(left.value == 1))
        return e

    def change(s: st.Statement) -> st.Statement:
        s = mapped(s, compared)
        for e in expressions_of(s):
            number = _number_of_a_bit(e) if type(e) is ex.Compare else None
            if number is not None:
                work.lose(s, Fate.REFUSED, "condition", f"a digital signal compared with {number.value:g}")
        if isinstance(s, st.SetOutput) and _is_digital(s.signal) and type(s.value) is ex.Number:
            return replace(s, value=ex.SignalState(s.value.value != 0))
        return s

    return with_routines(program, [changed_rare(r, work.look(r), change) for r in program.routines])


def _is_bit(e: ex.Expression) -> bool:
    return type(e) is ex.Signal and _is_digital(e)


def _number_of_a_bit(e: ex.Compare) -> ex.Number | None:
    """The number that a digital signal is compared with."""
    for signal, other in ((e.left, e.right), (e.right, e.left)):
        if _is_bit(signal) and type(other) is ex.Number:
            return other
    return None


@dataclass(slots=True)
class _Typing:
    """`unused`: what takes the results of functions that are called for what they do, by type; `asked`: the types of
    what open SWITCH statements ask.
    """

    types: ValueTypes
    symbols: Symbols
    work: TranslationContext
    unused: dict[str, st.Declare] = field(default_factory=dict)
    asked: list[str] = field(default_factory=list)

    def statement(self, routine: str, s: st.Statement) -> list[st.Statement]:
        if not isinstance(s, (st.Move, st.Declare)):
            s = mapped(s, lambda e: self._handed(routine, self._compared(routine, e)))
        self._refuse_misuse(routine, s)
        if isinstance(s, st.Declare):
            return self._begun(routine, s)
        if isinstance(s, st.Message):
            return [replace(s, text=self._as_text(routine, s.text))]
        if isinstance(s, st.Assign):
            return self._assigned(routine, s, self._kind(routine, s.target))
        if isinstance(s, st.Return) and s.value is not None:
            own = self.symbols.routines.get(routine)
            return self._assigned(routine, s, "" if own is None else own.returns)
        if isinstance(s, st.Call):
            return [self._called(routine, s)]
        if isinstance(s, st.Move) and s.triggers and self.types.signals_are_states:
            return [replace(s, triggers=tuple(self._trigger(routine, one) for one in s.triggers))]
        if isinstance(s, st.SetOutput) and _is_digital(s.signal) and self.types.signals_are_states:
            return [replace(s, value=self._as_state(routine, s.value))]
        return [s]

    def _trigger(self, routine: str, one: st.PathTrigger) -> st.PathTrigger:
        return one._replace(value=self._as_state(routine, one.value)) if _is_digital(one.signal) else one

    def _begun(self, routine: str, s: st.Declare) -> list[st.Statement]:
        """A variable that begins with what is computed is set where it was declared."""
        if s.value is None or s.storage != "variable" or _is_written(s.value):
            return [s]
        begins = st.Assign(s.line, ex.Named(s.name), s.value, s.comment)
        return [replace(s, value=None, comment=""), *self.statement(routine, begins)]

    def _called(self, routine: str, s: st.Call) -> st.Call:
        """A call whose arguments are of the types that are asked for, and whose result goes somewhere."""
        arguments = tuple(self._argument(routine, one) for one in s.arguments)
        called = self.symbols.routines.get(s.routine) if self.types.results_are_used else None
        if called is None or not called.returns or s.result is not None or s.jump:
            return replace(s, arguments=arguments)
        kind = called.returns
        if kind not in self.unused:
            self.unused[kind] = st.Declare(0, self.work.helper(f"unused_{kind}"), kind, shared=True)
        return replace(s, arguments=arguments, result=ex.Named(self.unused[kind].name))

    def _handed(self, routine: str, e: ex.Expression) -> ex.Expression:
        if type(e) is ex.Function and e.name == _JOINED:
            return replace(e, arguments=tuple(self._as_text(routine, one) for one in e.arguments))
        if type(e) is not ex.CallValue or not e.arguments:
            return e
        return replace(e, arguments=tuple(self._argument(routine, one) for one in e.arguments))

    def _as_text(self, routine: str, e: ex.Expression) -> ex.Expression:
        """What is shown; a variable that is a number for want of a declaration was no number to `displayed_values`."""
        return ex.Function(AS_TEXT, (e,)) if self._certain(routine, e) in _NUMBERS else e

    def _argument(self, routine: str, e: ex.Expression) -> ex.Expression:
        return ex.Compare("=", e, ex.SignalState(True)) if self._kind(routine, e) == "signal" else e

    def _assigned(self, routine: str, s: st.Assign | st.Return, wanted: str) -> list[st.Statement]:
        """A statement whose value is of the type `wanted`."""
        given = self._kind(routine, s.value)
        if says := self.unlike(routine, s, wanted):
            self.work.lose(s, Fate.REFUSED, "statement", says)
            return [s]
        if wanted == given or not wanted or not given or s.value is None:
            return [s]
        if wanted == "boolean" and given == "signal":
            return [replace(s, value=ex.Compare("=", s.value, ex.SignalState(True)))]
        if wanted == "boolean" and given in _NUMBERS:
            return [replace(s, value=_not_zero(s.value))]
        if wanted in _NUMBERS and type(s.value) is ex.SignalState:
            return [replace(s, value=ex.Number(int(s.value.on)))]
        if wanted in _NUMBERS and given == "boolean":
            test = (
                s.value
                if not isinstance(s.value, ex.Signal)
                else ex.Compare("=", s.value, ex.SignalState(True))
            )
            on, off = (replace(s, value=ex.Number(n), comment="") for n in (1, 0))
            return [st.If(s.line, test, s.comment), on, st.Else(s.line), off, st.EndIf(s.line)]
        if {wanted, given} == _PLACES:
            says = "joint values and a pose in one variable: the target has a type for each"
            self.work.lose(s, Fate.REFUSED, "statement", says)
        return [s]

    def unlike(self, routine: str, s: st.Assign | st.Return, wanted: str = "") -> str:
        """What is wrong with a value of another family than what takes it, of the type `wanted` where that returns."""
        takes = self._certain(routine, s.target) if isinstance(s, st.Assign) else wanted
        sure = "list" if isinstance(s.value, ex.RecordLiteral) else self._certain(routine, s.value)
        if not _differ(takes, sure):
            return ""
        return f"{_FAMILIES[sure]} in a variable of {_FAMILIES[takes]}: the target has a type for each"

    def unlike_sides(self, routine: str, e: ex.Compare) -> str:
        left, right = self._certain(routine, e.left), self._certain(routine, e.right)
        return _compared_families(left, right) if _differ(left, right) else ""

    def _certain(self, routine: str, e: ex.Expression | None) -> str:
        """As `kind_of_value`, "" where that takes a type for granted: of members, system values, most functions."""
        kind = kind_of_value(self.symbols, routine, e)
        granted = (
            isinstance(e, (ex.Member, ex.SystemValue))
            or (isinstance(e, ex.Item) and not self._sizes(routine, e))
            or (isinstance(e, ex.Function) and e.name not in NUMERIC_FUNCTIONS)
        )
        return "" if kind == "real" and granted else kind

    def _sizes(self, routine: str, e: ex.Item) -> tuple[ex.Expression, ...]:
        """The declared sizes of what an element is of, () where none are known."""
        symbol = self.symbols.find(routine, e.base.name) if isinstance(e.base, ex.Named) else None
        return () if symbol is None else symbol.sizes

    def _refuse_misuse(self, routine: str, s: st.Statement) -> None:
        """Refuses a statement that uses a value as what it is not: a text as a number, a number as an array."""
        called = self._hands_others(routine, s) if isinstance(s, st.Call) else self._chosen(routine, s)
        misused = (self._misused(routine, e) for e in expressions_of(s))
        if says := called or next(filter(None, misused), ""):
            self.work.lose(s, Fate.REFUSED, "statement", says)

    def _chosen(self, routine: str, s: st.Statement) -> str:
        """A case of another kind than what its SWITCH asks."""
        if isinstance(s, st.Switch):
            self.asked.append(self._certain(routine, s.value))
        elif isinstance(s, st.EndSwitch) and self.asked:
            self.asked.pop()
        elif isinstance(s, st.Case) and self.asked:
            cases = (self._certain(routine, one) for one in s.values)
            return next(
                (_compared_families(self.asked[-1], one) for one in cases if _differ(self.asked[-1], one)), ""
            )
        return ""

    def _misused(self, routine: str, e: ex.Expression) -> str:
        if isinstance(e, ex.Function):
            wanted = taken(e.name, len(e.arguments))
            given = [self._certain(routine, one) for one in e.arguments]
            pairs = ((w, g) for w, g in zip(wanted, given, strict=True) if _differ(w, g))
            return next((f"{e.name} of {_FAMILIES[g]}, where it takes {_FAMILIES[w]}" for w, g in pairs), "")
        if isinstance(e, (ex.Binary, ex.Unary, ex.Logic)):
            word, sides = _operands(e)
            families = {_FAMILIES.get(self._certain(routine, one), "") for one in sides}
            if "positions" in families or ("texts" in families and not isinstance(e, ex.Binary)):
                return f"the operator {word} on {'positions' if 'positions' in families else 'texts'}"
        if isinstance(e, ex.Compare):
            return self.unlike_sides(routine, e)
        if isinstance(e, ex.CallValue):
            return self._hands_others(routine, e)
        return ""

    def _hands_others(self, routine: str, call: st.Call | ex.CallValue) -> str:
        called = self.symbols.routines.get(call.routine)
        if called is None:
            return ""
        if len(call.arguments) > len(called.parameters):
            return f"{call.routine} with {len(call.arguments)} arguments, which has {len(called.parameters)}"
        rows = {p.name for p in called.parameters if p.sizes}
        types = {p.name: p.type for p in called.parameters if not p.sizes}
        for name, one in paired(called.parameters, call.arguments):
            single = self._is_single(routine, one)
            if single is not None and single == (name in rows):
                other = (
                    "one value, where it takes an array" if single else "an array, where it takes one value"
                )
                return f"{call.routine} with {other}"
            wanted, given = types.get(name, ""), self._certain(routine, one)
            if _differ(wanted, given):
                return f"{call.routine} with {_FAMILIES[given]}, where it takes {_FAMILIES[wanted]}"
        return ""

    def _is_single(self, routine: str, e: ex.Expression | None) -> bool | None:
        """Whether a variable is declared without indices, None of what is no variable of a known type."""
        symbol = self.symbols.find(routine, e.name) if type(e) is ex.Named else None
        if symbol is None or not symbol.declared or symbol.type not in _FAMILIES or symbol.type == "list":
            return None
        listed = isinstance(symbol.value, ex.RecordLiteral) and not symbol.sizes
        return None if listed or isinstance(symbol.value, ex.Named) else not symbol.sizes

    def _kind(self, routine: str, e: ex.Expression | None) -> str:
        """As `kind_of_value`; "signal" for the state of one where that is a number and still no plain one."""
        if isinstance(e, ex.Signal) and _is_digital(e) and not self.types.signals_are_states:
            return "signal"
        return kind_of_value(self.symbols, routine, e)

    def _as_state(self, routine: str, e: ex.Expression) -> ex.Expression:
        if isinstance(e, ex.Number):
            return ex.SignalState(e.value != 0)
        return _not_zero(e) if kind_of_value(self.symbols, routine, e) in _NUMBERS else e

    def _compared(self, routine: str, e: ex.Expression) -> ex.Expression:
        """Both sides of a comparison as one type."""
        if not isinstance(e, ex.Compare) or e.operator not in ("=", "<>"):
            return e
        kinds = self._kind(routine, e.left), self._kind(routine, e.right)
        if (
            set(kinds) == {"signal", "boolean"}
            and not isinstance(e.left, ex.SignalState)
            and not isinstance(e.right, ex.SignalState)
        ):
            left, right = (
                ex.Compare("=", side, ex.SignalState(True)) if kind == "signal" else side
                for side, kind in zip((e.left, e.right), kinds, strict=True)
            )
            return replace(e, left=left, right=right)
        if "boolean" in kinds and any(kind in _NUMBERS for kind in kinds):
            states = [self._as_state(routine, side) for side in (e.left, e.right)]
            return replace(e, left=states[0], right=states[1])
        return e


def _differ(wanted: str, given: str) -> bool:
    """Whether two types are of two families; False where one is not known."""
    return wanted in _FAMILIES and given in _FAMILIES and _FAMILIES[wanted] != _FAMILIES[given]


def _compared_families(left: str, right: str) -> str:
    return f"{_FAMILIES[left]} compared with {_FAMILIES[right]}"


def _operands(e: ex.Binary | ex.Unary | ex.Logic) -> tuple[str, tuple[ex.Expression, ...]]:
    """The word of an operation and what it is of."""
    if isinstance(e, ex.Logic):
        return e.rest[0][0] if e.rest else "and", (e.first, *(one for _, one in e.rest))
    return e.operator, (e.operand,) if isinstance(e, ex.Unary) else (e.left, e.right)


def _is_digital(e: ex.Signal) -> bool:
    return not any(word in e.bus for word in ("group", "analog", "register"))


def _not_zero(e: ex.Expression) -> ex.Expression:
    return ex.Compare("<>", e, ex.Number(0))


def _is_written(value: ex.Expression | None) -> bool:
    """Whether a value stands in the text as it is, and is not computed."""
    return value is not None and all(type(e) in _LITERALS for e in expressions_of(value))


def _places_apart(program: st.Program, work: TranslationContext) -> st.Program:
    """Positions that moves also take as their tool or frame: the tool or frame is a copy that is set with them."""
    places: set[str] = set()
    systems: dict[str, str] = {}
    for s in program.statements():
        if type(s) is st.Move:
            places |= {e.name for e in (*s.targets, s.via) if type(e) is ex.Named}
            for kind, e in (("tool", s.tool), ("frame", s.frame)):
                if type(e) is ex.Named:
                    systems.setdefault(e.name, kind)
    values = {d.name: d.value for d in program.data}
    names = {name: work.fresh(f"{name}_{systems[name]}") for name in systems if name in places}
    if not names:
        return program
    data = []
    for name, new in names.items():
        value = values.get(name)
        begins = value if isinstance(value, ex.PositionLiteral) else _NOTHING
        data.append(st.Declare(0, new, systems[name], begins, storage="persistent", shared=True))
        work.names[systems[name], name] = new

    def copied(s: st.Statement) -> list[st.Statement]:
        if type(s) is st.Move:
            named = {"tool": s.tool, "frame": s.frame}
            changes = {
                field: ex.Named(names[e.name])
                for field, e in named.items()
                if type(e) is ex.Named and e.name in names
            }
            return [edited(s, changes) if changes else s]
        begun = [s.name] if isinstance(s, st.Declare) and s.value is not None else []
        changed = [name for name in (*changed_by(s), *begun) if name in names]
        if changed and not isinstance(s, (st.Assign, st.Call, st.Declare)):
            says = "a position that is also a tool or frame is changed within a condition"
            work.lose(s, Fate.REFUSED, "frame", says)
        return [s, *(st.Assign(s.line, ex.Named(names[name]), ex.Named(name)) for name in changed)]

    routines = [with_rows(r, [row for s in r.body for row in copied(s)]) for r in program.routines]
    program = with_routines(program, routines)
    return replace(program, data=(*program.data, *data))


def _systems_in_the_module(program: st.Program, work: TranslationContext) -> st.Program:
    """Tools and frames that a routine declares, declared for the whole program under names of their own."""
    data: list[st.Declare] = []
    routines: list[st.Routine] = []
    taken = {declare.name.casefold() for declare in program.data}
    for routine in program.routines:
        chosen = {
            e.name
            for s in routine.body
            if type(s) is st.Move
            for e in (s.tool, s.frame)
            if type(e) is ex.Named
        }
        moved = [
            s
            for s in routine.body
            if isinstance(s, st.Declare) and (s.type in _MODULE_DATA or (s.name in chosen and not s.sizes))
        ]
        if not moved:
            routines.append(routine)
            continue
        names: dict[str, str] = {}
        for declare in moved:
            new = declare.name
            if new.casefold() in taken:
                new = work.fresh(f"{routine.name}_{new}")
            taken.add(new.casefold())
            names[declare.name] = new
            value = declare.value if _is_written(declare.value) or declare.sizes else _NOTHING
            data.append(replace(declare, line=0, name=new, value=value, storage="persistent", shared=True))
        gone = set(map(id, moved))

        def change(e: ex.Expression, names: dict[str, str] = names) -> ex.Expression:
            return (
                ex.Named(names[e.name]) if type(e) is ex.Named and names.get(e.name, e.name) != e.name else e
            )

        changed = {name for s in routine.body for name in changed_by(s)}
        rows: list[st.Statement] = []
        for s in routine.body:
            if id(s) not in gone:
                rows.append(mapped(s, change))
            elif (
                isinstance(s, st.Declare)
                and s.value is not None
                and (s.name in changed or not _is_written(s.value))
            ):
                rows.append(st.Assign(s.line, ex.Named(names[s.name]), s.value))  # what each call begins with
        routines.append(replace(routine, body=tuple(rows)))
    return replace(program, routines=tuple(routines), data=(*program.data, *data)) if data else program


def whole_decimals(e: Any) -> Any:
    """A number rounded to decimals, where the target's function rounds to whole numbers."""
    if not isinstance(e, ex.Function) or e.name not in ("round", "trunc") or len(e.arguments) != 2:
        return e
    number, decimals = e.arguments
    if not isinstance(decimals, ex.Number):
        return e
    scale = ex.Number(10 ** int(decimals.value))
    return ex.Binary("/", ex.Function(e.name, (ex.Binary("*", number, scale),)), scale)


# --- Enumerations ---
# KRL's enumerations that the program or its lists declare: whole numbers, which is what their constants are.

_LARGEST_POWER: Final = 4  # that is written as a product
_LARGEST_EXPONENT: Final = 50  # of constants that are computed here
_MANUAL: Final = (ex.SystemValue("manual-reduced"), ex.SystemValue("manual-full"))
_STATES_ARE_TOLD: Final = "see that these signals tell what the program asks of the controller"
_AUTOMATIC: Final = (
    "automatic mode is asked for, whether a cell's controller started the program or an operator"
)
_REDUCED: Final = "the signal that is asked tells of manual modes at full speed, too"
_TOLD_BY_SIGNAL: Final = (
    "whether the mode is manual is asked of the signal that the controller sets in its manual modes"
)


def enumerations(program: st.Program, work: TranslationContext) -> st.Program:
    """Variables of an enumeration as whole numbers, its constants counted from 1 as KRL counts them."""
    declared = [
        d for d in program.declarations() if d.type == "enumeration" and isinstance(d.value, ex.RecordLiteral)
    ]
    if not declared or program.vendor == work.target:
        return program
    kinds = {d.name.casefold() for d in declared}
    places: dict[str, set[int]] = {}
    for d in declared:
        for place, (_, word) in enumerate(d.value.members, 1):  # type: ignore[union-attr]
            if isinstance(word, ex.Text):
                places.setdefault(word.value.casefold(), set()).add(place)
    known = {word: min(found) for word, found in places.items() if len(found) == 1}
    used = {e.value.casefold() for s in program.statements() for e in expressions_of(s) if type(e) is ex.Text}
    for d in declared:
        words = [e.value for _, e in d.value.members if isinstance(e, ex.Text)]  # type: ignore[union-attr]
        if not used.isdisjoint(word.casefold() for word in words):
            shown = ", ".join(f"{word[1:]} {place}" for place, word in enumerate(words, 1))
            work.note_once(f"{d.name} is a whole number there: {shown}")

    symbols = symbols_of(program)

    def numbered(s: _S, scope: str) -> _S:
        kept = {e.value for e in _of_other_types(s, scope, symbols)}

        def change(e: ex.Expression) -> ex.Expression:
            if type(e) is not ex.Text or e.value in kept or e.value.casefold() not in known:
                return e
            return ex.Number(known[e.value.casefold()])

        return mapped(s, change)

    def plain(d: st.Declare) -> st.Declare:
        return replace(d, type="integer", native="") if d.type.casefold() in kinds else d

    routines = []
    for r in program.routines:
        given = tuple(
            replace(p, type="integer", native="") if p.type.casefold() in kinds else p for p in r.parameters
        )
        body = tuple(
            plain(one) if type(one := numbered(s, r.name)) is st.Declare else one
            for s in r.body
            if not (type(s) is st.Declare and s.type == "enumeration")
        )
        returns = "integer" if r.returns.casefold() in kinds else r.returns
        data = tuple(plain(numbered(d, r.name)) for d in r.data if d.type != "enumeration")
        routines.append(replace(r, body=body, data=data, parameters=given, returns=returns))
    rows = tuple(plain(numbered(d, "")) for d in program.data if d.type != "enumeration")
    return replace(program, routines=tuple(routines), data=rows)


def _of_other_types(s: st.Statement, scope: str, symbols: Symbols) -> Iterator[ex.Text]:
    """Constants of enumerations of the controller's own, which a variable of such a type takes as a text."""
    pairs = [(e.left, e.right) for e in expressions_of(s) if type(e) is ex.Compare]
    if type(s) is st.Assign:
        pairs.append((s.target, s.value))
    elif type(s) is st.Declare and type(s.value) is ex.Text and s.type == "string":
        yield s.value
    for one, other in (*pairs, *((right, left) for left, right in pairs)):
        if type(other) is ex.Text and kind_of_value(symbols, scope, one) == "string":
            yield other


def exclusive_or(program: st.Program, work: TranslationContext) -> st.Program:
    """Exclusive OR of two conditions, not of bits; `<>` where the target has no such operator."""
    symbols = work.symbols(program)

    def change(e: ex.Expression, routine: str) -> ex.Expression:
        if type(e) is not ex.Binary or e.operator != "xor":
            return e
        if not all(kind_of_value(symbols, routine, one) == "boolean" for one in (e.left, e.right)):
            return e
        if work.limits.has_exclusive_or:
            return ex.Logic(e.left, (("xor", e.right),))
        return ex.Compare("<>", e.left, e.right)

    routines = [
        changed_rare(r, work.look(r), lambda s, name=r.name: mapped(s, lambda e: change(e, name)))  # type: ignore[misc]
        for r in program.routines
    ]
    return with_routines(program, routines)


# --- Texts of values ---
# Some languages take a number or a state where they show a text, and write it as one; others want that to be said.

_JOINED: Final = "joined-text"
AS_TEXT: Final = "text-of-value"
_NO_TEXTS: Final = _NUMBERS | _PLACES | {"boolean"}


def displayed_values(program: st.Program, work: TranslationContext) -> st.Program:
    """Numbers, states and positions in messages and joined texts are converted to texts; texts are not converted."""
    adds = work.conventions.sums_of_texts
    if not any(_shows_values(s, adds) for r in program.routines for _, s in work.look(r).rare):
        return program
    symbols = work.symbols(program)

    def parts(e: ex.Expression) -> tuple[ex.Expression, ...]:
        return e.arguments if type(e) is ex.Function and e.name == _JOINED else (e,)

    def shown(e: ex.Expression, routine: str) -> ex.Expression:
        if type(e) is ex.Member or kind_of_value(symbols, routine, e) not in _NO_TEXTS:
            return e
        return ex.Function(AS_TEXT, (_as_state(e, symbols, routine),))

    def change(e: ex.Expression, routine: str) -> ex.Expression:
        if type(e) is ex.Binary and adds and e.operator == "+":
            if "string" not in (kind_of_value(symbols, routine, one) for one in (e.left, e.right)):
                return e
            e = ex.Function(_JOINED, (*parts(e.left), *parts(e.right)))
        if type(e) is not ex.Function or not e.arguments:
            return e
        if e.name == _JOINED:
            return replace(e, arguments=tuple(shown(one, routine) for one in e.arguments))
        if e.name == AS_TEXT:
            first, *more = e.arguments
            if kind_of_value(symbols, routine, first) == "string":
                return first
            return replace(e, arguments=(_as_state(first, symbols, routine), *more))
        return e

    def row(s: st.Statement, routine: str) -> st.Statement:
        if not _shows_values(s, adds):
            return s
        s = mapped(s, lambda e: change(e, routine))
        return replace(s, text=shown(s.text, routine)) if type(s) is st.Message else s

    routines = [
        changed_rare(r, work.look(r), lambda s, name=r.name: row(s, name))  # type: ignore[misc]
        for r in program.routines
    ]
    return with_routines(program, routines)


def _shows_values(s: st.Statement, adds: bool) -> bool:
    if calls_nothing(s):
        return False
    if type(s) is st.Message and type(s.text) is not ex.Text:
        return True
    if adds and any(type(e) is ex.Binary and e.operator == "+" for e in expressions_of(s)):
        return True
    return any(type(e) is ex.Function and e.name in (_JOINED, AS_TEXT) for e in expressions_of(s))


def _as_state(e: ex.Expression, symbols: Symbols, routine: str) -> ex.Expression:
    """A signal that is on or off as a condition, any other value as it is."""
    if type(e) is ex.Signal and kind_of_value(symbols, routine, e) == "boolean":
        return ex.Compare("=", e, ex.SignalState(True))
    return e


def powers(program: st.Program, work: TranslationContext) -> st.Program:
    """Small whole powers as products, those of constants as numbers, where the target has no function for them."""
    if work.limits.has_power:
        return program
    symbols = work.symbols(program)

    told: list[str] = []  # variables whose values are taken, in the statement under way

    def change(e: ex.Expression, routine: str) -> ex.Expression:
        if type(e) is not ex.Function or e.name != "power" or len(e.arguments) != 2:
            return e
        told.extend(one.name for one in e.arguments if _may_change(one, symbols, routine))
        known = tuple(symbols.fixed_value(routine, one) or one for one in e.arguments)
        match known:
            case (ex.Number(number), ex.Number(exponent)) if (
                number > 0 and abs(exponent) <= _LARGEST_EXPONENT
            ):
                return ex.Number(number**exponent)
            case (_, ex.Number(exponent)) if _is_cheap(base := e.arguments[0]):
                if exponent == 0.5:
                    return ex.Function("sqrt", (base,))
                if float(exponent).is_integer() and 1 <= exponent <= _LARGEST_POWER:
                    product = base
                    for _ in range(int(exponent) - 1):
                        product = ex.Binary("*", product, base)
                    return product
        return e

    def row(s: st.Statement, routine: str) -> st.Statement:
        told.clear()
        made = mapped(s, lambda e: change(e, routine))
        for name in dict.fromkeys(told):
            says = f"{name} is a variable: the power is written as it is with its first value"
            work.lose(s, Fate.APPROXIMATED, "value", says)
        return made

    routines = [
        changed_rare(r, work.look(r), lambda s, name=r.name: row(s, name))  # type: ignore[misc]
        for r in program.routines
    ]
    return with_routines(program, routines)


def _may_change(e: ex.Expression, symbols: Symbols, routine: str) -> TypeGuard[ex.Named]:
    """Whether it is a variable that nothing here sets: others may."""
    if type(e) is not ex.Named:
        return False
    symbol = symbols.find(routine, e.name)
    return symbol is not None and symbol.is_fixed and symbol.storage == "persistent"


def controller_states(program: st.Program, work: TranslationContext) -> st.Program:
    """States that only the controller knows are read from signals that show them, where the target has such."""

    def change(s: st.Statement) -> st.Statement:
        asked = {
            e.name for e in expressions_of(s) if type(e) is ex.SystemValue and e.name in terminology.STATES
        }
        if not asked:
            return s
        known: dict[ex.Expression, ex.Expression] = {}
        for name in sorted(asked):
            told = work.limits.state_signals.get(name)
            if name == "automatic":
                work.lose(s, Fate.APPROXIMATED, "condition", _AUTOMATIC)
                known[ex.SystemValue(name)] = ex.Unary("not", ex.Logic(_MANUAL[0], (("or", _MANUAL[1]),)))
            elif told is not None:
                bus, index, asks = told
                says = f"{terminology.STATES[name]} is asked of a signal that the controller or the cell sets"
                work.lose(s, Fate.APPROXIMATED, "condition", says)
                work.ask(_STATES_ARE_TOLD, asks)
                known[ex.SystemValue(name)] = ex.Signal(
                    bus, ex.Number(index) if isinstance(index, int) else ex.Text(index)
                )
        return mapped(s, lambda e: known.get(e, e)) if known else s

    routines = [changed_rare(r, work.look(r), change) for r in program.routines]
    return with_routines(program, routines)


def manual_modes(program: st.Program, work: TranslationContext) -> st.Program:
    """Whether the mode is manual, at whatever speed, is read from a signal, where the target has such."""
    told = work.limits.manual_signal
    if told is None:
        return program
    signal = ex.Signal(told[0], ex.Number(told[1]))

    def both(e: ex.Expression) -> ex.Expression:
        parts = _either(e)
        if type(e) is not ex.Logic or not all(mode in parts for mode in _MANUAL):
            return e
        work.note_once(_TOLD_BY_SIGNAL)
        others = [part for part in parts if part not in _MANUAL]
        return ex.Logic(signal, tuple(("or", part) for part in others)) if others else signal

    def change(s: st.Statement) -> st.Statement:
        s = mapped(s, both)
        if not any(e in _MANUAL for e in expressions_of(s)):
            return s
        if not any(e == _MANUAL[0] for e in expressions_of(s)):
            return s
        work.lose(s, Fate.APPROXIMATED, "condition", _REDUCED)
        return mapped(s, lambda e: signal if e == _MANUAL[0] else e)

    routines = [changed_rare(r, work.look(r), change) for r in program.routines]
    return with_routines(program, routines)


def assumed_states(program: st.Program, work: TranslationContext) -> st.Program:
    """States that the target's controller cannot tell become variables that the operator or another program sets."""
    names: dict[str, str] = {}

    def told(e: ex.Expression) -> ex.Expression:
        if not _is_state(e, work):
            return e
        if e.name not in names:
            names[e.name] = work.fresh(terminology.state_variable(e.name))
            work.undeclared[names[e.name]] = "boolean"
            work.ask(ASKS["status"], names[e.name])
        return ex.Named(names[e.name])

    def change(s: st.Statement) -> st.Statement:
        for e in dict.fromkeys(e for e in expressions_of(s) if _is_state(e, work)):
            variable = told(e)
            assert isinstance(variable, ex.Named)
            says = f"{terminology.value(e.name)} is asked of a variable, {variable.name}, which something has to set"
            work.lose(s, Fate.APPROXIMATED, "condition", says)
        return mapped(s, told)

    routines = [changed_rare(r, work.look(r), change) for r in program.routines]
    data = (st.Declare(0, name, "boolean", shared=True, comment=UNDECLARED) for name in names.values())
    return replace(with_routines(program, routines), data=(*program.data, *data)) if names else program


def _is_state(e: ex.Expression, work: TranslationContext) -> TypeGuard[ex.SystemValue]:
    if type(e) is not ex.SystemValue or e.name in work.limits.states:
        return False
    return e.name in terminology.STATES or e in _MANUAL


def _either(e: ex.Expression) -> list[ex.Expression]:
    """The conditions of which one is enough."""
    if type(e) is not ex.Logic or any(word != "or" for word, _ in e.rest):
        return [e]
    return [inner for part in (e.first, *(part for _, part in e.rest)) for inner in _either(part)]


def _is_cheap(e: ex.Expression) -> bool:
    """Whether a value may be computed more than once: nothing is called, and no signal is read."""
    return not any(isinstance(one, (ex.CallValue, ex.Signal, ex.SystemValue)) for one in expressions_of(e))
