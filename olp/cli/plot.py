"""`olp plot`: the path of a program and its speed, as a picture."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from olp.cli._timing import add_routine_argument, add_timing_arguments, print_diagnostics, timing_job_of
from olp.core.files import write_output

SUMMARY = "draw the path of a program and its speed over time"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("job", metavar="JOB", help="a program")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="FILE.svg or FILE.png")
    add_timing_arguments(parser)
    add_routine_argument(parser)


def run(args: Namespace) -> int:
    from olp.identification.timing_job import plan_and_time
    from olp.reports.plot.output import picture, refuse_unknown
    from olp.reports.plot.program import program_figure

    refuse_unknown(args.output)
    timing = plan_and_time(args.job, timing_job_of(args))
    write_output(args.output, picture(program_figure(timing), args.output), inputs=[args.job])
    print_diagnostics([d.at(args.job) for d in timing.diagnostics])
    return 0
