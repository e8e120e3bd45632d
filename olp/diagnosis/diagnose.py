"""The whole diagnosis of a recording's durations: locate, name, model, prove, tell apart, or say no."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.diagnosis import confirm
from olp.diagnosis.case_making import case_of
from olp.diagnosis.fitting import Fit, Noise, fit
from olp.diagnosis.folds import Folds, folds_of
from olp.diagnosis.intervals import parameters_with_intervals
from olp.diagnosis.locate import mismatch_of
from olp.diagnosis.model import Model
from olp.diagnosis.remains import LEVEL, Remains, f_tail, remains_of
from olp.diagnosis.result import (
    Alternative,
    Diagnosis,
    Errors,
    Evidence,
    Finding,
    FittedParameter,
    Remainder,
)
from olp.diagnosis.search import WIDE, Shelf, move_terms, price, search, shelf_of, swaps
from olp.diagnosis.waits import late_moves, spread
from olp.physics._case import Case

if TYPE_CHECKING:
    from olp.recording import Recording
    from olp.recording.recording import NoiseFloor
    from olp.robot import Robot

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Labels = NDArray[np.int64]

_LEAST = 1e-5  # [s] no clock is finer than that
_ALIKE = 6.0  # in BIC: terms that are no worse than that are not told apart
_ACTS = 0.5  # of the scatter: a term acts in moves to which it adds more
_SMALL = 0.01  # of the variance that all names explain: less is no finding
_PLACEBOS = 4
_ENOUGH = 8  # degrees of freedom behind repeats, for them to judge a fit
_ROUNDS = 2  # of search and setting waits apart


class Named(NamedTuple):
    """What the search came to."""

    fit: Fit
    late: Mask  # (n,) of the whole case
    clean: Case  # the case without late moves
    noise: Noise
    shelf: Shelf
    folds: Folds  # of the clean case
    selection: confirm.Selection
    gains: tuple[confirm.Gain, ...]
    remains: Remains


class Outcome(NamedTuple):
    """A diagnosis and what a report draws beside it."""

    diagnosis: Diagnosis
    case: Case
    model: Model  # the findings as they act together; waits are not in it
    predicted: Floats  # (n,) [s] with the findings, waits included
    ladder: tuple[tuple[str, float, float], ...]  # name added, BIC, held-out RMSE [s]; the first is ""


def diagnose_recording(recording: Recording, robot: Robot | None = None) -> Outcome:
    """Everything that the moves of a recording tell; `robot` stands for the recording's. Raises OlpError N010."""
    if robot is not None:
        recording = replace(recording, robot=robot)
    making = case_of(recording)
    case, floor = making.case, recording.noise_floor()
    groups = {name: labels[making.rows] for name, labels in recording.groups().items()}
    folds = folds_of(recording, making.rows)
    named = _name(case, _noise(floor), folds, groups)
    return _answer(recording, case, floor, named, groups, making.notes)


def _noise(floor: NoiseFloor) -> Noise:
    resolution = np.nan_to_num(floor.resolution) / math.sqrt(12.0)
    return Noise(max(float(resolution), _LEAST))


# --- name -------------------------------------------------------------------------------------------------------------


def _name(case: Case, noise: Noise, folds: Folds, groups: dict[str, Labels]) -> Named:
    """Search, set waits apart, search again, and drop what does not hold on moves that were not fitted."""
    late = np.zeros(len(case), dtype=bool)
    for last in (False,) * (_ROUNDS - 1) + (True,):
        clean = case.take(np.nonzero(~late)[0].astype(np.int64))
        shelf = shelf_of(clean, move_terms())
        best = search(clean, noise, shelf, WIDE)[0]
        noise = noise._replace(order=_order(best, clean))
        if noise.order:
            best = search(clean, noise, shelf, WIDE)[0]
        again = late_moves(best, case, noise.least)
        if last or np.array_equal(again, late):
            break
        late = again
    clean_folds = Folds(folds.by, folds.labels[~late])
    selection = confirm.selection(clean, noise, clean_folds)
    best, gains = _confirmed(fit(best.model, clean, noise, 30), clean, noise, clean_folds, selection)
    left = clean.measured - best.model.seconds(clean)
    remains = remains_of(left, clean, {name: labels[~late] for name, labels in groups.items()})
    return Named(best, late, clean, noise, shelf, clean_folds, selection, gains, remains)


def _order(best: Fit, clean: Case) -> float:
    """Correlation between neighbours in what the best set leaves; a whitened search is fairer then."""
    left = clean.measured - best.model.seconds(clean)
    order = remains_of(left, clean, {}).order
    return order if abs(order) > 0.1 else 0.0


def _confirmed(
    best: Fit, case: Case, noise: Noise, folds: Folds, selection: confirm.Selection
) -> tuple[Fit, tuple[confirm.Gain, ...]]:
    """The parts that held-out moves confirm, the weakest removed one at a time."""
    while best.model.parts:
        gains = [confirm.gain_of(best, k, case, noise, folds) for k in range(len(best.model.parts))]
        sizes = [float(np.mean(c**2)) for c in best.model.contributions(case)]
        weak = [
            k
            for k, gain in enumerate(gains)
            if not gain.holds or sizes[k] < _SMALL * sum(sizes) or _seldom(best, k, selection)
        ]
        if not weak:
            return best, tuple(gains)
        worst = min(weak, key=lambda k: gains[k].loglik)
        best = fit(best.model.without(worst), case, noise, 30)
    return best, ()


def _seldom(best: Fit, index: int, selection: confirm.Selection) -> bool:
    """Whether most searches inside the folds chose neither the term nor one that is known to look like it."""
    term = best.model.parts[index].term
    like = {term.name, *term.confusable}
    others = {part.term.name for k, part in enumerate(best.model.parts) if k != index}
    votes = max((selection.chosen[name] for name in like - others), default=0)
    return 2 * votes < selection.folds


# --- answer -----------------------------------------------------------------------------------------------------------


def _answer(
    recording: Recording,
    case: Case,
    floor: NoiseFloor,
    named: Named,
    groups: dict[str, Labels],
    notes: tuple[str, ...],
) -> Outcome:
    best, clean = named.fit, named.clean
    findings, alike = _findings(named, case)
    waits = _waiting(named, case)
    if waits is not None:
        findings = [*findings, waits]
    predicted = best.model.seconds(case)
    predicted[named.late] = case.measured[named.late] if waits is not None else predicted[named.late]
    sigma = _floor(floor, named)
    verdict = _verdict(case, named, floor, bool(findings))
    if verdict in ("unexplained", "no-mismatch"):
        notes = (*notes, *(f"not named for want of evidence: {f.says}" for f in findings))
        findings, alike = [], []
    mismatch = mismatch_of(case, sigma, best.model if findings else Model(), named.late)
    raw, held = clean.residual, clean.measured - named.selection.predicted
    diagnosis = Diagnosis(
        verdict=verdict,
        moves=len(case),
        held_out_by=named.folds.by,
        noise_floor=sigma,
        mismatch=mismatch,
        findings=tuple(sorted(findings, key=lambda f: -f.evidence.delta_bic)),
        indistinguishable=tuple(alike),
        remainder=Remainder(_rms(case.measured - predicted), named.remains.correlates),
        before=errors_of(case.residual, case.measured),
        heldout_before=errors_of(raw, clean.measured),
        heldout_after=errors_of(held if findings else raw, clean.measured),
        placebo=confirm.placebo(best, clean, named.noise, _PLACEBOS),
        notes=notes,
    )
    return Outcome(diagnosis, case, best.model, predicted, _ladder(named))


def _findings(named: Named, case: Case) -> tuple[list[Finding], list[tuple[str, ...]]]:
    """A finding per term (axes of one limit together), and the groups that cannot be told apart."""
    best, clean = named.fit, named.clean
    parameters = parameters_with_intervals(best, clean, named.noise)
    shares = best.model.contributions(case)
    by_term: dict[str, list[int]] = {}
    for k, part in enumerate(best.model.parts):
        by_term.setdefault(part.term.name, []).append(k)
    findings, groups = list[Finding](), list[tuple[str, ...]]()
    for name, parts in by_term.items():
        rivals = _rivals(best, parts, named)
        findings.append(_finding(name, parts, named, case, parameters, shares, rivals))
        alike = tuple(r.term for r in rivals if r.delta_bic < _ALIKE)
        if alike:
            groups.append((name, *alike))
    return findings, groups


def _rivals(best: Fit, parts: list[int], named: Named) -> list[Alternative]:
    if len(parts) > 1:
        return []
    fits = swaps(best, parts[0], named.shelf, named.clean, named.noise)
    used = set(best.names)
    rivals = []
    for other in fits[:6]:
        new = next((p.term.name for p in other.model.parts if p.term.name not in used), None)
        if new is not None:
            rivals.append(Alternative(new, max(other.bic - best.bic, 0.0)))
    return [r for r in rivals if r.delta_bic < 5 * _ALIKE]


def _finding(
    name: str,
    parts: list[int],
    named: Named,
    case: Case,
    parameters: list[dict[str, FittedParameter]],
    shares: tuple[Floats, ...],
    rivals: list[Alternative],
) -> Finding:
    best = named.fit
    members = [best.model.parts[k] for k in parts]
    share = np.sum([shares[k] for k in parts], axis=0)
    acts = np.abs(share) > _ACTS * best.scale
    rest = best
    for k in sorted(parts, reverse=True):
        rest = Fit(rest.model.without(k), rest.loss, rest.scale, rest.bic)
    bare = fit(rest.model, named.clean, named.noise, 20)
    gains = [named.gains[k] for k in parts]
    return Finding(
        term=name,
        says="; ".join(p.term.says(p.form, p.values, case) for p in members),
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
    )


def _likelihood_ratio(bare: Fit, full: Fit) -> float:
    """Tail of chi square with one degree per parameter, times the number of names that were tried."""
    freedom = sum(len(p.form.parameters) for p in full.model.parts) - sum(
        len(p.form.parameters) for p in bare.model.parts
    )
    x = max(2.0 * (bare.loss - full.loss), 0.0)
    k = 2.0 / (9.0 * max(freedom, 1))
    tail = 0.5 * math.erfc((((x / max(freedom, 1)) ** (1 / 3)) - (1.0 - k)) / math.sqrt(2.0 * k))
    return min(1.0, tail * len(move_terms()))


def _waiting(named: Named, case: Case) -> Finding | None:
    """The late moves as a finding."""
    late = named.late
    if not late.any():
        return None
    from olp.physics import load_term

    lost = np.where(late, case.measured - named.fit.model.seconds(case), 0.0)
    waits = lost[late]
    sigma = spread(named.clean.measured - named.fit.model.seconds(named.clean), named.noise.least)
    count = int(late.sum())
    places = {f"{case.job[i]}:{case.line[i]}" for i in np.nonzero(late)[0].tolist() if case.line[i]}
    where = f", all at {next(iter(places))}" if len(places) == 1 and count > 1 else ""
    says = (
        f"{count} of {len(case)} moves are late by {waits.min():.3f} to {waits.max():.3f} s for reasons outside the arm{where}"
        if count > 1
        else f"move {int(case.move[late][0])} is late by {waits[0]:.3f} s for a reason outside the arm"
    )
    error = 1.96 * float(waits.std(ddof=1)) / math.sqrt(count) if count > 1 else 1.96 * sigma
    mean = float(waits.mean())
    gain = float(np.sum((waits / sigma) ** 2)) - 2.0 * count * math.log(len(case))
    return Finding(
        "external-wait",
        says,
        load_term("external-wait").equation,  # type: ignore[attr-defined]
        {"mean": FittedParameter(mean, "s", mean - error, mean + error)},
        tuple(case.move[late].tolist()),
        dict(zip(case.move.tolist(), lost.tolist(), strict=True)),
        Evidence(gain, LEVEL * min(1.0, math.exp(-0.5 * max(gain, 0.0))), _rms(lost[late]), sigma),
    )


# --- verdict ----------------------------------------------------------------------------------------------------------


def _floor(floor: NoiseFloor, named: Named) -> float:
    """[s] of repeats where there are enough, else what the clock's digits and the middle of what remains say."""
    left = named.clean.measured - named.fit.model.seconds(named.clean)
    if floor.freedom >= _ENOUGH:
        return float(floor.floor)
    known = np.nan_to_num(floor.resolution) / math.sqrt(12.0)
    return max(float(known), spread(left, named.noise.least))


def _verdict(case: Case, named: Named, floor: NoiseFloor, found: bool) -> str:
    structured = named.remains.structured
    above = _above_repeats(named, floor)
    if not found:
        return "unexplained" if structured or above else "no-mismatch"
    if not structured and not above:
        return "explained"
    clean, left = named.clean, named.clean.measured - named.fit.model.seconds(named.clean)
    raw = float(np.mean(clean.residual**2))
    kept = 1.0 - float(np.mean(left**2)) / raw if raw > 0 else 0.0
    if kept < 0.5 and not named.late.any():
        return "unexplained"
    return "partly-explained" if float(np.mean(left**2)) > 0.02 * raw else "explained"


def _above_repeats(named: Named, floor: NoiseFloor) -> bool:
    """Whether what remains is more than repeats of the same move scatter (F test)."""
    if floor.freedom < _ENOUGH or not floor.floor > 0:
        return False
    left = named.clean.measured - named.fit.model.seconds(named.clean)
    ratio = float(np.mean(left**2)) / floor.floor**2
    return ratio > 1.3 and f_tail(ratio, len(left), floor.freedom) < LEVEL


def _ladder(named: Named) -> tuple[tuple[str, float, float], ...]:
    """The findings added one at a time, the most telling first."""
    parts = list(named.fit.model.parts)
    case, noise = named.clean, named.noise
    steps = [("", fit(Model(), case, noise))]
    while parts:
        tried = [(p, fit(Model((*steps[-1][1].model.parts, p)), case, noise, 15)) for p in parts]
        part, best = min(tried, key=lambda t: price(t[1]))
        parts = [p for p in parts if p is not part]
        steps.append((part.term.name, best))
    return tuple((name, f.bic, _held_out(f, case, noise, named.folds)) for name, f in steps)


def _held_out(fitted: Fit, case: Case, noise: Noise, folds: Folds) -> float:
    left = np.zeros(len(case))
    for label in np.unique(folds.labels).tolist():
        seen = np.nonzero(folds.labels != label)[0].astype(np.int64)
        held = np.nonzero(folds.labels == label)[0].astype(np.int64)
        test = case.take(held)
        left[held] = test.measured - fit(fitted.model, case.take(seen), noise, 6).model.seconds(test)
    return _rms(left)


def errors_of(residual: Floats, measured: Floats) -> Errors:
    """RMSE [s], mean and worst absolute percentage."""
    if not len(residual):
        return Errors(math.nan, math.nan, math.nan)
    share = 100.0 * np.abs(residual) / np.where(measured > 0, measured, np.nan)
    return Errors(_rms(residual), float(np.nanmean(share)), float(np.nanmax(share)))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0
