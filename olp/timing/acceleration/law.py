"""Base class of all acceleration laws; the files of this folder are the list of laws."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.core.registry import file_names, load_from
from olp.robots.model import Robot

Floats = NDArray[np.float64]


class AccelerationLaw(ABC):
    """How quickly each axis of a robot may change its speed."""

    summary: ClassVar[str]
    source: ClassVar[str]

    @property
    def name(self) -> str:
        """Name of the law: that of its file."""
        return type(self).__module__.rpartition(".")[2]

    @abstractmethod
    def knows(self, robot: Robot) -> bool:
        """Whether the law has numbers for this robot; without them its accelerations are nan, never a guess."""

    @abstractmethod
    def limits(self, robot: Robot, joints: Floats, directions: Floats) -> Floats:
        """Implements `accelerations` for checked input; both arrays are (n, k)."""

    @final
    def accelerations(self, robot: Robot, joints: ArrayLike, directions: ArrayLike) -> Floats:
        """Accelerations of each axis (n, k) [rad/s² | m/s²], positive, nan where unknown, in poses `joints` (n, k)
        [rad | m].

        `directions` (n, k): the sign of the wanted acceleration of each axis; 0 gives the lower one of both signs.
        Raises OlpError: T022 wrong number of axes.
        """
        places = np.atleast_2d(np.asarray(joints, dtype=np.float64))
        if places.ndim != 2 or places.shape[1] != len(robot.axes):
            says = f"{robot.name} has {len(robot.axes)} axes, the points have {places.shape[-1]}"
            raise OlpError(error("T022", says))
        signs = np.broadcast_to(np.sign(np.asarray(directions, dtype=np.float64)), places.shape)
        forth, back = (self.limits(robot, places, np.full_like(places, s)) for s in (1.0, -1.0))
        result: Floats = np.where(signs > 0, forth, np.where(signs < 0, back, np.minimum(forth, back)))
        return result

    @final
    def along_path(
        self, robot: Robot, joints: ArrayLike, rates: ArrayLike
    ) -> tuple[Floats, NDArray[np.intp]]:
        """The highest acceleration along a path [m/s²] (n,), and the axis that limits it (n,).

        `rates` (n, k) [rad/m | 1]: how far each axis turns per metre of path, signed in the direction of the
        acceleration; the path's own curvature is not included. Axes with an unknown acceleration set no limit.
        Raises OlpError: T022.
        """
        turned = np.atleast_2d(np.asarray(rates, dtype=np.float64))
        limits = self.accelerations(robot, joints, turned)
        with np.errstate(divide="ignore", invalid="ignore"):
            allowed = np.where(np.isnan(limits) | (turned == 0), np.inf, limits / np.abs(turned))
        axis = np.argmin(allowed, axis=1)
        return allowed.min(axis=1), axis


def law_names() -> tuple[str, ...]:
    """Names of all acceleration laws (the files of this folder), without loading them."""
    return file_names(AccelerationLaw)


def load_law(name: str) -> AccelerationLaw:
    """Load the acceleration law called `name`. Raises OlpError (T021) with the known names if there is none."""
    return load_from(AccelerationLaw, name, "acceleration law", "T021")
