"""How a program uses the names that nothing at hand declares: what tells their type, and how large their arrays are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from olp.ir.expressions import (
    Binary,
    CallValue,
    Compare,
    Expression,
    FrameRef,
    Function,
    Item,
    Logic,
    Member,
    Named,
    Number,
    Quantity,
    Signal,
    Unary,
)
from olp.ir.program import (
    Assign,
    Call,
    Case,
    DefineFrame,
    Dwell,
    ElseIf,
    For,
    If,
    Jump,
    Move,
    Path,
    Program,
    PulseOutput,
    ReadInput,
    Return,
    Routine,
    SetFrame,
    SetOutput,
    SetTool,
    ShiftOn,
    Statement,
    Switch,
    Until,
    Update,
    Wait,
    While,
)
from olp.ir.transformer import calls_nothing, expressions_of, sets_numbers
from olp.languages.vendor import conventions_of
from olp.transpile.constant_folding import paired
from olp.transpile.context import TranslationContext
from olp.transpile.name_types import AXES, COMPONENTS, KINDS, NUMERIC, PLACES, TARGET, Use, taken
from olp.transpile.occurrences import Look
from olp.transpile.symbols import Symbols, kind_of_value


def uses_of(program: Program, work: TranslationContext) -> dict[str, Use]:
    """The names of `program` that nothing declares, in order of their first use."""
    symbols = work.symbols(program)
    if not any(_uses_unknown(routine, symbols, work.look(routine)) for routine in program.routines):
        return {}
    seen = _Seen(program, symbols)
    for routine in program.routines:
        seen.look_at(routine)
    seen.spread()
    return seen.uses


def _uses_unknown(routine: Routine, symbols: Symbols, look: Look) -> bool:
    """Whether a routine names anything that nothing declares."""
    for name in look.names() - symbols.declared.keys():
        symbol = symbols.find(routine.name, name)
        if symbol is None or not symbol.declared:
            return True
    return False


@dataclass(slots=True)
class _Seen:
    program: Program
    symbols: Symbols
    uses: dict[str, Use] = field(default_factory=dict)
    links: list[tuple[str, str]] = field(default_factory=list)  # names that hold the same kind of value
    routine: Routine = field(init=False)
    counted: dict[str, list[int | None]] = field(
        default_factory=dict
    )  # of loops that are open: largest value
    loops: list[str] = field(default_factory=list)
    statement: Statement = field(init=False)

    def look_at(self, routine: Routine) -> None:
        self.routine = routine
        for s in routine.body:
            self.statement = s
            if type(s) is Move:
                self._move(s)
            if calls_nothing(s) or sets_numbers(s):
                continue
            handle = _STATEMENTS.get(type(s))
            if handle is not None:
                handle(self, s)
            for e in expressions_of(s):  # whatever no rule looks into
                if type(e) is Named:
                    self._use(e)

    def spread(self) -> None:
        """Names that are compared with or assigned to each other are of one type."""
        changed = True
        while changed:
            changed = False
            for left, right in self.links:
                one, other = self.uses[left].kinds, self.uses[right].kinds
                if one != other:
                    one |= other
                    other |= one
                    changed = True

    # --- names ------------------------------------------------------------------------------------------

    def _use(self, e: Expression | None) -> Use | None:
        """What is known of a name that nothing declares, None for any other expression."""
        if type(e) is not Named:
            return None
        found = self.uses.get(e.name)
        if found is not None and not self._is_own(e.name):
            return found
        symbol = self.symbols.find(self.routine.name, e.name)
        if symbol is not None and symbol.declared:
            return None
        return self.uses.setdefault(e.name, Use(e.name, self.statement))

    def _is_own(self, name: str) -> bool:
        return (self.routine.name, name) in self.symbols.table

    def _kind(self, e: Expression | None) -> str:
        """What a value is by its own; a number that is written out tells little."""
        if type(e) is Number:
            return ""
        if self._bare(e) is not None:
            return ""
        return kind_of_value(self.symbols, self.routine.name, e)

    def _bare(self, e: Expression | None) -> Use | None:
        """The undeclared name that an expression is, or an element of."""
        return self._use(e.base) if type(e) is Item else self._use(e)

    # --- expressions ------------------------------------------------------------------------------------

    def see(self, e: Any, kind: str = "") -> None:
        """An expression where a value of this kind is taken."""
        match e:
            case Named():
                use = self._use(e)
                if use is not None:
                    use.whole = True
                    use.kinds |= {kind} - {""}
            case Item(base, indices):
                self._item(base, indices, kind)
            case Member(base, name):
                self._member(base, name.casefold())
            case Binary(operator, left, right):
                self._binary(operator, left, right, kind)
            case Compare(_, left, right):
                self._same(left, right)
            case Logic(first, rest):
                for part in (first, *(condition for _, condition in rest)):
                    self.see(part, "boolean")
            case Unary(operator, operand):
                self.see(operand, "boolean" if operator == "not" else kind if kind in NUMERIC else "real")
            case Function(name, arguments):
                for argument, kind in zip(arguments, taken(name, len(arguments)), strict=True):
                    self.see(argument, kind)
            case Signal(_, index) | FrameRef(_, index):
                self.see(index, "integer")
            case CallValue(name, arguments):
                self._arguments(name, arguments)
            case Quantity(written, _):
                self.see(written, "real")

    def _item(self, base: Expression, indices: tuple[Expression, ...], kind: str) -> None:
        for index in indices:
            self.see(index, "integer")
        use = self._use(base)
        if use is None:
            self.see(base)
            return
        largest = tuple(self._largest(index) for index in indices)
        use.indices.append(largest)
        use.kinds |= {kind} - {""}
        if any(self._largest(index) is None for index in indices):
            use.computed.add(self.statement.line)

    def _largest(self, index: Expression) -> int | None:
        """The largest value of an index that is written out, or that an open loop counts; None: not known here."""
        match index:
            case Number(value):
                return int(value)
            case Named(name):
                return (self.counted.get(name) or [None])[-1]
            case Binary("+" | "-" as operator, left, Number(value)):
                largest = self._largest(left)
                return None if largest is None else largest + int(value if operator == "+" else -value)
        return None

    def _member(self, base: Expression, name: str) -> None:
        kind = "position" if name in COMPONENTS else "joints" if name in AXES else ""
        use = None if kind or type(base) is not Named else self._use(base)
        if use is None:
            self.see(base, kind)
        else:
            use.records.add(name)

    def _binary(self, operator: str, left: Expression, right: Expression, kind: str) -> None:
        if operator in ("div", "mod"):
            inner = "integer"
        elif operator in ("and", "or", "xor"):
            inner = "integer" if kind in NUMERIC else "boolean"
        elif operator == "/":
            inner = "real"
        else:
            sides = {self._kind(left), self._kind(right)} - set(NUMERIC) - {""}
            inner = next(iter(sides)) if sides else kind if kind in ("integer", *PLACES, "string") else "real"
        self.see(left, inner)
        self.see(right, inner)

    def _same(self, left: Expression, right: Expression) -> None:
        """Two values that are compared, or one that is assigned to the other."""
        first, second = self._bare(left), self._bare(right)
        if first is not None and second is not None and first is not second:
            self.links.append((first.name, second.name))
        for one, other in ((left, right), (right, left)):
            self.see(one, "real" if type(other) is Number else self._kind(other))

    def _arguments(self, routine: str, arguments: tuple[Expression, ...]) -> None:
        called = self.symbols.routines.get(routine)
        if called is None:
            for argument in arguments:
                self.see(argument)
            return
        kinds = {p.name: p.type for p in called.parameters}
        for name, value in paired(called.parameters, arguments):
            self.see(value, kinds.get(name, "") if kinds.get(name, "") in KINDS else "")

    # --- statements -------------------------------------------------------------------------------------

    def _move(self, s: Move) -> None:
        if not calls_nothing(s):
            for measured in (s.speed, s.blend, s.rate):
                if measured is not None and measured.value is not None:
                    self.see(measured.value)
            for quantity in (s.acceleration, s.deceleration, s.arc, s.turn):
                self.see(quantity)
            for pose in (s.via, s.offset, s.tool_offset):
                self.see(pose, "position")
            self.see(s.until, "boolean")
        kind = "position" if s.path is not Path.JOINT else self._joint_target(s)
        for target in s.targets:
            self.see(target, kind)
        self.see(s.tool, "tool")
        self.see(s.frame, "frame")

    def _joint_target(self, s: Move) -> str:
        """The instruction may say whether a joint move goes to axis values; the neutral move does not."""
        word = conventions_of(self.program.vendor).joint_target_word
        if not word:
            return TARGET
        return "joints" if word in self.program.source.line(s.line).casefold() else "position"

    def _for(self, s: For) -> None:
        self._same(s.variable, s.start)
        fraction = any(
            type(e) is Number and not float(e.value).is_integer() for e in (s.start, s.stop, s.step)
        )
        for e in (s.variable, s.start, s.stop, s.step):
            self.see(e, "real" if fraction else "integer")
        name = s.variable.name if isinstance(s.variable, Named) else ""
        bounds = [e.value for e in (s.start, s.stop) if type(e) is Number]
        self.counted.setdefault(name, []).append(int(max(bounds)) if len(bounds) == 2 else None)
        self.loops.append(name)

    def _next(self, s: Statement) -> None:
        if self.loops:
            self.counted[self.loops.pop()].pop()

    def _assign(self, s: Assign) -> None:
        use = self._use(s.target)
        if use is not None:
            use.assigned = True
        self._same(s.target, s.value)

    def _switch(self, s: Switch) -> None:
        cases = [value for one in self.routine.body if type(one) is Case for value in one.values]
        whole = all(type(value) is Number and float(value.value).is_integer() for value in cases)
        self.see(s.value, "integer" if whole else self._kind(cases[0]))
        for value in cases:
            self.see(value)

    def _output(self, s: SetOutput) -> None:
        kind = kind_of_value(self.symbols, self.routine.name, s.signal)
        self.see(s.signal)
        numeric = conventions_of(self.program.vendor).numeric_booleans
        self.see(s.value, "integer" if kind == "boolean" and numeric else kind)

    def _call(self, s: Call) -> None:
        self._arguments(s.routine, s.arguments)
        called = self.symbols.routines.get(s.routine)
        self.see(s.result, "" if called is None else called.returns)
        self.see(s.condition, "boolean")


_Handler = Callable[[_Seen, Any], None]


def _condition(seen: _Seen, s: Any) -> None:
    seen.see(s.condition, "boolean")


def _seeing(**kinds: str) -> _Handler:
    def handle(seen: _Seen, s: Any) -> None:
        for name, kind in kinds.items():
            seen.see(getattr(s, name), kind)

    return handle


def _read(seen: _Seen, s: ReadInput) -> None:
    seen.see(s.signal)
    seen.see(s.target, kind_of_value(seen.symbols, seen.routine.name, s.signal))


def _update(seen: _Seen, s: Update) -> None:
    if s.operand is not None:
        seen._same(s.target, s.operand)


def _define(seen: _Seen, s: DefineFrame) -> None:
    for point in s.points:
        seen.see(point, "position")


def _return(seen: _Seen, s: Return) -> None:
    seen.see(s.value, seen.routine.returns if seen.routine.returns in KINDS else "")


_STATEMENTS: Final[dict[type, _Handler]] = {
    Assign: _Seen._assign,
    Call: _Seen._call,
    DefineFrame: _define,
    Dwell: _seeing(duration="real"),
    ElseIf: _condition,
    For: _Seen._for,
    If: _condition,
    Jump: _condition,
    PulseOutput: _seeing(signal="", duration="real", condition="boolean"),
    ReadInput: _read,
    Return: _return,
    SetFrame: _seeing(frame="frame"),
    SetOutput: _Seen._output,
    SetTool: _seeing(tool="tool"),
    ShiftOn: _seeing(offset="position"),
    Switch: _Seen._switch,
    Until: _condition,
    Update: _update,
    Wait: _condition,
    While: _condition,
}
