"""A whole VAL3 file: a program, data or a project; and everything that is wrong with it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import unescape
from typing import Any, Final

from olp.core.diagnostic import Severity
from olp.core.source import Source
from olp.ir.expressions import Expression, Number
from olp.ir.points import PointTable
from olp.ir.program import (
    Break,
    Comment,
    Declare,
    EndSwitch,
    EndWhile,
    For,
    LineKind,
    Move,
    Next,
    Parameter,
    Program,
    Repeat,
    Routine,
    Statement,
    Switch,
    Until,
    While,
)
from olp.languages.findings import Findings
from olp.languages.short_reader import (
    Codes,
    LineParser,
    check_blocks,
    is_readable,
    unreadable,
    with_comment,
    words,
    xyz_pose,
)
from olp.languages.vendors.val3.data import (
    JOINTS,
    POSES,
    Val3Declarations,
    XmlTag,
    beside,
    declarations,
    read_data,
    tags,
)
from olp.languages.vendors.val3.rules import Leave, Val3Rules

_CODES: Final = Codes("P570", "P571", "P572", "P573", "P574", "P575")
_MARK = re.compile(r"<(?:Programs|programList|Database|dataList|Project)\b", re.IGNORECASE)
_DATA = re.compile(r"<(?:Database|dataList)\b", re.IGNORECASE)
_PROJECT = re.compile(r"<Project\b", re.IGNORECASE)
_OPEN = re.compile(r"<(?:Code|code)\b[^<>]*>\s*(<!\[CDATA\[)?")
_CLOSE = re.compile(r"(?:\]\]>\s*)?</(?:Code|code)>|\]\]>")
_KNOWN: Final = words(
    "IF ELSEIF ELSE ENDIF WHILE ENDWHILE FOR ENDFOR DO UNTIL SWITCH CASE DEFAULT ENDSWITCH BREAK MOVEJ MOVEL MOVEC CALL"
)
_MOVES: Final = words("MOVEJ MOVEL MOVEC MOVEJF ALTER ALTERMOVEJ ALTERMOVEL ALTERMOVEC")
_TYPES: Final = {"num": "real", "bool": "boolean", "string": "string"}


def read_program(source: Source) -> Program:
    """What is in a file. Never raises on bad text."""
    findings = Findings(source)
    if not is_readable(findings, _CODES, _MARK, "VAL3"):
        return unreadable("val3", source, findings)
    for number, line in enumerate(source.lines):
        findings.kinds[number] = LineKind.RECORD if line.strip() else LineKind.BLANK
    if any(_DATA.search(line) for line in source.lines[:50]):
        data = read_data(source)
        for one in data:
            findings.kinds[one.line - 1] = LineKind.POINT
        return Program(
            "val3", source, (), findings.result(), bytes(findings.kinds), tuple(declarations(data))
        )
    routines = _Val3File(findings).read()
    return Program("val3", source, tuple(routines), findings.result(), bytes(findings.kinds))


class _Val3File:
    def __init__(self, findings: Findings) -> None:
        self.findings, self.kinds = findings, findings.kinds
        self.known = beside(findings.source.path)
        self.tags: dict[int, list[XmlTag]] = {}
        for tag in tags(findings.source):
            self.tags.setdefault(tag.line, []).append(tag)

    def read(self) -> list[Routine]:
        routines: list[Routine] = []
        lines, number = self.findings.source.lines, 1
        head: list[XmlTag] = []
        while number <= len(lines):
            line = lines[number - 1]
            opened = _OPEN.search(line)
            head += [tag for tag in self.tags.get(number, ()) if not tag.closes]
            if opened is None:
                number += 1
                continue
            body = _Val3Body(self.findings, self._names(head))
            stop = self._code(body, opened, number)
            routines.append(self._routine(head, body, stop))
            head, number = [], stop + 1
        programs = [tag for found in self.tags.values() for tag in found if tag.name.lower() == "program"]
        if not routines and programs and not any(_PROJECT.search(line) for line in lines[:20]):
            self._tell_unclosed(programs[0].line, "a program without <Code>")
        return routines

    def _names(self, head: list[XmlTag]) -> Val3Declarations:
        """What holds in one program: its parameters and local variables hide the data of the same name."""
        known = Val3Declarations(dict(self.known.types), set(self.known.arrays), dict(self.known.fathers))
        for tag in _variables(head):
            name = tag.attributes["name"]
            known.types[name] = tag.attributes.get("type", "")
            known.fathers.pop(name, None)
            known.arrays.discard(name)
            if _size(tag) > 1 or (
                tag.name.lower() == "parameter" and tag.attributes.get("xsi:type") == "array"
            ):
                known.arrays.add(name)
        return known

    def _code(self, body: _Val3Body, opened: re.Match[str], number: int) -> int:
        """Reads the lines of the code; the number of the last one."""
        lines, start = self.findings.source.lines, number
        plain = opened[1] is not None
        text = lines[number - 1][opened.end() :]
        while True:
            closed = _CLOSE.search(text)
            code = text[: closed.start()] if closed else text
            if code.strip():
                body.line((code if plain else unescape(code)).strip(), number)
            elif not closed and number > start:
                self.kinds[number - 1] = LineKind.BLANK
            if closed:
                return number
            if number >= len(lines):
                self._tell_unclosed(start, "the code is never closed")
                return number
            number += 1
            text = lines[number - 1]

    def _tell_unclosed(self, number: int, message: str) -> None:
        span = self.findings.whole_line(number)
        self.findings.error("P573", message, span, "<Code><![CDATA[begin … end]]></Code>")

    def _routine(self, head: list[XmlTag], body: _Val3Body, last: int) -> Routine:
        program = next((tag for tag in reversed(head) if tag.name.lower() == "program"), None)
        name = program.attributes.get("name", "") if program else ""
        statements = body.finish()
        check_blocks(self.findings, statements, "P573")
        parameters, local = [], []
        for tag in _variables(head):
            if tag.name.lower() == "parameter":
                by_reference = tag.attributes.get("use", "") == "reference"
                type_ = _TYPES.get(tag.attributes.get("type", ""), "")
                parameters.append(Parameter(tag.attributes["name"], type_, by_reference=by_reference))
            else:
                local.append(_declared(tag))
        line = program.line if program else 1
        return Routine(
            name or "program",
            line,
            (*local, *statements),
            PointTable(),
            parameters=tuple(parameters),
            last_line=last,
        )


class _Val3Body:
    """The instructions of one program."""

    def __init__(self, findings: Findings, known: Val3Declarations) -> None:
        self.findings, self.kinds = findings, findings.kinds
        self.rules = Val3Rules(known)
        self.parser = LineParser(findings, "val3", self.rules, _CODES, _KNOWN, _MOVES)
        self.body: list[Statement] = []
        self.open: list[type] = []

    def line(self, text: str, number: int) -> None:
        code, comment = _parted(text)
        if not code or code in ("begin", "end"):
            record = LineKind.COMMENT if not code else LineKind.RECORD
            self.kinds[number - 1] = record
            if comment is not None:
                self.body.append(Comment(number, comment))
            return
        before = len(self.body)
        for one in self.parser.parse(code, number):
            self._add(one, number)
        if comment and len(self.body) > before:
            self.body[-1] = with_comment(self.body[-1], comment)

    def _add(self, one: Any, number: int) -> None:
        if isinstance(one, Leave):
            if self.open[-1:] != [Switch]:  # of a switch it ends the case, which the next one does anyway
                self.body.append(Break(number))
            return
        if isinstance(one, (While, For, Repeat, Switch)):
            self.open.append(type(one))
        elif isinstance(one, (EndWhile, Next, Until, EndSwitch)) and self.open:
            self.open.pop()
        if isinstance(one, Move):
            self._tell_queue(number)
            if self.rules.frameless:
                self._tell_frame(number)
        self.body.append(one)

    def _tell_queue(self, number: int) -> None:
        message = "moves are queued: what stands behind one is read as done after it"
        help = "waitEndMove() makes the program wait for it"
        self.findings.once(Severity.INFO, "P576", "", message, self.findings.whole_line(number), help)

    def _tell_frame(self, number: int) -> None:
        self.rules.frameless = False
        message = (
            "no data beside the program says in which frame the point of this move stands: the world is taken"
        )
        help = "put the project's .dtx file beside it"
        self.findings.once(Severity.WARNING, "P577", "", message, self.findings.whole_line(number), help)

    def finish(self) -> list[Statement]:
        """Without what stands between `switch` and its first `case`, which is nothing but comments."""
        kept: list[Statement] = []
        for one in self.body:
            if isinstance(one, Comment) and kept and isinstance(kept[-1], Switch):
                continue
            kept.append(one)
        return kept


def _variables(head: list[XmlTag]) -> Iterator[XmlTag]:
    for tag in head:
        if tag.name.lower() in ("parameter", "local") and tag.attributes.get("name"):
            yield tag


def _size(tag: XmlTag) -> int:
    text = tag.attributes.get("size", "1")
    return min(int(text), 5000) if text.isdigit() and len(text) < 7 else 1


def _declared(tag: XmlTag) -> Declare:
    """A local variable: numbers are 0, poses and joints are all zeros."""
    kind = tag.attributes.get("type", "")
    value: Expression | None = None
    type_ = _TYPES.get(kind, "position" if kind in POSES else "joints" if kind in JOINTS else kind)
    sizes = (Number(_size(tag)),) if _size(tag) > 1 else ()
    if kind in POSES and not sizes:
        value = xyz_pose((0.0,) * 6)
    return Declare(tag.line, tag.attributes["name"], type_, value, sizes, native=kind)


def _parted(text: str) -> tuple[str, str | None]:
    """The instruction and its comment; slashes in a text are part of the text."""
    quoted = False
    for at, char in enumerate(text):
        if char == '"' and text[at - 1 : at] != "\\":
            quoted = not quoted
        elif char == "/" and not quoted and text.startswith("//", at):
            return text[:at].rstrip(), text[at + 2 :]
    return text, None
