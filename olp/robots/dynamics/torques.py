"""Torques of motions and the parts of equation 5.1: t = M(q) q'' + h(q, q') + V q' + g(q)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.dynamics.algebra import Term
from olp.robots.dynamics.links import Link, links_of
from olp.robots.dynamics.model import DynamicModel
from olp.robots.dynamics.newton_euler import AxisMotion, joint_forces
from olp.robots.kinematics.chain import as_joints
from olp.robots.masses import Body, Vector
from olp.robots.model import Robot

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
