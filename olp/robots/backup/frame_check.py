"""A backup proves its own arm: user frames hold both the pulses they were taught at and the frame that came out.

A frame is right when the three points, computed from the pulses with the arm's model and the tool, give the
stored frame again. On a published AR2010 (YRC1000, three frames) the largest difference is 0.0005 mm and
0.00006 deg.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from olp.core.diagnostic import OlpError
from olp.core.units import deg, mm
from olp.robots.backup.parameters import GroupParameters
from olp.robots.backup.tool_cnd import ToolData, Vector
from olp.robots.backup.uframe_cnd import UserFrame

if TYPE_CHECKING:
    from olp.robots.model import Robot

_POINTS: Final = ("RORG", "RXX", "RXY")
# The file rounds to 0.001 mm and pulses to 0.001 deg, which turns a frame of 100 mm by less than this.
CLOSE: Final = 0.1 * mm  # [m]
CLOSE_ANGLE: Final = 0.05 * deg  # [rad]

Taught = list[tuple[UserFrame, Vector]]  # frames with the tip [m] of the tool they were taught with


class Stance(NamedTuple):
    """How an arm stands at zero pulses: the standard angle of an axis is sign x reading + zero [rad]."""

    signs: tuple[int, ...] = (1,) * 6
    zeros: tuple[float, ...] = (0.0,) * 6
    source: str = ""


# Those of Yaskawa's six-axis arms: upright; with the flange down at B = 0; shelf-mounted.
STANCES: Final = (
    Stance(),
    Stance(zeros=(0.0, 0.0, 0.0, 0.0, -90.0 * deg, 0.0)),
    Stance(zeros=(0.0, 90.0 * deg, 0.0, 0.0, 0.0, 0.0)),
)


class FrameAgreement(NamedTuple):
    """The largest differences over the frames that could be computed."""

    frames: tuple[int, ...]  # their numbers
    distance: float  # [m]
    angle: float  # [rad]
    unseen: tuple[int, ...] = ()  # axes (from 0) whose sense could be turned over without being noticed

    @property
    def close(self) -> bool:
        return self.distance <= CLOSE and self.angle <= CLOSE_ANGLE

    @property
    def proves(self) -> bool:
        """Whether poses may be trusted: the frames agree, and would not if any axis turned the other way."""
        return self.close and not self.unseen


def find_stance(
    parameters: GroupParameters, frames: dict[int, UserFrame], tools: dict[int, ToolData], name: str = ""
) -> tuple[Stance, FrameAgreement | None]:
    """How the arm stands, and how well its user frames agree; None when none was taught with this arm alone.

    The library's robot `name`, when there is one, gives the stance unless the frames prove another.
    `parameters` must be those of a six-axis arm with links.
    """
    taught = [
        (frame, tools[frame.tool].position)
        for _, frame in sorted(frames.items())
        if frame.groups == (parameters.group,) and frame.tool in tools
        if all(len(frame.taught.get(point, ())) >= 6 for point in _POINTS)
    ]
    known = _library_stance(name)
    stances = STANCES if known is None else (known, *STANCES)
    first: FrameAgreement | None = None
    for stance in stances:
        agreement = _agreement(parameters, taught, stance)
        if agreement is not None and agreement.proves:
            return stance._replace(source=stance.source or "confirmed by the user frames"), agreement
        first = first or agreement
    return stances[0], first


def _library_stance(name: str) -> Stance | None:
    from olp.robots.robot import load_robot, robot_names

    if name not in robot_names():
        return None
    geometry = load_robot(name).geometry
    if geometry is None or geometry.links is None:
        return None
    return Stance(geometry.links.signs, geometry.links.zeros, f"stance at zero as in the library's {name}")


def _agreement(parameters: GroupParameters, taught: Taught, stance: Stance) -> FrameAgreement | None:
    agreement = _compared(parameters, taught, stance)
    if agreement is None or not agreement.close:
        return agreement
    turned = (_compared(parameters, taught, stance, axis) for axis in range(6))
    unseen = tuple(axis for axis, other in enumerate(turned) if other is not None and other.close)
    return agreement._replace(unseen=unseen)


def _compared(
    parameters: GroupParameters, taught: Taught, stance: Stance, turned: int | None = None
) -> FrameAgreement | None:
    """The differences between computed and stored frames; `turned` is an axis taken in the other sense."""
    import numpy as np

    from olp.robots.geometry import frame_from_points, rotation_angle, rotation_from_angles
    from olp.robots.kinematics.chain import forward

    robot = _robot(parameters, stance)
    used: list[int] = []
    distance = angle = 0.0
    for frame, tip in taught:
        joints = np.array([parameters.radians(frame.taught[point][:6]) for point in _POINTS])
        if turned is not None:
            joints[:, turned] *= -1.0
        positions, rotations = forward(robot, joints)
        try:
            found = frame_from_points(*(positions + rotations @ np.array(tip)))
        except OlpError:
            continue  # three points on one line tell nothing about the arm
        used.append(frame.number)
        distance = max(distance, float(np.max(np.abs(found.position - np.array(frame.position)))))
        angle = max(angle, float(rotation_angle(found.rotation, rotation_from_angles(frame.angles))))
    return FrameAgreement(tuple(used), distance, angle) if used else None


def _robot(parameters: GroupParameters, stance: Stance) -> Robot:
    from olp.robots.model import Axis, Links, Robot
    from olp.robots.reader import wrist_geometry

    a1, a2, a3, d4, d6 = (parameters.links[key] for key in ("a1", "a2", "a3", "d4", "d6"))
    links = Links(a1, a2, a3, d4, d6, stance.signs, stance.zeros)
    ranges = zip(
        parameters.radians(parameters.lower),
        parameters.radians(parameters.upper),
        parameters.radians(parameters.speeds),
        strict=True,
    )
    axes = tuple(Axis(str(index), *numbers) for index, numbers in enumerate(ranges))
    return Robot("", "", "", axes, geometry=wrist_geometry(links, None))
