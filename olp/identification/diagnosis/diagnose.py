"""The whole diagnosis of a recording: locate, name, model, prove, tell apart, or say no."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError
from olp.identification.diagnosis import evidence, phrasing
from olp.identification.diagnosis.case_making import as_simulated_otherwise
from olp.identification.diagnosis.findings import ReportedFindings, findings_of
from olp.identification.diagnosis.fitting import Noise, fit
from olp.identification.diagnosis.folds import Folds, errors_of, folds_of, rms
from olp.identification.diagnosis.intervals import settled
from olp.identification.diagnosis.model import DurationModel
from olp.identification.diagnosis.naming import NamingResult, instead, name, nameless, price_of
from olp.identification.diagnosis.residuals import FALSE_DISCOVERIES, of_axes
from olp.identification.diagnosis.result import (
    Diagnosis,
    Errors,
    Finding,
    Mismatch,
    MoveResidual,
    NextExperiment,
    Remainder,
)
from olp.identification.diagnosis.scatter import FEWEST_FAR, REMAINS, digits_of, far_out
from olp.identification.diagnosis.search import additions, move_terms, nearest_single, price
from olp.identification.diagnosis.verdict import (
    AGREES,
    FEWEST,
    far_moves,
    floor_of,
    heavy_tails,
    in_time,
    joined,
    left_over,
    only_rounding,
    taken_away,
    unseen_errors,
    verdict_of,
)
from olp.identification.recorded_plan import case_of
from olp.timing.physics._case import MeasuredMoves
from olp.timing.physics._motion import Motion

if TYPE_CHECKING:
    from olp.identification.diagnosis.logs.result import AxisResidual, LogDiagnosis
    from olp.identification.recording.recording import Recording
    from olp.robots.model import Robot


Floats = NDArray[np.float64]

_MORE_LEFT = ("unexplained", "partly-explained")
_NEAREST = 3  # terms that an experiment tells apart where none holds
_SCALES = {"speed-scale": "scale", "clock": "rate"}  # terms that make all times longer, and their number
_ROUGHLY = 0.1  # of a tuning: a scale so near to it is that
_LISTED = 10  # moves that a note names
_LEAST = 1e-5  # [s] no clock is finer than that
_HEAVY = (
    "some moves are far out, as far early as late or too few to tell, and in no kind of moves more than in others: the "
    "noise floor holds them as scatter"
)

_ROUNDED = (
    "the remaining difference is no larger than rounding to the recorder's digits; moves that take the same time are "
    "rounded by the same amount, so it can correlate with columns"
)


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
    noise, folds = Noise(max(digits_of(case), _LEAST)), folds_of(recording, making.rows, case.residual)
    named = name(case, noise, folds, groups)
    if named.fit.model.parts or named.remains.structured:
        for other, says in as_simulated_otherwise(case):
            found = name(other, noise, folds, groups)
            if price_of(found) < price_of(named):
                case, named, notes = other, found, (*making.notes, says)
    named = named._replace(fit=settled(named.fit, named.clean, named.noise))
    return _answer(recording, case, named, log, notes)


def _log_of(recording: Recording) -> LogDiagnosis | None:
    if recording.log is None:
        return None
    from olp.identification.diagnosis.logs.diagnose import diagnose_logs

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
    gone, fallen = set[str](), dict(named.fallen)
    while idle := _idle(told):
        gone.add(idle)
        named, told = _without_idle(named, told, case, gone)
        fallen |= {**named.fallen, idle: "the intervals of its numbers hold those at which it does nothing"}
        sigma, told_by = floor_of(named)
    fallen = {term: why for term, why in fallen.items() if term not in {f.term for f in told.findings}}
    told, tuned = _without_tuning(told, case)
    less = taken_away(named)
    # That some moves wait is no doubt, and a difference that unseen moves show is real.
    doubted = less < 1.0 and (named.late.any() or (told_by == REMAINS and less > 0.0))
    if less < 1.0:
        tuned = (*tuned, *(f"not named for want of evidence: {f.says}" for f in told.findings))
        told = ReportedFindings([], [], [])
        if not named.late.any():
            named = nameless(named)
            sigma, told_by = floor_of(named)
    verdict, tails = "unexplained" if doubted else verdict_of(named), heavy_tails(named)
    floor = math.hypot(sigma, math.sqrt(tails))
    experiment = _experiment(told, named, verdict, case, sigma, recording)
    beside = _beside_the_judged(recording, case, floor) if verdict == "no-mismatch" else ()
    verdict = "unexplained" if beside else verdict
    axes = of_axes(left_over(named), named.clean) if verdict in _MORE_LEFT else ()
    hints = tuple(sorted((*named.remains.correlates, *axes), key=lambda hint: hint.p_value))
    if verdict == "unexplained" and not told.findings:
        notes = (*_far(named), *notes)
    if told.findings:
        notes = (*_lone(named), *notes)
    notes = (*beside, *notes, *tuned, *((_HEAVY,) if tails > 0 else ()))
    if named.remains.structured and only_rounding(named):
        notes = (*notes, _ROUNDED)
    model = named.fit.model if told.findings else DurationModel()
    predicted = model.seconds(case)
    if told.findings:
        predicted = np.where(named.waiting, case.measured, predicted)
    findings = _together(told.findings, log)
    notes = (*notes, *_fallen(fallen, findings))
    unseen, judged = case.residual, case.measured
    if told.findings:
        unseen, judged = unseen_errors(named), named.clean.measured[in_time(named)]
    diagnosis = Diagnosis(
        verdict=verdict if log is None else joined(verdict, log.verdict, bool(findings)),
        moves=len(case),
        held_out_by=named.folds.by,
        noise_floor=floor,
        noise_from=told_by,
        mismatch=mismatch_of(case, sigma, model, named.waiting),
        findings=findings,
        indistinguishable=(*told.alike, *(log.indistinguishable if log is not None else ())),
        next_experiment=experiment,
        remainder=Remainder(rms(case.measured - predicted), hints),
        before=errors_of(case.residual, case.measured),
        heldout_before=errors_of(case.residual, case.measured),
        heldout_after=errors_of(unseen, judged),
        placebo=evidence.placebo(named.fit, named.clean, named.shelf),
        notes=(*notes, *_held_back(named), *_untold(case), *(log.notes if log is not None else ())),
        unpaired=_unpaired(log),
        log=_log_json(log),
    )
    return DiagnosisOutcome(diagnosis, case, model, predicted, _ladder(named), log, named)


def _beside_the_judged(recording: Recording, case: MeasuredMoves, floor: float) -> tuple[str, ...]:
    """That moves without a known length or speed differ: then judged ones that agree say nothing of the whole."""
    moves = recording.moves
    both = moves.measured & np.isfinite(moves.sim) & (moves.duration > 0) & ~np.isin(moves.move, case.move)
    off = (moves.duration - moves.sim)[both]
    if len(off) < FEWEST or rms(off) <= AGREES * floor:
        return ()
    others = f"{phrasing.counted(len(off), 'other')} differ by typically {phrasing.seconds(rms(off))}"
    return (
        f"the {len(case)} moves of known length and speed agree with the simulation; {others}: to say why, give their "
        "joints or points, and speeds",
    )


def _far(named: NamingResult) -> tuple[str, ...]:
    """The moves that are far out on one side, where these alone may be the difference."""
    far = far_moves(named)
    if not far.any():
        return ()
    off, moves = left_over(named)[far], [str(move) for move in named.clean.move[far].tolist()]
    told = ", ".join(moves if len(moves) <= _LISTED else [*moves[:_LISTED], "…"])
    side, least, most = "late" if off[0] > 0 else "early", np.abs(off).min(), np.abs(off).max()
    return (
        f"some moves ({told}) are {side} by {phrasing.seconds(least)} to {phrasing.seconds(most)}, more and by more "
        "than on the other side: a scatter has tails on both",
    )


def _lone(named: NamingResult) -> tuple[str, ...]:
    """One move or two that are far off with the names, too: they may be all that is left."""
    off = left_over(named)
    far = far_out(off - np.median(off), named.clean.resolution)
    if not 0 < far.sum() < FEWEST_FAR:
        return ()
    told = [
        f"move {move} by {phrasing.seconds(abs(by))} ({'late' if by > 0 else 'early'})"
        for move, by in zip(named.clean.move[far].tolist(), off[far].tolist(), strict=True)
    ]
    return (f"still far off with what is named: {' and '.join(told)}; too few moves to tell why",)


def _idle(told: ReportedFindings) -> str:
    """The weakest name whose interval holds the value at which it does nothing, "" when none does."""
    idle = [f for f in told.findings if f.holds_null]
    return min(idle, key=lambda f: f.evidence.delta_bic).term if idle else ""


def _without_idle(
    named: NamingResult, told: ReportedFindings, case: MeasuredMoves, gone: set[str]
) -> tuple[NamingResult, ReportedFindings]:
    """The others, or with them a name that is as good as the one that is `gone` and surely does something."""
    model = named.fit.model
    kept = DurationModel(tuple(part for part in model.parts if part.term.name not in gone))
    as_good = [rivals[1:] for group, rivals in zip(told.alike, told.rivals, strict=True) if group[0] in gone]
    for rival in (*(one for rivals in as_good for one in rivals), kept):
        more = {part.term.name for part in rival.parts} - {part.term.name for part in kept.parts}
        if more & gone:
            continue
        other = instead(named, rival)
        said = findings_of(other, case, floor_of(other).value)
        sure = {f.term for f in said.findings if not f.holds_null}
        if more <= sure:
            break
    return other, said


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
        "the written speeds and accelerations give, and the robot runs as written: this tuning of the simulation "
        "is removed, and is no cause",
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
    told: ReportedFindings,
    named: NamingResult,
    verdict: str,
    case: MeasuredMoves,
    sigma: float,
    recording: Recording,
) -> NextExperiment:
    """The moves that would tell the groups apart; where a difference has no name, those that tell apart what comes
    nearest to it."""
    from olp.identification.diagnosis.next_experiment import design_experiment

    if told.rivals:
        each = [
            design_experiment(case, rivals, sigma, recording) for rivals in told.rivals if len(rivals) > 1
        ]
        return NextExperiment(
            "; ".join(dict.fromkeys(one.why for one in each if one.why)),
            tuple(dict.fromkeys(move for one in each for move in one.moves)),
            tuple(dict.fromkeys(timer for one in each for timer in one.timers)),
        )
    if verdict in ("no-mismatch", "not-judged", "explained") or (
        told.findings and not named.remains.structured
    ):
        return NextExperiment()
    if told.findings:
        nearest, rest = _beyond_the_names(named), "more remains; of the nearest terms beside the names"
    else:
        nearest = nearest_single(named.shelf, named.clean, named.noise, _NEAREST)
        rest = "no name holds; of the nearest terms"
    found = design_experiment(case, nearest, sigma, recording)
    return replace(found, why=f"{rest}, {found.why}") if found.why else found


def _beyond_the_names(named: NamingResult) -> list[DurationModel]:
    """The names, each time with one of the terms that promise most beside them."""
    best, case, noise = named.fit, named.clean, named.noise
    more = {part.term.name: part for part in additions(named.shelf, best, case, noise, 2 * _NEAREST)}
    models = [DurationModel((*best.model.parts, part)) for part in more.values()]
    return [one.model for one in sorted((fit(m, case, noise) for m in models), key=price)[:_NEAREST]]


def _fallen(fallen: dict[str, str], findings: Sequence[Finding]) -> tuple[str, ...]:
    """The names that the search found, and why they are none."""
    named = {finding.term for finding in findings}
    told = "; ".join(f"{name} ({why})" for name, why in fallen.items() if name not in named)
    return (f"found by the search, and not named: {told}",) if told else ()


def _held_back(named: NamingResult) -> tuple[str, ...]:
    """That the names do not reach as far as the recording, which shows on moves that they were not fitted to."""
    if not named.selection.held or not named.fit.model.parts:
        return ()
    return (
        f"in {named.selection.held} of {len(named.clean)} moves, names that were fitted to the others change more than "
        "in any of these, and the unseen error counts the largest change seen there: do not predict moves beyond the "
        "recorded ones by them",
    )


def _untold(case: MeasuredMoves) -> tuple[str, ...]:
    """The terms that these columns cannot tell, and what would have to be recorded."""
    missing = [(term.name, term.lacks(case)) for term in move_terms()]
    told = "; ".join(f"{name} ({lacks})" for name, lacks in missing if lacks)
    return (f"these columns cannot identify {told}",) if told else ()


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
        test = case.fold(held)
        if not len(seen):
            left[held] = test.residual
            continue
        left[held] = test.measured - fit(model, case.fold(seen), noise, 6).model.seconds(test)
    return rms(left)


# --- Locate ---
# Where simulation and recording differ: move by move, significant or not, and in which phase.


def mismatch_of(case: MeasuredMoves, sigma: float, model: DurationModel, late: NDArray[np.bool_]) -> Mismatch:
    """Residuals of all moves against the judged simulation."""
    residual = case.residual
    chosen = significant(residual, sigma)
    phases = _phases(case, model, late)
    moves = tuple(
        MoveResidual(
            int(case.move[i]),
            case.job[i] or None,
            int(case.line[i]) or None,
            phases[i],
            float(residual[i]),
            bool(chosen[i]),
        )
        for i in range(len(case))
    )
    return Mismatch(float(residual.mean()), errors_of(residual, case.measured), moves)


def significant(residual: Floats, sigma: float) -> NDArray[np.bool_]:
    """(n,) beyond the noise, at most 5 % false ones (Y. Benjamini, Y. Hochberg, J. R. Statist. Soc. B 57, 1995)."""
    tail = np.array([math.erfc(abs(r) / sigma / math.sqrt(2.0)) for r in residual.tolist()])
    order = np.argsort(tail)
    passed = tail[order] <= FALSE_DISCOVERIES * np.arange(1, len(tail) + 1) / len(tail)
    count = int(np.nonzero(passed)[0].max()) + 1 if passed.any() else 0
    chosen = np.zeros(len(tail), dtype=bool)
    chosen[order[:count]] = True
    return chosen


def _phases(case: MeasuredMoves, model: DurationModel, late: NDArray[np.bool_]) -> list[str]:
    """Of the term that does most in a move; "whole" without one."""
    shares = model.contributions(case)
    if not shares:
        return ["settle" if waits else "whole" for waits in late.tolist()]
    most = np.argmax(np.abs(shares), axis=0)
    names = [part.term.phase for part in model.parts]
    return ["settle" if waits else names[k] for k, waits in zip(most.tolist(), late.tolist(), strict=True)]


# --- Logs alone ---
# A recording that has logs and no moves: the diagnosis is what the logs tell.

_NOTE = "no moves were recorded: durations are not judged, only the logs"


def diagnosis_of_logs(log: LogDiagnosis, unpaired: tuple[str, ...]) -> Diagnosis:
    """The whole answer from logs. `unpaired`: what could not be paired, in words.

    Seconds are those by which an axis at its RMS speed would have to be early or late to be as far off, the mean
    square over axes; percentages are of an axis' travel, on the mean and the worst. nan where none is judged.
    """
    axes = _judged(log)
    after, floor = (_seconds(axes, name) for name in ("after", "floor"))
    errors = {name: _errors(axes, name) for name in ("before", "after")}
    late = float(np.mean([a.late for a in axes])) if axes else math.nan
    return Diagnosis(
        verdict=log.verdict,
        moves=0,
        held_out_by="blocks of the log",
        noise_floor=floor,
        noise_from="rests and neighbouring samples" if math.isfinite(floor) else "",
        mismatch=Mismatch(late, errors["before"], ()),
        findings=in_seconds(log),
        indistinguishable=log.indistinguishable,
        next_experiment=NextExperiment(log.next_experiment),
        remainder=Remainder(after),
        before=errors["before"],
        heldout_before=errors["before"],
        heldout_after=errors["after"],
        notes=(_NOTE, *log.notes),
        unpaired=unpaired,
        log=log.to_json(),
    )


def nothing_to_compare(problem: OlpError) -> Diagnosis:
    """The answer where `diagnose_recording` raised N010; raises any other `problem` again."""
    if [d.code for d in problem.diagnostics] != ["N010"]:
        raise problem
    found = problem.diagnostics[0]
    return Diagnosis(
        verdict="not-judged",
        moves=0,
        held_out_by="",
        noise_floor=math.nan,
        mismatch=Mismatch(math.nan, Errors(math.nan, math.nan, math.nan), ()),
        remainder=Remainder(math.nan),
        notes=(f"{found.message}; {found.help}",),
    )


def _seconds(axes: list[AxisResidual], name: str) -> float:
    """[s] Root mean square over axes of a position's error over its axis' RMS speed."""
    values = np.array([getattr(a, name) / a.pace for a in axes])
    values = values[np.isfinite(values)]
    return rms(values) if len(values) else math.nan


def _errors(axes: list[AxisResidual], name: str) -> Errors:
    shares = [100.0 * getattr(a, name) / a.reach for a in axes if a.reach > 0]
    if not shares:
        return Errors(math.nan, math.nan, math.nan)
    return Errors(_seconds(axes, name), float(np.mean(shares)), float(np.max(shares)))


def in_seconds(log: LogDiagnosis) -> tuple[Finding, ...]:
    """The findings with the errors of their axes on unseen blocks, in seconds; a clock's are those of all axes.

    Torques have no seconds: their errors stand in the log's own part of the answer.
    """
    return tuple(_in_seconds(finding, log, _judged(log)) for finding in log.findings)


def _off(log: LogDiagnosis) -> float:
    """[s] RMS by which the clock that is farthest off reads wrong over the log, its rate and its offset."""
    off = [0.0]
    for clock in log.clocks:
        drift = (clock.rate - 1.0) * log.span / math.sqrt(12.0) if clock.rate_significant else 0.0
        off.append(math.hypot(drift, clock.offset if clock.offset_significant else 0.0))
    return max(off)


def _judged(log: LogDiagnosis) -> list[AxisResidual]:
    return [a for a in log.axes if a.signal == "position" and a.pace > 0]


def _in_seconds(finding: Finding, log: LogDiagnosis, axes: list[AxisResidual]) -> Finding:
    pace = {a.axis: a.pace for a in axes}
    own = [e for e in log.evidence if e.term == finding.term and e.signal == "position"]
    told = [e for e in own if e.axis in pace and math.isfinite(e.heldout_before)]
    if told:
        before, after = (
            rms(np.array([getattr(e, name) / pace[e.axis] for e in told]))
            for name in ("heldout_before", "heldout_after")
        )
    elif finding.term == "clock" and axes:
        after = _seconds(axes, "after")
        before = math.hypot(after, _off(log))
    else:
        return finding
    return replace(finding, evidence=finding.evidence._replace(heldout_before=before, heldout_after=after))


def no_case() -> MeasuredMoves:
    """The case of no moves at all."""
    one, three = np.zeros(0), np.zeros((0, 3))
    number, mask = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.bool_)
    motion = Motion(one, one, one, one, one, one, one, one, one, one)
    return MeasuredMoves(
        *(number, one, one, motion, mask, mask, three, three, one, mask, mask),
        *(one, one, one, one, one, one, number, (), number),
    )
