"""Makes a recording out of what a controller, a client or ROS recorded of its own accord.

Codes: D050 to D052 of `olp.languages.recorders`, D053 a file that no known recorder wrote, D054 simulated motions that
do not belong to the measured ones, D060 how motions were found in a log that knows of none, or that none was.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error, info, warning
from olp.core.terminal import csv_text
from olp.core.units import deg, mm
from olp.identification.recording.column_naming import NamedColumn, doubtful_units, meant_by
from olp.identification.recording.columns import nearest
from olp.identification.recording.log import Log
from olp.identification.recording.log_reader import column_names, read_log
from olp.identification.recording.ros_bag import Trajectory, is_bag, read_bag
from olp.identification.recording.segments import rest, still_of_axes, stretches_between_rests
from olp.identification.recording.writer import log_csv
from olp.languages.recorders import (
    ControllerMotion,
    ControllerRecorder,
    ControllerRun,
    controller_logs,
    recorders,
)
from olp.robots.robot import library_name

if TYPE_CHECKING:
    from olp.robots.model import Robot


Floats = NDArray[np.float64]
_MOST_NAMED = 12
_POINT = ("x", "y", "z", "rx", "ry", "rz")
_UNITS = ("mm", "mm", "mm", "deg", "deg", "deg")


@dataclass(frozen=True, slots=True)
class ImportedRecording:
    """The files of a recording as text; `log` is empty for several runs, whose clocks have nothing in common."""

    moves: str
    log: bytes
    robot: str  # name of the library, "" where it is not there
    count: int
    seconds: float
    period: float
    tool: tuple[float, ...] | None
    controller: str
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class ImportOptions:
    """What the files do not say: `naming` of a table's columns, `topic` and order of `joints` of a ROS recording."""

    naming: tuple[NamedColumn, ...] = ()
    robot: Robot | None = None
    topic: str = ""
    joints: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ImportedRun:
    """A run and, where it is not a controller's trace, the log that it was made of."""

    run: ControllerRun
    log: Log | None = None


def import_runs(
    paths: Sequence[Path],
    sim: Sequence[Path] = (),
    override: float | None = None,
    options: ImportOptions | None = None,
) -> ImportedRecording:
    """The recording of these files, each a log or a part of a controller's own recording. Raises OlpError.

    `override` [%]: the program override under which all of them ran, which traces do not tell.
    """
    options = options or ImportOptions()
    imported = read_runs(paths, options)
    runs = [one.run for one in imported]
    told = [d for run in runs for d in run.diagnostics]
    simulated: list[ControllerMotion] | None = None
    if sim:
        others = [one.run for one in read_runs(sim, options)]
        told += [d for run in others for d in run.diagnostics]
        simulated = _paired(runs, others)
    rows = [row for run in runs for row in _rows(run)]
    for number, row in enumerate(rows):
        row["move"] = number + 1
        if len(runs) > 1:
            del row["t_start_s"]  # each run has a clock of its own
        if override is not None:
            row["override_pct"] = override
        if simulated is not None:
            other = simulated[number]
            row["sim_s"] = _rounded(other.end - other.begin)
            row.update({f"sim_{k}": v for k, v in other.says.items() if k.startswith("payload")})
    names = list(dict.fromkeys(name for row in rows for name in row))
    names.sort(key=lambda name: name != "move")
    moves = csv_text([names, *([row.get(name, "") for name in names] for row in rows)])
    robots = {run.robot for run in runs}
    if len(robots) > 1:
        says = f"these are recordings of several robots: {', '.join(sorted(robots))}"
        raise OlpError(error("D054", says, help="make one recording of each"))
    tools = {run.flange_tool for run in runs}
    name = library_name(runs[0].robot)
    if not name and options.robot is None:
        told.append(_without_robot(runs[0].robot, paths[0]))
    return ImportedRecording(
        moves,
        _log(imported[0]) if len(runs) == 1 else b"",
        name,
        len(rows),
        sum(m.end - m.begin for run in runs for m in run.motions),
        max(run.period for run in runs),
        tools.pop() if len(tools) == 1 else None,
        runs[0].controller,
        tuple(told),
    )


def _without_robot(called: str, path: Path) -> Diagnostic:
    if called:
        return warning("D053", f"{called} is not in the library", help="see olp robots")
    return info("D053", "no robot is named", file=str(path), help="--robot, one of olp robots")


def read_runs(paths: Iterable[Path], options: ImportOptions) -> list[ImportedRun]:
    """Each recording once, whichever of its files are named; folders for all that they hold. Raises OlpError."""
    sets: dict[Path, ControllerRecorder] = {}
    logs: list[Path] = []
    problems: list[Diagnostic] = []
    for path in paths:
        folder = path.is_dir() and not is_bag(path)
        known = len(sets)
        for file in sorted(path.iterdir()) if folder else [path]:
            found = next(((s, r) for r in recorders() if (s := r.set_of(file)) is not None), None)
            if found is not None:
                sets.setdefault(*found)
            elif not folder:
                logs.append(file)
        if folder and len(sets) == known:
            problems.append(_unknown(path))
    made = (
        [ImportedRun(recorder.read(stem)) for stem, recorder in sorted(sets.items())] if not problems else []
    )
    for file in logs:
        try:
            log, told, trajectories = read_any_log(file, options)
            robot = options.robot.name if options.robot is not None else ""
            made.append(ImportedRun(run_of_log(log, robot, told, trajectories), log))
        except OlpError as problem:
            problems += problem.diagnostics
    if problems:
        raise OlpError(*problems)
    return made


def read_any_log(path: Path, options: ImportOptions) -> tuple[Log, list[Diagnostic], tuple[Trajectory, ...]]:
    """A ROS recording, or a table of samples. Raises OlpError, D053 for what is neither."""
    if is_bag(path):
        bag = read_bag(path, options.topic, options.joints)
        return bag.log, list(bag.diagnostics), bag.trajectories
    if not options.naming and not is_log(path, options):
        raise OlpError(_unknown(path))
    log, told, _ = read_log(path, options.naming, options.robot)
    return log, [*told, *doubtful_units(log)], ()


def is_log(path: Path, options: ImportOptions) -> bool:
    """Whether the file's columns are those of a log, or nearly. Raises OlpError for what is no table."""
    names = column_names(path)
    axes = options.robot.axis_names if options.robot is not None else ()
    if any(log.knows(names) for log in controller_logs()):
        return True
    like = [
        name
        for name in ("t_s", "q1_deg", "q2_deg")
        if name in names or meant_by(name, names, axes) or nearest(name, names)
    ]
    return len(like) >= 2


def _unknown(path: Path) -> Diagnostic:
    known = [*(recorder.files for recorder in recorders()), *(log.files for log in controller_logs())]
    help = f"known are {'; '.join(known)}; ROS recordings; any table of axes with --robot and --column"
    if path.is_dir():
        within = ", ".join(sorted(one.name for one in path.iterdir() if one.is_dir())[:_MOST_NAMED])
        help = f"folders in it: {within}; name the one that holds the recording" if within else help
        return error("D053", "no controller's recording is in this folder", file=str(path), help=help)
    try:
        names = column_names(path)
    except OlpError as problem:
        return problem.diagnostics[0]
    if all(name.isdecimal() for name in names):
        says = f"the file begins with numbers: nothing names its {len(names)} columns"
        help = "name them by their numbers, with the unit: --column t_s=1 --column q1_deg=2 …"
        return error("D053", says, file=str(path), help=help)
    listed = ", ".join(names[:_MOST_NAMED]) + (" …" if len(names) > _MOST_NAMED else "")
    if any(nearest(name, ("duration_s", "line")) for name in names):
        help = f"a table of times needs --job, the program that was timed; {help}"
    return error("D053", f"no recording is known with columns {listed}", file=str(path), help=help)


def _paired(runs: Sequence[ControllerRun], others: Sequence[ControllerRun]) -> list[ControllerMotion]:
    """The simulated motion of each measured one: motions of the same kinds between the same axes, in the same order.

    A simulated program may have other lines. Raises OlpError (D054).
    """
    real = [(run, m) for run in runs for m in run.motions]
    other = [(run, m) for run in others for m in run.motions]
    if len(real) != len(other):
        says = f"{len(real)} measured motions and {len(other)} simulated ones"
        raise OlpError(error("D054", says, help="name the recordings of the same programs with --sim"))
    for (run, motion), (sim, moved) in zip(real, other, strict=True):
        ends = [
            run.joints[_sample(run, m)] - sim.joints[_sample(sim, n)]
            for m, n in ((motion.begin, moved.begin), (motion.end, moved.end))
        ]
        if motion.kind != moved.kind or max(float(np.abs(end).max()) for end in ends) > _APART:
            lines = f"{_called(run, motion)} and {_called(sim, moved, 'the simulated ')}"
            says = f"{lines} are not the same motion"
            raise OlpError(error("D054", says, help="name the recordings of the same programs with --sim"))
    return [m for _, m in other]


def _called(run: ControllerRun, motion: ControllerMotion, which: str = "") -> str:
    place = f"line {motion.line}" if motion.line else f"the motion at {motion.begin:.3f} s"
    return f"{place} of {which}{run.name}"


_APART = 30.0  # [deg] of an axis: samples lie a cycle apart, in which an arm turns less


def _rows(run: ControllerRun) -> list[dict[str, float | int | str]]:
    rows = []
    for motion in run.motions:
        row: dict[str, float | int | str] = {
            "move": 0,
            "type": motion.kind,
            "duration_s": _rounded(motion.end - motion.begin),
            "trace": run.name,
            **({"job": motion.job, "line": motion.line} if motion.line else {}),
            "t_start_s": _rounded(motion.begin),
            **motion.says,
        }
        for end, instant in (("start", motion.begin), ("end", motion.end)):
            at = _sample(run, instant)
            row.update(
                {
                    f"q{n + 1}_{end}_{'mm' if run.slides and run.slides[n] else 'deg'}": round(float(q), 6)
                    for n, q in enumerate(run.joints[at])
                }
            )
            if run.tool is not None:
                row.update(_point(run.tool[at], end, 6))
        if motion.kind == "circular" and run.tool is not None:
            row.update(_point(run.tool[_sample(run, (motion.begin + motion.end) / 2)], "via", 3))
        rows.append(row)
    return rows


def _sample(run: ControllerRun, instant: float) -> int:
    return nearest_sample(run.time, instant)


def _point(place: Floats, end: str, count: int) -> dict[str, float]:
    cells = zip(_POINT, place.tolist(), _UNITS, strict=True)
    return {f"{name}_{end}_{unit}": round(value, 6) for name, value, unit in list(cells)[:count]}


def _rounded(seconds: float) -> float:
    return round(seconds, 6)


def _log(imported: ImportedRun) -> bytes:
    run = imported.run
    if imported.log is not None:
        return log_csv(with_counter(imported.log, run))
    axes = run.joints.shape[1]
    names = ["t_s", *(f"q{n + 1}_deg" for n in range(axes))]
    columns = [run.time, *run.joints.T]
    if run.tool is not None:
        names += [f"{name}_{unit}" for name, unit in zip(_POINT, _UNITS, strict=True)]
        columns += list(run.tool.T)
    number = np.full(len(run.time), -1)
    for index, motion in enumerate(run.motions):
        number[(run.time >= motion.begin - 1e-9) & (run.time < motion.end - 1e-9)] = index + 1
    cells = [[f"{v:.6f}" for v in column] for column in columns] + [[str(n) for n in number]]
    return csv_text([[*names, "move"], *zip(*cells, strict=True)]).encode()


# --- Motions in a log that knows of none: what lies between two rests of the arm ---


_STRAIGHT = 1e-3  # of a way's length that it may leave its chord by
_BLOCK = 0.02  # [s] that are averaged where samples are denser: shorter rests are none
_AT_SPEED = 0.2  # of a motion's highest speed: from a rest it is not reached within two samples
_CLEARLY = 3.0  # times what is noise: motions that go no farther are none
_LEAST_WAY = 0.3 * mm  # that a straight way may leave its chord by, however short


def run_of_log(
    log: Log, robot: str, told: Sequence[Diagnostic], trajectories: Sequence[Trajectory] = ()
) -> ControllerRun:
    """The log as a run with its motions. `trajectories`: they are the motions. Raises OlpError (D060).

    A motion lasts from when the arm leaves its rest to when it arrives at the next one. It is linear where the tool
    goes straight and the axes do not, else joint: an arc cannot be told from a joint move.
    """
    if trajectories:
        spans = [(float(t.time[0]), float(t.time[-1])) for t in trajectories]
    else:
        found = motions_between_rests(log)
        spans = [span for span in found if not _is_cut(log, span)]
        told = [*told, *(_left_out(log, span) for span in found if span not in spans)]
        says = f"{len(spans)} motions between rests; moves without a stop between them are one"
        told = [*told, info("D060", says, file=log.file, help="--job PROGRAM tells them apart")]
    if not spans:
        raise OlpError(error("D060", "no motion begins and ends in this log", file=log.file), *told)
    units = np.where(np.array(log.slides, dtype=bool), mm, deg)
    tool = None
    if log.position is not None and log.angles is not None:
        tool = np.concatenate([log.position / mm, log.angles / deg], axis=1)
    return ControllerRun(
        Path(log.file).name,
        robot,
        log.period,
        tuple(ControllerMotion(_kind(log, *span), "", 0, *span) for span in spans),
        log.time,
        log.q / units,
        tool,
        diagnostics=tuple(told),
        slides=log.slides,
    )


def motions_between_rests(log: Log) -> list[tuple[float, float]]:
    """[s] when the arm leaves its rest and when it arrives at the next one, of each motion."""
    still = still_of_axes(log)
    coarse = _averaged(log)
    noise = still_of_axes(coarse)
    found = [
        span
        for span in stretches_between_rests(coarse.time, coarse.q, noise)
        if _farthest(coarse, *span) > _CLEARLY * noise
    ]
    spans = []
    for number, (begin, end) in enumerate(found):
        before = found[number - 1][1] if number else float(log.time[0])
        after = found[number + 1][0] if number + 1 < len(found) else float(log.time[-1])
        middle = (begin + end) / 2
        left = _rest_within(log, before, middle, begin, still)
        came = _rest_within(log, middle, after, end, still)
        leave = begin if left is None or not np.isfinite(left[1]) else left[1]
        arrive = end if came is None or not np.isfinite(came[0]) else came[0]
        if arrive > leave:
            spans.append((leave, arrive))
    return spans


def _is_cut(log: Log, span: tuple[float, float]) -> bool:
    """Whether the log begins or ends within the motion: the arm is at speed at the log's first or last sample."""
    inside = (log.time >= span[0]) & (log.time <= span[1])
    quickest = float(np.linalg.norm(np.diff(log.q[inside], axis=0), axis=1).max(initial=0.0))
    edges = []
    if span[0] <= log.time[min(2, len(log) - 1)]:
        edges.append(log.q[:3])
    if span[1] >= log.time[max(len(log) - 3, 0)]:
        edges.append(log.q[-3:])
    paces = [float(np.linalg.norm(edge[-1] - edge[0])) / max(len(edge) - 1, 1) for edge in edges]
    return any(pace > _AT_SPEED * quickest for pace in paces)


def _left_out(log: Log, span: tuple[float, float]) -> Diagnostic:
    says = f"the motion from {span[0]:.3f} to {span[1]:.3f} s is left out: the log begins or ends within it"
    return warning("D060", says, file=log.file, help="record from a rest to a rest")


def _averaged(log: Log) -> Log:
    """The log with a sample for each `_BLOCK` at most: noise of many samples within it hides no rest."""
    size = max(int(_BLOCK / log.period), 1) if len(log) > 1 and log.period > 0 else 1
    count = len(log) // size
    if size == 1 or count < 3:
        return log
    time = log.time[: count * size].reshape(count, size).mean(axis=1)
    q = log.q[: count * size].reshape(count, size, -1).mean(axis=1)
    return Log(time, q, log.slides)


def _farthest(log: Log, begin: float, end: float) -> float:
    """[rad | m] how far the axes go from where they are at `begin` [s]."""
    first, last = np.searchsorted(log.time, [begin, end])
    return float(np.linalg.norm(log.q[first : last + 1] - log.q[first], axis=1).max(initial=0.0))


def _rest_within(log: Log, low: float, high: float, at: float, still: float) -> tuple[float, float] | None:
    """When the arm came to the rest that lies between `low` and `high` [s], and when it left; `at` is at its edge."""
    first, last = np.searchsorted(log.time, [low, high], side="left")
    part = slice(int(first), int(last) + 1)
    standing = nearest_sample(log.time, at)
    found = rest(log.time[part], log.q[part], log.q[standing], still, dwells=True)
    return None if found is None else (found.arrive, found.leave)


def nearest_sample(time: Floats, instant: float) -> int:
    """The index of the sample nearest to `instant` [s]; `time` (n,) [s] in order."""
    after = int(np.clip(np.searchsorted(time, instant), 1, max(len(time) - 1, 1)))
    return after - 1 if len(time) < 2 or instant - time[after - 1] <= time[after] - instant else after


def _kind(log: Log, begin: float, end: float) -> str:
    first, last = np.searchsorted(log.time, [begin, end])
    inside = slice(int(first), int(last) + 1)
    if log.position is None or last - first < 5:
        return "joint"
    tool, axes = _bow(log.position[inside]), _bow(log.q[inside])
    return "linear" if tool is not None and tool < 1 and (axes is None or axes > 1) else "joint"


def _bow(way: Floats) -> float | None:
    """How far a way (n, c) leaves its chord, in what a straight one may; None for one that goes nowhere."""
    chord = way[-1] - way[0]
    length = float(np.linalg.norm(chord))
    if length < 10 * _LEAST_WAY:
        return None
    beside = (way - way[0]) - np.outer((way - way[0]) @ chord, chord) / length**2
    return float(np.linalg.norm(beside, axis=1).max()) / max(_STRAIGHT * length, _LEAST_WAY)


def with_counter(log: Log, run: ControllerRun) -> Log:
    """The same log; its column `move` numbers the run's motions from 1, -1 between them."""
    number = np.full(len(log), -1, dtype=np.int64)
    for index, motion in enumerate(run.motions):
        first, last = np.searchsorted(log.time, [motion.begin - 1e-9, motion.end - 1e-9])
        number[first:last] = index + 1
    return replace(log, move=number)
