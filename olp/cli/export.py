"""`olp export`: a program written anew in a vendor's language, from what was understood of it."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from olp.cli._outputs import add_output_arguments, convert
from olp.cli._timing import print_diagnostics

if TYPE_CHECKING:
    from olp.core.diagnostic import Diagnostic

SUMMARY = "write a program in a vendor's language"


def add_arguments(parser: ArgumentParser) -> None:
    from olp.languages.limits import writable

    add_output_arguments(parser, "exported")
    parser.add_argument(
        "--to", required=True, metavar="VENDOR", help=f"the language to write, such as {writable()[0]}"
    )
    parser.add_argument("--encoding", metavar="E", help="of the programs that are read (default: guessed)")
    parser.add_argument("--to-encoding", metavar="E", help="of the new program (default: the old one's)")
    parser.add_argument("--template", metavar="FILE", help="a jinja2 file for the shape of the program")


def run(args: Namespace) -> int:
    from olp.languages.limits import refuse_unwritable
    from olp.languages.vendor import find_vendor

    refuse_unwritable(args.to)
    told = convert(args, lambda path: _export(path, args), find_vendor(args.to).suffixes[0])
    print_diagnostics(told)
    return 2 if any(diagnostic.is_error for diagnostic in told) else 0


def _export(path: Path, args: Namespace) -> tuple[bytes, Sequence[Diagnostic]]:
    from olp.languages.vendor import read
    from olp.transpile.convert import export

    program = read(path, encoding=args.encoding)
    data = export(program, args.to, template=args.template, encoding=args.to_encoding)
    return data, program.diagnostics
