"""A recording that has logs and no moves: the diagnosis is what the logs tell."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from olp.diagnosis.result import Diagnosis, Errors, Mismatch, NextExperiment, Remainder
from olp.physics._case import Case
from olp.physics._motion import Motion

if TYPE_CHECKING:
    from olp.diagnosis.logs import LogDiagnosis

_NOTE = "no moves were recorded: durations are not judged, only the logs"


def diagnosis_of_logs(log: LogDiagnosis, unpaired: tuple[str, ...]) -> Diagnosis:
    """The whole answer from logs. `unpaired`: what could not be paired, in words."""
    return Diagnosis(
        verdict=log.verdict,
        moves=0,
        held_out_by="blocks of the log",
        noise_floor=math.nan,
        mismatch=Mismatch(math.nan, Errors(math.nan, math.nan, math.nan), ()),
        findings=log.findings,
        indistinguishable=log.indistinguishable,
        next_experiment=NextExperiment(log.next_experiment),
        remainder=Remainder(math.nan),
        notes=(_NOTE, *log.notes),
        unpaired=unpaired,
        log=log.to_json(),
    )


def no_case() -> Case:
    """The case of no moves at all."""
    one, three = np.zeros(0), np.zeros((0, 3))
    number, mask = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.bool_)
    motion = Motion(one, one, one, one, one, one, one, one, one, one)
    return Case(
        *(number, one, one, motion, mask, mask, three, three, one, mask, mask),
        *(one, one, one, one, one, one, number, (), number),
    )
