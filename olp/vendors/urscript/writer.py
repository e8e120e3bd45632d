"""Writes programs as URScript: what `templates/urscript.j2` puts together.

One function holds the whole program: its data, the other functions inside it, and its instructions.

Codes: X002 what URScript cannot say.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from olp.diagnostic import Diagnostic, Span, error
from olp.expression import Expression, RecordLiteral
from olp.program import (
    Assign,
    Call,
    Declare,
    Else,
    ElseIf,
    EndIf,
    EndWhile,
    If,
    Message,
    Move,
    Pause,
    Process,
    Program,
    Routine,
    SetTool,
    StartTask,
    Statement,
    While,
)
from olp.vendors.urscript import helpers
from olp.vendors.urscript.write_moves import MoveWriter
from olp.vendors.urscript.write_statements import declared, popup, spell, tool
from olp.vendors.urscript.write_values import CannotSayError, Words

_OPENS = (If, ElseIf, Else, While)
_CLOSES = (EndIf, EndWhile, ElseIf, Else)
_FORGETS = (*_OPENS, *_CLOSES, Call)
_STEP = "  "


@dataclass(frozen=True, slots=True)
class Function:
    """One function as the template sees it: `head` without its colon; `body` of whole lines, indented."""

    head: str
    comment: str
    body: str


def write(program: Program, date: str) -> tuple[dict[str, object], list[Diagnostic]]:
    """The values for the template, and everything that URScript cannot say. `date`: scripts hold none."""
    return _ProgramWriter(program).values()


class _ProgramWriter:
    def __init__(self, program: Program) -> None:
        self.program = program
        self.problems: list[Diagnostic] = []
        self.own = program.vendor == "urscript"
        self.words = Words(self.own)
        for declare in program.data:
            _note(self.words.types, declare)
        self.words.returns = {routine.name: routine.returns for routine in program.routines}
        self.started = set() if self.own else self._started()
        self.late = {one.name for one in program.data if one.value is None} if self.own else set()

    def values(self) -> tuple[dict[str, object], list[Diagnostic]]:
        routines = self.program.routines
        main = next(
            (one for one in routines if one.name == self.program.main), routines[0] if routines else None
        )
        data = self._data()
        others = [one for one in routines if one is not main]
        functions = [self._function(one, 1) for one in others if one.details.get("kind") != "sec"]
        secondary = [self._function(one, 0) for one in others if one.details.get("kind") == "sec"]
        whole = Function("def program()", "", "") if main is None else self._function(main, 0)
        texts = [helpers.TEXTS[name] for name in helpers.TEXTS if name in self.words.used]
        return {
            "secondary": secondary,
            "program": whole,
            "data": data,
            "helpers": "".join(f"{_STEP}{line}\n" for text in texts for line in text),
            "functions": functions,
        }, self.problems

    def _data(self) -> str:
        lines = []
        for one in self.program.data:
            if self.own and one.value is None:
                continue
            try:
                lines.append(_noted(f"{_STEP}{declared(self.words, one, 'global ')}", one.comment))
            except CannotSayError as problem:
                self.lose(problem, one.line)
        return "".join(f"{line}\n" for line in lines)

    def _function(self, routine: Routine, depth: int) -> Function:
        kind = routine.details.get("kind", "def") if self.own else self._kind(routine)
        types = self.words.types
        self.words.types = {**types, **{one.name: one.type for one in routine.parameters}}
        for declare in routine.data:
            _note(self.words.types, declare)
        for statement in routine.body:
            if isinstance(statement, Declare):
                _note(self.words.types, statement)
        try:
            head = f"{kind} {routine.name}({self._parameters(routine)})"
            lines = _BodyWriter(self, routine, depth + 1).lines()
        finally:
            self.words.types = types
        return Function(head, _remark(routine.comment), "".join(f"{line}\n" for line in lines))

    def _started(self) -> set[str]:
        """The routines that run beside the one that starts them."""
        found = (s.routine for one in self.program.routines for s in one.body if isinstance(s, StartTask))
        return {name.casefold() for name in found}

    def _kind(self, routine: Routine) -> str:
        """`run` takes a thread only, and a thread can neither be called nor be handed anything."""
        if routine.name.casefold() not in self.started:
            return "def"
        called = (s.routine for one in self.program.routines for s in one.body if isinstance(s, Call))
        if routine.name == self.program.main or any(
            name.casefold() == routine.name.casefold() for name in called
        ):
            problem = CannotSayError("a routine that is both called and started", "give it under two names")
            self.lose(problem, routine.line)
        if routine.parameters:
            self.lose(CannotSayError("a task that is handed something", "store it before"), routine.line)
        return "thread"

    def _parameters(self, routine: Routine) -> str:
        texts = []
        for one in routine.parameters:
            try:
                if one.by_reference:
                    raise CannotSayError(f"a parameter that is handed back ({one.name})", "return its value")
                if one.switch:
                    raise CannotSayError(f"a switch as a parameter ({one.name})")
                texts.append(
                    one.name if one.default is None else f"{one.name}={self.words.value(one.default)}"
                )
            except CannotSayError as problem:
                self.lose(problem, routine.line)
        return ", ".join(texts)

    def lose(self, problem: CannotSayError, line: int) -> None:
        text = self.program.source.line(line)
        span = Span(line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
        message = f"URScript cannot say this: {problem}"
        path = self.program.path
        self.problems.append(error("X002", message, span, file=path, source_line=text, help=problem.help))


class _BodyWriter:
    """The lines of one routine, indented. `_tool`: what set_tcp holds as far as the text tells, None: unknown."""

    def __init__(self, program: _ProgramWriter, routine: Routine, depth: int) -> None:
        self._program = program
        self._words = program.words
        self._moves = MoveWriter(program.words)
        self._routine = routine
        self._depth = depth
        self._tool: str | None = None
        self._told: Expression | None = None  # the tool of the last move, which the next one shares
        self._lines: list[str] = []
        data = {one.name for one in program.program.data}
        # A name of the routine's own that the program has as well is its own wherever it gets a value.
        self._shadows = {
            one.name
            for one in routine.body
            if isinstance(one, Declare) and one.value is None and one.name in data
        }

    def lines(self) -> list[str]:
        if not self._words.own:
            self._add_all(self._routine.data)
        body, index = self._routine.body, 0
        while index < len(body):
            statement = body[index]
            try:
                if type(statement) is Move:
                    self._move(statement)
                    index += 1
                    continue
                taken = self._popup(body, index)
                if taken:
                    index += taken
                    continue
                self._statement(statement)
            except CannotSayError as problem:
                self._program.lose(problem, statement.line)
            index += 1
        return self._lines

    def _add_all(self, data: Sequence[Declare]) -> None:
        for one in data:
            try:
                self._add(declared(self._words, one, "local "), one.comment)
            except CannotSayError as problem:
                self._program.lose(problem, one.line)

    def _add(self, text: str, comment: str = "") -> None:
        line = f"{_STEP * self._depth}{text}"
        self._lines.append(_noted(line, comment) if comment else line)

    def _move(self, s: Move) -> None:
        if s.tool is not None and (s.tool is not self._told or self._tool is None):
            self._told = s.tool
            wanted = tool(self._words, s.tool)
            if wanted != self._tool:
                self._add(f"set_tcp({wanted})")
                self._tool = wanted
        self._add(self._moves.move(s), s.comment)

    def _statement(self, s: Statement) -> None:
        lines = spell(self._words, s)
        if isinstance(s, _CLOSES):
            self._depth = max(1, self._depth - 1)
        comment = getattr(s, "comment", "")
        for number, line in enumerate(lines):
            self._add(self._scoped(s, line), comment if number == 0 else "")
        if not lines and comment and not isinstance(s, Declare):
            self._add(f"# {_one_line(comment)}")
        if isinstance(s, _OPENS):
            self._depth += 1
        if isinstance(s, SetTool):
            self._tool, self._told = tool(self._words, s.tool), None
        elif isinstance(s, _FORGETS):
            self._tool = None

    def _scoped(self, s: Statement, line: str) -> str:
        """`global` or `local` before a name that gets its value here and nowhere above."""
        name = _stored_name(s)
        if name in self._shadows:
            return f"local {line}"
        return f"global {line}" if name in self._program.late and not self._is_own(name) else line

    def _is_own(self, name: str) -> bool:
        own = any(isinstance(one, Declare) and one.name == name for one in self._routine.body)
        return own or any(one.name == name for one in self._routine.parameters)

    def _popup(self, body: tuple[Statement, ...], index: int) -> int:
        """How many statements from here on are one popup, which is written; 0 when none are."""
        options, at = body[index], index
        if isinstance(options, Process):
            if options.name != "popup" or not self._words.own:
                return 0
            at += 1
        message = body[at] if at < len(body) else None
        if not isinstance(message, Message):
            return 0
        last = body[at + 1] if at + 1 < len(body) else None
        blocking = isinstance(last, Pause) and last.condition is None
        if not isinstance(options, Process) and not blocking:
            return 0
        given = options if isinstance(options, Process) else None
        self._add(popup(self._words, given, message, blocking), message.comment)
        return at + 1 + blocking - index


def _stored_name(s: Statement) -> str:
    from olp.expression import Named

    if isinstance(s, Assign) and isinstance(s.target, Named):
        return s.target.name
    if isinstance(s, Call) and isinstance(s.result, Named):
        return s.result.name
    return s.task if isinstance(s, StartTask) else ""


def _note(types: dict[str, str], declare: Declare) -> None:
    """What a name holds, and what its elements do."""
    array = bool(declare.sizes) or (_is_list(declare.value) and declare.type != "joints")
    types[declare.name] = "list" if array else _TYPES.get(declare.type, declare.type)
    if array:
        types[f"{declare.name}[]"] = _TYPES.get(declare.type, declare.type)


_TYPES = {"frame": "position", "tool": "position"}


def _is_list(value: Expression | None) -> bool:
    return isinstance(value, RecordLiteral) and all(not name for name, _ in value.members)


def _noted(line: str, comment: str) -> str:
    return f"{line}{_remark(comment)}"


def _remark(comment: str) -> str:
    return f"  # {_one_line(comment)}" if comment else ""


def _one_line(text: str) -> str:
    return " ".join(text.splitlines()).strip()
