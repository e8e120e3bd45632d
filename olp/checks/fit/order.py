"""The order of groups of lines that do not depend on each other, such as points where something is picked.

The time of a group depends on the one before it and the one after it. Both are measured in the program itself, in
orders that put each group after each other one. Up to `_ALL` groups every order is timed; up to `_EXACT` the best
one by the measured times is found exactly (Held and Karp, 1962); for more, single groups and whole stretches are
moved as long as that gains (Or, 1976; Croes, 1958). The answer is timed, and counts only where it is faster than
the written order.

Codes: U032 invalid groups, U033 groups that depend on each other.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise, permutations
from typing import TYPE_CHECKING

import numpy as np

from olp.checks.fit.choices import Choice, kept_lines, reread
from olp.core.diagnostic import OlpError, Span, error
from olp.languages.vendor import find_vendor
from olp.runtime.plan import StepKind

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from olp.ir.program import Program
    from olp.timing.result import Timing

Order = tuple[int, ...]
Groups = tuple[range, ...]

_ALL = 5  # 120 orders: as many timings as the search for edits takes
_EXACT = 12  # 12² · 2¹² steps: a second
_NUMBER = re.compile(r"\s*\d+:")
_SAME_S = 1e-9


def best_order(
    program: Program, base: Timing, run: Callable[[Program], Timing], groups: Groups, kept: frozenset[int]
) -> tuple[Program, Choice, dict[int, int]] | None:
    """The program with the groups in the fastest order, the edit, and the new line of each old one.

    None where no order is faster. Raises OlpError (U032, U033).
    """
    _check(program, groups, kept | kept_lines(program))
    search = OrderSearch(program, base, run, groups)
    best = search.solved()
    if search.total(best) >= base.total_s - _SAME_S:
        return None
    new = search.ordered(best)
    moved = frozenset(n for n, text in enumerate(new.source.lines, 1) if text != program.source.line(n))
    says = "order of the groups: " + " ".join(str(number + 1) for number in best)
    choice = Choice("order", groups[0].start, ("order", groups[0].start), says, 1.0, moved=moved)
    return new, choice, {old: now for now, old in search.old_lines(best).items()}


def _check(program: Program, groups: Groups, kept: frozenset[int]) -> None:
    """Raises OlpError (U032) for invalid groups."""

    def refuse(says: str, line: int, help: str) -> None:
        text = program.source.line(line)
        place = Span(line) if text else None
        raise OlpError(error("U032", says, place, file=program.path, source_line=text, help=help))

    if len(groups) < 2:
        refuse(
            "one group has one order", groups[0].start, "--order takes two groups or more: 10-14,15-19,20-24"
        )
    for one, other in pairwise(groups):
        if one.stop != other.start:
            refuse(
                "this group does not directly follow the one before it",
                other.start,
                "give groups in a row",
            )
    if groups[-1].stop - 1 > len(program.source.lines):
        refuse(
            f"the program has {len(program.source.lines)} lines",
            groups[-1].stop - 1,
            "give lines of the program",
        )
    for line in range(groups[0].start, groups[-1].stop):
        if line in kept:
            refuse("a line of the groups has to stay", line, "leave its group out")


class OrderSearch:
    """A program with its groups, and its times in the measured orders."""

    def __init__(
        self, program: Program, base: Timing, run: Callable[[Program], Timing], groups: Groups
    ) -> None:
        self.program, self.base, self.run, self.groups = program, base, run, groups
        self._known: dict[Order, Timing] = {tuple(range(len(groups))): base}

    def old_lines(self, order: Order) -> dict[int, int]:
        """The old number of each line of the groups, by its new one."""
        lines = [line for number in order for line in self.groups[number]]
        return dict(zip(range(self.groups[0].start, self.groups[-1].stop), lines, strict=True))

    def ordered(self, order: Order) -> Program:
        """The program with whole lines moved; line numbers that a controller writes before them stay in place."""
        source = self.program.source
        numbered = find_vendor(self.program.vendor).numbered_lines
        edits = {}
        for now, old in self.old_lines(order).items():
            text = source.line(old)
            if numbered and _NUMBER.match(text) and (mine := _NUMBER.match(source.line(now))):
                text = mine[0] + _NUMBER.sub("", text, count=1)
            edits[now] = (text,)
        return reread(self.program, source.edited(edits))

    def timed(self, order: Order) -> Timing:
        """Timing in this order. Raises OlpError (U033) where a line then does something else."""
        if order not in self._known:
            timing = self.run(self.ordered(order))
            line = self._differs(timing, order)
            if line:
                raise OlpError(
                    error(
                        "U033",
                        "the groups depend on each other: in another order this line does something else",
                        Span(line),
                        file=self.program.path,
                        source_line=self.program.source.line(line),
                        help="take what the groups share out of them, or leave the group out",
                    )
                )
            self._known[order] = timing
        return self._known[order]

    def total(self, order: Order) -> float:
        """Total [s]; inf where the order causes a new diagnostic, such as a path through a singularity."""
        timing = self.timed(order)
        told = {d.code for d in timing.diagnostics} - {d.code for d in self.base.diagnostics}
        return np.inf if told or timing.unseen > self.base.unseen else timing.total_s

    def _differs(self, timing: Timing, order: Order) -> int:
        """The first line whose steps request something else than in the written order; 0: none."""
        before, after = _asked(self.base, {}), _asked(timing, self.old_lines(order))
        for line in sorted(before.keys() | after.keys()):
            one, other = before.get(line), after.get(line)
            if one is None or other is None or one.shape != other.shape:
                return line
            if not np.allclose(one, other, rtol=0.0, atol=1e-9, equal_nan=True):
                return line
        return 0

    # --- search

    def solved(self) -> Order:
        count = len(self.groups)
        if count <= _ALL:
            return min(permutations(range(count)), key=self.total)
        way = self._measured()
        found = held_karp(way) if count <= _EXACT else improved(way)
        return min((found, tuple(range(count))), key=self.total)

    def _measured(self) -> NDArray[np.float64]:
        """Time [s] from each group to each next one (n + 1, n + 1); index n is the code before and after the groups."""
        count = len(self.groups)
        seconds = np.full((count + 1, count + 1), np.nan)
        for order in covering(count):
            timing = self.timed(order)
            firsts, rests = self._shares(timing, order)
            ends = (count, *order, count)
            outside = timing.total_s - sum(firsts.values()) - sum(rests.values())
            for one, other in pairwise(ends):
                # The way into a group is its first move's; what comes behind decides about the others.
                seconds[one, other] = rests.get(one, 0.0) + firsts.get(other, outside)
        return seconds

    def _shares(self, timing: Timing, order: Order) -> tuple[dict[int, float], dict[int, float]]:
        """Seconds of each group up to its first move, and of its rest, over all its runs."""
        plan, old = timing.plan, self.old_lines(order)
        firsts, rests = {}, {}
        lines = np.array([old.get(line, 0) for line in range(self.groups[-1].stop)])
        inside = (plan.source == 0) & (plan.line < len(lines))
        at = np.where(inside, lines[np.where(inside, plan.line, 0)], 0)
        for number, group in enumerate(self.groups):
            mine = np.isin(at, group)
            moving = np.flatnonzero(mine & (plan.kind == StepKind.MOVE))
            first = plan.line[moving[0]] if len(moving) else -1
            way = mine & (plan.line == first)
            firsts[number] = float(timing.duration_s[way].sum())
            rests[number] = float(timing.duration_s[mine & ~way].sum())
        return firsts, rests


def _asked(timing: Timing, old: dict[int, int]) -> dict[int, NDArray[np.float64]]:
    """Requests of the steps of each line: target, speed, acceleration, blend; independent of the steps before."""
    plan, moves = timing.plan, timing.plan.moves
    found: dict[int, list[NDArray[np.float64]]] = {}
    for step in np.flatnonzero(plan.source == 0).tolist():
        row = int(plan.row[step])
        if plan.kind[step] == StepKind.MOVE:
            target = int(moves.target[row])
            names = (
                "path",
                "travel",
                "fraction",
                "axis_speed",
                "turn",
                "rate",
                "acceleration",
                "deceleration",
            )
            numbers = [
                float(getattr(moves, name)[row]) for name in (*names, "blend_code", "blend", "duration")
            ]
            place = (plan.positions.position[target], plan.positions.quaternion[target])
            asked = np.concatenate((numbers, *place))
        else:
            asked = np.array([plan.durations[row]])
        line = int(plan.line[step])
        found.setdefault(old.get(line, line), []).append(asked)
    return {line: np.concatenate(rows) for line, rows in found.items()}


def covering(count: int) -> Iterator[Order]:
    """Orders in which each group comes after each other one, first, and last at least once."""
    missing = {(a, b) for a in range(count + 1) for b in range(count + 1) if a != b}
    while missing:
        order, here = [], count
        left = set(range(count))
        while left:
            wanted = sorted(left, key=lambda b: ((here, b) not in missing, b))
            here = wanted[0]
            order.append(here)
            left.discard(here)
        before = len(missing)
        missing -= set(pairwise((count, *order, count)))
        if len(missing) == before:  # what is missing cannot be begun: put it first
            one, other = min(missing)
            if one == count:
                order = [other, *(n for n in order if n != other)]
            elif other == count:
                order = [*(n for n in order if n != one), one]
            else:
                order = [one, other, *(n for n in order if n not in (one, other))]
            missing -= set(pairwise((count, *order, count)))
        yield tuple(order)


def held_karp(way: NDArray[np.float64]) -> Order:
    """The fastest order from outside through all groups and out again; `way` (n + 1, n + 1) [s]."""
    count = len(way) - 1
    best = {(1 << one, one): (float(way[count, one]), -1) for one in range(count)}
    for size in range(1, count):
        for (done, last), (seconds, _) in [one for one in best.items() if one[0][0].bit_count() == size]:
            for other in range(count):
                if not done >> other & 1:
                    key, total = (done | 1 << other, other), seconds + float(way[last, other])
                    if key not in best or total < best[key][0]:
                        best[key] = (total, last)
    done = (1 << count) - 1
    last = min(range(count), key=lambda one: best[done, one][0] + float(way[one, count]))
    order = []
    while last >= 0:
        order.append(last)
        done, last = done & ~(1 << last), best[done, last][1]
    return tuple(reversed(order))


def improved(way: NDArray[np.float64]) -> Order:
    """A good order of many groups: nearest first, then stretches moved and reversed as long as that gains."""
    count = len(way) - 1

    def seconds(order: Sequence[int]) -> float:
        return float(way[[count, *order], [*order, count]].sum())

    order: list[int] = []
    while len(order) < count:
        here = order[-1] if order else count
        order.append(min((n for n in range(count) if n not in order), key=lambda n: float(way[here, n])))
    best = min((order, list(range(count))), key=seconds)
    while True:
        found = min(_neighbours(best), key=seconds)
        if seconds(found) >= seconds(best) - _SAME_S:
            return tuple(best)
        best = found


def _neighbours(order: list[int]) -> Iterator[list[int]]:
    count = len(order)
    for start in range(count):
        for stop in range(start + 1, count + 1):
            if stop - start > 1:
                yield [*order[:start], *reversed(order[start:stop]), *order[stop:]]
            if stop - start <= 3:
                rest = order[:start] + order[stop:]
                yield from (
                    [*rest[:at], *order[start:stop], *rest[at:]] for at in range(len(rest) + 1) if at != start
                )
