"""SYSTEM.SYS: which controller and which arms.

Layout, as seen in backups: `//SYSTEM NO : software`, `//APPLI : …`, and below `//ROBOT NAME` one or two
entries a row, `R1 : 1-06VXH25-A1*(AR2010) STANDARD   0011_1111`: control group, model, the axes in use as
bits.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from olp.robots.backup.controller_text import BackupFindings, BackupLine

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
    """What a controller says of itself. `groups` in the order of the parameter groups: robots, bases,
    stations.
    """

    software: str
    controller: str
    application: str
    groups: tuple[BackupControlGroup, ...]

    def parameter_group(self, name: str) -> int | None:
        """The n of `///RCnG` for a control group's name; None when the system has no such group."""
        names = [group.name for group in self.groups]
        return names.index(name) + 1 if name in names else None


def read_system_sys(rows: tuple[BackupLine, ...], findings: BackupFindings) -> SystemInfo | None:
    """What the file says; None when it names neither software nor groups."""
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
    """The model as catalogues write it: `1-06VXH25-A1*(AR2010)` is AR2010, `MA02010-A0*` is MA2010."""
    inner = re.search(r"\(([A-Za-z0-9-]+)\)", text)
    if inner:
        return inner.group(1)
    word = text.split("*")[0].split(" ")[0]
    plain = re.fullmatch(r"([A-Z]+)0*([1-9][0-9]*[A-Z]*)(?:-A[0-9]+)?", word)
    return plain.group(1) + plain.group(2) if plain else word


def _axes(bits: str) -> tuple[int, ...]:
    mask = int(bits.replace("_", ""), 2)
    return tuple(axis for axis in range(8) if mask >> axis & 1)
