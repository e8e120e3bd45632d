"""Measured numbers of the by-pose law, per robot: facts with their source, no code.

Fitted by `bench/ma2010.py`, which prints them again; tests hold them to the measured table they come from.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import NamedTuple


class Swing(NamedTuple):
    """Axis S. 1/a = fixed + elbow e² + forearm f², a at most `cap`: inertia over torque, and what the
    controller allows.

    e: horizontal distance of the elbow from axis S [m]; f: of the point `ahead`, `above` [m] in the forearm's
    frame.
    """

    fixed: float  # [s²/rad]
    elbow: float  # [s²/rad/m²]
    forearm: float  # [s²/rad/m²]
    ahead: float  # [m] along the forearm from axis U
    above: float  # [m] across it
    cap: float  # [rad/s²]


class Lean(NamedTuple):
    """Axis L. a = (1 + both ± gravity) / inertia, over the torque; + for leaning forward.

    inertia = fixed + cosine cos U + sine sin U [s²/rad]: the forearm is nearer or further with U alone. gravity
    and `both` are sums of parts along (sin L, cos L, cos E, sin E), E = U - L the forearm's elevation: the
    lever of the upper arm and of the forearm, and what slows both directions alike (balancer, friction under
    load).
    """

    fixed: float
    cosine: float
    sine: float
    gravity: tuple[float, float, float, float]  # [1]
    both: tuple[float, float, float, float]  # [1]


class Lift(NamedTuple):
    """Axis U. a = high - s drop ∓ (lever - s eased) g, g = cos(E + offset) the forearm's horizontal lever; -
    for lifting.

    s = 1 / (1 + exp((start - |g|) / width)) steps to 1 where |g| passes `start`: two levels of acceleration.
    """

    offset: float  # [rad] from the forearm's axis to its centre of mass
    start: float  # [1] share of the full lever
    width: float  # [1]
    high: float  # [rad/s²]
    drop: float  # [rad/s²]
    lever: float  # [rad/s²]
    eased: float  # [rad/s²]


class ByPose(NamedTuple):
    """The first three axes; `ranges`: lowest and highest measured [rad/s²], kept outside the measured poses too."""

    swing: Swing
    lean: Lean
    lift: Lift
    ranges: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
    source: str


MEASURED = MappingProxyType(
    {
        "yaskawa/ma2010": ByPose(
            swing=Swing(
                fixed=0.06379, elbow=0.02967, forearm=0.02152, ahead=0.91025, above=0.26087, cap=13.05
            ),
            lean=Lean(
                fixed=0.16157,
                cosine=0.01237,
                sine=0.05723,
                gravity=(0.0897, -0.01119, 0.05436, -0.01082),
                both=(0.0179, 0.21379, 0.00777, 0.15928),
            ),
            lift=Lift(
                offset=0.34476,
                start=0.70793,
                width=0.05004,
                high=10.56506,
                drop=2.23369,
                lever=0.98795,
                eased=0.59805,
            ),
            ranges=((5.87, 13.92), (3.95, 10.34), (7.38, 11.31)),
            source="published DX200 recordings of an MA2010 (axes S, L, U swung by 0.05 to 0.07 rad at full speed in "
            "202 poses, L -33 to 93 deg, U -71 to 147 deg; mean of the five largest filtered accelerations)",
        )
    }
)
