"""Units at the edge: multiply to come in, divide to go out. Inside everything is SI."""

from __future__ import annotations

from math import pi
from typing import Final

mm: Final = 1e-3  # [m]
um: Final = 1e-6  # [m]
deg: Final = pi / 180.0  # [rad]
percent: Final = 1e-2  # [1]
ms: Final = 1e-3  # [s]
minute: Final = 60.0  # [s]
