"""Collects the diagnostics of a file; those that repeat are counted instead of listed."""

from __future__ import annotations

from dataclasses import replace

from olp.core.diagnostic import Diagnostic, Severity, Span
from olp.core.source import Source
from olp.ir.program import LineKind


class Findings:
    """Collects the diagnostics of one source file, and what each of its lines was understood as.

    `kinds`: one `LineKind` per line of the source; every reader fills it.
    """

    def __init__(self, source: Source) -> None:
        self.source = source
        self.kinds = bytearray(len(source.lines))
        self._found: list[Diagnostic] = []
        self._repeated: dict[tuple[str, str], tuple[int, int]] = {}

    def add(self, severity: Severity, code: str, message: str, where: Span | int, help: str = "") -> None:
        """Add a diagnostic at a span or for a whole line (a number from 1). An error sets the line's kind to
        `LineKind.ERROR`.
        """
        span = self.whole_line(where) if isinstance(where, int) else where
        if severity is Severity.ERROR and 0 < span.line <= len(self.kinds):
            self.kinds[span.line - 1] = LineKind.ERROR
        self._found.append(
            Diagnostic(
                code,
                message,
                severity,
                self.source.path,
                span.line,
                span.column,
                span.end_column,
                help,
                self.source.line(span.line),
            )
        )

    def error(self, code: str, message: str, where: Span | int, help: str = "") -> None:
        self.add(Severity.ERROR, code, message, where, help)

    def warning(self, code: str, message: str, where: Span | int, help: str = "") -> None:
        self.add(Severity.WARNING, code, message, where, help)

    def info(self, code: str, message: str, where: Span | int, help: str = "") -> None:
        self.add(Severity.INFO, code, message, where, help)

    def once(
        self, severity: Severity, code: str, key: str, message: str, where: Span | int, help: str = ""
    ) -> None:
        """Add a diagnostic at its first place only and count its further places; `key` and `code` say what counts
        as the same.
        """
        known = self._repeated.get((code, key))
        if known is not None:
            if severity is Severity.ERROR:
                self.kinds[(where if isinstance(where, int) else where.line) - 1] = LineKind.ERROR
            self._repeated[code, key] = (known[0], known[1] + 1)
            return
        self._repeated[code, key] = (len(self._found), 1)
        self.add(severity, code, message, where, help)

    def extend(self, diagnostics: list[Diagnostic]) -> None:
        """Add diagnostics about whole lines that another part found; the file's path and the line's text are filled
        in.
        """
        for one in diagnostics:
            self.add(one.severity, one.code, one.message, one.line, one.help)

    def whole_line(self, number: int) -> Span:
        """Return the span of a line's text without leading and trailing blanks. `number` counts from 1."""
        text = self.source.line(number)
        start = len(text) - len(text.lstrip()) + 1
        return Span(number, start, max(len(text.rstrip()), start) + 1)

    def result(self) -> tuple[Diagnostic, ...]:
        """Return all diagnostics in order of their lines; one that was counted says in how many more lines it holds."""
        found = list(self._found)
        for place, count in self._repeated.values():
            if count > 1:
                first = found[place]
                lines = "once more" if count == 2 else f"in {count - 1} more lines"
                found[place] = replace(first, message=f"{first.message} (and {lines})")
        return tuple(sorted(found, key=lambda one: one.line))
