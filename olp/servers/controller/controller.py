"""A controller that a simulator steps through its interpolation cycle.

The idea is that of realistic robot simulation (Apostolovic's thesis, 1.4.1): the simulator names robot, tool, frame and
position, gives the next target, and asks for the next step until it is told that another target is needed.

Targets wait until their motion is certain; then steps are cut out of it. A corner is passed as fast as the moves
behind it allow, because the arm has to be able to brake in what it knows of its way. So the motion of a target
depends on later ones, and a step may be handed out only when no later target can change it any more. Whether it can
is found out without knowing the corner's law: the plan is timed as it is, which ends in a stop, and again with its
last move braking more softly. Where both agree, the stop at the end is not what rules, and a longer way would not
change anything either.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.core.source import Source
from olp.ir.points import PointKind, PointState
from olp.ir.program import Path
from olp.robots.controller_effects import effects_of
from olp.robots.coordinate_systems import Cell, Mechanism
from olp.robots.geometry import Pose, compose
from olp.robots.kinematics.configuration import Tool, forward, with_tool, within_limits
from olp.runtime.plan import PATHS, BlendCode, Plan, StepKind
from olp.runtime.recorder import Recorder
from olp.servers.controller.target import Target, reach
from olp.timing.motion._profile import Profile
from olp.timing.motion.model import load_model
from olp.timing.result import CornerPieces, Timing
from olp.timing.timing import time_plan
from olp.timing.track import states, tool_speed

if TYPE_CHECKING:
    from olp.robots.model import Robot


Floats = NDArray[np.float64]
_BLOCK = 256  # steps that are computed at once; a new target throws them away
_LEAD_IN = (
    16  # samples from a move's start to the first step in it, so that the arm's configuration is followed
)
_SHARE = 1e-9  # of a cycle: nothing happens in so short a time
_ARRIVED = 1e-6  # [rad or m] an arm this near to its target's joints stands there


class State(StrEnum):
    """What can be asked of the controller next."""

    IDLE = "idle"  # stands, nothing was asked of it yet
    MOVING = "moving"  # the next step is known
    NEEDS_TARGET = "needs-target"  # the next step depends on what follows: a target, a wait, or the end
    DONE = "done"  # stands, everything was reached and the end was announced


@dataclass(frozen=True, slots=True)
class Step:
    """State of the arm after one interpolation cycle.

    `time` [s] since the position was set; `elapsed` [s] since the step before: one cycle, less for the last step of
    a motion, 0 when no step could be made. `joints` (k,) [rad or m]; `tool`: its pose in the controller's frame;
    `speed` [m/s] of the tool's point; `target`: the number of the current target (or wait), counted from 1. `state`
    after the step.
    """

    time: float
    elapsed: float
    state: State
    joints: Floats
    tool: Pose
    speed: float
    target: int


def is_over(known: CertainMotion, now: float, cycle: float) -> bool:
    """Whether the motion has ended at `now` [s], counted from the queue's start."""
    return known.rests and known.horizon - now <= _SHARE * cycle


def certain_steps(
    queue: Queue, known: CertainMotion, base: float, last: Step, cycle: float, frame: Pose
) -> list[Step]:
    """The next steps, a block at most, after the `last` one, that no later target can change.

    The queue's times count from `base` [s]. Raises OlpError S009 where the arm cannot follow.
    """
    now = last.time
    times = _instants(known, now - base, cycle)
    if known.timing is None or not len(times):
        return []
    if not len(known.timing.plan.moves):  # it waits where it stands
        axes, tools, speeds = (
            np.tile(queue.origin, (len(times), 1)),
            [last.tool] * len(times),
            [0.0] * len(times),
        )
    else:
        position, rotation, axes = _followed(queue, known, known.timing, times)
        inverse = frame.inverse()
        tools = [
            Pose(p, r)
            for p, r in zip(*compose(inverse.position, inverse.rotation, position, rotation), strict=True)
        ]
        speeds = tool_speed(known.timing, times).tolist()
    numbers = [queue.items[i].number for i in _under_way(known, times, cycle)]
    clock = [now, *(times + base).tolist()]
    found = [
        Step(clock[i + 1], clock[i + 1] - clock[i], State.MOVING, axes[i], tools[i], speeds[i], numbers[i])
        for i in range(len(times))
    ]
    _tell_what_follows(queue, known, found, float(times[-1]), cycle)
    return found


def _instants(known: CertainMotion, now: float, cycle: float) -> Floats:
    """The times [s] of the next certain steps; the last step of a motion ends with it, however short it is."""
    left = (known.horizon - now) / cycle
    count = int(min(np.floor(left + _SHARE), _BLOCK))
    times: Floats = now + cycle * np.arange(1, count + 1, dtype=np.float64)
    if known.rests and count < _BLOCK:
        if left - count > _SHARE:
            return np.append(times, known.horizon)
        times[-1:] = known.horizon
    return times


def _followed(
    queue: Queue, known: CertainMotion, timing: Timing, times: Floats
) -> tuple[Floats, Floats, Floats]:
    """Position (n, 3), rotation (n, 3, 3) and axes (n, k) at `times`."""
    lead = _lead_in(timing, float(times[0]))
    found = states(timing, np.concatenate((lead, times)))
    position, rotation, axes = (part[len(lead) :] for part in found)
    axes = axes[:, : len(queue.origin)]
    lost = np.isnan(axes).any(axis=1)
    if lost.any():
        number = queue.items[int(np.searchsorted(known.ends, times[lost.argmax()]))].number
        says = f"the arm cannot follow the path to target {number}"
        raise OlpError(error("S009", says, help="it leaves the arm's reach"))
    return position, rotation, axes


def _lead_in(timing: Timing, first: float) -> Floats:
    """Instants from the start of the move that `first` lies in up to it."""
    plan = timing.plan
    starts = timing.rows.start[plan.row[plan.kind == StepKind.MOVE]]
    index = int(np.searchsorted(starts, first, side="right")) - 1
    if index < 0:
        return np.zeros(0)
    lead: Floats = np.linspace(max(float(starts[index]), 0.0), first, _LEAD_IN, endpoint=False)
    return lead


def _under_way(known: CertainMotion, times: Floats, cycle: float) -> list[int]:
    index = np.searchsorted(known.ends, times - _SHARE * cycle)
    found: list[int] = np.minimum(index, len(known.ends) - 1).tolist()
    return found


def _tell_what_follows(
    queue: Queue, known: CertainMotion, found: list[Step], last: float, cycle: float
) -> None:
    """Set the state of the last step; at a stop set its pose exactly to the target."""
    end = found[-1]
    if is_over(known, last, cycle):
        goal = queue.last_joints
        if np.abs(end.joints - goal).max() > _ARRIVED:
            says = f"the arm reaches target {end.target} in another configuration than foreseen"
            raise OlpError(
                error("S009", says, help="the path passes a singularity: go there with a joint move")
            )
        state = State.DONE if queue.closed else State.NEEDS_TARGET
        found[-1] = replace(end, state=state, joints=goal.copy(), speed=0.0)
    elif not known.rests and known.horizon - last < cycle * (1 - _SHARE):
        found[-1] = replace(end, state=State.NEEDS_TARGET)


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
    """A wait of `seconds` [s] at the current position."""

    number: int
    seconds: float


Item = Go | Stay


class CertainMotion(NamedTuple):
    """Motion that no later target can change. Times [s] count from the start of the queue."""

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
        """Joints (k,) of the last target."""
        for item in reversed(self.items):
            if isinstance(item, Go):
                return item.goals[-1]
        return self.origin

    def drop(self, count: int) -> None:
        """Remove the first `count` items; the arm must have stopped after them."""
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
        """The plan of the items, and the number of its steps up to the end of each item."""
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
    """Whether the arm stops after an item whatever follows."""
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


DEFAULT_CYCLE: Final = 0.004  # [s] step of Yaskawa's server for realistic robot simulation
MOST_TARGETS: Final = 20_000  # in waiting: a motion without stops is timed as a whole
_SHORTEST_CYCLE = 1e-5  # [s]


class Controller:
    """One arm, stepped. Raises OlpError S001 for an arm without geometry, S002 for an invalid cycle."""

    def __init__(
        self,
        robot: Robot,
        *,
        model: str = "constant",
        cycle: float = DEFAULT_CYCLE,
        acceleration: float | None = None,
        settings: Mapping[str, str | float] | None = None,
    ) -> None:
        """`cycle` [s]; `acceleration` [m/s²] of linear moves, None: the robot's; `settings` as in [motion] of
        olp.toml. The arm stands with every axis at zero, or at the soft limit that is nearest to it."""
        if robot.geometry is None:
            says = f"the geometry of {robot.name} is not known: its motion cannot be followed"
            raise OlpError(error("S001", says, help="add [links] to the robot file"))
        if not _SHORTEST_CYCLE <= cycle < float("inf"):
            says = f"an interpolation cycle of {cycle:g} s is not possible"
            raise OlpError(error("S002", says, help=f"{_SHORTEST_CYCLE:g} s or more"))
        load_model(model)
        effects_of(settings or {})
        self.robot, self.cycle = robot, cycle
        self._options = (model, acceleration, dict(settings or {}))
        self._frame, self._tool, self._tools = Pose.identity(), 0, {0: Tool(Pose.identity())}
        self._last: Step
        self._stand(np.clip(np.zeros(len(robot.axes)), robot.lower, robot.upper))

    def set_tool(self, tool: Pose) -> None:
        """Set the tool centre point on the flange for the following targets."""
        self._tool = len(self._tools)
        self._tools[self._tool] = Tool(tool)
        self._tell_pose()

    def set_frame(self, frame: Pose) -> None:
        """Set the frame, in the robot's base, of the following targets and of the reported poses."""
        self._frame = frame
        self._ready.clear()
        self._tell_pose()

    def set_position(self, joints: ArrayLike) -> None:
        """Put the arm at `joints` (k,) [rad or m], at time 0. Raises OlpError S003, S005 outside soft limits, S007
        during a motion.
        """
        values = np.asarray(joints, dtype=np.float64)
        if values.shape != (len(self.robot.axes),) or not np.isfinite(values).all():
            raise OlpError(error("S003", f"a position has {len(self.robot.axes)} finite numbers"))
        if self._queue.items:
            raise OlpError(error("S007", "the arm moves: it cannot be put elsewhere", help="step to the end"))
        inside = within_limits(self.robot, values[None])[0]
        if not inside.all():
            axis = self.robot.axes[int(np.argmin(inside))].name
            raise OlpError(error("S005", f"axis {axis} would stand beyond its soft limits"))
        self._stand(values.copy())

    def target(self, target: Target) -> int:
        """Queues the next target and returns its number. Raises OlpError S003 to S006, S008; nothing is queued
        then."""
        problems = target.problems(len(self.robot.axes))
        if problems:
            raise OlpError(*problems)
        start, tool = self._queue.last_joints, self._tools[self._tool].pose
        goals = tuple(reach(self.robot, start, target, tool, self._frame))
        return self._add(Go(self._number + 1, target, goals, self._tool))

    def wait(self, seconds: float) -> int:
        """Queues standing still for `seconds` [s] and returns its number. Raises OlpError S003, S008."""
        if not 0 < seconds < float("inf"):
            raise OlpError(error("S003", f"a wait has to be above zero, not {seconds:g} s"))
        return self._add(Stay(self._number + 1, seconds))

    def end(self) -> None:
        """Declare the end of the motion: the last target becomes a stop. A later target begins another motion."""
        if not self._queue.closed:
            self._forget()
            self._queue.closed = True

    def step(self) -> Step:
        """The next interpolation cycle. Raises OlpError T1xx or S009 where the motion cannot be timed or followed."""
        if not self._ready:
            self._compute()
        if not self._ready:
            speed = self._last.speed if self._queue.items else 0.0
            self._last = replace(self._last, elapsed=0.0, state=self._waiting(), speed=speed)
            return self._last
        self._last = self._ready.popleft()
        known = self._known
        if known is not None and is_over(known, self._last.time - self._base, self.cycle):
            self._rest()
        return self._last

    def run(self) -> Iterator[Step]:
        """Steps until another target is needed or everything is done."""
        state = State.MOVING
        while state is State.MOVING:
            step = self.step()
            state = step.state
            if step.elapsed:
                yield step

    def _stand(self, joints: Floats) -> None:
        self._queue = Queue(self.robot, *self._options, joints, self._tools)
        self._base, self._number = 0.0, 0  # [s] the queue's times count from the base
        self._known: CertainMotion | None = None
        self._ready: deque[Step] = deque()
        self._last = Step(0.0, 0.0, State.IDLE, joints.copy(), Pose.identity(), 0.0, 0)
        self._tell_pose()

    def _tell_pose(self) -> None:
        """The pose of an arm that stands, with another tool or in another frame."""
        if self._queue.items:
            return
        flange = forward(self.robot, self._last.joints[None])
        position, rotation = with_tool(*flange, self._tools[self._tool].pose)
        self._last = replace(self._last, tool=self._frame.inverse() @ Pose(position[0], rotation[0]))

    def _add(self, item: Item) -> int:
        if len(self._queue.items) >= MOST_TARGETS:
            says = f"{MOST_TARGETS} targets are waiting already"
            raise OlpError(error("S008", says, help="step before giving more"))
        self._forget()
        self._queue.closed = False
        self._queue.items.append(item)
        self._number = item.number
        return item.number

    def _forget(self) -> None:
        """What was computed ahead may change; what lies behind the last stop is never needed again."""
        known, self._known = self._known, None
        self._ready.clear()
        if known is None:
            return
        past = int(np.searchsorted(known.ends, self._last.time - self._base, side="right"))
        while past and not stops(self._queue.items[past - 1]):
            past -= 1
        if past:
            self._base += float(known.ends[past - 1])
            self._queue.drop(past)

    def _rest(self) -> None:
        """Everything in waiting is done: the next motion begins here and now."""
        self._queue.drop(len(self._queue.items))
        self._base, self._known = self._last.time, None

    def _waiting(self) -> State:
        if self._queue.items:
            return State.NEEDS_TARGET
        if not self._number:
            return State.IDLE
        return State.DONE if self._queue.closed else State.NEEDS_TARGET

    def _compute(self) -> None:
        """Fills `_ready` with the steps that are certain, a block at most."""
        if not self._queue.items:
            return
        if self._known is None:
            self._known = self._queue.known()
        known, now = self._known, self._last.time
        if is_over(known, now - self._base, self.cycle):
            self._rest()  # targets where the arm already stood
            return
        self._ready.extend(certain_steps(self._queue, known, self._base, self._last, self.cycle, self._frame))
