"""Apostolovic's method to the letter: tables of correction factors per start radius (chapters 5 and 6).

C = a_adjusted / a_nominal (6.1, 6.2, 6.4) over bearing (5.2) in level moves and over incline in upright ones, linear
between measured angles (6.3) and, where a start radius was not measured, between the tables of its neighbours.
Moves in neither plane combine both (6.5 to 6.18). Mass, tool orientation and configuration are factors of
their own (6.19).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm
from olp.identification.apostolovic import bearing, correction_factor, interpolated_factor
from olp.identification.signature.coefficients import LearntParameter, Parameters
from olp.identification.signature.estimator import Estimate, Estimator, measured_slowness
from olp.identification.signature.moveset import MoveSet

if TYPE_CHECKING:
    from olp.robots.model import Robot


Floats = NDArray[np.float64]

PLANES = ("horizontal", "vertical")
# [1] A move belongs to a plane when less than this share of it leaves the plane.
_LEVEL = 1e-3
_IN_PLANES = 0.5  # of the moves: from fewer, tables say nothing of most moves that they were learnt from
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

    def suits(self, moves: MoveSet) -> bool:
        planes = _planes(moves)
        return bool(np.mean(planes["horizontal"] | planes["vertical"]) >= _IN_PLANES)

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
        parameters.update(level_factors(levels, ratio / plain, good))
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


# --- Levels ---
# The three influential parameters that are factors of their own: carried mass, tool orientation, configuration (6.19).
# The most common level of each is the reference, at which the tables are made; any other level has the median of the
# ratios that its moves show to the tables.


Mask = NDArray[np.bool_]

_SAME_TURN = 0.5 * deg  # [rad]
_SAME_MASS = 1e-3  # [kg]
# [rad] An orientation that was not measured is taken as the nearest one, up to this far.
_NEAR_TURN = 10.0 * deg


@dataclass(frozen=True, slots=True)
class Levels:
    """Where n moves stand in each of the three parameters."""

    at_reference: Mask  # (n,) all three at the reference
    mass: Floats  # (n,) [kg]
    mass_reference: float
    orientation: NDArray[np.int64]  # (n,) index into `orientations`, -1 where none is near
    orientations: tuple[Floats, ...]  # each (9,), the first is the reference
    configuration: tuple[str, ...]
    configuration_reference: str
    factor: tuple[Floats, Mask]  # (n,) product of the three, and whether all were learnt


def levels_of(moves: MoveSet, parameters: Parameters | None = None) -> Levels:
    """The levels of `moves`: against those that were learnt, or, without `parameters`, their own."""
    learnt = parameters or {}
    if "orientations" in learnt:
        orientations = tuple(np.array(o, dtype=np.float64) for o in learnt["orientations"].value)
    else:
        orientations = _distinct(moves.rotation.reshape(len(moves), 9))
    orientation = _nearest(moves.rotation.reshape(len(moves), 9), orientations)
    told = np.round(moves.payload / _SAME_MASS) * _SAME_MASS
    known = learnt["mass_reference"].value if "mass_reference" in learnt else _commonest(told)
    mass_reference = float("nan") if known is None else float(known)
    mass = np.where(np.isnan(told), mass_reference, told)
    posture = learnt.get("configuration_reference")
    reference = str(posture.value) if posture else Counter(moves.configuration).most_common(1)[0][0]
    same = np.isclose(mass, mass_reference, atol=_SAME_MASS) | np.isnan(mass)
    at = same & (orientation <= 0) & np.array([c in ("", reference) for c in moves.configuration])
    factor = _product(mass, orientation, moves.configuration, reference, learnt)
    return Levels(at, mass, mass_reference, orientation, orientations, moves.configuration, reference, factor)


def level_factors(levels: Levels, ratio: Floats, good: Mask) -> dict[str, LearntParameter]:
    """C_m, C_o, C_c of every level but the reference, from moves in which only that level differs.

    `ratio` (n,): measured factor over the tables' factor.
    """
    plain_mass = np.isclose(levels.mass, levels.mass_reference, atol=_SAME_MASS) | np.isnan(levels.mass)
    plain_turn = levels.orientation <= 0
    plain_posture = np.array([c in ("", levels.configuration_reference) for c in levels.configuration])
    found: dict[str, LearntParameter] = {
        "mass_reference": LearntParameter(_number(levels.mass_reference), "kg"),
        "configuration_reference": LearntParameter(levels.configuration_reference, ""),
        "orientations": LearntParameter([o.round(9).tolist() for o in levels.orientations], "1"),
    }
    masses = np.unique(levels.mass[good & ~plain_mass & plain_turn & plain_posture])
    found["mass_factors"] = _medians(
        [(float(m), good & plain_turn & plain_posture & (levels.mass == m)) for m in masses.tolist()], ratio
    )
    turns = range(1, len(levels.orientations))
    found["orientation_factors"] = _medians(
        [(t, good & plain_mass & plain_posture & (levels.orientation == t)) for t in turns], ratio
    )
    postures = sorted({c for c, plain in zip(levels.configuration, plain_posture, strict=True) if not plain})
    own = np.array(levels.configuration)
    found["configuration_factors"] = _medians(
        [(p, good & plain_mass & plain_turn & (own == p)) for p in postures], ratio
    )
    return found


def _medians(cases: list[tuple[Any, Mask]], ratio: Floats) -> LearntParameter:
    """[level, factor] of each case that has rows; uncertainty from the spread about the median."""
    values, doubts = [], []
    for level, rows in cases:
        own = ratio[rows]
        if not len(own):
            continue
        middle = float(np.median(own))
        values.append([level, middle])
        spread = 1.4826 * float(np.median(np.abs(own - middle)))
        doubts.append(1.2533 * spread / np.sqrt(len(own)) if len(own) > 1 else None)
    return LearntParameter(values, "level, 1", doubts)


def _product(
    mass: Floats, orientation: NDArray[np.int64], posture: tuple[str, ...], reference: str, learnt: Parameters
) -> tuple[Floats, Mask]:
    result, known = np.ones(len(mass)), orientation >= 0
    table = learnt["mass_factors"].value if "mass_factors" in learnt else []
    base = learnt["mass_reference"].value if "mass_reference" in learnt else None
    if base is not None:
        points = sorted([(float(base), 1.0), *((float(m), float(f)) for m, f in table)])
        places = [m for m, _ in points]
        carried = np.where(np.isnan(mass), float(base), mass)
        result = result * np.interp(carried, places, [f for _, f in points])
        known &= (carried >= places[0] - _SAME_MASS) & (carried <= places[-1] + _SAME_MASS)
    for turn, factor in learnt["orientation_factors"].value if "orientation_factors" in learnt else []:
        result = np.where(orientation == turn, result * factor, result)
    names = {"", reference}
    for name, factor in learnt["configuration_factors"].value if "configuration_factors" in learnt else []:
        names.add(name)
        result = np.where(np.array(posture) == name, result * factor, result)
    return result, known & np.array([p in names for p in posture])


def _distinct(turns: Floats) -> tuple[Floats, ...]:
    """Different orientations, the most common first; none when nobody told any."""
    kinds: list[Floats] = []
    counts: list[int] = []
    for turn in turns[~np.isnan(turns).any(axis=1)]:
        for i, kind in enumerate(kinds):
            if _apart(turn, kind) < _SAME_TURN:
                counts[i] += 1
                break
        else:
            kinds.append(turn)
            counts.append(1)
    order = sorted(range(len(kinds)), key=lambda i: -counts[i])
    return tuple(kinds[i] for i in order)


def _nearest(turns: Floats, kinds: tuple[Floats, ...]) -> NDArray[np.int64]:
    """(n,) the kind each turn is near to, -1 when it is far from all; 0 where nothing is told."""
    result = np.zeros(len(turns), dtype=np.int64)
    if not kinds:
        return result
    apart = np.stack([_apart(turns, kind) for kind in kinds])
    told = ~np.isnan(turns).any(axis=1)
    nearest = np.argmin(np.nan_to_num(apart, nan=np.inf), axis=0)
    far = np.nan_to_num(apart.min(axis=0), nan=0.0) > _NEAR_TURN
    result[told] = np.where(far, -1, nearest)[told]
    return result


def _apart(turns: Floats, kind: Floats) -> Floats:
    """[rad] angle between rotations given as nine numbers."""
    cosine = (np.sum(turns * kind, axis=-1) - 1.0) / 2.0
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _commonest(values: Floats) -> float:
    known = values[~np.isnan(values)].tolist()
    return float(Counter(known).most_common(1)[0][0]) if known else float("nan")


def _number(value: float) -> float | None:
    return None if np.isnan(value) else value
