"""Programmed accelerations in the target's units: shares of the rated one, or values."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from olp.core.units import percent
from olp.ir.expressions import Number, Quantity
from olp.ir.program import Acceleration, AccelerationUnit, Move, Path, Program
from olp.ir.transformer import edited
from olp.languages.limits import Range, range_text, within
from olp.transpile.context import Fate, Loss, TranslationContext

_UNITS: Final = {AccelerationUnit.TRAVEL: "m/s²", AccelerationUnit.AXIS: "rad/s²"}
_SAME: Final = 1e-6  # relative: below this two shares are one


def accelerations(program: Program, work: TranslationContext) -> Program:
    """Every move's accelerations as the target says them; what it cannot say is left out, with a loss."""
    says = work.limits.unprogrammed_acceleration
    joints = AccelerationUnit.AXIS in work.limits.accelerations
    if says and any(type(s) is Move and _is_free(s, joints) for s in program.statements()):
        work.notes.append(says)
    if not any(
        type(s) is Move and not (s.acceleration is None and s.deceleration is None and s.rate is None)
        for s in program.statements()
    ):
        return program
    own = _Accelerations(work)
    routines = tuple(
        replace(r, body=tuple([own.move(s) if type(s) is Move else s for s in r.body]))
        for r in program.routines
    )
    return replace(program, routines=routines)


@dataclass(slots=True)
class _Accelerations:
    """`known`: by the ids of a move's accelerations, that move, what became of them, and what is lost of it."""

    work: TranslationContext
    known: dict[tuple[object, ...], tuple[Move, dict[str, Any], list[Loss]]] = field(default_factory=dict)

    def move(self, s: Move) -> Move:
        """Moves share what modal statements set: what becomes of it does not depend on the move."""
        if s.acceleration is None and s.deceleration is None and s.rate is None:
            return s
        key = (s.path, id(s.acceleration), id(s.deceleration), id(s.rate))
        known = self.known.get(key)
        if known is None:
            losses = len(self.work.losses)
            made = _rounded(_within(_converted(s, self.work), self.work), self.work)
            changes = {name: getattr(made, name) for name in ("acceleration", "deceleration", "rate")}
            self.known[key] = (s, changes, self.work.losses[losses:])
            return made
        for loss in known[2]:
            self.work.lose(s, loss.fate, loss.part, loss.says, loss.size, loss.unit)
        return edited(s, known[1])


def _is_free(s: Move, joints: bool) -> bool:
    return (joints or s.path is not Path.JOINT) and s.acceleration is None and s.rate is None


def _within(s: Move, work: TranslationContext) -> Move:
    """The nearest accelerations that the target takes."""
    changes: dict[str, object] = {}
    for name in ("acceleration", "deceleration"):
        share: Quantity | None = getattr(s, name)
        near = None if share is None else _near(s, work, share, work.limits.acceleration_range, percent, "%")
        if near is not None:
            changes[name] = near
    largest = None if s.rate is None else work.limits.largest_rates.get(s.rate.unit)
    if s.rate is not None and largest is not None:
        near = _near(s, work, s.rate.value, (0.0, largest), 1.0, _UNITS[s.rate.unit])
        if near is not None:
            changes["rate"] = s.rate._replace(value=near)
    return edited(s, changes) if changes else s


def _near(
    s: Move, work: TranslationContext, value: Quantity, bounds: Range, scale: float, unit: str
) -> Quantity | None:
    """The nearest number within bounds, told with how far off it is; None where the value itself is within."""
    literal = value.literal
    near = literal if literal is None else within(literal, bounds)
    if literal is None or near is None or near == literal:
        return None
    off = abs(near - literal) / scale
    work.lose(s, Fate.APPROXIMATED, "acceleration", range_text(bounds, scale, unit), off, unit)
    return Quantity(Number(_clean(near / scale)), scale)


def _rounded(s: Move, work: TranslationContext) -> Move:
    """As many decimals as the target writes."""
    step, share = work.limits.acceleration_step, s.acceleration
    value = None if share is None or not step else share.literal
    if value is None:
        return s
    rounded = max(1, round(value / step)) * step
    if abs(rounded - value) > _SAME * value:
        says = f"rounded to {step / percent:g} %"
        work.lose(s, Fate.APPROXIMATED, "acceleration", says, abs(rounded - value) / percent, "%")
    return edited(s, {"acceleration": Quantity(Number(_clean(rounded / percent)), percent)})


def _converted(s: Move, work: TranslationContext) -> Move:
    allowed = work.limits.accelerations
    rated = _rated(s, work)
    if s.rate is not None and s.rate.unit not in allowed:
        value = s.rate.value.literal
        s = edited(s, {"rate": None})
        if AccelerationUnit.FRACTION in allowed and rated and value is not None:
            return _bounded(
                edited(s, {"acceleration": Quantity(Number(_clean(100 * value / rated)), percent)}), work
            )
        says = "the acceleration is left out: what share of the rated one it is, is not known"
        work.lose(s, Fate.APPROXIMATED, "acceleration", says)
        return s
    if AccelerationUnit.FRACTION in allowed:
        return _one_share(s, work)
    return _as_rate(s, work, rated)


def _one_share(s: Move, work: TranslationContext) -> Move:
    """Braking and speeding up are one share where the target cannot tell them apart."""
    if s.deceleration is None or work.limits.separate_deceleration:
        return s
    if s.acceleration is not None and s.acceleration.literal != s.deceleration.literal:
        work.lose(
            s,
            Fate.APPROXIMATED,
            "acceleration",
            "one share for speeding up and braking: the first is written",
        )
    return replace(s, acceleration=s.acceleration or s.deceleration, deceleration=None)


def _as_rate(s: Move, work: TranslationContext, rated: float | None) -> Move:
    share = s.acceleration or s.deceleration
    if share is None:
        return s
    s = edited(s, {"acceleration": None, "deceleration": None})
    unit = AccelerationUnit.AXIS if s.path is Path.JOINT else AccelerationUnit.TRAVEL
    if share is None or s.rate is not None:
        return s
    value = share.literal
    if value is None or rated is None or unit not in work.limits.accelerations:
        work.lose(s, Fate.APPROXIMATED, "acceleration", "the share of the rated acceleration is left out")
        return s
    return edited(s, {"rate": Acceleration(unit, Quantity(Number(_clean(value * rated)), 1.0))})


def _bounded(s: Move, work: TranslationContext) -> Move:
    assert s.acceleration is not None
    value = s.acceleration.literal
    if value is not None and value > 1.0:
        says = "more than the rated acceleration: 100 % is written"
        work.lose(s, Fate.APPROXIMATED, "acceleration", says, 100 * (value - 1.0), "%")
        return replace(s, acceleration=Quantity(Number(100), percent))
    return s


def _rated(s: Move, work: TranslationContext) -> float | None:
    """[m/s²] or, of a joint move, [rad/s²]: the rated acceleration; None where no robot says it."""
    robot = work.target_robot
    if robot is None:
        return None
    if s.path is not Path.JOINT:
        return robot.linear_acceleration
    known = robot.accelerations[~np.isnan(robot.accelerations)]
    return float(known.min()) if len(known) else None


def _clean(value: float) -> float:
    return float(f"{value:.9g}")
