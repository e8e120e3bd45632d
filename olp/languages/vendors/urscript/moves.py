"""Lowers moves: arguments by place or by name, the manual's defaults written out, frames that `pose_trans` names.

Codes: P558 arguments that a call does not have, P561 a time that decides whether the speed counts and is not known,
P568 a speed that is mm/s by its size.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

from olp.ir.expressions import Expression, FrameRef, Named, Number, Quantity, SignalState
from olp.ir.program import Acceleration, AccelerationUnit, Blend, BlendKind, Move, Path, Speed, SpeedUnit
from olp.languages.vendors.urscript import builtins
from olp.languages.vendors.urscript.expressions import Expressions
from olp.languages.vendors.urscript.syntax import (
    Invocation,
    Node,
    PlainPose,
    PoseOf,
    UrscriptArgument,
    UrscriptName,
    fold,
)

_PATHS: Final = {
    "movej": Path.JOINT,
    "movel": Path.LINEAR,
    "movep": Path.LINEAR,
    "movec": Path.CIRCULAR,
    "optimovej": Path.JOINT,
    "optimovel": Path.LINEAR,
}
_FASTEST = 20.0  # [m/s]; no arm is a tenth as fast
BASE: Final = FrameRef("base")
_TRANS: Final = UrscriptName("pose_trans")
_STOP: Final = Blend(BlendKind.RADIUS, Quantity(Number(0), 1.0))


class Manner(NamedTuple):
    """How a move goes, without where."""

    speed: Speed
    rate: Acceleration | None
    acceleration: Quantity | None
    blend: Blend
    other: tuple[tuple[str, Expression], ...]


class UrscriptMoveRules:
    """Lowers the moves of one part."""

    def __init__(self, expressions: Expressions, tell: Callable[[str, str, str], None]) -> None:
        self._expressions = expressions
        self._tell = tell
        self._manners: dict[tuple[str, tuple[UrscriptArgument, ...]], Manner] = {}
        self._rates: dict[tuple[AccelerationUnit, Node | None], Acceleration] = {}
        self._blends: dict[Node, Blend] = {}
        self._frames: dict[Node, Expression] = {}
        self._turns: dict[Node, bool] = {}

    def move(self, word: str, given: tuple[UrscriptArgument, ...], line: int, comment: str) -> Move | None:
        """The move, None when it has no target (which is told)."""
        count = 2 if word == "movec" else 1
        if count == 1 and given and not given[0].name:
            targets, rest = [given[0].value], given[1:]
        elif all(not one.name for one in given[:count]) and len(given) >= count:
            targets, rest = [one.value for one in given[:count]], given[count:]
        else:
            arguments = self._sorted(word, given, count)
            if arguments is None:
                return None
            targets, rest = arguments
        key = (word, rest)
        manner = self._manners.get(key)
        if manner is None:
            manner = self._manners[key] = self._manner(word, rest, count)
        frame, places = self._placed(targets)
        lower = self._expressions.lower
        goal = places[-1]
        target = Named(goal.text) if type(goal) is UrscriptName else lower(goal, True)
        via = lower(places[0], True) if count == 2 else None
        speed, rate, acceleration, blend, other = manner
        return Move(
            line,
            _PATHS[word],
            (target,),
            speed,
            blend,
            (),
            comment,
            acceleration,
            other=other,
            via=via,
            rate=rate,
            frame=frame,
        )

    def _sorted(
        self, word: str, given: tuple[UrscriptArgument, ...], count: int
    ) -> tuple[list[Node], tuple[UrscriptArgument, ...]] | None:
        """Targets that are given by name or out of order."""
        places = builtins.MOVES[word]
        targets: dict[str, Node] = {}
        rest = []
        for index, one in enumerate(given):
            name = one.name or (places[index] if index < len(places) else "")
            if name in ("q", "pose") and places[0] in ("q", "pose"):
                name = places[0]
            if name in places[:count]:
                targets[name] = one.value
            else:
                rest.append(UrscriptArgument(one.name or name, one.value))
        if len(targets) < count:
            needs = " and ".join(places[:count])
            self._tell("P558", f"{word} has no target", f"it needs {needs}")
            return None
        return [targets[name] for name in places[:count]], tuple(rest)

    # --- how --------------------------------------------------------------------------------------------

    def _manner(self, word: str, rest: tuple[UrscriptArgument, ...], count: int) -> Manner:
        arguments = self._named(word, rest, count)
        if word.startswith("optimove"):
            return self._optimal(arguments)
        joint = word == "movej"
        unit = AccelerationUnit.AXIS if joint else AccelerationUnit.TRAVEL
        defaults = builtins.JOINT_DEFAULTS if joint else builtins.PATH_DEFAULTS
        # What is written alike is one object: passes ask by it what became of it in another move.
        given = unit, arguments.get("a")
        rate = self._rates.get(given)
        if rate is None:
            rate = self._rates[given] = Acceleration(unit, self._quantity(given[1], defaults[0]))
        speed, other = self._speed(
            word, arguments, SpeedUnit.AXIS if joint else SpeedUnit.TRAVEL, defaults[1]
        )
        if word == "movep":
            other += (("process", SignalState(True)),)
        if "mode" in arguments and self._expressions.number(arguments["mode"]) != 0:
            other += (("mode", self._expressions.lower(arguments["mode"])),)
        return Manner(speed, rate, None, self._blend(arguments), other)

    def _optimal(self, arguments: dict[str, Node]) -> Manner:
        acceleration, speed = builtins.OPTIMAL_DEFAULTS
        return Manner(
            Speed(SpeedUnit.FRACTION, self._quantity(arguments.get("v"), speed)),
            None,
            self._quantity(arguments.get("a"), acceleration),
            self._blend(arguments),
            (),
        )

    def _named(self, word: str, rest: tuple[UrscriptArgument, ...], count: int) -> dict[str, Node]:
        places = builtins.MOVES[word][count:]
        found: dict[str, Node] = {}
        for index, one in enumerate(rest):
            name = one.name or (places[index] if index < len(places) else "")
            if name not in places:
                what = f"no argument {name}" if name else f"{len(rest) + count} arguments"
                self._tell("P558", f"{word} takes {what}", f"it takes {', '.join(builtins.MOVES[word])}")
            elif name in found:
                self._tell("P558", f"{word} is given {name} twice", "remove one of them")
            else:
                found[name] = one.value
        return found

    def _speed(
        self, word: str, arguments: dict[str, Node], unit: SpeedUnit, default: float
    ) -> tuple[Speed, tuple[tuple[str, Expression], ...]]:
        """The speed, or the time where one is given: it overrides speed and acceleration."""
        travel = Speed(unit, self._quantity(arguments.get("v"), default))
        if unit is SpeedUnit.TRAVEL and (travel.value.literal or 0.0) > _FASTEST:
            self._tell("P568", f"{word} with {travel.value.literal:g} m/s", "v is in m/s, a in m/s²")
        time = arguments.get("t")
        if time is None:
            return travel, ()
        value = self._expressions.number(time)
        written = fold(self._expressions.lower(time))
        if value is None and type(time) is UrscriptName:
            value = self._expressions.names.constant(self._expressions.part, time.text)
            if value is not None and value <= 0:
                return travel, ((builtins.NO_TIME, written),)
        if value is None and "v" in arguments:
            message = f"{word} with a time that is computed: taken as 0, so that the speed counts"
            self._tell("P561", message, "a time above 0 overrides the speed")
            return travel, (("t", written),)
        if value is not None and value <= 0:
            return travel, ()
        other = (("v", travel.value.written),) if "v" in arguments else ()
        return Speed(SpeedUnit.TIME, Quantity(written, 1.0)), other

    def _blend(self, arguments: dict[str, Node]) -> Blend:
        node = arguments.get("r")
        if node is None:
            return _STOP
        known = self._blends.get(node)
        if known is None:
            radius = self._quantity(node, 0.0)
            known = _STOP if radius.literal == 0.0 else Blend(BlendKind.RADIUS, radius)
            self._blends[node] = known
        return known

    def _quantity(self, node: Node | None, default: float) -> Quantity:
        return Quantity(Number(default) if node is None else fold(self._expressions.lower(node)), 1.0)

    # --- where ------------------------------------------------------------------------------------------

    def _placed(self, targets: list[Node]) -> tuple[Expression, list[Node]]:
        """The frame that all targets stand in, and the targets in it."""
        if len(targets) == 1:
            if type(targets[0]) is not Invocation:
                return BASE, targets
            only, place = self._in_frame(targets[0])
            return (BASE, targets) if only is None else (self._frame(only), [place])
        split = [self._in_frame(target) for target in targets]
        frame = split[0][0]
        if frame is None or any(one[0] != frame for one in split):
            return BASE, targets
        return self._frame(frame), [place for _, place in split]

    def _frame(self, node: Node) -> Expression:
        """Few names of frames: all moves in one share it."""
        if type(node) is not UrscriptName:
            return self._expressions.lower(node)
        found = self._frames.get(node)
        if found is None:
            found = self._frames[node] = self._expressions.lower(node)
        return found

    def _in_frame(self, target: Node) -> tuple[Node | None, Node]:
        if type(target) is not Invocation or target.function != _TRANS or len(target.arguments) != 2:
            return None, target
        (_, frame), (_, place) = target.arguments
        turns = self._turns.get(frame) if type(frame) is UrscriptName else None
        if turns is None:
            turns = self._turn_points(frame)
            if type(frame) is UrscriptName:
                self._turns[frame] = turns
        return (frame, place) if turns else (None, target)

    def _turn_points(self, frame: Node) -> bool:
        """Whether `pose_trans` with this first argument says in which frame the second one stands."""
        if type(frame) is UrscriptName:
            waypoint = frame.text.endswith("_p") or frame.text in self._expressions.names.waypoints
        else:
            waypoint = type(frame) not in (PlainPose, PoseOf)
        return not waypoint and self._expressions.part.find("pose_trans") is None
