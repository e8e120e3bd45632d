"""The receipt of a translation: what was kept, changed and left out, and how far apart the two programs are.

The form for scripts is here, that for people in `receipt_text`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from olp.core.diagnostic import Diagnostic
from olp.core.units import deg, mm
from olp.ir.program import (
    Begin,
    Call,
    Comment,
    Declare,
    Dwell,
    End,
    Message,
    Move,
    Pause,
    Program,
    PulseOutput,
    SetOutput,
    Statement,
    Wait,
)
from olp.ir.terminology import kind_of
from olp.runtime.assumptions import NAMED_SIGNAL, SignalKey, signal_key, signal_name
from olp.runtime.interpreter import LIMIT
from olp.runtime.plan import ASSUMABLE, Event, Plan
from olp.transpile.compare import WRITTEN, Comparison, PlanDifference, Tolerances, compare_plans
from olp.transpile.context import PROCESS, Fate, Loss
from olp.transpile.dead_code import holds_data_only
from olp.transpile.link import Linked
from olp.transpile.pipeline import Translated
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
    "option": ("path", "orientation"),
    "wait": ("wait", "order"),
    "duration": ("wait", "signal", "order"),
}
_TURNED: Final = ("configuration", "joints")  # after which a joint move has another way
_FAILED: Final = ("I1", "I2", "I3")  # a statement that a run left out


class PlanRuns(NamedTuple):
    """Plans of the source and of the translation: with the inputs as assumed, then with other ones, in the same order.

    None where a program could not be run. `origins`: see `Rerun`.
    """

    source: tuple[Plan | None, ...]
    target: tuple[Plan | None, ...]
    origins: Mapping[tuple[str, int], int] | None = None


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
        gone = loss.fate in (Fate.COMMENTED, Fate.REFUSED) or loss.part == PROCESS
        if gone and loss.line not in told:
            told.add(loss.line)
            yield Objection("left-out", loss.line, loss.says)


def _is_unfinished(found: Diagnostic) -> bool:
    """Whether a run left something out, or took what no file says for granted, so that the two may agree by chance."""
    return found.code in ASSUMABLE or (found.is_error and found.code.startswith(_FAILED))


def _unfinished(runs: PlanRuns, comparisons: Sequence[Comparison]) -> Iterator[Objection]:
    for name, plans in zip(("the source", "the translation"), runs[:2], strict=True):
        if plans[0] is None:
            yield Objection("uncompared", 0, f"{name} could not be run")
            continue
        for found in _left_undone(plans):
            line = found.line if name == "the source" else 0
            where = "" if line else f" (its line {found.line})"
            yield Objection("uncompared", line, f"{name}{where}: {found.message}")
            break
    for comparison in comparisons:
        if comparison.until:
            says = "what runs from here on depends on a value that is not known here"
            yield Objection("uncompared", comparison.until, says)


def _left_undone(plans: Sequence[Plan | None]) -> Iterator[Diagnostic]:
    """What the runs left out. Those with the inputs on may be cut off: their loops may have no end."""
    for place, plan in enumerate(plans):
        for found in () if plan is None else plan.diagnostics:
            if _is_unfinished(found) or (found.code == LIMIT and not place):
                yield found


# --- Receipt ---

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
    verdict: Verdict = field(default_factory=Verdict)
    again: tuple[Comparison, ...] = ()  # with the inputs on
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
    one, other = runs.source[0], runs.target[0]
    comparison: Comparison | None = None
    again: list[Comparison] = []
    times: tuple[tuple[int, float, int, float], ...] = ()
    left_out = {loss.line for loss in translated.losses if loss.part == "statement"}
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
    verdict = verdict_of(translated, runs, compared, data_only)
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
        "" if data_only else places(map(linked.place, _unreached(program, runs.source, left_out))),
    )


def _unreached(program: Program, plans: Sequence[Plan | None], left_out: Set[int]) -> list[int]:
    """The lines of moves that are translated and that no run came to."""
    reached = {int(line) for plan in plans if plan is not None for line in np.unique(plan.line)}
    reached |= {found.line for plan in plans if plan is not None for found in plan.diagnostics}
    moves = dict.fromkeys(s.line for s in program.statements() if isinstance(s, Move))
    return [line for line in moves if line not in reached | left_out]


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


# --- Correspondence ---
# Which statement of the source each line of a translation was made from, found from the two texts' own statements.
#
# The writer makes no list: the translated program and the program that is read again hold the same statements
# in the same order, but for what a language sets beside them. Pairs are found routine by routine and never by counting:
# where one of them has a statement more, the next pair is looked for.

Token = tuple[object, ...]
_AHEAD: Final = 32  # statements that are looked at for the next pair
_SIGNAL: Final = "signal"


def origins_of(translated: Program, written: Iterable[Program]) -> dict[tuple[str, int], int]:
    """File and line of `written`, the files read again -> the line of the source that it was made from."""
    found: dict[tuple[str, int], int] = {}
    several: set[tuple[str, int]] = set()  # lines that were made from two, such as a move with its output
    bodies = {routine.name.casefold(): _steps(routine.body) for routine in translated.routines}
    for program in written:
        for routine in program.routines:
            made = bodies.get(routine.name.casefold())
            for s, t in _paired(made, _steps(routine.body)) if made is not None else ():
                place = (program.path, t.line)
                if s.line and found.setdefault(place, s.line) != s.line:
                    several.add(place)
    for place in several:
        del found[place]
    return found


def _steps(body: Sequence[Statement]) -> list[tuple[Token, Statement]]:
    return [(token, s) for s in body if (token := _token(s))]


def _token(s: Statement) -> Token:
    """What a statement and its translation have in common; () for what makes no step."""
    match s:
        case Move():
            return ("move", s.path)
        case Call():
            return ("call", s.routine.casefold())
        case SetOutput() | PulseOutput():
            return (type(s).__name__, s.signal.index)
        case Dwell() | Wait() | Pause() | Message():
            return (type(s).__name__,)
        case _:
            return ()


def _paired(
    made: list[tuple[Token, Statement]], written: list[tuple[Token, Statement]]
) -> Iterable[tuple[Statement, Statement]]:
    i, j = 0, 0
    while i < len(made) and j < len(written):
        if made[i][0] == written[j][0]:
            yield made[i][1], written[j][1]
            i, j = i + 1, j + 1
            continue
        more, others = _next_pair(made, written, i, j)
        i, j = i + more, j + others


def _next_pair(
    made: list[tuple[Token, Statement]], written: list[tuple[Token, Statement]], i: int, j: int
) -> tuple[int, int]:
    """How many statements of both come before the next pair, as few as can be."""
    for total in range(1, _AHEAD):
        for more in range(total + 1):
            x, y = i + more, j + total - more
            if x < len(made) and y < len(written) and made[x][0] == written[y][0]:
                return more, total - more
    return 1, 1


# --- signals ------------------------------------------------------------------------------------------------


_ANY: Final = "*"  # a computed number


@dataclass(frozen=True, slots=True)
class SignalsThere:
    """What signals of the source are in the target. `numbered`: by bus, the name of one with a computed number *."""

    single: Mapping[SignalKey, SignalKey]
    numbered: Mapping[str, str]

    @classmethod
    def of(cls, mapping: Mapping[tuple[str, str], str]) -> SignalsThere:
        """`mapping`: (kind, name in the source) -> name in the target."""
        single: dict[SignalKey, SignalKey] = {}
        numbered: dict[str, str] = {}
        for (kind, name), to in mapping.items():
            if kind != _SIGNAL:
                continue
            bus, _, shown = name.rpartition(" ")
            there, _, index = to.rpartition(" ")
            if shown == _ANY:
                numbered[bus] = index
            else:
                single[_key(bus, shown)] = _key(there or bus, index)
        return cls(single, numbered)

    def find(self, signal: SignalKey) -> SignalKey:
        found = self.single.get(signal)
        if found is not None:
            return found
        name = self.numbered.get(signal.bus) if isinstance(signal.number, int) else None
        return signal if name is None else _key(signal.bus, name.replace(_ANY, str(signal.number)))


def _key(bus: str, shown: str) -> SignalKey:
    return SignalKey(bus, int(shown)) if shown.isdecimal() else SignalKey(NAMED_SIGNAL, shown.casefold())


def renamer(mapping: Mapping[tuple[str, str], str]) -> Callable[[Event], Event]:
    """Events of the source with the target's signals."""
    there = SignalsThere.of(mapping)
    single = {signal_name(old): signal_name(new) for old, new in there.single.items()}

    def name_there(name: str) -> str:
        key = signal_key(name) if there.numbered else None
        return single.get(name, name) if key is None else signal_name(there.find(key))

    def renamed(event: Event) -> Event:
        signals = tuple(sorted(map(name_there, event.signals)))
        return event if signals == event.signals else event._replace(signals=signals)

    return renamed
