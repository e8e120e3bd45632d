"""The runs that an experiment is chosen from: straight moves that are known to be possible, as a hypothetical case.

Parts of recorded lines, both ways, at speeds that were recorded or that the axes can follow; where the robot is known
also lines between points of the recorded box that `olp probe` proves. A run is one move from stop to stop, or a line in
two halves with the point between them passed with and without rounding.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, fields, replace
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.units import mm
from olp.identification.diagnosis.axis_rates import PLACES, rates_of
from olp.identification.recording.moves import LINEAR, RecordedMoves
from olp.robots.geometry import rotation_from_angles
from olp.timing.physics._case import Floats, MeasuredMoves, Rates
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import MoveTerm

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording


Labels = NDArray[np.int64]

_PARTS = (1.0, 0.5, 0.25, 0.1)  # of a line
_STROKE = 2 * mm  # and one that is too short for any speed
_SPEEDS = (
    0.01,
    0.1,
    0.25,
    0.5,
    1.0,
    1.5,
)  # of the fastest recorded; above 1 only where the axes can be checked
_LONGEST = 20.0  # [s] at the programmed speed
_OF_RATED = 0.9
_PACE = 0.1 * mm  # [m/s] speeds are written to this
_MOST_LOADS = 3
_USUAL_ROUNDING = 25 * mm


@dataclass(frozen=True, slots=True, eq=False)
class CandidateMoves:
    """r rows of hypothetical moves; the rows of a run stand together."""

    case: MeasuredMoves
    run: Labels  # (r,) 0, 1, …
    line: Labels  # (r,) which line

    def __len__(self) -> int:
        return int(self.run[-1]) + 1 if len(self.run) else 0

    @property
    def first(self) -> Labels:
        """(runs,) the first row of each run."""
        return np.asarray(np.searchsorted(self.run, np.arange(len(self))))

    @property
    def rounded(self) -> NDArray[np.bool_]:
        """(runs,) runs in two moves with a rounded point between; the run before is the same with a stop there."""
        return np.asarray(self.case.blend[self.first] > 0)


class _Row(NamedTuple):
    run: int
    line: int
    begin: float  # share of the line
    end: float
    speed: float
    blend_start: float
    blend: float
    load: int
    when: float


def candidates(
    case: MeasuredMoves, recording: Recording, terms: Collection[MoveTerm]
) -> CandidateMoves | None:
    """Runs to choose from, None where the recording has no straight move with tool points. Raises OlpError (K…).

    `terms`: what may be at work; loads and running time are varied only where one of them depends on it.
    """
    straight = np.nonzero(case.moving & ~case.joint & (np.nan_to_num(case.length) > SHORTEST))[0]
    if not len(straight):
        return None
    lines = lines_of(case, recording, straight)
    loads = _loads(case) if any(term.name.startswith("payload") for term in terms) else _loads(case)[:1]
    times = _times(case, any(term.by_time for term in terms))
    rows = _rows(case, lines, len(loads), times, straight)
    return _as_case(case, lines, rows, loads, straight) if rows else None


# --- runs -------------------------------------------------------------------------------------------------------------


def _loads(case: MeasuredMoves) -> list[tuple[float, float]]:
    """[kg], [kg m²] that were recorded: the lightest, the heaviest, and one between."""
    both = np.round(np.stack([case.payload, case.payload_inertia], axis=1), 6)[case.moving]
    # Not a number is not equal to itself: what was not written is one load too.
    _, first = np.unique(np.nan_to_num(both, nan=-1.0), axis=0, return_index=True)
    both = both[first]
    if len(both) > _MOST_LOADS:
        both = both[np.linspace(0, len(both) - 1, _MOST_LOADS).round().astype(int)]
    return [(float(mass), float(inertia)) for mass, inertia in both]


def _times(case: MeasuredMoves, matters: bool) -> list[float]:
    """[s] on the recorder's clock: its end, and where running time matters its begin."""
    if not np.isfinite(case.t_start).all() or np.ptp(case.t_start) <= 0:
        return [float("nan")]
    last = float(case.t_start.max())
    return [float(case.t_start.min()), last] if matters else [last]


def _rows(
    case: MeasuredMoves, lines: StraightLines, loads: int, times: list[float], straight: Labels
) -> list[_Row]:
    top = float(case.base.speed[straight].max())
    rounding = usual_rounding(case)
    rows: list[_Row] = []
    run = 0
    for line, share in product(range(len(lines.start)), _SPEEDS):
        whole, speed = float(lines.length[line]), round(round(share * top / _PACE) * _PACE, 7)
        if speed <= 0 or not _possible(case, lines, line, speed):
            continue
        parts = [p for p in _PARTS if SHORTEST <= p * whole <= _LONGEST * speed] + [_STROKE / whole]
        for load, when in product(range(loads), times):
            for part, back in product(parts, (False, True)):
                begin, end = (1.0, 1.0 - part) if back else (0.0, part)
                rows.append(_Row(run, line, begin, end, speed, 0.0, 0.0, load, when))
                run += 1
            if 1.0 not in parts or whole < 4 * SHORTEST:
                continue
            for radius in (0.0, min(rounding, whole / 4)):
                rows.append(_Row(run, line, 0.0, 0.5, speed, 0.0, radius, load, when))
                rows.append(_Row(run, line, 0.5, 1.0, speed, radius, 0.0, load, when))
                run += 1
    return rows


def usual_rounding(case: MeasuredMoves) -> float:
    """[m] The middle of the recorded roundings."""
    rounded = case.blend[np.nan_to_num(case.blend) > 0]
    return float(np.median(rounded)) if len(rounded) else _USUAL_ROUNDING


def _possible(case: MeasuredMoves, lines: StraightLines, line: int, speed: float) -> bool:
    """Nothing faster than recorded, but where every axis stays below its rated speed all along."""
    rated = case.rates.rated if case.rates is not None and case.rates.exact else None
    if lines.rates is None or not lines.checked[line] or rated is None:
        return speed <= max(float(lines.fastest[line]), 0.0) * 1.001
    return bool(np.all(np.abs(lines.rates[line]).max(axis=0) * speed <= _OF_RATED * rated))


# --- the hypothetical case --------------------------------------------------------------------------------------------


def _as_case(
    case: MeasuredMoves,
    lines: StraightLines,
    rows: list[_Row],
    loads: list[tuple[float, float]],
    straight: Labels,
) -> CandidateMoves:
    table = np.array(rows)
    line = table[:, 1].astype(np.int64)
    way = (lines.end - lines.start)[line]
    start, end = (lines.start[line] + table[:, [k]] * way for k in (2, 3))
    blend_start, blend = table[:, 5], table[:, 6]
    load = np.array(loads)[table[:, 7].astype(int)]
    base = _motion(case, straight, np.linalg.norm(end - start, axis=1), table[:, 4], blend_start, blend)
    count = len(rows)
    no = np.zeros(count, dtype=bool)
    none = np.full(count, -1, dtype=np.int64)
    length = base.duration()
    hypothetical = replace(
        case,
        move=int(case.move.max()) + 1 + np.arange(count),
        measured=length,
        simulated=length,
        base=base,
        moving=~no,
        joint=no,
        start=start,
        end=end,
        turn=np.zeros(count),
        stop_start=blend_start == 0.0,
        stop_end=blend == 0.0,
        blend=blend,
        blend_start=blend_start,
        corner=np.zeros(count),
        payload=load[:, 0],
        payload_inertia=load[:, 1],
        t_start=table[:, 8],
        cycle=none,
        job=("",) * count,
        line=np.zeros(count, dtype=np.int64),
        rates=_rates(case, lines, line, table[:, 2], table[:, 3]),
        covariates={name: np.full(count, np.median(v)) for name, v in case.covariates.items()},
        repeats=np.arange(count) + int(case.repeats.max(initial=-1)) + 1
        if len(case.repeats)
        else case.repeats,
        place=np.arange(count) + int(case.place.max(initial=-1)) + 1,
        sim_payload=_middle(case.sim_payload, count),
        sim_payload_inertia=_middle(case.sim_payload_inertia, count),
        override=_middle(case.override, count),
        partners=None,
        wider=None,
        derived={},
    )
    return CandidateMoves(hypothetical, table[:, 0].astype(np.int64), line)


def _middle(told: Floats, count: int) -> Floats:
    """(count,) the middle of what was told, nan where it never was; nothing where there is no such column."""
    known = told[np.isfinite(told)]
    return np.full(count if len(told) else 0, np.median(known) if len(known) else np.nan)


def _motion(
    case: MeasuredMoves, straight: Labels, way: Floats, speed: Floats, blend_start: Floats, blend: Floats
) -> Motion:
    """What the judged simulation would use: the middle of what it used for straight moves."""
    base, count = case.base, len(way)
    middle = {
        name: np.full(count, np.median(getattr(base, name)[straight]))
        for name in (
            "accelerate",
            "decelerate",
            "jerk",
            "rate",
            "filtered",
            "build",
            "open_start",
            "open_end",
        )
    }
    return replace(
        _passing(base),
        way=way,
        speed=speed,
        round_start=blend_start,
        round_end=blend,
        least=np.zeros(count),
        added=np.zeros(count),
        corners=None,
    ).with_(**middle)


def _passing(base: Motion) -> Motion:
    """Where no recorded corner is rounded, nothing tells how the simulation passes one: at full speed."""
    return base if (base.round_end > 0).any() else base.with_(law="full", overlap=1.0, split=0.5)


def _rates(
    case: MeasuredMoves, lines: StraightLines, line: Labels, begin: Floats, end: Floats
) -> Rates | None:
    """Rates along parts of lines; backwards the axes turn the other way."""
    if case.rates is None or lines.rates is None:
        return None
    share = begin[:, None] + (end - begin)[:, None] * np.linspace(0.0, 1.0, PLACES)
    at = np.clip(share * (PLACES - 1), 0.0, PLACES - 1)
    low = np.minimum(at.astype(np.int64), PLACES - 2)
    over = at - low

    def between(values: Floats) -> Floats:
        first, second = values[line[:, None], low], values[line[:, None], low + 1]
        weight = over.reshape(*over.shape, *([1] * (values.ndim - 2)))
        return np.asarray(first * (1.0 - weight) + second * weight)

    path = between(lines.rates) * np.sign(end - begin)[:, None, None]
    bodies = None if case.rates.bodies is None else between(lines.bodies)
    return replace(case.rates, path=path, known=lines.checked[line], bodies=bodies, lifts=None, climb=None)


def joined(case: MeasuredMoves, more: MeasuredMoves) -> MeasuredMoves:
    """The rows of both, so that what a term takes from the whole recording stays what it was."""
    both: dict[str, object] = {}
    for column in fields(MeasuredMoves):
        first, second = getattr(case, column.name), getattr(more, column.name)
        if isinstance(first, np.ndarray):
            both[column.name] = np.concatenate([first, second])
    base = {
        column.name: np.concatenate([getattr(case.base, column.name), getattr(more.base, column.name)])
        for column in fields(Motion)
        if isinstance(getattr(case.base, column.name), np.ndarray)
    }
    rates = case.rates
    if rates is not None and more.rates is not None:
        path = np.concatenate([rates.path, more.rates.path])
        bodies = None
        if rates.bodies is not None and more.rates.bodies is not None:
            bodies = np.concatenate([rates.bodies, more.rates.bodies])
        # Of joint moves, and what is joined to a recording is lines.
        lifts, climb = (
            None if of is None else np.concatenate([of, np.full((len(more), *of.shape[1:]), np.nan)])
            for of in (rates.lifts, rates.climb)
        )
        known = np.concatenate([rates.known, more.rates.known])
        rates = replace(rates, path=path, known=known, bodies=bodies, lifts=lifts, climb=climb)
    return replace(
        case,
        base=replace(_passing(case.base), corners=None, **base),  # type: ignore[arg-type]
        partners=None,
        wider=None,
        job=case.job + more.job,
        rates=rates,
        covariates={name: np.concatenate([v, more.covariates[name]]) for name, v in case.covariates.items()},
        derived={},
        **both,  # type: ignore[arg-type]
    )


# --- Next lines ---
# Straight lines that are known to be possible: those that were run, and those that `olp probe` proves in their box.

_MOST = 10  # recorded lines and proved lines, each
SHORTEST = 10 * mm


class StraightLines(NamedTuple):
    """m straight lines. `rates` (m, 21, k) per metre, None: axes are not known; `checked` (m,): rates are known."""

    start: Floats  # (m, 3) [m]
    end: Floats  # (m, 3) [m]
    fastest: Floats  # (m,) [m/s] that was run there; 0 where nothing was
    rates: Floats | None
    checked: NDArray[np.bool_]
    bodies: Floats  # (m, 21, 2, 3) [m] elbow and wrist centre, nan where not known

    @property
    def length(self) -> Floats:
        return np.asarray(np.linalg.norm(self.end - self.start, axis=1))


def lines_of(case: MeasuredMoves, recording: Recording, straight: Labels) -> StraightLines:
    kept = _spread(case.start[straight], case.end[straight])
    rows = straight[kept]
    top = float(case.base.speed[straight].max())
    rates = case.rates
    path = None if rates is None else rates.path[rows]
    known = np.zeros(len(rows), dtype=bool) if rates is None else rates.known[rows]
    start, end = case.start[rows], case.end[rows]
    recorded = StraightLines(start, end, case.base.speed[rows], path, known, _bodies(rates, rows))
    further = _proved(recording, case, straight, top) if rates is not None and rates.exact else None
    if further is None:
        return recorded
    assert path is not None
    assert further.rates is not None
    had = np.concatenate([recorded.start, recorded.end], axis=1)
    had = np.concatenate([had, np.roll(had, 3, axis=1)])
    more = np.concatenate([further.start, further.end], axis=1)
    new = np.abs(more[:, None] - had[None]).max(axis=2).min(axis=1) > SHORTEST
    pairs = zip(recorded, further, strict=True)
    return StraightLines(*(np.concatenate([a, b[new]]) for a, b in pairs))  # type: ignore[index]


def _proved(
    recording: Recording, case: MeasuredMoves, straight: Labels, speed: float
) -> StraightLines | None:
    """Lines between points of the recorded box that can be run at the fastest recorded speed."""
    from olp.identification.probe.reach import candidates as lines_in
    from olp.identification.signature.axis_paths import has_axes

    robot, moves = recording.robot, recording.moves
    angles = usual_angles(recording)
    if robot is None or not has_axes(robot) or len(robot.axes) != 6 or angles is None:
        return None
    points = np.concatenate([case.start[straight], case.end[straight]])
    box = np.stack([points.min(axis=0), points.max(axis=0)], axis=1)
    if not (np.ptp(box, axis=1) > SHORTEST).any():
        return None
    shortest = 0.3 * float(np.linalg.norm(box[:, 1] - box[:, 0]))
    found = lines_in(robot, box, rotation_from_angles(angles), recording.tool, speed, shortest)
    if not len(found.starts):
        return None
    start, end = found.points[found.starts], found.points[found.ends]
    kept = _spread(start, end)
    start, end = start[kept], end[kept]
    hypothetical = replace(recording, moves=straight_moves(moves, start, end, angles))
    rates, _ = rates_of(hypothetical, np.arange(len(start)), np.linalg.norm(end - start, axis=1))
    if rates is None:
        return None
    bodies = _bodies(rates, np.arange(len(start)))
    return StraightLines(start, end, np.zeros(len(start)), rates.path, rates.known, bodies)


def _bodies(rates: Rates | None, rows: Labels) -> Floats:
    if rates is None or rates.bodies is None:
        return np.full((len(rows), PLACES, 2, 3), np.nan)
    return np.asarray(rates.bodies[rows])


def _spread(start: Floats, end: Floats) -> Labels:
    """Rows of lines far from each other; a line that is there in both senses is one line."""
    from olp.identification.signature.domain import spread_out

    ends = np.round(np.concatenate([start, end], axis=1), 4)
    turned = [tuple(row[:3]) > tuple(row[3:]) for row in ends.tolist()]
    same = np.where(np.array(turned)[:, None], np.roll(ends, 3, axis=1), ends)
    once = np.sort(np.unique(same, axis=0, return_index=True)[1])
    return np.asarray(once[spread_out(same[once], min(_MOST, len(once)))])


def usual_angles(recording: Recording) -> Floats | None:
    """(3,) [rad] The orientation that most moves start with, None where none tells it."""
    angles = recording.moves.start_angles
    angles = angles[np.isfinite(angles).all(axis=1)]
    if not len(angles):
        return None
    _, first, count = np.unique(np.round(angles, 5), axis=0, return_index=True, return_counts=True)
    return np.asarray(angles[first[np.argmax(count)]])


def straight_moves(like: RecordedMoves, start: Floats, end: Floats, angles: Floats) -> RecordedMoves:
    """Recorded moves without durations along these lines (n, 3) [m]."""
    count = len(start)
    changes: dict[str, object] = {}
    for column in fields(RecordedMoves):
        value = getattr(like, column.name)
        if isinstance(value, np.ndarray):
            empty = 0 if value.dtype.kind == "i" else np.nan
            changes[column.name] = np.full((count, *value.shape[1:]), empty, dtype=value.dtype)
    turned = np.broadcast_to(angles, (count, 3))
    changes |= {"move": np.arange(count), "start": start, "end": end, "job": ("",) * count}
    changes |= {"kind": np.full(count, LINEAR, np.int8), "start_angles": turned, "end_angles": turned}
    return replace(like, covariates={}, texts={}, **changes)  # type: ignore[arg-type]
