"""`olp recording import`: a recording out of what a controller, a client or ROS recorded, or of a table of times."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from olp.identification.recording.importing import ImportOptions

SUMMARY = "make a recording from traces, logs, ROS recordings or tables of times"


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli._timing import positive

    parser.add_argument(
        "files",
        nargs="+",
        metavar="FILE",
        help="files of the recording, or folders of them; with --job one log, or one table with columns line and "
        "duration_s",
    )
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="the folder, created if needed")
    parser.add_argument(
        "--sim",
        nargs="+",
        default=[],
        metavar="FILE",
        help="the same of a simulated controller: its durations become sim_s",
    )
    parser.add_argument("--job", metavar="JOB", help="the program that ran, or whose lines were timed")
    parser.add_argument("--robot", metavar="R", help="the robot (default: what the controller says)")
    parser.add_argument(
        "--override", type=positive, metavar="PCT", help="the program override, which traces do not hold"
    )
    parser.add_argument(
        "--column",
        action="append",
        default=[],
        metavar="NAME=COLUMN",
        help="what a log's column is, such as t_ms=Time, q1_deg=J1, q1_rad=2 (the second) or q1_pulse=S",
    )
    parser.add_argument(
        "--topic", default="", metavar="T", help="of a ROS recording (default: the only one with joints)"
    )
    parser.add_argument(
        "--joints", default="", metavar="A,B,…", help="joints of a ROS recording, from the base to the flange"
    )
    parser.add_argument("--force", action="store_true", help="replace a moves.csv that is there")


def run(args: Namespace) -> int:
    from olp.cli._timing import print_diagnostics
    from olp.core.diagnostic import OlpError, error
    from olp.core.files import absent, write_together
    from olp.core.units import deg, mm
    from olp.identification.recording.column_naming import parse_naming
    from olp.identification.recording.importing import ImportOptions, import_runs
    from olp.identification.recording.settings import FILE_NAME, RecordingSettings
    from olp.identification.recording.writer import settings_toml
    from olp.robots.robot import load_robot

    folder = Path(args.output)
    if (folder / "moves.csv").exists() and not args.force:
        says = "this file exists and was not changed"
        help = "name another folder with -o, or say --force to replace it"
        raise OlpError(error("C009", says, file=str(folder / "moves.csv"), help=help))
    robot = load_robot(args.robot) if args.robot else None
    if gone := absent([*args.files, *args.sim, *filter(None, [args.job])]):
        raise OlpError(*gone)
    joints = tuple(filter(None, map(str.strip, args.joints.split(","))))
    options = ImportOptions(parse_naming(args.column), robot, args.topic, joints)
    if args.job:
        return _import_job(args, options)
    files = [Path(file) for file in args.files], [Path(file) for file in args.sim]
    made = import_runs(*files, args.override, options)
    tool = None
    if made.tool is not None:
        tool = (*(v * mm for v in made.tool[:3]), *(v * deg for v in made.tool[3:]))
    settings = RecordingSettings(
        robot=args.robot or made.robot,
        controller=made.controller,
        time_resolution=float(f"{made.period:.3g}"),
        tool=tool,
    )
    written = {
        folder / "moves.csv": made.moves.encode(),
        folder / FILE_NAME: settings_toml(settings, "Made by olp recording import.").encode(),
    }
    if made.log:
        written[folder / "log.csv"] = made.log
    folder.mkdir(parents=True, exist_ok=True)
    write_together(written)
    called = settings.robot or "robot not known"
    print(
        f"{made.count} moves, {made.seconds:.3f} s, {called}: {', '.join(f.name for f in written)} in {folder}"
    )
    print_diagnostics(made.diagnostics)
    return 0


def _import_job(args: Namespace, options: ImportOptions) -> int:
    """The recording of one log, or of one table of times, and the program that ran."""
    from olp.core.diagnostic import OlpError, error
    from olp.identification.recording.column_naming import names_times
    from olp.identification.recording.importing import is_log
    from olp.identification.recording.ros_bag import is_bag

    if len(args.files) > 1 or args.sim:
        says = "with --job, one log or one table of times is imported"
        help = "one run of the program; put all times into one table; simulated ones are column sim_s"
        raise OlpError(error("C001", says, help=help))
    file = Path(args.files[0])
    if not names_times(options.naming) and (options.naming or is_bag(file) or is_log(file, options)):
        return _import_log(args, file, options)
    return _import_times(args, options)


def _import_log(args: Namespace, file: Path, options: ImportOptions) -> int:
    """The moves of a log and the program that ran."""
    from olp.cli.recording_from_log import write_from_log
    from olp.core.units import percent
    from olp.identification.recording.importing import read_any_log
    from olp.identification.timing_job import TimingJob, plan_and_time

    log, told, _ = read_any_log(file, options)
    override = args.override * percent if args.override else None
    timing = plan_and_time(args.job, TimingJob(robot=args.robot, override=override))
    write_from_log(args, file, log, told, timing, maker="import")
    return 0


def _import_times(args: Namespace, options: ImportOptions) -> int:
    """The recording of a table of times and the program they were taken of."""
    from olp.cli._timing import print_diagnostics
    from olp.cli.recording_from_log import settings_of_run, table_of_moves
    from olp.core.files import refuse_inputs
    from olp.core.units import percent
    from olp.identification.recording.column_naming import named_table
    from olp.identification.recording.programmed import moved, tool_of
    from olp.identification.recording.stop_watch import moves_from_times
    from olp.identification.recording.table import read_table
    from olp.identification.recording.writer import write_recording
    from olp.identification.timing_job import TimingJob, plan_and_time

    refuse_inputs(Path(args.output) / "moves.csv", [args.files[0], args.job])
    table = named_table(read_table(Path(args.files[0])), options.naming)
    override = args.override * percent if args.override else None
    timing = plan_and_time(args.job, TimingJob(robot=args.robot, override=override))
    moves, planned, told = moves_from_times(table, timing, override)
    settings = settings_of_run(args, timing, None, tool_of(moved(timing)))
    names = f"{Path(args.files[0]).name} and {Path(args.job).name}"
    write_recording(args.output, moves, settings, comment=f"Made by olp recording import of {names}.")
    print(table_of_moves(moves, planned, timing))
    print_diagnostics([d.at(args.job) for d in timing.diagnostics] + list(told))
    return 0
