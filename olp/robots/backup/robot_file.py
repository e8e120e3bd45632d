"""A robot file (TOML) from a controller's backup, every number with the file and the slot it is from."""

from __future__ import annotations

from functools import lru_cache

from olp.core.diagnostic import raise_errors
from olp.core.toml import plain, quoted, shown
from olp.core.units import deg, mm, ms
from olp.robots.backup.backup import Backup
from olp.robots.backup.import_check import (
    FrameAgreement,
    Stance,
    axis_name,
    check_import,
    control_group,
    has_links,
    maker_and_model,
    parameter_group,
    shortest_degrees,
    stance_of,
)
from olp.robots.backup.parameters import LINK_SLOTS, ZONE_SLOTS, GroupParameters


@lru_cache(maxsize=16)
def robot_toml(backup: Backup, group: str = "R1", name: str = "") -> str:
    """The robot file of one control group, called `name` (maker/model) or after SYSTEM.SYS.

    Link lengths, pulses per degree, soft limits, rated speeds, blend zones and (marked as inferred)
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
    """Where each group of numbers is from."""
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
