"""What commands that time programs share: the options, the job that they make, progress, and what is told besides."""

from __future__ import annotations

import re
import sys
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from typing import TYPE_CHECKING, TypeVar

from olp.core.diagnostic import Severity
from olp.core.files import shown, utf8
from olp.core.terminal import RED, YELLOW, paint, wanted

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from olp.core.diagnostic import Diagnostic
    from olp.identification.timing_job import TimingJob

Result = TypeVar("Result")


def add_timing_arguments(parser: ArgumentParser) -> None:
    """What every command takes that has to time a program."""
    parser.add_argument("--robot", metavar="R", help="the robot: a name of `olp robots`, or a robot file")
    parser.add_argument(
        "--model", metavar="M", help="the motion model: constant or linear (default: constant)"
    )
    parser.add_argument(
        "--accel",
        type=positive,
        metavar="A",
        help="acceleration of linear moves in mm/s² (default: the robot's)",
    )
    parser.add_argument(
        "--accel-law",
        metavar="L",
        help="what an axis can do: constant, time_constant, by_pose or torque (default: constant)",
    )
    parser.add_argument(
        "--override",
        type=positive,
        metavar="PCT",
        help="speed override in percent, a factor on V= and VJ= (default: 100)",
    )
    parser.add_argument(
        "--signature",
        metavar="FILE",
        help="the robot's timing signature, made by olp calibrate or olp diagnose",
    )
    parser.add_argument("--assumptions", metavar="FILE", help="an olp.toml (default: the nearest one)")
    parser.add_argument("--encoding", metavar="E", help="of the program text (default: guessed)")
    parser.add_argument(
        "--max-steps",
        type=positive_int,
        metavar="N",
        help="stop after this many statements (default: 200000 per cycle, and ten times those that are read)",
    )
    parser.add_argument(
        "--cycles", type=positive_int, default=1, metavar="N", help="rounds of an endless main loop"
    )


def add_routine_argument(parser: ArgumentParser) -> None:
    """The option of commands that tell about one run of a program."""
    parser.add_argument(
        "--routine", metavar="NAME", help="start there (default: main, or what the language starts with)"
    )


def positive(text: str) -> float:
    """A number above zero."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise ArgumentTypeError(f"{text!r} is not a number above zero")
    return value


def positive_int(text: str) -> int:
    """A whole number above zero."""
    if not text.isdecimal() or int(text) < 1:
        raise ArgumentTypeError(f"{text!r} is not a whole number above zero")
    return int(text)


def timing_job_of(args: Namespace) -> TimingJob:
    """What `add_timing_arguments` took. Raises OlpError for a robot, model or olp.toml that is none."""
    from olp.identification.timing_job import TimingJob, check_job

    job = TimingJob(
        robot=args.robot,
        model=args.model,
        acceleration=None if args.accel is None else args.accel * 1e-3,
        encoding=args.encoding,
        assumptions=args.assumptions,
        max_steps=args.max_steps,
        override=None if args.override is None else args.override * 1e-2,
        cycles=args.cycles,
        acceleration_law=args.accel_law,
        signature=args.signature,
        routine=getattr(args, "routine", None),
    )
    check_job(job)
    return job


def with_progress(
    paths: Sequence[str], work: Callable[[Callable[[int], None] | None], list[Result]]
) -> list[Result]:
    """Does the work, with a progress bar when it is long and somebody is watching. `work` is done in order of `paths`.

    A file counts as much as it has bytes: one long program takes the time of many short ones.
    """
    import os
    from itertools import islice

    if len(paths) < 20 or not sys.stderr.isatty():
        return work(None)
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as progress:
        sizes = [os.path.getsize(path) if os.path.isfile(path) else 0 for path in paths]
        task, left = progress.add_task("working", total=sum(sizes)), iter(sizes)
        return work(lambda n: progress.update(task, advance=sum(islice(left, n))))


def encode(text: str, output: str | None) -> bytes:
    """Reports are UTF-8, but a terminal gets what it can show."""
    return shown(text) if output is None else utf8(text)


_MORE = re.compile(r" \(and (once more|in \d+ more lines)\)$")
_WHOLE = 3  # errors of one sentence in one file that are shown with their lines


def print_diagnostics(diagnostics: Sequence[Diagnostic]) -> None:
    """To the error stream: what is wrong whole, the same sentence once; notes of one kind as one line."""

    if not diagnostics:
        return
    colour = wanted(sys.stderr)
    groups: dict[tuple[Severity, str, str], list[Diagnostic]] = {}
    for d in diagnostics:
        if d.severity is not Severity.INFO:
            groups.setdefault((d.severity, d.code, _MORE.sub("", d.message)), []).append(d)
    blocks = [block for group in groups.values() for block in _blocks(group, colour)]
    notes = _notes(diagnostics)
    print("\n\n".join([*blocks, "\n".join(notes)] if notes else blocks), file=sys.stderr)


def _blocks(group: Sequence[Diagnostic], colour: bool) -> list[str]:
    """What one sentence is said of: the first place whole (of errors those of its file), the others counted."""
    whole = [d for d in group if d.file == group[0].file][: _WHOLE if group[0].is_error else 1]
    blocks = [_shown(d, colour) for d in whole]
    others = [d for d in group if d not in whole]
    if others:
        places = list(dict.fromkeys(f"{d.file}:{d.line}" if d.line else d.file for d in others))
        more = f" and {len(places) - _WHOLE} more places" if len(places) > _WHOLE else ""
        blocks[-1] += f"\nthe same in {', '.join(places[:_WHOLE])}{more}"
    return blocks


def _notes(diagnostics: Sequence[Diagnostic]) -> list[str]:
    """One line per sentence, with its first place and how often it was said."""
    groups: dict[tuple[str, str], list[Diagnostic]] = {}
    for diagnostic in diagnostics:
        if diagnostic.severity is Severity.INFO:
            groups.setdefault((diagnostic.code, _MORE.sub("", diagnostic.message)), []).append(diagnostic)
    lines = []
    for (code, message), group in groups.items():
        place = f"{group[0].file}:{group[0].line}" if group[0].line else group[0].file
        often = f", {len(group)} times" if len(group) > 1 else ""
        lines.append(f"info[{code}]: {message} ({place}{often})")
    return lines


def _shown(diagnostic: Diagnostic, colour: bool) -> str:
    head, *rest = diagnostic.render().split("\n")
    if colour:
        head = paint(head, RED if diagnostic.is_error else YELLOW)
    return "\n".join([head, *rest])
