"""Logs of fanuc_motion_program_exec (Rensselaer Polytechnic Institute): the KAREL program that it runs beside a motion.

It writes whole milliseconds and the axes as the pendant shows them, in degrees: `J1` to `J6`, or `J11` to `J16` and
`J21` to `J26` for two groups, of which the first is read.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from olp.languages.recorders import ControllerLog

Floats = NDArray[np.float64]
_GROUPS = [[f"J{i}" for i in range(1, 7)], [f"J1{i}" for i in range(1, 7)]]
_MS = 1e-3  # [s]


class KarelLog(ControllerLog):
    files = (
        "a log of fanuc_motion_program_exec (timestamp in milliseconds, J1 to J6 or, of group 1, J11 to J16)"
    )

    def knows(self, names: Sequence[str]) -> bool:
        numbered = {"cmdnum", "cmd_num"} & set(names)
        return "timestamp" in names and not numbered and any(set(group) <= set(names) for group in _GROUPS)

    def columns(self, cells: Mapping[str, Floats]) -> Mapping[str, Floats]:
        if (cells["timestamp"] % 1 != 0).any():
            return cells  # no count of milliseconds: another recorder's names
        group = next(group for group in _GROUPS if set(group) <= set(cells))
        renamed = {axis: f"q{number}_deg" for number, axis in enumerate(group, 1)}
        rest = {renamed.get(name, name): values for name, values in cells.items() if name != "timestamp"}
        return {"t_s": cells["timestamp"] * _MS, **rest}


LOG_COLUMNS = KarelLog()
