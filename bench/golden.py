"""Golden run: keeps what olp prints and writes for many programs, so that two versions of olp can be compared.

`python bench/golden.py run OUT [FOLDER …]` runs every command that shows or writes a program, in this process, over
`samples/` and over the programs in the folders. `python bench/golden.py compare OLD NEW` prints which outputs of two
such runs differ, the first ones as a diff, and ends with status 1 when any does.

OUT/index.tsv has one line per output: program, operation, sha256 of the bytes, sha256 of the problems' text; OUT/texts/
holds each text under its sha256. The programs come from folders, the languages and their suffixes from `olp vendors`,
the robots from `olp robots`: nothing here knows a vendor's name. The olp that runs is the one that Python imports, and
the samples are those beside it, so that `PYTHONPATH` chooses the version.
"""

from __future__ import annotations

import datetime
import hashlib
import io
import json
import os
import shutil
import sys
import tempfile
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from difflib import unified_diff
from functools import partial
from pathlib import Path
from typing import NamedTuple, TypeAlias
from unittest.mock import patch

import olp
from olp.__main__ import main as run_olp

ROOT = Path(olp.__file__).parents[1]
SOURCE, TEXTS, INDEX = "samples", "texts", "index.tsv"
LARGEST = 48_000  # bytes of a program; larger ones are read and written back only
STEPS = "20000"  # statements that a program may run
COMMENTED = "with robots, losses as comments"
Key: TypeAlias = tuple[str, str]  # program, operation


class Output(NamedTuple):
    """What one operation gave: `data` as written, `problems` as text, with the exit status where there is one."""

    data: bytes
    problems: str


Operation: TypeAlias = tuple[Key, Callable[[], Output]]


class Language(NamedTuple):
    """What `olp vendors` and `olp robots` say. `robot`: the last of the maker's, for all programs."""

    suffixes: tuple[str, ...]
    writable: bool
    robot: str


class Fixed(datetime.datetime):
    """A clock that stands: some languages write the date into the program."""

    @classmethod
    def now(cls, tz: datetime.tzinfo | None = None) -> Fixed:
        return cls(2001, 2, 3, 4, 5, 6, tzinfo=tz)


def main(words: list[str]) -> int:
    parser = ArgumentParser(prog="bench/golden.py", description="keep and compare the outputs of olp")
    commands = parser.add_subparsers(dest="command", required=True)
    runs = commands.add_parser("run", help="run all operations and keep what they give")
    runs.add_argument("out", type=Path, metavar="OUT", help="the folder for the outputs, made anew")
    runs.add_argument("folders", nargs="*", type=Path, metavar="FOLDER", help="with further programs")
    runs.add_argument(
        "--sample", type=int, default=1, metavar="N", help="every Nth program of samples and folders"
    )
    runs.add_argument("--only", default="", metavar="WORD", help="only operations whose name has this in it")
    compares = commands.add_parser("compare", help="compare two runs")
    compares.add_argument("old", type=Path, metavar="OLD")
    compares.add_argument("new", type=Path, metavar="NEW")
    compares.add_argument("--show", type=int, default=5, metavar="N", help="differences to print as a diff")
    args = parser.parse_args(words)
    return compare(args.old, args.new, args.show) if args.command == "compare" else run(args)


def run(args: Namespace) -> int:
    """Runs all operations over all programs and keeps what they give in the folder `args.out`."""
    began = time.perf_counter()
    shutil.rmtree(args.out, ignore_errors=True)
    (args.out / TEXTS).mkdir(parents=True)
    out = args.out.resolve()
    folders = [folder.resolve() for folder in args.folders]
    os.chdir(ROOT)
    os.environ["COLUMNS"] = "100"  # argparse wraps help at the width of the terminal
    found = languages()
    count = 0
    with open(out / INDEX, "w", encoding="utf-8", newline="\n") as index, patch("datetime.datetime", Fixed):
        for (program, operation), make in operations(found, folders, args.sample):
            if args.only not in operation:
                continue
            output = guarded(make, folders)
            shas = (keep(out, output.data), keep(out, output.problems.encode("utf-8", "surrogateescape")))
            print(program, operation, *shas, sep="\t", file=index, flush=True)
            count += 1
    print(f"{count} outputs of olp in {ROOT} kept in {out}, {time.perf_counter() - began:.0f} s")
    return 0


def languages() -> dict[str, Language]:
    """All languages that olp reads, by name."""
    document = json.loads(olp_command("vendors", "--format", "json").data)
    writes = {name for row in document["statements"].values() for name, cell in row.items() if cell["writes"]}
    robots = olp.robot_names()
    return {
        name: Language(tuple(row["suffixes"]), name in writes, robot_for(row["title"], robots))
        for name, row in document["vendors"].items()
    }


def robot_for(title: str, robots: tuple[str, ...]) -> str:
    """The last robot of the maker that a language's title names, else the last of all."""
    maker = title.rsplit(" ", 1)[0].lower().replace(" ", "-")
    return next((name for name in reversed(robots) if name.split("/")[0] == maker), robots[-1])


def operations(found: dict[str, Language], folders: list[Path], sample: int) -> Iterator[Operation]:
    """Everything that is run, in a fixed order: its name, and what runs it."""
    yield from general()
    for name, path in programs(found, folders, sample):
        yield from of_program(name, path, found)


def general() -> Iterator[Operation]:
    """What needs no program: tables and help."""
    yield ("-", "vendors"), partial(olp_command, "vendors")
    yield ("-", "vendors json"), partial(olp_command, "vendors", "--format", "json")
    yield ("-", "robots"), partial(olp_command, "robots", "-v")
    yield ("-", "lint rules"), partial(olp_command, "lint", "--rules")
    yield ("-", "help"), partial(olp_command, "--help")
    listed = olp_command("--help").data.decode().split("commands:\n")[1].split("\n\n")[0].splitlines()
    for name in (line.strip().split("  ")[0] for line in listed):
        yield ("-", f"help {name}"), partial(olp_command, *name.split(), "--help")


def programs(found: dict[str, Language], folders: list[Path], sample: int) -> Iterator[tuple[str, Path]]:
    """Every Nth program of the samples and of each folder: the name that the index gives it, and its path."""
    suffixes = tuple({suffix for language in found.values() for suffix in language.suffixes})
    for path in programs_below(Path(SOURCE), suffixes)[::sample]:
        yield path.as_posix(), path
    for folder in folders:
        for path in programs_below(folder, suffixes)[::sample]:
            yield f"{folder.name}/{path.relative_to(folder).as_posix()}", path


def programs_below(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    """Files with these suffixes, links left out, in a fixed order."""
    every = (p for p in folder.rglob("*") if p.is_file() and not p.is_symlink())
    return sorted(path for path in every if path.name.lower().endswith(suffixes))


def of_program(name: str, path: Path, found: dict[str, Language]) -> Iterator[Operation]:
    """What is run over one program."""
    yield (name, "read"), partial(read_back, path)
    if path.stat().st_size > LARGEST:
        return
    own = next((o.robot for o in found.values() if path.name.lower().endswith(o.suffixes)), "")
    robot, bounded = ("--robot", own), ("--max-steps", STEPS, "--workers", "1")
    timed = olp_command("time", path, "--format", "json", *robot, *bounded)
    yield (name, "time"), lambda: timed
    yield (name, "lint"), partial(olp_command, "lint", path, *robot, *bounded)
    yield (name, "annotate"), partial(annotated_and_back, path, robot)
    for target, language in found.items():
        if not language.writable:
            continue
        yield (name, f"export {target}"), partial(olp_command, "export", path, "--to", target)
        if f"stopped after {STEPS}" in timed.problems:
            continue  # `olp convert` runs programs for longer, several times
        yield (name, f"convert {target}"), partial(converted, path, target)
        options = ("--on-loss", "comment", *robot, "--target-robot", language.robot)
        yield (name, f"convert {target} {COMMENTED}"), partial(converted, path, target, *options)


def read_back(path: Path) -> Output:
    """The program as olp writes it back, and its diagnostics."""
    program = olp.read(path)
    return Output(program.to_bytes(), "\n\n".join(found.render() for found in program.diagnostics))


def annotated_and_back(path: Path, options: tuple[str, ...]) -> Output:
    """The annotated program, behind it what is left when the annotation is removed."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / path.name
        for beside in path.parent.iterdir():
            if beside.is_file() and beside.stat().st_size <= LARGEST:
                shutil.copyfile(beside, Path(folder) / beside.name)
        added = olp_command("annotate", target, "--in-place", *options, "--max-steps", STEPS)
        annotated = target.read_bytes()
        removed = olp_command("annotate", "--remove", target, "--in-place")
        data = annotated + b"\n----- removed -----\n" + target.read_bytes()
        return Output(data, (added.problems + removed.problems).replace(folder, "FOLDER"))


def converted(path: Path, target: str, *options: str) -> Output:
    """All files that `olp convert` writes, its receipt as text and as JSON."""
    with tempfile.TemporaryDirectory() as folder:
        out, receipt = Path(folder, "out"), Path(folder, "receipt.json")
        shown = olp_command("convert", path, "--to", target, "-o", out, "--receipt", receipt, *options)
        parts = [shown.data.replace(folder.encode(), b"FOLDER")]
        if receipt.exists():
            parts += [receipt.read_bytes().replace(folder.encode(), b"FOLDER")]
        if out.exists():
            for file in sorted(out.iterdir()):
                parts += [f"\n----- {file.name} -----\n".encode(), file.read_bytes()]
        return Output(b"".join(parts), shown.problems.replace(folder, "FOLDER"))


def olp_command(*words: str | Path) -> Output:
    """What a command line prints, and its exit status."""
    with captured() as (out, told):
        status = run_olp([str(word) for word in words])
    return Output(out.getvalue(), f"{told.getvalue().decode('utf-8')}\nexit status {status}\n")


@contextmanager
def captured() -> Iterator[tuple[io.BytesIO, io.BytesIO]]:
    """The two output streams, as bytes."""
    out, told = io.BytesIO(), io.BytesIO()
    kept = sys.stdout, sys.stderr
    sys.stdout = io.TextIOWrapper(out, "utf-8", errors="replace", newline="\n", write_through=True)
    sys.stderr = io.TextIOWrapper(told, "utf-8", errors="replace", newline="\n", write_through=True)
    try:
        yield out, told
        sys.stdout.flush()
        sys.stderr.flush()
    finally:
        # A wrapper closes its stream when it goes.
        sys.stdout.detach()
        sys.stderr.detach()
        sys.stdout, sys.stderr = kept


def guarded(make: Callable[[], Output], folders: list[Path]) -> Output:
    """What an operation gives; an exception is kept as a problem. Folders' paths are taken out of both."""
    try:
        output = make()
    except Exception as crash:
        output = Output(b"", f"{type(crash).__name__}: {crash}\n")
    data, problems = output
    for folder in folders:
        data, problems = (
            data.replace(str(folder).encode(), b"FOLDER"),
            problems.replace(str(folder), "FOLDER"),
        )
    return Output(data, problems)


def keep(out: Path, data: bytes) -> str:
    """Writes the text under its sha256, which is returned."""
    sha = hashlib.sha256(data).hexdigest()
    file = out / TEXTS / sha
    if not file.exists():
        file.write_bytes(data)
    return sha


def compare(old: Path, new: Path, show: int) -> int:
    """Prints which outputs differ, per operation how many, and the first ones as a diff. Status 1 when any does."""
    before, after = read_index(old), read_index(new)
    both = [key for key in before if key in after]
    differ = [key for key in both if before[key] != after[key]]
    for key in differ[:show]:
        for part, one, other in zip(("output", "problems"), before[key], after[key], strict=True):
            print_difference(f"{key[0]}: {key[1]}: {part}", text(old, one), text(new, other))
    for operation in sorted({key[1] for key in differ}):
        print(f"{sum(key[1] == operation for key in differ):6d} differ: {operation}")
    for name, missing in ((old, before.keys() - after.keys()), (new, after.keys() - before.keys())):
        if missing:
            print(f"{len(missing)} outputs only in {name}, such as {' '.join(min(missing))}")
    print(f"{len(both)} outputs compared, {len(differ)} differ")
    return 1 if differ or not both else 0


def print_difference(title: str, old: list[str], new: list[str]) -> None:
    """A diff of at most 40 lines."""
    lines = list(unified_diff(old, new, f"old {title}", f"new {title}", lineterm="", n=1))
    print("\n".join([*lines[:40], *([f"… {len(lines) - 40} lines more"] if len(lines) > 40 else []), ""]))


def text(folder: Path, sha: str) -> list[str]:
    """A kept text, line by line."""
    return (folder / TEXTS / sha).read_bytes().decode("utf-8", "backslashreplace").splitlines()


def read_index(folder: Path) -> dict[Key, tuple[str, str]]:
    """What `run` kept: per program and operation the two hashes."""
    rows = (line.split("\t") for line in (folder / INDEX).read_text(encoding="utf-8").splitlines())
    return {(program, operation): (data, problems) for program, operation, data, problems in rows}


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
