"""The three influential parameters that are factors of their own: carried mass, tool orientation, configuration (6.19).

The most common level of each is the reference, at which the tables are made; any other level has the median of the
ratios that its moves show to the tables.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg
from olp.identification.signature.estimator import LearntParameter, Parameters
from olp.identification.signature.moveset import MoveSet

Floats = NDArray[np.float64]
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


def level_factors(levels: Levels, moves: MoveSet, ratio: Floats, good: Mask) -> dict[str, LearntParameter]:
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
