"""A whole PDL2 file: declarations, routines and the program itself, and everything that is wrong with them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final, NamedTuple

from olp.core.diagnostic import Severity
from olp.core.source import Source
from olp.ir import program as st
from olp.ir.expressions import CallValue, Expression, Item, Member, Named, Number, SignalState, Text, Unknown
from olp.ir.points import PointTable
from olp.ir.transformer import expressions_of
from olp.languages.findings import Findings
from olp.languages.short_reader import (
    Codes,
    LineParser,
    check_blocks,
    is_readable,
    unreadable,
    with_comment,
    words,
)
from olp.languages.vendors.pdl2.rules import MoveType, Pdl2Rules, Untyped, overrides_set, with_bits

_CODES: Final = Codes("P590", "P591", "P592", "P593", "P594", "P595")
_MARK = re.compile(r"^\s*PROGRAM\s+[A-Z_]\w*", re.IGNORECASE)
_NAME = r"([A-Z_]\w*)"
_PROGRAM = re.compile(rf"PROGRAM\s+{_NAME}\b.*", re.IGNORECASE)
_ROUTINE = re.compile(
    rf"ROUTINE\s+{_NAME}\s*(?:\(((?:[^()]|\([^()]*\))*)\))?\s*(?::\s*(\w+))?\s*(.*)", re.IGNORECASE
)
_VARIABLES = re.compile(r"((?:[A-Z_]\w*\s*,\s*)*[A-Z_]\w*)\s*:(?!=)\s*(.+)", re.IGNORECASE)
_CONSTANT = re.compile(rf"{_NAME}\s*=\s*(.+)", re.IGNORECASE)
_SIZED = re.compile(r"ARRAY\s*(?:\[([^\]]*)\])?\s*OF\s+(\w+).*", re.IGNORECASE)
_DEFAULT = re.compile(
    r"\w+(?:\[\d+\])?\s*\(([^()]*)\)"
)  # the value of a parameter that a caller may leave out
_END = re.compile(rf"END(?:\s+{_NAME})?", re.IGNORECASE)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:E[-+]?\d{1,2})?", re.IGNORECASE)
_KNOWN: Final = words(
    "MOVE MOVEFLY DELAY IF ELSIF ELSE ENDIF WHILE ENDWHILE FOR ENDFOR REPEAT UNTIL SELECT CASE ENDSELECT GOTO PULSE "
    "RETURN"
)
_MOVES: Final = words("MOVE MOVEFLY SEGMENT")
_TYPES: Final = {
    "INTEGER": "integer",
    "REAL": "real",
    "BOOLEAN": "boolean",
    "STRING": "string",
    "POSITION": "position",
    "XTNDPOS": "position",
    "JOINTPOS": "joints",
}
_SECTIONS: Final = words("VAR CONST TYPE BEGIN CYCLE IMPORT ENDTYPE")
_MOST_JOINED: Final = 40
_MOVE = re.compile(r"MOVE(?:FLY)?\b", re.IGNORECASE)
_CLOSED = re.compile(r"\bENDMOVE$", re.IGNORECASE)
_SETTING = re.compile(r"(?:WITH|ENDMOVE)\b|\$\w+\s*=", re.IGNORECASE)
# Moves that are legal and not modelled: along paths, about and by vectors, part of the way, of two arms at once.
_UNMODELLED = re.compile(
    r"MOVE(?:FLY)?\s+(?:ARM\s*\[[^\]]*\]\s*)?(?:JOINT\s+|LINEAR\s+|CIRCULAR\s+)?(?:ALONG|ABOUT|BY|FOR)\b"
    r"|MOVE(?:FLY)?\b.*\bSYNCMOVE(?:FLY)?\b",
    re.IGNORECASE,
)


class Pdl2Line(NamedTuple):
    """An instruction. `taken`: source lines that it takes."""

    number: int
    text: str
    comment: str | None
    taken: int = 1


class _Part:
    """A routine, or the program itself, while it is read."""

    def __init__(
        self, name: str, line: int, parameters: tuple[st.Parameter, ...] = (), returns: str = ""
    ) -> None:
        self.name, self.line, self.parameters, self.returns = name, line, parameters, returns
        self.body: list[st.Statement] = []
        self.data: list[st.Declare] = []
        self.cycle = 0  # line of CYCLE
        self.last = line


def read_program(source: Source) -> st.Program:
    """The program in a text. Never raises on bad text."""
    findings = Findings(source)
    if not is_readable(findings, _CODES, _MARK, "PDL2"):
        return unreadable("pdl2", source, findings)
    return _Pdl2File(findings).read()


class _Pdl2File:
    def __init__(self, findings: Findings) -> None:
        self.findings, self.kinds = findings, findings.kinds
        self.rules = Pdl2Rules(
            any("$FLY_DIST" in line.upper() for line in findings.source.lines),
            overrides_set(findings.source.lines),
        )
        self.parser = LineParser(findings, "pdl2", self.rules, _CODES, _KNOWN, _MOVES)
        self.parts: list[_Part] = []
        self.part: _Part | None = None  # the routine that is open
        self.program: _Part | None = None
        self.section = ""
        self.path = st.Path.JOINT
        self.handler = False
        self.outside: list[st.Statement] = []  # comments before the program

    def read(self) -> st.Program:
        for line in self._lines():
            for more in range(line.taken):
                self.kinds[line.number - 1 + more] = st.LineKind.STATEMENT
            part = self.part or self.program
            held = (0, 0) if part is None else (len(part.body), len(part.data))
            self._line(line)
            if line.comment:
                now = self.part or self.program
                is_head = now is not None and now.line == line.number
                self._keep_comment(
                    line.number, line.comment, now if is_head else part, None if is_head else held
                )
        for one in (self.part, self.program):
            if one is not None:
                span = self.findings.whole_line(one.line)
                self.findings.error("P593", f"{one.name} is never closed", span, f"add END {one.name}")
                self._close(one, len(self.kinds))
        routines = tuple(self._routine(one) for one in self.parts)
        main = next((one.name for one in self.parts if one.returns == "PROGRAM"), "")
        data = tuple(d for one in self.parts if one.returns == "PROGRAM" for d in one.data)
        kinds = bytes(self.kinds)
        routines = tuple(_of_first_arm(routines, data))
        return st.Program("pdl2", self.findings.source, routines, self.findings.result(), kinds, data, main)

    def _keep_comment(
        self, number: int, comment: str, part: _Part | None = None, held: tuple[int, int] | None = None
    ) -> None:
        """With what its line says; else, as behind a head or an end, by itself in the routine.

        `part`, `held`: the routine before the line, and how many statements and data it had.
        """
        part = part or self.part or self.program or (self.parts[-1] if self.parts else None)
        if part is None:
            self.outside.append(st.Comment(number, comment))
        elif held is not None and len(part.body) > held[0]:
            part.body[-1] = with_comment(part.body[-1], comment)
        elif held is not None and len(part.data) > held[1]:
            part.data[-1] = with_comment(part.data[-1], comment)
        else:
            part.body.append(st.Comment(number, comment))

    # --- lines ------------------------------------------------------------------------------------------

    def _lines(self) -> Iterator[Pdl2Line]:
        """Instructions, a MOVE with its WITH lines as one."""
        lines, number = list(map(_parted, self.findings.source.lines)), 1
        while number <= len(lines):
            text, comment = lines[number - 1]
            if not text.strip():
                self.kinds[number - 1] = st.LineKind.BLANK if comment is None else st.LineKind.COMMENT
                if comment is not None:
                    self._keep_comment(number, comment)
                number += 1
                continue
            count = 1
            while number + count <= len(lines) and count < _MOST_JOINED:
                more, _ = lines[number + count - 1]
                if not _goes_on(text, more):
                    break
                text = f"{text.removesuffix('&').rstrip()} {more}"
                count += 1
            yield Pdl2Line(number, text, comment, count)
            number += count

    def _line(self, line: Pdl2Line) -> None:
        text, number = line.text, line.number
        word = next(iter(text.split(None, 1)), "").upper()  # nothing but & is left of a line that goes on
        if self.handler or word.startswith("CONDITION["):
            self._handler(line, word)
        elif word == "PROGRAM" and (head := _PROGRAM.fullmatch(text)) and self.program is None:
            self.kinds[number - 1] = st.LineKind.RECORD
            self.program, self.section = _Part(self.rules.spelled(head[1]), number, (), "PROGRAM"), "VAR"
            self.program.body, self.outside = self.outside, []
        elif word == "ROUTINE" and (head := _ROUTINE.fullmatch(text)):
            self._head(head, number)
        elif word in _SECTIONS:
            self._section(word, text, number)
        elif word == "END" and (end := _END.fullmatch(text)):
            self._end(end, number)
        elif self.section in ("VAR", "CONST", "TYPE", "IMPORT"):
            self._declaration(text, number)
        else:
            self._instruction(text, number)

    def _handler(self, line: Pdl2Line, word: str) -> None:
        """A condition handler runs beside the program: kept, told once."""
        part = self.part or self.program
        self.handler = word != "ENDCONDITION"
        for number in range(line.number, line.number + line.taken):
            opaque = self.parser.opaque(self.findings.source.line(number).strip(), number)
            if part is not None:
                part.body.append(opaque)

    def _head(self, head: re.Match[str], number: int) -> None:
        self.kinds[number - 1] = st.LineKind.RECORD
        if "EXPORTED" in head[4].upper() or "EXTERNAL" in head[4].upper():
            return
        if self.part is not None:
            self._close(self.part, number)
        parameters = tuple(_parameters(head[2] or "", self.rules))
        self.part = _Part(
            self.rules.spelled(head[1]), number, parameters, _TYPES.get((head[3] or "").upper(), "")
        )
        self.section = "VAR"

    def _section(self, word: str, text: str, number: int) -> None:
        self.section = "VAR" if word == "ENDTYPE" else word
        rest = text[len(word) :].strip()
        part = self.part or self.program
        if word == "IMPORT":
            self.kinds[number - 1], self.section = st.LineKind.RECORD, "VAR"
        elif part is not None and (word == "CYCLE" or (word == "BEGIN" and rest.upper() == "CYCLE")):
            part.body.append(st.While(number, SignalState(True)))
            part.cycle = number
        elif rest:
            self._declaration(rest, number)

    def _end(self, end: re.Match[str], number: int) -> None:
        self.kinds[number - 1] = st.LineKind.RECORD
        part = self.part or self.program
        if part is None:
            span = self.findings.whole_line(number)
            self.findings.error("P593", "END without a program", span, "remove it, or open a routine above")
            return
        if end[1] and end[1].casefold() != part.name.casefold():
            message = f"END {end[1][:40]} closes {part.name}"
            self.findings.warning("P593", message, self.findings.whole_line(number), f"write END {part.name}")
        self._close(part, number)

    def _close(self, part: _Part, number: int) -> None:
        if part.cycle:
            part.body.append(st.EndWhile(number))
        part.last = number
        integers = {one.name.casefold() for one in part.parameters if one.type == "integer"}
        for data in {id(self.program): self.program, id(part): part}.values():
            integers |= {one.name.casefold() for one in (data.data if data else ()) if one.type == "integer"}
        part.body = with_bits(part.body, integers)
        self.parts.append(part)
        if part is self.part:
            self.part = None
            self.section = "VAR"
        else:
            self.program = None

    # --- declarations -----------------------------------------------------------------------------------

    def _declaration(self, text: str, number: int) -> None:
        part = self.part or self.program
        match = _VARIABLES.fullmatch(text)
        constant = _CONSTANT.fullmatch(text) if match is None else None
        if part is None or self.section == "TYPE" or (match is None and constant is None):
            self.parser.opaque(text, number)
            return
        if constant is not None:
            value = _literal(constant[2].strip())
            if value is None:
                self.parser.opaque(text, number)
                return
            name = self.rules.spelled(constant[1])
            part.data.append(st.Declare(number, name, _type_of(value), value, storage="constant"))
            return
        assert match is not None
        native = match[2].strip()
        sized = _SIZED.fullmatch(native)
        type_ = (sized[2] if sized else re.split(r"\W", native, maxsplit=1)[0]).upper()
        sizes = tuple(Number(int(one)) for one in re.findall(r"\d{1,6}", sized[1] or "")) if sized else ()
        for one in match[1].split(","):
            name = self.rules.spelled(one.strip())
            part.data.append(
                st.Declare(number, name, _TYPES.get(type_, type_.lower()), None, sizes, native=native)
            )

    # --- instructions -----------------------------------------------------------------------------------

    def _instruction(self, text: str, number: int) -> None:
        part = self.part or self.program
        if part is None:
            span = self.findings.whole_line(number)
            self.findings.error("P593", "an instruction outside of a program", span, "PROGRAM name above it")
            return
        unmodelled = _UNMODELLED.match(text) is not None
        for one in [self.parser.opaque(text, number)] if unmodelled else self.parser.parse(text, number):
            part.body.extend(self._placed(one, number))

    def _placed(self, one: Any, number: int) -> list[st.Statement]:
        """Statements with what $MOVE_TYPE said of moves that name no path."""
        if isinstance(one, MoveType):
            self.path = one.path
            self.kinds[number - 1] = st.LineKind.RECORD
            return []
        if isinstance(one, Untyped):
            move: st.Move = replace(one.move, line=number)
            if self.path is st.Path.JOINT:
                return [move]
            return [replace(move, path=st.Path.LINEAR, speed=None)]
        if isinstance(one, st.Opaque) and one.text.startswith("$"):
            self.kinds[number - 1] = st.LineKind.OPAQUE
        return [one]

    def _routine(self, part: _Part) -> st.Routine:
        check_blocks(self.findings, part.body, "P593")
        own = part.returns != "PROGRAM"
        body = (*part.data, *part.body) if own else tuple(part.body)
        returns = part.returns if own else ""
        if any(isinstance(one, st.Opaque) and one.text.upper().startswith("CONDITION[") for one in part.body):
            message = "condition handlers run beside the program: they are left out of the plan"
            span = self.findings.whole_line(part.line)
            self.findings.once(Severity.INFO, "P596", "", message, span, "add their time as a wait")
        return st.Routine(
            part.name,
            part.line,
            body,
            PointTable(),
            parameters=_changed(part.parameters, body),
            returns=returns,
            last_line=part.last,
        )


def _of_first_arm(routines: tuple[st.Routine, ...], data: tuple[st.Declare, ...]) -> Iterator[st.Routine]:
    """`MOVE ARM[n]` is a plain move where n is a name that holds 1 wherever the text gives it a value."""
    values: dict[str, set[Expression | None]] = {}
    for one in (*data, *(s for routine in routines for s in routine.body)):
        if isinstance(one, st.Declare) and one.value is not None:
            values.setdefault(one.name, set()).add(one.value)
        elif isinstance(one, (st.Assign, st.ReadInput)) and isinstance(one.target, Named):
            values.setdefault(one.target.name, set()).add(one.value if isinstance(one, st.Assign) else None)
        elif isinstance(one, st.For) and isinstance(one.variable, Named):
            values.setdefault(one.variable.name, set()).add(None)
    plain = {("arm", Named(name)) for name, held in values.items() if held == {Number(1)}}
    plain -= {("arm", Named(one.name)) for routine in routines for one in routine.parameters}
    for routine in routines:
        body = tuple(
            replace(s, other=tuple(o for o in s.other if o not in plain)) if isinstance(s, st.Move) else s
            for s in routine.body
        )
        yield replace(routine, body=body)


def _goes_on(text: str, more: str) -> bool:
    """Whether the next line belongs to the instruction: behind a trailing &, or to the WITH and ENDMOVE of a move."""
    if text.endswith("&"):
        return True
    if not _MOVE.match(text) or _CLOSED.search(text):
        return False
    return text.endswith(",") or _SETTING.match(more) is not None


def _parted(text: str) -> tuple[str, str | None]:
    """The instruction without a ; at its end, and its comment; dashes in a text are part of the text."""
    text = text.strip(" \t\r\f\x1a")
    if "--" not in text:
        return text.rstrip(" \t;"), None
    quoted = False
    for at, char in enumerate(text):
        if char == "'":
            quoted = not quoted
        elif char == "-" and not quoted and text.startswith("--", at):
            return text[:at].rstrip(" \t;"), text[at + 2 :]
    return text.rstrip(" \t;"), None


def _literal(text: str) -> Expression | None:
    if text.upper() in ("TRUE", "ON", "FALSE", "OFF"):
        return SignalState(text.upper() in ("TRUE", "ON"))
    if len(text) > 1 and text[0] == text[-1] == "'":
        return Text(text[1:-1])
    if _NUMBER.fullmatch(text) and len(text) < 40:
        return Number(int(text)) if text.lstrip("+-").isdigit() else Number(float(text))
    return None


def _type_of(value: Expression) -> str:
    if isinstance(value, Number):
        return "integer" if isinstance(value.value, int) else "real"
    return "string" if isinstance(value, Text) else "boolean"


def _changed(parameters: tuple[st.Parameter, ...], body: Sequence[st.Statement]) -> tuple[st.Parameter, ...]:
    """Parameters, by reference those that the routine sets or hands on.

    A variable is handed over by reference, a constant, an expression or a variable in brackets by value (from memory
    of the PDL2 Programming Language Manual, Passing Arguments; no page at hand).
    """
    changed: set[str] = set()
    for s in body:
        places: list[Expression | None] = []
        if isinstance(s, (st.Assign, st.Update, st.Clear, st.ReadInput)):
            places.append(s.target)
        elif isinstance(s, st.For):
            places.append(s.variable)
        elif isinstance(s, st.Call):
            places += s.arguments
        places += [a for e in expressions_of(s) if isinstance(e, CallValue) for a in e.arguments]
        for place in places:
            while isinstance(place, (Item, Member)):
                place = place.base
            if isinstance(place, Named):
                changed.add(place.name.casefold())
    return tuple(
        replace(one, by_reference=one.by_reference or (not one.optional and one.name.casefold() in changed))
        for one in parameters
    )


def _parameters(text: str, rules: Pdl2Rules) -> Iterator[st.Parameter]:
    for group in text.split(";"):
        names, _, type_ = group.partition(":")
        changed = re.match(r"\s*VAR\s+", names, re.IGNORECASE)
        sized = _SIZED.fullmatch(type_.strip())
        word = (sized[2] if sized else re.split(r"\W", type_.strip(), maxsplit=1)[0]).upper()
        given = None if sized else _DEFAULT.fullmatch(type_.strip())
        default = None if given is None else _literal(given[1].strip())
        for name in names[changed.end() if changed else 0 :].split(","):
            if name.strip():
                yield st.Parameter(
                    rules.spelled(name.strip()),
                    _TYPES.get(word, ""),
                    by_reference=bool(changed or sized),
                    optional=default is not None,
                    default=default,
                    native="[]" if sized else "",
                    sizes=(Unknown(""),) * ((sized[1] or "").count(",") + 1) if sized else (),
                )
