"""Everything that clocks, axes and torques told becomes candidates; what blocks confirm becomes names."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from olp.identification.diagnosis.logs.effort import Efforts
from olp.identification.diagnosis.logs.encoders import PLAY, SKEW, TWIST, Encoders
from olp.identification.diagnosis.logs.findings import ConfirmedTerm
from olp.identification.diagnosis.logs.pairing import LEAST_RATE, Pairing
from olp.identification.diagnosis.logs.position import PositionResult, numbers
from olp.identification.diagnosis.logs.result import AxisEvidence, ClockFit
from olp.identification.diagnosis.logs.select import held_out
from olp.identification.diagnosis.logs.statistics import false_discovery
from olp.identification.diagnosis.logs.torque import MASSES
from olp.identification.diagnosis.result import FittedParameter

LEVEL = 0.05  # false discoveries among names
_LEAST_BIC = 10.0  # "very strong": R. E. Kass, A. E. Raftery, Bayes Factors, J. Am. Stat. Assoc. 90, 1995
SURE = 4.0  # standard errors of a clock
_NEAR = 1.0  # [s] an offset below which two clocks were meant to agree
_LEAST_OFFSET = 0.05  # sampling periods
_HELD = 0.5  # sampling periods: a loop that computes once per cycle is that early or late beside its lag, on average


class Candidate(NamedTuple):
    named: ConfirmedTerm
    held: bool = True  # False: not a discovery, whatever its p-value


def confirmed(candidates: list[Candidate], looks: int) -> list[ConfirmedTerm]:
    """Discoveries among as many `looks` as there were; those not taken up count with p = 1."""
    p = np.ones(max(looks, len(candidates)))
    p[: len(candidates)] = [c.named.evidence.p_value for c in candidates]
    found = false_discovery(np.nan_to_num(p, nan=1.0), LEVEL)
    return [
        c.named
        for c, ok in zip(candidates, found, strict=False)
        if ok and c.held and not c.named.evidence.delta_bic < _LEAST_BIC
    ]


def of_position(result: PositionResult, slides: tuple[bool, ...]) -> list[Candidate]:
    """Lag, compliance and play of every axis."""
    found = []
    for a in result.axes:
        axis = a.follower.axis
        unit = "m" if slides[axis] else "rad"
        values = numbers(a, result.late, result.clock)
        fixed = ("clock",) if result.clock and result.late != result.zero else ()
        for term in a.terms:
            rms = [
                math.sqrt(held_out(a.raw, (*fixed, *(t for t in a.terms if t != out))).mean())
                for out in (term, "")
            ]
            evidence = AxisEvidence(
                term, axis + 1, "position", unit, a.delta_bic[term], a.gains[term][1], rms[0], rms[1]
            )
            parameters = _parameters(term, values, unit)
            known = all(p.identified for name, p in parameters.items() if name != "damping")
            found.append(Candidate(ConfirmedTerm(evidence, parameters), known and a.gains[term][0] > 0))
    return found


def _parameters(term: str, values: dict[str, tuple[float, float]], unit: str) -> dict[str, FittedParameter]:
    def made(name: str, unit: str, factor: float, low: float, high: float) -> FittedParameter:
        value, width = (factor * v for v in values[name])
        bound = not low < value < high
        return FittedParameter(value, unit, value - width, value + width, bound, width < 0.5 * abs(value))

    if term == "servo-lag":
        return {"time constant": made("lag", "s", 1.0, 1e-5, 0.499)}
    if term == "backlash":
        return {"play": made("play", unit, 1.0, 2e-9, 0.099)}
    if "twist" in values:
        twist, width = values["twist"]
        sure = width < 0.5 * twist
        high = 1 / (twist - width) if sure else math.inf
        per = "N m/rad" if unit == "rad" else "N/m"
        return {"stiffness": FittedParameter(1 / twist, per, 1 / (twist + width), high, False, sure)}
    turn = 1 / (2 * math.pi)
    return {
        "frequency": made("frequency", "Hz", turn, 0.6, 119.0),
        "damping": made("damping", "1", 1.0, 2.1e-3, 0.499),
        "share": made("swing", "1", 1.0, -19.0, 19.0),
    }


def of_efforts(result: Efforts, slides: tuple[bool, ...]) -> list[Candidate]:
    """Friction of every axis."""
    found = []
    for a in result.axes:
        per = "m" if slides[a.axis] else "rad"
        for term in a.terms:
            if term == MASSES:
                continue
            value, width = a.sizes[term]
            unit = f"{a.unit} s/{per}" if term == "viscous-friction" else a.unit
            evidence = AxisEvidence(
                term, a.axis + 1, a.signal, a.unit, a.delta_bic[term], a.gains[term][1], *a.heldout[term]
            )
            p = FittedParameter(value, unit, value - width, value + width, False, width < 0.5 * abs(value))
            name = term.partition("-")[0]
            found.append(Candidate(ConfirmedTerm(evidence, {name: p}), a.gains[term][0] > 0))
    if result.load is not None:
        load = result.load
        evidence = AxisEvidence("payload", 0, "torque", "1", load.delta_bic, load.gain[1], *load.heldout)
        (mass, about), (centre, width) = load.mass, load.centre
        numbers_of = {
            "mass": FittedParameter(mass, "kg", mass - about, mass + about),
            "centre along the flange's z": FittedParameter(
                centre, "m", centre - width, centre + width, False, width < 0.5 * abs(centre)
            ),
        }
        found.append(Candidate(ConfirmedTerm(evidence, numbers_of)))
    return found


def of_encoders(result: Encoders, slides: tuple[bool, ...]) -> tuple[list[Candidate], ClockFit | None]:
    """Second encoders: a common skew is the clock, a twist per torque is compliance."""
    found: list[Candidate] = []
    clock = None
    if math.isfinite(result.late):
        p = _together([a.gains[SKEW][1] for a in result.axes])
        rms = [math.sqrt(np.mean([a.heldout[SKEW][i] ** 2 for a in result.axes])) for i in (0, 1)]
        evidence = AxisEvidence("clock", 0, "link encoder", "rad", math.nan, p, rms[0], rms[1])
        parameter = FittedParameter(result.late, "s", result.low, result.high)
        found.append(Candidate(ConfirmedTerm(evidence, {"link behind motor encoders": parameter})))
        clock = ClockFit(
            *("link encoders", "motor encoders", result.late, result.low, result.high),
            *(math.nan, math.nan, math.nan, True, False),
        )
    for a in result.axes:
        unit = "m" if slides[a.axis] else "rad"
        per = "Nm" if a.by_torque else f"{unit}/s²"
        for term, (value, width), name in ((TWIST, a.twist, "twist"), (PLAY, a.play, "play")):
            if term not in a.terms:
                continue
            whole = 2 * value if term == PLAY else value
            half = 2 * width if term == PLAY else width
            evidence = AxisEvidence(
                term, a.axis + 1, "link encoder", unit, math.nan, a.gains[term][1], *a.heldout[term]
            )
            label = f"{unit}/{per}" if term == TWIST else unit
            p_fit = FittedParameter(whole, label, whole - half, whole + half, False, half < 0.5 * abs(whole))
            found.append(
                Candidate(
                    ConfirmedTerm(evidence, {name: p_fit}), a.gains[term][0] > 0 and half < 0.5 * abs(whole)
                )
            )
    return found, clock


def _together(p_values: list[float]) -> float:
    """One p-value of several independent ones (R. A. Fisher); closed for an even number of degrees of freedom."""
    half = -sum(math.log(max(p, 1e-300)) for p in p_values)
    term, total = 1.0, 1.0
    for i in range(1, len(p_values)):
        term *= half / i
        total += term
    return min(math.exp(-half) * total, 1.0)


def of_clock(
    pairing: Pairing | None,
    position: PositionResult | None,
    by_command: bool,
    period: float,
    against_sim: bool,
) -> tuple[list[Candidate], list[ClockFit]]:
    """The recorder against the simulation, and one channel against another."""
    found: list[Candidate] = []
    clocks: list[ClockFit] = []
    late = position.late if position is not None else 0.0
    least = (_HELD if position is not None and digital(position) else _LEAST_OFFSET) * period
    error = position.late_error if position is not None else math.nan
    if pairing is not None:
        clock = pairing.clock
        rate_sure = (
            abs(clock.rate - 1) > max(SURE * clock.rate_error, LEAST_RATE)
            and len(pairing.at) >= 6
            and not pairing.retimed
        )
        joint = against_sim and not by_command and position is not None
        offset = clock.offset + clock.rate * late if joint else clock.offset
        width = 1.96 * (error if joint else clock.offset_error)
        if joint and position is not None:
            offset_sure = position.clock and abs(late - position.zero) > least
        else:
            offset_sure = abs(offset) > max(SURE * clock.offset_error, _LEAST_OFFSET * period)
        offset_sure = offset_sure and abs(offset) < _NEAR and not pairing.retimed
        half = 1.96 * clock.rate_error
        fit = ClockFit(
            *("log", "simulation", offset, offset - width, offset + width),
            *(clock.rate, clock.rate - half, clock.rate + half, offset_sure, rate_sure),
        )
        clocks.append(fit)
        if offset_sure or rate_sure:
            found.append(_clock_candidate(fit, position if joint else None))
    if position is not None and position.clock and (pairing is None or by_command):
        fit = ClockFit(
            *("q", "q_cmd", late, late - 1.96 * error, late + 1.96 * error),
            *(math.nan, math.nan, math.nan, abs(late) > least, False),
        )
        clocks.append(fit)
        if fit.offset_significant:
            found.append(_clock_candidate(fit, position))
    return found, clocks


def digital(position: PositionResult) -> bool:
    """Whether most axes have a servo lag, so that their loops' cycle makes some of the lateness.

    A log is written once per cycle, or more seldom.
    """
    lagging = sum("servo-lag" in a.terms for a in position.axes)
    return lagging * 3 >= 2 * len(position.axes)


def _clock_candidate(fit: ClockFit, position: PositionResult | None) -> Candidate:
    numbers = {}
    name = f"{fit.of} behind {fit.against}"
    if fit.offset_significant:
        numbers[name] = FittedParameter(fit.offset, "s", fit.offset_low, fit.offset_high)
    if fit.rate_significant:
        numbers["rate"] = FittedParameter(fit.rate, "1", fit.rate_low, fit.rate_high)
    p, delta = math.erfc(SURE / math.sqrt(2)), math.nan
    if position is not None and fit.offset_significant and not fit.rate_significant:
        p, delta = position.clock_gain[1], position.clock_delta
    return Candidate(
        ConfirmedTerm(AxisEvidence("clock", 0, "position", "s", delta, p, math.nan, math.nan), numbers)
    )
