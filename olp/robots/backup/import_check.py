"""What stands against making a robot file from a backup, and what its user should know."""

from __future__ import annotations

from typing import Final

from olp.core.diagnostic import Diagnostic, Severity, error, info, warning
from olp.core.units import deg, mm
from olp.robots.backup.backup import Backup
from olp.robots.backup.frame_check import FrameAgreement, Stance, find_stance
from olp.robots.backup.parameters import GroupParameters
from olp.robots.backup.plausibility import axis_name, has_links, implausible
from olp.robots.backup.system_sys import BackupControlGroup
from olp.robots.backup.toml_text import ROBOT_NAME

MAKER: Final = "Yaskawa"


def check_import(backup: Backup, group: str = "R1", name: str = "") -> tuple[Diagnostic, ...]:
    """Everything that stands against a robot file of control group `group`, errors first.

    Of the backup's own findings only those on parameter files and SYSTEM.SYS count: a broken tool harms no
    robot file.
    """
    used = ("SYSTEM.SYS", ".PRM")
    found = [d for d in backup.diagnostics if d.file.upper().endswith(used) or not backup.files]
    if name and not ROBOT_NAME.fullmatch(name.lower()):
        says = "maker/model, for example yaskawa/gp25"
        found.append(error("B010", f"{name!r} is not a robot name", help=says))
        name = ""
    elif not name and backup.files and not model_of(backup, group):
        says = "say --name yaskawa/gp25, or add SYSTEM.SYS to the folder"
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
    """What SYSTEM.SYS says of the group."""
    groups = backup.system.groups if backup.system else ()
    return next((g for g in groups if g.name == group), None)


def model_of(backup: Backup, group: str) -> str:
    """The model in SYSTEM.SYS, "" without one."""
    control = control_group(backup, group)
    return control.model if control else ""


def maker_and_model(backup: Backup, group: str, name: str) -> tuple[str, str]:
    """For the robot file; together, in lower case, they are the robot's name. `name`: maker/model or ""."""
    if not name:
        return MAKER, model_of(backup, group)
    maker, model = name.split("/")
    return (MAKER if maker.lower() == MAKER.lower() else maker), model.upper()


def stance_of(
    backup: Backup, group: str, parameters: GroupParameters, name: str
) -> tuple[Stance, FrameAgreement | None]:
    """How the arm stands at zero and what its user frames say of it; upright and None for what is no arm."""
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
