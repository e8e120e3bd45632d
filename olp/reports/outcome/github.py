"""Annotations of GitHub Actions: one command per finding, shown at the line in the pull request."""

from __future__ import annotations

from typing import ClassVar

from olp.reports.outcome.model import JudgedItem, Level, Outcome, OutcomeFinding, OutcomeFormat, Status

_WORDS = {Level.ERROR: "error", Level.WARNING: "warning", Level.NOTE: "notice"}


class GithubFormat(OutcomeFormat):
    """For GitHub Actions."""

    summary: ClassVar[str] = "annotations for GitHub Actions"
    suffix: ClassVar[str] = ".txt"

    def render(self, outcome: Outcome) -> str:
        rows = [_row(found) for found in outcome.findings]
        files = {found.file for found in outcome.findings}
        places = {(found.file, found.line) for found in outcome.findings}
        rows += [_item(item) for item in outcome.items if _untold(item, files, places)]
        rows += outcome.summary
        return "".join(f"{row}\n" for row in rows)


def _untold(item: JudgedItem, files: set[str], places: set[tuple[str, int]]) -> bool:
    """Whether no finding reports an item's result."""
    return item.untold(places) or (item.status is Status.FAILED and item.file not in files)


def _row(found: OutcomeFinding) -> str:
    place = [f"file={_property(found.file)}"] if found.file else []
    if found.line:
        place += [f"line={found.line}", f"col={max(1, found.column)}"]
    place.append(f"title={_property(f'{found.code} {found.title}'.strip())}")
    text = f"{found.message}\n{found.help}" if found.help else found.message
    return f"::{_WORDS[found.level]} {','.join(place)}::{_data(text)}"


def _item(item: JudgedItem) -> str:
    place = [f"file={_property(item.file)}"] if item.file else []
    place += [f"line={item.line}"] if item.line else []
    place.append(f"title={_property(item.name)}")
    return f"::error {','.join(place)}::{_data(item.message or str(item.status))}"


def _data(text: str) -> str:
    """Text escaped for the message part of a GitHub command."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
