"""How fast a path can be followed when every axis has limits, and which axis limits where."""

from olp.retiming.along import along_path
from olp.retiming.limits import PathLimits, Singular
from olp.retiming.path import SampledPath
from olp.retiming.retime import Further, Kind, Limiter, Retimed, retime
from olp.retiming.spline import Spline, spline_through

__all__ = [
    "Further",
    "Kind",
    "Limiter",
    "PathLimits",
    "Retimed",
    "SampledPath",
    "Singular",
    "Spline",
    "along_path",
    "retime",
    "spline_through",
]
