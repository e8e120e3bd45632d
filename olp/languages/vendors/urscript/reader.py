"""A whole file: its functions as routines, the one that runs, the data they share, and what is wrong with it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import PurePath

from olp.core.diagnostic import Span
from olp.core.garbage_collection import no_garbage_collection
from olp.core.source import Source
from olp.ir.program import Declare, LineKind, Program, Routine
from olp.languages.findings import Findings
from olp.languages.vendors.urscript import helpers
from olp.languages.vendors.urscript.bodies import Bodies
from olp.languages.vendors.urscript.lines import Mark, UrscriptLine, UrscriptLineReader
from olp.languages.vendors.urscript.outline import Outliner, UrscriptPart
from olp.languages.vendors.urscript.scopes import UrscriptNames
from olp.languages.vendors.urscript.syntax import Evaluation, Invocation, UrscriptName

_GZIP = b"\x1f\x8b"


def read_program(source: Source) -> Program:
    """The program in a text. Never raises on bad text."""
    if source.raw.startswith((_GZIP, b"<URProgram")):
        from olp.languages.vendors.urscript.polyscope import read_polyscope

        return read_polyscope(source)
    return read_lines(source)


def read_lines(source: Source) -> Program:
    """The program in the lines of a text."""
    findings = Findings(source)
    if not _is_readable(findings):
        return Program("urscript", source, (), findings.result(), bytes(findings.kinds))
    with no_garbage_collection():
        root = Outliner(findings).read(UrscriptLineReader(findings).read())
        _forget_helpers(root)
        main = _main(root, source)
        names = UrscriptNames(root, main)
        bodies = Bodies(findings, names)
        # The main program says which data holds before anything runs.
        routines = [bodies.routine(main, main.unique)]
        routines += [
            bodies.routine(part, part.unique) for part in root.all() if part is not main and part is not root
        ]
        data = [*bodies.data.values(), *bodies.late_data()]
    routines[0] = _without(routines[0], data)
    return Program(
        "urscript",
        source,
        tuple(routines),
        findings.result(),
        bytes(findings.kinds),
        tuple(data),
        main.unique,
    )


def _forget_helpers(root: UrscriptPart) -> None:
    """Functions that olp wrote into the script stand for what they compute."""
    for part in list(root.all()):
        for name in helpers.TEXTS.keys() & part.parts.keys():
            del part.parts[name]


def _without(main: Routine, data: list[Declare]) -> Routine:
    """The main program without the declarations that hold before it runs."""
    from dataclasses import replace

    taken = {id(one) for one in data}
    return replace(main, body=tuple(one for one in main.body if id(one) not in taken))


def _is_readable(findings: Findings) -> bool:
    source = findings.source
    if source.encoding.startswith("utf-16") or any("\0" in line for line in source.lines):
        findings.error(
            "P001", "this is no program text but binary or UTF-16", Span(0), "save it as plain text"
        )
        return _refused(findings)
    if not any(line.strip() for line in source.lines):
        findings.error("P564", "the file is empty", Span(0), "")
        return False
    return True


def _refused(findings: Findings) -> bool:
    for number, line in enumerate(findings.source.lines):
        findings.kinds[number] = LineKind.ERROR if line.strip() else LineKind.BLANK
    return False


def _main(root: UrscriptPart, source: Source) -> UrscriptPart:
    """The part that runs: the file's own instructions, else the function they call, else the one that nobody calls."""
    own = [line for line, _ in root.lines if type(line.content) is not Mark]
    called = _called(own, root)
    if own and called is None:
        root.unique = _identifier(PurePath(source.path).stem, {part.unique for part in root.all()})
        return root
    main = called or _uncalled(root)
    if main is None:
        root.unique = _identifier(PurePath(source.path).stem, set())
        return root
    main.lines = [*((line, 0) for line, _ in root.lines if type(line.content) is Mark), *main.lines]
    return main


def _called(own: list[UrscriptLine], root: UrscriptPart) -> UrscriptPart | None:
    """The function that the file's only instruction calls."""
    if len(own) != 1 or type(own[0].content) is not Evaluation:
        return None
    call = own[0].content.value
    if type(call) is not Invocation or type(call.function) is not UrscriptName or call.arguments:
        return None
    part = root.parts.get(call.function.text)
    return part if part is not None and part.kind == "def" and not part.parameters else None


def _uncalled(root: UrscriptPart) -> UrscriptPart | None:
    """The only function, else the first one that needs no arguments and that no other one calls."""
    parts = [part for part in root.parts.values() if part.kind == "def"]
    if len(parts) < 2:
        return parts[0] if parts else next(iter(root.parts.values()), None)
    called = {
        node.function.text
        for part in root.all()
        for line, _ in part.lines
        for node in _calls_in(line)
        if type(node.function) is UrscriptName
    }
    free = [part for part in parts if all(default is not None for _, default in part.parameters)]
    return next((part for part in free if part.name not in called), free[0] if free else parts[0])


def _calls_in(line: UrscriptLine) -> Iterator[Invocation]:
    from olp.languages.vendors.urscript.syntax import expressions, walk

    content = line.content
    if not isinstance(content, tuple) or type(content).__name__ in ("Mark", "Broken"):
        return
    for expression in expressions(content):  # type: ignore[arg-type]
        for node in walk(expression):
            if type(node) is Invocation:
                yield node


def _identifier(stem: str, taken: set[str]) -> str:
    """A name for the file's own instructions."""
    name = re.sub(r"\W+", "_", stem, flags=re.ASCII).strip("_") or "program"
    if name[0].isdigit():
        name = f"program_{name}"
    while name in taken:
        name += "_main"
    return name
