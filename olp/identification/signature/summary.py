"""A signature in words."""

from __future__ import annotations

from typing import Any

import numpy as np

from olp.core.units import deg, mm
from olp.identification.signature.coefficients import LearntParameter
from olp.identification.signature.document import Signature
from olp.identification.signature.folds import merit
from olp.identification.signature.joint_moves import LearntArm

_FEW = 12  # names that are listed


def summary(signature: Signature) -> list[str]:
    """What it is and how well it did, in a few lines."""
    learnt = signature.recording
    lines = [
        f"signature of {signature.robot or 'a robot that is not named'}"
        + (f", {signature.controller}" if signature.controller else ""),
        f"learnt from {learnt.moves} moves of {learnt.name} (sha256 {learnt.sha256[:12]}…)",
        f"method {signature.method}",
    ]
    if signature.compared:
        lines.append("held out inside the recording, mean error in %:   moves  start points  directions")
        ranked = sorted(signature.compared.items(), key=lambda item: merit(item[1]))
        lines += [
            f"  {name:<44}  {_two(s.moves)}  {_two(s.starts):>12}  {_two(s.directions):>10}"
            for name, s in ranked
        ]
    if signature.arm is not None:
        lines += _arm_summary(signature.arm)
    return lines


def _arm_summary(arm: LearntArm) -> list[str]:
    lines = [f"{arm.rows} joint moves, held out, mean error in %:"]
    lines += [f"  {name:<44}  {_two(error)}" for name, error in arm.held_out.items()]
    if arm.untold:
        lines.append(f"  not determined by these moves, prior values kept: {', '.join(arm.untold)}")
    return lines


def describe(signature: Signature) -> list[str]:
    """Everything but the long tables."""
    domain, errors = signature.domain, signature.errors
    lines = summary(signature)
    lines.append("domain")
    lines.append(f"  speed {_range(domain.speed, mm)} mm/s, length {_range(domain.length, mm)} mm")
    if domain.payload is not None:
        lines.append(f"  payload {_range(domain.payload, 1.0)} kg")
    if signature.tool is not None:
        place = ", ".join(f"{v / mm:g}" for v in signature.tool[:3])
        turn = ", ".join(f"{v / deg:g}" for v in signature.tool[3:])
        lines.append(f"  tool {place} mm, {turn} deg")
    top = domain.speed[1]
    lines.append(f"95 % of the held-out moves were within (at {top / mm:g} mm/s)")
    lines.append(
        f"  {errors.near.half * top:.3f} s among learnt moves, {errors.far.half * top:.3f} s from a new start point"
    )
    lines.append("parameters")
    lines += [_line(name, parameter) for name, parameter in signature.parameters.items()]
    if signature.arm is not None:
        lines.append(f"joint moves: 95 % within {signature.arm.quantile:.2g} spreads")
        lines += [
            f"  {p.name}: {p.value:.4g} {'' if p.unit == '1' else p.unit} ± "
            f"{(p.value if p.logarithmic else 1.0) * p.sd:.2g} ({p.source})"
            for p in signature.arm.timing.parameters
            if not p.name.startswith("posture")
        ]
    for kind, part in signature.parts.items():
        law = f", law {part.law}" if part.law else ""
        lines.append(
            f"{kind}: learnt from {part.rows}{law}, held out {part.unlearnt:.2f} % without, {part.learnt:.2f} % with it"
        )
        lines += [_line(name, quantity) for name, quantity in part.quantities.items()]
        lines.append(f"  95 % within {part.spread.half:.3f} s")
    return lines


def _two(value: float) -> str:
    return "    -" if np.isnan(value) else f"{value:5.2f}"


def _range(pair: tuple[float, float], factor: float) -> str:
    low, high = pair[0] / factor, pair[1] / factor
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _line(name: str, parameter: LearntParameter) -> str:
    unit = "" if parameter.value is None or parameter.unit in ("", "1") else f" {parameter.unit}"
    return f"  {name}: {_short(parameter.value)}{unit}{_doubt(parameter.sd)}"


def _short(value: Any) -> str:
    if value is None:
        return "not learnt"
    if isinstance(value, list):
        names = all(isinstance(v, str) for v in value)
        if names and len(value) <= _FEW:
            return ", ".join(str(v) or "-" for v in value)
        return f"{len(value)} entries" if len(value) != 1 else "1 entry"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _doubt(sd: Any) -> str:
    return f" ± {sd:.3g}" if isinstance(sd, float) else ""
