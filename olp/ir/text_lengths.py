"""How many characters texts may get that a program joins: from what is written out, along its branches and loops.

What no statement here writes out (an argument from elsewhere, an answer of a socket) counts as empty, so that a length
is the least that the program makes by itself. A number takes `NUMBER` characters.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.block_structure import LOOPS, Block, Node, parse
from olp.ir.transformer import calls_nothing

NUMBER: Final = 12  # as -1.23457e+06
_JOINED: Final = "joined-text"
Lengths = dict[str, float]  # by the name of the variable


def text_lengths(program: st.Program) -> list[tuple[st.Statement, float]]:
    """Each assignment of a text with the characters that it may have; inf: more with each pass of a loop."""
    joins = any(
        type(s) is st.Assign and type(s.value) is ex.Function and s.value.name == _JOINED
        for s in program.statements()
    )
    if not joins:
        return []
    walks = [_Walk(r.name) for r in program.routines]
    for walk, routine in zip(walks, program.routines, strict=True):
        walk.nodes([*program.data, *routine.data])
    begun = [dict(walk.held) for walk in walks]
    trees = [parse(r.body) or list(r.body) for r in program.routines]
    for walk, tree in zip(walks, trees, strict=True):
        walk.nodes(tree)
    given = _given(program, walks)
    for walk, tree, held in zip(
        walks, trees, begun, strict=True
    ):  # once more, with what the other routines set
        others = [other.peak for other in walks if other is not walk]
        walk.start = given.get(walk.routine.casefold(), {})
        for name in {name for peak in others for name in peak}:
            walk.start[name] = max(walk.start.get(name, 0.0), *(peak.get(name, 0.0) for peak in others))
        walk.held, walk.found = held, {}
        walk.nodes(tree)
    return [one for walk in walks for one in walk.found.values()]


def _given(program: st.Program, walks: Iterable[_Walk]) -> Mapping[str, Lengths]:
    """By routine, case folded, what calls hand over for its parameters."""
    names = {r.name.casefold(): [p.name.casefold() for p in r.parameters] for r in program.routines}
    found: dict[str, Lengths] = {}
    for walk in walks:
        for routine, place, length in walk.handed:
            taken = names.get(routine, [])
            if place < len(taken):
                held = found.setdefault(routine, {})
                held[taken[place]] = max(held.get(taken[place], 0.0), length)
    return found


@dataclass(slots=True)
class _Walk:
    """One routine. `held`: lengths here; `peak`: the greatest ones; `start`: of names that it has not set yet."""

    routine: str
    held: Lengths = field(default_factory=dict)
    peak: Lengths = field(default_factory=dict)
    start: Lengths = field(default_factory=dict)
    found: dict[int, tuple[st.Statement, float]] = field(default_factory=dict)
    handed: list[tuple[str, int, float]] = field(default_factory=list)

    def nodes(self, nodes: Iterable[Node]) -> None:
        for node in nodes:
            if isinstance(node, Block):
                self._block(node)
            elif type(node) is st.Assign:
                self._assign(node, node.target, node.value)
            elif type(node) is st.Declare and node.value is not None:
                self._assign(node, ex.Named(node.name), node.value)
            elif type(node) is st.Call:
                self._hand(node)

    def _block(self, block: Block) -> None:
        before, after = dict(self.held), dict(self.held)
        for opener, inside in block.branches:
            self.held = dict(before)
            self.nodes(inside)
            if isinstance(opener, LOOPS):
                once = dict(self.held)
                self.nodes(inside)
                grown = [name for name, length in self.held.items() if length > once.get(name, 0.0)]
                if grown:
                    self.held |= dict.fromkeys(grown, math.inf)
                    self.nodes(inside)
            for name, length in self.held.items():
                after[name] = max(after.get(name, 0.0), length)
        self.held = after

    def _assign(self, s: st.Statement, target: ex.Expression, value: ex.Expression) -> None:
        name, length = _name(target), self._length(value)
        if not name or not (length or name in self.held):
            return
        if type(target) is ex.Item:  # another element may be longer
            length = max(length, self.held.get(name, 0.0))
        self.held[name] = length
        self.peak[name] = max(self.peak.get(name, 0.0), length)
        known = self.found.get(id(s))
        self.found[id(s)] = (s, max(length, 0.0 if known is None else known[1]))

    def _hand(self, s: st.Call) -> None:
        if calls_nothing(s) or not s.arguments:
            return
        self.handed += [(s.routine.casefold(), at, self._length(e)) for at, e in enumerate(s.arguments)]

    def _length(self, e: ex.Expression) -> float:
        if type(e) is ex.Text:
            return len(e.value)
        if type(e) is ex.Function:
            return self._of_function(e)
        name = _name(e)
        return self.held.get(name, self.start.get(name, 0.0)) if name else 0.0

    def _of_function(self, e: ex.Function) -> float:
        match e.name, e.arguments:
            case "joined-text", parts:
                return sum(self._part(part) for part in parts)
            case "part-of-text", (text, _, ex.Number(size), *_):
                return min(self._length(text), float(size))
            case "part-of-text", (text, *_):
                return self._length(text)
            case "text-of-value", _:
                return NUMBER
        return 0.0

    def _part(self, e: ex.Expression) -> float:
        return NUMBER if type(e) in (ex.Number, ex.Binary) else self._length(e)


def _name(e: ex.Expression) -> str:
    """Which variable an expression is, or an element of one; empty: none."""
    match e:
        case ex.Named(name):
            return name.casefold()
        case ex.Item(base):
            return _name(base)
        case ex.Variable(store, ex.Number(index)):
            return f"{store.name}{index:g}"
    return ""
