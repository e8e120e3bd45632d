"""RC.PRM, SC.PRM and ALL.PRM: the parameters of each control group; SYSTEM.SYS: the controller and its arms.

A parameter file is a list of integers, ten a row, per section `///RC1G`, `///S1C1G` ..; ALL.PRM holds all sections.
The meaning of the slots is not published. The slots below were found by comparing published backups of six arms
with their data sheets: with them the soft limits and rated speeds of all six are round degrees.

Layout of SYSTEM.SYS, as seen in backups: `//SYSTEM NO : software`, `//APPLI : …`, and below `//ROBOT NAME` one or
two entries a row, `R1 : 1-06VXH25-A1*(AR2010) STANDARD 0011_1111`: control group, model, the axes in use as bits.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, NamedTuple

from olp.core.units import deg, mm, ms, um
from olp.robots.backup.controller_text import BackupFindings, BackupLine, integers, record

COUNTS_PER_TURN: Final = 4096  # pulses per motor turn in jobs, for every axis met
LINK_SLOTS: Final = {"a1": 1, "a2": 3, "a3": 5, "d4": 8, "d6": 12}
ZONE_SLOTS: Final = (33, 41)
MOST_AXES: Final = 8
_SECTION: Final = re.compile(r"///(?:RC([0-9]{1,2})G|S1C([0-9]{1,2})G)\s*")


class ParameterLayout(NamedTuple):
    """First slot of each per-axis list in `///RCnG` (slot 0 is the section's first value)."""

    controllers: str
    values: int  # in the whole section
    upper: int  # soft limit + [pulses]
    lower: int  # soft limit - [pulses]
    speed: int  # rated speed [pulses/s]
    denominator: int  # of the gear ratio; its sign is the motor's sense
    numerator: int
    acceleration: int  # looks like a time to full speed [ms]; inferred


LAYOUTS: Final = (
    ParameterLayout("DX100, DX200", 1700, 924, 932, 956, 972, 980, 900),
    ParameterLayout("YRC1000", 3000, 1030, 1040, 1070, 1090, 1100, 1290),
)


@dataclass(frozen=True, slots=True)
class GroupParameters:
    """One `///RCnG`. Per-axis tuples have one entry per axis in use (with a gear ratio)."""

    group: int
    file: str
    line: int  # of the section's head
    layout: ParameterLayout
    axes: tuple[int, ...]  # which, 0-based in the controller's order S L U R B T E
    links: dict[str, float]  # a1 a2 a3 d4 d6 [m]
    denominators: tuple[int, ...]  # signed
    numerators: tuple[int, ...]
    upper: tuple[int, ...]  # [pulses], in the sense of the job's pulses
    lower: tuple[int, ...]  # [pulses]
    speeds: tuple[int, ...]  # [pulses/s]
    acceleration_times: tuple[float, ...]  # [s], inferred

    @property
    def pulses_per_degree(self) -> tuple[float, ...]:
        """Pulses per degree of each axis, positive. Job pulses already count in the direction of the joint, so the
        denominator's sign, the motor's direction, is not applied again (confirmed on the AR2010's recorded poses).
        """
        ratios = zip(self.numerators, self.denominators, strict=True)
        return tuple(
            COUNTS_PER_TURN * above / abs(below) / 360.0 if below else 0.0 for above, below in ratios
        )

    def radians(self, pulses: Iterable[int]) -> tuple[float, ...]:
        """Joint angles [rad] of the pulses of each axis (or [rad/s] of pulses/s); nan for an axis without a ratio."""
        pairs = zip(pulses, self.pulses_per_degree, strict=True)
        return tuple(value / per_degree * deg if per_degree else float("nan") for value, per_degree in pairs)


class ParameterFile(NamedTuple):
    """Content of one parameter file."""

    groups: dict[int, GroupParameters]
    zones: dict[int, tuple[float, ...]]  # [m] for PL = 1..8


def read_parameters(
    rows: tuple[BackupLine, ...], file: str, layout: ParameterLayout | None, findings: BackupFindings
) -> ParameterFile:
    """The robot data and blend zones by group number.

    `layout`: the one of the controller's software number, used for a section whose size does not identify its
    layout; a section that stays ambiguous is omitted, with an error finding.
    """
    groups: dict[int, GroupParameters] = {}
    zones: dict[int, tuple[float, ...]] = {}
    for robot, number, head, body in _sections(rows):
        values = _values(body, findings)
        if values is None or (not values and number > 1):
            continue
        if robot:
            parameters = _group(number, file, head, values, layout, findings)
            if parameters is not None and parameters.axes:
                groups[number] = parameters
        else:
            found = _zones(number, head, values, findings)
            if found is not None:
                zones[number] = found
    return ParameterFile(groups, zones)


def _sections(rows: tuple[BackupLine, ...]) -> list[tuple[bool, int, BackupLine, list[BackupLine]]]:
    """The robot and station sections as (is RC, group number, head, value rows)."""
    sections: list[tuple[bool, int, BackupLine, list[BackupLine]]] = []
    body: list[BackupLine] = []
    for row in rows:
        if not row.text.startswith("/"):
            body.append(row)
            continue
        if record(row)[1] == "CRC":
            continue
        body = []
        if found := _SECTION.fullmatch(row.text):
            robot = found.group(1) is not None
            sections.append((robot, int(found.group(1) or found.group(2)), row, body))
    return sections


def _values(body: list[BackupLine], findings: BackupFindings) -> list[int] | None:
    """All values of a section; None when a row is unreadable, since every later slot would be uncertain."""
    values: list[int] = []
    good = True
    for row in body:
        if not row.text.strip():
            continue
        found = integers(row, findings)
        good = good and found is not None
        values.extend(found or ())
    return values if good else None


def _layout(
    count: int, head: BackupLine, hint: ParameterLayout | None, findings: BackupFindings
) -> ParameterLayout | None:
    for layout in LAYOUTS:
        if count == layout.values:
            return layout
    sizes = " or ".join(f"{layout.values} ({layout.controllers})" for layout in LAYOUTS)
    message = f"{head.text.strip()} has {count} values instead of {sizes}"
    last = None if hint is None else hint.numerator + MOST_AXES
    if hint is None or last is None or count < last:
        says = "the file is cut, or the controller is of another generation: save the parameters again"
        findings.error("B006", message, head, help=says)
        return None
    findings.warning("B006", f"{message}; read as that of a {hint.controllers}", head)
    return hint


def _group(
    number: int,
    file: str,
    head: BackupLine,
    values: list[int],
    hint: ParameterLayout | None,
    findings: BackupFindings,
) -> GroupParameters | None:
    layout = _layout(len(values), head, hint, findings)
    if layout is None:
        return None
    values = values + [0] * max(0, layout.values - len(values))
    numerators = values[layout.numerator : layout.numerator + MOST_AXES]
    axes = tuple(axis for axis, above in enumerate(numerators) if above)

    def per_axis(first: int) -> tuple[int, ...]:
        return tuple(values[first + axis] for axis in axes)

    def times(first: int) -> tuple[float, ...]:
        return tuple(value * ms for value in per_axis(first))

    return GroupParameters(
        group=number,
        file=file,
        line=head.line,
        layout=layout,
        axes=axes,
        links={name: values[slot] * um for name, slot in LINK_SLOTS.items()},
        denominators=per_axis(layout.denominator),
        numerators=per_axis(layout.numerator),
        upper=per_axis(layout.upper),
        lower=per_axis(layout.lower),
        speeds=per_axis(layout.speed),
        acceleration_times=times(layout.acceleration),
    )


def _zones(
    number: int, head: BackupLine, values: list[int], findings: BackupFindings
) -> tuple[float, ...] | None:
    """Zones [m] of PL = 1..8; None for a group that is not installed (all zero)."""
    first, end = ZONE_SLOTS
    zones = values[first:end]
    if len(zones) < end - first:
        findings.error(
            "B002", f"{head.text.strip()} is cut: it has {len(values)} values, {end} are needed", head
        )
        return None
    if not any(zones):
        return None
    if zones[0] <= 0 or any(after < before for before, after in pairwise(zones)):
        shown = ", ".join(f"{zone * um / mm:g}" for zone in zones)
        findings.error(
            "B007", f"the zones of group {number} do not grow with the position level: {shown} mm", head
        )
        return None
    return tuple(zone * um for zone in zones)


# First letters of the software number. YAS and DN were seen in published backups, the others in none.
CONTROLLERS: Final = {
    "YAS": "YRC1000",
    "YBS": "YRC1000micro",
    "DN": "DX200",
    "DS": "DX100",
    "FS": "FS100",
    "NS": "NX100",
}
_ENTRY: Final = re.compile(r"\b([RBS])([0-9]{1,2})\s*:\s*([^,:]{0,80}?)\s+([01]{4}_[01]{4})")
_ORDER: Final = "RBS"


@dataclass(frozen=True, slots=True)
class BackupControlGroup:
    """One control group of the system: a robot (R), a base or track (B) or a station (S)."""

    name: str  # R1, B1, S1 ..
    model: str  # AR2010
    model_text: str  # as written: 1-06VXH25-A1*(AR2010) STANDARD
    axes: tuple[int, ...]  # 0-based axes in use


@dataclass(frozen=True, slots=True)
class SystemInfo:
    """Content of SYSTEM.SYS. `groups` in the order of the parameter groups: robots, bases, stations."""

    software: str
    controller: str
    application: str
    groups: tuple[BackupControlGroup, ...]

    def parameter_group(self, name: str) -> int | None:
        """The n of `///RCnG` for a control group's name; None when the system has no such group."""
        names = [group.name for group in self.groups]
        return names.index(name) + 1 if name in names else None


def read_system_sys(rows: tuple[BackupLine, ...], findings: BackupFindings) -> SystemInfo | None:
    """The content of SYSTEM.SYS; None when it names neither software nor groups."""
    values: dict[str, str] = {}
    found: dict[tuple[int, int], BackupControlGroup] = {}
    inside = False
    for row in rows:
        if row.text.startswith("/"):
            key, _, value = row.text[:300].lstrip("/").partition(":")
            inside = key.strip() == "ROBOT NAME"
            values.setdefault(key.strip(), value.strip())
        elif inside:
            for kind, number, text, bits in _ENTRY.findall(row.text[:300]):
                group = BackupControlGroup(
                    f"{kind}{int(number)}", model_name(text), text.strip(), _axes(bits)
                )
                found[_ORDER.index(kind), int(number)] = group
    software = values.get("SYSTEM NO", "")
    if not software and not found:
        if rows:
            findings.warning("B004", "this file names neither the software nor the control groups")
        return None
    controller = next((name for prefix, name in CONTROLLERS.items() if software.startswith(prefix)), "")
    groups = tuple(found[key] for key in sorted(found))
    return SystemInfo(software, controller, values.get("APPLI", ""), groups)


def model_name(text: str) -> str:
    """The model as in catalogues: `1-06VXH25-A1*(AR2010)` is AR2010, `MA02010-A0*` is MA2010."""
    inner = re.search(r"\(([A-Za-z0-9-]+)\)", text)
    if inner:
        return inner.group(1)
    word = text.split("*")[0].split(" ")[0]
    plain = re.fullmatch(r"([A-Z]+)0*([1-9][0-9]*[A-Z]*)(?:-A[0-9]+)?", word)
    return plain.group(1) + plain.group(2) if plain else word


def _axes(bits: str) -> tuple[int, ...]:
    mask = int(bits.replace("_", ""), 2)
    return tuple(axis for axis in range(8) if mask >> axis & 1)
