"""The receipt of a translation: what was kept, changed and left out, and how far apart the two programs are.

The form for scripts is here, that for people in `receipt_text`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from olp.core.diagnostic import Diagnostic
from olp.core.units import deg, mm
from olp.ir import program as st
from olp.ir.terminology import kind_of
from olp.runtime.interpreter import LIMIT
from olp.runtime.plan import ASSUMABLE, Plan
from olp.transpile.compare import WRITTEN, Comparison, PlanDifference, Tolerances, compare_plans
from olp.transpile.context import BESIDE, PROCESS, Fate, Loss, Translated, partly_left_out
from olp.transpile.correspondence import MadeUpRun, blamed, renamer, states_told
from olp.transpile.dead_code import holds_data_only
from olp.transpile.link import Linked
from olp.transpile.preflight import before_it_runs, places

if TYPE_CHECKING:
    from olp.robots.model import Robot


# --- Verdict ---
# Whether a translation is proven: both programs ran to their end, and every step of both agrees.
#
# What stands against it has a kind, and a reader may accept some: a difference that the receipt names at that line
# ("named"), a statement that is left out ("left-out"), runs that could not be compared to their end ("uncompared").
# Nobody can accept a difference that the receipt does not name ("difference").

ACCEPTABLE: Final = ("named", "left-out", "uncompared")
# What the receipt names of a statement -> what of a step it explains.
_EXPLAINS: Final = {
    "speed": ("speed",),
    "override": ("speed",),
    "blend": ("blend",),
    "end": ("blend", "signal", "order"),
    "configuration": ("position", "orientation", "speed"),
    "joints": ("position", "orientation", "speed"),
    "base": ("position", "orientation"),
    "pose": ("position", "orientation", "path", "speed"),
    "option": ("path", "orientation"),
    "wait": ("wait", "order"),
    "duration": ("wait", "signal", "order"),
}
_TURNED: Final = ("configuration", "joints")  # after which a joint move has another way
_FAILED: Final = ("I1", "I2", "I3")  # a statement that a run left out
_VALUES: Final = "I2"  # … for a value, which is a warning where nobody tells what it comes from


class PlanRuns(NamedTuple):
    """Plans of the source and of the translation: with the inputs as assumed, then with other ones, then of further
    programs that the source holds, in the same order.

    None where a program could not be run. `origins`: the line of the source that each line of a file was made from.
    `made_up`: with values for what no file tells. `starts`: the routine where each plan starts, "" the main one.
    """

    source: tuple[Plan | None, ...]
    target: tuple[Plan | None, ...]
    origins: Mapping[tuple[str, int], int] | None = None
    made_up: tuple[MadeUpRun, ...] = ()
    starts: tuple[str, ...] = ()


class Objection(NamedTuple):
    """What stands against a translation. `line`: of the source, 0 the program as a whole."""

    kind: str
    line: int
    says: str


@dataclass(frozen=True, slots=True)
class Verdict:
    """`objections`: the worst kind first, in the order of the runs."""

    objections: tuple[Objection, ...] = ()

    @property
    def agrees(self) -> bool:
        return not self.objections

    def holds(self, accepted: Iterable[str] = ()) -> bool:
        """Whether nothing is left but what the reader accepts."""
        return {one.kind for one in self.objections} <= set(accepted)


def verdict_of(
    translated: Translated,
    runs: PlanRuns,
    comparisons: Sequence[Comparison],
    data_only: bool = False,
) -> Verdict:
    found = [
        *_differences(translated.losses, comparisons),
        *_left_out(translated.losses),
        *(() if data_only else _unfinished(runs, comparisons)),
    ]
    kinds = ("difference", *ACCEPTABLE)
    return Verdict(tuple(sorted(found, key=lambda one: kinds.index(one.kind))))


def _differences(losses: Sequence[Loss], comparisons: Sequence[Comparison]) -> Iterator[Objection]:
    named: dict[int, set[str]] = {}
    for loss in losses:
        if loss.fate is Fate.APPROXIMATED:
            named.setdefault(loss.line, set()).update(_EXPLAINS.get(loss.part, ()))
    turned = {loss.line for loss in losses if loss.part in _TURNED}
    for comparison in comparisons:
        before = 0
        for one in comparison.found:
            known = one.part in named.get(one.line, set()) or (
                one.part == "speed" and _follows(one, before, turned)
            )
            yield Objection("named" if known else "difference", one.line, one.says)
            before = one.line


def _follows(one: PlanDifference, before: int, turned: set[int]) -> bool:
    """Whether the joint move before a step ends with another arm configuration, as the receipt says."""
    return before in turned or any(line < one.line for line in turned if line > before)


def _left_out(losses: Sequence[Loss]) -> Iterator[Objection]:
    told: set[int] = set()
    for loss in losses:
        gone = loss.fate in (Fate.COMMENTED, Fate.REFUSED) or loss.part in (PROCESS, BESIDE)
        if gone and loss.line not in told:
            told.add(loss.line)
            yield Objection("left-out", loss.line, loss.says)


def _is_unfinished(found: Diagnostic) -> bool:
    """Whether a run left something out, or took what no file says for granted, so that the two may agree by chance."""
    left_out = found.code.startswith(_VALUES) or (found.is_error and found.code.startswith(_FAILED))
    return left_out or found.code in ASSUMABLE


def _unfinished(runs: PlanRuns, comparisons: Sequence[Comparison]) -> Iterator[Objection]:
    for name, plans in zip(("the source", "the translation"), runs[:2], strict=True):
        if plans[0] is None:
            yield Objection("uncompared", 0, f"{name} could not be run")
            continue
        for found in _left_undone(plans, runs.starts):
            line = found.line if name == "the source" else 0
            where = "" if line else f" (its line {found.line})"
            yield Objection("uncompared", line, f"{name}{where}: {found.message}")
            break
    for comparison in comparisons:
        if comparison.until:
            says = "what runs from here on depends on a value that is not known here"
            yield Objection("uncompared", comparison.until, says)


def _left_undone(plans: Sequence[Plan | None], starts: Sequence[str]) -> Iterator[Diagnostic]:
    """What the runs left out. Those with the inputs on may be cut off: their loops may have no end."""
    for place, plan in enumerate(plans):
        with_inputs_on = place > 0 and not (starts and starts[place])
        for found in () if plan is None else plan.diagnostics:
            if _is_unfinished(found) or (found.code == LIMIT and not with_inputs_on):
                yield found


# --- Receipt ---

_ORDER = tuple(Fate)
_UNCOUNTED = (st.Begin, st.End, st.Comment, st.Declare)


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
    made_up: tuple[Comparison, ...] = ()  # with values for what no file tells; what the others have not shown
    starts: Mapping[str, Comparison] = field(default_factory=dict)  # of further programs that it holds
    unreached: str = ""  # moves that none of the runs comes to

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
    comments, left_out = (
        {x.line for x in translated.losses if x.part == "statement" and (x.fate is Fate.EXACT) is exact}
        for exact in (True, False)
    )
    partly = partly_left_out(linked.program, [x for x in translated.losses if x.part == "statement"])
    comments, left_out = comments | partly, left_out - partly
    compared = partial(
        compare_plans,
        without=left_out,
        comments=comments,
        tolerances=tolerances,
        origins=runs.origins,
        renamed=renamer(translated.mapping),
        states=states_told(target),
        loose={
            "loop": _loops(linked.program),
            **{
                part: {loss.line for loss in translated.losses if loss.part == part}
                for part in ("wait", "order", BESIDE)
            },
        },
    )
    comparison, again, starts = _compared_runs(runs, compared)
    times = () if comparison is None else tuple(comparison.times)
    known = {
        (row.line, row.part)
        for past in (comparison, *again, *starts.values())
        if past is not None
        for row in past.found
    }
    made_up: list[Comparison] = []
    for run in runs.made_up:
        found = _with_made_up(run, compared, known)
        if found is not None:
            made_up.append(found)
            known |= {(row.line, row.part) for row in found.found}
    program = linked.program
    data_only = holds_data_only(program)
    comparisons = [*([] if comparison is None else [comparison]), *again, *starts.values(), *made_up]
    verdict = verdict_of(translated, runs, comparisons, data_only)
    idle = (loss for loss in translated.losses if loss.fate is Fate.EXACT)
    remarks = (*idle, *translated.remarks)
    lines = [loss.line for loss in (*translated.losses, *remarks)]
    lines += [] if comparison is None else comparison.unknown
    lines += [one.line for one in verdict.objections]
    sources = (*runs.source, *(run.source for run in runs.made_up))
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
        before_it_runs(linked, translated, target, runs.target[0], checked, robots[1] is not None),
        remarks,
        "" if comparison is None else places(map(linked.place, comparison.unknown)),
        data_only,
        verdict,
        tuple(again),
        tuple(made_up),
        starts,
        "" if data_only else places(map(linked.place, _unreached(program, sources, left_out))),
    )


def _loops(program: st.Program) -> set[int]:
    """Lines of what may ask again and again: heads of loops, and jumps back with their labels."""
    found = {s.line for s in program.statements() if isinstance(s, (st.While, st.Repeat, st.Until))}
    for routine in program.routines:
        labels: dict[str, int] = {}
        for s in routine.body:
            if isinstance(s, st.Label):
                labels[s.name] = s.line
            elif isinstance(s, st.Jump) and (not isinstance(s.target, str) or s.target in labels):
                found |= {s.line, *((labels[s.target],) if isinstance(s.target, str) else labels.values())}
    return found


def _compared_runs(
    runs: PlanRuns, compared: Callable[..., Comparison]
) -> tuple[Comparison | None, list[Comparison], dict[str, Comparison]]:
    """Of the plain runs, of those with the inputs on, and of those from further routines."""
    plain: Comparison | None = None
    again: list[Comparison] = []
    starts: dict[str, Comparison] = {}
    labels = runs.starts or ("",) * len(runs.source)
    for place, (before, after, start) in enumerate(zip(runs.source, runs.target, labels, strict=False)):
        if before is None or after is None:
            continue
        if place == 0:
            plain = compared(before, after, seconds=(_seconds(before), _seconds(after)))
        elif start:
            starts[start] = compared(before, after)
        else:
            again.append(compared(before, after))
    return plain, again, starts


def _with_made_up(
    run: MadeUpRun, compared: Callable[..., Comparison], known: Set[tuple[int, str]]
) -> Comparison | None:
    """Both runs with made-up values: what differs beyond what is known, and which of the values makes it differ."""
    if run.source is None or run.target is None or not run.asked:
        return None
    found = compared(run.source, run.target, other_lengths=True)
    new = [row for row in found.found if (row.line, row.part) not in known]
    if new:
        first = (new[0].line, new[0].part)

        def differs(one: MadeUpRun) -> bool:
            if one.source is None or one.target is None:
                return False
            alone = compared(one.source, one.target, other_lengths=True)
            return any((row.line, row.part) == first for row in alone.found)

        says = blamed(run, differs)
        new = [row._replace(text=f"{says}: {row.text}") for row in new]
    found.found = new
    return found


def _unreached(program: st.Program, plans: Sequence[Plan | None], left_out: Set[int]) -> list[int]:
    """The lines of moves that are translated and that no run came to."""
    reached = {int(line) for plan in plans if plan is not None for line in np.unique(plan.line)}
    reached |= {found.line for plan in plans if plan is not None for found in plan.diagnostics}
    reached |= left_out
    moves = dict.fromkeys(s.line for s in program.statements() if isinstance(s, st.Move))
    return [line for line in moves if line not in reached]


def _name(robot: Robot | None) -> str:
    return "" if robot is None else robot.name


def counts_of(program: st.Program, losses: tuple[Loss, ...]) -> dict[str, dict[str, int]]:
    """Kind of statement -> fate -> how many; a statement has the worst fate of its parts.

    A loss of a part that no statement of its line is, such as an output that a move switches, is the first one's.
    """
    counted = [(s.line, kind_of(s)) for s in program.statements() if not isinstance(s, _UNCOUNTED)]
    first = dict(reversed(counted))
    known = set(counted)
    uncounted = {kind.__name__ for kind in _UNCOUNTED} | {"program"}
    worst: dict[tuple[int, str], Fate] = {}
    for loss in losses:
        key = (loss.line, loss.statement)
        if key not in known and loss.line in first:
            key = (loss.line, first[loss.line])
        elif key not in known and loss.fate is not Fate.EXACT and loss.statement not in uncounted:
            known.add(key)
            counted.append(key)  # of a line that the run has with another one: TRIGGER
        worst[key] = max(worst.get(key, Fate.EXACT), loss.fate, key=_ORDER.index)
    found: dict[str, dict[str, int]] = {}
    for key in counted:
        fate = worst.get(key, Fate.EXACT)
        row = found.setdefault(key[1], {})
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
        "starts": {name: _difference(one) for name, one in receipt.starts.items()},
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


def _known(seconds: float) -> float | None:
    """JSON has no number for what is not known."""
    return None if math.isnan(seconds) else seconds


def _time(receipt: Receipt) -> dict[str, Any] | None:
    if not receipt.times:
        return None
    return {
        "source_s": _known(sum(row[1] for row in receipt.times)),
        "target_s": _known(sum(row[3] for row in receipt.times)),
        "segments": [
            {"line": a, "source_s": _known(x), "target_line": b, "target_s": _known(y)}
            for a, x, b, y in receipt.times
        ],
    }
