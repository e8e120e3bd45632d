"""What numbered variables hold before a program sets them: the values of VAR.DAT and olp.toml beside it.

A controller's variables live on when a program ends. Positions among them are taught like points; numbers are counters
and recipes, which keep their values in languages that have data beside the program, and are left to their operator in
others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

from olp.assumptions import Given
from olp.expression import Expression, Item, Named, Number, Store, Text, Variable
from olp.interpreter.initial import NUMBERS, POSITIONS, saved_position
from olp.points import Point
from olp.program import Routine
from olp.translate.work import Fate, Work, world_of


def saved_values(work: Work) -> dict[tuple[Store, int], Given]:
    """By kind and number; olp.toml wins over VAR.DAT. Nothing where neither file is there."""
    if work.source.vendor != "inform":
        return {}
    world = world_of(work.source, work.robot)
    found: dict[tuple[Store, int], Given] = {}
    variables = None if world.backup is None else world.backup.variables
    if variables is not None:
        for store, letters in NUMBERS.items():
            found |= {(store, n): value for n, value in getattr(variables, letters).items()}
        for store, letters in POSITIONS.items():
            found |= {(store, n): saved_position(value) for n, value in getattr(variables, letters).items()}
    return found | dict(world.assumptions.variables)


def saved_points(values: Mapping[tuple[Store, int], Given]) -> Iterator[Point]:
    """The positions of robots among them."""
    for (store, number), value in values.items():
        if store is Store.ROBOT and isinstance(value, tuple):
            yield Point(number, value.values, value.state, 0)


def saved_number(value: Given | None) -> Expression | None:
    """A number or text as it is written in a declaration; None for what a declaration has anyway, or for a position."""
    if isinstance(value, str):
        return Text(value) if value else None
    return Number(value) if isinstance(value, (int, float)) and value else None


def label_of(name: Expression) -> str:
    """A variable, or an element of an array by its constant index, as the receipt names it."""
    if isinstance(name, Item) and isinstance(name.base, Named) and isinstance(name.indices[0], Number):
        return f"{name.base.name}[{name.indices[0].value}]"
    assert isinstance(name, Named)
    return name.name


def tell_unset(
    work: Work,
    routines: Iterable[Routine],
    name_of: Callable[[Variable], Expression],
    is_set: Callable[[Expression], bool],
) -> None:
    """Positions that a move goes to and nothing here sets; a name has to be declared with a value."""
    numbers = bool(work.limits.numbered)
    says = "nothing here sets this position, and no VAR.DAT or olp.toml holds it"
    says += ": it has to be taught" if numbers else ": zeros are declared"
    told: set[str] = set()
    for s in [s for routine in routines for s in work.look(routine).unnamed()]:
        for e in s.targets:
            if not isinstance(e, Variable) or e.local or type(e.index) is not Number:
                continue
            if e.store is Store.SYSTEM:
                continue
            name = name_of(e)
            label = label_of(name)
            if label not in told and not is_set(name):
                told.add(label)
                work.lose(s, Fate.APPROXIMATED, "position", says)
                work.ask(f"teach these positions{'' if numbers else ', which are zeros now'}", label)
