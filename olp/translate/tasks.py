"""Parallel tasks by the numbers that INFORM gives them."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Final

from olp.program import Program, StartTask, Statement, WaitTask
from olp.translate.work import Fate, Work

_MOST: Final = 15  # SUB1 to SUB15 of the larger controllers; smaller ones have five
_OWN: Final = re.compile(r"SUB\d+\Z")


def tasks(program: Program, work: Work) -> Program:
    """Every task that has a name as SUB1 and further, in the order of their starts."""
    if work.target != "inform":
        return program
    started = dict.fromkeys(s.task for s in program.statements() if isinstance(s, StartTask) and s.task)
    named = [name for name in started if not _OWN.match(name)]
    if not named:
        return program
    taken = {name for name in started if _OWN.match(name)}
    free = [f"SUB{n}" for n in range(1, _MOST + 1) if f"SUB{n}" not in taken]
    numbers = dict(zip(named, free, strict=False))
    work.names.update({("task", name): number for name, number in numbers.items()})

    def numbered(s: Statement) -> Statement:
        if not isinstance(s, (StartTask, WaitTask)) or s.task not in started or _OWN.match(s.task):
            return s
        if s.task not in numbers:
            work.lose(s, Fate.REFUSED, "statement", f"more than {_MOST} parallel tasks")
            return s
        return replace(s, task=numbers[s.task])

    routines = tuple(replace(r, body=tuple(map(numbered, r.body))) for r in program.routines)
    return replace(program, routines=routines)
