"""`olp diagnose`: where a simulation and a recording differ, and which physics was left out."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

SUMMARY = "find what a simulation left out, from a recording: which physics, how much, and whether that holds"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "recording", metavar="RECORDING", help="a folder with moves.csv, or such a file (docs/recording.md)"
    )
    parser.add_argument("--job", metavar="JOB", help="the program that ran, for the lines in the report")
    parser.add_argument("--robot", metavar="R", help="the robot, instead of the recording's")
    parser.add_argument(
        "--json", metavar="OUT", help="the whole answer, schema olp.diagnosis/1; - for standard output"
    )
    parser.add_argument("--html", metavar="OUT", help="a report in one file, to open in a browser")
    parser.add_argument(
        "--next", metavar="OUT", help="a robot program of the moves that would tell apart what is alike"
    )


def run(args: Namespace) -> int:
    import json
    from pathlib import Path

    from olp.commands.time import print_diagnostics
    from olp.diagnosis.diagnose import diagnose_recording
    from olp.diagnosis.report_text import text_report
    from olp.files import refuse_inputs, write_output
    from olp.recording import read_recording
    from olp.robots.library import load_robot

    inputs = [args.recording, *Path(args.recording).glob("*"), *([args.job] if args.job else [])]
    for output in (args.json, args.html, args.next):
        if output not in (None, "-"):
            refuse_inputs(output, inputs)
    robot = load_robot(args.robot) if args.robot else None
    recording = read_recording(args.recording)
    outcome = diagnose_recording(recording, robot)
    if args.json:
        write_output(args.json, (json.dumps(outcome.diagnosis.to_json(), indent=1) + "\n").encode())
    if args.html:
        from olp.diagnosis.html import html_report

        write_output(args.html, html_report(outcome, recording, _text_of(args.job)).encode())
    if args.next:
        from olp.diagnosis.next_job import write_experiment_job

        write_experiment_job(outcome.diagnosis.next_experiment, recording, args.next)
    print_diagnostics(recording.diagnostics)
    if args.json != "-":
        print(text_report(outcome.diagnosis, outcome.case))
    return 0


def _text_of(job: str | None) -> str | None:
    """The program as text, for the report."""
    if job is None:
        return None
    import olp

    return olp.read(job).to_bytes().decode(errors="replace")
