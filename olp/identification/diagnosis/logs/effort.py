"""Torques and currents of all axes: which have friction that the rigid bodies leave out, and what blocks confirm."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.select import (
    BLOCKS,
    FOLDS,
    LibraryColumn,
    Products,
    best,
    criterion,
    gain,
    held_out_rms,
    intervals,
    left,
    products,
    solve,
)
from olp.identification.diagnosis.logs.series import autoregression, kept, order_of, runs, whiten
from olp.identification.diagnosis.logs.statistics import student_quantile, student_tail
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
                f"axis {axis + 1} hardly moves or turns one way only: its friction is not identified"
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

    from olp.robots.dynamics.torques import dynamic_model, inverse_dynamics

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
    errors = {t: (held_out_rms(raw, _without(terms, t)), held_out_rms(raw, terms)) for t in terms}
    friction = tuple(t for t in terms if t != MASSES)
    named = {columns[i].term: (float(s), float(w)) for i, s, w in zip(members, sizes, widths, strict=True)}
    return EffortResult(
        axis, signal, unit, data, terms,
        gains,
        {t: criterion(data.products, _without(terms, t)) - whole for t in terms},
        {t: named[t] for t in friction},
        errors,
        held_out_rms(raw, ()),
        # What other masses would explain has no name: it stays in the remainder.
        held_out_rms(raw, friction),
        left,
        _told(raw, terms),
    )  # fmt: skip


def _told(raw: Products, terms: tuple[str, ...]) -> bool:
    """Whether the other kind of friction would do clearly worse."""
    kinds = [t for t in terms if t in _KINDS]
    if len(kinds) != 1:
        return bool(kinds)
    other = tuple(k for k in _KINDS if k not in kinds)
    return held_out_rms(raw, _without(terms, *kinds) + other) > _APART * held_out_rms(raw, terms)


def _without(terms: tuple[str, ...], *gone: str) -> tuple[str, ...]:
    return tuple(t for t in terms if t not in gone)


# --- Payload ---
# A load that the rigid bodies do not have: one mass for all axes, told from what it weighs in every pose.

_FEWEST = 400  # samples of an axis
_HELPS = 1.05  # times: whitened RMS without over with; less is not worth a name
_SHARED = 2  # last columns before the residual: mass [kg], first moment along the flange's z [kg m]


@dataclass(frozen=True, slots=True, eq=False)
class PayloadEstimate:
    """`mass` [kg] and `centre` [m] along the flange's z with half-widths of 95 % intervals.

    `torque` (n, k) [Nm | N] of it.
    """

    mass: tuple[float, float]
    centre: tuple[float, float]
    gain: tuple[float, float]  # mean of ln of held-out squares without over with, p-value
    delta_bic: float
    heldout: tuple[float, float]  # RMS of whitened residuals over all axes without and with it
    torque: Floats

    @property
    def sure(self) -> bool:
        """Whether held-out blocks want it, it is more than nothing, and the mass is known to a quarter."""
        return (
            self.gain[0] > 0
            and self.gain[1] < 0.01
            and self.heldout[0] > _HELPS * self.heldout[1]
            and self.mass[0] > 4 * self.mass[1] > 0
        )


def payload(robot: Robot, moved: LogMotion, residual: Floats, usable: Mask) -> PayloadEstimate | None:
    """The load that explains `residual` (n, k) [Nm | N] of all axes; None where too little is known."""
    mass, moment = _columns(robot, moved)
    tables = []
    for axis in range(residual.shape[1]):
        speed = moved.speed[:, axis]
        soft = max(0.005 * float(np.quantile(np.abs(speed), 0.98)), 3 * float(moved.noise[axis]), 1e-6)
        own = np.stack([np.ones(len(speed)), speed, np.tanh(speed / soft)], axis=1)
        use = usable & np.isfinite(residual[:, axis])
        library = np.column_stack([own, mass[:, axis], moment[:, axis]])
        if use.sum() < _FEWEST or np.abs(mass[use, axis]).max() < 1e-6:
            continue
        fit = np.linalg.lstsq(library[use], residual[use, axis], rcond=1e-10)[0]
        run = runs(moved.time, use)
        order = order_of(run)
        a = autoregression(np.where(use, residual[:, axis] - library @ fit, 0.0), run, order)
        keep = kept(run, order)
        if keep.sum() < _FEWEST:
            continue
        white = products(
            whiten(library, a, keep),
            whiten(np.where(use, residual[:, axis], 0.0), a, keep),
            (LibraryColumn(""),) * 5,
        )
        tables.append(_scaled(white))
    return _shared(tables, mass, moment) if len(tables) >= 2 else None


def _columns(robot: Robot, moved: LogMotion) -> tuple[Floats, Floats]:
    """(n, k) torques of 1 kg in the flange, and of 1 kg m of first moment along its z."""
    from olp.robots.dynamics.torques import dynamic_model, inverse_dynamics
    from olp.robots.model import Body

    model = dynamic_model(robot)
    motion = moved.q, moved.speed, moved.acceleration
    bare = inverse_dynamics(model, *motion)
    here = inverse_dynamics(model, *motion, Body(1.0)) - bare
    small = 1e-3
    there = inverse_dynamics(model, *motion, Body(1.0, (0.0, 0.0, small))) - bare
    return here, (there - here) / small


def _scaled(table: Products) -> Products:
    """In units of the axis' own noise, so that axes can be added."""
    everything = tuple(range(table.blocks.shape[1] - 1))
    noise = left(table.total, everything, solve(table.total, everything)) / table.count.sum()
    return Products(table.blocks / max(noise, 1e-300), table.count, table.columns, table.prior)


def _reduced(gram: Floats) -> Floats:
    """Mass, moment and residual with the axis' own columns taken out."""
    own = gram.shape[0] - _SHARED - 1
    inside = np.linalg.pinv(gram[:own, :own], rcond=1e-12, hermitian=True)
    return np.asarray(gram[own:, own:] - gram[own:, :own] @ inside @ gram[:own, own:])


def _shared(tables: list[Products], mass: Floats, moment: Floats) -> PayloadEstimate | None:
    whole = np.sum([_reduced(t.total) for t in tables], axis=0)
    inside = whole[:_SHARED, :_SHARED]
    if np.linalg.matrix_rank(inside, hermitian=True) < _SHARED:
        return None
    inverse = np.linalg.inv(inside)
    sizes = inverse @ whole[:_SHARED, -1]
    count = sum(float(t.count.sum()) for t in tables)
    delta = whole[-1, -1] - float(whole[-1, :_SHARED] @ sizes)  # what it leaves, in units of noise
    delta_bic = float(whole[-1, -1] - delta - _SHARED * math.log(count))
    without, with_it = np.zeros(BLOCKS), np.zeros(BLOCKS)
    parts = []
    for fold in range(FOLDS):
        out = np.arange(BLOCKS) % FOLDS == fold
        grams = [t.blocks[~out].sum(axis=0) for t in tables]
        shared = np.sum([_reduced(g) for g in grams], axis=0)
        trained = np.linalg.solve(shared[:_SHARED, :_SHARED], shared[:_SHARED, -1])
        parts.append(trained)
        for table, gram in zip(tables, grams, strict=True):
            without += _errors(table, gram, out, np.zeros(_SHARED))
            with_it += _errors(table, gram, out, trained)
    ratio = np.log(without / with_it)
    spread = max(float(ratio.std(ddof=1)) / math.sqrt(BLOCKS), 1e-300)
    gain = float(ratio.mean()), student_tail(float(ratio.mean()) / spread, BLOCKS - 1)
    # Leave-one-fold-out sizes say what autocorrelation and wrong masses do to the estimate (jackknife).
    jack = np.sqrt((FOLDS - 1) / FOLDS * np.square(np.array(parts) - np.mean(parts, axis=0)).sum(axis=0))
    errors = np.maximum(1.96 * np.sqrt(np.diag(inverse)), student_quantile(FOLDS - 1) * jack)
    kilograms, metres = float(sizes[0]), float(sizes[1] / sizes[0]) if sizes[0] else math.nan
    about = math.hypot(float(errors[1]), metres * float(errors[0])) / max(abs(kilograms), 1e-12)
    rms = math.sqrt(without.sum() / count), math.sqrt(with_it.sum() / count)
    torque = sizes[0] * mass + sizes[1] * moment
    return PayloadEstimate((kilograms, float(errors[0])), (metres, about), gain, delta_bic, rms, torque)


def _errors(table: Products, trained: Floats, out: Mask, shared: Floats) -> Floats:
    """(b,) squares of the blocks `out` under sizes fitted on `trained`, the shared ones given."""
    own = trained.shape[0] - _SHARED - 1
    right = trained[:own, -1] - trained[:own, own:-1] @ shared
    sizes = np.concatenate([np.linalg.pinv(trained[:own, :own], rcond=1e-12, hermitian=True) @ right, shared])
    members = tuple(range(len(sizes)))
    return np.array([left(g, members, sizes) if o else 0.0 for g, o in zip(table.blocks, out, strict=True)])
