"""The page: gathers what the report shows and sets it into the template.

Nothing is loaded from elsewhere and nothing from the recording can become markup: the template escapes every
value, the page's policy allows no request, and only the script that comes with olp may run.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from olp.core import resources
from olp.identification.diagnosis.result import Diagnosis
from olp.reports.diagnosis import colours, path_charts, program, sections
from olp.reports.diagnosis.fit_charts import Ladder
from olp.reports.diagnosis.rows import Floats, rows_of
from olp.reports.diagnosis.tables import tables_of
from olp.reports.webpage import FOLDER, json_in_page, render_page, script_of

if TYPE_CHECKING:
    from olp.identification.diagnosis.diagnose import DiagnosisOutcome
    from olp.identification.recording import Recording
    from olp.timing.physics._case import MeasuredMoves

_TEMPLATE = "diagnosis.html.j2"


def html_report(
    outcome: DiagnosisOutcome,
    recording: Recording | None = None,
    job_text: str | Mapping[str, str] | None = None,
    *,
    log_summary: Mapping[str, Any] | None = None,
) -> str:
    """One self-contained HTML file, UTF-8.

    `job_text`: the program's text, or texts by the name that column `job` has; `log_summary`: what a log told, any
    nested names and numbers.
    """
    return diagnosis_page(
        outcome.diagnosis,
        outcome.case,
        recording,
        job_text,
        log_summary=log_summary,
        predicted=outcome.predicted,
        ladder=outcome.ladder,
    )


def diagnosis_page(
    diagnosis: Diagnosis,
    case: MeasuredMoves | None = None,
    recording: Recording | None = None,
    job_text: str | Mapping[str, str] | None = None,
    *,
    log_summary: Mapping[str, Any] | None = None,
    predicted: Floats | None = None,
    ladder: Ladder = (),
) -> str:
    """The same of as much as there is.

    `predicted`: (n,) [s] per move of the case with all causes at work at once, to check the ledger's sums; `ladder`:
    term added ("" for none), BIC and RMSE of unseen moves [s], step by step.
    """
    rows = rows_of(diagnosis, case, recording)
    lines = program.program_lines(rows)
    listings = program.listings(rows, job_text, lines)
    script, script_hash = script_of("diagnosis.js")
    values: dict[str, Any] = {
        "css": Markup(colours.variables() + resources.read_text(FOLDER, "diagnosis.css")),
        "js": script,
        "js_hash": script_hash,
        "data": json_in_page(path_charts.data(rows)),
        "steps": range(colours.STEPS),
        "compared": len(rows),
        "tables": tables_of(log_summary or {}),
        **sections.summary(diagnosis, recording),
        **sections.fit(diagnosis, rows),
        **sections.evidence(diagnosis, rows, ladder),
        **sections.where(diagnosis, rows, recording),
        **sections.findings(diagnosis, case, lines),
        **sections.split(diagnosis, rows, lines, listings, predicted),
        **sections.still_open(diagnosis),
    }
    return render_page(_TEMPLATE, values)
