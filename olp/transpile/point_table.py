"""Tables of points for the languages that number them."""

from __future__ import annotations

import numpy as np

from olp.ir.expressions import FrameRef, Number, PositionLiteral, Store
from olp.ir.points import PointBlock, PointKind, PointState, PointTable
from olp.ir.program import Move

Place = tuple[int, int | None]  # tool, user frame (None: base)


def table(rows: list[tuple[bool, int, PositionLiteral, Place]]) -> PointTable:
    """A point table of (taught, number, value, place)."""
    states: list[PointState] = []
    blocks: dict[tuple[Store, bool], PointBlock] = {}
    configured = any(literal.configuration for _, _, literal, _ in rows)
    for taught in (True, False):
        own = [row for row in rows if row[0] is taught]
        if not own:
            continue
        width = max(6, *{len(literal.values) for _, _, literal, _ in own})
        whole = all(len(literal.values) == width for _, _, literal, _ in own)
        values = np.full((len(own), width), np.nan)
        if whole:
            values[:] = [literal.values for _, _, literal, _ in own]
        kinds = []
        known: dict[tuple[str, tuple[int, ...], Place], int] = {}
        for at, (_, _, literal, place) in enumerate(own):
            if not whole:
                values[at, : len(literal.values)] = literal.values
            key = (literal.kind, literal.configuration, place)
            kind = known.get(key)
            if kind is None:
                state = _state(literal, place, configured)
                if state not in states:
                    states.append(state)
                kind = known[key] = states.index(state)
            kinds.append(kind)
        for at in np.nonzero(np.isnan(values).any(axis=1))[0].tolist():
            # What is not written is nothing; behind a row's end the table stays empty.
            literal = own[at][2]
            values[at, : len(literal.values)] = _values(literal)
        found = np.array([number for _, number, _, _ in own], dtype=np.int64)
        blocks[(Store.ROBOT, taught)] = PointBlock(
            Store.ROBOT,
            taught,
            found,
            values,
            np.array(kinds, dtype=np.int32),
            np.zeros(len(own), dtype=np.int32),
            {n: at for at, n in enumerate(found.tolist())},
        )
    return PointTable(tuple(states), blocks)


def _values(literal: PositionLiteral) -> list[float]:
    return [0.0 if v != v else v for v in literal.values]


def _state(literal: PositionLiteral, place: Place, configured: bool) -> PointState:
    tool, user = place
    if literal.kind == "joint":
        return PointState(PointKind.JOINT, "joint", None, tool)
    # INFORM's arm flags hold until others are written: with one configuration in a job all have one.
    flags = literal.configuration or ((0,) * 6 if configured else ())
    return PointState(PointKind.POSE, "base" if user is None else "user", user, tool, flags)


def place_of(s: Move) -> Place:
    """The tool and the frame of a move by their numbers."""
    tool, frame = s.tool, s.frame
    number = int(tool.number.value) if type(tool) is FrameRef and type(tool.number) is Number else 0
    if type(frame) is FrameRef and frame.kind == "user" and type(frame.number) is Number:
        return number, int(frame.number.value)
    return number, None
