"""Reads a robot program into the station that is open in RoboDK: frames, tools, targets and a program with olp's times.

Started in RoboDK (Program > Add Python program) it asks for the file; on a command line:
python olp_import.py FILE [--robot maker/model] [--signature FILE] [--rounding]
"""

from __future__ import annotations

import argparse
import sys

from olp_station.build import build
from olp_station.steps import executed
from robodk.robolink import ITEM_TYPE_ROBOT, Robolink

from olp.core.diagnostic import OlpError


def arguments(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Reads a robot program into RoboDK's station, with olp's times."
    )
    parser.add_argument("file", nargs="?", help="the program (default: asks)")
    parser.add_argument("--robot", help="a name of `olp robots`, or a robot file (default: the program's)")
    parser.add_argument("--signature", help="the robot's timing signature, made by olp calibrate")
    parser.add_argument(
        "--rounding", action="store_true", help="write corner radii; RoboDK's time then is its own"
    )
    return parser.parse_args(words)


def main(words: list[str]) -> int:
    given = arguments(words)
    if given.file is None:
        from robodk.robodialogs import getOpenFileName

        given.file = getOpenFileName(strtitle="A robot program")
        if not given.file:
            return 0
    try:
        run = executed(given.file, given.robot, given.signature)
    except OlpError as refused:
        print("\n\n".join(diagnostic.render() for diagnostic in refused.diagnostics), file=sys.stderr)
        return 2
    link = Robolink(args=["-API_NODELAY"])  # hundreds of small messages
    robot = link.Item("", ITEM_TYPE_ROBOT)
    if not robot.Valid():
        print("there is no robot in this station: open one first", file=sys.stderr)
        return 2
    print(build(link, robot, run, given.rounding))
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
