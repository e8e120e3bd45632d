"""`olp signature show`: what a signature holds."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

SUMMARY = "say what a signature was learnt from, how sure it is and where it holds"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("signature", metavar="FILE", help="made by olp calibrate")


def run(args: Namespace) -> int:
    from olp.identification.signature.file import read_signature
    from olp.identification.signature.summary import describe

    print("\n".join(describe(read_signature(args.signature))))
    return 0
