"""Do two plans do the same? Their steps are paired by the statements that make them, and each pair is compared.

A move to where the arm stands is left out where the other program has none, and an arc may be one step or several.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import islice, zip_longest
from pathlib import PurePath
from typing import NamedTuple

import numpy as np

from olp.core.units import deg, mm
from olp.ir.program import Path
from olp.robots.geometry import quaternion_from_rotation
from olp.runtime.paths import circle, point_on_arc
from olp.runtime.plan import CUT_SHORT, PATHS, BlendCode, Event, Plan, StepKind
from olp.runtime.state import VALUE_IS_UNKNOWN
from olp.timing.blending.law import load_law

Place = tuple[str, int]  # the name of a file of the translation and a line there
_STILL = 0.002 * mm  # [m] a shorter move goes nowhere
_TURN = 0.0002 * deg  # [rad]
_INSTANT = 1e-6  # [s] by which points that are rounded change a move
_SAME_AXIS = 0.01  # [mm or deg] of an external axis: what three decimals leave open, and some
_SAME_VALUE = 1e-5  # of a signal's value, as a share and as a number
_AHEAD = 64  # steps that are looked at for the next pair
_MUCH_LONGER = 8  # times the steps of the other: not for the same statements, where both were stopped
_KINDS = tuple(StepKind)  # by their number
_ARC = 8  # steps of one program that may be one arc in the other


@dataclass(frozen=True, slots=True)
class Tolerances:
    """By how much two plans may differ and still be the same: [m], [rad], share of the speed [1], [m], [s]."""

    position: float = 0.001 * mm
    angle: float = 0.0001 * deg
    speed: float = 1e-4
    blend: float = 1e-6
    wait: float = 1e-6


# What the numbers that controllers write, three decimals of mm and degrees and two of seconds, leave open.
WRITTEN = Tolerances(0.01 * mm, 0.01 * deg, 0.001, 0.1 * mm, 0.005)


class ComparedStep(NamedTuple):
    """One thing that happens: a move, a wait or a signal, in SI. nan where the plan does not know."""

    kind: StepKind
    line: int
    path: Path | None = None
    position: tuple[float, ...] = ()
    rotation: tuple[float, ...] = ()  # quaternion
    axes: tuple[float, ...] = ()
    travel: float = math.nan
    turn: float = math.nan
    time: float = math.nan  # of a joint move: what its programmed speed asks for
    blend: float = math.nan
    exact: bool = False  # the arm stops at the end
    duration: float = math.nan
    seconds: float = 0.0  # what the step takes as timed, with those that were put together with it
    length: float = math.nan  # of the tool's path
    middle: tuple[float, ...] = ()  # a point half on the way of an arc
    circle: tuple[tuple[float, ...], ...] = ()  # three points of an arc's circle
    passed: tuple[tuple[float, ...], ...] = ()  # where the steps that were put together as one arc meet
    still: bool = False  # goes nowhere
    event: Event | None = None
    file: str = ""  # its name: a translation is read again in another folder for each run
    fraction: float = math.nan  # of a joint move: the share of full speed that is programmed
    tool: tuple[float, ...] = ()  # centre point on the flange, quaternion
    beside: tuple[float, ...] = ()  # [mm or deg] where external axes stand
    shifts: bool = False  # one of them stood elsewhere before


class PlanDifference(NamedTuple):
    """What differs: in the step of `line` of the first program and `other` of the second, 0 where it has none.

    `part`: path, position, orientation, speed, blend, wait, signal, or order for a step that the other has not.
    `step`: of the comparison, from 1; a statement in a loop has several. `text`: what both have.
    """

    line: int
    other: int
    part: str
    step: int
    text: str

    @property
    def says(self) -> str:
        return f"step {self.step} (line {self._lines(', ')}): {self.text}"

    @property
    def where(self) -> str:
        """The line in both programs."""
        return f"lines {self._lines(' and ')}"

    def _lines(self, between: str) -> str:
        return between.join(str(line) if line else "none" for line in (self.line, self.other))


@dataclass(slots=True)
class Comparison:
    """What differs. The worst of matching steps: position and blend [m], angle [rad], speed [1], wait [s].

    `unknown`: lines of the first program that its run left out, for it does not know their values. `until`: the first
    of them where the two go different ways from there on, which is not compared; 0: all was. `steps`: pairs. `times`:
    of each pair the line and the seconds in both programs, as they were timed.
    """

    steps: int = 0
    found: list[PlanDifference] = field(default_factory=list)
    worst_position: float = 0.0
    worst_angle: float = 0.0
    worst_speed: float = 0.0
    worst_blend: float = 0.0
    worst_wait: float = 0.0
    unknown: tuple[int, ...] = ()
    until: int = 0
    tolerances: Tolerances = Tolerances()
    times: list[tuple[int, float, int, float]] = field(default_factory=list)

    @property
    def is_equal(self) -> bool:
        """Whether nothing differs but, within the tolerances, numbers."""
        return not self.found

    @property
    def differences(self) -> list[str]:
        return [one.says for one in self.found]

    def differ(self, a: ComparedStep | None, b: ComparedStep | None, part: str, says: str) -> None:
        lines = (0 if a is None else a.line), (0 if b is None else b.line)
        self.found.append(PlanDifference(*lines, part, self.steps, says))


def compare_plans(
    one: Plan,
    other: Plan,
    *,
    speeds: bool = True,
    blends: bool = True,
    tolerances: Tolerances | None = None,
    without: Set[int] = frozenset(),
    comments: Set[int] = frozenset(),
    loose: Mapping[str, Set[int]] | None = None,
    origins: Mapping[Place, int] | None = None,
    renamed: Callable[[Event], Event] | None = None,
    states: Set[str] = frozenset(),
    seconds: tuple[Sequence[float], Sequence[float]] = ((), ()),
    other_lengths: bool = False,
) -> Comparison:
    """The differences of two plans.

    `without`: lines of `one` that are known to have no counterpart. `comments`: those where a statement that does
    nothing became a comment; anything else of them has its counterpart. `loose`: "speed", "blend", "order" and
    "wait", the lines of `one` where they are known to differ; "beside", those whose external axes are left out, as
    positions of `other` have none; "loop", where loops begin, which may pause in `other`. `origins`: the line of
    `one` that each line of `other` was made from; without it steps are paired in their order. `renamed`: an event
    of `one` with the signals of `other`. `states`: the signals by which the controller of `other` tells what `one`
    asks it without a signal. `seconds`: of the steps of both plans, as they were timed. `other_lengths`: moves are
    not as long as they were when speeds of joint moves and sizes of blends were converted, which are then not
    compared. Of two runs that were stopped, the last move is not compared, as what follows it is not known, nor
    what one of them comes to.
    """
    cut_short = all(any(d.code in CUT_SHORT for d in p.diagnostics) for p in (one, other))
    rules = _Rules(
        tolerances or Tolerances(),
        speeds,
        blends,
        loose or {},
        origins,
        renamed,
        states,
        other_lengths,
        cut_short,
    )
    first = steps_of(one, without, seconds[0], comments=comments)
    second = rules.joined(steps_of(other, seconds=seconds[1]))
    first, second = _carried(_without_standing(first)), _carried(_without_standing(second))
    if cut_short:
        first, second = _before_the_last_move(first), _before_the_last_move(second)
    result = _compared(first, second, rules)
    result.unknown = tuple(dict.fromkeys(d.line for d in one.diagnostics if d.code in VALUE_IS_UNKNOWN))
    if one.unknown < 0 or result.is_equal:
        return result
    known = _carried(_without_standing(steps_of(one, without, seconds[0], one.unknown, comments)))
    until = _compared(known, second, rules, cut=True)
    until.unknown, until.until = result.unknown, result.unknown[0]
    return until


def _without_standing(steps: list[ComparedStep]) -> list[ComparedStep]:
    """Steps without the external axes that no move of the run takes anywhere: they may be left out."""
    rows = [s.beside for s in steps if s.beside]
    values = [{v for v in column if v == v} for column in zip_longest(*rows, fillvalue=math.nan)]
    moving = [
        at for at, column in enumerate(values) if max(column, default=0) - min(column, default=0) > _SAME_AXIS
    ]
    return [
        s._replace(beside=tuple(s.beside[at] if at < len(s.beside) else math.nan for at in moving))
        if s.beside
        else s
        for s in steps
    ]


def _carried(steps: list[ComparedStep]) -> list[ComparedStep]:
    """Steps whose moves say where external axes stand although they say nothing of them: where they stood before."""
    found: list[ComparedStep] = []
    last: tuple[float, ...] = ()
    for s in steps:
        if s.kind is StepKind.MOVE:
            beside = s.beside or last
            shifts = any(abs(x - y) > _SAME_AXIS for x, y in zip(last, beside, strict=False))
            if shifts or beside is not s.beside:
                s = s._replace(beside=beside, shifts=shifts)
            last = beside
        found.append(s)
    return found


def _before_the_last_move(steps: list[ComparedStep]) -> list[ComparedStep]:
    last = next((at for at in range(len(steps) - 1, -1, -1) if steps[at].kind is StepKind.MOVE), len(steps))
    return steps[:last]


class _Rules(NamedTuple):
    tolerances: Tolerances
    speeds: bool
    blends: bool
    loose: Mapping[str, Set[int]]
    origins: Mapping[Place, int] | None
    renamed: Callable[[Event], Event] | None
    states: Set[str] = frozenset()
    other_lengths: bool = False
    cut_short: bool = False

    def belong(self, a: ComparedStep, b: ComparedStep) -> bool:
        """Whether two steps may come from one statement."""
        if a.kind is not b.kind or _is_message(a) is not _is_message(b):
            return False
        origin = None if self.origins is None else self.origins.get((b.file, b.line))
        return origin is None or origin == a.line

    def joined(self, steps: list[ComparedStep]) -> list[ComparedStep]:
        """Steps without what several instructions do that one of the source became, and that switches nothing.

        So does the pause of a loop that asks: it stands once, however often the loop comes round.
        """
        if self.origins is None:
            return steps
        found: list[ComparedStep] = []
        pauses: set[Place] = set()
        for step in steps:
            if not _is_message(step):
                pauses.clear()
            elif self.is_added(step):
                if (step.file, step.line) in pauses:
                    continue
                pauses.add((step.file, step.line))
            last = found[-1] if found else None
            if last is not None and _is_message(last) and _is_message(step) and last.line != step.line:
                origin = self.origins.get((step.file, step.line))
                if origin is not None and origin == self.origins.get((last.file, last.line)):
                    continue
            found.append(step)
        return found

    def asks(self, a: ComparedStep) -> bool:
        """Whether a wait is a loop in the other program, which finds at once what it asks for."""
        loop = a.line in self.loose.get("wait", frozenset())
        return loop and a.kind is StepKind.WAIT and a.duration <= self.tolerances.wait

    def is_asked(self, b: ComparedStep) -> bool:
        """Whether a wait may be the pause of a loop that asks, which is no wait in the first program."""
        loops = self.loose.get("loop", frozenset())
        origin = None if self.origins is None else self.origins.get((b.file, b.line))
        pauses = _is_message(b) or (b.kind is StepKind.WAIT and not b.duration)
        return pauses and (origin in loops or (bool(loops) and self.is_added(b)))

    def is_added(self, b: ComparedStep) -> bool:
        """Whether the step's statement is known to be added by the translation."""
        return self.origins is not None and (b.file, b.line) not in self.origins

    def made(self, some: Sequence[ComparedStep], b: ComparedStep) -> bool:
        """Whether it is known that one of these steps of the first program is what the other one's was made from."""
        origin = None if self.origins is None else self.origins.get((b.file, b.line))
        return origin is not None and any(s.line == origin and s.kind is b.kind for s in some)


# --- pairs ----------------------------------------------------------------------------------------------


def paired(
    first: Sequence[ComparedStep], second: Sequence[ComparedStep], rules: _Rules, cut: bool = False
) -> Iterator[tuple[ComparedStep | None, ComparedStep | None]]:
    """Steps of both programs that belong together; None where the other has none. `cut`: the first one ends early."""
    i, j = 0, 0
    while i < len(first) and j < len(second):
        a, b = first[i], second[j]
        more, others = _arc_steps(first, second, i, j, rules)
        if not (more or others) and not rules.belong(a, b):
            skip = _next_pair(first, second, i, j, rules)
            if skip is None:
                if not rules.cut_short or min(len(first) - i, len(second) - j) > _AHEAD:
                    yield a, b
                return
            yield from ((s, None) for s in first[i : i + skip[0]] if not s.still)
            yield from ((None, s) for s in second[j : j + skip[1]] if not s.still)
            i, j = i + skip[0], j + skip[1]
            continue
        i, j = i + more, j + others
        a, b = _joined(first[i - more : i + 1]), _joined(second[j - others : j + 1])
        i, j = i + 1, j + 1
        if _is_message(a) and _is_message(b):
            # A text may be longer than a line of the other controller.
            more_follow = i < len(first) and _is_message(first[i])
            while j < len(second) and _is_message(second[j]):
                if more_follow and not (rules.is_added(second[j]) or rules.made([a], second[j])):
                    break
                j += 1
        if a.kind is b.kind is StepKind.WAIT:
            a, i = _waited(a, first, i, b.duration)
            b, j = _waited(b, second, j, a.duration)
        if a.kind is StepKind.MOVE:
            # A move to where the arm stands that only one of the programs has: how it ends is how the one before does.
            while j < len(second) and second[j].still and not rules.made(first[i : i + 1], second[j]):
                b, j = _ending(b, second[j]), j + 1
            while (
                i < len(first)
                and first[i].still
                and not any(rules.made([first[i]], s) for s in second[j : j + 1])
            ):
                a, i = _ending(a, first[i]), i + 1
        yield a, b
    if (
        rules.cut_short
        and max(len(first), len(second)) < _MUCH_LONGER * min(len(first), len(second)) + _AHEAD
    ):
        return
    yield from ((s, None) for s in first[i:] if not s.still)
    if not cut:
        yield from ((None, s) for s in second[j:] if not s.still)


def _next_pair(
    first: Sequence[ComparedStep], second: Sequence[ComparedStep], i: int, j: int, rules: _Rules
) -> tuple[int, int] | None:
    """How many steps of both come before the next ones that belong together, as few as can be."""
    for total in range(1, _AHEAD):
        for more in range(total + 1):
            x, y = i + more, j + total - more
            if x < len(first) and y < len(second) and rules.belong(first[x], second[y]):
                return more, total - more
    return None


def _arc_steps(
    first: Sequence[ComparedStep], second: Sequence[ComparedStep], i: int, j: int, rules: _Rules
) -> tuple[int, int]:
    """How many further steps of each program lead on along one arc, until both are at the same point."""
    a, b = first[i], second[j]
    tolerance = rules.tolerances.position
    if a.path is not Path.CIRCULAR or b.path is not Path.CIRCULAR:
        return 0, 0
    if rules.belong(a, b) and _distance(a.position, b.position) <= tolerance:
        return 0, 0
    for total in range(1, _ARC):
        for more in range(total + 1):
            run, other = first[i : i + more + 1], second[j : j + total - more + 1]
            if len(run) <= more or len(other) <= total - more or not rules.belong(run[-1], other[-1]):
                continue
            if not all(s.path is Path.CIRCULAR for s in (*run, *other)):
                continue
            if all(s.still for s in run) != all(s.still for s in other):
                continue  # a whole circle ends where it begins
            if _distance(run[-1].position, other[-1].position) <= tolerance:
                return more, total - more
    return 0, 0


def _joined(run: Sequence[ComparedStep]) -> ComparedStep:
    """Steps along one arc as one; its middle is not known where they are several."""
    if len(run) == 1:
        return run[0]
    return run[-1]._replace(
        length=sum(s.length for s in run),
        seconds=sum(s.seconds for s in run),
        middle=(),
        passed=tuple(s.position for s in run[:-1]),
        path=Path.CIRCULAR,
        still=False,
    )


_ROUNDED = 1e-6  # [s]


def _waited(
    step: ComparedStep, steps: Sequence[ComparedStep], at: int, until: float
) -> tuple[ComparedStep, int]:
    """A wait with those that follow at once, as long as the other lasts: a loop repeats it, or one wait is several."""
    while at < len(steps) and step.duration < until and steps[at].event is None:
        last = steps[at]
        same = (last.file, last.line) == (step.file, step.line)
        if last.kind is not StepKind.WAIT or not (same or step.duration + last.duration <= until + _ROUNDED):
            break
        lasts, seconds = step.duration + last.duration, step.seconds + last.seconds
        step, at = step._replace(duration=lasts, seconds=seconds), at + 1
    return step, at


def _ending(step: ComparedStep, last: ComparedStep) -> ComparedStep:
    return step._replace(exact=last.exact, blend=last.blend, seconds=step.seconds + last.seconds)


# --- comparing pairs ------------------------------------------------------------------------------------


def _compared(
    first: Sequence[ComparedStep], second: Sequence[ComparedStep], rules: _Rules, cut: bool = False
) -> Comparison:
    result = Comparison(tolerances=rules.tolerances)
    for a, b in paired(first, second, rules, cut):
        result.steps += 1
        result.times.append(
            (
                0 if a is None else a.line,
                0.0 if a is None else a.seconds,
                0 if b is None else b.line,
                0.0 if b is None else b.seconds,
            )
        )
        if b is None and a is not None and rules.asks(a):
            continue
        if a is None and b is not None and rules.is_asked(b):
            continue
        if a is None or b is None:
            which, step = ("the source", a) if b is None else ("the translation", b)
            assert step is not None
            result.differ(a, b, "order", f"only {which} has this {step.kind.name.lower()}")
        elif a.kind is not b.kind:
            result.differ(a, b, "order", f"{a.kind.name.lower()} and {b.kind.name.lower()}")
        elif a.kind is StepKind.MOVE:
            _compare_moves(a, b, result, rules)
        else:
            _compare_events(a, b, result, rules)
    return result


def _compare_events(a: ComparedStep, b: ComparedStep, result: Comparison, rules: _Rules) -> None:
    if a.kind is StepKind.WAIT:
        off = abs(a.duration - b.duration)
        result.worst_wait = max(result.worst_wait, off)
        if off > rules.tolerances.wait:
            result.differ(a, b, "wait", f"waits of {a.duration:g} s and {b.duration:g} s")
    if a.event is None or b.event is None:
        return
    one = a.event if rules.renamed is None else rules.renamed(a.event)
    if a.kind is StepKind.WAIT and not b.event.signals:
        return  # of a variable, which a signal without a number may be there
    told = rules.states - set(one.signals) if a.kind is StepKind.WAIT else ()
    there = tuple(name for name in b.event.signals if name not in told)
    if rules.renamed is not None and one.signals != there:
        says = f"{_named(a.event)}, which is {_named(one)} there, and {_named(b.event)}"
        result.differ(a, b, "signal", f"signals {says}")
    elif not _same_value(one.value, b.event.value):
        result.differ(a, b, "signal", f"{_named(a.event)} to {one.value:g} and to {b.event.value:g}")
    elif a.line not in rules.loose.get("order", frozenset()):
        _compare_shifts(a, b, (one, b.event), result, rules)


def _same_value(one: float, other: float) -> bool:
    """Whether a signal is set to the same: numbers that are computed from rounded positions are nearly so."""
    if math.isnan(one) or math.isnan(other):
        return True
    if float(one).is_integer() and float(other).is_integer():
        return one == other
    return math.isclose(one, other, rel_tol=_SAME_VALUE, abs_tol=_SAME_VALUE)


def _compare_shifts(
    a: ComparedStep, b: ComparedStep, events: tuple[Event, Event], result: Comparison, rules: _Rules
) -> None:
    """How far from its place each output switches, where triggers of moves switch them."""
    one, other = events
    limits = (("mm", mm, rules.tolerances.position), ("s", 1.0, rules.tolerances.wait))
    for (unit, scale, limit), x, y in zip(limits, one[3:], other[3:], strict=True):
        if abs(x - y) > limit:
            says = f"{_named(one)} switches {x / scale:g} {unit} and {y / scale:g} {unit} behind that end of the move"
            result.differ(a, b, "order", says)


def _named(event: Event) -> str:
    return " and ".join(event.signals) or "no signal"


def _compare_moves(a: ComparedStep, b: ComparedStep, result: Comparison, rules: _Rules) -> None:
    tolerances = rules.tolerances
    shapes = _shape(a), _shape(b)
    if shapes[0] is not shapes[1] and not (a.still and b.still):
        result.differ(a, b, "path", f"{shapes[0]} and {shapes[1]}")
    off = _distance(a.position, b.position)
    result.worst_position = max(result.worst_position, off)
    if off > tolerances.position:
        result.differ(a, b, "position", f"{off / mm:.6f} mm apart")
    turned = _between(a.rotation, b.rotation)
    result.worst_angle = max(result.worst_angle, turned)
    if turned > tolerances.angle:
        result.differ(a, b, "orientation", f"turned by {turned / deg:.6f} deg")
    _compare_tools(a, b, result, rules)
    alone = not a.beside or a.line in rules.loose.get("beside", frozenset())
    for number, (x, y) in enumerate(zip_longest(a.beside, b.beside, fillvalue=math.nan), 1):
        if not alone and (abs(x - y) > _SAME_AXIS or (y != y and x == x)):
            there = "nowhere" if y != y else f"{y:.6g}"
            result.differ(a, b, "external", f"external axis {number} at {x:.6g} and {there}")
    if b.shifts and not a.beside:
        result.differ(a, b, "external", "only the translation moves external axes here")
    if a.path is Path.JOINT and any(map(math.isnan, (*a.position, *b.position))):
        apart = _distance(a.axes, b.axes)
        result.worst_angle = max(result.worst_angle, apart)
        if apart > tolerances.angle * 3:
            result.differ(a, b, "orientation", f"axes turned by {apart / deg:.6f} deg")
    if shapes == (Path.CIRCULAR, Path.CIRCULAR):
        _compare_arcs(a, b, result, rules)
    if rules.speeds and a.line not in rules.loose.get("speed", frozenset()):
        _compare_speeds(a, b, result, rules)
    if rules.blends and a.line not in rules.loose.get("blend", frozenset()):
        _compare_blends(a, b, result, rules)


def _compare_tools(a: ComparedStep, b: ComparedStep, result: Comparison, rules: _Rules) -> None:
    """The same point may be reached with another tool: the flange is elsewhere then."""
    if a.tool == b.tool or not a.tool or not b.tool:
        return
    off, turned = _distance(a.tool[:3], b.tool[:3]), _between(a.tool[3:], b.tool[3:])
    if off > rules.tolerances.position or turned > rules.tolerances.angle:
        says = f"tools {off / mm:.6f} mm and {turned / deg:.6f} deg apart"
        result.differ(a, b, "tool", says)


def _shape(step: ComparedStep) -> Path | None:
    """An arc through points of one line is straight, and so is the way to the first point of a chain."""
    straight = step.path is Path.CIRCULAR and not step.circle
    return Path.LINEAR if straight else step.path


def _compare_arcs(a: ComparedStep, b: ComparedStep, result: Comparison, rules: _Rules) -> None:
    """The middle of the arc; of one that is several steps its length, and the points where these meet."""
    limit = rules.tolerances.position
    if a.middle and b.middle:
        off = _distance(a.middle, b.middle)
    else:
        off = 0.0 if math.isnan(a.length) or math.isnan(b.length) else abs(a.length - b.length)
        off = max([off, *_off_circle(a.passed, b.circle), *_off_circle(b.passed, a.circle)])
    # The middle of a flat arc moves further than the points that it is made from.
    if off > 10.0 * limit:
        result.differ(a, b, "path", f"arcs that are {off / mm:.6f} mm apart along the path")


def _off_circle(points: tuple[tuple[float, ...], ...], on: tuple[tuple[float, ...], ...]) -> Iterator[float]:
    """[m] from each point to the circle through three others."""
    if not points or not on:
        return
    centre, radius, axis = (part[0] for part in circle(*(np.array([p]) for p in on)))
    for point in points:
        spoke = np.array(point) - centre
        height = float(spoke @ axis)
        if math.isfinite(float(radius)):
            yield math.hypot(float(np.linalg.norm(spoke - height * axis)) - float(radius), height)


def _compare_speeds(a: ComparedStep, b: ComparedStep, result: Comparison, rules: _Rules) -> None:
    time = ("time at speed", a.time, b.time)
    if rules.other_lengths and a.path is Path.JOINT:
        time = ("share of full speed", a.fraction, b.fraction)
    for name, x, y in (("speed", a.travel, b.travel), time):
        if math.isnan(x) or math.isnan(y) or min(x, y) <= 0.0:  # 0: from a place that is not known
            continue
        off = abs(x - y) / max(x, y)
        if off > rules.tolerances.speed and name != "speed" and abs(x - y) <= _INSTANT:
            continue
        result.worst_speed = max(result.worst_speed, off)
        if off > rules.tolerances.speed:
            result.differ(a, b, "speed", f"{name} {x:g} and {y:g}")


def _compare_blends(a: ComparedStep, b: ComparedStep, result: Comparison, rules: _Rules) -> None:
    x, y = (0.0 if s.exact else s.blend for s in (a, b))
    if a.exact is b.exact and (math.isnan(x) or math.isnan(y)):
        return
    if a.exact is b.exact and rules.other_lengths:
        return
    off = abs((0.0 if math.isnan(x) else x) - (0.0 if math.isnan(y) else y))
    result.worst_blend = max(result.worst_blend, off)
    if off > rules.tolerances.blend or a.exact is not b.exact:
        one, other = ("unknown size" if math.isnan(size) else f"{size / mm:g} mm" for size in (x, y))
        result.differ(a, b, "blend", f"blends of {one} and {other}")


def _distance(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    pairs = [(x, y) for x, y in zip(a, b, strict=False) if not math.isnan(x) and not math.isnan(y)]
    if a and b and any(math.isnan(v) for v in (*a, *b)) and not pairs:
        return 0.0
    return math.sqrt(sum((x - y) ** 2 for x, y in pairs))


def _between(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    if a == b or any(map(math.isnan, (*a, *b))) or not a or not b:
        return 0.0
    x, y = np.array(a), np.array(b)
    less, more = x - y, x + y
    chord = math.sqrt(min(less @ less, more @ more))
    return 4.0 * math.asin(min(chord / 2.0, 1.0))


# --- steps ----------------------------------------------------------------------------------------------


def steps_of(
    plan: Plan,
    without: Set[int] = frozenset(),
    seconds: Sequence[float] = (),
    stop: int | None = None,
    comments: Set[int] = frozenset(),
) -> list[ComparedStep]:
    """The steps of a plan in order: moves, waits and signals.

    `without`: lines of the program's own file whose steps are left out; `comments`: whose steps are left out where they
    take no time and switch nothing. `seconds`: of each step, as it was timed. `stop`: how many of the plan's steps are
    looked at.
    """
    found: list[ComparedStep] = []
    last = -1  # move among those that were found
    names = [PurePath(source.path).name for source in plan.sources]
    far, moves, durations = _far_apart(plan), _MoveRows.of(plan), plan.durations.tolist()
    steps = zip(*(column.tolist() for column in (plan.kind, plan.line, plan.source, plan.row)), strict=True)
    for at, (code, line, source, row) in enumerate(islice(steps, stop)):
        if without and line in without and source == 0:
            continue
        kind = _KINDS[code]
        took = float(seconds[at]) if len(seconds) else 0.0
        file = names[source]
        if kind is StepKind.MOVE:
            # Where the arm stands before its first move is mostly not known: there the move begins where it ends.
            begins = last >= 0 or plan.moves.start[row] != plan.moves.target[row]
            still = begins and not far[row] and _goes_nowhere(plan, row)
            last = len(found)
            found.append(_move(plan, moves, row, line, took, still, file))
            continue
        lasts = durations[row]
        if kind is StepKind.WAIT and lasts > 0.0 and last >= 0 and not found[last].exact:
            # A move whose end is passed comes to rest all the same where the program then waits for a time.
            found[last] = found[last]._replace(exact=True, blend=0.0)
        if kind is StepKind.WAIT and not lasts and row not in plan.events:
            continue  # a routine of the controller's own that is passed over, or a wait of no time
        if kind is StepKind.SIGNAL and not lasts and row not in plan.events:
            if line in comments and source == 0:
                continue
            if found and _is_message(found[-1]) and found[-1].line == line:
                continue  # a window and what it says: one message
        found.append(
            ComparedStep(kind, line, duration=lasts, seconds=took, event=plan.events.get(row), file=file)
        )
    return found


def _is_message(step: ComparedStep) -> bool:
    """Whether a step is a message, or the like."""
    return step.kind is StepKind.SIGNAL and step.event is None and not step.duration


def _middles(plan: Plan) -> Mapping[int, tuple[float, ...]]:
    """Row -> the point half on the way of each arc."""
    moves, positions = plan.moves, plan.positions.position
    rows = np.flatnonzero((moves.path == PATHS.index(Path.CIRCULAR)) & (moves.via >= 0))
    if not len(rows):
        return {}
    start, target = positions[moves.start[rows]], positions[moves.target[rows]]
    third = positions[moves.via[rows]]
    _, radius, _ = circle(start, target, third)
    points = point_on_arc(start, target, third, moves.before[rows], np.full(len(rows), 0.5))
    round_ = np.isfinite(radius).tolist()
    return {
        row: tuple(point)
        for row, point, is_round in zip(rows.tolist(), points.tolist(), round_, strict=True)
        if is_round
    }


def _far_apart(plan: Plan) -> list[bool]:
    """Of each move whether its ends are known, and surely not the same."""
    position = plan.positions.position
    if not len(position):
        return [False] * len(plan.moves.start)
    way = position[plan.moves.target] - position[plan.moves.start]
    far: list[bool] = (np.abs(way).max(axis=1) > 2 * _STILL).tolist()  # nan is not
    return far


def _goes_nowhere(plan: Plan, row: int) -> bool:
    moves, positions = plan.moves, plan.positions
    a, b = int(moves.start[row]), int(moves.target[row])
    if a == b:
        return True
    if not np.isnan(positions.position[[a, b]]).any():
        close = float(np.linalg.norm(positions.position[a] - positions.position[b])) < _STILL
        return close and _between(tuple(positions.quaternion[a]), tuple(positions.quaternion[b])) < _TURN
    difference = positions.axes[a] - positions.axes[b]
    known = difference[~np.isnan(difference)]
    return bool(len(known)) and bool((np.abs(known) < _TURN).all())


class _MoveRows(NamedTuple):
    """Columns of a plan's moves as lists, the positions by their index in the pool: every move asks for all."""

    target: list[int]
    path: list[int]
    blend_code: list[int]
    blend: list[float]
    travel: list[float]
    turn: list[float]
    duration: list[float]
    fraction: list[float]
    length: list[float]
    position: list[list[float]]
    quaternion: list[list[float]]
    axes: list[list[float]]
    tool: list[tuple[float, ...]]  # of each move
    middle: Mapping[int, tuple[float, ...]]  # row -> the point half on the way of each arc

    @classmethod
    def of(cls, plan: Plan) -> _MoveRows:
        moves, positions = plan.moves, plan.positions
        tools = {
            number: (*pose.position.tolist(), *quaternion_from_rotation(pose.rotation[None])[0].tolist())
            for number, pose in plan.tools.items()
        }
        held = [-1] * len(moves.target) if plan.held is None else plan.held.tolist()
        return cls(
            moves.target.tolist(),
            moves.path.tolist(),
            moves.blend_code.tolist(),
            moves.blend.tolist(),
            moves.travel.tolist(),
            moves.turn.tolist(),
            moves.duration.tolist(),
            moves.fraction.tolist(),
            moves.length.tolist(),
            positions.position.tolist(),
            positions.quaternion.tolist(),
            positions.axes.tolist(),
            [tools.get(number, ()) for number in held],
            _middles(plan),
        )


def _move(
    plan: Plan, moves: _MoveRows, row: int, line: int, took: float, still: bool, file: str
) -> ComparedStep:
    target, code = moves.target[row], moves.blend_code[row]
    path = PATHS[moves.path[row]]
    zone = code == BlendCode.ZONE and _shares(plan.zone_law)
    size = math.nan if zone else moves.blend[row]
    return ComparedStep(
        StepKind.MOVE,
        line,
        path,
        tuple(moves.position[target]),
        tuple(moves.quaternion[target]),
        tuple(moves.axes[target]),
        moves.travel[row] if path is not Path.JOINT else math.nan,
        moves.turn[row],
        _asked(plan, row) if path is Path.JOINT else moves.duration[row],
        0.0 if code == 0 else size,
        code == 0,
        seconds=took,
        length=moves.length[row],
        middle=moves.middle.get(row, ()),
        circle=_circle_of(plan, row) if row in moves.middle else (),
        still=still,
        file=file,
        fraction=moves.fraction[row],
        tool=moves.tool[row],
        beside=plan.beside.get(row, ()),
    )


@lru_cache(maxsize=32)
def _shares(law: str) -> bool:
    """Whether the sizes of a law's zones are shares of a way."""
    return load_law(law).share_zones


def _circle_of(plan: Plan, row: int) -> tuple[tuple[float, ...], ...]:
    moves = plan.moves
    places = (moves.start[row], moves.target[row], moves.via[row])
    return tuple(tuple(plan.positions.position[int(place)].tolist()) for place in places)


def _asked(plan: Plan, row: int) -> float:
    """[s] that a joint move's programmed speed asks for, no less than its axes need; nan without a robot."""
    moves, robot = plan.moves, plan.robot
    start, target = int(moves.start[row]), int(moves.target[row])
    turned = np.abs(plan.positions.axes[target] - plan.positions.axes[start])
    least = 0.0
    if robot is not None and not np.isnan(turned[: len(robot.axes)]).any():
        least = float((turned[: len(robot.axes)] / robot.speeds).max())
    if not math.isnan(moves.duration[row]):
        return max(float(moves.duration[row]), least)
    if not math.isnan(moves.axis_speed[row]):
        known = turned[~np.isnan(turned)]
        return max(float(known.max() / moves.axis_speed[row]), least) if len(known) else math.nan
    if not math.isnan(moves.travel[row]):
        return max(float(moves.length[row] / moves.travel[row]), least)
    if robot is None or math.isnan(moves.fraction[row]) or np.isnan(turned[: len(robot.axes)]).any():
        return math.nan
    return least / float(moves.fraction[row])
