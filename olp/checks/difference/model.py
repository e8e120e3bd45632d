"""What differs between two versions of a program."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from olp.reports.outcome.model import JudgedItem


class Cause(StrEnum):
    """Why a line takes another time; the words that reports use."""

    POINT = "point moved"
    SPEED = "speed"
    ACCELERATION = "acceleration"
    STOP = "new stop"
    NO_STOP = "stop gone"
    BLEND = "blend"
    PATH = "kind of move"
    TOOL = "tool"
    FRAME = "frame"
    WAIT = "wait"
    SIGNAL = "I/O"
    ADDED = "new line"
    REMOVED = "line gone"
    COUNT = "runs another number of times"
    NEIGHBOUR = "its neighbour changed"
    ROBOT = "robot"
    SETTINGS = "settings"
    UNKNOWN = "not known"


@dataclass(frozen=True, slots=True)
class LineChange:
    """One line of the old or new version. `old_s`, `new_s` [s]: over all executions, 0 where it is not there.

    `old_line`, `new_line`: 0 where there is none. `moved_mm`, `turned_deg`: of its target. `details`: "V=300 → 250".
    """

    routine: str
    old_line: int
    new_line: int
    statement: str
    kind: str
    old_s: float
    new_s: float
    cause: Cause
    details: str = ""
    moved_mm: float = 0.0
    turned_deg: float = 0.0
    file: str = ""  # name of the file that the line stands in

    @property
    def change_s(self) -> float:
        return self.new_s - self.old_s


@dataclass(frozen=True, slots=True)
class ProgramDifference:
    """One program. `changes`: lines whose time or meaning changed; the seconds of all others are the same.

    `old_s`, `new_s` [s]: totals, None where that version could not be timed, and `why` tells the reason; `old_ends`,
    `new_ends` [s]: their 95 % intervals, None where nothing is known of them. Of one arm both versions err alike: an
    interval is that of its total, not of the change.
    """

    file: str
    old_s: float | None
    new_s: float | None
    changes: tuple[LineChange, ...] = ()
    budgets: tuple[JudgedItem, ...] = ()
    why: str = ""
    notes: tuple[str, ...] = field(default_factory=tuple)
    old_ends: tuple[float, float] | None = None
    new_ends: tuple[float, float] | None = None

    @property
    def change_s(self) -> float | None:
        return None if self.old_s is None or self.new_s is None else self.new_s - self.old_s
