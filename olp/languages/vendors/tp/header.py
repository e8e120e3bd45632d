"""The sections of a listing and the attributes above its instructions."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Final

from olp.ir.program import LineKind
from olp.languages.findings import Findings
from olp.languages.vendors.tp.german_keywords import attribute, attribute_value

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
        findings.kinds[number - 1] = LineKind.RECORD
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
        findings.kinds[number - 1] = LineKind.RECORD
        text = text.strip()
        if text.startswith("TCD:"):
            text = text[4:].strip()
        match = _ATTRIBUTE.match(text.rstrip(" \t;,"))
        if match is not None:
            listing.attributes.setdefault(attribute(match[1]), attribute_value(match[2]))
    for number in range(*listing.sections.get("/APPL", (0, 0))):
        if lines[number - 1].strip():
            findings.kinds[number - 1] = LineKind.RECORD
            listing.application.append(lines[number - 1].rstrip())
