"""The page's colours as CSS variables, light and dark, and the scale from "robot faster" to "robot slower"."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.reports.plot.figure import SERIES, TONES

Floats = NDArray[np.float64]

# Blue and orange stay apart for all common kinds of colour blindness; the middle recedes into the paper.
_SCALE = (
    ("#08468c", "#a9d2ff"),
    ("#2672b8", "#6fb1f5"),
    ("#62a5d6", "#4385cb"),
    ("#a6c8e0", "#35587d"),
    ("#b3b9c0", "#525b66"),
    ("#edc196", "#7d5735"),
    ("#e08e3e", "#bb6f2a"),
    ("#c25a0c", "#f09a4c"),
    ("#853602", "#ffcd9c"),
)
STEPS = len(_SCALE)


def variables() -> str:
    """Declarations of both themes; the system's wish holds until the reader chooses."""
    light = _declared(0)
    dark = _declared(1)
    return (
        f":root{{color-scheme:light;{light}}}"
        f"@media (prefers-color-scheme:dark){{:root:not([data-theme=light]){{color-scheme:dark;{dark}}}}}"
        f":root[data-theme=dark]{{color-scheme:dark;{dark}}}"
        f"@media print{{:root:root:root{{color-scheme:light;{light}}}}}"
    )


def _declared(theme: int) -> str:
    tones = "".join(f"--{role}:{tone[theme]};" for role, tone in TONES.items())
    series = "".join(f"--s{i}:var(--{role});" for i, role in enumerate(SERIES))
    scale = "".join(f"--r{i}:{step[theme]};" for i, step in enumerate(_SCALE))
    return tones + series + scale


def scale_limit(residual: Floats) -> float:
    """[s] where the scale ends: nineteen of twenty moves lie within, so that one outlier does not wash out the rest."""
    known = np.abs(residual[np.isfinite(residual)])
    return float(max(np.quantile(known, 0.95), 1e-6)) if len(known) else 1e-3


def step_of(residual: Floats, limit: float) -> NDArray[np.int64]:
    """(n,) the scale's step, 0 much faster than simulated … STEPS - 1 much slower."""
    half = (STEPS - 1) / 2
    steps = np.round(np.nan_to_num(residual) / limit * half) + half
    return np.asarray(np.clip(steps, 0, STEPS - 1).astype(np.int64))
