"""A whole AS file: its programs as routines, its tables as data, and everything that is wrong with it."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

from olp.core.diagnostic import Severity, Span
from olp.core.memory_limit import shelf
from olp.core.source import Source
from olp.core.units import mm
from olp.ir.expressions import (
    Binary,
    Expression,
    Function,
    Item,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    Text,
    Unary,
)
from olp.ir.points import PointTable
from olp.ir.program import (
    Assign,
    Blend,
    BlendKind,
    Call,
    Comment,
    Declare,
    EndIf,
    EndSwitch,
    EndWhile,
    For,
    If,
    Label,
    LineKind,
    Move,
    Next,
    Parameter,
    Path,
    Program,
    Repeat,
    Routine,
    SetBlend,
    SpeedUnit,
    StartTask,
    Statement,
    Switch,
    Until,
    While,
)
from olp.languages.findings import Findings
from olp.languages.lark_host import changed
from olp.languages.short_reader import (
    Codes,
    LineParser,
    array,
    check_blocks,
    is_readable,
    joints,
    unreadable,
    with_comment,
    words,
    zyz_pose,
)

from .rules import Arc, AsRules, BlockEnd, NextMoveFields, PercentOfPath

_CODES: Final = Codes("P580", "P581", "P582", "P583", "P584", "P585")
_MARK = re.compile(
    r"^\s*\.(?:PROGRAM|TRANS|JOINTS|REALS|STRINGS|INTEGER|AUXDATA|SYSDATA|ROBOTDATA\d|NETCONF\d?|\w+_INFO\d?)\b",
    re.IGNORECASE,
)
_HEAD = re.compile(r"\s*\.PROGRAM\s+([A-Z_][\w.]*)\s*(?:\(([^)]*)\))?", re.IGNORECASE)
_LABEL = re.compile(r"(\d+)(?:\s*:|\s+|$)\s*|([A-Z_][\w.]*)\s*:(?!=)\s*", re.IGNORECASE)
_ROW = re.compile(r"([#$]?[A-Z_][\w.]*)\s*(?:\[([\d,\s]+)\])?\s*=?\s*(.*)", re.IGNORECASE)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:E[-+]?\d+)?", re.IGNORECASE)
_TABLES: Final = (".TRANS", ".JOINTS", ".REALS", ".STRINGS", ".INTEGER")
_KNOWN: Final = words(
    "JMOVE LMOVE HMOVE C1MOVE C2MOVE XMOVE LAPPRO JAPPRO LDEPART JDEPART DRAW TDRAW TWAIT STABLE DELAY BREAK CALL GOTO "
    "IF ELSE ELSEIF END WHILE DO UNTIL FOR CASE SCASE VALUE SVALUE ANY RETURN SIGNAL SWAIT WAIT POINT TOOL BASE"
)
_MOVES: Final = words("C1MOVE DRAW TDRAW DRIVE ALIGN JOINT LINEAR LIN2 CIR1 CIR2")
_UNTAUGHT: Final = PositionLiteral("pose", (float("nan"),) * 6)
_MOST_ELEMENTS: Final = 5000  # per index of an array
_MOST_ROOM: Final = 500_000  # elements of all arrays together
_SIZES: Final = {1: 1000, 2: 100}  # of an array that only the program fills, by its number of indices


def read_program(source: Source) -> Program:
    """The programs and the data of a file. Never raises on bad text."""
    findings = Findings(source)
    if not is_readable(findings, _CODES, _MARK, "AS"):
        return unreadable("as", source, findings)
    return _AsFile(findings).read()


class _AsFile:
    def __init__(self, findings: Findings) -> None:
        self.findings, self.kinds = findings, findings.kinds
        self.rules = AsRules()
        self.parser = LineParser(findings, "as", self.rules, _CODES, _KNOWN, _MOVES)
        self.data: dict[str, Declare] = {}
        self.room = _MOST_ROOM
        self.elements: dict[str, dict[tuple[int, ...], Expression]] = {}
        self._values = shelf("as rows")

    def read(self) -> Program:
        source = self.findings.source
        lines, number = source.lines, 1
        routines: list[Routine] = []
        while number <= len(lines):
            text = lines[number - 1].strip()
            head = _HEAD.match(text)
            word = text.split(None, 1)[0].upper() if text else ""
            if head:
                routine, number = self._routine(head, number)
                routines.append(routine)
            elif word in _TABLES:
                number = self._table(word, number)
            else:
                self.kinds[number - 1] = LineKind.RECORD if text else LineKind.BLANK
                number += 1
        self._close_arrays()
        routines = [self._with_arrays(one) for one in routines]
        main = _main(routines)
        if main:
            at = next(i for i, one in enumerate(routines) if one.name == main)
            routines[at] = self._with_defaults(routines[at])
        return Program(
            "as",
            source,
            tuple(routines),
            self.findings.result(),
            bytes(self.kinds),
            tuple(self.data.values()),
            main,
        )

    # --- tables -----------------------------------------------------------------------------------------

    def _table(self, word: str, number: int) -> int:
        """The rows of .TRANS, .JOINTS, .REALS or .STRINGS; the number of the line behind it."""
        lines = self.findings.source.lines
        self.kinds[number - 1] = LineKind.RECORD
        number += 1
        while number <= len(lines):
            text = lines[number - 1].strip()
            if text.upper().startswith(".END"):
                self.kinds[number - 1] = LineKind.RECORD
                return number + 1
            if text.startswith(".") and not text.startswith(".*"):
                break
            self.kinds[number - 1] = LineKind.POINT if text else LineKind.BLANK
            if text and not text.startswith((".*", ";")):
                self._row(word, text, number)
            number += 1
        span = self.findings.whole_line(number - 1)
        self.findings.warning("P583", f"{word} is never closed", span, "add .END behind its last row")
        return number

    def _row(self, word: str, text: str, number: int) -> None:
        match = _ROW.fullmatch(text)
        value = None if match is None else self._value(word, match[3])
        if match is None or value is None:
            wanted = "a name and its values, as in p1 450.5 -10 300 0 180 45"
            self.findings.error("P586", "this is no row of a table", self.findings.whole_line(number), wanted)
            return
        name, type_ = self.rules.spelled(match[1]), _TYPES[word]
        if match[2] is None:
            self.data[name.casefold()] = Declare(number, name, type_, value, shared=True)
            return
        index = tuple(int(part) for part in match[2].split(",") if part.strip())
        if not index or max(index) > _MOST_ELEMENTS:
            wanted = f"indices from 0 to {_MOST_ELEMENTS}"
            self.findings.error("P586", "an index out of range", self.findings.whole_line(number), wanted)
            return
        self.elements.setdefault(name, {})[index] = value

    def _value(self, word: str, text: str) -> Expression | None:
        """What the columns of a row say; where somebody remembers, worked out once."""
        found: Expression | None = None if self._values is None else self._values.get((word, text))
        if found is None:
            found = _value(word, text)
            if self._values is not None and found is not None:
                self._values.put((word, text), found)
        return found

    def _close_arrays(self) -> None:
        for name, elements in self.elements.items():
            widths = Counter(map(len, elements))
            width = widths.most_common(1)[0][0]
            kept = {index: value for index, value in elements.items() if len(index) == width}
            first = next(iter(kept.values()))
            type_, missing = _gap(first)
            sizes = tuple(Number(max(index[at] for index in kept) + 1) for at in range(width))
            if not self._takes(sizes):
                message, help = (
                    f"{name} makes the arrays too large",
                    f"at most {_MOST_ROOM:,} elements in all",
                )
                self.findings.once(Severity.ERROR, "P586", "room", message, Span(0), help)
                continue
            self.data[name.casefold()] = Declare(
                0, name, type_, array(type_, kept, missing), sizes, shared=True
            )

    def _takes(self, sizes: tuple[Number, ...]) -> bool:
        """Whether there is room for one more array of these sizes."""
        self.room -= math.prod(int(size.value) for size in sizes)
        return self.room >= 0

    # --- programs ---------------------------------------------------------------------------------------

    def _routine(self, head: re.Match[str], number: int) -> tuple[Routine, int]:
        lines, start = self.findings.source.lines, number
        self.kinds[number - 1] = LineKind.RECORD
        body = _AsBody(self.findings, self.parser)
        number += 1
        closed = False
        while number <= len(lines) and not closed:
            text = lines[number - 1].strip()
            if text.upper().startswith(".END"):
                self.kinds[number - 1], closed = LineKind.RECORD, True
            elif text.startswith(".") and (_HEAD.match(text) or text.upper().startswith(_TABLES)):
                break
            else:
                body.line(text, number)
            number += 1
        if not closed:
            span = self.findings.whole_line(start)
            self.findings.error(
                "P583", "the program is never closed", span, "add .END behind its last instruction"
            )
        statements = body.finish()
        check_blocks(self.findings, statements, "P583")
        parameters = tuple(_parameters(head[2] or "", self.rules))
        name = self.rules.spelled(head[1])
        routine = Routine(
            name, start, tuple(statements), PointTable(), parameters=parameters, last_line=number - 1
        )
        return routine, number

    def _with_arrays(self, routine: Routine) -> Routine:
        """Variables come into being when they are given a value: those of the program (.name) here, others for all."""
        own: dict[str, Declare] = {}
        given = {p.name.casefold() for p in routine.parameters}
        for one in routine.body:
            target = one.target if isinstance(one, Assign) else one.variable if isinstance(one, For) else None
            base = target.base if isinstance(target, Item) else target
            if not isinstance(base, Named) or base.name.casefold() in given:
                continue
            count = len(target.indices) if isinstance(target, Item) else 0
            sizes = (Number(_SIZES.get(count, 20)),) * count
            if base.name.casefold() not in self.data.keys() | own.keys() and not self._takes(sizes):
                sizes = (Number(1),) * count
            local = "." in base.name[:2]
            place = own if local else self.data
            type_ = self._type(one.value) if isinstance(one, Assign) else "integer"
            if base.name.startswith("$"):
                type_ = "string"
            line = routine.line if local else 0
            place.setdefault(base.name.casefold(), Declare(line, base.name, type_, None, sizes))
        return replace(routine, body=(*own.values(), *routine.body)) if own else routine

    def _type(self, value: Expression) -> str:
        """Of a variable that gets this value."""
        base = value.base if isinstance(value, Item) else value
        if isinstance(base, Named):
            known = self.data.get(base.name.casefold())
            return known.type if known else "variable"
        if isinstance(value, PositionLiteral):
            return "position" if value.kind == "pose" else "joints"
        if isinstance(value, Function) and value.name.startswith(("pose-", "forward")):
            return "position"
        return "real" if isinstance(value, (Number, Binary, Unary)) else "variable"

    def _with_defaults(self, routine: Routine) -> Routine:
        """What a controller holds before any instruction: corners of 1 mm."""
        first = SetBlend(routine.line, (Blend(BlendKind.RADIUS, Quantity(Number(1), mm)),))
        return replace(routine, body=(first, *routine.body))


class _AsBody:
    """The instructions of one program, with what the next move takes and which block is open."""

    def __init__(self, findings: Findings, parser: LineParser) -> None:
        self.findings, self.parser, self.kinds = findings, parser, findings.kinds
        self.body: list[Statement] = []
        self.open: list[type] = []
        self.next: dict[str, Any] = {}
        self.via: tuple[Expression, int] | None = None

    def line(self, text: str, number: int) -> None:
        code, comment = _parted(text)
        if not code:
            self.kinds[number - 1] = LineKind.COMMENT if comment is not None else LineKind.BLANK
            if comment is not None:
                self.body.append(Comment(number, comment))
            return
        self.kinds[number - 1] = LineKind.STATEMENT
        label = _LABEL.match(code)
        if label and not re.match(r"ANY\s*:", code, re.IGNORECASE):
            self.body.append(Label(number, (label[1] or label[2]).casefold()))
            code = code[label.end() :]
            if not code:
                return
        before = len(self.body)
        for one in self.parser.parse(code, number):
            self._add(one, number)
        if comment and len(self.body) > before:
            self.body[-1] = with_comment(self.body[-1], comment)

    def _add(self, one: Any, number: int) -> None:
        if isinstance(one, NextMoveFields):
            self.next.update(one.fields)
        elif isinstance(one, PercentOfPath):
            self._tell_percent(number)
        elif isinstance(one, Arc):
            self._arc(one, number)
        elif isinstance(one, BlockEnd):
            self._end(number)
        elif isinstance(one, Move):
            self.body.append(self._taken(one))
        else:
            self._block(one)
            self.body.append(one)

    def _taken(self, move: Move) -> Move:
        """The move with what SPEED, ACCURACY and ACCEL before it said."""
        fields, self.next = self.next, {}
        speeds = fields.pop("speeds", ())
        wanted = SpeedUnit.FRACTION if move.path is Path.JOINT else SpeedUnit.TRAVEL
        speed = next((s for s in speeds if s.unit in (wanted, SpeedUnit.TIME)), None)
        if speed is not None and speed.native:
            self._tell_percent(move.line)
        return changed(move, speed=speed, **fields)  # type: ignore[no-any-return]

    def _arc(self, arc: Arc, number: int) -> None:
        span = self.findings.whole_line(number)
        if not arc.end:
            if self.via is not None:  # a chain of arcs: only the last two points make one here
                one = self.via[1]
                self.body.append(self.parser.opaque(self.findings.source.line(one).strip(), one))
            self.via = (arc.target, number)
        elif self.via is None:
            self.findings.error(
                "P587", "C2MOVE without C1MOVE", span, "C1MOVE with the point on the arc before it"
            )
        else:
            via, self.via = self.via[0], None
            blend = Blend(BlendKind.RADIUS)
            self.body.append(self._taken(Move(number, Path.CIRCULAR, (arc.target,), blend=blend, via=via)))

    def _block(self, one: Statement) -> None:
        if isinstance(one, (If, While, For, Switch, Repeat)):
            self.open.append(type(one))
        elif isinstance(one, Until) and self.open[-1:] == [Repeat]:
            self.open.pop()

    def _end(self, number: int) -> None:
        """END closes the innermost block, whatever it is."""
        if not self.open or self.open[-1] is Repeat:
            span = self.findings.whole_line(number)
            self.findings.warning("P583", "END without a block", span, "remove it, or open a block above")
            return
        opener = self.open.pop()
        if opener is For:
            self.body.append(Next(number, None))
        elif opener is If:
            self.body.append(EndIf(number))
        else:
            self.body.append(EndWhile(number) if opener is While else EndSwitch(number))

    def _tell_percent(self, number: int) -> None:
        message = "100 % of a path is taken as 1 m/s: no program says what its controller's full speed is"
        help = "write the speed of paths in MM/S, that of joint moves in percent"
        self.findings.once(Severity.INFO, "P588", "", message, self.findings.whole_line(number), help)

    def finish(self) -> list[Statement]:
        if self.via is not None:
            span = self.findings.whole_line(self.via[1])
            self.findings.error("P587", "C1MOVE without C2MOVE", span, "C2MOVE with the arc's end behind it")
        return self.body


_TYPES: Final = {
    ".TRANS": "position",
    ".JOINTS": "joints",
    ".REALS": "real",
    ".INTEGER": "integer",
    ".STRINGS": "string",
}


def _gap(element: Expression) -> tuple[str, Expression]:
    """The type of an array by one of its elements, and what stands where none was given."""
    if isinstance(element, PositionLiteral):
        return ("position", _UNTAUGHT) if element.kind == "pose" else ("joints", _UNTAUGHT)
    return ("string", Text("")) if isinstance(element, Text) else ("real", Number(0))


def _value(word: str, text: str) -> Expression | None:
    if word == ".STRINGS":
        return Text(text.strip().strip('"'))
    words = text.split(";")[0].replace(",", " ").split()
    if not words or not all(_NUMBER.fullmatch(one) for one in words) or any(len(one) > 40 for one in words):
        return None
    numbers = [float(one) for one in words]
    if not all(map(math.isfinite, numbers)):
        return None
    if word == ".TRANS":
        return zyz_pose(numbers[:6]) if len(numbers) >= 6 else None
    if word == ".JOINTS":
        return joints(numbers) if len(numbers) >= 3 else None
    return (
        Number(int(numbers[0]) if words[0].lstrip("+-").isdigit() else numbers[0])
        if len(words) == 1
        else None
    )


def _parted(text: str) -> tuple[str, str | None]:
    """The instruction and its comment; a semicolon in a text is part of the text."""
    if ";" not in text:
        return text, None
    at, quoted = 0, False
    for at, char in enumerate(text):
        if char == '"':
            quoted = not quoted
        elif char == ";" and not quoted:
            return text[:at].rstrip(), text[at + 1 :]
    return text, None


def _parameters(text: str, rules: AsRules) -> Iterator[Parameter]:
    for part in text.split(","):
        name = re.sub(r"\[.*", "", part).replace("&", "").replace("]", "").strip()
        if name:
            yield Parameter(rules.spelled(name), by_reference=True)


def _main(routines: list[Routine]) -> str:
    """The first program that no other one calls: a file does not say which of its programs runs."""
    called = {
        one.routine.casefold()
        for routine in routines
        for one in routine.body
        if isinstance(one, (Call, StartTask))
    }
    free = [one.name for one in routines if one.name.casefold() not in called]
    return (free or [one.name for one in routines] or [""])[0]
