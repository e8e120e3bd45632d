"""GitLab's code quality report: a JSON list, shown at the line in the merge request."""

from __future__ import annotations

import json
from typing import ClassVar

from olp.reports.outcome.model import Level, Outcome, OutcomeFinding, OutcomeFormat

_SEVERITIES = {Level.ERROR: "major", Level.WARNING: "minor", Level.NOTE: "info"}


class GitlabFormat(OutcomeFormat):
    """For merge requests of GitLab."""

    summary: ClassVar[str] = "code quality report for GitLab"
    suffix: ClassVar[str] = ".json"

    def render(self, outcome: Outcome) -> str:
        seen: dict[str, int] = {}
        rows = [_row(found, seen) for found in outcome.told]
        return json.dumps(rows, indent=2, ensure_ascii=False) + "\n"


def _row(found: OutcomeFinding, seen: dict[str, int]) -> dict[str, object]:
    # Two findings of one line must differ, or the forge drops one of them.
    count = seen[found.fingerprint] = seen.get(found.fingerprint, 0) + 1
    mark = found.fingerprint if count == 1 else f"{found.fingerprint}-{count}"
    return {
        "description": f"{found.message}. {found.help}" if found.help else found.message,
        "check_name": found.code,
        "fingerprint": mark,
        "severity": _SEVERITIES[found.level],
        "location": {"path": found.file.replace("\\", "/"), "lines": {"begin": max(1, found.line)}},
    }
