"""`olp init`: an olp.toml for a folder of programs: the arm, what was taken for granted, and budgets."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from olp.timing.timing import Timing

SUMMARY = "write an olp.toml for a folder of programs"
_ROOM = 1.05  # [1] of today's time that a budget leaves
_LISTED = 20  # assumptions of one program


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "folder", nargs="?", default=".", metavar="FOLDER", help="of the programs (default: .)"
    )
    parser.add_argument("--robot", metavar="R", help="the robot: a name of `olp robots`, or a robot file")
    parser.add_argument("--force", action="store_true", help="replace an olp.toml that is there")


def run(args: Namespace) -> int:
    from olp.cli.time import print_diagnostics
    from olp.core.diagnostic import OlpError, error
    from olp.core.files import expand_paths, write_output
    from olp.languages.vendor import vendor_suffixes
    from olp.reports.batch import Job, plan_and_time, shown, time_files
    from olp.reports.cell import started
    from olp.robots.robot import load_robot

    folder, target = Path(args.folder), Path(args.folder) / "olp.toml"
    if not folder.is_dir():
        says = "no such folder" if not folder.exists() else "this is a file"
        raise OlpError(error("C003", says, file=args.folder, help="name the folder that holds the programs"))
    if target.exists() and not args.force:
        says = "this file exists and was left as it is"
        raise OlpError(error("C009", says, file=str(target), help="say --force to replace it"))
    if args.robot:
        load_robot(args.robot)
    paths = [str(path) for path in expand_paths([str(folder)], vendor_suffixes())]
    job = Job(robot=args.robot)
    parts = time_files(paths, job)
    mains = [parts[index].file for index in started(parts) if not parts[index].failed]
    timings = [plan_and_time(path, job) for path in mains]
    robot = args.robot or ""
    if robot.lower().endswith(".toml"):  # olp.toml names it as seen from its own folder
        robot = Path(os.path.relpath(robot, folder)).as_posix()
    write_output(target, "\n".join(_text(robot, folder, mains, timings)) + "\n")
    whole = sum(map(_is_whole, timings))
    print(f"{target}: {len(parts)} programs, {len(mains)} that a controller starts, {whole} with a budget")
    if not args.robot:
        print("name the arm in it (olp robots lists them): without it most joint moves have no time")
    print_diagnostics([d for d in shown(parts) if d.is_error])
    return 0


def _text(robot: str, folder: Path, mains: Sequence[str], timings: Sequence[Timing]) -> Iterator[str]:
    import json

    yield "# What the programs of this folder cannot say themselves (docs/assumptions.md). Made by olp init."
    yield (
        f"robot = {json.dumps(robot)}"
        if robot
        else '# robot = "yaskawa/gp25"  # the arm: olp robots lists them'
    )
    names = [Path(path).stem for path in mains]
    for path, name, timing in zip(mains, names, timings, strict=True):
        seen = Path(path).relative_to(folder).as_posix()
        yield from _assumed(seen, timing)
        if not _is_whole(timing):
            yield f"\n# {seen}: no budget, its time is not known whole: olp time {seen}"
            continue
        limit = max(round(timing.total_s * _ROOM, 1), round(timing.total_s + 0.05, 1))
        yield f"\n[[budget]]  # {timing.total_s:.3f} s today (docs/check.md)"
        yield f"name = {json.dumps(name if names.count(name) == 1 else seen)}"
        yield f"files = {json.dumps(seen)}"
        yield f"limit_s = {limit:g}"


def _is_whole(timing: Timing) -> bool:
    return not timing.untimed and not timing.left_open and timing.total_s > 0


def _assumed(seen: str, timing: Timing) -> Iterator[str]:
    told = list(dict.fromkeys((a.line, a.says) for a in timing.assumptions))
    if told:
        yield f"\n# Taken for granted in {seen}; [waits], [inputs], [variables] and [motion] say otherwise:"
    for line, says in told[:_LISTED]:
        place = f"line {line}: " if line else ""
        yield f"#   {place}{' '.join(says.split())}"
    if len(told) > _LISTED:
        yield f"#   and {len(told) - _LISTED} more: olp time {seen}"
