"""Speeds that a table of the controller holds (FANUC's WELD_SPEED): a variable that its operator sets."""

from __future__ import annotations

import re
from dataclasses import replace

from olp.ir import terminology
from olp.ir.expressions import Named, SystemValue
from olp.ir.program import Declare, Move, Program, StartTask, Statement, WaitTask
from olp.ir.transformer import edited
from olp.transpile.context import Fate, TranslationContext


def schedules(program: Program, work: TranslationContext) -> Program:
    """Every speed that only the controller knows by the name of one variable for each table."""
    names: dict[SystemValue, str] = {}
    routines = tuple(
        replace(r, body=tuple([_move(s, names, work) for s in r.body])) for r in program.routines
    )
    if not names:
        return program
    data = [Declare(0, name, "real", shared=True) for name in names.values()]
    return replace(program, routines=routines, data=(*program.data, *data))


def _move(s: Statement, names: dict[SystemValue, str], work: TranslationContext) -> Statement:
    if type(s) is not Move or s.speed is None:
        return s
    held = s.speed.value.written
    if type(held) is not SystemValue:
        return s
    name = names.get(held)
    if name is None:
        name = names[held] = work.fresh(held.name.replace("-", "_"))
    says = f"{terminology.value(held.name)} is not in the program: {name} has to be set, in mm/s"
    work.lose(s, Fate.APPROXIMATED, "speed", says)
    work.ask("set these variables, which have no values", f"{name} [mm/s]")
    return edited(
        s, {"speed": s.speed._replace(value=s.speed.value._replace(written=Named(name)), native="")}
    )


# --- Tasks ---
# Parallel tasks by their numbers, where the target has no names for them.


def tasks(program: Program, work: TranslationContext) -> Program:
    """Every task that has a name by a number, in the order of their starts."""
    most, spelt = work.limits.tasks, work.limits.task_name
    if not most:
        return program
    own = re.compile(re.escape(spelt).replace(r"\{\}", r"\d+") + r"\Z")
    started = dict.fromkeys(s.task for s in program.statements() if isinstance(s, StartTask) and s.task)
    named = [name for name in started if not own.match(name)]
    if not named:
        return program
    taken = {name for name in started if own.match(name)}
    free = [name for n in range(1, most + 1) if (name := spelt.format(n)) not in taken]
    numbers = dict(zip(named, free, strict=False))
    work.names.update({("task", name): number for name, number in numbers.items()})

    def numbered(s: Statement) -> Statement:
        if not isinstance(s, (StartTask, WaitTask)) or s.task not in started or own.match(s.task):
            return s
        if s.task not in numbers:
            work.lose(s, Fate.REFUSED, "statement", f"more than {most} parallel tasks")
            return s
        return replace(s, task=numbers[s.task])

    routines = tuple(replace(r, body=tuple(map(numbered, r.body))) for r in program.routines)
    return replace(program, routines=routines)
