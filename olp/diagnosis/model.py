"""Terms with values, acting together: what the judged simulation would say with them in it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.physics import Form, MoveTerm
from olp.physics._case import Case
from olp.physics._motion import Motion

Floats = NDArray[np.float64]


class Part(NamedTuple):
    """One term of a model, in one of its forms."""

    term: MoveTerm
    form: Form
    values: Floats  # (p,) SI

    @property
    def label(self) -> str:
        """Told apart from all other parts of a model: one form per term, but one for each axis."""
        return f"{self.term.name}/{self.form.axis}"


class Model(NamedTuple):
    """Prediction of durations: the judged simulation's, plus what the parts change in its motion."""

    parts: tuple[Part, ...] = ()

    def seconds(self, case: Case) -> Floats:
        """(n,) [s] predicted durations."""
        return self.both(case)[0]

    def smooth(self, case: Case) -> Floats:
        """(n,) [s] the same, with the mean of rounding to a cycle in its place: it has derivatives."""
        return self.both(case)[1]

    def both(self, case: Case) -> tuple[Floats, Floats]:
        """`seconds` and `smooth` at the price of one."""
        smooth, motion = self._acted(case)
        cycle = motion.cycle
        if cycle <= 0:
            return smooth, smooth
        rounded = np.ceil(smooth / cycle - motion.early - 1e-6) * cycle
        return np.asarray(rounded), smooth + (0.5 - motion.early) * cycle

    def _acted(self, case: Case) -> tuple[Floats, Motion]:
        base = case.once("base", case.base.duration)
        motion = self.motion(case)
        return np.asarray((case.simulated + motion.duration() - base) * motion.rate), motion

    def motion(self, case: Case) -> Motion:
        """The simulation's motion with all parts in it."""
        motion = case.base
        for part in sorted(self.parts, key=lambda p: p.term.stage):
            motion = part.term.act(motion, part.form, part.values, case)
        return motion

    def without(self, index: int) -> Model:
        return Model(self.parts[:index] + self.parts[index + 1 :])

    def contributions(self, case: Case) -> tuple[Floats, ...]:
        """Per part (n,) [s]: its share of the whole correction. The shares add up to it exactly.

        A part's share is the mean of what it adds as the first and as the last of all parts, and what these leave
        over (they act together) is split in proportion to their sizes.
        """
        whole = self.seconds(case) - case.simulated
        shares = []
        for index, part in enumerate(self.parts):
            first = Model((part,)).seconds(case) - case.simulated
            last = self.seconds(case) - self.without(index).seconds(case)
            shares.append(0.5 * (first + last))
        return _balanced(shares, whole)


def _balanced(shares: Sequence[Floats], whole: Floats) -> tuple[Floats, ...]:
    if not shares:
        return ()
    left = whole - np.sum(shares, axis=0)
    sizes = np.abs(shares)
    total = sizes.sum(axis=0)
    parts = np.where(total > 0, sizes / np.where(total > 0, total, 1.0), 1.0 / len(shares))
    return tuple(share + part * left for share, part in zip(shares, parts, strict=True))
