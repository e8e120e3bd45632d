"""Lines that differ in nothing but digits are parsed once: a program has thousands of rows and moves of a few shapes.

The tokens of a line with other digits are put into the tree of the first one. That is right as long as a grammar takes
one digit for another; where it does not, lines are parsed one by one (`_EXACT`).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from threading import Lock
from typing import Any, Final, NamedTuple, TypeVar

from lark import Token, Tree

from olp.languages.lark_host import Grammar

Result = TypeVar("Result")

_DIGITS: Final = re.compile(r"[0-9]+")
# 0x1F is a number and 1x1F is none; C1MOVE is a move; grammars bound the digits of numbers and of exponents.
_EXACT: Final = re.compile(r"[0-9](?:x|\.?e[-+]?[0-9]{3})|c[0-9]+move|[0-9]{19}", re.IGNORECASE)
_MOST: Final = 2000  # shapes that are kept: about 10 MB


class _Slot(NamedTuple):
    """A token with digits in a tree: `children[at]`. `spelled`: its text, %s for each of the runs from first to end."""

    children: list[Any]
    at: int
    kind: str
    spelled: str
    first: int
    end: int


class AlikeLines:
    """A grammar's trees of the shapes of lines. Safe to share between threads."""

    def __init__(self, grammar: Grammar) -> None:
        self.grammar = grammar
        self._known: dict[str, tuple[Tree[Token], list[_Slot]]] = {}
        self._lock = Lock()

    def read(self, text: str, use: Callable[[Tree[Token]], Result]) -> Result:
        """What `use` makes of the line's tree, which it must not keep and whose tokens tell no positions.

        Raises lark's UnexpectedInput and what `use` raises.
        """
        if _EXACT.search(text):
            return use(self.grammar.parse(text))
        shape = _DIGITS.sub("0", text)
        with self._lock:
            found = self._known.get(shape)
            if found is None:
                tree = self.grammar.parse(text)
                slots = _slots(tree, text)
                if slots is not None:
                    if len(self._known) >= _MOST:
                        self._known.clear()
                    self._known[shape] = tree, slots
                return use(tree)
            tree, slots = found
            runs = _DIGITS.findall(text)
            for children, at, kind, spelled, first, end in slots:
                children[at] = Token(kind, spelled % tuple(runs[first:end]))
            return use(tree)


def _slots(tree: Tree[Token], text: str) -> list[_Slot] | None:
    """None where a token is not what stands in the text."""
    found = []
    runs = _DIGITS.findall(text)
    for node in tree.iter_subtrees():
        for at, token in enumerate(node.children):
            if not isinstance(token, Token) or not (inside := _DIGITS.findall(token)):
                continue
            first = len(_DIGITS.findall(text, 0, token.start_pos or 0))
            end = first + len(inside)
            if runs[first:end] != inside:
                return None
            spelled = _DIGITS.sub("%s", token.replace("%", "%%"))
            found.append(_Slot(node.children, at, token.type, spelled, first, end))
    return found
