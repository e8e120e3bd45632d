"""`olp signature diff`: what changed between two signatures."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from olp.cli._timing import positive

SUMMARY = "compare two signatures in facts and in predicted times"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("old", metavar="OLD.json", help="made by olp calibrate")
    parser.add_argument("new", metavar="NEW.json", help="made by olp calibrate")
    parser.add_argument(
        "--limit", type=positive, metavar="PCT", help="exit status 1 when the mean time changed by more"
    )


def run(args: Namespace) -> int:
    from olp.identification.signature.diff import difference
    from olp.identification.signature.file import read_signature

    found = difference(read_signature(args.old), read_signature(args.new))
    for name, old, new in found.facts:
        print(f"{name}: {old} -> {new}")
    percent = found.percent
    mean = float(found.new.sum() / found.old.sum() - 1) * 100
    print(
        f"{len(percent)} moves of both domains: time {mean:+.2f} %, from {percent.min():+.2f} to {percent.max():+.2f} %"
    )
    print(f"{int(found.apart.sum())} of them with intervals that do not touch")
    return 1 if args.limit is not None and abs(mean) > args.limit else 0
