"""Lowers calls that are statements and no moves: signals, waits, messages, settings, and functions of the program."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

from olp.ir.expressions import Expression, Function, PositionLiteral, Quantity, Signal, SignalState, Text
from olp.ir.moves import SetTool
from olp.ir.program import Call, Dwell, Message, Pause, Process, SetOutput, Statement
from olp.languages.vendors.urscript import builtins
from olp.languages.vendors.urscript.expressions import Expressions, method_name
from olp.languages.vendors.urscript.folding import fold
from olp.languages.vendors.urscript.syntax import Invocation, Node, UrscriptArgument, UrscriptName

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

    def _tagged(self, given: tuple[UrscriptArgument, ...]) -> tuple[tuple[str, Expression], ...]:
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
            return [Process(line, "sync", (("sleep", SignalState(True)),), comment)]
        return [Dwell(line, Quantity(fold(self._expressions.lower(value)), 1.0), comment)]

    def _output(
        self, name: str, given: tuple[UrscriptArgument, ...], line: int, comment: str
    ) -> list[Statement]:
        if len(given) != 2:
            self._tell("P558", f"{name} takes two arguments, not {len(given)}", f"{name}(1, True)")
            return []
        number, value = (self._expressions.lower(one.value) for one in given)
        return [SetOutput(line, Signal(builtins.OUTPUTS[name], number), value, comment)]

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
            text = label.value if type(label) is Text else ""
            if type(tool) is PositionLiteral:
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
        if waits is not None and type(waits) is not SignalState:
            options.append(("blocking", waits))
        message = Message(line, self._expressions.lower(text), comment)
        if waits != SignalState(True):
            return [Process(line, "popup", tuple(options)), message]
        if message.text == Text("") and not options:
            return [Pause(line, comment=comment)]  # it says nothing, and waits for the operator
        before: list[Statement] = [Process(line, "popup", tuple(options))] if options else []
        return [*before, message, Pause(line)]

    def _message(
        self, name: str, given: tuple[UrscriptArgument, ...], line: int, comment: str
    ) -> list[Statement]:
        if not given or any(one.name not in ("", "s1", "s2") for one in given):
            return []
        texts = tuple(self._expressions.lower(one.value) for one in given)
        text = texts[0] if len(texts) == 1 else Function("joined-text", texts)
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
