"""What a line does and what a name means, in a few lines of Markdown."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from olp.core.units import deg, mm
from olp.robots.geometry import angles_from_rotation, rotation_from_quaternion
from olp.runtime.plan import StepKind
from olp.servers.language.analysis import Analysis
from olp.servers.language.symbols import PlacedName, definitions, name_at, names

if TYPE_CHECKING:
    from olp.servers.language.service import ProgramService
    from olp.timing.timing import Timing

_MOST = 5  # executions that are told one by one


def hover(service: ProgramService, analysis: Analysis, line: int, column: int) -> str:
    """Markdown for a place; empty where there is nothing to say."""
    parts = [*_line(analysis, line)]
    asked = name_at(names(analysis), line, column)
    if asked is not None:
        parts += _name(service, analysis, asked, line, column)
    return "\n\n".join(parts)


def _line(analysis: Analysis, line: int) -> Iterator[str]:
    timing, steps = analysis.timing, analysis.steps(line)
    if timing is None or not steps:
        return
    seconds = timing.duration_s[steps]
    whole = float(seconds.sum())
    often = f" in {len(steps)} executions" if len(steps) > 1 else ""
    yield f"**{_seconds(whole)}**{often}" if not math.isnan(whole) else "**no time**: see the findings"
    last = steps[min(len(steps), _MOST) - 1]
    for number, step in enumerate(steps[:_MOST], 1):
        told = _move(timing, step) if timing.plan.kind[step] == StepKind.MOVE else ""
        head = f"{number}. " if len(steps) > 1 else "- "
        yield f"{head}{_interval(timing, step)}{told}".rstrip()
    if len(steps) > _MOST:
        yield f"… and {len(steps) - _MOST} more"
    if timing.plan.kind[last] == StepKind.MOVE:
        yield from _pose(timing, steps[-1])


def _interval(timing: Timing, step: int) -> str:
    text = _seconds(float(timing.duration_s[step]))
    if timing.interval is not None:
        low, high = float(timing.interval.low[step]), float(timing.interval.high[step])
        if not math.isnan(low):
            text += f" (95 %: {low:.3f} to {high:.3f})"
    return f"{text}, ends at {float(timing.end_s[step]):.3f} s"


def _move(timing: Timing, step: int) -> str:
    """Way, turn, speeds, acceleration and limit."""
    columns = (
        ("{:.1f} mm", timing.distance_mm),
        ("turns {:.1f}°", timing.angle_deg),
        ("programmed {:g} %", timing.speed_pct),
        ("programmed {:.1f} mm/s", timing.speed_mm_s),
        ("programmed {:g} °/s", timing.speed_deg_s),
        ("reached {:.1f} mm/s", timing.reached_mm_s),
        ("{:.0f} mm/s²", timing.accel_mm_s2),
    )
    found = [text.format(float(of[step])) for text, of in columns if not math.isnan(float(of[step]))]
    if timing.limited_by[step]:
        found.append(f"limited by {timing.limited_by[step]}")
    return ": " + ", ".join(found)


def _pose(timing: Timing, step: int) -> Iterator[str]:
    """Where the move ends: the tool in the base, and the axes."""
    plan = timing.plan
    row = int(plan.row[step])
    target, mechanism = int(plan.moves.target[row]), int(plan.moves.mechanism[row])
    place, turn = plan.positions.position[target], plan.positions.quaternion[target]
    if not np.isnan(place).any():
        x, y, z = place / mm
        rx, ry, rz = angles_from_rotation(rotation_from_quaternion(turn)) / deg
        yield (
            f"ends at X {x:.3f} Y {y:.3f} Z {z:.3f} mm, Rx {rx:.4f} Ry {ry:.4f} Rz {rz:.4f}° (tool in the base)"
        )
    robot = plan.robots[mechanism] if mechanism < len(plan.robots) else None
    if robot is None:
        return
    axes = plan.positions.axes[target][: len(robot.axes)]
    if not np.isnan(axes).any():
        shown = " ".join(
            f"{name} {value / (mm if axis.linear else deg):.3f}{' mm' if axis.linear else '°'}"
            for name, axis, value in zip(robot.axis_names, robot.axes, axes.tolist(), strict=True)
        )
        yield f"axes {shown}"


def _name(
    service: ProgramService, analysis: Analysis, asked: PlacedName, line: int, column: int
) -> Iterator[str]:
    """The line where the name comes into being."""
    for found in definitions(service, analysis, line, column)[:1]:
        if found.line == asked.line and found.file == asked.file:
            continue
        where = f"line {found.line}" if found.file == analysis.path else f"{_base(found.file)}:{found.line}"
        yield f"{asked.kind} of {where}: `{_text(service, analysis, found)}`"


def _text(service: ProgramService, analysis: Analysis, name: PlacedName) -> str:
    from olp.core.source import load

    if name.file == analysis.path:
        return analysis.source.line(name.line).strip()
    if name.file in service.documents:
        return service.documents[name.file].line(name.line).strip()
    try:
        return load(name.file).line(name.line).strip()
    except OSError:
        return ""


def _base(path: str) -> str:
    return path.replace("\\", "/").rpartition("/")[2]


def _seconds(value: float) -> str:
    return "no time" if math.isnan(value) else f"{value:.3f} s"
