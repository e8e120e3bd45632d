"""What an explanation of one line holds, and how it reads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm, percent

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Phase:
    """A stretch of the segment's motion. Times [s] of the program; `speeds` [m/s] (or [rad/s] of an axis) at its ends.

    `length` [m] (or [rad]); `kind`: join, rise, cruise, fall or rest, for the picture's shading.
    """

    name: str
    kind: str
    begin: float
    end: float
    length: float
    speeds: tuple[float, float]
    limit: str


@dataclass(frozen=True, slots=True)
class AxisLoad:
    """`speed` [rad/s or m/s] over time (n,), `rated` [rad/s or m/s]; `linear`: a slide.

    `torque` [Nm or N] over time (n,), without the tool's mass, None where the robot's masses are not known;
    `torque_limit` [Nm or N], inf where not known.
    """

    name: str
    speed: Floats
    rated: float
    linear: bool
    torque: Floats | None = None
    torque_limit: float = float("inf")

    @property
    def share(self) -> Floats:
        """(n,) [1] of the rated speed."""
        return np.asarray(np.abs(self.speed) / self.rated, dtype=np.float64)

    @property
    def torque_share(self) -> Floats | None:
        """(n,) [1] of the torque limit, None where either is not known."""
        if self.torque is None or not np.isfinite(self.torque_limit):
            return None
        return np.asarray(np.abs(self.torque) / self.torque_limit, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Explanation:
    """One execution of one line. `time` (n,) [s] of the program, `speed` (n,) [m/s] of the tool's point.

    `scale`: phases count in metres of the tool's path (True) or radians of the leading axis. `programmed` [m/s], nan
    for joint moves. `executions`: how often the line ran; this is the first that moves.
    """

    line: int
    statement: str
    kind: str
    begin: float
    duration: float
    executions: int
    limited_by: str
    phases: tuple[Phase, ...] = ()
    entry: str = ""
    exit: str = ""
    metric: bool = True
    programmed: float = float("nan")
    time: Floats | None = None
    speed: Floats | None = None
    axes: tuple[AxisLoad, ...] = ()
    gains: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def as_text(told: Explanation) -> str:
    """The explanation in words and one table, ending in a line end."""
    rows = [f"line {told.line}: {told.statement}", f"  {_summary(told)}"]
    if told.phases:
        rows += ["", *_phase_table(told), "", f"  before: {told.entry}", f"  after:  {told.exit}"]
    busy = [axis for axis in told.axes if np.isfinite(axis.share).any()]
    if busy and told.time is not None:
        known = any(axis.torque is not None for axis in busy)
        more = "; highest torque and share of its limit, without the tool's mass" if known else ""
        rows += ["", f"  axes, highest speed and share of rated speed{more}:", *_axis_table(busy, told.time)]
    if told.gains:
        rows += ["", f"  {'; '.join(told.gains)}"]
    rows += [f"  {note}" for note in told.notes]
    return "\n".join(rows) + "\n"


def _summary(told: Explanation) -> str:
    span = (
        f"{told.duration:.3f} s, from {told.begin:.3f} to {told.begin + told.duration:.3f} s of the program"
    )
    often = f"; executed {told.executions} times, this is the first" if told.executions > 1 else ""
    limited = f", limited by {told.limited_by}" if told.limited_by else ""
    return f"{told.kind}, {span}{limited}{often}"


def _phase_table(told: Explanation) -> list[str]:
    unit, word = (mm, "mm") if told.metric else (deg, "deg")
    names = [phase.name for phase in told.phases]
    width = max(map(len, [*names, "phase"]))
    rows = [
        f"  {'phase':{width}}  {'from s':>8} {'to s':>8} {'s':>7} {word:>8}  {word + '/s':>15}  limited by"
    ]
    for phase in told.phases:
        first, last = (max(speed, 0.0) / unit for speed in phase.speeds)  # never -0.0
        speeds = f"{first:.1f} → {last:.1f}"
        rows.append(
            f"  {phase.name:{width}}  {phase.begin:8.3f} {phase.end:8.3f} {phase.end - phase.begin:7.3f} "
            f"{phase.length / unit:8.1f}  {speeds:>15}  {phase.limit}"
        )
    return rows


def _torque_words(axis: AxisLoad) -> str:
    if axis.torque is None:
        return ""
    peak, share = float(np.abs(axis.torque).max()), axis.torque_share
    limit = "" if share is None else f" {share.max() / percent:6.1f} %"
    return f"  {peak:8.1f} {'N' if axis.linear else 'Nm'}{limit}"


def _axis_table(axes: list[AxisLoad], time: Floats) -> list[str]:
    rows = []
    width = max(len(axis.name) for axis in axes)
    for axis in axes:
        share = np.nan_to_num(axis.share)
        at = int(np.argmax(share))
        unit, word = (mm, "mm/s") if axis.linear else (deg, "deg/s")
        note = "  beyond its rated speed" if share[at] > 1.0 + 1e-6 else ""
        rows.append(
            f"    {axis.name:{width}} {abs(axis.speed[at]) / unit:8.1f} {word:5} {share[at] / percent:6.1f} %"
            f"  at {time[at]:.3f} s{_torque_words(axis)}{note}"
        )
    return rows
