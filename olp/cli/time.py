"""`olp time`: how long every line takes, and why."""

from __future__ import annotations

import re
import sys
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from typing import TYPE_CHECKING, TypeVar

from olp.cli.command import refuse_other_forms
from olp.core.diagnostic import OlpError, Severity, error
from olp.core.files import expand_paths, write_output
from olp.core.terminal import RED, YELLOW, paint, shown, utf8, wanted

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from olp.core.diagnostic import Diagnostic
    from olp.identification.timing_job import TimingJob
    from olp.reports.batch import Job


Result = TypeVar("Result")
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


def add_timing_arguments(parser: ArgumentParser) -> None:
    """What every command takes that has to time a program."""
    parser.add_argument("--robot", metavar="R", help="the robot: a name of `olp robots`, or a robot file")
    parser.add_argument(
        "--model", metavar="M", help="the motion model: constant or linear (default: constant)"
    )
    parser.add_argument(
        "--accel",
        type=positive,
        metavar="A",
        help="acceleration of linear moves in mm/s² (default: the robot's)",
    )
    parser.add_argument(
        "--accel-law",
        metavar="L",
        help="what an axis can do: constant, time_constant, by_pose or torque (default: constant)",
    )
    parser.add_argument(
        "--override",
        type=positive,
        metavar="PCT",
        help="speed override in percent, a factor on V= and VJ= (default: 100)",
    )
    parser.add_argument(
        "--signature",
        metavar="FILE",
        help="the robot's timing signature, made by olp calibrate or olp diagnose",
    )
    parser.add_argument("--assumptions", metavar="FILE", help="an olp.toml (default: the nearest one)")
    parser.add_argument("--encoding", metavar="E", help="of the program text (default: guessed)")
    parser.add_argument(
        "--max-steps",
        type=positive_int,
        metavar="N",
        help="stop after this many statements (default: 200000 per cycle, and ten times those that are read)",
    )
    parser.add_argument(
        "--cycles", type=positive_int, default=1, metavar="N", help="rounds of an endless main loop"
    )


def positive(text: str) -> float:
    """A number above zero."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise ArgumentTypeError(f"{text!r} is not a number above zero")
    return value


def positive_int(text: str) -> int:
    """A whole number above zero."""
    if not text.isdecimal() or int(text) < 1:
        raise ArgumentTypeError(f"{text!r} is not a whole number above zero")
    return int(text)


def run(args: Namespace) -> int:
    if args.explain is not None:
        return run_explain(args)
    from olp.languages.vendor import vendor_suffixes
    from olp.reports.batch import shown, time_files
    from olp.reports.formats.report import WORKBOOK, format_of, load_report

    if args.summary and args.by in ("cause", "line"):
        raise OlpError(error("C002", "--summary and --by exclude each other", help="leave out --summary"))
    workbook = args.output is not None and args.output.lower().endswith(WORKBOOK)
    said = None if args.output is None else format_of(args.output)
    if args.format is not None and said is not None and (workbook or said != args.format):
        load_report(args.format)
        says = f"a file ending in .{args.output.rpartition('.')[2]} is {'a workbook' if workbook else said}"
        says += f", and --format says {args.format}"
        raise OlpError(error("C002", says, file=args.output, help="leave out --format, or name another file"))
    if said is None and not workbook:
        refuse_other_forms(args.output, (".csv", ".json", ".md", WORKBOOK), args.format)
    args.format = args.format or said or "text"
    report = load_report(args.format)
    paths = [str(path) for path in expand_paths(args.jobs, vendor_suffixes())]
    job = job_of(args, len(paths))
    parts = with_progress(paths, lambda done: time_files(paths, job, args.workers, done))
    if workbook:
        from olp.reports.workbook import workbook_of

        data = workbook_of(report.join(parts, job.options), parts)
    else:
        data = encode(report.join(parts, job.options), args.output)
    write_output(args.output, data, inputs=paths)
    print_diagnostics(shown(parts))
    return 2 if any(part.failed for part in parts) else 0


def job_of(args: Namespace, count: int) -> Job:
    """The settings of one run over `count` files. Raises OlpError for a robot, model or olp.toml that is none."""
    from dataclasses import replace

    from olp.reports.formats.report import Options

    report = getattr(args, "format", None) or "text"
    summary = getattr(args, "summary", False)
    segments = not summary and (count == 1 or args.segments or report != "text")
    top, by = getattr(args, "top", None), getattr(args, "by", None) or ""
    cell = report == "text" and count > 1 and not summary
    wide = terminal(args) if report == "text" else (0, False)
    return replace(
        settings_of(args),
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


def settings_of(args: Namespace) -> Job:
    """What `add_timing_arguments` took. Raises OlpError for a robot, model or olp.toml that is none."""
    from dataclasses import fields

    from olp.reports.batch import Job

    job = timing_job_of(args)
    return Job(**{field.name: getattr(job, field.name) for field in fields(job)})


def timing_job_of(args: Namespace) -> TimingJob:
    """The same for commands that write no report: those need not be loaded."""
    from olp.identification.timing_job import TimingJob, check_job

    job = TimingJob(
        robot=args.robot,
        model=args.model,
        acceleration=None if args.accel is None else args.accel * 1e-3,
        encoding=args.encoding,
        assumptions=args.assumptions,
        max_steps=args.max_steps,
        override=None if args.override is None else args.override * 1e-2,
        cycles=args.cycles,
        acceleration_law=args.accel_law,
        signature=args.signature,
    )
    check_job(job)
    return job


def terminal(args: Namespace) -> tuple[int, bool]:
    """Characters per line of the terminal (0: no limit, the output goes elsewhere), and whether it shows colour."""
    import shutil
    import sys

    if args.output or not sys.stdout.isatty():
        return 0, False
    return shutil.get_terminal_size().columns, wanted(sys.stdout)


def with_progress(
    paths: Sequence[str], work: Callable[[Callable[[int], None] | None], list[Result]]
) -> list[Result]:
    """Does the work, with a progress bar when it is long and somebody is watching. `work` is done in order of `paths`.

    A file counts as much as it has bytes: one long program takes the time of many short ones.
    """
    import os
    import sys
    from itertools import islice

    if len(paths) < 20 or not sys.stderr.isatty():
        return work(None)
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as progress:
        sizes = [os.path.getsize(path) if os.path.isfile(path) else 0 for path in paths]
        task, left = progress.add_task("working", total=sum(sizes)), iter(sizes)
        return work(lambda n: progress.update(task, advance=sum(islice(left, n))))


def encode(text: str, output: str | None) -> bytes:
    """Reports are UTF-8, but a terminal gets what it can show."""
    return shown(text) if output is None else utf8(text)


_MORE = re.compile(r" \(and (once more|in \d+ more lines)\)$")
_WHOLE = 3  # errors of one sentence in one file that are shown with their lines


def print_diagnostics(diagnostics: Sequence[Diagnostic]) -> None:
    """To the error stream: what is wrong whole, the same sentence once; notes of one kind as one line."""
    import sys

    if not diagnostics:
        return
    colour = wanted(sys.stderr)
    groups: dict[tuple[Severity, str, str], list[Diagnostic]] = {}
    for d in diagnostics:
        if d.severity is not Severity.INFO:
            groups.setdefault((d.severity, d.code, _MORE.sub("", d.message)), []).append(d)
    blocks = [block for group in groups.values() for block in _blocks(group, colour)]
    notes = _notes(diagnostics)
    print("\n\n".join([*blocks, "\n".join(notes)] if notes else blocks), file=sys.stderr)


def _blocks(group: Sequence[Diagnostic], colour: bool) -> list[str]:
    """What one sentence is said of: the first place whole (of errors those of its file), the others counted."""
    whole = [d for d in group if d.file == group[0].file][: _WHOLE if group[0].is_error else 1]
    blocks = [_shown(d, colour) for d in whole]
    others = [d for d in group if d not in whole]
    if others:
        places = list(dict.fromkeys(f"{d.file}:{d.line}" if d.line else d.file for d in others))
        more = f" and {len(places) - _WHOLE} more places" if len(places) > _WHOLE else ""
        blocks[-1] += f"\nthe same in {', '.join(places[:_WHOLE])}{more}"
    return blocks


def _notes(diagnostics: Sequence[Diagnostic]) -> list[str]:
    """One line per sentence, with its first place and how often it was said."""
    groups: dict[tuple[str, str], list[Diagnostic]] = {}
    for diagnostic in diagnostics:
        if diagnostic.severity is Severity.INFO:
            groups.setdefault((diagnostic.code, _MORE.sub("", diagnostic.message)), []).append(diagnostic)
    lines = []
    for (code, message), group in groups.items():
        place = f"{group[0].file}:{group[0].line}" if group[0].line else group[0].file
        often = f", {len(group)} times" if len(group) > 1 else ""
        lines.append(f"info[{code}]: {message} ({place}{often})")
    return lines


def _shown(diagnostic: Diagnostic, colour: bool) -> str:
    head, *rest = diagnostic.render().split("\n")
    if colour:
        head = paint(head, RED if diagnostic.is_error else YELLOW)
    return "\n".join([head, *rest])


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
    timing = plan_and_time(args.jobs[0], job_of(args, 1))
    told = explain(timing, args.explain)
    if args.output is not None:
        from olp.reports.plot.motion import motion_figure
        from olp.reports.plot.output import picture

        write_output(args.output, picture(motion_figure(told), args.output), inputs=args.jobs)
    sys.stdout.flush()
    sys.stdout.buffer.write(encode(as_text(told), None))
    print_diagnostics([d.at(args.jobs[0]) for d in timing.diagnostics if d.line == told.line])
    return 0
