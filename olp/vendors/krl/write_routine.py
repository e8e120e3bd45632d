"""Spells the routines of a program: head, declarations, statements in order."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Protocol

from olp import called
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
from olp.vendors.krl.scope import NEUTRAL_TYPES, Scope
from olp.vendors.krl.write_moves import MoveWriter
from olp.vendors.krl.write_poses import computed_first
from olp.vendors.krl.write_statements import HELPERS, SPELLINGS
from olp.vendors.krl.write_values import CannotSayError, Words

TYPES: Final = {neutral: word for word, neutral in NEUTRAL_TYPES.items() if word not in ("POS", "AXIS")}
HEADER: Final = "&ACCESS RVP\n&REL 1\n"
# Without INITMOV $VEL, $ACC and their like hold what the last program left, or nothing at all. It halves the axes'
# acceleration, which is the rated one in all other languages.
_INI: Final = (
    ";FOLD INI",
    "  BAS (#INITMOV,0)",
    *(f"  $ACC_AXIS[{axis}]=100" for axis in range(1, 7)),
    ";ENDFOLD (INI)",
)
_OPENS: Final = (If, While, For, Repeat, Switch)
_CLOSES: Final = (EndIf, EndWhile, Next, Until, EndSwitch)
_MIDDLE: Final = (Else, ElseIf, Case, Default)
_FORGETS: Final = frozenset((*_CLOSES, *_MIDDLE, While, For, Repeat, Label, Call))
_DEEPER: Final = frozenset((*_OPENS, *_MIDDLE))
_BLOCKS: Final = frozenset((*_OPENS, *_CLOSES, *_MIDDLE, Process))
_MODAL: Final = frozenset((SetSpeed, SetAcceleration, SetBlend, SetTool, SetFrame, SetOverride))
_FIRST: Final = frozenset((SetSpeed, SetAcceleration))  # whose comment stands behind their first line
_DEEPEST: Final = 20  # levels of blanks before a line


class FileWriter(Protocol):
    """The file that a routine belongs to."""

    own: bool
    scope: Scope
    words: Words

    def lose(self, problem: CannotSayError, line: int) -> None: ...

    def begins(self, routine: Routine) -> bool: ...


@dataclass(frozen=True, slots=True)
class RoutineText:
    """One routine as the template sees it. Texts of several lines end with a line end."""

    above: str  # &ACCESS lines and comments that stand before it
    head: str  # DEF NAME ( )
    declarations: str
    instructions: str
    end: str
    below: str


class RoutineWriter:
    """Spells one routine. `data`: what is declared in it because no other routine uses it."""

    def __init__(self, file: FileWriter, routine: Routine, data: tuple[Declare, ...], first: bool) -> None:
        self.file = file
        self.routine = routine
        self.first = first
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
        head = ""
        try:
            head = self._head()
            self.declarations += write_data.parameter_rows(self.words, routine.parameters)
        except CannotSayError as problem:
            self.file.lose(problem, routine.line)
        if self.file.begins(routine):
            self.lines += _INI
        for one in self.data:
            self._declare(one)
        self._body()
        helpers = {name: word for name, word in HELPERS.items() if self._needs_helpers()}
        self.declarations += [
            f"DECL {word} {name}" for name, word in (*helpers.items(), *self.temporaries.items())
        ]
        return RoutineText(
            above=above + "\n" if above else (HEADER if self.first and not self.own else ""),
            head=head,
            declarations=as_text(self.declarations),
            instructions=as_text(self.lines),
            end="ENDFCT" if routine.returns else "END",
            below=details["below"] + "\n" if "below" in details else "",
        )

    def _needs_helpers(self) -> bool:
        return any(isinstance(one, Wait) and one.timeout is not None for one in self.routine.body)

    def _head(self) -> str:
        routine = self.routine
        shared = "GLOBAL " if "GLOBAL" in routine.details and self.own else ""
        given = write_data.parameters_text(routine.parameters, self.own)
        if routine.returns:
            word = TYPES.get(routine.returns) or routine.returns
            return f"{shared}DEFFCT {word} {routine.name} ({given})"
        return f"{shared}DEF {routine.name} ({given or ' '})"

    # --- declarations -----------------------------------------------------------------------------------

    def _declare(self, it: Declare) -> None:
        """In KRL a program's declarations come first and take no values: these are assigned."""
        try:
            if self.own:
                self.lines.append(write_data.declared(self.words, it, with_value=True) + behind(it.comment))
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
        kind = type(one)
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
        self._add(lines, getattr(one, "comment", ""), 0 if kind in _FIRST else -1)
        if kind in _FORGETS:
            self.moves.forget()
        if kind in _DEEPER:
            self.depth += 1
        if self.bas is not None:
            self.bas.follow(one)

    def _spelt(self, one: Statement) -> list[str]:
        kind = type(one)
        if isinstance(one, Move):
            before, move = computed_first(one, self.words, self.temporaries)
            return [*before, *self.moves.move(move)] if before else self.moves.move(move)
        if kind in _MODAL:
            return self._modal(one)
        if kind in _BLOCKS:
            found = self._block(one)
            if found is not None:
                return found
        if kind not in SPELLINGS:
            raise CannotSayError(called.statement(one))
        before, one = computed_first(one, self.words, self.temporaries)
        return [*before, *SPELLINGS[kind](self.words, one)]

    def _block(self, one: Statement) -> list[str] | None:
        """What opens or closes a block, where its words depend on what stands around it."""
        if isinstance(one, (*_CLOSES, *_MIDDLE)):
            self.depth = max(self.depth - 1, 0)
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
        return None

    def _else_if(self, one: ElseIf) -> list[str]:
        """KRL has none: an IF within ELSE, which its own ENDIF closes."""
        condition = self.words.expression(one.condition)
        if self.own:
            return [f"ELSEIF {condition} THEN"]
        if self.nested:
            self.nested[-1] += 1
        return ["ELSE", f"IF {condition} THEN"]

    def _modal(self, one: Statement) -> list[str]:
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
        assert isinstance(one, SetOverride)
        return moves.set_override(one)

    def _add(self, lines: Iterable[str], comment: str, place: int = -1) -> None:
        indent = "  " * min(self.depth, _DEEPEST)
        rows = [f"{indent}{line}" for line in lines]
        if comment and rows:
            rows[place] += behind(comment)
        self.lines += rows


def behind(comment: str) -> str:
    return f" ;{comment}" if comment else ""


def as_text(lines: Iterable[str]) -> str:
    return "".join(f"{line}\n" for line in lines)
