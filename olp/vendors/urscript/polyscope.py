"""PolyScope's own files."""

from __future__ import annotations

from olp.diagnostic import Span
from olp.program import LineKind, Program
from olp.source import Source
from olp.vendors.inform.findings import Findings


def read_polyscope(source: Source) -> Program:
    """The program in a .urp file."""
    findings = Findings(source)
    findings.error("P562", "a compressed PolyScope program", Span(0), "export it as .script")
    for number in range(len(findings.kinds)):
        findings.kinds[number] = LineKind.ERROR
    return Program("urscript", source, (), findings.result(), bytes(findings.kinds))
