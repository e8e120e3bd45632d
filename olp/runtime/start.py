"""Sets a machine up, runs it and makes the plan."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from olp.core.diagnostic import Diagnostic, OlpError, error, errors
from olp.languages.vendor import find_vendor, part_of, vendor_names
from olp.runtime.assumptions import Assumptions, load_assumptions, nearest_assumptions
from olp.runtime.initial import set_initial_values
from olp.runtime.jobs import Jobs
from olp.runtime.machine import OPERATIONS, execute
from olp.runtime.memory import Memory
from olp.runtime.recorder import Recorder
from olp.runtime.robots import missing_robots
from olp.runtime.state import CallFrame, Machine
from olp.runtime.world import build_world

if TYPE_CHECKING:
    from olp.ir.program import Program
    from olp.robots.robot import Robot
    from olp.runtime.plan import Plan


def start(
    program: Program,
    robot: str | Robot | None,
    assumptions: Assumptions | None,
    folder: Path | None,
    max_steps: int,
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
    m.left = max_steps
    m.load(main)
    set_initial_values(m)
    execute(m, max_steps)
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
