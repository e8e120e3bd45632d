"""Collects what the interpreter executes and turns it into a plan, all positions in one go.

The interpreter runs statement by statement; resolving 100,000 points one by one would cost minutes. Here each
statement only leaves a few numbers, and numpy does the rest at the end: positions are resolved batch by batch, all
paths measured at once.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import Diagnostic
from olp.core.result_cache import check
from olp.core.source import Source
from olp.core.units import deg, mm
from olp.ir.expressions import Store
from olp.ir.points import PointKind, PointState, PointTable
from olp.ir.program import Path
from olp.robots.coordinate_systems import Cell, Floats, quaternions
from olp.robots.geometry import compose, quaternion_from_rotation, rotation_from_quaternion
from olp.runtime.arm_branch import WrittenPosture, axes_after, keep_branches, named, says_of
from olp.runtime.paths import circle, cross, shape_paths, swept_angle, turn_between
from olp.runtime.plan import (
    PATHS,
    Assumption,
    BlendCode,
    Event,
    Moves,
    Plan,
    Positions,
    StepKind,
    distinct,
)

if TYPE_CHECKING:
    from olp.robots.model import Robot


# --- Whole arcs ---
# Arcs that one statement describes: from where the arm stands, through a via point, to a target.
#
# The plan tells an arc by a third point beyond its target, as jobs do that chain circular moves. Here that
# point is made: on the same circle, as far beyond the target as the way back to the start leaves.


def beyond_targets(
    positions: Positions, moves: Moves, extras: Mapping[int, Extra]
) -> tuple[Positions, Moves, dict[int, int]]:
    """Positions with the added points, moves whose target an angle replaces, and row -> added point.

    `extras`: rows with a via point. Rows on no circle (three points on a line) get none: they run straight.
    """
    added: list[Floats] = []
    turns: list[Floats] = []
    axes: list[Floats] = []
    third: dict[int, int] = {}
    start, target = moves.start.copy(), moves.target.copy()
    count = len(positions)

    def add(point: Floats, like: int) -> int:
        added.append(point)
        turns.append(positions.quaternion[like])
        axes.append(np.full(positions.axes.shape[1], np.nan))
        return count + len(added) - 1

    def point(index: int) -> Floats:
        return positions.position[index][None] if index < count else added[index - count][None]

    for row, extra in extras.items():
        a, b = point(start[row]), point(extra.via)  # after an arc with an angle the start is an added point
        end = int(target[row])
        c = positions.position[end][None]
        centre, radius, axis = circle(a, b, c)
        if not np.isfinite(radius[0]):
            continue
        swept = float(swept_angle(a - centre, c - centre, axis)[0])
        third[row] = add(_turned(a, centre, axis, swept + (2 * np.pi - swept % (2 * np.pi)) / 2), end)
    if not added:
        return positions, moves, third
    grown = Positions(
        np.concatenate([positions.position, np.array(added)]),
        np.concatenate([positions.quaternion, np.array(turns)]),
        np.concatenate([positions.axes, np.array(axes)]),
    )
    return grown, replace(moves, start=start, target=target), third


def _turned(point: Floats, centre: Floats, axis: Floats, angle: float) -> Floats:
    """(3,) [m]: a point (1, 3) turned about the circle's axis."""
    spoke = point - centre
    turned = spoke * np.cos(angle) + cross(axis, spoke) * np.sin(angle)
    result: Floats = (centre + turned)[0]
    return result


# --- Blend starts ---
# Where a blend begins that is programmed as a speed, an angle or a share: as a distance before the target.
#
# After the manuals of mxAutomation and KSS: APO structure (CPTP, CDIS, CORI, CVEL). Not measured.


def from_speed(cvel: ArrayLike, speed: ArrayLike, deceleration: ArrayLike) -> Floats:
    """C_VEL: [m] left when braking from `speed` [m/s] at `deceleration` [m/s²] reaches the share $APO.CVEL (0 to 1)."""
    result: Floats = (np.asarray(cvel) * np.asarray(speed)) ** 2 / (2 * np.asarray(deceleration))
    return result


def from_angle(cori: ArrayLike, angle: ArrayLike, length: ArrayLike) -> Floats:
    """C_ORI: [m] left of `length` [m] when $APO.CORI [rad] of the whole reorientation `angle` [rad] is left."""
    turned = np.asarray(angle, dtype=np.float64)
    share = np.divide(cori, turned, out=np.ones(np.broadcast(cori, turned).shape), where=turned > 0)
    result: Floats = np.minimum(share, 1.0) * np.asarray(length)
    return result


def from_share(cptp: ArrayLike, length: ArrayLike) -> Floats:
    """C_PTP: share $APO.CPTP (0 to 1) of the greatest distance, which is half of the move of `length` [m or rad]."""
    result: Floats = 0.5 * np.asarray(cptp) * np.asarray(length)
    return result


# --- Columns ---

_JOINT = PATHS.index(Path.JOINT)
# Looked up once: every step asks.
_MOVE, _WAIT, _SIGNAL, _EXACT = StepKind.MOVE, StepKind.WAIT, StepKind.SIGNAL, int(BlendCode.EXACT)
_HIGHEST_TOOL = np.iinfo(np.int32).max  # a program may write a number of any size, which is no tool's
NOWHERE = -1  # the position before the first move

# start, target, mechanism, path, unit, speed, blend code, blend, acceleration, deceleration, end of arc
MoveRow = tuple[int, int, int, int, int, float, int, float, float, float, bool]


class Extra(NamedTuple):
    """What moves of some languages say besides, as it stands in the first row of a move.

    `rate` [m/s²], of a joint move [rad/s²]. `turn` [rad/s]: bound of the tool's turning. `via`: pool index of the point
    that an arc passes on its way (-1: none). `blend`: the kind of blend whose number becomes metres once the path is
    known.
    """

    rate: float = math.nan
    turn: float = math.nan
    via: int = -1
    blend: str = ""


NO_EXTRA: Final = Extra()


@dataclass(slots=True)
class Batch:
    """Positions of one mechanism under one state, to be resolved together."""

    mechanism: int
    state: PointState
    rows: list[int] = field(default_factory=list)  # index in the pool
    values: list[Sequence[float]] = field(default_factory=list)


def columns(
    cell: Cell,
    batches: Iterable[Batch],
    count: int,
    rows: Sequence[MoveRow],
    extras: Mapping[int, Extra] | None = None,
    *,
    branches: bool = True,
) -> tuple[Positions, Moves, NDArray[np.int32]]:
    """The `count` positions and all moves of a plan, and the tool of each move (-1: none).

    `branches`: the axes at poses follow from the moves that lead there; else they are those of the written flags.
    """
    positions, tools, says = _resolve(cell, batches, count)
    moves, end_of_arc = _moves(rows)
    if not len(moves):
        return positions, moves, np.zeros(0, dtype=np.int32)
    if branches:
        positions, moves, tools = keep_branches(cell, positions, tools, says, moves)
    positions, moves = _with_target_tools(cell, positions, tools, moves)
    held = tools[moves.target]
    extras = extras or {}
    with_via = {row: extra for row, extra in extras.items() if extra.via >= 0}
    positions, moves, whole_arcs = beyond_targets(positions, moves, with_via)
    via, before, length = shape_paths(moves, positions, end_of_arc, whole_arcs)
    angle = turn_between(positions.quaternion[moves.start], positions.quaternion[moves.target])
    moves = replace(moves, via=via, before=before, length=length, angle=angle)
    return positions, with_extras(moves, extras, units_of(rows)), held


def _resolve(
    cell: Cell, batches: Iterable[Batch], count: int
) -> tuple[Positions, NDArray[np.int32], NDArray[np.int8]]:
    """All positions, the tool that each was taught with (-1 for what carries none), what it says of the arm (Named)."""
    width = max((len(m.robot.axes) for m in cell.mechanisms if m.robot), default=6)
    position = np.full((count, 3), np.nan)
    quaternion = np.full((count, 4), np.nan)
    axes = np.full((count, max(width, 6)), np.nan)
    tools = np.full(count, -1, dtype=np.int32)
    says = np.zeros(count, dtype=np.int8)
    for batch in batches:
        rows = np.array(batch.rows)
        resolved = cell.resolve(batch.mechanism, batch.state, _rectangle(batch.values))
        position[rows] = resolved.position
        quaternion[rows] = quaternions(resolved)
        known = min(resolved.axes.shape[1], axes.shape[1])  # seven pulses of an unknown arm tell nothing
        axes[rows, :known] = resolved.axes[:, :known]
        if cell.mechanisms[batch.mechanism].is_robot:
            tools[rows] = max(-_HIGHEST_TOOL, min(batch.state.tool, _HIGHEST_TOOL))
            says[rows] = says_of(cell, batch.mechanism, batch.state, resolved.axes)
    return Positions(position, quaternion, axes), tools, says


def _rectangle(values: list[Sequence[float]]) -> Floats:
    """(n, w) from rows that may differ in width, nan where a row is short."""
    width = max(len(row) for row in values)
    if all(len(row) == width for row in values):
        return np.array(values, dtype=np.float64)
    return np.array([[*row, *[np.nan] * (width - len(row))] for row in values], dtype=np.float64)


def _moves(rows: Sequence[MoveRow]) -> tuple[Moves, NDArray[np.bool_]]:
    """The moves, their paths not yet measured, and which of them end an arc."""
    cells = list(zip(*rows, strict=True)) if rows else [()] * 11
    start, target, mechanism, path, unit, speed, code, blend, acceleration, deceleration, end_of_arc = cells
    starts, targets = np.array(start, dtype=np.int32), np.array(target, dtype=np.int32)
    units, speeds = np.array(unit, dtype=np.int8), np.array(speed, dtype=np.float64)
    count = len(rows)
    moves = Moves(
        # Nobody knows where the arm stood before its first move: it is taken to stand at that move's target.
        start=np.where(starts == NOWHERE, targets, starts).astype(np.int32),
        target=targets,
        via=np.full(count, -1, dtype=np.int32),
        before=np.zeros(count, dtype=bool),
        mechanism=np.array(mechanism, dtype=np.int16),
        path=np.array(path, dtype=np.int8),
        fraction=np.where(units == 0, speeds, np.nan),
        travel=np.where(units == 1, speeds, np.nan),
        turn=np.where(units == 2, speeds, np.nan),
        acceleration=np.array(acceleration, dtype=np.float64),
        deceleration=np.array(deceleration, dtype=np.float64),
        blend_code=np.array(code, dtype=np.int8),
        blend=np.array(blend, dtype=np.float64),
        length=np.zeros(count),
        angle=np.zeros(count),
        axis_speed=np.where(units == 3, speeds, np.nan),
        duration=np.where(units == 4, speeds, np.nan),
        rate=np.full(count, np.nan),
    )
    return moves, np.array(end_of_arc, dtype=bool)


def units_of(rows: Sequence[MoveRow]) -> NDArray[np.int8]:
    """(m,) what the speed of each row is of, see `Recorder.row`."""
    return np.array([row[4] for row in rows], dtype=np.int8)


def with_extras(moves: Moves, extras: Mapping[int, Extra], units: NDArray[np.int8]) -> Moves:
    """Accelerations, bounds of turning, times and blends that need the path's length."""
    timed = units == 4
    if not extras and not timed.any():
        return moves
    rate, turn, blend = moves.rate.copy(), moves.turn.copy(), moves.blend.copy()
    for row, extra in extras.items():
        rate[row] = extra.rate
        if not math.isnan(extra.turn):
            turn[row] = extra.turn if math.isnan(turn[row]) else min(turn[row], extra.turn)
        if extra.blend:
            blend[row] = _metres(extra, float(blend[row]), moves, row)
    with np.errstate(divide="ignore", invalid="ignore"):
        pace = np.where(timed & (moves.path != _JOINT), moves.length / moves.duration, moves.travel)
        turning = np.where(
            timed & (moves.path != _JOINT) & (moves.length <= 0), moves.angle / moves.duration, turn
        )
    return replace(moves, rate=rate, turn=turning, blend=blend, travel=pace)


# DEF_ACC_CP of KRL's controllers: what a share of the speed is braked with where the program says nothing else.
_USUAL_BRAKING = 2.3  # [m/s²]


def _metres(extra: Extra, value: float, moves: Moves, row: int) -> float:
    """[m] before the target at which a blend that is no length begins."""

    length = float(moves.length[row])
    if extra.blend == "share":
        return float(from_share(min(value, 1.0), length))
    if extra.blend == "turn":
        return float(from_angle(value, float(moves.angle[row]), length))
    braking = _USUAL_BRAKING if math.isnan(extra.rate) else extra.rate
    speed = float(moves.travel[row])
    return 0.0 if math.isnan(speed) else float(from_speed(min(value, 1.0), speed, braking))


def _with_target_tools(
    cell: Cell, positions: Positions, tools: NDArray[np.int32], moves: Moves
) -> tuple[Positions, Moves]:
    """Where a move's target was taught with another tool, its start is seen with that tool too.

    The controller moves the tool that the target names; the arm stands where it stood, but the point that
    travels is another one.
    """
    changed = np.nonzero(tools[moves.start] != tools[moves.target])[0]
    if not len(changed):
        return positions, moves
    start = moves.start.copy()
    old, new = tools[start[changed]], tools[moves.target[changed]]
    extra: list[Positions] = []
    for first, second in sorted(set(zip(old.tolist(), new.tolist(), strict=True))):
        rows = changed[(old == first) & (new == second)]
        swap = cell.tool_pose(first).inverse() @ cell.tool_pose(second)
        seen = start[rows]
        position, rotation = compose(
            positions.position[seen],
            rotation_from_quaternion(positions.quaternion[seen]),
            swap.position,
            swap.rotation,
        )
        start[rows] = len(positions) + sum(map(len, extra)) + np.arange(len(rows))
        extra.append(Positions(position, quaternion_from_rotation(rotation), positions.axes[seen]))
    together = (
        np.concatenate([getattr(p, name) for p in (positions, *extra)])
        for name in ("position", "quaternion", "axes")
    )
    return Positions(*together), replace(moves, start=start)


_CHECKED = 0xFF  # steps, in between which nobody asks whether the plan is still wanted


@dataclass(slots=True)
class Recorder:
    """Everything executed so far. `at[m]`: pool index of where mechanism m is (NOWHERE before its first move)."""

    cell: Cell
    sources: tuple[Source, ...]
    at: list[int] = field(default_factory=list)
    assumptions: dict[tuple[str, int, str], Assumption] = field(default_factory=dict)
    _pool: int = 0
    _static: dict[tuple[int, int, Store, int], int] = field(default_factory=dict)
    _batches: dict[tuple[int, PointState], Batch] = field(default_factory=dict)
    # The same by identity: of 100,000 positions most have a state that is one object.
    _latest: dict[tuple[int, int], tuple[PointState, Batch]] = field(default_factory=dict)
    _kind: list[int] = field(default_factory=list)
    _row: list[int] = field(default_factory=list)
    _source: list[int] = field(default_factory=list)
    _line: list[int] = field(default_factory=list)
    _durations: list[float] = field(default_factory=list)
    _moves: list[MoveRow] = field(default_factory=list)
    _stood: dict[int, tuple[int, Floats]] = field(default_factory=dict)  # rows that led there, and its axes
    _extras: dict[int, Extra] = field(default_factory=dict)  # first row of a move -> what else it says

    _events: dict[int, Event] = field(default_factory=dict)
    further: dict[int, tuple[float, ...]] = field(default_factory=dict)  # entry of the pool -> [mm or deg]
    _last_move: int = 0  # the first row of the last move

    unknown: int = -1  # see Plan

    def __post_init__(self) -> None:
        self.at = [NOWHERE] * len(self.cell.mechanisms)

    def __len__(self) -> int:
        return len(self._kind)

    def taught(
        self, mechanism: int, routine: int, points: PointTable, store: Store, number: int
    ) -> int | None:
        """Pool index of a point taught in a routine, None if missing. `routine`: any number telling routines apart."""
        key = (mechanism, routine, store, number)
        index = self._static.get(key)
        if index is None:
            block = points.blocks.get((store, True))
            row = None if block is None else block.rows.get(number)
            if block is None or row is None:
                return None
            state = points.states[block.state[row]]
            index = self._static[key] = self.position(mechanism, state, block.values[row])
        return index

    def position(self, mechanism: int, state: PointState, values: Sequence[float]) -> int:
        """Pool index of a position computed at run time."""
        same = self._latest.get((mechanism, id(state)))
        if same is not None and same[0] is state:
            batch = same[1]
        else:
            found = self._batches.get((mechanism, state))
            batch = found or self._batches.setdefault((mechanism, state), Batch(mechanism, state))
            self._latest[(mechanism, id(state))] = (state, batch)
        index = self._pool
        self._pool += 1
        batch.rows.append(index)
        batch.values.append(values)
        return index

    def written(self, index: int) -> tuple[PointState, Sequence[float]]:
        """State and numbers of an entry of the pool."""
        for batch in self._batches.values():
            row = bisect_left(batch.rows, index)  # entries are appended in order
            if row < len(batch.rows) and batch.rows[row] == index:
                return batch.state, batch.values[row]
        raise IndexError(index)

    def axes_here(self, mechanism: int) -> Floats:
        """(k,) axes where a mechanism stands now, nan where they are not known; it has moved, or begins somewhere."""
        from olp.robots.kinematics.configuration import readings_of_joints

        done, axes = self._stood.get(mechanism, (0, None))
        entries: list[tuple[PointState, Sequence[float], bool]] = []
        first = NOWHERE
        for row in reversed(self._moves[done:]):
            if row[2] != mechanism:
                continue
            joint, first = row[3] == _JOINT, row[0]
            entries.append((*self.written(row[1]), joint))
            says = named(self.cell, mechanism, entries[-1][0])
            if says is WrittenPosture.AXES or (
                says is WrittenPosture.FLAGS and joint and not entries[-1][0].sectors
            ):
                break
        else:
            if axes is not None:
                robot = self.cell.robot(mechanism)
                read = axes if robot is None else readings_of_joints(robot, axes[None])[0]
                entries.append((PointState(PointKind.JOINT, "joint"), read.tolist(), True))
            elif first != NOWHERE or not entries:
                entries.append((*self.written(first if entries else self.at[mechanism]), True))
        axes = axes_after(self.cell, mechanism, entries[::-1])
        self._stood[mechanism] = len(self._moves), axes
        return axes

    def pulse_span(self, mechanism: int) -> tuple[Floats, Floats] | None:
        """Smallest and largest pulse of each axis of all recorded positions, None when there are none in pulses."""
        rows = [
            np.asarray(values, dtype=np.float64)
            for batch in self._batches.values()
            if batch.mechanism == mechanism and batch.state.kind is PointKind.PULSE
            for values in batch.values
        ]
        width = min((len(row) for row in rows), default=0)
        if not width:
            return None
        table = np.nan_to_num(np.stack([row[:width] for row in rows]))
        return table.min(axis=0), table.max(axis=0)

    def step(self, source: int, line: int) -> None:
        """Begins a move; one `row` per mechanism follows. Raises what `olp.core.result_cache.check` does."""
        if not len(self._kind) & _CHECKED:
            check()
        self._kind.append(_MOVE)
        self._row.append(len(self._moves))
        self._last_move = len(self._moves)
        self._source.append(source)
        self._line.append(line)

    def extra(self, extra: Extra) -> None:
        """What the move begun last says besides; its rows follow."""
        self._extras[len(self._moves)] = extra

    def row(
        self,
        mechanism: int,
        target: int,
        path: int,
        unit: int,
        speed: float,
        blend_code: int,
        blend: float = np.nan,
        acceleration: float = 1.0,
        deceleration: float = 1.0,
        end_of_arc: bool = False,
    ) -> None:
        """One mechanism's part of the move begun last.

        `path`: index into PATHS. `unit`: 0 fraction of rated [1], 1 travel [m/s], 2 turn [rad/s], 3 axis [rad/s], 4
        time [s]. `blend` [m] with BlendCode.ZONE.
        """
        start = self.at[mechanism]
        self.at[mechanism] = target
        if start == NOWHERE:
            name = self.cell.mechanisms[mechanism].name
            self.assume(
                self._source[-1], self._line[-1], f"{name} is already at the target of its first move"
            )
        self._moves.append(
            (
                start,
                target,
                mechanism,
                path,
                unit,
                speed,
                blend_code,
                blend,
                acceleration,
                deceleration,
                end_of_arc,
            )
        )

    def end_exactly(self) -> None:
        """The last move stops at its target, whatever blend it asks for."""
        for row in range(self._last_move, len(self._moves)):
            move = self._moves[row]
            if move[6] == _EXACT:
                continue
            self._moves[row] = (*move[:6], _EXACT, math.nan, *move[8:])
            if row in self._extras:
                self._extras[row] = self._extras[row]._replace(blend="")
        self._last_move = len(self._moves)

    def cut(self, length: int) -> None:
        """Forgets the steps from number `length` on: a pass that was the same as the one before it."""
        moves = [self._row[i] for i in range(length, len(self)) if self._kind[i] == StepKind.MOVE]
        timed = [self._row[i] for i in range(length, len(self)) if self._kind[i] != StepKind.MOVE]
        rows, events = min(moves, default=len(self._moves)), min(timed, default=len(self._durations))
        for row in reversed(self._moves[rows:]):
            self.at[row[2]] = row[0]
        for column in (self._kind, self._row, self._source, self._line):
            del column[length:]
        del self._moves[rows:], self._durations[events:]
        self._extras = {row: extra for row, extra in self._extras.items() if row < rows}
        self._events = {row: event for row, event in self._events.items() if row < events}
        self._stood = {of: stood for of, stood in self._stood.items() if stood[0] <= rows}
        self._last_move = min(self._last_move, len(self._moves))

    def wait(self, source: int, line: int, seconds: float, event: Event | None = None) -> None:
        """A wait of `seconds` [s]."""
        self._timed(_WAIT, source, line, seconds, event)

    def signal(self, source: int, line: int, seconds: float = 0.0, event: Event | None = None) -> None:
        """An output, process instruction or message that takes `seconds` [s]."""
        self._timed(_SIGNAL, source, line, seconds, event)

    def _timed(self, kind: StepKind, source: int, line: int, seconds: float, event: Event | None) -> None:
        if event is not None:
            self._events[len(self._durations)] = event
        self._kind.append(kind)
        self._row.append(len(self._durations))
        self._source.append(source)
        self._line.append(line)
        self._durations.append(seconds)

    def assume(self, source: int, line: int, says: str) -> None:
        """Reports something taken for granted, once per place."""
        path = self.sources[source].path
        self.assumptions.setdefault((path, line, says), Assumption(line, says, path))

    def _beside(self) -> dict[int, tuple[float, ...]]:
        """First row of each move -> where external axes stand [mm or deg]: tracks, then stations; nan where it is not
        said.
        """
        mechanisms = self.cell.mechanisms
        carry = any(state.units for _, state in self._batches)
        if not self.further and not carry and all(m.is_robot for m in mechanisms):
            return {}
        firsts = [row for row, kind in zip(self._row, self._kind, strict=True) if kind == StepKind.MOVE]
        found: dict[int, dict[int, tuple[float, ...]]] = {}
        for first, after in pairwise([*firsts, len(self._moves)]):
            for move in self._moves[first:after]:
                values = self._beside_at(move[2], move[1])
                if values:
                    found.setdefault(first, {})[move[2]] = values
        widths: dict[int, int] = {}
        for row in found.values():
            for mechanism, values in row.items():
                widths[mechanism] = max(widths.get(mechanism, 0), len(values))
        order = sorted(widths, key=lambda mechanism: mechanisms[mechanism].name)
        nowhere = {mechanism: (math.nan,) * width for mechanism, width in widths.items()}
        return {
            first: tuple(chain(*((row.get(at, ()) + nowhere[at])[: widths[at]] for at in order)))
            for first, row in found.items()
        }

    def _beside_at(self, mechanism: int, target: int) -> tuple[float, ...]:
        """[mm or deg] where a track or a station, or the external axes of an arm's position, stand at its target."""
        if target in self.further:
            return self.further[target]
        state, written = self.written(target)
        if not self.cell.mechanisms[mechanism].is_robot:
            return self.cell.beside(mechanism, state, written)
        further = zip(written[state.own :], state.units, strict=False)
        return tuple(v / (mm if unit == "mm" else deg) for v, unit in further)

    def finish(
        self, diagnostics: Sequence[Diagnostic], stop_reason: str = "", *, branches: bool = True
    ) -> Plan:
        """The plan of everything executed. `branches`: as in `columns`."""
        positions, moves, held = columns(
            self.cell, self._batches.values(), self._pool, self._moves, self._extras, branches=branches
        )
        tools = {number: self.cell.tool_pose(number) for number in distinct(held) if number >= 0}
        gaps = tuple(Assumption(0, gap.says) for gap in self.cell.gaps.values() if not gap.unusable)
        robots: tuple[Robot | None, ...] = tuple(m.robot for m in self.cell.mechanisms)
        return Plan(
            sources=self.sources,
            robot=next((r for r, m in zip(robots, self.cell.mechanisms, strict=True) if m.is_robot), None),
            mechanisms=tuple(m.name for m in self.cell.mechanisms),
            kind=np.array(self._kind, dtype=np.int8),
            row=np.array(self._row, dtype=np.int32),
            source=np.array(self._source, dtype=np.int16),
            line=np.array(self._line, dtype=np.int32),
            moves=moves,
            durations=np.array(self._durations, dtype=np.float64),
            positions=positions,
            assumptions=(*self.assumptions.values(), *gaps),
            diagnostics=tuple(diagnostics),
            stop_reason=stop_reason,
            robots=robots,
            unknown=self.unknown,
            events=self._events,
            held=held,
            tools=tools,
            beside=self._beside(),
        )
