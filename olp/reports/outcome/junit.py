"""JUnit XML: each judged item is a test case, as CI servers show them."""

from __future__ import annotations

import re
from typing import ClassVar
from xml.sax.saxutils import escape, quoteattr

from olp.reports.outcome.model import JudgedItem, Level, Outcome, OutcomeFinding, OutcomeFormat, Status

# XML 1.0 allows no other characters, escaped or not.
_FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


class JunitFormat(OutcomeFormat):
    """For the test pages of CI servers."""

    summary: ClassVar[str] = "JUnit XML for CI servers"
    suffix: ClassVar[str] = ".xml"

    def render(self, outcome: Outcome) -> str:
        # A failed item holds its findings already.
        failed = {item.file for item in outcome.items if item.status in (Status.FAILED, Status.UNKNOWN)}
        cases = [_case(outcome, item) for item in outcome.items]
        cases += [
            _finding_case(outcome, found)
            for found in outcome.findings
            if not outcome.items or (found.level is Level.ERROR and found.file not in failed)
        ]
        failures = sum("<failure" in case for case in cases)
        errors = sum("<error" in case for case in cases)
        head = (
            f'<testsuite name={_quoted("olp " + outcome.command)} tests="{len(cases)}" '
            f'failures="{failures}" errors="{errors}" skipped="0">'
        )
        total = f'<testsuites tests="{len(cases)}" failures="{failures}" errors="{errors}">'
        rows = [
            '<?xml version="1.0" encoding="UTF-8"?>',
            total,
            head,
            *cases,
            "</testsuite>",
            "</testsuites>",
        ]
        return "\n".join(rows) + "\n"


def _case(outcome: Outcome, item: JudgedItem) -> str:
    # A budget's time is the predicted cycle, so that the server's own graphs show it.
    time = "" if item.seconds is None else f' time="{item.seconds:.3f}"'
    group = item.group or f"olp.{outcome.command}"
    head = f"<testcase classname={_quoted(group)} name={_quoted(_name(item))}{time}"
    text = _clean(item.message)
    words = {Status.FAILED: "failure", Status.UNKNOWN: "error"}
    if item.status in words:
        details = f"\n{_clean(item.details)}" if item.details else ""
        word, body = words[item.status], escape(_where(item.file, item.line) + text + details)
        return f"{head}><{word} message={_quoted(text)}>{body}</{word}></testcase>"
    note = f"<system-out>{escape(text)}</system-out>" if text else ""
    return f"{head}>{note}</testcase>" if note else f"{head}/>"


def _finding_case(outcome: Outcome, found: OutcomeFinding) -> str:
    name = _quoted(f"{found.code} {found.file}:{found.line}")
    text = _clean(found.message)
    head = f"<testcase classname={_quoted('olp.' + outcome.command)} name={name}"
    if found.level is not Level.ERROR:
        return f"{head}><system-out>{escape(text)}</system-out></testcase>"
    body = escape(_where(found.file, found.line) + text + (f"\n{_clean(found.help)}" if found.help else ""))
    return f"{head}><failure type={_quoted(found.code)} message={_quoted(text)}>{body}</failure></testcase>"


def _name(item: JudgedItem) -> str:
    return f"{item.name} ({item.file})" if item.file and item.file not in item.name else item.name


def _where(file: str, line: int) -> str:
    return f"{_clean(file)}:{line}: " if file and line else f"{_clean(file)}: " if file else ""


def _clean(text: str) -> str:
    return _FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", text)


def _quoted(text: str) -> str:
    return quoteattr(_clean(text))
