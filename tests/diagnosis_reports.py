"""A case and a diagnosis of the UP20 samples made by hand, least squares on columns that are easy to check."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from olp.identification.diagnosis.result import (
    Alternative,
    Correlate,
    Diagnosis,
    Errors,
    Evidence,
    Finding,
    FittedParameter,
    Mismatch,
    MoveResidual,
    NextExperiment,
    NextMove,
    Remainder,
)
from olp.identification.recording import Recording, read_recording
from olp.timing.physics._case import MeasuredMoves
from olp.timing.physics._motion import Motion

UP20 = Path(__file__).parent.parent / "samples" / "up20"
NOISE = 0.004  # [s]


def up20() -> Recording:
    return read_recording(UP20)


def case_of(recording: Recording) -> MeasuredMoves:
    """Every move of the recording, from exact stop to exact stop."""
    moves = recording.moves
    n = len(moves)
    ones, zeros, unknown = np.ones(n), np.zeros(n), np.full(n, math.nan)
    base = Motion(
        way=np.linalg.norm(moves.end - moves.start, axis=1),
        speed=moves.speed,
        accelerate=moves.acceleration,
        decelerate=moves.acceleration,
        jerk=np.full(n, math.inf),
        round_start=np.zeros_like(ones),
        round_end=np.zeros_like(ones),
        least=zeros,
        added=zeros,
        rate=ones,
    )
    yes, no = np.ones(n, dtype=bool), np.zeros(n, dtype=bool)
    return MeasuredMoves(
        move=moves.move,
        measured=moves.duration,
        simulated=moves.sim,
        base=base,
        moving=yes,
        joint=no,
        start=moves.start,
        end=moves.end,
        turn=zeros,
        stop_start=yes,
        stop_end=yes,
        blend=zeros,
        blend_start=zeros,
        corner=unknown,
        payload=unknown,
        payload_inertia=unknown,
        t_start=moves.t_start,
        cycle=moves.cycle,
        job=moves.job,
        line=moves.line,
    )


def diagnosis_of(case: MeasuredMoves) -> Diagnosis:
    """Three causes by least squares: reach at the start, the incline, and a constant per stop."""
    residual = case.residual
    reach = np.hypot(case.start[:, 0], case.start[:, 1]) ** 2
    columns = np.column_stack([reach - reach.mean(), case.rise, np.ones(len(case))])
    sizes = np.linalg.lstsq(columns, residual, rcond=None)[0]
    parts = columns * sizes
    rest = residual - parts.sum(axis=1)
    names = ("reach-inertia", "gravity", "settling")
    findings = tuple(
        _finding(name, float(size), case, parts[:, i], residual - parts.sum(axis=1) + parts[:, i], rest)
        for i, (name, size) in enumerate(zip(names, sizes.tolist(), strict=True))
    )
    told = tuple(
        MoveResidual(m, job or None, line or None, "accelerate", r, abs(r) > 3 * NOISE)
        for m, job, line, r in zip(
            case.move.tolist(), case.job, case.line.tolist(), residual.tolist(), strict=True
        )
    )
    before, after = _errors(residual, case), _errors(rest, case)
    return Diagnosis(
        verdict="partly-explained",
        moves=len(case),
        held_out_by="start",
        noise_floor=NOISE,
        mismatch=Mismatch(float(residual.mean()), before, told),
        findings=findings,
        indistinguishable=(("settling", "dispatch"),),
        next_experiment=NextExperiment(
            "The same way in one move and in four tells a time per stop from a time per move.",
            (NextMove((1.35, 0.7, 0.1), (0.71, 0.7, 0.1), 0.3, None, 0.0, 5, "one move"),) * 2,
        ),
        remainder=Remainder(_rms(rest), (Correlate("angle_deg", 0.41, 3e-5),)),
        before=before,
        heldout_before=before,
        heldout_after=Errors(after.rmse * 1.1, after.mape * 1.1, after.worst * 1.1),
        placebo=0.02,
        notes=("no payload is written: taken as equal in all moves",),
        unpaired=("move 7: the program has no such line",),
    )


def _finding(
    name: str, size: float, case: MeasuredMoves, part: np.ndarray, others: np.ndarray, rest: np.ndarray
) -> Finding:
    acts = tuple(case.move[np.abs(part) > 2 * NOISE].tolist())
    return Finding(
        term=name,
        says=f"changes the time of a move by {size:.3g} s per unit",
        equation=r"T = L/v + \frac{v}{a_{max}}\,(1 + k r^2)",
        parameters={"size": FittedParameter(size, "s", size * 0.9, size * 1.1, name == "settling")},
        moves=acts,
        contribution=dict(zip(case.move.tolist(), part.tolist(), strict=True)),
        evidence=Evidence(41.3, 2e-4, _rms(others) * 1.1, _rms(rest) * 1.1),
        alternatives=(Alternative("dispatch", 0.3),) if name == "settling" else (),
    )


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _errors(residual: np.ndarray, case: MeasuredMoves) -> Errors:
    share = np.abs(residual) / case.measured * 100
    return Errors(_rms(residual), float(share.mean()), float(share.max()))
