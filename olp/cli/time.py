"""`olp time`: how long every line takes, and why."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from olp.cli._timing import (
    add_routine_argument,
    add_timing_arguments,
    encode,
    positive_int,
    print_diagnostics,
    timing_job_of,
    with_progress,
)
from olp.cli.command import refuse_other_forms
from olp.core.diagnostic import OlpError, error
from olp.core.files import write_output
from olp.core.terminal import wanted

if TYPE_CHECKING:
    from olp.reports.batch import Job
    from olp.reports.formats.report import ReportPart


SUMMARY = "say how long every line of a program takes, and why"


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli._watching import add_watch
    from olp.reports.formats.report import report_names

    parser.add_argument("jobs", nargs="+", metavar="JOB", help="a program, or a folder of programs")
    parser.add_argument(
        "--format",
        metavar="F",
        help=f"one of {', '.join(report_names())} (default: what the suffix of -o says, else text)",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="write there (default: standard output): .txt, .csv, .json, .md or .xlsx",
    )
    add_timing_arguments(parser)
    add_routine_argument(parser)
    parser.add_argument(
        "--segments", action="store_true", help="every line even when there are several programs"
    )
    parser.add_argument("--summary", action="store_true", help="only the totals")
    parser.add_argument(
        "--top",
        type=positive_int,
        metavar="N",
        help="the N lines that cost most, with what would help (default: 10 for several programs)",
    )
    parser.add_argument("--by", choices=("cause", "job", "line"), help="only the totals by this")
    parser.add_argument(
        "--sort", choices=("time", "file"), help="order of several programs (default: below their callers)"
    )
    parser.add_argument(
        "--explain",
        metavar="LINE",
        help="the phases of one line and what limits each (JOB:LINE in another job); a picture with -o FILE.svg|.png",
    )
    add_watch(parser, "jobs")
    parser.add_argument(
        "--workers", type=positive_int, default=0, metavar="N", help="processes (default: one per core)"
    )


def run(args: Namespace) -> int:
    if args.explain is not None:
        return run_explain(args)
    from olp.languages.vendor import program_files
    from olp.reports.batch import shown, time_files
    from olp.reports.formats.report import WORKBOOK, format_of, load_report

    if args.summary and args.by in ("cause", "line"):
        raise OlpError(error("C002", "--summary and --by exclude each other", help="leave out --summary"))
    output: str | None = args.output
    workbook = output is not None and output.lower().endswith(WORKBOOK)
    said = None if output is None else format_of(output)
    if (
        args.format is not None
        and output is not None
        and said is not None
        and (workbook or said != args.format)
    ):
        load_report(args.format)
        says = f"a file ending in .{output.rpartition('.')[2]} is {'a workbook' if workbook else said}"
        says += f", and --format says {args.format}"
        raise OlpError(error("C002", says, file=output, help="leave out --format, or name another file"))
    if said is None and not workbook:
        refuse_other_forms(args.output, (".csv", ".json", ".md", WORKBOOK), args.format)
    args.format = args.format or said or "text"
    report = load_report(args.format)
    paths = [str(path) for path in program_files(args.jobs)]
    job = job_of(args, len(paths))
    parts = with_progress(paths, lambda done: time_files(paths, job, args.workers, done))
    parts, left_out = _with_start(parts, args.jobs)
    if workbook:
        from olp.reports.workbook import workbook_of

        data = workbook_of(report.join(parts, job.options), parts)
    else:
        data = encode(report.join(parts, job.options), args.output)
    write_output(args.output, data, inputs=paths)
    print_diagnostics(shown(parts))
    if left_out:
        which = "hold data alone" if args.routine is None else f"have no routine {args.routine}"
        says = f"left out: {left_out} of the folder's files, which {which}"
        print(f"olp: {says}", file=sys.stderr)
    return 2 if any(part.failed for part in parts) else 0


def _with_start(parts: list[ReportPart], given: Sequence[str]) -> tuple[list[ReportPart], int]:
    """Without the files of a folder that lack a routine to start, where others have one; and how many those are."""
    asked = {str(Path(path)) for path in given}
    kept = [part for part in parts if not part.lacks_start or part.file in asked]
    return (kept, len(parts) - len(kept)) if kept else (parts, 0)


def job_of(args: Namespace, count: int) -> Job:
    """The settings of one run over `count` files. Raises OlpError for a robot, model or olp.toml that is none."""
    from dataclasses import fields

    from olp.reports.batch import Job
    from olp.reports.formats.report import Options

    report = getattr(args, "format", None) or "text"
    summary = getattr(args, "summary", False)
    segments = not summary and (count == 1 or args.segments or report != "text")
    top, by = getattr(args, "top", None), getattr(args, "by", None) or ""
    cell = report == "text" and count > 1 and not summary
    wide = terminal(args) if report == "text" else (0, False)
    job = timing_job_of(args)
    return Job(
        **{field.name: getattr(job, field.name) for field in fields(job)},
        format=report,
        options=Options(
            segments,
            *wide,
            interval=args.signature is not None,
            top=top or (10 if cell or by else 0),
            by=by,
            sort=getattr(args, "sort", None) or "",
        ),
    )


def terminal(args: Namespace) -> tuple[int, bool]:
    """Characters per line of the terminal (0: no limit, the output goes elsewhere), and whether it shows colour."""
    import shutil
    import sys

    if args.output or not sys.stdout.isatty():
        return 0, False
    return shutil.get_terminal_size().columns, wanted(sys.stdout)


# --- Explain ---
# `olp time JOB --explain LINE`: one line in words, and as a picture with -o.


def run_explain(args: Namespace) -> int:
    """The words go to standard output, the picture to `-o`. Raises OlpError for several programs, and E001 to E005."""
    from olp.identification.timing_job import plan_and_time
    from olp.reports.explain import as_text, explain

    if len(args.jobs) != 1:
        raise OlpError(error("C002", "--explain takes one program", help="olp time JOB --explain LINE"))
    if args.output is not None:
        from olp.reports.plot.output import refuse_unknown

        refuse_unknown(args.output)
    timing = plan_and_time(args.jobs[0], timing_job_of(args))
    told = explain(timing, args.explain)
    if args.output is not None:
        from olp.reports.plot.motion import motion_figure
        from olp.reports.plot.output import picture

        write_output(args.output, picture(motion_figure(told), args.output), inputs=args.jobs)
    sys.stdout.flush()
    sys.stdout.buffer.write(encode(as_text(told), None))
    print_diagnostics([d.at(args.jobs[0]) for d in timing.diagnostics if d.line == told.line])
    return 0
