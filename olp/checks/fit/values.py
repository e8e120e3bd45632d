"""Speeds that stand elsewhere than in the move: the value of a variable, a member of a record of data.

Such a number is a setting of all moves that use it, and is one only where nothing but speeds is made of it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import NamedTuple

from olp.core.source import Source
from olp.ir.expressions import Expression, Member, Named, Number, Quantity, RecordLiteral, Variable
from olp.ir.moves import Move, SetSpeed, Speed, SpeedUnit
from olp.ir.program import Program, Statement
from olp.ir.statements import Assign, Declare
from olp.languages.literals import Token, text_of
from olp.languages.vendor import find_vendor

_NUMBER = re.compile(r"(?<![\w.])(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])")
_WHOLE = 10.0  # a number without a decimal point stays whole from there on


class SpokenValue(NamedTuple):
    """A number that says how fast moves are. `what`: of what it is the value; `value`: what it means as a speed."""

    what: str
    source: Source
    token: Token
    unit: SpeedUnit
    value: Quantity

    @property
    def decimals(self) -> int:
        """How many a new number has at most."""
        text = text_of(self.source, self.token)
        return max(3, len(text.partition(".")[2])) if "." in text or float(text) < _WHOLE else 0


class _SpeedSource(NamedTuple):
    """A thing that a speed is made of: a variable, or `member` of a record."""

    thing: Expression
    member: str = ""


def spoken_values(program: Program) -> Iterator[SpokenValue]:
    """Those of the program's file and of the lists that were read with it."""
    means: dict[_SpeedSource, set[tuple[SpeedUnit, float]]] = {}
    records = {one.name: one.value for one in program.data if isinstance(one.value, RecordLiteral)}
    for one in program.statements():
        for speed in _speeds(one):
            said = _said(speed, records)
            if said is not None:
                means.setdefault(said, set()).add((speed.unit, speed.value.scale))
    elsewhere = set(_mentioned(program)) if means else set()
    for said, how in means.items():
        whole = Member(said.thing, said.member) if said.member else said.thing
        if len(how) > 1 or whole in elsewhere:
            continue  # the number means something else as well
        ((unit, scale),) = how
        for source, token in _written(program, said):
            number = float(text_of(source, token))
            what = getattr(said.thing, "name", "")
            yield SpokenValue(what, source, token, unit, Quantity(Number(number), scale))


def _speeds(one: Statement) -> tuple[Speed, ...]:
    if isinstance(one, SetSpeed):
        return one.speeds
    return (one.speed,) if isinstance(one, Move) and one.speed is not None else ()


def _said(speed: Speed, records: dict[str, RecordLiteral]) -> _SpeedSource | None:
    """What a speed is made of; None where it stands in the move or cannot be followed."""
    match speed.value.written:
        case Named() as name:
            return _SpeedSource(name)
        case Variable(index=Number()) as variable:
            return _SpeedSource(variable)
        case Member(base=Named() as record, name=member):
            return _SpeedSource(record, member)
        case Number() if speed.native in records:
            # The reader has put the value of the constant into the move.
            return _SpeedSource(Named(speed.native), records[speed.native].members[0][0])
    return None


def _mentioned(program: Program) -> Iterator[Expression]:
    """Whatever is said in other places than speeds, and values that are given as numbers."""
    for one in program.statements():
        if isinstance(one, Assign) and isinstance(one.value, Number):
            continue
        if not isinstance(one, SetSpeed | Declare):
            yield from _within(one, "speed" if isinstance(one, Move) else "")


def _within(it: object, but: str = "") -> Iterator[Expression]:
    if isinstance(it, Named | Variable | Member):
        yield it
    if isinstance(it, tuple):
        for part in it:
            yield from _within(part)
    elif is_dataclass(it) and not isinstance(it, type):
        for field in fields(it):
            if field.name != but:
                yield from _within(getattr(it, field.name))


# --- Where they stand ---


def _written(program: Program, said: _SpeedSource) -> Iterator[tuple[Source, Token]]:
    for one in (*program.data, *program.statements()):
        if isinstance(one, Declare):
            mine = Named(one.name) == said.thing
        else:
            mine = isinstance(one, Assign) and not said.member and one.target == said.thing
        value = one.value if mine and isinstance(one, Assign | Declare) else None
        if isinstance(value, RecordLiteral) and said.member:
            value = dict(value.members).get(said.member)
        if isinstance(value, Number):
            for source, line in _rows(program, one, said):
                token = _number(program, source.line(line), line, said.member, float(value.value))
                if token is not None:
                    yield source, token


def _rows(program: Program, one: Statement, said: _SpeedSource) -> Iterator[tuple[Source, int]]:
    """The line that gives the value; of a list beside the program the only one that does."""
    if one.line > 0:
        yield program.source, one.line
        return
    name = re.escape(getattr(said.thing, "name", "") or "\0")
    row = re.compile(rf"(?<![\w$.]){name}\s*=", re.IGNORECASE)
    found = [
        (source, number)
        for source in program.companions
        for number, line in enumerate(source.lines, 1)
        if row.search(line)
    ]
    if len(found) == 1:
        yield found[0]


def _number(program: Program, text: str, line: int, member: str, value: float) -> Token | None:
    """Where the number stands; None where that cannot be said for sure."""
    mark = find_vendor(program.vendor).trailing_comment_prefix.strip()
    code = text.partition(mark)[0] if mark else text
    start = code.find("=") + 1
    named = re.search(rf"\b{re.escape(member)}\s+(?={_NUMBER.pattern})", code[start:], re.IGNORECASE)
    if member and named is not None:
        start += named.end()
    found = list(_NUMBER.finditer(code, start))
    wanted = found[:1] if member else found
    same = [match for match in wanted if float(match[0]) == value]
    return Token(line, *same[0].span()) if len(same) == 1 else None
