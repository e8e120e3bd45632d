"""Why an experiment tells rivals apart, in one sentence: what they differ by, and where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from olp.core.units import mm
from olp.identification.diagnosis.model import DurationModel
from olp.identification.diagnosis.next_candidates import CandidateMoves
from olp.timing.physics._case import Floats

Labels = NDArray[np.int64]

_BINS = 4
_NOTHING = 1.0  # standard deviations: below it two rivals say the same
_ENOUGH = 0.1  # of the variation of a difference that a property has to explain to be named
_MOST_NAMED = 2
_STEEP = 0.2  # sine of an incline that counts as up or down
_PACE = 0.5  # speed and length scale most effects: less is said by naming them


@dataclass(frozen=True, slots=True, eq=False)
class _Property:
    """Something in which runs differ. `most`, `least`: said of high and low values; `how`: of the runs to do."""

    values: Floats
    most: str
    least: str
    how: str
    weight: float = 1.0


def sentence(
    models: Sequence[DurationModel], found: CandidateMoves | None, apart: Floats | None, runs: Labels | None
) -> str:
    """`apart` (runs,) [standard deviations]: the difference of two models on all candidates; `runs`: the chosen."""
    names = " and ".join(_names(models))
    if found is None or apart is None or runs is None:
        return f"{names} fit these moves alike"
    where, only, how = _where(found, apart, runs)
    count = len(np.nonzero(np.isin(found.run, runs))[0])
    when = (
        f"differ {'only ' if only else ''}when {where}" if where else "differ most on moves unlike each other"
    )
    return f"{names} {when}: run these {count} moves{how}"


def _names(models: Sequence[DurationModel]) -> list[str]:
    """What each model has that the others have not."""
    every = [{part.term.name for part in model.parts} for model in models]
    shared = set.intersection(*every)
    if any(names - shared for names in every):
        return [" with ".join(sorted(names - shared)) or "nothing more" for names in every]
    forms = [{(p.term.name, p.form.key) for p in model.parts} for model in models]
    common = set.intersection(*forms)
    return [
        " with ".join(f"{name} ({key})" if key else name for name, key in sorted(own - common)) or "the same"
        for own in forms
    ]


def _where(found: CandidateMoves, apart: Floats, runs: Labels) -> tuple[str, bool, str]:
    """What the difference hangs on most, whether it vanishes elsewhere, and how the chosen runs differ in it."""
    size = np.abs(apart)
    rounded = np.nonzero(found.rounded)[0]
    twins = rounded - 1
    single = np.setdiff1d(np.arange(len(found)), np.concatenate([rounded, twins]))
    changed = float(np.median(np.abs(apart[rounded] - apart[twins]))) if len(rounded) else 0.0
    if found.rounded[runs].any() and changed > max(_NOTHING, float(np.std(apart[single]))):
        more = bool(size[rounded].mean() > size[twins].mean())
        elsewhere = np.concatenate([single, twins if more else rounded])
        word = "corners are blended" if more else "corners are not blended"
        only = bool(size[elsewhere].max(initial=0.0) < _NOTHING)
        return word, only, " with and without rounding (CNT, PL)"
    return _hangs_on(_properties(found), apart, single, runs)


def _hangs_on(
    every: Sequence[_Property], apart: Floats, single: Labels, runs: Labels
) -> tuple[str, bool, str]:
    """The one or two properties that part large differences from small ones; failing that, what the runs span."""
    size = np.abs(apart)
    among = np.isin(np.arange(len(apart)), single)
    inside = among.copy()
    named: list[tuple[_Property, str]] = []
    for _ in range(_MOST_NAMED):
        free = [p for p in every if all(p is not q for q, _ in named)]
        worth = [p.weight * _explained(p.values[inside], apart[inside]) for p in free]
        if max(worth, default=0.0) < _ENOUGH:
            break
        best = free[int(np.argmax(worth))]
        bins = _binned(best.values)
        low, high = inside & (bins == 0), inside & (bins == bins.max())
        upward = _mean(size[high]) >= _mean(size[low])
        named.append((best, best.most if upward else best.least))
        inside = high if upward else low
    only = bool(named) and float(size[among & ~inside].max(initial=0.0)) < _NOTHING
    told = [p for p, _ in named] or [p for p in every if p.weight == _PACE]
    spans = [(p.how, p.values[runs]) for p in told]
    how = ",".join(text.format(span.min(), span.max()) for text, span in spans if np.ptp(span) > 1e-9)
    return " and ".join(word for _, word in named), only, how


def _properties(found: CandidateMoves) -> list[_Property]:
    case, first = found.case, found.first
    last = np.append(first[1:], len(found.run)) - 1
    length = np.linalg.norm(case.end[last] - case.start[first], axis=1)
    rise = case.rise[first]
    reach = 0.5 * (np.hypot(*case.start[first, :2].T) + np.hypot(*case.end[last, :2].T))
    every = [
        _Property(
            case.base.speed[first] / mm,
            "moves are fast",
            "moves are slow",
            " at {:.0f} to {:.0f} mm/s",
            _PACE,
        ),
        _Property(length / mm, "moves are long", "moves are short", " over {:.0f} to {:.0f} mm", _PACE),
        _Property(np.where(np.abs(rise) > _STEEP, rise, 0.0), "moves go up", "moves go down", " up and down"),
        _Property(np.abs(rise), "moves are steep", "moves are level", " steep and level"),
        _Property(
            reach / mm, "moves are far out", "moves are near the base", " {:.0f} to {:.0f} mm from axis 1"
        ),
        _Property(case.payload[first], "the load is heavy", "the load is light", " with {:.3g} to {:.3g} kg"),
        _Property(
            *(case.payload_inertia[first], "the load's inertia is large", "the load's inertia is small"),
            " with {:.3g} to {:.3g} kg m²",
        ),
        _Property(case.t_start[first], "the robot is warm", "the robot is cold", " cold and warm"),
    ]
    return [p for p in every if np.isfinite(p.values).all() and np.ptp(p.values) > 1e-9]


def _explained(values: Floats, apart: Floats) -> float:
    """Share of the variation of the difference that lies between the values' bins."""
    whole = float(np.var(apart)) if len(apart) else 0.0
    if whole <= 0.0:
        return 0.0
    bins = _binned(values)
    count = np.bincount(bins)
    mean = np.bincount(bins, apart) / np.maximum(count, 1)
    return float(np.sum(count * (mean - apart.mean()) ** 2) / len(apart)) / whole


def _binned(values: Floats) -> Labels:
    """(n,) 0, 1, … by levels, or by quarters where there are many."""
    levels = np.unique(np.round(values, 6))
    if len(levels) <= 2 * _BINS:
        return np.asarray(np.searchsorted(levels, np.round(values, 6)))
    edges = np.unique(np.quantile(values, np.linspace(0, 1, _BINS + 1)[1:-1]))
    return np.asarray(np.searchsorted(edges, values, side="left"))


def _mean(values: Floats) -> float:
    return float(values.mean()) if len(values) else 0.0
