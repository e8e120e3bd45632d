"""`olp fit`: the fewest edits with which a program takes no longer than it may."""

from __future__ import annotations

import json
import sys
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from typing import TYPE_CHECKING

from olp.core.files import refuse_inputs, write_output

if TYPE_CHECKING:
    from olp.checks.fit.fit import Fit

SUMMARY = "change as little as possible so that a program takes no longer than S"


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli.time import add_timing_arguments, positive

    parser.add_argument("job", metavar="JOB", help="the program")
    parser.add_argument(
        "--to", type=positive, required=True, metavar="S", help="the time in seconds that it may take"
    )
    parser.add_argument(
        "-o", "--output", required=True, metavar="OUT", help="where to write the edited program"
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
        "--keep", type=_lines, default=frozenset(), metavar="LINES", help="lines that stay: 12,20-31"
    )
    parser.add_argument(
        "--front", metavar="FILE", help="what more and fewer edits can do, as .json, .svg or .png"
    )
    parser.add_argument("--json", action="store_true", help="tell the edits as JSON")
    add_timing_arguments(parser)


def _millimetres(text: str) -> float:
    from olp.cli.time import positive

    return positive(text.strip().removesuffix("mm").rstrip())


def _lines(text: str) -> frozenset[int]:
    found: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise ArgumentTypeError(f"{part!r} is no line or range of lines: 12,20-31")
        found.update(range(int(first), int(last or first) + 1))
    return frozenset(found)


def run(args: Namespace) -> int:
    from pathlib import Path

    from olp.checks.fit.choices import Allowed
    from olp.checks.fit.fit import fit
    from olp.checks.fit.told import as_json, as_text, front_file, refuse_front
    from olp.cli.time import settings_of
    from olp.core.units import mm
    from olp.languages.read import read
    from olp.reports.batch import time_program

    job = settings_of(args)
    if args.output != "-":
        refuse_inputs(args.output, [args.job])
    if args.front is not None:
        refuse_front(args.front)
    program = read(args.job, encoding=args.encoding)
    folder = Path(args.job).parent
    allowed = Allowed(
        (args.within or 0.0) * mm, None if args.max_speed is None else args.max_speed * mm, args.keep
    )
    found = fit(program, args.to, lambda one: time_program(one, job, folder), allowed)
    return _told(args, found, as_json(found) if args.json else as_text(found), front_file(found, args.front))


def _told(args: Namespace, found: Fit, told: object, front: bytes | None) -> int:
    if found.reached:
        write_output(args.output, found.program.source.raw, inputs=[args.job])
    if front is not None:
        write_output(args.front, front, inputs=[args.job])
    text = told if isinstance(told, str) else json.dumps(told, indent=2, ensure_ascii=False)
    print(text, file=sys.stderr if args.output == "-" else sys.stdout)
    return 0 if found.reached else 1
