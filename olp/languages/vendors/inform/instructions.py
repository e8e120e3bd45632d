"""The lines between //INST and END: the fast path first, then lines seen before, then the grammar."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from olp.core.diagnostic import Severity, Span
from olp.ir.expressions import Number, Store, Unknown, Variable
from olp.ir.program import (
    Begin,
    Case,
    Comment,
    Default,
    Else,
    ElseIf,
    End,
    EndIf,
    EndSwitch,
    EndWhile,
    For,
    If,
    LineKind,
    Next,
    Opaque,
    Statement,
    Switch,
    While,
)
from olp.languages.findings import Findings
from olp.languages.lark_host import MOST_BROKEN, BrokenLineError, give_up, values_of
from olp.languages.vendors.inform.fast import InformMoveLines
from olp.languages.vendors.inform.positions import ROW

if TYPE_CHECKING:
    from olp.languages.vendors.inform.grammar import InformLine
    from olp.languages.vendors.inform.problems import InformProblem


_FIRST_WORD = re.compile(r"\s*([^\s*(=#\"']*)")
_RECORD = re.compile(r"///|//(?:NAME|POS|INST|ALIAS|ARGINFO)(?![A-Za-z])")
_OPERATORS = "+-*/("
_MOST_OPERATORS = (
    200  # a nesting that no controller takes, and that would exhaust the stack of an interpreter
)
_MOST_CHARACTERS = 4096
_LONG_NUMBER = re.compile(r"\d{19,}")
_STRING = re.compile(r'"[^"]*"')
# Legal forms of known words: jobs and labels by a number, speeds of external axes, single elements of a position.
_UNMODELLED: Final = re.compile(
    r"\s*(?:(?:CALL|JUMP)\s+(?:IGH?#|L?[BID]\d)|SPEED\s[^'/]*\bVE=|(?:ADD|SUB|MUL|DIV)\s+L?(?:P|BP|EX)\d+\s*\()"
)
_MOST_SUGGESTED = 50  # unknown words that are compared with all known ones
_MOST_CACHED = 50_000

# A statement's class and all its values but the line.
_Template = tuple[Callable[..., Statement], tuple[Any, ...]]
# NOP and END stand in every job: a job of plain moves needs no grammar at all.
_PRESET: Final[dict[str, _Template]] = {"NOP": (Begin, ("",)), "END": (End, ("",))}
_seen = dict(_PRESET)


class InformInstructionReader:
    """Reads the instruction lines of one job."""

    def __init__(self, findings: Findings, moves: InformMoveLines, aliases: Mapping[str, Variable]) -> None:
        self._findings = findings
        self._kinds = findings.kinds
        self._moves = moves
        self._aliases = aliases
        self._own: dict[str, _Template] = {}
        self._manglers: dict[bool, Callable[[str], str]] = {}
        self._unknown: set[str] = set()
        self._broken = 0
        self.markers: list[Statement] = []  # stand for broken lines that open or continue a block

    def read(self, lines: Sequence[str], first: int) -> list[Statement]:
        """The statements in `lines`, the first of which is line `first` of the file."""
        body: list[Statement] = []
        move, seen, own, kinds = self._moves.read, _seen, self._own, self._kinds
        for number, line in enumerate(lines, first):
            statement: Statement | None = move(line, number)
            if statement is None:
                template = own.get(line) or seen.get(line)
                if template is None:
                    body.extend(self._read(line, number))
                    continue
                statement = template[0](number, *template[1])
            kinds[number - 1] = LineKind.STATEMENT
            body.append(statement)
        return body

    def _read(self, line: str, number: int) -> tuple[Statement, ...]:
        text = line.rstrip("\x1a \t")
        if not text.strip():
            return ()
        if text.lstrip(" \t").startswith(("'", "//")):
            return self._comment(text, number)
        if ROW.match(text):
            self._misplaced("P014", "a position row among the instructions", number)
            return ()
        if self._too_much(text, number):
            return ()
        word = _first_word(text)
        if word and word[0].isalpha() and (word not in self._words() or _UNMODELLED.match(text)):
            return (self._opaque(text, word, number),)
        return self._parse(text, line, number)

    def _too_much(self, text: str, number: int) -> bool:
        """Whether a line is beyond what any controller takes, which is told: it could only exhaust olp."""
        digits = _LONG_NUMBER.search(_STRING.sub("", text))
        if digits is not None:
            self._findings.error(
                "P023",
                f"a number of {len(digits[0])} digits",
                self._findings.whole_line(number),
                "at most 18",
            )
            return True
        operators = sum(map(text.count, _OPERATORS)) if len(text) > _MOST_OPERATORS else 0
        if len(text) <= _MOST_CHARACTERS and operators <= _MOST_OPERATORS:
            return False
        message = f"an instruction of {len(text)} characters is longer than any controller takes"
        help = f"at most {_MOST_CHARACTERS} characters and {_MOST_OPERATORS} operators are read"
        self._findings.error("P023", message, self._findings.whole_line(number), help)
        return True

    def _words(self) -> frozenset[str]:
        from olp.languages.vendors.inform.grammar import instruction_parser

        return instruction_parser().words

    def _comment(self, text: str, number: int) -> tuple[Statement, ...]:
        text = text.lstrip(" \t")
        if _RECORD.match(text):
            self._misplaced("P015", "a header record among the instructions", number)
            return ()
        self._kinds[number - 1] = LineKind.COMMENT
        return (Comment(number, text[1 if text[0] == "'" else 2 :]),)

    def _misplaced(self, code: str, message: str, number: int) -> None:
        help = "move it above NOP; is the line /JOB of another job missing?"
        self._findings.error(code, message, self._findings.whole_line(number), help)

    def _opaque(self, text: str, word: str, number: int) -> Opaque:
        from difflib import get_close_matches

        self._kinds[number - 1] = LineKind.OPAQUE
        start = len(text) - len(text.lstrip()) + 1
        near: list[str] = []
        known = word in self._words()
        if not known and len(self._unknown) < _MOST_SUGGESTED and word not in self._unknown:
            near = get_close_matches(word[:20].upper(), self._words(), 1, 0.75)
        self._unknown.add(word)
        help = f"did you mean {near[0]}?" if near else "its effect on the time is unknown"
        message = f"{'this form of ' if known else ''}{word[:40]} is kept but not modelled"
        span = Span(number, start, start + len(word))
        # A word that looks like a misspelt instruction may well be a move.
        severity = Severity.WARNING if near or known else Severity.INFO
        self._findings.once(severity, "P021", word, message, span, help)
        return Opaque(number, text.strip())

    def _parse(self, text: str, line: str, number: int) -> tuple[Statement, ...]:
        from lark.exceptions import UnexpectedInput

        from olp.languages.vendors.inform.problems import InformProblem, explain

        if self._broken >= MOST_BROKEN:
            self._kinds[number - 1] = LineKind.ERROR
            give_up(self._findings, "P024", Span(number, 1, 2), "lines new to olp")
            return ()
        try:
            parsed = self._parsed(text)
        except UnexpectedInput as refused:
            self._report(explain(refused, text), text, number)
            return ()
        except BrokenLineError as broken:
            column = max(text.rfind(broken.word), 0) + 1
            problem = InformProblem(broken.message, column, column + len(broken.word), broken.wanted)
            self._report(problem, text, number)
            return ()
        self._kinds[number - 1] = LineKind.STATEMENT
        templates = [(type(one), values_of(one)) for one in parsed.statements]
        if not parsed.remarks and len(templates) == 1:
            _remember(self._own if parsed.named else _seen, line, templates[0])
        for remark in parsed.remarks:
            self._remark(
                remark.code, remark.text, Span(number, remark.column, remark.column + len(remark.text))
            )
        return tuple(kind(number, *values) for kind, values in templates)

    def _parsed(self, text: str) -> InformLine:
        """Once with odd names of //ALIAS guarded; if the grammar refuses that, with all of them."""
        from lark.exceptions import UnexpectedInput

        from olp.languages.vendors.inform.grammar import instruction_parser

        once = self._mangled(text, every=False)
        try:
            return instruction_parser().instruction(once, self._aliases)
        except UnexpectedInput:
            again = self._mangled(text, every=True)
            if again == once:
                raise
        return instruction_parser().instruction(again, self._aliases)

    def _mangled(self, text: str, every: bool) -> str:
        from olp.languages.vendors.inform.expressions import Mangler, is_plain

        if not self._aliases:
            return text
        if every not in self._manglers:
            self._manglers[every] = Mangler(name for name in self._aliases if every or not is_plain(name))
        return self._manglers[every](text)

    def _report(self, problem: InformProblem, text: str, number: int) -> None:
        self._broken += 1
        word = _first_word(text)
        if word in MARKERS:
            self.markers.append(MARKERS[word](number))
        help = f"expected {problem.wanted}" if problem.wanted else ""
        span = Span(number, problem.column, problem.end_column)
        self._findings.error("P020", problem.message, span, help=help)

    def _remark(self, code: str, text: str, span: Span) -> None:
        severity, key, message, help = _REMARKS[code]
        self._findings.once(
            severity, code, text if key else code, message.format(text), span, help.format(text)
        )


# code: severity, whether each text is told on its own, message, help
_REMARKS: Final = {
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


# --- Markers ---
# Stand-ins for broken lines that open, continue or close a block.
#
# They pair with the rest of the job's blocks, so that one broken IFTHEN is not told again as an ENDIF without IFTHEN.

_UNKNOWN = Unknown("")
MARKERS: Final[dict[str, Callable[[int], Statement]]] = {
    "IFTHEN": lambda line: If(line, _UNKNOWN),
    "IFTHENEXP": lambda line: If(line, _UNKNOWN),
    "ELSEIF": lambda line: ElseIf(line, _UNKNOWN),
    "ELSEIFEXP": lambda line: ElseIf(line, _UNKNOWN),
    "ELSE": lambda line: Else(line),
    "ENDIF": lambda line: EndIf(line),
    "WHILE": lambda line: While(line, _UNKNOWN),
    "WHILEEXP": lambda line: While(line, _UNKNOWN),
    "ENDWHILE": lambda line: EndWhile(line),
    "FOR": lambda line: For(line, Variable(Store.BYTE, Number(0)), _UNKNOWN, _UNKNOWN),
    "NEXT": lambda line: Next(line, None),
    "SWITCH": lambda line: Switch(line, _UNKNOWN),
    "CASE": lambda line: Case(line, ()),
    "DEFAULT": lambda line: Default(line),
    "ENDSWITCH": lambda line: EndSwitch(line),
}
