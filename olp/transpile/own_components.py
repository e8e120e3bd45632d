"""Components of positions, tools and frames that only the source's language has."""

from __future__ import annotations

from typing import Final

from olp.ir.expressions import Expression, Item, Member, Named
from olp.ir.program import Declare, Move, Program
from olp.ir.transformer import calls_nothing, expressions_of, sets_numbers
from olp.languages.vendor import language_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.symbols import Symbols

_SHARED: Final = frozenset({"x", "y", "z", "rx", "ry", "rz", "e1", "e2", "e3", "e4", "e5", "e6"})
_AXES: Final = frozenset(f"{letter}{number}" for letter in "aj" for number in range(1, 7))
_POSITIONS: Final = frozenset({"position", "joints"})
_SYSTEMS: Final = frozenset({"tool", "frame"})


def own_components(program: Program, work: TranslationContext) -> Program:
    """Refuses statements with such: a quaternion's part, a tool's load, one of a frame's two parts, arm flags.

    Where tools and frames have numbers, no component of them is a variable.
    """
    symbols = work.symbols(program)
    held = _POSITIONS if work.limits.numbered else _POSITIONS | _SYSTEMS
    for routine in program.routines:
        for s in routine.body:
            if isinstance(s, Declare) or calls_nothing(s) or sets_numbers(s):
                continue
            if isinstance(s, Move) and not s.has_signals:
                continue
            for e in expressions_of(s):
                kind = system_or_position(e.base, symbols, routine.name) if isinstance(e, Member) else ""
                if isinstance(e, Member) and kind and not (kind in held and _is_shared(e.name, kind)):
                    other = language_of(work.target)
                    says = f"the component {e.name} of a position, tool or frame, which {other} lacks"
                    work.lose(s, Fate.REFUSED, "component", says)
    return program


def _is_shared(component: str, kind: str) -> bool:
    """Whether other languages have it too: places, angles, external axes, and the axes of joint values."""
    return component in _SHARED or (kind == "joints" and component.lower() in _AXES)


def system_or_position(base: Expression, symbols: Symbols, routine: str) -> str:
    """Which of them has a component: position, joints, tool or frame; "" for records."""
    while isinstance(base, Item):
        base = base.base
    symbol = symbols.find(routine, base.name) if isinstance(base, Named) else None
    return symbol.type if symbol is not None and symbol.type in _POSITIONS | _SYSTEMS else ""
