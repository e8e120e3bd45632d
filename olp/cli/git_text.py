"""`olp git text`: a program as git's diff should show it."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

SUMMARY = "show a program for git diff: positions in the moves, no line numbers and dates"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("job", metavar="JOB", help="a program, or a file of its data")


def run(args: Namespace) -> int:
    from olp.checks.merge.git import shown_text
    from olp.core.files import write_output

    write_output(None, shown_text(args.job))
    return 0
