"""Lowers motion instructions: speed, termination and options of a J, L, C, A or S line."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

from lark import Token, Transformer

from olp.core.units import mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import edited
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendors.tp import values

# --- Expressions ---
# Lowers values and conditions: one short method per rule of the grammar.

_TIMES: Final = {"*": "*", "/": "/", "DIV": "div", "MOD": "mod"}
_HERE: Final = {"LPOS": "current-pose", "JPOS": "current-joints"}


class TpValueRules(Transformer[Token, Any]):
    """Values. Names in brackets stay with their variables as `Variable.name`."""

    def close(self, children: list[Token]) -> str:
        """The name behind the colon."""
        return str(children[0])[1:-1].strip() if children else ""

    # --- literals ---------------------------------------------------------------------------------------

    def number(self, children: list[Token]) -> ex.Number:
        return ex.Number(values.number(str(children[0])))

    def negative(self, children: list[Any]) -> ex.Expression:
        value = children[0]
        if isinstance(value, Token):
            value = self.number([value])
        return ex.Number(-value.value) if isinstance(value, ex.Number) else ex.Unary("-", value)

    def state(self, children: list[Token]) -> ex.SignalState:
        return ex.SignalState(children[0] == "ON")

    def text(self, children: list[Token]) -> ex.Text:
        return ex.Text(str(children[0])[1:-1])

    def text_argument(self, children: list[Token]) -> ex.Text:
        text = str(children[0]).strip()
        return ex.Text(text[1:-1] if text[:1] in "'\"" and len(text) > 1 else text)

    def not_(self, children: list[ex.Expression]) -> ex.Unary:
        return ex.Unary("not", children[0])

    def grouped(self, children: list[ex.Expression]) -> ex.Expression:
        return children[0]

    # --- arithmetic and conditions ----------------------------------------------------------------------

    def add(self, children: list[ex.Expression]) -> ex.Binary:
        return ex.Binary("+", *children)

    def subtract(self, children: list[ex.Expression]) -> ex.Binary:
        return ex.Binary("-", *children)

    def times(self, children: list[Any]) -> ex.Binary:
        left, word, right = children
        return ex.Binary(_TIMES[str(word)], left, right)

    def compare(self, children: list[Any]) -> ex.Compare:
        left, word, right = children
        return ex.Compare(str(word), left, right)

    def equal(self, children: list[ex.Expression]) -> ex.Compare:
        return ex.Compare("=", *children)

    def logic(self, children: list[Any]) -> ex.Logic:
        """A chain of one operator is one node."""
        left, word, right = children
        operator = str(word).lower()
        if isinstance(left, ex.Logic) and all(op == operator for op, _ in left.rest):
            return ex.Logic(left.first, (*left.rest, (operator, right)))
        return ex.Logic(left, ((operator, right),))

    def string_function(self, children: list[Any]) -> ex.Function:
        return ex.Function(values.STRING_FUNCTIONS[str(children[0])], tuple(children[1:]))

    def function(self, children: list[Any]) -> ex.Function:
        return ex.Function(values.FUNCTIONS[str(children[0])[:-1]], tuple(children[1:]))

    # --- variables --------------------------------------------------------------------------------------

    def register(self, children: list[Any]) -> ex.Variable:
        return ex.Variable(ex.Store.REAL, children[1], name=children[2])

    def string_register(self, children: list[Any]) -> ex.Variable:
        return ex.Variable(ex.Store.STRING, children[1], name=children[2])

    def argument_register(self, children: list[Any]) -> ex.Argument:
        index = children[1]
        if not isinstance(index, ex.Number):
            raise BrokenLineError("an argument without a fixed number", wanted="a number, as in AR[1]")
        return ex.Argument(int(index.value))

    def position_register(self, children: list[Any]) -> ex.Variable:
        return ex.Variable(_group(children[0]), children[1], name=children[2])

    def element(self, children: list[Any]) -> ex.Expression:
        start, index, place, name = children
        variable = ex.Variable(_group(start), index, name=name)
        if isinstance(place, ex.Number) and 1 <= place.value <= len(values.ELEMENTS):
            return ex.Member(variable, values.ELEMENTS[int(place.value) - 1])
        return ex.Item(variable, (place,))

    def point(self, children: list[Any]) -> ex.Expression:
        """P[3]; a point whose number is computed is the function `taught` of it."""
        index = children[1]
        if isinstance(index, ex.Number):
            return ex.Taught(ex.Store.ROBOT, int(index.value))
        return ex.Function("taught", (index,))

    def signal(self, children: list[Any]) -> ex.Signal:
        return ex.Signal(values.BUSES[str(children[0])[:-1]], children[1], name=children[2])

    def frame(self, children: list[Any]) -> ex.FrameRef:
        return ex.FrameRef("user" if children[0] == "UFRAME[" else "tool", children[1])

    def timer_value(self, children: list[Any]) -> ex.Expression:
        index = children[1]
        if not isinstance(index, ex.Number):
            return ex.Function("timer", (index,))
        return ex.SystemValue("timer", int(index.value), children[2])

    def system(self, children: list[Token]) -> ex.Named:
        return ex.Named("".join(str(children[0]).split()))

    def unmodelled(self, children: list[Token]) -> ex.Unknown:
        return ex.Unknown(str(children[0]))

    def here(self, children: list[Token]) -> ex.SystemValue:
        return ex.SystemValue(_HERE[str(children[0])])


def _group(start: Token) -> ex.Store:
    """Of which motion group PR[GP2:… is; the first one without."""
    text = str(start)
    group = int(text[5]) if len(text) > 3 else 1
    if group not in values.GROUP_STORES:
        raise BrokenLineError(f"motion group {group}", wanted="one of GP1 to GP4")
    return values.GROUP_STORES[group]


# --- Moves ---

OWN = ex.FrameRef(
    "own"
)  # an incremental position is added in its own kind: joints to joints, a pose along its frame
WELD_SPEED = ex.SystemValue("weld-speed")


# Time and distance before (R-30iB, operator's manual).
_TRIGGERS: Final = "triggers"
_TRIGGER: Final = re.compile(
    r"(?:(?P<word>T[AB])\s+(?P<far>\d*\.?\d+)\s*sec|(?P<db>DB)\s+(?P<way>\d*\.?\d+)\s*mm)\s*,\s*"
    r"(?P<bus>[DRGA]O)\[(?P<number>\d+)(?::[^\]]*)?\]\s*=\s*\(?(?P<value>ON|OFF|-?\d*\.?\d+)\)?"
)


class TpMoveOption(NamedTuple):
    """One option of a move: the field of `Move` that it sets, "" for one that is kept as written."""

    field: str
    value: Any


class TpMoveRules(TpValueRules):
    """Motion."""

    def position(self, children: list[ex.Expression]) -> ex.Expression:
        return children[0]

    def motion(self, children: list[Any]) -> st.Move:
        letter = str(children[0])
        positions = [one for one in children[1:3] if one is not None]
        speed, corner = children[3], children[4]
        options: list[TpMoveOption] = [one for one in children[5:] if one is not None]
        path = values.PATHS[letter]
        if (len(positions) == 2) != (letter == "C"):
            wanted = "two positions, as in C P[1] P[2] 100mm/sec FINE" if letter == "C" else "one position"
            raise BrokenLineError(f"a {letter} move with {len(positions)} positions", wanted=wanted)
        if speed is None:
            raise BrokenLineError("a move without a speed", wanted="a speed such as 100mm/sec or 50%")
        if corner is None:
            raise BrokenLineError("a move without a termination", wanted="FINE or CNT0 .. CNT100")
        fields: dict[str, Any] = {one.field: one.value for one in options if one.field}
        other = [one.value for one in options if not one.field]
        triggers = [one.value for one in options if one.field == _TRIGGERS]
        if triggers:
            fields[_TRIGGERS] = tuple(triggers)
        return st.Move(
            0,
            path,
            (positions[-1],),
            speed,
            corner,
            via=positions[0] if letter == "C" else None,
            other=tuple(other),
            **fields,
        )

    # --- speed ------------------------------------------------------------------------------------------

    def speed(self, children: list[Any]) -> st.Speed:
        if isinstance(children[0], Token):
            if children[0].type == "WELD_SPEED":
                return st.Speed(st.SpeedUnit.TRAVEL, ex.Quantity(WELD_SPEED, mm), "WELD_SPEED")
            return st.Speed(st.SpeedUnit.TRAVEL, ex.Quantity(ex.Number(values.FASTEST_LINE), mm), "max_speed")
        value, word = children
        unit, scale = values.UNITS[str(word)]
        if isinstance(value, ex.Number) and not value.value > 0:
            raise BrokenLineError("a speed that is not positive", wanted="a number above 0")
        return st.Speed(unit, ex.Quantity(value, scale))

    def termination(self, children: list[Any]) -> st.Blend:
        word = str(children[0])
        if word == "FINE":
            return values.FINE
        kind, scale = values.CORNERS[word]
        if len(children) == 1 or children[1] is None:
            raise BrokenLineError(f"{word} without its number", wanted=f"{word}50")
        native = "" if word == "CNT" else word
        if len(children) > 2 and children[2] is not None:
            native = f"{word},{_literal(children[2])}"
        return st.Blend(kind, ex.Quantity(children[1], scale), native)

    # --- options ----------------------------------------------------------------------------------------

    def acceleration(self, children: list[Any]) -> TpMoveOption:
        return TpMoveOption("acceleration", ex.Quantity(children[1], values.PERCENT))

    def offset(self, children: list[Any]) -> TpMoveOption:
        if len(children) == 1 or children[1] is None:
            return TpMoveOption("", ("Offset", ex.Text("")))
        return TpMoveOption("offset", children[1])

    def tool_offset(self, children: list[Any]) -> TpMoveOption:
        if len(children) == 1 or children[1] is None:
            return TpMoveOption("", ("Tool_Offset", ex.Text("")))
        return TpMoveOption("tool_offset", children[1])

    def incremental(self, _: list[Any]) -> TpMoveOption:
        return TpMoveOption("relative", OWN)

    def other(self, children: list[Token]) -> TpMoveOption:
        text = str(children[0])
        trigger = _trigger(text)
        return kept(text) if trigger is None else TpMoveOption(_TRIGGERS, trigger)


def _trigger(text: str) -> st.PathTrigger | None:
    """TB, TA or DB with an output; None for any other option, such as one that calls a program."""
    match = _TRIGGER.fullmatch(text.strip())
    if match is None:
        return None
    state = match["value"]
    value = ex.SignalState(state == "ON") if state in ("ON", "OFF") else ex.Number(float(state))
    signal = ex.Signal(values.BUSES[match["bus"]], ex.Number(int(match["number"])))
    if match["db"]:
        return st.PathTrigger(signal, value, False, metres=ex.Quantity(ex.Number(-float(match["way"])), mm))
    seconds = float(match["far"]) * (1.0 if match["word"] == "TA" else -1.0)
    return st.PathTrigger(signal, value, False, seconds=ex.Quantity(ex.Number(seconds), 1.0))


def kept(text: str) -> TpMoveOption:
    """An option that is not modelled: its first word, and the rest as written."""
    text = " ".join(text.split())
    length = next((at for at, char in enumerate(text) if not (char.isalpha() or char in "_-")), len(text))
    return TpMoveOption("", (text[:length], ex.Text(text[length:])))


def _literal(value: ex.Expression) -> str:
    if not isinstance(value, ex.Number):
        raise BrokenLineError("a register as the second number of a corner", wanted="a number, as in CR5,10")
    return str(value.value)


# --- Conditions of offsets ---
# `OFFSET CONDITION PR[1]`, `TOOL_OFFSET CONDITION PR[2]`: by what moves are offset that name no register.

_CONDITIONS: Final = {
    "OFFSET CONDITION": ("offset", "Offset"),
    "TOOL_OFFSET CONDITION": ("tool_offset", "Tool_Offset"),
}


def with_conditions(body: Sequence[st.Statement]) -> Sequence[st.Statement]:
    """The statements with the offsets of their moves, where the text tells them: one condition precedes all of them."""
    given: dict[str, set[ex.Expression]] = {}
    for s in body:
        if isinstance(s, st.Process) and s.name in _CONDITIONS:
            given.setdefault(_CONDITIONS[s.name][0], set()).add(s.arguments[0][1])
    if not given:
        return body
    rows: list[st.Statement] = []
    holds: dict[str, ex.Expression] = {}
    for s in body:
        if isinstance(s, st.Process) and s.name in _CONDITIONS:
            holds[_CONDITIONS[s.name][0]] = s.arguments[0][1]
        elif isinstance(s, st.WAYS_MEET):
            holds = {part: e for part, e in holds.items() if len(given[part]) == 1}
        rows.append(_with_offsets(s, holds) if isinstance(s, st.Move) and s.other else s)
    return rows


def _with_offsets(s: st.Move, holds: Mapping[str, ex.Expression]) -> st.Move:
    for part, word in _CONDITIONS.values():
        if part in holds and (word, ex.Text("")) in s.other:
            s = edited(
                s, {"other": tuple(one for one in s.other if one != (word, ex.Text(""))), part: holds[part]}
            )
    return s
