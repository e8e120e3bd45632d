"""Finds motions in a log that knows of none: what lies between two rests of the arm.

Code: D060 how the motions were found, or that none was.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error, info, warning
from olp.core.units import deg, mm
from olp.identification.recording.log import Log
from olp.identification.recording.ros_bag import Trajectory
from olp.identification.recording.segments import rest, still_of_axes, stretches_between_rests
from olp.languages.recorders import ControllerMotion, ControllerRun

Floats = NDArray[np.float64]
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
