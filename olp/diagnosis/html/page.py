"""The page: gathers what the report shows and sets it into the template.

Nothing is loaded from elsewhere and nothing from the recording can become markup: the template escapes every
value, the page's policy allows no request, and only the script that comes with olp may run.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from olp import resources
from olp.diagnosis import words
from olp.diagnosis.html import colours, path_charts, program, sections
from olp.diagnosis.html.fit_charts import Ladder
from olp.diagnosis.html.rows import Floats, rows_of
from olp.diagnosis.html.tables import tables_of
from olp.diagnosis.result import Diagnosis

if TYPE_CHECKING:
    from olp.diagnosis.diagnose import Outcome
    from olp.physics._case import Case
    from olp.recording import Recording

_FOLDER, _TEMPLATE = "templates", "diagnosis.html.j2"


def html_report(
    outcome: Outcome,
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
    case: Case | None = None,
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
    script = Markup(resources.read_text(_FOLDER, "diagnosis.js"))
    values: dict[str, Any] = {
        "css": Markup(colours.variables() + resources.read_text(_FOLDER, "diagnosis.css")),
        "js": script,
        "js_hash": base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
        "data": _json(path_charts.data(rows)),
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
    return _render(values)


def _render(values: dict[str, Any]) -> str:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    # Not olp.templating: that renders strangers' templates as plain text; this one is olp's own and escapes.
    environment = Environment(
        loader=FunctionLoader(lambda name: resources.read_text(_FOLDER, name)),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_clean,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(_TEMPLATE).render(values)


def _clean(value: Any) -> Any:
    """Values as they may stand in a page: markup of olp's own, or printable text."""
    return words.plain(value) if isinstance(value, str) and not isinstance(value, Markup) else value


def _json(value: Any) -> Markup:
    """JSON that may stand in a <script>: no character in it can end the element."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(text)
