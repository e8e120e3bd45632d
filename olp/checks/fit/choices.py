"""What a person would change in a program to make it faster: the speed of a line, the zone of a corner.

A choice is a change of the text, so that the edited program is the written one, byte for byte, but for the lines of the
choices. Taught points are never changed, nor lines that say `olp: keep`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from olp.checks.edit import speeds
from olp.checks.lint.case import LintCase
from olp.checks.lint.rules.exact_stop import ExactStop
from olp.checks.lint.zones import larger
from olp.core.units import mm
from olp.ir.moves import Speed, SpeedUnit
from olp.ir.program import Program, like
from olp.languages.literals import Token, WrittenSpeed, language, replaced
from olp.languages.vendor import find_vendor
from olp.runtime.plan import BlendCode

if TYPE_CHECKING:
    from olp.timing.timing import Timing

KEPT = re.compile(r"\bolp:\s*keep\b", re.IGNORECASE)
# Of the speed that is written: steps that a person would take.
_FASTER = (1.2, 1.5, 2.0)
_UNITS = {SpeedUnit.FRACTION: (0.01, "%"), SpeedUnit.TRAVEL: (mm, "mm/s")}
_DIGITS = 2  # of a new speed: nobody writes 117.3


@dataclass(frozen=True, slots=True)
class Choice:
    """One edit. `line`: of the move that it is about; `place`: two choices of one place exclude each other.

    `says`: "118 → 150 mm/s". `effort` [1]: how far it goes, where two edits do equally. `texts`: numbers that change;
    `zone`: what the line becomes beside them, as the n-th larger zone.
    """

    kind: str
    line: int
    place: tuple[str, int]
    says: str
    effort: float
    texts: tuple[tuple[Token, str], ...] = ()
    zone: int = -1


@dataclass(frozen=True, slots=True)
class Allowed:
    """How far choices may go. `speed` [m/s] of the tool; None: the highest of the program's run. `within` [m]."""

    within: float = 0.0
    speed: float | None = None
    kept: frozenset[int] = frozenset()


def choices(program: Program, timing: Timing, allowed: Allowed) -> list[Choice]:
    """All edits that may be made, by place, the smaller ones first. Raises OlpError (O001) for other languages."""
    kept = allowed.kept | _kept(program)
    steps = {
        int(line) for line, source in zip(timing.plan.line, timing.plan.source, strict=True) if source == 0
    }
    found = list(_speeds(program, top_speed(program, timing, allowed), kept, steps))
    if allowed.within > 0.0:
        found += _zones(program, timing, kept)
    return found


def _kept(program: Program) -> frozenset[int]:
    """Lines that say so themselves, and those below a comment that does."""
    found: set[int] = set()
    prefix = find_vendor(program.vendor).comment_prefix.strip()
    for number, text in enumerate(program.source.lines, 1):
        if KEPT.search(text):
            found.add(number)
            if prefix and text.strip().lstrip("0123456789: ").startswith(prefix.lstrip(": ")):
                found.add(number + 1)
    return frozenset(found)


def top_speed(program: Program, timing: Timing, allowed: Allowed) -> float:
    """[m/s] that a line may get: what is allowed, else the highest that is written or that a move of the run has."""
    if allowed.speed is not None:
        return allowed.speed
    written = [_si(one.speed) for one in speeds(program) if one.speed.unit is SpeedUnit.TRAVEL]
    travel = timing.plan.moves.travel
    return max([*written, *travel[np.isfinite(travel)].tolist()], default=0.0)


def _speeds(program: Program, most: float, kept: frozenset[int], steps: set[int]) -> Iterator[Choice]:
    spoken = [one for one in speeds(program) if one.speed.unit in _UNITS]
    highest = {SpeedUnit.FRACTION: 1.0, SpeedUnit.TRAVEL: most}
    done: set[int] = set()
    for one in spoken:
        if one.line in kept or one.written in kept or one.written in done:
            continue
        if one.line not in steps and one.written not in steps:
            continue  # never runs
        done.add(one.written)
        yield from _faster(one.line, one.speed, one.place, highest[one.speed.unit])


def _faster(line: int, speed: Speed, written: WrittenSpeed, highest: float) -> Iterator[Choice]:
    now, (unit, name) = _si(speed), _UNITS[speed.unit]
    if not 0.0 < now < highest:
        return
    values = [_round(now * factor / unit) * unit for factor in _FASTER]
    told: set[float] = set()
    for value in (*(v for v in values if now < v < highest), highest):
        number = float(f"{value / speed.value.scale:.9g}")
        texts = written.respelt(number)
        if round(value, 9) in told or not texts:
            continue
        told.add(round(value, 9))
        says = f"{now / unit:g} → {value / unit:g} {name}"
        yield Choice("speed", line, ("speed", written.line), says, value / now - 1.0, tuple(texts.items()))


def _si(speed: Speed) -> float:
    return float(speed.value.literal or 0.0) if speed.value.literal is not None else 0.0


def _round(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}") if value < 1000 else float(f"{value:.{_DIGITS + 1}g}")


def _zones(program: Program, timing: Timing, kept: frozenset[int]) -> Iterator[Choice]:
    """Corners with a zone may get a larger one; an exact stop one only where nothing stops there."""
    case = LintCase(program, timing)
    stops = {found.line for found in ExactStop().find(case)}
    plan = timing.plan
    for line, steps in case.lines.items():
        code = int(plan.moves.blend_code[case.row(steps[0])])
        if line in kept or (code == BlendCode.EXACT and line not in stops):
            continue
        for number, text in enumerate(larger(program.vendor, program.source.line(line))):
            yield Choice("zone", line, ("zone", line), text.says, 0.1 * (number + 1), zone=number)


def apply(program: Program, chosen: Sequence[Choice]) -> Program:
    """The program with these edits. Raises OlpError where it cannot be read."""
    source = replaced(program.source, {token: text for one in chosen for token, text in one.texts})
    lines: dict[int, tuple[str, ...]] = {}
    for one in chosen:
        if one.zone >= 0:
            zones = list(larger(program.vendor, source.line(one.line)))
            lines[one.line] = (zones[min(one.zone, len(zones) - 1)].text,)
    source = source.edited(lines) if lines else source
    reread = getattr(language(program), "reread", None)
    new = reread(source, program.companions) if reread else find_vendor(program.vendor).read(source)
    return like(new, program)


def seconds_of(
    base: Timing, edited: Timing, active: Sequence[Sequence[int]]
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """What each group of lines gains [s], all steps shared out: a step counts to the active one that runs nearest."""
    gained = np.nan_to_num(base.duration_s) - np.nan_to_num(edited.duration_s)
    owner = np.full(len(base.plan), -1)
    for number, lines in enumerate(active):
        owner[np.isin(base.plan.line, lines) & (base.plan.source == 0)] = number
    places = np.flatnonzero(owner >= 0)
    found = np.zeros(len(active))
    if not len(places):
        return found
    steps = np.arange(len(owner))
    after = np.minimum(np.searchsorted(places, steps), len(places) - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.where(abs(places[before] - steps) <= abs(places[after] - steps), before, after)
    np.add.at(found, owner[places[nearer]], gained)
    return found
