"""JSON: a list with one object per program; the keys are fixed, scripts rely on them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from olp.core.diagnostic import Diagnostic
from olp.reports.formats.report import Options, Report, ReportPart

if TYPE_CHECKING:
    from olp.timing.result import Timing


_TOTALS = (
    "robot", "model", "total_s", "motion_s", "wait_s", "io_s", "untimed", "low_s", "high_s",
    "expected_low_s", "expected_high_s",
)  # fmt: skip


class Json(Report):
    """Numbers as computed, null for what does not apply or is unknown."""

    summary = "one object per program, for scripts"
    suffixes = (".json",)

    def part(
        self, file: str, timing: Timing | None, diagnostics: Sequence[Diagnostic], options: Options
    ) -> str:
        return json.dumps(as_object(file, timing, diagnostics, options), ensure_ascii=False)

    def join(self, parts: Sequence[ReportPart], options: Options) -> str:
        from olp.reports.cell import started

        first = set(started(parts))
        texts = [_with_place(part, index in first) for index, part in enumerate(parts)]
        return "[\n" + ",\n".join(texts) + "\n]\n"


def _with_place(part: ReportPart, is_started: bool) -> str:
    """The object of one program with its data that depend on the whole cell: who starts it, and its branches."""
    more: dict[str, Any] = {"started": is_started, "branches": [asdict(branch) for branch in part.branches]}
    if part.cost is not None:
        more["top"] = [
            {**asdict(line), "cause": line.cause, "by_cause": _named(line.by_cause)}
            for line in part.cost.lines
        ]
    return part.text[:-1] + ", " + json.dumps(more, ensure_ascii=False)[1:]


def _named(by_cause: Sequence[float]) -> dict[str, float]:
    from olp.timing.causes import CAUSES

    return dict(zip(CAUSES, by_cause, strict=True))


def as_object(
    file: str, timing: Timing | None, diagnostics: Sequence[Diagnostic], options: Options
) -> dict[str, Any]:
    """The object of one program, with the keys of the contract."""
    assumptions = () if timing is None else timing.assumptions
    segments = () if timing is None or not options.segments else timing.segments()
    return {
        "file": file,
        **{name: getattr(timing, name, None) for name in _TOTALS},
        "by_cause": None if timing is None else _by_cause(timing),
        "segments": list(segments),
        "assumptions": [{"line": a.line, "says": a.says, "file": a.file} for a in assumptions],
        "diagnostics": [_diagnostic(d) for d in diagnostics],
    }


def _by_cause(timing: Timing) -> dict[str, float]:
    """Seconds [s] by cause."""
    from olp.timing.causes import seconds_by_cause

    return _named([round(float(v), 9) for v in seconds_by_cause(timing).sum(axis=0)])


def _diagnostic(diagnostic: Diagnostic) -> dict[str, Any]:
    return {
        "code": diagnostic.code,
        "severity": str(diagnostic.severity),
        "file": diagnostic.file,
        "line": diagnostic.line,
        "column": diagnostic.column,
        "message": diagnostic.message,
        "help": diagnostic.help,
    }
