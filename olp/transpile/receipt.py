"""The receipt of a translation: what was kept, changed and left out, and how far apart the two programs are.

The form for scripts is here, that for people in `receipt_text`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from olp.core.units import deg, mm
from olp.ir.program import Begin, Comment, Declare, End, Program
from olp.ir.terminology import kind_of
from olp.transpile.compare import WRITTEN, Comparison, Tolerances, compare_plans
from olp.transpile.context import Fate, Loss
from olp.transpile.correspondence import renamer
from olp.transpile.data_only import holds_data_only
from olp.transpile.link import Linked
from olp.transpile.pipeline import Translated
from olp.transpile.preflight import before_it_runs, places
from olp.transpile.verdict import Objection, Verdict, verdict_of

if TYPE_CHECKING:
    from olp.robots.robot import Robot
    from olp.runtime.plan import Plan

_ORDER = tuple(Fate)
_UNCOUNTED = (Begin, End, Comment, Declare)


class PlanRuns(NamedTuple):
    """Plans of the source and of the translation: with the inputs as assumed, then with other ones, in the same order.

    None where a program could not be run. `origins`: see `Rerun`.
    """

    source: tuple[Plan | None, ...]
    target: tuple[Plan | None, ...]
    origins: Mapping[tuple[str, int], int] | None = None


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
    verdict: Verdict = field(default_factory=Verdict)
    again: tuple[Comparison, ...] = ()  # with the inputs on

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
    runs: PlanRuns,
    robots: tuple[Robot | None, Robot | None],
    tolerances: Tolerances = WRITTEN,
) -> Receipt:
    """`runs`: of the source and of the files read again."""
    one, other = runs.source[0], runs.target[0]
    comparison: Comparison | None = None
    again: list[Comparison] = []
    times: tuple[tuple[int, float, int, float], ...] = ()
    left_out = {loss.line for loss in translated.losses if loss.leaves_out}
    for before, after in zip(runs.source, runs.target, strict=False):
        if before is None or after is None:
            continue
        found = compare_plans(
            before,
            after,
            without=left_out,
            tolerances=tolerances,
            origins=runs.origins,
            renamed=renamer(translated.mapping),
            seconds=(_seconds(before), _seconds(after)) if before is one else ((), ()),
        )
        if before is one:
            comparison = found
            times = tuple(found.times)
        else:
            again.append(found)
    program = linked.program
    data_only = holds_data_only(program)
    compared = [*([] if comparison is None else [comparison]), *again]
    verdict = verdict_of(translated, (one, other), compared, data_only)
    idle = (loss for loss in translated.losses if loss.fate is Fate.EXACT)
    remarks = (*idle, *translated.remarks)
    lines = [loss.line for loss in (*translated.losses, *remarks)]
    lines += [] if comparison is None else comparison.unknown
    lines += [one.line for one in verdict.objections]
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
        verdict,
        tuple(again),
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


def _seconds(plan: Plan) -> list[float]:
    """Of each step, as `olp time` predicts them without a signature."""
    from olp.timing.timing import time_plan

    return [float(seconds) for seconds in time_plan(plan).duration_s]


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
        "agrees": receipt.verdict.agrees,
        "objections": [_objection(receipt, one) for one in receipt.verdict.objections],
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


def _objection(receipt: Receipt, one: Objection) -> dict[str, Any]:
    file, line = receipt.places.get(one.line, (receipt.source, one.line))
    return {"kind": one.kind, "file": file, "line": line or None, "says": one.says}


def _tolerances(t: Tolerances) -> dict[str, float]:
    return {
        "position_mm": t.position / mm,
        "orientation_deg": t.angle / deg,
        "speed_percent": 100 * t.speed,
        "blend_mm": t.blend / mm,
        "wait_s": t.wait,
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
        "tolerances": _tolerances(c.tolerances),
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
