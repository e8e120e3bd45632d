"""Lowers the grammar's values, conditions and EXPRESS arithmetic: one short method per rule."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from lark import Token, Transformer

from olp.ir import expressions as ex
from olp.ir.program import Speed
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendors.inform import values

_BUSES = {
    "IN": "in",
    "OT": "out",
    "IG": "in-group",
    "OG": "out-group",
    "IGH": "in-half-group",
    "OGH": "out-half-group",
    "SIN": "system-in",
    "SOUT": "system-out",
    "RIN": "direct-in",
    "AI": "analog-in",
    "AO": "analog-out",
    "MREG": "register",
}
_FRAMES = {"BF": "base", "RF": "robot", "TF": "tool", "MTF": "master-tool"}
_JOINTS = {"ANDIF": "and", "ANDEXP": "and", "ORIF": "or", "OREXP": "or"}


class InformRemark(NamedTuple):
    """Something to tell about a line that was understood. `text`: the word that it is about."""

    code: str
    text: str
    column: int


class InformExpressionRules(Transformer[Token, Any]):
    """`aliases` holds while a routine is read; `remarks` and `named_any` tell about the last line."""

    def __init__(self) -> None:
        super().__init__()
        self.aliases: Mapping[str, ex.Variable] = {}
        self.remarks: list[InformRemark] = []
        self.named_any = False

    def number(self, children: list[Token]) -> ex.Number:
        return values.number(children[0])

    def text(self, children: list[Token]) -> ex.Text:
        return ex.Text(children[0][1:-1])

    def state(self, children: list[Token]) -> ex.SignalState:
        return ex.SignalState(children[0] == "ON")

    def taught(self, children: list[Token]) -> ex.Taught:
        return values.taught(children[0])

    def variable(self, children: list[Token]) -> ex.Variable:
        return values.variable(children[0])

    def subscripted(self, children: list[Any]) -> ex.Variable:
        word, index = children
        local = word[0] == "L"
        return ex.Variable(values.STORES[str(word[1:] if local else word)], index, local)

    def named(self, children: list[Token]) -> ex.Variable | ex.Unknown:
        self.named_any = True
        name = unmangle(str(children[0]))
        found = self.aliases.get(name)
        if found is not None:
            return found
        self.remarks.append(InformRemark("P041", name, children[0].column or 1))
        return ex.Unknown(name)

    def index(self, children: list[ex.Expression]) -> ex.Expression:
        return children[0]

    def signal(self, children: list[Any]) -> ex.Signal:
        return ex.Signal(_BUSES[children[0][:-1]], children[1])

    def time(self, children: list[Any]) -> ex.Quantity:
        return checked(values.quantity(children[1], values.TIME), children[0], "a time", least=0.0)

    def speed(self, children: list[Any]) -> Speed:
        spoken = values.speed(children[0][:-1], children[1])
        checked(spoken.value, children[0], "a speed", least=0.0)  # 0 occurs in second parts, which follow
        return spoken

    def tool(self, children: list[Any]) -> ex.FrameRef:
        return ex.FrameRef("tool", children[1])

    def user(self, children: list[Any]) -> ex.FrameRef:
        return ex.FrameRef("user", children[1])

    def frame(self, children: list[Token]) -> ex.FrameRef:
        return ex.FrameRef(_FRAMES[children[0]])

    def condition(self, children: list[Any]) -> ex.Expression:
        if len(children) == 1:
            first: ex.Expression = children[0]
            return first
        rest = tuple((_JOINTS[children[i]], children[i + 1]) for i in range(1, len(children), 2))
        return ex.Logic(children[0], rest)

    def comparison(self, children: list[Any]) -> ex.Compare:
        return ex.Compare(str(children[1]), children[0], children[2])

    def binary(self, children: list[Any]) -> ex.Binary:
        return ex.Binary(str(children[1]), children[0], children[2])

    def glued(self, children: list[Any]) -> ex.Binary:
        """`LI000 -1`: a sign without a blank behind it."""
        if children[1][0] not in "+-":
            raise BrokenLineError(
                "two values without an operator between them", word=str(children[1]), wanted="+, -, * or /"
            )
        operator, number = children[1][0], children[1][1:]
        return ex.Binary(operator, children[0], values.number(number))

    def negative(self, children: list[Any]) -> ex.Unary | ex.Number:
        operand = children[1]
        if type(operand) is ex.Number:
            return ex.Number(-operand.value)
        return ex.Unary("-", operand)


def checked(quantity: ex.Quantity, tag: str, what: str, least: float | None = None) -> ex.Quantity:
    """The quantity, whose literal must be above zero, or not below `least`. Raises BrokenLineError."""
    value = quantity.literal
    if value is None or value > 0 or (least is not None and value >= least):
        return quantity
    written = quantity.written
    shown = written.value if isinstance(written, ex.Number) else ""
    wanted = "one above 0" if least is None else "one of 0 or more"
    raise BrokenLineError(f"{what} of {shown}", word=str(tag), wanted=wanted)


# --- Names ---
# Names of //ALIAS inside an instruction.
#
# Such a name may hold blanks or be a word of the language. It is rewritten, character by character, into a range of
# Unicode that no text uses, so that the grammar sees one name and all columns stay where they are.

_SHIFT = 0xE000
_LAST_SHIFTED = 0x18FF
_PLAIN = re.compile(r"[^\W\d]\w*")
_SHAPED = re.compile(r"L?(?:PX|BP|EX|[BIDRSP])\d+|(?:BC|EC|C|E)\d+|SUB\d+|T\d{5}|ARGF.*")


def mangle(name: str) -> str:
    """The name as private characters, one for one."""
    return "".join(chr(_SHIFT + ord(c)) if ord(c) <= _LAST_SHIFTED else c for c in name)


def unmangle(name: str) -> str:
    """The name as it was written."""
    if name.isascii():
        return name
    return "".join(chr(ord(c) - _SHIFT) if _SHIFT <= ord(c) <= _SHIFT + _LAST_SHIFTED else c for c in name)


def is_plain(name: str) -> bool:
    """Whether the grammar reads the name as one without help."""
    return _PLAIN.fullmatch(name) is not None and _SHAPED.fullmatch(name) is None


class Mangler:
    """Rewrites some names wherever they stand alone in a line, the longest first."""

    def __init__(self, names: Iterable[str]) -> None:
        ordered = sorted(names, key=len, reverse=True)
        alternatives = "|".join(re.escape(name) for name in ordered)
        # ARGF stands glued to its value; strings and comments are passed over as wholes.
        self._pattern = re.compile(
            rf"""("[^"]*"|'.*|//.*)|(?:(?<![\w#*:])|(?<=ARGF))({alternatives})(?!\w)"""
            if ordered
            else r"(?!)"
        )

    def __call__(self, line: str) -> str:
        return self._pattern.sub(lambda match: match[1] or mangle(match[2]), line)
