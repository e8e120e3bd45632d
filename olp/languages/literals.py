"""Numbers as they stand in a program's text: where a position or a speed is written, and how it is spelt anew.

A position is six numbers of the text (seven with a quaternion). A new one changes the numbers that differ and
leaves the digits of all others, the blanks and the rest of the line as they are.

Codes: O001 a language whose programs cannot be changed.

There are six decimal fractions in every point: they are rounded as `round` does, in less of the time.
"""

from __future__ import annotations

import importlib.util
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import lru_cache
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from olp.core.diagnostic import OlpError, error
from olp.core.source import Source
from olp.ir.expressions import Expression
from olp.ir.points import PointKind
from olp.ir.program import Move, SetSpeed, Speed, SpeedUnit
from olp.robots.geometry import Pose, angles_from_rotation, quaternion_from_rotation, rotation_from_quaternion

if TYPE_CHECKING:
    from olp.ir.program import Program


def trimmed(value: float, decimals: int) -> str | None:
    """`value` with at most so many decimals (up to 11), without zeros behind them; None for 10,000 or more, and nan.

    A whole number ends with its point: languages say for themselves what stands there. Never "-0.".
    """
    if not -1e4 < value < 1e4:  # fifteen digits at most, which a float keeps
        return None
    text = f"{value:.{decimals}f}".rstrip("0")
    return "0." if text == "-0." else text


def all_trimmed(values: tuple[float, ...], decimals: int) -> list[str] | None:
    """`trimmed` of each of a point's values, in a third of the time; None where it is None for one of them."""
    if not (min(values) > -1e4 and max(values) < 1e4):
        return None
    text = _pattern(len(values), decimals) % values
    if "n" in text:  # nan is neither the least nor the greatest
        return None
    found = [one.rstrip("0") for one in text.split(",")]
    return ["0." if one == "-0." else one for one in found] if "-0." in found else found


@lru_cache(maxsize=100)
def _pattern(count: int, decimals: int) -> str:
    return ",".join([f"%.{decimals}f"] * count)


_TURN = 2.0 * math.pi
_SAME_TURN = 1e-9  # [rad] below this an orientation is the same, and its numbers stay


class Token(NamedTuple):
    """One piece of a text: line from 1, columns from 0, half open. `padded`: its column is kept with blanks."""

    line: int
    start: int
    stop: int
    padded: bool = False


class Orientation(StrEnum):
    """How a language writes how the tool is turned."""

    XYZ = "xyz"  # rx ry rz with R = Rz Ry Rx (INFORM, TP)
    ZYX = "zyx"  # the same turns, rz first (KRL)
    QUATERNION = "quaternion"  # w x y z (RAPID)
    VECTOR = "vector"  # axis times angle (URScript)


@dataclass(frozen=True, slots=True)
class Spelling:
    """`length` [m], `angle` [rad]: one written unit. Decimals that a changed number has at least."""

    orientation: Orientation
    length: float
    angle: float
    length_decimals: int
    angle_decimals: int


@dataclass(frozen=True, slots=True)
class WrittenPoint:
    """A position with all of its numbers in the text.

    `name` as written; `target`: what a move calls it, None for one that stands in the move on `line` itself.
    """

    name: str
    line: int
    source: Source
    kind: PointKind
    numbers: tuple[Token, ...]
    spelling: Spelling
    target: Expression | None = None

    def written(self) -> list[float]:
        """The numbers as they stand there, in the language's units."""
        return [float(text_of(self.source, token)) for token in self.numbers]

    def pose(self) -> Pose:
        """[m], in the frame that the point stands in; only of a POSE."""
        values = self.written()
        position = np.asarray(values[:3]) * self.spelling.length
        return Pose(position, _rotation(values[3:], self.spelling))

    def values(self) -> tuple[float, ...]:
        """x y z [m] rx ry rz [rad], the axes [rad], or pulses."""
        if self.kind is PointKind.POSE:
            return tuple(self.pose().xyz_angles().tolist())
        return tuple(
            v * (1.0 if self.kind is PointKind.PULSE else self.spelling.angle) for v in self.written()
        )

    def respelt(self, values: Sequence[float]) -> dict[Token, str]:
        """New texts of the numbers that change, for `values` as `values()` gives them."""
        old, spelling = self.written(), self.spelling
        if self.kind is PointKind.PULSE:
            wanted, least = [float(round(v)) for v in values], [0] * len(old)
        elif self.kind is PointKind.JOINT:
            wanted, least = [v / spelling.angle for v in values], [spelling.angle_decimals] * len(old)
        else:
            pose = Pose.from_xyz_angles(values)
            wanted = [*(pose.position / spelling.length).tolist(), *_turned(pose, self.pose(), old, spelling)]
            least = [spelling.length_decimals] * 3 + [spelling.angle_decimals] * (len(old) - 3)
        found = {}
        for token, new, before, decimals in zip(self.numbers, wanted, old, least, strict=True):
            text = respelt(text_of(self.source, token), new, before, decimals)
            if text is not None:
                found[token] = text
        return found


@dataclass(frozen=True, slots=True)
class WrittenSpeed:
    """The speed of a move or of a setting: `line` is the statement's. `tokens`: all places that say the same.

    `decimals`: at most so many, or with `fixed` exactly. `before` comes in front of a number that has no place yet.
    `named`: where a name stands that may change for one of `names`, by number.
    """

    line: int
    source: Source
    tokens: tuple[Token, ...]
    decimals: int = 1
    before: str = ""
    fixed: bool = False
    named: Token | None = None
    names: Mapping[float, str] = field(default_factory=dict)

    def respelt(self, number: float) -> dict[Token, str]:
        """The texts with `number`, in the unit that is written there."""
        if self.named is not None and number in self.names:
            return {self.named: self.names[number]}
        if self.fixed:
            return dict.fromkeys(self.tokens, f"{number:.{self.decimals}f}")
        return dict.fromkeys(self.tokens, self.before + shortest(number, self.decimals))


def numbers_of(pattern: re.Pattern[str], source: Source, line: int, comment: str) -> Iterator[Token]:
    """Where group 1 of a pattern stands in a line, before what opens a comment there."""
    code = source.line(line).partition(comment)[0]
    return (Token(line, *match.span(1)) for match in pattern.finditer(code))


def text_of(source: Source, token: Token) -> str:
    return source.line(token.line)[token.start : token.stop].strip()


def decimals_of(text: str) -> int:
    """How many digits follow the point."""
    return len(text.partition(".")[2]) if text.replace(".", "").lstrip("+-").isdigit() else 0


def shortest(value: float, decimals: int) -> str:
    """At most so many decimals, none in vain."""
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text


def respelt(old: str, new: float, before: float, least: int) -> str | None:
    """`new` with the decimals of `old`, or as many as `least` where they say something; None: nothing changes."""
    own = decimals_of(old)
    decimals = max(own, least)
    if abs(new - before) < 0.5 * 10.0**-decimals:
        return None
    text = shortest(new, decimals)
    missing = own - decimals_of(text)
    if missing > 0:
        text += ("" if "." in text else ".") + "0" * missing
    return text


def replaced(source: Source, texts: dict[Token, str]) -> Source:
    """The text with `texts` in place of their tokens; all other bytes stay."""
    lines: dict[int, str] = {}
    for token in sorted(texts, key=lambda one: (one.line, -one.start)):
        line = lines.get(token.line, source.line(token.line))
        text, start = texts[token], token.start
        if token.padded:
            # The old number's column ends where it ended; blanks give way on its left.
            room = len(line[:start]) - len(line[:start].rstrip(" "))
            start -= min(max(0, len(text) - (token.stop - start)), max(0, room - 1))
            text = text.rjust(token.stop - start)
        lines[token.line] = line[:start] + text + line[token.stop :]
    return source.edited({number: (line,) for number, line in lines.items()})


def _rotation(
    numbers: Sequence[float], spelling: Spelling
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    if spelling.orientation is Orientation.QUATERNION:
        return rotation_from_quaternion(numbers)
    turns = np.asarray(numbers) * spelling.angle
    if spelling.orientation is Orientation.VECTOR:
        return rotation_from_quaternion(_quaternion_of_vector(turns))
    if spelling.orientation is Orientation.ZYX:
        turns = turns[::-1]
    return Pose.from_xyz_angles([0.0, 0.0, 0.0, *turns]).rotation


def _quaternion_of_vector(vector: ArrayLike) -> list[float]:
    x, y, z = np.asarray(vector, dtype=np.float64).tolist()
    angle = math.sqrt(x * x + y * y + z * z)
    share = 0.5 if angle < 1e-12 else math.sin(0.5 * angle) / angle
    return [math.cos(0.5 * angle), x * share, y * share, z * share]


def _turned(pose: Pose, before: Pose, old: Sequence[float], spelling: Spelling) -> list[float]:
    """The numbers of an orientation, of all that say the same those nearest to the old ones."""
    twist = before.rotation.T @ pose.rotation
    if np.abs(twist - np.eye(3)).max() < _SAME_TURN:
        return list(old[3:])
    if spelling.orientation is Orientation.QUATERNION:
        q = quaternion_from_rotation(pose.rotation)
        return (q if float(np.dot(q, old[3:])) >= 0.0 else -q).tolist()  # type: ignore[no-any-return]
    if spelling.orientation is Orientation.VECTOR:
        choices = _vectors(quaternion_from_rotation(pose.rotation).tolist())
    else:
        choices = _angles(pose)
        if spelling.orientation is Orientation.ZYX:
            choices = [one[::-1] for one in choices]
    written = [[v / spelling.angle for v in one] for one in choices]
    if spelling.orientation is not Orientation.VECTOR:
        full = _TURN / spelling.angle
        written = [
            [v + full * round((w - v) / full) for v, w in zip(one, old[3:], strict=True)] for one in written
        ]
        written = [[_once_round(v, full) for v in one] for one in written]
    return min(written, key=lambda one: sum((v - w) ** 2 for v, w in zip(one, old[3:], strict=True)))


def _once_round(value: float, full: float) -> float:
    """Within one turn either way: controllers refuse more."""
    return value - full * round(value / full) if abs(value) > full else value


def _angles(pose: Pose) -> list[list[float]]:
    rx, ry, rz = angles_from_rotation(pose.rotation).tolist()
    return [[rx, ry, rz], [rx + math.pi, math.pi - ry, rz + math.pi]]


def _vectors(quaternion: Sequence[float]) -> list[list[float]]:
    w, *axis = quaternion
    sine = math.sqrt(sum(v * v for v in axis))
    if sine < 1e-12:
        return [[0.0, 0.0, 0.0]]
    angle = 2.0 * math.atan2(sine, w)
    return [[v / sine * turn for v in axis] for turn in (angle, angle - _TURN)]


def written_points(program: Program) -> dict[str, WrittenPoint]:
    """The positions that can be changed, by name; none of a name that is written twice.

    Raises OlpError (O001) for a language that cannot be edited.
    """
    return {name: found[0] for name, found in by_name(program).items() if len(found) == 1}


def language(program: Program) -> ModuleType:
    """The vendor's module that finds positions and speeds. Raises OlpError (O001) where there is none."""
    name = f"olp.languages.vendors.{program.vendor}.written"
    package = import_module(f"olp.languages.vendors.{program.vendor}")
    if not hasattr(package, "__path__") or importlib.util.find_spec(name) is None:
        raise OlpError(
            error("O001", f"programs in {program.vendor} cannot be changed here", file=program.path)
        )
    return import_module(name)


def by_name(program: Program) -> dict[str, list[WrittenPoint]]:
    """All positions with numbers in the text, by name."""
    found: dict[str, list[WrittenPoint]] = {}
    for point in language(program).points(program):
        found.setdefault(point.name, []).append(point)
    return found


class SpokenSpeed(NamedTuple):
    """`speed` of the statement on `line`, written on the line `written`: of a move in KRL mostly another one.

    `place`: where its number stands.
    """

    line: int
    speed: Speed
    written: int
    place: WrittenSpeed


def speed_of(program: Program, line: int) -> Speed | None:
    """The speed that `line` would be given by `ChangeSpeed`; None where none is written as a number."""
    found = written_speed(program, line)
    return None if found is None else found[1]


def speeds(program: Program) -> list[SpokenSpeed]:
    """All speeds that `ChangeSpeed` can change, by line. Raises OlpError (O001)."""
    by_line = _by_line(program)
    found = ((line, _spelt(program, by_line, line)) for line in sorted(by_line))
    return [SpokenSpeed(line, one[1], one[0].line, one[0]) for line, one in found if one is not None]


def written_speed(program: Program, line: int) -> tuple[WrittenSpeed, Speed] | None:
    """Where the speed of the statement on `line` stands, and what it is."""
    return _spelt(program, _by_line(program), line)


def _by_line(program: Program) -> dict[int, list[Move | SetSpeed]]:
    found: dict[int, list[Move | SetSpeed]] = {}
    for one in program.statements():
        if isinstance(one, Move | SetSpeed):
            found.setdefault(one.line, []).append(one)
    return found


def _spelt(
    program: Program, by_line: Mapping[int, list[Move | SetSpeed]], line: int
) -> tuple[WrittenSpeed, Speed] | None:
    for one in by_line.get(line, ()):
        own = [speed for speed in _speeds(one) if speed.value.literal is not None]
        for unit in [speed.unit for speed in own] or (SpeedUnit.FRACTION, SpeedUnit.TRAVEL):
            written = language(program).speed(program, one, unit)
            said = () if written is None else by_line.get(written.line, ())
            for speed in (speed for other in said for speed in _speeds(other)):
                if speed.unit is unit and speed.value.literal is not None:
                    return written, speed
    return None


def _speeds(statement: Move | SetSpeed) -> tuple[Speed, ...]:
    if isinstance(statement, SetSpeed):
        return statement.speeds
    return () if statement.speed is None else (statement.speed,)
