"""`olp report`: programs and their times as one HTML page that people look at."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from olp.core.files import read_input, write_output

if TYPE_CHECKING:
    from olp.checks.guard.budget import Budget
    from olp.identification.timing_job import TimingJob
    from olp.ir.program import Program
    from olp.reports.outcome.model import JudgedItem
    from olp.reports.page import PageEntry

SUMMARY = "write one HTML page: Gantt, speed, path in 3D, text with times"


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli._timing import add_timing_arguments

    parser.add_argument("paths", nargs="+", metavar="PATH", help="programs, or folders of programs")
    parser.add_argument(
        "-o", "--output", metavar="FILE", required=True, help="the page; its last version gives the trend"
    )
    parser.add_argument(
        "--title", default="", metavar="TEXT", help="title of the page (default: the program's name)"
    )
    parser.add_argument(
        "--budgets", metavar="FILE", help="the olp.toml whose budgets are shown (default: the nearest)"
    )
    add_timing_arguments(parser)


def run(args: Namespace) -> int:
    from olp.cli._timing import print_diagnostics, timing_job_of
    from olp.core.diagnostic import OlpError, error
    from olp.languages.vendor import program_files
    from olp.reports.batch import branch_times
    from olp.reports.cell import started
    from olp.reports.page import report_page

    paths = [str(path) for path in program_files(args.paths)]
    job = timing_job_of(args)
    entries = [_entry(path, job, args.budgets) for path in paths]
    first = set(started(entries))
    entries = [
        replace(entry, branches=branch_times(entry.path, job)) if index in first else entry
        for index, entry in enumerate(entries)
    ]
    if all(entry.timing is None for entry in entries):
        told = [d for entry in entries for d in entry.diagnostics if d.is_error]
        raise OlpError(*(told or [error("Y001", "none of these programs can be shown")]))
    page = report_page(entries, args.title, _last(Path(args.output)))
    write_output(args.output, page, inputs=paths)
    print_diagnostics([d for entry in entries for d in entry.diagnostics])
    return 2 if any(entry.is_unanswered for entry in entries) else 0


def _entry(path: str, job: TimingJob, budgets: str | None) -> PageEntry:
    from olp.checks.guard.run import judge, tasks
    from olp.core.diagnostic import OlpError
    from olp.identification.timing_job import time_program
    from olp.languages.vendor import read
    from olp.reports.cell import CellLinks, links_of, with_run
    from olp.reports.page import PageEntry

    links = CellLinks()
    try:
        program = read(path, encoding=job.encoding)
        links = links_of(program)
        timing = time_program(program, job)
        links = with_run(links, timing.plan)
    except OlpError as problem:
        return PageEntry(path, None, tuple(d.at(path) for d in problem.diagnostics), links=links)
    own = tasks([path], budgets)[0][0].budgets
    items = judge(path, own, job).items if own else ()
    totals = {budget.name: budget for budget in own if budget.of == "total" and not budget.routine}
    items = tuple(_with_offer(item, totals.get(item.name), program, job) for item in items)
    return PageEntry(path, timing, tuple(d.at(path) for d in timing.diagnostics), items, links)


def _with_offer(item: JudgedItem, budget: Budget | None, program: Program, job: TimingJob) -> JudgedItem:
    """A broken budget says which edits would hold it."""
    from olp.checks.fit.fit import offer
    from olp.identification.timing_job import time_program
    from olp.reports.outcome.model import Status

    if item.status is not Status.FAILED or budget is None:
        return item
    job = replace(job, signature=budget.signature or job.signature)
    found = offer(program, budget.limit_s, lambda one: time_program(one, job, Path(program.path).parent))
    if found is None:
        return replace(item, message=f"{item.message}; no edits of speeds and accelerations hold it")
    lines = ", ".join(f"line {one.choice.line} {one.choice.says}" for one in found.edits[:_EDITS])
    more = f" and {len(found.edits) - _EDITS} more" if len(found.edits) > _EDITS else ""
    return replace(item, message=f"{item.message}; make it {found.says} ({lines}{more}; olp fit writes them)")


_EDITS = 5  # that a page names


def _last(path: Path) -> str:
    """The page that is about to be replaced, "" where there is none."""
    try:
        return read_input(path).decode("utf-8")
    except (OSError, UnicodeDecodeError):
        return ""
