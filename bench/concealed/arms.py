"""Random six-axis arms: geometry, own kinematics, rigid bodies in MuJoCo, and the robot file that a case carries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
FLANGE = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])  # at zero, docs/robots.md
_AXES = np.array([[0, 0, 1], [0, 1, 0], [0, -1, 0], [-1, 0, 0], [0, -1, 0], [-1, 0, 0]], dtype=float)
NAMES = "SLURBT"
ZONES_MM = (12.5, 25, 50, 100, 200, 300, 400, 500)


@dataclass(frozen=True, slots=True)
class Arm:
    """Lengths [m], masses [kg], rated speeds [rad/s], acceleration limits [rad/s^2] of the axes, tool length [m]."""

    a1: float
    a2: float
    a3: float
    d4: float
    d6: float
    tool: float
    mass: Floats  # (6,) of the links
    load: float  # kg carried at the tool point, always there
    speed: Floats  # (6,)
    acceleration: Floats  # (6,)
    rotor: Floats  # (6,) kg m^2 behind the gears, on the axis' side
    friction: Floats  # (6,) N m, Coulomb, of the body that both simulation and robot know

    @property
    def reach(self) -> float:
        """[m] of the wrist centre from the first axis."""
        return self.a1 + self.a2 + float(np.hypot(self.a3, self.d4))


def random_arm(dice: np.random.Generator) -> Arm:
    """An anthropomorphic arm between 0.9 and 2.6 m of reach, heavier when longer."""
    scale = dice.uniform(0.7, 1.6)
    a2 = scale * dice.uniform(0.6, 0.85)
    mass = scale**2 * np.array([60.0, 40.0, 25.0, 12.0, 6.0, 2.0]) * dice.uniform(0.7, 1.4, 6)
    speed = np.radians([185.0, 175, 195, 380, 390, 580]) * dice.uniform(0.85, 1.15) / scale**0.3
    return Arm(
        a1=scale * dice.uniform(0.08, 0.25),
        a2=a2,
        a3=scale * dice.uniform(0.05, 0.2),
        d4=a2 * dice.uniform(0.85, 1.2),
        d6=dice.uniform(0.08, 0.14),
        tool=dice.uniform(0.05, 0.3),
        mass=mass,
        load=float(scale**2 * dice.uniform(3, 15)),
        speed=speed,
        acceleration=speed / dice.uniform(0.12, 0.3) * dice.uniform(0.9, 1.1, 6),
        rotor=scale**2 * np.array([25.0, 30.0, 12.0, 1.2, 1.0, 0.4]) * dice.uniform(0.8, 1.2, 6),
        friction=np.zeros(6),
    )


def rot(axis: int, angle: Floats) -> Floats:
    """Rotations (…, 3, 3) about a coordinate axis by (…) [rad]."""
    angle = np.asarray(angle, dtype=float)
    result = np.zeros((*angle.shape, 3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    result[..., axis, axis] = 1
    result[..., i, i] = result[..., j, j] = np.cos(angle)
    result[..., i, j], result[..., j, i] = -np.sin(angle), np.sin(angle)
    return result


def forward(arm: Arm, q: Floats) -> tuple[Floats, Floats]:
    """Tool point (n, 3) [m] and rotation (n, 3, 3) of axes (n, 6) [rad]."""
    s, low, u, r, b, t = np.moveaxis(q, -1, 0)
    turn = rot(2, s)
    place = turn @ np.array([arm.a1, 0, 0])
    turn = turn @ rot(1, low)
    place = place + turn @ np.array([0, 0, arm.a2])
    turn = turn @ rot(1, -u)
    place = place + turn @ np.array([arm.d4, 0, arm.a3])
    turn = turn @ rot(0, -r) @ rot(1, -b) @ rot(0, -t) @ FLANGE
    return place + turn[..., 2] * (arm.d6 + arm.tool), turn


def inverse(arm: Arm, place: Floats, turn: Floats) -> Floats:
    """Axes (…, 6) [rad], elbow up, in front, wrist bent one way; nan out of reach. R and T are not unwrapped."""
    wrist = place - turn[..., 2] * (arm.d6 + arm.tool)
    s = np.arctan2(wrist[..., 1], wrist[..., 0])
    x, z = np.hypot(wrist[..., 0], wrist[..., 1]) - arm.a1, wrist[..., 2]
    far, fore = np.hypot(x, z), float(np.hypot(arm.a3, arm.d4))
    with np.errstate(invalid="ignore"):
        lift = np.arccos((arm.a2**2 + far**2 - fore**2) / (2 * arm.a2 * far))
    low = np.pi / 2 - (np.arctan2(z, x) + lift)
    rise = np.arctan2(z - arm.a2 * np.cos(low), x - arm.a2 * np.sin(low))
    phi = np.arctan2(arm.a3, arm.d4) - rise
    rest = np.swapaxes(rot(2, s) @ rot(1, phi), -1, -2) @ turn @ FLANGE.T
    b = -np.arccos(np.clip(rest[..., 0, 0], -1, 1))
    r = -np.arctan2(rest[..., 1, 0], -rest[..., 2, 0])
    t = -np.arctan2(rest[..., 0, 1], rest[..., 0, 2])
    return np.stack([s, low, low - phi, r, b, t], axis=-1)


@dataclass(frozen=True, slots=True)
class Joints:
    """What else a body has in its joints, (6,) each: N m s/rad, N m, and N m/rad between motor and link (inf: none)."""

    viscous: Floats
    coulomb: Floats
    stiffness: Floats


def mjcf(arm: Arm, step: float = 0.002, payload: float = 0.0, joints: Joints | None = None) -> str:
    """The arm as MuJoCo reads it; `payload` [kg] at the tool point."""
    offsets = [(0, 0, 0), (arm.a1, 0, 0), (0, 0, arm.a2), (0, 0, arm.a3), (arm.d4, 0, 0), (arm.d6, 0, 0)]
    reach = [(arm.a1 / 2, 0, 0), (0, 0, arm.a2 / 2), (0, 0, arm.a3), (arm.d4 / 2, 0, 0), (arm.d6 / 2, 0, 0)]
    reach.append((0.02, 0, 0))
    sizes = [0.2, arm.a2, 0.2, arm.d4, 0.1, 0.08]
    text, close = "", ""
    for i in range(6):
        own = arm.mass[i] * sizes[i] ** 2 / 12 + 1e-3
        inertial = (
            f'<inertial mass="{arm.mass[i]}" pos="{reach[i][0]} {reach[i][1]} {reach[i][2]}" '
            f'diaginertia="{own} {own} {own}"/>'
        )
        axis = " ".join(map(str, _AXES[i]))
        loss = "" if joints is None else f' damping="{joints.viscous[i]}" frictionloss="{joints.coulomb[i]}"'
        motor = f'<joint name="{NAMES[i]}" type="hinge" axis="{axis}" armature="{arm.rotor[i]}"{loss}/>'
        place = f'pos="{offsets[i][0]} {offsets[i][1]} {offsets[i][2]}"'
        if joints is not None and np.isfinite(joints.stiffness[i]):
            # The motor turns behind the gears; the link hangs on it by a spring with 3 % damping.
            k = joints.stiffness[i]
            slim = '<inertial mass="0.01" pos="0 0 0" diaginertia="1e-4 1e-4 1e-4"/>'
            spring = f'<joint type="hinge" axis="{axis}" stiffness="{k}" damping="{0.0015 * k}"/>'
            text += f"<body {place}>{slim}{motor}<body>{inertial}{spring}"
            close += "</body></body>"
        else:
            text += f"<body {place}>{inertial}{motor}"
            close += "</body>"
    load = arm.load + payload
    text += f'<body pos="{arm.tool} 0 0"><inertial mass="{load}" pos="0 0 0" diaginertia="1e-3 1e-3 1e-3"/></body>'
    motors = "".join(f'<motor joint="{name}"/>' for name in NAMES)
    return (
        f'<mujoco><option timestep="{step}" integrator="implicitfast"><flag contact="disable"/></option>'
        f"<worldbody>{text}{close}</worldbody><actuator>{motors}</actuator></mujoco>"
    )


def mass_and_gravity(arm: Arm, q: Floats, payload: float = 0.0) -> tuple[Floats, Floats]:
    """Joint-space mass matrices (n, 6, 6) [kg m^2] and gravity torques (n, 6) [N m] of axes (n, 6), from MuJoCo."""
    import mujoco

    model: Any = mujoco.MjModel.from_xml_string(mjcf(arm, payload=payload))
    data: Any = mujoco.MjData(model)
    mass, weight = np.empty((len(q), 6, 6)), np.empty((len(q), 6))
    full = np.empty((6, 6))
    for i, pose in enumerate(q):
        data.qpos[:] = pose
        mujoco.mj_forward(model, data)
        full = _full_mass(mujoco, model, data, full)
        mass[i], weight[i] = full, data.qfrc_bias
    return mass, weight


def _full_mass(mujoco: Any, model: Any, data: Any, full: Floats) -> Floats:
    try:
        mujoco.mj_fullM(model, full, data.qM)
    except (AttributeError, TypeError):  # the argument list changed between versions
        mujoco.mj_fullM(model, data, full)
    return full


def robot_file(arm: Arm, name: str, with_acceleration: bool) -> str:
    """The arm as an olp robot file (docs/robots.md)."""
    limits = [180, 150, 210, 360, 200, 720]
    rows = []
    for i in range(6):
        more = f", acceleration_deg_s2 = {np.degrees(arm.acceleration[i]):.3f}" if with_acceleration else ""
        rows.append(
            f'  {{ name = "{NAMES[i]}", lower_deg = {-limits[i]}, upper_deg = {limits[i]}, '
            f"speed_deg_s = {np.degrees(arm.speed[i]):.3f}{more} }},"
        )
    source = 'limits = "random arm"\nspeed = "random arm"\nlinks = "random arm"\nblend_zones = "random arm"\n'
    if with_acceleration:
        source += 'acceleration = "random arm"\n'
    links = "\n".join(f"{key}_mm = {1000 * getattr(arm, key):.6f}" for key in ("a1", "a2", "a3", "d4", "d6"))
    zones = ", ".join(map(str, ZONES_MM))
    return (
        f'maker = "Concealed"\nmodel = "{name}"\npose_verified = false\nblend_zones_mm = [{zones}]\n\n'
        f"axes = [\n" + "\n".join(rows) + f"\n]\n\n[links]\n{links}\n\n[sources]\n{source}"
    )
