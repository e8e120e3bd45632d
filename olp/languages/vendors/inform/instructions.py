"""The lines between //INST and END: the fast path first, then lines seen before, then the grammar.

The fast path reads plain move lines without the grammar: a CAM job has 100,000 of them. `InformMoveLines.read`
understands literal MOVJ, MOVL, MOVC and SMOVx lines and gives exactly the statement that the grammar gives (a test
compares the two); whatever else a line holds, it declines, and the grammar reads it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from olp.core import result_cache
from olp.core.diagnostic import Severity, Span
from olp.core.result_cache import CacheShelf
from olp.core.units import mm
from olp.ir import program as st
from olp.ir.expressions import Number, Position, Store, Taught, Unknown, Variable
from olp.languages.findings import Findings
from olp.languages.lark_host import (
    MOST_BROKEN,
    BrokenLineError,
    column_of,
    either,
    expected,
    give_up,
    in_words,
    shortened,
    values_of,
    word_at,
)
from olp.languages.vendors.inform import values
from olp.languages.vendors.inform.positions import ROW

if TYPE_CHECKING:
    from lark.exceptions import UnexpectedInput

    from olp.languages.vendors.inform.statements import InformLine


_NUMBER = r"\d{1,9}(?:\.\d{0,9})?"
_NOT_ZERO = r"(?!0+(?:\.0*)?(?![\d.]))"
_POSITION = r"(?:BC|EC|C|L?BP|L?EX|L?P)\d{1,6}"
MOVE_LINE: Final = re.compile(
    rf"(MOV[JLC]|SMOV[LC]) ({_POSITION}(?: {_POSITION})?)"
    rf"(?: (VJ?={_NOT_ZERO}{_NUMBER}))?(?: (PL=[0-8]|CR={_NUMBER}))?(?: {{1,2}}\+MOVJ ({_POSITION}(?: VJ={_NUMBER})?))?"
    r"(?: *//(.*?))?\s*",
    re.ASCII,
)
_PATHS: Final = {"J": st.Path.JOINT, "L": st.Path.LINEAR, "C": st.Path.CIRCULAR}


class InformMoveLines:
    """Reads plain move lines of one file; equal words share one object."""

    def __init__(self) -> None:
        self._targets: dict[str, tuple[Position, ...]] = {}
        self._speeds: dict[str | None, st.Speed | None] = {None: None}
        self._blends: dict[str | None, st.Blend | None] = {None: None}
        self._parts: dict[str | None, tuple[st.MovePart, ...]] = {None: ()}

    def read(self, line: str, number: int) -> st.Move | None:
        """The move in `line`, or None when it is not plain."""
        match = MOVE_LINE.fullmatch(line)
        if match is None:
            return None
        word, where, spoken, level, second, comment = match.groups()
        if where[0] == "C" and where.isalnum():
            # Nearly every taught point is used once: sharing them would cost more than it saves.
            targets: tuple[Position, ...] = (Taught(Store.ROBOT, int(where[1:])),)
        else:
            targets = self._targets.get(where) or self._find_targets(where)
        try:
            speed, blend, parts = self._speeds[spoken], self._blends[level], self._parts[second]
        except KeyError:
            speed, blend, parts = self._speed(spoken), self._blend(level), self._part(second)
        path = _PATHS[word[-1]]
        if word[0] == "S":
            return st.Move(number, path, targets, speed, blend, parts, comment or "", coordinated=True)
        return st.Move(number, path, targets, speed, blend, parts, comment or "")

    def _find_targets(self, text: str) -> tuple[Position, ...]:
        found = tuple(_position(word) for word in text.split(" "))
        self._targets[text] = found
        return found

    def _speed(self, text: str | None) -> st.Speed | None:
        if text not in self._speeds:
            self._speeds[text] = values.literal_speed(text)
        return self._speeds[text]

    def _blend(self, text: str | None) -> st.Blend | None:
        if text is not None and text not in self._blends:
            size = values.number(text[3:])
            radius = text[0] == "C"
            kind = st.BlendKind.RADIUS if radius else st.BlendKind.LEVEL
            self._blends[text] = st.Blend(kind, values.quantity(size, (mm, mm) if radius else values.LEVEL))
        return self._blends[text]

    def _part(self, text: str | None) -> tuple[st.MovePart, ...]:
        if text is not None and text not in self._parts:
            position, _, spoken = text.partition(" ")
            speed = self._speed(spoken) if spoken else None
            self._parts[text] = (st.MovePart(st.Path.JOINT, (_position(position),), speed),)
        return self._parts[text]


class RememberedLines(InformMoveLines):
    """The same for a text that was read before: its lines are taken from memory."""

    def __init__(self, shelf: CacheShelf) -> None:
        super().__init__()
        self._shelf = shelf

    def read(self, line: str, number: int) -> st.Move | None:
        known: st.Move | None = self._shelf.get(line)
        if known is not None and known.line == number:
            return known
        found = super().read(line, number) if known is None else _on_line(known, number)
        if found is not None:
            self._shelf.put(line, found)
        return found


def _on_line(it: st.Move, number: int) -> st.Move:
    """The same plain move on another line."""
    same = (it.path, it.targets, it.speed, it.blend, it.parts, it.comment)
    return st.Move(number, *same, coordinated=it.coordinated)


def move_lines() -> InformMoveLines:
    """The reader of plain lines for one file."""
    shelf = result_cache.shelf("inform moves")
    return InformMoveLines() if shelf is None else RememberedLines(shelf)


def _position(word: str) -> Position:
    if word[0] == "C" or word[1] == "C":
        kind = word.rstrip("0123456789")
        return Taught(values.TAUGHT_STORES[kind], int(word[len(kind) :]))
    return values.variable(word)


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
    r"\s*(?:(?:CALL|JUMP)\s+(?:IGH?#|L?[BID]\d)|SPEED\s[^'/]*\bVE=|(?:ADD|SUB|MUL|DIV)\s+L?(?:P|BP|EX)\d+\s*\("
    r"|PULSE\s+O(?:T|GH?)#\([^()]*\)\s+(?:L?[BID]\d|O))"  # of the group's signals that a value says, or of several
)
_MOST_SUGGESTED = 50  # unknown words that are compared with all known ones
_MOST_CACHED = 50_000

# A statement's class and all its values but the line.
_Template = tuple[Callable[..., st.Statement], tuple[Any, ...]]
# NOP and END stand in every job: a job of plain moves needs no grammar at all.
_PRESET: Final[dict[str, _Template]] = {"NOP": (st.Begin, ("",)), "END": (st.End, ("",))}
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
        self.markers: list[st.Statement] = []  # stand for broken lines that open or continue a block

    def read(self, lines: Sequence[str], first: int) -> list[st.Statement]:
        """The statements in `lines`, the first of which is line `first` of the file."""
        body: list[st.Statement] = []
        move, seen, own, kinds = self._moves.read, _seen, self._own, self._kinds
        for number, line in enumerate(lines, first):
            statement: st.Statement | None = move(line, number)
            if statement is None:
                template = own.get(line) or seen.get(line)
                if template is None:
                    body.extend(self._read(line, number))
                    continue
                statement = template[0](number, *template[1])
            kinds[number - 1] = st.LineKind.STATEMENT
            body.append(statement)
        return body

    def _read(self, line: str, number: int) -> tuple[st.Statement, ...]:
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
        from olp.languages.vendors.inform.statements import instruction_parser

        return instruction_parser().words

    def _comment(self, text: str, number: int) -> tuple[st.Statement, ...]:
        text = text.lstrip(" \t")
        if _RECORD.match(text):
            self._misplaced("P015", "a header record among the instructions", number)
            return ()
        self._kinds[number - 1] = st.LineKind.COMMENT
        return (st.Comment(number, text[1 if text[0] == "'" else 2 :]),)

    def _misplaced(self, code: str, message: str, number: int) -> None:
        help = "move it above NOP; is the line /JOB of another job missing?"
        self._findings.error(code, message, self._findings.whole_line(number), help)

    def _opaque(self, text: str, word: str, number: int) -> st.Opaque:
        from difflib import get_close_matches

        self._kinds[number - 1] = st.LineKind.OPAQUE
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
        return st.Opaque(number, text.strip())

    def _parse(self, text: str, line: str, number: int) -> tuple[st.Statement, ...]:
        from lark.exceptions import UnexpectedInput

        if self._broken >= MOST_BROKEN:
            self._kinds[number - 1] = st.LineKind.ERROR
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
        self._kinds[number - 1] = st.LineKind.STATEMENT
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

        from olp.languages.vendors.inform.statements import instruction_parser

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
MARKERS: Final[dict[str, Callable[[int], st.Statement]]] = {
    "IFTHEN": lambda line: st.If(line, _UNKNOWN),
    "IFTHENEXP": lambda line: st.If(line, _UNKNOWN),
    "ELSEIF": lambda line: st.ElseIf(line, _UNKNOWN),
    "ELSEIFEXP": lambda line: st.ElseIf(line, _UNKNOWN),
    "ELSE": lambda line: st.Else(line),
    "ENDIF": lambda line: st.EndIf(line),
    "WHILE": lambda line: st.While(line, _UNKNOWN),
    "WHILEEXP": lambda line: st.While(line, _UNKNOWN),
    "ENDWHILE": lambda line: st.EndWhile(line),
    "FOR": lambda line: st.For(line, Variable(Store.BYTE, Number(0)), _UNKNOWN, _UNKNOWN),
    "NEXT": lambda line: st.Next(line, None),
    "SWITCH": lambda line: st.Switch(line, _UNKNOWN),
    "CASE": lambda line: st.Case(line, ()),
    "DEFAULT": lambda line: st.Default(line),
    "ENDSWITCH": lambda line: st.EndSwitch(line),
}


# Each terminal of the grammar in words. Those that share a sentence are told once.
WORDS: Final = {
    "NUMBER": "a number",
    "UNSIGNED": "a number",
    "STRING": 'a text such as "OK"',
    "VARIABLE": "a variable such as B000, LD012 or P040",
    "ARRAY": "a variable such as B000, LD012 or P040",
    "NAME": "a name from //ALIAS",
    "TAUGHT": "a position such as C00001",
    "SPEED_TAG": "a speed such as V=300.0 or VJ=25.00",
    "LEVEL_TAG": "a position level such as PL=1",
    "RATE_TAG": "ACC= or DEC=",
    "RADIUS_TAG": "CR=",
    "OTHER_TAG": "CV=, VE= or SPDL=",
    "TIME_TAG": "a time such as T=0.50",
    "DISTANCE_TAG": "a distance such as DIS=20.0",
    "KIND_TAG": "KIND=",
    "NUMBER_TAG": "PRMNO=",
    "COUNT_TAG": "SNUM=",
    "TAG": "a value such as AMP=2.0",
    "INDEXED": "a condition file such as ASF#(1)",
    "SIGNAL": "a signal such as IN#(1) or OT#(1)",
    "STATE": "ON or OFF",
    "HALF": "LOW or HIGH",
    "LPAR": "'('",
    "RPAR": "')'",
    "LSQB": "'['",
    "RSQB": "']'",
    "COMMA": "','",
    "EQUAL": "'='",
    "COMPARE": "a comparison such as =, <> or <",
    "PLUS": "'+'",
    "MINUS": "'-'",
    "TIMES": "'*'",
    "DIVIDE": "'/'",
    "COMMENT": "a comment such as //seam start",
    "LABEL": "a label such as *START",
    "JOB": "a job such as JOB:MAIN",
    "ARGF": "an argument such as ARGF1",
    "SUFFIX": "a condition such as IF IN#(1)=ON",
    "JOINT": "ANDIF, ORIF, ANDEXP or OREXP",
    "FOREXPRESS": "FOREXPRESS",
    "FRAME": "a coordinate system such as UF#(1) or BF",
    "USER_MARK": "a coordinate system such as UF#(1) or BF",
    "TOOL_MARK": "a tool such as TL#(1)",
    "MACRO_MARK": "a macro such as MJ#(1)",
    "IARG": "an argument such as IARG#(1)",
    "STEP_MARK": "a step such as STEP#(1)",
    "EXPRESS": "EXPRESS with an expression",
    "SRCH": "a search such as SRCH RIN#(1)=ON DIS=20.0",
    "UNTIL": "UNTIL with a condition",
    "CONTINUOUS": "CONT",
    "END_OF_ARC": "FPT",
    "NO_WAIT": "NWAIT",
    "PASSES": "a pass such as T00001",
    "MOVE": "MOVJ or MOVL",
    "REFERENCE": "REFP",
    "START": "START=",
    "CASE": "CASE",
    "TO": "TO",
    "STEP": "STEP=",
    "TASK": "a task such as SUB1",
    "SYNC": "SYNC",
    "ALL": "ALL",
    "CLEAR_WORD": "STACK or MPF",
    "MTOOL": "MTOOL",
    "RETURNED": "$RV",
    "SYSTEM_VALUE": "a system variable such as $PX000 or $B002",
    "DISABLED": "an instruction",
    "COMPUTED": "LABEL: with a variable",
    "$END": "the end of the line",
}
# The end of a line and a comment fit nearly everywhere and help nobody who misses something else.
_LAST = ("the end of the line", "a comment such as //seam start")
_MOST = 6
_NUMBER_BEFORE = re.compile(r"(?<![\w.])[\d.]+$")
_NUMBER_GOES_ON = frozenset(".0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_")
_BARE_TAG = re.compile(r"([A-Z]+=)(?:\s+[A-Z]+|\s*)$")
_WORD_BEFORE = re.compile(r"[^\W\d]\w*$")
_KNOWN_TAGS = frozenset({"V=", "VJ=", "VR=", "PL=", "ACC=", "DEC=", "CR=", "T=", "UF#", "SRCH="})


class InformProblem(NamedTuple):
    """`column`, `end_column`: 1-based, in the line."""

    message: str
    column: int
    end_column: int
    wanted: str


def explain(problem: UnexpectedInput, line: str) -> InformProblem:
    """The refused line in words: what stands there, and what could stand there."""
    names, text = expected(problem), line.rstrip()
    length, column = len(text), column_of(problem, text)
    if column > length:
        return InformProblem("the line ends too early", column, column + 1, sentence(names))
    return _odd_word(line, column) or _unknown_tag(line, column, names) or _unexpected(line, column, names)


def _unexpected(line: str, column: int, names: set[str]) -> InformProblem:
    word = word_at(line, column)
    return InformProblem(
        f"'{_shown(word)}' is not expected here", column, column + len(word), sentence(names)
    )


def _odd_word(line: str, column: int) -> InformProblem | None:
    """A text without its end, a number with two points, a tag without its value."""
    if line[column - 1] == '"':
        return InformProblem("a text that is never closed", column, len(line) + 1, 'a " at its end')
    glued = _NUMBER_BEFORE.search(line[: column - 1])
    if glued is not None and line[column - 1] in _NUMBER_GOES_ON:
        start, word = glued.start() + 1, glued[0] + word_at(line, column)
        return InformProblem(f"'{_shown(word)}' is no number", start, start + len(word), "a number")
    bare = _BARE_TAG.search(line[: column - 1])
    if bare is not None and not (bare.end() == column - 1 and line[column - 1] not in " \t="):
        return InformProblem(
            f"{bare[1]} has no value", bare.start(1) + 1, bare.end(1) + 1, "a number or a variable"
        )
    return None


def _unknown_tag(line: str, column: int, names: set[str]) -> InformProblem | None:
    """`VV=1`: the grammar takes VV for a name and stumbles over the `=` only."""
    before = _WORD_BEFORE.search(line[: column - 1])
    if before is None or line[column - 1] not in "=#" or "COMPARE" in names:
        return None
    start, word = before.start() + 1, before[0] + line[column - 1]
    if word in _KNOWN_TAGS:
        missing = WORDS["TAUGHT"] if "TAUGHT" in names else sentence(names)
        return InformProblem(f"'{word}' is not expected here", start, start + len(word), missing)
    wanted = sentence(names - {"NAME", "VARIABLE", "ARRAY", "TAUGHT"})
    return InformProblem(f"'{_shown(word)}' is not known here", start, start + len(word), wanted)


def sentence(terminals: Iterable[str]) -> str:
    """`terminals` in words: the likely ones first, not more than six."""
    names = set(terminals)
    if "PLUS" in names:
        names.discard("NUMBER")  # a number with a sign continues a sum
    if "COMPARE" in names:
        names.discard("EQUAL")
    words = in_words(names, WORDS)
    likely = [word for word in words if word not in _LAST] or words
    if len(likely) > _MOST:
        return ", ".join([*likely[:_MOST], "…"])
    return either(likely) or "something else"


def _shown(word: str) -> str:
    from olp.languages.vendors.inform.expressions import unmangle

    return shortened(unmangle(word))
