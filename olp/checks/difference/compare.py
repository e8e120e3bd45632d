"""Two timed versions of one program, compared line by line."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from olp.checks.difference.model import Cause, LineChange, ProgramDifference
from olp.checks.difference.rows import ComparedLine, rows_of
from olp.core.units import deg, mm
from olp.ir.program import Program
from olp.runtime.plan import BlendCode
from olp.timing.timing import Timing

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
    """What changed from `old` to `new`. The changes' seconds add up to the change of the totals."""
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
    """As `olp time` tells them: of a total that leaves something out only what was recorded says anything."""
    return None if timing.left_open and timing.interval is None else timing.total_ends


def _left_out(version: str, timing: Timing) -> Iterator[str]:
    """What a version's total leaves out."""
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
    """[mm], [deg] between the two targets; 0 where one is not known."""
    if a is None or b is None:
        return 0.0, 0.0
    distance = float(np.linalg.norm(a.target - b.target))
    chord = min(float(np.linalg.norm(a.turn - b.turn)), float(np.linalg.norm(a.turn + b.turn)))
    angle = 4.0 * math.asin(min(chord / 2.0, 1.0)) if math.isfinite(chord) else 0.0
    return (distance / mm if math.isfinite(distance) else 0.0), angle / deg


def _own_cause(a: ComparedLine | None, b: ComparedLine | None) -> tuple[Cause | None, str]:
    """What the line itself says differently, None where it says the same."""
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
    """A reason outside of the program's lines: another robot, or other settings."""
    if old.plan.robots != new.plan.robots:
        return Cause.ROBOT
    if old.plan.settings != new.plan.settings or old.model != new.model:
        return Cause.SETTINGS
    return None


# --- Align ---
# Which line of the old version is which of the new one: by what the lines do, not by their numbers.

_SKIP = 1.0  # cost of a line that has no partner; a pair that costs more than two of them is none
_SMALL = 300  # lines of a gap that are aligned exactly; longer gaps pair up by their text


def align(
    old: Sequence[ComparedLine], new: Sequence[ComparedLine]
) -> Iterator[tuple[ComparedLine | None, ComparedLine | None]]:
    """Pairs in order; each row comes once. Lines that do the same are anchors, those between pair up."""
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
    """A long gap: first by the same text, what is left by order."""
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
    """0 for the same, more than two skips for what cannot be the same line."""
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
