"""Between the poses of the flange and those of the tool centre point."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.robots.geometry import Pose, compose

Array = NDArray[np.float64]


def with_tool(positions: ArrayLike, rotations: ArrayLike, tool: Pose) -> tuple[Array, Array]:
    """Poses of the tool centre point, (n, 3) [m] and (n, 3, 3), from those of the flange."""
    return compose(positions, rotations, tool.position, tool.rotation)


def without_tool(positions: ArrayLike, rotations: ArrayLike, tool: Pose) -> tuple[Array, Array]:
    """Poses of the flange, (n, 3) [m] and (n, 3, 3), from those of the tool centre point."""
    off = tool.inverse()
    return compose(positions, rotations, off.position, off.rotation)
