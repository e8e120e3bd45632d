"""Lowers instructions that do not move: outputs, waits, counters, modal settings, messages."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from olp.core.units import mm, percent
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendor import SHOWN
from olp.languages.vendors.rapid.expressions import (
    NO_LIMIT,
    RapidExpressionRules,
    as_state,
    bit_is_set,
    bit_value,
)
from olp.languages.vendors.rapid.predefined_data import FASTEST, SIGNAL_USERS
from olp.languages.vendors.rapid.syntax import RapidArgument

Lowered = list[st.Statement]
Rule = Callable[
    [RapidExpressionRules, str, list[RapidArgument]], Lowered | None
]  # None: kept as a process instruction


def options_of(rules: RapidExpressionRules, given: list[RapidArgument]) -> dict[str, ex.Expression]:
    """All options by name, lower case; a switch is TRUE."""
    return {
        option.name.lower(): ex.SignalState(True) if option.value is None else rules.coerce(option.value, "")
        for one in given
        for option in one.options
    }


def values_of(
    rules: RapidExpressionRules, name: str, given: list[RapidArgument], count: int, kind: str = ""
) -> list[ex.Expression]:
    """The positional arguments, at least `count`. Raises BrokenLineError."""
    found = [rules.coerce(one.value, kind) for one in given if one.value is not None]
    if len(found) < count:
        raise BrokenLineError(
            f"{name} needs {count} argument{'s' if count > 1 else ''}, and {len(found)} are given", word=name
        )
    return found


def _output(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered | None:
    """SetDO, SetGO, SetAO; a delay is left out, with \\Sync they wait until the output is set."""
    options = options_of(rules, given)
    if set(options) - {"sync", "sdelay"}:
        return None
    place, value = values_of(rules, name, given, 2)[:2]
    signal = rules.signal(place, SIGNAL_USERS[name.lower()])
    state = as_state(signal, value)
    is_set = st.Wait(0, ex.Compare("=", signal, state), spelling=f"Wait{name[3:]}")
    late = _beside(
        "the delay of the output, which switches at once" if "sdelay" in options else "", acts=True
    )
    return [st.SetOutput(0, signal, state), *([is_set] if "sync" in options else []), *late]


def _alias(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered | None:
    """AliasIO: the variable stands for the signal of that name from here on."""
    called, variable = values_of(rules, name, given, 2)[:2]
    if not isinstance(variable, ex.Signal) or not isinstance(variable.index, ex.Named):
        return None
    if isinstance(called, (ex.Named, ex.Signal)):
        called = rules.signal(called, variable.bus).index
    return [st.Assign(0, variable.index, called)]


def _clock(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    """ClkStart, ClkStop; ClkReset stops the clock and sets it to 0."""
    values = tuple(values_of(rules, name, given, 1)[:1])
    runs = st.Assign(0, ex.Function("timer-running", values), ex.SignalState(name.lower() == "clkstart"))
    return (
        [runs, st.Assign(0, ex.Function("timer", values), ex.Number(0))]
        if name.lower() == "clkreset"
        else [runs]
    )


def _switch(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    signal = rules.signal(values_of(rules, name, given, 1)[0], "out")
    return [st.SetOutput(0, signal, ex.SignalState(name.lower() == "set"))]


def _invert(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    signal = rules.signal(values_of(rules, name, given, 1)[0], "out")
    return [st.SetOutput(0, signal, ex.Unary("not", signal))]


def _pulse(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    options = options_of(rules, given)
    signal = rules.signal(values_of(rules, name, given, 1)[0], "out")
    length = options.get("plength")
    duration = None if length is None else ex.Quantity(length, 1.0)
    return [st.PulseOutput(0, signal, duration, spelling="High" if "high" in options else "")]


def _dwell(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    dwell = st.Dwell(0, ex.Quantity(values_of(rules, name, given, 1)[0], 1.0))
    if "inpos" in options_of(rules, given):
        return [st.Process(0, "WaitRob", (("", ex.Text("\\InPos")),)), dwell]
    return [dwell]


_COMPARED: Final = {"lt": "<", "gt": ">", "noteq": "<>"}


def _wait_signal(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered | None:
    options = options_of(rules, given)
    if "maxtime" in options and "valueattimeout" in options:
        return None
    place, value = values_of(rules, name, given, 2)[:2]
    signal = rules.signal(place, SIGNAL_USERS[name.lower()])
    operator = next((sign for option, sign in _COMPARED.items() if option in options), "=")
    return _wait(ex.Compare(operator, signal, as_state(signal, value)), options, name)


def _wait_until(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    options = options_of(rules, given)
    found = _wait(values_of(rules, name, given, 1)[0], options, name)
    return [st.Process(0, "WaitRob", (("", ex.Text("\\InPos")),)), *found] if "inpos" in options else found


def _wait(condition: ex.Expression, options: dict[str, ex.Expression], word: str) -> Lowered:
    limit = options.get("maxtime")
    endless = limit == NO_LIMIT
    if endless:
        limit = None
    wait = st.Wait(0, condition, None if limit is None else ex.Quantity(limit, 1.0), spelling=word)
    flag = options.get("timeflag")
    if flag is None:
        return [wait]
    return [wait, st.Assign(0, flag, ex.SignalState(False) if endless else ex.SystemValue("timed-out"))]


def _step(operator: str) -> Rule:
    def lowered(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
        return [st.Update(0, operator, values_of(rules, name, given, 1)[0], ex.Number(1))]

    return lowered


def _add(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    target, value = values_of(rules, name, given, 2)[:2]
    return [st.Update(0, "+", target, value)]


def _clear(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    return [st.Assign(0, values_of(rules, name, given, 1)[0], ex.Number(0))]


def _bit(on: bool) -> Rule:
    """BitSet, BitClear: a bit is added, or taken away, where it is not as it should be."""

    def lowered(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
        target, place = values_of(rules, name, given, 2)[:2]
        is_set = bit_is_set(target, place)
        change = st.Update(0, "+" if on else "-", target, bit_value(place))
        return [st.If(0, ex.Unary("not", is_set) if on else is_set), change, st.EndIf(0)]

    return lowered


def _taken(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    """WaitTestAndSet: waits until no task has taken a thing, and takes it."""
    target = values_of(rules, name, given, 1)[0]
    return [st.Wait(0, ex.Unary("not", target), spelling=name), st.Assign(0, target, ex.SignalState(True))]


def _message(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered | None:
    text = values_of(rules, name, given, 1)[0]
    options = options_of(rules, given)
    shown = [value for option, value in options.items() if option in ("num", "bool", "dnum")]
    if not shown:
        place = options.keys() & {"pos", "orient"}
        return [st.Message(0, text), *_beside("the position or turn behind the text" if place else "")]
    return [st.Message(0, ex.Function("joined-text", (text, ex.Function("text-of-value", (shown[0],)))))]


def _pause(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    return [st.Pause(0, spelling="Break" if name.lower() == "break" else "")]


def _acceleration(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered | None:
    """AccSet; a ramp below 100 % is kept beside it as written."""
    values = values_of(rules, name, given, 2)
    rate = st.Acceleration(st.AccelerationUnit.FRACTION, ex.Quantity(values[0], percent))
    plain = values[1] == ex.Number(100) and not options_of(rules, given)
    return [st.SetAcceleration(0, (rate,)), *_beside("" if plain else "how fast the acceleration builds up")]


def _override(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered | None:
    share, fastest = values_of(rules, name, given, 2)[:2]
    bound = None if fastest == ex.Number(int(FASTEST)) else ex.Quantity(fastest, mm)
    return [st.SetOverride(0, ex.Quantity(share, percent), fastest=bound)]


BESIDE: Final = "beside"  # the name of a process that says more exactly what the statement before it says
ACTS: Final = "acts"  # of its argument, where the machine does something else without it


def _beside(what: str, *, acts: bool = False) -> Lowered:
    return [st.Process(0, BESIDE, ((ACTS if acts else "", ex.Text(what)),))] if what else []


def _log(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered | None:
    """ErrWrite: a head and up to four rows into the event log, shown unless it is a warning (W) or information (I)."""
    rows = values_of(rules, name, given, 2)[:2]
    more = [value for option, value in options_of(rules, given).items() if option.startswith("rl")]
    text: ex.Expression = rows[0]
    for row in (*rows[1:], *more):
        text = _joined(_joined(text, ex.Text(": ")), row)
    return [st.Process(0, name, ((SHOWN, text),))]


def _joined(first: ex.Expression, second: ex.Expression) -> ex.Expression:
    if isinstance(first, ex.Text) and isinstance(second, ex.Text):
        return ex.Text(first.value + second.value)
    return ex.Function("joined-text", (first, second))


_TRIGGERED: Final = {"dop": "out", "gop": "out-group", "aop": "analog-out"}


def _trigger(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered | None:
    """TriggIO, TriggEquip: kept as written, with what a run needs beside it: how far from the end in mm or s."""
    options = options_of(rules, given)
    bus = next((bus for word, bus in _TRIGGERED.items() if word in options), "")
    values = values_of(rules, name, given, 3)
    if (
        not bus
        or not isinstance(values[0], ex.Named)
        or options.keys() - _TRIGGERED.keys() - {"start", "time"}
    ):
        return None
    signal = rules.signal(options[next(word for word in _TRIGGERED if word in options)], bus)
    arguments = (
        ("triggdata", values[0]),
        ("signal", signal),
        ("value", as_state(signal, values[-1])),
        ("start", ex.SignalState("start" in options)),
        ("s" if "time" in options else "mm", values[1]),
    )
    lag = (("lag", values[2]),) if name.lower() == "triggequip" else ()
    return [st.Process(0, name, (*arguments, *lag))]


def _shift_set(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    return [st.ShiftOn(0, values_of(rules, name, given, 1, "pose")[0])]


def _shift_on(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    """PDispOn: from where a point was programmed to where it is now, or to \\ExeP."""
    options = options_of(rules, given)
    point = values_of(rules, name, given, 2, "robtarget")[0]
    there = options.get("exep", ex.SystemValue("current-pose"))
    if "rot" in options:
        offset = ex.Function("pose-product", (there, ex.Function("pose-inverse", (point,))))
    else:
        ways = (ex.Binary("-", ex.Member(there, axis), ex.Member(point, axis)) for axis in ("x", "y", "z"))
        offset = ex.Function("pose-angles", (*ways, ex.Number(0), ex.Number(0), ex.Number(0)))
    return [st.ShiftOn(0, offset), st.Process(0, BESIDE)]


def _shift_off(rules: RapidExpressionRules, name: str, given: list[RapidArgument]) -> Lowered:
    return [st.ShiftOff(0)]


RULES: Final[dict[str, Rule]] = {
    "setdo": _output,
    "setgo": _output,
    "setao": _output,
    "aliasio": _alias,
    **dict.fromkeys(("clkstart", "clkstop", "clkreset"), _clock),
    "set": _switch,
    "reset": _switch,
    "invertdo": _invert,
    "pulsedo": _pulse,
    "waittime": _dwell,
    **dict.fromkeys(("waitdi", "waitdo", "waitgi", "waitgo", "waitai", "waitao"), _wait_signal),
    "waituntil": _wait_until,
    "incr": _step("+"),
    "decr": _step("-"),
    "add": _add,
    "clear": _clear,
    "bitset": _bit(True),
    "bitclear": _bit(False),
    "waittestandset": _taken,
    "tpwrite": _message,
    "errwrite": _log,
    "stop": _pause,
    "break": _pause,
    "accset": _acceleration,
    "velset": _override,
    "triggio": _trigger,
    "triggequip": _trigger,
    "pdispset": _shift_set,
    "pdispon": _shift_on,
    "pdispoff": _shift_off,
}
