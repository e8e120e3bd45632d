"""ABB zones: a parabola from the edge of the zone on."""

from __future__ import annotations

from types import MappingProxyType
from typing import NamedTuple

from olp.core.diagnostic import OlpError, error
from olp.core.units import deg, mm
from olp.timing.blending._parabola import ParabolicLaw


class PredefinedZone(NamedTuple):
    """The predefined zonedata of RAPID; `fine` is a stop."""

    tcp: float  # pzone_tcp [m]: of the tool centre point's path
    orientation: float  # pzone_ori [m]: distance at which reorienting begins
    external: float  # pzone_eax [m]: distance at which external axes begin
    angle: float  # zone_ori [rad], where the tool only turns
    linear: float  # zone_leax [m], where only a linear external axis moves
    rotary: float  # zone_reax [rad], where only a rotary external axis moves


_MILLIMETRES = {  # pzone_tcp, pzone_ori, pzone_eax [mm], zone_ori [deg], zone_leax [mm], zone_reax [deg]
    "z0": (0.3, 0.3, 0.3, 0.03, 0.3, 0.03),
    "z1": (1, 1, 1, 0.1, 1, 0.1),
    "z5": (5, 8, 8, 0.8, 8, 0.8),
    "z10": (10, 15, 15, 1.5, 15, 1.5),
    "z15": (15, 23, 23, 2.3, 23, 2.3),
    "z20": (20, 30, 30, 3.0, 30, 3.0),
    "z30": (30, 45, 45, 4.5, 45, 4.5),
    "z40": (40, 60, 60, 6.0, 60, 6.0),
    "z50": (50, 75, 75, 7.5, 75, 7.5),
    "z60": (60, 90, 90, 9.0, 90, 9.0),
    "z80": (80, 120, 120, 12, 120, 12),
    "z100": (100, 150, 150, 15, 150, 15),
    "z150": (150, 225, 225, 23, 225, 23),
    "z200": (200, 300, 300, 30, 300, 30),
}

ZONES = MappingProxyType(
    {"fine": PredefinedZone(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)}
    | {
        name: PredefinedZone(a * mm, b * mm, c * mm, d * deg, e * mm, f * deg)
        for name, (a, b, c, d, e, f) in _MILLIMETRES.items()
    }
)


def zone(name: str) -> PredefinedZone:
    """The predefined zone called `name`, in any case of letters. Raises OlpError (T014) with the known names if
    there is none.
    """
    found = ZONES.get(name.lower())
    if found is None:
        raise OlpError(error("T014", f"there is no zone {name!r}", help=f"predefined: {', '.join(ZONES)}"))
    return found


class Zones(ParabolicLaw):
    """The corner path, a parabola, begins at the edge of the zone and is symmetrical.

    "The zone size cannot be larger than half the distance to the closest position (forwards or backwards). If a
    larger zone is specified, the robot automatically reduces it." Speeds that differ change into each other
    within the corner path. The programmed speed is kept where the acceleration allows (the manual gives no
    number for that).
    """

    summary = "ABB zones fine, z0 to z200: a parabola from pzone_tcp before the point to pzone_tcp behind it"
    source = "ABB RAPID reference manual: zonedata; motion and I/O principles, corner paths. Not measured"
    amount = "pzone_tcp [m]"
