"""Parses clauses for a file: those seen before first, then the grammar; what it refuses is told, and mended."""

from __future__ import annotations

import re
from functools import cache
from typing import Final

from lark import Token
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken, VisitError

from olp.core.diagnostic import Span
from olp.core.result_cache import remembered, shelf
from olp.ir.program import LineKind, Statement
from olp.languages.findings import Findings
from olp.languages.lark_host import MOST_BROKEN, BrokenLineError, Grammar, bracket_depth, give_up
from olp.languages.vendors.rapid.clauses import Clause
from olp.languages.vendors.rapid.names import RapidNames
from olp.languages.vendors.rapid.statements import ClauseRules, FramingClause

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
            shelf("rapid clauses"),
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
            if bracket_depth(bare) <= _MOST_NESTED and operators <= _MOST_OPERATORS + bare.count("["):
                return False
        mark(self._findings, clause, LineKind.ERROR)
        message = f"an instruction of {len(text)} characters is longer or deeper than any controller takes"
        help = f"at most {_MOST_OPERATORS} operators and {_MOST_NESTED} brackets in one another are read"
        self._findings.error("P467", message, span_of(clause), help)
        return True


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


# --- Grammar ---
# The RAPID parser: built once per process from grammars/rapid.lark, shared by all reads.

_WORDS: Final = {
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "a text",
    "COMPARE": "a comparison",
    "SEMICOLON": ";",
    "COMMA": ",",
    "COLON": ":",
    "LPAR": "(",
    "RPAR": ")",
    "LSQB": "[",
    "RSQB": "]",
    "LBRACE": "{",
    "RBRACE": "}",
    "BACKSLASH": "\\",
    "PERCENT": "%",
    "QMARK": "?",
    "DOT": ".",
    "PLUS": "+",
    "MINUS": "-",
    "STAR": "*",
    "DIVIDE": "/",
    "BOOLEAN": "TRUE, FALSE",
    "__ANON_0": ":=",
    "STORAGE": "CONST, PERS, VAR",
    "SCOPE": "LOCAL",
    "PASSING": "INOUT, PERS, VAR",
    "ENDROUTINE": "ENDPROC",
}
_EXPRESSION: Final = {"NAME", "NUMBER", "STRING", "LPAR", "LSQB"}
_MOST_WANTED: Final = 6


class RefusedError(Exception):
    """A clause that the grammar refuses, or that makes no sense: where (1-based, in the clause) and what would do."""

    def __init__(self, message: str, line: int, column: int, length: int, wanted: str) -> None:
        super().__init__(message)
        self.message = message
        self.line = line
        self.column = column
        self.length = max(length, 1)
        self.wanted = wanted


class ClauseParser(Grammar):
    """Parses one clause at a time."""

    def __init__(self) -> None:
        super().__init__("rapid", ClauseRules(), ("clause", "component"))

    def clause(
        self, text: str, names: RapidNames, *, main: bool = False, returns: str = "", component: bool = False
    ) -> FramingClause | list[Statement]:
        """What a clause means, with line 0. Raises RefusedError."""
        start = "component" if component else "clause"
        try:
            found: FramingClause | list[Statement] = self.parse(
                text, start, names=names, raw=text, main=main, returns=returns
            )
        except UnexpectedInput as refused:
            raise _refused(refused, text) from None
        except VisitError as wrong:
            if isinstance(wrong.orig_exc, BrokenLineError):
                raise _broken(wrong.orig_exc, text) from None
            raise
        except BrokenLineError as wrong:
            raise _broken(wrong, text) from None
        return found


def _refused(refused: UnexpectedInput, text: str) -> RefusedError:
    line, column = max(refused.line, 1), max(refused.column, 1)
    if isinstance(refused, UnexpectedToken):
        token: Token = refused.token
        if token.type == "$END":
            lines = text.split("\n")
            line, column = len(lines), len(lines[-1]) + 1
            return RefusedError("the instruction is not complete", line, column, 1, _wanted(refused.accepts))
        return RefusedError(f"unexpected {_shown(token)}", line, column, len(token), _wanted(refused.accepts))
    if isinstance(refused, UnexpectedCharacters):
        rest = text.split("\n")[line - 1][column - 1 :] if line <= text.count("\n") + 1 else ""
        message = "a text that is not closed" if rest[:1] == '"' else f"unexpected {rest[:1]!r}"
        return RefusedError(message, line, column, 1, _wanted(refused.allowed))
    return RefusedError("this is not understood", 1, 1, len(text), "")


def _broken(wrong: BrokenLineError, text: str) -> RefusedError:
    place = max(text.find(wrong.word), 0) if wrong.word else 0
    line = text.count("\n", 0, place) + 1
    column = place - (text.rfind("\n", 0, place) + 1) + 1
    return RefusedError(wrong.message, line, column, len(wrong.word), wrong.wanted)


def _shown(token: Token) -> str:
    text = str(token)
    return f"'{text[:40]}'" if "'" not in text else text[:40]


def _wanted(names: object) -> str:
    """The terminals that would have done, in words; nothing when they are many."""
    if not isinstance(names, (set, frozenset, list, tuple)):
        return ""
    found = {str(name) for name in names} - {"$END", "BLANK", "PLACEHOLDER"}
    if len(found & _EXPRESSION) >= 4:
        found = (found - _EXPRESSION - {"MINUS", "PLUS", "BOOLEAN", "NOT"}) | {"an expression"}
    operators = {
        "AND",
        "OR",
        "XOR",
        "COMPARE",
        "PLUS",
        "MINUS",
        "STAR",
        "DIVIDE",
        "DIV",
        "MOD",
        "DOT",
        "LBRACE",
    }
    if found - operators:
        found -= operators
    words = (_WORDS.get(name, name.lstrip("_")) for name in found)
    shown = sorted(
        (w if w[0].isalpha() else f"'{w}'" for w in words), key=lambda w: (w[0] == "'", w)
    )  # signs last
    return ", ".join(shown) if len(shown) <= _MOST_WANTED else ""


@cache
def clause_parser() -> ClauseParser:
    """The one parser of this process."""
    return ClauseParser()
