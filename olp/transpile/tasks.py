"""Parallel tasks by their numbers, where the target has no names for them."""

from __future__ import annotations

import re
from dataclasses import replace

from olp.ir.program import Program, StartTask, Statement, WaitTask
from olp.transpile.context import Fate, TranslationContext


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
