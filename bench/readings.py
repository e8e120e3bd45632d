"""Writes below each line of the declared readings of a language what olp reads, and what it writes of them.

For a report format NAME it writes `samples/up20/reports/NAME.report`, which `check_report` compares.

    python bench/readings.py NAME…

The programs are those of `samples/NAME/readings/`; a line that was added begins with `?` and three blanks. What is
written is a proposal: whoever keeps a line has checked it against the manual.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from olp.contracts.derived_readings import declare  # noqa: E402
from olp.contracts.readings import readings_of  # noqa: E402
from olp.contracts.reports import declare_report  # noqa: E402
from olp.contracts.writers import declare_texts  # noqa: E402
from olp.languages.limits import writable  # noqa: E402
from olp.languages.vendor import find_vendor  # noqa: E402
from olp.reports.formats import report_names  # noqa: E402


def main(names: Sequence[str]) -> int:
    for name in names:
        if name in report_names():
            declare_report(name)
            continue
        for path in readings_of(ROOT / "samples" / name):
            declare(find_vendor(name), path)
        if name in writable():
            declare_texts(find_vendor(name), ROOT / "samples" / name)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
