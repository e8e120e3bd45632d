"""`olp lint`: mistakes in the motion that cost time or safety."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from olp.cli._outputs import add_format_arguments, outcome_outputs
from olp.core.diagnostic import OlpError, error, visible
from olp.core.files import write_output

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from olp.checks.lint.fix import Fixed
    from olp.checks.lint.rule import Rule
    from olp.checks.lint.run import Linted, RuleChoice
    from olp.identification.timing_job import TimingJob
    from olp.reports.outcome.model import JudgedItem, Outcome, OutcomeFinding

SUMMARY = "find motion mistakes that cost time or safety"
_WORTH_WORKERS = 24


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli._timing import add_timing_arguments, positive_int
    from olp.cli._watching import add_watch

    parser.add_argument(
        "paths", nargs="*", default=["."], metavar="PATH", help="programs, or folders (default: .)"
    )
    add_format_arguments(parser)
    parser.add_argument(
        "--select", default="", metavar="CODES", help="only these rules: W001,W01 (default: all)"
    )
    parser.add_argument("--ignore", default="", metavar="CODES", help="not these rules")
    parser.add_argument("--baseline", metavar="FILE", help="findings that are known and excused")
    parser.add_argument(
        "--write-baseline", metavar="FILE", help="excuse everything found now, and write it there"
    )
    parser.add_argument(
        "--fail-on",
        default="warning",
        choices=("error", "warning", "note"),
        help="the least level that makes exit status 1 (default: warning)",
    )
    parser.add_argument(
        "--fix", action="store_true", help="change the programs where that alters neither path nor time"
    )
    parser.add_argument(
        "--unsafe-fixes",
        action="store_true",
        help="with --fix: change also what alters the motion or its time, as a rounded corner does",
    )
    parser.add_argument(
        "--load",
        action="store_true",
        help="report what a controller rejects when it loads the programs, and nothing else",
    )
    parser.add_argument(
        "--controller",
        default="",
        metavar="C",
        help="with --load: such as irc5-6.13 or krc4-8.5 (default: the usual)",
    )
    parser.add_argument("--rules", action="store_true", help="list the rules")
    parser.add_argument("--statistics", action="store_true", help="only how often each rule is broken")
    parser.add_argument(
        "--quiet",
        action="store_true",
        help="one line per finding, and nothing about what held or is told besides",
    )
    add_watch(parser, "paths")
    parser.add_argument(
        "--workers", type=positive_int, default=0, metavar="N", help="processes (default: one per core)"
    )
    add_timing_arguments(parser)


def run(args: Namespace) -> int:
    from olp.checks.lint.run import baseline_text, choice, read_baseline, without_known
    from olp.cli._timing import encode, timing_job_of, with_progress
    from olp.identification.timing_job import check_assumptions
    from olp.languages.vendor import program_files

    if args.rules:
        write_output(args.output, encode(_rules(), args.output), inputs=[])
        return 0
    if args.unsafe_fixes and not args.fix:
        raise OlpError(error("C002", "--unsafe-fixes goes with --fix", help="olp lint --fix --unsafe-fixes"))
    if (args.statistics or args.quiet) and (
        args.format not in (None, "text") or args.statistics == args.quiet
    ):
        says = "--statistics and --quiet are text, and exclude each other"
        raise OlpError(error("C002", says, help="leave out --format, or the other one"))
    told, job = outcome_outputs(args), timing_job_of(args)
    check_assumptions(job)
    known = read_baseline(Path(args.baseline)) if args.baseline else {}
    paths = [str(path) for path in program_files(args.paths)]
    asked = choice(_codes(args.select), _codes(args.ignore))
    if args.controller and not args.load:
        raise OlpError(error("C002", "--controller goes with --load", help="olp lint --load --controller C"))
    work = partial(_lint_all, paths, job, args.controller if args.load else asked, args.workers)
    results = with_progress(paths, work)
    changes: list[Fixed] = []
    if args.fix:
        results = [_fixed(result, job, asked, args.unsafe_fixes, changes) for result in results]
    if args.write_baseline:
        text = baseline_text(f for r in results for f in r.findings)
        write_output(args.write_baseline, text, inputs=paths)
        return 0
    fresh = list(without_known((f for r in results for f in r.findings), known))
    outcome = outcome_of(results, fresh, args.fail_on)
    if args.fix:
        outcome = replace(outcome, summary=(*outcome.summary, _mended(changes)))
    if args.statistics or args.quiet:
        text = _statistics(fresh) if args.statistics else _quiet(fresh)
        write_output(args.output, encode(text, args.output), inputs=paths)
    else:
        told.write(outcome, paths)
    return outcome.exit_status


def _statistics(findings: Sequence[OutcomeFinding]) -> str:
    """Each rule that is broken: how often, in how many files, and what it means; the most frequent first."""
    groups: dict[tuple[str, str, str], list[OutcomeFinding]] = {}
    for found in findings:
        groups.setdefault((found.code, str(found.level), found.title or found.message), []).append(found)
    rows = [
        f"{len(group):6d}  in {len({f.file for f in group}):4d} files  {code}  {level:8s}{title}"
        for (code, level, title), group in sorted(groups.items(), key=lambda item: (-len(item[1]), item[0]))
    ]
    total = f"{len(findings):6d}  in {len({f.file for f in findings}):4d} files"
    return "".join(visible(row) + "\n" for row in [*rows, total])


def _quiet(findings: Sequence[OutcomeFinding]) -> str:
    return "".join(visible(f"{f.file}:{f.line}:{f.column}: {f.code} {f.message}") + "\n" for f in findings)


def _lint_all(
    paths: Sequence[str],
    job: TimingJob,
    asked: RuleChoice | str,
    workers: int,
    done: Callable[[int], None] | None,
) -> list[Linted]:
    """One result per path, on all cores when it pays. `asked`: the rules, or the controller that is to load them."""
    import os
    from concurrent.futures import ProcessPoolExecutor

    from olp.checks.lint.run import lint, lint_load

    one: Callable[[str], Linted]
    if isinstance(asked, str):
        one = partial(lint_load, job=job, controller=asked)
    else:
        one = partial(lint, job=job, asked=asked)
    count = min(workers or os.cpu_count() or 1, 1 + len(paths) // _WORTH_WORKERS)
    results: list[Linted] = []
    if count <= 1:
        for path in paths:
            results.append(one(path))
            if done is not None:
                done(1)
        return results
    with ProcessPoolExecutor(count) as pool:
        for result in pool.map(one, paths, chunksize=16):
            results.append(result)
            if done is not None:
                done(1)
    return results


def _codes(text: str) -> list[str]:
    return text.replace(",", " ").split()


def _fixed(result: Linted, job: TimingJob, asked: RuleChoice, unsafe: bool, changes: list[Fixed]) -> Linted:
    """What remains of a file's findings after its fixes, which are added to `changes`."""
    from olp.checks.lint.fix import fix_file
    from olp.checks.lint.run import lint
    from olp.identification.timing_job import time_program

    if result.unreadable or not result.findings:
        return result
    run = partial(time_program, job=job)
    done = fix_file(result.path, result.findings, run, unsafe=unsafe, encoding=job.encoding)
    if done is None:
        return result
    changes.append(done)
    return lint(result.path, job, asked) if done.done else result


def _mended(changes: Sequence[Fixed]) -> str:
    """What was changed, and how much was left alone because it would not do what it promises."""
    lines = [edit for change in changes for edit in change.done]
    left = {
        (n, edit.code, edit.line)
        for n, change in enumerate(changes)
        for edit in change.refused
        if not any((edit.code, edit.line) == (d.code, d.line) for d in change.done)
    }
    told = f"{len(lines)} mended"
    told += f", {sum(not e.safe for e in lines)} of them unsafe" if any(not e.safe for e in lines) else ""
    return told + (f", {len(left)} left alone: the change would do something else as well" if left else "")


def outcome_of(
    results: Sequence[Linted], findings: Sequence[OutcomeFinding], fail_on: str = "warning"
) -> Outcome:
    """The findings that count, and each file as an item, which fails from the level `fail_on` on."""
    from olp.reports.outcome.model import Outcome

    own: dict[str, list[OutcomeFinding]] = {}
    for found in findings:
        own.setdefault(found.file, []).append(found)
    items = [_item(result, own.get(result.path, []), fail_on) for result in results]
    excused = sum(r.excused for r in results)
    told = sum(len(r.findings) for r in results) - len(findings)
    more = f", {told} known from the baseline" if told else ""
    more += f", {excused} excused in the programs" if excused else ""
    count = len(findings)
    programs = f"{len(results)} program{'' if len(results) == 1 else 's'}"
    sentence = f"{programs}: {count} finding{'' if count == 1 else 's'}{more}"
    return Outcome("lint", tuple(findings), tuple(items), (sentence,))


def _item(result: Linted, findings: Sequence[OutcomeFinding], fail_on: str) -> JudgedItem:
    from olp.reports.outcome.model import JudgedItem, Status

    order = ("note", "warning", "error")
    status, count = Status.HELD, len(findings)
    says = f"{count} finding{'' if count == 1 else 's'}"
    if result.unreadable:
        status, says = Status.UNKNOWN, next((f.message for f in result.findings), "cannot be read")
    elif any(order.index(found.level) >= order.index(fail_on) for found in findings):
        status = Status.FAILED
    elif findings:
        status = Status.WARNED
    elif result.findings:
        says = "only known findings"
    details = "\n".join(f"{f.file}:{f.line}: {f.code} {f.message}" for f in findings)
    return JudgedItem(result.path, result.path, status, says, group="lint", details=details)


def _fix_of(rule: Rule) -> str:
    return ", --fix" if rule.fixable else ", --fix --unsafe-fixes" if rule.suggests else ""


def _rules() -> str:
    from olp.checks.lint.rule import all_rules

    rows = [f"{rule.code}  {rule.level!s:8s} {rule.title}{_fix_of(rule)}" for rule in all_rules()]
    return "\n".join(rows) + "\n"
