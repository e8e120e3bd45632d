"""A diagnosis as a signature: the terms it named, what they were added to, and how wrong that was on unseen moves.

Codes: H040 a diagnosis with nothing to apply, H041 what of a diagnosis predictions leave out or take for granted.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error, info, warning
from olp.core.version import __version__
from olp.identification.diagnosis.intervals import parameters_with_intervals
from olp.identification.diagnosis.model import DurationModel
from olp.identification.recorded_plan import case_of
from olp.identification.signature.coefficients import TERMS, CorrectionPart, half_of_few
from olp.identification.signature.document import Learnt, Signature
from olp.identification.signature.domain import domain_of
from olp.identification.signature.errors import ErrorModel, spread_of
from olp.identification.signature.term_model import (
    NamedModel,
    case_for,
    moves_of_case,
    rated_speed,
    to_parameters,
)

if TYPE_CHECKING:
    from olp.identification.diagnosis.diagnose import DiagnosisOutcome
    from olp.identification.diagnosis.naming import NamingResult as Search
    from olp.identification.recording.recording import Recording
    from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]

METHOD = "named_terms"  # the file in estimators/
_NORMAL = 1.96
_VARIED = 0.01  # [1] accelerations of the simulation that differ by more are worth a word
_OFF = 0.002  # [s] by which the simulation may differ from its own constant acceleration without a word
_LEFT_OUT = {
    "clock": "the recorder's clock is at fault, not the robot: predictions are in seconds of the simulation",
    "external-wait": "waits for reasons outside the arm are not predicted",
}
_IN_LOGS = "only the log shows it: it is not in predictions"


def signature_of_recording(recording: Recording) -> tuple[Signature, tuple[Diagnostic, ...]]:
    """Diagnoses, and makes a signature of what was found. Raises OlpError: H040, N010."""
    from olp.identification.diagnosis.diagnose import diagnose_recording

    return signature_of(diagnose_recording(recording), recording)


def signature_of(outcome: DiagnosisOutcome, recording: Recording) -> tuple[Signature, tuple[Diagnostic, ...]]:
    """The signature of a diagnosis of `recording`, and what it leaves out. Raises OlpError H040."""
    rows, search = case_of(recording).rows, outcome.named
    assert search is not None
    named = _named(outcome, _ramp(outcome.case, recording, rows), recording.path)
    made = case_for(named, recording)
    moves = None if made is None else moves_of_case(made[0], recording, made[1])
    if made is None or moves is None or not len(moves):
        says = "without the robot, targets and axis speeds of its joint moves are not known"
        raise OlpError(error("H040", says, file=recording.path, help="name the robot in recording.toml"))
    own = np.full(int(max(rows.max(), made[1].max())) + 1, np.nan)
    own[made[1]] = made[0].simulated
    off = own[rows] - outcome.case.simulated
    use = outcome.case.moving & np.isfinite(off)
    errors = _held_out(search, off)
    judged = use[~search.late]
    part = _part(search, errors, judged, named.law)
    settings = recording.settings
    slowness = spread_of(errors[judged] / np.median(moves.speed), search.folds.labels[judged])
    signature = Signature(
        robot=recording.robot.name if recording.robot else "",
        controller=settings.controller or "",
        tool=None if recording.tool is None else tuple(float(v) for v in recording.tool.xyz_angles()),
        payload=named.payload if math.isfinite(named.payload) else None,
        recording=Learnt(recording.path, recording.sha256, part.rows, settings.time_resolution),
        method=METHOD,
        parameters=to_parameters(named, _deviations(search)),
        errors=ErrorModel(slowness, slowness),
        domain=domain_of(moves),
        compared={},
        olp=__version__,
        parts={TERMS: part},
    )
    return signature, tuple(_told(outcome, named, off[use], recording.path))


def _named(outcome: DiagnosisOutcome, ramp: float, file: str) -> NamedModel:
    """The terms that can be applied to other moves. Raises OlpError H040."""
    found = outcome.diagnosis
    if found.verdict in ("no-mismatch", "unexplained", "not-judged"):
        why = {
            "no-mismatch": "the simulation agrees with the robot: there is nothing to add",
            "not-judged": "there was nothing to compare, or too little",
            "unexplained": "no term explains the difference on moves that were not fitted",
        }[found.verdict]
        says = f"{why} (verdict {found.verdict})"
        help = "olp calibrate learns durations without naming their cause"
        raise OlpError(error("H040", says, file=file, help=help))
    parts = tuple(part for part in outcome.model.parts if part.term.name not in _LEFT_OUT)
    if not parts:
        names = ", ".join(finding.term for finding in found.findings)
        says = f"the findings cannot be used in predictions: {names}"
        raise OlpError(error("H040", says, file=file, help="a signature needs terms of motion"))
    case, model = outcome.case, DurationModel(parts)
    model.seconds(case)  # asks for the numbers that the forms refer to
    base = case.base
    inertia, payload = (v[np.isfinite(v)] for v in (case.payload_inertia, case.payload))
    return NamedModel(
        model,
        _middle(_paths(case)),
        ramp,
        base.law,
        base.overlap,
        base.split,
        _middle(payload),
        _middle(inertia),
        case.numbers_used,
    )


def _ramp(case: MeasuredMoves, recording: Recording, rows: NDArray[np.int64]) -> float:
    """[s] that every axis takes to its rated speed in the simulation's joint moves.

    0 where the accelerations of the robot's file come nearer to the simulation; nan where nothing can be told.
    """
    joint = np.nonzero(case.moving & case.joint)[0]
    if recording.robot is None or not len(
        joint
    ):  # without a robot the speeds of axes are known of these moves alone
        return math.nan
    base, simulated = case.base.take(joint), case.simulated[joint]
    rated = rated_speed(case, recording, rows)[joint]
    cruise = base.way / base.speed
    over = simulated - cruise
    good = (case.stop_start & case.stop_end)[joint] & (over > 0)
    if not good.any():
        return 0.0
    with np.errstate(divide="ignore"):
        ramps = rated / np.where(over <= cruise, base.speed / over, 4.0 * base.way / simulated**2)
    ramp = float(np.median(ramps[good]))
    slow = rated / ramp
    own, other = (
        float(np.mean((motion.duration() - simulated) ** 2))
        for motion in (base.with_(accelerate=slow, decelerate=slow), base)
    )
    known = np.isfinite(recording.robot.accelerations).all()
    return 0.0 if known and other <= own else ramp


def _paths(case: MeasuredMoves) -> Floats:
    """[m/s²] of the simulation's paths."""
    return np.asarray(case.base.accelerate[case.moving & ~case.joint])


def _middle(values: Floats) -> float:
    return float(np.median(values)) if len(values) else math.nan


def _deviations(search: Search) -> dict[tuple[str, str], float]:
    """Standard deviations by the labels of part and parameter, of those that the data hold."""
    told = parameters_with_intervals(search.fit, search.clean, search.noise)
    return {
        (part.label, name): (p.high - p.low) / (2 * _NORMAL)
        for part, own in zip(search.fit.model.parts, told, strict=True)
        for name, p in own.items()
        if p.identified and not p.at_bound and math.isfinite(p.high - p.low)
    }


def _held_out(search: Search, off: Floats) -> Floats:
    """(m,) [s] errors of moves that neither search nor fit saw, nan where nothing is predicted.

    `off` (n,) [s]: constant acceleration less the simulation. The diagnosis adds the terms to what the simulation said,
    the signature to constant acceleration: errors are those of the signature.
    """
    return np.asarray(search.clean.measured - search.selection.predicted - off[~search.late])


def _part(search: Search, errors: Floats, judged: NDArray[np.bool_], law: str) -> CorrectionPart:
    """`judged` (m,): moves that go somewhere and are predicted."""
    spread = spread_of(errors[judged], search.folds.labels[judged])
    measured, before = search.clean.measured[judged], search.clean.residual[judged]
    half = max(spread.half, half_of_few(errors[judged]))
    share = [100.0 * float(np.mean(np.abs(e) / measured)) for e in (before, errors[judged])]
    rows, longest = int(judged.sum()), float(measured.max())
    return CorrectionPart({}, spread._replace(half=half), half, rows, longest, share[0], share[1], law)


def _told(outcome: DiagnosisOutcome, named: NamedModel, off: Floats, file: str) -> list[Diagnostic]:
    found = []
    kept = {part.term.name for part in named.model.parts}
    for finding in outcome.diagnosis.findings:
        if finding.term not in kept:
            why = _LEFT_OUT.get(finding.term, _IN_LOGS)
            found.append(warning("H041", f"{finding.term}: {why}", file=file))
    for name in sorted({part.term.name for part in named.model.parts if part.term.by_time}):
        found.append(info("H041", f"{name}: predictions are those of a warm robot", file=file))
    for group in outcome.diagnosis.indistinguishable:
        one = [name for name in group if name in kept]
        if one:
            says = f"{', '.join(group)} explain these moves equally: {one[0]} is used; other moves may show another"
            found.append(
                warning("H041", says, file=file, help="olp diagnose --next writes moves that separate them")
            )
    paths = _paths(outcome.case)
    if len(paths) and np.ptp(paths) > _VARIED * named.linear:
        says = f"the simulation's accelerations differ: paths without one take {named.linear:.4g} m/s²"
        found.append(info("H041", says, file=file))
    rms = float(np.sqrt(np.mean(off**2)))
    if rms > _OFF:
        says = (
            f"predictions start from constant acceleration, {rms:.3f} s (root mean square) off the simulation"
        )
        found.append(info("H041", says, file=file))
    return found
