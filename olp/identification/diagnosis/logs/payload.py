"""A load that the rigid bodies do not have: one mass for all axes, told from what it weighs in every pose."""

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
    left,
    products,
    solve,
)
from olp.identification.diagnosis.logs.statistics import student_quantile, student_tail
from olp.identification.diagnosis.logs.torque import LogMotion
from olp.identification.diagnosis.logs.whiten import autoregression, kept, order_of, runs, whiten
from olp.robots.model import Robot

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
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
    from olp.robots.dynamics import dynamic_model, inverse_dynamics
    from olp.robots.masses import Body

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
