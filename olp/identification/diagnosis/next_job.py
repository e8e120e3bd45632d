"""An experiment as a job for the robot, read again and looked at before it is given out.

Codes: N040 the job cannot be written, N041 what has to be looked at before it runs.
"""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error, warning
from olp.core.files import temporary_cell, write_output
from olp.core.source import decode
from olp.core.units import mm, percent
from olp.identification.diagnosis.result import NextExperiment, NextMove
from olp.ir import program as st
from olp.ir.expressions import Number, Quantity, Store, Taught
from olp.ir.points import PointTable, written_poses
from olp.languages.vendor import find_vendor, maker_of, probe_language, vendor_names
from olp.runtime.folder import DEFAULT_ZONES

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording
    from olp.robots.model import Robot

Floats = NDArray[np.float64]

NAME = "NEXT"
_FIRST = 5.0  # [%] of the axes' speed to the first point, from wherever the arm stands
_REST = 0.5  # [s] before and behind each run: the arm stands still, and a joint log can be cut there
_BETWEEN = 0.1  # [m/s] at most on the ways between runs, which nobody has measured
_MOST_TEXT = 32  # characters of a comment


def write_experiment_job(
    experiment: NextExperiment, recording: Recording, path: str | FilePath, tool_number: int = 0
) -> tuple[Diagnostic, ...]:
    """Writes the experiment's moves and timers as a program, and tells what to look at before it runs.

    The language is that of the path's suffix, else that of the recording's robot; further files that it takes stand
    beside the path.
    `tool_number`: what the controller calls the recorded tool. A run keeps the orientation of the recorded point
    nearest to its begin; the posture is the commonest recorded one. Raises OlpError: N040, X…; OSError.
    """
    from olp.transpile.convert import export

    if not experiment.moves and not experiment.timers:
        says = "there is no experiment to write: no moves are proposed"
        raise OlpError(error("N040", says, file=str(path), help=experiment.why))
    if tool_number == 0 and recording.tool is not None:
        tool_number = 1
    stem = FilePath(path).stem.upper()
    program = _program(experiment, recording, tool_number, stem if stem.isidentifier() else NAME)
    data = export(program, probe_language())
    told = _looked_at(data, recording, tool_number)
    vendor = _language(recording, FilePath(path))
    if vendor == probe_language():
        write_output(FilePath(path), data)
        return told
    beside, main = _translated(data, recording, vendor, FilePath(path))
    for name, more in beside.items():
        write_output(FilePath(path).with_name(name), more)
    write_output(FilePath(path), main)
    return told


def _language(recording: Recording, path: FilePath) -> str:
    """The vendor whose files have the path's suffix, else the maker of the recording's robot."""
    names = vendor_names()
    by_suffix = [n for n in names if path.suffix.lower() in find_vendor(n).suffixes]
    maker = recording.robot.maker.casefold() if recording.robot is not None else ""
    by_maker = [n for n in names if maker and maker_of(n).casefold() == maker]
    both = [n for n in by_suffix if n in by_maker]
    return next(iter(both or by_suffix or by_maker), probe_language())


def _translated(
    data: bytes, recording: Recording, vendor: str, path: FilePath
) -> tuple[dict[str, bytes], bytes]:
    """The files beside the program, by name, and the program itself. Raises OlpError (X…)."""
    from olp.languages.vendor import read
    from olp.transpile.context import Context
    from olp.transpile.convert import convert

    with temporary_cell() as folder:
        file = folder / f"{path.stem.upper()}.JBI"
        file.write_bytes(data)
        found = convert(read(str(file)), vendor, Context(recording.robot))
    beside = {name: more for name, more in found.files.items() if name != found.main}
    return beside, found.files[found.main]


# --- the program ------------------------------------------------------------------------------------------------------


class _Writer:
    """The body and the points of the job, in the order of running."""

    def __init__(self, zones: tuple[float, ...]) -> None:
        self.body: list[st.Statement] = [st.Begin(0)]
        self.places: list[tuple[float, float, float]] = []
        self.begins: list[
            int
        ] = []  # per place: that of the run's begin, whose orientation the whole run keeps
        self.zones = zones
        self.at: tuple[float, float, float] | None = None

    def go(
        self, place: tuple[float, float, float], speed: float, blend: float = 0.0, begin: bool = False
    ) -> None:
        pace = st.Speed(st.SpeedUnit.TRAVEL, Quantity(Number(round(speed / mm, 1)), mm))
        path = st.Path.LINEAR
        if self.at is None:
            path, pace = st.Path.JOINT, st.Speed(st.SpeedUnit.FRACTION, Quantity(Number(_FIRST), percent))
        level = st.Blend(st.BlendKind.LEVEL, Quantity(Number(self._level(blend)), 1.0))
        self.body.append(st.Move(0, path, (Taught(Store.ROBOT, len(self.places)),), pace, level))
        self.begins.append(len(self.places) if begin else self.begins[-1])
        self.places.append(place)
        self.at = place

    def say(self, text: str) -> None:
        self.body.append(st.Comment(0, text[:_MOST_TEXT]))

    def rest(self) -> None:
        self.body.append(st.Dwell(0, Quantity(Number(_REST), 1.0)))

    def wait_for(self, what: str) -> None:
        self.say(what)
        self.body.append(st.Pause(0))

    def _level(self, blend: float) -> int:
        """The position level whose zone is nearest to a rounding [m]; 0 stops."""
        if blend <= 0.0:
            return 0
        return 1 + int(np.argmin(np.abs(np.array(self.zones) - blend)))


def _program(experiment: NextExperiment, recording: Recording, tool: int, name: str) -> st.Program:
    writer = _Writer(_zones(recording.robot))
    writer.say("moves that separate rivals")
    setting: tuple[float | None, bool] | None = None
    for number, chain, now, times in _in_order(experiment.moves):
        if setting is not None and now != setting:
            writer.wait_for("after hours of running" if now[1] else f"carry {now[0] or 0.0:g} kg")
        elif setting is None and now[0] is not None:
            writer.say(f"carry {now[0]:g} kg")
        setting = now
        for _ in range(times):
            _run(writer, number, chain)
    for timer in experiment.timers:
        writer.say(f"measured: timer of {timer.duration:g} s")
        for _ in range(timer.times):
            writer.body.append(st.Dwell(0, Quantity(Number(timer.duration), 1.0)))
    writer.body.append(st.End(0))
    points = _points(writer, recording, tool)
    group = (st.ControlGroup(("RB1",)),)
    routine = st.Routine(name, 1, tuple(writer.body), points, group, comment="OLP DIAGNOSE")
    return st.Program(probe_language(), decode(b""), (routine,))


def _run(writer: _Writer, number: int, chain: list[NextMove]) -> None:
    # Also where the arm is there already: the tool may have to turn.
    writer.go(chain[0].start, _BETWEEN, begin=True)
    writer.say(f"measured: from move {number}")
    writer.rest()
    for move in chain:
        writer.go(move.end, move.speed, move.blend)
    writer.rest()


def _in_order(
    moves: tuple[NextMove, ...],
) -> list[tuple[int, list[NextMove], tuple[float | None, bool], int]]:
    """Runs with the number of their first move, by load and by whether the robot is warm; repeats of one follow it."""
    chains: list[tuple[int, list[NextMove]]] = []
    for number, move in enumerate(moves, 1):
        open_end = chains and chains[-1][1][-1]
        if open_end and open_end.why.startswith("first half") and open_end.end == move.start:
            chains[-1][1].append(move)
        else:
            chains.append((number, [move]))
    runs = [(n, c, (c[0].payload, "after hours" in c[0].why), c[0].times) for n, c in chains]
    return sorted(runs, key=lambda run: (run[2][1], run[2][0] or 0.0))


def _zones(robot: Robot | None) -> tuple[float, ...]:
    """[m] of PL = 1..8; those of a common arm where the robot's are not known."""
    return DEFAULT_ZONES if robot is None or robot.blend_zones is None else robot.blend_zones


def _points(writer: _Writer, recording: Recording, tool: int) -> PointTable:
    if not writer.places:
        return PointTable((), {})
    places = np.array(writer.places)
    angles = _nearest_angles(recording, places)[writer.begins]
    return written_poses(places, angles, tool, _posture(recording))


def _nearest_angles(recording: Recording, place: Floats) -> Floats:
    """(n, 3) [rad] The tool's orientation at the nearest recorded point. Raises OlpError (N040)."""
    moves = recording.moves
    places = np.concatenate([moves.start, moves.end])
    angles = np.concatenate([moves.start_angles, moves.end_angles])
    known = np.isfinite(np.concatenate([places, angles], axis=1)).all(axis=1)
    if not known.any():
        says = "the recording does not give the tool's orientation, so no job can be written"
        raise OlpError(
            error("N040", says, file=recording.path, help="give rx_deg, ry_deg, rz_deg in moves.csv")
        )
    apart = np.linalg.norm(place[:, None] - places[known][None], axis=2)
    return np.asarray(angles[known][np.argmin(apart, axis=1)])


def _posture(recording: Recording) -> tuple[int, ...]:
    """RCONF's first six flags: those that most recorded joint points have; in front, elbow up without any."""
    from olp.identification.probe.reach import PLAIN
    from olp.robots.kinematics.configuration import configuration_of

    moves, robot = recording.moves, recording.robot
    posed = moves.has_joints
    if robot is None or robot.geometry is None or robot.geometry.links is None or not posed.any():
        return PLAIN
    flags, count = np.unique(configuration_of(robot, moves.joints_start[posed]), axis=0, return_counts=True)
    return tuple(flags[np.argmax(count)].tolist())


# --- the look ---------------------------------------------------------------------------------------------------------


def _looked_at(data: bytes, recording: Recording, tool_number: int) -> tuple[Diagnostic, ...]:
    """The job's own bytes, read again and planned: errors are raised, the rest is told. Raises OlpError (N040)."""
    from olp.identification.probe.job import tool_file
    from olp.languages.vendor import read
    from olp.runtime.interpreter import run
    from olp.timing.retiming.along import along_path

    told = []
    if recording.tool is not None:
        told.append(f"the job uses TOOL {tool_number}: it must be the recorded tool")
    else:
        told.append(
            "the tool is not given: the job's points are those of TOOL 0, which must be the recorded tool"
        )
    with temporary_cell() as folder:
        file = folder / f"{NAME}.JBI"
        file.write_bytes(data)
        if recording.tool is not None:
            text = tool_file(tool_number, recording.tool)
            (folder / "TOOL.CND").write_text(text, encoding="ascii")
        program = read(str(file))
        found = list(program.diagnostics)
        if recording.robot is not None:
            plan = run(program, recording.robot)
            limits = along_path(plan)
            found += plan.diagnostics
            told += [f"line {d.line}: {d.message}" for d in limits.diagnostics]
        else:
            told.append("no robot is known: nothing proves that the moves can be run")
    bad = [d.message for d in found if d.is_error]
    if bad:
        raise OlpError(*(error("N040", f"the job was not written: {text}") for text in bad))
    return tuple(warning("N041", text, help="run the job slowly once, without measuring") for text in told)
