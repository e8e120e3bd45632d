"""Which numbers of the robots nobody published: a time that rests on them is one that rests on an assumption."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from olp.ir.program import Path
from olp.runtime.plan import PATHS, BlendCode, Plan

# Groups of a robot file's `inferred`, as its reader would say them, and what makes a time depend on them.
_OF_JOINT_MOVES = {"speed": "axis speeds", "acceleration": "axis accelerations"}
_OF_LINES = {"linear_acceleration": "acceleration of linear moves"}
_OF_CORNERS = {"blend_zones": "zones of the position levels"}


def report_inferred(plan: Plan, moving: NDArray[np.bool_], report: Callable[[str], None]) -> None:
    """Calls `report` with one sentence per robot whose inferred numbers were used; `moving` (m,): rows that move."""
    moves = plan.moves
    joint = moves.path == PATHS.index(Path.JOINT)
    told: dict[str, dict[str, None]] = {}
    for index, robot in enumerate(plan.robots):
        if robot is None or not robot.inferred:
            continue
        mine = moving & (moves.mechanism == index)
        used = {
            **(_OF_JOINT_MOVES if (mine & joint).any() else {}),
            **(_OF_LINES if (mine & ~joint).any() else {}),
            **(_OF_CORNERS if (mine & (moves.blend_code == BlendCode.ZONE)).any() else {}),
        }
        words = told.setdefault(robot.name, {})
        words.update(dict.fromkeys(text for group, text in used.items() if group in robot.inferred))
    for name, words in told.items():
        if words:
            report(f"inferred, not published, for {name}: {', '.join(words)} (olp robots {name} -v)")
