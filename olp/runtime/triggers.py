"""Outputs that RAPID's TriggL, TriggJ and TriggC switch on the way, as TriggIO or TriggEquip has said before.

A trigger is data: what it switches, to what, and how far from the end of the move, or from its start (\\Start), it acts
(ABB, technical reference manual, TriggIO). A plan has steps and no places within them: what acts near the start is a
step before the move, everything else one behind it.
"""

from __future__ import annotations

from typing import Final

from olp.ir.expressions import Named, Number, Signal, SignalState, Text
from olp.ir.program import Move, Process, SetOutput
from olp.runtime.evaluate import evaluate
from olp.runtime.memory import Record, Value
from olp.runtime.scope import find_slot, write_name
from olp.runtime.state import Machine

DEFINED: Final = "triggdata"  # the type of a trigger, and the argument of a process instruction that names it
_PREFIX: Final = "trigg"
_AT_START: Final = "start"


def define(m: Machine, s: Process) -> bool:
    """Keeps what a TriggIO or TriggEquip says in its variable; False for any other instruction."""
    given = dict(s.arguments)
    name, signal = given.get(DEFINED), given.get("signal")
    if not isinstance(name, Named) or not isinstance(signal, Signal) or not isinstance(signal.index, Text):
        return False
    members: dict[str, Value] = {
        "bus": signal.bus,
        "signal": signal.index.value,
        "value": evaluate(m, given["value"]),
        _AT_START: given[_AT_START] == SignalState(True),
    }
    write_name(m, name.name, Record(DEFINED, members))
    return True


def outputs_of(m: Machine, s: Move, at_start: bool) -> list[SetOutput]:
    """What a move's triggers switch near its start, or near its end, in the order in which they are named."""
    if not s.other or not s.other[0][0].casefold().startswith(_PREFIX):
        return []
    found = []
    for _, value in s.other[1:]:
        slot = find_slot(m, value.name) if isinstance(value, Named) else None
        trigger = None if slot is None else slot.value
        if (
            not isinstance(trigger, Record)
            or trigger.type != DEFINED
            or trigger.members[_AT_START] != at_start
        ):
            continue
        signal = Signal(str(trigger.members["bus"]), Text(str(trigger.members["signal"])))
        set_to = trigger.members["value"]
        if not isinstance(set_to, (bool, int, float)):
            continue
        state = SignalState(set_to) if isinstance(set_to, bool) else Number(set_to)
        found.append(SetOutput(s.line, signal, state))
    if found:
        m.assume_once(DEFINED, "outputs that switch on the way of a move are shown at the nearer of its ends")
    return found
