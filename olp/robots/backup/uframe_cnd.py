"""UFRAME.CND: the user frames of a controller.

Layout, as seen in backups: `//UFRAME n`, `///NAME`, `///TOOL n`, `///GROUP` (one number per control group),
the three points it was taught with (`////RORG`, `////RXX`, `////RXY`, in pulses; `////BORG` .. for a track)
and the result `////BUSER x,y,z,rx,ry,rz` in the base frame (mm, deg).
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
from olp.robots.backup.tool_cnd import Vector

_TAUGHT: Final = re.compile(r"////([A-Z]+)\s+[A-Z]+[0-9]+=")
_RESULT: Final = re.compile(r"////BUSER\s+")


@dataclass(frozen=True, slots=True)
class UserFrame:
    """One user frame, seen from the base frame."""

    number: int
    name: str
    position: Vector  # [m]
    angles: Vector  # Rx, Ry, Rz [rad], R = Rz Ry Rx
    tool: int = 0  # with which it was taught
    groups: tuple[int, ...] = ()  # control groups it was taught with, 1 = the first of the system
    taught: dict[str, tuple[int, ...]] = field(default_factory=dict)  # RORG, RXX, RXY, BORG .. -> pulses


def read_uframe_cnd(rows: tuple[BackupLine, ...], findings: BackupFindings) -> dict[int, UserFrame]:
    """The user frames by number. Frames that were never set, or whose result is unreadable, are left out."""
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
    """The integers behind the keyword of a record."""
    space = row.text.find(" ")
    return integers(row, findings, space + 1) if space >= 0 else None


def _result(row: BackupLine, start: int, findings: BackupFindings) -> tuple[float, ...] | None:
    values = numbers(row, findings, start)
    if values is not None and len(values) != 6:
        findings.error("B004", f"////BUSER has {len(values)} values instead of 6", row, start=start)
        return None
    return values
