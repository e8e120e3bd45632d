"""Modal settings (speed, blend, acceleration, tool, frame) are written into each move that they hold for.

Where a setting depends on the path through the program, a variable holds it, set where the modal statement was.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Set
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import inf
from typing import Any, Final

from olp.core.diagnostic import OlpError
from olp.core.units import deg, mm, percent
from olp.ir import program as st
from olp.ir.expressions import (
    Binary,
    Expression,
    FrameRef,
    Item,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    SystemValue,
)
from olp.ir.transformer import calls_nothing, edited, expressions_of
from olp.languages.limits import limits_of
from olp.runtime.poses import FRACTION, SHOWN_UNTOLD, TRAVEL, UNTOLD_SPEED
from olp.transpile.context import LOST, SET_BACK, Fate, TranslationContext
from olp.transpile.current_position import HERE, UNSEEN, System, read_here, solves
from olp.transpile.first_values import behind_declarations
from olp.transpile.reaching_definitions import UNSET, Key, Reaching, State, Values, is_straight, reaching
from olp.transpile.symbols import LITERALS, Symbols, kind_of_value

_MODAL: Final = (st.SetSpeed, st.SetAcceleration, st.SetBlend, st.SetTool, st.SetFrame, st.SetOverride)
# What a variable that holds a modal value counts in, SI per unit.
_SCALES: Final[Mapping[object, float]] = {
    st.SpeedUnit.FRACTION: percent,
    st.SpeedUnit.TRAVEL: mm,
    st.SpeedUnit.TURN: deg,
    st.SpeedUnit.AXIS: deg,
    st.SpeedUnit.TIME: 1.0,
    st.BlendKind.RADIUS: mm,
    st.BlendKind.SHARE: percent,
    st.BlendKind.SPEED: percent,
    st.BlendKind.TURN: deg,
}
# What holds where a program sets nothing, as the interpreter takes it.
_BLENDS: Final[Mapping[object, Quantity]] = {
    st.BlendKind.SHARE: Quantity(Number(50.0), percent),
    st.BlendKind.RADIUS: Quantity(Number(3.0), mm),
    st.BlendKind.SPEED: Quantity(Number(100.0), percent),
    st.BlendKind.TURN: Quantity(Number(5.0), deg),
}
# A speed for moves that nobody gave one, where the target needs it: that of the source's run.
_SLOW: Final[Mapping[bool, st.Speed]] = {
    True: st.Speed(st.SpeedUnit.FRACTION, Quantity(Number(UNTOLD_SPEED[FRACTION] / percent), percent)),
    False: st.Speed(st.SpeedUnit.TRAVEL, Quantity(Number(UNTOLD_SPEED[TRAVEL] / mm), mm)),
}
_NO_BLEND: Final = Quantity(Number(0.0), 1.0)
_FLANGE: Final = FrameRef("tool", Number(0))
_BASE: Final = FrameRef("base")
_NOTHING: Final = PositionLiteral(
    "pose", (0.0,) * 6
)  # the flange, or the base, as a value that is written out
_CHANGING: Final = frozenset(
    {"Named", "Item", "Member", "Signal", "Function", "CallValue", "SystemValue", "Variable"}
)
_MODAL_KINDS: Final = frozenset(_MODAL)
_NEVER: Final[Values] = frozenset({UNSET})
_NO_KEYS: Final[Mapping[Key, object]] = {}
_SPEED, _LAST, _TURN, _RATE, _BLEND = "speed", "last", "turn", "rate", "blend"
_UNSET_TOOL: Final = "see which tool was active where the program chooses none (the flange is written)"
_UNSET_FRAME: Final = "see which frame was active where the program chooses none (the base is written)"
_CALLED = {_LAST: "speed", _TURN: "turning speed", _RATE: "acceleration"}
_TOOL: Final[Key] = ("tool",)
_FRAME: Final[Key] = ("frame",)
_DEEP: Final = 4  # calls and assignments through which a tool's number is followed
_KINDS: Final[Mapping[Key, str]] = {_TOOL: "tool", _FRAME: "user"}
_SYSTEMS: Final = frozenset(_KINDS)
_OVERRIDE: Final[Key] = ("override",)
_FASTEST: Final[Key] = ("fastest",)
_UNBOUNDED: Final = Quantity(Number(inf), 1.0)
_WHOLE: Final = Quantity(Number(1), 1.0)  # no override
_TURNING: Final[Key] = (_TURN,)
_RATES: Final[Mapping[bool, tuple[Key, Key]]] = {
    joint: ((_RATE, joint, True), (_RATE, joint, False)) for joint in (True, False)
}


def _name_of(key: Key) -> str:
    """What a variable for a setting is called."""
    words = [part for part in key if isinstance(part, str)]
    if key[0] == _RATE:
        words = ["joint" if key[1] else "path", "acceleration"]
    return "_".join(words)


@dataclass(slots=True)
class _Modal:
    """`definitions`: what each definition sets its key to, in order of finding."""

    program: st.Program
    work: TranslationContext
    symbols: Symbols
    definitions: list[object] = field(default_factory=list)
    numbers: dict[tuple[int, Key], int] = field(default_factory=dict)
    variables: dict[Key, Named] = field(default_factory=dict)
    declared: list[st.Declare] = field(default_factory=list)
    assigned: dict[int, tuple[Key, Named]] = field(default_factory=dict)  # definition -> its variable
    begins: dict[str, list[st.Assign]] = field(
        default_factory=dict
    )  # what each run sets a variable to, by its name
    routine: str = ""
    flow: Reaching = field(default_factory=Reaching)
    made: dict[tuple[st.SpeedUnit, int], st.Speed] = field(default_factory=dict)  # moves share their speeds
    sized: dict[tuple[st.Blend, int], st.Blend] = field(default_factory=dict)  # and their blends
    rates: dict[tuple[bool, int], st.Acceleration] = field(default_factory=dict)  # and their accelerations
    keys: set[Key] = field(default_factory=set)  # that any statement sets
    state: State | None = None  # before the statement that is looked at
    current: dict[Key, object] = field(default_factory=dict)  # what was asked for in this state
    by_number: frozenset[Key] = frozenset()  # whose variable holds the number of a tool or frame
    set_to: dict[str, list[tuple[Expression, st.Routine]]] = field(
        default_factory=dict
    )  # by its name: what a variable is set to, and in which routine
    called: dict[str, list[tuple[st.Call, st.Routine]]] = field(
        default_factory=dict
    )  # and where a routine is called
    last: System = UNSEEN  # of the move before, in the order of writing
    bounded: bool = False  # whether any override says how fast the tool is at most
    unset_tool: str | None = None  # what is asked of moves that take the tool which the controller has active
    unset_frame: str | None = None  # and the frame
    used: set[int] = field(default_factory=set)  # definitions that a statement takes its value from

    # --- definitions ------------------------------------------------------------------------------------

    def of(self, s: st.Statement) -> Mapping[Key, int]:
        """The keys that a statement sets."""
        return {key: self._number(s, key, value) for key, value in self._given(s).items()}

    def _given(self, s: st.Statement) -> Mapping[Key, object]:
        """The keys that a statement sets, and to what."""
        if type(s) is not st.Move:
            return _settings(s)
        if not self.work.conventions.speed_persists or s.speed is None:
            return _NO_KEYS
        return {(_LAST, s.speed.unit): s.speed.value}

    def _number(self, s: st.Statement, key: Key, value: object) -> int:
        number = self.numbers.get((id(s), key))
        if number is None:
            self.keys.add(key)
            number = self.numbers[(id(s), key)] = len(self.definitions)
            self.definitions.append(value)
        return number

    # --- values -----------------------------------------------------------------------------------------

    def value(self, key: Key, unset: object = None) -> object:
        """What holds at a statement: a value, a variable where it depends on the way there, or `unset`.

        A key is always asked for with the same `unset`.
        """
        if key not in self.keys:
            return unset
        found = self.current.get(key, self)
        if found is self:
            found = self.current[key] = self._value(key, unset)
        return found

    def _value(self, key: Key, unset: object) -> object:
        state = self.state
        if (
            state is not None
            and len(reached := state.get(key, _NEVER)) == 1
            and (number := next(iter(reached))) >= 0
        ):
            self.used.add(number)
            only = self.definitions[number]
            if type(only) is Quantity and type(only.written) is Number:
                return only
            if type(only) is FrameRef and type(only.number) is Number:
                return only
        found = self.flow.held(self.routine, state, key)
        if found == _NEVER:
            return unset
        self.used |= found
        values = [unset if number == UNSET else self.definitions[number] for number in found]
        first = next((value for value in values if _lost(value)), values[0])
        if _lost(first):
            return first
        if all(value == first for value in values) and self._is_fixed(first):
            return first
        if unset is None and UNSET in found and len(found) == 2:
            known = next(value for value in values if value is not None)
            if self._is_fixed(known):
                self._tell_assumed(key)
                return known
        return self._variable(key, found, unset)

    def _is_fixed(self, value: object) -> bool:
        """Whether a value is the same whenever it is looked at."""
        if isinstance(value, Named):
            return self._never_changes(value)
        if isinstance(value, Item):
            written = all(type(index) is Number for index in value.indices)
            return written and isinstance(value.base, Named) and self._never_changes(value.base)
        if type(value) is FrameRef and type(value.number) is Number:
            return True
        return not any(
            type(e).__name__ in _CHANGING and self.symbols.fixed_value(self.routine, e) is None
            for e in expressions_of(value)
        )

    def _never_changes(self, e: Named) -> bool:
        """Whether a name holds what it begins with; what that is need not be known here."""
        symbol = self.symbols.find(self.routine, e.name)
        return symbol is not None and not symbol.assigned and symbol.parameter is None

    def _variable(self, key: Key, found: Values, unset: object) -> object:
        name = self.variables.get(key)
        if name is None:
            name = self.variables[key] = Named(self.work.helper(_name_of(key)))
            frame = key in (_TOOL, _FRAME)
            value: Any = _NOTHING if frame else self._begin(key, found, unset)
            kind = str(key[0]) if frame else "real"
            if key in self.by_number:
                kind, value = "integer", Number(0)
            self.declared.append(st.Declare(0, name.name, kind, value, shared=True))
            if UNSET in found and self._lives_on(key):
                self.begins[name.name] = [st.Assign(0, name, unset if frame else value)]  # type: ignore[arg-type]
        for number in found:
            if number != UNSET:
                self.assigned[number] = (key, name)
        if key in (_TOOL, _FRAME):
            return name
        return Quantity(name, _scale(key))

    def _begin(self, key: Key, found: Values, unset: object) -> Expression:
        """What a variable holds before any statement sets it."""
        if UNSET not in found:
            return Number(0.0)
        if unset is None:
            known = (self.definitions[number] for number in sorted(found) if number != UNSET)
            unset = next(
                (value for value in known if type(value) is Quantity and value.literal is not None), None
            )
            self._tell_assumed(key)
        return Number(0.0) if unset is None else _counted(unset, key)

    def _tell_assumed(self, key: Key) -> None:
        part = _CALLED.get(str(key[0]), key[0])
        self.work.note_once(
            f"{part}: assumed to be set, although one path avoids every statement that sets it"
        )

    def _lives_on(self, key: Key) -> bool:
        """Whether a variable for a setting holds in the next run what this one has left in it."""
        numbered = bool(
            self.work.limits.numbered
        )  # whose variables each run sets first, but tools and frames
        return (
            key in (_TOOL, _FRAME) and key not in self.by_number if numbered else self.work.limits.keeps_data
        )

    # --- statements -------------------------------------------------------------------------------------

    def straight(self, routine: st.Routine, kinds: Set[type]) -> list[st.Statement]:
        """The statements of a routine that is run from its first to its last one."""
        held: dict[Key, Values] = {}
        self.state, self.current = held, {}
        rows: list[st.Statement] = []
        for s in routine.body:
            rows.append(self.move(s) if type(s) is st.Move else s)
            if type(s) in kinds:
                self._hold(s, held)
        return rows

    def _hold(self, s: st.Statement, held: dict[Key, Values]) -> None:
        """Notes what a statement sets for those behind it; numbers that are written out need no definition."""
        for key, value in self._given(s).items():
            if type(value) is Quantity and type(value.written) is Number:
                self.keys.add(key)
                self.current[key] = value
            else:
                self.current.pop(key, None)
                held[key] = frozenset((self._number(s, key, value),))

    def routed(self, routine: st.Routine, states: list[State | None]) -> list[st.Statement]:
        """The statements of a routine; `states`: what holds before each."""
        self.current = {}
        rows: list[st.Statement] = []
        moved: State | None = None
        for s, state in zip(routine.body, states, strict=True):
            if state is not self.state:
                self.state, self.current = state, {}
            if type(s) is st.Move and state is not moved and not (s.tool is None and s.frame is None):
                moved = state  # a position with a tool and a frame of its own is one of those that hold
                for key in self.keys & _SYSTEMS:
                    self.used |= self.flow.held(routine.name, state, key)
            rows.append(self.move(s) if type(s) is st.Move else self.placed(s))
        return rows

    def move(self, s: st.Move) -> st.Move:
        changes: dict[str, Any] = {}
        joint = s.path is st.Path.JOINT
        if s.speed is None:
            changes["speed"] = self._speed(s, joint)
        if s.blend is not None and s.blend.value is None and s.blend.kind is not st.BlendKind.CONTINUOUS:
            changes["blend"] = self._blend(s.blend)
        if s.acceleration is None and s.rate is None and not self.keys.isdisjoint(_RATES[joint]):
            share, rate = (self.value(key) for key in _RATES[joint])
            if share is not None:
                changes["acceleration"] = share
            if rate is not None:
                changes["rate"] = self._rate(rate, joint)
        if s.turn is None and (turn := self.value(_TURNING)) is not None:
            changes["turn"] = turn
        if s.tool is None:
            changes["tool"] = self.value(_TOOL, _FLANGE)
        if s.frame is None:
            changes["frame"] = self.value(_FRAME, _BASE)
        self.last = (changes.get("tool", s.tool), changes.get("frame", s.frame))
        if self.unset_tool is not None and changes.get("tool") is _FLANGE:
            self.work.ask(self.unset_tool, self.routine or "the program")
        if self.unset_frame is not None and changes.get("frame") is _BASE and not self._is_of_axes(s):
            self.work.ask(self.unset_frame, self.routine or "the program")
        for which in ("tool", "frame") if s.tool is None or s.frame is None else ():
            if _lost(changes.get(which)):
                self._lose(s, which, changes[which])
                del changes[which]
        if _OVERRIDE in self.keys:
            if self.bounded:
                self._bound(s, changes)
            if not self.work.limits.has_override:
                self._fold_override(s, changes)
        s = edited(s, changes) if changes else s
        # Where positions keep the base that they were read in, a move to where the arm is needs no frame.
        if self.work.conventions.names_read_frames:
            return s
        plain = type(s.targets[0]) is not SystemValue or self.work.limits.position_read_in == "base"
        if (plain and calls_nothing(s)) or HERE not in expressions_of(s):
            return s
        read = read_here(s, (s.tool, s.frame), (s.tool, s.frame), self.work)
        assert isinstance(read, st.Move)
        return read

    def _speed(self, s: st.Move, joint: bool) -> st.Speed | None:
        units = (st.SpeedUnit.FRACTION, st.SpeedUnit.AXIS) if joint else (st.SpeedUnit.TRAVEL,)
        for kind in (_SPEED, _LAST):
            for unit in units:
                value = self.value((kind, unit))
                if value is not None:
                    found = self.made.get((unit, id(value)))
                    if found is None:
                        found = st.Speed(unit, value)  # type: ignore[arg-type]
                        if type(value) is Quantity and type(value.written) is Number:
                            self.made[(unit, id(value))] = found  # which keeps the value, and so its id
                    return found
        if not self.work.limits.speeds_needed:
            says = "no speed was set before this move: the target's default holds"
            self.work.lose(s, Fate.APPROXIMATED, "speed", says)
            return None
        says = "no speed was set before this move, which takes its caller's: "
        shown = SHOWN_UNTOLD[FRACTION if joint else TRAVEL].partition(" of ")[0]
        self.work.lose(s, Fate.APPROXIMATED, "speed", says + shown)
        return _SLOW[joint]

    def _rate(self, value: object, joint: bool) -> st.Acceleration:
        found = self.rates.get((joint, id(value)))
        if found is None:
            unit = st.AccelerationUnit.AXIS if joint else st.AccelerationUnit.TRAVEL
            found = st.Acceleration(unit, value)  # type: ignore[arg-type]
            self.rates[(joint, id(value))] = found  # which keeps the value, and so its id
        return found

    def _blend(self, blend: st.Blend) -> st.Blend:
        size: Any = self.value((_BLEND, blend.kind), _BLENDS.get(blend.kind, _NO_BLEND))
        known = self.sized.get((blend, id(size)))
        if known is None:
            known = blend._replace(value=size)
            if type(size.written) is Number:
                self.sized[(blend, id(size))] = known  # which keeps the size, and so its id
        return known

    def _is_of_axes(self, s: st.Move) -> bool:
        """Whether a move goes to axis values, to which no frame matters."""
        target = s.targets[0] if s.targets else None
        if isinstance(target, PositionLiteral):
            return target.kind == "joint"
        return target is not None and kind_of_value(self.symbols, self.routine, target) == "joints"

    def _bound(self, s: st.Move, changes: dict[str, Any]) -> None:
        """A speed that is no faster than the largest one, which holds behind the override."""
        speed: st.Speed | None = changes.get("speed", s.speed)
        if speed is None or speed.unit is not st.SpeedUnit.TRAVEL:
            return
        fastest, share, written = self._literal(_FASTEST), self._literal(_OVERRIDE), speed.value.literal
        if fastest == inf:
            return
        if written is None or fastest is None or share is None:
            says = "a largest speed is left out, as it is computed or not set on every way: the move may be faster"
            self.work.lose(s, Fate.APPROXIMATED, "speed", says)
        elif written * share > fastest:
            scale = speed.value.scale
            changes["speed"] = st.Speed(speed.unit, Quantity(Number(fastest / share / scale), scale))

    def _literal(self, key: Key) -> float | None:
        """The number that holds, or that of no override; None where it depends on the way, or is computed."""
        found = self.current.get(key)
        if found is not None:
            return found.literal if type(found) is Quantity else None
        unset = _UNBOUNDED if key == _FASTEST else _WHOLE
        held = self.flow.held(self.routine, self.state, key)
        values = [unset if number == UNSET else self.definitions[number] for number in held] or [unset]
        numbers = {value.literal if type(value) is Quantity else None for value in values}
        return next(iter(numbers)) if len(numbers) == 1 else None

    def _fold_override(self, s: st.Move, changes: dict[str, Any]) -> None:
        share = self.value(_OVERRIDE, _WHOLE)
        speed: st.Speed | None = changes.get("speed", s.speed)
        if share is _WHOLE or speed is None:
            return
        assert isinstance(share, Quantity)
        known, value = share.literal, speed.value
        timed = speed.unit is st.SpeedUnit.TIME  # which is as much longer
        if known is not None and value.literal is not None:
            written = value.literal / known if timed else value.literal * known
            changes["speed"] = st.Speed(speed.unit, Quantity(Number(written / value.scale), value.scale))
            return
        product = Binary("/" if timed else "*", value.written, share.written)
        scale = value.scale / share.scale if timed else value.scale * share.scale
        changes["speed"] = st.Speed(speed.unit, Quantity(product, scale))

    def placed(self, s: st.Statement) -> st.Statement:
        """For languages that read the position in the frame and with the tool that hold."""
        if type(s) in _MODAL_KINDS or not any(e == HERE or solves(e) for e in expressions_of(s)):
            return s
        tool: Any = self.value(_TOOL, _FLANGE)
        frame: Any = self.value(_FRAME, _BASE)
        if (tool, frame) != (_FLANGE, _BASE) and any(map(solves, expressions_of(s))):
            says = (
                "axes and poses computed with another tool than the flange, or in another frame than the base"
            )
            self.work.lose(s, Fate.REFUSED, "position", says)
        if HERE not in expressions_of(s):
            return s
        for which, value in (("tool", tool), ("frame", frame)):
            if _lost(value):
                self._lose(s, which, value)
                return s
        if self.unset_tool is not None and tool is _FLANGE:
            self.work.ask(self.unset_tool, self.routine or "the program")
        if self.unset_frame is not None and frame is _BASE:
            self.work.ask(self.unset_frame, self.routine or "the program")
        return read_here(s, (tool, frame), self.last, self.work)

    def _lose(self, s: st.Statement, which: str, lost: Any) -> None:
        setting = self.program.source.line(int(lost.number.value)).strip()
        says = f"it needs the {which} that '{setting}' sets in a way that the target cannot"
        self.work.lose(s, Fate.REFUSED, "statement", says)

    def noted(self, s: st.Statement) -> list[st.Statement]:
        """Assignments to the variables that hold what a statement sets, where a later one needs them."""
        rows: list[st.Statement] = []
        for key, value in self._given(s).items():
            wanted = self.assigned.get(self.numbers.get((id(s), key), UNSET))
            if wanted is not None:
                if key in self.by_number:
                    value = self._number_of(key, value)
                    self._tell_number(s, key, value)
                rows.append(st.Assign(s.line, wanted[1], _counted(value, key)))
        return rows

    def kept(self, s: st.Statement) -> list[st.Statement]:
        """What a modal statement becomes: assignments to the variables that need it, and its comment."""
        rows = self.noted(s) if self.assigned else []
        comment: str = s.comment  # type: ignore[union-attr]
        if isinstance(s, st.SetOverride) and self.work.limits.has_override:
            if (
                self.work.conventions.override_begins_anew
                and not self.work.target_conventions.override_begins_anew
            ):
                self.work.ask(SET_BACK, "the override, to 100 %")
            return [s]
        if comment:
            rows.insert(0, st.Comment(s.line, comment))
        return rows

    def note_numbers(self) -> None:
        """Tools and frames that are chosen by numbers alone, which the target has, too, and which stay as they are."""
        mapping = self.work.context.mapping
        if self.work.limits.tool_and_frame != "modal" or self.work.limits.named_frames:
            return
        chosen: dict[Key, list[tuple[st.Routine, Expression]]] = {_TOOL: [], _FRAME: []}
        for routine in self.program.routines:
            for s in routine.body:
                for key, field_name in ((_TOOL, "tool"), (_FRAME, "frame")):
                    system = (
                        getattr(s, field_name, None)
                        if isinstance(s, (st.SetTool, st.SetFrame, st.Move))
                        else None
                    )
                    if system is not None:
                        chosen[key].append((routine, system))
                if isinstance(s, st.Assign) and isinstance(s.target, Named):
                    self.set_to.setdefault(s.target.name, []).append((s.value, routine))
                elif isinstance(s, st.Call):
                    self.called.setdefault(s.routine, []).append((s, routine))
        tables = {_TOOL: mapping.tools, _FRAME: mapping.frames}
        self.by_number = frozenset(
            key
            for key, named in chosen.items()
            if not tables[key] and all(self._has_number(key, routine, system) for routine, system in named)
        )

    def _has_number(self, key: Key, routine: st.Routine, system: Expression) -> bool:
        """Whether a tool or frame has a number that is, as far as the text shows, one that the target has."""
        number = self._number_of(key, system)
        most = self.work.limits.frame_numbers[_KINDS[key]]
        return number is not None and self._highest(number, routine, _DEEP) <= most

    def _highest(self, number: Expression, routine: st.Routine, deep: int) -> float:
        """The highest of the numbers that the text shows to be computed, 0 where it shows none."""
        if isinstance(number, Number):
            return number.value
        if isinstance(number, Binary) and number.operator == "+":
            return sum(self._highest(part, routine, deep) for part in (number.left, number.right))
        if not isinstance(number, Named) or not deep:
            return 0
        symbol = self.symbols.find(routine.name, number.name)
        found: list[tuple[Expression, st.Routine]] = (
            [(symbol.value, routine)] if symbol and symbol.value else []
        )
        at = next((n for n, p in enumerate(routine.parameters) if p.name == number.name), -1)
        found += self.set_to.get(number.name, ())
        for call, other in self.called.get(routine.name, ()) if at >= 0 else ():
            if at < len(call.arguments):
                found.append((call.arguments[at], other))
        return max((self._highest(value, where, deep - 1) for value, where in found), default=0)

    def _number_of(self, key: Key, system: object) -> Expression | None:
        """The number by which a tool or frame is chosen, None for any other one."""
        if isinstance(system, Item) and isinstance(system.base, Named) and len(system.indices) == 1:
            spelt = self.work.conventions.frame_spelling.get(_KINDS[key], "")
            return system.indices[0] if spelt.format("n") == f"{system.base.name.upper()}[n]" else None
        if not isinstance(system, FrameRef) or system.kind == LOST:
            return None
        return Number(0) if system.kind in ("base", "robot") else system.number

    def _tell_number(self, s: st.Statement, key: Key, number: object) -> None:
        """What the controller has to hold, of a number that is computed."""
        if isinstance(number, Number):
            return
        kind = _KINDS[key]
        here, there = (
            one.frame_spelling.get(kind, "{}").format("n")
            for one in (self.work.conventions, self.work.target_conventions)
        )
        largest = self.work.limits.frame_numbers[kind]
        says = f"{there} has to hold the values of {here}, and n must be 1 to {largest}"
        self.work.lose(s, Fate.APPROXIMATED, str(key[0]), says)
        self.work.ask(f"set {there} on the controller, for each n that the program computes", here)


def _settings(s: st.Statement) -> dict[Key, object]:
    """The keys that a modal statement sets, and to what."""
    match s:
        case st.SetSpeed(speeds=speeds, turn=turn):
            found: dict[Key, object] = {(_SPEED, speed.unit): speed.value for speed in speeds}
            if turn is not None:
                found[(_TURN,)] = turn
            return found
        case st.SetBlend(blends=blends):
            return {(_BLEND, blend.kind): blend.value for blend in blends if blend.value is not None}
        case st.SetAcceleration(rates=rates, path=path):
            found = {}
            for rate in rates:
                if rate.unit is st.AccelerationUnit.FRACTION:
                    paths = (True, False) if path is None else (path is st.Path.JOINT,)
                    found |= {(_RATE, joint, True): rate.value for joint in paths}
                else:
                    found[(_RATE, rate.unit is st.AccelerationUnit.AXIS, False)] = rate.value
            return found
        case st.SetTool(tool=tool):
            return {_TOOL: tool}
        case st.SetFrame(frame=frame):
            return {_FRAME: frame}
        case st.SetOverride(share=share, fastest=fastest):
            return {_OVERRIDE: share, _FASTEST: _UNBOUNDED if fastest is None else fastest}
        case _:
            return {}


class _Outlasting:
    """What still holds where a program ends, or calls one that no file has: the translation writes it into moves alone.

    Told are statements that no move here takes a value of, and asked for is what such a call hands on.
    """

    def __init__(self, own: _Modal) -> None:
        self.own = own
        self.unused: dict[int, st.Statement] = {}
        self.handed: list[
            tuple[str, st.Statement]
        ] = []  # to a routine that no file has: a statement that holds
        self._number_of: dict[int, st.Statement] | None = None

    def straight(self, routine: st.Routine) -> None:
        """Of a routine that is run from its first to its last statement, looked at from its end."""
        wanted: set[Key] = set()  # by moves behind, before which no other statement sets it
        kept: set[Key] = set()  # that a statement behind sets
        calls: dict[str, set[Key]] = {}  # behind: what is set between here and there
        used: set[int] = set()
        met: set[_Asks] = set()
        for s in reversed(routine.body):
            kind = type(s)
            if kind is st.Move:
                if (asks := _asks(s)) not in met:  # type: ignore[arg-type]
                    met.add(asks)
                    wanted |= _wanted(asks)
            elif kind in _MODAL_KINDS:
                keys = set(_settings(s))
                if not wanted.isdisjoint(keys):
                    used.add(id(s))
                    wanted -= keys
                    met.clear()
                if not keys <= kept:
                    kept |= keys
                    self.unused[id(s)] = s
                for name, between in calls.items():
                    if not keys <= between:
                        between |= keys
                        self.handed.append((name, s))
            elif kind is st.Call and s.routine in self.own.work.missing:  # type: ignore[union-attr]
                kept, calls[s.routine] = set(), set()  # type: ignore[union-attr]
        for one in used:
            self.unused.pop(one, None)

    def routed(self, routine: st.Routine, states: list[State | None], starts: bool) -> None:
        """`states`: what holds before each statement. `starts`: whether another program comes behind it."""
        last = len(routine.body) - 1
        for n, (s, state) in enumerate(zip(routine.body, states, strict=True)):
            name = s.routine if type(s) is st.Call and s.routine in self.own.work.missing else ""
            ends = starts and (n == last or type(s) in (st.End, st.Return))
            if state is None or not (name or ends):
                continue
            found = {d for key in self.own.keys for d in self.own.flow.held(routine.name, state, key)}
            held = [one for d in found if (one := self.numbered.get(d)) is not None]
            self.unused |= {id(one): one for one in held if ends or name}
            self.handed += [(name, one) for one in held if name]
            if n == last and type(s) in _MODAL_KINDS:
                self.unused[id(s)] = s

    @property
    def numbered(self) -> dict[int, st.Statement]:
        """The modal statement of each definition."""
        if self._number_of is None:
            ids = {one for one, _ in self.own.numbers}
            found = (s for s in self.own.program.statements() if ids and id(s) in ids)
            modal = {id(s): s for s in found if type(s) in _MODAL_KINDS}
            self._number_of = {n: modal[one] for (one, _), n in self.own.numbers.items() if one in modal}
        return self._number_of

    def tell(self) -> None:
        work = self.own.work
        for number in self.own.used if self.unused else ():
            if number in self.numbered:
                self.unused.pop(id(self.numbered[number]), None)
        if not (self.unused or self.handed):
            return
        # What a language sets by itself: as a routine begins, and again behind a move that a setting held for alone.
        lines = Counter({routine.line: _INITIAL for routine in self.own.program.routines})
        asked = {s.line for s in (*self.unused.values(), *(s for _, s in self.handed))}
        for s in self.own.program.statements():
            if s.line in asked and ((kind := type(s)) is st.Move or kind in _MODAL_KINDS):
                lines[s.line] += _INITIAL if kind is st.Move else 1
        for s in sorted(self.unused.values(), key=lambda s: s.line):
            if lines[s.line] < _INITIAL and self._is_lost(s):
                work.lose(s, Fate.APPROXIMATED, "scope", _NOT_SET)
        by_name: dict[str, set[str]] = {}
        for name, s in self.handed:
            if lines[s.line] < _INITIAL and self._is_lost(s):
                by_name.setdefault(name, set()).add(_HANDED[type(s)])
        for name, words in by_name.items():
            work.ask(_MOVES_WITH, f"{name} ({', '.join(sorted(words))})")

    def _is_lost(self, s: st.Statement) -> bool:
        """Whether a statement sets something else than what holds where nothing is set, and is written nowhere."""
        match s:
            case st.SetOverride(share=share, fastest=fastest):
                return not self.own.work.limits.has_override and (share.literal != 1.0 or fastest is not None)
            case st.SetAcceleration(rates=rates):
                share = st.AccelerationUnit.FRACTION
                return any(rate.unit is not share or rate.value.literal != 1.0 for rate in rates)
        return True


_Asks = tuple[bool, bool, object, bool, bool]
_INITIAL: Final = 5  # settings of one line that sets all to how a program begins
_NOT_SET: Final = (
    "no move here takes it: what runs behind this program, or is called by it, has to set it there"
)
_MOVES_WITH: Final = (
    "see that these set themselves what holds for them here in the source, and change none of it"
)
_HANDED: Final[Mapping[type, str]] = {
    st.SetSpeed: "speed",
    st.SetAcceleration: "acceleration",
    st.SetBlend: "blend",
    st.SetTool: "tool",
    st.SetFrame: "frame",
    st.SetOverride: "override",
}


def _ending(program: st.Program, work: TranslationContext) -> set[str]:
    """The routines, case folded, behind which another program comes: that start, and what they call last of all."""
    called = {s.routine.casefold() for s in work.rare(program) if type(s) is st.Call}
    main = (program.main or program.routines[0].name).casefold()
    due = [
        r for r in program.routines if r.starts or (name := r.name.casefold()) == main or name not in called
    ]
    found: set[str] = set()
    by_name = {r.name.casefold(): r for r in program.routines}
    while due:
        routine = due.pop()
        found.add(routine.name.casefold())
        last = routine.body[-1] if routine.body else None
        one = by_name.get(last.routine.casefold()) if type(last) is st.Call else None
        if one is not None and one.name.casefold() not in found:
            due.append(one)
    return found


def _asks(s: st.Move) -> _Asks:
    """What a move takes from statements before it."""
    sized = s.blend is None or s.blend.value is not None
    return (
        s.path is st.Path.JOINT,
        s.speed is None,
        None if sized else s.blend.kind,  # type: ignore[union-attr]
        s.acceleration is None and s.rate is None,
        s.turn is None,
    )


@lru_cache(maxsize=256)
def _wanted(asks: _Asks) -> frozenset[Key]:
    joint, speed, blend, rate, turn = asks
    found: set[Key] = {_OVERRIDE, _FASTEST, *_SYSTEMS}
    if speed:
        units = (st.SpeedUnit.FRACTION, st.SpeedUnit.AXIS) if joint else (st.SpeedUnit.TRAVEL,)
        found |= {(_SPEED, unit) for unit in units}
    if blend is not None:
        found.add((_BLEND, blend))
    if rate:
        found |= set(_RATES[joint])
    if turn:
        found.add(_TURNING)
    return frozenset(found)


def _scale(key: Key) -> float:
    if key[0] == _RATE:
        return percent if key[2] else deg if key[1] else 1.0
    if key[0] == _TURN:
        return deg
    return percent if key == _OVERRIDE else _SCALES[key[1]]


def _counted(value: object, key: Key) -> Expression:
    """A value in the unit that its variable counts in."""
    if not isinstance(value, Quantity):
        assert isinstance(value, (*LITERALS, Named, FrameRef)) or value is not None
        return value  # type: ignore[return-value]
    scale = _scale(key)
    if isinstance(value.written, Number):
        return Number(float(f"{value.written.value * value.scale / scale:.12g}"))
    factor = value.scale / scale
    return value.written if abs(factor - 1.0) < 1e-12 else Binary("*", value.written, Number(factor))


def _chooses_by_statement(vendor: str) -> bool:
    """Whether a language chooses tools by statements that hold from there on; nothing is asked of those only read."""
    try:
        return limits_of(vendor).tool_and_frame == "modal"
    except OlpError:
        return False


def _lost(value: object) -> bool:
    return type(value) is FrameRef and value.kind == LOST


def modal_settings(program: st.Program, work: TranslationContext) -> st.Program:
    """Every move with its speed, blend, accelerations, tool and frame; no modal statement is left."""
    if not _needs(program):
        return program
    own = _Modal(program, work, work.symbols(program))
    own.note_numbers()
    own.bounded = any(type(s) is st.SetOverride and s.fastest is not None for s in work.rare(program))
    own.unset_tool = _UNSET_TOOL if _chooses_by_statement(program.vendor) else None
    chooses = own.unset_tool is not None and not limits_of(program.vendor).pose_functions
    own.unset_frame = _UNSET_FRAME if chooses else None
    kinds = _MODAL_KINDS | {st.Move} if work.conventions.speed_persists else _MODAL_KINDS
    if not is_straight(program):
        own.flow = reaching(program, own.of, kinds)
    bodies, outlasting = [], _Outlasting(own)
    ending = _ending(program, work)
    for routine in program.routines:
        own.routine, own.last = routine.name, UNSEEN
        states = own.flow.before.get(routine.name)
        if states is None:
            bodies.append(own.straight(routine, kinds))
            outlasting.straight(routine)
        else:
            bodies.append(own.routed(routine, states))
            outlasting.routed(routine, states, routine.name.casefold() in ending)
    outlasting.tell()
    routines = []
    for routine, body in zip(program.routines, bodies, strict=True):
        own.routine = routine.name
        rows: list[st.Statement] = []
        for original, s in zip(routine.body, body, strict=True):
            if type(original) in _MODAL_KINDS:
                rows += own.kept(original)
                continue
            if own.assigned and type(original) is st.Move:
                rows += own.noted(original)
            rows.append(s)
        if own.begins and (routine.starts or routine.name == (program.main or program.routines[0].name)):
            rows = behind_declarations(tuple(rows), own.begins)
        routines.append(replace(routine, body=tuple(rows)))
    return replace(program, routines=tuple(routines), data=(*program.data, *own.declared))


def _needs(program: st.Program) -> bool:
    for s in program.statements():
        if isinstance(s, _MODAL):
            return True
        if isinstance(s, st.Move) and (
            s.speed is None
            or s.tool is None
            or s.frame is None
            or (s.blend is not None and s.blend.value is None and s.blend.kind is not st.BlendKind.CONTINUOUS)
        ):
            return True
    return False
