"""`olp check`: are the cycle-time budgets held?"""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from olp.cli._outputs import add_format_arguments, outcome_outputs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from olp.checks.guard.run import JudgedFile
    from olp.core.diagnostic import Diagnostic
    from olp.reports.outcome.model import Outcome

SUMMARY = "hold programs against their cycle-time budgets"
_CACHE = ".olp-cache"


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli._timing import add_timing_arguments, positive_int
    from olp.cli._watching import add_watch

    parser.add_argument(
        "paths", nargs="*", default=["."], metavar="PATH", help="programs, or folders (default: .)"
    )
    add_format_arguments(parser)
    parser.add_argument(
        "--budgets",
        metavar="FILE",
        help="the olp.toml whose budgets hold (default: the nearest of each program)",
    )
    add_timing_arguments(parser)
    parser.add_argument("--store", metavar="FILE", help="keep the run in this SQLite file, for olp trend")
    parser.add_argument(
        "--cache", metavar="FILE", default=_CACHE, help=f"results of unchanged programs (default: {_CACHE})"
    )
    parser.add_argument("--no-cache", action="store_true", help="time everything anew")
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", default="", help="of a Dask cluster that does the work"
    )
    add_watch(parser, "paths")
    parser.add_argument(
        "--workers", type=positive_int, default=0, metavar="N", help="processes (default: one per core)"
    )


def run(args: Namespace) -> int:
    from olp.checks.guard import store
    from olp.checks.guard.run import GuardSettings, tasks
    from olp.checks.guard.run import run as judge_all
    from olp.cli._timing import timing_job_of, with_progress
    from olp.languages.vendor import program_files

    told = outcome_outputs(args)
    paths = [str(path) for path in program_files(args.paths)]
    job = timing_job_of(args)
    work = tasks(paths, args.budgets)
    if args.store:
        store.check(Path(args.store))
    cache = None if args.no_cache or args.scheduler else Path(args.cache)
    settings = GuardSettings(job, args.workers, cache, args.scheduler)
    results = with_progress(paths, lambda done: judge_all(work.tasks, settings, done))
    outcome = outcome_of(
        _asked_for(results, args.paths), [*work.diagnostics, *work.idle(results, args.paths)]
    )
    told.write(outcome, paths)
    if args.store:
        store.keep(Path(args.store), results, Path.cwd())
    return outcome.exit_status


def _asked_for(results: Sequence[JudgedFile], paths: Sequence[str]) -> list[JudgedFile]:
    """The same; a program that was asked for by its name and cannot be read is one that cannot be judged."""
    from olp.reports.outcome.model import JudgedItem, Status

    def item(result: JudgedFile) -> JudgedItem:
        why = result.findings[0].message if result.findings else "cannot be read"
        return JudgedItem("program", result.path, Status.UNKNOWN, why, group="budget")

    named = {str(Path(path)) for path in paths}
    return [
        replace(r, items=(item(r),)) if r.unread and not r.items and r.path in named else r for r in results
    ]


def outcome_of(results: Sequence[JudgedFile], problems: Sequence[Diagnostic] = ()) -> Outcome:
    """What all files together amount to: the worst first."""
    from olp.reports.outcome.model import JudgedItem, Level, Outcome, Status, of_diagnostic

    problems = [replace(d, file=_shown(d.file)) for d in problems]

    order = (Status.UNKNOWN, Status.FAILED, Status.WARNED, Status.HELD)
    items = [item for result in results for item in result.items]
    items += [
        JudgedItem("budgets", d.file, Status.UNKNOWN, d.message, d.line, group="budget")
        for d in problems
        if d.is_error
    ]
    if not items:
        help = "write [[budget]] tables with limit_s into olp.toml beside the programs"
        items.append(
            JudgedItem(
                "budgets",
                "",
                Status.UNKNOWN,
                f"no budget holds for any of these programs: {help}",
                group="budget",
            )
        )
    items.sort(key=lambda item: (order.index(item.status), -_over(item), item.file))
    # What is wrong with a file matters where a budget of it could not be judged; else it is olp time's to tell.
    judged = {item.file for item in items if item.status is not Status.HELD}
    findings = [of_diagnostic(d) for d in problems]
    for result in sorted(results, key=lambda r: -max((_over(i) for i in r.items), default=0.0)):
        if result.path in judged:
            unjudged = _unjudged(result)
            findings += [
                f
                for f in result.findings
                if f.code.startswith("M") or (unjudged and f.level is not Level.NOTE)
            ]
    return Outcome(
        "check", tuple(findings), tuple(items), (_sentence(results, items),), {"programs": _programs(results)}
    )


def _shown(file: str) -> str:
    """Seen from the current folder, as programs are, where it is below it."""
    try:
        return str(Path(file).relative_to(Path.cwd()))
    except ValueError:
        return file


def _unjudged(result: JudgedFile) -> bool:
    from olp.reports.outcome.model import Status

    return any(item.status is Status.UNKNOWN for item in result.items)


def _over(item: object) -> float:
    seconds, limit = getattr(item, "seconds", None), getattr(item, "limit_s", None)
    return 0.0 if seconds is None or limit is None else float(seconds - limit)


def _sentence(results: Sequence[JudgedFile], items: Sequence[object]) -> str:
    from collections import Counter

    counts = Counter(str(getattr(item, "status", "")) for item in items)
    told = ", ".join(
        f"{counts[word]} {word}" for word in ("unknown", "failed", "warned", "held") if counts[word]
    )
    free = sum(not result.items for result in results)
    without = f"; {free} program{'' if free == 1 else 's'} without a budget" if free else ""
    unread = sum(result.unread and not result.items for result in results)
    without += f", of which {unread} cannot be read" if unread else ""
    return f"{len(results)} program{'' if len(results) == 1 else 's'}: {told}{without}"


def _programs(results: Sequence[JudgedFile]) -> list[dict[str, object]]:
    return [
        {
            "file": r.path,
            "total_s": r.total_s,
            "motion_s": r.motion_s,
            "wait_s": r.wait_s,
            "io_s": r.io_s,
            "high_s": r.high_s,
        }
        for r in results
    ]
