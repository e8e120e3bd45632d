"""`olp git install`: git merges and shows robot programs with olp."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

SUMMARY = "have git merge and show robot programs with olp, in this repository"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--remove", action="store_true", help="take it out again, of .git/config and .gitattributes"
    )


def run(args: Namespace) -> int:
    from olp.checks.merge.git import install, remove

    for line in remove() if args.remove else install():
        print(line)
    return 0
