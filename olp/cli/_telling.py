"""How the commands that judge are told to tell: one format to the terminal or a file, others to files besides."""

from __future__ import annotations

import os
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from olp.cli.command import refuse_other_forms
from olp.core.diagnostic import OlpError, error
from olp.core.files import write_output

if TYPE_CHECKING:
    from olp.reports.outcome import Outcome, OutcomeFormat


class Telling(NamedTuple):
    """Formats, each with the file that it goes to; None: standard output."""

    outputs: tuple[tuple[OutcomeFormat, str | None], ...]

    def write(self, outcome: Outcome, inputs: Iterable[str]) -> None:
        """Raises OlpError (C006) for an output that is an input, and OSError."""
        from olp.cli.time import encode

        texts = [(form.render(outcome), file) for form, file in self.outputs]
        known = list(inputs)
        for text, file in texts:
            write_output(file, encode(text, file), inputs=known)


def add_format_arguments(parser: ArgumentParser) -> None:
    """--format, -o and --also."""
    from olp.reports.outcome import format_names

    parser.add_argument(
        "--format",
        metavar="F",
        help=f"one of {', '.join(format_names())} (default: what the suffix of -o says, else text)",
    )
    parser.add_argument("-o", "--output", metavar="FILE", help="write there (default: standard output)")
    parser.add_argument(
        "--also",
        action="append",
        default=[],
        type=_pair,
        metavar="F=FILE",
        help="write another format to a file of its own; may come several times",
    )


def telling(args: Namespace) -> Telling:
    """Where everything goes. Raises OlpError for an unknown format (C011) or a file that is named twice (C002)."""
    from olp.reports.outcome import load_format

    refuse_other_forms(args.output, _BY_SUFFIX, args.format)
    suffix = os.path.splitext(args.output or "")[1].lower()
    pairs = [(args.format or _BY_SUFFIX.get(suffix, "text"), args.output), *args.also]
    files = [os.path.abspath(file) for _, file in pairs if file is not None]
    for file in files:
        if files.count(file) > 1:
            raise OlpError(error("C002", "two formats would go to this file", file=file))
    return Telling(tuple((load_format(name), file) for name, file in pairs))


_BY_SUFFIX = {".json": "json", ".xml": "junit", ".md": "markdown", ".sarif": "sarif"}


def _pair(text: str) -> tuple[str, str]:
    name, sign, file = text.partition("=")
    if not (name and sign and file):
        raise ArgumentTypeError("a format and its file: junit=budgets.xml")
    return name, file
