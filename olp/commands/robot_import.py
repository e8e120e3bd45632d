"""`olp robot import`: a robot file from a controller's backup."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path

from olp.diagnostic import OlpError, error

SUMMARY = "make a robot file from a controller's backup"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "backup", metavar="BACKUP", help="folder with RC.PRM or ALL.PRM; SC.PRM and SYSTEM.SYS are used too"
    )
    parser.add_argument("-o", "--output", metavar="FILE", help="the robot file (default: standard output)")
    parser.add_argument("--name", default="", metavar="MAKER/MODEL", help="default: the model in SYSTEM.SYS")
    parser.add_argument(
        "--group", default="R1", metavar="GROUP", help="the control group: R1, R2, S1 .. (default: R1)"
    )
    parser.add_argument("--force", action="store_true", help="replace FILE when it exists")


def run(args: Namespace) -> int:
    from olp.backup.backup import read_backup
    from olp.backup.import_check import check_import
    from olp.backup.robot_file import robot_toml
    from olp.files import write_output

    backup = read_backup(args.backup)
    findings = list(check_import(backup, args.group, args.name))
    output = args.output if args.output not in (None, "-") else None
    if output is not None and Path(output).exists() and not args.force:
        help_text = "name another file with -o, or say --force to replace this one"
        findings.insert(
            0, error("C009", "this file exists and was left as it is", file=output, help=help_text)
        )
    if any(finding.is_error for finding in findings):
        raise OlpError(*findings)
    inputs = [Path(args.backup) / name for name in backup.files]
    write_output(output, robot_toml(backup, args.group, args.name).encode(), inputs=inputs)
    for finding in findings:
        print(finding.render(), end="\n\n", file=sys.stderr)
    return 0
