"""Forward kinematics and the geometric Jacobian of any serial chain, over whole paths at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.geometry import Pose, compose
from olp.robots.model import Geometry, Robot, Vector

Array = NDArray[np.float64]

# Poses per block: all intermediate arrays of a block together stay in the second-level cache.
BLOCK = 2048


@dataclass(frozen=True, slots=True)
class Tool:
    """A tool on the flange. `pose`: the tool centre point; `mass` [kg], `centre` of gravity [m] on the flange."""

    pose: Pose
    name: str = ""
    mass: float | None = None
    centre: tuple[float, float, float] | None = None
    inertia: tuple[float, float, float] | None = None  # [kg m²]


class Sweep(NamedTuple):
    """One pass from base to flange over m poses; all columns are (3, m) in the base frame."""

    axes: list[Array]  # direction of each joint, in chain order
    origins: list[Array]  # [m] a point on each joint's axis, in chain order
    position: Array  # [m] of the flange
    columns: list[Array]  # x, y, z of the flange


def geometry_of(robot: Robot) -> Geometry:
    """The robot's geometry. Raises OlpError (K001) when its file states none."""
    if robot.geometry is None:
        advice = "add [links] or [chain] to its robot file"
        raise OlpError(error("K001", f"the geometry of {robot.name} is not known", help=advice))
    return robot.geometry


def forward(robot: Robot, joints: ArrayLike) -> tuple[Array, Array]:
    """Flange poses in the robot base frame (height of axes S and L, floor height not added).

    `joints` (n, k) [rad | m] in the order of the robot's axes. Returns positions (n, 3) [m] and rotations
    (n, 3, 3). Raises OlpError: K001 no geometry, K002 wrong number of axes.
    """
    geometry = geometry_of(robot)
    values = as_joints(robot, joints)
    count = len(values)
    positions, rotations = np.empty((3, count)), np.empty((3, 3, count))
    for start in range(0, count, BLOCK):
        part = slice(start, start + BLOCK)
        swept = sweep(robot, geometry, values[part].T)
        positions[:, part] = swept.position
        for i, column in enumerate(swept.columns):
            rotations[:, i, part] = column
    return positions.T, rotations.transpose(2, 0, 1)


def jacobian(robot: Robot, joints: ArrayLike) -> Array:
    """(n, 6, k): flange velocity [m/s] and angular velocity [rad/s] per unit joint speed, in the base frame."""
    geometry = geometry_of(robot)
    values = as_joints(robot, joints)
    swept = sweep(robot, geometry, values.T)
    result = np.zeros((len(values), 6, values.shape[1]))
    for joint, axis, origin in zip(geometry.joints, swept.axes, swept.origins, strict=True):
        if robot.axes[joint.axis].linear:
            result[:, :3, joint.axis] = axis.T
        else:
            result[:, :3, joint.axis] = np.cross(axis.T, (swept.position - origin).T)
            result[:, 3:, joint.axis] = axis.T
    return result


def joint_speeds(robot: Robot, joints: ArrayLike, twist: ArrayLike, damping: float) -> Array:
    """(n, k): joint speeds with which the flange does `twist` (n, 6) [m/s, rad/s], as `jacobian` has it.

    `damping` [m/s per rad/s]: near a singularity the speeds stay finite, and the twist is missed a little instead.
    """
    matrix = jacobian(robot, joints)
    turned = matrix.transpose(0, 2, 1)
    square = turned @ matrix + damping**2 * np.eye(matrix.shape[2])
    return np.asarray(np.linalg.solve(square, turned @ np.asarray(twist)[:, :, None])[:, :, 0])


def as_joints(robot: Robot, joints: ArrayLike) -> Array:
    """`joints` as (n, k). Raises OlpError (K002) when k is not the robot's number of axes."""
    values = np.atleast_2d(np.asarray(joints, dtype=np.float64))
    if values.ndim != 2 or values.shape[1] != len(robot.axes):
        message = f"{robot.name} has {len(robot.axes)} axes, the points have {values.shape[-1]}"
        raise OlpError(error("K002", message))
    return values


def sweep(robot: Robot, geometry: Geometry, joints: Array) -> Sweep:
    """All joints of the chain for `joints` (k, m) [rad | m]."""
    count = joints.shape[1]
    sines, cosines = np.sin(joints), np.cos(joints)
    columns = [np.repeat(np.eye(3)[:, i : i + 1], count, axis=1) for i in range(3)]
    position = np.zeros((3, count))
    axes, origins = [], []
    for joint in geometry.joints:
        position = _shifted(position, columns, joint.offset)
        axis = _combined(columns, joint.direction)
        axes.append(axis)
        origins.append(position)
        if robot.axes[joint.axis].linear:
            position = position + axis * joints[joint.axis]
        else:
            columns = _turned(columns, joint.direction, sines[joint.axis], cosines[joint.axis])
    position = _shifted(position, columns, geometry.flange_offset)
    flange = [_combined(columns, column) for column in zip(*geometry.flange_rotation, strict=True)]
    return Sweep(axes, origins, position, flange)


def _combined(columns: list[Array], weights: Vector) -> Array:
    """Sum of the columns times their weights; zero weights cost nothing."""
    terms = [column if w == 1.0 else column * w for column, w in zip(columns, weights, strict=True) if w]
    return sum(terms[1:], terms[0])


def _shifted(position: Array, columns: list[Array], offset: Vector) -> Array:
    return position + _combined(columns, offset) if any(offset) else position


def _turned(columns: list[Array], direction: Vector, sine: Array, cosine: Array) -> list[Array]:
    """The columns after a turn about `direction`, given in their own frame."""
    if sorted(map(abs, direction)) != [0.0, 0.0, 1.0]:
        return _turned_anyhow(columns, direction, sine, cosine)
    # About a coordinate axis only the two other columns mix: a third of the general product.
    axis = max(range(3), key=lambda i: abs(direction[i]))
    u, v = (axis + 1) % 3, (axis + 2) % 3
    sine = sine * direction[axis]
    turned = list(columns)
    turned[u] = columns[u] * cosine + columns[v] * sine
    turned[v] = columns[v] * cosine - columns[u] * sine
    return turned


def _turned_anyhow(columns: list[Array], direction: Vector, sine: Array, cosine: Array) -> list[Array]:
    x, y, z = direction
    versine = 1.0 - cosine
    # Rodrigues: I cos + (1 - cos) d dᵀ + sin [d]x, column by column.
    weights = (
        (cosine + versine * x * x, versine * x * y + sine * z, versine * x * z - sine * y),
        (versine * x * y - sine * z, cosine + versine * y * y, versine * y * z + sine * x),
        (versine * x * z + sine * y, versine * y * z - sine * x, cosine + versine * z * z),
    )
    return [columns[0] * a + columns[1] * b + columns[2] * c for a, b, c in weights]


# --- Tool ---
# Between the poses of the flange and those of the tool centre point.


def with_tool(positions: ArrayLike, rotations: ArrayLike, tool: Pose) -> tuple[Array, Array]:
    """Poses of the tool centre point, (n, 3) [m] and (n, 3, 3), from those of the flange."""
    return compose(positions, rotations, tool.position, tool.rotation)


def without_tool(positions: ArrayLike, rotations: ArrayLike, tool: Pose) -> tuple[Array, Array]:
    """Poses of the flange, (n, 3) [m] and (n, 3, 3), from those of the tool centre point."""
    off = tool.inverse()
    return compose(positions, rotations, off.position, off.rotation)
