"""Universal Robots: the blend radius r of movej, movel and movep."""

from __future__ import annotations

from olp.timing.blending._parabola import ParabolicLaw


class BlendRadius(ParabolicLaw):
    """Within r of the waypoint the robot leaves its path and joins the next one: a parabola from r before to r
    behind.

    The script manual states the radius, not the curve. Users report that the tool's speed inside is not the
    programmed one at low speeds, and that blends start late; this law models neither. The robot skips a waypoint
    whose blend overlaps another's, and warns; here the blend is cut to half of the move and reported (T104).
    """

    summary = "UR blend radius r: leaves the path at r before the waypoint, joins the next at r behind it"
    source = "Universal Robots script manual, parameter r of movej, movel, movep. The curve is assumed, not measured"
    amount = "blend radius r [m]"
    overlap_skips = True
