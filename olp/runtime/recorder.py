"""Collects what the interpreter executes and turns it into a plan, all positions in one go.

The interpreter runs statement by statement; resolving 100,000 points one by one would cost minutes. Here each
statement only leaves a few numbers, and numpy does the rest at the end.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from olp.core.diagnostic import Diagnostic
from olp.core.memory_limit import check
from olp.core.source import Source
from olp.ir.expressions import Store
from olp.ir.points import PointKind, PointState, PointTable
from olp.ir.program import Path
from olp.robots.coordinate_systems import Cell, Floats
from olp.runtime.arm_branch import WrittenPosture, axes_after, named
from olp.runtime.columns import NOWHERE, Batch, Extra, MoveRow, columns
from olp.runtime.plan import PATHS, Assumption, BlendCode, Event, Plan, StepKind

if TYPE_CHECKING:
    from olp.robots.robot import Robot


_JOINT = PATHS.index(Path.JOINT)


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
        from olp.robots.kinematics.readings import readings_of_joints

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
        """Begins a move; one `row` per mechanism follows. Raises what `olp.core.memory_limit.check` does."""
        if not len(self._kind) & _CHECKED:
            check()
        self._kind.append(StepKind.MOVE)
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
            if move[6] == BlendCode.EXACT:
                continue
            self._moves[row] = (*move[:6], int(BlendCode.EXACT), math.nan, *move[8:])
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
        self._timed(StepKind.WAIT, source, line, seconds, event)

    def signal(self, source: int, line: int, seconds: float = 0.0, event: Event | None = None) -> None:
        """An output, process instruction or message that takes `seconds` [s]."""
        self._timed(StepKind.SIGNAL, source, line, seconds, event)

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

    def finish(self, diagnostics: Sequence[Diagnostic], stop_reason: str = "") -> Plan:
        """The plan of everything executed."""
        positions, moves = columns(self.cell, self._batches.values(), self._pool, self._moves, self._extras)
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
        )
