"""The folder of an experiment: the job, moves.csv to fill in, recording.toml."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from olp.core.files import write_output
from olp.core.units import mm
from olp.identification.probe.experiment import Experiment
from olp.identification.probe.job import NAME, Proved, proved_job
from olp.identification.recording.moves import LINEAR, RecordedMoves
from olp.identification.recording.settings import RecordingSettings
from olp.identification.recording.writer import write_recording

JOB = f"{NAME}.JBI"
_NOTE = """Designed by olp probe. Run the job, write each measured move's duration into moves.csv, then:
    olp calibrate THIS_FOLDER --method averaged_process -o robot.signature.json
time_resolution_s: what the durations are read to."""


def write_experiment(
    experiment: Experiment, folder: str | Path, robot: str = "", date: str | None = None
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
    Path(folder).mkdir(parents=True, exist_ok=True)
    write_output(Path(folder) / JOB, proved.data)
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
