"""The INFORM parser: built once per process from grammars/inform.lark, shared by all reads."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from threading import Lock
from typing import Any, NamedTuple

from lark import Lark

from olp.expression import Variable
from olp.program import Statement
from olp.resources import read_text
from olp.vendors.inform.expressions import Remark
from olp.vendors.inform.flow import SwitchAndCase
from olp.vendors.inform.statements import InstructionRules

_PLAIN_WORDS = re.compile(r"[A-Z][A-Z0-9$]+")


class Parsed(NamedTuple):
    """One instruction, with line 0: one statement, but two for `SWITCH a CASE 1`.

    `named`: names of //ALIAS took part, so it holds for its job only.
    """

    statements: tuple[Statement, ...]
    remarks: tuple[Remark, ...]
    named: bool


class InstructionParser:
    """Parses one instruction at a time. Safe to share between threads."""

    def __init__(self) -> None:
        self._rules = InstructionRules()
        self._lark = Lark(
            read_text("grammars", "inform.lark"),
            parser="lalr",
            lexer="contextual",
            start="instruction",
            transformer=self._rules,
            maybe_placeholders=True,
        )
        self._lock = Lock()
        self.terminals = {terminal.name: terminal.pattern.value for terminal in self._lark.terminals}
        self.words = self._instruction_words()

    def parse(self, line: str, aliases: Mapping[str, Variable]) -> Parsed:
        """Raises lark's UnexpectedInput, or BrokenLineError for a line whose words contradict each other."""
        with self._lock:
            rules = self._rules
            rules.aliases, rules.remarks, rules.named_any = aliases, [], False
            parsed: Any = self._lark.parse(line)
            statements: tuple[Any, ...] = tuple(parsed) if isinstance(parsed, SwitchAndCase) else (parsed,)
            return Parsed(statements, tuple(rules.remarks), rules.named_any)

    def _instruction_words(self) -> frozenset[str]:
        """Every word that can open an instruction, as the grammar lists them."""
        choices = self._lark.parse_interactive("").choices()  # type: ignore[no-untyped-call]
        words: set[str] = set()
        for name in (set(choices) & set(self.terminals)) - {"COMMENT", "LABEL"}:
            pattern = self.terminals[name].split("(?!")[0].split("(?=")[0]
            words.update(_PLAIN_WORDS.findall(pattern.replace("\\", "")))
        return frozenset(words)


@cache
def instruction_parser() -> InstructionParser:
    """The one parser of this process."""
    return InstructionParser()
