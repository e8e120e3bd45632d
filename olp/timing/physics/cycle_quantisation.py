"""`cycle-quantisation`: durations are whole multiples of the controller's cycle."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_SHORTEST, _LONGEST = 5e-4, 0.25  # [s]
_EQUAL = 1e-5  # [s] by which simulated durations of one kind differ at most
_FEWEST = 12
_FEW = 6  # durations that differ, where the cycle is known: they only have to tell what was late
_LOOKED_AT = 240  # moves
_SURE = 0.12  # of the coherence: durations that are multiples have 1, any others about 1/√n
_DOUBT = 7.0  # that scatter passes in no frequency with probability 1 - exp(-7)
_STEP, _NEAR = 0.12, 3  # of a cycle at the longest duration, and so many steps to both sides
_SURELY = 1e-3  # of a cycle: so near the lattice found tells it, at best
_ROUND = 0.02  # of a cycle at the longest duration: what the lattice found leaves open
_DIGITS = 0.8  # of the frequency of the clock's digits: shorter cycles cannot be seen
_OTHERS = 3  # cycles that are tried
_TEETH = 1.25  # 1 + 1/4: mean square of a saw tooth's first two sines, over that of the first
_FAR, _TOLD_SIZE = 3.0, 1.5  # times the scatter, and times the size that it should have, at most
_TIMED = "but waits"  # which end by a timer of their own
_MOVING = r"\ \text{(moves)}"
_BETWEEN = 0.02  # of a cycle: nearer to a multiple, rounding does not change a wait
_NEARLY = 0.6  # of the coherence of the best: less is no candidate


class CycleQuantisation(MoveTerm):
    summary = "durations are whole multiples of the controller's cycle"
    does = "durations fall on a lattice; the differences are spread evenly from zero to one cycle"
    source = "interpolation cycle of controllers (4, 8, 12 ms); lattice found by the coherence |Σ exp(2πi T/c)| / n"
    confusable = ("dispatch", "settling")
    stage = Stage.CLOCKS
    conditionable = False

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        found = _found(case).tolist()
        longest = float(case.measured[case.moving].max(initial=0.0))
        polled = [_later("polled", case.polled, longest)] if _differ(case) and case.polled > 0 else []
        rounded = [form for rank, cycle in enumerate(found) for form in _rounded(rank, cycle, longest)]
        timed = [
            form._replace(key=f"{form.key} {_TIMED}".strip(), equation=form.equation + _MOVING)
            for form in rounded[:2]  # the likeliest cycle's
            if _between(case, found[0])
        ]
        return (*polled, *rounded, *timed)

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        one = form.parameters[0]
        middle = 0.5 * (one.low + one.high)
        # Scatter leaves the cycle open by a part of what makes one multiple more of the longest duration.
        share = middle / max(float(case.measured[case.moving].max()), middle)
        steps = np.arange(1, _NEAR + 1)
        near = middle * (1.0 + _STEP * share * np.concatenate([[0], -steps, steps]))
        # Controllers have round cycles, and timers that are multiples of them: half a step less is one cycle more.
        near = np.append(near, _roundest(middle, _ROUND * share * middle))
        return np.asarray(np.clip(near, one.low, one.high)[:, None])

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        early = 0.5 if form.key.startswith("nearest") else 0.0
        return motion.with_(cycle=float(values[0]), early=early, timed=form.key.endswith(_TIMED))

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        of = "durations of motion" if form.key.endswith(_TIMED) else "durations"
        return f"{of} are whole multiples of {values[0] * 1000:.3g} ms"


def _rounded(rank: int, cycle: float, longest: float) -> tuple[Form, Form]:
    """Durations, the `longest` [s] among them, rounded up to a cycle [s], and to the nearest; `rank`: 0 for the
    likeliest cycle."""
    other = f"other {rank}" if rank else ""
    later = _later(other, cycle, longest)
    return later, Form(f"nearest {other}".strip(), later.parameters, r"T = c \lfloor T_0 / c + 1/2 \rfloor")


def _later(key: str, cycle: float, longest: float) -> Form:
    """Moves end with the next cycle [s]: what a recorder that looks in cycles tells too late once it tells too early as
    often, so of its cycle there is no other form. The `longest` [s] leaves it open by what is looked at."""
    about = max(_SURELY, (_NEAR + 1) * _STEP * cycle / max(longest, cycle))
    one = TermParameter(
        "cycle", "s", cycle * (1 - about), cycle * (1 + about), 0.0, False, "of the controller"
    )
    return Form(key, (one,), r"T = c \lceil T_0 / c \rceil")


def _between(case: MeasuredMoves, cycle: float) -> bool:
    """Whether some of the simulated waits would end between two cycles [s]."""
    multiples = case.simulated[~case.moving] / cycle
    return bool((np.abs(multiples - np.round(multiples)) > _BETWEEN).any())


def _differ(case: MeasuredMoves) -> bool:
    """Whether there are enough durations, and these differ by more than two of the cycle in which they are told."""
    times = case.measured[case.moving]
    return len(np.unique(times)) >= _FEW and case.polled < 0.5 * float(np.ptp(times))


def _roundest(value: float, error: float) -> float:
    """The number with the fewest decimals within `error` of a value."""
    rounded = (round(value, digits) for digits in range(2, 9))
    return next((one for one in rounded if abs(one - value) <= error), value)


def _found(case: MeasuredMoves) -> Floats:
    return case.once("lattice", lambda: _lattices(case))


def _lattices(case: MeasuredMoves) -> Floats:
    """Candidate cycles (c,) [s] of which the durations may be multiples, the likeliest first; none if none stands
    out.

    Durations that a recorder has rounded to r look the same at the frequencies f and 1/r - f: both are candidates.
    What moves are late by tells how much each was rounded up, also where scatter hides the multiples. Moves that take
    the same time in the simulation count as one: a few that are repeated often lie on some lattice by chance.
    """
    moving = np.nonzero(case.moving)[0]
    times, kind = case.measured[moving], _kinds(case.simulated[moving])
    alike = int(kind.max(initial=-1)) + 1
    spread = float(np.ptp(times)) if len(times) else 0.0
    shortest = max(_SHORTEST, 2.0 * case.resolution)
    # A cycle as long as durations differ would be told by anything that is not spread evenly.
    longest = min(_LONGEST, 0.5 * spread)
    if alike < _FEWEST or shortest >= longest:
        return np.zeros(0)
    # Short durations have few multiples to choose from: they tell the lattice with the fewest frequencies to try.
    order = np.argsort(times, kind="stable")
    order = order[np.cumsum(_one_of_each(kind[order])) <= max(_FEWEST, 0.75 * alike)]
    order = order[:: max(1, len(order) // _LOOKED_AT)]
    few, each = times[order], _one_of_each(kind[order])
    # Frequencies so fine that the longest duration is no more than a sixth of a turn off between two of them.
    step = 0.33 / max(float(few.max()), 1e-3)
    frequency = np.arange(1.0 / longest, 1.0 / shortest, step)
    if len(frequency) < 2:
        return np.zeros(0)
    strong = _coherence(few, frequency, each)
    needed = max(_SURE, float(np.sqrt((np.log(len(frequency)) + _DOUBT) / each.sum())))
    peaks = _peaks(frequency, strong, needed)
    late = _rounded_up(case.residual[moving], case.simulated[moving], kind, shortest, longest)
    fine = [_finest(times, f, step) for f in peaks]
    fine = [f for f in fine if all(abs(f - one) * float(times.max()) > 1.0 for one in late)]
    if case.resolution > 0:
        mirrored = [1.0 / case.resolution - f for f in fine]
        fine += [f for f in mirrored if f * case.resolution < _DIGITS]
    return 1.0 / np.array([*late, *fine])


def _kinds(simulated: Floats) -> NDArray[np.int64]:
    """(n,) equal for moves whose simulated durations (n,) [s] are."""
    _, kind = np.unique(np.round(simulated / _EQUAL), return_inverse=True)
    return np.asarray(kind.ravel(), dtype=np.int64)


def _one_of_each(kind: NDArray[np.int64]) -> Floats:
    """(n,) weights, which for all of one `kind` (n,) come to one."""
    return np.asarray(1.0 / np.bincount(kind)[kind])


def _rounded_up(
    late: Floats, times: Floats, kind: NDArray[np.int64], shortest: float, longest: float
) -> list[float]:
    """The frequency [1/s] of the cycle that makes moves late by what their simulated durations lack to a multiple of
    it, none where none stands out: that is a saw tooth over these, c/2 + (c/π) (sin(2π T₀/c) + sin(4π T₀/c)/2 + …).
    `late`, `times` (n,) [s]; `kind` (n,): moves that count as one.

    The share that its first two sines, which scatter hides least, have in what is late tells the cycle by its phase and
    by its size.
    """
    late = late - np.median(late)
    scatter = 1.4826 * float(np.median(np.abs(late)))
    if not scatter > 0 or not np.isfinite(times).all():
        return []
    each = _one_of_each(kind)
    clipped = np.clip(late, -_FAR * scatter, _FAR * scatter)
    late, times = (np.asarray(np.bincount(kind, each * of), dtype=np.float64) for of in (clipped, times))
    late, alike = late - late.mean(), len(late)
    frequency = np.arange(1.0 / longest, 1.0 / shortest, 0.33 / max(float(times.max()), 1e-3))
    if len(frequency) < 2:
        return []
    size = _toothed(times, frequency, late) / (0.5 * _TEETH * alike)
    told = size * np.pi * frequency  # of the size that the tooth has
    # Scatter alone correlates with a sine by r or more with a chance below (1 - r²)^(m/2) / (r √(2π m)), m = n - 2.
    square = 0.5 * _TEETH * np.maximum(size, 0.0) ** 2 / float(late.var())
    square = np.clip(square, 1e-9, 1.0 - 1e-9)
    chance = 0.5 * (alike - 2) * np.log1p(-square) - 0.5 * np.log(2.0 * np.pi * (alike - 2) * square)
    sure = -chance > np.log(len(frequency)) + _DOUBT
    likely = sure & (told > 1.0 / _TOLD_SIZE) & (told < _TOLD_SIZE)
    if not likely.any():
        return []
    best = float(frequency[np.argmax(np.where(likely, size, 0.0))])
    near = best + np.linspace(-1.0, 1.0, 81) * (frequency[1] - frequency[0])
    return [float(near[np.argmax(_toothed(times, near, late))])]


def _toothed(times: Floats, frequency: Floats, weight: Floats) -> Floats:
    """Σ w (sin(2π f T) + sin(4π f T)/2) (f,): how a saw tooth's first sines go with the weights of durations."""
    return _sums(times, frequency, weight).imag + 0.5 * _sums(times, 2.0 * frequency, weight).imag


def _peaks(frequency: Floats, strong: Floats, needed: float) -> list[float]:
    """The strongest frequencies [1/s], the fundamental instead of its multiples."""
    left, found = strong.copy(), list[float]()
    while len(found) < _OTHERS:
        at = int(np.argmax(left))
        if left[at] < needed or left[at] < _NEARLY * float(strong.max()):
            break
        best = float(frequency[at])
        # A lattice of c is also one of c/2, c/3, …: the longest that is as good leads.
        for part in range(8, 1, -1):
            near = np.abs(frequency - best / part) <= 1.5 * (frequency[1] - frequency[0])
            if near.any() and strong[near].max() > 0.93 * left[at]:
                best = float(frequency[near][np.argmax(strong[near])])
                break
        found.append(best)
        multiple = np.abs(frequency / best - np.round(frequency / best)) * best
        left[multiple <= 4.0 * (frequency[1] - frequency[0])] = 0.0
    return found


def _finest(times: Floats, frequency: float, step: float) -> float:
    """The best frequency [1/s] near a given one, refined with ever longer durations."""
    ordered = np.sort(times)
    count = min(_LOOKED_AT, len(ordered))
    while True:
        some = ordered[:count]
        near = np.linspace(frequency - step, frequency + step, 81)
        near = near[near > 0]
        frequency = float(near[np.argmax(_coherence(some, near, np.ones(count)))])
        if count == len(ordered):
            return frequency
        step = min(step, 0.33 / max(float(some.max()), 1e-3))
        count = min(2 * count, len(ordered))


def _coherence(times: Floats, frequency: Floats, weight: Floats) -> Floats:
    """Coherence (f,) [1] of the durations, each of some weight, at evenly spaced frequencies."""
    return np.asarray(np.abs(_sums(times, frequency, weight)) / weight.sum())


def _sums(times: Floats, frequency: Floats, weight: Floats) -> NDArray[np.complex128]:
    """Σ w exp(2πi f T) (f,) over durations at evenly spaced frequencies.

    Each phase is a coarse frequency's phase times a remainder's, so that all pairs are one product of matrices.
    """
    count = len(frequency)
    fine = max(1, math.isqrt(count))
    step = (frequency[-1] - frequency[0]) / max(1, count - 1)
    coarse = weight * np.exp(2j * np.pi * np.outer(frequency[::fine], times))
    rest = np.exp(2j * np.pi * step * np.outer(times, np.arange(fine)))
    return np.asarray((coarse @ rest).ravel()[:count])
