"""Positions of which components are left out (KRL): those stay as they are, which no other language can say."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, TypeVar

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import calls_nothing, edited, expressions_of, mapped
from olp.runtime.plan import Plan, StepKind
from olp.transpile.context import BESIDE, Fate, TranslationContext
from olp.transpile.occurrences import changed_rare
from olp.transpile.symbols import Symbols, base_of

_STEADY: Final = (
    st.Comment,
    st.Dwell,
    st.SetOutput,
    st.Declare,
)  # leave the arm, its tool and its frame where they are
_SAME: Final = 1e-9  # [rad]
_PLACE: Final = ("x", "y", "z")
_ANGLES: Final = ("rx", "ry", "rz")
_S = TypeVar("_S", bound=st.Statement)
_NOWHERE: Final = ex.PositionLiteral("pose", (0.0,) * 6)
_COMPUTED: Final = {"pose-angles": "pose", "joints": "joint"}  # functions of six components
_READ: Final = {"pose": ("position", "current-pose"), "joint": ("joints", "current-joints")}


def component(position: ex.Expression, kind: str, at: int) -> ex.Expression:
    """One of the six components of a pose or of joint values (kind), counted from 0."""
    return (
        ex.Item(position, (ex.Number(at + 1),))
        if kind == "joint"
        else ex.Member(position, (*_PLACE, *_ANGLES)[at])
    )


def written_component(value: float, kind: str, at: int) -> ex.Number:
    """A component [m or rad] as programs count it [mm or degrees]."""
    number = round(value / (mm if kind == "pose" and at < len(_PLACE) else deg), 9)
    return ex.Number(int(number) if number.is_integer() else number)


def partial_targets(program: st.Program, work: TranslationContext) -> st.Program:
    """Targets with components left open get them from the move before, or by a reading when the arm is there.

    Where the target's language has no single axes, those of the run are written; else such targets are refused.
    """
    if not work.conventions.partial_targets or not any(_leaves_out(r, work) for r in program.routines):
        return _whole_data(program, work)
    own = _Partial(work, work.symbols(program))
    routines = tuple(replace(r, body=tuple(own.rows(r))) for r in program.routines)
    return _whole_data(replace(program, routines=routines, data=(*program.data, *own.declared)), work)


@dataclass(slots=True)
class _Partial:
    work: TranslationContext
    symbols: Symbols
    last: ex.PositionLiteral | None = None  # where the move before went, as the text tells
    declared: list[st.Declare] = field(default_factory=list)  # positions that are put together
    _axes: dict[int, list[Sequence[float]]] | None = field(default=None)

    def rows(self, routine: st.Routine) -> list[st.Statement]:
        self.last = None
        rows: list[st.Statement] = []
        for s in routine.body:
            if isinstance(s, st.Move):
                rows += self._move(s, routine.name)
            else:
                self.last = self.last if isinstance(s, _STEADY) else None
                if _has_gaps(s):
                    self.work.lose(s, Fate.REFUSED, "position", _SAYS)
                rows.append(s)
        return rows

    def _move(self, s: st.Move, routine: str) -> list[st.Statement]:
        before: list[st.Statement] = []
        if _has_gaps(s):
            via = None if s.via is None else self._filled(s.via, s)
            s = edited(s, {"targets": tuple(self._filled(t, s) for t in s.targets), "via": via})
            if _has_gaps(s) and len(s.targets) == 1:
                target = self._put_together(s.targets[0], s, before)
                via = None if s.via is None else self._put_together(s.via, s, before)
                s = edited(s, {"targets": (target,), "via": via})
            if _has_gaps(s):
                self.work.lose(s, Fate.REFUSED, "position", _SAYS)
        end = self.symbols.fixed_value(routine, s.targets[-1])
        self.last = end if isinstance(end, ex.PositionLiteral) and not s.relative else None
        return [*before, s]

    def _put_together(self, e: ex.Expression, s: st.Move, before: list[st.Statement]) -> ex.Expression:
        """Where the arm is when it comes to a move, with the components that are written."""
        written = _written(e)
        if written is None:
            return e
        of, values = written
        name = ex.Named(self.work.helper("target"))
        kind, reading = _READ[of]
        self.declared.append(st.Declare(0, name.name, kind, shared=True))
        before.append(st.Assign(s.line, name, ex.SystemValue(reading)))
        before += [st.Assign(s.line, component(name, of, at), value) for at, value in values]
        return name

    def _filled(self, e: ex.Expression, s: st.Move) -> ex.Expression:
        if not isinstance(e, ex.PositionLiteral) or not _is_partial(e):
            return e
        before = self.last
        if before is not None and before.kind == e.kind and not _is_partial(before):
            return _joined(e, before.values)
        registers = self.work.limits.registers
        if e.kind != "joint" or registers is None or not registers.joint_elements:
            return e
        run = self._run_of(s.line)
        if run is None:
            return e
        says = "its other axes stay as they are: written as this run has them there"
        self.work.lose(s, Fate.APPROXIMATED, "position", says)
        return _joined(e, run)

    def _run_of(self, line: int) -> Sequence[float] | None:
        """[rad] the axes at the end of a move, where all its executions have the same ones."""
        if self._axes is None:
            plan = self.work.plan()
            self._axes = {} if plan is None else _axes_by_line(plan)
        rows = self._axes.get(line, [])
        if not rows or any(map(math.isnan, rows[0][:6])):
            return None
        if any(abs(a - b) > _SAME for row in rows[1:] for a, b in zip(row, rows[0], strict=True)):
            return None
        return rows[0]


def _written(e: ex.Expression) -> tuple[str, list[tuple[int, ex.Expression]]] | None:
    """ "pose" or "joint", and the components that a partial target writes; None of any other expression."""
    if isinstance(e, ex.PositionLiteral) and _is_partial(e) and e.kind in _READ:
        return e.kind, [
            (at, written_component(v, e.kind, at)) for at, v in enumerate(e.values[:6]) if not math.isnan(v)
        ]
    if (
        isinstance(e, ex.Function)
        and e.name in _COMPUTED
        and len(e.arguments) == 6
        and any(map(_is_partial, e.arguments))
    ):
        return _COMPUTED[e.name], [(at, v) for at, v in enumerate(e.arguments) if not _is_partial(v)]
    return None


def computed_axes(program: st.Program, work: TranslationContext) -> st.Program:
    """Joint values of which some are computed, axis by axis, where a position is a register of elements."""
    registers = work.limits.registers
    if registers is None or registers.joint_elements:
        return program
    declared: list[st.Declare] = []
    routines = []
    for routine in program.routines:
        rows: list[st.Statement] = []
        for s in routine.body:
            e = s.targets[0] if isinstance(s, st.Move) and s.relative is None else getattr(s, "value", None)
            if not isinstance(s, (st.Assign, st.Move)) or not _is_axes(e):
                rows.append(s)
                continue
            assert isinstance(e, ex.Function)
            own = (
                isinstance(s, st.Assign)
                and isinstance(s.target, ex.Named)
                and s.target not in expressions_of(e)
            )
            name = s.target if own and isinstance(s, st.Assign) else ex.Named(work.helper("target"))
            rows.append(st.Assign(s.line, name, ex.SystemValue("current-joints"), s.comment if own else ""))
            rows += [
                st.Assign(s.line, component(name, "joint", at), one) for at, one in enumerate(e.arguments)
            ]
            if not own:
                declared.append(st.Declare(0, getattr(name, "name", ""), "joints", shared=True))
                rows.append(
                    edited(s, {"targets": (name,)}) if isinstance(s, st.Move) else replace(s, value=name)
                )
        routines.append(replace(routine, body=tuple(rows)))
    return replace(program, routines=tuple(routines), data=(*program.data, *declared))


def _is_axes(e: object) -> bool:
    return (
        isinstance(e, ex.Function)
        and e.name == "joints"
        and len(e.arguments) == 6
        and not any(map(_is_partial, e.arguments))
    )


_SAYS: Final = "omitted components are those of the current position: write them all"


def _axes_by_line(plan: Plan) -> dict[int, list[Sequence[float]]]:
    found: dict[int, list[Sequence[float]]] = {}
    axes = plan.positions.axes[plan.moves.target]
    for step in ((plan.kind == StepKind.MOVE) & (plan.source == 0)).nonzero()[0].tolist():
        found.setdefault(int(plan.line[step]), []).append(axes[int(plan.row[step])].tolist())
    return found


def _joined(e: ex.PositionLiteral, values: Sequence[float]) -> ex.PositionLiteral:
    pairs = zip(e.values, values, strict=False)
    return replace(e, values=tuple(b if math.isnan(a) else a for a, b in pairs))


def _leaves_out(routine: st.Routine, work: TranslationContext) -> bool:
    look = work.look(routine)
    return any(map(_has_gaps, look.direct())) or any(_has_gaps(s) for _, s in look.rare)


def _has_gaps(s: st.Statement) -> bool:
    if type(s) is st.Move:
        if type(s.targets[0]) is ex.Named and s.via is None:
            return False
    elif isinstance(s, (st.Comment, st.Declare)):
        return False
    return any(map(_is_partial, expressions_of(s)))


def _is_partial(e: ex.Expression) -> bool:
    """Whether a position, or a component of one that is computed, has a value left out."""
    if type(e) is ex.Number:
        return e.value != e.value
    if type(e) is not ex.PositionLiteral:
        return False
    total = sum(e.values[:6])  # one number to look at: there are as many as points
    return total != total and any(v != v for v in e.values[:6])


def _whole_data(program: st.Program, work: TranslationContext) -> st.Program:
    """Zeros for what the value of a declaration leaves out."""

    def whole(d: st.Declare) -> st.Declare:
        if type(d.value) is not ex.PositionLiteral or not _is_partial(d.value):
            return d
        work.lose(d, Fate.APPROXIMATED, "value", f"components of {d.name} are left out: zeros are declared")
        values = tuple(0.0 if v != v else v for v in d.value.values)
        return replace(d, value=replace(d.value, values=values))

    def row(s: st.Statement) -> st.Statement:
        return whole(s) if type(s) is st.Declare else s

    routines = tuple(
        replace(changed_rare(r, work.look(r), row), data=tuple(map(whole, r.data))) for r in program.routines
    )
    return replace(program, routines=routines, data=tuple(map(whole, program.data)))


# --- Externals ---
# External axes of positions (E1, extax): for languages where a track or a station is an arm of its own, or none.


_TURN: Final = 360.0  # [deg]
_UNITS_ARE_ASKED: Final = (
    "see which external axes slide and which turn: the units are taken from their values"
)
_ARM_ALONE: Final = (
    "make something else move the external axes in the comments; where one carries the arm, teach anew"
)
_UNITS_ARE_OPEN: Final = "the program does not say which external axes slide [mm] and which turn [deg]"


def externals(program: st.Program, work: TranslationContext) -> st.Program:
    """Drops external axes that are zero in all positions; others stay, or become comments where the target has none.

    Where the target has external axes and their unit has to be known, the values decide whether it is mm or deg.
    """
    says = work.limits.no_external_axes
    if not (says or work.limits.external_axes):
        says = "external axes: positions have none there"
    if not any(e.external for e in work.literals(program)):
        return program
    if not says:
        # Of an axis that stands at zero in one position alone, the zero is where it goes.
        count = _moving(_farthest(work.literals(program)))
        return _everywhere(program, lambda e: _without(e, count))
    if work.limits.external_units:
        return _with_units(program, work)
    return _arm_alone(program, work, says)


def _arm_alone(program: st.Program, work: TranslationContext, says: str) -> st.Program:
    """The arm's own moves, with comments that say where axes beside it go: a person makes something else move them.

    Refused where no comment may stand for what is lost.
    """
    count = _moving(_farthest(work.literals(program)))
    symbols = work.symbols(program)
    held = _holding_places(program, count) if count else set()
    routines = []
    for routine in program.routines if count else ():
        rows: list[st.Statement] = []
        for s in routine.body:
            places = [
                place for e in _positions(s) if (place := _place_beside(e, symbols, routine.name, count))
            ]
            if not places and isinstance(s, st.Move) and not held.isdisjoint(_bases(s)):
                places = [()]  # which of them it is turns out while the program runs
            if places and work.context.on_loss != "comment":
                work.lose(s, Fate.REFUSED, "external", says)
            elif places:
                work.lose(s, Fate.APPROXIMATED, BESIDE, f"{says}: the arm's part alone is written")
                work.ask(_ARM_ALONE, routine.name)
            if places and isinstance(s, st.Move):
                end = _place_beside(s.targets[0], symbols, routine.name, count) or places[0]
                rows += [st.Comment(s.line, text) for text in _named_axes(end, work)]
            rows.append(s)
        routines.append(replace(routine, body=tuple(rows)))
    return _everywhere(replace(program, routines=tuple(routines)) if count else program, _without)


def _holding_places(program: st.Program, count: int) -> set[str]:
    """Variables, case folded, that may hold positions with one of the first `count` external axes."""
    declared = [d for r in program.routines for d in (*r.data, *r.body) if isinstance(d, st.Declare)]
    given = [(d.name, d.value) for d in (*program.data, *declared) if d.value is not None]
    for s in program.statements():
        if isinstance(s, st.Assign) and (base := base_of(s.target)) is not None:
            given.append((base.name, s.value))
    held: set[str] = set()
    size = -1
    while size < len(held):
        size = len(held)
        for name, value in given:
            literals = (e for e in expressions_of(value) if type(e) is ex.PositionLiteral)
            if any(v == v for e in literals for v in e.external[:count]) or not held.isdisjoint(
                _bases(value)
            ):
                held.add(name.casefold())
    return held


def _bases(s: st.Move | ex.Expression) -> set[str]:
    """The names, case folded, by which a move or a value says a position."""
    inside = (s.targets if s.via is None else (*s.targets, s.via)) if isinstance(s, st.Move) else (s,)
    return {e.name.casefold() for one in inside for e in expressions_of(one) if type(e) is ex.Named}


def _place_beside(e: ex.Expression, symbols: Symbols, routine: str, count: int) -> tuple[float, ...]:
    """[mm or deg] where the first `count` external axes of a position stand, nan where it says nothing; else ()."""
    value = symbols.fixed_value(routine, e)
    found = value.external[:count] if type(value) is ex.PositionLiteral else ()
    return found if any(v == v for v in found) else ()


def _named_axes(place: tuple[float, ...], work: TranslationContext) -> Iterator[str]:
    """Where each external axis stands, in words that are short enough for the comments of each language."""
    units = dict(work.external_units)
    for n, value in enumerate(place, 1):
        if value == value:
            yield f"external axis {n}: {value:.8g} {units.get(f'E{n}', '')}".rstrip()


def _with_units(program: st.Program, work: TranslationContext) -> st.Program:
    """External axes with a unit: one whose values exceed a turn slides, any other turns, and the receipt asks."""
    farthest = _farthest(work.literals(program))
    count = _moving(farthest)
    most = work.limits.external_units
    if count > most:
        _refuse_beyond(program, most, work)
        count = _moving(farthest[:most])
    program = _everywhere(program, lambda e: _without(e, count))
    if not count:
        return program
    if work.external_units:  # the source tells them
        return program
    units = tuple((f"E{n}", "mm" if value > _TURN else "deg") for n, value in enumerate(farthest[:count], 1))
    work.external_units = units
    for name, unit in units:
        way = "slides" if unit == "mm" else "turns"
        work.ask(_UNITS_ARE_ASKED, f"{name} {way} [{unit}]")
    symbols = work.symbols(program)
    for routine in program.routines:
        for s in routine.body:
            if any(_stands(e, symbols, routine.name) for e in _positions(s)):
                work.lose(s, Fate.APPROXIMATED, "external", _UNITS_ARE_OPEN)
    return program


def _farthest(found: Iterable[ex.PositionLiteral]) -> list[float]:
    """[mm or deg] how far from zero each external axis is in any position."""
    farthest: list[float] = []
    for e in found:
        farthest += [0.0] * (len(e.external) - len(farthest))
        for at, value in enumerate(e.external):
            farthest[at] = max(farthest[at], abs(value) if value == value else 0.0)
    return farthest


def _moving(farthest: Sequence[float]) -> int:
    """How many external axes there are up to the last one that does not stand at zero in all positions."""
    return max((at for at, value in enumerate(farthest, 1) if value), default=0)


def _refuse_beyond(program: st.Program, most: int, work: TranslationContext) -> None:
    """Statements with positions in which an axis beyond the first `most` external ones does not stand at zero."""
    symbols = work.symbols(program)
    for routine in program.routines:
        for s in routine.body:
            if any(_stands(e, symbols, routine.name, most) for e in _positions(s)):
                work.lose(s, Fate.REFUSED, "external", f"more than {most} external axes")


def _everywhere(program: st.Program, change: Callable[[ex.Expression], ex.Expression]) -> st.Program:
    routines = tuple(
        replace(
            r,
            body=tuple([mapped(s, change) for s in r.body]),
            data=tuple([mapped(d, change) for d in r.data]),
        )
        for r in program.routines
    )
    return replace(program, data=tuple([mapped(d, change) for d in program.data]), routines=routines)


def _positions(s: st.Statement) -> tuple[ex.Expression, ...]:
    """Whatever in a statement may hold a position."""
    if calls_nothing(s):
        assert isinstance(s, st.Move)
        return s.targets
    return tuple(expressions_of(s))


def _stands(e: ex.Expression, symbols: Symbols, routine: str, first: int = 0) -> bool:
    """Whether a position has an external axis behind the `first` ones that is not at zero."""
    value = symbols.fixed_value(routine, e)
    return type(value) is ex.PositionLiteral and any(v == v and v != 0.0 for v in value.external[first:])


def _without(e: ex.Expression, count: int = 0) -> ex.Expression:
    """A position with the first `count` of its external axes."""
    return replace(e, external=e.external[:count]) if type(e) is ex.PositionLiteral and e.external else e


# --- Angles of one position ---


def combined_turns(program: st.Program, work: TranslationContext) -> st.Program:
    """Angles of a position that are set one after the other are set at once, where the target holds a turn as a whole.

    One by one each would be made anew of the others, which has no one answer where the second angle is 90 degrees.
    """
    if not work.limits.angles_together:
        return program
    routines = tuple(
        replace(r, body=tuple(_together(r.body))) if _sets_angles(r) else r for r in program.routines
    )
    return _with_turns(replace(program, routines=routines), work)


def _with_turns(program: st.Program, work: TranslationContext) -> st.Program:
    """A turn of zero for positions without a first value of which the program reads or sets single angles.

    A quaternion of four zeros, as it begins otherwise, is no turn: functions that take it stop the program.
    """
    turned = {
        e.base.name
        for r in program.routines
        for e in work.look(r).expressions
        if isinstance(e, ex.Member) and e.name in _ANGLES and type(e.base) is ex.Named
    }
    if not turned:
        return program

    def row(s: _S) -> _S:
        if not isinstance(s, st.Declare) or s.name not in turned:
            return s
        bare = s.value is None and not s.sizes and s.type == "position"
        return replace(s, value=_NOWHERE) if bare else s

    routines = tuple(
        replace(r, body=tuple(map(row, r.body)), data=tuple(map(row, r.data))) for r in program.routines
    )
    return replace(program, routines=routines, data=tuple(map(row, program.data)))


def _sets_angles(routine: st.Routine) -> bool:
    return any(type(s) is st.Assign and _angle_of(s) for s in routine.body)


def _angle_of(s: st.Assign) -> str:
    return s.target.name if isinstance(s.target, ex.Member) and s.target.name in _ANGLES else ""


def _together(body: Sequence[st.Statement]) -> list[st.Statement]:
    rows: list[st.Statement] = []
    group: list[st.Assign] = []
    between: list[st.Statement] = []  # comments within a group

    def close() -> None:
        rows.extend([_at_once(group)] if len(group) > 1 else group)
        rows.extend(between)
        group.clear()
        between.clear()

    for s in body:
        if group and isinstance(s, st.Comment):
            between.append(s)
        elif type(s) is st.Assign and _angle_of(s):
            if group and not _joins(s, group):
                close()
            group.append(s)
        else:
            close()
            rows.append(s)
    close()
    return rows


def _joins(s: st.Assign, group: Sequence[st.Assign]) -> bool:
    """Whether an angle belongs to the same position and is computed from nothing that the group has set."""
    base = _base(s)
    read = {repr(e) for e in (s.value, *expressions_of(s.value))}
    return (
        (isinstance(base, ex.Named) or (isinstance(base, ex.Item) and all(map(_is_steady, base.indices))))
        and base == _base(group[0])
        and not any(one.target == s.target or repr(one.target) in read for one in group)
        and not any(isinstance(e, ex.CallValue) for e in expressions_of(s))
    )


def _is_steady(index: ex.Expression) -> bool:
    return isinstance(index, (ex.Number, ex.Named))


def _base(s: st.Assign) -> ex.Expression | None:
    return s.target.base if isinstance(s.target, ex.Member) else None


def _at_once(group: Sequence[st.Assign]) -> st.Assign:
    base = _base(group[0])
    assert base is not None
    given = {_angle_of(s): s.value for s in group}
    place = tuple(ex.Member(base, name) for name in _PLACE)
    turn = tuple(given.get(name, ex.Member(base, name)) for name in _ANGLES)
    comment = ", ".join(dict.fromkeys(s.comment.strip() for s in group if s.comment))
    value = ex.Function("pose-angles", (*place, *turn))
    return replace(group[-1], target=base, value=value, comment=comment)
