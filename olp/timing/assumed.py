"""What was taken for granted, as findings: for whoever shows it nowhere else. Code: A004."""

from __future__ import annotations

from olp.core.diagnostic import Diagnostic, Span, info
from olp.timing.result import Timing


def assumed(timing: Timing) -> list[Diagnostic]:
    """One note per assumption and place."""
    return [
        info("A004", f"assumed: {says}", Span(line) if line else None, file=file)
        for line, says, file in dict.fromkeys(timing.assumptions)
    ]
