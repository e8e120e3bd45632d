"""Seconds per step, in columns; the names of the columns are those of `olp time --format json`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from olp.diagnostic import Diagnostic
from olp.motion import Profile
from olp.plan import Assumption, Plan, StepKind

if TYPE_CHECKING:
    import pandas

    from olp.timing.signed_interval import Interval

Floats = NDArray[np.float64]

# Name, decimals shown: what a segment is told by.
COLUMNS: tuple[str, ...] = (
    "line", "statement", "kind", "distance_mm", "speed_mm_s", "reached_mm_s", "accel_mm_s2",
    "limited_by", "duration_s", "end_s", "speed_pct", "speed_deg_s", "angle_deg", "file",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class RowTimes:
    """When each row of the plan's moves runs, (m,) each; what `olp track` and plots need.

    A row's own clock starts `ramp / 2` before the end of the step before it. In its first `ramp` seconds it runs
    at a growing share of its profile's speed (the corner's overlap), so at time u on its clock the profile
    stands at u²/(2 ramp), later at u - ramp/2. `rate`: the clock of a mechanism that waits for a slower one.
    """

    profile: Profile
    start: Floats  # [s] from the program's start
    ramp: Floats  # [s]
    rate: Floats  # [1]
    length: Floats  # as the profile counts it


@dataclass(frozen=True, slots=True)
class Timing:
    """One entry per step of the plan; nan where a number does not apply or is not known.

    `duration_s`, `end_s` [s]; `distance_mm` [mm]; `speed_mm_s` programmed, `reached_mm_s` highest [mm/s];
    `accel_mm_s2` used [mm/s²]; `speed_pct` programmed joint speed [%], `speed_deg_s` of reorientation [deg/s];
    `angle_deg` reorientation [deg].
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
    speed_pct: Floats
    speed_deg_s: Floats
    angle_deg: Floats
    assumptions: tuple[Assumption, ...]
    diagnostics: tuple[Diagnostic, ...]
    interval: Interval | None = None  # with a signature: see olp/timing/signed.py

    @property
    def low_s(self) -> float | None:
        """[s] The lower end of the 95 % interval of the total; None without a signature."""
        return None if self.interval is None else self.interval.total_low

    @property
    def high_s(self) -> float | None:
        """[s] The upper end."""
        return None if self.interval is None else self.interval.total_high

    @property
    def columns(self) -> tuple[str, ...]:
        """COLUMNS, and with a signature the ends of each segment's interval."""
        return COLUMNS if self.interval is None else (*COLUMNS, "low_s", "high_s")

    @property
    def end_s(self) -> Floats:
        """Running total; a step that cannot be timed adds nothing (and has a diagnostic)."""
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
        """Number of steps that cannot be timed: the totals leave them out."""
        return int(np.count_nonzero(np.isnan(self.duration_s)))

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
        columns: dict[str, Any] = {
            "line": plan.line,
            "statement": [plan.statement(step) for step in range(len(plan))],
            "kind": self.kind,
            "limited_by": self.limited_by,
            "file": [plan.sources[s].path for s in plan.source.tolist()],
        }
        columns.update({name: getattr(self, name) for name in _NUMBERS})
        if self.interval is not None:
            columns.update(low_s=self.interval.low, high_s=self.interval.high)
        return pandas.DataFrame({name: columns[name] for name in self.columns})


_NUMBERS = (
    "distance_mm", "speed_mm_s", "reached_mm_s", "accel_mm_s2", "duration_s", "end_s", "speed_pct", "speed_deg_s",
    "angle_deg",
)  # fmt: skip
