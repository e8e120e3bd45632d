"""Plain move lines without the grammar: a CAM program has 100,000 of them.

`TpMoveLines.read` understands J, L and A moves with literal numbers and gives exactly the statement that the grammar
gives (a test compares the two); whatever else a line holds, it declines, and the grammar reads it.
"""

from __future__ import annotations

import re
from typing import Final

from olp.core.units import mm
from olp.ir.expressions import Number, Quantity, Store, Taught
from olp.ir.program import Blend, Move, Path, Speed
from olp.languages.vendors.tp import values
from olp.languages.vendors.tp.moves import WELD_SPEED, kept

_NUMBER = r"(?!0+(?:\.0*)?(?![\d.]))\d{1,9}(?:\.\d{1,9})?"
_CORNER = r"FINE|CNT\d{1,3}|C[RD]\d{1,4}(?:\.\d{1,6})?"
MOVE_LINE: Final = re.compile(
    r"([JLA]) {1,4}P\[(\d{1,6})(?::[^\]]*)?\] {1,4}"
    rf"({_NUMBER}(?:%|mm/sec|cm/min|inch/min|deg/sec|msec|sec)|WELD_SPEED) {{1,4}}({_CORNER})"
    r"(?: {1,4}ACC(\d{1,3}))?((?: {1,4}(?:COORD|PTH|RTCP|BREAK))*)\s*",
    re.ASCII,
)
_SPEED: Final = re.compile(r"([\d.]+)(.*)")


class TpMoveLines:
    """Reads plain move lines of one file; equal words share one object."""

    def __init__(self) -> None:
        self._speeds: dict[str, Speed] = {}
        self._blends: dict[str, Blend] = {"FINE": values.FINE}
        self._rates: dict[str | None, Quantity | None] = {None: None}
        self._others: dict[str, tuple[tuple[str, object], ...]] = {"": ()}

    def read(self, text: str, number: int) -> Move | None:
        """The move in `text`, or None when it is not plain."""
        match = MOVE_LINE.fullmatch(text)
        if match is None:
            return None
        letter, point, spoken, corner, rate, other = match.groups()
        try:
            speed, blend = self._speeds[spoken], self._blends[corner]
        except KeyError:
            speed, blend = self._speed(spoken), self._blend(corner)
        targets = (Taught(Store.ROBOT, int(point)),)
        path = values.PATHS[letter]
        if rate is None and not other:
            return Move(number, path, targets, speed, blend)
        return self._with_options(number, path, targets, speed, blend, rate, other)

    def _with_options(
        self,
        number: int,
        path: Path,
        targets: tuple[Taught],
        speed: Speed,
        blend: Blend,
        rate: str | None,
        other: str,
    ) -> Move:
        if rate not in self._rates:
            self._rates[rate] = Quantity(Number(int(rate or 0)), values.PERCENT)
        if other not in self._others:
            self._others[other] = tuple(kept(word).value for word in other.split())
        words = self._others[other]
        return Move(number, path, targets, speed, blend, acceleration=self._rates[rate], other=words)  # type: ignore[arg-type]

    def _speed(self, text: str) -> Speed:
        if text not in self._speeds:
            if text == "WELD_SPEED":
                unit, scale = values.UNITS["mm/sec"]
                self._speeds[text] = Speed(unit, Quantity(WELD_SPEED, mm), text)
            else:
                match = _SPEED.fullmatch(text)
                assert match is not None
                unit, scale = values.UNITS[match[2]]
                self._speeds[text] = Speed(unit, Quantity(Number(values.number(match[1])), scale))
        return self._speeds[text]

    def _blend(self, text: str) -> Blend:
        if text not in self._blends:
            word = "CNT" if text[1] == "N" else text[:2]
            kind, scale = values.CORNERS[word]
            size = Quantity(Number(values.number(text[len(word) :])), scale)
            self._blends[text] = Blend(kind, size, "" if word == "CNT" else word)
        return self._blends[text]
