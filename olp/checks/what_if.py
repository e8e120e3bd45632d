"""Time of a program with another speed or zone of single lines: edited in memory, timed, and never written.

Codes: O011 a line without the requested zone, O012 a packed file or project; those of `olp.checks.edit`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from olp.checks.edit import ChangeSpeed, Edited, check_same, edited
from olp.checks.fit.choices import reread
from olp.checks.lint.zones import larger, smaller
from olp.core.diagnostic import Diagnostic, OlpError, Span, error
from olp.core.source import decode
from olp.core.units import deg, mm
from olp.ir.program import Move, SpeedUnit
from olp.languages.literals import speeds
from olp.languages.vendor import find_vendor
from olp.runtime.plan import StepKind

if TYPE_CHECKING:
    from olp.core.source import Source
    from olp.ir.program import Program
    from olp.timing.result import Timing

# What a person reads and writes: the size of one in SI, and its name.
SPEED_UNITS: Mapping[SpeedUnit, tuple[float, str]] = {
    SpeedUnit.FRACTION: (0.01, "%"),
    SpeedUnit.TRAVEL: (mm, "mm/s"),
    SpeedUnit.TURN: (deg, "deg/s"),
    SpeedUnit.AXIS: (deg, "deg/s"),
    SpeedUnit.TIME: (1.0, "s"),
}


class LineEdit(NamedTuple):
    """Another `speed` of `line`, in the unit of its `EditableLine`, and its n-th larger zone (-n: smaller)."""

    line: int
    speed: float | None = None
    zone: int = 0


class EditableLine(NamedTuple):
    """A line whose speed or zone can be changed. `written`: the line on which that speed is written.

    `speed` in `unit`, None without a speed of its own. `zones`: n of `LineEdit`, and the zone as written.
    """

    line: int
    statement: str
    speed: float | None
    unit: str
    written: int
    zones: tuple[tuple[int, str], ...]


class WhatIf(NamedTuple):
    """The changed program. `sources`: its files that differ."""

    program: Program
    sources: tuple[Source, ...]
    notes: tuple[Diagnostic, ...]


def editable_lines(program: Program) -> list[EditableLine]:
    """Every line that can be changed, in order. Raises OlpError (O001, O012)."""
    spoken = {one.line: one for one in speeds(program)}
    _refuse_packed(program)
    moves = _moves(program)
    found = []
    for line in sorted(moves.keys() | spoken.keys()):
        text = program.source.line(line)
        zones = tuple((n, says) for n, says, _ in _zones(program, moves.get(line), text))
        one = spoken.get(line)
        if one is None and not zones:
            continue
        scale, unit = SPEED_UNITS[one.speed.unit] if one is not None else (1.0, "")
        number = one.speed.value.literal if one is not None else None
        speed = None if number is None else float(f"{number / scale:.9g}")
        found.append(
            EditableLine(line, text.strip(), speed, unit, one.written if one is not None else line, zones)
        )
    return found


def what_if(program: Program, changes: Sequence[LineEdit]) -> WhatIf:
    """The program with these changes only. Raises OlpError with all problems."""
    spoken = {one.line: one for one in speeds(program)}
    _refuse_packed(program)
    edits = []
    for one in changes:
        if one.speed is not None:
            # A line without a speed of its own is refused by `edited`, whatever the number.
            scale = SPEED_UNITS[spoken[one.line].speed.unit][0] if one.line in spoken else 1.0
            edits.append(ChangeSpeed(one.line, one.speed * scale))
    result = edited(program, edits) if edits else Edited(program, (), ())
    zoned = _with_zones(result.program, {one.line: one.zone for one in changes if one.zone})
    old = {one.path: one.raw for one in (program.source, *program.companions)}
    now = (zoned.source, *zoned.companions)
    return WhatIf(zoned, tuple(one for one in now if one.raw != old.get(one.path)), result.notes)


def seconds_by_line(timing: Timing) -> dict[int, float]:
    """Seconds [s] of each line of the program itself, over all its runs."""
    own = timing.plan.source == 0
    lines, of = np.unique(timing.plan.line[own], return_inverse=True)
    sums = np.bincount(of, np.nan_to_num(timing.duration_s[own]), len(lines))
    timed = np.unique(timing.plan.line[own & (timing.plan.kind == StepKind.MOVE)])
    return {
        line: round(seconds, 9)
        for line, seconds in zip(lines.tolist(), sums.tolist(), strict=True)
        if seconds or line in timed
    }


def _refuse_packed(program: Program) -> None:
    """Raises OlpError (O012) for a packed program or a project of other files, whose text is not the file's."""
    source = program.source
    if decode(source.raw, source.path, source.encoding).lines != source.lines:
        says = "this file holds other files: its lines cannot be changed"
        raise OlpError(error("O012", says, file=source.path, help="open the program in it, saved as text"))


def _moves(program: Program) -> dict[int, Move]:
    return {one.line: one for one in program.statements() if isinstance(one, Move)}


def _zones(program: Program, move: Move | None, text: str) -> list[tuple[int, str, str]]:
    """n of `LineEdit`, the zone as written, and the line with it: the smallest first.

    A zone that is not a number (KRL C_DIS, a variable) is kept.
    """
    words = find_vendor(program.vendor).corners
    if words is None or move is None or not (re.search(words.zone, text) or _stops(move)):
        return []
    less = list(smaller(program.vendor, text))
    found = [(n - len(less), one) for n, one in enumerate(reversed(less))]
    found += [(n, one.text) for n, one in enumerate(larger(program.vendor, text), 1)]
    spelt = {one: re.search(words.zone, one) for _, one in found}
    return [(n, "smallest" if (zone := spelt[one]) is None else zone[0].strip(), one) for n, one in found]


def _stops(move: Move) -> bool:
    blend = move.blend
    return blend is None or (blend.value is not None and blend.value.literal == 0.0)


def _with_zones(program: Program, zones: Mapping[int, int]) -> Program:
    """The program with the n-th larger zone of each line. Raises OlpError: O011, and O008 where the new text
    changes something else.
    """
    if not zones:
        return program
    lines: dict[int, tuple[str]] = {}
    moves, problems = _moves(program), []
    for line, zone in zones.items():
        known = {n: text for n, _, text in _zones(program, moves.get(line), program.source.line(line))}
        if zone in known:
            lines[line] = (known[zone],)
        else:
            help = f"there are {', '.join(map(str, known))}" if known else "this line has none to change"
            problems.append(
                error("O011", f"no zone number {zone} on this line", Span(line), file=program.path, help=help)
            )
    if problems:
        raise OlpError(*problems)
    result = reread(program, program.source.edited(lines))
    check_same(program, result, len(lines))
    return result
