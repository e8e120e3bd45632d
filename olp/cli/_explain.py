"""`olp time JOB --explain LINE`: one line in words, and as a picture with -o."""

from __future__ import annotations

import sys
from argparse import Namespace

from olp.core.diagnostic import OlpError, error
from olp.core.files import write_output


def run_explain(args: Namespace) -> int:
    """The words go to standard output, the picture to `-o`. Raises OlpError for several programs, and E001 to E005."""
    from olp.cli.time import encode, job_of, print_diagnostics
    from olp.reports.batch import plan_and_time
    from olp.reports.explain import explain
    from olp.reports.explanation import as_text

    if len(args.jobs) != 1:
        raise OlpError(error("C002", "--explain takes one program", help="olp time JOB --explain LINE"))
    if args.output is not None:
        from olp.reports.plot import refuse_unknown

        refuse_unknown(args.output)
    timing = plan_and_time(args.jobs[0], job_of(args, 1))
    told = explain(timing, args.explain)
    if args.output is not None:
        from olp.reports.plot import picture
        from olp.reports.plot.motion import motion_figure

        write_output(args.output, picture(motion_figure(told), args.output), inputs=args.jobs)
    sys.stdout.flush()
    sys.stdout.buffer.write(encode(as_text(told), None))
    print_diagnostics([d.at(args.jobs[0]) for d in timing.diagnostics if d.line == told.line])
    return 0
