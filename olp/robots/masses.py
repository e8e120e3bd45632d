"""Masses, friction, rotors and torque limits of a machine: what rigid-body dynamics needs besides the geometry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

Vector = tuple[float, float, float]
Inertia = tuple[float, float, float, float, float, float]

NO_INERTIA: Inertia = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Body(NamedTuple):
    """A rigid body in some frame: of a link its own (see `Dynamics`), of a load the flange's."""

    mass: float  # [kg]
    centre: Vector = (0.0, 0.0, 0.0)  # [m] centre of mass
    inertia: Inertia = NO_INERTIA  # [kg m²] about the centre of mass: xx, yy, zz, xy, xz, yz of the tensor


class Drive(NamedTuple):
    """What the drive of one axis adds, on the joint's side of the gear. Units of a sliding axis in second place."""

    limit: float | None = None  # [Nm | N] largest torque, None where not known
    rotor: float = 0.0  # [kg m² | kg] inertia of rotor and gear, times the ratio squared
    viscous: float = 0.0  # [Nm s/rad | N s/m] friction per speed
    coulomb: float = 0.0  # [Nm | N] friction that depends on the direction only


@dataclass(frozen=True, slots=True)
class Dynamics:
    """Bodies and drives, both in the order of the robot's axes.

    The body of an axis is what that axis moves and the next one does not. Its frame has its origin at the joint's
    point of the chain and, with all axes at zero, the directions of the base frame; it turns with the link.
    """

    bodies: tuple[Body, ...]
    drives: tuple[Drive, ...]
    point_masses: tuple[str, ...] = ()  # names of the axes whose bodies have no inertia of their own stated
