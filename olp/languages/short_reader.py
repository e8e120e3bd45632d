"""What the short readers share: one line at a time through a grammar, what it refuses kept, everything told."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from operator import is_not
from threading import Lock
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Protocol, TypeVar

from lark import Token, Tree

from olp.core.diagnostic import Severity, Span
from olp.core.result_cache import shelf
from olp.core.source import Source
from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir.program import LineKind, Opaque, Program, Statement
from olp.languages.findings import Findings
from olp.languages.lark_host import (
    MOST_BROKEN,
    BrokenLineError,
    Grammar,
    column_of,
    expected,
    give_up,
    placed,
)

if TYPE_CHECKING:
    from lark.exceptions import UnexpectedInput


# --- Alike lines ---
# Lines that differ in nothing but digits are parsed once: a program has thousands of rows and moves of a few shapes.
#
# The tokens of a line with other digits are put into the tree of the first one. That is right as long as a grammar
# takes one digit for another; where it does not, lines are parsed one by one (`_EXACT`).


Result = TypeVar("Result")

_DIGITS: Final = re.compile(r"[0-9]+")
# 0x1F is a number and 1x1F is none; C1MOVE and SET2HOME are words; grammars bound the digits of numbers and exponents.
_EXACT: Final = re.compile(r"[0-9](?:x|\.?e[-+]?[0-9]{3})|c[0-9]+move|set[0-9]+home|[0-9]{19}", re.IGNORECASE)
_MOST: Final = 2000  # shapes that are kept: about 10 MB


class _Slot(NamedTuple):
    """A token with digits in a tree: `children[at]`. `spelled`: its text, %s for each of the runs from first to end."""

    children: list[Any]
    at: int
    kind: str
    spelled: str
    first: int
    end: int


class _FilledToken(Token):
    """A token without a position in the text, which is made in a third of the time."""

    __slots__ = ()
    start_pos = line = column = end_line = end_column = end_pos = None

    def __new__(cls, type: str, value: str) -> _FilledToken:
        made = str.__new__(cls, value)
        made.type, made.value = type, value
        return made


class AlikeLines:
    """Parse trees of a grammar by the shape of the line, digits aside. May be shared between threads."""

    def __init__(self, grammar: Grammar) -> None:
        self.grammar = grammar
        self._known: dict[str, tuple[Tree[Token], list[_Slot]]] = {}
        self._lock = Lock()

    def read(self, text: str, use: Callable[[Tree[Token]], Result]) -> Result:
        """Return `use(tree)` for the line's tree. `use` must not keep the tree; its tokens have no positions.

        Raises lark's UnexpectedInput and what `use` raises.
        """
        if _EXACT.search(text):
            return use(self.grammar.parse(text))
        shape = _DIGITS.sub("0", text)
        with self._lock:
            found = self._known.get(shape)
            if found is None:
                tree = self.grammar.parse(text)
                slots = _slots(tree, text)
                if slots is not None:
                    if len(self._known) >= _MOST:
                        self._known.clear()
                    self._known[shape] = tree, slots
                return use(tree)
            tree, slots = found
            runs = _DIGITS.findall(text)
            for children, at, kind, spelled, first, end in slots:
                children[at] = _FilledToken(kind, spelled % tuple(runs[first:end]))
            return use(tree)


def _slots(tree: Tree[Token], text: str) -> list[_Slot] | None:
    """Return the tokens with digits in a tree; None where a token differs from the text it stands for."""
    found = []
    runs = _DIGITS.findall(text)
    for node in tree.iter_subtrees():
        for at, token in enumerate(node.children):
            if not isinstance(token, Token) or not (inside := _DIGITS.findall(token)):
                continue
            first = len(_DIGITS.findall(text, 0, token.start_pos or 0))
            end = first + len(inside)
            if runs[first:end] != inside:
                return None
            spelled = _DIGITS.sub("%s", token.replace("%", "%%"))
            found.append(_Slot(node.children, at, token.type, spelled, first, end))
    return found


# --- Reader ---


_MOST_CHARACTERS: Final = 4096
_MOST_OPERATORS: Final = 100  # of one line: what is nested deeper is no program
_OPERATORS: Final = re.compile(r"[-+*/(\[{:]|\.(?=[^\W\d])|\bB?NOT\b", re.IGNORECASE)
_LONG_NUMBER = re.compile(r"\d{19,}")
_WORD = re.compile(r"[^\s(,;:=]+")


class Codes(NamedTuple):
    """The codes of what a reader finds. `olp/core/codes.toml` lists those that there are, with their meanings."""

    broken: str  # a line of a known kind that cannot be understood
    opaque: str  # kept, not modelled
    long: str  # longer than any controller takes
    block: str  # blocks and labels that do not pair
    unreadable: str  # no text of this language
    move: str  # a move that is kept and not modelled


class NotModelledError(Exception):
    """Raised by a rule for a line that is understood and that no statement of the program can express: it becomes
    `Opaque`. `why`: a clause about the line's first word, as "it writes into a file".
    """

    def __init__(self, why: str) -> None:
        super().__init__(why)
        self.why = why


@lru_cache(maxsize=16)
def _lines(language: str) -> AlikeLines:
    """The language's parser, built once per process from grammars/<language>.lark."""
    return AlikeLines(Grammar(language))


class LoweringRules(Protocol):
    """The part of `ValueRules` (statement_rules.py) that `LineParser` uses."""

    settled_by: Hashable
    asked: list[tuple[str, str]] | None

    def spelled(self, name: str) -> str: ...

    def transform(self, tree: Tree[Token]) -> Any: ...


class LineParser:
    """Parses single lines of one program into statements.

    `known`: first words, in upper case, of the instructions that the grammar knows; a line that begins with one and
    does not parse is an error, any other is kept as `Opaque`. `moves`: first words of moves; a move that is kept as
    `Opaque` is reported as a warning.
    """

    def __init__(
        self,
        findings: Findings,
        language: str,
        rules: LoweringRules,
        codes: Codes,
        known: frozenset[str],
        moves: frozenset[str] = frozenset(),
    ) -> None:
        self.findings, self.codes, self.broken = findings, codes, 0
        self._language, self._rules, self._known, self._moves = language, rules, known, moves
        self._shelf = shelf(f"{language} lowered") if rules.settled_by is not None else None

    def parse(self, text: str, number: int) -> list[Any]:
        """Return the statements of the instruction in line `number` (from 1); an empty list where it has an error.
        Never raises.
        """
        from lark.exceptions import UnexpectedInput

        self.findings.kinds[number - 1] = LineKind.STATEMENT
        before = self._lowered_before(text) if self.broken < MOST_BROKEN else None
        if before is None and self._too_much(text, number):
            return []
        try:
            asked, found = self._lowered(text) if before is None else before
        except UnexpectedInput as refused:
            return self._refused(text, number, refused)
        except BrokenLineError as problem:
            self._tell(text, number, problem.message, 1, problem.wanted)
            return []
        except NotModelledError as unmodelled:
            return [self.opaque(text, number, unmodelled.why)]
        here = [placed(one, number) if hasattr(one, "line") else one for one in found]
        if self._shelf is not None and (before is None or any(map(is_not, here, found))):
            self._shelf.put((text, self._rules.settled_by), (asked, here))
        return here

    def _lowered(self, text: str) -> tuple[list[tuple[str, str]], list[Any]]:
        """Return the statements that the rules make of the text, and the names they asked for where results are
        kept.
        """
        rules = self._rules
        asked: list[tuple[str, str]] = []
        rules.asked = None if self._shelf is None else asked
        try:
            found = _lines(self._language).read(text, rules.transform)
        finally:
            rules.asked = None
        return asked, found if isinstance(found, list) else [found]

    def _lowered_before(self, text: str) -> tuple[list[tuple[str, str]], list[Any]] | None:
        """Return the earlier result for the same text, if the names in it are still spelled the same; None where
        there is none.
        """
        known = None if self._shelf is None else self._shelf.get((text, self._rules.settled_by))
        if known is None:
            return None
        spelled = self._rules.spelled
        for name, spelt in known[0]:
            if spelled(name) != spelt:
                return None
        return known  # type: ignore[no-any-return]

    def opaque(self, text: str, number: int, why: str = "") -> Opaque:
        """Return the line word for word as `Opaque`; each instruction word is reported once, for each reason `why`."""
        word = _first_word(text)
        self.findings.kinds[number - 1] = LineKind.OPAQUE
        span = self.findings.whole_line(number)
        because = f" because {why}" if why else ""
        if word in self._moves:
            message = f"the move {word} is kept but not modelled{because}: it is left out of the plan"
            help = "write it with a target, or add its time as a wait"
            self.findings.once(Severity.WARNING, self.codes.move, word + why, message, span, help)
        else:
            message, help = (
                f"{word[:40]} is kept but not modelled{because}",
                "its effect on the time is unknown",
            )
            self.findings.once(Severity.INFO, self.codes.opaque, word + why, message, span, help)
        return Opaque(number, text)

    def _refused(self, text: str, number: int, refused: UnexpectedInput) -> list[Any]:
        if _first_word(text) not in self._known:
            return [self.opaque(text, number)]
        column = column_of(refused, text)
        match = _WORD.match(text, column - 1)
        word = match[0] if match else text[column - 1 : column]
        said = f"'{word[:40]}' is not expected here" if word else "the line ends too early"
        self._tell(text, number, said, column, wanted_by(refused, _lines(self._language).grammar.written))
        return []

    def _too_much(self, text: str, number: int) -> bool:
        if self.broken >= MOST_BROKEN:
            give_up(self.findings, self.codes.long, self.findings.whole_line(number))
            return True
        operators = len(_OPERATORS.findall(text)) if len(text) > _MOST_OPERATORS else 0
        if len(text) <= _MOST_CHARACTERS and operators <= _MOST_OPERATORS and not _LONG_NUMBER.search(text):
            return False
        self.broken += 1
        help = f"at most {_MOST_CHARACTERS} characters, {_MOST_OPERATORS} operators and 18 digits are read"
        span = self.findings.whole_line(number)
        self.findings.error(self.codes.long, "this is longer than any controller takes", span, help)
        return True

    def _tell(self, text: str, number: int, message: str, column: int, wanted: str) -> None:
        self.broken += 1
        start = self.findings.source.line(number).find(text)
        match = _WORD.match(text, column - 1)
        end = start + column + (len(match[0]) if match else 1)
        # A statement of several lines is joined: only its first line can be shown.
        span = Span(number, start + column, end) if start >= 0 else self.findings.whole_line(number)
        help = f"expected {wanted}" if wanted else ""
        self.findings.error(self.codes.broken, message, span, help)


def words(text: str) -> frozenset[str]:
    return frozenset(text.split())


def with_comment(statement: Any, comment: str) -> Any:
    """Return the statement with its trailing comment; a statement without such a field, which keeps its whole text,
    as it is.
    """
    return replace(statement, comment=comment) if hasattr(statement, "comment") else statement


def wanted_by(refused: UnexpectedInput, written: Mapping[str, str]) -> str:
    """Return a list of at most six tokens that the grammar expected at the error.

    `written`: the text of terminals that have one spelling; others are called by their names.
    """
    words = (_in_words(name, written.get(name)) for name in expected(refused))
    names = sorted(words, key=lambda word: (word.startswith("'"), word.isupper(), word))  # signs last
    return ", ".join(names[:6]) + (" …" if len(names) > 6 else "")


def _in_words(name: str, text: str | None) -> str:
    if name == "$END":
        return "the end of the line"
    if text is None:
        return name.lower().replace("_", " ").strip()
    return text.upper() if text.isidentifier() else f"'{text}'"


def _first_word(text: str) -> str:
    match = _WORD.match(text)
    return match[0].upper() if match else text[:1]


def is_readable(findings: Findings, codes: Codes, mark: re.Pattern[str], what: str) -> bool:
    """Return whether the file is text of this language; if not, add one error and mark every line."""
    source = findings.source
    if source.encoding.startswith("utf-16") or b"\0" in source.raw:
        message = "this is binary or UTF-16, not program text"
    elif not source.raw.strip():
        message = "the file is empty"
    elif not any(mark.search(line) for line in source.lines):
        message = f"this is no {what} program"
    else:
        return True
    findings.error(
        codes.unreadable, message, Span(0), "save the program as plain text: Notepad calls it ANSI or UTF-8"
    )
    for number, line in enumerate(source.lines):
        findings.kinds[number] = LineKind.ERROR if line.strip() else LineKind.BLANK
    return False


def unreadable(vendor: str, source: Source, findings: Findings) -> Program:
    return Program(vendor, source, (), findings.result(), bytes(findings.kinds))


def check_blocks(findings: Findings, body: Sequence[Statement], code: str) -> None:
    """Reports each block that is not closed or not opened, and each label that is missing or repeated, as `code`.

    `body`: the statements of one routine.
    """
    from olp.ir.block_structure import UNPAIRED, pair

    for problem in pair(body).problems:
        span = findings.whole_line(problem.line) if problem.line else Span(0)
        tell = findings.error if problem.is_error else findings.warning
        message, help = UNPAIRED.get(problem.code, (problem.message, problem.help))
        tell(code, message.replace("*", ""), span, help.replace("*", ""))


def zyz_pose(values: Sequence[float], native: tuple[tuple[str, str], ...] = ()) -> ex.PositionLiteral:
    """A pose from x y z [mm] and R = Rz(a) Ry(e) Rz(r) [deg]."""
    a, e, r = (v * deg for v in values[3:6])
    ca, sa, ce, se, cr, sr = math.cos(a), math.sin(a), math.cos(e), math.sin(e), math.cos(r), math.sin(r)
    matrix = (
        (ca * ce * cr - sa * sr, -ca * ce * sr - sa * cr, ca * se),
        (sa * ce * cr + ca * sr, -sa * ce * sr + ca * cr, sa * se),
        (-se * cr, se * sr, ce),
    )
    return _pose(values, matrix, native)


def xyz_pose(values: Sequence[float], native: tuple[tuple[str, str], ...] = ()) -> ex.PositionLiteral:
    """A pose from x y z [mm] and R = Rx(rx) Ry(ry) Rz(rz) [deg]."""
    a, b, c = (v * deg for v in values[3:6])
    ca, sa, cb, sb, cc, sc = math.cos(a), math.sin(a), math.cos(b), math.sin(b), math.cos(c), math.sin(c)
    matrix = (
        (cb * cc, -cb * sc, sb),
        (sa * sb * cc + ca * sc, -sa * sb * sc + ca * cc, -sa * cb),
        (-ca * sb * cc + sa * sc, ca * sb * sc + sa * cc, ca * cb),
    )
    return _pose(values, matrix, native)


def _pose(
    values: Sequence[float], r: tuple[tuple[float, ...], ...], native: tuple[tuple[str, str], ...]
) -> ex.PositionLiteral:
    """Rx, Ry, Rz as `olp.robots.geometry.angles_from_rotation`, one pose at a time."""
    cosine = math.hypot(r[0][0], r[1][0])
    locked = cosine < 1e-12
    rx = math.atan2(-r[1][2], r[1][1]) if locked else math.atan2(r[2][1], r[2][2])
    rz = 0.0 if locked else math.atan2(r[1][0], r[0][0])
    place = tuple(v * mm for v in values[:3])
    return ex.PositionLiteral("pose", (*place, rx, math.atan2(-r[2][0], cosine), rz), native=native)


def joints(values: Iterable[float]) -> ex.PositionLiteral:
    """Return a joint position from axis values [deg]."""
    return ex.PositionLiteral("joint", tuple(v * deg for v in values))


def constants(values: Iterable[ex.Expression]) -> list[float] | None:
    """Return the values of literal numbers; None where one of them is computed."""
    found = [one.value for one in values if isinstance(one, ex.Number)]
    return [float(v) for v in found] if len(found) == len(list(values)) else None


def from_zero(index: ex.Expression) -> ex.Expression:
    """Return the index that counts from 1 for one that counts from 0."""
    return ex.Number(index.value + 1) if isinstance(index, ex.Number) else ex.Binary("+", index, ex.Number(1))


def array(
    type_: str, elements: Mapping[tuple[int, ...], ex.Expression], missing: ex.Expression
) -> ex.Expression:
    """Return the literal of an array from its elements by their indices, which count from 0, with `missing` in the
    gaps: every row is as long as the longest.
    """
    sizes = tuple(max(places) + 1 for places in zip(*elements, strict=True))

    def row(above: tuple[int, ...]) -> ex.Expression:
        if len(above) == len(sizes):
            return elements.get(above, missing)
        return ex.RecordLiteral(type_, tuple(("", row((*above, at))) for at in range(sizes[len(above)])))

    return row(())
