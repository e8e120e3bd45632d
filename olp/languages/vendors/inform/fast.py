"""Plain move lines without the grammar: a CAM job has 100,000 of them.

`InformMoveLines.read` understands literal MOVJ, MOVL, MOVC and SMOVx lines and gives exactly the statement
that the grammar gives (a test compares the two); whatever else a line holds, it declines, and the grammar reads it.
"""

from __future__ import annotations

import re
from typing import Final

from olp.core import memory_limit
from olp.core.memory_limit import CacheShelf
from olp.ir.expressions import Position, Store, Taught
from olp.ir.program import Blend, BlendKind, Move, MovePart, Path, Speed
from olp.languages.vendors.inform import values

_NUMBER = r"\d{1,9}(?:\.\d{0,9})?"
_NOT_ZERO = r"(?!0+(?:\.0*)?(?![\d.]))"
_POSITION = r"(?:BC|EC|C|L?BP|L?EX|L?P)\d{1,6}"
MOVE_LINE: Final = re.compile(
    rf"(MOV[JLC]|SMOV[LC]) ({_POSITION}(?: {_POSITION})?)"
    rf"(?: (VJ?={_NOT_ZERO}{_NUMBER}))?(?: PL=([0-8]))?(?: {{1,2}}\+MOVJ ({_POSITION}(?: VJ={_NUMBER})?))?"
    r"(?: *//(.*?))?\s*",
    re.ASCII,
)
_PATHS: Final = {"J": Path.JOINT, "L": Path.LINEAR, "C": Path.CIRCULAR}


class InformMoveLines:
    """Reads plain move lines of one file; equal words share one object."""

    def __init__(self) -> None:
        self._targets: dict[str, tuple[Position, ...]] = {}
        self._speeds: dict[str | None, Speed | None] = {None: None}
        self._blends: dict[str | None, Blend | None] = {None: None}
        self._parts: dict[str | None, tuple[MovePart, ...]] = {None: ()}

    def read(self, line: str, number: int) -> Move | None:
        """The move in `line`, or None when it is not plain."""
        match = MOVE_LINE.fullmatch(line)
        if match is None:
            return None
        word, where, spoken, level, second, comment = match.groups()
        if where[0] == "C" and where.isalnum():
            # Nearly every taught point is used once: sharing them would cost more than it saves.
            targets: tuple[Position, ...] = (Taught(Store.ROBOT, int(where[1:])),)
        else:
            targets = self._targets.get(where) or self._find_targets(where)
        try:
            speed, blend, parts = self._speeds[spoken], self._blends[level], self._parts[second]
        except KeyError:
            speed, blend, parts = self._speed(spoken), self._blend(level), self._part(second)
        path = _PATHS[word[-1]]
        if word[0] == "S":
            return Move(number, path, targets, speed, blend, parts, comment or "", coordinated=True)
        return Move(number, path, targets, speed, blend, parts, comment or "")

    def _find_targets(self, text: str) -> tuple[Position, ...]:
        found = tuple(_position(word) for word in text.split(" "))
        self._targets[text] = found
        return found

    def _speed(self, text: str | None) -> Speed | None:
        if text not in self._speeds:
            self._speeds[text] = values.literal_speed(text)
        return self._speeds[text]

    def _blend(self, text: str | None) -> Blend | None:
        if text not in self._blends:
            level = values.quantity(values.number(text), values.LEVEL)
            self._blends[text] = Blend(BlendKind.LEVEL, level)
        return self._blends[text]

    def _part(self, text: str | None) -> tuple[MovePart, ...]:
        if text is not None and text not in self._parts:
            position, _, spoken = text.partition(" ")
            speed = self._speed(spoken) if spoken else None
            self._parts[text] = (MovePart(Path.JOINT, (_position(position),), speed),)
        return self._parts[text]


class RememberedLines(InformMoveLines):
    """The same for a text that was read before: its lines are taken from memory."""

    def __init__(self, shelf: CacheShelf) -> None:
        super().__init__()
        self._shelf = shelf

    def read(self, line: str, number: int) -> Move | None:
        known: Move | None = self._shelf.get(line)
        if known is not None and known.line == number:
            return known
        found = super().read(line, number) if known is None else _on_line(known, number)
        if found is not None:
            self._shelf.put(line, found)
        return found


def _on_line(it: Move, number: int) -> Move:
    """The same plain move on another line."""
    same = (it.path, it.targets, it.speed, it.blend, it.parts, it.comment)
    return Move(number, *same, coordinated=it.coordinated)


def move_lines() -> InformMoveLines:
    """The reader of plain lines for one file."""
    shelf = memory_limit.shelf("inform moves")
    return InformMoveLines() if shelf is None else RememberedLines(shelf)


def _position(word: str) -> Position:
    if word[0] == "C" or word[1] == "C":
        kind = word.rstrip("0123456789")
        return Taught(values.TAUGHT_STORES[kind], int(word[len(kind) :]))
    return values.variable(word)
