"""A program together with the routines and the data that it names from the files beside it, as one program."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, fields, is_dataclass, replace
from enum import Enum
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeVar, cast

from olp.core.diagnostic import Diagnostic, errors
from olp.core.files import named_like
from olp.core.source import Source
from olp.ir import program as st
from olp.ir.expressions import CallValue, Expression, Function, Named, Number, RecordLiteral, Store, Variable
from olp.ir.program import is_same
from olp.ir.transformer import Change, calls_nothing, edited, expressions_of, mapped, note_names, sets_numbers
from olp.languages.vendor import conventions_of, find_vendor, vendor_names
from olp.runtime.end_actions import with_end_actions
from olp.transpile.commented_out import owner
from olp.transpile.name_types import KINDS
from olp.transpile.occurrences import Look, names_of_data, with_routines, with_rows

if TYPE_CHECKING:
    from olp.runtime.jobs import Jobs, RunnableRoutine

S = TypeVar("S", bound=st.Statement)
_LAYOUTS: Final = ("structure", "enumeration")
_PLAIN_TYPES: Final = frozenset({*KINDS, "speed", "zone", "signal", ""})  # which no file declares


@dataclass(frozen=True, slots=True)
class LinkedPart:
    """One file of a linked program: its lines stand behind those of the parts before, from `offset` + 1 on."""

    path: str
    offset: int
    count: int


@dataclass(frozen=True, slots=True)
class Linked:
    """`borrowed`: routines that a file has for itself and another one calls, each with the path of the first."""

    program: st.Program
    parts: tuple[LinkedPart, ...]
    borrowed: tuple[tuple[str, str], ...] = ()

    @property
    def starts(self) -> tuple[str, ...]:
        """The main routines of the further programs that it holds."""
        return tuple(routine.name for routine in self.program.routines if routine.starts)

    def place(self, line: int) -> tuple[str, int]:
        """The file and the line there of a line of the linked program."""
        for part in reversed(self.parts):
            if line > part.offset:
                return named_like(part.path, self.program.path), line - part.offset
        return self.program.path, line

    def located(self, found: Diagnostic) -> Diagnostic:
        """A diagnostic of the linked program with the file and the line that people know."""
        path, line = self.place(found.line)
        if not found.line or line == found.line:
            return found
        # The text of another file is not at hand, so there is nothing to draw a caret under.
        return replace(found, file=path, line=line, column=1, end_column=1, source_line="")


def link(program: st.Program, to: str = "", others: Sequence[Path] = ()) -> Linked:
    """`program` with what it names and does not declare, from the files of its folder: routines that its calls name,
    data that its statements and those of the routines name. The lines of other files follow its own.

    `to`: the language that it is for; in another one than its own, statements are spelled out as that vendor says.
    `others`: programs that become part of it, whole.
    """
    from olp.runtime.jobs import Jobs

    path = Path(program.path) if program.path else None
    folder = path.parent if path is not None and path.is_file() else None
    own = LinkedPart(program.path, 0, len(program.source.lines))
    jobs = Jobs(program, folder)
    plainly = to != program.vendor and program.vendor in vendor_names()
    if plainly:
        program = _unlike_in_case(program)
        program = with_routines(program, (_spelled_out(r, program, jobs) for r in program.routines))
    if folder is None:
        return Linked(_as_called(program, plainly), (own,))
    joined = _Joined(program, jobs, [own], list(program.source.lines), plainly)
    joined.add_routines(others)
    joined.add_data()
    return joined.linked()


def _unlike_in_case(program: st.Program) -> st.Program:
    """The program with other names for routines whose names differ from others in case alone, which most languages read
    as one.
    """
    names = [r.name for r in program.routines]
    taken = {name.casefold() for name in names}
    if len(taken) == len(names) or not find_vendor(program.vendor).case_sensitive:
        return program
    new: dict[str, str] = {}
    seen: set[str] = set()
    for name in names:
        if name.casefold() in seen:
            number = next(n for n in range(2, len(names) + 2) if f"{name}_{n}".casefold() not in taken)
            new[name] = f"{name}_{number}"
            taken.add(new[name].casefold())
        seen.add(name.casefold())

    def change(e: Expression) -> Expression:
        return replace(e, routine=new[e.routine]) if type(e) is CallValue and e.routine in new else e

    def called(s: st.Statement) -> st.Statement:
        s = mapped(s, change)
        return replace(s, routine=new[s.routine]) if isinstance(s, _CALLING) and s.routine in new else s

    def apart(r: st.Routine) -> st.Routine:
        r = replace(r, body=tuple(map(called, r.body)))
        if r.name not in new:
            return r
        comment = " ".join(filter(None, (r.comment, f"{r.name} in the source")))
        return replace(r, name=new[r.name], comment=comment)

    return replace(
        with_routines(program, map(apart, program.routines)), main=new.get(program.main, program.main)
    )


_CALLING: Final = (st.Call, st.StartTask)
_MOVES_OR_WAITS: Final = (st.Call, st.Dwell, st.Move, st.PulseOutput, st.SetOutput, st.Wait)
_WITHOUT_NAMES: Final = (
    st.Assign,
    st.Else,
    st.ElseIf,
    st.EndIf,
    st.For,
    st.If,
    st.Return,
    st.SetOutput,
    st.While,
)
_NAME: Final = re.compile(r"\w+")
# Fields of statements and expressions that hold no word of the program, and comments.
_OWN_WORDS: Final = frozenset({"bus", "comment", "kind", "operator", "spelling", "storage", "type"})


def with_starts(program: st.Program) -> st.Program:
    """The program with its routines that nothing in it names as starts, beside the main one: somebody runs them."""
    if len(program.routines) < 2:
        return program
    named = _named_routines(program)
    first = program.main or program.routines[0].name

    def starts(r: st.Routine) -> bool:
        if r.returns or r.name == first or r.name.casefold() in named:
            return False
        return any(isinstance(s, _MOVES_OR_WAITS) for s in r.body)

    return with_routines(program, (replace(r, starts=True) if starts(r) else r for r in program.routines))


def _named_routines(program: st.Program) -> set[str]:
    """What may be the name of a routine in any statement, case folded."""
    found: set[str] = set()
    for routine in program.routines:
        for s in with_end_actions(program.vendor, routine.body):
            if calls_nothing(s) or sets_numbers(s) or isinstance(s, st.Comment):
                continue
            if isinstance(s, st.Call):
                found.add(s.routine.casefold())
            if isinstance(s, (*_WITHOUT_NAMES, st.Call, st.Move)):
                found |= {e.routine.casefold() for e in expressions_of(s) if type(e) is CallValue}
            else:
                found |= {word for text in _texts(s) for word in _NAME.findall(text.casefold())}
    return found


def _texts(node: object) -> Iterator[str]:
    """Every text in a statement, names and kept words alike; no word of this package, such as a name of a field."""
    if isinstance(node, str):
        if not isinstance(node, Enum):
            yield node
    elif isinstance(node, (tuple, frozenset)):
        for part in node:
            yield from _texts(part)
    elif is_dataclass(node) and not isinstance(node, type):
        own = _OWN_WORDS if type(node) is not Function else _OWN_WORDS | {"name"}
        for one in fields(node):
            if one.name not in own:
                yield from _texts(getattr(node, one.name))


class Whole(NamedTuple):
    """Programs that share routines, data or numbered variables, and so become one: the first, and the others."""

    program: st.Program
    others: tuple[Path, ...]


def wholes(programs: Sequence[st.Program]) -> list[Whole]:
    """The programs as wholes, each in the place of its first one.

    First stands a program that no other one of its whole needs: one with a main routine, else without an error, else
    that needs most files.
    """
    files: list[set[Path]] = []
    numbers: list[set[tuple[Store, int]]] = []
    for program in programs:
        linked = link(program)
        files.append({Path(part.path).absolute() for part in linked.parts})
        numbers.append(_numbered(linked.program))
    group = list(range(len(programs)))
    for n in range(len(programs)):
        for m in range(n):
            if programs[n].vendor == programs[m].vendor and (files[n] & files[m] or numbers[n] & numbers[m]):
                old, new = group[n], group[m]
                group = [new if one == old else one for one in group]
    found = []
    for name in dict.fromkeys(group):
        members = [n for n, one in enumerate(group) if one == name]

        def place(n: int, members: list[int] = members) -> tuple[bool, bool, bool, bool, int]:
            needed = any(Path(programs[n].path).absolute() in files[m] for m in members if m != n)
            broken = bool(errors(programs[n].diagnostics))
            return not programs[n].routines, needed, not programs[n].main, broken, -len(files[n])

        first = min(members, key=place)
        found.append(Whole(programs[first], tuple(Path(programs[n].path) for n in members if n != first)))
    return found


def _numbered(program: st.Program) -> set[tuple[Store, int]]:
    """The numbered variables, which all programs of a controller share, of these statements."""
    return {
        (e.store, int(e.index.value))
        for s in program.statements()
        for e in expressions_of(s)
        if isinstance(e, Variable) and not e.local and isinstance(e.index, Number)
    }


def _spelled_out(routine: st.Routine, program: st.Program, jobs: Jobs) -> st.Routine:
    """A routine with what only the maker's controllers do in one statement as plain statements."""
    vendor = find_vendor(program.vendor)
    source = next((n for n, one in enumerate(jobs.programs) if one is program), 0)

    def find(name: str) -> st.Routine | None:
        job = jobs.find(name, source)
        return None if job is None or _is_library(job) else job.routine

    return with_rows(routine, vendor.spelled_out(routine.body, find))


def _is_library(job: RunnableRoutine) -> bool:
    """Whether a routine stands in a file of the maker's own, whose routines are known by their names."""
    own = find_vendor(job.program.vendor).library_files
    return bool(own) and Path(job.program.path).stem.casefold() in own


def _as_called(program: st.Program, plainly: bool) -> st.Program:
    return find_vendor(program.vendor).as_called(program) if plainly else program


@dataclass(slots=True)
class _Joined:
    """The program and what has been added to it so far. `offsets`: of each file's lines, by its program's id."""

    program: st.Program
    jobs: Jobs
    parts: list[LinkedPart]
    lines: list[str]
    plainly: bool  # what only the maker's controllers do is spelled out
    routines: list[st.Routine] = field(default_factory=list)
    data: list[st.Declare] = field(default_factory=list)
    offsets: dict[int, int] = field(default_factory=dict)
    looks: dict[int, Look] = field(default_factory=dict)  # at routines, by the id of their body
    sources: dict[int, int] = field(default_factory=dict)  # of routines, by the id of their body; else 0
    # By the file that names it, and the name there, case folded: its name in the whole
    renamed_routines: dict[tuple[int, str], str] = field(default_factory=dict)
    renamed_data: dict[tuple[int, str], str] = field(default_factory=dict)
    found: list[Diagnostic] = field(
        default_factory=list
    )  # errors of the routines of other files, and what their reader has assumed
    borrowed: dict[str, str] = field(default_factory=dict)  # other files' own routines -> path
    public: dict[str, str] = field(
        default_factory=dict
    )  # shared data of a name that is another file's own here

    def __post_init__(self) -> None:
        self.routines += self.program.routines
        self.data += self.program.data
        self.offsets |= {id(self.jobs.programs[0]): 0, id(self.program): 0}

    def linked(self) -> Linked:
        program = self.program
        if len(self.parts) == 1:
            return Linked(_as_called(program, self.plainly), tuple(self.parts))
        source = Source(program.source.path, program.source.raw, program.source.encoding, tuple(self.lines))
        main = program.main or (program.routines[0].name if program.routines else "")
        routines, data = self._respelt()
        found = (*program.diagnostics, *self.found)
        joined = replace(program, source=source, routines=routines, data=data, main=main, diagnostics=found)
        borrowed = tuple(self.borrowed.items())
        return Linked(_as_called(joined, self.plainly), tuple(self.parts), borrowed)

    def _respelt(self) -> tuple[tuple[st.Routine, ...], tuple[st.Declare, ...]]:
        """Routines and data with the names of other files spelt as these declare them."""
        routines, data = tuple(self.routines), tuple(self.data)
        if find_vendor(self.program.vendor).case_sensitive:
            return routines, data
        own = {id(declare) for declare in self.program.data}
        spelt = {d.name.casefold(): d.name for d in data if id(d) not in own}
        used: set[str] = set()
        for row in (*data, *(row for r in routines for row in (*r.data, *r.body))):
            note_names(row.means if isinstance(row, st.Disabled) else row, used)
        wrong = {name: spelt[name.casefold()] for name in used if spelt.get(name.casefold(), name) != name}
        if not wrong:
            return routines, data

        def change(e: Expression) -> Expression:
            return Named(wrong[e.name]) if type(e) is Named and e.name in wrong else e

        routines = tuple([_with_handlers(mapped(r, change), change) for r in routines])
        return routines, tuple([mapped(d, change) for d in data])

    def add_routines(self, others: Sequence[Path] = ()) -> None:
        """The routines that calls name, and those that they call; with the data of their files. All of `others`.

        What two files call the same, each for itself, has another name in the file that comes later.
        """
        have = {routine.name.casefold() for routine in self.routines}
        # Of what is there, in the whole; a routine that is spelled out is another object than the one that calls find.
        names = {id(r): r.name for r in (*self.jobs.programs[0].routines, *self.routines)}
        todo = [(name, 0) for routine in self.routines for name in self._called(routine)]
        starts = set()
        for path in others:
            at = self.jobs.read_file(path)
            if at is not None:
                other = self.jobs.programs[at]
                self._add(other, self._apart(other))
                todo += [(routine.name, at) for routine in other.routines]
                starts |= {(at, (other.main or r.name).casefold()) for r in other.routines[:1]}
        while todo:
            name, source = todo.pop(0)
            job = self.jobs.find(name, source)
            if job is None or (self.plainly and _is_library(job)):
                continue
            found = job.routine
            if not found.shared and job.source != source:
                self.borrowed[found.name] = job.program.path
            if id(found) not in names:
                other = job.program
                if id(other) not in self.offsets:
                    self._add(other, self._apart(other))
                new = (
                    found.name if found.name.casefold() not in have else self._fresh(found.name, other, have)
                )
                names[id(found)] = new
                have.add(new.casefold())
                routine = _spelled_out(found, other, self.jobs) if self.plainly else found
                todo += [(called, job.source) for called in self._called(routine)]
                routine = _shifted(routine, self.offsets[id(other)])
                routine = replace(routine, name=new, starts=(job.source, found.name.casefold()) in starts)
                self.routines.append(routine)
                self.sources[id(routine.body)] = job.source
                self.found += self._found_in(found, other)
            if names[id(found)] != found.name:
                self.renamed_routines[(source, name.casefold())] = names[id(found)]
        self._add_layouts()
        self._keep_private()
        self._keep_points()
        self.routines = [self._renamed(r) for r in self.routines]
        if starts:
            called = {name.casefold() for r in self.routines for name in self._called(r)}
            self.routines = [
                replace(r, starts=False) if r.starts and r.name.casefold() in called else r
                for r in self.routines
            ]

    def _found_in(self, routine: st.Routine, other: st.Program) -> list[Diagnostic]:
        """What is wrong or assumed in the text of a routine of another file, at its line in the whole."""
        assumed = conventions_of(other.vendor).assumed_codes
        return [
            replace(d, line=d.line + self.offsets[id(other)], file="")
            for d in other.diagnostics
            if (d.is_error or d.code in assumed)
            and d.file in ("", other.path)
            and owner(other.routines, d.line) is routine
        ]

    def _add_layouts(self) -> None:
        """The structures of other files that data, parameters and results here are of."""
        wanted = {d.type.casefold() for d in self.data}
        for routine in self.routines:
            wanted |= {routine.returns.casefold()} | {one.type.casefold() for one in _locals(routine)}
        wanted -= {d.name.casefold() for d in self.data if d.type in _LAYOUTS} | _PLAIN_TYPES
        if wanted and find_vendor(self.program.vendor).shares_names:
            self.jobs.read_naming(wanted)
            for other in self.jobs.programs[1:]:
                if rows := self._layouts(other, wanted):
                    self._add(other, rows)

    def _keep_private(self) -> None:
        """Names whose data here are another file's alone, as that of shared data or of none that is known."""
        if len(self.parts) == 1 or not find_vendor(self.program.vendor).shares_names:
            return
        own = [{d.name.casefold() for d in one.data} for one in self.jobs.programs]
        private = {d.name.casefold() for d in self.data if not d.shared}
        for routine in self.routines:
            source = self.sources.get(id(routine.body), 0)
            local = {d.name.casefold() for d in _locals(routine)}
            for name in private.intersection(map(str.casefold, self._look(routine).names())):
                if name not in local and name not in own[source]:
                    taken = {d.name.casefold() for d in self.data}
                    new = self.public.get(name) or _free(f"{name}_shared", taken)
                    self.public[name] = self.renamed_data[(source, name)] = new

    def _keep_points(self) -> None:
        """Points that no list here has, of which each file has its own: they are another one in each file."""
        own_points = find_vendor(self.program.vendor).conventions.file_points
        if own_points is None or len(self.parts) == 1:
            return
        own = [{d.name.casefold() for d in one.data} for one in self.jobs.programs]
        known = {d.name.casefold() for one in self.jobs.programs for d in one.data if d.shared}
        first: dict[str, int] = {}
        for routine in self.routines:
            source = self.sources.get(id(routine.body), 0)
            local = {d.name.casefold() for d in _locals(routine)} | known | own[source]
            for s in routine.body:
                points = (*s.targets, s.via) if isinstance(s, st.Move) else ()
                for name in (e.name for e in points if type(e) is Named and own_points.fullmatch(e.name)):
                    key = name.casefold()
                    if key not in local and first.setdefault(key, source) != source:
                        taken = {*first, *map(str.casefold, self.renamed_data.values())}
                        new = self._fresh(name, self.jobs.programs[source], taken)
                        self.renamed_data.setdefault((source, key), new)

    def _apart(self, other: st.Program) -> list[st.Declare]:
        """The data of a file that comes in, under other names where the data here have them and are others."""
        known = {d.name.casefold(): d for d in self.data}
        rows = []
        source = next(n for n, one in enumerate(self.jobs.programs) if one is other)
        taken = set(known)
        for d in other.data:
            before = known.get(d.name.casefold())
            if before is None:
                rows.append(d)
            elif not (is_same(d, before) and (d.storage == "constant" or (d.shared and before.shared))):
                new = self._fresh(d.name, other, taken)
                taken.add(new.casefold())
                self.renamed_data[(source, d.name.casefold())] = new
                rows.append(replace(d, name=new))
        renamed = {name: new for (at, name), new in self.renamed_data.items() if at == source}
        return [mapped(d, lambda e: _with_new_name(e, renamed)) for d in rows] if renamed else rows

    @staticmethod
    def _fresh(name: str, other: st.Program, taken: Set[str]) -> str:
        stem = "".join(c if c.isascii() and c.isalnum() else "_" for c in Path(other.path).stem).strip("_")
        return _free(f"{name}_{stem}", taken)

    def _renamed(self, routine: st.Routine) -> st.Routine:
        """A routine with the names that the whole has for what its file calls otherwise."""
        source = self.sources.get(id(routine.body), 0)
        called = {name: new for (at, name), new in self.renamed_routines.items() if at == source}
        data = {name: new for (at, name), new in self.renamed_data.items() if at == source}
        for one in _locals(routine):
            data.pop(one.name.casefold(), None)
        if not called and not data:
            return routine

        def change(e: Expression) -> Expression:
            if type(e) is CallValue and e.routine.casefold() in called:
                return replace(e, routine=called[e.routine.casefold()])
            return _with_new_name(e, data)

        def row(s: st.Statement) -> st.Statement:
            s = mapped(s, change)
            if isinstance(s, st.Call) and s.routine.casefold() in called:
                return replace(s, routine=called[s.routine.casefold()])
            return s

        changed = replace(routine, body=tuple(map(row, routine.body)), data=mapped(routine.data, change))
        return _with_handlers(changed, change)

    def add_data(self) -> None:
        """The declarations of names that nothing declares so far, and of the names that their values need."""
        open_names = self._undeclared()
        if not open_names or not find_vendor(self.program.vendor).shares_names:
            return
        while open_names:
            asked = {new.casefold(): name for name, new in self.public.items()}
            self.jobs.read_naming({asked.get(name, name) for name in open_names})
            before = len(self.data)
            for other in self.jobs.programs[1:]:
                shared = [d for d in other.data if d.shared]
                rows = [d for d in shared if d.name.casefold() in open_names]
                named = ((self.public.get(d.name.casefold(), ""), d) for d in shared)
                rows += [replace(d, name=new) for new, d in named if new.casefold() in open_names]
                open_names -= {d.name.casefold() for d in rows}
                if rows:
                    self._add(other, [*self._layouts(other, {d.type.casefold() for d in rows}), *rows])
            if len(self.data) == before:
                return
            open_names = self._undeclared()

    def _called(self, routine: st.Routine) -> list[str]:
        found: list[str] = []
        look = self._look(routine)
        for s in (*(s for _, s in look.rare), *look.handled()):
            if isinstance(s, st.Call) and s.routine:
                found.append(s.routine)
            if not (calls_nothing(s) or sets_numbers(s)):
                found += [e.routine for e in expressions_of(s) if type(e) is CallValue]
        return found

    def _look(self, routine: st.Routine) -> Look:
        known = self.looks.get(id(routine.body))
        if known is None:
            known = self.looks[id(routine.body)] = Look(routine.body)  # which keeps the body, and so its id
        return known

    def _undeclared(self) -> set[str]:
        """Names that are used where no declaration holds for them, in lower case: a routine's own is no other's."""
        own = conventions_of(self.program.vendor)
        known = {declare.name.casefold() for declare in self.data}
        found = names_of_data((*self.data, *(row for r in self.routines for row in r.data)))
        found = {name.casefold() for name in found}
        for routine in self.routines:
            look = self._look(routine)
            known |= {d.name.casefold() for d in routine.data}
            names = set(look.names())
            for s in look.handled():
                note_names(s, names)
            declared = [s for _, s in look.rare if isinstance(s, st.Declare)]
            known |= {d.name.casefold() for d in declared if d.shared}
            ours = {one.name.casefold() for one in (*routine.parameters, *declared)}
            found |= {name.casefold() for name in names} - ours
        return {name for name in found if not own.is_controllers(name)} - known

    def _layouts(self, other: st.Program, wanted: Set[str]) -> list[st.Declare]:
        """A file's declarations of these types, case folded, and of those of their members."""
        have = {d.name.casefold() for d in self.data}
        found: list[st.Declare] = []
        while more := [d for d in other.data if d.type in _LAYOUTS and d.name.casefold() in wanted - have]:
            found += more
            have |= {d.name.casefold() for d in more}
            members = [e for d in more if isinstance(d.value, RecordLiteral) for _, e in d.value.members]
            wanted = {e.type.casefold() for e in members if isinstance(e, RecordLiteral)}
        return found

    def _add(self, other: st.Program, rows: list[st.Declare]) -> None:
        """Declarations of another file, whose lines are added where they are not yet."""
        if id(other) not in self.offsets:
            self.offsets[id(other)] = len(self.lines)
            self.parts.append(LinkedPart(other.path, len(self.lines), len(other.source.lines)))
            self.lines += other.source.lines
        offset = self.offsets[id(other)]
        # What tells no line of its own is of that file all the same.
        self.data += [_moved(d if d.line else replace(d, line=1), offset) for d in rows]


def _free(name: str, taken: Set[str]) -> str:
    return next(one for one in (f"{name}{n or ''}" for n in count()) if one.casefold() not in taken)


def _locals(routine: st.Routine) -> list[st.Parameter | st.Declare]:
    """What a routine declares for itself."""
    return [*routine.parameters, *routine.data, *(s for s in routine.body if isinstance(s, st.Declare))]


def _with_new_name(e: Expression, names: Mapping[str, str]) -> Expression:
    new = names.get(e.name.casefold()) if type(e) is Named else None
    return e if new is None else Named(new)


def _with_handlers(routine: st.Routine, change: Change) -> st.Routine:
    """The same done to what handlers mean, which `mapped` passes over."""
    if not any(isinstance(s, st.Disabled) and s.means for s in routine.body):
        return routine
    body = [
        replace(s, means=mapped(s.means, change)) if isinstance(s, st.Disabled) else s for s in routine.body
    ]
    return replace(routine, body=tuple(body))


def _shifted(routine: st.Routine, offset: int) -> st.Routine:
    return replace(
        routine,
        body=tuple([_moved(s, offset) for s in routine.body]),
        data=tuple([_moved(d, offset) for d in routine.data]),
        line=routine.line + offset,
        last_line=routine.last_line and routine.last_line + offset,
    )


def _moved(s: S, offset: int) -> S:
    """A statement `offset` lines further down."""
    statement: Any = s
    if not s.line:
        return s
    line = s.line + offset
    return cast(S, edited(statement, {"line": line}) if type(s) is st.Move else replace(statement, line=line))
