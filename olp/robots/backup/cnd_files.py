"""The .CND files of a controller: its user frames and its tools.

Layout of UFRAME.CND, as seen in backups: `//UFRAME n`, `///NAME`, `///TOOL n`, `///GROUP` (one number per control
group), the three points it was taught with (`////RORG`, `////RXX`, `////RXY`, in pulses; `////BORG` .. for a track)
and the result `////BUSER x,y,z,rx,ry,rz` in the base frame (mm, deg).

Layout of TOOL.CND, as seen in backups of DX200 and YRC1000: `//TOOL n`, `///NAME text`, then five rows: pose (mm, deg),
centre of gravity (mm), mass (kg), inertia at the centre of gravity (kg m²), flags. A YRC1000 puts `///CRC`
before the name.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Final

from olp.core.units import deg, mm
from olp.robots.backup.controller_text import (
    BackupBlock,
    BackupFindings,
    BackupLine,
    blocks,
    integers,
    numbers,
    record,
)

_WIDTHS: Final = (("pose", 6), ("centre of gravity", 3), ("mass", 1), ("inertia", 3))
_REACH: Final = 10.0  # [m], farther than any tool stands out

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class ToolData:
    """One tool, relative to the flange. Without load rows (older controllers) the last three fields are None."""

    number: int
    name: str
    position: Vector  # [m]
    angles: Vector  # Rx, Ry, Rz [rad], R = Rz Ry Rx
    mass: float | None = None  # [kg]
    centre: Vector | None = None  # centre of gravity [m]
    inertia: Vector | None = None  # Ix, Iy, Iz [kg m²]

    @property
    def pose(self) -> tuple[float, float, float, float, float, float]:
        """Tool centre point as x, y, z [m], Rx, Ry, Rz [rad]."""
        return (*self.position, *self.angles)


def read_tool_cnd(rows: tuple[BackupLine, ...], findings: BackupFindings) -> dict[int, ToolData]:
    """The tools by number.

    A tool with an unreadable row is omitted, with an error finding for each such row.
    """
    tools: dict[int, ToolData] = {}
    for block in blocks(rows, "TOOL", findings):
        tool = _tool(block, findings)
        if tool is None:
            continue
        if tool.number in tools:
            findings.warning("B005", f"tool {tool.number} is given twice; the last one is used", block.head)
        tools[tool.number] = tool
    if rows and not tools:
        findings.warning("B004", "no tool was found in this file")
    return tools


def _tool(block: BackupBlock, findings: BackupFindings) -> ToolData | None:
    name = ""
    values: list[tuple[float, ...] | None] = []
    for row in block.rows:
        slashes, keyword, rest = record(row)
        if slashes:
            name = rest if keyword == "NAME" else name
        elif rest and len(values) < len(_WIDTHS):
            values.append(_row(row, len(values), findings))
    # One row, the pose, is a whole tool on controllers without load data.
    if len(values) not in (1, len(_WIDTHS)):
        wanted = _WIDTHS[len(values)][0]
        findings.error("B002", f"tool {block.number} is cut: its {wanted} row is missing", block.head)
        return None
    if any(value is None for value in values):
        return None
    pose, *load = [value for value in values if value is not None]
    position, angles = _vector(pose[:3], mm), _vector(pose[3:], deg)
    if max(map(abs, position)) > _REACH:
        findings.warning("B007", f"tool {block.number} stands out more than {_REACH:g} m", block.head)
    if not load:
        return ToolData(block.number, name, position, angles)
    centre, mass, inertia = load
    if mass[0] < 0.0 or min(inertia) < 0.0:
        findings.warning("B007", f"tool {block.number} has a negative mass or inertia", block.head)
    return ToolData(block.number, name, position, angles, mass[0], _vector(centre, mm), _vector(inertia, 1.0))


def _row(row: BackupLine, index: int, findings: BackupFindings) -> tuple[float, ...] | None:
    name, width = _WIDTHS[index]
    values = numbers(row, findings)
    if values is not None and len(values) != width:
        findings.error("B004", f"the {name} row has {len(values)} values instead of {width}", row)
        return None
    return values


def _vector(values: tuple[float, ...], unit: float) -> Vector:
    x, y, z = values
    return x * unit, y * unit, z * unit


_TAUGHT: Final = re.compile(r"////([A-Z]+)\s+[A-Z]+[0-9]+=")
_RESULT: Final = re.compile(r"////BUSER\s+")


@dataclass(frozen=True, slots=True)
class UserFrame:
    """One user frame, relative to the base frame."""

    number: int
    name: str
    position: Vector  # [m]
    angles: Vector  # Rx, Ry, Rz [rad], R = Rz Ry Rx
    tool: int = 0  # with which it was taught
    groups: tuple[int, ...] = ()  # control groups it was taught with, 1 = the first of the system
    taught: dict[str, tuple[int, ...]] = field(default_factory=dict)  # RORG, RXX, RXY, BORG .. -> pulses


def read_uframe_cnd(rows: tuple[BackupLine, ...], findings: BackupFindings) -> dict[int, UserFrame]:
    """The user frames by number, without those that were never set or whose result is unreadable."""
    frames: dict[int, UserFrame] = {}
    unset: list[int] = []
    for block in blocks(rows, "UFRAME", findings):
        if not any(row.text.startswith("////") for row in block.rows):
            unset.append(block.number)
            continue
        frame = _frame(block, findings)
        if frame is None:
            continue
        if frame.number in frames:
            findings.warning(
                "B005", f"user frame {frame.number} is given twice; the last is used", block.head
            )
        frames[frame.number] = frame
    if unset:
        listed = ", ".join(map(str, unset[:20])) + (" …" if len(unset) > 20 else "")
        findings.info("B008", f"user frames without a result were left out: {listed}")
    return frames


def _frame(block: BackupBlock, findings: BackupFindings) -> UserFrame | None:
    name = ""
    tool = 0
    groups: tuple[int, ...] = ()
    taught: dict[str, tuple[int, ...]] = {}
    result: tuple[float, ...] | None = None
    seen = False
    for row in block.rows:
        _, keyword, rest = record(row)
        if keyword == "NAME":
            name = rest
        elif keyword == "TOOL":
            tool = (_integers_after(row, findings) or (0,))[0]
        elif keyword == "GROUP":
            marks = _integers_after(row, findings) or ()
            groups = tuple(index for index, mark in enumerate(marks, start=1) if mark)
        elif found := _RESULT.match(row.text):
            seen = True
            result = _result(row, found.end(), findings)
        elif found := _TAUGHT.match(row.text):
            pulses = integers(row, findings, found.end())
            if pulses is not None:
                taught[found.group(1)] = pulses
    if result is None:
        if not seen:
            findings.error("B002", f"user frame {block.number} is cut: it has no ////BUSER row", block.head)
        return None
    x, y, z, rx, ry, rz = result
    position, angles = (x * mm, y * mm, z * mm), (rx * deg, ry * deg, rz * deg)
    return UserFrame(block.number, name, position, angles, tool, groups, taught)


def _integers_after(row: BackupLine, findings: BackupFindings) -> tuple[int, ...] | None:
    """The integers after the keyword of a record."""
    space = row.text.find(" ")
    return integers(row, findings, space + 1) if space >= 0 else None


def _result(row: BackupLine, start: int, findings: BackupFindings) -> tuple[float, ...] | None:
    values = numbers(row, findings, start)
    if values is not None and len(values) != 6:
        findings.error("B004", f"////BUSER has {len(values)} values instead of 6", row, start=start)
        return None
    return values
