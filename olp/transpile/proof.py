"""Both programs run: as olp.toml and the usual assumptions have it, and again with the inputs that they ask for on."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from olp.core.diagnostic import OlpError
from olp.ir.expressions import Number, Signal, Text
from olp.ir.program import Move, Program, Statement, Wait
from olp.ir.transformer import calls_nothing, expressions_of, sets_numbers
from olp.robots.robot import Robot
from olp.runtime.assumptions import (
    NAMED_SIGNAL,
    Assumptions,
    SignalKey,
    load_assumptions,
    nearest_assumptions,
)
from olp.runtime.interpreter import run
from olp.runtime.plan import Plan
from olp.transpile.convert import Converted, rerun
from olp.transpile.receipt import PlanRuns

_ON = (1,)
_MOST_AGAIN = 20_000  # statements of a run in which loops may have no end


def runs_of(
    source: Program, converted: Converted, vendor: str, robots: tuple[Robot | None, Robot | None]
) -> PlanRuns:
    """`robots`: of the source, and of the translation where it is another one."""
    asked = asked_inputs(source)
    sets = [asked] if asked else []
    first = [_run(source, robots[0], None, 2_000_000)]
    first += [_run(source, robots[0], inputs, _MOST_AGAIN) for inputs in sets]
    try:
        there = rerun(converted, vendor, robots[1] or robots[0], source, sets)
    except OlpError:
        return PlanRuns(tuple(first), (None,) * len(first))
    return PlanRuns(tuple(first), there.plans, there.origins)


def asked_inputs(program: Program) -> dict[SignalKey, tuple[int, ...]]:
    """The inputs that a program decides by, each on; what is only waited for comes anyway."""
    found: dict[SignalKey, tuple[int, ...]] = {}
    for s in program.statements():
        if not calls_nothing(s) and not sets_numbers(s) and not isinstance(s, Wait):
            found |= dict.fromkeys(_inputs(s), _ON)
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


def _run(
    program: Program, robot: Robot | None, inputs: Mapping[SignalKey, tuple[int, ...]] | None, most: int
) -> Plan | None:
    """The plan, None where the program cannot be run."""
    try:
        if inputs is None:
            return run(program, robot=robot, max_steps=most)
        folder = Path(program.path).parent if program.path and Path(program.path).is_file() else None
        path = nearest_assumptions(folder) if folder is not None else None
        given = load_assumptions(path) if path is not None else Assumptions()
        return run(program, robot=robot, assumptions=with_inputs(given, inputs), max_steps=most)
    except OlpError:
        return None


def with_inputs(given: Assumptions, inputs: Mapping[SignalKey, tuple[int, ...]]) -> Assumptions:
    """What olp.toml says of an input counts more."""
    from dataclasses import replace

    return replace(given, inputs={**inputs, **given.inputs})
