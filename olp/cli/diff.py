"""`olp diff`: what a new version of a program costs or gains, line by line."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
from pathlib import PurePath
from typing import TYPE_CHECKING

from olp.cli._outputs import add_format_arguments, outcome_outputs
from olp.core.source import file_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from olp.checks.difference.compare import ProgramDifference
    from olp.reports.outcome.model import JudgedItem, Outcome, OutcomeFinding

SUMMARY = "compare the times of two versions of a program"
_SHOWN = 12  # lines per program in text; JSON has them all


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli._timing import add_timing_arguments, positive

    parser.add_argument("old", metavar="OLD", help="a program, a folder, or a git revision")
    parser.add_argument("new", metavar="NEW", help="the same; . is the working copy when OLD is a revision")
    parser.add_argument(
        "paths", nargs="*", metavar="PATH", help="of two revisions: only these files and folders"
    )
    add_format_arguments(parser)
    parser.add_argument(
        "--allow", type=positive, metavar="S", help="fail when a program takes this much longer than before"
    )
    parser.add_argument(
        "--all", action="store_true", help="list every line that changed, not only the largest"
    )
    add_timing_arguments(parser)


def run(args: Namespace) -> int:
    from olp.checks.difference.versions import open_versions
    from olp.cli._timing import timing_job_of

    told, job = outcome_outputs(args), timing_job_of(args)
    with open_versions(args.old, args.new, args.paths) as versions:
        found = [versions.compare(pair, job) for pair in versions.pairs]
        outcome = outcome_of(found, args.allow, None if args.all else _SHOWN)
        told.write(outcome, [args.old, args.new])
    return outcome.exit_status


def outcome_of(found: Sequence[ProgramDifference], allow: float | None, shown: int | None) -> Outcome:
    """What all programs together amount to, the one that grew most first."""
    from olp.reports.outcome.model import Outcome

    ordered = sorted(found, key=lambda d: (d.change_s is not None, -abs(d.change_s or 0.0), d.file))
    # Nobody wants to read the list of those that are as they were.
    items = [_item(d, allow) for d in ordered if len(ordered) == 1 or d.changes or d.why or not _same(d)]
    items += [item for d in ordered for item in d.budgets]
    findings = [f for d in ordered for f in _findings(d, allow, shown)]
    tables = [_table(d, shown) for d in ordered if d.changes]
    data = {"programs": [_data(d) for d in ordered], "tables": tables}
    return Outcome("diff", tuple(findings), tuple(items), (_sentence(found),), data)


def _signed(seconds: float) -> str:
    """Never -0.000."""
    return f"{round(seconds, 3) + 0.0:+.3f}"


def _same(d: ProgramDifference) -> bool:
    return d.old_s is not None and d.old_s == d.new_s


def _item(d: ProgramDifference, allow: float | None) -> JudgedItem:
    from olp.reports.outcome.model import JudgedItem, Status

    if d.old_s is None or d.new_s is None:
        added = "new program" if d.old_s is None and not d.why else "program gone" if not d.why else d.why
        status = Status.UNKNOWN if d.why else Status.HELD
        return JudgedItem(d.file, d.file, status, added, seconds=d.new_s, group="diff")
    change = d.new_s - d.old_s
    over = allow is not None and change > allow
    says = f"{d.old_s:.3f} → {d.new_s:.3f} s ({_signed(change)} s)"
    if d.new_ends is not None:
        says += f", 95 %: {d.new_ends[0]:.3f} to {d.new_ends[1]:.3f} s"
    status = Status.FAILED if over else Status.UNKNOWN if d.notes else Status.HELD
    return JudgedItem(d.file, d.file, status, "; ".join((says, *d.notes)), seconds=d.new_s, group="diff")


def _findings(d: ProgramDifference, allow: float | None, shown: int | None) -> Iterator[OutcomeFinding]:
    from olp.reports.outcome.model import Level, OutcomeFinding

    order = sorted(d.changes, key=lambda c: -abs(c.change_s))[:shown]
    for change in order:
        own = not change.file or change.file == file_name(d.file)
        file = d.file if own else str(PurePath(d.file).with_name(change.file))
        details = f" ({change.details})" if change.details else ""
        yield OutcomeFinding(
            "U010",
            Level.NOTE,
            f"{_signed(change.change_s)} s, {change.cause}{details}: {change.statement}",
            file,
            change.new_line or 0,
            title="a line takes another time",
            anchor=f"{change.routine} {change.statement}",
            numbers={"old_s": round(change.old_s, 6), "new_s": round(change.new_s, 6)},
        )
    if allow is not None and d.change_s is not None and d.change_s > allow:
        says = f"the program takes {d.change_s:.3f} s longer than before, {allow:g} s are allowed"
        yield OutcomeFinding("U011", Level.ERROR, says, d.file, title="cycle time grew", anchor="total")


def _table(d: ProgramDifference, shown: int | None) -> dict[str, object]:
    order = sorted(d.changes, key=lambda c: -abs(c.change_s))[:shown]
    rows = [
        (
            c.new_line or f"({c.old_line})",
            c.statement,
            f"{c.old_s:.3f}",
            f"{c.new_s:.3f}",
            _signed(c.change_s),
            c.cause,
            c.details,
        )
        for c in order
    ]
    return {
        "title": d.file,
        "head": ("line", d.file, "old s", "new s", "change s", "cause", ""),
        "rows": rows,
    }


def _data(d: ProgramDifference) -> dict[str, object]:
    return {
        "file": d.file,
        "old_s": d.old_s,
        "new_s": d.new_s,
        "change_s": d.change_s,
        "old_interval_s": d.old_ends,
        "new_interval_s": d.new_ends,
        "notes": list(d.notes),
        "changes": [
            {
                "file": c.file,
                "routine": c.routine,
                "old_line": c.old_line,
                "new_line": c.new_line,
                "statement": c.statement,
                "kind": c.kind,
                "old_s": c.old_s,
                "new_s": c.new_s,
                "change_s": c.change_s,
                "cause": str(c.cause),
                "details": c.details,
                "moved_mm": c.moved_mm,
                "turned_deg": c.turned_deg,
            }
            for c in d.changes
        ],
    }


def _sentence(found: Sequence[ProgramDifference]) -> str:
    changes = [d.change_s for d in found if d.change_s is not None]
    changed = sum(abs(c) > 5e-7 for c in changes)
    total = sum(changes)
    programs = f"{len(found)} program{'' if len(found) == 1 else 's'}"
    return f"{programs}, {changed} with another time, {_signed(total)} s in all"
