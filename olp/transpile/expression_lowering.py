"""Numbered points, variables and arguments become named ones, so that all further passes see one kind of program."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeGuard

from olp.core.diagnostic import OlpError
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointKind, PointState, PointTable
from olp.ir.transformer import calls_nothing, expressions_of, mapped, sets_numbers
from olp.languages.limits import limits_of
from olp.runtime.assumptions import Given
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.first_values import (
    POSE_ELEMENTS,
    Unset,
    label_of,
    read_by,
    saved_number,
    saved_points,
    saved_values,
)
from olp.transpile.move_lowering import Points, carried_systems, framed_shift, has_names, lifted_move
from olp.transpile.occurrences import with_rows
from olp.transpile.reaching_definitions import UNSET, Key, reaching
from olp.transpile.symbols import STORED

_COMPUTED_ELEMENT: Final = "an element of a position by a computed number"
LETTERS: Final = {
    ex.Store.BYTE: "B",
    ex.Store.INTEGER: "I",
    ex.Store.DOUBLE: "D",
    ex.Store.REAL: "R",
    ex.Store.STRING: "S",
    ex.Store.ROBOT: "PV",
    ex.Store.BASE: "BPV",
    ex.Store.STATION: "EPV",
    ex.Store.SYSTEM: "PX",
}
_ZEROS: Final[dict[str, ex.Expression]] = {
    "integer": ex.Number(0),
    "real": ex.Number(0.0),
    "string": ex.Text(""),
    "boolean": ex.SignalState(False),
    "position": ex.PositionLiteral("pose", (0.0,) * 6),
    "joints": ex.PositionLiteral("joint", (0.0,) * 6),
}
_JOINTS: Final = frozenset({PointKind.JOINT, PointKind.PULSE})
_POSES: Final = frozenset({PointKind.POSE})
_KINDS: Final = {"position-pulse": PointKind.PULSE, "current-joints": PointKind.JOINT}  # where the arm stands
_ELEMENTS: Final = (*POSE_ELEMENTS, "e1", "e2")
_SYSTEM: Final = {"position-pose": "current-pose", "position-pulse": "current-joints"}
_LARGEST_ARRAY: Final = 100
_POSE: Final = frozenset(POSE_ELEMENTS)


def _is_integer(e: ex.Expression | None) -> bool:
    if isinstance(e, ex.Variable):
        return STORED.get(e.store) == "integer"
    return isinstance(e, ex.Element) or (isinstance(e, ex.Number) and isinstance(e.value, int))


def _numbers_of(vendor: str) -> Mapping[ex.Store, int]:
    """How many variables of each kind the controllers of a language have."""
    try:
        return limits_of(vendor).numbered
    except OlpError:
        return {}  # a language that is only read


def named_data(program: st.Program, work: TranslationContext) -> st.Program:
    """Numbered points, variables and arguments get names. A program without any is returned as it is."""
    lifted = _NamedData(program, work)
    routines = tuple(map(lifted.routine, program.routines, lifted.expressions))
    Unset(program, work, lifted.variable, lifted.begins, lifted.is_set).tell()
    data = (*program.data, *lifted.points.declared, *lifted.global_data())
    work.states = {name: state.frame for name, state in lifted.points.states.items()}
    if lifted.joints:
        routines = tuple(map(lifted.with_axes, routines))
    made = replace(program, routines=routines, data=data)
    return carried_systems(made, lifted.points.states, lifted.rows, work)


@dataclass(slots=True)
class _NamedData:
    program: st.Program
    work: TranslationContext
    points: Points = field(init=False)
    expressions: list[list[ex.Expression]] = field(
        default_factory=list
    )  # of each routine, without those of plain moves
    names: dict[tuple[str, ex.Store, int], ex.Named] = field(
        default_factory=dict
    )  # routine ("" global), kind, number
    arrays: dict[tuple[str, ex.Store], ex.Named] = field(default_factory=dict)
    largest: dict[tuple[str, ex.Store], int] = field(default_factory=dict)
    initial: dict[str, ex.Expression] = field(default_factory=dict)
    kinds: dict[str, set[PointKind]] = field(
        default_factory=dict
    )  # of the values that position variables are set to
    array_initial: list[st.Assign] = field(default_factory=list)
    saved: Mapping[tuple[ex.Store, int], Given] = field(default_factory=dict)  # what the controller keeps
    whole: frozenset[int] = frozenset()  # real registers that only ever hold whole numbers
    scope: str = ""
    parameters: tuple[st.Parameter, ...] = ()  # of the routine that is translated
    line: int = 0  # of the statement that is translated
    changed: dict[ex.Expression, frozenset[str]] | None = (
        None  # a variable -> its components that statements set
    )
    returned: ex.Named | None = None
    joints: set[str] = field(default_factory=set)  # variables that are declared as axis values
    rows: dict[str, set[PointState]] = field(
        default_factory=dict
    )  # of the first values of position variables

    def __post_init__(self) -> None:
        self.points = Points(self.work)
        for routine in self.program.routines:
            self.expressions.append(self.work.look(routine).expressions)
            for expression in self.expressions[-1]:
                if type(expression) is ex.Variable and type(expression.index) is not ex.Number:
                    self._array(routine.name if expression.local else "", expression.store)
        self.whole = whole_registers(self.program, self.work)
        for routine in self.program.routines:
            self._initial_positions(routine)
        self.saved = saved_values(self.work)
        self._saved_positions()
        self._carry_states()

    # --- names ------------------------------------------------------------------------------------------

    def _array(self, scope: str, store: ex.Store) -> None:
        if (scope, store) not in self.arrays:
            stem = f"{'L' if scope else ''}{LETTERS[store]}"
            self.arrays[(scope, store)] = array = ex.Named(self.work.fresh(stem))
            if not scope:
                self.work.names[("variable", f"{LETTERS[store]}*")] = array.name
            self.largest[(scope, store)] = 0

    def variable(self, v: ex.Variable) -> ex.Expression:
        """The name of a numbered variable; an array element where the program computes numbers of such variables."""
        if v.store is ex.Store.SYSTEM:
            v = replace(
                v, store=ex.Store.ROBOT
            )  # of it, a program of one arm uses the robot's position alone
        scope = self.scope if v.local else ""
        array = self.arrays.get((scope, v.store))
        if array is not None:
            first = 1 - self.work.conventions.first_variable  # Item counts from 1
            if type(v.index) is ex.Number:
                index: ex.Expression = ex.Number(int(v.index.value) + first)
                self.largest[(scope, v.store)] = max(
                    self.largest[(scope, v.store)], int(v.index.value) + first
                )
            else:
                index = ex.Binary("+", v.index, ex.Number(first)) if first else v.index
                usual = _numbers_of(self.program.vendor).get(v.store, _LARGEST_ARRAY)
                self.largest[(scope, v.store)] = max(self.largest[(scope, v.store)], usual)
            return ex.Item(array, (index,))
        assert type(v.index) is ex.Number
        key = (scope, v.store, int(v.index.value))
        name = self.names.get(key)
        if name is None:
            stem = v.name or f"{'L' if scope else ''}{LETTERS[v.store]}{key[2]}"
            name = self.names[key] = ex.Named(self.work.fresh(stem))
            if not scope:
                self.work.registers.add(name.name)
            self.work.names[("variable", f"{scope + '.' if scope else ''}{LETTERS[v.store]}{key[2]}")] = (
                name.name
            )
        return name

    def _initial_positions(self, routine: st.Routine) -> None:
        for (store, taught), block in routine.points.blocks.items():
            if taught or store is not ex.Store.ROBOT:
                continue
            for number in block.rows:
                point = routine.points.find(store, False, number)
                literal = None if point is None else self.points.literal(routine, point, store)
                name = self.variable(ex.Variable(store, ex.Number(int(number))))
                if point is None or literal is None:
                    continue
                if isinstance(name, ex.Named):
                    self.initial.setdefault(name.name, literal)
                    self.work.registers.discard(name.name)  # loading the job sets it
                    self._begins_with(name, point.state)
                elif isinstance(name, ex.Item) and isinstance(name.base, ex.Named):
                    self.array_initial.append(st.Assign(0, name, literal))
                    self._begins_with(name.base, point.state)

    def _saved_positions(self) -> None:
        """Positions that neither a header nor a statement sets begin with the values that the controller keeps."""
        saved = list(saved_points(self.saved))
        used = numbered(self.program, ex.Store.ROBOT) if saved else set()
        by_number = ("", ex.Store.ROBOT) in self.arrays
        for point in saved:
            if not by_number and point.number not in used:
                continue
            name = self.variable(ex.Variable(ex.Store.ROBOT, ex.Number(point.number)))
            literal = self.points.literal(self.program.routines[0], point, ex.Store.ROBOT)
            if literal is None:
                continue
            if isinstance(name, ex.Named) and name.name not in self.initial:
                self.initial[name.name] = literal
                self.work.registers.discard(name.name)  # taught, as a point is
                self._begins_with(name, point.state)
            elif isinstance(name, ex.Item) and isinstance(name.base, ex.Named):
                self.array_initial.insert(
                    0, st.Assign(0, name, literal)
                )  # the values of headers come later and win
                self._begins_with(name.base, point.state)

    def _begins_with(self, name: ex.Named, state: PointState) -> None:
        self.points.states.setdefault(name.name, state)
        self.rows.setdefault(name.name, set()).add(state)

    def begins(self, name: ex.Expression) -> bool:
        """Whether the first value of a variable is known."""
        return label_of(name) in self.initial or any(a.target == name for a in self.array_initial)

    def is_set(self, name: ex.Expression) -> bool:
        """Whether statements set a variable; of a position, all of its components."""
        if self.changed is None:
            self.changed = {}
            for routine in self.program.routines:
                self.scope = routine.name
                for _, s in self.work.look(routine).rare:
                    self._note_changed(s)
        return self.changed.get(name, frozenset()) >= _POSE

    def _note_changed(self, s: st.Statement) -> None:
        """Notes in `changed` which components of a variable a statement sets; for numbers and whole positions, all."""
        assert self.changed is not None
        targets = [s.target] if isinstance(s, (st.Assign, st.Update, st.Clear, st.ReadInput)) else []
        targets += [s.variable] if isinstance(s, st.For) else [s.result] if isinstance(s, st.Call) else []
        for target in targets:
            variable: Any = target
            if isinstance(target, (ex.Element, ex.Member)):
                variable = target.variable if isinstance(target, ex.Element) else target.base
            if not isinstance(variable, ex.Variable) or isinstance(s, st.Update):
                continue
            if isinstance(s, st.Assign) and variable in expressions_of(s.value):
                continue  # the new value depends on the old one
            name = self.variable(variable)
            new = _POSE
            if isinstance(target, ex.Member):
                new = frozenset({target.name})
            elif isinstance(target, ex.Element) and isinstance(target.index, ex.Number):
                new = frozenset(_ELEMENTS[int(target.index.value) - 1 : int(target.index.value)])
            self.changed[name] = self.changed.get(name, frozenset()) | new

    def _carry_states(self) -> None:
        """Position variables that are copied from another one get its frame and tool."""
        assigned = [
            (routine, s)
            for routine in self.program.routines
            for _, s in self.work.look(routine).rare
            if type(s) is st.Assign and _is_position(s.target)
        ]
        for _ in range(3):
            for routine, s in assigned:
                self.scope = routine.name
                self._carry_state(routine, s)

    def _carry_state(self, routine: st.Routine, s: st.Assign) -> None:
        source: ex.Expression = s.value
        if isinstance(source, ex.Function) and source.name == "pose-product":
            source = source.arguments[0]
        target = _owner(self.value(s.target))
        if target is None:
            return
        state = None
        if isinstance(source, ex.Taught):
            point = routine.points.find(source.store, True, source.number)
            state = None if point is None else point.state
        elif _is_position(source):
            name = _owner(self.value(source))
            state = None if name is None else self.points.states.get(name.name)
        elif isinstance(source, ex.SystemValue):
            state = PointState(_KINDS.get(source.name, PointKind.POSE), "base")
        if state is not None:
            self.points.states.setdefault(target.name, state)
            self.kinds.setdefault(target.name, set()).add(state.kind)

    def global_data(self) -> Iterator[st.Declare]:
        """Declarations of everything that was numbered and holds for the whole program."""
        yield from self._declared("")
        if self.returned is not None:
            yield st.Declare(0, self.returned.name, "real", ex.Number(0.0), shared=True)

    def _declared(self, scope: str) -> Iterator[st.Declare]:
        for (where, store, number), name in self.names.items():
            if where == scope:
                value = self.initial.get(name.name)
                if value is None and not scope:
                    value = saved_number(self.saved.get((store, number)))
                kind = (
                    "integer"
                    if store is ex.Store.REAL and number in self.whole
                    else STORED.get(store, "position")
                )
                if isinstance(value, ex.PositionLiteral):
                    kind = "joints" if value.kind == "joint" else kind
                elif kind == "position" and self.kinds.get(name.name, _POSES) <= _JOINTS:
                    kind = "joints"  # all that sets it are points by their axes
                if kind == "joints":
                    self.joints.add(name.name)
                if value is None and not (self.work.limits.numbered and not scope):
                    value = _ZEROS[kind]  # a register stays what its operator has set
                yield st.Declare(0, name.name, kind, value, (), _kept(scope), shared=not scope)
        for (where, store), name in self.arrays.items():
            if where == scope:
                size = ex.Number(max(self.largest[(where, store)], 1))
                kind = STORED.get(store, "position")
                yield st.Declare(0, name.name, kind, None, (size,), _kept(scope), shared=not scope)

    # --- routines ---------------------------------------------------------------------------------------

    def routine(self, routine: st.Routine, expressions: list[ex.Expression]) -> st.Routine:
        """The routine with names; `expressions`: all that it has, without those of plain moves."""
        self.scope = routine.name
        parameters = routine.parameters or tuple(
            st.Parameter(f"arg{number}", STORED.get(store, "real") if store else "real")
            for number, store in enumerate(arguments_of(routine, expressions), 1)
        )
        self.parameters = parameters
        body: list[st.Statement] = []
        taught_frames = self.work.conventions.taught_frames
        for s in routine.body:
            if (type(s) is st.Move and not taught_frames and has_names(s)) or sets_numbers(s):
                body.append(s)
            else:
                body += self.statement(routine, s)
        local: tuple[st.Statement, ...] = tuple(self._declared(routine.name))
        if routine.starts or routine.name == (self.program.main or self.program.routines[0].name):
            local = (*local, *self.array_initial)
        at = 1 if body and type(body[0]).__name__ == "Begin" else 0
        body[at:at] = local
        return replace(
            with_rows(routine, body),
            points=PointTable(),
            parameters=parameters,
            arguments=(),
            locals={},
            aliases={},
        )

    def with_axes(self, routine: st.Routine) -> st.Routine:
        """Elements of variables that hold axis values become axes [deg]; they were read as components of poses."""

        def axis(e: ex.Expression) -> ex.Expression:
            if not (type(e) is ex.Member and type(e.base) is ex.Named and e.name in POSE_ELEMENTS):
                return e
            name = e.base.name
            if name not in self.joints:
                return e
            state = self.points.states.get(name)
            if PointKind.PULSE in (*self.kinds.get(name, ()), state and state.kind):
                self.work.lose(self.line, Fate.REFUSED, "element", "an element of a position in motor pulses")
            return ex.Item(e.base, (ex.Number(POSE_ELEMENTS.index(e.name) + 1),))

        body: list[st.Statement] = []
        for s in routine.body:
            self.line = s.line
            body.append(s if calls_nothing(s) else mapped(s, axis))
        return with_rows(routine, body)

    def statement(self, routine: st.Routine, s: st.Statement) -> list[st.Statement]:
        self.line = s.line
        if type(s) is st.Move:
            return lifted_move(self.points, routine, s, self.value)
        if not calls_nothing(s) and any(map(_is_computed_element, expressions_of(s))):
            self.work.lose(s, Fate.REFUSED, "element", _COMPUTED_ELEMENT)
            return [s]
        match s:
            case st.Update():
                return self._update(s)
            case st.Clear():
                return self._clear(s)
            case st.ReadInput(line, target, signal, comment):
                return [st.Assign(line, self.value(target), mapped(signal, self._change), comment)]
            case st.Assign(line, ex.Element() as element, value, comment):
                member, scale = self._element(element)
                return [st.Assign(line, member, in_units(self.value(value), scale), comment)]
            case st.ShiftOn(frame=None) if self.work.conventions.taught_frames:
                return [mapped(framed_shift(self.points, s, self.value), self._change)]
            case st.Return(line, value, condition, comment) if self._returns_by_register(routine, value):
                target = self._returned()
                if condition is not None:
                    self.work.lose(s, Fate.REFUSED, "value", "a value is returned under a condition")
                    return [s]
                return [st.Assign(line, target, self.value(value), comment), st.Return(line)]
            case _:
                return [mapped(s, self._change)]

    def _returns_by_register(
        self, routine: st.Routine, value: ex.Expression | None
    ) -> TypeGuard[ex.Expression]:
        """Whether the caller reads the returned value from a register later (`$RV`), and not as a function's value."""
        return value is not None and not routine.returns and self.work.conventions.returns_by_register

    def _returned(self) -> ex.Named:
        if self.returned is None:
            self.returned = ex.Named(self.work.fresh("returned"))
        return self.returned

    def _update(self, s: st.Update) -> list[st.Statement]:
        target = self.value(s.target)
        operand = None if s.operand is None else self.value(s.operand)
        if _is_position(s.target):
            return self._moved_position(s, target, operand)
        assert operand is not None
        value: ex.Expression = ex.Binary(s.operator, target, operand)
        if (
            s.operator == "/"
            and isinstance(s.target, ex.Variable)
            and STORED.get(s.target.store) == "integer"
        ):
            # Two integers divide towards zero; what a real gives is rounded.
            whole = _is_integer(s.operand)
            value = ex.Binary("div", target, operand) if whole else ex.Function("round", (value,))
        return [st.Assign(s.line, target, value, s.comment)]

    def _moved_position(
        self, s: st.Update, target: ex.Expression, operand: ex.Expression | None
    ) -> list[st.Statement]:
        """Positions add element by element."""
        if s.operator not in ("+", "-") or operand is None or not _is_position(s.operand):
            self.work.lose(s, Fate.REFUSED, "arithmetic", "arithmetic of a position with a number")
            return [s]
        rows: list[st.Statement] = []
        known = self.initial.get(operand.name) if isinstance(operand, ex.Named) else None
        fixed = known if isinstance(known, ex.PositionLiteral) and not self._is_changed(operand) else None
        for at, member in enumerate(_ELEMENTS[:6]):
            if fixed is not None and fixed.values[at] == 0.0:
                continue
            total = ex.Binary(s.operator, ex.Member(target, member), ex.Member(operand, member))
            rows.append(st.Assign(s.line, ex.Member(target, member), total))
        return rows

    def _is_changed(self, name: ex.Expression) -> bool:
        return any(
            isinstance(s, (st.Assign, st.Update, st.Clear, st.ReadInput))
            and s.target is not None
            and self._names(s.target, name)
            for s in self.program.statements()
        )

    def _names(self, target: ex.Expression, name: ex.Expression) -> bool:
        variable = target.variable if isinstance(target, ex.Element) else target
        return isinstance(variable, ex.Variable) and self.variable(variable) == name

    def _clear(self, s: st.Clear) -> list[st.Statement]:
        target, count = s.target, s.count
        if (
            not isinstance(target, ex.Variable)
            or type(target.index) is not ex.Number
            or target.store in ex.POSITION_STORES
        ):
            self.work.lose(s, Fate.REFUSED, "target", "only numbered variables can be cleared")
            return [s]
        if isinstance(count, ex.Number):
            indices = range(int(target.index.value), int(target.index.value) + int(count.value))
        else:
            used = {n for scope, store, n in self.names if store is target.store}
            indices = range(int(target.index.value), max(used, default=int(target.index.value)) + 1)
        zero = _ZEROS[STORED.get(target.store, "integer")]
        return [
            st.Assign(s.line, self.variable(replace(target, index=ex.Number(i), name="")), zero)
            for i in list(indices)[:200]
        ]

    # --- values -----------------------------------------------------------------------------------------

    def value(self, e: Any) -> Any:
        return mapped(e, self._change)

    def _change(self, e: ex.Expression) -> ex.Expression:
        kind = type(e)
        if kind is ex.Variable:
            assert isinstance(e, ex.Variable)
            return self.variable(e)
        if kind is ex.Argument:
            assert isinstance(e, ex.Argument)
            if 0 < e.number <= len(self.parameters):
                return ex.Named(self.parameters[e.number - 1].name)
            return e
        if kind is ex.Element:
            assert isinstance(e, ex.Element)
            member, scale = self._element(e)
            return ex.Function("round", (ex.Binary("*", member, ex.Number(scale)),))
        if kind is ex.SystemValue:
            assert isinstance(e, ex.SystemValue)
            if e.name == "returned":
                return self._returned()
            return ex.SystemValue(_SYSTEM[e.name]) if e.name in _SYSTEM else e
        if kind is ex.Taught:
            assert isinstance(e, ex.Taught)
            return self.points.taught(self.work.routine(self.scope), e.store, e.number) or e
        return e

    def _element(self, e: ex.Element) -> tuple[ex.Expression, int]:
        """An element as a component in mm or deg, and the number of the controller's counts per mm or deg."""
        if isinstance(e.variable, ex.Variable) and e.variable.store in (ex.Store.BASE, ex.Store.STATION):
            says = "an element of an external axis: pulses, mm or degrees, as its controller has it"
            self.work.lose(self.line, Fate.REFUSED, "statement", says)
            return e, 1
        if not isinstance(e.index, ex.Number) or not 1 <= int(e.index.value) <= len(_ELEMENTS):
            self.work.lose(self.line, Fate.REFUSED, "element", _COMPUTED_ELEMENT)
            return e, 1
        at = int(e.index.value) - 1
        inner: Any = e.variable
        base = inner if isinstance(inner, (ex.Named, ex.Item)) else self.value(inner)
        return ex.Member(base, _ELEMENTS[at]), 1000 if at < 3 else 10_000


def _kept(scope: str) -> str:
    """The storage of a register: global ones keep their values when the program ends."""
    return "variable" if scope else "persistent"


def _owner(e: Any) -> ex.Named | None:
    """The name of a position variable, or of the array that has it as an element."""
    base = e.base if isinstance(e, ex.Item) else e
    return base if isinstance(base, ex.Named) else None


def _is_computed_element(e: ex.Expression) -> bool:
    """Whether this is a component with a computed number of a numbered position."""
    return isinstance(e, ex.Item) and isinstance(e.base, ex.Variable) and e.base.store in ex.POSITION_STORES


def _is_position(e: ex.Expression | None) -> bool:
    return isinstance(e, ex.Variable) and e.store in ex.POSITION_STORES


# --- Number lowering ---
# Which numbered variables a program uses, of which type, and whether they ever hold a fraction.


def numbered(program: st.Program, store: ex.Store) -> set[int]:
    """Numbers of the global variables of a kind that a program names."""
    return {
        int(e.index.value)
        for s in program.statements()
        for e in expressions_of(s)
        if type(e) is ex.Variable and e.store is store and not e.local and type(e.index) is ex.Number
    }


def arguments_of(routine: st.Routine, expressions: list[ex.Expression]) -> tuple[ex.Store | None, ...]:
    """Kinds of a routine's arguments: as its header says, else as its body reads them. `expressions`: of the body."""
    read = [e.number for e in expressions if type(e) is ex.Argument]
    count = max((len(routine.arguments), *read))
    kinds = {
        s.value.number: s.target.store
        for s in routine.body
        if type(s) is st.Assign and type(s.value) is ex.Argument and type(s.target) is ex.Variable
    }
    said = len(routine.arguments)
    return (*routine.arguments, *(kinds.get(number) for number in range(said + 1, count + 1)))


def whole_registers(program: st.Program, work: TranslationContext) -> frozenset[int]:
    """Numbers of the real registers that only ever hold whole values: they can be integers in the target.

    The program sets them before it reads them, and only to whole values: what was stored before may be a fraction.
    """
    assigned: dict[int, list[ex.Expression | None]] = {}
    for s in (s for r in program.routines for _, s in work.look(r).rare):
        for number, value in _register_values(s):
            assigned.setdefault(number, []).append(value)
    whole = _never_fractions(assigned, set(assigned))
    return frozenset(_never_fractions(assigned, whole - _read_unset(program, work, whole)))


def _register_values(s: st.Statement) -> Iterator[tuple[int, ex.Expression | None]]:
    """The real registers that a statement sets, each with its value, None where it is unknown."""
    target: ex.Expression | None = None
    value: ex.Expression | None = ex.Number(0)
    match s:
        case st.Assign(target=target, value=value):
            pass
        case st.Update(operator=operator, target=target, operand=operand):
            value = None if operand is None else ex.Binary(operator, target, operand)
        case st.ReadInput(target=target) | st.Clear(target=target) | st.For(variable=target):
            pass
        case st.Call(result=target):
            value = None
    number = _real_register(target)
    if number is not None:
        yield number, value


def _real_register(e: ex.Expression | None) -> int | None:
    if isinstance(e, ex.Variable) and e.store is ex.Store.REAL and isinstance(e.index, ex.Number):
        return int(e.index.value)
    return None


def _never_fractions(assigned: Mapping[int, list[ex.Expression | None]], whole: set[int]) -> set[int]:
    """The registers of `whole` that are only set to whole values."""
    while True:
        kept = {n for n in whole if all(_is_whole(value, whole) for value in assigned[n])}
        if kept == whole:
            return whole
        whole = kept


def _read_unset(program: st.Program, work: TranslationContext, registers: set[int]) -> set[int]:
    """The registers that are read where the program may not have set them before.

    A called routine whose text is unknown may set any of them.
    """
    if not registers:
        return set()
    own = {r.name.casefold() for r in program.routines}
    unknown: dict[Key, int] = {("whole", n): UNSET for n in registers}

    def made(s: st.Statement) -> dict[Key, int]:
        called = unknown if isinstance(s, st.Call) and s.routine.casefold() not in own else {}
        return called | {("whole", n): 1 for n, _ in _register_values(s) if n in registers}

    ways = reaching(program, made, {st.Assign, st.Update, st.ReadInput, st.Clear, st.For, st.Call})
    found: set[int] = set()
    for r in program.routines:
        for index, s in work.look(r).rare:
            read = {_real_register(e) for e in read_by(s)} & registers - found
            found |= {n for n in read if n is not None and UNSET in ways.at(r.name, index, ("whole", n))}
    return found


def _is_whole(e: ex.Expression | None, whole: set[int]) -> bool:
    match e:
        case ex.Number(value):
            return isinstance(value, int) or float(value).is_integer()
        case ex.Variable(ex.Store.REAL, ex.Number(index)):
            return int(index) in whole
        case ex.Variable(store):
            return STORED.get(store) == "integer"
        case ex.Unary("-", operand):
            return _is_whole(operand, whole)
        case ex.Binary(operator, left, right):
            return operator in ("div", "mod") or (
                operator in "+-*" and _is_whole(left, whole) and _is_whole(right, whole)
            )
        case ex.Function(name):
            return name in ("round", "trunc", "floor", "ceil")
        case _:
            return False


def in_units(counts: ex.Expression, scale: int) -> ex.Expression:
    """The expression in mm or deg for one in the controller's counts, `scale` of which are 1 mm or 1 deg."""
    if isinstance(counts, ex.Unary) and counts.operator == "-" and isinstance(counts.operand, ex.Number):
        counts = ex.Number(-counts.operand.value)
    return (
        ex.Number(counts.value / scale)
        if isinstance(counts, ex.Number)
        else ex.Binary("/", counts, ex.Number(scale))
    )
