"""`olp probe`: the smallest experiment that tells a robot's timing signature."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from olp.identification.probe.experiment import Wanted
    from olp.identification.recording.recording import Recording
    from olp.robots.geometry import Pose

SUMMARY = "design the moves that reveal most about a robot's timing, as a job"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("--robot", metavar="R", help="the robot, a name from olp robots or a robot file")
    parser.add_argument("--moves", type=int, default=20, metavar="N", help="how many to measure (default 20)")
    parser.add_argument(
        "--box",
        metavar="X0,X1,Y0,Y1,Z0,Z1",
        help="[mm] where the tool centre point may be, in the robot's base (with a minus: --box=-100,…)",
    )
    parser.add_argument("--speed", type=float, metavar="V", help="[mm/s] programmed speed (default 300)")
    parser.add_argument("--orientation", metavar="RX,RY,RZ", help="[deg] of the tool (default 180,0,0)")
    parser.add_argument(
        "--tool", metavar="X,Y,Z,RX,RY,RZ", help="[mm, deg] on the flange (default: the flange)"
    )
    parser.add_argument(
        "--tool-number",
        type=int,
        default=0,
        metavar="N",
        help="the controller's number of that tool (default 0)",
    )
    parser.add_argument(
        "--next", metavar="RECORDING", help="the measurements so far: design the moves that add most to them"
    )
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="the folder to write")


def run(args: Namespace) -> int:
    from pathlib import Path

    from olp.cli._timing import print_diagnostics
    from olp.core.diagnostic import OlpError, error
    from olp.identification.probe.experiment import design_experiment, further_experiment
    from olp.identification.probe.job import write_experiment
    from olp.identification.recording.reader import read_recording

    folder = Path(args.output)
    if args.next is None:
        experiment = design_experiment(_wanted(args))
    else:
        recording = read_recording(args.next)
        experiment = further_experiment(recording, _wanted_further(args, recording))
    taken = [name for name in ("moves.csv", "recording.toml", "PROBE.JBI") if (folder / name).exists()]
    if taken:
        says = f"{', '.join(taken)} would be overwritten"
        raise OlpError(error("C009", says, file=str(folder), help="name another folder with -o"))
    named = str(Path(args.robot).resolve()) if args.robot and Path(args.robot).is_file() else ""
    proved = write_experiment(experiment, folder, named)
    print_diagnostics(experiment.told)
    count = len(experiment.ends)
    print(f"{folder / 'PROBE.JBI'}: {count} measured moves, about {proved.duration:.0f} s")
    print(f"{folder / 'moves.csv'}: fill in duration_s")
    print(f"expected to leave {100 * experiment.left:.0f} % of what is unknown about the box")
    print(f"then: olp calibrate {folder} --method averaged_process -o robot.signature.json")
    return 0


def _wanted(args: Namespace) -> Wanted:
    import numpy as np

    from olp.core.diagnostic import OlpError, error
    from olp.core.units import deg, mm
    from olp.identification.probe.experiment import Wanted
    from olp.robots.robot import load_robot

    missing = [f"--{name}" for name in ("robot", "box") if getattr(args, name) is None]
    if missing:
        says = f"{' and '.join(missing)} missing: which robot, and where it may move"
        raise OlpError(error("C002", says, help="or --next RECORDING"))
    box = np.array(_numbers(args.box, 6, "--box")).reshape(3, 2) * mm
    x, y, z = (v * deg for v in _numbers(args.orientation or "180,0,0", 3, "--orientation"))
    speed = (300.0 if args.speed is None else args.speed) * mm
    return Wanted(load_robot(args.robot), box, args.moves, speed, (x, y, z), _tool(args), args.tool_number)


def _wanted_further(args: Namespace, recording: Recording) -> Wanted:
    """What the recording tells, overruled by what is given."""
    import numpy as np

    from olp.core.units import deg, mm
    from olp.identification.probe.experiment import wanted_of
    from olp.robots.robot import load_robot

    robot = load_robot(args.robot) if args.robot else None
    box = None if args.box is None else np.array(_numbers(args.box, 6, "--box")).reshape(3, 2) * mm
    wanted = wanted_of(recording, robot, args.moves, args.tool_number, box)
    if args.orientation is not None:
        x, y, z = (v * deg for v in _numbers(args.orientation, 3, "--orientation"))
        wanted = wanted._replace(angles=(x, y, z))
    if args.speed is not None:
        wanted = wanted._replace(speed=args.speed * mm)
    return wanted if args.tool is None else wanted._replace(tool=_tool(args))


def _tool(args: Namespace) -> Pose | None:
    from olp.core.units import deg, mm
    from olp.robots.geometry import Pose

    if args.tool is None:
        return None
    numbers = _numbers(args.tool, 6, "--tool")
    return Pose.from_xyz_angles([v * (mm if i < 3 else deg) for i, v in enumerate(numbers)])


def _numbers(text: str, count: int, option: str) -> list[float]:
    import math

    from olp.core.diagnostic import OlpError, error

    try:
        found = [float(part) for part in text.split(",")]
    except ValueError:
        found = []
    if len(found) != count or not all(map(math.isfinite, found)):
        raise OlpError(error("C002", f"{option} takes {count} numbers with commas between, not {text!r}"))
    return found
