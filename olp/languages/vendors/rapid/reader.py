"""A whole file: its modules, their data and routines, and everything that is wrong with it."""

from __future__ import annotations

import re

from olp.core.garbage_collection import no_garbage_collection
from olp.core.source import Source
from olp.ir.program import Declare, Program, Routine
from olp.languages.findings import Findings
from olp.languages.vendors.rapid import checks
from olp.languages.vendors.rapid.clauses import Cutter
from olp.languages.vendors.rapid.modules import ModuleReader
from olp.languages.vendors.rapid.names import gather

_LISTING = re.compile(r"\s*(?:<\?xml\b|<Program\b)")


def read_program(source: Source) -> Program:
    """The program in a file of modules, or in a .pgf that lists them. Never raises on bad text."""
    if any(_LISTING.match(line) for line in source.lines[:3]):
        from olp.languages.vendors.rapid.listing import read_listing

        return read_listing(source)
    return read_modules(source)


def read_modules(source: Source) -> Program:
    """The program in a file that holds modules."""
    findings = Findings(source)
    routines: tuple[Routine, ...] = ()
    data: tuple[Declare, ...] = ()
    if checks.is_readable(findings):
        with no_garbage_collection():
            clauses = list(Cutter(source.lines).cut())
            names = gather(clauses)
            reader = ModuleReader(findings, names)
            reader.read(clauses)
            routines, data = tuple(reader.routines), tuple(reader.data)
            checks.check_program(findings, routines, data, names)
    return Program(
        "rapid", source, routines, findings.result(), bytes(findings.kinds), data, main_of(routines)
    )


def main_of(routines: tuple[Routine, ...]) -> str:
    """PROC main, else the first PROC that needs no argument."""
    called = [one for one in routines if one.details.get("kind", "PROC") == "PROC"]
    main = next((one for one in called if one.name.lower() == "main"), None)
    if main is None:
        main = next((one for one in called if all(p.optional for p in one.parameters)), None)
    return "" if main is None else main.name
