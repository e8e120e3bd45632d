"""JSON: a list with one object per program; the keys are fixed, scripts rely on them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from olp.core.diagnostic import Diagnostic
from olp.reports.formats.report import Options, Report, ReportPart

if TYPE_CHECKING:
    from olp.timing.timing import Timing


_TOTALS = (
    "robot", "model", "total_s", "motion_s", "wait_s", "io_s", "untimed", "low_s", "high_s",
    "expected_low_s", "expected_high_s",
)  # fmt: skip


class Json(Report):
    """Numbers as computed, null for what does not apply or is not known."""

    summary = "one object per program, for scripts"

    def part(
        self, file: str, timing: Timing | None, diagnostics: Sequence[Diagnostic], options: Options
    ) -> str:
        return json.dumps(as_object(file, timing, diagnostics, options), ensure_ascii=False)

    def join(self, parts: Sequence[ReportPart], options: Options) -> str:
        return "[\n" + ",\n".join(part.text for part in parts) + "\n]\n"


def as_object(
    file: str, timing: Timing | None, diagnostics: Sequence[Diagnostic], options: Options
) -> dict[str, Any]:
    """The object of one program, with the keys of the contract."""
    assumptions = () if timing is None else timing.assumptions
    segments = () if timing is None or not options.segments else timing.segments()
    return {
        "file": file,
        **{name: getattr(timing, name, None) for name in _TOTALS},
        "segments": list(segments),
        "assumptions": [{"line": a.line, "says": a.says, "file": a.file} for a in assumptions],
        "diagnostics": [_diagnostic(d) for d in diagnostics],
    }


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
