"""The base of the laws in which both moves run at once: their shape is that of an Overlap."""

from __future__ import annotations

from abc import abstractmethod

from olp.timing.blending._overlap import Floats, Overlap
from olp.timing.blending.law import BlendingLaw, Corners


class OverlappingLaw(BlendingLaw):
    """A law that says how the two moves overlap; where the tool is follows from that."""

    @abstractmethod
    def _overlap(self, corners: Corners) -> Overlap:
        """When each move of each corner fades out and in."""

    def span(self, corners: Corners) -> Floats:
        return self._overlap(corners).span

    def position(self, corners: Corners, time: Floats) -> Floats:
        return self._overlap(corners).position(time)

    def velocity(self, corners: Corners, time: Floats) -> Floats:
        return self._overlap(corners).velocity(time)
