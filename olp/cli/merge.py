"""`olp merge`: taught points from the robot and logic from the office in one program."""

from __future__ import annotations

import json
import sys
from argparse import ArgumentParser, Namespace

from olp.core.diagnostic import OlpError, error
from olp.core.files import absent, refuse_inputs, write_output

SUMMARY = "merge two changes of one program: points by identity, logic by statement"


def add_arguments(parser: ArgumentParser) -> None:
    from olp.cli._timing import add_timing_arguments, positive_int

    parser.add_argument("base", metavar="BASE", help="the program as both found it")
    parser.add_argument("ours", metavar="OURS", help="one changed version")
    parser.add_argument("theirs", metavar="THEIRS", help="the other one")
    parser.add_argument(
        "-o", "--output", metavar="OUT", help="where to write the merged program, - for standard output"
    )
    parser.add_argument("--json", action="store_true", help="print what was merged as JSON")
    parser.add_argument("--no-time", action="store_true", help="do not predict times")
    parser.add_argument(
        "--driver", metavar="PATH", help="as git's merge driver: write over OURS, which git knows as PATH"
    )
    parser.add_argument(
        "--marker-size",
        type=positive_int,
        default=7,
        metavar="N",
        help="characters of a conflict marker (default: 7)",
    )
    add_timing_arguments(parser)


def run(args: Namespace) -> int:
    from olp.checks.merge.merge import is_known, merge_files, text_merge
    from olp.cli._timing import print_diagnostics, timing_job_of
    from olp.identification.timing_job import check_assumptions

    inputs = [args.base, args.ours, args.theirs]
    if gone := absent(inputs):
        raise OlpError(*gone)
    target = _target(args, inputs)
    job = timing_job_of(args) if not args.no_time or args.assumptions is not None else None
    if job is not None:
        check_assumptions(job)
    home = args.driver or (args.ours if target in (None, "-") else target)
    if args.driver is not None and not is_known(inputs, str(home)):
        # Other files have these suffixes, too: git's own merge is better than none.
        return text_merge(inputs, args.marker_size)
    try:
        merged = merge_files(inputs, str(home), None if args.no_time else job)
    except OlpError as problem:
        if args.driver is None:
            raise
        # Git would leave ours there as if it were the merge, without a mark.
        print_diagnostics(problem.diagnostics)
        return text_merge(inputs, args.marker_size)
    if merged.writable:
        data = merged.to_bytes(args.marker_size)
        write_output(target, data, inputs=inputs, in_place=args.driver is not None)
    quiet = target in (None, "-") or args.driver is not None
    told = json.dumps(merged.as_json(), indent=2, ensure_ascii=False) if args.json else merged.as_text()
    print(told, file=sys.stderr if quiet else sys.stdout)
    print_diagnostics(merged.diagnostics)
    return 0 if merged.clean else 1


def _target(args: Namespace, inputs: list[str]) -> str | None:
    """Where the program goes. Raises OlpError where nothing or too much is said."""
    if args.driver is not None:
        if args.output is not None:
            raise OlpError(
                error("C002", "--driver writes over OURS: -o says something else", help="leave out one")
            )
        return inputs[1]
    if args.output is None:
        raise OlpError(
            error("C002", "the merged program has no place", help="olp merge BASE OURS THEIRS -o OUT")
        )
    if args.output != "-":
        refuse_inputs(args.output, inputs)
    return str(args.output)
