"""Values made up for what nothing at hand tells, so that two programs that share it can be compared.

Tools, frames, positions, inputs and variables that no file gives are zeros in a run, and two programs that use them in
different ways then do the same by chance. Here each of them has a value of its own, which depends on the seed and on
what it is in the source: the translation's run has the same one under the name that the translation gave it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import pi
from random import Random
from typing import ClassVar, Final, NamedTuple

import numpy as np

from olp.core.units import deg, mm
from olp.ir import terminology
from olp.ir.expressions import Store
from olp.ir.points import PointKind, PointState
from olp.robots.geometry import Pose
from olp.runtime.assumptions import SignalKey, holds_number
from olp.runtime.memory import ACTIVE, INTEGERS, Array, PositionValue, Record, Slot, Value

_NEAR: Final = (40 * mm, 12 * deg)  # how far a tool's or a frame's made-up pose is from none
_AROUND: Final = (80 * mm, 20 * deg)  # how far a position is from the middle of them
_MIDDLE: Final = (0.5, 0.0, 0.4, pi, 0.0, 0.0)  # [m], [rad] of an arm whose reach is not known
_AXES: Final = (0.1, -0.3, 0.3, 0.2, 0.9, 0.4)  # [rad] around which axis values are
_LARGEST: Final = 7  # number that nothing is compared with
_FRACTION: Final = 0.5
_POSITIONS: Final = ("position", "joints")
# The member of a record that says where a tool or a frame is.
_PLACED: Final = ("tframe", "uframe")

FrameAndTool = tuple[str, int | None, int]


class UnknownThing(NamedTuple):
    """What no file tells. `kind`: tool, frame, signal, variable, element, argument, start.

    `name` as its program has it.
    """

    kind: str
    name: int | str | SignalKey | tuple[Store, int] | tuple[str, int]


class MadeUpPosition(NamedTuple):
    """`place`: the frame, its number and the tool with which the source first used it."""

    value: PositionValue
    place: FrameAndTool


Made = Value | Pose | MadeUpPosition | None


@dataclass(slots=True)
class MadeUp:
    """What one run is told. `seed` 0: nothing; what could be made up is noted all the same.

    `origins`: a thing of this program -> of the source. `types`: of names that nothing declares, as `Declare.type`.
    `choices`: numbers that the source compares a thing with. `only`: all else is zero, and positions are those of no
    seed. `begins`: what the source's run made up, which the translation declares as zero. `places`: frame and tool of
    positions that hold them. `polls`: a wait with a limit looks once, as a loop that asks would. `turned`: inputs that
    this run took to change, so that loops end, in order; `turns`: those of the source's run under the names here, which
    are taken first, as one program may read its inputs in another order, or not all of them. `timed`: those of `turned`
    that ended loops which ask a clock, too; where the source's run has them, under the names here, waits with a limit
    for them end before it.
    """

    polls: ClassVar[bool] = True

    seed: int = 0
    origins: Mapping[UnknownThing, UnknownThing] = field(default_factory=dict)
    types: Mapping[str, str] = field(default_factory=dict)
    choices: Mapping[UnknownThing, tuple[int, ...]] = field(default_factory=dict)
    only: UnknownThing | None = None
    begins: Mapping[UnknownThing, Made] = field(default_factory=dict)
    places: Mapping[UnknownThing, FrameAndTool] = field(default_factory=dict)
    place: FrameAndTool = ("base", None, 0)  # that hold for the target that is evaluated
    asked: dict[UnknownThing, Made] = field(default_factory=dict)
    turned: list[SignalKey] = field(default_factory=list)
    turns: list[SignalKey] = field(default_factory=list)
    timed: set[SignalKey] = field(default_factory=set)

    def first_turned(self, inputs: Sequence[SignalKey]) -> list[SignalKey]:
        """Inputs that may end a loop: that which ended it in the source's run first."""
        next_one = next((key for key in self.turns if key in inputs), None)
        return [*([] if next_one is None else [next_one]), *(key for key in inputs if key != next_one)]

    def turn(self, key: SignalKey) -> None:
        self.turned.append(key)
        if key in self.turns:
            self.turns.remove(key)

    def origin(
        self, kind: str, name: int | str | SignalKey | tuple[Store, int] | tuple[str, int]
    ) -> UnknownThing:
        thing = UnknownThing(kind, name)
        return self.origins.get(thing, thing)

    def _is_made_up(self, thing: UnknownThing) -> bool:
        """Whether this run has a value of its own for what it asks for here."""
        self.asked.setdefault(thing, None)
        return bool(self.seed) and (self.only is None or self.only == thing)

    def _chance(self, thing: UnknownThing) -> Random | None:
        """Where its values come from, None where it has none."""
        return Random(f"{self.seed} {thing}") if self._is_made_up(thing) else None

    def _keep(self, thing: UnknownThing, made: Made) -> None:
        self.asked[thing] = made

    # --- what is asked for ------------------------------------------------------------------------------------

    def pose(self, kind: str, name: int | str) -> Pose | None:
        """Where a tool's centre point is on the flange, or a frame in the base; nothing of number 0, which is none."""
        thing = self.origin(kind, name)
        chance = self._chance(thing) if thing.name != 0 else None
        if chance is None:
            return None
        made = Pose.from_xyz_angles(_about((0.0,) * 6, _NEAR, chance))
        self._keep(thing, made)
        return made

    def signal(self, key: SignalKey, is_number: bool) -> int | None:
        thing = self.origin("signal", key)
        if not self._is_made_up(thing):
            return None
        # The other program may know the signal by a name, which does not say that it is a number.
        is_number = is_number or (isinstance(thing.name, SignalKey) and holds_number(thing.name.bus))
        # Every second seed has the other state.
        made = int(self._number(thing, True)) if is_number else (_first(thing) + self.seed) % 2
        self._keep(thing, made)
        return made

    def variable(self, store: Store, index: int, frames: bool) -> Value | None:
        """What a numbered variable holds. `frames`: positions of this language name their frame and tool."""
        thing = self.origin("variable", (store, index))
        if store is Store.ROBOT:
            return self._position(thing, frames)
        told = self.begins.get(thing)
        if isinstance(told, (bool, int, float)):
            return int(told) if isinstance(told, bool) else told  # the source's run came first
        # A register of the target may hold fractions where the variable of the source cannot.
        first = thing.name[0] if isinstance(thing.name, tuple) else store
        whole = store in INTEGERS or first in INTEGERS or self.types.get(str(thing.name)) == "integer"
        return self._plain(thing, "integer" if whole else "real" if store is Store.REAL else "")

    def named(self, name: str, type_: str) -> Value | None:
        thing = self.origin("variable", name)
        type_ = type_ or self.types.get(str(thing.name), "")
        return self._position(thing, False, type_) if type_ in _POSITIONS else self._plain(thing, type_)

    def state(self, name: str) -> Value | None:
        """What a program asks of its controller, where the translation has a variable for it."""
        variable = terminology.state_variable(name)
        return self.named(variable, "") if variable in self.types else None

    def result(self, name: str) -> int | bool:
        """What a function returns that is not known here."""
        return 0

    def argument(self, number: int, type_: str) -> Value | None:
        """What the main routine takes, by the place among its parameters."""
        thing = UnknownThing("argument", number)
        begun = self.begins.get(thing)
        if isinstance(begun, (bool, int, float)):
            return begun  # whatever type the translation gives it
        return self._position(thing, False, type_) if type_ in _POSITIONS else self._plain(thing, type_)

    def start(self, values: tuple[float, ...]) -> tuple[float, ...]:
        """Where the arm stands at first, around a place that it reaches."""
        chance = self._chance(UnknownThing("start", 0))
        return values if chance is None else _about(values, _NEAR, chance)

    def begun(self, name: str, slot: Slot) -> Slot:
        """A declared variable with what it is in the source, where the source does not tell that."""
        made = self._begin(UnknownThing("variable", name))
        if isinstance(slot.value, Array):
            for at in range(len(slot.value.items)):
                item = self._begin(UnknownThing("element", (name, at + 1)))
                if item is not None:
                    slot.value.items[at] = _held(item, slot.value.items[at])
        elif made is not None:
            slot.value = _held(made, slot.value)
        return slot

    def _begin(self, there: UnknownThing) -> Made:
        return self.begins.get(self.origins.get(there, there))

    # --- values -----------------------------------------------------------------------------------------------

    def _plain(self, thing: UnknownThing, type_: str) -> Value | None:
        if type_ not in ("integer", "real", "boolean") or not self._is_made_up(thing):
            return None
        if type_ == "boolean":
            made: Value = bool((_first(thing) + self.seed) % 2)
        else:
            made = self._number(thing, type_ == "integer")
        self._keep(thing, made)
        return made

    def _number(self, thing: UnknownThing, whole: bool) -> int | float:
        choices = self.choices.get(thing, ())
        if choices:
            return choices[(_first(thing) + self.seed) % len(choices)]
        number = _number_of(f"{self.seed} {thing}")
        return number if whole or self.seed % 2 else number + _FRACTION

    def _position(self, thing: UnknownThing, frames: bool, type_: str = "position") -> PositionValue | None:
        chance = self._chance(thing)
        if not self.seed:
            return None
        chance = chance or Random(str(thing))  # a position is somewhere
        begun = self.begins.get(thing)
        if isinstance(begun, MadeUpPosition) and begun.value.state.kind is PointKind.JOINT:
            value = begun.value  # a register holds axis values or a pose
        elif type_ == "joints":
            axes = tuple(axis + chance.uniform(-0.2, 0.2) for axis in _AXES)
            value = PositionValue(PointState(PointKind.JOINT, "joint"), axes)
        else:
            frame, user, tool = self.places.get(thing, ("base", None, 0)) if frames else (ACTIVE, None, 0)
            state = PointState(PointKind.POSE, frame, user, tool)
            value = PositionValue(state, _about(_MIDDLE, _AROUND, chance))
        self._keep(thing, MadeUpPosition(value, self.place))
        return value


def _first(thing: UnknownThing) -> int:
    return _place_of(str(thing))


# A program may ask its controller for something at every move.
@lru_cache(maxsize=4096)
def _place_of(thing: str) -> int:
    return Random(thing).randrange(1000)


@lru_cache(maxsize=4096)
def _number_of(seed_and_thing: str) -> int:
    return Random(seed_and_thing).randint(1, _LARGEST)


def _about(values: tuple[float, ...], by: tuple[float, float], chance: Random) -> tuple[float, ...]:
    """Six numbers of a pose, each moved."""
    return tuple(v + chance.uniform(-1.0, 1.0) * by[0 if at < 3 else 1] for at, v in enumerate(values))


def _held(made: Made, value: Value | None) -> Value | None:
    """What was made up as a variable with the value so far holds it; `value` where it cannot."""
    if isinstance(made, MadeUpPosition):
        made = made.value
    if isinstance(made, Pose):
        made = PositionValue(PointState(PointKind.POSE, ACTIVE), tuple(np.array(made.xyz_angles()).tolist()))
        if isinstance(value, Record):
            name = next((n for n in value.members if n.casefold() in _PLACED), None)
            return value if name is None else Record(value.type, {**value.members, name: made}, value.partial)
    numbers = isinstance(made, (bool, int, float)) and isinstance(value, (bool, int, float, type(None)))
    if numbers and isinstance(value, bool):
        return bool(made)
    return made if numbers or isinstance(made, PositionValue) else value
