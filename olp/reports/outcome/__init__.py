"""What a check, a comparison or the rules found, and the formats in which it is told. One file per format."""

from olp.reports.outcome.model import (
    JudgedItem,
    Level,
    Outcome,
    OutcomeFinding,
    OutcomeFormat,
    Status,
    format_names,
    load_format,
)

__all__ = [
    "JudgedItem",
    "Level",
    "Outcome",
    "OutcomeFinding",
    "OutcomeFormat",
    "Status",
    "format_names",
    "load_format",
]
