"""Seconds per step, in columns; the names of the columns are those of `olp time --format json`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, Span, info
from olp.core.files import utf8
from olp.runtime.plan import Assumption, Plan, StepKind, leaves_open
from olp.timing.blending.law import BlendingLaw, Corners
from olp.timing.motion._profile import Profile

if TYPE_CHECKING:
    import pandas


Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

# Name, decimals shown: what a segment is told by.
COLUMNS: tuple[str, ...] = (
    "line", "statement", "kind", "distance_mm", "speed_mm_s", "reached_mm_s", "accel_mm_s2",
    "limited_by", "duration_s", "end_s", "speed_pct", "speed_deg_s", "angle_deg", "file",
)  # fmt: skip


class CorrectionInterval(NamedTuple):
    """95 % interval: `low`, `high` (n,) [s] per step, nan where unknown; `total_low`, `total_high` [s] of the whole
    program.
    """

    low: Floats
    high: Floats
    total_low: float
    total_high: float


class LawCorners(NamedTuple):
    """Corners of one law, at the ends of `rows` (n,), ascending."""

    law: BlendingLaw
    corners: Corners
    rows: Rows


@dataclass(frozen=True, slots=True)
class CornerPieces:
    """The corner at the end of each row of Moves, (m,) each, 0 where there is none.

    `span` [s]: its duration; `lead` [s]: the part that counts for the row before. `before`, `after` [m]: lengths of
    the row before and of the row after inside the corner, which is entered at `entry` and left at `exit` [m/s].
    Faded corners only: `fall` and `rise` [s], durations of the ramps, `shift` [s] from the middle of the rise to
    that of the fall.
    """

    span: Floats
    lead: Floats
    before: Floats
    after: Floats
    entry: Floats
    exit: Floats
    fall: Floats
    rise: Floats
    shift: Floats
    shapes: list[LawCorners] = field(default_factory=list)

    @classmethod
    def none(cls, count: int) -> CornerPieces:
        """No corner at any of `count` rows."""
        span, lead, before, after, entry, exit, fall, rise, shift = np.zeros((9, count))
        return cls(span, lead, before, after, entry, exit, fall, rise, shift)

    def add(self, other: CornerPieces) -> None:
        """Add the corners of `other`, which are at other rows."""
        for name in ("span", "lead", "before", "after", "entry", "exit", "fall", "rise", "shift"):
            getattr(self, name)[:] += getattr(other, name)
        self.shapes.extend(other.shapes)

    def falling(self, rows: Rows, time: Floats) -> Floats:
        """Length [m] (n,) that `rows` (n,) travel in the corners at their ends, `time` (n,) [s] after the corners
        begin.
        """
        middle = self.lead[rows] + self.shift[rows]
        even = np.minimum(time, middle) + _ramp(time - middle, self.fall[rows], late=True)
        return self._shaped(rows, time, 0, self.entry[rows] * even)

    def rising(self, rows: Rows, time: Floats) -> Floats:
        """Length [m] (n,) that the rows after `rows` (n,) travel in the corners between them, `time` (n,) [s] after
        the corners begin.
        """
        since = time - self.lead[rows]
        even = np.maximum(since, 0.0) + _ramp(since, self.rise[rows])
        return self._shaped(rows, time, 1, self.exit[rows] * even)

    def _shaped(self, rows: Rows, time: Floats, part: int, even: Floats) -> Floats:
        """`even` with the values of other laws at their corners; `part`: 0 the row before, 1 the row after."""
        for law, corners, own in self.shapes:
            if not len(own):
                continue
            at = np.minimum(np.searchsorted(own, rows), len(own) - 1)
            mine = np.flatnonzero(own[at] == rows)
            if not len(mine):
                continue
            which = at[mine]
            along = law.position(corners.take(which), time[mine][:, None])[:, 0, part]
            even[mine] = along + (self.before[rows[mine]] if part == 0 else 0.0)
        return even


def _ramp(since: Floats, width: Floats, late: bool = False) -> Floats:
    """Lead [s] (n,) of a speed that changes evenly over `width` [s] ahead of one that steps in its middle.

    `since` [s]: time since the middle. A rise has begun before it; a fall (`late`) too, and lags by the same
    amount.
    """
    u = np.maximum(width / 2 - np.abs(since), 0.0)
    ahead: Floats = np.divide(u * u, 2 * width, out=np.zeros_like(u), where=width > 0)
    return -ahead if late else ahead


@dataclass(frozen=True, slots=True)
class RowTimes:
    """When each row of the plan's moves runs, (m,) each; used by `olp track` and plots.

    A row is its body, which follows `profile`, between its pieces in the corners: on its own clock it begins with
    the corner at the end of row `previous` (-1: from rest), and ends with the corner at its own end. The clock
    starts at `start` and runs at `rate`, which is below one for a mechanism that waits for a slower one. So each
    row begins and ends at rest, without a jump, and where rows run at once their displacements add.
    """

    profile: Profile  # of the body
    start: Floats  # [s] from the program's start
    rate: Floats  # [1]
    length: Floats  # [m | rad] corners included
    corners: CornerPieces
    previous: NDArray[np.intp]

    @property
    def entry(self) -> Floats:
        """Time [s] on each row's clock at which its body begins."""
        spans: Floats = np.where(self.previous >= 0, self.corners.span[self.previous], 0.0)
        return spans

    def fraction(self, rows: NDArray[np.intp], time: Floats) -> Floats:
        """Covered share of the path, 0 to 1, of each of `rows` (n,) at `time` (n,) [s]."""
        u = np.maximum((time - self.start[rows]) * self.rate[rows], 0.0)
        entry, body = self.entry[rows], self.profile.duration[rows]
        done = np.where(u > entry, self.profile.take(rows).position(np.maximum(u - entry, 0.0)), 0.0)
        previous = self.previous[rows]
        for at, piece, row, since in (
            (previous >= 0, self.corners.rising, previous, np.minimum(u, entry)),
            (
                u > entry + body,
                self.corners.falling,
                rows,
                np.minimum(u - entry - body, self.corners.span[rows]),
            ),
        ):
            which = np.flatnonzero(at & (self.corners.span[row] > 0))
            if len(which):
                done[which] += piece(row[which], since[which])
        length = self.length[rows]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.clip(np.nan_to_num(done / length), 0.0, 1.0)
        result: Floats = np.where(length > 0, share, (u > 0).astype(float))
        return result


@dataclass(frozen=True, slots=True)
class Timing:
    """One entry per step of the plan; nan where a number does not apply or is unknown.

    `duration_s`, `end_s` [s]; `stop_s` [s]: the part of a duration that the stop at its end costs beyond the
    motion; `distance_mm` [mm]; `speed_mm_s` programmed, `reached_mm_s` highest [mm/s]; `accel_mm_s2` used [mm/s²];
    `speed_pct` programmed joint speed [%], `speed_deg_s` of reorientation [deg/s]; `angle_deg` reorientation [deg].
    """

    plan: Plan
    model: str
    rows: RowTimes
    kind: tuple[str, ...]
    distance_mm: Floats
    speed_mm_s: Floats
    reached_mm_s: Floats
    accel_mm_s2: Floats
    limited_by: tuple[str, ...]
    duration_s: Floats
    stop_s: Floats
    speed_pct: Floats
    speed_deg_s: Floats
    angle_deg: Floats
    assumptions: tuple[Assumption, ...]
    diagnostics: tuple[Diagnostic, ...]
    expected: tuple[float, float] | None = (
        None  # [s] ends of the total's 95 % interval before anything was recorded
    )
    interval: CorrectionInterval | None = None  # with a signature: see olp/timing/correction.py
    unseen: int = 0  # paths outside what the signature learnt

    @property
    def low_s(self) -> float | None:
        """Lower end [s] of the total's 95 % interval; None without a signature."""
        return None if self.interval is None else self.interval.total_low

    @property
    def high_s(self) -> float | None:
        """Upper end [s] of the total's 95 % interval; None without a signature."""
        return None if self.interval is None else self.interval.total_high

    @property
    def expected_low_s(self) -> float | None:
        """Lower end [s] of the total's interval by prior knowledge of such arms; None with a signature."""
        return None if self.expected is None else self.expected[0]

    @property
    def expected_high_s(self) -> float | None:
        """Upper end [s] of the total's interval by prior knowledge of such arms; None with a signature."""
        return None if self.expected is None else self.expected[1]

    @property
    def total_ends(self) -> tuple[float, float] | None:
        """95 % interval [s] of the total: from the signature, else from prior knowledge of such arms."""
        return self.expected if self.interval is None else (self.interval.total_low, self.interval.total_high)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns: COLUMNS, and with a signature the ends of each segment's interval."""
        return COLUMNS if self.interval is None else (*COLUMNS, "low_s", "high_s")

    @property
    def end_s(self) -> Floats:
        """Running total [s]; a step that cannot be timed adds nothing (and has a diagnostic)."""
        ends: Floats = np.cumsum(np.nan_to_num(self.duration_s))
        return ends

    def _sum(self, kind: StepKind) -> float:
        return float(np.nansum(self.duration_s[self.plan.kind == kind]))

    @property
    def motion_s(self) -> float:
        return self._sum(StepKind.MOVE)

    @property
    def wait_s(self) -> float:
        return self._sum(StepKind.WAIT)

    @property
    def io_s(self) -> float:
        return self._sum(StepKind.SIGNAL)

    @property
    def total_s(self) -> float:
        return self.motion_s + self.wait_s + self.io_s

    @property
    def untimed(self) -> int:
        """Number of steps that cannot be timed: the totals do not include them."""
        return int(np.count_nonzero(np.isnan(self.duration_s)))

    @property
    def left_open(self) -> tuple[Diagnostic, ...]:
        """Diagnostics for what the total leaves out, or assumes without a file that says it: do not compare such
        totals.
        """
        return tuple(filter(leaves_open, self.diagnostics))

    @property
    def robot(self) -> str | None:
        return self.plan.robot.name if self.plan.robot else None

    def segments(self) -> Iterator[dict[str, Any]]:
        """Each step as a dict with the keys of COLUMNS; None for what does not apply."""
        numbers = {
            name: [None if math.isnan(v) else v for v in getattr(self, name).tolist()]
            for name in COLUMNS
            if name in _NUMBERS
        }
        plan = self.plan
        lines, sources = plan.line.tolist(), plan.source.tolist()
        for step, (line, source) in enumerate(zip(lines, sources, strict=True)):
            text = plan.sources[source]
            row: dict[str, Any] = {
                "line": line,
                "statement": text.line(line).strip(),
                "kind": self.kind[step],
                "limited_by": self.limited_by[step],
                "file": text.path,
            }
            row.update({name: values[step] for name, values in numbers.items()})
            segment = {name: row[name] for name in COLUMNS}
            if self.interval is not None:
                low, high = float(self.interval.low[step]), float(self.interval.high[step])
                segment["low_s"], segment["high_s"] = (None if math.isnan(v) else v for v in (low, high))
            yield segment

    def frame(self) -> pandas.DataFrame:
        """The segments as a table, units in the column names."""
        import pandas

        plan = self.plan
        files = [utf8(source.path).decode() for source in plan.sources]  # pandas takes no text that is none
        columns: dict[str, Any] = {
            "line": plan.line,
            "statement": [utf8(plan.statement(step)).decode() for step in range(len(plan))],
            "kind": self.kind,
            "limited_by": self.limited_by,
            "file": [files[source] for source in plan.source.tolist()],
        }
        columns.update({name: getattr(self, name) for name in _NUMBERS})
        if self.interval is not None:
            columns.update(low_s=self.interval.low, high_s=self.interval.high)
        return pandas.DataFrame({name: columns[name] for name in self.columns})


_NUMBERS = (
    "distance_mm", "speed_mm_s", "reached_mm_s", "accel_mm_s2", "duration_s", "end_s", "speed_pct", "speed_deg_s",
    "angle_deg",
)  # fmt: skip


# --- Assumptions as findings ---
# What was taken for granted, as findings: for whoever shows it nowhere else. Code: A004.


def assumed(timing: Timing) -> list[Diagnostic]:
    """One note per assumption and place."""
    return [
        info("A004", f"assumed: {says}", Span(line) if line else None, file=file)
        for line, says, file in dict.fromkeys(timing.assumptions)
    ]
