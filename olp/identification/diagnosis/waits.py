"""Moves far out beside what the terms explain: waits from outside the arm, and the tails of a scatter that has them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.fitting import ModelFit
from olp.identification.diagnosis.folds import COUNT
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.diagnosis.residuals import FALSE_DISCOVERIES, LEVEL, rank_correlation, ranks
from olp.identification.diagnosis.scatter import FEWEST_FAR, far_out, neighbours
from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_LEVEL = 0.01  # that one clean recording in a hundred may have an outlier
_MOST, _MOST_ANY = 0.35, 0.45  # of all moves; more is no exception but a rule, unless waits are as they come
_MANY = 16  # waits of one kind of moves, at several lines: fewer do not tell that they go with nothing
_SURE = 25.0  # in BIC: fewer and smaller outliers are scatter
_FORM = 0.25  # of the terms' numbers: what that changes in a move may be a flaw of their form
_PLACES = 2  # of a program that may wait in every cycle for the same time; more are moves that are just slow
_SCATTERED = 1.5  # times the scatter's variance: so much at least do waits differ between repeats
_DIFFER, _ALIKE = (
    0.3,
    0.05,
)  # of a wait: so much it differs between repeats, and how seldom it looks as if it did not
_LATE = 2  # late moves, of no one kind; a single one may have any reason
_TICKS = 1.5  # of the recorder's clock that a wait lasts at least
_KINDS, _BY_CHANCE = 4, 1e-3  # programmed moves that a kind needs, and how seldom chance makes one
_ROUNDS, _LEAST = (
    12,
    2.0,
)  # of the fit of waits and scatter, and standard deviations of the shortest wait that tells
# Late moves for each early one; or moves that are later than any is early, fewer if one of them is so many times as
# late; or times as late as any is early.
_ONE_SIDED = 5
_TAILS = (1.5, 2.5, 4.0, 8.0, 30.0)  # degrees of freedom of a scatter
_DEALS = 8  # ways to hold moves out
_CLEARLY = 4.0  # times the scatter: where waits are looked for at first
_LEAST_WAITS = 1e-6  # less is none


def spread(residual: Floats, least: float) -> float:
    """[s] standard deviation of the middle of the residuals."""
    return max(1.4826 * float(np.median(np.abs(residual - np.median(residual)))), least)


def late_moves(fitted: ModelFit, case: MeasuredMoves, least: float) -> Mask:
    """(n,) moves that are later than scatter explains; none when as many are early (a heavy-tailed scatter)."""
    predicted = fitted.model.seconds(case)
    residual = case.measured - predicted
    sigma = spread(residual, least)
    corrected = np.abs(predicted - case.simulated)
    least_far = max(threshold(len(case)) * sigma, _TICKS * case.resolution)
    far = least_far + _flaw(fitted, case)
    late, early = residual > far, residual < -far
    nothing = np.zeros(len(case), dtype=bool)
    if late.sum() < _ONE_SIDED * early.sum():
        # What the fit's own form leaves is to both sides, and no farther to one than to the other.
        late = residual > np.maximum(far, -residual.min())
        far_later = residual > -_ONE_SIDED * residual.min()
        if late.sum() < (FEWEST_FAR if (late & far_later).any() else _ONE_SIDED):
            late &= far_later
    if late.sum() < _LATE or late.mean() > _MOST_ANY:
        return nothing
    excess = float(np.sum((residual[late] / sigma) ** 2)) - 2.0 * float(late.sum()) * math.log(len(case))
    # Others that are as late may be so by the fit's own flaw, and then two of them are no waits, either.
    if late.sum() < FEWEST_FAR and ((residual[~late] > least_far).any() or _of_one_kind(late, case)):
        return nothing
    if excess < _SURE or (late.sum() > _KINDS and _with_the_motion(residual, late, case) < _BY_CHANCE):
        return nothing
    # Where names may be off by more than a wait lasts, none is seen: these moves do not tell which ones wait.
    seen = late | (far <= np.median(residual[late]))
    if late.mean() > _MOST or _chosen_by_the_motion(late, corrected, case, among=seen):
        # A name under a condition may have made up for a part of what these moves are late by, and hide its law.
        everywhere = DurationModel(tuple(part for part in fitted.model.parts if part.condition is None))
        if not as_it_comes(late, case.measured - everywhere.seconds(case), case):
            return nothing
    many = len(np.unique(case.repeats[late])) > _PLACES if len(case.repeats) == len(case) else False
    if many and (_the_same_moves(residual, late, case, sigma) or _of_one_way(residual, late, case)):
        return nothing
    return np.asarray(late, dtype=bool)


def _of_one_kind(late: Mask, case: MeasuredMoves) -> bool:
    """Whether a late move is like another one or next to it: of too few for their ranks to tell, that does."""
    order = np.arange(len(late))
    near = [order - 1, np.where(order + 1 < len(late), order + 1, -1), *neighbours(case).values()]
    return any(bool((late & (one >= 0) & late[one]).any()) for one in near)


def price_of_waits(few: int, count: int, moves: int) -> float:
    """In BIC: a number for each of `few` of `count` that may wait, and the choice of these; `moves` were measured."""
    choice = math.lgamma(count + 1) - math.lgamma(few + 1) - math.lgamma(count - few + 1)
    return few * math.log(moves) + 2.0 * choice


def told_by_unseen_moves(residual: Floats, least: float, resolution: float) -> bool:
    """Whether moves that were not fitted are likelier, as all names have to make them, where some moves wait than where
    the scatter alone has tails, however heavy, on both sides. `residual` (n,) [s] of all moves, rounded to `resolution`
    [s]."""
    return _likelier(residual - np.median(residual), least, resolution) >= -math.log(FALSE_DISCOVERIES)


def far_on_one_side(residual: Floats, sigma: float, resolution: float) -> Mask:
    """(n,) three moves or more that are far out on one side, late or early, for another reason than a scatter, whose
    tails, however heavy, are on both: in recordings of a scatter alone there are some in one of a hundred, at most.

    `residual` (n,) [s], rounded to `resolution` [s], scatters by `sigma` [s] beside the tails.
    """
    off = residual - np.median(residual)
    reach = max(threshold(len(off)) * sigma, resolution)
    late, early = off > reach, off < -reach
    far, others = (late, early) if late.sum() > early.sum() else (early, late)
    if far.sum() < max(FEWEST_FAR, _ONE_SIDED * others.sum()):
        return np.zeros_like(far)
    sure = _likelier(off, _LEAST_WAITS, resolution) >= -math.log(_LEVEL)
    return np.asarray(far & sure)


def _likelier(off: Floats, least: float, resolution: float) -> float:
    """Logarithm of how much likelier unseen moves are where some are late, or early, than by scatter alone.

    The likelihood ratio of unseen moves is one on the mean without such a reason, and so is its mean over both sides
    and over ways to deal the moves, of which the luckiest does not decide (A. Markov's inequality). Where `off` (n,)
    [s] is rounded to `resolution` [s], each may be any value that is rounded so: what is rounded alike is no scatter.
    """
    told, least = np.zeros((_DEALS, 2)), max(resolution / math.sqrt(12.0), least)
    for deal in range(_DEALS):
        between = np.random.default_rng(deal).uniform(-0.5, 0.5, len(off)) * resolution
        told[deal] = _gained(off + between, least, deal)
    most = float(told.max())
    return most + math.log(float(np.mean(np.exp(told - most))))


def _gained(off: Floats, least: float, deal: int) -> Floats:
    """(2,) log-likelihood ratios of moves that were not fitted, with waits over without, of `off` (n,) [s] and of the
    same turned round; `deal`: how they are held out."""
    seen = np.random.default_rng(deal).permutation(len(off)) % COUNT != np.arange(COUNT)[:, None]
    sigma = np.array([spread(off[some], least) for some in seen])[:, None]
    with_waits = _foretold(np.stack([off, -off])[:, None], seen, sigma, least, True)
    gained = with_waits - _foretold(off[None], seen, sigma, least, False)
    return np.asarray(np.where(seen, 0.0, gained).sum(axis=(1, 2)))


def _foretold(off: Floats, seen: Mask, sigma: Floats, least: float, waits: bool) -> Floats:
    """(…, f, n) log density of residuals `off` (…, 1, n) [s] by those that are `seen` (f, n) and scatter by `sigma`
    (f, 1) [s]: Student's t, and with `waits` beside it an exponential, whose mean is as uncertain as that of so few
    waits is. The degrees of freedom are weighted by how likely they make what is seen."""
    count, square = seen.sum(axis=1, keepdims=True), off**2
    freedom = np.array(_TAILS).reshape(-1, *(1,) * off.ndim)
    scale, late = sigma, seen & (off > _CLEARLY * sigma) & waits
    likely = late.astype(np.float64)
    for _ in range(_ROUNDS):
        rest = seen - likely
        weight = rest * ((freedom + 1.0) / (freedom + square / scale**2))
        many = np.maximum(rest.sum(axis=-1, keepdims=True), 1.0)
        scale = np.maximum(np.sqrt((weight * square).sum(axis=-1, keepdims=True) / many), least)
        if waits:
            wait, share = _waiting(off, seen, likely), likely.sum(axis=-1, keepdims=True) / count
            either = wait + (1.0 - share) * _student(off, scale, freedom)
            likely = np.where(seen, wait / np.maximum(either, 1e-300), 0.0)
    density = _student(off, scale, freedom)
    if waits:
        rest = 1.0 - likely.sum(axis=-1, keepdims=True) / count
        density = _waiting(off, seen, likely) + rest * density
    told = np.where(seen, np.log(np.maximum(density, 1e-300)), 0.0).sum(axis=-1, keepdims=True)
    share = np.exp(told - told.max(axis=0))
    whole = (share * density).sum(axis=0) / share.sum(axis=0)
    return np.asarray(np.log(np.maximum(whole, 1e-300)))


def _waiting(off: Floats, seen: Mask, likely: Floats) -> Floats:
    """(…, f, n) density of waits of `off` (…, 1, n) [s], where moves that are `seen` (f, n) are `likely` (…, f, n) to
    wait: an exponential whose mean is known by these (Lomax's distribution)."""
    count = likely.sum(axis=-1, keepdims=True)
    whole = (likely * off).sum(axis=-1, keepdims=True)
    some = (count >= _LEAST_WAITS) & (whole > 0)
    whole = np.where(some, whole, 1.0)
    far = (1.0 + np.maximum(off, 0.0) / whole) ** -(count + 1.0)
    density = count / seen.sum(axis=1, keepdims=True) * count / whole * far
    return np.asarray(np.where(some & (off > 0), density, 0.0))


def _student(values: Floats, scale: Floats, freedom: Floats) -> Floats:
    """Density of Student's t."""
    half = [math.lgamma(0.5 * (one + 1.0)) - math.lgamma(0.5 * one) for one in freedom.ravel().tolist()]
    size = np.exp(half).reshape(freedom.shape) / np.sqrt(freedom * math.pi)
    return np.asarray(size / scale * (1.0 + (values / scale) ** 2 / freedom) ** (-0.5 * (freedom + 1.0)))


def as_it_comes(late: Mask, residual: Floats, case: MeasuredMoves) -> bool:
    """Whether the moves that are `late` (n,) wait for something, though they are of one kind: those of one line of the
    program, or those that take or place parts. Only that they are late by times that differ, and that go together with
    nothing in the motion, its place or its order, tells them from slow ones."""
    waits, few = residual[late], int(late.sum())
    if few < 2 * _KINDS or waits.std() < _DIFFER * waits.mean():
        return False
    if case.line[late].min() > 0 and np.ptp(case.line[late]) == 0:
        return _with_the_motion(residual, late, case) > LEVEL
    order = np.arange(len(case), dtype=np.float64)
    places = (*case.start.T, *case.end.T, order)
    return few >= _MANY and _with_the_motion(residual, late, case, places) > LEVEL


def with_its_line(late: Mask, residual: Floats, case: MeasuredMoves) -> Mask:
    """(n,) the `late` moves, and all that the same line of the program makes where these wait there for times that
    differ: those that are not far out wait for less, and what they are late by tells nothing of the arm."""
    waits = residual[late]
    if len(waits) < FEWEST_FAR or waits.std() < _DIFFER * waits.mean():
        return late
    return late | of_one_line(late, case)


def of_one_line(late: Mask, case: MeasuredMoves) -> Mask:
    """(n,) all moves of the line of the program that all `late` (n,) ones come from; none where that is none."""
    lines = {(case.job[k], int(case.line[k])) for k in np.flatnonzero(late).tolist()}
    job, line = lines.pop() if len(lines) == 1 else ("", 0)
    of_job = np.array([one == job for one in case.job], dtype=np.bool_)
    return np.asarray(of_job & (case.line == line) & (line > 0), dtype=np.bool_)


def _flaw(fitted: ModelFit, case: MeasuredMoves) -> Floats:
    """(n,) [s] by which the terms may be off in a move: what other numbers in each of them would change there."""
    predicted = fitted.model.seconds(case)
    whole = np.zeros(len(case))
    for k, part in enumerate(fitted.model.parts):
        most = np.zeros(len(case))
        for factor in (1.0 - _FORM, 1.0 + _FORM):
            parts = list(fitted.model.parts)
            parts[k] = part._replace(values=_stronger(part, factor))
            most = np.maximum(most, np.abs(DurationModel(tuple(parts)).seconds(case) - predicted))
        whole += most
    return whole


def _stronger(part: ModelPart, factor: float) -> Floats:
    """(p,) values that are `factor` times as far from those at which the part does nothing."""
    values = []
    for parameter, value in zip(part.form.parameters, part.values.tolist(), strict=True):
        if not math.isfinite(parameter.null):
            values.append(factor * value)
        elif parameter.log:
            values.append(parameter.null * (value / parameter.null) ** factor)
        else:
            values.append(parameter.null + factor * (value - parameter.null))
    return np.array(values)


def waiting_moves(apart: Mask, residual: Floats, sigma: float, resolution: float) -> Mask:
    """(n,) of the moves that are set `apart` (n,) those that are late, and where there are any, also those that more
    likely wait for less than scatter.

    A mixture of scatter and of waits that are spread as an exponential, fitted by expectation and maximisation
    (A. Dempster, N. Laird, D. Rubin, J. Royal Statistical Society B 39, 1977).
    """
    late = apart & (residual > _LEAST * sigma)
    if not late.any():
        return apart
    far = residual / sigma
    scatter = np.exp(-0.5 * np.minimum(far, 30.0) ** 2) / math.sqrt(2.0 * math.pi)
    likely = late.astype(np.float64)
    for _ in range(_ROUNDS):
        share, mean = float(likely.mean()), float((likely * far).sum() / likely.sum())
        waits = share / mean * np.exp(-np.maximum(far, 0.0) / mean)
        either = waits + (1.0 - share) * scatter
        likely = np.where(late, 1.0, np.where(far > 0, waits / np.maximum(either, 1e-300), 0.0))
        # What is below the middle of the scatter's reach tells nothing of waits.
        likely = np.where(late | (far > _LEAST), likely, 0.0)
    return np.asarray(late | ((likely > 0.5) & (residual > _TICKS * resolution)))


def tails_of(left: Floats, case: MeasuredMoves, beside_names: bool = False) -> float:
    """[s²] of the mean square of what is left (n,) [s]: what moves far out are worth that a heavy-tailed scatter makes.

    A scatter is early as often as it is late, and as far; an effect that acts in few moves is not. What the two tails
    have in common counts: all but the squared distance between their quantiles (the Wasserstein distance of the
    residuals from their mirror image, C. Mallows, Annals of Mathematical Statistics 43, 1972); of one or two moves
    nothing tells whether the other tail is as heavy, and they count; of more, the farthest counts alone where it has
    no like on the other side, as no single move decides. Moves that are as far out in their repeats, or that are of one
    kind, are no scatter; nor are more than there are half as far out, which would be tails heavier than A. Cauchy's:
    of one or two `beside_names` that explain all others nothing tells that, either.
    """
    off = left - np.median(left)
    far = far_out(off, case.resolution)
    few = beside_names and far.sum() < FEWEST_FAR
    many = 2 * far.sum() > far_out(off, case.resolution, 0.5).sum() and not few
    if many or not far.any() or _chosen_by_the_motion(far, np.zeros(len(case)), case, LEVEL):
        return 0.0
    far &= ~_repeated(off, far, case)
    if far.sum() < FEWEST_FAR:
        return float(off[far] @ off[far]) / len(off)
    farthest = np.arange(len(off)) == np.argmax(np.where(far, np.abs(off), 0.0))
    apart = float(off[farthest] @ off[farthest]) + _on_both_sides(off[far & ~farthest])
    return max(_on_both_sides(off[far]), apart) / len(off)


def _on_both_sides(off: Floats) -> float:
    """[s²] sum of squares that the late and the early ones of moves `off` (m,) [s] have in common, the farthest with
    the farthest."""
    late, early = (np.sort(side[side > 0])[::-1] for side in (off, -off))
    both = min(len(late), len(early))
    return 2.0 * float(late[:both] @ early[:both])


def _repeated(off: Floats, far: Mask, case: MeasuredMoves) -> Mask:
    """(n,) far-out moves whose repeats are more than half as far out, on the mean."""
    if len(case.repeats) != len(case):
        return np.zeros_like(far)
    _, group, count = np.unique(case.repeats, return_inverse=True, return_counts=True)
    others = (np.bincount(group, off)[group] - off) / np.maximum(count[group] - 1, 1)
    return np.asarray(far & (np.sign(off) * others > 0.5 * np.abs(off)))


def _chosen_by_the_motion(
    late: Mask, corrected: Floats, case: MeasuredMoves, level: float = _BY_CHANCE, among: Mask | None = None
) -> bool:
    """Whether late moves are those of one kind `among` (n,) these: steep, long, fast, far out. Waits do not choose.

    One look per programmed move, by ranks (H. Mann, D. Whitney, Annals of Mathematical Statistics 18, 1947).
    """
    one = np.arange(len(case)) if among is None else np.flatnonzero(among)
    columns = [*_of_the_motion(late, case), corrected]
    if len(case.repeats) == len(case):
        late = np.isin(case.repeats, case.repeats[late if among is None else late & among])
        one = one[np.unique(case.repeats[one], return_index=True)[1]]
    late = late[one]
    few, many = int(late.sum()), int((~late).sum())
    if few < _KINDS or many < _KINDS:
        return False
    for column in columns:
        values = column[one]
        if not np.isfinite(values).all() or np.ptp(values) <= 0:
            continue
        excess = float(ranks(values)[late].sum()) - few * (few + many + 1) / 2.0
        z = abs(excess) / math.sqrt(few * many * (few + many + 1) / 12.0)
        if math.erfc(z / math.sqrt(2.0)) * len(columns) < level:
            return True
    axes = [case.led(k)[one] for k in range(len(case.rates.names))] if case.rates is not None else []
    return any(_as_many_by_chance(late, led) * len(axes) < level for led in axes)


def _as_many_by_chance(late: Mask, inside: Mask) -> float:
    """Probability that as many of the `late` (n,) are `inside` (n,) where chance deals them (hypergeometric)."""
    count, size, few = len(late), int(inside.sum()), int(late.sum())

    def ways(of: int, some: int) -> float:
        return math.lgamma(of + 1) - math.lgamma(some + 1) - math.lgamma(of - some + 1)

    most = min(size, few)
    return sum(
        math.exp(ways(size, k) + ways(count - size, few - k) - ways(count, few))
        for k in range(max(int((late & inside).sum()), few + size - count), most + 1)
    )


def _of_the_motion(late: Mask, case: MeasuredMoves) -> tuple[Floats, ...]:
    """(n,) each: what a move is like, and how long the one before it takes, as a planner that runs dry is no wait; but
    where all `late` moves (n,) come from one line, they come behind another."""
    turned = np.nan_to_num(case.turn) / np.maximum(case.base.way, 1e-6)
    reaches = [np.hypot(place[:, 0], place[:, 1]) for place in (case.start, case.end)]
    loads = (case.payload, case.payload_inertia)
    columns = (case.rise, case.base.way, case.base.speed, case.turn, turned, *loads, *reaches)
    if of_one_line(late, case).any():
        return columns
    return *columns, np.where(case.follows, np.roll(case.simulated, 1), np.median(case.simulated))


def _with_the_motion(
    residual: Floats, late: Mask, case: MeasuredMoves, more: tuple[Floats, ...] = ()
) -> float:
    """Probability that chance makes sizes of waits go with a property of the moves, or with `more` (n,) of them, as far
    as these do: a wait does not know how long, fast or loaded the move is. One look per property that differs between
    the late moves."""
    waits = residual[late]
    columns = [column[late] for column in (case.simulated, *_of_the_motion(late, case), *more)]
    columns = [column for column in columns if np.isfinite(column).all() and np.ptp(column) > 0]
    together = max((abs(rank_correlation(waits, column)) for column in columns), default=0.0)
    return 2.0 * _tail(together, len(waits)) * len(columns)


def _tail(rho: float, count: int) -> float:
    """Probability of a correlation of ranks of at least that by chance (C. Spearman, American Journal of Psychology 15,
    1904): its inverse hyperbolic tangent is near enough normal (E. Fieller, H. Hartley, E. Pearson, Biometrika 44,
    1957), but no order of few ranks is rarer than one in all of them."""
    z = math.atanh(max(min(rho, 1.0 - 1e-9), 1e-9 - 1.0)) * math.sqrt((count - 3) / 1.06)
    return max(0.5 * math.erfc(z / math.sqrt(2.0)), 1.0 / math.factorial(min(count, 20)))


def _the_same_moves(residual: Floats, late: Mask, case: MeasuredMoves, sigma: float) -> bool:
    """Whether the late moves are late in every repeat, and always by the same time: that is the move, not a wait."""
    if len(case.repeats) != len(case):
        return False
    always, square, freedom, waits = 0, 0.0, 0, 0.0
    for label in np.unique(case.repeats[late]).tolist():
        alike = residual[case.repeats == label]
        if len(alike) > 1 and alike.min() > 2.0 * sigma:
            always += int((late & (case.repeats == label)).sum())
            square += float(((alike - alike.mean()) ** 2).sum())
            freedom += len(alike) - 1
            waits += (len(alike) - 1) * float(alike.mean()) ** 2
    if always <= 0.5 * int(late.sum()) or square >= _SCATTERED * freedom * sigma**2:
        return False
    differing = freedom * sigma**2 + _DIFFER**2 * waits
    return _as_small_by_chance(square / differing * freedom, freedom) < _ALIKE


def _of_one_way(residual: Floats, late: Mask, case: MeasuredMoves) -> bool:
    """Whether the late moves are late by about the same time, and any two of them begin and end nearer to each other
    than any does to a move in time: that is the move, wherever a camera or a pallet puts its ends, not a wait."""
    waits, few, many = residual[late], int(late.sum()), int(case.moving.sum())
    if waits.std() >= _DIFFER * waits.mean() or (few / max(many, 1)) ** few > _BY_CHANCE:
        return False
    places = np.concatenate([case.start, case.end], axis=1)
    apart = np.linalg.norm(places[late][:, None] - places[case.moving], axis=2)
    together = late[case.moving]
    if together.all() or not together.any():
        return False
    return bool(apart[:, together].max() < apart[:, ~together].min())  # never where places are not known


def _as_small_by_chance(x: float, freedom: int) -> float:
    """Probability of a chi square of no more than x (E. Wilson, M. Hilferty, PNAS 17, 1931)."""
    k = 2.0 / (9.0 * freedom)
    return 0.5 * math.erfc((1.0 - k - (x / freedom) ** (1.0 / 3.0)) / math.sqrt(2.0 * k))


def threshold(count: int) -> float:
    """[1] standard deviations that the largest of `count` normal values passes with probability `_LEVEL`."""
    tail = _LEVEL / max(count, 1)
    low, high = 1.0, 12.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if 0.5 * math.erfc(middle / math.sqrt(2.0)) > tail else (low, middle)
    return high
