"""Gathers the data of the report and renders the template.

Nothing is loaded from elsewhere and nothing from the recording can become markup: the template escapes every value,
the page's policy allows no request, and only the script that comes with olp may run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from markupsafe import Markup

from olp.core import resources
from olp.identification.diagnosis import phrasing
from olp.identification.diagnosis.result import PHASES, Diagnosis, Errors, Finding, NextMove
from olp.identification.diagnosis.scatter import DIGITS, NEIGHBOURS, REMAINS, REPEATS
from olp.reports.diagnosis import fit_charts, svg
from olp.reports.diagnosis.fit_charts import Ladder
from olp.reports.diagnosis.mathml import mathml
from olp.reports.diagnosis.rows import (
    Floats,
    MoveRows,
    ProgramLine,
    ProgramListing,
    groups_of,
    program_lines,
    program_listings,
    rows_of,
)
from olp.reports.webpage import FOLDER, json_in_page, render_page, script_of

if TYPE_CHECKING:
    from olp.identification.diagnosis.diagnose import DiagnosisOutcome
    from olp.identification.recording.recording import Recording
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

    `job_text`: the program's text, or texts by the name that column `job` has; `log_summary`: results of a log, any
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
    """The same page as `html_report`, from whatever data are available.

    `predicted`: (n,) [s] per move of the case with all causes acting together, to check the ledger's sums;
    `ladder`: added term ("" for none), BIC and RMSE of unseen moves [s], step by step.
    """
    rows = rows_of(diagnosis, case, recording)
    lines = program_lines(rows)
    listings = program_listings(rows, job_text, lines)
    script, script_hash = script_of("diagnosis.js")
    values: dict[str, Any] = {
        "css": Markup(svg.variables() + resources.read_text(FOLDER, "diagnosis.css")),
        "js": script,
        "js_hash": script_hash,
        "data": json_in_page(fit_charts.data(rows)),
        "steps": range(svg.STEPS),
        "compared": len(rows),
        "tables": tables_of(log_summary or {}),
        **summary(diagnosis, recording),
        **fit(diagnosis, rows),
        **evidence(diagnosis, rows, ladder),
        **where(diagnosis, rows, recording),
        **findings(diagnosis, case, lines),
        **split(diagnosis, rows, lines, listings, predicted),
        **still_open(diagnosis),
    }
    return render_page(_TEMPLATE, values)


# --- Tables ---
# Any mapping of results as tables: what a log tells is a different thing for every robot.

_DEEPEST = 4
_MOST = 200  # rows


class ReportTable(NamedTuple):
    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def tables_of(summary: Mapping[str, Any], title: str = "", depth: int = 0) -> list[ReportTable]:
    """Tables of a summary: one for its single values, one for each list of mappings or mapping of mappings."""
    single = [(_words(key), _text(value)) for key, value in summary.items() if not _nested(value)]
    found = [ReportTable(title, ("name", "value"), tuple(single[:_MOST]))] if single else []
    for key, value in summary.items():
        name = f"{title}: {_words(key)}" if title else _words(key)
        if isinstance(value, Mapping) and value:
            rows = list(value.items())
            if all(isinstance(row, Mapping) and not any(map(_nested, row.values())) for _, row in rows):
                found.append(_table(name, [{"name": k, **row} for k, row in rows]))
            elif depth < _DEEPEST:
                found += tables_of(value, name, depth + 1)
        elif _nested(value) and not isinstance(value, Mapping):
            found.append(_table(name, [row if isinstance(row, Mapping) else {"value": row} for row in value]))
    return found


def _nested(value: Any) -> bool:
    if isinstance(value, Mapping):
        return True
    return isinstance(value, Sequence) and not isinstance(value, str) and any(map(_nested, value))


def _table(title: str, rows: Sequence[Mapping[Any, Any]]) -> ReportTable:
    keys = list(dict.fromkeys(key for row in rows for key in row))
    body = tuple(tuple(_text(row.get(key, "")) for key in keys) for row in rows[:_MOST])
    return ReportTable(title, tuple(map(_words, keys)), body)


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float) or hasattr(value, "dtype"):
        return phrasing.figure(float(value), 6) if not math.isnan(float(value)) else ""
    if isinstance(value, (list, tuple)):
        return ", ".join(map(_text, value))
    return "" if value is None else str(value)


def _words(key: Any) -> str:
    return str(key).replace("_", " ")


# --- Sections ---
# The report's sections as values for the template: texts, charts, tables.

_MM = 1000.0
_MUCH = 1.5  # times the noise that the recording itself shows
_PRINTED = 40  # program lines on paper; the style sheet hides the others


def summary(diagnosis: Diagnosis, recording: Recording | None) -> dict[str, Any]:
    titles = {
        "no-mismatch": "no mismatch",
        "not-judged": "not judged",
        "partly-explained": "partly explained",
        "unexplained": "not explained",
    }
    before, after = diagnosis.heldout_before, diagnosis.heldout_after
    tiles = []
    if diagnosis.findings and math.isfinite(before.rmse):
        tiles.append(
            ("Typical error before", phrasing.seconds(before.rmse), _share(before, diagnosis), "before")
        )
    elif math.isfinite(diagnosis.before.rmse):
        tiles.append(
            (
                "Typical error",
                phrasing.seconds(diagnosis.before.rmse),
                _share(diagnosis.before, diagnosis),
                "before",
            )
        )
    if diagnosis.findings and math.isfinite(after.rmse):
        tiles.append(("Typical error after", phrasing.seconds(after.rmse), _share(after, diagnosis), "after"))
    tiles.append(
        ("Noise floor", phrasing.seconds(diagnosis.noise_floor), _floor_note(diagnosis, recording), "")
    )
    held = f"held out by {diagnosis.held_out_by}" if diagnosis.held_out_by else ""
    tiles.append(("Moves compared", str(diagnosis.moves), held, ""))
    return {
        "verdict": diagnosis.verdict,
        "verdict_title": titles.get(diagnosis.verdict, diagnosis.verdict),
        "headline": phrasing.headline(diagnosis),
        "promise": phrasing.promise(diagnosis),
        "tiles": tiles,
        "facts": _facts(recording),
        "title": recording.path if recording is not None else "",
    }


_FLOORS = {
    REPEATS: "from repeated moves",
    REMAINS: "scatter of the residual",
    NEIGHBOURS: "from similar moves, because the residual has a pattern",
    DIGITS: "from the clock’s resolution",
}


def _floor_note(diagnosis: Diagnosis, recording: Recording | None) -> str:
    """Origin of the noise floor, as far as the recording shows it."""
    if not math.isfinite(diagnosis.noise_floor):
        return "smaller differences are not resolved"
    if diagnosis.noise_from in _FLOORS:
        return _FLOORS[diagnosis.noise_from]
    if recording is None:
        return "smaller differences are not resolved"
    noise = recording.noise_floor()
    if math.isfinite(noise.floor) and diagnosis.noise_floor > _MUCH * noise.floor:
        return f"scatter of the residual; the recording’s own is {phrasing.seconds(noise.floor)}"
    return (
        "from repeated moves"
        if noise.freedom and noise.floor == noise.repeats
        else "from the clock’s resolution"
    )


def _share(errors: Errors, diagnosis: Diagnosis) -> str:
    whole = "the duration" if diagnosis.moves else "the axes’ travel"  # of logs alone, see `logs_alone`
    return f"{phrasing.percent(errors.mape)} of {whole} on average" if math.isfinite(errors.mape) else ""


def _facts(recording: Recording | None) -> list[tuple[str, str]]:
    """Facts of the judged recording, for archiving the report."""
    if recording is None:
        return []
    settings, noise = recording.settings, recording.noise_floor()
    facts = [
        ("Recording", recording.path),
        ("Robot", recording.robot.name if recording.robot else "not named"),
    ]
    if settings.controller:
        facts.append(("Controller", settings.controller))
    if math.isfinite(noise.resolution):
        how = "as its digits show" if noise.inferred else "as the recording says"
        facts.append(("Resolution of the durations", f"{phrasing.seconds(noise.resolution)}, {how}"))
    if noise.freedom:
        facts.append(("Scatter of repeated moves", phrasing.seconds(noise.repeats)))
    return [*facts, ("SHA-256 of the values", recording.sha256)]


def fit(diagnosis: Diagnosis, rows: MoveRows) -> dict[str, Any]:
    noise = diagnosis.noise_floor
    whole, unseen = "all moves", "moves the fit never saw"
    if not diagnosis.moves:
        whole, unseen = "positions in the log", "blocks of the log that the fit never saw"
    errors = [
        (f"{whole}, simulation as it is", diagnosis.before),
        (f"{unseen}, before", diagnosis.heldout_before),
        (f"{unseen}, after", diagnosis.heldout_after),
    ][: 3 if diagnosis.findings else 1]
    return {
        "scatter": fit_charts.scatter(rows),
        "histogram": fit_charts.histogram(rows, noise),
        "errors": [(name, *_error(found)) for name, found in errors if math.isfinite(found.rmse)],
        "noise": phrasing.seconds(noise),
        "placebo": f"{diagnosis.placebo * 100:.0f} %" if math.isfinite(diagnosis.placebo) else "",
        "held_out_by": diagnosis.held_out_by,
        "bias": phrasing.seconds(diagnosis.mismatch.bias, sign=True),
    }


def evidence(diagnosis: Diagnosis, rows: MoveRows, ladder: Ladder) -> dict[str, Any]:
    """The steps that lead to the causes; empty if no cause was named."""
    steps = fit_charts.rungs(ladder) if rows.causes else []
    return {
        "ladder": fit_charts.ladder(steps, diagnosis.noise_floor),
        "rungs": [
            (
                step.name,
                phrasing.seconds(step.heldout),
                f"{step.bic:.0f}".replace("-", phrasing.MINUS),
                phrasing.figure(step.gain, 3) if i else "",
            )
            for i, step in enumerate(steps)
        ],
        "without": [
            (
                label,
                phrasing.seconds(f.evidence.heldout_before),
                phrasing.seconds(f.evidence.heldout_after),
                phrasing.figure(f.evidence.delta_bic, 3),
                phrasing.p_value(f.evidence.p_value),
            )
            for label, f in zip(phrasing.labels(diagnosis.findings), diagnosis.findings, strict=True)
        ],
        "waterfall": fit_charts.waterfall(rows),
        "after": phrasing.seconds(diagnosis.heldout_after.rmse),
    }


def _error(errors: Errors) -> tuple[str, str, str]:
    return phrasing.seconds(errors.rmse), phrasing.percent(errors.mape), phrasing.percent(errors.worst)


def where(diagnosis: Diagnosis, rows: MoveRows, recording: Recording | None) -> dict[str, Any]:
    noise = diagnosis.noise_floor
    told = [m for m in diagnosis.mismatch.moves if m.significant]
    phases = [(phase, [m.residual for m in told if m.phase == phase]) for phase in PHASES]
    strips = fit_charts.strips(rows, groups_of(rows, recording), noise)
    return {
        "panels": fit_charts.panels(rows),
        "legend": fit_charts.legend(rows),
        "over_time": fit_charts.over_time(rows, noise),
        "direction": fit_charts.by_direction(rows, noise),
        "steep": [
            (name, count, phrasing.seconds(before, sign=True), phrasing.seconds(after, sign=True))
            for name, count, before, after in fit_charts.steep(rows)
        ],
        "strips": strips,
        "phases": [
            (phase, len(found), phrasing.seconds(sum(found) / len(found), sign=True))
            for phase, found in phases
            if found
        ],
        "significant": len({m.move for m in told}),
    }


def findings(diagnosis: Diagnosis, case: MeasuredMoves | None, lines: list[ProgramLine]) -> dict[str, Any]:
    known = phrasing.places(diagnosis, case)
    anchors = {line.place: line.anchor for line in lines}
    labels = phrasing.labels(diagnosis.findings)
    return {
        "findings": [
            _finding(label, finding, known, anchors, i)
            for i, (label, finding) in enumerate(zip(labels, diagnosis.findings, strict=True))
        ]
    }


def _finding(
    label: str, finding: Finding, known: dict[int, phrasing.Place], anchors: dict[str, str], number: int
) -> dict[str, Any]:
    evidence = finding.evidence
    return {
        "label": label,
        "colour": number % 8,
        "says": phrasing.units(finding.says),
        "summary": phrasing.term_summary(finding.term),
        "equation": mathml(finding.equation),
        "parameters": [
            (
                name.replace("_", " "),
                phrasing.figure(p.value),
                phrasing.units(p.unit),
                _interval(p.low, p.high),
                ", ".join(phrasing.doubts(p)),
            )
            for name, p in finding.parameters.items()
        ],
        "moves": phrasing.counted(len(finding.moves), "move"),
        "largest": [
            (name, anchors.get(name, "") or f"move-{move}", phrasing.seconds(cost, sign=True))
            for name, move, cost in phrasing.few(phrasing.largest(finding, known), 5)
        ],
        "without": phrasing.seconds(evidence.heldout_before),
        "with_it": phrasing.seconds(evidence.heldout_after),
        "delta_bic": phrasing.figure(evidence.delta_bic, 3),
        "chance": phrasing.chance(evidence.p_value),
        "alternatives": [
            (phrasing.alternative(a), phrasing.figure(a.delta_bic, 2)) for a in finding.alternatives
        ],
    }


def _interval(low: float, high: float) -> str:
    if not (math.isfinite(low) and math.isfinite(high)):
        return phrasing.UNKNOWN
    return f"{phrasing.figure(low)} to {phrasing.figure(high)}"


def split(
    diagnosis: Diagnosis,
    rows: MoveRows,
    lines: list[ProgramLine],
    listings: list[ProgramListing],
    predicted: Floats | None,
) -> dict[str, Any]:
    anchors = {line.place: line.anchor for line in lines}
    listed = {line.anchor for listing in listings for line in listing.lines if line.anchor}
    return {
        "causes": list(rows.causes),
        "ledger": _ledger_lines(diagnosis, rows, anchors),
        "sums": _ledger_sums(rows),
        "check": _ledger_check(rows, predicted),
        "shares": _ledger_shares(rows),
        "program": [line._replace(listed=line.anchor in listed) for line in lines],
        "unprinted": len(lines) > _PRINTED,
        "listings": listings,
    }


def still_open(diagnosis: Diagnosis) -> dict[str, Any]:
    remainder = diagnosis.remainder
    return {
        "groups": [
            phrasing.listed([phrasing.term_title(n) for n in group]) for group in diagnosis.indistinguishable
        ],
        "why": diagnosis.next_experiment.why,
        "next_moves": [_next_move(move) for move in diagnosis.next_experiment.moves],
        "remains": phrasing.seconds(remainder.rmse),
        "correlates": [
            (c.column, phrasing.figure(c.statistic, 2), phrasing.p_value(c.p_value))
            for c in remainder.correlates
        ],
        "correction": remainder.correction,
        "notes": diagnosis.notes,
        "unpaired": diagnosis.unpaired,
    }


def _next_move(move: NextMove) -> tuple[str, ...]:
    start, end = (", ".join(f"{c * _MM:.1f}" for c in point) for point in (move.start, move.end))
    payload = "" if move.payload is None else phrasing.figure(move.payload)
    return (
        start,
        end,
        f"{move.speed * _MM:.0f}",
        payload,
        f"{move.blend * _MM:.1f}",
        str(move.times),
        move.why,
    )


# --- The ledger ---
# For every move, the difference between robot and simulation split into named causes and a remainder.


_LEDGER_LIMIT = 0.02  # that the causes may miss of the model's own prediction
_MS = 1000.0


class LedgerCell(NamedTuple):
    """A number in the ledger; `acts`: this cause exceeds the noise in this move."""

    text: str
    acts: bool


class LedgerLine(NamedTuple):
    """One move in the ledger."""

    move: int
    place: str
    anchor: str  # of the program line, "" without one
    measured: str
    simulated: str
    difference: str
    causes: tuple[LedgerCell, ...]
    remains: str
    significant: bool


class Sums(NamedTuple):
    """Totals over all moves."""

    measured: str
    simulated: str
    difference: str
    causes: tuple[str, ...]
    remains: str


class LedgerCheck(NamedTuple):
    """Whether the sum of the causes agrees with the model's prediction with all causes acting together."""

    says: str
    holds: bool


def _ledger_lines(diagnosis: Diagnosis, rows: MoveRows, anchors: Mapping[str, str]) -> list[LedgerLine]:
    """One line per move; `anchors`: program line -> its anchor in the page."""
    acting = [frozenset(finding.moves) for finding in diagnosis.findings]
    after = rows.after
    out = []
    for i, move in enumerate(rows.move.tolist()):
        causes = tuple(
            LedgerCell(_ms(values[i]), move in acts)
            for values, acts in zip(rows.causes.values(), acting, strict=True)
        )
        out.append(
            LedgerLine(
                move,
                rows.place[i],
                anchors.get(rows.place[i], ""),
                _s(rows.measured[i]),
                _s(rows.simulated[i]),
                _ms(rows.before[i]),
                causes,
                _ms(after[i]),
                bool(rows.significant[i]),
            )
        )
    return out


def _ledger_sums(rows: MoveRows) -> Sums:
    """The columns' totals."""
    return Sums(
        _s(_total(rows.measured)),
        _s(_total(rows.simulated)),
        _ms(_total(rows.before)),
        tuple(_ms(_total(values)) for values in rows.causes.values()),
        _ms(_total(rows.after)),
    )


def _ledger_check(rows: MoveRows, predicted: Floats | None) -> LedgerCheck | None:
    """The sum of the causes compared with `predicted` (n,) [s], the model with all causes acting together."""
    if not rows.causes or predicted is None:
        return None
    model = predicted - rows.simulated
    causes = rows.before - rows.after
    known = np.isfinite(model) & np.isfinite(causes)
    size = float(np.abs(model[known]).sum())
    if not known.any() or size <= 0.0:
        return None
    missed = float(np.abs(model[known] - causes[known]).sum()) / size
    says = (
        f"Move by move, the causes add up to the model with all of them together, "
        f"within {phrasing.percent(missed * 100)} (limit {_LEDGER_LIMIT * 100:.0f} %)."
    )
    return LedgerCheck(says, missed <= _LEDGER_LIMIT)


def _ledger_shares(rows: MoveRows) -> str:
    """The share of the difference that the causes explain."""
    before, after = float(np.nansum(np.abs(rows.before))), float(np.nansum(np.abs(rows.after)))
    if before <= 0.0 or not rows.causes:
        return ""
    return (
        f"Added up without signs, the moves differ by {phrasing.seconds(before)}; "
        f"{phrasing.seconds(after)} of it ({phrasing.percent(after / before * 100)}) have no name."
    )


def _total(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(known.sum()) if len(known) else math.nan


def _s(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else ""


def _ms(value: float) -> str:
    text = f"{abs(value) * _MS:.1f}"
    if not math.isfinite(value):
        return ""
    return f"{phrasing.MINUS if value < 0 and float(text) else ''}{text}"
