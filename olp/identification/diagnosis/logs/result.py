"""What time series told, as data. SI: angles [rad], lengths [m], torques [Nm], forces [N], currents [A]."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from olp.identification.diagnosis.result import Finding, MoveResidual


class ExtraDwell(NamedTuple):
    """At `time` [s] of the log it stands still `extra` [s] longer than the simulation (negative: shorter)."""

    time: float
    extra: float


class ClockFit(NamedTuple):
    """How one clock runs against another. `offset` [s] what `of` reads when `against` reads 0; `rate` [1].

    nan where it was not asked: two channels of one log have no rate against each other.
    """

    of: str
    against: str
    offset: float
    offset_low: float
    offset_high: float
    rate: float
    rate_low: float
    rate_high: float
    offset_significant: bool
    rate_significant: bool


class AxisEvidence(NamedTuple):
    """Why one term is believed of one axis (from 1; 0: of all axes together), in the unit of the signal."""

    term: str
    axis: int
    signal: str  # position, torque, current, link encoder
    unit: str
    delta_bic: float  # how much worse the axis is explained without the term
    p_value: float  # of the gain on blocks that no fit saw, one-sided
    heldout_before: float  # RMS without the term on those blocks
    heldout_after: float  # RMS with it


class AxisResidual(NamedTuple):
    """What is left of one axis, RMS on blocks that no fit saw. `floor`: its noise, nan where nothing tells it.

    `pace`, `reach`, `late`: of positions; nan of all else.
    """

    axis: int  # from 1
    signal: str
    unit: str
    before: float
    after: float
    floor: float
    pace: float = math.nan  # RMS speed [unit/s] while it moves
    reach: float = math.nan  # from its least to its greatest position
    late: float = math.nan  # [s] behind its reference before anything is explained, by least squares


class LogCorrelate(NamedTuple):
    """What the rest of an axis goes together with."""

    axis: int  # from 1
    signal: str
    column: str
    statistic: float  # correlation of means over blocks of samples
    p_value: float


@dataclass(frozen=True, slots=True)
class LogDiagnosis:
    """`gaps`, `unpaired`: from, to [s] on the log's clock. `moves`: only of logs that number them.

    `residual` of a move is how late its axes are [s], its phase the one with the largest part of the difference.
    """

    verdict: str  # of olp.identification.diagnosis.result.VERDICTS
    findings: tuple[Finding, ...] = ()
    indistinguishable: tuple[tuple[str, ...], ...] = ()
    clocks: tuple[ClockFit, ...] = ()
    dropped: int = 0
    gaps: tuple[tuple[float, float], ...] = ()
    unpaired: tuple[tuple[float, float], ...] = ()
    dwell: tuple[ExtraDwell, ...] = ()
    axes: tuple[AxisResidual, ...] = ()
    evidence: tuple[AxisEvidence, ...] = ()
    moves: tuple[MoveResidual, ...] = ()
    correlates: tuple[LogCorrelate, ...] = ()
    next_experiment: str = ""
    notes: tuple[str, ...] = ()
    span: float = math.nan  # [s] from the first sample to the last

    def finding(self, term: str) -> Finding | None:
        return next((f for f in self.findings if f.term == term), None)

    def to_json(self) -> dict[str, Any]:
        """What `olp diagnose --json` puts under `log`; findings stand with those of the moves."""
        return {
            "verdict": self.verdict,
            "clocks": [_numbers(c._asdict()) for c in self.clocks],
            "dropped_samples": self.dropped,
            "gaps_s": [list(g) for g in self.gaps],
            "unpaired_s": [list(u) for u in self.unpaired],
            "dwell": [{"time_s": d.time, "extra_s": d.extra} for d in self.dwell],
            "axes": [_numbers(a._asdict()) for a in self.axes],
            "evidence": [_numbers(e._asdict()) for e in self.evidence],
            "correlates": [_numbers(c._asdict()) for c in self.correlates],
            "next_experiment": self.next_experiment,
            "notes": list(self.notes),
        }


def _numbers(values: dict[str, Any]) -> dict[str, Any]:
    """Numbers that are not known are null."""
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in values.items()}
