"""`olp convert`: a program in another robot's language, with a receipt of what was kept and what was changed."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from olp.cli._timing import print_diagnostics
from olp.core.diagnostic import Diagnostic, OlpError, Severity, error
from olp.core.files import from_os_error

if TYPE_CHECKING:
    from olp.transpile.compare import Tolerances
    from olp.transpile.context import Context
    from olp.transpile.link import Whole
    from olp.transpile.receipt import Receipt

ACCEPTABLE = ("named", "left-out", "uncompared")
SUMMARY = "translate a program into another robot's language, with a receipt"


def add_arguments(parser: ArgumentParser) -> None:
    from olp.languages.limits import writable

    parser.add_argument("jobs", nargs="+", metavar="JOB", help="a program, or a folder of programs")
    parser.add_argument(
        "--to", required=True, metavar="VENDOR", help=f"the language to write, such as {writable()[1]}"
    )
    parser.add_argument(
        "-o", "--output", required=True, metavar="DIR", help="the folder for the new program's files"
    )
    parser.add_argument("--robot", metavar="R", help="the robot that the program was written for")
    parser.add_argument(
        "--target-robot", metavar="R", help="the robot that it is written for (default: the same)"
    )
    parser.add_argument(
        "--map", metavar="FILE.toml", help="which tools, frames and signals of the target the source's are"
    )
    parser.add_argument("--receipt", metavar="FILE.json", help="write the receipt there, too")
    parser.add_argument(
        "--on-loss",
        choices=("error", "comment"),
        default="error",
        help="what becomes of a statement that the target cannot express, and of a called routine with an error "
        "(default: error)",
    )
    parser.add_argument(
        "--flat",
        action="store_true",
        help="write what the program does, move after move, instead of the program",
    )
    parser.add_argument(
        "--plain",
        action="store_true",
        help="write moves as plain statements where the target's pendant has forms",
    )
    parser.add_argument(
        "--accept",
        action="append",
        default=[],
        choices=ACCEPTABLE,
        help="end with 0 all the same where the runs differ as the receipt names it, where statements are left out, or "
        "where the runs could not be compared to their end (may be given again)",
    )
    parser.add_argument(
        "--tolerance",
        action="append",
        default=[],
        metavar="WHAT=N",
        help="what may differ: position, blend [mm], orientation [deg], speed [percent], wait [s]",
    )
    parser.add_argument("--encoding", metavar="E", help="of the programs that are read (default: guessed)")
    parser.add_argument("--to-encoding", metavar="E", help="of the new program (default: the old one's)")
    parser.add_argument("--force", action="store_true", help="write over files of the folder")


def run(args: Namespace) -> int:
    from olp.core.files import write_output
    from olp.languages.limits import refuse_unwritable
    from olp.languages.vendor import program_files
    from olp.transpile.dead_code import DATA_ALONE
    from olp.transpile.receipt_text import as_text

    refuse_unwritable(args.to)
    jobs = program_files(args.jobs)
    told: list[Diagnostic] = []
    parts = _wholes(jobs, args, told)
    context = replace(_context(args), entry=len(parts) == 1 and not parts[0].others)
    alone: list[Diagnostic] = []  # files of data that the target's programs hold
    made: list[tuple[str, dict[str, bytes]]] = []  # the files of each program
    receipts: list[Receipt] = []
    for part in parts:
        job = part.program.path
        try:
            found, receipt, unconverted = _convert(part, context, args)
        except OlpError as problem:
            found_wrong = [diagnostic.at(job) for diagnostic in problem.diagnostics]
            told += [one for one in found_wrong if one.code != DATA_ALONE]
            alone += [one for one in found_wrong if one.code == DATA_ALONE]
            continue
        told += [d.at(job) for d in part.program.diagnostics if not d.is_error]
        told += unconverted
        made.append((job, found))
        receipts.append(receipt)
    files, receipts, clash = _together(made, receipts)
    others = len(alone) < len(parts)
    told += [replace(one, severity=Severity.WARNING) if others else one for one in alone]
    told += clash
    rejected = any(diagnostic.is_error for diagnostic in told)
    if any(one.is_error for one in clash) or (rejected and not receipts):
        print_diagnostics(told)
        return 2
    _write_all(Path(args.output), files, jobs, args.force)
    if args.receipt:
        write_output(args.receipt, _document(receipts), inputs=jobs)
    write_output(None, "\n".join(map(as_text, receipts)))
    print_diagnostics(told)
    if rejected:
        return 2
    return 0 if all(receipt.verdict.holds(args.accept) for receipt in receipts) else 1


def _together(
    made: list[tuple[str, dict[str, bytes]]], receipts: list[Receipt]
) -> tuple[dict[str, bytes], list[Receipt], list[Diagnostic]]:
    """All files by their names, those of programs that make one name (the tasks of a cell) each in a folder of its own.

    The folder is called as the one that tells the sources apart; where none does, that is an error (C008).
    """
    files: dict[str, bytes] = {}
    clash: dict[str, str] = {}  # name -> the second program that makes it
    for job, found in made:
        for name, data in found.items():
            if files.setdefault(name, data) != data:
                clash.setdefault(name, job)
    if not clash:
        return files, receipts, []
    apart = _folders([job for job, found in made if not clash.keys().isdisjoint(found)])
    told = []
    for name, job in clash.items():
        says = f"two programs that share nothing make the file {name}"
        if apart:
            says += ": each is in a folder of its own, where data of one name are no longer the same"
            help = "load each into the task or controller that runs it"
            told.append(Diagnostic("C008", says, Severity.WARNING, file=job, help=help))
        else:
            help = "translate them one by one, each into a folder of its own"
            told.append(error("C008", says, file=job, help=help))
    files, named = {}, []
    for (job, found), receipt in zip(made, receipts, strict=True):
        before = f"{apart[job]}/" if job in apart else ""
        files |= {f"{before}{name}": data for name, data in found.items()}
        named.append(replace(receipt, files=tuple(f"{before}{name}" for name in receipt.files)))
    return files, named, told


def _folders(jobs: list[str]) -> dict[str, str]:
    """The first folder by which the paths of programs differ, for each; none where it is not one for each."""
    rows = [Path(job).parts for job in jobs]
    at = next((n for n, parts in enumerate(zip(*rows, strict=False)) if len(set(parts)) > 1), None)
    if at is None or any(len(row) <= at + 1 for row in rows):
        return {}
    found = {job: row[at] for job, row in zip(jobs, rows, strict=True)}
    return found if len(set(found.values())) == len(jobs) else {}


def _context(args: Namespace) -> Context:
    from olp.robots.robot import load_robot
    from olp.transpile.context import Context, Mapping, read_mapping

    robot = None if args.robot is None else load_robot(args.robot)
    target = None if args.target_robot is None else load_robot(args.target_robot)
    mapping = Mapping() if args.map is None else read_mapping(args.map)
    return Context(robot, target, mapping, args.on_loss, args.flat, not args.plain)


def _wholes(jobs: list[Path], args: Namespace, told: list[Diagnostic]) -> list[Whole]:
    """The programs that can be read, those that share something together where the target's programs can."""
    from olp.languages.limits import limits_of
    from olp.languages.vendor import read
    from olp.transpile.link import Whole, wholes

    programs = []
    for job in jobs:
        try:
            programs.append(read(job, encoding=args.encoding))
        except OlpError as problem:
            told += [diagnostic.at(str(job)) for diagnostic in problem.diagnostics]
    if len(programs) > 1 and not args.flat and limits_of(args.to).shares_programs:
        return wholes(programs)
    return [Whole(program, ()) for program in programs]


def _convert(
    part: Whole, context: Context, args: Namespace
) -> tuple[dict[str, bytes], Receipt, list[Diagnostic]]:
    """The files, the receipt, and what was wrong in routines that are not converted."""
    from contextlib import ExitStack

    from olp.core.garbage_collection import no_garbage_collection
    from olp.core.result_cache import TextCache, remembering
    from olp.transpile.commented_out import UNCONVERTED, with_texts
    from olp.transpile.convert import convert, runs_of
    from olp.transpile.link import link, with_starts
    from olp.transpile.receipt import receipt_of

    # The translation and its proof run both programs several times, and make many objects.
    with remembering(TextCache()), no_garbage_collection():
        linked = link(part.program, args.to, part.others)
        if args.on_loss == "comment":
            linked = replace(linked, program=with_texts(linked.program, args.to))
        linked = replace(linked, program=with_starts(linked.program))
        try:
            converted = convert(linked.program, args.to, context, encoding=args.to_encoding)
        except OlpError as refused:
            raise OlpError(*map(linked.located, refused.diagnostics)) from None
        robots = (context.robot, context.target_robot)
        names = tuple(converted.files)
        with ExitStack() as lasting:
            runs = runs_of(linked.program, converted, args.to, robots, lasting)
            receipt = receipt_of(
                linked, converted.translated, args.to, names, runs, robots, _tolerances(args.tolerance)
            )
    unconverted = [linked.located(d) for d in linked.program.diagnostics if d.code == UNCONVERTED]
    return converted.files, receipt, unconverted


def _tolerances(given: list[str]) -> Tolerances:
    """Raises OlpError (C017) for what is no tolerance."""
    from olp.core.units import deg, mm, percent
    from olp.transpile.compare import WRITTEN

    units = {"position": mm, "orientation": deg, "speed": percent, "blend": mm, "wait": 1.0}
    found: dict[str, float] = {}
    for text in given:
        name, _, value = text.partition("=")
        try:
            found[{"orientation": "angle"}.get(name, name)] = float(value) * units[name]
        except (KeyError, ValueError):
            known = ", ".join(units)
            raise OlpError(
                error("C017", f"no tolerance: {text}", help=f"such as --tolerance speed=2, of {known}")
            ) from None
    return replace(WRITTEN, **found)


def _write_all(folder: Path, files: dict[str, bytes], inputs: list[Path], force: bool) -> None:
    """All files or none. Raises OlpError for a file that is there already (C009), or that would replace an input."""
    from olp.core.files import refuse_inputs, write_together

    problems = []
    for name in files:
        target = folder / name
        refuse_inputs(target, inputs)
        if target.exists() and not force:
            problems.append(
                error("C009", "this file exists already", file=str(target), help="say --force, or another -o")
            )
    if problems:
        raise OlpError(*problems)
    try:
        for target in {(folder / name).parent for name in files} | {folder}:
            target.mkdir(parents=True, exist_ok=True)
        write_together({folder / name: data for name, data in files.items()})
    except OSError as problem:
        raise OlpError(from_os_error(problem)) from None


def _document(receipts: list[Receipt]) -> str:
    import json

    from olp.transpile.receipt import as_json

    rows = [as_json(receipt) for receipt in receipts]
    return json.dumps(rows[0] if len(rows) == 1 else rows, indent=2, ensure_ascii=False) + "\n"
