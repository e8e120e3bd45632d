"""Spells values, registers, arithmetic and conditions in TP: the way back of `expressions`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, Final

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.points import PointKind, PointTable
from olp.languages.generator import CannotSayError, Generator, Spelled, decimal, without_noise
from olp.languages.vendors.tp import values

_FUNCTIONS: Final = {name: word for word, name in values.FUNCTIONS.items()}
_STRING_FUNCTIONS: Final = {name: word for word, name in values.STRING_FUNCTIONS.items()}
_GROUPS: Final = {store: group for group, store in values.GROUP_STORES.items()}
_COMPARED, _UNARY = 3, 6  # how strongly comparisons and signs bind


class TpValues(Generator):
    """Spells expressions. `names`: comments of signals, DO[3] -> gripper. `points`: what the program teaches."""

    language = "TP"
    binary: ClassVar = {
        "+": ("+", 4),
        "-": ("-", 4),
        "*": ("*", 5),
        "/": ("/", 5),
        "div": (" DIV ", 5),
        "mod": (" MOD ", 5),
    }
    unary: ClassVar = {"-": ("(-{})", _UNARY, _UNARY), "not": ("!{}", _UNARY, _UNARY)}
    logic: ClassVar = {"and": (" AND ", 2), "or": (" OR ", 1)}
    compared = (_COMPARED, 4)
    signals: ClassVar = {bus: word for word, bus in values.BUSES.items()}
    states = ("OFF", "ON")
    quotes = "'"
    not_in_text = frozenset("'\r\n")
    no_text = "a text that holds ' or a line end"
    no_value = ("a computed value in this place", "compute it into a register first")
    singles = frozenset(
        {
            ex.Number,
            ex.Variable,
            ex.Argument,
            ex.Signal,
            ex.SignalState,
            ex.Member,
            ex.Item,
            ex.SystemValue,
            ex.Taught,
            ex.FrameRef,
            ex.Text,
            ex.Named,
            ex.Unknown,
        }
    )

    def __init__(self, program: st.Program) -> None:
        super().__init__(program, program.vendor == "tp")
        self.names: Mapping[str, str] = {}
        self.points = PointTable()

    # --- registers --------------------------------------------------------------------------------------

    def spell_variable(self, e: ex.Variable) -> str:
        name = f":{e.name}" if e.name else ""
        if e.store is ex.Store.REAL:
            return f"R[{self.index(e.index)}{name}]"
        if e.store is ex.Store.STRING:
            return f"SR[{self.index(e.index)}{name}]"
        return f"{self._position_register(e)}{name}]"

    def _position_register(self, it: ex.Variable) -> str:
        if it.store not in _GROUPS or it.local:
            raise CannotSayError(f"a {terminology.STORES[it.store]}", "TP has R, PR and SR registers")
        group = _GROUPS[it.store]
        return f"PR[{'' if group == 1 else f'GP{group}:'}{self.index(it.index)}"

    def spell_member(self, e: ex.Member) -> str:
        return self._element(e)

    def spell_item(self, e: ex.Item) -> str:
        return self._element(e)

    def _element(self, it: ex.Member | ex.Item) -> str:
        base = it.base
        if isinstance(base, ex.Taught) and isinstance(it, ex.Member):
            return self._taught_component(base, it.name)
        if not isinstance(base, ex.Variable) or base.store not in _GROUPS:
            raise CannotSayError(
                "a component of something that is no position register", "copy it into a PR first"
            )
        if isinstance(it, ex.Member):
            if it.name not in values.ELEMENTS:
                raise CannotSayError(
                    f"the component '{it.name}' of a position", "TP has x y z, W P R and E1 to E3"
                )
            place = str(values.ELEMENTS.index(it.name) + 1)
        elif len(it.indices) == 1:
            place = self.index(it.indices[0])
        else:
            raise CannotSayError("an array of several dimensions")
        return f"{self._position_register(base)},{place}{f':{base.name}' if base.name else ''}]"

    def _taught_component(self, base: ex.Taught, name: str) -> str:
        """A component of a taught position, which no program changes: its number."""
        point = self.points.find(base.store, True, base.number)
        place = values.ELEMENTS.index(name) if name in values.ELEMENTS[:6] else -1
        if point is None or point.state.kind is not PointKind.POSE or place < 0:
            raise CannotSayError(f"the component '{name}' of a taught position", "copy it into a PR first")
        value = round(point.values[place] / (mm if place < 3 else deg), 6)
        return self.single(ex.Number(int(value) if value == int(value) else value))

    def index(self, it: ex.Expression) -> str:
        """A number, or one register."""
        if isinstance(it, ex.Number):
            return str(int(it.value))
        if isinstance(it, ex.Argument) or (isinstance(it, ex.Variable) and it.store is ex.Store.REAL):
            return self.value(it)
        raise CannotSayError("a computed index", "compute it into a register first")

    def signal(self, it: ex.Signal) -> str:
        if it.part:
            raise CannotSayError(*terminology.signal(it))
        word = self.signal_word(it)
        if isinstance(it.index, ex.Text):
            raise CannotSayError(f"the signal '{it.index.value}' by its name", "say which number it has")
        return self.named(word, it.index)

    def spell_frame_ref(self, e: ex.FrameRef) -> str:
        if e.kind not in ("user", "tool") or e.number is None:
            raise CannotSayError(f"{terminology.SYSTEMS.get(e.kind, e.kind)} in this place")
        return f"{'UFRAME' if e.kind == 'user' else 'UTOOL'}[{self.index(e.number)}]"

    def spell_system_value(self, e: ex.SystemValue) -> str:
        if e.name == "timer":
            return self.named("TIMER", ex.Number(e.index))
        if e.name in ("current-pose", "current-joints"):
            return "LPOS" if e.name == "current-pose" else "JPOS"
        raise CannotSayError(terminology.value(e.name))

    def named(self, word: str, index: ex.Expression) -> str:
        """A word with its number, and the comment that the program gives it."""
        key = f"{word}[{self.index(index)}]"
        name = self.names.get(key)
        return f"{key[:-1]}:{name}]" if name else key

    # --- values -----------------------------------------------------------------------------------------

    def target(self, e: ex.Expression) -> str:
        return self.single(e)

    def spell_number(self, e: ex.Number) -> str:
        """A negative number is in parentheses."""
        text = self.number(e)
        return f"({text})" if text[0] == "-" else text

    def spell_argument(self, e: ex.Argument) -> str:
        return f"AR[{e.number}]"

    def spell_taught(self, e: ex.Taught) -> Spelled:
        return f"P[{e.number}]" if e.store is ex.Store.ROBOT else self.spell_other(e)

    def spell_named(self, e: ex.Named) -> str:
        if e.name.startswith("$"):
            return e.name
        raise CannotSayError(f"the variable {e.name} by its name", "give it a register")

    def spell_unknown(self, e: ex.Unknown) -> str:
        if not self.own:
            raise CannotSayError(f"the word {e.text}")
        return e.text

    def assigned(self, it: ex.Expression) -> str:
        """The right side of an assignment: one value, one operation, or mixed logic in parentheses."""
        if isinstance(it, ex.Function) and it.name in _STRING_FUNCTIONS:
            return f"{_STRING_FUNCTIONS[it.name]} {','.join(map(self.single, it.arguments))}"
        if isinstance(it, ex.Function) and it.name == "joined-text" and len(it.arguments) == 2:
            return "+".join(map(self.single, it.arguments))
        if type(it) in self.singles or (isinstance(it, ex.Function) and it.name in _FUNCTIONS):
            return self.value(it)
        if isinstance(it, ex.Binary) and type(it.left) in self.singles and type(it.right) in self.singles:
            return self.value(it)
        return f"({self.value(it)})"

    def spell_function(self, e: ex.Function) -> str:
        if e.name not in _FUNCTIONS:
            raise CannotSayError(terminology.function(e.name))
        return f"{_FUNCTIONS[e.name]}[{self.arguments(e.arguments)}]"

    def operand(self, e: ex.Expression, strength: int) -> str:
        """An operand of AND, OR and !: a register counts as true when it is not zero."""
        if isinstance(e, (ex.Variable, ex.Argument, ex.Number)):
            text = f"{self.single(e)}<>0"
            return f"({text})" if strength > _COMPARED else text
        return self.value(e, strength)

    def spell_compare(self, e: ex.Compare) -> Spelled:
        if isinstance(e.right, ex.SignalState) and isinstance(e.left, (ex.Variable, ex.Argument)):
            e = ex.Compare(e.operator, e.left, ex.Number(int(e.right.on)))
        return super().spell_compare(e)

    def condition(self, e: ex.Expression, strength: int = 0) -> str:
        """Plain where it compares a single value with another and binds no stronger, else in parentheses."""
        single = isinstance(e, ex.Compare) and type(e.left) in self.singles and type(e.right) in self.singles
        if isinstance(e, ex.Compare) and single and not isinstance(e.left, (ex.Number, ex.SignalState)):
            text = self.value(e)
            return f"({text})" if strength else text
        return f"({self.operand(e, 0)})"

    # --- numbers with units -----------------------------------------------------------------------------

    def quantity(self, it: ex.Quantity, unit: float) -> str:
        written = it.written
        if isinstance(written, ex.Number):
            value = written.value if it.scale == unit else without_noise(written.value * it.scale / unit)
            return decimal(float(value))
        if not math.isclose(it.scale, unit):
            raise CannotSayError("a register in another unit", "convert it into a register of its own first")
        return self.index(written)
