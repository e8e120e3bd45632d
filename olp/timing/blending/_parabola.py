"""A corner rounded by the parabola that touches both moves at the same distance z from the corner point.

P(u) = corner - z (1 - u)² d1 + z u² d2. Its vertex passes the corner at z/2 sin(turn/2), and is where it bends
most: radius z cos²(turn/2) / sin(turn/2). Where the acceleration allows, the tool keeps its speed along it;
where not, it slows down towards the vertex, in the limit as a body thrown does: one constant acceleration for
the whole corner, u growing evenly, speed at the vertex cos(turn/2) of that at the ends (linear segments with
parabolic blends: R. P. Paul, Robot Manipulators, 1981; J. J. Craig, Introduction to Robotics, chapter on
trajectories).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from olp.timing.blending.law import BlendingLaw, Corners, Passage

Floats = NDArray[np.float64]
_STRAIGHT = 1e-6  # [rad] a turn below this is what rounding leaves of none


@dataclass(frozen=True, slots=True)
class Parabola:
    """n parabolic corners, (n,) each."""

    zone: Floats  # [m]
    cosine: Floats  # of half the turn
    sine: Floats
    speed_in: Floats  # [m/s]
    speed_out: Floats  # [m/s]
    thrown: Floats  # 0: constant speed along the curve, 1: constant acceleration
    duration: Floats  # [s]

    @property
    def length(self) -> Floats:
        """Length of the curve [m]."""
        return 2 * self.zone * _arc(np.ones_like(self.zone), self.cosine, self.sine)

    def parameter(self, time: Floats) -> Floats:
        """Curve parameter u (n, m) at `time` (n, m) [s]; between different speeds at the ends the speed changes
        evenly.
        """
        total = self.speed_in + self.speed_out
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(self.duration[:, None] > 0, time / self.duration[:, None], 0.0)
            first = np.where(total > 0, 2 * self.speed_in / total, 1.0)[:, None]
        share = np.clip(share, 0.0, 1.0)
        share = share * (first + (1.0 - first) * share)
        thrown = self.thrown[:, None]
        return thrown * share + (1 - thrown) * self._even(share)

    def _even(self, share: Floats) -> Floats:
        """Parameter u at which this share of the curve's length is covered: bisection, then Newton, as there is no
        closed form.
        """
        cosine, sine = self.cosine[:, None], self.sine[:, None]
        wanted = share * _arc(np.ones_like(share), cosine, sine)
        low, high = np.zeros_like(share), np.ones_like(share)
        for _ in range(10):
            middle = (low + high) / 2
            short = _arc(middle, cosine, sine) < wanted
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        u = (low + high) / 2
        for _ in range(4):
            slope = np.sqrt(cosine**2 + ((2 * u - 1) * sine) ** 2)
            u = np.clip(u - (_arc(u, cosine, sine) - wanted) / np.maximum(slope, 1e-12), low, high)
        return u


class ParabolicLaw(BlendingLaw):
    """Common part of the laws with a parabola; each law defines only its zone."""

    def zone(self, corners: Corners) -> Floats:
        """Distance of the parabola's ends from the corner point [m], (n,), before the half-segment cap."""
        return corners.amount

    def curve(self, corners: Corners) -> Parabola:
        """The parabolas of the corners with their speeds."""
        zone = np.minimum(self.zone(corners), corners.half)
        sine, cosine = np.sin(corners.turn / 2), np.cos(corners.turn / 2)
        limit = np.minimum(corners.deceleration, corners.acceleration)
        with np.errstate(divide="ignore", invalid="ignore"):
            most = np.where(sine > _STRAIGHT, np.sqrt(limit * zone / sine), np.inf)
        most = np.where((zone <= 0) & (sine > _STRAIGHT), 0.0, most)
        first, last = np.minimum(corners.speed_before, most), np.minimum(corners.speed_after, most)
        first, last = _matched(first, last, zone, corners)
        with np.errstate(invalid="ignore"):
            bent = np.where(np.isfinite(most), most * cosine, np.inf)
        entry = np.maximum(first, last)
        vertex = np.minimum(entry, bent)
        with np.errstate(divide="ignore", invalid="ignore"):
            lost = np.where(entry > 0, (1 - vertex / entry) / (1 - cosine), 0.0)
        thrown = np.where(vertex < entry, np.clip(lost, 0.0, 1.0), 0.0)
        curve = Parabola(zone, cosine, sine, first, last, thrown, np.zeros_like(zone))
        way = (1 - thrown) * curve.length + thrown * 2 * zone
        total = first + last
        duration = np.divide(2 * way, total, out=np.zeros_like(way), where=total > 0)
        return Parabola(zone, cosine, sine, first, last, thrown, duration)

    def passage(self, corners: Corners) -> Passage:
        curve = self.curve(corners)
        return Passage(
            trim_before=curve.zone,
            trim_after=curve.zone,
            duration=curve.duration,
            speed_in=curve.speed_in,
            speed_out=curve.speed_out,
            capped=self.zone(corners) > corners.half,
        )

    def span(self, corners: Corners) -> Floats:
        return self.curve(corners).duration

    def position(self, corners: Corners, time: Floats) -> Floats:
        curve = self.curve(corners)
        u = curve.parameter(time)
        zone = curve.zone[:, None]
        return np.stack([-zone * (1 - u) ** 2, zone * u**2], axis=-1)

    def velocity(self, corners: Corners, time: Floats) -> Floats:
        curve = self.curve(corners)
        # The parameter's rate by a symmetric difference: it has no closed form at constant speed.
        step = np.maximum(curve.duration[:, None] * 1e-4, 1e-12)
        u = curve.parameter(time)
        later = np.minimum(time + step, curve.duration[:, None])
        earlier = np.maximum(time - step, 0.0)
        width = np.maximum(later - earlier, 1e-15)
        rate = (curve.parameter(later) - curve.parameter(earlier)) / width
        zone = curve.zone[:, None]
        along = np.stack([2 * zone * (1 - u) * rate, 2 * zone * u * rate], axis=-1)
        entering = np.zeros_like(along)
        entering[..., 0] = curve.speed_in[:, None]
        return np.where(curve.duration[:, None, None] > 0, along, entering)


def _matched(first: Floats, last: Floats, zone: Floats, corners: Corners) -> tuple[Floats, Floats]:
    """Speeds at both ends such that the acceleration can change one into the other within the zone."""
    with np.errstate(invalid="ignore"):
        gain = np.sqrt(first**2 + np.where(zone > 0, 4 * corners.acceleration * zone, 0.0))
        loss = np.sqrt(last**2 + np.where(zone > 0, 4 * corners.deceleration * zone, 0.0))
    return np.minimum(first, loss), np.minimum(last, gain)


def _arc(u: Floats, cosine: Floats, sine: Floats) -> Floats:
    """Length of the parabola from 0 to u over 2 z: the integral of |(1 - u) d1 + u d2|.

    With w = 2u - 1 the integrand is sqrt(cos² + w² sin²) / 1, w from -1 on.
    """
    w = 2 * u - 1
    return (_primitive(w, cosine, sine) - _primitive(np.full_like(w, -1.0), cosine, sine)) / 2


def _primitive(w: Floats, cosine: Floats, sine: Floats) -> Floats:
    root = np.sqrt(cosine**2 + (w * sine) ** 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        bent = cosine**2 * np.arcsinh(w * sine / cosine) / sine
    bent = np.where(sine < 1e-6, cosine * w, np.where(cosine < 1e-9, 0.0, bent))
    result: Floats = (w * root + bent) / 2
    return result
