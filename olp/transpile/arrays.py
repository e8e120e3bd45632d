"""How many elements arrays have; what an index takes from beyond them is refused, for it is another variable."""

from __future__ import annotations

from olp.ir.expressions import Expression, Item, Named, Number, RecordLiteral
from olp.ir.program import Program
from olp.ir.transformer import expressions_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.symbols import Symbol, Symbols


def sizes_of(symbols: Symbols, symbol: Symbol) -> tuple[int, ...] | None:
    """The elements of each dimension; () of what is no array, None where nothing at hand tells."""
    found = []
    for size in symbol.sizes:
        value = symbols.fixed_value(symbol.scope, size)
        if not isinstance(value, Number):
            return _listed(symbol) if len(symbol.sizes) == 1 else None
        found.append(int(value.value))
    return tuple(found) if found else _listed(symbol)


def _listed(symbol: Symbol) -> tuple[int, ...] | None:
    """Of an array whose elements are written out and nothing else says how many there are."""
    if isinstance(symbol.value, RecordLiteral) and all(not name for name, _ in symbol.value.members):
        return (len(symbol.value.members),)
    return None if symbol.sizes else ()


def largest_indices(program: Program, work: TranslationContext) -> dict[str, int]:
    """The largest index that is written out of each array of one dimension."""
    found: dict[str, int] = {}
    for routine in program.routines:
        for e in work.look(routine).expressions:
            if type(e) is Item and type(e.base) is Named and len(e.indices) == 1:
                index = e.indices[0]
                if type(index) is Number:
                    found[e.base.name] = max(found.get(e.base.name, 1), int(index.value))
    return found


def array_bounds(program: Program, work: TranslationContext) -> Program:
    """Refuses elements beyond an array's end; for numbered languages also computed ones where no end is known."""
    if not any(type(e) is Item for routine in program.routines for e in work.look(routine).expressions):
        return program
    symbols = work.symbols(program)
    for routine in program.routines:
        for _, s in work.look(routine).rare:
            for e in expressions_of(s):
                says = _wrong(symbols, routine.name, e, bool(work.limits.numbered)) if type(e) is Item else ""
                if says:
                    work.lose(s, Fate.REFUSED, "index", says)
                    break
    return program


def _wrong(symbols: Symbols, routine: str, e: Item, numbered: bool) -> str:
    """What is wrong with an element of an array, nothing where it is one, or no array of a program's own."""
    symbol = symbols.find(routine, e.base.name) if type(e.base) is Named else None
    if symbol is None:
        return ""
    sizes = sizes_of(symbols, symbol)
    if sizes == ():
        return ""
    values = [symbols.fixed_value(routine, index) for index in e.indices]
    if sizes is None or not all(sizes):
        unknown = numbered and not all(isinstance(value, Number) for value in values)
        return (
            f"nothing tells how many elements {symbol.name} has, and the index is computed" if unknown else ""
        )
    for value, size in zip(values, sizes, strict=False):
        if isinstance(value, Number) and not 1 <= value.value <= size:
            return f"{symbol.name} has {size} elements, and the index is {_shown(value)}"
    return ""


def _shown(e: Expression) -> str:
    return f"{e.value:g}" if isinstance(e, Number) else ""
