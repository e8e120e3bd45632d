"""MACRO.DAT: which job a macro number calls.

Layout, as seen in backups: `//MACRO1 n`, `///JOB1 name`, arguments.
"""

from __future__ import annotations

from olp.robots.backup.controller_text import BackupFindings, BackupLine, blocks, record


def read_macro_dat(rows: tuple[BackupLine, ...], findings: BackupFindings) -> dict[int, str]:
    """The job names by macro number, the n of `MACRO1 MJ#(n)`. Numbers without a job are left out."""
    jobs: dict[int, str] = {}
    for block in blocks(rows, "MACRO1", findings):
        named = [(row, rest) for row in block.rows for _, keyword, rest in [record(row)] if keyword == "JOB1"]
        for row, job in named:
            if not job:
                continue
            if block.number in jobs:
                findings.warning("B005", f"macro {block.number} is given twice; the last one is used", row)
            jobs[block.number] = job
        if not named and block.rows:
            findings.warning("B002", f"macro {block.number} has no ///JOB1 row", block.head)
    return jobs
