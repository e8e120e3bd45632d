"""How long moves take, told by olp, by the maker's simulator and by two peers: one table of all recordings of a folder.

    python bench/league.py FOLDER [--only NAME]

FOLDER holds recordings (docs/recording.md): folders with a moves.csv; so whoever has a robot adds a row. Folders
without one are named and left out. Of each recording, joint moves and paths (lines and arcs) apart:

- olp out of the box: nothing learnt. Joint moves by the prior of the arm, with its interval; paths at programmed speed
  with the acceleration that was written, else that of the robot file, else olp's default, at rest where they stop
  exactly.
- olp, 20 moves: `olp calibrate` on twenty moves drawn at random, `olp predict` on all others.
- olp, half: each program predicted after every second move of the other programs; where there is one program only,
  one half of the moves after the other half, drawn at random.
- the maker's simulator: `sim_s`, told more than olp is.
- ruckig: time-optimal, the prior's speeds and accelerations, no limit of jerk; paths as out of the box.
- trapezoid fit: a speed and an acceleration per axis and one constant, least squares of relative errors on the moves
  that "half" learns from; the slowest axis decides. Joint moves only.

Errors are relative, of each move that a method predicts without having seen it: mean, median, 95th percentile of their
absolute values; of the total; and how many measured times lie within the stated 95 % interval.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from olp.core.diagnostic import OlpError  # noqa: E402
from olp.identification.recording import Recording, read_recording  # noqa: E402
from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR, RecordedMoves  # noqa: E402
from olp.identification.signature import calibrate  # noqa: E402
from olp.identification.signature.joint_moves import recorded_joint_moves  # noqa: E402
from olp.identification.signature.motions import arc_length  # noqa: E402
from olp.identification.signature.rows import predict_recording  # noqa: E402
from olp.robots.controller_effects import generations_in  # noqa: E402
from olp.timing.accelerations import DEFAULT_LINEAR_ACCELERATION  # noqa: E402
from olp.timing.arm import ArmTiming  # noqa: E402
from olp.timing.arm_prior import arm_prior  # noqa: E402
from olp.timing.motion import load_model  # noqa: E402

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
FEW = 20
SEED = 20
_NORMAL = 1.96
_SAME = 1e-4  # [m | rad] a move begins where the one before ended


class Told(NamedTuple):
    """(n,) [s] per row of the recording, nan where a method says nothing or has seen the move."""

    duration: Floats
    low: Floats
    high: Floats

    @classmethod
    def only(cls, duration: Floats) -> Told:
        """Without an interval."""
        return cls(duration, *np.full((2, len(duration)), np.nan))

    def without(self, seen: Mask) -> Told:
        """The same of moves that were not learnt from."""
        return Told(*(np.where(seen, np.nan, values) for values in self))


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", metavar="NAME", help="this recording alone")
    args = parser.parse_args()
    print("| recording | moves | method | mean % | median % | 95th % | total % | coverage % |")
    print("|---|---|---|---|---|---|---|---|")
    left_out = []
    for folder in sorted(path for path in args.folder.iterdir() if path.is_dir()):
        if args.only not in (None, folder.name):
            continue
        if not any((folder / name).is_file() for name in ("moves.csv", "moves.csv.gz", "moves.parquet")):
            left_out.append(folder.name)
            continue
        for line in rows_of(folder.name, read_recording(folder)):
            print(line, flush=True)
    if left_out:
        print(f"\nno moves.csv, left out: {', '.join(left_out)}")


METHODS: dict[str, Callable[[Recording], Told]] = {}


def method(name: str) -> Callable[[Callable[[Recording], Told]], Callable[[Recording], Told]]:
    """Enters a method of the league."""

    def enter(function: Callable[[Recording], Told]) -> Callable[[Recording], Told]:
        METHODS[name] = function
        return function

    return enter


def rows_of(name: str, recording: Recording) -> Iterator[str]:
    """Lines of the table."""
    moves = recording.moves
    for kind, rows in (("joint", moves.kind == JOINT), ("paths", np.isin(moves.kind, (LINEAR, CIRCULAR)))):
        rows = rows & (np.nan_to_num(moves.duration) > 0)
        if not rows.any():
            continue
        for title, tell in METHODS.items():
            yield f"| {name}, {kind} | {rows.sum()} | {title} | {_figures(tell, recording, rows)} |"


def _figures(tell: Callable[[Recording], Told], recording: Recording, rows: Mask) -> str:
    try:
        told = tell(recording)
    except OlpError as problem:
        return f"refused: {problem.diagnostics[0].message} | | | |"
    measured = recording.moves.duration
    known = rows & np.isfinite(told.duration)
    if known.sum() < max(2, 0.05 * rows.sum()):
        return "– | – | – | – | –"
    error = 100 * np.abs(told.duration[known] / measured[known] - 1)
    total = 100 * (told.duration[known].sum() / measured[known].sum() - 1)
    inside = (told.low[known] <= measured[known]) & (measured[known] <= told.high[known])
    bounded = np.isfinite(told.low[known])
    coverage = f"{100 * np.mean(inside[bounded]):.0f}" if bounded.mean() > 0.5 else "–"
    return f"{error.mean():.1f} | {np.median(error):.1f} | {np.percentile(error, 95):.1f} | {total:+.1f} | {coverage}"


# --- olp --------------------------------------------------------------------------------------------------------------


@method("olp out of the box")
def out_of_the_box(recording: Recording) -> Told:
    moves = recording.moves
    told = Told.only(_paths(moves, recording))
    axes = len(recording.robot.axes) if recording.robot else moves.joints_start.shape[1]
    joints, rows = recorded_joint_moves(moves, recording.robot, recording.tool, axes)
    if len(rows):
        prior = _prior(recording, axes)
        told.duration[rows] = prior.durations(joints.motions)
        factor = np.exp(_NORMAL * prior.spread(joints.motions))
        told.low[rows], told.high[rows] = told.duration[rows] / factor, told.duration[rows] * factor
    return told


@method(f"olp, {FEW} moves")
def twenty(recording: Recording) -> Told:
    measured = np.flatnonzero(np.nan_to_num(recording.moves.duration) > 0)
    seen = np.zeros(len(recording.moves), dtype=bool)
    seen[np.random.default_rng(SEED).choice(measured, min(FEW, len(measured) // 2), replace=False)] = True
    return _learnt(recording, seen).without(seen)


@method("olp, half")
def half(recording: Recording) -> Told:
    told = Told(*np.full((3, len(recording.moves)), np.nan))
    for seen, asked in _halves(recording):
        found = _learnt(recording, seen)
        for values, new in zip(told, found, strict=True):
            values[asked] = new[asked]
    return told


def _prior(recording: Recording, axes: int) -> ArmTiming:
    """As `olp diagnose` and `olp calibrate` take it."""
    generations = generations_in(recording.settings.controller or "")
    return arm_prior(recording.robot, generations, [f"q{i + 1}" for i in range(axes)])


def _learnt(recording: Recording, seen: Mask) -> Told:
    """What a signature says that was learnt from the rows `seen`."""
    duration = np.where(seen, recording.moves.duration, np.nan)
    signature, _ = calibrate(replace(recording, moves=replace(recording.moves, duration=duration)))
    rows, _ = predict_recording(signature, recording)
    return Told(rows.predicted, rows.low, rows.high)


def _halves(recording: Recording) -> Iterator[tuple[Mask, Mask]]:
    """What is learnt from and what is asked: each program after half of the others, or one half after the other."""
    moves = recording.moves
    names = np.array(moves.texts.get("program", moves.job))
    measured = np.nan_to_num(moves.duration) > 0
    programs = np.unique(names[measured]) if len(names) else []
    if len(programs) < 2:
        drawn = np.zeros(len(moves), dtype=bool)
        rows = np.flatnonzero(measured)
        drawn[np.random.default_rng(SEED).choice(rows, len(rows) // 2, replace=False)] = True
        yield drawn, measured & ~drawn
        return
    for program in programs:
        others = np.flatnonzero(measured & (names != program))
        seen = np.zeros(len(moves), dtype=bool)
        seen[others[::2]] = True
        yield seen, measured & (names == program)


def _paths(moves: RecordedMoves, recording: Recording) -> Floats:
    """(n,) [s] lines and arcs at programmed speed, at rest where they stop exactly; nan for all else."""
    length, rolling, speed, push = _asked(moves, recording)
    profile = load_model("constant").profile(
        length, speed, push, None, rolling[0] * speed, rolling[1] * speed
    )
    return np.where(np.isfinite(moves.speed) & (length > 0), profile.duration, np.nan)


def _asked(moves: RecordedMoves, recording: Recording) -> tuple[Floats, tuple[Mask, Mask], Floats, Floats]:
    """Length [m], whether each path begins and ends rolling, speed [m/s] and acceleration [m/s²]; 1 where unknown."""
    path = np.isin(moves.kind, (LINEAR, CIRCULAR))
    length = np.where(path, np.nan_to_num(np.linalg.norm(moves.end - moves.start, axis=1)), 0.0)
    arc = np.flatnonzero((moves.kind == CIRCULAR) & np.isfinite(moves.via).all(axis=1))
    if len(arc):
        length[arc] = arc_length(moves.start[arc], moves.via[arc], moves.end[arc])
    robot = recording.robot
    usual = (robot.linear_acceleration if robot else None) or DEFAULT_LINEAR_ACCELERATION
    push = np.where(np.isfinite(moves.acceleration), moves.acceleration, usual)
    ends = path & ((np.nan_to_num(moves.blend, nan=1.0) > 0) | (moves.level > 0))
    goes_on = path[1:] & path[:-1] & (np.linalg.norm(moves.end[:-1] - moves.start[1:], axis=1) < _SAME)
    ends &= np.append(goes_on, False)
    begins = np.insert(ends[:-1], 0, False)
    override = _override(moves)
    return length, (begins, ends), np.where(np.isfinite(moves.speed), moves.speed * override, 1.0), push


def _override(moves: RecordedMoves) -> Floats:
    return np.where(moves.override > 0, moves.override, 1.0)


# --- peers ------------------------------------------------------------------------------------------------------------


@method("the maker's simulator")
def simulator(recording: Recording) -> Told:
    return Told.only(recording.moves.sim.copy())


@method("ruckig, the prior's limits")
def by_ruckig(recording: Recording) -> Told:
    from ruckig import InputParameter, Ruckig, Trajectory

    moves = recording.moves
    result = np.full(len(moves), np.nan)
    axes = len(recording.robot.axes) if recording.robot else moves.joints_start.shape[1]
    _, rows = recorded_joint_moves(moves, recording.robot, recording.tool, axes)
    if len(rows):
        prior = _prior(recording, axes)
        rows = rows[:: max(1, len(rows) // _MOST)]
        fraction = np.nan_to_num(moves.speed_fraction[rows], nan=1.0) * _override(moves)[rows]
        planner, asked = Ruckig(axes), InputParameter(axes)
        for row, share in zip(rows.tolist(), fraction.tolist(), strict=False):
            asked.target_position = np.abs(moves.joints_end[row] - moves.joints_start[row]).tolist()
            asked.max_velocity = (prior.speeds * share).tolist()
            asked.max_acceleration = (prior.speeds / prior.times_to_speed).tolist()
            trajectory = Trajectory(axes)
            planner.calculate(asked, trajectory)
            result[row] = trajectory.duration
    length, rolling, speed, push = _asked(moves, recording)
    planner, asked = Ruckig(1), InputParameter(1)
    begin, end = speed * rolling[0], speed * rolling[1]
    possible = np.abs(end**2 - begin**2) <= 2 * push * length  # else it would go back and forth
    for row in np.flatnonzero((length > 0) & np.isfinite(moves.speed) & possible).tolist():
        asked.target_position, asked.max_velocity = [float(length[row])], [float(speed[row])]
        asked.max_acceleration = [float(push[row])]
        asked.current_velocity, asked.target_velocity = [float(begin[row])], [float(end[row])]
        trajectory = Trajectory(1)
        planner.calculate(asked, trajectory)
        result[row] = trajectory.duration
    return Told.only(result)


_RISE = 0.15  # [s] to full speed, where the fit begins
_MOST = 500  # moves of a recording that ruckig is asked for


@method("trapezoid fit, half")
def trapezoid(recording: Recording) -> Told:
    from scipy.optimize import least_squares

    moves = recording.moves
    result = np.full(len(moves), np.nan)
    known = (moves.kind == JOINT) & moves.has_joints
    distance = np.abs(moves.joints_end - moves.joints_start)
    share = np.nan_to_num(moves.speed_fraction, nan=1.0) * _override(moves)
    axes = distance.shape[1]

    def times(numbers: Floats, rows: Mask) -> Floats:
        speed, push = np.exp(numbers[:axes]) * share[rows, None], np.exp(numbers[axes:-1])
        way = distance[rows]
        each = np.where(way * push > speed**2, way / speed + speed / push, 2 * np.sqrt(way / push))
        return np.asarray(each.max(axis=1) + numbers[-1])

    for seen, asked in _halves(recording):
        rows = seen & known
        if rows.sum() < 2 * axes + 1:
            continue
        mean = distance[rows] / (moves.duration[rows] * share[rows])[:, None]
        begin = np.log(np.maximum(mean.max(axis=0), mean.max() / 10) * 1.3)
        begin = np.concatenate([begin, begin - np.log(_RISE), [0.05]])
        fit = least_squares(lambda p, r=rows: times(p, r) / moves.duration[r] - 1, begin, x_scale=0.1)
        result[asked & known] = times(fit.x, asked & known)
    return Told.only(result)


if __name__ == "__main__":
    main()
