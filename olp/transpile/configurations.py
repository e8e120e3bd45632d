"""Arm configurations: kept where the target says them; where it does not, told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from olp.ir.expressions import Expression, Function, Named, PositionLiteral
from olp.ir.program import Move, Path, Program, Statement
from olp.ir.transformer import edited, mapped
from olp.robots.kinematics.readings import readings_of_joints, same_posture
from olp.runtime.plan import StepKind
from olp.transpile.context import Fate, TranslationContext

_SAME = 1e-6  # [rad] below this two ends are one


def configurations(program: Program, work: TranslationContext) -> Program:
    """Poses with the arm flags of the plan, or without any for languages that have none; URScript is told joint values.

    Each other joint move that led to a pose with flags is a loss.
    """
    if work.limits.has_configuration or not any(e.configuration for e in work.literals(program)):
        return program
    symbols = work.symbols(program)
    routines = []
    for routine in program.routines:
        rows: list[Statement] = []
        for s in routine.body:
            row = _row(s)
            if isinstance(s, Move) and s.path is Path.JOINT:
                literal = symbols.fixed_value(routine.name, s.targets[0])
                if isinstance(literal, PositionLiteral) and literal.configuration:
                    assert isinstance(row, Move)
                    row = _near(row, work)
            rows.append(row)
        routines.append(
            replace(routine, body=tuple(rows), data=tuple(mapped(d, _without) for d in routine.data))
        )
    data = tuple(mapped(d, _without) for d in program.data)
    return replace(program, data=data, routines=tuple(routines))


def _near(s: Move, work: TranslationContext) -> Move:
    """The move to the joint values near which the pose is reached, where each run of it ends in the same ones."""
    axes = _ends(s.line, work) if work.limits.near_joints else None
    if axes is None and not work.has_flags:
        return s
    if axes is None:
        says = "which way the arm stands is left to the controller: it takes the nearest"
        work.lose(s, Fate.APPROXIMATED, "configuration", says)
        return s
    near = PositionLiteral("joint", axes)
    return edited(s, {"targets": (Function("inverse", (s.targets[0], near)),)})


def _ends(line: int, work: TranslationContext) -> tuple[float, ...] | None:
    """[rad] Where the source's plan has the arm at the end of a line; None where that is not known."""
    robot, plan = work.robot, work.plan()
    if robot is None or plan is None or work.target_robot is None:
        return None
    steps = np.nonzero((plan.kind == StepKind.MOVE) & (plan.source == 0) & (plan.line == line))[0]
    rows = plan.positions.axes[plan.moves.target[plan.row[steps]]][:, : len(robot.axes)]
    if not len(rows) or np.isnan(rows).any() or np.ptp(rows, axis=0).max() > _SAME:
        return None
    if work.target_robot.name != robot.name:
        stands = same_posture(robot, work.target_robot, rows[:1])
        if stands is None:
            return None
        rows = stands
    return tuple(float(f"{value:.9g}") for value in readings_of_joints(work.target_robot, rows[:1])[0])


def _row(s: Statement) -> Statement:
    plain = type(s) is Move and type(s.targets[0]) is Named and (s.via is None or type(s.via) is Named)
    return s if plain else mapped(s, _without)


def _without(e: Expression) -> Expression:
    if type(e) is not PositionLiteral or not e.configuration:
        return e
    return PositionLiteral(e.kind, e.values, e.external, native=e.native)
