"""Apostolovic's method to the letter: tables of correction factors per start radius (chapters 5 and 6).

C = a_adjusted / a_nominal (6.1, 6.2, 6.4) over bearing (5.2) in level moves and over incline in upright ones, linear
between measured angles (6.3) and, where a start radius was not measured, between the tables of its neighbours.
Moves in neither plane combine both (6.5 to 6.18). Mass, tool orientation and configuration are factors of
their own (6.19).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm
from olp.identification.apostolovic import bearing, correction_factor, interpolated_factor
from olp.identification.signature.estimator import (
    Estimate,
    Estimator,
    LearntParameter,
    Parameters,
    measured_slowness,
)
from olp.identification.signature.factor_levels import level_factors, levels_of
from olp.identification.signature.moveset import MoveSet

if TYPE_CHECKING:
    from olp.robots.robot import Robot

Floats = NDArray[np.float64]

PLANES = ("horizontal", "vertical")
# [1] A move belongs to a plane when less than this share of it leaves the plane.
_LEVEL = 1e-3
_BIT = 1e-6  # [rad] that angles lose on their way through a file
# [m/s²] where a recording names no simulation: the factors are then relative to this.
NOMINAL = 1.0


@dataclass(frozen=True, slots=True)
class FactorTable:
    """C over the angle [rad], rising, for one start point, plane and sense of the motion."""

    plane: str
    sense: int  # +1 away from the base (horizontal) or up (vertical), -1 the other way
    start: tuple[float, ...]  # [m]
    radius: float  # [m] of the start point from the base
    angles: Floats
    factors: Floats


class Factors(Estimator):
    """Combination in the inclined plane without the part a_y² twice (docs/thesis.md, erratum 28)."""

    summary = "Apostolovic's factor tables, a_y² counted once in inclined planes"

    def needs(self, moves: MoveSet, robot: Robot | None) -> str:
        if not any(flat.any() for flat in _planes(moves).values()):
            return "no move lies in a level or upright plane"
        return ""

    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        nominal = float(np.nanmedian(moves.nominal)) if np.isfinite(moves.nominal).any() else NOMINAL
        slowness = measured_slowness(moves)
        ratio = np.asarray(correction_factor(1.0 / slowness, nominal))
        good = np.isfinite(ratio)
        levels = levels_of(moves)
        base = good & levels.at_reference
        tables = _tables(moves.take(base), ratio[base])
        plain = combine(tables, moves, self.combined)[0]
        parameters = {
            "nominal": LearntParameter(nominal / mm, "mm/s²"),
            "tables": LearntParameter([_as_json(table) for table in tables], "mm, deg, 1"),
        }
        parameters.update(level_factors(levels, moves, ratio / plain, good))
        return parameters

    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        tables = [_from_json(entry) for entry in parameters["tables"].value]
        factor, inside = combine(tables, moves, self.combined)
        more, known = levels_of(moves, parameters).factor
        nominal = float(parameters["nominal"].value) * mm
        with np.errstate(divide="ignore", invalid="ignore"):
            slowness = 1.0 / (nominal * factor * more)
        return Estimate(slowness, np.zeros(len(moves)), inside & known)

    def combined(self, parts: Floats, horizontal: Floats, vertical: Floats) -> Floats:
        """One factor of C_H and C_V (n,) for the unit vectors `parts` (n, 3).

        6.13 to 6.18 with the part along Y, which lies in both planes, weighted by how much of the rest lies in each:
        the weights of C_H² and C_V² add up to 1. Without Y the same as 6.18.
        """
        along, upward = parts[:, 0] ** 2, parts[:, 2] ** 2
        both = along + upward
        share = np.where(both > 0, along / np.where(both > 0, both, 1.0), 0.5)
        return np.asarray(np.sqrt(share * horizontal**2 + (1.0 - share) * vertical**2))


def combine(tables: list[FactorTable], moves: MoveSet, rule: Any) -> tuple[Floats, NDArray[np.bool_]]:
    """(n,) factor, and whether it is between measured angles and radii."""
    result, inside = np.full(len(moves), np.nan), np.zeros(len(moves), dtype=bool)
    planes = _planes(moves)
    values = {plane: plane_factor(tables, plane, moves) for plane in PLANES}
    for plane in PLANES:
        flat = planes[plane]
        result[flat], inside[flat] = values[plane][0][flat], values[plane][1][flat]
    inclined = ~(planes["horizontal"] | planes["vertical"])
    both = rule(moves.direction, values["horizontal"][0], values["vertical"][0])
    result[inclined] = both[inclined]
    inside[inclined] = (values["horizontal"][1] & values["vertical"][1])[inclined]
    # A plane that was never measured is taken as the other one, and said to be outside.
    other = np.where(np.isnan(values["horizontal"][0]), values["vertical"][0], values["horizontal"][0])
    result = np.where(np.isnan(result), other, result)
    everything = np.concatenate([table.factors for table in tables]) if tables else np.ones(1)
    return np.where(np.isnan(result), np.median(everything), result), inside


def plane_factor(tables: list[FactorTable], plane: str, moves: MoveSet) -> tuple[Floats, NDArray[np.bool_]]:
    """(n,) C of one plane for each move's part in it, nan where the plane was never measured."""
    angle, sense = plane_angle(moves, plane)
    radius = np.linalg.norm(moves.start, axis=1)
    result, inside = np.full(len(moves), np.nan), np.zeros(len(moves), dtype=bool)
    for way in (-1, 1):
        mine = [table for table in tables if table.plane == plane and table.sense == way]
        known = bool(mine)
        mine = mine or [table for table in tables if table.plane == plane]
        rows = np.nonzero(sense == way)[0]
        for row in rows.tolist() if mine else []:
            result[row], inside[row] = _between_radii(mine, moves.start[row], radius[row], angle[row])
            inside[row] &= known
    return result, inside


def plane_angle(moves: MoveSet, plane: str) -> tuple[Floats, NDArray[np.int64]]:
    """Bearing or incline (5.2) [rad] (n,), and the sense of the motion (n,): two ways share each angle."""
    step = moves.end - moves.start
    along = step[:, 0] if plane == "horizontal" else step[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        angle = np.asarray(bearing(along, step[:, 1]))
    return np.nan_to_num(angle), np.where(along > 0, 1, -1)


def _planes(moves: MoveSet) -> dict[str, NDArray[np.bool_]]:
    parts = np.abs(moves.direction)
    level = parts[:, 2] < _LEVEL
    return {"horizontal": level, "vertical": ~level & (parts[:, 0] < _LEVEL)}


def _tables(moves: MoveSet, ratio: Floats) -> list[FactorTable]:
    """One table per start point, plane and sense; moves repeated at one angle are averaged, as in 6.1."""
    tables = []
    planes = _planes(moves)
    labels = moves.start_labels
    for plane in PLANES:
        angle, sense = plane_angle(moves, plane)
        for label in np.unique(labels).tolist():
            for way in (-1, 1):
                rows = np.nonzero(planes[plane] & (labels == label) & (sense == way))[0]
                if not len(rows):
                    continue
                angles, index = np.unique(np.round(angle[rows], 7), return_inverse=True)
                slow = np.bincount(index, 1.0 / ratio[rows]) / np.bincount(index)
                start = moves.start[rows[0]]
                tables.append(
                    FactorTable(plane, way, tuple(start), float(np.linalg.norm(start)), angles, 1.0 / slow)
                )
    return tables


def _between_radii(
    tables: list[FactorTable], start: Floats, radius: float, angle: float
) -> tuple[float, bool]:
    """C at a start point: of its own table, else between the tables of the next radii (nearest outside them)."""
    same = [table for table in tables if np.linalg.norm(np.array(table.start) - start) < 1e-3]
    if same:
        return _at(same, angle)
    radii = np.unique(np.round([table.radius for table in tables], 6))
    lower, upper = radii[radii <= radius + 1e-6], radii[radii >= radius - 1e-6]
    near = [float(lower[-1])] if len(lower) else []
    near += [float(upper[0])] if len(upper) and (not near or upper[0] != near[0]) else []
    found = [_at([t for t in tables if abs(t.radius - r) < 2e-6], angle) for r in near]
    if len(near) == 1:
        return found[0][0], found[0][1] and bool(len(lower) and len(upper))
    share = (radius - near[0]) / (near[1] - near[0])
    return found[0][0] + share * (found[1][0] - found[0][0]), found[0][1] and found[1][1]


def _at(tables: list[FactorTable], angle: float) -> tuple[float, bool]:
    """Mean of the tables' C at `angle` (6.3); at the nearest measured angle outside a table."""
    values, inside = [], []
    for table in tables:
        # A table's own first and last angle are inside, whatever the last bit says.
        first, last = table.angles[0], table.angles[-1]
        held = float(np.clip(angle, first, last)) if first - _BIT <= angle <= last + _BIT else angle
        value = float(interpolated_factor(held, table.angles, table.factors))
        inside.append(not np.isnan(value))
        values.append(value if inside[-1] else float(np.interp(angle, table.angles, table.factors)))
    good = [v for v, ok in zip(values, inside, strict=True) if ok] or values
    return float(np.mean(good)), any(inside)


def _as_json(table: FactorTable) -> dict[str, Any]:
    return {
        "plane": table.plane,
        "sense": table.sense,
        "start_mm": [round(v / mm, 6) for v in table.start],
        "angle_deg": [round(v / deg, 7) for v in table.angles.tolist()],
        "factor": [float(f"{v:.10g}") for v in table.factors.tolist()],
    }


def _from_json(entry: dict[str, Any]) -> FactorTable:
    start = tuple(float(v) * mm for v in entry["start_mm"])
    angles = np.array(entry["angle_deg"], dtype=np.float64) * deg
    factors = np.array(entry["factor"], dtype=np.float64)
    radius = float(np.linalg.norm(start))
    return FactorTable(str(entry["plane"]), int(entry["sense"]), start, radius, angles, factors)
