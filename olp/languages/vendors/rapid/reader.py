"""A whole file: its modules, their data and routines, and everything that is wrong with it."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence, Set
from dataclasses import replace
from typing import Final

from olp.core.diagnostic import Diagnostic, Severity, Span
from olp.core.garbage_collection import no_garbage_collection
from olp.core.source import Source, load
from olp.ir import expressions as ex
from olp.ir.program import Declare, Jump, Label, LineKind, Move, Program, Routine, Speed, Statement
from olp.languages.findings import Findings
from olp.languages.vendors.rapid.clauses import Cutter
from olp.languages.vendors.rapid.literals import is_unturned
from olp.languages.vendors.rapid.modules import ModuleReader
from olp.languages.vendors.rapid.names import RapidNames, gather
from olp.languages.vendors.rapid.predefined_data import FASTEST

_LISTING = re.compile(r"\s*(?:<\?xml\b|<Program\b)")


def read_program(source: Source) -> Program:
    """The program in a file of modules, or in a .pgf that lists them. Never raises on bad text."""
    if any(_LISTING.match(line) for line in source.lines[:3]):
        return read_listing(source)
    return read_modules(source)


def read_modules(source: Source) -> Program:
    """The program in a file that holds modules."""
    findings = Findings(source)
    routines: tuple[Routine, ...] = ()
    data: tuple[Declare, ...] = ()
    if is_readable(findings):
        with no_garbage_collection():
            clauses = list(Cutter(source.lines).cut())
            names = gather(clauses)
            reader = ModuleReader(findings, names)
            reader.read(clauses)
            routines, data = tuple(reader.routines), tuple(reader.data)
            check_program(findings, routines, data, names)
    main = main_of(routines)
    kinds = bytes(findings.kinds)
    return Program(
        "rapid",
        source,
        routines,
        findings.result(),
        kinds,
        data,
        main,
        main_is_guessed=main.lower() != _MAIN,
    )


_MAIN: Final = "main"  # which a task begins with (RAPID overview, "The main routine")


def main_of(routines: tuple[Routine, ...]) -> str:
    """PROC main, else the first PROC that needs no argument."""
    called = [one for one in routines if one.details.get("kind", "PROC") == "PROC"]
    main = next((one for one in called if one.name.lower() == _MAIN), None)
    if main is None:
        main = next((one for one in called if all(p.optional for p in one.parameters)), None)
    return "" if main is None else main.name


# --- Listing ---
# A .pgf: the list of a program's modules, which are read from the same folder.

_MODULE: Final = re.compile(r"<Module>\s*([^<]*?)\s*</Module>", re.IGNORECASE)
_MOST_BYTES: Final = 64 * 1024 * 1024  # bytes of all modules
_MOST: Final = 200  # modules


def read_listing(source: Source) -> Program:
    """All modules as one program. Line numbers continue after the list's; diagnostics name the modules' own files."""

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
    main = main_of(tuple(routines))
    return Program(
        "rapid",
        whole,
        tuple(routines),
        tuple(told),
        bytes(kinds),
        tuple(data),
        main,
        tuple(module.source for module in modules),
        main_is_guessed=main.lower() != _MAIN,
    )


def _module(findings: Findings, source: Source, name: str, span: Span) -> Source | None:
    """The module's text; a file that cannot be read is a diagnostic."""
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
        if os.path.islink(path) or os.path.getsize(path) > _MOST_BYTES:
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


# --- Checks ---
# Checks of a file whose statements are all valid: missing labels, duplicate names, points without a value.

_NAME_LENGTH = 32
_OWN = frozenset({"tool0", "wobj0", "load0"})


def is_readable(findings: Findings) -> bool:
    """Whether the file is text with at least one module; if not, one error says so."""
    source = findings.source
    if source.encoding.startswith("utf-16") or b"\0" in source.raw:
        return _refuse(
            findings,
            "this is no module but binary or UTF-16",
            "save it as plain text: Notepad calls it ANSI or UTF-8",
        )
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
    """Adds the findings that concern the whole file."""
    _check_names(findings, routines, data)
    _check_frames(findings, data)
    _check_fastest(findings)
    unturned = {one.name.lower() for one in data if one.storage == "constant" and is_unturned(one.value)}
    for routine in routines:
        _check_labels(findings, routine)
        _check_moves(findings, routine, names, unturned)


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
    """Warns of work objects that a mechanical unit moves."""
    for one in data:
        if one.type != "frame" or not isinstance(one.value, ex.RecordLiteral):
            continue
        members = dict(one.value.members)
        unit = members.get("ufmec")
        if (isinstance(unit, ex.Text) and unit.value) or members.get("ufprog") == ex.SignalState(False):
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


def _check_moves(findings: Findings, routine: Routine, names: RapidNames, unturned: Set[str]) -> None:
    """Checks points and speeds of moves. `unturned`: constants with a quaternion of zeros, in lower case."""
    inside = names.inside.get(routine.line, {})
    told: set[str] = set(_OWN)
    fastest: set[int] = set()
    for one in routine.body:
        if type(one) is not Move:
            continue
        for value in (*one.targets, one.via, one.tool, one.frame):
            if (
                value is None
                or type(value) is ex.PositionLiteral
                or (type(value) is ex.Named and value.name in told)
            ):
                continue
            base = _base(value)
            if isinstance(base, ex.Unknown):
                message = "the position of * is in the controller's memory only"
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
                if key in unturned and key not in inside:
                    message = f"{base.name[:40]} has a quaternion of zeros, which is no rotation"
                    findings.error("P465", message, findings.whole_line(one.line), "teach it")
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


def _check_fastest(findings: Findings) -> None:
    if b"maxrobspeed" not in findings.source.raw.lower():
        return
    for number, line in enumerate(findings.source.lines, 1):
        if "maxrobspeed" in line.partition("!")[0].lower():
            message = f"MaxRobSpeed() is read as {FASTEST:g} mm/s: the robot decides"
            help = "write a speed of your own"
            findings.once(Severity.INFO, "P464", "function", message, findings.whole_line(number), help)


def _base(value: ex.Expression | None) -> ex.Named | ex.Unknown | None:
    while isinstance(value, (ex.Item, ex.Member)):
        value = value.base
    return value if isinstance(value, (ex.Named, ex.Unknown)) else None
