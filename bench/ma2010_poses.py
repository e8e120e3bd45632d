"""The acceleration of axes S, L, U over 202 poses: laws fitted on some poses and asked for the others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from olp.robots.model import Lean, Lift, Swing
from olp.robots.robot import load_robot
from olp.timing.acceleration.by_pose import lean_limit, lift_limit, swing_limit

Floats = NDArray[np.float64]
_GEOMETRY = load_robot("yaskawa/ma2010").geometry
assert _GEOMETRY is not None
assert _GEOMETRY.links is not None
LINKS = _GEOMETRY.links
FOLDS = 10


@dataclass(frozen=True, slots=True)
class Table:
    """`lean`, `lift` (n,) [rad]: axes L and U. `measured` per axis (n, directions) [rad/s²]; + direction first."""

    lean: Floats
    lift: Floats
    measured: tuple[Floats, Floats, Floats]


@dataclass(frozen=True, slots=True)
class Candidate:
    """A law with numbers to fit: (numbers, lean, lift) -> (n, directions)."""

    name: str
    predict: Callable[[Floats, Floats, Floats], Floats]
    guess: tuple[float, ...]

    def fit(self, lean: Floats, lift: Floats, measured: Floats) -> Floats:
        def residual(numbers: Floats) -> Floats:
            return (self.predict(numbers, lean, lift) - measured).ravel()

        answer: Floats = least_squares(residual, self.guess, x_scale="jac", max_nfev=500).x
        return answer


def read(file: Path) -> Table:
    table = np.loadtxt(file, delimiter=",", skiprows=1)
    # Both directions of axis S are one number in the file.
    return Table(table[:, 0], table[:, 1], (table[:, 2:3], table[:, 4:6], table[:, 6:8]))


def _constant(numbers: Floats, lean: Floats, _: Floats) -> Floats:
    return np.broadcast_to(numbers, (len(lean), len(numbers)))


def _reach(numbers: Floats, lean: Floats, lift: Floats) -> Floats:
    """1/a = c0 + c1 reach² + c2 elbow², both horizontal."""
    elbow = LINKS.a1 + LINKS.a2 * np.sin(lean)
    reach = elbow + LINKS.d4 * np.cos(lift - lean) - LINKS.a3 * np.sin(lift - lean)
    return 1.0 / np.maximum(numbers[0] + numbers[1] * reach**2 + numbers[2] * elbow**2, 1e-3)[:, None]


def swing_of(numbers: Floats) -> Swing:
    return Swing(*numbers.tolist())


def lean_of(numbers: Floats) -> Lean:
    return Lean(
        *numbers[:3].tolist(), gravity=tuple(numbers[3:7].tolist()), both=tuple(numbers[7:11].tolist())
    )


def lift_of(numbers: Floats) -> Lift:
    return Lift(*numbers.tolist())


def _both(limit: Callable[[float], Floats]) -> Floats:
    return np.stack([limit(1.0), limit(-1.0)], axis=1)


CANDIDATES: tuple[tuple[Candidate, ...], ...] = (
    (
        Candidate("constant", _constant, (10.0,)),
        Candidate("reach and elbow", _reach, (0.067, 0.016, 0.033)),
        Candidate(
            "by pose",
            lambda x, lean, lift: swing_limit(swing_of(x), LINKS, lean, lift)[:, None],
            (0.06, 0.03, 0.02, 1.0, 0.2, 13.0),
        ),
    ),
    (
        Candidate("constant", _constant, (6.0, 6.0)),
        Candidate(
            "by pose",
            lambda x, lean, lift: _both(lambda s: lean_limit(lean_of(x), lean, lift, np.float64(s))),
            (0.15, 0.0, 0.05, 0.1, 0.0, 0.05, 0.0, 0.0, 0.2, 0.0, 0.0),
        ),
    ),
    (
        Candidate("constant", _constant, (9.0, 9.0)),
        Candidate(
            "by pose",
            lambda x, lean, lift: _both(lambda s: lift_limit(lift_of(x), lean, lift, np.float64(s))),
            (0.33, 0.7, 0.05, 10.5, 2.3, 0.9, 0.6),
        ),
    ),
)


def groups(table: Table, whole_rows: bool) -> NDArray[np.intp]:
    """(n,): the fold of each pose; random tenths, or all poses with one angle of axis L together."""
    if whole_rows:
        return np.unique(np.round(table.lean, 2), return_inverse=True)[1]
    return np.random.default_rng(0).permutation(len(table.lean)) % FOLDS


def held_out(candidate: Candidate, table: Table, axis: int, fold: NDArray[np.intp]) -> Floats:
    """Errors (n, directions) [rad/s²] in poses that the fit has not seen."""
    measured = table.measured[axis]
    errors = np.empty_like(measured)
    for k in np.unique(fold):
        seen, new = fold != k, fold == k
        numbers = candidate.fit(table.lean[seen], table.lift[seen], measured[seen])
        errors[new] = candidate.predict(numbers, table.lean[new], table.lift[new]) - measured[new]
    return errors


def chosen_inside(table: Table, axis: int) -> tuple[Floats, list[str]]:
    """Errors with the law, too, chosen without the held-out poses: by folds within the rest of each fold."""
    fold = groups(table, whole_rows=False)
    measured, names = table.measured[axis], []
    errors = np.empty_like(measured)
    for k in range(FOLDS):
        seen, new = fold != k, fold == k
        rest = Table(table.lean[seen], table.lift[seen], tuple(m[seen] for m in table.measured))  # type: ignore[arg-type]
        inner = np.arange(seen.sum()) % 5
        best = min(CANDIDATES[axis], key=lambda c: float(np.mean(held_out(c, rest, axis, inner) ** 2)))
        numbers = best.fit(rest.lean, rest.lift, rest.measured[axis])
        errors[new] = best.predict(numbers, table.lean[new], table.lift[new]) - measured[new]
        names.append(best.name)
    return errors, names
