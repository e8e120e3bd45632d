"""`olp fit`: the fewest edits with which a program takes no longer than it may."""

from __future__ import annotations

import json
import os
import sys
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from olp.core.diagnostic import OlpError, error
from olp.core.files import refuse_inputs, write_output

if TYPE_CHECKING:
    from olp.checks.fit.fit import Fit

SUMMARY = "change as little as possible so that a program takes no longer than S"


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli._timing import add_timing_arguments, positive

    parser.add_argument("job", metavar="JOB", help="the program")
    parser.add_argument(
        "--to", type=positive, required=True, metavar="S", help="the time in seconds that it may take"
    )
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="OUT",
        help="where to write the edited program; a folder (FOLDER/): programs that it calls are edited there as well",
    )
    parser.add_argument(
        "--within",
        type=_millimetres,
        metavar="MM",
        help="let corners pass their points by so much (default: not at all)",
    )
    parser.add_argument(
        "--max-speed",
        type=positive,
        metavar="V",
        help="of the tool in mm/s (default: the highest that a move of the program has)",
    )
    parser.add_argument(
        "--max-acceleration",
        type=positive,
        metavar="A",
        help="of straight moves in mm/s² (default: the highest that is written)",
    )
    parser.add_argument(
        "--free",
        type=_lines,
        default=frozenset(),
        metavar="LINES",
        help="straight moves that may become joint moves: 12,20-31",
    )
    parser.add_argument(
        "--order",
        type=_groups,
        default=(),
        metavar="GROUPS",
        help="adjacent groups of lines whose order is free: 12-15,16-19,20-23",
    )
    parser.add_argument(
        "--unseen", action="store_true", help="go beyond the speeds that the signature has seen"
    )
    parser.add_argument(
        "--keep", type=_lines, default=frozenset(), metavar="LINES", help="lines that stay: 12,20-31"
    )
    parser.add_argument(
        "--front", metavar="FILE", help="what more and fewer edits can do, as .json, .svg or .png"
    )
    parser.add_argument("--json", action="store_true", help="print the edits as JSON")
    add_timing_arguments(parser)


def _millimetres(text: str) -> float:
    from olp.cli._timing import positive

    return positive(text.strip().removesuffix("mm").rstrip())


def _groups(text: str) -> tuple[range, ...]:
    found = [sorted(_lines(part)) for part in text.split(",")]
    return tuple(range(lines[0], lines[-1] + 1) for lines in sorted(found))


def _lines(text: str) -> frozenset[int]:
    found: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise ArgumentTypeError(f"{part!r} is not a line or range of lines: 12,20-31")
        if int(last or first) < int(first):
            raise ArgumentTypeError(f"{part!r} ends before it begins")
        found.update(range(int(first), int(last or first) + 1))
    return frozenset(found)


def run(args: Namespace) -> int:
    from olp.checks.fit.choices import Allowed
    from olp.checks.fit.fit import fit
    from olp.checks.fit.report import as_json, as_text, front_file, refuse_front
    from olp.cli._timing import timing_job_of
    from olp.core.units import mm
    from olp.identification.timing_job import time_program
    from olp.languages.vendor import read

    job = timing_job_of(args)
    into = args.output.endswith(("/", os.sep)) or Path(args.output).is_dir()
    if args.output != "-":
        refuse_inputs(str(Path(args.output) / Path(args.job).name) if into else args.output, [args.job])
    if args.front is not None:
        refuse_front(args.front)
    program = read(args.job, encoding=args.encoding)
    folder = Path(args.job).parent
    count = len(program.source.lines)
    for option, lines in (("keep", args.keep), ("free", args.free)):
        if gone := [line for line in lines if line > count and line - 1 not in lines]:
            says = f"--{option} names line {min(gone)}, the program has {count}"
            raise OlpError(error("C002", says, file=args.job, help="lines count from 1"))
    allowed = Allowed(
        (args.within or 0.0) * mm,
        _metres(args.max_speed),
        args.keep,
        _metres(args.max_acceleration),
        args.free,
        into,
        args.unseen,
        args.order,
    )
    found = fit(program, args.to, lambda one: time_program(one, job, folder), allowed)
    told = as_json(found) if args.json else as_text(found)
    return _told(args, found, told, front_file(found, args.front), into)


def _metres(value: float | None) -> float | None:
    """From mm/s or mm/s² to SI."""
    return None if value is None else value * 1e-3


def _told(args: Namespace, found: Fit, told: object, front: bytes | None, into: bool) -> int:
    inputs = [args.job, *(one.path for one in found.others)]
    if found.reached and into:
        Path(args.output).mkdir(parents=True, exist_ok=True)
        for one in (found.program.source, *found.others):
            write_output(str(Path(args.output) / Path(one.path).name), one.raw, inputs=inputs)
    elif found.reached:
        write_output(args.output, found.program.source.raw, inputs=inputs)
    if front is not None:
        write_output(args.front, front, inputs=[args.job])
    text = told if isinstance(told, str) else json.dumps(told, indent=2, ensure_ascii=False)
    print(text, file=sys.stderr if args.output == "-" else sys.stdout)
    return 0 if found.reached else 1
