"""The plan: what happens when a program runs. Moves, waits and signals in order, in SI, each with its statement.

Held in columns, because a CAM job has 100,000 moves; `Plan.steps()` gives the same as objects.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, Span
from olp.core.source import Source
from olp.ir.program import Path
from olp.robots.geometry import Pose

if TYPE_CHECKING:
    from olp.robots.model import Robot

Floats = NDArray[np.float64]
PATHS: tuple[Path, ...] = tuple(Path)
USUAL_LAW = (
    "yaskawa"  # the blending law of a plan whose language has none of its own: that of position levels
)

ROBOT_IS_ASKED_FOR = ("I001", "I003")  # codes of findings that say that moves need a robot
# What may be assumed where no file says it: code -> key of [unknown] in olp.toml.
ASSUMABLE: Mapping[str, str] = {
    "I102": "routines",
    "I118": "first-move",
    "I203": "values",
    "I209": "values",
    "I215": "start",
    "I225": "routines",
}
# Of findings that the run ended before the program did, and not with a cycle of it: the rest takes time, too.
CUT_SHORT = frozenset({"I108", "I109"})


def leaves_open(found: Diagnostic) -> bool:
    """Whether a total leaves out what a finding tells, or had to assume it."""
    return found.is_error or found.code in ASSUMABLE or found.code in CUT_SHORT


class StepKind(IntEnum):
    """What a step is; the row index of the step points into the columns of that kind."""

    MOVE = 0
    WAIT = 1
    SIGNAL = 2


class BlendCode(IntEnum):
    """How the end of a move is passed; `blend` holds the zone [m] for ZONE, the radius for RADIUS, else nothing."""

    EXACT = 0
    ZONE = 1  # of the maker's law `zone_law`; with some laws a share of the speed instead of metres
    UNTAGGED = 2  # no position level written: the controller's filter rounds, nothing stops
    RADIUS = 3  # rounded by an arc that touches both moves


class Event(NamedTuple):
    """What a signal step or a wait is about: signals as olp.toml spells them, and the value (nan: not a number).

    `metres`, `seconds`: how far behind its place it acts, as a trigger of a move does (`ir.program.PathTrigger`).
    """

    kind: str  # set, pulse, wait
    signals: tuple[str, ...]
    value: float
    metres: float = 0.0
    seconds: float = 0.0


class Assumption(NamedTuple):
    """What a program cannot tell and olp took for granted. `line` 0: the program as a whole."""

    line: int
    says: str
    file: str = ""


@dataclass(frozen=True, slots=True)
class Positions:
    """The distinct positions of a plan, p rows.

    `position` (p, 3) [m] and `quaternion` (p, 4) (w, x, y, z): tool centre point in the robot's base frame, nan where
    no robot, tool or frame lets it be known, or for a mechanism that has none (track, station).
    `axes` (p, k) [rad or m]: the mechanism's axes, nan where unknown.
    """

    position: Floats
    quaternion: Floats
    axes: Floats

    def __len__(self) -> int:
        return len(self.position)


@dataclass(frozen=True, slots=True)
class Moves:
    """One row per moving mechanism of each move, m rows. A move of several groups is several rows of one step.

    `start`, `target`, `via`: row in Positions; a curve runs through `via` too, after its target, or `before` its
    start (-1: straight). `mechanism`: index into `Plan.mechanisms`.
    `path`: index into PATHS. `fraction` [1], `travel` [m/s], `turn` [rad/s]: the programmed speed, nan where it is
    of another kind. `acceleration`, `deceleration`: fraction of rated [1]. `blend_code`, `blend` [m].
    `length` [m] and `angle` [rad]: of the tool's path; nan where unknown. `axis_speed` [rad/s]: programmed for the axis
    that turns furthest; `duration` [s]: programmed instead of a speed; `rate` [m/s²], of a joint move [rad/s²]:
    programmed acceleration; each nan where the program says none. A `turn` beside a `travel` bounds the reorientation.
    """

    start: NDArray[np.int32]
    target: NDArray[np.int32]
    via: NDArray[np.int32]
    before: NDArray[np.bool_]
    mechanism: NDArray[np.int16]
    path: NDArray[np.int8]
    fraction: Floats
    travel: Floats
    turn: Floats
    acceleration: Floats
    deceleration: Floats
    blend_code: NDArray[np.int8]
    blend: Floats
    length: Floats
    angle: Floats
    axis_speed: Floats
    duration: Floats
    rate: Floats

    def __len__(self) -> int:
        return len(self.start)


class MoveConditions(NamedTuple):
    """Under which each row of Moves ran, (m,) each, where a recording tells more than its program; nan: not known."""

    override: Floats  # [1] of the controller; 1 where nothing is told
    payload: Floats  # [kg]
    inertia: Floats  # [kg m²] of the payload itself


@dataclass(frozen=True, slots=True)
class MoveStep:
    """A move as an object: one entry of `rows` per mechanism."""

    line: int
    statement: str
    path: Path
    mechanisms: tuple[str, ...]
    start: Floats  # (3,) [m]
    target: Floats  # (3,) [m]
    length: float  # [m]
    angle: float  # [rad]
    blend_code: BlendCode
    blend: float  # [m]


@dataclass(frozen=True, slots=True)
class WaitStep:
    line: int
    statement: str
    duration: float  # [s]


@dataclass(frozen=True, slots=True)
class SignalStep:
    """An output, a process instruction, a message: takes `duration` [s], mostly nothing."""

    line: int
    statement: str
    duration: float  # [s]


class CallSpan(NamedTuple):
    """Steps `start` to `stop` - 1 ran under one execution of the main routine's call on `line`."""

    line: int
    start: int
    stop: int


Step = MoveStep | WaitStep | SignalStep


@dataclass(frozen=True, slots=True)
class Plan:
    """Executed steps in order, n of them.

    `kind` (n,): StepKind. `row` (n,): first row in `moves`, or index into `durations`. `source` (n,): index into
    `sources`, `line` (n,): 1-based line there. `durations` [s]: of waits and signals.
    `unknown`: how many steps there were when a statement was first left out because a value is not known; -1: none was.
    `events`: index into `durations` -> what the step is about. `calls`: of the main routine, in order. `zone_law`: the
    blending law whose zones BlendCode.ZONE means. `conditions`: of moves that were recorded.
    `held` (m,): the tool of each move, as a key of `tools` (its centre point on the flange), -1 for none.
    `beside`: first row of a move -> where the axes beside the arm stand [mm or deg], nan where it does not say.
    """

    sources: tuple[Source, ...]
    robot: Robot | None
    mechanisms: tuple[str, ...]
    kind: NDArray[np.int8]
    row: NDArray[np.int32]
    source: NDArray[np.int16]
    line: NDArray[np.int32]
    moves: Moves
    durations: Floats
    positions: Positions
    assumptions: tuple[Assumption, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    stop_reason: str = ""  # why execution ended before the program did, if it did
    robots: tuple[Robot | None, ...] = ()  # per mechanism
    settings: Mapping[str, str | float] = field(default_factory=dict)  # [motion] of olp.toml, as written
    calls: tuple[CallSpan, ...] = ()
    zone_law: str = USUAL_LAW
    unknown: int = -1
    events: Mapping[int, Event] = field(default_factory=dict)
    conditions: MoveConditions | None = None
    held: NDArray[np.int32] | None = None
    tools: Mapping[int, Pose] = field(default_factory=dict)
    beside: Mapping[int, tuple[float, ...]] = field(default_factory=dict)

    @property
    def path(self) -> str:
        return self.sources[0].path if self.sources else ""

    def __len__(self) -> int:
        return len(self.kind)

    def overrides(self, override: float) -> Floats:
        """(m,) [1] under which each row runs at the controller's `override` [1]."""
        told = np.ones(len(self.moves)) if self.conditions is None else self.conditions.override
        return np.asarray(override * told)

    def statement(self, step: int) -> str:
        """The text of the step's line, trimmed."""
        return self.sources[int(self.source[step])].line(int(self.line[step])).strip()

    def rows_of(self, step: int) -> range:
        """The rows in `moves` of a MOVE step."""
        first = int(self.row[step])
        following = np.nonzero(self.kind[step + 1 :] == StepKind.MOVE)[0]
        last = int(self.row[step + 1 + following[0]]) if len(following) else len(self.moves)
        return range(first, last)

    def steps(self) -> Iterator[Step]:
        """The same as objects, for reading by people and small tools."""
        for step in range(len(self)):
            yield self._step(step)

    def _step(self, step: int) -> Step:
        line, text = int(self.line[step]), self.statement(step)
        kind, row = StepKind(int(self.kind[step])), int(self.row[step])
        if kind is StepKind.WAIT:
            return WaitStep(line, text, float(self.durations[row]))
        if kind is StepKind.SIGNAL:
            return SignalStep(line, text, float(self.durations[row]))
        moves = self.moves
        return MoveStep(
            line,
            text,
            PATHS[int(moves.path[row])],
            tuple(self.mechanisms[int(moves.mechanism[r])] for r in self.rows_of(step)),
            self.positions.position[int(moves.start[row])],
            self.positions.position[int(moves.target[row])],
            float(moves.length[row]),
            float(moves.angle[row]),
            BlendCode(int(moves.blend_code[row])),
            float(moves.blend[row]),
        )


# --- Findings ---
# What is told of moves of a plan: once per file, at the first line that it holds of, with the number of the others.


def distinct(column: NDArray[np.integer]) -> list[int]:
    """The values of a column, ascending. np.unique would import numpy.ma: 10 ms, as much as a short program's plan."""
    return sorted(set(column.tolist()))


def lines_of(plan: Plan, rows: NDArray[np.integer]) -> dict[int, list[int]]:
    """Index into `plan.sources` -> its lines, each once, that `rows` (r,) of the plan's Moves are from."""
    if not len(rows):
        return {}
    steps = np.flatnonzero(plan.kind == StepKind.MOVE)
    owners = steps[np.searchsorted(plan.row[steps], rows, side="right") - 1]
    lines: dict[int, dict[int, None]] = {}
    for source, line in zip(plan.source[owners].tolist(), plan.line[owners].tolist(), strict=True):
        lines.setdefault(source, {})[line] = None
    return {source: list(found) for source, found in lines.items()}


def of_rows(
    plan: Plan, rows: NDArray[np.integer], tell: Callable[..., Diagnostic], code: str, says: str, how: str
) -> Iterator[Diagnostic]:
    """`tell` is `error`, `warning` or `info`; `rows` (r,) of the plan's Moves in order; `says` of the first of them."""
    for source, found in lines_of(plan, rows).items():
        line, more = found[0], len(found) - 1
        text = plan.sources[source].line(line)
        count = "" if not more else " (and once more)" if more == 1 else f" (and in {more} more lines)"
        span = Span(line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
        yield tell(code, says + count, span, file=plan.sources[source].path, source_line=text, help=how)
