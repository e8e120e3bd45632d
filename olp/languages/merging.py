"""A program's text in the pieces that two people change independently: statements, positions, records of the header.

What a language has to say about itself stands in `merging.py` of the vendor's folder, as `MERGING`. Bytes are kept:
texts are read as Latin-1, in which every byte is one character.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import ClassVar, NamedTuple

NUMBER = "\0"  # in a piece's lines: where the number of a position stands
COUNTER = "\1"  # as often as the number of the line has columns
_LINE = re.compile(r"([^\r\n]*)(\r\n|\n|\r|\Z)")
_BLANKS = re.compile(r"\s{2,}|[^\S ]")
_BESIDE_SIGNS = re.compile(r" (?:(?=[=,(){}\[\]:;<>])|(?<=[=,(){}\[\]:;<>] ))")
_NEVER = re.compile(r"(?!)")
_DECIMAL = re.compile(r"(?<![\w.])\d++\.\d++(?![\w.])")
_ENDS_IN_ZERO = re.compile(r"0(?![\w.])")
_NO_SIGN = re.compile(r"-(?<=[\s,:=({\[]-)(?=0\.?(?![\w.]))")
_DIGITS = re.compile(r"\d+")
_EXPONENT = re.compile(r"(?<![\w.])(\d+\.?\d*)e([-+]?\d+)(?![\w.])", re.IGNORECASE)
_UNEVEN = re.compile(r"[\d.][eE][-+0]|[0.][eE]\d")  # an exponent that may be written in another way
_CONSTANT = re.compile(r"-?\d+|#\w+|\"[^\"]*\"")


class RecordRule(Enum):
    """Which of two texts of one record holds when both sides have changed it."""

    ASK = "a person decides"
    COUNTED = "how many there are now"
    NEWEST = "the later date"
    GREATEST = "the greater number"
    SAVED_LAST = "that of the side with the later date or greater number"


class NumberedUse(NamedTuple):
    """A numbered position, of one routine. `width`: digits as written."""

    family: str
    number: int
    width: int


@dataclass(frozen=True, slots=True)
class Piece:
    """One thing that stands in a text. `lines` without their `ends`.

    `name`: what it is known by wherever it stands, "" for what is known by its place and words. `loose`: its place
    among others says nothing. `uses`: the positions whose numbers stand at `NUMBER`. `says`: its words, or what makes
    them of a line: they are rarely asked for where a name says which piece it is.
    """

    lines: tuple[str, ...]
    ends: tuple[str, ...]
    says: str | Callable[[str], str]
    name: str = ""
    loose: bool = False
    rule: RecordRule = RecordRule.ASK
    uses: tuple[NumberedUse, ...] = ()

    @property
    def code(self) -> str:
        """Its words without comment and surplus blanks, by which it is found again."""
        says = self.says
        if isinstance(says, str):
            return says
        words = " ".join(map(says, self.lines))
        object.__setattr__(self, "says", words)  # the same, worked out once
        return words

    @property
    def says_nothing(self) -> bool:
        """A blank line or a comment: nothing runs otherwise because of it."""
        code = self.code
        return not code or code[0] == _SILENT


_SILENT = "\2"  # begins the code of a comment on a line of its own


@dataclass(frozen=True, slots=True)
class Row:
    """A numbered position as a table holds it. `state`: what the records before it say; `lead`: those right before it.

    `before`: what held in front of `lead`.
    """

    use: NumberedUse
    lines: tuple[str, ...]
    ends: tuple[str, ...]
    state: tuple[str, ...] = ()
    lead: tuple[tuple[str, str], ...] = ()
    before: tuple[str, ...] = ()
    means: tuple[str, ...] = ()  # of the state, what says where the position is


class MoveArgument(NamedTuple):
    """A part of a move. `name`: place (target, tool and frame), speed, zone, acceleration …; of what: motion."""

    name: str
    text: str


class Side(Enum):
    """One of the two texts that are merged."""

    OURS = 0
    THEIRS = 1


@dataclass(frozen=True, slots=True)
class Cut:
    """A whole text. `rows`: its numbered positions in order, by the table that they stand in; in `pieces` a table is
    one without lines that has its name. `tails`: what stands behind the last row. `fixed`: families whose numbers stay.
    """

    pieces: list[Piece]
    rows: Mapping[str, list[Row]] = field(default_factory=dict)
    tails: Mapping[str, tuple[tuple[str, str], ...]] = field(default_factory=dict)
    fixed: frozenset[str] = frozenset()


# Pieces by line, its end and the routine or job that it stands in: versions of one program have most in common.
Known = dict[tuple[str, str, str], Piece]

# A row to write, or the two between which somebody has to choose.
Choice = Row | tuple[Row | None, Row | None]


class MergeRules:
    """One language. Patterns match at the beginning of a line.

    `comments`: marks behind which a comment stands, outside of quotes; `whole_comments`: those that count only where a
    line begins; `structure`: lines of those that something is built of.
    `data`: a line that defines the thing that its group 1 names, wherever it stands; `loose_data` whether
    its place says nothing. `data_ends`: what ends such a definition where it is longer than a line. `scope`: a line
    that opens a routine, its name the group 1, or ends one, without a name. `heads`: records with what decides between
    two. `has_variables`: statements say names that a person chose, `ignores_case`: in any letters. `reals`: a whole
    number that ends there means the same with a decimal point. `saved_suffixes`: of the files that `of_saved` is about.
    """

    comments: ClassVar[tuple[str, ...]] = ()
    whole_comments: ClassVar[tuple[str, ...]] = ()
    structure: ClassVar[re.Pattern[str]] = _NEVER
    data: ClassVar[re.Pattern[str]] = _NEVER
    loose_data: ClassVar[bool] = True
    data_ends: ClassVar[str] = ""
    scope: ClassVar[re.Pattern[str]] = _NEVER
    branch: ClassVar[re.Pattern[str]] = _NEVER
    branched: ClassVar[re.Pattern[str]] = _NEVER
    declares: ClassVar[re.Pattern[str]] = _NEVER
    heads: ClassVar[tuple[tuple[re.Pattern[str], RecordRule], ...]] = ()
    has_variables: ClassVar[bool] = False
    ignores_case: ClassVar[bool] = False
    reals: ClassVar[re.Pattern[str]] = _NEVER
    saved_suffixes: ClassVar[tuple[str, ...]] = ()

    def renamed(self, base: str, ours: str, theirs: str) -> tuple[str, str, str]:
        """The three texts, with one name for what a tool names anew whenever it writes a program."""
        return base, ours, theirs

    def of_saved(self, text: str) -> MergeRules | None:
        """The rules of what a controller saves beside its programs; None: it is none of these."""
        return None

    def packing(self, data: bytes) -> PackedRules | None:
        """The rules of a file that holds its text packed; None: it is that text."""
        return None

    def cut(self, text: str, known: Known) -> Cut:
        """The pieces of a text, in order. `known`: those of other versions, to which its own are added."""
        return Cut(list(self._pieces(lines_of(text), known)))

    def rows(self, rows: Sequence[Choice]) -> Iterator[TableText]:
        """The lines of a table of positions."""
        return iter(())

    def joined_row(self, base: Row, ours: Row, theirs: Row) -> Row | None:
        """A position of which the two sides changed different things; None: together these say one place."""
        return None

    def counted(self, piece: Piece, totals: Mapping[str, int], lines: int) -> str:
        """A record that tells how many positions of a family or numbered lines there are, told anew."""
        return piece.lines[0]

    def arguments(self, code: str) -> list[MoveArgument]:
        """A move's parts that two people change independently, in order: together its words. Empty: it is no move."""
        return []

    def spelled(self, use: NumberedUse, number: int) -> str:
        """The number of a position."""
        return str(number)

    def code(self, line: str) -> str:
        """The words of a line, without comment and surplus blanks; one text for numbers that are the same."""
        text = self.split(line)[1]
        words = text if '"' in text else self._plain(_BESIDE_SIGNS.sub("", _BLANKS.sub(" ", text)))
        return words if words or not line.strip() else self.silent(line.strip())

    def _plain(self, words: str) -> str:
        if self.ignores_case:
            words = words.casefold()
        if _UNEVEN.search(words):
            words = _EXPONENT.sub(_exponent, words)
        if self.reals is not _NEVER:
            words = self.reals.sub(r"\g<0>.", words)
        if "." in words and _ENDS_IN_ZERO.search(words):
            words = _DECIMAL.sub(lambda match: match[0].rstrip("0"), words)
        return _NO_SIGN.sub("", words) if "-0" in words else words

    @staticmethod
    def silent(text: str) -> str:
        """The code of a line that nothing runs otherwise for."""
        return _SILENT + text

    def split(self, line: str) -> tuple[str, str, str]:
        """Indentation, code, and the comment with the blanks before it."""
        start = len(line) - len(line.lstrip(" \t"))
        stop = self._comment(line)
        code = line[start : max(start, stop)]
        kept = code.rstrip(" \t")
        return line[:start], kept, line[start + len(kept) :]

    def _comment(self, line: str) -> int:
        if self.whole_comments and line.lstrip(" \t").startswith(self.whole_comments):
            return 0
        found = [at for mark in self.comments if (at := line.find(mark)) >= 0]
        if not found:
            return len(line)
        first = min(found)
        if '"' not in line[:first]:
            return first
        return _outside_quotes(line, self.comments)

    def _pieces(self, lines: Sequence[tuple[str, str]], known: Known) -> Iterator[Piece]:
        scope, at = "", 0
        while at < len(lines):
            key = (*lines[at], scope)
            piece = known.get(key)
            if piece is None:
                opened = self.scope.match(key[0])
                if opened is not None:
                    scope = (opened[1] or "").casefold()
                piece, at = self._piece(lines, at, scope)
                if len(piece.lines) == 1 and opened is None:
                    known[key] = piece
            yield piece
            at += 1

    def _piece(self, lines: Sequence[tuple[str, str]], at: int, scope: str) -> tuple[Piece, int]:
        """The piece that begins with line `at`, and its last line."""
        text, end = lines[at]
        for pattern, rule in self.heads:
            head = pattern.match(text)
            if head is not None:
                return Piece((text,), (end,), self.code(text), f"head {head[0].strip()}", False, rule), at
        name = self.data_name(text)
        if not name:
            return Piece((text,), (end,), self.code), at
        stop = at
        while self.data_ends and stop < len(lines) - 1 and stop - at < 1000:
            if self.split(lines[stop][0])[1].endswith(self.data_ends):
                break
            stop += 1
        texts, ends = zip(*lines[at : stop + 1], strict=True)
        return Piece(texts, ends, self.code, f"{scope}/{name}", self.loose_data), stop

    def routines(self, lines: Sequence[str]) -> list[str]:
        """The names of the routines that these lines are: whole ones, and remarks. Empty: they are something else."""
        found, inside = [], False
        for line in lines:
            edge = self.scope.match(line)
            if edge is not None:
                if bool(edge[1]) is inside:
                    return []
                inside = not inside
                found += [edge[1].casefold()] if inside else []
            elif not inside and not self.is_silent(line):
                return []
        return [] if inside else found

    def routine_names(self, text: str) -> list[str]:
        """The names of the routines of a text in order: quick."""
        if self.scope is _NEVER:
            return []
        opened = re.compile(f"^(?:{self.scope.pattern})", self.scope.flags | re.MULTILINE)
        return [match[1] for match in opened.finditer(text) if match[1]]

    def by_routines(self, text: str) -> list[tuple[str, str]]:
        """The text in routines by their names, each with the remarks above it, between what is in front and behind.

        Empty: there is none, something else stands between two of them, or a line end is missing.
        """
        found: list[tuple[str, str]] = []
        name, held = "", [""]
        for line, end in lines_of(text):
            edge = self.scope.match(line)
            if edge is not None and edge[1] and not name:
                name = edge[1].casefold()
                remarks = len(held)
                while remarks > 1 and self.is_silent(held[remarks - 1].rstrip("\r\n")):
                    remarks -= 1
                if not found:
                    found, held = [("", "".join(held[:remarks]))], ["", *held[remarks:]]
                elif remarks > 1:
                    return []
            held.append(line + end)
            if edge is not None and not edge[1] and name:
                found.append((name, "".join(held)))
                name, held = "", [""]
        whole = found and not name and all(one.endswith(("\n", "\r")) for _, one in found[1:])
        return [*found, ("", "".join(held))] if whole else []

    def branches(self, lines: Sequence[str], behind: str) -> list[str]:
        """The constants whose branches these lines are in front of `behind`; empty: they are something else."""
        said = [line for line in lines if not self.is_silent(line)]
        if not said or not self.branch.match(said[0]) or any(map(self.branched.match, said)):
            return []
        if not self.branch.match(behind) and not self.branched.match(behind):
            return []
        opened = (match[1] for match in map(self.branch.match, said) if match is not None)
        found = [" ".join(one.split()) for labels in opened for one in labels.split(",")]
        return found if all(map(_CONSTANT.fullmatch, found)) else []

    def declared(self, code: str) -> tuple[str, dict[str, str], str]:
        """What stands before the names of a declaration, each by its key, and behind them; no names: it is none."""
        match = self.declares.fullmatch(code)
        if match is None:
            return "", {}, ""
        names = _separated(match[2])
        return match[1], {self.code(one).partition("[")[0].strip(): one for one in names}, match[3]

    def is_silent(self, line: str) -> bool:
        """Whether it is a blank line or a comment."""
        code = self.code(line)
        return not code or code[0] == _SILENT

    def data_name(self, line: str) -> str:
        """What a line defines, "" where it defines nothing."""
        match = self.data.match(line)
        return next(filter(None, match.groups()), "").casefold() if match is not None else ""


def split_arguments(code: str, names: Sequence[str], words: Mapping[str, str]) -> list[MoveArgument]:
    """The arguments of `WORD(a, b)` or `WORD a, b;` with the names of their places; empty: there are more.

    `words`: names of arguments that are written `word=value`.
    """
    spans = _top_level(code)
    if len(spans) > len(names) + 1:
        return []
    found = [MoveArgument("motion", code[: spans[0][0]])]
    for name, (start, stop) in zip((*names, ""), spans, strict=False):
        word, sign, _ = code[start:stop].strip(" ,").partition("=")
        name = words.get(word.strip(), "") if sign and words else name
        if not name:
            return []
        found.append(MoveArgument(name, code[start:stop]))
    return [*found, MoveArgument("motion", code[spans[-1][1] :])]


_OPENS = re.compile(r"\w+ *\(|\w+ ")


def _top_level(code: str) -> list[tuple[int, int]]:
    """Where the arguments of a statement stand, each with the comma before it."""
    head = _OPENS.match(code)
    at = start = 0 if head is None else head.end()
    found, depth, quoted = [], 0, False
    while at < len(code):
        sign = code[at]
        quoted ^= sign == '"'
        if not quoted and (sign == ";" or (sign == ")" and not depth)):
            break
        depth += (sign in "([{") - (sign in ")]}") if not quoted else 0
        if sign == "," and not depth and not quoted:
            found.append((start, at))
            start = at
        at += 1
    return [*found, (start, at)]


class PackedRules(MergeRules, ABC):
    """Of files that are no text, but hold one."""

    @abstractmethod
    def unpack(self, data: bytes) -> bytes:
        """The text. Raises ValueError where it holds none."""

    @abstractmethod
    def pack(self, text: bytes) -> bytes:
        """The file that holds this text. Raises ValueError where it is none that such a file can hold."""


class TableText(NamedTuple):
    """One line of a table. `side`: it is that side's alone. `row`: whose number stands at `NUMBER`."""

    text: str
    end: str
    side: Side | None = None
    row: Row | None = None


def lines_of(text: str) -> list[tuple[str, str]]:
    """The lines of a text, each with its end."""
    found = _LINE.findall(text)
    if found and not found[-1][0] and not found[-1][1]:
        found.pop()
    return found


def _separated(names: str) -> list[str]:
    """Names between commas, with their indices."""
    return [one.strip() for one in re.split(r",(?![^[]*\])", names)]


def _exponent(match: re.Match[str]) -> str:
    """One text for 9E9, 9.0E+09 and 9e+009."""
    digits = match[1].rstrip("0").removesuffix(".") if "." in match[1] else match[1]
    return f"{digits}e{int(match[2])}"


def holds(base: object, ours: object, theirs: object) -> Side | None:
    """Which side says what a thing became; None: both changed it, and differently."""
    if ours == theirs or theirs == base:
        return Side.OURS
    return Side.THEIRS if ours == base else None


def later(ours: str, theirs: str) -> str:
    """Of two records the one with the later date or greater number."""
    return max(ours, theirs, key=lambda text: (_moment(text), text))


def _moment(text: str) -> tuple[int, ...]:
    numbers = [int(one) for one in _DIGITS.findall(text)]
    if len(numbers) > 2 and numbers[0] < 100:  # a year of two digits
        numbers[0] += 1900 if numbers[0] >= 80 else 2000
    return tuple(numbers)


def _outside_quotes(line: str, marks: tuple[str, ...]) -> int:
    inside = False
    for at, sign in enumerate(line):
        if sign == '"':
            inside = not inside
        elif not inside and line.startswith(marks, at):
            return at
    return len(line)
