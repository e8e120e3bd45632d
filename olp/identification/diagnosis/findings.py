"""What is believed, as findings: sentences, parameters, contributions, evidence, what could stand in their place."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.errors import rms
from olp.identification.diagnosis.fitting import ModelFit, fit
from olp.identification.diagnosis.intervals import parameters_with_intervals
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.diagnosis.naming import NamingResult
from olp.identification.diagnosis.residuals import LEVEL
from olp.identification.diagnosis.result import Alternative, Evidence, Finding, FittedParameter
from olp.identification.diagnosis.search import move_terms, swaps
from olp.identification.diagnosis.waits import spread
from olp.identification.diagnosis.ways import ALIKE
from olp.timing.physics import load_term
from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]

_LATTICE = "cycle-quantisation"  # a cycle of nothing is no value that an interval comes near
_RIVALS = 30.0  # in BIC: worse ones are not worth a word
_ACTS = 0.5  # of the scatter: a term acts in moves to which it adds more


class ReportedFindings(NamedTuple):
    """Findings, groups of names that cannot be told apart, and for each such group its models."""

    findings: list[Finding]
    alike: list[tuple[str, ...]]
    rivals: list[list[DurationModel]]


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
    for name, parts in by_term.items():
        rivals = rivals_of[name]
        told.findings.append(
            _finding(name, parts, named, case, parameters, shares, [r.alternative for r in rivals])
        )
        alike = [r for r in rivals if r.alternative.delta_bic < ALIKE]
        if alike:
            told.alike.append((name, *(r.alternative.term for r in alike)))
            told.rivals.append([best.model, *(r.model for r in alike)])
    waits = _waiting(named, case)
    return told if waits is None else told._replace(findings=[*told.findings, waits])


def _rivals(best: ModelFit, parts: list[int], named: NamingResult) -> list[_Rival]:
    if len(parts) > 1:
        return []
    used, rivals = set(best.names), list[_Rival]()
    for other in swaps(best, parts[0], named.shelf, named.clean, named.noise):
        name = next((p.term.name for p in other.model.parts if p.term.name not in used), None)
        worse = max(other.bic - best.bic, 0.0)
        if name is not None and worse < _RIVALS:
            rivals.append(_Rival(Alternative(name, worse), other.model))
    return rivals


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
    acts = np.abs(share) > _ACTS * best.scale
    rest = best
    for k in sorted(parts, reverse=True):
        rest = ModelFit(rest.model.without(k), rest.loss, rest.scale, rest.bic)
    bare = fit(rest.model, named.clean, named.noise, 20)
    gains = [named.gains[k] for k in parts]
    conditions = [str(p.condition) for p in members if p.condition is not None]
    where = f"where {conditions[0]}: " if conditions else ""
    return Finding(
        term=name,
        says=where + "; ".join(p.term.says(p.form, p.values, case) for p in members),
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
        condition=conditions[0] if conditions else None,
        nulls=_nulls(members),
    )


def _nulls(members: list[ModelPart]) -> dict[str, float]:
    """By parameter the value at which nothing happens; {} where the first one, which says how much, has none."""
    sized = [p for p in members if math.isfinite(p.form.parameters[0].null) and p.term.name != _LATTICE]
    return {q.name: q.null for p in sized for q in p.form.parameters if math.isfinite(q.null)}


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
    return Finding(
        "external-wait",
        says,
        load_term("external-wait").equation,  # type: ignore[attr-defined]
        {"mean": FittedParameter(mean, "s", mean - error, mean + error)},
        tuple(case.move[late].tolist()),
        dict(zip(case.move.tolist(), lost.tolist(), strict=True)),
        Evidence(gain, LEVEL * min(1.0, math.exp(-0.5 * max(gain, 0.0))), rms(lost[late]), sigma),
    )
