"""What something along the way is over the ramps of the judged simulation."""

from __future__ import annotations

import numpy as np

from olp.physics._case import Case, Floats


def ramp_weights(case: Case, places: int, end: int) -> Floats:
    """(n, m) weights, summing to 1, of places along the way in the ramp at the start (0) or end (1).

    While speed grows from rest, the time spent at a place is one over the square root of the way behind it, and the
    speed gained there is the same: so places count by what they add to the speed.
    """

    def work_out() -> Floats:
        share = np.linspace(0.0, 1.0, places)
        share = 1.0 - share if end else share
        slow = case.base.decelerate if end else case.base.accelerate
        ramp = np.clip(case.base.speed**2 / (2 * slow) / np.maximum(case.base.way, 1e-9), 0.02, 0.5)
        step = 0.5 / (places - 1)
        inner = np.sqrt(np.clip((share - step)[None, :], 0.0, ramp[:, None]))
        outer = np.sqrt(np.clip((share + step)[None, :], 0.0, ramp[:, None]))
        weight = outer - inner
        return np.asarray(weight / weight.sum(axis=1)[:, None])

    return case.once(f"ramp weights {places} {end}", work_out)


def over_ramp(case: Case, values: Floats, end: int) -> Floats:
    """(n, …) mean over the ramp of values (n, m, …) along the way."""
    weight = ramp_weights(case, values.shape[1], end)
    return np.asarray(np.einsum("nm,nm...->n...", weight, values))
