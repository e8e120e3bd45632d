"""Executes a program: what is written becomes what happens."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from olp.core.diagnostic import Diagnostic, OlpError, error, errors
from olp.languages.vendor import find_vendor, part_of, vendor_names
from olp.runtime.assumptions import Assumptions, load_assumptions, nearest_assumptions
from olp.runtime.folder import build_world
from olp.runtime.jobs import Jobs
from olp.runtime.machine import OPERATIONS, execute
from olp.runtime.memory import SAVED_NUMBERS, SAVED_POSITIONS, Memory, PositionValue, saved_position
from olp.runtime.recorder import Recorder
from olp.runtime.robots import missing_robots
from olp.runtime.state import STEPS, CallFrame, Machine

if TYPE_CHECKING:
    import os

    from olp.ir.program import Program
    from olp.robots.robot import Robot
    from olp.runtime.plan import Plan


def run(
    program: Program,
    robot: str | Robot | None = None,
    *,
    assumptions: Assumptions | None = None,
    folder: str | os.PathLike[str] | None = None,
    max_steps: int | None = None,
    cycles: int = 1,
) -> Plan:
    """The plan of `program`: its first routine, run to the end.

    `robot`: library name, robot file or Robot of the first arm; else olp.toml or the controller's backup decide.
    `assumptions`: what the program cannot tell; the nearest olp.toml when None. `folder`: where called routines and
    controller files are; the program's own folder when None. `cycles`: passes of an endless main loop.
    `max_steps`: statements after which the run is stopped (None: 200,000 in each cycle, and ten times what is read).
    Raises OlpError for a robot that does not exist; everything else is in `Plan.diagnostics`.
    """

    place = Path(folder) if folder is not None else _folder_of(program)
    return start(program, robot, assumptions, place, max_steps, cycles)


def _folder_of(program: Program) -> Path | None:
    if not program.path:
        return None
    path = Path(program.path)
    return path.parent if path.is_file() else None


# --- A run ---
# Sets a machine up, runs it and makes the plan.


def start(
    program: Program,
    robot: str | Robot | None,
    assumptions: Assumptions | None,
    folder: Path | None,
    max_steps: int | None,
    cycles: int,
) -> Plan:
    """See `olp.runtime.interpreter.run`."""
    if assumptions is None:
        path = nearest_assumptions(folder) if folder is not None else None
        assumptions = load_assumptions(path) if path is not None else Assumptions()
    jobs = Jobs(program, folder)
    main = jobs.main()
    if main is None:
        nothing = error(
            "I101", "the file holds no routine", file=program.path, help="give a file with a job in it"
        )
        raise OlpError(*(errors(program.diagnostics) or (nothing,)))
    world = build_world(robot, assumptions, folder)
    recorder = Recorder(world.cell, tuple(jobs.sources))
    m = Machine(
        OPERATIONS, recorder, world, Memory(), jobs, assumptions, cycles, CallFrame(main), first_job=main.key
    )
    if program.vendor in vendor_names():
        m.known_routines = part_of(program.vendor, "known_routines") or {}
        m.law = find_vendor(program.vendor).blending
        m.conventions = find_vendor(program.vendor).conventions
        m.case_sensitive = find_vendor(program.vendor).case_sensitive
        m.advance_stops = find_vendor(program.vendor).advance_stops
    m.allow(STEPS * cycles if max_steps is None else max_steps)
    m.allows_more = max_steps is None
    m.load(main)
    set_initial_values(m)
    execute(m)
    return _finish(m)


def _finish(m: Machine) -> Plan:
    m.hand_over_assumptions()
    plan = m.recorder.finish((), m.stop_reason)
    found = [*m.jobs.program.diagnostics, *m.jobs.found, *m.world.diagnostics]
    told = {(d.file, d.line) for d in found if d.is_error}
    broken = {file for file, _ in told}
    found += [d for d in m.diagnostics() if not _is_told(d, told, broken)]
    found += missing_robots(m, plan)
    length = len(plan)
    return replace(
        plan,
        diagnostics=tuple(dict.fromkeys(found)),
        settings=m.assumptions.motion,
        zone_law=m.law if m.law != "radius" else plan.zone_law,
        calls=tuple(
            span if span.stop > span.start or not m.frames else span._replace(stop=length) for span in m.spans
        ),
    )


def _is_told(finding: Diagnostic, told: set[tuple[str, int]], broken: set[str]) -> bool:
    """Whether the reader has said the same: of that line, or of the row that should have taught the point."""
    return (finding.file, finding.line) in told or (finding.code == "I206" and finding.file in broken)


# --- Initial values ---
# What the variables hold, and where the arms stand, when a run begins: VAR.DAT, then olp.toml, which wins.


def set_initial_values(m: Machine) -> None:
    """Fills the memory. Positions in the headers of routines, loaded before, win over VAR.DAT."""
    values = m.memory.values
    saved = m.world.backup.variables if m.world.backup is not None else None
    if saved is not None:
        for store, letters in SAVED_NUMBERS.items():
            for index, value in getattr(saved, letters).items():
                values[(store, index)] = value
        for store, letters in SAVED_POSITIONS.items():
            for index, position in getattr(saved, letters).items():
                values.setdefault((store, index), PositionValue(*saved_position(position)))
    for key, given in m.assumptions.variables.items():
        values[key] = PositionValue(*given) if isinstance(given, tuple) else given
    for name, start in m.assumptions.start.items():
        mechanism = m.add_mechanism(name)
        m.recorder.at[mechanism] = m.recorder.position(mechanism, start.state, start.values)
