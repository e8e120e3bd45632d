"""Names become numbers: variables and registers by their kind, points by the moves that go there."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.points import PointBlock, PointKind, PointState, PointTable
from olp.ir.transformer import edited, expressions_of, is_usual, is_written_out, mapped, note_names
from olp.languages.limits import Registers
from olp.languages.vendor import language_of
from olp.runtime.spelling import spell
from olp.transpile.arrays import largest_indices, sizes_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.first_values import is_untaught, lasts, with_zeros
from olp.transpile.reaching_definitions import ENTRY, Key, reaching
from olp.transpile.symbols import Symbol, Symbols, kind_of_value, symbols_of

# --- Position registers ---
# Numbers for variables and positions, and positions that are computed step by step.

_NUMBERED: Final = re.compile(r"X?[CP]?\d+")  # names that say nothing: C00012, P3, XP3
MEMBERS: Final = ("x", "y", "z", "rx", "ry", "rz", "e1", "e2")
_NO_FLAGS: Final = (1, 0, 0, 0, 0, 0)  # N U T


@dataclass(slots=True)
class PositionNumbers:
    """`points`: taught points of each routine; `constants`: positions that the program sets when it is loaded."""

    work: TranslationContext
    symbols: Symbols
    program: st.Program
    arrays: Mapping[str, int] = field(default_factory=dict)  # largest index written of each
    numbers: dict[str, int] = field(default_factory=dict)
    taken: dict[ex.Store, set[int]] = field(default_factory=dict)
    unfree: dict[tuple[ex.Store, int], int] = field(
        default_factory=dict
    )  # of so many numbers in a row, none that begins below is free
    # By value and place, and by name those that were never taught: each is taught by itself.
    points: dict[str, dict[tuple[ex.PositionLiteral, Place, str], int]] = field(default_factory=dict)
    names: dict[tuple[str, int], str] = field(
        default_factory=dict
    )  # of taught points, for languages that show them
    constants: dict[tuple[ex.PositionLiteral, Place], int] = field(default_factory=dict)
    places: dict[str, Place] = field(
        default_factory=dict
    )  # of position variables: where moves take them to be
    initial: dict[int, tuple[ex.PositionLiteral, Place]] = field(default_factory=dict)
    routine_name: str = ""
    before: list[st.Statement] | None = None  # what runs before the statement under way, where anything can
    line: int = 0
    indices: int = 0  # of elements, computed for the statement under way
    computed: dict[str, list[int]] = field(
        default_factory=dict
    )  # position variables for one statement each; of each routine, where several run at once
    at_once: bool = False
    under_way: int = 0  # how many of them the statement under way needs
    # Variables for which no number is left, with the lines that fall, empty: each use.
    beyond: dict[str, set[int]] = field(default_factory=dict)
    choosing: dict[str, set[int]] | None = None  # array -> lines that take an element by a computed index
    told: bool = False  # that configurations are those of the plan
    lines: Mapping[str, int] = field(default_factory=dict)  # where each variable is declared, 0: nowhere
    owners: Mapping[str, str] = field(default_factory=dict)  # variable -> the routine that has it for itself
    owned: dict[str, dict[ex.Store, int]] = field(default_factory=dict)  # routine -> how many of each kind

    @property
    def registers(self) -> Registers:
        """The target's numbered variables."""
        assert self.work.limits.registers is not None
        return self.work.limits.registers

    # --- variables --------------------------------------------------------------------------------------

    def _store(self, symbol: Symbol) -> ex.Store:
        return self.registers.stores.get(
            symbol.type or "real", ex.Store.REAL if symbol.type != "position" else ex.Store.ROBOT
        )

    def variable(self, e: ex.Named) -> ex.Variable:
        """The numbered variable that a name becomes."""
        symbol = self.symbols.find("", e.name)
        if symbol is None:  # every pass declares what it makes, and `declarations` all others
            # Tools and frames of an array have numbers by now, and are no data any more.
            declared = any(one.name == e.name for one in self.work.source.data)
            says = (
                "which element it takes is computed while the program runs"
                if declared
                else "declared nowhere"
            )
            self.work.lose(self.line, Fate.REFUSED, "variable", f"{e.name}: {says}")
            symbol = Symbol(e.name, "real")
        store = self._store(symbol)
        known = self.numbers.get(e.name)
        owner = self.owners.get(e.name)
        if known is None and owner is not None:
            counts = self.owned.setdefault(owner, {})
            known = self.numbers[e.name] = counts.get(store, 0)
            counts[store] = known + 1
            shown = self.registers.variable.format(letter=f"L{self.registers.letters[store]}", number=known)
            self.work.names[("variable", e.name)] = shown
        elif known is None:
            known = self.numbers[e.name] = self._allocate(e.name, store, self._size(symbol))
        elif e.name in self.beyond and not self.beyond[e.name]:
            self._refuse_beyond(e.name, store)
        return ex.Variable(store, ex.Number(known), owner is not None, e.name)

    def keep_apart(self, program: st.Program) -> None:
        """Where the program has more variables of a kind than the target, routines have theirs for themselves."""
        if not self.registers.routines_own:
            return
        needed: dict[ex.Store, int] = {}
        kinds: dict[str, ex.Store] = {}
        used = set[str]().union(*(self.work.look(r).names() for r in program.routines))
        for d in program.data:
            symbol = self.symbols.find("", d.name)
            if symbol is not None and d.name in used:
                kinds[d.name] = self._store(symbol)
                needed[kinds[d.name]] = needed.get(kinds[d.name], 0) + self._size(symbol)
        delivered = self.work.limits.numbered
        many = {s for s in self.registers.routines_own if needed.get(s, 0) > delivered.get(s, 0)}
        mapped_ = self.work.context.mapping.variables
        plain = {
            d.name
            for d in program.data
            if kinds.get(d.name) in many and d.value is None and not d.sizes and d.name not in mapped_
        }
        self.owners = _set_before_read(program, plain) if plain else {}

    def _size(self, symbol: Symbol) -> int:
        """How many numbers it takes: an array whose size nothing tells, those that are used of it."""
        sizes = sizes_of(self.symbols, symbol)
        return max(1, self.arrays.get(symbol.name, 1) if sizes is None or 0 in sizes else math.prod(sizes))

    def _allocate(self, name: str, store: ex.Store, size: int) -> int:
        taken = self.taken.setdefault(store, set())
        wanted = (
            self.work.context.mapping.variables.get(name, "")
            .lstrip("ABCDEFGHIJKLMNOPQRSTUVWXYZ[")
            .rstrip("]")
        )
        first, largest = self.registers.first_point, self.work.limits.most_numbered(store)
        if wanted.isdecimal():
            start = int(wanted)
        else:
            places = range(self.unfree.get((store, size), first), first + largest - size + 1)
            free = (at for at in places if taken.isdisjoint(range(at, at + size)))
            start = self.unfree[store, size] = next(free, first + largest)
        if start + size > first + largest:
            declared = 0 if self._is_fixed(ex.Named(name)) else self.lines.get(name, 0)
            self.beyond[name] = {declared} if declared else self._lines_choosing(name)
            self._refuse_beyond(name, store)
        else:
            taken.update(range(start, start + size))
        shown = self.registers.variable.format(letter=self.registers.letters.get(store, ""), number=start)
        self.work.names[("variable", name)] = shown
        return start

    def _refuse_beyond(self, name: str, store: ex.Store) -> None:
        """Its declaration, with which all uses fall. What is declared in no line of its own, such as a member of a
        record, falls with each use; so does what never changes: other uses of that are points. Of an array what
        chooses an element by a computed index falls first: without it the others may be no array.
        """
        most = self.work.limits.most_numbered(store)
        says = f"more than {most} variables of one kind ({terminology.STORES[store]})"
        for line in self.beyond[name] or (self.line,):
            self.work.lose(line, Fate.REFUSED, "variable", says)

    def _lines_choosing(self, array: str) -> set[int]:
        """The lines with an element of an array by a computed index."""
        if self.choosing is None:
            self.choosing = {}
            for s in self.program.statements():
                for name in filter(None, map(_chosen_array, expressions_of(s))):
                    self.choosing.setdefault(name, set()).add(s.line)
        return self.choosing.get(array, set())

    def tell_enlarged(self) -> None:
        """What the controller has to be set up for: more variables of a kind than it is delivered with."""
        for store, taken in self.taken.items():
            delivered = self.work.limits.numbered.get(store, 0)
            if taken and max(taken) >= delivered + self.registers.first_point:
                shown = self.registers.variable.format(
                    letter=self.registers.letters.get(store, ""), number=max(taken)
                )
                says = "set the controller up for more variables than it is delivered with"
                self.work.ask(says, f"{shown} is used, {delivered} are delivered")

    def _change(self, e: ex.Expression) -> ex.Expression:
        if type(e) is ex.Named:
            symbol = self.symbols.find("", e.name)
            if symbol is not None and self._store(symbol) is ex.Store.ROBOT and self._is_fixed(e):
                return e  # where it stands decides what becomes of it
            return self.variable(e)
        if (
            isinstance(e, (ex.Item, ex.Member))
            and type(e.base) is ex.Named
            and (held := self._held(e)) is not None
        ):
            return held
        if type(e) is ex.Item and len(e.indices) == 1 and isinstance(e.base, (ex.Variable, ex.Named)):
            base = e.base
            if isinstance(base, ex.Named):
                symbol = self.symbols.find("", base.name)
                if isinstance(e.indices[0], ex.Number) or symbol is None or not symbol.sizes:
                    return e
                base = self.variable(base)  # one of several that nothing changes, by a computed number
            if not isinstance(base.index, ex.Number):
                return e  # an element of an element
            if self._is_joints(base):
                if self.registers.joint_elements:
                    self.work.lose(self.line, Fate.REFUSED, "element", self.registers.joint_elements)
                return e
            index = e.indices[0]
            if isinstance(index, ex.Number):
                return replace(base, index=ex.Number(int(base.index.value) + int(index.value) - 1), name="")
            return replace(base, index=self._shifted(index, int(base.index.value) - 1), name="")
        return e

    def _held(self, e: ex.Item | ex.Member) -> ex.Number | None:
        """One number of a position that nothing changes [mm or deg], None where it is not known."""
        fixed = self._fixed(e.base)
        if fixed is None:
            return None
        if isinstance(e, ex.Member):
            place = MEMBERS.index(e.name) if fixed.kind == "pose" and e.name in MEMBERS[:6] else -1
            scale = mm if e.name in MEMBERS[:3] else deg
        else:
            index = e.indices[0] if fixed.kind == "joint" and len(e.indices) == 1 else None
            place = int(index.value) - 1 if isinstance(index, ex.Number) else -1
            scale = deg
        if not 0 <= place < len(fixed.values) or math.isnan(fixed.values[place]):
            return None
        value = round(fixed.values[place] / scale, 6)
        return ex.Number(int(value) if value.is_integer() else value)

    def _is_joints(self, e: ex.Variable) -> bool:
        """Whether it holds joint values, whose elements are axes; one without a name is an element of an array."""
        if e.store is ex.Store.ROBOT and not e.name:
            return True
        symbol = self.symbols.find("", e.name) if e.name and e.store is ex.Store.ROBOT else None
        return symbol is not None and symbol.type == "joints" and not symbol.sizes

    def _shifted(self, index: ex.Expression, shift: int) -> ex.Expression:
        """The number of an element: one variable is all that a number may be computed by."""
        fits = isinstance(index, ex.Variable) and (
            self.registers.real_index or index.store is not ex.Store.REAL
        )
        if not shift and fits:
            return index
        if shift:
            index = ex.Binary("+" if shift > 0 else "-", index, ex.Number(abs(shift)))
        if self.before is None:
            return index  # of a loop: the writer says that it cannot
        self.indices += 1
        kept = self.variable(ex.Named(self._whole(f"element_index{self.indices}")))
        self.before.append(st.Assign(self.line, kept, index))
        return kept

    # --- positions --------------------------------------------------------------------------------------

    def note_places(self, program: st.Program) -> None:
        """In which frame and with which tool each position variable is used."""
        for routine in program.routines:
            for s in routine.body:
                if type(s) is st.Move and not (s.via is None and self._is_fixed(s.targets[0])):
                    place = place_of(s)
                    for target in (*s.targets, *(() if s.via is None else (s.via,))):
                        self._note(target, place)
        set_to = [
            (target_name, _leading(s.value))
            for s in program.statements()
            if type(s) is st.Assign
            for target_name in _leading(s.target)
        ]
        for _ in range(4):
            for target_name, names in set_to:
                if target_name in self.places:
                    for name in names:
                        self.places.setdefault(name, self.places[target_name])

    def _place(self, e: ex.Expression, otherwise: Place) -> Place:
        """The frame and the tool of a position variable, or of the array whose element it is, where moves use it."""
        return next((self.places[name] for name in _leading(e) if name in self.places), otherwise)

    def _is_fixed(self, target: ex.Expression) -> bool:
        """Whether a name's value is known and nothing changes it; a register without one is others' to set."""
        if type(target) is not ex.Named or target.name in self.work.registers:
            return False
        return self.symbols.is_fixed(target.name)

    def _note(self, target: ex.Expression, place: Place) -> None:
        computed = type(target) is ex.Item and any(type(index) is not ex.Number for index in target.indices)
        for name in _leading(target):
            if self.symbols.find("", name) is None or (self._is_fixed(ex.Named(name)) and not computed):
                continue
            self.places.setdefault(name, place)

    def constant(self, literal: ex.PositionLiteral, place: Place, name: str = "") -> ex.Variable:
        """A position variable that has this value when the program is loaded."""
        key = (literal, place)
        at = self.constants.get(key)
        if at is None:
            at = self.constants[key] = self._allocate(name or self.work.helper("position"), ex.Store.ROBOT, 1)
            self.initial[at] = key
        return ex.Variable(ex.Store.ROBOT, ex.Number(at))

    def taught(self, literal: ex.PositionLiteral, place: Place, name: str, untaught: str = "") -> ex.Taught:
        points = self.points.get(self.routine_name)
        if points is None:
            points = self.points[self.routine_name] = {}
        registers = self.work.limits.registers
        assert registers is not None
        new = len(points) + registers.first_point
        at = points.setdefault((literal, place, untaught), new)
        if at == new:
            self.names[(self.routine_name, at)] = "" if _NUMBERED.fullmatch(name) else name
            if name:
                self.work.names[("point", name)] = registers.point.format(number=at)
        return ex.Taught(ex.Store.ROBOT, at)

    def _with_values(self, literal: ex.PositionLiteral, line: int) -> ex.PositionLiteral:
        """A position that was never taught as the target can hold it."""
        if self.work.limits.untaught_points or not is_untaught(literal):
            return literal
        says = "a position that was never taught: zeros are written in its place"
        self.work.lose(line, Fate.APPROXIMATED, "value", says)
        self.work.ask("teach what no file here declares, or copy its values", f"the position of line {line}")
        return with_zeros(literal)

    def _configured(self, literal: ex.PositionLiteral) -> ex.PositionLiteral:
        """Registers have an arm configuration with every pose; where the source has none, it is that of the plan."""
        if literal.configuration or self.registers.steps or literal.kind != "pose" or self.work.robot is None:
            return literal
        if not self.told:
            says = "the source names no arm configuration: that of the plan is written, where not known N U T: check it"
            self.work.notes.append(says)
            self.told = True
        return ex.PositionLiteral(literal.kind, literal.values, literal.external, _NO_FLAGS, literal.native)

    def _literal_or(self, e: ex.Expression) -> ex.Expression:
        fixed = self._fixed(e)
        return e if fixed is None else self._configured(fixed)

    def _fixed(self, e: ex.Expression) -> ex.PositionLiteral | None:
        if type(e) is ex.Named and e.name in self.work.registers:
            return None
        value = self.symbols.fixed_value("", e)
        return value if isinstance(value, ex.PositionLiteral) else None

    def position(
        self, e: ex.Expression, place: Place, before: list[st.Statement], line: int
    ) -> ex.Expression:
        """A position as the target computes it: statements before the one that needs it, and a variable."""
        fixed = self._fixed(e)
        if fixed is not None:
            if not self.registers.steps:
                return self._configured(fixed)
            fixed = self._with_values(fixed, line)
            return self.constant(fixed, place, e.name if isinstance(e, ex.Named) else "")
        if self.registers.steps and e == ex.SystemValue("current-pose"):
            read = self._own()
            stored = ex.Variable(ex.Store.SYSTEM, read.index)
            before.append(st.Assign(line, stored, ex.SystemValue("position-pose")))
            return read
        if not isinstance(e, ex.Function):
            variable: ex.Expression = mapped(e, self._change)
            if self.registers.steps and self._place(e, place) != place:
                return self._placed(variable, place, before, line)
            return variable
        if not self.registers.steps:
            return mapped(replace(e, arguments=tuple(self._literal_or(a) for a in e.arguments)), self._change)
        return self._computed(e, place, before, line)

    def _own(self) -> ex.Variable:
        """A position variable of the statement under way: the next statement may take the same one."""
        own = self.computed.setdefault(self.routine_name if self.at_once else "", [])
        if self.under_way == len(own):
            own.append(self._allocate(self.work.helper("position"), ex.Store.ROBOT, 1))
        self.under_way += 1
        return ex.Variable(ex.Store.ROBOT, ex.Number(own[self.under_way - 1]))

    def _computed(self, e: ex.Function, place: Place, before: list[st.Statement], line: int) -> ex.Expression:
        """Position functions one by one, offsets element by element in 0.001 mm."""
        result = self._own()
        if e.name == "pose-angles" and len(e.arguments) == 6:
            nothing = self.constant(ex.PositionLiteral("pose", (0.0,) * 6), place)
            before.append(st.Assign(line, result, nothing))
            for at, value in enumerate(e.arguments, 1):
                if value != ex.Number(0):
                    self._put(result, at, value, before, line)
            return result
        first = e.arguments[0]
        start = self.position(first, place, before, line)
        as_it_is = self._fixed(first) is None and self._place(first, place) == place
        if as_it_is and not isinstance(first, ex.Function):
            start = self._placed(start, place, before, line)
        if e.name == "pose-offset":
            before.append(st.Assign(line, result, start))
            self._add(result, e.arguments[1:4], before, line)
        elif e.name == "pose-product":
            second = self.position(e.arguments[1], place, before, line)
            before.append(st.Assign(line, result, ex.Function("pose-product", (start, second))))
        elif e.name == "pose-inverse":
            before.append(st.Assign(line, result, ex.Function("pose-inverse", (start,))))
        elif e.name == "pose-relative-tool":
            by = self._relative(e.arguments[1:], place, before, line)
            before.append(st.Assign(line, result, ex.Function("pose-product", (start, by))))
        else:
            self.work.lose(line, Fate.REFUSED, "target", terminology.function(e.name))
        return result

    def _placed(self, e: ex.Expression, place: Place, before: list[st.Statement], line: int) -> ex.Expression:
        """A position variable's numbers in another frame or with another tool: behind a pose that changes nothing."""
        nothing = self.constant(ex.PositionLiteral("pose", (0.0,) * 6), place)
        result = self._own()
        before.append(st.Assign(line, result, ex.Function("pose-product", (nothing, e))))
        return result

    def _relative(
        self, by: tuple[ex.Expression, ...], place: Place, before: list[st.Statement], line: int
    ) -> ex.Expression:
        """A pose in the tool's axes: written out, or with computed places that are added up while the program runs."""
        from olp.robots.geometry import Pose
        from olp.transpile.records import literal_of

        values = [*by, *[ex.Number(0)] * (6 - len(by))]
        literal = [v.value for v in values if isinstance(v, ex.Number)]
        turn = _turned(values[3:])
        if turn is None:
            self.work.lose(line, Fate.REFUSED, "target", "a turn that is computed")
            turn = np.eye(3)
        if len(literal) == len(values):
            return self.constant(literal_of(Pose(np.array(literal[:3]) * mm, turn)), place)
        result = self._own()
        before.append(st.Assign(line, result, self.constant(literal_of(Pose(np.zeros(3), turn)), place)))
        self._add(result, values[:3], before, line)
        return result

    def _add(
        self, target: ex.Variable, by: Iterable[ex.Expression], before: list[st.Statement], line: int
    ) -> None:
        for at, offset in enumerate(by, 1):
            if isinstance(offset, ex.Number) and (not offset.value or offset.value != offset.value):
                continue  # one that is left out has been refused
            count = self.variable(ex.Named(self._counter()))
            counts = counts_of(mapped(offset, self._change), 1000)
            operator = "+"
            if isinstance(counts, ex.Number) and counts.value < 0:
                counts, operator = ex.Number(-counts.value), "-"
            element = ex.Element(target, ex.Number(at))
            before.append(st.Assign(line, count, element))
            before.append(st.Assign(line, count, ex.Binary(operator, count, counts)))
            before.append(st.Assign(line, element, count))

    def _put(
        self, target: ex.Variable, at: int, value: ex.Expression, before: list[st.Statement], line: int
    ) -> None:
        """Sets an element of a position of the statement under way to a length [mm] or an angle [deg]."""
        count = self.variable(ex.Named(self._counter()))
        scale = 1000 if at <= 3 else 10_000
        before.append(st.Assign(line, count, counts_of(mapped(value, self._change), scale)))
        before.append(st.Assign(line, ex.Element(target, ex.Number(at)), count))

    def _counter(self) -> str:
        return self._whole("element_count")

    def _whole(self, name: str) -> str:
        """A variable of the translation's own for whole numbers."""
        if name not in self.numbers:
            self.work.helpers.add(name)
            self.symbols.table[("", name)] = Symbol(name, "integer", assigned=1)
        return name


def _chosen_array(e: ex.Expression) -> str:
    """The array of which `e` is an element by a computed index, "": it is none."""
    if type(e) is ex.Item and type(e.base) is ex.Named and any(type(i) is not ex.Number for i in e.indices):
        return e.base.name
    return ""


def _turned(angles: Sequence[ex.Expression]) -> npt.NDArray[np.float64] | None:
    """The rotation of RelTool: about x, then the new y, then the new z [deg]; None where an angle is computed."""
    from olp.robots.geometry import rotation_from_angles

    turn = np.eye(3)
    for axis, angle in enumerate(angles):
        if not isinstance(angle, ex.Number):
            return None
        turn = turn @ rotation_from_angles(np.eye(3)[axis] * (angle.value * deg))
    return turn


def counts_of(value: ex.Expression, scale: int) -> ex.Expression:
    """A length or angle in the whole units that INFORM counts elements in.

    Counts stay counts in a sum: what a controller makes of the fractions in `D001 / 1000` is published nowhere.
    """
    if (known := _known(value)) is not None:
        return ex.Number(round(known * scale))
    match value:
        case ex.Binary("+" | "-" as operator, left, right) if _holds_counts(value, scale):
            return ex.Binary(operator, counts_of(left, scale), counts_of(right, scale))
        case ex.Unary("-", operand) if _holds_counts(operand, scale):
            return ex.Unary("-", counts_of(operand, scale))
        case _:
            return ex.without_decimals(ex.scaled(value, scale))


def _known(value: ex.Expression) -> float | None:
    """What comes out of numbers alone, None where anything else takes part."""
    match value:
        case ex.Number(number):
            return number
        case ex.Unary("-", operand):
            inner = _known(operand)
            return None if inner is None else -inner
        case ex.Binary("+" | "-" | "*" as operator, left, right):
            one, other = _known(left), _known(right)
            if one is None or other is None:
                return None
            return one * other if operator == "*" else one + other if operator == "+" else one - other
    return None


def _holds_counts(value: ex.Expression, scale: int) -> bool:
    """Whether a term of a sum is a count that was made a length or an angle."""
    match value:
        case ex.Binary("/", _, ex.Number(divisor)):
            return divisor == scale
        case ex.Binary("+" | "-", left, right):
            return _holds_counts(left, scale) or _holds_counts(right, scale)
        case ex.Unary("-", operand):
            return _holds_counts(operand, scale)
    return False


def _leading(e: ex.Expression) -> list[str]:
    """The position variables whose frame a computed position takes over."""
    if isinstance(e, ex.Named):
        return [e.name]
    return _leading(e.base) if isinstance(e, ex.Item) else []


# --- Register allocation ---

_NO_SYSTEMS: Final = {"tool": None, "frame": None}
_HEADS: Final = (st.While, st.Until, st.ElseIf, st.Case)  # before which nothing can run each time
_VALUES: Final = (
    "speed", "blend", "acceleration", "deceleration", "rate", "turn", "offset", "tool_offset", "until"
)  # fmt: skip


_BEGINS: Final = "see that these are started and not called: each sets what it uses to its first values"


def names_from(start: st.Routine, program: st.Program) -> Set[str]:
    """The names that a routine and those that it calls have."""
    routines = {r.name.casefold(): r for r in program.routines}
    found: set[str] = set()
    todo, seen = [start], {start.name.casefold()}
    while todo:
        for s in todo.pop().body:
            note_names(s, found)
            called = routines.get(s.routine.casefold()) if isinstance(s, st.Call) else None
            if called is not None and called.name.casefold() not in seen:
                seen.add(called.name.casefold())
                todo.append(called)
    return found


def allocate_registers(program: st.Program, work: TranslationContext) -> st.Program:
    """For languages with registers: names of variables and points become numbers."""
    before = {to: name for (kind, name), to in work.names.items() if kind == "variable"}  # it was too long
    lines = {d.name: d.line or work.declared_at.get(before.get(d.name, d.name), 0) for d in program.data}
    own = _Numbers(work, symbols_of(program), program, largest_indices(program, work), lines=lines)
    main = program.main or (program.routines[0].name if program.routines else "")
    own.note_places(program)
    own.keep_apart(program)
    own.at_once = any(isinstance(s, st.StartTask) for s in program.statements())
    bodies = [(routine, own.body(routine)) for routine in program.routines]
    routines = []
    for routine, body in bodies:
        if own.registers.framed and not (body and isinstance(body[0], st.Begin)):
            body.insert(0, st.Begin(0))
        if own.registers.framed and not isinstance(body[-1], st.End):
            body.append(st.End(0))
        at = 1 if body and isinstance(body[0], st.Begin) else 0
        body[at:at] = own.own_names(routine)
        begins = routine.name == main or routine.starts
        if begins:
            used = None if routine.name == main else names_from(routine, program)
            body[at:at] = own.prologue(program, used)
            if used is not None:
                work.ask(_BEGINS, routine.name)
        routines.append(own.routine(routine, tuple(body), begins))
    own.tell_enlarged()
    return replace(program, routines=tuple(routines), data=())


@dataclass(slots=True)
class _Numbers(PositionNumbers):
    """Statements and routines with numbers."""

    # --- statements -------------------------------------------------------------------------------------

    def body(self, routine: st.Routine) -> list[st.Statement]:
        self.routine_name = routine.name
        rows: list[st.Statement] = []
        for s in routine.body:
            before: list[st.Statement] = []
            self.before, self.line, self.indices = None if type(s) in _HEADS else before, s.line, 0
            self.under_way = 0
            new = [self._move(s, before)] if type(s) is st.Move else self._statement(s, before)
            if before:
                rows += before
            rows += new
        return rows

    def _statement(self, s: st.Statement, before: list[st.Statement]) -> list[st.Statement]:
        match s:
            case st.Declare():
                return []
            case st.Assign():
                return self._assign(s, before)
            case st.DefineFrame(points=points):
                return [replace(s, points=tuple(self.position(p, (0, None), before, s.line) for p in points))]  # type: ignore[misc]
            case _:
                return [mapped(s, self._change)]

    def _move(self, s: st.Move, before: list[st.Statement]) -> st.Move:
        place = place_of(s)
        if is_written_out(s):
            (target,) = s.targets
            changes: dict[str, Any] = {"targets": (self._target(target, place, before, s),)}
            self._called(target, s, changes)
            return edited(s, changes | _NO_SYSTEMS if self.registers.steps else changes)
        changes = {}
        if s.via is not None:  # which comes first, and so does its number
            changes["via"] = self._target(s.via, place, before, s)
        changes["targets"] = tuple([self._target(t, place, before, s) for t in s.targets])
        self._called(s.targets[0], s, changes)
        for name in ("tool", "frame", "speed", "blend") if is_usual(s) else ("tool", "frame", *_VALUES):
            old = getattr(s, name)
            if old is not None and (new := mapped(old, self._change)) is not old:
                changes[name] = new
        if self.registers.steps:
            changes |= _NO_SYSTEMS
            if (
                s.relative is not None and s.relative.kind == "own"
            ):  # a move that names no axes takes the base's
                user = place[1]
                changes["relative"] = (
                    ex.FrameRef("base") if user is None else ex.FrameRef("user", ex.Number(user))
                )
        return edited(s, changes)

    def _called(self, target: ex.Expression, s: st.Move, changes: dict[str, Any]) -> None:
        """Behind the move, what the source calls its point, where points have no names."""
        point = changes["targets"][0]
        named = type(point) is ex.Taught and type(target) is ex.Named and self.registers.comments
        if named and not s.comment and (name := self.names[(self.routine_name, point.number)]):
            changes["comment"] = name

    def _target(
        self, e: ex.Expression, place: Place, before: list[st.Statement], s: st.Move
    ) -> ex.Expression:
        fixed = self._fixed(e)
        if fixed is not None:
            fixed, own = self._configured(fixed), e.name if isinstance(e, ex.Named) else ""
            if s.relative is not None:
                return self.constant(fixed, place) if self.registers.steps else fixed
            if not is_untaught(fixed):
                return self.taught(fixed, place, own)
            untaught = spell(e)
            point = self.taught(self._with_values(fixed, s.line), place, own, untaught)
            if self.work.limits.untaught_points and self.work.source.vendor != self.work.target:
                shown = self.registers.point.format(number=point.number)
                self.work.ask("teach these points, or the program stops there", f"{shown} (line {s.line})")
            return point
        return self.position(e, place, before, s.line)

    def _assign(self, s: st.Assign, before: list[st.Statement]) -> list[st.Statement]:
        kind = kind_of_value(self.symbols, "", s.value)
        if kind in ("position", "joints", "tool", "frame"):
            # A copy has the frame and the tool of what it is used with; where no move uses it, those of its value.
            place = self._place(s.target, self._place(s.value, (0, None)))
            value = self.position(s.value, place, before, s.line)
            return [replace(s, target=mapped(s.target, self._change), value=value)]
        if self.registers.elements and isinstance(s.target, ex.Member):
            if s.target.name not in MEMBERS:
                language = language_of(self.work.target)
                says = f"{language} has no data with an element '{s.target.name}' that can be set on its own"
                self.work.lose(s, Fate.REFUSED, "element", says)
                return [s]
            return self._set_element(s)
        value = mapped(s.value, self._change)
        match value:
            case ex.SignalState(on):
                value = ex.Number(int(on))
            case ex.Binary("*", ex.Member(base, name), ex.Number(factor)) if (
                self.registers.elements and factor in (1000, 10_000) and name in MEMBERS
            ):
                value = ex.Element(base, ex.Number(MEMBERS.index(name) + 1))  # type: ignore[arg-type]
        return [replace(s, target=mapped(s.target, self._change), value=value)]

    def _set_element(self, s: st.Assign) -> list[st.Statement]:
        assert isinstance(s.target, ex.Member)
        at = MEMBERS.index(s.target.name) + 1
        base: Any = mapped(s.target.base, self._change)
        scale = 1000 if at <= 3 else 10_000
        value = mapped(s.value, self._change)
        count = self.variable(ex.Named(self._counter()))
        counts = counts_of(value, scale)
        return [
            st.Assign(s.line, count, counts),
            st.Assign(s.line, ex.Element(base, ex.Number(at)), count, s.comment),
        ]

    # --- the whole program ------------------------------------------------------------------------------

    def prologue(self, program: st.Program, used: Set[str] | None = None) -> list[st.Statement]:
        """Initial values, and which name is which number. `used`: of these names alone (None: all)."""
        rows: list[st.Statement] = []
        comments: list[st.Statement] = []
        for declare in program.data:
            if declare.name not in self.numbers or declare.name in self.owners or declare.name in self.beyond:
                continue
            if used is not None and declare.name not in used:
                continue
            symbol = self.symbols.find("", declare.name)
            if self.registers.comments:
                comments.append(
                    st.Comment(0, f"{self.work.names[('variable', declare.name)]} {declare.name}")
                )
            if declare.value is None or declare.name in self.work.registers or symbol is None:
                continue
            again = bool(symbol.assigned) and not lasts(declare, self.work)
            begins = mapped(declare.value, lambda e: with_zeros(e) if is_untaught(e) else e)
            if begins is not declare.value:  # a register without values would keep those of another program
                says = f"elements of {declare.name} have no values: zeros are written in their places"
                self.work.lose(declare, Fate.APPROXIMATED, "value", says)
            begun = self._begins(declare.name, self.variable(ex.Named(declare.name)), begins, again)
            rows += [replace(s, line=declare.line) for s in begun]
        return [*comments, *rows]

    def own_names(self, routine: st.Routine) -> list[st.Statement]:
        """Which of the routine's own variables is which."""
        names = [one for one, owner in self.owners.items() if owner == routine.name and one in self.numbers]
        return [st.Comment(0, f"{self.work.names[('variable', one)]} {one}") for one in names]

    def _begins(
        self, name: str, target: ex.Variable, value: ex.Expression, again: bool
    ) -> list[st.Statement]:
        """What gives a variable, or the elements of an array, its first value, `again` at each start of the program."""
        match value:
            case ex.PositionLiteral() if self.registers.steps and again:
                return [st.Assign(0, target, self.constant(value, self.places.get(name, (0, None))))]
            case ex.PositionLiteral() if self.registers.steps:
                assert isinstance(target.index, ex.Number)
                self.initial[int(target.index.value)] = (value, self.places.get(name, (0, None)))
                return []
            case ex.PositionLiteral() | ex.Number() | ex.Text():
                return [st.Assign(0, target, value)]
            case ex.SignalState(on):
                return [st.Assign(0, target, ex.Number(int(on)))]
            case ex.RecordLiteral(_, members) if all(not member for member, _ in members):
                assert isinstance(target.index, ex.Number)
                first = int(target.index.value)
                rows: list[st.Statement] = []
                for at, (_, one) in enumerate(members):
                    rows += self._begins(
                        name, replace(target, index=ex.Number(first + at), name=""), one, again
                    )
                return rows
        return []

    def routine(self, routine: st.Routine, body: tuple[st.Statement, ...], main: bool) -> st.Routine:
        rows = [
            (True, at, literal, place)
            for (literal, place, _), at in self.points.get(routine.name, {}).items()
        ]
        if main:
            rows += [(False, at, literal, place) for at, (literal, place) in sorted(self.initial.items())]
        details = dict(routine.details) if self.work.source.vendor == self.work.target else {}
        details |= {f"unit GP1 {name}": unit for name, unit in self.work.external_units if unit}
        rows = [
            (taught, at, _as_row(one, self.work.external_units), place) for taught, at, one, place in rows
        ]
        if not self.registers.comments:
            details |= {
                self.registers.point.format(number=at): name
                for (name_, at), name in self.names.items()
                if name_ == routine.name and name
            }
        moves = rows or main or any(isinstance(s, st.Move) for s in body)
        groups = (st.ControlGroup(("RB1",)),) if moves else ()
        return replace(
            routine,
            body=body,
            points=table(rows, self.work.limits.untaught_points),
            details=details,
            locals=self.owned.get(routine.name, {}),
            groups=groups if self.registers.framed else (),
        )


def _set_before_read(program: st.Program, names: Set[str]) -> dict[str, str]:
    """Those of the names that one routine uses alone, and gives a value on every way before it asks for it."""
    users: dict[str, set[str]] = {}
    for r in program.routines:
        for s in r.body:
            for name in _variables_in(s) & names:
                users.setdefault(name, set()).add(r.name)
    found = {name: next(iter(where)) for name, where in users.items() if len(where) == 1}

    def sets(s: st.Statement) -> Mapping[Key, int]:
        target = s.target if type(s) is st.Assign else None
        return {("own", target.name): 1} if type(target) is ex.Named and target.name in found else {}

    ways = reaching(program, sets, {st.Assign})
    for r in program.routines:
        for state, s in zip(ways.before[r.name], r.body, strict=True):
            if state is None:
                continue  # nothing ever gets there
            for name in _variables_in(s.value if type(s) is st.Assign and sets(s) else s) & found.keys():
                if ENTRY in state.get(("own", name), {ENTRY}):
                    del found[name]
    return found


def _variables_in(it: object) -> set[str]:
    names: set[str] = set()
    note_names(it, names)
    return names


# --- Point table ---
# Tables of points for the languages that number them.

Place = tuple[int, int | None]  # tool, user frame (None: base)


def table(rows: list[tuple[bool, int, ex.PositionLiteral, Place]], untaught: bool) -> PointTable:
    """A point table of (taught, number, value, place); `untaught`: a point may be without values."""
    states: list[PointState] = []
    blocks: dict[tuple[ex.Store, bool], PointBlock] = {}
    configured = any(literal.configuration for _, _, literal, _ in rows)
    for taught in (True, False):
        own = [row for row in rows if row[0] is taught]
        if not own:
            continue
        width = max(6, *{len(literal.values) for _, _, literal, _ in own})
        whole = all(len(literal.values) == width for _, _, literal, _ in own)
        values = np.full((len(own), width), np.nan)
        if whole:
            values[:] = [literal.values for _, _, literal, _ in own]
        kinds = []
        known: dict[tuple[str, tuple[int, ...], Place], int] = {}
        for at, (_, _, literal, place) in enumerate(own):
            if not whole:
                values[at, : len(literal.values)] = literal.values
            key = (literal.kind, literal.configuration, place)
            kind = known.get(key)
            if kind is None:
                state = _state(literal, place, configured)
                if state not in states:
                    states.append(state)
                kind = known[key] = states.index(state)
            kinds.append(kind)
        for at in np.nonzero(np.isnan(values).any(axis=1))[0].tolist():
            # What is not written is nothing; behind a row's end the table stays empty, as does a point without values.
            literal = own[at][2]
            if not (untaught and is_untaught(literal)):
                values[at, : len(literal.values)] = _values(literal)
        found = np.array([number for _, number, _, _ in own], dtype=np.int64)
        blocks[(ex.Store.ROBOT, taught)] = PointBlock(
            ex.Store.ROBOT,
            taught,
            found,
            values,
            np.array(kinds, dtype=np.int32),
            np.zeros(len(own), dtype=np.int32),
            {n: at for at, n in enumerate(found.tolist())},
        )
    return PointTable(tuple(states), blocks)


def _as_row(literal: ex.PositionLiteral, units: Iterable[tuple[str, str]]) -> ex.PositionLiteral:
    """A position with its external axes among its values."""
    if not literal.external:
        return literal
    scales = [mm if unit == "mm" else deg for _, unit in units]
    further = [v * scale for v, scale in zip(literal.external, scales, strict=False)]
    if not further:
        return literal
    return replace(literal, values=(*literal.values, *further), external=())


def _values(literal: ex.PositionLiteral) -> list[float]:
    return [0.0 if v != v else v for v in literal.values]


def _state(literal: ex.PositionLiteral, place: Place, configured: bool) -> PointState:
    tool, user = place
    if literal.kind == "joint":
        return PointState(PointKind.JOINT, "joint", None, tool)
    # INFORM's arm flags hold until others are written: with one configuration in a job all have one.
    flags = literal.configuration or ((0,) * 6 if configured else ())
    return PointState(PointKind.POSE, "base" if user is None else "user", user, tool, flags)


def place_of(s: st.Move) -> Place:
    """The tool and the frame of a move by their numbers, -1 for one that is computed."""
    tool, frame = s.tool, s.frame
    number = _number_of(tool) if type(tool) is ex.FrameRef else 0
    if type(frame) is ex.FrameRef and frame.kind == "user" and frame.number is not None:
        return number, _number_of(frame)
    return number, None


def _number_of(system: ex.FrameRef) -> int:
    if system.number is None:
        return 0
    return int(system.number.value) if type(system.number) is ex.Number else -1
