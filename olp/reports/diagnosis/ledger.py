"""The ledger: for every move, the difference between robot and simulation split into named causes and a remainder."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from olp.identification.diagnosis import phrasing
from olp.identification.diagnosis.result import Diagnosis
from olp.reports.diagnosis.rows import Floats, MoveRows

LIMIT = 0.02  # that the causes may miss of the model's own prediction
_MS = 1000.0


class LedgerCell(NamedTuple):
    """A number in the ledger; `acts`: the cause stands above the noise in this move."""

    text: str
    acts: bool


class LedgerLine(NamedTuple):
    """One move."""

    move: int
    place: str
    anchor: str  # of the program line, "" without one
    measured: str
    simulated: str
    difference: str
    causes: tuple[LedgerCell, ...]
    remains: str
    significant: bool


class Sums(NamedTuple):
    """All moves together."""

    measured: str
    simulated: str
    difference: str
    causes: tuple[str, ...]
    remains: str


class LedgerCheck(NamedTuple):
    """Whether the causes add up to what the model predicts with all of them at once."""

    says: str
    holds: bool


def lines(diagnosis: Diagnosis, rows: MoveRows, anchors: Mapping[str, str]) -> list[LedgerLine]:
    """One line per move; `anchors`: program line -> the place in the page that shows it."""
    acting = [frozenset(finding.moves) for finding in diagnosis.findings]
    after = rows.after
    out = []
    for i, move in enumerate(rows.move.tolist()):
        causes = tuple(
            LedgerCell(_ms(values[i]), move in acts)
            for values, acts in zip(rows.causes.values(), acting, strict=True)
        )
        out.append(
            LedgerLine(
                move,
                rows.place[i],
                anchors.get(rows.place[i], ""),
                _s(rows.measured[i]),
                _s(rows.simulated[i]),
                _ms(rows.before[i]),
                causes,
                _ms(after[i]),
                bool(rows.significant[i]),
            )
        )
    return out


def sums(rows: MoveRows) -> Sums:
    """The columns' totals."""
    return Sums(
        _s(_total(rows.measured)),
        _s(_total(rows.simulated)),
        _ms(_total(rows.before)),
        tuple(_ms(_total(values)) for values in rows.causes.values()),
        _ms(_total(rows.after)),
    )


def check(rows: MoveRows, predicted: Floats | None) -> LedgerCheck | None:
    """The sum of the causes against `predicted` (n,) [s], the model with all causes at work at once."""
    if not rows.causes or predicted is None:
        return None
    model = predicted - rows.simulated
    causes = rows.before - rows.after
    known = np.isfinite(model) & np.isfinite(causes)
    size = float(np.abs(model[known]).sum())
    if not known.any() or size <= 0.0:
        return None
    missed = float(np.abs(model[known] - causes[known]).sum()) / size
    says = (
        f"Move by move, the causes add up to the model with all of them together, "
        f"within {phrasing.percent(missed * 100)} (limit {LIMIT * 100:.0f} %)."
    )
    return LedgerCheck(says, missed <= LIMIT)


def shares(rows: MoveRows) -> str:
    """How much of the difference the causes carry."""
    before, after = float(np.nansum(np.abs(rows.before))), float(np.nansum(np.abs(rows.after)))
    if before <= 0.0 or not rows.causes:
        return ""
    return (
        f"Added up without signs, the moves differ by {phrasing.seconds(before)}; "
        f"{phrasing.seconds(after)} of it ({phrasing.percent(after / before * 100)}) have no name."
    )


def _total(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(known.sum()) if len(known) else math.nan


def _s(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else ""


def _ms(value: float) -> str:
    text = f"{abs(value) * _MS:.1f}"
    if not math.isfinite(value):
        return ""
    return f"{phrasing.MINUS if value < 0 and float(text) else ''}{text}"
