"""`olp track`: where the robot is at each instant."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from olp.cli._timing import add_timing_arguments, positive, print_diagnostics, timing_job_of
from olp.core.diagnostic import OlpError, error
from olp.core.files import utf8, write_output
from olp.core.terminal import to_cell

if TYPE_CHECKING:
    import pandas

_PARQUET = (".parquet", ".pq")
SUMMARY = "say where the robot is at each instant of a program"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("job", metavar="JOB", help="a program")
    parser.add_argument(
        "--dt", type=positive, default=0.004, metavar="S", help="time step in s (default: 0.004)"
    )
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="FILE.csv or FILE.parquet (default: CSV on standard output)"
    )
    add_timing_arguments(parser)


def run(args: Namespace) -> int:
    from olp.identification.timing_job import plan_and_time
    from olp.timing.result import assumed
    from olp.timing.track import track

    _refuse_other_suffixes(args.output)
    timing = plan_and_time(args.job, timing_job_of(args))
    table = track(timing, args.dt).frame()
    if args.output and args.output.lower().endswith(_PARQUET):
        data = _parquet(table)
    else:
        table["file"] = table["file"].map({name: to_cell(name) for name in set(table["file"])})
        data = utf8(table.to_csv(index=False, float_format="%.6f", lineterminator="\n"))
    write_output(args.output, data, inputs=[args.job])
    told = [d.at(args.job) for d in (*timing.diagnostics, *assumed(timing))]
    print_diagnostics(told)
    return 2 if any(d.is_error for d in told) else 0


def _refuse_other_suffixes(output: str | None) -> None:
    """Raises OlpError for a suffix that promises another format than those there are (.xlsx)."""
    suffix = "" if output in (None, "-") else os.path.splitext(str(output))[1].lower()
    if suffix not in ("", ".csv", ".txt", *_PARQUET):
        raise OlpError(
            error("C002", f"a track cannot be written as {suffix}", help="name FILE.csv or FILE.parquet")
        )


def _parquet(table: pandas.DataFrame) -> bytes:
    """The table as Parquet. Raises OlpError when the library for it is not installed."""
    import io

    buffer = io.BytesIO()
    try:
        table.to_parquet(buffer, index=False)
    except ImportError:
        raise OlpError(
            error(
                "C010", "Parquet needs pyarrow", help='install it: pip install "olp[parquet]"; or write .csv'
            )
        ) from None
    return buffer.getvalue()
