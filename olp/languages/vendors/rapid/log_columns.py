"""Logs of abb_motion_program_exec (Rensselaer Polytechnic Institute): seconds, the command's number, axes in degrees.

Its first versions call the number cmd_num.

The number counts the commands of the program from 0, waits included; it is not the number of a move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from olp.languages.recorders import ControllerLog

Floats = NDArray[np.float64]
_AXES = [f"J{i}" for i in range(1, 7)]


class MotionProgramLog(ControllerLog):
    files = "a log of abb_motion_program_exec (timestamp, cmdnum, J1 to J6)"

    def knows(self, names: Sequence[str]) -> bool:
        return {"timestamp", *_AXES} <= set(names) and bool({"cmdnum", "cmd_num"} & set(names))

    def columns(self, cells: Mapping[str, Floats]) -> Mapping[str, Floats]:
        renamed = {"timestamp": "t_s", "cmd_num": "cmdnum", **{axis: f"q{axis[1:]}_deg" for axis in _AXES}}
        return {renamed.get(name, name): values for name, values in cells.items()}


LOG_COLUMNS = MotionProgramLog()
