"""Functions that olp writes into a script where URScript has no word of its own; the reader knows them again."""

from __future__ import annotations

from typing import Final

from olp.ir.expressions import Expression, Function, Member

# Angles of a pose [deg], R = Rz(rz) Ry(ry) Rx(rx): the manual's roll, pitch and yaw.
TEXTS: Final = {
    "olp_rx": (
        "def olp_rx(pose):",
        "  local rpy = rotvec2rpy([pose[3], pose[4], pose[5]])",
        "  return r2d(rpy[0])",
        "end",
    ),
    "olp_ry": (
        "def olp_ry(pose):",
        "  local rpy = rotvec2rpy([pose[3], pose[4], pose[5]])",
        "  return r2d(rpy[1])",
        "end",
    ),
    "olp_rz": (
        "def olp_rz(pose):",
        "  local rpy = rotvec2rpy([pose[3], pose[4], pose[5]])",
        "  return r2d(rpy[2])",
        "end",
    ),
    "olp_pose": (
        "def olp_pose(x, y, z, rx, ry, rz):",
        "  local turn = rpy2rotvec([d2r(rx), d2r(ry), d2r(rz)])",
        "  return p[x * 0.001, y * 0.001, z * 0.001, turn[0], turn[1], turn[2]]",
        "end",
    ),
    "olp_trunc": (
        "def olp_trunc(x):",
        "  if (x < 0):",
        "    return ceil(x)",
        "  end",
        "  return floor(x)",
        "end",
    ),
    "olp_round": (
        "def olp_round(x):",
        "  if (x < 0):",
        "    return ceil(x - 0.5)",
        "  end",
        "  return floor(x + 0.5)",
        "end",
    ),
    "olp_min": ("def olp_min(a, b):", "  if (a < b):", "    return a", "  end", "  return b", "end"),
    "olp_max": ("def olp_max(a, b):", "  if (a > b):", "    return a", "  end", "  return b", "end"),
}
_FUNCTIONS: Final = {
    "olp_pose": "pose-angles",
    "olp_trunc": "trunc",
    "olp_round": "round",
    "olp_min": "min",
    "olp_max": "max",
}
WORDS: Final = {neutral: name for name, neutral in _FUNCTIONS.items()}
COUNTER: Final = "olp_left"  # [s] that a wait may still last


def meaning(name: str, arguments: tuple[Expression, ...]) -> Expression:
    """What a call of one of them computes."""
    if name in _FUNCTIONS:
        return Function(_FUNCTIONS[name], arguments)
    return Member(arguments[0], name.removeprefix("olp_"))
