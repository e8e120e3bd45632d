"""Torques and currents of all axes: which have friction that the rigid bodies leave out, and what blocks confirm."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.payload import PayloadEstimate, payload
from olp.identification.diagnosis.logs.select import Products, best, criterion, gain, held_out, intervals
from olp.identification.diagnosis.logs.torque import (
    MASSES,
    AxisTorque,
    LogMotion,
    axis_torque,
    motion,
    rigid_basis,
)
from olp.identification.recording.log import Log
from olp.robots.model import Robot

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
FITTED = "fitted rigid bodies"
_MOST = 36_000  # samples that are looked at
_STRIPES = 36
_LEAST = 0.1  # of what is left: an effect of less is not named
# Of innovations' squares on held-out blocks. Less is what another axis' effect leaks into this one: no noise, so
# significant, but it has no friction's course in time.
_LEAST_GAIN = 0.02
# Times: held-out RMS with the other kind of friction over that with the chosen one; less does not tell which it is.
_APART = 1.1
_KINDS = ("viscous-friction", "coulomb-friction")


@dataclass(frozen=True, slots=True, eq=False)
class EffortResult:
    """One axis. `sizes`: term -> value and half-width of the 95 % interval, in `unit` per unit of the column."""

    axis: int
    signal: str  # torque or current
    unit: str
    data: AxisTorque
    terms: tuple[str, ...]
    gains: dict[str, tuple[float, float]]
    delta_bic: dict[str, float]
    sizes: dict[str, tuple[float, float]]
    heldout: dict[str, tuple[float, float]]  # term -> RMS without and with it on blocks that no fit saw
    before: float
    after: float
    left: Floats  # (n,) nan where not used
    told: bool  # whether one kind of friction explains clearly more than the other


@dataclass(frozen=True, slots=True, eq=False)
class Efforts:
    moved: LogMotion  # of the samples that were looked at
    rows: NDArray[np.intp]  # their places in the log
    axes: tuple[EffortResult, ...]
    load: PayloadEstimate | None
    against: str  # what was taken out of the torques, in words
    notes: tuple[str, ...]
    fitted: frozenset[int] = (
        frozenset()
    )  # axes (from 0) whose rigid bodies were fitted, for want of anything else


def efforts(log: Log, simulated: Floats | None, usable: Mask, robot: Robot | None) -> Efforts | None:
    """Every axis with a torque or a current. `simulated` (n, k) torques or currents at the samples, nan of axes that
    have none, or None."""
    measured, signal = (log.torque, "torque") if log.torque is not None else (log.current, "current")
    if measured is None:
        return None
    moved = motion(log)
    rigid = None
    notes = []
    if simulated is not None:
        against = "the simulated " + ("torques" if signal == "torque" else "currents")
    else:
        rigid = _model_torques(robot, moved) if signal == "torque" else None
        against = f"the masses of {robot.name}" if rigid is not None and robot is not None else FITTED
        if rigid is None:
            notes.append(
                "no simulated torques and no masses: inertia and gravity were fitted per axis beside friction"
            )
    results = []
    rows = _stripes(len(log))
    moved, usable, measured = moved.take(rows), usable[rows], measured[rows]
    simulated = simulated[rows] if simulated is not None else None
    rigid = rigid[rows] if rigid is not None else None
    taken = simulated if simulated is not None else rigid
    load = None
    if signal == "torque" and robot is not None and robot.dynamics is not None and taken is not None:
        load = payload(robot, moved, measured - taken, usable)
        if load is not None and load.sure:
            measured = measured - load.torque
    fitted = list[int]()
    for axis in range(measured.shape[1]):
        if not np.isfinite(measured[:, axis]).any():
            notes.append(f"axis {axis + 1} has no {signal} in the log")
            continue
        values = np.where(usable, measured[:, axis], np.nan)
        basis = rigid_basis(moved, axis, log.slides)
        if simulated is not None and np.isfinite(simulated[:, axis]).any():
            data = _axis(moved, values - simulated[:, axis], basis[:, :1], axis, basis[:, 1:])
        elif rigid is not None:
            data = _axis(moved, values - rigid[:, axis], basis[:, :1], axis, basis[:, 1:])
        else:
            fitted.append(axis)
            data = _axis(moved, values, basis, axis, None)
        if data is None:
            notes.append(
                f"axis {axis + 1} hardly moves or turns one way only: nothing is told of its friction"
            )
            continue
        slides = log.slides[axis]
        unit = "A" if signal == "current" else "N" if slides else "Nm"
        results.append(judge_axis(data, axis, signal, unit))
    if simulated is not None and fitted:
        names = ", ".join(str(axis + 1) for axis in fitted)
        notes.append(f"no simulated {signal}s of axes {names}: inertia and gravity were fitted there")
    return Efforts(
        moved,
        rows,
        tuple(_of_one_kind(results)),
        load if load is not None and load.sure else None,
        against,
        tuple(notes),
        frozenset(fitted),
    )


def _of_one_kind(results: list[EffortResult]) -> list[EffortResult]:
    """An axis that does not tell which kind of friction it has, has the kind of those that do."""
    kinds = {t for r in results if r.told for t in r.terms} & set(_KINDS)
    if len(kinds) != 1:
        return results
    banned = tuple(set(_KINDS) - kinds)
    return [r if r.told else judge_axis(r.data, r.axis, r.signal, r.unit, banned) for r in results]


def _stripes(count: int) -> NDArray[np.intp]:
    """Rows of at most about `_MOST` samples of a long log, in stretches spread over all of it."""
    if count <= 1.5 * _MOST:
        return np.arange(count)
    edges = np.linspace(0, count, _STRIPES + 1).astype(int)[:-1]
    return np.asarray((edges[:, None] + np.arange(_MOST // _STRIPES)[None, :]).ravel())


def _axis(
    moved: LogMotion, residual: Floats, base: Floats, axis: int, masses: Floats | None
) -> AxisTorque | None:
    extra = tuple((MASSES, column) for column in masses.T) if masses is not None else ()
    return axis_torque(moved, residual, base, axis, extra)


def _model_torques(robot: Robot | None, moved: LogMotion) -> Floats | None:
    if robot is None or robot.dynamics is None:
        return None
    from dataclasses import replace

    from olp.robots.dynamics import dynamic_model, inverse_dynamics

    frictionless = tuple(d._replace(viscous=0.0, coulomb=0.0) for d in robot.dynamics.drives)
    smooth = replace(robot, dynamics=replace(robot.dynamics, drives=frictionless))
    return inverse_dynamics(dynamic_model(smooth), moved.q, moved.speed, moved.acceleration)


def judge_axis(
    data: AxisTorque, axis: int, signal: str, unit: str, banned: tuple[str, ...] = ()
) -> EffortResult:
    """The best set of terms without `banned`; each stays while it is large enough and its BIC wants it."""
    _, scores = best(data.products)
    terms = min((s for s in scores if not set(s) & set(banned)), key=lambda s: scores[s])
    while True:
        members, sizes, widths = intervals(data.products, terms)
        columns = data.products.columns
        all_sizes = np.zeros(len(columns))
        all_sizes[list(members)] = sizes
        left = np.where(data.use, data.residual - data.library @ all_sizes, np.nan)
        rest = float(np.nanstd(left))
        amount = {}
        for term in terms:
            index = [i for i, c in enumerate(columns) if c.term == term]
            amount[term] = float((data.library[data.use][:, index] @ all_sizes[index]).std())
        gains = {t: gain(data.products, terms, t) for t in terms}
        weak = [t for t in terms if amount[t] < _LEAST * rest or (t != MASSES and gains[t][0] < _LEAST_GAIN)]
        if not weak:
            break
        worst = min(weak, key=lambda t: amount[t])
        terms = tuple(t for t in terms if t != worst)
    whole = criterion(data.products, terms)
    raw = data.raw
    # Where innovations and torques themselves say something else, the columns are not quite those of the robot; and
    # what hangs on how long speeds are smoothed is not known better than that.
    _, other, _ = intervals(raw, terms)
    _, slower, _ = intervals(data.slower, terms)
    widths = np.sqrt(widths**2 + (sizes - other) ** 2 + (other - slower) ** 2)
    errors = {t: (_rms(held_out(raw, _without(terms, t))), _rms(held_out(raw, terms))) for t in terms}
    friction = tuple(t for t in terms if t != MASSES)
    named = {columns[i].term: (float(s), float(w)) for i, s, w in zip(members, sizes, widths, strict=True)}
    return EffortResult(
        axis, signal, unit, data, terms,
        gains,
        {t: criterion(data.products, _without(terms, t)) - whole for t in terms},
        {t: named[t] for t in friction},
        errors,
        _rms(held_out(raw, ())),
        # What other masses would explain has no name: it stays in the remainder.
        _rms(held_out(raw, friction)),
        left,
        _told(raw, terms),
    )  # fmt: skip


def _told(raw: Products, terms: tuple[str, ...]) -> bool:
    """Whether the other kind of friction would do clearly worse."""
    kinds = [t for t in terms if t in _KINDS]
    if len(kinds) != 1:
        return bool(kinds)
    other = tuple(k for k in _KINDS if k not in kinds)
    return _rms(held_out(raw, _without(terms, *kinds) + other)) > _APART * _rms(held_out(raw, terms))


def _without(terms: tuple[str, ...], *gone: str) -> tuple[str, ...]:
    return tuple(t for t in terms if t not in gone)


def _rms(squares: Floats) -> float:
    return math.sqrt(max(float(squares.mean()), 0.0))
