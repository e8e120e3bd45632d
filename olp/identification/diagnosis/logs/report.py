"""What is left after the confirmed terms, and everything that is said about it."""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.effort import Efforts
from olp.identification.diagnosis.logs.following import BOTH, CLOCK, NONE
from olp.identification.diagnosis.logs.pairing import Pairing
from olp.identification.diagnosis.logs.position import PositionResult
from olp.identification.diagnosis.logs.result import (
    AxisEvidence,
    AxisResidual,
    ClockFit,
    LogCorrelate,
    LogDiagnosis,
)
from olp.identification.diagnosis.logs.select import LibraryColumn, held_out, held_out_rms, products
from olp.identification.diagnosis.logs.series import (
    autoregression,
    dropped,
    gaps,
    kept,
    misread,
    order_of,
    rests,
    runs,
    whiten,
)
from olp.identification.diagnosis.logs.statistics import student_tail
from olp.identification.diagnosis.logs.torque import MASSES
from olp.identification.diagnosis.result import Alternative, Evidence, Finding, FittedParameter, MoveResidual
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
            before = held_out_rms(one.raw, ())
            after = held_out_rms(one.raw, (*fixed, *one.terms))
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
        """Return the groups of named terms that these motions cannot tell apart, and the alternatives of each term."""
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
    """Return the RMS speed [rad/s or m/s] of an axis while it moves, and its delay [s], fitted to `residual` (n,).

    A delay d leaves the residual -d times the speed. `use`: the samples that count.
    """
    moves = use & (np.abs(speed) > _STILL * np.abs(speed).max(initial=0.0))
    power = float((speed[moves] ** 2).sum())
    if not power > 0:
        return math.nan, math.nan
    off = residual[moves] - residual[use].mean()
    return math.sqrt(power / moves.sum()), -float((off * speed[moves]).sum()) / power


def _motion_columns(axis: int, speed: Floats, acceleration: Floats, q: Floats) -> dict[str, Floats]:
    """Return what the residual of an axis (from 0) may correlate with: name -> (n,) of the simulated motion."""
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


# --- Findings ---
# From what axes told to sentences: one finding per term, its numbers per axis.

_ORDER = (
    *(
        "clock",
        "servo-lag",
        "joint-compliance",
        "backlash",
        "viscous-friction",
        "coulomb-friction",
        "payload",
    ),
)


class ConfirmedTerm(NamedTuple):
    """One term of one axis (from 1; 0: all), confirmed. `numbers`: name -> parameter."""

    evidence: AxisEvidence
    numbers: dict[str, FittedParameter]
    moves: tuple[int, ...] = ()


def findings(named: list[ConfirmedTerm], rivals: dict[str, tuple[Alternative, ...]]) -> tuple[Finding, ...]:
    """Return one finding per term: clocks first, then physics; within each the terms that explain most first."""
    found = []
    for term in _ORDER:
        own = [n for n in named if n.evidence.term == term]
        if own:
            found.append(_finding(term, own, rivals.get(term, ())))
    return tuple(found)


def _finding(term: str, own: list[ConfirmedTerm], rivals: tuple[Alternative, ...]) -> Finding:
    numbers: dict[str, FittedParameter] = {}
    for n in own:
        axis = n.evidence.axis
        numbers |= {
            name if axis == 0 else f"{name} of axis {axis}": value for name, value in n.numbers.items()
        }
    moves = tuple(sorted({m for n in own for m in n.moves}))
    delta = sum(n.evidence.delta_bic for n in own if math.isfinite(n.evidence.delta_bic))
    evidence = Evidence(delta, min(n.evidence.p_value for n in own), math.nan, math.nan)
    return Finding(term, says(term, own), equation_of(term), numbers, moves, {}, evidence, rivals)


def equation_of(term: str) -> str:
    """Return the equation of a term in LaTeX, as its file in olp/timing/physics/ states it."""
    module = importlib.import_module(f"olp.timing.physics.{term.replace('-', '_')}")
    classes = [c for c in vars(module).values() if isinstance(c, type) and c.__module__ == module.__name__]
    return next(
        (str(c.equation) for c in classes if hasattr(c, "equation")), r"\tau = m\,J^{\mathsf T}(\ddot x - g)"
    )


def says(term: str, own: list[ConfirmedTerm]) -> str:
    """Return the sentence that tells a term, with the fitted numbers of each axis."""
    parts = []
    for n in own:
        axis = n.evidence.axis
        values = dict(n.numbers)
        parts.append(_clause(term, axis, values))
    start = _TWISTED if all("stiffness" in n.numbers for n in own) else _START[term]
    return start + "; ".join(parts)


_TWISTED = "axes yield to their torques: "
_START = {
    "clock": "the recorder's clock: ",
    "servo-lag": "axes follow late by a time constant: ",
    "joint-compliance": "axes oscillate after acceleration changes: ",
    "backlash": "a dead band at reversals: ",
    "viscous-friction": "torque against motion in proportion to speed: ",
    "coulomb-friction": "torque against motion at any speed: ",
    "payload": "more mass is carried: ",
}


def _clause(term: str, axis: int, values: dict[str, FittedParameter]) -> str:
    where = f"axis {axis} " if axis else ""
    if term == "clock":
        texts = []
        for name, p in values.items():
            if p.unit == "s":
                texts.append(f"{name} {p.value * 1000:.4g} ms ({p.low * 1000:.4g} to {p.high * 1000:.4g})")
            else:
                texts.append(f"{name} {p.value:.6f} ({p.low:.6f} to {p.high:.6f})")
        return ", ".join(texts)
    if term == "servo-lag":
        return where + f"{next(iter(values.values())).value * 1000:.3g} ms"
    if term == "joint-compliance" and "frequency" in values:
        return where + f"{values['frequency'].value:.3g} Hz, damping {values['damping'].value:.2g}"
    if term == "backlash":
        p = next(iter(values.values()))
        return where + (f"{math.degrees(p.value):.2g}°" if p.unit == "rad" else f"{p.value * 1000:.3g} mm")
    p = next(iter(values.values()))
    return where + f"{p.value:.3g} {p.unit}"


# --- Moves ---
# Where in a program the axes are off: per numbered move, how late, and in which phase most.

_MOVES_STILL = 0.02  # of the move's greatest pace
_STEADY = 0.05  # of it: change of pace over a phase's sample


def late_moves(
    move: NDArray[np.int64], period: float, residual: Floats, speed: Floats, floor: Floats
) -> tuple[MoveResidual, ...]:
    """Return, for each numbered move of a log, its delay [s] and the phase in which the axes are off most.

    `move` (n,): the move of each sample, -1 for none. `period` [s]: between samples. `residual` (n, k), `speed` (n, k)
    and `floor` (k,), the noise, are in the units of each of the k axes; `residual` is nan where a sample is not used.
    Moves of fewer than 8 samples are left out.
    """
    found = []
    scale = np.maximum(floor, 1e-12)
    for number in np.unique(move[move >= 0]).tolist():
        rows = np.nonzero((move == number) & np.isfinite(residual).all(axis=1))[0]
        if len(rows) < 8:
            continue
        off, pace = residual[rows] / scale, speed[rows] / scale
        power = float((pace**2).sum())
        late = -float((pace * off).sum()) / max(power, 1e-300)
        error = 1 / math.sqrt(max(power, 1e-300))
        clear = abs(late) > max(4 * error, 0.02 * period)
        found.append(MoveResidual(int(number), None, None, _phase(off, speed[rows]), late, bool(clear)))
    return tuple(found)


def _phase(off: Floats, speed: Floats) -> str:
    """Return the phase (settle, cruise, accelerate, decelerate) that has the largest share of the squared residuals."""
    pace = np.sqrt((speed**2).sum(axis=1))
    top = float(pace.max(initial=0.0))
    change = np.gradient(pace)
    still = pace < _MOVES_STILL * top
    steady = np.abs(change) < _STEADY * max(float(np.abs(change).max(initial=0.0)), 1e-300)
    squares = (off**2).sum(axis=1)
    parts = {
        "settle": still,
        "cruise": ~still & steady,
        "accelerate": ~still & ~steady & (change > 0),
        "decelerate": ~still & ~steady & (change < 0),
    }
    return max(parts, key=lambda name: float(squares[parts[name]].sum()))


# --- Residuals ---
# Noise of an axis, what its rest goes together with, and the verdict.

CLEAR = 1.5  # times the noise: less is not called a mismatch
_MOST_CORRELATES = 3
_CERTAIN = 1e-3
_WHOLE = 0.9  # of the mismatch's squares: more is explained, not partly


def noise_floor(time: Floats, residual: Floats, speed: Floats, use: Mask) -> float:
    """Return the RMS noise of a residual (n,) that no motion causes, in its unit: the larger of two estimates.

    One is the scatter around the mean of each rest, the other that between neighbouring samples.
    """
    third = np.diff(residual, 3)
    good = use[3:] & use[:-3]
    white = 1.4826 * float(np.median(np.abs(third[good]))) / math.sqrt(20.0) if good.any() else math.nan
    squares, freedom = 0.0, 0
    for begin, end in rests(time, speed, 0.15):
        # The first half of a rest belongs to what still swings.
        part = residual[(begin + end) // 2 : end + 1]
        part = part[use[(begin + end) // 2 : end + 1]]
        if len(part) > 8:
            squares += float(((part - part.mean()) ** 2).sum())
            freedom += len(part) - 1
    still = math.sqrt(squares / freedom) if freedom > 60 else 0.0
    return max(white, still)


def goes_with_motion(time: Floats, residual: Floats, motion: dict[str, Floats], use: Mask) -> float:
    """Return the p-value of the test that the `motion` columns predict a residual on held-out blocks of samples."""
    library = np.column_stack([np.ones(len(residual)), *motion.values()])
    run = runs(time, use)
    order = order_of(run)
    a = autoregression(np.where(use, residual, 0.0), run, order)
    keep = kept(run, order)
    if keep.sum() < 300:
        return 1.0
    columns = (LibraryColumn(""), *(LibraryColumn("motion") for _ in motion))
    table = products(whiten(library, a, keep), whiten(np.where(use, residual, 0.0), a, keep), columns)
    ratio = np.log(held_out(table, ()) / held_out(table, ("motion",)))
    spread = max(float(ratio.std(ddof=1)) / math.sqrt(len(ratio)), 1e-300)
    return student_tail(float(ratio.mean()) / spread, len(ratio) - 1)


def correlates(
    axis: int, signal: str, residual: Floats, columns: dict[str, Floats], use: Mask
) -> tuple[LogCorrelate, ...]:
    """Return the columns that correlate with a residual, strongest first.

    Neighbouring samples of a log are alike: they count by their effective number, after the correlation of neighbours.
    """
    rest = residual[use] - residual[use].mean()
    found = []
    for name, values in columns.items():
        other = values[use]
        if not np.isfinite(other).all() or other.std() <= 1e-9 * max(float(np.abs(other).max()), 1e-9):
            continue
        for kind, left in (("", rest), ("size of the rest with ", np.abs(rest) - np.abs(rest).mean())):
            if not left.std() > 0:
                continue
            r = float(np.corrcoef(left, other)[0, 1])
            alike = _memory(left) * _memory(other - other.mean())
            count = max(len(left) * (1 - alike) / (1 + alike), 3.0)
            t = abs(r) * math.sqrt((count - 2) / max(1 - r * r, 1e-12))
            p = min(2 * student_tail(t, count - 2), 1.0)
            if p < _CERTAIN and abs(r) > 0.1:
                found.append(LogCorrelate(axis, signal, kind + name, r, p))
    return tuple(sorted(found, key=lambda c: -abs(c.statistic))[:_MOST_CORRELATES])


def _memory(values: Floats) -> float:
    """Return the correlation of neighbouring values, from 0 to just below 1."""
    power = float(values @ values)
    return float(np.clip(values[1:] @ values[:-1] / max(power, 1e-300), 0.0, 0.99999))


def verdict_of(axes: tuple[AxisResidual, ...], named: bool, structured: set[tuple[int, str]]) -> str:
    """Return the verdict on the axes whose signals were compared. `named`: whether a term is confirmed.

    `structured`: the (axis, signal) whose remaining residual correlates with the motion.
    """
    if not axes:
        return "not-judged"
    before = after = 0.0
    open_ends = False
    for a in axes:
        unit = max(a.floor if math.isfinite(a.floor) else a.after, 1e-9 * a.before, 1e-12)
        gone = max((a.before**2 - unit**2) / unit**2, 0.0)
        rest = max((a.after**2 - unit**2) / unit**2, 0.0)
        before, after = before + gone, after + rest
        open_ends |= a.after > CLEAR * unit and (a.axis, a.signal) in structured
    if not named:
        return "unexplained" if open_ends else "no-mismatch"
    if not open_ends or after <= (1 - _WHOLE) * before:
        return "explained"
    return "partly-explained"
