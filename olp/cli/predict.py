"""`olp predict`: the time of each move of a recording, from a signature."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

SUMMARY = "predict the moves of a recording with a signature, with a 95 % interval"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("recording", metavar="RECORDING", help="a folder with moves.csv, or such a file")
    parser.add_argument(
        "--signature", required=True, metavar="FILE", help="made by olp calibrate or olp diagnose"
    )
    parser.add_argument("-o", "--output", metavar="OUT.csv", help="move, predicted_s, low_s, high_s")


def run(args: Namespace) -> int:
    from pathlib import Path

    from olp.cli._timing import print_diagnostics
    from olp.core.files import write_output
    from olp.identification.recording.reader import read_recording
    from olp.identification.signature.file import read_signature
    from olp.identification.signature.rows import predict_recording

    signature = read_signature(args.signature)
    recording = read_recording(args.recording)
    rows, told = predict_recording(signature, recording)
    inputs = [args.recording, args.signature, *Path(args.recording).glob("*")]
    write_output(args.output, rows.csv(), inputs=[p for p in inputs if Path(p).is_file()])
    print_diagnostics((*recording.diagnostics, *told))
    return 0
