"""The answer of a diagnosis as data; `to_json` writes it as schema `olp.diagnosis/1`.

All SI. `move` is the number that the recording's own column `move` gives a move.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

SCHEMA = "olp.diagnosis/1"
VERDICTS = ("explained", "partly-explained", "unexplained", "no-mismatch", "not-judged")
PHASES = ("accelerate", "cruise", "decelerate", "settle", "corner", "whole")


class Errors(NamedTuple):
    """How far predicted durations are from measured ones. [s], [%], [%]; nan where nothing was compared."""

    rmse: float
    mape: float
    worst: float


_NOT_COMPARED = Errors(math.nan, math.nan, math.nan)


class FittedParameter(NamedTuple):
    """One parameter of a term, with its 95 % confidence interval in `unit`."""

    value: float
    unit: str
    low: float
    high: float
    at_bound: bool = False
    identified: bool = True  # False: the data hold the parameter no better than its bounds do

    def wide(self, null: float) -> bool:
        """Whether the interval is wider than the value is away from the `null` at which nothing happens, or from 0."""
        size = abs(self.value - null) if math.isfinite(null) else abs(self.value)
        return not self.identified or self.high - self.low > size


class Alternative(NamedTuple):
    """A term that could stand for a finding, or beside a plainer form of it, and how much worse the whole then is
    (Δ BIC, 0 or more)."""

    term: str
    delta_bic: float
    beside: bool = False


class Evidence(NamedTuple):
    """Why a finding is believed. `delta_bic`: how much the others are worse without it. [s] on groups never seen."""

    delta_bic: float
    p_value: float
    heldout_before: float  # RMSE of the others without this term
    heldout_after: float  # RMSE with it


@dataclass(frozen=True, slots=True)
class Finding:
    """One named effect. `moves`: those in which it acts beyond the noise; `contribution` [s] of every move."""

    term: str
    says: str  # one sentence with the number
    equation: str  # LaTeX
    parameters: Mapping[str, FittedParameter]
    moves: tuple[int, ...]
    contribution: Mapping[int, float]
    evidence: Evidence
    alternatives: tuple[Alternative, ...] = ()
    condition: str | None = None  # in which moves it acts, "y > 150 mm and length > 200 mm"; None: everywhere
    nulls: Mapping[str, float] = field(
        default_factory=dict
    )  # of the parameters that have one: nothing happens there; {} where the moves object to all of them at once

    @property
    def holds_null(self) -> bool:
        """Whether all intervals hold the values at which nothing happens."""
        known = [self.parameters[name] for name in self.nulls]
        held = [p.low <= null <= p.high for p, null in zip(known, self.nulls.values(), strict=True)]
        return bool(held) and all(held)


class MoveResidual(NamedTuple):
    """What the judged simulation misses in one move. [s]; measured less simulated."""

    move: int
    job: str | None
    line: int | None
    phase: str  # of PHASES
    residual: float
    significant: bool  # after correction for as many looks as there are moves


@dataclass(frozen=True, slots=True)
class Mismatch:
    bias: float  # [s] mean of measured less simulated
    errors: Errors
    moves: tuple[MoveResidual, ...]


class Correlate(NamedTuple):
    """A column that what remains goes together with. `statistic`: Spearman's rho, or sqrt of eta squared for groups."""

    column: str
    statistic: float
    p_value: float


@dataclass(frozen=True, slots=True)
class Remainder:
    """What no name explains. `correction`: an unnamed one, only where it held on groups that were never seen."""

    rmse: float  # [s]
    correlates: tuple[Correlate, ...] = ()
    correction: str = ""


class NextMove(NamedTuple):
    """One move of an experiment to come: points [m], angles [rad] as Rx, Ry, Rz, speed [m/s]."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    speed: float
    payload: float | None = None  # [kg]
    blend: float = 0.0  # [m]
    times: int = 1  # how often to run it
    why: str = ""


class NextTimer(NamedTuple):
    """A programmed wait of an experiment to come, in which the arm stands still."""

    duration: float  # [s]
    times: int = 1
    why: str = ""


@dataclass(frozen=True, slots=True)
class NextExperiment:
    why: str = ""
    moves: tuple[NextMove, ...] = ()
    timers: tuple[NextTimer, ...] = ()


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """Everything `olp diagnose` answers."""

    verdict: str
    moves: int
    held_out_by: str
    noise_floor: float  # [s]
    mismatch: Mismatch
    findings: tuple[Finding, ...] = ()
    indistinguishable: tuple[tuple[str, ...], ...] = ()
    next_experiment: NextExperiment = field(default_factory=NextExperiment)
    remainder: Remainder = field(default_factory=lambda: Remainder(0.0))
    before: Errors = _NOT_COMPARED
    heldout_before: Errors = _NOT_COMPARED
    heldout_after: Errors = _NOT_COMPARED
    placebo: float = math.nan  # share of shuffled searches that found a name
    notes: tuple[str, ...] = ()  # what was assumed, could not be paired, or would need more columns
    unpaired: tuple[str, ...] = ()
    log: Mapping[str, Any] | None = None  # what logs tell beside the findings, ready for JSON
    noise_from: str = ""  # what told the noise floor: repeats, what remains, neighbours, the clock's digits

    def to_json(self) -> dict[str, Any]:
        """The contract's object; numbers that are not known are null."""
        return {
            "schema": SCHEMA,
            "verdict": self.verdict,
            "data": {
                "moves": self.moves,
                "held_out_by": self.held_out_by,
                "noise_floor_s": _number(self.noise_floor),
                "noise_floor_from": self.noise_from,
            },
            "mismatch": _mismatch(self.mismatch),
            "findings": [_finding(finding) for finding in self.findings],
            "indistinguishable": [list(group) for group in self.indistinguishable],
            "next_experiment": _experiment(self.next_experiment),
            "unexplained": {
                "rmse_s": _number(self.remainder.rmse),
                "correlates": [
                    {"column": c.column, "statistic": _number(c.statistic), "p_value": _number(c.p_value)}
                    for c in self.remainder.correlates
                ],
                "correction": self.remainder.correction or None,
            },
            "fit": {
                "before": _errors(self.before),
                "heldout_before": _errors(self.heldout_before),
                "heldout_after": _errors(self.heldout_after),
            },
            "placebo_share": _number(self.placebo),
            "notes": list(self.notes),
            "unpaired": list(self.unpaired),
            "log": dict(self.log) if self.log is not None else None,
        }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _errors(errors: Errors) -> dict[str, float | None]:
    return {
        "rmse_s": _number(errors.rmse),
        "mape_pct": _number(errors.mape),
        "worst_pct": _number(errors.worst),
    }


def _mismatch(mismatch: Mismatch) -> dict[str, Any]:
    moves = [
        {
            "move": m.move,
            "job": m.job,
            "line": m.line,
            "phase": m.phase,
            "residual_s": _number(m.residual),
            "significant": bool(m.significant),
        }
        for m in mismatch.moves
    ]
    return {"bias_s": _number(mismatch.bias), **_errors(mismatch.errors), "moves": moves}


def _finding(finding: Finding) -> dict[str, Any]:
    acts = set(finding.moves)
    return {
        "term": finding.term,
        "says": finding.says,
        "equation": finding.equation,
        "parameters": {name: _parameter(p) for name, p in finding.parameters.items()},
        "moves": list(finding.moves),
        "contribution_s": {
            str(move): _number(value) for move, value in finding.contribution.items() if move in acts
        },
        "condition": finding.condition,
        "evidence": {
            "delta_bic": _number(finding.evidence.delta_bic),
            "p_value": _number(finding.evidence.p_value),
            "heldout_rmse_before_s": _number(finding.evidence.heldout_before),
            "heldout_rmse_after_s": _number(finding.evidence.heldout_after),
        },
        "alternatives": [
            {"term": a.term, "delta_bic": _number(a.delta_bic), "beside": a.beside}
            for a in finding.alternatives
        ],
    }


def _parameter(parameter: FittedParameter) -> dict[str, Any]:
    return {
        "value": _number(parameter.value),
        "unit": parameter.unit,
        "ci95": [_number(parameter.low), _number(parameter.high)],
        "at_bound": bool(parameter.at_bound),
        "identified": bool(parameter.identified),
    }


def _experiment(experiment: NextExperiment) -> dict[str, Any]:
    mm = 1000.0
    moves = [
        {
            "start_mm": [c * mm for c in m.start],
            "end_mm": [c * mm for c in m.end],
            "speed_mm_s": m.speed * mm,
            "payload_kg": m.payload,
            "blend_mm": m.blend * mm,
            "times": m.times,
            "why": m.why,
        }
        for m in experiment.moves
    ]
    timers = [{"duration_s": t.duration, "times": t.times, "why": t.why} for t in experiment.timers]
    return {"why": experiment.why, "moves": moves, **({"timers": timers} if timers else {})}
