"""Recorders: what a clock, a file and a person make of true durations."""

import numpy as np

KINDS = ("white", "white", "grid", "digits", "stamps", "stamps", "heavy", "slow")


def record(rng, kind: str, true: np.ndarray, sigma: float) -> tuple[np.ndarray, float | None]:
    """Durations as recorded [s], and the resolution that the file states (None: not stated).

    `stamps` are differences of events that neighbours share, `slow` errors last for some moves, `grid` is a task of
    1, 10 or 12 ms that reads the same events, `digits` a table that somebody rounded.
    """
    n = len(true)
    if kind == "white":
        return true + rng.normal(0, sigma, n), None
    if kind == "heavy":
        return true + sigma * rng.standard_t(2.5, n) / 1.5, None
    if kind == "stamps":
        return true + np.diff(rng.normal(0, sigma / np.sqrt(2), n + 1)), None
    if kind == "slow":
        noise = rng.normal(0, sigma, n + 20)
        for i in range(1, len(noise)):
            noise[i] = 0.5 * noise[i - 1] + np.sqrt(0.75) * noise[i]
        return true + noise[20:], None
    if kind == "digits":
        return np.round(true + rng.normal(0, 0.001, n), 2), 0.01 if rng.random() < 0.5 else None
    step = float(rng.choice([0.001, 0.01, 0.012]))
    events = np.append(0.0, np.cumsum(true)) + rng.uniform(0, step)
    events += rng.normal(0, 0.0003, n + 1)
    return np.diff(np.floor(events / step)) * step, step if rng.random() < 0.7 else None
