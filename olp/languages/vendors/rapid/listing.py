"""A .pgf: the list of a program's modules, which are read from the same folder."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from typing import Final

from olp.core.diagnostic import Diagnostic, Span
from olp.core.source import Source, load
from olp.ir.program import Declare, LineKind, Program, Routine, Statement
from olp.languages.findings import Findings

_MODULE: Final = re.compile(r"<Module>\s*([^<]*?)\s*</Module>", re.IGNORECASE)
_LARGEST: Final = 64 * 1024 * 1024  # bytes of all modules
_MOST: Final = 200  # modules


def read_listing(source: Source) -> Program:
    """All modules as one program. Lines count on behind those of the list; diagnostics name the modules' own files."""
    from olp.languages.vendors.rapid.reader import main_of, read_modules

    findings = Findings(source)
    modules: list[Program] = []
    for number, line in enumerate(source.lines, 1):
        findings.kinds[number - 1] = LineKind.RECORD if line.strip() else LineKind.BLANK
        for match in _MODULE.finditer(line):
            found = _module(findings, source, match[1], Span(number, match.start(1) + 1, match.end(1) + 1))
            if found is not None and len(modules) < _MOST:
                modules.append(read_modules(found))
    routines: list[Routine] = []
    data: list[Declare] = []
    lines, kinds = list(source.lines), bytearray(findings.kinds)
    told: list[Diagnostic] = list(findings.result())
    for module in modules:
        routines += [_moved(routine, len(lines)) for routine in module.routines]
        data += [replace(one, line=one.line + len(lines)) for one in module.data]
        told += module.diagnostics
        lines += module.source.lines
        kinds += module.line_kinds
    whole = replace(source, lines=tuple(lines))
    return Program(
        "rapid",
        whole,
        tuple(routines),
        tuple(told),
        bytes(kinds),
        tuple(data),
        main_of(tuple(routines)),
        tuple(module.source for module in modules),
    )


def _module(findings: Findings, source: Source, name: str, span: Span) -> Source | None:
    """The module's text; what cannot be read is told."""
    folder = os.path.dirname(source.path)
    if not name or name in (".", "..") or set(name) & set("/\\:\0"):
        findings.error(
            "P470", f"{name[:60]!r} is no file of this folder", span, "modules stand beside the list"
        )
        return None
    wanted = name.lower()
    try:
        entries = [
            one.name for one in os.scandir(folder or ".") if one.name.lower() == wanted and one.is_file()
        ]
        path = os.path.join(folder, name if name in entries or not entries else entries[0])
        if os.path.islink(path) or os.path.getsize(path) > _LARGEST:
            raise OSError(0, "it is a link, or too large")
        return load(path)
    except (OSError, ValueError) as problem:
        why = getattr(problem, "strerror", None) or str(problem)
        findings.error(
            "P470", f"the module {name[:60]} cannot be read: {why}", span, "put it beside the list"
        )
        return None


def _moved(routine: Routine, by: int) -> Routine:
    body: tuple[Statement, ...] = tuple(replace(one, line=one.line + by) for one in routine.body)
    return replace(routine, line=routine.line + by, last_line=routine.last_line + by, body=body)
