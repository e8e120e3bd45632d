"""Every group of numbers in a robot file names its source: which groups there are, and the check."""

from __future__ import annotations

from typing import Final

from olp.robots.document import RobotDocument
from olp.robots.model import Robot

SOURCE_GROUPS: Final = (
    "limits", "speed", "acceleration", "pulses", "links", "chain", "base_height", "blend_zones",
    "linear_acceleration", "settling_time", "payload", "pose",
    "masses", "inertias", "torque_limits", "rotors", "friction",
)  # fmt: skip


def number_groups(robot: Robot) -> tuple[str, ...]:
    """The groups of numbers that `robot` holds, each of which needs an entry in its `sources`."""
    geometry = robot.geometry
    bodies = robot.dynamics.bodies if robot.dynamics else ()
    drives = robot.dynamics.drives if robot.dynamics else ()
    held = {
        "limits": True,
        "speed": True,
        "acceleration": any(axis.acceleration is not None for axis in robot.axes),
        "pulses": any(axis.pulses_per_unit is not None for axis in robot.axes),
        "links": geometry is not None and geometry.links is not None,
        "chain": geometry is not None and geometry.links is None,
        "base_height": geometry is not None and geometry.base_height is not None,
        "blend_zones": robot.blend_zones is not None,
        "linear_acceleration": robot.linear_acceleration is not None,
        "settling_time": robot.settling_time is not None,
        "payload": robot.payload is not None,
        "pose": robot.pose_verified,
        "masses": bool(bodies),
        "inertias": any(any(body.inertia) for body in bodies),
        "torque_limits": any(drive.limit is not None for drive in drives),
        "rotors": any(drive.rotor for drive in drives),
        "friction": any(drive.viscous or drive.coulomb for drive in drives),
    }
    return tuple(group for group in SOURCE_GROUPS if held[group])


def read_sources(document: RobotDocument) -> dict[str, str]:
    """The table `[sources]` as it stands, its unknown keys reported (R003)."""
    table = document.subtable("sources") or {}
    start = document.table_start("sources")
    document.known_keys(table, SOURCE_GROUPS, "sources", start)
    return {key: document.word(table, key, start) or "" for key in table}


def check_sources(document: RobotDocument, robot: Robot) -> None:
    """Reports groups of numbers without a source (R006), and inferred groups that are not there (R005)."""
    groups = number_groups(robot)
    missing = [group for group in groups if group not in robot.sources]
    if missing:
        advice = f'[sources] {missing[0]} = "data sheet of ..., page ..., or how it was measured"'
        document.report("R006", f"no source is stated for: {', '.join(missing)}", "sources", help=advice)
    for group in robot.inferred:
        if group not in groups:
            document.report("R005", f"inferred names {group!r}, which the file does not hold", "inferred")
