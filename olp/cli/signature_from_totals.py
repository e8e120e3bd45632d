"""`olp signature from-totals`: a timing signature from nothing but the total times of programs."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

SUMMARY = "learn a robot's timing signature from the totals of programs alone"


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "totals", metavar="TOTALS.csv", help="columns job (a file, from the table's folder) and total_s"
    )
    parser.add_argument("-o", "--output", metavar="FILE", help="the signature (default: standard output)")
    parser.add_argument("--robot", metavar="R", help="the robot, instead of the jobs' own")


def run(args: Namespace) -> int:
    import math

    from olp.cli._timing import print_diagnostics
    from olp.core.files import refuse_inputs
    from olp.identification.signature.file import write_signature
    from olp.identification.signature.partial_programs import programs_of, read_totals, signature_of_totals
    from olp.identification.signature.summary import summary

    table = read_totals(args.totals)
    if args.output not in (None, "-"):
        refuse_inputs(args.output, [args.totals, *table.totals])
    found = programs_of(table, args.robot)
    print_diagnostics(found.told)
    tool = None if found.tool is None else tuple(float(v) for v in found.tool.xyz_angles())
    signature = signature_of_totals(found.totals, found.robot, table.path, table.sha256, tool)
    write_signature(signature, args.output)
    if args.output not in (None, "-"):
        print("\n".join(summary(signature)))
        totals = found.totals
        print(f"{len(totals.total)} totals of {len(totals.owner)} straight moves from stop to stop")
        if not math.isnan(found.scatter):
            print(f"cycles of one program scatter by {found.scatter:.3f} s")
    return 0
