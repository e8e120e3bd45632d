"""The INFORM parser: built once per process from grammars/inform.lark, shared by all reads."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

from olp.ir.expressions import Variable
from olp.ir.program import Statement
from olp.languages.lark_host import Grammar
from olp.languages.vendors.inform.expressions import InformRemark
from olp.languages.vendors.inform.flow import SwitchAndCase
from olp.languages.vendors.inform.statements import InformInstructionRules

_PLAIN_WORDS = re.compile(r"[A-Z][A-Z0-9$]+")


class InformLine(NamedTuple):
    """One instruction, with line 0: one statement, but two for `SWITCH a CASE 1`.

    `named`: names of //ALIAS took part, so it holds for its job only.
    """

    statements: tuple[Statement, ...]
    remarks: tuple[InformRemark, ...]
    named: bool


class InformParser(Grammar):
    """Parses one instruction at a time. `words`: all that can open an instruction."""

    def __init__(self) -> None:
        super().__init__("inform", InformInstructionRules())
        self.words = self._instruction_words()

    def instruction(self, line: str, aliases: Mapping[str, Variable]) -> InformLine:
        """Raises lark's UnexpectedInput, or BrokenLineError."""
        told = ("remarks", "named_any")
        parsed, remarks, named = self.parse(line, then=told, aliases=aliases, remarks=[], named_any=False)
        statements: tuple[Any, ...] = tuple(parsed) if isinstance(parsed, SwitchAndCase) else (parsed,)
        return InformLine(statements, tuple(remarks), named)

    def _instruction_words(self) -> frozenset[str]:
        """Every word that can open an instruction, as the grammar lists them."""
        choices = self.lark.parse_interactive("").choices()  # type: ignore[no-untyped-call]
        words: set[str] = set()
        for name in (set(choices) & set(self.terminals)) - {"COMMENT", "LABEL"}:
            pattern = self.terminals[name].split("(?!")[0].split("(?=")[0]
            words.update(_PLAIN_WORDS.findall(pattern.replace("\\", "")))
        return frozenset(words)


@cache
def instruction_parser() -> InformParser:
    """The one parser of this process."""
    return InformParser()
