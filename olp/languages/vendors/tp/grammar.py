"""The TP parser: built once per process from grammars/tp.lark, shared by all reads."""

from __future__ import annotations

from functools import cache
from typing import Any

from olp.ir.program import Statement
from olp.languages.lark_host import Grammar
from olp.languages.vendors.tp.statements import Statements, TpInstructionRules


class TpParser(Grammar):
    """Parses one instruction at a time."""

    def __init__(self) -> None:
        super().__init__("tp", TpInstructionRules())

    def statements(self, text: str) -> tuple[Statement, ...]:
        """All statements of one line, with line 0. Raises lark's UnexpectedInput, or BrokenLineError."""
        parsed: Any = self.parse(text)
        return parsed.all if isinstance(parsed, Statements) else (parsed,)


@cache
def instruction_parser() -> TpParser:
    """The one parser of this process."""
    return TpParser()
