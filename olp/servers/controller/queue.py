"""Targets in waiting, and how far their motion is already certain.

A corner is passed as fast as the moves behind it allow, because the arm has to be able to brake in what it knows of
its way. So the motion of a target depends on later ones, and a step may be handed out only when no later target can
change it any more. Whether it can is found out without knowing the corner's law: the plan is timed as it is, which
ends in a stop, and again with its last move braking more softly. Where both agree, the stop at the end is not what
rules, and a longer way would not change anything either.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.source import Source
from olp.ir.points import PointKind, PointState
from olp.ir.program import Path
from olp.robots.coordinate_systems import Cell, Mechanism, Tool
from olp.robots.geometry import Pose
from olp.runtime.plan import PATHS, BlendCode, Plan
from olp.runtime.recorder import Recorder
from olp.servers.controller.target import Target
from olp.timing.corners import CornerPieces
from olp.timing.motion import Profile
from olp.timing.timing import Timing, time_plan

if TYPE_CHECKING:
    from olp.robots.robot import Robot

Floats = NDArray[np.float64]
_FRACTION, _TRAVEL, _TURN = 0, 1, 2  # units of speed as Recorder.row counts them
_SOFTER = 0.5  # times the deceleration of the last move: a corner at its end takes at most half of what is left of it
_SAME = 1e-12  # relative; times that differ by less are the same
_NOTHING = 1e-9  # [m or rad]: below this nothing moves
_CURVED, _JOINT = PATHS.index(Path.CIRCULAR), PATHS.index(Path.JOINT)


class Go(NamedTuple):
    """A target with the joints (k,) it was found to have, and the number of its tool."""

    number: int
    target: Target
    goals: tuple[Floats, ...]
    tool: int


class Stay(NamedTuple):
    """Standing still for `seconds` [s]."""

    number: int
    seconds: float


Item = Go | Stay


class CertainMotion(NamedTuple):
    """What is certain. Times [s] count from the start of the queue."""

    timing: Timing | None  # None: nothing moves
    horizon: float  # up to here nothing can change any more
    rests: bool  # the arm stands at the horizon: that is the end of a motion
    ends: Floats  # when each item of the queue is done, (m,) at most one per item


@dataclass(slots=True)
class Queue:
    """What is yet to be done from `origin` (k,), where the arm stands at the queue's start."""

    robot: Robot
    model: str
    acceleration: float | None
    settings: dict[str, str | float]
    origin: Floats
    tools: dict[int, Tool] = field(default_factory=lambda: {0: Tool(Pose.identity())})
    items: list[Item] = field(default_factory=list)
    closed: bool = False  # nothing more will come

    @property
    def last_joints(self) -> Floats:
        """(k,): where the last target leaves the arm."""
        for item in reversed(self.items):
            if isinstance(item, Go):
                return item.goals[-1]
        return self.origin

    def drop(self, count: int) -> None:
        """Forgets the first `count` items; the arm must have come to a stop behind them."""
        for item in self.items[:count]:
            if isinstance(item, Go):
                self.origin = item.goals[-1]
        del self.items[:count]

    def known(self) -> CertainMotion:
        """Times what can be timed. Raises OlpError where a move cannot."""
        items = self.items
        if not items:
            return CertainMotion(None, 0.0, True, np.zeros(0))
        plan, steps = self._plan(items)
        shapeless = not self.closed and isinstance(items[-1], Go) and items[-1].target.path is Path.SPLINE
        if shapeless:
            plan = _with_least_end(plan)
        timing = time_plan(plan, self.model, self.acceleration)
        problems = [d for d in timing.diagnostics if d.is_error]
        if problems:
            from olp.core.diagnostic import OlpError

            raise OlpError(*problems)
        ends = timing.end_s[np.array(steps) - 1]
        if self.closed or stops(items[-1]):
            return CertainMotion(timing, timing.total_s, True, ends)
        return CertainMotion(timing, self._certain(plan, timing, int(shapeless)), False, ends)

    def _certain(self, plan: Plan, timing: Timing, unknown: int) -> float:
        """[s] up to which a softer stop at the end changes nothing; the last move and `unknown` more are not it."""
        moves = plan.moves
        moving = np.nonzero(timing.rows.length > _NOTHING)[0][: -unknown or None]
        last = int(moving[-1]) if len(moving) else 0
        deceleration = moves.deceleration.copy()
        deceleration[last:] *= _SOFTER
        other = replace(plan, moves=replace(moves, deceleration=deceleration))
        softer = time_plan(other, self.model, self.acceleration).rows
        mine = timing.rows
        same = np.ones(len(moves), dtype=bool)
        for one, two in zip(_columns(mine), _columns(softer), strict=True):
            size = np.maximum(np.abs(one), np.abs(two)).max(initial=1.0)
            same &= np.abs(one - two).reshape(len(moves), -1).max(axis=1, initial=0.0) <= _SAME * size
        same[last:] = False
        return max(0.0, float(min(mine.start[~same].min(), softer.start[~same].min())))

    def _plan(self, items: list[Item]) -> tuple[Plan, list[int]]:
        """The plan of the items, and how many of its steps are done behind each."""
        text = tuple(f"target {item.number}" for item in items)
        source = Source("controller", "\n".join(text).encode(), "utf-8", text)
        recorder = Recorder(Cell([Mechanism("RB1", self.robot)], self.tools), (source,))
        tool = next((item.tool for item in items if isinstance(item, Go)), 0)
        recorder.at[0] = recorder.position(0, _state(tool), self.origin.tolist())
        steps = []
        for line, item in enumerate(items, 1):
            if isinstance(item, Stay):
                recorder.wait(0, line, item.seconds)
            else:
                _record(recorder, line, item)
            steps.append(len(recorder))
        return replace(recorder.finish(()), settings=self.settings), steps


def _with_least_end(plan: Plan) -> Plan:
    """The next point shapes the last move of a spline: until it is known, no length of it may be relied on."""
    length = plan.moves.length.copy()
    length[-1] = min(length[-1], 2 * _NOTHING)
    return replace(plan, moves=replace(plan.moves, length=length))


def stops(item: Item) -> bool:
    """Whether the arm stands behind an item whatever follows."""
    if isinstance(item, Stay):
        return True
    return item.target.zone == 0.0 and item.target.path is not Path.SPLINE


def _columns(rows: object) -> list[Floats]:
    """Every number that says how rows move, (m,) or (m, p) each; a row's end is no part of its motion."""
    found: list[Floats] = []
    for name in type(rows).__dataclass_fields__:  # type: ignore[attr-defined]
        value = getattr(rows, name)
        if isinstance(value, Profile):
            found += [value.durations, value.accelerations, value.jerks, value.speeds]
        elif isinstance(value, CornerPieces):
            found += [value.span, value.lead, value.before, value.after, value.entry, value.exit]
        elif isinstance(value, np.ndarray):
            found.append(value)
    return found


def _state(tool: int) -> PointState:
    return PointState(PointKind.JOINT, "joint", None, tool)


def _record(recorder: Recorder, line: int, item: Go) -> None:
    """One step per goal; an arc begins with a point where the arm already stands, as controllers want it."""
    target = item.target
    path = PATHS.index(target.path)
    unit, speed = (_TURN, target.turn) if target.speed is None else (_TRAVEL, target.speed)
    assert speed is not None
    unit = _FRACTION if path == _JOINT else unit

    def row(index: int, code: BlendCode, zone: float = np.nan, end_of_arc: bool = False) -> None:
        recorder.step(0, line)
        share = target.acceleration, target.deceleration
        recorder.row(0, index, path, unit, speed, code, zone, *share, end_of_arc=end_of_arc)

    if path == _CURVED:
        row(recorder.at[0], BlendCode.UNTAGGED, end_of_arc=True)
    *between, end = (recorder.position(0, _state(item.tool), joints.tolist()) for joints in item.goals)
    for index in between:
        row(index, BlendCode.UNTAGGED)
    if target.zone is None:
        row(end, BlendCode.UNTAGGED, end_of_arc=path == _CURVED)
    elif target.zone > 0.0:
        row(end, BlendCode.ZONE, target.zone, end_of_arc=path == _CURVED)
    else:
        row(end, BlendCode.EXACT, end_of_arc=path == _CURVED)
