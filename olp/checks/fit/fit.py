"""Brings a program down to a time with as few edits as possible.

Every choice is timed in the program itself, many at once where they are too far apart to affect each other. Their
gains are nearly additive, and an edit counts as one whatever its size: the fewest sufficient edits are then those
with the largest gains, which needs no solver (the tests compare with SciPy's `milp`). Corners shared by two edited
moves make the sum inexact: the answer is timed, and the difference is added to the requested gain; at the end every
edit has to be needed.

Codes: U030 a program that cannot be timed completely, U031 an invalid time.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from olp.checks.fit.choices import (
    Allowed,
    Applied,
    Choice,
    apply,
    called_programs,
    choices,
    seconds_of,
    source_of,
    top_speed,
)
from olp.checks.fit.order import best_order
from olp.core.diagnostic import Diagnostic, OlpError, Span, error
from olp.core.result_cache import TextCache, remembering
from olp.core.source import Source, drop, put, text
from olp.core.units import mm
from olp.ir.program import Program, SetOverride
from olp.languages.literals import speeds
from olp.reports.cell import links_of
from olp.runtime.folder import read_cached
from olp.runtime.plan import StepKind
from olp.timing.track import tool_position, tool_speed

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from olp.timing.result import Timing

Run = Callable[[Program], "Timing"]
Place = tuple[object, ...]
Steps = np.ndarray[tuple[int], np.dtype[np.intp]]

_LEAST_S = 1e-4  # [s] a choice that gains less is none
_APART = 4  # places that are timed at once: one in so many, so that no move has two edited neighbours
_ROUNDS = 12
_SAMPLES = 161  # of the way round a corner
_LESS = (0.0, 0.25, 0.5)  # of what a corner may be passed by, for the front
_SMALL = 10  # places up to which fewer edits are looked for one by one
_HELD = 1e-9  # [s]
_SPEEDS = 41  # instants of a move at which the tool's speed is measured
_SAME_SPEED = 1e-6  # of a speed, for the difference of two places


@dataclass(frozen=True, slots=True)
class FittedEdit:
    """`gained_s` [s] in the new program; `limit`: the limit that decides its time now.

    `deviation_mm`: distance of its corner from the point, or of a joint move from the straight line.
    """

    choice: Choice
    gained_s: float
    deviation_mm: float
    limit: str


class FrontPoint(NamedTuple):
    """Best total for this number of edits and this distance at corners."""

    edits: int
    within_mm: float
    total_s: float

    @property
    def worth(self) -> tuple[float, float, float]:
        """Sort key: smaller is better in each element."""
        return float(self.edits), self.within_mm, self.total_s


@dataclass(frozen=True, slots=True)
class Fit:
    """`program` is the edited one, `timing` its timing; `before_s` [s] the original total. `reached`: as fast as
    `to_s`.

    `others`: changed texts of called programs; `shared`: other callers of each of them. `needed_s` [s]: the total
    at which `to_s` holds in 95 % of cases; None where no interval is known.
    """

    program: Program
    timing: Timing
    before_s: float
    to_s: float
    reached: bool
    edits: tuple[FittedEdit, ...]
    front: tuple[FrontPoint, ...]
    limits: tuple[str, ...] = ()
    others: tuple[Source, ...] = ()
    shared: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def says(self) -> str:
        """Summary: "8 s: 3 edits"."""
        return f"{self.to_s:g} s: {len(self.edits)} edit{'s' * (len(self.edits) != 1)}"

    @property
    def needed_s(self) -> float | None:
        ends = self.timing.total_ends
        return None if ends is None or ends[1] <= 0.0 else self.to_s * self.timing.total_s / ends[1]


def offer(program: Program, to_s: float, run: Run) -> Fit | None:
    """Edits that bring a broken budget down and need no permission: no corner rounded, no speed above the program's
    highest.

    None if there are none.
    """
    try:
        found = fit(program, to_s, run, Allowed(), front=False)
    except OlpError:
        return None
    return found if found.reached and found.edits else None


def fit(program: Program, to_s: float, run: Run, allowed: Allowed, *, front: bool = True) -> Fit:
    """The fewest edits with which `program` takes at most `to_s` [s]; if that is impossible, the best that edits
    can do.

    `front`: also compute the totals for more and fewer edits. Raises OlpError (O001, U030, U031).
    """
    search = FitSearch(program, run, allowed)
    found = search.fit(to_s, front=front)
    if not allowed.order:
        return found
    known = best_order(program, search.base, run, allowed.order, allowed.kept)
    if known is None or (found.reached and len(found.edits) <= 1):
        return found
    ordered, order, line = known
    kept, free = (frozenset(line.get(n, n) for n in lines) for lines in (allowed.kept, allowed.free))
    other = _with_order(
        FitSearch(ordered, run, replace(allowed, kept=kept, free=free)), order, search, to_s, front
    )
    if found.reached and other.reached:
        return min(found, other, key=lambda one: len(one.edits))
    return (
        other
        if other.reached or (not found.reached and other.timing.total_s < found.timing.total_s)
        else found
    )


def _with_order(inner: FitSearch, order: Choice, outer: FitSearch, to_s: float, front: bool) -> Fit:
    """The answer for the program in another order, which counts as one more edit."""
    found = inner.fit(to_s, front=front)
    gained = outer.base.total_s - inner.base.total_s
    edits = (FittedEdit(order, gained, 0.0, ""), *found.edits)
    points = {one.edits: one for one in (outer.front if front else ())}
    for one in found.front:
        if one.edits + 1 not in points or one.total_s < points[one.edits + 1].total_s:
            points[one.edits + 1] = one._replace(edits=one.edits + 1)
    return replace(
        found,
        before_s=outer.base.total_s,
        edits=edits,
        front=tuple(points[count] for count in sorted(points)),
    )


class FitSearch:
    """A program with all its choices, and the gain of each alone [s]: for one or several target times."""

    def __init__(self, program: Program, run: Run, allowed: Allowed) -> None:
        """Find and time the choices. Raises OlpError (O001, U030)."""
        self.program, self.run, self.allowed = program, run, allowed
        self._memory = TextCache()
        with remembering(self._memory):
            self.base = run(program)
        _check(self.base)
        self._told = {(d.code, d.line) for d in self.base.diagnostics}
        self._known: dict[frozenset[Choice], tuple[float, float]] = {}
        self._passes: dict[Choice, float] = {}  # [m] of the choices with a zone, alone
        self.called = called_programs(program, self.base) if allowed.called else {}
        found = choices(program, self.base, allowed)
        self.steps = self._governed(found)
        self.gains = self._alone([one for one in found if len(self.steps[one.place])])
        self.choices = [one for one in found if self.gains.get(one, 0.0) > _LEAST_S]
        helps = {one.place for one in self.choices}
        idle = {one.place: one for one in self.gains if one.zone < 0 and one.place not in helps}
        # Each kind at once: a speed that gains nothing as long as the acceleration rules, and the other way round.
        self._idle = [
            [one for one in idle.values() if one.kind == kind]
            for kind in dict.fromkeys(one.kind for one in idle.values())
        ]

    def fit(self, to_s: float, *, front: bool = True) -> Fit:
        """The answer for `to_s` [s]. Raises OlpError (U031)."""
        if not to_s > 0.0:
            raise OlpError(error("U031", f"a time is above zero, not {to_s:g} s"))
        chosen: list[Choice] = []
        if self.base.total_s > to_s + _HELD:
            chosen = self.solved(self.base.total_s - to_s)
        return self.answer(chosen, to_s, self.front if front else ())

    # --- what a choice gains

    def _governed(self, found: Sequence[Choice]) -> dict[Place, Steps]:
        """The steps that the choices of each place affect; empty for a place that never runs."""
        plan = self.base.plan
        known: dict[Place, Steps] = {}
        for one in found:
            if not one.modal and one.place not in known:
                here = np.isin(plan.line, [one.line, *one.lines])
                known[one.place] = np.flatnonzero(here & (plan.source == source_of(self.base, one.path)))
        for kind in dict.fromkeys(one.kind for one in found if one.modal):
            known |= self._governed_by_settings([one for one in found if one.modal and one.kind == kind])
        return known

    def _governed_by_settings(self, found: Sequence[Choice]) -> dict[Place, Steps]:
        """The steps that each setting affects. Run number b changes the settings whose number has bit b.

        A step has its speed from one setting, so the runs that change the step give the bits of that setting's
        number.
        """
        most = {one.place: one for one in found}  # the last one of a place goes furthest
        number = np.zeros(len(self.base.plan), dtype=np.intp)
        for bit in range(len(most).bit_length()):
            some = [one for n, one in enumerate(most.values(), 1) if n >> bit & 1]
            timing = self._timed(some)
            if timing is not None:
                number[_asked_otherwise(self.base, timing)] |= 1 << bit
        return {place: np.flatnonzero(number == n) for n, place in enumerate(most, 1)}

    def _alone(self, found: Sequence[Choice]) -> dict[Choice, float]:
        """Gains of all choices, level by level, of every fourth place at once; of settings one by one."""
        places: dict[Place, list[Choice]] = {}
        for one in found:
            places.setdefault(one.place, []).append(one)
        gains: dict[Choice, float] = {}
        ended: set[Place] = set()  # corners that are passed too far already
        for level in range(max(map(len, places.values()), default=0)):
            for batch in self._batches(places):
                some = [places[p][level] for p in batch if len(places[p]) > level and p not in ended]
                alone = self._together(some)
                ended.update(one.place for one in some if one.zone >= 0 and one not in alone)
                gains |= alone
        return gains

    def _batches(self, places: dict[Place, list[Choice]]) -> Iterator[list[Place]]:
        """Places of a kind that are far from each other."""
        order = sorted(places, key=lambda place: int(self.steps[place][0]))
        for kind in dict.fromkeys((of[0].kind, of[0].modal) for of in places.values()):
            mine = [place for place in order if (places[place][0].kind, places[place][0].modal) == kind]
            # What a setting holds for may stand anywhere between what others hold for.
            apart = len(mine) if kind[1] else _APART
            yield from (mine[start::apart] for start in range(apart))

    def _together(self, some: Sequence[Choice]) -> dict[Choice, float]:
        """Gain of each of `some`, which are far from each other; choices that pass a corner too far gain nothing."""
        if not some:
            return {}
        timing = self._timed(some)
        if timing is None:
            # One of them cannot be: it is in one of the halves.
            half = len(some) // 2
            return self._together(some[:half]) | self._together(some[half:]) if half else {}
        gained = seconds_of(self.base, timing, [self.steps[one.place] for one in some])
        far, fast = passed(timing, some), self._too_fast(timing, some)
        self._passes |= far
        return {
            one: seconds
            for one, seconds in zip(some, gained.tolist(), strict=True)
            if far.get(one, 0.0) <= self.allowed.within and one not in fast
        }

    def _too_fast(self, timing: Timing, some: Sequence[Choice]) -> set[Choice]:
        """Choices that set the speed of axes and make the tool faster than allowed."""
        most = self.allowed.speed
        if most is None:
            return set()
        ends = np.concatenate(([0.0], timing.end_s))
        found = set()
        for one in some:
            steps = [step for step in self.steps[one.place] if timing.plan.kind[step] == StepKind.MOVE]
            if one.by_axes and steps:
                times = np.concatenate([np.linspace(ends[step], ends[step + 1], _SPEEDS) for step in steps])
                if tool_speed(timing, times).max() > most * (1.0 + _SAME_SPEED):
                    found.add(one)
        return found

    def timed(self, some: Sequence[Choice]) -> tuple[Applied, Timing]:
        """The program with `some`, called programs changed as well. Raises OlpError."""
        applied = apply(self.program, some, self.called)
        with _in_place(applied.others), remembering(self._memory):
            return applied, self.run(applied.program)

    def _timed(self, some: Sequence[Choice]) -> Timing | None:
        """Timing of the program with `some`; None if the program then does something else, or gets a new problem."""
        try:
            _, timing = self.timed(some)
        except OlpError:
            return None
        same = len(timing.plan) == len(self.base.plan) and np.array_equal(
            timing.plan.kind, self.base.plan.kind
        )
        new = {(d.code, d.line) for d in timing.diagnostics} - self._told
        seen = self.allowed.unseen or timing.unseen <= self.base.unseen
        return timing if same and seen and not new else None

    def total(self, chosen: Sequence[Choice]) -> tuple[float, float]:
        """Seconds of the program with these edits, and the largest distance from a corner [m]; inf if it cannot be
        timed.
        """
        key = frozenset(chosen)
        if key not in self._known:
            timing = self._timed(chosen)
            if timing is None or self._too_fast(timing, chosen):
                self._known[key] = (np.inf, np.inf)
            else:
                self._known[key] = (timing.total_s, max(passed(timing, chosen).values(), default=0.0))
        return self._known[key]

    def _holds(self, chosen: Sequence[Choice], to_s: float) -> bool:
        seconds, far = self.total(chosen)
        return seconds <= to_s + _HELD and far <= self.allowed.within

    # --- the fewest

    def solved(self, need: float) -> list[Choice]:
        """The fewest edits that gain `need` [s]; all that help if that is not enough."""
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
        """The best edit of each place, and edits that gain only together with others; without those that pass
        corners too far.
        """
        best: dict[Place, Choice] = {}
        for one in some:
            old = best.get(one.place)
            # What gains no more alone may do so where another edit lifts the limit that rules now.
            if old is None or self.gains[one] > self.gains[old] - (_LEAST_S if one.zone < 0 else 0.0):
                best[one.place] = one
        chosen = list(best.values())
        for rest in self._idle:
            more = [*chosen, *(one for one in rest if one.place not in best)]
            if len(more) > len(chosen) and self.total(more)[0] < self.total(chosen)[0] - _LEAST_S:
                chosen = more
        timing = self._timed(chosen)
        if timing is not None:
            far, fast = passed(timing, chosen), self._too_fast(timing, chosen)
            chosen = [one for one in chosen if far.get(one, 0.0) <= self.allowed.within and one not in fast]
        return chosen

    def _fewer(self, chosen: list[Choice], to_s: float) -> list[Choice]:
        """`chosen` without edits that are not needed; in small programs no smaller set of places suffices."""
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

    @cached_property
    def front(self) -> tuple[FrontPoint, ...]:
        """The best total for each number of edits, and for smaller distances at corners, without points that
        another one dominates.
        """
        found = set(self._front(self.allowed.within))
        best = (
            one
            for one in found
            if not any(other != one and all(map(float.__le__, other.worth, one.worth)) for other in found)
        )
        return tuple(sorted(best))

    def _front(self, within: float) -> Iterator[FrontPoint]:
        last = self.base.total_s
        yield FrontPoint(0, 0.0, last)
        best = sorted(self.most(self.choices), key=lambda c: -self.gains[c])
        for count in _counts(len(best)):
            seconds, far = self.total(best[:count])
            if seconds < last - _LEAST_S and far <= within:
                last = seconds
                yield FrontPoint(count, round(far / mm, 6), seconds)
        for share in _LESS if any(one.zone >= 0 for one in best) else ():
            chosen = self.most(
                [one for one in self.choices if one.zone < 0 or self._passes[one] <= share * within]
            )
            seconds, far = self.total(chosen)
            if np.isfinite(seconds):
                yield FrontPoint(len(chosen), round(far / mm, 6), seconds)

    def answer(self, chosen: Sequence[Choice], to_s: float, front: tuple[FrontPoint, ...]) -> Fit:
        # What a setting gains is what the moves gain that have no edit of their own.
        chosen = sorted(chosen, key=lambda one: (not one.modal, one.path, one.line, one.kind))
        applied, timing = self.timed(chosen)
        gained = self._shared_out(
            chosen, seconds_of(self.base, timing, [self.steps[one.place] for one in chosen])
        )
        far = passed(timing, chosen) | aside(timing, chosen)
        edits = tuple(
            FittedEdit(one, float(seconds), far.get(one, 0.0) / mm, self._limit(timing, one))
            for one, seconds in zip(chosen, gained.tolist(), strict=True)
        )
        edits = tuple(sorted(edits, key=lambda one: (one.choice.path, one.choice.line, one.choice.kind)))
        reached = timing.total_s <= to_s + _HELD
        limits = () if reached else (*self._limits(timing), *_overrides(self.program))
        shared = {
            one.path: callers(one.path, self.program) for one in applied.others if one.path in self.called
        }
        return Fit(
            applied.program,
            timing,
            self.base.total_s,
            to_s,
            reached,
            edits,
            front,
            limits,
            applied.others,
            shared,
        )

    def _limits(self, timing: Timing) -> Iterator[str]:
        """What keeps the program from being faster: the lines that take longest, and the main limit of each."""
        plan = timing.plan
        seconds: Counter[tuple[int, int]] = Counter()
        rules: dict[tuple[int, int], Counter[str]] = {}
        steps = zip(plan.source.tolist(), plan.line.tolist(), timing.duration_s.tolist(), strict=True)
        for (source, line, s), rule in zip(steps, timing.limited_by, strict=True):
            if s > 0.0:
                seconds[source, line] += s
                rules.setdefault((source, line), Counter())[rule or "a wait or a signal"] += s
        for (source, line), s in seconds.most_common(3):
            file = plan.sources[source]
            name = "" if source == 0 else f"{Path(file.path).name} "
            rule = rules[source, line].most_common(1)[0][0]
            told = f"{rule}{self._unedited(timing, source, line) if rule == 'speed' else ''}"
            yield f"{name}line {line}: {s:.3f} s, {told}: {file.line(line).strip()}"

    def _unedited(self, timing: Timing, source: int, line: int) -> str:
        """Note for a line whose speed no edit changes, with the reason; "" for others."""
        path = timing.plan.sources[source].path
        program = self.called.get(path) if source else self.program
        if program is None:
            return " in a called program"
        plan = timing.plan
        here = np.flatnonzero((plan.source == source) & (plan.line == line) & (plan.kind == StepKind.MOVE))
        slow = plan.moves.travel[plan.row[here]] < (1.0 - _SAME_SPEED) * top_speed(
            program, self.base, self.allowed
        )
        edited = [steps for place, steps in self.steps.items() if place[0] == "speed"]
        if not slow.any() or any(np.isin(here, steps).any() for steps in edited):
            return ""
        kept = line in {one.line for one in speeds(program)}  # it may be edited, and is not
        return "" if kept else " that is computed or an argument, which is not edited"

    def _shared_out(self, chosen: Sequence[Choice], gained: NDArray[np.float64]) -> NDArray[np.float64]:
        """Joint gain of the edits of one line, divided by the gain of each alone."""
        lines: dict[tuple[str, int], list[int]] = {}
        for at, one in enumerate(chosen):
            if not one.modal:
                lines.setdefault((one.path, one.line), []).append(at)
        found = gained.copy()
        for some in lines.values():
            alone = np.array([max(self.gains[chosen[at]], _HELD) for at in some])
            found[some] = gained[some].sum() * alone / alone.sum()
        return found

    def _limit(self, timing: Timing, one: Choice) -> str:
        """The limit of the longest step that the edit affects."""
        steps = self.steps[one.place]
        return timing.limited_by[int(steps[np.argmax(timing.duration_s[steps])])] if len(steps) else ""


@contextmanager
def _in_place(sources: Sequence[Source]) -> Generator[None]:
    """Use these texts in place of their files while the context lasts."""
    before = {one.path: text(one.path) for one in sources}
    for one in sources:
        put(one.path, one.raw)
    try:
        yield
    finally:
        for path, raw in before.items():
            if raw is None:
                drop(path)
            else:
                put(path, raw)


def _asked_otherwise(base: Timing, other: Timing) -> Steps:
    """Steps whose moves request another speed or acceleration."""
    rows = np.zeros(len(base.plan.moves), dtype=bool)
    for name in ("travel", "fraction", "axis_speed", "turn", "rate", "acceleration", "deceleration"):
        one, two = getattr(base.plan.moves, name), getattr(other.plan.moves, name)
        rows |= ~np.isclose(one, two, rtol=1e-12, atol=0.0, equal_nan=True)
    moving = np.flatnonzero(base.plan.kind == StepKind.MOVE)
    return np.asarray(moving[rows[base.plan.row[moving]]])


def callers(path: str, program: Program) -> tuple[str, ...]:
    """Files beside a called program that also call it."""
    own = links_of(read_cached(Path(path))).defines
    found = []
    for beside in sorted(Path(path).parent.iterdir()):
        if beside.suffix.lower() != Path(path).suffix.lower() or str(beside) in (path, program.path):
            continue
        try:
            links = links_of(read_cached(beside))
        except OlpError:
            continue
        if set(links.calls) & set(own):
            found.append(beside.name)
    return tuple(found)


def cover(some: Sequence[Choice], gains: Mapping[Choice, float], need: float) -> list[Choice] | None:
    """The fewest of `some`, at most one per place, that gain `need` [s] together; None if all are not enough.

    No set of as many places gains more than those with the largest gains. Each of these is then reduced as far as
    possible.
    """
    levels: dict[Place, list[Choice]] = {}
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


def passed(timing: Timing, some: Sequence[Choice]) -> dict[Choice, float]:
    """Distance [m] of the tool from the point of each choice with a zone, first and last execution.

    inf if unknown.
    """
    plan = timing.plan
    zones = [one for one in some if one.zone >= 0]
    if np.isnan(timing.duration_s).any():
        return dict.fromkeys(zones, float("inf"))
    ends = np.concatenate(([0.0], timing.end_s))
    corners: list[tuple[Choice, int]] = []
    for one in zones:
        steps = _moves_of(timing, one).tolist()
        corners += [(one, step) for step in dict.fromkeys(steps[:1] + steps[-1:])]
    # Dense where one move ends and the next begins.
    place = np.linspace(-1.0, 1.0, _SAMPLES)
    times = []
    for _, step in corners:
        before, here, after = ends[step], ends[step + 1], ends[min(step + 2, len(ends) - 1)]
        times.append(here + place * abs(place) * np.where(place < 0.0, here - before, after - here))
    found = dict.fromkeys(zones, 0.0)
    if not corners:
        return found
    position = tool_position(timing, np.concatenate(times))
    for number, (one, step) in enumerate(corners):
        way = position[number * _SAMPLES : (number + 1) * _SAMPLES]
        target = plan.positions.position[int(plan.moves.target[int(plan.row[step])])]
        known = not (np.isnan(target).any() or np.isnan(way).any())
        found[one] = max(found[one], _distance(target, way) if known else float("inf"))
    return found


def aside(timing: Timing, some: Sequence[Choice]) -> dict[Choice, float]:
    """Distance [m] of the tool from the straight line, for each choice that is a joint move now, every execution."""
    plan, ends = timing.plan, np.concatenate(([0.0], timing.end_s))
    found = {}
    for one in some:
        if one.joint <= 0.0:
            continue
        far = 0.0
        for step in _moves_of(timing, one).tolist():
            row = int(plan.row[step])
            start, stop = (
                plan.positions.position[int(of[row])] for of in (plan.moves.start, plan.moves.target)
            )
            way = tool_position(timing, np.linspace(ends[step], ends[step + 1], _SAMPLES))
            far = max(far, *(_distance(point, np.stack((start, stop))) for point in way))
        found[one] = far
    return found


def _moves_of(timing: Timing, one: Choice) -> Steps:
    plan = timing.plan
    mine = (
        (plan.kind == StepKind.MOVE) & (plan.source == source_of(timing, one.path)) & (plan.line == one.line)
    )
    return np.flatnonzero(mine)


def _distance(point: NDArray[np.float64], way: NDArray[np.float64]) -> float:
    """Distance [m] from a point to a polyline."""
    start, along = way[:-1], np.diff(way, axis=0)
    square = (along**2).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.clip(np.nan_to_num(((point - start) * along).sum(axis=1) / square), 0.0, 1.0)
    return float(np.linalg.norm(start + share[:, None] * along - point, axis=1).min())


def _counts(most: int) -> list[int]:
    """Up to a dozen numbers of edits, dense at the start."""
    return (
        sorted(
            {*range(1, min(most, 6) + 1), *np.unique(np.geomspace(1, max(most, 1), 7).astype(int)).tolist()}
            - {0}
        )
        if most
        else []
    )


def _overrides(program: Program) -> Iterator[str]:
    """Lines that slow all following moves and that no edit changes, since an override is set for other reasons."""
    for one in program.statements():
        share = one.share.literal if isinstance(one, SetOverride) else None
        if share is not None and share < 1.0:
            said = program.source.line(one.line).strip()
            yield f"line {one.line}: an override of {share:.0%}, which is not edited: {said}"


def _check(timing: Timing) -> None:
    """Raises OlpError (U030) for a timing with unknown durations."""
    problems: list[Diagnostic] = [d for d in timing.diagnostics if d.is_error]
    if not problems and not timing.untimed:
        return
    first = problems[0] if problems else None
    says = first.message if first is not None else f"{timing.untimed} steps cannot be timed"
    raise OlpError(
        error(
            "U030",
            f"a program that cannot be timed completely cannot be fitted: {says}",
            Span(first.line, first.column, first.end_column) if first is not None and first.line else None,
            file=timing.plan.path,
            source_line=first.source_line if first is not None else "",
            help="olp time says what is missing; --robot names the robot",
        )
    )
