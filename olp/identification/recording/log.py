"""The time series of a recording in columns, SI inside."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Log:
    """n samples in order of time, k axes; nan where nothing was written, None where the file has no such column."""

    time: Floats  # (n,) [s] on the recorder's own clock
    q: Floats  # (n, k) [rad | m] measured
    slides: tuple[bool, ...]  # (k,) which axes are lengths
    command: Floats | None = None  # (n, k) [rad | m]
    speed: Floats | None = None  # (n, k) [rad/s | m/s]
    torque: Floats | None = None  # (n, k) [Nm | N]
    current: Floats | None = None  # (n, k) [A]
    position: Floats | None = None  # (n, 3) [m] of the tool centre point in the base frame
    angles: Floats | None = None  # (n, 3) [rad] Rx, Ry, Rz with R = Rz Ry Rx
    move: NDArray[np.int64] | None = None  # (n,) number of the executing move, -1 for none
    covariates: Mapping[str, Floats] = field(
        default_factory=dict
    )  # other numbers, in the units of their names
    texts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    file: str = ""

    def __len__(self) -> int:
        return len(self.time)

    @property
    def period(self) -> float:
        """[s] between samples, the median; nan for fewer than two."""
        return float(np.median(np.diff(self.time))) if len(self) > 1 else float("nan")

    @property
    def gaps(self) -> NDArray[np.intp]:
        """Samples after which more than 2.5 periods pass."""
        return (
            np.nonzero(np.diff(self.time) > 2.5 * self.period)[0] if len(self) > 1 else np.zeros(0, np.intp)
        )
