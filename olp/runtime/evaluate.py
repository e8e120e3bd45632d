"""The value of an expression, as the controller would compute it, within its limits and the kinds of its variables.

A name is that of a variable of the running routine, else of the data beside the routine, else of its file, else of
another file that shares it. Files of the folder are read when no file read so far knows the name.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

from olp.ir import expressions as ex
from olp.ir.points import PointKind, PointState
from olp.ir.program import Assign, Declare, Parameter, is_same
from olp.ir.transformer import expressions_of
from olp.runtime.assumptions import VARIABLE_LETTERS
from olp.runtime.jobs import RunnableRoutine
from olp.runtime.memory import (
    INTEGERS,
    RANGES,
    WHOLE,
    Array,
    Changes,
    PositionValue,
    Record,
    Scope,
    Slot,
    SystemPosition,
    Value,
    zero,
)
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError

# What a variable of each type begins with; `type` as that of `Declare`.
ZEROS: Final[Mapping[str, Value]] = {
    "integer": 0, "real": 0.0, "boolean": False, "string": "", "character": "",
}  # fmt: skip

_LEFT_OPEN: Final = ex.Unknown("")  # an element of an array to which no list gives a value
_POSE_SIZE: Final = 6
# Looked up once: every variable asks.
_ROBOT, _SYSTEM, _REAL, _STRING = ex.Store.ROBOT, ex.Store.SYSTEM, ex.Store.REAL, ex.Store.STRING
_POSITION_PARTS: Final = (ex.Store.ROBOT, ex.Store.BASE, ex.Store.STATION)
_CHECK: Final = "check the value on the right"


def read_variable(m: Machine, store: ex.Store, index: int, local: bool) -> Value:
    """A variable's value; one that nobody ever set holds zero, which is reported."""
    _check_index(index)
    key = (store, index)
    values = m.frame.locals if local else m.memory.values
    value = values.get(key)
    if value is not None:
        return value
    if store is _SYSTEM:
        parts = ((part, values.get((part, index))) for part in _POSITION_PARTS)
        held = tuple(
            (part, part_value) for part, part_value in parts if isinstance(part_value, PositionValue)
        )
        if held:
            return SystemPosition(held)
    made = (
        None if m.made_up is None or local else m.made_up.variable(store, index, m.conventions.taught_frames)
    )
    if made is not None:
        values[key] = made
        return made
    value = values[key] = zero(store)
    name = f"{'L' if local else ''}{VARIABLE_LETTERS[store]}{index:03d}"
    if store in ex.POSITION_STORES:
        del values[key]
        beside = "put VAR.DAT beside the job, or " if m.conventions.saved_variables else ""
        raise StatementError(
            "I203",
            f"position {name} has no value",
            f"{beside}say it in olp.toml: [variables] {name} = {{ pulse = [ … ] }}",
        )
    shown = '""' if store is _STRING else "0"
    files = "VAR.DAT or olp.toml" if m.conventions.saved_variables else "olp.toml"
    where = "never set before it is read here" if local else f"not in {files}"
    if not local:
        m.memory.assumed.add(key)
    m.assume(f"{name} is taken as {shown}: {where}")
    return value


def store_variable(m: Machine, store: ex.Store, index: int, local: bool, value: Value) -> None:
    """Stores a value as the variable's kind holds it. Raises StatementError when it does not fit."""
    _check_index(index)
    key = (store, index)
    if store is _SYSTEM:
        _store_system(m, index, local, value)
        return
    held = coerce(m, store, value)
    if local:
        if m.frame.locals.get(key) != held:
            m.memory.stamp += 1
            m.frame.changed[key] = m.memory.stamp
        m.frame.locals[key] = held
    else:
        m.memory.put(key, held)


def _store_system(m: Machine, index: int, local: bool, value: Value) -> None:
    if isinstance(value, PositionValue):  # the result of a pose function: that of the robot
        value = SystemPosition(((ex.Store.ROBOT, value),))
    if not isinstance(value, SystemPosition):
        raise StatementError(
            "I204", "only a whole system position can be stored here", "use a PX variable or $PX000"
        )
    for store, part in value.parts:
        store_variable(m, store, index, local, part)


def coerce(m: Machine, store: ex.Store, value: Value) -> Value:
    """`value` as a variable of kind `store` holds it."""
    if store is _REAL:
        if isinstance(value, (int, float)):
            return finite(float(value))
        raise StatementError("I204", "a real variable holds numbers only", _CHECK)
    if store in INTEGERS:
        return _integer(m, store, value)
    if store is _STRING:
        return value if isinstance(value, str) else _as_text(value)
    if isinstance(value, PositionValue) and (store is not _ROBOT or is_whole(value)):
        return value
    raise StatementError(
        "I204", "a position variable holds positions of its own kind only", "set its elements one by one"
    )


def is_whole(value: PositionValue) -> bool:
    """Whether a pose has all six numbers, as that of a robot must."""
    return value.state.kind is not PointKind.POSE or len(value.values) >= _POSE_SIZE


def _integer(m: Machine, store: ex.Store, value: Value) -> int:
    if isinstance(value, str):
        value = _parsed(value)
    if not isinstance(value, (int, float)):
        raise StatementError("I204", "an integer variable holds numbers only", _CHECK)
    result = value
    if isinstance(value, float):
        result = round_half_away(value)
        if result != value:
            m.assume("a real value is rounded to the nearest integer, halves away from zero")
    low, high = RANGES[store]
    if not low <= result <= high:
        raise StatementError(
            "I205",
            f"{result} does not fit a {store.value} variable ({low} .. {high}): it keeps its value",
            "the controller stops with an alarm here; use a wider variable",
        )
    return int(result)


def _parsed(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise StatementError("I204", f"the text {text[:40]!r} is not a number", _CHECK) from None


def _as_text(value: Value) -> str:
    if isinstance(value, bool):
        return "ON" if value else "OFF"
    if isinstance(value, (int, float)):
        return str(value)
    raise StatementError("I204", "a position cannot become a text", _CHECK)


def _check_index(index: int) -> None:
    if index < 0:
        raise StatementError("I221", f"there is no variable with the index {index}", "indices begin at 0")


_LARGEST: Final = 1e30  # larger than any variable of a controller holds in practice
_ARITHMETIC: Mapping[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
}
_NUMBERS: Final = frozenset((int, float))
_BITWISE: Mapping[str, Callable[[int, int], int]] = {
    "and": operator.and_,
    "or": operator.or_,
    "xor": operator.xor,
}
COMPARED: Mapping[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}


def calculate(sign: str, left: Value, right: Value) -> Value:
    """`left sign right` on numbers or strings; `/` of two integers is exact. Raises StatementError."""
    usual = _ARITHMETIC.get(sign)
    if usual is not None and type(left) in _NUMBERS and type(right) in _NUMBERS:
        return finite(usual(left, right))
    if isinstance(left, str) and sign == "+" and isinstance(right, (str, int, float)):
        return f"{left}{right}"
    if not isinstance(left, (int, float)) or not isinstance(right, (int, float)):
        raise StatementError("I201", f"'{sign}' needs two numbers")
    if sign in _BITWISE:
        return int(_BITWISE[sign](int(left), int(right)))
    if sign in ("/", "mod", "div"):
        if right == 0:
            raise StatementError("I207", "division by zero", "the controller stops with an alarm here")
        if sign == "mod":
            return _remainder(left, right)
        if sign == "div":
            return math.trunc(left / right)
        exact = isinstance(left, int) and isinstance(right, int) and left % right == 0
        return left // right if exact else left / right
    if sign not in _ARITHMETIC:
        raise StatementError("I216", f"the operator {sign} is not known to the interpreter")
    result: int | float = _ARITHMETIC[sign](left, right)
    return finite(result)


def check_divisor(m: Machine, sign: str, divisor: ex.Expression, value: Value) -> None:
    """Raises StatementError (I203) where a program divides by a variable that is 0 for want of a value."""
    if value != 0 or sign not in ("/", "mod", "div") or not isinstance(divisor, ex.Variable):
        return
    if (divisor.store, whole(m, divisor.index)) in m.memory.assumed and not divisor.local:
        name = f"{VARIABLE_LETTERS[divisor.store]}{whole(m, divisor.index):03d}"
        raise StatementError(
            "I203",
            f"{name} has no value, and nothing can be divided by 0: the statement is left out",
            f"say it in olp.toml: [variables] {name} = 1",
        )


def finite(value: int | float) -> int | float:
    """The value; one beyond every variable of a controller is refused (I202)."""
    if not -_LARGEST <= value <= _LARGEST:
        raise StatementError("I202", "the value is too large for any variable", "check the operands")
    return value


def _remainder(left: float, right: float) -> int | float:
    if isinstance(left, int) and isinstance(right, int):
        # Truncating division, as integers divide: the remainder takes the sign of the dividend.
        rest = abs(left) % abs(right)
        return -rest if left < 0 else rest
    return math.fmod(left, right)


def compare(sign: str, left: Value, right: Value) -> bool:
    """`left sign right` on two numbers or two texts. Raises StatementError (I208) on anything else."""
    texts = isinstance(left, str) and isinstance(right, str)
    numbers = isinstance(left, (int, float)) and isinstance(right, (int, float))
    if not texts and not numbers:
        raise StatementError("I208", "these two values cannot be compared", "compare numbers, or texts")
    return COMPARED[sign](left, right)


def round_half_away(value: float) -> int:
    """The nearest whole number, halves away from zero. Raises StatementError (I202) for infinite values."""
    if not math.isfinite(value):
        raise StatementError("I202", "the value is not finite", "check the operands")
    return int(math.copysign(math.floor(abs(value) + 0.5), value))


def evaluate(m: Machine, expression: ex.Expression) -> Value:
    """The value of `expression`. Raises StatementError for what has none."""
    return m.operations.evaluators[type(expression)](m, expression)


def known(m: Machine, expression: ex.Expression, otherwise: Value) -> Value:
    """The value, `otherwise` where no file says it and it may be assumed, which is reported."""
    try:
        return evaluate(m, expression)
    except StatementError as problem:
        if not m.may_assume(problem) or problem.code == "I215":
            raise
        m.fault(problem, f"taken as {_shown(otherwise)}")
        return otherwise


def _shown(value: Value) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return "an empty text" if value == "" else str(value)


def number(m: Machine, expression: ex.Expression) -> int | float:
    """The value as a number; on and off count as 1 and 0. Raises StatementError (I201) for anything else."""
    if type(expression) is ex.Number:
        return expression.value
    value = known(m, expression, 0)
    if isinstance(value, (int, float)):
        return value
    raise StatementError(
        "I201", f"{spell(expression)} is not a number", "use a byte, integer, double or real variable"
    )


def whole(m: Machine, expression: ex.Expression) -> int:
    """The value as a whole number, for indices and counts. Raises StatementError (I201)."""
    value = number(m, expression)
    return value if type(value) is int else round_half_away(value)


def quantity(m: Machine, value: ex.Quantity) -> float:
    """The SI value of a number with a unit."""
    literal = value.literal
    return float(literal) if literal is not None else number(m, value.written) * value.scale


def holds(m: Machine, condition: ex.Expression) -> bool:
    """Whether a condition is true; a bare number or signal counts as true when it is not zero."""
    value = known(m, condition, False)
    return bool(value) if isinstance(value, (bool, int, float)) else value != ""


def write_variable(m: Machine, target: ex.Variable, value: Value) -> None:
    """Stores a value as the variable's kind holds it. Raises StatementError when it does not fit."""
    index = target.index
    place = index.value if type(index) is ex.Number and type(index.value) is int else whole(m, index)
    store_variable(m, target.store, place, target.local, value)


def _variable(m: Machine, v: ex.Variable) -> Value:
    index = int(v.index.value) if type(v.index) is ex.Number else whole(m, v.index)
    if not v.local:
        value = m.memory.values.get((v.store, index))
        if value is not None:
            return value
    return read_variable(m, v.store, index, v.local)


def _taught(m: Machine, taught: ex.Taught) -> Value:
    point = m.frame.job.points.find(taught.store, True, taught.number)
    if point is None:
        raise StatementError(
            "I206", f"the routine teaches no {spell(taught)}", "add the point, or correct its number"
        )
    return PositionValue(point.state, point.values)


def _unary(m: Machine, e: ex.Unary) -> Value:
    if e.operator == "not":
        value = evaluate(m, e.operand)
        return not value if isinstance(value, bool) else ~_as_int(value, e.operand) & 0xFF
    return -number(m, e.operand)


def _as_int(value: Value, what: ex.Expression) -> int:
    if isinstance(value, int):
        return value
    raise StatementError(
        "I201", f"{spell(what)} is not a whole number", "use a byte, integer or double variable"
    )


def _compare(m: Machine, e: ex.Compare) -> Value:
    return compare(e.operator, *both(m, e.left, e.right))


def both(m: Machine, left: ex.Expression, right: ex.Expression) -> tuple[Value, Value]:
    """Two values that are compared or combined: one that no file says is the zero of the other's kind."""
    evaluators = m.operations.evaluators
    try:
        first = evaluators[type(left)](m, left)
    except StatementError as problem:
        if not m.may_assume(problem) or problem.code == "I215":
            raise
        second = known(m, right, 0)
        return known(m, left, _zero_like(second, problem)), second
    try:
        return first, evaluators[type(right)](m, right)
    except StatementError as problem:
        if not m.may_assume(problem) or problem.code == "I215":
            raise
        zero = _zero_like(first, problem)
        m.fault(problem, f"taken as {_shown(zero)}")
        return first, zero


def _zero_like(value: Value, problem: StatementError) -> Value:
    """Nothing, of the kind of `value`. Raises `problem` where there is none: a position is somewhere."""
    if isinstance(value, (bool, int, float, str)):
        return type(value)()
    raise problem


def _logic(m: Machine, e: ex.Logic) -> Value:
    result = holds(m, e.first)
    for word, condition in e.rest:
        if m.conventions.stops_early and result is _DECIDED_BY.get(word):
            _read_inputs(m, condition)
        else:
            result = _JOINED[word](result, holds(m, condition))
    return result


def _read_inputs(m: Machine, condition: ex.Expression) -> None:
    """Reads the inputs of an operand that is not evaluated: which are read must not depend on the order of writing."""
    for e in expressions_of(condition):
        if type(e) is ex.Signal and type(e.index) in _WRITTEN:
            evaluate(m, e)


_WRITTEN = (ex.Number, ex.Text)
_DECIDED_BY: Mapping[str, bool] = {"and": False, "or": True}  # on the left, whatever stands on the right

_JOINED: Mapping[str, Callable[[bool, bool], bool]] = {
    "and": lambda a, b: a and b,
    "or": lambda a, b: a or b,
    "xor": lambda a, b: a is not b,
}


def _argument(m: Machine, e: ex.Argument) -> Value:
    arguments = m.frame.arguments
    if 0 < e.number <= len(arguments):
        return arguments[e.number - 1]
    if m.frames:
        m.assume(f"argument {e.number} was not passed by the caller: taken as 0")
        return 0
    value = uncalled_argument(m, e.number, "integer" if _takes_whole(m, e) else "real")
    return 0 if value is None else value


_WHOLE_STORES: Final = frozenset({ex.Store.BYTE, ex.Store.INTEGER, ex.Store.DOUBLE})


def _takes_whole(m: Machine, e: ex.Argument) -> bool:
    """Whether an argument goes into variables of whole numbers alone: who calls with a fraction errs."""
    takers = [s.target for s in m.frame.job.body if type(s) is Assign and s.value == e]
    return bool(takers) and all(type(one) is ex.Variable and one.store in _WHOLE_STORES for one in takers)


def uncalled_argument(m: Machine, number: int, type_: str) -> Value | None:
    """What the main routine, which nothing here calls, takes: made up, else one; None of a type without values.

    One, for zero is no number of a register, a place or a tool, and no speed.
    """
    made = None if m.made_up is None else m.made_up.argument(number, type_)
    if made is not None:
        return made
    usual = {"integer": 1, "real": 1.0}.get(
        type_ or "integer", ZEROS.get(type_)
    )  # a type is mostly a number's
    if usual is not None:
        m.assume(f"argument {number} of the main routine, which nothing here calls, is taken as {usual!r}")
        m.unsure = True  # what goes wrong from here on may do so for that
    return usual


def _unknown(m: Machine, e: ex.Unknown) -> Value:
    certain = m.conventions.taught_frames  # a language without names: the text is a mistake
    raise StatementError(
        "I209", f"nothing defines {e.text}", "declare the name, or correct it", certain=certain
    )


def _named_argument(m: Machine, e: ex.NamedArgument) -> Value:
    return True if e.value is None else evaluate(m, e.value)


# What needs no other part of the interpreter; interpreter.py adds the rest.
PLAIN: Mapping[type, Callable[[Machine, Any], Value]] = {
    ex.Number: lambda m, e: e.value,
    ex.Text: lambda m, e: e.value,
    ex.SignalState: lambda m, e: e.on,
    ex.Variable: _variable,
    ex.Taught: _taught,
    ex.Argument: _argument,
    ex.Unary: _unary,
    ex.Compare: _compare,
    ex.Logic: _logic,
    ex.Unknown: _unknown,
    ex.NamedArgument: _named_argument,
}


_MOST_ITEMS = 100_000  # of an array, over all its dimensions; controllers stop far below
_AXES = 6  # of the arms that URScript moves
_STORABLE = (
    ex.Named,
    ex.Item,
    ex.Member,
    ex.Variable,
)  # what a routine hands a value back to; a constant stays


def fold(m: Machine, name: str) -> str:
    """The name as it is looked up: in most languages two names that differ in case only are the same."""
    return name if m.case_sensitive else name.casefold()


def find_slot(m: Machine, name: str) -> Slot | None:
    """The variable called `name` as the running routine sees it, None where nothing declares it."""
    key, frame = name if m.case_sensitive else name.casefold(), m.frame
    job = frame.job
    slot = frame.names.get(key) or job.data.get(key)
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
    if slot is not None and slot.value is not None:
        return slot.value
    given = m.assumptions.names.get(name.casefold())
    if given is not None:
        return PositionValue(*given) if isinstance(given, tuple) else given
    made = None if m.made_up is None else m.made_up.named(fold(m, name), "" if slot is None else slot.type)
    if made is not None:
        slot = slot or m.modules.setdefault(m.frame.job.source, {}).setdefault(fold(m, name), Slot(None))
        slot.value, slot.shared = made, True
        return made
    if slot is None and m.conventions.is_controllers(name):
        m.assume(f"{name} is taken as 0: the controller sets it")
        return 0
    if slot is None:
        help = "declare or correct it, put the file that declares it beside the program, or its value into olp.toml"
        raise StatementError("I209", f"nothing defines {name}", help)
    raise StatementError("I203", f"{name} has no value yet", "give it one before it is used")


def write_name(m: Machine, name: str, value: Value) -> None:
    """Stores a value; a name that nothing declares becomes a variable of the running routine."""
    slot = find_slot(m, name)
    if slot is None:
        slot = m.frame.names[fold(m, name)] = Slot(None)
    held = fitted(slot.type, copied(value))
    if slot.value != held:
        note_change(m, name)
    slot.value = held


def note_change(m: Machine, name: str, element: int | None = None) -> None:
    """Keeps that a named variable has changed, for loops that wait for it: one element (from 1), or None for all."""
    m.memory.stamp += 1
    place = WHOLE if element is None else element
    frame, outer, key = m.frame, len(m.frames), fold(m, name)
    while key in frame.names:
        _note(frame.changed, key, place, m.memory.stamp)
        if key not in frame.lent:
            return
        key, outer = frame.lent[key], outer - 1
        if outer < 0:
            break
        frame = m.frames[outer]
    _note(m.memory.changed, key, place, m.memory.stamp)


def _note(changed: Changes, key: str, place: int, stamp: int) -> None:
    kind = "name:" + key.casefold()
    changed[(kind, 0)] = changed[(kind, place)] = stamp


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
    shared = [(fold(m, d.name), d) for d in data if d.shared]
    for source, scope in m.modules.items():
        here = [(name, d) for name, d in shared if name in scope]
        if not here:  # as in most of many files
            continue
        others = {fold(m, d.name): d for d in m.jobs.programs[source].data if d.shared}
        for name, d in here:
            if name in others and is_same(d, others[name]):
                found.setdefault(name, scope[name])
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

    sizes = [max(0, whole(m, size)) for size in s.sizes] if s.sizes else []
    if sizes and math.prod(size or 1 for size in sizes) > _MOST_ITEMS:  # empty ones are built, too
        raise StatementError(
            "I202", f"{s.name} has more than {_MOST_ITEMS:,} items", "make the array smaller"
        )
    if s.value is None:
        slot = Slot(_empty(s.type, sizes), s.type, s.shared)
    else:
        value = evaluate(m, s.value)
        if sizes and isinstance(value, Array) and len(value.items) < sizes[0]:
            value.items.extend([ZEROS.get(s.type)] * (sizes[0] - len(value.items)))
        if isinstance(value, Array):
            value.items[:] = [ZEROS.get(s.type) if item is None else item for item in value.items]
        slot = Slot(fitted(s.type, value), s.type, s.shared)
    return slot if m.made_up is None else m.made_up.begun(fold(m, s.name), slot)


def _empty(type_: str, sizes: list[int]) -> Value | None:
    if not sizes:
        return ZEROS.get(type_)
    return Array([_empty(type_, sizes[1:]) for _ in range(sizes[0])])


def literal(m: Machine, e: ex.RecordLiteral) -> Value:
    """A record, or an array where the members have no names."""

    if e.members and not e.members[0][0]:
        return Array([None if value == _LEFT_OPEN else copied(evaluate(m, value)) for _, value in e.members])
    values = [
        (name, value.value if type(value) is ex.Number else copied(evaluate(m, value)))
        for name, value in e.members
    ]
    return Record(e.type, dict(values)) if values else Array([])


def bind(
    m: Machine, parameters: tuple[Parameter, ...], arguments: tuple[ex.Expression, ...]
) -> tuple[Scope, list[tuple[str, ex.Expression]], dict[str, str]]:
    """The parameters of a call as variables, which of them hand their value back, and where to, and which are a
    variable of the caller, with its name there.
    """
    scope: Scope = {}
    outs: list[tuple[str, ex.Expression]] = []
    lent: dict[str, str] = {}
    by_name = {fold(m, a.name): a for a in _named(m, arguments)}
    positional = iter([a for a in arguments if not isinstance(a, ex.NamedArgument)])
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
        slot = find_slot(m, given.name) if parameter.by_reference and isinstance(given, ex.Named) else None
        if slot is None:
            if parameter.type == "signal" and isinstance(given, ex.Signal):
                given = given.index  # the signal itself, by its name, and not its state
            slot = Slot(fitted(parameter.type, copied(evaluate(m, given))), parameter.type)
            if parameter.by_reference and isinstance(given, _STORABLE):
                outs.append((key, _chosen(m, given)))
        elif isinstance(given, ex.Named):
            lent[key] = fold(m, given.name)
        scope[key] = slot
    return scope, outs, lent


def _chosen(m: Machine, target: ex.Expression) -> ex.Expression:
    """A variable with the indices that it has at the call: the routine may change what they are computed from."""
    if isinstance(target, ex.Item):
        indices = tuple([_counted(m, index) for index in target.indices])
        return replace(target, base=_chosen(m, target.base), indices=indices)
    if isinstance(target, ex.Member):
        return replace(target, base=_chosen(m, target.base))
    return target


def _counted(m: Machine, index: ex.Expression) -> ex.Expression:
    """An index as a number; one that stands for all elements is kept."""
    if isinstance(index, (ex.Number, ex.Unknown)):
        return index
    value = evaluate(m, index)
    return ex.Number(value) if isinstance(value, (int, float)) else index


def bind_uncalled(m: Machine, parameters: tuple[Parameter, ...]) -> None:
    """The parameters of a main routine, which nothing here calls: made-up values, else zeros, which is reported."""

    for number, one in enumerate(parameters, 1):
        if one.default is not None:
            value: Value | None = evaluate(m, one.default)
        elif one.optional or one.switch:
            continue
        else:
            value = uncalled_argument(m, number, one.type)
        m.frame.names[fold(m, one.name)] = Slot(None if value is None else fitted(one.type, value), one.type)


def _named(m: Machine, arguments: tuple[ex.Expression, ...]) -> Iterator[ex.NamedArgument]:
    """The arguments by name; one that passes an optional parameter on (RAPID x?y) where the caller has got it."""
    for a in arguments:
        if not isinstance(a, ex.NamedArgument):
            continue
        if not a.name.endswith("?"):
            yield a
        elif isinstance(a.value, ex.Named) and is_given(m, a.value.name):
            yield ex.NamedArgument(a.name[:-1], a.value)


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
