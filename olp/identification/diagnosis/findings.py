"""Named terms as findings: sentences, parameters, contributions, evidence, and which other terms explain as much."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis import evidence, phrasing
from olp.identification.diagnosis.fitting import (
    LATTICE,
    ModelFit,
    evaluate,
    fit,
    loss_of,
    penalty,
    rounded_bic,
    whiten,
)
from olp.identification.diagnosis.folds import rms
from olp.identification.diagnosis.intervals import ALIKE, does_something, parameters_with_intervals
from olp.identification.diagnosis.model import Condition, DurationModel, ModelPart, Statement
from olp.identification.diagnosis.naming import NamingResult
from olp.identification.diagnosis.residuals import LEVEL
from olp.identification.diagnosis.result import (
    Alternative,
    Evidence,
    Finding,
    FittedParameter,
)
from olp.identification.diagnosis.search import PRICE, additions, move_terms, swaps
from olp.identification.diagnosis.verdict import unseen_errors
from olp.identification.diagnosis.waits import price_of_waits, spread
from olp.timing.physics import TermParameter, load_term
from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]

_ACCELERATION, _CLAMP = "acceleration", "speed-clamp"
_KIND = 3  # digits of logarithms of ways and speeds of moves of one kind
_NOTHING = 1e-9  # [m, m/s] that are none
_FEW_STEPS = 8  # of a fit that begins at what is the same law
_BESIDE = 2  # names that are tried beside a plainer form
_RIVALS = 30.0  # in BIC: worse ones are not worth a word
_TIMES = 40  # per cycle, of a time per move
_COINCIDENCE = 0.05  # of these times would do: fewer are one by chance too seldom


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
        beside = beside or (_beside_another_acceleration(best, parts[0], named) if len(parts) == 1 else [])
        beside += _as_waits(best, parts[0], named) if len(parts) == 1 else []
        beside += _as_half_a_cycle(best, parts[0], named) if len(parts) == 1 else []
        beside += _in_quick_moves(best, parts[0], named) if len(parts) == 1 else []
        others = [*(r.alternative for r in rivals), *beside]
        told.findings.append(_finding(term, parts, named, case, parameters, shares, others, floor))
        alike = [r for r in rivals if r.alternative.delta_bic < ALIKE]
        if alike:
            told.alike.append((term, *(r.alternative.term for r in alike)))
            told.rivals.append([best.model, *(r.model for r in alike)])
        for other in beside:
            if (term, other.term) not in told.alike:
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


def _beside_another_acceleration(best: ModelFit, index: int, named: NamingResult) -> list[Alternative]:
    """An acceleration, where a number of the form stands for one: an inertia of which the simulation is right at one
    reach is, from the first axis, the same inertia beside another acceleration, with as many numbers. No move tells
    which of both somebody had in mind, but those that only one of the two acts in."""
    part, case, noise = best.model.parts[index], named.clean, named.noise
    told = part.term.beside_acceleration(part.form, part.values, case)
    if told is None or _ACCELERATION in best.names:
        return []
    values, factor = told
    rest = best.model.without(index).parts
    alone = (*rest, part._replace(values=values))
    begins = sum(len(one.values) for one in alone) - 1  # where the simulation is right: it stays at the axis
    whole = (one for one in named.shelf.parts if one.term.name == _ACCELERATION and one.form.axis < 0)
    for other in itertools.islice(whole, 1):
        scaled = other._replace(
            values=factor * np.array([other.form.parameters[0].null]), condition=part.condition
        )
        both = fit(DurationModel((*alone, scaled)), case, noise, _FEW_STEPS, held=begins)
        without = fit(DurationModel(both.model.parts[:-1]), case, noise, _FEW_STEPS, held=begins)
        worse = 2.0 * max(both.loss - best.loss, 0.0)  # a number less of the one, and one of the other
        if worse < ALIKE < 2.0 * (without.loss - both.loss):
            return [Alternative(_ACCELERATION, worse, beside=True)]
    return []


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
    loss, _ = loss_of(whiten(left, noise, case), noise.least)
    waits = price_of_waits(len(programmed), len(np.unique(case.repeats)), len(case))
    bic = 2.0 * loss + penalty(bare.model.parts, case) + waits
    worse = max(bic - best.bic, 0.0)
    return [Alternative("external-wait", worse)] if worse < ALIKE else []


def _as_half_a_cycle(best: ModelFit, index: int, named: NamingResult) -> list[Alternative]:
    """A time per move, where the clock shows nothing finer than the cycle: a time of half a cycle that is rounded to
    the nearest multiple is a time rounded up. Only that it should happen to be just that long tells them apart, which
    is unlikely where few times would do."""
    case, noise = named.clean, named.noise
    if best.model.parts[index].term.name != LATTICE or not case.polled or "dispatch" in best.names:
        return []
    rest = best.model.without(index).parts
    alike = list[Alternative]()
    for one in {part.form.key: part for part in named.shelf.parts if part.term.name == "dispatch"}.values():
        times = (np.arange(_TIMES) + 0.5) / _TIMES * case.polled
        parts = [one._replace(values=np.array([time])) for time in times.tolist()]
        told = np.array(
            [rounded_bic(evaluate(DurationModel((*rest, part)), case, noise), case, noise) for part in parts]
        )
        worse = max(float(told.min()) - rounded_bic(best, case, noise), 0.0)
        if worse < ALIKE and np.mean(told < told.min() + ALIKE) >= _COINCIDENCE:
            alike.append(Alternative("dispatch", worse))
    return alike[:1]


def _in_quick_moves(best: ModelFit, index: int, named: NamingResult) -> list[Alternative]:
    """What else would act in the moves that are quicker than a clamp, where these are all of one length and speed: a
    clamp takes one time of each then, as whatever acts in quick moves does, and is as much a statement about speeds."""
    part, case, noise = best.model.parts[index], named.clean, named.noise
    if part.term.name != _CLAMP or part.condition is not None:
        return []
    acts = evidence.acts(best, (index,), case)
    kinds = np.round(np.log(np.maximum([case.base.way, case.base.speed], _NOTHING))[:, acts], _KIND)
    slower = case.base.speed[~acts & case.moving & ~case.joint]
    quick = float(case.base.speed[acts].min(initial=np.inf))
    slower = slower[slower < quick]
    if len(np.unique(kinds, axis=1).T) != 1 or case.joint[acts].any() or not len(slower):
        return []
    condition = Condition((Statement("speed", above=0.5 * (quick + float(slower.max()))),))
    if (condition.mask(case) != acts).any():
        return []
    rest, found = best.model.without(index).parts, dict[str, float]()
    for one in named.shelf.parts:
        if one.term.name in best.names or len(one.values) > 1 or not one.conditionable:
            continue
        model = DurationModel((*rest, one._replace(condition=condition)))
        worse = 2.0 * max(fit(model, case, noise, _FEW_STEPS).loss - best.loss, 0.0)
        if worse < min(ALIKE, found.get(one.term.name, math.inf)):
            found[one.term.name] = worse
    return [Alternative(term, worse) for term, worse in sorted(found.items())]


def _finding(
    name: str,
    parts: list[int],
    named: NamingResult,
    case: MeasuredMoves,
    parameters: list[dict[str, FittedParameter]],
    shares: tuple[Floats, ...],
    rivals: list[Alternative],
    floor: float,
) -> Finding:
    best = named.fit
    members = [best.model.parts[k] for k in parts]
    share = np.sum([shares[k] for k in parts], axis=0)
    acts = np.abs(share) > evidence.ACTS * best.scale
    rest = best
    for k in sorted(parts, reverse=True):
        rest = ModelFit(rest.model.without(k), rest.loss, rest.scale, rest.bic)
    bare = fit(rest.model, named.clean, named.noise, 20)
    sure = does_something(best, bare, parts, named.clean, named.noise, floor)
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
        nulls={} if sure else _nulls(members),
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
    return {q.name: _null(q) for p in sized for q in p.form.parameters if not math.isnan(_null(q))}


def _null(parameter: TermParameter) -> float:
    """Of a limit, which does nothing at infinity, the highest that is sought: no move reaches more."""
    return parameter.high if parameter.null == math.inf else parameter.null


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
    unseen = unseen_errors(named)
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
