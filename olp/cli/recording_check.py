"""`olp recording check`: whether a recording can be used, and what it holds."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

SUMMARY = "report what a recording holds, or everything that is wrong with it"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("path", metavar="RECORDING", help="a folder with moves.csv, or a file of moves")
    parser.add_argument("--format", choices=("text", "json"), default="text", help="default: text")


def run(args: Namespace) -> int:
    import json

    from olp.cli._timing import print_diagnostics
    from olp.identification.recording.reader import read_recording
    from olp.identification.recording.summary import as_dict, describe

    recording = read_recording(args.path)
    if args.format == "json":
        told = [
            {"code": d.code, "severity": str(d.severity), "file": d.file, "line": d.line, "column": d.column,
             "message": d.message, "help": d.help}
            for d in recording.diagnostics
        ]  # fmt: skip
        print(json.dumps(as_dict(recording) | {"diagnostics": told}, indent=2, ensure_ascii=False))
        return 0
    print(describe(recording))
    print_diagnostics(recording.diagnostics)
    return 0
