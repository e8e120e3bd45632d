"""W008 and W013: points that nothing uses, and points that are taught twice."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from olp.checks.lint.rule import LintCase, Rule, mentioned, routines
from olp.ir.expressions import Named, Store
from olp.ir.points import PointKind
from olp.ir.program import Declare, Routine
from olp.reports.outcome.model import Level, OutcomeFinding

_SAME = 1e-6  # [m] and [rad]; pulses are whole numbers


class UnusedPoint(Rule):
    """A taught point that no statement names."""

    code = "W008"
    title = "unused point"
    level = Level.NOTE
    why = "No move uses the point: it is left over, or the move was lost. Touching it up has no effect."
    example = "C00007=…   and no MOVL C00007"
    better = "delete the point, or move to it"
    fixable = True

    def find(self, case: LintCase) -> Iterator[OutcomeFinding]:
        for routine in routines(case):
            used = {
                (p.store, p.number) for s in routine.body for p in mentioned(s) if not isinstance(p, Named)
            }
            for (store, taught), block in routine.points.blocks.items():
                if not taught or store is not Store.ROBOT:
                    continue
                for number, row in sorted(block.rows.items()):
                    if (store, number) not in used:
                        says = f"point {number} is taught and never used"
                        yield self.finding(case, int(block.lines[row]), says, "delete it, or move to it")
            yield from self._named(case, routine)

    def _named(self, case: LintCase, routine: Routine) -> Iterator[OutcomeFinding]:
        """Unused declared points of this routine, in languages where points have names."""
        own = [s for s in routine.body if isinstance(s, Declare) and _is_own(s)]
        if not own:
            return
        used = {p.name.casefold() for s in routine.body for p in mentioned(s) if isinstance(p, Named)}
        for s in own:
            if s.name.casefold() not in used and s.line:
                says, text = f"{s.name} is declared and never used", case.text(s.line)
                # One declaration on one line; what its lines are is known of no longer one.
                alone = sum(other.line == s.line for other in routine.body) == 1
                whole = s.name.casefold() in text.casefold() and text.count("{") == text.count("}")
                fixes = ((s.line, s.line, ""),) if alone and whole else ()
                yield self.finding(case, s.line, says, "delete it, or move to it", fixes=fixes)


def _is_own(s: Declare) -> bool:
    """Whether a declared point is visible in this file only, or in its routine."""
    return s.type in ("position", "joints") and not s.shared


class DuplicatedPoint(Rule):
    """Two points with the same values."""

    code = "W013"
    title = "duplicated point"
    level = Level.NOTE
    why = (
        "Two points with the same values, frame and tool are most often one position that was taught twice. Touching "
        "up one leaves the other where it was."
    )
    example = "C00003=…  and C00009=… with the same numbers"
    better = "move to C00003 twice"

    def find(self, case: LintCase) -> Iterator[OutcomeFinding]:
        for routine in routines(case):
            block = routine.points.blocks.get((Store.ROBOT, True))
            if block is None or len(block) > 5000:  # a generated path: nobody touches its points up
                continue
            seen: dict[tuple[object, ...], int] = {}
            for number, row in sorted(block.rows.items()):
                state = routine.points.states[int(block.state[row])]
                step = 1.0 if state.kind is PointKind.PULSE else _SAME
                key = (state, *np.round(np.nan_to_num(block.values[row]) / step).tolist())
                first = seen.setdefault(key, number)
                if first != number:
                    says = f"point {number} is the same as point {first}"
                    yield self.finding(case, int(block.lines[row]), says, f"move to point {first} instead")
