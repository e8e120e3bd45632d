"""The whole diagnosis of a recording: locate, name, model, prove, tell apart, or say no."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis import evidence
from olp.identification.diagnosis.case_making import case_of
from olp.identification.diagnosis.errors import errors_of, rms
from olp.identification.diagnosis.findings import ReportedFindings, findings_of
from olp.identification.diagnosis.fitting import Noise, fit
from olp.identification.diagnosis.folds import Folds, folds_of
from olp.identification.diagnosis.locate import mismatch_of
from olp.identification.diagnosis.logs_alone import diagnosis_of_logs, in_seconds, no_case
from olp.identification.diagnosis.model import DurationModel
from olp.identification.diagnosis.naming import NamingResult, name, without
from olp.identification.diagnosis.result import Diagnosis, Finding, NextExperiment, Remainder
from olp.identification.diagnosis.scatter import digits_of
from olp.identification.diagnosis.search import move_terms, price
from olp.identification.diagnosis.verdict import floor_of, joined, verdict_of
from olp.identification.diagnosis.ways import settled
from olp.timing.physics._case import MeasuredMoves

if TYPE_CHECKING:
    from olp.identification.diagnosis.logs import LogDiagnosis
    from olp.identification.recording import Recording
    from olp.robots.robot import Robot

Floats = NDArray[np.float64]

_SCALES = {"speed-scale": "scale", "clock": "rate"}  # terms that make all times longer, and their number
_ROUGHLY = 0.1  # of a tuning: a scale so near to it is that
_LEAST = 1e-5  # [s] no clock is finer than that


class DiagnosisOutcome(NamedTuple):
    """A diagnosis and what a report draws beside it."""

    diagnosis: Diagnosis
    case: MeasuredMoves
    model: DurationModel  # the findings as they act together; waits are not in it
    predicted: Floats  # (n,) [s] with the findings, waits included
    ladder: tuple[tuple[str, float, float], ...]  # name added, BIC, held-out RMSE [s]; the first is ""
    log: LogDiagnosis | None = None
    named: NamingResult | None = None  # what the search came to, with its predictions of moves it did not see


def diagnose_recording(recording: Recording, robot: Robot | None = None) -> DiagnosisOutcome:
    """Everything that a recording tells; `robot` stands for the recording's. Raises OlpError N010."""
    if robot is not None:
        recording = replace(recording, robot=robot)
    log = _log_of(recording)
    if log is not None and not len(recording.moves):
        return _logs_alone(log)
    making = case_of(recording)
    case, notes = _on_time(making.case, log), making.notes
    groups = {name: labels[making.rows] for name, labels in recording.groups().items()}
    named = name(
        case, Noise(max(digits_of(case), _LEAST)), folds_of(recording, making.rows, case.residual), groups
    )
    named = named._replace(fit=settled(named.fit, named.clean, named.noise))
    return _answer(recording, case, named, log, notes)


def _log_of(recording: Recording) -> LogDiagnosis | None:
    if recording.log is None:
        return None
    from olp.identification.diagnosis.logs import diagnose_logs

    return diagnose_logs(recording)


def _logs_alone(log: LogDiagnosis) -> DiagnosisOutcome:
    """Of a recording that has no moves."""
    return DiagnosisOutcome(
        diagnosis_of_logs(log, _unpaired(log)), no_case(), DurationModel(), np.zeros(0), (), log
    )


def _on_time(case: MeasuredMoves, log: LogDiagnosis | None) -> MeasuredMoves:
    """Durations by the simulation's clock, where the logs show that the recorder's runs at another rate."""
    rates = [clock.rate for clock in log.clocks if clock.rate_significant] if log is not None else []
    return replace(case, measured=case.measured / rates[0], derived={}) if rates else case


def _answer(
    recording: Recording,
    case: MeasuredMoves,
    named: NamingResult,
    log: LogDiagnosis | None,
    notes: tuple[str, ...],
) -> DiagnosisOutcome:
    sigma, told_by = floor_of(named)
    told = findings_of(named, case, sigma)
    while idle := _idle(told):
        named = without(named, idle)
        sigma, told_by = floor_of(named)
        told = findings_of(named, case, sigma)
    verdict = verdict_of(named)
    told, tuned = _without_tuning(told, case)
    notes = (*notes, *tuned)
    if verdict not in ("explained", "partly-explained"):
        notes = (*notes, *(f"not named for want of evidence: {f.says}" for f in told.findings))
        told = ReportedFindings([], [], [])
    model = named.fit.model if told.findings else DurationModel()
    predicted = model.seconds(case)
    if told.findings:
        predicted = np.where(named.waiting, case.measured, predicted)
    findings = _together(told.findings, log)
    raw = named.clean.residual
    held = named.clean.measured - named.selection.predicted if told.findings else raw
    diagnosis = Diagnosis(
        verdict=verdict if log is None else joined(verdict, log.verdict, bool(findings)),
        moves=len(case),
        held_out_by=named.folds.by,
        noise_floor=sigma,
        noise_from=told_by,
        mismatch=mismatch_of(case, sigma, model, named.waiting),
        findings=findings,
        indistinguishable=(*told.alike, *(log.indistinguishable if log is not None else ())),
        next_experiment=_experiment(told, case, sigma, recording),
        remainder=Remainder(rms(case.measured - predicted), named.remains.correlates),
        before=errors_of(case.residual, case.measured),
        heldout_before=errors_of(raw, named.clean.measured),
        heldout_after=errors_of(held, named.clean.measured),
        placebo=evidence.placebo(named.fit, named.clean, named.noise, named.shelf),
        notes=(*notes, *_untold(case), *(log.notes if log is not None else ())),
        unpaired=_unpaired(log),
        log=_log_json(log),
    )
    return DiagnosisOutcome(diagnosis, case, model, predicted, _ladder(named), log, named)


def _idle(told: ReportedFindings) -> str:
    """The weakest name whose interval holds the value at which it does nothing, "" when none does. What cannot be told
    from others has an interval that holds theirs."""
    alike = {name for group in told.alike for name in group}
    idle = [f for f in told.findings if f.holds_null and f.term not in alike]
    return min(idle, key=lambda f: f.evidence.delta_bic).term if idle else ""


def _without_tuning(told: ReportedFindings, case: MeasuredMoves) -> tuple[ReportedFindings, tuple[str, ...]]:
    """Beside other names, the scale that makes a stretched simulation run as it is written is the tuning of that
    simulation, taken back: it is noted, and no finding."""
    undone = [f.term for f in told.findings if f.term in _SCALES and _undoes(f, case.stretch)]
    if len(undone) != 1 or len(told.findings) < 2:
        return told, ()
    kept = [k for k, group in enumerate(told.alike) if group[0] not in undone]
    told = ReportedFindings(
        [f for f in told.findings if f.term not in undone],
        [told.alike[k] for k in kept],
        [told.rivals[k] for k in kept],
    )
    return told, (
        f"the simulated times are {abs(case.stretch - 1.0):.2%} {'longer' if case.stretch > 1.0 else 'shorter'} than "
        "the written speeds and accelerations make them, and the robot runs as written: that tuning of the simulation "
        "is taken back, and is no cause",
    )


def _undoes(finding: Finding, stretch: float) -> bool:
    """Whether a scale is that of the simulation over what is written, within its interval."""
    if stretch == 1.0:
        return False
    scale = finding.parameters.get(_SCALES[finding.term])
    if scale is None:
        return False
    asked = stretch if finding.term == "speed-scale" else 1.0 / stretch
    return abs(scale.value - asked) <= max(scale.high - scale.low, _ROUGHLY * abs(stretch - 1.0))


def _together(findings: list[Finding], log: LogDiagnosis | None) -> tuple[Finding, ...]:
    """Findings of durations and of logs; a log tells a term that both tell better, durations say in which moves."""
    found = sorted(findings, key=lambda f: -f.evidence.delta_bic)
    if log is None:
        return tuple(found)
    seen = {f.term: f for f in found}
    logged = [
        replace(f, moves=seen[f.term].moves, contribution=seen[f.term].contribution) if f.term in seen else f
        for f in in_seconds(log)
    ]
    names = {f.term for f in logged}
    return (*logged, *(f for f in found if f.term not in names))


def _experiment(
    told: ReportedFindings, case: MeasuredMoves, sigma: float, recording: Recording
) -> NextExperiment:
    """The moves that would tell the first group apart."""
    if not told.rivals:
        return NextExperiment()
    from olp.identification.diagnosis.next_experiment import design_experiment

    return design_experiment(case, told.rivals[0], sigma, recording)


def _untold(case: MeasuredMoves) -> tuple[str, ...]:
    """The terms that these columns cannot tell, and what would have to be recorded."""
    missing = [(term.name, term.lacks(case)) for term in move_terms()]
    told = "; ".join(f"{name} ({lacks})" for name, lacks in missing if lacks)
    return (f"these columns cannot tell {told}",) if told else ()


def _unpaired(log: LogDiagnosis | None) -> tuple[str, ...]:
    if log is None:
        return ()
    stretches = tuple(f"log {a:.3f} to {b:.3f} s: nothing in the simulated log" for a, b in log.unpaired)
    return (*stretches, f"{log.dropped} samples are missing") if log.dropped else stretches


def _log_json(log: LogDiagnosis | None) -> dict[str, Any] | None:
    return None if log is None else log.to_json()


def _ladder(named: NamingResult) -> tuple[tuple[str, float, float], ...]:
    """The findings added one at a time, the most telling first."""
    parts = list(named.fit.model.parts)
    case, noise = named.clean, named.noise
    steps = [("", fit(DurationModel(), case, noise))]
    while parts:
        tried = [(p, fit(DurationModel((*steps[-1][1].model.parts, p)), case, noise, 15)) for p in parts]
        part, best = min(tried, key=lambda t: price(t[1]))
        parts = [p for p in parts if p is not part]
        steps.append((part.term.name, best))
    return tuple((label, f.bic, _held_out(f.model, case, noise, named.folds)) for label, f in steps)


def _held_out(model: DurationModel, case: MeasuredMoves, noise: Noise, folds: Folds) -> float:
    left = np.zeros(len(case))
    for label in np.unique(folds.labels).tolist():
        seen = np.nonzero(folds.labels != label)[0].astype(np.int64)
        held = np.nonzero(folds.labels == label)[0].astype(np.int64)
        test = case.take(held)
        if not len(seen):
            left[held] = test.residual
            continue
        left[held] = test.measured - fit(model, case.take(seen), noise, 6).model.seconds(test)
    return rms(left)
