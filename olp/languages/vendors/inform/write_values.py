"""Spells values, variables, arithmetic and conditions in INFORM: the way back of `values` and `expressions`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar, Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.block_structure import MIRRORED
from olp.ir.transformer import expressions_of
from olp.languages import generator
from olp.languages.generator import ATOM, CannotSayError, Generator, Spelled, without_noise
from olp.languages.vendors.inform import values
from olp.languages.vendors.inform.limits import LONGEST_TEXT

LETTERS: Final = {
    ex.Store.BYTE: "B",
    ex.Store.INTEGER: "I",
    ex.Store.DOUBLE: "D",
    ex.Store.REAL: "R",
    ex.Store.STRING: "S",
    ex.Store.ROBOT: "P",
    ex.Store.BASE: "BP",
    ex.Store.STATION: "EX",
    ex.Store.SYSTEM: "PX",
}
TAUGHT_LETTERS: Final = {ex.Store.ROBOT: "C", ex.Store.BASE: "BC", ex.Store.STATION: "EC"}
FRAMES: Final = {"base": "BF", "robot": "RF", "tool": "TF", "master-tool": "MTF"}
_POSITION_VALUES = {"position-pulse": "$PX000", "position-pose": "$PX001"}
COUNTED: Final = (ex.Store.BYTE, ex.Store.INTEGER, ex.Store.DOUBLE)
_EXPRESS = "EXPRESS has + - * and /"


def decimal(value: float, at_least: int = 0) -> str:
    """`value` as a decimal fraction with that many decimals, more where it has more."""
    return generator.decimal(value, at_least, "job")


_CONSTANTS: Final = (ex.Number, ex.Text)


class InformValues(Generator):
    """Spells expressions. `aliases`: the job's names of variables; `digits`: of a variable's number.

    `point_digits`, `station_letter`: of taught points.
    """

    language = "INFORM"
    binary: ClassVar = {"+": (" + ", 1), "-": (" - ", 1), "*": (" * ", 2), "/": (" / ", 2)}
    unary: ClassVar = {"-": ("-{}", ATOM, 3)}
    operator_help = _EXPRESS
    parentheses = ("( ", " )")
    separator = ", "
    states = ("OFF", "ON")
    no_value = ("a computed value in this place", "compute it into a variable with SET … EXPRESS first")
    singles = frozenset({ex.Number, ex.Variable, ex.Taught, ex.Text, ex.SignalState, ex.Unknown, ex.FrameRef})
    signals: ClassVar = {
        "in": "IN",
        "out": "OT",
        "in-group": "IG",
        "out-group": "OG",
        "in-half-group": "IGH",
        "out-half-group": "OGH",
        "system-in": "SIN",
        "system-out": "SOUT",
        "direct-in": "RIN",
        "analog-in": "AI",
        "analog-out": "AO",
        "register": "MREG",
    }

    def __init__(self, program: st.Program, date: str) -> None:
        super().__init__(program, program.vendor == "inform", date)
        self.aliases: Mapping[str, ex.Variable] = {}
        self.digits, self.point_digits, self.station_letter = 3, 5, "EC"

    # --- names ------------------------------------------------------------------------------------------

    def spell_variable(self, e: ex.Variable) -> str:
        if e.name and self.aliases.get(e.name) == e:
            return e.name
        letter = ("L" if e.local else "") + LETTERS[e.store]
        if type(e.index) is not ex.Number:
            return f"{letter}[{self.value(e.index)}]"
        return f"{letter}{int(e.index.value):0{self.digits}d}"

    def spell_taught(self, e: ex.Taught) -> str:
        letter = self.station_letter if e.store is ex.Store.STATION else TAUGHT_LETTERS.get(e.store, "")
        if not letter:
            raise CannotSayError(f"a taught position as a {terminology.STORES[e.store]}")
        return f"{letter}{e.number:0{self.point_digits}d}"

    def signal(self, e: ex.Signal) -> str:
        """Without the half of a register, which stands behind it as a word of its own."""
        return f"{self.signal_word(e)}#({self.single(e.index)})"

    def spell_frame_ref(self, e: ex.FrameRef) -> str:
        if e.number is not None and e.kind in ("user", "tool"):
            return f"{'UF' if e.kind == 'user' else 'TL'}#({self.single(e.number)})"
        if e.kind not in FRAMES:
            raise CannotSayError(terminology.SYSTEMS.get(e.kind, e.kind))
        return FRAMES[e.kind]

    def system(self, e: ex.SystemValue) -> str:
        """As GETS takes it."""
        if e.name == "returned":
            return "$RV"
        if e.name in _POSITION_VALUES:
            return _POSITION_VALUES[e.name]
        letters = {store.value: letter for store, letter in LETTERS.items()}
        if e.name not in letters:
            raise CannotSayError(terminology.value(e.name))
        return f"${letters[e.name]}{e.index:03d}"

    # --- values -----------------------------------------------------------------------------------------

    def target(self, e: ex.Expression) -> str:
        return self.single(e)

    def arguments(self, given: Sequence[ex.Expression]) -> str:
        return self.separator.join(map(self.single, given))

    def with_room(self, e: ex.Expression) -> None:
        """Refuses what a variable of texts has no room for; what a job is handed is not bounded by any page at hand."""
        if not self.own and any(
            type(x) is ex.Text and len(x.value) > LONGEST_TEXT for x in expressions_of(e)
        ):
            raise CannotSayError(f"a text of more than {LONGEST_TEXT} characters")

    def spell_system_value(self, e: ex.SystemValue) -> Spelled:
        raise CannotSayError(f"{terminology.value(e.name)} within a computation")

    def spell_compare(self, e: ex.Expression) -> Spelled:
        raise CannotSayError("a comparison or an element within a computation", _EXPRESS)

    spell_logic = spell_element = spell_compare

    def spell_function(self, e: ex.Function) -> Spelled:
        return self.spell_other(e)

    def spell_call_value(self, e: ex.CallValue) -> Spelled:
        return self.spell_other(e)

    def spell_named(self, e: ex.Named) -> Spelled:
        return self.spell_other(e)

    def joined(self, e: ex.Expression, express: bool) -> str:
        """A condition; `express`: joined by ANDEXP and OREXP instead of ANDIF and ORIF."""
        ending = "EXP" if express else "IF"
        if type(e) is ex.Logic:
            missing = [word for word, _ in e.rest if word not in ("and", "or")]
            if missing:
                raise CannotSayError(terminology.operation(missing[0]), "write it with AND and OR")
            rest = (f" {word.upper()}{ending} {self._comparison(other)}" for word, other in e.rest)
            return self._comparison(e.first) + "".join(rest)
        return self._comparison(e)

    def _comparison(self, e: ex.Expression) -> str:
        if type(e) is not ex.Compare:
            raise CannotSayError(
                "a condition that compares nothing", "write it as comparisons joined by AND and OR"
            )
        left, operator, right = e.left, e.operator, e.right
        if type(left) is ex.Text or type(right) is ex.Text:
            self.with_room(e)
        # Jobs seen have neither a number nor a text there.
        if type(left) in _CONSTANTS and type(right) not in _CONSTANTS:
            left, operator, right = right, MIRRORED.get(operator, operator), left
        if operator == "<>" and type(right) is ex.SignalState and not self.own:
            # Jobs seen compare a signal's state with = alone.
            operator, right = "=", ex.SignalState(not right.on)
        return f"{self.value(left)}{operator}{self.value(right)}"

    # --- numbers with units -----------------------------------------------------------------------------

    def quantity(self, it: ex.Quantity, unit: float) -> str:
        return self.amount(it, (unit, unit), 0)

    def amount(self, it: ex.Quantity, scales: tuple[float, float], at_least: int) -> str:
        """`scales`: SI per written unit of a literal, and of a counted variable; `at_least`: decimals."""
        literal, counted = scales
        written = it.written
        if type(written) is ex.Number:
            value = (
                written.value if it.scale == literal else without_noise(written.value * it.scale / literal)
            )
            return decimal(float(value), at_least)
        counts = type(written) is not ex.Variable or written.store in COUNTED
        if not math.isclose(it.scale, counted if counts else literal):
            raise CannotSayError("a variable in another unit", "convert it into a variable of its own first")
        return self.single(written)

    def seconds(self, it: ex.Quantity) -> str:
        return self.amount(it, values.TIME, 2)


def is_simple(condition: ex.Expression) -> bool:
    """Whether IFTHEN and IF can say it: comparisons of single values, none of them a text."""
    parts = (
        (condition.first, *(part for _, part in condition.rest))
        if type(condition) is ex.Logic
        else (condition,)
    )
    return all(
        type(part) is ex.Compare
        and not any(type(side) in (ex.Binary, ex.Unary, ex.Text) for side in (part.left, part.right))
        for part in parts
    )
