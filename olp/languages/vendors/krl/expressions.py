"""Lowers the grammar's values and expressions: one short method per rule."""

from __future__ import annotations

from typing import Any, Final

from lark import Token, Transformer

from olp.ir import expressions as ex
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendors.krl import values
from olp.languages.vendors.krl.scope import AXES, MODES, POSES, KrlReference, Scope
from olp.languages.vendors.krl.values import Component, KrlAggregate, settle

FUNCTIONS: Final = {
    "SQRT": "sqrt",
    "ABS": "abs",
    "SIN": "sin",
    "COS": "cos",
    "TAN": "tan",
    "ACOS": "acos",
    "ATAN2": "atan2",
    "INV_POS": "pose-inverse",
    "FORWARD": "forward",
    "INVERSE": "inverse",
    "STRLEN": "length-of-text",
}
BUSES: Final = {
    "$IN": "in",
    "$OUT": "out",
    "$ANIN": "analog-in",
    "$ANOUT": "analog-out",
    "$FLAG": "flag",
    "$CYCFLAG": "cyclic-flag",
    "$TIMER_FLAG": "timer-flag",
}
SYSTEM_VALUES: Final = {
    "$POS_ACT": "current-pose",
    "$AXIS_ACT": "current-joints",
    "$TOOL": "current-tool",
    "$BASE": "current-frame",
    "$AXIS_ACT_MEAS": "current-joints",
    "$POS_ACT_MES": "current-pose",
    "$T1": "manual-reduced",
    "$T2": "manual-full",
    "$AUT": "automatic",
    "$EXT": "automatic",
    "$IN_HOME": "at-home",
    "$PERI_RDY": "motors-on",
    "$PRO_ACT": "running",
    "$STOPMESS": "faulted",
    "$MOVE_ENABLE": "may-move",
    "$USER_SAF": "guard-closed",
    "$ALARM_STOP": "no-emergency-stop",
}
_MILLISECONDS: Final = ex.Number(1000)  # of a second
_FRAMES: Final = frozenset({"$NULLFRAME", "$WORLD"})
_COMPARISONS: Final = {"==": "=", "<>": "<>", "<": "<", ">": ">", "<=": "<=", ">=": ">="}
# Which binds first, by the manuals: comparisons last of all.
_STRENGTH: Final = {"B_AND": 7, "B_EXOR": 6, "B_OR": 5, "AND": 3, "EXOR": 2, "OR": 1}
_FIRST, _LAST = 4, 0  # how strongly comparisons bind: before AND, or after OR
_WORDS: Final = {"EXOR": "xor", "B_EXOR": "xor", "B_AND": "and", "B_OR": "or"}
_NOT_A_CONDITION = frozenset({"INT", "REAL", "CHAR"})


class KrlExpressionRules(Transformer[Token, Any]):
    """`scope` holds while a file is read; `mixed` tells of the last line that it mixes comparisons with AND or OR."""

    def __init__(self) -> None:
        super().__init__()
        self.scope = Scope()
        self.mixed = False

    # --- values -----------------------------------------------------------------------------------------

    def number(self, children: list[Token]) -> ex.Number:
        return values.number(children[0])

    def bits(self, children: list[Token]) -> ex.Number:
        try:
            return values.bits(children[0])
        except ValueError:
            raise BrokenLineError(
                f"{children[0]} is no number", word=str(children[0]), wanted="'B0110' or 'H1F'"
            ) from None

    def text(self, children: list[Token]) -> ex.Expression:
        word = str(children[0][1:-1])
        # A text that looks like a constant of an enumeration, which is a Text with # in front.
        return ex.Function("joined-text", (ex.Text(word),)) if _looks_like_constant(word) else ex.Text(word)

    def state(self, children: list[Token]) -> ex.SignalState:
        return ex.SignalState(children[0].upper() == "TRUE")

    def constant(self, children: list[Token]) -> ex.Text:
        return ex.Text("#" + self.scope.spell(children[0][1:].strip()))

    def untaught(self, _: list[Any]) -> ex.Unknown:
        """`PTP !`: the place of a point that is still to be taught."""
        return ex.Unknown("!")

    def parenthesised(self, children: list[Any]) -> Any:
        return children[0]

    def component(self, children: list[Any]) -> Component:
        name, *dimensions, value = children
        brackets = "[]" if dimensions else ""
        return Component(name.upper() + brackets, f"{name}{brackets}", value)

    def aggregate(self, children: list[Any]) -> KrlAggregate:
        tag, *components = children
        return KrlAggregate(tag.upper() if tag else "", tuple(components))

    # --- names ------------------------------------------------------------------------------------------

    def reference(self, children: list[Token]) -> KrlReference:
        return KrlReference(children[0].upper(), self.scope.spell(children[0]))

    def member_of(self, children: list[Any]) -> KrlReference:
        owner, name = children
        return owner._replace(parts=(*owner.parts, (str(name), ())))  # type: ignore[no-any-return]

    def element_of(self, children: list[Any]) -> KrlReference:
        owner, indices = children
        return owner._replace(parts=(*owner.parts, ("", indices)))  # type: ignore[no-any-return]

    def dimensions(self, children: list[Any]) -> tuple[ex.Expression | None, ...]:
        return tuple(None if one is None else self.plain(one) for one in children)

    def value(self, children: list[KrlReference]) -> ex.Expression:
        return self.lower(children[0])

    def lower(self, it: KrlReference) -> ex.Expression:
        """What a name with its members and indices stands for."""
        scope = self.scope
        signal = scope.signal(it.key)
        if signal is not None and not it.parts:
            return signal
        base, parts = self._system(it) if it.key[0] == "$" else (ex.Named(it.name), it.parts)
        for name, indices in parts:
            if name:
                base = scope.member(base, name)
            elif len(indices) == 1 and indices[0] is None:
                base = ex.Item(base, ())
            else:
                base = ex.Item(base, tuple(ex.Unknown("") if one is None else one for one in indices))
        return base

    def _system(self, it: KrlReference) -> tuple[ex.Expression, tuple[Any, ...]]:
        """The controller's own variables that have a neutral name, and the parts that are left."""
        first = it.parts[0] if it.parts else ("", ())
        index = first[1][0] if len(first[1]) == 1 else None
        if it.key == "$TIMER_FLAG" and type(index) is ex.Number:
            # On from 0 on: a clock that is set to -2000 ms tells that 2 s are over.
            return ex.Compare(">=", ex.SystemValue("timer", int(index.value)), ex.Number(0)), it.parts[1:]
        if it.key in BUSES and index is not None:
            return ex.Signal(BUSES[it.key], index), it.parts[1:]
        if it.key == "$TIMER" and type(index) is ex.Number:
            return ex.Binary("*", ex.SystemValue("timer", int(index.value)), _MILLISECONDS), it.parts[1:]
        if it.key == "$TIMER_STOP" and type(index) is ex.Number:
            return ex.Unary("not", ex.SystemValue("timer-running", int(index.value))), it.parts[1:]
        if it.key in SYSTEM_VALUES:
            return ex.SystemValue(SYSTEM_VALUES[it.key]), it.parts
        if it.key in _FRAMES:
            return values.NULL_FRAME, it.parts
        return ex.Named(it.name), it.parts

    def arguments(self, children: list[Any]) -> tuple[ex.Expression, ...]:
        if children == [None]:
            return ()
        return tuple(ex.Unknown("") if one is None else self.plain(one) for one in children)

    def call_value(self, children: list[Any]) -> ex.Expression:
        name, arguments = children
        function = FUNCTIONS.get(name.upper())
        if function is not None and name.upper() not in self.scope.local_types:
            return ex.Function(function, arguments)
        if name.upper() == "STRFIND" and len(arguments) == 4 and arguments[3] == ex.Text("#CASE_SENS"):
            start, text, pattern, _ = arguments
            return ex.Function("find-in-text", (text, start, pattern))
        if name.upper() == "STRCOMP" and len(arguments) == 3 and arguments[2] == ex.Text("#CASE_SENS"):
            return ex.Function("same-text", arguments[:2])
        return ex.CallValue(self.scope.spell(name), arguments)

    # --- arithmetic and logic ---------------------------------------------------------------------------

    def plain(self, it: ex.Expression | KrlAggregate) -> ex.Expression:
        return settle(it, self.scope)

    def binary(self, children: list[Any]) -> ex.Binary:
        left, sign, right = children
        operator = str(sign)
        types = self.scope.type_of
        if operator == "/" and _is_integer(left, types) and _is_integer(right, types):
            operator = "div"
        return ex.Binary(operator, self.plain(left), self.plain(right))

    def signed(self, children: list[Any]) -> ex.Expression:
        sign, operand = children
        if sign == "+":
            return self.plain(operand)
        return ex.Number(-operand.value) if type(operand) is ex.Number else ex.Unary("-", self.plain(operand))

    def negated(self, children: list[Any]) -> ex.Expression:
        word, operand = children
        if word.upper() == "B_NOT":
            return ex.Function("bit-not", (self.plain(operand),))
        return ex.Unary("not", self.plain(operand))

    def composition(self, children: list[Any]) -> ex.Function:
        return ex.Function("pose-product", (self.plain(children[0]), self.plain(children[1])))

    def operator(self, children: list[Token]) -> str:
        return str(children[0].upper())

    def chain(self, children: list[Any]) -> ex.Expression:
        operands = [self.plain(one) for one in children[::2]]
        operators = children[1::2]
        compared = any(one in _COMPARISONS for one in operators)
        joined = [place for place, one in enumerate(operators) if one in ("AND", "OR", "EXOR")]
        if not (compared and joined):
            return _climb(operands, operators, _LAST)
        self.mixed = True
        # By the manuals AND binds before ==; where that would join numbers, only the other way makes sense.
        beside = [operands[place + side] for place in joined for side in (0, 1)]
        natural = any(self._is_no_condition(one) for one in beside)
        return _climb(operands, operators, _FIRST if natural else _LAST)

    def _is_no_condition(self, it: ex.Expression) -> bool:
        if type(it) in (ex.Number, ex.Text, ex.Binary):
            return True
        kind = self.scope.type_of(it)
        return kind in _NOT_A_CONDITION or kind in POSES or kind in AXES


def _climb(operands: list[ex.Expression], operators: list[str], comparison: int) -> ex.Expression:
    """Joins a flat chain by strength; `comparison`: how strongly comparisons bind."""
    values_, waiting = [operands[0]], list[str]()

    def join() -> None:
        right, left = values_.pop(), values_.pop()
        values_.append(_joined(waiting.pop(), left, right))

    for operator, operand in zip(operators, operands[1:], strict=True):
        while waiting and _STRENGTH.get(waiting[-1], comparison) >= _STRENGTH.get(operator, comparison):
            join()
        waiting.append(operator)
        values_.append(operand)
    while waiting:
        join()
    return values_[0]


def _joined(operator: str, left: ex.Expression, right: ex.Expression) -> ex.Expression:
    if operator in _COMPARISONS:
        mode = _mode(left, right)
        if mode is not None and operator in ("==", "<>"):
            return mode if operator == "==" else ex.Unary("not", mode)
        return ex.Compare(_COMPARISONS[operator], left, right)
    if operator in ("AND", "OR"):
        return ex.Logic(left, ((operator.lower(), right),))
    return ex.Binary(_WORDS[operator], left, right)


def _mode(left: ex.Expression, right: ex.Expression) -> ex.SystemValue | None:
    """`$MODE_OP==#T1`: whether the controller is in this mode."""
    if type(left) is ex.Named and left.name.upper() == "$MODE_OP" and type(right) is ex.Text:
        name = MODES.get(right.value.upper())
        return None if name is None else ex.SystemValue(name)
    return None


def _is_integer(it: Any, types: Any) -> bool:
    """Whether it is surely an INT: KRL cuts the quotient of two of them."""
    if type(it) is ex.Binary:
        return it.operator != "/" and _is_integer(it.left, types) and _is_integer(it.right, types)
    if type(it) is ex.Unary:
        return _is_integer(it.operand, types)
    return not isinstance(it, KrlAggregate) and types(it) == "INT"


def _looks_like_constant(word: str) -> bool:
    return word[:1] == "#" and word[1:].isidentifier()
