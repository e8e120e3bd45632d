"""Results of a check, a comparison or lint, and their output formats. One file per format."""

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
