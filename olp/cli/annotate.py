"""`olp annotate`: predicted times as comments in the program, and out of it again."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from olp.cli._outputs import add_output_arguments, convert
from olp.cli._timing import add_routine_argument, add_timing_arguments, print_diagnostics, timing_job_of

if TYPE_CHECKING:
    from olp.core.diagnostic import Diagnostic
    from olp.identification.timing_job import TimingJob

SUMMARY = "write the predicted time of each line into a program, as comments"


def add_arguments(parser: ArgumentParser) -> None:
    add_output_arguments(parser, "annotated")
    parser.add_argument("--remove", action="store_true", help="take the annotations out again")
    parser.add_argument(
        "--template", metavar="FILE", help="a jinja2 file for the comments (default: the one of the language)"
    )
    add_timing_arguments(parser)
    add_routine_argument(parser)


def run(args: Namespace) -> int:
    job = timing_job_of(args)
    told = convert(args, lambda path: _remove(path, args) if args.remove else _annotate(path, job, args))
    print_diagnostics(told)
    return 2 if any(diagnostic.is_error for diagnostic in told) else 0


def _remove(path: Path, args: Namespace) -> tuple[bytes, Sequence[Diagnostic]]:
    from olp.languages.vendor import read
    from olp.reports.annotate import remove

    program = read(path, encoding=args.encoding)
    plain = remove(program.source, program.vendor)
    return plain.source.raw, plain.diagnostics


def _annotate(path: Path, job: TimingJob, args: Namespace) -> tuple[bytes, Sequence[Diagnostic]]:
    from olp.identification.timing_job import time_program
    from olp.languages.vendor import read
    from olp.reports.annotate import annotate
    from olp.timing.result import assumed

    program = read(path, encoding=job.encoding)
    timing = time_program(program, job)
    result = annotate(program, timing, args.template)
    told = [*timing.diagnostics, *result.diagnostics, *assumed(timing)]
    return result.source.raw, told
