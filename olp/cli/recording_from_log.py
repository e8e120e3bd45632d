"""`olp recording from-log`: the measured moves of a recording, out of a joint log and the program that ran."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from olp.cli._timing import add_timing_arguments, print_diagnostics, timing_job_of
from olp.core.source import file_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from olp.core.diagnostic import Diagnostic
    from olp.identification.recording.from_log import By
    from olp.identification.recording.log import Log
    from olp.identification.recording.moves import Floats, RecordedMoves
    from olp.identification.recording.settings import RecordingSettings
    from olp.timing.result import Timing

SUMMARY = "make moves.csv out of a joint log and the program that ran"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("log", metavar="LOG", help="log.csv, log.csv.gz or log.parquet")
    parser.add_argument("job", metavar="JOB", help="the program that ran")
    parser.add_argument(
        "-o", "--output", required=True, metavar="DIR", help="the folder of the recording, created if needed"
    )
    parser.add_argument(
        "--by",
        choices=("auto", "points", "counter", "dwell"),
        default="auto",
        help="how moves are separated: by the programmed points, by the log's column move, by the stops alone "
        "(default: the column if there is one, else the points if the robot is known)",
    )
    parser.add_argument("--with-log", action="store_true", help="put the log into the folder too")
    parser.add_argument("--force", action="store_true", help="replace a moves.csv that is there")
    add_timing_arguments(parser)


def run(args: Namespace) -> int:
    from olp.core.diagnostic import OlpError, error
    from olp.core.files import refuse_inputs
    from olp.identification.recording.log_reader import read_log
    from olp.identification.timing_job import plan_and_time

    target = Path(args.output) / "moves.csv"
    if target.exists() and not args.force:
        raise OlpError(
            error(
                "C009",
                "this file exists and was not changed",
                file=str(target),
                help="name another folder with -o, or say --force to replace it",
            )
        )
    refuse_inputs(Path(args.output) / "log.csv" if args.with_log else target, [args.log, args.job])
    log, told, _ = read_log(Path(args.log))
    timing = plan_and_time(args.job, timing_job_of(args))
    write_from_log(args, Path(args.log), log, told, timing, args.by, args.with_log)
    return 0


def write_from_log(
    args: Namespace,
    file: Path,
    log: Log,
    told: Sequence[Diagnostic],
    timing: Timing,
    by: By = "auto",
    with_log: bool = True,
    maker: str = "from-log",
) -> None:
    """Writes the moves of the program `args.job` that `log`, read from `file`, shows, and prints them."""
    from olp.identification.recording.from_log import moves_from_log
    from olp.identification.recording.writer import write_recording

    made = moves_from_log(log, timing, by)
    settings = settings_of_run(args, timing, log.period, made.tool)
    comment = f"Made by olp recording {maker} of {file.name} and {os.path.basename(args.job)}."
    write_recording(args.output, made.moves, settings, log if with_log else None, comment)
    print(table_of_moves(made.moves, made.planned, timing, made.by))
    print_diagnostics([d.at(args.job) for d in (*timing.diagnostics, *told, *made.diagnostics)])


def settings_of_run(
    args: Namespace, timing: Timing, period: float | None, tool: tuple[float, ...] | None
) -> RecordingSettings:
    """recording.toml of the program `args.job` in the folder `args.output`.

    `period` [s]: of a log's samples, between which instants are found, so that one is what they resolve at worst.
    """
    from olp.identification.recording.settings import RecordingSettings
    from olp.robots.robot import robot_names

    robot = timing.plan.robot
    name = ""
    if robot is not None and robot.name in robot_names():
        name = robot.name
    elif args.robot and args.robot.lower().endswith(".toml"):
        name = _seen_from(args.output, args.robot)
    job = _seen_from(args.output, args.job)
    resolution = None if period is None else float(f"{period:.3g}")
    return RecordingSettings(robot=name, time_resolution=resolution, tool=tool, job=job)


def _seen_from(folder: str, path: str) -> str:
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:  # another drive on Windows
        return Path(path).resolve().as_posix()


def table_of_moves(moves: RecordedMoves, planned: Floats, timing: Timing, by: str = "") -> str:
    """One line per move: what the plan gives it [s] and what was measured. `by`: how moves were told apart."""
    kinds = moves.kinds
    rows = [
        f"{'move':>5} {'line':>5}  {'type':<9}{'plan s':>9}{'measured s':>12}{'differs s':>11}  statement"
    ]
    text = {file_name(s.path): s for s in timing.plan.sources}
    for i, expected in enumerate(planned.tolist()):
        lasts = float(moves.duration[i])
        says = text[moves.job[i]].line(int(moves.line[i])).strip() if moves.job[i] in text else ""
        head = f"{moves.move[i]:>5} {moves.line[i]:>5}  {kinds[i]:<9}"
        rows.append(f"{head}{expected:9.3f}{lasts:12.3f}{lasts - expected:+11.3f}  {says[:60]}")
    total, how = float(moves.duration.sum()), f" by {by}" if by else ""
    rows += ["", f"{len(moves)} rows{how}: measured {total:.3f} s, planned {planned.sum():.3f} s"]
    return "\n".join(rows)
