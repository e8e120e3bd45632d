"""Writes programs as KRL: what `templates/krl.j2` puts together.

Codes: X002 what KRL cannot say.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import PureWindowsPath
from typing import Final

from olp.diagnostic import Diagnostic, Span, error
from olp.moves import Move, SetAcceleration, SetBlend, SetFrame, SetOverride, SetSpeed, SetTool
from olp.program import (
    Begin,
    Call,
    Case,
    Declare,
    Default,
    Else,
    ElseIf,
    End,
    EndIf,
    EndSwitch,
    EndWhile,
    For,
    If,
    Label,
    Next,
    Process,
    Program,
    Repeat,
    Routine,
    Statement,
    Switch,
    Until,
    Wait,
    While,
)
from olp.vendors.krl import write_data
from olp.vendors.krl.bas_calls import BasCalls
from olp.vendors.krl.neighbours import CONFIG_MARK
from olp.vendors.krl.scope import NEUTRAL_TYPES, Scope
from olp.vendors.krl.write_data import is_of_config
from olp.vendors.krl.write_moves import MoveWriter
from olp.vendors.krl.write_poses import computed_first
from olp.vendors.krl.write_statements import HELPERS, SPELLINGS
from olp.vendors.krl.write_values import CannotSayError, Words

_OPENS: Final = (If, While, For, Repeat, Switch)
_CLOSES: Final = (EndIf, EndWhile, Next, Until, EndSwitch)
_MIDDLE: Final = (Else, ElseIf, Case, Default)
_FORGETS: Final = (*_CLOSES, *_MIDDLE, While, For, Repeat, Label, Call)
_DEEPEST: Final = 20  # levels of blanks before a line
_HEADER: Final = "&ACCESS RVP\n&REL 1\n"
_TYPES: Final = {neutral: word for word, neutral in NEUTRAL_TYPES.items() if word not in ("POS", "AXIS")}


@dataclass(frozen=True, slots=True)
class RoutineText:
    """One routine as the template sees it. Texts of several lines end with a line end."""

    above: str  # &ACCESS lines and comments that stand before it
    head: str  # DEF NAME ( )
    declarations: str
    instructions: str
    end: str
    below: str


def write(program: Program, date: str, pair: bool = False) -> tuple[dict[str, object], list[Diagnostic]]:
    """The values for the template, and everything that KRL cannot say. KRL programs hold no `date`.

    `pair`: data go into a list beside the program, "companions" {".dat": text}; else they are declared in the one
    routine that uses them, and what several routines share stands in a list behind the program.
    """
    del date
    writer = _Writer(program, pair)
    return writer.values(), writer.problems


class _Writer:
    def __init__(self, program: Program, pair: bool) -> None:
        self.program = program
        self.own = program.vendor == "krl"
        self.problems: list[Diagnostic] = []
        self.pair = pair
        self.scope = _scope_of(program)
        main = program.main
        ordered = sorted(program.routines, key=lambda one: bool(main) and one.name != main)
        self.routines = list(program.routines) if self.own else ordered
        strings = frozenset(one.name for one in _all_data(program) if one.type == "string" and not self.own)
        self.words = Words(self.scope, self.own, strings)

    def values(self) -> dict[str, object]:
        local, shared = self._places()
        texts = tuple(_RoutineWriter(self, one, local.get(one.name, ())).text() for one in self._programs())
        list_text = self._list(shared)
        values: dict[str, object] = {"routines": texts, "list": "" if self.pair else list_text}
        if self.pair and list_text:
            values["companions"] = {".dat": list_text}
        return values

    def _programs(self) -> list[Routine]:
        return [one for one in self.routines if "list" not in one.details or not self.own]

    def _places(self) -> tuple[dict[str, tuple[Declare, ...]], list[Declare]]:
        """(data declared in a routine, by its name; data of the list)."""
        rows = [one for one in self.program.data if not is_of_config(one)]
        rows += [one for routine in self.routines for one in routine.data]
        if self.pair or self.own:
            return {}, rows
        local: dict[str, tuple[Declare, ...]] = {}
        shared: list[Declare] = []
        users = _users(self.program)
        first = self.routines[0].name if self.routines else ""
        for one in rows:
            names, assigned = users.get(one.name, (set(), False))
            if len(names) == 1 and (not assigned or names == {first}):
                local[next(iter(names))] = (*local.get(next(iter(names)), ()), one)
            else:
                shared.append(one)
        return local, shared

    def _list(self, rows: list[Declare]) -> str:
        lists = [one for one in self.routines if "list" in one.details] if self.own else []
        details = next((one.details for one in self.routines if "data head" in one.details and self.own), {})
        if not rows and not lists and not details:
            return ""
        owner = lists[0] if lists else None
        stem = (
            PureWindowsPath(self.program.path.replace("/", "\\")).stem
            if self.own and self.program.path
            else ""
        )
        name = owner.name if owner else (self.program.main or stem or self._first_name())
        above = owner.details.get("above", "") if owner else details.get("data above", "")
        public = " PUBLIC" if owner is not None and owner.details["list"] == "PUBLIC" else ""
        head = [details.get("data head", f"DEFDAT {name}{public}")]
        if "data rows" in details:
            head.append(details["data rows"])
        try:
            return (above + "\n" if above else "" if self.own else _HEADER) + _text(
                [*head, *write_data.rows(self.words, rows), "ENDDAT"]
            )
        except CannotSayError as problem:
            self.lose(problem, 0)
            return ""

    def _first_name(self) -> str:
        return self.routines[0].name if self.routines else "PROGRAM"

    def lose(self, problem: CannotSayError, line: int) -> None:
        text = self.program.source.line(line)
        span = Span(line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
        message = f"KRL cannot say this: {problem}"
        self.problems.append(
            error("X002", message, span, file=self.program.path, source_line=text, help=problem.help)
        )


class _RoutineWriter:
    def __init__(self, file: _Writer, routine: Routine, data: tuple[Declare, ...]) -> None:
        self.file = file
        self.routine = routine
        self.words = file.words
        self.own = file.own
        self.moves = MoveWriter(file.words)
        self.bas = BasCalls(file.scope, file.words) if self.own else None
        self.data = data
        self.depth = 0
        self.ends: list[str] = []
        self.nested: list[int] = []  # blocks that an ELSEIF opened, per IF
        self.declarations: list[str] = []
        self.lines: list[str] = []
        self.temporaries: dict[str, str] = {}

    def text(self) -> RoutineText:
        routine = self.routine
        details = routine.details if self.own else {}
        above = details.get("above", "")
        first = not self.own and self.file.routines[0] is routine
        head = ""
        try:
            head = self._head()
            self.declarations += write_data.parameter_rows(self.words, routine.parameters)
        except CannotSayError as problem:
            self.file.lose(problem, routine.line)
        for one in self.data:
            self._declare(one)
        self._body()
        helpers = {name: word for name, word in HELPERS.items() if self._needs_helpers()}
        self.declarations += [
            f"DECL {word} {name}" for name, word in (*helpers.items(), *self.temporaries.items())
        ]
        return RoutineText(
            above=above + "\n" if above else (_HEADER if first else ""),
            head=head,
            declarations=_text(self.declarations),
            instructions=_text(self.lines),
            end="ENDFCT" if routine.returns else "END",
            below=details["below"] + "\n" if "below" in details else "",
        )

    def _needs_helpers(self) -> bool:
        return any(isinstance(one, Wait) and one.timeout is not None for one in self.routine.body)

    def _head(self) -> str:
        routine = self.routine
        shared = "GLOBAL " if "GLOBAL" in routine.details and self.own else ""
        given = write_data.parameters_text(routine.parameters)
        if routine.returns:
            word = _TYPES.get(routine.returns) or routine.returns
            return f"{shared}DEFFCT {word} {routine.name} ({given})"
        return f"{shared}DEF {routine.name} ({given or ' '})"

    # --- declarations -----------------------------------------------------------------------------------

    def _declare(self, it: Declare) -> None:
        """In KRL a program's declarations come first and take no values: these are assigned."""
        try:
            if self.own:
                self.lines.append(write_data.declared(self.words, it, with_value=True) + _behind(it.comment))
                self.lines += write_data.elements(self.words, it)
                return
            self.declarations.append(write_data.declared(self.words, it, with_value=False))
            if it.value is None:
                return
            if it.sizes or it.type == "string":
                self._add(list(write_data.elements(self.words, it)), it.comment)
            else:
                self._add([f"{it.name}={self.words.expression(it.value)}"], it.comment)
        except CannotSayError as problem:
            self.file.lose(problem, it.line)

    # --- instructions -----------------------------------------------------------------------------------

    def _body(self) -> None:
        body = self.routine.body
        place = 0
        while place < len(body):
            taken = self.bas.call(body, place) if self.bas is not None else None
            if taken is not None:
                count, line = taken
                self.moves.forget()
                comment = getattr(body[place + count - 1], "comment", "")
                self._add([line], comment)
                place += count
                continue
            self._statement(body[place])
            place += 1

    def _statement(self, one: Statement) -> None:
        if isinstance(one, (Begin, End)):
            if one.comment:
                self.lines.append(f";{one.comment}")
            return
        if isinstance(one, Declare):
            self._declare(one)
            return
        try:
            lines = self._spelt(one)
        except CannotSayError as problem:
            self.file.lose(problem, one.line)
            return
        self._add(
            lines, getattr(one, "comment", ""), 0 if isinstance(one, (SetSpeed, SetAcceleration)) else -1
        )
        if isinstance(one, _FORGETS):
            self.moves.forget()
        if isinstance(one, (*_OPENS, *_MIDDLE)):
            self.depth += 1
        if self.bas is not None:
            self.bas.follow(one)

    def _spelt(self, one: Statement) -> list[str]:
        if isinstance(one, (*_CLOSES, *_MIDDLE)):
            self.depth = max(self.depth - 1, 0)
        if isinstance(one, Move):
            before, move = computed_first(one, self.words, self.temporaries)
            return [*before, *self.moves.move(move)]
        found = self._modal(one)
        if found is not None:
            return found
        if isinstance(one, ElseIf):
            return self._else_if(one)
        if isinstance(one, If):
            self.nested.append(0)
        if isinstance(one, EndIf):
            return ["ENDIF"] * (1 + (self.nested.pop() if self.nested else 0))
        if isinstance(one, While):
            lines = SPELLINGS[While](self.words, one)
            self.ends.append("ENDLOOP" if lines == ["LOOP"] else "ENDWHILE")
            return lines
        if isinstance(one, EndWhile):
            return [self.ends.pop() if self.ends else "ENDWHILE"]
        if isinstance(one, Process) and one.name == "ENDSPLINE":
            return [self.moves.end_block()]
        if isinstance(one, Process) and one.name in ("SPLINE", "PTP_SPLINE"):
            self.moves.in_block = True
        if type(one) not in SPELLINGS:
            raise CannotSayError(f"a statement of the kind {type(one).__name__}")
        before, one = computed_first(one, self.words, self.temporaries)
        return [*before, *SPELLINGS[type(one)](self.words, one)]

    def _else_if(self, one: ElseIf) -> list[str]:
        """KRL has none: an IF within ELSE, which its own ENDIF closes."""
        condition = self.words.expression(one.condition)
        if self.own:
            return [f"ELSEIF {condition} THEN"]
        if self.nested:
            self.nested[-1] += 1
        return ["ELSE", f"IF {condition} THEN"]

    def _modal(self, one: Statement) -> list[str] | None:
        moves = self.moves
        if isinstance(one, SetSpeed):
            return moves.set_speed(one)
        if isinstance(one, SetAcceleration):
            return moves.set_acceleration(one)
        if isinstance(one, SetBlend):
            return moves.set_blend(one)
        if isinstance(one, (SetTool, SetFrame)):
            before, one = computed_first(one, self.words, self.temporaries)
            assert isinstance(one, (SetTool, SetFrame))
            return [*before, *(moves.set_tool(one) if isinstance(one, SetTool) else moves.set_frame(one))]
        return moves.set_override(one) if isinstance(one, SetOverride) else None

    def _add(self, lines: Iterable[str], comment: str, place: int = -1) -> None:
        indent = "  " * min(self.depth, _DEEPEST)
        rows = [f"{indent}{line}" for line in lines]
        if comment and rows:
            rows[place] += _behind(comment)
        self.lines += rows


def _behind(comment: str) -> str:
    return f" ;{comment}" if comment else ""


def _text(lines: Iterable[str]) -> str:
    return "".join(f"{line}\n" for line in lines)


def _all_data(program: Program) -> Iterable[Declare]:
    yield from program.data
    for routine in program.routines:
        yield from routine.data
        yield from (one for one in routine.body if isinstance(one, Declare))


def _scope_of(program: Program) -> Scope:
    """Types and values of all data, as the reader would know them."""
    scope = Scope()
    for one in _all_data(program):
        native = one.native.removesuffix(CONFIG_MARK) if program.vendor == "krl" else ""
        scope.declare(one.name, native or _TYPES.get(one.type, one.type.upper()), bool(one.sizes))
        if one.native == "STRUC":
            members = getattr(one.value, "members", ())
            scope.structures[one.name.upper()] = {name.upper(): it.type for name, it in members}
    for one in (*program.data, *(one for routine in program.routines for one in routine.data)):
        if one.value is not None:
            scope.values[one.name.upper()] = one.value
    for routine in program.routines:
        for given in routine.parameters:
            word = given.native.removesuffix("[]") if program.vendor == "krl" else ""
            scope.declare(given.name, word or _TYPES.get(given.type, ""), given.native.endswith("[]"))
    return scope


def _users(program: Program) -> dict[str, tuple[set[str], bool]]:
    """Name -> (the routines that use it, whether one of them assigns it)."""
    from olp.vendors.krl.naming import names_in

    found: dict[str, tuple[set[str], bool]] = {}
    for routine in program.routines:
        for one in routine.body:
            for name, assigned in names_in(one):
                names, before = found.get(name, (set(), False))
                found[name] = (names | {routine.name}, before or assigned)
    return found
