"""A recording's logs: the clocks first, then how the axes follow, then what torques they need.

What is named is what held-out blocks confirm, at one false discovery rate over all axes and terms together.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs import candidate_findings
from olp.identification.diagnosis.logs.effort import FITTED, Efforts, efforts
from olp.identification.diagnosis.logs.encoders import Encoders, encoders, link_columns
from olp.identification.diagnosis.logs.findings import ConfirmedTerm
from olp.identification.diagnosis.logs.pairing import LEAST_RATE, Pairing, pair
from olp.identification.diagnosis.logs.position import (
    PositionResult,
    drift,
    drop,
    followers,
    judge,
    seconds_left,
)
from olp.identification.diagnosis.logs.report import LogReport
from olp.identification.diagnosis.logs.result import LogDiagnosis
from olp.identification.diagnosis.logs.series import Grid, Spectrum, even, smoothed
from olp.identification.diagnosis.logs.torque import motion
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
    "moves take other times in the log than in the simulation: how the axes follow is not judged against it"
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
        return LogDiagnosis("not-judged", notes=(f"{len(log)} samples are too few to tell anything",))
    if sim is not None and (len(sim) < _FEWEST or sim.q.shape[1] != log.q.shape[1]):
        notes.append("the simulated log is too short or has other axes: it was left aside")
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
            self.notes.append("no command and no simulated axes: lag, compliance and play cannot be told")
            return
        axes = followers(time, log.q, reference_time, reference, self.usable, self._loads())
        if not axes:
            self.notes.append("no axis moves long enough to tell how it follows")
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
        if self.turns >= _TURNS or abs(grows) < max(candidate_findings.SURE * error, LEAST_RATE):
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
        candidates, clocks = candidate_findings.of_clock(
            self.pairing, self.position, self.by_command, log.period, self.against_sim
        )
        looks = 2
        if self.position is not None:
            candidates += candidate_findings.of_position(self.position, slides)
            looks += 3 * len(self.position.axes)
        if self.effort is not None:
            candidates += candidate_findings.of_efforts(self.effort, slides)
            looks += 2 * len(self.effort.axes)
        if self.second is not None:
            more, clock = candidate_findings.of_encoders(self.second, slides)
            candidates += more
            clocks += [clock] if clock is not None else []
            looks += 3 * len(self.second.axes)
            if clock is None:
                self.notes.append("the second encoders differ by different times: no clock explains that")
        named = candidate_findings.confirmed(candidates, looks)
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
