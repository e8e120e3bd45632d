"""The KRL parser: built once per process from grammars/krl.lark, shared by all reads."""

from __future__ import annotations

from functools import cache
from threading import Lock
from typing import Any, NamedTuple

from lark import Lark

from olp.resources import read_text
from olp.vendors.krl.scope import Scope
from olp.vendors.krl.statements import StatementRules


class Parsed(NamedTuple):
    """One line. `result`: a statement, or declarations, a head, a tail, a spline block's border."""

    result: Any
    mixed: bool  # comparisons stand beside AND or OR without parentheses


class LineParser:
    """Parses one line at a time. Safe to share between threads."""

    def __init__(self) -> None:
        self._rules = StatementRules()
        self._lark = Lark(
            read_text("grammars", "krl.lark"),
            parser="lalr",
            lexer="contextual",
            start="start",
            transformer=self._rules,
            maybe_placeholders=True,
        )
        self._lock = Lock()
        self.terminals = {terminal.name: terminal.pattern.value for terminal in self._lark.terminals}

    def parse(self, line: str, scope: Scope) -> Parsed:
        """Raises lark's UnexpectedInput, or BrokenLineError for a line whose words contradict each other."""
        with self._lock:
            rules = self._rules
            rules.scope, rules.mixed = scope, False
            result: Any = self._lark.parse(line)
            return Parsed(result, rules.mixed)


@cache
def line_parser() -> LineParser:
    """The one parser of this process."""
    return LineParser()
