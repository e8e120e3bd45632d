"""`olp robots`: the library of robots, and how far each can be trusted."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from olp.core.diagnostic import Diagnostic, OlpError
from olp.core.units import deg, mm

if TYPE_CHECKING:
    from olp.robots.model import Axis, Robot

SUMMARY = "list the known robots and what is known of each"

COLUMNS = ("robot", "kind", "axes", "pulses", "poses", "zones", "accelerations")
NOTES = """\
pulses: how many make a degree or millimetre; poses: computed from pulses and compared with the controller's
own coordinates; zones: of the position levels PL; accelerations: of the axes."""


def add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "robots",
        nargs="*",
        metavar="ROBOT",
        help="a name (yaskawa/ma2010) or a robot file (default: all)",
    )
    parser.add_argument(
        "--format", choices=("text", "json", "markdown"), default="text", help="default: text"
    )
    parser.add_argument("-v", "--verbose", action="store_true", help="also say where the numbers are from")


def run(args: Namespace) -> int:
    from olp.robots.robot import robot_names

    robots = load_all(args.robots or robot_names())
    print({"text": as_text, "json": as_json, "markdown": as_markdown}[args.format](robots, args.verbose))
    return 0


def load_all(names: Sequence[str]) -> list[Robot]:
    """The robots of these names or files. Raises OlpError with the problems of all of them."""
    from olp.robots.robot import load_robot

    robots: list[Robot] = []
    problems: list[Diagnostic] = []
    for name in names:
        try:
            robots.append(load_robot(name))
        except OlpError as problem:
            problems.extend(problem.diagnostics)
    if problems:
        raise OlpError(*problems)
    return robots


def as_text(robots: Sequence[Robot], verbose: bool) -> str:
    """One line per robot in aligned columns; with `verbose` its sources below it."""
    rows = [COLUMNS, *map(summary, robots)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
    if verbose:
        for number, robot in reversed(list(enumerate(robots, 1))):
            lines[number + 1 : number + 1] = [f"    {line}" for line in sources(robot)]
    return "\n".join([*lines, "", NOTES])


def as_markdown(robots: Sequence[Robot], verbose: bool) -> str:
    """A table; with `verbose` the sources in a last column."""
    header = (*COLUMNS, "sources") if verbose else COLUMNS
    body = [(*summary(robot), "<br>".join(sources(robot))) if verbose else summary(robot) for robot in robots]
    return "\n".join(f"| {' | '.join(row)} |" for row in (header, ["---"] * len(header), *body))


def as_json(robots: Sequence[Robot], verbose: bool) -> str:
    """A list of objects, units in the key names; with `verbose` the sources too."""
    import json

    return json.dumps([record(robot, verbose) for robot in robots], indent=2, ensure_ascii=False)


def summary(robot: Robot) -> tuple[str, ...]:
    """What the table says of one robot, in the order of COLUMNS."""
    if robot.geometry is None:
        poses = "no geometry"
    else:
        poses = "verified" if robot.pose_verified else "not verified"
    return (
        robot.name,
        robot.kind,
        " ".join(robot.axis_names),
        known(robot.knows_pulses),
        poses,
        known(robot.blend_zones is not None),
        known(*(axis.acceleration is not None for axis in robot.axes)),
    )


def known(*parts: bool) -> str:
    """One word for all parts, or how many of them are known."""
    if all(parts):
        return "known"
    return f"{sum(parts)} of {len(parts)}" if any(parts) else "unknown"


def sources(robot: Robot) -> list[str]:
    """One line per group of numbers: what, whether inferred, from where."""
    return [
        f"{group}{' (inferred)' if group in robot.inferred else ''}: {source}"
        for group, source in robot.sources.items()
    ]


def record(robot: Robot, verbose: bool) -> dict[str, Any]:
    """Everything of one robot for other programs, in the field's units."""
    zones = robot.blend_zones
    acceleration = robot.linear_acceleration
    entry: dict[str, Any] = {
        "robot": robot.name,
        "maker": robot.maker,
        "model": robot.model,
        "kind": robot.kind,
        "controllers": list(robot.controllers),
        "payload_kg": robot.payload,
        "axes": [axis_record(axis) for axis in robot.axes],
        "has_geometry": robot.geometry is not None,
        "pose_verified": robot.pose_verified,
        "zones_mm": None if zones is None else [round(zone / mm, 6) for zone in zones],
        "linear_acceleration_mm_s2": None if acceleration is None else round(acceleration / mm, 6),
        "settling_time_s": robot.settling_time,
    }
    if verbose:
        entry |= {"sources": dict(robot.sources), "inferred": list(robot.inferred)}
    return entry


def axis_record(axis: Axis) -> dict[str, Any]:
    """One axis, in degrees or, when it slides, in millimetres; null is not known."""
    name, unit = ("mm", mm) if axis.linear else ("deg", deg)
    acceleration, pulses = axis.acceleration, axis.pulses_per_unit
    return {
        "axis": axis.name,
        f"lower_{name}": round(axis.lower / unit, 6),
        f"upper_{name}": round(axis.upper / unit, 6),
        f"speed_{name}_s": round(axis.speed / unit, 6),
        f"acceleration_{name}_s2": None if acceleration is None else round(acceleration / unit, 6),
        f"pulses_per_{name}": None if pulses is None else round(pulses * unit, 6),
    }
