"""What can be wrong with a listing whose lines are all fine: sections, labels, blocks, positions, comments."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from typing import Any, TypeGuard

from olp.core.diagnostic import Severity, Span
from olp.ir.block_structure import pair
from olp.ir.expressions import Expression, FrameRef, Number, Store, Taught
from olp.ir.points import PointKind
from olp.ir.program import Assign, Comment, Label, LineKind, Move, Routine, Statement
from olp.languages.findings import Findings
from olp.languages.vendors.tp.header import TpSections
from olp.languages.vendors.tp.limits import COMMENT_LENGTH, LARGEST_LABEL, ROUTINE_LENGTH
from olp.languages.vendors.tp.positions import MODAL, TpPositionReader


def is_readable(findings: Findings) -> bool:
    """Whether the file is a listing of a program; if not, one error says so."""
    source = findings.source
    if source.encoding.startswith("utf-16") or b"\0" in source.raw:
        return _refuse(
            findings, "P500", "this is no listing but binary or UTF-16", "list the program as ASCII (.ls)"
        )
    marked = ("/PROG", "/MN")
    if not any(line.lstrip().startswith(marked) for line in source.lines if "/" in line):
        what = (
            "the file is empty"
            if not source.raw.strip()
            else "this is no listing of a program: it has no /PROG"
        )
        return _refuse(findings, "P500", what, "a program begins with /PROG NAME, /ATTR and /MN")
    return True


def _refuse(findings: Findings, code: str, message: str, help: str) -> bool:
    findings.error(code, message, Span(0), help)
    for number, line in enumerate(findings.source.lines):
        findings.kinds[number] = LineKind.ERROR if line.strip() else LineKind.BLANK
    return False


def check_routine(
    findings: Findings,
    listing: TpSections,
    routine: Routine,
    positions: TpPositionReader,
    markers: Sequence[Statement],
) -> None:
    """Everything that holds for one program. `markers`: stand for broken lines that open a block."""
    _check_sections(findings, listing)
    if "/MN" not in listing.sections:
        return
    flow = [one for one in routine.body if type(one) is not Move]
    if markers:
        flow = sorted([*flow, *markers], key=lambda one: one.line)
    for problem in pair(flow).problems:
        tell = _unpaired if "label" not in problem.message else _missing if problem.is_error else _repeated
        tell(findings, problem.line, problem.message)
    _check_points(findings, routine, positions)
    _check_lengths(findings, routine)
    _tell_conventions(findings, routine)


def _check_sections(findings: Findings, listing: TpSections) -> None:
    last = findings.whole_line(max(listing.last_line, 1))
    head = findings.whole_line(max(listing.line, 1))
    if not listing.name:
        findings.error("P501", "the program has no name", head, "expected /PROG NAME as the first line")
    elif len(listing.name) > ROUTINE_LENGTH:
        help = f"at most {ROUTINE_LENGTH} characters, 8 before the R-30iA"
        findings.warning("P503", f"the program's name has {len(listing.name)} characters", head, help)
    if "/MN" not in listing.sections:
        findings.error(
            "P502", "the program has no /MN", last, "is the file cut off? /MN begins the instructions"
        )
    elif "/END" not in listing.sections:
        help = "is the file cut off? /END is the last line of a listing"
        findings.warning("P505", "the program has no /END", last, help)


def _unpaired(findings: Findings, line: int, message: str) -> None:
    for inform, tp in (("IFTHEN", "IF"), ("SWITCH", "SELECT"), ("NEXT", "ENDFOR")):
        message = message.replace(inform, tp)
    help = "IF (…) THEN needs ENDIF, FOR needs ENDFOR"
    findings.error("P528", message, findings.whole_line(line), help)


def _repeated(findings: Findings, line: int, message: str) -> None:
    findings.warning("P527", _label(message), findings.whole_line(line), "jumps go to the first one")


def _missing(findings: Findings, line: int, message: str) -> None:
    findings.error("P526", _label(message), findings.whole_line(line), "add the label, or correct its number")


def _label(message: str) -> str:
    """`label *7 …` in TP's words; the labels of P-SPS blocks lose the line of their block."""
    name = message.split("*", 1)[1].split(" ")[0]
    return message.replace(f"label *{name}", f"LBL[{name.split('/')[0]}]")


# --- positions ------------------------------------------------------------------------------------------


def _used(routine: Routine) -> Iterator[tuple[int, Expression]]:
    for one in routine.body:
        if type(one) is Move:
            yield one.line, one.targets[0]
            if one.via is not None:
                yield one.line, one.via
        elif type(one) is Assign:
            yield one.line, one.value


def _check_points(findings: Findings, routine: Routine, positions: TpPositionReader) -> None:
    block = routine.points.blocks.get((Store.ROBOT, True))
    rows = block.rows if block is not None else {}
    numbers = sorted(rows)
    for line, target in _used(routine):
        if type(target) is not Taught:
            continue
        number = target.number
        if number not in rows:
            if number not in positions.broken:
                _report_missing(findings, line, number, numbers)
        elif number in positions.uninitialised:
            message = f"P[{number}] is used, and was never taught (********)"
            findings.once(
                Severity.WARNING, "P516", str(number), message, findings.whole_line(line), "teach it"
            )


def _report_missing(findings: Findings, line: int, number: int, numbers: list[int]) -> None:
    if not numbers:
        message = "the listing has no positions: where its moves go is not known"
        findings.once(
            Severity.WARNING, "P515", "", message, findings.whole_line(line), "list it with its /POS section"
        )
        return
    place = bisect_left(numbers, number)
    near = min(numbers[max(place - 1, 0) : place + 1], key=lambda known: abs(known - number))
    help = f"the nearest one is P[{near}]"
    findings.error("P525", f"there is no position P[{number}]", findings.whole_line(line), help)


def _check_lengths(findings: Findings, routine: Routine) -> None:
    for one in routine.body:
        if type(one) is Comment and len(one.text) > COMMENT_LENGTH and not one.text.startswith("--eg:"):
            message = f"a comment of {len(one.text)} characters"
            help = f"controllers keep {COMMENT_LENGTH} characters"
            findings.once(Severity.INFO, "P506", "", message, findings.whole_line(one.line), help)
        elif type(one) is Label and not 1 <= int(one.name.split("/")[0]) <= LARGEST_LABEL:
            span = findings.whole_line(one.line)
            findings.warning("P529", f"no controller takes label {one.name}", span, f"1 .. {LARGEST_LABEL}")


def _tell_conventions(findings: Findings, routine: Routine) -> None:
    """What a listing leaves open, told once where it matters."""
    block = routine.points.blocks.get((Store.ROBOT, True))
    if block is None or not len(block):
        return
    states = routine.points.states
    line = int(block.lines[0])
    if any(state.kind is PointKind.JOINT for state in states):
        message = "joint positions: J3 of FANUC arms is measured to the horizontal"
        help = "it is taken as written, unless the robot says that its axis 3 couples with axis 2"
        findings.once(Severity.INFO, "P533", "", message, findings.whole_line(line), help)
    defined = {(one.target.kind, one.target.number) for one in routine.body if _defines_frame(one)}
    wanted = {("user", Number(state.user)) for state in states if state.user}
    wanted |= {("tool", Number(state.tool)) for state in states if state.tool not in (0, MODAL)}
    if wanted - defined:
        message = "the values of frames and tools are not in a listing"
        help = "give them in olp.toml: [frames], [tools]"
        findings.once(Severity.INFO, "P534", "", message, findings.whole_line(line), help)


def _defines_frame(statement: Statement) -> TypeGuard[Any]:
    return type(statement) is Assign and type(statement.target) is FrameRef
