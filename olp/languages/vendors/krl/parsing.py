"""Gives lines to the grammar, within bounds, and tells what is wrong with those that it refuses."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any, Final

from olp.core.diagnostic import Severity, Span
from olp.core.result_cache import CacheShelf, remembered, shelf
from olp.ir.expressions import Text
from olp.ir.program import Opaque, Process, Statement
from olp.languages.findings import Findings
from olp.languages.lark_host import (
    MOST_BROKEN,
    BrokenLineError,
    bracket_depth,
    either,
    expected,
    give_up,
)
from olp.languages.vendors.krl.scope import Scope

_OPERATORS = re.compile(r"[-+*/:({\[<>=]|\.(?=[A-Za-z_$])|\bB?_?NOT\b", re.IGNORECASE)
_MOST_OPERATORS = (
    200  # a nesting that no controller takes, and that would exhaust the stack of an interpreter
)
_MOST_NESTED = 60
_MOST_CHARACTERS = 4096
_LONG_NUMBER = re.compile(r"(?<![\w$.])\d{19,}|'[BHDbhd]?[0-9A-Fa-f]{65,}'")
_STRING = re.compile(r'"[^"]*"')
_MOST_WORDS = 8
# A list that a whole tree shares is read with each program of the tree, and most of its lines say the same each time.
_SHARED_LINES = CacheShelf(20_000)

# What the grammar calls its terminals, in a reader's words.
_NAMES: Final = {
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "a text",
    "BITS": "'B0110'",
    "ENUM": "#CONSTANT",
    "STATE": "TRUE or FALSE",
    "SIGN": "+ or -",
    "TIMES": "* or /",
    "COMPARE": "==",
    "NOT": "NOT",
    "EQUAL": "=",
    "COMMA": ",",
    "COLON": ":",
    "DOT": ".",
    "LPAR": "(",
    "RPAR": ")",
    "LSQB": "[",
    "RSQB": "]",
    "LBRACE": "{",
    "RBRACE": "}",
    "BLEND": "C_DIS",
    "DIRECTION": ":IN or :OUT",
    "$END": "the end of the line",
}


class KrlLineReader:
    """Parses the lines of one file. `broken`: how many were refused; `shared`: those of a list of many programs."""

    def __init__(self, findings: Findings, scope: Scope, shared: bool = False) -> None:
        self._known = _SHARED_LINES if shared else shelf("krl lines")
        self._findings = findings
        self._scope = scope
        self.broken = 0
        self.mixed = False

    def parse(self, code: str, number: int) -> Any:
        """What the grammar makes of a line without its comment; None when it is refused, which is told."""
        if self._too_much(code, number):
            return None
        from lark.exceptions import UnexpectedInput

        from olp.languages.vendors.krl.grammar import line_parser

        if self.broken >= MOST_BROKEN:
            give_up(self._findings, "P410", Span(number, 1, 2))
            return None
        try:
            parsed = remembered(self._known, code, self._scope, lambda s: line_parser().parse_line(code, s))
        except UnexpectedInput as refused:
            self._report(number, code, *_explain(refused, code))
            return None
        except BrokenLineError as broken:
            column = max(code.upper().rfind(broken.word.upper()), 0)
            self._report(number, code, broken.message, broken.wanted, column, column + len(broken.word))
            return None
        self.mixed = parsed.mixed
        if parsed.mixed:
            self._tell_mixed(number)
        return parsed.result

    def _tell_mixed(self, number: int) -> None:
        message = "a comparison beside AND or OR without parentheses: the controller compares last"
        span = self._findings.whole_line(number)
        self._findings.once(Severity.WARNING, "P414", "", message, span, "put the comparison in parentheses")

    def _too_much(self, code: str, number: int) -> bool:
        """Whether a line is beyond what any controller takes, which is told: it could only exhaust olp."""
        text = _STRING.sub('""', code) if '"' in code else code
        digits = _LONG_NUMBER.search(text) if len(text) > 19 else None
        if digits is not None:
            message = f"a number of {len(digits[0])} characters"
            self._findings.error("P409", message, number, "at most 18 digits")
            return True
        operators = len(_OPERATORS.findall(text)) if len(text) > _MOST_OPERATORS else 0
        nested = bracket_depth(text) if len(text) > _MOST_NESTED else 0
        if len(code) <= _MOST_CHARACTERS and operators <= _MOST_OPERATORS and nested <= _MOST_NESTED:
            return False
        message = f"a line of {len(code)} characters is longer than any controller takes"
        help = (
            f"at most {_MOST_CHARACTERS} characters, {_MOST_OPERATORS} operators and {_MOST_NESTED} brackets in one "
            "another are read"
        )
        self._findings.error("P409", message, number, help)
        return True

    def _report(self, number: int, code: str, message: str, wanted: str, start: int, stop: int) -> None:
        self.broken += 1
        text = self._findings.source.line(number)
        offset = max(text.find(code), 0) + 1
        help = f"expected {wanted}" if wanted else ""
        self._findings.error(
            "P404", message, Span(number, offset + start, offset + max(stop, start + 1)), help
        )


def _explain(refused: Any, code: str) -> tuple[str, str, int, int]:
    """(message, what was expected, start, stop) of a refused line."""
    column = getattr(refused, "column", -1) or -1
    token = getattr(refused, "token", None)
    at_end = token is not None and token.type == "$END"
    start = len(code) if at_end or column < 1 else column - 1
    word = "" if at_end else str(token) if token is not None else code[start : start + 1]
    wanted = _wanted(expected(refused))
    message = "the line ends too soon" if not word else f"'{word[:40]}' makes no sense here"
    return message, wanted, start, start + len(word)


def _wanted(names: set[str]) -> str:
    words = sorted({_NAMES.get(name) or name.lstrip("_") for name in names if not str(name).startswith("__")})
    if not words or len(words) > _MOST_WORDS:
        return ""
    return either(words)


# --- Lines ---
# One line of KRL: code and comment, kept words, and what a line number is put on.

_CODE = re.compile(r'(?:[^;"]|"[^"]*(?:"|$))*')
BLANKS: Final = " \t\f\x1a\xa0"
# Instructions that are kept word for word: the advance run, interrupts, switching on the path, the operator.
_KEPT = re.compile(
    r"(?:GLOBAL\s+)?(INTERRUPT|TRIGGER|ANOUT|ANIN|DIGIN|BRAKE|RESUME|CONTINUE|ON_ERROR_PROCEED|CONFIRM|CCLOSE|CREAD|COPEN"
    r"|CWRITE|CHANNEL|SREAD|SWRITE|CAST_FROM|CAST_TO|CONST_VEL|STOP\s+WHEN|ASYPTP|ASYCONT|ASYSTOP|ASYCANCEL)"
    r"(?![\w$])(?!\s*[=.\[])",
    re.IGNORECASE,
)
# What every INI fold holds: it acts when the arm has been stopped, and never moves it.
_STOP_HANDLER = re.compile(
    r"(?:GLOBAL\s+)?INTERRUPT\s+(?:DECL\s+3\s+WHEN\s+\$STOPMESS\s*==\s*TRUE\s+DO\s+\w+\s*\(\s*\)|(?:ON|OFF)\s+3)",
    re.IGNORECASE,
)
_OUTSIDE = re.compile(
    r"(?:GLOBAL\s+)?(?:EXT|EXTP|EXTFCT|EXTFCTP|IMPORT)(?![\w$])(?!\s*[=.\[(])", re.IGNORECASE
)
FOLD: Final = re.compile(r"\s*(END)?FOLD(?![A-Za-z])", re.IGNORECASE)


def split(line: str) -> tuple[str, str | None]:
    """Code without the blanks around it, and the comment behind ; (None: there is none)."""
    if ";" not in line:
        return line.strip(BLANKS), None
    match = _CODE.match(line)
    end = match.end() if match else 0
    return line[:end].strip(BLANKS), line[end + 1 :].rstrip(BLANKS) if end < len(line) else None


def kept(code: str) -> Statement | None:
    """A statement that is kept word for word, or None."""
    match = _KEPT.match(code)
    if match is not None:
        name = "stop-handler" if _STOP_HANDLER.fullmatch(code) else match[1].split()[0].lower()
        return Process(0, name, (("", Text(code)),))
    return Opaque(0, code) if _OUTSIDE.match(code) else None


def commented(statement: Any, comment: str) -> Statement:
    """The statement with a comment behind it."""
    changed: Statement = replace(statement, comment=comment)
    return changed
