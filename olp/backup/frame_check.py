"""A backup proves its own arm: user frames hold both the pulses they were taught at and the frame that came out.

A frame is right when the three points, computed from the pulses with the arm's model and the tool, give the stored
frame again. On a published AR2010 (YRC1000, three frames) the largest difference is 0.001 mm and 0.00006 deg.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from olp.backup.parameters import GroupParameters
from olp.backup.tool_cnd import ToolData
from olp.backup.uframe_cnd import UserFrame
from olp.diagnostic import OlpError
from olp.units import deg, mm

if TYPE_CHECKING:
    from olp.geometry import Array
    from olp.robots.model import Geometry

_POINTS: Final = ("RORG", "RXX", "RXY")
# The file rounds to 0.001 mm and pulses to 0.001 deg, which turns a frame of 100 mm by less than this.
CLOSE: Final = 0.1 * mm  # [m]
CLOSE_ANGLE: Final = 0.05 * deg  # [rad]


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


def frame_agreement(
    parameters: GroupParameters, frames: dict[int, UserFrame], tools: dict[int, ToolData]
) -> FrameAgreement | None:
    """How well the arm's model explains its user frames; None when no frame was taught with this arm alone.

    `parameters` must be those of a six-axis arm with links.
    """
    taught = [
        (frame, tools[frame.tool].position)
        for _, frame in sorted(frames.items())
        if frame.groups == (parameters.group,) and frame.tool in tools
        if all(len(frame.taught.get(point, ())) >= 6 for point in _POINTS)
    ]
    agreement = _compared(parameters, taught)
    if agreement is None or not agreement.close:
        return agreement
    turned = (_compared(parameters, taught, axis) for axis in range(6))
    unseen = tuple(axis for axis, other in enumerate(turned) if other is not None and other.close)
    return agreement._replace(unseen=unseen)


def _compared(
    parameters: GroupParameters,
    taught: list[tuple[UserFrame, tuple[float, float, float]]],
    turned: int | None = None,
) -> FrameAgreement | None:
    """The differences between computed and stored frames; `turned` is an axis taken in the other sense."""
    from olp.geometry import frame_from_points, rotation_angle, rotation_from_angles
    from olp.robots.model import Links
    from olp.robots.reader import wrist_geometry

    lengths = parameters.links
    links = Links(lengths["a1"], lengths["a2"], lengths["a3"], lengths["d4"], lengths["d6"])
    geometry = wrist_geometry(links, None)
    used: list[int] = []
    distance = angle = 0.0
    for frame, tip in taught:
        rows = (frame.taught[point][:6] for point in _POINTS)
        pulses = [tuple(-p if axis == turned else p for axis, p in enumerate(row)) for row in rows]
        try:
            found = frame_from_points(*(_tool_point(geometry, parameters, row, tip) for row in pulses))
        except OlpError:
            continue  # three points on one line tell nothing about the arm
        used.append(frame.number)
        difference = max(abs(a - b) for a, b in zip(found.position, frame.position, strict=True))
        distance = max(distance, float(difference))
        angle = max(angle, float(rotation_angle(found.rotation, rotation_from_angles(frame.angles))))
    return FrameAgreement(tuple(used), distance, angle) if used else None


def _tool_point(
    geometry: Geometry, parameters: GroupParameters, pulses: tuple[int, ...], tip: tuple[float, float, float]
) -> Array:
    """(3,) [m] in the base frame."""
    import numpy as np

    from olp.geometry import Pose

    angles = parameters.radians(pulses)
    place = Pose.identity()
    for joint in geometry.joints:
        turned = _about(joint.direction, angles[joint.axis])
        place = place @ Pose(np.array(joint.offset), np.eye(3)) @ Pose(np.zeros(3), turned)
    flange = Pose(np.array(geometry.flange_offset), np.array(geometry.flange_rotation))
    return (place @ flange).apply(tip)


def _about(direction: tuple[float, float, float], angle: float) -> Array:
    """(3, 3): the turn by `angle` [rad] about a unit vector (O. Rodrigues, 1840)."""
    import numpy as np

    x, y, z = direction
    cross = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    turned: Array = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    return turned
