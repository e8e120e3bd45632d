"""What can be wrong with a file whose clauses are all fine: labels, names that stand twice, points nobody wrote."""

from __future__ import annotations

from collections.abc import Sequence

from olp.core.diagnostic import Severity, Span
from olp.ir.expressions import (
    Expression,
    Item,
    Member,
    Named,
    PositionLiteral,
    RecordLiteral,
    SignalState,
    Text,
    Unknown,
)
from olp.ir.program import Declare, Jump, Label, LineKind, Move, Routine, Speed
from olp.languages.findings import Findings
from olp.languages.vendors.rapid.names import RapidNames
from olp.languages.vendors.rapid.predefined_data import FASTEST

_NAME_LENGTH = 32
_OWN = frozenset({"tool0", "wobj0", "load0"})


def is_readable(findings: Findings) -> bool:
    """Whether the file is text with at least one module; if not, one error says so."""
    source = findings.source
    if source.encoding.startswith("utf-16") or b"\0" in source.raw:
        return _refuse(findings, "this is no module but binary or UTF-16", "save it as plain text")
    if not source.raw.strip():
        return _refuse(findings, "the file is empty", "a module begins with MODULE and its name")
    if not any("MODULE" in line.upper() or "PROC" in line.upper() for line in source.lines):
        return _refuse(findings, "this is no module: no line has the word MODULE", "MODULE name … ENDMODULE")
    return True


def _refuse(findings: Findings, message: str, help: str) -> bool:
    findings.error("P450", message, Span(0), help=help)
    for number, line in enumerate(findings.source.lines):
        findings.kinds[number] = LineKind.ERROR if line.strip() else LineKind.BLANK
    return False


def check_program(
    findings: Findings, routines: Sequence[Routine], data: Sequence[Declare], names: RapidNames
) -> None:
    """Everything that holds for the whole file."""
    _check_names(findings, routines, data)
    _check_frames(findings, data)
    for routine in routines:
        _check_labels(findings, routine)
        _check_moves(findings, routine, names)


def _check_names(findings: Findings, routines: Sequence[Routine], data: Sequence[Declare]) -> None:
    first: dict[str, int] = {}
    named = [(one.line, one.name) for one in routines]
    named += [(one.line, one.name) for one in data]
    for line, name in sorted(named):
        key = name.lower()
        if first.setdefault(key, line) != line:
            message = f"{name[:40]} stands twice"
            help = f"the first one is in line {first[key]}; that one is used"
            findings.warning("P459", message, findings.whole_line(line), help)
        if len(name) > _NAME_LENGTH:
            message = f"a name of more than {_NAME_LENGTH} characters"
            span = findings.whole_line(line)
            findings.once(Severity.INFO, "P460", "", message, span, "the controller refuses it")


def _check_frames(findings: Findings, data: Sequence[Declare]) -> None:
    """Work objects that a mechanical unit carries."""
    for one in data:
        if one.type != "frame" or not isinstance(one.value, RecordLiteral):
            continue
        members = dict(one.value.members)
        unit = members.get("ufmec")
        if (isinstance(unit, Text) and unit.value) or members.get("ufprog") == SignalState(False):
            message = f"{one.name[:40]} moves with a mechanical unit: it is planned as if it stood still"
            findings.warning(
                "P473", message, findings.whole_line(one.line), "give it a user frame of its own"
            )


def _check_labels(findings: Findings, routine: Routine) -> None:
    jumps = [one for one in routine.body if type(one) is Jump]
    labels: dict[str, int] = {}
    for one in routine.body:
        if type(one) is Label and labels.setdefault(one.name, one.line) != one.line:
            message = f"label {one.name} stands twice"
            help = f"jumps go to the first one, in line {labels[one.name]}"
            findings.warning("P458", message, findings.whole_line(one.line), help)
    for jump in jumps:
        if jump.target not in labels:
            known = ", ".join(list(labels)[:8]) or "none"
            message = f"label {jump.target} does not exist"
            findings.error(
                "P458", message, findings.whole_line(jump.line), f"labels of this routine: {known}"
            )


def _check_moves(findings: Findings, routine: Routine, names: RapidNames) -> None:
    inside = names.inside.get(routine.line, {})
    told: set[str] = set(_OWN)
    fastest: set[int] = set()
    for one in routine.body:
        if type(one) is not Move:
            continue
        for value in (*one.targets, one.via, one.tool, one.frame):
            if (
                value is None
                or type(value) is PositionLiteral
                or (type(value) is Named and value.name in told)
            ):
                continue
            base = _base(value)
            if isinstance(base, Unknown):
                message = "the position of * stands in the controller's memory only"
                if base.text != "*":
                    message = f"nobody has filled in {base.text}"
                findings.once(
                    Severity.WARNING,
                    "P462",
                    base.text,
                    message,
                    findings.whole_line(one.line),
                    "give the point a name",
                )
            elif base is not None and base.name not in told:
                told.add(base.name)
                key = base.name.lower()
                if key not in inside and key not in names.types and key not in _OWN:
                    message = f"{base.name[:40]} is declared in another file"
                    span = findings.whole_line(one.line)
                    help = "put that module into the folder of this one, or under SYSMOD beside it"
                    findings.once(Severity.INFO, "P472", key, message, span, help)
        if id(one.speed) not in fastest:
            fastest.add(id(one.speed))
            _check_speed(findings, one.speed, one.line)


def _check_speed(findings: Findings, speed: Speed | None, line: int) -> None:
    if speed is not None and speed.native == "vmax":
        message = f"vmax is read as {FASTEST:g} mm/s: the robot decides"
        findings.once(
            Severity.INFO, "P464", "", message, findings.whole_line(line), "write a speed of your own"
        )


def _base(value: Expression | None) -> Named | Unknown | None:
    while isinstance(value, (Item, Member)):
        value = value.base
    return value if isinstance(value, (Named, Unknown)) else None
