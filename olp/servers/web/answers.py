"""What the page asks, answered as the command line answers it: the cell, a program's page, two versions, what if.

The process answers one request after the other: python web_worker.py < requests > answers. The first message is a
`WorkerSetting`; each further one names what is asked and its arguments. An answer is {"answer": …} or {"diagnostics":
[…]}. Codes: Z005 out of memory, Z006 wrong arguments, Z008 unexpected.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import sys
import traceback
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from olp.core.diagnostic import OlpError, error
from olp.core.files import from_os_error, parse_json
from olp.servers.confinement import CommandLine, as_json, close_in, limit_memory, prepare
from olp.servers.web.desk import DROPPED, Desk, WorkerSetting, diagnosed, packed, received

if TYPE_CHECKING:
    from olp.checks.what_if import LineEdit, WhatIf
    from olp.core.source import Source
    from olp.identification.timing_job import TimingJob
    from olp.ir.program import Program
    from olp.reports.formats.report import ReportPart
    from olp.timing.result import Timing


_COSTLIEST = 10  # lines of the cell, as `olp time FOLDER` lists
_TOLD = 200  # diagnostics of one answer


# --- The cell ---


def cell(desk: Desk, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the table of `olp time FOLDER`; {} where no file has changed since the answer with the stamp `known`."""
    from olp.languages.vendor import program_files
    from olp.reports.batch import Job, time_files
    from olp.reports.formats.report import Options

    stamp = _stamp(desk)
    if given.get("known") == stamp:
        return {}
    paths = [str(path) for path in program_files(["."])]
    job = Job(**asdict(desk.setting.job), options=Options(segments=False, top=_COSTLIEST))
    # Processes that are started anew would not be closed in; copies of this one are.
    workers = 0 if multiprocessing.get_start_method() == "fork" else 1
    parts = time_files(paths, job, workers)
    return {"stamp": stamp, **cell_table(parts)}


def _stamp(desk: Desk) -> str:
    return folder_stamp([Path("."), *map(Path, desk.setting.also)])


def folder_stamp(places: Sequence[Path]) -> str:
    """Stamp that changes with any file of the folder: from names, sizes and modification times, without opening a
    file.
    """
    digest = hashlib.sha256()
    for place in places:
        for folder, inner, names in os.walk(place):
            inner[:] = sorted(name for name in inner if name != ".git")
            _stamp_files(digest.update, folder, sorted(names))
        _stamp_files(digest.update, "", [str(place)])
    return digest.hexdigest()


def _stamp_files(update: Callable[[bytes], None], folder: str, names: Sequence[str]) -> None:
    for name in names:
        try:
            status = os.stat(os.path.join(folder, name))
        except OSError:
            continue
        update(repr((folder, name, status.st_mtime_ns, status.st_size)).encode("utf-8", "replace"))


def cell_table(parts: Sequence[ReportPart]) -> dict[str, Any]:
    """Return the rows in the order of `olp time`, called programs below their caller, and totals over the started
    programs.
    """
    from olp.reports.batch import shown
    from olp.reports.cell import ProgramCost, cell_tree, spelled_time, told_branches
    from olp.reports.formats._table import at_least
    from olp.timing.causes import CAUSES

    order = cell_tree(parts)
    first = [parts[row.index] for row in order if row.depth == 0]
    total = sum(part.total_s or 0.0 for part in first)
    cost = sum((part.cost for part in first if part.cost is not None), ProgramCost())
    return {
        "programs": [{**_program(parts[row.index]), "depth": row.depth} for row in order],
        "started": len(first),
        "total_s": total,
        "spelled": spelled_time(total),
        "partial": any(part.is_partial for part in parts),
        "by_cause": dict(zip(CAUSES, cost.by_cause, strict=True)),
        "lines": [{**asdict(line), "cause": line.cause} for line in cost.lines[:_COSTLIEST]],
        "branches": [
            f"{part.file}: {told}" for part in first for told in told_branches(part.branches, at_least)
        ],
        "diagnostics": [as_json(d) for d in shown(parts)[:_TOLD]],
    }


def _program(part: ReportPart) -> dict[str, Any]:
    names = ("file", "robot", "total_s", "motion_s", "wait_s", "io_s", "assumed")
    problems = sum(d.is_error for d in part.diagnostics)
    return {**{n: getattr(part, n) for n in names}, "partial": part.is_partial, "problems": problems}


# --- Versions ---


def compare(desk: Desk, given: Mapping[str, Any]) -> dict[str, Any]:
    """`olp diff OLD NEW` of two files, or of the file `new` against git's HEAD where `old` is empty."""
    new = desk.file(given, "new")
    old = desk.file(given, "old") if given.get("old") else ""
    versions = [old, new] if old else ["HEAD", ".", new]
    words = ("--all", "--format=json", *desk.setting.words)
    found: dict[str, Any] = parse_json(desk.ran("diff", *words, "--", *versions))
    return found


# --- What if ---


def what_if_lines(desk: Desk, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the lines of a program that can be changed, and their present times [s]."""
    from olp.checks.what_if import editable_lines, seconds_by_line
    from olp.runtime.plan import leaves_open

    program, timing = _timed(desk, desk.file(given))
    seconds = seconds_by_line(timing)
    rows = [{**one._asdict(), "seconds": seconds.get(one.line)} for one in editable_lines(program)]
    rate = desk.setting.job.override
    return {
        "lines": rows,
        "total_s": timing.total_s,
        "partial": any(map(leaves_open, timing.diagnostics)),
        "override": 100.0 if rate is None else 100.0 * rate,
        "digest": _digest(program),
        "diagnostics": [as_json(d.at(program.path)) for d in timing.diagnostics[:_TOLD]],
    }


def what_if_times(desk: Desk, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the times [s] with the requested changes, in total and per line. No file is written."""
    from olp.checks.what_if import seconds_by_line
    from olp.identification.timing_job import time_program

    program, timing = _timed(desk, desk.file(given))
    edited = _edited(program, given)
    after = time_program(edited.program, _with_override(desk.setting.job, given), Path(program.path).parent)
    told = [*edited.notes, *(d for d in after.diagnostics if d not in timing.diagnostics)]
    return {
        "total_s": after.total_s,
        "before_s": timing.total_s,
        "seconds": seconds_by_line(after),
        "diagnostics": [as_json(d.at(program.path)) for d in told[:_TOLD]],
    }


def what_if_files(desk: Desk, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the edited files for a download: name -> content as hexadecimal digits."""
    program, _ = _timed(desk, desk.file(given))
    edited = _edited(program, given)
    return {Path(one.path).name: one.raw.hex() for one in edited.sources or (program.source,)}


def page(desk: Desk, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the page of `olp report` about a program on the disk, with the requested changes if there are some."""
    file = desk.file(given)
    job = _with_override(desk.setting.job, given)
    words = [*desk.setting.words]
    if job.override is not None and job.override != desk.setting.job.override:
        words.append(f"--override={100.0 * job.override!r}")
    sources: Sequence[Source] = ()
    if given.get("changes"):
        sources = _edited(_timed(desk, file)[0], given).sources
    title = f"--title={Path(file).name}{', what if' if sources else ''}"
    with _in_place_of_files(sources):
        return {"html": desk.page("report", title, *words, file, "-o")}


@contextmanager
def _in_place_of_files(sources: Sequence[Source]) -> Generator[None]:
    """Use these texts in place of their files while the context lasts."""
    from olp.core.source import drop, put

    for one in sources:
        put(one.path, one.raw.decode(one.encoding, "surrogateescape").encode("utf-8", "surrogateescape"))
    try:
        yield
    finally:
        for one in sources:
            drop(one.path)


def _timed(desk: Desk, file: str) -> tuple[Program, Timing]:
    """Return the program on the disk and its times; those of the last request while no file has changed."""
    from olp.identification.timing_job import time_program
    from olp.languages.vendor import read

    key = file, _stamp(desk)
    if desk.timed is None or desk.timed[0] != key:
        program = read(file, encoding=desk.setting.job.encoding)
        desk.timed = key, program, time_program(program, desk.setting.job)
    return desk.timed[1:]


def _digest(program: Program) -> str:
    return hashlib.sha256(b"\0".join(one.raw for one in (program.source, *program.companions))).hexdigest()


def _edited(program: Program, given: Mapping[str, Any]) -> WhatIf:
    """Raises OlpError: Z006 for wrong arguments, Z011 for a file that is another one by now, and of `what_if`."""
    from olp.checks.what_if import what_if

    if given.get("digest") != _digest(program):
        says = "this file has changed since its lines were shown"
        raise OlpError(error("Z011", says, file=program.path, help="reload the page"))
    return what_if(program, _changes(given.get("changes", [])))


_CHANGE: Mapping[str, tuple[type, ...]] = {"line": (int,), "speed": (int, float, type(None)), "zone": (int,)}


def _changes(rows: Any) -> list[LineEdit]:
    """The requested changes. Raises OlpError (Z006) with all invalid ones."""
    from olp.checks.what_if import LineEdit

    if not isinstance(rows, list):
        raise OlpError(error("Z006", "changes: must be a list"))
    help = 'such as {"line": 12, "speed": 250, "zone": 1}'
    problems = [
        error("Z006", f"this is no change: {str(row)[:80]}", help=help) for row in rows if not _is_change(row)
    ]
    if problems:
        raise OlpError(*problems[:_TOLD])
    return [LineEdit(row["line"], row.get("speed"), row.get("zone", 0)) for row in rows]


def _is_change(row: Any) -> bool:
    return (
        isinstance(row, dict)
        and {"line"} <= row.keys() <= _CHANGE.keys()
        and not any(isinstance(value, bool) or not isinstance(value, _CHANGE[n]) for n, value in row.items())
    )


def _with_override(job: TimingJob, given: Mapping[str, Any]) -> TimingJob:
    """Return the job with the request's program override [%], if there is one. Raises OlpError (Z006)."""
    percent = given.get("override")
    if percent is None:
        return job
    if isinstance(percent, bool) or not isinstance(percent, int | float) or not 0.0 < percent <= 1000.0:
        raise OlpError(error("Z006", f"override: {percent!r} is no percentage above zero"))
    return replace(job, override=percent * 1e-2)


def diagnose(desk: Desk, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the diagnosis of the files that were dropped on the page. Runs in a worker of its own, because it
    changes the current folder.
    """
    job = str(desk.setting.folder / desk.file(given, "job")) if given.get("job") else ""
    # What is told then names the files as they came, not by where they lie meanwhile.
    os.chdir(desk.temporary)
    return diagnosed(desk, Path(DROPPED), job)


ANSWERS: dict[str, Callable[[Desk, Mapping[str, Any]], dict[str, Any]]] = {
    "cell": cell,
    "compare": compare,
    "what_if_lines": what_if_lines,
    "what_if_times": what_if_times,
    "what_if_files": what_if_files,
    "page": page,
    "diagnose": diagnose,
}


def answered(desk: Desk, request: dict[str, Any]) -> bytes:
    """Return the answer to a request as a message. Never raises."""
    try:
        return packed({"answer": ANSWERS[request["ask"]](desk, request["given"])})
    except OlpError as refused:
        found = list(refused.diagnostics)
    except OSError as problem:
        found = [from_os_error(problem)]
    except (MemoryError, RecursionError):
        says = "this is too large: memory is at its end"
        found = [error("Z005", says, help="ask about fewer or smaller programs")]
    except Exception as problem:
        traceback.print_exc()
        says = f"olp failed in a way that it does not know ({type(problem).__name__})"
        found = [error("Z008", says, help="the terminal of olp serve has the details")]
    return packed({"diagnostics": [as_json(d) for d in found]})


def main(command_line: CommandLine) -> None:
    """Answer requests until standard input ends. Other prints go to standard error."""
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    setting = WorkerSetting.from_json(received(sys.stdin.buffer))
    root, temporary = Path(setting.root), Path(setting.temporary)
    limit_memory(setting.memory)
    prepare(root, temporary)
    close_in(root, temporary, False, setting.file, [Path(path) for path in setting.also])
    desk = Desk(setting, temporary, command_line)
    while (request := received(sys.stdin.buffer)) is not None:
        out.write(answered(desk, request))
        out.flush()
