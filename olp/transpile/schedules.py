"""Speeds that a table of the controller holds (FANUC's WELD_SPEED): a variable that its operator sets."""

from __future__ import annotations

from dataclasses import replace

from olp.ir import terminology
from olp.ir.expressions import Named, SystemValue
from olp.ir.program import Declare, Move, Program, Statement
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
