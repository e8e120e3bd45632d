"""Data of one control group (an arm, a positioner, a track): frozen, SI, with sources."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
Kind = Literal["arm", "positioner", "track"]

# Columns are the flange axes at zero, seen from the base: x up, y to the right, z forward.
FLANGE_AT_ZERO: tuple[Vector, Vector, Vector] = ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0))


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis. Units are radians, or metres when `linear`; None means unknown."""

    name: str
    lower: float  # [rad | m] soft limit
    upper: float  # [rad | m] soft limit
    speed: float  # [rad/s | m/s] rated, what VJ=100 means
    acceleration: float | None = None  # [rad/s² | m/s²]
    pulses_per_unit: float | None = None  # [pulses/rad | pulses/m], in the sense of the job's pulses
    linear: bool = False


class Links(NamedTuple):
    """Six axes with a spherical wrist. Lengths [m] in the standard posture: upper arm up, forearm forward.

    a1 from axis S to axis L (forward), a2 from L to U (up), a3 from U to the forearm's axis R (up), d4 from U to
    the wrist centre (forward), d6 from there to the flange (forward). The standard angle of an axis, which is 0 in
    that posture, is sign x reading + zero: shelf-mounted arms read L = 0 with the upper arm forward, some small
    arms read B = 0 with the flange down.

    `height` [m] of axis L above the origin of the base frame in which the maker's controller gives poses: 0 where
    the origin is at that height. `third_to_horizontal`: the controller reads axis U against the horizontal; the
    limits of U are still those of the joint.
    """

    a1: float
    a2: float
    a3: float
    d4: float
    d6: float
    signs: tuple[int, ...] = (1, 1, 1, 1, 1, 1)
    zeros: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # [rad]
    height: float = 0.0
    third_to_horizontal: bool = False


class Joint(NamedTuple):
    """One joint of the chain, in the order from base to flange."""

    axis: int  # index into Robot.axes: the controller may count the axes in another order
    direction: Vector  # unit vector of the axis at zero, in the base frame
    offset: Vector  # [m] from the previous joint, at zero, in the base frame


@dataclass(frozen=True, slots=True)
class Geometry:
    """A serial chain at zero: each offset is applied before its joint turns (or slides)."""

    joints: tuple[Joint, ...]
    flange_offset: Vector  # [m] from the last joint, at zero, in the base frame
    flange_rotation: tuple[Vector, Vector, Vector] = FLANGE_AT_ZERO  # rows, at zero
    links: Links | None = None  # set when the closed-form inverse of a spherical wrist applies
    base_height: float | None = None  # [m] of the base frame, in which poses are given, above the floor


@dataclass(frozen=True, slots=True)
class Robot:
    """A machine. Poses computed from pulses are proven only where `pose_verified` is true."""

    name: str  # "maker/model", lower case
    maker: str
    model: str
    axes: tuple[Axis, ...]
    kind: Kind = "arm"
    controllers: tuple[str, ...] = ()
    geometry: Geometry | None = None
    dynamics: Dynamics | None = None
    blend_zones: tuple[float, ...] | None = None  # [m] for PL = 1..8
    linear_acceleration: float | None = None  # [m/s²] of the tool centre point
    settling_time: float | None = None  # [s] per exact stop
    acceleration_filter: float | None = None  # [s] that every change of speed takes, however large
    pose_accelerations: PoseAccelerations | None = None  # of the first three axes
    payload: float | None = None  # [kg]
    pose_verified: bool = False  # pulses -> pose was compared with the controller's own coordinates
    sources: Mapping[str, str] = field(default_factory=dict)  # per group of numbers
    inferred: tuple[str, ...] = ()  # the groups (keys of `sources`) that are inferred, not published

    @property
    def axis_names(self) -> tuple[str, ...]:
        return tuple(axis.name for axis in self.axes)

    @property
    def lower(self) -> Array:
        """Lower soft limits (k,) [rad | m]."""
        return np.array([axis.lower for axis in self.axes])

    @property
    def upper(self) -> Array:
        """Upper soft limits (k,) [rad | m]."""
        return np.array([axis.upper for axis in self.axes])

    @property
    def speeds(self) -> Array:
        """Rated speeds (k,) [rad/s | m/s]."""
        return np.array([axis.speed for axis in self.axes])

    @property
    def accelerations(self) -> Array:
        """Accelerations (k,) [rad/s² | m/s²], nan where unknown."""
        return _with_nan([axis.acceleration for axis in self.axes])

    @property
    def pulses_per_unit(self) -> Array:
        """Encoder pulses per unit (k,) [pulses/rad | pulses/m], nan where unknown."""
        return _with_nan([axis.pulses_per_unit for axis in self.axes])

    @property
    def knows_pulses(self) -> bool:
        return all(axis.pulses_per_unit is not None for axis in self.axes)

    def __repr__(self) -> str:
        return f"<Robot {self.name}: {self.kind}, axes {' '.join(self.axis_names)}>"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{escape(axis.name)}</td><td>{axis.lower / unit:g} … {axis.upper / unit:g} {word}</td>"
            f"<td>{axis.speed / unit:g} {word}/s</td></tr>"
            for axis in self.axes
            for unit, word in ([(mm, "mm")] if axis.linear else [(deg, "deg")])
        )
        head = "<tr><th>axis</th><th>range</th><th>rated speed</th></tr>"
        return f"<p>{escape(self.name)}: {escape(self.kind)}</p><table>{head}{rows}</table>"

    def __hash__(self) -> int:
        # `sources` is a mapping and cannot be hashed; the rest already tells robots apart.
        return hash((self.name, self.axes, self.geometry))


class PulseFit(NamedTuple):
    """How well a program's pulses fit a robot's soft limits."""

    robot: Robot
    used: float  # [1] mean over the axes of the share of the range that the pulses span


def _with_nan(values: list[float | None]) -> Array:
    return np.array([math.nan if value is None else value for value in values])


# --- Masses ---
# Masses, friction, rotors and torque limits of a machine: what rigid-body dynamics needs besides the geometry.

Inertia = tuple[float, float, float, float, float, float]

NO_INERTIA: Inertia = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Body(NamedTuple):
    """A rigid body: of a link in the link's own frame (see `Dynamics`), of a load in the flange's."""

    mass: float  # [kg]
    centre: Vector = (0.0, 0.0, 0.0)  # [m] centre of mass
    inertia: Inertia = NO_INERTIA  # [kg m²] about the centre of mass: xx, yy, zz, xy, xz, yz of the tensor


class Drive(NamedTuple):
    """Properties of one axis' drive, on the joint's side of the gear; for a sliding axis with the linear units."""

    limit: float | None = None  # [Nm | N] largest torque, None where not known
    rotor: float = 0.0  # [kg m² | kg] inertia of rotor and gear, times the ratio squared
    viscous: float = 0.0  # [Nm s/rad | N s/m] friction per speed
    coulomb: float = 0.0  # [Nm | N] friction that depends on the direction only


@dataclass(frozen=True, slots=True)
class Dynamics:
    """Bodies and drives, both in the order of the robot's axes.

    The body of an axis is the mass that this axis moves and the next one does not. Its frame has its origin at the
    joint's point of the chain and, with all axes at zero, the directions of the base frame; it turns with the link.
    """

    bodies: tuple[Body, ...]
    drives: tuple[Drive, ...]
    point_masses: tuple[str, ...] = ()  # names of the axes whose bodies have no inertia of their own stated


def tensor(inertia: Inertia) -> Array:
    """Inertia tensor (3, 3) [kg m²] of xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


# --- Accelerations by pose ---
# Parameters of the law `by_pose`, as measured on one arm (olp/timing/acceleration/by_pose.py).


class Swing(NamedTuple):
    """Parameters of axis S. 1/a = fixed + elbow e² + forearm f², with a at most `cap`: inertia over torque, and the
    controller's own limit.

    e: horizontal distance of the elbow from axis S [m]; f: horizontal distance of the point (`ahead`, `above`) [m]
    of the forearm's frame.
    """

    fixed: float  # [s²/rad]
    elbow: float  # [s²/rad/m²]
    forearm: float  # [s²/rad/m²]
    ahead: float  # [m] along the forearm from axis U
    above: float  # [m] across it
    cap: float  # [rad/s²]


class Lean(NamedTuple):
    """Parameters of axis L. a = (1 + both ± gravity) / inertia, divided by the torque; + for leaning forward.

    inertia = fixed + cosine cos U + sine sin U [s²/rad]: axis U alone moves the forearm nearer or further.
    `gravity` and `both` are sums of parts along (sin L, cos L, cos E, sin E), with the forearm's elevation E = U -
    L: the levers of the upper arm and of the forearm, and what slows both directions alike (balancer, friction
    under load).
    """

    fixed: float  # [s²/rad]
    cosine: float  # [s²/rad]
    sine: float  # [s²/rad]
    gravity: tuple[float, float, float, float]  # [1]
    both: tuple[float, float, float, float]  # [1]


class Lift(NamedTuple):
    """Parameters of axis U. a = high - s drop ∓ (lever - s eased) g, with the forearm's horizontal lever g = cos(E
    + offset); - for lifting.

    s = 1 / (1 + exp((start - |g|) / width)) steps to 1 where |g| passes `start`: two levels of acceleration.
    """

    offset: float  # [rad] from the forearm's axis to its centre of mass
    start: float  # [1] share of the full lever
    width: float  # [1]
    high: float  # [rad/s²]
    drop: float  # [rad/s²]
    lever: float  # [rad/s²]
    eased: float  # [rad/s²]


class PoseAccelerations(NamedTuple):
    """Parameters of the first three axes. `ranges`: lowest and highest measured acceleration [rad/s²]; they also
    bound the result outside the measured poses.
    """

    swing: Swing
    lean: Lean
    lift: Lift
    ranges: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
