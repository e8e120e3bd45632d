"""Moves that are timed, but hardly as whoever wrote them meant: told at the first of them, the others counted."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, info, warning
from olp.core.units import mm
from olp.ir.program import Path
from olp.runtime.paths import circle
from olp.runtime.plan import PATHS, BlendCode, Plan, StepKind, of_rows
from olp.timing.blending import load_law
from olp.timing.demand import Demand

_CIRCULAR = PATHS.index(Path.CIRCULAR)
_NOTHING = 1e-9  # [m] or [rad]: below this nothing moves


def oddities(plan: Plan, wanted: Demand) -> list[Diagnostic]:
    """T102 moves to where the arm stands, T103 circular moves that are lines, T104 zones longer than a move."""
    return [*_nowhere(plan, wanted), *_no_circle(plan), *_long_zones(plan, wanted)]


def _nowhere(plan: Plan, wanted: Demand) -> Iterator[Diagnostic]:
    moves = plan.moves
    still = (wanted.length <= _NOTHING) & ~wanted.unknown
    still[np.unique(moves.mechanism, return_index=True)[1]] = (
        False  # of the first move nobody knows the start
    )
    first = plan.row[plan.kind == StepKind.MOVE]
    rows = first[np.logical_and.reduceat(still, first)] if len(first) else first
    says = "the arm is already at the target of this move: it takes no time"
    yield from of_rows(plan, rows, info, "T102", says, "leave it out, or correct its point")


def _no_circle(plan: Plan) -> Iterator[Diagnostic]:
    moves = plan.moves
    rows = np.flatnonzero((moves.path == _CIRCULAR) & (moves.length > _NOTHING))
    if not len(rows):
        return
    point, arcs = plan.positions.position, rows[moves.via[rows] >= 0]
    _, radius, _ = circle(*(point[at[arcs]] for at in (moves.start, moves.target, moves.via)))
    says = "the three points of this arc lie on a line, or two of them are one: it is timed as a line"
    how = "move the middle point off the line, or write a linear move"
    yield from of_rows(plan, arcs[np.isinf(radius)], warning, "T103", says, how)
    after = _following(moves.mechanism)
    on_arc = (moves.path == _CIRCULAR) & (moves.via >= 0)
    lines = rows[moves.via[rows] < 0]
    alone = lines[(after[lines] < 0) | ~on_arc[after[lines]]]
    says = "this circular move has no two others beside it to make an arc with: it is timed as a line"
    yield from of_rows(
        plan, alone, warning, "T103", says, "an arc takes three circular moves, the first to where it begins"
    )


def _long_zones(plan: Plan, wanted: Demand) -> Iterator[Diagnostic]:
    """A zone is cut to half of the shorter neighbour, as controllers do; one longer than a whole move is told."""
    moves = plan.moves
    zoned = np.flatnonzero(moves.blend_code == BlendCode.ZONE)
    if not len(zoned) or load_law(plan.zone_law).share_zones:
        return
    if load_law(plan.zone_law).overlap_skips:
        yield from _overlapping_zones(plan, wanted)
        return
    after = _following(moves.mechanism)[zoned]
    zoned, after = zoned[after >= 0], after[after >= 0]
    travels = _travels(wanted)
    both = travels[zoned] & travels[after]
    zoned, after = zoned[both], after[both]
    shorter = np.minimum(wanted.length[zoned], wanted.length[after])
    long = moves.blend[zoned] > shorter * (1 + 1e-9)
    rows = zoned[long]
    if len(rows):
        zone, cut = moves.blend[rows[0]] / mm, shorter[long][0] / 2 / mm
        says = (
            f"the corner's zone of {zone:g} mm is longer than the shorter of its moves: {cut:.3g} mm are used"
        )
        how = "a zone ends at half of the shorter move: a smaller one that still does changes nothing"
        yield from of_rows(plan, rows, warning, "T104", says, how)


def _overlapping_zones(plan: Plan, wanted: Demand) -> Iterator[Diagnostic]:
    """Where the robot skips the point of a zone that meets its neighbour's: told wherever two zones touch."""
    moves = plan.moves
    zone = np.where(moves.blend_code == BlendCode.ZONE, moves.blend, 0.0)
    after = _following(moves.mechanism)
    first = np.flatnonzero((after >= 0) & _travels(wanted)[after])
    second = after[first]
    room = wanted.length[second]
    over = zone[first] + zone[second] > room * (1 - 1e-9)
    if not over.any():
        return
    rows = np.unique(np.concatenate((first[over], second[over])))
    asked, way = (zone[first] + zone[second])[over][0] / mm, room[over][0] / mm
    says = (
        f"blends overlap here: they take {asked:.4g} mm of a path of {way:.4g} mm; the robot skips such a point "
        "and warns; timed with half of the path"
    )
    how = "make r smaller: the radii of two points together must be less than the distance between them"
    yield from of_rows(plan, rows[zone[rows] > 0], warning, "T104", says, how)


def _travels(wanted: Demand) -> NDArray[np.bool_]:
    """(m,): rows whose length is known, is metres, and is one."""
    travels: NDArray[np.bool_] = wanted.metric & ~wanted.unknown & (wanted.length > _NOTHING)
    return travels


def _following(mechanism: NDArray[np.int16]) -> NDArray[np.intp]:
    """(m,): the next row of the same mechanism, -1 for its last."""
    result = np.full(len(mechanism), -1, dtype=np.intp)
    for index in np.unique(mechanism):
        rows = np.flatnonzero(mechanism == index)
        result[rows[:-1]] = rows[1:]
    return result
