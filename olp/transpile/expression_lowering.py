"""Numbered points, variables and arguments become named ones, so that all further passes see one kind of program."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeGuard

from olp.core.diagnostic import OlpError
from olp.ir.expressions import (
    POSITION_STORES,
    Argument,
    Binary,
    Element,
    Expression,
    Function,
    Item,
    Member,
    Named,
    Number,
    PositionLiteral,
    SignalState,
    Store,
    SystemValue,
    Taught,
    Text,
    Unary,
    Variable,
)
from olp.ir.points import PointKind, PointState, PointTable
from olp.ir.program import (
    Assign,
    Call,
    Clear,
    Declare,
    For,
    Move,
    Parameter,
    Program,
    ReadInput,
    Return,
    Routine,
    Statement,
    Update,
)
from olp.ir.transformer import calls_nothing, expressions_of, mapped, sets_numbers
from olp.languages.limits import limits_of
from olp.runtime.assumptions import Given
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.first_values import (
    POSE_ELEMENTS,
    Unset,
    label_of,
    saved_number,
    saved_points,
    saved_values,
)
from olp.transpile.move_lowering import Points, carried_systems, has_names, lifted_move
from olp.transpile.occurrences import with_rows
from olp.transpile.symbols import STORED

LETTERS: Final = {
    Store.BYTE: "B",
    Store.INTEGER: "I",
    Store.DOUBLE: "D",
    Store.REAL: "R",
    Store.STRING: "S",
    Store.ROBOT: "PV",
    Store.BASE: "BPV",
    Store.STATION: "EPV",
    Store.SYSTEM: "PX",
}
_ZEROS: Final[dict[str, Expression]] = {
    "integer": Number(0),
    "real": Number(0.0),
    "string": Text(""),
    "boolean": SignalState(False),
    "position": PositionLiteral("pose", (0.0,) * 6),
    "joints": PositionLiteral("joint", (0.0,) * 6),
}
_JOINTS: Final = frozenset({PointKind.JOINT, PointKind.PULSE})
_POSES: Final = frozenset({PointKind.POSE})
_KINDS: Final = {"position-pulse": PointKind.PULSE, "current-joints": PointKind.JOINT}  # where the arm stands
_ELEMENTS: Final = (*POSE_ELEMENTS, "e1", "e2")
_SYSTEM: Final = {"position-pose": "current-pose", "position-pulse": "current-joints"}
_LARGEST_ARRAY: Final = 100
_POSE: Final = frozenset(POSE_ELEMENTS)


def _is_integer(e: Expression | None) -> bool:
    if isinstance(e, Variable):
        return STORED.get(e.store) == "integer"
    return isinstance(e, Element) or (isinstance(e, Number) and isinstance(e.value, int))


def _numbers_of(vendor: str) -> Mapping[Store, int]:
    """How many variables of each kind the controllers of a language have."""
    try:
        return limits_of(vendor).numbered
    except OlpError:
        return {}  # a language that is read alone


def lift(program: Program, work: TranslationContext) -> Program:
    """Only names from here on. A program without numbers comes back as it is."""
    lifted = _Lift(program, work)
    routines = tuple(map(lifted.routine, program.routines, lifted.expressions))
    Unset(program, work, lifted.variable, lifted.begins, lifted.is_set).tell()
    data = (*program.data, *lifted.points.declared, *lifted.global_data())
    work.states = {name: state.frame for name, state in lifted.points.states.items()}
    if lifted.joints:
        routines = tuple(map(lifted.with_axes, routines))
    made = replace(program, routines=routines, data=data)
    return carried_systems(made, lifted.points.states, lifted.rows, work)


@dataclass(slots=True)
class _Lift:
    program: Program
    work: TranslationContext
    points: Points = field(init=False)
    expressions: list[list[Expression]] = field(
        default_factory=list
    )  # of each routine, but those of plain moves
    names: dict[tuple[str, Store, int], Named] = field(
        default_factory=dict
    )  # routine ("" global), kind, number
    arrays: dict[tuple[str, Store], Named] = field(default_factory=dict)
    largest: dict[tuple[str, Store], int] = field(default_factory=dict)
    initial: dict[str, Expression] = field(default_factory=dict)
    kinds: dict[str, set[PointKind]] = field(default_factory=dict)  # of what position variables are set to
    array_initial: list[Assign] = field(default_factory=list)
    saved: Mapping[tuple[Store, int], Given] = field(default_factory=dict)  # what the controller keeps
    whole: frozenset[int] = frozenset()  # real registers that only ever hold whole numbers
    scope: str = ""
    parameters: tuple[Parameter, ...] = ()  # of the routine under way
    line: int = 0  # of the statement under way
    changed: dict[Expression, frozenset[str]] | None = None  # what statements set -> which elements
    returned: Named | None = None
    joints: set[str] = field(default_factory=set)  # variables that are declared as axis values
    rows: dict[str, set[PointState]] = field(
        default_factory=dict
    )  # of the position variables that begin with a position

    def __post_init__(self) -> None:
        self.points = Points(self.work)
        for routine in self.program.routines:
            self.expressions.append(self.work.look(routine).expressions)
            for expression in self.expressions[-1]:
                if type(expression) is Variable and type(expression.index) is not Number:
                    self._array(routine.name if expression.local else "", expression.store)
        self.whole = whole_registers(s for r in self.program.routines for _, s in self.work.look(r).rare)
        for routine in self.program.routines:
            self._initial_positions(routine)
        self.saved = saved_values(self.work)
        self._saved_positions()
        self._carry_states()

    # --- names ------------------------------------------------------------------------------------------

    def _array(self, scope: str, store: Store) -> None:
        if (scope, store) not in self.arrays:
            stem = f"{'L' if scope else ''}{LETTERS[store]}"
            self.arrays[(scope, store)] = array = Named(self.work.fresh(stem))
            if not scope:
                self.work.names[("variable", f"{LETTERS[store]}*")] = array.name
            self.largest[(scope, store)] = 0

    def variable(self, v: Variable) -> Expression:
        """The name of a numbered variable; an element of an array where the program computes a number of its kind."""
        if v.store is Store.SYSTEM:
            v = replace(v, store=Store.ROBOT)  # its robot is all that a program of one arm uses of it
        scope = self.scope if v.local else ""
        array = self.arrays.get((scope, v.store))
        if array is not None:
            first = 1 - self.work.conventions.first_variable  # Item counts from 1
            if type(v.index) is Number:
                index: Expression = Number(int(v.index.value) + first)
                self.largest[(scope, v.store)] = max(
                    self.largest[(scope, v.store)], int(v.index.value) + first
                )
            else:
                index = Binary("+", v.index, Number(first)) if first else v.index
                usual = _numbers_of(self.program.vendor).get(v.store, _LARGEST_ARRAY)
                self.largest[(scope, v.store)] = max(self.largest[(scope, v.store)], usual)
            return Item(array, (index,))
        assert type(v.index) is Number
        key = (scope, v.store, int(v.index.value))
        name = self.names.get(key)
        if name is None:
            stem = v.name or f"{'L' if scope else ''}{LETTERS[v.store]}{key[2]}"
            name = self.names[key] = Named(self.work.fresh(stem))
            if not scope:
                self.work.registers.add(name.name)
            self.work.names[("variable", f"{scope + '.' if scope else ''}{LETTERS[v.store]}{key[2]}")] = (
                name.name
            )
        return name

    def _initial_positions(self, routine: Routine) -> None:
        for (store, taught), block in routine.points.blocks.items():
            if taught or store is not Store.ROBOT:
                continue
            for number in block.rows:
                point = routine.points.find(store, False, number)
                literal = None if point is None else self.points.literal(routine, point, store)
                name = self.variable(Variable(store, Number(int(number))))
                if point is None or literal is None:
                    continue
                if isinstance(name, Named):
                    self.initial.setdefault(name.name, literal)
                    self.work.registers.discard(name.name)  # the job itself sets it when it is loaded
                    self._begins_with(name, point.state)
                elif isinstance(name, Item) and isinstance(name.base, Named):
                    self.array_initial.append(Assign(0, name, literal))
                    self._begins_with(name.base, point.state)

    def _saved_positions(self) -> None:
        """Positions that neither a header nor a statement sets are those that the controller keeps."""
        saved = list(saved_points(self.saved))
        used = numbered(self.program, Store.ROBOT) if saved else set()
        by_number = ("", Store.ROBOT) in self.arrays
        for point in saved:
            if not by_number and point.number not in used:
                continue
            name = self.variable(Variable(Store.ROBOT, Number(point.number)))
            literal = self.points.literal(self.program.routines[0], point, Store.ROBOT)
            if literal is None:
                continue
            if isinstance(name, Named) and name.name not in self.initial:
                self.initial[name.name] = literal
                self.work.registers.discard(name.name)  # taught, as a point is
                self._begins_with(name, point.state)
            elif isinstance(name, Item) and isinstance(name.base, Named):
                self.array_initial.insert(0, Assign(0, name, literal))  # what a header says comes after
                self._begins_with(name.base, point.state)

    def _begins_with(self, name: Named, state: PointState) -> None:
        self.points.states.setdefault(name.name, state)
        self.rows.setdefault(name.name, set()).add(state)

    def begins(self, name: Expression) -> bool:
        """Whether a value is known that a variable begins with."""
        return label_of(name) in self.initial or any(a.target == name for a in self.array_initial)

    def is_set(self, name: Expression) -> bool:
        """Whether statements give a variable a value: a position a whole one."""
        if self.changed is None:
            self.changed = {}
            for routine in self.program.routines:
                self.scope = routine.name
                for _, s in self.work.look(routine).rare:
                    self._note_changed(s)
        return self.changed.get(name, frozenset()) >= _POSE

    def _note_changed(self, s: Statement) -> None:
        """Which elements of what a statement sets; of a number, and of a whole position, all."""
        assert self.changed is not None
        targets = [s.target] if isinstance(s, (Assign, Update, Clear, ReadInput)) else []
        targets += [s.variable] if isinstance(s, For) else [s.result] if isinstance(s, Call) else []
        for target in targets:
            variable: Any = target
            if isinstance(target, (Element, Member)):
                variable = target.variable if isinstance(target, Element) else target.base
            if not isinstance(variable, Variable) or isinstance(s, Update):
                continue
            if isinstance(s, Assign) and variable in expressions_of(s.value):
                continue  # it counts on from what it was
            name = self.variable(variable)
            new = _POSE
            if isinstance(target, Member):
                new = frozenset({target.name})
            elif isinstance(target, Element) and isinstance(target.index, Number):
                new = frozenset(_ELEMENTS[int(target.index.value) - 1 : int(target.index.value)])
            self.changed[name] = self.changed.get(name, frozenset()) | new

    def _carry_states(self) -> None:
        """A position variable that is set from another one has that one's frame and tool."""
        assigned = [
            (routine, s)
            for routine in self.program.routines
            for _, s in self.work.look(routine).rare
            if type(s) is Assign and _is_position(s.target)
        ]
        for _ in range(3):
            for routine, s in assigned:
                self.scope = routine.name
                self._carry_state(routine, s)

    def _carry_state(self, routine: Routine, s: Assign) -> None:
        source: Expression = s.value
        if isinstance(source, Function) and source.name == "pose-product":
            source = source.arguments[0]
        target = _owner(self.value(s.target))
        if target is None:
            return
        state = None
        if isinstance(source, Taught):
            point = routine.points.find(source.store, True, source.number)
            state = None if point is None else point.state
        elif _is_position(source):
            name = _owner(self.value(source))
            state = None if name is None else self.points.states.get(name.name)
        elif isinstance(source, SystemValue):
            state = PointState(_KINDS.get(source.name, PointKind.POSE), "base")
        if state is not None:
            self.points.states.setdefault(target.name, state)
            self.kinds.setdefault(target.name, set()).add(state.kind)

    def global_data(self) -> Iterator[Declare]:
        """Declarations of everything that was numbered and holds for the whole program."""
        yield from self._declared("")
        if self.returned is not None:
            yield Declare(0, self.returned.name, "real", Number(0.0), shared=True)

    def _declared(self, scope: str) -> Iterator[Declare]:
        for (where, store, number), name in self.names.items():
            if where == scope:
                value = self.initial.get(name.name)
                if value is None and not scope:
                    value = saved_number(self.saved.get((store, number)))
                kind = (
                    "integer"
                    if store is Store.REAL and number in self.whole
                    else STORED.get(store, "position")
                )
                if isinstance(value, PositionLiteral):
                    kind = "joints" if value.kind == "joint" else kind
                elif kind == "position" and self.kinds.get(name.name, _POSES) <= _JOINTS:
                    kind = "joints"  # all that sets it are points by their axes
                if kind == "joints":
                    self.joints.add(name.name)
                if value is None and not (self.work.limits.numbered and not scope):
                    value = _ZEROS[kind]  # a register stays what its operator has set
                yield Declare(0, name.name, kind, value, (), _kept(scope), shared=not scope)
        for (where, store), name in self.arrays.items():
            if where == scope:
                size = Number(max(self.largest[(where, store)], 1))
                kind = STORED.get(store, "position")
                yield Declare(0, name.name, kind, None, (size,), _kept(scope), shared=not scope)

    # --- routines ---------------------------------------------------------------------------------------

    def routine(self, routine: Routine, expressions: list[Expression]) -> Routine:
        """`routine` with names; `expressions`: those in it, but for plain moves'."""
        self.scope = routine.name
        parameters = routine.parameters or tuple(
            Parameter(f"arg{number}", STORED.get(store, "real") if store else "real")
            for number, store in enumerate(arguments_of(routine, expressions), 1)
        )
        self.parameters = parameters
        body: list[Statement] = []
        taught_frames = self.work.conventions.taught_frames
        for s in routine.body:
            if (type(s) is Move and not taught_frames and has_names(s)) or sets_numbers(s):
                body.append(s)
            else:
                body += self.statement(routine, s)
        local: tuple[Statement, ...] = tuple(self._declared(routine.name))
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

    def with_axes(self, routine: Routine) -> Routine:
        """Elements of axis values as axes [deg], which their numbers were taken as elements of poses for."""

        def axis(e: Expression) -> Expression:
            if not (type(e) is Member and type(e.base) is Named and e.name in POSE_ELEMENTS):
                return e
            name = e.base.name
            if name not in self.joints:
                return e
            state = self.points.states.get(name)
            if PointKind.PULSE in (*self.kinds.get(name, ()), state and state.kind):
                self.work.lose(self.line, Fate.REFUSED, "element", "an element of a position in motor pulses")
            return Item(e.base, (Number(POSE_ELEMENTS.index(e.name) + 1),))

        body: list[Statement] = []
        for s in routine.body:
            self.line = s.line
            body.append(s if calls_nothing(s) else mapped(s, axis))
        return with_rows(routine, body)

    def statement(self, routine: Routine, s: Statement) -> list[Statement]:
        self.line = s.line
        if type(s) is Move:
            return lifted_move(self.points, routine, s, self.value)
        match s:
            case Update():
                return self._update(s)
            case Clear():
                return self._clear(s)
            case ReadInput(line, target, signal, comment):
                return [Assign(line, self.value(target), mapped(signal, self._change), comment)]
            case Assign(line, Element() as element, value, comment):
                member, scale = self._element(element)
                return [Assign(line, member, in_units(self.value(value), scale), comment)]
            case Return(line, value, condition, comment) if self._returns_by_register(routine, value):
                target = self._returned()
                if condition is not None:
                    self.work.lose(s, Fate.REFUSED, "value", "a value is returned under a condition")
                    return [s]
                return [Assign(line, target, self.value(value), comment), Return(line)]
            case _:
                return [mapped(s, self._change)]

    def _returns_by_register(self, routine: Routine, value: Expression | None) -> TypeGuard[Expression]:
        """Whether a value goes back as its caller asks for it later (`$RV`), not as that of a function."""
        return value is not None and not routine.returns and self.work.conventions.returns_by_register

    def _returned(self) -> Named:
        if self.returned is None:
            self.returned = Named(self.work.fresh("returned"))
        return self.returned

    def _update(self, s: Update) -> list[Statement]:
        target = self.value(s.target)
        operand = None if s.operand is None else self.value(s.operand)
        if _is_position(s.target):
            return self._moved_position(s, target, operand)
        assert operand is not None
        value: Expression = Binary(s.operator, target, operand)
        if s.operator == "/" and isinstance(s.target, Variable) and STORED.get(s.target.store) == "integer":
            # Two integers divide towards zero; what a real gives is rounded.
            whole = _is_integer(s.operand)
            value = Binary("div", target, operand) if whole else Function("round", (value,))
        return [Assign(s.line, target, value, s.comment)]

    def _moved_position(self, s: Update, target: Expression, operand: Expression | None) -> list[Statement]:
        """Positions add element by element."""
        if s.operator not in ("+", "-") or operand is None or not _is_position(s.operand):
            self.work.lose(s, Fate.REFUSED, "arithmetic", "arithmetic of a position with a number")
            return [s]
        rows: list[Statement] = []
        known = self.initial.get(operand.name) if isinstance(operand, Named) else None
        fixed = known if isinstance(known, PositionLiteral) and not self._is_changed(operand) else None
        for at, member in enumerate(_ELEMENTS[:6]):
            if fixed is not None and fixed.values[at] == 0.0:
                continue
            total = Binary(s.operator, Member(target, member), Member(operand, member))
            rows.append(Assign(s.line, Member(target, member), total))
        return rows

    def _is_changed(self, name: Expression) -> bool:
        return any(
            isinstance(s, (Assign, Update, Clear, ReadInput))
            and s.target is not None
            and self._names(s.target, name)
            for s in self.program.statements()
        )

    def _names(self, target: Expression, name: Expression) -> bool:
        variable = target.variable if isinstance(target, Element) else target
        return isinstance(variable, Variable) and self.variable(variable) == name

    def _clear(self, s: Clear) -> list[Statement]:
        target, count = s.target, s.count
        if (
            not isinstance(target, Variable)
            or type(target.index) is not Number
            or target.store in POSITION_STORES
        ):
            self.work.lose(s, Fate.REFUSED, "target", "only numbered variables can be cleared")
            return [s]
        if isinstance(count, Number):
            indices = range(int(target.index.value), int(target.index.value) + int(count.value))
        else:
            used = {n for scope, store, n in self.names if store is target.store}
            indices = range(int(target.index.value), max(used, default=int(target.index.value)) + 1)
        zero = _ZEROS[STORED.get(target.store, "integer")]
        return [
            Assign(s.line, self.variable(replace(target, index=Number(i), name="")), zero)
            for i in list(indices)[:200]
        ]

    # --- values -----------------------------------------------------------------------------------------

    def value(self, e: Any) -> Any:
        return mapped(e, self._change)

    def _change(self, e: Expression) -> Expression:
        kind = type(e)
        if kind is Variable:
            assert isinstance(e, Variable)
            return self.variable(e)
        if kind is Argument:
            assert isinstance(e, Argument)
            if 0 < e.number <= len(self.parameters):
                return Named(self.parameters[e.number - 1].name)
            return e
        if kind is Element:
            assert isinstance(e, Element)
            member, scale = self._element(e)
            return Function("round", (Binary("*", member, Number(scale)),))
        if kind is SystemValue:
            assert isinstance(e, SystemValue)
            if e.name == "returned":
                return self._returned()
            return SystemValue(_SYSTEM[e.name]) if e.name in _SYSTEM else e
        if kind is Taught:
            assert isinstance(e, Taught)
            return self.points.taught(self.work.routine(self.scope), e.store, e.number) or e
        return e

    def _element(self, e: Element) -> tuple[Expression, int]:
        """An element as a component in mm and deg, and how many of the controller's counts one of them is."""
        if isinstance(e.variable, Variable) and e.variable.store in (Store.BASE, Store.STATION):
            says = "an element of an external axis: pulses, mm or degrees, as its controller has it"
            self.work.lose(self.line, Fate.REFUSED, "statement", says)
            return e, 1
        if not isinstance(e.index, Number) or not 1 <= int(e.index.value) <= len(_ELEMENTS):
            self.work.lose(
                self.line, Fate.REFUSED, "element", "an element of a position by a computed number"
            )
            return e, 1
        at = int(e.index.value) - 1
        inner: Any = e.variable
        base = inner if isinstance(inner, (Named, Item)) else self.value(inner)
        return Member(base, _ELEMENTS[at]), 1000 if at < 3 else 10_000


def _kept(scope: str) -> str:
    """How a register is stored: those of the whole program keep their values when it ends."""
    return "variable" if scope else "persistent"


def _owner(e: Any) -> Named | None:
    """The name of a position, or of the array that it is in."""
    base = e.base if isinstance(e, Item) else e
    return base if isinstance(base, Named) else None


def _is_position(e: Expression | None) -> bool:
    return isinstance(e, Variable) and e.store in POSITION_STORES


# --- Number lowering ---
# What a program uses of its numbered variables: which numbers, as what, and whether they ever hold a fraction.


def numbered(program: Program, store: Store) -> set[int]:
    """Numbers of the global variables of a kind that a program names."""
    return {
        int(e.index.value)
        for s in program.statements()
        for e in expressions_of(s)
        if type(e) is Variable and e.store is store and not e.local and type(e.index) is Number
    }


def arguments_of(routine: Routine, expressions: list[Expression]) -> tuple[Store | None, ...]:
    """What a routine takes: as its header says, else as its body, with these expressions, reads."""
    read = [e.number for e in expressions if type(e) is Argument]
    count = max((len(routine.arguments), *read))
    kinds = {
        s.value.number: s.target.store
        for s in routine.body
        if type(s) is Assign and type(s.value) is Argument and type(s.target) is Variable
    }
    said = len(routine.arguments)
    return (*routine.arguments, *(kinds.get(number) for number in range(said + 1, count + 1)))


def whole_registers(statements: Iterable[Statement]) -> frozenset[int]:
    """Numbers of the real registers that only ever get whole values, so that they can count."""
    assigned: dict[int, list[Expression | None]] = {}
    for s in statements:
        target = getattr(s, "target", None) if isinstance(s, (Assign, Update, ReadInput, Clear)) else None
        if target is None:
            target = getattr(s, "variable", None)
        if isinstance(target, Variable) and target.store is Store.REAL and isinstance(target.index, Number):
            values = assigned.setdefault(int(target.index.value), [])
            if isinstance(s, Assign):
                values.append(s.value)
            elif isinstance(s, Update):
                values.append(Binary(s.operator, s.target, s.operand) if s.operand is not None else None)
            else:
                values.append(Number(0))
    whole = set(assigned)
    while True:
        kept = {n for n in whole if all(_is_whole(value, whole) for value in assigned[n])}
        if kept == whole:
            return frozenset(whole)
        whole = kept


def _is_whole(e: Expression | None, whole: set[int]) -> bool:
    match e:
        case Number(value):
            return isinstance(value, int) or float(value).is_integer()
        case Variable(Store.REAL, Number(index)):
            return int(index) in whole
        case Variable(store):
            return STORED.get(store) == "integer"
        case Unary("-", operand):
            return _is_whole(operand, whole)
        case Binary(operator, left, right):
            return operator in ("div", "mod") or (
                operator in "+-*" and _is_whole(left, whole) and _is_whole(right, whole)
            )
        case Function(name):
            return name in ("round", "trunc", "floor", "ceil")
        case _:
            return False


def in_units(counts: Expression, scale: int) -> Expression:
    """[mm] or [deg] of the controller's counts."""
    if isinstance(counts, Unary) and counts.operator == "-" and isinstance(counts.operand, Number):
        counts = Number(-counts.operand.value)
    return Number(counts.value / scale) if isinstance(counts, Number) else Binary("/", counts, Number(scale))
