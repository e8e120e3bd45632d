"""A whole file: its jobs, each with header and instructions, and everything that is wrong with it."""

from __future__ import annotations

from collections.abc import Iterator

from olp.core.garbage_collection import no_garbage_collection
from olp.core.source import Source
from olp.ir.program import LineKind, Program, Routine
from olp.languages.findings import Findings
from olp.languages.vendors.inform import checks
from olp.languages.vendors.inform.fast import InformMoveLines, move_lines
from olp.languages.vendors.inform.header import HeaderReader
from olp.languages.vendors.inform.instructions import InformInstructionReader


def read_program(source: Source) -> Program:
    """The program in a text of one or more jobs. Never raises on bad text."""
    findings = Findings(source)
    routines: tuple[Routine, ...] = ()
    if checks.is_readable(findings):
        with no_garbage_collection():
            routines = tuple(_routines(findings))
        checks.check_names(findings, routines)
        checks.check_text(findings)
    return Program("inform", source, routines, findings.result(), bytes(findings.kinds))


def _routines(findings: Findings) -> Iterator[Routine]:
    lines = findings.source.lines
    starts = [number for number, line in enumerate(lines) if line[:4] == "/JOB" and line.strip() == "/JOB"]
    first = starts[0] if starts else len(lines)
    early = next((number for number in range(first) if lines[number].strip()), None)
    if early is not None and _before_job(findings, early, first):
        starts.insert(0, early)
    moves = move_lines()
    for start, stop in zip(starts, [*starts[1:], len(lines)], strict=False):
        yield _routine(findings, moves, start, stop)


def _before_job(findings: Findings, start: int, stop: int) -> bool:
    """Tells what stands before the first /JOB. True when it is a job of its own."""
    lines = findings.source.lines
    is_job = any(line.startswith("//") for line in lines[start:stop])
    help = "add the line /JOB before this one" if is_job else "remove it, or move it behind NOP"
    findings.error("P015", "a job begins with /JOB", findings.whole_line(start + 1), help)
    if not is_job:
        for number in range(start, stop):
            findings.kinds[number] = LineKind.ERROR if lines[number].strip() else LineKind.BLANK
    return is_job


def _routine(findings: Findings, moves: InformMoveLines, start: int, stop: int) -> Routine:
    header = HeaderReader(findings, start, stop).read()
    instructions = InformInstructionReader(findings, moves, header.aliases)
    body = instructions.read(findings.source.lines[header.body : stop], header.body + 1)
    routine = Routine(
        header.name,
        start + 1,
        tuple(body),
        header.points,
        tuple(header.groups),
        header.comment,
        header.relative_to,
        header.locals,
        header.arguments,
        header.aliases,
        header.details,
        stop,
    )
    checks.check_routine(findings, header, routine, instructions.markers)
    return routine
