"""Moves to taught points become moves to names, each with the frame and the tool that the point was taught with."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import chain
from typing import Any, Final

import numpy as np

from olp.core.diagnostic import OlpError
from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir.points import Point, PointKind, PointState
from olp.ir.program import Assign, Declare, Move, Path, Program, Routine, ShiftOn, Statement, Update
from olp.ir.transformer import calls_nothing, edited, expressions_of, is_usual, is_written_out
from olp.robots.coordinate_systems import ASSUMED_PULSES
from olp.runtime.folder import KIND_PREFIX, mechanism_name
from olp.transpile.context import PROCESS, Fate, TranslationContext
from olp.transpile.reaching_definitions import UNSET, Key, Reaching, reaching

Value = Callable[[Any], Any]  # of whatever holds expressions
_VALUES: Final = (
    "speed",
    "blend",
    "acceleration",
    "deceleration",
    "rate",
    "turn",
    "until",
    "search",
    "offset",
    "tool_offset",
    "other",
)
_MOVING: Final = ("tool", "master-tool")
_TOOL: Final[Key] = ("tool",)


def relative_tools(program: Program, work: TranslationContext) -> Program:
    """Moves by an offset with the tool of the taught move before, which is the one that holds there."""
    relative = [
        (r, index, s)
        for r in program.routines
        for index, s in enumerate(r.body)
        if type(s) is Move and s.relative is not None and s.tool is None
    ]
    if not relative or not work.conventions.taught_frames:
        return program
    tools: list[ex.Expression] = []

    def taught(s: Statement) -> Mapping[Key, int]:
        if type(s) is not Move or s.tool is None:
            return {}
        if s.tool not in tools:
            tools.append(s.tool)
        return {_TOOL: tools.index(s.tool)}

    ways = reaching(program, taught, frozenset({Move}))
    changed: dict[str, dict[int, Move]] = {}
    for r, index, s in relative:
        found = ways.at(r.name, index, _TOOL)
        held = {at for at in found if at >= 0}
        if len(held) == 1:
            changed.setdefault(r.name, {})[index] = edited(s, _systems(s, tools[held.pop()]))
        elif held:
            work.lose(s, Fate.REFUSED, "frame", "a move by an offset behind moves with different tools")
        if UNSET in found:
            work.lose(
                s, Fate.APPROXIMATED, "frame", "a move by an offset may run before any move that names a tool"
            )
    routines = tuple(
        replace(r, body=tuple(changed[r.name].get(at, s) for at, s in enumerate(r.body)))
        if r.name in changed
        else r
        for r in program.routines
    )
    return replace(program, routines=routines)


_System = tuple[ex.Expression | None, ex.Expression | None]  # tool, frame
_HERE: Final = "where the arm stands"


def carried_systems(
    program: Program,
    states: Mapping[str, PointState],
    rows: Mapping[str, set[PointState]],
    work: TranslationContext,
) -> Program:
    """Moves to position variables with the tool and the frame of what the variable was last set to.

    `states`: of all positions; `rows`: of the variables that begin with a position.
    """
    if not work.conventions.taught_frames:
        return program
    return _CarriedSystems(program, states, rows, work).followed()


@dataclass(slots=True)
class _CarriedSystems:
    program: Program
    states: Mapping[str, PointState]
    rows: Mapping[str, set[PointState]]
    work: TranslationContext
    assigned: dict[str, list[Assign]] = field(default_factory=dict)
    several: set[str] = field(default_factory=set)  # variables that are set with one system or another
    setting: list[tuple[str, int, Statement]] = field(default_factory=list)  # routine, place
    numbers: dict[int, int] = field(default_factory=dict)  # of these, by their ids
    ways: Reaching = field(default_factory=Reaching)

    def followed(self) -> Program:
        for r in self.program.routines:
            for s in r.body:
                if type(s) is Assign and (name := _variable(s.target)) is not None:
                    self.assigned.setdefault(name, []).append(s)
        found: dict[str, set[object]] = {name: set() for name in self.assigned}
        for name, begins in self.rows.items():
            found.setdefault(name, set()).update(map(_system, begins))
        grows = True
        while grows:
            before = sum(map(len, found.values()))
            for name, ways in self.assigned.items():
                for s in ways:
                    found[name] |= self._at_all(s.value, found)
            grows = sum(map(len, found.values())) > before
        self.several = {name for name, systems in found.items() if _HERE in systems or len(systems) > 1}
        moves = [
            (r.name, at, s)
            for r in self.program.routines
            for at, s in enumerate(r.body)
            if type(s) is Move and s.relative is None and _variable(s.targets[0]) in self.several
        ]
        if not moves:
            return self.program
        self.setting = [
            (r.name, at, s)
            for r in self.program.routines
            for at, s in enumerate(r.body)
            if type(s) in (Move, Assign)
        ]
        self.numbers = {id(s): number for number, (_, _, s) in enumerate(self.setting)}
        self.ways = reaching(self.program, self._sets, frozenset({Move, Assign}))
        changed = {(name, at): self._move(name, at, s) for name, at, s in moves}
        routines = tuple(
            replace(r, body=tuple(changed.get((r.name, at), s) for at, s in enumerate(r.body)))
            for r in self.program.routines
        )
        return replace(self.program, routines=routines)

    def _at_all(self, source: ex.Expression, found: Mapping[str, set[object]]) -> set[object]:
        """Every system that what a variable is set to may have, as long as the order of statements is not asked."""
        source = _first_factor(source)
        if _is_read(source):
            return {_HERE}
        name = _variable(source)
        if name is None:
            return set()
        if name in found:
            return found[name]
        return {_system(self.states[name])} if name in self.states else set()

    def _sets(self, s: Statement) -> Mapping[Key, int]:
        keys: list[Key] = [_TOOL] if type(s) is Move else []
        if type(s) is Assign and isinstance(s.target, ex.Named) and s.target.name in self.several:
            keys.append(("systems", s.target.name))
        return dict.fromkeys(keys, self.numbers[id(s)]) if keys else {}

    def _move(self, routine: str, at: int, s: Move) -> Move:
        found = self._target(routine, at, s.targets[0], frozenset())
        if len(found) > 1:
            says = "the position is set with several tools or frames, and this move may get each of them"
            self.work.lose(s, Fate.REFUSED, "frame", says)
        if len(found) != 1:
            return s
        (tool, frame), changes = next(iter(found)), {}
        if tool is not None:
            changes["tool"] = tool
        if frame is not None:
            changes["frame"] = frame
        return edited(s, changes)

    def _target(self, routine: str, at: int, e: ex.Expression, seen: frozenset[int]) -> set[_System]:
        """The systems that a position may have where this statement is."""
        e, name = _first_factor(e), _variable(_first_factor(e))
        if _is_read(e):
            return {(tool, ex.FrameRef("base")) for tool in self._tools(routine, at, seen)}
        if name is None:
            return set()
        if name not in self.several:
            return {_system(self.states[name])} if name in self.states else set()
        begins = set(map(_system, self.rows.get(name, ())))
        if not isinstance(e, ex.Named):  # an element: which one is not followed
            found = (self.numbers[id(s)] for s in self.assigned.get(name, ()))
            return begins.union(*(self._assigned(number, seen) for number in found))
        systems: set[_System] = set()
        for number in self.ways.at(routine, at, ("systems", name)):
            systems |= begins if number == UNSET else self._assigned(number, seen)
        return systems

    def _assigned(self, number: int, seen: frozenset[int]) -> set[_System]:
        routine, at, s = self.setting[number]
        assert type(s) is Assign
        return set() if number in seen else self._target(routine, at, s.value, seen | {number})

    def _tools(self, routine: str, at: int, seen: frozenset[int]) -> set[ex.Expression | None]:
        """The tools that the arm may hold where this statement is."""
        tools: set[ex.Expression | None] = set()
        for number in self.ways.at(routine, at, _TOOL):
            if number == UNSET:
                continue
            name, place, s = self.setting[number]
            assert type(s) is Move
            if _variable(s.targets[0]) in self.several and s.relative is None:
                if number not in seen:
                    found = self._target(name, place, s.targets[0], seen | {number})
                    tools |= {tool for tool, _ in found}
            elif s.tool is not None:
                tools.add(s.tool)
        return tools or {_tool(0)}


def _first_factor(e: ex.Expression) -> ex.Expression:
    return e.arguments[0] if isinstance(e, ex.Function) and e.name == "pose-product" else e


def _is_read(e: ex.Expression) -> bool:
    """Whether this is where the arm stands."""
    return isinstance(e, (ex.Function, ex.SystemValue)) and e.name in ("current-pose", "current-joints")


def _variable(e: ex.Expression) -> str | None:
    base = e.base if isinstance(e, ex.Item) else e
    return base.name if isinstance(base, ex.Named) else None


def _system(state: PointState) -> _System:
    return tool_of(state), frame_of(state)


def _systems(s: Move, tool: ex.Expression) -> dict[str, Any]:
    """The tool of a move by an offset, and the frame in whose directions it counts as its own."""
    relative = s.relative
    assert relative is not None
    if s.frame is not None:
        return {"tool": tool}
    if relative.kind in ("tool", "own"):
        return {"tool": tool, "frame": ex.FrameRef("base")}
    return {"tool": tool, "frame": relative, "relative": ex.FrameRef("own")}


def has_names(s: Move) -> bool:
    """Whether a move goes to a named position, and nothing else of it can be numbered."""
    return type(s.targets[0]) is ex.Named and (is_written_out(s) or _names_systems(s))


def _names_systems(s: Move) -> bool:
    """Whether a move's tool and frame are names, and all else of it but the target numbers that are written out."""
    speed, blend = s.speed, s.blend
    return (
        type(s.tool) is ex.Named
        and type(s.frame) is ex.Named
        and len(s.targets) == 1
        and (speed is None or type(speed.value.written) is ex.Number)
        and (blend is None or blend.value is None or type(blend.value.written) is ex.Number)
        and is_usual(s)
    )


def lifted_move(points: Points, routine: Routine, s: Move, value: Value) -> list[Statement]:
    """The move with names; as it was, with a loss, where its target cannot be known."""
    beside: tuple[float, ...] = ()
    if s.parts or len(s.targets) > 1:
        found = _beside(points, routine, s, value)
        if type(found) is str:
            points.work.lose(s, Fate.REFUSED, "groups", found)
            return [s]
        assert type(found) is tuple
        beside = found
        s = edited(s, {"targets": s.targets[:1], "parts": (), "coordinated": False})
    elif points.work.conventions.points_of_groups:
        others = points.of_others(routine)
        if others and any(points.moves_there(routine, store, s.targets[0]) for store in others):
            points.work.lose(s, Fate.APPROXIMATED, PROCESS, _OTHER_GROUPS)
    elif any(map(points.width, _STANDING)):
        points.work.lose(s, Fate.APPROXIMATED, "external", _SAYS_NOTHING)
    if s.passes:
        points.work.lose(s, Fate.APPROXIMATED, "passes", _PASSES)
        s = edited(s, {"passes": ""})
    state = _state(points, routine, s.targets[0], value)
    target = _target(points, routine, s, value, state, beside)
    if target is None:
        return [s]
    via = None
    if s.via is not None:
        via = value(s.via)
        if isinstance(s.via, ex.Taught):
            other = points.taught(routine, s.via.store, s.via.number)
            via = other if other is not None else via
    name, state = target
    changes: dict[str, Any] = {"via": via} if via is not None else {}
    if name is not s.targets[0]:
        changes["targets"] = (name,)
    for part in () if is_written_out(s) else ("speed", "blend") if is_usual(s) else _VALUES:
        old = getattr(s, part)
        if old is not None:
            new = value(old)
            if new is not old:
                changes[part] = new
    if state is not None and s.relative is None:
        if state.frame in _MOVING:
            points.work.lose(
                s, Fate.REFUSED, "frame", "the position is written in a frame that moves with the arm"
            )
            return [s]
        if s.tool is None:
            changes["tool"] = tool_of(state)
        if s.frame is None:
            changes["frame"] = frame_of(state)
    if None in changes.values():
        changes = {name: new for name, new in changes.items() if new is not None}
    if state is None and s.tool is None and s.relative is None and points.work.conventions.taught_frames:
        says = "in which frame and with which tool this position is meant is not known: base and flange are written"
        points.work.lose(s, Fate.APPROXIMATED, "frame", says)
    return [edited(s, changes) if changes else s]


def framed_shift(points: Points, s: ShiftOn, value: Value) -> ShiftOn:
    """A shift that names no frame with that of the variable: in its directions the targets are moved."""
    offset = value(s.offset)
    base = offset.base if isinstance(offset, ex.Item) else offset
    state = points.states.get(base.name) if isinstance(base, ex.Named) else None
    if state is not None and state.kind is not PointKind.POSE:
        points.work.lose(s, Fate.REFUSED, "shift", "a shift by axis values")
    frame = None if state is None else frame_of(state)
    if frame is None:
        says = "in which frame this shift is meant is not known: the base is written"
        points.work.lose(s, Fate.APPROXIMATED, "frame", says)
    return replace(s, frame=frame if isinstance(frame, ex.FrameRef) else ex.FrameRef("base"))


_STANDING: Final = {ex.Store.BASE: "track", ex.Store.STATION: "station"}  # in the order of external axes
_PASSES: Final = "the tag of multi-pass welding is left out: every pass runs as written"
_SET_UP: Final = (
    "set these external axes up, none of which moves the arm's base, and compare a position of each"
)
_NAME_PULSES: Final = (
    "name the files of these in [robots] of olp.toml and translate again, as their pulses are assumed"
)
_PULSES: Final = f"{ASSUMED_PULSES:,.0f} pulses per mm or degree are assumed for an external axis"
_OTHERS: Final = (*_STANDING, ex.Store.SYSTEM)  # groups of a point that are not the arm
_OTHER_GROUPS: Final = "the other control groups of the point move, too, and are left out"
_SAYS_NOTHING: Final = "the move says nothing of external axes that others move"
_CARRIED: Final = "the path and the speed are those over the arm's own base, which the track carries"
_SECOND_ARM: Final = (
    "the moves of the second arm are left out: it needs a program of its own, in step with this one"
)


def _beside(points: Points, routine: Routine, s: Move, value: Value) -> tuple[float, ...] | str:
    """Where a move's track and station stand [mm or deg], those that no point moves left out; or why that is not known.

    Of further arms the first one's move stays, and the others' are told.
    """
    parts = [(number, part.targets) for number, part in enumerate(s.parts, 1) if not _has_arm(part.targets)]
    others = [(number, target) for number, targets in ((0, s.targets[1:]), *parts) for target in targets]
    if not _has_arm(s.targets[:1]) or _has_arm(s.targets[1:]):
        return "a move of several control groups"
    moving: dict[ex.Store, tuple[float, ...]] = {}
    for number, target in others:
        assert isinstance(target, (ex.Taught, ex.Variable))
        store = target.store
        if type(target) is ex.Taught and points.stands_still(store):
            says = f"the {_STANDING[store]} has the same position in all points: its part of the moves is left out"
            points.work.note_once(says)
            continue
        row = points.beside(routine, s, number, target)
        if row is None or store in moving:
            return f"the program does not say where the {_STANDING[store]} goes"
        moving[store] = row
    on_track = any(getattr(target, "store", None) is ex.Store.BASE for _, target in others)
    if on_track and not _is_seen(points, routine, s, value):
        return "the program does not say where the target is for an arm whose base is on a track"
    if s.coordinated and ex.Store.STATION in moving:
        return "a path over the work on a station that turns at the same time"
    if len(parts) < len(s.parts):
        points.work.lose(s, Fate.APPROXIMATED, PROCESS, _SECOND_ARM)
    if ex.Store.BASE in moving and s.path is not Path.JOINT:
        points.work.lose(s, Fate.APPROXIMATED, "external", _CARRIED)
    if any(points.width(store) for store in _STANDING if store not in moving):
        points.work.lose(s, Fate.APPROXIMATED, "external", _SAYS_NOTHING)
    if not moving:
        return ()
    rows = (moving.get(store, (math.nan,) * points.width(store)) for store in _STANDING)
    return tuple(chain.from_iterable(rows))


def _has_arm(targets: tuple[ex.Expression, ...]) -> bool:
    """Whether a position of these is an arm's, or of all groups, and not a track's or a station's alone."""
    return any(
        not isinstance(target, (ex.Taught, ex.Variable)) or target.store not in _STANDING
        for target in targets
    )


def _is_seen(points: Points, routine: Routine, s: Move, value: Value) -> bool:
    """Whether it is known where an arm's own base, which a track carries, has a move's target: what is not carried is
    elsewhere by as much as the track is, in whatever frame does not move with it.
    """
    state = _state(points, routine, s.targets[0], value)
    return state is not None and (state.kind is not PointKind.POSE or state.frame == "robot")


def _state(points: Points, routine: Routine, target: ex.Expression, value: Value) -> PointState | None:
    if isinstance(target, ex.Taught):
        point = points.point(routine, target.store, target.number)
        return None if point is None else point.state
    if isinstance(target, ex.Variable) and points.work.conventions.taught_frames:
        # A position register stands in whatever frame holds.
        name = value(target)
        name = name.base if isinstance(name, ex.Item) else name
        return points.states.get(name.name) if isinstance(name, ex.Named) else None
    return None


def _target(
    points: Points,
    routine: Routine,
    s: Move,
    value: Value,
    state: PointState | None,
    beside: tuple[float, ...] = (),
) -> tuple[ex.Expression, PointState | None] | None:
    """The target with `beside` as its external axes."""
    written = s.targets[0]
    if isinstance(written, (ex.Taught, ex.Variable)) and written.store is not ex.Store.ROBOT:
        points.work.lose(s, Fate.REFUSED, "groups", "a move of a track or a station alone")
        return None
    number = _number_of(points, written)
    if beside and not isinstance(written, ex.Taught):
        points.work.lose(s, Fate.REFUSED, "groups", "a variable as the place of an arm and of external axes")
        return None
    if number is None:
        return value(written), state
    assert isinstance(written, (ex.Taught, ex.Variable))
    if state is not None and state.kind is not PointKind.POSE and s.path is not Path.JOINT:
        seen = points.in_space(routine, written.store, isinstance(written, ex.Taught), number)
        if seen is None and isinstance(written, ex.Variable):
            return value(written), state
        if seen is None:
            points.work.need_robot(s, "a straight move to a point in joint values is known by its robot only")
            return None
        literal, base = seen
        points.tell_tool(s, base.tool)
        key = (routine.name, written.store, isinstance(written, ex.Taught), -1 - number, beside)
        name = points.names.get(key)
        if name is None:
            stem = "P" if isinstance(written, ex.Taught) else "PV"
            literal = replace(literal, external=beside)
            name = points.names[key] = points.add(f"{stem}{number}_pose", literal, base, 0)
        return ex.Named(name), base
    if isinstance(written, ex.Variable):
        return value(written), state
    name_ = points.taught(routine, written.store, written.number, beside)
    if name_ is None:
        points.work.lose(s, Fate.REFUSED, "target", "the point has no values that can be known")
        return None
    return name_, state


def _number_of(points: Points, written: ex.Expression) -> int | None:
    """Of a taught point, or of a variable that holds one and that nothing ever sets."""
    if isinstance(written, ex.Taught):
        return written.number
    if not isinstance(written, ex.Variable) or not isinstance(written.index, ex.Number) or written.local:
        return None
    return None if points.is_set(written) else int(written.index.value)


# --- Point lowering ---
# Taught points become named positions: each with its numbers, and its frame and tool for the moves that go there.

_POSE = 6
_LETTERS = {ex.Store.ROBOT: "P", ex.Store.BASE: "BP", ex.Store.STATION: "EP"}


@dataclass(slots=True)
class Points:
    """The named positions made so far. `states`: what holds for each of them, for the moves that go there."""

    work: TranslationContext
    names: dict[tuple[str, ex.Store, bool, int, tuple[float, ...]], str] = field(default_factory=dict)
    states: dict[str, PointState] = field(default_factory=dict)
    declared: list[Declare] = field(default_factory=list)
    found: dict[tuple[str, ex.Store], dict[int, Point]] = field(
        default_factory=dict
    )  # the taught points of a routine
    changed: set[ex.Variable] | None = None  # variables that statements set, once it was asked
    stands: dict[ex.Store, bool] = field(
        default_factory=dict
    )  # whether no point moves stations or tracks, if asked

    units: dict[ex.Store, tuple[str, ...]] = field(default_factory=dict)  # of their axes: mm or deg
    moved: dict[ex.Store, str] = field(default_factory=dict)  # the mechanism that is external axes
    others: dict[str, tuple[ex.Store, ...]] = field(default_factory=dict)  # see `of_others`, by routine
    widths: dict[ex.Store, int] = field(default_factory=dict)  # external axes of stations and tracks

    def is_set(self, variable: ex.Variable) -> bool:
        """Whether a statement of the program may give a position variable another value."""
        if self.changed is None:
            targets = (e for s in self.work.source.statements() for e in _targets(s))
            self.changed = {e for e in targets if isinstance(e, ex.Variable)}
        return any(
            e.store in (variable.store, ex.Store.SYSTEM)
            and (e.index == variable.index or not isinstance(e.index, ex.Number))
            for e in self.changed
        )

    def stands_still(self, store: ex.Store) -> bool:
        """Whether all points of stations, or of tracks, are one and the same in all routines."""
        if store not in self.stands:
            found = [r.points.blocks.get((store, True)) for r in self.work.source.routines]
            # An axis that a point leaves out (E0=-0.4,,) is nan, which differs from itself.
            rows = (row for block in found if block is not None for row in block.values.tolist())
            self.stands[store] = len({tuple(None if v != v else v for v in row) for row in rows}) <= 1
        return self.stands[store]

    def width(self, store: ex.Store) -> int:
        """How many external axes a track or a station is in positions; 0: it stands still, or there is none."""
        if store not in self.widths:
            found = [r.points.blocks.get((store, True)) for r in self.work.source.routines]
            rows = [row for block in found if block is not None for row in block.values.tolist()]
            count = max((sum(v == v for v in row) for row in rows), default=0)
            self.widths[store] = 0 if self.stands_still(store) else count
        return self.widths[store]

    def of_others(self, routine: Routine) -> tuple[ex.Store, ...]:
        """The kinds of taught points of a routine that are not the arm's."""
        found = self.others.get(routine.name)
        if found is None:
            blocks = routine.points.blocks
            found = self.others[routine.name] = tuple(store for store in _OTHERS if (store, True) in blocks)
        return found

    def moves_there(self, routine: Routine, store: ex.Store, target: ex.Expression) -> bool:
        """Whether a taught point holds a position of another control group, which is not the same in all points."""
        if not isinstance(target, ex.Taught) or (store, True) not in routine.points.blocks:
            return False
        return not self.stands_still(store) and self.point(routine, store, target.number) is not None

    def beside(
        self, routine: Routine, s: Move, part: int, target: ex.Taught | ex.Variable
    ) -> tuple[float, ...] | None:
        """[mm or deg] where a track or a station stands in a taught point; told once how each is to be set up."""
        point = self.point(routine, target.store, target.number) if isinstance(target, ex.Taught) else None
        if point is None:
            return None
        world = self.work.world()
        names = [group.mechanisms for group in routine.groups]
        name = mechanism_name(names, part, target.store) or f"{KIND_PREFIX[target.store]}1"
        if self.moved.setdefault(target.store, name) != name:
            return None  # of two stations, which external axes are which is not told
        at = world.mechanism(name)
        robot = world.cell.robot(at)
        if point.state.kind is PointKind.PULSE and (robot is None or not robot.knows_pulses):
            self.work.ask(_NAME_PULSES, name)
            self.work.lose(s, Fate.APPROXIMATED, "external", _PULSES)
        first = sum(map(self.width, list(_STANDING)[: list(_STANDING).index(target.store)]))
        row = world.cell.beside(at, point.state, point.values)
        self.units[target.store] = world.cell.units(at, len(row))
        units = [self.units.get(store, ("",) * self.width(store)) for store in _STANDING if self.width(store)]
        self.work.external_units = tuple((f"E{n}", unit) for n, unit in enumerate(chain(*units), 1))
        for number, _ in enumerate(row if self.work.limits.external_axes else (), first + 1):
            self.work.ask(_SET_UP, f"{number} ({name})")
        return row

    def point(self, routine: Routine, store: ex.Store, number: int) -> Point | None:
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

    def taught(
        self, routine: Routine, store: ex.Store, number: int, beside: tuple[float, ...] = ()
    ) -> ex.Named | None:
        """The name of a taught point with `beside` as its external axes, None where the routine does not teach it or
        its place is not known.
        """
        key = (routine.name, store, True, number, beside)
        name = self.names.get(key)
        if name is None:
            point = self.point(routine, store, number)
            literal = None if point is None else self.literal(routine, point, store)
            if point is None or literal is None:
                return None
            literal = replace(literal, external=beside) if beside else literal
            stem = _point_name(store, number)
            called = routine.points.names.get(number, "") if store is ex.Store.ROBOT else ""
            # Of other letters a name of any target keeps nothing.
            readable = called and re.search("[A-Za-z]", called)
            name = self.names[key] = self.add(called if readable else stem, literal, point.state, point.line)
            self.work.names[("point", f"{routine.name}.{stem}")] = name
        return ex.Named(name)

    def add(self, stem: str, literal: ex.PositionLiteral, state: PointState, line: int) -> str:
        """Declares a position; its name begins with `stem`."""
        name = self.work.fresh(stem)
        self.states[name] = state
        kind = "joints" if literal.kind == "joint" else "position"
        storage = "constant" if not line or not self.work.conventions.taught_frames else "variable"
        self.declared.append(Declare(line, name, kind, literal, storage=storage, shared=True))
        return name

    def literal(self, routine: Routine, point: Point, store: ex.Store) -> ex.PositionLiteral | None:
        """The numbers of a point; pulses need the robot. None where they cannot be known."""
        values = tuple(point.values)
        state = point.state
        if store is not ex.Store.ROBOT:
            return (
                ex.PositionLiteral("joint", _trimmed(values)) if state.kind is not PointKind.PULSE else None
            )
        if state.kind is PointKind.POSE:
            further = self._further(routine, values) if len(values) > _POSE else ()
            return ex.PositionLiteral(
                "pose", values[:_POSE], further, state.configuration, sectors=state.sectors
            )
        if state.kind is PointKind.JOINT:
            if self.work.conventions.wrist_target_axes and len(values) > _POSE:
                return ex.PositionLiteral("joint", _trimmed(values[:_POSE]), self._further(routine, values))
            return ex.PositionLiteral("joint", _trimmed(values))
        return self._joints_of(values)

    def _further(self, routine: Routine, values: tuple[float, ...]) -> tuple[float, ...]:
        """What follows the six values of a position, as written: an external axis in mm or deg, or a seventh axis."""
        group = routine.details.get("group 1", "1")
        units = (routine.details.get(f"unit GP{group} E{n}", "deg") for n in range(1, len(values)))
        found = [v / (mm if unit == "mm" else deg) for v, unit in zip(values[_POSE:], units, strict=False)]
        while found and found[-1] != found[-1]:
            found.pop()
        return tuple(found)

    def _joints_of(self, pulses: tuple[float, ...]) -> ex.PositionLiteral | None:
        robot = self.work.robot
        if robot is None:
            self.work.need_robot(
                None, "the points are written in motor pulses, which mean nothing without their robot"
            )
            return None
        from olp.robots.kinematics.configuration import pulses_to_joints

        row = np.nan_to_num(np.asarray(pulses[: len(robot.axes)], dtype=np.float64))
        row = np.concatenate((row, np.zeros(len(robot.axes) - len(row))))
        try:
            return ex.PositionLiteral(
                "joint", tuple(float(v) for v in pulses_to_joints(robot, row[None, :])[0])
            )
        except OlpError as problem:
            self.work.need_robot(None, problem.diagnostics[0].message)
            return None

    def tell_tool(self, s: Move, number: int) -> None:
        """Where a line to joint values leads is not known without its tool."""
        if f"tool {number}" in self.work.cell().gaps:
            tell_zeros(self.work, s, "tool", f"tool {number}")

    def in_space(
        self, routine: Routine, store: ex.Store, taught: bool, number: int
    ) -> tuple[ex.PositionLiteral, PointState] | None:
        """A point taught in joints as a pose of its tool in the base, for moves that need one."""
        point = routine.points.find(store, taught, number)
        if point is None or self.work.robot is None:
            return None
        pose = self.work.cell().pose(0, point.state, point.values)
        if pose is None:
            return None
        state = PointState(PointKind.POSE, "base", tool=point.state.tool)
        return ex.PositionLiteral("pose", tuple(float(v) for v in pose.xyz_angles())), state


def tell_zeros(work: TranslationContext, s: Move, kind: str, label: str) -> None:
    """Notes that a line or arc to joint values was computed without its tool or frame, whose value no file tells."""
    says = f"a {s.path.value} move to joint values leads to their pose, computed as if its {kind} were zeros"
    work.lose(s, Fate.APPROXIMATED, "pose", says)
    work.ask(
        "give the values of these in olp.toml and translate again, as lines to joint values depend on them",
        label,
    )


def _targets(s: Statement) -> Iterator[ex.Expression]:
    """What a statement may give another value: anything but what an assignment takes."""
    if isinstance(s, (Assign, Update)):
        yield from expressions_of(s.target)
    elif not isinstance(s, Move) and not calls_nothing(s):
        yield from expressions_of(s)


def frame_of(state: PointState) -> ex.Expression | None:
    """The frame that a position with this state is written in, None where it says none."""
    if state.kind is not PointKind.POSE:
        return ex.FrameRef("base")
    if state.frame == "user":
        return None if state.user is None else _user(state.user)
    return ex.FrameRef("base") if state.frame in ("base", "robot") else ex.FrameRef(state.frame)


def tool_of(state: PointState) -> ex.Expression | None:
    """The tool that a position with this state was taught with, None where it says none."""
    return _tool(state.tool) if state.tool >= 0 else None


@lru_cache(maxsize=1000)
def _user(number: int) -> ex.FrameRef:
    return ex.FrameRef("user", ex.Number(number))


@lru_cache(maxsize=1000)
def _tool(number: int) -> ex.FrameRef:
    return ex.FrameRef("tool", ex.Number(number))


def _trimmed(values: tuple[float, ...]) -> tuple[float, ...]:
    kept = list(values)
    while kept and math.isnan(kept[-1]):
        kept.pop()
    return tuple(0.0 if math.isnan(v) else v for v in kept)


def _point_name(store: ex.Store, number: int) -> str:
    return f"{_LETTERS.get(store, 'P')}{number}"
