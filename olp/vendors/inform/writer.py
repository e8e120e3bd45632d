"""Writes programs as INFORM jobs: what `templates/inform.j2` puts together.

Codes: X002 what INFORM cannot say.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from olp.diagnostic import Diagnostic, Span, error
from olp.expression import Store, Variable
from olp.program import Case, Move, Program, Reference, Routine, SetSpeed, Statement, Switch
from olp.vendors.inform.write_moves import MoveWriter
from olp.vendors.inform.write_positions import PositionWriter
from olp.vendors.inform.write_statements import SPELLINGS, vendor_words_only
from olp.vendors.inform.write_values import LETTERS, CannotSayError, Words
from olp.vendors.vendor import language_of

_COUNTED = tuple(store for store in LETTERS if store is not Store.SYSTEM)
_COMMENT_ROWS = 8


@dataclass(frozen=True, slots=True)
class Job:
    """One job as the template sees it. Texts of several lines end with a line end."""

    name: str
    folder: str
    counts: str  # ///NPOS
    positions: str
    global_counts: str  # of the named variables, like local_counts; empty: none is named
    global_names: str
    local_counts: str
    local_names: str
    argument_types: str
    argument_comments: str | None  # None: no ///COMMENT
    has_arguments: bool
    date: str
    comment: str
    attributes: str
    frame: str
    frame_record: str
    groups: tuple[str, ...]
    locals: str  # ///LVARS: the allocated ones; empty: none
    instructions: str


def write(program: Program, date: str) -> tuple[dict[str, object], list[Diagnostic]]:
    """The values for the template, and everything that INFORM cannot say.

    `date`: YYYY/MM/DD HH:MM, for jobs that have none.
    """
    problems: list[Diagnostic] = []
    jobs = tuple(_JobWriter(program, routine, problems, date).job() for routine in program.routines)
    return {"jobs": jobs}, problems


class _JobWriter:
    def __init__(self, program: Program, routine: Routine, problems: list[Diagnostic], date: str) -> None:
        self.program = program
        self.routine = routine
        self.problems = problems
        self.own = program.vendor == "inform"
        self.date = date
        attributes = routine.details.get("ATTR", "")
        self.old = self.own and attributes[:1].isdigit()  # ERC writes flags, all later generations words
        if self.old:
            self.words = Words(routine.aliases, digits=3, point_digits=3, station_letter="E")
        else:
            self.words = Words(routine.aliases)

    def job(self) -> Job:
        routine, details = self.routine, self.routine.details if self.own else {}
        writer = PositionWriter(routine.points, exact=self.own, old=self.old)
        counts = positions = ""
        try:
            counts, positions = writer.counts(), _text(writer.lines())
        except CannotSayError as problem:
            self._lose(problem, routine.line)
        types = details.get("ARGTYPE") or _types(routine)
        rows = details.get("COMMENT")
        global_counts, global_names = self._names(local=False)
        local_counts, local_names = self._names(local=True)
        return Job(
            name=routine.name,
            folder=details.get("FOLDERNAME", ""),
            counts=counts,
            positions=positions,
            global_counts=global_counts,
            global_names=global_names,
            local_counts=local_counts,
            local_names=local_names,
            argument_types=types,
            argument_comments=None if rows is None else _text(rows.split("\n")),
            has_arguments=bool(types) or rows is not None,
            date=details.get("DATE") or self.date,
            comment=routine.comment,
            attributes=details.get("ATTR") or ("SC,RW,RJ" if routine.relative_to else "SC,RW"),
            frame=self._frame(),
            frame_record="///FRAME" if self.old else "////FRAME",
            groups=tuple(",".join(group.mechanisms) for group in routine.groups),
            locals=_counts(routine.locals) if routine.locals else "",
            instructions=_text(self._instructions()),
        )

    # --- header -----------------------------------------------------------------------------------------

    def _frame(self) -> str:
        frame = self.routine.relative_to
        if frame is None:
            return ""
        if frame.number is None:
            return frame.kind.upper()
        number = self.words.value(frame.number)
        return number if self.old else f"USER {number}"

    def _names(self, local: bool) -> tuple[str, str]:
        """The counts and rows of //ALIAS for the named local or global variables."""
        found = [(name, it) for name, it in self.routine.aliases.items() if it.local == local]
        order: list[Store] = list(_COUNTED)
        found.sort(key=lambda pair: (order.index(pair[1].store), _index(pair[1])))
        sizes = {store: sum(it.store is store for _, it in found) for store in order}
        letter = "L" if local else ""
        rows = _text(f"{letter}{LETTERS[it.store]}{_index(it):03d} {name}" for name, it in found)
        return (_counts(sizes) if found else ""), rows

    # --- instructions -----------------------------------------------------------------------------------

    def _instructions(self) -> list[str]:
        moves, words = MoveWriter(self.words), self.words
        lines: list[str] = []
        switch: Switch | None = None
        for statement in self.routine.body:
            try:
                if isinstance(statement, Move):
                    text = moves.move(statement)
                elif isinstance(statement, Reference):
                    text = moves.reference(statement)
                elif isinstance(statement, SetSpeed):
                    text = moves.set_speed(statement)
                else:
                    text = self._other(words, statement)
            except CannotSayError as problem:
                self._lose(problem, statement.line)
                continue
            comment = getattr(statement, "comment", "")
            if comment:
                text = f"{text}  //{comment}"
            if switch is not None and isinstance(statement, Case) and statement.line == switch.line:
                lines[-1] += f" {text}"  # SWITCH and its first CASE may share a line
            else:
                lines.append(text)
            switch = statement if isinstance(statement, Switch) and not comment else None
        return lines

    def _other(self, words: Words, statement: Statement) -> str:
        if not self.own and vendor_words_only(statement):
            raise CannotSayError(f"a word of {language_of(self.program.vendor)} that means nothing in INFORM")
        return SPELLINGS[type(statement)](words, statement)

    def _lose(self, problem: CannotSayError, line: int) -> None:
        text = self.program.source.line(line)
        span = Span(line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
        message = f"INFORM cannot say this: {problem}"
        self.problems.append(
            error("X002", message, span, file=self.program.path, source_line=text, help=problem.help)
        )


def _text(lines: Iterable[str]) -> str:
    return "".join(f"{line}\n" for line in lines)


def _index(variable: Variable) -> int:
    value = getattr(variable.index, "value", None)
    assert isinstance(value, int)  # a name stands for one variable, never for a computed one
    return value


def _counts(sizes: object) -> str:
    assert isinstance(sizes, dict)
    return ",".join(str(sizes.get(store, 0)) for store in _COUNTED)


def _types(routine: Routine) -> str:
    """///ARGTYPE: eight letters or nothings with commas."""
    if not routine.arguments:
        return ""
    letters = ["" if store is None else LETTERS[store] for store in routine.arguments]
    return ",".join([*letters, *[""] * (_COMMENT_ROWS - len(letters))])
