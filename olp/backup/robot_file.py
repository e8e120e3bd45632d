"""A robot file (TOML) from a controller's backup, every number with the file and the slot it is from."""

from __future__ import annotations

import json
import re
from typing import Final

from olp.backup.backup import Backup
from olp.backup.frame_check import FrameAgreement, frame_agreement
from olp.backup.parameters import LINK_SLOTS, ZONE_SLOTS, GroupParameters
from olp.backup.plausibility import axis_name, has_links, implausible, shortest_degrees
from olp.diagnostic import Diagnostic, Severity, error, raise_errors, warning
from olp.units import deg, mm, ms

MAKER: Final = "Yaskawa"
_NAME: Final = re.compile(r"[a-z0-9][a-z0-9._-]{0,40}/[a-z0-9][a-z0-9._-]{0,60}")


def check_import(backup: Backup, group: str = "R1", name: str = "") -> tuple[Diagnostic, ...]:
    """Everything that stands against a robot file of control group `group`, errors first.

    Of the backup's own findings only those on parameter files and SYSTEM.SYS count: a broken tool harms no
    robot file.
    """
    used = ("SYSTEM.SYS", ".PRM")
    found = [d for d in backup.diagnostics if d.file.upper().endswith(used) or not backup.files]
    if backup.files or not found:
        found.extend(_group_findings(backup, group))
    if name and not _NAME.fullmatch(name.lower()):
        found.append(
            error("B010", f"{name!r} is not a robot name", help="maker/model, for example yaskawa/gp25")
        )
    if not name and not _model(backup, group) and not any(d.is_error for d in found):
        says = "say --name yaskawa/gp25, or add SYSTEM.SYS to the folder"
        found.append(error("B009", f"the model of {group} is not known", file=backup.folder, help=says))
    return tuple(sorted(found, key=lambda d: d.severity is not Severity.ERROR))


def robot_toml(backup: Backup, group: str = "R1", name: str = "") -> str:
    """The robot file of one control group. Raises OlpError with all errors of `check_import`.

    Link lengths, pulses per degree, soft limits, rated speeds, blend zones and (marked as inferred)
    acceleration times.
    """
    raise_errors(check_import(backup, group, name))
    number = _parameter_group(backup, group)
    assert number is not None  # check_import refuses a group that has no parameters
    parameters = backup.groups[number]
    maker, model = _named(backup, group, name)
    controllers = [backup.system.controller] if backup.system and backup.system.controller else []
    zones = backup.zones.get(number)
    timed = any(parameters.acceleration_times)
    agreement = _agreement(backup, group, parameters)
    verified = agreement is not None and agreement.proves
    rows = [
        *_header(backup, group, parameters),
        f"maker = {_quoted(maker)}",
        f"model = {_quoted(model)}",
        *([f"controllers = [{', '.join(map(_quoted, controllers))}]"] if controllers else []),
        *([] if group.startswith("R") else ['kind = "positioner"']),
        f"pose_verified = {'true' if verified else 'false'}",
        *(['inferred = ["acceleration"]'] if timed else []),
        "",
        "axes = [",
        *(f"  {_axis(parameters, group, place)}," for place in range(len(parameters.axes))),
        "]",
    ]
    if zones is not None:
        rows += ["", f"blend_zones_mm = [{', '.join(_shown(zone / mm, 3) for zone in zones)}]"]
    if group.startswith("R") and has_links(parameters):
        rows += [
            "",
            "[links]",
            *(f"{key}_mm = {_shown(parameters.links[key] / mm, 3)}" for key in LINK_SLOTS),
        ]
    sources = _sources(backup, parameters, group)
    if agreement is not None and verified:
        sources["pose"] = (
            f"user frames {', '.join(map(str, agreement.frames))} computed from their taught pulses agree to "
            f"{agreement.distance / mm:.4f} mm and {agreement.angle / deg:.5f} deg (UFRAME.CND, TOOL.CND)"
        )
    rows += ["", "[sources]", *(f"{key} = {_quoted(text)}" for key, text in sources.items()), ""]
    return "\n".join(rows)


def _group_findings(backup: Backup, group: str) -> list[Diagnostic]:
    number = _parameter_group(backup, group)
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
    found = list(implausible(parameters, group, _model(backup, group), file))
    control = next((g for g in backup.system.groups if g.name == group), None) if backup.system else None
    if control is not None and control.axes != parameters.axes:
        message = (
            f"///RC{number}G has {len(parameters.axes)} axes, SYSTEM.SYS gives {group} {len(control.axes)}"
        )
        found.append(error("B007", message, file=file, help="the files are from different controllers"))
    if group.startswith("R") and number not in backup.zones:
        message = f"no blend zones: SC.PRM or ALL.PRM with ///S1C{number}G was not read"
        says = "add blend_zones_mm to the robot file"
        found.append(warning("B009", message, file=backup.folder, help=says))
    if group != "R1" and backup.system and sum(g.name[0] == "R" for g in backup.system.groups) > 1:
        message = f"{group} is taken as ///RC{number}G: robots, then bases, then stations"
        found.append(Diagnostic("B008", message, Severity.INFO, backup.folder))
    if not any(d.is_error for d in found):
        found.extend(_pose_findings(backup, group, parameters))
    return found


def _pose_findings(backup: Backup, group: str, parameters: GroupParameters) -> list[Diagnostic]:
    agreement = _agreement(backup, group, parameters)
    if not group.startswith("R") or not has_links(parameters) or (agreement and agreement.proves):
        return []
    file = backup.path("UFRAME.CND")
    if agreement is None:
        message = (
            f"no user frame was taught with {group} alone, so poses computed from pulses are not verified"
        )
        says = "a UFRAME.CND with a frame taught by three points, and its TOOL.CND, would verify them"
        return [Diagnostic("B013", message, Severity.INFO, file, help=says)]
    if agreement.close:
        names = " ".join(axis_name(group, axis) for axis in agreement.unseen)
        message = f"the user frames agree with the arm's model, but would too if {names} turned the other way"
        says = "teach a frame with a tool that stands out to the side, in other positions of these axes"
        return [Diagnostic("B013", message, Severity.INFO, file, help=says)]
    off = f"{agreement.distance / mm:.3f} mm and {agreement.angle / deg:.4f} deg"
    listed = ", ".join(map(str, agreement.frames))
    message = f"the taught points of user frames {listed} miss the stored frames by {off}"
    says = (
        "the tool was changed after teaching, or the arm is not built like the model: do not trust its poses"
    )
    return [warning("B013", message, file=file, help=says)]


def _agreement(backup: Backup, group: str, parameters: GroupParameters) -> FrameAgreement | None:
    if not group.startswith("R") or not has_links(parameters):
        return None
    return frame_agreement(parameters, backup.user_frames, backup.tools)


def _parameter_group(backup: Backup, group: str) -> int | None:
    if backup.system is not None and backup.system.groups:
        return backup.system.parameter_group(group)
    return 1 if group == "R1" else None


def _model(backup: Backup, group: str) -> str:
    groups = backup.system.groups if backup.system else ()
    return next((g.model for g in groups if g.name == group), "")


def _named(backup: Backup, group: str, name: str) -> tuple[str, str]:
    """Maker and model for the file; together, in lower case, they are the robot's name."""
    if name:
        maker, model = name.split("/")
        return (MAKER if maker.lower() == MAKER.lower() else maker), model.upper()
    return MAKER, _model(backup, group)


def _header(backup: Backup, group: str, parameters: GroupParameters) -> list[str]:
    system = backup.system
    origin = f"{system.controller or 'controller'} {system.software}".strip() if system else "a controller"
    text = next((g.model_text for g in system.groups if g.name == group), "") if system else ""
    return [
        f"# {_plain(group)} {_plain(text)}".rstrip(),
        f"# Made by `olp robot import` from a backup of {_plain(origin)}.",
        f"# Slots of ///RC{parameters.group}G as {parameters.layout.controllers} lists them.",
        "# Pulses count in the sense of the joints.",
    ]


def _axis(parameters: GroupParameters, group: str, place: int) -> str:
    per_degree = parameters.pulses_per_degree[place]
    entries = {
        "name": _quoted(axis_name(group, parameters.axes[place])),
        "lower_deg": _shown(shortest_degrees(parameters.lower[place], per_degree), 9),
        "upper_deg": _shown(shortest_degrees(parameters.upper[place], per_degree), 9),
        "speed_deg_s": _shown(shortest_degrees(parameters.speeds[place], per_degree), 9),
        "pulses_per_deg": repr(per_degree),
    }
    if parameters.acceleration_times[place] > 0.0:
        entries["acceleration_time_ms"] = _shown(parameters.acceleration_times[place] / ms, 3)
    return "{ " + ", ".join(f"{key} = {value}" for key, value in entries.items()) + " }"


def _sources(backup: Backup, parameters: GroupParameters, group: str) -> dict[str, str]:
    """Where each group of numbers is from."""
    layout, number = parameters.layout, parameters.group
    section = f"{parameters.file} ///RC{number}G"
    rounded = "to the shortest decimal within one pulse"
    texts = {
        "limits": f"{section} slots {layout.upper}.. (+) and {layout.lower}.. (-), {rounded}",
        "speed": f"{section} slots {layout.speed}.., {rounded}",
        "pulses": (
            f"{section} slots {layout.numerator}.. over {layout.denominator}.. x 4096 / 360, joint sense"
        ),
    }
    if any(parameters.acceleration_times):
        texts["acceleration"] = (
            f"{section} slots {layout.acceleration}..: inferred, they look like times to full speed [ms]"
        )
    if group.startswith("R") and has_links(parameters):
        texts["links"] = f"{section} slots {', '.join(map(str, LINK_SLOTS.values()))}"
    if number in backup.zones:
        holder = "SC.PRM" if "SC.PRM" in map(str.upper, backup.files) else "ALL.PRM"
        texts["blend_zones"] = f"{holder} ///S1C{number}G slots {ZONE_SLOTS[0]}..{ZONE_SLOTS[1] - 1}"
    return texts


def _shown(value: float, decimals: int) -> str:
    """A number without needless zeros and never -0: TOML integers where it is whole."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def _quoted(text: str) -> str:
    """A TOML basic string; JSON's escapes are among TOML's, and DEL is the one character that JSON leaves."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _plain(text: str) -> str:
    """Text for a comment: TOML allows no control characters there."""
    return "".join(c if c.isprintable() else "?" for c in text)
