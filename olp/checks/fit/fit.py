"""A program brought down to a time with as few edits as possible.

Every choice is timed in the program itself, many at once where they are too far apart to touch each other. What they
gain is nearly additive, and an edit counts as one however far it goes: the fewest that are enough are then those that
gain most, which needs no solver (the tests compare with SciPy's `milp`). What corners shared by two edited moves add or
take is put right by timing the answer and asking for the difference as well; at the end every edit has to be needed.

Codes: U030 a program that cannot be timed whole, U031 a time that is none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from olp.checks.fit.choices import Allowed, Choice, apply, choices, seconds_of
from olp.core.diagnostic import Diagnostic, OlpError, Span, error
from olp.core.units import mm
from olp.ir.program import Program
from olp.runtime.plan import StepKind
from olp.timing.track import states

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from olp.timing.timing import Timing

Run = Callable[[Program], "Timing"]

_LEAST_S = 1e-4  # [s] a choice that gains less is none
_APART = 4  # places that are timed at once: one in so many, so that no move has two edited neighbours
_ROUNDS = 12
_SAMPLES = 161  # of the way round a corner
_SMALL = 10  # places up to which fewer edits are looked for one by one
_HELD = 1e-9  # [s]


@dataclass(frozen=True, slots=True)
class FittedEdit:
    """`gained_s` [s] in the new program; `deviation_mm`: how far its corner passes the point; `limit`: what rules."""

    choice: Choice
    gained_s: float
    deviation_mm: float
    limit: str


class FrontPoint(NamedTuple):
    """What so many edits, passing corners by so much, can do at best."""

    edits: int
    within_mm: float
    total_s: float


@dataclass(frozen=True, slots=True)
class Fit:
    """`program` is the edited one, and `timing` its; `before_s` [s] the total as it was. `reached`: as fast as `to_s`.

    `needed_s` [s]: the total from which on `to_s` holds in 95 % of cases; None where no interval is known.
    """

    program: Program
    timing: Timing
    before_s: float
    to_s: float
    reached: bool
    edits: tuple[FittedEdit, ...]
    front: tuple[FrontPoint, ...]
    limits: tuple[str, ...] = ()

    @property
    def needed_s(self) -> float | None:
        ends = self.timing.total_ends
        return None if ends is None or ends[1] <= 0.0 else self.to_s * self.timing.total_s / ends[1]


def fit(program: Program, to_s: float, run: Run, allowed: Allowed) -> Fit:
    """The fewest edits with which `program` takes at most `to_s` [s]; where there are none, what can be done at best.

    Raises OlpError (O001, U030, U031).
    """
    work = _Work(program, run, allowed)
    if not to_s > 0.0:
        raise OlpError(error("U031", f"a time is above zero, not {to_s:g} s"))
    chosen: list[Choice] = []
    if work.base.total_s > to_s + _HELD:
        chosen = work.solved(work.base.total_s - to_s)
    front = tuple(work.front(allowed.within))
    return work.answer(chosen, to_s, front)


class _Work:
    """A program with all its choices, and what each gains alone [s]."""

    def __init__(self, program: Program, run: Run, allowed: Allowed) -> None:
        self.program, self.run, self.allowed = program, run, allowed
        self.base = run(program)
        _check(self.base)
        self._told = {(d.code, d.line) for d in self.base.diagnostics}
        self._known: dict[frozenset[Choice], tuple[float, float]] = {}
        found = choices(program, self.base, allowed)
        self.gains = self._alone(found)
        self.choices = [one for one in found if self.gains.get(one, 0.0) > _LEAST_S]

    # --- what a choice gains

    def _alone(self, found: Sequence[Choice]) -> dict[Choice, float]:
        """Gains of all choices, level by level, of every fourth place at once."""
        places: dict[tuple[str, int], list[Choice]] = {}
        for one in found:
            places.setdefault(one.place, []).append(one)
        order = self._order(places)
        gains: dict[Choice, float] = {}
        ended: set[tuple[str, int]] = set()  # corners that are passed too far already
        for level in range(max(map(len, places.values()), default=0)):
            for kind in ("speed", "zone"):
                for start in range(_APART):
                    some = [
                        places[place][level]
                        for place in order[kind][start::_APART]
                        if len(places[place]) > level and place not in ended
                    ]
                    alone = self._together(some)
                    ended.update(one.place for one in some if one.zone >= 0 and one not in alone)
                    gains |= alone
        return gains

    def _order(self, places: dict[tuple[str, int], list[Choice]]) -> dict[str, list[tuple[str, int]]]:
        first: dict[int, int] = {}
        for step, line in enumerate(self.base.plan.line.tolist()):
            first.setdefault(line, step)
        known = sorted(places, key=lambda place: first.get(places[place][0].line, 0))
        return {kind: [place for place in known if place[0] == kind] for kind in ("speed", "zone")}

    def _together(self, some: Sequence[Choice]) -> dict[Choice, float]:
        """What each of `some`, far from each other, gains; those that pass a corner too far gain nothing."""
        if not some:
            return {}
        timing = self._timed(some)
        if timing is None:
            # One of them cannot be: it is in one of the halves.
            half = len(some) // 2
            return self._together(some[:half]) | self._together(some[half:]) if half else {}
        gained = seconds_of(self.base, timing, [self._lines(one) for one in some])
        far = deviations(timing, [one.line for one in some if one.zone >= 0])
        return {
            one: seconds
            for one, seconds in zip(some, gained.tolist(), strict=True)
            if one.zone < 0 or far[one.line] <= self.allowed.within
        }

    def _lines(self, choice: Choice) -> list[int]:
        return sorted({choice.line, choice.place[1]})

    def _timed(self, some: Sequence[Choice]) -> Timing | None:
        """The program with `some`; None where it does something else, or something new is wrong."""
        try:
            timing = self.run(apply(self.program, some))
        except OlpError:
            return None
        same = len(timing.plan) == len(self.base.plan) and np.array_equal(
            timing.plan.kind, self.base.plan.kind
        )
        new = {(d.code, d.line) for d in timing.diagnostics} - self._told
        return timing if same and not new else None

    def total(self, chosen: Sequence[Choice]) -> tuple[float, float]:
        """Seconds of the program with these edits, and how far it passes a corner [m]; inf where it cannot be."""
        key = frozenset(chosen)
        if key not in self._known:
            timing = self._timed(chosen)
            if timing is None:
                self._known[key] = (np.inf, np.inf)
            else:
                far = max(
                    deviations(timing, [one.line for one in chosen if one.zone >= 0]).values(), default=0.0
                )
                self._known[key] = (timing.total_s, far)
        return self._known[key]

    def _holds(self, chosen: Sequence[Choice], to_s: float) -> bool:
        seconds, far = self.total(chosen)
        return seconds <= to_s + _HELD and far <= self.allowed.within

    # --- the fewest

    def solved(self, need: float) -> list[Choice]:
        """The fewest edits that gain `need` [s]; all that help where that is not enough."""
        to_s = self.base.total_s - need
        asked = need
        for _ in range(_ROUNDS):
            found = cover(self.choices, self.gains, asked)
            if found is None:
                break
            if self._holds(found, to_s):
                return self._fewer(found, to_s)
            seconds, far = self.total(found)
            if far > self.allowed.within:
                return self._fewer_or_most(to_s)
            asked += max(seconds - to_s, 1e-6) * 1.05
        return self._fewer_or_most(to_s)

    def _fewer_or_most(self, to_s: float) -> list[Choice]:
        most = self.most(self.choices)
        return self._fewer(most, to_s) if self._holds(most, to_s) else most

    def most(self, some: Sequence[Choice]) -> list[Choice]:
        """Of each place what gains most; corners give way until none is passed too far."""
        best: dict[tuple[str, int], Choice] = {}
        for one in some:
            if one.place not in best or self.gains[one] > self.gains[best[one.place]]:
                best[one.place] = one
        chosen = list(best.values())
        timing = self._timed(chosen)
        if timing is not None:
            far = deviations(timing, [one.line for one in chosen if one.zone >= 0])
            chosen = [one for one in chosen if one.zone < 0 or far[one.line] <= self.allowed.within]
        return chosen

    def _fewer(self, chosen: list[Choice], to_s: float) -> list[Choice]:
        """Without edits that are not needed; in small programs no smaller set of places is enough."""
        for one in sorted(chosen, key=lambda c: self.gains[c])[:40]:
            rest = [other for other in chosen if other is not one]
            if self._holds(rest, to_s):
                chosen = rest
        best = self.most(self.choices)
        if len(best) <= _SMALL:
            for some in combinations(sorted(best, key=lambda c: -self.gains[c]), max(0, len(chosen) - 1)):
                if self._holds(some, to_s):
                    return self._fewer(list(some), to_s)
        return chosen

    # --- what is told

    def front(self, within: float) -> Iterator[FrontPoint]:
        """The best total for each number of edits, then for each share of the deviation."""
        last = self.base.total_s
        yield FrontPoint(0, 0.0, last)
        best = sorted(self.most(self.choices), key=lambda c: -self.gains[c])
        for count in _counts(len(best)):
            seconds, far = self.total(best[:count])
            if seconds < last - _LEAST_S and far <= within:
                last = seconds
                yield FrontPoint(count, round(far / mm, 6), seconds)
        if any(one.zone >= 0 for one in best):
            seconds, _ = self.total(self.most([one for one in self.choices if one.zone < 0]))
            if np.isfinite(seconds):
                yield FrontPoint(len({c.place for c in self.choices if c.zone < 0}), 0.0, seconds)

    def answer(self, chosen: Sequence[Choice], to_s: float, front: tuple[FrontPoint, ...]) -> Fit:
        chosen = sorted(chosen, key=lambda one: (one.line, one.kind))
        program = apply(self.program, chosen) if chosen else self.program
        timing = self.run(program)
        gained = seconds_of(self.base, timing, [self._lines(one) for one in chosen])
        far = deviations(timing, [one.line for one in chosen if one.zone >= 0])
        edits = tuple(
            FittedEdit(
                one,
                float(seconds),
                far[one.line] / mm if one.zone >= 0 else 0.0,
                _limit(timing, one.line),
            )
            for one, seconds in zip(chosen, gained.tolist(), strict=True)
        )
        reached = timing.total_s <= to_s + _HELD
        limits = () if reached else tuple(_limits(timing))
        return Fit(program, timing, self.base.total_s, to_s, reached, edits, front, limits)


def cover(some: Sequence[Choice], gains: Mapping[Choice, float], need: float) -> list[Choice] | None:
    """The fewest of `some`, at most one of each place, that gain `need` [s] together; None where all are not enough.

    No set of so many places gains more than those that gain most. Of these each goes no further than it has to.
    """
    levels: dict[tuple[str, int], list[Choice]] = {}
    for one in some:
        levels.setdefault(one.place, []).append(one)
    best = sorted((max(of, key=lambda c: gains[c]) for of in levels.values()), key=lambda c: -gains[c])
    spare = -need
    chosen: list[Choice] = []
    for one in best:
        if spare >= 0.0:
            break
        chosen.append(one)
        spare += gains[one]
    if spare < 0.0:
        return None
    for at, one in enumerate(chosen):
        for other in sorted(levels[one.place], key=lambda c: c.effort):
            if other.effort < one.effort and gains[one] - gains[other] <= spare:
                spare -= gains[one] - gains[other]
                chosen[at] = other
                break
    return chosen


def deviations(timing: Timing, lines: Sequence[int]) -> dict[int, float]:
    """By how much the tool passes the point of the move on each line [m], first and last execution; inf: not known."""
    plan = timing.plan
    if not lines:
        return {}
    if np.isnan(timing.duration_s).any():
        return dict.fromkeys(lines, float("inf"))
    ends = np.concatenate(([0.0], timing.end_s))
    moving = (plan.source == 0) & (plan.kind == StepKind.MOVE)
    corners: list[tuple[int, int]] = []
    for line in dict.fromkeys(lines):
        steps = np.flatnonzero(moving & (plan.line == line)).tolist()
        corners += [(line, step) for step in dict.fromkeys(steps[:1] + steps[-1:])]
    # Dense where one move ends and the next begins.
    place = np.linspace(-1.0, 1.0, _SAMPLES)
    times = []
    for _, step in corners:
        before, here, after = ends[step], ends[step + 1], ends[min(step + 2, len(ends) - 1)]
        times.append(here + place * abs(place) * np.where(place < 0.0, here - before, after - here))
    position, _, _ = states(timing, np.concatenate(times) if times else np.zeros(0))
    found = dict.fromkeys(lines, 0.0)
    for number, (line, step) in enumerate(corners):
        way = position[number * _SAMPLES : (number + 1) * _SAMPLES]
        target = plan.positions.position[int(plan.moves.target[int(plan.row[step])])]
        known = not (np.isnan(target).any() or np.isnan(way).any())
        found[line] = max(found[line], _distance(target, way) if known else float("inf"))
    return found


def deviation(timing: Timing, line: int) -> float:
    """That of one line [m]."""
    return deviations(timing, [line])[line]


def _distance(point: NDArray[np.float64], way: NDArray[np.float64]) -> float:
    """[m] from a point to a polyline."""
    start, along = way[:-1], np.diff(way, axis=0)
    square = (along**2).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.clip(np.nan_to_num(((point - start) * along).sum(axis=1) / square), 0.0, 1.0)
    return float(np.linalg.norm(start + share[:, None] * along - point, axis=1).min())


def _counts(most: int) -> list[int]:
    """Up to a dozen numbers of edits, dense where few do much."""
    return (
        sorted(
            {*range(1, min(most, 6) + 1), *np.unique(np.geomspace(1, max(most, 1), 7).astype(int)).tolist()}
            - {0}
        )
        if most
        else []
    )


def _limit(timing: Timing, line: int) -> str:
    plan = timing.plan
    steps = np.flatnonzero((plan.line == line) & (plan.source == 0))
    return timing.limited_by[int(steps[0])] if len(steps) else ""


def _limits(timing: Timing) -> Iterator[str]:
    """What stops the program from being faster: the lines that take longest, and what rules them."""
    plan = timing.plan
    seconds: dict[tuple[int, int], float] = {}
    rules: dict[tuple[int, int], str] = {}
    steps = zip(
        plan.source.tolist(), plan.line.tolist(), timing.duration_s.tolist(), timing.limited_by, strict=True
    )
    for source, line, s, rule in steps:
        seconds[source, line] = seconds.get((source, line), 0.0) + (s if s == s else 0.0)
        rules.setdefault((source, line), rule or "a wait or a signal")
    for place in sorted(seconds, key=lambda one: -seconds[one])[:3]:
        text = plan.sources[place[0]]
        name = "" if place[0] == 0 else f"{Path(text.path).name} "
        yield f"{name}line {place[1]}: {seconds[place]:.3f} s, {rules[place]}: {text.line(place[1]).strip()}"


def _check(timing: Timing) -> None:
    """Raises OlpError (U030): what is not known cannot be brought down."""
    problems: list[Diagnostic] = [d for d in timing.diagnostics if d.is_error]
    if not problems and not timing.untimed:
        return
    first = problems[0] if problems else None
    says = first.message if first is not None else f"{timing.untimed} steps cannot be timed"
    raise OlpError(
        error(
            "U030",
            f"a program that cannot be timed whole cannot be fitted: {says}",
            Span(first.line, first.column, first.end_column) if first is not None and first.line else None,
            file=timing.plan.path,
            source_line=first.source_line if first is not None else "",
            help="olp time says what is missing; --robot names the robot",
        )
    )
