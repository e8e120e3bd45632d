"""`cycle-quantisation`: durations are whole multiples of the controller's cycle."""

from __future__ import annotations

import numpy as np

from olp.physics._case import Case, Floats
from olp.physics._motion import Motion
from olp.physics.term import Form, MoveTerm, Parameter, Stage

_SHORTEST, _LONGEST = 2e-3, 0.25  # [s]
_FEWEST = 12
_SHORT = 120  # moves that are looked at
_SURE = 0.35  # of the coherence: durations that are multiples have 1, any others about 1/√n


class CycleQuantisation(MoveTerm):
    summary = "durations are whole multiples of the controller's cycle"
    does = "durations fall on a lattice; what is missing is spread evenly between nothing and one cycle"
    source = "interpolation cycle of controllers (4, 8, 12 ms); lattice found by the coherence |Σ exp(2πi T/c)| / n"
    confusable = ("dispatch", "settling")
    stage = Stage.CLOCKS

    def forms(self, case: Case) -> tuple[Form, ...]:
        found = _found(case)
        if not np.isfinite(found):
            return ()
        one = Parameter("cycle", "s", found * 0.999, found * 1.001, 0.0, False, "of the controller")
        up = Form("", (one,), r"T = c \lceil T_0 / c \rceil")
        return (up, Form("nearest", (one,), r"T = c \lfloor T_0 / c + 1/2 \rfloor"))

    def guesses(self, form: Form, case: Case) -> Floats:
        return np.array([[_found(case)]])

    def act(self, motion: Motion, form: Form, values: Floats, case: Case) -> Motion:
        return motion.with_(cycle=float(values[0]), early=0.5 if form.key == "nearest" else 0.0)

    def says(self, form: Form, values: Floats, case: Case) -> str:
        return f"durations are whole multiples of {values[0] * 1000:.3g} ms"


def _found(case: Case) -> float:
    return float(case.once("lattice", lambda: np.array([_lattice(case)]))[0])


def _lattice(case: Case) -> float:
    """[s] the longest cycle that the durations are multiples of; nan when none stands out of the clock's own digits."""
    # Short durations have few multiples to choose from: they tell the lattice with the fewest frequencies to try.
    times = np.sort(case.measured[case.moving])[:_SHORT]
    shortest = max(_SHORTEST, 2.5 * case.resolution)
    if len(times) < _FEWEST or shortest > _LONGEST:
        return float("nan")
    # Frequencies so fine that the longest duration is no more than a sixth of a turn off between two of them.
    step = 0.33 / max(float(times.max()), 1e-3)
    frequency = np.arange(1.0 / _LONGEST, 1.0 / shortest, step)
    strong = _coherence(times, frequency)
    needed = max(_SURE, float(np.sqrt((np.log(len(frequency)) + 7.0) / len(times))))
    if not (strong > needed).any():
        return float("nan")
    best = frequency[np.argmax(strong)]
    # A lattice of c is also one of c/2, c/3, …: take the longest that is as good.
    for part in range(8, 1, -1):
        near = np.linspace(best / part - step, best / part + step, 41)
        if near[0] > 1.0 / _LONGEST and _coherence(times, near).max() > 0.93 * strong.max():
            best = near[np.argmax(_coherence(times, near))]
            break
    near = np.linspace(best - step, best + step, 401)
    return float(1.0 / near[np.argmax(_coherence(times, near))])


def _coherence(times: Floats, frequency: Floats) -> Floats:
    """(f,) [1]"""
    parts = [
        np.abs(np.exp(2j * np.pi * np.outer(chunk, times)).mean(axis=1))
        for chunk in np.array_split(frequency, max(1, len(frequency) * len(times) // 2_000_000))
    ]
    return np.concatenate(parts)
