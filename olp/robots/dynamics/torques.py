"""Torques of motions and the parts of equation 5.1: t = M(q) q'' + h(q, q') + V q' + g(q).

The robot is a chain of rigid bodies under gravity. The masses of the links are prepared once, without the parts
that their own joint cannot move. Sums and products treat constants separately: a constant 0 or 1 costs nothing. In
a robot most components are always zero: joints turn about coordinate axes, offsets lie along them, the base does
not move. Python floats are the constants, arrays are values of many samples; the recursion is written for the
general case, and constant terms drop out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.kinematics.configuration import as_joints, geometry_of
from olp.robots.model import Body, Robot, Vector, tensor

if TYPE_CHECKING:
    from olp.robots.kinematics.configuration import Tool


Mounting = Literal["floor", "wall", "ceiling"]
STANDARD_GRAVITY: Final = 9.80665  # [m/s²] CGPM 1901
_TILTS: Final[dict[str, float]] = {"floor": 0.0, "wall": math.pi / 2.0, "ceiling": math.pi}


@dataclass(frozen=True, slots=True)
class DynamicModel:
    """A robot whose masses are known, and the gravity [m/s²] that acts on it, in its base frame."""

    robot: Robot
    gravity: Vector = (0.0, 0.0, -STANDARD_GRAVITY)

    @property
    def torque_limits(self) -> NDArray[np.float64]:
        """Torque limits (k,) [Nm | N], infinite where unknown."""
        assert self.robot.dynamics is not None
        limits = [drive.limit for drive in self.robot.dynamics.drives]
        return np.array([math.inf if limit is None else limit for limit in limits])

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Sentences on the data that the robot's file lacks and the model's assumptions for them."""
        dynamics = self.robot.dynamics
        assert dynamics is not None
        points = ", ".join(dynamics.point_masses)
        groups = (
            (f"the inertias of {points} are not known: taken as point masses", not points),
            ("the inertia of the rotors is not known: taken as zero", any(d.rotor for d in dynamics.drives)),
            ("friction is not known: taken as zero", any(d.viscous or d.coulomb for d in dynamics.drives)),
        )
        return tuple(f"{self.robot.name}: {says}" for says, known in groups if not known)


def dynamic_model(robot: Robot, mounting: Mounting | Vector = "floor") -> DynamicModel:
    """The model of `robot` on the floor, on a wall or under a ceiling, or under any gravity [m/s²] in its base
    frame.

    On a wall the base frame's x points down; for other mountings pass the gravity vector. Raises OlpError: K001 no
    geometry, K006 no masses (the caller then uses a model without masses).
    """
    geometry_of(robot)
    if robot.dynamics is None:
        advice = "add [dynamics] to its robot file, or use an acceleration that needs no masses"
        raise OlpError(error("K006", f"the masses of {robot.name} are not known", help=advice))
    if isinstance(mounting, str):
        return DynamicModel(robot, gravity_of(_TILTS[mounting]))
    return DynamicModel(robot, mounting)


def gravity_of(tilt: float) -> Vector:
    """Gravity [m/s²] in the base frame of a robot that is tilted by `tilt` [rad] about its base frame's y axis."""
    # Quarter turns have exact zeros, which the recursion skips.
    x, z = (round(value, 15) for value in (math.sin(tilt), -math.cos(tilt)))
    return STANDARD_GRAVITY * x, 0.0, STANDARD_GRAVITY * z


def payload_of(tool: Tool) -> tuple[Body | None, tuple[str, ...]]:
    """The load of a tool relative to the flange, and sentences on its assumptions; None without a mass."""
    name = f"tool {tool.name}" if tool.name else "the tool"
    if tool.mass is None:
        return None, (f"the mass of {name} is not known: taken as nothing",)
    assumed = []
    if tool.centre is None:
        assumed.append(f"the centre of gravity of {name} is not known: taken in the flange")
    if tool.inertia is None:
        assumed.append(f"the inertia of {name} is not known: taken as a point mass")
    inertia = (*(tool.inertia or (0.0, 0.0, 0.0)), 0.0, 0.0, 0.0)
    return Body(tool.mass, tool.centre or (0.0, 0.0, 0.0), inertia), tuple(assumed)


Rows = tuple[Vector, Vector, Vector]


class Link(NamedTuple):
    """One link in its own frame (origin at its joint, directions of the base at zero)."""

    axis: int  # index into the robot's axes
    linear: bool
    direction: Vector
    offset: Vector  # [m] of its joint in the frame of the link before
    mass: float  # [kg]
    first: Vector  # [kg m] mass times centre
    second: Rows  # [kg m²] sum of mass times position times position transposed


@lru_cache(maxsize=128)
def links_of(robot: Robot, payload: Body | None) -> tuple[Link, ...]:
    """The links from base to flange; the payload belongs to the last one. Needs geometry and dynamics of the robot.

    A mass on the axis of a turning joint moves as if it belonged to the link before; so do the second moments of a
    sliding link. They count for that link, so the recursion has less to do (base parameters; Khalil and Dombre,
    Modeling, Identification and Control of Robots, 2002, section 9.4); the joint forces are the same.
    """
    assert robot.geometry is not None
    assert robot.dynamics is not None
    joints = robot.geometry.joints
    moments = [_about_origin(robot.dynamics.bodies[joint.axis]) for joint in joints]
    if payload is not None:
        moments[-1] = moments[-1] + _about_origin(
            payload, np.array(robot.geometry.flange_rotation), np.array(robot.geometry.flange_offset)
        )
    for i in reversed(range(len(joints))):
        linear = robot.axes[joints[i].axis].linear
        kept = _unmoved(moments[i], np.array(joints[i].direction), linear)
        moments[i] = moments[i] - kept
        if i:
            moments[i - 1] = moments[i - 1] + _shifted(kept, np.array(joints[i].offset))
    return tuple(
        Link(joint.axis, robot.axes[joint.axis].linear, joint.direction, joint.offset, *_plain(moment))
        for joint, moment in zip(joints, moments, strict=True)
    )


# All moments of a body in one symmetric matrix [[second, first], [first, mass]]: they add, and they move by M X Mᵀ.


def _about_origin(body: Body, rotation: Array | None = None, offset: Array | None = None) -> Array:
    """Moments (4, 4) of a body about the origin of the link in which it is rotated and shifted."""
    centre, inertia = np.array(body.centre), tensor(body.inertia)
    if rotation is not None and offset is not None:
        centre, inertia = offset + rotation @ centre, rotation @ inertia @ rotation.T
    moments = np.zeros((4, 4))
    moments[:3, :3] = np.eye(3) * (np.trace(inertia) / 2.0) - inertia
    place = np.append(centre, 1.0)
    return moments + body.mass * np.outer(place, place)


def _unmoved(moments: Array, direction: Array, linear: bool) -> Array:
    """The part (4, 4) of the moments that acts on the joint's own link exactly as on the link before it."""
    kept = np.zeros((4, 4))
    if linear:
        kept[:3, :3] = moments[:3, :3]
        return kept
    kept[:3, :3] = np.outer(direction, direction) * (direction @ moments[:3, :3] @ direction)
    kept[:3, 3] = kept[3, :3] = direction * (direction @ moments[:3, 3])
    kept[3, 3] = moments[3, 3]
    return kept


def _shifted(moments: Array, offset: Array) -> Array:
    move = np.eye(4)
    move[:3, 3] = offset
    return move @ moments @ move.T


def _plain(moments: NDArray[np.float64]) -> tuple[float, Vector, Rows]:
    """The moments as Python floats: only these count as constants."""
    rows = moments.tolist()
    first = (rows[0][3], rows[1][3], rows[2][3])
    second: Rows = (tuple(rows[0][:3]), tuple(rows[1][:3]), tuple(rows[2][:3]))
    return rows[3][3], first, second


Array = NDArray[np.float64]
Term: TypeAlias = float | Array  # exactly `float` for a constant: numpy's own scalars count as arrays
Triple: TypeAlias = tuple[Term, Term, Term]
Matrix: TypeAlias = tuple[Triple, Triple, Triple]


def times(a: Term, b: Term) -> Term:
    """a b"""
    if type(a) is float:
        a, b = b, a
    if type(b) is float:
        if b == 0.0:
            return 0.0
        if b == 1.0:
            return a
        if b == -1.0:
            return -a
    return a * b


def plus(a: Term, b: Term) -> Term:
    """a + b"""
    if type(a) is float and a == 0.0:
        return b
    return a if type(b) is float and b == 0.0 else a + b


def minus(a: Term, b: Term) -> Term:
    """a - b"""
    if type(a) is float and a == 0.0:
        return -b
    return a if type(b) is float and b == 0.0 else a - b


def dot(a: Sequence[Term], b: Sequence[Term]) -> Term:
    """a · b"""
    return plus(plus(times(a[0], b[0]), times(a[1], b[1])), times(a[2], b[2]))


def cross(a: Triple, b: Triple) -> Triple:
    """a × b"""
    return (
        minus(times(a[1], b[2]), times(a[2], b[1])),
        minus(times(a[2], b[0]), times(a[0], b[2])),
        minus(times(a[0], b[1]), times(a[1], b[0])),
    )


def add(a: Triple, b: Triple) -> Triple:
    return plus(a[0], b[0]), plus(a[1], b[1]), plus(a[2], b[2])


def scale(a: Triple, factor: Term) -> Triple:
    return times(a[0], factor), times(a[1], factor), times(a[2], factor)


def apply(matrix: Matrix, vector: Triple) -> Triple:
    """matrix · vector"""
    return dot(matrix[0], vector), dot(matrix[1], vector), dot(matrix[2], vector)


def turn(vector: Triple, axis: tuple[float, float, float], sine: Term, cosine: Term) -> Triple:
    """`vector` turned about the unit vector `axis` by the angle of that sine and cosine."""
    for i in range(3):
        if abs(axis[i]) == 1.0:
            # A turn about a negative axis is one about the positive axis with u and v exchanged.
            u, v = ((i + 1) % 3, (i + 2) % 3)[:: 1 if axis[i] > 0.0 else -1]
            result = [vector[i]] * 3
            result[u] = minus(times(vector[u], cosine), times(vector[v], sine))
            result[v] = plus(times(vector[u], sine), times(vector[v], cosine))
            return result[0], result[1], result[2]
    along = times(dot(vector, axis), minus(1.0, cosine))
    return add(add(scale(vector, cosine), scale(cross(axis, vector), sine)), scale(axis, along))


# Samples per block: all intermediate arrays of a block together stay in the second-level cache.
BLOCK: Final = 4096
_WEIGHTLESS: Final = (0.0, 0.0, 0.0)


def inverse_dynamics(
    model: DynamicModel, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, payload: Body | None = None
) -> Array:
    """Torques (n, k) [Nm | N] of the joints, friction and rotors included (Apostolovic's thesis, equation 5.1).

    `q`, `qd`, `qdd` (n, k) in rad, rad/s, rad/s² (m, m/s, m/s² of sliding axes), in the order of the robot's axes;
    `payload` in the flange frame. Raises OlpError: K002 wrong number of axes, K007 not as many speeds or
    accelerations as positions.
    """
    positions, speeds, accelerations = same_shape(model.robot, q, qd, qdd)
    torques = _recursion(model, payload, model.gravity, positions, speeds, accelerations)
    drives = drives_of(model)
    for part, factors in ((speeds, drives[1]), (np.sign(speeds) if drives[2].any() else speeds, drives[2])):
        if factors.any():
            torques += part * factors
    return torques + accelerations * drives[0] if drives[0].any() else torques


def bias_forces(model: DynamicModel, q: ArrayLike, qd: ArrayLike, payload: Body | None = None) -> Array:
    """Torques without acceleration (n, k) [Nm | N]: centrifugal and Coriolis forces, friction and gravity."""
    positions, speeds = same_shape(model.robot, q, qd)
    torques = _recursion(model, payload, model.gravity, positions, speeds, None)
    _, viscous, coulomb = drives_of(model)
    return torques + speeds * viscous + np.sign(speeds) * coulomb


def gravity_torques(model: DynamicModel, q: ArrayLike, payload: Body | None = None) -> Array:
    """Torques (n, k) [Nm | N] that hold the robot still, without friction."""
    return _recursion(model, payload, model.gravity, as_joints(model.robot, q), None, None)


def inertia_forces(
    model: DynamicModel, q: ArrayLike, qd: ArrayLike | None, qdd: ArrayLike, payload: Body | None = None
) -> Array:
    """Inertia torques (n, k) [Nm | N] without gravity and friction: M q'' + h, or M q'' alone when `qd` is None."""
    rotors = drives_of(model)[0]
    positions, accelerations = same_shape(model.robot, q, qdd)
    speeds = None if qd is None else same_shape(model.robot, q, qd)[1]
    torques = _recursion(model, payload, _WEIGHTLESS, positions, speeds, accelerations)
    return torques + accelerations * rotors if rotors.any() else torques


def mass_matrix(model: DynamicModel, q: ArrayLike, payload: Body | None = None) -> Array:
    """Mass matrix (n, k, k) [kg m² | kg m | kg], symmetric, rotors included: column j is the torque for unit
    acceleration of axis j.
    """
    positions = as_joints(model.robot, q)
    links = links_of(model.robot, payload)
    count = len(links)
    matrix = np.zeros((len(positions), count, count))
    for part, still in _blocks(links, positions, None, None):
        for i, link in enumerate(links):
            unit: list[Term] = [0.0] * count
            unit[link.axis] = 1.0
            # The joints further in have the same entries by symmetry.
            forces = joint_forces(links, still._replace(accelerations=unit), _WEIGHTLESS, first=i)
            for axis, force in forces.items():
                matrix[part, axis, link.axis] = matrix[part, link.axis, axis] = force
    diagonal = np.arange(count)
    matrix[:, diagonal, diagonal] += drives_of(model)[0]
    return matrix


def drives_of(model: DynamicModel) -> tuple[Array, Array, Array]:
    """Rotors [kg m² | kg], viscous [Nm s/rad | N s/m] and Coulomb friction [Nm | N], each (k,)."""
    assert model.robot.dynamics is not None
    drives = model.robot.dynamics.drives
    rotor, viscous, coulomb = (
        [d.rotor for d in drives],
        [d.viscous for d in drives],
        [d.coulomb for d in drives],
    )
    return np.array(rotor), np.array(viscous), np.array(coulomb)


def same_shape(robot: Robot, *arrays: ArrayLike) -> list[Array]:
    """Each array as (n, k). Raises OlpError: K002 wrong number of axes, K007 different numbers of rows."""
    values = [as_joints(robot, array) for array in arrays]
    counts = [len(value) for value in values]
    if len(set(counts)) > 1:
        says = f"positions, speeds and accelerations have {', '.join(map(str, counts))} rows"
        raise OlpError(error("K007", says, help="each needs one row per sample"))
    return values


def _recursion(
    model: DynamicModel,
    payload: Body | None,
    gravity: Vector,
    positions: Array,
    speeds: Array | None,
    accelerations: Array | None,
) -> Array:
    """Joint forces (n, k); None for speeds or accelerations stands for zeros and costs nothing."""
    links = links_of(model.robot, payload)
    result = np.empty_like(positions)
    for part, motion in _blocks(links, positions, speeds, accelerations):
        block = result[part]
        for axis, force in joint_forces(links, motion, gravity).items():
            block[:, axis] = force
    return result


def _blocks(
    links: Sequence[Link], positions: Array, speeds: Array | None, accelerations: Array | None
) -> Iterator[tuple[slice, AxisMotion]]:
    """Slices of the samples, each with its motion."""
    zeros = [0.0] * positions.shape[1]
    turning = [link.axis for link in links if not link.linear]
    for start in range(0, len(positions), BLOCK):
        part = slice(start, start + BLOCK)
        place = np.ascontiguousarray(positions[part].T)
        sines, cosines = list(place), list(place)
        for axis in turning:
            sines[axis], cosines[axis] = np.sin(place[axis]), np.cos(place[axis])
        rate = zeros if speeds is None else list(np.ascontiguousarray(speeds[part].T))
        change = zeros if accelerations is None else list(np.ascontiguousarray(accelerations[part].T))
        yield part, AxisMotion(sines, cosines, list(place), rate, change)


# --- Newton euler ---
# Recursive Newton-Euler over many samples at once: forces of the joints for given motions.


class AxisMotion(NamedTuple):
    """Motion of the robot's axes, one term each; a constant applies to all samples and is cheaper than an array."""

    sines: Sequence[Term]  # of the angles; not used for sliding axes
    cosines: Sequence[Term]
    positions: Sequence[Term]  # [m] of sliding axes; not used for turning ones
    speeds: Sequence[Term]  # [rad/s | m/s]
    accelerations: Sequence[Term]  # [rad/s² | m/s²]


class LinkState(NamedTuple):
    """A link's motion in its own frame. `pull` p is the acceleration of the point p minus that of the origin."""

    turning: Triple  # [rad/s]
    turning_rate: Triple  # [rad/s²]
    origin: Triple  # [m/s²] acceleration of its origin; the base's is minus gravity
    pull: Matrix  # [1/s²]
    arm: Triple  # [m] from the origin of the link before, in that link's frame


def joint_forces(
    links: Sequence[Link], motion: AxisMotion, gravity: Vector, first: int = 0
) -> dict[int, Term]:
    """Forces [Nm | N] by index of the axis, of the joints from chain index `first` on to the flange.

    Luh, Walker, Paul: On-line computational scheme for mechanical manipulators (1980), in link frames, with the
    moments of each link about its joint: F = m a + U c, N = [J U]x + c × a, U = [w']x + [w]x[w]x.
    """
    states = _outward(links, motion, gravity)
    force: Triple = (0.0, 0.0, 0.0)
    moment: Triple = (0.0, 0.0, 0.0)
    forces: dict[int, Term] = {}
    for i in reversed(range(first, len(links))):
        link, state = links[i], states[i]
        # Of the innermost joint asked for only the component along its axis is needed.
        along = [c for c in range(3) if link.direction[c]]
        whole = [0, 1, 2] if i > first else []
        own_force = _newton(link, state, along if link.linear and not whole else whole)
        own_moment = _euler(link, state, whole if link.linear or whole else along)
        if i + 1 < len(links):
            outer = links[i + 1]
            force, moment = _inward(outer, motion, force), _inward(outer, motion, moment)
            moment = add(moment, cross(states[i + 1].arm, force))
        force, moment = add(own_force, force), add(own_moment, moment)
        forces[link.axis] = dot(link.direction, force if link.linear else moment)
    return forces


def _outward(links: Sequence[Link], motion: AxisMotion, gravity: Vector) -> list[LinkState]:
    rest: Triple = (0.0, 0.0, 0.0)
    still: Matrix = (rest, rest, rest)
    state = LinkState(rest, rest, (-gravity[0], -gravity[1], -gravity[2]), still, rest)
    states = []
    for link in links:
        state = _slid(link, motion, state) if link.linear else _turned(link, motion, state)
        states.append(state)
    return states


def _turned(link: Link, motion: AxisMotion, before: LinkState) -> LinkState:
    """The state of a link that turns on the one before."""
    axis, index = link.direction, link.axis
    origin = _outer(link, motion, add(before.origin, apply(before.pull, link.offset)))
    carried = _outer(link, motion, before.turning)
    speed = motion.speeds[index]
    turning = add(carried, scale(axis, speed))
    rate = _outer(link, motion, before.turning_rate)
    rate = add(rate, scale(cross(carried, axis), speed))
    rate = add(rate, scale(axis, motion.accelerations[index]))
    return LinkState(turning, rate, origin, _pull(turning, rate), link.offset)


def _slid(link: Link, motion: AxisMotion, before: LinkState) -> LinkState:
    """The state of a link that slides on the one before."""
    axis, index = link.direction, link.axis
    arm = add(link.offset, scale(axis, motion.positions[index]))
    origin = add(before.origin, apply(before.pull, arm))
    coriolis = scale(cross(before.turning, axis), times(2.0, motion.speeds[index]))
    origin = add(add(origin, coriolis), scale(axis, motion.accelerations[index]))
    return LinkState(before.turning, before.turning_rate, origin, before.pull, arm)


def _pull(w: Triple, rate: Triple) -> Matrix:
    """[rate]x + [w]x [w]x"""
    x, y, z = w
    xx, yy, zz = times(x, x), times(y, y), times(z, z)
    xy, xz, yz = times(x, y), times(x, z), times(y, z)
    return (
        (minus(0.0, plus(yy, zz)), minus(xy, rate[2]), plus(xz, rate[1])),
        (plus(xy, rate[2]), minus(0.0, plus(xx, zz)), minus(yz, rate[0])),
        (minus(xz, rate[1]), plus(yz, rate[0]), minus(0.0, plus(xx, yy))),
    )


def _newton(link: Link, state: LinkState, wanted: Sequence[int]) -> Triple:
    """m a + U c"""
    force: list[Term] = [0.0, 0.0, 0.0]
    for i in wanted:
        force[i] = plus(times(state.origin[i], link.mass), dot(state.pull[i], link.first))
    return force[0], force[1], force[2]


def _euler(link: Link, state: LinkState, wanted: Sequence[int]) -> Triple:
    """The moment of the inertia forces about the origin: sum of m r × (a + U r)."""
    pull, second, first, origin = state.pull, link.second, link.first, state.origin
    moment: list[Term] = [0.0, 0.0, 0.0]
    for i in wanted:
        j, k = (i + 1) % 3, (i + 2) % 3
        skew = minus(times(pull[k][i], second[i][j]), times(pull[j][i], second[i][k]))
        skew = plus(skew, minus(times(pull[k][j], second[j][j]), times(pull[j][k], second[k][k])))
        if second[j][k]:
            skew = plus(skew, times(minus(pull[k][k], pull[j][j]), second[j][k]))
        lever = minus(times(origin[k], first[j]), times(origin[j], first[k]))
        moment[i] = plus(skew, lever)
    return moment[0], moment[1], moment[2]


def _outer(link: Link, motion: AxisMotion, vector: Triple) -> Triple:
    """A vector of the frame before, in the frame of the link."""
    back = (-link.direction[0], -link.direction[1], -link.direction[2])
    return turn(vector, back, motion.sines[link.axis], motion.cosines[link.axis])


def _inward(link: Link, motion: AxisMotion, vector: Triple) -> Triple:
    """A vector of the link, in the frame before."""
    if link.linear:
        return vector
    return turn(vector, link.direction, motion.sines[link.axis], motion.cosines[link.axis])
