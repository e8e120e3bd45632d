"""SARIF 2.1.0: what code scanning services of forges read."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import ClassVar
from urllib.parse import quote

from olp.reports.outcome.model import Level, Outcome, OutcomeFinding, OutcomeFormat

_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
_LEVELS = {Level.ERROR: "error", Level.WARNING: "warning", Level.NOTE: "note"}


class SarifFormat(OutcomeFormat):
    """For code scanning."""

    summary: ClassVar[str] = "SARIF 2.1.0 for code scanning"
    suffix: ClassVar[str] = ".sarif"

    def render(self, outcome: Outcome) -> str:
        from olp.core.version import __version__

        findings = outcome.told
        codes = sorted({found.code for found in findings})
        rules = [_rule(code, findings) for code in codes]
        run = {
            "tool": {"driver": {"name": "olp", "semanticVersion": __version__, "rules": rules}},
            "automationDetails": {"id": f"olp/{outcome.command}/"},
            "columnKind": "unicodeCodePoints",
            "results": [_result(found, codes.index(found.code)) for found in findings],
        }
        return (
            json.dumps({"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}, indent=2, ensure_ascii=False)
            + "\n"
        )


def _rule(code: str, findings: Sequence[OutcomeFinding]) -> dict[str, object]:
    first = next(found for found in findings if found.code == code)
    rule: dict[str, object] = {"id": code, "shortDescription": {"text": first.title or first.message}}
    if first.help:
        rule["help"] = {"text": first.help}
    return rule


def _result(found: OutcomeFinding, rule: int) -> dict[str, object]:
    text = f"{found.message}. {found.help}" if found.help else found.message
    result: dict[str, object] = {
        "ruleId": found.code,
        "ruleIndex": rule,
        "level": _LEVELS[found.level],
        "message": {"text": text},
        "partialFingerprints": {"olp/v1": found.fingerprint},
    }
    if found.file:
        place: dict[str, object] = {"artifactLocation": {"uri": _uri(found.file)}}
        if found.line:
            place["region"] = _region(found)
        result["locations"] = [{"physicalLocation": place}]
    if found.numbers:
        result["properties"] = dict(found.numbers)
    return result


def _region(found: OutcomeFinding) -> dict[str, int]:
    region = {"startLine": found.line, "startColumn": max(1, found.column)}
    if found.end_column > found.column:
        region["endColumn"] = found.end_column
    return region


def _uri(file: str) -> str:
    return quote(file.replace("\\", "/"), errors="surrogateescape")
