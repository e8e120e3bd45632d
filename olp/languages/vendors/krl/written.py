"""The text spans of the positions and speeds in a KRL program: .dat, .src, and three places of an inline form."""

from __future__ import annotations

import re
from collections.abc import Iterator

from olp.core.source import Source
from olp.core.units import deg, mm
from olp.ir import program as st
from olp.ir.expressions import Expression, Named
from olp.ir.points import PointKind
from olp.languages.literals import Orientation, Spelling, Token, WrittenPoint, WrittenSpeed, numbers_of
from olp.languages.vendors.krl.parsing import split
from olp.languages.vendors.krl.reader import read_program

_DECLARED = re.compile(
    r"\s*(?:DECL\s+)?(?:GLOBAL\s+)?(?:E6POS|POS|FRAME|E6AXIS|AXIS)\s+(\w+)\s*=\s*(\{)", re.IGNORECASE
)
_IN_MOVE = re.compile(r"\s*S?(?:LIN|PTP|SPL)\s*(\{)", re.IGNORECASE)
_MEMBER = re.compile(r"(?<![\w$])(A[1-6]|[XYZABC])\s+([-+]?\d*\.?\d+(?:[Ee][-+]?\d+)?)", re.IGNORECASE)
_POSE, _AXES = tuple("XYZABC"), tuple(f"A{n}" for n in range(1, 7))
_SETTING = re.compile(
    r"\s*(?:BAS\s*\(\s*#(?:PTP_PARAMS|CP_PARAMS|VEL_PTP|VEL_CP)\s*,|\$VEL\.CP\s*=)\s*(\d*\.?\d+)",
    re.IGNORECASE,
)
_ACCELERATION = re.compile(
    r"^\s*(?:BAS\s*\(\s*#(?:ACC_PTP|ACC_CP)\s*,|\$ACC(?:\.CP|_AXIS\[\s*\d\s*\])\s*=)\s*(\d*\.?\d+)",
    re.IGNORECASE,
)
_FORM = re.compile(r"\s*;FOLD\s+\w+\s.*?\bVel=\s*(\d*\.?\d+)\s*(?:%|m/s)", re.IGNORECASE)
_FORM_PARAMETER = re.compile(r",\s*5:\s*(\d*\.?\d+)\s*,")
_BETWEEN = (st.SetSpeed, st.SetAcceleration, st.SetBlend, st.SetFrame, st.SetTool, st.Assign, st.Comment)
SPELLING = Spelling(Orientation.ZYX, mm, deg, 3, 4)


def points(program: st.Program) -> Iterator[WrittenPoint]:
    """Declared positions with a value, and those written out in a LIN or PTP. $config.dat belongs to the cell."""
    for source in (program.source, *program.companions):
        if "$" in source.path.replace("\\", "/").rpartition("/")[2]:
            continue
        for number, line in enumerate(source.lines, 1):
            if "{" not in line:
                continue
            code = line[: len(line) - len(line.lstrip()) + len(split(line)[0])]
            declared = _DECLARED.match(code)
            match = declared or _IN_MOVE.match(code)
            if match is None or (declared is None and code.count("{") != 1):
                continue
            target = Named(declared[1]) if declared else None
            point = _point(source, number, code, match.end(), target)
            if point is not None:
                yield point


def _point(
    source: Source, number: int, code: str, start: int, target: Expression | None
) -> WrittenPoint | None:
    tokens = {m[1].upper(): Token(number, *m.span(2)) for m in _MEMBER.finditer(code, start)}
    for kind, keys in ((PointKind.POSE, _POSE), (PointKind.JOINT, _AXES)):
        if all(key in tokens for key in keys):
            name = target.name if isinstance(target, Named) else f"line {number}"
            numbers = tuple(tokens[key] for key in keys)
            return WrittenPoint(name, number, source, kind, numbers, SPELLING, target)
    return None


def speed(program: st.Program, statement: st.Move | st.SetSpeed, unit: st.SpeedUnit) -> WrittenSpeed | None:
    """The number of a speed setting: `statement` itself, or the one before a move that holds for this move alone."""
    setting = statement if isinstance(statement, st.SetSpeed) else _own_setting(program, statement, unit)
    match = None if setting is None else _SETTING.match(program.source.line(setting.line))
    if setting is None or match is None:
        return None
    return WrittenSpeed(
        setting.line,
        program.source,
        (Token(setting.line, *match.span(1)), *_form(program.source, setting.line)),
        6,
    )


def _own_setting(program: st.Program, move: st.Move, unit: st.SpeedUnit) -> st.SetSpeed | None:
    """The speed setting that holds for this move and no other. A path speed does not hold for a PTP."""
    if (unit is st.SpeedUnit.FRACTION) != (move.path is st.Path.JOINT):
        return None
    for routine in program.routines:
        lines = [one.line for one in routine.body]
        if not lines or not lines[0] <= move.line <= lines[-1]:
            continue
        here = next((i for i, one in enumerate(routine.body) if one is move), None)
        if here is None:
            continue
        before = routine.body[:here][::-1]
        found = next((i for i, one in enumerate(before) if _sets(one, unit)), None)
        if found is None or not all(isinstance(one, _BETWEEN) for one in before[:found]):
            return None
        for one in routine.body[here + 1 :]:
            if _sets(one, unit):
                break
            if isinstance(one, st.Move) and (one.path is st.Path.JOINT) == (move.path is st.Path.JOINT):
                return None
        setting = before[found]
        return setting if isinstance(setting, st.SetSpeed) else None
    return None


def _sets(statement: object, unit: st.SpeedUnit) -> bool:
    return isinstance(statement, st.SetSpeed) and any(speed.unit is unit for speed in statement.speeds)


def _form(source: Source, line: int) -> list[Token]:
    """The same speed in the head of the inline form around `line`: the teach pendant shows that one."""
    for number in range(line - 1, 0, -1):
        text = source.line(number)
        if text.lstrip().upper().startswith(";ENDFOLD") or not text.strip():
            return []
        if text.lstrip().upper().startswith(";FOLD"):
            found = (_FORM.match(text), _FORM_PARAMETER.search(text))
            return [Token(number, *match.span(1)) for match in found if match is not None]
    return []


def reread(source: Source, companions: tuple[Source, ...]) -> st.Program:
    """The program in texts that are not on the disk."""
    return read_program(source, companions)


def accelerations(source: Source, line: int) -> Iterator[Token]:
    """The number of a setting: $ACC.CP, $ACC_AXIS[n] or BAS."""
    return numbers_of(_ACCELERATION, source, line, ";")
