"""Torques of motions and the parts of equation 5.1: t = M(q) q'' + h(q, q') + V q' + g(q)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.dynamics.algebra import (
    Matrix,
    Term,
    Triple,
    add,
    apply,
    cross,
    dot,
    minus,
    plus,
    scale,
    times,
    turn,
)
from olp.robots.dynamics.links import Link, links_of
from olp.robots.dynamics.model import DynamicModel
from olp.robots.kinematics.chain import as_joints
from olp.robots.model import Body, Robot, Vector

Array = NDArray[np.float64]

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
    """(n, k) [Nm | N]: centrifugal and Coriolis forces, friction and gravity; torques without acceleration."""
    positions, speeds = same_shape(model.robot, q, qd)
    torques = _recursion(model, payload, model.gravity, positions, speeds, None)
    _, viscous, coulomb = drives_of(model)
    return torques + speeds * viscous + np.sign(speeds) * coulomb


def gravity_torques(model: DynamicModel, q: ArrayLike, payload: Body | None = None) -> Array:
    """(n, k) [Nm | N] that hold the robot still, without friction."""
    return _recursion(model, payload, model.gravity, as_joints(model.robot, q), None, None)


def inertia_forces(
    model: DynamicModel, q: ArrayLike, qd: ArrayLike | None, qdd: ArrayLike, payload: Body | None = None
) -> Array:
    """(n, k) [Nm | N] without gravity and friction: M q'' + h, or M q'' alone when `qd` is None."""
    rotors = drives_of(model)[0]
    positions, accelerations = same_shape(model.robot, q, qdd)
    speeds = None if qd is None else same_shape(model.robot, q, qd)[1]
    torques = _recursion(model, payload, _WEIGHTLESS, positions, speeds, accelerations)
    return torques + accelerations * rotors if rotors.any() else torques


def mass_matrix(model: DynamicModel, q: ArrayLike, payload: Body | None = None) -> Array:
    """(n, k, k) [kg m² | kg m | kg], symmetric, rotors included: column j is what unit acceleration of axis j takes."""
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
    """Each as (n, k). Raises OlpError: K002 wrong number of axes, K007 numbers of rows differ."""
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
    """(n, k) joint forces; no speeds or accelerations are zeros that cost nothing."""
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
    """Slices of the samples and the motion in each."""
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
    """Of the robot's axes, one term each; a constant applies to all samples and is cheaper than an array."""

    sines: Sequence[Term]  # of the angles; not used for sliding axes
    cosines: Sequence[Term]
    positions: Sequence[Term]  # [m] of sliding axes; not used for turning ones
    speeds: Sequence[Term]  # [rad/s | m/s]
    accelerations: Sequence[Term]  # [rad/s² | m/s²]


class LinkState(NamedTuple):
    """A link's motion in its own frame. `pull` p is the acceleration of the point p less that of the origin."""

    turning: Triple  # [rad/s]
    turning_rate: Triple  # [rad/s²]
    origin: Triple  # [m/s²] acceleration of its origin; the base's is minus gravity
    pull: Matrix  # [1/s²]
    arm: Triple  # [m] from the origin of the link before, in that link's frame


def joint_forces(
    links: Sequence[Link], motion: AxisMotion, gravity: Vector, first: int = 0
) -> dict[int, Term]:
    """[Nm | N] by index of the axis, of the joints from chain index `first` on to the flange.

    Luh, Walker, Paul: On-line computational scheme for mechanical manipulators (1980), in link frames, with
    the moments of each link about its joint: F = m a + U c, N = [J U]x + c × a, U = [w']x + [w]x[w]x.
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
    """A vector of the frame before, seen from the link."""
    back = (-link.direction[0], -link.direction[1], -link.direction[2])
    return turn(vector, back, motion.sines[link.axis], motion.cosines[link.axis])


def _inward(link: Link, motion: AxisMotion, vector: Triple) -> Triple:
    """A vector of the link, seen from the frame before."""
    if link.linear:
        return vector
    return turn(vector, link.direction, motion.sines[link.axis], motion.cosines[link.axis])
