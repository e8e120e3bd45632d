"""A recording's logs: the clocks first, then how the axes follow, then what torques they need.

What is named is what held-out blocks confirm, at one false discovery rate over all axes and terms together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from olp.diagnosis.logs import told
from olp.diagnosis.logs.effort import Efforts, efforts
from olp.diagnosis.logs.encoders import Encoders, encoders, link_columns
from olp.diagnosis.logs.findings import Named, findings
from olp.diagnosis.logs.following import BOTH, CLOCK, NONE
from olp.diagnosis.logs.moves import late_moves
from olp.diagnosis.logs.pairing import LEAST_RATE, Pairing, pair
from olp.diagnosis.logs.position import PositionResult, drift, drop, followers, judge, seconds_left
from olp.diagnosis.logs.remains import correlates, goes_with_motion, noise_floor, verdict_of
from olp.diagnosis.logs.result import AxisResidual, ClockFit, LogCorrelate, LogDiagnosis
from olp.diagnosis.logs.select import held_out
from olp.diagnosis.logs.series import dropped, even, gaps
from olp.diagnosis.logs.torque import MASSES, motion
from olp.diagnosis.result import Alternative, MoveResidual
from olp.recording.log import Log
from olp.recording.recording import Recording
from olp.robots.model import Robot

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
_FEWEST = 600  # samples
_NEAR = 1.0  # [s] an offset below which two clocks were meant to agree
_RIVAL = 10.0  # BIC: a story less worse than that is as good
_TURNS = 2
_RETIMED = 0.01  # [s] that axes may be off in time when a clock and their physics are taken out
_OTHER_TIMES = (
    "moves take other times in the log than in the simulation: how the axes follow is not judged against it"
)
_FAR = 3.0  # times the noise: a rest of that size in motion is no noise, whatever it goes with
_SHORT_DWELL = 0.05  # [s] beside a dwell that is not looked at


def diagnose_logs(recording: Recording) -> LogDiagnosis:
    """Everything that `log.csv`, alone or beside `sim_log.csv`, tells. A recording without a log tells nothing."""
    if recording.log is None:
        return LogDiagnosis("no-mismatch", notes=("the recording has no log",))
    return diagnose_log(recording.log, recording.sim_log, recording.robot)


def diagnose_log(log: Log, sim: Log | None = None, robot: Robot | None = None) -> LogDiagnosis:
    """As `diagnose_logs`, from the logs themselves. Samples that are not whole numbers of axes are left out."""
    notes: list[str] = []
    log = _clean(log, "log", notes)
    sim = _clean(sim, "simulated log", notes) if sim is not None else None
    if len(log) < _FEWEST:
        return LogDiagnosis("no-mismatch", notes=(f"{len(log)} samples are too few to tell anything",))
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
        axes = followers(time, log.q, reference_time, reference, self.usable)
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

    def _steady(self, pairing: Pairing) -> bool:
        """Whether lateness does not grow; else the pairing has learnt the rate that the windows did not see."""
        assert self.position is not None
        grows, error = drift(self.position)
        if self.turns >= _TURNS or abs(grows) < max(told.SURE * error, LEAST_RATE):
            known = pairing.clock.rate == 1.0
            self.pairing = pairing.quicker(1.0 if known else 1 + grows, error)
            return True
        self.turns += 1
        self.pairing = pairing.quicker(1 + grows, error)
        return False

    def drive(self) -> None:
        """Torques and second encoders."""
        log = self.log
        self.effort = efforts(log, self._simulated_effort(), self.usable, self.robot)
        if self.effort is not None:
            self.notes += self.effort.notes
        if link_columns(log):
            self.second = encoders(log, motion(log), self.usable)

    def _simulated_effort(self) -> Floats | None:
        sim, pairing = self.sim, self.pairing
        if sim is None or pairing is None or pairing.retimed:
            return None
        theirs = sim.torque if self.log.torque is not None else sim.current
        if theirs is None or not np.isfinite(theirs).all(axis=1).any():
            return None
        grid = even(sim.time, theirs, sim.period)
        return grid.at(pairing.simulated(self.log.time))

    def answer(self) -> LogDiagnosis:
        """What is confirmed, in the shape that is reported."""
        log, slides = self.log, self.log.slides
        candidates, clocks = told.of_clock(
            self.pairing, self.position, self.by_command, log.period, self.against_sim
        )
        looks = 2
        if self.position is not None:
            candidates += told.of_position(self.position, slides)
            looks += 3 * len(self.position.axes)
        if self.effort is not None:
            candidates += told.of_efforts(self.effort, slides)
            looks += 2 * len(self.effort.axes)
        if self.second is not None:
            more, clock = told.of_encoders(self.second, slides)
            candidates += more
            clocks += [clock] if clock is not None else []
            looks += 3 * len(self.second.axes)
            if clock is None:
                self.notes.append("the second encoders differ by different times: no clock explains that")
        named = told.confirmed(candidates, looks)
        kept = _kept(self.position, named)
        return _Report(self, kept, named).diagnosis(tuple(clocks))


def _kept(position: PositionResult | None, named: list[Named]) -> PositionResult | None:
    """The axes with only what was confirmed."""
    if position is None:
        return None
    names = {(n.evidence.axis, n.evidence.term) for n in named if n.evidence.signal == "position"}
    axes = []
    for a in position.axes:
        terms = tuple(t for t in a.terms if (a.follower.axis + 1, t) in names)
        axes.append(a if terms == a.terms else drop(a, terms, position.late, position.zero))
    return replace(position, axes=tuple(axes))


@dataclass(frozen=True, slots=True)
class _Report:
    """What is left after the confirmed terms, and everything said about it."""

    case: _Case
    position: PositionResult | None
    named: list[Named]

    def diagnosis(self, clocks: tuple[ClockFit, ...]) -> LogDiagnosis:
        case = self.case
        axes, remains, structured, moves = self._positions()
        more, others, follows = self._efforts()
        holes = gaps(case.log.time)
        missing = dropped(case.log.time)
        if missing:
            share = missing / (missing + len(case.log))
            case.notes.append(f"{missing} samples are missing ({share:.1%}), in {len(holes)} gaps")
        groups, rivals = self._rivals()
        judged = (*axes, *(a for a in more if case._simulated_effort() is not None or _has_masses(case)))
        named = [n._replace(moves=tuple(m.move for m in moves if m.significant)) for n in self.named]
        verdict = verdict_of(judged, bool(named), structured | follows)
        if case.pairing is not None and case.pairing.retimed:
            verdict = "partly-explained" if named else "unexplained"
        return LogDiagnosis(
            verdict,
            findings(named, rivals),
            groups,
            clocks,
            missing,
            holes,
            case.pairing.unpaired if case.pairing is not None else (),
            case.pairing.dwell if case.pairing is not None else (),
            (*axes, *more),
            tuple(n.evidence for n in named),
            moves,
            (*remains, *others),
            _NEXT if groups else "",
            tuple(dict.fromkeys(case.notes)),
        )

    def _positions(
        self,
    ) -> tuple[
        tuple[AxisResidual, ...], tuple[LogCorrelate, ...], set[tuple[int, str]], tuple[MoveResidual, ...]
    ]:
        result, case = self.position, self.case
        if result is None:
            return (), (), set(), ()
        reference = result.axes[0].follower.reference
        k = reference.grid.values.shape[1]
        v, a = (np.stack([reference.derivative(o, j, 0.008) for j in range(k)], axis=1) for o in (1, 2))
        time = result.axes[0].follower.time
        speed, acceleration = (reference.grid.at(time, x) for x in (v, a))
        fixed = ("clock",) if result.clock and result.late != result.zero else ()
        axes: list[AxisResidual] = []
        found: list[LogCorrelate] = []
        structured: set[tuple[int, str]] = set()
        off = np.full((len(time), k), np.nan)
        floors = np.full(k, np.nan)
        for one in result.axes:
            f, j = one.follower, one.follower.axis
            left = f.residual - f.effects(one.shape, result.late)
            left = left - left[f.use].mean()
            floor = noise_floor(case.log.time, left, speed, f.use)
            before = math.sqrt(held_out(one.raw, ()).mean())
            after = math.sqrt(held_out(one.raw, (*fixed, *one.terms)).mean())
            unit = "m" if case.log.slides[j] else "rad"
            axes.append(AxisResidual(j + 1, "position", unit, before, after, floor))
            columns = _motion_columns(j, speed, acceleration, case.log.q)
            still = f.use & (np.abs(speed[:, j]) <= 0.01 * np.abs(speed[:, j]).max())
            moving = float(left[f.use & ~still].std()) if (f.use & ~still).any() else 0.0
            if moving > _FAR * floor or goes_with_motion(case.log.time, left, columns, f.use) < 1e-3:
                structured.add((j + 1, "position"))
                if after > 1.2 * floor:
                    found += correlates(j + 1, "position", left, columns | _others(case.log), f.use)
            floors[j] = floor
            raw = f.residual - (f.delay(result.zero) if result.zero else 0.0)
            off[:, j] = np.where(f.use, raw - raw[f.use].mean(), np.nan)
        live = [x.follower.axis for x in result.axes]
        moves = (
            late_moves(case.log.move, case.log.period, off[:, live], speed[:, live], floors[live])
            if case.log.move is not None
            else ()
        )
        return tuple(axes), tuple(found), structured, moves

    def _efforts(self) -> tuple[tuple[AxisResidual, ...], tuple[LogCorrelate, ...], set[tuple[int, str]]]:
        result, log = self.case.effort, self.case.log
        if result is None:
            return (), (), set()
        axes: list[AxisResidual] = []
        found: list[LogCorrelate] = []
        structured: set[tuple[int, str]] = set()
        moved, others = result.moved, {n: v[result.rows] for n, v in _others(log).items()}
        for one in result.axes:
            use = np.isfinite(one.left)
            left = np.where(use, one.left, 0.0)
            floor = noise_floor(moved.time, left, moved.speed, use)
            axes.append(AxisResidual(one.axis + 1, one.signal, one.unit, one.before, one.after, floor))
            columns = _motion_columns(one.axis, moved.speed, moved.acceleration, moved.q)
            if MASSES in one.terms or goes_with_motion(moved.time, left, columns, use) < 1e-3:
                structured.add((one.axis + 1, one.signal))
            if one.after > 1.2 * floor:
                found += correlates(one.axis + 1, one.signal, left, columns | others, use)
        if any(MASSES in one.terms for one in result.axes):
            names = ", ".join(str(one.axis + 1) for one in result.axes if MASSES in one.terms)
            self.case.notes.append(
                f"inertia or gravity of axes {names} are not those of {result.against}: masses, or a load"
            )
        return tuple(axes), tuple(found), structured

    def _rivals(self) -> tuple[tuple[tuple[str, ...], ...], dict[str, tuple[Alternative, ...]]]:
        """Clock and lag when their shapes cannot be told apart by these motions."""
        result = self.position
        if result is None:
            return (), {}
        lagging = any("servo-lag" in a.terms for a in result.axes)
        clock = min(result.scores.get(CLOCK, math.inf), math.inf)
        none = result.scores.get(NONE, math.inf)
        if lagging and not result.clock and clock < _RIVAL:
            return (("servo-lag", "clock"),), {"servo-lag": (Alternative("clock", clock),)}
        if result.clock and not lagging and none < _RIVAL:
            return (("clock", "servo-lag"),), {"clock": (Alternative("servo-lag", none),)}
        if result.clock and lagging and none < _RIVAL:
            rival = Alternative("servo-lag", result.scores.get(BOTH, 0.0))
            return (("clock", "servo-lag"),), {"clock": (rival,)}
        return (), {}


_NEXT = (
    "run the same moves at the highest acceleration and with the shortest ramps: a lag rounds them, a late clock "
    "does not"
)


def _has_masses(case: _Case) -> bool:
    return case.robot is not None and case.robot.dynamics is not None and case.log.torque is not None


def _motion_columns(axis: int, speed: Floats, acceleration: Floats, q: Floats) -> dict[str, Floats]:
    """What a rest may go together with, by name."""
    v, a = speed[:, axis], acceleration[:, axis]
    return {
        f"qd{axis + 1}": v,
        f"size of qd{axis + 1}": np.abs(v),
        f"qdd{axis + 1}": a,
        f"size of qdd{axis + 1}": np.abs(a),
        f"direction of axis {axis + 1}": np.tanh(v / max(1e-3 * float(np.abs(v).max()), 1e-12)),
        f"sin q{axis + 1}": np.sin(q[:, axis]),
        f"cos q{axis + 1}": np.cos(q[:, axis]),
    }


def _others(log: Log) -> dict[str, Floats]:
    return {"t_s": log.time} | dict(log.covariates)


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
