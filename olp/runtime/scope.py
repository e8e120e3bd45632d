"""Named variables: where a name is looked for, and how it comes into being.

A name is that of a variable of the running routine, else of the data beside the routine, else of its file, else of
another file that shares it. Files of the folder are read when no file read so far knows the name.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from olp.ir.expressions import Expression, Item, Member, Named, NamedArgument, RecordLiteral, Signal, Variable
from olp.ir.points import PointKind, PointState
from olp.ir.program import Declare, Parameter
from olp.ir.statements import is_same
from olp.runtime.evaluate import ZEROS, round_half_away
from olp.runtime.jobs import RunnableRoutine
from olp.runtime.memory import Array, PositionValue, Record, Scope, Slot, Value
from olp.runtime.state import Machine, StatementError

_MOST_ITEMS = 100_000  # of an array, over all its dimensions; controllers stop far below
_AXES = 6  # of the arms that URScript moves
_STORABLE = (Named, Item, Member, Variable)  # what a routine hands a value back to; a constant stays


def fold(m: Machine, name: str) -> str:
    """The name as it is looked up: in most languages two names that differ in case only are the same."""
    return name if m.case_sensitive else name.casefold()


def find_slot(m: Machine, name: str) -> Slot | None:
    """The variable called `name` as the running routine sees it, None where nothing declares it."""
    key, job = fold(m, name), m.frame.job
    slot = m.frame.names.get(key) or job.data.get(key)
    if slot is None:
        slot = m.modules.get(job.source, {}).get(key) or _shared(m, key)
    if slot is None and (m.jobs.read_naming((name,)) or len(m.modules) < len(m.jobs.programs)):
        for source in range(len(m.jobs.programs)):
            declare_module(m, source)
        slot = _shared(m, key)
    return slot


def _shared(m: Machine, key: str) -> Slot | None:
    return next((scope[key] for scope in m.modules.values() if key in scope and scope[key].shared), None)


def read_name(m: Machine, name: str) -> Value:
    """The value of a named variable; a controller's own variable that nobody set counts as 0, which is reported.

    Raises StatementError: I209 where nothing declares it, I203 where it has no value yet.
    """
    slot = find_slot(m, name)
    if slot is None or slot.value is None:
        given = m.assumptions.names.get(name.casefold())
        if given is not None:
            return PositionValue(*given) if isinstance(given, tuple) else given
        made = (
            None if m.made_up is None else m.made_up.named(fold(m, name), "" if slot is None else slot.type)
        )
        if made is not None:
            slot = slot or m.modules.setdefault(m.frame.job.source, {}).setdefault(fold(m, name), Slot(None))
            slot.value, slot.shared = made, True
            return made
    if slot is None and name.startswith("$"):
        m.assume(f"{name} is taken as 0: the controller sets it")
        return 0
    if slot is None:
        help = "declare or correct it, put the file that declares it beside the program, or its value into olp.toml"
        raise StatementError("I209", f"nothing defines {name}", help)
    if slot.value is None:
        raise StatementError("I203", f"{name} has no value yet", "give it one before it is used")
    return slot.value


def write_name(m: Machine, name: str, value: Value) -> None:
    """Stores a value; a name that nothing declares becomes a variable of the running routine."""
    slot = find_slot(m, name)
    if slot is None:
        slot = m.frame.names[fold(m, name)] = Slot(None)
    held = fitted(slot.type, copied(value))
    if slot.value != held:
        note_change(m, name)
    slot.value = held


def note_change(m: Machine, name: str) -> None:
    """Keeps that a named variable has changed, for loops that wait for it."""
    m.memory.stamp += 1
    m.memory.changed[("name:" + name.casefold(), 0)] = m.memory.stamp


def fitted(type_: str, value: Value) -> Value:
    """`value` as a variable of that type holds it: an integer rounds."""
    if type_ == "integer" and isinstance(value, float):
        return round_half_away(value)
    if type_ == "real" and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    return value


def copied(value: Value) -> Value:
    """A value that no later change of the original reaches."""
    if isinstance(value, Array):
        return Array([None if item is None else copied(item) for item in value.items])
    if isinstance(value, Record):
        return Record(value.type, {name: copied(item) for name, item in value.members.items()}, value.partial)
    return value


def declare(m: Machine, s: Declare) -> None:
    """Makes a variable of the running routine, or of its file where the declaration is shared."""
    if not s.shared:
        m.frame.names[fold(m, s.name)] = _slot(m, s)
        return
    scope = m.modules.setdefault(m.frame.job.source, {})
    known = scope.get(fold(m, s.name))
    slot = _slot(m, s)
    if known is None:
        scope[fold(m, s.name)] = slot
    elif s.value is not None and slot.value is not None:
        if known.value != slot.value:
            note_change(m, s.name)
        known.value = slot.value


def declare_all(m: Machine, job: RunnableRoutine) -> None:
    """Makes the variables of a routine's file, and those that belong to the routine."""
    declare_module(m, job.source)
    _into(m, job.data, job.routine.data)


def declare_module(m: Machine, source: int) -> None:
    if source in m.modules:
        return
    same = _same_elsewhere(m, m.jobs.programs[source].data)
    m.modules[source] = same
    _into(m, same, tuple(d for d in m.jobs.programs[source].data if fold(m, d.name) not in same))


def _same_elsewhere(m: Machine, data: tuple[Declare, ...]) -> Scope:
    """The variables of other files that these declarations, which share them, declare again."""
    found: Scope = {}
    for source, scope in m.modules.items():
        others = {fold(m, d.name): d for d in m.jobs.programs[source].data if d.shared}
        for d in data:
            other = others.get(fold(m, d.name))
            if d.shared and other is not None and is_same(d, other) and fold(m, other.name) in scope:
                found.setdefault(fold(m, d.name), scope[fold(m, d.name)])
    return found


def _into(m: Machine, scope: Scope, data: tuple[Declare, ...]) -> None:
    """Makes variables; those whose value names one that is declared further down come after it."""
    waiting, before = data, m.declaring
    m.declaring = True  # nothing is assumed: another row may say it
    try:
        _in_any_order(m, scope, waiting)
    finally:
        m.declaring = before


def _in_any_order(m: Machine, scope: Scope, waiting: tuple[Declare, ...]) -> None:
    while waiting:
        failed: list[tuple[Declare, StatementError]] = []
        for declaration in waiting:
            try:
                scope[fold(m, declaration.name)] = _slot(m, declaration)
            except StatementError as found:
                failed.append((declaration, found))
        if len(failed) == len(waiting):
            break
        waiting = tuple(declaration for declaration, _ in failed)
    else:
        return
    for declaration, problem in failed:
        # A value that needs the running robot is no value; whoever reads the variable hears of it.
        scope[fold(m, declaration.name)] = Slot(None, declaration.type, declaration.shared)
        if problem.code != "I209":
            m.assume(f"{declaration.name} has no value that can be known before the program runs")


def _slot(m: Machine, s: Declare) -> Slot:
    from olp.runtime.evaluate import evaluate, whole

    sizes = [max(0, whole(m, size)) for size in s.sizes]
    if math.prod(size or 1 for size in sizes) > _MOST_ITEMS:  # empty ones are built, too
        raise StatementError(
            "I202", f"{s.name} has more than {_MOST_ITEMS:,} items", "make the array smaller"
        )
    if s.value is None:
        slot = Slot(_empty(s.type, sizes), s.type, s.shared)
    else:
        value = evaluate(m, s.value)
        if sizes and isinstance(value, Array) and len(value.items) < sizes[0]:
            value.items.extend([ZEROS.get(s.type)] * (sizes[0] - len(value.items)))
        slot = Slot(fitted(s.type, value), s.type, s.shared)
    return slot if m.made_up is None else m.made_up.begun(fold(m, s.name), slot)


def _empty(type_: str, sizes: list[int]) -> Value | None:
    if not sizes:
        return ZEROS.get(type_)
    return Array([_empty(type_, sizes[1:]) for _ in range(sizes[0])])


def literal(m: Machine, e: RecordLiteral) -> Value:
    """A record, or an array where the members have no names."""
    from olp.runtime.evaluate import evaluate

    values = [(name, copied(evaluate(m, value))) for name, value in e.members]
    if values and not values[0][0]:
        return Array([value for _, value in values])
    return Record(e.type, dict(values)) if values else Array([])


def bind(
    m: Machine, parameters: tuple[Parameter, ...], arguments: tuple[Expression, ...]
) -> tuple[Scope, list[tuple[str, Expression]]]:
    """The parameters of a call as variables, and which of them hand their value back, and where to."""
    from olp.runtime.evaluate import evaluate

    scope: Scope = {}
    outs: list[tuple[str, Expression]] = []
    by_name = {fold(m, a.name): a for a in _named(m, arguments)}
    positional = iter([a for a in arguments if not isinstance(a, NamedArgument)])
    for parameter in parameters:
        key = fold(m, parameter.name)
        named = by_name.get(key)
        if named is None and (parameter.switch or (parameter.optional and parameter.default is None)):
            continue
        given = named.value if named is not None else next(positional, None)
        if named is not None and given is None:
            scope[key] = Slot(True, "boolean")
            continue
        if given is None:
            given = parameter.default
        if given is None:
            m.assume(f"the parameter {parameter.name} is not given by the caller")
            continue
        slot = find_slot(m, given.name) if parameter.by_reference and isinstance(given, Named) else None
        if slot is None:
            if parameter.type == "signal" and isinstance(given, Signal):
                given = given.index  # the signal itself, by its name, and not its state
            slot = Slot(fitted(parameter.type, copied(evaluate(m, given))), parameter.type)
            if parameter.by_reference and isinstance(given, _STORABLE):
                outs.append((key, given))
        scope[key] = slot
    return scope, outs


def bind_uncalled(m: Machine, parameters: tuple[Parameter, ...]) -> None:
    """The parameters of a main routine, which nothing here calls: made-up values, else zeros, which is reported."""
    from olp.runtime.evaluate import evaluate, uncalled_argument

    for number, one in enumerate(parameters, 1):
        if one.default is not None:
            value: Value | None = evaluate(m, one.default)
        elif one.optional or one.switch:
            continue
        else:
            value = uncalled_argument(m, number, one.type)
        m.frame.names[fold(m, one.name)] = Slot(None if value is None else fitted(one.type, value), one.type)


def _named(m: Machine, arguments: tuple[Expression, ...]) -> Iterator[NamedArgument]:
    """The arguments by name; one that passes an optional parameter on (RAPID x?y) where the caller has got it."""
    for a in arguments:
        if not isinstance(a, NamedArgument):
            continue
        if not a.name.endswith("?"):
            yield a
        elif isinstance(a.value, Named) and is_given(m, a.value.name):
            yield NamedArgument(a.name[:-1], a.value)


def is_given(m: Machine, name: str) -> bool:
    """Whether an optional parameter was given by the caller (RAPID Present)."""
    return fold(m, name) in m.frame.names


def position_of(value: Value, what: str) -> PositionValue:
    """The value as a position; URScript's lists of six numbers are joint values [rad]. Raises StatementError (I209)."""
    if isinstance(value, PositionValue):
        return value
    if isinstance(value, Array):
        axes = [float(one) for one in value.items if isinstance(one, (int, float))]
        if len(axes) == len(value.items) == _AXES:
            return PositionValue(PointState(PointKind.JOINT, "joint"), tuple(axes))
    raise StatementError("I209", f"{what} is no position", "use a position variable or a taught point")
