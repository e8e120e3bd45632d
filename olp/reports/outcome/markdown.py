"""Markdown: a comment in a pull request, or a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from olp.reports.outcome.model import JudgedItem, Level, Outcome, OutcomeFinding, OutcomeFormat, Status

_MARKS = {
    Status.HELD: "held",
    Status.WARNED: "**close**",
    Status.FAILED: "**over**",
    Status.UNKNOWN: "**unknown**",
}
_MOST_ROWS = 50  # forges cut comments at 65,536 characters


class MarkdownFormat(OutcomeFormat):
    """For pull requests."""

    summary: ClassVar[str] = "Markdown for a comment"
    suffix: ClassVar[str] = ".md"

    def render(self, outcome: Outcome) -> str:
        blocks = [f"### olp {outcome.command}"]
        if outcome.summary:
            blocks.append("  \n".join(_text(line) for line in outcome.summary))
        blocks += [_table(table) for table in _tables(outcome.data)]
        order = list(_MARKS)[::-1]
        items = sorted(outcome.items, key=lambda item: order.index(item.status))
        if items:
            blocks.append(_rows(("status", "what", "time s", "limit s", ""), [_item(item) for item in items]))
        # Notes beside tables only say what those show.
        shown = [f for f in outcome.findings if f.level is not Level.NOTE or not _tables(outcome.data)]
        if shown:
            blocks.append(_rows(("", "where", "what", "what would help"), [_finding(f) for f in shown]))
        return "\n\n".join(blocks) + "\n"


def _tables(data: Mapping[str, object]) -> Sequence[Mapping[str, object]]:
    """Tables that the command adds to the output: `tables`, each with `head` and `rows`."""
    tables = data.get("tables", ())
    return [table for table in tables if isinstance(table, Mapping)] if isinstance(tables, Sequence) else []


def _table(table: Mapping[str, object]) -> str:
    head, rows = table.get("head", ()), table.get("rows", ())
    assert isinstance(head, Sequence)
    assert isinstance(rows, Sequence)
    return _rows(
        tuple(map(str, head)), [tuple("" if c is None else _text(str(c)) for c in row) for row in rows]
    )


def _rows(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(row) + " |" for row in rows[:_MOST_ROWS]]
    if len(rows) > _MOST_ROWS:
        lines.append(f"\n… and {len(rows) - _MOST_ROWS} more")
    return "\n".join(lines)


def _item(item: JudgedItem) -> tuple[str, ...]:
    seconds = "" if item.seconds is None else f"{item.seconds:.3f}"
    limit = "" if item.limit_s is None else f"{item.limit_s:.3f}"
    return (_MARKS[item.status], _text(item.name), seconds, limit, _text(item.message))


def _finding(found: OutcomeFinding) -> tuple[str, ...]:
    place = (
        f"`{_code(found.file)}:{found.line}`"
        if found.line
        else f"`{_code(found.file)}`"
        if found.file
        else ""
    )
    return (f"{found.level} {found.code}", place, _text(found.message), _text(found.help))


def _code(text: str) -> str:
    return text.replace("`", "'").replace("|", "\\|").replace("\n", " ")


def _text(text: str) -> str:
    """Text on one line, with all markup characters escaped."""
    for sign in ("\\", "|", "*", "_", "<", "`", "[", "@"):
        text = text.replace(sign, f"\\{sign}" if sign not in "<@" else {"<": "&lt;", "@": "@\u200b"}[sign])
    return text.replace("\n", " ")
