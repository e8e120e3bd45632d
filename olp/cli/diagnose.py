"""`olp diagnose`: where a simulation and a recording differ, and which physics was left out."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording

SUMMARY = "name the physics that a simulation left out, from a recording of the robot"

_WIDTH = 100  # characters of a line where no terminal says how wide it is


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "recording",
        metavar="RECORDING",
        help="a folder with moves.csv or log.csv, or a file of moves (docs/recording.md)",
    )
    parser.add_argument(
        "--job", metavar="JOB", help="the program that ran, for its lines (default: that of recording.toml)"
    )
    parser.add_argument("--robot", metavar="R", help="the robot, instead of the recording's")
    parser.add_argument(
        "--json", metavar="OUT", help="the whole answer, schema olp.diagnosis/1; - for standard output"
    )
    parser.add_argument("--html", metavar="OUT", help="a report in one file, to open in a browser")
    parser.add_argument(
        "--next", metavar="OUT", help="write a robot program of moves that separate indistinguishable causes"
    )
    parser.add_argument(
        "--signature",
        metavar="OUT",
        help="the findings as a signature, for olp time, annotate and predict; - for standard output",
    )


def run(args: Namespace) -> int:
    import json
    from dataclasses import replace
    from pathlib import Path

    from olp.cli._timing import print_diagnostics
    from olp.core.diagnostic import OlpError
    from olp.core.files import refuse_inputs, write_output
    from olp.identification.diagnosis.diagnose import diagnose_recording, nothing_to_compare
    from olp.identification.recording.reader import read_recording
    from olp.robots.robot import load_robot

    inputs = [args.recording, *Path(args.recording).glob("*"), *([args.job] if args.job else [])]
    for output in (args.json, args.html, args.next, args.signature):
        if output not in (None, "-"):
            refuse_inputs(output, inputs)
    robot = load_robot(args.robot) if args.robot else None
    recording = read_recording(args.recording, logs_alone=True)
    recording, job_text = _with_job(recording, args.job)
    print_diagnostics(recording.diagnostics)
    try:
        outcome = diagnose_recording(recording, robot)
    except OlpError as problem:
        answer = nothing_to_compare(problem)
        if args.json:
            write_output(args.json, json.dumps(answer.to_json(), indent=1) + "\n")
        raise
    if args.json:
        write_output(args.json, json.dumps(outcome.diagnosis.to_json(), indent=1) + "\n")
    if args.html:
        from olp.reports.diagnosis.page import html_report

        log = outcome.log.to_json() if outcome.log is not None else None
        write_output(args.html, html_report(outcome, recording, job_text, log_summary=log))
    if "-" not in (args.json, args.html, args.signature):
        from olp.identification.diagnosis.report_text import text_report

        print(text_report(outcome.diagnosis, outcome.case, *_terminal()), end="")
    if args.next:
        from olp.identification.diagnosis.next_job import write_experiment_job

        print_diagnostics(write_experiment_job(outcome.diagnosis.next_experiment, recording, args.next))
    if args.signature:
        from olp.identification.signature.file import write_signature
        from olp.identification.signature.from_diagnosis import signature_of

        own = recording if robot is None else replace(recording, robot=robot)
        signature, told = signature_of(outcome, own)
        write_signature(signature, args.signature)
        print_diagnostics(told)
    return 2 if outcome.diagnosis.verdict == "not-judged" else 0


def _terminal() -> tuple[int, bool]:
    """Characters per line, and whether somebody sees colour."""
    import shutil
    import sys

    from olp.core.terminal import wanted

    columns = shutil.get_terminal_size().columns if sys.stdout.isatty() else _WIDTH
    return columns, wanted(sys.stdout)


def _with_job(recording: Recording, job: str | None) -> tuple[Recording, dict[str, str] | None]:
    """The recording with the program's name where moves have lines only, and the program's text by its name.

    Raises OlpError: what is wrong with the program; N011 where moves are of lines that it does not have.
    """
    from dataclasses import replace
    from pathlib import Path

    from olp.core.diagnostic import OlpError, Severity, error
    from olp.languages.vendor import read

    if job is None:
        settings = recording.settings
        path = Path(settings.file).parent / settings.job
        if not settings.job or not os.path.isfile(path):
            return recording, None
        job = str(path)
    program = read(job)
    bad = [d for d in program.diagnostics if d.severity is Severity.ERROR]
    if bad:
        raise OlpError(*bad)
    name, text = Path(job).name, program.to_bytes().decode(errors="replace")
    moves = recording.moves
    if (moves.line > 0).any() and not any(moves.job):
        recording = replace(recording, moves=replace(moves, job=(name,) * len(moves)))
    last = max(
        (n for n, of in zip(moves.line.tolist(), recording.moves.job, strict=True) if of == name), default=0
    )
    if last > len(text.splitlines()):
        says = f"line {last} of {recording.path} is not in this program, which has {len(text.splitlines())} lines"
        raise OlpError(error("N011", says, file=job, help="name the program that ran"))
    return recording, {name: text}
