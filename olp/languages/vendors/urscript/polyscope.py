"""PolyScope's own files (.urp): compressed XML of program nodes, told as the script that those nodes mean.

The lines of the source are that script; its bytes stay those of the file. Waypoints are joint positions, as taught.

Codes: P562 a file that cannot be read, P563 a node that is kept by its name only.
"""

from __future__ import annotations

import zlib
from pathlib import PurePath
from xml.etree import ElementTree

from olp.core.diagnostic import Diagnostic, Severity, Span
from olp.core.source import Source
from olp.ir.program import LineKind, Program
from olp.languages.findings import Findings

_LARGEST = 50_000_000  # bytes that are unpacked; the largest programs have a tenth


def read_polyscope(source: Source) -> Program:
    """The program in a .urp file. Never raises."""
    from dataclasses import replace

    from olp.languages.vendors.urscript.polyscope_nodes import Script
    from olp.languages.vendors.urscript.reader import read_lines

    try:
        root = ElementTree.fromstring(_unpacked(source.raw))
    except (ElementTree.ParseError, zlib.error, ValueError) as problem:
        return _refused(source, f"this PolyScope program cannot be read: {problem}")
    if root.tag != "URProgram":
        return _refused(source, f"this is no PolyScope program: its first node is {root.tag[:40]}")
    script = Script(root, PurePath(source.path).stem)
    view = replace(source, encoding="utf-8", lines=tuple(script.lines))
    program = read_lines(view)
    unknown = [
        Diagnostic(
            "P563",
            f"the node {name} is kept by its name only ({count} of them)",
            Severity.WARNING,
            source.path,
            help="export the program as .script, which holds what the node does",
        )
        for name, count in sorted(script.unknown.items())
    ]
    return replace(program, diagnostics=(*unknown, *program.diagnostics))


def _unpacked(raw: bytes) -> bytes:
    """The XML. Raises zlib.error, and ValueError for what no controller wrote."""
    unpacker = zlib.decompressobj(31)
    plain = raw.lstrip().startswith(b"<")
    data = raw if plain else unpacker.decompress(raw, _LARGEST)
    if unpacker.unconsumed_tail:
        raise ValueError(f"it is larger than {_LARGEST} bytes")
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise ValueError("it defines entities")
    return data


def _refused(source: Source, message: str) -> Program:
    findings = Findings(source)
    findings.error("P562", message, Span(0), "save it again on the controller, or export it as .script")
    findings.kinds[:] = bytes([LineKind.ERROR]) * len(findings.kinds)
    return Program("urscript", source, (), findings.result(), bytes(findings.kinds))
