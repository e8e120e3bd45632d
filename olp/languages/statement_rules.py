"""Rules that the short readers share: values, conditions and blocks, one short method per rule of their grammars."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, Final

from lark import Token, Tree

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.languages.short_reader import constants, joints

Statements = st.Statement | list[st.Statement]
_COMPARE: Final = {
    "==": "=",
    "=": "=",
    "<>": "<>",
    "!=": "<>",
    "=<": "<=",
    "=>": ">=",
    "<=": "<=",
    ">=": ">=",
}


class ValueRules:
    """Lowering rules of numbers, texts, arithmetic and conditions; each rule of a grammar has one short method.

    `spellings`: the first spelling of each name, for languages that ignore case. `settled_by`: every setting that
    the lowering depends on, None where that cannot be stated; with the same settings a line's earlier result is
    used again.
    """

    settled_by: Hashable = None

    def __init__(self, fold: bool = True) -> None:
        self.spellings: dict[str, str] = {}
        self.asked: list[tuple[str, str]] | None = (
            None  # while somebody wants to know: names, and how they are spelled
        )
        self._fold = fold

    def transform(self, tree: Tree[Token]) -> Any:
        """Return what the rules' methods make of a tree; children are lowered first. Raises what the methods raise.

        It replaces lark's Transformer, which takes twice the time: it also looks for methods of tokens and wraps
        exceptions.
        """
        children = [self.transform(one) if type(one) is Tree else one for one in tree.children]
        method = getattr(self, tree.data, None)
        if method is None:
            raise TypeError(f"the rule '{tree.data}' of the grammar has no method in {type(self).__name__}")
        return method(children)

    def spelled(self, name: str) -> str:
        found = self.spellings.setdefault(name.casefold(), name) if self._fold else name
        if self.asked is not None:
            self.asked.append((name, found))
        return found

    def name(self, children: list[Any]) -> ex.Expression:
        return ex.Named(self.spelled(str(children[0])))

    def item(self, children: list[Any]) -> ex.Expression:
        return ex.Item(ex.Named(self.spelled(str(children[0]))), tuple(children[1]))

    def indices(self, children: list[Any]) -> list[Any]:
        return children

    arguments = indices

    def number(self, children: list[Token]) -> ex.Number:
        text = str(children[0])
        if text[:2].lower() == "0x":
            return ex.Number(int(text, 16))
        return ex.Number(int(text) if text.isdigit() else float(text))

    def text(self, children: list[Token]) -> ex.Text:
        return ex.Text(str(children[0])[1:-1])

    def on(self, _: list[Any]) -> ex.SignalState:
        return ex.SignalState(True)

    def off(self, _: list[Any]) -> ex.SignalState:
        return ex.SignalState(False)

    def negative(self, children: list[Any]) -> ex.Expression:
        value = children[0]
        return ex.Number(-value.value) if isinstance(value, ex.Number) else ex.Unary("-", value)

    def not_(self, children: list[Any]) -> ex.Unary:
        return ex.Unary("not", children[0])

    def sum(self, children: list[Any]) -> ex.Expression:
        return self._chain(children, lambda word: str(word))

    def product(self, children: list[Any]) -> ex.Expression:
        return self._chain(children, lambda word: {"%": "mod"}.get(str(word), str(word).lower()))

    def _chain(self, children: list[Any], operator: Callable[[Any], str]) -> ex.Expression:
        value: ex.Expression = children[0]
        for word, right in zip(children[1::2], children[2::2], strict=True):
            value = ex.Binary(operator(word), value, right)
        return value

    def compare(self, children: list[Any]) -> ex.Compare:
        left, word, right = children
        return ex.Compare(_COMPARE.get(str(word), str(word)), left, right)

    def conjunction(self, children: list[Any]) -> ex.Expression:
        first, *rest = children
        pairs = zip(rest[::2], rest[1::2], strict=True)
        return ex.Logic(first, tuple((str(word).lower(), right) for word, right in pairs))

    disjunction = conjunction


class BlockWords:
    """Lowering rules of statements that open, divide and close blocks, and of what stands in them; a grammar names
    those it needs, and a language's own rule of the same name goes first: it may make several statements of its line.
    """

    def plain(self, value: Any) -> Any:
        """What a statement holds of a value that a rule has made."""
        return value

    def if_(self, children: list[Any]) -> Statements:
        return st.If(0, self.plain(children[0]))

    def else_if(self, children: list[Any]) -> Statements:
        return st.ElseIf(0, self.plain(children[0]))

    def else_(self, _: list[Any]) -> Statements:
        return st.Else(0)

    def end_if(self, _: list[Any]) -> Statements:
        return st.EndIf(0)

    def while_(self, children: list[Any]) -> Statements:
        return st.While(0, self.plain(children[0]))

    def end_while(self, _: list[Any]) -> Statements:
        return st.EndWhile(0)

    def end_for(self, _: list[Any]) -> Statements:
        return st.Next(0, None)

    def do(self, _: list[Any]) -> Statements:
        return st.Repeat(0)

    def until(self, children: list[Any]) -> Any:
        return st.Until(0, self.plain(children[0]))

    def switch(self, children: list[Any]) -> Any:
        return st.Switch(0, self.plain(children[0]))

    def case(self, children: list[Any]) -> Any:
        return st.Case(0, tuple(map(self.plain, children)))

    def default(self, _: list[Any]) -> Statements:
        return st.Default(0)

    def end_switch(self, _: list[Any]) -> Statements:
        return st.EndSwitch(0)

    def break_(self, _: list[Any]) -> Any:
        return st.Break(0)

    def wait(self, children: list[Any]) -> Any:
        return st.Wait(0, self.plain(children[0]))

    def pause(self, _: list[Any]) -> Statements:
        return st.Pause(0)


class BlockRules(BlockWords, ValueRules):
    """All rules that the short readers share."""

    def instruction(self, children: list[Any]) -> Any:
        return children[0]

    def joints(self, children: list[ex.Expression]) -> ex.Expression:
        numbers = constants(children)
        return joints(numbers) if numbers is not None else ex.Function("joints", tuple(children))

    def power(self, children: list[ex.Expression]) -> ex.Function:
        return ex.Function("power", tuple(children))

    def case(self, children: list[Any]) -> Any:
        return super().case(children[0])

    def return_(self, _: list[Any]) -> Statements:
        return st.Return(0)
