"""Old sins: a file of findings that are known and excused, so that only new ones break the build.

Codes: W901 a baseline that cannot be read.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from olp.core.diagnostic import OlpError, error
from olp.core.files import parse_json, read_input
from olp.reports.outcome.model import OutcomeFinding

_VERSION = 1


def read_baseline(path: Path) -> dict[str, int]:
    """Fingerprint -> how many such findings are known. Raises OlpError (W901)."""
    try:
        whole = parse_json(read_input(path))
        rows = whole["findings"] if whole["version"] == _VERSION else []
        return {str(row["fingerprint"]): int(row["count"]) for row in rows}
    except OSError as problem:
        why = problem.strerror or "it cannot be read"
    except (ValueError, KeyError, TypeError, OverflowError):
        why = "it is not a baseline of olp lint"
    raise OlpError(
        error("W901", f"the baseline: {why}", file=str(path), help="olp lint --write-baseline FILE makes one")
    )


def baseline_text(findings: Iterable[OutcomeFinding]) -> str:
    """The text of a baseline that excuses `findings`, sorted, so that versions of it can be compared."""
    found = list(findings)
    counts = Counter(f.fingerprint for f in found)
    first = {f.fingerprint: f for f in reversed(found)}
    order = sorted(counts, key=lambda mark: (first[mark].file, first[mark].code, mark))
    rows = [{"fingerprint": mark, "count": counts[mark], **_told(first[mark])} for mark in order]
    return json.dumps({"version": _VERSION, "findings": rows}, indent=1, ensure_ascii=False) + "\n"


def _told(finding: OutcomeFinding) -> dict[str, str]:
    """For people who read the file; it is not read back."""
    return {"code": finding.code, "file": finding.file, "says": finding.message}
