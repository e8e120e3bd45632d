"""The receipt of a translation: what was kept, changed and left out, and how far apart the two programs are.

The form for scripts is here, that for people in `receipt_text`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from olp.called import kind_of
from olp.program import Begin, Comment, Declare, End, Program
from olp.translate.before import before_it_runs, places
from olp.translate.canonical import Translated
from olp.translate.compare import Comparison, compare_plans, steps_of
from olp.translate.data_only import holds_data_only
from olp.translate.link import Linked
from olp.translate.work import Fate, Loss
from olp.units import deg, mm

if TYPE_CHECKING:
    from olp.plan import Plan
    from olp.robot import Robot

_ORDER = tuple(Fate)
_UNCOUNTED = (Begin, End, Comment, Declare)


@dataclass(frozen=True, slots=True)
class Receipt:
    """`counts`: kind of statement -> fate -> how many. `losses`: what is not exact; `remarks`: what is and is told.

    `comparison`: of both plans, None where one cannot be run. `times`: (line of the source, seconds there, line of the
    target, seconds there) of each matching step; nan where no robot lets it be known. `before_run`: what is to be
    done before the translation runs on a controller. `unknown`: where statements were left out of both runs, for what
    they do depends on values that nobody knows here.
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
    before_run: tuple[str, ...] = ()
    remarks: tuple[Loss, ...] = ()
    unknown: str = ""
    data_only: bool = False  # nothing in it runs

    @property
    def totals(self) -> dict[str, int]:
        """How many statements of each fate."""
        return {fate.value: sum(row.get(fate.value, 0) for row in self.counts.values()) for fate in _ORDER}

    @property
    def is_exact(self) -> bool:
        return not self.losses

    def place(self, loss: Loss) -> tuple[str, int]:
        """File and line of a loss; line 0: the program as a whole."""
        return self.places.get(loss.line, (self.source, loss.line))


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
    data_only = holds_data_only(program)
    idle = (loss for loss in translated.losses if loss.fate is Fate.EXACT)
    remarks = (*idle, *translated.remarks)
    lines = [loss.line for loss in (*translated.losses, *remarks)]
    lines += [] if comparison is None else comparison.unknown
    checked = data_only or (comparison is not None and not comparison.until)
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
        {line: linked.place(line) for line in lines},
        comparison,
        times,
        before_it_runs(linked, translated, target, other, checked),
        remarks,
        "" if comparison is None else places(map(linked.place, comparison.unknown)),
        data_only,
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
        "notes": [*receipt.notes, *(_remark(receipt, loss) for loss in receipt.remarks)],
        "before_run": list(receipt.before_run),
        "difference": None if comparison is None else _difference(comparison),
        "unknown": receipt.unknown or None,
        "time": _time(receipt),
    }


def _remark(receipt: Receipt, loss: Loss) -> str:
    file, line = receipt.place(loss)
    return f"line {line}: {loss.says}" if file == receipt.source else f"{file}:{line}: {loss.says}"


def _loss(receipt: Receipt, loss: Loss) -> dict[str, Any]:
    file, line = receipt.place(loss)
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
        "until_line": c.until or None,
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
