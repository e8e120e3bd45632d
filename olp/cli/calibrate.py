"""`olp calibrate`: from recorded moves to the robot's timing signature."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

SUMMARY = "learn a robot's timing signature from recorded moves"


def add_arguments(parser: ArgumentParser) -> None:
    from olp.identification.signature.estimator import estimator_names

    parser.add_argument(
        "recording", metavar="RECORDING", help="a folder with moves.csv, or such a file (docs/recording.md)"
    )
    parser.add_argument("-o", "--output", metavar="FILE", help="the signature (default: standard output)")
    parser.add_argument(
        "--method",
        default="auto",
        metavar="M",
        help=f"auto (what predicts held-out moves best) or one of {', '.join(estimator_names())}",
    )
    parser.add_argument("--robot", metavar="R", help="the robot, instead of the recording's")


def run(args: Namespace) -> int:
    import sys
    from pathlib import Path

    from olp.cli._timing import print_diagnostics
    from olp.core.files import refuse_inputs
    from olp.identification.recording.reader import read_recording
    from olp.identification.signature.file import write_signature
    from olp.identification.signature.learn import calibrate
    from olp.identification.signature.summary import summary
    from olp.robots.robot import load_robot

    inputs = [args.recording, *Path(args.recording).glob("*")] if args.recording else []
    if args.output not in (None, "-"):
        refuse_inputs(args.output, inputs)
    recording = read_recording(args.recording)
    robot = load_robot(args.robot) if args.robot else None
    signature, told = calibrate(recording, args.method, robot)
    write_signature(signature, args.output)
    print_diagnostics((*recording.diagnostics, *told))
    if args.output not in (None, "-"):
        print("\n".join(summary(signature)), file=sys.stdout)
    return 0
