"""`olp trend`: how the predicted time of a program went from run to run."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from olp.core.diagnostic import OlpError, error
from olp.core.files import write_output
from olp.core.terminal import csv_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from olp.checks.guard.store import TrendPoint

SUMMARY = "show how a program's predicted time changed from run to run"
_FORMATS = ("text", "csv", "json")


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli._timing import positive_int

    parser.add_argument("job", metavar="JOB", help="the program's path, or its name without suffix")
    parser.add_argument(
        "--store", default="olp.db", metavar="FILE", help="made by olp check --store (default: olp.db)"
    )
    parser.add_argument("--last", type=positive_int, default=20, metavar="N", help="runs shown (default: 20)")
    parser.add_argument("--format", default="text", choices=_FORMATS, help="default: text")
    parser.add_argument("-o", "--output", metavar="FILE", help="write there (default: standard output)")


def run(args: Namespace) -> int:
    from olp.checks.guard.store import history
    from olp.cli._timing import encode

    points = history(Path(args.store), args.job)
    if not points:
        says = f"the store holds no run of {args.job[:60]!r}"
        raise OlpError(error("M005", says, file=args.store, help="name the program as olp check saw it"))
    points = points[-args.last :]
    text = {"text": _text, "csv": _csv, "json": _json}[args.format](points)
    write_output(args.output, encode(text, args.output), inputs=[args.store, args.job])
    return 0


def _text(points: Sequence[TrendPoint]) -> str:
    rows = [f"{'run':25s} {'commit':12s} {'time s':>10s} {'change s':>10s}  program"]
    before: dict[str, float] = {}
    for point in points:
        total = point.total_s
        change = "" if total is None or point.path not in before else f"{total - before[point.path]:+.3f}"
        shown = "unknown" if total is None else f"{total:.3f}"
        rows.append(f"{point.started:25s} {point.commit:12s} {shown:>10s} {change:>10s}  {point.path}")
        if total is not None:
            before[point.path] = total
    return "\n".join(rows) + "\n"


def _csv(points: Sequence[TrendPoint]) -> str:
    return csv_text([("started", "commit", "file", "total_s", "motion_s", "wait_s"), *points])


def _json(points: Sequence[TrendPoint]) -> str:
    import json

    return json.dumps([point._asdict() for point in points], indent=2) + "\n"
