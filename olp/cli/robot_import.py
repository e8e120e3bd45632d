"""`olp robot import`: a robot file from a controller's backup."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from pathlib import Path

from olp.core.diagnostic import Diagnostic, OlpError, error

Made = tuple[Callable[[], str], list[Path], list[Diagnostic]]  # the text, the files it is of, what was found

SUMMARY = "make a robot file from a controller's backup"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "backup",
        metavar="BACKUP",
        help="folder with RC.PRM or ALL.PRM; SC.PRM and SYSTEM.SYS are used too. KUKA: the archive, unpacked",
    )
    parser.add_argument("-o", "--output", metavar="FILE", help="the robot file (default: standard output)")
    parser.add_argument(
        "--name", default="", metavar="MAKER/MODEL", help="default: the model that the backup names"
    )
    parser.add_argument(
        "--group", default="R1", metavar="GROUP", help="the control group: R1, R2, S1 .. (default: R1)"
    )
    parser.add_argument("--force", action="store_true", help="replace FILE when it exists")


def run(args: Namespace) -> int:
    from olp.core.files import write_output
    from olp.robots.backup.machine_dat import find_machine_data

    output = args.output if args.output not in (None, "-") else None
    findings = []
    if output is not None and Path(output).exists() and not args.force:
        help_text = "name another file with -o, or say --force to replace this one"
        findings.append(error("C009", "this file exists and was not changed", file=output, help=help_text))
    machine = find_machine_data(Path(args.backup))
    text, inputs, found = _of_machine_data(machine, args) if machine is not None else _of_parameters(args)
    findings += found
    if any(finding.is_error for finding in findings):
        raise OlpError(*findings)
    write_output(output, text(), inputs=inputs)
    for finding in findings:
        print(finding.render(), end="\n\n", file=sys.stderr)
    return 0


def _of_machine_data(machine: Path, args: Namespace) -> Made:
    from olp.robots.backup.machine_dat import machine_data_toml, read_machine_data

    data = read_machine_data(machine)
    text = machine_data_toml(data, args.name)
    return lambda: text, [machine], list(data.findings.all())


def _of_parameters(args: Namespace) -> Made:
    from olp.robots.backup.backup import read_backup
    from olp.robots.backup.robot_file import check_import, robot_toml

    backup = read_backup(args.backup)
    inputs = [Path(args.backup) / name for name in backup.files]
    findings = list(check_import(backup, args.group, args.name))
    return lambda: robot_toml(backup, args.group, args.name), inputs, findings
