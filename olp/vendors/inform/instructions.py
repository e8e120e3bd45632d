"""The lines between //INST and END: the fast path first, then lines seen before, then the grammar."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from operator import attrgetter
from typing import Any, Final

from olp.diagnostic import Severity, Span
from olp.expression import Variable
from olp.program import Comment, LineKind, Opaque, Statement
from olp.vendors.inform.fast import MoveLines
from olp.vendors.inform.findings import Findings

_FIRST_WORD = re.compile(r"\s*([^\s*(=#\"']*)")
_OPERATORS = "+-*/("
_MOST_OPERATORS = (
    200  # a nesting that no controller takes, and that would exhaust the stack of an interpreter
)
_MOST_CHARACTERS = 4096
_MOST_BROKEN = 2000
_MOST_CACHED = 50_000

# A statement's class and all its values but the line.
_Template = tuple[Callable[..., Statement], tuple[Any, ...]]
_seen: dict[str, _Template] = {}


class Instructions:
    """Reads the instruction lines of one job."""

    def __init__(self, findings: Findings, moves: MoveLines, aliases: Mapping[str, Variable]) -> None:
        self._findings = findings
        self._kinds = findings.kinds
        self._moves = moves
        self._aliases = aliases
        self._own: dict[str, _Template] = {}
        self._mangle: Callable[[str], str] | None = None
        self._broken: dict[str, int] = {}

    def read(self, lines: Sequence[str], first: int) -> list[Statement]:
        """The statements in `lines`, the first of which is line `first` of the file."""
        body: list[Statement] = []
        move, seen, own, kinds = self._moves.read, _seen, self._own, self._kinds
        for number, line in enumerate(lines, first):
            statement: Statement | None = move(line, number)
            if statement is None:
                template = own.get(line) or seen.get(line)
                statement = template[0](number, *template[1]) if template else self._read(line, number)
                if statement is None:
                    continue
                if type(statement) is Comment:
                    kinds[number - 1] = LineKind.COMMENT
                elif type(statement) is not Opaque:
                    kinds[number - 1] = LineKind.STATEMENT
            else:
                kinds[number - 1] = LineKind.STATEMENT
            body.append(statement)
        return body

    def _read(self, line: str, number: int) -> Statement | None:
        text = line.rstrip("\x1a \t")
        if not text.strip():
            return None
        if text[0] == "'":
            return Comment(number, text[1:])
        if len(text) > _MOST_CHARACTERS or (
            len(text) > _MOST_OPERATORS and sum(map(text.count, _OPERATORS)) > _MOST_OPERATORS
        ):
            message = f"an instruction of {len(text)} characters is longer than any controller takes"
            help = f"at most {_MOST_CHARACTERS} characters and {_MOST_OPERATORS} operators are read"
            self._findings.error("P023", message, Span(number, 1, len(text) + 1), help)
            return None
        word = _first_word(text)
        from olp.vendors.inform.grammar import instruction_parser

        if word and word not in instruction_parser().words:
            return self._opaque(text, word, number)
        return self._parse(text, line, number)

    def _opaque(self, text: str, word: str, number: int) -> Opaque:
        from difflib import get_close_matches

        from olp.vendors.inform.grammar import instruction_parser

        self._kinds[number - 1] = LineKind.OPAQUE
        start = len(text) - len(text.lstrip()) + 1
        near = get_close_matches(word[:40].upper(), instruction_parser().words, 1, 0.75)
        self._findings.once(
            Severity.INFO,
            "P021",
            word,
            f"{word[:40]} is kept but not modelled",
            Span(number, start, start + len(word)),
            help=f"did you mean {near[0]}?" if near else "its effect on the time is unknown",
        )
        return Opaque(number, text.strip())

    def _parse(self, text: str, line: str, number: int) -> Statement | None:
        from lark.exceptions import UnexpectedInput

        from olp.vendors.inform.expressions import BrokenLineError
        from olp.vendors.inform.grammar import instruction_parser
        from olp.vendors.inform.problems import Problem, explain

        try:
            try:
                parsed = instruction_parser().parse(self._mangled(text, False), self._aliases)
            except UnexpectedInput:
                again = self._mangled(text, True)
                if again == text:
                    raise
                parsed = instruction_parser().parse(again, self._aliases)
        except UnexpectedInput as refused:
            self._report(explain(refused, text), number)
            return None
        except BrokenLineError as broken:
            problem = Problem(broken.message, broken.column, broken.end_column, broken.wanted)
            self._report(problem, number)
            return None
        statement = parsed.statement
        template = (type(statement), _values(statement))
        if not parsed.remarks:
            _remember(self._own if parsed.named else _seen, line, template)
        for remark in parsed.remarks:
            self._remark(
                remark.code, remark.text, Span(number, remark.column, remark.column + len(remark.text))
            )
        return template[0](number, *template[1])

    def _mangled(self, text: str, every: bool) -> str:
        from olp.vendors.inform.names import Mangler, is_plain

        if not self._aliases:
            return text
        if every:
            return Mangler(self._aliases)(text)
        if self._mangle is None:
            self._mangle = Mangler(name for name in self._aliases if not is_plain(name))
        return self._mangle(text)

    def _report(self, problem: Any, number: int) -> None:
        self._broken["lines"] = self._broken.get("lines", 0) + 1
        help = f"expected {problem.wanted}" if problem.wanted else ""
        self._findings.error(
            "P020", problem.message, Span(number, problem.column, problem.end_column), help=help
        )

    def _remark(self, code: str, text: str, span: Span) -> None:
        severity, key, message, help = REMARKS[code]
        self._findings.once(
            severity, code, text if key else code, message.format(text), span, help.format(text)
        )


# code: severity, whether each text is told on its own, message, help
REMARKS: Final = {
    "P033": (
        Severity.WARNING,
        False,
        "a ' comment behind an instruction, which the controller refuses",
        "write it on a line of its own, or with // behind a move",
    ),
    "P036": (Severity.WARNING, False, "JMP is read as JUMP", "write JUMP"),
    "P040": (
        Severity.INFO,
        False,
        "EDTLCK locks a line against editing; only its instruction is modelled",
        "",
    ),
    "P041": (
        Severity.WARNING,
        True,
        "the name {} is not in //ALIAS",
        "add its variable to //ALIAS, or write the variable itself",
    ),
}


def _first_word(text: str) -> str:
    match = _FIRST_WORD.match(text)
    return match[1] if match else ""


def _remember(cache: dict[str, _Template], line: str, template: _Template) -> None:
    if len(cache) >= _MOST_CACHED:
        cache.clear()
    cache[line] = template


_getters: dict[type, Callable[[Any], tuple[Any, ...]]] = {}


def _values(statement: Statement) -> tuple[Any, ...]:
    """All fields but the line, in the order of the constructor."""
    kind = type(statement)
    getter = _getters.get(kind)
    if getter is None:
        names = [one.name for one in fields(statement)][1:]
        if not names:
            getter = _nothing
        elif len(names) == 1:
            getter = _single(names[0])
        else:
            getter = attrgetter(*names)
        _getters[kind] = getter
    return getter(statement)


def _nothing(_: Any) -> tuple[Any, ...]:
    return ()


def _single(name: str) -> Callable[[Any], tuple[Any, ...]]:
    return lambda statement: (getattr(statement, name),)
