"""Writes programs as RAPID modules: what `templates/rapid.j2` puts together.

Codes: X002 what RAPID cannot say.
"""

from __future__ import annotations

import os
import re
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

from olp.core.diagnostic import Diagnostic
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.expressions import Expression, Named
from olp.ir.program import Assign, Declare, Move, Program
from olp.ir.transformer import note_names
from olp.languages.generator import CannotSayError, as_text, framing_comments
from olp.languages.vendor import TRAP
from olp.languages.vendors.rapid.limits import RESERVED
from olp.languages.vendors.rapid.names import STRUCTURE, RapidNames
from olp.languages.vendors.rapid.write_statements import RapidStatements, native_type
from olp.languages.vendors.rapid.write_values import TIMED_OUT

_NAME: Final = re.compile(r"[^A-Za-z0-9_]+")
_LONGEST: Final = 32
_END: Final = {"PROC": "ENDPROC", "FUNC": "ENDFUNC", "TRAP": "ENDTRAP"}


@dataclass(slots=True)
class RapidRoutineText:
    """One routine. Texts of several lines end with a line end."""

    before: str  # data and comments between it and the routine before
    head: str
    body: str
    end: str


@dataclass(slots=True)
class RapidModuleText:
    """One module as the template sees it."""

    before: str  # what stands outside of modules
    name: str
    attributes: str
    data: str = ""  # what olp adds to the module's own
    routines: list[RapidRoutineText] = field(default_factory=list)
    after: str = ""  # behind the last routine
    closed: bool = False


def write(program: st.Program, date: str) -> tuple[dict[str, object], list[Diagnostic]]:
    """The values for the template, and everything that RAPID cannot say. Modules hold no date."""
    return RapidWriter(program).written()


_PERSISTENT: Final = ("tooldata", "wobjdata")  # a move takes none that its routine was handed as a copy


class RapidWriter(RapidStatements):
    """Writes modules."""

    def __init__(self, program: st.Program) -> None:
        structures = _structures(program)
        super().__init__(program, {}, structures)
        self.globals = {one.name.lower(): self._type(one) for one in program.data}
        self._used = {} if self.own else uses(program)
        self.globals.update({name: kind for name, kind in self._used.items() if name in self.globals})
        self.types = self.globals
        self.arrays = frozenset(one.name.lower() for one in program.data if one.sizes)
        self._lists = self.arrays
        self._data: dict[str, deque[st.Declare]] = {}
        for one in program.data:
            if one.type != STRUCTURE:  # which stands in the module's own text
                self._data.setdefault(one.name, deque()).append(one)
        self._made: list[RapidModuleText] = []
        self._pending: list[str] = []  # lines that wait for the routine or module they stand before

    def template_values(self) -> dict[str, object]:
        modules, ending = self.modules()
        return {"modules": modules, "ending": ending}

    def modules(self) -> tuple[list[RapidModuleText], str]:
        """All modules in order, and what stands behind the last one."""
        if not self._has_layout():
            self._made.append(RapidModuleText("", self._module_name(), "", closed=True))
            self._pending = list(map(self._declaration, self._take_all()))
        for routine in self.program.routines:
            self._layout(routine.details.get("before", "") if self.own else "")
            self._routine(routine)
            self._layout(routine.details.get("after", "") if self.own else "")
        if self._made:
            last = next(one for one in reversed(self._made) if one is self._made[-1])
            if not last.closed or not self._has_layout():
                last.after += self._taken()
            first = self._made[0]
            first.data = "".join(map(self._declaration, self._take_all())) + self._added()
        return self._made, self._taken()

    def _type(self, one: st.Declare) -> str:
        """RAPID's type, lower case, aliases resolved."""
        return self.names.resolved(native_type(one, self.own))

    def _has_layout(self) -> bool:
        texts = (routine.details.get("before", "") for routine in self.program.routines)
        return self.own and any(line.startswith("M ") for text in texts for line in text.split("\n"))

    def _module_name(self) -> str:
        stem = os.path.splitext(os.path.basename(self.program.path))[0]
        name = _NAME.sub("_", stem).strip("_")[:_LONGEST]
        if not name or not name[0].isalpha():
            name = f"M_{name}"[:_LONGEST].rstrip("_") if name else "Module1"
        taken = {one.name.lower() for one in self.program.routines} | set(self.globals)
        return f"M_{name}"[:_LONGEST] if name.lower() in taken or name.upper() in RESERVED else name

    # --- between routines -------------------------------------------------------------------------------------

    def _layout(self, text: str) -> None:
        """The module's own text between routines, in the order in which it was read."""
        for item in text.split("\n") if text else ():
            mark, rest = item[:1], item[2:]
            if mark == "M":
                name, _, attributes = rest.partition("(")
                self._made.append(
                    RapidModuleText(self._taken(), name, f"({attributes}" if attributes else "")
                )
            elif mark == "E":
                if self._made:
                    self._made[-1].after += self._taken()
                    self._made[-1].closed = True
            elif mark == "D":
                found = self._data.get(rest)
                if found:
                    self._pending.append(self._declaration(found.popleft()))
            elif mark == "H":
                self._pending.append(f"{rest}\n")
            else:
                self._pending.append(f"{self.step}{'!' if mark == '!' else ''}{rest}\n")

    def _taken(self) -> str:
        text = "".join(self._pending)
        self._pending.clear()
        return text

    def _take_all(self) -> list[st.Declare]:
        found = [one for same in self._data.values() for one in same]
        self._data.clear()
        return found

    def _declaration(self, one: st.Declare) -> str:
        try:
            text = self.declared_as(one, module=True)
            if self.before:
                raise CannotSayError("a value that is computed before the program runs")
        except CannotSayError as problem:
            self.lose(problem, one.line)
            return ""
        behind = f" !{one.comment}" if one.comment else ""
        above = () if self.own else one.above  # the text between routines has them
        remarks = [f"{self.step}{self.write_comment(st.Comment(0, line))}\n" for line in above]
        return f"{''.join(remarks)}{self.step}{text}{behind}\n"

    def _added(self) -> str:
        """Speeds, zones and variables that the program needs in RAPID only."""
        rows = self.declarations()
        rows += [f"LOCAL VAR {kind} {name};" for name, kind in self.temporary.items()]
        if self.timed_out:
            rows.append(f"LOCAL VAR bool {TIMED_OUT};")
        return "".join(f"{self.step}{row}\n" for row in rows)

    # --- routines ---------------------------------------------------------------------------------------------

    def _routine(self, routine: st.Routine) -> None:
        if not self._made:
            self._made.append(RapidModuleText("", self._module_name(), "", closed=True))
        local = {one.name.lower(): self._type(one) for one in routine.body if isinstance(one, st.Declare)}
        local.update({name: kind for name, kind in self._used.items() if name in local})
        local.update({one.name.lower(): self._parameter_type(one) for one in routine.parameters})
        self.types = {**self.globals, **local}
        arrays = {one.name.lower() for one in routine.parameters if one.sizes}
        arrays |= {one.name.lower() for one in routine.body if isinstance(one, st.Declare) and one.sizes}
        self.arrays = self._lists - local.keys() | arrays
        framing = framing_comments(routine, self.own)
        outside = int(routine.details.get("outside", "0"))  # comments that the text between routines has
        before = "".join(f"{self.step}!{one}\n" for one in framing.above[outside:])
        rows = self.routine_rows(framing.body, routine, self._safety(routine))
        untyped = [one.name for one in routine.parameters if not one.switch and not self._parameter_type(one)]
        if untyped:
            problem = CannotSayError(f"a parameter whose type nothing tells ({', '.join(untyped)})")
            self.lose(problem, routine.line)
        kind = routine.details.get("kind", "") if self.own else ""
        kind = kind or ("TRAP" if TRAP in routine.details else "FUNC" if routine.returns else "PROC")
        said = framing.head or routine.comment
        behind = f" !{said}" if said else ""
        gap = "\n" if self._pending or self._made[-1].routines else ""
        self._made[-1].routines.append(
            RapidRoutineText(
                f"{self._taken()}{gap}{before}",
                f"{self.step}{self._head(routine, kind)}{behind}".rstrip(),
                as_text(rows),
                f"{self.step}{_END[kind]}{' !' + framing.end if framing.end else ''}",
            )
        )

    def _safety(self, routine: st.Routine) -> list[str]:
        """Along lines the arm stays as it stands: what a pose of another language names is not watched there."""
        name = self.program.main or (self.program.routines[0].name if self.program.routines else "")
        if self.own or routine.name != name:
            return []
        moves = (one for one in self.program.statements() if isinstance(one, st.Move))
        if any(one.path is not st.Path.JOINT or not _is_joints(one) for one in moves):
            return ["ConfL \\Off;"]
        return []

    def _head(self, routine: st.Routine, kind: str) -> str:
        scope = "" if routine.shared else "LOCAL "
        returned = ""
        if kind == "FUNC":
            written = routine.details.get("returns", "") if self.own else ""
            probe = st.Declare(0, "", routine.returns)
            returned = f"{written or native_type(probe, False)} "
        parameters = "" if kind == "TRAP" else f"({self._parameters(routine.parameters)})"
        return f"{scope}{kind} {returned}{routine.name}{parameters}"

    def _parameters(self, parameters: Iterable[st.Parameter]) -> str:
        text = ""
        for one in parameters:
            instead = one.native.startswith("| ") and self.own
            native = one.native.removeprefix("| ") if self.own and one.native else ""
            word, _, stars = native.partition("{")
            if not word:
                kind = "switch" if one.switch else self._parameter_type(one)
                placed = kind in _PERSISTENT and not one.sizes
                passing = "PERS " if placed else "INOUT " if one.by_reference else ""
                word = passing + kind
                stars = ",".join("*" * len(one.sizes)) + "}" if one.sizes else ""
            mark = "\\" if one.optional and not instead else ""
            separator = " | " if instead else "," if text else ""
            text += f"{separator}{mark}{word} {one.name}{'{' + stars if stars else ''}"
        return text

    def _parameter_type(self, one: st.Parameter) -> str:
        """RAPID's type of a parameter, lower case."""
        native = one.native.removeprefix("| ").partition("{")[0].split()
        return self._type(st.Declare(0, one.name, one.type, native=native[-1] if native else ""))


def _structures(program: st.Program) -> RapidNames:
    """The structures that the program's own text declares."""
    names = RapidNames()
    fields: list[tuple[str, str]] = []
    kind = ""
    for routine in program.routines:
        for item in f"{routine.details.get('before', '')}\n{routine.details.get('after', '')}".split("\n"):
            words = item[1:].partition("!")[0].rstrip("; ").split() if item[:1] == "T" else []
            if "RECORD" in map(str.upper, words[:2]):
                kind, fields = words[-1].lower(), []
            elif words and words[0].upper() == "ENDRECORD":
                names.records[kind] = tuple(fields)
            elif words and words[0].upper() == "ALIAS" and len(words) == 3:
                names.aliases[words[2].lower()] = words[1].lower()
            elif len(words) == 2:
                fields.append((words[1], words[0].lower()))
    return names


def _is_joints(move: st.Move) -> bool:
    target = move.targets[0] if move.targets else None
    return isinstance(target, ex.PositionLiteral) and target.kind == "joint"


# --- Uses ---
# Which names of another language's program are tools and work objects: by what moves do with them.


def uses(program: Program) -> dict[str, str]:
    """Lower-case name -> tooldata or wobjdata; also of the program's data that hand their value on to one of them."""
    found = {one.name.lower(): "tooldata" for one in program.data if one.type == "tool"}
    known = {one.name.lower() for one in program.data}
    places: set[str] = set()  # names that say where moves go
    given: list[tuple[str, str]] = []
    for one in (*program.data, *program.statements()):
        if isinstance(one, Move):
            _note(found, one.tool, "tooldata")
            _note(found, one.frame, "wobjdata")
            note_names((one.targets, one.via), places)
        elif isinstance(one, Assign) and isinstance(one.target, Named) and isinstance(one.value, Named):
            given.append((one.target.name.lower(), one.value.name.lower()))
        elif isinstance(one, Declare) and isinstance(one.value, Named):
            given.append((one.name.lower(), one.value.name.lower()))
    known -= {name.lower() for name in places}
    given = [pair for pair in given if known.issuperset(pair)]
    for _ in range(len(given)):
        before = len(found)
        for target, value in given:
            if target in found or value in found:
                kind = found.get(target) or found[value]
                found.setdefault(target, kind)
                found.setdefault(value, kind)
        if len(found) == before:
            break
    return found


def _note(found: dict[str, str], value: Expression | None, kind: str) -> None:
    if isinstance(value, Named):
        found.setdefault(value.name.lower(), kind)
