"""`olp vendors`: which statements each robot language reads, writes and is translated into."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from olp.core.files import write_output

SUMMARY = "list the robot languages, and what of each is read and written"
_LEGEND = """r read, w written exactly, ~ written with an approximation, - not at all
time: what such a statement adds to a program's time; a process instruction what olp.toml says, else nothing"""
_TIMES = {"move": "move", "wait": "wait", "signal": "I/O"}


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("--format", choices=("text", "json"), default="text", help="(default: text)")
    parser.add_argument("-o", "--output", metavar="FILE", help="write there (default: standard output)")


def run(args: Namespace) -> int:
    text = _json() if args.format == "json" else _text()
    write_output(args.output, text)
    return 0


def _text() -> str:
    from olp.ir.terminology import STATEMENTS
    from olp.languages.vendor import find_vendor, vendor_names
    from olp.transpile.support import support, timed_as

    names = vendor_names()
    table = support()
    lines = [
        f"{name:<10} {find_vendor(name).title} ({' '.join(find_vendor(name).suffixes)})" for name in names
    ]
    width = max(len(STATEMENTS[kind]) for kind in table)
    lines += ["", f"{'statement':<{width}}  time" + "".join(f"{name:>10}" for name in names)]
    for kind, row in table.items():
        cells = (_cell(row[name].reads, row[name].writes) for name in names)
        head = f"{STATEMENTS[kind]:<{width}}  {_TIMES.get(timed_as(kind), ''):<4}"
        lines.append(head + "".join(f"{cell:>10}" for cell in cells))
    return "\n".join([*lines, "", _LEGEND, ""])


def _cell(reads: bool, writes: str) -> str:
    return ("r" if reads else "") + {"exact": "w", "approximated": "~"}.get(writes, "") or "-"


def _json() -> str:
    import json

    from olp.languages.vendor import find_vendor, vendor_names
    from olp.transpile.support import kinds, support, timed_as

    document = {
        "vendors": {
            name: {"title": find_vendor(name).title, "suffixes": list(find_vendor(name).suffixes)}
            for name in vendor_names()
        },
        "statements": {
            kind: {name: {"reads": it.reads, "writes": it.writes or None} for name, it in row.items()}
            for kind, row in support().items()
        },
        "times": {kind: timed_as(kind) or None for kind in kinds()},
    }
    return json.dumps(document, indent=2) + "\n"
