"""Finds the routines that a program calls: in its own file, then beside it, by job name or file name.

A loop depends on the statements that leave it and the variables that decide.
"""

from __future__ import annotations

import difflib
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from olp.core.diagnostic import Diagnostic, OlpError, Severity
from olp.core.source import Source
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.block_structure import ControlFlow, pair
from olp.ir.points import PointTable
from olp.ir.transformer import expressions_of
from olp.languages.vendor import Vendor, find_vendor, vendor_names
from olp.runtime.end_actions import with_end_actions
from olp.runtime.folder import files_by_name_record, files_by_stem, lower_case_cached, read_cached
from olp.runtime.memory import WHOLE, Scope
from olp.runtime.raised import with_raised


@dataclass(frozen=True, slots=True)
class Region:
    """The statements between the head of a loop and the way back to it.

    `exits`: indices of statements that leave it. `reads`: (kind or bus, index, local) of all variables and signals
    that decide whether it is left or goes on; index None when it is computed. `elements`: of arrays by name of which
    the region only reads these.
    """

    exits: tuple[int, ...]
    reads: frozenset[tuple[str, int | None, bool]]
    elements: Mapping[str, tuple[int, ...]] = field(default_factory=dict)


def region(body: tuple[st.Statement, ...], flow: ControlFlow, first: int, last: int) -> Region:
    """The region of the loop from `first` to the statement `last` that leads back."""
    exits = tuple(i for i in range(first, last) if _leaves(body, i, flow, first, last))
    exits += tuple(i for i in range(first, last) if _around(body[i], flow, i, last))
    deciding = list(_conditions(body[last]))
    if isinstance(body[first], st.While):
        deciding.extend(_conditions(body[first]))
    for index in exits:
        deciding.extend(_conditions(body[index]))
        for opener, end in flow.end.items():
            if first <= opener < index < end and flow.opener.get(opener) == opener:
                deciding.extend(c for marker in _markers(flow, opener) for c in _conditions(body[marker]))
        deciding.extend(
            c for i in range(first, index) if _skips(body[i], flow, i, index) for c in _conditions(body[i])
        )
    reads = {read for condition in deciding for read in reads_of(condition)}
    anew: dict[Read, set[Read] | None] = {}
    size = 0
    while reads and len(reads) > size:
        size = len(reads)
        anew |= {read: _set_anew(read, body, flow, first, last) for read in reads - anew.keys()}
        reads |= _behind(body, flow, range(first, last), {read for read in reads if anew.get(read) is None})
        reads |= {source for read in reads for source in anew.get(read) or ()}
    helpers = {read for read in reads if anew.get(read) is not None}
    reads -= helpers | _copies(body[first:last])
    return Region(exits, frozenset(reads), _elements(body[first : last + 1], reads))


def _elements(body: Sequence[st.Statement], reads: set[Read]) -> dict[str, tuple[int, ...]]:
    """Of each named array of `reads` what `body` reads of it (and WHOLE), where that is elements by literal indices."""
    wanted = {kind for kind, _, _ in reads if not isinstance(kind, ex.Store) and kind.startswith("name:")}
    read = [e for s in body if wanted and not isinstance(s, st.Comment) for e in _asked_by(s)]
    names = Counter(f"name:{e.name.casefold()}" for e in read if isinstance(e, ex.Named))
    items: dict[str, list[int]] = defaultdict(list)
    for e in read:
        if isinstance(e, ex.Item) and isinstance(e.base, ex.Named) and len(e.indices) == 1:
            index = e.indices[0]
            if isinstance(index, ex.Number):
                items[f"name:{e.base.name.casefold()}"].append(int(index.value))
    return {
        kind: (WHOLE, *dict.fromkeys(items[kind])) for kind in wanted if 0 < names[kind] == len(items[kind])
    }


def _asked_by(s: st.Statement) -> list[ex.Expression]:
    """The expressions whose values a statement needs: all but an element of an array that it sets."""
    if isinstance(s, st.Assign) and isinstance(s.target, ex.Item) and isinstance(s.target.base, ex.Named):
        return [e for part in (*s.target.indices, s.value) for e in expressions_of(part)]
    return expressions_of(s)


def _set_anew(
    read: Read, body: tuple[st.Statement, ...], flow: ControlFlow, first: int, last: int
) -> set[Read] | None:
    """What a routine's own variable is set from where every pass of a loop sets it before it reads it; else None.

    That decides in its place. Such are the helpers in which a translation computes an index.
    """
    if not any(isinstance(s, st.Declare) and f"name:{s.name.casefold()}" == read[0] for s in body):
        return None
    inside = [(i, _spellings(body[i], read)) for i in range(first, last + 1)]
    touching = [i for i, spelt in inside if spelt]
    if len({name for _, spelt in inside for name in spelt}) != 1 or not _is_always_met(
        touching[0], body, flow, first
    ):
        return None
    sources: set[Read] = set()
    for i in touching:
        s = body[i]
        if any(isinstance(e, ex.CallValue) for e in expressions_of(s)):
            return None  # it may set the variable, too
        if isinstance(s, st.Assign) and isinstance(s.target, ex.Named) and read in reads_of(s.target):
            sources |= set(reads_of(s.value))
            if (i == touching[0] and read in sources) or any(map(_is_controllers, expressions_of(s.value))):
                return None
        elif i == touching[0] or not _only_asks(s):
            return None
    return sources - {read}


def _is_controllers(e: ex.Expression) -> bool:
    """Whether only the controller knows a value, which may be another each time: where the arm is, a clock."""
    return isinstance(e, ex.SystemValue) or (
        isinstance(e, ex.Function) and (e.name == "timer" or not e.arguments)
    )


def _is_always_met(index: int, body: tuple[st.Statement, ...], flow: ControlFlow, first: int) -> bool:
    """Whether each pass of the loop with its head at `first` runs the statement, unless it leaves the loop before."""
    return not any(isinstance(s, (st.Jump, st.Continue)) for s in body[first:index]) and not any(
        first < opener < index < end for opener, end in flow.end.items() if flow.opener.get(opener) == opener
    )


def _only_asks(s: st.Statement) -> bool:
    """Whether a statement that names a variable cannot change it."""
    if isinstance(s, (st.Jump, st.Return)):
        return s.condition is not None
    if isinstance(s, st.Assign):
        return not isinstance(s.target, ex.Named)
    return isinstance(s, (st.If, st.ElseIf, st.While, st.Until, st.Switch, st.Case, st.SetOutput, st.Wait))


def _spellings(s: st.Statement, read: Read) -> set[str]:
    """How a statement calls the variable, where it names it."""
    if isinstance(s, st.Declare) and f"name:{s.name.casefold()}" == read[0]:
        return {s.name, ""}  # it comes into being inside the loop
    return {
        e.name
        for e in expressions_of(s)
        if isinstance(e, ex.Named) and f"name:{e.name.casefold()}" == read[0]
    }


def _copies(body: Sequence[st.Statement]) -> set[Read]:
    """Variables that only hold what a signal was read as: as new as that, which decides in their place."""
    copied: set[Read] = set()
    computed: set[Read] = set()
    for s in body:
        if isinstance(s, st.ReadInput) or (isinstance(s, st.Assign) and type(s.value) is ex.Signal):
            copied |= set(reads_of(s.target))
        elif isinstance(s, (st.Assign, st.Update, st.Clear, st.For, st.Call)):
            places: tuple[ex.Expression | None, ...]
            if isinstance(s, st.Call):
                places = (*s.arguments, s.result)
            else:
                places = (s.variable if isinstance(s, st.For) else s.target,)
            computed |= {read for e in places if e is not None for read in reads_of(e)}
    return copied - computed


Read = tuple[str, int | None, bool]
ANYTHING: Read = ("", None, False)  # what a routine gives back may depend on anything


def influences(bodies: Iterable[Sequence[st.Statement]], reads: frozenset[Read]) -> frozenset[Read]:
    """All that `reads` depend on through what `bodies` assign, the conditions around the assignments included."""
    parts = [(_assignments(body), _all_conditions(body)) for body in bodies]
    found, size = set(reads), -1
    while size != len(found):
        size = len(found)
        for assignments, conditions in parts:
            given = [sources for target, sources in assignments if not found.isdisjoint(target)]
            for sources in given:
                found |= sources
            if given:
                found |= conditions
    return frozenset(found)


def _assignments(body: Sequence[st.Statement]) -> list[tuple[set[Read], set[Read]]]:
    """What each statement sets, and what it reads for that."""
    found = []
    for s in body:
        if isinstance(s, (st.Assign, st.SetOutput)):
            target, value = (s.target if isinstance(s, st.Assign) else s.signal), s.value
            found.append((set(reads_of(target)), _sources(value)))
        elif isinstance(s, st.Update):
            found.append((set(reads_of(s.target)), set() if s.operand is None else _sources(s.operand)))
        elif isinstance(s, st.ReadInput):
            found.append((set(reads_of(s.target)), set(reads_of(s.signal))))
        elif isinstance(s, st.Call) and (s.result is not None or s.arguments):
            handed = (*s.arguments, *(() if s.result is None else (s.result,)))
            found.append(({read for e in handed for read in reads_of(e)}, {ANYTHING}))
    return found


def _sources(value: ex.Expression) -> set[Read]:
    return set(reads_of(value)) | ({ANYTHING} if isinstance(value, ex.CallValue) else set())


def _all_conditions(body: Sequence[st.Statement]) -> set[Read]:
    return {read for s in body for condition in _conditions(s) for read in reads_of(condition)}


def _behind(body: tuple[st.Statement, ...], flow: ControlFlow, inside: range, reads: set[Read]) -> set[Read]:
    """What conditions inside the loop read that decide whether a deciding variable is set: progress in them is some."""
    found: set[Read] = set()
    for opener, end in flow.end.items():
        if opener not in inside or flow.opener.get(opener) != opener or isinstance(body[opener], st.While):
            continue
        targets = (s.target for s in body[opener:end] if isinstance(s, (st.Assign, st.Update, st.ReadInput)))
        if any(read in reads for target in targets for read in reads_of(target)):
            conditions = (c for marker in _markers(flow, opener) for c in _conditions(body[marker]))
            found.update(read for condition in conditions for read in reads_of(condition))
    return found


def _leaves(body: tuple[st.Statement, ...], index: int, flow: ControlFlow, first: int, last: int) -> bool:
    statement = body[index]
    if isinstance(statement, (st.Return, st.End)):
        return True
    if isinstance(statement, st.Call):
        return statement.jump
    if isinstance(statement, st.Break):
        return flow.loop.get(index, first) <= first  # one of a loop inside ends that one
    if isinstance(statement, st.Jump):
        target = flow.labels.get(statement.target) if isinstance(statement.target, str) else None
        return target is None or not first <= target <= last
    return False


def _around(statement: st.Statement, flow: ControlFlow, index: int, last: int) -> bool:
    """Whether the way back stands in the branch of an IF: the loop is left where the branch is not taken."""
    return isinstance(statement, st.If) and index < last < flow.after.get(index, index)


def _skips(statement: st.Statement, flow: ControlFlow, index: int, over: int) -> bool:
    """Whether a jump inside the loop can pass over an exit."""
    if not isinstance(statement, st.Jump) or not isinstance(statement.target, str):
        return False
    return flow.labels.get(statement.target, index) > over


def _markers(flow: ControlFlow, opener: int) -> Iterator[int]:
    marker, end = opener, flow.end[opener]
    while marker < end:
        yield marker
        marker = flow.after[marker]


def _conditions(statement: st.Statement) -> Iterator[ex.Expression]:
    if isinstance(statement, (st.If, st.ElseIf, st.While, st.Until)):
        yield statement.condition
    elif isinstance(statement, (st.Jump, st.Return, st.Call)):
        if statement.condition is not None:
            yield statement.condition
        if isinstance(statement, st.Jump) and not isinstance(statement.target, str):
            yield statement.target
    elif isinstance(statement, st.Switch):
        yield statement.value
    elif isinstance(statement, st.Case):
        yield from statement.values


def is_literal(e: ex.Expression) -> bool:
    """Whether an expression is the same whatever happens: literals, and operators between them."""
    if isinstance(e, (ex.Compare, ex.Binary)):
        return is_literal(e.left) and is_literal(e.right)
    if isinstance(e, ex.Logic):
        return all(is_literal(part) for part in (e.first, *(condition for _, condition in e.rest)))
    if isinstance(e, ex.Unary):
        return is_literal(e.operand)
    return isinstance(e, (ex.Number, ex.Text, ex.SignalState))


def reads_of(e: ex.Expression) -> Iterator[tuple[str, int | None, bool]]:
    """(kind or bus, index, local) of every variable and signal in an expression."""
    if isinstance(e, (ex.Variable, ex.Signal)):
        kind = e.store if isinstance(e, ex.Variable) else e.bus
        index = int(e.index.value) if isinstance(e.index, ex.Number) else None
        yield kind, index, isinstance(e, ex.Variable) and e.local
        yield from reads_of(e.index)
    elif isinstance(e, (ex.Compare, ex.Binary)):
        yield from reads_of(e.left)
        yield from reads_of(e.right)
    elif isinstance(e, ex.Logic):
        for part in (e.first, *(condition for _, condition in e.rest)):
            yield from reads_of(part)
    elif isinstance(e, ex.Unary):
        yield from reads_of(e.operand)
    elif isinstance(e, (ex.Function, ex.CallValue)):
        for argument in e.arguments:
            yield from reads_of(argument)
    elif isinstance(e, ex.Named):
        yield f"name:{e.name.casefold()}", 0, False
    elif isinstance(e, (ex.Item, ex.Member)):
        yield from reads_of(e.base)
        for inner in e.indices if isinstance(e, ex.Item) else ():
            yield from reads_of(inner)
    elif isinstance(e, ex.NamedArgument) and e.value is not None:
        yield from reads_of(e.value)
    elif isinstance(e, ex.Element):
        yield from reads_of(e.variable)


@dataclass(slots=True)
class RunnableRoutine:
    """A routine ready to run. `key` tells routines apart, `source` is the index of its file in the plan."""

    program: st.Program
    routine: st.Routine
    key: int
    source: int
    body: tuple[st.Statement, ...]
    points: PointTable
    loaded: bool = False  # its mechanisms and its global positions are known
    groups: tuple[tuple[int, ...], ...] = ()  # mechanism indices per control group
    roles: dict[tuple[int, str], int] = field(default_factory=dict)  # (part, kind of target) -> mechanism
    regions: dict[tuple[int, int], Region] = field(default_factory=dict)  # loops met, by head and way back
    deciding: dict[int, tuple[Read, ...]] = field(
        default_factory=dict
    )  # by the head: what decides about them
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

    program: st.Program
    folder: Path | None
    sources: list[Source] = field(default_factory=list)
    found: list[Diagnostic] = field(default_factory=list)
    _jobs: dict[str, RunnableRoutine] = field(default_factory=dict)
    programs: list[st.Program] = field(default_factory=list)  # by the index of their source
    _own: dict[tuple[int, str], RunnableRoutine] = field(
        default_factory=dict
    )  # (source, name): a file's own routines win
    # (source, name as it is spelled), where the language tells names apart by their case.
    _spelled: dict[tuple[int, str], RunnableRoutine] = field(default_factory=dict)
    _count: int = 0  # of routines met so far
    # Routines that another file has for itself: called only where no file shares one of the name.
    _private: dict[str, RunnableRoutine] = field(default_factory=dict)
    _read_files: set[Path] = field(default_factory=set)
    _beside: dict[Path, bytes] | None = None  # files not read so far, and what they hold in lower case
    _searched: set[str] = field(default_factory=set)  # names that no file left in `_beside` holds
    _looked_for: set[str] = field(default_factory=set)  # names whose own file was looked for, found or not
    _near: dict[tuple[str, int], list[str]] = field(default_factory=dict)  # of a name, among so many routines

    def __post_init__(self) -> None:
        if self.folder is not None and self.program.path:
            self._read_files.add(self.folder / Path(self.program.path).name)
        self._add(self.program)

    def main(self) -> RunnableRoutine | None:
        """The routine that the program says runs, else its first one."""
        if not self.program.routines:
            return None
        first = self.program.main or self.program.routines[0].name
        if (spelled := self._spelled.get((0, first.strip()))) is not None:
            return spelled
        return self._jobs.get(_key(first)) or self._jobs[_key(self.program.routines[0].name)]

    def find(self, name: str, source: int = 0) -> RunnableRoutine | None:
        """The routine called `name` by the file `source`, None when there is none in the program or its folder."""
        key = _key(name)
        spelled = self._spelled.get((source, name.strip()))
        job = spelled or self._own.get((source, key)) or self._jobs.get(key)
        if job is None:
            self._read(key)
            job = self._jobs.get(key)
        if job is None and self.read_naming((name,)):
            job = self._jobs.get(key)
        return job or self._private.get(key)

    def read_file(self, path: Path) -> int | None:
        """The index of a file's source; it is read where no name has led to it. None where it cannot be read."""
        here = path.absolute()  # folders beside that of the program are searched by their whole paths
        known = {one.absolute() for one in self._read_files}
        if here not in known:
            self._add_file(path)
        found = (n for n, one in enumerate(self.programs) if Path(one.path).absolute() == here)
        return next(found, None)

    def read_naming(self, names: Iterable[str]) -> bool:
        """Reads the other files of the folder that hold one of `names`, where the language shares names between files.

        Of a controller's whole archive most files hold none, and their lists of points are long.
        """
        if self.folder is None or not self.program.path:
            return False
        if self._beside is None:
            self._beside = dict(self._files_to_search(self.folder))
        new = {name.strip().lower() for name in names} - self._searched
        if not new:
            return False
        self._searched |= new
        plain = all(name.isascii() for name in new)  # others are spelled as the file's encoding says
        words = [name.encode() for name in new]
        pattern = re.compile(rb"(?<![\w$])(?:" + b"|".join(map(re.escape, words)) + rb")(?!\w)")
        few = len(words) <= _FEW_NAMES  # a pattern takes ten times as long as a plain text
        before = len(self.programs)
        for path, text in [*self._beside.items()]:
            if few and plain and text and not any(word in text for word in words):
                continue
            if not text or not plain or pattern.search(text):
                del self._beside[path]
                if path not in self._read_files and before <= _MOST_FILES:
                    self._add_file(path, asked=False)
        return len(self.programs) > before

    def _files_to_search(self, folder: Path) -> Iterator[tuple[Path, bytes]]:
        """The files that may declare a name, and their texts; empty where other files hold what they declare."""
        vendor = find_vendor(self.program.vendor)
        size = 0
        for path in _files_beside(folder, vendor) if vendor.shares_names else ():
            size += path.stat().st_size
            if path not in self._read_files and size <= _MOST_BYTES:
                yield path, _text_of(path, vendor) if vendor.list_suffixes else b""

    def near(self, name: str) -> list[str]:
        """Names that `name` may have meant."""
        key, place = (_key(name), len(self._jobs)), self.folder
        if key not in self._near:  # a call in a loop asks each time
            files = {} if place is None else files_by_stem(place, Path(self.program.path).suffix)
            self._near[key] = difflib.get_close_matches(key[0], {*self._jobs, *files}, n=3, cutoff=0.5)
        return self._near[key]

    def _add(self, program: st.Program, file_name: str = "") -> None:
        source = len(self.sources)
        self.sources.append(program.source)
        self.programs.append(program)
        by_case = program.vendor in vendor_names() and find_vendor(program.vendor).case_sensitive
        for routine in program.routines:
            routine = with_raised(program, routine)
            body = with_end_actions(program.vendor, routine.body)
            job = RunnableRoutine(program, routine, self._count, source, body, _points(routine))
            self._count += 1
            seen = self._jobs if routine.shared or source == 0 else self._private
            seen.setdefault(_key(routine.name), job)
            self._own.setdefault((source, _key(routine.name)), job)
            if by_case:
                self._spelled.setdefault((source, routine.name.strip()), job)
        if file_name and program.routines:
            self._jobs.setdefault(file_name, self._own[(source, _key(program.routines[0].name))])

    def _read(self, key: str) -> None:
        """Reads the file called like the job, else the one whose head names it."""
        if self.folder is None or key in self._looked_for:
            return
        self._looked_for.add(key)
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
                if stem not in known and not vendor.conventions.is_controllers(stem):
                    yield path


def _text_of(path: Path, vendor: Vendor) -> bytes:
    """A file and the lists of its name, in lower case."""
    lists = (files_by_stem(path.parent, suffix).get(path.stem.upper()) for suffix in vendor.list_suffixes)
    try:
        return lower_case_cached((path, *(one for one in lists if one is not None)))
    except OSError:
        return b""  # and reading it says why


def _points(routine: st.Routine) -> PointTable:
    """The routine's positions; user coordinates of a relative routine stand in its own frame."""
    frame, table = routine.relative_to, routine.points
    if frame is None or frame.kind != "user" or not isinstance(frame.number, ex.Number):
        return table
    user = int(frame.number.value)
    if all(state.user == user for state in table.states if state.frame == "user"):
        return table
    return PointTable(
        tuple(replace(s, user=user) if s.frame == "user" else s for s in table.states), table.blocks
    )


# A folder is searched for names no further than this.
_MOST_FILES = 400
_FEW_NAMES = 8
_MOST_BYTES = 20_000_000


def _key(name: str) -> str:
    return name.strip().upper()
