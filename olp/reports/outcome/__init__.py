"""What a check, a comparison or the rules found, and the formats in which it is told. One file per format."""

from olp.reports.outcome.format import OutcomeFormat, format_names, load_format
from olp.reports.outcome.model import Finding, Item, Level, Outcome, Status

__all__ = ["Finding", "Item", "Level", "Outcome", "OutcomeFormat", "Status", "format_names", "load_format"]
