"""Lowers values and conditions: one short method per rule of the grammar."""

from __future__ import annotations

from typing import Any, Final

from lark import Token, Transformer

from olp.ir.expressions import (
    Argument,
    Binary,
    Compare,
    Expression,
    FrameRef,
    Function,
    Item,
    Logic,
    Member,
    Named,
    Number,
    Signal,
    SignalState,
    Store,
    SystemValue,
    Taught,
    Text,
    Unary,
    Unknown,
    Variable,
)
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendors.tp import values

_TIMES: Final = {"*": "*", "/": "/", "DIV": "div", "MOD": "mod"}
_HERE: Final = {"LPOS": "current-pose", "JPOS": "current-joints"}


class TpValueRules(Transformer[Token, Any]):
    """Values. Names in brackets stay with their variables as `Variable.name`."""

    def close(self, children: list[Token]) -> str:
        """The name behind the colon."""
        return str(children[0])[1:-1].strip() if children else ""

    # --- literals ---------------------------------------------------------------------------------------

    def number(self, children: list[Token]) -> Number:
        return Number(values.number(str(children[0])))

    def negative(self, children: list[Any]) -> Expression:
        value = children[0]
        if isinstance(value, Token):
            value = self.number([value])
        return Number(-value.value) if isinstance(value, Number) else Unary("-", value)

    def state(self, children: list[Token]) -> SignalState:
        return SignalState(children[0] == "ON")

    def text(self, children: list[Token]) -> Text:
        return Text(str(children[0])[1:-1])

    def text_argument(self, children: list[Token]) -> Text:
        text = str(children[0]).strip()
        return Text(text[1:-1] if text[:1] in "'\"" and len(text) > 1 else text)

    def not_(self, children: list[Expression]) -> Unary:
        return Unary("not", children[0])

    def grouped(self, children: list[Expression]) -> Expression:
        return children[0]

    # --- arithmetic and conditions ----------------------------------------------------------------------

    def add(self, children: list[Expression]) -> Binary:
        return Binary("+", *children)

    def subtract(self, children: list[Expression]) -> Binary:
        return Binary("-", *children)

    def times(self, children: list[Any]) -> Binary:
        left, word, right = children
        return Binary(_TIMES[str(word)], left, right)

    def compare(self, children: list[Any]) -> Compare:
        left, word, right = children
        return Compare(str(word), left, right)

    def equal(self, children: list[Expression]) -> Compare:
        return Compare("=", *children)

    def logic(self, children: list[Any]) -> Logic:
        """A chain of one operator is one node."""
        left, word, right = children
        operator = str(word).lower()
        if isinstance(left, Logic) and all(op == operator for op, _ in left.rest):
            return Logic(left.first, (*left.rest, (operator, right)))
        return Logic(left, ((operator, right),))

    def string_function(self, children: list[Any]) -> Function:
        return Function(values.STRING_FUNCTIONS[str(children[0])], tuple(children[1:]))

    def function(self, children: list[Any]) -> Function:
        return Function(values.FUNCTIONS[str(children[0])[:-1]], tuple(children[1:]))

    # --- variables --------------------------------------------------------------------------------------

    def register(self, children: list[Any]) -> Variable:
        return Variable(Store.REAL, children[1], name=children[2])

    def string_register(self, children: list[Any]) -> Variable:
        return Variable(Store.STRING, children[1], name=children[2])

    def argument_register(self, children: list[Any]) -> Argument:
        index = children[1]
        if not isinstance(index, Number):
            raise BrokenLineError("an argument without a fixed number", wanted="a number, as in AR[1]")
        return Argument(int(index.value))

    def position_register(self, children: list[Any]) -> Variable:
        return Variable(_group(children[0]), children[1], name=children[2])

    def element(self, children: list[Any]) -> Expression:
        start, index, place, name = children
        variable = Variable(_group(start), index, name=name)
        if isinstance(place, Number) and 1 <= place.value <= len(values.ELEMENTS):
            return Member(variable, values.ELEMENTS[int(place.value) - 1])
        return Item(variable, (place,))

    def point(self, children: list[Any]) -> Expression:
        """P[3]; a point whose number is computed is the function `taught` of it."""
        index = children[1]
        if isinstance(index, Number):
            return Taught(Store.ROBOT, int(index.value))
        return Function("taught", (index,))

    def signal(self, children: list[Any]) -> Signal:
        return Signal(values.BUSES[str(children[0])[:-1]], children[1])

    def frame(self, children: list[Any]) -> FrameRef:
        return FrameRef("user" if children[0] == "UFRAME[" else "tool", children[1])

    def timer_value(self, children: list[Any]) -> Expression:
        index = children[1]
        if not isinstance(index, Number):
            return Function("timer", (index,))
        return SystemValue("timer", int(index.value))

    def system(self, children: list[Token]) -> Named:
        return Named("".join(str(children[0]).split()))

    def unmodelled(self, children: list[Token]) -> Unknown:
        return Unknown(str(children[0]))

    def here(self, children: list[Token]) -> SystemValue:
        return SystemValue(_HERE[str(children[0])])


def _group(start: Token) -> Store:
    """Of which motion group PR[GP2:… is; the first one without."""
    text = str(start)
    group = int(text[5]) if len(text) > 3 else 1
    if group not in values.GROUP_STORES:
        raise BrokenLineError(f"motion group {group}", wanted="one of GP1 to GP4")
    return values.GROUP_STORES[group]
