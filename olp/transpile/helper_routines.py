"""Functions that the target lacks, as routines of the translation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial, reduce
from typing import Final, NamedTuple, TypeGuard

from olp.core.units import mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointTable
from olp.ir.transformer import expressions_of, mapped
from olp.languages.vendor import language_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import changed_rare, with_rows
from olp.transpile.symbols import Symbols, holds_number, kind_of_value

_BITS: Final = ("and", "or", "xor")
_BYTE: Final = 255
_WHOLE: Final = ("floor", "ceil", "trunc")
_STATE: Final = "number-of-state"  # of a signal, or a condition
_CONDITION: Final = "number-of-condition"  # where signals are numbers
_ORDERS: Final = ("<", ">", "<=", ">=")


def helper_routines(program: st.Program, work: TranslationContext) -> st.Program:
    """Powers, whole numbers, the larger of two numbers, bits and the numbers of states, computed by routines where the
    target has none."""
    if not work.limits.lacks:
        return program
    own = _Helpers(work)
    routines = [
        changed_rare(r, look, own.statement)
        if any(map(own.asks, look.expressions)) or any(own.is_bitwise(s) for _, s in look.rare)
        else r
        for r in program.routines
        for look in (work.look(r),)
    ]
    return replace(program, routines=(*routines, *own.made.values()))


@dataclass(slots=True)
class _Helpers:
    work: TranslationContext
    made: dict[str, st.Routine] = field(default_factory=dict)  # by the function's name

    @property
    def asked(self) -> Callable[[ex.Expression], bool]:
        """What stands in arithmetic as a number that the target does not take for one."""
        lacks = self.work.limits.lacks
        return is_truth if _STATE in lacks else is_condition if _CONDITION in lacks else _is_state

    def asks(self, e: ex.Expression) -> bool:
        if computes_with_state(e, self.asked):
            return True
        name = e.operator if isinstance(e, ex.Binary) else e.name if isinstance(e, ex.Function) else ""
        return name in self.work.limits.lacks

    def is_bitwise(self, s: st.Statement) -> TypeGuard[st.Update]:
        """Whether bits of a variable are set (`AND B001 15`, `NOT B001 B002`) in a way that the target has not."""
        return type(s) is st.Update and (s.operator == "not" or s.operator in self.work.limits.lacks)

    def statement(self, s: st.Statement) -> st.Statement:
        if type(s) is st.SetOutput and _is_state(s.signal) and _inverts(s.value):
            return replace(s, value=ex.Unary("not", s.value.right))
        if not self.is_bitwise(s):
            return mapped(s, lambda e: self._change(e, s))
        operand = s.target if s.operand is None else s.operand
        if s.operator == "not":
            if not (_is_byte(s.target) and _is_byte(operand)):
                self.work.lose(s, Fate.REFUSED, "value", "the bits of a number beyond a byte inverted")
            return st.Assign(s.line, s.target, ex.Binary("-", ex.Number(_BYTE), operand), s.comment)
        value = self._change(ex.Binary(s.operator, s.target, operand), s)
        return st.Assign(s.line, s.target, value, s.comment)

    def _change(self, e: ex.Expression, s: st.Statement) -> ex.Expression:
        name = next((one for one in (_STATE, _CONDITION) if one in self.work.limits.lacks), "")
        if name and computes_with_state(e, self.asked):
            e = with_states(e, lambda one: self._called(name, (one,)), self.asked)
        language = language_of(self.work.target)
        if isinstance(e, ex.Binary) and e.operator in _BITS:
            if e.operator in self.work.limits.lacks:
                says = f"{language} has no bits of numbers: a loop computes them, of whole numbers from 0 on"
                self.work.lose(s, Fate.APPROXIMATED, "value", says)
            return self._called(e.operator, (e.left, e.right))
        if not isinstance(e, ex.Function) or len(e.arguments) != (1 if e.name in _WHOLE else 2):
            return e
        if e.name == "power" and "power" in self.work.limits.lacks:
            says = f"{language} has no powers: a loop multiplies, for whole exponents from 0 on"
            self.work.lose(s, Fate.APPROXIMATED, "value", says)
        return self._called(e.name, e.arguments)

    def _called(self, name: str, given: tuple[ex.Expression, ...]) -> ex.Expression:
        if name not in self.work.limits.lacks or name not in COMPUTED:
            return ex.Binary(name, *given) if name in _BITS else ex.Function(name, given)
        if name not in self.made:
            words = (f"{name}_of", "first", "second", "result", "count")
            if name in (_STATE, _CONDITION):
                words = ("number_of_state", "state", *words[2:])
            routine, *others = map(self.work.helper, words)
            self.made[name] = COMPUTED[name](_HelperNames(routine, *map(ex.Named, others)), name)
        return ex.CallValue(self.made[name].name, given)


def _is_state(e: ex.Expression) -> bool:
    """Whether it is a digital signal, which is a number in RAPID and a state elsewhere."""
    return type(e) is ex.Signal and not holds_number(e.bus)


def _inverts(e: ex.Expression) -> TypeGuard[ex.Binary]:
    """Whether it is `1 - di1`: the other state."""
    return type(e) is ex.Binary and e.operator == "-" and e.left == ex.Number(1) and _is_state(e.right)


def is_condition(e: ex.Expression) -> bool:
    """Whether it is true or false, whatever it asks."""
    return type(e) in (ex.Compare, ex.Logic) or (type(e) is ex.Unary and e.operator == "not")


def is_truth(e: ex.Expression) -> bool:
    return _is_state(e) or is_condition(e)


def computes_with_state(e: ex.Expression, asked: Callable[[ex.Expression], bool] = _is_state) -> bool:
    """Whether a digital signal takes part in arithmetic, or is asked whether it is more or less than a number.

    `asked`: what is looked for in its place.
    """
    match e:
        case ex.Binary(operator, left, right) if asked is _is_state or operator not in _BITS:
            return asked(left) or asked(right)
        case ex.Compare(operator, left, right):
            return operator in _ORDERS and (asked(left) or asked(right))
        case ex.Unary("-", operand):
            return asked(operand)
        case _:
            return False


def with_states(
    e: ex.Expression,
    number: Callable[[ex.Expression], ex.Expression],
    asked: Callable[[ex.Expression], bool] = _is_state,
) -> ex.Expression:
    """With `number` of each digital signal in the place of it, and 1 and 0 in the place of ON and OFF."""

    def one(side: ex.Expression) -> ex.Expression:
        if isinstance(side, ex.SignalState):
            return ex.Number(int(side.on))
        return number(side) if asked(side) else side

    if isinstance(e, ex.Unary):
        return replace(e, operand=one(e.operand))
    assert isinstance(e, (ex.Binary, ex.Compare))
    return replace(e, left=one(e.left), right=one(e.right))


def _is_byte(e: ex.Expression) -> bool:
    if isinstance(e, ex.Variable):
        return e.store is ex.Store.BYTE
    return isinstance(e, ex.Number) and 0 <= e.value <= _BYTE


class _HelperNames(NamedTuple):
    """Of a routine, its parameters and its variables: none that the program has."""

    routine: str
    a: ex.Named
    b: ex.Named
    result: ex.Named
    counter: ex.Named


def _routine(names: _HelperNames, kinds: tuple[str, str, str], rows: Sequence[st.Statement]) -> st.Routine:
    """`kinds`: of both parameters and of the value."""
    first, second, returns = kinds
    parameters = (st.Parameter(names.a.name, first), st.Parameter(names.b.name, second))
    body = (st.Begin(0), *rows, st.End(0))
    return st.Routine(names.routine, 0, body, PointTable(), parameters=parameters, returns=returns)


def _power(names: _HelperNames, _: str) -> st.Routine:
    result, count = names.result, names.counter
    rows: list[st.Statement] = [
        st.Declare(0, result.name, "real", None),
        st.Declare(0, count.name, "integer", None),
        st.Assign(0, result, ex.Number(1.0)),
        st.Assign(0, count, ex.Number(0)),
        st.While(0, ex.Compare("<", count, names.b)),
        st.Assign(0, result, ex.Binary("*", result, names.a)),
        st.Assign(0, count, ex.Binary("+", count, ex.Number(1))),
        st.EndWhile(0),
        st.Return(0, result),
    ]
    return _routine(names, ("real", "integer", "real"), rows)


def _larger(names: _HelperNames, function: str) -> st.Routine:
    test = ex.Compare(">" if function == "max" else "<", names.a, names.b)
    rows: list[st.Statement] = [st.If(0, test), st.Return(0, names.a), st.EndIf(0), st.Return(0, names.b)]
    return _routine(names, ("real", "real", "real"), rows)


def _whole(names: _HelperNames, function: str) -> st.Routine:
    """The nearest whole number, and one less or more where it lies on the other side."""
    a, result = names.a, names.result
    above, below = ex.Compare(">", result, a), ex.Compare("<", result, a)
    down: list[st.Statement] = [
        st.If(0, above),
        st.Assign(0, result, ex.Binary("-", result, ex.Number(1))),
        st.EndIf(0),
    ]
    up: list[st.Statement] = [
        st.If(0, below),
        st.Assign(0, result, ex.Binary("+", result, ex.Number(1))),
        st.EndIf(0),
    ]
    rows = {"floor": down, "ceil": up}.get(function) or [
        st.If(0, ex.Compare(">", a, ex.Number(0))),
        *down,
        st.Else(0),
        *up,
        st.EndIf(0),
    ]
    nearest = st.Assign(0, result, ex.Function("round", (a,)))
    body = [
        st.Begin(0),
        st.Declare(0, result.name, "integer", None),
        nearest,
        *rows,
        st.Return(0, result),
        st.End(0),
    ]
    given = (st.Parameter(a.name, "real"),)
    return st.Routine(names.routine, 0, tuple(body), PointTable(), parameters=given, returns="integer")


def _bits(names: _HelperNames, operator: str) -> st.Routine:
    """Bit by bit, the lowest first; `count` is the value of the bit."""
    _, a, b, result, count = names
    last_a, last_b = (ex.Binary("mod", one, ex.Number(2)) for one in (a, b))
    both = ex.Logic(ex.Compare("=", last_a, ex.Number(1)), (("and", ex.Compare("=", last_b, ex.Number(1))),))
    tests: dict[str, ex.Expression] = {
        "and": both,
        "or": ex.Compare(">", ex.Binary("+", last_a, last_b), ex.Number(0)),
        "xor": ex.Compare("<>", last_a, last_b),
    }
    left = ex.Logic(ex.Compare(">", a, ex.Number(0)), (("or", ex.Compare(">", b, ex.Number(0))),))
    rows: list[st.Statement] = [
        st.Declare(0, result.name, "integer", None),
        st.Declare(0, count.name, "integer", None),
        st.Assign(0, result, ex.Number(0)),
        st.Assign(0, count, ex.Number(1)),
        st.While(0, left),
        st.If(0, tests[operator]),
        st.Assign(0, result, ex.Binary("+", result, count)),
        st.EndIf(0),
        st.Assign(0, a, ex.Binary("div", a, ex.Number(2))),
        st.Assign(0, b, ex.Binary("div", b, ex.Number(2))),
        st.Assign(0, count, ex.Binary("*", count, ex.Number(2))),
        st.EndWhile(0),
        st.Return(0, result),
    ]
    return _routine(names, ("integer", "integer", "integer"), rows)


def _number_of_state(names: _HelperNames, _: str) -> st.Routine:
    state = names.a
    on = ex.Compare("=", state, ex.SignalState(True))
    rows = (
        st.Begin(0),
        st.If(0, on),
        st.Return(0, ex.Number(1)),
        st.EndIf(0),
        st.Return(0, ex.Number(0)),
        st.End(0),
    )
    given = (st.Parameter(state.name, "boolean"),)
    return st.Routine(names.routine, 0, rows, PointTable(), parameters=given, returns="integer")


COMPUTED: Final[dict[str, Callable[[_HelperNames, str], st.Routine]]] = {
    "power": _power,
    "max": _larger,
    "min": _larger,
    **dict.fromkeys(_WHOLE, _whole),
    **dict.fromkeys(_BITS, _bits),
    **dict.fromkeys((_STATE, _CONDITION), _number_of_state),
}


# --- Poses ---
# Products and inverses of poses, for controllers that add position registers and no more.

_PLACES: Final = ("x", "y", "z")
_ANGLES: Final = ("rx", "ry", "rz")
_FLAT: Final = ex.Number(0.00001)  # cosine of an angle about y of which no angles about x and z are known
_MULTIPLIED: Final = ("pose-product", "pose-inverse")


def pose_products(program: st.Program, work: TranslationContext) -> st.Program:
    """Variables that are set to a product of two poses or to an inverse get it from a routine.

    R = Rz Ry Rx, which its matrix gives. Moves to a product stay: they have offsets. So does what never changes.
    """
    if work.limits.multiplies_poses or work.source.vendor == work.target:
        return program
    own = _PoseProducts(work, work.symbols(program))
    routines = [with_rows(r, [row for s in r.body for row in own.rows(s, r.name)]) for r in program.routines]
    if not own.made:
        return program
    work.note_once(f"{language_of(work.target)} multiplies no poses: a routine of the translation does")
    return replace(program, routines=(*routines, *own.made.values()), data=(*program.data, *own.declared))


@dataclass(slots=True)
class _PoseProducts:
    work: TranslationContext
    symbols: Symbols
    made: dict[str, st.Routine] = field(default_factory=dict)  # by the function's name
    declared: list[st.Declare] = field(default_factory=list)
    scratch: dict[str, ex.Named] = field(default_factory=dict)  # numbers that both routines compute with

    def rows(self, s: st.Statement, routine: str) -> list[st.Statement]:
        if not isinstance(s, st.Assign) or not any(map(self._is_asked, expressions_of(s.value))):
            return [s]
        before: list[st.Statement] = []
        value = mapped(s.value, partial(self._changed, routine, before, s.line))
        last = before[-1] if before else None
        if isinstance(last, st.Call) and last.result == value:
            return [*before[:-1], replace(last, result=s.target, comment=s.comment)]
        return [*before, replace(s, value=value)]

    def _is_asked(self, e: ex.Expression) -> bool:
        return isinstance(e, ex.Function) and e.name in _MULTIPLIED

    def _changed(
        self, routine: str, before: list[st.Statement], line: int, e: ex.Expression
    ) -> ex.Expression:
        if not isinstance(e, ex.Function):
            return e
        if not self._is_asked(e) or all(self._is_known(a, routine) for a in e.arguments):
            return e
        if e.name == "pose-product" and (shifted := _shifted(e)) is not None:
            return shifted
        result = ex.Named(self.work.helper("computed_pose"))
        self.declared.append(st.Declare(0, result.name, "position", None, shared=True))
        tool = e.name == "pose-product" and self._is_written_out(e.arguments[1], routine)
        before.append(
            st.Call(line, self._routine("tool-product" if tool else e.name), e.arguments, result=result)
        )
        return result

    def _is_known(self, e: ex.Expression, routine: str) -> bool:
        if isinstance(e, ex.Function):
            return self._is_asked(e) and all(self._is_known(a, routine) for a in e.arguments)
        return not (isinstance(e, ex.Named) and e.name in self.work.registers) and isinstance(
            self.symbols.fixed_value(routine, e), ex.PositionLiteral
        )

    def _is_written_out(self, e: ex.Expression, routine: str) -> bool:
        """Whether a pose is known, or put together from numbers: no place that the arm goes to as it is."""
        places = (
            one
            for one in expressions_of(e)
            if kind_of_value(self.symbols, routine, one) in ("position", "joints")
        )
        return self._is_known(e, routine) or not any(isinstance(one, (ex.Named, ex.Item)) for one in places)

    def _routine(self, function: str) -> str:
        if function not in self.made:
            own = _PoseRoutine(self.work, self.scratch)
            self.made[function] = own.inverse() if function == "pose-inverse" else own.product(function)
        return self.made[function].name


def _shifted(e: ex.Function) -> ex.Expression | None:
    """A pose behind one that does not turn: what is added to its place [mm]. None for any other product."""
    first, second = e.arguments
    if not isinstance(first, ex.PositionLiteral) or first.kind != "pose" or any(first.values[3:]):
        return None
    return ex.Function("pose-offset", (second, *(ex.Number(round(v / mm, 6)) for v in first.values[:3])))


@dataclass(slots=True)
class _PoseRoutine:
    """The statements of a routine that multiplies or inverts poses."""

    work: TranslationContext
    scratch: dict[str, ex.Named]
    rows: list[st.Statement] = field(default_factory=list)

    def product(self, function: str) -> st.Routine:
        """The arm's posture is that of the second pose; of the first one where the second is what a tool adds."""
        first, second, result = (ex.Named(self.work.helper(one)) for one in ("first", "second", "product"))
        self._matrix(first)
        self.rows.append(st.Assign(0, result, first if function == "tool-product" else second))
        self._multiply(first, second, result)
        return self._routine(function.replace("-", "_"), (first, second), result)

    def inverse(self) -> st.Routine:
        first, result = (ex.Named(self.work.helper(one)) for one in ("pose", "inverse"))
        self._matrix(first)
        self.rows.append(st.Assign(0, result, first))
        self._invert(first, result)
        return self._routine("pose_inverse", (first,), result)

    def _routine(self, stem: str, given: Sequence[ex.Named], result: ex.Named) -> st.Routine:
        self._angles(result)
        declared = st.Declare(0, result.name, "position", None)
        body = (st.Begin(0), declared, *self.rows, st.Return(0, result), st.End(0))
        parameters = tuple(st.Parameter(one.name, "position") for one in given)
        name = self.work.helper(stem)
        return st.Routine(name, 0, body, PointTable(), parameters=parameters, returns="position")

    def _name(self, stem: str) -> ex.Named:
        if stem not in self.scratch:
            self.scratch[stem] = ex.Named(self.work.helper(stem))
        return self.scratch[stem]

    def _set(self, stem: str, value: ex.Expression) -> None:
        self.rows.append(st.Assign(0, self._name(stem), value))

    def _turns(self, pose: ex.Named) -> tuple[ex.Named, ...]:
        """Cosine and sine of the three angles."""
        for axis in _ANGLES:
            self._set("angle", ex.Member(pose, axis))
            self._set(f"cos_{axis}", ex.Function("cos", (self._name("angle"),)))
            self._set(f"sin_{axis}", ex.Function("sin", (self._name("angle"),)))
        return tuple(self._name(f"{what}_{axis}") for axis in _ANGLES for what in ("cos", "sin"))

    def _columns(self, pose: ex.Named) -> list[list[ex.Expression]]:
        """The axes of a pose: of R = Rz Ry Rx its columns."""
        cx, sx, cy, sy, cz, sz = self._turns(pose)
        return [
            [_times(cz, cy), _times(sz, cy), ex.Binary("-", ex.Number(0), sy)],
            [
                ex.Binary("-", _times(cz, sy, sx), _times(sz, cx)),
                ex.Binary("+", _times(sz, sy, sx), _times(cz, cx)),
                _times(cy, sx),
            ],
            [
                ex.Binary("+", _times(cz, sy, cx), _times(sz, sx)),
                ex.Binary("-", _times(sz, sy, cx), _times(cz, sx)),
                _times(cy, cx),
            ],
        ]

    def _matrix(self, pose: ex.Named) -> None:
        for column, values in zip("xyz", self._columns(pose), strict=True):
            for row, value in zip("xyz", values, strict=True):
                self._set(f"a_{row}{column}", value)

    def _multiply(self, first: ex.Named, second: ex.Named, result: ex.Named) -> None:
        places = [ex.Member(second, axis) for axis in _PLACES]
        for row in _PLACES:
            value = self._row(row, places)
            self.rows.append(
                st.Assign(0, ex.Member(result, row), ex.Binary("+", ex.Member(first, row), value))
            )
        wanted = {"x": "xyz", "y": "xyz", "z": "z"}
        for column, values in zip("xyz", self._columns(second), strict=True):
            for row, value in zip("xyz", values, strict=True):
                self._set(f"b_{row}", value)
            axis = [self._name(f"b_{row}") for row in "xyz"]
            for row in wanted[column]:
                self._set(f"r_{row}{column}", self._row(row, axis))

    def _row(self, row: str, column: Sequence[ex.Expression]) -> ex.Expression:
        """A row of the first matrix times a column."""
        x, y, z = (_times(self._name(f"a_{row}{at}"), value) for at, value in zip("xyz", column, strict=True))
        return ex.Binary("+", ex.Binary("+", x, y), z)

    def _invert(self, first: ex.Named, result: ex.Named) -> None:
        places = [ex.Member(first, axis) for axis in _PLACES]
        for column in _PLACES:
            x, y, z = (
                _times(self._name(f"a_{at}{column}"), value) for at, value in zip("xyz", places, strict=True)
            )
            total = ex.Binary("+", ex.Binary("+", x, y), z)
            self.rows.append(st.Assign(0, ex.Member(result, column), ex.Binary("-", ex.Number(0), total)))
        for one in ("xx", "yx", "zx", "xy", "yy", "zy", "zz"):
            self._set(f"r_{one}", self._name(f"a_{one[::-1]}"))

    def _angles(self, result: ex.Named) -> None:
        """The angles of R = Rz Ry Rx; where Ry turns by a right angle, Rz by none."""
        r = {one: self._name(f"r_{one}") for one in ("xx", "yx", "zx", "xy", "yy", "zy", "zz")}
        self._set("flat", ex.Binary("+", _times(r["xx"], r["xx"]), _times(r["yx"], r["yx"])))
        self._set("flat", ex.Function("sqrt", (self._name("flat"),)))
        self._set("angle", ex.Binary("-", ex.Number(0), r["zx"]))
        self._angle(result, "ry", self._name("angle"), self._name("flat"))
        self.rows.append(st.If(0, ex.Compare(">", self._name("flat"), _FLAT)))
        self._angle(result, "rx", r["zy"], r["zz"])
        self._angle(result, "rz", r["yx"], r["xx"])
        self.rows.append(st.Else(0))
        self._set("angle", _times(r["xy"], self._name("angle")))
        self._angle(result, "rx", self._name("angle"), r["yy"])
        self.rows += [st.Assign(0, ex.Member(result, "rz"), ex.Number(0)), st.EndIf(0)]

    def _angle(self, result: ex.Named, axis: str, sine: ex.Named, cosine: ex.Named) -> None:
        self._set("turn", ex.Function("atan2", (sine, cosine)))
        self.rows.append(st.Assign(0, ex.Member(result, axis), self._name("turn")))


def _times(first: ex.Expression, *others: ex.Expression) -> ex.Expression:
    return reduce(partial(ex.Binary, "*"), others, first)
