"""Values that only the controller knows: where the arm is, what a call returned."""

from __future__ import annotations

from olp.ir.expressions import FrameRef, Store, SystemValue
from olp.runtime.columns import NOWHERE
from olp.runtime.memory import PositionValue, SystemPosition, Value
from olp.runtime.poses import as_pose, as_pulses, here
from olp.runtime.state import Machine, role


def read_system_value(m: Machine, value: SystemValue) -> Value:
    """The value; one that nobody can know is taken as 0, which is reported."""
    if value.name == "returned":
        if m.returned is None:
            m.assume("nothing was returned before: the returned value is taken as 0")
            return 0
        return m.returned
    if value.name == "position-pulse":
        return _position(m, pulses=True)
    if value.name == "position-pose":
        return _position(m, pulses=False)
    if value.name == "timed-out":
        return m.timed_out
    if value.name in ("current-pose", "current-joints"):
        from olp.runtime.places import current

        return current(m, joints=value.name == "current-joints")
    m.assume(f"system value {value.name} {value.index} is taken as 0")
    return 0


def _position(m: Machine, pulses: bool) -> SystemPosition:
    arm = role(m, 0, Store.ROBOT)
    value = here(m, arm)
    robot = as_pulses(m, arm, value) if pulses else as_pose(m, arm, value, FrameRef("base"))
    parts: list[tuple[Store, PositionValue]] = [(Store.ROBOT, robot)]
    for store in (Store.BASE, Store.STATION):
        for (_, known), mechanism in m.frame.job.roles.items():
            if known is store and m.recorder.at[mechanism] != NOWHERE:
                parts.append((store, here(m, mechanism)))
                break
    return SystemPosition(tuple(parts))
