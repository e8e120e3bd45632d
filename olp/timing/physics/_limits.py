"""Limits that moves reach: start values for their search, and the time that a speed limit along the way costs."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from olp.core import compiled_loops
from olp.timing.physics._case import Floats
from olp.timing.physics._motion import Motion

_FEWEST, _FACTOR, _MOST = 2.0, 2.3, 0.8
_BELOW = 0.97  # of what the last of the moves asks: it is touched too


def limits_reached(asked: Floats) -> Floats:
    """Limits (g,) that two, five, eleven … of the moves reach, as the gradient vanishes at one that none reaches;
    `asked` (n,): what each move needs."""
    asked = np.sort(asked[asked > 0])[::-1]
    if not len(asked):
        return np.zeros(0)
    counts, count = list[int](), _FEWEST
    while count <= max(_MOST * len(asked), _FEWEST):
        counts.append(min(round(count), len(asked)))
        count *= _FACTOR
    return np.unique(_BELOW * asked[np.array(counts) - 1])


def slowed_below(motion: Motion, rows: NDArray[np.intp], limit: Floats) -> Floats:
    """Time (r,) [s] that moves `rows` take longer along the path at no more than `limit` (r, m) [m/s], within the
    ramps' accelerations, than at no more than the programmed speed.

    Forwards and backwards over the squares of the speed (J. Bobrow, S. Dubowsky, J. Gibson, 1985): exact for
    constant acceleration between two places, and where a ramp from or to rest ends before the next place.
    """
    places = limit.shape[1]
    speed, step = motion.speed[rows], motion.way[rows] / (places - 1)
    up, down = 2.0 * motion.accelerate[rows] * step, 2.0 * motion.decelerate[rows] * step
    if _LOOPS.worth(len(rows)):
        slow = np.empty((2, len(rows), places - 1))
        _compiled_slowness(speed, up, down, limit, slow)
    else:
        slow = _slowness(speed, up, down, limit)
    whole, alone = step * slow.sum(axis=2)
    return np.asarray(whole - alone)


def _slowness(speed: Floats, up: Floats, down: Floats, limit: Floats) -> Floats:
    """(2, r, m - 1) [s/m] between two places each, with the limit (r, m) [m/s] and without it; `up`, `down` (r,)
    [m²/s²]: what the square of the speed (r,) gains or loses from one place to the next."""
    at = np.arange(limit.shape[1])
    gained, lost = up[:, None] * at, down[:, None] * at[::-1]
    # With the limit, and without it, which has a closed form.
    squares = np.empty((2, *limit.shape))
    square = np.minimum(speed[:, None], limit, out=squares[0])
    np.square(square, out=square)
    # At rounded corners the ramps are whole too: they overlap with the neighbours' ones.
    square[:, 0] = square[:, -1] = 0.0
    # A place is reached from any place before it, at a gain for each step between: over all places in one go.
    square -= gained
    np.minimum.accumulate(square, axis=1, out=square)
    square += gained
    square -= lost
    np.minimum.accumulate(square[:, ::-1], axis=1, out=square[:, ::-1])
    square += lost
    # What was taken off and added again leaves a rounding, at rest below nothing.
    np.maximum(square, 0.0, out=square)
    np.minimum(gained, lost, out=squares[1])
    np.minimum(squares[1], (speed**2)[:, None], out=squares[1])
    between = np.sqrt(squares, out=squares)
    slow = between[:, :, 1:] + between[:, :, :-1]
    np.maximum(slow, 1e-9, out=slow)
    np.divide(2.0, slow, out=slow)
    # A ramp from rest may end long before the first place.
    for k, gain in ((0, up), (-1, down)):
        top = np.maximum(between[:, :, 1 if k == 0 else -2], 1e-9)
        slow[:, :, k] = 1.0 / top + top / gain
    return slow


_LOOPS = compiled_loops.Loops(1e-6)  # [s] per move that they save, measured


@compiled_loops.kernel()
def _compiled_slowness(speed: Floats, up: Floats, down: Floats, limit: Floats, slow: Floats) -> None:
    """The same as `_slowness`, to the last bit: a search asks for it thousands of times."""
    last = limit.shape[1] - 1
    fast, alone = np.empty(last + 1), np.empty(last + 1)
    for i in range(len(speed)):
        least = np.inf
        for k in range(last + 1):
            here = min(speed[i], limit[i, k])
            here = here * here if 0 < k < last else 0.0
            least = min(least, here - up[i] * k)
            fast[k] = (least + up[i] * k) - down[i] * (last - k)
        least = np.inf
        for k in range(last, -1, -1):
            least = min(least, fast[k])
            fast[k] = least + down[i] * (last - k)
        for k in range(last + 1):
            fast[k] = math.sqrt(max(fast[k], 0.0))
            alone[k] = math.sqrt(min(min(up[i] * k, down[i] * (last - k)), speed[i] * speed[i]))
        for which, speeds in ((0, fast), (1, alone)):
            for k in range(1, last - 1):
                slow[which, i, k] = 2.0 / max(speeds[k + 1] + speeds[k], 1e-9)
            first, final = max(speeds[1], 1e-9), max(speeds[last - 1], 1e-9)
            slow[which, i, 0] = 1.0 / first + first / up[i]
            slow[which, i, last - 1] = 1.0 / final + final / down[i]
