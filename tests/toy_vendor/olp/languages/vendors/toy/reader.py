"""A whole TOY file: data, routines, and everything that is wrong with them."""

from __future__ import annotations

import re
from typing import Any, Final

from lark import Token

from olp.core.source import Source
from olp.core.units import deg, mm, percent
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointTable
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
from olp.languages.statement_rules import BlockRules

# Broken line, kept and not modelled, too long, blocks that do not pair, no TOY at all, a move that is not modelled.
_CODES: Final = Codes("P990", "P991", "P992", "P993", "P994", "P995")
_MARK = re.compile(r"^\s*TOYPROGRAM\b", re.IGNORECASE)
_KNOWN: Final = words(
    "JOINT LINE ARC OUT PAUSE WAIT IF ELSEIF ELSE ENDIF WHILE ENDWHILE FOR ENDFOR BREAK LABEL GOTO CALL RETURN SAY STOP"
)
_MOVES: Final = words("JOINT LINE ARC")
_DATA = re.compile(r"(TOOL|FRAME|POSE|AXES|NUM)\s+([A-Z_]\w*)\s*=\s*([-+.\d\s]+)", re.IGNORECASE)
_HEAD = re.compile(r"(TOYPROGRAM|ROUTINE)\s+([A-Z_]\w*)", re.IGNORECASE)
_TYPES: Final = {"TOOL": "tool", "FRAME": "frame", "POSE": "position", "AXES": "joints", "NUM": "real"}


class ToyRules(BlockRules):
    """One method per rule of grammars/toy.lark that BlockRules does not have; numbers become SI by `Quantity`."""

    value = BlockRules.disjunction  # the rule `value` where it has several parts

    def equal(self, children: list[Any]) -> ex.Compare:
        return ex.Compare("=", *children)

    def name(self, children: list[Any]) -> Any:
        word = str(children[0]).upper()
        if word == "WORLD":
            return ex.FrameRef("base")
        return ex.FrameRef("tool", ex.Number(0)) if word == "FLANGE" else super().name(children)

    def rest(self, children: list[Any]) -> dict[str, Any]:
        blend, tool, frame = children
        return {"blend": st.Blend(st.BlendKind.RADIUS, ex.Quantity(blend, mm)), "tool": tool, "frame": frame}

    def joint(self, children: list[Any]) -> st.Move:
        target, share, rest = children
        speed = st.Speed(st.SpeedUnit.FRACTION, ex.Quantity(share, percent))
        return st.Move(0, st.Path.JOINT, (target,), speed, **rest)

    def line(self, children: list[Any]) -> st.Move:
        target, speed, rest = children
        return st.Move(0, st.Path.LINEAR, (target,), _travel(speed), **rest)

    def arc(self, children: list[Any]) -> st.Move:
        via, target, speed, rest = children
        return st.Move(0, st.Path.CIRCULAR, (target,), _travel(speed), via=via, **rest)

    def member(self, children: list[Token]) -> ex.Member:
        return ex.Member(ex.Named(self.spelled(str(children[0]))), str(children[1]).lower())

    def input(self, children: list[Any]) -> ex.Signal:
        return ex.Signal("in", children[0])

    def offset(self, children: list[Any]) -> ex.Function:
        return ex.Function("pose-offset", tuple(children))

    def assign(self, children: list[Any]) -> st.Assign:
        return st.Assign(0, children[0], children[1])

    def output(self, children: list[Any]) -> st.SetOutput:
        return st.SetOutput(0, ex.Signal("out", children[0]), children[1])

    def dwell(self, children: list[Any]) -> st.Dwell:
        return st.Dwell(0, ex.Quantity(children[0], 1.0))

    def for_(self, children: list[Any]) -> st.For:
        name, start, stop, step = children
        return st.For(0, ex.Named(self.spelled(str(name))), start, stop, step)

    def label(self, children: list[Token]) -> st.Label:
        return st.Label(0, self.spelled(str(children[0])))

    def goto(self, children: list[Token]) -> st.Jump:
        return st.Jump(0, self.spelled(str(children[0])))

    def call(self, children: list[Token]) -> st.Call:
        return st.Call(0, self.spelled(str(children[0])))

    def say(self, children: list[Token]) -> st.Message:
        return st.Message(0, ex.Text(str(children[0])[1:-1]))


def read_program(source: Source) -> st.Program:
    """The program in a text. Never raises on bad text."""
    findings = Findings(source)
    if not is_readable(findings, _CODES, _MARK, "TOY"):
        return unreadable("toy", source, findings)
    rules = ToyRules()
    parser = LineParser(findings, "toy", rules, _CODES, _KNOWN, _MOVES)
    routines: list[tuple[str, int, list[Any]]] = []
    data: list[st.Declare] = []
    for number, line in enumerate(source.lines, 1):
        text, mark, comment = line.partition("#")
        text, body = text.strip(), routines[-1][2] if routines else None
        if not text:
            findings.kinds[number - 1] = st.LineKind.COMMENT if mark else st.LineKind.BLANK
            if mark and body is not None:
                body.append(st.Comment(number, comment.strip()))
        elif head := _HEAD.fullmatch(text):
            findings.kinds[number - 1] = st.LineKind.RECORD
            routines.append((rules.spelled(head[2]), number, []))
        elif found := _DATA.fullmatch(text):
            findings.kinds[number - 1] = st.LineKind.RECORD
            value = _value(found[1].upper(), found[3].split())
            if value is None:
                span = findings.whole_line(number)
                findings.error("P990", "this is no value of its type", span, "six numbers, or one of NUM")
                continue
            name = rules.spelled(found[2])
            data.append(st.Declare(number, name, _TYPES[found[1].upper()], value, comment=comment.strip()))
        elif body is None:
            findings.error(
                "P993",
                "an instruction outside of a program",
                findings.whole_line(number),
                "TOYPROGRAM above it",
            )
        else:
            for one in parser.parse(text, number):
                body.append(with_comment(one, comment.strip()) if mark else one)
    made = []
    for name, number, body in routines:
        check_blocks(findings, body, "P993")
        made.append(st.Routine(name, number, tuple(body), PointTable()))
    kinds = bytes(findings.kinds)
    main = made[0].name if made else ""
    return st.Program("toy", source, tuple(made), findings.result(), kinds, tuple(data), main)


def _travel(speed: ex.Expression) -> st.Speed:
    """A speed in mm/s; the number stays as written, and `mm` makes it SI."""
    return st.Speed(st.SpeedUnit.TRAVEL, ex.Quantity(speed, mm))


def _value(word: str, texts: list[str]) -> Any:
    try:
        numbers = [float(one) for one in texts]
    except ValueError:
        return None
    if word == "NUM":
        return ex.Number(int(texts[0]) if texts[0].isdigit() else numbers[0]) if len(numbers) == 1 else None
    if len(numbers) != 6:
        return None
    if word == "AXES":
        return ex.PositionLiteral("joint", tuple(one * deg for one in numbers))
    return ex.PositionLiteral("pose", (*(v * mm for v in numbers[:3]), *(v * deg for v in numbers[3:])))
