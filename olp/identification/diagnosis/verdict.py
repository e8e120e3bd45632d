"""The verdict, and the noise that it is measured by: what the names leave over the noise floor, and nothing else."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.errors import rms
from olp.identification.diagnosis.naming import NamingResult
from olp.identification.diagnosis.scatter import Scatter, digits_of, scatter_of

Floats = NDArray[np.float64]

AGREES = 2.0  # times the noise floor: what is off by more is no agreement
EXPLAINED = 1.5  # times the noise floor that names leave at most
_FEWEST = 4  # moves; fewer are no comparison
_LITTLE = 0.02  # of the mean square: a pattern in what is left of it does not matter
_MOST = 0.5  # of the mean square: names that leave more, and a pattern in it, are not the cause
_ROUGH, _DIGITS = (
    0.03,
    8.0,
)  # share of a duration, and times the digits' standard deviation: robots repeat better


def floor_of(named: NamingResult) -> Scatter:
    """Of repeats where there are enough, else of what remains or of moves that are alike; at least the digits."""
    least = max(digits_of(named.clean), named.noise.least)
    return scatter_of(left_over(named), named.clean, least, named.remains.structured)


def left_over(named: NamingResult) -> Floats:
    """(n,) [s] of the moves that are not late."""
    return np.asarray(named.clean.measured - named.fit.model.seconds(named.clean))


def verdict_of(named: NamingResult) -> str:
    """One of VERDICTS, from the durations alone."""
    if len(named.late) < _FEWEST:
        return "not-judged"
    sigma, left, raw = floor_of(named).value, rms(left_over(named)), rms(named.clean.residual)
    pattern = named.remains.structured and left > digits_of(named.clean)
    if not named.fit.model.parts and not named.late.any():
        rough = _rough(named) and 0 < _DIGITS * digits_of(named.clean) < raw
        return "unexplained" if pattern or rough or left > AGREES * sigma else "no-mismatch"
    if left <= EXPLAINED * sigma and not (pattern and left**2 > _LITTLE * raw**2):
        return "explained"
    if pattern and left**2 > _MOST * raw**2 and not named.late.any():
        return "unexplained"
    return "partly-explained"


def joined(one: str, other: str, found: bool) -> str:
    """The verdict of durations and logs together."""
    judged = {one, other} - {"not-judged"}
    if not judged:
        return "not-judged"
    if found:
        return "explained" if judged <= {"explained", "no-mismatch"} else "partly-explained"
    return "unexplained" if "unexplained" in judged else "no-mismatch"


def _rough(named: NamingResult) -> bool:
    """Whether simulation and robot differ by a share of the durations that no scatter is."""
    return float(np.mean(np.abs(named.clean.residual) / np.maximum(named.clean.measured, 1e-6))) > _ROUGH
