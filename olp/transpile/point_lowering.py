"""Taught points become named positions: each with its numbers, and its frame and tool for the moves that go there."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from olp.core.diagnostic import OlpError
from olp.core.units import deg, mm
from olp.ir.expressions import Expression, FrameRef, Named, Number, PositionLiteral, Store
from olp.ir.points import Point, PointKind, PointState
from olp.ir.program import Declare, Routine
from olp.transpile.context import TranslationContext

_POSE = 6
_LETTERS = {Store.ROBOT: "P", Store.BASE: "BP", Store.STATION: "EP"}


@dataclass(slots=True)
class Points:
    """The named positions made so far. `states`: what holds for each of them, for the moves that go there."""

    work: TranslationContext
    names: dict[tuple[str, Store, bool, int], str] = field(default_factory=dict)
    states: dict[str, PointState] = field(default_factory=dict)
    declared: list[Declare] = field(default_factory=list)
    found: dict[tuple[str, Store], dict[int, Point]] = field(
        default_factory=dict
    )  # the taught points of a routine
    stands: bool | None = None  # whether no point moves a station, once it was asked

    def station_stands(self) -> bool:
        """Whether all points of stations, in all routines, are one and the same."""
        if self.stands is None:
            found = [r.points.blocks.get((Store.STATION, True)) for r in self.work.source.routines]
            rows = [tuple(row) for block in found if block is not None for row in block.values.tolist()]
            self.stands = all(row == rows[0] for row in rows)
        return self.stands

    def point(self, routine: Routine, store: Store, number: int) -> Point | None:
        """A taught point; all of a routine are taken out of their columns at once."""
        known = self.found.get((routine.name, store))
        if known is None:
            known = self.found[(routine.name, store)] = {}
            block = routine.points.blocks.get((store, True))
            if block is not None:
                states, kinds = routine.points.states, block.state.tolist()
                values, lines = block.values.tolist(), block.lines.tolist()
                for at, row in block.rows.items():
                    known[at] = Point(at, tuple(values[row]), states[kinds[row]], lines[row])
        return known.get(number)

    def taught(self, routine: Routine, store: Store, number: int) -> Named | None:
        """The name of a taught point, None where the routine does not teach it or its place is not known."""
        key = (routine.name, store, True, number)
        name = self.names.get(key)
        if name is None:
            point = self.point(routine, store, number)
            literal = None if point is None else self.literal(routine, point, store)
            if point is None or literal is None:
                return None
            stem = _point_name(store, number)
            name = self.names[key] = self.add(stem, literal, point.state, point.line)
            self.work.names[("point", f"{routine.name}.{stem}")] = name
        return Named(name)

    def add(self, stem: str, literal: PositionLiteral, state: PointState, line: int) -> str:
        """Declares a position; its name begins with `stem`."""
        name = self.work.fresh(stem)
        self.states[name] = state
        kind = "joints" if literal.kind == "joint" else "position"
        storage = "constant" if not line or not self.work.conventions.taught_frames else "variable"
        self.declared.append(Declare(0, name, kind, literal, storage=storage, shared=True))
        return name

    def literal(self, routine: Routine, point: Point, store: Store) -> PositionLiteral | None:
        """The numbers of a point; pulses need the robot. None where they cannot be known."""
        values = tuple(point.values)
        state = point.state
        if store is not Store.ROBOT:
            return PositionLiteral("joint", _trimmed(values)) if state.kind is not PointKind.PULSE else None
        if state.kind is PointKind.POSE:
            further = self._further(routine, values) if len(values) > _POSE else ()
            return PositionLiteral(
                "pose", values[:_POSE], further, state.configuration, sectors=state.sectors
            )
        if state.kind is PointKind.JOINT:
            if self.work.conventions.wrist_target_axes and len(values) > _POSE:
                return PositionLiteral("joint", _trimmed(values[:_POSE]), self._further(routine, values))
            return PositionLiteral("joint", _trimmed(values))
        return self._joints_of(values)

    def _further(self, routine: Routine, values: tuple[float, ...]) -> tuple[float, ...]:
        """What follows the six values of a position, as written: an external axis in mm or deg, or a seventh axis."""
        group = routine.details.get("group 1", "1")
        units = (routine.details.get(f"unit GP{group} E{n}", "deg") for n in range(1, len(values)))
        found = [v / (mm if unit == "mm" else deg) for v, unit in zip(values[_POSE:], units, strict=False)]
        while found and found[-1] != found[-1]:
            found.pop()
        return tuple(found)

    def _joints_of(self, pulses: tuple[float, ...]) -> PositionLiteral | None:
        robot = self.work.robot
        if robot is None:
            self.work.need_robot(
                None, "the points are written in motor pulses, which mean nothing without their robot"
            )
            return None
        from olp.robots.kinematics import pulses_to_joints

        row = np.nan_to_num(np.asarray(pulses[: len(robot.axes)], dtype=np.float64))
        row = np.concatenate((row, np.zeros(len(robot.axes) - len(row))))
        try:
            return PositionLiteral("joint", tuple(float(v) for v in pulses_to_joints(robot, row[None, :])[0]))
        except OlpError as problem:
            self.work.need_robot(None, problem.diagnostics[0].message)
            return None

    def in_space(
        self, routine: Routine, store: Store, number: int
    ) -> tuple[PositionLiteral, PointState] | None:
        """A point taught in joints as a pose of its tool in the base, for moves that need one."""
        point = routine.points.find(store, True, number)
        if point is None or self.work.robot is None:
            return None
        pose = self.work.cell().pose(0, point.state, point.values)
        if pose is None:
            return None
        state = PointState(PointKind.POSE, "base", tool=point.state.tool)
        return PositionLiteral("pose", tuple(float(v) for v in pose.xyz_angles())), state


def frame_of(state: PointState) -> Expression | None:
    """The frame that a position with this state is written in, None where it says none."""
    if state.kind is not PointKind.POSE:
        return FrameRef("base")
    if state.frame == "user":
        return None if state.user is None else _user(state.user)
    return FrameRef("base") if state.frame in ("base", "robot") else FrameRef(state.frame)


def tool_of(state: PointState) -> Expression | None:
    """The tool that a position with this state was taught with, None where it says none (FANUC UT : F)."""
    return _tool(state.tool) if state.tool >= 0 else None


@lru_cache(maxsize=1000)
def _user(number: int) -> FrameRef:
    return FrameRef("user", Number(number))


@lru_cache(maxsize=1000)
def _tool(number: int) -> FrameRef:
    return FrameRef("tool", Number(number))


def _trimmed(values: tuple[float, ...]) -> tuple[float, ...]:
    kept = list(values)
    while kept and math.isnan(kept[-1]):
        kept.pop()
    return tuple(0.0 if math.isnan(v) else v for v in kept)


def _point_name(store: Store, number: int) -> str:
    return f"{_LETTERS.get(store, 'P')}{number}"
