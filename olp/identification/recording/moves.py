"""The measured moves of a recording in columns, SI inside."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
KINDS: Final = ("joint", "linear", "circular", "wait")
JOINT, LINEAR, CIRCULAR, WAIT = range(len(KINDS))


@dataclass(frozen=True, slots=True, eq=False)
class RecordedMoves:
    """n executed moves in order; nan where nothing was written. `docs/recording.md` says what each column means.

    `start_angles`, `end_angles`: Rx, Ry, Rz with R = Rz Ry Rx. `joints_*` (n, k): k = 0 without joint points.
    `blend` is 0 where neither radius nor level is written, nan where only a level says how the end is passed.
    """

    move: NDArray[np.int64]  # the file's own numbers
    kind: NDArray[np.int8]  # index into KINDS
    duration: Floats  # [s] measured
    sim: Floats  # [s] of the judged simulation
    start: Floats  # (n, 3) [m]
    end: Floats  # (n, 3) [m]
    via: Floats  # (n, 3) [m]
    start_angles: Floats  # (n, 3) [rad]
    end_angles: Floats  # (n, 3) [rad]
    joints_start: Floats  # (n, k) [rad | m]
    joints_end: Floats  # (n, k) [rad | m]
    slides: tuple[bool, ...]  # (k,) which axes are lengths
    speed: Floats  # [m/s]
    speed_fraction: Floats  # [1] of the axes' rated speed
    acceleration: Floats  # [m/s²] that the simulation used
    acceleration_fraction: Floats  # [1] of rated
    blend: Floats  # [m]
    level: NDArray[np.int8]  # position level 0..8, -1 where none is written
    t_start: Floats  # [s] on the recorder's clock
    cycle: NDArray[np.int64]  # -1 where none is written
    line: NDArray[np.int64]  # 1-based, 0 where none is written
    job: tuple[str, ...]
    payload: Floats  # [kg]
    payload_inertia: Floats  # [kg m²]
    covariates: Mapping[str, Floats] = field(
        default_factory=dict
    )  # other numbers, in the units of their names
    texts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # other texts
    row: NDArray[np.int64] = field(
        default_factory=lambda: np.zeros(0, dtype=np.int64)
    )  # line in the file, 0: none
    given: tuple[str, ...] = ()  # the names of the columns that the file has
    sim_payload: Floats = field(
        default_factory=lambda: np.zeros(0)
    )  # [kg] that the judged simulation was told
    sim_payload_inertia: Floats = field(default_factory=lambda: np.zeros(0))  # [kg m²] likewise
    override: Floats = field(default_factory=lambda: np.zeros(0))  # [1] under which the robot ran
    sim_override: Floats = field(
        default_factory=lambda: np.zeros(0)
    )  # [1] under which the judged simulation did

    def __post_init__(self) -> None:
        for name in ("sim_payload", "sim_payload_inertia", "override", "sim_override"):
            if len(getattr(self, name)) != len(self.move):
                object.__setattr__(self, name, np.full(len(self.move), np.nan))

    def __len__(self) -> int:
        return len(self.move)

    def take(self, rows: NDArray[np.intp]) -> RecordedMoves:
        """These rows, in this order."""
        chosen: dict[str, Any] = {"job": tuple(self.job[i] for i in rows.tolist())}
        for name in self.__slots__:
            values = getattr(self, name)
            if isinstance(values, np.ndarray) and len(values) == len(self):
                chosen[name] = values[rows]
        chosen["covariates"] = {name: values[rows] for name, values in self.covariates.items()}
        chosen["texts"] = {name: tuple(words[i] for i in rows.tolist()) for name, words in self.texts.items()}
        return replace(self, **chosen)

    @property
    def kinds(self) -> tuple[str, ...]:
        return tuple(KINDS[code] for code in self.kind.tolist())

    @property
    def measured(self) -> NDArray[np.bool_]:
        """(n,): which moves have a duration; the others are there to be predicted."""
        return ~np.isnan(self.duration)

    @property
    def has_points(self) -> NDArray[np.bool_]:
        """(n,): which moves have both tool points."""
        return _whole_points(self.start, self.end)

    @property
    def has_joints(self) -> NDArray[np.bool_]:
        """(n,): which moves have both joint points."""
        if not self.slides:
            return np.zeros(len(self), dtype=bool)
        return _whole_points(self.joints_start, self.joints_end)

    @property
    def played(self) -> Floats:
        """(n,) [1] the override under which each move ran; 1 where none is written."""
        return np.where(self.override > 0, self.override, 1.0)

    @property
    def chord(self) -> Floats:
        """(n,) [m] straight from start to end, nan without tool points."""
        length: Floats = np.linalg.norm(self.end - self.start, axis=1)
        return length

    @property
    def stops(self) -> NDArray[np.bool_]:
        """(n,): which moves end in an exact stop. `corner`, which `olp recording from-log` writes, may say untagged."""
        silent = np.array([word == "untagged" for word in self.texts.get("corner", ())] or [False])
        stops: NDArray[np.bool_] = ((self.level == 0) | ((self.level < 0) & (self.blend == 0.0))) & ~silent
        return stops

    def programmed(self) -> Floats:
        """(n, c): everything that was asked for, rounded to what can be told apart (0.01 mm, 0.001 deg, 0.1 %).

        Two rows with equal numbers are repeats of one move; nan counts as equal to nan.
        """
        fine = [self.start, self.end, self.via, self.joints_start, self.joints_end]
        columns = [np.round(values, 5) for values in fine]
        columns += [np.round(values, 5) for values in (self.start_angles, self.end_angles)]
        single = (self.speed, self.speed_fraction, self.acceleration, self.acceleration_fraction, self.blend)
        columns += [np.round(values, 6)[:, None] for values in single]
        columns += [self.kind[:, None].astype(float), self.level[:, None].astype(float)]
        # -0.0 and 0.0 are one place.
        together: Floats = np.concatenate(columns, axis=1) + 0.0
        return np.where(np.isnan(together), np.inf, together)


def no_moves() -> RecordedMoves:
    """Those of a recording that has logs only."""
    one, three, none = np.zeros(0), np.zeros((0, 3)), np.zeros(0, dtype=np.int64)
    kind, joints = np.zeros(0, dtype=np.int8), np.zeros((0, 0))
    return RecordedMoves(
        *(none, kind, one, one, three, three, three, three, three, joints, joints, ()),
        *(one, one, one, one, one, kind, one, none, none, (), one, one),
    )


def _whole_points(start: Floats, end: Floats) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(np.concatenate([start, end], axis=1)).all(axis=1), dtype=bool)
