"""A diagnosis as a signature: the terms it named, what they were added to, and how wrong that was on unseen moves.

Codes: H040 a diagnosis with nothing to apply, H041 what of a diagnosis predictions leave out or take for granted.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.diagnosis.case_making import case_of
from olp.diagnosis.intervals import parameters_with_intervals
from olp.diagnosis.model import Model
from olp.diagnostic import Diagnostic, OlpError, error, info, warning
from olp.signature.document import Learnt, Signature
from olp.signature.domain import domain_of
from olp.signature.errors import ErrorModel, Spread, spread_of
from olp.signature.named_case import case_for
from olp.signature.named_model import Named, to_parameters
from olp.signature.named_rows import moves_of_case
from olp.signature.parts import TERMS, Part, half_of_few
from olp.version import __version__

if TYPE_CHECKING:
    from olp.diagnosis.diagnose import Outcome
    from olp.diagnosis.naming import Named as Search
    from olp.physics._case import Case
    from olp.recording import Recording

Floats = NDArray[np.float64]

METHOD = "named_terms"  # the file in estimators/
_NORMAL = 1.96
_VARIED = 0.01  # [1] accelerations of the simulation that differ by more are worth a word
_OFF = 0.002  # [s] by which the simulation may differ from its own constant acceleration without a word
_LEFT_OUT = {
    "clock": "the recorder's clock is at fault, not the robot: predictions are in seconds of the simulation",
    "external-wait": "waits for reasons outside the arm are not predicted",
}
_IN_LOGS = "the log told it and durations do not: it is not in predictions"


def signature_of_recording(recording: Recording) -> tuple[Signature, tuple[Diagnostic, ...]]:
    """Diagnoses, and makes a signature of what was found. Raises OlpError: H040, N010."""
    from olp.diagnosis.diagnose import diagnose_recording

    return signature_of(diagnose_recording(recording), recording)


def signature_of(outcome: Outcome, recording: Recording) -> tuple[Signature, tuple[Diagnostic, ...]]:
    """The signature of a diagnosis of `recording`, and what it leaves out. Raises OlpError H040."""
    named, search = _named(outcome, recording), outcome.named
    assert search is not None
    rows = case_of(recording).rows
    made = case_for(named, recording)
    moves = None if made is None else moves_of_case(made[0], recording, made[1])
    if made is None or moves is None or not len(moves):
        says = "without the robot nothing tells where its joint moves lead, or how fast its axes are"
        raise OlpError(error("H040", says, file=recording.path, help="name the robot in recording.toml"))
    own = np.full(int(max(rows.max(), made[1].max())) + 1, np.nan)
    own[made[1]] = made[0].simulated
    errors, groups, off = _held_out(outcome.case, search, own[rows])
    settings = recording.settings
    spread = spread_of(errors, groups)
    pace = spread_of(errors / np.median(moves.speed), groups)
    signature = Signature(
        robot=recording.robot.name if recording.robot else "",
        controller=settings.controller or "",
        tool=None if recording.tool is None else tuple(float(v) for v in recording.tool.xyz_angles()),
        payload=named.payload if math.isfinite(named.payload) else None,
        recording=Learnt(recording.path, recording.sha256, len(errors), settings.time_resolution),
        method=METHOD,
        parameters=to_parameters(named, _deviations(search)),
        errors=ErrorModel(pace, pace),
        domain=domain_of(moves),
        compared={},
        olp=__version__,
        parts={TERMS: _part(search, errors, spread, named.law)},
    )
    return signature, tuple(_told(outcome, named, off, recording.path))


class _Accelerations(NamedTuple):
    """The middle of the simulation's accelerations, nan where no such move was judged, and whether they differ."""

    middle: float
    varied: bool


def _named(outcome: Outcome, recording: Recording) -> Named:
    """The terms that can be applied to other moves. Raises OlpError H040."""
    found = outcome.diagnosis
    if found.verdict in ("no-mismatch", "unexplained"):
        why = {
            "no-mismatch": "the simulation says what the robot does: there is nothing to add to it",
            "unexplained": "no term explains the difference on moves that were not fitted",
        }[found.verdict]
        says = f"{why} (verdict {found.verdict})"
        help = "olp calibrate learns durations without naming their cause"
        raise OlpError(error("H040", says, file=recording.path, help=help))
    parts = tuple(part for part in outcome.model.parts if part.term.name not in _LEFT_OUT)
    if not parts:
        names = ", ".join(finding.term for finding in found.findings)
        says = f"what was found cannot be put into predictions: {names}"
        raise OlpError(error("H040", says, file=recording.path, help="a signature needs terms of motion"))
    case, model = outcome.case, Model(parts)
    model.seconds(case)  # asks for the numbers that the forms refer to
    base = case.base
    inertia, payload = (v[np.isfinite(v)] for v in (case.payload_inertia, case.payload))
    return Named(
        model,
        _accelerations(case, False).middle,
        # Without a robot the axes' speeds are known of recorded moves alone.
        math.nan if recording.robot is None else _accelerations(case, True).middle,
        base.law,
        base.overlap,
        base.split,
        float(np.median(payload)) if len(payload) else math.nan,
        float(np.median(inertia)) if len(inertia) else math.nan,
        case.numbers_used,
    )


def _accelerations(case: Case, joint: bool) -> _Accelerations:
    own = case.base.accelerate[case.moving & (case.joint == joint)]
    if not len(own):
        return _Accelerations(math.nan, False)
    middle = float(np.median(own))
    return _Accelerations(middle, bool(np.ptp(own) > _VARIED * middle))


def _deviations(search: Search) -> dict[tuple[str, str], float]:
    """Standard deviations by the labels of part and parameter, of those that the data hold."""
    told = parameters_with_intervals(search.fit, search.clean, search.noise)
    return {
        (part.label, name): (p.high - p.low) / (2 * _NORMAL)
        for part, own in zip(search.fit.model.parts, told, strict=True)
        for name, p in own.items()
        if p.identified and not p.at_bound and math.isfinite(p.high - p.low)
    }


def _held_out(case: Case, search: Search, own: Floats) -> tuple[Floats, NDArray[np.int64], Floats]:
    """Errors [s] of moves that neither search nor fit saw, their groups, and [s] what olp's own base is off.

    `own` (n,) [s]: constant acceleration, nan where it says nothing. The signature adds the terms to that, the
    diagnosis to what the simulation said: errors are those of the signature.
    """
    off = own - case.simulated
    use = case.moving & np.isfinite(off)
    clean = ~search.late
    left = search.clean.measured - search.selection.predicted - off[clean]
    return left[use[clean]], search.folds.labels[use[clean]], off[use]


def _part(search: Search, errors: Floats, spread: Spread, law: str) -> Part:
    use = search.clean.moving
    measured, before = search.clean.measured[use], search.clean.residual[use]
    half = max(spread.half, half_of_few(errors))
    share = [100.0 * float(np.mean(np.abs(e) / measured)) for e in (before, errors)]
    longest = float(measured.max())
    return Part({}, spread._replace(half=half), half, len(errors), longest, share[0], share[1], law)


def _told(outcome: Outcome, named: Named, off: Floats, file: str) -> list[Diagnostic]:
    found = []
    kept = {part.term.name for part in named.model.parts}
    for finding in outcome.diagnosis.findings:
        if finding.term not in kept:
            why = _LEFT_OUT.get(finding.term, _IN_LOGS)
            found.append(warning("H041", f"{finding.term}: {why}", file=file))
    if "warm-up" in kept:
        found.append(info("H041", "warm-up: predictions are those of a warm robot", file=file))
    for group in outcome.diagnosis.indistinguishable:
        one = [name for name in group if name in kept]
        if one:
            says = f"{', '.join(group)} explain these moves alike: {one[0]} is applied, other moves may show the other"
            found.append(warning("H041", says, file=file, help="olp diagnose --next writes moves that tell"))
    for joint, unit in ((False, "m/s²"), (True, "rad/s²")):
        middle, varied = _accelerations(outcome.case, joint)
        if varied:
            says = (
                f"the simulation accelerates at various rates: moves that do not say take {middle:.4g} {unit}"
            )
            found.append(info("H041", says, file=file))
    rms = float(np.sqrt(np.mean(off**2)))
    if rms > _OFF:
        says = (
            f"predictions start from constant acceleration, {rms:.3f} s (root mean square) off the simulation"
        )
        found.append(info("H041", says, file=file))
    return found
