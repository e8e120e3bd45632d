"""Speeds, zones, tool0 and wobj0 as values: where they are passed on instead of named by a move."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from olp.ir.expressions import Expression, Number, PositionLiteral, RecordLiteral, SignalState, Text
from olp.languages.vendors.rapid.predefined_data import RECORDS, SPEEDS, ZONES

_HERE: Final = PositionLiteral("pose", (0.0,) * 6)


def _number(value: float) -> Number:
    return Number(int(value) if value == int(value) else value)


def _record(kind: str, values: tuple[Expression, ...]) -> RecordLiteral:
    names = (name for name, _ in RECORDS[kind])
    return RecordLiteral(kind, tuple(zip(names, values, strict=True)))


_COG: Final = PositionLiteral("pose", (0.0, 0.0, 1e-6, 0.0, 0.0, 0.0))
_LOAD: Final = _record("loaddata", (_number(0.001), _COG, _HERE, _number(0), _number(0), _number(0)))
PREDEFINED: Final[Mapping[str, RecordLiteral]] = {
    **{name: _record("speeddata", tuple(map(_number, values))) for name, values in SPEEDS.items()},
    **{
        name: _record("zonedata", (SignalState(zone.fine), *map(_number, zone.values)))
        for name, zone in ZONES.items()
    },
    "tool0": _record("tooldata", (SignalState(True), _HERE, _LOAD)),
    "wobj0": _record("wobjdata", (SignalState(False), SignalState(True), Text(""), _HERE, _HERE)),
    "load0": _LOAD,
}
PREDEFINED_NAMES: Final[Mapping[tuple[str, tuple[tuple[str, Expression], ...]], str]] = {
    (value.type, value.members): name for name, value in PREDEFINED.items() if name not in ("vmax", "load0")
}
