"""Executes a program: what is written becomes what happens."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import os

    from olp.ir.program import Program
    from olp.robots.robot import Robot
    from olp.runtime.assumptions import Assumptions
    from olp.runtime.plan import Plan


def run(
    program: Program,
    robot: str | Robot | None = None,
    *,
    assumptions: Assumptions | None = None,
    folder: str | os.PathLike[str] | None = None,
    max_steps: int = 2_000_000,
    cycles: int = 1,
) -> Plan:
    """The plan of `program`: its first routine, run to the end.

    `robot`: library name, robot file or Robot of the first arm; else olp.toml or the controller's backup decide.
    `assumptions`: what the program cannot tell; the nearest olp.toml when None. `folder`: where called routines and
    controller files are; the program's own folder when None. `cycles`: passes of an endless main loop.
    Raises OlpError for a robot that does not exist; everything else is in `Plan.diagnostics`.
    """
    from olp.runtime.start import start

    place = Path(folder) if folder is not None else _folder_of(program)
    return start(program, robot, assumptions, place, max_steps, cycles)


def _folder_of(program: Program) -> Path | None:
    if not program.path:
        return None
    path = Path(program.path)
    return path.parent if path.is_file() else None
