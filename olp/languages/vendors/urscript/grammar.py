"""The URScript parser: built once per process from grammars/urscript.lark, shared by all reads."""

from __future__ import annotations

from functools import cache
from typing import Any

from lark import Token, Transformer

from olp.languages.lark_host import Grammar
from olp.languages.vendors.urscript.syntax import (
    Assignment,
    Closing,
    Definition,
    Evaluation,
    Instruction,
    Invocation,
    ListOf,
    Literal,
    Node,
    Opening,
    Running,
    Sign,
    Subscript,
    UrscriptArgument,
    UrscriptDot,
    UrscriptKeyword,
    UrscriptName,
    UrscriptPair,
    pose_of,
)


class Rules(Transformer[Token, Any]):
    """One short method per rule of the grammar."""

    def instruction(self, children: list[Any]) -> Instruction:
        return children[0]  # type: ignore[no-any-return]

    def definition(self, children: list[Any]) -> Definition:
        kind, name, parameters = children
        return Definition(str(kind), str(name), tuple(parameters or ()))

    def parameters(self, children: list[Any]) -> list[Any]:
        return children

    def parameter(self, children: list[Any]) -> tuple[str, Node | None]:
        return str(children[0]), children[1]

    # --- blocks -----------------------------------------------------------------------------------------

    def if_(self, children: list[Any]) -> Opening:
        return Opening("if", children[0], *children[1])

    def else_if(self, children: list[Any]) -> Opening:
        return Opening("elif", children[0], *children[1])

    def else_(self, children: list[Any]) -> Opening:
        return Opening("else", None, *children[0])

    def while_(self, children: list[Any]) -> Opening:
        return Opening("while", children[0], *children[1])

    def rest(self, children: list[Any]) -> tuple[Any, bool]:
        return children[0], children[1] is not None

    def closed(self, _: list[Any]) -> bool:
        return True

    def end(self, _: list[Any]) -> Closing:
        return Closing()

    # --- statements -------------------------------------------------------------------------------------

    def return_(self, children: list[Any]) -> UrscriptKeyword:
        return UrscriptKeyword("return", children[0])

    def break_(self, _: list[Any]) -> UrscriptKeyword:
        return UrscriptKeyword("break", None)

    def continue_(self, _: list[Any]) -> UrscriptKeyword:
        return UrscriptKeyword("continue", None)

    def join(self, children: list[Any]) -> UrscriptKeyword:
        return UrscriptKeyword("join", children[0])

    def kill(self, children: list[Any]) -> UrscriptKeyword:
        return UrscriptKeyword("kill", children[0])

    def assign(self, children: list[Any]) -> Assignment:
        scope, target, value = children
        return Assignment(str(scope or ""), target, "=", value)

    def update(self, children: list[Any]) -> Assignment:
        target, operator, value = children
        return Assignment("", target, str(operator), value)

    def evaluate(self, children: list[Any]) -> Evaluation:
        return Evaluation(children[0])

    # --- expressions ------------------------------------------------------------------------------------

    def or_(self, children: list[Node]) -> Node:
        return _chain("or", children)

    def xor(self, children: list[Node]) -> Node:
        return _chain("xor", children)

    def and_(self, children: list[Node]) -> Node:
        return _chain("and", children)

    def not_(self, children: list[Node]) -> Node:
        return Sign("not", children[0])

    def compare(self, children: list[Any]) -> Node:
        return _left(children)

    def sum(self, children: list[Any]) -> Node:
        return _left(children)

    def product(self, children: list[Any]) -> Node:
        return _left(children)

    def sign(self, children: list[Any]) -> Node:
        operator, operand = str(children[0]), children[1]
        if operator == "+":
            return operand  # type: ignore[no-any-return]
        if isinstance(operand, Literal) and isinstance(operand.value, (int, float)):
            return Literal(-operand.value)
        return Sign(operator, operand)

    def run(self, children: list[Node]) -> Node:
        return Running(children[0])

    def call(self, children: list[Any]) -> Node:
        return Invocation(children[0], tuple(children[1] or ()))

    def arguments(self, children: list[Any]) -> list[UrscriptArgument]:
        return [one if type(one) is UrscriptArgument else UrscriptArgument("", one) for one in children]

    def named(self, children: list[Any]) -> UrscriptArgument:
        return UrscriptArgument(str(children[0]), children[1])

    def expressions(self, children: list[Node]) -> tuple[Node, ...]:
        return tuple(children)

    def subscript(self, children: list[Any]) -> Node:
        base, indices = children
        # A variable may be called p: one index, or two of a matrix, are no pose.
        if base == UrscriptName("p") and len(indices) > 2:
            return pose_of(indices)
        return Subscript(base, indices)

    def member(self, children: list[Any]) -> Node:
        return UrscriptDot(children[0], str(children[1]))

    def name(self, children: list[Token]) -> Node:
        return UrscriptName(str(children[0]))

    def number(self, children: list[Token]) -> Node:
        text = str(children[0])
        if text[:2] in ("0x", "0X"):
            return Literal(int(text, 16))
        return Literal(int(text) if text.isdigit() else float(text))

    def text(self, children: list[Token]) -> Node:
        return Literal(str(children[0])[1:-1])

    def true(self, _: list[Any]) -> Node:
        return Literal(True)

    def false(self, _: list[Any]) -> Node:
        return Literal(False)

    def sequence(self, children: list[Any]) -> Node:
        return ListOf(tuple(children[0] or ()))


def _chain(operator: str, operands: list[Node]) -> Node:
    result = operands[0]
    for operand in operands[1:]:
        result = UrscriptPair(operator, result, operand)
    return result


def _left(children: list[Any]) -> Node:
    """`a op b op c` as ((a op b) op c)."""
    result: Node = children[0]
    for operator, operand in zip(children[1::2], children[2::2], strict=True):
        result = UrscriptPair(str(operator), result, operand)
    return result


@cache
def instruction_parser() -> Grammar:
    """The one parser of this process."""
    return Grammar("urscript", Rules())
