"""Retiming: the highest speed along a path within the limits of every axis, and the limiting axis at each place."""

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
