"""What every robot file promises: `check_robot`."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from olp.contracts.promises import Difference, Promise, hold
from olp.robots.kinematics.configuration import forward, joints_to_pulses, pulses_to_joints
from olp.robots.kinematics.inverse import inverse
from olp.robots.model import Array, Geometry, Robot
from olp.robots.robot import load_robot, number_groups, robot_names

_DEG: Final = math.pi / 180.0
# What a name says: KUKA R2700 and Yaskawa MA2010 in mm, ABB -2.55 in m; KUKA KR210 and ABB IRB6700-150 in kg.
_REACH: Final = re.compile(r"-r(\d{3,4})\b|^(?:ma|ar)(\d{4})\b|-(\d\.\d{1,2})$")
_PAYLOAD: Final = re.compile(r"^(?:kr|irb\d{3,4}s?t?-|crb\d{5}-)(?:\d+-l)?(\d+)(?![\d.]*l)")
# Bounds that the arms of the library keep, with room to spare: what machines are like, and no law.
_TIP_SPEED: Final = (1.5, 12.0)  # [m/s] of the wrist, arm stretched, by one of the first three axes
_ACCELERATION_TIME: Final = (0.05, 1.5)  # [s] of an axis to its speed
_PULSES: Final = (400.0, 3000.0)  # per degree
# How far each axis turns from the standard stance (upper arm up, forearm and flange forward): the least and the most of
# its lower end, and of its upper end. In that stance all makers' arms are alike, however they count.
_TURNS: Final = (
    ((-190, -150), (150, 190)),
    ((-185, -25), (70, 185)),  # it leans backwards, and forwards
    ((-195, -45), (70, 330)),  # the forearm lowers, and lifts
    ((-410, -135), (135, 410)),
    ((-200, -95), (85, 200)),  # the flange looks down, and up
    ((-470, -85), (170, 600)),
)  # [deg]
_SHORTEST: Final = 5.0  # [mm] of a length, [deg] of a range's end, that is not 0
_LONGEST: Final = 3.0  # [m] of one link
_DIGITS: Final = 3  # decimals of mm and of degrees in data sheets
_PROPORTION: Final = 2.2  # by which a length's share of the arm differs among the arms of a maker


def check_robot(robot: str | Path | Robot, *, first: bool = False) -> None:
    """Raises ContractError with every promise of a robot that `robot` (a name, a file or a Robot) breaks.

    What a file says alone can be judged: that its numbers fit together, what its model's name says of reach and
    payload, and what no machine has. A number that is wrong by a few per cent, of which no other in the file knows, is
    not found: that needs its source.

        from olp.contracts import check_robot
        check_robot("my/robot.toml")
    """
    loaded = robot if isinstance(robot, Robot) else load_robot(robot)
    hold(f"robot {loaded.name}", loaded, PROMISES, first=first)


def names_its_sources(robot: Robot) -> Iterator[Difference]:
    """Every group of numbers has a source, no source is without numbers, and what is inferred says so in its source"""
    groups = number_groups(robot)
    if set(robot.sources) != set(groups):
        yield "[sources]", f"groups {sorted(set(robot.sources) ^ set(groups))} are on one side only"
    for group in groups:
        source = robot.sources.get(group, "")
        if len(source) <= 10:
            yield f"the source of {group}", repr(source)
        if ("inferred" in source) != (group in robot.inferred):
            yield (
                f"the source of {group}",
                "`inferred` names it and its source does not, or the other way round",
            )
    if robot.name != f"{robot.maker}/{robot.model}".lower().replace(" ", "-"):
        yield "maker and model", f"the name is {robot.name}"
    if not robot.controllers:
        yield "controllers", "none"


def has_limits_of_a_machine(robot: Robot) -> Iterator[Difference]:
    """Each axis has a range around its zero, a speed and an acceleration that machines have"""
    if len({axis.name for axis in robot.axes}) != len(robot.axes):
        yield "axes", "two of them have one name"
    for axis in robot.axes:
        given = f"axis {axis.name}"
        span = axis.upper - axis.lower
        if axis.linear:
            if not 0.05 < span < 100.0 or not 0.01 < axis.speed < 20.0:
                yield given, f"{span:g} m at {axis.speed:g} m/s"
            continue
        if not 100 * _DEG < span < (21 * math.tau if abs(axis.upper + axis.lower) < 1e-6 else 3 * math.tau):
            yield given, f"a range of {span / _DEG:.4g} deg"
        if not 30 * _DEG < axis.speed < (1500 if robot.kind == "arm" else 400) * _DEG:
            yield given, f"a speed of {axis.speed / _DEG:.4g} deg/s"
        if axis.acceleration is not None:
            low, high = _ACCELERATION_TIME
            if not low < axis.speed / axis.acceleration < high:
                yield given, f"{axis.speed / axis.acceleration:.4g} s from rest to its speed"
        if axis.pulses_per_unit is not None:
            low, high = _PULSES
            if not low < abs(axis.pulses_per_unit) * _DEG < high:
                yield given, f"{axis.pulses_per_unit * _DEG:.6g} pulses per degree"


def has_axes_of_an_arm(robot: Robot) -> Iterator[Difference]:
    """A six-axis arm turns as far to the left as to the right, and its axes are about as fast as each other"""
    if robot.kind != "arm":
        return
    if not 1.0 <= robot.speeds.max() / robot.speeds.min() < 8.0:
        yield (
            "the speed of the fastest axis to the slowest",
            f"{robot.speeds.max() / robot.speeds.min():.3g} times",
        )
    if len(robot.axes) != 6:
        return
    for at in (0, 3, 5):
        axis = robot.axes[at]
        if not axis.lower < 0.0 < axis.upper or not 0.5 < -axis.upper / axis.lower < 2.0:
            yield f"axis {axis.name}", f"from {axis.lower / _DEG:.4g} to {axis.upper / _DEG:.4g} deg"
    for at in (1, 2, 4):
        axis = robot.axes[at]
        if not 130 * _DEG < axis.upper - axis.lower < 725 * _DEG:
            yield f"axis {axis.name}", f"a range of {(axis.upper - axis.lower) / _DEG:.4g} deg"
    arm, wrist = robot.speeds[:3], robot.speeds[3:]
    for name, ratio, most in (
        ("the arm's fastest axis to its slowest", arm.max() / arm.min(), 2.2),
        ("the wrist's fastest axis to its slowest", wrist.max() / wrist.min(), 3.5),
        ("the wrist's fastest axis to the arm's", wrist.max() / arm.max(), 5.0),
    ):
        if not 0.99 <= ratio < most:
            yield f"the speed of {name}", f"{ratio:.3g} times"


def has_numbers_of_a_data_sheet(robot: Robot) -> Iterator[Difference]:
    """Lengths and ranges are as data sheets print them, in mm and degrees: few decimals, and nothing next to nothing"""
    for axis in robot.axes:
        unit = 1e-3 if axis.linear else _DEG
        for end in (axis.lower, axis.upper):
            whole = axis.pulses_per_unit is not None and _is_rounded(end * axis.pulses_per_unit, 0)
            if not (_is_rounded(end / unit, _DIGITS - 1) or whole) or 0.0 < abs(end / unit) < _SHORTEST:
                yield (
                    f"axis {axis.name}",
                    f"a range that ends at {end / unit:.9g} {'mm' if axis.linear else 'deg'}",
                )
    first = robot.axes[0]
    if first.pulses_per_unit is not None and first.pulses_per_unit < 0.0:
        yield (
            f"axis {first.name}",
            "its pulses fall as it turns: the first axis of every known arm counts with them",
        )
    for name, length in _lengths(robot):
        if abs(length) > _LONGEST or (length < 0.0 and name == "base_height"):
            yield name, f"{length:g} m"
        if not _is_rounded(length * 1e3, _DIGITS) or 0.0 < abs(length * 1e3) < _SHORTEST:
            yield name, f"a length of {length * 1e3:.9g} mm"


def _is_rounded(value: float, decimals: int) -> bool:
    return abs(round(value, decimals) - value) < 1e-6


def _lengths(robot: Robot) -> Iterator[tuple[str, float]]:
    """Every length of the geometry [m], with its name."""
    geometry = robot.geometry
    if geometry is None:
        return
    yield "base_height", geometry.base_height or 0.0
    if geometry.links is not None:
        yield from (
            (name, getattr(geometry.links, name)) for name in ("a1", "a2", "a3", "d4", "d6", "height")
        )
        return
    for joint in geometry.joints:
        yield from ((f"the offset of joint {robot.axes[joint.axis].name}", value) for value in joint.offset)
    yield from (("flange_offset", value) for value in geometry.flange_offset)


def takes_the_standard_stance(robot: Robot) -> Iterator[Difference]:
    """From upper arm up and forearm forward each axis turns about as far as those of other arms, however it counts"""
    links = None if robot.geometry is None else robot.geometry.links
    if links is None or robot.kind != "arm":
        return
    if any(sign not in (-1, 1) for sign in links.signs):
        yield "signs", f"{links.signs}"
    if any(zero / _DEG % 90 > 1e-9 or abs(zero) > math.pi + 1e-9 for zero in links.zeros):
        yield "zero_deg", f"{[f'{zero / _DEG:g}' for zero in links.zeros]}"
    if links.height < 0.0:
        yield "origin_below_mm", f"{links.height * 1e3:g} mm"
    zeros = (0.0, *links.zeros[1:])  # whether the base's x or its y points to the front is the maker's choice
    for axis, sign, zero, bounds in zip(robot.axes, links.signs, zeros, _TURNS, strict=True):
        ends = sorted((sign * end + zero) / _DEG for end in (axis.lower, axis.upper))
        for end, (least, most), what in zip(ends, bounds, ("down", "up"), strict=True):
            if not least <= end <= most:
                yield f"axis {axis.name}", f"it turns {what} to {end:.4g} deg from the standard stance"


def counts_as_its_maker(robot: Robot) -> Iterator[Difference]:
    """Directions and zeros of the axes are those of another arm of its maker, or the source of the lengths says so"""
    others = [other.geometry for other in _others(robot) if other.geometry is not None]
    if robot.geometry is None or robot.kind != "arm" or not others:
        return
    links = robot.geometry.links
    if links is None:
        yield from _is_built_as(robot, [other for other in others if other.links is None])
        return
    source, spherical = robot.sources.get("links", ""), [other.links for other in others if other.links]
    for name, own, known in (
        ("signs", links.signs, [other.signs for other in spherical]),
        ("zero_deg", links.zeros, [other.zeros for other in spherical]),
    ):
        same = any(np.allclose(np.subtract(own, other) % math.tau, 0.0) for other in known)
        told = "the other way" in source if name == "signs" else "at zero" in source or "= 0" in source
        if spherical and not same and not told:
            yield name, f"{[round(float(x), 4) for x in own]}, as no other arm of {robot.maker}"


def _others(robot: Robot) -> list[Robot]:
    """The other robots of its maker in the library."""
    maker = f"{robot.name.partition('/')[0]}/"
    return [load_robot(name) for name in robot_names() if name.startswith(maker) and name != robot.name]


def _is_built_as(robot: Robot, others: list[Geometry]) -> Iterator[Difference]:
    """The offsets of a chain beside those of the maker's chains with the same directions: sides and proportions."""
    assert robot.geometry is not None
    own = robot.geometry
    directions = [joint.direction for joint in own.joints]
    alike = [other for other in others if [joint.direction for joint in other.joints] == directions]
    if not alike:
        return
    mine, theirs = _shares(own), np.array([_shares(other) for other in alike])
    for k, offset in enumerate((*(joint.offset for joint in own.joints), own.flange_offset)):
        for side in range(3):
            share, least, most = mine[k, side], theirs[:, k, side].min(), theirs[:, k, side].max()
            low = least / _PROPORTION if least > 0.0 else least * _PROPORTION
            high = most * _PROPORTION if most > 0.0 else most / _PROPORTION
            if not low <= share <= high:
                yield (
                    f"offset {k + 1}",
                    f"{[f'{x * 1e3:g}' for x in offset]} mm, as no other arm of {robot.maker}",
                )


def _shares(geometry: Geometry) -> Array:
    """(joints + 1, 3) the offsets over the length of the two longest."""
    rows = np.array([*(joint.offset for joint in geometry.joints), geometry.flange_offset])
    found: Array = rows / np.sort(np.linalg.norm(rows, axis=1))[-2:].sum()
    return found


def reaches_what_its_name_says(robot: Robot) -> Iterator[Difference]:
    """The wrist reaches what the model's name says, the payload is that of its name"""
    name = robot.model.lower().replace(" ", "-")
    links = None if robot.geometry is None else robot.geometry.links
    told = _REACH.search(name)
    if told is not None and links is not None:
        reach = links.a1 + links.a2 + math.hypot(links.a3, links.d4)
        wanted = float(told[3]) if told[3] else float(told[1] or told[2]) / 1000.0
        if not 0.98 < reach / wanted < 1.06:
            yield f"the name {robot.model}", f"the wrist reaches {reach:.3f} m"
    if robot.payload is not None:
        heavy = _PAYLOAD.search(name)
        variant = re.search(r"-l(\d+)", name)
        wanted = float(variant[1]) if variant else float(heavy[1]) if heavy else robot.payload
        if wanted != robot.payload or not 0.3 <= robot.payload <= 2500.0:
            yield f"the name {robot.model}", f"a payload of {robot.payload:g} kg"


def has_lengths_of_an_arm(robot: Robot) -> Iterator[Difference]:
    """The arm's lengths are those of an arm: between 0.15 and 4.3 m at zero, fast enough at its end and not too fast"""
    geometry = robot.geometry
    if geometry is None or robot.kind != "arm":
        return
    stretched = float(np.linalg.norm(forward(robot, np.zeros((1, len(robot.axes))))[0]))
    if not 0.15 < stretched < 4.3:
        yield "all axes at zero", f"the flange is {stretched:.3f} m from the base's origin"
    if geometry.base_height is not None and not 0.0 <= geometry.base_height < 1.6:
        yield "base_height", f"{geometry.base_height:g} m"
    for joint in geometry.joints:
        if abs(math.hypot(*joint.direction) - 1.0) > 1e-9:
            yield f"joint {joint.axis}", f"its direction has the length {math.hypot(*joint.direction):g}"
    links = geometry.links
    if links is None:
        return
    reach = links.a1 + links.a2 + math.hypot(links.a3, links.d4)
    low, high = _TIP_SPEED
    for axis in range(3):
        if not low < reach * robot.axes[axis].speed < high:
            yield f"axis {robot.axes[axis].name}", f"{reach * robot.axes[axis].speed:.3g} m/s at the wrist"
    scale = links.a2 + links.d4
    for name, length, least, most in (
        ("a1", links.a1, 0.0, 0.35),
        ("a2", links.a2, 0.32, 0.65),
        ("a3", links.a3, -0.04, 0.2),
        ("d4", links.d4, 0.35, 0.68),
        ("d6", links.d6, 0.03, 0.17),
        ("base_height", geometry.base_height or 0.0, 0.0, 0.75),
    ):
        if scale <= 0.0 or not least <= length / scale <= most:
            yield name, f"{length:g} m, of an arm with {scale:.3g} m from axis L to the wrist"


def goes_there_and_back(robot: Robot) -> Iterator[Difference]:
    """Poses computed from axes lead back to them, and so do pulses"""
    geometry = robot.geometry
    rng = np.random.default_rng(4)
    share = rng.uniform(0.3, 0.7, (6, len(robot.axes)))
    span = np.minimum(robot.upper, 170 * _DEG) - np.maximum(robot.lower, -170 * _DEG)
    joints = np.maximum(robot.lower, -170 * _DEG) + share * span
    if geometry is not None and geometry.links is not None:
        position, rotation = forward(robot, joints)
        if np.abs(rotation @ rotation.transpose(0, 2, 1) - np.eye(3)).max() > 1e-9:
            yield "random axes", "the flange's axes are not at right angles"
        found, reached = inverse(robot, position, rotation)
        again, turned = forward(robot, found)
        if (
            not reached.all()
            or np.abs(again - position).max() > 1e-6
            or np.abs(turned - rotation).max() > 1e-6
        ):
            yield "poses of random axes", "the axes that are found for them lead elsewhere"
    if robot.knows_pulses:
        back = pulses_to_joints(robot, joints_to_pulses(robot, joints))
        if np.abs(back - joints).max() > 1e-3 * _DEG:
            yield "pulses of random axes", "they lead to other axes"


def has_timing_of_a_controller(robot: Robot) -> Iterator[Difference]:
    """Blend zones grow, and acceleration of the tool and settling are those of controllers"""
    zones = robot.blend_zones or ()
    if any(b <= a for a, b in itertools.pairwise(zones)) or not all(1e-3 < z < 1.0 for z in zones):
        yield "blend_zones", f"{[f'{zone:g}' for zone in zones]} m"
    if robot.linear_acceleration is not None and not 0.1 < robot.linear_acceleration < 30.0:
        yield "linear_acceleration", f"{robot.linear_acceleration:g} m/s²"
    if robot.settling_time is not None and not 0.0 <= robot.settling_time < 1.0:
        yield "settling_time", f"{robot.settling_time:g} s"
    if robot.acceleration_filter is not None and not 0.02 < robot.acceleration_filter < 0.6:
        yield "acceleration_filter", f"{robot.acceleration_filter:g} s"
    measured = robot.pose_accelerations.ranges if robot.pose_accelerations else ()
    for axis, (low, high) in zip(robot.axes, measured, strict=False):
        if axis.acceleration is None or not low < axis.acceleration < high:
            yield (
                "pose_accelerations",
                f"axis {axis.name}: {low:g} to {high:g} rad/s² without its acceleration",
            )


def weighs_what_an_arm_weighs(robot: Robot) -> Iterator[Difference]:
    """Masses and inertias belong to bodies: positive, and no inertia is larger than that of the others together"""
    if robot.dynamics is None:
        return
    for body in robot.dynamics.bodies:
        if not 0.0 <= body.mass < 3000.0:
            yield "a body", f"a mass of {body.mass:g} kg"


PROMISES: Final[tuple[Promise[Robot], ...]] = (
    names_its_sources,
    has_limits_of_a_machine,
    has_numbers_of_a_data_sheet,
    takes_the_standard_stance,
    counts_as_its_maker,
    has_axes_of_an_arm,
    reaches_what_its_name_says,
    has_lengths_of_an_arm,
    goes_there_and_back,
    has_timing_of_a_controller,
    weighs_what_an_arm_weighs,
)
