"""The plan of the source program, for passes that need it: as it runs, and with the inputs on that it asks for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Final

from olp.core.diagnostic import OlpError
from olp.ir.expressions import Number, Signal, Text
from olp.ir.program import Move, Program, Statement, Wait
from olp.ir.transformer import calls_nothing, expressions_of, sets_numbers
from olp.languages.limits import limits_of
from olp.robots.model import Robot
from olp.runtime.assumptions import (
    NAMED_SIGNAL,
    Assumptions,
    SignalKey,
    load_assumptions,
    nearest_assumptions,
)
from olp.runtime.interpreter import run
from olp.runtime.made_up import MadeUp
from olp.runtime.plan import Plan
from olp.transpile.context import Context, Planned, TranslationContext

MOST_AGAIN: Final = 20_000  # statements of a run with the inputs on, in which loops may have no end
_CIRCLES: Final = 40_000  # statements of a run after which a program in circles has come by all that it will


def work_for(
    program: Program, target: str, context: Context, planned: Planned | None = None
) -> TranslationContext:
    """`planned`: of the same program, where it was translated before. Raises OlpError (X010) for a language that cannot
    be written."""
    planned = planned or plans_of(program, context.robot)
    return TranslationContext(program, target, limits_of(target, context.forms), context, planned)


def plans_of(program: Program, robot: Robot | None) -> Planned:
    """What makes the plan of a program when it is first asked for."""

    @lru_cache(maxsize=2)  # without and with inputs
    def planned(with_inputs: bool) -> Plan | None:
        if not with_inputs:
            # A program that is passed once is run to its end.
            rows = sum(len(r.body) for r in program.routines)
            return plan_of(program, robot, None, min(200_000, max(_CIRCLES, 2 * rows)))
        inputs = asked_inputs(program)
        return plan_of(program, robot, inputs, MOST_AGAIN) if inputs else None

    return planned


def plan_of(
    program: Program,
    robot: Robot | None,
    inputs: Mapping[SignalKey, tuple[int, ...]] | None,
    most: int | None,
    made_up: MadeUp | None = None,
) -> Plan | None:
    """The plan of `most` statements (None: as usual), None where the program cannot be run.

    `inputs`: what olp.toml says counts more.
    """
    try:
        if inputs is None:
            return run(program, robot=robot, max_steps=most, made_up=made_up)
        folder = Path(program.path).parent if program.path and Path(program.path).is_file() else None
        path = nearest_assumptions(folder) if folder is not None else None
        given = load_assumptions(path) if path is not None else Assumptions()
        on = replace(given, inputs={**inputs, **given.inputs})
        return run(program, robot=robot, assumptions=on, max_steps=most, made_up=made_up)
    except OlpError:
        return None


def asked_inputs(program: Program) -> dict[SignalKey, tuple[int, ...]]:
    """The inputs that a program decides by, each on; what is only waited for comes anyway."""
    found: dict[SignalKey, tuple[int, ...]] = {}
    for s in program.statements():
        if not calls_nothing(s) and not sets_numbers(s) and not isinstance(s, Wait):
            found |= dict.fromkeys(_inputs(s), (1,))
    return found


def _inputs(s: Statement) -> set[SignalKey]:
    signals = [] if isinstance(s, Move) else [e for e in expressions_of(s) if isinstance(e, Signal)]
    found = set()
    for signal in signals:
        if signal.bus.rpartition("-")[2] != "in" or "analog" in signal.bus:
            continue
        if isinstance(signal.index, Text):
            found.add(SignalKey(NAMED_SIGNAL, signal.index.value.casefold()))
        elif isinstance(signal.index, Number):
            found.add(SignalKey(signal.bus, int(signal.index.value)))
    return found
