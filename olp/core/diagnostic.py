"""One type for everything a user is told: a code, a place, a sentence, and what would have worked."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple

# Controls but line feed and tab, the C1 controls, directions of text, lone surrogates (of names that are no text).
_STEERING = "\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff"
_UNSAFE = re.compile(f"[{_STEERING}]")
_STYLED = re.compile(f"(\x1b\\[[0-9;]*m)|[{_STEERING}]")


def visible(text: str) -> str:
    """`text` with every sign that would steer a terminal written as its code, such as \\x1b."""
    return _UNSAFE.sub(_code, text)


def visible_styled(text: str) -> str:
    """The same, but for the styles of `olp.core.terminal.paint`."""
    return _STYLED.sub(lambda found: found[1] or _code(found), text)


def _code(found: re.Match[str]) -> str:
    return found[0].encode("unicode_escape").decode("ascii")


class Severity(StrEnum):
    """How bad a finding is. Only `ERROR` makes a command end with status 2."""

    ERROR = "error"
    WARNING = "warning"
    INFO = "info"


class Span(NamedTuple):
    """A place in one line of a text: 1-based columns counted in characters, `end_column` exclusive."""

    line: int
    column: int = 1
    end_column: int = 1


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One finding. `line` 0 means the file as a whole; `source_line` is the offending text, for the caret."""

    code: str
    message: str
    severity: Severity = Severity.ERROR
    file: str = ""
    line: int = 0
    column: int = 1
    end_column: int = 1
    help: str = ""
    source_line: str = ""

    def at(self, file: str) -> Diagnostic:
        """The same finding placed in `file` (unless it already names one)."""
        return self if self.file else replace(self, file=file)

    @property
    def is_error(self) -> bool:
        return self.severity is Severity.ERROR

    def render(self) -> str:
        """The finding as text with the line and a caret under the place."""
        head = f"{self.severity}[{self.code}]: {visible(self.message)}"
        rows = [head]
        if self.line:
            rows.append(f"  --> {visible(self.file) or '<text>'}:{self.line}:{self.column}")
        elif self.file:
            rows.append(f"  --> {visible(self.file)}")
        if self.line and self.source_line:
            rows.extend(self._caret_rows())
        if self.help:
            rows.append(f"help: {visible(self.help)}")
        return "\n".join(rows)

    def _caret_rows(self) -> list[str]:
        # Control characters of a binary file would steer the terminal.
        text = "".join(sign if sign.isprintable() else " " for sign in self.source_line)
        start = min(max(self.column, 1), len(text) + 1) - 1
        width = max(1, min(self.end_column, len(text) + 1) - self.column)
        # A 10,000 character line helps nobody: show the neighbourhood of the caret.
        left = max(0, start - 80)
        shown = ("…" if left else "") + text[left : left + 160]
        offset = start - left + (1 if left else 0)
        gutter = f"{self.line} | "
        return [gutter + shown, " " * (len(gutter) - 2) + "| " + " " * offset + "^" * min(width, 80)]


class OlpError(Exception):
    """The only exception that bad input raises. Carries every problem found, not just the first."""

    def __init__(self, *diagnostics: Diagnostic) -> None:
        self.diagnostics: tuple[Diagnostic, ...] = diagnostics
        super().__init__("\n\n".join(d.render() for d in diagnostics))

    def __reduce__(self) -> tuple[type[OlpError], tuple[Diagnostic, ...]]:
        # Worker processes hand errors back pickled; the default would pass the rendered text instead.
        return type(self), self.diagnostics


def error(code: str, message: str, span: Span | None = None, **more: str) -> Diagnostic:
    """An error at `span`; `more` takes file, help, source_line."""
    return _make(Severity.ERROR, code, message, span, more)


def warning(code: str, message: str, span: Span | None = None, **more: str) -> Diagnostic:
    """A warning at `span`; `more` takes file, help, source_line."""
    return _make(Severity.WARNING, code, message, span, more)


def info(code: str, message: str, span: Span | None = None, **more: str) -> Diagnostic:
    """A note at `span`; `more` takes file, help, source_line."""
    return _make(Severity.INFO, code, message, span, more)


def _make(severity: Severity, code: str, message: str, span: Span | None, more: dict[str, str]) -> Diagnostic:
    line, column, end_column = span or (0, 1, 1)
    return Diagnostic(code, message, severity, line=line, column=column, end_column=end_column, **more)


def errors(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Only those that make the input unusable."""
    return tuple(d for d in diagnostics if d.is_error)


def raise_errors(diagnostics: Sequence[Diagnostic]) -> None:
    """Raises OlpError with all errors among `diagnostics`, if there is one."""
    bad = errors(diagnostics)
    if bad:
        raise OlpError(*bad)
