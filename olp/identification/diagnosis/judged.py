"""What a diagnosis judges: the recording's simulation, else what `olp time` says of its moves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from olp.identification.diagnosis.case_making import JudgedTimes, Making, case_beside
from olp.identification.recorded_plan import unlearnt_times

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording


def case_of(recording: Recording) -> Making:
    """All measured moves whose simulated duration is known or can be predicted. Raises OlpError N010."""
    notes = list[str]()
    return case_beside(recording, _judged(recording, notes), notes)


def _judged(recording: Recording, notes: list[str]) -> JudgedTimes:
    moves = recording.moves
    if np.isfinite(moves.sim).any():
        return JudgedTimes(moves.sim, np.zeros(len(moves)), own=False)
    own = unlearnt_times(recording)
    notes.append("no sim_s: olp's own prediction is judged, which `olp time` gives, too")
    notes.extend(f"olp's own prediction: {says}" for says in own.assumptions)
    return JudgedTimes(own.duration, own.stop, own=True)
