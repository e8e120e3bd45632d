"""Whether the moves, the logs and the robot of a recording belong together. Code: D021 they do not."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from olp.core.diagnostic import Diagnostic, error
from olp.core.units import deg, mm
from olp.identification.recording.columns import Problems
from olp.identification.recording.log import Log
from olp.identification.recording.moves import Floats, RecordedMoves
from olp.identification.recording.table import RecordingTable

if TYPE_CHECKING:
    from olp.robots.model import Robot

_SLACK = 0.2  # of a duration: how far two clocks may disagree before they measured different things
_FAR = 5.0 * deg  # of an axis, at the median start
_FAR_SLIDE = 50.0 * mm


def fit_together(
    table: RecordingTable, moves: RecordedMoves, logs: Mapping[str, Log | None], robot: Robot | None
) -> list[Diagnostic]:
    """Everything that shows that two of the files are of different runs or robots."""
    problems = Problems(table)
    axes = len(moves.slides)
    if robot is not None and axes and axes != len(robot.axes):
        says = f"the moves have {axes} axes, {robot.name} has {len(robot.axes)}"
        problems.cell("D021", says, -1, f"q{axes}_start_deg")
    found: list[Diagnostic] = []
    for log in logs.values():
        if log is None:
            continue
        found += _axes(log, axes, robot)
        if not found:
            _inside(problems, moves, log) if log is logs["log"] else None
            _counter(problems, moves, log)
    log = logs["log"]
    if log is not None and axes and not found and not problems.found:
        _starts(problems, moves, log)
    return [*problems.all(), *found]


def logs_fit(logs: Mapping[str, Log | None], robot: Robot | None) -> list[Diagnostic]:
    """Logs without moves: whether each has the robot's axes."""
    return [told for log in logs.values() if log is not None for told in _axes(log, 0, robot)]


def _axes(log: Log, axes: int, robot: Robot | None) -> list[Diagnostic]:
    width = len(log.slides)
    found = []
    if axes and axes != width:
        found.append(error("D021", f"the log has {width} axes, the moves have {axes}", file=log.file))
    if robot is not None and width != len(robot.axes):
        says = f"the log has {width} axes, {robot.name} has {len(robot.axes)}"
        found.append(error("D021", says, file=log.file))
    return found


def _inside(problems: Problems, moves: RecordedMoves, log: Log) -> None:
    """A move that starts or ends outside the log's time was not logged."""
    if not len(log):
        problems.whole("D021", f"{log.file} has no samples", "record again, or remove the log")
        return
    slack = max(5 * log.period, 0.1) if len(log) > 1 else 0.1
    early = moves.t_start < log.time[0] - slack
    late = moves.t_start + np.nan_to_num(moves.duration) > log.time[-1] + slack
    for row in np.nonzero(early | late)[0].tolist():
        says = f"the log runs from {log.time[0]:.9g} to {log.time[-1]:.9g} s, this move from {moves.t_start[row]:.9g} s"
        problems.cell("D021", f"{says} on", row, "t_start_s", "t_start_s is on the clock of log.csv")


def _counter(problems: Problems, moves: RecordedMoves, log: Log) -> None:
    """Every number in the log is a move of the table, and lasts about as long there."""
    if log.move is None or not len(log):
        return
    known = {number: row for row, number in enumerate(moves.move.tolist())}
    for number in np.unique(log.move).tolist():
        if number != -1 and number not in known:
            at = int(np.argmax(log.move == number))
            problems.whole(
                "D021",
                f"{log.file} names move {number} at {log.time[at]:.9g} s, which the moves do not have",
            )
    changes = np.nonzero(np.diff(log.move))[0]
    first, last = np.concatenate(([0], changes + 1)), np.concatenate((changes, [len(log) - 1]))
    for begin, end in zip(first.tolist(), last.tolist(), strict=True):
        number = int(log.move[begin])
        if number not in known or begin == 0 or end == len(log) - 1:
            continue  # cut off by the recorder
        row = known[number]
        least = log.time[end] - log.time[begin]
        most = log.time[end + 1] - log.time[begin - 1]
        lasts = moves.duration[row]
        if np.isnan(lasts) or least * (1 - _SLACK) - 0.1 <= lasts <= most * (1 + _SLACK) + 0.1:
            continue
        says = f"move {number} lasts {lasts:g} s, in the log {least:.3f} to {most:.3f} s"
        problems.cell("D021", says, row, "duration_s", "are they of one run?")


def _starts(problems: Problems, moves: RecordedMoves, log: Log) -> None:
    """At the starts of the moves the log's axes are where the moves begin, most of the time."""
    use = np.nonzero(~np.isnan(moves.t_start) & moves.has_joints)[0]
    if len(use) < 3:
        return
    there = interpolate(log.time, log.q, moves.t_start[use])
    off = np.abs(there - moves.joints_start[use])
    for axis, slides in enumerate(moves.slides):
        typical = float(np.nanmedian(off[:, axis])) if not np.isnan(off[:, axis]).all() else 0.0
        if typical > (_FAR_SLIDE if slides else _FAR):
            name = f"q{axis + 1}_start_{'mm' if slides else 'deg'}"
            much = f"{typical / mm:.0f} mm" if slides else f"{typical / deg:.1f}°"
            says = f"when the moves start, axis {axis + 1} of the log is {much} away from {name} (median)"
            problems.cell("D021", says, int(use[0]), name, "are they of one run, and one order of axes?")


def interpolate(time: Floats, values: Floats, at: Floats) -> Floats:
    """(m, k) `values` (n, k) between the samples at `time` (n,)."""
    return np.stack([np.interp(at, time, column) for column in values.T], axis=1)
