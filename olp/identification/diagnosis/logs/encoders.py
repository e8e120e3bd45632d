"""Compares an encoder behind the gear with the motor's: a delay between both channels, or a compliant gear?

Columns `q1_link_deg`, … of a log are the positions behind the gears. A compliant gear twists in proportion to its
torque, at any speed. A delay makes both channels differ in proportion to speed, by the same time for all axes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm
from olp.identification.diagnosis.logs.following import direction
from olp.identification.diagnosis.logs.select import (
    LibraryColumn,
    Products,
    best,
    gain,
    held_out_rms,
    intervals,
    products,
)
from olp.identification.diagnosis.logs.series import autoregression, hermite, kept, order_of, runs, whiten
from olp.identification.diagnosis.logs.torque import LogMotion
from olp.identification.recording.log import Log

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
SKEW, TWIST, PLAY = "clock", "joint-compliance", "backlash"
_COLUMNS = (LibraryColumn(""), LibraryColumn(SKEW), LibraryColumn(TWIST, positive=False), LibraryColumn(PLAY))
_ALIKE = 0.25  # of their mean: how far the axes' times may be apart and still be one clock
_LEAST = 0.1
_NO_TIME = 1e-5  # [s]


@dataclass(frozen=True, slots=True)
class EncoderAxis:
    """`late` [s]: link behind motor; `twist` [rad/Nm | rad s²/rad]; each with the half-width of its 95 % interval."""

    axis: int
    terms: tuple[str, ...]
    late: tuple[float, float]
    twist: tuple[float, float]
    play: tuple[float, float]
    by_torque: bool  # whether twist is per torque, not per acceleration
    gains: dict[str, tuple[float, float]]
    heldout: dict[str, tuple[float, float]]  # term -> RMS [rad | m] without and with it
    before: float  # [rad | m] RMS
    after: float


@dataclass(frozen=True, slots=True)
class Encoders:
    """`late` [s] with its 95 % interval when all axes agree on it, nan otherwise."""

    axes: tuple[EncoderAxis, ...]
    late: float
    low: float
    high: float


def link_columns(log: Log) -> dict[int, Floats]:
    """Axis (from 0) -> positions [rad | m] behind the gear."""
    found = {}
    for axis, slides in enumerate(log.slides):
        name = f"q{axis + 1}_link_{'mm' if slides else 'deg'}"
        if name in log.covariates:
            found[axis] = log.covariates[name] * (mm if slides else deg)
    return found


def encoders(log: Log, moved: LogMotion, usable: Mask) -> Encoders | None:
    """What the second encoders tell; None without them."""
    links = link_columns(log)
    # A delay is more than speed times time: at high acceleration the rest would pass for a twist.
    about = [_late(log, moved, usable, axis, link) for axis, link in links.items()]
    common = float(np.median(about)) if about else 0.0
    found = [
        a for axis, link in links.items() if (a := _axis(log, moved, usable, axis, link, common)) is not None
    ]
    if not found:
        return None
    late = np.array([a.late[0] for a in found if SKEW in a.terms])
    width = np.array([a.late[1] for a in found if SKEW in a.terms])
    if len(late) < 2 or np.ptp(late) > _ALIKE * abs(late.mean()) or len(late) < len(found):
        return Encoders(tuple(found), math.nan, math.nan, math.nan)
    weight = 1 / np.maximum(width, 1e-9) ** 2
    middle = float((weight * late).sum() / weight.sum())
    # Axes that disagree by more than their own intervals widen the common one.
    own = 1 / math.sqrt(float(weight.sum()))
    spread = 2 * float(late.std(ddof=1)) / math.sqrt(len(late))
    half = max(own, spread)
    return Encoders(tuple(found), middle, middle - half, middle + half)


def _late(log: Log, moved: LogMotion, usable: Mask, axis: int, link: Floats) -> float:
    """[s] by speed alone."""
    use = usable & np.isfinite(link)
    difference, speed = (link - log.q[:, axis])[use], moved.speed[use, axis]
    speed = speed - speed.mean()
    return -float((difference * speed).sum()) / max(float((speed**2).sum()), 1e-300)


def _axis(
    log: Log, moved: LogMotion, usable: Mask, axis: int, link: Floats, about: float
) -> EncoderAxis | None:
    speed = moved.speed[:, axis]
    if abs(about) > _NO_TIME:
        # The column of a delay of that very size, per second of it.
        shifted = hermite(log.time, log.q[:, axis : axis + 1], log.time - about)[:, 0]
        speed = (log.q[:, axis] - shifted) / about
    by_torque = log.torque is not None
    load = log.torque[:, axis] if log.torque is not None else moved.acceleration[:, axis]
    difference = link - log.q[:, axis]
    margin = (log.time > log.time[0] + 0.1) & (log.time < log.time[-1] - 0.1)
    use = usable & np.isfinite(difference) & np.isfinite(load) & margin
    if use.sum() < 400 or np.ptp(log.q[use, axis]) < 1e-3:
        return None
    library = np.stack(
        [np.ones(len(speed)), -speed, np.where(use, load, 0.0), -direction(log.q[:, axis])], axis=1
    )
    sizes = np.linalg.lstsq(library[use], difference[use], rcond=None)[0]
    run = runs(log.time, use)
    order = order_of(run)
    a = autoregression(np.where(use, difference - library @ sizes, 0.0), run, order)
    keep = kept(run, order)
    target = np.where(use, difference, 0.0)
    table = products(whiten(library, a, keep), whiten(target, a, keep), _COLUMNS)
    raw = products(library[use], target[use], _COLUMNS)
    terms = _large(best(table)[0], table, library[use], target[use])
    members, sizes, widths = intervals(table, terms)
    known = {_COLUMNS[i].term: (float(s), float(w)) for i, s, w in zip(members, sizes, widths, strict=True)}
    none = (math.nan, math.nan)
    errors = {
        t: (held_out_rms(raw, tuple(x for x in terms if x != t)), held_out_rms(raw, terms)) for t in terms
    }
    return EncoderAxis(
        axis, terms, known.get(SKEW, none), known.get(TWIST, none), known.get(PLAY, none), by_torque,
        {t: gain(table, terms, t) for t in terms}, errors,
        held_out_rms(raw, ()), held_out_rms(raw, terms),
    )  # fmt: skip


def _large(terms: tuple[str, ...], table: Products, library: Floats, target: Floats) -> tuple[str, ...]:
    """Without the terms that are a small part of what is left."""
    while True:
        members, sizes, _ = intervals(table, terms)
        rest = float((target - library[:, list(members)] @ sizes).std())
        amount = {
            _COLUMNS[i].term: float((library[:, i] * s).std())
            for i, s in zip(members, sizes, strict=True)
            if i
        }
        weak = [t for t in terms if amount[t] < _LEAST * rest]
        if not weak:
            return terms
        terms = tuple(t for t in terms if t != min(weak, key=lambda w: amount[w]))
