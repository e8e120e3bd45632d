"""`olp recording import`: a recording out of what a controller recorded of its own accord."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

SUMMARY = "make a recording of a controller's own traces"


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli.time import positive

    parser.add_argument("files", nargs="+", metavar="FILE", help="files of the recording, or folders of them")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="the folder, made if need be")
    parser.add_argument(
        "--sim",
        nargs="+",
        default=[],
        metavar="FILE",
        help="the same of a simulated controller: its durations become sim_s",
    )
    parser.add_argument("--robot", metavar="R", help="the robot (default: what the controller says)")
    parser.add_argument(
        "--override", type=positive, metavar="PCT", help="the program override, which traces do not tell"
    )
    parser.add_argument("--force", action="store_true", help="replace a moves.csv that is there")


def run(args: Namespace) -> int:
    from olp.cli.time import print_diagnostics
    from olp.core.diagnostic import OlpError, error
    from olp.core.files import write_together
    from olp.core.units import deg, mm
    from olp.identification.recording.importing import import_runs
    from olp.identification.recording.settings import FILE_NAME, RecordingSettings
    from olp.identification.recording.writer import settings_toml
    from olp.robots.robot import load_robot

    folder = Path(args.output)
    if (folder / "moves.csv").exists() and not args.force:
        says = "this file exists and was left as it is"
        help = "name another folder with -o, or say --force to replace it"
        raise OlpError(error("C009", says, file=str(folder / "moves.csv"), help=help))
    if args.robot:
        load_robot(args.robot)
    gone = [file for file in (*args.files, *args.sim) if not Path(file).exists()]
    if gone:
        raise OlpError(*(error("C003", "no such file or folder", file=file) for file in gone))
    made = import_runs([Path(file) for file in args.files], [Path(file) for file in args.sim], args.override)
    tool = None
    if made.tool is not None:
        tool = (*(v * mm for v in made.tool[:3]), *(v * deg for v in made.tool[3:]))
    settings = RecordingSettings(
        robot=args.robot or made.robot,
        controller=made.controller,
        time_resolution=made.period,
        tool=tool,
    )
    files = {
        folder / "moves.csv": made.moves.encode(),
        folder / FILE_NAME: settings_toml(settings, "Made by olp recording import.").encode(),
    }
    if made.log:
        files[folder / "log.csv"] = made.log.encode()
    folder.mkdir(parents=True, exist_ok=True)
    write_together(files)
    robot = settings.robot or "robot not known"
    print(
        f"{made.count} moves, {made.seconds:.3f} s, {robot}: {', '.join(f.name for f in files)} in {folder}"
    )
    print_diagnostics(made.diagnostics)
    return 0
