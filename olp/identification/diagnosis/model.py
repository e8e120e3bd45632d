"""Terms with values, acting together: what the judged simulation would say with them in it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.timing.physics import Form, MoveTerm
from olp.timing.physics._case import MeasuredMoves, RepeatedMoves, Rivals
from olp.timing.physics._motion import Motion, stacked

Floats = NDArray[np.float64]


class Statement(NamedTuple):
    """Something plain that is true of some moves: a column of `FEATURES` above, below or equal to something."""

    column: str
    above: float = -math.inf
    below: float = math.inf
    word: str = ""

    def mask(self, case: MeasuredMoves) -> NDArray[np.bool_]:
        """(n,)"""
        values = feature(case, self.column)
        if isinstance(values, tuple):
            return np.array([value == self.word for value in values], dtype=bool)
        with np.errstate(invalid="ignore"):
            return np.asarray((values > self.above) & (values < self.below))

    def __str__(self) -> str:
        if self.word:
            return f"{self.column} {self.word}"
        unit, factor = _UNITS.get(self.column, ("", 1.0))
        sign, bound = (">", self.above) if math.isfinite(self.above) else ("<", self.below)
        if self.column == _PLACE:  # between two axes: the last one without, or the first one
            bound = math.floor(bound) if sign == ">" else math.ceil(bound)
        return f"{self.column} {sign} {bound * factor:.4g}{' ' + unit if unit else ''}"


class Condition(NamedTuple):
    """All of its statements hold."""

    statements: tuple[Statement, ...]

    def mask(self, case: MeasuredMoves) -> NDArray[np.bool_]:
        """(n,)"""
        held = np.ones(len(case), dtype=bool)
        for statement in self.statements:
            held &= statement.mask(case)
        return held

    @property
    def by_axis(self) -> bool:
        """Whether it is about the leading axis: an axis that takes over brings its own answer."""
        return any(statement.column in ("axis", _PLACE) for statement in self.statements)

    def __str__(self) -> str:
        return " and ".join(map(str, self.statements))


_UNITS = {
    **dict.fromkeys(("x", "y", "z", "start x", "start y", "start z", "length"), ("mm", 1000.0)),
    **dict.fromkeys(("middle x", "middle y", "middle z"), ("mm", 1000.0)),
    **dict.fromkeys(("turn",), ("deg", 180.0 / math.pi)),
    **{"speed": ("mm/s", 1000.0), "time": ("s", 1.0), "payload": ("kg", 1.0)},
}


_PLACE = "axis number"
FEATURES = (
    *(
        "x",
        "y",
        "z",
        "start x",
        "start y",
        "start z",
        "middle x",
        "middle y",
        "middle z",
        "length",
        "incline",
        "speed",
        "turn",
        "payload",
        "time",
    ),
    *("axis", _PLACE, "job", "line"),
)


def feature(case: MeasuredMoves, name: str) -> Floats | tuple[str, ...]:
    """What a condition can be about, one of `FEATURES`: numbers (n,) in SI, nan where not known, or words, "" likewise.

    x, y, z: of the end of a move; middle: halfway from start to end of a straight move, as no joint
    move passes there; incline: the sine of its direction, up is
    positive; axis: the one that leads; axis number: its place from the base, 1 for the first.
    """
    if name in _NUMBERS:
        return case.once(f"feature {name}", lambda: _NUMBERS[name](case))
    if name == "axis":
        return case.leading
    if name == "job":
        return case.job
    return tuple(
        f"{job}:{line}" if job and line else str(line) if line else ""
        for job, line in zip(case.job, case.line.tolist(), strict=True)
    )


_NUMBERS: dict[str, Callable[[MeasuredMoves], Floats]] = {
    **{axis: lambda case, k=k: case.end[:, k] for k, axis in enumerate("xyz")},  # type: ignore[misc]
    **{f"start {axis}": lambda case, k=k: case.start[:, k] for k, axis in enumerate("xyz")},  # type: ignore[misc]
    **{
        f"middle {axis}": lambda case, k=k: np.where(  # type: ignore[misc]
            case.joint, np.nan, 0.5 * (case.start[:, k] + case.end[:, k])
        )
        for k, axis in enumerate("xyz")
    },
    "length": lambda case: case.length,
    "incline": lambda case: np.where(np.isfinite(case.length), case.rise, np.nan),
    "speed": lambda case: np.where(case.moving & ~case.joint, case.base.speed, np.nan),
    "turn": lambda case: case.turn,
    "payload": lambda case: case.payload,
    "time": lambda case: case.t_start - case.began,
    _PLACE: lambda case: _places(case),
}


def _places(case: MeasuredMoves) -> Floats:
    """(n,) Of the leading axis from the base, 1 for the first; nan where it is not known. The axes of the arm and those
    of the wrist have drives of their own kinds: what goes for one goes for its neighbours."""
    names = () if case.rates is None else case.rates.names
    return np.array([names.index(name) + 1.0 if name else math.nan for name in case.leading])


_LATELY = 64  # motions that a case keeps


@lru_cache(maxsize=_LATELY)
def _named(condition: Condition) -> str:
    """What a case keeps its moves under."""
    return f"where {condition!r}"


class ModelPart(NamedTuple):
    """One term of a model, in one of its forms, in all moves or under a condition."""

    term: MoveTerm
    form: Form
    values: Floats  # (p,) SI
    condition: Condition | None = None

    @property
    def label(self) -> str:
        """Told apart from all other parts of a model: one form per term, but one for each axis."""
        return f"{self.term.name}/{self.form.axis}"

    @property
    def conditionable(self) -> bool:
        """Whether the term changes moves one by one, not the way in which all of them are made."""
        return self.term.conditionable

    @property
    def reversible(self) -> bool:
        """Whether other values do the opposite: a limit only slows."""
        first = self.form.parameters[0]
        return first.low < first.null < first.high

    def act(self, motion: Motion, case: MeasuredMoves) -> Motion:
        """The motion with the part in it. A fit asks again and again for the parts whose values it leaves."""
        if isinstance(case, RepeatedMoves):  # of trials: each is asked for once
            return self._made(motion, case)
        of = (self.term.name, self.form.key, self.form.axis, self.condition)
        key = (id(motion), self.values.tobytes(), of)
        known = case.acted.get(key)
        if known is not None:
            return known[1]
        changed = self._made(motion, case)
        if len(case.acted) >= _LATELY:
            del case.acted[next(iter(case.acted))]
        case.acted[key] = (motion, changed)  # it keeps the motion: no other one has its number meanwhile
        return changed

    def _made(self, motion: Motion, case: MeasuredMoves) -> Motion:
        changed = self.term.act(motion, self.form, self.values, case)
        if self.condition is None:
            return changed
        return motion.where(case.once(_named(self.condition), lambda: self._mask(case)) > 0, changed)

    def _mask(self, case: MeasuredMoves) -> Floats:
        assert self.condition is not None
        return self.condition.mask(case).astype(np.float64)


class _Led(NamedTuple):
    """The motion of the axes that lead in the simulation, and of those that may take over."""

    motion: Motion
    rivals: Motion | None

    @classmethod
    def of(cls, case: MeasuredMoves) -> _Led:
        return cls(case.base, None if case.rivals is None else case.rivals.moves.base)

    def with_(self, part: ModelPart, case: MeasuredMoves) -> _Led:
        """The same with one more part in it: what does not act axis by axis acts on all of a move's axes alike."""
        motion, rivals = part.act(self.motion, case), self.rivals
        if rivals is None or case.rivals is None:
            return _Led(motion, None)
        if part.term.by_axis(part.form) or (part.condition is not None and part.condition.by_axis):
            return _Led(motion, part.act(rivals, case.rivals.moves))
        more = {
            name: getattr(rivals, name) * (after / before)[case.rivals.of]
            for name in _SET_BY_AXES
            if (after := getattr(motion, name)) is not (before := getattr(self.motion, name))
        }
        return _Led(motion, rivals.with_(**more) if more else rivals)

    def together(self, case: MeasuredMoves) -> Motion:
        """Of whole moves, corners included: a corner belongs to both of the moves that meet there."""
        motion, partners = self._slowest_axes(case), case.partners
        return motion if partners is None else motion.meeting(case.base, *partners)

    def _slowest_axes(self, case: MeasuredMoves) -> Motion:
        """All axes start and end together: whichever allows the least speed or acceleration sets it for all, or the
        slowest one takes its own time."""
        if self.rivals is None or case.rivals is None:
            return self.motion
        if case.slowest:
            return _slowest(self.motion, self.rivals, case.rivals)
        simulated = all(
            one.way is whole.way
            for one, whole in ((self.motion, case.base), (self.rivals, case.rivals.moves.base))
        )
        per_turn = partial(_per_turn, self.motion, self.rivals, case.rivals)
        turn = case.once("per turn", per_turn) if simulated else per_turn()
        least = dict[str, Floats]()
        for name in _SET_BY_AXES:
            mine, others = getattr(self.motion, name), getattr(self.rivals, name)
            work_out = partial(_least, mine, others, turn, case.rivals)
            if (
                simulated
                and mine is getattr(case.base, name)
                and others is getattr(case.rivals.moves.base, name)
            ):
                least[name] = case.once(f"together {name}", work_out)
            else:
                least[name] = work_out()
        return self.motion.with_(**least)


def _slowest(motion: Motion, others: Motion, rivals: Rivals) -> Motion:
    """The motion of the leading axes, with the limits of a rival where that takes longer alone."""
    places, rows = rivals.together
    alone, turn = _between_stops(others), _per_turn(motion, others, rivals)
    slowest = places[np.argmax(alone[places], axis=0), np.arange(len(rows))]
    over = alone[slowest] > _between_stops(motion)[rows]
    slowest, rows = slowest[over], rows[over]
    changed = dict[str, Floats]()
    for name in _SET_BY_AXES:
        changed[name] = getattr(motion, name).copy()
        changed[name][rows] = getattr(others, name)[slowest] * turn[slowest]
    return motion.with_(**changed)


def _between_stops(motion: Motion) -> Floats:
    """(n,) [s] from rest to rest with constant accelerations."""
    ramps = 0.5 / motion.accelerate + 0.5 / motion.decelerate
    reached = motion.way >= motion.speed**2 * ramps
    cruising = motion.way / motion.speed + motion.speed * ramps
    return np.asarray(np.where(reached, cruising, 2.0 * np.sqrt(motion.way * ramps)))


def _per_turn(motion: Motion, others: Motion, rivals: Rivals) -> Floats:
    """(r,) the way of the leading axis per turn of each rival."""
    return np.asarray(motion.way[rivals.of] / others.way)


def _least(mine: Floats, others: Floats, per_turn: Floats, rivals: Rivals) -> Floats:
    """(n,) the least of what the leading axes and their rivals allow."""
    at_most, (places, rows) = mine.copy(), rivals.together
    at_most[rows] = np.minimum(at_most[rows], (others * per_turn)[places].min(axis=0))
    return at_most


_SET_BY_AXES = ("speed", "accelerate", "decelerate")
_ROWS = 4096  # of motions in one go: more do not stay near to the processor


class _Stack(NamedTuple):
    """What some changes of a model make of the same moves, one below the other."""

    of: tuple[int, ...]  # the changes
    led: _Led

    def with_(self, part: ModelPart, case: MeasuredMoves) -> _Stack:
        return self._replace(led=self.led.with_(part, case.repeated(len(self.of))))

    @property
    def manner(self) -> tuple[object, ...]:
        return self.led.motion.manner, None if self.led.rivals is None else self.led.rivals.manner


def _stacked(stacks: Sequence[_Stack], case: MeasuredMoves) -> list[_Stack]:
    """Those in one manner together, as far as they are not too large."""
    alike: dict[tuple[object, ...], list[list[_Stack]]] = {}
    for stack in stacks:
        bunches = alike.setdefault(stack.manner, [[]])
        if sum(len(one.of) for one in (*bunches[-1], stack)) * len(case) > _ROWS:
            bunches.append([])
        bunches[-1].append(stack)
    return [_together(bunch, case) for bunches in alike.values() for bunch in bunches if bunch]


def _together(stacks: Sequence[_Stack], case: MeasuredMoves) -> _Stack:
    """One stack of those in one manner."""
    if len(stacks) == 1:
        return stacks[0]
    each = [case.repeated(len(one.of)) for one in stacks]
    of = tuple(at for one in stacks for at in one.of)
    whole = case.repeated(len(of))
    motion = stacked([one.led.motion for one in stacks], [moves.base for moves in each], whole.base)
    rivals = [one.led.rivals for one in stacks if one.led.rivals is not None]
    if not rivals or whole.rivals is None:
        return _Stack(of, _Led(motion, None))
    bases = [moves.rivals.moves.base for moves in each if moves.rivals is not None]
    return _Stack(of, _Led(motion, stacked(rivals, bases, whole.rivals.moves.base)))


_OPEN = 0.02  # of a cycle: digits that leave more open tell nothing of rounding
_MOST_DIGITS = 6  # behind the point


class DurationModel(NamedTuple):
    """Prediction of durations: the judged simulation's, plus what the parts change in its motion."""

    parts: tuple[ModelPart, ...] = ()

    def seconds(self, case: MeasuredMoves) -> Floats:
        """(n,) [s] predicted durations."""
        return self.both(case)[0]

    def smooth(self, case: MeasuredMoves) -> Floats:
        """(n,) [s] the same, with the mean of rounding to a cycle in its place: it has derivatives."""
        return self.both(case)[1]

    def both(self, case: MeasuredMoves) -> tuple[Floats, Floats]:
        """`seconds` and `smooth` at the price of one."""
        moves = self._moves_of(case)
        motion = self.motion(moves)
        whole, mean = _in_cycles(_seconds_of(motion, moves), motion, moves)
        own = whole[: len(case)]  # the same array twice tells a fit that nothing is rounded
        return own, own if mean is whole else mean[: len(case)]

    def _moves_of(self, case: MeasuredMoves) -> MeasuredMoves:
        """The moves that the durations of those of the case hang on, these first."""
        passed = case.base.law != "stop" or any(part.term.phase == "corner" for part in self.parts)
        return case.wider if case.wider is not None and passed else case

    def smooth_with(self, changes: Sequence[tuple[int, ModelPart]], case: MeasuredMoves) -> list[Floats]:
        """Per change (n,) [s] `smooth` with another part in the place of one; what acts before that is kept."""
        return [smooth for _, smooth in self.both_with(changes, case)]

    def both_with(
        self, changes: Sequence[tuple[int, ModelPart]], case: MeasuredMoves
    ) -> list[tuple[Floats, Floats]]:
        """Per change `both` likewise."""
        own, case = len(case), self._moves_of(case)
        order = sorted(range(len(self.parts)), key=lambda k: self.parts[k].term.stage)
        stacks, before = list[_Stack](), _Led.of(case)
        for k in order:
            stacks = [stack.with_(self.parts[k], case) for stack in stacks]
            mine = [(at, part) for at, (index, part) in enumerate(changes) if index == k]
            stacks += [_Stack((at,), before.with_(part, case)) for at, part in mine]
            stacks = _stacked(stacks, case)
            if k != order[-1]:
                before = before.with_(self.parts[k], case)
        found = dict[int, tuple[Floats, Floats]]()
        _base(case)
        for of, led in stacks:
            moves = case.repeated(len(of))
            motion = led.together(moves)
            both = _in_cycles(_seconds_of(motion, moves), motion, moves)
            each = (columns.reshape(len(of), -1)[:, :own] for columns in both)
            found.update(zip(of, zip(*each, strict=True), strict=True))
        return [found[at] for at in range(len(changes))]

    def motion(self, case: MeasuredMoves) -> Motion:
        """The simulation's motion with all parts in it."""
        led = _Led.of(case)
        for part in sorted(self.parts, key=lambda p: p.term.stage):
            led = led.with_(part, case)
        return led.together(case)

    def without(self, index: int) -> DurationModel:
        return DurationModel(self.parts[:index] + self.parts[index + 1 :])

    def contributions(self, case: MeasuredMoves) -> tuple[Floats, ...]:
        """Per part (n,) [s]: its share of the whole correction. The shares add up to it exactly.

        A part's share is the mean of what it adds as the first and as the last of all parts, and what these leave
        over (they act together) is split in proportion to their sizes.
        """
        whole = self.seconds(case) - case.simulated
        shares = []
        for index, part in enumerate(self.parts):
            first = DurationModel((part,)).seconds(case) - case.simulated
            last = self.seconds(case) - self.without(index).seconds(case)
            shares.append(0.5 * (first + last))
        return _balanced(shares, whole)


def _seconds_of(motion: Motion, case: MeasuredMoves) -> Floats:
    """(n,) [s] of whole durations, before they are rounded to a cycle."""
    return np.asarray((case.simulated + motion.duration() - _base(case)) * motion.rate)


def _in_cycles(seconds: Floats, motion: Motion, case: MeasuredMoves) -> tuple[Floats, Floats]:
    """(n,) [s] whole durations rounded to the motion's cycle, and with the mean of rounding instead.

    A duration as near to a multiple as the simulation's digits leave it may be on either side of it: what was recorded
    tells on which.
    """
    cycle = motion.cycle
    if cycle <= 0:
        return seconds, seconds
    open_by = min(float(case.once("half a digit", lambda: _half_a_digit(case.simulated))[0]), _OPEN * cycle)
    rounded, other = (
        np.ceil((seconds + side) / cycle - motion.early - 1e-6) * cycle for side in (-open_by, open_by)
    )
    rounded = np.where(np.abs(case.measured - other) < np.abs(case.measured - rounded), other, rounded)
    mean = seconds + (0.5 - motion.early) * cycle
    if not motion.timed:
        return np.asarray(rounded), mean
    waits = motion.way <= 0
    return np.where(waits, seconds, rounded), np.where(waits, seconds, mean)


def _half_a_digit(seconds: Floats) -> Floats:
    """(1,) [s] half of the last digit that durations have, 0 where these have more than six behind the point."""
    for digits in range(1, _MOST_DIGITS + 1):
        if np.abs(seconds - np.round(seconds, digits)).max(initial=0.0) < 1e-9:
            return np.array([0.5 * 10.0**-digits])
    return np.zeros(1)


def _base(case: MeasuredMoves) -> Floats:
    """(n,) [s] of the judged simulation's motion."""
    return case.once("base", case.base.duration)


def _balanced(shares: Sequence[Floats], whole: Floats) -> tuple[Floats, ...]:
    if not shares:
        return ()
    left = whole - np.sum(shares, axis=0)
    sizes = np.abs(shares)
    total = sizes.sum(axis=0)
    parts = np.where(total > 0, sizes / np.where(total > 0, total, 1.0), 1.0 / len(shares))
    return tuple(share + part * left for share, part in zip(shares, parts, strict=True))
