"""Shared by text and Markdown: which numbers of a segment are shown, and with how many digits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from olp.core.source import file_name

if TYPE_CHECKING:
    from olp.timing.result import Timing

HEADER = ("line", "statement", "mm", "V mm/s", "top mm/s", "mm/s²", "limited by", "time s", "end s")
LEFT = {1, 6}  # columns of text; all others are numbers and stand right


def rows(timing: Timing) -> Iterator[tuple[str, ...]]:
    """One tuple of cells per step."""
    for segment in timing.segments():
        yield (
            str(segment["line"]),
            _statement(segment, timing),
            _number(segment["distance_mm"], 1),
            _speed(segment),
            _number(segment["reached_mm_s"], 1),
            _number(segment["accel_mm_s2"], 0),
            segment["limited_by"],
            _number(segment["duration_s"], 3) or "unknown",
            _number(segment["end_s"], 3),
        )


def _statement(segment: dict[str, Any], timing: Timing) -> str:
    """Text of the statement; a line of another job names that job, because its line numbers start anew."""
    text: str = segment["statement"]
    if segment["file"] == timing.plan.path:
        return text
    return f"{file_name(segment['file'])}: {text}"


def _speed(segment: dict[str, Any]) -> str:
    if segment["speed_pct"] is not None:
        return f"{segment['speed_pct']:g} %"
    if segment["speed_mm_s"] is None and segment["speed_deg_s"] is not None:
        return f"{segment['speed_deg_s']:g} °/s"
    return _number(segment["speed_mm_s"], 1)


def _number(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}"


def totals(timing: Timing) -> str:
    """One sentence with the sums."""
    parts = f"motion {timing.motion_s:.3f} s, waits {timing.wait_s:.3f} s, I/O {timing.io_s:.3f} s"
    robot = timing.robot or "robot not known"
    total = at_least(timing.total_s, bool(timing.left_open))
    ends = None if timing.left_open and timing.interval is None else timing.total_ends
    between = "" if ends is None else f" (95 %: {ends[0]:.3f} to {ends[1]:.3f})"
    by = f"{timing.model} acceleration model" if timing.interval is None else "timing signature"
    return f"total {total} s{between} ({parts}), {robot}, {by}"


def missing(timing: Timing) -> str:
    """One sentence on what the sums do not include; empty for nothing."""
    wrong = sum(d.is_error for d in timing.left_open)
    assumed = len(timing.left_open) - wrong
    parts = [
        f"{timing.untimed} of {len(timing.kind)} steps have no time" if timing.untimed else "",
        f"{wrong} error{'s' * (wrong > 1)}" if wrong else "",
        f"{assumed} line{'s' * (assumed > 1)} with what no file says" if assumed else "",
    ]
    told = ", ".join(part for part in parts if part)
    return f"incomplete: {told}" if timing.left_open else ""


def at_least(seconds: float, incomplete: bool) -> str:
    """A sum; an incomplete one is marked with >=."""
    return f"{'>= ' * incomplete}{seconds:.3f}"


def grouped(timing: Timing) -> list[str]:
    """The assumptions, each sentence once with all its lines; lines of another job name it."""
    lines: dict[tuple[str, str], list[int]] = {}
    for assumption in timing.assumptions:
        lines.setdefault((assumption.says, assumption.file), []).append(assumption.line)
    return [
        _with_lines(says, "" if file in ("", timing.plan.path) else file_name(file) + " ", numbers)
        for (says, file), numbers in lines.items()
    ]


def _with_lines(says: str, file: str, numbers: list[int]) -> str:
    known = sorted({n for n in numbers if n})
    if not known:
        return says
    shown = ", ".join(map(str, known[:8])) + (f" and {len(known) - 8} more" if len(known) > 8 else "")
    return f"{file}line{'s' * (len(known) > 1)} {shown}: {says}"
