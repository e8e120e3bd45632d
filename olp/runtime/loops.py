"""Loops without an end: where one cycle is enough, and inputs that a loop waits for.

A way back to an earlier statement is free while something that decides about the loop changes. When nothing does, it
would turn for ever: a loop that moves is the program's main loop and ends after the wanted number of cycles; one that
waits ends because the input that it reads is taken to change.
"""

from __future__ import annotations

from olp.ir.expressions import Expression
from olp.ir.program import If, Jump, Return
from olp.runtime.assumptions import SignalKey
from olp.runtime.evaluate import holds
from olp.runtime.regions import Region, region
from olp.runtime.signals import flip
from olp.runtime.state import Loop, LoopEntry, Machine, StatementError

# A loop that counts while it polls an input ends when its count does; nobody polls longer than this.
_PATIENCE = 20_000
_NOTHING = LoopEntry(0, 0, 0, 0)


def enter_loop(m: Machine, index: int) -> None:
    """Notes what had happened when the head of a possible loop was reached from outside."""
    m.entries += 1
    m.frame.entered[index] = LoopEntry(m.memory.stamp, m.moves, m.reads, m.entries)


def way_back(m: Machine, first: int, last: int, condition: Expression | None) -> int:
    """The statement to go on with at `last`, which leads back to `first` where `condition` holds."""
    entry = m.frame.entered.get(first, _NOTHING)
    m.frame.entered[first] = LoopEntry(m.memory.stamp, m.moves, m.reads, entry.number)
    loop = _loop(m, last, entry)
    loop.passes += 1
    about = _region(m, first, last)
    moved = m.moves > entry.moves
    conditional = condition is not None or bool(about.exits)
    if conditional and _changed(m, about, entry):
        loop.idle = 0 if moved else loop.idle + 1
        if loop.idle <= _PATIENCE or not _candidates(m, loop, entry):
            return first + 1
    elif moved and loop.passes < m.cycles and not (m.frames and conditional):
        return first + 1
    following = _ended_by_input(m, first, last, condition, about, entry) if conditional else None
    if following is None and conditional and not moved:
        following = _ended_from_outside(m, first, last, condition, about)
    if following is not None:
        return following
    _stop(m, first, last, moved)
    return last + 1


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
    """Turns over the input that ends the loop; None when no input does."""
    loop = m.frame.loops[last]
    moved = m.moves > entry.moves
    for key in _candidates(m, loop, entry):
        before = m.memory.signals.get(key)
        says = flip(m, key)
        way_out = _way_out(m, condition, about, last)
        if way_out is None and moved and not m.frames:
            _restore(m, key, before)  # the main loop goes on with this input as well
            continue
        loop.flipped.add(key)
        m.assume(f"{says}, which ends {_lines(m, first, last)}")
        return first + 1 if way_out is None else way_out
    return None


def _restore(m: Machine, key: SignalKey, before: int | None) -> None:
    if before is None:
        del m.memory.signals[key]
    else:
        m.memory.signals[key] = before


def _ended_from_outside(
    m: Machine, first: int, last: int, condition: Expression | None, about: Region
) -> int | None:
    """A loop that waits for a variable which nobody here changes: somebody else does. None without such an exit."""
    following = last + 1 if condition is not None else None
    for index in about.exits:
        statement = m.frame.job.body[index]
        if following is None and isinstance(statement, (Jump, Return)) and statement.condition is not None:
            following = _target(m, index)
    if following is not None:
        m.assume(f"{_lines(m, first, last)} waits for something outside: taken to come at once")
    return following


def _stop(m: Machine, first: int, last: int, moved: bool) -> None:
    cycles = f"{m.cycles} cycle{'' if m.cycles == 1 else 's'}" if moved else "one pass without a move"
    says = f"{_lines(m, first, last)} has no end: stopped after {cycles}"
    m.assume(says)
    m.stop(says)


def _candidates(m: Machine, loop: Loop, entry: LoopEntry) -> list[SignalKey]:
    """Inputs that were read in the last pass and not yet turned over, the last one first: it is nearest to the end."""
    read = [
        (when, key)
        for key, when in m.inputs_read.items()
        if when > entry.reads and key not in loop.flipped and (key.bus, key.number) not in m.memory.changed
    ]
    return [key for _, key in sorted(read, reverse=True)]


def _way_out(m: Machine, condition: Expression | None, about: Region, last: int) -> int | None:
    """Where the loop is left with the inputs as they are now, None when it is not."""
    if condition is not None and not _holds(m, condition):
        return last + 1
    for index in about.exits:
        statement = m.frame.job.body[index]
        if isinstance(statement, If) and not _holds(m, statement.condition):
            return index
        condition = statement.condition if isinstance(statement, (Jump, Return)) else None
        if condition is not None and _holds(m, condition):
            return _target(m, index)
    return None


def _target(m: Machine, index: int) -> int:
    """Where a leaving statement leads to: the label of a plain jump, else the statement itself, which then runs."""
    statement = m.frame.job.body[index]
    if isinstance(statement, Jump) and isinstance(statement.target, str):
        return m.frame.job.flow.labels.get(statement.target, index)
    return index


def _holds(m: Machine, condition: Expression) -> bool:
    try:
        return holds(m, condition)
    except StatementError:
        return False


def _changed(m: Machine, about: Region, entry: LoopEntry) -> bool:
    """Whether anything that decides about the loop was changed since its head."""
    if m.listed > entry.stamp:
        return True  # a list of inputs from olp.toml goes on
    changed = m.memory.changed
    for kind, index, local in about.reads:
        if index is None:
            if any(known == kind and stamp > entry.stamp for (known, _), stamp in changed.items()):
                return True
        elif changed.get((kind, -1 - index if local else index), 0) > entry.stamp:
            return True
    return False
