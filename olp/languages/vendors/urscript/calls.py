"""Lowers calls that are statements and no moves: signals, waits, messages, settings, and functions of the program."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

from olp.ir import expressions as ex
from olp.ir.program import Call, Dwell, Message, Pause, Process, SetOutput, SetTool, Statement, Wait
from olp.languages.vendors.urscript import builtins, helpers
from olp.languages.vendors.urscript.expressions import Expressions, method_name, signal_of
from olp.languages.vendors.urscript.lines import UrscriptLine
from olp.languages.vendors.urscript.scopes import UrscriptPart
from olp.languages.vendors.urscript.syntax import (
    Assignment,
    Closing,
    Evaluation,
    Invocation,
    Node,
    Opening,
    Simple,
    UrscriptArgument,
    UrscriptName,
    UrscriptPair,
    fold,
)

_POPUP: Final = ("s", "title", "warning", "error", "blocking")


class CallRules:
    """Lowers the calls of one part. `tell`: takes (code, message, help)."""

    def __init__(self, expressions: Expressions, tell: Callable[[str, str, str], None]) -> None:
        self._expressions = expressions
        self._tell = tell

    def statements(self, call: Invocation, line: int, comment: str) -> list[Statement]:
        """What the call does, one statement or several on one line."""
        if type(call.function) is not UrscriptName:
            return [Process(line, method_name(call.function), self._tagged(call.arguments), comment)]
        name = call.function.text
        called = self._expressions.part.find(name)
        if called is not None:
            arguments = self._expressions.passed(called, call.arguments)
            return [Call(line, called.unique, arguments, comment=comment)]
        rule = _RULES.get(name)
        if rule is not None:
            found = rule(self, name, call.arguments, line, comment)
            if found:
                return found
        if name in builtins.SENSED_MOTION:
            message = f"{name} moves as sensors or other threads say: kept, its way and time are unknown"
            self._tell("P560", message, "say how long it takes in olp.toml")
        if name in builtins.KNOWN:
            return [Process(line, name, self._tagged(call.arguments), comment)]
        help = "its file beside this one is looked for when the program runs"
        self._tell("P555", f"{name} is not defined in this file", help)
        return [Call(line, name, self._expressions.arguments(call.arguments), comment=comment)]

    def _tagged(self, given: tuple[UrscriptArgument, ...]) -> tuple[tuple[str, ex.Expression], ...]:
        return tuple((one.name, self._expressions.lower(one.value)) for one in given)

    def _by_name(self, given: tuple[UrscriptArgument, ...], places: tuple[str, ...]) -> dict[str, Node]:
        found: dict[str, Node] = {}
        for index, one in enumerate(given):
            found[one.name or (places[index] if index < len(places) else f"{index}")] = one.value
        return found

    def _dwell(
        self, name: str, given: tuple[UrscriptArgument, ...], line: int, comment: str
    ) -> list[Statement]:
        if len(given) != 1:
            self._tell(
                "P558", f"sleep takes one argument, not {len(given)}", "sleep(0.5) waits half a second"
            )
            return []
        value = given[0].value
        if is_step(value):
            return [Process(line, "sync", (("sleep", ex.SignalState(True)),), comment)]
        return [Dwell(line, ex.Quantity(fold(self._expressions.lower(value)), 1.0), comment)]

    def _output(
        self, name: str, given: tuple[UrscriptArgument, ...], line: int, comment: str
    ) -> list[Statement]:
        if len(given) != 2:
            self._tell("P558", f"{name} takes two arguments, not {len(given)}", f"{name}(1, True)")
            return []
        signal = signal_of(self._expressions, name, builtins.OUTPUTS[name], given[0].value)
        return [SetOutput(line, signal, self._expressions.lower(given[1].value), comment)]

    def _tool(
        self, name: str, given: tuple[UrscriptArgument, ...], line: int, comment: str
    ) -> list[Statement]:
        """set_tcp(pose, tcp_name)."""
        if not given:
            self._tell("P558", "set_tcp has no pose", "set_tcp(p[x, y, z, rx, ry, rz])")
            return []
        tool = self._expressions.lower(given[0].value)
        if len(given) > 1:
            label = self._expressions.lower(given[1].value)
            text = label.value if type(label) is ex.Text else ""
            if type(tool) is ex.PositionLiteral:
                tool = replace(tool, native=(*tool.native, ("name", text)))
            else:
                comment = f"{text} {comment}".strip()
        return [SetTool(line, tool, comment)]

    def _popup(
        self, name: str, given: tuple[UrscriptArgument, ...], line: int, comment: str
    ) -> list[Statement]:
        found = self._by_name(given, _POPUP)
        text, blocking = found.pop("s", None), found.pop("blocking", None)
        if text is None:
            return []
        waits = None if blocking is None else self._expressions.lower(blocking)
        options = [(option, self._expressions.lower(value)) for option, value in found.items()]
        if waits is not None and type(waits) is not ex.SignalState:
            options.append(("blocking", waits))
        message = Message(line, self._expressions.lower(text), comment)
        if waits != ex.SignalState(True):
            return [Process(line, "popup", tuple(options)), message]
        if message.text == ex.Text("") and not options:
            return [Pause(line, comment=comment)]  # it says nothing, and waits for the operator
        before: list[Statement] = [Process(line, "popup", tuple(options))] if options else []
        return [*before, message, Pause(line)]

    def _message(
        self, name: str, given: tuple[UrscriptArgument, ...], line: int, comment: str
    ) -> list[Statement]:
        if not given or any(one.name not in ("", "s1", "s2") for one in given):
            return []
        texts = tuple(self._expressions.lower(one.value) for one in given)
        text = texts[0] if len(texts) == 1 else ex.Function("joined-text", texts)
        return [Message(line, text, comment)]


def is_step(value: Node) -> bool:
    """get_steptime(): one cycle of the controller."""
    return type(value) is Invocation and value.function == UrscriptName("get_steptime")


Rule = Callable[[CallRules, str, tuple[UrscriptArgument, ...], int, str], list[Statement]]
_RULES: Final[Mapping[str, Rule]] = {
    **dict.fromkeys(builtins.OUTPUTS, CallRules._output),
    "sleep": CallRules._dwell,
    "set_tcp": CallRules._tool,
    "popup": CallRules._popup,
    "textmsg": CallRules._message,
}


# --- Waits ---
# Loops that do nothing but wait: what they wait for, and for how long at most.

_INVERTED: Final = {"=": "<>", "<>": "=", "<": ">=", ">": "<=", "<=": ">", ">=": "<"}
_COUNTER: Final = UrscriptName(helpers.COUNTER)


class Waits:
    """Finds the waits of one part."""

    def __init__(self, part: UrscriptPart, expressions: Expressions) -> None:
        self._part = part
        self._expressions = expressions

    def at(self, index: int, line: UrscriptLine) -> tuple[Wait, int] | None:
        """The wait that begins here, and how many lines it has; None when the lines do more than wait."""
        if _is_count(line.content):
            return self._timed(index, line)
        return self._wait(index, line)

    def _wait(self, index: int, line: UrscriptLine) -> tuple[Wait, int] | None:
        lines = self._part.lines
        opening = lines[index][0].content
        if type(opening) is not Opening or opening.word != "while" or opening.condition is None:
            return None
        condition = self._expressions.lower(opening.condition)
        if type(condition) is ex.SignalState:
            return None
        if opening.closed:
            idle: object = opening.rest
            count = 1
        else:
            idle = None if opening.rest is not None else self._inside(index, 1)
            count = 3
        if not isinstance(idle, Evaluation) or not _is_idle(idle):
            return None
        assert isinstance(idle.value, Invocation)  # a call of sync or sleep
        spelling = "sleep" if idle.value.arguments else ""
        return Wait(line.number, inverted(condition), comment=line.comment, spelling=spelling), count

    def _inside(self, index: int, count: int) -> object:
        """The first of `count` instructions in the block that `index` opens, None unless it holds just as many."""
        lines = self._part.lines
        if index + count + 1 >= len(lines):
            return None
        closing, outside = lines[index + count + 1]
        depth = lines[index][1]
        if type(closing.content) is not Closing or closing.comment or outside != depth:
            return None
        inside = lines[index + 1 : index + count + 1]
        if any(line.comment or place != depth + 1 for line, place in inside):
            return None
        return inside[0][0].content

    def _timed(self, index: int, line: UrscriptLine) -> tuple[Wait, int] | None:
        """A wait that gives up, as olp writes it: a counter runs down beside the condition."""
        lines = self._part.lines
        if index + 4 >= len(lines):
            return None
        start, opening, last = (lines[index + n][0].content for n in (0, 1, 3))
        idle = self._inside(index + 1, 2)
        if type(opening) is not Opening or opening.word != "while" or opening.rest is not None:
            return None
        if not isinstance(idle, Evaluation) or not _is_idle(idle) or not _is_count(last):
            return None
        match opening.condition:
            case UrscriptPair("and", UrscriptPair(">", UrscriptName(helpers.COUNTER), _), condition):
                assert isinstance(start, Assignment)  # `_is_count` has seen it
                timeout = ex.Quantity(fold(self._expressions.lower(start.value)), 1.0)
                waited = inverted(self._expressions.lower(condition))
                return Wait(line.number, waited, timeout, line.comment), 5
        return None


def inverted(condition: ex.Expression) -> ex.Expression:
    """What holds when the condition does not; twice inverted it is what it was."""
    if type(condition) is ex.Compare:
        if type(condition.right) is ex.SignalState and condition.operator in ("=", "<>"):
            return ex.Compare(condition.operator, condition.left, ex.SignalState(not condition.right.on))
        return ex.Compare(_INVERTED[condition.operator], condition.left, condition.right)
    if type(condition) is ex.Unary and condition.operator == "not":
        return condition.operand
    return ex.Unary("not", condition)


def _is_count(content: object) -> bool:
    """Whether the counter of a wait gets a value."""
    return isinstance(content, Assignment) and content.target == _COUNTER


def _is_idle(simple: Simple) -> bool:
    """sync() or sleep(get_steptime())."""
    if type(simple) is not Evaluation or type(simple.value) is not Invocation:
        return False
    call = simple.value
    if call.function == UrscriptName("sync") and not call.arguments:
        return True
    return (
        call.function == UrscriptName("sleep")
        and len(call.arguments) == 1
        and is_step(call.arguments[0].value)
    )
