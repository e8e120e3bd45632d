"""The receipt of a translation: what was kept, changed and left out, and how far apart the two programs are."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from olp.program import Begin, Comment, Declare, End, Program
from olp.translate.canonical import Translated
from olp.translate.compare import Comparison, compare_plans, steps_of
from olp.translate.link import Linked
from olp.translate.work import Fate, Loss, kind_of
from olp.units import deg, mm

if TYPE_CHECKING:
    from olp.plan import Plan
    from olp.robot import Robot

_ORDER = tuple(Fate)
_UNCOUNTED = (Begin, End, Comment, Declare)


@dataclass(frozen=True, slots=True)
class Receipt:
    """`counts`: kind of statement -> fate -> how many. `lines`: what is not exact, worst first in each line.

    `comparison`: of both plans, None where one cannot be run. `times`: (line of the source, seconds there, line of the
    target, seconds there) of each matching step; nan where no robot lets it be known.
    """

    source: str
    source_vendor: str
    target_vendor: str
    files: tuple[str, ...]
    robots: tuple[str, str]
    counts: Mapping[str, Mapping[str, int]]
    losses: tuple[Loss, ...]
    mapping: Mapping[tuple[str, str], str]
    notes: tuple[str, ...]
    places: Mapping[int, tuple[str, int]] = field(default_factory=dict)
    comparison: Comparison | None = None
    times: tuple[tuple[int, float, int, float], ...] = ()

    @property
    def totals(self) -> dict[str, int]:
        """How many statements of each fate."""
        return {fate.value: sum(row.get(fate.value, 0) for row in self.counts.values()) for fate in _ORDER}

    @property
    def is_exact(self) -> bool:
        return not self.losses


def receipt_of(
    linked: Linked,
    translated: Translated,
    target: str,
    files: tuple[str, ...],
    plans: tuple[Plan | None, Plan | None],
    robots: tuple[Robot | None, Robot | None],
) -> Receipt:
    """`plans`: of the source and of the files read again; None where a program could not be run."""
    one, other = plans
    comparison: Comparison | None = None
    times: tuple[tuple[int, float, int, float], ...] = ()
    if one is not None and other is not None:
        left_out = {loss.line for loss in translated.losses if loss.leaves_out}
        comparison = compare_plans(one, other, without=left_out)
        times = _times(one, other, left_out)
    program = linked.program
    return Receipt(
        program.path,
        program.vendor,
        target,
        files,
        (_name(robots[0]), _name(robots[1] or robots[0])),
        counts_of(program, translated.losses),
        tuple(loss for loss in translated.losses if loss.fate is not Fate.EXACT),
        translated.mapping,
        translated.notes,
        {loss.line: linked.place(loss.line) for loss in translated.losses},
        comparison,
        times,
    )


def _name(robot: Robot | None) -> str:
    return "" if robot is None else robot.name


def counts_of(program: Program, losses: tuple[Loss, ...]) -> dict[str, dict[str, int]]:
    """Kind of statement -> fate -> how many; a statement has the worst fate of its parts."""
    worst: dict[tuple[int, str], Fate] = {}
    for loss in losses:
        key = (loss.line, loss.statement)
        worst[key] = max(worst.get(key, Fate.EXACT), loss.fate, key=_ORDER.index)
    found: dict[str, dict[str, int]] = {}
    for s in program.statements():
        if isinstance(s, _UNCOUNTED):
            continue
        kind = kind_of(s)
        fate = worst.get((s.line, kind), Fate.EXACT)
        row = found.setdefault(kind, {})
        row[fate.value] = row.get(fate.value, 0) + 1
    return dict(sorted(found.items()))


def _times(one: Plan, other: Plan, left_out: set[int]) -> tuple[tuple[int, float, int, float], ...]:
    """Seconds per step on both controllers, as `olp time` predicts them without a signature."""
    first, second = _durations(one, left_out), _durations(other, set())
    if len(first) != len(second):
        return ()
    return tuple((a, x, b, y) for (a, x), (b, y) in zip(first, second, strict=True))


def _durations(plan: Plan, left_out: set[int]) -> list[tuple[int, float]]:
    """(line, seconds) of each step; what was put together is one."""
    from olp.timing import time_plan

    timing = time_plan(plan)
    return [(step.line, step.seconds) for step in steps_of(plan, left_out, timing.duration_s.tolist())]


# --- words ----------------------------------------------------------------------------------------------


def as_json(receipt: Receipt) -> dict[str, Any]:
    """The receipt for scripts; nan is null."""
    comparison = receipt.comparison
    return {
        "source": {
            "file": receipt.source,
            "vendor": receipt.source_vendor,
            "robot": receipt.robots[0] or None,
        },
        "target": {
            "files": list(receipt.files),
            "vendor": receipt.target_vendor,
            "robot": receipt.robots[1] or None,
        },
        "totals": receipt.totals,
        "statements": {kind: dict(row) for kind, row in receipt.counts.items()},
        "losses": [_loss(receipt, loss) for loss in receipt.losses],
        "mapping": [{"kind": kind, "from": name, "to": to} for (kind, name), to in receipt.mapping.items()],
        "notes": list(receipt.notes),
        "difference": None if comparison is None else _difference(comparison),
        "time": _time(receipt),
    }


def _loss(receipt: Receipt, loss: Loss) -> dict[str, Any]:
    file, line = receipt.places.get(loss.line, (receipt.source, loss.line))
    return {
        "file": file,
        "line": line,
        "statement": loss.statement,
        "fate": loss.fate.value,
        "part": loss.part,
        "says": loss.says,
        "size": None if math.isnan(loss.size) else loss.size,
        "unit": loss.unit,
    }


def _difference(c: Comparison) -> dict[str, Any]:
    return {
        "steps": c.steps,
        "position_mm": c.worst_position / mm,
        "orientation_deg": c.worst_angle / deg,
        "speed_percent": 100 * c.worst_speed,
        "blend_mm": c.worst_blend / mm,
        "wait_s": c.worst_wait,
        "says": c.differences,
    }


def _time(receipt: Receipt) -> dict[str, Any] | None:
    if not receipt.times:
        return None
    return {
        "source_s": sum(row[1] for row in receipt.times),
        "target_s": sum(row[3] for row in receipt.times),
        "segments": [
            {"line": a, "source_s": x, "target_line": b, "target_s": y} for a, x, b, y in receipt.times
        ],
    }


def as_text(receipt: Receipt) -> str:
    """The receipt for people."""
    lines = [
        f"{receipt.source} ({receipt.source_vendor}) as {receipt.target_vendor}: {', '.join(receipt.files)}",
        "",
    ]
    width = max((len(kind) for kind in receipt.counts), default=9)
    lines.append(f"{'statement':<{width}}" + "".join(f"{fate.value:>14}" for fate in _ORDER))
    for kind, row in receipt.counts.items():
        lines.append(f"{kind:<{width}}" + "".join(f"{row.get(fate.value, 0) or '':>14}" for fate in _ORDER))
    totals = receipt.totals
    lines.append(f"{'all':<{width}}" + "".join(f"{totals[fate.value]:>14}" for fate in _ORDER))
    if receipt.losses:
        lines += ["", *(_loss_text(receipt, loss) for loss in receipt.losses)]
    if receipt.mapping:
        lines += [
            "",
            *(f"{kind} {name} is {to}" for (kind, name), to in receipt.mapping.items() if name != to),
        ]
    if receipt.notes:
        lines += ["", *(f"note: {note}" for note in receipt.notes)]
    lines += ["", *_comparison_text(receipt)]
    return "\n".join(lines) + "\n"


def _loss_text(receipt: Receipt, loss: Loss) -> str:
    file, line = receipt.places.get(loss.line, ("", loss.line))
    place = f"{file}:{line}" if line else file or receipt.source
    size = "" if math.isnan(loss.size) else f", {loss.size:.4g} {loss.unit}"
    return f"{place}: {loss.statement}: {loss.part} {loss.fate.value}: {loss.says}{size}"


def _comparison_text(receipt: Receipt) -> list[str]:
    c = receipt.comparison
    if c is None:
        return ["the two programs could not be run and compared"]
    if not c.steps and not c.differences:
        return ["neither program moves or waits here: there was nothing to compare"]
    rows = [
        f"both run: {c.steps} steps, at most {c.worst_position / mm:.2g} mm and {c.worst_angle / deg:.2g} deg apart,"
        f" speeds {100 * c.worst_speed:.2g} %, blends {c.worst_blend / mm:.2g} mm, waits {c.worst_wait:.2g} s",
        *c.differences[:20],
    ]
    if receipt.times:
        source, target = (sum(row[at] for row in receipt.times) for at in (1, 3))
        names = " and ".join(dict.fromkeys(name for name in receipt.robots if name)) or "no robot named"
        rows.append(f"predicted ({names}): {source:.3f} s before, {target:.3f} s after")
    return rows
