"""Arm configurations: kept where the target says them; where it does not, told."""

from __future__ import annotations

from dataclasses import replace

from olp.expression import Expression, Named, PositionLiteral
from olp.program import Move, Path, Program, Statement
from olp.translate.rewrite import mapped
from olp.translate.symbols import symbols_of
from olp.translate.work import Fate, Work


def configurations(program: Program, work: Work) -> Program:
    """Poses without arm flags for languages that have none, with a loss for each joint move that led to one."""
    if work.limits.has_configuration:
        return program
    symbols = symbols_of(program)
    for routine in program.routines:
        for s in routine.body:
            if isinstance(s, Move) and s.path is Path.JOINT:
                literal = symbols.fixed_value(routine.name, s.targets[0])
                if isinstance(literal, PositionLiteral) and literal.configuration:
                    says = "which way the arm stands is left to the controller: it takes the nearest"
                    work.lose(s, Fate.APPROXIMATED, "configuration", says)
    return replace(
        program,
        data=tuple(mapped(d, _without) for d in program.data),
        routines=tuple(
            replace(r, body=tuple([_row(s) for s in r.body]), data=tuple(mapped(d, _without) for d in r.data))
            for r in program.routines
        ),
    )


def _row(s: Statement) -> Statement:
    plain = type(s) is Move and type(s.targets[0]) is Named and (s.via is None or type(s.via) is Named)
    return s if plain else mapped(s, _without)


def _without(e: Expression) -> Expression:
    return replace(e, configuration=()) if isinstance(e, PositionLiteral) and e.configuration else e
