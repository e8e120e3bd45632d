"""A recording that has logs and no moves: the diagnosis is what the logs tell."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from olp.identification.diagnosis.errors import rms
from olp.identification.diagnosis.result import (
    Diagnosis,
    Errors,
    Finding,
    Mismatch,
    NextExperiment,
    Remainder,
)
from olp.timing.physics._case import MeasuredMoves
from olp.timing.physics._motion import Motion

if TYPE_CHECKING:
    from olp.identification.diagnosis.logs import LogDiagnosis
    from olp.identification.diagnosis.logs.result import AxisResidual

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
