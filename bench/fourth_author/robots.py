"""Arms of this author: serial chains from base to flange, poses and a numeric inverse of many rows at once."""

import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

LIBRARY = Path(__file__).resolve().parents[2] / "olp" / "robots"


@dataclass
class Arm:
    """A serial arm. Lengths in m, angles in rad; `n` axes."""

    name: str
    directions: np.ndarray  # (n, 3) unit vectors at zero
    offsets: np.ndarray  # (n, 3) from the axis before [m]
    flange: np.ndarray  # (3,) from the last axis [m]
    flange_rotation: np.ndarray  # (3, 3)
    speeds: np.ndarray  # (n,) rated [rad/s], [m/s] of a slide
    accelerations: np.ndarray  # (n,) [rad/s^2], [m/s^2] of a slide
    home: np.ndarray  # (n,) a posture whose tool looks down
    payload: float  # rated [kg]
    slides: tuple[bool, ...] = ()
    signs: np.ndarray = field(default_factory=lambda: np.ones(0))
    zeros: np.ndarray = field(default_factory=lambda: np.ones(0))
    library: str | None = None
    tool: float = 0.0  # length along the flange's z [m]

    def __post_init__(self) -> None:
        n = len(self.directions)
        self.slides = self.slides or (False,) * n
        self.signs = self.signs if len(self.signs) else np.ones(n)
        self.zeros = self.zeros if len(self.zeros) else np.zeros(n)

    @property
    def n(self) -> int:
        """Number of axes."""
        return len(self.directions)

    def poses(self, readings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tool positions (m, 3) and rotations (m, 3, 3) of readings (m, n)."""
        angles = self.signs * readings + self.zeros
        rotation = np.broadcast_to(np.eye(3), (len(angles), 3, 3))
        position = np.zeros((len(angles), 3))
        for i in range(self.n):
            position = position + rotation @ self.offsets[i]
            if self.slides[i]:
                position = position + angles[:, i : i + 1] * (rotation @ self.directions[i])
            else:
                rotation = rotation @ turned(self.directions[i], angles[:, i])
        position = position + rotation @ self.flange
        rotation = rotation @ self.flange_rotation
        return position + self.tool * rotation[:, :, 2], rotation

    def jacobian(self, readings: np.ndarray) -> np.ndarray:
        """Numeric Jacobian (m, 6, n): metres and rad per reading."""
        base, rotation = self.poses(readings)
        columns = []
        for i in range(self.n):
            step = np.zeros(self.n)
            step[i] = 1e-6
            p, r = self.poses(readings + step)
            columns.append(
                np.concatenate([(p - base), rotation_vector(r @ rotation.transpose(0, 2, 1))], axis=1) / 1e-6
            )
        return np.stack(columns, axis=2)

    def reach(
        self, position: np.ndarray, rotation: np.ndarray, seed: np.ndarray, rounds: int = 30
    ) -> tuple[np.ndarray, np.ndarray]:
        """Readings (m, n) that hold the poses, from a seed, by damped least squares; which rows arrived."""
        q = np.array(seed, float)
        weight = np.array([1, 1, 1, 0.3, 0.3, 0.3])
        for _ in range(rounds):
            p, r = self.poses(q)
            error = (
                np.concatenate([position - p, rotation_vector(rotation @ r.transpose(0, 2, 1))], axis=1)
                * weight
            )
            if np.abs(error).max() < 1e-9:
                break
            j = self.jacobian(q) * weight[:, None]
            jt = j.transpose(0, 2, 1)
            size = np.minimum((error**2).sum(axis=1), 1.0)
            step = jt @ np.linalg.solve(
                j @ jt + (1e-9 + 1e-2 * size)[:, None, None] * np.eye(6), error[:, :, None]
            )
            q = q + np.clip(step[:, :, 0], -0.4, 0.4)
        p, r = self.poses(q)
        error = np.concatenate([position - p, rotation_vector(rotation @ r.transpose(0, 2, 1))], axis=1)
        return q, np.abs(error).max(axis=1) < 1e-6

    def toml(self) -> str:
        """The robot file that says what a user of this arm knows."""
        axes, joints = list[str](), list[str]()
        for i, slides in enumerate(self.slides):
            unit, scale, limit = ("mm", 1e3, 2000) if slides else ("deg", 180 / np.pi, 400)
            rated, ramp = self.speeds[i] * scale, self.accelerations[i] * scale
            limits = f"lower_{unit} = {-limit}, upper_{unit} = {limit}, speed_{unit}_s = {rated:.6g}"
            axes.append(f'  {{ name = "{i + 1}", {limits}, acceleration_{unit}_s2 = {ramp:.6g} }},')
            place = f"direction = {_list(self.directions[i])}, offset_mm = {_list(1e3 * self.offsets[i])}"
            joints.append(f'  {{ axis = "{i + 1}", {place} }},')
        x, z = (signed_axis(self.flange_rotation[:, k]) for k in (0, 2))
        head = f'maker = "Fourth"\nmodel = "{self.name}"\nkind = "arm"\ncontrollers = ["C4"]\npose_verified = false'
        groups = ("limits", "speed", "acceleration", "chain", "payload")
        return "\n".join(
            [
                *(
                    head,
                    f"payload_kg = {self.payload}",
                    "axes = [",
                    *axes,
                    "]",
                    "[chain]",
                    "joints = [",
                    *joints,
                    "]",
                ),
                f"flange_offset_mm = {_list(1e3 * self.flange)}",
                *(f'flange_x = "{x}"', f'flange_z = "{z}"', "[sources]"),
                *(f'{group} = "made up"' for group in groups),
                "",
            ]
        )


def _list(numbers: np.ndarray) -> list[float]:
    return [round(float(x), 6) for x in numbers]


def signed_axis(vector: np.ndarray) -> str:
    """`+x`, `-z`, … of a unit vector along an axis."""
    k = int(np.argmax(np.abs(vector)))
    return ("+" if vector[k] > 0 else "-") + "xyz"[k]


def turned(direction: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotations (m, 3, 3) about a unit vector by angles (m,) [rad]."""
    x, y, z = direction
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    a = angle[:, None, None]
    return np.eye(3) + np.sin(a) * k + (1 - np.cos(a)) * (k @ k)


def rotation_vector(r: np.ndarray) -> np.ndarray:
    """Axis times angle [rad] (m, 3) of rotations (m, 3, 3)."""
    v = np.stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], axis=1) / 2
    sine = np.linalg.norm(v, axis=1)
    angle = np.arctan2(sine, (np.trace(r, axis1=1, axis2=2) - 1) / 2)
    v = v * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 1.0)[:, None]
    for k in np.flatnonzero(
        (sine < 1e-6) & (angle > 3)
    ):  # half a turn: the axis is the longest column of R + 1
        column = max((r[k] + np.eye(3)).T, key=np.linalg.norm)
        v[k] = np.pi * column / np.linalg.norm(column)
    return v


def euler(r: np.ndarray) -> np.ndarray:
    """rx, ry, rz [deg] (m, 3) with R = Rz Ry Rx."""
    ry = np.arcsin(np.clip(-r[:, 2, 0], -1, 1))
    rx = np.arctan2(r[:, 2, 1], r[:, 2, 2])
    rz = np.arctan2(r[:, 1, 0], r[:, 0, 0])
    return np.degrees(np.stack([rx, ry, rz], axis=1))


_DOWN = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]])
_X, _Y, _Z = np.eye(3)


def six(
    name: str, lengths: tuple[float, ...], speeds: tuple[float, ...], times: tuple[float, ...], payload: float
) -> Arm:
    """A six-axis arm: height, shoulder, upper arm, elbow, forearm, hand [m]; rated deg/s; seconds to them."""
    h, a1, a2, a3, d4, d6 = lengths
    rated = np.radians(speeds)
    return Arm(
        name,
        np.array([_Z, _Y, _Y, _X, _Y, _X]),
        np.array([[0, 0, h], [a1, 0, 0], [0, 0, a2], [0, 0, a3], [d4, 0, 0], [0, 0, 0]]),
        np.array([d6, 0, 0]),
        np.array([[0.0, 0, 1], [0, -1, 0], [1, 0, 0]]).T,
        rated,
        rated / np.array(times),
        np.radians([0, 10.0, 20, 0, 60, 0]),
        payload,
    )


def cobot() -> Arm:
    """A cobot with three parallel axes and an offset wrist."""
    rated = np.radians([150, 150, 180, 200, 200, 220])
    return Arm(
        "cobot",
        np.array([_Z, _Y, _Y, _Y, _Z, _Y]),
        np.array([[0, 0, 0.18], [0, 0.14, 0], [0.61, -0.12, 0], [0.57, 0, 0], [0, 0.11, 0], [0, 0, -0.12]]),
        np.array([0, 0.11, 0]),
        np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]),
        rated,
        np.full(6, 6.0),
        np.radians([0, -90, 100, -100, -90, 90]),
        10,
    )


def seven() -> Arm:
    """A seven-axis arm with a redundant elbow."""
    rated = np.radians([130, 130, 150, 150, 170, 170, 200])
    return Arm(
        "seven",
        np.array([_Z, _Y, _Z, -_Y, _Z, _Y, _Z]),
        np.array([[0, 0, 0.36], [0, 0, 0], [0, 0, 0], [0, 0, 0.42], [0, 0, 0], [0, 0, 0.4], [0, 0, 0]]),
        np.array([0, 0, 0.13]),
        np.eye(3),
        rated,
        rated / 0.3,
        np.radians([0, 35, 0, -80, 0, 65, 0]),
        14,
    )


def scara() -> Arm:
    """A four-axis arm with a slide."""
    rated = np.array([6.5, 7.5, 1.1, 20])
    return Arm(
        "scara",
        np.array([_Z, _Z, _Z, _Z]),
        np.array([[0, 0, 0.4], [0.4, 0, 0], [0.3, 0, 0], [0, 0, 0]]),
        np.zeros(3),
        _DOWN,
        rated,
        rated / np.array([0.25, 0.22, 0.1, 0.2]),
        np.array([-0.5, 1.0, -0.2, 0.0]),
        5,
        slides=(False, False, True, False),
    )


def from_library(name: str, home: tuple[float, ...], seconds: float) -> Arm:
    """An arm of olp's library, from its file and the frames of docs/robots.md; accelerations are this author's."""
    data = tomllib.loads((LIBRARY / f"{name}.toml").read_text())
    links = data["links"]
    a1, a2, a3, d4, d6 = (links[k] / 1e3 for k in ("a1_mm", "a2_mm", "a3_mm", "d4_mm", "d6_mm"))
    below = links.get("origin_below_mm", 0) / 1e3
    rated = np.radians([axis["speed_deg_s"] for axis in data["axes"]])
    return Arm(
        name.replace("/", "-"),
        np.array([_Z, _Y, -_Y, -_X, -_Y, -_X]),
        np.array([[0, 0, below], [a1, 0, 0], [0, 0, a2], [0, 0, a3], [d4, 0, 0], [0, 0, 0]]),
        np.array([d6, 0, 0]),
        np.array([[0.0, 0, 1], [0, -1, 0], [1, 0, 0]]).T,
        rated,
        rated / seconds,
        np.radians(home),
        data.get("payload_kg", 20.0),
        signs=np.array(links.get("signs", [1] * 6), float),
        zeros=np.radians(links.get("zero_deg", [0] * 6)),
        library=name,
    )


def all_arms() -> list[Arm]:
    """Every arm, own ones first."""
    return [
        six(
            "heavy",
            (0.62, 0.33, 1.15, -0.05, 1.25, 0.22),
            (110, 105, 110, 170, 165, 240),
            (0.55, 0.6, 0.5, 0.4, 0.35, 0.3),
            210,
        ),
        six(
            "bench",
            (0.33, 0.05, 0.34, 0.03, 0.33, 0.08),
            (370, 310, 400, 420, 420, 700),
            (0.25, 0.25, 0.22, 0.2, 0.18, 0.15),
            6,
        ),
        six(
            "welder",
            (0.45, 0.17, 0.61, 0.17, 0.69, 0.1),
            (200, 180, 190, 400, 400, 600),
            (0.4, 0.45, 0.35, 0.3, 0.25, 0.2),
            12,
        ),
        cobot(),
        seven(),
        scara(),
        from_library("kuka/kr16-2", (0, -70, 100, 0, 60, 170), 0.45),
        from_library("fanuc/m-20ia", (0, 10, 0, 0, -80, 0), 0.4),
        from_library("abb/irb2600-12-1.65", (0, 10, 10, 0, 70, 170), 0.35),
        from_library("yaskawa/gp25", (0, 10, -10, 0, -80, 0), 0.38),
        from_library("kuka/kr210-2", (0, -70, 100, 0, 60, 170), 0.6),
    ]
