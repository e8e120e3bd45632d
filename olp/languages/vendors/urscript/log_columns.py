"""RTDE recordings of a Universal Robot: radians and metres, axes counted from 0, tool poses with rotation vectors.

The names are those of the RTDE guide of Universal Robots; clients write a vector `actual_q` as `actual_q_0` to `_5`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm
from olp.languages.recorders import ControllerLog
from olp.robots.geometry import angles_from_rotation, rotation_from_quaternion

Floats = NDArray[np.float64]
_AXES = {
    "actual_q": ("q{}_deg", deg),
    "target_q": ("q{}_cmd_deg", deg),
    "actual_qd": ("qd{}_deg_s", deg),
    "actual_current": ("i{}_a", 1.0),
}
_NUMBERED = re.compile(r"(\w+?)_([0-5])")
_POSE = [f"actual_TCP_pose_{i}" for i in range(6)]


class RtdeLog(ControllerLog):
    files = "an RTDE recording (timestamp, actual_q_0 to actual_q_5)"
    joint_names = tuple(
        f"{name}_joint"
        for name in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    )

    def knows(self, names: Sequence[str]) -> bool:
        return {"timestamp", *(f"actual_q_{i}" for i in range(6))} <= set(names)

    def columns(self, cells: Mapping[str, Floats]) -> Mapping[str, Floats]:
        found: dict[str, Floats] = {"t_s": cells["timestamp"]}
        for name, values in cells.items():
            match = _NUMBERED.fullmatch(name)
            if match and match[1] in _AXES:
                called, unit = _AXES[match[1]]
                found[called.format(int(match[2]) + 1)] = values / unit
            elif name != "timestamp" and name not in _POSE:
                found[name] = values
        if all(name in cells for name in _POSE):
            found.update(zip(("x_mm", "y_mm", "z_mm"), (cells[name] / mm for name in _POSE[:3]), strict=True))
            vector = np.stack([cells[name] for name in _POSE[3:]], axis=1)
            half = np.linalg.norm(vector, axis=1, keepdims=True) / 2
            # sin(half) / (2 half) of the vector is the quaternion's, at no turn as well.
            quaternion = np.concatenate([np.cos(half), vector / 2 * np.sinc(half / np.pi)], axis=1)
            angles = angles_from_rotation(rotation_from_quaternion(quaternion)).T / deg
            found.update(zip(("rx_deg", "ry_deg", "rz_deg"), angles, strict=True))
        return found


LOG_COLUMNS = RtdeLog()
