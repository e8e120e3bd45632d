"""Finds the routines that a program calls: in its own file, then beside it, by job name or file name."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from olp.core.diagnostic import Diagnostic, OlpError, Severity
from olp.core.source import Source
from olp.ir.block_structure import ControlFlow, pair
from olp.ir.expressions import Number
from olp.ir.points import PointTable
from olp.ir.program import Program, Routine, Statement
from olp.languages.vendor import Vendor, find_vendor
from olp.runtime.end_actions import with_end_actions
from olp.runtime.folder import files_by_name_record, files_by_stem, read_cached
from olp.runtime.memory import Scope
from olp.runtime.regions import Read, Region


@dataclass(slots=True)
class RunnableRoutine:
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
    deciding: dict[int, frozenset[Read]] = field(default_factory=dict)  # by the head: what decides about them
    data: Scope = field(default_factory=dict)  # named variables that keep their values between runs
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
    _jobs: dict[str, RunnableRoutine] = field(default_factory=dict)
    programs: list[Program] = field(default_factory=list)  # by the index of their source
    _own: dict[tuple[int, str], RunnableRoutine] = field(
        default_factory=dict
    )  # (source, name): a file's own routines win
    _read_files: set[Path] = field(default_factory=set)
    _all_read: bool = False

    def __post_init__(self) -> None:
        if self.folder is not None and self.program.path:
            self._read_files.add(self.folder / Path(self.program.path).name)
        self._add(self.program)

    def main(self) -> RunnableRoutine | None:
        """The routine that the program says runs, else its first one."""
        if not self.program.routines:
            return None
        first = self.program.main or self.program.routines[0].name
        return self._jobs.get(_key(first)) or self._jobs[_key(self.program.routines[0].name)]

    def find(self, name: str, source: int = 0) -> RunnableRoutine | None:
        """The routine called `name` by the file `source`, None when there is none in the program or its folder."""
        key = _key(name)
        job = self._own.get((source, key)) or self._jobs.get(key)
        if job is None:
            self._read(key)
            job = self._jobs.get(key)
        if job is None and self.read_all():
            job = self._jobs.get(key)
        return job

    def read_all(self) -> bool:
        """Reads the other files of the folder for what they declare, where the language shares names between files."""
        if self._all_read or self.folder is None or not self.program.path:
            return False
        self._all_read = True
        vendor = find_vendor(self.program.vendor)
        if not vendor.shares_names:
            return False
        before = len(self.programs)
        size = 0
        for path in _files_beside(self.folder, vendor):
            size += path.stat().st_size
            if path in self._read_files or len(self.programs) > _MOST_FILES or size > _MOST_BYTES:
                continue
            self._add_file(path, asked=False)
        return len(self.programs) > before

    def near(self, name: str) -> list[str]:
        """Names that `name` may have meant."""
        files = files_by_stem(self.folder, Path(self.program.path).suffix) if self.folder is not None else {}
        return difflib.get_close_matches(_key(name), {*self._jobs, *files}, n=3, cutoff=0.5)

    def _add(self, program: Program, file_name: str = "") -> None:
        source = len(self.sources)
        self.sources.append(program.source)
        self.programs.append(program)
        for routine in program.routines:
            body = with_end_actions(program.vendor, routine.body)
            job = RunnableRoutine(program, routine, len(self._jobs), source, body, _points(routine))
            self._jobs.setdefault(_key(routine.name), job)
            self._own.setdefault((source, _key(routine.name)), job)
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
        if path is None:
            further = find_vendor(self.program.vendor).folders_with(self.folder)[1:]
            path = next((found for one in further if (found := files_by_stem(one, suffix).get(key))), None)
        if path is not None and path not in self._read_files:
            self._add_file(path)

    def _add_file(self, path: Path, asked: bool = True) -> None:
        """`asked`: a call names it; what is wrong with a file that is only searched for names stops nobody."""
        self._read_files.add(path)
        try:
            program = read_cached(path)
        except OlpError as problem:
            if path.suffix.lower() not in find_vendor(self.program.vendor).list_suffixes:
                self.found.extend(problem.diagnostics)
            return
        if program.vendor != self.program.vendor:
            return  # data of another maker
        wrong = program.diagnostics
        self.found.extend(wrong if asked else (_as_warning(d) for d in wrong))
        self._add(program, _key(path.stem))


def _as_warning(found: Diagnostic) -> Diagnostic:
    return replace(found, severity=Severity.WARNING) if found.is_error else found


def _files_beside(folder: Path, vendor: Vendor) -> Iterator[Path]:
    """The files that may declare what a program in `folder` names: those of its folder first."""
    folders = vendor.folders_with(folder)
    for place in folders:
        for suffix in vendor.suffixes:
            yield from sorted(files_by_stem(place, suffix).values())
    for place in folders if vendor.list_suffixes else ():
        # A list of a program's own name has been read with it, and $config.dat with every program.
        known = {stem for suffix in vendor.suffixes for stem in files_by_stem(place, suffix)}
        for suffix in vendor.list_suffixes:
            for stem, path in sorted(files_by_stem(place, suffix).items()):
                if stem not in known and not stem.startswith("$"):
                    yield path


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


# A folder is searched for names no further than this.
_MOST_FILES = 400
_MOST_BYTES = 20_000_000


def _key(name: str) -> str:
    return name.strip().upper()
