"""One line of KRL: code and comment, kept words, and what a line number is put on."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any, Final

from olp.ir.expressions import Text
from olp.ir.program import Opaque, Process, Statement
from olp.languages.lark_host import values_of

_CODE = re.compile(r'(?:[^;"]|"[^"]*(?:"|$))*')
BLANKS: Final = " \t\f\x1a\xa0"
# Instructions that are kept word for word: the advance run, interrupts, switching on the path, the operator.
_KEPT = re.compile(
    r"(?:GLOBAL\s+)?(INTERRUPT|TRIGGER|ANOUT|ANIN|DIGIN|BRAKE|RESUME|CONTINUE|ON_ERROR_PROCEED|CONFIRM|CCLOSE|CREAD|COPEN"
    r"|CWRITE|CHANNEL|SREAD|SWRITE|CAST_FROM|CAST_TO|CONST_VEL|STOP\s+WHEN)(?![\w$])(?!\s*[=.\[])",
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


def placed(statement: Statement, line: int) -> Statement:
    """The statement on its line."""
    return type(statement)(line, *values_of(statement))


def commented(statement: Any, comment: str) -> Statement:
    """The statement with a comment behind it."""
    changed: Statement = replace(statement, comment=comment)
    return changed
