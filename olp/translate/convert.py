"""A program of one language as the files of another: the passes, the writer, one file per routine where it takes that.

Codes: X011 something that the target cannot say.
"""

from __future__ import annotations

import inspect
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import TYPE_CHECKING, Any

from olp.collecting import no_garbage_collection
from olp.diagnostic import Diagnostic, OlpError, Span, error, raise_errors
from olp.export import refuse_unwritable
from olp.program import Program, Routine
from olp.translate.canonical import Translated, canonical
from olp.translate.data_only import name_of
from olp.translate.left_out import LeftOut
from olp.translate.limits import limits_of
from olp.translate.split import split
from olp.translate.work import Context, Fate
from olp.vendors.vendor import language_of

if TYPE_CHECKING:
    from olp.assumptions import Assumptions
    from olp.plan import Plan
    from olp.robot import Robot

_ROUNDS = 20  # of commenting out what the writer refuses


@dataclass(frozen=True, slots=True)
class Converted:
    """`files`: name -> bytes; `main`: the one that runs. `translated`: the passes' losses and mapping."""

    files: dict[str, bytes]
    main: str
    translated: Translated
    problems: tuple[Diagnostic, ...] = field(default=())


def convert(
    program: Program,
    vendor: str,
    context: Context | None = None,
    *,
    encoding: str | None = None,
    date: str | None = None,
) -> Converted:
    """`program` as files of the language `vendor`.

    Raises OlpError with the program's own errors, with what the target cannot say (X002, X011, X014), and where the
    question needs a robot (X012). With `on_loss` "comment" statements that cannot be said become comments.
    """
    refuse_unwritable(vendor)
    context = context or Context()
    raise_errors([found.at(program.path) for found in program.diagnostics])
    # Statements are many, small and without cycles.
    with no_garbage_collection():
        return _converted(program, vendor, context, encoding, date)


def _converted(
    program: Program, vendor: str, context: Context, encoding: str | None, date: str | None
) -> Converted:
    left_out = LeftOut()
    for _ in range(_ROUNDS):
        translated = canonical(program, vendor, context, left_out)
        raise_errors(translated.problems)
        files, main, problems = _written(translated.program, vendor, encoding, date)
        lines = {found.line: _reason(found) for found in problems if found.line}
        if context.on_loss != "comment" or not left_out.add(lines):
            break
    told = refusals(program, vendor, translated)
    refused = {found.line for found in told}
    # What a pass refuses the writer cannot say either, and in less fitting words.
    told += [found for found in problems if not found.line or found.line not in refused]
    if told:
        raise OlpError(*dict.fromkeys(told))
    return Converted(files, main, translated)


def _reason(found: Diagnostic) -> str:
    """Why the writer cannot say something, as the receipt tells it: "a computed index (…)"."""
    says = found.message.partition(": ")[2] or found.message
    return f"{says} ({found.help})" if found.help else says


def refusals(program: Program, vendor: str, translated: Translated) -> list[Diagnostic]:
    """An error (X011) for every statement that the passes refuse."""
    found = []
    for loss in translated.losses:
        if loss.fate is Fate.REFUSED:
            text = program.source.line(loss.line)
            span = (
                Span(loss.line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
                if loss.line
                else None
            )
            message = f"{language_of(vendor)} cannot say this: {loss.says}"
            help = loss.help or "--on-loss comment writes it as a comment"
            found.append(error("X011", message, span, file=program.path, source_line=text, help=help))
    return found


def _written(
    program: Program, vendor: str, encoding: str | None, date: str | None
) -> tuple[dict[str, bytes], str, list[Diagnostic]]:
    """The files, which of them runs, and what the writer cannot say."""
    from olp.vendors.vendor import find_vendor

    limits = limits_of(vendor)
    suffix = find_vendor(vendor).suffixes[0]
    if vendor == "inform":
        suffix = suffix.upper()
    files: dict[str, bytes] = {}
    problems: list[Diagnostic] = []
    main = ""
    for part in split(program, limits):
        routine = _main_of(part)
        stem = routine.name if routine is not None else name_of(part)
        texts, found = _texts(part, vendor, date)
        problems += found
        for ending, text in texts.items():
            name = f"{stem}{ending or suffix}"
            if not found:
                files[name] = _encoded(text, part, vendor, encoding)
            main = main or name
    return files, main, problems


def _main_of(program: Program) -> Routine | None:
    return next(
        (r for r in program.routines if r.name == program.main),
        program.routines[0] if program.routines else None,
    )


def _texts(program: Program, vendor: str, date: str | None) -> tuple[dict[str, str], list[Diagnostic]]:
    """The text of the file ("") and of those beside it, by suffix."""
    from olp.export import now, rendered

    writer: Any = import_module(f"olp.vendors.{vendor}.writer")
    pair = {"pair": True} if "pair" in inspect.signature(writer.write).parameters else {}
    values, problems = writer.write(program, date or now(), **pair)
    companions: dict[str, str] = values.pop("companions", {})
    if problems:
        return {"": ""}, list(problems)
    text = rendered(values, vendor, program)
    return ({"": text, **companions} if text else companions), []  # of data alone there is nothing that runs


def _encoded(text: str, program: Program, vendor: str, encoding: str | None) -> bytes:
    from olp.export import encoded, encoding_of

    return encoded(text, program, vendor, encoding or encoding_of(program, vendor))


def run_converted(
    converted: Converted, vendor: str, robot: Robot | None, source: Program | None = None
) -> Plan:
    """The plan of the files, read again and run beside each other.

    `source`: what stands around that program (its olp.toml, its controller's tools and frames) stands around them.
    """
    import tempfile
    from pathlib import Path

    from olp.interpreter import run
    from olp.reading import read

    surroundings = None if source is None else _surroundings(source, converted, robot)
    with tempfile.TemporaryDirectory() as folder:
        for name, data in converted.files.items():
            Path(folder, name).write_bytes(data)
        program = read(Path(folder, converted.main), vendor=vendor)
        raise_errors(program.diagnostics)
        return run(program, robot=robot, folder=folder, assumptions=surroundings, max_steps=200_000)


def _surroundings(source: Program, converted: Converted, robot: Robot | None) -> Assumptions:
    """olp.toml beside the source, with its tools and frames under the numbers that they have in the target."""
    from pathlib import Path

    from olp.assumptions import (
        NAMED_SIGNAL,
        Assumptions,
        SignalKey,
        WrittenPosition,
        load_assumptions,
        nearest_assumptions,
    )
    from olp.interpreter.memory import ACTIVE
    from olp.points import PointKind, PointState
    from olp.translate.work import cell_of

    folder = Path(source.path).parent if source.path and Path(source.path).is_file() else None
    path = nearest_assumptions(folder) if folder is not None else None
    given = load_assumptions(path) if path is not None else Assumptions()
    cell = cell_of(source, robot)
    mapping = converted.translated.mapping

    def number(kind: str, n: int) -> int:
        new = mapping.get((kind, str(n)), "")
        return int(new) if new.isdecimal() else n

    tools = {number("tool", n): tuple(map(float, t.pose.xyz_angles())) for n, t in cell.tools.items()}
    frames = {number("frame", n): tuple(map(float, p.xyz_angles())) for n, p in cell.user_frames.items()}
    names = dict(given.names)
    for (kind, name), literal in converted.translated.held.items():
        if name.isdecimal():
            (tools if kind == "tool" else frames)[int(name)] = literal.values[:6]
        else:
            names[name.casefold()] = WrittenPosition(PointState(PointKind.POSE, ACTIVE), literal.values[:6])

    def key(old: SignalKey) -> SignalKey:
        new = mapping.get(("signal", f"{old.bus} {old.number}"), "")
        return (
            old if not new or new.isdecimal() else SignalKey(NAMED_SIGNAL, new.rpartition(" ")[2].casefold())
        )

    inputs = {key(signal): values for signal, values in given.inputs.items()}
    waits = {key(signal): seconds for signal, seconds in given.waits.items()}
    return replace(given, tools=tools, frames=frames, names=names, inputs=inputs, waits=waits)
