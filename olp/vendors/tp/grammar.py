"""The TP parser: built once per process from grammars/tp.lark, shared by all reads."""

from __future__ import annotations

from functools import cache
from threading import Lock
from typing import Any

from lark import Lark

from olp.program import Statement
from olp.resources import read_text
from olp.vendors.tp.statements import InstructionRules, Statements


class InstructionParser:
    """Parses one instruction at a time. Safe to share between threads."""

    def __init__(self) -> None:
        self._lark = Lark(
            read_text("grammars", "tp.lark"),
            parser="lalr",
            lexer="contextual",
            start="instruction",
            transformer=InstructionRules(),
            maybe_placeholders=True,
        )
        self._lock = Lock()

    def parse(self, text: str) -> tuple[Statement, ...]:
        """All statements of one line, with line 0.

        Raises lark's UnexpectedInput, or BrokenLineError for a line whose words contradict each other.
        """
        with self._lock:
            parsed: Any = self._lark.parse(text)
        return parsed.all if isinstance(parsed, Statements) else (parsed,)


@cache
def instruction_parser() -> InstructionParser:
    """The one parser of this process."""
    return InstructionParser()
