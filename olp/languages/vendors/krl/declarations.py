"""Lowers declarations and the heads of routines and data lists: one short method per rule."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from lark import Token

from olp.ir.expressions import Expression, Number, RecordLiteral, Signal, Text, Unknown
from olp.ir.program import Declare, Parameter
from olp.languages.vendors.krl.moves import KrlMoveRules
from olp.languages.vendors.krl.scope import NEUTRAL_TYPES, KrlReference
from olp.languages.vendors.krl.values import settle


class Head(NamedTuple):
    """DEF, DEFFCT or DEFDAT. `kind`: "routine", "function" or "list"; `type` in capitals.

    `array`: the brackets behind the type of a function that returns an array, as written.
    """

    kind: str
    name: str
    parameters: tuple[Parameter, ...] = ()
    shared: bool = False
    type: str = ""
    array: str = ""


class Tail(NamedTuple):
    """END, ENDFCT or ENDDAT."""

    word: str


class _Declarator(NamedTuple):
    name: str
    sizes: tuple[Expression | None, ...]
    value: Any  # an expression or an aggregate


class DeclarationRules(KrlMoveRules):
    # --- heads ------------------------------------------------------------------------------------------

    def routine(self, children: list[Any]) -> Head:
        *shared, name, parameters = children
        return Head("routine", str(name), parameters or (), bool(shared))

    def function(self, children: list[Any]) -> Head:
        shared = children[0].type == "GLOBAL"
        word, *sizes, name, parameters = children[shared:]
        counts = [str(one.value) if type(one) is Number else "" for size in sizes for one in size]
        array = f"[{','.join(counts)}]" if sizes else ""
        return Head("function", str(name), parameters or (), shared, str(word.upper()), array)

    def data_list(self, children: list[Token]) -> Head:
        return Head("list", str(children[0]), shared=len(children) > 1)

    def end(self, children: list[Token]) -> Tail:
        return Tail(str(children[0].upper()))

    def parameters(self, children: list[Parameter]) -> tuple[Parameter, ...]:
        return tuple(children)

    def parameter(self, children: list[Any]) -> Parameter:
        name, *dimensions, direction = children
        # Without a word the caller's variable is changed.
        by_reference = direction is None or not direction.upper().endswith("IN")
        return Parameter(
            self.scope.spell(name),
            by_reference=by_reference,
            native="[]" if dimensions else "",
            sizes=tuple(Unknown("") for indices in dimensions for _ in indices),
        )

    # --- variables --------------------------------------------------------------------------------------

    def modifier(self, children: list[Token]) -> str:
        return str(children[0].upper())

    def declarator(self, children: list[Any]) -> _Declarator:
        name, *sizes, value = children
        return _Declarator(str(name), sizes[0] if sizes else (), value)

    def member(self, children: list[Any]) -> tuple[Token | None, _Declarator]:
        return children[0], children[1]

    def variables(self, children: list[Any]) -> tuple[Declare, ...]:
        modifiers = [one for one in children if type(one) is str]
        word, *declarators = children[len(modifiers) :]
        key = str(word.upper())
        return tuple(self._declare(modifiers, word, key, one) for one in declarators)

    def _declare(self, modifiers: Sequence[str], word: Token, key: str, it: _Declarator) -> Declare:
        scope = self.scope
        scope.declare(it.name, key, bool(it.sizes))
        value = None if it.value is None else settle(it.value, scope, key)
        if value is not None:
            scope.keep(it.name.upper(), value)
        return Declare(
            0,
            scope.spell(it.name),
            NEUTRAL_TYPES.get(key) or scope.spell(word),
            value,
            tuple(Unknown("") if one is None else one for one in it.sizes),
            "constant" if "CONST" in modifiers else "variable",
            "GLOBAL" in modifiers,
            key,
        )

    def enumeration(self, children: list[Any]) -> tuple[Declare, ...]:
        modifiers = [one for one in children if type(one) is str]
        name, *words = children[len(modifiers) :]
        constants = tuple(("", Text("#" + self.scope.spell(word))) for word in words)
        value = RecordLiteral("ENUM", constants)
        return (
            Declare(
                0, self.scope.spell(name), "enumeration", value, shared="GLOBAL" in modifiers, native="ENUM"
            ),
        )

    def structure(self, children: list[Any]) -> tuple[Declare, ...]:
        modifiers = [one for one in children if type(one) is str]
        name, type_, first, *others = children[len(modifiers) :]
        members: list[tuple[str, Expression]] = []
        types: dict[str, str] = {}
        for word, declarator in [(type_, first), *others]:
            type_ = word or type_
            types[declarator.name.upper()] = type_.upper()
            sizes = tuple(("", Unknown("") if one is None else one) for one in declarator.sizes)
            members.append((self.scope.spell(declarator.name), RecordLiteral(str(type_.upper()), sizes)))
        self.scope.lay_out(name.upper(), tuple(types.items()))
        value = RecordLiteral("STRUC", tuple(members))
        return (
            Declare(
                0, self.scope.spell(name), "structure", value, shared="GLOBAL" in modifiers, native="STRUC"
            ),
        )

    def named_signal(self, children: list[Any]) -> tuple[Declare, ...]:
        modifiers = [one for one in children if type(one) is str]
        name, first, last = children[len(modifiers) :]
        signal = self._signal(first)
        spelt = self.scope.spell(name)
        value: Expression = signal
        if last is not None:
            value = RecordLiteral("SIGNAL", (("", signal), ("", self._signal(last))))
            signal = Signal(f"{signal.bus}-group", Text(spelt))
        self.scope.declare(name, "SIGNAL")
        self.scope.name_signal(name, signal)
        shared = "GLOBAL" in modifiers
        return (Declare(0, spelt, "signal", value, storage="constant", shared=shared, native="SIGNAL"),)

    def _signal(self, it: KrlReference) -> Signal:
        found = self.lower(it)
        if type(found) is not Signal:
            # A system signal such as $USER_SAF: a name for a name.
            return Signal("system", Text(it.name))
        return found
