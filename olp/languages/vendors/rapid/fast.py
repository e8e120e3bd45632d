"""Plain moves and robtargets without the grammar: a CAM program has 100,000 of them.

`PlainClauses` understands moves whose arguments are names and numbers, and declarations of literal robtargets, and
gives exactly what the grammar gives (a test compares the two); whatever else a clause holds, it declines.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from typing import Final

from olp.core import result_cache
from olp.core.units import mm
from olp.ir import expressions as ex
from olp.ir.points import Sector
from olp.ir.program import Blend, Declare, Move, Path, Speed, Statement
from olp.ir.transformer import edited
from olp.languages.vendors.rapid.literals import (
    UNIT_TOLERANCE,
    ShapeError,
    connected,
    joint_literal,
    quaternion_angles,
)
from olp.languages.vendors.rapid.literals import arm as arm_of
from olp.languages.vendors.rapid.moves import frame_of, named_blend, named_speed, tool_of
from olp.languages.vendors.rapid.names import RapidNames
from olp.languages.vendors.rapid.predefined_data import NOT_CONNECTED, RECORDS, TYPES

# Only words may stand in any letters: lists are matched in half the time where no letter of theirs is changed.
_SOME: Final = r"\[([-+0-9.,eE\s]*+)\]\s*+"
_LIST: Final = rf"\[\s*+{_SOME},\s*+{_SOME}(?:,\s*+{_SOME},\s*+{_SOME})?\]"
MOVE: Final = re.compile(
    rf"((?i:Move[LJC]|MoveAbsJ))\s+(?:(\w+)|{_LIST})\s*,(?:\s*(?:(\w+)|{_LIST})\s*,(?=(?:[^][,]*,){{2}}))?"
    r"\s*(\w+)\s*,\s*(\w+)\s*,\s*(\w+)\s*(?:\\\s*(?i:WObj)\s*:=\s*(\w+)\s*)?;",
)
# Tool and frame, of which there are few different texts in a path, are read by MOVE once for each.
_TO_NAME: Final = re.compile(
    r"((?i:Move(?:[LJ]|AbsJ)))\s++(\w++)\s*+,\s*+(\w++)\s*+,\s*+(\w++)\s*+,([^][,;]*+;)"
)
# What the grammar read of such a move holds for all that differ in their targets alone.
_BEFORE_ALL: Final = re.compile(r"((?i:Move(?:[LJ]|AbsJ)))\s++(\w++)\s*+,([^\n]*;)")
_ROBTARGET: Final = re.compile(
    rf"(?:((?i:LOCAL|TASK))\s+)?((?i:CONST|PERS|VAR))\s+((?i:robtarget))\s+(\w+)\s*:=\s*{_LIST}\s*;"
)
_RECORD: Final = re.compile(
    r"(?:(LOCAL)\s+)?(CONST|PERS|VAR)\s+(speeddata|zonedata)\s+(\w+)\s*:=\s*"
    r"\[((?:\s*(?:TRUE|FALSE|\d{1,9}(?:\.\d{1,9})?)\s*(?:,(?!\s*\])|(?=\])))+)\]\s*;",
    re.IGNORECASE | re.ASCII,
)
_PATHS: Final = {"l": Path.LINEAR, "j": Path.JOINT, "c": Path.CIRCULAR}
_WORDS: Final = frozenset({"pi", "high", "low", "true", "false"})
_STORAGE: Final = {"C": "constant", "P": "persistent", "V": "variable"}
_MOST: Final = 10_000  # texts that are remembered
_Speed = tuple[Speed, ex.Quantity | None]  # with the bound on the tool's turning
_Systems = tuple[ex.Expression | None, ex.Expression | None]  # tool and frame
# arm flags, quarters of axes, what is written back, further axes
_Arm = tuple[tuple[int, ...], tuple[Sector, ...], tuple[tuple[str, str], ...], tuple[float, ...]]


@lru_cache(maxsize=_MOST)
def _value(text: str) -> ex.SignalState | ex.Number:
    word = text.lower()
    if word in ("true", "false"):
        return ex.SignalState(word == "true")
    return ex.Number(float(text) if "." in text else int(text))


def _moved(
    line: int,
    word: str,
    target: ex.Expression,
    speed: _Speed,
    blend: Blend,
    systems: _Systems,
    comment: str,
    via: ex.Expression | None = None,
) -> Move:
    tool, frame = systems
    path = Path.JOINT if len(word) > 5 else _PATHS[word[-1].lower()]
    return Move(
        line, path, (target,), speed[0], blend, (), comment, via=via, turn=speed[1], tool=tool, frame=frame
    )


class PlainClauses:
    """Reads plain clauses of one file; equal words share one object."""

    def __init__(self, names: RapidNames) -> None:
        self._names = names
        self._shelf = result_cache.shelf("rapid robtargets")
        self._moves = result_cache.shelf("rapid moves")
        self._speeds: dict[str, _Speed | None] = {}
        self._blends: dict[str, Blend | None] = {}
        self._named: dict[str, ex.Named | None] = {}
        self._systems: dict[str, _Systems] = {}
        self._alike: dict[
            tuple[str, str], Move
        ] = {}  # word and what follows the target -> the grammar's move
        self._numbers: dict[str, tuple[float, ...] | None] = {}
        self._arms: dict[tuple[str, str], _Arm | None] = {}

    def forget(self) -> None:
        """Names mean something else: another routine begins."""
        for cache in (self._speeds, self._blends, self._named, self._systems, self._alike):
            cache.clear()

    def move(self, text: str, line: int, comment: str) -> Move | None:
        """The move in a clause, or None when it is not plain."""
        plain = _TO_NAME.fullmatch(text)
        if plain is not None:
            word, name, spoken, zone, rest = plain.groups()
            systems = self._systems.get(rest)
            if systems is not None:
                target = self._named.get(name) or self._name(name)
                speed = self._speeds.get(spoken) or self._speed(spoken)
                blend = self._blends.get(zone) or self._blend(zone)
                if target is None or speed is None or blend is None:
                    return None
                return _moved(line, word, target, speed, blend, systems, comment)
        found = self._examined(text, line, comment)
        if found is None:
            return self._as_another(text, line, comment) if self._alike else None
        if plain is not None and len(self._systems) < _MOST:
            self._systems[plain[5]] = found.tool, found.frame
        return found

    def learn(self, text: str, found: Sequence[Statement]) -> None:
        """Remember what the grammar `found` in a clause, for moves that differ from it in the target alone."""
        shape = _BEFORE_ALL.fullmatch(text)
        if shape is None or len(found) != 1 or len(self._alike) >= _MOST:
            return
        one, (word, name, rest) = found[0], shape.groups()
        if type(one) is Move and one.targets == (self._name(name),):
            self._alike[word, rest] = one

    def _as_another(self, text: str, line: int, comment: str) -> Move | None:
        shape = _BEFORE_ALL.fullmatch(text)
        if shape is None:
            return None
        word, name, rest = shape.groups()
        known = self._alike.get((word, rest))
        target = None if known is None else self._name(name)
        if known is None or target is None:
            return None
        return edited(known, {"line": line, "targets": (target,), "comment": comment})

    def _examined(self, text: str, line: int, comment: str) -> Move | None:
        groups = None if self._moves is None else self._moves.get(text)
        if groups is None:
            match = MOVE.fullmatch(text)
            if match is None:
                return None
            groups = match.groups()
            if self._moves is not None:
                self._moves.put(text, groups)
        (word, name, *literal, via_name, via1, via2, via3, via4, spoken, zone, tool_name, frame_name) = groups
        circular = word[-1] in "cC"
        if circular != (via_name is not None or via1 is not None):
            return None
        target = self._target(word, name, literal)
        via = self._target(word, via_name, [via1, via2, via3, via4]) if circular else None
        tool = self._name(tool_name)
        frame = ex.FrameRef("base") if frame_name is None else self._name(frame_name)
        speed = self._speeds.get(spoken) or self._speed(spoken)
        blend = self._blends.get(zone) or self._blend(zone)
        if target is None or speed is None or blend is None or tool is None or frame is None:
            return None
        if circular:
            if via is None:
                return None
            target, via = via, target
        return _moved(line, word, target, speed, blend, (tool_of(tool), frame_of(frame)), comment, via)

    def point(self, text: str, line: int, comment: str) -> Declare | None:
        """The declaration of a literal robtarget, speed or zone, or None when it is not plain."""
        match = _ROBTARGET.fullmatch(text)
        if match is None:
            return self._record(text, line, comment)
        scope, storage, kind, name, place, turn, arm, axes = match.groups()
        if arm is None:
            return None
        value = self._robtarget(place, turn, arm, axes)
        if value is None:
            return None
        native = f"TASK {kind}" if scope and scope.upper() == "TASK" else kind
        return Declare(
            line,
            self._names.spelled(name),
            "position",
            value,
            (),
            _STORAGE[storage[0].upper()],
            not scope or scope.upper() != "LOCAL",
            native,
            comment,
        )

    def _record(self, text: str, line: int, comment: str) -> Declare | None:
        """A speed or a zone: of those that olp or a CAM system writes there are hundreds."""
        match = _RECORD.fullmatch(text)
        if match is None:
            return None
        scope, storage, kind, name, listed = match.groups()
        key = kind.lower()
        if key in self._names.records or key in self._names.aliases:
            return None
        values = [_value(one.strip()) for one in listed.split(",")]
        members = RECORDS[key]
        words = ["bool" if type(one) is ex.SignalState else "num" for one in values]
        if words != [word for _, word in members]:
            return None
        named = zip((member for member, _ in members), values, strict=True)
        return Declare(
            line,
            self._names.spelled(name),
            TYPES[key],
            ex.RecordLiteral(key, tuple(named)),
            (),
            _STORAGE[storage[0].upper()],
            not scope,
            kind,
            comment,
        )

    def _target(self, word: str, name: str | None, literal: list[str | None]) -> ex.Expression | None:
        if name is not None:
            return self._name(name)
        first, second, arm, axes = literal
        if first is None or second is None:
            return None
        if len(word) > 5:
            return None if arm is not None else self._jointtarget(first, second)
        return None if arm is None or axes is None else self._robtarget(first, second, arm, axes)

    def _robtarget(self, place: str, turn: str, arm: str, axes: str) -> ex.PositionLiteral | None:
        shelf, key = self._shelf, (place, turn, arm, axes)
        if shelf is None:
            return self._read_robtarget(place, turn, arm, axes)
        known = shelf.get(key)
        if known is None:
            before, self._names.uneven = self._names.uneven, False
            known = self._read_robtarget(place, turn, arm, axes), self._names.uneven
            self._names.uneven |= before
            shelf.put(key, known)
        elif known[1]:
            self._names.uneven = True
        found: ex.PositionLiteral | None = known[0]
        return found

    def _read_robtarget(self, place: str, turn: str, arm: str, axes: str) -> ex.PositionLiteral | None:
        try:
            x, y, z = map(float, place.split(","))
            xyz = (x * mm, y * mm, z * mm)
            w, a, b, c = map(float, turn.split(","))
            angles = quaternion_angles(w, a, b, c)
        except (ValueError, ShapeError):
            return None
        key = arm, axes
        how = self._arms[key] if key in self._arms else self._arm(key)
        if how is None or not abs(xyz[0]) + abs(xyz[1]) + abs(xyz[2]) < NOT_CONNECTED:
            return None
        if not abs(w * w + a * a + b * b + c * c - 1.0) < UNIT_TOLERANCE:
            self._names.uneven = True
        flags, sectors, native, external = how
        return ex.PositionLiteral(
            "pose", (*xyz, *angles), external, flags, (("orient", turn), *native), sectors
        )

    def _arm(self, texts: tuple[str, str]) -> _Arm | None:
        """What a robtarget holds besides its pose: few different ones in a path."""
        configuration, external = self._some(texts[0], 4), self._some(texts[1], 6)
        if len(self._arms) > _MOST:
            self._arms.clear()
        found: _Arm | None = None
        if configuration is not None and external is not None:
            found = (*arm_of(configuration), connected(external))
        self._arms[texts] = found
        return found

    def _jointtarget(self, axes: str, more: str) -> ex.PositionLiteral | None:
        try:
            values = tuple(map(float, axes.split(",")))
        except ValueError:
            return None
        external = self._some(more, 6)
        if len(values) != 6 or external is None or not all(abs(v) < NOT_CONNECTED for v in values):
            return None
        return joint_literal(values, external)

    def _some(self, text: str, count: int) -> tuple[float, ...] | None:
        """Few different texts: arm configurations and external axes."""
        if text not in self._numbers:
            try:
                values: tuple[float, ...] | None = tuple(map(float, text.split(",")))
            except ValueError:
                values = None
            # nan and inf are words for float and none for the grammar.
            plain = values is not None and len(values) == count and all(abs(v) < 1e12 for v in values)
            if len(self._numbers) > _MOST:
                self._numbers.clear()
            self._numbers[text] = values if plain else None
        return self._numbers[text]

    def _name(self, text: str) -> ex.Named | None:
        if text in self._named:
            return self._named[text]
        names, key = self._names, text.lower()
        known = key in names.types or key in names.local or names.bus_of(text) is None
        known = known and key not in _WORDS and not text[0].isdigit()
        found = ex.Named(names.spelling.setdefault(key, text)) if known else None
        if len(self._named) < 200_000:
            self._named[text] = found
        return found

    def _speed(self, text: str) -> _Speed | None:
        self._speeds[text] = named_speed(text, self._names)
        return self._speeds[text]

    def _blend(self, text: str) -> Blend | None:
        self._blends[text] = named_blend(text, self._names)
        return self._blends[text]
