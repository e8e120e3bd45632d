"""Small jobs for the tests of the interpreter, and what their plans did."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from olp.core.diagnostic import Severity
from olp.core.source import decode
from olp.fluent import Plan, read_source, run
from olp.ir.program import Program
from olp.runtime.assumptions import Assumptions
from olp.runtime.plan import StepKind

# Point n of every job stands at x = 37.5 n + 11 mm, so that a plan tells which points it visited.
_PITCH, _FIRST = 37.5, 11.0


def job_text(
    body: str, name: str = "TEST", points: int = 12, header: str = "", rows: str = "", arguments: str = ""
) -> str:
    """A job with `points` Cartesian points and the given instructions; `rows` are further position rows."""
    taught = [
        f"C{n:05d}={_FIRST + _PITCH * n:.3f},-203.400,417.250,178.2610,1.5083,-29.8410" for n in range(points)
    ]
    further = rows.strip().splitlines()
    counts = [
        points + sum(row.startswith("C") for row in further),
        *(sum(row.startswith(kind) for row in further) for kind in ("BC", "EC", "P0", "BP", "EX")),
    ]
    lines = [
        "/JOB",
        f"//NAME {name}",
        "//POS",
        f"///NPOS {','.join(map(str, counts))}",
        "///TOOL 0",
        "///POSTYPE BASE",
        "///RECTAN",
        "///RCONF 1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0",
        *taught,
        *further,
        *([f"//ARGINFO\n///ARGTYPE {arguments}\n///COMMENT\n\n\n\n\n\n\n\n"] if arguments else []),
        "//INST",
        "///DATE 2026/04/11 09:22",
        "///ATTR SC,RW",
        *(header.strip().splitlines() or ["///GROUP1 RB1"]),
        "///LVARS 20,20,20,20,20,20,0,0",
        "NOP",
        *(line.strip() for line in body.strip().splitlines()),
        "END",
    ]
    return "\r\n".join("\r\n".join(lines).splitlines()) + "\r\n"


def program(body: str, **options: object) -> Program:
    """The program of `job_text`; it must be free of errors."""
    found = read_source(decode(job_text(body, **options).encode("cp1252"), "TEST.JBI"))  # type: ignore[arg-type]
    assert not [d for d in found.diagnostics if d.severity is Severity.ERROR], found.diagnostics
    return found


def plan_of(
    body: str,
    assumptions: Assumptions | None = None,
    cycles: int = 1,
    robot: str | None = None,
    **options: object,
) -> Plan:
    return run(program(body, **options), robot, assumptions=assumptions or Assumptions(), cycles=cycles)


def write_jobs(folder: Path, bodies: Mapping[str, str]) -> Path:
    """One file per job; the path of the first."""
    for name, body in bodies.items():
        (folder / f"{name}.JBI").write_bytes(job_text(body, name=name).encode("cp1252"))
    return folder / f"{next(iter(bodies))}.JBI"


def visited(plan: Plan) -> list[int]:
    """The numbers of the taught points that the robot's moves went to, in order."""
    rows = [plan.row[i] for i in range(len(plan)) if plan.kind[i] == StepKind.MOVE]
    x = plan.positions.position[plan.moves.target[rows], 0] if rows else np.zeros(0)
    return [round((value * 1000 - _FIRST) / _PITCH) for value in x]


def waits(plan: Plan) -> list[float]:
    """The duration of every wait [s]."""
    return [float(plan.durations[plan.row[i]]) for i in range(len(plan)) if plan.kind[i] == StepKind.WAIT]


def errors(plan: Plan) -> list[tuple[str, int]]:
    """(code, line) of every error."""
    return [(d.code, d.line) for d in plan.diagnostics if d.severity is Severity.ERROR]


def findings(plan: Plan) -> list[str]:
    """The codes of everything above a note."""
    return [d.code for d in plan.diagnostics if d.severity is not Severity.INFO]


def said(plan: Plan) -> str:
    """All assumptions as one text."""
    return "\n".join(f"{a.line}: {a.says}" for a in plan.assumptions)


def counted(plan: Plan) -> int:
    """The value that a job showed by visiting the point of that number last."""
    return visited(plan)[-1]
