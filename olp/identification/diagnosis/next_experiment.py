"""The experiment that tells rival explanations apart: the few moves on which they differ most, beyond all doubt.

G. Buzzi-Ferraris and P. Forzatti, "A new sequential experimental design procedure for discriminating among rival
models", Chemical Engineering Science 38 (1983): dᵀ V⁻¹ d, with d the difference of two models' predictions and V what
scatter and the uncertainty of both models' parameters make of it. Beside them V holds an offset that all new moves may
share (another day, another clock), so that moves on which rivals agree are chosen too, to compare with.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.units import mm
from olp.identification.diagnosis.fitting import Noise, parameters_of, slopes_of
from olp.identification.diagnosis.model import DurationModel
from olp.identification.diagnosis.next_candidates import CandidateMoves, candidates, joined
from olp.identification.diagnosis.result import NextExperiment, NextMove, NextTimer
from olp.timing.physics._case import Floats, MeasuredMoves

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording


Labels = NDArray[np.int64]

FEWEST, MOST = 4, 12  # moves
_TOLD_APART = 6.0  # standard deviations between two rivals, after all moves
_HOPELESS = 2.0  # less than this with every move five times is nothing to propose
_LEAST_TIMES, _MOST_TIMES = 3, 5  # fewer are no evidence of a name, however far off they are
_OFFSET = 5.0  # of the noise: what all new moves may be off by together
_WEIGHED = 240  # candidates whose parameters' uncertainty is worked out
_SHORT, _LONGEST = 1.0, 120.0  # [s] of timers
_LEAST_NOISE = 1e-3  # [s] where nothing tells the noise
_SAME_LINE = 1.1  # preference for a line that is run already: the moves then differ in one thing


def design_experiment(
    case: MeasuredMoves, rivals: Sequence[DurationModel], noise: float, recording: Recording
) -> NextExperiment:
    """Moves that separate the fitted `rivals` most, and why. `noise` [s]: standard deviation of one measured duration.

    Moves lie inside the recorded box, on lines that were run or that the robot is proved to reach; without moves when
    no such move separates the rivals, or none can be proposed. Raises OlpError (K…).
    """
    models = [
        DurationModel(tuple(p for p in m.parts if p.form.parameters and p.term.name != "external-wait"))
        for m in rivals
    ]
    if len(models) < 2:
        return NextExperiment()
    terms = {part.term for model in models for part in model.parts}
    scatter = (
        noise if np.isfinite(noise) and noise > 0 else max(case.resolution / np.sqrt(12.0), _LEAST_NOISE)
    )
    timers = _timers(models, scatter)
    found = candidates(case, recording, terms)
    if found is None:
        says = "the recording has no straight move with tool points, so no further moves can be proposed"
        return _without_moves(models, says, timers)
    apart = _differences([_predicted(model, case, found) for model in models])
    pairs = list(combinations(range(len(models)), 2))
    hopeful = [
        k for k, row in enumerate(apart) if _MOST_TIMES * float((row**2).max()) >= (_HOPELESS * scatter) ** 2
    ]
    if hopeful:  # a pair that no single move parts has no say in which moves part the others
        apart, pairs = apart[hopeful], [pairs[k] for k in hopeful]
    few = _worth_weighing(found, apart)
    parts = taken(found, few)
    spread = _spreads(models, pairs, case, parts, scatter)
    chosen, reached = _chosen(found, few, apart[:, few], spread, scatter)
    if reached * _MOST_TIMES < _HOPELESS**2:
        says = "no straight move inside the recorded box separates them beyond the noise of the recording"
        return _without_moves(models, says, timers)
    times = int(np.clip(np.ceil(_TOLD_APART**2 / reached), _LEAST_TIMES, _MOST_TIMES))
    runs = few[np.sort(np.array(chosen))]
    hardest = int(np.argmin(np.sum(apart[:, runs] ** 2, axis=1)))
    why = sentence([models[i] for i in pairs[hardest]], found, apart[hardest] / scatter, runs)
    return NextExperiment(why, _moves(found, runs, times), timers)


def _without_moves(
    models: Sequence[DurationModel], says: str, timers: tuple[NextTimer, ...]
) -> NextExperiment:
    says = "run these timers; " + says if timers else says
    return NextExperiment(f"{sentence(models, None, None, None)}: {says}", (), timers)


def _timers(models: Sequence[DurationModel], noise: float) -> tuple[NextTimer, ...]:
    """Where only some of the models have a clock at another rate: only it changes what a timer takes. A short timer
    beside the long one tells what all timers take more."""
    rates = [[float(p.values[0]) for p in model.parts if p.term.name == "clock"] for model in models]
    off = [abs(rate[0] - 1.0) for rate in rates if rate]
    if not off or len(off) == len(models) or min(off) <= 0.0:
        return ()
    needed = _TOLD_APART * noise * np.sqrt(2.0 / _MOST_TIMES) / min(off)
    long = float(np.clip(np.ceil(needed), _SHORT + 1.0, _LONGEST))
    return (
        NextTimer(_SHORT, _MOST_TIMES, "to compare with"),
        NextTimer(long, _MOST_TIMES, "a clock changes its duration, motion does not"),
    )


# --- predictions ------------------------------------------------------------------------------------------------------


def taken(found: CandidateMoves, runs: Labels) -> CandidateMoves:
    """Some of the runs, numbered anew."""
    rows = np.nonzero(np.isin(found.run, runs))[0]
    _, number = np.unique(found.run[rows], return_inverse=True)
    return CandidateMoves(found.case.take(rows), number.astype(np.int64), found.line[rows])


def _blocks(case: MeasuredMoves, found: CandidateMoves) -> list[Labels]:
    """Few rows at a time beside the recorded ones: a term's medians then stay those of the recording."""
    size = max(6, len(case) // 10)
    edges = np.searchsorted(found.run, np.arange(len(found)), side="right")
    blocks, first = [], 0
    while first < len(found.run):
        last = edges[np.searchsorted(edges, first + size)] if first + size < edges[-1] else edges[-1]
        blocks.append(np.arange(first, last))
        first = int(last)
    return blocks


def _predicted(model: DurationModel, case: MeasuredMoves, found: CandidateMoves) -> Floats:
    """(runs,) [s] of each run, its rows together."""
    rows = [model.smooth(joined(case, found.case.take(block)))[len(case) :] for block in _blocks(case, found)]
    return _per_run(found, np.concatenate(rows))


def _per_run(found: CandidateMoves, rows: Floats) -> Floats:
    return np.asarray(np.add.reduceat(rows, found.first, axis=0))


def _differences(predicted: Sequence[Floats]) -> Floats:
    """(pairs, runs) [s]"""
    return np.stack([first - second for first, second in combinations(predicted, 2)])


def _worth_weighing(found: CandidateMoves, apart: Floats) -> Labels:
    """Runs on which some pair differs most, and the others of the same lines for comparison."""
    if len(found) <= _WEIGHED:
        return np.arange(len(found))
    share = _WEIGHED // (2 * len(apart)) + 1
    most = np.unique(np.argsort(-np.abs(apart), axis=1, kind="stable")[:, :share])
    rest = np.setdiff1d(np.arange(len(found)), most)
    beside = rest[np.linspace(0, len(rest) - 1, _WEIGHED // 2).round().astype(int)]
    twins = most[found.rounded[most]] - 1
    return np.unique(np.concatenate([most, beside, twins]))


def _spreads(
    models: Sequence[DurationModel],
    pairs: Sequence[tuple[int, int]],
    case: MeasuredMoves,
    found: CandidateMoves,
    scatter: float,
) -> list[Floats]:
    """Per pair (runs, p) [s]: what one standard deviation of each parameter of the two models does to a run."""
    noise = Noise(scatter)
    each: list[Floats] = []
    for model in models:
        if not model.parts:
            each.append(np.zeros((len(found), 0)))
            continue
        known = slopes_of(model, case, noise)
        rows = [
            slopes_of(model, joined(case, found.case.take(block)), noise)[len(case) :]
            for block in _blocks(case, found)
        ]
        slopes = _per_run(found, np.concatenate(rows))
        span = np.array(
            [np.log(q.high / q.low) if q.log else q.high - q.low for _, q, _ in parameters_of(model)]
        )
        told = known.T @ known / scatter**2 + np.diag(4.0 / np.maximum(span, 1e-9) ** 2)
        # V = G C Gᵀ with C the inverse of what the recording tells: G times a root of C.
        each.append(np.asarray(np.linalg.solve(np.linalg.cholesky(told), slopes.T).T, dtype=np.float64))
    return [np.concatenate([each[one], each[two]], axis=1) for one, two in pairs]


# --- the choice -------------------------------------------------------------------------------------------------------


def _chosen(
    found: CandidateMoves, few: Labels, apart: Floats, spread: Sequence[Floats], scatter: float
) -> tuple[list[int], float]:
    """Positions in `few`, and the worst pair's dᵀ V⁻¹ d."""
    rows = np.bincount(found.run)[few]
    line = found.line[found.first][few]
    stopped = (rows > 1) & ~found.rounded[few]
    chosen: list[int] = []
    while True:
        now = [_separation(apart[p], spread[p], rows, scatter, chosen) for p in range(len(apart))]
        count = int(rows[chosen].sum())
        if count >= FEWEST and min(now) >= _TOLD_APART**2:
            break
        # Two halves with a stop between are only there to be compared with the same ones rounded.
        twins = np.isin(few + 1, few[[c for c in chosen if found.rounded[few[c]]]])
        free = (count + rows <= MOST) & ~np.isin(np.arange(len(few)), chosen) & (~stopped | twins)
        if not free.any():
            break
        worst = int(np.argmin(now))
        gain = _gains(apart[worst], spread[worst], rows, scatter, chosen) / np.where(twins, 1, rows)
        gain = np.where(np.isin(line, line[chosen]), _SAME_LINE * gain, gain)
        chosen.append(int(np.argmax(np.where(free, gain, -1.0))))
    return chosen, min(now)


def _covariance(
    spread: Floats, rows: NDArray[np.int64], scatter: float, left: Labels, right: Labels
) -> Floats:
    """[s²] between runs: parameters and the common offset; scatter is added on the diagonal by the callers."""
    shared = (_OFFSET * scatter) ** 2 * np.outer(rows[left], rows[right])
    return np.asarray(spread[left] @ spread[right].T + shared)


def _separation(
    apart: Floats, spread: Floats, rows: NDArray[np.int64], scatter: float, chosen: list[int]
) -> float:
    """dᵀ V⁻¹ d of the chosen runs."""
    if not chosen:
        return 0.0
    at = np.array(chosen)
    covariance = _covariance(spread, rows, scatter, at, at) + np.diag(rows[at] * scatter**2)
    return float(apart[at] @ np.linalg.solve(covariance, apart[at]))


def _gains(
    apart: Floats, spread: Floats, rows: NDArray[np.int64], scatter: float, chosen: list[int]
) -> Floats:
    """(runs,) by how much each run would raise dᵀ V⁻¹ d."""
    every = np.arange(len(apart))
    own = np.sum(spread**2, axis=1) + (_OFFSET * scatter * rows) ** 2 + rows * scatter**2
    if not chosen:
        # The offset is told by the moves to come: the first run is the one that differs most without it.
        return np.asarray(apart**2 / (own - (_OFFSET * scatter * rows) ** 2))
    at = np.array(chosen)
    among = _covariance(spread, rows, scatter, at, at) + np.diag(rows[at] * scatter**2)
    across = _covariance(spread, rows, scatter, every, at)
    weights = np.linalg.solve(among, across.T)
    news = apart - weights.T @ apart[at]
    left = own - np.einsum("rc,cr->r", across, weights)
    return np.asarray(news**2 / np.maximum(left, 1e-3 * scatter**2))


# --- the answer -------------------------------------------------------------------------------------------------------


def _moves(found: CandidateMoves, runs: Labels, times: int) -> tuple[NextMove, ...]:
    case = found.case
    moves = []
    timed = len(np.unique(case.t_start[np.isfinite(case.t_start)])) > 1
    begin = float(case.t_start.min()) if timed else float("nan")
    for run in runs.tolist():
        rows = np.nonzero(found.run == run)[0]
        for row in rows.tolist():
            load = float(case.payload[row])
            moves.append(
                NextMove(
                    start=_point(case.start[row]),
                    end=_point(case.end[row]),
                    speed=float(case.base.speed[row]),
                    payload=load if np.isfinite(load) else None,
                    blend=float(case.blend[row]),
                    times=times,
                    why=_remark(case, rows, row, begin),
                )
            )
    return tuple(moves)


def _remark(case: MeasuredMoves, rows: Labels, row: int, begin: float) -> str:
    """What a move is for, as far as its numbers do not say it. `begin` [s]: of the day, nan where time is no matter."""
    words = []
    if len(rows) > 1:
        half = "first" if row == rows[0] else "second"
        passed = "rounded" if case.blend[rows[0]] > 0 else "an exact stop"
        words.append(f"{half} half of a line, the point between {passed}")
    if np.isfinite(begin):
        cold = case.t_start[row] == begin
        words.append("while the robot is cold" if cold else "after hours of running")
    return ", ".join(words)


def _point(place: Floats) -> tuple[float, float, float]:
    x, y, z = np.round(place, 6).tolist()
    return x, y, z


# --- Next words ---
# Why an experiment tells rivals apart, in one sentence: what they differ by, and where.

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
        return f"{names} fit these moves equally well"
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
