"""The KRL parser: built once per process from grammars/krl.lark, shared by all reads."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

from olp.languages.lark_host import Grammar
from olp.languages.vendors.krl.scope import Scope
from olp.languages.vendors.krl.statements import StatementRules


class KrlLine(NamedTuple):
    """One line. `result`: a statement, or declarations, a head, a tail, a spline block's border."""

    result: Any
    mixed: bool  # comparisons stand beside AND or OR without parentheses


class KrlParser(Grammar):
    """Parses one line at a time."""

    def __init__(self) -> None:
        super().__init__("krl", StatementRules(), ("start",))

    def parse_line(self, line: str, scope: Scope) -> KrlLine:
        """Raises lark's UnexpectedInput, or BrokenLineError."""
        return KrlLine(*self.parse(line, then=("mixed",), scope=scope, mixed=False))


@cache
def line_parser() -> KrlParser:
    """The one parser of this process."""
    return KrlParser()
