"""A Robot.Trajectory that takes as long as olp predicts, by FreeCAD's own law of motion.

FreeCAD runs each piece between two waypoints by a trapezoid of speed from a stop to a stop (KDL's
VelocityProfile_Trap): T = L / V + V / A, or 2 √(L / A) where V is not reached. L is the longer of the way in mm and of
the turn in rad times 1 mm. It knows no arcs and passes over waits, so a curve is a row of short pieces, and a
wait is a piece of a thousandth of a millimetre that takes as long.
"""

from __future__ import annotations

import math

from FreeCAD import Placement, Vector

from olp_freecad.places import placement

_LEAST = 1e-3  # mm; KDL takes 1e-6 for nothing
_STEADY = 1.02  # a piece that may not slow down is 2 % faster in its middle than on average
_AT_ONCE = 1e9


def acceleration_for(length: float, seconds: float, speed: float) -> tuple[float, float]:
    """Speed [mm/s] and acceleration [mm/s²] with which FreeCAD takes `seconds` for `length` [mm].

    The speed is the given one as long as it is fast enough to come there in time.
    """
    if seconds <= 0.0:
        return _AT_ONCE, _AT_ONCE
    if not speed > 0.0 or length >= speed * seconds * (1.0 - 1e-6):
        speed = _STEADY * length / seconds
    if 2.0 * length <= speed * seconds:
        return speed, 4.0 * length / seconds**2
    return speed, speed / (seconds - length / speed)


class _Course:
    """Waypoints in the making; each begins where the one before it ended."""

    def __init__(self) -> None:
        self.waypoints: list = []
        self.last: Placement | None = None

    def begin(self, place: Placement) -> None:
        self._append(place, "PTP", "start", _AT_ONCE, _AT_ONCE)

    def wait(self, seconds: float, name: str) -> None:
        if self.last is not None:
            self.go(self.last, seconds, 0.0, "LIN", name)

    def go(self, place: Placement, seconds: float, speed: float, kind: str, name: str) -> None:
        assert self.last is not None
        if host_length(self.last, place) < _LEAST:
            if seconds <= 0.0:
                return
            place = Placement(self.last.Base + Vector(0.0, 0.0, _LEAST), place.Rotation)
        speed, acceleration = acceleration_for(host_length(self.last, place), seconds, speed)
        self._append(place, kind, name, speed, acceleration)

    def _append(self, place: Placement, kind: str, name: str, speed: float, acceleration: float) -> None:
        import Robot

        self.waypoints.append(Robot.Waypoint(place, type=kind, name=name, vel=speed, acc=acceleration))
        self.last = place


def waypoints(segments: list) -> list:
    """One per move, with the acceleration that gives its predicted time; more along curves; one per wait."""
    course = _Course()
    # A wait before the first move stands where that begins.
    first = next((one["start"] for one in segments if one.get("start")), None)
    if first is not None:
        course.begin(placement(first))
        for segment in segments:
            _add(course, segment)
    return course.waypoints


def _add(course: _Course, segment: dict) -> None:
    seconds, name = segment["duration_s"] or 0.0, f"line {segment['line']}"
    way = segment.get("way") or []
    if segment.get("target") is None:
        course.wait(seconds, name)
    elif segment["path"] == "linear" or len(way) < 3:
        kind = "PTP" if segment["path"] == "joint" else "LIN"
        course.go(placement(segment["target"]), seconds, segment["reached_mm_s"] or 0.0, kind, name)
    else:
        for number, (instant, place) in enumerate(way[1:], 1):
            end = segment["target"] if number == len(way) - 1 else place
            course.go(placement(end), instant - way[number - 1][0], 0.0, "LIN", f"{name} ({number})")


def host_length(start: Placement, end: Placement) -> float:
    """The length that FreeCAD's law counts."""
    turn = (start.Rotation.inverted() * end.Rotation).Angle
    turn = min(turn, 2.0 * math.pi - turn)
    return max((end.Base - start.Base).Length, turn)


def trajectory(segments: list) -> object | None:
    """Robot.Trajectory, or None in a FreeCAD without its Robot module."""
    try:
        import Robot
    except ImportError:
        return None
    return Robot.Trajectory(waypoints(segments))
