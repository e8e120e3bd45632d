"""Which modal statements reach which statement: reaching definitions over jumps, blocks and calls.

A value is a set of definitions: their numbers, UNSET where none came before, ENTRY for what held when the routine
began.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass, field
from typing import Final

from olp.ir import program as st
from olp.ir.block_structure import ControlFlow, pair
from olp.ir.expressions import CallValue, Number
from olp.ir.transformer import calls_nothing, expressions_of, sets_numbers

UNSET: Final = -1
ENTRY: Final = -2
Key = tuple[object, ...]
Values = frozenset[int]
State = Mapping[Key, Values]
Definitions = Callable[[st.Statement], Mapping[Key, int]]

_FROM_OUTSIDE: Final[Values] = frozenset({ENTRY})
_NOTHING: Final[Values] = frozenset({UNSET})
_MARKERS: Final = (st.ElseIf, st.Else, st.Case, st.Default)
_MARKER_KINDS: Final = frozenset(_MARKERS)
# Statements behind which the next one comes; the commonest ones, all others are looked at more closely.
# None of them calls anything.
_ONWARD: Final = frozenset(
    {st.Move, st.SetSpeed, st.SetBlend, st.SetAcceleration, st.SetTool, st.SetFrame, st.Comment, st.Declare}
)
_ROUNDS: Final = 50


@dataclass(slots=True)
class Reaching:
    """`before[routine][i]`: what holds before statement i, by key; a key that is missing holds ENTRY."""

    before: dict[str, list[State | None]] = field(default_factory=dict)
    entry: dict[str, dict[Key, Values]] = field(default_factory=dict)

    def at(self, routine: str, index: int, key: Key) -> Values:
        """The definitions that reach statement `index` of a routine; UNSET among them where none may have come."""
        return self.held(routine, self.before[routine][index], key)

    def held(self, routine: str, state: State | None, key: Key) -> Values:
        """As `at`, for what holds before a statement."""
        if state is None:
            return _NOTHING  # nothing ever gets there
        found = state.get(key, _FROM_OUTSIDE)
        return self._resolved(routine, key, found)

    def _resolved(self, routine: str, key: Key, found: Values) -> Values:
        if ENTRY not in found:
            return found
        return (found - _FROM_OUTSIDE) | self.entry.get(routine, {}).get(key, _NOTHING)


def is_straight(program: st.Program) -> bool:
    """Whether all statements run in order and call none of its routines: what holds is what was set last."""
    own = {routine.name.casefold() for routine in program.routines}
    others = [s for routine in program.routines for s in routine.body if type(s) not in _ONWARD]
    return all(
        type(s) is st.Call
        and not (s.jump or s.condition is not None or s.routine.casefold() in own)
        and not any(type(e) is CallValue for e in expressions_of(s))
        for s in others
    )


def reaching(program: st.Program, definitions: Definitions, kinds: Set[type]) -> Reaching:
    """`definitions(statement)`: the keys that a statement sets, each with the number of the definition.

    `kinds`: the classes of statements that set any.
    """
    result = Reaching()
    graphs = {routine.name: _Graph(routine, pair(routine.body)) for routine in program.routines}
    names = {routine.name.casefold(): routine.name for routine in program.routines}
    summaries: dict[str, State] = {name: {} for name in graphs}
    callers: dict[str, set[str]] = defaultdict(set)
    for name, graph in graphs.items():
        for called in graph.calls(names).values():
            for one in called:
                callers[one].add(name)
    due = set(graphs)
    for _ in range(_ROUNDS):
        for name, graph in graphs.items():
            if name not in due:
                continue  # what it calls leaves the same as when it was looked at last
            due.discard(name)
            result.before[name], leaving = graph.run(definitions, kinds, summaries, names)
            if leaving != summaries[name]:
                summaries[name] = leaving
                due |= callers[name]
        if not due:
            break
    _enter(program, graphs, names, result)
    return result


def _enter(program: st.Program, graphs: dict[str, _Graph], names: dict[str, str], result: Reaching) -> None:
    """What holds when each routine begins: what held where it is called."""
    sites = [
        (name, index, called)
        for name, graph in graphs.items()
        for index, found in graph.calls(names).items()
        for called in found
    ]
    if not sites:
        result.entry |= {name: {} for name in graphs}
        return
    keys = {key for states in result.before.values() for state in states if state for key in state}
    main = program.main or (program.routines[0].name if program.routines else "")
    called_at_all = {called for _, _, called in sites}
    for name in graphs:
        begins = name == main or name not in called_at_all
        result.entry[name] = dict.fromkeys(keys, _NOTHING) if begins else {}
    for _ in range(_ROUNDS):
        changed = False
        for caller, index, called in sites:
            state = result.before[caller][index]
            if state is None:
                continue
            for key in keys:
                found = state.get(key, _FROM_OUTSIDE)
                if ENTRY in found:
                    found = (found - _FROM_OUTSIDE) | result.entry[caller].get(key, frozenset())
                old = result.entry[called].get(key, frozenset())
                if not found <= old:
                    result.entry[called][key], changed = old | found, True
        if not changed:
            return


@dataclass(slots=True)
class _Graph:
    routine: st.Routine
    flow: ControlFlow
    _calls: dict[int, list[str]] | None = None

    def calls(self, names: dict[str, str]) -> dict[int, list[str]]:
        """The program's own routines that each statement calls."""
        if self._calls is None:
            self._calls = {}
            functions = any(e is not None for e in names)
            for index, s in enumerate(self.routine.body):
                found: list[str] = []
                if functions and not (type(s) in _WITHOUT_VALUES or calls_nothing(s) or sets_numbers(s)):
                    found = [e.routine for e in expressions_of(s) if type(e) is CallValue]
                if isinstance(s, st.Call):  # what its arguments call runs before it
                    found.append(s.routine)
                known = [names[name.casefold()] for name in found if name.casefold() in names]
                if known:
                    self._calls[index] = known
        return self._calls

    def run(
        self,
        definitions: Definitions,
        kinds: Set[type],
        summaries: Mapping[str, Mapping[Key, Values]],
        names: dict[str, str],
    ) -> tuple[list[State | None], State]:
        """What holds before each statement, and what the routine has set when it ends."""
        body, calls = self.routine.body, self.calls(names)
        before: list[State | None] = [None] * len(body)
        last = len(body) - 1
        leaving: State | None = None
        work: list[tuple[int, State]] = [(0, {})]
        while work:
            index, state = work.pop()
            while True:
                if index >= len(body):
                    leaving = state if leaving is None else _joined(leaving, state)
                    break
                known = before[index]
                if known is not None:
                    joined = known if known is state else _joined(known, state)
                    if joined is known:
                        break
                    state = joined
                before[index] = state
                after = state
                if type(body[index]) in kinds or index in calls:
                    after = self._after(index, state, definitions, calls, summaries)
                if (
                    index < last
                    and type(body[index]) in _ONWARD
                    and type(body[index + 1]) not in _MARKER_KINDS
                ):
                    index, state = index + 1, after
                    continue
                following = self._following(index)
                if not following:
                    leaving = after if leaving is None else _joined(leaving, after)
                    break
                work += [(other, after) for other in following[1:]]
                index, state = following[0], after
        return before, leaving or {}

    def _after(
        self,
        index: int,
        state: State,
        definitions: Definitions,
        calls: dict[int, list[str]],
        summaries: Mapping[str, Mapping[Key, Values]],
    ) -> State:
        for called in calls.get(index, ()) if calls else ():
            changes = summaries[called]
            if changes:
                new = dict(state)
                for key, values in changes.items():
                    own = state.get(key, _FROM_OUTSIDE)
                    new[key] = (values - _FROM_OUTSIDE) | own if ENTRY in values else values
                state = new
        made = definitions(self.routine.body[index])
        if made:
            new = dict(state)
            for key, number in made.items():
                new[key] = frozenset((number,))
            return new
        return state

    def _following(self, index: int) -> list[int]:
        """The statements that may come next; none where the routine ends."""
        body, flow = self.routine.body, self.flow
        s = body[index]
        onward = index + 1
        if type(s) in _ONWARD and (onward >= len(body) or type(body[onward]) not in _MARKER_KINDS):
            return [onward]
        if onward < len(body) and isinstance(body[onward], _MARKERS) and not isinstance(s, st.Switch):
            onward = flow.end.get(onward, onward)  # the branch is done, and so is the whole block
        match s:
            case st.End():
                return []
            case st.Return(condition=condition):
                return [] if condition is None else [onward]
            case st.Call(jump=True, condition=condition):
                return [] if condition is None else [onward]
            case st.Jump(target=target, condition=condition):
                places = [flow.labels[target]] if target in flow.labels else []
                if not isinstance(target, str):
                    places = list(flow.labels.values())
                return [*places, onward] if condition is not None or not places else places
            case st.If() | st.ElseIf():
                return [onward, flow.after.get(index, onward)]
            case st.Switch():
                markers, marker = [], flow.after.get(index)
                while (
                    marker is not None
                    and marker < len(body)
                    and isinstance(body[marker], (st.Case, st.Default))
                ):
                    markers.append(marker)
                    marker = flow.after.get(marker)
                return [*markers, flow.end.get(index, onward)]
            case st.For() if _runs_at_all(s):
                return [onward]
            case st.While() | st.For():
                return [onward, min(flow.end.get(index, index) + 1, len(body))]
            case st.EndWhile():
                return [flow.opener.get(index, onward)]
            case st.Next() | st.Until():
                return [flow.opener.get(index, index) + 1, onward]
            case st.Break():
                return [flow.end.get(flow.loop.get(index, index), index) + 1]
            case st.Continue():
                return [flow.end.get(flow.loop.get(index, index), index)]
            case _:
                return [onward]


_WITHOUT_VALUES: Final = frozenset(
    {st.Comment, st.Label, st.Else, st.EndIf, st.EndWhile, st.Next, st.Begin, st.End}
)


def _runs_at_all(s: st.For) -> bool:
    """Whether the text says that a loop runs at least once."""
    numbers = [e.value for e in (s.start, s.stop, s.step or Number(1)) if type(e) is Number]
    if len(numbers) < 3:
        return False
    start, stop, step = numbers
    return start <= stop if step > 0 else start >= stop


def _joined(one: State, other: State) -> State:
    """What holds where two ways meet; `one` itself where the other adds nothing, as it nearly always does."""
    result: dict[Key, Values] | None = None
    for key, values in other.items():
        own = one.get(key, _FROM_OUTSIDE)
        if own is not values and not values <= own:
            result = dict(one) if result is None else result
            result[key] = own | values
    for key, own in one.items():
        if key not in other and ENTRY not in own:
            result = dict(one) if result is None else result
            result[key] = own | _FROM_OUTSIDE
    return one if result is None else result
