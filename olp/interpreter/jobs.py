"""Finds the routines that a program calls: in its own file, then beside it, by job name or file name."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, field, replace
from pathlib import Path

from olp.control import ControlFlow, pair
from olp.diagnostic import Diagnostic, OlpError
from olp.expression import Number
from olp.interpreter.folder import files_by_name_record, files_by_stem, read_cached
from olp.interpreter.regions import Region
from olp.points import PointTable
from olp.program import Program, Routine, Statement
from olp.source import Source


@dataclass(slots=True)
class Job:
    """A routine ready to run. `key` tells routines apart, `source` is the index of its file in the plan."""

    program: Program
    routine: Routine
    key: int
    source: int
    body: tuple[Statement, ...]
    points: PointTable
    loaded: bool = False  # its mechanisms and its global positions are known
    groups: tuple[tuple[int, ...], ...] = ()  # mechanism indices per control group
    roles: dict[tuple[int, str], int] = field(default_factory=dict)  # (part, kind of target) -> mechanism
    regions: dict[tuple[int, int], Region] = field(default_factory=dict)  # loops met, by head and way back
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
    _read_files: set[Path] = field(default_factory=set)

    def __post_init__(self) -> None:
        if self.folder is not None and self.program.path:
            self._read_files.add(self.folder / Path(self.program.path).name)
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
        files = files_by_stem(self.folder, Path(self.program.path).suffix) if self.folder is not None else {}
        return difflib.get_close_matches(_key(name), {*self._jobs, *files}, n=3, cutoff=0.5)

    def _add(self, program: Program, file_name: str = "") -> None:
        source = len(self.sources)
        self.sources.append(program.source)
        for routine in program.routines:
            job = Job(program, routine, len(self._jobs), source, routine.body, _points(routine))
            self._jobs.setdefault(_key(routine.name), job)
        if file_name and program.routines:
            self._jobs.setdefault(file_name, self._jobs[_key(program.routines[0].name)])

    def _read(self, key: str) -> None:
        """Reads the file called like the job, else the one whose head names it."""
        if self.folder is None:
            return
        suffix = Path(self.program.path).suffix
        path = files_by_stem(self.folder, suffix).get(key) or files_by_name_record(self.folder, suffix).get(
            key
        )
        if path is None or path in self._read_files:
            return
        self._read_files.add(path)
        try:
            program = read_cached(path)
        except OlpError as problem:
            self.found.extend(problem.diagnostics)
            return
        self.found.extend(program.diagnostics)
        self._add(program, _key(path.stem))


def _points(routine: Routine) -> PointTable:
    """The routine's positions; user coordinates of a relative routine stand in its own frame."""
    frame, table = routine.relative_to, routine.points
    if frame is None or frame.kind != "user" or not isinstance(frame.number, Number):
        return table
    user = int(frame.number.value)
    if all(state.user == user for state in table.states if state.frame == "user"):
        return table
    return PointTable(
        tuple(replace(s, user=user) if s.frame == "user" else s for s in table.states), table.blocks
    )


def _key(name: str) -> str:
    return name.strip().upper()
