"""`olp init`: an olp.toml for a folder of programs: the arm, what was taken for granted, and budgets."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from olp.runtime.folder import ArmSource
    from olp.timing.result import Timing

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
    from olp.cli._timing import print_diagnostics
    from olp.core.diagnostic import OlpError, error
    from olp.core.files import write_output
    from olp.identification.timing_job import plan_and_time
    from olp.languages.vendor import program_files
    from olp.reports.batch import Job, shown, time_files
    from olp.reports.cell import started
    from olp.robots.robot import load_robot
    from olp.runtime.folder import find_arms

    folder, target = Path(args.folder), Path(args.folder) / "olp.toml"
    if not folder.is_dir():
        says = "no such folder" if not folder.exists() else "this is a file"
        raise OlpError(error("C003", says, file=args.folder, help="name the folder that holds the programs"))
    if target.exists() and not args.force:
        says = "this file exists and was not changed"
        raise OlpError(error("C009", says, file=str(target), help="say --force to replace it"))
    if args.robot:
        load_robot(args.robot)
    paths = [str(path) for path in program_files([str(folder)])]
    arms = [] if args.robot else _named_before(target) or find_arms(folder, paths)
    robot = args.robot or (arms[0].name if len(arms) == 1 else "")
    job = Job(robot=robot or None)
    parts = time_files(paths, job)
    parts = [part for part in parts if not part.lacks_start] or parts  # files of data alone
    starts = started(parts)
    mains = [parts[index].file for index in starts if not parts[index].failed]
    timings = [plan_and_time(path, job) for path in mains]
    if robot.lower().endswith(".toml"):  # olp.toml names it as seen from its own folder
        robot = Path(os.path.relpath(robot, folder)).as_posix()
    write_output(target, "\n".join(_text(robot, folder, mains, timings)) + "\n")
    whole = sum(map(_is_whole, timings))
    print(f"{target}: {len(parts)} programs, {len(starts)} that a controller starts, {whole} with a budget")
    for line in _about_arm(args.robot, arms):
        print(line)
    print_diagnostics([d for d in shown(parts) if d.is_error])
    return 0


def _named_before(target: Path) -> list[ArmSource]:
    """The arm in the olp.toml that is replaced: somebody may have named it."""
    from olp.runtime.assumptions import read_assumptions
    from olp.runtime.folder import ArmSource

    name = read_assumptions(target).robot if target.exists() else ""
    if name.lower().endswith(".toml"):
        name = str(target.parent / name)
    return [ArmSource(name, "the olp.toml that was replaced")] if name else []


def _about_arm(given: str | None, arms: Sequence[ArmSource]) -> Iterator[str]:
    if given:
        return
    if len(arms) == 1:
        yield f"arm: {arms[0].name or 'as its controller says'}, by {arms[0].why}; another one: robot in olp.toml"
        return
    for arm in arms:
        yield f"arm: {arm.name}, by {arm.why}?"
    yield "name the arm in it (olp robots lists them): without it most joint moves have no time"
    yield "olp init --force finds it by a robot file or a backup in the folder, or by a program's first comments"


def _text(robot: str, folder: Path, mains: Sequence[str], timings: Sequence[Timing]) -> Iterator[str]:
    import json

    from olp.robots import EXAMPLE_ROBOT

    yield "# What the programs of this folder cannot say themselves (docs/assumptions.md). Made by olp init."
    yield (
        f"robot = {json.dumps(robot)}"
        if robot
        else f'# robot = "{EXAMPLE_ROBOT}"  # the arm: olp robots lists them'
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
        yield f"\n# Assumed in {seen}; [waits], [inputs], [variables] and [motion] say otherwise:"
    for line, says in told[:_LISTED]:
        place = f"line {line}: " if line else ""
        yield f"#   {place}{' '.join(says.split())}"
    if len(told) > _LISTED:
        yield f"#   and {len(told) - _LISTED} more: olp time {seen}"
