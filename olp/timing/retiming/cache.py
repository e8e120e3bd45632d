"""Rows that an earlier plan of the same text held too: what was found along them holds still."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from olp.core import memory_limit
from olp.robots.robot import Robot
from olp.runtime.plan import Plan
from olp.timing.retiming.limits import Floats, PathLimits

Rows = NDArray[np.intp]

_FOUND: Final = (
    "known", "speed", "axis", "place", "acceleration", "paced", "singular", "nearness", "lost", "outside",
)  # fmt: skip


class RetimingCache:
    """What is known of `rows` (r,) of a plan that are looked at `samples` times each, if anybody remembers.

    A row is known where all numbers that decide about it are the same bit for bit. Rows come and go between others, so
    those before the first and behind the last change are compared.
    """

    def __init__(
        self, plan: Plan, robot: Robot, samples: int, rows: Rows, speeds: Floats, pushes: Floats
    ) -> None:
        self._rows, self._robot = rows, robot
        self._shelf = memory_limit.shelf("rows along paths")
        if self._shelf is not None:
            self._key = (robot.name, samples)
            self._asked = _bits(_asked(plan, robot, rows, speeds, pushes))

    def fresh(self, result: PathLimits) -> Rows:
        """The rows of which nothing is known; what is known of the others is put into `result`."""
        before: Any = None if self._shelf is None else self._shelf.get(self._key)
        if before is None or before[0] is not self._robot or before[1].dtype != self._asked.dtype:
            return self._rows
        _, asked, found = before
        count = min(len(asked), len(self._asked))
        head = _same(asked[:count], self._asked[:count])
        left = count - head
        tail = _same(asked[len(asked) - left :][::-1], self._asked[len(self._asked) - left :][::-1])
        for place, name in enumerate(_FOUND):
            column = getattr(result, name)
            column[self._rows[:head]] = found[:head, place]
            if tail:
                column[self._rows[-tail:]] = found[-tail:, place]
        return self._rows[head : len(self._rows) - tail]

    def keep(self, result: PathLimits) -> None:
        """What was found is known from now on."""
        if self._shelf is not None:
            found = np.stack([getattr(result, name)[self._rows] for name in _FOUND], axis=1)
            self._shelf.put(self._key, (self._robot, self._asked, found))


def _asked(plan: Plan, robot: Robot, rows: Rows, speeds: Floats, pushes: Floats) -> Floats:
    """(r, n): every number that what is found along a row depends on."""
    moves, positions = plan.moves, plan.positions
    via = moves.via[rows]
    third = np.where((via >= 0)[:, None], positions.position[via], np.nan)
    ends = [
        part[at[rows]]
        for at in (moves.start, moves.target)
        for part in (positions.position, positions.quaternion, positions.axes[:, : len(robot.axes)])
    ]
    single = (moves.path, moves.before, moves.length, moves.angle, speeds, pushes)
    columns = np.stack([np.asarray(one[rows], dtype=np.float64) for one in single], axis=1)
    return np.concatenate((*ends, third, columns), axis=1)


def _bits(table: Floats) -> NDArray[np.void]:
    """Each row of a table as one thing, so that nan is equal to itself."""
    whole = np.ascontiguousarray(table)
    bits: NDArray[np.void] = whole.view(np.dtype((np.void, whole.itemsize * whole.shape[1])))[:, 0]
    return bits


def _same(first: NDArray[np.void], second: NDArray[np.void]) -> int:
    """How many rows are the same from the beginning on."""
    differ = np.flatnonzero(first != second)
    return int(differ[0]) if len(differ) else len(first)
