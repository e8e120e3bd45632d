"""Parses clauses for a file: those seen before first, then the grammar; what it refuses is told, and mended."""

from __future__ import annotations

import re
from typing import Final

from olp.core.diagnostic import Span
from olp.core.memory_limit import remembered
from olp.ir.program import LineKind, Statement
from olp.languages.findings import Findings
from olp.languages.lark_host import MOST_BROKEN, give_up
from olp.languages.vendors.rapid.clauses import Clause
from olp.languages.vendors.rapid.grammar import RefusedError, clause_parser
from olp.languages.vendors.rapid.names import RapidNames
from olp.languages.vendors.rapid.statements import FramingClause

_MOST_CHARACTERS: Final = 1_000_000
_MOST_OPERATORS: Final = 300  # more could only exhaust the stack of an interpreter
_MOST_NESTED: Final = 60
_SHORT: Final = 100  # characters that cannot hold too much
_STRING: Final = re.compile(r'"(?:[^"]|"")*"')
_NUMBER: Final = re.compile(r"(?<![\w.])[-+]?(?:\d[\d.]*|\.\d+)(?:E[-+]?\d+)?", re.IGNORECASE)
_OPERATOR: Final = re.compile(r"[-+*/.\\]|\b(?:AND|OR|XOR|NOT|DIV|MOD)\b", re.IGNORECASE)
_MEMORY: Final = 50_000

Found = FramingClause | list[Statement]


class Parsing:
    """The parser of one file."""

    def __init__(self, findings: Findings, names: RapidNames) -> None:
        self._findings = findings
        self._names = names
        self._seen: dict[str, Found] = {}
        self._broken = 0

    def forget(self) -> None:
        """Names mean something else: another routine begins."""
        self._seen.clear()

    def read(
        self, clause: Clause, head: FramingClause | None = None, component: bool = False
    ) -> tuple[Found | None, Clause | None]:
        """What a clause means, None when it was refused, which is told; and a second one that was found in it.

        `head`: that of the routine it stands in. `component`: it stands in a RECORD.
        """
        text = clause.text
        known = self._seen.get(text)
        if known is not None:
            return known, None
        if self._broken >= MOST_BROKEN:
            mark(self._findings, clause, LineKind.ERROR)
            give_up(self._findings, "P468", span_of(clause), "clauses new to olp")
            return None, None
        try:
            found = self._parse(text if clause.complete else f"{text};", head, component)
        except RefusedError as refused:
            mended = self._mended(clause, refused, head)
            if mended is None:
                self._report(clause, refused)
                return None, None
            return mended
        if not clause.complete:
            self._missing_end(clause)
        elif len(self._seen) < _MEMORY:
            self._seen[text] = found
        return found, None

    def _parse(self, text: str, head: FramingClause | None, component: bool = False) -> Found:
        main = head is not None and head.name.lower() == "main"
        returns = "" if head is None else head.returns
        return remembered(
            "rapid clauses",
            (text, main, returns, component),
            self._names,
            lambda names: clause_parser().clause(
                text, names, main=main, returns=returns, component=component
            ),
        )

    def _mended(
        self, clause: Clause, refused: RefusedError, head: FramingClause | None
    ) -> tuple[Found, Clause] | None:
        """Where a line begins with what is refused, the semicolon before it is missing: both parts are read."""
        lines = clause.text.split("\n")
        at = refused.line - 1
        if not 0 < at < len(lines) or lines[at][: refused.column - 1].strip():
            return None
        text = "\n".join(lines[:at]).rstrip()
        try:
            found = self._parse(f"{text};", head)
        except RefusedError:
            return None
        self._broken += 1
        mark(self._findings, clause, LineKind.STATEMENT)
        self._missing_end(clause._replace(text=text, last=clause.line + text.count("\n")))
        rest = "\n".join(lines[at:])
        begin = rest.lstrip()
        word = re.match(r"\w*", begin)
        return found, clause._replace(
            word=word[0].upper() if word else "",
            text=begin,
            line=clause.line + at,
            column=len(rest) - len(begin) + 1,
        )

    def _report(self, clause: Clause, refused: RefusedError) -> None:
        self._broken += 1
        before = clause.column - 1 if refused.line == 1 else 0
        column = refused.column + before
        help = f"expected {refused.wanted}" if refused.wanted else ""
        mark(self._findings, clause, LineKind.ERROR)
        span = Span(clause.line + refused.line - 1, column, column + refused.length)
        self._findings.error("P451", refused.message, span, help)

    def _missing_end(self, clause: Clause) -> None:
        text = self._findings.source.line(clause.last)
        column = len(text.partition("!")[0].rstrip()) + 1
        message = "the semicolon at the end is missing"
        self._findings.error("P452", message, Span(clause.last, column, column + 1), "add ;")

    def too_much(self, clause: Clause) -> bool:
        """Whether a clause is beyond what any controller takes, which is told: it could only exhaust olp."""
        text = clause.text
        if len(text) < _SHORT:
            return False
        if len(text) <= _MOST_CHARACTERS:
            bare = _NUMBER.sub("0", _STRING.sub('""', text))
            operators = len(_OPERATOR.findall(bare))
            if _deepest(bare) <= _MOST_NESTED and operators <= _MOST_OPERATORS + bare.count("["):
                return False
        mark(self._findings, clause, LineKind.ERROR)
        message = f"an instruction of {len(text)} characters is longer or deeper than any controller takes"
        help = f"at most {_MOST_OPERATORS} operators and {_MOST_NESTED} brackets in one another are read"
        self._findings.error("P467", message, span_of(clause), help)
        return True


def _deepest(text: str) -> int:
    """How deep brackets are nested."""
    depth = deepest = 0
    for character in text:
        if character in "([{":
            depth += 1
            deepest = max(deepest, depth)
        elif character in ")]}":
            depth -= 1
    return deepest


def mark(findings: Findings, clause: Clause, kind: int) -> None:
    """What the lines of a clause are; an error stays one."""
    kinds = findings.kinds
    for line in range(clause.line - 1, min(clause.last, len(kinds))):
        if kinds[line] != LineKind.ERROR:
            kinds[line] = kind


def span_of(clause: Clause) -> Span:
    """The clause's first line."""
    first = clause.text.partition("\n")[0]
    return Span(clause.line, clause.column, clause.column + max(len(first), 1))
