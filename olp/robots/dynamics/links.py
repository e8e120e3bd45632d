"""The chain prepared for the recursion: what each link weighs, without what its own joint cannot move."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.robots.dynamics.algebra import Array
from olp.robots.model import Body, Robot, Vector
from olp.robots.reader import tensor

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
    """From base to flange; the payload belongs to the last one. Needs geometry and dynamics of the robot.

    A mass on the axis of a turning joint moves as if it belonged to the link before, and the second moments of a
    sliding link do. They are counted there, so the recursion has less to do (base parameters; Khalil and Dombre,
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
    """(4, 4) moments of a body about the origin of a link that it is turned and shifted in."""
    centre, inertia = np.array(body.centre), tensor(body.inertia)
    if rotation is not None and offset is not None:
        centre, inertia = offset + rotation @ centre, rotation @ inertia @ rotation.T
    moments = np.zeros((4, 4))
    moments[:3, :3] = np.eye(3) * (np.trace(inertia) / 2.0) - inertia
    place = np.append(centre, 1.0)
    return moments + body.mass * np.outer(place, place)


def _unmoved(moments: Array, direction: Array, linear: bool) -> Array:
    """(4, 4) the part that acts on the joint's own link as it would on the link before it."""
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
    """Python floats: only they count as constants."""
    rows = moments.tolist()
    first = (rows[0][3], rows[1][3], rows[2][3])
    second: Rows = (tuple(rows[0][:3]), tuple(rows[1][:3]), tuple(rows[2][:3]))
    return rows[3][3], first, second
