"""Where commands put their results.

Commands that write programs: one file, one per input in a folder, or in place. Commands that judge: one format on the
terminal or in a file, others in files besides.

Codes: C007 several outputs and nowhere to put them, C008 two inputs for one output.
"""

from __future__ import annotations

import os
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from olp.cli.command import refuse_other_forms
from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.files import from_os_error, write_output

if TYPE_CHECKING:
    from olp.reports.outcome.model import Outcome, OutcomeFormat


# Bytes of the output, and what there is to tell besides.
Work = Callable[[Path], tuple[bytes, Sequence[Diagnostic]]]


def add_output_arguments(parser: ArgumentParser, done: str) -> None:
    """JOB…, -o and --in-place. `done`: what the outputs are, for the help."""
    parser.add_argument("jobs", nargs="+", metavar="JOB", help="a program, or a folder of programs")
    parser.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        help=f"where to write the {done} program (default: standard output); a folder for several",
    )
    parser.add_argument("--in-place", action="store_true", help="write it over the file that was read")


def convert(args: Namespace, work: Work, suffix: str | None = None) -> list[Diagnostic]:
    """Does `work` for every file of `args.jobs` and writes what comes out. Returns all there is to tell.

    A file whose work raises OlpError is told about and not written; the others are. `suffix`: of the outputs,
    with its dot (None: as the input's). Raises OlpError for missing inputs and outputs that contradict each other.
    """
    from olp.languages.vendor import program_files

    inputs = program_files(args.jobs)
    targets = destinations(inputs, args, suffix)
    told: list[Diagnostic] = []
    for source, target in zip(inputs, targets, strict=True):
        try:
            data, found = work(source)
            if target is not None:
                target.parent.mkdir(parents=True, exist_ok=True)
            write_output(target, data, inputs=inputs, in_place=args.in_place)
            told += [diagnostic.at(str(source)) for diagnostic in found]
        except OlpError as problem:
            told += [diagnostic.at(str(source)) for diagnostic in problem.diagnostics]
        except BrokenPipeError:
            raise
        except OSError as problem:
            told.append(from_os_error(problem))
    return told


def destinations(inputs: Sequence[Path], args: Namespace, suffix: str | None) -> list[Path | None]:
    """One output per input; None is standard output. Raises OlpError."""
    if args.in_place:
        if args.output is not None:
            raise OlpError(error("C002", "-o and --in-place exclude each other"))
        if any(_renamed(path, suffix) != path for path in inputs):
            raise OlpError(error("C002", "another language belongs in another file", help="name it with -o"))
        return list(inputs)
    if args.output in (None, "-"):
        if len(inputs) > 1:
            raise OlpError(
                error(
                    "C007",
                    f"{len(inputs)} programs and one output",
                    help="name a folder with -o, or say --in-place",
                )
            )
        return [None]
    out = Path(args.output)
    whole_folder = any(Path(job).is_dir() for job in args.jobs)
    if len(inputs) == 1 and not whole_folder and not out.is_dir() and not args.output.endswith(("/", os.sep)):
        return [out]
    if out.exists() and not out.is_dir():
        raise OlpError(error("C007", "several programs need a folder, this is a file", file=str(out)))
    # Files of the same name in different folders stay apart.
    root = Path(os.path.commonpath([os.path.abspath(path.parent) for path in inputs]))
    targets = [out / _renamed(Path(os.path.abspath(path)).relative_to(root), suffix) for path in inputs]
    _refuse_collisions(inputs, targets)
    return list(targets)


def _renamed(path: Path, suffix: str | None) -> Path:
    return path if suffix is None or path.suffix.lower() == suffix.lower() else path.with_suffix(suffix)


def _refuse_collisions(inputs: Sequence[Path], targets: Sequence[Path]) -> None:
    first: dict[str, Path] = {}
    problems = []
    for source, target in zip(inputs, targets, strict=True):
        other = first.setdefault(os.path.normcase(target), source)
        if other != source:
            problems.append(error("C008", f"this output is {other}'s too", file=str(target)))
    if problems:
        raise OlpError(*problems)


class OutcomeOutputs(NamedTuple):
    """Formats, each with the file that it goes to; None: standard output."""

    outputs: tuple[tuple[OutcomeFormat, str | None], ...]

    def write(self, outcome: Outcome, inputs: Iterable[str]) -> None:
        """Raises OlpError (C006) for an output that is an input, and OSError."""
        from olp.cli._timing import encode

        texts = [(form.render(outcome), file) for form, file in self.outputs]
        known = list(inputs)
        for text, file in texts:
            write_output(file, encode(text, file), inputs=known)


def add_format_arguments(parser: ArgumentParser) -> None:
    """--format, -o and --also."""
    from olp.reports.outcome.model import format_names

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


def outcome_outputs(args: Namespace) -> OutcomeOutputs:
    """Where everything goes. Raises OlpError for an unknown format (C011) or a file that is named twice (C002)."""
    from olp.reports.outcome.model import load_format

    refuse_other_forms(args.output, _BY_SUFFIX, args.format)
    suffix = os.path.splitext(args.output or "")[1].lower()
    pairs = [(args.format or _BY_SUFFIX.get(suffix, "text"), args.output), *args.also]
    files = [os.path.abspath(file) for _, file in pairs if file is not None]
    for file in files:
        if files.count(file) > 1:
            raise OlpError(error("C002", "two formats would go to this file", file=file))
    return OutcomeOutputs(tuple((load_format(name), file) for name, file in pairs))


_BY_SUFFIX = {".json": "json", ".xml": "junit", ".md": "markdown", ".sarif": "sarif"}


def _pair(text: str) -> tuple[str, str]:
    name, sign, file = text.partition("=")
    if not (name and sign and file):
        raise ArgumentTypeError("a format and its file: junit=budgets.xml")
    return name, file
