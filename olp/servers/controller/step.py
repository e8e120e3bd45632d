"""Steps of the interpolation cycle, cut out of a motion that is certain."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.geometry import Pose, compose
from olp.runtime.plan import StepKind
from olp.servers.controller.queue import CertainMotion, Queue
from olp.timing.timing import Timing
from olp.timing.track import states, tool_speed

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
    """Where the arm is after one interpolation cycle.

    `time` [s] since the position was set; `elapsed` [s] since the step before: one cycle, less for the last step of
    a motion, 0 when no step could be made. `joints` (k,) [rad or m]; `tool`: its pose in the controller's frame;
    `speed` [m/s] of the tool's point; `target`: the number of the target (or wait) under way, counted from 1.
    `state` after the step.
    """

    time: float
    elapsed: float
    state: State
    joints: Floats
    tool: Pose
    speed: float
    target: int


def is_over(known: CertainMotion, now: float, cycle: float) -> bool:
    """Whether the motion has come to its end at `now` [s], counted from the queue's start."""
    return known.rests and known.horizon - now <= _SHARE * cycle


def certain_steps(
    queue: Queue, known: CertainMotion, base: float, last: Step, cycle: float, frame: Pose
) -> list[Step]:
    """The next steps that nothing can change any more, a block at most, behind the `last` one.

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
    """The last step says what it needs; at a stop it stands exactly where its target is."""
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
