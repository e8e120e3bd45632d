"""Writes the /POS section, and finds the number of every position that a move names."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import terminology
from olp.ir.points import PointBlock, PointKind, PointState, PointTable
from olp.languages.generator import CannotSayError
from olp.languages.vendors.tp.positions import MODAL
from olp.languages.vendors.tp.values import GROUP_STORES

_EXACT: Final = 9  # decimals that are tried where a position is to be read as it was
_LENGTH_DECIMALS, _ANGLE_DECIMALS = 4, 5
_ARM_AXES = 6
_MISSING: Final = "********"
_POSE_NAMES: Final = ("X", "Y", "Z", "W", "P", "R")

Frames = tuple[int | None, int]  # user frame (None: F), tool (MODAL: F)


class TpPositionWriter:
    """The positions of one program. `exact`: as many decimals as give the same numbers when read again."""

    def __init__(self, points: PointTable, details: Mapping[str, str], exact: bool) -> None:
        self.points = points
        self.details = details
        self.exact = exact
        self._frames: dict[int, Frames] = {}
        self._copies: dict[tuple[int, Frames], int] = {}
        self._literals: dict[tuple[ex.PositionLiteral, Frames], int] = {}
        self._made: dict[int, tuple[ex.PositionLiteral, Frames]] = {}
        self._copied: dict[int, int] = {}
        block = points.blocks.get((ex.Store.ROBOT, True))
        self._block = block
        self._last = int(block.numbers.max()) if block is not None and len(block) else 0

    # --- numbers ----------------------------------------------------------------------------------------

    def taught(self, number: int, user: int | None, tool: int | None) -> int:
        """The number under which a taught position is written; a copy where other frames hold than elsewhere.

        `user`, `tool`: those that hold at the move; None: the position's own.
        """
        if user is None and tool is None:
            return number
        own = self._own(number)
        if own is None:
            return number
        wanted: Frames = (own[0] if user is None else user, own[1] if tool is None else tool)
        known = self._frames.setdefault(number, wanted)
        if known == wanted:
            return number
        copy = self._copies.get((number, wanted))
        if copy is None:
            copy = self._copies[number, wanted] = self._new()
            self._copied[copy] = number
            self._frames[copy] = wanted
        return copy

    def literal(self, literal: ex.PositionLiteral, user: int | None, tool: int | None) -> int:
        """The number of a position that is written out; equal ones share it."""
        frames: Frames = (user, MODAL if tool is None else tool)
        number = self._literals.get((literal, frames))
        if number is None:
            number = self._literals[literal, frames] = self._new()
            self._made[number] = (literal, frames)
        return number

    def _own(self, number: int) -> Frames | None:
        row = None if self._block is None else self._block.rows.get(number)
        if self._block is None or row is None:
            return None
        return _frames_of(self.points.states[int(self._block.state[row])])

    def _new(self) -> int:
        self._last += 1
        return self._last

    # --- text -------------------------------------------------------------------------------------------

    def lines(self) -> Iterator[str]:
        """All positions, in order of their numbers in the table, then those that were added."""
        unknown = [key for key in self.points.blocks if not key[1] or key[0] not in GROUP_STORES.values()]
        if unknown:
            raise CannotSayError(
                f"a {terminology.STORES[unknown[0][0]]} that the program sets when it is loaded"
            )
        if self._block is not None:
            texts = _TpRows(self, self._block, 1)
            others = self._other_groups()
            for row, number in enumerate(self._block.numbers.tolist()):
                yield from self._taught(number, row, texts, others)
            for copy, number in self._copied.items():
                yield from self._taught(copy, self._block.rows[number], texts, [])
        for number, (literal, frames) in self._made.items():
            yield from self._literal(number, literal, frames)

    def group(self, place: int) -> int:
        """The number of the motion group whose positions come at `place` (from 1)."""
        return int(self.details.get(f"group {place}", place))

    def _other_groups(self) -> list[tuple[int, PointBlock, _TpRows]]:
        found = []
        for place, store in GROUP_STORES.items():
            block = self.points.blocks.get((store, True))
            if place > 1 and block is not None:
                found.append((self.group(place), block, _TpRows(self, block, place)))
        return found

    def _taught(
        self, number: int, row: int, texts: _TpRows, others: list[tuple[int, PointBlock, _TpRows]]
    ) -> Iterator[str]:
        name = self.details.get(f"P[{number}]") if self.details else None
        if not others and (plain := texts.plain(row, self._frames.get(number))) is not None:
            yield f'P[{number}:"{name}"]{plain}' if name else f"P[{number}]{plain}"
            return
        yield f'P[{number}:"{name}"]{{' if name else f"P[{number}]{{"
        yield f"   GP{self.group(1)}:"
        yield from texts.lines(row, self._frames.get(number))
        for group, block, rows in others:
            if number in block.rows:
                yield f"   GP{group}:"
                yield from rows.lines(block.rows[number], None)
        yield "};"

    def _literal(self, number: int, literal: ex.PositionLiteral, frames: Frames) -> Iterator[str]:
        pose = literal.kind == "pose"
        state = PointState(PointKind.POSE if pose else PointKind.JOINT, configuration=literal.configuration)
        scale = [mm] * 3 + [deg] * 3 if pose else [deg] * len(literal.values)
        row = [_field(v, unit, _decimals(unit), False) for v, unit in zip(literal.values, scale, strict=True)]
        row += [_text(value, _LENGTH_DECIMALS) for value in literal.external if not math.isnan(value)]
        yield f"P[{number}]{{"
        yield "   GP1:"
        yield from _group_lines(state, frames, row, ["deg"] * len(row))
        yield "};"


class _TpRows:
    """The texts of one block's rows."""

    def __init__(self, writer: TpPositionWriter, block: PointBlock, place: int) -> None:
        self.states = writer.points.states
        self.block = block
        self.exact = writer.exact
        group, width = writer.group(place), block.values.shape[1]
        self.configuration = writer.details.get("CONFIG", "")
        self.units = [
            [writer.details.get(f"unit GP{group} {_axis(kind, at)}", "deg") for at in range(width)]
            for kind in (PointKind.POSE, PointKind.JOINT)
        ]
        self.table = [self._rounded(at) for at in (0, 1)]
        self.kinds: list[int] = block.state.tolist()
        self._patterns: dict[tuple[int, Frames | None], str] = {}
        self._head = f"{{\n   GP{group}:\n"

    def _scale(self, joint: int) -> list[float]:
        units = self.units[joint]
        return [mm if unit == "mm" or (not joint and at < 3) else deg for at, unit in enumerate(units)]

    def _rounded(self, joint: int) -> tuple[list[list[float]], list[bool], list[int], list[float]]:
        """All rows in written units, which of them may be written so, with how many decimals, and SI per unit."""
        scale = self._scale(joint)
        units = np.array(scale)
        decimals = [3 if self.exact else _decimals(unit) for unit in scale]
        columns = (self.block.values / units).T
        rounded = (
            np.column_stack([np.round(column, n) for column, n in zip(columns, decimals, strict=True)]) + 0.0
        )
        if self.exact:
            plain = np.all(rounded * units == self.block.values, axis=1)
        else:
            plain = ~np.isnan(rounded).any(axis=1)
        return rounded.tolist(), np.atleast_1d(plain).tolist(), decimals, scale

    def plain(self, row: int, frames: Frames | None) -> str | None:
        """What stands behind the number of a pose of six rounded values, as nearly all are; None for all others."""
        table, plain, _, _ = self.table[0]
        values = table[row]
        if not plain[row] or len(values) != _ARM_AXES:
            return None
        key = (self.kinds[row], frames)
        pattern = self._patterns.get(key)
        if pattern is None:
            pattern = self._patterns[key] = self._pattern(*key)
        return pattern % tuple(values) if pattern else None

    def _pattern(self, kind: int, frames: Frames | None) -> str:
        """The text of a pose with this state, with places for its values; empty for what is no pose."""
        state = self.states[kind]
        if state.kind is not PointKind.POSE:
            return ""
        flags = configuration(state.configuration) if state.configuration else self.configuration
        marks = [f"{at}" for at in range(_ARM_AXES)]
        lines = _group_lines(state, frames or _frames_of(state), marks, self.units[0], flags)
        text = "\n".join([*lines, "};"]).replace("%", "%%")
        for mark, count in zip(marks, self.table[0][2], strict=True):
            text = text.replace(f"= {mark:>9} ", f"= %9.{count}f ")
        return self._head + text

    def lines(self, row: int, frames: Frames | None) -> Iterator[str]:
        """The lines of one row; `frames`: instead of its own."""
        state = self.states[int(self.block.state[row])]
        joint = int(state.kind is PointKind.JOINT)
        if state.kind is PointKind.PULSE:
            raise CannotSayError("positions in pulses", "say which robot it is, and they become joint angles")
        table, plain, decimals, scale = self.table[joint]
        if plain[row]:
            texts = [f"{value:.{count}f}" for value, count in zip(table[row], decimals, strict=True)]
        else:
            original = self.block.values[row].tolist()
            fields = zip(original, scale, decimals, strict=True)
            texts = [_field(value, unit, count, self.exact) for value, unit, count in fields]
        flags = configuration(state.configuration) if state.configuration else self.configuration
        yield from _group_lines(state, frames or _frames_of(state), texts, self.units[joint], flags)


def _group_lines(
    state: PointState, frames: Frames, row: list[str], units: list[str], flags: str = ""
) -> Iterator[str]:
    user = "F" if frames[0] is None else str(frames[0])
    tool = "F" if frames[1] == MODAL else str(frames[1])
    if state.kind is PointKind.POSE:
        yield f"\tUF : {user}, UT : {tool},\t\tCONFIG : '{flags or configuration(state.configuration)}',"
        x, y, z, w, p, r, *more = row
        places = (f"{name} = {_column(text)}  mm," for name, text in (("X", x), ("Y", y), ("Z", z)))
        yield "\t" + "\t".join(places)
        turns = (f"{name} = {_column(text)} deg" for name, text in (("W", w), ("P", p), ("R", r)))
        last = "\t" + ",\t".join(turns)
        fields = [
            f"E{at}= {text:>9} {units[5 + at]:>3}" for at, text in enumerate(more, 1) if text != _MISSING
        ]
        yield from [last] if not fields else [f"{last},", "\t" + ",\t".join(fields)]
        return
    yield f"\tUF : {user}, UT : {tool},\t"
    axes = row[:_ARM_AXES]
    while axes[-1] == _MISSING and any(text != _MISSING for text in axes):
        axes.pop()  # of a mechanism with fewer axes
    fields = [f"J{at}= {text:>9} {units[at - 1]:>3}" for at, text in enumerate(axes, 1)]
    fields += [
        f"E{at}= {text:>9} {units[_ARM_AXES + at - 1]:>3}"
        for at, text in enumerate(row[_ARM_AXES:], 1)
        if text != _MISSING
    ]
    rows = [fields[at : at + 3] for at in range(0, len(fields), 3)]
    for at, some in enumerate(rows):
        yield "\t" + ",\t".join(some) + ("," if at + 1 < len(rows) else "")


def _column(text: str) -> str:
    """A number as wide as the controller writes it; it writes `_MISSING` narrower."""
    return text if text == _MISSING else f"{text:>9}"


def configuration(flags: tuple[int, ...]) -> str:
    """CONFIG's text: wrist, elbow, front, and the turns of J4, J5 and J6; no flags: N U T."""
    if not flags:
        return "N U T, 0, 0, 0"
    wrist, elbow, front, fourth, sixth, _, *rest = (*flags, *[0] * (6 - len(flags)))
    letters = f"{'FN'[min(abs(wrist), 1)]} {'UD'[min(abs(elbow), 1)]} {'TB'[min(abs(front), 1)]}"
    return f"{letters}, {fourth}, {rest[0] if len(rest) == 1 else 0}, {sixth}"


def _frames_of(state: PointState) -> Frames:
    user = None if state.user == MODAL else state.user
    return (0 if state.frame in ("base", "robot") else user, state.tool)


def _axis(kind: PointKind, at: int) -> str:
    """The name of column `at`."""
    if at >= _ARM_AXES:
        return f"E{at - _ARM_AXES + 1}"
    return _POSE_NAMES[at] if kind is PointKind.POSE else f"J{at + 1}"


def _decimals(unit: float) -> int:
    return _LENGTH_DECIMALS if unit == mm else _ANGLE_DECIMALS


def _field(value: float, unit: float, at_least: int, exact: bool) -> str:
    if math.isnan(value):
        return _MISSING
    if not exact:
        return _text(value / unit, at_least)
    for count in range(at_least, _EXACT + 1):
        rounded = round(value / unit, count)
        if rounded * unit == value:
            return f"{rounded:.{count}f}"
    return _text(value / unit, _EXACT)


def _text(value: float, decimals: int) -> str:
    return f"{round(value, decimals) + 0.0:.{decimals}f}"
