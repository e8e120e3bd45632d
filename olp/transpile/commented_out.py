"""What the target cannot express becomes comments: statements, values of data, data, and routines by their heads.

A routine with an error in its text is not converted: it becomes its text, each line of which is a comment there.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final, NamedTuple

from olp.core.diagnostic import Severity
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.block_structure import Block, Node, flat, parse
from olp.ir.transformer import expressions_of, note_names
from olp.languages.vendor import conventions_of
from olp.transpile.context import LOST, Fate, TranslationContext
from olp.transpile.reaching_definitions import ENTRY, UNSET, Key, Reaching, reaching
from olp.transpile.shared_variables import handed_over, paired
from olp.transpile.source_only import foreign_word, untranslated

_SETTING = (st.Assign, st.Update, st.Clear, st.ReadInput)
_RESULT = "result of "  # a routine's, among names of variables
_LETTERS = "abcdefghijklmnopqrstuvwxyz"


@dataclass(slots=True)
class LeftOut:
    """Lines of the source that become comments, and why.

    `gone`: declarations that the target could not say without their value either; whoever names them goes with them.
    """

    lines: dict[int, str] = field(default_factory=dict)
    gone: dict[int, str] = field(default_factory=dict)
    empty: dict[str, str] = field(default_factory=dict)  # routines of which nothing is left, case folded
    uncalled: frozenset[int] | None = None  # lines that nothing can run, None: nobody looked

    def add(self, found: Mapping[int, str], program: st.Program, on_loss: str) -> bool:
        """Whether this leaves out more than before; unless `on_loss` is "comment", of what nothing can run."""
        if on_loss != "comment" and found:
            if self.uncalled is None:
                dead = _uncalled(program)
                self.uncalled = frozenset(n for r in program.routines if r.name in dead for n in _lines_of(r))
            found = {line: says for line, says in found.items() if line in self.uncalled}
        new = {line: says for line, says in found.items() if line not in self.lines}
        again = {line: says for line, says in found.items() if line in self.lines and line not in self.gone}
        self.lines.update(new)
        self.gone.update(again)
        return bool(new or again)


# --- Routines with an error ---

UNCONVERTED = "X015"


def owner(routines: Iterable[st.Routine], line: int) -> st.Routine | None:
    """The routine that a line stands in: the innermost around it, else the last one before it."""
    before = sorted((r for r in routines if r.line <= line), key=lambda r: r.line)
    around = [r for r in before if max(r.last_line, *(s.line for s in r.body), 0) >= line]
    found = around or before
    return found[-1] if found else None


def with_texts(program: st.Program, to: str) -> st.Program:
    """The program, for another language, with the texts of its routines that have an error: a warning then (X015).

    The errors stay, and the routines too, where one stands in the main routine, in a head or in no routine.
    """
    if program.vendor == to:
        return program
    main = program.main or (program.routines[0].name if program.routines else "")
    wrong: dict[str, list[int]] = {}
    told = []
    for d in program.diagnostics:
        if d.is_error:
            inside = owner(program.routines, d.line) if d.file in ("", program.path) else None
            if inside is None or inside.name == main or inside.line == d.line:
                return program
            wrong.setdefault(inside.name, []).append(d.line)
            says = f"{inside.name} is not converted: {d.message}"
            d = replace(d, code=UNCONVERTED, message=says, severity=Severity.WARNING)
        told.append(d)
    routines = tuple(_as_text(program, r, wrong[r.name]) if r.name in wrong else r for r in program.routines)
    return replace(program, routines=routines, diagnostics=tuple(told)) if wrong else program


def _as_text(program: st.Program, routine: st.Routine, wrong: Iterable[int]) -> st.Routine:
    """`wrong`: the lines of its errors, which hold no statement."""
    written: dict[int, list[st.Statement]] = {line: [] for line in wrong}
    for s in routine.body:
        written.setdefault(s.line, []).append(s)
    inside = [s.line for s in routine.body] or [*written]
    body: list[st.Statement] = []
    for line in sorted({*range(min(inside), max(inside) + 1), *written}):
        here = written.get(line, [])
        text = program.source.line(line).strip()
        if here and all(isinstance(s, (st.Begin, st.End, st.Comment)) for s in here):
            body += here
        elif text:
            body.append(st.Opaque(line, text))
    return replace(routine, body=tuple(body), data=())


def text_alone(program: st.Program) -> LeftOut:
    """What is left out of a program for the routines that are their text: see `with_texts`."""
    out = LeftOut()
    for d in program.diagnostics:
        routine = owner(program.routines, d.line) if d.code == UNCONVERTED else None
        if routine is None or routine.name.casefold() in out.empty:
            continue
        out.empty[routine.name.casefold()] = d.message
        out.lines.update({s.line: d.message for s in routine.body if isinstance(s, st.Opaque)})
        if routine.returns:
            out.lines[routine.line] = d.message
    return out


def _tell_callers(program: st.Program, out: LeftOut, work: TranslationContext) -> None:
    for s in program.statements() if out.empty else ():
        if (
            isinstance(s, (st.Call, st.StartTask))
            and s.routine.casefold() in out.empty
            and s.line not in out.lines
        ):
            work.lose(s, Fate.APPROXIMATED, "call", out.empty[s.routine.casefold()])


# --- Statements, data, heads ---

_Gone = dict[tuple[str, str], str]  # (the routine that has it for itself or "", its name), case folded -> why


def leave_out(program: st.Program, out: LeftOut, work: TranslationContext) -> st.Program:
    """The program without what `out` names; each statement that goes is a comment and a loss."""
    foreign = work.source.vendor != work.target
    unreached = _before_cases(program) if foreign else {}
    filling = _filling(program, work) if foreign and work.context.on_loss == "comment" else {}
    if not out.lines and not unreached and not filling:
        return program
    lines: dict[int, str] = {}
    if out.lines or filling:
        program = _without_uncalled(program, out, work)
        lost: _Gone = {}
        program = _without_data(program, out, lost, work)
        program, bodies = _without_heads(program, out, lost)
        lines = {**filling, **_users(program, lost), **bodies, **out.lines}
        lines = {**_inside(program, lines), **lines}
        lines |= _tell_users(program, lines, work)
        _tell_callers(program, out, work)
    lines = {**unreached, **lines}
    return replace(program, routines=tuple(_commented(program, r, lines, work) for r in program.routines))


def _filling(program: st.Program, work: TranslationContext) -> dict[int, str]:
    """The lines that are kept as their text and give values to variables: who reads these is told."""
    words = work.conventions.filling_words
    found = (s for r in program.routines for _, s in work.look(r).rare if isinstance(s, st.Opaque))
    return {s.line: foreign_word(program.vendor, work.target) for s in found if _filled(s.text, words)}


_UNREACHED: Final = "no value of the SWITCH leads to it, as it stands before the first CASE"


def _before_cases(program: st.Program) -> dict[int, str]:
    """The lines between a SWITCH and its first branch: nothing runs them, and few compilers take them."""
    found: dict[int, str] = {}

    def note(nodes: list[Node]) -> None:
        for node in nodes:
            if not isinstance(node, Block):
                continue
            opener, first = node.branches[0]
            if isinstance(opener, st.Switch):
                rows = (s for s in flat(first) if not isinstance(s, (st.Comment, st.Declare)))
                found.update({s.line: _UNREACHED for s in rows if s.line != opener.line})
            for _, inside in node.branches:
                note(inside)

    for routine in program.routines:
        if any(type(s) is st.Switch for s in routine.body):
            note(parse(routine.body) or [])
    return found


# --- Routines that nothing calls ---
# A UR program holds the functions of all tools that are installed, most of them for sockets, inside its main function.
# Those that it never calls need not be said: what they would do is never done.

_UNCALLED: Final = "nothing calls this function, and no other program can: it is left out"
_WORD: Final = re.compile(r"\w+")


def _uncalled(program: st.Program) -> set[str]:
    """Routines inside the main one whose names stand in no text that may run, not even in a comment."""
    words = conventions_of(program.vendor).opened_by
    main = next((r for r in program.routines if r.name == program.main), None)
    if words is None or main is None:
        return set()
    nested = {r.name: r for r in program.routines if main.line < r.line and r.last_line <= main.last_line}
    inside: dict[int, st.Routine] = {}  # line -> the innermost routine around it
    for r in sorted(nested.values(), key=lambda r: r.line):
        inside.update(dict.fromkeys(_lines_of(r), r))
    texts: dict[str, set[str]] = {}
    for line, text in enumerate(program.source.lines, 1):
        around = inside.get(line)
        if around is None or line != around.line:
            texts.setdefault("" if around is None else around.name, set()).update(_WORD.findall(text))
    called, waiting = set[str](), [""]
    while waiting:
        found = texts.get(waiting.pop(), set())
        if found & words:
            return set()
        new = sorted((found & nested.keys()) - called)
        waiting += new
        called.update(new)
    return nested.keys() - called


def _lines_of(r: st.Routine) -> range:
    return range(r.line, r.last_line + 1)


def _without_uncalled(program: st.Program, out: LeftOut, work: TranslationContext) -> st.Program:
    """Without the routines that nothing calls and the target cannot say, and those of them that call such."""
    if work.source.vendor == work.target or not (uncalled := _uncalled(program)):
        return program
    own = [r for r in program.routines if r.name in uncalled]
    gone = {r.name for r in own if not out.lines.keys().isdisjoint(_lines_of(r))}
    while more := {r.name for r in own if any(gone & _named_in(s) for s in r.body)} - gone:
        gone |= more
    for r in own:
        for s in r.body if r.name in gone else ():
            if not isinstance(s, (st.Begin, st.End, st.Comment, st.Declare)):
                work.lose(s, Fate.EXACT, "statement", _UNCALLED)
    return replace(program, routines=tuple(r for r in program.routines if r.name not in gone))


def _without_data(program: st.Program, out: LeftOut, lost: _Gone, work: TranslationContext) -> st.Program:
    routines = []
    for routine in program.routines:
        name = routine.name.casefold()
        body: list[st.Statement] = []
        for s in routine.body:
            body += _declared([s], out, lost, work, name) if isinstance(s, st.Declare) else [s]
        data = tuple(_declared(routine.data, out, lost, work, name))
        routines.append(replace(routine, body=tuple(body), data=data))
    data = tuple(_declared(program.data, out, lost, work))
    return replace(program, data=data, routines=tuple(routines))


def _declared(
    data: Iterable[st.Declare], out: LeftOut, lost: _Gone, work: TranslationContext, routine: str = ""
) -> list[st.Declare]:
    """Of data that the target cannot say first the value goes, then the name. `routine`: whose (case folded)."""
    kept = []
    for one in data:
        if one.line not in out.lines or not one.line:
            kept.append(one)
        elif one.value is not None and one.line not in out.gone:
            says = f"the first value of {one.name} is left out: {out.lines[one.line]}"
            asked = any(
                isinstance(e, ex.CallValue | ex.Function | ex.SystemValue) for e in expressions_of(one)
            )
            work.lose(one, Fate.COMMENTED if asked else Fate.APPROXIMATED, "value", says)
            kept.append(replace(one, value=None))
        else:
            says = out.gone.get(one.line, out.lines[one.line])
            work.lose(one, Fate.COMMENTED, "statement", says)
            lost["" if one.shared else routine, one.name.casefold()] = says
    return kept


def _without_heads(program: st.Program, out: LeftOut, lost: _Gone) -> tuple[st.Program, dict[int, str]]:
    """A routine whose head cannot be said takes and gives nothing, and the lines that it held are to go.

    What a listing takes it only names where it is used: its head is refused again when it has been left out.
    """
    routines, bodies = [], {}
    for routine in program.routines:
        takes = routine.parameters or routine.returns or routine.line in out.gone
        if routine.line in out.lines and takes:
            says = lost["", routine.name.casefold()] = out.lines[routine.line]
            bodies.update({s.line: says for s in routine.body if s.line})
            routine = replace(routine, parameters=(), returns="", arguments=())
        routines.append(routine)
    return replace(program, routines=tuple(routines)), bodies


def _users(program: st.Program, lost: _Gone) -> dict[int, str]:
    """Lines that name what is gone, and why that is. A local variable is another one than its namesakes elsewhere."""
    if not lost:
        return {}
    found = {}
    for routine in program.routines:
        declared = (*routine.data, *(s for s in routine.body if isinstance(s, st.Declare)))
        own = {one.name.casefold() for one in routine.parameters} | {d.name.casefold() for d in declared}
        gone = {name: says for (where, name), says in lost.items() if not where and name not in own}
        gone |= {name: says for (where, name), says in lost.items() if where == routine.name.casefold()}
        for s in routine.body if gone else ():
            why = next((name for name in sorted(_named_in(s)) if name.casefold() in gone), None)
            if why is not None:
                found[s.line] = f"it needs {why}: {gone[why.casefold()]}"
    return found


def _named_in(s: st.Statement) -> set[str]:
    """Variables, functions and routines."""
    names: set[str] = set()
    for one in (s, *(s.means if isinstance(s, st.Disabled) else ())):
        note_names(one, names)
    for e in expressions_of(s):
        if isinstance(e, (ex.Function, ex.CallValue)):
            names.add(e.name if isinstance(e, ex.Function) else e.routine)
    if isinstance(s, (st.Call, st.StartTask)):
        names.add(s.routine)
    return names


def _tell_users(program: st.Program, lines: Mapping[int, str], work: TranslationContext) -> dict[int, str]:
    """Statements that stay, but need what one that goes would have set, at first or second hand.

    Moves to such a place go, too, as nobody knows where it is: their lines, and why.
    """
    lost = _Lost(program, lines)
    if not lost.origins:
        return {}
    lost.follow()
    places: dict[int, str] = {}
    for routine in program.routines:
        for index, s in enumerate(routine.body):
            if s.line in lines or isinstance(s, st.Declare):
                continue
            for name, spelled in sorted(_read_by(s).items()):
                origin = lost.reaches(routine.name, index, name)
                if origin is None:
                    continue
                setting = program.source.line(origin.line).strip()
                how = (
                    "sets in a way that the target cannot" if origin.surely else "may set, which is left out"
                )
                says = f"it needs {spelled}, which '{setting}' {how}"
                if isinstance(s, st.Move) and origin.surely and name in _places_of(s):
                    places.setdefault(s.line, says)
                else:
                    work.lose(s, Fate.APPROXIMATED, "value", says)
    return places


def _places_of(s: st.Move) -> dict[str, str]:
    """The variables that say where a move goes, as `_read_by`."""
    bare = st.Move(s.line, s.path, s.targets, parts=s.parts, via=s.via, tool=s.tool, frame=s.frame)
    return _read_by(replace(bare, offset=s.offset, tool_offset=s.tool_offset))


class _Origin(NamedTuple):
    """A statement that goes, and whether it surely sets the variable: a call may."""

    line: int
    surely: bool


_LOCAL: Final = re.compile(
    rf"l(?:{'|'.join(ex.Store)})\d+", re.IGNORECASE
)  # a numbered variable of a routine: `_key`


class _Lost:
    """Which variables do not have their value where, because the statement that gives it goes.

    Values that are computed from such ones are lost, too. What a routine loses that runs at any time (an interrupt, a
    task) is lost everywhere.
    """

    def __init__(self, program: st.Program, lines: Mapping[int, str]) -> None:
        self._program, self._lines = program, lines
        self._fixed = {d.name.casefold() for d in program.data if d.storage == "constant"}
        self._own = {r.name: {name.casefold() for name in _names_of(r)} for r in program.routines}
        self.origins: list[_Origin] = []
        # id of a statement -> what it loses, by numbers of origins
        self._made: dict[int, dict[Key, int]] = {}
        self._first: dict[Key, int] = {}  # of data that lose their first value
        self._everywhere: dict[str, int] = {}
        self._ways: Reaching | None = None
        self._note_data()
        self._note_statements()

    def _key(self, routine: str, name: str) -> Key:
        local = name in self._own.get(routine, ()) or _LOCAL.fullmatch(name) is not None
        return (routine, name) if local else ("", name)

    def _origin(self, line: int, surely: bool) -> int:
        self.origins.append(_Origin(line, surely))
        return len(self.origins)

    def _note_data(self) -> None:
        own = [("", d) for d in self._program.data]
        own += [(r.name, d) for r in self._program.routines for d in r.data]
        for scope, d in own:
            if d.line in self._lines:
                self._first[(scope, d.name.casefold())] = self._origin(d.line, True)

    def _note_statements(self) -> None:
        beside = _beside(self._program)
        for r in self._program.routines:
            for s in r.body:
                if s.line not in self._lines:
                    continue
                if isinstance(s, st.Return) and s.value:
                    result = f"{_RESULT}{r.name.casefold()}"
                    self._everywhere.setdefault(result, self._origin(s.line, True))
                for name, surely in _set_by_lost(s, self._program.vendor).items():
                    if name in self._fixed and not surely:
                        continue
                    number = self._origin(s.line, surely)
                    if r.name in beside and not self._key(r.name, name)[0]:
                        self._everywhere.setdefault(name, number)
                    self._made.setdefault(id(s), {})[self._key(r.name, name)] = number

    def follow(self) -> None:
        """Notes what is computed from lost values, until there is no more."""
        found = True
        while found:
            found = False
            self._ways = self._reaching()
            for r in self._program.routines:
                for index, s in enumerate(r.body):
                    result = f"{_RESULT}{r.name.casefold()}" if isinstance(s, st.Return) and s.value else ""
                    name = result or (None if s.line in self._lines else _set_by(s))
                    if name is None or id(s) in self._made or name in self._everywhere:
                        continue
                    origins = [o for read in _read_by(s) if (o := self._number(r.name, index, read))]
                    if origins:
                        origin = next((o for o in origins if self.origins[o - 1].surely), origins[0])
                        if result:
                            self._everywhere[result] = origin
                        else:
                            self._made[id(s)] = {self._key(r.name, name): origin}
                        found = True
            found = self._hand_back() or found

    def _hand_back(self) -> bool:
        """Notes what callers get back by reference of what a routine has lost; whether that is more than before."""
        handed = {
            (r.name, p.name.casefold())
            for r in self._program.routines
            for p in r.parameters
            if p.by_reference
        }
        inside = {
            key: number for made in self._made.values() for key, number in made.items() if key in handed
        }
        takes = {
            r.name: r.parameters for r in self._program.routines if any(r.name == name for name, _ in inside)
        }
        found = False
        for r in self._program.routines if takes else ():
            for s in r.body:
                for name, arguments in handed_over(s):
                    for parameter, value in paired(takes.get(name, ()), arguments):
                        number = inside.get((name, parameter.casefold()))
                        given = None if number is None or s.line in self._lines else _key(value)
                        made = self._made.setdefault(id(s), {}) if number and given else {}
                        if number and given and (key := self._key(r.name, given)) not in made:
                            made[key] = number
                            found = True
        return found

    def _reaching(self) -> Reaching:
        keys = {key for made in self._made.values() for key in made} | self._first.keys()
        sets: dict[int, Mapping[Key, int]] = {}
        for r in self._program.routines:
            for s in r.body:
                made = self._made.get(id(s))
                name = _set_by(s) if made is None and _sets_all(s) else None
                if name is not None and (key := self._key(r.name, name)) in keys:
                    made = {key: 0}
                if made is not None:
                    sets[id(s)] = made
        kinds = {type(s) for r in self._program.routines for s in r.body if id(s) in sets}
        return reaching(self._program, lambda s: sets.get(id(s), {}), kinds)

    def _number(self, routine: str, index: int, name: str) -> int:
        """The origin of a loss that reaches a statement, from 1; 0 where none does."""
        if name in self._everywhere:
            return self._everywhere[name]
        assert self._ways is not None
        key = self._key(routine, name)
        values = self._ways.at(routine, index, key)
        found = sorted(n for n in values if n > 0)
        if not found and (UNSET in values or ENTRY in values):
            return self._first.get(key, 0)
        return next((n for n in found if self.origins[n - 1].surely), found[0]) if found else 0

    def reaches(self, routine: str, index: int, name: str) -> _Origin | None:
        """Why a variable does not have its value before a statement, None where it has it."""
        number = self._number(routine, index, name)
        return self.origins[number - 1] if number else None


def _names_of(r: st.Routine) -> Iterator[str]:
    """What a routine declares for itself."""
    yield from (p.name for p in r.parameters)
    yield from (d.name for d in (*r.data, *(s for s in r.body if isinstance(s, st.Declare))) if not d.shared)


def _beside(program: st.Program) -> set[str]:
    """Routines that nothing calls, the main one aside: an interrupt or a task may run them at any time."""
    called = {program.main.casefold() if program.main else program.routines[0].name.casefold()}
    for s in program.statements():
        called |= {s.routine.casefold()} if isinstance(s, st.Call) else set()
        called |= {e.routine.casefold() for e in expressions_of(s) if isinstance(e, ex.CallValue)}
    return {r.name for r in program.routines if r.name.casefold() not in called}


def _sets_all(s: st.Statement) -> bool:
    """Whether a statement sets a whole variable, whatever it held."""
    if isinstance(s, st.Declare):
        return s.value is not None
    target = (
        s.result
        if isinstance(s, st.Call)
        else s.target
        if isinstance(s, (st.Assign, st.Clear, st.ReadInput))
        else None
    )
    return isinstance(target, (ex.Named, ex.Variable))


def _set_by_lost(s: st.Statement, vendor: str) -> dict[str, bool]:
    """What a statement that goes would have set, case folded, and whether it surely does."""
    found: dict[str, bool] = {}
    known = conventions_of(vendor)
    if isinstance(s, st.Opaque):
        found |= dict.fromkeys(_filled(s.text, known.filling_words), True)
    if known.filling_routines or not known.arguments_are_values:
        calls = [c for c in (s, *expressions_of(s)) if isinstance(c, (st.Call, ex.CallValue))]
        if known.arguments_are_values:
            calls = [
                replace(c, arguments=c.arguments[-1:])
                for c in calls
                if c.routine.casefold() in known.filling_routines
            ]
        for one in [a for c in calls for a in c.arguments]:
            name = _key(one.value if isinstance(one, ex.NamedArgument) else one)
            if name is not None:
                found[name] = False
    name = _set_by(s)
    if name is not None:
        found[name] = True
    elif isinstance(s, st.Move) and s.search is not None:  # beside its move stands where it found something
        found |= {e.name.casefold(): True for tag, e in s.other if not tag and isinstance(e, ex.Named)}
    return found


_CALL: Final = re.compile(r"\s*(\w+)\s*\((.*)\)\s*\Z", re.DOTALL)
_ARGUMENT: Final = re.compile(  # what stands between two commas: texts, and brackets of two levels
    r'(?:"(?:[^"\\]|\\.)*+"|[(\[{](?:[^()\[\]{}]|[(\[{][^()\[\]{}]*+[)\]}])*+[)\]}]|[^,"(\[{])++'
)
_SET: Final = re.compile(r"\s*(?:[A-Za-z]+\s+)?([.#$]?\w[\w.]*+)\s*(?:\[[^\]]*+\]\s*)?:?=(?!=)")


def _filled(text: str, words: Mapping[str, tuple[int, ...]]) -> list[str]:
    """The variables, case folded, that an instruction gives values which is kept as its text: `x = …`, `WORD x = …`,
    and arguments of `words`.
    """
    if (target := _SET.match(text)) is not None:
        return [target[1].casefold()]
    call = _CALL.match(text) if words else None
    if call is None or call[1].casefold() not in words:
        return []
    given = _ARGUMENT.findall(call[2])
    names = [_WORD.search(given[at]) for at in words[call[1].casefold()] if at < len(given)]
    return [name[0].casefold() for name in names if name is not None]


def _set_by(s: st.Statement) -> str | None:
    if isinstance(s, st.Declare):
        return s.name.casefold()
    if isinstance(s, st.Call):
        return _key(s.result)
    return _key(s.target) if isinstance(s, _SETTING) else None


def _key(e: ex.Expression | None) -> str | None:
    """What stands for a variable, case folded; None for what is none, or is found while the program runs."""
    while isinstance(e, (ex.Item, ex.Member)):
        e = e.base
    if isinstance(e, ex.Named):
        return e.name.casefold()
    if isinstance(e, ex.Variable) and isinstance(e.index, ex.Number):
        store = (
            ex.Store.ROBOT if e.store is ex.Store.SYSTEM else e.store
        )  # a position of the system holds the robot's
        return f"{'l' if e.local else ''}{store}{e.index.value:g}".casefold()
    return None


def _read_by(s: st.Statement) -> dict[str, str]:
    """Variables whose values a statement takes: case folded -> as written."""
    names: set[str] = set()
    inside: Any = s.value if isinstance(s, st.Assign) and isinstance(s.target, (ex.Named, ex.Variable)) else s
    if isinstance(s, st.Call) and isinstance(s.result, (ex.Named, ex.Variable)):
        inside = replace(s, result=None)
    note_names(inside, names)
    found = {name.casefold(): name for name in sorted(names)}
    if isinstance(s, st.Call) and s.result is not None:
        found[f"{_RESULT}{s.routine.casefold()}"] = f"what {s.routine} returns"
    for e in (inside, *expressions_of(inside)):
        if isinstance(e, ex.CallValue):
            found.setdefault(f"{_RESULT}{e.routine.casefold()}", f"what {e.routine} returns")
        elif isinstance(e, ex.Variable) and (key := _key(e)) is not None:
            found.setdefault(key, e.name or f"{e.store} variable {key.lstrip(_LETTERS)}")
    return found


def _inside(program: st.Program, lines: Mapping[int, str]) -> dict[int, str]:
    """The lines of blocks that go as a whole, because their begin, a branch or their end does."""
    found: dict[int, str] = {}

    def note(nodes: list[Node]) -> None:
        for node in nodes:
            if not isinstance(node, Block):
                continue
            marked = [m.line for m in (*(m for m, _ in node.branches), node.closer) if m.line in lines]
            if marked:
                rows = flat([node])
                found.update(
                    dict.fromkeys((s.line for s in rows if not isinstance(s, st.Comment)), lines[marked[0]])
                )
            else:
                for _, inside in node.branches:
                    note(inside)

    for routine in program.routines:
        if any(s.line in lines for s in routine.body):
            note(parse(routine.body) or [])
    return found


def _commented(
    program: st.Program, routine: st.Routine, lines: Mapping[int, str], work: TranslationContext
) -> st.Routine:
    nodes = parse(routine.body)
    if nodes is None:
        return routine
    return replace(routine, body=tuple(flat(_nodes(program, nodes, lines, work))))


def _nodes(
    program: st.Program, nodes: list[Node], lines: Mapping[int, str], work: TranslationContext
) -> list[Node]:
    result: list[Node] = []
    for node in nodes:
        if isinstance(node, Block):
            markers = [*(m for m, _ in node.branches), node.closer]
            if any(m.line in lines for m in markers):
                says = next(lines[m.line] for m in markers if m.line in lines)
                result += _all(program, list(flat([node])), says, work)
            else:
                branches = [(m, _nodes(program, inside, lines, work)) for m, inside in node.branches]
                result.append(Block(branches, node.closer))
        elif node.line in lines and not isinstance(node, (st.Begin, st.End, st.Declare, st.Comment)):
            rows = _all(program, [node], lines[node.line], work)
            result += [row for row in rows if not (isinstance(row, st.Comment) and result[-1:] == [row])]
        else:
            result.append(node)
    return result


def _all(
    program: st.Program, statements: list[st.Statement], says: str, work: TranslationContext
) -> list[Node]:
    rows: list[Node] = []
    last = 0
    for s in statements:
        if isinstance(s, st.Comment):
            rows.append(s)
            continue
        for line in sorted(
            {s.line - t.above for t in s.triggers if t.above} if isinstance(s, st.Move) else ()
        ):
            work.lose(line, Fate.COMMENTED, "statement", says)
            rows.append(st.Comment(line, untranslated(program, st.Comment(line, ""))))
        work.lose(s, Fate.COMMENTED, "statement", says)
        if s.line != last:
            rows.append(st.Comment(s.line, untranslated(program, s)))
        last = s.line
        if isinstance(s, (st.SetTool, st.SetFrame)):
            # What held before does not hold behind it: moves that would take it are left out as well.
            lost = ex.FrameRef(LOST, ex.Number(s.line))
            rows.append(st.SetTool(s.line, lost) if isinstance(s, st.SetTool) else st.SetFrame(s.line, lost))
    return rows
