"""A small minimiser for smooth functions of a few variables: BFGS with a backtracking line search.

J. Nocedal and S. J. Wright, Numerical Optimization (2nd ed., Springer 2006), algorithms 3.1 and 6.1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Of the decrease that the slope promises, the share that has to come true.
_ENOUGH = 1e-4
_LONGEST = 1.0  # in the units of the variables, which are logarithms


def minimise(
    function: Callable[[Floats], tuple[float, Floats]], start: Floats, most: int, enough: float = 1e-6
) -> Floats:
    """The best point found from `start`. `function` gives value and gradient.

    Ends after `most` steps, or when one gains less than `enough`.
    """
    place = np.array(start, dtype=np.float64)
    value, slope = function(place)
    inverse = np.eye(len(place)) / max(1.0, float(np.linalg.norm(slope)))
    for _ in range(most):
        step = -inverse @ slope
        if step @ slope >= 0:
            inverse = np.eye(len(place)) / max(1.0, float(np.linalg.norm(slope)))
            step = -inverse @ slope
        step *= min(1.0, _LONGEST / max(float(np.max(np.abs(step))), 1e-12))
        size = 1.0
        while size > 1e-6:
            reached, new_slope = function(place + size * step)
            if reached <= value + _ENOUGH * size * float(step @ slope):
                break
            size *= 0.4
        else:
            return place
        moved, turned = size * step, new_slope - slope
        place = place + moved
        gained, value, slope = value - reached, reached, new_slope
        curve = float(moved @ turned)
        if curve > 1e-12:
            left = np.eye(len(place)) - np.outer(moved, turned) / curve
            inverse = left @ inverse @ left.T + np.outer(moved, moved) / curve
        if gained < enough:
            return place
    return place
