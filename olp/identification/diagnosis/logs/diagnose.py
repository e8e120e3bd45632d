"""A recording's logs: the clocks first, then how the axes follow, then what torques they need.

What is named is what held-out blocks confirm, at one false discovery rate over all axes and terms together.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.effort import FITTED, Efforts, efforts
from olp.identification.diagnosis.logs.encoders import PLAY, SKEW, TWIST, Encoders, encoders, link_columns
from olp.identification.diagnosis.logs.pairing import LEAST_RATE, Pairing, pair
from olp.identification.diagnosis.logs.position import (
    PositionResult,
    drift,
    drop,
    followers,
    judge,
    numbers,
    seconds_left,
)
from olp.identification.diagnosis.logs.report import ConfirmedTerm, LogReport
from olp.identification.diagnosis.logs.result import AxisEvidence, ClockFit, LogDiagnosis
from olp.identification.diagnosis.logs.select import held_out_rms
from olp.identification.diagnosis.logs.series import Grid, Spectrum, even, smoothed
from olp.identification.diagnosis.logs.statistics import false_discovery
from olp.identification.diagnosis.logs.torque import MASSES, motion
from olp.identification.diagnosis.result import FittedParameter
from olp.identification.recording.log import Log
from olp.identification.recording.recording import Recording
from olp.robots.model import Robot
from olp.timing.physics.clock import shift
from olp.timing.physics.servo_lag import lag

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
_FEWEST = 600  # samples
_NEAR = 1.0  # [s] an offset below which two clocks were meant to agree
_TURNS = 2
_RETIMED = 0.01  # [s] that axes may be off in time when a clock and their physics are taken out
_OTHER_TIMES = (
    "moves take different times in log and simulation: how axes follow is not judged against the simulation"
)
_SHORT_DWELL = 0.05  # [s] beside a dwell that is not looked at


def diagnose_logs(recording: Recording) -> LogDiagnosis:
    """Everything that `log.csv`, alone or beside `sim_log.csv`, tells. A recording without a log tells nothing."""
    if recording.log is None:
        return LogDiagnosis("not-judged", notes=("the recording has no log",))
    return diagnose_log(recording.log, recording.sim_log, recording.robot)


def diagnose_log(log: Log, sim: Log | None = None, robot: Robot | None = None) -> LogDiagnosis:
    """As `diagnose_logs`, from the logs themselves. Samples that are not whole numbers of axes are left out."""
    notes: list[str] = []
    log = _clean(log, "log", notes)
    sim = _clean(sim, "simulated log", notes) if sim is not None else None
    if len(log) < _FEWEST:
        return LogDiagnosis("not-judged", notes=(f"{len(log)} samples are too few for a diagnosis",))
    if sim is not None and (len(sim) < _FEWEST or sim.q.shape[1] != log.q.shape[1]):
        notes.append("the simulated log is too short or has other axes: it is ignored")
        sim = None
    case = _Case(log, sim, robot, notes)
    case.align()
    case.follow()
    case.drive()
    return case.answer()


class _Case:
    """One pair of logs on its way through the three questions."""

    def __init__(self, log: Log, sim: Log | None, robot: Robot | None, notes: list[str]) -> None:
        self.log, self.sim, self.robot, self.notes = log, sim, robot, notes
        self.pairing: Pairing | None = None
        self.by_command = False  # whether the clock was told from commands alone
        self.against_sim = False  # whether the axes are judged against the simulated ones
        self.position: PositionResult | None = None
        self.effort: Efforts | None = None
        self.second: Encoders | None = None
        self.turns = 0  # that the rate was corrected
        self.usable: Mask = np.ones(len(log), dtype=bool)

    def align(self) -> None:
        """Pairs the log with the simulated one; what cannot be paired is left out."""
        log, sim = self.log, self.sim
        if sim is None:
            return
        self.by_command = log.command is not None
        values = log.command if log.command is not None else log.q
        planned = sim.command if self.by_command and sim.command is not None else sim.q
        self.pairing = pair(log, sim, values, planned)
        if self.pairing is None:
            self.notes.append("the log and the simulated log never move alike: nothing was paired")
            return
        for begin, end in self.pairing.unpaired:
            self.usable &= (log.time < begin) | (log.time > end)
        for stop in self.pairing.dwell:
            self.usable &= np.abs(log.time - stop.time) > abs(stop.extra) + _SHORT_DWELL
        if self.pairing.retimed:
            self.notes.append(_OTHER_TIMES)

    def follow(self) -> None:
        """The axes against the simulated ones, or against their commands."""
        log, sim, pairing = self.log, self.sim, self.pairing
        unfaulted: float | None = 0.0
        if sim is not None and pairing is not None and not pairing.retimed:
            self.against_sim = True
            time, reference_time, reference = pairing.simulated(log.time), sim.time, sim.q
            offset = pairing.clock.offset
            if not self.by_command:
                unfaulted = -offset / pairing.clock.rate if abs(offset) < _NEAR else None
        elif log.command is not None:
            time, reference_time, reference = log.time, log.time, log.command
        else:
            self.notes.append(
                "no command and no simulated axes: lag, compliance and play cannot be identified"
            )
            return
        axes = followers(time, log.q, reference_time, reference, self.usable, self._loads())
        if not axes:
            self.notes.append("no axis moves long enough to identify how it follows")
            return
        self.position = judge(axes, unfaulted)
        if self.against_sim and pairing is not None:
            if seconds_left(self.position) > max(_RETIMED, 2 * log.period):
                # A clock and the axes' physics leave no such thing: the moves themselves are other ones.
                self.pairing, self.position, self.against_sim = replace(pairing, retimed=True), None, False
                self.notes.append(_OTHER_TIMES)
                self.follow()
                return
            if not self._steady(pairing):
                self.follow()
                return
        if self.position.refused:
            self.notes.append("the axes are early or late by different times, which no clock does")

    def _loads(self) -> Floats | None:
        """(n, k, 2) torques that axes may give way to, and how far they are from the simulated ones.

        Not against commands: motors that stand away from their commands under a load say how stiff servos are.
        """
        log, sim, pairing = self.log, self.sim, self.pairing
        if not self.against_sim or sim is None or pairing is None or log.torque is None or sim.torque is None:
            return None
        if not (np.isfinite(log.torque).all() and np.isfinite(sim.torque).all()):
            return None
        measured = smoothed(even(log.time, log.torque, log.period), log.time)
        planned = smoothed(even(sim.time, sim.torque, sim.period), pairing.simulated(log.time))
        return np.stack([measured, measured - planned], axis=2)

    def _steady(self, pairing: Pairing) -> bool:
        """Whether lateness does not grow; else the pairing has learnt the rate that the windows did not see."""
        assert self.position is not None
        grows, error = drift(self.position)
        if self.turns >= _TURNS or abs(grows) < max(SURE * error, LEAST_RATE):
            known = pairing.clock.rate == 1.0
            self.pairing = pairing.quicker(1.0 if known else 1 + grows, error)
            return True
        self.turns += 1
        self.pairing = pairing.quicker(1 + grows, error)
        return False

    def _reference(self) -> tuple[Floats, Floats] | None:
        """Instants and places that the axes were judged against."""
        if self.against_sim and self.sim is not None:
            return self.sim.time, self.sim.q
        return (self.log.time, self.log.command) if self.log.command is not None else None

    def _planned(self) -> tuple[Floats, Floats] | None:
        """Instants and torques or currents that the measured ones were judged against."""
        if self.sim is None:
            return None
        theirs = self.sim.torque if self.log.torque is not None else self.sim.current
        return (self.sim.time, theirs) if theirs is not None else None

    def drive(self) -> None:
        """Torques and second encoders."""
        log = self.log
        self.effort = efforts(log, self._simulated_effort(), self.usable, self.robot)
        if self.effort is not None:
            self.notes += self.effort.notes
        if self.sim is not None and link_columns(self.sim):
            self.notes.append(
                "the simulation has the second encoders, too: they are not judged against the motors'"
            )
        elif link_columns(log):
            self.second = encoders(log, motion(log), self.usable)

    def _simulated_effort(self) -> Floats | None:
        sim, pairing = self.sim, self.pairing
        if sim is None or pairing is None or pairing.retimed:
            return None
        theirs = sim.torque if self.log.torque is not None else sim.current
        known = np.isfinite(theirs).any(axis=0) if theirs is not None else np.zeros(1, dtype=bool)
        if theirs is None or not known.any():
            return None
        grid = even(sim.time, np.where(known, theirs, 0.0), sim.period)
        return np.where(known, grid.at(pairing.simulated(self.log.time), self._as_late(grid)), np.nan)

    def _as_late(self, grid: Grid) -> Floats:
        """(n, k) what is simulated on `grid`, as late as the axes: bodies need torque when they move, not when told."""
        lags = {
            a.follower.axis: a.shape.lag
            for a in (self.position.axes if self.position is not None and self.against_sim else ())
            if "servo-lag" in a.terms
        }
        if self.position is None or not lags:
            return grid.values
        spectrum, values = Spectrum(grid), grid.values.copy()
        usual = float(np.median(list(lags.values())))
        for axis in range(values.shape[1]):
            gain = (1 + shift(spectrum.omega, self.position.late - self.position.zero)) * (
                1 + lag(spectrum.omega, lags.get(axis, usual))
            )
            values[:, axis] = grid.values[:, axis] + spectrum.through(gain - 1, axis)
        return values

    def answer(self) -> LogDiagnosis:
        """What is confirmed, in the shape that is reported."""
        log, slides = self.log, self.log.slides
        candidates, clocks = of_clock(
            self.pairing, self.position, self.by_command, log.period, self.against_sim
        )
        looks = 2
        if self.position is not None:
            candidates += of_position(self.position, slides)
            looks += 3 * len(self.position.axes)
        if self.effort is not None:
            candidates += of_efforts(self.effort, slides)
            looks += 2 * len(self.effort.axes)
        if self.second is not None:
            more, clock = of_encoders(self.second, slides)
            candidates += more
            clocks += [clock] if clock is not None else []
            looks += 3 * len(self.second.axes)
            if clock is None:
                self.notes.append("the second encoders differ by different times: no clock explains that")
        named = confirmed(candidates, looks)
        kept = _kept(self.position, named)
        simulated = self.effort is not None and self.effort.against != FITTED
        report = LogReport(
            log,
            self._reference(),
            self._planned(),
            self.pairing,
            kept,
            self.effort,
            simulated,
            named,
            self.notes,
        )
        return report.diagnosis(tuple(clocks))


def _kept(position: PositionResult | None, named: list[ConfirmedTerm]) -> PositionResult | None:
    """The axes with only what was confirmed."""
    if position is None:
        return None
    names = {(n.evidence.axis, n.evidence.term) for n in named if n.evidence.signal == "position"}
    axes = []
    for a in position.axes:
        terms = tuple(t for t in a.terms if (a.follower.axis + 1, t) in names)
        axes.append(a if terms == a.terms else drop(a, terms, position.late, position.zero))
    return replace(position, axes=tuple(axes))


def _clean(log: Log, name: str, notes: list[str]) -> Log:
    """Without samples that repeat an instant or miss an axis."""
    good = np.isfinite(log.q).all(axis=1) & np.append(True, np.diff(log.time) > 0)
    if log.command is not None and np.isfinite(log.command).all(axis=1).mean() < 0.5:
        log = replace(log, command=None)
    if log.command is not None:
        good &= np.isfinite(log.command).all(axis=1)
    if good.all():
        return log
    notes.append(f"{int((~good).sum())} samples of the {name} repeat an instant or miss an axis: left out")
    parts = {
        part: value[good]
        for part in ("time", "q", "command", "speed", "torque", "current", "position", "angles", "move")
        if (value := getattr(log, part)) is not None
    }
    others = {k: v[good] for k, v in log.covariates.items()}
    texts = {k: tuple(t for t, ok in zip(v, good, strict=True) if ok) for k, v in log.texts.items()}
    return replace(log, **parts, covariates=others, texts=texts)


# --- Candidate findings ---
# Everything that clocks, axes and torques told becomes candidates; what blocks confirm becomes names.

LEVEL = 0.05  # false discoveries among names
_LEAST_BIC = 10.0  # "very strong": R. E. Kass, A. E. Raftery, Bayes Factors, J. Am. Stat. Assoc. 90, 1995
SURE = 4.0  # standard errors of a clock
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
            rms = [held_out_rms(a.raw, (*fixed, *(t for t in a.terms if t != out))) for out in (term, "")]
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
