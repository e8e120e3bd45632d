"""JSON: everything, for scripts. The keys stay as they are."""

from __future__ import annotations

import json
from typing import ClassVar

from olp.reports.outcome.model import JudgedItem, Outcome, OutcomeFinding, OutcomeFormat


class JsonFormat(OutcomeFormat):
    """For scripts."""

    summary: ClassVar[str] = "JSON for scripts"
    suffix: ClassVar[str] = ".json"

    def render(self, outcome: Outcome) -> str:
        whole = {
            "command": outcome.command,
            "exit_status": outcome.exit_status,
            "findings": [_finding(found) for found in outcome.findings],
            "items": [_item(item) for item in outcome.items],
            "summary": list(outcome.summary),
            **outcome.data,
        }
        return json.dumps(whole, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _finding(found: OutcomeFinding) -> dict[str, object]:
    return {
        "code": found.code,
        "level": str(found.level),
        "message": found.message,
        "file": found.file,
        "line": found.line,
        "column": found.column,
        "help": found.help,
        "title": found.title,
        "fingerprint": found.fingerprint,
        "numbers": dict(found.numbers),
        "fixable": bool(found.fixes),
    }


def _item(item: JudgedItem) -> dict[str, object]:
    return {
        "name": item.name,
        "file": item.file,
        "line": item.line,
        "status": str(item.status),
        "message": item.message,
        "seconds": item.seconds,
        "limit_s": item.limit_s,
        "low_s": item.low_s,
        "high_s": item.high_s,
        "group": item.group,
    }
