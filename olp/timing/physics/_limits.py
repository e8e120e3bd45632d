"""Start values for the search of a limit: the gradient vanishes at a limit that no move reaches."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats

_FEWEST, _FACTOR, _MOST = 2.0, 2.3, 0.8
_BELOW = 0.97  # of what the last of the moves asks: it is touched too


def limits_reached(asked: Floats) -> Floats:
    """Limits (g,) that two, five, eleven … of the moves reach; `asked` (n,): what each move needs."""
    asked = np.sort(asked[asked > 0])[::-1]
    if not len(asked):
        return np.zeros(0)
    counts, count = list[int](), _FEWEST
    while count <= max(_MOST * len(asked), _FEWEST):
        counts.append(min(round(count), len(asked)))
        count *= _FACTOR
    return np.unique(_BELOW * asked[np.array(counts) - 1])
