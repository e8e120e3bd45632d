"""Resolves written positions: pulses, joints or a pose in some frame become axes and a tool pose in the base.

A cell is the environment of a program: the robot of each mechanism, its tools and its user frames. Whatever is
missing is assumed in one documented way and reported once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm
from olp.ir.points import PointKind, PointState
from olp.robots.geometry import Pose, compose, invert, quaternion_from_rotation, rotation_from_angles
from olp.robots.kinematics.configuration import Tool

if TYPE_CHECKING:
    from olp.robots.model import Robot

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Mechanism:
    """One control group: its name in the program (RB1, BS1, ST1) and its machine, if known."""

    name: str
    robot: Robot | None = None

    @property
    def is_robot(self) -> bool:
        return not self.name.startswith(("BS", "ST", "B", "S"))


class Resolved(NamedTuple):
    """`position` (n, 3) [m], `rotation` (n, 3, 3) of the tool in the base, `axes` (n, k); nan where unknown."""

    position: Floats
    rotation: Floats
    axes: Floats


EXTERNAL_AXES = "external axes are not in this plan: they are assumed never to be the slowest"
# [m, rad or pulses] Nothing that a cell holds is farther; powers of larger numbers leave what floating point can hold.
_FARTHEST = 1e12
ASSUMED_PULSES = 1000.0  # per mm of a track and per deg of a station that no file describes
ROBOT_GAP = "robot "  # begins the key of a gap that a robot for the mechanism would fill


class Gap(NamedTuple):
    """Missing data of the cell, and the assumption that replaced them. `key` identifies repeats."""

    key: str
    says: str
    unusable: bool = False  # nothing could be assumed: the position is unknown


@dataclass(slots=True)
class Cell:
    """Mechanisms, tools and frames. `gaps` collects the missing data, once each.

    `frame_files`: the controller's file that would define the "tool" or the "user" frames.
    """

    mechanisms: Sequence[Mechanism]
    tools: Mapping[int, Tool] = field(default_factory=dict)
    user_frames: dict[int, Pose] = field(default_factory=dict)
    gaps: dict[str, Gap] = field(default_factory=dict)
    frame_files: Mapping[str, str] = field(default_factory=dict)
    made_up: Callable[[str, int], Pose | None] | None = None  # of a tool ("tool") or frame that is not known

    def robot(self, mechanism: int) -> Robot | None:
        return self.mechanisms[mechanism].robot

    def resolve(
        self, mechanism: int, state: PointState, values: Floats, seed: Floats | None = None
    ) -> Resolved:
        """Resolves positions written as `values` (n, w) under one state.

        Pulses and joints give axes and, for an arm whose geometry is known, the pose; poses give the tool pose and,
        for such an arm, the axes of the branch that the configuration names (the nearest to `seed` (k,) without
        one). Rows with absurd numbers are unknown.
        """
        absurd = np.flatnonzero((np.abs(np.nan_to_num(values)) > _FARTHEST).any(axis=1))
        if not absurd.size:
            return self._resolve(mechanism, state, values, seed)
        self._gap("absurd", f"positions with numbers beyond {_FARTHEST:g} are not known", True)
        known = np.array(values)
        known[absurd] = 0.0
        resolved = self._resolve(mechanism, state, known, seed)
        for column in resolved:
            column[absurd] = np.nan
        return resolved

    def _resolve(self, mechanism: int, state: PointState, values: Floats, seed: Floats | None) -> Resolved:
        if not self.mechanisms[mechanism].is_robot:
            return self._resolve_external(mechanism, state, values)
        if state.own:
            values = self._without_external(state, values)
        if state.kind is PointKind.POSE:
            return self._resolve_pose(mechanism, state, values, seed)
        return self._resolve_axes(mechanism, state, values)

    def _without_external(self, state: PointState, values: Floats) -> Floats:
        """The values without those of external axes; reports these if they are not zero."""
        if np.nan_to_num(values[:, state.own :]).any():
            self._gap("external axes", EXTERNAL_AXES)
        return values[:, : state.own]

    def tool_pose(self, number: int) -> Pose:
        """The tool's centre point on the flange; the flange itself when the tool is not known (reported)."""
        tool = self.tools.get(number)
        if tool is None:
            made = None if self.made_up is None else self.made_up("tool", number)
            if made is not None:
                return made
            if self.tools or number:
                self._gap(
                    f"tool {number}",
                    f"tool {number} is not known ({self._absent('tool', 'tools')}): the flange is used",
                )
            return Pose.identity()
        return self._near(f"tool {number}", tool.pose)

    def user_frame(self, number: int) -> Pose:
        """A user frame in the base; the base itself when the frame is not known (reported)."""
        frame = self.user_frames.get(number)
        if frame is None:
            made = None if self.made_up is None else self.made_up("frame", number)
            if made is not None:
                return made
            self._gap(
                f"user {number}",
                f"user frame {number} is not known ({self._absent('user', 'frames')}): taken as the base frame",
            )
            return Pose.identity()
        return self._near(f"user frame {number}", frame)

    def _absent(self, kind: str, table: str) -> str:
        """Reports that a tool or frame is unknown, and which file would define it."""
        beside = f"no {self.frame_files[kind]} beside it, " if kind in self.frame_files else ""
        return f"{beside}no [{table}] in olp.toml"

    def _near(self, name: str, pose: Pose) -> Pose:
        """The pose of a tool or frame; the identity if its distance is absurd (reported)."""
        if (np.abs(pose.position) <= _FARTHEST).all():
            return pose
        self._gap(name, f"{name} is farther than {_FARTHEST:g} m: it is left out")
        return Pose.identity()

    def _resolve_external(self, mechanism: int, state: PointState, values: Floats) -> Resolved:
        robot = self.robot(mechanism)
        name = self.mechanisms[mechanism].name
        count = len(values)
        axes = values
        if state.kind is PointKind.PULSE:
            if robot is None or not robot.knows_pulses:
                self._gap(
                    f"axes {name}",
                    f"the axes of {name} are not known: its part of a move is assumed never to be the slowest",
                )
                axes = np.full_like(values, np.nan)
            else:
                from olp.robots.kinematics.configuration import pulses_to_joints

                axes = pulses_to_joints(robot, _width(values, len(robot.axes)))
        return Resolved(np.full((count, 3), np.nan), np.full((count, 3, 3), np.nan), axes)

    def units(self, mechanism: int, count: int) -> tuple[str, ...]:
        """Of the axes of a track or a station: mm where one slides, deg where it turns."""
        robot = self.robot(mechanism)
        if robot is None:
            return ("mm" if self.mechanisms[mechanism].name.startswith("B") else "deg",) * count
        return tuple("mm" if axis.linear else "deg" for axis in robot.axes[:count])

    def beside(self, mechanism: int, state: PointState, values: Sequence[float]) -> tuple[float, ...]:
        """[mm or deg] where a track or a station stands, as positions hold it that have axes beside the arm's.

        Pulses without a machine that tells their number: `ASSUMED_PULSES` in each.
        """
        row, robot = [v for v in values if v == v], self.robot(mechanism)
        scales = [mm if unit == "mm" else deg for unit in self.units(mechanism, len(row))]
        if state.kind is PointKind.PULSE:
            if robot is None or not robot.knows_pulses:
                return tuple(v / ASSUMED_PULSES for v in row)
            row = [v / ratio for v, ratio in zip(row, robot.pulses_per_unit.tolist(), strict=False)]
        return tuple(v / scale for v, scale in zip(row, scales, strict=False))

    def _resolve_axes(self, mechanism: int, state: PointState, values: Floats) -> Resolved:
        robot = self.robot(mechanism)
        name = self.mechanisms[mechanism].name
        count = len(values)
        unknown = Resolved(
            np.full((count, 3), np.nan), np.full((count, 3, 3), np.nan), np.full_like(values, np.nan)
        )
        if robot is None:
            whose = f" of {name}" if len(self.mechanisms) > 1 else ""
            unit = "pulses" if state.kind is PointKind.PULSE else "joint angles"
            says = f"the points{whose} are written in {unit}, and this robot is not known"
            self._gap(f"{ROBOT_GAP}{name}", says, True)
            return unknown
        from olp.robots.kinematics.configuration import forward, pulses_to_joints

        if np.nan_to_num(values[:, len(robot.axes) :]).any():
            says = (
                f"the points have more axes than the {len(robot.axes)} of {robot.name}: it is another robot"
            )
            self._gap(f"axes of {robot.name}", says, True)
            return unknown
        axes = _width(values, len(robot.axes))
        if state.kind is PointKind.PULSE:
            if not robot.knows_pulses:
                self._gap("pulses", f"the pulses per degree of {robot.name} are not known", True)
                return unknown
            axes = pulses_to_joints(robot, axes)
        else:
            from olp.robots.kinematics.configuration import joints_of_readings

            axes = joints_of_readings(robot, axes)
        if robot.geometry is None:
            self._gap(
                "geometry",
                f"the geometry of {robot.name} is not known: its linear moves cannot be timed",
                True,
            )
            return unknown._replace(axes=axes)
        if not robot.pose_verified:
            self._gap(
                f"unverified {robot.name}",
                f"poses of {robot.name} computed from its axes were never compared with a real controller",
            )
        tool = self.tool_pose(state.tool)
        position, rotation = compose(*forward(robot, axes), tool.position, tool.rotation)
        return Resolved(position, rotation, axes)

    def _resolve_pose(
        self, mechanism: int, state: PointState, values: Floats, seed: Floats | None
    ) -> Resolved:
        position, rotation = self._in_base(state, values)
        if np.isnan(position).all():
            return Resolved(position, rotation, np.full((len(values), 6), np.nan))
        return Resolved(position, rotation, self._axes_of(mechanism, state, position, rotation, seed))

    def _in_base(self, state: PointState, values: Floats) -> tuple[Floats, Floats]:
        """Positions (n, 3) and rotations (n, 3, 3) in the base of written poses; nan in frames that move."""
        if values.shape[1] < 6:  # cut off: not known at all, rather than without its turn
            values = np.full((len(values), 6), np.nan)
        position, rotation = values[:, :3], rotation_from_angles(values[:, 3:6])
        if state.frame == "user":
            frame = self.user_frame(state.user or 0)
            return compose(frame.position, frame.rotation, position, rotation)
        if state.frame in ("tool", "master-tool"):
            self._gap(state.frame, f"points in the {state.frame} frame depend on another position", True)
            return np.full_like(position, np.nan), np.full_like(rotation, np.nan)
        return position, rotation

    def _axes_of(
        self, mechanism: int, state: PointState, position: Floats, rotation: Floats, seed: Floats | None
    ) -> Floats:
        robot = self.robot(mechanism)
        if robot is None or robot.geometry is None:
            return np.full((len(position), 6), np.nan)
        from olp.robots.kinematics.configuration import turned_into
        from olp.robots.kinematics.inverse import inverse

        tool = self.tool_pose(state.tool).inverse()
        flange = compose(position, rotation, tool.position, tool.rotation)
        if seed is not None and (not state.configuration or robot.geometry.links is None):
            from olp.robots.kinematics.inverse import nearest

            return nearest(robot, *flange, seed)
        configuration = np.array((state.configuration or (0, 0, 0, 0, 0, 0))[:6], dtype=np.int64)
        axes, reachable = inverse(robot, *flange, configuration)
        axes[~reachable] = np.nan
        return turned_into(robot, axes, state.sectors) if state.sectors else axes

    def pose(self, mechanism: int, state: PointState, values: Sequence[float]) -> Pose | None:
        """One position as the tool's pose in the base; None if unknown."""
        rows = np.asarray([values], dtype=np.float64)
        if state.kind is PointKind.POSE and self.mechanisms[mechanism].is_robot:
            position, rotation = self._in_base(
                state, rows
            )  # the axes, which cost an inverse, are not asked for
        else:
            position, rotation, _ = self.resolve(mechanism, state, rows)
        return None if np.isnan(position).any() else Pose(position[0], rotation[0])

    def _gap(self, key: str, says: str, unusable: bool = False) -> None:
        self.gaps.setdefault(key, Gap(key, says, unusable))


def quaternions(resolved: Resolved) -> Floats:
    """Quaternions (n, 4) of the tool, nan where the rotation is unknown."""
    known = ~np.isnan(resolved.rotation[:, 0, 0])
    result = np.full((len(known), 4), np.nan)
    if known.any():
        result[known] = quaternion_from_rotation(resolved.rotation[known])
    return result


def in_frame(pose: Pose, frame: Pose) -> Pose:
    """A base-frame pose relative to `frame`."""
    return Pose(*compose(*invert(frame.position, frame.rotation), pose.position, pose.rotation))


def _width(values: Floats, width: int) -> Floats:
    """Values (n, width): cut, or padded with zeros where a row is short; empty fields count as zero."""
    result = np.zeros((len(values), width))
    shared = min(width, values.shape[1])
    result[:, :shared] = np.nan_to_num(values[:, :shared])
    return result
