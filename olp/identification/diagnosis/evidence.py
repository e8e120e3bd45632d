"""What it takes to name a term: evidence on moves that were not fitted, with the false discovery rate under control.

Of each name, all others fitted along: by how much groups of moves that the fit never saw are more likely with it than
without it. The exponential of that is the split likelihood ratio, which without an effect is one on average, however
the names were chosen (L. Wasserman, A. Ramdas, S. Balakrishnan, PNAS 117, 2020); a step-up rule over such ratios holds
the share of false names at `FALSE_DISCOVERIES` (R. Wang, A. Ramdas, J. R. Statist. Soc. B 84, 2022). No density is less
than that of a move that waits, some 1/n^1.5 per second: that adds next to nothing to one. A name also has to
take away as much as it leaves: form for form a robot's law is never quite the term's, and what makes up for that is no
second name.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.conditions import fit_anew
from olp.identification.diagnosis.fitting import (
    ModelFit,
    Noise,
    fit,
    loss_each,
    penalty,
    rounded_bic,
    rounding_of,
    scale_before_rounding,
    whiten,
)
from olp.identification.diagnosis.folds import EACH_FIFTH, HALF, Folds, interleaved, rms
from olp.identification.diagnosis.intervals import ALIKE
from olp.identification.diagnosis.model import DurationModel
from olp.identification.diagnosis.residuals import FALSE_DISCOVERIES, Remains, no_farther, remains_of
from olp.identification.diagnosis.scatter import FEWEST_FAR, beyond_digits, digits_of, scatter_of
from olp.identification.diagnosis.search import (
    NARROW,
    TELLING,
    PartShelf,
    doubts,
    in_its_place,
    price,
    search,
    with_fewer_numbers,
)
from olp.identification.diagnosis.waits import price_of_waits
from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]

SMALL = 0.01  # of the mean square that all names explain: what a name adds beyond what the others do is more
LITTLE = 0.02  # of the mean square: a pattern in what is left of it does not matter
_WITHIN = 1.5  # times the scatter: the root mean square of moves of which none is far off (Student's t: 1.2)
_CLEARLY = 1.25  # times the scatter that a set leaves: a smaller set that leaves more has lost something
_DRIFT = (
    0.05  # of a drift's mean square that a law of time may leave as drift: more, and the drift is another one
)
_APART = range(
    6, 11
)  # moves apart: a drift hardly changes over them, and an error that lasts some moves is gone
_TRIES, _STEPS = 3, 25  # sets of each size that are fitted to the end
_FEWEST = 3  # moves in which a term acts, in the training part of each fold
_CLIP = 6.0  # times the scatter: what is farther off counts as that
# Of the moves: more that are far off whatever is named are no outliers; and of those on the one side, on the other.
_OUTLIERS, _BOTH_SIDES = 0.05, 0.25
ACTS = 0.5  # of the scatter: a term acts in moves to which it adds more
_SURE_DRIFT = 3.0  # standard errors
NOTICED = 1.05  # times the error with a name: without it, it is more
# Why a name that the search found is none.
_UNCONFIRMED = "unseen moves do not confirm it"
_TOO_LITTLE = "the other names explain about as much"
_FORM_ONLY = "it is next to nothing of what the other names explain: their form may be off by as much"
_TOO_FEW = "it acts in fewer programmed moves than it has numbers"
_DRIFTS = "durations still drift with it"
_MISLEADS = "whole groups of moves are predicted better without it"
_STEPS_ONLY = "what it leaves has a pattern: a law that changes evenly would be cut into such parts as well"
CUT = 2.0  # times the mean square beyond the noise: a name takes away as much of it as it leaves, at least
_STEP = 9.0  # times likewise, where one step stands in the place of a law that grows evenly from nought


class Gain(NamedTuple):
    """What a term brings on moves that were not fitted."""

    loglik: float  # summed difference of log-likelihoods, with it less without it
    luckiest: float  # what one move adds to it at most
    before: float  # [s] RMSE without it
    after: float  # [s] RMSE with it
    cut: float  # [1] mean square beyond the noise without it, over that with it

    @property
    def evidence(self) -> float:
        """Log-likelihood of all moves but the luckiest: no single one decides."""
        return self.loglik - self.luckiest


class Selection(NamedTuple):
    """The search repeated inside the folds. Predictions are of moves that it did not see."""

    predicted: Floats  # (n,) [s]
    sets: tuple[frozenset[str], ...] = ()  # the names that each fold chose
    held: int = 0  # moves in which what a name changes is held at the most that the fit saw
    found: tuple[ModelFit | None, ...] = ()  # what each fold's own search came to, whatever is named


def chosen(
    fits: Sequence[ModelFit], case: MeasuredMoves, noise: Noise, tries: int = _TRIES, steps: int = _STEPS
) -> ModelFit:
    """The set with the fewest names that does as well as the best of all that were fitted; `fits`: the best first.

    Of each size the first `tries` sets are fitted in up to `steps` steps. A smaller set will do when each name more is
    worth less than `TELLING` in BIC, or does not matter.
    """
    best = min((fit(f.model, case, noise, steps) for f in fits[:tries]), key=price)
    for size in range(len(best.model.parts)):
        more = len(best.model.parts) - size
        will_do = []
        for one in [f for f in fits if len(f.model.parts) == size][:tries]:
            fitted = fit(one.model, case, noise, steps)
            if worth(fitted, best, case, noise) < TELLING * more or not matters(
                fitted, best, case, SMALL * more
            ):
                will_do.append(fitted)
        if will_do:
            return min(will_do, key=price)
    return best


def worth(fewer: ModelFit, more: ModelFit, case: MeasuredMoves, noise: Noise) -> float:
    """By how much the larger set is better in BIC; values that physics does not expect count against a set."""
    told = [rounded_bic(fitted, case, noise) + doubts(fitted.model) for fitted in (fewer, more)]
    return told[0] - told[1]


def matters(fewer: ModelFit, more: ModelFit, case: MeasuredMoves, small: float) -> bool:
    """Whether the larger set differs from the smaller by a share `small` of all that it explains (in the mean square),
    or leaves clearly less, or scatter where the smaller leaves a pattern or some moves far off."""
    if fewer.scale > _CLEARLY * more.scale:
        return True
    predicted, others = more.model.seconds(case), fewer.model.seconds(case)
    left = rms(case.measured - predicted)
    if left <= _WITHIN * more.scale and rms(case.measured - others) > _WITHIN * left:
        return True
    if float(np.mean((predicted - others) ** 2)) >= small * float(np.mean((predicted - case.simulated) ** 2)):
        return True
    return (
        not remains_of(case.measured - predicted, case, {}).structured
        and remains_of(case.measured - others, case, {}).structured
    )


def gain_of(
    fitted: ModelFit,
    parts: Sequence[int],
    rest: DurationModel,
    case: MeasuredMoves,
    noise: Noise,
    folds: Folds,
    floor: float,
) -> Gain:
    """Adding the `parts` to the others, held out by the folds; `floor` [s]: the noise.

    `rest`: the others at their own best values. Those beside the part may be far from these, and the few steps of a
    fold's fit do not lead there: the part would seem to bring what the steps did not reach. A move that is farther off
    than it costs to call it one that waits counts as that, with the part and without it.
    """
    labels = folds_for(fitted, parts, case, folds).labels
    without, with_it = (np.full(len(case), np.nan) for _ in range(2))
    difference, apart = np.zeros(len(case)), 0.5 * price_of_waits(1, len(case), len(case))
    scale, width = scale_before_rounding(fitted, case, noise), rounding_of(case, noise)
    for label in np.unique(labels).tolist():
        seen, held = _parts(labels, label)
        train, test = case.fold(seen), case.fold(held)
        with_it[held] = test.measured - fit_anew(fitted.model, train, noise, 6).model.seconds(test)
        without[held] = test.measured - fit_anew(rest, train, noise, 6).model.seconds(test)
        losses = [loss_each(whiten(left[held], noise, test), scale, width) for left in (without, with_it)]
        difference[held] = np.minimum(losses[0], apart) - np.minimum(losses[1], apart)
    luckiest = max(float(difference.max()), 0.0)
    return Gain(
        float(difference.sum()), luckiest, rms(without), rms(with_it), clipped_cut(without, with_it, floor)
    )


def clipped_cut(without: Floats, with_it: Floats, floor: float) -> float:
    """`cut`, where what is far off counts as no more than far: no single move decides.

    Far is what is far among all moves, or among those that differ: in most moves a name need not act at all. One move
    or two that are far off beside all others, with it and without it, or few that are so on both sides, as a recorder
    makes them, say nothing of it and are left out.
    """
    off = np.minimum(np.abs(without), np.abs(with_it))
    alone = off > _CLIP * max(1.4826 * float(np.median(np.abs(with_it))), floor)
    late, early = int((with_it[alone] > 0).sum()), int((with_it[alone] < 0).sum())
    scattered = min(late, early) >= _BOTH_SIDES * max(late, early) and late + early <= _OUTLIERS * len(off)
    if alone.any() and (late + early < FEWEST_FAR or scattered):
        without, with_it = without[~alone], with_it[~alone]
    differs = np.abs(without - with_it) > ACTS * floor
    some = without[differs] if differs.sum() >= _FEWEST else without
    far = _CLIP * 1.4826 * max(float(np.median(np.abs(moves))) for moves in (without, some))
    return cut(np.clip(without, -far, far), np.clip(with_it, -far, far), floor)


def cut(without: Floats, with_it: Floats, floor: float) -> float:
    """[1] How many times the mean square beyond the noise `floor` [s] is larger in `without` (k,) [s] than in `with_it`
    (m,) [s]; 0 where the whole error hardly differs."""
    before, after = rms(without), rms(with_it)
    if before <= NOTICED * after:
        return 0.0
    return (before**2 - floor**2) / (after**2 - floor**2) if after > floor else math.inf


def fallen(gains: Sequence[Gain], tried: int, least: float = CUT) -> list[int]:
    """The names that unseen moves do not confirm; `tried`: names that there were to choose from; `least` [1] cut."""
    order = sorted(range(len(gains)), key=lambda k: -gains[k].evidence)
    held = 0
    for rank, k in enumerate(order, 1):
        if gains[k].evidence >= math.log(tried / (FALSE_DISCOVERIES * rank)):
            held = rank
    sure = {k for k in order[:held] if _sure(gains[k], least)}
    return [k for k in range(len(gains)) if k not in sure]


def _sure(gain: Gain, least: float) -> bool:
    """Whether the error is smaller with the name, and clearly so beyond the noise. What is far off with and without it
    hides in the whole error what the others gain."""
    return gain.before > gain.after and gain.cut >= least


def drifts_on(fitted: ModelFit, index: int, case: MeasuredMoves) -> bool:
    """Whether part `index`, which acts by the running time, leaves a drift that is no small part of its own.

    Only what goes together over moves near each other is compared, as a share of their durations; scatter does not.
    """
    part = fitted.model.parts[index]
    condition = part.condition.statements if part.condition is not None else ()
    if not part.term.by_time and all(statement.column != "time" for statement in condition):
        return False
    whole = fitted.model.seconds(case)
    if not beyond_digits(case.measured - whole, case):
        return False  # the same move is rounded alike
    left, error = _together(case.measured - whole, case)
    done, _ = _together(whole - fitted.model.without(index).seconds(case), case)
    return left > _DRIFT * done and left > _SURE_DRIFT * error


def _together(seconds: Floats, case: MeasuredMoves) -> tuple[float, float]:
    """[1] mean product of near moves' shares of their durations, and its standard error where they are independent."""
    time = case.simulated
    near = seconds - np.median(seconds)
    reach = _CLIP * 1.4826 * float(np.median(np.abs(near)))
    off = np.clip(near, -reach, reach)
    # A time per move and a share of all durations are no drift.
    level = np.stack([np.ones(len(off)), time], axis=1)
    off = off - level @ np.linalg.lstsq(level, off, rcond=None)[0]
    pairs = [(off[k:] * off[:-k], time[k:] * time[:-k]) for k in _APART if k < len(off)]
    size = max(sum(float(both.sum()) for _, both in pairs), 1e-300)
    squares = sum(float((product**2).sum()) for product, _ in pairs)
    return sum(float(product.sum()) for product, _ in pairs) / size, math.sqrt(squares) / size


def acts(fitted: ModelFit, parts: Sequence[int], case: MeasuredMoves) -> NDArray[np.bool_]:
    """(n,) moves that some parts together change by more than half of the scatter."""
    whole = fitted.model.seconds(case)
    return np.asarray(np.abs(whole - _leaving(fitted.model, parts).seconds(case)) > ACTS * fitted.scale)


def spared(fitted: ModelFit, index: int, case: MeasuredMoves) -> NDArray[np.bool_]:
    """(n,) moves that part `index` would change by more than half of the scatter, were it not for its condition."""
    part = fitted.model.parts[index]
    if part.condition is None:
        return np.zeros(len(case), dtype=bool)
    parts = list(fitted.model.parts)
    parts[index] = part._replace(condition=None)
    always = DurationModel(tuple(parts)).seconds(case)
    return np.asarray(np.abs(always - fitted.model.seconds(case)) > ACTS * fitted.scale)


class _Weighed(NamedTuple):
    """A set, and what unseen moves say of its parts."""

    fit: ModelFit
    gains: tuple[Gain, ...]  # of the name of each part
    fewer: tuple[ModelFit, ...]  # without each part
    weak: dict[int, str]  # parts that are not confirmed: why
    stands: bool  # whether nothing is against the weak ones but that each takes away less than it leaves


def confirmed(
    best: ModelFit,
    case: MeasuredMoves,
    noise: Noise,
    folds: Folds,
    shelf: PartShelf,
    kinds: Sequence[Folds] = (),
) -> tuple[ModelFit, tuple[Gain, ...], dict[str, str]]:
    """The parts that held-out moves confirm; what each of them gains; and the names that fell, with the reason.

    Of the weak ones that falls first without which unseen moves have the smallest error, and the others are fitted
    anew. Names that fell one by one, as each took away less than it left, may together take away more: then the
    smallest of the sets with them that does is the answer, unless what the others leave is scatter.

    `kinds`: further ways to hold out whole groups. Where more than scatter is left, moves of a group have errors in
    common: then the set has to do no worse than a smaller one in each.
    """
    tried, gone, fell = len({part.label for part in shelf.parts}), set[str](), dict[str, str]()
    gains, larger = tuple[Gain, ...](), list[_Weighed]()
    while best.model.parts:
        found = _weighed(best, case, noise, folds, kinds, tried)
        gains = found.gains
        if not found.weak:
            break
        worst = min(found.weak, key=lambda k: (found.gains[k].before, found.gains[k].loglik))
        if found.weak[worst] == _TOO_FEW and _acts_in(best, worst, case) > 1:  # one move is as any form says
            simpler = with_fewer_numbers(best, worst, shelf, case, noise)
            if simpler is not None and price(simpler) < price(found.fewer[worst]) - TELLING:
                best, gains = simpler, ()
                continue
        if found.weak[worst] != _UNCONFIRMED:  # no larger set makes up for a drift that is left, or for steps
            larger = []
        elif found.stands:
            larger.append(found)
        gone.add(best.model.parts[worst].label)
        fell[best.model.parts[worst].term.name] = found.weak[worst]
        left = in_its_place(found.fewer[worst], best.model.parts[worst], shelf, case, noise, gone)
        best, gains = fit(left.model, case, noise, 30), ()
    for one in reversed(larger if patterned(best, case, noise) else ()):
        more = [k for k, part in enumerate(one.fit.model.parts) if part.label not in best.labels]
        floor = noise_left(one.fit, case, noise)
        if not fallen([gain_of(one.fit, more, best.model, case, noise, folds, floor)], len(larger) * tried):
            best, gains = one.fit, one.gains
    return best, gains, {name: why for name, why in fell.items() if name not in best.names}


def _weighed(
    best: ModelFit, case: MeasuredMoves, noise: Noise, folds: Folds, kinds: Sequence[Folds], tried: int
) -> _Weighed:
    """A set with names; `kinds` as in `confirmed`, `tried` as in `fallen`."""
    count, names = range(len(best.model.parts)), _names(best.model)
    floor = noise_left(best, case, noise)
    rests = {name: fit(_leaving(best.model, name), case, noise, 30) for name in names}
    gains = [gain_of(best, name, rests[name].model, case, noise, folds, floor) for name in names]
    told = {k: gain for name, gain in zip(names, gains, strict=True) for k in name}
    fewer = [rests[(k,)] if (k,) in rests else fit(best.model.without(k), case, noise, 30) for k in count]
    weak = dict.fromkeys([k for at in fallen(gains, tried) for k in names[at]], _UNCONFIRMED)
    little = {k for at in fallen(gains, tried, 0.0) for k in names[at]}
    stands = not little
    for k in count:
        if k in little:
            continue
        why = _against(best, k, fewer[k], case, noise, floor)
        if why:
            stands = False
            weak.setdefault(k, why)
    weak = dict.fromkeys([k for k in count if drifts_on(best, k, case)], _DRIFTS) or weak
    stands = stands and _DRIFTS not in weak.values()
    if (stands or not weak) and patterned(best, case, noise):
        without = {name: one.model for name, one in rests.items()}
        if misleading := _misleading(best, without, case, noise, kinds):
            stands, weak = False, weak or dict.fromkeys(misleading, _MISLEADS)
    if (stands or not weak) and (steps := _steps(best, case, noise, floor)):
        stands, weak = False, weak or dict.fromkeys(steps, _STEPS_ONLY)
    return _Weighed(best, tuple(told[k] for k in count), tuple(fewer), weak, stands)


def _against(
    best: ModelFit, index: int, fewer: ModelFit, case: MeasuredMoves, noise: Noise, floor: float
) -> str:
    """Why part `index` is no name although unseen moves are likelier with it, "" where nothing is against it; `fewer`:
    the fit without it."""
    if worth(fewer, best, case, noise) < TELLING:
        return _TOO_LITTLE
    if _has_a_number_for_each(best, index, case):
        return _TOO_FEW
    return _FORM_ONLY if _is_form(best, index, fewer, case, floor) else ""


def _names(model: DurationModel) -> list[tuple[int, ...]]:
    """The parts of each term: of several axes, one name has several."""
    names: dict[str, tuple[int, ...]] = {}
    for k, part in enumerate(model.parts):
        names[part.term.name] = (*names.get(part.term.name, ()), k)
    return list(names.values())


def _leaving(model: DurationModel, parts: Sequence[int]) -> DurationModel:
    """The model without some of its parts."""
    return DurationModel(tuple(part for k, part in enumerate(model.parts) if k not in parts))


def _misleading(
    best: ModelFit,
    rests: Mapping[tuple[int, ...], DurationModel],
    case: MeasuredMoves,
    noise: Noise,
    kinds: Sequence[Folds],
) -> list[int]:
    """The parts of the name without which whole groups of some kind are predicted clearly better, by all others or by
    one of them alone; nobody could know of a name in a group with all moves in which it acts, or that its condition
    leaves out. `rests`: the models without the parts of each name."""
    fewer = [(set(name), rest) for name, rest in rests.items()]
    every = set(range(len(best.model.parts)))
    if len(rests) > 2:
        for name in rests:
            alone = _leaving(best.model, sorted(every - set(name)))
            fewer.append((every - set(name), fit(alone, case, noise, 30).model))
    shown = {name: [acts(best, name, case), *(spared(best, k, case) for k in name)] for name in rests}
    for folds in kinds if len(rests) > 1 else ():
        known = {k for name in rests if not any(_absent(some, folds) for some in shown[name]) for k in name}
        asked = [(model, gone & known) for gone, model in fewer if gone & known]
        if not asked:
            continue
        # Where the error hardly differs, how groups happen to be dealt would decide.
        least, misleading = held_out_error(best.model, case, noise, folds) / NOTICED, set[int]()
        for model, gone in asked:
            if (error := held_out_error(model, case, noise, folds, least)) < least:
                least, misleading = error, gone
        if misleading:
            return sorted(misleading)
    return []


def held_out_error(
    model: DurationModel, case: MeasuredMoves, noise: Noise, folds: Folds, least: float = np.inf
) -> float:
    """[s] RMSE of whole folds that the model's values were not fitted to; inf as soon as some folds tell that it is
    not below `least` [s]."""
    left = np.zeros(len(case))
    for label in np.unique(folds.labels).tolist():
        seen, held = _parts(folds.labels, label)
        test = case.fold(held)
        left[held] = test.measured - fit_anew(model, case.fold(seen), noise, 6).model.seconds(test)
        if rms(left) > least:
            return np.inf
    return rms(left)


def _steps(best: ModelFit, case: MeasuredMoves, noise: Noise, floor: float) -> list[int]:
    """The parts under a condition where all names together take away no more than a step does of a law that is none of
    the terms, and leave a pattern.

    Of x from 0 to 1, the best step (none below 1/3, 2/3 beyond) leaves a ninth of the mean square. What is left of such
    a law goes together with something, or is larger in moves of some kind; a scatter is not.
    """
    steps = [k for k, part in enumerate(best.model.parts) if part.condition is not None]
    left = case.measured - best.model.seconds(case)
    if not steps or clipped_cut(case.residual, left, floor) >= _STEP:
        return []
    return steps if patterned(best, case, noise) or uneven(best, case, noise) else []


def _is_form(best: ModelFit, index: int, fewer: ModelFit, case: MeasuredMoves, floor: float) -> bool:
    """Whether part `index`, under a condition, makes up for what the form of another name leaves: it is next to nothing
    of what all explain, and `fewer`, without it, leaves as little as explains the moves; `floor` [s]: the noise."""
    if best.model.parts[index].condition is None:
        return False
    whole, others = best.model.seconds(case), fewer.model.seconds(case)
    small = float(np.mean((whole - others) ** 2)) < SMALL * float(np.mean((whole - case.simulated) ** 2))
    return small and rms(case.measured - others) <= _WITHIN * floor


def _has_a_number_for_each(best: ModelFit, index: int, case: MeasuredMoves) -> bool:
    """Whether part `index` acts in fewer programmed moves than it has numbers: that is no law, but a list of them."""
    return _acts_in(best, index, case) < len(best.model.parts[index].values)


def _acts_in(best: ModelFit, index: int, case: MeasuredMoves) -> int:
    """Number of programmed moves in which part `index` acts."""
    return len(np.unique(_programmed(case)[acts(best, (index,), case)]))


def _programmed(case: MeasuredMoves) -> NDArray[np.int64]:
    """(n,) the same label for moves that were programmed alike."""
    return case.repeats if len(case.repeats) == len(case) else np.arange(len(case))


def stamped(noise: Noise) -> Noise:
    """What shared time stamps do to neighbours is the recorder's; what goes together is left over."""
    return noise if noise.order < 0 else noise._replace(order=0.0)


def patterned(best: ModelFit, case: MeasuredMoves, noise: Noise) -> bool:
    """Whether a fit leaves more than scatter."""
    return remains_beside(best.model, case, noise, {}).structured


def remains_beside(
    model: DurationModel, case: MeasuredMoves, noise: Noise, groups: Mapping[str, NDArray[np.int64]]
) -> Remains:
    """What a model leaves, without what the recorder does to neighbours, looked at from every side."""
    left = no_farther(case.measured - model.seconds(case), case.resolution)
    return remains_of(whiten(left, stamped(noise), case), case, dict(groups))


def uneven(best: ModelFit, case: MeasuredMoves, noise: Noise) -> bool:
    """Whether what a fit leaves is larger in moves of some kind than in others."""
    left = whiten(case.measured - best.model.seconds(case), stamped(noise), case)
    size = np.abs(left - np.median(left))
    return remains_of(size - size.mean(), case, {}).structured


def noise_left(best: ModelFit, case: MeasuredMoves, noise: Noise) -> float:
    """[s] noise, as far as what a fit leaves tells it."""
    left = case.measured - best.model.seconds(case)
    return scatter_of(left, case, max(digits_of(case), noise.least), patterned(best, case, noise)).value


def selection(
    case: MeasuredMoves,
    noise: Noise,
    folds: Folds,
    shelf: PartShelf,
    named: DurationModel,
    before: Sequence[ModelFit | None] = (),
) -> Selection:
    """Search and fit without each fold, predict it.

    The `named` terms of all moves are one candidate: a narrow search may not come to them, and the moves that are seen
    choose another where they tell it from these. That physics does not expect their values is no such sign: all moves
    made up for it. Names beyond these have to hold on folds of the moves that are seen.
    `before`: what the searches in the same folds came to, where they were made for other names.
    """
    predicted, sets, held_back = np.full(len(case), np.nan), list[frozenset[str]](), 0
    searched = list[ModelFit | None]()
    for turn, label in enumerate(np.unique(folds.labels).tolist()):
        seen, held = _parts(folds.labels, label)
        train, test = case.fold(seen), case.fold(held)
        if not len(seen):
            predicted[held] = test.simulated
            searched.append(None)
            continue
        known = fit_anew(named, train, noise, 10)
        found = (before[turn] if before else None) or found_in(train, noise, shelf.take(seen))
        searched.append(found)
        asked = price(known) - doubts(known.model) - ALIKE
        if price(found) < asked:
            found = _held_against(
                found, known.labels, train, noise, Folds(folds.by, folds.labels[seen]), shelf
            )
        best = found if price(found) < asked else known
        predicted[held], beyond = foreseen(best, train, test, noise)
        held_back += int(beyond.sum())
        sets.append(frozenset(best.names))
    return Selection(predicted, tuple(sets), held_back, tuple(searched))


def foreseen(
    fitted: ModelFit, seen: MeasuredMoves, case: MeasuredMoves, noise: Noise
) -> tuple[Floats, NDArray[np.bool_]]:
    """Durations (n,) [s] of moves that the fit to the moves `seen` never had, and (n,) where they are held back.

    A law that leaves only scatter, or next to nothing of what it explains, is taken at its word. One that leaves a
    pattern is no more than a description of the moves `seen`: what it changes in another move, in seconds and as a
    share of the duration, is at most what it changes in one of these.
    """
    predicted, left = fitted.model.seconds(case), seen.measured - fitted.model.seconds(seen)
    little = float(np.mean(left**2)) <= LITTLE * float(np.mean(seen.residual**2))
    if not fitted.model.parts or little or not patterned(fitted, seen, noise):
        return predicted, np.zeros(len(case), dtype=bool)
    held, beyond = np.array(case.simulated), np.zeros(len(case), dtype=bool)
    for known, asked in zip(fitted.model.contributions(seen), fitted.model.contributions(case), strict=True):
        share = known / np.maximum(seen.simulated, 1e-9)
        least = np.minimum(min(known.min(), 0.0), min(share.min(), 0.0) * case.simulated)
        most = np.maximum(max(known.max(), 0.0), max(share.max(), 0.0) * case.simulated)
        held += np.clip(asked, least, most)
        beyond |= (asked < least) | (asked > most)
    return np.where(beyond, held, predicted), beyond


def _held_against(
    found: ModelFit,
    known: frozenset[str],
    case: MeasuredMoves,
    noise: Noise,
    folds: Folds,
    shelf: PartShelf,
) -> ModelFit:
    """The set without those of its parts beyond the `known` labels that held-out moves do not confirm."""
    tried = len({part.label for part in shelf.parts})
    while more := [k for k, part in enumerate(found.model.parts) if part.label not in known]:
        floor = noise_left(found, case, noise)
        rests = [fit(found.model.without(k), case, noise, 15) for k in more]
        gains = [
            gain_of(found, (k,), rest.model, case, noise, folds, floor)
            for k, rest in zip(more, rests, strict=True)
        ]
        weak = fallen(gains, tried)
        if not weak:
            break
        found = rests[min(weak, key=lambda at: gains[at].loglik)]
    return found


def found_in(case: MeasuredMoves, noise: Noise, shelf: PartShelf) -> ModelFit:
    """What a narrow search comes to, without conditions."""
    return chosen(search(case, noise, shelf, NARROW), case, noise, 1, 10)


def placebo(
    fitted: ModelFit, case: MeasuredMoves, shelf: PartShelf, times: int = 200, seed: int = 1
) -> float:
    """Share of shuffles of what the model leaves among the moves in which some term would be worth its price, to first
    order: the largest of all gains, so that looking at many terms is counted (P. Westfall, S. Young, 1993)."""
    columns, left = shelf.columns, case.measured - fitted.model.seconds(case)
    if not columns.shape[1]:
        return 0.0
    left = np.clip(left - np.median(left), -_CLIP * fitted.scale, _CLIP * fitted.scale)
    rng = np.random.default_rng(seed)
    shuffled = np.stack([rng.permutation(left) for _ in range(times)], axis=1)
    size = (columns**2).sum(axis=0)
    gain = (
        (columns.T @ shuffled) ** 2 / np.maximum(size, 1e-12)[:, None] / max(float(np.mean(left**2)), 1e-18)
    )
    cost = np.array([penalty((part,), case) for part in shelf.parts]) + TELLING
    return float((gain > np.where(size > 1e-12, cost, np.inf)[:, None]).any(axis=0).mean())


def folds_for(fitted: ModelFit, parts: Iterable[int], case: MeasuredMoves, folds: Folds) -> Folds:
    """The folds, unless one holds most of what one of the parts does, or all moves that its condition leaves out:
    nobody could know that from the others."""
    acting = {k: acts(fitted, (k,), case) for k in parts}
    lumped = [where for k, where in acting.items() if _lumped(fitted, k, where, case, folds)]
    lumped += [where for k in acting if _absent(where := spared(fitted, k, case), folds)]
    if not lumped:
        return folds
    programmed = _programmed(case)
    labels = np.zeros(len(case), dtype=np.int64)
    _, kind = np.unique(np.stack(lumped, axis=1), axis=0, return_inverse=True)
    for each in range(int(kind.max()) + 1):
        some = kind.ravel() == each
        labels[some] = interleaved(programmed[some])
    return Folds(EACH_FIFTH, labels)


def _lumped(
    fitted: ModelFit, index: int, where: NDArray[np.bool_], case: MeasuredMoves, folds: Folds
) -> bool:
    """Whether one fold holds most of what part `index` does, or leaves too few of the moves `where` (n,) it acts."""
    done = (fitted.model.seconds(case) - fitted.model.without(index).seconds(case)) ** 2
    return _absent(where, folds) or bool(np.bincount(folds.labels, done).max() > HALF * done.sum())


def _absent(where: NDArray[np.bool_], folds: Folds) -> bool:
    """Whether all moves but those of one fold have too few of the moves `where` (n,) a part acts."""
    inside = np.bincount(folds.labels, where)
    return bool((inside.sum() - inside < min(_FEWEST, inside.sum())).any())


def _parts(labels: NDArray[np.int64], label: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    return np.nonzero(labels != label)[0].astype(np.int64), np.nonzero(labels == label)[0].astype(np.int64)
