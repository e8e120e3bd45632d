"""Which rows of a recording run into each other: where the arm stands, and where it passes a corner."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from olp.identification.recording.moves import RecordedMoves

Mask = NDArray[np.bool_]

_SAME_PLACE = 1e-3  # [m], [rad] a move that begins this near to the end of the one before goes on from there


class Stretches(NamedTuple):
    """(n,) each. Rows with one `label` run from stop to stop."""

    begins_rolling: Mask
    ends_rolling: Mask  # into the next row
    open: Mask  # not in an exact stop, and no row goes on from there
    label: NDArray[np.int64]

    @property
    def stops(self) -> NDArray[np.int64]:
        """(n,) at how many of its two ends the arm stands."""
        return 2 - self.begins_rolling.astype(np.int64) - self.ends_rolling


def stretches_of(moves: RecordedMoves) -> Stretches:
    """A row that ends in no exact stop runs into the next one where that begins at its end, in the same program."""
    from olp.identification.recording.moves import WAIT

    count = len(moves)
    rolls = ~moves.stops & (moves.kind != WAIT)
    goes_on = np.zeros(count, dtype=bool)
    if count > 1:
        goes_on[:-1] = (moves.kind[1:] != WAIT) & meets(moves)
    ends = rolls & goes_on
    begins = np.concatenate([[False], ends[:-1]]) if count else ends
    label = np.cumsum(~begins).astype(np.int64) - 1
    return Stretches(begins, ends, rolls & ~goes_on, label)


def meets(moves: RecordedMoves) -> Mask:
    """(n - 1,) whether each row begins where, and in the program in which, the one before ended."""
    same = np.array([a == b for a, b in zip(moves.job[:-1], moves.job[1:], strict=True)], dtype=bool)
    same &= moves.cycle[:-1] == moves.cycle[1:]
    apart = np.full(len(same), np.inf)
    for ends, starts in ((moves.end, moves.start), (moves.joints_end, moves.joints_start)):
        if ends.shape[1]:
            step = np.linalg.norm(starts[1:] - ends[:-1], axis=1)
            apart = np.fmin(apart, step)
    return np.asarray(same & (apart < _SAME_PLACE))


def plain_rows(moves: RecordedMoves, stretches: Stretches) -> Mask:
    """(n,) straight moves from stop to stop, which the methods of a signature are made for."""
    from olp.identification.recording.moves import LINEAR

    return np.asarray((moves.kind == LINEAR) & (stretches.stops == 2) & ~stretches.open)
