"""Which of a control group's numbers cannot be true, or are not enough for a robot file."""

from __future__ import annotations

from collections.abc import Iterator

from olp.core.diagnostic import Diagnostic, Severity
from olp.robots.backup.parameters import GroupParameters

AXIS_NAMES = ("S", "L", "U", "R", "B", "T", "E", "8")
_PULSES_PER_DEGREE = (100.0, 20_000.0)  # arms and stations of published backups: 455 .. 11,378
_TURN = 1_080.0  # [deg], three turns: no soft limit of an arm or a station is farther
_FASTEST = 2_000.0  # [deg/s], twice the fastest wrist of a data sheet


def axis_name(group_name: str, axis: int) -> str:
    """S, L, U, R, B, T, E for a robot; 1, 2 .. for a base or a station. `axis` counts from 0."""
    return AXIS_NAMES[axis] if group_name.startswith("R") else str(axis + 1)


def shortest_degrees(pulses: int, pulses_per_degree: float) -> float:
    """[deg] with as few decimals as name the same pulse.

    Controllers round limits and speeds away from zero to whole pulses (180 deg is stored as 241,449 where
    241,448.4 would do), so the number meant is the shortest one less than a pulse away.
    """
    exact = pulses / pulses_per_degree
    for decimals in range(7):
        value = round(exact, decimals)
        if abs(value * pulses_per_degree - pulses) < 1.0:
            return value
    return exact


def implausible(
    parameters: GroupParameters, name: str, model: str = "", file: str = ""
) -> tuple[Diagnostic, ...]:
    """All findings on the group called `name` (R1, S1): errors where no robot file can be made, else
    warnings.
    """
    section = f"///RC{parameters.group}G"
    if name.startswith("B") or "RECT" in model or "TRAVERSE" in model:
        says = "the millimetres per motor turn are not in the parameter files: write the track's file by hand"
        found = [("B012", f"{name} is a track or slide", Severity.ERROR, says)]
    else:
        found = [
            *_axis_findings(parameters, name),
            *_speed_findings(parameters),
            *_link_findings(parameters, name),
        ]
    return tuple(
        Diagnostic(
            code, f"{section}: {message}", severity, file or parameters.file, parameters.line, help=says
        )
        for code, message, severity, says in found
    )


def _axis_findings(parameters: GroupParameters, name: str) -> Iterator[tuple[str, str, Severity, str]]:
    ratios = zip(
        parameters.axes,
        parameters.numerators,
        parameters.denominators,
        parameters.pulses_per_degree,
        parameters.lower,
        parameters.upper,
        parameters.speeds,
        strict=True,
    )
    data_sheet = "take this axis from the data sheet and write the file by hand"
    for index, above, below, per_degree, lower, upper, speed in ratios:
        axis = f"axis {axis_name(name, index)}"
        if below == 0 or above < 0:
            yield "B007", f"{axis} has the gear ratio {above}/{below}", Severity.ERROR, data_sheet
            continue
        if above == abs(below):
            says = "a ratio of 1:1 is a placeholder; the axis is geared elsewhere. " + data_sheet
            yield "B007", f"{axis} has a gear ratio of 1:1", Severity.ERROR, says
            continue
        if not _PULSES_PER_DEGREE[0] <= per_degree <= _PULSES_PER_DEGREE[1]:
            yield "B007", f"{axis} has {per_degree:g} pulses per degree", Severity.WARNING, ""
        if lower >= upper:
            message = f"{axis} has a lower soft limit of {lower} and an upper of {upper} pulses"
            yield "B007", message, Severity.ERROR, data_sheet
        elif max(-lower, upper) > _TURN * per_degree:
            message = f"{axis} may turn {max(-lower, upper) / per_degree:.0f} deg"
            yield "B007", message, Severity.WARNING, "a limit that was switched off looks like this"
        if speed <= 0:
            yield "B007", f"{axis} has a rated speed of {speed} pulses/s", Severity.ERROR, data_sheet
        elif speed > _FASTEST * per_degree:
            yield "B007", f"{axis} turns at {speed / per_degree:.0f} deg/s", Severity.WARNING, ""


def _speed_findings(parameters: GroupParameters) -> Iterator[tuple[str, str, Severity, str]]:
    """Users change soft limits but not rated speeds: one that is not round was read from the wrong slot."""
    pairs = zip(parameters.speeds, parameters.pulses_per_degree, strict=True)
    speeds = [shortest_degrees(speed, per_degree) for speed, per_degree in pairs if per_degree]
    if any(abs(speed - round(speed, 1)) > 1e-9 for speed in speeds):
        shown = ", ".join(f"{speed:g}" for speed in speeds)
        says = "on all controllers met they are; compare the file with the robot's data sheet before using it"
        yield "B007", f"the rated speeds are not round degrees: {shown} deg/s", Severity.WARNING, says


def _link_findings(parameters: GroupParameters, name: str) -> Iterator[tuple[str, str, Severity, str]]:
    """Without usable links a robot file has no geometry: joint moves can be timed, poses cannot be
    computed.
    """
    if not name.startswith("R"):
        return
    if parameters.axes != tuple(range(6)):
        names = " ".join(axis_name(name, axis) for axis in parameters.axes) or "none"
        message = f"the axes are {names}; link lengths describe six-axis arms and are left out"
        yield "B007", message, Severity.WARNING, "add a [chain] to the robot file"
    elif not has_links(parameters):
        shown = ", ".join(f"{key} {value * 1e3:g}" for key, value in parameters.links.items())
        says = "take the lengths from the data sheet and add [links] to the robot file"
        yield "B007", f"the link lengths cannot be true ({shown} mm) and are left out", Severity.WARNING, says


def has_links(parameters: GroupParameters) -> bool:
    """Whether the links describe a six-axis arm: an upper and a lower arm, none longer than any arm made."""
    links = parameters.links
    long_enough = links["a2"] > 0.0 and links["d4"] > 0.0
    return parameters.axes == tuple(range(6)) and long_enough and max(map(abs, links.values())) < 5.0
