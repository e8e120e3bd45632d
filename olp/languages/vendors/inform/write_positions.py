"""Writes the //POS section: rows by family, and a state record wherever the state changes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import terminology
from olp.ir.points import PointBlock, PointKind, PointState, PointTable
from olp.languages.generator import CannotSayError
from olp.languages.vendors.inform.write_values import decimal

FAMILIES: Final = {
    "C": (ex.Store.ROBOT, True),
    "BC": (ex.Store.BASE, True),
    "EC": (ex.Store.STATION, True),
    "P": (ex.Store.ROBOT, False),
    "BP": (ex.Store.BASE, False),
    "EX": (ex.Store.STATION, False),
}
_KIND_RECORDS: Final = {PointKind.PULSE: "PULSE", PointKind.POSE: "RECTAN", PointKind.JOINT: "ANGLE"}
_POSTYPES: Final = {
    "pulse": "PULSE",
    "joint": "ANGLE",
    "base": "BASE",
    "robot": "ROBOT",
    "user": "USER",
    "tool": "TOOL",
    "master-tool": "MTOOL",
}
_LENGTH_DECIMALS, _ANGLE_DECIMALS, _OLD_ANGLE_DECIMALS = 3, 4, 2
_MOST_DECIMALS = 9
_FLAGS = 24  # of ///RCONF, all generations since the NX100


class InformPositionWriter:
    """Writes the positions of one job. `exact`: as many decimals as give the same numbers when read again."""

    def __init__(self, points: PointTable, exact: bool, old: bool) -> None:
        self.points = points
        self.exact = exact
        self.old = old  # ERC: three digits, no position types, four counts, E for stations
        self._written: dict[str, str] = {}

    def counts(self) -> str:
        """What ///NPOS says: the number of rows of each family."""
        sizes = {name: len(self.points.blocks.get(key, ())) for name, key in FAMILIES.items()}
        names = ("C", "EC", "P", "EX") if self.old else tuple(FAMILIES)
        left_out = [name for name in FAMILIES if sizes[name] and name not in names]
        if left_out:
            raise CannotSayError(f"{left_out[0]} positions in a job of the ERC generation")
        return ",".join(str(sizes[name]) for name in names)

    def lines(self) -> Iterator[str]:
        """All rows and state records."""
        for name, key in FAMILIES.items():
            block = self.points.blocks.get(key)
            if block is None or not len(block):
                continue
            starts = [0, *(np.nonzero(np.diff(block.state))[0] + 1).tolist(), len(block)]
            for start, stop in pairwise(starts):
                state = self.points.states[int(block.state[start])]
                yield from self._records(state)
                yield from self._rows(name, block, slice(start, stop), state)
        if self._written.get("LIMIT") == "ON":
            yield "///LIMIT OFF"
        unknown = [
            key for key, block in self.points.blocks.items() if len(block) and key not in FAMILIES.values()
        ]
        if unknown:
            raise CannotSayError(f"a taught position as a {terminology.STORES[unknown[0][0]]}")

    # --- state ------------------------------------------------------------------------------------------

    def _records(self, state: PointState) -> Iterator[str]:
        if state.frame not in _POSTYPES:
            raise CannotSayError(f"positions in {terminology.SYSTEMS.get(state.frame, state.frame)}")
        wanted = {"USER": str(state.user)} if state.user is not None else {}
        wanted["TOOL"] = str(state.tool)
        if not self.old or state.frame not in ("pulse", "joint", "base"):
            wanted["POSTYPE"] = _POSTYPES[state.frame]
        wanted["kind"] = _KIND_RECORDS[state.kind]
        if state.configuration:
            wanted["RCONF"] = self._configuration(state.configuration)
        elif state.kind is PointKind.POSE and "RCONF" in self._written:
            raise CannotSayError("a position without an arm configuration behind one that has it")
        wanted["LIMIT"] = "ON" if state.outside_limits else "OFF"
        for word, value in wanted.items():
            if self._written.get(word, "OFF" if word == "LIMIT" else None) != value:
                self._written[word] = value
                yield f"///{value}" if word == "kind" else f"///{word} {value}"

    def _configuration(self, flags: tuple[int, ...]) -> str:
        filled = flags
        if not self.exact:  # others count turns with their sign, and those of B behind the rest
            filled = tuple(min(abs(flag), 1) for flag in flags[:6])
            filled += flags[6:] if len(flags) == _FLAGS else (0,) * (_FLAGS - len(filled))
        return ",".join(map(str, filled))

    # --- rows -------------------------------------------------------------------------------------------

    def _rows(self, name: str, block: PointBlock, rows: slice, state: PointState) -> Iterator[str]:
        letter = "E" if self.old and name == "EC" else name
        numbers, values = block.numbers[rows].tolist(), block.values[rows]
        angle_decimals = _OLD_ANGLE_DECIMALS if self.old else _ANGLE_DECIMALS
        scale, decimals = _units(block.store, state.kind, values.shape[1], angle_decimals)
        rounded = _rounded(values / scale, decimals) + 0.0  # turns -0 into 0
        plain = np.asarray(~np.isnan(rounded).any(axis=1))
        if self.exact or state.kind is PointKind.PULSE:
            plain &= np.all(rounded * scale == values, axis=1)
        head = f"{letter}%0{3 if self.old else 5}d="
        form = head + ",".join(f"%.{count}f" for count in decimals)
        table = rounded.tolist()
        for number, row, as_it_is, original in zip(numbers, table, plain.tolist(), values, strict=True):
            if as_it_is:
                yield form % (number, *row)
            else:
                yield head % number + self._odd_row(original, scale, decimals)

    def _odd_row(self, values: NDArray[np.float64], scale: NDArray[np.float64], decimals: list[int]) -> str:
        """A row with empty fields or more decimals than usual."""
        texts = [
            "" if value != value else _field(value, unit, count)
            for value, unit, count in zip(values.tolist(), scale.tolist(), decimals, strict=True)
        ]
        while len(texts) > 1 and not texts[-1] and not self.old:
            texts.pop()
        return ",".join(texts)


def _units(
    store: ex.Store, kind: PointKind, width: int, angle_decimals: int
) -> tuple[NDArray[np.float64], list[int]]:
    """SI per written unit, and decimals, of each value of a row."""
    if kind is PointKind.PULSE:
        return np.ones(width), [0] * width
    lengths = (
        width if store is ex.Store.BASE else 3 if kind is PointKind.POSE and store is ex.Store.ROBOT else 0
    )
    scale = np.where(np.arange(width) < lengths, mm, deg)
    return scale, [_LENGTH_DECIMALS if at < lengths else angle_decimals for at in range(width)]


def _rounded(values: NDArray[np.float64], decimals: list[int]) -> NDArray[np.float64]:
    """Each column to its decimals."""
    return np.column_stack([np.round(values[:, at], count) for at, count in enumerate(decimals)])


def _field(value: float, unit: float, at_least: int) -> str:
    """The shortest decimal fraction that reads as `value` again, or the usual one when none does."""
    for count in range(at_least, _MOST_DECIMALS + 1):
        number = round(value / unit, count)
        if number * unit == value:
            return decimal(number, at_least)
    return decimal(round(value / unit, at_least), at_least)
