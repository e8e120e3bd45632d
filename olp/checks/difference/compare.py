"""Compares two timed versions of one program line by line: what each line does, how often it runs, how long it
takes.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from olp.core.source import file_name, file_stem
from olp.core.units import deg, mm
from olp.ir.expressions import Taught
from olp.ir.points import PointKind, PointState
from olp.ir.program import Move, Program
from olp.reports.outcome.model import JudgedItem
from olp.runtime.plan import BlendCode, Plan, StepKind
from olp.runtime.spelling import spell
from olp.timing.result import Timing

Floats = NDArray[np.float64]
_COMMENT = re.compile(r"\s*(//|;;|![^=]|#\s).*$")
_BLANKS = re.compile(r"\s+")


@dataclass(slots=True)
class ComparedLine:
    """One line. `seconds`: over all `count` executions. Positions [m] and angles are those of its first execution.

    `standing`: tool and frame of the target, as far as the program says. `text`: without outer blanks and comment.
    `speed`: (unit, value in SI). `signature`: meaning of the line, to find it again at another line number.
    """

    routine: str
    line: int
    text: str
    kind: str
    count: int
    seconds: float
    start: Floats
    target: Floats
    turn: Floats
    via: Floats
    axes: Floats
    speed: tuple[str, float]
    acceleration: tuple[float, float, float]
    blend: tuple[int, float]
    standing: tuple[str, str]
    file: str = ""

    @property
    def signature(self) -> tuple[object, ...]:
        """Key that is equal for lines that do the same."""
        if self.kind in ("wait", "signal"):
            return (self.routine, self.kind, self.text, round(self.seconds / self.count, 6))
        place = tuple(np.round(self.target, 5).tolist()) if not np.isnan(self.target).any() else self.text
        return (self.routine, self.kind, place, self.speed, self.blend)


def rows_of(timing: Timing, program: Program) -> list[ComparedLine]:
    """Every executed line once: routines in order of first execution, lines in order of their numbers."""
    plan = timing.plan
    names = [file_stem(source.path) for source in plan.sources]
    found: dict[tuple[int, int], ComparedLine] = {}
    seconds = np.nan_to_num(timing.duration_s).tolist()
    lines, sources, kinds = plan.line.tolist(), plan.source.tolist(), plan.kind.tolist()
    starts, standing = _line_starts(program), standing_of(program)
    for step in range(len(plan)):
        key = sources[step], lines[step]
        row = found.get(key)
        if row is None:
            routine = _routine(starts, lines[step]) if sources[step] == 0 else names[sources[step]]
            found[key] = _row(timing, step, kinds[step], routine or names[sources[step]], seconds[step])
            if sources[step] == 0:
                found[key].standing = standing.get(lines[step], ("", ""))
            found[key].file = file_name(plan.sources[sources[step]].path)
        else:
            row.count += 1
            row.seconds += seconds[step]
    order: dict[str, int] = {}
    for row in found.values():
        order.setdefault(row.routine, len(order))
    return sorted(found.values(), key=lambda row: (order[row.routine], row.line))


def _line_starts(program: Program) -> list[tuple[int, str]]:
    return sorted((routine.line, routine.name) for routine in program.routines)


def standing_of(program: Program) -> dict[int, tuple[str, str]]:
    """Tool and frame of each move, by its line."""
    found = {}
    for routine in program.routines:
        for s in routine.body:
            if not isinstance(s, Move) or not s.targets:
                continue
            target = s.targets[0]
            point = (
                routine.points.find(target.store, True, target.number) if isinstance(target, Taught) else None
            )
            tool = "" if point is None else str(point.state.tool)
            frame = "" if point is None else _frame(point.state)
            found[s.line] = (
                tool if s.tool is None else spell(s.tool),
                frame if s.frame is None else spell(s.frame),
            )
    return found


def _frame(state: PointState) -> str:
    """Name of the frame; empty for joint values, which have none."""
    if state.kind is not PointKind.POSE:
        return ""
    return state.frame if state.user is None else f"{state.frame} {state.user}"


def _routine(starts: list[tuple[int, str]], line: int) -> str:
    return next((name for start, name in reversed(starts) if start <= line), "")


_NONE = np.full(3, np.nan)


def _row(timing: Timing, step: int, kind: int, routine: str, seconds: float) -> ComparedLine:
    plan = timing.plan
    text = _BLANKS.sub(" ", _COMMENT.sub("", plan.statement(step))).strip()
    line, told = int(plan.line[step]), timing.kind[step]
    if kind != StepKind.MOVE:
        none = (math.nan,) * 3
        return ComparedLine(
            routine, line, text, told, 1, seconds, _NONE, _NONE, np.full(4, np.nan), _NONE, np.full(6, np.nan),
            ("", 0.0), none, (0, 0.0), ("", ""),
        )  # fmt: skip
    return _move(plan, step, routine, line, text, told, seconds)


def _move(
    plan: Plan, step: int, routine: str, line: int, text: str, told: str, seconds: float
) -> ComparedLine:
    moves, places = plan.moves, plan.positions
    row = int(plan.row[step])
    target = int(moves.target[row])
    via = int(moves.via[row])
    return ComparedLine(
        routine,
        line,
        text,
        told,
        1,
        seconds,
        places.position[int(moves.start[row])],
        places.position[target],
        places.quaternion[target],
        places.position[via] if via >= 0 else _NONE,
        places.axes[target],
        next(_speeds(plan, row), ("", 0.0)),
        (float(moves.acceleration[row]), float(moves.deceleration[row]), float(moves.rate[row])),
        _blend_of(plan, row),
        ("", ""),
    )


def _speeds(plan: Plan, row: int) -> Iterator[tuple[str, float]]:
    moves = plan.moves
    for name in ("fraction", "travel", "turn", "axis_speed", "duration"):
        value = float(getattr(moves, name)[row])
        if not math.isnan(value):
            yield name, value


def _blend_of(plan: Plan, row: int) -> tuple[int, float]:
    code, size = int(plan.moves.blend_code[row]), float(plan.moves.blend[row])
    return code, 0.0 if math.isnan(size) or code == BlendCode.EXACT else round(size, 9)


class Cause(StrEnum):
    """Why the time of a line changed; the words that reports use."""

    POINT = "point moved"
    SPEED = "speed"
    ACCELERATION = "acceleration"
    STOP = "new stop"
    NO_STOP = "stop gone"
    BLEND = "blend"
    PATH = "kind of move"
    TOOL = "tool"
    FRAME = "frame"
    WAIT = "wait"
    SIGNAL = "I/O"
    ADDED = "new line"
    REMOVED = "line gone"
    COUNT = "runs another number of times"
    NEIGHBOUR = "its neighbour changed"
    ROBOT = "robot"
    SETTINGS = "settings"
    UNKNOWN = "not known"


@dataclass(frozen=True, slots=True)
class LineChange:
    """Change of one line. `old_s`, `new_s` [s]: over all executions, 0 in the version without the line.

    `old_line`, `new_line`: 0 in the version without the line. `moved_mm`, `turned_deg`: of its target. `details`:
    "V=300 → 250".
    """

    routine: str
    old_line: int
    new_line: int
    statement: str
    kind: str
    old_s: float
    new_s: float
    cause: Cause
    details: str = ""
    moved_mm: float = 0.0
    turned_deg: float = 0.0
    file: str = ""  # name of the file that the line stands in

    @property
    def change_s(self) -> float:
        return self.new_s - self.old_s


@dataclass(frozen=True, slots=True)
class ProgramDifference:
    """Difference of one program. `changes`: lines whose time or meaning changed; all other times are equal.

    `old_s`, `new_s` [s]: totals, None where that version could not be timed (`why` is the reason); `old_ends`,
    `new_ends` [s]: their 95 % intervals, None where unknown. The errors of both versions are correlated, as they
    are of one arm: an interval is that of its total, not of the change.
    """

    file: str
    old_s: float | None
    new_s: float | None
    changes: tuple[LineChange, ...] = ()
    budgets: tuple[JudgedItem, ...] = ()
    why: str = ""
    notes: tuple[str, ...] = field(default_factory=tuple)
    old_ends: tuple[float, float] | None = None
    new_ends: tuple[float, float] | None = None

    @property
    def change_s(self) -> float | None:
        return None if self.old_s is None or self.new_s is None else self.new_s - self.old_s


_SAME_S = 1e-9  # [s] a smaller change is a rounding
_SAME_M = 1e-7  # [m]
_SAME_RAD = 1e-7
_UNITS = {
    "fraction": (0.01, "%"),
    "travel": (mm, "mm/s"),
    "turn": (deg, "deg/s"),
    "axis_speed": (deg, "deg/s"),
    "duration": (1.0, "s"),
}


def compare(file: str, old: Timing, new: Timing, programs: tuple[Program, Program]) -> ProgramDifference:
    """The changes from `old` to `new`. Their seconds add up to the change of the totals."""
    before, after = rows_of(old, programs[0]), rows_of(new, programs[1])
    # A copy under another name is still the same program.
    names = [_main(program) for program in programs]
    for row in after:
        if row.routine == names[1]:
            row.routine = names[0]
    pairs = list(align(before, after))
    own = [_own_cause(a, b) for a, b in pairs]
    elsewhere = _global_cause(old, new)
    touched = any(cause is not None for cause, _ in own)
    changes = [
        change
        for (a, b), (cause, details) in zip(pairs, own, strict=True)
        if (change := _change(a, b, cause, details, elsewhere, touched)) is not None
    ]
    notes = (*_left_out("old", old), *_left_out("new", new))
    ends = _ends(old), _ends(new)
    return ProgramDifference(file, old.total_s, new.total_s, tuple(changes), (), "", notes, *ends)


def _ends(timing: Timing) -> tuple[float, float] | None:
    """The interval that `olp time` reports; with an incomplete total only one from a recording."""
    return None if timing.left_open and timing.interval is None else timing.total_ends


def _left_out(version: str, timing: Timing) -> Iterator[str]:
    """Notes on the parts that a version's total does not include."""
    if timing.untimed:
        yield f"the {version} version: {timing.untimed} steps cannot be timed"
    broken = timing.left_open
    if broken:
        count = "1 finding" if len(broken) == 1 else f"{len(broken)} findings"
        place = f"line {broken[0].line}: " if broken[0].line else ""
        yield f"the {version} version is timed in part only, {count}: {place}{broken[0].message}"


def _main(program: Program) -> str:
    known = {routine.name for routine in program.routines}
    return program.main if program.main in known else program.routines[0].name


def _change(
    a: ComparedLine | None,
    b: ComparedLine | None,
    cause: Cause | None,
    details: str,
    elsewhere: Cause | None,
    touched: bool,
) -> LineChange | None:
    old_s, new_s = a.seconds if a else 0.0, b.seconds if b else 0.0
    if cause is None and abs(new_s - old_s) <= _SAME_S:
        return None
    if cause is None:
        cause = elsewhere or (Cause.NEIGHBOUR if touched else Cause.UNKNOWN)
    row = b or a
    assert row is not None
    moved, turned = _moved(a, b)
    return LineChange(
        row.routine,
        a.line if a else 0,
        b.line if b else 0,
        row.text,
        row.kind,
        old_s,
        new_s,
        cause,
        details,
        moved,
        turned,
        row.file,
    )


def _moved(a: ComparedLine | None, b: ComparedLine | None) -> tuple[float, float]:
    """Distance [mm] and angle [deg] between the two targets; 0 where one is unknown."""
    if a is None or b is None:
        return 0.0, 0.0
    distance = float(np.linalg.norm(a.target - b.target))
    chord = min(float(np.linalg.norm(a.turn - b.turn)), float(np.linalg.norm(a.turn + b.turn)))
    angle = 4.0 * math.asin(min(chord / 2.0, 1.0)) if math.isfinite(chord) else 0.0
    return (distance / mm if math.isfinite(distance) else 0.0), angle / deg


def _own_cause(a: ComparedLine | None, b: ComparedLine | None) -> tuple[Cause | None, str]:
    """The difference in the text of the line, as cause and details; None if there is none."""
    if a is None or b is None:
        return (Cause.ADDED if a is None else Cause.REMOVED), ""
    if a.kind != b.kind:
        return Cause.PATH, f"{a.kind} → {b.kind}"
    if a.kind in ("wait", "signal"):
        return _of_timed(a, b)
    found = [cause for cause in _of_move(a, b) if cause is not None]
    if found:
        return found[0][0], ", ".join(details for _, details in found)
    if a.count != b.count:
        return Cause.COUNT, f"{a.count} → {b.count} times"
    return None, ""


def _of_timed(a: ComparedLine, b: ComparedLine) -> tuple[Cause | None, str]:
    each = a.seconds / a.count, b.seconds / b.count
    cause = Cause.WAIT if a.kind == "wait" else Cause.SIGNAL
    if abs(each[0] - each[1]) > _SAME_S:
        return cause, f"{each[0]:.3f} → {each[1]:.3f} s"
    if a.count != b.count:
        return Cause.COUNT, f"{a.count} → {b.count} times"
    return (cause, f"{a.text} → {b.text}") if a.text != b.text else (None, "")


def _of_move(a: ComparedLine, b: ComparedLine) -> Iterable[tuple[Cause, str] | None]:
    for cause, before, after in zip((Cause.TOOL, Cause.FRAME), a.standing, b.standing, strict=True):
        if before != after and before and after:
            yield cause, f"{cause} {before} → {after}"
    yield _point(a, b)
    yield _stop(a, b)
    if a.speed != b.speed:
        yield Cause.SPEED, f"{_speed(a)} → {_speed(b)}"
    if not np.allclose(a.acceleration, b.acceleration, rtol=1e-12, atol=0.0, equal_nan=True):
        yield Cause.ACCELERATION, f"{a.acceleration[0]:.0%} → {b.acceleration[0]:.0%}"


def _point(a: ComparedLine, b: ComparedLine) -> tuple[Cause, str] | None:
    distance, angle = _moved(a, b)
    via = float(np.nan_to_num(np.linalg.norm(a.via - b.via)))
    # The point beyond the target that shapes an arc belongs to the next line where arcs are chained.
    if distance * mm > _SAME_M or angle * deg > _SAME_RAD:
        return Cause.POINT, f"{distance:.3f} mm, {angle:.3f} deg"
    if np.isnan(a.target).any() and not np.allclose(a.axes, b.axes, rtol=0.0, atol=1e-9, equal_nan=True):
        return Cause.POINT, "in joint values"
    return (Cause.POINT, f"via {via / mm:.3f} mm") if via > _SAME_M and a.text != b.text else None


def _stop(a: ComparedLine, b: ComparedLine) -> tuple[Cause, str] | None:
    if a.blend == b.blend:
        return None
    stops = a.blend[0] == BlendCode.EXACT, b.blend[0] == BlendCode.EXACT
    details = f"{_blend(a)} → {_blend(b)}"
    if stops == (False, True):
        return Cause.STOP, details
    return (Cause.NO_STOP if stops == (True, False) else Cause.BLEND), details


def _blend(row: ComparedLine) -> str:
    code, size = row.blend
    if code == BlendCode.EXACT:
        return "stop"
    return f"{size / mm:g} mm" if size else "no zone"


def _speed(row: ComparedLine) -> str:
    name, value = row.speed
    scale, unit = _UNITS.get(name, (1.0, ""))
    return f"{value / scale:g} {unit}"


def _global_cause(old: Timing, new: Timing) -> Cause | None:
    """A cause outside of the program's lines: another robot, or other settings."""
    if old.plan.robots != new.plan.robots:
        return Cause.ROBOT
    if old.plan.settings != new.plan.settings or old.model != new.model:
        return Cause.SETTINGS
    return None


# --- Matching lines ---
# Which line of the old version is which of the new one: by what the lines do, not by their numbers.

_SKIP = 1.0  # cost of a line that has no partner; a pair that costs more than two of them is none
_SMALL = 300  # lines of a gap that are aligned exactly; longer gaps pair up by their text


def align(
    old: Sequence[ComparedLine], new: Sequence[ComparedLine]
) -> Iterator[tuple[ComparedLine | None, ComparedLine | None]]:
    """Pairs of old and new rows in order, each row once. Lines that do the same are anchors; those between are
    paired.
    """
    matcher = difflib.SequenceMatcher(
        None, [r.signature for r in old], [r.signature for r in new], autojunk=False
    )
    for word, a, b, c, d in matcher.get_opcodes():
        if word == "equal":
            yield from zip(old[a:b], new[c:d], strict=True)
        else:
            yield from _gap(old[a:b], new[c:d])


def _gap(
    old: Sequence[ComparedLine], new: Sequence[ComparedLine]
) -> Iterator[tuple[ComparedLine | None, ComparedLine | None]]:
    if not old or not new:
        yield from ((row, None) for row in old)
        yield from ((None, row) for row in new)
    elif len(old) > _SMALL or len(new) > _SMALL:
        yield from _by_text(old, new)
    else:
        yield from _cheapest(old, new)


def _by_text(
    old: Sequence[ComparedLine], new: Sequence[ComparedLine]
) -> Iterator[tuple[ComparedLine | None, ComparedLine | None]]:
    """Pairs of a long gap: first rows of equal text, then the others in order."""
    matcher = difflib.SequenceMatcher(
        None, [_words(r) for r in old], [_words(r) for r in new], autojunk=False
    )
    for word, a, b, c, d in matcher.get_opcodes():
        both = min(b - a, d - c)
        if word == "equal" or word == "replace":
            yield from zip(old[a : a + both], new[c : c + both], strict=True)
        else:
            both = 0
        yield from ((row, None) for row in old[a + both : b])
        yield from ((None, row) for row in new[c + both : d])


def _words(row: ComparedLine) -> tuple[str, str, str]:
    return row.routine, row.kind, row.text


def _cheapest(
    old: Sequence[ComparedLine], new: Sequence[ComparedLine]
) -> Iterator[tuple[ComparedLine | None, ComparedLine | None]]:
    """The pairing of least cost (Needleman and Wunsch)."""
    price = np.array([[_price(a, b) for b in new] for a in old])
    table = np.zeros((len(old) + 1, len(new) + 1))
    table[:, 0] = np.arange(len(old) + 1) * _SKIP
    table[0] = np.arange(len(new) + 1) * _SKIP
    for i in range(1, len(old) + 1):
        for j in range(1, len(new) + 1):
            table[i, j] = min(
                table[i - 1, j - 1] + price[i - 1, j - 1], table[i - 1, j] + _SKIP, table[i, j - 1] + _SKIP
            )
    pairs: list[tuple[ComparedLine | None, ComparedLine | None]] = []
    i, j = len(old), len(new)
    while i or j:
        if i and j and table[i, j] == table[i - 1, j - 1] + price[i - 1, j - 1]:
            i, j = i - 1, j - 1
            pairs.append((old[i], new[j]))
        elif i and table[i, j] == table[i - 1, j] + _SKIP:
            i -= 1
            pairs.append((old[i], None))
        else:
            j -= 1
            pairs.append((None, new[j]))
    yield from reversed(pairs)


def _price(a: ComparedLine, b: ComparedLine) -> float:
    """Cost of a pair: 0 for equal lines, more than two skips for lines that cannot correspond."""
    if a.routine != b.routine or (a.kind in ("wait", "signal")) != (b.kind in ("wait", "signal")):
        return 3 * _SKIP
    if a.kind in ("wait", "signal"):
        alike = difflib.SequenceMatcher(None, a.text, b.text, autojunk=False).quick_ratio()
        return 1.9 * _SKIP * (1.0 - alike) if a.kind == b.kind else 2.5 * _SKIP
    price = 0.0 if a.kind == b.kind else 0.6
    # The name of the point and the word of the move say more than the numbers: those are what gets touched up.
    price += 0.7 * (1.0 - difflib.SequenceMatcher(None, a.text, b.text, autojunk=False).quick_ratio())
    gap = float(np.linalg.norm(a.target - b.target))
    price += 0.6 * min(gap / 0.2, 1.0) if np.isfinite(gap) else 0.0 if _same_axes(a, b) else 0.3
    price += 0.1 * (a.speed != b.speed) + 0.1 * (a.blend != b.blend)
    return price


def _same_axes(a: ComparedLine, b: ComparedLine) -> bool:
    return bool(np.allclose(a.axes, b.axes, rtol=0.0, atol=1e-9, equal_nan=True))
