"""The instructions of /MN: the fast path first, then lines seen before, then the grammar.

Before, numbers and semicolons are taken off, continued lines joined, P-SPS blocks found. The fast path reads plain
move lines without the grammar: a CAM program has 100,000 of them. `TpMoveLines.read` understands J, L and A moves
with literal numbers and gives exactly the statement that the grammar gives (a test compares the two); whatever else a
line holds, it declines, and the grammar reads it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from olp.core.diagnostic import Severity, Span
from olp.core.units import mm
from olp.ir import program as st
from olp.ir.expressions import Member, Number, Quantity, Store, Taught, Text, Variable
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
from olp.languages.vendor import ACKNOWLEDGED, ON_THE_WAY
from olp.languages.vendors.tp import values
from olp.languages.vendors.tp.moves import WELD_SPEED, kept

if TYPE_CHECKING:
    from lark.exceptions import UnexpectedInput


_NUMBER = r"(?!0+(?:\.0*)?(?![\d.]))\d{1,9}(?:\.\d{1,9})?"
_CORNER = r"FINE|CNT\d{1,3}|C[RD]\d{1,4}(?:\.\d{1,6})?"
MOVE_LINE: Final = re.compile(
    r"([JLA]) {1,4}P\[(\d{1,6})(?::[^\]]*)?\] {1,4}"
    rf"({_NUMBER}(?:%|mm/sec|cm/min|inch/min|deg/sec|msec|sec)|WELD_SPEED) {{1,4}}({_CORNER})"
    r"(?: {1,4}ACC(\d{1,3}))?((?: {1,4}(?:COORD|PTH|RTCP|BREAK))*)\s*",
    re.ASCII,
)
_SPEED: Final = re.compile(r"([\d.]+)(.*)")


class TpMoveLines:
    """Reads plain move lines of one file; equal words share one object."""

    def __init__(self) -> None:
        self._speeds: dict[str, st.Speed] = {}
        self._blends: dict[str, st.Blend] = {"FINE": values.FINE}
        self._rates: dict[str | None, Quantity | None] = {None: None}
        self._others: dict[str, tuple[tuple[str, object], ...]] = {"": ()}

    def read(self, text: str, number: int) -> st.Move | None:
        """The move in `text`, or None when it is not plain."""
        match = MOVE_LINE.fullmatch(text)
        if match is None:
            return None
        letter, point, spoken, corner, rate, other = match.groups()
        try:
            speed, blend = self._speeds[spoken], self._blends[corner]
        except KeyError:
            speed, blend = self._speed(spoken), self._blend(corner)
        targets = (Taught(Store.ROBOT, int(point)),)
        path = values.PATHS[letter]
        if rate is None and not other:
            return st.Move(number, path, targets, speed, blend)
        return self._with_options(number, path, targets, speed, blend, rate, other)

    def _with_options(
        self,
        number: int,
        path: st.Path,
        targets: tuple[Taught],
        speed: st.Speed,
        blend: st.Blend,
        rate: str | None,
        other: str,
    ) -> st.Move:
        if rate not in self._rates:
            self._rates[rate] = Quantity(Number(int(rate or 0)), values.PERCENT)
        if other not in self._others:
            self._others[other] = tuple(kept(word).value for word in other.split())
        words = self._others[other]
        return st.Move(number, path, targets, speed, blend, acceleration=self._rates[rate], other=words)  # type: ignore[arg-type]

    def _speed(self, text: str) -> st.Speed:
        if text not in self._speeds:
            if text == "WELD_SPEED":
                unit, scale = values.UNITS["mm/sec"]
                self._speeds[text] = st.Speed(unit, Quantity(WELD_SPEED, mm), text)
            else:
                match = _SPEED.fullmatch(text)
                assert match is not None
                unit, scale = values.UNITS[match[2]]
                self._speeds[text] = st.Speed(unit, Quantity(Number(values.number(match[1])), scale))
        return self._speeds[text]

    def _blend(self, text: str) -> st.Blend:
        if text not in self._blends:
            word = "CNT" if text[1] == "N" else text[:2]
            kind, scale = values.CORNERS[word]
            size = Quantity(Number(values.number(text[len(word) :])), scale)
            self._blends[text] = st.Blend(kind, size, "" if word == "CNT" else word)
        return self._blends[text]


NUMBERED: Final = re.compile(r"\s*(\d*)\s*:(?!:)")
_BLOCK_END = re.compile(r"\s*-{3,}\s*;?\s*")
_MOST_JOINED = 60  # lines of one instruction


class TpLine(NamedTuple):
    """One instruction. `closed`: it ended with a semicolon. `lines`: source lines that it takes."""

    number: int  # of its first source line
    text: str
    closed: bool = True
    lines: int = 1
    block_end: bool = False  # the ------ that ends a P-SPS block


def instructions(lines: tuple[str, ...], first: int, stop: int) -> Iterator[TpLine]:
    """The instructions in source lines `first` .. `stop` - 1 (from 1), blank lines left out."""
    number = first
    while number < stop:
        text = lines[number - 1]
        if not text.strip():
            number += 1
            continue
        if _BLOCK_END.fullmatch(text):
            yield TpLine(number, "", block_end=True)
            number += 1
            continue
        body = _body(text)
        if body.endswith(";"):
            yield TpLine(number, body[:-1].rstrip())
            number += 1
            continue
        line = _joined(lines, number, stop, body)
        yield line
        number += line.lines


def _body(text: str) -> str:
    """The text behind the line's number, without the blanks around it."""
    match = NUMBERED.match(text)
    return (text[match.end() :] if match else text).strip(" \t\x1a\x00")


def _joined(lines: tuple[str, ...], number: int, stop: int, body: str) -> TpLine:
    """An instruction that its first line does not close: what follows belongs to it, up to a semicolon."""
    parts, count = [body], 1
    while number + count < stop and count < _MOST_JOINED:
        text = lines[number + count - 1]
        match = NUMBERED.match(text)
        if not text.strip() or _BLOCK_END.fullmatch(text) or (match is not None and match[1]):
            break
        parts.append(_body(text))
        count += 1
        if parts[-1].endswith(";"):
            parts[-1] = parts[-1][:-1].rstrip()
            return TpLine(number, " ".join(parts).strip(), lines=count)
    if count == 1 or not body.startswith(("C ", "L ", "J ", "A ", "S ")):
        return TpLine(number, body, closed=False)
    return TpLine(number, " ".join(parts).strip(), closed=False, lines=count)


# --- German keywords ---
# Controllers set to German write German keywords: they are turned into the English ones, outside names and comments.
#
# Read from published listings of German controllers: other languages are not documented, and stay as they are.

# /ATTR: German -> English.
ATTRIBUTES: Final = {
    "EIGN.": "OWNER",
    "KOMMENTAR": "COMMENT",
    "ERSTELL": "CREATE",
    "DATEI_NAME": "FILE_NAME",
    "ZEILEN": "LINE_COUNT",
    "SPEICHERGR.": "MEMORY_SIZE",
    "SCHUTZ": "PROTECT",
    "DEFAULT_GRUP": "DEFAULT_GROUP",
    "KONTROLLCODE": "CONTROL_CODE",
}
# The umlauts of these came through many code pages.
_ATTRIBUTE_FORMS: Final = (
    (re.compile(r"PROG_GR.{1,4}E"), "PROG_SIZE"),
    (re.compile(r"GE.{1,2}NDERT"), "MODIFIED"),
)
_VALUES: Final = {"LESEN_SCHREIB": "READ_WRITE", "LESEN": "READ"}

_ENGLISH: Final = {
    "WENN": "IF",
    "DANN": "THEN",
    "SONST": "ELSE",
    "AUFRUF": "CALL",
    "SPRUNG": "JMP",
    "WARTE": "WAIT",
    "LABEL": "LBL",
    "AN": "ON",
    "AUS": "OFF",
    "ENDE": "END",
    "FEIN": "FINE",
    "BENUTZER_NUM": "UFRAME_NUM",
    "WKZ_NUM": "UTOOL_NUM",
    "TRAGLST": "PAYLOAD",
    "FB-PSPS": "TC_ONLINE",
    "ZEIT VOR": "TB",
    "ZEIT NACH": "TA",
    "WEG VOR": "DB",
    "Sek": "sec",
    "sek": "sec",
    "[&]": "AND",
    "[+]": "OR",
    "gA[": "GO[",
    "gE[": "GI[",
    "A[": "DO[",
    "E[": "DI[",
    "i[": "R[",
}
_GERMAN_HEAD: Final = re.compile(
    r"^(?:EIGN\.|KOMMENTAR|ERSTELL|SCHUTZ|ZEILEN|KONTROLLCODE)\s*=", re.MULTILINE
)
_PLAIN = "|".join(re.escape(word) for word in sorted(_ENGLISH, key=len, reverse=True) if word[-1].isalnum())
_NUMBERED = "|".join(
    r"(?<=\[" + r"\d" * digits + ")" for digits in range(1, 6)
)  # behind it a comment may hold "["
# Either something to leave alone (texts, comments in brackets, names of programs) or a word to replace.
_TOKENS: Final = re.compile(
    rf"(\"[^\"]*\"|'[^']*'|(?:{_NUMBERED}):[^\];]*\]|"
    r":[^\]\[;]*\]|(?<=AUFRUF )\s*\w+|MESSAGE\[.*)"
    rf"|(\[&\]|\[\+\]|(?<![A-Za-z0-9_$.])g?[AEi]\[|(?<![A-Za-z_$])(?:{_PLAIN})(?![A-Za-z0-9_]))"
)


def is_german(text: str) -> bool:
    """Whether the header of a listing is in German."""
    return _GERMAN_HEAD.search(text) is not None


def in_english(text: str) -> str:
    """One instruction with its German keywords replaced."""
    return _TOKENS.sub(lambda match: match[1] or _ENGLISH[match[2]], text)


def attribute(word: str) -> str:
    """The English name of an attribute of the header."""
    for form, name in _ATTRIBUTE_FORMS:
        if form.fullmatch(word):
            return name
    return ATTRIBUTES.get(word, word)


def attribute_value(text: str) -> str:
    """The value of an attribute: dates and protection in English."""
    text = _VALUES.get(text.strip(), text)
    return re.sub(r"\bTAG (\d\d-\d\d-\d\d)(\s+)ZEIT ", r"DATE \1\2TIME ", text)


BLOCK: Final = "P-SPS"  # the instructions that a controller runs beside a move


class TpInstructionReader:
    """Reads the instructions of one program. `german`: its keywords are German."""

    def __init__(self, findings: Findings, moves: TpMoveLines, german: bool) -> None:
        self._findings = findings
        self._kinds = findings.kinds
        self._moves = moves
        self._parser = TpLineParser(findings, german)
        self._body: list[st.Statement] = []
        self._block = 0  # line of the move that a P-SPS block belongs to
        self._switch = -1  # index behind the last action of an open SELECT

    @property
    def markers(self) -> list[st.Statement]:
        """Stand for broken lines that open a block."""
        return self._parser.markers

    def read(self, lines: Iterable[TpLine]) -> list[st.Statement]:
        """All statements, in order."""
        move, body, kinds = self._moves.read, self._body, self._kinds
        for line in lines:
            number = line.number
            for more in range(line.lines):
                kinds[number - 1 + more] = st.LineKind.STATEMENT
            statement = move(line.text, number)
            if statement is not None:
                if self._switch >= 0:
                    self._end_switch()
                body.append(statement)
            elif line.text:
                self._line(line)
            elif line.block_end:
                self._end_block(number)
            if not line.closed:
                self._unclosed(line)
        if self._switch >= 0:
            self._end_switch()
        return body

    # --- one line ---------------------------------------------------------------------------------------

    def _line(self, line: TpLine) -> None:
        text, number = line.text, line.number
        if text[0] == "!":
            self._kinds[number - 1] = st.LineKind.COMMENT
            self._body.append(st.Comment(number, text[1:]))
            return
        if text.startswith("--eg:"):
            self._kinds[number - 1] = st.LineKind.COMMENT
            self._body.append(st.Comment(number, text))
            return
        if text.startswith("//"):
            self._body.append(st.Disabled(number, text[2:].strip()))
            return
        for statement in self._statements(text, number):
            self._add(statement)

    def _add(self, statement: st.Statement) -> None:
        kind = type(statement)
        if self._switch >= 0:
            self._end_switch()
        if self._block and kind in (st.Label, st.Jump):
            statement = self._inside_block(statement)
        if kind is st.Move and any(BLOCK in getattr(value, "value", "") for _, value in statement.other):  # type: ignore[union-attr]
            self._block = statement.line
        self._body.append(statement)

    def _inside_block(self, statement: st.Statement) -> st.Statement:
        """Labels of a P-SPS block are its own: they get the block's line behind their number."""
        if isinstance(statement, st.Label):
            return replace(statement, name=f"{statement.name}/{self._block}")
        if isinstance(statement, st.Jump) and isinstance(statement.target, str):
            return replace(statement, target=f"{statement.target}/{self._block}")
        return statement

    def _end_block(self, number: int) -> None:
        if not self._block:
            self._findings.warning(
                "P532",
                "the end of a block that never began",
                self._span(number),
                "remove it, or add P-SPS to its move",
            )
            return
        self._block = 0
        if self._switch >= 0:
            self._end_switch()
        self._body.append(st.Process(number, f"{BLOCK} END"))
        message = "a P-SPS block runs beside its move; it is read as standing behind it"
        self._findings.once(
            Severity.INFO, "P531", "", message, self._span(number), "waits in it delay the next move"
        )

    def _end_switch(self) -> None:
        at = self._switch
        self._body.insert(at, st.EndSwitch(self._body[at - 1].line))
        self._switch = -1

    # --- SELECT -----------------------------------------------------------------------------------------

    def _statements(self, text: str, number: int) -> list[st.Statement]:
        found = self._parser.statements(text, number)
        if found and type(found[0]) in (st.Switch, st.Case, st.Default):
            self._begin_case(type(found[0]) is st.Switch, number)
            self._body.extend(found)
            self._switch = len(self._body)
            return []
        return found

    def _begin_case(self, opens: bool, number: int) -> None:
        if opens and self._switch >= 0:
            self._end_switch()
        elif not opens and self._switch < 0:
            self._findings.error(
                "P528", "a case without SELECT", self._span(number), "add SELECT R[1]=1,JMP LBL[1] above"
            )

    def _unclosed(self, line: TpLine) -> None:
        message = "no semicolon ends this instruction"
        self._findings.once(
            Severity.WARNING, "P504", "", message, self._span(line.number), "add ; at its end"
        )

    def _span(self, number: int) -> Span:
        return self._findings.whole_line(number)


# --- Parsing ---
# One instruction's text as statements: lines seen before, then the grammar, then macros; and what is wrong with it.

_MACRO = re.compile(r"([A-Za-z_][A-Za-z0-9_ .\-]*?)\s*(\(.*\))?")
_FIRST_WORD = re.compile(r"[A-Za-z_$]*")
# Words that the grammar knows: a line that begins with one of them and does not parse is wrong.
_KNOWN: Final = frozenset(
    re.findall(
        r"\w+",
        "IF THEN ELSE ENDIF SELECT FOR ENDFOR LBL JMP CALL RUN WAIT END PAUSE ABORT MESSAGE OVERRIDE TIMER "
        "UFRAME UTOOL UFRAME_NUM UTOOL_NUM R PR SR AR P DI DO RI RO GI GO AI AO SI SO UI UO WI WO F M ",
    )
)
_ODD_CALL = re.compile(r"CALL\s+[A-Za-z_]\w*\s*\(.*\)")
_EDGE_WAIT = re.compile(r"(WAIT\s+[A-Z]{2}\[[^\]]*\]\s*=\s*)(ON\+|OFF-)")
_EDGE = re.compile(r"\b(?:ON\+|OFF-)")
_MOTION = re.compile(r"[JLCAS]\s+P")
# Instructions of options that stand alone, as macros do: palletizing, touch sensing, seam tracking, multi-pass.
_OPTION: Final = re.compile(
    r"PALLETIZING-|(?:TOUCH|SEARCH|TRACK|MP|RPM|RTPM|SENSOR)\b|SENSOR_O|FOLLOW UP|STOP_TRACKING|CLEAR_RESUME_PROG",
    re.IGNORECASE,
)
_PALLET_MOVE: Final = re.compile(r"[JL]\s+PAL_\d{1,2}\s*\[")
_OPERATORS = "+-*/("
_MOST_OPERATORS = 200
_MOST_CHARACTERS = 4096
_MOST_CACHED = 50_000
_LONG_NUMBER = re.compile(r"\d{19,}")

_MOST_EXPECTED = 6
# The grammar's terminals in words, the likely ones first.
_WORDS: Final = {
    "MOTION": "a move such as L P[1] 100mm/sec FINE",
    "POINT_OPEN": "a position such as P[1]",
    "POSITION_OPEN": "a position register such as PR[1]",
    "UNIT": "a unit such as mm/sec or %",
    "FINE": "FINE",
    "CORNER": "CNT0 .. CNT100",
    "REGISTER_OPEN": "a register such as R[1]",
    "SIGNAL_OPEN": "a signal such as DI[1]",
    "NUMBER": "a number",
    "STATE": "ON or OFF",
    "LABEL_OPEN": "a label such as LBL[1]",
    "PROGRAM": "the name of a program",
    "COMPARE": "a comparison",
    "EQUAL": "'='",
    "RSQB": "']'",
    "NAMED_CLOSE": "']'",
    "LPAR": "'('",
    "RPAR": "')'",
    "COMMA": "','",
    "THEN": "THEN",
    "AND": "AND",
    "OR": "OR",
    "TIMEOUT": "TIMEOUT,LBL[1]",
    "ACC": "an option such as ACC80 or Offset,PR[1]",
}

# The classes of a line's statements and all their values but the line.
_Template = tuple[tuple[Callable[..., st.Statement], tuple[Any, ...]], ...]
_seen: dict[str, _Template] = {}


class TpLineParser:
    """Understands single instructions of one program. `markers`: stand for broken lines that open a block."""

    def __init__(self, findings: Findings, german: bool) -> None:
        self._findings = findings
        self._kinds = findings.kinds
        self._german = german
        self._broken = 0
        self.markers: list[st.Statement] = []

    def statements(self, text: str, number: int) -> list[st.Statement]:
        """The statements of the instruction in line `number`; none where it is broken."""
        template = None if self._german else _seen.get(text)
        if template is None:
            template = self._template(text, number)
        return [kind(number, *rest) for kind, rest in template]

    def _template(self, text: str, number: int) -> _Template:
        from lark.exceptions import UnexpectedInput

        from olp.languages.vendors.tp.grammar import instruction_parser

        if self._too_much(text, number):
            return ()
        english = in_english(text) if self._german else text
        if self._german and english in _seen:
            return _seen[english]
        if (component := _COMPONENT.fullmatch(english)) is not None:
            template = _set_component(component[1], component[2], component[3] or component[4])
            _remember(english, template)
            return template
        try:
            statements = instruction_parser().statements(english)
        except UnexpectedInput as refused:
            return self._refused(english, number, _explain(refused, english))
        except BrokenLineError as broken:
            problem = _TpProblem(broken.message, 1, len(english) + 1, broken.wanted)
            self._report(problem, number, english)
            return ()
        template = tuple((type(one), values_of(one)) for one in statements)
        _remember(english, template)
        return template

    def _refused(self, text: str, number: int, problem: _TpProblem) -> _Template:
        """A macro, an instruction that nobody models, or a mistake."""
        match = _FIRST_WORD.match(text)
        word = match[0] if match else ""
        edge = _EDGE_WAIT.fullmatch(text)
        if edge is not None:
            # Until it is in the other state, and then until it is not.
            states = ("OFF", "ON") if edge[2] == "ON+" else ("ON", "OFF")
            return tuple(one for state in states for one in self._template(f"{edge[1]}{state}", number))
        if _EDGE.search(text):
            return self._opaque(text, number, "waiting for an edge of a signal")
        if _ODD_CALL.fullmatch(text):
            return self._opaque(text, number, "a call with other arguments than values")
        if _PALLET_MOVE.match(text):
            return self._opaque(text, number, "a move of PALLETIZING", Severity.WARNING)
        if word in _KNOWN or _MOTION.match(text):
            self._report(problem, number, text)
            return ()
        macro = None if _OPTION.match(text) else _MACRO.fullmatch(text)
        if macro is None:
            return self._opaque(text, number, word or text[:20])
        return self._macro(macro, number, text)

    def _macro(self, match: re.Match[str], number: int, text: str) -> _Template:
        from lark.exceptions import UnexpectedInput

        from olp.languages.vendors.tp.grammar import instruction_parser

        name = " ".join(match[1].split())
        try:
            (call,) = instruction_parser().statements(f"CALL M{match[2] or ''}")
        except (UnexpectedInput, BrokenLineError):
            return self._opaque(text, number, name)
        assert isinstance(call, st.Call)
        self._kinds[number - 1] = st.LineKind.STATEMENT
        message = f"{name[:40]} is taken for a macro"
        help = "its effect on the time is that of the program that the macro stands for"
        self._findings.once(Severity.INFO, "P522", name, message, self._span(number), help)
        return ((st.Call, values_of(replace(call, routine=name, spelling="macro"))),)

    def _opaque(self, text: str, number: int, what: str, severity: Severity = Severity.INFO) -> _Template:
        self._kinds[number - 1] = st.LineKind.OPAQUE
        message = f"{what[:40]} is kept but not modelled"
        help = "its effect on the time is unknown"
        self._findings.once(severity, "P521", what, message, self._span(number), help)
        return ((st.Opaque, (text,)),)

    # --- what is wrong ----------------------------------------------------------------------------------

    def _too_much(self, text: str, number: int) -> bool:
        """Whether a line is beyond what any controller takes, which is told: it could only exhaust olp."""
        operators = sum(map(text.count, _OPERATORS)) if len(text) > _MOST_OPERATORS else 0
        if self._broken >= MOST_BROKEN:
            give_up(self._findings, "P524", self._span(number), "lines new to olp")
            return True
        if len(text) <= _MOST_CHARACTERS and operators <= _MOST_OPERATORS and not _LONG_NUMBER.search(text):
            return False
        self._broken += 1
        help = f"at most {_MOST_CHARACTERS} characters, {_MOST_OPERATORS} operators and 18 digits are read"
        self._findings.error("P523", "this is longer than any controller takes", self._span(number), help)
        return True

    def _report(self, problem: _TpProblem, number: int, text: str) -> None:
        self._broken += 1
        if text.startswith("IF") and text.endswith("THEN"):
            self.markers.append(st.If(number, Number(0)))
        elif text.startswith("FOR"):
            self.markers.append(st.For(number, Variable(Store.REAL, Number(0)), Number(0), Number(0)))
        line = self._findings.source.line(number)
        head = NUMBERED.match(line)
        start = head.end() if head else 0
        start += len(line[start:]) - len(line[start:].lstrip())
        inside = line[start:].startswith(text[: max(problem.column - 1, 1)])
        span = (
            Span(number, start + problem.column, start + problem.end_column) if inside else self._span(number)
        )
        help = f"expected {problem.wanted}" if problem.wanted else ""
        self._findings.error("P520", problem.message, span, help)

    def _span(self, number: int) -> Span:
        return self._findings.whole_line(number)


# What tables of positions are made of that are written element by element: read without the grammar.
_COMPONENT: Final = re.compile(
    r"PR\[(\d{1,6}),([1-6])\]=(?:(\d{1,9}(?:\.\d{1,9})?)|\((-\d{1,9}(?:\.\d{1,9})?)\))"
)


def _set_component(register: str, place: str, value: str) -> _Template:
    """`PR[register,place]=value`."""
    target = Member(Variable(Store.ROBOT, Number(int(register))), values.ELEMENTS[int(place) - 1])
    number = Number(float(value) if "." in value else int(value))
    return ((st.Assign, values_of(st.Assign(0, target, number))),)


def _remember(text: str, template: _Template) -> None:
    if len(_seen) >= _MOST_CACHED:
        _seen.clear()
    _seen[text] = template


class _TpProblem(NamedTuple):
    """`column` (from 1) of the instruction's text and `end_column`, exclusive; `wanted` in words, may be empty."""

    message: str
    column: int
    end_column: int
    wanted: str


def _explain(problem: UnexpectedInput, text: str) -> _TpProblem:
    """The first thing that the grammar did not take, and what it would have taken."""
    column, words = column_of(problem, text), in_words(expected(problem), _WORDS)
    many = len(words) > _MOST_EXPECTED
    wanted = ", ".join([*words[:_MOST_EXPECTED], "…"]) if many else either(words)
    if column > len(text):
        return _TpProblem("the line ends too early", column, column + 1, wanted)
    word = word_at(text, column)
    # The pendant shows dots where nothing was filled in yet, and stops the program there.
    says = "this was not filled in" if word.startswith("...") else f"'{shortened(word)}' is not expected here"
    return _TpProblem(says, column, column + len(word), wanted)


# --- What moves do on their way ---
# `TB .10sec,CALL OPEN`, `DB 10mm,DO[2]=PULSE,0.5sec`, P-SPS blocks. Outputs that are switched on or off are triggers of
# their moves (`TpMoveRules.other`); a plan has no time for all else, and no other language a word.

ON_ITS_WAY: Final = frozenset({"TB", "TA", "DB"})
CONTINUES: Final = "continue"  # the arm goes on: what follows does not stop it
_DEED: Final = re.compile(r"\s*(?P<far>-?\d*\.?\d+)\s*(?P<unit>sec|mm)\s*,\s*(?P<deed>.*\S)\s*", re.DOTALL)


def with_deeds(body: tuple[st.Statement, ...]) -> tuple[st.Statement, ...]:
    """The statements with what moves do on their way behind the moves, which is told."""
    if not any(type(s) is st.Move and s.other for s in body):
        return body
    return tuple(row for s in body for row in (_spelled(s) if type(s) is st.Move and s.other else (s,)))


def _spelled(move: st.Move) -> Iterator[st.Statement]:
    found = {}
    for option in move.other:
        word, text = option
        if word in ON_ITS_WAY and isinstance(text, Text) and (deed := _deed(word, text)) is not None:
            found[option] = deed
    yield replace(move, other=tuple(one for one in move.other if one not in found)) if found else move
    for says, deeds in found.values():
        yield st.Process(move.line, CONTINUES, ((ON_THE_WAY, Text(says)),))
        yield from (replace(one, line=move.line) for one in deeds)


def _deed(word: str, option: Text) -> tuple[str, tuple[st.Statement, ...]] | None:
    """What is told of an option of a move, and what it does; None where that is not known here."""
    from lark.exceptions import UnexpectedInput

    from olp.languages.vendors.tp.grammar import instruction_parser

    match = _DEED.fullmatch(option.value)
    if match is None:
        return None
    side = "behind" if word == "TA" else "before"
    far = f"{float(match['far']):g} {'mm' if match['unit'] == 'mm' else 's'} {side} its end"
    if match["deed"] == BLOCK:  # its statements are read as standing behind the move
        return f"a P-SPS block runs behind its move, not beside it from {far} on", ()
    try:
        deeds = instruction_parser().statements(match["deed"])
    except (UnexpectedInput, BrokenLineError):
        return None
    if not all(type(one) in (st.Call, st.PulseOutput, st.SetOutput) for one in deeds):
        return None
    called = next((one.routine for one in deeds if type(one) is st.Call), "")
    if called:
        return f"{called} runs behind the move, which waits for its end, not beside it from {far} on", deeds
    return f"an output is set at the end of the move, not {far}", deeds


# --- User alarms ---

_ALARM: Final = re.compile(r"\d+")


def with_alarms(program: st.Program) -> st.Program:
    """The program with what `UALM[n]` does as its controller is delivered: it shows an alarm and stops the program."""
    if not any(isinstance(s, st.Process) and s.name == "UALM" for s in program.statements()):
        return program

    def rows(s: st.Statement) -> tuple[st.Statement, ...]:
        if not isinstance(s, st.Process) or s.name != "UALM":
            return (s,)
        shown = st.Message(s.line, Text(f"user alarm {_number_of(s)}".rstrip()), s.comment)
        return shown, st.Pause(s.line, spelling=ACKNOWLEDGED)

    routines = (replace(r, body=tuple(one for s in r.body for one in rows(s))) for r in program.routines)
    return replace(program, routines=tuple(routines))


def _number_of(s: st.Process) -> str:
    found = _ALARM.search("".join(e.value for _, e in s.arguments if isinstance(e, Text)))
    return found[0] if found else ""
