"""Taught and named positions of a routine, in columns: a CAM job has 100,000 of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.fast_dataclass import fast_init
from olp.core.units import deg, mm
from olp.ir.expressions import Store

Floats = NDArray[np.float64]
_FLAGS = 24  # of an arm's posture, as a job has them


class PointKind(StrEnum):
    """What the numbers of a position mean."""

    PULSE = "pulse"  # motor pulses per axis
    JOINT = "joint"  # axis angles [rad] or slides [m]
    POSE = "pose"  # x y z [m], rx ry rz [rad] with R = Rz(rz) Ry(ry) Rx(rx); a seventh value is an axis [rad]


class Sector(NamedTuple):
    """Where an axis stands [rad]: from `low` to below `high`, either of which may be infinite. `axis` counts from 0."""

    axis: int
    low: float
    high: float


def sectors_of_turns(turns: Iterable[tuple[int, int]]) -> tuple[Sector, ...]:
    """Where axes (from 0) stand that count turns by number: turn n is 360 n - 180 to 360 n + 180 deg.

    An axis that counts none needs no sector: no turn is what a pose alone means.
    """
    return tuple(Sector(axis, (2 * n - 1) * math.pi, (2 * n + 1) * math.pi) for axis, n in turns if n)


@dataclass(frozen=True, slots=True)
class PointState:
    """What holds for a run of points: how to read the numbers, in which frame, with which tool.

    `configuration`: the controller's arm flags (RCONF) or () when none were given. `sectors`: where axes
    stand, for languages that tell turns by signs, by quarters or by their number.
    `own`: how many of a point's numbers are the arm's, where external axes (E1, E2, E3) follow, written in `units`
    (mm or deg); 0: all are.
    """

    kind: PointKind
    frame: str = "pulse"  # pulse, joint, base, robot, user, tool or master-tool
    user: int | None = None
    tool: int = 0
    configuration: tuple[int, ...] = ()
    outside_limits: bool = False
    sectors: tuple[Sector, ...] = ()
    own: int = 0
    units: tuple[str, ...] = ()

    def at(self, frame: str, user: int | None, tool: int) -> PointState:
        """The same in another frame and with another tool: one object for each, because every move asks."""
        key = (id(self), frame, user, tool)
        known = _elsewhere.get(key)
        if known is None or known[0] is not self:
            if len(_elsewhere) >= _MOST_KNOWN:
                _elsewhere.clear()
            known = _elsewhere[key] = (self, replace(self, frame=frame, user=user, tool=tool))
        return known[1]


_MOST_KNOWN = 4096
# By identity, since comparing them costs more than making one.
_elsewhere: dict[tuple[int, str, int | None, int], tuple[PointState, PointState]] = {}


@fast_init
@dataclass(frozen=True, slots=True)
class Point:
    """One position. `values`: pulses, or metres and radians; nan where a field was left empty."""

    number: int
    values: tuple[float, ...]
    state: PointState
    line: int


@dataclass(frozen=True, slots=True)
class PointBlock:
    """All positions of one family of a routine, in order of writing.

    `values` (n, width): nan where a row is shorter. `state` (n,): index into `PointTable.states`.
    `taught`: local to the routine (C, BC, EC); otherwise global variables that the routine sets when it is loaded.
    """

    store: Store
    taught: bool
    numbers: NDArray[np.int64]
    values: NDArray[np.float64]
    state: NDArray[np.int32]
    lines: NDArray[np.int32]
    rows: Mapping[int, int] = field(default_factory=dict)  # number -> row, the last one written counts

    def __len__(self) -> int:
        return len(self.numbers)


@dataclass(frozen=True, slots=True)
class PointTable:
    """The positions of a routine by (store, taught). `names`: what it calls the taught ones of the robot, by number."""

    states: tuple[PointState, ...] = ()
    blocks: Mapping[tuple[Store, bool], PointBlock] = field(default_factory=dict)
    names: Mapping[int, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return sum(len(block) for block in self.blocks.values())

    def find(self, store: Store, taught: bool, number: int) -> Point | None:
        """The position, or None when the routine does not define it."""
        block = self.blocks.get((store, taught))
        row = None if block is None else block.rows.get(number)
        return None if block is None or row is None else self._point(block, row)

    def __iter__(self) -> Iterator[tuple[Store, bool, Point]]:
        for (store, taught), block in self.blocks.items():
            for row in range(len(block)):
                yield store, taught, self._point(block, row)

    def _point(self, block: PointBlock, row: int) -> Point:
        values = tuple(block.values[row].tolist())
        return Point(int(block.numbers[row]), values, self.states[block.state[row]], int(block.lines[row]))


def written_poses(places: Floats, angles: Floats, tool: int, posture: tuple[int, ...]) -> PointTable:
    """Robot positions 0, 1, … at `places` (n, 3) [m] with `angles` (n, 3) [rad], in the robot's base.

    Rounded as jobs are written, to micrometres and a ten-thousandth of a degree, so that what is read again is the
    same number. `posture`: the first flags of the arm; those after them are 0.
    """
    count = len(places)
    values = np.concatenate([np.round(places / mm, 3) * mm, np.round(angles / deg, 4) * deg], axis=1)
    nothing = np.zeros(count, dtype=np.int32)
    state = PointState(PointKind.POSE, "robot", None, tool, posture + (0,) * (_FLAGS - len(posture)))
    rows = {number: number for number in range(count)}
    block = PointBlock(Store.ROBOT, True, np.arange(count), values, nothing, nothing, rows)
    return PointTable((state,), {(Store.ROBOT, True): block})
