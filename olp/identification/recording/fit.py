"""Whether the moves, the logs and the robot of a recording belong together, and whether its units do.

Codes: D021 files of different runs or robots, D027 durations of which one is in another unit, D057 numbers that look
like another unit.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from olp.core.diagnostic import Diagnostic, Severity, error
from olp.core.units import deg, mm
from olp.identification.recording.columns import POINTS, Problems, like_radians
from olp.identification.recording.log import Log
from olp.identification.recording.moves import LINEAR, Floats, RecordedMoves
from olp.identification.recording.table import RecordingTable

if TYPE_CHECKING:
    from olp.robots.model import Robot

_SLACK = 0.2  # of a duration: how far two clocks may disagree before they measured different things
_FAR = 5.0 * deg  # of an axis, at the median start
_FAR_SLIDE = 50.0 * mm
_FEWEST = 3  # moves that two columns are compared on: their median stands for most of them
# Of 286 recordings, real and made up, the medians of simulated over measured times are 0.76 to 1.25, those of measured
# over needed times (as `units_fit` has them) 1.03 to 3.5. Another unit is off by 17 (m/min), 60 (minutes) or 1000.
_OTHER_TIME = 30.0
_OTHER_LENGTH = 100.0  # an override of 1 % is as slow
_OTHER_SPEED = 8.0  # no override makes a move so fast
_MOST_ACCELERATION = 50.0  # [m/s²] five times that of gravity: no arm's program asks for more
_INSIDE_BASE = 20 * mm  # an arm's tool is not in its own foot: metres
_NO_ACCELERATION = 0.05  # [m/s²] 50 mm/s²: below what any arm is set to, usual as a number of m/s²


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


def units_fit(table: RecordingTable, moves: RecordedMoves) -> list[Diagnostic]:
    """Two durations of which one must be in another unit (D027), and numbers that look like another unit (D057).

    Nothing is judged by lengths and speeds alone where a simulation is given, so what they say is a warning.
    """
    problems = Problems(table)
    ratio = _typical(moves.sim, moves.duration)
    if ratio and not 1 / _OTHER_TIME < ratio < _OTHER_TIME:
        larger, smaller = ("sim_s", "duration_s") if ratio > 1 else ("duration_s", "sim_s")
        says = f"{larger} is typically {max(ratio, 1 / ratio):,.0f} times {smaller}"
        problems.cell("D027", says, -1, larger, "both are in seconds")
        return problems.all()
    doubts = [*_doubtful_lengths(moves), *_doubtful_joints(moves), *_doubtful_accelerations(moves)]
    for name, says, help in doubts:
        problems.cell("D057", says, -1, name, help, Severity.WARNING)
    return problems.all()


# The column that numbers of another unit are in, what shows it, and the unit that they should be in.
_Doubt = tuple[str, str, str]


def _doubtful_lengths(moves: RecordedMoves) -> Iterator[_Doubt]:
    """Straight moves whose lengths at their speeds need another time than they take."""
    way, cruise = np.where(moves.kind == LINEAR, moves.chord, np.nan), moves.speed * moves.played
    needed = np.maximum(way / cruise, 2 * np.sqrt(way / _MOST_ACCELERATION))  # from rest to rest, or at speed
    ratio = _typical(np.where(moves.measured, moves.duration, moves.sim), needed)
    first, near = POINTS["start"][0], _in_its_base(moves)
    if ratio > _OTHER_LENGTH:
        says = f"straight moves typically take {ratio:,.0f} times as long as their lengths at speed_mm_s need"
        yield first if near else "duration_s", says, "points are in mm, speeds in mm/s, durations in s"
    elif 0.0 < ratio < 1 / _OTHER_SPEED:
        says = f"lengths at speed_mm_s typically need {1 / ratio:,.0f} times as long as straight moves take"
        yield "speed_mm_s", says, "speeds are in mm/s, points in mm, durations in s"
    elif near:
        yield (
            first,
            "every point is within 20 mm of the foot of the arm: are these metres?",
            "points are in mm",
        )


def _doubtful_joints(moves: RecordedMoves) -> Iterator[_Doubt]:
    if like_radians(moves.joints_start[moves.has_joints], moves.slides):
        says = "no axis is farther than 7 deg from 0: are these radians?"
        yield "q1_start_deg", says, "joint points are in degrees"


def _doubtful_accelerations(moves: RecordedMoves) -> Iterator[_Doubt]:
    typical = _typical(moves.acceleration)
    if 0.0 < typical < _NO_ACCELERATION:
        says = f"accelerations are typically {typical / mm:.3g} mm/s²: are these m/s²?"
        yield "accel_mm_s2", says, "accelerations are in mm/s²"


def _typical(values: Floats, over: Floats | float = 1.0) -> float:
    """The median of `values` over `over`, both above 0; 0 where fewer than three are known."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = values / over
    known = ratio[np.isfinite(ratio) & (ratio > 0)]
    return float(np.median(known)) if len(known) >= _FEWEST else 0.0


def _in_its_base(moves: RecordedMoves) -> bool:
    """Whether no point of moves that go anywhere is outside the arm's foot."""
    points = np.concatenate([moves.start[moves.has_points], moves.end[moves.has_points]])
    if len(points) < 2 * _FEWEST:
        return False
    return float(np.ptp(points, axis=0).max()) > 0.0 and float(np.abs(points).max()) < _INSIDE_BASE


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
