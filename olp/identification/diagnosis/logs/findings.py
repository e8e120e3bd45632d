"""From what axes told to sentences: one finding per term, its numbers per axis."""

from __future__ import annotations

import importlib
import math
from typing import NamedTuple

from olp.identification.diagnosis.logs.result import AxisEvidence
from olp.identification.diagnosis.result import Alternative, Evidence, Finding, FittedParameter

_ORDER = (
    *(
        "clock",
        "servo-lag",
        "joint-compliance",
        "backlash",
        "viscous-friction",
        "coulomb-friction",
        "payload",
    ),
)


class ConfirmedTerm(NamedTuple):
    """One term of one axis (from 1; 0: all), confirmed. `numbers`: name -> parameter."""

    evidence: AxisEvidence
    numbers: dict[str, FittedParameter]
    moves: tuple[int, ...] = ()


def findings(named: list[ConfirmedTerm], rivals: dict[str, tuple[Alternative, ...]]) -> tuple[Finding, ...]:
    """One per term, the terms that explain most first within their kind; clocks before physics."""
    found = []
    for term in _ORDER:
        own = [n for n in named if n.evidence.term == term]
        if own:
            found.append(_finding(term, own, rivals.get(term, ())))
    return tuple(found)


def _finding(term: str, own: list[ConfirmedTerm], rivals: tuple[Alternative, ...]) -> Finding:
    numbers: dict[str, FittedParameter] = {}
    for n in own:
        axis = n.evidence.axis
        numbers |= {
            name if axis == 0 else f"{name} of axis {axis}": value for name, value in n.numbers.items()
        }
    moves = tuple(sorted({m for n in own for m in n.moves}))
    delta = sum(n.evidence.delta_bic for n in own if math.isfinite(n.evidence.delta_bic))
    evidence = Evidence(delta, min(n.evidence.p_value for n in own), math.nan, math.nan)
    return Finding(term, says(term, own), equation_of(term), numbers, moves, {}, evidence, rivals)


def equation_of(term: str) -> str:
    """LaTeX, from the term's file."""
    module = importlib.import_module(f"olp.timing.physics.{term.replace('-', '_')}")
    classes = [c for c in vars(module).values() if isinstance(c, type) and c.__module__ == module.__name__]
    return next(
        (str(c.equation) for c in classes if hasattr(c, "equation")), r"\tau = m\,J^{\mathsf T}(\ddot x - g)"
    )


def says(term: str, own: list[ConfirmedTerm]) -> str:
    """One sentence with the numbers."""
    parts = []
    for n in own:
        axis = n.evidence.axis
        values = dict(n.numbers)
        parts.append(_clause(term, axis, values))
    start = _TWISTED if all("stiffness" in n.numbers for n in own) else _START[term]
    return start + "; ".join(parts)


_TWISTED = "axes give way to their torques: "
_START = {
    "clock": "the recorder's clock: ",
    "servo-lag": "axes follow late by a time constant: ",
    "joint-compliance": "axes oscillate after acceleration changes: ",
    "backlash": "a dead band at reversals: ",
    "viscous-friction": "torque against motion in proportion to speed: ",
    "coulomb-friction": "torque against motion at any speed: ",
    "payload": "more mass is carried: ",
}


def _clause(term: str, axis: int, values: dict[str, FittedParameter]) -> str:
    where = f"axis {axis} " if axis else ""
    if term == "clock":
        texts = []
        for name, p in values.items():
            if p.unit == "s":
                texts.append(f"{name} {p.value * 1000:.4g} ms ({p.low * 1000:.4g} to {p.high * 1000:.4g})")
            else:
                texts.append(f"{name} {p.value:.6f} ({p.low:.6f} to {p.high:.6f})")
        return ", ".join(texts)
    if term == "servo-lag":
        return where + f"{next(iter(values.values())).value * 1000:.3g} ms"
    if term == "joint-compliance" and "frequency" in values:
        return where + f"{values['frequency'].value:.3g} Hz, damping {values['damping'].value:.2g}"
    if term == "backlash":
        p = next(iter(values.values()))
        return where + (f"{math.degrees(p.value):.2g}°" if p.unit == "rad" else f"{p.value * 1000:.3g} mm")
    p = next(iter(values.values()))
    return where + f"{p.value:.3g} {p.unit}"
