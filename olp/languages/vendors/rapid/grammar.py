"""The RAPID parser: built once per process from grammars/rapid.lark, shared by all reads."""

from __future__ import annotations

from functools import cache
from typing import Final

from lark import Token
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken, VisitError

from olp.ir.program import Statement
from olp.languages.lark_host import BrokenLineError, Grammar
from olp.languages.vendors.rapid.names import RapidNames
from olp.languages.vendors.rapid.statements import ClauseRules, FramingClause

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
    found = {str(name) for name in names} - {"$END", "BLANK"}
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
    words = sorted(_WORDS.get(name, name.lstrip("_")) for name in found)
    return ", ".join(words) if len(words) <= _MOST_WANTED else ""


@cache
def clause_parser() -> ClauseParser:
    """The one parser of this process."""
    return ClauseParser()
