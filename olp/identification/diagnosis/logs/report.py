"""What is left after the confirmed terms, and everything that is said about it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.effort import Efforts
from olp.identification.diagnosis.logs.findings import ConfirmedTerm, findings
from olp.identification.diagnosis.logs.following import BOTH, CLOCK, NONE
from olp.identification.diagnosis.logs.moves import late_moves
from olp.identification.diagnosis.logs.pairing import Pairing
from olp.identification.diagnosis.logs.position import PositionResult
from olp.identification.diagnosis.logs.residuals import (
    CLEAR,
    correlates,
    goes_with_motion,
    noise_floor,
    verdict_of,
)
from olp.identification.diagnosis.logs.result import AxisResidual, ClockFit, LogCorrelate, LogDiagnosis
from olp.identification.diagnosis.logs.select import held_out
from olp.identification.diagnosis.logs.series import dropped, gaps, misread
from olp.identification.diagnosis.logs.torque import MASSES
from olp.identification.diagnosis.result import Alternative, MoveResidual
from olp.identification.recording.log import Log

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
_RIVAL = 10.0  # BIC: a story less worse than that is as good
_INSTANT = 0.01  # of a sampling period: no better is known what belongs to what in two logs
_STILL = 0.01  # of an axis' highest speed: slower is rest
_FAR = 3.0  # times the noise: a rest of that size in motion is no noise, whatever it goes with


@dataclass(frozen=True, slots=True)
class LogReport:
    """What is left after the confirmed terms, and everything said about it."""

    log: Log
    reference: tuple[Floats, Floats] | None  # (m,) [s] and (m, k) what the axes were judged against
    efforts_of: tuple[Floats, Floats] | None  # the same of torques or currents
    pairing: Pairing | None
    position: PositionResult | None  # of every axis only what was confirmed
    effort: Efforts | None
    torque_judged: bool  # whether torques were compared with anything but a fit of their own
    named: list[ConfirmedTerm]
    notes: list[str]  # more are added

    def diagnosis(self, clocks: tuple[ClockFit, ...]) -> LogDiagnosis:
        axes, remains, structured, moves = self._positions()
        more, others, follows = self._efforts()
        holes = gaps(self.log.time)
        missing = dropped(self.log.time)
        if missing:
            share = missing / (missing + len(self.log))
            self.notes.append(f"{missing} samples are missing ({share:.1%}), in {len(holes)} gaps")
        groups, rivals = self._rivals()
        fitted = self.effort.fitted if self.effort is not None else frozenset()
        judged = (*axes, *(a for a in more if self.torque_judged and a.axis - 1 not in fitted))
        named = [n._replace(moves=tuple(m.move for m in moves if m.significant)) for n in self.named]
        verdict = verdict_of(judged, bool(named), structured | follows)
        if self.pairing is not None and self.pairing.retimed:
            verdict = "partly-explained" if named else "unexplained"
        return LogDiagnosis(
            verdict,
            findings(named, rivals),
            groups,
            clocks,
            missing,
            holes,
            self.pairing.unpaired if self.pairing is not None else (),
            self.pairing.dwell if self.pairing is not None else (),
            (*axes, *more),
            tuple(n.evidence for n in named),
            moves,
            (*remains, *others),
            _NEXT if groups else "",
            tuple(dict.fromkeys(self.notes)),
            float(self.log.time[-1] - self.log.time[0]),
        )

    def _positions(
        self,
    ) -> tuple[
        tuple[AxisResidual, ...], tuple[LogCorrelate, ...], set[tuple[int, str]], tuple[MoveResidual, ...]
    ]:
        result = self.position
        if result is None:
            return (), (), set(), ()
        reference = result.axes[0].follower.reference
        k = reference.grid.values.shape[1]
        v, a = (np.stack([reference.derivative(o, j, 0.008) for j in range(k)], axis=1) for o in (1, 2))
        time = result.axes[0].follower.time
        speed, acceleration = (reference.grid.at(time, x) for x in (v, a))
        fixed = ("clock",) if result.clock and result.late != result.zero else ()
        read = misread(*self.reference) if self.reference is not None else np.zeros(k)
        axes: list[AxisResidual] = []
        found: list[LogCorrelate] = []
        structured: set[tuple[int, str]] = set()
        off = np.full((len(time), k), np.nan)
        floors = np.full(k, np.nan)
        for one in result.axes:
            f, j = one.follower, one.follower.axis
            left = f.residual - f.effects(one.shape, result.late)
            left = left - left[f.use].mean()
            pace, late = _pace_and_lateness(f.residual, speed[:, j], f.use)
            known = _INSTANT * self.log.period * float(np.nan_to_num(pace))
            floor = math.hypot(noise_floor(self.log.time, left, speed, f.use), float(read[j]), known)
            before = math.sqrt(held_out(one.raw, ()).mean())
            after = math.sqrt(held_out(one.raw, (*fixed, *one.terms)).mean())
            unit = "m" if self.log.slides[j] else "rad"
            reach = float(np.ptp(reference.grid.values[:, j]))
            axes.append(AxisResidual(j + 1, "position", unit, before, after, floor, pace, reach, late))
            columns = _motion_columns(j, speed, acceleration, self.log.q)
            still = f.use & (np.abs(speed[:, j]) <= 0.01 * np.abs(speed[:, j]).max())
            moving = float(left[f.use & ~still].std()) if (f.use & ~still).any() else 0.0
            if moving > _FAR * floor or goes_with_motion(self.log.time, left, columns, f.use) < 1e-3:
                structured.add((j + 1, "position"))
                if after > 1.2 * floor:
                    found += correlates(j + 1, "position", left, columns | _others(self.log), f.use)
            floors[j] = floor
            raw = f.residual - (f.delay(result.zero) if result.zero else 0.0)
            off[:, j] = np.where(f.use, raw - raw[f.use].mean(), np.nan)
        live = [x.follower.axis for x in result.axes]
        moves = (
            late_moves(self.log.move, self.log.period, off[:, live], speed[:, live], floors[live])
            if self.log.move is not None
            else ()
        )
        return tuple(axes), tuple(found), structured, moves

    def _efforts(self) -> tuple[tuple[AxisResidual, ...], tuple[LogCorrelate, ...], set[tuple[int, str]]]:
        result, log = self.effort, self.log
        if result is None:
            return (), (), set()
        axes: list[AxisResidual] = []
        found: list[LogCorrelate] = []
        structured: set[tuple[int, str]] = set()
        read = misread(*self.efforts_of) if self.efforts_of is not None else np.zeros(self.log.q.shape[1])
        moved, others = result.moved, {n: v[result.rows] for n, v in _others(log).items()}
        for one in result.axes:
            use = np.isfinite(one.left)
            left = np.where(use, one.left, 0.0)
            floor = math.hypot(noise_floor(moved.time, left, moved.speed, use), float(read[one.axis]))
            axes.append(AxisResidual(one.axis + 1, one.signal, one.unit, one.before, one.after, floor))
            columns = _motion_columns(one.axis, moved.speed, moved.acceleration, moved.q)
            if MASSES in one.terms or goes_with_motion(moved.time, left, columns, use) < 1e-3:
                structured.add((one.axis + 1, one.signal))
            if one.after > 1.2 * floor:
                found += correlates(one.axis + 1, one.signal, left, columns | others, use)
        heavier = [
            one.axis + 1
            for one, seen in zip(result.axes, axes, strict=True)
            if MASSES in one.terms and seen.after > CLEAR * seen.floor
        ]
        if heavier:
            names = ", ".join(map(str, heavier))
            self.notes.append(
                f"inertia or gravity of axes {names} are not those of {result.against}: masses, or a load"
            )
        return tuple(axes), tuple(found), structured

    def _rivals(self) -> tuple[tuple[tuple[str, ...], ...], dict[str, tuple[Alternative, ...]]]:
        """Clock and lag, of what was named, when their shapes cannot be told apart by these motions."""
        result = self.position
        if result is None or not {n.evidence.term for n in self.named} & {"clock", "servo-lag"}:
            return (), {}
        lagging = any("servo-lag" in a.terms for a in result.axes)
        clock = min(result.scores.get(CLOCK, math.inf), math.inf)
        none = result.scores.get(NONE, math.inf)
        if lagging and not result.clock and clock < _RIVAL:
            return (("servo-lag", "clock"),), {"servo-lag": (Alternative("clock", clock),)}
        if result.clock and not lagging and none < _RIVAL:
            return (("clock", "servo-lag"),), {"clock": (Alternative("servo-lag", none),)}
        clocked = any(n.evidence.term == "clock" for n in self.named)
        if clocked and result.clock and lagging and none < _RIVAL:
            rival = Alternative("servo-lag", result.scores.get(BOTH, 0.0))
            return (("clock", "servo-lag"),), {"clock": (rival,)}
        return (), {}


_NEXT = (
    "run the same moves at the highest acceleration and with the shortest ramps: a lag rounds them, a late clock "
    "does not"
)


def _pace_and_lateness(residual: Floats, speed: Floats, use: Mask) -> tuple[float, float]:
    """RMS speed while the axis moves, and how late [s] it is: what a delay would leave is minus the speed times it."""
    moves = use & (np.abs(speed) > _STILL * np.abs(speed).max(initial=0.0))
    power = float((speed[moves] ** 2).sum())
    if not power > 0:
        return math.nan, math.nan
    off = residual[moves] - residual[use].mean()
    return math.sqrt(power / moves.sum()), -float((off * speed[moves]).sum()) / power


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
