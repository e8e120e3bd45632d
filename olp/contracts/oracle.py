"""Geometry and numbers that share no code with what they judge: readers, writers, interpreter and kinematics.

Rotations are built from the definitions in the makers' manuals, with sines and cosines, so that a mistake in
`olp.robots.geometry` cannot hide here. Lengths in metres, angles in radians.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
DEG: Final = math.pi / 180.0
MM: Final = 0.001


def turned(axis: str, angle: float) -> Array:
    """(3, 3): a turn by `angle` [rad] about x, y or z, right-handed."""
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    made = np.eye(3)
    made[j, j] = made[k, k] = math.cos(angle)
    made[k, j] = math.sin(angle)
    made[j, k] = -math.sin(angle)
    return made


def fixed_xyz(rx: float, ry: float, rz: float) -> Array:
    """(3, 3) = Rz Ry Rx, the angles of olp's neutral poses [rad]."""
    return turned("z", rz) @ turned("y", ry) @ turned("x", rx)


def frame(x: float, y: float, z: float, rx: float, ry: float, rz: float) -> Array:
    """(4, 4) of x y z [mm] and rx ry rz [deg]."""
    made = np.eye(4)
    made[:3, :3] = fixed_xyz(rx * DEG, ry * DEG, rz * DEG)
    made[:3, 3] = np.array([x, y, z]) * MM
    return made


def of_quaternion(w: float, x: float, y: float, z: float) -> Array:
    """(3, 3) of a unit quaternion."""
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def of_vector(x: float, y: float, z: float) -> Array:
    """(3, 3) of a rotation vector [rad], by Rodrigues' formula."""
    angle = math.sqrt(x * x + y * y + z * z)
    if angle < 1e-12:
        return np.eye(3)
    a, b, c = x / angle, y / angle, z / angle
    cross = np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    made: Array = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * (cross @ cross)
    return made


def angle_between(a: Array, b: Array) -> float:
    """[rad] that turns the rotation `a` (3, 3) into `b`; exact for small angles."""
    chord = float(np.linalg.norm(a - b)) / math.sqrt(8.0)
    return 2.0 * math.asin(min(chord, 1.0))


class Circle(NamedTuple):
    """An arc: its centre (3,) [m] and its axis (3,), a unit vector about which it turns right-handed."""

    centre: Array
    axis: Array


def circle(start: Array, via: Array, end: Array) -> Circle:
    """The arc from `start` through `via` to `end`, each (3,) [m]."""
    a, b = via - start, end - start
    normal = np.cross(a, b)
    square = float(normal @ normal)
    to_centre = np.cross(normal, a) * float(b @ b) + np.cross(b, normal) * float(a @ a)
    return Circle(start + to_centre / (2.0 * square), normal / math.sqrt(square))


# --- numbers of a text ------------------------------------------------------------------------------------

# No digit that belongs to a name (J1, P2), to a date or to a version.
_NUMBER: Final = re.compile(r"(?<![\w.\-:/])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w:/])")


def numbers_of(text: str) -> list[float]:
    """All numbers of a text in order of writing, a sign in parentheses with them."""
    return [float(found) for found in _NUMBER.findall(text)]


Turn = Callable[..., Array]


class PoseSpelling(NamedTuple):
    """How a language writes a pose: metres per unit, how many numbers turn it, and what they mean."""

    unit: float
    width: int
    turn: Turn


def _angles(scale: float, order: str, *, reverse: bool = False) -> Turn:
    """Turns about the axes `order`, one after the other in the moving frame; `reverse`: written last first."""

    def made(*values: float) -> Array:
        given = values[::-1] if reverse else values
        return reduce(np.matmul, (turned(a, v * scale) for a, v in zip(order, given, strict=True)))

    return made


_TURNS: Final[Mapping[str, tuple[int, Turn]]] = {
    # Rz Ry Rx is a turn about z, then y, then x of the moving frame; written rx ry rz or, as KRL does, rz ry rx.
    "rx ry rz [deg]": (3, _angles(DEG, "zyx", reverse=True)),
    "rz ry rx [deg]": (3, _angles(DEG, "zyx")),
    "rx ry rz [rad]": (3, _angles(1.0, "zyx", reverse=True)),
    "rz ry rx [rad]": (3, _angles(1.0, "zyx")),
    "x y' z'' [deg]": (3, _angles(DEG, "xyz")),
    "z y' z'' [deg]": (3, _angles(DEG, "zyz")),
    "z x' z'' [deg]": (3, _angles(DEG, "zxz")),
    "quaternion w x y z": (4, of_quaternion),
    "quaternion x y z w": (4, lambda x, y, z, w: of_quaternion(w, x, y, z)),
    "rotation vector [rad]": (3, of_vector),
    "rotation vector [deg]": (3, lambda x, y, z: of_vector(x * DEG, y * DEG, z * DEG)),
}
SPELLINGS: Final[Mapping[str, PoseSpelling]] = {
    f"{unit}, {turn}": PoseSpelling(size, count, made)
    for unit, size in (("mm", MM), ("m", 1.0), ("um", 1e-6))
    for turn, (count, made) in _TURNS.items()
}


def is_written(numbers: Sequence[float], pose: Array, spelling: PoseSpelling, length: float = 2e-6) -> bool:
    """Whether the pose (4, 4) stands among the numbers of a text: within `length` [m] and 2e-5 rad."""
    if len(numbers) < 3 + spelling.width:
        return False
    places = np.lib.stride_tricks.sliding_window_view(np.array(numbers), 3) * spelling.unit
    near = np.nonzero((np.abs(places - pose[:3, 3]) <= length).all(axis=1))[0]
    turns = (numbers[at + 3 : at + 3 + spelling.width] for at in near.tolist())
    return any(
        len(turn) == spelling.width and angle_between(spelling.turn(*turn), pose[:3, :3]) < 2e-5
        for turn in turns
    )


def spelling_of(text: str, poses: Sequence[Array], least: int = 2) -> tuple[str, PoseSpelling] | None:
    """How a text writes poses that are known to stand in it; None where fewer than `least` are found any way."""
    numbers = numbers_of(text)
    counts = {name: sum(is_written(numbers, pose, one) for pose in poses) for name, one in SPELLINGS.items()}
    best = max(counts, key=lambda name: counts[name])
    return (best, SPELLINGS[best]) if counts[best] >= least else None
