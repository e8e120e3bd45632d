"""A controller that a simulator steps through its interpolation cycle.

The idea is that of realistic robot simulation (Apostolovic's thesis, 1.4.1): the simulator names robot, tool, frame and
position, gives the next target, and asks for the next step until it is told that another target is needed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.controller_effects import effects_of
from olp.robots.coordinate_systems import Tool
from olp.robots.geometry import Pose
from olp.robots.kinematics import forward, with_tool, within_limits
from olp.servers.controller.queue import CertainMotion, Go, Item, Queue, Stay, stops
from olp.servers.controller.step import State, Step, certain_steps, is_over
from olp.servers.controller.target import Target, reach
from olp.timing.motion import load_model

if TYPE_CHECKING:
    from olp.robots.robot import Robot

Floats = NDArray[np.float64]
DEFAULT_CYCLE: Final = 0.004  # [s] step of Yaskawa's server for realistic robot simulation
MOST_TARGETS: Final = 20_000  # in waiting: a motion without stops is timed as a whole
_SHORTEST_CYCLE = 1e-5  # [s]


class Controller:
    """One arm, stepped. Raises OlpError S001 for an arm without geometry, S002 for a cycle that is none."""

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
        """The tool's centre point on the flange, for the targets that follow."""
        self._tool = len(self._tools)
        self._tools[self._tool] = Tool(tool)
        self._tell_pose()

    def set_frame(self, frame: Pose) -> None:
        """The frame in the robot's base in which the targets that follow are given and poses are told."""
        self._frame = frame
        self._ready.clear()
        self._tell_pose()

    def set_position(self, joints: ArrayLike) -> None:
        """Puts the arm (k,) [rad or m] somewhere, at time 0. Raises OlpError S003, S005 outside soft limits, S007
        while it moves."""
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
        """Says that nothing follows: the last target becomes a stop. A later target begins another motion."""
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
