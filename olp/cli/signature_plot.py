"""`olp signature plot`: the corrected acceleration over the direction, as a picture."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

SUMMARY = "draw a signature: the corrected acceleration over the direction of the moves"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("signature", metavar="FILE", help="made by olp calibrate")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="FILE.svg or FILE.png")


def run(args: Namespace) -> int:
    from olp.core.files import write_output
    from olp.identification.signature.file import read_signature
    from olp.reports.plot.output import picture, refuse_unknown
    from olp.reports.signature_picture import signature_figure

    refuse_unknown(args.output)
    figure = signature_figure(read_signature(args.signature))
    write_output(args.output, picture(figure, args.output), inputs=[args.signature])
    return 0
