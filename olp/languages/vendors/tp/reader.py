"""A whole listing: header, instructions and positions, and everything that is wrong with it."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, TypeGuard

from olp.core.diagnostic import Severity, Span
from olp.core.garbage_collection import no_garbage_collection
from olp.core.source import Source
from olp.ir import program as st
from olp.ir.block_structure import pair
from olp.ir.expressions import Expression, FrameRef, Number, Store, Taught, Text
from olp.ir.points import PointKind
from olp.languages.findings import Findings
from olp.languages.vendors.tp import values
from olp.languages.vendors.tp.instructions import (
    BLOCK,
    ON_ITS_WAY,
    TpInstructionReader,
    TpMoveLines,
    attribute,
    attribute_value,
    instructions,
    is_german,
)
from olp.languages.vendors.tp.limits import COMMENT_LENGTH, LARGEST_LABEL, ROUTINE_LENGTH
from olp.languages.vendors.tp.moves import with_conditions
from olp.languages.vendors.tp.positions import MODAL, TpPositionReader

# Comments of signals and labels, which belong to the controller and stand wherever the signal does.
_NAMED = re.compile(
    r"\b(DI|DO|RI|RO|GI|GO|AI|AO|SI|SO|UI|UO|WI|WO|F|M|TIMER|PAYLOAD)\[(\d{1,5}):([^\]\n]*)\]"
)


def read_program(source: Source) -> st.Program:
    """The program in a listing. Never raises on bad text."""
    findings = Findings(source)
    routines: tuple[st.Routine, ...] = ()
    if is_readable(findings):
        with no_garbage_collection():
            routines = tuple(_routine(findings, listing) for listing in listings(findings))
    text = "\n".join(source.lines) if routines else ""
    data: tuple[st.Declare, ...] = ()
    if values.TIMEOUT in text or "TIMEOUT" in text:
        data = (st.Declare(0, values.TIMEOUT, "integer", Number(values.USUAL_TIMEOUT), shared=True),)
    return st.Program("tp", source, routines, findings.result(), bytes(findings.kinds), data)


def _routine(findings: Findings, listing: TpSections) -> st.Routine:
    lines = findings.source.lines
    first, stop = listing.sections.get("/MN", (0, 0))
    german = is_german("\n".join(lines[max(listing.line - 1, 0) : max(first - 1, 0)]))
    if german:
        message = "German keywords are read as the English ones they stand for"
        findings.info("P530", message, Span(listing.line, 1, 1), "exported programs are in English")
    reader = TpInstructionReader(findings, TpMoveLines(), german)
    body = reader.read(instructions(lines, first, stop) if first else ())
    positions = TpPositionReader(findings)
    begin, end = listing.sections.get("/POS", (0, 0))
    if begin:
        positions.read(begin, end)
    table = positions.table()
    routine = st.Routine(
        listing.name or "UNNAMED",
        listing.line,
        tuple(with_conditions(body)),
        table,
        _groups(listing),
        listing.comment,
        details=_details(listing, positions, "\n".join(lines[first - 1 : stop - 1]) if first else ""),
        last_line=listing.last_line,
    )
    check_routine(findings, listing, routine, positions, reader.markers)
    return routine


def _groups(listing: TpSections) -> tuple[st.ControlGroup, ...]:
    """DEFAULT_GROUP 1,*,*,*,*: a program drives its first motion group, which is a robot; *,*,*,*,*: none."""
    mask = listing.attributes.get("DEFAULT_GROUP", "1")
    return (st.ControlGroup(("RB1",)),) if "1" in mask else ()


def _details(listing: TpSections, positions: TpPositionReader, text: str) -> dict[str, str]:
    """What only TP's own writer needs: attributes, names of positions and signals, units of slides."""
    found = {f"/ATTR {name}": value for name, value in listing.attributes.items()}
    if listing.kind:
        found["/PROG"] = listing.kind
    if listing.application:
        found["/APPL"] = "\n".join(listing.application)
    for number, name in positions.names.items():
        found[f"P[{number}]"] = name
    for axis, unit in positions.units.items():
        found[f"unit {axis}"] = unit
    for place, group in enumerate(positions.groups(), 1):
        if group != place:
            found[f"group {place}"] = str(group)
    if positions.other_configuration:
        found["CONFIG"] = positions.other_configuration
    for match in _NAMED.finditer(text):
        found.setdefault(f"{match[1]}[{match[2]}]", match[3].strip())
    return found


# --- Checks ---
# What can be wrong with a listing whose lines are all fine: sections, labels, blocks, positions, comments.


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
        findings.kinds[number] = st.LineKind.ERROR if line.strip() else st.LineKind.BLANK
    return False


def check_routine(
    findings: Findings,
    listing: TpSections,
    routine: st.Routine,
    positions: TpPositionReader,
    markers: Sequence[st.Statement],
) -> None:
    """Everything that holds for one program. `markers`: stand for broken lines that open a block."""
    _check_sections(findings, listing)
    if "/MN" not in listing.sections:
        return
    flow = [one for one in routine.body if type(one) is not st.Move]
    if markers:
        flow = sorted([*flow, *markers], key=lambda one: one.line)
    for problem in pair(flow).problems:
        tell = _unpaired if "label" not in problem.message else _missing if problem.is_error else _repeated
        tell(findings, problem.line, problem.message)
    _check_points(findings, routine, positions)
    _check_lengths(findings, routine)
    _tell_conventions(findings, routine)
    _tell_calls(findings, routine)


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


def _used(routine: st.Routine) -> Iterator[tuple[int, Expression]]:
    for one in routine.body:
        if type(one) is st.Move:
            yield one.line, one.targets[0]
            if one.via is not None:
                yield one.line, one.via
        elif type(one) is st.Assign:
            yield one.line, one.value


def _check_points(findings: Findings, routine: st.Routine, positions: TpPositionReader) -> None:
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


def _check_lengths(findings: Findings, routine: st.Routine) -> None:
    for one in routine.body:
        if type(one) is st.Comment and len(one.text) > COMMENT_LENGTH and not one.text.startswith("--eg:"):
            message = f"a comment of {len(one.text)} characters"
            help = f"controllers keep {COMMENT_LENGTH} characters"
            findings.once(Severity.INFO, "P506", "", message, findings.whole_line(one.line), help)
        elif type(one) is st.Label and not 1 <= int(one.name.split("/")[0]) <= LARGEST_LABEL:
            span = findings.whole_line(one.line)
            findings.warning("P529", f"no controller takes label {one.name}", span, f"1 .. {LARGEST_LABEL}")


def _tell_calls(findings: Findings, routine: st.Routine) -> None:
    """`TB .10sec,CALL OPEN`: the program runs beside the move, and a plan has one thing after the other."""
    for one in routine.body:
        if type(one) is not st.Move or not one.other:
            continue
        called = next((value for name, value in one.other if name in ON_ITS_WAY), None)
        text = called.value.partition(",")[2] if isinstance(called, Text) else ""
        if text and text != BLOCK:  # its block is read behind the move
            name = text.removeprefix("CALL ")
            message = f"{name} runs beside the move: it is left out of the plan"
            help = "where the program waits for it, add its time as a wait"
            findings.once(Severity.INFO, "P535", name, message, findings.whole_line(one.line), help)


def _tell_conventions(findings: Findings, routine: st.Routine) -> None:
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


def _defines_frame(statement: st.Statement) -> TypeGuard[Any]:
    return type(statement) is st.Assign and type(statement.target) is FrameRef


# --- Header ---
# The sections of a listing and the attributes above its instructions.

SECTIONS: Final = ("/PROG", "/ATTR", "/APPL", "/MN", "/POS", "/END")
_SECTION = re.compile(r"\s*(/[A-Z]+)\b(.*)", re.DOTALL)
_PROGRAM = re.compile(r"\s*([^\s;]+)\s*(.*?)\s*;?\s*")
_ATTRIBUTE = re.compile(r"\s*([^\s=:,][^=,;]*?)\s*=\s*(.*)")
_QUOTED = re.compile(r'"(.*)"')


@dataclass(slots=True)
class TpSections:
    """Where the sections of one program stand: line numbers (from 1) of the first and behind the last line of each.

    `attributes`: by their English names, in order; values as written. `application`: the lines of /APPL.
    """

    name: str = ""
    kind: str = ""  # what stands behind the name: Macro, Process …
    line: int = 0
    last_line: int = 0
    sections: dict[str, tuple[int, int]] = field(default_factory=dict)
    attributes: dict[str, str] = field(default_factory=dict)
    application: list[str] = field(default_factory=list)

    @property
    def comment(self) -> str:
        text = self.attributes.get("COMMENT", "")
        quoted = _QUOTED.search(text)
        return quoted[1] if quoted else ""


def listings(findings: Findings) -> list[TpSections]:
    """The programs of a file: usually one, and one more with every further /PROG."""
    found: list[TpSections] = []
    current: TpSections | None = None
    section, start = "", 0
    lines = findings.source.lines
    for number, text in enumerate(lines, 1):
        if "/" not in text[:8] or text.lstrip()[:1] != "/":
            continue
        match = _SECTION.match(text)
        if match is None or match[1] not in SECTIONS:
            continue
        if current is not None and section:
            current.sections.setdefault(section, (start, number))
        if match[1] == "/PROG" or current is None:
            current = TpSections(line=number)
            found.append(current)
            if match[1] == "/PROG":
                _take_name(current, match[2])
        section, start = match[1], number + 1
        current.last_line = number
        findings.kinds[number - 1] = st.LineKind.RECORD
        if section == "/END":
            current.sections["/END"] = (number, number)
            section = ""
    if current is not None and section:
        current.sections.setdefault(section, (start, len(lines) + 1))
        current.last_line = len(lines)
    for listing in found:
        _take_attributes(findings, listing)
    return found


def _take_name(listing: TpSections, text: str) -> None:
    match = _PROGRAM.fullmatch(text)
    if match is not None:
        listing.name, listing.kind = match[1], match[2]


def _take_attributes(findings: Findings, listing: TpSections) -> None:
    lines = findings.source.lines
    first, stop = listing.sections.get("/PROG", (0, 0))
    later = listing.sections.get("/ATTR", (0, 0))
    for number in (*range(first, stop), *range(*later)):
        text = lines[number - 1]
        if not text.strip():
            continue
        findings.kinds[number - 1] = st.LineKind.RECORD
        text = text.strip()
        if text.startswith("TCD:"):
            text = text[4:].strip()
        match = _ATTRIBUTE.match(text.rstrip(" \t;,"))
        if match is not None:
            listing.attributes.setdefault(attribute(match[1]), attribute_value(match[2]))
    for number in range(*listing.sections.get("/APPL", (0, 0))):
        if lines[number - 1].strip():
            findings.kinds[number - 1] = st.LineKind.RECORD
            listing.application.append(lines[number - 1].rstrip())
