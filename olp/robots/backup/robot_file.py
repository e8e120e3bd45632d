"""Robot file (TOML) from a controller's backup; every number names the file and the slot it is from."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Final, NamedTuple

from olp.core.diagnostic import Diagnostic, OlpError, Severity, error, info, raise_errors, warning
from olp.core.toml import ROBOT_NAME, plain, quoted, shown
from olp.core.units import deg, mm, ms
from olp.robots import EXAMPLE_ROBOT
from olp.robots.backup.backup import Backup
from olp.robots.backup.cnd_files import ToolData, UserFrame, Vector
from olp.robots.backup.parameters import LINK_SLOTS, ZONE_SLOTS, BackupControlGroup, GroupParameters

if TYPE_CHECKING:
    from olp.robots.model import Robot


# --- Check ---
# What stands against making a robot file from a backup, and what its user should know.
#
# Some of a control group's numbers cannot be true, or are not enough for a robot file. A backup proves its own arm:
# user frames hold both the pulses they were taught at and the frame that came out.
#
# A frame is right when the three points, computed from the pulses with the arm's model and the tool, give the
# stored frame again. On a published AR2010 (YRC1000, three frames) the largest difference is 0.0005 mm and
# 0.00006 deg.


_POINTS: Final = ("RORG", "RXX", "RXY")
# The file rounds to 0.001 mm and pulses to 0.001 deg, which turns a frame of 100 mm by less than this.
CLOSE: Final = 0.1 * mm  # [m]
CLOSE_ANGLE: Final = 0.05 * deg  # [rad]

Taught = list[tuple[UserFrame, Vector]]  # frames with the tip [m] of the tool they were taught with


class Stance(NamedTuple):
    """Posture of an arm at zero pulses: the standard angle of an axis is sign x reading + zero [rad]."""

    signs: tuple[int, ...] = (1,) * 6
    zeros: tuple[float, ...] = (0.0,) * 6
    source: str = ""


# Those of Yaskawa's six-axis arms: upright; with the flange down at B = 0; shelf-mounted.
STANCES: Final = (
    Stance(),
    Stance(zeros=(0.0, 0.0, 0.0, 0.0, -90.0 * deg, 0.0)),
    Stance(zeros=(0.0, 90.0 * deg, 0.0, 0.0, 0.0, 0.0)),
)


class FrameAgreement(NamedTuple):
    """The largest differences between stored and computed frames, over the `frames` that could be computed."""

    frames: tuple[int, ...]  # their numbers
    distance: float  # [m]
    angle: float  # [rad]
    unseen: tuple[int, ...] = ()  # axes (from 0) whose sense could be turned over without being noticed

    @property
    def close(self) -> bool:
        return self.distance <= CLOSE and self.angle <= CLOSE_ANGLE

    @property
    def proves(self) -> bool:
        """Whether poses may be trusted: the frames agree, and would not agree if any axis turned the other way."""
        return self.close and not self.unseen


def find_stance(
    parameters: GroupParameters, frames: dict[int, UserFrame], tools: dict[int, ToolData], name: str = ""
) -> tuple[Stance, FrameAgreement | None]:
    """The arm's stance, and how well its user frames agree with it; None if no frame was taught with this arm
    alone.

    The stance is that of the library's robot `name`, if there is one, unless the frames prove another. `parameters`
    must be those of a six-axis arm with links.
    """
    taught = [
        (frame, tools[frame.tool].position)
        for _, frame in sorted(frames.items())
        if frame.groups == (parameters.group,) and frame.tool in tools
        if all(len(frame.taught.get(point, ())) >= 6 for point in _POINTS)
    ]
    known = _library_stance(name)
    stances = STANCES if known is None else (known, *STANCES)
    first: FrameAgreement | None = None
    for stance in stances:
        agreement = _agreement(parameters, taught, stance)
        if agreement is not None and agreement.proves:
            return stance._replace(source=stance.source or "confirmed by the user frames"), agreement
        first = first or agreement
    return stances[0], first


def _library_stance(name: str) -> Stance | None:
    from olp.robots.robot import load_robot, robot_names

    if name not in robot_names():
        return None
    geometry = load_robot(name).geometry
    if geometry is None or geometry.links is None:
        return None
    return Stance(geometry.links.signs, geometry.links.zeros, f"stance at zero as in the library's {name}")


def _agreement(parameters: GroupParameters, taught: Taught, stance: Stance) -> FrameAgreement | None:
    agreement = _compared(parameters, taught, stance)
    if agreement is None or not agreement.close:
        return agreement
    turned = (_compared(parameters, taught, stance, axis) for axis in range(6))
    unseen = tuple(axis for axis, other in enumerate(turned) if other is not None and other.close)
    return agreement._replace(unseen=unseen)


def _compared(
    parameters: GroupParameters, taught: Taught, stance: Stance, turned: int | None = None
) -> FrameAgreement | None:
    """The differences between computed and stored frames; `turned`: an axis to be turned in the other direction."""
    import numpy as np

    from olp.robots.geometry import frame_from_points, rotation_angle, rotation_from_angles
    from olp.robots.kinematics.configuration import forward

    robot = _robot(parameters, stance)
    used: list[int] = []
    distance = angle = 0.0
    for frame, tip in taught:
        joints = np.array([parameters.radians(frame.taught[point][:6]) for point in _POINTS])
        if turned is not None:
            joints[:, turned] *= -1.0
        positions, rotations = forward(robot, joints)
        try:
            found = frame_from_points(*(positions + rotations @ np.array(tip)))
        except OlpError:
            continue  # three points on one line tell nothing about the arm
        used.append(frame.number)
        distance = max(distance, float(np.max(np.abs(found.position - np.array(frame.position)))))
        angle = max(angle, float(rotation_angle(found.rotation, rotation_from_angles(frame.angles))))
    return FrameAgreement(tuple(used), distance, angle) if used else None


def _robot(parameters: GroupParameters, stance: Stance) -> Robot:
    from olp.robots.model import Axis, Links, Robot
    from olp.robots.robot import wrist_geometry

    a1, a2, a3, d4, d6 = (parameters.links[key] for key in ("a1", "a2", "a3", "d4", "d6"))
    links = Links(a1, a2, a3, d4, d6, stance.signs, stance.zeros)
    ranges = zip(
        parameters.radians(parameters.lower),
        parameters.radians(parameters.upper),
        parameters.radians(parameters.speeds),
        strict=True,
    )
    axes = tuple(Axis(str(index), *numbers) for index, numbers in enumerate(ranges))
    return Robot("", "", "", axes, geometry=wrist_geometry(links, None))


AXIS_NAMES = ("S", "L", "U", "R", "B", "T", "E", "8")
_PULSES_PER_DEGREE = (100.0, 20_000.0)  # arms and stations of published backups: 455 .. 11,378
_TURN = 1_080.0  # [deg], three turns: no soft limit of an arm or a station is farther
_FASTEST = 2_000.0  # [deg/s], twice the fastest wrist of a data sheet


def axis_name(group_name: str, axis: int) -> str:
    """S, L, U, R, B, T, E for a robot; 1, 2 .. for a base or a station. `axis` counts from 0."""
    return AXIS_NAMES[axis] if group_name.startswith("R") else str(axis + 1)


def shortest_degrees(pulses: int, pulses_per_degree: float) -> float:
    """Angle [deg] with the fewest decimals that gives the same pulse.

    Controllers round limits and speeds away from zero to whole pulses (180 deg is stored as 241,449 although
    241,448.4 would be exact), so the intended number is the shortest one less than a pulse away.
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
    """All findings on the group called `name` (R1, S1): errors that prevent a robot file, else warnings."""
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
    """Findings on rated speeds: users do not change them, so one that is not round was read from the wrong slot."""
    pairs = zip(parameters.speeds, parameters.pulses_per_degree, strict=True)
    speeds = [shortest_degrees(speed, per_degree) for speed, per_degree in pairs if per_degree]
    if any(abs(speed - round(speed, 1)) > 1e-9 for speed in speeds):
        shown = ", ".join(f"{speed:g}" for speed in speeds)
        says = "on all controllers met they are; compare the file with the robot's data sheet before using it"
        yield "B007", f"the rated speeds are not round degrees: {shown} deg/s", Severity.WARNING, says


def _link_findings(parameters: GroupParameters, name: str) -> Iterator[tuple[str, str, Severity, str]]:
    """Findings on links: without usable ones a robot file has no geometry; joint moves can be timed, poses cannot
    be computed.
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


MAKER: Final = "Yaskawa"


def check_import(backup: Backup, group: str = "R1", name: str = "") -> tuple[Diagnostic, ...]:
    """All findings against a robot file of control group `group`, errors first.

    Of the backup's own findings only those on parameter files and SYSTEM.SYS count: a broken tool harms no robot
    file.
    """
    used = ("SYSTEM.SYS", ".PRM")
    found = [d for d in backup.diagnostics if d.file.upper().endswith(used) or not backup.files]
    if name and not ROBOT_NAME.fullmatch(name.lower()):
        says = f"maker/model, for example {EXAMPLE_ROBOT}"
        found.append(error("B010", f"{name!r} is not a robot name", help=says))
        name = ""
    elif not name and backup.files and not model_of(backup, group):
        says = f"say --name {EXAMPLE_ROBOT}, or add SYSTEM.SYS to the folder"
        found.append(
            error("B009", f"the model of {group[:40]!r} is not known", file=backup.folder, help=says)
        )
    if backup.files or not found:
        found.extend(_group_findings(backup, group, name))
    return tuple(sorted(found, key=lambda d: d.severity is not Severity.ERROR))


def parameter_group(backup: Backup, group: str) -> int | None:
    """The n of `///RCnG` for a control group's name; without a SYSTEM.SYS only R1 is known."""
    if backup.system is not None and backup.system.groups:
        return backup.system.parameter_group(group)
    return 1 if group == "R1" else None


def control_group(backup: Backup, group: str) -> BackupControlGroup | None:
    """The entry of SYSTEM.SYS for the group; None if there is none."""
    groups = backup.system.groups if backup.system else ()
    return next((g for g in groups if g.name == group), None)


def model_of(backup: Backup, group: str) -> str:
    """The model in SYSTEM.SYS, "" without one."""
    control = control_group(backup, group)
    return control.model if control else ""


def maker_and_model(backup: Backup, group: str, name: str) -> tuple[str, str]:
    """Maker and model for the robot file; together, in lower case, they are the robot's name. `name`: maker/model
    or "".
    """
    if not name:
        return MAKER, model_of(backup, group)
    maker, model = name.split("/")
    return (MAKER if maker.lower() == MAKER.lower() else maker), model.upper()


def stance_of(
    backup: Backup, group: str, parameters: GroupParameters, name: str
) -> tuple[Stance, FrameAgreement | None]:
    """The arm's stance at zero and how well its user frames agree; for a group that is not an arm the default
    stance and None.
    """
    if not group.startswith("R") or not has_links(parameters):
        return Stance(), None
    full = "/".join(maker_and_model(backup, group, name)).lower()
    return find_stance(parameters, backup.user_frames, backup.tools, full)


def _group_findings(backup: Backup, group: str, name: str) -> list[Diagnostic]:
    number = parameter_group(backup, group)
    if number is None:
        says = "the groups are named in SYSTEM.SYS: copy it beside the parameter files"
        if backup.system and backup.system.groups:
            says = f"the groups are {', '.join(g.name for g in backup.system.groups)}"
        return [error("B009", f"there is no control group {group[:40]!r}", file=backup.folder, help=says)]
    parameters = backup.groups.get(number)
    if parameters is None:
        says = "RC.PRM or ALL.PRM with this section is needed"
        message = f"///RC{number}G, the robot data of {group}, was not read"
        return [error("B009", message, file=backup.folder, help=says)]
    file = backup.path(parameters.file)
    found = list(implausible(parameters, group, model_of(backup, group), file))
    found += _against_system(backup, group, parameters, file)
    if group.startswith("R") and number not in backup.zones:
        message = f"no blend zones: SC.PRM or ALL.PRM with ///S1C{number}G was not read"
        says = "add blend_zones_mm to the robot file"
        found.append(warning("B009", message, file=backup.folder, help=says))
    if not any(d.is_error for d in found):
        found += _pose_findings(backup, group, parameters, name)
    return found


def _against_system(backup: Backup, group: str, parameters: GroupParameters, file: str) -> list[Diagnostic]:
    found = []
    control = control_group(backup, group)
    section = f"///RC{parameters.group}G"
    if control is not None and control.axes != parameters.axes:
        axes = f"{len(parameters.axes)} axes, SYSTEM.SYS gives {group} {len(control.axes)}"
        says = "the files are from different controllers"
        found.append(error("B007", f"{section} has {axes}", file=file, help=says))
    robots = [g.name for g in backup.system.groups if g.name.startswith("R")] if backup.system else []
    if len(robots) > 1 and group != "R1":
        # Seen with one robot only: R1, B1, S1 .. S4 are ///RC1G .. ///RC6G.
        message = f"{group} is taken to be {section}: robots, then bases, then stations"
        found.append(info("B008", message, file=file))
    return found


def _pose_findings(backup: Backup, group: str, parameters: GroupParameters, name: str) -> list[Diagnostic]:
    if not group.startswith("R") or not has_links(parameters):
        return []
    _, agreement = stance_of(backup, group, parameters, name)
    file = backup.path("UFRAME.CND")
    if agreement is None:
        message = (
            f"no user frame was taught with {group} alone, so poses computed from pulses are not verified"
        )
        says = "a UFRAME.CND with a frame taught by three points, and its TOOL.CND, would verify them"
        return [info("B013", message, file=file, help=says)]
    if agreement.proves:
        return []
    if agreement.close:
        names = " ".join(axis_name(group, axis) for axis in agreement.unseen)
        message = f"the user frames agree with the arm's model, but would also do so if {names} turned the other way"
        says = "teach a frame with a tool that stands out to the side, in other positions of these axes"
        return [info("B013", message, file=file, help=says)]
    off = f"{agreement.distance / mm:.3f} mm and {agreement.angle / deg:.4f} deg"
    listed = ", ".join(map(str, agreement.frames))
    message = f"the taught points of user frames {listed} miss the stored frames by {off}"
    says = (
        "the tool was changed after teaching, or the arm is not built like the model: do not trust its poses"
    )
    return [warning("B013", message, file=file, help=says)]


# --- Robot file ---


@lru_cache(maxsize=16)
def robot_toml(backup: Backup, group: str = "R1", name: str = "") -> str:
    """The robot file of one control group, called `name` (maker/model) or after SYSTEM.SYS.

    It has link lengths, pulses per degree, soft limits, rated speeds, blend zones and (marked as inferred)
    acceleration times. Raises OlpError with all errors of `check_import`.
    """
    raise_errors(check_import(backup, group, name))
    number = parameter_group(backup, group)
    assert number is not None  # check_import refuses a group that has no parameters
    parameters = backup.groups[number]
    stance, agreement = stance_of(backup, group, parameters, name)
    rows = [
        *_header(backup, group, parameters),
        *_identity(backup, group, name),
        f"pose_verified = {'true' if agreement and agreement.proves else 'false'}",
        *(['inferred = ["acceleration"]'] if any(parameters.acceleration_times) else []),
        "",
        "axes = [",
        *(f"  {_axis(parameters, group, place)}," for place in range(len(parameters.axes))),
        "]",
    ]
    if number in backup.zones:
        rows += ["", f"blend_zones_mm = [{', '.join(shown(zone / mm) for zone in backup.zones[number])}]"]
    if group.startswith("R") and has_links(parameters):
        rows += ["", "[links]", *_links(parameters, stance)]
    sources = _sources(backup, parameters, group, stance, agreement)
    rows += ["", "[sources]", *(f"{key} = {quoted(text)}" for key, text in sources.items()), ""]
    return "\n".join(rows)


def _header(backup: Backup, group: str, parameters: GroupParameters) -> list[str]:
    system, control = backup.system, control_group(backup, group)
    origin = f"{system.controller or 'controller'} {system.software}".strip() if system else "controller"
    text = control.model_text if control else ""
    return [
        f"# {plain(group)} {plain(text)}".rstrip(),
        f"# Made by `olp robot import` from the backup of a {plain(origin)}.",
        f"# Slots of ///RC{parameters.group}G as {parameters.layout.controllers} lists them.",
        "# Pulses count in the sense of the joints.",
    ]


def _identity(backup: Backup, group: str, name: str) -> list[str]:
    maker, model = maker_and_model(backup, group, name)
    rows = [f"maker = {quoted(maker)}", f"model = {quoted(model)}"]
    if backup.system and backup.system.controller:
        rows.append(f"controllers = [{quoted(backup.system.controller)}]")
    if not group.startswith("R"):
        rows.append('kind = "positioner"')
    return rows


def _axis(parameters: GroupParameters, group: str, place: int) -> str:
    per_degree = parameters.pulses_per_degree[place]
    entries = {
        "name": quoted(axis_name(group, parameters.axes[place])),
        "lower_deg": shown(shortest_degrees(parameters.lower[place], per_degree)),
        "upper_deg": shown(shortest_degrees(parameters.upper[place], per_degree)),
        "speed_deg_s": shown(shortest_degrees(parameters.speeds[place], per_degree)),
        "pulses_per_deg": repr(per_degree),
    }
    if parameters.acceleration_times[place] > 0.0:
        entries["acceleration_time_ms"] = shown(parameters.acceleration_times[place] / ms)
    return "{ " + ", ".join(f"{key} = {value}" for key, value in entries.items()) + " }"


def _links(parameters: GroupParameters, stance: Stance) -> list[str]:
    rows = [f"{key}_mm = {shown(parameters.links[key] / mm)}" for key in LINK_SLOTS]
    if any(sign != 1 for sign in stance.signs):
        rows.append(f"signs = [{', '.join(map(str, stance.signs))}]")
    if any(stance.zeros):
        rows.append(f"zero_deg = [{', '.join(shown(zero / deg) for zero in stance.zeros)}]")
    return rows


def _sources(
    backup: Backup,
    parameters: GroupParameters,
    group: str,
    stance: Stance,
    agreement: FrameAgreement | None,
) -> dict[str, str]:
    """Source of each group of numbers."""
    layout, number = parameters.layout, parameters.group
    section = f"{parameters.file} ///RC{number}G"
    rounded = "to the shortest decimal within one pulse"
    texts = {
        "limits": f"{section} slots {layout.upper}.. (+) and {layout.lower}.. (-), {rounded}",
        "speed": f"{section} slots {layout.speed}.., {rounded}",
        "pulses": f"{section} slots {layout.numerator}.. over {layout.denominator}.. x 4096 / 360, joint sense",
    }
    if any(parameters.acceleration_times):
        says = "inferred, they look like times to full speed [ms]"
        texts["acceleration"] = f"{section} slots {layout.acceleration}..: {says}"
    if group.startswith("R") and has_links(parameters):
        stands = f"; {stance.source}" if stance.source else "; stance at zero assumed upright"
        texts["links"] = f"{section} slots {', '.join(map(str, LINK_SLOTS.values()))}{stands}"
    if number in backup.zones:
        holder = "SC.PRM" if "SC.PRM" in map(str.upper, backup.files) else "ALL.PRM"
        texts["blend_zones"] = f"{holder} ///S1C{number}G slots {ZONE_SLOTS[0]}..{ZONE_SLOTS[1] - 1}"
    if agreement is not None and agreement.proves:
        texts["pose"] = (
            f"user frames {', '.join(map(str, agreement.frames))} computed from their taught pulses agree to "
            f"{agreement.distance / mm:.4f} mm and {agreement.angle / deg:.5f} deg (UFRAME.CND, TOOL.CND)"
        )
    return texts
