"""How fast a path can be followed when every axis has limits, and which axis limits where."""

from olp.timing.retiming.along import along_path
from olp.timing.retiming.path import PathLimits, SampledPath, Singular, Spline, spline_through
from olp.timing.retiming.retime import Further, Limiter, LimitKind, Retimed, retime

__all__ = [
    "Further",
    "LimitKind",
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

# What these were called in earlier versions.
Kind = LimitKind
