"""A whole listing: header, instructions and positions, and everything that is wrong with it."""

from __future__ import annotations

import re

from olp.core.diagnostic import Span
from olp.core.garbage_collection import no_garbage_collection
from olp.core.source import Source
from olp.ir.expressions import Number
from olp.ir.program import ControlGroup, Declare, Program, Routine
from olp.languages.findings import Findings
from olp.languages.vendors.tp import checks, values
from olp.languages.vendors.tp.fast import TpMoveLines
from olp.languages.vendors.tp.german_keywords import is_german
from olp.languages.vendors.tp.header import TpSections, listings
from olp.languages.vendors.tp.instructions import TpInstructionReader
from olp.languages.vendors.tp.lines import instructions
from olp.languages.vendors.tp.positions import TpPositionReader

# Comments of signals and labels, which belong to the controller and stand wherever the signal does.
_NAMED = re.compile(
    r"\b(DI|DO|RI|RO|GI|GO|AI|AO|SI|SO|UI|UO|WI|WO|F|M|TIMER|PAYLOAD)\[(\d{1,5}):([^\]\n]*)\]"
)


def read_program(source: Source) -> Program:
    """The program in a listing. Never raises on bad text."""
    findings = Findings(source)
    routines: tuple[Routine, ...] = ()
    if checks.is_readable(findings):
        with no_garbage_collection():
            routines = tuple(_routine(findings, listing) for listing in listings(findings))
    text = "\n".join(source.lines) if routines else ""
    data: tuple[Declare, ...] = ()
    if values.TIMEOUT in text or "TIMEOUT" in text:
        data = (Declare(0, values.TIMEOUT, "integer", Number(values.USUAL_TIMEOUT)),)
    return Program("tp", source, routines, findings.result(), bytes(findings.kinds), data)


def _routine(findings: Findings, listing: TpSections) -> Routine:
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
    routine = Routine(
        listing.name or "UNNAMED",
        listing.line,
        tuple(body),
        table,
        _groups(listing),
        listing.comment,
        details=_details(listing, positions, "\n".join(lines[first - 1 : stop - 1]) if first else ""),
        last_line=listing.last_line,
    )
    checks.check_routine(findings, listing, routine, positions, reader.markers)
    return routine


def _groups(listing: TpSections) -> tuple[ControlGroup, ...]:
    """DEFAULT_GROUP 1,*,*,*,*: a program drives its first motion group, which is a robot; *,*,*,*,*: none."""
    mask = listing.attributes.get("DEFAULT_GROUP", "1")
    return (ControlGroup(("RB1",)),) if "1" in mask else ()


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
