"""Places between olp and FreeCAD: mm and quaternions (x, y, z, w) on both sides."""

from __future__ import annotations

from FreeCAD import Placement, Rotation, Vector


def placement(place: dict) -> Placement:
    return Placement(Vector(*place["position"]), Rotation(*place["quaternion"]))


def place_of(one: Placement) -> dict:
    return {"position": list(one.Base), "quaternion": list(one.Rotation.Q)}


def differ(one: Placement, other: Placement) -> bool:
    """Further apart than a thousandth of a millimetre or a ten-thousandth of a degree."""
    turn = (one.Rotation.inverted() * other.Rotation).Angle
    return (one.Base - other.Base).Length > 1e-3 or min(turn, 6.283185307179586 - turn) > 2e-6
