"""Forward kinematics and Jacobian of a serial chain, the configuration of a pose, and the joint turns that it implies.

A configuration is six flags, as RCONF counts them: 1 flip (B >= 0: 0) or no flip (B < 0: 1); 2 upper (0) or lower (1)
elbow; 3 wrist centre in front of (0) or behind (1) axis S; 4, 5, 6 whether |R|, |T|, |S| reach 180 deg (controller
manuals; 1, 3 and 5 are confirmed by the twenty AR2010 poses that exist both as pulses and as coordinates).

Readings are joint values as a maker's controller shows them. FANUC reads axis 3 against the horizontal: its reading
stays when axis 2 alone turns the upper arm. Everything else here counts joints, each against the link before;
readings become joints where a program is read and where one is written.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.geometry import Pose, compose
from olp.robots.model import Geometry, Links, Robot, Vector

Array = NDArray[np.float64]

# Poses per block: all intermediate arrays of a block together stay in the second-level cache.
BLOCK = 2048


@dataclass(frozen=True, slots=True)
class Tool:
    """A tool on the flange. `pose`: the tool centre point; `mass` [kg], `centre` of gravity [m] relative to the
    flange.
    """

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

    def at(self, rows: NDArray[np.bool_]) -> Sweep:
        """Of some of the poses, `rows` (m,)."""
        if rows.all():
            return self
        axes, origins, columns = (
            [one[:, rows] for one in part] for part in (self.axes, self.origins, self.columns)
        )
        return Sweep(axes, origins, self.position[:, rows], columns)


def geometry_of(robot: Robot) -> Geometry:
    """The robot's geometry. Raises OlpError (K001) when its file has none."""
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
    """Jacobians (n, 6, k): flange velocity [m/s] and angular velocity [rad/s] per unit joint speed, in the base
    frame.
    """
    geometry = geometry_of(robot)
    return slopes(robot, geometry, sweep(robot, geometry, as_joints(robot, joints).T))


def slopes(robot: Robot, geometry: Geometry, swept: Sweep) -> Array:
    """The Jacobians (m, 6, k) of the poses that were swept, as `jacobian`."""
    result = np.zeros((swept.position.shape[1], 6, len(robot.axes)))
    for joint, axis, origin in zip(geometry.joints, swept.axes, swept.origins, strict=True):
        if robot.axes[joint.axis].linear:
            result[:, :3, joint.axis] = axis.T
        else:
            # The products of np.cross, which takes longer to sort its axes than to multiply.
            (x, y, z), (u, v, w) = axis, swept.position - origin
            result[:, 0, joint.axis] = y * w - z * v
            result[:, 1, joint.axis] = z * u - x * w
            result[:, 2, joint.axis] = x * v - y * u
            result[:, 3:, joint.axis] = axis.T
    return result


def joint_speeds(robot: Robot, joints: ArrayLike, twist: ArrayLike, damping: float) -> Array:
    """Joint speeds (n, k) that give the flange the velocity `twist` (n, 6) [m/s, rad/s], in the order of
    `jacobian`.

    `damping` [m/s per rad/s]: near a singularity the speeds stay finite, and the twist is only approximated.
    """
    matrix = jacobian(robot, joints)
    turned = matrix.transpose(0, 2, 1)
    square = turned @ matrix + damping**2 * np.eye(matrix.shape[2])
    return np.asarray(
        np.linalg.solve(square, turned @ np.asarray(twist)[:, :, None])[:, :, 0], dtype=np.float64
    )


def as_joints(robot: Robot, joints: ArrayLike) -> Array:
    """`joints` as (n, k). Raises OlpError (K002) when k is not the robot's number of axes."""
    values = np.atleast_2d(np.asarray(joints, dtype=np.float64))
    if values.ndim != 2 or values.shape[1] != len(robot.axes):
        message = f"{robot.name} has {len(robot.axes)} axes, the points have {values.shape[-1]}"
        raise OlpError(error("K002", message))
    return values


def sweep(robot: Robot, geometry: Geometry, joints: Array) -> Sweep:
    """Positions and axes of all joints of the chain, and the flange, for `joints` (k, m) [rad | m]."""
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


Flags = NDArray[np.int64]

# Axes (S L U R B T) whose turn a flag tells, in the order of flags 4, 5, 6.
TURN_AXES = (3, 5, 0)
_TURN = 2.0 * math.pi


class Singularity(NamedTuple):
    """Which poses are near each of the three singularities, (n,) each: there a joint speed grows without bound."""

    wrist: NDArray[np.bool_]  # B nearly 0: R and T turn about one line
    elbow: NDArray[np.bool_]  # arm nearly stretched or folded
    shoulder: NDArray[np.bool_]  # wrist centre nearly on axis S


class Clearance(NamedTuple):
    """Distance of poses from each of the three singularities, (n,) each; 0 at a singularity, with opposite signs on
    its two sides.
    """

    wrist: Array  # [rad] -pi/2..pi/2, of axis B from its nearest straight or folded position
    elbow: Array  # [rad] of the forearm from the stretched arm (positive: upper elbow) or from the folded one
    shoulder: Array  # [m] of the wrist centre from axis S, negative behind it


def links_of(robot: Robot) -> Links:
    """The robot's links. Raises OlpError (K001 no geometry, K004 no spherical wrist)."""
    links = geometry_of(robot).links
    if links is None:
        message = f"{robot.name} has no spherical wrist with six axes: RCONF does not describe its poses"
        raise OlpError(
            error("K004", message, help="give its points as pulses, or solve from a start position")
        )
    return links


def configuration_of(robot: Robot, joints: ArrayLike) -> Flags:
    """Configuration flags (n, 6), 0 or 1, of joints (n, 6) [rad]. Raises OlpError: K001, K002, K004."""
    links = links_of(robot)
    values = as_joints(robot, joints)
    standard = to_standard(links, values)
    flags = np.zeros(values.shape, dtype=np.int64)
    flags[:, 0] = wrap(standard[:, 4]) < 0.0
    flags[:, 1] = wrap(standard[:, 2] - _stretched(links)) > 0.0
    flags[:, 2] = _radius(links, standard) < 0.0
    for flag, axis in enumerate(TURN_AXES, start=3):
        # A controller's own pose at 180 deg comes back a rounding error short of it.
        flags[:, flag] = np.abs(values[:, axis]) >= math.pi - 1e-9
    return flags


def singularities(robot: Robot, joints: ArrayLike, angle: float = 0.01, length: float = 0.01) -> Singularity:
    """Which poses lie within `angle` [rad] (wrist, elbow) or `length` [m] (shoulder) of a singularity.

    `joints` (n, 6) [rad]. Raises OlpError: K001, K002, K004.
    """
    clear = clearance(robot, joints)
    return Singularity(
        np.abs(clear.wrist) < angle, np.abs(clear.elbow) < angle, np.abs(clear.shoulder) < length
    )


def clearance(robot: Robot, joints: ArrayLike) -> Clearance:
    """Distance of joints (n, 6) [rad] from the singularities; nan for nan joints. Raises OlpError: K001, K002, K004."""
    links = links_of(robot)
    standard = to_standard(links, as_joints(robot, joints))
    bend = wrap(_stretched(links) - standard[:, 2])
    return Clearance(
        np.arcsin(np.sin(standard[:, 4])),
        np.where(np.abs(bend) > math.pi / 2, np.copysign(math.pi, bend) - bend, bend),
        _radius(links, standard),
    )


def within_limits(robot: Robot, joints: ArrayLike) -> NDArray[np.bool_]:
    """Whether each of the joints (n, k) [rad | m] is inside the soft limits (n, k); False for nan."""
    values = as_joints(robot, joints)
    inside: NDArray[np.bool_] = (values >= robot.lower - 1e-9) & (values <= robot.upper + 1e-9)
    return inside


def to_standard(links: Links, readings: Array) -> Array:
    """Standard angles from readings, both (n, 6) [rad]."""
    standard: Array = readings * np.array(links.signs, dtype=np.float64) + np.array(links.zeros)
    return standard


def from_standard(links: Links, standard: Array) -> Array:
    """Readings from standard angles, axes last, both (..., 6) [rad]."""
    readings: Array = (standard - np.array(links.zeros)) * np.array(links.signs, dtype=np.float64)
    return readings


def turn_centres(robot: Robot) -> Array:
    """Centres (6,) [rad] about which readings are wrapped to within half a turn.

    Flags give the turn of S, R and T, so these centre on 0; no flag gives it for L, U and B, which centre on the
    middle of their limits (U reaches beyond 180 deg on many arms).
    """
    centres = (robot.lower + robot.upper) / 2.0
    centres[list(TURN_AXES)] = 0.0
    return centres


def apply_turns(readings: Array, configuration: Flags) -> Array:
    """Readings (n, 6) [rad] with S, R, T one turn further where flags 4 to 6 of (n, 6) or (6,) are set.

    A flag that is neither 0 nor 1 is a signed number of turns.
    """
    turned = readings.copy()
    flags = np.broadcast_to(configuration, readings.shape)
    for flag, axis in enumerate(TURN_AXES, start=3):
        value = readings[:, axis]
        further = (flags[:, flag] != 0) & (np.abs(value) < math.pi - 1e-9)
        turned[:, axis] = np.where(further, value - np.copysign(_TURN, value), value)
        counted = (flags[:, flag] < 0) | (flags[:, flag] > 1)
        turned[:, axis] = np.where(counted, value + _TURN * flags[:, flag], turned[:, axis])
    return turned


def wrap(angle: Array, centre: float | Array = 0.0) -> Array:
    """`angle` [rad] shifted by whole turns to within half a turn of `centre`."""
    wrapped: Array = angle - _TURN * np.rint((angle - centre) / _TURN)
    return wrapped


def _stretched(links: Links) -> float:
    """Standard angle U [rad] at which forearm and upper arm are in line: upper elbow below it, lower elbow above it."""
    return math.pi / 2.0 - math.atan2(links.a3, links.d4)


def _radius(links: Links, standard: Array) -> Array:
    """Distance (n,) [m] of the wrist centre from axis S, negative behind it."""
    pitch = standard[:, 1] - standard[:, 2]
    forearm = links.d4 * np.cos(pitch) + links.a3 * np.sin(pitch)
    return links.a1 + links.a2 * np.sin(standard[:, 1]) + forearm


# --- Sectors ---
# How far axes have turned, said by sectors: signs, quarters, or numbers of turns.

Sectors = Sequence[tuple[int, float, float]]  # axis, from [rad], to below [rad]

QUARTER = 0.5 * math.pi
_EDGE = 1e-6  # [rad] an axis on the edge of a sector is in both
_TURNS = (0, 1, -1, 2, -2)


def turned_into(robot: Robot, joints: Array, sectors: Sectors) -> Array:
    """Joints (n, 6) [rad] with axes shifted by whole turns into their sector, if the limits allow."""
    turned = joints.copy()
    for axis, low, high in sectors:
        if axis not in TURN_AXES and not (math.isfinite(low) and math.isfinite(high)):
            continue  # a sign of one of the arm's axes tells no turn
        value = joints[:, axis]
        done = np.zeros(len(joints), dtype=bool)
        for turns in _TURNS:
            further = value + turns * _TURN
            fits = _in(further, low, high) & _in(further, robot.lower[axis], robot.upper[axis] + 1e-9)
            turned[:, axis] = np.where(fits & ~done, further, turned[:, axis])
            done |= fits
    return turned


def said_of(robot: Robot, joints: Array, flags: Flags, sectors: Sequence[Sectors]) -> Array:
    """Joints (n, 6) [rad] that a reader computes from the pose of `joints` (n, 6) [rad] with `flags` (n, 6) and the
    sectors of each row.
    """
    said = apply_turns(wrap(joints, turn_centres(robot)), flags)
    for row in range(len(said)):
        said[row] = turned_into(robot, said[row : row + 1], sectors[row])[0]
    return said


def stands_in(joints: Array, sectors: Sectors) -> NDArray[np.bool_]:
    """Whether joints (n, 6) [rad] are in all sectors that have two ends (n,); False for unknown joints.

    A sector with one end only gives a number of turns, counted by the maker's convention, and is ignored.
    """
    inside = np.ones(len(joints), dtype=bool)
    for axis, low, high in sectors:
        if math.isfinite(low) and math.isfinite(high):
            inside &= _in(joints[:, axis], low, high)
    return inside


def quarters_of(joints: Array) -> NDArray[np.int64]:
    """Quarter turn in which S, R, T are (n, 3): 0 is 0 to 90 deg, -1 is -90 to 0 deg. `joints` (n, 6) [rad]."""
    found: NDArray[np.int64] = np.floor(joints[:, (0, 3, 5)] / QUARTER + 1e-9).astype(np.int64)
    return found


def _in(values: Array, low: float, high: float) -> NDArray[np.bool_]:
    return np.asarray((values >= low - _EDGE) & (values < high + _EDGE))


def joints_of_readings(robot: Robot, readings: Array) -> Array:
    """Joints (n, k) [rad | m] of the controller's readings."""
    links = _coupled(robot)
    if links is None:
        return readings
    joints = readings.copy()
    joints[:, 2] += links.signs[1] * links.signs[2] * readings[:, 1]
    return joints


def readings_of_joints(robot: Robot, joints: Array) -> Array:
    """The controller's readings of joints; inverse of `joints_of_readings`."""
    links = _coupled(robot)
    if links is None:
        return joints
    readings = joints.copy()
    readings[:, 2] -= links.signs[1] * links.signs[2] * joints[:, 1]
    return readings


def same_posture(robot: Robot, other: Robot, joints: Array) -> Array | None:
    """Joints (n, 6) [rad] that give `other` the posture of `robot` at `joints`: parallel links, same front side.

    None if either is not a six-axis arm with a spherical wrist. L, U and B lie within the other's range; S, R and T
    keep their turns unless only other turns are within the other's limits.
    """
    one = None if robot.geometry is None else robot.geometry.links
    two = None if other.geometry is None else other.geometry.links
    if one is None or two is None:
        return None
    if (one.signs, one.zeros) == (two.signs, two.zeros):
        return joints
    found = from_standard(two, to_standard(one, joints))
    turned = wrap(found, (other.lower + other.upper) / 2.0)
    for axis in (1, 2, 4):
        found[:, axis] = turned[:, axis]
    return np.where(within_limits(other, turned) & ~within_limits(other, found), turned, found)


def turned_back(robot: Robot, other: Robot, joints: Array, found: Array) -> NDArray[np.bool_]:
    """Rows (n,) of `found`, the result of `same_posture` for `joints`, in which S, R or T differ by whole turns."""
    went_on = from_standard(links_of(other), to_standard(links_of(robot), joints))
    apart: Array = np.abs(found - went_on)[:, TURN_AXES]
    return np.asarray((apart > np.pi).any(axis=1))


def _coupled(robot: Robot) -> Links | None:
    links = None if robot.geometry is None else robot.geometry.links
    return links if links is not None and links.third_to_horizontal else None


# --- Pulses ---
# Encoder pulses to joint values and back.


def pulses_to_joints(robot: Robot, pulses: ArrayLike) -> Array:
    """Joints (n, k) [rad | m] from pulses (n, k). Raises OlpError: K002 number of axes, K003 unknown ratios."""
    return as_joints(robot, pulses) / _ratios(robot)


def joints_to_pulses(robot: Robot, joints: ArrayLike) -> NDArray[np.int64]:
    """Whole pulses (n, k) from joints (n, k) [rad | m]. Raises OlpError: K002 number of axes, K003 unknown ratios."""
    return np.rint(as_joints(robot, joints) * _ratios(robot)).astype(np.int64)


def _ratios(robot: Robot) -> Array:
    """Pulses per unit of each axis (k,) [pulses/rad | pulses/m]. Raises OlpError (K003)."""
    unknown = [axis.name for axis in robot.axes if axis.pulses_per_unit is None]
    if unknown:
        raise OlpError(
            error(
                "K003",
                f"the pulses per degree of {robot.name} are not known (axes {', '.join(unknown)})",
                help="give pulses_per_deg in a robot file of your own, or import the controller's backup",
            )
        )
    return robot.pulses_per_unit
