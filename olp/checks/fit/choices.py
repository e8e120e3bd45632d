"""Edits that make a program faster: a speed, an acceleration, a zone, a joint move where the path is free.

A choice is a change of the text, so that the edited program is the written one, byte for byte, except for the lines
of the choices. Taught points are never changed, nor lines with `olp: keep`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from olp.checks.lint.rule import LintCase
from olp.checks.lint.rules.exact_stop import ExactStop
from olp.checks.lint.zones import freed, larger
from olp.core.diagnostic import OlpError
from olp.core.source import Source
from olp.core.units import deg, mm
from olp.ir import program as st
from olp.ir.expressions import Expression, Member, Named, Number, Quantity, RecordLiteral, Variable
from olp.languages.literals import SpokenSpeed, Token, language, replaced, shortest, speeds, text_of
from olp.languages.merging import split_arguments
from olp.languages.vendor import find_vendor
from olp.runtime.folder import read_cached
from olp.runtime.plan import BlendCode, StepKind

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from olp.timing.result import Timing


KEPT = re.compile(r"\bolp:\s*keep\b", re.IGNORECASE)
# Of the number that is written: steps that a person would take.
_FASTER = (1.2, 1.5, 2.0)
_JOINT_SPEEDS = (0.25, 0.5, 1.0)  # of a straight move that becomes a joint move, as a share of rated speed
_SPEED_UNITS = {
    st.SpeedUnit.FRACTION: (0.01, "%"),
    st.SpeedUnit.TRAVEL: (mm, "mm/s"),
    st.SpeedUnit.AXIS: (deg, "deg/s"),
}
_RATE_UNITS = {
    st.AccelerationUnit.FRACTION: (0.01, "%"),
    st.AccelerationUnit.TRAVEL: (mm, "mm/s²"),
    st.AccelerationUnit.AXIS: (1.0, "rad/s²"),
}
_DIGITS = 2  # of a new speed: nobody writes 117.3


@dataclass(frozen=True, slots=True)
class Choice:
    """One edit. `line`: of the move that it changes; `place`: two choices of one place exclude each other.

    `says`: "118 → 150 mm/s". `effort` [1]: size of the change, to decide between two edits of equal gain. `texts`:
    numbers that change; `zone`: index of the larger zone that the line gets, -1 for none; `joint` [1]: the share of
    rated speed with which a straight move becomes a joint move, 0 for none. `path`: of the called program that it
    changes; empty: the program itself. `modal`: a setting that holds for moves of other lines. `moved`: lines that
    hold another line's text. `by_axes`: it sets the speed of the axes, and the tool's speed follows.
    """

    kind: str
    line: int
    place: tuple[object, ...]
    says: str
    effort: float
    texts: tuple[tuple[Token, str], ...] = ()
    zone: int = -1
    joint: float = 0.0
    path: str = ""
    modal: bool = False
    moved: frozenset[int] = frozenset()
    by_axes: bool = False

    @property
    def lines(self) -> frozenset[int]:
        """The lines whose text changes."""
        whole = {self.line} if self.zone >= 0 or self.joint > 0.0 else set()
        return frozenset({token.line for token, _ in self.texts} | whole) | self.moved


@dataclass(frozen=True, slots=True)
class Allowed:
    """Limits of the choices. `within` [m] of corners. `speed` [m/s] of the tool, `acceleration` [m/s²] of straight
    moves; None: the highest of the program. `kept`: lines that stay; `free`: lines with a free path. `called`: also
    edit called programs. `unseen`: also speeds beyond those in the signature's recordings. `order`: groups of lines
    whose order is free.
    """

    within: float = 0.0
    speed: float | None = None
    kept: frozenset[int] = frozenset()
    acceleration: float | None = None
    free: frozenset[int] = frozenset()
    called: bool = False
    unseen: bool = False
    order: tuple[range, ...] = ()


class Applied(NamedTuple):
    """The program with edits, and the changed texts of called programs."""

    program: st.Program
    others: tuple[Source, ...] = ()


def called_programs(program: st.Program, timing: Timing) -> dict[str, st.Program]:
    """Programs of other files that run and can be edited, by their paths."""
    found = {}
    for number in np.unique(timing.plan.source).tolist():
        path = timing.plan.sources[number].path
        if number and path not in {one.path for one in (program.source, *program.companions)}:
            try:
                called = read_cached(Path(path))
                language(called)
            except OlpError:
                continue
            found[path] = called
    return found


def choices(program: st.Program, timing: Timing, allowed: Allowed) -> list[Choice]:
    """All edits that may be made, by place, the smaller ones first. Raises OlpError (O001) for other languages."""
    found = list(_choices_of(program, "", timing, allowed))
    if allowed.called:
        for path, called in called_programs(program, timing).items():
            found += _choices_of(called, path, timing, allowed)
    return found


def _choices_of(program: st.Program, path: str, timing: Timing, allowed: Allowed) -> Iterator[Choice]:
    """The edits that may be made in one file."""
    kept = kept_lines(program) | (frozenset() if path else allowed.kept)
    plan = timing.plan
    steps = set(plan.line[plan.source == source_of(timing, path)].tolist())
    most = top_speed(program, timing, allowed)
    spoken = [one for one in speeds(program) if one.speed.unit in _SPEED_UNITS]
    yield from _speeds(spoken, path, most, kept, steps)
    yield from _values(program, path, _highest(spoken, most), kept, allowed.called and not path)
    yield from _accelerations(program, path, allowed, kept)
    if allowed.within > 0.0:
        yield from _zones(program, path, timing, kept)
    if not path:
        yield from _free(program, allowed.free - kept)


def source_of(timing: Timing, path: str) -> int:
    """Index of a file among the plan's sources; 0, the program itself, for an empty path; -1: none."""
    paths = [source.path for source in timing.plan.sources]
    return 0 if not path else paths.index(path) if path in paths else -1


def kept_lines(program: st.Program) -> frozenset[int]:
    """Lines that must not change: those with `olp: keep`, and those below a comment with it."""
    found: set[int] = set()
    prefix = find_vendor(program.vendor).comment_prefix.strip()
    for number, text in enumerate(program.source.lines, 1):
        if KEPT.search(text):
            found.add(number)
            if prefix and text.strip().lstrip("0123456789: ").startswith(prefix.lstrip(": ")):
                found.add(number + 1)
    return frozenset(found)


def top_speed(program: st.Program, timing: Timing, allowed: Allowed) -> float:
    """Highest speed [m/s] that a line may get: the allowed one, else the highest that is written or that a move of
    the run has.
    """
    if allowed.speed is not None:
        return allowed.speed
    written = [_si(one.speed.value) for one in speeds(program) if one.speed.unit is st.SpeedUnit.TRAVEL]
    travel = timing.plan.moves.travel
    return max([*written, *travel[np.isfinite(travel)].tolist()], default=0.0)


def _highest(spoken: Sequence[SpokenSpeed], most: float) -> dict[st.SpeedUnit, float]:
    """Highest value of a speed by its unit; `most` [m/s] of the tool."""
    axis = max((_si(one.speed.value) for one in spoken if one.speed.unit is st.SpeedUnit.AXIS), default=0.0)
    return {st.SpeedUnit.FRACTION: 1.0, st.SpeedUnit.TRAVEL: most, st.SpeedUnit.AXIS: axis}


def _speeds(
    spoken: Sequence[SpokenSpeed], path: str, most: float, kept: frozenset[int], steps: set[int]
) -> Iterator[Choice]:
    """Edits of speeds: of single moves first, then of settings that several moves share."""
    highest = _highest(spoken, most)
    done: set[int] = set()
    for one in sorted(spoken, key=lambda one: one.line not in steps):
        if one.line in kept or one.written in kept or one.written in done:
            continue
        done.add(one.written)
        modal = one.line not in steps
        for value, number, says in _levels(
            one.speed.value, *_SPEED_UNITS[one.speed.unit], highest[one.speed.unit]
        ):
            texts = one.place.respelt(number)
            if texts:
                effort = value / _si(one.speed.value) - 1.0
                place = ("speed", one.written, path)
                new, turns = tuple(texts.items()), one.speed.unit is not st.SpeedUnit.TRAVEL
                yield Choice(
                    "speed", one.line, place, says, effort, new, path=path, modal=modal, by_axes=turns
                )


def _values(
    program: st.Program, path: str, highest: Mapping[st.SpeedUnit, float], kept: frozenset[int], beside: bool
) -> Iterator[Choice]:
    """Edits of variables and records that hold speeds; `beside`: also of those in other files' data lists."""
    for one in spoken_values(program):
        own = one.source.path == program.path
        line = one.token.line
        if one.unit not in _SPEED_UNITS or (not own and not beside):
            continue
        if line in kept if own else KEPT.search(one.source.line(line)):
            continue
        where = path if own else one.source.path
        for value, number, says in _levels(one.value, *_SPEED_UNITS[one.unit], highest[one.unit]):
            text = shortest(number, one.decimals)
            if float(text) > float(text_of(one.source, one.token)):
                yield Choice(
                    "speed",
                    line,
                    ("speed", line, where, one.token.start),
                    f"{one.what} {says}".lstrip(),
                    value / _si(one.value) - 1.0,
                    ((one.token, text),),
                    path=where,
                    modal=True,
                    by_axes=one.unit is not st.SpeedUnit.TRAVEL,
                )


def _levels(now: Quantity, unit: float, name: str, highest: float) -> Iterator[tuple[float, float, str]]:
    """Values that a number may get: each in SI, as written, and as the text "118 → 150 mm/s"."""
    start = _si(now)
    if not 0.0 < start < highest:
        return
    values = [_round(start * factor / unit) * unit for factor in _FASTER]
    told: set[float] = set()
    for value in (*(v for v in values if start < v < highest), highest):
        if round(value, 9) not in told:
            told.add(round(value, 9))
            number = float(f"{value / now.scale:.9g}")
            yield value, number, f"{start / unit:g} → {value / unit:g} {name}"


def _si(value: Quantity) -> float:
    return float(value.literal) if value.literal is not None else 0.0


def _round(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}") if value < 1000 else float(f"{value:.{_DIGITS + 1}g}")


# --- Accelerations ---


class SpokenAcceleration(NamedTuple):
    """An acceleration that is a number on `line`; `modal`: of a setting, else of the move on this line."""

    line: int
    unit: st.AccelerationUnit
    value: Quantity
    token: Token
    modal: bool


def accelerations(program: st.Program) -> Iterator[SpokenAcceleration]:
    """All accelerations that are written as numbers. Raises OlpError (O001)."""
    written = language(program).accelerations
    told: set[Token] = set()
    for one in program.statements():
        if not isinstance(one, st.Move | st.SetAcceleration):
            continue
        known = _rates(one)
        for token in written(program.source, one.line) if known else ():
            number = float(text_of(program.source, token))
            for unit, value in known:
                if (
                    token not in told
                    and value.literal is not None
                    and np.isclose(number * value.scale, value.literal)
                ):
                    told.add(token)
                    yield SpokenAcceleration(
                        one.line, unit, value, token, isinstance(one, st.SetAcceleration)
                    )


def _rates(one: st.Move | st.SetAcceleration) -> list[tuple[st.AccelerationUnit, Quantity]]:
    if isinstance(one, st.SetAcceleration):
        return [(rate.unit, rate.value) for rate in one.rates]
    shares = (value for value in (one.acceleration, one.deceleration) if value is not None)
    found = [(st.AccelerationUnit.FRACTION, value) for value in shares]
    return found if one.rate is None else [*found, (one.rate.unit, one.rate.value)]


def _accelerations(
    program: st.Program, path: str, allowed: Allowed, kept: frozenset[int]
) -> Iterator[Choice]:
    spoken = list(accelerations(program))
    highest = {
        unit: max((_si(one.value) for one in spoken if one.unit is unit), default=0.0)
        for unit in st.AccelerationUnit
    }
    highest[st.AccelerationUnit.FRACTION] = 1.0
    if allowed.acceleration is not None:
        highest[st.AccelerationUnit.TRAVEL] = allowed.acceleration
    for one in spoken:
        if one.line in kept:
            continue
        place = ("acceleration", one.line, path, one.token.start)
        old = text_of(program.source, one.token)
        for value, number, says in _levels(one.value, *_RATE_UNITS[one.unit], highest[one.unit]):
            decimals = 0 if one.unit is st.AccelerationUnit.FRACTION else max(3, len(old.partition(".")[2]))
            texts = ((one.token, shortest(number, decimals)),)
            effort = value / _si(one.value) - 1.0
            yield Choice(
                "acceleration",
                one.line,
                place,
                f"acceleration {says}",
                effort,
                texts,
                path=path,
                modal=one.modal,
            )


# --- Zones and paths ---


def _zones(program: st.Program, path: str, timing: Timing, kept: frozenset[int]) -> Iterator[Choice]:
    """Larger zones for corners; for an exact stop only where no action needs the stop."""
    plan, source = timing.plan, source_of(timing, path)
    stops = set() if path else {found.line for found in ExactStop().find(LintCase(program, timing))}
    steps = np.flatnonzero((plan.kind == StepKind.MOVE) & (plan.source == source))
    for line, first in zip(*np.unique(plan.line[steps], return_index=True), strict=True):
        code = int(plan.moves.blend_code[plan.row[steps[first]]])
        if line in kept or (code == BlendCode.EXACT and line not in stops):
            continue
        for number, text in enumerate(larger(program.vendor, program.source.line(int(line)))):
            place = ("zone", int(line), path)
            yield Choice("zone", int(line), place, text.says, 0.1 * (number + 1), zone=number, path=path)


def _free(program: st.Program, lines: frozenset[int]) -> Iterator[Choice]:
    """Straight moves of these lines as joint moves. They exclude another speed of the line."""
    straight = {
        one.line for one in program.statements() if isinstance(one, st.Move) and one.path is st.Path.LINEAR
    }
    for line in sorted(lines & straight):
        for share in _JOINT_SPEEDS:
            if freed(program.vendor, program.source.line(line), share) is not None:
                says = f"straight → joint move at {share:.0%}".replace("%", " %")
                yield Choice("joint", line, ("speed", line, ""), says, 1.0 + share, joint=share, by_axes=True)


# --- The edited text ---


def apply(
    program: st.Program, chosen: Sequence[Choice], called: Mapping[str, st.Program] | None = None
) -> Applied:
    """The program with these edits, and those of `called` that change. Raises OlpError if the result cannot be read."""
    others = []
    for path, other in (called or {}).items():
        mine = [one for one in chosen if one.path == path]
        if mine:
            others.append(_text_with(other, mine))
    lists = tuple(
        _with_numbers(one, [of for of in chosen if of.path == one.path]) for one in program.companions
    )
    others += [new for new, old in zip(lists, program.companions, strict=True) if new is not old]
    mine = [one for one in chosen if not one.path]
    if not mine and lists == program.companions:
        return Applied(program, tuple(others))
    return Applied(reread(program, _text_with(program, mine), lists), tuple(others))


def reread(program: st.Program, source: Source, lists: tuple[Source, ...] | None = None) -> st.Program:
    """The program with another text of its file and of the data `lists`. Raises OlpError if it cannot be read."""
    again = getattr(language(program), "reread", None)
    beside = program.companions if lists is None else lists
    new = again(source, beside) if again else find_vendor(program.vendor).read(source)
    return st.like(new, program)


def _with_numbers(source: Source, chosen: Sequence[Choice]) -> Source:
    return (
        replaced(source, {token: text for one in chosen for token, text in one.texts}) if chosen else source
    )


def _text_with(program: st.Program, chosen: Sequence[Choice]) -> Source:
    source = replaced(program.source, {token: text for one in chosen for token, text in one.texts})
    lines: dict[int, tuple[str, ...]] = {}
    for one in chosen:
        if one.joint > 0.0:
            text = freed(program.vendor, source.line(one.line), one.joint)
            lines[one.line] = (source.line(one.line) if text is None else text,)
    for one in chosen:
        if one.zone >= 0:
            text = lines.get(one.line, (source.line(one.line),))[0]
            zones = list(larger(program.vendor, text))
            if zones:
                lines[one.line] = (zones[min(one.zone, len(zones) - 1)].text,)
    return source.edited(lines) if lines else source


def seconds_of(base: Timing, edited: Timing, groups: Sequence[NDArray[np.intp]]) -> NDArray[np.float64]:
    """Gain [s] of each group of steps; the gain of every step counts for the nearest group in the run.

    A step of two groups counts for the later one.
    """
    gained = np.nan_to_num(base.duration_s) - np.nan_to_num(edited.duration_s)
    owner = np.full(len(base.plan), -1)
    for number, steps in enumerate(groups):
        owner[steps] = number
    places = np.flatnonzero(owner >= 0)
    found = np.zeros(len(groups))
    if not len(places):
        return found
    steps = np.arange(len(owner))
    after = np.minimum(np.searchsorted(places, steps), len(places) - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.where(abs(places[before] - steps) <= abs(places[after] - steps), before, after)
    np.add.at(found, owner[places[nearer]], gained)
    return found


# --- Speeds that stand elsewhere than in the move ---
# The value of a variable, a member of a record, or what a call gives to a parameter: a setting of all moves that use
# it, where nothing but speeds is made of it.


_NUMBER = re.compile(r"(?<![\w.])(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])")
_WHOLE = 10.0  # a number without a decimal point stays whole from there on


class SpokenValue(NamedTuple):
    """A number that decides the speed of moves. `what`: name of the variable or member; `value`: its meaning as a
    speed.
    """

    what: str
    source: Source
    token: Token
    unit: st.SpeedUnit
    value: Quantity

    @property
    def decimals(self) -> int:
        """Largest number of decimals of a new number."""
        text = text_of(self.source, self.token)
        return max(3, len(text.partition(".")[2])) if "." in text or float(text) < _WHOLE else 0


class _SpeedSource(NamedTuple):
    """Data that hold a speed: a variable, or `member` of a record."""

    thing: Expression
    member: str = ""


def spoken_values(program: st.Program) -> Iterator[SpokenValue]:
    """Numbers of which speeds are made, in the program's file and in the data lists read with it."""
    means: dict[_SpeedSource, set[tuple[st.SpeedUnit, float]]] = {}
    records = {one.name: one.value for one in program.data if isinstance(one.value, RecordLiteral)}
    for one in program.statements():
        for speed in _speeds_of(one):
            said = _said(speed, records)
            if said is not None:
                means.setdefault(said, set()).add((speed.unit, speed.value.scale))
    elsewhere = set(_mentioned(program)) if means else set()
    for said, how in means.items():
        whole = Member(said.thing, said.member) if said.member else said.thing
        if len(how) > 1 or whole in elsewhere:
            continue  # the number means something else as well
        ((unit, scale),) = how
        for source, token in (*_written(program, said), *_given(program, said)):
            number = float(text_of(source, token))
            what = getattr(said.thing, "name", "")
            yield SpokenValue(what, source, token, unit, Quantity(Number(number), scale))


def _speeds_of(one: st.Statement) -> tuple[st.Speed, ...]:
    if isinstance(one, st.SetSpeed):
        return one.speeds
    return (one.speed,) if isinstance(one, st.Move) and one.speed is not None else ()


def _said(speed: st.Speed, records: dict[str, RecordLiteral]) -> _SpeedSource | None:
    """The variable or record member that holds a speed; None where the move itself holds it or it cannot be
    followed.
    """
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


def _mentioned(program: st.Program) -> Iterator[Expression]:
    """Expressions used outside of speeds and outside of assignments of numbers."""
    for one in program.statements():
        if isinstance(one, st.Assign) and isinstance(one.value, Number):
            continue
        if not isinstance(one, st.SetSpeed | st.Declare):
            yield from _within(one, "speed" if isinstance(one, st.Move) else "")


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


def _written(program: st.Program, said: _SpeedSource) -> Iterator[tuple[Source, Token]]:
    for one in (*program.data, *program.statements()):
        if isinstance(one, st.Declare):
            mine = Named(one.name) == said.thing
        else:
            mine = isinstance(one, st.Assign) and not said.member and one.target == said.thing
        value = one.value if mine and isinstance(one, st.Assign | st.Declare) else None
        if isinstance(value, RecordLiteral) and said.member:
            value = dict(value.members).get(said.member)
        if isinstance(value, Number):
            for source, line in _rows(program, one, said):
                token = _number(program, source.line(line), line, said.member, float(value.value))
                if token is not None:
                    yield source, token


def _given(program: st.Program, said: _SpeedSource) -> Iterator[tuple[Source, Token]]:
    """Numbers that calls in the program pass for the parameter of this name."""
    if said.member or not isinstance(said.thing, Named):
        return
    taking = {
        one.name.casefold(): one.parameters
        for one in program.routines
        if any(parameter.name == said.thing.name for parameter in one.parameters)
    }
    for one in program.statements() if taking else ():
        parameters = taking.get(one.routine.casefold()) if isinstance(one, st.Call) else None
        if parameters is None or not isinstance(one, st.Call):
            continue
        plain = not any(parameter.optional or parameter.switch for parameter in parameters)
        at = next(at for at, parameter in enumerate(parameters) if parameter.name == said.thing.name)
        value = one.arguments[at] if plain and at < len(one.arguments) else None
        token = _argument(program, one, at) if isinstance(value, Number) else None
        if token is not None:
            yield program.source, token


def _argument(program: st.Program, call: st.Call, at: int) -> Token | None:
    """Position of a call's argument that is a plain number; None if uncertain."""
    text = program.source.line(call.line)
    mark = find_vendor(program.vendor).trailing_comment_prefix.strip()
    code = text.partition(mark)[0] if mark else text
    start = len(code) - len(code.lstrip())
    if not re.match(rf"{re.escape(call.routine)}\b", code[start:], re.IGNORECASE):
        return None
    names = [str(number) for number in range(len(call.arguments))]
    parts = split_arguments(code[start:], names, {})
    found = next((part for part in parts if part.name == str(at)), None)
    if found is None or len(parts) != len(names) + 2:
        return None
    start += sum(len(part.text) for part in parts[: parts.index(found)])
    number = re.fullmatch(rf"\s*,?\s*({_NUMBER.pattern})\s*", found.text)
    return Token(call.line, start + number.start(1), start + number.end(1)) if number else None


def _rows(program: st.Program, one: st.Statement, said: _SpeedSource) -> Iterator[tuple[Source, int]]:
    """The line that assigns the value; in a data list beside the program only if a single line does."""
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


def _number(program: st.Program, text: str, line: int, member: str, value: float) -> Token | None:
    """Position of the number in the text; None if uncertain."""
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
