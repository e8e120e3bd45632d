"""Finds the routines that a program calls: in its own file, then beside it, by job name or file name."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from olp.control import ControlFlow, pair
from olp.diagnostic import Diagnostic, OlpError
from olp.program import Program, Routine, Statement
from olp.source import Source

# A name stands in the first lines of a file; reading more of 10,000 files to find one job would take seconds.
_HEAD = 4096


@dataclass(slots=True)
class Job:
    """A routine ready to run. `key` tells routines apart, `source` is the index of its file in the plan."""

    program: Program
    routine: Routine
    key: int
    source: int
    body: tuple[Statement, ...]
    loaded: bool = False  # its mechanisms and its global positions are known
    groups: tuple[tuple[int, ...], ...] = ()  # mechanism indices per control group
    roles: dict[tuple[int, str], int] = field(default_factory=dict)  # (part, kind of target) -> mechanism
    _flow: ControlFlow | None = None

    @property
    def flow(self) -> ControlFlow:
        """Where blocks and labels are; straight jobs never ask."""
        if self._flow is None:
            self._flow = pair(self.body)
        return self._flow


@dataclass(slots=True)
class Jobs:
    """All routines met so far. `sources` grows with each file; `found` are the files' own diagnostics."""

    program: Program
    folder: Path | None
    sources: list[Source] = field(default_factory=list)
    found: list[Diagnostic] = field(default_factory=list)
    _jobs: dict[str, Job] = field(default_factory=dict)
    _files: dict[str, Path] | None = None

    def __post_init__(self) -> None:
        self._add(self.program)

    def main(self) -> Job | None:
        """The first routine of the program."""
        if not self.program.routines:
            return None
        return self._jobs[_key(self.program.routines[0].name)]

    def find(self, name: str) -> Job | None:
        """The routine called `name`, None when there is none in the program or its folder."""
        key = _key(name)
        job = self._jobs.get(key)
        if job is None:
            self._read(key)
            job = self._jobs.get(key)
        return job

    def near(self, name: str) -> list[str]:
        """Names that `name` may have meant."""
        known = {**{key: key for key in self._jobs}, **{key: key for key in self._folder()}}
        return difflib.get_close_matches(_key(name), known, n=3, cutoff=0.5)

    def _add(self, program: Program, file_name: str = "") -> None:
        source = len(self.sources)
        self.sources.append(program.source)
        for routine in program.routines:
            job = Job(program, routine, len(self._jobs), source, routine.body)
            self._jobs.setdefault(_key(routine.name), job)
        if file_name and program.routines:
            self._jobs.setdefault(file_name, self._jobs[_key(program.routines[0].name)])

    def _read(self, key: str) -> None:
        """Reads the file called like the job, else the one whose head names it."""
        files = self._folder()
        path = files.get(key)
        if path is None:
            path = next((file for file in files.values() if key in _names(file)), None)
        if path is None:
            return
        from olp.reading import read

        try:
            program = read(path)
        except OlpError as problem:
            self.found.extend(problem.diagnostics)
            return
        self.found.extend(program.diagnostics)
        self._add(program, _key(path.stem))

    def _folder(self) -> dict[str, Path]:
        """The program files beside the job by upper-case stem."""
        if self._files is None:
            self._files = dict(_program_files(self.folder, Path(self.program.path))) if self.folder else {}
        return self._files


def _key(name: str) -> str:
    return name.strip().upper()


def _program_files(folder: Path, main: Path) -> Iterator[tuple[str, Path]]:
    suffix = main.suffix.lower()
    try:
        with os.scandir(folder) as entries:
            names = sorted(entry.name for entry in entries if entry.is_file())
    except OSError:
        return
    for name in names:
        path = folder / name
        if path.suffix.lower() == suffix and path.name != main.name:
            yield _key(path.stem), path


def _names(path: Path) -> set[str]:
    """Upper-case words after a name record in the head of a file."""
    try:
        with open(path, "rb") as file:
            head = file.read(_HEAD)
    except OSError:
        return set()
    lines = head.decode("latin-1").upper().splitlines()
    return {line.split(None, 1)[1].strip() for line in lines if line.startswith("//NAME ") and len(line) > 7}
