"""How long moves take, told by olp, by the maker's simulator and by two peers: one table of all recordings of a folder.

    python bench/league.py FOLDER [--only NAME] [--speed]

FOLDER holds recordings (docs/recording.md): folders with a moves.csv; so whoever has a robot adds a row. Of a folder
that holds logs alone, of a Universal Robot without a header (time, six joints, six speeds, SI), each way from rest to
rest becomes a joint move where the leading axis holds a speed for a quarter of it: that was programmed. Other folders
are named and left out. Of each recording, joint moves and paths (lines and arcs) apart:

- olp out of the box: nothing learnt, as `olp time` times a program of these moves, with the interval of each.
- olp, 20 moves: `olp calibrate` on twenty moves drawn at random, `olp predict` on all others; 100 moves likewise, of
  recordings of twice as many.
- olp, half: each program predicted after every second move of the other programs; where there is one program only,
  one half of the moves after the other half, drawn at random.
- olp, all seen: all moves after all moves, the asked ones among them: what the law itself leaves.
- olp, other programs: each program predicted after all moves of the other programs. Of several programs only.
- the maker's simulator: `sim_s`, told more than olp is.
- ruckig: time-optimal, the prior's speeds and accelerations, no limit of jerk; paths at programmed speed with the
  acceleration that was written, else the one that olp takes, at rest where they stop exactly.
- trapezoid fit: a speed and an acceleration per axis and one constant, least squares of relative errors on the moves
  that "half" learns from; the slowest axis decides. Joint moves only.

Errors are relative, of each move that a method predicts without having seen it ("all seen" aside): mean, median, 95th
percentile of their absolute values; of the total; how many measured times lie within the stated 95 % interval; and of
the total of each program of the recording, in the order of their names, where there are several.
"""

from __future__ import annotations

import argparse
import csv
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from olp.core.diagnostic import OlpError  # noqa: E402
from olp.identification.recorded_plan import unlearnt_times  # noqa: E402
from olp.identification.recording import Recording, read_recording  # noqa: E402
from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR, RecordedMoves  # noqa: E402
from olp.identification.signature import calibrate  # noqa: E402
from olp.identification.signature.joint_moves import recorded_joint_moves  # noqa: E402
from olp.identification.signature.rows import predict_recording  # noqa: E402
from olp.identification.signature.stretch_times import arc_length  # noqa: E402
from olp.robots.controller_effects import generations_in  # noqa: E402
from olp.robots.robot import load_robot  # noqa: E402
from olp.timing.arm import ArmTiming  # noqa: E402
from olp.timing.arm_prior import arm_prior, line_acceleration  # noqa: E402
from olp.timing.joint_times import KNOWN_DOUBT, ramp_doubt  # noqa: E402
from olp.timing.path_law import SCATTER  # noqa: E402

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
FEW, MORE = 20, 100
SEED = 20
_NORMAL = 1.96
_LOGGED = "universal-robots/ur10e"  # the arm of logs without a recording
_RESTING = 0.01  # [rad/s] slower is standing
_SHORT = 0.05  # [rad] less is a correction, not a move
_ASKED = 100_000  # rows
_EVEN, _HELD = 0.03, 0.25  # a programmed speed is held to this share, for this share of the time
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
    parser.add_argument("--speed", action="store_true", help="seconds of calibrating and predicting instead")
    args = parser.parse_args()
    if args.speed:
        for folder in sorted(path for path in args.folder.iterdir() if (path / "moves.csv").is_file()):
            if args.only in (None, folder.name):
                print(speed_of(folder.name, read_recording(folder)), flush=True)
        return
    print(
        "| recording | moves | method | mean % | median % | 95th % | total % | coverage % | totals of programs % |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    left_out = []
    for folder in sorted(path for path in args.folder.iterdir() if path.is_dir()):
        if args.only not in (None, folder.name):
            continue
        with tempfile.TemporaryDirectory() as place:
            recording = recording_of(folder, Path(place))
            if recording is None:
                left_out.append(folder.name)
                continue
            for line in rows_of(folder.name, recording):
                print(line, flush=True)
    if left_out:
        print(f"\nno moves in them that anything was programmed of, left out: {', '.join(left_out)}")


def speed_of(name: str, recording: Recording) -> str:
    """CPU seconds of learning from all moves, and of predicting `_ASKED` rows, its own again and again."""
    began = process_time()
    signature, _ = calibrate(recording)
    learnt = process_time() - began
    moves = recording.moves
    rows = np.resize(np.arange(len(moves)), _ASKED)
    many = replace(recording, moves=replace(moves.take(rows), move=np.arange(_ASKED)))
    began = process_time()
    predict_recording(signature, many)
    told = process_time() - began
    return f"{name}: calibrate {len(moves)} rows {learnt:.1f} s CPU, predict {_ASKED} rows {told:.2f} s CPU"


def recording_of(folder: Path, place: Path) -> Recording | None:
    """The recording in `folder`, else one that its logs make, written to `place`; None where there are neither."""
    if any((folder / name).is_file() for name in ("moves.csv", "moves.csv.gz", "moves.parquet")):
        return read_recording(folder)
    rows = [row for path in sorted(folder.glob("ur-*.csv.gz")) for row in moves_in_log(path)]
    if not rows:
        return None
    ends = [f"q{axis}_{end}_deg" for end in ("start", "end") for axis in range(1, 7)]
    with (place / "moves.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["move", "type", "program", "duration_s", "speed_pct", *ends])
        table.writerows([number, *row] for number, row in enumerate(rows, 1))
    (place / "recording.toml").write_text(
        f'robot = "{_LOGGED}"\ntime_resolution_s = 0.01\n', encoding="utf-8"
    )
    return read_recording(place)


def moves_in_log(path: Path) -> Iterator[list[object]]:
    """Type, program, duration [s], speed [%] and joints [deg] at both ends of each way from rest to rest."""
    table = np.loadtxt(path, delimiter=",")
    time, joints, rates = table[:, 0], table[:, 1:7], np.abs(table[:, 7:13])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], rates.max(axis=1) > _RESTING, [0]]).astype(int)))
    rated = load_robot(_LOGGED).speeds
    for first, last in edges.reshape(-1, 2).tolist():
        if first < 2 or last > len(time) - 2:
            continue  # cut off by the log
        start, end = joints[first - 1], joints[last]
        if np.abs(end - start).max() < _SHORT or (rates[first:last].max(axis=1) < _RESTING).any():
            continue
        leading = rates[first:last, int(np.argmax(np.abs(end - start)))]
        if np.mean(leading > (1 - _EVEN) * leading.max()) < _HELD:
            continue  # a streamed curve: no speed was programmed
        share = float(np.max(rates[first:last].max(axis=0) / rated))
        degrees = np.degrees([*start, *end]).round(3).tolist()
        yield [
            "joint",
            path.name.split(".")[0],
            round(float(time[last] - time[first - 1]), 4),
            100 * share,
            *degrees,
        ]


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
        return f"refused: {problem.diagnostics[0].message} | | | | |"
    measured = recording.moves.duration
    known = rows & np.isfinite(told.duration)
    if known.sum() < max(2, 0.05 * rows.sum()):
        return "– | – | – | – | – | –"
    error = 100 * np.abs(told.duration[known] / measured[known] - 1)
    names = _names(recording.moves)
    parts = [known & (names == name) for name in np.unique(names[known])] if len(names) else []
    total, *totals = (
        f"{100 * (told.duration[some].sum() / measured[some].sum() - 1):+.1f}" for some in (known, *parts)
    )
    inside = (told.low[known] <= measured[known]) & (measured[known] <= told.high[known])
    bounded = np.isfinite(told.low[known])
    coverage = f"{100 * np.mean(inside[bounded]):.0f}" if bounded.mean() > 0.5 else "–"
    figures = (error.mean(), np.median(error), np.percentile(error, 95))
    return " | ".join(
        [*(f"{v:.1f}" for v in figures), total, coverage, ", ".join(totals) if len(totals) > 1 else "–"]
    )


# --- olp --------------------------------------------------------------------------------------------------------------


@method("olp out of the box")
def out_of_the_box(recording: Recording) -> Told:
    moves = recording.moves
    told = Told.only(unlearnt_times(recording).duration)
    axes = len(recording.robot.axes) if recording.robot else moves.joints_start.shape[1]
    joints, rows = recorded_joint_moves(moves, recording.robot, recording.tool, axes)
    if len(rows):
        factor = np.exp(_NORMAL * _prior(recording, axes).spread(joints.motions))
        told.low[rows], told.high[rows] = told.duration[rows] / factor, told.duration[rows] * factor
    length, _, speed, _ = _asked(moves, recording)
    rows = np.flatnonzero(np.isin(moves.kind, (LINEAR, CIRCULAR)) & np.isfinite(told.duration))
    cruise = (length / speed)[rows]
    lines = line_acceleration(recording.robot, recording.settings.controller or "").doubt
    doubt = np.where(np.isfinite(moves.acceleration[rows]), KNOWN_DOUBT, lines)
    below, above = ramp_doubt(np.maximum(told.duration[rows] - cruise, 0.0), cruise, doubt)
    scatter = _NORMAL * SCATTER * told.duration[rows]
    told.low[rows] = told.duration[rows] - np.hypot(below, scatter)
    told.high[rows] = told.duration[rows] + np.hypot(above, scatter)
    return told


@method(f"olp, {FEW} moves")
def twenty(recording: Recording) -> Told:
    return _after(recording, min(FEW, int(np.sum(np.nan_to_num(recording.moves.duration) > 0)) // 2))


@method(f"olp, {MORE} moves")
def hundred(recording: Recording) -> Told:
    if len(recording.moves) < 2 * MORE:
        return Told(*np.full((3, len(recording.moves)), np.nan))
    return _after(recording, MORE)


def _after(recording: Recording, count: int) -> Told:
    measured = np.flatnonzero(np.nan_to_num(recording.moves.duration) > 0)
    seen = np.zeros(len(recording.moves), dtype=bool)
    seen[np.random.default_rng(SEED).choice(measured, count, replace=False)] = True
    return _learnt(recording, seen).without(seen)


@method("olp, half")
def half(recording: Recording) -> Told:
    told = Told(*np.full((3, len(recording.moves)), np.nan))
    for seen, asked in _halves(recording):
        found = _learnt(recording, seen)
        for values, new in zip(told, found, strict=True):
            values[asked] = new[asked]
    return told


@method("olp, other programs")
def other_programs(recording: Recording) -> Told:
    told = Told(*np.full((3, len(recording.moves)), np.nan))
    for seen, asked in _programs(recording, 1):
        for values, new in zip(told, _learnt(recording, seen), strict=True):
            values[asked] = new[asked]
    return told


@method("olp, all seen")
def all_seen(recording: Recording) -> Told:
    return _learnt(recording, np.nan_to_num(recording.moves.duration) > 0)


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
    measured = np.nan_to_num(moves.duration) > 0
    several = list(_programs(recording, 2))
    if not several:
        drawn = np.zeros(len(moves), dtype=bool)
        rows = np.flatnonzero(measured)
        drawn[np.random.default_rng(SEED).choice(rows, len(rows) // 2, replace=False)] = True
        yield drawn, measured & ~drawn
    yield from several


def _programs(recording: Recording, step: int) -> Iterator[tuple[Mask, Mask]]:
    """Each program, after each `step`th move of all others; nothing of a single one."""
    moves = recording.moves
    names = _names(moves)
    measured = np.nan_to_num(moves.duration) > 0
    programs = np.unique(names[measured]) if len(names) else []
    for program in programs if len(programs) > 1 else []:
        others = np.flatnonzero(measured & (names != program))
        seen = np.zeros(len(moves), dtype=bool)
        seen[others[::step]] = True
        yield seen, measured & (names == program)


def _names(moves: RecordedMoves) -> NDArray[np.str_]:
    """(n,) the program of each row; (0,) where none is written."""
    return np.array(moves.texts.get("program", moves.job), dtype=np.str_)


def _asked(moves: RecordedMoves, recording: Recording) -> tuple[Floats, tuple[Mask, Mask], Floats, Floats]:
    """Length [m], whether each path begins and ends rolling, speed [m/s] and acceleration [m/s²]; 1 where unknown."""
    path = np.isin(moves.kind, (LINEAR, CIRCULAR))
    length = np.where(path, np.nan_to_num(np.linalg.norm(moves.end - moves.start, axis=1)), 0.0)
    arc = np.flatnonzero((moves.kind == CIRCULAR) & np.isfinite(moves.via).all(axis=1))
    if len(arc):
        length[arc] = arc_length(moves.start[arc], moves.via[arc], moves.end[arc])
    usual = line_acceleration(recording.robot, recording.settings.controller or "").value
    push = np.where(np.isfinite(moves.acceleration), moves.acceleration, usual)
    ends = path & ((np.nan_to_num(moves.blend, nan=1.0) > 0) | (moves.level > 0))
    goes_on = path[1:] & path[:-1] & (np.linalg.norm(moves.end[:-1] - moves.start[1:], axis=1) < _SAME)
    ends &= np.append(goes_on, False)
    begins = np.insert(ends[:-1], 0, False)
    return length, (begins, ends), np.where(np.isfinite(moves.speed), moves.speed * moves.played, 1.0), push


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
        fraction = np.nan_to_num(moves.speed_fraction[rows], nan=1.0) * moves.played[rows]
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
    share = np.nan_to_num(moves.speed_fraction, nan=1.0) * moves.played
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
