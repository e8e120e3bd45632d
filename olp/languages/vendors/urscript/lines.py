"""From physical lines to instructions: comments taken off, brackets closed over several lines, marks of PolyScope.

Plain moves and points are read without the grammar: a path of a CAM system has 100,000 of them. `quick` gives exactly
the instruction that the grammar gives (a test compares the two); whatever else a line holds, it declines, and the
grammar reads it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol, TypeVar, cast

from olp.core import result_cache
from olp.core.diagnostic import Severity, Span
from olp.ir.program import LineKind
from olp.languages.findings import Findings
from olp.languages.lark_host import MOST_BROKEN, expected, give_up
from olp.languages.vendors.urscript.syntax import (
    POSE_NUMBERS,
    Assignment,
    Evaluation,
    Instruction,
    Invocation,
    ListOf,
    Literal,
    Node,
    PlainPose,
    UrscriptArgument,
    UrscriptName,
    UrscriptPair,
    pose_of,
)

if TYPE_CHECKING:
    from lark.exceptions import UnexpectedInput

N = TypeVar("N")


_NUMBER: Final = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE](?:-\d{1,3}|\+?\d{1,2})(?!\d))?"
_NAME: Final = r"[A-Za-z_][A-Za-z0-9_]*+"
_SOME: Final = r"[-+0-9.eE, ]++"
_PLACE: Final = rf"(?:p?\[{_SOME}\]|{_NAME})"
# What stands behind the target is examined once for each of its texts.
_MOVE: Final = re.compile(
    rf"(move[jlp]) ?\( ?(?:pose_trans\(({_PLACE}), ?({_PLACE})\)"
    rf"|get_inverse_kin\(({_PLACE}), qnear=({_PLACE})\)|({_PLACE}))( ?,[^()\[\]\"]*+)? ?\)",
    re.ASCII,
)
_POINT: Final = re.compile(rf"(?:(global|local) )?({_NAME}) ?= ?(p?\[{_SOME}\])", re.ASCII)
_ARGUMENT: Final = re.compile(
    rf"(?:({_NAME}) ?= ?)?(?:({_NUMBER})|({_NAME})(?: ?\* ?(\d+(?:\.\d*)?))?)", re.ASCII
)
_WORDS: Final = frozenset((
    "and", "or", "xor", "not", "if", "elif", "else", "while", "end", "def", "thread", "sec", "return",
    "break", "continue", "global", "local", "join", "kill", "run", "True", "False", "true", "false",
))  # fmt: skip
_HUGE = 1e100  # numbers from here on are refused by the grammar
_LONGEST = 26  # characters of a number; longer ones are examined by the reader of lines


class _New(Protocol):
    def __call__(self, kind: type[N], values: tuple[object, ...]) -> N: ...


_new: Final = cast(_New, tuple.__new__)  # the nodes as their constructors make them, in half the time
_TRANS: Final = UrscriptName("pose_trans")
_KIN: Final = UrscriptName("get_inverse_kin")
_MOVES: Final = {word: UrscriptName(word) for word in ("movej", "movel", "movep")}
_arguments: dict[str | None, tuple[UrscriptArgument, ...]] = {None: ()}
_MOST_ARGUMENTS = 20_000


def quick(text: str) -> Instruction | None:
    """The move or point in `text`, or None when it is not plain. A logical line without its comment."""
    if text.startswith("move"):
        found = _MOVE.fullmatch(text)
        return None if found is None else _move(found)
    if text.endswith("]"):
        found = _POINT.fullmatch(text)
        if found is not None and found[2] not in _WORDS:
            value = _place(found[3])
            if value is not None:
                return _new(Assignment, (found[1] or "", _new(UrscriptName, (found[2],)), "=", value))
    return None


def _move(found: re.Match[str]) -> Instruction | None:
    word, frame, inner, pose, near, plain, tail = found.groups()
    arguments = _arguments.get(tail)
    if arguments is None:
        arguments = _read_arguments(tail)
        if arguments is None:
            return None
    if plain is not None:
        target = _place(plain)
        if target is None:
            return None
    elif frame is not None:
        first, second = _place(frame), _place(inner)
        if first is None or second is None:
            return None
        given = (_new(UrscriptArgument, ("", first)), _new(UrscriptArgument, ("", second)))
        target = _new(Invocation, (_TRANS, given))
    else:
        first, second = _place(pose), _place(near)
        if first is None or second is None:
            return None
        target = Invocation(_KIN, (UrscriptArgument("", first), UrscriptArgument("qnear", second)))
    all_given = (_new(UrscriptArgument, ("", target)), *arguments)
    return _new(Evaluation, (_new(Invocation, (_MOVES[word], all_given)),))


def _place(text: str) -> Node | None:
    if text[-1] != "]":
        return None if text in _WORDS else _new(UrscriptName, (text,))
    pose = text[0] == "p"
    numbers = text[2 if pose else 1 : -1].split(",")
    if max(map(len, numbers)) > _LONGEST:
        return None
    try:
        if pose and len(numbers) == POSE_NUMBERS:
            values = tuple(map(float, numbers))
            if not abs(sum(values)) < _HUGE:
                return None
            if not all(values):  # -0 is a whole number, which has no sign
                values = tuple([float(_number(one)) for one in numbers])
            return _new(PlainPose, (values,))
        items = tuple([Literal(_number(one)) for one in numbers])
    except ValueError:
        return None
    if pose:
        return pose_of(items) if len(items) > 2 else None
    return ListOf(items)


def _read_arguments(tail: str) -> tuple[UrscriptArgument, ...] | None:
    found: list[UrscriptArgument] = []
    for part in tail.split(",")[1:]:
        match = _ARGUMENT.fullmatch(part.strip(" "))
        given = None if match is None else _given(match)
        if given is None:
            break
        found.append(given)
    else:
        if len(_arguments) >= _MOST_ARGUMENTS:
            _arguments.clear()
            _arguments[None] = ()
        _arguments[tail] = tuple(found)
        return tuple(found)
    return None


def _given(match: re.Match[str]) -> UrscriptArgument | None:
    name, number, value, factor = match.groups()
    if name in _WORDS or value in _WORDS or len(number or factor or "") > _LONGEST:
        return None
    if number is not None:
        return UrscriptArgument(name or "", Literal(_number(number)))
    given: Node = UrscriptName(value)
    if factor is not None:
        given = UrscriptPair("*", given, Literal(_number(factor)))
    return UrscriptArgument(name or "", given)


def _number(text: str) -> int | float:
    text = text.strip(" ")
    value = int(text) if text.lstrip("+-").isdigit() else float(text)
    if not abs(value) < _HUGE:
        raise ValueError(text)
    return value


_CODE: Final = re.compile(r'(?:[^"#]+|"[^"]*"|")*')
_STRINGS: Final = re.compile(r'"[^"]*"')
_BRACKETS: Final = re.compile(r"[()\[\]]")
_PLACEHOLDER: Final = re.compile(r"\{\{.*?\}\}|\{%.*?%\}")
_STARTS: Final = re.compile(r"(?:def|thread|sec|if|elif|while|return|global|local|end|else)(?![A-Za-z0-9_])")
_HEAD: Final = re.compile(r"(def|thread|sec|if|elif|else|while|end)(?![A-Za-z0-9_])")
_DEEP: Final = re.compile(r"[-+*/%!]|[=<>]=?|\b(?:and|or|xor|not|run)\b")
_CHAIN: Final = re.compile(r"[\])]\s*[\[(]|\.[A-Za-z_]")
_LONG_NUMBER: Final = re.compile(r"(?<![\w.])\d{19,}(?![\d.eE])|\d{100,}")
_GOES_ON: Final = re.compile(r".*(?:[-+*/%=<>,]|(?<![A-Za-z0-9_])(?:and|or|xor|not))", re.DOTALL)
_BRANCH: Final = re.compile(r"(?<=[^A-Za-z0-9_.])(?:elif|else)(?![A-Za-z0-9_])")
_MOST_JOINED = 300
_MOST_UNCLOSED = 20  # after which only the next lines are looked at
_MOST_CHARACTERS = 100_000
_MOST_NESTED = 400
_MOST_CACHED = 50_000

_seen: dict[str, Instruction] = {}


class Mark(NamedTuple):
    """A comment, a `$ n "node"` line of PolyScope (`text` begins with $), or a line that is kept as it is."""

    text: str
    opaque: bool = False


class Broken(NamedTuple):
    """An instruction that the grammar refuses. `head`: the word that opens or ends a block, or nothing."""

    text: str
    head: str


class UrscriptLine(NamedTuple):
    """One instruction. `last`: the last physical line of it."""

    number: int
    last: int
    content: Instruction | Mark | Broken
    comment: str = ""


class UrscriptLineReader:
    """Reads the instructions of one file and tells what is wrong with them. `plain` False: moves may be shadowed."""

    def __init__(self, findings: Findings) -> None:
        self._findings = findings
        self._lines = findings.source.lines
        self._kinds = findings.kinds
        self._broken = 0
        self._unclosed = 0
        self._shelf = result_cache.shelf("urscript lines")

    def read(self) -> Iterator[UrscriptLine]:
        """All instructions in order; every physical line gets its kind."""
        number, count, lines, kinds = 0, len(self._lines), self._lines, self._kinds
        new: Callable[..., UrscriptLine] = tuple.__new__  # as the constructor does, in half the time
        read = quick if self._shelf is None else self._quick
        while number < count:
            text = lines[number].strip(" \t\f\u00a0\x1a")
            number += 1
            instruction = read(text)
            if instruction is not None:
                kinds[number - 1] = LineKind.STATEMENT
                yield new(UrscriptLine, (number, number, instruction, ""))
                continue
            if not text:
                continue
            mark = self._mark(text, number)
            for line in [mark] if mark is not None else self._statements(text, number):
                number = line.last
                yield line

    def _quick(self, text: str) -> Instruction | None:
        """`quick`, or what it gave for the same line of an earlier text."""
        if self._shelf is None:
            return quick(text)
        known = self._shelf.get(text)
        if known is None:
            known = (quick(text),)
            self._shelf.put(text, known)
        found: Instruction | None = known[0]
        return found

    def _mark(self, text: str, number: int) -> UrscriptLine | None:
        if text[0] == "#":
            self._kinds[number - 1] = LineKind.COMMENT
            return UrscriptLine(number, number, Mark(text[1:]))
        if text[0] == "$":
            self._kinds[number - 1] = LineKind.COMMENT
            return UrscriptLine(number, number, Mark(text))
        if "{" in text and _PLACEHOLDER.search(_STRINGS.sub('""', text)):
            return self._placeholder(text, number)
        return None

    def _placeholder(self, text: str, number: int) -> UrscriptLine:
        self._kinds[number - 1] = LineKind.OPAQUE
        self._findings.once(
            Severity.WARNING,
            "P556",
            "",
            "a placeholder of a template: the line is kept and not modelled",
            self._findings.whole_line(number),
            "fill the template in before it is read",
        )
        head = _HEAD.match(text)
        if head is not None:
            return UrscriptLine(number, number, Broken(text, head[1]))
        return UrscriptLine(number, number, Mark(text, opaque=True))

    def _statements(self, text: str, number: int) -> list[UrscriptLine]:
        """The instruction that begins here; those of a whole `if` in one line, which is parted at elif and else."""
        known = None if self._shelf is None else self._shelf.get((text,))
        if known is not None:
            self._kinds[number - 1] = LineKind.STATEMENT
            return [UrscriptLine(number, number, *known)]
        code, comment = split_comment(text)
        last = number
        if _open_brackets(code) > 0 or _GOES_ON.fullmatch(code):
            code, comment, last = self._joined(code, comment, number)
        for place in range(number, last + 1):
            self._kinds[place - 1] = LineKind.STATEMENT
        parts = _branches(code)
        found = [
            self._quick(one) or _seen.get(one) or self._parse(one, number, last, begin)
            for begin, one in parts
        ]
        if self._shelf is not None and len(found) == 1 and last == number and type(found[0]) is not Broken:
            self._shelf.put((text,), (found[0], comment))
        comments = [""] * (len(parts) - 1) + [comment]
        return [UrscriptLine(number, last, one, said) for one, said in zip(found, comments, strict=True)]

    def _joined(self, code: str, comment: str, number: int) -> tuple[str, str, int]:
        """The instruction with the lines that close its brackets; alone where nothing closes them."""
        parts, comments, depth = [code], [comment] if comment else [], _open_brackets(code)
        most = _MOST_JOINED if self._unclosed < _MOST_UNCLOSED else _MOST_UNCLOSED
        for last in range(number + 1, min(number + most, len(self._lines)) + 1):
            more, remark = split_comment(self._lines[last - 1].strip(" \t\f\u00a0\x1a"))
            if _STARTS.match(more):
                break
            parts.append(more)
            if remark:
                comments.append(remark)
            depth += _open_brackets(more)
            if depth <= 0 and not _GOES_ON.fullmatch(more):
                return "\n".join(parts), " ".join(comments), last
        self._unclosed += 1
        return code, comment, number

    def _parse(self, code: str, number: int, last: int, begin: int) -> Instruction | Broken:
        """`begin`: where the instruction stands in its line."""
        from lark.exceptions import UnexpectedInput

        from olp.languages.vendors.urscript.grammar import instruction_parser

        head = _HEAD.match(code)
        broken = Broken(code, head[1] if head else "")
        if self._too_much(code, number):
            return broken
        if self._broken >= MOST_BROKEN:
            self._kinds[number - 1] = LineKind.ERROR
            give_up(self._findings, "P554", Span(number, 1, 2), "lines new to olp")
            return broken
        try:
            instruction: Instruction = instruction_parser().parse(code)
        except UnexpectedInput as refused:
            self._report(refused, code, number, last, begin)
            return broken
        if len(_seen) >= _MOST_CACHED:
            _seen.clear()
        _seen[code] = instruction
        return instruction

    def _too_much(self, code: str, number: int) -> bool:
        """Whether a line is beyond what any controller takes, which is told: it could only exhaust olp."""
        plain = _STRINGS.sub('""', code)
        depth = deepest = 0
        for bracket in _BRACKETS.findall(plain):
            depth += 1 if bracket in "([" else -1
            deepest = max(deepest, depth)
        # Each bracket may hold one chain of operators that nests to the left.
        nested = (deepest + 1) * (_most_operators(plain) + 1) + len(_CHAIN.findall(plain))
        if len(code) <= _MOST_CHARACTERS and nested <= _MOST_NESTED and not _LONG_NUMBER.search(plain):
            return False
        help = (
            f"at most {_MOST_CHARACTERS} characters, some {_MOST_NESTED} operators and brackets in one another "
            "and numbers of 18 digits are read"
        )
        span = self._findings.whole_line(number)
        self._findings.error("P553", "an instruction beyond what any controller takes", span, help)
        return True

    def _report(self, refused: UnexpectedInput, code: str, number: int, last: int, begin: int) -> None:
        self._broken += 1
        problem = explain(refused, code)
        physical = min(number + code.count("\n", 0, problem.offset), last)
        first = code.rfind("\n", 0, problem.offset) + 1
        text = self._lines[physical - 1]
        column = len(text) - len(text.lstrip(" \t\f\u00a0")) + problem.offset - first + 1
        column += begin if first == 0 else 0
        for place in range(number, last + 1):
            self._kinds[place - 1] = LineKind.ERROR
        span = Span(physical, column, column + problem.length)
        self._findings.error("P550", problem.message, span, problem.help)


def _branches(code: str) -> list[tuple[int, str]]:
    """The instruction, parted before each elif and else that stands behind something in its line; where each begins."""
    if "el" not in code or not _BRANCH.search(code):
        return [(0, code)]
    plain = _STRINGS.sub(lambda text: " " * len(text[0]), code)
    places = [0, *(found.start() for found in _BRANCH.finditer(plain)), len(code)]
    return [(begin, code[begin:end].strip()) for begin, end in pairwise(places)]


def split_comment(text: str) -> tuple[str, str]:
    """The instruction and its comment, both without blanks around them."""
    if "#" not in text:
        return text, ""
    match = _CODE.match(text)
    assert match is not None  # the pattern matches nothing, too
    return text[: match.end()].rstrip(), text[match.end() + 1 :].strip()


def _open_brackets(code: str) -> int:
    """How many brackets are open at the end."""
    opened = code.count("(") + code.count("[") - code.count(")") - code.count("]")
    if '"' not in code:
        return opened
    plain = _STRINGS.sub("", code)
    return plain.count("(") + plain.count("[") - plain.count(")") - plain.count("]")


def _most_operators(plain: str) -> int:
    """The most operators between two commas: a bound on how deep an expression nests to the left."""
    return max(len(_DEEP.findall(part)) for part in plain.split(","))


# --- Problems ---
# What is wrong with an instruction that the grammar refuses, in words.

WORDS: Final = {
    "NAME": "a name",
    "NUMBER": "a number",
    "TEXT": 'a text such as "part ready"',
    "LPAR": "'('",
    "RPAR": "')'",
    "LSQB": "'['",
    "RSQB": "']'",
    "COMMA": "','",
    "COLON": "':'",
    "EQUAL": "'='",
    "DOT": "'.'",
    "COMPARE": "an operator",
    "SUM": "an operator",
    "PRODUCT": "an operator",
    "AND": "an operator",
    "OR": "an operator",
    "XOR": "an operator",
    "END": "end",
    "DEFINE": "def or thread",
    "$END": "the end of the line",
}
_VALUE: Final = frozenset({"NAME", "NUMBER", "TEXT", "LPAR", "LSQB"})
_FOREIGN: Final = {
    "for": "URScript has no for: count with while",
    "&&": "write and",
    "||": "write or",
    "try": "URScript has no try",
    "import": "URScript has no import",
    "++": "write x = x + 1",
}
_WORD = re.compile(r"\w+|\S")
_MOST = 6


class UrscriptProblem(NamedTuple):
    """`offset`, `length`: in the text of the instruction, from 0."""

    message: str
    offset: int
    length: int
    help: str


def explain(refused: UnexpectedInput, text: str) -> UrscriptProblem:
    """The refused instruction in words: what stands there, and what could stand there."""
    offset = refused.pos_in_stream if isinstance(refused.pos_in_stream, int) else len(text)
    token = getattr(refused, "token", None)
    if token is not None and token.type == "$END":
        offset = len(text)
    help = _foreign(text, offset) or _sentence(expected(refused))
    if not 0 <= offset < len(text):
        return UrscriptProblem("the line ends too early", len(text), 1, help)
    if text[offset] == '"':
        return UrscriptProblem(
            "a text that is not closed", offset, len(text) - offset, 'close it with " on the same line'
        )
    word = _WORD.match(text, offset)
    found = word[0] if word else text[offset]
    return UrscriptProblem(f"'{found[:40]}' does not fit here", offset, len(found), help)


def _foreign(text: str, offset: int) -> str:
    """What a word of another language is called here, or nothing."""
    if text[offset : offset + 1] == "=" and text.startswith(("if", "elif", "while")):
        return "compare with =="
    first = _WORD.match(text)
    for word, help in _FOREIGN.items():
        if (word.isalpha() and first is not None and first[0] == word) or (
            not word.isalpha() and word in text
        ):
            return help
    return ""


def _sentence(names: set[str]) -> str:
    if "SUM" in names and "COMPARE" in names:
        names = names - {"LPAR", "LSQB", "DOT"}  # what goes on behind any value helps nobody
    words = {WORDS.get(name, "") for name in names - _VALUE} - {""}
    if names >= {"NAME", "NUMBER"}:
        words.add("a value")
    elif names & _VALUE:
        words |= {WORDS[name] for name in names & _VALUE}
    if not words or len(words) > _MOST:
        return ""
    return f"expected {', '.join(sorted(words))}"
