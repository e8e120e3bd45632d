"""Control flow: labels, jumps, blocks, calls and returns."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from olp.core.diagnostic import Severity
from olp.ir import program as st
from olp.ir.expressions import (
    CallValue,
    Expression,
    Function,
    Named,
    Store,
    SystemValue,
    Unary,
    Variable,
)
from olp.ir.transformer import calls_nothing, expressions_of
from olp.runtime.assumptions import SignalKey, signal_name
from olp.runtime.evaluate import bind, evaluate, fold, holds, number, whole, write_name, write_variable
from olp.runtime.jobs import Jobs, Read, Region, RunnableRoutine, influences, is_literal, reads_of, region
from olp.runtime.memory import RANGES, Array, Changes, Record, Slot, Value
from olp.runtime.plan import CallSpan, Event
from olp.runtime.signals import counted, expected_wait, flip, key_of, signals_of
from olp.runtime.spelling import spell
from olp.runtime.state import (
    OTHER_FRAME,
    CallFrame,
    EndedError,
    Held,
    Loop,
    LoopEntry,
    Machine,
    StatementError,
)

_NESTED = 30  # calls within expressions of routines so called: each is a level of Python's own stack
_DEPTH = 100  # calls within calls; controllers allow about a dozen


def test(m: Machine, condition: Expression) -> bool:
    """Whether a condition holds; one that cannot be evaluated is reported and does not."""
    try:
        return holds(m, condition)
    except StatementError as fault:
        m.fault(fault)
        return False


def label(m: Machine, s: st.Label) -> None:
    enter_loop(m, m.frame.pc - 1)


def jump(m: Machine, s: st.Jump) -> int | None:
    if s.condition is not None and not test(m, s.condition):
        return None
    name = s.target if isinstance(s.target, str) else _label_name(evaluate(m, s.target))
    labels = m.frame.job.flow.labels
    target = labels.get(name)
    if target is None:
        known = ", ".join(list(labels)[:8]) or "none"
        raise StatementError(
            "I104", f"there is no label {name[:40]} to jump to", f"labels of this routine: {known}"
        )
    here = m.frame.pc - 1
    return way_back(m, target, here, s.condition) if target <= here else target


def _label_name(value: Value) -> str:
    if isinstance(value, float) and float(value).is_integer():
        value = int(value)
    return str(int(value)) if isinstance(value, bool) else str(value)


def if_(m: Machine, s: st.If) -> int | None:
    if test(m, s.condition):
        return None
    return _next_branch(m, m.frame.pc - 1)


def _next_branch(m: Machine, marker: int) -> int | None:
    """The first statement of the branch that is taken after a condition at `marker` did not hold."""
    body, flow = m.frame.job.body, m.frame.job.flow
    following = flow.after.get(marker)
    while following is not None and following < len(body):
        branch = body[following]
        if not isinstance(branch, st.ElseIf):
            return following + 1
        m.frame.pc = following + 1
        if test(m, branch.condition):
            return following + 1
        following = flow.after.get(following)
    return following


def end_of_branch(m: Machine, s: st.ElseIf | st.Else | st.Case | st.Default) -> int | None:
    """Reached from the branch above: that one is done, and so is the whole block."""
    end = m.frame.job.flow.end.get(m.frame.pc - 1)
    return None if end is None else end + 1


def while_(m: Machine, s: st.While) -> int | None:
    here = m.frame.pc - 1
    enter_loop(m, here)
    if test(m, s.condition):
        return None
    end = m.frame.job.flow.end.get(here)
    return None if end is None else end + 1


def end_while(m: Machine, s: st.EndWhile) -> int | None:
    here = m.frame.pc - 1
    opener = m.frame.job.flow.opener.get(here)
    if opener is None:
        return None
    head = m.frame.job.body[opener]
    assert isinstance(head, st.While)
    return way_back(m, opener, here, head.condition) if test(m, head.condition) else None


def repeat(m: Machine, s: st.Repeat) -> None:
    enter_loop(m, m.frame.pc - 1)


def until(m: Machine, s: st.Until) -> int | None:
    here = m.frame.pc - 1
    opener = m.frame.job.flow.opener.get(here)
    if opener is None or test(m, s.condition):
        return None
    return way_back(m, opener, here, Unary("not", s.condition))


def break_(m: Machine, s: st.Break) -> int | None:
    flow = m.frame.job.flow
    opener = flow.loop.get(m.frame.pc - 1)
    if opener is None:
        return None
    m.frame.counters.pop(opener, None)
    return flow.end[opener] + 1


def continue_(m: Machine, s: st.Continue) -> int | None:
    flow = m.frame.job.flow
    opener = flow.loop.get(m.frame.pc - 1)
    return None if opener is None else flow.end[opener]


def for_(m: Machine, s: st.For) -> int | None:
    here = m.frame.pc - 1
    if not isinstance(s.variable, (Variable, Named)):  # a name that nothing defines
        raise StatementError(
            "I209", f"{spell(s.variable)} cannot count", "use a byte, integer or double variable"
        )
    start, stop = number(m, s.start), number(m, s.stop)
    usual = -1 if m.conventions.for_turns and stop < start else 1
    step = usual if s.step is None else number(m, s.step)
    if step == 0:
        raise StatementError("I105", "a FOR loop with step 0 has no end", "give a step other than 0")
    hidden = _hide(m, here, s.variable)
    _count(m, s.variable, start)
    m.frame.counters[here] = (stop, step, hidden)
    if _beyond(start, stop, step):
        _show(m, here, s.variable)
        end = m.frame.job.flow.end.get(here)
        return None if end is None else end + 1
    return None


def next_(m: Machine, s: st.Next) -> int | None:
    opener = m.frame.job.flow.opener.get(m.frame.pc - 1)
    counter = None if opener is None else m.frame.counters.get(opener)
    if opener is None or counter is None:
        return None  # reached by a jump past the loop's head: nothing is counted
    head = m.frame.job.body[opener]
    assert isinstance(head, st.For)
    stop, step, _ = counter
    following = number(m, head.variable) + step
    if m.conventions.for_keeps_last and _beyond(following, stop, step):
        _show(m, opener, head.variable)
        return None
    if _fits(head.variable, following):
        _count(m, head.variable, following)
        if not _beyond(following, stop, step):
            return opener + 1
    _show(m, opener, head.variable)
    return None


def _hide(m: Machine, here: int, variable: Variable | Named) -> Slot | None:
    """Where FOR declares its counter: that counter instead of a variable of the same name, which is returned."""
    if not (m.conventions.for_declares and isinstance(variable, Named)):
        return None
    names, key, left = m.frame.names, fold(m, variable.name), m.frame.counters.get(here)
    hidden = names.get(key) if left is None else left[2]  # left by a jump: it is hidden still
    names[key] = Slot(None)
    return hidden


def _show(m: Machine, here: int, variable: Variable | Named) -> None:
    """Ends a loop: what its counter hid is there again."""
    _, _, hidden = m.frame.counters.pop(here)
    if not (m.conventions.for_declares and isinstance(variable, Named)):
        return
    if hidden is None:
        del m.frame.names[fold(m, variable.name)]
    else:
        m.frame.names[fold(m, variable.name)] = hidden


def _beyond(value: float, stop: float, step: float) -> bool:
    return value > stop if step > 0 else value < stop


def _count(m: Machine, variable: Variable | Named, value: float) -> None:
    if isinstance(variable, Variable):
        write_variable(m, variable, value)
        return
    write_name(m, variable.name, value)


def _fits(variable: Variable | Named, value: float) -> bool:
    if isinstance(variable, Named):
        return True
    low, high = RANGES.get(variable.store, (-float("inf"), float("inf")))
    return low <= value <= high


def switch(m: Machine, s: st.Switch) -> int | None:
    here, body, flow = m.frame.pc - 1, m.frame.job.body, m.frame.job.flow
    value = evaluate(m, s.value)
    default = None
    marker = flow.after.get(here)
    while marker is not None and marker < len(body):
        branch = body[marker]
        if isinstance(branch, st.Case):
            m.frame.pc = marker + 1
            if any(evaluate(m, case) == value for case in branch.values):
                return marker + 1
        elif isinstance(branch, st.Default):
            default = marker + 1
        else:
            break
        marker = flow.after.get(marker)
    return default if default is not None else (None if marker is None else marker + 1)


def call(m: Machine, s: st.Call) -> int | None:
    if s.condition is not None and not test(m, s.condition):
        return None
    name = _routine_name(m, s)
    if s.spelling == "macro" and m.jobs.find(name, m.frame.job.source) is None:
        m.assume(f"the macro {name} takes no time and changes nothing")
        m.recorder.signal(m.frame.job.source, s.line)
        return None
    job = m.jobs.find(name, m.frame.job.source)
    if job is None and _is_passed_over(m, name, s):
        return None
    if job is None:
        job = _found(m, name, ": its call is left out")
    frame = _new_frame(m, job, s.arguments)
    frame.result = s.result
    if s.jump:
        if _again(m, job.key, name):
            return None
        m.frame = frame
        return OTHER_FRAME
    _check_depth(m)
    if not m.frames:
        m.spans.append(CallSpan(s.line, len(m.recorder), len(m.recorder)))
    m.frames.append(m.frame)
    m.frame = frame
    return OTHER_FRAME


def _is_passed_over(m: Machine, name: str, s: st.Call) -> bool:
    """Whether a routine that is not here takes a time that is known, or none as what the controller brings with it."""
    seconds = m.assumptions.routines.get(name.casefold())
    what = m.known_routines.get(name.casefold())
    if seconds is None and (what is None or "routines" in m.assumptions.strict):
        return False
    if seconds is None:
        m.assume_once(
            f"routine {name.casefold()}", f"{name}, {what}, takes no time here: [known-routines] may say one"
        )
    m.recorder.wait(m.frame.job.source, s.line, seconds or 0.0)
    return True


def _found(m: Machine, name: str, then: str = "") -> RunnableRoutine:
    job = m.jobs.find(name, m.frame.job.source)
    if job is not None:
        return job
    what = m.known_routines.get(name.casefold())
    if what is not None:
        raise StatementError("I102", f"{name[:60]}, {what}, is not modelled{then}")
    near = m.jobs.near(name)
    did = f"did you mean {', '.join(near)}? Else " if near else ""
    raise StatementError(
        "I102",
        f"the routine {name[:60]} was not found{then}",
        f"{did}put its file into the same folder",
    )


def _new_frame(m: Machine, job: RunnableRoutine, arguments: tuple[Expression, ...]) -> CallFrame:
    if not job.routine.parameters:
        values = tuple(evaluate(m, argument) for argument in arguments)
        m.load(job)
        return CallFrame(job, values)
    m.load(job)
    names, outs, lent = bind(m, job.routine.parameters, arguments)
    return CallFrame(job, names=names, outs=outs, lent=lent)


def _check_depth(m: Machine) -> None:
    if len(m.frames) >= _DEPTH:
        m.stop(f"calls go more than {_DEPTH} deep")
        raise StatementError(
            "I106", f"calls go more than {_DEPTH} deep: the run ends here", "the routine calls itself"
        )


def value_of_call(m: Machine, e: CallValue) -> Value:
    """Runs a routine inside an expression, to its return."""
    answer = m.conventions.answers.get(e.routine.casefold())
    if answer is not None and m.jobs.find(e.routine, m.frame.job.source) is None:
        m.assume(f"{e.routine} is taken to be {'on' if answer[0] else 'off'}")
        return answer[0]
    frame = _new_frame(m, _found(m, e.routine), e.arguments)
    _check_depth(m)
    if m.nested >= _NESTED:
        m.stop(f"calls within expressions go more than {_NESTED} deep")
        raise StatementError(
            "I106", f"calls within expressions go more than {_NESTED} deep: the run ends here"
        )
    depth, caller = len(m.frames), m.frame
    m.frames.append(caller)
    m.frame = frame
    m.returned = None
    m.nested += 1
    m.operations.run_until(m, depth)
    m.nested -= 1
    returned: Value | None = m.returned
    if returned is None and m.stop_reason:
        raise EndedError
    if returned is None:
        raise StatementError("I225", f"{e.routine} returns no value", "end it with a return of one")
    return returned


def _routine_name(m: Machine, s: st.Call) -> str:
    if s.macro is None:
        return s.routine
    macro = whole(m, s.macro)
    macros = m.world.backup.macros if m.world.backup is not None else {}
    if macro not in macros:
        raise StatementError(
            "I107",
            f"macro {macro} is not defined: its call is left out",
            "put MACRO.DAT beside the job",
            Severity.WARNING,
        )
    return macros[macro]


def _again(m: Machine, key: int, name: str) -> bool:
    """Whether a chain of jumps between routines has come round often enough. Stops the run then."""
    times = m.jumped.get(key, 1 if key == m.first_job else 0)
    m.jumped[key] = times + 1
    if times < m.cycles:
        return False
    m.assume(
        f"the routines jump in a circle: stopped after {m.cycles} {'cycle' if m.cycles == 1 else 'cycles'}"
    )
    m.stop(f"one cycle ends where line {m.line} jumps to {name} again")
    return True


def return_(m: Machine, s: st.Return) -> int | None:
    if s.condition is not None and not test(m, s.condition):
        return None
    if s.value is not None:
        m.returned = evaluate(m, s.value)
    leave(m)
    return OTHER_FRAME


def end(m: Machine, _: st.Statement) -> int:
    leave(m)
    return OTHER_FRAME


def leave(m: Machine) -> None:
    """Goes back to the caller; without one the program has ended."""
    if not m.frames:
        m.ended = True
        return
    done = m.frame
    m.frame = m.frames.pop()
    if done.outs or done.result is not None:
        _hand_back(m, done)
    if not m.frames and m.spans:
        m.spans[-1] = m.spans[-1]._replace(stop=len(m.recorder))


def _hand_back(m: Machine, done: CallFrame) -> None:
    """Stores what a routine returned or changed in its parameters where the caller wants it."""
    from olp.runtime.data import store_value

    for key, target in done.outs:
        value = done.names[key].value
        if value is not None:
            store_value(m, target, value)
    if done.result is not None and m.returned is not None:
        store_value(m, done.result, m.returned)


# --- Loops ---
# Loops without an end: where one cycle is enough, and inputs that a loop waits for.
#
# A way back to an earlier statement is free while something that decides about the loop changes. When nothing does, it
# would turn for ever: a loop that moves is the program's main loop and ends after the wanted number of cycles; one that
# waits ends because the input that it reads is taken to change.

# A loop that counts while it polls an input ends when its count does; nobody polls longer than this.
_PATIENCE = 20_000
_COMPARED = 100  # items of an array that are compared with those of the pass before
_NOTHING = LoopEntry(0, 0, 0, 0)


def enter_loop(m: Machine, index: int) -> None:
    """Notes what had happened when the head of a possible loop was reached from outside."""
    m.entries += 1
    m.frame.entered[index] = LoopEntry(
        m.memory.stamp, m.moves, m.reads, m.entries, _held(m, index), len(m.recorder)
    )


def way_back(m: Machine, first: int, last: int, condition: Expression | None) -> int:
    """The statement to go on with at `last`, which leads back to `first` where `condition` holds."""
    entry = m.frame.entered.get(first, _NOTHING)
    held = _held(m, first)
    m.frame.entered[first] = LoopEntry(m.memory.stamp, m.moves, m.reads, entry.number, held, len(m.recorder))
    loop = _loop(m, last, entry)
    loop.passes += 1
    about = _region(m, first, last)
    moved = m.moves > entry.moves
    # A main loop that stands still goes on with another input, whether it is spelt as a loop or as a jump.
    conditional = condition is not None or bool(about.exits) or not moved
    loop.past.append(entry)
    loop.held.append(entry.held)
    begun = None if moved else _same_before(m, loop, held)
    if begun is not None:
        entry = begun
    elif conditional and _changed(m, about, entry, held):
        loop.idle = 0 if moved else loop.idle + 1
        if loop.idle <= _PATIENCE or not _candidates(m, loop, entry):
            return first + 1
    elif moved and loop.passes < m.cycles and not (m.frames and conditional):
        return first + 1
    following = _ended_by_input(m, first, last, condition, about, entry) if conditional else None
    if following is None and conditional and (not moved or _is_retry(m, last, condition)):
        following = _ended_from_outside(m, first, last, condition, about, entry if moved else None)
    if following is not None:
        return following
    _stop(m, first, last, moved)
    return last + 1


def _same_before(m: Machine, loop: Loop, held: Held) -> LoopEntry | None:
    """The head of an earlier pass, without a move since, when all held what it holds now: the same comes again."""
    if not held or held not in loop.held:  # as in nearly all passes
        return None
    past = next(past for past in reversed(loop.past) if past.held == held)
    return past if past.moves == m.moves and past.stamp >= m.listed else None


def _loop(m: Machine, last: int, entry: LoopEntry) -> Loop:
    loop = m.frame.loops.get(last)
    if loop is None or loop.entry != entry.number:
        loop = m.frame.loops[last] = Loop(entry.number)
    return loop


def _region(m: Machine, first: int, last: int) -> Region:
    job = m.frame.job
    known = job.regions.get((first, last))
    if known is None:
        known = job.regions[(first, last)] = region(job.body, job.flow, first, last)
    return known


def _lines(m: Machine, first: int, last: int) -> str:
    body = m.frame.job.body
    return f"the loop from line {body[first].line} to line {body[last].line}"


def _ended_by_input(
    m: Machine, first: int, last: int, condition: Expression | None, about: Region, entry: LoopEntry
) -> int | None:
    """Turns over the input that ends the loop; None when no input does.

    Where none does alone, the one that was read last is turned over, and the loop asks again.
    """
    loop = m.frame.loops[last]
    moved = m.moves > entry.moves
    candidates = _candidates(m, loop, entry)
    for key in candidates:
        before = m.memory.signals.get(key)
        says = flip(m, key)
        way_out = _way_out(m, condition, about, first, last)
        if way_out is not None:
            break
        _restore(m, key, before)  # a main loop goes on with this input as well
    else:
        if not candidates or (moved and not m.frames):
            return None
        key, way_out = candidates[0], None
        says = flip(m, key)
    if m.made_up is not None:
        m.made_up.turn(key)
        if any(map(_asks_clock, m.frame.job.body[first : last + 1])):
            m.made_up.timed.add(key)
    m.assume(f"{says}, which ends {_lines(m, first, last)}")
    if not moved and not loop.flipped:
        _wait(m, last if way_out is None else way_out.asks, _asked(m, about, entry))
    loop.flipped.add(key)
    return first + 1 if way_out is None else way_out.to


def _asks_clock(s: st.Statement) -> bool:
    return not calls_nothing(s) and any(
        isinstance(e, (SystemValue, Function)) and e.name == "timer" for e in expressions_of(s)
    )


def ends_in_time(m: Machine, s: st.Wait) -> bool:
    """Whether a wait with a limit ends before it, as the loop of the source did that asked a clock: its input comes."""
    for key in () if m.made_up is None else (key_of(m, signal) for signal in signals_of(s.condition)):
        if m.made_up is not None and key in m.made_up.timed:
            before = m.memory.signals.get(key)
            flip(m, key)
            if test(m, s.condition):
                m.made_up.turn(key)
                return True
            _restore(m, key, before)
    return False


def _wait(m: Machine, asks: int, keys: Sequence[SignalKey]) -> None:
    """A loop that asks until a signal comes is a wait for it, at the statement that asks."""
    seconds = expected_wait(m, keys)
    opener = m.frame.job.flow.opener.get(asks)
    line = m.frame.job.body[asks if opener is None else opener].line
    names = tuple(sorted({signal_name(key) for key in keys}))
    m.recorder.wait(m.frame.job.source, line, seconds, Event("wait", names, math.nan))


def _asked(m: Machine, about: Region, entry: LoopEntry) -> list[SignalKey]:
    """The signals that decide about a loop, and those that its last pass read; a part of a condition may be unread."""
    decide = [
        counted(m, kind, index)
        for kind, index, _ in about.reads
        if index is not None and not isinstance(kind, Store) and not kind.startswith("name:")
    ]
    return list(
        dict.fromkeys((*sorted(decide), *(k for k, when in m.inputs_read.items() if when > entry.reads)))
    )


def _forget(m: Machine, steps: int) -> None:
    m.recorder.cut(steps)
    m.spans[:] = [span._replace(stop=min(span.stop, steps)) for span in m.spans if span.start < steps]


def _restore(m: Machine, key: SignalKey, before: int | None) -> None:
    if before is None:
        del m.memory.signals[key]
    else:
        m.memory.signals[key] = before


def _is_retry(m: Machine, last: int, condition: Expression | None) -> bool:
    """Whether a loop that moves is tried again, and no main loop: it is in a called routine, or asks at its end.

    A loop that asks signals alone is held by them: what olp.toml says of them is so.
    """
    asks_at_end = condition is not None and isinstance(m.frame.job.body[last], (st.Jump, st.Until))
    if condition is not None and not any(
        isinstance(kind, Store) or kind.startswith("name:") for kind, _, _ in reads_of(condition)
    ):
        return False
    return asks_at_end or bool(m.frames)


def _ended_from_outside(
    m: Machine,
    first: int,
    last: int,
    condition: Expression | None,
    about: Region,
    moved: LoopEntry | None,
) -> int | None:
    """A loop held by a variable which nobody here changes: somebody else does. None without such an exit.

    `moved`: the head of the last pass, where that moved.
    """
    exit = _exit_from_outside(m, condition, about, first, last)
    if exit is not None and moved is not None:
        if m.frame.loops[last].passes > m.cycles:  # it began with other values, and is now as one pass before
            _forget(m, moved.steps)
        why = "" if condition is None else f" while {spell(condition)}"
        m.assume(f"{_lines(m, first, last)} repeats{why}, which nothing here changes: one pass is timed")
    elif exit is not None and not m.seeks_move:
        m.assume(f"{_lines(m, first, last)} waits for something outside: taken to come at once")
    return None if exit is None else _taken(m, exit)


def _exit_from_outside(
    m: Machine, condition: Expression | None, about: Region, first: int, last: int
) -> WayOut | None:
    """How the loop is left once somebody else changes a variable."""
    if condition is not None and not is_literal(condition):
        return WayOut(last, last + 1)
    body, flow = m.frame.job.body, m.frame.job.flow
    for index in about.exits:
        s = body[index]
        if isinstance(s, st.If):  # the way back stands in its branch
            asks, to = s.condition, flow.after[index] + 1
        elif isinstance(s, (st.Jump, st.Return)) and s.condition is not None:
            asks, to = (None if _leads_nowhere(m, s) else s.condition), index
        else:
            around = [
                at for at in range(first + 1, index) if flow.opener.get(at) == at < index < flow.end[at]
            ]
            opener = body[around[0]] if len(around) == 1 else None
            inside = isinstance(opener, st.If) and index < flow.after[around[0]]
            asks, to = (opener.condition, around[0] + 1) if inside else (None, index)
        if asks is not None and any(reads_of(asks)):
            return WayOut(index, to)
    return None


def _leads_nowhere(m: Machine, s: st.Jump | st.Return) -> bool:
    """Whether a jump names a label that does not exist."""
    return isinstance(s, st.Jump) and isinstance(s.target, str) and s.target not in m.frame.job.flow.labels


def _taken(m: Machine, exit: WayOut) -> int:
    """Where a loop goes on that is left although the condition for it does not hold."""
    statement = m.frame.job.body[exit.asks]
    if exit.to != exit.asks:
        return exit.to
    if not isinstance(statement, st.Return):
        return _target(m, exit.to)
    m.frame.pc = exit.to + 1
    return_(m, replace(statement, condition=None))
    return OTHER_FRAME


def _stop(m: Machine, first: int, last: int, moved: bool) -> None:
    cycles = f"{m.cycles} cycle{'' if m.cycles == 1 else 's'}" if moved else "one pass without a move"
    says = f"{_lines(m, first, last)} has no end: stopped after {cycles}"
    if moved:
        m.assume(says)
    else:
        help = "give it an exit, or say in olp.toml the values that it asks for"
        m.fault(StatementError("I109", says, help, Severity.WARNING))
    m.stop(says)


def _candidates(m: Machine, loop: Loop, entry: LoopEntry) -> list[SignalKey]:
    """Inputs that were read in the last pass and not yet turned over, the last one first: it is nearest to the end.

    Where another program of the same meaning ran before, that comes first which ended its loop.
    """
    read = [
        (when, key)
        for key, when in m.inputs_read.items()
        if when > entry.reads and key not in loop.flipped and (key.bus, key.number) not in m.memory.changed
    ]
    last_first = [key for _, key in sorted(read, reverse=True)]
    return last_first if m.made_up is None else m.made_up.first_turned(last_first)


def _way_out(m: Machine, condition: Expression | None, about: Region, first: int, last: int) -> WayOut | None:
    """How the loop is left with the inputs as they are now, None when it is not."""
    if condition is not None and not _holds(m, condition):
        return WayOut(last, last + 1)
    for index in about.exits:
        statement = m.frame.job.body[index]
        if isinstance(statement, st.If) and not _holds(m, statement.condition):
            return WayOut(index, index)
        condition = statement.condition if isinstance(statement, (st.Jump, st.Return)) else None
        if condition is not None and _holds(m, condition):
            return WayOut(index, _target(m, index))
        branch = _taken_branch(m, first, index) if condition is None else None
        if branch is not None:
            return WayOut(branch, branch)
    return None


class WayOut(NamedTuple):
    """How a loop is left: the statement that asks, and the one to go on with."""

    asks: int
    to: int


def _taken_branch(m: Machine, first: int, index: int) -> int | None:
    """The outermost IF around a statement that leaves without a condition, where its branches are those taken now."""
    flow, body = m.frame.job.flow, m.frame.job.body
    around = [at for at in range(first + 1, index) if flow.opener.get(at) == at and index < flow.end[at]]
    if all(isinstance(body[at], st.If) and _branch_now(m, at, index) for at in around):
        return around[0] if around else None
    return None


def _branch_now(m: Machine, opener: int, index: int) -> bool:
    """Whether the branch of an IF that holds a statement is taken with the inputs as they are now."""
    flow, body, marker = m.frame.job.flow, m.frame.job.body, opener
    while (following := flow.after.get(marker)) is not None:
        branch = body[marker]
        taken = not isinstance(branch, (st.If, st.ElseIf)) or _holds(m, branch.condition)
        if index < following:
            return taken
        if taken:
            return False
        marker = following
    return False


def _target(m: Machine, index: int) -> int:
    """Where a leaving statement leads to: the label of a plain jump, else the statement itself, which then runs."""
    statement = m.frame.job.body[index]
    if isinstance(statement, st.Jump) and isinstance(statement.target, str):
        return m.frame.job.flow.labels.get(statement.target, index)
    return index


def _holds(m: Machine, condition: Expression) -> bool:
    try:
        return holds(m, condition)
    except StatementError:
        return False


def _changed(m: Machine, about: Region, entry: LoopEntry, held: Held) -> bool:
    """Whether anything that decides about the loop is another than at its head."""
    if m.listed > entry.stamp:
        return True  # a list of inputs from olp.toml goes on
    return _touched(m, about, entry) and (not entry.held or entry.held != held)


def _touched(m: Machine, about: Region, entry: LoopEntry) -> bool:
    """Whether something that decides was given another value since the head, whatever it holds now."""
    for kind, index, local in about.reads:
        if isinstance(kind, Store) or not kind.startswith("name:"):
            if _is_later(m.frame.changed if local else m.memory.changed, kind, index, entry.stamp):
                return True
        elif any(
            _is_later(changed, kind, place, entry.stamp)
            for changed in (m.frame.changed, m.memory.changed)
            for place in about.elements.get(kind, (index,))
        ):
            return True
    return False


def _is_later(changed: Changes, kind: str, index: int | None, stamp: int) -> bool:
    """Whether something was changed behind `stamp`; index None: any of its kind."""
    if index is None:
        return any(known == kind and when > stamp for (known, _), when in changed.items())
    return changed.get((kind, index), 0) > stamp


def _held(m: Machine, head: int) -> Held:
    """What everything holds that decides about the loops with this head."""
    job = m.frame.job
    deciding = job.deciding.get(head)
    if deciding is None:
        deciding = job.deciding[head] = tuple(sorted(_deciding(m, head), key=repr))
    return tuple([(read, _frozen(_value(m, *read))) for read in deciding])


def _deciding(m: Machine, head: int) -> frozenset[Read]:
    job = m.frame.job
    ends = list(_ways_back(m, head))
    reads = frozenset(read for last in ends for read in _region(m, head, last).reads)
    if not reads:
        return reads
    own = job.body[head : max(ends) + 1]
    return influences((own, *called_bodies(m.jobs, job, own)), reads)


def _ways_back(m: Machine, head: int) -> Iterator[int]:
    body, flow = m.frame.job.body, m.frame.job.flow
    for index in range(head + 1, len(body)):
        s = body[index]
        if isinstance(s, st.Jump):
            if isinstance(s.target, str) and flow.labels.get(s.target) == head:
                yield index
        elif isinstance(s, (st.EndWhile, st.Until)) and flow.opener.get(index) == head:
            yield index


def called_bodies(
    jobs: Jobs, job: RunnableRoutine, body: Sequence[st.Statement] | None = None
) -> Iterator[tuple[st.Statement, ...]]:
    """The routines that run under statements of `job` (None: all of them), each once."""
    known, waiting = {job.key}, [(job.body if body is None else body, job.source)]
    while waiting:
        statements, source = waiting.pop()
        for s in statements:
            if calls_nothing(s):
                continue
            called = [e.routine for e in expressions_of(s) if isinstance(e, CallValue)]
            if isinstance(s, st.Call) and s.macro is None:
                called.append(s.routine)
            for name in called:
                found = jobs.find(name, source)
                if found is not None and found.key not in known:
                    known.add(found.key)
                    waiting.append((found.body, found.source))
                    yield found.body


def _value(m: Machine, kind: str, index: int | None, local: bool) -> object:
    """What is held now; something that equals nothing where that cannot be said."""
    if index is None:
        return object()
    if isinstance(kind, Store):
        return (m.frame.locals if local else m.memory.values).get((kind, index))
    if not kind.startswith("name:"):
        key = counted(m, kind, index)
        signal = m.memory.signals.get(key)
        return None if signal == m.signals_made_up.get(key) else signal  # until it is read nobody knows it
    name, job = kind.removeprefix("name:"), m.frame.job
    for scope in (m.frame.names, job.data, m.modules.get(job.source, {}), *m.modules.values()):
        if name in scope:
            return scope[name].value
    return object() if m.case_sensitive else None


def _frozen(value: object) -> object:
    if isinstance(value, Array):
        return tuple(map(_frozen, value.items)) if len(value.items) <= _COMPARED else object()
    if isinstance(value, Record):
        return tuple((name, _frozen(item)) for name, item in value.members.items())
    return value
