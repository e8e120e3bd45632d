"""A recording: what a real robot did, move by move, and everything needed to judge a simulation by it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic
from olp.identification.recording.log import Log
from olp.identification.recording.moves import WAIT, Floats, RecordedMoves
from olp.identification.recording.settings import RecordingSettings

if TYPE_CHECKING:
    from olp.robots.geometry import Pose
    from olp.robots.model import Robot

Labels = NDArray[np.int64]
_MOSTLY = 0.9  # of the durations are on a grid
_CYCLE = 40  # digits of a controller's cycle, at most
_DECIMAL = 1e-6  # of a unit: a duration is a whole multiple of a resolution when it is this near to one


class NoiseFloor(NamedTuple):
    """Below what a difference of durations says nothing. All [s]; nan where nothing tells it.

    A clock that shows multiples of r rounds by up to r/2, evenly: r/√12 (uniform distribution). Repeats of one move
    scatter by the robot, the clock and all else, pooled over the moves that were repeated.
    """

    resolution: float
    inferred: bool  # from the durations' own digits, not from recording.toml
    repeats: float  # standard deviation between repeats
    freedom: int  # degrees of freedom behind `repeats`
    floor: float  # the larger of resolution/√12 and repeats

    @property
    def polled(self) -> bool:
        """Whether nobody states the resolution and it is no decimal digit: the cycle of a recorder or a controller."""
        digits = np.log10(self.resolution)
        return self.inferred and bool(np.isfinite(digits) and abs(digits - np.round(digits)) > _DECIMAL)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Recording:
    """`path` as it was named; `robot` and `tool` None where nobody named one; `sha256` of the values, not the files.

    `diagnostics`: warnings and notes; errors are raised by `read_recording`. `left_out`: rows of all files.
    """

    path: str
    moves: RecordedMoves
    log: Log | None
    sim_log: Log | None
    settings: RecordingSettings
    robot: Robot | None
    tool: Pose | None
    sha256: str
    diagnostics: tuple[Diagnostic, ...] = ()
    left_out: int = 0

    def __repr__(self) -> str:
        robot = self.robot.name if self.robot else self.settings.robot or "robot not known"
        logs = ", ".join(
            name for name, log in (("log", self.log), ("sim_log", self.sim_log)) if log is not None
        )
        return f"<Recording {self.path}: {len(self.moves)} moves, {robot}{', ' * bool(logs)}{logs}>"

    def groups(self) -> dict[str, Labels]:
        """Ways to hold out whole groups: name -> (n,) label per move, 0, 1, … in the order of first use.

        Start point, speed, type, job, cycle and every text column that tells at least two groups apart and at least
        two moves alike. A column that parts the moves as an earlier one does is not repeated.
        """
        found: dict[str, Labels] = {}
        for name, keys in self._keys().items():
            labels = _labels(keys)
            count = labels.max(initial=-1) + 1
            if 2 <= count < len(labels) and not any(
                np.array_equal(labels, other) for other in found.values()
            ):
                found[name if name not in found else f"{name} (column)"] = labels
        return found

    def _keys(self) -> dict[str, list[object]]:
        moves = self.moves
        starts = np.where(moves.has_points[:, None], np.round(moves.start, 4), np.nan)
        joints = np.round(moves.joints_start, 4)
        place = np.concatenate([starts, np.where(moves.has_points[:, None], np.nan, joints)], axis=1) + 0.0
        speeds = np.round(np.stack([moves.speed, moves.speed_fraction], axis=1), 6)
        keys: dict[str, list[object]] = {
            "start": list(map(str, place.tolist())),
            "speed": list(map(str, speeds.tolist())),
            "type": moves.kind.tolist(),
            "job": list(moves.job),
            "cycle": moves.cycle.tolist(),
        }
        for name, words in moves.texts.items():
            keys[name if name not in keys else f"{name} (column)"] = list(words)
        return keys

    def repeats(self) -> Labels:
        """(n,) label per move: rows that were programmed alike have one label."""
        programmed = self.moves.programmed()
        return _labels(list(map(bytes, np.ascontiguousarray(programmed))))

    def noise_floor(self) -> NoiseFloor:
        """What resolution and repeats say about the noise of the measured durations."""
        duration = self.moves.duration[self.moves.measured]
        given = self.settings.time_resolution
        resolution = given if given is not None else _resolution_of(duration)
        scatter, freedom = self._scatter()
        known = [value for value in (resolution / np.sqrt(12.0), scatter) if not np.isnan(value)]
        return NoiseFloor(resolution, given is None, scatter, freedom, max(known, default=float("nan")))

    def _scatter(self) -> tuple[float, int]:
        """Pooled standard deviation [s] of repeated moves and its degrees of freedom; waits repeat nothing."""
        use = self.moves.measured & (self.moves.kind != WAIT)
        labels, duration = self.repeats()[use], self.moves.duration[use]
        if not len(labels):
            return float("nan"), 0
        count = np.bincount(labels)
        mean = np.bincount(labels, duration) / np.maximum(count, 1)
        freedom = int(np.maximum(count - 1, 0).sum())
        square = float(((duration - mean[labels]) ** 2).sum())
        return (float(np.sqrt(square / freedom)), freedom) if freedom else (float("nan"), 0)


def _labels(keys: list[object]) -> Labels:
    order: dict[object, int] = {}
    return np.array([order.setdefault(key, len(order)) for key in keys], dtype=np.int64)


def _resolution_of(duration: Floats) -> float:
    """[s] The coarsest grid that nine in ten durations are multiples of: digits, and a controller's cycle on them;
    nan when none is."""
    if len(duration) < 10:
        return float("nan")
    for step in (1.0, 0.1, 0.01, 0.001, 1e-4):
        ratio = duration / step
        if np.mean(np.abs(ratio - np.round(ratio)) < _DECIMAL * np.maximum(1.0, ratio)) >= _MOSTLY:
            digits = np.round(ratio).astype(np.int64)
            times = [k for k in range(2, _CYCLE + 1) if np.mean(digits % k == 0) >= _MOSTLY]
            return step * max(times, default=1)
    return float("nan")
