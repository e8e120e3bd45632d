"""A robot as rigid bodies under gravity: what the functions of this package take."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.kinematics.chain import geometry_of
from olp.robots.model import Body, Robot, Vector

if TYPE_CHECKING:
    from olp.robots.coordinate_systems import Tool

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
        """(k,) [Nm | N] infinite where not known."""
        assert self.robot.dynamics is not None
        limits = [drive.limit for drive in self.robot.dynamics.drives]
        return np.array([math.inf if limit is None else limit for limit in limits])

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What the robot's file does not know and the model takes instead, in words."""
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
    """The model of `robot` on the floor, on a wall or under a ceiling, or under any gravity [m/s²] in its base frame.

    On a wall the base frame's x points down; turn the gravity vector for anything else. Raises OlpError: K001 no
    geometry, K006 no masses (the one who asks then uses a model that needs none).
    """
    geometry_of(robot)
    if robot.dynamics is None:
        advice = "add [dynamics] to its robot file, or use an acceleration that needs no masses"
        raise OlpError(error("K006", f"the masses of {robot.name} are not known", help=advice))
    if isinstance(mounting, str):
        return DynamicModel(robot, gravity_of(_TILTS[mounting]))
    return DynamicModel(robot, mounting)


def gravity_of(tilt: float) -> Vector:
    """[m/s²] in the base frame of a robot that stands turned by `tilt` [rad] about its base frame's y axis."""
    # Quarter turns have exact zeros, which the recursion skips.
    x, z = (round(value, 15) for value in (math.sin(tilt), -math.cos(tilt)))
    return STANDARD_GRAVITY * x, 0.0, STANDARD_GRAVITY * z


def payload_of(tool: Tool) -> tuple[Body | None, tuple[str, ...]]:
    """The load that a tool is, seen from the flange, and in words what of it was assumed; None without a mass."""
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
