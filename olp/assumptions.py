"""What a program cannot tell about itself: `olp.toml` beside the jobs.

Inputs, how long a wait lasts, what an operator types, which robot it is. Whatever the file does not say, the
interpreter assumes in one documented way and reports.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import NamedTuple

from olp.diagnostic import Diagnostic
from olp.expression import Store
from olp.points import PointState


class SignalKey(NamedTuple):
    """A signal whatever way it was written: bus as in `olp.expression.Signal`, and number."""

    bus: str
    number: int


class WrittenPosition(NamedTuple):
    """A position from the file: `values` in pulses, or metres and radians, as `state` says."""

    state: PointState
    values: tuple[float, ...]


Given = int | float | str | WrittenPosition


@dataclass(frozen=True, slots=True)
class Assumptions:
    """The file's content in SI. Every mapping is empty where the file says nothing."""

    path: str = ""
    robot: str = ""  # library name or file, for the first robot
    robots: Mapping[str, str] = field(default_factory=dict)  # mechanism (RB1, BS1, ST1) -> robot
    inputs: Mapping[SignalKey, tuple[int, ...]] = field(
        default_factory=dict
    )  # one value per read, the last holds
    variables: Mapping[tuple[Store, int], Given] = field(default_factory=dict)
    waits: Mapping[SignalKey, float] = field(default_factory=dict)  # [s] until that signal comes
    default_wait: float | None = None  # [s] for all other waits
    pause: float | None = None  # [s] until the operator starts again
    process: Mapping[str, float] = field(default_factory=dict)  # [s] per process instruction, lower case
    motion: Mapping[str, str | float] = field(default_factory=dict)  # model, accel_mm_s2 … as written
    start: Mapping[str, WrittenPosition] = field(
        default_factory=dict
    )  # mechanism -> where it stands at first
    diagnostics: tuple[Diagnostic, ...] = ()


FILE_NAME = "olp.toml"
_LEVELS = 5  # folders above the job that are searched


def nearest_assumptions(folder: FilePath) -> FilePath | None:
    """The `olp.toml` that holds for jobs in `folder`: there, or up to five folders above, not beyond a repository."""
    current = folder.resolve()
    for _ in range(_LEVELS + 1):
        candidate = current / FILE_NAME
        if candidate.is_file():
            return candidate
        if (current / ".git").exists() or current.parent == current:
            return None
        current = current.parent
    return None


def load_assumptions(path: str | os.PathLike[str]) -> Assumptions:
    return Assumptions(str(path))
