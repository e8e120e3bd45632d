"""TOOL.CND: the tools of a controller.

Layout, as seen in backups of DX200 and YRC1000: `//TOOL n`, `///NAME text`, then five rows: pose (mm, deg),
centre of gravity (mm), mass (kg), inertia at the centre of gravity (kg m²), flags. A YRC1000 puts `///CRC`
before the name.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from olp.core.units import deg, mm
from olp.robots.backup.controller_text import BackupBlock, BackupFindings, BackupLine, blocks, numbers, record

_WIDTHS: Final = (("pose", 6), ("centre of gravity", 3), ("mass", 1), ("inertia", 3))
_REACH: Final = 10.0  # [m], farther than any tool stands out

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class ToolData:
    """One tool, seen from the flange. Without load rows (older controllers) the last three are None."""

    number: int
    name: str
    position: Vector  # [m]
    angles: Vector  # Rx, Ry, Rz [rad], R = Rz Ry Rx
    mass: float | None = None  # [kg]
    centre: Vector | None = None  # centre of gravity [m]
    inertia: Vector | None = None  # Ix, Iy, Iz [kg m²]

    @property
    def pose(self) -> tuple[float, float, float, float, float, float]:
        """x, y, z [m], Rx, Ry, Rz [rad]."""
        return (*self.position, *self.angles)


def read_tool_cnd(rows: tuple[BackupLine, ...], findings: BackupFindings) -> dict[int, ToolData]:
    """The tools by number.

    A tool with an unreadable row is left out, with an error finding for each such row.
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
