"""The experiment as a job for the robot, with moves.csv to fill in, and the proof: the job's own bytes, read again and
planned.

Code: Q006 the job does not do what was designed.
"""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.core.files import temporary_cell, write_output
from olp.core.source import decode
from olp.core.units import deg, mm, percent
from olp.identification.probe.experiment import Experiment
from olp.identification.recording.moves import LINEAR, RecordedMoves
from olp.identification.recording.settings import RecordingSettings
from olp.identification.recording.writer import write_recording
from olp.ir import program as st
from olp.ir.expressions import Number, Quantity, Store, Taught
from olp.ir.points import PointTable, written_poses
from olp.languages.vendor import probe_language
from olp.robots.geometry import Pose
from olp.transpile.convert import export

NAME = "PROBE"
# [%] of the axes' speed on the way to the first point, from wherever the arm stands.
_FIRST = 5.0
# [s] before and behind each measured move: the arm stands still, and a joint log can be cut there.
REST = 0.5
# [m] A controller's own points are written to a thousandth of a millimetre.
_SAME = 0.02 * mm
_STOP = st.Blend(st.BlendKind.LEVEL, Quantity(Number(0), 1.0))


class Proved(NamedTuple):
    """`lines`: of the measured moves, 1-based, in the order of running. `duration` [s] of the job as olp times it."""

    data: bytes
    lines: tuple[int, ...]
    duration: float


def proved_job(experiment: Experiment, date: str | None = None) -> Proved:
    """The job's bytes, proved. `date`: YYYY/MM/DD HH:MM. Raises OlpError: Q006, X…"""
    program = _program(experiment)
    data = export(program, probe_language(), date=date)
    return Proved(data, *_prove(experiment, data))


def _program(experiment: Experiment) -> st.Program:
    used = [int(experiment.starts[0])]
    body: list[st.Statement] = [st.Begin(0)]
    body.append(st.Comment(0, "to the first point from anywhere"))
    body.append(_move(st.Path.JOINT, 0, st.Speed(st.SpeedUnit.FRACTION, Quantity(Number(_FIRST), percent))))
    pace = Number(round(experiment.wanted.speed / mm, 1))
    speed = st.Speed(st.SpeedUnit.TRAVEL, Quantity(pace, mm))
    rest = st.Dwell(0, Quantity(Number(REST), 1.0))

    def go(point: int) -> None:
        body.append(_move(st.Path.LINEAR, len(used), speed))
        used.append(point)

    for number, (end, before) in enumerate(zip(experiment.ends.tolist(), experiment.before, strict=True)):
        for point in before:
            go(point)
        body.append(st.Comment(0, f"measured: move {experiment.first + number}"))
        body.append(rest)
        go(end)
        body.append(rest)
    body.append(st.End(0))
    points = _points(experiment, np.array(used, dtype=np.int64))
    routine = st.Routine(
        NAME, 1, tuple(body), points, (st.ControlGroup(("RB1",)),), comment="SIGNATURE PROBE"
    )
    return st.Program(probe_language(), decode(b""), (routine,))


def _move(path: st.Path, number: int, speed: st.Speed) -> st.Move:
    return st.Move(0, path, (Taught(Store.ROBOT, number),), speed, _STOP)


def _points(experiment: Experiment, used: NDArray[np.int64]) -> PointTable:
    wanted = experiment.wanted
    angles = np.broadcast_to(np.array(wanted.angles), (len(used), 3))
    return written_poses(experiment.points[used], angles, wanted.tool_number, experiment.posture)


# --- the proof ------------------------------------------------------------------------------------------------


def _prove(experiment: Experiment, data: bytes) -> tuple[tuple[int, ...], float]:
    from olp.languages.vendor import read
    from olp.runtime.interpreter import run
    from olp.timing.retiming.along import along_path
    from olp.timing.timing import time_plan

    with temporary_cell() as folder:
        file = folder / f"{NAME}.JBI"
        file.write_bytes(data)
        if experiment.wanted.tool is not None:
            text = tool_file(experiment.wanted.tool_number, experiment.wanted.tool)
            (folder / "TOOL.CND").write_text(text, encoding="ascii")
        program = read(str(file))
        plan = run(program, experiment.wanted.robot)
        limits = along_path(plan)
        found = [*program.diagnostics, *plan.diagnostics, *limits.diagnostics]
        says = [d.message for d in found if d.is_error or d in limits.diagnostics]
        lines = _measured(program)
        says += _differences(experiment, plan, lines)
        straight = np.asarray(plan.moves.length > 0) & np.isfinite(plan.moves.travel)
        if not limits.known[straight].all() or np.any(limits.outside >= 0):
            says.append("a line leaves the soft limits or cannot be followed")
        duration = float(time_plan(plan).duration_s.sum())
    if says:
        raise OlpError(*(error("Q006", f"the job was not written: {text}") for text in says))
    return lines, duration


def _measured(program: st.Program) -> tuple[int, ...]:
    """The line of the first straight move behind each comment that announces one."""
    found, waiting = [], False
    for statement in program.statements():
        if isinstance(statement, st.Comment) and statement.text.startswith("measured"):
            waiting = True
        elif waiting and isinstance(statement, st.Move):
            found.append(statement.line)
            waiting = False
    return tuple(found)


def _differences(experiment: Experiment, plan: object, lines: tuple[int, ...]) -> list[str]:
    from olp.runtime.plan import BlendCode, Plan, StepKind

    assert isinstance(plan, Plan)
    moves, positions = plan.moves, plan.positions.position
    rows = {
        int(line): int(row)
        for line, row, kind in zip(plan.line, plan.row, plan.kind, strict=True)
        if kind == StepKind.MOVE
    }
    if len(lines) != len(experiment.ends) or any(line not in rows for line in lines):
        return ["it does not run the moves that were designed"]
    row = np.array([rows[line] for line in lines])
    box = experiment.wanted.box
    says = []
    start, end = positions[moves.start[row]], positions[moves.target[row]]
    wanted = experiment.points[experiment.starts], experiment.points[experiment.ends]
    if max(np.abs(start - wanted[0]).max(), np.abs(end - wanted[1]).max()) > _SAME:
        says.append("its points are not those that were designed")
    if np.any(positions < box[:, 0] - _SAME) or np.any(positions > box[:, 1] + _SAME):
        says.append("a point lies outside the box")
    if np.any(moves.blend_code != BlendCode.EXACT):
        says.append("a move does not end in an exact stop")
    if np.any(np.abs(moves.travel[row] - experiment.wanted.speed) > 0.06 * mm):
        says.append("its speed is not the one that was asked for")
    return says


def tool_file(number: int, tool: Pose) -> str:
    """TOOL.CND for the proof alone: on a controller it would replace the tools that are there."""
    numbers = (tool.xyz_angles() / ([mm] * 3 + [deg] * 3)).tolist()
    blank = ["0.000,0.000,0.000", "0.000", "0.000,0.000,0.000", "0.000,0,1"]
    text: list[str] = []
    for tag, six in ((0, [0.0] * 6), (number, numbers)):
        row = ",".join(f"{v:.{3 if i < 3 else 4}f}" for i, v in enumerate(six))
        text += [f"//TOOL {tag}", "///NAME", row, *blank]
    return "\r\n".join([*text, ""])


# --- The folder: the job, moves.csv to fill in, recording.toml ---


JOB = f"{NAME}.JBI"
_NOTE = """Designed by olp probe. Run the job, write each measured move's duration into moves.csv, then:
    olp calibrate THIS_FOLDER --method averaged_process -o robot.signature.json
time_resolution_s: what the durations are read to."""


def write_experiment(
    experiment: Experiment, folder: str | FilePath, robot: str = "", date: str | None = None
) -> Proved:
    """Proves the job, then writes PROBE.JBI, moves.csv and recording.toml.

    `robot`: what recording.toml names, by default the robot's name in the library. Raises OlpError (Q006), OSError.
    """
    proved = proved_job(experiment, date)
    wanted = experiment.wanted
    tool = None
    if wanted.tool is not None:
        tool = tuple(float(v) for v in wanted.tool.xyz_angles())
    settings = RecordingSettings(
        robot=robot or wanted.robot.name,
        controller=wanted.robot.controllers[0] if len(wanted.robot.controllers) == 1 else "",
        time_resolution=0.01,
        tool=tool,
        job=JOB,
    )
    FilePath(folder).mkdir(parents=True, exist_ok=True)
    write_output(FilePath(folder) / JOB, proved.data)
    write_recording(folder, _rows(experiment, proved.lines), settings, comment=_NOTE)
    return proved


def _rows(experiment: Experiment, lines: tuple[int, ...]) -> RecordedMoves:
    """moves.csv without durations."""
    count = len(lines)
    nothing = np.full(count, np.nan)
    places = np.full((count, 3), np.nan)
    angles = np.broadcast_to(np.array(experiment.wanted.angles), (count, 3))
    joints = np.zeros((count, 0))
    return RecordedMoves(
        move=np.arange(experiment.first, experiment.first + count, dtype=np.int64),
        kind=np.full(count, LINEAR, dtype=np.int8),
        duration=nothing,
        sim=nothing,
        start=np.round(experiment.points[experiment.starts] / mm, 3) * mm,
        end=np.round(experiment.points[experiment.ends] / mm, 3) * mm,
        via=places,
        start_angles=angles,
        end_angles=angles,
        joints_start=joints,
        joints_end=joints,
        slides=(),
        speed=np.full(count, experiment.wanted.speed),
        speed_fraction=nothing,
        acceleration=nothing,
        acceleration_fraction=nothing,
        blend=np.zeros(count),
        level=np.zeros(count, dtype=np.int8),
        t_start=nothing,
        cycle=np.full(count, -1, dtype=np.int64),
        line=np.array(lines, dtype=np.int64),
        job=(JOB,) * count,
        payload=nothing,
        payload_inertia=nothing,
        covariates={"information_rank": (experiment.rank + 1).astype(np.float64)},
    )
