"""Designs an experiment: from a box to the moves that tell most, in an order that can be run.

Codes: Q001 a wish that cannot be, Q002 the box is out of reach, Q003 the robot's axes are not known,
Q004 lines that were left out, Q005 the recording does not tell what is needed, Q007 the robot's numbers are inferred.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error, info, warning
from olp.core.units import mm
from olp.identification.probe.reach import CandidateLines, Posture, candidates
from olp.identification.signature.axis_paths import has_axes
from olp.identification.signature.estimators.averaged_process import views_of
from olp.identification.signature.mixture import Views, average_covariance, ruler_of
from olp.identification.signature.moveset import MoveSet, moves_of_recording
from olp.robots.geometry import angles_from_rotation, rotation_from_angles

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording
    from olp.robots.geometry import Pose
    from olp.robots.model import Robot


Floats = NDArray[np.float64]
Labels = NDArray[np.int64]

MOST_MOVES = 200
# [m/s²] Where a robot file tells none: only decides how short a move may be.
_USUAL_ACCELERATION = 1.0


class Wanted(NamedTuple):
    """What is asked for. `box` (3, 2) [m] lower and upper end, `speed` [m/s], `angles` (3,) [rad] of the tool."""

    robot: Robot
    box: Floats
    moves: int
    speed: float
    angles: tuple[float, float, float]
    tool: Pose | None = None
    tool_number: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Experiment:
    """m moves in the order of running, from `points[starts]` to `points[ends]`.

    `before`: per move the points passed to get to its start, the start last; [] where it is there already.
    `rank` (m,): 0 the most telling. `left` [1]: standard deviation that is left, of the one before, by the model of
    method averaged_process, averaged over the box.
    """

    wanted: Wanted
    points: Floats  # (p, 3) [m]
    starts: Labels
    ends: Labels
    before: tuple[tuple[int, ...], ...]
    rank: Labels
    left: float
    posture: Posture
    first: int = 1  # number of the first move
    told: tuple[Diagnostic, ...] = ()


def design_experiment(wanted: Wanted, measured: MoveSet | None = None, first: int = 1) -> Experiment:
    """The moves that tell most beside the `measured` ones. Raises OlpError: Q001, Q002, Q003."""
    _check(wanted)
    rotation = rotation_from_angles(wanted.angles)
    found = candidates(wanted.robot, wanted.box, rotation, wanted.tool, wanted.speed, _shortest(wanted))
    if len(found.starts) < wanted.moves:
        says = f"{len(found.starts)} lines of the box can be run, {wanted.moves} moves are asked for"
        raise OlpError(
            error(
                "Q002",
                f"{says}: {found.told}",
                help="move or shrink the box, turn the tool or lower the speed",
            )
        )
    lines = _moves(found, wanted, rotation)
    covariance, known = _covariance(lines, measured, wanted.robot)
    allowed = np.arange(len(covariance)) < len(lines)
    chosen = most_telling(covariance, wanted.moves, known, allowed)
    left = share_left(covariance, np.concatenate([np.nonzero(known)[0], chosen]))
    return _routed(wanted, found, chosen, left, first)


def further_experiment(recording: Recording, wanted: Wanted) -> Experiment:
    """The moves that tell most beside those of a recording that have a duration. Raises OlpError."""
    moves, _ = moves_of_recording(recording)
    measured = moves.take(np.isfinite(moves.duration) & np.isfinite(moves.rotation).all(axis=(1, 2)))
    if not len(measured):
        says = "no straight move with a duration and a tool orientation"
        raise OlpError(error("Q005", says, file=recording.path, help="fill duration_s in moves.csv first"))
    return design_experiment(wanted, measured, int(recording.moves.move.max()) + 1)


def wanted_of(
    recording: Recording, robot: Robot | None, moves: int, tool_number: int = 0, box: Floats | None = None
) -> Wanted:
    """The wish that a recording itself tells: its robot, box, speed and tool orientation. Raises OlpError (Q005)."""
    robot = robot or recording.robot
    rows, _ = moves_of_recording(recording)
    rows = rows.take(np.asarray(np.isfinite(rows.rotation).all(axis=(1, 2))))
    if robot is None:
        raise OlpError(error("Q005", "the recording names no robot", file=recording.path, help="--robot"))
    if not len(rows):
        says = "the recording holds no straight move with a tool orientation"
        raise OlpError(error("Q005", says, file=recording.path))
    if box is None:
        ends = np.concatenate([rows.start, rows.end])
        box = np.stack([ends.min(axis=0), ends.max(axis=0)], axis=1)
    x, y, z = angles_from_rotation(rows.rotation[:1])[0].tolist()
    speed = float(np.median(rows.speed))
    return Wanted(robot, box, moves, speed, (x, y, z), recording.tool, tool_number)


def _check(wanted: Wanted) -> None:
    box, problems = wanted.box, []
    if box.shape != (3, 2) or not np.isfinite(box).all() or np.any(box[:, 0] > box[:, 1]):
        problems.append(error("Q001", "a box is X0,X1,Y0,Y1,Z0,Z1 in mm, each pair rising"))
    elif not np.any(box[:, 1] - box[:, 0] >= 10 * mm):
        problems.append(error("Q001", "the box is nowhere 10 mm wide"))
    if not 1 <= wanted.moves <= MOST_MOVES:
        problems.append(error("Q001", f"{wanted.moves} moves: 1 to {MOST_MOVES} can be designed"))
    if not (np.isfinite(wanted.speed) and wanted.speed > 0):
        problems.append(error("Q001", "the speed must be above zero"))
    if not np.isfinite(wanted.angles).all():
        problems.append(error("Q001", "the orientation is RX,RY,RZ in degrees"))
    if (wanted.tool is None) != (wanted.tool_number == 0) or not 0 <= wanted.tool_number <= 63:
        says = "give a tool together with its number on the controller (1 to 63); 0 is the flange"
        problems.append(error("Q001", says, help="--tool X,Y,Z,RX,RY,RZ --tool-number N"))
    if not has_axes(wanted.robot) or len(wanted.robot.axes) != 6:
        says = f"the axes of {wanted.robot.name} are not known in closed form: nothing can be proved"
        problems.append(error("Q003", says, help="give the robot file its [links]"))
    if problems:
        raise OlpError(*problems)


def _shortest(wanted: Wanted) -> float:
    """[m] The programmed speed is reached; in a small box half its diagonal."""
    acceleration = wanted.robot.linear_acceleration or _USUAL_ACCELERATION
    diagonal = float(np.linalg.norm(wanted.box[:, 1] - wanted.box[:, 0]))
    return min(wanted.speed**2 / acceleration, 0.5 * diagonal)


def _moves(found: CandidateLines, wanted: Wanted, rotation: Floats) -> MoveSet:
    count = len(found.starts)
    nothing = np.full(count, np.nan)
    return MoveSet(
        start=found.points[found.starts],
        end=found.points[found.ends],
        rotation=np.broadcast_to(rotation, (count, 3, 3)),
        speed=np.full(count, wanted.speed),
        nominal=nothing,
        duration=nothing,
        payload=nothing,
        configuration=("",) * count,
        program=("",) * count,
        tool=wanted.tool,
    )


def _covariance(lines: MoveSet, measured: MoveSet | None, robot: Robot) -> tuple[Floats, NDArray[np.bool_]]:
    """Of the lines and the measured moves behind them, and which are the measured ones."""
    views = views_of(lines, robot)
    count = len(lines)
    if measured is not None:
        more = views_of(measured, robot)
        more = more.take(np.nonzero(np.isfinite(more.terms).all(axis=1))[0])
        views = Views(*(np.concatenate(pair) for pair in zip(views, more, strict=True)))
    known = np.arange(len(views.places)) >= count
    return average_covariance(views, views, ruler_of(views)), known


def _routed(wanted: Wanted, found: CandidateLines, chosen: Labels, left: float, first: int) -> Experiment:
    starts, ends = found.starts[chosen], found.ends[chosen]
    ways = ShortestPaths(found.points, found.possible)
    turn = order(starts, ends, ways)
    before: list[tuple[int, ...]] = []
    at = int(starts[turn[0]])
    for move in turn:
        before.append(tuple(ways.between(at, int(starts[move]))))
        at = int(ends[move])
    rows = np.array(turn, dtype=np.int64)
    return Experiment(
        wanted,
        found.points,
        starts[rows],
        ends[rows],
        tuple(before),
        rows,
        left,
        found.posture,
        first,
        _told(wanted, found),
    )


def _told(wanted: Wanted, found: CandidateLines) -> tuple[Diagnostic, ...]:
    robot, told = wanted.robot, []
    if found.told:
        says = f"of {found.looked} lines between points of the box some cannot be run: {found.told}"
        told.append(info("Q004", says))
    doubtful = [name for name in ("limits", "links", "speed") if name in robot.inferred]
    if doubtful:
        says = f"{', '.join(doubtful)} of {robot.name} are inferred, not published: the proof is as good as they are"
        told.append(warning("Q007", says, help="run the job slowly once, without measuring"))
    return tuple(told)


# --- Route ---
# In which order moves are run, and the ways between them: short, and only along lines that were proved.


class ShortestPaths:
    """The shortest ways between p points along allowed lines. `allowed` (p, p), `points` (p, 3) [m]."""

    def __init__(self, points: Floats, allowed: NDArray[np.bool_]) -> None:
        apart = np.linalg.norm(points[:, None] - points[None], axis=2)
        self.length: Floats = np.where(allowed, apart, np.inf)
        np.fill_diagonal(self.length, 0.0)
        count = len(points)
        self._next: Labels = np.where(np.isfinite(self.length), np.arange(count)[None, :], -1)
        # R. W. Floyd, Algorithm 97: shortest path, Communications of the ACM 5 (1962).
        for middle in range(count):
            over = self.length[:, middle, None] + self.length[None, middle, :]
            better = over < self.length - 1e-12
            self.length = np.where(better, over, self.length)
            self._next = np.where(better, self._next[:, middle, None], self._next)

    def between(self, first: int, last: int) -> list[int]:
        """The points after `first` up to `last`; [] when they are one. Needs a finite length."""
        found: list[int] = []
        at = first
        while at != last:
            at = int(self._next[at, last])
            found.append(at)
        return found


def order(starts: Labels, ends: Labels, ways: ShortestPaths) -> list[int]:
    """Move numbers so that each starts near where the one before ended; always the nearest, the first one stays."""
    rest = list(range(1, len(starts)))
    found = [0] if len(starts) else []
    while rest:
        at = int(ends[found[-1]])
        best = min(rest, key=lambda move: (float(ways.length[at, int(starts[move])]), move))
        rest.remove(best)
        found.append(best)
    return found


# --- Design ---
# Which moves tell most: the rows that leave the least variance of what is wanted, before anything is measured.
#
# V. V. Fedorov, Theory of Optimal Experiments (Academic Press 1972), chapter 3: exchanges until none helps; the
# criterion is the average variance of prediction (I-optimality) of a Gaussian process.

# Noise of one measured move, of the variance of the function: a hundredth of a second in three seconds.
NOISE = 0.01
_ROUNDS = 20
_GAIN = 1e-9


def most_telling(
    covariance: Floats, count: int, known: NDArray[np.bool_], allowed: NDArray[np.bool_]
) -> Labels:
    """(count,) rows to measure beside the `known` (n,) ones, among `allowed`: the most telling one first.

    `covariance` (n, n): of all moves; the variance left is averaged over all of them. Rows that are known already
    are not measured again. Gives fewer rows when fewer are allowed.
    """
    fixed = np.nonzero(known)[0]
    free = allowed & ~known
    chosen: list[int] = []
    left = _without(covariance, fixed)
    for _ in range(min(count, int(free.sum()))):
        best = _best(left, free, chosen)
        chosen.append(best)
        left = _less(left, best)
    for _ in range(_ROUNDS):
        changed = False
        for place, row in enumerate(chosen):
            others = chosen[:place] + chosen[place + 1 :]
            left = _without(covariance, np.concatenate([fixed, np.array(others, dtype=np.int64)]))
            gain = _gains(left, free, others)
            best = int(np.argmax(gain))
            if gain[best] > gain[row] * (1 + _GAIN):
                chosen[place] = best
                changed = True
        if not changed:
            break
    return _ranked(covariance, fixed, chosen)


def share_left(covariance: Floats, rows: Labels) -> float:
    """[1] The average standard deviation that measuring `rows` leaves, of the one before."""
    before = float(np.sqrt(np.diag(covariance)).mean())
    after = np.sqrt(np.maximum(np.diag(_without(covariance, rows)), 0.0))
    return float(after.mean()) / before


def _ranked(covariance: Floats, fixed: Labels, chosen: list[int]) -> Labels:
    """The same rows, each the most telling one after those before it."""
    left, rest, order = _without(covariance, fixed), sorted(chosen), []
    while rest:
        gain = _gains(left, np.ones(len(left), dtype=bool), [])
        best = max(rest, key=lambda row: float(gain[row]))
        rest.remove(best)
        order.append(best)
        left = _less(left, best)
    return np.array(order, dtype=np.int64)


def _gains(left: Floats, free: NDArray[np.bool_], taken: list[int]) -> Floats:
    gain = np.sum(left**2, axis=0) / (np.diag(left) + NOISE)
    gain[~free] = -1.0
    gain[taken] = -1.0
    return np.asarray(gain)


def _best(left: Floats, free: NDArray[np.bool_], taken: list[int]) -> int:
    return int(np.argmax(_gains(left, free, taken)))


def _less(left: Floats, row: int) -> Floats:
    """The covariance after one more row was measured."""
    column = left[:, row]
    return np.asarray(left - np.outer(column, column) / (column[row] + NOISE))


def _without(covariance: Floats, rows: Labels) -> Floats:
    """The covariance after `rows` were measured."""
    if not len(rows):
        return covariance
    own = covariance[np.ix_(rows, rows)] + NOISE * np.eye(len(rows))
    return np.asarray(covariance - covariance[:, rows] @ np.linalg.solve(own, covariance[rows]))
