"""What a signature knows beside straight moves from stop to stop: a few learnt quantities per kind of move.

Every part corrects olp's own model of constant acceleration, so that nothing learnt means the model as it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.errors import Spread, spread_of
from olp.identification.signature.estimator import LearntParameter
from olp.identification.signature.robust import FormChoice, Model, choose

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]

STOP, JOINT, CIRCULAR, CORNER = "stop", "joint", "circular", "corner"
TERMS = "terms"  # of method named_terms: nothing learnt beside the terms, but how wrong they are [s]
FEWEST = 4  # rows that a part is learnt from
_FOLDS = 10
_MANY = 40


class LearntQuantity(NamedTuple):
    name: str
    unit: str
    plain: float  # what it is when nothing was learnt
    lowest: float


class CorrectionKind(NamedTuple):
    """`forms`: which quantities may be learnt together, the simplest first."""

    name: str
    quantities: tuple[LearntQuantity, ...]
    forms: tuple[tuple[int, ...], ...]


_SCALE = LearntQuantity("acceleration_time_scale", "1", 1.0, 0.05)
_FIXED = LearntQuantity("fixed_time", "s", 0.0, -1.0)
KINDS: Mapping[str, CorrectionKind] = {
    kind.name: kind
    for kind in (
        CorrectionKind(
            STOP,
            (LearntQuantity("fixed_time", "s", 0.0, 0.0), LearntQuantity("slowness", "s²/m", 0.3, 1e-9)),
            ((1,), (0, 1)),
        ),
        CorrectionKind(JOINT, (_SCALE, _FIXED), ((), (0,), (1,), (0, 1))),
        CorrectionKind(CIRCULAR, (_SCALE, _FIXED), ((), (0,), (1,), (0, 1))),
        CorrectionKind(
            CORNER,
            (
                LearntQuantity("saving_scale", "1", 1.0, 0.0),
                LearntQuantity("stretch_time", "s", 0.0, -10.0),
                LearntQuantity("corner_time", "s", 0.0, -10.0),
            ),
            ((), (0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)),
        ),
        CorrectionKind(TERMS, (), ((),)),
    )
}


class CorrectionPart(NamedTuple):
    """Learnt `quantities` by name; held-out errors in s.

    `rows`: rows (stretches, for corners) it was learnt from; `longest` [s]: of them. `row_half` [s]: half-width that
    95 % of the rows of held-out stretches kept. `unlearnt`, `learnt`: held-out mean absolute errors [%] without and
    with the part. `law`: the blending law of the corners.
    """

    quantities: Mapping[str, LearntParameter]
    spread: Spread
    row_half: float
    rows: int
    longest: float
    unlearnt: float
    learnt: float
    law: str = ""

    def value(self, name: str) -> float:
        return float(self.quantities[name].value)


Parts = Mapping[str, CorrectionPart]


def value_of(parts: Parts, kind: str, name: str) -> float:
    """A learnt quantity, or what it is when nothing was learnt."""
    if kind in parts:
        return parts[kind].value(name)
    return next(q.plain for q in KINDS[kind].quantities if q.name == name)


def learn_part(
    kind: str, model: Model, measured: Floats, groups: Labels, plain: Floats | None = None, law: str = ""
) -> tuple[CorrectionPart, FormChoice]:
    """From `measured` (n,) [s], n >= FEWEST; `groups` (n,): rows of one program. `plain`: instead of the kind's own."""
    known = KINDS[kind]
    start = np.array([q.plain for q in known.quantities]) if plain is None else plain
    lowest = np.array([q.lowest for q in known.quantities])
    folds = np.arange(len(measured), dtype=np.int64) % min(_FOLDS, len(measured))
    found = choose(model, start, known.forms, measured, folds, lowest)
    spread = spread_of(found.errors, groups)
    spread = spread._replace(half=max(spread.half, half_of_few(found.errors)))
    quantities = {
        q.name: LearntParameter(float(value), q.unit, float(sd) if i in found.form else None)
        for i, (q, value, sd) in enumerate(
            zip(known.quantities, found.solved.values, found.solved.sd, strict=True)
        )
    }
    before, after = (100.0 * float(np.mean(np.abs(e) / measured)) for e in (found.plain, found.errors))
    longest = float(np.max(measured))
    part = CorrectionPart(quantities, spread, spread.half, len(measured), longest, before, after, law)
    return part, found


def half_of_few(errors: Floats) -> float:
    """[s] half-width by Student's t: of few errors the largest one covers less than 95 %. 0 of many."""
    if len(errors) >= _MANY:
        return 0.0
    own = float(np.sqrt(np.mean(errors**2)))
    return own * Spread(own, 0.0, own, len(errors) - 1).quantile
