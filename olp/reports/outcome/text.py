"""Plain text for the terminal: findings in their order, then the judged items, worst first, then one sentence."""

from __future__ import annotations

from typing import ClassVar

from olp.core.diagnostic import visible
from olp.reports.outcome.model import JudgedItem, Outcome, OutcomeFinding, OutcomeFormat, Status

_ORDER = (Status.UNKNOWN, Status.FAILED, Status.WARNED, Status.HELD)
_SHOWN_HELD = 20  # items that held, of which nobody wants to read thousands


class TextFormat(OutcomeFormat):
    """For people."""

    summary: ClassVar[str] = "text for the terminal"
    suffix: ClassVar[str] = ".txt"

    def render(self, outcome: Outcome) -> str:
        blocks = [_finding(found) for found in outcome.findings]
        rows = _items(outcome.items)
        if rows:
            blocks.append("\n".join(rows))
        if outcome.summary:
            blocks.append("\n".join(outcome.summary))
        return "\n\n".join(blocks) + "\n" if blocks else ""


def _finding(found: OutcomeFinding) -> str:
    rows = [f"{found.level}[{found.code}]: {visible(found.message)}"]
    if found.file:
        place = f"{found.file}:{found.line}:{found.column}" if found.line else found.file
        rows.append(f"  --> {visible(place)}")
    if found.source_line.strip():
        rows.append(f"   | {visible(found.source_line.strip())}")
    if found.help:
        rows.append(f"help: {visible(found.help)}")
    return "\n".join(rows)


def _items(items: tuple[JudgedItem, ...]) -> list[str]:
    rows: list[str] = []
    for status in _ORDER:
        own = [item for item in items if item.status is status]
        shown = own if status is not Status.HELD else own[:_SHOWN_HELD]
        rows.extend(_row(item) for item in shown)
        if len(shown) < len(own):
            rows.append(f"{status:8s}{len(own) - len(shown)} more")
    return rows


def _row(item: JudgedItem) -> str:
    message = f"  {item.message}" if item.message else ""
    if item.low_s is not None and item.high_s is not None:
        message += f", 95 %: {item.low_s:.3f} to {item.high_s:.3f} s"
    where = f"  {item.file}" if item.file and item.file not in item.name else ""
    return visible(f"{item.status:8s}{item.name}{where}{message}")
