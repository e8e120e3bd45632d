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
from olp.identification.diagnosis.fitting import LATTICE, ModelFit, Noise, fit, loss_of, penalty, whiten
from olp.identification.diagnosis.folds import Folds, errors_of, folds_of, rms
from olp.identification.diagnosis.intervals import ALIKE, parameters_with_intervals, settled
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.diagnosis.naming import NamingResult, instead, name, nameless
from olp.identification.diagnosis.residuals import LEVEL, of_axes
from olp.identification.diagnosis.result import (
    Alternative,
    Diagnosis,
    Errors,
    Evidence,
    Finding,
    FittedParameter,
    Mismatch,
    MoveResidual,
    NextExperiment,
    Remainder,
)
from olp.identification.diagnosis.scatter import REMAINS, Scatter, beyond_digits, digits_of, scatter_of
from olp.identification.diagnosis.search import PRICE, additions, move_terms, nearest_single, price, swaps
from olp.identification.diagnosis.waits import spread, tails_of
from olp.identification.recorded_plan import case_of
from olp.timing.physics import TermParameter, load_term
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
_LEAST = 1e-5  # [s] no clock is finer than that
_HEAVY = (
    "some moves are far out, as far early as late or too few to tell, and in no kind of moves more than in others: the "
    "noise floor holds them as scatter"
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
    named = name(
        case, Noise(max(digits_of(case), _LEAST)), folds_of(recording, making.rows, case.residual), groups
    )
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
    less = _taken_away(named)
    doubted = told_by == REMAINS and 0.0 < less < 1.0  # a difference that unseen moves show is real
    if less < 1.0:
        tuned = (*tuned, *(f"not named for want of evidence: {f.says}" for f in told.findings))
        told = ReportedFindings([], [], [])
        if not named.late.any():
            named = nameless(named)
            sigma, told_by = floor_of(named)
    verdict, tails = "unexplained" if doubted else verdict_of(named), _tails(named)
    floor = math.hypot(sigma, math.sqrt(tails))
    beside = _beside_the_judged(recording, case, floor) if verdict == "no-mismatch" else ()
    verdict = "unexplained" if beside else verdict
    axes = of_axes(left_over(named), named.clean) if verdict in _MORE_LEFT else ()
    hints = tuple(sorted((*named.remains.correlates, *axes), key=lambda hint: hint.p_value))
    notes = (*beside, *notes, *tuned, *((_HEAVY,) if tails > 0 else ()))
    model = named.fit.model if told.findings else DurationModel()
    predicted = model.seconds(case)
    if told.findings:
        predicted = np.where(named.waiting, case.measured, predicted)
    findings = _together(told.findings, log)
    notes = (*notes, *_fallen(fallen, findings))
    unseen, judged = case.residual, case.measured
    if told.findings:
        unseen, judged = _unseen(named), named.clean.measured[_in_time(named)]
    diagnosis = Diagnosis(
        verdict=verdict if log is None else joined(verdict, log.verdict, bool(findings)),
        moves=len(case),
        held_out_by=named.folds.by,
        noise_floor=floor,
        noise_from=told_by,
        mismatch=mismatch_of(case, sigma, model, named.waiting),
        findings=findings,
        indistinguishable=(*told.alike, *(log.indistinguishable if log is not None else ())),
        next_experiment=_experiment(told, named, case, sigma, recording),
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


def _unseen(named: NamingResult) -> Floats:
    """(m,) [s] of the moves that do not wait, by names that were found and fitted without them."""
    predicted = named.selection.predicted if named.fit.model.parts else named.clean.simulated
    return np.asarray((named.clean.measured - predicted)[_in_time(named)])


def _in_time(named: NamingResult) -> NDArray[np.bool_]:
    """Of the moves that were fitted, those that do not wait: some wait for less than the terms may be off by."""
    return np.asarray(~named.waiting[~named.late])


def _beside_the_judged(recording: Recording, case: MeasuredMoves, floor: float) -> tuple[str, ...]:
    """That moves without a known length or speed differ: then judged ones that agree say nothing of the whole."""
    moves = recording.moves
    both = moves.measured & np.isfinite(moves.sim) & (moves.duration > 0) & ~np.isin(moves.move, case.move)
    off = (moves.duration - moves.sim)[both]
    if len(off) < _FEWEST or rms(off) <= AGREES * floor:
        return ()
    others = f"{phrasing.counted(len(off), 'other')} differ by typically {phrasing.seconds(rms(off))}"
    return (
        f"the {len(case)} moves of known length and speed agree with the simulation; {others}: to say why, give their "
        "joints or points, and speeds",
    )


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
    told: ReportedFindings, named: NamingResult, case: MeasuredMoves, sigma: float, recording: Recording
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
    verdict = verdict_of(named)
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
    passed = tail[order] <= evidence.FALSE_DISCOVERIES * np.arange(1, len(tail) + 1) / len(tail)
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


# --- Verdict ---
# The verdict, and the noise that it is measured by: what the names leave over the noise floor, and nothing else.

AGREES = 2.0  # times the noise floor: what is off by more is no agreement
EXPLAINED = 1.5  # times the noise floor that names leave at most
_FEWEST = 4  # moves; fewer are no comparison
_HALVED = 4.0  # times the mean square: an explanation takes away half of the error, at least
_MORE = 2.0  # times the mean square: names that explain more of it than they leave
_GROWS = 0.01  # [s/s] of the moves' times: makers say of their own simulations that they are off by no more
_FAR = 6.0  # times the middle's scatter: what is farther off counts as that, no single long move decides


def floor_of(named: NamingResult) -> Scatter:
    """Of repeats where there are enough, else of what remains or of moves that are alike; at least the digits."""
    least = max(digits_of(named.clean), named.noise.least)
    return scatter_of(left_over(named), named.clean, least, named.remains.structured)


def left_over(named: NamingResult) -> Floats:
    """(n,) [s] of the moves that are not late."""
    return np.asarray(named.clean.measured - named.fit.model.seconds(named.clean))


def verdict_of(named: NamingResult) -> str:
    """One of VERDICTS, from the durations alone."""
    if len(named.late) < _FEWEST:
        return "not-judged"
    sigma, tails = floor_of(named).value, _tails(named)
    off = left_over(named)[_in_time(named)]
    left, raw = _beside(off, tails), rms(named.clean.residual)
    pattern = named.remains.structured and beyond_digits(off, named.clean, named.noise.order)
    if not named.fit.model.parts and not named.late.any():
        grows = _growth(off, named.clean.simulated[_in_time(named)]) > _GROWS
        return "unexplained" if pattern or grows or left > AGREES * sigma else "no-mismatch"
    unseen = (named.clean.measured - named.selection.predicted)[_in_time(named)]  # by the whole search
    if _taken_away(named) < 1.0:
        return "unexplained"
    if max(left, _beside(unseen, tails)) <= EXPLAINED * sigma and not (
        pattern and left**2 > evidence.LITTLE * raw**2
    ):
        return "explained"
    return "partly-explained"


def _taken_away(named: NamingResult) -> float:
    """[1] How many times larger the unseen moves' mean square is without the names, over what is asked of an
    explanation; 0 where it hardly differs.

    Asked is half of the error beyond the noise. Where nothing but what the names leave tells the noise, none is beyond
    it: half of the error of the moves in which they act, or more of all moves' mean square than they leave.
    """
    if not named.fit.model.parts:
        return math.inf
    raw, floor = named.clean.residual, floor_of(named)
    unseen = named.clean.measured - named.selection.predicted
    if floor.source != REMAINS:
        return evidence.clipped_cut(raw, unseen, floor.value) / _HALVED
    acts = np.abs(raw - unseen) > evidence.ACTS * floor.value
    there = evidence.clipped_cut(raw[acts], unseen[acts], 0.0) if acts.sum() >= _FEWEST else 0.0
    return max(there / _HALVED, evidence.clipped_cut(raw, unseen, 0.0) / _MORE)


def _tails(named: NamingResult) -> float:
    """[s²] of the mean square of what the names leave, what is a scatter's; none of a pattern."""
    return 0.0 if named.remains.structured else tails_of(left_over(named), named.clean)


def _beside(off: Floats, tails: float) -> float:
    """[s] root mean square of `off` (n,) [s] without the heavy tails of a scatter, `tails` [s²], which are not in the
    noise floor either."""
    return math.sqrt(max(float(np.mean(off**2)) - tails, 0.0))


def joined(one: str, other: str, found: bool) -> str:
    """The verdict of durations and logs together."""
    judged = {one, other} - {"not-judged"}
    if not judged:
        return "not-judged"
    if found:
        return "explained" if judged <= {"explained", "no-mismatch"} else "partly-explained"
    return "unexplained" if "unexplained" in judged else "no-mismatch"


def _growth(off: Floats, seconds: Floats) -> float:
    """[s/s] by how much the size of a difference, `off` (n,) [s], grows with the moves' `seconds` (n,), by least
    squares: a recorder scatters as much in short moves as in long ones, and robots repeat to within thousandths."""
    size = np.abs(off - np.median(off))
    size = np.minimum(size, _FAR * 1.4826 * float(np.median(size)))
    long = seconds - seconds.mean()
    return float(size @ long) / max(float(long @ long), 1e-12)


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


# --- Findings ---
# What is believed, as findings: sentences, parameters, contributions, evidence, what could stand in their place.

_BESIDE = 2  # names that are tried beside a plainer form
_RIVALS = 30.0  # in BIC: worse ones are not worth a word


class ReportedFindings(NamedTuple):
    """Findings, groups of names that cannot be told apart, and for each such group its models."""

    findings: list[Finding]
    alike: list[tuple[str, ...]]
    rivals: list[list[DurationModel]]  # one alone where no move could tell more


class _Rival(NamedTuple):
    alternative: Alternative
    model: DurationModel


def findings_of(named: NamingResult, case: MeasuredMoves, floor: float) -> ReportedFindings:
    """A finding per term (axes of one limit together). `floor` [s]: the noise."""
    best = named.fit
    shares = best.model.contributions(case)
    by_term: dict[str, list[int]] = {}
    for k, part in enumerate(best.model.parts):
        by_term.setdefault(part.term.name, []).append(k)
    rivals_of = {name: _rivals(best, parts, named) for name, parts in by_term.items()}
    as_good = [r.model for rivals in rivals_of.values() for r in rivals if r.alternative.delta_bic < ALIKE]
    parameters = parameters_with_intervals(best, named.clean, named.noise, as_good, floor)
    told = ReportedFindings([], [], [])
    for term, parts in by_term.items():
        rivals = rivals_of[term]
        beside = _beside_a_plainer_form(best, parts[0], named) if len(parts) == 1 else []
        beside += _as_waits(best, parts[0], named) if len(parts) == 1 else []
        others = [*(r.alternative for r in rivals), *beside]
        told.findings.append(_finding(term, parts, named, case, parameters, shares, others))
        alike = [r for r in rivals if r.alternative.delta_bic < ALIKE]
        if alike:
            told.alike.append((term, *(r.alternative.term for r in alike)))
            told.rivals.append([best.model, *(r.model for r in alike)])
        for other in beside:
            told.alike.append((term, other.term))
            told.rivals.append([best.model])  # no move tells them apart
    waits = _waiting(named, case)
    return told if waits is None else told._replace(findings=[*told.findings, waits])


def _rivals(best: ModelFit, parts: list[int], named: NamingResult) -> list[_Rival]:
    if len(parts) > 1:
        return []
    used, rivals = set(best.names), list[_Rival]()
    for other in swaps(
        best, parts[0], named.shelf, named.clean, named.noise, best.bic + _RIVALS + PRICE * len(best.names)
    ):
        name = next((p.term.name for p in other.model.parts if p.term.name not in used), None)
        worse = max(other.bic - best.bic, 0.0)
        if name is not None and worse < _RIVALS:
            rivals.append(_Rival(Alternative(name, worse), other.model))
    return rivals


def _beside_a_plainer_form(best: ModelFit, index: int, named: NamingResult) -> list[Alternative]:
    """The names that explain as much beside a form of the term with fewer numbers: an inertia that is right at one
    reach is the same law as one from the first axis with another acceleration."""
    part, rest = best.model.parts[index], best.model.without(index).parts
    shelf, case, noise = named.shelf, named.clean, named.noise
    found, seen = dict[str, float](), set[tuple[str, float]]()
    for plainer in shelf.parts:
        if plainer.label != part.label or len(plainer.values) >= len(part.values):
            continue
        bare = fit(DurationModel((*rest, plainer._replace(condition=part.condition))), case, noise, 8)
        there = (plainer.form.key, round(bare.bic))
        if there in seen:
            continue  # another guess has led to the same fit
        seen.add(there)
        for other in additions(shelf, bare, case, noise, _BESIDE):
            both = fit(DurationModel((*bare.model.parts, other)), case, noise, 20, below=best.bic + ALIKE)
            worse = min(max(both.bic - best.bic, 0.0), found.get(other.term.name, math.inf))
            if worse < ALIKE and other.term.name not in best.names:
                found[other.term.name] = worse
    return [Alternative(term, worse, beside=True) for term, worse in sorted(found.items())]


def _as_waits(best: ModelFit, index: int, named: NamingResult) -> list[Alternative]:
    """Waits, each programmed move for a time of its own, where that explains the few moves that are slower under a
    condition as well. It costs a number for each, and the choice of these from all that there are."""
    case, noise = named.clean, named.noise
    if best.model.parts[index].condition is None or len(case.repeats) != len(case):
        return []
    bare = fit(best.model.without(index), case, noise, 15)
    programmed = np.unique(case.repeats[evidence.acts(best, (index,), case)])
    left = case.measured - bare.model.seconds(case)
    for one in programmed.tolist():
        some = case.repeats == one
        if (mean := float(left[some].mean())) <= 0:
            return []
        left[some] -= mean
    count, few = len(np.unique(case.repeats)), len(programmed)
    choice = math.lgamma(count + 1) - math.lgamma(few + 1) - math.lgamma(count - few + 1)
    loss, _ = loss_of(whiten(left, noise, case), noise.least)
    bic = 2.0 * loss + penalty(bare.model.parts, case) + few * math.log(len(case)) + 2.0 * choice
    worse = max(bic - best.bic, 0.0)
    return [Alternative("external-wait", worse)] if worse < ALIKE else []


def _finding(
    name: str,
    parts: list[int],
    named: NamingResult,
    case: MeasuredMoves,
    parameters: list[dict[str, FittedParameter]],
    shares: tuple[Floats, ...],
    rivals: list[Alternative],
) -> Finding:
    best = named.fit
    members = [best.model.parts[k] for k in parts]
    share = np.sum([shares[k] for k in parts], axis=0)
    acts = np.abs(share) > evidence.ACTS * best.scale
    rest = best
    for k in sorted(parts, reverse=True):
        rest = ModelFit(rest.model.without(k), rest.loss, rest.scale, rest.bic)
    bare = fit(rest.model, named.clean, named.noise, 20)
    gains = [named.gains[k] for k in parts]
    return Finding(
        term=name,
        says=_says([(best.model.parts[k], parameters[k]) for k in parts], case),
        equation=members[0].form.equation,
        parameters={key: value for k in parts for key, value in parameters[k].items()},
        moves=tuple(case.move[acts].tolist()),
        contribution=dict(zip(case.move.tolist(), share.tolist(), strict=True)),
        evidence=Evidence(
            bare.bic - best.bic,
            _likelihood_ratio(bare, best),
            max(g.before for g in gains),
            min(g.after for g in gains),
        ),
        alternatives=tuple(rivals),
        condition=_condition(members),
        nulls=_nulls(members),
    )


def _condition(members: list[ModelPart]) -> str | None:
    """Where any of them acts; None: everywhere."""
    told = [part.condition for part in members if part.condition is not None]
    return " or ".join(dict.fromkeys(map(str, told))) if len(told) == len(members) else None


def _says(parts: list[tuple[ModelPart, dict[str, FittedParameter]]], case: MeasuredMoves) -> str:
    """A clause per part, that of all axes before those of one; what all begin with is said once."""
    parts = sorted(parts, key=lambda one: one[0].form.axis)
    where = [f"where {part.condition}: " if part.condition is not None else "" for part, _ in parts]
    clauses = [
        place + _clause(part, fitted, case) for place, (part, fitted) in zip(where, parts, strict=True)
    ]
    head = "".join(clauses[0].rpartition(": ")[:2])
    all_axes = parts[0][0].form.axis < 0
    rest = [clause.removeprefix(head) for clause in clauses[1:]]
    besides = ["beside that, " * (all_axes and part.form.axis >= 0) for part, _ in parts[1:]]
    return "; ".join([clauses[0], *map("".join, zip(besides, rest, strict=True))])


def _clause(part: ModelPart, fitted: dict[str, FittedParameter], case: MeasuredMoves) -> str:
    """With the numbers where their intervals are narrow, else with the ends of these."""
    values, told = part.values, [fitted[p.name] for p in part.form.parameters]
    ends, open_ends = np.stack([values, values]), [False, False]
    for k, (parameter, one) in enumerate(zip(part.form.parameters, told, strict=True)):
        if not one.wide(parameter.null):
            continue
        ends[:, k] = np.clip([one.low, one.high], parameter.low, parameter.high)
        if k == 0:  # the size; the others say how it changes
            open_ends = [one.low < parameter.low, one.high > parameter.high]
    best, low, high = (part.term.says(part.form, v, case) for v in (values, *ends))
    return phrasing.ranged(best, low, high, *open_ends)


def _nulls(members: list[ModelPart]) -> dict[str, float]:
    """By parameter the value at which nothing happens; {} where the first one, which says how much, has none. A
    cycle has none: no interval comes near a cycle of nothing."""
    sized = [p for p in members if not math.isnan(_null(p.form.parameters[0])) and p.term.name != LATTICE]
    firsts = {p.form.parameters[0].name: _null(p.form.parameters[0]) for p in sized}
    return firsts | {q.name: q.null for p in sized for q in p.form.parameters[1:] if math.isfinite(q.null)}


def _null(size: TermParameter) -> float:
    """Of a limit, which does nothing at infinity, the highest that is sought: no move reaches more."""
    return size.high if size.null == math.inf else size.null


def _likelihood_ratio(bare: ModelFit, full: ModelFit) -> float:
    """Tail of chi square with one degree per parameter, times the number of names that were tried."""
    freedom = sum(len(p.form.parameters) for p in full.model.parts) - sum(
        len(p.form.parameters) for p in bare.model.parts
    )
    x = max(2.0 * (bare.loss - full.loss), 0.0)
    k = 2.0 / (9.0 * max(freedom, 1))
    tail = 0.5 * math.erfc((((x / max(freedom, 1)) ** (1 / 3)) - (1.0 - k)) / math.sqrt(2.0 * k))
    return min(1.0, tail * len(move_terms()))


def _waiting(named: NamingResult, case: MeasuredMoves) -> Finding | None:
    """The late moves as a finding."""
    late = named.waiting
    if not late.any():
        return None
    lost = np.where(late, case.measured - named.fit.model.seconds(case), 0.0)
    waits = lost[late]
    sigma = spread(named.clean.measured - named.fit.model.seconds(named.clean), named.noise.least)
    count = int(late.sum())
    places = {f"{case.job[i]}:{case.line[i]}" for i in np.nonzero(late)[0].tolist() if case.line[i]}
    where = f", all at {next(iter(places))}" if len(places) == 1 and count > 1 else ""
    says = (
        f"{count} of {len(case)} moves are late by {waits.min():.3f} to {waits.max():.3f} s "
        f"for reasons outside the arm{where}"
        if count > 1
        else f"move {int(case.move[late][0])} is late by {waits[0]:.3f} s for a reason outside the arm"
    )
    error = 1.96 * float(waits.std(ddof=1)) / math.sqrt(count) if count > 1 else 1.96 * sigma
    mean = float(waits.mean())
    gain = float(np.sum((waits / sigma) ** 2)) - 2.0 * count * math.log(len(case))
    unseen = _unseen(named)
    off = np.concatenate([unseen, (case.measured - named.fit.model.seconds(case))[late]])
    return Finding(
        "external-wait",
        says,
        load_term("external-wait").equation,  # type: ignore[attr-defined]
        {"mean": FittedParameter(mean, "s", mean - error, mean + error)},
        tuple(case.move[late].tolist()),
        dict(zip(case.move.tolist(), lost.tolist(), strict=True)),
        Evidence(gain, LEVEL * min(1.0, math.exp(-0.5 * max(gain, 0.0))), rms(off), rms(unseen)),
    )
