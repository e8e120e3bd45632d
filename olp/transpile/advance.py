"""Where the source's controller reads ahead of the arm and has to wait for it: the move before ends exactly.

KRL's advance run stops before every statement that sets outputs or reads the periphery, whatever approximation the
move before asks for, unless CONTINUE stands before it (KSS 8, system integrators' manual, "Computer advance run").
The target's controller would pass the corner and switch early: the move gets an exact stop there. So it does before a
statement of other languages that waits until the arm stands (RAPID's WaitRob).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from olp.core.units import mm
from olp.ir import program as st
from olp.ir.expressions import Number, Quantity, Signal, SystemValue, Text
from olp.ir.transformer import expressions_of
from olp.languages.vendor import find_vendor, vendor_names
from olp.runtime.plan import BlendCode, StepKind
from olp.runtime.signals import PERIPHERY
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.current_position import reads_place
from olp.transpile.occurrences import with_routines, with_rows
from olp.transpile.reaching_definitions import UNSET, Key, reaching

_STOP: Final = st.Blend(st.BlendKind.RADIUS, Quantity(Number(0), mm))
_WAITING: Final = (st.PulseOutput, st.Wait, st.Dwell, st.Pause)
_PASSED_ON: Final = (*st.MOVES_NOTHING, *_WAITING, st.Process, st.SetOutput, st.Assign)
_ACTUAL: Final = frozenset({"current-pose", "current-joints", "timer"})
CONTINUE: Final = "continue"  # what the statement is called as which it is read and written
_WORD: Final = (("", Text("CONTINUE")),)
_SAYS: Final = "what follows waits for the arm, so it stops here whatever its blend"
_SOMETIMES: Final = "on some paths the next statement waits for the arm: an exact stop is written"
_AHEAD: Final = (
    "behind a corner, with CONTINUE: the advance run does it, up to $ADVANCE moves before the arm is there"
)
_STANDS: Final = (
    "on some paths the next statement follows an exact stop: it waits for the arm, which then stops here"
)
_READ: Final = "the arm stops here, because its position is read"
_SLOWED: Final = (
    "the advance run sets it, up to $ADVANCE moves before the arm is there: the moves before may have it, too"
)
_LAST: Final[Key] = ("last move",)
_CORNER, _STOPPED = 1, 2  # how the move before ends
_STANDING: Final = frozenset({st.Move, st.Dwell, st.Pause})
_UNSEEN: Final = "whether what follows waits for the arm is not seen in this run: the blend is written"


def stopped_advance(program: st.Program, work: TranslationContext) -> st.Program:
    """Moves that a stop of the advance run keeps from being blended end in an exact stop."""
    if program.vendor not in vendor_names():
        return program
    names = work.conventions.standing_processes
    stops = find_vendor(program.vendor).advance_stops
    if not stops and not any(_is_standing(s, names) for s in work.source.statements()):
        return program
    own = _Stops(work, waits_for_the_arm if stops else partial(_is_standing, names=names))
    # What is left out by now has stopped the arm all the same.
    called = {s.routine.casefold() for s in work.source.statements() if isinstance(s, st.Call)}
    main = (work.source.main or work.source.routines[0].name).casefold() if work.source.routines else ""
    stopped = {
        line
        for r in work.source.routines
        for line in own.stopped(r.body, r.name.casefold() == main and main not in called)
    }
    if not stopped:
        return program
    routines = []
    for routine in program.routines:
        rows = [
            replace(s, blend=_STOP) if isinstance(s, st.Move) and s.line in stopped else s
            for s in routine.body
        ]
        routines.append(with_rows(routine, rows))
    return with_routines(program, routines)


def continue_statements(program: st.Program, work: TranslationContext) -> st.Program:
    """Puts CONTINUE before statements that wait for the arm in the target, where only rounded moves lead there.

    The target's controller then runs them ahead of the arm, which the receipt tells. Where some paths of the program
    lead there from an exact stop it has to wait: else an output would switch, or an input be read, while the arm still
    moves.
    """
    if not find_vendor(work.target).advance_stops:
        return program
    moves = [s for s in program.statements() if isinstance(s, st.Move)]
    corners = {id(s): n for n, s in enumerate(moves, 1) if s.blend is None or not _is_exact(s.blend)}
    waiting = {
        (r.name, index)
        for r in program.routines
        for index, s in work.look(r).rare
        if not isinstance(s, (st.Move, st.Dwell, st.Pause)) and waits_for_the_arm(s)
    }
    if not corners or not waiting:
        return program

    def last(s: st.Statement) -> Mapping[Key, int]:
        return {_LAST: corners.get(id(s), 0)} if type(s) in _STANDING else {}  # 0: the arm stands

    ways = reaching(program, last, _STANDING)
    stopped: set[int] = set()
    read: set[int] = set()  # moves that stop, as the position is read behind them
    routines = []
    for routine in program.routines:
        rows: list[st.Statement] = []
        for index, s in enumerate(routine.body):
            if (routine.name, index) in waiting:
                before = ways.at(routine.name, index, _LAST)
                if work.conventions.waits_before_reading and reads_place(s):
                    read |= {n for n in before if n > 0}
                elif before and min(before) > 0:
                    work.lose(s, Fate.APPROXIMATED, "order", _AHEAD)
                    rows.append(st.Process(s.line, CONTINUE, _WORD))
                else:
                    stopped |= {n for n in before if n > 0}
            rows.append(s)
        routines.append(with_rows(routine, rows))
    for n in sorted(stopped):
        work.lose(moves[n - 1], Fate.APPROXIMATED, "blend", _STANDS)
    for n in sorted(read):
        work.lose(moves[n - 1], Fate.APPROXIMATED, "blend", _READ)
    return with_routines(program, routines)


def overrides_read_ahead(program: st.Program, work: TranslationContext) -> st.Program:
    """Tells where KRL's override may hold earlier than elsewhere (`overrides_ahead`)."""
    if program.vendor not in vendor_names() or find_vendor(work.target).advance_stops:
        return program
    return _with_overrides(program, work, False) if find_vendor(program.vendor).advance_stops else program


def overrides_ahead(program: st.Program, work: TranslationContext) -> st.Program:
    """An override of KRL holds as soon as the advance run comes to it, also for the moves that are under way.

    No manual at hand has `$OV_PRO` among what stops the advance run. `WAIT SEC 0` stands before one that only exact
    stops lead to, where the arm stands anyway; behind a corner it is told.
    """
    if not find_vendor(work.target).advance_stops or work.source.vendor == work.target:
        return program
    return _with_overrides(program, work, True)


def _with_overrides(program: st.Program, work: TranslationContext, waited: bool) -> st.Program:
    if not any(isinstance(s, st.SetOverride) for s in work.rare(program)):
        return program

    def last(s: st.Statement) -> Mapping[Key, int]:
        if isinstance(s, st.Move):
            return {_LAST: _STOPPED if s.blend is not None and _is_exact(s.blend) else _CORNER}
        return {_LAST: 0} if type(s) in _STANDING else {}

    ways = reaching(program, last, _STANDING)
    routines = []
    for routine in program.routines:
        rows: list[st.Statement] = []
        for index, s in enumerate(routine.body):
            before = ways.at(routine.name, index, _LAST) if isinstance(s, st.SetOverride) else frozenset()
            if _CORNER in before or (_STOPPED in before and not waited):
                work.lose(s, Fate.APPROXIMATED, "order", _SLOWED)
            elif _STOPPED in before:
                rows.append(st.Dwell(s.line, Quantity(Number(0), 1.0)))
            rows.append(s)
        routines.append(with_rows(routine, rows) if len(rows) != len(routine.body) else routine)
    return with_routines(program, routines)


def needless_stands(program: st.Program, work: TranslationContext) -> st.Program:
    """Without the statements that only wait until the arm stands, where it stands on every way that leads there.

    Those of KRL stop the advance run, too, and stay. A routine that nothing calls may begin at any time, as that of an
    interrupt does.
    """
    if work.source.vendor == work.target or find_vendor(work.target).advance_stops:
        return program
    stand = work.limits.stand
    first = program.main or (program.routines[0].name if program.routines else "")
    if not any(_only_stands(s, stand) for s in work.rare(program)):
        return program
    moves = [s for s in program.statements() if isinstance(s, st.Move)]
    passed = {
        id(s): n for n, s in enumerate(moves, 1) if s.no_wait or s.blend is None or not _is_exact(s.blend)
    }
    kinds = frozenset({st.Move, st.Pause, st.Process if stand else st.Dwell})

    def last(s: st.Statement) -> Mapping[Key, int]:
        if type(s) is st.Process and s.name != stand:
            return {}
        return {_LAST: passed.get(id(s), 0)} if type(s) in kinds else {}  # 0: the arm stands

    ways = reaching(program, last, kinds)
    routines = []
    for routine in program.routines:
        standing = {0, UNSET} if routine.name == first else {0}
        rows: list[st.Statement] = []
        for index, s in enumerate(routine.body):
            if not (_only_stands(s, stand) and ways.at(routine.name, index, _LAST) <= standing):
                rows.append(s)
            elif comment := getattr(s, "comment", ""):
                rows.append(st.Comment(s.line, comment))
        routines.append(with_rows(routine, rows) if len(rows) != len(routine.body) else routine)
    return with_routines(program, routines)


def _only_stands(s: st.Statement, stand: str) -> bool:
    """Whether a statement does nothing but wait for the arm. `stand`: the target's word for that."""
    if type(s) is st.Process:
        return bool(stand) and s.name == stand
    return type(s) is st.Dwell and s.duration.literal == 0.0


def _is_standing(s: st.Statement, names: Set[str]) -> bool:
    return isinstance(s, st.Process) and s.name.casefold() in names


class _Stops:
    def __init__(self, work: TranslationContext, waits: Callable[[st.Statement], bool]) -> None:
        self._work, self._waits = work, waits
        self._runs: dict[int, set[bool]] | None = None

    def stopped(self, rows: Sequence[st.Statement], is_main: bool) -> Iterator[int]:
        """The lines of moves that lose their blend. `is_main`: nothing runs after these rows."""
        for at, s in enumerate(rows):
            if not isinstance(s, st.Move) or s.blend is None or _is_exact(s.blend):
                continue
            stops = self._stops_behind(rows, at, is_main)
            if stops is None:
                stops = self._in_the_run(s)
            if stops:
                self._work.note_at(s, _SAYS)
                yield s.line

    def _stops_behind(self, rows: Sequence[st.Statement], at: int, is_main: bool) -> bool | None:
        """Whether what follows a move waits for the arm before the next move; None where the text does not show it."""
        continued = False
        for index in range(at + 1, len(rows)):  # no copy of the rest for each move of a long program
            s = rows[index]
            if isinstance(s, st.Process) and s.name == CONTINUE:
                continued = True
                continue
            if isinstance(s, st.Move) or (is_main and isinstance(s, st.End)):
                return False
            if not continued and self._waits(s):
                return True
            if not isinstance(s, _PASSED_ON):
                return None
            continued = continued and isinstance(s, st.Comment)
        return False if is_main else None

    def _in_the_run(self, s: st.Move) -> bool:
        """Whether the run of the source stops at a move, where the text does not show what follows it."""
        seen = self._seen().get(s.line, set())
        if len(seen) > 1:
            self._work.lose(s, Fate.APPROXIMATED, "blend", _SOMETIMES)
        elif not seen:
            self._work.lose(s, Fate.APPROXIMATED, "blend", _UNSEEN)
        return True in seen

    def _seen(self) -> dict[int, set[bool]]:
        """Line -> whether its moves ended exactly."""
        if self._runs is None:
            self._runs = {}
            plan = self._work.plan()
            if plan is not None:
                steps = np.flatnonzero((plan.kind == StepKind.MOVE) & (plan.source == 0))
                exact = plan.moves.blend_code[plan.row[steps]] == BlendCode.EXACT
                for line, stopped in zip(plan.line[steps].tolist(), exact.tolist(), strict=True):
                    self._runs.setdefault(line, set()).add(stopped)
        return self._runs


def _is_exact(blend: st.Blend) -> bool:
    return blend.value is not None and blend.value.literal is not None and blend.value.literal <= 0.0


def waits_for_the_arm(s: st.Statement) -> bool:
    """Whether a statement sets or reads what belongs to the moment when it runs."""
    if isinstance(s, _WAITING):
        return True
    if isinstance(s, (st.Process, *st.MOVES_NOTHING)):
        return False
    return any(
        e.bus in PERIPHERY if isinstance(e, Signal) else isinstance(e, SystemValue) and e.name in _ACTUAL
        for e in expressions_of(s)
    )
